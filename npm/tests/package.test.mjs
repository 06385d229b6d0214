// The npm package as its users have it: packed, and installed in a project of its own. Its answers are those of the program.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { cpSync, existsSync, mkdirSync, readFileSync, readdirSync, symlinkSync, writeFileSync } from 'node:fs';
import { createServer } from 'node:http';
import { extname, join, resolve } from 'node:path';
import { after, before, test } from 'node:test';
import { pathToFileURL } from 'node:url';
import { folder, laptop, launch, makeSpheres, makeTube, removeFolder, run as runProgram } from '../../page/tests/program.mjs';

const modules = resolve('../page/node_modules');
const project = join(folder, 'project');
let foldproof;
let memory; // the engine's

function run(command, args, cwd = project) {
  const { status, stdout, stderr } = spawnSync(command, args, { cwd, encoding: 'utf8' });
  assert.equal(status, 0, `${command} ${args.join(' ')}\n${stdout}${stderr}`);
  return stdout;
}

before(async () => {
  const [tarball] = readdirSync('../out/npm').filter((name) => name.endsWith('.tgz'));
  mkdirSync(project);
  writeFileSync(join(project, 'package.json'), '{"private": true, "type": "module"}');
  run('npm', ['install', '--offline', '--no-audit', '--no-fund', resolve('../out/npm', tarball)]);
  const { instantiate } = WebAssembly;
  WebAssembly.instantiate = async (...given) => {
    const made = await instantiate(...given);
    memory ??= Object.values(made.instance?.exports ?? {}).find((value) => value instanceof WebAssembly.Memory);
    return made;
  };
  foldproof = await import(pathToFileURL(join(project, 'node_modules/foldproof/index.js')));
  await foldproof.check(triangles);
  WebAssembly.instantiate = instantiate;
});
after(removeFolder);

/** Faces and frames of an OBJ and its PC2. */
function read([obj, pc2]) {
  const faces = Uint32Array.from(readFileSync(obj, 'utf8').split('\n').filter((line) => line.startsWith('f ')).flatMap((line) => line.split(' ').slice(1).map((id) => id - 1)));
  const bytes = readFileSync(pc2);
  const [vertices, count] = [bytes.readInt32LE(16), bytes.readInt32LE(28)];
  const frames = Array.from({ length: count }, (_, k) => new Float32Array(bytes.buffer.slice(bytes.byteOffset + 32 + 12 * vertices * k, bytes.byteOffset + 32 + 12 * vertices * (k + 1))));
  return { faces, frames };
}

/** Rows of a step's pairs as the program's CSV has them: kind,object_a,a0,a1,object_b,b0,b1,toi,answer. */
function rowsOf({ frame, substep, vertexFace: v, edgeEdge: e }) {
  const answer = (undecided) => (undecided ? 'undecided' : 'hit');
  const rows = [];
  for (let k = 0; k < v.toi.length; ++k) rows.push([frame, substep, 'vf', v.vertexObject[k], v.vertex[k], '', v.faceObject[k], v.face[k], '', v.toi[k], answer(v.undecided[k])]);
  for (let k = 0; k < e.toi.length; ++k) rows.push([frame, substep, 'ee', e.objectA[k], e.a[2 * k], e.a[2 * k + 1], e.objectB[k], e.b[2 * k], e.b[2 * k + 1], e.toi[k], answer(e.undecided[k])]);
  return rows.map((row) => row.map(String));
}

const crossingRows = (frame, c) => Array.from(c.triangleA, (_, k) => [frame, 0, 'tt', c.objectA[k], c.triangleA[k], '', c.objectB[k], c.triangleB[k], '', '', 'crossing'].map(String));

/** The program's rows; its numbers are as short as JavaScript's once they are numbers. */
function programRows(files, ...options) {
  const [, ...lines] = runProgram('check', ...files, ...options, '--csv', '-', '--quiet').trim().split('\n');
  return lines.map((line) => line.split(',').map((field, k) => (k === 9 && field !== '' ? String(Number(field)) : field)));
}

/** A contact, under the names that the program's JSON has; without what that leaves out. */
function contactRow({ sides, curves, ...contact }) {
  const snake = (value) => {
    if (typeof value !== 'object' || value === null) return value;
    if (Array.isArray(value)) return value.map(snake);
    return Object.fromEntries(Object.entries(value).map(([key, inner]) => [key.replaceAll(/[A-Z]/g, (letter) => `_${letter.toLowerCase()}`), snake(inner)]));
  };
  return snake({ ...contact, sides: sides.map(({ object }) => object) });
}

