"use strict";
const root = document.documentElement, find = id => document.getElementById(id);
const fault = error => { find("fault").hidden = false, find("fault").textContent = `The page has a fault: ${root.dataset.error = String(error?.message ?? error)}`; };
addEventListener("error", event => fault(event.error ?? event.message));
const fill = (made, more, kids) => {
  for (const [name, value] of Object.entries(more ?? {})) if (value !== undefined && value !== null) made.setAttribute(name, value);
  return made.append(...kids.flat(3).filter(kid => kid !== null && kid !== undefined)), made;
};
const make = (tag, more, ...kids) => fill(document.createElement(tag), more, kids);
const draw = (tag, more, ...kids) => fill(document.createElementNS("http://www.w3.org/2000/svg", tag), more, kids), number = n => Number(n ?? 0).toLocaleString("en");
const short = n => n < 1000 ? String(n) : n < 9950 ? `${(n / 1000).toFixed(1)}k` : n < 999500 ? `${Math.round(n / 1000)}k` : `${(n / 1e6).toFixed(1)}M`;
const percent = x => x === 0 ? "0 %" : x < 1e-4 ? "<0.01 %" : `${x < 0.00095 ? (100 * x).toFixed(2) : x < 0.0995 ? (100 * x).toPrecision(2) : (100 * x).toFixed(0)} %`;
const micro = ns => ns > 0 ? `${(us => us < 10 ? us.toPrecision(2) : Math.round(us).toLocaleString("en"))(ns / 1000)} µs` : "-";

// The data, and the names of its counts in the order of the panel.
const league = JSON.parse(find("league").textContent);
const faults = ["missed", "invented", "distance", "points", "normal", "depth", "support", "late", "early", "failed", "crashed", "hung"];
const names = {right: "right", missed: "missed collision", invented: "invented collision", distance: "wrong distance", points: "wrong points", support: "contacts on one side",
  normal: "wrong normal", depth: "wrong depth", late: "hit too late", early: "hit too early", failed: "library reports failure", crashed: "crashed",
  hung: "hung", unsupported: "unsupported", undecided: "rounding decides", extra: "extra hit, as announced"};
const kindOf = {right: "right", extra: "extra", missed: "missed", crashed: "broken", hung: "broken", unsupported: "none", undecided: "none"};
const libraries = new Map(league.libraries.map(library => [library.name, library])), families = new Map(league.families.map(family => [family.name, family]));
const key = (library, family) => `${encodeURIComponent(library)}/${encodeURIComponent(family)}`;
const results = new Map(league.results.map(result => [key(result.library, result.family), result]));
const badOf = result => faults.reduce((sum, name) => sum + (result[name] ?? 0), 0);
const judged = result => (result.cases ?? 0) - (result.unsupported ?? 0); // Every result of an undecided case is right.
const classOf = result => {
  if (!result || judged(result) <= 0 || result.crashed || result.hung) return result?.crashed || result?.hung ? "broken" : "none";
  if (result.missed) return "missed";
  const bad = badOf(result), share = bad / judged(result);
  if (!bad) return result.extra ? "extra" : "right";
  return share < 0.001 ? "wrong1" : share < 0.01 ? "wrong2" : share < 0.1 ? "wrong3" : "wrong4";
};
const sumOf = list => Object.fromEntries(["cases", ...Object.keys(names)].map(name => [name, list.reduce((sum, r) => sum + (r[name] ?? 0), 0)]));
const ofLibrary = (name, question) => league.results.filter(result => result.library === name && judged(result) > 0
  && (!question || families.get(result.family)?.question === question));
const verdicts = {right: "All results are right", extra: "Some hits are extra; the library says that it may report them", missed: "The library misses collisions",
  broken: "The library crashed or hung", none: "The library does not support this"};
const bare = ({name, group, question}) => [group, question].some(word => name.startsWith(`${word}: `)) ? name.slice(name.indexOf(": ") + 2) : name;
const verdict = kind => verdicts[kind] ?? "Some results are wrong";

