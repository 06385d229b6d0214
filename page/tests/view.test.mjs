// The page in a real browser, against the real program.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { after, before, test } from 'node:test';
import { join } from 'node:path';
import { folder, gapNote, launch, makeGap, makeSpheres, makeTube, openPage, phone, picture, removeFolder, run, state, textOf, until, view } from './program.mjs';

const kFrames = 400;
let browser, withModel, without;

const differs = (a, b) => Buffer.compare(a, b) !== 0;

/** Waits until a picture meets a condition. */
async function looks(page, condition, what) {
  for (const end = Date.now() + 5000; Date.now() < end; ) if (condition(await picture(page))) return;
  assert.fail(what);
}

/** The picture once nothing moves. */
async function still(page) {
  await state(page);
  for (let last = await picture(page); ; ) {
    await page.waitForTimeout(100);
    const now = await picture(page);
    if (!differs(now, last)) return now;
    last = now;
  }
}

/** Where the camera is after a flight. */
async function landed(page) {
  for (let last = ''; ; await page.waitForTimeout(100)) {
    const { camera } = await state(page);
    if (camera.join() === last) return camera;
    last = camera.join();
  }
}

before(async () => {
  // A name that must not be interpreted as markup.
  const tube = makeTube('tube<img src=x onerror=alert(1)>', { frames: kFrames });
  const poses = makeTube('poses', { frames: 24 });
  const model = join(folder, 'tube.model');
  run('train', ...poses, '-o', model, '--quiet');
  [browser, withModel, without] = await Promise.all([launch(), view(...tube, '--model', model), view(...makeTube('plain', { frames: 12 }), '--substeps', '4')]);
});

after(async () => {
  await browser?.close();
  await Promise.all([withModel?.end(), without?.end()]);
  removeFolder();
});

/** Opens a page, waits for its first picture and for the check, and closes it without an error. */
async function visit(server, body, size) {
  const { page, errors, close } = await openPage(browser, server.url, size);
  try {
    await until(page, (s) => s.firstPicture > 0, 'a first picture');
    await until(page, (s) => s.state === 'done', 'the end of the check', 30_000);
    await body(page);
    assert.deepEqual(errors, []);
  } finally {
    await close();
  }
}

test('loads and plays a motion of 400 frames', () =>
  visit(withModel, async (page) => {
    assert.equal((await state(page)).steps, kFrames - 1);
    assert.match(await textOf(page, '.status .text'), /goes through itself.*, in frame \d+/);
    assert.match(await page.locator('.status .text').getAttribute('title'), /Collisions in \d+ of 399 steps/);
    await page.keyboard.press(' ');
    const { position } = await until(page, (s) => s.playing && s.position > 2, 'playing');
    await until(page, (s) => s.position > position + 2, 'the frame to go on');
    await page.click('.play');
    const { playing, bytes, budget } = await state(page);
    assert.equal(playing, false);
    assert.ok(bytes > 0 && bytes <= budget, `${bytes} bytes of ${budget}`);
  }));

test('scrubs on the timeline, steps with keys and buttons', () =>
  visit(withModel, async (page) => {
    const before = await still(page);
    const box = await page.locator('.track').boundingBox();
    await page.mouse.click(box.x + box.width / 2, box.y + box.height / 2);
    const { position, step } = await until(page, (s) => Math.abs(s.position - (kFrames - 1) / 2) < 2 && !s.waiting, 'the middle');
    assert.ok(position > 0);
    await looks(page, (now) => differs(now, before), 'the middle');
    await page.keyboard.press('ArrowRight');
    assert.equal((await state(page)).step, step + 1);
    await page.click('[title="One step back (←)"]');
    assert.equal((await state(page)).step, step);
    await page.keyboard.press('End');
    assert.equal((await state(page)).position, kFrames - 1);
  }));

test('picks a pair and flies there', () =>
  visit(withModel, async (page) => {
    await page.click('#tab-collisions');
    await page.keyboard.press('n');
    const row = page.locator('.pair:visible').first();
    await row.waitFor();
    const before = await state(page);
    const seen = await still(page);
    await row.click();
    const now = await until(page, (s) => s.camera.join() !== before.camera.join(), 'the flight to a pair');
    const toi = Number((await row.locator('.toi').innerText()).match(/\d\.\d+/)[0]);
    assert.ok(Math.abs(now.t - toi) < 1e-3, `the time is ${now.t} and the pair's ${toi}`);
    await looks(page, (picture) => differs(picture, seen), 'the pair');
    await page.keyboard.press('r');
  }));

