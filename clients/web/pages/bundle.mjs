// Writes pages/try.html as one file, with the package's modules and its WebAssembly inside, which is not divided here.
// usage: node bundle.mjs NPM_FOLDER WHOLE.wasm OUTPUT.html
import { readFileSync, writeFileSync } from 'node:fs';
import { gzipSync } from 'node:zlib';

const [npm, whole, output] = process.argv.slice(2);
const pages = new URL('.', import.meta.url);
// Each after those that it imports.
const modules = ['wasm/oncollide.mjs', 'lib/loading.mjs', 'lib/module.mjs', 'lib/columns.mjs', 'lib/poses.mjs', 'lib/geometry.mjs', 'lib/bodies.mjs', 'lib/pairs.mjs',
  'lib/space.mjs', 'lib/world.mjs', 'lib/index.mjs', 'pages/gl.mjs', 'pages/pair.mjs', 'pages/crowd.mjs'];
const text = (name) => readFileSync(name.startsWith('pages/') ? new URL(name.slice(6), pages) : `${npm}/${name}`, 'utf8');
const sources = modules.map((name) => {
  const source = text(name);
  if (/<\/script|<!--/i.test(source)) throw new Error(`${name} holds a mark that would end it in HTML`);
  return `<script type="text/plain" data-module="${name}">${source}</script>`;
});
sources.push(`<script type="text/plain" id="wasm">${gzipSync(readFileSync(whole), { level: 9 }).toString('base64')}</script>`);
const page = text('pages/try.html');
if (!page.includes('<!-- sources -->')) throw new Error('try.html has no place for the sources');
writeFileSync(output, page.replace('<!-- sources -->', () => sources.join('\n')));
