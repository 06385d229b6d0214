// The page without a program (./dev web): its answers are those of the program, bit for bit, and it needs no network.
import assert from 'node:assert/strict';
import { createReadStream, existsSync, readFileSync, writeFileSync } from 'node:fs';
import { createServer } from 'node:http';
import { extname, join } from 'node:path';
import { after, before, test } from 'node:test';
import { gzipSync } from 'node:zlib';
import { engineOf } from './engine.mjs';
import { folder, laptop, launch, makeSpheres, makeTube, phone, removeFolder, run, textOf, until, view } from './program.mjs';

const site = '../out/web';
const types = { '.html': 'text/html', '.js': 'text/javascript', '.css': 'text/css', '.svg': 'image/svg+xml', '.webmanifest': 'application/manifest+json' };
const requests = [];
const demo = (name) => join(folder, 'demo', name);
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
  run('demo', join(folder, 'demo'));
  [browser, address] = await Promise.all([launch(), serve()]);
});

after(async () => {
  await browser?.close();
  server?.close();
  removeFolder();
});

/** Generated data: a triangle that turns about two axes, as GLB. Between keys, sines may differ in the last bit, so there is no frame. */
function turningTriangle() {
  const numbers = [0, 0, 0, 1, 0, 0, 0, 1, 0.5, 0, 1 / 24, 0, 0, 0, 1, 0.6, 0.48, 0, 0.64]; // positions, times, rotations
  const json = {
    asset: { version: '2.0' },
    scene: 0,
    scenes: [{ nodes: [0] }],
    nodes: [{ mesh: 0 }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0 } }] }],
    accessors: [['VEC3', 3], ['SCALAR', 2], ['VEC4', 2]].map(([type, count], bufferView) => ({ bufferView, componentType: 5126, count, type })),
    bufferViews: [[0, 36], [36, 8], [44, 32]].map(([byteOffset, byteLength]) => ({ buffer: 0, byteOffset, byteLength })),
    buffers: [{ byteLength: 4 * numbers.length }],
    animations: [{ channels: [{ sampler: 0, target: { node: 0, path: 'rotation' } }], samplers: [{ input: 1, output: 2 }] }],
  };
  const chunk = (type, bytes) => {
    const head = Buffer.alloc(8);
    head.writeUInt32LE(bytes.length, 0);
    head.write(type, 4, 'latin1');
    return Buffer.concat([head, bytes]);
  };
  const text = JSON.stringify(json);
  const chunks = Buffer.concat([chunk('JSON', Buffer.from(text.padEnd(4 * Math.ceil(text.length / 4)))), chunk('BIN\0', Buffer.from(Float32Array.from(numbers).buffer))]);
  const head = Buffer.alloc(12);
  head.write('glTF', 0, 'latin1');
  [2, 12 + chunks.length].forEach((number, k) => head.writeUInt32LE(number, 4 + 4 * k));
  return Buffer.concat([head, chunks]);
}

/** What answers requests of the program, once it has checked. */
async function programOf(...args) {
  const served = await view(...args);
  const get = async (path) => Buffer.from(await (await fetch(`${served.url}api/${path}`)).arrayBuffer());
  while (JSON.parse(await get('steps')).state === 'running') await new Promise((wait) => setTimeout(wait, 50));
  return { get, end: served.end };
}

/** Without the time that steps took. */
const untimed = (bytes) => JSON.parse(String(bytes), (key, value) => (key === 'ms' ? undefined : value));

