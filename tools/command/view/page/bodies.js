// Bodies: copies of meshes. The level of detail is chosen for each picture.
const canvas = document.getElementById("scene");
const gl = canvas.getContext("webgl2", {antialias: false, alpha: false, powerPreference: "high-performance"});
if (!gl) throw new Error("This page needs WebGL 2, which this browser does not offer.");
const renderer = new THREE.WebGLRenderer({canvas, context: gl});
renderer.autoClear = false;
const camera = new THREE.PerspectiveCamera(42, 1, 0.1, 1000);
camera.up.set(0, 0, 1);
// Layers, drawn from back to front.
const scene = new THREE.Scene(), [ground, solids, volumes, ghosts, lines, marks] = Array.from({length: 6}, () => new THREE.Scene());
scene.add(ground, solids, volumes, ghosts, lines, marks);
const addTo = (layer, mesh) => (layer.add(mesh), (mesh.renderOrder = scene.children.indexOf(layer)));
// True if the CPU draws in place of a GPU.
const drawsOnCpu = (() => {
  const named = gl.getExtension("WEBGL_debug_renderer_info");
  return /swiftshader|llvmpipe|softpipe|software|basic render/i.test(gl.getParameter(named ? named.UNMASKED_RENDERER_WEBGL : gl.RENDERER));
})();
const screen = {value: new THREE.Vector2(1, 1)}, drawnPixels = {value: new THREE.Vector2(1, 1)}; // the view's size in CSS pixels, and in drawn pixels
let palette = {}; // colours by name in the style sheet; components 0 to 1

function readPalette() {
  const style = getComputedStyle(document.documentElement);
  for (const name of ["free", "ground", "separate", "within", "colliding", "undecided", "accent", "ink", "paper", "soft", "line", "band"])
    palette[name] = new THREE.Color(style.getPropertyValue("--" + name).trim());
}

const turned = `vec3 turned(vec4 q, vec3 v) { return v + 2.0 * cross(q.xyz, cross(q.xyz, v) + q.w * v); }\n`;
const bodyVaryings = "varying vec3 vNormal, vEye; varying vec4 vTint, vNumber;\n";
const bodyVertex = turned + bodyVaryings + `
uniform vec3 low, size;
void main() {
  vec4 at = viewMatrix * vec4(iPosition + turned(iTurn, low + size * position), 1.0);
  vNormal = mat3(viewMatrix) * turned(iTurn, normal);
  vEye = at.xyz; vTint = iTint; vNumber = iNumber;
  gl_Position = projectionMatrix * at;
}`;
// @param n, eye  the normal, and the direction to the eye, in the camera's frame
const shading = `
uniform vec3 up, accent; uniform float night;
vec3 keyLight() { return normalize(up * 0.9 + vec3(-0.45, 0.0, 0.55)); }
float light(float sky, float lit, float front) {
  return mix(0.42, 0.30, night) + 0.26 * (0.5 + 0.5 * sky) + 0.42 * max(lit, 0.0) + 0.10 * max(front, 0.0);
}
vec3 shaded(vec3 n, vec3 eye, vec3 tint) {
  vec3 key = keyLight();
  return tint * light(dot(n, up), dot(n, key), dot(n, eye)) + 0.10 * pow(max(dot(n, normalize(key + eye)), 0.0), 24.0);
}
vec3 chosen(vec3 c, vec3 n, vec3 eye, float is) {
  return mix(c, accent, is * (0.15 + 0.85 * smoothstep(0.2, 0.75, pow(1.0 - abs(dot(n, eye)), 2.0))));
}`;
const stripes = `
vec3 striped(vec4 tint) { return tint.a < 0.75 && mod(gl_FragCoord.x + gl_FragCoord.y, 12.0) < 4.5 ? mix(tint.rgb, vec3(1.0), 0.6) : tint.rgb; }`;
const uniforms = {up: {value: new THREE.Vector3()}, accent: {value: new THREE.Color()}, night: {value: 0}};