test('switches every layer', () =>
  visit(withModel, async (page) => {
    await page.click('#tab-collisions');
    await page.keyboard.press('n');
    await until(page, (s) => s.facesShown === s.step && !s.waiting, 'the answer of the step');
    await page.locator('.pair:visible').first().click();
    await page.keyboard.press('-');
    await page.keyboard.press('-');
    await page.click('#tab-layers');
    for (const layer of ['collisions', 'contacts', 'keyPoints', 'boxes', 'edges', 'seeThrough']) {
      const before = await still(page);
      const box = page.locator(`[data-layer=${layer}]`);
      await box.click();
      await looks(page, (now) => differs(now, before), `${layer} shows`);
      await box.click();
      await looks(page, (now) => !differs(now, before), `${layer} goes back to what was`);
    }
    const seen = [await still(page)];
    for (const paint of ['level', 'margin', 'error']) {
      await page.click(`input[value=${paint}]`);
      await looks(page, (now) => differs(now, seen.at(-1)), `the color ${paint}`);
      seen.push(await still(page));
      assert.ok((await page.locator('.legend .scale').count()) >= 1, `${paint} has a legend`);
    }
    assert.equal(new Set(seen.map((png) => png.toString('base64'))).size, seen.length, 'every color looks different');
  }));

test('moves sliders and distinguishes inside from outside', () =>
  visit(withModel, async (page) => {
    await page.click('#tab-shapes');
    await until(page, (s) => s.radius?.state === 'done', 'a radius', 20_000);
    const { radius } = (await state(page)).radius;
    assert.ok(radius > 0, 'this shape has a radius');
    await page.locator('.badge[data-kind=inside]').waitFor();
    const before = await still(page);
    const slider = page.locator('.slider input').first();
    await slider.fill(String(Math.min(3, radius * 0.5).toFixed(2)));
    assert.equal(await page.locator('.badge').getAttribute('data-kind'), 'inside');
    await looks(page, (now) => differs(now, before), 'another shape');
    const wide = page.locator('.shapes >> text=Up to 3 σ');
    if (await wide.isVisible()) await wide.click();
    for (const one of await page.locator('.slider:visible input').all()) await one.fill('3');
    assert.ok((await state(page)).norm > radius, 'the sliders go beyond the radius');
    await page.locator('.badge[data-kind=outside]').waitFor();
    assert.match(await textOf(page, '.badge'), /Outside the certified radius/);
  }));

test('proves nothing at the certified radius itself', () =>
  visit(withModel, async (page) => {
    await page.route('**/model/radius', (route) => route.fulfill({ json: { state: 'done', radius: 0, share: 0 } }));
    await page.click('#tab-shapes');
    await until(page, (s) => s.radius?.state === 'done', 'a radius');
    assert.match(await textOf(page, '.badge'), /^Outside the certified radius \(0 σ from the mean, proven below 0 σ\)/);
  }));

test('ties charts to the timeline', () =>
  visit(withModel, async (page) => {
    await page.click('#tab-charts');
    await page.locator('.chart .u-over').nth(4).waitFor();
    assert.equal(await page.locator('.chart').count(), 5);
    const box = await page.locator('.chart[data-chart=time] .u-over').boundingBox();
    await page.mouse.click(box.x + box.width / 4, box.y + box.height / 2);
    const { position } = await state(page);
    assert.ok(Math.abs(position - (kFrames - 1) / 4) < 6, `a quarter of the way, and not ${position}`);
  }));

test('shows names as text', () =>
  visit(withModel, async (page) => {
    assert.match(await textOf(page, 'header .title'), /<img src=x onerror=alert\(1\)>/);
    assert.equal(await page.locator('img').count(), 0);
  }));

test('goes without a model, says why, and takes substeps', () =>
  visit(without, async (page) => {
    await page.click('#tab-layers');
    for (const name of ['[data-layer=keyPoints]', 'input[value=error]', 'input[value=prediction]']) assert.ok(await page.locator(name).isDisabled(), name);
    assert.match(await textOf(page, '.layers'), /Needs a model/);
    await page.click('#tab-shapes');
    assert.match(await textOf(page, '#panel-shapes'), /--model/);
    assert.equal((await state(page)).steps, 11 * 4);
    await page.keyboard.press('Home');
    await page.keyboard.press('ArrowRight');
    assert.equal((await state(page)).position, 0.25);
  }));