function showTotals() {
  const sum = sumOf(league.results), asked = judged(sum);
  const tile = (name, value, kind, title) => make("div", {class: kind, title}, make("dt", null, name), make("dd", null, value));
  find("totals").append(tile("libraries", number(libraries.size)), tile("families of cases", number(families.size)),
    tile("results judged", number(asked - sum.failed - sum.crashed - sum.hung)),
    tile("wrong results", percent(asked ? (badOf(sum) - sum.crashed - sum.hung) / asked : 0), null, number(badOf(sum))),
    tile("missed collisions", number(sum.missed), sum.missed ? "missed" : null), tile("crashes and hangs", number(sum.crashed + sum.hung), sum.crashed + sum.hung ? "broken" : null));
  find("foot").textContent = `${league.program}; the league played on ${league.date}.`;
}
const cells = new Map();
function showMatrix() {
  const table = find("matrix"), all = [...libraries.values()], groups = new Map();
  for (const family of families.values()) groups.set(family.group, [...groups.get(family.group) ?? [], family]);
  table.tHead.append(make("tr", null, make("th", {scope: "col"}, "Family and question"), all.map(library =>
    make("th", {scope: "col", title: `${library.name}: ${library.settings}`}, make("span", null, library.name)))));
  for (const [group, members] of groups) {
    const body = make("tbody", null, make("tr", null, make("th", {scope: "rowgroup", colspan: all.length + 1}, make("span", null, group))));
    for (const family of members)
      body.append(make("tr", null, make("th", {scope: "row", title: family.what}, make("span", null, bare(family)), make("small", null, family.question)),
        all.map(library => make("td", null, cellOf(library, family)))));
    table.tFoot.before(body);
  }
  table.tFoot.append(make("tr", null, make("th", {scope: "row"}, "Wrong in all"), all.map(library => {
    const sum = sumOf(ofLibrary(library.name));
    return make("td", null, judged(sum) ? percent(badOf(sum) / judged(sum)) : "-");
  })));
  new ResizeObserver(() => find("frame").classList.toggle("fits", table.offsetWidth <= find("frame").clientWidth)).observe(find("frame"));
}
function cellOf(library, family) {
  const id = key(library.name, family.name), result = results.get(id), kind = classOf(result), bad = result ? badOf(result) : 0;
  const counts = result ? ["right", "extra", ...faults, "unsupported", "undecided"].filter(name => result[name]).map(name => `${names[name]}: ${number(result[name])}`) : [];
  const told = `${library.name}, ${family.name}: ${verdict(kind)}.`, button = make("button", {class: kind, type: "button", "aria-expanded": "false",
    "aria-label": [told, ...counts].join(" "),
    title: [told, ...counts, ...result?.ns > 0 ? [`${micro(result.ns)} a query`] : []].join("\n")}, kind === "none" ? "" : bad || result.extra ? short(bad || result.extra) : "✓");
  button.addEventListener("click", () => { location.hash === `#${id}` ? close() : location.hash = id; });
  return cells.set(id, button), button;
}

// The panel of a cell.
function showPanel(id) {
  const panel = find("panel"), result = results.get(id), cell = cells.get(id);
  for (const [name, other] of cells) other.setAttribute("aria-expanded", name === id);
  for (const old of document.querySelectorAll("#matrix .on")) old.classList.remove("on");
  stages.splice(0), find("app").classList.toggle("open", Boolean(cell)), panel.hidden = !cell;
  if (!cell) return;
  const [library, family] = id.split("/").map(decodeURIComponent).map((name, k) => (k ? families : libraries).get(name));
  const kind = classOf(result), worst = result?.worst ?? [], shut = make("button", {type: "button", "aria-label": "Close", title: "Close (Escape)"}, "✕");
  cell.closest("tr").classList.add("on"), find("matrix").tHead.rows[0].cells[cell.parentElement.cellIndex].classList.add("on");
  shut.addEventListener("click", close);
  const facts = list => make("dl", {class: "facts"}, list.map(([name, value, more]) => [make("dt", null, name), make("dd", {class: more}, value)]));
  panel.replaceChildren(make("header", null, make("h2", {id: "panel-title"}, `${library.name}: ${family.name}`, make("small", null, library.settings)), shut),
    make("p", null, family.what), make("p", {class: `verdict ${kind}`}, `${verdict(kind)}.`),
    facts([["Question", family.question], ["Group", family.group], ["Time", result?.ns > 0 ? `${micro(result.ns)} a query` : "-"],
      ["Cases", number(result?.cases)], ["Numbers", `${library.bits} bits`]]));
  if (result) panel.append(make("dl", {class: "counts"}, Object.keys(names).filter(name => name === "right" || result[name]).map(name => {
    const n = result[name] ?? 0, bar = make("i", {class: kindOf[name]});
    bar.style.width = `${100 * n / Math.max(result.cases, 1)}%`;
    return [make("dt", null, names[name]), make("dd", {class: "n"}, number(n)), make("dd", {class: "bar"}, n ? bar : null)];
  })), make("p", {class: "zeros"}, `0 each: ${Object.keys(names).filter(name => name !== "right" && !result[name]).map(name => names[name]).join(", ")}.`));
  if (worst.length) panel.append(make("h3", null, worst.length > 1 ? `The ${worst.length} worst cases` : "The worst case"));
  for (const one of worst) {
    const card = panel.appendChild(make("article", {class: "card"}));
    if (one.case) stages.push(new Stage(card, one.case));
    card.append(facts([["Seed", String(one.seed)], ["Fault", names[one.fault] ?? one.fault, "bad"], ["Expected", one.expected ?? "-"], ["Given", one.given ?? "-"],
      ...one.error ? [["Error", Number(one.error).toPrecision(3)]] : []]), commandOf(library, family, one.seed));
  }
  if (result?.wrong_seeds?.length > worst.length) panel.append(make("h3", null, "Seeds of wrong results"), make("p", null, `${result.wrong_seeds.join(", ")}${result.wrong_seeds.length < 100 ? "" : ", ..."}`));
  for (const stage of stages) stage.resize();
  panel.scrollTop = 0, cell.scrollIntoView({block: "nearest", inline: "nearest"});
  if (innerWidth < 1000) shut.focus();
}
function commandOf(library, family, seed) {
  const words = ["oncollide-lab league", ...(library.adapter ? [`--adapter '${library.adapter.replaceAll("'", "'\\''")}'`] : []), `--library ${library.name}`, `--family '${family.name.replaceAll("'", "'\\''")}'`, `--seed ${seed}`, "--write case.obj"];
  const code = make("code", null, words.map((word, k) => [k ? " " : null, make("span", null, word)])), copy = make("button", {type: "button"}, "Copy");
  copy.addEventListener("click", async () => {
    try { await navigator.clipboard.writeText(code.textContent), copy.textContent = "Copied"; }
    catch { getSelection().selectAllChildren(code), copy.textContent = "Selected"; }
    setTimeout(() => { copy.textContent = "Copy"; }, 1500);
  });
  return make("div", {class: "command"}, code, copy);
}
function close() {
  const cell = cells.get(location.hash.slice(1));
  history.replaceState(null, "", location.pathname + location.search), showPanel(""), cell?.focus({preventScroll: true});
}

