import { call, numberAt, OncollideError, pointerAt, put, room, textAt, wasm } from './module.mjs';
import { columns, row } from './columns.mjs';
import { identity, posesOf } from './poses.mjs';
import { Bodies } from './bodies.mjs';
import { manifoldArguments, manifoldLists, Pairs } from './pairs.mjs';
import { Space } from './space.mjs';

export const Verdict = Object.freeze({ separate: 0, within: 1, colliding: 2, undecided: 3 });
export const ContactKind = Object.freeze({ unknown: 0, near: 1, touching: 2, crossing: 3, enclosed: 4 });
export const Stage = Object.freeze({ bounds: 0, delimitation: 1, broad: 2, refine: 3, exact: 4 });
export const RegionKind = Object.freeze({ crossing: 0, touching: 1, enclosed: 2, near: 3 });

const forgotten = new FinalizationRegistry((at) => wasm()._oc_world_free(at));
const snake = (name) => name.replace(/[A-Z]/g, (letter) => `_${letter.toLowerCase()}`);
const camel = (name) => name.replace(/_([a-z])/g, (_, letter) => letter.toUpperCase());
const hashOf = (low, high) => (BigInt(high) << 32n) | BigInt(low);
const pairSchema = { a: 'f64', b: 'f64', verdict: 'u8', kind: 'u8', stage: 'u8', bound: 'f64' };

/** The results of a step; its lists are copied when they are first read. */
class Frame {
  #world;
  #step;
  #lists = {};
  constructor(world, step, numbers) {
    this.#world = world;
    this.#step = step;
    [this.frame, this.ms] = numbers;
    this.hash = hashOf(numbers[2], numbers[3]);
    [this.pairCount, this.beganCount, this.endedCount] = numbers.slice(4, 7);
    this.trees = { nodePairs: numbers[8], trianglePairs: numbers[9], nodes: numbers[10], bytes: numbers[11] };
  }
  #address(name) {
    if (this.#world.steps !== this.#step)
      throw new OncollideError('usage', `Frame: ${name}: the World has stepped since; read the lists of a frame before the next step()`);
    return this.#world.address;
  }
  #list(name, read) {
    return (this.#lists[name] ??= read(this.#address(name)));
  }
  get pairs() {
    return this.#list('pairs', (at) => (call('_oc_frame_pairs', at, false), columns(pairSchema)));
  }
  get met() {
    return this.#list('met', (at) => (call('_oc_frame_pairs', at, true), columns(pairSchema)));
  }
  get began() {
    return this.#list('began', (at) => (call('_oc_frame_changes', at, false), columns({ a: 'f64', b: 'f64' })));
  }
  get ended() {
    return this.#list('ended', (at) => (call('_oc_frame_changes', at, true), columns({ a: 'f64', b: 'f64' })));
  }
  manifolds(options = {}) {
    call('_oc_frame_manifolds', this.#address('manifolds'), ...manifoldArguments(options));
    return { ...columns({ a: 'f64', b: 'f64' }, 4), ...manifoldLists() };
  }
}

class Models {
  #world;
  constructor(world) { this.#world = world; }
  add(geometry) {
    const [made] = put(room);
    call('_oc_models_add', this.#world.address, geometry.address, made);
    return numberAt(made);
  }
  replace(model, geometry) { call('_oc_models_replace', this.#world.address, model, geometry.address); }
  remove(model) { call('_oc_models_remove', this.#world.address, model); }
  has(model) { return wasm()._oc_models_contains(this.#world.address, model) !== 0; }
  get size() { return this.#world.inspect().models; }
  setVertices(model, positions, first = null) {
    const [at] = put(Float64Array.from(positions));
    call('_oc_models_set_vertices', this.#world.address, model, first ?? -1, at, positions.length / 3);
  }
  closed(model) {
    const [at] = put(room);
    call('_oc_models_closed', this.#world.address, model, at);
    return wasm().HEAP32[at >> 2] !== 0;
  }
  selfContacts(model, most = -1) {
    call('_oc_models_self_contacts', this.#world.address, model, most);
    const { a, b } = columns({ a: 'f64', b: 'f64' });
    return { a: Uint32Array.from(a), b: Uint32Array.from(b) };
  }
  spheres(model) {
    call('_oc_models_spheres', this.#world.address, model);
    return columns({ center: 'vec3', radius: 'f64', level: 'u8' });
  }
  bounds(model, pose = identity) {
    const [at] = put(posesOf(pose, 'bounds').numbers);
    call('_oc_models_bounds', this.#world.address, model, at);
    return row({ min: 'vec3', max: 'vec3' });
  }
}

export class World {
  #at;
  steps = 0;
  constructor(settings = {}) {
    const given = Object.fromEntries(Object.entries(settings).filter(([, value]) => value != null).map(([name, value]) => [snake(name), value]));
    const [json, made] = put(JSON.stringify(given), room);
    call('_oc_world', json, made);
    this.#at = pointerAt(made);
    forgotten.register(this, this.#at, this);
    this.models = new Models(this);
    this.bodies = new Bodies(this);
    this.pairs = new Pairs(this);
    this.space = new Space(this);
  }
  /** The address in the module's memory. */
  get address() {
    if (!this.#at) throw new OncollideError('usage', 'the World is disposed of; make another one');
    return this.#at;
  }
  get settings() {
    const [at] = put(new Float64Array(1024));
    call('_oc_world_settings', this.address, at, 8192);
    return Object.fromEntries(Object.entries(JSON.parse(textAt(at))).map(([name, value]) => [camel(name), value]));
  }
  step() {
    call('_oc_step', this.address);
    const at = wasm()._oc_results(0) >> 3;
    return new Frame(this, ++this.steps, wasm().HEAPF64.slice(at, at + 12));
  }
  inspect() {
    call('_oc_world_info', this.address);
    const { bodies, models, frames, bytes } = row({ bodies: 'f64', models: 'f64', frames: 'f64', bytes: 'f64' });
    return { bodies, models, frames, bytes };
  }
  get hash() {
    call('_oc_world_info', this.address);
    const found = row({ bodies: 'f64', models: 'f64', frames: 'f64', bytes: 'f64', low: 'f64', high: 'f64' });
    return hashOf(found.low, found.high);
  }
  dispose() {
    if (!this.#at) return;
    forgotten.unregister(this);
    wasm()._oc_world_free(this.#at);
    this.#at = 0;
  }
  [Symbol.dispose ?? Symbol.for('Symbol.dispose')]() { this.dispose(); }
}

/** Two geometries at two poses, in a World of their own. */
function once(a, poseA, b, poseB, ask) {
  const world = new World();
  try {
    return ask(world.pairs, { model: world.models.add(a), pose: poseA }, { model: world.models.add(b), pose: poseB });
  } finally {
    world.dispose();
  }
}
export const collide = (a, poseA, b, poseB) => once(a, poseA, b, poseB, (pairs, x, y) => pairs.decide(x, y));
export const distance = (a, poseA, b, poseB, options) => once(a, poseA, b, poseB, (pairs, x, y) => pairs.distance(x, y, options));
export const contacts = (a, poseA, b, poseB) => once(a, poseA, b, poseB, (pairs, x, y) => pairs.contacts(x, y));
export const penetration = (a, poseA, b, poseB) => once(a, poseA, b, poseB, (pairs, x, y) => pairs.penetration(x, y));
