// psim for JavaScript: an ES module for browsers, workers and Node. psim.d.ts describes every function.
import { abilities } from './abilities.mjs';
import { Memory } from './memory.mjs';
import { Scene } from './scene.mjs';
import { World } from './world.mjs';

export { abilities } from './abilities.mjs';

const isNode = typeof process === 'object' && process.versions?.node !== undefined && globalThis.window === undefined;

/** Which module to load, and in words what the machine lacks for a better one. */
function choose(options) {
  const able = options.abilities ?? abilities();
  const notes = [];
  if (!able.exceptions) throw new Error('psim: this browser is too old: WebAssembly has no exceptions here');
  let threads = Math.max(1, Math.min(Math.floor(options.threads ?? 1), 16));
  if (!able.simd) notes.push('WebAssembly has no SIMD here: scalar kernels do the work, slower, with the same bits');
  if (threads > 1 && isNode) {
    notes.push('in Node the library runs on one thread; psim.mjs, the program, has threads');
    threads = 1;
  } else if (threads > 1 && !(able.threads && able.simd)) {
    notes.push('no shared memory here (a page needs the headers COOP and COEP): one thread does the work');
    threads = 1;
  }
  const module = !able.simd ? 'psim-plain' : threads > 1 ? 'psim-simd-threads' : 'psim-simd';
  return { module, threads, notes };
}

export async function load(options = {}) {
  const { module, threads, notes } = choose(options);
  const settings = { threads };
  const folder = new URL('./wasm/', import.meta.url);
  if (isNode) {
    const { readFile } = await import('node:fs/promises');
    settings.wasmBinary = await readFile(new URL(`${module}.wasm`, folder));
  } else {
    settings.locateFile = (file) => new URL(file, folder).href;
  }
  const { default: start } = await import(new URL(`${module}.mjs`, folder).href);
  return new Psim(new Memory(await start(settings)), module, threads, notes);
}

class Psim {
  #memory;

  constructor(memory, module, threads, notes) {
    this.#memory = memory;
    this.module = module;
    this.threads = threads;
    memory.call('_psim_flat_start_workers', threads);
    this.notes = notes;
    this.version = memory.text(memory.call('_psim_version'));
    this.isas = [0, 1, 2, 3, 4, 5, 6, 7]
      .filter((isa) => memory.call('_psim_isa_available', isa))
      .map((isa) => memory.text(memory.call('_psim_isa_name', isa)));
  }

  /** The built-in scenes. */
  get scenes() {
    const m = this.#memory;
    const all = [];
    for (let k = 0, name; (name = m.call('_psim_flat_builtin_name', k)) !== 0; ++k) {
      const count = m.call('_psim_flat_builtin_count', k);
      const description = m.text(m.call('_psim_flat_builtin_words', k));
      all.push({ name: m.text(name), description, bodies: Math.abs(count), sized: count > 0 });
    }
    return all;
  }

  builtin(name, { bodies = 0, seed = 1 } = {}) {
    const m = this.#memory;
    return new Scene(m, m.withText(name, (at) => m.call('_psim_flat_builtin', at, bodies, seed)), this);
  }

  scene(json, file = 'scene') {
    const m = this.#memory;
    const text = typeof json === 'string' ? json : JSON.stringify(json);
    const parse = (at) => m.withText(file, (name) => m.call('_psim_flat_parse', at, name));
    return new Scene(m, m.withText(text, parse), this);
  }

  /** A world of a scene that is used once. */
  world(json, options) {
    const scene = this.scene(json);
    try {
      return scene.world(options);
    } finally {
      scene.free();
    }
  }

  restore(bytes, options = {}) {
    const m = this.#memory;
    return m.withBytes(2 * bytes.length, (at) => {
      m.u8.set(bytes, at);
      const isa = this.isaNumber(options.isa);
      const world = m.call('_psim_flat_restore', at, bytes.length, at + bytes.length, isa);
      return new World(m, m.need(world), this);
    });
  }

  /** The number of a forced instruction set; -1 for the best. */
  isaNumber(name = 'auto') {
    if (name === 'auto') return -1;
    if (!this.isas.includes(name)) {
      throw new Error(`psim: isa ${name}: this module lacks it; it has ${this.isas.join(' and ')}`);
    }
    const m = this.#memory;
    return m.withText(name, (at) => m.numbers(1, (out) => (m.call('_psim_parse_isa', at, out), m.i32[out >> 2])));
  }
}