// The chart: a dot for each library.
function showChart() {
  find("question").append(make("option", {value: ""}, "all"), ...[...new Set(league.families.map(family => family.question))].map(kind => make("option", {value: kind}, kind)));
  find("question").addEventListener("change", drawChart), new ResizeObserver(drawChart).observe(find("chart")), drawChart();
}
function drawChart() {
  const dots = [];
  for (const library of libraries.values()) {
    const list = ofLibrary(library.name, find("question").value), timed = list.filter(result => result.ns > 0);
    if (!timed.length) continue;
    const share = list.reduce((sum, result) => sum + badOf(result) / judged(result), 0) / list.length;
    dots.push({library, list, share, us: Math.exp(timed.reduce((sum, result) => sum + Math.log(result.ns / 1000), 0) / timed.length), kind: classOf(sumOf(list))});
  }
  const wide = Math.max(find("chart").clientWidth, 280), high = wide < 560 ? 340 : 400, left = 58, right = wide - 18, top = 12, base = high - 46, zero = base - 34;
  const wrong = dots.filter(dot => dot.share > 0).map(dot => Math.log10(dot.share)), times = dots.map(dot => Math.log10(dot.us));
  const x0 = Math.min(...times, 9) - 0.25, x1 = Math.max(...times, -9) + 0.35, y0 = Math.floor(Math.min(...wrong, -2)), y1 = 0;
  const x = us => left + 14 + (Math.log10(us) - x0) / (x1 - x0) * (right - left - 28);
  const y = share => share > 0 ? zero - 14 - (Math.log10(share) - y0) / (y1 - y0) * (zero - 14 - top) : (zero + base) / 2;
  const picture = draw("svg", {viewBox: `0 0 ${wide} ${high}`, height: high, role: "img", "aria-label": "Time a query and share of wrong results of each library"});
  const text = (words, more) => draw("text", more, words), line = (xa, ya, xb, yb, kind) => draw("line", {x1: xa, y1: ya, x2: xb, y2: yb, class: kind});
  picture.append(draw("rect", {x: left, y: zero, width: right - left, height: base - zero, class: "zero", rx: 4}));
  for (let e = y0; e <= y1; ++e)
    picture.append(line(left, y(10 ** e), right, y(10 ** e), "grid"), text(`${+(100 * 10 ** e).toPrecision(1)} %`, {x: left - 8, y: y(10 ** e) + 4, "text-anchor": "end"}));
  for (let e = Math.floor(x0); e <= x1; ++e) for (const us of [1, 2, 5].map(k => +(k * 10 ** e).toPrecision(1))) if (Math.log10(us) >= x0 && Math.log10(us) <= x1)
    picture.append(line(x(us), top, x(us), base, "grid"), text(`${number(us)} µs`, {x: x(us), y: base + 18, "text-anchor": "middle"}));
  picture.append(text("0", {x: left - 8, y: (zero + base) / 2 + 4, "text-anchor": "end", class: "zero-text"}), line(left, base, right, base, "axis"),
    text(`time a query${wide < 560 ? "" : " (log scale)"} →`, {x: right, y: high - 8, "text-anchor": "end"}),
    text(`↑ share of wrong answers${wide < 560 ? "" : " (log scale, 0 at the bottom)"}`, {x: left, y: high - 8}));
  const taken = dots.map(dot => [x(dot.us) - 8, y(dot.share) - 8, x(dot.us) + 8, y(dot.share) + 8]);
  const meets = (p, q) => p[0] < q[2] && q[0] < p[2] && p[1] < q[3] && q[1] < p[3];
  for (const dot of dots.sort((p, q) => p.us - q.us)) {
    const cx = x(dot.us), cy = y(dot.share), long = dot.library.name.length * (wide < 560 ? 8.1 : 8.6) + 4, spots = [[11, 0], [-11 - long, 0]];
    for (const up of [-17, 17, -32, 32, -47, 47, -62, 62, -77, 77, -92, 92]) spots.push([-long / 2, up], [6, up], [-6 - long, up]);
    const box = ([dx, dy]) => [cx + dx, cy + dy - 8, cx + dx + long, cy + dy + 8];
    const inside = spots.filter(place => (b => b[0] > left && b[2] < right + 10 && b[1] > 0 && b[3] < base + 2)(box(place)));
    const spot = inside.find(place => !taken.some(other => meets(box(place), other))) ?? inside[0] ?? spots[0];
    taken.push(box(spot));
    if (Math.abs(spot[1]) > 18) picture.append(line(cx, cy, cx + spot[0] + long / 2, cy + spot[1] - 6 * Math.sign(spot[1]), "leader"));
    const told = `${dot.library.name}: ${micro(1000 * dot.us)} a query, ${percent(dot.share)} wrong, ${dot.list.length} families`;
    picture.append(draw("circle", {cx, cy, r: 7, class: dot.kind}, draw("title", null, told)), text(dot.library.name, {x: cx + spot[0] + 2, y: cy + spot[1] + 4, class: "label"}));
  }
  find("chart").replaceChildren(dots.length ? picture : make("p", {class: "soft"}, "No library results this question."));
}

