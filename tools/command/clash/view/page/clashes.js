// The choice, the hidden parts, and the view that follows them.
const state = {clash: -1, part: -1, isolate: false, hidden: new Set(), search: "", kind: "", status: "", onlyPart: false, rows: rowsAtATime, axis: "", depth: 0.5, flipped: false, theme: ""};
let listed = [], dirty = true, flight = null;
const calm = matchMedia("(prefers-reduced-motion: reduce)").matches;

const inFront = () => (state.clash >= 0 ? [header.clashes[state.clash].a, header.clashes[state.clash].b] : state.part >= 0 ? [state.part] : []);
function showParts() {
  const chosen = new Set(inFront());
  let shown = 0;
  for (const part of parts) {
    part.shown = !state.hidden.has(part.number) && (!(state.isolate && chosen.size) || chosen.has(part.number));
    part.visible = part.shown && !chosen.has(part.number);
    shown += part.shown;
  }
  points.visible = state.clash < 0;
  materials.glass.uniforms.alpha.value = chosen.size ? 0.08 : 0.3; // the choice is seen through it
  root.dataset.parts = shown, (root.dataset.clash = state.clash < 0 ? "" : header.clashes[state.clash].id), (root.dataset.hidden = state.hidden.size);
  root.dataset.red = front.children.filter((thing) => thing.material === materials.red).reduce((sum, thing) => sum + (thing.geometry.index ? thing.geometry.index.count : thing.geometry.attributes.position.count) / 3, 0);
  dirty = true;
}

const press = (label, act, pressed, title) => element("button", {onclick: act, title: title || "", ariaPressed: pressed === undefined ? null : String(pressed)}, label);
function fillChosen() {
  const box = document.querySelector("#chosen > div"), hide = (part) => [state.hidden.has(part) ? "Show" : "Hide", () => toggleHidden(part)];
  const rest = state.hidden.size ? element("div.row", {}, press(`Show ${state.hidden.size} hidden`, showAll, undefined, "Shift+H")) : null;
  if (state.clash < 0 && state.part < 0) return box.replaceChildren(...[element("p.hint", {}, header.clashes.length ? "Choose a clash in the list, or click its mark. Click a part to see what it clashes with." : "No clashes."), rest].filter((e) => e));
  const isolate = press("Isolate", () => ((state.isolate = !state.isolate), changed()), state.isolate, "Show nothing else (I)"), clear = press("Clear", clearChoice, undefined, "Esc");
  if (state.clash >= 0) {
    const c = header.clashes[state.clash];
    return box.replaceChildren(...[element("p", {}, element("span", {className: "dot " + c.kind}), element("b", {}, c.kind), `, ${c.size}`, element("span.soft", {}, ` · ${c.status}${c.comment ? `: ${c.comment}` : ""}`)),
      partBox(c.a, c.whole === "a" ? "crossing" : "a", [hide(c.a), ["Its clashes", () => choosePart(c.a)]]), partBox(c.b, c.whole === "b" ? "crossing" : "b", [hide(c.b), ["Its clashes", () => choosePart(c.b)]]),
      element("p.hint", {}, `at ${c.where} (${header.unit})`), element("div.row", {}, press("Fly there", fit, undefined, "F"), isolate, press("Section here", sectionHere, undefined, "Section plane through the clash (S)"), clear), rest].filter((e) => e));
  }
  box.replaceChildren(...[partBox(state.part, "", [hide(state.part)]), element("div.row", {}, press("Fly there", fit, undefined, "F"), isolate, clear), rest].filter((e) => e));
}

function changed() {
  showParts(), fillChosen(), writeHash();
}
function filter() {
  listed = listedBy({...state, part: state.part});
  placeMarks(listed), fillRows(listed, state.clash, state.rows, (k) => chooseClash(k)), (dirty = true);
}
function chooseClash(number, fly = true) {
  state.clash = number;
  for (const part of inFront()) state.hidden.delete(part);
  showInFront(number, -1), changed(), markRow(number);
  if (fly) fit();
}
function choosePart(number) {
  state.clash = -1, (state.part = number);
  showInFront(-1, number), filter(), changed();
}
function clearChoice() {
  const had = state.part >= 0;
  state.clash = state.part = -1, (state.isolate = false);
  showInFront(-1, -1), had && filter(), markRow(-1), changed();
}
function toggleHidden(part) {
  state.hidden.has(part) ? state.hidden.delete(part) : state.hidden.add(part);
  for (const thing of front.children) if (thing.number === part) thing.visible = !state.hidden.has(part);
  changed();
}
function showAll() {
  state.hidden.clear();
  for (const thing of front.children) thing.visible = true;
  changed();
}
function step(by) {
  const numbers = [...listed.keys()].filter((k) => listed[k]);
  if (!numbers.length) return;
  const at = numbers.indexOf(state.clash), next = numbers[at < 0 ? (by > 0 ? 0 : numbers.length - 1) : (at + by + numbers.length) % numbers.length];
  if (numbers.indexOf(next) >= state.rows) (state.rows = numbers.indexOf(next) + rowsAtATime), filter();
  chooseClash(next);
}

