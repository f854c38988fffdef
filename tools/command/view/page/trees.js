// The trees of the selected bodies, level by level: which volumes of one touch volumes of the other.
const solidBalls = makeBalls(volumes, true), faintBalls = makeBalls(volumes, false);
const solidBoxes = makeBoxes(volumes, true), faintBoxes = makeBoxes(volumes, false);

const trees = new Map();
// Columns of a geometry's tree: kind is "spheres" or "boxes".
function treeOf(geometry, kind) {
  const list = header.geometries[geometry][kind], id = kind[0] + geometry;
  if (!list) return null;
  if (trees.has(id)) return trees.get(id);
  const columns = new Columns(id), count = list.reduce((n, l) => n + l[0], 0), tree = {levels: []};
  tree.centre = columns.take(Float32Array, 3 * count);
  if (kind === "boxes") tree.half = columns.take(Float32Array, 3 * count), tree.turn = columns.take(Int16Array, 4 * count);
  let first = 0;
  for (const [n, error, radius] of list) tree.levels.push({first, count: n, error, radius}), first += n;
  trees.set(id, tree);
  return tree;
}
function deepestLevel(geometry, kind) {
  const list = header.geometries[geometry][kind];
  return list ? list.length - 1 : -1;
}

// A level's volumes in the world: centres, radii around them; for boxes also half-extents and axes.
function volumesOf(body, kind, level) {
  const g = bodies.geometry[body], tree = treeOf(g, kind);
  if (!tree) return null;
  const l = tree.levels[Math.min(level, tree.levels.length - 1)], p = bodies.position, n = l.count;
  const out = {count: n, error: l.error, centre: new Float32Array(3 * n), radius: new Float32Array(n), boxes: kind === "boxes"};
  for (let i = 0; i < n; ++i) {
    const k = l.first + i;
    place(bodies.turn, body, tree.centre.subarray(3 * k, 3 * k + 3), p[3 * body], p[3 * body + 1], p[3 * body + 2], out.centre, 3 * i);
    out.radius[i] = out.boxes ? Math.hypot(...tree.half.subarray(3 * k, 3 * k + 3)) : l.radius;
  }
  if (!out.boxes) return out;
  out.half = tree.half.subarray(3 * l.first, 3 * (l.first + n)), out.turn = new Float32Array(4 * n), out.axes = new Float32Array(9 * n);
  const whole = new THREE.Quaternion(...bodies.turn.subarray(4 * body, 4 * body + 4)).normalize(), q = new THREE.Quaternion(), axis = new THREE.Vector3();
  for (let i = 0; i < n; ++i) {
    const k = l.first + i;
    q.set(...tree.turn.subarray(4 * k, 4 * k + 4)).normalize().premultiply(whole);
    q.toArray(out.turn, 4 * i);
    for (let a = 0; a < 3; ++a) axis.setComponent(0, a === 0).setComponent(1, a === 1).setComponent(2, a === 2).applyQuaternion(q).toArray(out.axes, 9 * i + 3 * a);
  }
  return out;
}

// Separating-axis test on fifteen axes: false if two boxes are certainly more than `gap` apart.
function boxesTouch(a, i, b, j, gap) {
  const d = [0, 1, 2].map((k) => b.centre[3 * j + k] - a.centre[3 * i + k]), A = a.axes.subarray(9 * i, 9 * i + 9), B = b.axes.subarray(9 * j, 9 * j + 9);
  const reach = (x, y, z) => {
    let r = 0;
    for (let k = 0; k < 3; ++k)
      r += a.half[3 * i + k] * Math.abs(A[3 * k] * x + A[3 * k + 1] * y + A[3 * k + 2] * z) + b.half[3 * j + k] * Math.abs(B[3 * k] * x + B[3 * k + 1] * y + B[3 * k + 2] * z);
    return r + gap >= Math.abs(d[0] * x + d[1] * y + d[2] * z);
  };
  for (let k = 0; k < 9; k += 3) if (!reach(A[k], A[k + 1], A[k + 2]) || !reach(B[k], B[k + 1], B[k + 2])) return false;
  for (let k = 0; k < 9; k += 3)
    for (let m = 0; m < 9; m += 3) {
      const x = A[k + 1] * B[m + 2] - A[k + 2] * B[m + 1], y = A[k + 2] * B[m] - A[k] * B[m + 2], z = A[k] * B[m + 1] - A[k + 1] * B[m], l = Math.hypot(x, y, z);
      if (l > 1e-6 && !reach(x / l, y / l, z / l)) return false;
    }
  return true;
}