function showLibraries() {
  const table = find("libraries"), heads = [...table.tHead.rows[0].cells].map(cell => cell.textContent);
  for (const library of libraries.values()) {
    const list = ofLibrary(library.name), sum = sumOf(list), right = judged(sum) ? sum.right / judged(sum) : null;
    const digits = right === null ? "-" : right === 1 ? "100 %" : `${Math.min(99.999, 100 * right).toFixed(right > 0.999 ? 3 : 1)} %`;
    const values = [`${library.bits} bits`, (library.precision || 1e-6).toExponential(), `${list.length} of ${families.size}`, digits,
      number(sum.missed), number(sum.crashed + sum.hung)];
    table.tBodies[0].append(make("tr", null, make("th", {scope: "row"}, library.name),
      make("td", null, library.settings, library.conservative ? "; it may report extra hits" : "", make("br"), make("code", null, library.source)),
      values.map((value, k) => make("td", {class: "n", "data-name": heads[k + 2]}, value))));
  }
}

// Bodies as polygons in the world. Vectors are arrays of three numbers.
const add = (p, q, s = 1) => [p[0] + s * q[0], p[1] + s * q[1], p[2] + s * q[2]], dot = (p, q) => p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
const cross = (p, q) => [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]];
const unit = p => (length => length > 0 ? p.map(x => x / length) : [0, 0, 1])(Math.hypot(...p)), middle = (p, q) => p.map((x, k) => (x + q[k]) / 2);
// A point that turns about another by a share of a rotation vector.
const turned = (p, about, turn, share) => {
  const angle = Math.hypot(...turn), axis = unit(turn), arm = add(p, about, -1), along = dot(axis, arm) * (1 - Math.cos(share * angle));
  if (!(angle > 0)) return p;
  return [0, 1, 2].map(k => about[k] + Math.cos(share * angle) * arm[k] + Math.sin(share * angle) * cross(axis, arm)[k] + along * axis[k]);
};
const normalOf = face => unit(cross(add(face[1], face[0], -1), add(face[2], face[0], -1)));
const kindName = kind => String(kind ?? "").toLowerCase().replace(/[^a-z]/g, "");
const boundsOf = points => [0, 1, 2].reduce((box, k) => { for (const p of points) box[0][k] = Math.min(box[0][k], p[k]), box[1][k] = Math.max(box[1][k], p[k]); return box; },
  [[1 / 0, 1 / 0, 1 / 0], [-1 / 0, -1 / 0, -1 / 0]]);

