// The texts and charts beside the scene. Names come from files, so they are inserted as text, never as markup.
const $ = (id) => document.getElementById(id);
// element("p.hint", {title: "x"}, "text", child...)
function element(what, properties, ...children) {
  const [tag, ...classes] = what.split("."), e = document.createElement(tag);
  if (classes.length) e.className = classes.join(" ");
  for (const [name, value] of Object.entries(properties || {})) name in e ? (e[name] = value) : e.setAttribute(name, value);
  e.append(...children.filter((c) => c !== null && c !== undefined));
  return e;
}

const VERDICT_TEXT = {
  colliding: ["Colliding", "they certainly share a point"],
  within: ["May touch", "at most as far apart as the bound (within)"],
  undecided: ["Not decided", "a limit stopped the search (undecided)"],
  separate: ["Apart", "their boxes overlap, but they are apart (separate)"]};
const KIND_TEXT = {near: "apart, but closer than the clearance", touching: "surfaces touch and do not cross", crossing: "surfaces cross", enclosed: "one is inside the other"};
const STAGE_TEXT = {
  bounds: ["Boxes of the bodies", "bounds"], delimitation: ["Regions in which pairs can collide", "delimitation"],
  broad: ["Pairs whose boxes overlap", "broad phase"],
  refine: [header.refined === "boxes" ? "Pairs left over by OBB trees" : "Pairs left over by sphere-trees", header.refined === "boxes" ? "narrow phase, OBB trees" : "narrow phase, sphere-trees"],
  exact: ["Pairs decided on the surfaces", "exact"]};
const STAGE_COLOURS = ["#0072b2", "#56b4e9", "#009e73", "#e69f00", "#cc79a7"];
const ORDER = [2, 3, 1, 0]; // verdicts, worst first

function boundText(frame, p) {
  const bound = frame.bound[p], verdict = VERDICTS[frame.verdict[p]];
  if (verdict === "colliding") return KINDS[frame.kind[p]];
  return isFinite(bound) ? (verdict === "separate" ? "≥ " : "≤ ") + lengthText(bound) : "no bound";
}
const stageName = (frame, p) => header.stages[frame.stage[p]] || "";

// The legend is also the filter: a click leaves only one verdict.
function fillLegend(frame, only, choose) {
  const counts = frame.header.verdicts, list = $("legend");
  const rows = ORDER.filter((v) => v !== 0 || header.separate || counts[0]).filter((v) => v !== 3 || counts[3] || only === 3);
  list.replaceChildren(...rows.map((v) => {
    const name = VERDICTS[v], shown = v !== 0 || header.separate;
    return element("li", {}, element("button", {onclick: () => choose(only === v ? -1 : v), ariaPressed: String(only === v), disabled: !shown, title: VERDICT_TEXT[name][1] + (shown ? "" : "; listed with --separate")},
      element("span.swatch." + name), VERDICT_TEXT[name][0], element("b", {}, grouped(counts[v]))));
  }), element("li.hide-low", {}, element("button", {disabled: true}, element("span.swatch"), "No pair here")),
    ...(frame.header.left_out ? [element("li", {id: "left-out"}, element("button", {disabled: true, title: "The page has reached its size limit: these pairs have no marks and are not listed. Their bodies have the right colours."}, element("span"), "Pairs left out", element("b", {}, grouped(frame.header.left_out))))] : []));
}

function pairButton(frame, p, chosen, choose) {
  const verdict = VERDICTS[frame.verdict[p]];
  return element("li", {}, element("button", {onclick: () => choose(frame.a[p], frame.b[p]), ariaCurrent: String(p === chosen)},
    element("span.swatch." + verdict, {title: VERDICT_TEXT[verdict][0]}), element("span.names", {title: nameOf(frame.a[p]) + " and " + nameOf(frame.b[p])}, nameOf(frame.a[p]) + " · " + nameOf(frame.b[p])),
    element("span.bound", {}, boundText(frame, p))));
}

const MOST_LISTED = 200;
function fillPairs(frame, shown, chosen, search, choose, chooseBody) {
  const list = document.querySelector("#pairs ul"), rows = [];
  const wanted = search.toLowerCase(), has = (b) => nameOf(b).toLowerCase().includes(wanted);
  let found = 0;
  for (const v of ORDER)
    for (let p = 0; p < frame.pairs; ++p) {
      if (frame.verdict[p] !== v || !shown(p) || (wanted && !has(frame.a[p]) && !has(frame.b[p]))) continue;
      if (++found <= MOST_LISTED) rows.push(pairButton(frame, p, chosen, choose));
    }
  if (wanted)
    for (let b = 0, more = 0; b < bodies.count && more < 20; ++b)
      if (has(b)) ++more, rows.push(element("li", {}, element("button", {onclick: () => chooseBody(b)}, element("span.swatch." + RANKS[bodies.verdict[b]]), element("span.names", {}, nameOf(b)), element("span.bound", {}, "body"))));
  if (!rows.length) rows.push(element("li.note", {}, wanted ? "No match in this frame." : "No pair in this frame" + (header.separate ? "." : " except separate ones.")));
  if (found > MOST_LISTED) rows.push(element("li.note", {}, `and ${grouped(found - MOST_LISTED)} more`));
  if (frame.header.left_out) rows.push(element("li.note", {}, `${grouped(frame.header.left_out)} pairs of this frame are left out: the page has reached its size limit. Their bodies have the right colours.`));
  list.replaceChildren(...rows);
}

