// Bodies: instances of meshes, in levels of detail that are chosen anew for each picture.
const canvas = document.getElementById("scene");
const gl = canvas.getContext("webgl2", {antialias: true, alpha: false, powerPreference: "high-performance"});
if (!gl) throw new Error("This page needs WebGL 2, which this browser does not offer.");
const renderer = new THREE.WebGLRenderer({canvas, context: gl, antialias: true});
renderer.autoClear = false;
const camera = new THREE.PerspectiveCamera(42, 1, 0.1, 1000);
camera.up.set(0, 0, 1);
const solids = new THREE.Scene(), ghosts = new THREE.Scene();
let palette = {}; // by name of the style sheet: 0 to 1 each

function readPalette() {
  const style = getComputedStyle(document.documentElement);
  for (const name of ["free", "ground", "separate", "within", "colliding", "undecided", "accent", "ink", "paper", "soft", "line", "band"])
    palette[name] = new THREE.Color(style.getPropertyValue("--" + name).trim());
}

const turned = `vec3 turned(vec4 q, vec3 v) { return v + 2.0 * cross(q.xyz, cross(q.xyz, v) + q.w * v); }\n`;
const bodyVertex = turned + `
attribute vec3 iPosition; attribute vec4 iTurn, iTint, iNumber;
uniform vec3 low, size;
varying vec3 vNormal, vEye; varying vec4 vTint, vNumber;
void main() {
  vec4 at = viewMatrix * vec4(iPosition + turned(iTurn, low + size * position), 1.0);
  vNormal = mat3(viewMatrix) * turned(iTurn, normal);
  vEye = at.xyz; vTint = iTint; vNumber = iNumber;
  gl_Position = projectionMatrix * at;
}`;
const shading = `
uniform vec3 up, accent; uniform float night;
varying vec3 vNormal, vEye; varying vec4 vTint, vNumber;
vec3 shaded(vec3 n, vec3 tint) {
  vec3 eye = normalize(-vEye), key = normalize(up * 0.9 + vec3(-0.45, 0.0, 0.55));
  float sky = 0.5 + 0.5 * dot(n, up), lit = max(dot(n, key), 0.0), front = max(dot(n, eye), 0.0);
  vec3 c = tint * (mix(0.42, 0.30, night) + 0.26 * sky + 0.42 * lit + 0.10 * front);
  c += 0.10 * pow(max(dot(n, normalize(key + eye)), 0.0), 24.0);
  return c;
}`;
const uniforms = {up: {value: new THREE.Vector3()}, accent: {value: new THREE.Color()}, night: {value: 0}};

function bodyMaterial(model, ghost) {
  return new THREE.ShaderMaterial({
    vertexShader: bodyVertex,
    fragmentShader: shading + (ghost ? `
void main() {
  vec3 n = normalize(vNormal); if (!gl_FrontFacing) n = -n;
  float rim = pow(1.0 - abs(dot(n, normalize(vEye))), 2.0);
  gl_FragColor = vec4(shaded(n, vTint.rgb), vTint.a * mix(0.35, 1.0, rim));
}` : `
void main() {
  vec3 n = normalize(vNormal); if (!gl_FrontFacing) n = -n;
  vec3 tint = vTint.rgb;
  if (vTint.a < 0.75 && mod(gl_FragCoord.x + gl_FragCoord.y, 12.0) < 4.5) tint = mix(tint, vec3(1.0), 0.6);
  vec3 c = shaded(n, tint);
  float rim = pow(1.0 - abs(dot(n, normalize(vEye))), 2.0);
  c = mix(c, accent, vNumber.w * (0.15 + 0.85 * smoothstep(0.2, 0.75, rim)));
  gl_FragColor = vec4(c, 1.0);
}`),
    uniforms: {...uniforms, low: {value: new THREE.Vector3(...model.low)},
               size: {value: new THREE.Vector3(...model.high).sub(new THREE.Vector3(...model.low))}},
    side: THREE.DoubleSide, transparent: ghost, depthWrite: !ghost});
}
const pickFragment = `varying vec4 vNumber; void main() { gl_FragColor = vec4(vNumber.xyz, 1.0); }`;