test('fits a phone, opens its help, changes its colors', () =>
  visit(
    without,
    async (page) => {
      const { scrolls, canvas } = await page.evaluate(() => ({ scrolls: document.documentElement.scrollWidth > innerWidth, canvas: document.querySelector('.stage canvas').clientHeight }));
      assert.ok(!scrolls, 'nothing sticks out at the side');
      assert.ok(canvas > 250, `the picture is ${canvas} pixels high`);
      await page.keyboard.press('?');
      assert.ok(await page.locator('dialog').isVisible());
      await page.keyboard.press('Escape');
      const theme = () => page.evaluate(() => document.documentElement.dataset.theme);
      const before = await theme();
      await page.click('[aria-label="Switch between light and dark"]');
      assert.notEqual(await theme(), before);
    },
    phone,
  ));

/** A page of a program of its own, after the end of the check. */
async function withPage(args, body, { end = 'done', prepare = async () => {} } = {}) {
  const server = await view(...args);
  const { page, errors, close } = await openPage(browser, 'about:blank');
  try {
    await prepare(page);
    await page.goto(server.url);
    await until(page, (s) => s.firstPicture > 0 && s.state === end, `the state ${end}`, 20_000);
    await body(page);
    assert.deepEqual(errors.filter((text) => !/Failed to load resource/.test(text)), []);
  } finally {
    await close();
    await server.end();
  }
}

const verdict = async (page) => ({ text: await textOf(page, '.status .text'), kind: await page.locator('.status').getAttribute('data-kind') });

/** How many pixels of the timeline are of the color that a free step has. */
const green = (page) =>
  page.evaluate(() => {
    const canvas = document.querySelector('.strip');
    const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
    const [r, g, b] = getComputedStyle(document.documentElement).getPropertyValue('--free').trim().slice(1).match(/../g).map((hex) => parseInt(hex, 16));
    let n = 0;
    for (let k = 0; k < data.length; k += 4) if (data[k] === r && data[k + 1] === g && data[k + 2] === b) ++n;
    return n;
  });

test('reports crossings of two overlapping spheres, though no step collides', () =>
  withPage(makeSpheres('merged', { frames: 6 }), async (page) => {
    const { text, kind } = await verdict(page);
    assert.match(text, /^merged goes through itself, [\d.]+ deep at worst, in frame \d$/);
    assert.equal(kind, 'hit');
    const { start } = await until(page, (s) => s.inside?.[0] > 0, 'the triangles that are inside');
    assert.equal(await green(page), 0, 'no step is shown as free');
    await page.keyboard.press('l');
    assert.match(await textOf(page, '.legend'), /Inside or crossing now[^]*Meets in this step/);
    await page.keyboard.press('l'); // The legend lies over the picture.
    await page.keyboard.press('r'); // The page begins at the contact.
    await page.keyboard.press('Home');
    await page.click('#tab-collisions');
    await page.locator('.pair:visible .kind.tt').first().waitFor();
    assert.match(await textOf(page, '.collisions'), new RegExp(`Frame 0 starts with ${start.crossings} crossing pairs`));
    for (const step of [0, 3]) {
      assert.equal((await state(page)).step, step);
      assert.equal(await textOf(page, '.collisions .head').then((head) => head.split('\n')[0]), 'No new contact in this step');
      const red = await still(page);
      await page.keyboard.press('c');
      await looks(page, (now) => differs(now, red), `what is inside is seen in step ${step}`);
      await page.keyboard.press('c');
      if (step === 0) for (let k = 0; k < 3; ++k) await page.keyboard.press('ArrowRight');
    }
    await page.keyboard.press('p');
    assert.equal((await state(page)).position, 0, 'the start can be reached');
    const { camera } = await state(page);
    await page.locator('.pair:visible').first().click();
    await until(page, (s) => s.camera.join() !== camera.join(), 'the flight to a pair');
    await page.keyboard.press('l');
    assert.match(await textOf(page, '.legend'), /first edge or triangle/);
  }));