// The camera flies to a ball, seen from a direction.
function fly(middle, radius, from) {
  const way = from.clone().normalize();
  if (Math.abs(way.z) > 0.999) way.set(0.03, -0.03, way.z).normalize(); // the camera cannot stand on its head
  const distance = radius / Math.sin((camera.fov * Math.PI) / 360) / Math.min(1, camera.aspect);
  const to = {target: middle.clone(), position: middle.clone().addScaledVector(way, distance)};
  flight = {to, from: {target: controls.target.clone(), position: camera.position.clone()}, start: performance.now(), time: calm || !root.dataset.ready ? 0 : 450};
  dirty = true;
}
function fit() {
  if (state.clash >= 0) {
    const [middle, radius, from] = header.clashes[state.clash].view;
    return fly(vector(middle), Math.max(radius, 1e-6), vector(from));
  }
  const box = state.part >= 0 ? parts[state.part].box : parts.box;
  fly(box.getCenter(new THREE.Vector3()), Math.max(0.5 * box.getSize(new THREE.Vector3()).length(), 1e-6), root.dataset.ready ? camera.position.clone().sub(controls.target) : vector([0.45, -1, 0.6]));
}

function setAxis(axis) {
  state.axis = state.axis === axis ? "" : axis;
  applySection();
}
function sectionHere() {
  const at = state.clash >= 0 ? vector(header.clashes[state.clash].at) : parts.box.getCenter(new THREE.Vector3());
  state.axis = state.axis || "y";
  const low = parts.box.min[state.axis], size = parts.box.max[state.axis] - low || 1;
  state.depth = Math.min(1, Math.max(0, (at[state.axis] - low) / size));
  state.flipped = camera.position[state.axis] < at[state.axis]; // keeps the side behind the clash
  applySection();
}
function applySection() {
  setSection(state.axis, state.depth, state.flipped);
  $("axis").value = state.axis, ($("depth").value = state.depth), ($("depth").hidden = $("flip").hidden = !state.axis);
  root.dataset.section = state.axis, (dirty = true);
}

const isDark = () => (state.theme ? state.theme === "dark" : matchMedia("(prefers-color-scheme: dark)").matches);
function applyTheme() {
  root.dataset.theme = isDark() ? "dark" : "light";
  applyColours(), listed.length && placeMarks(listed), (dirty = true);
}

// The address holds the choice, so that it can be shared.
function writeHash() {
  const words = [];
  if (state.clash >= 0) words.push("clash=" + header.clashes[state.clash].id);
  else if (state.part >= 0) words.push("part=" + state.part);
  if (state.isolate) words.push("isolate");
  if (state.theme) words.push("theme=" + state.theme);
  try { history.replaceState(null, "", "#" + words.join("&")); } catch (_) { /* some viewers forbid it */ }
}
function readHash() {
  const wants = new Map(location.hash.slice(1).split("&").map((word) => word.split("=")));
  if (["dark", "light"].includes(wants.get("theme"))) state.theme = wants.get("theme");
  state.isolate = wants.has("isolate");
  applyTheme();
  const clash = header.clashes.findIndex((c) => c.id === wants.get("clash")), part = wants.has("part") ? +wants.get("part") : -1;
  state.part = clash < 0 && parts[part] ? part : -1;
  if (["x", "y", "z"].includes(wants.get("section"))) state.axis = wants.get("section");
  filter();
  if (clash >= listed.length || clash >= state.rows) (state.rows = clash + rowsAtATime), filter();
  if (clash >= 0) chooseClash(clash);
  else state.clash = -1, showInFront(-1, state.part), changed(), fit();
  if (state.axis) sectionHere();
  else applySection();
}
addEventListener("hashchange", readHash);

const KEYS = [["N P", "next or previous clash"], ["F", "fly to the clash, or show everything"], ["I", "isolate the choice"], ["H", "hide the chosen part, or the second part of the clash; with Shift: show all"], ["S", "section plane through the clash"],
  ["X Y Z", "section plane along an axis, or off"], ["Esc", "choose nothing"], ["D", "dark or light"], ["Drag, wheel", "turn, zoom; right button or two fingers: move"]];
