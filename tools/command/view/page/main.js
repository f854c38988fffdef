// The page's behaviour: frames, selection, keys, touch, and redrawing.
const last = header.frames.length - 1, root = document.documentElement;
const state = {frame: 0, playing: false, speed: 1, only: -1, pair: null, body: -1, isolate: false, links: true, curves: true, bounds: false,
               labels: false, regions: false, regionLevel: -1, colours: "verdict", tree: "none", level: 3, theme: "", search: "", at: null};
const mediaDark = matchMedia("(prefers-color-scheme: dark)");
let frame = null, chosenPair = -1, treeFacts = null;
let dirty = true, pairsDirty = true, panelDirty = true; // to renew: the picture; the drawn pairs; the texts
const changed = () => (dirty = pairsDirty = panelDirty = true);
const controls = new THREE.OrbitControls(camera, canvas);
Object.assign(controls, {enableDamping: true, dampingFactor: 0.16, enableKeys: false, screenSpacePanning: true, zoomSpeed: 1.1});
controls.addEventListener("change", () => ((dirty = true), touch()));

const isDark = () => (state.theme ? state.theme === "dark" : mediaDark.matches);
function applyTheme() {
  root.dataset.theme = isDark() ? "dark" : "light";
  paletteChanged(isDark());
  changed();
}
mediaDark.addEventListener("change", applyTheme);

const shown = (p) => (state.only < 0 || frame.verdict[p] === state.only) && (!state.isolate || !selectedBodies().length || isSelected(p));
const isSelected = (p) => (state.pair ? p === chosenPair : frame.a[p] === state.body || frame.b[p] === state.body);
const selectedBodies = () => state.pair || (state.body >= 0 ? [state.body] : []);

function setFrame(k) {
  state.frame = Math.max(0, Math.min(last, k | 0)), touch();
  frame = frameAt(state.frame);
  showFrame(frame);
  choose();
  root.dataset.frame = state.frame, $("scrub").value = state.frame;
}
// After the selection or the frame changed.
function choose() {
  chosenPair = -1;
  for (let p = 0; state.pair && p < frame.pairs; ++p) if (frame.a[p] === state.pair[0] && frame.b[p] === state.pair[1]) chosenPair = p;
  bodies.selected.fill(0);
  for (const b of selectedBodies()) bodies.selected[b] = 1;
  changed();
}
function choosePair(a, b) {
  state.pair = [Math.min(a, b), Math.max(a, b)], state.body = -1;
  choose(), openTab("selection", false);
}
function chooseBody(b) {
  state.pair = null, state.body = b;
  choose(), openTab("selection", false);
}
function clearSelection() {
  state.pair = null, state.body = -1, state.isolate = false;
  choose();
}
function nextPair(step) {
  const all = [];
  for (const v of ORDER) for (let p = 0; p < frame.pairs; ++p) if (frame.verdict[p] === v && (state.only < 0 || state.only === v)) all.push(p);
  if (!all.length) return;
  const p = all[(all.indexOf(chosenPair) + step + all.length) % all.length];
  choosePair(frame.a[p], frame.b[p]), fit();
}

// Points the camera at the selection, or at all bodies that move or are in a pair.
function fit() {
  const box = new THREE.Box3(), point = new THREE.Vector3(), chosen = selectedBodies(), add = (b) => {
    const r = bodies.radius[b] * (bodies.count > 1 ? 0.8 : 1), m = bodies.middle;
    for (const s of [-1, 1]) box.expandByPoint(point.set(m[3 * b] + s * r, m[3 * b + 1] + s * r, m[3 * b + 2] + s * r));
  };
  const small = chosen.filter((b) => !environment[b]);
  (small.length ? small : chosen).forEach(add);
  if (box.isEmpty()) for (let b = 0; b < bodies.count; ++b) if (!environment[b] && (!bodies.fixed[b] || bodies.verdict[b])) add(b);
  if (box.isEmpty()) for (let b = 0; b < bodies.count; ++b) add(b);
  const middle = box.getCenter(new THREE.Vector3()), radius = Math.max(box.getSize(point).length() / 2, 1e-6);
  const wide = Math.min(1, camera.aspect), angle = (camera.fov * Math.PI) / 360, direction = camera.position.clone().sub(controls.target);
  if (direction.lengthSq() < 1e-12 || !fit.done) direction.set(-0.55, -1, 0.62);
  fit.done = true;
  controls.target.copy(middle);
  camera.position.copy(middle).addScaledVector(direction.normalize(), (chosen.length ? 1.15 : 0.86) * radius / Math.sin(Math.atan(Math.tan(angle) * wide)));
  controls.update();
  dirty = true;
}

