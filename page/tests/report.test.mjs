// The report, opened from a file without a network.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { pathToFileURL } from 'node:url';
import { folder, gapNote, launch, makeGap, makeSpheres, makeTube, openPage, phone, removeFolder, run } from './program.mjs';

let browser;
const file = join(folder, 'report.html');

before(async () => {
  run('report', ...makeTube('a<b>&', { frames: 30 }), '-o', file);
  browser = await launch();
});
after(async () => {
  await browser?.close();
  removeFolder();
});

test('opens from a file, offline, and shows the results', async () => {
  const { page, errors, close } = await openPage(browser, 'about:blank');
  const requests = [];
  page.on('request', (request) => requests.push(request.url().slice(0, 5)));
  await page.context().setOffline(true);
  await page.goto(pathToFileURL(file).href);
  assert.match(await page.locator('h1').innerText(), /goes through itself.*, in frame \d+/);
  assert.match(await page.locator('body').innerText(), /a<b>&/);
  assert.equal(await page.locator('.chart canvas').count(), 5);
  assert.ok((await page.locator('.contact img').count()) >= 1);
  assert.match(await page.locator('.contact').first().innerText(), /a<b>&.* with itself[^]*(deep|along|touches)/);
  assert.equal(await page.locator('main > section h2').first().innerText(), await page.locator('.contacts h2').innerText(), 'contacts come first');
  assert.ok((await page.locator('.lanes a').count()) >= 1);
  assert.ok(await page.evaluate(() => Array.from(document.images).every((image) => image.complete && image.naturalWidth > 0)));
  assert.deepEqual([...new Set(requests)].filter((start) => start !== 'file:' && start !== 'data:'), []);
  assert.deepEqual(errors, []);
  await close();
});

/** Opens a report; returns its heading, the heading's kind and its text. */
async function read(file) {
  const { page, errors, close } = await openPage(browser, pathToFileURL(file).href);
  const heading = page.locator('h1');
  const result = { page, close, verdict: await heading.innerText(), kind: await heading.getAttribute('class'), text: await page.locator('body').innerText() };
  assert.deepEqual(errors, []);
  return result;
}

function reportOf(name, motion, ...options) {
  const out = join(folder, `${name}.html`);
  run('report', ...motion, ...options, '-o', out, '--quiet');
  return out;
}

test('reports crossings of two overlapping spheres, though no step collides', async () => {
  const { page, verdict, kind, text, close } = await read(reportOf('merged', makeSpheres('merged', { frames: 6 })));
  assert.match(verdict, /^merged goes through itself, [\d.]+ deep at worst, in frame \d$/);
  assert.equal(kind, 'hit');
  assert.match(text, /Triangles that cross in frame 0\s+[\d,]+ pairs/);
  assert.match(text, /The contact\s/);
  assert.match(text, /deep/);
  assert.match(text, /there from the start; there at the end/);
  assert.equal(await page.locator('.contact img').count(), 1);
  assert.ok(await page.locator('.chart .start-mark').first().isVisible());
  assert.equal(await page.locator('.chart[data-chart=collisions]').count(), 0, 'a chart of nothing is left out');
  assert.equal(await page.locator('.free').count(), 0, 'nothing is green');
  await close();
});

test('reports a free motion', async () => {
  const { page, verdict, kind, close } = await read(reportOf('apart', makeSpheres('apart', { frames: 6, distance: 2.5 })));
  assert.equal(verdict, 'No collisions: no triangles cross in frame 0, and all 5 steps are proven free');
  assert.equal(kind, 'free');
  assert.equal(await page.locator('.answer.free').count(), 2);
  assert.equal(await page.locator('.start-mark:visible').count(), 0);
  assert.equal(await page.locator('.contacts').count(), 0);
  assert.equal(await page.locator('.chart[data-chart=collisions]').count(), 0);
  assert.equal(await page.locator('figure img').count(), 1);
  await close();
});

test('claims nothing about untested crossings', async () => {
  const { page, verdict, kind, close } = await read(reportOf('steps', makeSpheres('steps', { frames: 6 }), '--steps-only'));
  assert.match(verdict, /^No contact begins in all 5 steps, proven\. Crossings from frame 0 on were not tested/);
  assert.equal(kind, 'run');
  assert.equal(await page.locator('.free').count(), 0, 'nothing is green');
  await close();
  const touching = await read(reportOf('touching', makeTube('touching', { frames: 24 }), '--steps-only'));
  assert.match(touching.text, /with itself\s+touches; not known whether it crosses/);
  await touching.close();
});

test('says which pairs contacts leave out', async () => {
  const tube = makeTube('limited', { frames: 24 });
  const { page, close } = await read(reportOf('limited', tube, '--limit', '1'));
  assert.match(await page.locator('.contacts').innerText(), /^(The contact|\d+ contacts, the worst first)\s+Contacts join only the \d+ of [\d,]+ colliding pairs that are listed \(--limit\)\./);
  await close();
  const whole = await read(reportOf('unlimited', tube));
  assert.doesNotMatch(whole.text, /Contacts join only/);
  await whole.close();
});

test('says what the reader of a motion left out', async () => {
  const { verdict, text, close } = await read(reportOf('gap', makeGap('gap')));
  assert.match(verdict, /^No collisions/);
  assert.match(text, gapNote);
  await close();
});

