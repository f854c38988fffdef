// Two meshes: one stays, one is dragged, turned, or comes from a file.
import { boxMesh, load, OncollideError, pose, sphereMesh, torusKnotMesh, torusMesh, Verdict, World } from '../lib/index.mjs';
import { facets, onDrag, Orbit, Painter } from './gl.mjs';

const samples = {
  knot: () => torusKnotMesh(2, 3, 1, 0.42, 0.16, 5000),
  torus: () => torusMesh(0.8, 0.3, 3000),
  sphere: () => sphereMesh(0.7, 2048),
  box: () => boxMesh([0.6, 0.6, 0.6]),
};
const colors = [[0.36, 0.55, 0.85], [0.95, 0.75, 0.3]];
const words = Object.keys(Verdict);

/** Quaternion of a rotation by `angle` about a unit axis, after `q`. */
function turned(q, axis, angle) {
  const s = Math.sin(angle / 2), [x, y, z, w] = [axis[0] * s, axis[1] * s, axis[2] * s, Math.cos(angle / 2)], [a, b, c, d] = q;
  return [w * a + x * d + y * c - z * b, w * b - x * c + y * d + z * a, w * c + x * b - y * a + z * d, w * d - x * a - y * b - z * c];
}

export function pairPage(root) {
  const find = (name) => root.querySelector(`[data-${name}]`);
  const canvas = find('canvas'), painter = new Painter(canvas), camera = new Orbit(8);
  const sides = [{ at: [0, 0, 0], turn: [0, 0, 0, 1] }, { at: [2.8, 0, 0], turn: [0.2, 0.1, 0, 0.97] }];
  const world = new World(); // exact
  let dialled = null, drawn = [], spheres = painter.shape(facetsOfBall(), facetsOfBall()), found = {};

  function facetsOfBall() {
    const ball = sphereMesh(1, 128);
    const { positions } = facets(ball.vertices, ball.faces);
    ball.dispose();
    return positions;
  }
  function put(k, geometry) {
    const side = sides[k], { vertices, faces } = geometry;
    const { min, max } = geometry.bounds, size = Math.hypot(...max.map((number, i) => number - min[i]));
    painter.free(side.shape);
    const { positions, normals } = facets(vertices, faces);
    Object.assign(side, { positions, faces: faces.length / 3, shape: painter.shape(positions, normals), size });
    side.geometry?.dispose();
    side.geometry = geometry;
    side.model = world.models.add(geometry);
    restart();
  }
  /** The second World, whose error is the dial: its sphere-trees grow from nothing. */
  function restart() {
    dialled?.world.dispose();
    dialled = null;
    if (!sides[0].geometry || !sides[1].geometry) return;
    const error = 10 ** Number(find('dial').value);
    const world = new World({ maxError: error, boundingVolume: 'sphere', exact: 'off' });
    dialled = { world, error, models: sides.map((side) => world.models.add(side.geometry)) };
    dialled.bodies = dialled.models.map((model, k) => world.bodies.add(model, pose(sides[k].at, sides[k].turn)));
    find('error').textContent = `${error < 0.1 ? error.toPrecision(1) : error.toFixed(2)} m`;
    update();
  }
  function update() {
    if (!dialled) return;
    const [a, b] = sides.map((side) => ({ model: side.model, pose: pose(side.at, side.turn) }));
    world.pairs.decide(a, b); // trees grow on their first use
    const began = performance.now();
    let repeats = 0;
    do found = world.pairs.decide(a, b), ++repeats;
    while (repeats < 20 && performance.now() - began < 5);
    const micros = (1000 * (performance.now() - began)) / repeats;
    const apart = world.pairs.distance(a, b), meeting = found.verdict === Verdict.colliding ? world.pairs.contacts(a, b) : null;
    dialled.world.bodies.setPose(Float64Array.from(dialled.bodies), Float64Array.from([...a.pose, ...b.pose]));
    const frame = dialled.world.step(), met = frame.met;
    find('verdict').textContent = words[found.verdict];
    find('verdict').dataset.is = words[found.verdict];
    find('distance').textContent = found.verdict === Verdict.colliding ? `${meeting.partA.length} pairs of triangles meet`
      : `${apart.lower.toFixed(6)} to ${apart.upper.toFixed(6)} m apart`;
    find('time').textContent = `${micros < 10 ? micros.toFixed(1) : Math.round(micros)} µs`;
    const rough = met.verdict.length ? `${words[met.verdict[0]]}: at most ${met.bound[0].toFixed(4)} m apart` : 'separate';
    find('dialled').textContent = `${rough}; the two trees hold ${frame.trees.nodes} cells, ${Math.round(frame.trees.bytes / 1000)} kB`;
    for (const shape of drawn) painter.free(shape.shape);
    drawn = [];
    if (meeting) {
      for (const [k, parts] of [[0, meeting.partA], [1, meeting.partB]]) {
        const numbers = [...new Set(parts)], points = new Float32Array(9 * numbers.length);
        numbers.forEach((n, i) => points.set(sides[k].positions.subarray(9 * n, 9 * n + 9), 9 * i));
        drawn.push({ shape: painter.shape(points), pose: k ? b.pose : a.pose, color: [1, 0.1, 0.1], above: true });
      }
    } else {
      const line = [...apart.pointA, ...apart.pointB];
      drawn.push({ shape: painter.shape(line, null, 'LINES'), pose: pose([0, 0, 0]), color: [0.1, 0.8, 0.3], above: true });
      drawn.push({ shape: painter.shape(line, null, 'POINTS'), pose: pose([0, 0, 0]), color: [0.1, 0.8, 0.3], above: true });
    }
    paint();
  }
  function paint() {
    const dark = matchMedia('(prefers-color-scheme: dark)').matches;
    painter.begin(camera.view, dark ? [0.11, 0.12, 0.14] : [0.96, 0.96, 0.97]);
    sides.forEach((side, k) => side.shape && painter.draw(side.shape, [...pose(side.at, side.turn), ...colors[k], 1]));
    for (const { shape, pose, color, above } of drawn) painter.draw(shape, [...pose, ...color, 1], { above });
    if (!find('trees').checked || !dialled) return;
    dialled.models.forEach((model, k) => {
      const { center, radius } = dialled.world.models.spheres(model), place = pose(sides[k].at, sides[k].turn);
      const instances = new Float32Array(20 * radius.length);
      radius.forEach((r, i) => {
        const at = [0, 1, 2].map((row) => place[row] * center[3 * i] + place[4 + row] * center[3 * i + 1] + place[8 + row] * center[3 * i + 2] + place[12 + row]);
        instances.set([r, 0, 0, 0, 0, r, 0, 0, 0, 0, r, 0, ...at, 1, ...colors[k], 0.12], 20 * i);
      });
      painter.draw(spheres, instances);
    });
  }

  // Drags: with one finger or the mouse as the mode says; two fingers and the right button turn the view.
  const move = (dx, dy, mode) => {
    const { right, up, back } = camera.axes, side = sides[1], step = camera.distance / (0.9 * Math.min(canvas.clientWidth, canvas.clientHeight));
    if (mode === 'look') camera.drag(dx, dy), paint();
    else if (mode === 'turn') {
      side.turn = turned(turned(side.turn, up, 0.01 * dx), right, 0.01 * dy);
      update();
    } else {
      side.at = side.at.map((number, k) => number + step * (dx * right[k] - dy * up[k]) + (mode === 'deep' ? -step * dy * back[k] : 0));
      update();
    }
  };
  const mode = () => root.querySelector('[name=mode]:checked').value;
  onDrag(canvas, (dx, dy, pointers, event) =>
    move(dx / pointers, dy / pointers, pointers > 1 || event.buttons & 2 ? 'look' : event.shiftKey ? 'turn' : mode()));
  canvas.addEventListener('contextmenu', (event) => event.preventDefault());
  canvas.addEventListener('wheel', (event) => {
    event.preventDefault();
    camera.distance = Math.max(1, Math.min(60, camera.distance * 1.001 ** event.deltaY));
    paint();
  }, { passive: false });
  canvas.addEventListener('keydown', (event) => {
    const way = { ArrowLeft: [-8, 0], ArrowRight: [8, 0], ArrowUp: [0, -8], ArrowDown: [0, 8] }[event.key];
    if (way) event.preventDefault(), move(...way, event.shiftKey ? 'turn' : event.altKey ? 'look' : mode());
    if (event.key === '+' || event.key === '-') camera.distance *= event.key === '+' ? 0.9 : 1 / 0.9, paint();
  });

  const say = (text) => { find('error-text').textContent = text; };
  async function take(file, k) {
    try {
      put(k, load(file.name, await file.arrayBuffer(), { fitDiagonal: 2, centre: true }));
      sides[1].at = [2.8, 0, 0];
      find(`mesh-${k}`).value = 'file';
      say('');
      restart();
    } catch (error) {
      if (!(error instanceof OncollideError)) throw error;
      say(error.message);
    }
  }
  for (const k of [0, 1]) {
    find(`mesh-${k}`).addEventListener('change', (event) => {
      if (event.target.value === 'file') find(`file-${k}`).click();
      else put(k, samples[event.target.value]());
    });
    find(`file-${k}`).addEventListener('change', (event) => event.target.files[0] && take(event.target.files[0], k));
    put(k, samples[k ? 'torus' : 'knot']());
  }
  root.addEventListener('dragover', (event) => event.preventDefault());
  root.addEventListener('drop', (event) => {
    event.preventDefault();
    [...event.dataTransfer.files].slice(0, 2).forEach((file, i, all) => take(file, all.length === 1 ? 1 : i));
  });
  find('dial').addEventListener('input', restart);
  find('trees').addEventListener('change', paint);
  addEventListener('resize', paint);
  return { sides, update, take, get found() { return found; }, get dialled() { return dialled; } };
}
