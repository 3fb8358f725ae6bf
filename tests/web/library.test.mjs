// The package in Node: scenes, steps, columns, fluids, bodies, queries, hands, saved states, errors, and both modules.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { test } from 'node:test';
import { abilities, load } from '../../build/web/npm/psim.mjs';
import { root } from './places.mjs';

const psim = await load();
const ground = { type: 'static', shape: { segment: { p1: [-50, 0], p2: [50, 0] } }, position: [0, 0] };
const empty = { psim: 1, world: { bounds: [-50, -10, 50, 90], gravity: [0, -9.81] }, bodies: [ground] };
const with_ = (...bodies) => ({ ...empty, bodies: [ground, ...bodies] });
const disc = (x, y, more) => ({ shape: { disc: { radius: 0.5 } }, position: [x, y], ...more });

test('the machine that runs the tests has SIMD, and the module uses it', () => {
  assert.deepEqual(abilities(), { simd: true, exceptions: true, threads: true });
  assert.deepEqual(psim.isas, ['simd128']);
  assert.equal(psim.module, 'psim-simd');
  assert.deepEqual(psim.notes, []);
});

test('every built-in scene makes a world', () => {
  const names = psim.scenes.map((scene) => scene.name);
  assert.ok(names.length > 30 && names.includes('card_house'));
  for (const { name, sized, bodies } of psim.scenes) {
    if (!sized && bodies > 10000) continue;
    const scene = psim.builtin(name, { bodies: sized ? Math.min(bodies, 500) : 0 });
    const world = scene.world();
    world.step();
    assert.match(world.hash(), /^0x[0-9a-f]{16}$/, name);
    world.free();
    scene.free();
  }
});

test('a body falls as the equations say', () => {
  const world = psim.world(with_(disc(0, 50)));
  for (let k = 0; k < 60; ++k) assert.equal(world.step().quarantined, 0);
  const body = world.body({ index: 1, generation: 0 });
  assert.ok(Math.abs(body.y - (50 - 9.81 / 2)) < 1e-3, `y ${body.y}`);
  assert.ok(Math.abs(body.vy + 9.81) < 1e-3);
  assert.equal(world.frame, 60);
  world.free();
});

test('columns are views on the memory of the module', () => {
  const world = psim.world(with_(disc(0, 5), disc(2, 6)));
  world.step();
  const state = world.state();
  assert.equal(state.count, 3);
  assert.equal(state.x.buffer, state.id.buffer);
  assert.ok(state.x.buffer.byteLength >= 32 << 20, 'it is the whole memory');
  assert.deepEqual([...state.id], [0, 1, 2]);
  assert.deepEqual([...state.type], [1, 0, 0]);
  assert.deepEqual([...state.x.subarray(1)], [0, 2]);
  assert.deepEqual([...state.radius.subarray(1)], [0.5, 0.5]);
  world.setSnapshots(true);
  assert.equal(world.snapshot(), undefined);
  world.step();
  const shot = world.snapshot();
  const [ox, oy] = shot.origin;
  const now = world.state();
  for (let k = 0; k < 3; ++k) {
    assert.ok(Math.abs(shot.x[k] + ox - now.x[k]) < 1e-4 && Math.abs(shot.y[k] + oy - now.y[k]) < 1e-4);
  }
  assert.ok(shot.yPrev[1] > shot.y[1], 'it falls');
  world.free();
});

test('the modules of both instruction sets give one hash', async () => {
  const able = { simd: false, exceptions: true, threads: false };
  const plain = await load({ abilities: able, threads: 4 });
  assert.equal(plain.module, 'psim-plain');
  assert.deepEqual(plain.isas, ['scalar']);
  assert.match(plain.notes[0], /no SIMD/);
  assert.equal(plain.notes.length, 2, 'and no threads');
  const run = (lib, isa) => {
    const scene = lib.builtin('rough-pile', { bodies: 1000 });
    const world = scene.world({ isa });
    for (let k = 0; k < 60; ++k) world.step();
    assert.equal(world.isa, isa);
    const hash = world.hash();
    world.free();
    scene.free();
    return hash;
  };
  const hash = run(psim, 'simd128');
  assert.equal(run(plain, 'scalar'), hash);
  assert.throws(() => run(psim, 'scalar'), /isa scalar: this module lacks it; it has simd128/);
  assert.throws(() => run(plain, 'simd128'), /isa simd128: this module lacks it; it has scalar/);
});