test('says which pairs were not tested', async () => {
  const one = makeSpheres('one', { frames: 6, distance: 2.5 });
  const both = [...one, ...makeSpheres('other', { frames: 6, distance: 2.5 })];
  const verdictOf = async (name, motions, option) => {
    const { verdict, close } = await read(reportOf(name, motions, option));
    await close();
    return verdict;
  };
  const free = 'No collisions: no triangles cross in frame 0, and all 5 steps are proven free';
  assert.equal(await verdictOf('within', both, '--within'), `${free}; pairs of two meshes were not tested`);
  assert.equal(await verdictOf('within-one', one, '--within'), free);
  assert.match(await verdictOf('between', both, '--between'), /; pairs within one mesh were not tested$/);
});

test('says that it skips frames', async () => {
  const { verdict, close } = await read(reportOf('stride', makeSpheres('stride', { frames: 7, distance: 2.5 }), '--frames', '::3'));
  await close();
  assert.equal(verdict, 'No collisions: no triangles cross in frame 0, and all 2 steps are proven free; only every 3rd frame was checked');
});

test('shows a single frame', async () => {
  const { verdict, kind, close } = await read(reportOf('single', makeSpheres('single', { frames: 1 }).slice(0, 1)));
  assert.match(verdict, /^single goes through itself, [\d.]+ deep, in frame 0$/);
  assert.equal(kind, 'hit');
  await close();
});

test('reports the poses of a static check', async () => {
  const poses = makeSpheres('poses', { distances: [2.5, 1.4, 2.5, 1] });
  const { page, verdict, kind, text, close } = await read(reportOf('poses', poses, '--static'));
  assert.match(verdict, /^poses goes through itself twice, [\d.]+ deep at worst, in frame 3$/);
  assert.equal(kind, 'hit');
  assert.match(text, /first frame with crossings is 1\. The worst is frame 3, with [\d,]+ pairs\..*what happens between frames is not tested/);
  assert.match(text, /Frames with crossings/);
  assert.doesNotMatch(text.slice(0, text.indexOf('Settings')), /\bstep|collision|collid|motion|start/i);
  assert.equal(await page.locator('.contact img').count(), 1);
  assert.ok(await page.locator('.chart[data-chart=collisions]').isVisible());
  await close();
  const free = await read(reportOf('free', poses, '--static', '--frames', '0:4:2'));
  assert.equal(free.verdict, 'No triangles cross in any of 2 frames, proven. What happens between frames was not tested; only every 2nd frame was checked');
  assert.equal(free.kind, 'free');
  assert.equal(await free.page.locator('.answer.free').count(), 1);
  await free.close();
  const one = await read(reportOf('one', poses, '--static', '--frames', '1'));
  assert.match(one.verdict, /^poses goes through itself, [\d.]+ deep, in frame 1$/);
  await one.close();
});

test('pictures go with dark pages', async () => {
  const { page, close } = await openPage(browser, pathToFileURL(file).href);
  const corner = await page.locator('.contact img').first().evaluate((image) => {
    const canvas = Object.assign(document.createElement('canvas'), { width: image.naturalWidth, height: image.naturalHeight });
    const context = canvas.getContext('2d');
    context.drawImage(image, 0, 0);
    return [...context.getImageData(0, 0, 1, 1).data];
  });
  assert.equal(corner[3], 0, 'the ground is transparent');
  await close();
});

test('fits a phone', async () => {
  const { page, errors, close } = await openPage(browser, pathToFileURL(file).href, phone);
  assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), 'nothing sticks out at the side');
  assert.deepEqual(errors, []);
  await close();
});

test('is one file that asks for no other', () => {
  const text = readFileSync(file, 'utf8');
  assert.doesNotMatch(text, /<(?:script|img|link)[^>]+(?:src|href)="(?!data:)/);
});

test('shows what a repair did, before and after', async () => {
  const out = join(folder, 'repaired.html');
  run('repair', ...makeTube('bent', { frames: 24 }), '-o', join(folder, 'bent.npz'), '--report', out, '--quiet');
  const { page, verdict, kind, text, close } = await read(out);
  assert.equal(verdict, 'Proven: nothing touches, in no frame and at no time between frames');
  assert.equal(kind, 'free');
  assert.match(text, /\d+ of them were moved, by at most [\d.]+ in frame \d+/);
  const pictures = await page.locator('.comparison img').evaluateAll((images) => images.map(({ src, alt, naturalWidth }) => ({ src, alt, naturalWidth })));
  assert.ok(pictures.length >= 2 && pictures.every(({ naturalWidth }) => naturalWidth > 0));
  assert.match(pictures[0].alt, /^Frame \d+, before$/);
  assert.equal(pictures[1].alt, pictures[0].alt.replace('before', 'after'));
  assert.notEqual(pictures[0].src, pictures[1].src);
  assert.equal(await page.locator('.comparison .answer.free').count(), await page.locator('.comparison').count());
  assert.equal(await page.locator('.bars i').count(), 24);
  assert.equal(await page.locator('.contacts').count(), 0, 'nothing remains');
  await close();
});

test('shows what a repair left', async () => {
  const out = join(folder, 'left.html');
  const objects = [...makeSpheres('held', { frames: 4 }), ...makeSpheres('other', { frames: 4 })];
  run('repair', ...objects, '--fixed', 'held', '--frames', '0:1', '-o', join(folder, 'left.npz'), '--report', out, '--quiet');
  const { page, verdict, kind, text, close } = await read(out);
  assert.equal(verdict, 'No frame is free and none could be made so: nothing was written');
  assert.equal(kind, 'hit');
  assert.equal(await page.locator('.comparison img').count(), await page.locator('.comparison').count(), 'only before');
  assert.match(text, /What remains: \d+ contacts?/);
  assert.match(text, /What may not move, with itself: 1 contact/);
  assert.match(text, /remains\s+Frame \d+, before/);
  assert.match(text, /fixed\s+held/);
  await close();
});
