import assert from 'node:assert/strict';
import { test } from 'node:test';
import { built, load, why } from './npm.mjs';

const oc = built ? await load('index.mjs') : null;
if (built) {
  assert.throws(() => new oc.World(), (error) => error instanceof oc.OncollideError && error.kind === 'usage' && /await ready/.test(error.cure));
  await oc.ready();
}
const check = (name, run) => test(name, { skip: why }, run);
const refused = (kind, pattern, run) => assert.throws(run, (error) => {
  assert.ok(error instanceof oc.OncollideError, String(error));
  assert.equal(error.kind, kind);
  assert.match(error.message, pattern);
  return true;
});
/** A tetrahedron with a corner at the origin. */
const corner = [[0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1], [0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3]];

check('meshes of every kind of array are the same mesh', () => {
  const meshes = [
    oc.mesh(...corner), oc.mesh(Float64Array.from(corner[0]), Uint16Array.from(corner[1])),
    oc.mesh(Float32Array.from(corner[0]), Uint32Array.from(corner[1])),
    oc.mesh(corner[1].flatMap((i) => corner[0].slice(3 * i, 3 * i + 3))),
  ];
  for (const mesh of meshes.slice(0, 3)) {
    assert.deepEqual([...mesh.vertices], corner[0]);
    assert.deepEqual([...mesh.faces], corner[1]);
  }
  for (const mesh of meshes) {
    assert.equal(mesh.kind, 'mesh');
    assert.equal(mesh.faceCount, 4);
    assert.equal(mesh.closed, true);
    assert.deepEqual(mesh.bounds, { min: [0, 0, 0], max: [1, 1, 1] });
  }
});

check('two bodies collide, part, and have a certified distance', () => {
  const world = new oc.World();
  const ball = world.models.add(oc.sphereMesh(1, 2000));
  const [a, b] = world.bodies.add(ball, Float64Array.from([...oc.pose([0, 0, 0]), ...oc.pose([1.5, 0, 0])]));
  assert.equal(world.pairs.decide(a, b).verdict, oc.Verdict.colliding);
  let frame = world.step();
  assert.deepEqual([frame.pairCount, frame.met.a[0], frame.met.b[0], frame.beganCount], [1, a, b, 1]);
  world.bodies.setPose(b, oc.pose([3, 0, 0]));
  const { lower, upper, pointA, pointB } = world.pairs.distance(a, b);
  assert.ok(lower <= upper && upper - lower < 1e-9 && upper >= 1 && upper < 1.01, `${lower} ${upper}`); // a sphere's mesh is inside it
  assert.ok(Math.abs(pointB[0] - pointA[0] - upper) < 1e-9);
  frame = world.step();
  assert.deepEqual([frame.met.a.length, frame.endedCount], [0, 1]);
  assert.ok(world.hash > 0n);
  world.dispose();
});

check('many pairs give columns with the results of single ones', () => {
  const world = new oc.World({ mode: 'solid' });
  const knot = world.models.add(oc.torusKnotMesh(2, 3, 1, 0.4, 0.15, 1000)), box = world.models.add(oc.box([0.3, 0.3, 0.3]));
  const poses = [];
  for (let i = 0; i < 40; ++i) poses.push(oc.pose([0.1 * i - 1, 0.05 * i, 0], [Math.sin(i), 0.3, 0, 1]));
  const side = { model: box, pose: Float64Array.from(poses.flat()) };
  const decided = world.pairs.decide({ model: knot }, side), apart = world.pairs.distance({ model: knot }, side);
  const found = world.pairs.contacts({ model: knot }, side);
  poses.forEach((pose, i) => {
    const one = { model: box, pose };
    assert.equal(decided.verdict[i], world.pairs.decide({ model: knot }, one).verdict);
    const { lower, pointA } = world.pairs.distance({ model: knot }, one);
    assert.equal(apart.lower[i], lower);
    assert.deepEqual([...apart.pointA.slice(3 * i, 3 * i + 3)], pointA);
    assert.equal(found.offsets[i + 1] - found.offsets[i], world.pairs.contacts({ model: knot }, one).partA.length);
  });
  const verdicts = new Set(decided.verdict);
  assert.ok(verdicts.has(oc.Verdict.colliding) && verdicts.has(oc.Verdict.separate));
});

