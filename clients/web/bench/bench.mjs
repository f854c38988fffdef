// Times the package and three-mesh-bvh on the same meshes and poses, in one thread.
// usage: node bench.mjs [NPM_FOLDER] [--seconds S] [--meshes FILE,...] [--json FILE]      npm ci in this folder first
import { readFileSync, writeFileSync } from 'node:fs';
import { resolve } from 'node:path';
import { pathToFileURL } from 'node:url';
import * as THREE from 'three';
import { MeshBVH } from 'three-mesh-bvh';

const options = process.argv.slice(2);
const after = (name, otherwise) => (options.includes(name) ? options[options.indexOf(name) + 1] : otherwise);
const folder = resolve(options[0] && !options[0].startsWith('--') ? options[0] : new URL('../../../build/wasm/npm', import.meta.url).pathname);
const seconds = Number(after('--seconds', 2));
const oc = await import(pathToFileURL(`${folder}/lib/index.mjs`).href);
await oc.ready();

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
  const row = { mesh: name, triangles: geometry.faceCount, poses: count, colliding: ours.filter(Boolean).length, bvh_build_ms: built, ...wrong };
  row.ours_us = time(count, (i) => world.pairs.decide(still, sides[i]));
  row.bvh_us = time(count, (i) => one.boundsTree.intersectsGeometry(other, matrices[i]));
  row.ratio = row.bvh_us / row.ours_us;
  row.ours_distance_us = time(apart.length, (k) => world.pairs.distance(still, sides[apart[k]]));
  row.bvh_distance_us = theirTime;
  row.distance_ratio = row.bvh_distance_us / row.ours_distance_us;
  world.dispose();
  return row;
}

const { Crowd } = await (async () => {
  const text = readFileSync(new URL('../pages/crowd.mjs', import.meta.url), 'utf8')
    .replace("'../lib/index.mjs'", `'${pathToFileURL(`${folder}/lib/index.mjs`).href}'`).replace("'./gl.mjs'", `'${new URL('../pages/gl.mjs', import.meta.url).href}'`);
  return import(`data:text/javascript,${encodeURIComponent(text)}`);
})();
function crowd(count) {
  const bodies = new Crowd(count), times = [];
  for (let i = 0; i < 10; ++i) bodies.step();
  for (let i = 0; i < 200; ++i) times.push(bodies.step());
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
if (after('--json')) writeFileSync(after('--json'), `${JSON.stringify(result, null, 1)}\n`);
