// Drawings between and around bodies: lines, marks, spheres, boxes, regions, the ground.

// Marks, lines, spheres: copies of a shape with few vertices.
class Instances {
  // @param index  null: vertices are points
  constructor(scene, corners, index, columns, material) {
    this.columns = Object.entries(columns);
    this.copies = new Copies(new THREE.BufferAttribute(new Float32Array(corners), 3), null, index, columns);
    material.vertexShader = this.copies.shader(material.vertexShader);
    material.uniforms = {...material.uniforms, ...this.copies.uniforms};
    this.mesh = index ? new THREE.Mesh(this.copies.shape, material) : new THREE.Points(this.copies.shape, material);
    this.mesh.frustumCulled = false, this.mesh.visible = false;
    addTo(scene, this.mesh);
  }
  // @param values  by column: the values of all copies
  set(count, values) {
    this.count = count;
    if (count) this.copies.makeRoom(count);
    this.columns.forEach(([name, size], column) => {
      const from = values[name], to = this.copies.numbers, n = this.columns.length;
      for (let i = 0; i < count; ++i) for (let k = 0; k < size; ++k) to[4 * (n * i + column) + k] = from[size * i + k];
    });
    this.copies.show(this.mesh, count);
  }
}
const quad = [-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0], quadIndex = [0, 1, 2, 0, 2, 3];

// Lines with a width in pixels. A colour's fourth number is its opacity; below 0: dashed.
function makeLines(scene, width, over) {
  return new Instances(scene, [0, -1, 0, 1, -1, 0, 1, 1, 0, 0, 1, 0], quadIndex, {iFrom: 3, iTo: 3, iColour: 4}, new THREE.ShaderMaterial({
    vertexShader: `
uniform vec2 screen; uniform float width;
varying vec4 vColour; varying float vAlong;
void main() {
  vec4 a = viewMatrix * vec4(iFrom, 1.0), b = viewMatrix * vec4(iTo, 1.0);
  float near = -0.001;
  if (a.z > near && b.z < near) a = mix(a, b, (a.z - near) / (a.z - b.z));
  else if (b.z > near && a.z < near) b = mix(b, a, (b.z - near) / (b.z - a.z));
  vec4 p = projectionMatrix * a, q = projectionMatrix * b;
  vec2 s = p.xy / p.w * screen, t = q.xy / q.w * screen, along = t - s;
  float l = length(along);
  along = l > 1e-6 ? along / l : vec2(1.0, 0.0);
  gl_Position = mix(p, q, position.x);
  gl_Position.xy += vec2(-along.y, along.x) * position.y * width / screen * gl_Position.w;
  gl_Position.xy += along * (2.0 * position.x - 1.0) * 0.5 * width / screen * gl_Position.w;
  vColour = iColour; vAlong = l * position.x * 0.5;
}`,
    fragmentShader: `varying vec4 vColour; varying float vAlong;
void main() { if (vColour.a < 0.0 && mod(vAlong, 9.0) > 5.0) discard; gl_FragColor = vec4(vColour.rgb, abs(vColour.a)); }`,
    uniforms: {screen, width: {value: width}}, transparent: true, depthTest: !over, depthWrite: false}));
}

// Discs of constant size on the screen, drawn over everything.
function makeMarks(scene) {
  return new Instances(scene, [0, 0, 0], null, {iAt: 3, iColour: 3, iSize: 1}, new THREE.ShaderMaterial({
    vertexShader: `
uniform vec2 screen, pixels;
varying vec3 vColour; varying float vSize;
void main() {
  gl_Position = projectionMatrix * viewMatrix * vec4(iAt, 1.0);
  vSize = iSize * max(pixels.y / screen.y, 0.5), vColour = iColour, gl_PointSize = 2.0 * vSize;
}`,
    fragmentShader: `
varying vec3 vColour; varying float vSize; uniform vec3 edge; uniform float rim;
void main() {
  float r = length(2.0 * gl_PointCoord - 1.0), w = 1.3 / vSize;
  if (r > 1.0) discard;
  vec3 c = mix(vColour, edge, (vSize > 6.0 ? 1.0 : rim) * smoothstep(1.0 - 3.0 * w, 1.0 - 2.0 * w, r));
  gl_FragColor = vec4(c, 1.0 - smoothstep(1.0 - w, 1.0, r));
}`,
    uniforms: {screen, pixels: drawnPixels, rim: {value: 1}, edge: {value: new THREE.Color(1, 1, 1)}}, transparent: true, depthTest: false, depthWrite: false}));
}

