// Where the package under test is: the build's, or one that was installed.
import { existsSync } from 'node:fs';
import { resolve } from 'node:path';
import { fileURLToPath, pathToFileURL } from 'node:url';

const here = fileURLToPath(new URL('.', import.meta.url));
export const folder = resolve(process.env.ONCOLLIDE_NPM ?? resolve(here, '../../../build/wasm/npm'));
export const built = existsSync(`${folder}/wasm/oncollide.wasm`);
export const why = built ? false : `${folder} has no wasm/oncollide.wasm; run './dev build --preset wasm'`;
export const load = (file) => import(pathToFileURL(`${folder}/lib/${file}`).href);

/** three.js of bench/, or Debian's; null: neither is installed. */
export async function three() {
  for (const place of [resolve(here, '../bench/node_modules/three/build/three.module.js'), '/usr/share/javascript/three/build/three.module.js',
    '/usr/share/javascript/three/three.module.js'])
    if (existsSync(place)) return import(pathToFileURL(place).href);
  return null;
}