function bodyMaterial(model, ghost, copies) {
  return new THREE.ShaderMaterial({
    vertexShader: copies.shader(bodyVertex),
    fragmentShader: bodyVaryings + shading + (ghost ? `
void main() {
  vec3 n = normalize(vNormal), eye = normalize(-vEye); if (!gl_FrontFacing) n = -n;
  float rim = pow(1.0 - abs(dot(n, eye)), 2.0);
  gl_FragColor = vec4(shaded(n, eye, vTint.rgb), vTint.a * mix(0.35, 1.0, rim));
}` : stripes + `
void main() {
  vec3 n = normalize(vNormal), eye = normalize(-vEye); if (!gl_FrontFacing) n = -n;
  gl_FragColor = vec4(chosen(shaded(n, eye, striped(vTint)), n, eye, vNumber.w), 1.0);
}`),
    uniforms: {...uniforms, ...copies.uniforms, ...boxUniforms(model)}, side: THREE.DoubleSide, transparent: ghost, depthWrite: !ghost});
}
// The same, shaded only at vertices: a quarter of the work where the CPU draws.
function plainMaterial(model, copies) {
  return new THREE.ShaderMaterial({
    vertexShader: copies.shader(turned + shading + `
uniform vec3 low, size;
varying vec4 vColour;
void main() {
  vec4 at = viewMatrix * vec4(iPosition + turned(iTurn, low + size * position), 1.0);
  vec3 n = normalize(mat3(viewMatrix) * turned(iTurn, normal)), eye = normalize(-at.xyz);
  n = faceforward(n, -eye, n);
  vColour = vec4(chosen(shaded(n, eye, iTint.rgb), n, eye, iNumber.w), iTint.a);
  gl_Position = projectionMatrix * at;
}`),
    fragmentShader: stripes + "varying vec4 vColour; void main() { gl_FragColor = vec4(striped(vColour), 1.0); }",
    uniforms: {...uniforms, ...copies.uniforms, ...boxUniforms(model)}, side: THREE.DoubleSide});
}
// The uniforms of a model, which follow its box if it deforms.
function boxUniforms(model) {
  const own = (model.uniforms = model.uniforms || {low: {value: new THREE.Vector3()}, size: {value: new THREE.Vector3()}});
  own.low.value.set(...model.low), own.size.value.set(...model.high).sub(own.low.value);
  return own;
}
const pickFragment = `varying vec4 vNumber; void main() { gl_FragColor = vec4(vNumber.xyz, 1.0); }`;