test('finds what the program finds, to the last bit', async () => {
  for (const [files, settings, options] of [
    [makeTube('tube', { frames: 12 }), {}, []],
    [makeTube('thick', { frames: 5 }), { thickness: 0.01, substeps: 3 }, ['--thickness', '0.01', '--substeps', '3']],
    [makeSpheres('spheres', { frames: 3 }), {}, []],
  ]) {
    const found = await foldproof.check(read(files), settings);
    const rows = [...crossingRows(0, found.startCrossings), ...found.steps.flatMap(rowsOf)];
    assert.ok(rows.length > 100);
    assert.deepEqual(rows, programRows(files, ...options));
    const { totals, contacts } = JSON.parse(runProgram('check', ...files, ...options, '--json', '-', '--quiet'));
    assert.equal(found.collisions, totals.collisions.vf + totals.collisions.ee);
    assert.equal(found.startsCrossing, found.startCrossings.triangleA.length);
    assert.equal(found.contacts.length, contacts.length);
    assert.ok(contacts.length > 0);
    assert.deepEqual(found.contacts.map(contactRow), contacts.map(({ sides, ...contact }) => ({ ...contact, sides: sides.map(({ object }) => object) })));
  }
});

test('finds the crossings of poses', async () => {
  const files = makeSpheres('poses', { frames: 3 });
  const found = await foldproof.check(read(files), { static: true });
  assert.equal(found.startsCrossing, null);
  assert.deepEqual(found.steps.flatMap(({ frame, crossings }) => crossingRows(frame, crossings)), programRows(files, '--static'));
});

test('a StepChecker finds what a check finds', async () => {
  const { faces, frames } = read(makeTube('steps', { frames: 12 }));
  const { steps } = await foldproof.check({ faces, frames });
  const checker = await foldproof.StepChecker.create({ faces, positions: frames[0] });
  for (const [k, step] of steps.entries()) {
    const answer = checker.check(frames[k], frames[k + 1]);
    for (const key of ['clean', 'vertexFaceCount', 'edgeEdgeCount', 'vertexFace', 'edgeEdge', 'earliestToi', 'tolerance', 'collidingFaces']) assert.deepEqual(answer[key], step[key], key);
  }
  assert.ok(steps.some(({ collidingFaces }) => collidingFaces[0].includes(1)));
  assert.equal(checker.checkStatic(frames[0]).clean, true);
  checker.free();
  checker.free();
  assert.throws(() => checker.checkStatic(frames[0]), { name: 'FoldproofError', message: /has been freed/ });
});

const triangles = { faces: [[0, 1, 2]], frames: [[[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 0, 0], [1, 0, 0], [0, 1, 0]]] };
const falling = { faces: [[0, 1, 2]], frames: [[[0.2, 0.2, 1], [0.4, 0.2, 1], [0.2, 0.4, 1]], [[0.2, 0.2, -1], [0.4, 0.2, -1], [0.2, 0.4, -1]]] };

test('takes several objects, names, parts, and generators', async () => {
  const asked = [];
  async function* frames() {
    for (const frame of falling.frames) {
      asked.push(frame);
      yield new Float32Array(frame.flat());
    }
  }
  const found = await foldproof.check([{ ...triangles, name: 'floor' }, { faces: new Uint16Array([0, 1, 2]), frames: frames(), parts: ['toe'] }]);
  assert.equal(asked.length, 2);
  assert.deepEqual(found.contacts[0].sides.map(({ name }) => name), ['floor', 'toe']);
  assert.deepEqual([...new Set(found.steps[0].vertexFace.vertexObject)], [1]);
  const checker = await foldproof.StepChecker.create([triangles, falling].map(({ faces, frames }) => ({ faces, positions: frames[0] })));
  const step = checker.check([triangles.frames[0], falling.frames[0]], [triangles.frames[1], falling.frames[1]]);
  assert.equal(step.vertexFaceCount + step.edgeEdgeCount, found.collisions);
  assert.deepEqual(step.collidingFaces, [new Uint8Array([1]), new Uint8Array([1])]);
  assert.equal(checker.check([triangles.frames[0], falling.frames[0]], [triangles.frames[1], falling.frames[1]], { between: false }).clean, true);
});

test('says how many pairs contacts can join', async () => {
  const at = (k, frame) => frame.map(([x, y, z]) => [x + 10 * k, y, z]);
  const both = [0, 1].map((frame) => [0, 1, 2].flatMap((k) => [...at(k, triangles.frames[frame]), ...at(k, falling.frames[frame])]));
  const motion = { faces: Uint32Array.from({ length: 18 }, (_, k) => k), frames: both };
  const [whole, cut] = [await foldproof.check(motion), await foldproof.check(motion, { maxListed: 1 })];
  assert.deepEqual([whole.contacts.length, whole.listed], [3, whole.collisions]);
  assert.equal(cut.collisions, whole.collisions);
  assert.equal(cut.listed, cut.steps[0].vertexFace.toi.length + cut.steps[0].edgeEdge.toi.length);
  assert.ok(cut.listed < cut.collisions && cut.contacts.length < 3);
});

