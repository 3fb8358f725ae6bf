// The page in headless Chromium, with played input. Screenshots stay in build/web/pictures to be looked at.
import assert from 'node:assert/strict';
import { mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { test } from 'node:test';
import { colourOf } from '../../build/web/page/fluids.mjs';
import { serve } from '../../build/web/serve.mjs';
import { Chromium, browser } from './chromium.mjs';
import { built, root } from './places.mjs';

const skip = browser ? false : 'no Chromium here';

async function onPage(options, use) {
  const { server, address } = await serve(built, 0, { isolated: options.isolated ?? true, scene: options.scene });
  let page;
  try {
    page = await Chromium.open(`${address}${options.query ?? ''}`, { width: 1100, height: 800, ...options });
    await page.until('window.psimPage?.world?.frame > 5');
    await use(page);
    assert.deepEqual(page.errors, []);
    mkdirSync(`${built}pictures`, { recursive: true });
    writeFileSync(`${built}pictures/${options.name}.png`, await page.picture());
  } finally {
    server.close();
    await page?.close();
  }
}

const state = (name) => `psimPage.world.${name}`;
/** CSS pixels of a place of the world. */
const onCanvas = (x, y) => `(() => { const c = document.getElementById('view'), m = psimPage.camera;
  const s = m.pixelsAMetre(c.clientWidth, c.clientHeight);
  return [c.clientWidth / 2 + (${x} - m.x) * s, c.clientHeight / 2 - (${y} - m.y) * s]; })()`;
/** How many different colours the middle of the canvas has. */
const colours = `(() => { const c = document.getElementById('view'), gl = c.getContext('webgl2');
  const p = new Uint8Array(4 * c.width * c.height), seen = new Set();
  gl.readPixels(0, 0, c.width, c.height, gl.RGBA, gl.UNSIGNED_BYTE, p);
  for (let k = 0; k < p.length; k += 4) seen.add(p[k] << 16 | p[k + 1] << 8 | p[k + 2]);
  return seen.size; })()`;

test('scenes, sliders and hands on a desk', { skip }, async () => {
  await onPage({ name: 'desk', query: '?scene=pyramid&threads=2' }, async (page) => {
    assert.equal(await page.ask('psimPage.psim.module'), 'psim-simd-threads');
    assert.equal(await page.ask(state('threads')), 2);
    assert.equal(await page.ask('document.getElementById("message").textContent'), '');
    assert.ok((await page.ask('document.getElementById("scene").length')) > 30);
    assert.match(await page.ask('document.getElementById("hash").textContent'), /^frame \d+ {2}0x[0-9a-f]{16}$/);
    assert.ok((await page.ask(colours)) > 20, 'bodies are drawn');

    // The hand pulls a box out of the pyramid.
    const top = await page.ask(`(() => { const s = ${state('state()')}; let k = 0;
      for (let j = 0; j < s.count; ++j) if (s.type[j] === 0 && s.y[j] > s.y[k]) k = j;
      return [s.id[k], s.x[k], s.y[k]]; })()`);
    const [x, y] = await page.ask(onCanvas(top[1], top[2]));
    await page.mouse('mousePressed', x, y);
    for (let k = 1; k <= 10; ++k) await page.mouse('mouseMoved', x + 20 * k, y - 6 * k);
    await page.until(`psimPage.world.body({ index: ${top[0]}, generation: 0 }).x > ${top[1]} + 2`);
    assert.equal(await page.ask(state('jointCount')), 2);
    await page.mouse('mouseReleased', x + 200, y - 60);
    await page.until(`${state('jointCount')} === 0`);

    // A box is put in, and all are kicked.
    const before = await page.ask(state('bodyCount'));
    await page.ask('document.querySelector("[name=tool][value=box]").click()');
    await page.mouse('mousePressed', x - 200, y);
    await page.mouse('mouseReleased', x - 200, y);
    await page.until(`${state('bodyCount')} === ${before} + 1`);
    await page.ask('document.querySelector("[name=tool][value=kick]").click()');
    const [cx, cy] = await page.ask(onCanvas(top[1], 1));
    await page.mouse('mousePressed', cx, cy);
    await page.mouse('mouseReleased', cx, cy);
    await page.until(`(() => { const s = ${state('state()')}; return Math.max(...s.vx.map(Math.abs)) > 2; })()`);

    // Sliders.
    await page.ask('(e => { e.value = 20; e.dispatchEvent(new Event("input")); })(document.getElementById("gravity"))');
    assert.equal(await page.ask(state('settings.gravity[1]')), 20);
    await page.ask('(e => { e.value = 2; e.dispatchEvent(new Event("change")); })(document.getElementById("substeps"))');
    assert.equal(await page.ask(state('settings.substeps')), 2);
    await page.until(`${state('frame')} > 60`);
  });
});

test('the hash on the page is that of Node', { skip }, async () => {
  const { load } = await import('../../build/web/npm/psim.mjs');
  const world = (await load()).builtin('rough-pile', { bodies: 2000 }).world();
  const inNode = [];
  for (let frame = 0; frame <= 120; ++frame) inNode.push(world.hash()), world.step();
  await onPage({ name: 'pile', query: '?scene=rough-pile&bodies=2000&threads=3' }, async (page) => {
    const inPage = await page.ask(`(() => { const scene = psimPage.psim.builtin('rough-pile', { bodies: 2000 });
      const world = scene.world(), hashes = [];
      for (let frame = 0; frame <= 120; ++frame) hashes.push(world.hash()), world.step();
      world.free(); scene.free();
      return hashes; })()`);
    assert.deepEqual(inPage, inNode);
  });
});

test('every scene of the gallery starts', { skip }, async () => {
  await onPage({ name: 'gallery', query: '?scene=washer&threads=1' }, async (page) => {
    const scenes = await page.ask('[...document.getElementById("scene").options].map((o) => o.value)');
    for (const fluid of ['boats', 'dam_break', 'tap']) assert.ok(scenes.includes(fluid), fluid);
    for (const name of scenes) {
      await page.ask(`(e => { e.value = ${JSON.stringify(name)}; e.dispatchEvent(new Event('change')); })(document.getElementById('scene'))`);
      await page.until(`${state('frame')} > 2`);
      assert.equal(await page.ask('document.getElementById("message").textContent'), '', name);
    }
    await page.ask(`(e => { e.value = 'washer'; e.dispatchEvent(new Event('change')); })(document.getElementById('scene'))`);
    await page.until(`${state('frame')} > 60`, 120);
  });
});

/** Of each fluid: the share of its particles at whose places the canvas has the fluid's colour; how many pixels have this
 * colour, and how many would if discs did not overlap: the outermost half pixel of a disc is paler. */
const water = (fluids) => `(() => { const c = document.getElementById('view'), gl = c.getContext('webgl2');
  const { width: w, height: h } = c, camera = psimPage.camera, scale = camera.pixelsAMetre(w, h);
  const p = new Uint8Array(4 * w * h);
  gl.readPixels(0, 0, w, h, gl.RGBA, gl.UNSIGNED_BYTE, p);
  const { count, fluid, x, y } = psimPage.world.fluidParticles();
  return ${JSON.stringify(fluids)}.map(({ rgb, spacing }, f) => {
    const is = (k) => rgb.every((part, j) => Math.abs(p[k + j] - part) < 8);
    let all = 0, seen = 0, pixels = 0;
    for (let k = 0; k < count; ++k) {
      if (fluid[k] !== f) continue;
      const column = Math.floor(w / 2 + (x[k] - camera.x) * scale), row = Math.floor(h / 2 + (y[k] - camera.y) * scale);
      ++all, seen += is(4 * (row * w + column));
    }
    for (let k = 0; k < p.length; k += 4) pixels += is(k);
    return { all, share: seen / all, pixels, area: all * Math.PI * (spacing / 2 * scale - 0.5) ** 2 };
  }); })()`;

test('fluids are drawn where their particles are', { skip }, async () => {
  const bytes = (f) => colourOf(f).map((part) => Math.round(255 * part));
  for (const [name, spacing, least] of [['boats', 0.04, [7000, 1600]], ['dam_break', 0.01, [20000]]]) {
    await onPage({ name, query: `?scene=${name}` }, async (page) => {
      const fluids = least.map((_, f) => ({ rgb: bytes(f), spacing }));
      for (const frames of [6, 40]) {
        await page.until(`${state('frame')} > ${frames}`);
        const drawn = await page.ask(water(fluids));
        drawn.forEach(({ all, share, pixels, area }, f) => {
          const words = `${name}, fluid ${f}: ${share} of ${all} particles, ${pixels} pixels of ${area}`;
          assert.ok(all >= least[f] && share > 0.9 && pixels > 0.5 * area && pixels < 1.5 * area, words);
        });
      }
      const particles = await page.ask(`${state('fluidParticles()')}.count`);
      assert.ok((await page.ask('document.getElementById("status").textContent')).includes(`${particles.toLocaleString('en')} particles`));
    });
  }
});

test('the colours of fluids are those of pictures', () => {
  const source = readFileSync(`${root}src/psim/surface/fluid_field.cpp`, 'utf8');
  const colours = /kColours = \{(.*)\};/.exec(source)[1].split(',').map(Number);
  const bytes = (f) => colourOf(f).reduce((rgb, part) => 256 * rgb + Math.round(255 * part), 0);
  assert.deepEqual([...colours, colours[0]].map((_, f) => bytes(f)), [...colours, colours[0]]);
});

const shown = 'document.getElementById("scene").value', message = 'document.getElementById("message").textContent';

test('the server leads to a scene, built in or a file', { skip }, async () => {
  await onPage({ name: 'named', scene: 'bridge' }, async (page) => assert.equal(await page.ask(shown), 'bridge'));
  const folder = mkdtempSync(`${tmpdir()}/psim-page-`), scene = `${folder}/two words.json`;
  const card_house = readFileSync(`${root}scenes/card_house.json`, 'utf8');
  writeFileSync(scene, JSON.stringify({ ...JSON.parse(card_house), name: 'mine' }));
  await onPage({ name: 'file', scene }, async (page) => {
    assert.equal(await page.ask(shown), 'mine');
    assert.equal(await page.ask(message), '');
    assert.equal(await page.ask(state('bodyCount')), JSON.parse(card_house).bodies.length);
  });
  rmSync(folder, { recursive: true });
});

test('a scene that is not there is said to be so', { skip }, async () => {
  await onPage({ name: 'absent', query: '?scene=no-such' }, async (page) => {
    assert.match(await page.ask(message), /no scene no-such/);
    assert.equal(await page.ask(shown), 'washer');
  });
});

test('on a phone, by touch, without shared memory', { skip }, async () => {
  await onPage({ name: 'phone', query: '?scene=bridge', width: 390, height: 780, touch: true, isolated: false }, async (page) => {
    assert.equal(await page.ask('psimPage.psim.module'), 'psim-simd');
    assert.match(await page.ask('document.getElementById("message").textContent'), /COOP and COEP/);
    assert.equal(await page.ask('document.documentElement.scrollWidth'), 390);
    const disc = await page.ask(`(() => { const s = ${state('state()')}; const k = s.type.lastIndexOf(0);
      return [s.id[k], s.x[k], s.y[k]]; })()`);
    await page.ask('document.getElementById("pause").click()');
    const [x, y] = await page.ask(onCanvas(disc[1], disc[2]));
    await page.ask('document.getElementById("pause").click()');
    await page.touch('touchStart', [x, y]);
    await page.until(`${state('jointCount')} > 0`);
    for (let k = 1; k <= 5; ++k) await page.touch('touchMove', [x, y - 10 * k]);
    await page.touch('touchEnd');
    // Two fingers zoom.
    const span = await page.ask('psimPage.camera.span[0]');
    await page.touch('touchStart', [150, 300], [250, 300]);
    await page.touch('touchMove', [100, 300], [300, 300]);
    await page.touch('touchEnd');
    assert.ok((await page.ask('psimPage.camera.span[0]')) < 0.7 * span);
  });
});
