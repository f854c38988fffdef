import assert from 'node:assert/strict';
import { existsSync, writeFileSync } from 'node:fs';
import { resolve } from 'node:path';
import { test } from 'node:test';
import { pathToFileURL } from 'node:url';
import { Browser, missing } from './browser.mjs';

const page = process.env.ONCOLLIDE_TRY_PAGE ?? resolve(import.meta.dirname ?? '.', '../../../build/wasm/try.html');
const skip = missing || (existsSync(page) ? false : `${page} is missing; run './dev build --preset wasm'`);

async function open(size, run) {
  const browser = await Browser.open(pathToFileURL(page).href, size);
  try {
    await browser.until('document.body?.dataset.ready');
    assert.equal(await browser.value("document.getElementById('fault').textContent"), '');
    await run(browser);
    if (process.env.ONCOLLIDE_PICTURES) writeFileSync(`${process.env.ONCOLLIDE_PICTURES}/try-${size.width}.png`, await browser.picture());
  } finally {
    await browser.close();
  }
}
const text = (name) => `document.querySelector('#pair [data-${name}]').textContent`;

test('the page decides, measures and draws as its meshes are dragged, by mouse and by keyboard', { skip, timeout: 200000 }, () =>
  open({ width: 1200, height: 900 }, async (browser) => {
    assert.equal(await browser.value(text('verdict')), 'separate');
    assert.match(await browser.value(text('distance')), /^0\.\d{6} to 0\.\d{6} m apart$/);
    assert.match(await browser.value(text('time')), /^[\d.]+ µs$/);
    const [x, y] = await browser.value("(() => { const r = document.querySelector('#pair canvas').getBoundingClientRect(); return [r.x + r.width / 2, r.y + r.height / 2]; })()");
    const before = await browser.value('oncollidePages.pair.sides[1].at');
    await browser.drag([x, y], [x - 120, y]);
    assert.notDeepEqual(await browser.value('oncollidePages.pair.sides[1].at'), before);
    await browser.value("oncollidePages.pair.sides[1].at = [1.6, 0, 0]; oncollidePages.pair.update(); document.querySelector('#pair canvas').focus()");
    assert.equal(await browser.value(text('verdict')), 'colliding');
    assert.match(await browser.value(text('distance')), /^\d+ pairs of triangles meet$/);
    await browser.value('oncollidePages.pair.sides[1].at = [2.6, 0, 0]; oncollidePages.pair.update()');
    const [at, turn] = await browser.value('[oncollidePages.pair.sides[1].at, oncollidePages.pair.sides[1].turn]');
    await browser.press('ArrowRight');
    await browser.press('ArrowUp', 8); // Shift
    assert.notDeepEqual(await browser.value('oncollidePages.pair.sides[1].at'), at);
    assert.notDeepEqual(await browser.value('oncollidePages.pair.sides[1].turn'), turn);
  }));

test('a smaller error grows larger sphere-trees, and only where the meshes come near', { skip, timeout: 200000 }, () =>
  open({ width: 1200, height: 900 }, async (browser) => {
    const cells = async (dial, at) => {
      await browser.value(`oncollidePages.pair.sides[1].at = [${at}, 0, 0];
        const dial = document.querySelector('[data-dial]'); dial.value = ${dial}; dial.dispatchEvent(new Event('input'))`.replace('const dial', 'var dial'));
      return Number((await browser.value(text('dialled'))).match(/hold (\d+) cells/)[1]);
    };
    const [far, rough, fine] = [await cells(-2, 8), await cells(-0.5, 2.1), await cells(-2, 2.1)];
    assert.ok(far < rough && rough < fine, `${far} ${rough} ${fine}`);
    // What is drawn are pixels of both meshes and of the spheres.
    const colors = `(() => { const c = document.querySelector('#pair canvas'), g = c.getContext('webgl2'), p = new Uint8Array(4 * c.width * c.height);
      g.readPixels(0, 0, c.width, c.height, g.RGBA, g.UNSIGNED_BYTE, p); const s = new Set(); for (let i = 0; i < p.length; i += 4) s.add(p[i] << 16 | p[i + 1] << 8 | p[i + 2]); return s.size; })()`;
    assert.ok(await browser.value(colors) > 50);
  }));

test('files that are dropped are read, and refused with their fault', { skip, timeout: 200000 }, () =>
  open({ width: 1200, height: 900 }, async (browser) => {
    const drop = (name, content) => browser.value(`oncollidePages.pair.take(new File([${JSON.stringify(content)}], '${name}'), 1)`);
    await drop('four.obj', 'v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n');
    assert.equal(await browser.value('oncollidePages.pair.sides[1].faces'), 4);
    assert.equal(await browser.value(text('error-text')), '');
    await drop('cut.stl', 'solid x\nfacet normal 0 0');
    assert.match(await browser.value(text('error-text')), /cut\.stl/);
    assert.equal(await browser.value('oncollidePages.pair.sides[1].faces'), 4);
  }));

test('2,000 bodies move, and the red ones collide', { skip, timeout: 200000 }, () =>
  open({ width: 1200, height: 900 }, async (browser) => {
    await browser.until('oncollidePages.crowd.times.length >= 5');
    assert.equal(await browser.value('oncollidePages.crowd.crowd.bodies.length'), 2000);
    assert.ok(await browser.value('oncollidePages.crowd.crowd.pairs') > 10);
    assert.equal(await browser.value('oncollidePages.crowd.crowd.red.reduce((a, b) => a + b, 0) > 10'), true);
    assert.match(await browser.value("document.querySelector('#crowd [data-time]').textContent"), /^[\d.]+ ms$/);
    await browser.value("document.querySelector('#crowd canvas').focus()");
    await browser.press(' ');
    assert.equal(await browser.value("document.querySelector('[data-pause]').textContent"), 'Go on');
  }));

test('the page fits a phone', { skip, timeout: 200000 }, () =>
  open({ width: 375, height: 700, mobile: true }, async (browser) => {
    assert.ok(await browser.value('document.documentElement.scrollWidth <= innerWidth'), 'it is wider than the screen');
    const [wide] = await browser.value("[document.querySelector('#pair canvas').clientWidth]");
    assert.ok(wide > 300 && wide <= 375, String(wide));
  }));
