// Two builds: dist/view is served by `foldproof view`, dist/report is put into the file that `foldproof
// report` writes.
import { defineConfig } from 'vite';

const view = {
  build: {
    outDir: 'dist/view',
    emptyOutDir: true,
    // A script in the page itself would be against its content security policy.
    modulePreload: { polyfill: false },
    assetsInlineLimit: 0,
    target: 'es2022',
    chunkSizeWarningLimit: 1000,
  },
  server: { proxy: { '/api': process.env.FOLDPROOF_SERVER ?? 'http://127.0.0.1:8080' } },
};

const report = {
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
