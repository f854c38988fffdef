// The model: every part as grey glass, the chosen two in colours, their common part in red.
const header = JSON.parse(document.getElementById("header").textContent);
const $ = (id) => document.getElementById(id), root = document.documentElement;
const canvas = $("scene"), gl = canvas.getContext("webgl2", {antialias: true, alpha: false, powerPreference: "high-performance"});
if (!gl) throw new Error("This page needs WebGL 2, which this browser does not offer.");
const renderer = new THREE.WebGLRenderer({canvas, context: gl});
renderer.sortObjects = false;
const camera = new THREE.PerspectiveCamera(42, 1, 0.1, 1000), scene = new THREE.Scene(), controls = new THREE.OrbitControls(camera, canvas);
camera.up.set(0, 0, 1);
scene.autoUpdate = false; // parts do not move
controls.screenSpacePanning = true;
const vector = (numbers) => new THREE.Vector3(...numbers);
const colourOf = (name) => new THREE.Color(getComputedStyle(root).getPropertyValue("--" + name).trim());

// Flat faces, brighter towards the camera. Glass is clear where the camera looks straight at it. Coordinates are relative to the
// camera, so that small clashes far from the model's middle are drawn as exactly as others.
function material(name, alpha, more = {}) {
  const made = new THREE.ShaderMaterial({
    uniforms: {colour: {value: new THREE.Color()}, alpha: {value: alpha}, glass: {value: more.glass || 0}}, clipping: true, side: THREE.DoubleSide,
    transparent: alpha < 1, depthWrite: alpha === 1, polygonOffset: alpha === 1, polygonOffsetFactor: -2, polygonOffsetUnits: -2,
    vertexShader: `varying vec3 eye;
#include <clipping_planes_pars_vertex>
void main() {
  vec4 mvPosition = modelViewMatrix * vec4(position, 1.0);
  eye = mvPosition.xyz;
  gl_Position = projectionMatrix * mvPosition;
#include <clipping_planes_vertex>
}`,
    fragmentShader: `varying vec3 eye;
uniform vec3 colour; uniform float alpha, glass;
#include <clipping_planes_pars_fragment>
void main() {
#include <clipping_planes_fragment>
  vec3 n = normalize(cross(dFdx(eye), dFdy(eye)));
  float front = abs(dot(n, normalize(eye))), up = abs((vec4(n, 0.0) * viewMatrix).z);
  gl_FragColor = vec4(colour * (0.55 + 0.25 * front + 0.2 * up), alpha * mix(1.0, 0.25 + 1.2 * pow(1.0 - front, 2.0), glass));
}`});
  made.name = name;
  return made;
}
const materials = {glass: material("glass-part", 0.3, {glass: 1}), a: material("a", 0.38), b: material("b", 0.38), red: material("red", 1), soft: material("accent", 0.5)};
const lineMaterials = {a: new THREE.LineBasicMaterial({}), b: new THREE.LineBasicMaterial({}), red: new THREE.LineBasicMaterial({depthTest: false}), accent: new THREE.LineBasicMaterial({})};

// Geometries by mesh, made when a part first needs one.
const positions = new Columns("positions"), wide = new Columns("wide"), narrow = new Columns("narrow");
const geometries = header.meshes.map(([vertices, triangles]) => {
  const geometry = new THREE.BufferGeometry(), is_wide = vertices > 65536;
  geometry.setAttribute ? geometry.setAttribute("position", new THREE.BufferAttribute(positions.take(Float32Array, 3 * vertices), 3))
                        : geometry.addAttribute("position", new THREE.BufferAttribute(positions.take(Float32Array, 3 * vertices), 3));
  geometry.setIndex(new THREE.BufferAttribute((is_wide ? wide : narrow).take(is_wide ? Uint32Array : Uint16Array, 3 * triangles), 1));
  geometry.computeBoundingBox(), geometry.computeBoundingSphere();
  return geometry;
});
const fresh = (numbers) => {
  const geometry = new THREE.BufferGeometry(), attribute = new THREE.BufferAttribute(numbers, 3);
  geometry.setAttribute ? geometry.setAttribute("position", attribute) : geometry.addAttribute("position", attribute);
  return geometry;
};

const glass = new THREE.Group(), front = new THREE.Group(), marked = new THREE.Group();
scene.add(front, glass, marked); // the choice is drawn first: glass is before it or behind it
const parts = (() => {
  const count = header.labels.length, columns = new Columns("parts"), box = new THREE.Box3();
  const at = columns.take(Float64Array, 3 * count), turn = columns.take(Float32Array, 4 * count), mesh = columns.take(Uint32Array, count), made = [];
  for (let k = 0; k < count; ++k) {
    const part = new THREE.Mesh(geometries[mesh[k]], materials.glass);
    part.position.fromArray(at, 3 * k), part.quaternion.fromArray(turn, 4 * k), part.updateMatrix(), (part.matrixWorld = part.matrix), (part.matrixAutoUpdate = false);
    part.number = k, (part.box = part.geometry.boundingBox.clone().applyMatrix4(part.matrix));
    box.union(part.box);
    glass.add(part), made.push(part);
  }
  made.box = box.isEmpty() ? new THREE.Box3(vector([-1, -1, -1]), vector([1, 1, 1])) : box;
  return made;
})();

