#!/usr/bin/env node
// psim as WebAssembly in Node: node psim.mjs, then what psim takes. Files, exit codes and output are the program's own.
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { abilities } from './npm/abilities.mjs';

const words = process.argv.slice(2);
const able = abilities();
const refuse = (text) => {
  process.stderr.write(`psim: ${text}\n`);
  process.exit(2);
};
if (!able.exceptions || !able.simd) refuse('this Node lacks SIMD or exceptions in WebAssembly; Node 17 has both');

// Threads cost memory and time at the start, so that the module with them is for those who ask.
let threads = words.includes('--verify') || /--threads[ =](?!1\b)/.test(words.join(' '));
if (threads && !able.threads) {
  process.stderr.write('psim: no shared memory here: one thread does the work; the bits are the same\n');
  threads = false;
}
const name = threads ? './program-threads' : './program';
const start = createRequire(import.meta.url)(`${name}.js`);
await start({
  arguments: words,
  thisProgram: 'psim',
  wasmBinary: readFileSync(new URL(`${name}.wasm`, import.meta.url)),
});
