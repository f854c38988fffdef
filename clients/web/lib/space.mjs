import { call, OncollideError, put } from './module.mjs';
import { columns, offsets, row, rows } from './columns.mjs';
import { distanceSchema, sweepArguments } from './pairs.mjs';
import { posesOf } from './poses.mjs';

const hit = { body: 'f64', verdict: 'u8', kind: 'u8', bound: 'f64' };
const castHit = { body: 'f64', verdict: 'u8', fractionLower: 'f64', fractionUpper: 'f64', part: 'i32', point: 'vec3', normal: 'vec3' };
const sweepHit = { body: 'f64', verdict: 'u8', kind: 'u8', clearUntil: 'f64', contactBy: 'f64', gap: 'f64', point: 'vec3', normal: 'vec3' };
const filterOf = ({ layer = 1, mask = 0xffffffff, group = 0 } = {}) => [layer, mask, group];
const some = (found) => (found.body < 0 ? null : found);

function pointsOf(a, b, name) {
  if (a.length !== b.length || a.length % 3 || a.length === 0)
    throw new OncollideError('usage', `${name}: ${a.length} and ${b.length} numbers; give as many points of three numbers on both sides`);
  return a.length / 3;
}

export class Space {
  #world;
  constructor(world) { this.#world = world; }
  #overlaps(form, model, one, other, count, filter) {
    const [at, to] = put(one, other);
    call('_oc_overlaps', this.#world.address, form, model, at, to, count, ...filterOf(filter));
    return count > 1 ? { ...columns(hit), offsets: offsets() } : columns(hit);
  }
  overlaps(model, pose = null, filter = {}) {
    const { numbers, count } = posesOf(pose, 'overlaps');
    return this.#overlaps(0, model, numbers, null, count, filter);
  }
  overlapsSegment(start, end, filter = {}) {
    return this.#overlaps(1, 0, start, end, pointsOf(start, end, 'overlapsSegment'), filter);
  }
  overlapsBox(low, high, filter = {}) {
    return this.#overlaps(2, 0, low, high, pointsOf(low, high, 'overlapsBox'), filter);
  }
  cast(start, end, filter = {}) {
    const count = pointsOf(start, end, 'cast'), [from, to] = put(start, end);
    call('_oc_cast', this.#world.address, from, to, count, false, ...filterOf(filter));
    return count > 1 ? columns(castHit) : some(row(castHit));
  }
  castAll(start, end, filter = {}) {
    if (pointsOf(start, end, 'castAll') !== 1) throw new OncollideError('usage', 'castAll: one segment at a time');
    const [from, to] = put(start, end);
    call('_oc_cast', this.#world.address, from, to, 1, true, ...filterOf(filter));
    return rows(castHit);
  }
  #castModel(model, start, end, all, options) {
    const [from, to] = put(posesOf(start, 'castModel').numbers, posesOf(end, 'castModel').numbers);
    call('_oc_cast_model', this.#world.address, model, from, to, all, ...filterOf(options), ...sweepArguments(options, 'castModel'));
  }
  castModel(model, start, end, options = {}) {
    this.#castModel(model, start, end, false, options);
    return row(sweepHit);
  }
  castAllModel(model, start, end, options = {}) {
    this.#castModel(model, start, end, true, options);
    return rows(sweepHit);
  }
  distances(model, pose, cutoff, { tolerance = 0, ...filter } = {}) {
    const [at] = put(posesOf(pose, 'distances').numbers);
    call('_oc_distances', this.#world.address, model, at, cutoff, tolerance, ...filterOf(filter));
    return columns({ body: 'f64', ...distanceSchema });
  }
}