const fact = (name, value) => [element("dt", {}, name), element("dd", {}, value)];
function pairFacts(frame, p) {
  const verdict = VERDICTS[frame.verdict[p]], bound = frame.bound[p], facts = [], kind = KINDS[frame.kind[p]], out = [];
  out.push(element("p.verdict", {}, element("span.swatch." + verdict), VERDICT_TEXT[verdict][0], element("small", {}, VERDICT_TEXT[verdict][1])));
  if (kind) facts.push(...fact("How", KIND_TEXT[kind] + ` (${kind})`));
  const share = (x) => (100 * x).toPrecision(6).replace(/\.?0+$/, "") + " %", [clear, contact] = frame.times.subarray(2 * p, 2 * p + 2);
  if (contact === 0) facts.push(...fact("On the way to this frame", "in contact from the start"));
  if (contact > 0) facts.push(...fact("On the way to this frame", `free until ${share(clear)} of the way, in contact by ${share(contact)}; the mark is there`));
  if (verdict !== "colliding") facts.push(...fact(verdict === "separate" ? "At least apart (bound)" : "At most apart (bound)", isFinite(bound) ? lengthText(bound) : "no bound known"));
  if (verdict !== "colliding" && frame.apart[p] >= 0) {
    const near = frame.nearest[p], far = frame.apart[p];
    facts.push(...fact("Measured for this page", far === 0 ? "they meet" : lengthText(near) === lengthText(far) ? lengthText(far) : lengthText(near) + " to " + lengthText(far)));
  }
  facts.push(...fact("Requested accuracy (max_error)", lengthText(frame.error[p])));
  const stage = STAGE_TEXT[stageName(frame, p)];
  if (stage) facts.push(...fact("Decided by", stage[1]));
  out.push(element("dl.facts", {}, ...facts));
  // To scale: the requested accuracy, the certified bound, and the measured distance.
  const rows = [["Requested accuracy", frame.error[p] + header.clearance, "var(--line)"], ["Bound", verdict === "colliding" ? 0 : bound, `var(--${verdict})`]];
  if (verdict !== "colliding" && frame.apart[p] > 0) rows.push(["Measured", frame.apart[p], "var(--ink)"]);
  const longest = Math.max(...rows.map((r) => (isFinite(r[1]) ? r[1] : 0)));
  if (longest > 0 && verdict !== "colliding")
    out.push(element("div", {ariaLabel: "To scale"}, ...rows.filter((r) => isFinite(r[1])).map(([name, x, colour]) => {
      const bar = element("i"), box = element("div.bars", {}, bar);
      bar.style.cssText = `width:${Math.max(0.5, (100 * x) / longest)}%;background:${colour};${colour === "var(--line)" ? "box-shadow:inset 0 0 0 1.5px var(--soft)" : ""}`;
      return element("div.stage", {}, element("div.name", {}, element("span", {}, name), element("span", {}, lengthText(x))), box);
    })));
  return out;
}

function bodyLink(b, chooseBody) {
  return element("button.body-link", {onclick: () => chooseBody(b), title: "Select only this body"}, element("span.swatch." + RANKS[bodies.verdict[b]]), element("b", {}, nameOf(b)));
}

function bodyFacts(b) {
  const g = header.geometries[bodies.geometry[b]], p = bodies.position, size = g.low.map((x, k) => lengthText(g.high[k] - x)).join(" × ");
  const count = g.triangles ? grouped(g.triangles) + (g.kind === "map" ? " cells" : " triangles") : "";
  return element("dl.facts", {}, ...fact("Geometry", (g.name ? g.name + ", " : "") + g.kind), ...(count ? fact("Made of", count + (g.kind !== "map" && g.meshes[0][1] < g.triangles ? ` (shown: ${grouped(g.meshes[0][1])})` : "")) : []),
    ...fact("Size", size), ...fact("At", [0, 1, 2].map((k) => (header.origin[k] + p[3 * b + k]).toFixed(2)).join(", ")), ...fact("Moves", bodies.fixed[b] ? "never (fixed)" : "yes"));
}

