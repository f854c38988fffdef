// The data of a run: a header in JSON, and columns of numbers, decoded on first use.
const header = JSON.parse(document.getElementById("header").textContent);
const VERDICTS = ["separate", "within", "colliding", "undecided"]; // by number
const KINDS = ["", "near", "touching", "crossing", "enclosed"];

// All bodies, by number: their state in the frame that is shown.
const bodies = (() => {
  const count = header.bodies, columns = new Columns("bodies");
  const geometry = columns.take(Uint32Array, count), moving = columns.take(Uint32Array, header.moving);
  const position = columns.take(Float32Array, 3 * count), turn = columns.take(Int16Array, 4 * count);
  const fixed = columns.take(Uint8Array, count);
  return {count, geometry, moving, position, turn, fixed,
          middle: new Float32Array(3 * count),  // centre of its box
          radius: new Float32Array(count),      // around that centre
          verdict: new Uint8Array(count),       // of its worst pair: 0 none, else rank
          selected: new Uint8Array(count)};
})();
const RANKS = ["free", "separate", "within", "undecided", "colliding"]; // of bodies, best first
const RANK_OF_VERDICT = [1, 2, 4, 3];

function measure(g) {
  g.middle = g.low.map((x, k) => (x + g.high[k]) / 2);
  g.radius = Math.hypot(...g.low.map((x, k) => (g.high[k] - x) / 2));
}
for (const g of header.geometries) if (g.low) measure(g);
const deforming = header.geometries.filter((g) => g.deforms);
for (let b = 0; b < bodies.count; ++b) bodies.radius[b] = header.geometries[bodies.geometry[b]].radius;

// Static bodies that are much larger than the dynamic ones: buildings, terrains. They stay grey; marks show contacts.
const environment = (() => {
  const sizes = [];
  for (let b = 0; b < bodies.count; ++b) if (!bodies.fixed[b]) sizes.push(bodies.radius[b]);
  sizes.sort((a, b) => a - b);
  const usual = sizes.length ? sizes[sizes.length >> 1] : Infinity, is = new Uint8Array(bodies.count);
  for (let b = 0; b < bodies.count; ++b) is[b] = bodies.fixed[b] && bodies.radius[b] > 6 * usual;
  return is;
})();

function nameOf(body) {
  return (header.names && header.names[body]) || "body " + body;
}

// Rotates v by quaternion k of `turn` (16-bit components) and adds an offset; writes out[o..o+2].
function place(turn, k, v, x, y, z, out, o) {
  const s = 1 / 32767, qx = turn[4 * k] * s, qy = turn[4 * k + 1] * s, qz = turn[4 * k + 2] * s, qw = turn[4 * k + 3] * s;
  const [vx, vy, vz] = v;
  const tx = 2 * (qy * vz - qz * vy), ty = 2 * (qz * vx - qx * vz), tz = 2 * (qx * vy - qy * vx);
  out[o] = x + vx + qw * tx + qy * tz - qz * ty;
  out[o + 1] = y + vy + qw * ty + qz * tx - qx * tz;
  out[o + 2] = z + vz + qw * tz + qx * ty - qy * tx;
}

function findMiddle(b) {
  const p = bodies.position;
  place(bodies.turn, b, header.geometries[bodies.geometry[b]].middle, p[3 * b], p[3 * b + 1], p[3 * b + 2], bodies.middle, 3 * b);
}
for (let b = 0; b < bodies.count; ++b) findMiddle(b);