// Points the camera at a place of the scene, at the distance that shows the radius, from a direction.
function lookAt([x, y, z, radius, ...from]) {
  const wide = Math.min(1, camera.aspect), angle = Math.atan(Math.tan((camera.fov * Math.PI) / 360) * wide);
  controls.target.set(x - header.origin[0], y - header.origin[1], z - header.origin[2]);
  camera.position.copy(controls.target).addScaledVector(new THREE.Vector3(...from).normalize(), Math.max(radius, 1e-6) / Math.sin(angle));
  controls.update();
  dirty = true;
}

const extent = (() => { // of all bodies at their start
  const box = new THREE.Box3(), p = new THREE.Vector3();
  for (let b = 0; b < bodies.count; ++b)
    for (const s of [-1, 1]) box.expandByPoint(p.set(...[0, 1, 2].map((k) => bodies.middle[3 * b + k] + s * bodies.radius[b])));
  return {middle: box.getCenter(new THREE.Vector3()), radius: Math.max(box.getSize(p).length() / 2, 1e-6)};
})();
const hasEnvironment = environment.some((e) => e);
const groundHeight = (() => {
  let low = Infinity;
  for (let b = 0; b < bodies.count; ++b) low = Math.min(low, bodies.middle[3 * b + 2] - bodies.radius[b]);
  return low;
})();

function resize() {
  const width = Math.max($("view").clientWidth, 1), height = Math.max($("view").clientHeight, 1);
  renderer.setPixelRatio(Math.min(devicePixelRatio || 1, 2) * manner.pixels);
  renderer.setSize(width, height, false);
  screen.value.set(width, height), renderer.getDrawingBufferSize(drawnPixels.value);
  camera.aspect = width / height;
  camera.updateProjectionMatrix();
  dirty = true;
}
function changeManner(to) {
  const {pixels} = manner;
  manner = to, (dirty = true);
  if (pixels !== manner.pixels) resize();
}
new ResizeObserver(() => { resize(), (panelDirty = true); }).observe($("view"));

function lookOf() {
  const rgb = (c) => [255 * c.r, 255 * c.g, 255 * c.b], tint = RANKS.map((name) => rgb(palette[name])), grey = tint[0], land = rgb(palette.ground);
  const chosen = selectedBodies().length > 0, glass = state.tree !== "none" && chosen, related = new Uint8Array(state.only >= 0 ? bodies.count : 0);
  for (let p = 0; state.only >= 0 && p < frame.pairs; ++p) if (frame.verdict[p] === state.only) related[frame.a[p]] = related[frame.b[p]] = 1;
  for (let b = 0; b < (state.only >= 0 ? frame.worst.length : 0); ++b) if (frame.worst[b] === RANK_OF_VERDICT[state.only]) related[b] = 1;
  const own = new Map(), hue = (b) => {
    if (!own.has(b)) own.set(b, rgb(new THREE.Color().setHSL((b * 0.618034) % 1, 0.42, isDark() ? 0.6 : 0.62)));
    return own.get(b);
  };
  const how = {hidden: false, ghost: false, colour: grey, alpha: 255};
  return (b) => {
    const rank = bodies.verdict[b], picked = bodies.selected[b];
    how.hidden = false, how.ghost = false, how.alpha = rank === 3 ? 128 : 255;
    how.colour = environment[b] ? land : state.colours === "body" ? hue(b) : state.only >= 0 && related[b] ? tint[RANK_OF_VERDICT[state.only]] : tint[rank];
    if (picked) how.ghost = glass, how.alpha = glass ? (environment[b] ? 120 : 70) : how.alpha;
    else if (chosen && (state.isolate || glass)) how.hidden = bodies.count > 3000, how.ghost = true, how.alpha = environment[b] ? 16 : 26, how.colour = grey;
    else if (state.only >= 0 && !related[b] && !environment[b]) how.ghost = true, how.alpha = 40, how.colour = grey;
    return how;
  };
}