// Spheres: squares on which each pixel intersects its ray with the sphere. Opacity below 1: only the rim is visible.
function makeBalls(scene, solid) {
  return new Instances(scene, quad, quadIndex, {iBall: 4, iColour: 4}, new THREE.ShaderMaterial({
    vertexShader: `
varying vec3 vAt; varying vec4 vBall, vColour;
void main() {
  vec3 c = (viewMatrix * vec4(iBall.xyz, 1.0)).xyz;
  float d = length(c), r = iBall.w;
  // A square that faces the eye and covers the sphere. From inside: a square in front of the eye.
  vec3 n = d > 1.05 * r ? -c / d : vec3(0.0, 0.0, 1.0);
  vec3 side = normalize(cross(abs(n.y) < 0.9 ? vec3(0.0, 1.0, 0.0) : vec3(1.0, 0.0, 0.0), n)), above = cross(n, side);
  float half_ = d > 1.05 * r ? r * d / sqrt(d * d - r * r) : 2.0 * r;
  vAt = (d > 1.05 * r ? c : vec3(0.0, 0.0, -r)) + half_ * (side * position.x + above * position.y);
  vBall = vec4(c, r); vColour = iColour;
  gl_Position = projectionMatrix * vec4(vAt, 1.0);
}`,
    fragmentShader: shading + `
varying vec3 vAt; varying vec4 vBall, vColour; uniform mat4 projection;
void main() {
  vec3 ray = normalize(vAt);
  float b = dot(ray, vBall.xyz), c = dot(vBall.xyz, vBall.xyz) - vBall.w * vBall.w, h = b * b - c;
  if (h < 0.0) discard;
  float t = b - sqrt(h); if (t < 0.0) t = b + sqrt(h);
  if (t < 0.0) discard;
  vec3 at = ray * t, n = (at - vBall.xyz) / vBall.w;
  vec4 clip = projection * vec4(at, 1.0);
  gl_FragDepthEXT = 0.5 + 0.5 * clip.z / clip.w;
  float rim = 1.0 - abs(dot(n, ray));
  gl_FragColor = vec4(shaded(n, -ray, vColour.rgb), ${solid ? "1.0" : "vColour.a * (0.12 + 0.88 * rim * rim)"});
}`,
    uniforms: {...uniforms, projection: {value: camera.projectionMatrix}}, transparent: !solid, depthWrite: solid}));
}

// Boxes of any orientation; without `solid` only their edges are visible.
function makeBoxes(scene, solid) {
  const corners = [], index = [];
  for (let k = 0; k < 8; ++k) corners.push(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1);
  for (const f of [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]) index.push(f[0], f[1], f[2], f[0], f[2], f[3]);
  return new Instances(scene, corners, index, {iMiddle: 3, iHalf: 3, iTurn: 4, iColour: 4}, new THREE.ShaderMaterial({
    vertexShader: turned + `
varying vec3 vAt, vEye; varying vec4 vColour;
void main() {
  vec4 at = viewMatrix * vec4(iMiddle + turned(iTurn, iHalf * position), 1.0);
  vAt = position; vEye = at.xyz; vColour = iColour;
  gl_Position = projectionMatrix * at;
}`,
    fragmentShader: shading + `
varying vec3 vAt, vEye; varying vec4 vColour;
void main() {
  vec3 n = normalize(cross(dFdx(vEye), dFdy(vEye))), eye = normalize(-vEye); if (dot(n, eye) < 0.0) n = -n;
  vec3 edge = (1.0 - abs(vAt)) / max(fwidth(vAt), 1e-5);
  float second = max(min(edge.x, edge.y), min(max(edge.x, edge.y), edge.z)); // the nearest one is the face itself
  float line = 1.0 - smoothstep(0.6, 1.6, second);
  gl_FragColor = ${solid ? "vec4(mix(shaded(n, eye, vColour.rgb), vColour.rgb * 0.35, line), 1.0)" : "vec4(vColour.rgb, vColour.a * (0.06 + 0.94 * line))"};
}`,
    uniforms, transparent: !solid, depthWrite: solid, side: THREE.DoubleSide}));
}

