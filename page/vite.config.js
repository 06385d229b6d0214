// Two builds: `foldproof view` serves dist/view, `foldproof report` embeds dist/report in its file.
import { readFileSync } from 'node:fs';
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

export default defineConfig(({ mode }) => (mode === 'report' ? report : view));