function draw() {
  const distance = camera.position.distanceTo(extent.middle), target = camera.position.distanceTo(controls.target);
  camera.far = Math.max(distance + 1.5 * extent.radius, 2 * target), camera.near = Math.max(camera.far * 1e-5, Math.min(target * 0.02, camera.far * 0.1));
  camera.updateProjectionMatrix(), camera.updateMatrixWorld();
  uniforms.up.value.set(0, 0, 1).transformDirection(camera.matrixWorldInverse);
  const scale = Math.pow(10, Math.floor(Math.log10(Math.max(target, 1e-9) / 1.5))), g = grid.material.uniforms;
  g.cell.value = scale, g.reach.value = Math.max(extent.radius * 1.6, Math.min(target * 2, extent.radius * 4)), g.middle.value.set(extent.middle.x, extent.middle.y, groundHeight);
  grid.visible = !hasEnvironment;
  gatherBodies(lookOf());
  if (pairsDirty) showPairs(frame, {...state, curves: state.curves && state.tree === "none"}, shown, chosenPair), (pairsDirty = false);
  render();
  placeLabels(), showScale(target);
  Object.assign(root.dataset, {bodies: drawnBodies, triangles: drawnTriangles, pixels: canvas.width * canvas.height, drawn: ++drawn});
}

const onScreen = new THREE.Vector3();
function placeLabels() {
  const box = $("labels"), wanted = [];
  if (chosenPair >= 0) wanted.push(chosenPair);
  for (const v of state.labels ? ORDER : []) for (let p = 0; p < frame.pairs && wanted.length < 40; ++p) if (frame.verdict[p] === v && shown(p) && p !== chosenPair) wanted.push(p);
  while (box.children.length > wanted.length) box.lastChild.remove();
  while (box.children.length < wanted.length) box.append(element("div"));
  wanted.forEach((p, k) => {
    const label = box.children[k], verdict = VERDICTS[frame.verdict[p]], text = `${VERDICT_TEXT[verdict][0]} ${boundText(frame, p)} · ${stageName(frame, p)}`;
    onScreen.fromArray(frame.where, 3 * p).project(camera);
    label.hidden = onScreen.z > 1 || Math.abs(onScreen.x) > 1.05 || Math.abs(onScreen.y) > 1.05;
    if (label.textContent !== text) label.textContent = text;
    label.className = verdict;
    label.style.transform = `translate(${(0.5 + 0.5 * onScreen.x) * canvas.clientWidth + 12}px, ${(0.5 - 0.5 * onScreen.y) * canvas.clientHeight - 10}px)`;
  });
}

// A bar of a round length, at the distance of the point that the camera orbits.
function showScale(target) {
  const perMetre = canvas.clientHeight / 2 / Math.tan((camera.fov * Math.PI) / 360) / target, most = 140 / perMetre, power = Math.pow(10, Math.floor(Math.log10(most)));
  const length = [5, 2, 1].map((f) => f * power).find((l) => l <= most) || power;
  document.querySelector("#scale span").style.width = length * perMetre + "px", (document.querySelector("#scale b").textContent = lengthText(length));
}

