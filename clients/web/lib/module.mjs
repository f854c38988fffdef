// The WebAssembly module: loading it, calling its functions, arrays in, columns out, errors.
import create from '../wasm/oncollide.mjs';

const kinds = { 64: 'usage', 65: 'bad_data', 66: 'no_input', 70: 'internal', 71: 'no_gpu', 73: 'cannot_write' };

export class OncollideError extends Error {
  constructor(kind, message) {
    super(message);
    this.name = 'OncollideError';
    this.kind = kind;
  }
  /** The part of the message that names the cure, behind its last semicolon; empty if it has none. */
  get cure() {
    const at = this.message.lastIndexOf('; ');
    return at < 0 ? '' : this.message.slice(at + 2);
  }
}

let module = null, loading = null;

async function bytesOf(source) {
  if (source instanceof ArrayBuffer || ArrayBuffer.isView(source)) return source;
  const url = source instanceof URL ? source : new URL(source, globalThis.document?.baseURI ?? import.meta.url);
  if (url.protocol === 'file:' && globalThis.process?.versions?.node) {
    const { readFile } = await import(/* webpackIgnore: true */ /* @vite-ignore */ 'node:fs/promises');
    return readFile(url);
  }
  const response = await fetch(url);
  if (!response.ok) throw new OncollideError('no_input', `${url}: HTTP ${response.status}; pass the place of oncollide.wasm to ready({ wasm })`);
  return response.arrayBuffer();
}

async function load(source) {
  const compiled = source instanceof WebAssembly.Module ? source : await WebAssembly.compile(await bytesOf(source));
  return new Promise((resolve, reject) => {
    create({
      locateFile: (name) => name, // the module is compiled already
      instantiateWasm(imports, done) {
        WebAssembly.instantiate(compiled, imports).then((instance) => done(instance, compiled), reject);
        return {};
      },
    }).then(resolve, reject);
  });
}

export function ready(options = {}) {
  loading ??= load(options.wasm ?? new URL('../wasm/oncollide.wasm', import.meta.url)).then(
    (loaded) => { module = loaded; },
    (fault) => {
      loading = null;
      throw fault instanceof OncollideError ? fault : new OncollideError('no_input', `oncollide.wasm: ${fault.message ?? fault}; it needs a runtime with SIMD and exceptions of WebAssembly, such as Chrome 95, Firefox 100, Safari 16.4 or Node.js 18`);
    });
  return loading;
}

export function wasm() {
  if (!module) throw new OncollideError('usage', 'oncollide is not loaded yet; call await ready() first');
  return module;
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