test('bodies and joints come, are pushed, and go', () => {
  const world = psim.world(empty);
  const [a, b] = world.add([disc(-5, 20, { material: 'steel' }), { shape: { box: { size: [2, 1] } }, position: [5, 20] }],
                           { steel: { density: 8 } });
  const rod = world.addJoint('distance', a, b, { length: 10 });
  assert.equal(world.jointCount, 1);
  world.applyImpulse(b, 0, 4, 5, 20);
  assert.equal(world.body(b).vy, 2);
  world.setVelocity(a, 1, 2, 3);
  assert.deepEqual([world.body(a).vx, world.body(a).vy, world.body(a).omega], [1, 2, 3]);
  for (let k = 0; k < 60; ++k) world.step();
  const p = world.body(a), q = world.body(b);
  assert.ok(Math.abs(Math.hypot(p.x - q.x, p.y - q.y) - 10) < 0.02);
  world.removeJoint(rod);
  world.remove(a);
  assert.throws(() => world.body(a), /psim: .*psim_world_body/);
  assert.equal(world.idOf(a.index), undefined);
  assert.equal(world.bodyCount, 2);
  world.free();
});

test('a target pulls a body along, and a joint breaks', () => {
  const world = psim.world(empty);
  const { worldBody } = world.constructor;
  const [a, b] = world.add([disc(-5, 20), disc(5, 20)]);
  const mouse = world.addJoint('target', undefined, a, { target: [-5, 20], frequency: 5, dampingRatio: 1 });
  world.setTarget(mouse, 0, 25);
  world.addJoint('weld', worldBody, b, { anchorA: [5, 20], breakForce: 1e-3 });
  for (let k = 0; k < 120; ++k) world.step();
  assert.ok(Math.abs(world.body(a).x) < 0.01);
  assert.equal(world.jointCount, 1);
  assert.throws(() => world.setTarget(mouse, NaN, 0), /psim: .*psim_world_set_target/);
  world.free();
});

test('queries answer', () => {
  const world = psim.world(with_(disc(0, 10), disc(3, 10)));
  const hit = world.rayCast(-10, 10, 10, 10);
  assert.equal(hit.body.index, 1);
  assert.deepEqual(hit.point.map((v) => Math.round(1000 * v) / 1000), [-0.5, 10]);
  assert.deepEqual(hit.normal.map(Math.round), [-1, 0]);
  assert.equal(world.rayCast(-10, 20, 10, 20), undefined);
  assert.equal(world.closest(2.9, 12, 5).body.index, 2);
  assert.equal(world.closest(0, 40, 5), undefined);
  assert.equal(world.closest(0, 1, 20).body.index, 0);
  assert.equal(world.closest(0, 1, 20, { dynamic: true }).body.index, 1);
  assert.deepEqual(world.inRegion(-1, 9, 1, 11).map((id) => id.index), [1]);
  assert.deepEqual(world.inRegion(-9, 9, 9, 11).map((id) => id.index), [1, 2]);
  for (let k = 0; k < 200; ++k) world.step();
  const contacts = world.contacts();
  assert.equal(contacts.length, 2);
  for (const c of contacts) assert.ok(c.impulse > 0 && c.a === 0 && Math.abs(c.point[1]) < 0.01);
  world.free();
});

test('a hand pulls a body to where it goes, and lets go', () => {
  const world = psim.world(with_(disc(0, 0.5), disc(10, 0.5)));
  for (let k = 0; k < 30; ++k) world.step();
  assert.equal(world.grab(30, 30, 1), undefined);
  const grab = world.grab(0.2, 0.6, 1);
  assert.equal(grab.body.index, 1);
  grab.moveTo(3, 8);
  for (let k = 0; k < 180; ++k) grab.lead(), world.step();
  const held = world.body(grab.body);
  assert.ok(Math.hypot(held.x - 3, held.y - 8) < 1, `${held.x} ${held.y}`);
  const before = world.bodyCount;
  grab.release();
  assert.equal(world.bodyCount, before - 1);
  assert.equal(world.jointCount, 0);
  for (let k = 0; k < 180; ++k) world.step();
  assert.ok(world.body(grab.body).y < 0.6);
  world.free();
});

test('a saved world goes on with the same bits', () => {
  const scene = psim.builtin('card_house');
  const world = scene.world();
  for (let k = 0; k < 20; ++k) world.step();
  const bytes = world.save();
  const other = psim.restore(bytes);
  for (let k = 0; k < 40; ++k) world.step(), other.step();
  assert.equal(other.hash(), world.hash());
  bytes[bytes.length >> 1] ^= 4;
  assert.throws(() => psim.restore(bytes), /psim: .*damaged/);
  assert.throws(() => psim.restore(bytes.subarray(0, 40)), /psim: \S.*/);
  assert.throws(() => psim.restore(new Uint8Array(0)), /psim: \S.*/);
});

test('mistakes are errors of one line', () => {
  const line = (pattern) => (error) => pattern.test(error.message) && !error.message.includes('\n');
  assert.throws(() => psim.scene('{"psim": 1,'), line(/^psim: scene:1:/));
  assert.throws(() => psim.world({ psim: 1, world: { bounds: [0, 0, 0, 0] } }), line(/^psim: /));
  assert.throws(() => psim.builtin('nothing-like-it'), line(/^psim: .*nothing-like-it/));
  const world = psim.world(empty);
  assert.throws(() => world.add({ shape: { disc: { radius: -1 } }, position: [0, 5] }), line(/radius/));
  assert.throws(() => world.setGravity(NaN, 0), line(/gravity/));
  assert.throws(() => world.addJoint('rope', { index: 0, generation: 0 }, { index: 9, generation: 0 }), line(/psim_world_add_joint/));
  world.free();
});

