// Measures a large motion: `npm run measure`. Generated data, 70,312 triangles and 200 frames. Software rendering is slower
// than any graphics card, so the script's own time per picture is measured separately from drawing.
import { launch, makeTube, openPage, removeFolder, state, until, view } from './program.mjs';

const kSeconds = 8;
const server = process.env.URL ? { url: process.env.URL, end: async () => {} } : await view(...makeTube('large', { around: 188, along: 187, frames: 200 }));
const browser = await launch();

async function play(name, seconds) {
  const { page, errors, close } = await openPage(browser, server.url);
  const first = await until(page, (s) => s.firstPicture > 0, 'a first picture', 20_000);
  console.log(`${name}: first picture ${(first.firstPicture / 1000).toFixed(2)} s after the page was asked for`);
  await page.keyboard.press(' ');
  const before = await state(page);
  const start = performance.now();
  await page.waitForTimeout(1000 * seconds);
  const now = await state(page);
  const passed = (performance.now() - start) / 1000;
  const pictures = now.pictures - before.pictures;
  const moved = (now.position - before.position + 199) % 199;
  console.log(`  pictures per second ${(pictures / passed).toFixed(1)}; frames of the motion per second ${(moved / passed).toFixed(1)}, at 30 asked for`);
  console.log(`  per picture: script ${((now.scriptMs - before.scriptMs) / pictures).toFixed(2)} ms, handing it to the graphics ${((now.drawMs - before.drawMs) / pictures).toFixed(2)} ms`);
  console.log(`  held ${(now.bytes / 1e6).toFixed(0)} MB of at most ${(now.budget / 1e6).toFixed(0)} MB; steps checked ${now.steps}, ${now.state}`);
  if (errors.length > 0) console.log(errors.join('\n'));
  await close();
}

try {
  await play('while it is checked', kSeconds);
  const { page, close } = await openPage(browser, server.url);
  await until(page, (s) => s.state !== 'running', 'the end of the check', 300_000);
  await close();
  await play('once it is checked', kSeconds / 2);
} finally {
  await browser.close();
  await server.end();
  removeFolder();
}
