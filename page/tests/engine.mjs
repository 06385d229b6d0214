// The library as WebAssembly, as the page without a program runs it, in Node.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { dirname } from 'node:path';
import { deflateSync } from 'node:zlib';
import { unzipSync } from 'fflate';

/** The engine in Node, with these files open and checked; a function that answers a request. */
export async function engineOf(files, settings = {}) {
  globalThis.require = createRequire(import.meta.url);
  globalThis.__dirname = '.';
  const { default: create } = await import('../../build-web/page_engine.js');
  const engine = await create({ deflate: deflateSync, repairing: () => undefined });
  for (const file of files) {
    engine.FS.mkdirTree(dirname(file));
    engine.FS.writeFile(file, readFileSync(file));
    if (!file.endsWith('.npz')) continue;
    engine.FS.mkdir(`${file}.arrays`);  // as the worker unpacks it
    for (const [name, bytes] of Object.entries(unzipSync(readFileSync(file)))) engine.FS.writeFile(`${file}.arrays/${name}`, bytes);
  }
  const request = { files, models: [], thickness: 0, substeps: 1, static: false, fps: 24, command: 'a test', ...settings };
  const body = () => Buffer.from(engine.HEAPU8.slice(engine._foldproof_body(), engine._foldproof_body() + engine._foldproof_body_size()));
  assert.equal(engine.ccall('foldproof_open', 'number', ['string'], [JSON.stringify(request)]), 200, String(body()));
  while (engine._foldproof_advance() > 0);
  return async (path) => {
    assert.equal(engine.ccall('foldproof_get', 'number', ['string'], [`/api/${path}`]), 200, path);
    const answer = body();
    while (engine._foldproof_advance() > 0); // what was asked for
    return answer;
  };
}
