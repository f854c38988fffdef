// Bodies that drift and turn in a cube; those that collide are red.
import { boxMesh, pose, sphereMesh, torusKnotMesh, torusMesh, World } from '../lib/index.mjs';
import { facets, onDrag, Orbit, Painter } from './gl.mjs';

const side = 30; // metres, of the cube
export const makers = [() => torusKnotMesh(2, 3, 0.45, 0.18, 0.08, 600), () => boxMesh([0.4, 0.3, 0.2]), () => torusMesh(0.4, 0.15, 200), () => sphereMesh(0.4, 128)];

/** Numbers from 0 to 1, the same in every run. */
function dice(seed) {
  let state = seed >>> 0;
  return () => {
    state = (state + 0x6d2b79f5) >>> 0;
    let t = Math.imul(state ^ (state >>> 15), 1 | state);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
  };
}

export class Crowd {
  constructor(count, seed = 1) {
    const random = dice(seed), within = (half) => half * (2 * random() - 1);
    this.world = new World();
    this.kinds = makers.map((make) => {
      const geometry = make(), { positions, normals } = facets(geometry.vertices, geometry.faces), model = this.world.models.add(geometry);
      geometry.dispose();
      return { model, positions, normals };
    });
    this.bodies = Array.from({ length: count }, (_, i) => ({
      kind: i % makers.length, at: [within(side / 2), within(side / 2), within(side / 2)], way: [within(0.03), within(0.03), within(0.03)],
      axis: [within(1), within(1), within(1), 0.1], spin: within(0.04), angle: within(3),
    }));
    this.poses = new Float64Array(16 * count);
    this.#move(0);
    this.ids = new Float64Array(count);
    for (let k = 0; k < makers.length; ++k) {
      const own = this.bodies.flatMap((body, i) => (body.kind === k ? [i] : []));
      const ids = this.world.bodies.add(this.kinds[k].model, Float64Array.from(own.flatMap((i) => [...this.poses.subarray(16 * i, 16 * i + 16)])));
      own.forEach((i, n) => { this.ids[i] = ids.length ? ids[n] : ids; });
    }
    this.placeOf = new Map([...this.ids].map((id, i) => [id, i]));
    this.red = new Uint8Array(count);
  }
  #move(time) {
    this.bodies.forEach((body, i) => {
      for (let k = 0; k < 3; ++k) {
        body.at[k] += time * body.way[k];
        if (Math.abs(body.at[k]) > side / 2) body.way[k] = -Math.sign(body.at[k]) * Math.abs(body.way[k]);
      }
      body.angle += time * body.spin;
      const s = Math.sin(body.angle / 2), size = Math.hypot(...body.axis);
      this.poses.set(pose(body.at, [...body.axis.slice(0, 3).map((number) => (s * number) / size), Math.cos(body.angle / 2)]), 16 * i);
    });
  }
  /** One frame; returns the milliseconds that the World took: new poses, the step, and its pairs. */
  step(time = 1) {
    this.#move(time);
    const began = performance.now();
    this.world.bodies.setPose(this.ids, this.poses);
    const frame = this.world.step(), { a, b } = frame.met;
    const ms = performance.now() - began;
    this.red.fill(0);
    for (let i = 0; i < a.length; ++i) this.red[this.placeOf.get(a[i])] = this.red[this.placeOf.get(b[i])] = 1;
    this.pairs = a.length;
    this.candidates = frame.pairCount;
    return ms;
  }
}

export function crowdPage(root) {
  const find = (name) => root.querySelector(`[data-${name}]`);
  const canvas = find('canvas'), painter = new Painter(canvas), camera = new Orbit(60);
  let crowd = null, shapes = [], times = [], running = true;
  function restart() {
    for (const shape of shapes) painter.free(shape);
    crowd?.world.dispose();
    crowd = new Crowd(Number(find('count').value));
    shapes = crowd.kinds.map(({ positions, normals }) => painter.shape(positions, normals));
    times = [];
  }
  function paint() {
    const dark = matchMedia('(prefers-color-scheme: dark)').matches;
    painter.begin(camera.view, dark ? [0.11, 0.12, 0.14] : [0.96, 0.96, 0.97]);
    const lists = crowd.kinds.map(() => []);
    crowd.bodies.forEach((body, i) => {
      const red = crowd.red[i];
      lists[body.kind].push(...crowd.poses.subarray(16 * i, 16 * i + 16), red ? 0.95 : 0.45, red ? 0.12 : 0.6, red ? 0.1 : 0.72, 1);
    });
    lists.forEach((list, k) => painter.draw(shapes[k], list));
  }
  function frame() {
    if (running && !document.hidden) {
      times.push(crowd.step());
      if (times.length > 60) times.shift();
      const mean = times.reduce((sum, ms) => sum + ms, 0) / times.length;
      find('time').textContent = `${mean.toFixed(2)} ms`;
      find('pairs').textContent = `${crowd.pairs} pairs of ${crowd.candidates} candidates`;
      paint();
    }
    requestAnimationFrame(frame);
  }
  onDrag(canvas, (dx, dy) => camera.drag(dx, dy));
  const pause = () => {
    running = !running;
    find('pause').textContent = running ? 'Pause' : 'Go on';
  };
  canvas.addEventListener('keydown', (event) => {
    const way = { ArrowLeft: [-12, 0], ArrowRight: [12, 0], ArrowUp: [0, -12], ArrowDown: [0, 12] }[event.key];
    if (way) event.preventDefault(), camera.drag(...way);
    if (event.key === ' ') event.preventDefault(), pause();
    if (event.key === '+' || event.key === '-') camera.distance *= event.key === '+' ? 0.9 : 1 / 0.9;
  });
  find('count').addEventListener('change', restart);
  find('pause').addEventListener('click', pause);
  restart();
  frame();
  return { get crowd() { return crowd; }, get times() { return times; } };
}