function fillSelection() {
  const box = document.querySelector("#selection > div"), chosen = selectedBodies();
  if (!chosen.length) return box.replaceChildren(element("p.hint", {}, "Click a body or a pair. ", element("kbd", {}, "N"), " goes to the next pair."));
  const parts = [];
  if (state.pair) parts.push(...(chosenPair >= 0 ? pairFacts(frame, chosenPair) : [element("p.hint", {}, "These two are not a pair in this frame" + (header.separate ? "" : ", or are separate") + (frame.header.left_out ? ", or are left out: the page has reached its size limit." : "."))]), ...chosen.map((b) => bodyLink(b, chooseBody)));
  else {
    parts.push(bodyLink(state.body, fit), bodyFacts(state.body));
    const own = [];
    for (let p = 0; p < frame.pairs && own.length < 30; ++p) if (frame.a[p] === state.body || frame.b[p] === state.body) own.push(pairButton(frame, p, -1, choosePair));
    parts.push(element("ul", {id: "own"}, ...own));
    if (frame.header.left_out && bodies.verdict[state.body]) parts.push(element("p.hint", {}, "Pairs may be missing here: the page has reached its size limit."));
  }
  const deepest = (kind) => Math.max(...chosen.map((b) => deepestLevel(bodies.geometry[b], kind))), kinds = ["spheres", "boxes"].filter((k) => deepest(k) >= 0);
  const press = (text, on, act, title) => element("button", {onclick: act, ariaPressed: String(on), title: title || ""}, text);
  parts.push(element("div.row", {}, press("Isolate", state.isolate, () => ((state.isolate = !state.isolate), choose()), "Fade the others (I)"), press("Fit", false, fit, "F"), press("Clear", false, clearSelection, "Esc")));
  if (kinds.length) {
    parts.push(element("div.row", {}, element("span.soft", {}, "Trees"), press("none", state.tree === "none", () => setTree("none")), ...kinds.map((k) => press(k === "spheres" ? "spheres (OCST)" : "boxes (OBB)", state.tree === k, () => setTree(k)))));
    if (state.tree !== "none" && deepest(state.tree) >= 0) {
      const most = deepest(state.tree), level = Math.min(state.level, most);
      parts.push(element("div.row", {}, element("span.soft", {}, "Level"), element("input", {type: "range", min: 0, max: most, value: level, ariaLabel: "Level of the trees", oninput: (e) => ((state.level = +e.target.value), changed())}), element("b", {}, `${level} of ${most}`)));
      if (treeFacts)
        parts.push(element("dl.facts", {}, ...chosen.flatMap((b, k) => (treeFacts.counts[k] ? fact(nameOf(b), `${grouped(treeFacts.counts[k][0])}${treeFacts.counts[k][1] >= 0 ? `, ${grouped(treeFacts.counts[k][1])} touch` : ""}, off by ≤ ${lengthText(treeFacts.errors[k])}`) : []))),
          element("p.hint", {}, treeFacts.counts.every((c) => c && c[1] >= 0) ? "Solid: touches a volume of the other body and is refined further. Faint: ruled out." : "All volumes of the level." + (chosen.length > 1 ? " The other body has no such tree on this page." : "")));
    }
  }
  box.replaceChildren(...parts);
}
function setTree(kind) {
  state.tree = kind;
  changed();
}

function fillShow() {
  const toggle = (name, words, key) => element("label.switch", {}, element("input", {type: "checkbox", checked: state[name], onchange: (e) => ((state[name] = e.target.checked), changed())}), words, element("small", {}, element("kbd", {}, key)));
  const levels = [...new Set(frame.level)].sort();
  document.querySelector("#show > div").replaceChildren(
    toggle("links", "Pairs: lines to both bodies, a mark at the pair", "L"), toggle("curves", "Where surfaces meet", "C"), toggle("bounds", "Bounds to scale: spheres of that radius", "B"),
    toggle("labels", "Labels: bound and stage of each pair", "T"), toggle("regions", "Regions tested (delimitation)", "R"),
    state.regions ? (levels.length ? element("div.row", {}, element("span.soft", {}, "Level"), element("select", {onchange: (e) => ((state.regionLevel = +e.target.value), changed()), ariaLabel: "Level of the regions"},
      element("option", {value: -1}, "all"), ...levels.map((l) => element("option", {value: l, selected: l === state.regionLevel}, String(l)))), element("small", {}, "blue: kept, grey: ruled out" + (frame.header.regions_left_out ? `; ${grouped(frame.header.regions_left_out)} deep ones are not shown` : ""))) : element("p.hint", {}, "None in this frame: " + (frame.header.stages[1][4] || "no region was tested") + ".")) : null,
    element("div.row", {}, element("span.soft", {}, "Colour bodies by"), element("select", {onchange: (e) => ((state.colours = e.target.value), (dirty = true)), ariaLabel: "Colour bodies by"},
      ...[["verdict", "verdict"], ["body", "body"]].map(([v, t]) => element("option", {value: v, selected: v === state.colours}, t)))));
}

