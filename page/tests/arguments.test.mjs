// The page without a program pairs dropped meshes and point caches only where no other pairing is possible.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { test } from 'node:test';
import { transformWithEsbuild } from 'vite';

const source = readFileSync(new URL('../src/web/arguments.ts', import.meta.url), 'utf8');
const { code } = await transformWithEsbuild(source, 'arguments.ts');
const { argumentsOf } = await import(`data:text/javascript,${encodeURIComponent(code)}`);
const filesOf = (...paths) => argumentsOf(paths).files;

test('pairs a cache with the mesh of its name, or the only two that are left', () => {
  assert.deepEqual(filesOf('body.obj', 'shirt.obj', 'shirt.pc2', 'a.mdd'), ['shirt.obj', 'shirt.pc2', 'body.obj', 'a.mdd']);
  assert.deepEqual(filesOf('body.obj', 'shirt.obj', 'a_walk.pc2', 'body.pc2'), ['body.obj', 'body.pc2', 'shirt.obj', 'a_walk.pc2']);
  assert.deepEqual(filesOf('rest.obj', 'walk.pc2'), ['rest.obj', 'walk.pc2']);
});

test('leaves a cache alone where meshes are left to choose from, or none', () => {
  assert.deepEqual(filesOf('body.obj', 'shirt.obj', 'hat.obj', 'a_walk.pc2', 'body.pc2'), ['body.obj', 'body.pc2', 'a_walk.pc2', 'hat.obj', 'shirt.obj']);
  assert.deepEqual(filesOf('body.obj', 'shirt.obj', 'walk.pc2'), ['walk.pc2', 'body.obj', 'shirt.obj']);
  assert.deepEqual(filesOf('body.obj', 'a.pc2', 'body.pc2'), ['body.obj', 'body.pc2', 'a.pc2']);
});