document.querySelector("#keys dl").append(...KEYS.flatMap(([k, t]) => [element("dt", {}, ...k.split(" ").flatMap((w) => [element("kbd", {}, w), " "])), element("dd", {}, t)]));
addEventListener("keydown", (e) => {
  if (e.ctrlKey || e.metaKey || e.altKey || /^(INPUT|SELECT|TEXTAREA)$/.test(e.target.tagName)) return;
  const acts = {n: () => step(1), p: () => step(-1), f: fit, i: () => ((state.isolate = !state.isolate), changed()), h: () => (e.shiftKey ? showAll() : inFront().length && toggleHidden(inFront().pop())),
    s: sectionHere, x: () => setAxis("x"), y: () => setAxis("y"), z: () => setAxis("z"), escape: clearChoice, d: () => $("theme").click(), "?": () => $("keys").showModal()};
  const act = acts[e.key.toLowerCase()];
  if (act) act(), e.preventDefault();
});
$("search").oninput = (e) => ((state.search = e.target.value), (state.rows = rowsAtATime), filter());
for (const id of ["kind", "status"]) $(id).onchange = (e) => ((state[id] = e.target.value), (state.rows = rowsAtATime), filter());
$("more").onclick = () => ((state.rows += rowsAtATime), filter());
$("axis").onchange = (e) => ((state.axis = e.target.value), applySection());
$("depth").oninput = (e) => ((state.depth = +e.target.value), applySection());
$("flip").onclick = () => ((state.flipped = !state.flipped), applySection());
$("fit").onclick = fit, ($("help").onclick = () => $("keys").showModal());
$("theme").onclick = () => ((state.theme = isDark() ? "light" : "dark"), applyTheme(), writeHash());

// A click is a press with hardly any movement; otherwise it rotated the view.
let pressed = null;
canvas.addEventListener("pointerdown", (e) => ((pressed = [e.clientX, e.clientY]), (flight = null)));
canvas.addEventListener("pointerup", (e) => {
  if (!pressed || Math.hypot(e.clientX - pressed[0], e.clientY - pressed[1]) > 6) return;
  const box = canvas.getBoundingClientRect(), x = e.clientX - box.left, y = e.clientY - box.top;
  const clash = points.visible ? markAt(x, y, listed, e.pointerType === "touch" ? 18 : 9) : -1;
  if (clash >= 0) return chooseClash(clash);
  const part = partAt(x, y);
  part >= 0 ? choosePart(part) : clearChoice();
});
canvas.addEventListener("dblclick", fit);

// Draws when something changed.
controls.addEventListener("change", () => (dirty = true));
function resize() {
  const width = canvas.clientWidth || 1, height = canvas.clientHeight || 1, ratio = Math.min(devicePixelRatio || 1, 2);
  renderer.setPixelRatio(ratio), renderer.setSize(width, height, false), (markMaterial.uniforms.ratio.value = ratio);
  camera.aspect = width / height, camera.updateProjectionMatrix(), (dirty = true);
}
addEventListener("resize", resize);
function draw() {
  // Near and far planes follow the view, so that a clash of a micrometre and a site of a kilometre are both drawn.
  const distance = camera.position.distanceTo(controls.target), size = parts.box.getSize(new THREE.Vector3()).length();
  camera.near = Math.max(distance / 200, size * 1e-9), (camera.far = camera.position.distanceTo(parts.box.getCenter(new THREE.Vector3())) + size);
  camera.updateProjectionMatrix(), camera.updateMatrixWorld(), renderer.render(scene, camera);
  root.dataset.drawn = 1 + (+root.dataset.drawn || 0);
}
function moveFlight(now) {
  const share = flight.time ? Math.min(1, (now - flight.start) / flight.time) : 1, soft = share * share * (3 - 2 * share);
  controls.target.lerpVectors(flight.from.target, flight.to.target, soft), camera.position.lerpVectors(flight.from.position, flight.to.position, soft);
  camera.lookAt(controls.target), (dirty = true);
  if (share === 1) flight = null;
}
function tick(now) {
  requestAnimationFrame(tick);
  if (flight) moveFlight(now);
  controls.update();
  if (dirty) (dirty = false), draw();
}

$("title").textContent = header.title;
const counted = (count, one, many) => `${count.toLocaleString("en")} ${count === 1 ? one : many}`;
$("subtitle").textContent = `${counted(labels.length, "part", "parts")}, ${counted(header.clashes.length, "clash", "clashes")}` + header.notes.map((note) => ` · ${note}`).join("");
fillChoices("kind", "kinds"), fillChoices("status", "statuses");
resize(), readHash();
if (flight) moveFlight(performance.now());
controls.update(), draw();
root.dataset.opened = Math.round(performance.now()), (root.dataset.ready = "yes");
requestAnimationFrame(tick);