check('casts, overlaps, sweeps, depths and manifolds', () => {
  const world = new oc.World();
  const ball = world.models.add(oc.sphere(1));
  const body = world.bodies.add(ball, oc.pose([5, 0, 0]), { user: 7, layer: 2 });
  const hit = world.space.cast([0, 0, 0], [10, 0, 0]);
  assert.equal(hit.body, body);
  assert.ok(hit.fractionLower <= 0.4 && hit.fractionUpper >= 0.4 && hit.fractionUpper - hit.fractionLower < 1e-9);
  assert.equal(world.space.cast([0, 0, 3], [10, 0, 3]), null);
  assert.equal(world.space.cast([0, 0, 0], [10, 0, 0], { mask: 1 }), null);
  assert.deepEqual([...world.space.overlapsBox([3, -1, -1], [4.5, 1, 1]).body], [body]);
  assert.deepEqual([...world.space.overlaps(ball, oc.pose([6, 1, 0])).body], [body]);
  const sweep = world.pairs.sweep({ model: ball, pose: null, to: oc.pose([10, 0, 0]) }, { model: ball, pose: oc.pose([5, 0, 0]) });
  assert.ok(sweep.clearUntil <= 0.3 && sweep.contactBy >= 0.3 && sweep.contactBy - sweep.clearUntil < 1e-3);
  assert.equal(world.space.castModel(ball, null, oc.pose([10, 0, 0])).body, body);
  const depth = world.pairs.penetration({ model: ball }, { model: ball, pose: oc.pose([1.5, 0, 0]) });
  assert.ok(depth.partingLower <= 0.5 && depth.partingUpper >= 0.5 - 1e-9);
  const { regions, points } = world.pairs.manifold({ model: ball }, { model: ball, pose: oc.pose([1.5, 0, 0]) });
  assert.equal(regions.length, 1);
  assert.ok(Math.abs(regions[0].normal[0] - 1) < 1e-6 && points.depth.length >= 1);
  assert.equal(world.space.distances(ball, null, 10).lower.length, 1);
  assert.deepEqual(world.bodies.info(body), { model: ball, isStatic: false, isAsleep: false, layer: 2, mask: 0xffffffff, group: 0, user: 7 });
});

check('terrains, maps and hulls', () => {
  const world = new oc.World();
  const ground = world.models.add(oc.terrain(new Float64Array(100), 10, { spacing: 1 }));
  const map = world.models.add(oc.occupancyMap([0, 0, 0, 1, 0, 0], 0.5));
  const hull = world.models.add(oc.convexHull([0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1]));
  assert.equal(world.pairs.decide({ model: ground }, { model: hull, pose: oc.pose([3, 3, -0.5]) }).verdict, oc.Verdict.colliding);
  assert.equal(world.pairs.decide({ model: map }, { model: hull, pose: oc.pose([0, 0, 2]) }).verdict, oc.Verdict.separate);
});