/// A surface of revolution about z: a profile of [radius, height] from below; flat ends become polygons with many corners.
function lathe(profile, n = 28) {
  const ring = ([r, z]) => Array.from({length: n}, (_, k) => [r * Math.cos(2 * Math.PI * k / n), r * Math.sin(2 * Math.PI * k / n), z]), faces = [];
  for (let i = 1; i < profile.length; ++i) {
    const [low, high] = [profile[i - 1], profile[i]], p = ring(low), q = ring(high), flat = low[1] === high[1];
    if (flat) faces.push({points: low[0] === 0 ? q.reverse() : p, sharp: true});
    else for (let k = 0; k < n; ++k) {
      const l = (k + 1) % n, points = low[0] === 0 ? [p[k], q[l], q[k]] : high[0] === 0 ? [p[k], p[l], q[k]] : [p[k], p[l], q[l], q[k]];
      faces.push({points, sharp: false});
    }
  }
  return faces;
}
const arc = (r, from, to, shift, n) => Array.from({length: n + 1}, (_, k) => {
  const t = from + (to - from) * k / n, pole = k === 0 && from < -1.5 || k === n && to > 1.5;
  return [pole ? 0 : r * Math.cos(t), r * Math.sin(t) + shift];
});
const boxFaces = ([x, y, z], c = [0, 0, 0], skip = () => false) => [0, 1, 2].flatMap(k => [-1, 1].flatMap(s => {
  const h = [x, y, z], u = [0, 0, 0], v = [0, 0, 0], w = [0, 0, 0], i = (k + 1) % 3, j = (k + 2) % 3;
  u[i] = h[i], v[j] = h[j], w[k] = s * h[k];
  const points = [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([a, b]) => add(add(add(c, w), u, a), v, b));
  return skip(k, s) ? [] : [{points: s > 0 ? points : points.reverse(), sharp: true}];
}));

/// The hull's faces: each plane through three points with none beyond it. It takes the extreme points in some directions, if there are many.
function hullFaces(points) {
  if (points.length > 56) points = [...new Set(Array.from({length: 90}, (_, k) => {
    const z = 1 - (2 * k + 1) / 90, t = 2.399963 * k, r = Math.sqrt(1 - z * z), way = [r * Math.cos(t), r * Math.sin(t), z];
    return points.reduce((best, p) => dot(p, way) > dot(best, way) ? p : best);
  }))].slice(0, 56);
  const [low, high] = boundsOf(points), size = Math.hypot(...add(high, low, -1)) || 1, faces = [], seen = new Set(), n = points.length;
  for (let i = 0; i < n; ++i) for (let j = i + 1; j < n; ++j) for (let k = j + 1; k < n; ++k) {
    const c = cross(add(points[j], points[i], -1), add(points[k], points[i], -1)), area = Math.hypot(...c), on = [];
    if (area < 1e-12 * size * size) continue;
    let way = c.map(x => x / area), above = 0, below = 0;
    for (let m = 0; m < n && !(above && below); ++m) {
      const d = dot(add(points[m], points[i], -1), way);
      if (d > 1e-9 * size) ++above; else if (d < -1e-9 * size) ++below; else on.push(m);
    }
    if (above && below || seen.has(on.join())) continue;
    seen.add(on.join()), way = way.map(x => above ? -x : x);
    const centre = on.reduce((sum, m) => add(sum, points[m], 1 / on.length), [0, 0, 0]), u = unit(add(points[on[0]], centre, -1)), v = cross(way, u);
    const turn = m => (d => Math.atan2(dot(d, v), dot(d, u)))(add(points[m], centre, -1));
    faces.push({points: on.sort((a, b) => turn(a) - turn(b)).map(m => points[m]), sharp: true});
  }
  return faces;
}
function bodyFaces(body) {
  const size = body.size ?? [0, 0, 0], [r, h] = size, vertices = (body.vertices ?? []).filter(p => p.every(Number.isFinite)), half = Math.PI / 2;
  const triangles = () => (body.triangles ?? []).map(t => ({points: t.map(k => body.vertices[k]), sharp: true})).filter(f => f.points.every(p => p?.every(Number.isFinite)));
  const make = {
    mesh: triangles, terrain: triangles, hull: () => body.triangles?.length ? triangles() : hullFaces(vertices), box: () => boxFaces(size),
    sphere: () => lathe(arc(r, -half, half, 0, 16)), capsule: () => lathe([...arc(r, -half, 0, -h, 8), ...arc(r, 0, half, h, 8)]),
    cylinder: () => lathe([[0, -h], [r, -h], [r, h], [0, h]]), cone: () => lathe([[0, -h], [r, -h], [0, h]]),
    ellipsoid: () => lathe(arc(1, -half, half, 0, 16)).map(f => ({...f, points: f.points.map(p => p.map((x, k) => x * size[k]))})),
    cells: () => {
      const name = p => p.map((x, i) => Math.round((x - vertices[0][i]) / r)).join(), full = new Set(vertices.map(name));
      return vertices.slice(0, 4000).flatMap(p => boxFaces([r / 2, r / 2, r / 2], p, (k, s) => full.has(name(p.map((x, i) => i === k ? x + s * r : x)))));
    }
  }[kindName(body.kind)];
  const m = body.rotation ?? [1, 0, 0, 0, 1, 0, 0, 0, 1], at = body.position ?? [0, 0, 0];
  const place = p => [0, 1, 2].map(k => m[3 * k] * p[0] + m[3 * k + 1] * p[1] + m[3 * k + 2] * p[2] + at[k]);
  const closed = !["mesh", "terrain", "halfspace"].includes(kindName(body.kind)) || body.solid === 1;
  return {faces: (make?.() ?? []).map(face => ({...face, points: face.points.map(place)})), points: vertices.map(place), place, closed, body};
}