function fillStages(frame) {
  const rows = frame.header.stages, most = Math.log10(1 + Math.max(10, ...rows.map((s) => Math.max(s[0], s[1])))), total = rows.reduce((t, s) => t + s[3], 0) || 1;
  const width = (n) => (100 * Math.log10(1 + n)) / most + "%";
  const times = element("div.times", {role: "img", ariaLabel: "Share of each stage in the time of the frame"}, ...rows.map((s, k) => {
    const part = element("i", {title: `${STAGE_TEXT[header.stages[k]][0]}: ${timeText(s[3])}`});
    part.style.cssText = `flex:${s[3] / total} 0 0;background:${STAGE_COLOURS[k]}`;
    return part;
  }));
  const parts = rows.map(([into, out, undecided, ms, note], k) => {
    const name = header.stages[k], [words, paper] = STAGE_TEXT[name], a = element("i.in"), b = element("i");
    a.style.cssText = `width:${width(into)};background:${STAGE_COLOURS[k]}`, b.style.cssText = `width:${width(out)};background:${STAGE_COLOURS[k]}`;
    return element("div.stage", {}, element("div.name", {}, element("b", {}, words), element("span", {}, timeText(ms))),
      element("div.bars", {}, a, b),
      element("small", {}, note !== null ? `${paper}: skipped, ${note}` : `${paper}: ${grouped(into)} in, ${grouped(out)} passed on` + (undecided ? `, ${grouped(undecided)} not decided` : "")));
  });
  const levels = frame.header.levels, table = levels.length ? [element("h2", {}, "Regions (delimitation), level by level"),
    element("table", {}, element("tr", {}, ...["level", "regions", "ruled out", "bodies ruled out", "volume"].map((t) => element("th", {}, t))),
      ...levels.map(([n, rejected, gone, volume], k) => element("tr", {}, ...[k, grouped(n), grouped(rejected), grouped(gone), (100 * volume).toFixed(0) + " %"].map((t) => element("td", {}, String(t))))))] : [];
  document.querySelector("#stages > div").replaceChildren(element("p.soft", {}, `${timeText(frame.header.ms)} in total; pale: input of a stage, full: output (logarithmic)`), times, ...parts, ...table);
}

function fillAbout() {
  document.querySelector("#about > div").replaceChildren(...header.notes.map((n) => element("p.warning", {}, n)),
    element("dl.facts", {}, ...fact("Bodies", grouped(header.bodies)), ...fact("Frames", header.frames.length === header.frames_run ? grouped(header.frames_run) : `${grouped(header.frames.length)} of ${grouped(header.frames_run)}`), ...header.about.flatMap(([a, b]) => fact(a, b))),
    element("p.hint", {}, "Written by oncollide run --view. Drawn with three.js. Lengths in metres unless a unit is given."));
}

// The strip behind the slider: each frame's pairs by verdict, and its time.
function drawChart(now) {
  const chart = $("chart"), ratio = Math.min(devicePixelRatio || 1, 2), width = chart.clientWidth, height = chart.clientHeight, n = header.frames.length;
  chart.width = width * ratio, chart.height = height * ratio;
  const c = chart.getContext("2d"), style = getComputedStyle(document.documentElement), colour = (name) => style.getPropertyValue("--" + name).trim();
  c.scale(ratio, ratio), (c.fillStyle = colour("band")), c.fillRect(0, 0, width, height);
  const most = Math.max(1, ...header.frames.map((f) => f.verdicts[1] + f.verdicts[2] + f.verdicts[3])), step = width / n, room = height - 6;
  header.frames.forEach((f, k) => {
    let y = height;
    for (const v of [2, 3, 1]) {
      const h = (f.verdicts[v] / most) * room;
      c.fillStyle = colour(VERDICTS[v]), c.fillRect(k * step, y - h, Math.max(step - (step > 4 ? 1 : 0), 0.75), h), (y -= h);
    }
  });
  const times = header.frames.map((f) => f.ms || 0), sorted = [...times].sort((a, b) => a - b), top = Math.max(sorted[Math.floor(0.95 * (n - 1))] * 1.3, 1e-6);
  c.strokeStyle = colour("ink"), c.globalAlpha = 0.45, c.lineWidth = 1, c.beginPath();
  times.forEach((t, k) => c.lineTo((k + 0.5) * step, height - 2 - Math.min(t / top, 1) * room));
  c.stroke(), (c.globalAlpha = 1);
  const x = (now + 0.5) * step;
  c.fillStyle = colour("accent"), c.fillRect(x - 1, 0, 2, height);
  c.beginPath(), c.arc(x, 5, 5, 0, 7), c.fill();
}
