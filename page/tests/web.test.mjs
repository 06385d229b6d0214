// The page without a program (./dev web): its answers are those of the program, bit for bit, and it needs no network.
import assert from 'node:assert/strict';
import { createReadStream, existsSync, readFileSync } from 'node:fs';
import { createServer } from 'node:http';
import { createRequire } from 'node:module';
import { basename, extname, join } from 'node:path';
import { after, before, test } from 'node:test';
import { gzipSync } from 'node:zlib';
import { folder, laptop, launch, makeSpheres, makeTube, phone, removeFolder, run, until, view } from './program.mjs';

const site = '../out/web';
const types = { '.html': 'text/html', '.js': 'text/javascript', '.css': 'text/css', '.svg': 'image/svg+xml', '.webmanifest': 'application/manifest+json' };
const requests = [];
let browser, server, address;

/** Serves the page's files and remembers what was asked for. */
function serve() {
  return new Promise((resolve) => {
    server = createServer((request, response) => {
      const path = request.url === '/' ? '/index.html' : request.url.split('?')[0];
      requests.push(request.url);
      if (!existsSync(join(site, path))) return response.writeHead(404).end();
      response.writeHead(200, { 'Content-Type': types[extname(path)] ?? 'application/octet-stream' });
      createReadStream(join(site, path)).pipe(response);
    }).listen(0, '127.0.0.1', () => resolve(`http://127.0.0.1:${server.address().port}/`));
  });
}

before(async () => {
  assert.ok(existsSync(join(site, 'index.html')), 'run ./dev web first');
  [browser, address] = await Promise.all([launch(), serve()]);
});

after(async () => {
  await browser?.close();
  server?.close();
  removeFolder();
});

/** The engine in Node, with these files open and checked; a function that answers a request. */
async function engineOf(files, settings = {}) {
  globalThis.require = createRequire(import.meta.url);
  globalThis.__dirname = '.';
  const { default: create } = await import('../../build-web/foldproof.js');
  const engine = await create();
  for (const file of files) engine.FS.writeFile(basename(file), readFileSync(file));
  const request = { files: files.map((file) => basename(file)), models: [], thickness: 0, substeps: 1, static: false, fps: 24, ...settings };
  const body = () => Buffer.from(engine.HEAPU8.slice(engine._foldproof_body(), engine._foldproof_body() + engine._foldproof_body_size()));
  assert.equal(engine.ccall('foldproof_open', 'number', ['string'], [JSON.stringify(request)]), 200, String(body()));
  while (engine._foldproof_advance() > 0);
  return async (path) => {
    assert.equal(engine.ccall('foldproof_get', 'number', ['string'], [`/api/${path}`]), 200, path);
    return body();
  };
}

/** The same of the program. */
async function programOf(...args) {
  const served = await view(...args);
  const get = async (path) => Buffer.from(await (await fetch(`${served.url}api/${path}`)).arrayBuffer());
  while (JSON.parse(await get('steps')).state === 'running') await new Promise((wait) => setTimeout(wait, 50));
  return { get, end: served.end };
}

/** Without times, which differ. */
const untimed = (bytes) => JSON.parse(String(bytes), (key, value) => (key === 'ms' ? undefined : value));

async function assertSameAnswers(files, settings = {}, args = []) {
  const engine = await engineOf(files, settings);
  const program = await programOf(...files, ...args);
  const sameJson = async (path) => {
    const answer = untimed(await engine(path));
    assert.deepEqual(answer, untimed(await program.get(path)), path);
    return answer;
  };
  try {
    const { steps, state } = await sameJson('steps');
    assert.equal(state, 'done');
    if (!settings.static) await sameJson('start/crossings');
    await sameJson('contacts');
    for (const { number } of steps) {
      await sameJson(`steps/${number}/collisions`);
      assert.deepEqual(await engine(`steps/${number}/faces/0`), await program.get(`steps/${number}/faces/0`));
      assert.deepEqual(await engine(`objects/0/frames/${number}`), await program.get(`objects/0/frames/${number}`));
    }
    return steps.reduce((sum, step) => sum + step.vertex_face + step.edge_edge, 0);
  } finally {
    await program.end();
  }
}