function fillPanel() {
  const h = frame.header;
  treeFacts = showTrees(selectedBodies(), state.tree, state.level);
  showRegions(frame, state.regions, state.regionLevel);
  $("clock").replaceChildren(`Frame ${grouped(h.frame)} `, element("small", {}, `/ ${grouped(header.frames_run - 1)}\ncomputed in ${timeText(h.ms)}`));
  fillLegend(frame, state.only, (v) => ((state.only = v), choose()));
  fillSelection(), fillPairs(frame, shown, chosenPair, state.search, choosePair, chooseBody), fillStages(frame), fillShow(), drawChart(state.frame);
  const play = $("play");
  play.textContent = state.playing ? "❚❚" : "▶", play.setAttribute("aria-label", state.playing ? "Pause" : "Play");
  writeHash();
}

function play(on) {
  if (on && state.frame === last) setFrame(0);
  state.playing = on, panelDirty = true;
}

// The address holds the state of the view, so that it can be shared.
function writeHash() {
  if (state.playing) return;
  const parts = ["frame=" + state.frame];
  if (state.pair) parts.push("pair=" + state.pair.join(","));
  if (state.body >= 0) parts.push("body=" + state.body);
  if (state.tree !== "none") parts.push("trees=" + state.tree, "level=" + state.level);
  for (const name of ["isolate", "bounds", "labels", "regions"]) if (state[name]) parts.push(name);
  if (state.only >= 0) parts.push("only=" + VERDICTS[state.only]);
  if (state.theme) parts.push("theme=" + state.theme);
  try { history.replaceState(null, "", "#" + parts.join("&")); } catch (_) { /* some viewers forbid it */ }
}
function readHash() {
  const wants = new Map(location.hash.slice(1).split("&").map((part) => part.split("=")));
  const number = (name) => (wants.has(name) && isFinite(+wants.get(name)) ? +wants.get(name) : -1);
  const exists = (b) => Number.isInteger(b) && b >= 0 && b < bodies.count;
  for (const name of ["isolate", "bounds", "labels", "regions"]) if (wants.has(name)) state[name] = true;
  if (["dark", "light"].includes(wants.get("theme"))) state.theme = wants.get("theme");
  if (["spheres", "boxes"].includes(wants.get("trees"))) state.tree = wants.get("trees");
  if (number("level") >= 0) state.level = number("level");
  if (VERDICTS.includes(wants.get("only"))) state.only = VERDICTS.indexOf(wants.get("only"));
  const pair = (wants.get("pair") || "").split(",").map(Number);
  if (pair.length === 2 && pair.every(exists)) state.pair = pair;
  else if (wants.has("body") && exists(number("body"))) state.body = number("body");
  const at = (wants.get("at") || "").split(",").map(Number);
  state.at = at.length === 7 && at.every(isFinite) ? at : null;
  applyTheme();
  setFrame(Math.max(0, number("frame")));
  if (wants.has("worst")) nextPair(1);
  if (wants.has("tab")) openTab(wants.get("tab"), true);
  return wants;
}
addEventListener("hashchange", () => {
  readHash();
  if (state.at) lookAt(state.at);
});

function openTab(name, press) {
  const narrow = matchMedia("(max-width: 820px)").matches, panel = $("panel"), section = $(name);
  if (!section) return;
  if (!narrow) return press && section.scrollIntoView({block: "nearest"});
  const open = panel.classList.contains("open") && section.classList.contains("active");
  panel.classList.toggle("open", press ? !open : panel.classList.contains("open"));
  for (const s of panel.querySelectorAll("section")) s.classList.toggle("active", s === section);
  for (const b of document.querySelectorAll("#tabs button")) b.setAttribute("aria-pressed", String(b.dataset.tab === name && panel.classList.contains("open")));
}
for (const b of document.querySelectorAll("#tabs button")) b.onclick = () => openTab(b.dataset.tab, true);

