// The page and the program agree on which axis points up and on directions: cases that tests/picture checks, too.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { test } from 'node:test';
import { transformWithEsbuild } from 'vite';

const source = readFileSync(new URL('../src/shared/upright.ts', import.meta.url), 'utf8');
const { code } = await transformWithEsbuild(source, 'upright.ts');
const { defaultDirection, directionAlong, guessUp } = await import(`data:text/javascript,${encodeURIComponent(code)}`);
const cases = JSON.parse(readFileSync(new URL('../../tests/picture/upright.json', import.meta.url), 'utf8'));

const near = (a, b) => a.forEach((value, k) => assert.ok(Math.abs(value - b[k]) < 1e-9, `${a} is not ${b}`));

test('guesses the axis that points up', () => {
  for (const { name, poses, up } of cases.motions) {
    const boxes = poses.map((pose) => ({ min: pose.slice(0, 3), max: pose.slice(3) }));
    assert.equal(guessUp(boxes), up, name);
  }
});

test('looks along a normal, upright', () => {
  for (const { normal, up, from } of cases.normals) near(directionAlong(normal, up), from);
  for (const { up, from } of cases.defaults) near(defaultDirection(up), from);
});
