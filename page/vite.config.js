// Three builds: `foldproof view` serves dist/view, `foldproof report` embeds dist/report in its file, and dist/web is the page
// that needs no program (./dev web).
import { createHash } from 'node:crypto';
import { readdirSync, readFileSync } from 'node:fs';
import { resolve } from 'node:path';
import { defineConfig } from 'vite';

/** Puts the licenses of bundled packages before the scripts, as they require. */
const licenses = (...packages) => ({
  name: 'licenses',
  generateBundle(_, bundle) {
    const texts = packages.map((name) => `${name}\n\n${readFileSync(`node_modules/${name}/LICENSE`, 'utf8').trim()}`);
    for (const file of Object.values(bundle)) {
      if (file.type === 'chunk') file.code = `/*! Made with these packages:\n\n${texts.join('\n\n')}\n*/\n${file.code}`;
    }
  },
});

const view = {
  plugins: [licenses('three', 'uplot')],
  build: {
    outDir: 'dist/view',
    emptyOutDir: true,
    // The content security policy forbids inline scripts.
    modulePreload: { polyfill: false },
    assetsInlineLimit: 0,
    target: 'es2022',
    chunkSizeWarningLimit: 1000,
  },
  server: { proxy: { '/api': process.env.FOLDPROOF_SERVER ?? 'http://127.0.0.1:8080' } },
};

const report = {
  plugins: [licenses('uplot')],
  build: {
    outDir: 'dist/report',
    emptyOutDir: true,
    target: 'es2022',
    cssCodeSplit: false,
    lib: {
      entry: 'src/report/main.ts',
      formats: ['iife'],
      name: 'foldproofReport',
      fileName: () => 'report.js',
      cssFileName: 'report',
    },
  },
};

/** Writes offline.js, a service worker that keeps all files of this build in the browser. */
const offline = (publicDir) => ({
  name: 'offline',
  generateBundle(_, bundle) {
    const files = ['./', ...Object.keys(bundle), ...readdirSync(publicDir)].filter((name) => !name.endsWith('.html'));
    const version = createHash('sha256').update(JSON.stringify(files)).digest('hex').slice(0, 16);
    const source = readFileSync('src/web/offline.js', 'utf8').replace("'VERSION'", JSON.stringify(version)).replace("['FILES']", JSON.stringify(files));
    this.emitFile({ type: 'asset', fileName: 'offline.js', source });
  },
});

const web = {
  root: 'web',
  base: './',
  plugins: [licenses('three', 'uplot', 'fflate'), offline('web/public')],
  resolve: {
    alias: [
      { find: 'foldproof-engine', replacement: resolve('../build-web/page_engine.js') },
      { find: /^foldproof-sample/, replacement: resolve('../build-web/demo/walk.glb') },
    ],
  },
  assetsInclude: ['**/*.glb'],
  worker: { format: 'es' },
  build: {
    outDir: '../../out/web',
    emptyOutDir: true,
    modulePreload: { polyfill: false },
    target: 'es2022',
    chunkSizeWarningLimit: 8000,
  },
};

export default defineConfig(({ mode }) => ({ report, web })[mode] ?? view);