// Marks the volumes of both sides that touch a volume of the other side; sorted along x, so that each is compared with few.
function findTouching(a, b, gap) {
  a.touching = new Uint8Array(a.count), b.touching = new Uint8Array(b.count);
  const order = Array.from({length: b.count}, (_, k) => k).sort((p, q) => b.centre[3 * p] - b.centre[3 * q]);
  const largest = b.radius.reduce((m, r) => Math.max(m, r), 0);
  for (let i = 0; i < a.count; ++i) {
    const x = a.centre[3 * i], far = a.radius[i] + largest + gap;
    let low = 0, high = order.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      b.centre[3 * order[middle]] < x - far ? (low = middle + 1) : (high = middle);
    }
    for (; low < order.length && b.centre[3 * order[low]] <= x + far; ++low) {
      const j = order[low], r = a.radius[i] + b.radius[j] + gap;
      if (a.touching[i] && b.touching[j]) continue;
      const dx = b.centre[3 * j] - x, dy = b.centre[3 * j + 1] - a.centre[3 * i + 1], dz = b.centre[3 * j + 2] - a.centre[3 * i + 2];
      if (dx * dx + dy * dy + dz * dz <= r * r && (!a.boxes || boxesTouch(a, i, b, j, gap))) a.touching[i] = b.touching[j] = 1;
    }
  }
}

const treeColours = ["#3f8fd2", "#e0993a"]; // of the first and the second body
// Draws the volumes. Returns {counts: [volumes, touching] per body, errors}; null: there are none.
// `level` applies to the smaller body. A larger one uses a deeper level, with volumes of about the same size, if it has one.
function showTrees(chosen, kind, level) {
  const smallest = Math.min(...chosen.map((b) => bodies.radius[b])), more = chosen.map((b) => Math.max(0, Math.round(Math.log2(bodies.radius[b] / smallest) / (kind === "boxes" ? 1.5 : 1))));
  const sides = kind === "none" ? [] : chosen.map((body, k) => volumesOf(body, kind, level + more[k]));
  const there = sides.filter((s) => s), solid = {n: 0, c: [], h: [], t: [], colour: []}, faint = {n: 0, c: [], h: [], t: [], colour: []};
  if (there.length === 2) findTouching(there[0], there[1], header.clearance);
  sides.forEach((s, side) => {
    if (!s) return;
    const own = new THREE.Color(treeColours[side]), hot = palette.colliding;
    for (let i = 0; i < s.count; ++i) {
      const touches = s.touching && s.touching[i], to = (touches || there.length < 2) && !environment[chosen[side]] ? solid : faint, c = touches ? own.clone().lerp(hot, 0.6) : own;
      if (environment[chosen[side]] && !touches) continue; // the volumes of a whole landscape would hide the rest
      ++to.n, to.c.push(s.centre[3 * i], s.centre[3 * i + 1], s.centre[3 * i + 2]);
      if (s.boxes) to.h.push(...s.half.subarray(3 * i, 3 * i + 3)), to.t.push(...s.turn.subarray(4 * i, 4 * i + 4));
      else to.c.push(s.radius[i]);
      to.colour.push(c.r, c.g, c.b, s.count > 600 ? 0.35 : 0.6);
    }
  });
  const boxes = kind === "boxes";
  for (const [instances, set] of [[solidBalls, solid], [faintBalls, faint]]) instances.set(boxes ? 0 : set.n, {iBall: set.c, iColour: set.colour});
  for (const [instances, set] of [[solidBoxes, solid], [faintBoxes, faint]])
    instances.set(boxes ? set.n : 0, {iMiddle: set.c, iHalf: set.h, iTurn: set.t, iColour: set.colour});
  if (!there.length) return null;
  return {counts: sides.map((s) => s && [s.count, s.touching ? s.touching.reduce((n, t) => n + t, 0) : -1]), errors: sides.map((s) => s && s.error)};
}
