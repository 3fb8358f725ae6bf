// A world. Names and meanings follow the C API; ids are {index, generation}.
import { Grab } from './grab.mjs';

const jointTypes = ['distance', 'spring', 'rope', 'revolute', 'prismatic', 'weld', 'wheel', 'motor', 'target', 'gear',
  'pulley', 'filter'];
const none = { index: 0xffffffff, generation: 0 };
const bodyTypes = ['dynamic', 'static', 'kinematic'];

export class World {
  /** The world as a body of a joint: anchors at it are points of the world. */
  static worldBody = { index: 0xfffffffe, generation: 0 };

  #memory;
  #psim;

  constructor(memory, address, psim) {
    this.#memory = memory;
    this.#psim = psim;
    this.address = address;
  }

  /** fill(address) writes so many doubles, which come back. Nothing where fill says that there is nothing. */
  #doubles(count, fill) {
    const m = this.#memory;
    return m.numbers(count, (at) => {
      if (!m.check(fill(at), this.address)) return undefined;
      return Array.from(m.f64.subarray(at >> 3, (at >> 3) + count));
    });
  }

  #do(name, ...values) {
    return this.#memory.check(this.#memory.call(name, this.address, ...values), this.address);
  }

  // ---- steps ----
  step(dt = 0) {
    const m = this.#memory;
    const [ms, contacts, awake, asleep, pairs, escaped, quarantined] = this.#doubles(7, (at) =>
      m.call('_psim_flat_step', this.address, dt, at));
    return { ms, contacts, awake, asleep, pairs, escaped, quarantined };
  }

  get frame() { return this.#memory.call('_psim_flat_frame', this.address); }
  get bodyCount() { return this.#memory.call('_psim_world_body_count', this.address); }
  get dynamicCount() { return this.#memory.call('_psim_world_dynamic_count', this.address); }
  get jointCount() { return this.#memory.call('_psim_world_joint_count', this.address); }
  get memoryBytes() { return this.#memory.call('_psim_world_memory_bytes', this.address); }
  get threads() { return this.#psim.threads; }
  get isa() {
    const m = this.#memory;
    return m.text(m.call('_psim_isa_name', m.call('_psim_world_isa', this.address)));
  }

  get settings() {
    const m = this.#memory;
    const v = this.#doubles(9, (at) => m.call('_psim_flat_desc', this.address, at));
    const boundary = ['walls', 'periodic', 'open'][v[4]];
    return { bounds: v.slice(0, 4), boundary, gravity: v.slice(5, 7), dt: v[7], substeps: v[8] };
  }

  setGravity(x, y) { this.#do('_psim_flat_set_gravity', x, y); }
  setSleeping(on) { this.#do('_psim_world_set_sleeping', on ? 1 : 0); }

  hash() {
    const m = this.#memory;
    return m.numbers(1, (at) => {
      m.call('_psim_flat_hash', this.address, at);
      const half = (k) => m.u32[(at >> 2) + k].toString(16).padStart(8, '0');
      return `0x${half(1)}${half(0)}`;
    });
  }

  diagnostics() {
    const m = this.#memory;
    const v = this.#doubles(6, (at) => m.call('_psim_flat_diagnostics', this.address, at));
    return { kinetic: v[0], potential: v[1], momentum: [v[2], v[3]], angularMomentum: v[4], maxPenetration: v[5] };
  }

  // ---- columns: views on the module's memory, without a copy ----
  #columns(names, at) {
    const buffer = this.#memory.module.HEAPU8.buffer;
    const word = (k) => this.#memory.u32[(at >> 2) + k];
    const out = { count: word(0) };
    names.forEach(([name, Type], k) => (out[name] = new Type(buffer, word(k + 1), out.count)));
    return out;
  }

  state() {
    const m = this.#memory;
    const doubles = ['x', 'y', 'angle', 'vx', 'vy', 'omega', 'radius'].map((name) => [name, Float64Array]);
    return m.numbers(16, (at) => {
      m.check(m.call('_psim_flat_state', this.address, at), this.address);
      return this.#columns([['id', Uint32Array], ...doubles, ['type', Uint8Array]], at);
    });
  }

  setSnapshots(on) { this.#do('_psim_world_enable_snapshots', on ? 1 : 0); }

  snapshot() {
    const m = this.#memory;
    const names = ['x', 'y', 'xPrev', 'yPrev', 'angle', 'anglePrev', 'radius', 'speed'];
    const columns = [['id', Uint32Array], ...names.map((name) => [name, Float32Array]), ['asleep', Uint8Array]];
    return m.numbers(16, (at) => {
      const origin = at + 8 * 12;
      if (!m.check(m.call('_psim_flat_snapshot', this.address, at, origin), this.address)) return undefined;
      return { ...this.#columns(columns, at), origin: [m.f64[origin >> 3], m.f64[(origin >> 3) + 1]] };
    });
  }

  fluidParticles() {
    const m = this.#memory;
    const words = ['id', 'fluid'].map((name) => [name, Uint32Array]);
    const doubles = ['x', 'y', 'vx', 'vy', 'density', 'pressure'].map((name) => [name, Float64Array]);
    return m.numbers(16, (at) => {
      m.check(m.call('_psim_flat_fluid_particles', this.address, at), this.address);
      return this.#columns([...words, ...doubles], at);
    });
  }

  // ---- bodies ----
  /** Bodies in the words of scene files, such as {shape: {disc: {radius: 1}}, position: [0, 5]}. */
  add(bodies, materials = undefined) {
    const { bounds, boundary } = this.settings;
    const list = Array.isArray(bodies) ? bodies : [bodies];
    const scene = this.#psim.scene({ psim: 1, world: { bounds, boundary }, materials, bodies: list }, 'add');
    try {
      const ids = scene.addTo(this);
      return Array.isArray(bodies) ? ids : ids[0];
    } finally {
      scene.free();
    }
  }

  idOf(index) {
    const m = this.#memory;
    return this.#id((at) => m.call('_psim_flat_id_of', this.address, index, at));
  }

  #id(fill) {
    const m = this.#memory;
    return m.numbers(1, (at) =>
      m.check(fill(at), this.address) ? { index: m.u32[at >> 2], generation: m.u32[(at >> 2) + 1] } : undefined);
  }

  body(id) {
    const m = this.#memory;
    const v = this.#doubles(8, (at) => m.call('_psim_flat_body', this.address, id.index, id.generation, at));
    const [x, y, angle, vx, vy, omega, radius] = v;
    return { x, y, angle, vx, vy, omega, radius, type: bodyTypes[v[7]] };
  }

  remove(id) { this.#do('_psim_flat_remove', id.index, id.generation); }
  setTransform(id, x, y, angle = 0) { this.#do('_psim_flat_set_transform', id.index, id.generation, x, y, angle); }
  setVelocity(id, vx, vy, omega = 0) { this.#do('_psim_flat_set_velocity', id.index, id.generation, vx, vy, omega); }
  applyImpulse(id, px, py, x, y) { this.#do('_psim_flat_impulse', id.index, id.generation, px, py, x, y); }
  wake(id) { this.#do('_psim_flat_wake', id.index, id.generation); }

  // ---- joints ----
  addJoint(type, a, b, options = {}) {
    const m = this.#memory;
    const origin = [0, 0];
    const o = { anchorA: origin, anchorB: origin, axis: [1, 0], target: origin, linearVelocity: origin, groundA: origin,
      groundB: origin, jointA: none, jointB: none, ...options };
    const given = (name) => (o[name] === undefined ? 0 : 1);
    const values = [
      ...o.anchorA, ...o.anchorB, o.length ?? 0, o.stiffness ?? 0, o.damping ?? 0, ...o.axis, o.reference ?? 0,
      o.lower ?? 0, o.upper ?? 0, o.motorSpeed ?? 0, o.motorLimit ?? 0,
      given('length'), given('reference'), given('lower'), given('upper'), o.collide ? 1 : 0,
      ...o.target, o.rest ?? 0, ...o.linearVelocity, o.angularVelocity ?? 0, o.forceLimit ?? 0, o.torqueLimit ?? 0,
      ...o.groundA, ...o.groundB, o.ratio ?? 1, o.frequency ?? 0, o.dampingRatio ?? 0, o.breakForce ?? 0,
      o.breakTorque ?? 0,
    ];
    const sides = [a ?? none, b ?? none, o.jointA, o.jointB].flatMap((id) => [id.index, id.generation]);
    return m.numbers(values.length + 5, (at) => {
      m.f64.set(values, at >> 3);
      const ids = at + 8 * values.length;
      m.u32.set(sides, ids >> 2);
      const number = jointTypes.indexOf(type);
      m.check(m.call('_psim_flat_add_joint', this.address, number, ids, at, ids + 32), this.address);
      return { index: m.u32[(ids + 32) >> 2], generation: m.u32[(ids + 36) >> 2] };
    });
  }

  removeJoint(id) { this.#do('_psim_flat_remove_joint', id.index, id.generation); }
  setTarget(id, x, y) { this.#do('_psim_flat_set_target', id.index, id.generation, x, y); }
  setMotor(id, speed, limit) { this.#do('_psim_flat_set_motor', id.index, id.generation, speed, limit); }

  // ---- queries ----
  #hit(count, ask) {
    const m = this.#memory;
    return m.numbers(count + 1, (at) => {
      if (!m.check(ask(at, at + 8), this.address)) return undefined;
      const body = { index: m.u32[at >> 2], generation: m.u32[(at >> 2) + 1] };
      return { body, values: Array.from(m.f64.subarray((at >> 3) + 1, (at >> 3) + 1 + count)) };
    });
  }

  rayCast(x0, y0, x1, y1) {
    const m = this.#memory;
    const hit = this.#hit(5, (id, out) => m.call('_psim_flat_ray', this.address, x0, y0, x1, y1, id, out));
    return hit && { body: hit.body, point: hit.values.slice(0, 2), normal: hit.values.slice(2, 4), fraction: hit.values[4] };
  }

  closest(x, y, reach, { dynamic = false } = {}) {
    const m = this.#memory;
    const only = dynamic ? 1 : 0;
    const hit = this.#hit(3, (id, out) => m.call('_psim_flat_closest', this.address, x, y, reach, only, id, out));
    return hit && { body: hit.body, point: hit.values.slice(0, 2), distance: hit.values[2] };
  }

  inRegion(xmin, ymin, xmax, ymax) {
    const m = this.#memory;
    const room = this.bodyCount;
    return m.withBytes(8 * room, (at) => {
      const count = m.call('_psim_flat_in_region', this.address, xmin, ymin, xmax, ymax, at, room);
      if (count < 0) m.check(count, this.address);
      const word = (k) => m.u32[(at >> 2) + k];
      return Array.from({ length: count }, (_, k) => ({ index: word(2 * k), generation: word(2 * k + 1) }));
    });
  }

  contacts() {
    const m = this.#memory;
    const count = m.call('_psim_flat_contacts', this.address, 0, 0);
    if (count < 0) m.check(count, this.address);
    return m.withBytes(48 * count, (at) => {
      m.call('_psim_flat_contacts', this.address, at, count);
      const all = [];
      for (let k = 0, v = at >> 3; k < count; ++k, v += 6) {
        const [a, b, x, y, impulse, separation] = m.f64.subarray(v, v + 6);
        all.push({ a, b, point: [x, y], impulse, separation });
      }
      return all;
    });
  }

  /** Holds the dynamic body nearest to a point, if one is within reach, as a mouse does. */
  grab(x, y, reach, mass) { return Grab.begin(this, x, y, reach, mass); }

  // ---- saved states ----
  save() {
    const m = this.#memory;
    const size = m.call('_psim_flat_save', this.address, 0, 0);
    if (size < 0) m.check(size, this.address);
    return m.withBytes(size, (at) => {
      m.call('_psim_flat_save', this.address, at, size);
      return m.u8.slice(at, at + size);
    });
  }

  free() {
    this.#memory.call('_psim_world_destroy', this.address);
    this.address = 0;
  }
}
