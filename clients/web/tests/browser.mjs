// Chromium, headless, by its debugging protocol over a pipe.
import { spawn } from 'node:child_process';
import { existsSync, mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';

export const chromium = '/usr/bin/chromium'; // Debian's
export const missing = existsSync(chromium) ? false : "needs Debian's package chromium";

export class Browser {
  #calls = new Map();
  #count = 0;
  #text = '';
  /** Opens a page of the given size in pixels. */
  static async open(url, { width, height, mobile = false }) {
    const browser = new Browser();
    browser.folder = mkdtempSync(join(tmpdir(), 'oncollide-browser-'));
    browser.process = spawn(chromium, ['--headless', '--no-sandbox', '--no-first-run', '--disable-background-networking', '--remote-debugging-pipe',
      '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1', `--user-data-dir=${browser.folder}`],
    { stdio: ['ignore', 'ignore', 'ignore', 'pipe', 'pipe'], detached: true }); // a group of its own
    browser.process.stdio[4].on('data', (data) => browser.#take(String(data)));
    const { targetId } = await browser.send('Target.createTarget', { url: 'about:blank' });
    ({ sessionId: browser.session } = await browser.send('Target.attachToTarget', { targetId, flatten: true }));
    await browser.send('Emulation.setDeviceMetricsOverride', { width, height, deviceScaleFactor: 1, mobile });
    await browser.send('Page.enable');
    await browser.send('Page.navigate', { url });
    return browser;
  }
  #take(data) {
    this.#text += data;
    const messages = this.#text.split('\0');
    this.#text = messages.pop();
    for (const message of messages) {
      const { id, result, error } = JSON.parse(message);
      if (!id) continue;
      const [resolve, reject] = this.#calls.get(id);
      this.#calls.delete(id);
      if (error) reject(new Error(error.message));
      else resolve(result);
    }
  }
  send(method, params = {}) {
    const id = ++this.#count;
    this.process.stdio[3].write(`${JSON.stringify({ id, method, params, sessionId: this.session })}\0`);
    return new Promise((resolve, reject) => this.#calls.set(id, [resolve, reject]));
  }
  /** The value of an expression in the page. */
  async value(expression) {
    const { result, exceptionDetails } = await this.send('Runtime.evaluate', { expression, returnByValue: true, awaitPromise: true });
    if (exceptionDetails) throw new Error(exceptionDetails.exception?.description ?? exceptionDetails.text);
    return result.value;
  }
  async until(expression, seconds = 60) {
    for (const end = Date.now() + 1000 * seconds; Date.now() < end;) {
      if (await this.value(expression)) return;
      await new Promise((done) => setTimeout(done, 100));
    }
    throw new Error(`not true after ${seconds} s: ${expression}`);
  }
  async press(key, modifiers = 0) {
    for (const type of ['keyDown', 'keyUp']) await this.send('Input.dispatchKeyEvent', { type, key, code: key, modifiers });
  }
  async drag(from, to) {
    const mouse = (type, [x, y], buttons) => this.send('Input.dispatchMouseEvent', { type, x, y, button: 'left', buttons, clickCount: 1 });
    await mouse('mousePressed', from, 1);
    for (let i = 1; i <= 5; ++i) await mouse('mouseMoved', from.map((number, k) => number + ((to[k] - number) * i) / 5), 1);
    await mouse('mouseReleased', to, 0);
  }
  async picture() {
    return Buffer.from((await this.send('Page.captureScreenshot', { format: 'png' })).data, 'base64');
  }
  async close() {
    process.kill(-this.process.pid, 'SIGKILL'); // with its helpers, which write to the folder, too
    await new Promise((done) => this.process.on('close', done));
    rmSync(this.folder, { recursive: true, force: true, maxRetries: 20, retryDelay: 100 });
  }
}
