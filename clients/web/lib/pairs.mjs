import { call, OncollideError, put } from './module.mjs';
import { columns, offsets, row, rows } from './columns.mjs';
import { pathOf } from './bodies.mjs';
import { posesOf, repeated } from './poses.mjs';

const stops = { contact: 0, touch: 1, press: 2 };
export function sweepArguments({ path = 'linear', timeTolerance = 1e-4, gapTolerance = 1e-4, mostSteps = 10000, stop = 'contact' } = {}, name) {
  if (!(stop in stops)) throw new OncollideError('usage', `${name}: no stop '${stop}'; valid: contact, touch, press`);
  return [pathOf(path, name), timeTolerance, gapTolerance, mostSteps, stops[stop]];
}

/** A side of pairs as ids and poses. */
function sideOf(side, name) {
  if (typeof side === 'number') return { ids: [side], poses: null, count: 1, many: false };
  if (Array.isArray(side) || ArrayBuffer.isView(side)) return { ids: side, poses: null, count: side.length, many: true };
  if (!side || !('model' in side)) throw new OncollideError('usage', `${name}: a side is a body, bodies, or { model, pose }`);
  const ids = typeof side.model === 'number' ? [side.model] : side.model;
  const { numbers, count } = posesOf(side.pose ?? null, name);
  const many = ids.length > 1 || count > 1 || typeof side.model !== 'number';
  return { ids, poses: numbers, to: side.to ?? null, count: Math.max(ids.length, count), many };
}

function sidesOf(a, b, name) {
  const one = sideOf(a, name), other = sideOf(b, name), count = Math.max(one.count, other.count);
  for (const side of [one, other]) {
    for (const [what, width] of [['ids', 1], ['poses', 16], ['to', 16]]) {
      const length = side[what]?.length ?? width;
      if (length !== width && length !== width * count)
        throw new OncollideError('usage', `${name}: sides of ${one.count} and ${other.count}; give one, or as many on both sides`);
      if (side[what] && count > 1) side[what] = repeated(side[what], width, count);
    }
  }
  return { one, other, count, many: one.many || other.many };
}

function ask(world, name, a, b, ...more) {
  const { one, other, count, many } = sidesOf(a, b, name);
  const [ids, poses, otherIds, otherPoses] = put(one.ids, one.poses, other.ids, other.poses);
  call(`_oc_${name}`, world.address, ids, poses, otherIds, otherPoses, count, ...more);
  return many;
}

const decision = { verdict: 'u8', kind: 'u8', bound: 'f64' };
const distances = { lower: 'f64', upper: 'f64', partA: 'i32', partB: 'i32', pointA: 'vec3', pointB: 'vec3' };
const contact = { partA: 'i32', partB: 'i32', kind: 'u8', start: 'vec3', end: 'vec3', normalA: 'vec3', normalB: 'vec3' };
const depth = { supported: 'bool', depth: 'f64', depthUpper: 'f64', ofA: 'bool', deepest: 'vec3', thickness: 'f64', partingLower: 'f64', partingUpper: 'f64', partingAlong: 'vec3' };
const swept = { verdict: 'u8', kind: 'u8', clearUntil: 'f64', grazesUntil: 'f64', contactBy: 'f64', gap: 'f64', point: 'vec3', normal: 'vec3' };
const region = { kind: 'u8', open: 'bool', normal: 'vec3', normalError: 'f64', depthLower: 'f64', depthUpper: 'f64', first: 'f64', count: 'f64', area: 'f64', volume: 'f64', lost: 'f64' };
const point = { pointA: 'vec3', pointB: 'vec3', normal: 'vec3', depth: 'f64', depthError: 'f64' };

export const manifoldArguments = ({ margin = 0, pointsPerRegion = 4, regionsPerPair = 16, measures = false } = {}) =>
  [margin, pointsPerRegion, regionsPerPair, measures];
/** The regions, points, offsets and `complete` of many manifolds. */
export const manifoldLists = () => ({
  regions: rows(region), points: columns(point, 1), offsets: offsets(2), complete: Uint8Array.from(columns({ yes: 'f64' }, 3).yes),
});

export class Pairs {
  #world;
  constructor(world) { this.#world = world; }
  decide(a, b) { return ask(this.#world, 'decide', a, b) ? columns(decision) : row(decision); }
  distance(a, b, { tolerance = 0, cutoff = Infinity } = {}) {
    return ask(this.#world, 'distance', a, b, tolerance, cutoff) ? columns(distances) : row(distances);
  }
  contacts(a, b) {
    const many = ask(this.#world, 'contacts', a, b);
    return many ? { ...columns(contact), offsets: offsets() } : columns(contact);
  }
  penetration(a, b) { return ask(this.#world, 'penetration', a, b) ? columns(depth) : row(depth); }
  sweep(a, b, options = {}) {
    const { one, other, count, many } = sidesOf(a, b, 'sweep');
    if (!one.poses || !other.poses) throw new OncollideError('usage', 'sweep: a side is { model, pose, to }');
    const places = put(one.ids, one.poses, one.to, other.ids, other.poses, other.to);
    call('_oc_sweep', this.#world.address, ...places, count, ...sweepArguments(options, 'sweep'));
    return many ? columns(swept) : row(swept);
  }
  manifold(a, b, options = {}) {
    const many = ask(this.#world, 'manifold', a, b, ...manifoldArguments(options));
    const { offsets: all, complete, ...made } = manifoldLists();
    return many ? { ...made, offsets: all, complete } : { ...made, complete: complete[0] !== 0 };
  }
  maxError(a, b) {
    const { error } = ask(this.#world, 'max_error', a, b) ? columns({ error: 'f64' }) : row({ error: 'f64' });
    return error;
  }
}
export { distances as distanceSchema };
