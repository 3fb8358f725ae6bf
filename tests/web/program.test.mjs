// psim.mjs, the program in Node: the same command line, files, output and exit codes as the native program.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { existsSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { after, test } from 'node:test';
import { built, root } from './places.mjs';

const folder = mkdtempSync(`${tmpdir()}/psim-`);
after(() => rmSync(folder, { recursive: true }));

function run(...words) {
  const options = words.at(-1)?.node ?? [];
  if (words.at(-1)?.node) words.pop();
  return spawnSync('node', [...options, `${built}psim.mjs`, ...words], { encoding: 'utf8', cwd: folder, maxBuffer: 1 << 28 });
}
function report(...words) {
  const { status, stdout, stderr } = run(...words, '--report', 'json');
  assert.equal(status, 0, stderr);
  return JSON.parse(stdout);
}
function refused(line, ...words) {
  const { status, stdout, stderr } = run(...words);
  assert.equal(status, 2, stderr);
  assert.equal(stdout, '');
  assert.match(stderr, line);
  assert.equal(stderr.trim().split('\n').length, 1, stderr);
}

test('--version names the instruction sets', () => {
  const { status, stdout } = run('--version');
  assert.equal(status, 0);
  assert.match(stdout, /^psim \d+\.\d+\.\d+$/m);
  assert.match(stdout, /^ISAs of this CPU: scalar simd128$/m);
});

test('instruction sets and threads give one hash', () => {
  const scene = ['--scene', 'rough-pile', '--particles', '1500', '--frames', '60'];
  const first = report(...scene);
  assert.equal(first.isa, 'simd128');
  assert.equal(report(...scene, '--isa', 'scalar').state_hash, first.state_hash);
  const threads = report(...scene, '--threads', '3');
  assert.equal(threads.threads, 3);
  assert.equal(threads.state_hash, first.state_hash);
});

test('--verify compares them itself', () => {
  const { status, stdout, stderr } = run('--verify', '--scene', 'pile', '--particles', '500', '--frames', '20');
  assert.equal(status, 0, stderr);
  assert.match(stdout, /simd128/);
});

test('files are written and read', () => {
  const made = report('--scene', `${root}scenes/arch.json`, '--frames', '20', '--state', 'end.csv', '--metrics', 'frames.csv',
                      '--save', 'saved.state', '--image', 'end.png', '--image-size', '200x150');
  assert.equal(readFileSync(`${folder}/end.csv`, 'utf8').trim().split('\n').length, made.bodies.total + 1);
  assert.equal(readFileSync(`${folder}/frames.csv`, 'utf8').trim().split('\n').length, 21);
  assert.equal(readFileSync(`${folder}/end.png`).subarray(1, 4).toString(), 'PNG');
  const straight = report('--scene', `${root}scenes/arch.json`, '--frames', '50');
  const restored = report('--scene', `${root}scenes/arch.json`, '--restore', 'saved.state', '--frames', '30');
  assert.equal(restored.state_hash, straight.state_hash);
  const bytes = readFileSync(`${folder}/saved.state`);
  bytes[bytes.length >> 1] ^= 1;
  writeFileSync(`${folder}/broken.state`, bytes);
  refused(/^psim: .*broken\.state.*damaged/, '--scene', `${root}scenes/arch.json`, '--restore', 'broken.state', '--frames', '1');
});

// What the native program of the same tree saved goes on here with the same bits, and its files have the same bytes.
const native = `${root}build/release/psim`;
test('states and files of the native program', { skip: !existsSync(native) }, () => {
  const words = ['--scene', 'card_house', '--frames', '30', '--save', 'native.state', '--image', 'native.png', '--state', 'native.csv'];
  assert.equal(spawnSync(native, words, { cwd: folder }).status, 0);
  const own = words.map((word) => word.replace('native', 'web'));
  assert.equal(run(...own).status, 0);
  for (const kind of ['state', 'png', 'csv']) {
    assert.ok(readFileSync(`${folder}/native.${kind}`).equals(readFileSync(`${folder}/web.${kind}`)), kind);
  }
  const there = JSON.parse(spawnSync(native, ['--scene', 'card_house', '--restore', 'web.state', '--frames', '60', '--report', 'json'], { cwd: folder, encoding: 'utf8' }).stdout);
  assert.equal(report('--scene', 'card_house', '--restore', 'native.state', '--frames', '60').state_hash, there.state_hash);
});

test('fluids have the hash of the native program', { skip: !existsSync(native) }, () => {
  const words = ['--scene', `${root}scenes/boats.json`, '--frames', '30'];
  const { stdout } = spawnSync(native, [...words, '--report', 'json'], { cwd: folder, encoding: 'utf8' });
  assert.equal(report(...words).state_hash, JSON.parse(stdout).state_hash);
});

test('mistakes are one line and exit 2', () => {
  refused(/^psim: --isa avx2: this build lacks it and has scalar, simd128$/m, '--isa', 'avx2');
  refused(/^psim: --scene nowhere\.json: no such file/, '--scene', 'nowhere.json');
  refused(/^psim: --frames/, '--frames', 'many');
  refused(/cannot start ffmpeg/, '--scene', 'arch', '--video', 'film.mp4', '--frames', '2');
  refused(/^psim: /, '--scene', 'arch', '--frames', '1', '--state', '/nowhere/at/all.csv');
  // Of the build with threads, too, where a handler must be found in memory that they share.
  refused(/^psim: --frames/, '--frames', 'many', '--threads', '2');
  refused(/^psim: --scene nowhere\.json: no such file/, '--scene', 'nowhere.json', '--threads', '2');
});

test('without shared memory one thread does the work, and a line says so', () => {
  const words = ['--scene', 'pile', '--particles', '300', '--frames', '5', '--threads', '2', '--report', 'json'];
  const { status, stdout, stderr } = run(...words, { node: ['--no-harmony-sharedarraybuffer'] });
  assert.equal(status, 0, stderr);
  assert.match(stderr, /^psim: no shared memory here/);
  assert.equal(JSON.parse(stdout).state_hash, report(...words.slice(0, 6)).state_hash);
});
