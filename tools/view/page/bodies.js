// Bodies: copies of meshes, in levels of detail that are chosen anew for each picture.
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

function bodyMaterial(model, ghost, copies) {
  return new THREE.ShaderMaterial({
    vertexShader: copies.shader(bodyVertex),
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
    uniforms: {...uniforms, ...copies.uniforms, low: {value: new THREE.Vector3(...model.low)},
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
  if (level > 0 && triangles <= 200) { // from afar edges are not seen, and corners that triangles share cost a third
    const position = new Uint16Array(4 * vertices), normal = new Int8Array(4 * vertices);
    for (let v = 0; v < vertices; ++v) {
      const sum = [0, 0, 0];
      for (let k = first[v]; k < first[v + 1]; ++k) for (let a = 0; a < 3; ++a) sum[a] += face[3 * around[k] + a];
      const l = 127 / (Math.hypot(...sum) || 1);
      for (let a = 0; a < 3; ++a) position[4 * v + a] = at[3 * v + a], normal[4 * v + a] = sum[a] * l;
    }
    return {position, normal, index};
  }
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
  return {position, normal, index: null};
}

// Many copies of a small shape, whose numbers are in a texture: each instance that the GPU draws holds as many copies as
// make some thousand corners, since instances of a few triangles are slow, above all where the CPU draws them.
class Copies {
  // @param columns  sizes by name, 1 to 4: what shaders call the numbers of a copy
  constructor(position, normal, index, columns) {
    this.columns = Object.entries(columns), this.room = 0, this.corners = position.count;
    this.copies = Math.max(1, Math.min(256, Math.floor(4096 / this.corners)));
    this.shape = new THREE.InstancedBufferGeometry();
    this.shape.setAttribute("position", this.repeated(position));
    if (normal) this.shape.setAttribute("normal", this.repeated(normal));
    if (index) {
      const all = new Uint32Array(index.length * this.copies);
      for (let i = 0; i < all.length; ++i) all[i] = index[i % index.length] + this.corners * Math.floor(i / index.length);
      this.shape.setIndex(new THREE.BufferAttribute(all, 1));
    }
    this.uniforms = {data: {value: null}, copies: {value: this.copies}, corners: {value: this.corners}, count: {value: 0}};
  }
  repeated(attribute) {
    if (this.copies === 1) return attribute;
    const array = new attribute.array.constructor(attribute.array.length * this.copies);
    for (let k = 0; k < this.copies; ++k) array.set(attribute.array, k * attribute.array.length);
    return new THREE.BufferAttribute(array, attribute.itemSize, attribute.normalized);
  }
  shader(source) {
    return `uniform highp sampler2D data; uniform int copies, corners, count;
int copy() { return gl_InstanceID * copies + gl_VertexID / corners; }
vec4 cell(int column) { int k = copy() * ${this.columns.length} + column; return texelFetch(data, ivec2(k % 1024, k / 1024), 0); }
${this.columns.map(([name, size], k) => `#define ${name} cell(${k})${["", ".x", ".xy", ".xyz", ""][size]}`).join("\n")}
` + source.replace("void main() {", "void main() {\n  if (copy() >= count) { gl_Position = vec4(0.0, 0.0, 2.0, 1.0); return; }");
  }
  makeRoom(count) {
    if (count <= this.room) return;
    const rows = Math.ceil((Math.max(count, 2 * this.room, 16) * this.columns.length) / 1024), old = this.numbers;
    this.numbers = new Float32Array(4096 * rows), this.room = Math.floor((1024 * rows) / this.columns.length);
    if (old) this.numbers.set(old), this.uniforms.data.value.dispose();
    const texture = (this.uniforms.data.value = new THREE.DataTexture(this.numbers, 1024, rows, THREE.RGBAFormat, THREE.FloatType));
    texture.minFilter = texture.magFilter = THREE.NearestFilter, texture.generateMipmaps = false, texture.unpackAlignment = 4;
  }
  show(mesh, count) {
    mesh.visible = count > 0, this.uniforms.count.value = count;
    this.shape.maxInstancedCount = Math.ceil(count / this.copies);
    if (count) this.uniforms.data.value.needsUpdate = true;
  }
}

// The bodies that one level of one geometry is drawn for.
class Batch {
  constructor(surface, model, ghost) {
    this.surface = surface, this.count = 0;
    this.copies = new Copies(surface.positions, surface.normals, surface.index, {iPosition: 3, iTurn: 4, iTint: 4, iNumber: 4});
    this.material = bodyMaterial(model, ghost, this.copies);
    this.mesh = new THREE.Mesh(this.copies.shape, this.material);
    this.mesh.frustumCulled = false, this.mesh.matrixAutoUpdate = false;
    (ghost ? ghosts : solids).add(this.mesh);
  }
  add(b, red, green, blue, alpha) {
    this.copies.makeRoom(this.count + 1);
    const to = this.copies.numbers, o = 16 * this.count++, p = bodies.position, q = bodies.turn, n = b + 1, s = 1 / 255;
    to[o] = p[3 * b], to[o + 1] = p[3 * b + 1], to[o + 2] = p[3 * b + 2];
    for (let k = 0; k < 4; ++k) to[o + 4 + k] = q[4 * b + k] / 32767;
    to[o + 8] = red * s, to[o + 9] = green * s, to[o + 10] = blue * s, to[o + 11] = alpha * s;
    to[o + 12] = (n & 255) * s, to[o + 13] = ((n >> 8) & 255) * s, to[o + 14] = (n >> 16) * s, to[o + 15] = environment[b] ? 0 : bodies.selected[b];
  }
  flush() {
    this.copies.show(this.mesh, this.count);
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
