// Meshes and instances of three.js in a World. Uses the objects' own methods, so it works with the three.js that the page has.
import { mesh, OncollideError, World } from './index.mjs';

/** The triangles of a BufferGeometry, scaled; a mirror turns them inside out, so its faces are reversed. */
export function geometryOf(buffer, scale = [1, 1, 1], name = '') {
  const position = buffer.attributes?.position;
  if (!position) throw new OncollideError('usage', 'geometryOf: the geometry has no positions; give a BufferGeometry');
  const count = position.count, vertices = new Float64Array(3 * count);
  for (let i = 0; i < count; ++i) {
    vertices[3 * i] = position.getX(i) * scale[0];
    vertices[3 * i + 1] = position.getY(i) * scale[1];
    vertices[3 * i + 2] = position.getZ(i) * scale[2];
  }
  const faces = buffer.index ? Uint32Array.from(buffer.index.array) : Uint32Array.from({ length: count - (count % 3) }, (_, i) => i);
  if (scale[0] * scale[1] * scale[2] < 0)
    for (let i = 0; i < faces.length; i += 3) [faces[i], faces[i + 1]] = [faces[i + 1], faces[i]];
  return mesh(vertices, faces, { name });
}

/** A matrix as a rigid pose and a scale. */
function split(matrix, like) {
  const position = like.position.clone(), quaternion = like.quaternion.clone(), scale = like.scale.clone();
  matrix.decompose(position, quaternion, scale);
  const rigid = matrix.clone().compose(position, quaternion, like.scale.clone().set(1, 1, 1));
  const parts = [scale.x, scale.y, scale.z];
  // A sheared matrix is no rotation after a scale.
  const again = matrix.clone().compose(position, quaternion, scale).elements;
  const size = Math.max(...parts.map(Math.abs));
  if (matrix.elements.some((number, i) => i < 12 && Math.abs(number - again[i]) > 1e-5 * size))
    throw new OncollideError('usage', `'${like.name}': its matrix shears (a rotated object under one that is scaled unevenly); apply the scale to the geometry`);
  return { pose: rigid.elements, scale: parts };
}

