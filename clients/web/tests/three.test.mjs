import assert from 'node:assert/strict';
import { test } from 'node:test';
import { built, load, three, why } from './npm.mjs';

const THREE = await three();
const skip = why || (THREE ? false : "three.js is missing; run 'npm ci' in clients/web/bench, or install libjs-three");
const oc = built ? await load('index.mjs') : null, { ThreeWorld, geometryOf } = built ? await load('three.mjs') : {};
if (built) await oc.ready();
const check = (name, run) => test(name, { skip }, run);
// Debian's release 111 has other names for BufferGeometries.
const Box = THREE?.BoxBufferGeometry ?? THREE?.BoxGeometry, Ball = THREE?.SphereBufferGeometry ?? THREE?.SphereGeometry;
/** Bounds of a distance enclose a number closely. */
const near = ({ lower, upper }, number) => assert.ok(lower <= number && number <= upper + 1e-12 && upper - lower < 1e-9, `${lower} ${upper}`);

check('meshes with scales, mirrors and parents are where three.js draws them', () => {
  const world = new ThreeWorld({ mode: 'solid' }), group = new THREE.Group();
  group.position.set(10, 0, 0);
  const box = new THREE.Mesh(new Box(2, 2, 2)), far = new THREE.Mesh(box.geometry);
  box.scale.set(2, 1, -1);
  box.name = 'box';
  group.add(box);
  far.position.set(14, 0, 0);
  const [a, b] = [world.add(box), world.add(far)];
  near(world.distance(box, far), 1);
  assert.equal(world.objectOf(a).object, box);
  far.position.x = 12.5;
  assert.deepEqual(world.step().map(({ a, b, verdict }) => [a.object, b.object, verdict]), [[box, far, oc.Verdict.colliding]]);
  box.scale.set(0.5, 1, 1); // another model
  assert.equal(world.step().length, 0);
  assert.ok(world.contacts(box, far).partA.length === 0 && b > 0);
  const hit = world.cast(new THREE.Raycaster(new THREE.Vector3(0, 0.1, 0.1), new THREE.Vector3(1, 0, 0)));
  assert.equal(hit.object, box);
  assert.ok(Math.abs(hit.distance - 9.5) < 1e-6);
  world.remove(box);
  assert.throws(() => world.bodyOf(box), oc.OncollideError);
  world.dispose();
});

check('instances are bodies', () => {
  const world = new ThreeWorld(), many = new THREE.InstancedMesh(new Ball(0.4, 16, 8), undefined, 5);
  const at = new THREE.Matrix4();
  for (let i = 0; i < 5; ++i) many.setMatrixAt(i, at.makeTranslation(i, 0, 0));
  const ids = world.add(many);
  assert.equal(ids.length, 5);
  assert.equal(world.step().length, 0);
  many.setMatrixAt(2, at.makeTranslation(3.2, 0, 0));
  const [pair] = world.step();
  assert.deepEqual([pair.a.instance, pair.b.instance, pair.verdict], [2, 3, oc.Verdict.colliding]);
  assert.ok(world.distance([many, 0], [many, 1]).upper > 0.1);
});

check('a step has the contacts of its pairs', () => {
  const world = new ThreeWorld(), box = new THREE.Mesh(new Box(1, 1, 1)), many = new THREE.InstancedMesh(box.geometry, undefined, 2);
  const at = new THREE.Matrix4();
  many.setMatrixAt(0, at.makeTranslation(0.25, 0.125, 0.9375)), many.setMatrixAt(1, at.makeTranslation(5, 0, 0));
  assert.throws(() => world.manifolds(), /call step/);
  world.add(box), world.add(many);
  world.step();
  const [pair, ...others] = world.manifolds();
  assert.deepEqual([others.length, pair.a.object, pair.b.object, pair.b.instance, pair.complete], [0, box, many, 0, true]);
  const [{ normal, normalError, depthLower, depthUpper, points }] = pair.regions;
  assert.ok(normal[2] > 0.99 && normalError < 1e-9 && depthLower <= 0.0630 && depthUpper >= 0.0625, `${normal} ${depthLower} ${depthUpper}`);
  assert.ok(points.length > 0);
  for (const { depth, depthError, pointA, pointB } of points) {
    const along = normal.reduce((sum, number, k) => sum + number * (pointA[k] - pointB[k]), 0);
    assert.ok(Math.abs(along - depth) <= depthError + 1e-12 && depth >= depthLower - 1e-9 && depth <= depthUpper, `${depth} ${along}`);
    assert.ok(Math.abs(pointA[2] - 0.5) < 0.07 && Math.abs(pointB[2] - 0.4375) < 0.07, `${pointA} ${pointB}`);
  }
  many.setMatrixAt(0, at.makeTranslation(0, 0, 3));
  world.step();
  assert.deepEqual(world.manifolds(), []);
});

check('a sheared matrix is refused', () => {
  const world = new ThreeWorld(), parent = new THREE.Group(), child = new THREE.Mesh(new Box());
  parent.scale.set(3, 1, 1);
  child.rotation.z = 0.5;
  parent.add(child);
  assert.throws(() => world.add(child), /shears/);
});

check('geometries of three.js without an index, or changed, are read as they are', () => {
  const buffer = new Box(1, 1, 1).toNonIndexed();
  const geometry = geometryOf(buffer);
  assert.equal(geometry.faceCount, 12);
  assert.equal(geometry.closed, true);
  const world = new ThreeWorld(), a = new THREE.Mesh(buffer), b = new THREE.Mesh(new Box(1, 1, 1));
  b.position.x = 3;
  world.add(a), world.add(b);
  buffer.attributes.position.array.forEach((number, i, all) => { all[i] = 2 * number; });
  world.updateGeometry(a);
  near(world.distance(a, b), 1.5);
});
