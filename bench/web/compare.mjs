// Milliseconds a step of psim and other engines in Node on the same scenes, one thread: node compare.mjs [FRAMES].
// Each engine runs in a process of its own, so that none inherits another's heap. The figure is processor time, which
// other programs of the machine do not change much, as a mean over the last half of the frames. An engine that took
// too long stops and shows how far it came; it is compared with what psim took for the same frames. The mean height of the
// bodies at the end tells whether they did the same.
import { spawnSync } from 'node:child_process';
import { fileURLToPath } from 'node:url';
import { engines } from './engines.mjs';
import { discs, pyramid } from './scenes.mjs';

const scenes = [discs(2000), discs(10000), discs(50000), pyramid(40)];
const mostWarmMs = 3000, mostMs = 20000; // of processor time an engine and scene

function processorMs() {
  const { user, system } = process.cpuUsage();
  return (user + system) / 1000;
}

// Of the last half of the first `frames` times.
function mean(times, frames) {
  const half = times.slice(frames >> 1, frames);
  return half.reduce((sum, ms) => sum + ms, 0) / half.length;
}

function run(world, frames, most) {
  const times = [];
  for (let all = 0; times.length < frames && all < most;) {
    const begin = processorMs();
    world.step();
    times.push(processorMs() - begin);
    all += times.at(-1);
  }
  return times;
}

async function measure(scene, engine, frames) {
  const first = await engine.make(scene);  // Node compiles what runs often, meanwhile
  run(first, frames, mostWarmMs);
  first.free();
  const world = await engine.make(scene);
  const times = run(world, frames, mostMs);
  let height = 0;
  for (let k = 0; k < scene.bodies.length; ++k) height += world.height(k) / scene.bodies.length;
  world.free();
  return { times, height };
}

const [first, second, third] = process.argv.slice(2);
if (first === '--one') {
  const result = await measure(scenes[second], engines[third], Number(process.argv[5]));
  process.stdout.write(`\n${JSON.stringify(result)}\n`, () => process.exit(0));
} else {
  const frames = Number(first ?? 240);
  console.log(`Node ${process.version}, ${frames} frames\n\n| scene | engine | ms a step | times psim | frames | mean height, m |\n|---|---|---|---|---|---|`);
  scenes.forEach((scene, s) => {
    let own;
    engines.forEach((engine, e) => {
      const words = [fileURLToPath(import.meta.url), '--one', `${s}`, `${e}`, `${frames}`];
      const { stdout, stderr } = spawnSync('node', words, { encoding: 'utf8' });
      try {
        const r = JSON.parse(stdout.trim().split('\n').at(-1));
        own ??= r.times;
        const ms = mean(r.times, r.times.length), ratio = ms / mean(own, r.times.length);
        console.log(`| ${scene.name} | ${engine.name} | ${ms.toPrecision(3)} | ${ratio.toPrecision(3)} | ${r.times.length} | ${r.height.toFixed(2)} |`);
      } catch {
        console.log(`| ${scene.name} | ${engine.name} | failed: ${stderr.trim().split('\n').at(-1).slice(0, 80)} | | | |`);
      }
    });
  });
}
