import { call, finite, needRest, OncollideError, pointerAt, put, room, wasm } from './module.mjs';
import { row } from './columns.mjs';

const names = ['mesh', 'map', 'terrain', 'sphere', 'box', 'capsule', 'cylinder', 'hull', 'ellipsoid', 'cone', 'half_space'];
const forgotten = new FinalizationRegistry((at) => wasm()._oc_geometry_free(at));

export class Geometry {
  #at;
  #info;
  constructor(at, name) {
    if (typeof at !== 'number') throw new OncollideError('usage', 'Geometry has no constructor; call mesh(), box(), load() ...');
    this.#at = at;
    this.name = name;
    forgotten.register(this, at, this);
  }
  /** The address in the module's memory. */
  get address() {
    if (!this.#at) throw new OncollideError('usage', `the geometry '${this.name}' is disposed of; make it again`);
    return this.#at;
  }
  #known() {
    if (!this.#info) {
      call('_oc_geometry_info', this.address);
      this.#info = row({ kind: 'f64', vertices: 'f64', faces: 'f64', low: 'vec3', high: 'vec3' });
    }
    return this.#info;
  }
  get kind() { return names[this.#known().kind]; }
  get bounds() {
    const { low, high } = this.#known();
    return { min: [...low], max: [...high] };
  }
  get vertexCount() { return this.#known().vertices; }
  get faceCount() { return this.#known().faces; }
  get vertices() {
    const [at] = put(room);
    call('_oc_geometry_vertices', this.address, at);
    const begin = pointerAt(at) >> 3;
    return wasm().HEAPF64.slice(begin, begin + 3 * this.vertexCount);
  }
  get faces() {
    const [at] = put(room);
    call('_oc_geometry_faces', this.address, at);
    const begin = pointerAt(at) >> 2;
    return wasm().HEAPU32.slice(begin, begin + 3 * this.faceCount);
  }
  get closed() {
    const [at] = put(room);
    call('_oc_geometry_closed', this.address, at);
    return wasm().HEAP32[at >> 2] !== 0;
  }
  dispose() {
    if (!this.#at) return;
    forgotten.unregister(this);
    wasm()._oc_geometry_free(this.#at);
    this.#at = 0;
  }
  [Symbol.dispose ?? Symbol.for('Symbol.dispose')]() { this.dispose(); }
}

export function mesh(vertices, faces = null, { name = '' } = {}) {
  if (vertices.length % 3) throw new OncollideError('usage', `mesh: ${vertices.length} numbers of vertices are not a multiple of 3`);
  if ((faces ?? vertices).length % (faces ? 3 : 9)) throw new OncollideError('usage', `mesh: ${(faces ?? vertices).length} numbers are not whole triangles`);
  for (const index of faces && !ArrayBuffer.isView(faces) ? faces : [])
    if (!Number.isInteger(index) || index < 0) throw new OncollideError('usage', `mesh: ${index} is no number of a vertex`);
  const indices = faces === null || faces instanceof Uint32Array ? faces : Uint32Array.from(faces);
  const single = vertices instanceof Float32Array;
  const [at, of, called, made] = put(vertices, indices, name, room);
  call('_oc_mesh', at, vertices.length / 3, single, of, faces ? faces.length / 3 : vertices.length / 9, called, made);
  return new Geometry(pointerAt(made), name);
}

function shape(kind, call_, x, y, z, name) {
  for (const number of [x, y, z]) finite(call_, 'a size', number);
  const [called, made] = put(name, room);
  call('_oc_shape', kind, x, y, z, called, made);
  return new Geometry(pointerAt(made), name);
}
export const sphere = (radius, { name = '' } = {}) => shape(0, 'sphere', radius, 0, 0, name);
export const box = (half, { name = '' } = {}) => shape(1, 'box', half[0], half[1], half[2], name);
export const capsule = (radius, length, { name = '' } = {}) => shape(2, 'capsule', radius, length, 0, name);
export const cylinder = (radius, length, { name = '' } = {}) => shape(3, 'cylinder', radius, length, 0, name);
export const ellipsoid = (axes, { name = '' } = {}) => shape(5, 'ellipsoid', axes[0], axes[1], axes[2], name);
export const cone = (radius, length, { name = '' } = {}) => shape(6, 'cone', radius, length, 0, name);
export const halfSpace = ({ name = '' } = {}) => shape(7, 'halfSpace', 0, 0, 0, name);

export function convexHull(points, { name = '' } = {}) {
  needRest();
  const [at, called, made] = put(Float64Array.from(points), name, room);
  call('_oc_hull', at, points.length / 3, called, made);
  return new Geometry(pointerAt(made), name);
}

export function terrain(heights, columns, { spacing = 1, origin = [0, 0, 0], error = 0, name = '' } = {}) {
  const rows = heights.length / columns;
  if (!Number.isInteger(rows)) throw new OncollideError('usage', `terrain: ${heights.length} heights are not whole rows of ${columns}`);
  const [x, y] = typeof spacing === 'number' ? [spacing, spacing] : spacing;
  needRest();
  const [at, from, called, made] = put(Float64Array.from(heights), Float64Array.from(origin), name, room);
  call('_oc_terrain', at, columns, rows, x, y, from, error, called, made);
  return new Geometry(pointerAt(made), name);
}

export function occupancyMap(cells, resolution, { name = '' } = {}) {
  needRest();
  const [at, called, made] = put(Int32Array.from(cells), name, room);
  call('_oc_map', at, cells.length / 3, resolution, called, made);
  return new Geometry(pointerAt(made), name);
}

let folders = 0;

export function load(name, bytes, { files = {}, scale = 1, fitDiagonal = 0, centre = false } = {}) {
  needRest();
  const { FS } = wasm(), folder = `/oncollide-${++folders}`, written = [];
  const write = (path, content) => {
    const parts = path.split(/[\\/]/).filter((part) => part && part !== '.');
    if (parts.length === 0 || parts.includes('..')) throw new OncollideError('usage', `load: '${path}' is no name of a file`);
    const place = [folder, ...parts].join('/');
    FS.mkdirTree(place.slice(0, place.lastIndexOf('/')));
    FS.writeFile(place, content instanceof ArrayBuffer ? new Uint8Array(content) : content);
    written.push(place);
    return place;
  };
  try {
    for (const [path, content] of Object.entries(files)) write(path, content);
    const path = write(name, bytes);
    const [at, called, made] = put(path, name, room);
    call('_oc_load', at, scale, fitDiagonal, centre, called, made);
    return new Geometry(pointerAt(made), name);
  } catch (error) {
    if (error instanceof OncollideError) throw new OncollideError(error.kind, error.message.replaceAll(`${folder}/`, ''));
    throw error;
  } finally {
    for (const place of written) FS.unlink(place);
  }
}

function sample(kind, numbers, triangles, name) {
  const [called, made] = put(name, room);
  call('_oc_sample', kind, ...numbers, ...new Array(5 - numbers.length).fill(0), triangles, called, made);
  return new Geometry(pointerAt(made), name);
}
export const boxMesh = (half, { name = '' } = {}) => sample(0, [...half], 12, name);
export const sphereMesh = (radius, triangles, { name = '' } = {}) => sample(1, [radius], triangles, name);
export const torusMesh = (major, minor, triangles, { name = '' } = {}) => sample(2, [major, minor], triangles, name);
export const torusKnotMesh = (p, q, major, minor, tube, triangles, { name = '' } = {}) =>
  sample(3, [p, q, major, minor, tube], triangles, name);