// Vertices of all triangles, with smooth normals except at edges of more than 35 degrees.
function surfaceOf(geometry, level) {
  const model = header.geometries[geometry], [vertices, triangles] = model.meshes[level], columns = new Columns(`m${geometry}.${level}`);
  const wide = vertices > 65536 && columns.take(Uint32Array, 3 * triangles);
  const own = columns.take(Uint16Array, 3 * vertices), at = model.vertices || own, index = wide || columns.take(Uint16Array, 3 * triangles);
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
  if (level > 0 && triangles <= 200) { // edges are not visible from afar, and shared vertices cost a third
    const position = new Uint16Array(4 * vertices), normal = new Int8Array(4 * vertices);
    for (let v = 0; v < vertices; ++v) {
      let sum = [0, 0, 0], largest = 0;
      for (let k = first[v]; k < first[v + 1]; ++k) {
        const own = face.subarray(3 * around[k], 3 * around[k] + 3);
        sum = sum.map((x, a) => x + own[a]), largest = Math.max(largest, Math.hypot(...own));
      }
      if (Math.hypot(...sum) < 0.1 * largest) sum = [...face.subarray(3 * around[first[v]], 3 * around[first[v]] + 3)]; // opposite faces of a thin sheet
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

// Numbers for shaders, four per texel.
function tableOf(numbers, columns) {
  const texture = new THREE.DataTexture(numbers, columns, numbers.length / (4 * columns), THREE.RGBAFormat, THREE.FloatType);
  texture.minFilter = texture.magFilter = THREE.NearestFilter, texture.generateMipmaps = false, texture.unpackAlignment = 4;
  texture.needsUpdate = true;
  return texture;
}

// Many copies of a small shape. Their data is in a texture. Each GPU instance draws as many copies as have about a thousand
// vertices, because instances of a few triangles are slow, most of all where the CPU draws them.
class Copies {
  // @param columns  {name: size}, size 1 to 4: the data of a copy, by its name in shaders
  constructor(position, normal, index, columns) {
    this.columns = Object.entries(columns), this.room = 0, this.corners = position.count;
    this.copies = Math.max(1, Math.floor(4096 / this.corners));
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
  renew(name, attribute) {
    const own = this.shape.attributes[name];
    for (let k = 0; k < this.copies; ++k) own.array.set(attribute.array, k * attribute.array.length);
    own.needsUpdate = true;
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
    this.uniforms.data.value = tableOf(this.numbers, 1024);
  }
  show(mesh, count) {
    mesh.visible = count > 0, this.uniforms.count.value = count;
    this.shape.maxInstancedCount = Math.ceil(count / this.copies);
    if (count) this.uniforms.data.value.needsUpdate = true;
  }
}

// Bodies that are drawn in the same way.
const bodyColumns = {iPosition: 3, iTurn: 4, iTint: 4, iNumber: 4};
class Drawer {
  constructor(copies, layer) {
    this.copies = copies, this.count = 0;
    this.mesh = new THREE.Mesh(copies.shape);
    this.mesh.frustumCulled = false, this.mesh.matrixAutoUpdate = false;
    addTo(layer, this.mesh);
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

// Bodies drawn with the same level of the same geometry.
class Batch extends Drawer {
  constructor(geometry, level, ghost) {
    const surface = surfaceAt(geometry, level), model = header.geometries[geometry];
    super(new Copies(surface.positions, surface.normals, surface.index, bodyColumns), ghost ? ghosts : solids);
    this.model = model, this.geometry = geometry, this.surface = surface, this.triangles = surface.triangles;
    this.fine = bodyMaterial(model, ghost, this.copies), this.plain = ghost ? this.fine : plainMaterial(model, this.copies);
  }
  // Takes the vertices of the frame that is shown.
  deform() {
    boxUniforms(this.model);
    const surface = surfaceAt(this.geometry, 0);
    if (surface === this.surface) return;
    this.surface = surface;
    this.copies.renew("position", surface.positions), this.copies.renew("normal", surface.normals);
  }
  flush() {
    super.flush();
    if (this.model.deforms && this.count) this.deform();
    this.mesh.material = manner.plain ? this.plain : this.fine;
  }
}

// All batches of a geometry share a surface; a mesh that deforms has another surface in each frame.
const surfaces = new Map(); // by geometry and level
function surfaceAt(geometry, level) {
  const id = geometry + "." + level, known = surfaces.get(id), {vertices} = header.geometries[geometry];
  if (known && known.vertices === vertices) return known;
  const surface = surfaceOf(geometry, level);
  surface.vertices = vertices, surfaces.set(id, surface);
  surface.positions = new THREE.BufferAttribute(surface.position, 4, true);
  surface.normals = new THREE.BufferAttribute(surface.normal, 4, true);
  surface.triangles = header.geometries[geometry].meshes[level][1];
  return surface;
}

const batches = []; // by geometry, then [levels of solids..., levels of ghosts...]
function batchOf(geometry, level, ghost) {
  const levels = header.geometries[geometry].meshes.length, all = (batches[geometry] = batches[geometry] || []);
  const k = level + (ghost ? levels : 0);
  return (all[k] = all[k] || new Batch(geometry, level, ghost));
}

// Drawing quality: the first row at rest, otherwise as far down the list as needed to keep up.
// pixels: drawn per screen pixel, along a side; detail: triangles of a body relative to its size on the screen; smooth: edges; plain: shaded
// only at vertices; sprites: where the CPU draws, bodies below this radius (in pixels) are copied from pictures.
const MANNERS = [
  {pixels: 1, detail: 1.2, smooth: true, plain: false, sprites: 12},
  {pixels: 1, detail: 0.7, smooth: false, plain: false, sprites: 24},
  {pixels: 1, detail: 0.5, smooth: false, plain: true, sprites: 24},
  {pixels: 0.7, detail: 0.3, smooth: false, plain: true, sprites: 24},
  {pixels: 0.5, detail: 0.2, smooth: false, plain: true, sprites: 24},
  {pixels: 0.4, detail: 0.1, smooth: false, plain: true, sprites: 24}];
let manner = MANNERS[0];
const frustum = new THREE.Frustum(), matrix = new THREE.Matrix4(), sphere = new THREE.Sphere();
let drawnBodies = 0, drawnTriangles = 0;

// @param look  look(body) returns {hidden} or {ghost, colour: [r, g, b] 0 to 255, alpha}
function gatherBodies(look) {
  for (const batch of batches.flat()) if (batch) batch.count = 0;
  sprites.begin();
  matrix.multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse);
  frustum.setFromMatrix(matrix);
  const perMetre = (renderer.domElement.clientHeight / 2) / Math.tan((camera.fov * Math.PI) / 360);
  const {x, y, z} = camera.position;
  drawnBodies = drawnTriangles = 0;
  const few = manner === MANNERS[0] && bodies.count < 64; // all at the finest level
  for (let b = 0; b < bodies.count; ++b) {
    const how = look(b);
    if (how.hidden) continue;
    const g = bodies.geometry[b], mx = bodies.middle[3 * b], my = bodies.middle[3 * b + 1], mz = bodies.middle[3 * b + 2];
    sphere.center.set(mx, my, mz), sphere.radius = bodies.radius[b];
    if (!frustum.intersectsSphere(sphere)) continue;
    const far = Math.hypot(mx - x, my - y, mz - z), pixels = (perMetre * bodies.radius[b]) / Math.max(far - bodies.radius[b], 1e-9);
    let to = sprites;
    if (how.ghost || bodies.selected[b] || !sprites.show(b, pixels)) {
      const meshes = header.geometries[g].meshes, fine = manner.detail * pixels;
      let level = 0;
      if (!few && !bodies.selected[b])
        while (level + 1 < meshes.length && fine * fine < meshes[level][1]) ++level;
      to = batchOf(g, level, how.ghost);
    }
    to.add(b, how.colour[0], how.colour[1], how.colour[2], how.alpha, far);
  }
  for (const drawer of [sprites, ...batches.flat()]) {
    if (!drawer) continue;
    drawer.flush();
    drawnBodies += drawer.count, drawnTriangles += drawer.count * drawer.triangles;
  }
}

// Edges are smooth where the scene is drawn with four samples per pixel.
const samples = new THREE.WebGLMultisampleRenderTarget(1, 1, {format: THREE.RGBAFormat, stencilBuffer: true}); // with 24 bits of depth
const sheet = new THREE.Mesh(new THREE.PlaneBufferGeometry(2, 2), new THREE.ShaderMaterial({
  vertexShader: "varying vec2 vAt; void main() { vAt = uv; gl_Position = vec4(position.xy, 0.0, 1.0); }",
  fragmentShader: "varying vec2 vAt; uniform sampler2D drawn; void main() { gl_FragColor = texture2D(drawn, vAt); }",
  uniforms: {drawn: {value: samples.texture}}, depthTest: false, depthWrite: false}));
sheet.frustumCulled = false;
function render() {
  if (manner.smooth) samples.setSize(drawnPixels.value.x, drawnPixels.value.y);
  renderer.setRenderTarget(manner.smooth ? samples : null);
  renderer.clear(), renderer.render(scene, camera);
  if (manner.smooth) renderer.setRenderTarget(null), renderer.render(sheet, camera);
}

// The body at a position on the canvas, in pixels; -1: none.
const pickTarget = new THREE.WebGLRenderTarget(1, 1, {stencilBuffer: true}), pickMaterials = new Map();
function bodyAt(px, py, look) {
  const width = canvas.clientWidth, height = canvas.clientHeight, bytes = new Uint8Array(4);
  const usual = manner;
  manner = {...MANNERS[0], sprites: 0}, gatherBodies(look), (manner = usual);
  for (const batch of batches.flat()) {
    if (!batch || !batch.mesh.visible) continue;
    if (!pickMaterials.has(batch)) {
      const material = batch.fine.clone();
      material.uniforms = batch.fine.uniforms, material.fragmentShader = pickFragment;
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
  return bytes[0] + (bytes[1] << 8) + (bytes[2] << 16) - 1;
}
