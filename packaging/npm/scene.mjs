// A scene: what worlds are made of.
import { World } from './world.mjs';

const kinds = ['disc', 'area', 'line', 'loop', 'parts'];

export class Scene {
  #memory;
  #at;
  #psim;

  constructor(memory, at, psim) {
    this.#memory = memory;
    this.#at = memory.need(at);
    this.#psim = psim;
  }

  get json() { return this.#memory.text(this.#memory.need(this.#memory.call('_psim_flat_scene_json', this.#at))); }
  get bodies() { return this.#memory.call('_psim_flat_scene_bodies', this.#at); }

  set substeps(count) {
    if (!Number.isInteger(count) || count < 1 || count > 64) throw new Error('psim: substeps must be 1 to 64');
    this.#memory.call('_psim_flat_scene_substeps', this.#at, count);
  }

  /** What the bodies look like: `of[id]` is a row of `all`. Bodies alike share a row; one of several shapes has `parts`. */
  shapes() {
    const m = this.#memory;
    if (this.bodies === 0) return { of: new Uint32Array(0), all: [] };
    const first = m.need(m.call('_psim_flat_scene_shape_of', this.#at)) >> 2;
    const starts = m.u32.slice(first, first + this.bodies);
    const numbers = m.call('_psim_flat_scene_shape_numbers', this.#at);
    const begin = m.call('_psim_flat_scene_shapes', this.#at) >> 3;
    const flat = m.f64.slice(begin, begin + numbers);
    const all = [];
    const row = new Map(); // where a shape begins, and what it is: its row
    let at = 0;
    const read = () => {
      const [kind, radius, mass, count] = flat.subarray(at, (at += 4));
      if (kinds[kind] !== 'parts') return { kind: kinds[kind], radius, mass, points: flat.slice(at, (at += 2 * count)) };
      const parts = Array.from({ length: count }, read);
      return { kind: 'parts', radius, mass, parts, points: Float64Array.from(parts.flatMap((part) => [...part.points])) };
    };
    while (at < numbers) {
      const begin = at, shape = read(), key = flat.subarray(begin, at).join();
      if (!row.has(key)) row.set(key, all.push(shape) - 1);
      row.set(begin, row.get(key));
    }
    return { of: starts.map((start) => row.get(start)), all };
  }

  /** What its fluids are made of; the first one is fluid 0 of World.fluidParticles. */
  get fluids() {
    const m = this.#memory;
    return Array.from({ length: m.call('_psim_flat_scene_fluids', this.#at) }, (_, k) => m.numbers(4, (at) => {
      m.call('_psim_flat_scene_fluid', this.#at, k, at);
      const [spacing, density, viscosity, surfaceTension] = m.f64.subarray(at >> 3, (at >> 3) + 4);
      return { spacing, density, viscosity, surfaceTension };
    }));
  }

  world(options = {}) {
    const m = this.#memory;
    const isa = this.#psim.isaNumber(options.isa);
    return new World(m, m.need(m.call('_psim_flat_scene_world', this.#at, isa)), this.#psim);
  }

  /** Adds the scene's bodies, not its groups and joints, to a world. */
  addTo(world) {
    const m = this.#memory;
    return m.withBytes(8 * this.bodies, (at) => {
      const added = m.call('_psim_flat_scene_add_bodies', this.#at, world.address, at);
      if (added < 0) m.check(added, world.address);
      return Array.from({ length: added }, (_, k) => ({ index: m.u32[(at >> 2) + 2 * k], generation: m.u32[(at >> 2) + 2 * k + 1] }));
    });
  }

  free() {
    this.#memory.call('_psim_flat_scene_free', this.#at);
    this.#at = 0;
  }
}