// The picture of a case: orthographic, far triangles first. Large triangles are cut, so that bodies that cross look right.
const stages = [];
class Stage {
  constructor(card, asked) {
    this.turn = 0.7, this.rise = 0.42, this.zoom = 1;
    this.canvas = make("canvas", {tabindex: 0, role: "img", "aria-label": "The bodies of the case. Drag or use the arrow keys to turn them, plus and minus to zoom."});
    const button = (sign, name, act) => (made => (made.addEventListener("click", act), made))(make("button", {type: "button", title: name, "aria-label": name}, sign));
    this.clear = button("See through", "See through the faces", () => this.setThrough(!this.through));
    this.read(asked), card.append(make("div", {class: "stage"}, this.canvas, make("div", {class: "tools"}, this.clear, button("−", "Zoom out", () => this.setZoom(0.6)),
      button("+", "Zoom in to the place between the bodies", () => this.setZoom(1 / 0.6))), this.keyList()));
    this.listen(), this.setThrough(this.bodies.every(part => part.faces.length < 5));
  }
  read(asked) {
    const question = kindName(asked.question), has = body => body && (kindName(body.kind) !== "mesh" || body.vertices?.length);
    const list = asked.bodies?.length ? asked.bodies : question === "ray" ? [asked.a] : [asked.a, asked.b];
    const many = asked.bodies?.length, color = k => k && !many ? "--body-b" : "--body-a";
    this.bodies = list.filter(has).slice(0, 400).map((body, k) => Object.assign(bodyFaces(body), {name: many ? `${number(many)} bodies` : "ab"[k], color: color(k), many}));
    const cloud = part => part.faces.length ? part.faces.flatMap(face => face.points) : part.points;
    this.arrow = question === "ray" && asked.from ? [asked.from, add(asked.from, asked.motion)] : null;
    if (["cast", "turn"].includes(question) && this.bodies[1] && asked.motion) {
      const [low, high] = boundsOf(cloud(this.bodies[1]).length ? cloud(this.bodies[1]) : [this.bodies[1].body.position]), start = middle(low, high);
      this.arrow = dot(asked.motion, asked.motion) ? [start, add(start, asked.motion)] : null;
      for (const time of asked.turn ? [0.25, 0.5, 0.75, 1] : [1]) {
        const place = p => add(asked.turn ? turned(p, this.bodies[1].body.position, asked.turn, time) : p, asked.motion, time);
        this.bodies.push({...this.bodies[1], faces: this.bodies[1].faces.map(face => ({...face, points: face.points.map(place)})), points: [], ghost: true});
      }
    }
    const boxes = this.bodies.filter(part => cloud(part).length).map(part => boundsOf(cloud(part)));
    if (this.arrow || !boxes.length) boxes.push(this.arrow ? boundsOf(this.arrow) : [[-1, -1, -1], [1, 1, 1]]);
    const [low, high] = boundsOf(boxes.flat());
    this.centre = middle(low, high), this.radius = Math.hypot(...add(high, low, -1)) / 2 || 1;
    for (const part of this.bodies) if (kindName(part.body.kind) === "halfspace") this.fillHalfSpace(part, boxes);
    const near = boxes.slice(0, asked.bodies?.length ? 0 : 2), inner = k => [Math.max(...near.map(box => box[0][k])), Math.min(...near.map(box => box[1][k]))];
    this.focus = near.length < 2 ? this.centre : [0, 1, 2].map(k => (inner(k)[0] + inner(k)[1]) / 2);
  }
  fillHalfSpace(part, boxes) {
    const up = add(part.place([0, 0, 1]), part.place([0, 0, 0]), -1), away = dot(add(this.centre, part.place([0, 0, 0]), -1), up), foot = add(this.centre, up, -away);
    const [u, v] = [[1, 0, 0], [0, 1, 0]].map(p => add(part.place(p), part.place([0, 0, 0]), -1)), r = 0.8 * this.radius;
    const square = [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([a, b]) => add(add(foot, u, a * r), v, b * r));
    part.faces = [{points: square, sharp: true}], boxes.push(boundsOf([foot]));
    this.centre = middle(this.centre, foot), this.radius = 1.35 * this.radius + Math.abs(away) / 2;
  }
  keyList() {
    const about = part => part.body.triangles?.length ? `, ${number(part.body.triangles.length)} triangle${part.body.triangles.length > 1 ? "s" : ""}`
      : part.body.vertices?.length ? `, ${number(part.body.vertices.length)} points` : "";
    const row = (color, text) => (mark => (mark.style.background = `var(${color})`, make("li", null, mark, text)))(make("i"));
    const text = part => part.many ? part.name : `${part.name}: ${String(part.body.kind).replace(/[_-]/g, " ")}${about(part)}`;
    const list = this.bodies.filter(part => !part.ghost).slice(0, this.bodies[0]?.many ? 1 : 2).map(part => row(part.color, text(part)));
    if (this.arrow) list.push(row("--motion", this.bodies.some(part => part.ghost) ? "the motion of b" : "the ray"));
    return make("ul", {class: "key"}, list);
  }
  setThrough(on) { this.through = on, this.clear.setAttribute("aria-pressed", on), this.draw(); }
  setZoom(by) { this.zoom = Math.min(Math.max(this.zoom * by, 0.5), 1e7), this.cut = null, this.draw(); }
  rotate(dx, dy) { this.turn -= dx, this.rise = Math.min(Math.max(this.rise + dy, -1.57), 1.57), this.draw(); }
  listen() {
    let canvas = this.canvas, last = null;
    canvas.addEventListener("pointerdown", event => { last = [event.clientX, event.clientY], canvas.setPointerCapture(event.pointerId); });
    canvas.addEventListener("pointermove", ({clientX, clientY}) => { if (last) this.rotate((clientX - last[0]) / 130, (clientY - last[1]) / 130), last = [clientX, clientY]; });
    for (const name of ["pointerup", "pointercancel"]) canvas.addEventListener(name, () => { last = null; });
    canvas.addEventListener("wheel", event => {
      if (event.ctrlKey || document.activeElement === canvas) event.preventDefault(), this.setZoom(Math.exp(-event.deltaY / 400));
    }, {passive: false});
    canvas.addEventListener("keydown", event => {
      const act = {ArrowLeft: () => this.rotate(0.1, 0), ArrowRight: () => this.rotate(-0.1, 0), ArrowUp: () => this.rotate(0, 0.1), ArrowDown: () => this.rotate(0, -0.1),
        "+": () => this.setZoom(1.3), "=": () => this.setZoom(1.3), "-": () => this.setZoom(1 / 1.3)}[event.key];
      if (act) act(), event.preventDefault();
    });
  }
  resize() {
    const ratio = Math.min(devicePixelRatio || 1, 2), {clientWidth, clientHeight} = this.canvas;
    this.canvas.width = clientWidth * ratio, this.canvas.height = clientHeight * ratio, this.ratio = ratio, this.draw();
  }
  /// Triangles about the point `at`, with the normal of their face and a flag for each edge that belongs to the body.
  pieces(at) {
    const list = [], few = this.bodies.reduce((sum, part) => sum + part.faces.length, 0) < 4000, most = this.radius / this.zoom / 7, reach = 1.3 * this.radius / this.zoom;
    for (const part of this.bodies) for (const face of part.faces) {
      if (part.ghost) continue;
      const normal = normalOf(face.points), points = face.points.map(p => add(p, at, -1)), n = points.length;
      const stack = Array.from({length: n - 2}, (_, k) => ({p: [points[0], points[k + 1], points[k + 2]], e: [k === 0, true, k === n - 3]}));
      while (stack.length) {
        const {p, e} = stack.pop(), sides = p.map((q, k) => Math.hypot(...add(p[(k + 1) % 3], q, -1))), k = sides.indexOf(Math.max(...sides));
        const far = Math.hypot(...p.reduce((sum, q) => add(sum, q, 1 / 3), [0, 0, 0])) - sides[k] > reach;
        if (!few || sides[k] < most || far || list.length > 24000) { list.push({p, e, normal, part, face}); continue; }
        const [a, b, c] = [p[k], p[(k + 1) % 3], p[(k + 2) % 3]], m = middle(a, b);
        stack.push({p: [a, m, c], e: [e[k], false, e[(k + 2) % 3]]}, {p: [m, b, c], e: [e[k], e[(k + 1) % 3], false]});
      }
    }
    return list;
  }
  draw() {
    const {canvas, ratio, zoom, turn, rise} = this, w = canvas.width, h = canvas.height, pen = canvas.getContext("2d"), style = getComputedStyle(root);
    if (!ratio || !w) return;
    const share = 1 - 1 / Math.max(zoom, 1), at = this.centre.map((x, k) => x + share * (this.focus[k] - x)), scale = 0.46 * Math.min(w, 1.25 * h) / this.radius * zoom;
    const right = [-Math.sin(turn), Math.cos(turn), 0], view = [Math.cos(turn) * Math.cos(rise), Math.sin(turn) * Math.cos(rise), Math.sin(rise)], up = cross(view, right);
    const flat = p => [w / 2 + scale * dot(p, right), h / 2 - scale * dot(p, up)], light = unit(add(add(view, up, 0.7), right, -0.5));
    const hue = name => style.getPropertyValue(name).trim(), rgb = name => hue(name).match(/[0-9a-f]{2}/gi).map(x => parseInt(x, 16)), edge = rgb("--edge").join();
    const tone = (name, by) => rgb(name).map(x => Math.round(by < 1 ? x * by : x + (255 - x) * (by - 1))).join();
    const path = points => { pen.beginPath(); points.forEach((p, k) => pen[k ? "lineTo" : "moveTo"](...flat(p))); };
    const whole = part => part.faces.map(face => ({p: face.points.map(p => add(p, at, -1)), e: face.points.map(() => true), normal: normalOf(face.points), part, face}));
    pen.clearRect(0, 0, w, h), pen.lineJoin = pen.lineCap = "round";
    const items = this.through ? this.bodies.filter(part => !part.ghost).flatMap(whole)
      : (this.cut ??= this.pieces(at)).filter(item => !item.part.closed || dot(item.normal, view) > 0);
    for (const item of items) item.depth = item.p.reduce((sum, p) => sum + dot(p, view), 0) / item.p.length;
    const on = s => add(add(this.arrow[0], add(this.arrow[1], this.arrow[0], -1), s / 60), at, -1);
    if (this.arrow) for (let k = 0; k < 60; ++k) items.push({line: [on(k), on(k + 1)], depth: dot(on(k + 0.5), view)});
    for (const item of items.sort((p, q) => p.depth - q.depth)) {
      if (item.line) { pen.strokeStyle = hue("--motion"), pen.lineWidth = 2.4 * ratio, path(item.line), pen.stroke(); continue; }
      const facing = dot(item.normal, light), lit = 0.62 + 0.5 * (item.part.closed ? Math.max(facing, 0) : Math.abs(facing));
      pen.fillStyle = `rgba(${tone(item.part.color, lit)},${this.through ? 0.2 : 1})`, path(item.p), pen.closePath(), pen.fill();
      if (!this.through) pen.strokeStyle = pen.fillStyle, pen.lineWidth = 0.8 * ratio, pen.stroke();
      pen.strokeStyle = `rgba(${this.through ? tone(item.part.color, 0.8) : edge},${item.face.sharp ? 0.9 : this.through ? 0.25 : 0.1})`;
      pen.lineWidth = (item.part.faces.length > 300 ? 0.6 : 1.3) * ratio;
      item.p.forEach((p, k) => { if (item.e[k]) path([p, item.p[(k + 1) % item.p.length]]), pen.stroke(); });
    }
    this.overlay({pen, at, flat, path, hue, whole, tone, ratio});
  }
  /// Draws over the bodies: bodies without faces, the end of a motion, and the arrow where bodies hide it.
  overlay({pen, at, flat, path, hue, whole, tone, ratio}) {
    const disc = (p, r) => { pen.beginPath(), pen.arc(...p, r * ratio, 0, 7), pen.fill(); };
    const dash = (color, width) => { pen.setLineDash([5 * ratio, 4 * ratio]), pen.strokeStyle = color, pen.lineWidth = width * ratio; };
    for (const part of this.bodies) {
      pen.fillStyle = hue(part.color);
      if (!part.faces.length) for (const p of part.points) disc(flat(add(p, at, -1)), 3);
      if (part.ghost) for (const item of whole(part)) dash(`rgba(${tone(part.color, 0.9)},${item.face.sharp ? 0.6 : 0.22})`, 1), path(item.p), pen.closePath(), pen.stroke();
    }
    if (this.arrow) {
      const [p, q] = this.arrow.map(x => add(x, at, -1)), [a, b] = [flat(p), flat(q)], along = Math.atan2(b[1] - a[1], b[0] - a[0]), long = 13 * ratio;
      pen.fillStyle = hue("--motion"), pen.globalAlpha = 0.5, dash(pen.fillStyle, 1.4), path([p, q]), pen.stroke(), pen.globalAlpha = 1;
      pen.beginPath(), pen.moveTo(...b);
      for (const side of [-0.4, 0.4]) pen.lineTo(b[0] - long * Math.cos(along + side), b[1] - long * Math.sin(along + side));
      pen.fill(), disc(a, 3);
    }
    pen.setLineDash([]);
  }
}

try {
  showTotals(), showMatrix(), showChart(), showLibraries(), showPanel(location.hash.slice(1));
  addEventListener("hashchange", () => showPanel(location.hash.slice(1)));
  addEventListener("keydown", event => { if (event.key === "Escape" && !find("panel").hidden) close(); });
  addEventListener("resize", () => { for (const stage of stages) stage.resize(); });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { for (const stage of stages) stage.draw(); });
} catch (error) { fault(error); }
root.dataset.ready = "yes";