check('errors have a kind, name the place and the cure, and change nothing', () => {
  const world = new oc.World(), other = new oc.World();
  const model = world.models.add(oc.box([1, 1, 1])), foreign = other.bodies.add(other.models.add(oc.box([1, 1, 1])));
  const body = world.bodies.add(model);
  refused('bad_data', /vertex 9/, () => oc.mesh(corner[0], [0, 1, 9]));
  refused('bad_data', /finite/, () => oc.mesh([NaN, ...corner[0].slice(1)], corner[1]));
  refused('usage', /multiple of 3/, () => oc.mesh([1, 2], [0, 1, 2]));
  refused('usage', /no setting 'max_eror'/, () => new oc.World({ maxEror: 1 }));
  refused('usage', /max-error = -1/, () => new oc.World({ maxError: -1 }));
  refused('usage', /max_error.*another type/, () => new oc.World({ maxError: 'far' }));
  refused('bad_data', /rigid/, () => world.bodies.setPose(body, [2, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]));
  refused('usage', /16 numbers/, () => world.bodies.setPose(body, [1, 2, 3]));
  refused('usage', /./, () => world.bodies.setPose(foreign, oc.pose([0, 0, 0])));
  refused('usage', /./, () => world.bodies.remove(1.5));
  world.bodies.remove(body);
  refused('usage', /./, () => world.bodies.remove(body));
  refused('bad_data', /cut\.stl/, () => oc.load('cut.stl', 'solid x\nfacet normal 0 0'));
  refused('bad_data', /bad\.obj/, () => oc.load('bad.obj', 'v 0 0 0\nf 1 2 3\n'));
  refused('usage', /^the geometry 'ball' is not a mesh/, () => oc.sphere(1, { name: 'ball' }).faces);
  refused('usage', /no name of a file/, () => oc.load('../x.obj', ''));
  world.dispose();
  refused('usage', /disposed of/, () => world.step());
});

check('a frame refuses to be read after the next step', () => {
  const world = new oc.World();
  const first = world.step();
  world.step();
  refused('usage', /before the next step/, () => first.pairs);
  refused('usage', /before the next step/, () => first.manifolds());
});

check('the manifolds of a step are those of its pairs', () => {
  const world = new oc.World({ clearance: 0.2 }), knot = world.models.add(oc.torusKnotMesh(2, 3, 1, 0.4, 0.15, 1000));
  const ball = world.models.add(oc.sphere(0.6)), floor = world.models.add(oc.boxMesh([9, 9, 1]));
  const bodies = [world.bodies.add(floor, oc.pose([0, 0, -1.5]), { isStatic: true })];
  for (let i = 0; i < 6; ++i) bodies.push(world.bodies.add(i % 2 ? ball : knot, oc.pose([1.4 * i - 4, 0.2, 0.05 * i], [0.1 * i, 0, 0.3, 1])));
  const options = { margin: 0.1, pointsPerRegion: 8 }, frame = world.step(), found = frame.manifolds(options);
  assert.ok(found.a.length >= 4, `${found.a.length} pairs`);
  assert.deepEqual([found.offsets.length, found.complete.length, found.offsets.at(-1)], [found.a.length + 1, found.a.length, found.regions.length]);
  let points = 0;
  found.a.forEach((a, i) => {
    const one = world.pairs.manifold(a, found.b[i], options), mine = found.regions.slice(found.offsets[i], found.offsets[i + 1]);
    assert.equal(one.complete, found.complete[i] !== 0);
    assert.deepEqual(mine.map(({ first, ...rest }) => rest), one.regions.map(({ first, ...rest }) => rest));
    mine.forEach(({ first, count }, k) => {
      const at = one.regions[k].first;
      for (const [name, width] of [['pointA', 3], ['pointB', 3], ['normal', 3], ['depth', 1], ['depthError', 1]])
        assert.deepEqual(found.points[name].slice(width * first, width * (first + count)), one.points[name].slice(width * at, width * (at + count)), name);
      points += count;
    });
  });
  assert.equal(points, found.points.depth.length);
  const known = new Set([...found.a].map((a, i) => `${a} ${found.b[i]}`)), { a, b, verdict } = frame.met;
  verdict.forEach((one, i) => assert.ok(one !== oc.Verdict.colliding || known.has(`${a[i]} ${b[i]}`), `pair ${i} has no manifold`));
  assert.ok(frame.manifolds().points.depth.length < points); // without the margin
  refused('usage', /points/, () => frame.manifolds({ pointsPerRegion: 0 }));
  world.bodies.setPose(bodies[1], oc.pose([0, 0, 9]));
  refused('usage', /step/, () => frame.manifolds());
});

