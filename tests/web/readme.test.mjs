// The example of the package's README runs as it stands.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdtempSync, mkdirSync, readFileSync, rmSync, symlinkSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { test } from 'node:test';
import { built, root } from './places.mjs';

test('the example of the README prints what it says', () => {
  const text = readFileSync(`${root}packaging/npm/README.md`, 'utf8');
  const example = /```js\n([\s\S]*?)```/.exec(text)[1];
  const folder = mkdtempSync(`${tmpdir()}/psim-`);
  try {
    mkdirSync(`${folder}/node_modules`);
    symlinkSync(`${built}npm`, `${folder}/node_modules/psim`);
    writeFileSync(`${folder}/example.mjs`, example);
    const out = execFileSync('node', ['example.mjs'], { cwd: folder, encoding: 'utf8' }).trim().split('\n');
    assert.match(out[0], /^501 bodies, the highest at \d+\.\d m, 0x[0-9a-f]{16}$/);
    assert.match(out[1], /^under the box: \d+$/);
    assert.equal(out.length, 2);
  } finally {
    rmSync(folder, { recursive: true });
  }
});