test('memory grows and comes back', () => {
  const sizes = [];
  for (let round = 0; round < 6; ++round) {
    const scene = psim.builtin('discs', { bodies: 100000 });
    const world = scene.world();
    world.step();
    sizes.push(world.state().x.buffer.byteLength);
    world.free();
    scene.free();
  }
  assert.equal(sizes.at(-1), sizes[1], `${sizes}`);
});

// A drop of another liquid above a pool: 20 x 5 particles lie, 4 x 4 fall.
const pool = {
  psim: 1, world: { bounds: [0, 0, 2, 4], boundary: 'walls', gravity: [0, -9.81] },
  fluids: [{ region: [0, 0, 2, 0.5], spacing: 0.1 },
           { region: [0.8, 2, 1.2, 2.4], spacing: 0.1, density: 800, viscosity: 0.01, velocity: [0, -1] }],
};

test('particles of fluids are views on the memory of the module', () => {
  const scene = psim.scene(pool);
  assert.deepEqual(scene.fluids, [{ spacing: 0.1, density: 1000, viscosity: 0, surfaceTension: 0 },
                                  { spacing: 0.1, density: 800, viscosity: 0.01, surfaceTension: 0 }]);
  assert.deepEqual(scene.shapes(), { of: new Uint32Array(0), all: [] }, 'a scene without bodies has no shapes');
  const world = scene.world();
  const start = world.fluidParticles();
  assert.equal(start.count, 116);
  assert.equal(start.x.buffer, world.state().x.buffer);
  assert.deepEqual([...start.id], Array.from({ length: 116 }, (_, k) => k));
  assert.deepEqual([...start.fluid], Array.from({ length: 116 }, (_, k) => (k < 100 ? 0 : 1)));
  const near = (value, wanted, error = 1e-6) => assert.ok(Math.abs(value - wanted) < error, `${value}, not ${wanted}`);
  near(start.x[0], 0.05), near(start.y[0], 0.05), near(start.x[19], 1.95), near(start.y[99], 0.45);
  near(start.x[100], 0.85), near(start.y[100], 2.05), near(start.vy[100], -1), near(start.vy[0], 0);
  assert.deepEqual([...new Set(start.pressure)], [0]);
  for (let k = 0; k < 12; ++k) world.step();
  const now = world.fluidParticles();
  const t = 12 * world.settings.dt;
  for (let k = 100; k < 116; ++k) near(now.vy[k], -1 - 9.81 * t, 0.02), near(now.vx[k], 0, 0.02);
  near(now.y[100], 2.05 - t - 9.81 / 2 * t * t, 0.03);
  near(now.density[50], 1000, 100);
  assert.ok(now.pressure[10] > 1000, `a pool of half a metre presses on its bottom with ${now.pressure[10]} N/m`);
  world.free();
  scene.free();
  const dry = psim.world(empty);
  assert.equal(dry.fluidParticles().count, 0);
  assert.deepEqual(psim.builtin('arch').fluids, []);
  dry.free();
});

test('fluids have the same bits in both modules', async () => {
  const plain = await load({ abilities: { simd: false, exceptions: true, threads: false } });
  const boats = readFileSync(`${root}scenes/boats.json`, 'utf8');
  const [there, here] = [plain, psim].map((lib) => {
    const world = lib.world(boats);
    for (let k = 0; k < 30; ++k) world.step();
    const { count, x, y } = world.fluidParticles();
    const end = { hash: world.hash(), count, x: x.slice(), y: y.slice() };
    world.free();
    return end;
  });
  assert.ok(here.count > 8000);
  assert.deepEqual(here, there);
});

test('shapes say what bodies look like', () => {
  const scene = psim.builtin('discs', { bodies: 2000 });
  const shapes = scene.shapes();
  assert.equal(shapes.of.length, 2000);
  assert.deepEqual(shapes.all.map((shape) => shape.kind), ['disc']);
  const boxes = psim.builtin('card_house').shapes();
  assert.ok(boxes.all.some((shape) => shape.kind === 'area' && shape.points.length === 8 && shape.mass > 0));
  const hammer = { position: [5, 5], density: 2, shapes: [{ box: { size: [2, 1] } }, { disc: { radius: 1 }, position: [1, 0], density: 4 }] };
  const several = psim.scene({ psim: 1, world: { bounds: [0, 0, 10, 10] }, bodies: [hammer, hammer] }).shapes();
  assert.deepEqual([...several.of], [0, 0]);
  assert.deepEqual(several.all[0].parts.map((part) => [part.kind, part.radius, part.points.length]), [['area', 0, 8], ['area', 1, 2]]);
  assert.ok(Math.abs(several.all[0].mass - (4 + 4 * Math.PI)) < 1e-12);
});