check('the error of a verdict is that of the settings, and by default a hundredth of the smaller diagonal', () => {
  const small = oc.boxMesh([1, 2, 2]), large = oc.boxMesh([9, 9, 9]);
  for (const [settings, expected] of [[{}, 0.06], [{ maxError: 0.02, exact: 'off' }, 0.02]]) {
    const world = new oc.World(settings), model = world.models.add(small), body = world.bodies.add(world.models.add(large));
    const near = (error) => assert.ok(Math.abs(error - expected) < 1e-12, `${error} is not ${expected}`);
    near(world.pairs.maxError(body, { model }));
    const many = world.pairs.maxError(body, { model, pose: [...oc.pose([0, 0, 0]), ...oc.pose([1, 0, 0])] });
    assert.equal(many.length, 2);
    many.forEach(near);
  }
});

check('files are read from memory, with the files that they name', () => {
  const obj = oc.load('four.obj', 'v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n', { scale: 2 });
  assert.deepEqual(obj.bounds.max, [2, 2, 2]);
  assert.equal(obj.closed, true);
  const positions = new Uint8Array(Float32Array.from([0, 0, 0, 1, 0, 0, 0, 1, 0]).buffer);
  const gltf = JSON.stringify({
    asset: { version: '2.0' }, buffers: [{ uri: 'data/p.bin', byteLength: 36 }], bufferViews: [{ buffer: 0, byteLength: 36 }],
    accessors: [{ bufferView: 0, componentType: 5126, count: 3, type: 'VEC3', min: [0, 0, 0], max: [1, 1, 0] }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0 } }] }], nodes: [{ mesh: 0 }], scenes: [{ nodes: [0] }], scene: 0,
  });
  assert.equal(oc.load('one.gltf', gltf, { files: { 'data/p.bin': positions } }).faceCount, 1);
  refused('bad_data', /p\.bin/, () => oc.load('one.gltf', gltf));
});

check('settings come back with their defaults', () => {
  const { maxError, mode, coherence } = new oc.World({ maxError: 0.25 }).settings;
  assert.deepEqual([maxError, mode, coherence], [0.25, 'surface', true]);
});

check('collide, distance, contacts and penetration of two geometries', () => {
  const [a, b] = [oc.boxMesh([1, 1, 1]), oc.boxMesh([1, 1, 1])];
  assert.equal(oc.collide(a, null, b, oc.pose([1.5, 0.1, 0.2])).verdict, oc.Verdict.colliding);
  assert.ok(Math.abs(oc.distance(a, null, b, oc.pose([3, 0, 0])).lower - 1) < 1e-9);
  assert.ok(oc.contacts(a, null, b, oc.pose([1.5, 0.1, 0.2])).partA.length > 0);
  assert.ok(oc.penetration(a, null, b, oc.pose([1.5, 0.1, 0.2])).depth >= 0);
});

check('Worlds and geometries that are disposed of or forgotten leave no memory behind', async () => {
  const { wasm } = await load('module.mjs');
  const once = (dispose) => {
    const world = new oc.World(), geometry = oc.sphereMesh(1, 20000);
    const model = world.models.add(geometry);
    world.bodies.add(model), world.bodies.add(model, oc.pose([1, 0.2, 0.1]));
    world.step();
    if (dispose) world.dispose(), geometry.dispose();
  };
  once(true);
  const before = wasm().HEAPU8.length;
  for (let i = 0; i < 200; ++i) once(true);
  assert.ok(wasm().HEAPU8.length - before < 8 << 20, `grew by ${wasm().HEAPU8.length - before} bytes`);
  if (!globalThis.gc) return;
  for (let i = 0; i < 200; ++i) {
    once(false);
    if (i % 10 === 9) globalThis.gc(), await new Promise((done) => setTimeout(done, 5));
  }
  assert.ok(wasm().HEAPU8.length - before < 160 << 20, `forgotten ones grew by ${wasm().HEAPU8.length - before} bytes`);
});