const KEYS = [["Space", "play or pause"], ["← →", "previous or next frame; with Shift: by ten"], ["Home End", "first or last frame"], ["N P", "next or previous pair, worst first"],
  ["F", "fit the selection, or everything"], ["I", "isolate the selection"], ["Esc", "clear the selection"], ["S X", "trees of the selected: spheres, boxes"], ["[ ]", "level of the trees"],
  ["L C B T R", "pairs, contact curves, bounds, labels, regions"], ["D", "dark or light"], ["Drag, wheel", "turn, zoom; right button or two fingers: move"]];
document.querySelector("#keys dl").append(...KEYS.flatMap(([k, t]) => [element("dt", {}, ...k.split(" ").flatMap((w) => [element("kbd", {}, w), " "])), element("dd", {}, t)]));
const flip = (name) => ((state[name] = !state[name]), changed());
addEventListener("keydown", (e) => {
  if (e.ctrlKey || e.metaKey || e.altKey || /^(INPUT|SELECT|TEXTAREA)$/.test(e.target.tagName) && !(e.target.id === "scrub" && !e.key.startsWith("Arrow"))) return;
  if (e.key === " " && e.target.tagName === "BUTTON") return;
  const acts = {" ": () => play(!state.playing), ArrowLeft: () => setFrame(state.frame - (e.shiftKey ? 10 : 1)), ArrowRight: () => setFrame(state.frame + (e.shiftKey ? 10 : 1)), Home: () => setFrame(0), End: () => setFrame(last),
    n: () => nextPair(1), p: () => nextPair(-1), f: fit, i: () => flip("isolate"), Escape: clearSelection, s: () => setTree(state.tree === "spheres" ? "none" : "spheres"), x: () => setTree(state.tree === "boxes" ? "none" : "boxes"),
    "[": () => ((state.level = Math.max(0, state.level - 1)), changed()), "]": () => ((state.level = Math.min(state.level + 1, 16)), changed()),
    l: () => flip("links"), c: () => flip("curves"), b: () => flip("bounds"), t: () => flip("labels"), r: () => flip("regions"), d: () => $("theme").click(), "?": () => $("keys").showModal()};
  const act = acts[e.key] || acts[e.key.toLowerCase()];
  if (act) act(), e.preventDefault();
});
$("play").onclick = () => play(!state.playing), ($("previous").onclick = () => setFrame(state.frame - 1)), ($("next").onclick = () => setFrame(state.frame + 1));
$("scrub").max = last, ($("scrub").oninput = (e) => setFrame(+e.target.value));
$("speed").onchange = (e) => (state.speed = +e.target.value);
$("search").oninput = (e) => ((state.search = e.target.value), (panelDirty = true));
$("fit").onclick = fit, ($("help").onclick = () => $("keys").showModal());
$("theme").onclick = () => ((state.theme = isDark() ? "light" : "dark"), applyTheme());

// A click is a press with hardly any movement; otherwise it rotated the view.
let pressed = null;
canvas.addEventListener("pointerdown", (e) => (pressed = [e.clientX, e.clientY, performance.now()]));
canvas.addEventListener("pointerup", (e) => {
  if (!pressed || Math.hypot(e.clientX - pressed[0], e.clientY - pressed[1]) > 6 || performance.now() - pressed[2] > 800) return;
  const box = canvas.getBoundingClientRect(), x = e.clientX - box.left, y = e.clientY - box.top;
  let best = e.pointerType === "touch" ? 18 : 11, pair = -1; // marks of pairs first: they are small and on top
  for (let p = 0; state.links && p < frame.pairs; ++p) {
    if (!shown(p)) continue;
    onScreen.fromArray(frame.where, 3 * p).project(camera);
    const d = onScreen.z > 1 ? Infinity : Math.hypot((0.5 + 0.5 * onScreen.x) * box.width - x, (0.5 - 0.5 * onScreen.y) * box.height - y);
    if (d < best) (best = d), (pair = p);
  }
  if (pair >= 0) return choosePair(frame.a[pair], frame.b[pair]);
  const body = bodyAt(Math.floor(x), Math.floor(y), lookOf());
  body >= 0 ? chooseBody(body) : clearSelection();
});
canvas.addEventListener("dblclick", fit);