async function assertSameAnswers(files, settings = {}, args = []) {
  const engine = await engineOf(files, settings);
  const program = await programOf(...files, ...args);
  const sameJson = async (path) => {
    const [ours, theirs] = [untimed(await engine(path)), untimed(await program.get(path))];
    assert.deepEqual(ours, theirs, path);
    return ours;
  };
  try {
    const { steps, state } = await sameJson('steps');
    assert.equal(state, 'done');
    if (!settings.static) await sameJson('start/crossings');
    await sameJson('contacts');
    const objects = [...JSON.parse(await program.get('scene')).objects.keys()];
    const sameBytes = async (path) => assert.deepEqual(await engine(path), await program.get(path), path);
    for (const { number, frame } of steps) {
      for (let offset = 0, total = 1; offset < total; ) {
        const pairs = await sameJson(`steps/${number}/collisions?offset=${offset}`);
        ({ total } = pairs);
        offset += pairs.items.length || total;
      }
      for (const object of objects) {
        await sameBytes(`steps/${number}/faces/${object}`);
        await sameBytes(`objects/${object}/frames/${frame}`);
      }
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
  assert.ok((await assertSameAnswers([demo('walk.glb')])) > 100);
  assert.ok((await assertSameAnswers([demo('body.npz'), demo('shirt.npz')])) > 100);
});

test('reads rotations as the program, bit for bit', async () => {
  const turning = demo('turning.glb');
  writeFileSync(turning, turningTriangle());
  await assertSameAnswers([turning]);
});

test('answers as the program on a real motion', { skip: !process.env.FOLDPROOF_DATA && 'needs FOLDPROOF_DATA' }, async () => {
  const motion = ['obj', 'pc2'].map((type) => join(process.env.FOLDPROOF_DATA, 'hand', `hand-anim.${type}`));
  assert.ok((await assertSameAnswers(motion)) > 0);
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

test('repairs: what it saves, GLB or NPZ, the program calls free', async () => {
  for (const name of ['walk.glb', 'body.npz']) {
    const engine = await engineOf([demo(name)]);
    await engine('repair/start');
    const { state, error, verdict, files } = JSON.parse(await engine('repair'));
    assert.deepEqual([state, error, verdict?.kind], ['done', '', 'free']);
    assert.equal(files[0].name, name.replace('.', '-repaired.'));
    writeFileSync(demo(files[0].name), await engine('objects/0/repaired/file'));
    assert.equal(JSON.parse(run('check', demo(files[0].name), '--json', '-', '--quiet')).clean, true);
  }
});

test('shows how far a repair is, and saves', () =>
  visit(async (page) => {
    await page.getByText('Try the sample').click();
    await checked(page);
    await page.click('.repair button >> text=Repair');
    await until(page, (s) => s.repaired, 'the repair', 60_000);
    const [download] = await Promise.all([page.waitForEvent('download'), page.click('text=Save walk-repaired.glb')]);
    const path = demo('from-page.glb');
    await download.saveAs(path);
    assert.equal(JSON.parse(run('check', path, '--json', '-', '--quiet')).clean, true);
  }));

test('checks files that are chosen, and asks the network for nothing', () =>
  visit(async (page) => {
    const files = makeTube('tube', { frames: 24 });
    await page.evaluate(() => navigator.serviceWorker.ready);
    const before = requests.length;
    await page.locator('input[type=file]').first().setInputFiles(files);
    await checked(page);
    const { verdict } = JSON.parse(run('check', ...files, '--json', '-', '--quiet'));
    assert.equal((await textOf(page, '.status .text')) + '.', verdict.text);
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
    const choose = (...files) => page.locator('input[type=file]').first().setInputFiles(files);
    await choose({ name: 'broken.obj', mimeType: 'text/plain', buffer: Buffer.from('v 1 2 x\n') });
    await page.getByRole('alert').getByText('broken.obj:1').waitFor();
    await choose({ name: 'broken.npz', mimeType: 'application/zip', buffer: Buffer.from('PK no archive') });
    await page.getByRole('alert').getByText('broken.npz: is not a complete ZIP archive').waitFor();
    await page.getByText('Options').click();
    await page.getByLabel('Thickness').fill('');
    await choose(demo('pose.obj'));
    assert.equal(await page.getByLabel('Thickness').evaluate((input) => input.validity.valid), false);
    assert.ok(await page.getByText('Drop a motion here').isVisible());
    await page.getByLabel('Thickness').fill('0');
    await choose(demo('body.npz'));
    await checked(page);
    await page.getByRole('button', { name: 'Open', exact: true }).click();
    await choose(demo('pose.obj'));
    await checked(page);
  }, phone));

/** A page whose script is changed before it runs, in a browser that logs errors of workers. */
async function visitChanged(change, body) {
  const context = await browser.newContext({ ...laptop, reducedMotion: 'reduce', serviceWorkers: 'block' });
  const page = await context.newPage();
  try {
    await page.route('**/assets/*.js', async (route) => {
      const script = await (await route.fetch()).text();
      const changed = change(script);
      assert.notEqual(changed, script);
      await route.fulfill({ body: changed, contentType: 'text/javascript' });
    });
    await page.goto(address);
    await page.getByText('Try the sample').click();
    await body(page);
  } finally {
    await context.close();
  }
}

test('says it when the engine breaks off', () =>
  visitChanged(
    // Three turns, then none until the page is open.
    (script) => script.replace(/\w+\._foldproof_advance\(\)/, '((self.turns=(self.turns??0)+1)<4?$&:self.turns<40?0:new WebAssembly.Instance(0))'),
    async (page) => {
      await until(page, (s) => s.state === 'failed', 'the end of the check', 60_000);
      assert.match(await page.locator('.status .text').innerText(), /^Stopped at \d of 24 steps/);
      assert.match(await page.locator('.banner').innerText(), /^the check: failed: .*WebAssembly.*; please report this/);
    },
  ));

test('says it when the worker breaks off', () =>
  visitChanged(
    (script) => script.replace('new MessageChannel', '(new WebAssembly.Instance(0),new MessageChannel)'),
    (page) => page.getByRole('alert').getByText(/the check: failed: .*WebAssembly/).waitFor(),
  ));

test('is small', () => {
  const bytes = ['index.html', ...readFileSync(join(site, 'offline.js'), 'utf8').match(/assets\/[^"]+/g)].reduce((sum, name) => sum + gzipSync(readFileSync(join(site, name))).length, 0);
  assert.ok(bytes < 3_000_000, `${bytes} bytes, compressed`);
});
