// The report, as it would be opened from a mail: a file, no network.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { pathToFileURL } from 'node:url';
import { folder, launch, makeTube, openPage, phone, removeFolder, run } from './program.mjs';

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

test('opens from a file, offline, and tells what was found', async () => {
  const { page, errors, close } = await openPage(browser, 'about:blank');
  const requests = [];
  page.on('request', (request) => requests.push(request.url().slice(0, 5)));
  await page.context().setOffline(true);
  await page.goto(pathToFileURL(file).href);
  assert.match(await page.locator('h1').innerText(), /The motion collides in \d+ of 29 steps/);
  assert.match(await page.locator('body').innerText(), /a<b>&/);
  assert.equal(await page.locator('.chart canvas').count(), 4);
  assert.ok((await page.locator('figure img').count()) >= 1);
  assert.ok(await page.evaluate(() => Array.from(document.images).every((image) => image.complete && image.naturalWidth > 0)));
  assert.deepEqual([...new Set(requests)].filter((start) => start !== 'file:' && start !== 'data:'), []);
  assert.deepEqual(errors, []);
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
