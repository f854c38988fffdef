// Times the package and three-mesh-bvh on the same meshes and poses, in one thread.
// usage: node bench.mjs [NPM_FOLDER] [--seconds S] [--meshes FILE,...] [--native PYTHON_FOLDER] [--json FILE]
// npm ci in this folder first. --native: times the native library, too, with its baseline kernels (native.py);
// PYTHON_FOLDER has the Python package: build/release/python
import { spawnSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';
import * as THREE from 'three';
import { MeshBVH } from 'three-mesh-bvh';

const options = process.argv.slice(2);
const after = (name, otherwise) => (options.includes(name) ? options[options.indexOf(name) + 1] : otherwise);
const folder = resolve(options[0] && !options[0].startsWith('--') ? options[0] : new URL('../../../build/wasm/npm', import.meta.url).pathname);
const seconds = Number(after('--seconds', 2));
const oc = await import(pathToFileURL(`${folder}/lib/index.mjs`).href);
await oc.whole();
const native = after('--native', '');
const shared = native ? mkdtempSync(join(tmpdir(), 'oncollide-bench-')) : ''; // native.py reads it
const given = { rounds: 20, pairs: [], crowds: [] };
const share = (name, numbers) => native && writeFileSync(join(shared, name), numbers);
function shareGeometry(name, vertices, faces) {
  share(`${name}.vertices`, Float64Array.from(vertices));
  share(`${name}.faces`, Uint32Array.from(faces));
}

/** Poses around a mesh at which another one is near: from clearly apart to clearly inside. */
function posesNear(size, count) {
  let state = 12345;
  const random = () => ((state = (Math.imul(state, 1664525) + 1013904223) >>> 0) / 4294967296);
  const within = () => 2 * random() - 1;
  return Array.from({ length: count }, () => {
    const way = [within(), within(), within()], length = Math.hypot(...way), far = size * (0.15 + 0.6 * random());
    return oc.pose(way.map((number) => (number / length) * far), [within(), within(), within(), within()]);
  });
}

/** Microseconds per call of `run(i)` over all i, which have run once; the least of the rounds within some seconds. */
function time(count, run) {
  let best = Infinity;
  for (const end = performance.now() + 1000 * seconds; best === Infinity || performance.now() < end;) {
    const began = performance.now();
    for (let i = 0; i < count; ++i) run(i);
    best = Math.min(best, (1000 * (performance.now() - began)) / count);
  }
  return best;
}

/** Times all queries in one call, and gives them to native.py. */
function shareQueries(row, world, still, sides, apart) {
  const name = row.mesh.replace(/\W/g, '_'), { model } = still;
  const flat = (chosen) => Float64Array.from(chosen.flatMap(({ pose }) => Array.from(pose)));
  const all = flat(sides), far = flat(apart.map((i) => sides[i]));
  row.batch_us = time(1, () => world.pairs.decide(still, { model, pose: all })) / sides.length;
  row.batch_distance_us = time(1, () => world.pairs.distance(still, { model, pose: far })) / apart.length;
  share(`${name}.poses`, all);
  share(`${name}.apart`, JSON.stringify(apart));
  given.pairs.push(name);
}

function bench(name, geometry, count, far) {
  const { vertices, faces, bounds } = geometry, size = Math.hypot(...bounds.max.map((number, k) => number - bounds.min[k]));
  const poses = posesNear(size, count), matrices = poses.map((pose) => new THREE.Matrix4().fromArray(pose));
  const world = new oc.World(), model = world.models.add(geometry), still = { model, pose: oc.pose([0, 0, 0]) };
  const sides = poses.map((pose) => ({ model, pose }));
  const buffer = () => new THREE.BufferGeometry().setAttribute('position', new THREE.BufferAttribute(Float32Array.from(vertices), 3))
    .setIndex(new THREE.BufferAttribute(Uint32Array.from(faces), 1));
  const [one, other] = [buffer(), buffer()];
  const began = performance.now();
  one.boundsTree = new MeshBVH(one), other.boundsTree = new MeshBVH(other);
  const built = performance.now() - began;

  const ours = poses.map((_, i) => world.pairs.decide(still, sides[i]).verdict === oc.Verdict.colliding);
  const theirs = matrices.map((matrix) => one.boundsTree.intersectsGeometry(other, matrix));
  const apart = ours.flatMap((yes, i) => (yes ? [] : [i])).slice(0, far); // three-mesh-bvh takes seconds each
  const distances = apart.map((i) => world.pairs.distance(still, sides[i]));
  const [target1, target2] = [{}, {}];
  const before = performance.now();
  const theirDistances = apart.map((i) => one.boundsTree.closestPointToGeometry(other, matrices[i], target1, target2)?.distance);
  const theirTime = (1000 * (performance.now() - before)) / apart.length;
  const wrong = {
    lost: ours.filter((yes, i) => yes && !theirs[i]).length, invented: ours.filter((yes, i) => !yes && theirs[i]).length,
    // Outside our certified bounds by more than the rounding of positions to float.
    distances: distances.filter(({ lower, upper }, i) => !(theirDistances[i] >= lower - 1e-6 * size && theirDistances[i] <= upper + 1e-6 * size)).length,
  };
  shareGeometry(name.replace(/\W/g, '_'), vertices, faces);
  const row = { mesh: name, triangles: geometry.faceCount, poses: count, colliding: ours.filter(Boolean).length, bvh_build_ms: built, ...wrong };
  row.ours_us = time(count, (i) => world.pairs.decide(still, sides[i]));
  row.bvh_us = time(count, (i) => one.boundsTree.intersectsGeometry(other, matrices[i]));
  row.ratio = row.bvh_us / row.ours_us;
  row.ours_distance_us = time(apart.length, (k) => world.pairs.distance(still, sides[apart[k]]));
  row.bvh_distance_us = theirTime;
  row.distance_ratio = row.bvh_distance_us / row.ours_distance_us;
  if (native) shareQueries(row, world, still, sides, ours.flatMap((yes, i) => (yes ? [] : [i])));
  world.dispose();
  return row;
}

const { Crowd, makers } = await (async () => {
  const text = readFileSync(new URL('../pages/crowd.mjs', import.meta.url), 'utf8')
    .replace("'../lib/index.mjs'", `'${pathToFileURL(`${folder}/lib/index.mjs`).href}'`).replace("'./gl.mjs'", `'${new URL('../pages/gl.mjs', import.meta.url).href}'`);
  return import(`data:text/javascript,${encodeURIComponent(text)}`);
})();
function crowd(count) {
  const bodies = new Crowd(count), times = [], frames = [];
  for (let i = 0; i < 210; ++i) {
    times.push(bodies.step());
    if (native) frames.push(bodies.poses.slice());
  }
  if (native) {
    makers.map((make) => make()).forEach(({ vertices, faces }, k) => shareGeometry(`kind${k}`, vertices, faces));
    share(`crowd${count}`, Buffer.concat(frames.map((frame) => Buffer.from(frame.buffer))));
    given.crowds.push({ bodies: count, kinds: makers.length, frames: frames.length });
  }
  times.splice(0, 10);
  times.sort((a, b) => a - b);
  return { bodies: count, median_ms: times[100], most_ms: times[198], pairs: bodies.pairs };
}

const files = after('--meshes', '');
const meshes = files ? files.split(',').map((file) => [file.split('/').at(-1), oc.load(file.split('/').at(-1), readFileSync(file))])
  : [['knot 5k', oc.torusKnotMesh(2, 3, 1, 0.42, 0.16, 5000)], ['knot 69k', oc.torusKnotMesh(3, 5, 1, 0.42, 0.1, 69000)]];
const result = { node: process.version, pairs: [], crowds: [] };
for (const [name, geometry] of meshes) {
  const row = bench(name, geometry, 200, geometry.faceCount > 20000 ? 2 : 10);
  result.pairs.push(row);
  console.log(`${row.mesh}, ${row.triangles} triangles: decide ${row.ours_us.toFixed(1)} us, three-mesh-bvh ${row.bvh_us.toFixed(1)} us (${row.ratio.toFixed(1)} x); `
    + `distance ${row.ours_distance_us.toFixed(1)} us, three-mesh-bvh ${row.bvh_distance_us.toFixed(1)} us (${row.distance_ratio.toFixed(1)} x)\n`
    + `  of ${row.poses} poses ${row.colliding} collide; three-mesh-bvh loses ${row.lost}, invents ${row.invented}, and measures ${row.distances} distances wrongly`);
}
for (const count of [1000, 2000]) {
  const row = crowd(count);
  result.crowds.push(row);
  console.log(`${row.bodies} moving bodies: ${row.median_ms.toFixed(2)} ms a frame, at most ${row.most_ms.toFixed(2)} ms of 99 %; ${row.pairs} pairs collide`);
}
if (native) {
  share('given.json', JSON.stringify(given));
  const { stdout, status } = spawnSync('/usr/bin/python3', [new URL('native.py', import.meta.url).pathname, shared], {
    env: { ...process.env, ONCOLLIDE_ISA: 'baseline', PYTHONPATH: resolve(native) }, stdio: ['ignore', 'pipe', 'inherit'], encoding: 'utf8', maxBuffer: 1e9 });
  rmSync(shared, { recursive: true });
  if (status !== 0) throw new Error('native.py failed');
  const times = JSON.parse(stdout);
  times.pairs.forEach((made, i) => {
    const row = result.pairs[i];
    if (made.colliding !== row.colliding) throw new Error(`${row.mesh}: ${made.colliding} collisions natively, ${row.colliding} here`);
    Object.assign(row, { native_us: made.decide_us, native_distance_us: made.distance_us });
    console.log(`${row.mesh}, all poses in one call: decide ${row.batch_us.toFixed(2)} us, native ${made.decide_us.toFixed(2)} us (${(row.batch_us / made.decide_us).toFixed(2)} x as long); `
      + `distance ${row.batch_distance_us.toFixed(1)} us, native ${made.distance_us.toFixed(1)} us (${(row.batch_distance_us / made.distance_us).toFixed(2)} x)`);
  });
  times.crowds.forEach((made, i) => {
    const row = result.crowds[i];
    if (made.pairs !== row.pairs) throw new Error(`${row.bodies} bodies: ${made.pairs} pairs natively, ${row.pairs} here`);
    row.native_ms = made.median_ms;
    console.log(`${row.bodies} moving bodies, native: ${made.median_ms.toFixed(2)} ms a frame (here ${(row.median_ms / made.median_ms).toFixed(2)} x as long)`);
  });
}
if (after('--json')) writeFileSync(after('--json'), `${JSON.stringify(result, null, 1)}\n`);