test('opens on the worst contact and goes to others', () =>
  withPage(makeSpheres('touching', { frames: 5, distance: 1.9 }), async (page) => {
    const { contact, camera, position } = await until(page, (s) => s.contact !== null && s.curve && !s.waiting, 'the worst contact with its curve');
    assert.equal(contact, 1);
    assert.match(await textOf(page, '.status .text'), /^touching goes through itself, /);
    const card = page.locator('.contact').first();
    assert.match(await card.innerText(), /at \(.*\)\s+0\.\d+ deep\s+frames 0[^]*from the start/);
    assert.equal(await card.getAttribute('aria-selected'), 'true');
    const near = await still(page);
    await page.keyboard.press('r');
    const away = await until(page, (s) => s.contact === null && s.camera.join() !== camera.join(), 'leaving it');
    await looks(page, (now) => differs(now, near), 'all of it');
    await page.keyboard.press('End');
    await page.click('.leads >> text=Worst');
    const back = await until(page, (s) => s.contact === 1 && s.position === position && s.curve, 'the worst again');
    assert.notDeepEqual(back.camera, away.camera);
    await page.waitForFunction(() => /contact=1&.*camera=/.test(location.hash));
    await page.mouse.move(...(await page.locator('.track').boundingBox().then((box) => [box.x + box.width / 2, box.y + 30])));
    await page.locator('.hovercard:visible canvas:visible').waitFor();
    assert.match(await textOf(page, '.hovercard'), /frame 2\s+#1: 0\.\d+ deep/);
  }));

test('lists contacts of one object, and those between two', async () => {
  const [a, b] = ['one', 'other'].map((name) => makeSpheres(name, { frames: 3, distance: 1.9 }));
  const server = await view(...a, ...b);
  await visit(server, async (page) => {
    await until(page, (s) => s.contacts > 2, 'contacts');
    const count = async (choice) => {
      await page.selectOption('[aria-label="Between which"]', choice);
      await state(page);
      return page.locator('.contact').count();
    };
    const names = await page.locator('[label=of] option').allInnerTexts();
    assert.equal(names.length, 2);
    const [all, ofOne, ofOther, both] = [await count(''), await count(names[0]), await count(names[1]), await count(names.join(' – '))];
    assert.ok(ofOne < all && both < ofOne, `${[all, ofOne, ofOther, both]}`);
    assert.equal(all, ofOne + ofOther - both);
  });
  await server.end();
});

test('shows again what its address says', async () => {
  const server = await view(...makeSpheres('linked', { frames: 5 }));
  const { page, errors, close } = await openPage(browser, `${server.url}#at=3&up=z&camera=1,2,3,0,0,0`);
  await until(page, (s) => s.contacts === 1 && s.firstPicture > 0, 'the contacts', 20_000);
  const { position, up, camera, contact } = await state(page);
  assert.deepEqual({ position, up: up[2], contact }, { position: 3, up: 1, contact: null });
  assert.deepEqual(camera.map((value) => Math.round(value)), [1, 2, 3]);
  assert.deepEqual(errors, []);
  await close();
  await server.end();
});

test('looks the same far from the origin', async () => {
  const pictures = [];
  for (const far of [0, 1_000_000]) {
    await withPage(makeSpheres(`far-${far}`, { frames: 1, distance: 2.5, far }).slice(0, 1), async (page) => {
      const smooth = await still(page);
      await page.keyboard.press('e');
      await looks(page, (now) => differs(now, smooth), 'edges');
      pictures.push(await still(page));
    });
  }
  assert.ok(!differs(...pictures), 'a sphere at a million');
});

test('zooms its timeline, loops a range, goes to a typed frame', () =>
  visit(withModel, async (page) => {
    const { x, y, width } = await page.locator('.track').boundingBox();
    await page.mouse.move(x + width / 4, y + 6);
    await page.mouse.down();
    await page.mouse.move(x + width / 2, y + 6, { steps: 3 });
    await page.mouse.up();
    await page.keyboard.press('Home');
    await page.keyboard.press(' ');
    const { position } = await until(page, (s) => s.position > 0, 'playing');
    assert.ok(position >= 99 && position <= 201, `plays in the range, not at ${position}`);
    await page.keyboard.press(' ');
    const stopped = (await until(page, (s) => !s.playing, 'the stop')).position;
    await page.mouse.move(x + width / 2, y + 30);
    for (let k = 0; k < 4; ++k) await page.mouse.wheel(0, -400);
    await page.mouse.click(x + width - 2, y + 30);
    const end = (await until(page, (s) => s.position !== stopped, 'the right end')).position;
    assert.ok(end < 300, `the track shows a part, its end is at ${end}`);
    await page.keyboard.press('g');
    await page.keyboard.type('7');
    await page.keyboard.press('Enter');
    await until(page, (s) => s.position === 7, 'frame 7');
  }));

test('saves a picture', () =>
  visit(without, async (page) => {
    const [download] = await Promise.all([page.waitForEvent('download'), page.click('[aria-label="Save the picture (PNG)"]')]);
    assert.deepEqual([...readFileSync(await download.path()).subarray(1, 4)], [...Buffer.from('PNG')]);
  }));

test('repairs, shows before and after, and saves what the program calls free', async () => {
  run('demo', '--quiet', join(folder, 'demo'));
  const walk = await view(join(folder, 'demo', 'walk.glb'));
  await visit(walk, async (page) => {
    await until(page, (s) => s.contacts > 0, 'contacts');
    assert.equal(await page.locator('[name=source][value=repaired]').isDisabled(), true);
    await page.click('.repair button >> text=Repair');
    await until(page, (s) => s.repaired && s.shape === 'repaired', 'the repaired motion', 30_000);
    assert.match(await textOf(page, '.stage > .badge'), /^Repaired\. Proven: nothing touches/);
    const after = await still(page);
    await page.keyboard.press('f');
    await until(page, (s) => s.shape === 'motion', 'what was before');
    assert.ok(differs(after, await still(page)));
    await page.click('.repair >> text=After');
    assert.equal((await state(page)).shape, 'repaired');
    await page.click('[role=tab] >> text=Layers');
    await page.click('[name=paint][value=correction]');
    await looks(page, (image) => differs(image, after), 'no corrections are seen');
    assert.match(await textOf(page, '.legend'), /Correction, mesh units/);
    await page.click('[role=tab] >> text=Contacts');
    const [download] = await Promise.all([page.waitForEvent('download'), page.click('text=Save walk-repaired.glb')]);
    const path = join(folder, 'walk-repaired.glb');
    await download.saveAs(path);
    assert.equal(JSON.parse(run('check', path, '--json', '-')).clean, true);
  });
  await walk.end();
});

test('repairs one object beside another that may not move', async () => {
  const clothed = await view(join(folder, 'demo', 'body.npz'), join(folder, 'demo', 'shirt.npz'));
  await visit(clothed, async (page) => {
    await until(page, (s) => s.contacts > 0, 'contacts');
    await page.click('.repair >> text=Repair…');
    await page.click('.repair label >> text=body');
    await page.click('.repair .form button >> text=Repair');
    await until(page, (s) => s.repaired, 'the repaired motion', 30_000);
    assert.match(await textOf(page, '.stage > .badge'), /apart from what may not move, which touches itself/);
    assert.deepEqual(await page.locator('.repair >> text=/^Save/').allInnerTexts(), ['Save shirt-repaired.npz', 'Save report']);
    // Only the contacts of a card, and what stays is said.
    await page.click('.contacts .contact >> text=body with itself');
    await page.click('.contact[aria-selected=true] >> text=Repair only this');
    assert.match(await textOf(page, '.repair .form'), /^Only this is repaired: body with itself\. Other contacts stay\./);
    await page.click('.repair label >> text=body');
    await page.click('.repair .form button >> text=Repair');
    await page.waitForSelector('.repair >> text=/^Save body/', { timeout: 30_000 });
    assert.match(await textOf(page, '.repair .verdict'), /what was chosen is gone.* left: body and shirt go through each other/);
    // The shirt was not moved.
    assert.deepEqual(await page.locator('.repair >> text=/^Save/').allInnerTexts(), ['Save body-repaired.npz', 'Save report']);
    await page.click('.remaining >> text=/^body – shirt: .* deep, frames? \\d/');
    await until(page, (s) => s.shape === 'repaired' && s.left > 0 && !s.waiting, 'what was left');
    assert.match(await textOf(page, '.legend'), /What still touches: one side/);
    const shown = await still(page);
    const [report] = await Promise.all([page.waitForEvent('download'), page.click('text=Save report')]);
    assert.match(report.suggestedFilename(), /-repair\.html$/);
    const html = readFileSync(await report.path(), 'utf8');
    for (const field of ['"left":[{"number":', '"fixed":[]']) assert.ok(html.includes(field), field);
    await page.keyboard.press('f');
    await looks(page, (now) => differs(now, shown), 'what was before');
  });
  await clothed.end();
});

test('paints vertices that stay', async () => {
  const spheres = await view(...makeSpheres('painted', { distances: [2.3, 1.9, 2.3] }));
  await visit(spheres, async (page) => {
    await until(page, (s) => s.contacts > 0, 'contacts');
    await page.keyboard.press('r');
    await page.keyboard.press('1');
    await landed(page);
    const plain = await still(page);
    await page.click('.repair >> text=What may move…');
    await page.click('text=Paint what stays');
    const box = await page.locator('.stage canvas').boundingBox();
    const [x, y] = [box.x + box.width / 4, box.y + box.height / 2];
    const camera = await landed(page);
    await page.mouse.move(x, y);
    await page.mouse.down();
    await page.mouse.move(x + 60, y, { steps: 3 });
    await page.mouse.up();
    const { painted } = await until(page, (s) => s.painted > 0, 'paint');
    assert.deepEqual(await landed(page), camera, 'painting does not orbit');
    assert.match(await textOf(page, '.paint'), new RegExp(`${painted} vertices stay`));
    await looks(page, (now) => differs(now, plain), 'paint is seen');
    assert.equal(await page.locator('.card:visible').count(), 0, 'nothing was picked');
    // Shift erases what is under the brush.
    await page.keyboard.down('Shift');
    await page.mouse.click(x + 60, y);
    await page.keyboard.up('Shift');
    const { painted: fewer } = await until(page, (s) => s.painted < painted, 'erasing');
    assert.ok(fewer > 0);
    // Beside the surface a drag orbits.
    await page.mouse.move(box.x + box.width - 60, box.y + 100);
    await page.mouse.down();
    await page.mouse.move(box.x + box.width - 90, box.y + 130, { steps: 3 });
    await page.mouse.up();
    assert.notDeepEqual(await landed(page), camera);
    await page.keyboard.press('Escape');
    assert.equal(await page.locator('text=Paint what stays').getAttribute('aria-pressed'), 'false');
    const asked = page.waitForRequest(/repair\/start/);
    await page.click('.repair .form button >> text=/^Repair$/');
    assert.match((await asked).url(), /vertices=0:\d+/);
    await until(page, (s) => s.repaired, 'the repaired motion', 30_000);
    await page.waitForSelector(`.repair >> text=${fewer} vertices stay…`);
    await page.click(`.repair >> text=${fewer} vertices stay…`);
    await page.click('.paint >> text=Clear');
    assert.equal((await state(page)).painted, 0);
    // From near, where no vertex is under the brush, the nearest one.
    await page.click('text=Paint what stays');
    await page.locator('[aria-label="Size of the brush"]').fill('6');
    await page.keyboard.press('r');
    await page.keyboard.press('1');
    await landed(page);
    for (let k = 0; k < 14; ++k) await page.keyboard.press('+');
    await landed(page);
    await page.mouse.click(x, y);
    await until(page, (s) => s.painted === 1, 'the nearest vertex');
  });
  await spheres.end();
});

test('cuts, turns upright, looks from six sides', () =>
  visit(without, async (page) => {
    await page.keyboard.press('r');
    await page.keyboard.press('Home');
    const whole = await still(page);
    await page.click('#tab-layers');
    await page.selectOption('[data-option=cut]', 'x');
    await looks(page, (now) => differs(now, whole), 'a cut');
    await page.selectOption('[data-option=cut]', '');
    await looks(page, (now) => !differs(now, whole), 'no cut');
    const cameras = [];
    for (const key of '123456') {
      await page.keyboard.press(key);
      cameras.push((await landed(page)).map((value) => value.toFixed(2)).join());
    }
    assert.equal(new Set(cameras).size, 6, `six sides: ${cameras.join(' ')}`);
    await page.keyboard.press('z');
    await until(page, (s) => s.up[2] === 1, 'z up');
  }));

test('reports a free motion', () =>
  withPage(makeSpheres('apart', { frames: 6, distance: 2.5 }), async (page) => {
    assert.deepEqual(await verdict(page), { text: 'No collisions: no triangles cross in frame 0, and all 5 steps are proven free', kind: 'free' });
    assert.ok((await green(page)) > 1000);
    // No step begins in the last frame.
    const { x, y, width } = await page.locator('.track').boundingBox();
    for (const [share, card] of [[0.4, /frame 2[^]*no contact/], [0.999, /frame 5[^]*no contact/]]) {
      await page.mouse.move(x + share * width, y + 30);
      await page.locator('.hovercard:visible').waitFor();
      assert.match(await textOf(page, '.hovercard'), card);
    }
    assert.match(await textOf(page, '.contacts'), /No contacts\s+Nothing touches or crosses at any time/);
    await page.click('#tab-collisions');
    assert.match(await textOf(page, '.collisions'), /Nothing crosses in frame 0\.\s+Nothing is inside and nothing meets/);
  }));

/** What the tab of contacts says, once they are known. */
async function contactsText(page) {
  await until(page, (s) => s.contacts !== null, 'contacts');
  return textOf(page, '.contacts');
}

test('says that it skips frames', () =>
  withPage([...makeSpheres('stride', { frames: 6, distance: 2.5 }), '--frames', '::5'], async (page) => {
    assert.equal((await verdict(page)).text, 'No collisions: no triangles cross in frame 0, and the one step is proven free; only every 5th frame was checked');
    assert.match(await contactsText(page), /^No contacts\s+No contacts among what was tested\.$/);
  }));

for (const option of ['--within', '--between', '--steps-only']) {
  test(`claims nothing about what ${option} leaves out`, () =>
    withPage([...makeSpheres(`one${option}`, { frames: 2, distance: 2.5 }), ...makeSpheres(`other${option}`, { frames: 2, distance: 2.5, far: 9 }), option], async (page) => {
      assert.match(await contactsText(page), /^No contacts\s+(What crosses is not known in 2 frames: too many pairs, or not tested\. )?No contacts among what was tested\.$/);
    }));
}

test('says which pairs contacts leave out', async () => {
  const tube = makeTube('limited', { frames: 24 });
  await withPage([...tube, '--limit', '0'], async (page) => {
    assert.match(await contactsText(page), /^Contacts\s+Contacts join only the 0 of [\d,]+ colliding pairs that are listed \(--limit\)\. What crosses is not known in \d+ frames: too many pairs, or not tested\.$/);
  });
  await withPage([...tube, '--limit', '1'], async (page) => {
    assert.match(await contactsText(page), /^\d+ contacts?, the worst first\s+Contacts join only the \d+ of [\d,]+ colliding pairs that are listed \(--limit\)\./);
  });
  await withPage([...tube, '--limit', '1', '--static'], async (page) => {
    assert.match(await contactsText(page), /Contacts join only the \d+ of [\d,]+ crossing pairs that are listed \(--limit\)\./);
  });
});

test('says which crossings from the start are not listed', () =>
  withPage([...makeSpheres('listed', { frames: 3 }), '--limit', '5'], async (page) => {
    assert.doesNotMatch(await contactsText(page), /No contacts|No collisions/);
    await page.keyboard.press('Home');
    await page.click('#tab-collisions');
    await page.locator('.pair:visible .kind.tt').nth(4).waitFor();
    assert.match(await textOf(page, '.collisions'), /^Frame 0 starts with [\d,]+ crossing pairs of triangles\. Only 5 are marked; --limit N marks more\.\s/);
    assert.equal(await page.locator('.pair:visible').count(), 5);
  }));

test('tells what is within one object from what is between two of one name', async () => {
  const spheres = makeSpheres('twins', { frames: 2, distance: 2.5 });
  await withPage([...spheres, ...spheres, '--between'], async (page) => {
    assert.match(await contactsText(page), /twins\.obj with another/);
  });
  await withPage([...makeSpheres('bound', { frames: 2 }), ...spheres], async (page) => {
    assert.match(await contactsText(page), /bound with itself/);
  });
});

test('says what the reader of a motion left out', () =>
  withPage(makeGap('gap'), async (page) => {
    await page.click('#tab-collisions');
    assert.match(await textOf(page, '.collisions'), gapNote);
  }));

test('claims nothing about untested crossings', () =>
  withPage([...makeSpheres('steps', { frames: 6 }), '--steps-only'], async (page) => {
    const { text, kind } = await verdict(page);
    assert.match(text, /^No contact begins in all 5 steps, proven\. Crossings from frame 0 on were not tested/);
    assert.equal(kind, 'run');
    assert.equal(await green(page), 0);
    await page.click('#tab-collisions');
    assert.match(await textOf(page, '.collisions'), /Crossings from the start were not tested/);
  }));

test('shows a single frame as a motion of one frame', () =>
  withPage(makeSpheres('single', { frames: 1 }).slice(0, 1), async (page) => {
    const { text, kind } = await verdict(page);
    assert.match(text, /^single goes through itself, [\d.]+ deep, in frame 0$/);
    assert.equal(kind, 'hit');
    await page.click('#tab-collisions');
    await page.locator('.pair:visible .kind.tt').first().waitFor();
    await page.keyboard.press('ArrowRight');
    assert.equal((await state(page)).t, 0, 'no time passes');
    assert.equal(await textOf(page, '.where'), 'frame 0');
  }));

/** Everything that a page says, in all its tabs. */
async function wordsOf(page) {
  const texts = [];
  for (const key of ['l', '?', 'Escape']) await page.keyboard.press(key);
  for (const tab of ['contacts', 'collisions', 'layers', 'charts']) {
    await page.click(`#tab-${tab}`);
    await state(page);
    texts.push(await page.evaluate(() => [document.querySelector('.app').innerText, document.querySelector('dialog').textContent, ...[...document.querySelectorAll('[title]')].map(({ title }) => title)].join('\n')));
  }
  return texts.join('\n');
}

test('shows the poses of a static check', () =>
  withPage([...makeSpheres('poses', { distances: [2.5, 1.4, 2.5, 1, 2.5] }), '--static'], async (page) => {
    const { text, kind } = await verdict(page);
    assert.match(text, /^poses goes through itself twice, [\d.]+ deep at worst, in frame 3$/);
    assert.equal(kind, 'hit');
    const worst = await until(page, (s) => s.contact !== null && s.curve && !s.waiting, 'the worst contact with its curve');
    assert.deepEqual([worst.position, worst.contacts, worst.steps], [3, 2, 5]);
    assert.match(await textOf(page, '.contacts'), /what happens between frames is not tested[^]*twice[^]*worst in frame 3/);
    assert.ok((await green(page)) > 1000);
    await page.keyboard.press('Home');
    await until(page, (s) => s.contact === null && !s.waiting, 'a pose without the contact');
    await page.keyboard.press('r');
    const visited = [];
    for (const key of ['n', 'n', 'n', 'p', 'ArrowRight', '.', 'End']) {
      await page.keyboard.press(key);
      visited.push((await state(page)).position);
    }
    assert.deepEqual(visited, [1, 3, 3, 1, 2, 2, 4]);
    assert.equal(await textOf(page, '.where'), 'frame 4');
    await page.click('#tab-collisions');
    assert.match(await textOf(page, '.collisions .head'), /^Nothing crosses\s+frame 4$/);
    await page.keyboard.press('p');
    const row = page.locator('.pair:visible .kind.tt').first();
    await row.waitFor();
    const red = await still(page);
    await page.keyboard.press('c');
    await looks(page, (now) => differs(now, red), 'triangles that cross are marked');
    await page.keyboard.press('c');
    const before = await state(page);
    await row.click();
    const there = await until(page, (s) => s.camera.join() !== before.camera.join(), 'the flight to a pair');
    assert.equal(there.position, 3);
    const said = await wordsOf(page);
    assert.match(said, /Inside or crossing/);
    assert.doesNotMatch(said, /\bstep|collision|collid|motion|in contact/i);
  }));

test('plays poses one after the other, with nothing between them', () =>
  withPage([...makeSpheres('played', { distances: [2.5, 2.6, 2.7, 2.8] }), '--static'], async (page) => {
    assert.deepEqual(await verdict(page), { text: 'No triangles cross in any of 4 frames, proven. What happens between frames was not tested', kind: 'free' });
    assert.match(await textOf(page, '.contacts'), /No contacts\s+Nothing crosses in any frame/);
    assert.equal(await page.locator('[aria-label="Time within the step"]').count(), 0);
    const box = await page.locator('.track').boundingBox();
    await page.mouse.click(box.x + 0.6 * box.width, box.y + 30);
    assert.equal((await state(page)).position, 2, 'the third of four quarters');
    await page.keyboard.press(' ');
    const seen = new Set();
    await until(page, ({ position }) => seen.add(position).size === 4, 'all four');
    assert.deepEqual([...seen].sort(), [0, 1, 2, 3]);
  }));

/** Passes on only the first `count` steps, with a given state, and then does `next`. */
const cutAfter = (count, state, next) => async (page) => {
  let requests = 0;
  await page.route('**/api/steps?*', async (route) => {
    if (requests++ > 0) return next ? next(route) : route.continue();
    for (;;) {
      const answer = await (await route.fetch()).json();
      if (answer.done >= count) return route.fulfill({ json: { ...answer, state, done: count, steps: answer.steps.slice(0, count) } });
    }
  });
};

for (const [what, prepare, end, options, reached] of [
  ['was stopped', cutAfter(3, 'stopped'), 'stopped', [], '3 of 5 steps'],
  ['is gone with its program', cutAfter(3, 'running', (route) => route.abort()), 'gone', [], '3 of 5 steps'],
  ['was static and stopped', cutAfter(3, 'stopped'), 'stopped', ['--static'], '3 of 6 frames'],
]) {
  test(`reports how far a check came that ${what}`, () =>
    withPage(
      [...makeSpheres(what.replaceAll(' ', '-'), { frames: 6, distance: 2.5 }), ...options],
      async (page) => {
        assert.deepEqual(await verdict(page), { text: `Stopped at ${reached}; the rest is unknown`, kind: 'stopped' });
        assert.equal(await page.locator('.status progress').isVisible(), false);
        await page.click('#tab-collisions');
        await page.keyboard.press('End');
        assert.match(await textOf(page, '.collisions .head'), /^Not checked/);
        assert.match(await textOf(page, '.collisions'), new RegExp(`Stopped at ${reached}`));
      },
      { end, prepare },
    ));
}

test('says it when the program is gone', async () => {
  const server = await view(...makeTube('short', { frames: 6 }));
  const { page, errors, close } = await openPage(browser, server.url);
  await until(page, (s) => s.state === 'done' && s.framesAhead >= 6, 'the check, and every frame');
  await server.end();
  await page.keyboard.press('Home');
  await page.keyboard.press('b');
  await page.locator('.banner:visible').waitFor({ timeout: 5000 });
  assert.match(await textOf(page, '.banner'), /no longer answers.*Start foldproof view again/);
  await page.keyboard.press('ArrowRight');
  assert.equal((await state(page)).step, 1, 'what is loaded can still be looked at');
  assert.deepEqual(errors.filter((text) => !/Failed to load resource/.test(text)), []);
  await close();
});