test('names need not be well-formed', async () => {
  const found = await foldproof.check([{ ...triangles, name: 'floor\ud800' }, { ...falling, parts: ['\ud83d\ude00\udc00'] }]);
  assert.deepEqual(found.contacts[0].sides.map(({ name }) => name), ['floor\ufffd', '\ud83d\ude00\ufffd']);
});

test('the engine says why it failed', async () => {
  const { default: createEngine } = await import(pathToFileURL(join(project, 'node_modules/foldproof/engine.js')));
  const { succeed } = await import(pathToFileURL(join(project, 'node_modules/foldproof/memory.js')));
  const engine = await createEngine();
  const json = engine._malloc(2);
  engine.stringToUTF8('{', json, 2);
  assert.throws(() => succeed(engine, engine._foldproof_open_check(engine._foldproof_meshes(), json)), { name: 'FoldproofError', message: /^foldproof: failed: .*parse error.*; report this/ });
});

test('one call within another', async () => {
  async function* frames() {
    for (const frame of triangles.frames) {
      assert.equal((await foldproof.check(falling)).clean, true);
      yield frame;
    }
  }
  assert.equal((await foldproof.check({ faces: triangles.faces, frames: frames() })).clean, true);
  const [a, b] = await Promise.all([foldproof.check([triangles, falling]), foldproof.check(triangles)]);
  assert.deepEqual([a.clean, b.clean], [false, true]);
});

test('shows progress, and can be ended', async () => {
  const motion = read(makeTube('long', { frames: 40 }));
  const shares = [];
  await foldproof.check(motion, { onProgress: (share) => shares.push(share) });
  assert.equal(shares.length, 39);
  assert.equal(shares.at(-1), 1);
  const ended = new AbortController();
  await assert.rejects(foldproof.check(motion, { signal: ended.signal, onProgress: (share) => share > 0.2 && ended.abort(new Error('enough')) }), { message: 'enough' });
  await assert.rejects(foldproof.check(motion, { signal: AbortSignal.abort() }), { name: 'AbortError' });
});

test('says what it refuses, and why', async () => {
  const { check, StepChecker } = foldproof;
  const { faces, frames } = triangles;
  const refused = async (what, message) => assert.rejects(what, (error) => {
    assert.equal(error.name, 'FoldproofError');
    assert.match(error.message, message);
    assert.equal(error.message, `${error.where}: ${error.problem}; ${error.remedy}`);
    return true;
  });
  await refused(check({ faces: [[0, 1, 7]], frames }), /triangle 0: names vertex 7, but there are 3/);
  await refused(check({ faces: [[0, 1, -2]], frames }), /motion\.faces\[0\]: -2 is not the id/);
  await refused(check({ faces: [0, 1], frames }), /motion\.faces: has 2 numbers/);
  await refused(check({ faces: [[0, 1]], frames }), /motion\.faces\[0\]: is not an array of three/);
  await refused(check({ faces: [], frames }), /has no triangles/);
  await refused(check({ frames }), /motion\.faces: is not an array/);
  await refused(check({ faces }), /motion\.frames: is missing/);
  await refused(check({ faces, frames: [] }), /motion\.frames: is empty/);
  await refused(check({ faces, frames: [frames[0], frames[1].slice(1)] }), /motion\.frames\[1\]: has 2 vertices instead of 3/);
  await refused(check({ faces, frames: [frames[0], [[0, 0, NaN], [1, 0, 0], [0, 1, 0]]] }), /frame 1.*is not finite/);
  await refused(check([triangles, { ...falling, frames: falling.frames.slice(1) }]), /frames/);
  await refused(check({ ...triangles, parts: [] }), /motion\.parts: has 0 names for 1 triangles/);
  await refused(check([]), /no motions|motion/);
  await refused(check(triangles, { thicknes: 1 }), /thicknes: is not a setting; settings are within, /);
  await refused(check(triangles, { thickness: '1' }), /thickness: is 1; give a number/);
  await refused(check(triangles, { thickness: -1 }), /thickness/);
  await refused(check(triangles, { thickness: Infinity }), /thickness: is Infinity/);
  await refused(check(triangles, { substeps: 0 }), /substeps: is 0; give a whole number/);
  await refused(check(triangles, { maxListed: 1.5 }), /maxListed: is 1.5/);
  for (const setting of [{ thickness: 1 }, { tolerance: 1 }, { substeps: 2 }, { stepsOnly: true }]) await refused(check(triangles, { ...setting, static: true }), new RegExp(`^${Object.keys(setting)[0]}: does not go with static; omit`));
  assert.equal((await check(triangles, { static: true, substeps: 1, thickness: 0 })).clean, true);
  await refused(check(triangles, { within: false }), /^within: is off, but there is only one motion/);
  await refused(check({ faces, frames: frames.slice(1) }, { stepsOnly: true }), /check it without stepsOnly/);
  for (const [call, message] of [
    [() => check(undefined), /^motion: expected an object with faces and frames, not undefined$/],
    [() => check([triangles, 7]), /^motion 1: expected an object/],
    [() => check(triangles, null), /^settings: expected an object/],
    [() => StepChecker.create(null), /^mesh: expected an object with faces and positions/],
  ]) await assert.rejects(call, { name: 'TypeError', message });
  const checker = await StepChecker.create({ faces, positions: frames[0] });
  assert.throws(() => checker.check(frames[0], frames[1].slice(1)), { message: /^x1: has 2 vertices instead of 3/ });
  assert.throws(() => checker.check(frames[0], [[0, 0, NaN], [1, 0, 0], [0, 1, 0]]), { message: /not finite/ });
  assert.throws(() => checker.check(frames[0], frames[1], { static: true }), { message: /static: is not a setting/ });
  assert.throws(() => checker.checkStatic(frames[0], { thickness: 1 }), { message: /^thickness: does not go with checkStatic/ });
});

