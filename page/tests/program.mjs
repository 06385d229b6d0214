// Shared by the tests: motions, the program that serves them, and a browser.
import { spawn, spawnSync } from 'node:child_process';
import { mkdirSync, mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { chromium } from 'playwright-core';

export const program = process.env.FOLDPROOF ?? '../build/foldproof';

export const folder = mkdtempSync(join(tmpdir(), 'foldproof-page-'));
export const removeFolder = () => rmSync(folder, { recursive: true, force: true });

/** Runs the program to its end; its standard output. */
export function run(...args) {
  const { status, stdout, stderr, error } = spawnSync(program, args, { encoding: 'utf8', maxBuffer: 2 ** 30 });
  if (error) throw new Error(`${program}: ${error.message}; set FOLDPROOF to the program`);
  if (status > 1) throw new Error(`${program} ${args.join(' ')}: ${stderr}`);
  return stdout;
}

/** Generated data: a tube that bends until its ends meet and straightens again. OBJ and PC2, paths of both. */
export function makeTube(name, { around = 16, along = 60, frames }) {
  const faces = [];
  for (let ring = 0; ring < along; ++ring) {
    for (let i = 0; i < around; ++i) {
      const a = ring * around + i + 1;
      const b = ring * around + ((i + 1) % around) + 1;
      faces.push(`f ${a} ${b} ${b + around}`, `f ${a} ${b + around} ${a + around}`);
    }
  }
  const vertices = (along + 1) * around;
  const values = new Float32Array(3 * vertices * frames);
  for (let frame = 0; frame < frames; ++frame) placeTube(values.subarray(3 * vertices * frame), { around, along }, frame / (frames - 1));
  return write(name, faces, values, frames);
}

/** Generated data: two unit spheres that move together; at a distance of 1 they overlap by half. `distances`: one per frame. OBJ and PC2, paths of both. */
export function makeSpheres(name, { around = 32, along = 24, distances, frames = distances?.length, distance = 1, far }) {
  const sphere = around * (along + 1);
  const faces = [];
  for (const first of [1, sphere + 1]) {
    for (let ring = 0; ring < along; ++ring) {
      for (let i = 0; i < around; ++i) {
        const a = first + ring * around + i;
        const b = first + ring * around + ((i + 1) % around);
        faces.push(`f ${a} ${b} ${b + around}`, `f ${a} ${b + around} ${a + around}`);
      }
    }
  }
  const values = [];
  // On a grid, so that adding `far` loses nothing.
  const place = (...point) => (far === undefined ? point : point.map((value) => far + Math.round(value * 4096) / 4096));
  for (let frame = 0; frame < frames; ++frame) {
    for (const k of [0, 1]) {
      const apart = k * (distances?.[frame] ?? distance);
      for (let ring = 0; ring <= along; ++ring) {
        const angle = (Math.PI * (ring + 0.05)) / (along + 0.1);
        for (let i = 0; i < around; ++i) {
          const turn = (2 * Math.PI * i) / around;
          values.push(...place(0.25 * frame + apart + Math.sin(angle) * Math.cos(turn), 0.07 * k + Math.cos(angle), Math.sin(angle) * Math.sin(turn)));
        }
      }
    }
  }
  return write(name, faces, Float64Array.from(values), frames);
}

/** Generated data: a triangle in four frames, the third of which is missing. */
export function makeGap(name) {
  const frames = join(folder, name);
  mkdirSync(frames);
  for (const frame of [0, 1, 3]) writeFileSync(join(frames, `f${frame}.obj`), `v 0 0 ${frame}\nv 1 0 0\nv 0 1 0\nf 1 2 3\n`);
  return [frames];
}
export const gapNote = /: frame numbers jump from 1 to 3: the step between them was not in the files/;

function write(name, faces, values, frames) {
  const vertices = values.length / 3 / frames;
  const lines = [];
  for (let v = 0; v < vertices; ++v) lines.push(`v ${values[3 * v]} ${values[3 * v + 1]} ${values[3 * v + 2]}`);
  const head = Buffer.alloc(32);
  head.write('POINTCACHE2\0', 0, 'latin1');
  [1, vertices].forEach((n, k) => head.writeInt32LE(n, 12 + 4 * k));
  head.writeFloatLE(0, 20);
  head.writeFloatLE(1, 24);
  head.writeInt32LE(frames, 28);
  const [obj, pc2] = [join(folder, `${name}.obj`), join(folder, `${name}.pc2`)];
  writeFileSync(obj, [...lines, ...faces, ''].join('\n'));
  writeFileSync(pc2, Buffer.concat([head, Buffer.from(Float32Array.from(values).buffer)]));
  return [obj, pc2];
}

function placeTube(out, { around, along }, time) {
  const bend = 2.35 * Math.PI * Math.sin(Math.PI * time);
  let [x, y] = [0, 0];
  for (let ring = 0; ring <= along; ++ring) {
    const angle = bend * (ring / along - 0.5);
    x += (10 / along) * Math.cos(angle);
    y += (10 / along) * Math.sin(angle);
    for (let i = 0; i < around; ++i) {
      const turn = (2 * Math.PI * i) / around;
      const side = 0.6 * Math.cos(turn);
      out.set([x - side * Math.sin(angle), y + side * Math.cos(angle), 0.6 * Math.sin(turn) + 0.1 * Math.sin(3 * time + ring / 9)], 3 * (ring * around + i));
    }
  }
}

/** Starts `foldproof view`; its address, and how to end it. */
export function view(...args) {
  const child = spawn(program, ['view', '--no-browser', ...args], { stdio: ['ignore', 'pipe', 'pipe'] });
  return new Promise((resolve, reject) => {
    let text = '';
    let errors = '';
    child.stderr.on('data', (data) => (errors += data));
    child.on('error', reject);
    child.on('exit', (status) => reject(new Error(`foldproof view ended with ${status}: ${errors}`)));
    child.stdout.on('data', (data) => {
      text += data;
      const url = /http:\/\/\S+/.exec(text)?.[0];
      if (url) resolve({ url, end: () => end(child) });
    });
  });
}

function end(child) {
  if (child.exitCode !== null || child.signalCode !== null) return Promise.resolve();
  return new Promise((resolve) => {
    child.removeAllListeners('exit');
    child.on('exit', resolve);
    child.kill('SIGINT');
  });
}

export const launch = () =>
  chromium.launch({
    executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium',
    args: ['--headless', '--no-sandbox', '--disable-gpu', '--disable-quic', '--no-first-run', '--disable-background-networking', '--disable-component-update', '--disable-sync', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'],
  });

export const laptop = { viewport: { width: 1366, height: 768 } };
export const phone = { viewport: { width: 390, height: 844 }, isMobile: true, hasTouch: true };

/** A page that remembers every error. */
export async function openPage(browser, url, size = laptop) {
  const context = await browser.newContext({ ...size, reducedMotion: 'reduce' });
  const page = await context.newPage();
  const errors = [];
  page.on('console', (message) => {
    // Software rendering warns about reading its own pictures back.
    if (message.type() === 'error' || (message.type() === 'warning' && !/GL Driver Message/.test(message.text()))) errors.push(message.text());
  });
  page.on('pageerror', (error) => errors.push(String(error.stack)));
  await page.goto(url);
  return { page, errors, close: () => context.close() };
}

/** Waits until the page's state meets a condition. */
export async function until(page, condition, what, milliseconds = 10_000) {
  const end = Date.now() + milliseconds;
  for (;;) {
    const now = await page.evaluate(() => window.foldproof?.state());
    if (now && condition(now)) return now;
    if (Date.now() > end) throw new Error(`never: ${what}; the page is at ${JSON.stringify(now)}`);
    await page.waitForTimeout(30);
  }
}

/** Waits for what has changed to be drawn: the page draws once per animation frame. */
const drawn = (page) => page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));

/** The page's state once it shows what it was asked for. */
export async function state(page) {
  await drawn(page);
  return until(page, (s) => !s.waiting, 'what is asked for');
}

/** What an element says once the page shows what it was asked for. */
export async function textOf(page, selector) {
  await state(page);
  return page.locator(selector).innerText();
}

/** The center of the picture, without overlays. */
export async function picture(page) {
  await drawn(page);
  const box = await page.locator('.stage canvas').boundingBox();
  const { x, y, width, height } = box;
  return page.screenshot({ clip: { x: x + width / 4, y: y + height / 4, width: width / 2, height: height / 2 } });
}
