// The two parts of the module.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { createServer } from 'node:http';
import { readFileSync } from 'node:fs';
import { test } from 'node:test';
import { pathToFileURL } from 'node:url';
import { gzipSync } from 'node:zlib';
import { Browser, missing } from './browser.mjs';
import { folder, why } from './npm.mjs';

const check = (name, run) => test(name, { skip: why, timeout: 200000 }, run);
const file = (name) => pathToFileURL(`${folder}/${name}`).href;
/** Runs a program in a process of its own: each loads the module once. */
function program(text) {
  const source = `import * as oc from '${file('lib/index.mjs')}';
    const refused = (run) => { try { run(); } catch (error) { return [error instanceof oc.OncollideError, error.kind, error.message]; } };
    const hull = [0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1];
    ${text}`;
  const { status, stdout, stderr } = spawnSync(process.execPath, ['--input-type=module', '-e', source], { encoding: 'utf8' });
  assert.equal(status, 0, stderr);
  return JSON.parse(stdout);
}
const absent = `{ rest: '${file('wasm/absent.wasm')}' }`;

check('the first part is small, and both are of one build', () => {
  const parts = ['oncollide', 'oncollide-rest'].map((name) => readFileSync(`${folder}/wasm/${name}.wasm`));
  assert.ok(parts[0].length <= 1200000, `${parts[0].length} bytes`);
  const packed = gzipSync(parts[0], { level: 9 }).length;
  assert.ok(packed <= 450000, `${packed} bytes after gzip`);
  const [first, rest] = parts.map((bytes) => new TextDecoder().decode(WebAssembly.Module.customSections(new WebAssembly.Module(bytes), 'oncollide.build')[0]));
  assert.match(first, /^[0-9a-f]{16}$/);
  assert.equal(first, rest);
});

check('the first part alone answers questions about meshes and shapes', () => {
  const url = new URL('../split/first_part.mjs', import.meta.url).href;
  assert.equal(program(`const { firstPart } = await import('${url}'); await oc.ready(${absent}); firstPart(oc); console.log('true');`), true);
});

check('without the rest, what needs it is refused, and changes nothing', () => {
  const [whole, before, after] = program(`await oc.ready(${absent});
    const world = new oc.World(), ball = world.models.add(oc.sphere(1)), [a, b] = [0, 1.5].map((x) => world.bodies.add(ball, oc.pose([x, 0, 0])));
    const whole = await oc.whole().catch((error) => [error instanceof oc.OncollideError, error.kind, error.message]);
    console.log(JSON.stringify([whole, refused(() => oc.convexHull(hull)), world.pairs.decide(a, b).verdict]));`);
  for (const [ours, kind, message] of [whole, before]) {
    assert.deepEqual([ours, kind], [true, 'no_input']);
    assert.match(message, /oncollide-rest\.wasm: .*absent\.wasm.*; put it beside oncollide\.wasm/);
  }
  assert.equal(after, 2);
});

check('a call that stops because the rest is missing ends the use of the module', () => {
  const [first, second] = program(`await oc.ready(${absent});
    const world = new oc.World(), ball = world.models.add(oc.sphere(1)), side = { model: ball };
    console.log(JSON.stringify([refused(() => world.pairs.manifold(side, { model: ball, pose: oc.pose([1.5, 0, 0]) })), refused(() => new oc.World())]));`);
  assert.deepEqual([first.slice(0, 2), second], [[true, 'no_input'], first]);
});

check('a rest of another build is refused', () => {
  const [, kind, message] = program(`import { readFileSync } from 'node:fs';
    const bytes = readFileSync(new URL('${file('wasm/oncollide-rest.wasm')}'));
    bytes[bytes.length - 1] ^= 1;
    await oc.ready({ rest: bytes });
    console.log(JSON.stringify(refused(() => oc.convexHull(hull))));`);
  assert.equal(kind, 'no_input');
  assert.match(message, /another build/);
});

check('the rest is loaded during a call, in the background, and from bytes', () => {
  assert.deepEqual(program(`await oc.ready();
    const now = oc.convexHull(hull).kind;
    await oc.whole();
    console.log(JSON.stringify([now, oc.terrain(new Float64Array(9), 3).kind]));`), ['hull', 'terrain']);
  assert.equal(program(`import { readFileSync } from 'node:fs';
    await oc.ready({ wasm: readFileSync(new URL('${file('wasm/oncollide.wasm')}')), rest: new WebAssembly.Module(readFileSync(new URL('${file('wasm/oncollide-rest.wasm')}'))) });
    console.log(JSON.stringify(oc.convexHull(hull).kind));`), 'hull');
});

test('in a browser, a call that needs the rest early waits for it', { skip: why || missing, timeout: 200000 }, async () => {
  const asked = [], page = `<script type="module">
    import * as oc from '/lib/index.mjs';
    try {
      await oc.ready();
      window.before = oc.boxMesh([1, 1, 1]).faceCount;
      window.found = [oc.convexHull([0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1]).kind, oc.terrain(new Float64Array(9), 3).kind];
      await oc.whole();
      window.done = 'done';
    } catch (error) { window.done = error.message; }
  </script>`;
  const server = createServer((request, response) => {
    asked.push(request.url);
    const again = asked.filter((url) => url === request.url).length > 1, rest = request.url.endsWith('oncollide-rest.wasm');
    const send = () => {
      const html = request.url === '/', type = html ? 'text/html' : request.url.endsWith('.mjs') ? 'text/javascript' : 'application/wasm';
      try {
        const content = html ? page : readFileSync(`${folder}${request.url}`);
        response.writeHead(200, { 'content-type': type, 'cache-control': 'no-store' }).end(content);
      } catch {
        response.writeHead(404).end();
      }
    };
    if (rest && !again) setTimeout(send, 3000); // the one in the background is slow
    else send();
  });
  await new Promise((done) => server.listen(0, '127.0.0.1', done));
  const browser = await Browser.open(`http://127.0.0.1:${server.address().port}/`, { width: 400, height: 300 });
  try {
    await browser.until('window.done');
    assert.equal(await browser.value('window.done'), 'done');
    assert.deepEqual(await browser.value('[window.before, ...window.found]'), [12, 'hull', 'terrain']);
    assert.equal(asked.filter((url) => url.endsWith('oncollide-rest.wasm')).length, 2);
  } finally {
    await browser.close();
    server.close(), server.closeAllConnections();
  }
});
