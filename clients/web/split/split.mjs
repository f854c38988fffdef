// Divides the module into NPM_FOLDER/wasm/oncollide.wasm and oncollide-rest.wasm by Binaryen's wasm-split: the first has the functions
// that first_part.mjs reaches. usage: node split.mjs WHOLE.wasm NPM_FOLDER
import { spawnSync } from 'node:child_process';
import { createHash } from 'node:crypto';
import { mkdtempSync, readFileSync, renameSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';
import { firstPart } from './first_part.mjs';

const [whole, npm] = process.argv.slice(2).map((path) => resolve(path));
const folder = mkdtempSync(join(tmpdir(), 'oncollide-split-'));
const at = (name) => join(folder, name);
const features = ['simd', 'exception-handling', 'mutable-globals', 'sign-ext', 'bulk-memory', 'nontrapping-float-to-int'].map((name) => `--enable-${name}`);
function split(...options) {
  const { status, error, stderr } = spawnSync('wasm-split', [...features, ...options], { encoding: 'utf8' });
  if (status) throw new Error(`wasm-split ${options.join(' ')}: ${error ?? stderr}`);
}

/** For each function that the module defines: whether it takes or returns vectors of 128 bits, which JavaScript cannot pass on. */
function vectorFunctions(bytes) {
  const vector = 0x7b, types = [], functions = [];
  let place = 8;
  const byte = () => bytes[place++];
  function number() {
    let value = 0;
    for (let shift = 0; ; shift += 7) {
      const next = byte();
      value += (next & 127) * 2 ** shift;
      if (next < 128) return value;
    }
  }
  const repeat = (run) => Array.from({ length: number() }, run);
  while (place < bytes.length) {
    const section = byte(), end = number() + place;
    if (section === 1) repeat(() => { byte(); types.push([...repeat(byte), ...repeat(byte)].includes(vector)); });
    if (section === 3) repeat(() => functions.push(types[number()]));
    place = end;
  }
  return functions;
}

/** With a custom section that holds the build's number: of the module, and of how it is divided. */
function marked(bytes, build) {
  const text = (value) => [value.length, ...Buffer.from(value)];
  const content = [...text('oncollide.build'), ...Buffer.from(build)];
  return Buffer.concat([bytes, Buffer.from([0, content.length, ...content])]);
}

try {
  // The profile: 8 bytes, and a number for each function, which is 0 unless it was called.
  split('--instrument', whole, '-o', at('instrumented.wasm'));
  const oc = await import(pathToFileURL(`${npm}/lib/index.mjs`).href), { wasm } = await import(pathToFileURL(`${npm}/lib/module.mjs`).href);
  await oc.ready({ wasm: readFileSync(at('instrumented.wasm')) });
  firstPart(oc);
  const vectors = vectorFunctions(readFileSync(whole)), size = 8 + 4 * vectors.length, module = wasm();
  const buffer = module._malloc(size);
  if (module.asm.__write_profile(buffer, size) !== size) throw new Error('the profile has another size than its functions need');
  const profile = Buffer.from(module.HEAPU8.slice(buffer, buffer + size));
  vectors.forEach((vector, i) => vector && profile.writeUInt32LE(1, 8 + 4 * i));
  writeFileSync(at('profile'), profile);

  split(`--profile=${at('profile')}`, whole, '--export-prefix=%', '-o1', at('oncollide.wasm'), '-o2', at('oncollide-rest.wasm'));
  const build = createHash('sha256').update(readFileSync(whole)).update(profile).digest('hex').slice(0, 16);
  for (const name of ['oncollide.wasm', 'oncollide-rest.wasm']) {
    const target = `${npm}/wasm/${name}`;
    writeFileSync(`${target}.new`, marked(readFileSync(at(name)), build));
    renameSync(`${target}.new`, target);
  }
} finally {
  rmSync(folder, { recursive: true });
}