/** Models of equal geometries and scales, shared by bodies. */
class ModelCache {
  #world;
  #ofBuffers = new WeakMap();
  constructor(world) { this.#world = world; }
  modelOf(buffer, scale, name) {
    const key = scale.map((number) => Math.fround(number)).join(' ');
    let scaled = this.#ofBuffers.get(buffer);
    if (!scaled) this.#ofBuffers.set(buffer, scaled = new Map());
    if (!scaled.has(key)) {
      const geometry = geometryOf(buffer, key.split(' ').map(Number), name);
      scaled.set(key, this.#world.models.add(geometry));
      geometry.dispose(); // the World shares it
    }
    return scaled.get(key);
  }
  forget(buffer) { this.#ofBuffers.delete(buffer); }
}

export class ThreeWorld {
  #models;
  #objects = new Map(); // object -> { ids, poses, model, isStatic }
  #places = new Map(); // body -> { object, instance }
  #frame = null; // of the last step
  constructor(settings = {}) {
    this.world = new World(settings);
    this.#models = new ModelCache(this.world);
  }
  #matrices(object) {
    object.updateWorldMatrix(true, false);
    if (!object.isInstancedMesh) return [object.matrixWorld];
    return Array.from({ length: object.count }, (_, i) => {
      const own = object.matrixWorld.clone();
      object.getMatrixAt(i, own);
      return own.premultiply(object.matrixWorld);
    });
  }
  add(object, options = {}) {
    if (!object?.geometry || !object.matrixWorld) throw new OncollideError('usage', 'add: give a Mesh or an InstancedMesh of three.js');
    if (this.#objects.has(object)) throw new OncollideError('usage', `add: '${object.name}' is in the World already; remove() it first`);
    const ids = [], scales = [];
    for (const matrix of this.#matrices(object)) {
      const { pose, scale } = split(matrix, object);
      ids.push(this.world.bodies.add(this.#models.modelOf(object.geometry, scale, object.name), pose, options));
      scales.push(scale.map(Math.fround).join(' '));
      this.#places.set(ids.at(-1), { object, instance: object.isInstancedMesh ? ids.length - 1 : null });
    }
    this.#objects.set(object, { ids: Float64Array.from(ids), scales });
    return object.isInstancedMesh ? this.#objects.get(object).ids : ids[0];
  }
  remove(object) {
    const { ids } = this.#of(object);
    this.world.bodies.remove(ids);
    for (const id of ids) this.#places.delete(id);
    this.#objects.delete(object);
  }
  #of(object) {
    const known = this.#objects.get(object);
    if (!known) throw new OncollideError('usage', `'${object?.name ?? object}' is not in the World; add() it first`);
    return known;
  }
  /** The body of an object, or of one of its instances. */
  bodyOf(object, instance = 0) { return this.#of(object).ids[instance]; }
  /** The object and the instance of a body. */
  objectOf(body) { return this.#places.get(body) ?? null; }
  /** Moves the bodies of these objects, by default of all, to where the objects are. */
  update(objects = this.#objects.keys()) {
    for (const object of objects) {
      const known = this.#of(object), matrices = this.#matrices(object);
      const poses = new Float64Array(16 * known.ids.length);
      for (let i = 0; i < known.ids.length; ++i) {
        const { pose, scale } = split(matrices[i], object), key = scale.map(Math.fround).join(' ');
        poses.set(pose, 16 * i);
        if (key === known.scales[i]) continue;
        this.world.bodies.setModel(known.ids[i], this.#models.modelOf(object.geometry, scale, object.name));
        known.scales[i] = key;
      }
      this.world.bodies.setPose(known.ids, poses);
    }
  }
  /** Gives a geometry's bodies its positions of now, after they were changed. */
  updateGeometry(object) {
    const known = this.#of(object);
    this.#models.forget(object.geometry);
    this.update([object]);
    known.ids.forEach((id, i) => {
      const scale = known.scales[i].split(' ').map(Number);
      this.world.bodies.setModel(id, this.#models.modelOf(object.geometry, scale, object.name));
    });
  }
  /** Updates all objects, steps the World, and returns the pairs that are not separate. */
  step() {
    this.update();
    this.#frame = this.world.step();
    const { a, b, verdict, kind, bound } = this.#frame.met;
    return Array.from(verdict, (one, i) => ({ a: this.objectOf(a[i]), b: this.objectOf(b[i]), verdict: one, kind: kind[i], bound: bound[i] }));
  }
  /** The contacts of the last step, for each pair. */
  manifolds(options) {
    if (!this.#frame) throw new OncollideError('usage', 'manifolds: there has been no step; call step() first');
    const { a, b, regions, points, offsets, complete } = this.#frame.manifolds(options);
    const vector = (column, i) => [...column.subarray(3 * i, 3 * i + 3)];
    const pointAt = (i) => ({
      pointA: vector(points.pointA, i), pointB: vector(points.pointB, i), normal: vector(points.normal, i),
      depth: points.depth[i], depthError: points.depthError[i],
    });
    return Array.from(complete, (whole, i) => ({
      a: this.objectOf(a[i]), b: this.objectOf(b[i]), complete: whole !== 0,
      regions: regions.slice(offsets[i], offsets[i + 1]).map(({ first, count, ...region }) => (
        { ...region, points: Array.from({ length: count }, (_, k) => pointAt(first + k)) })),
    }));
  }
  #sides(a, b) {
    const sides = [a, b].map((side) => (Array.isArray(side) ? this.bodyOf(...side) : this.bodyOf(side)));
    this.update([a, b].map((side) => (Array.isArray(side) ? side[0] : side)));
    return sides;
  }
  decide(a, b) { return this.world.pairs.decide(...this.#sides(a, b)); }
  distance(a, b, options) { return this.world.pairs.distance(...this.#sides(a, b), options); }
  contacts(a, b) { return this.world.pairs.contacts(...this.#sides(a, b)); }
  penetration(a, b) { return this.world.pairs.penetration(...this.#sides(a, b)); }
  /** The first hit of a Ray, or of a Raycaster up to its `far`. Bodies are where the last update() or step() put them. */
  cast(ray, far = ray.far ?? 1e9) {
    const { origin, direction } = ray.ray ?? ray, length = Math.min(far, 1e9);
    const start = [origin.x, origin.y, origin.z], way = [direction.x, direction.y, direction.z];
    const hit = this.world.space.cast(start, start.map((number, k) => number + length * way[k]));
    return hit && { ...hit, ...this.objectOf(hit.body), distance: length * hit.fractionLower, faceIndex: hit.part };
  }
  dispose() {
    this.world.dispose();
    this.#objects.clear();
    this.#places.clear();
  }
}