// Draws when something changed: at full quality at rest, and fast enough for the browser while moving.
const FRAMES_PER_SECOND = 20; // of the run, at speed 1
let due = 0, before = 0, touched = 0, drawn = 0, bench = 0;
const touch = () => (touched = Math.max(touched, performance.now()));
controls.addEventListener("start", () => (touched = Infinity)), controls.addEventListener("end", () => (touched = performance.now()));
const moving = () => state.playing || bench > 0 || performance.now() - touched < 150;
function tick(now) {
  requestAnimationFrame(tick);
  const since = now - before, passed = Math.min(since, 200);
  before = now;
  if (state.playing && (due += (passed / 1000) * FRAMES_PER_SECOND * state.speed) >= 1) {
    const to = state.frame + Math.floor(due);
    due %= 1;
    if (to > last) bench > 0 ? setFrame(0) : (setFrame(last), play(false));
    else setFrame(to);
  }
  controls.update();
  if (bench > 0) turnFor(passed);
  const busy = moving(), wanted = busy ? MANNERS[pace.at] : MANNERS[0];
  if (wanted !== manner) changeManner(wanted);
  if (panelDirty && (!state.playing || now - (tick.panel || 0) > (drawsOnCpu ? 500 : 200))) (tick.panel = now), (panelDirty = false), fillPanel();
  if (!dirty) return;
  dirty = false;
  draw();
  if (busy && tick.busy) keepPace(since);
  tick.busy = busy;
}

// Quality while moving: coarser when pictures take too long, finer when there is time. After a failed try the next one comes later.
const pace = {at: drawsOnCpu ? 3 : 0, pictures: 0, time: 0, good: 0, patience: 8, tried: false};
function keepPace(since) {
  pace.time += Math.min(since, 1000);
  if (++pace.pictures < 8 && pace.time < 400) return;
  const each = pace.time / pace.pictures;
  pace.pictures = pace.time = 0;
  if (each > 36 && pace.at + 1 < MANNERS.length) {
    if (pace.tried) pace.patience = Math.min(2 * pace.patience, 256);
    ++pace.at, (pace.good = 0), (pace.tried = false);
  } else if (each < 20 && pace.at > 0 && ++pace.good >= pace.patience) --pace.at, (pace.good = 0), (pace.tried = true);
}

// "#bench=SECONDS" plays and rotates for that time, and leaves the pictures per second in data-fps.
let started = 0;
function turnFor(passed) {
  if (!started) (started = performance.now()), (drawn = 0);
  const angle = 0.0006 * passed, x = camera.position.x - controls.target.x, y = camera.position.y - controls.target.y;
  camera.position.x = controls.target.x + x * Math.cos(angle) - y * Math.sin(angle), camera.position.y = controls.target.y + x * Math.sin(angle) + y * Math.cos(angle);
  camera.lookAt(controls.target), (dirty = true);
  if (performance.now() - started < 1000 * bench) return;
  root.dataset.fps = ((1000 * drawn) / (performance.now() - started)).toFixed(1), (root.dataset.manner = pace.at);
  bench = 0, play(false);
}

$("title").textContent = header.scene;
$("subtitle").textContent = `${grouped(header.bodies)} bodies, ${grouped(header.frames_run)} frame${header.frames_run === 1 ? "" : "s"}` + (header.notes.length ? " · shown in part, see About" : "");
resize();
const wanted = readHash();
fit(), fillAbout();
if (state.at) lookAt(state.at);
if (wanted.has("bench")) (bench = +wanted.get("bench") || 3), (state.playing = true);
fillPanel(), draw();
root.dataset.ready = "yes";
requestAnimationFrame(tick);