// Corners of all triangles with normals, smooth but at edges that turn by more than 35 degrees.
function surfaceOf(geometry, level) {
  const model = header.geometries[geometry], [vertices, triangles] = model.meshes[level], columns = new Columns(`m${geometry}.${level}`);
  const wide = vertices > 65536 && columns.take(Uint32Array, 3 * triangles);
  const at = columns.take(Uint16Array, 3 * vertices), index = wide || columns.take(Uint16Array, 3 * triangles);
  const size = model.high.map((x, k) => x - model.low[k]), face = new Float32Array(3 * triangles), first = new Uint32Array(vertices + 1);
  for (let t = 0; t < triangles; ++t) {
    const [p, q, r] = [index[3 * t] * 3, index[3 * t + 1] * 3, index[3 * t + 2] * 3];
    const u = [0, 1, 2].map((k) => (at[q + k] - at[p + k]) * size[k]), v = [0, 1, 2].map((k) => (at[r + k] - at[p + k]) * size[k]);
    face[3 * t] = u[1] * v[2] - u[2] * v[1], face[3 * t + 1] = u[2] * v[0] - u[0] * v[2], face[3 * t + 2] = u[0] * v[1] - u[1] * v[0];
    for (let k = 0; k < 3; ++k) ++first[index[3 * t + k] + 1];
  }
  for (let v = 0; v < vertices; ++v) first[v + 1] += first[v];
  const next = first.slice(), around = new Uint32Array(3 * triangles);
  for (let c = 0; c < 3 * triangles; ++c) around[next[index[c]]++] = (c / 3) | 0;
  const position = new Uint16Array(12 * triangles), normal = new Int8Array(12 * triangles), length = new Float32Array(triangles);
  for (let t = 0; t < triangles; ++t) length[t] = Math.hypot(face[3 * t], face[3 * t + 1], face[3 * t + 2]) || 1e-30;
  for (let c = 0; c < 3 * triangles; ++c) {
    const t = (c / 3) | 0, v = index[c];
    let x = 0, y = 0, z = 0;
    for (let k = first[v]; k < first[v + 1]; ++k) {
      const f = around[k], dot = face[3 * t] * face[3 * f] + face[3 * t + 1] * face[3 * f + 1] + face[3 * t + 2] * face[3 * f + 2];
      if (f === t || dot > 0.82 * length[t] * length[f]) x += face[3 * f], y += face[3 * f + 1], z += face[3 * f + 2];
    }
    const l = 127 / (Math.hypot(x, y, z) || 1);
    for (let k = 0; k < 3; ++k) position[4 * c + k] = at[3 * v + k];
    normal[4 * c] = x * l, normal[4 * c + 1] = y * l, normal[4 * c + 2] = z * l;
  }
  return {position, normal, triangles};
}

// Instances of one level of one geometry.
class Batch {
  constructor(surface, model, ghost) {
    this.surface = surface, this.count = 0, this.room = 0;
    this.shape = new THREE.InstancedBufferGeometry();
    this.shape.setAttribute("position", surface.positions), this.shape.setAttribute("normal", surface.normals);
    this.material = bodyMaterial(model, ghost);
    this.mesh = new THREE.Mesh(this.shape, this.material);
    this.mesh.frustumCulled = false, this.mesh.matrixAutoUpdate = false;
    (ghost ? ghosts : solids).add(this.mesh);
  }
  grow() {
    const old = this.attributes;
    this.room = Math.max(16, 2 * this.room);
    this.attributes = [[Float32Array, 3, false], [Int16Array, 4, true], [Uint8Array, 4, true], [Uint8Array, 4, true]].map(([Type, size, scaled], k) => {
      const array = new Type(size * this.room);
      if (old) array.set(old[k].array);
      return new THREE.InstancedBufferAttribute(array, size, scaled).setUsage(THREE.DynamicDrawUsage);
    });
    // A new geometry: three.js keeps the buffers of the old one until it is disposed of.
    this.shape.dispose();
    ["iPosition", "iTurn", "iTint", "iNumber"].forEach((name, k) => this.shape.setAttribute(name, this.attributes[k]));
  }
  add(b, red, green, blue, alpha) {
    if (this.count === this.room) this.grow();
    const [position, turn, tint, number] = this.attributes, i = this.count++;
    for (let k = 0; k < 3; ++k) position.array[3 * i + k] = bodies.position[3 * b + k];
    for (let k = 0; k < 4; ++k) turn.array[4 * i + k] = bodies.turn[4 * b + k];
    tint.array[4 * i] = red, tint.array[4 * i + 1] = green, tint.array[4 * i + 2] = blue, tint.array[4 * i + 3] = alpha;
    const n = b + 1;
    number.array[4 * i] = n & 255, number.array[4 * i + 1] = (n >> 8) & 255, number.array[4 * i + 2] = n >> 16;
    number.array[4 * i + 3] = environment[b] ? 0 : 255 * bodies.selected[b];
  }
  flush() {
    this.mesh.visible = this.count > 0;
    this.shape.maxInstancedCount = this.count;
    if (!this.count) return;
    for (const a of this.attributes) a.needsUpdate = true, a.updateRange.count = this.count * a.itemSize;
  }
}

