// Serves a folder on localhost with the headers that shared memory needs: node serve.mjs FOLDER [PORT] [SCENE]. Prints the
// address. Port 0 is any free one. The page opens with SCENE, a name or a scene file.
import { createServer } from 'node:http';
import { readFile } from 'node:fs/promises';
import { existsSync } from 'node:fs';
import { basename, extname, join, normalize, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';

const types = {
  '.html': 'text/html; charset=utf-8', '.css': 'text/css', '.mjs': 'text/javascript', '.js': 'text/javascript',
  '.wasm': 'application/wasm', '.json': 'application/json',
};

const given = '/given/';  // where a scene file appears, wherever it lies

/** Without `isolated` the headers are missing, as on a plain server. With `scene` the address `/` leads to that scene. */
export function serve(folder, port = 0, { isolated = true, scene } = {}) {
  const root = resolve(folder);
  const isFile = scene !== undefined && existsSync(scene);
  const shown = isFile ? `${given}${basename(scene)}` : scene;
  const server = createServer(async (request, response) => {
    if (scene !== undefined && request.url === '/') {
      response.writeHead(302, { Location: `/?scene=${encodeURIComponent(shown)}` }).end();
      return;
    }
    const path = normalize(decodeURIComponent(new URL(request.url, 'http://localhost').pathname));
    const file = isFile && path === shown ? scene : join(root, path.endsWith('/') ? `${path}index.html` : path);
    try {
      const body = await readFile(file);
      if (isolated) {
        response.setHeader('Cross-Origin-Opener-Policy', 'same-origin');
        response.setHeader('Cross-Origin-Embedder-Policy', 'require-corp');
      }
      response.writeHead(200, { 'Content-Type': types[extname(file)] ?? 'application/octet-stream', 'Cache-Control': 'no-cache' });
      response.end(body);
    } catch {
      response.writeHead(404).end('not found');
    }
  });
  return new Promise((done, failed) => {
    server.once('error', failed);
    server.listen(port, 'localhost', () => done({ server, address: `http://localhost:${server.address().port}/` }));
  });
}

if (import.meta.url === pathToFileURL(process.argv[1] ?? '').href) {
  const [folder = '.', port = '8080', scene] = process.argv.slice(2);
  const { address } = await serve(folder, Number(port), { scene });
  console.log(address);
}
