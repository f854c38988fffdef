// Where the CPU draws, small bodies are drawn here: a software renderer takes about ten times as long for their pixels. Each body
// is copied from a picture of its geometry, seen from the nearest of 144 directions. The directions are the cells of an unfolded
// octahedron; pictures hold normals, and 0 outside the body.
const SIDES = 12, SIDE_PIXELS = 32;
const sideAxes = Array.from({length: SIDES * SIDES}, (_, side) => { // axes of that view: right, up, towards the eye
  const u = ((side % SIDES) + 0.5) * (2 / SIDES) - 1, v = (Math.floor(side / SIDES) + 0.5) * (2 / SIDES) - 1, w = 1 - Math.abs(u) - Math.abs(v);
  const sign = (x) => (x < 0 ? -1 : 1), d = new THREE.Vector3(u, v, w);
  if (w < 0) d.set((1 - Math.abs(v)) * sign(u), (1 - Math.abs(u)) * sign(v), w);
  d.normalize();
  const right = new THREE.Vector3(Math.abs(d.z) < 0.9 ? 0 : 1, 0, Math.abs(d.z) < 0.9 ? 1 : 0).cross(d).normalize();
  return [right, d.clone().cross(right), d];
});
function sideTowards(x, y, z) {
  const l = 1 / (Math.abs(x) + Math.abs(y) + Math.abs(z)), cell = (a) => Math.min(SIDES - 1, Math.floor((0.5 + 0.5 * a) * SIDES));
  const u = x * l, v = y * l, au = 1 - Math.abs(v), av = 1 - Math.abs(u);
  return z < 0 ? cell(u < 0 ? -au : au) + SIDES * cell(v < 0 ? -av : av) : cell(u) + SIDES * cell(v);
}

// Pictures of a geometry from all directions: normals, 8 bits per component (128: 0), and the extent of its box right, up and to the eye.
function picturesOf(geometry) {
  const {low, high, meshes} = header.geometries[geometry], level = Math.max(0, meshes.findIndex((m) => m[1] < 1500)), count = SIDES * SIDES;
  const {positions, normals, index} = surfaceAt(geometry, level), copies = new Copies(positions, normals, index, {iRight: 3, iAbove: 3, iSide: 3, iCell: 2});
  const half = high.map((x, k) => Math.max(0.5 * (x - low[k]), 1e-9)), reach = new Float32Array(3 * count), size = SIDES * SIDE_PIXELS;
  copies.makeRoom(count);
  sideAxes.forEach((axes, side) => {
    axes.forEach((axis, k) => {
      reach[3 * side + k] = Math.abs(axis.x) * half[0] + Math.abs(axis.y) * half[1] + Math.abs(axis.z) * half[2];
      axis.clone().divideScalar(reach[3 * side + k]).toArray(copies.numbers, 16 * side + 4 * k);
    });
    copies.numbers.set([side % SIDES, Math.floor(side / SIDES)], 16 * side + 12);
  });
  const mesh = new THREE.Mesh(copies.shape, new THREE.ShaderMaterial({
    vertexShader: copies.shader(`
uniform vec3 size;
varying vec3 vNormal, vSide;
void main() {
  vec3 at = size * (position - 0.5);
  vNormal = normal, vSide = iSide;
  gl_Position = vec4((iCell + 0.5 + ${(0.5 - 1 / SIDE_PIXELS).toFixed(6)} * vec2(dot(at, iRight), dot(at, iAbove))) * ${(2 / SIDES).toFixed(8)} - 1.0, -0.999 * dot(at, iSide), 1.0);
}`),
    fragmentShader: "varying vec3 vNormal, vSide; void main() { vec3 n = normalize(vNormal); gl_FragColor = vec4(128.0 + 127.0 * faceforward(n, -vSide, n), 255.0) / 255.0; }",
    uniforms: {...copies.uniforms, ...boxUniforms(header.geometries[geometry])}, side: THREE.DoubleSide}));
  copies.show(mesh, count), (mesh.frustumCulled = false);
  const only = new THREE.Scene(), target = new THREE.WebGLRenderTarget(size, size), bytes = new Uint8Array(4 * size * size);
  only.add(mesh);
  renderer.setRenderTarget(target), renderer.setClearColor(0, 0), renderer.clear(), renderer.render(only, camera);
  renderer.readRenderTargetPixels(target, 0, 0, size, size, bytes), renderer.setRenderTarget(null);
  target.dispose(), copies.uniforms.data.value.dispose(), copies.shape.dispose(), mesh.material.dispose();
  return {texels: new Uint32Array(bytes.buffer), reach};
}