test('gives memory back', async () => {
  const { faces, frames } = read(makeTube('memory', { frames: 2, along: 30 }));
  const use = async (rounds) => {
    for (let round = 0; round < rounds; ++round) {
      const checker = await foldproof.StepChecker.create({ faces, positions: frames[0] });
      checker.check(frames[0], frames[1]);
      checker.free();
      await foldproof.check({ faces, frames });
      await assert.rejects(foldproof.check({ faces, frames: [frames[0], [[NaN, 0, 0]]] }));
    }
    return memory.buffer.byteLength;
  };
  const before = await use(20);
  assert.equal(await use(200), before);
});

test('README and types hold', () => {
  const [, example] = /```js\n([^]*?)```/.exec(readFileSync(join(project, 'node_modules/foldproof/README.md'), 'utf8'));
  writeFileSync(join(project, 'readme.js'), example);
  const [first] = run('node', ['readme.js']).split('\n');
  assert.equal(first, 'false 3');
  cpSync('tests/types.ts', join(project, 'types.ts'));
  const compilerOptions = { noEmit: true, strict: true, target: 'ES2022', module: 'NodeNext', types: [] };
  writeFileSync(join(project, 'tsconfig.json'), JSON.stringify({ compilerOptions, files: ['types.ts'] }));
  run(join(modules, '.bin/tsc'), []);
  assert.equal(run('node', ['-e', "import('foldproof').then(({ check }) => console.log(typeof check))"]).trim(), 'function');
});

test('goes through a bundler, and colors what collides in a skinned mesh', async () => {
  const example = join(project, 'node_modules/foldproof/example');
  const page = join(folder, 'example');
  cpSync(example, page, { recursive: true });
  mkdirSync(join(page, 'node_modules'));
  symlinkSync(join(project, 'node_modules/foldproof'), join(page, 'node_modules/foldproof'));
  symlinkSync(join(modules, 'three'), join(page, 'node_modules/three'));
  run(join(modules, '.bin/vite'), ['build', '--target', 'es2022', '--logLevel', 'error'], page);
  const types = { '.html': 'text/html', '.js': 'text/javascript' };
  const server = createServer((request, response) => {
    const path = join(page, 'dist', request.url === '/' ? 'index.html' : request.url);
    if (!existsSync(path)) return response.writeHead(404).end();
    response.writeHead(200, { 'Content-Type': types[extname(path)] }).end(readFileSync(path));
  });
  await new Promise((listening) => server.listen(0, '127.0.0.1', listening));
  const browser = await launch();
  try {
    const shown = await browser.newPage(laptop);
    const errors = [];
    shown.on('pageerror', (error) => errors.push(String(error)));
    await shown.goto(`http://127.0.0.1:${server.address().port}/`);
    await shown.getByText('Nothing collides').waitFor();
    await shown.getByText(/\d+ pairs .* collide/).waitFor();
    await shown.screenshot({ path: join('../out/npm', 'example.png') });
    assert.deepEqual(errors, []);
  } finally {
    await browser.close();
    server.close();
  }
});