const batches = []; // by geometry, then [level of solids..., level of ghosts...]
function batchOf(geometry, level, ghost) {
  const model = header.geometries[geometry], levels = model.meshes.length, all = (batches[geometry] = batches[geometry] || []);
  const k = level + (ghost ? levels : 0);
  if (all[k]) return all[k];
  const other = all[level + (ghost ? 0 : levels)];
  let surface = other && other.surface;
  if (!surface) {
    surface = surfaceOf(geometry, level);
    surface.positions = new THREE.BufferAttribute(surface.position, 4, true);
    surface.normals = new THREE.BufferAttribute(surface.normal, 4, true);
  }
  return (all[k] = new Batch(surface, model, ghost));
}

// How finely bodies are drawn: 1 is as finely as can be, less where the browser does not keep up.
let quality = 1;
const frustum = new THREE.Frustum(), matrix = new THREE.Matrix4(), sphere = new THREE.Sphere();
let drawnBodies = 0, drawnTriangles = 0;

// @param look  look(body) says how: {hidden} or {ghost, colour: [r, g, b] 0 to 255, alpha}
function gatherBodies(look) {
  for (const all of batches) if (all) for (const batch of all) if (batch) batch.count = 0;
  matrix.multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse);
  frustum.setFromMatrix(matrix);
  const perMetre = (renderer.domElement.clientHeight / 2) / Math.tan((camera.fov * Math.PI) / 360);
  const {x, y, z} = camera.position;
  drawnBodies = drawnTriangles = 0;
  // Few bodies are all shown as finely as can be.
  const few = quality === 1 && bodies.count < 64, scale = perMetre * Math.min(quality, bodies.count > 2000 ? 0.6 : 1);
  for (let b = 0; b < bodies.count; ++b) {
    const how = look(b);
    if (how.hidden) continue;
    const g = bodies.geometry[b], mx = bodies.middle[3 * b], my = bodies.middle[3 * b + 1], mz = bodies.middle[3 * b + 2];
    sphere.center.set(mx, my, mz), sphere.radius = bodies.radius[b];
    if (!frustum.intersectsSphere(sphere)) continue;
    const meshes = header.geometries[g].meshes, pixels = (scale * bodies.radius[b]) / Math.max(Math.hypot(mx - x, my - y, mz - z) - bodies.radius[b], 1e-9);
    let level = 0;
    if (!few && !bodies.selected[b])
      while (level + 1 < meshes.length && pixels * pixels * 0.5 < meshes[level][1]) ++level;
    batchOf(g, level, how.ghost).add(b, how.colour[0], how.colour[1], how.colour[2], how.alpha);
    ++drawnBodies, drawnTriangles += meshes[level][1];
  }
  for (const all of batches) if (all) for (const batch of all) if (batch) batch.flush();
}

// The body at a place of the canvas, in pixels; -1: none.
const pickTarget = new THREE.WebGLRenderTarget(1, 1), pickMaterials = new Map();
function bodyAt(px, py) {
  const width = canvas.clientWidth, height = canvas.clientHeight, bytes = new Uint8Array(4);
  for (const all of batches) if (all) for (const batch of all) {
    if (!batch || !batch.mesh.visible) continue;
    if (!pickMaterials.has(batch)) {
      const material = batch.material.clone();
      material.uniforms = batch.material.uniforms, material.fragmentShader = pickFragment;
      material.transparent = false, material.depthWrite = true;
      pickMaterials.set(batch, material);
    }
    batch.mesh.material = pickMaterials.get(batch);
  }
  camera.setViewOffset(width, height, px, py, 1, 1);
  renderer.setRenderTarget(pickTarget);
  renderer.setClearColor(0, 0), renderer.clear(), renderer.render(solids, camera);
  renderer.readRenderTargetPixels(pickTarget, 0, 0, 1, 1, bytes);
  renderer.setRenderTarget(null);
  camera.clearViewOffset();
  for (const all of batches) if (all) for (const batch of all) if (batch) batch.mesh.material = batch.material;
  return bytes[0] + (bytes[1] << 8) + (bytes[2] << 16) - 1;
}