const decoded = new Map(); // the last few frames
function frameAt(k) {
  if (decoded.has(k)) return decoded.get(k);
  const h = header.frames[k], c = new Columns("f" + k), m = header.moving, n = h.pairs;
  const boxes = c.take(Float64Array, 6 * deforming.length);
  const frame = {boxes, position: c.take(Float32Array, 3 * m), a: c.take(Uint32Array, n), b: c.take(Uint32Array, n),
    bound: c.take(Float32Array, n), error: c.take(Float32Array, n), where: c.take(Float32Array, 3 * n),
    nearest: c.take(Float32Array, n), apart: c.take(Float32Array, n), times: c.take(Float32Array, h.swept ? 2 * n : 0), curve: c.take(Float32Array, 6 * h.curve),
    ofCurve: c.take(Uint32Array, h.curve), regions: c.take(Float32Array, 6 * h.regions), turn: c.take(Int16Array, 4 * m),
    vertices: deforming.map((g) => c.take(Uint16Array, 3 * g.meshes[0][0])),
    verdict: c.take(Uint8Array, n), stage: c.take(Uint8Array, n), kind: c.take(Uint8Array, n),
    level: c.take(Uint8Array, h.regions), rejected: c.take(Uint8Array, h.regions),
    worst: c.take(Uint8Array, h.left_out ? header.bodies : 0), header: h, pairs: n}; // worst: ranks of all bodies where pairs are left out
  findPlaces(frame);
  decoded.set(k, frame);
  if (decoded.size > 12) decoded.delete(decoded.keys().next().value);
  return frame;
}

// Records which positions are known; the others get one between the two bodies when the frame is shown.
function findPlaces(frame) {
  frame.known = new Uint8Array(frame.pairs);
  frame.where = new Float32Array(frame.where);
  for (let p = 0; p < frame.pairs; ++p) frame.known[p] = isFinite(frame.where[3 * p]);
}

// Moves the vertices of meshes that deform, and the bodies to their poses in this frame.
function showFrame(frame) {
  const {moving, position, turn, verdict, middle, radius} = bodies;
  deforming.forEach((g, i) => {
    g.low = [...frame.boxes.subarray(6 * i, 6 * i + 3)], g.high = [...frame.boxes.subarray(6 * i + 3, 6 * i + 6)];
    g.vertices = frame.vertices[i], measure(g);
  });
  for (let i = 0; i < moving.length; ++i) {
    const b = moving[i];
    for (let k = 0; k < 3; ++k) position[3 * b + k] = frame.position[3 * i + k];
    for (let k = 0; k < 4; ++k) turn[4 * b + k] = frame.turn[4 * i + k];
    findMiddle(b);
  }
  for (let b = 0; b < (deforming.length ? bodies.count : 0); ++b) {
    const g = header.geometries[bodies.geometry[b]];
    if (g.deforms) (radius[b] = g.radius), findMiddle(b);
  }
  verdict.fill(0), verdict.set(frame.worst);
  for (let p = 0; p < frame.pairs; ++p) {
    const rank = RANK_OF_VERDICT[frame.verdict[p]], a = frame.a[p], b = frame.b[p];
    verdict[a] = Math.max(verdict[a], rank), verdict[b] = Math.max(verdict[b], rank);
    if (frame.known[p]) continue;
    const share = radius[a] / (radius[a] + radius[b]), near = radius[a] > 6 * radius[b] ? 1 : radius[b] > 6 * radius[a] ? 0 : share;
    for (let k = 0; k < 3; ++k) frame.where[3 * p + k] = middle[3 * a + k] * (1 - near) + middle[3 * b + k] * near;
  }
}

function lengthText(length) { // in the scene's unit
  const metres = length * header.metres;
  if (!isFinite(metres)) return "unknown";
  const x = Math.abs(metres), digits = (v) => (v >= 100 ? v.toFixed(0) : v >= 10 ? v.toFixed(1).replace(/\.0$/, "") : v.toPrecision(3).replace(/(\.\d*?)0+$/, "$1").replace(/\.$/, ""));
  if (x === 0) return "0";
  if (x >= 1000) return digits(metres / 1000) + " km";
  if (x >= 1) return digits(metres) + " m";
  if (x >= 1e-3) return digits(metres * 1e3) + " mm";
  if (x >= 1e-6) return digits(metres * 1e6) + " µm";
  return metres.toExponential(1) + " m";
}
function timeText(ms) {
  if (ms === null) return "?";
  return ms >= 1000 ? (ms / 1000).toFixed(2) + " s" : ms >= 100 ? ms.toFixed(0) + " ms" : ms >= 1 ? ms.toPrecision(3) + " ms" : (ms >= 0.01 ? (1000 * ms).toFixed(0) : (1000 * ms).toFixed(1)) + " µs";
}
const grouped = (n) => Math.round(n).toLocaleString("en");