const linkLines = makeLines(lines, 2.2, true), curveLines = makeLines(lines, 3.2, true);
const placeMarks = makeMarks(marks), boundBalls = makeBalls(lines, false);
boundBalls.mesh.material.depthTest = false; // they are small, and between bodies

// Edges of axis-aligned boxes, one pixel wide.
const regionLines = new THREE.LineSegments(new THREE.BufferGeometry(), new THREE.LineBasicMaterial({vertexColors: THREE.VertexColors, transparent: true, opacity: 0.75, depthWrite: false}));
regionLines.frustumCulled = false;
addTo(volumes, regionLines);
function showRegions(frame, on, level) {
  const at = [], colour = [], edges = [0, 1, 2, 3, 4, 5, 6, 7, 0, 2, 1, 3, 4, 6, 5, 7, 0, 4, 1, 5, 2, 6, 3, 7];
  for (let r = 0; on && r < frame.header.regions; ++r) {
    if (level >= 0 && frame.level[r] !== level) continue;
    const c = frame.rejected[r] ? palette.soft : palette.accent, box = frame.regions.subarray(6 * r, 6 * r + 6);
    for (const k of edges) at.push(box[k & 1 ? 3 : 0], box[k & 2 ? 4 : 1], box[k & 4 ? 5 : 2]), colour.push(c.r, c.g, c.b);
  }
  const shape = new THREE.BufferGeometry();
  shape.setAttribute("position", new THREE.BufferAttribute(new Float32Array(at), 3));
  shape.setAttribute("color", new THREE.BufferAttribute(new Float32Array(colour), 3));
  regionLines.geometry.dispose();
  regionLines.geometry = shape, regionLines.visible = at.length > 0;
}

// The background, and a ground grid whose spacing follows the scale.
const backdrop = new THREE.Mesh(new THREE.PlaneBufferGeometry(2, 2), new THREE.ShaderMaterial({
  vertexShader: "varying vec2 vAt; void main() { vAt = position.xy; gl_Position = vec4(position.xy, 1.0, 1.0); }",
  fragmentShader: `varying vec2 vAt; uniform vec3 inner, outer;
void main() { float d = length(vAt * vec2(0.8, 1.0) - vec2(0.0, 0.15)); gl_FragColor = vec4(mix(inner, outer, smoothstep(0.1, 1.5, d)), 1.0); }`,
  uniforms: {inner: {value: new THREE.Color()}, outer: {value: new THREE.Color()}}, depthTest: false, depthWrite: false}));
backdrop.frustumCulled = false;
const grid = new THREE.Mesh(new THREE.PlaneBufferGeometry(2, 2), new THREE.ShaderMaterial({
  vertexShader: `uniform vec3 middle; uniform float reach; varying vec2 vAt; varying vec2 vOff;
void main() { vOff = position.xy; vec3 at = middle + vec3(position.xy * reach, 0.0); vAt = at.xy; gl_Position = projectionMatrix * viewMatrix * vec4(at, 1.0); }`,
  fragmentShader: `uniform vec3 line; uniform float cell; varying vec2 vAt, vOff;
float lines(float c) { vec2 p = vAt / c, w = fwidth(p), d = abs(fract(p - 0.5) - 0.5) / max(w, 1e-6); return (1.0 - min(min(d.x, d.y), 1.0)) * (1.0 - smoothstep(0.2, 0.6, max(w.x, w.y))); }
void main() { gl_FragColor = vec4(line, (0.25 * lines(cell) + 0.6 * lines(10.0 * cell)) * (1.0 - smoothstep(0.25, 1.0, length(vOff)))); }`,
  uniforms: {middle: {value: new THREE.Vector3()}, reach: {value: 1}, cell: {value: 1}, line: {value: new THREE.Color()}},
  transparent: true, depthWrite: false, side: THREE.DoubleSide}));