// Numbers 0 to count - 1 sorted by `far`, approximately, nearest first.
function nearestFirst(far, count) {
  const BINS = 2048, starts = new Uint32Array(BINS + 1), order = new Uint32Array(count);
  let least = Infinity, most = 0;
  for (let i = 0; i < count; ++i) least = Math.min(least, far[i]), most = Math.max(most, far[i]);
  const scale = (BINS - 1) / Math.max(most - least, 1e-9), bin = (i) => Math.floor((far[i] - least) * scale);
  for (let i = 0; i < count; ++i) ++starts[bin(i) + 1];
  for (let k = 0; k < BINS; ++k) starts[k + 1] += starts[k];
  for (let i = 0; i < count; ++i) order[starts[bin(i)]++] = i;
  return order;
}

class Sprites {
  constructor() {
    this.count = 0, this.triangles = 2, this.pictures = [];
    this.body = new Uint32Array(bodies.count), this.far = new Float32Array(bodies.count), this.tint = new Uint8Array(4 * bodies.count);
    // Only geometries of many bodies get pictures, which take time and memory.
    const users = header.geometries.map(() => 0);
    for (const g of bodies.geometry) ++users[g];
    this.shown = new Set([...users.keys()].filter((g) => users[g] >= 16 && !header.geometries[g].deforms).sort((g, h) => users[h] - users[g]).slice(0, 48));
    this.seen = {}, this.colours = new Uint32Array(0), this.depths = new Float32Array(0); // per pixel of the view, from the bottom row
    this.uniforms = {colours: {value: null}, depths: {value: null}};
    this.mesh = new THREE.Mesh(new THREE.PlaneBufferGeometry(2, 2), new THREE.ShaderMaterial({
      vertexShader: "void main() { gl_Position = vec4(position.xy, 0.0, 1.0); }",
      fragmentShader: `
uniform sampler2D colours; uniform highp sampler2D depths; uniform mat4 projectionMatrix;
void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  float z = -texelFetch(depths, at, 0).r;
  if (z < -9e29) discard;
  gl_FragDepthEXT = 0.5 - 0.5 * (projectionMatrix[2][2] * z + projectionMatrix[3][2]) / z;
  gl_FragColor = vec4(texelFetch(colours, at, 0).rgb, 1.0);
}`,
      uniforms: {...this.uniforms, projectionMatrix: {value: camera.projectionMatrix}}}));
    this.mesh.frustumCulled = this.mesh.visible = false;
    addTo(solids, this.mesh);
  }
  // @param pixels  the body's radius
  show(body, pixels) {
    return drawsOnCpu && pixels < manner.sprites && this.shown.has(bodies.geometry[body]);
  }
  begin() {
    const {x: width, y: height} = drawnPixels.value;
    this.count = 0;
    if (this.colours.length !== width * height) {
      this.colours = new Uint32Array(width * height), this.depths = new Float32Array(width * height);
      for (const {value} of Object.values(this.uniforms)) if (value) value.dispose();
      const table = (numbers, format, type) => new THREE.DataTexture(numbers, width, height, format, type);
      this.uniforms.colours.value = table(new Uint8Array(this.colours.buffer), THREE.RGBAFormat, THREE.UnsignedByteType);
      this.uniforms.depths.value = table(this.depths, THREE.RedFormat, THREE.FloatType);
    }
    this.depths.fill(1e30);
    const v = camera.matrixWorldInverse.elements, sun = new THREE.Vector3(-0.45, 0, 0.55).addScaledVector(uniforms.up.value, 0.9).normalize();
    this.view = v, this.width = width, this.height = height;
    this.perMetre = (0.5 * height) / Math.tan((camera.fov * Math.PI) / 360); // pixels per metre at a distance of 1 m
    const world = (c) => [0, 4, 8].map((row) => v[row] * c.x + v[row + 1] * c.y + v[row + 2] * c.z); // of a direction in the camera's frame
    this.sun = world(sun), this.right = [v[0], v[4], v[8]];
  }
  add(b, red, green, blue, alpha, far) {
    const i = this.count++;
    this.body[i] = b, this.far[i] = far;
    this.tint[4 * i] = red, this.tint[4 * i + 1] = green, this.tint[4 * i + 2] = blue, this.tint[4 * i + 3] = alpha;
  }
  flush() {
    for (const i of nearestFirst(this.far, this.count)) this.draw(this.body[i], this.tint[4 * i], this.tint[4 * i + 1], this.tint[4 * i + 2], this.tint[4 * i + 3]);
    this.mesh.visible = this.count > 0;
    if (this.count) for (const {value} of Object.values(this.uniforms)) value.needsUpdate = true;
  }
  // Where a body is in the view, which texels of its picture lie there, and how its normals are lit.
  see(b) {
    const g = bodies.geometry[b], {texels, reach} = (this.pictures[g] = this.pictures[g] || picturesOf(g)), m = this.view, seen = this.seen, s = 1 / 32767;
    const mx = bodies.middle[3 * b], my = bodies.middle[3 * b + 1], mz = bodies.middle[3 * b + 2];
    const depth = -(m[2] * mx + m[6] * my + m[10] * mz + m[14]), scale = this.perMetre / depth;
    // The body's axes in the world frame, and the directions to the eye, right and up in the body's frame.
    const qx = bodies.turn[4 * b] * s, qy = bodies.turn[4 * b + 1] * s, qz = bodies.turn[4 * b + 2] * s, qw = bodies.turn[4 * b + 3] * s;
    const ax = 1 - 2 * (qy * qy + qz * qz), ay = 2 * (qx * qy + qw * qz), az = 2 * (qx * qz - qw * qy);
    const bx = 2 * (qx * qy - qw * qz), by = 1 - 2 * (qx * qx + qz * qz), bz = 2 * (qy * qz + qw * qx);
    const cx = 2 * (qx * qz + qw * qy), cy = 2 * (qy * qz - qw * qx), cz = 1 - 2 * (qx * qx + qy * qy);
    const dx = camera.position.x - mx, dy = camera.position.y - my, dz = camera.position.z - mz, d = 1 / Math.hypot(dx, dy, dz);
    const ex = d * (ax * dx + ay * dy + az * dz), ey = d * (bx * dx + by * dy + bz * dz), ez = d * (cx * dx + cy * dy + cz * dz);
    const side = sideTowards(ex, ey, ez), [right, above] = sideAxes[side], [rx, ry, rz] = this.right, [sx, sy, sz] = this.sun;
    let ux = ax * rx + ay * ry + az * rz, uy = bx * rx + by * ry + bz * rz, uz = cx * rx + cy * ry + cz * rz;
    const along = ux * ex + uy * ey + uz * ez;
    ux -= along * ex, uy -= along * ey, uz -= along * ez;
    const l = 1 / Math.hypot(ux, uy, uz);
    ux *= l, uy *= l, uz *= l;
    const vx = ey * uz - ez * uy, vy = ez * ux - ex * uz, vz = ex * uy - ey * ux;
    const xu = ux * right.x + uy * right.y + uz * right.z, xv = ux * above.x + uy * above.y + uz * above.z;
    const yu = vx * right.x + vy * right.y + vz * right.z, yv = vx * above.x + vy * above.y + vz * above.z;

    const reachU = reach[3 * side], reachV = reach[3 * side + 1], texelsU = (SIDE_PIXELS / 2 - 1) / (scale * reachU), texelsV = (SIDE_PIXELS / 2 - 1) / (scale * reachV);
    seen.texels = texels, seen.first = (side % SIDES) * SIDE_PIXELS + Math.floor(side / SIDES) * SIDE_PIXELS * SIDE_PIXELS * SIDES;
    seen.x = 0.5 * this.width + scale * (m[0] * mx + m[4] * my + m[8] * mz + m[12]);
    seen.y = 0.5 * this.height + scale * (m[1] * mx + m[5] * my + m[9] * mz + m[13]);
    seen.halfX = scale * (Math.abs(xu) * reachU + Math.abs(xv) * reachV), seen.halfY = scale * (Math.abs(yu) * reachU + Math.abs(yv) * reachV);
    seen.uByX = texelsU * xu || 1e-9, seen.vByX = texelsV * xv || 1e-9, seen.uByY = texelsU * yu, seen.vByY = texelsV * yv;
    seen.near = Math.max(depth - reach[3 * side + 2], 1e-9);
    // light() of the shaders; normals are 127 long
    const soft = 1 / 127, key = 0.42 / 127;
    seen.softX = soft * (0.13 * az + 0.1 * ex), seen.softY = soft * (0.13 * bz + 0.1 * ey), seen.softZ = soft * (0.13 * cz + 0.1 * ez);
    seen.keyX = key * (ax * sx + ay * sy + az * sz), seen.keyY = key * (bx * sx + by * sy + bz * sz), seen.keyZ = key * (cx * sx + cy * sy + cz * sz);
    return seen;
  }
  draw(b, red, green, blue, alpha) {
    const {texels, first, x, y, halfX, halfY, uByX, vByX, uByY, vByY, near, softX, softY, softZ, keyX, keyY, keyZ} = this.see(b);
    const {colours, depths, width} = this, base = 0.55 - 0.12 * uniforms.night.value, tiny = halfX < 0.75 && halfY < 0.75;
    const left = Math.max(0, Math.floor(x - halfX)), right = Math.min(width - 1, Math.floor(x + halfX));
    const low = Math.max(0, Math.floor(y - halfY)), high = Math.min(this.height - 1, Math.floor(y + halfY));
    for (let row = low; row <= high; ++row) {
      const away = row + 0.5 - y, u0 = SIDE_PIXELS / 2 + uByX * (0.5 - x) + uByY * away, v0 = SIDE_PIXELS / 2 + vByX * (0.5 - x) + vByY * away;
      let from = left, to = right;
      if (!tiny) { // the part of the row that is on the picture
        const u1 = -u0 / uByX, u2 = (SIDE_PIXELS - u0) / uByX, v1 = -v0 / vByX, v2 = (SIDE_PIXELS - v0) / vByX;
        from = Math.max(from, Math.ceil(Math.max(Math.min(u1, u2), Math.min(v1, v2)))), to = Math.min(to, Math.floor(Math.min(Math.max(u1, u2), Math.max(v1, v2))));
      }
      for (let column = from, pixel = row * width + from; column <= to; ++column, ++pixel) {
        if (depths[pixel] <= near) continue;
        let bright = base + 0.3;
        if (!tiny) {
          const n = texels[first + ((u0 + uByX * column) | 0) + ((v0 + vByX * column) | 0) * (SIDE_PIXELS * SIDES)];
          if (!n) continue;
          const nx = (n & 255) - 128, ny = ((n >> 8) & 255) - 128, nz = ((n >> 16) & 255) - 128, lit = nx * keyX + ny * keyY + nz * keyZ;
          bright = base + nx * softX + ny * softY + nz * softZ + (lit > 0 ? lit : 0);
        }
        const white = alpha < 191 && (column + row) % 12 < 4.5 ? 153 : 0, own = white ? 0.4 : 1; // stripes
        const r = bright * (own * red + white), g = bright * (own * green + white), blu = bright * (own * blue + white);
        depths[pixel] = near;
        colours[pixel] = (r > 255 ? 255 : r) | ((g > 255 ? 255 : g) << 8) | ((blu > 255 ? 255 : blu) << 16);
      }
    }
  }
}
const sprites = new Sprites();
