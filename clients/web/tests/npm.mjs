// Where the package under test is: the build's, or one that was installed.
import { existsSync, readdirSync, readFileSync } from 'node:fs';
import { resolve } from 'node:path';
import { fileURLToPath, pathToFileURL } from 'node:url';

const here = fileURLToPath(new URL('.', import.meta.url));
export const folder = resolve(process.env.ONCOLLIDE_NPM ?? resolve(here, '../../../build/wasm/npm'));
const sources = resolve(here, '../lib');
const same = (file) => existsSync(`${folder}/lib/${file}`) && readFileSync(`${folder}/lib/${file}`).equals(readFileSync(`${sources}/${file}`));
const there = existsSync(`${folder}/wasm/oncollide.wasm`), current = there && readdirSync(sources).every(same);
const cure = "run './dev build --preset wasm'";
// The tests of a build for another system find the package as it was built some time ago.
if (there && !current && !process.env.ONCOLLIDE_NPM_MAY_BE_OLD) throw new Error(`${folder}/lib is not ${sources}; ${cure}`);
export const built = current;
export const why = built ? false : there ? `${folder} was built from other sources; ${cure}` : `${folder} has no wasm/oncollide.wasm; ${cure}`;
export const load = (file) => import(pathToFileURL(`${folder}/lib/${file}`).href);

/** three.js of bench/, or Debian's; null: neither is installed. */
export async function three() {
  for (const place of [resolve(here, '../bench/node_modules/three/build/three.module.js'), '/usr/share/javascript/three/build/three.module.js',
    '/usr/share/javascript/three/three.module.js'])
    if (existsSync(place)) return import(pathToFileURL(place).href);
  return null;
}