grid.frustumCulled = false;
addTo(ground, backdrop), addTo(ground, grid);

function paletteChanged(dark) {
  readPalette();
  uniforms.night.value = dark ? 1 : 0, uniforms.accent.value.copy(palette.accent);
  backdrop.material.uniforms.inner.value.set(dark ? "#232c37" : "#fbfcfd"), backdrop.material.uniforms.outer.value.set(dark ? "#0b0f14" : "#ccd6df");
  grid.material.uniforms.line.value.set(dark ? "#5f7082" : "#8a99a8");
  placeMarks.mesh.material.uniforms.edge.value.set(dark ? "#0e1319" : "#ffffff");
}

// Links between the bodies of pairs, marks at the pairs, and spheres with the bounds as radius.
// @param shown  shown(p): true if pair p is visible  @param chosen  the selected pair or -1
function showPairs(frame, options, shown, chosen) {
  const from = [], to = [], colour = [], at = [], markColour = [], size = [], ball = [], ballColour = [];
  const visible = [];
  for (let p = 0; p < frame.pairs; ++p) if (shown(p)) visible.push(p);
  const crowd = visible.length > 600, small = crowd ? 2 : visible.length > 400 ? 3.5 : visible.length > 60 ? 5 : 6.5;
  placeMarks.mesh.material.uniforms.rim.value = crowd ? 0 : 1;
  for (const p of visible) {
    const c = palette[VERDICTS[frame.verdict[p]]], a = frame.a[p], b = frame.b[p], x = frame.where[3 * p], y = frame.where[3 * p + 1], z = frame.where[3 * p + 2];
    const line = frame.verdict[p] === 2 ? 0.95 : -0.9;
    if ((options.links && !crowd) || p === chosen)
      for (const body of [a, b]) {
        if (environment[body]) continue; // its centre may be kilometres away
        from.push(bodies.middle[3 * body], bodies.middle[3 * body + 1], bodies.middle[3 * body + 2]), to.push(x, y, z), colour.push(c.r, c.g, c.b, p === chosen ? Math.sign(line) : line);
      }
    if (options.links || p === chosen) at.push(x, y, z), markColour.push(c.r, c.g, c.b), size.push(p === chosen ? 9 : small);
    if ((options.bounds || p === chosen) && frame.known[p] && frame.bound[p] > 0 && isFinite(frame.bound[p]))
      ball.push(x, y, z, frame.bound[p]), ballColour.push(c.r, c.g, c.b, 0.85);
  }
  linkLines.set(from.length / 3, {iFrom: from, iTo: to, iColour: colour});
  placeMarks.set(size.length, {iAt: at, iColour: markColour, iSize: size});
  boundBalls.set(ball.length / 4, {iBall: ball, iColour: ballColour});

  const cFrom = [], cTo = [], cColour = [], {r, g, b} = palette.ink;
  for (let k = 0; options.curves && k < frame.header.curve; ++k) {
    if (!shown(frame.ofCurve[k])) continue;
    const c = frame.curve;
    cFrom.push(c[6 * k], c[6 * k + 1], c[6 * k + 2]), cTo.push(c[6 * k + 3], c[6 * k + 4], c[6 * k + 5]), cColour.push(r, g, b, 1);
  }
  curveLines.set(cFrom.length / 3, {iFrom: cFrom, iTo: cTo, iColour: cColour});
}