test('answers as the program, bit for bit', async () => {
  assert.ok((await assertSameAnswers(makeTube('tube', { frames: 24 }))) > 1000);
  assert.ok((await assertSameAnswers(makeTube('thick', { frames: 8 }), { thickness: 0.01, substeps: 3 }, ['--thickness', '0.01', '--substeps', '3'])) > 1000);
  await assertSameAnswers(makeSpheres('spheres', { frames: 3 }));
  await assertSameAnswers(makeSpheres('poses', { frames: 3 }), { static: true }, ['--static']);
});

test('answers as the program on a real motion', { skip: !process.env.FOLDPROOF_DATA && 'needs FOLDPROOF_DATA' }, async () => {
  const motion = join(process.env.FOLDPROOF_DATA, process.env.FOLDPROOF_WEB_MOTION ?? 'samba.glb');
  assert.ok((await assertSameAnswers([motion])) > 0);
});

/** Opens the page, and lets `body` choose files. */
async function visit(body, size = laptop) {
  const context = await browser.newContext({ ...size, reducedMotion: 'reduce' });
  const page = await context.newPage();
  const errors = [];
  page.on('console', (message) => message.type() === 'error' && errors.push(message.text()));
  page.on('pageerror', (error) => errors.push(String(error.stack)));
  try {
    await page.goto(address);
    await body(page, context);
    assert.deepEqual(errors, []);
  } finally {
    await context.close();
  }
}

const checked = (page) => until(page, (s) => s.state === 'done' && s.firstPicture > 0, 'the end of the check', 60_000);

test('checks files that are chosen, and asks the network for nothing', () =>
  visit(async (page) => {
    const files = makeTube('tube', { frames: 24 });
    await page.evaluate(() => navigator.serviceWorker.ready);
    const before = requests.length;
    await page.locator('input[type=file]').first().setInputFiles(files);
    await checked(page);
    const { totals } = JSON.parse(run('check', ...files, '--json', '-', '--quiet'));
    const verdict = await page.locator('.status .text').innerText();
    assert.match(verdict.replaceAll(/[,  ]/g, ''), new RegExp(`^${totals.collisions}collidingpairs`));
    assert.deepEqual(requests.slice(before), []);
  }));

test('shows the sample without a network', () =>
  visit(async (page, context) => {
    await page.evaluate(() => navigator.serviceWorker.ready);
    await context.setOffline(true);
    await page.reload();
    await page.getByText('Try the sample').click();
    await checked(page);
    assert.match(await page.title(), /walk\.glb/);
  }));

test('unpacks archives, joins frames, and says what it cannot read', () =>
  visit(async (page) => {
    const [obj] = makeTube('pose', { frames: 1 });
    const choose = (...files) => page.locator('input[type=file]').first().setInputFiles(files);
    await choose({ name: 'broken.obj', mimeType: 'text/plain', buffer: Buffer.from('v 1 2 x\n') });
    await page.getByRole('alert').getByText('broken.obj:1').waitFor();
    run('demo', join(folder, 'demo'));
    await choose(join(folder, 'demo', 'body.npz'));
    await checked(page);
    await page.getByRole('button', { name: 'Open' }).click();
    await choose(obj);
    await checked(page);
  }, phone));

test('is small', () => {
  const bytes = ['index.html', ...readFileSync(join(site, 'offline.js'), 'utf8').match(/assets\/[^"]+/g)].reduce((sum, name) => sum + gzipSync(readFileSync(join(site, name))).length, 0);
  assert.ok(bytes < 3_000_000, `${bytes} bytes, compressed`);
});