// Marks of all clashes, as large from near as from afar.
const marks = fresh(new Float32Array(header.clashes.flatMap((c) => c.at)));
const markMaterial = new THREE.ShaderMaterial({
  uniforms: {ratio: {value: 1}}, transparent: true, depthTest: false, clipping: true,
  vertexShader: `attribute vec3 tint; varying vec3 colour; uniform float ratio;
#include <clipping_planes_pars_vertex>
void main() {
  vec4 mvPosition = modelViewMatrix * vec4(position, 1.0);
  colour = tint, gl_Position = projectionMatrix * mvPosition, gl_PointSize = 9.0 * ratio;
#include <clipping_planes_vertex>
}`,
  fragmentShader: `varying vec3 colour;
#include <clipping_planes_pars_fragment>
void main() {
#include <clipping_planes_fragment>
  float d = length(gl_PointCoord - 0.5);
  if (d > 0.5) discard;
  gl_FragColor = vec4(d > 0.36 ? vec3(1.0) : colour, 0.9);
}`});
const points = new THREE.Points(marks, markMaterial);
points.frustumCulled = false;
marked.add(points);

function applyColours() {
  for (const [name, made] of Object.entries(materials)) made.uniforms.colour.value.copy(colourOf(made.name || name));
  for (const [name, made] of Object.entries(lineMaterials)) made.color.copy(colourOf(name));
  renderer.setClearColor(colourOf("paper"));
}
// The colours of the marks; marks of clashes that are not listed have no place.
function placeMarks(listed) {
  const tints = new Float32Array(3 * listed.length), index = [], kinds = new Map();
  header.clashes.forEach((c, k) => {
    if (!kinds.has(c.kind)) kinds.set(c.kind, colourOf(c.kind));
    kinds.get(c.kind).toArray(tints, 3 * k);
    if (listed[k]) index.push(k);
  });
  const attribute = new THREE.BufferAttribute(tints, 3);
  marks.setAttribute ? marks.setAttribute("tint", attribute) : marks.addAttribute("tint", attribute);
  marks.setIndex(index);
}

// The red lines and faces of each clash, from the columns of all.
const red = new Columns("red"), reds = header.clashes.map((c) => ({triangles: red.take(Float32Array, 9 * c.red[0]), lines: red.take(Float32Array, 6 * c.red[1])}));
function showInFront(clash, part) {
  for (const thing of [...front.children]) front.remove(thing), thing.own && thing.geometry.dispose();
  const add = (thing, at, own = true) => {
    thing.position.copy(at), thing.updateMatrix(), (thing.matrixWorld = thing.matrix), (thing.own = own), front.add(thing);
  };
  const coloured = (number, name) => {
    const copy = new THREE.Mesh(parts[number].geometry, materials[name]), lineName = name === "soft" ? "accent" : name;
    copy.position.copy(parts[number].position), copy.quaternion.copy(parts[number].quaternion), copy.updateMatrix(), (copy.matrixWorld = copy.matrix), (copy.number = number);
    front.add(copy);
    if (name === "red" || parts[number].geometry.index.count > 150000) return;
    const edges = new THREE.LineSegments(new THREE.EdgesGeometry(parts[number].geometry, 25), lineMaterials[lineName]);
    edges.quaternion.copy(copy.quaternion), (edges.number = number), add(edges, copy.position);
  };
  if (part >= 0) coloured(part, "soft");
  if (clash < 0) return;
  const c = header.clashes[clash], at = vector(c.at), own = reds[clash];
  if (own.triangles.length) add(new THREE.Mesh(fresh(own.triangles), materials.red), at);
  else if (c.ball && !c.whole) add(new THREE.Mesh(new THREE.SphereBufferGeometry(c.ball[1], 24, 16), materials.red), vector(c.ball[0]).add(at));
  if (c.whole) coloured(c[c.whole], "red");
  if (c.whole !== "a") coloured(c.a, "a");
  if (c.whole !== "b") coloured(c.b, "b");
  if (own.lines.length) add(new THREE.LineSegments(fresh(own.lines), lineMaterials.red), at);
}

// The section plane: nothing beyond it is drawn or chosen.
const plane = new THREE.Plane();
function setSection(axis, share, flipped) {
  renderer.clippingPlanes = axis ? [plane] : [];
  if (!axis) return;
  const size = parts.box.max[axis] - parts.box.min[axis], at = parts.box.min[axis] + share * size;
  plane.normal.set(0, 0, 0)[axis] = flipped ? 1 : -1;
  plane.constant = flipped ? -at : at;
}
const beyond = (point) => renderer.clippingPlanes.length && plane.distanceToPoint(point) < 0;

const ray = new THREE.Raycaster();
function partAt(x, y) {
  const box = canvas.getBoundingClientRect();
  ray.setFromCamera({x: (2 * x) / box.width - 1, y: 1 - (2 * y) / box.height}, camera);
  const hit = ray.intersectObjects(parts.filter((p) => p.shown)).find((h) => !beyond(h.point));
  return hit ? hit.object.number : -1;
}
function markAt(x, y, listed, reach) {
  const box = canvas.getBoundingClientRect(), p = new THREE.Vector3();
  let best = -1;
  header.clashes.forEach((c, k) => {
    if (!listed[k] || beyond(p.fromArray(c.at))) return;
    p.project(camera);
    const d = p.z > 1 ? Infinity : Math.hypot((0.5 + 0.5 * p.x) * box.width - x, (0.5 - 0.5 * p.y) * box.height - y);
    if (d < reach) (reach = d), (best = k);
  });
  return best;
}
