// The WebAssembly module: loading it, calling its functions, arrays in, columns out, errors.
import { load, OncollideError, reasonOf } from './loading.mjs';
export { OncollideError };

const kinds = { 64: 'usage', 65: 'bad_data', 66: 'no_input', 70: 'internal', 71: 'no_gpu', 73: 'cannot_write' };

const invalid = 'it must be the file of the package, and the runtime needs SIMD and exceptions of WebAssembly, such as Chrome 95, Firefox 100, Safari 16.4 or Node.js 18 has';

let module = null, rest = null, loading = null;

export function ready(options = {}) {
  loading ??= load(options).then(
    (loaded) => {
      ({ module, rest } = loaded);
      rest.load().catch(() => {}); // whole() tells, and calls that need the rest
    },
    (fault) => {
      loading = null;
      throw new OncollideError('no_input', `oncollide.wasm: ${reasonOf(fault)}; ${fault instanceof WebAssembly.CompileError ? invalid : 'pass its place to ready({ wasm })'}`);
    });
  return loading;
}

export async function whole() {
  await ready();
  await rest.load();
}

export function wasm() {
  if (!module) throw new OncollideError('usage', 'oncollide is not loaded yet; call await ready() first');
  if (rest.fault) throw rest.fault;
  return module;
}

/** For calls that nearly always need the rest: if it cannot be loaded, nothing has changed yet. */
export function needRest() {
  wasm();
  rest.loadNow();
}

function textAt(at) {
  const bytes = module.HEAPU8;
  let end = at;
  while (bytes[end]) ++end;
  return new TextDecoder().decode(bytes.subarray(at, end));
}

/** Calls oc_NAME; throws its error. */
export function call(name, ...args) {
  const kind = wasm()[name](...args);
  if (kind) throw new OncollideError(kinds[kind] ?? 'internal', textAt(module._oc_message()));
}

const bytesFor = (array) => (typeof array === 'string' ? 3 * array.length + 1
  : array instanceof Uint32Array || array instanceof Int32Array || array instanceof Float32Array ? 4 * array.length
    : 8 * array.length);

/**
 * Copies arrays into the module's input buffer, and returns their addresses: typed arrays of 32 bits as they are, others as
 * doubles, strings as UTF-8; null stays 0.
 */
export function put(...arrays) {
  let size = 0;
  for (const array of arrays) if (array !== null) size += (bytesFor(array) + 7) & ~7;
  let at = wasm()._oc_input(size);
  if (!at) throw new OncollideError('internal', `out of memory: ${size} bytes of arguments`);
  const places = [];
  for (const array of arrays) {
    if (array === null) { places.push(0); continue; }
    places.push(at);
    if (typeof array === 'string') {
      const { written } = new TextEncoder().encodeInto(array, module.HEAPU8.subarray(at, at + 3 * array.length));
      module.HEAPU8[at + written] = 0;
    } else if (array instanceof Uint32Array || array instanceof Int32Array) module.HEAP32.set(array, at >> 2);
    else if (array instanceof Float32Array) module.HEAPF32.set(array, at >> 2);
    else module.HEAPF64.set(array, at >> 3);
    at += (bytesFor(array) + 7) & ~7;
  }
  return places;
}

/** Room for one result of a call that writes to an address. */
export const room = new Float64Array(1);
export const pointerAt = (at) => module.HEAPU32[at >> 2];
export const numberAt = (at) => module.HEAPF64[at >> 3];
export { textAt };

export function finite(call_, name, value) {
  if (typeof value !== 'number' || Number.isNaN(value)) throw new OncollideError('usage', `${call_}: ${name} is ${String(value)}; give a number`);
  return value;
}
