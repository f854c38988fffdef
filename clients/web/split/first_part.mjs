// What the first part of the module must do alone: meshes, shapes, verdicts, distances, contacts, casts and steps. The functions that
// these calls reach are the first part; all others are loaded later. A call that many programs begin with belongs here.

const kinds = (oc) => [
  oc.sphereMesh(1, 600), oc.boxMesh([0.7, 0.5, 0.6]), oc.torusKnotMesh(2, 3, 0.8, 0.3, 0.15, 3000), oc.torusMesh(0.8, 0.3, 800),
  oc.sphere(0.8), oc.box([0.6, 0.5, 0.7]), oc.capsule(0.4, 0.9), oc.cylinder(0.5, 1), oc.cone(0.5, 1), oc.ellipsoid([0.5, 0.7, 0.9]),
];

/** Numbers that are equal on every machine. */
function numbers() {
  let state = 2024;
  return () => ((state = (Math.imul(state, 1664525) + 1013904223) >>> 0) / 2147483648) - 1;
}

/** @param oc the package */
export function firstPart(oc) {
  const next = numbers(), turn = () => [next(), next(), next(), next()];
  const near = (far) => oc.pose([far * next(), far * next(), far * next()], turn());
  const geometries = kinds(oc);
  geometries.push(oc.mesh(geometries[2].vertices, geometries[2].faces));
  for (const settings of [{}, { mode: 'solid' }, { maxError: 0.05 }, { clearance: 0.1 }]) {
    const world = new oc.World(settings), models = geometries.map((geometry) => world.models.add(geometry));
    const wall = world.models.add(oc.halfSpace());
    const ground = world.bodies.add(wall, oc.pose([0, 0, -2]), { isStatic: true });
    const bodies = models.flatMap((model) => Array.from({ length: 4 }, () => world.bodies.add(model, near(3))));
    for (let frame = 0; frame < 6; ++frame) {
      world.bodies.setPose(Float64Array.from(bodies), Float64Array.from(bodies.flatMap(() => near(3))));
      const step = world.step();
      void step.met, step.pairs, step.began, step.ended;
    }
    if (settings.maxError) continue;
    for (const a of bodies) {
      for (const b of bodies) {
        if (a === b) continue;
        world.pairs.decide(a, b);
        world.pairs.distance(a, b);
        world.pairs.contacts(a, b);
      }
      world.pairs.decide(a, ground), world.pairs.distance(a, ground);
    }
    for (const model of models) {
      const poses = Float64Array.from(Array.from({ length: 20 }, () => near(2)).flat());
      for (const other of models) world.pairs.decide({ model: other }, { model, pose: poses });
      world.space.overlaps(model, near(2));
    }
    for (let i = 0; i < 40; ++i) {
      const from = [4 * next(), 4 * next(), 4], to = [4 * next(), 4 * next(), -4];
      world.space.cast(from, to), world.space.castAll(from, to), world.space.overlapsSegment(from, to);
    }
    void world.hash, world.settings, world.inspect(), world.bodies.info(bodies[0]), world.bodies.pose(bodies[0]);
    world.bodies.remove(bodies[0]);
    world.dispose();
  }
  for (const geometry of geometries) {
    void geometry.bounds;
    if (geometry.kind === 'mesh') void geometry.closed, geometry.vertices, geometry.faces;
    oc.collide(geometries[1], null, geometry, near(1)), oc.distance(geometries[1], null, geometry, near(3));
  }
  for (const geometry of geometries) geometry.dispose();
}
