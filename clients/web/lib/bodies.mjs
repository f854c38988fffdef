import { call, OncollideError, put, wasm } from './module.mjs';
import { columns, row } from './columns.mjs';
import { posesOf, repeated } from './poses.mjs';

const one = new Float64Array(1);
/** Ids as an array. */
export function idsOf(bodies) {
  if (typeof bodies !== 'number') return bodies;
  one[0] = bodies;
  return one;
}
const paths = { linear: 0, screw: 1 };
export function pathOf(path, call_) {
  if (!(path in paths)) throw new OncollideError('usage', `${call_}: no path '${path}'; valid: linear, screw`);
  return paths[path];
}

export class Bodies {
  #world;
  constructor(world) { this.#world = world; }
  #change(bodies, change) {
    const ids = idsOf(bodies), [at] = put(ids);
    call('_oc_bodies_change', this.#world.address, at, ids.length, change);
  }
  add(model, pose = null, { isStatic = false, layer = 1, mask = 0xffffffff, group = 0, user = 0 } = {}) {
    const { numbers, count } = posesOf(pose, 'bodies.add'), [at] = put(numbers);
    call('_oc_bodies_add', this.#world.address, model, at, count, isStatic, layer, mask, group, user);
    const { id } = columns({ id: 'f64' });
    return pose !== null && (count > 1 || ArrayBuffer.isView(pose) && pose.length > 16) ? id : id[0];
  }
  remove(bodies) {
    const ids = idsOf(bodies), [at] = put(ids);
    call('_oc_bodies_remove', this.#world.address, at, ids.length);
  }
  has(body) { return wasm()._oc_bodies_contains(this.#world.address, body) !== 0; }
  get size() { return this.#world.inspect().bodies; }
  pose(bodies) {
    const ids = idsOf(bodies), [at] = put(ids);
    call('_oc_bodies_pose', this.#world.address, at, ids.length);
    const begin = wasm()._oc_results(0) >> 3;
    return wasm().HEAPF64.slice(begin, begin + 16 * ids.length);
  }
  setPose(bodies, poses) {
    const ids = idsOf(bodies), given = posesOf(poses, 'bodies.setPose');
    if (given.count !== 1 && given.count !== ids.length)
      throw new OncollideError('usage', `bodies.setPose: ${ids.length} bodies and ${given.count} poses; give one pose, or one for each body`);
    const [at, to] = put(ids, given.count === ids.length ? given.numbers : repeated(given.numbers, 16, ids.length));
    call('_oc_bodies_set_pose', this.#world.address, at, to, ids.length);
  }
  setMotion(bodies, poses, { path = 'linear' } = {}) {
    const ids = idsOf(bodies), given = posesOf(poses, 'bodies.setMotion');
    const [at, to] = put(ids, repeated(given.numbers, 16, ids.length));
    call('_oc_bodies_set_motion', this.#world.address, at, to, ids.length, pathOf(path, 'bodies.setMotion'));
  }
  setStatic(bodies, isStatic) { this.#change(bodies, isStatic ? 0 : 1); }
  sleep(bodies) { this.#change(bodies, 2); }
  wake(bodies) { this.#change(bodies, 3); }
  setFilter(bodies, { layer = 1, mask = 0xffffffff, group = 0 } = {}) {
    const ids = idsOf(bodies), [at] = put(ids);
    call('_oc_bodies_set_filter', this.#world.address, at, ids.length, layer, mask, group);
  }
  setModel(bodies, model) {
    const ids = idsOf(bodies), [at] = put(ids);
    call('_oc_bodies_set_model', this.#world.address, at, ids.length, model);
  }
  exclude(a, b) { call('_oc_bodies_exclude', this.#world.address, a, b, true); }
  include(a, b) { call('_oc_bodies_exclude', this.#world.address, a, b, false); }
  info(body) {
    call('_oc_bodies_info', this.#world.address, body);
    return row({ model: 'f64', isStatic: 'bool', isAsleep: 'bool', layer: 'f64', mask: 'f64', group: 'f64', user: 'f64' });
  }
}
