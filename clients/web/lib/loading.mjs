// Loading the WebAssembly module. It has two parts: oncollide.wasm, and oncollide-rest.wasm with the functions that most calls do
// without (split/first_part.mjs). In the table of functions, stand-ins hold their places until they are loaded.
import create from '../wasm/oncollide.mjs';

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

export const reasonOf = (fault) => fault?.message ?? String(fault);
const isPlace = (source) => typeof source === 'string' || source instanceof URL;
const urlOf = (place) => new URL(place, globalThis.document?.baseURI ?? import.meta.url);
const isFile = (url, fs) => fs && url.protocol === 'file:';

async function bytesOf(source, fs) {
  if (!isPlace(source)) return source;
  const url = urlOf(source);
  if (isFile(url, fs)) return fs.promises.readFile(url);
  const response = await fetch(url);
  if (!response.ok) throw new Error(`HTTP ${response.status} for ${url}`);
  return response.arrayBuffer();
}

const compiledOf = async (source, fs) => (source instanceof WebAssembly.Module ? source : WebAssembly.compile(await bytesOf(source, fs)));

/** The bytes in the middle of a call, which cannot wait for a promise. */
function bytesNow(source, fs) {
  if (!isPlace(source)) return source;
  const url = urlOf(source);
  if (isFile(url, fs)) return fs.readFileSync(url);
  if (!globalThis.XMLHttpRequest) throw new Error('this runtime cannot read it during a call');
  const request = new XMLHttpRequest();
  request.open('GET', url, false);
  request.overrideMimeType('text/plain; charset=x-user-defined'); // pages get no bytes here, but letters that end in them
  request.send();
  if (request.status !== 200 && url.protocol.startsWith('http')) throw new Error(`HTTP ${request.status}`);
  return Uint8Array.from(request.responseText, (letter) => letter.charCodeAt(0) & 255);
}

/** Both parts hold the number of the build that made them. */
const buildOf = (compiled) => new TextDecoder().decode(WebAssembly.Module.customSections(compiled, 'oncollide.build')[0] ?? new ArrayBuffer(0));

/** The second part: functions that the first part calls through its table. */
class Rest {
  #source; // null: it is loaded
  #fs;
  #build;
  #first = null; // what the first part exports
  #loading = null;
  /** Why a call stopped half-way; the module can no longer be used. */
  fault = null;
  constructor(source, fs, first) {
    this.#source = source, this.#fs = fs, this.#build = buildOf(first);
  }
  setFirst(exports) {
    this.#first = exports;
  }
  /** Each loads the rest, which takes all their places, and passes its call on. */
  standIns() {
    const standIn = (place) => (...values) => {
      try {
        this.loadNow();
      } catch (fault) {
        throw this.fault = fault;
      }
      return this.#first.__indirect_function_table.get(place)(...values);
    };
    return new Proxy({}, { get: (_, place) => standIn(Number(place)) });
  }
  load() {
    this.#loading ??= this.#load().catch((fault) => {
      this.#loading = null;
      throw refusal(fault);
    });
    return this.#loading;
  }
  async #load() {
    const source = this.#source;
    if (!source) return;
    const compiled = this.#checked(await compiledOf(source, this.#fs));
    if (this.#source) await WebAssembly.instantiate(compiled, { primary: this.#first });
    this.#source = null;
  }
  loadNow() {
    const source = this.#source;
    if (!source) return;
    try {
      const compiled = this.#checked(source instanceof WebAssembly.Module ? source : new WebAssembly.Module(bytesNow(source, this.#fs)));
      new WebAssembly.Instance(compiled, { primary: this.#first });
      this.#source = null;
    } catch (fault) {
      throw refusal(fault);
    }
  }
  #checked(compiled) {
    if (buildOf(compiled) !== this.#build) throw new Error('it is of another build than oncollide.wasm');
    return compiled;
  }
}
const refusal = (fault) => new OncollideError('no_input',
  `oncollide-rest.wasm: ${reasonOf(fault)}; put it beside oncollide.wasm, or pass its place to ready({ rest }), and call await whole() before all other calls`);

/** Loads the first part: Emscripten's module, and its Rest. */
export async function load({ wasm, rest } = {}) {
  const fs = globalThis.process?.versions?.node ? await import(/* webpackIgnore: true */ /* @vite-ignore */ 'node:fs') : null;
  const source = wasm ?? new URL('../wasm/oncollide.wasm', import.meta.url);
  const compiled = await compiledOf(source, fs);
  const divided = WebAssembly.Module.imports(compiled).some(({ module }) => module === 'placeholder');
  const beside = () => (isPlace(wasm) ? new URL('oncollide-rest.wasm', urlOf(wasm)) : new URL('../wasm/oncollide-rest.wasm', import.meta.url));
  const second = new Rest(divided ? rest ?? beside() : null, fs, compiled);
  const module = await new Promise((resolve, reject) => {
    create({
      locateFile: (name) => name, // the module is compiled already
      instantiateWasm(imports, done) {
        WebAssembly.instantiate(compiled, { ...imports, placeholder: second.standIns() }).then((instance) => {
          second.setFirst(instance.exports);
          done(instance, compiled);
        }, reject);
        return {};
      },
    }).then(resolve, reject);
  });
  return { module, rest: second };
}
