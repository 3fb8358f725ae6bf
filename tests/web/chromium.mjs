// Headless Chromium through the pipe of its debugging protocol: messages that end with a NUL, without another package.
import { spawn, spawnSync } from 'node:child_process';
import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';

export const browser = ['chromium', 'chromium-browser', 'google-chrome'].find((name) =>
  spawnSync('sh', ['-c', `command -v ${name}`]).status === 0);

const patience = 60;  // s

export class Chromium {
  #next = 1;
  #waiting = new Map();
  events = [];

  static async open(address, { width, height, touch = false }) {
    const chromium = new Chromium();
    try {
      await chromium.#open(address, width, height, touch);
    } catch (error) {
      await chromium.close();
      throw error;
    }
    return chromium;
  }

  async #open(address, width, height, touch) {
    this.profile = mkdtempSync(`${tmpdir()}/psim-chromium-`);
    const words = ['--headless=new', '--no-sandbox', '--remote-debugging-pipe', `--user-data-dir=${this.profile}`,
                   '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--no-first-run',
                   '--disable-dev-shm-usage', 'about:blank'];
    this.process = spawn(browser, words, { stdio: ['ignore', 'ignore', 'ignore', 'pipe', 'pipe'] });
    this.#watch();
    this.#listen(this.process.stdio[4]);
    const { targetInfos } = await this.send('Target.getTargets');
    const { targetId } = targetInfos.find((target) => target.type === 'page');
    ({ sessionId: this.session } = await this.send('Target.attachToTarget', { targetId, flatten: true }));
    await this.send('Page.enable');
    await this.send('Runtime.enable');
    const mobile = touch;
    await this.send('Emulation.setDeviceMetricsOverride', { width, height, deviceScaleFactor: 1, mobile });
    if (touch) await this.send('Emulation.setTouchEmulationEnabled', { enabled: true });
    await this.send('Page.navigate', { url: address });
  }

  /** A browser that ends, for whatever reason, answers nothing any more. */
  #watch() {
    this.process.stdio[3].on('error', () => {});
    this.ended = new Promise((done) => this.process.once('exit', done));
    this.ended.then(() => {
      for (const { failed } of this.#waiting.values()) failed(new Error('Chromium has ended'));
    });
  }

  #listen(stream) {
    let rest = '';
    stream.setEncoding('utf8');
    stream.on('data', (text) => {
      const messages = (rest + text).split('\0');
      rest = messages.pop();
      for (const message of messages.map((m) => JSON.parse(m))) {
        const waiting = this.#waiting.get(message.id);
        this.#waiting.delete(message.id);
        if (!waiting) this.events.push(message);
        else if (message.error) waiting.failed(new Error(message.error.message));
        else waiting.done(message.result);
      }
    });
  }

  send(method, params = {}) {
    const id = this.#next++;
    const message = { id, method, params, ...(this.session && { sessionId: this.session }) };
    this.process.stdio[3].write(`${JSON.stringify(message)}\0`);
    return new Promise((done, failed) => {
      const late = setTimeout(() => failed(new Error(`no answer to ${method} within ${patience} s`)), 1000 * patience);
      const settle = (how) => (what) => (clearTimeout(late), how(what));
      this.#waiting.set(id, { done: settle(done), failed: settle(failed) });
    });
  }

  /** The value of an expression in the page. */
  async ask(expression) {
    const { result, exceptionDetails } = await this.send('Runtime.evaluate', {
      expression, awaitPromise: true, returnByValue: true,
    });
    if (exceptionDetails) throw new Error(exceptionDetails.exception?.description ?? exceptionDetails.text);
    return result.value;
  }

  async until(expression, seconds = 60) {
    for (let k = 0; k < 10 * seconds; ++k) {
      if (await this.ask(expression).catch(() => false)) return;
      await new Promise((done) => setTimeout(done, 100));
    }
    throw new Error(`never came true: ${expression}; the page says: ${await this.ask('document.body.innerText')}`);
  }

  mouse(type, x, y, more = {}) {
    return this.send('Input.dispatchMouseEvent', { type, x, y, button: 'left', buttons: 1, clickCount: 1, ...more });
  }

  touch(type, ...points) {
    return this.send('Input.dispatchTouchEvent', { type, touchPoints: points.map(([x, y], id) => ({ x, y, id })) });
  }

  async picture() {
    const { data } = await this.send('Page.captureScreenshot', { format: 'png' });
    return Buffer.from(data, 'base64');
  }

  get errors() {
    return this.events.filter(({ method }) => method === 'Runtime.exceptionThrown').map(({ params }) =>
      params.exceptionDetails.exception?.description ?? params.exceptionDetails.text);
  }

  async close() {
    const late = setTimeout(() => this.process.kill('SIGKILL'), 10_000);
    this.send('Browser.close').catch(() => {});
    await this.ended;
    clearTimeout(late);
    rmSync(this.profile, { recursive: true, force: true, maxRetries: 30, retryDelay: 100 });  // its children end later
  }
}
