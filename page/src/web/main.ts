// The page without a program: files are dropped, a worker checks them, and the page of `foldproof view` shows the answer.
import '../shared/base.css';
import '../view/view.css';
import './web.css';
import { el } from '../shared/dom';
import { startTheme } from '../shared/theme';
import { getJson, useSource, type SceneInfo } from '../view/api';
import { App } from '../view/app';
import { nameOf, save } from '../view/capture';
import { Engine } from './engine';
import type { InputFile, Settings } from './messages';
import { StartPage } from './start';

const root = document.querySelector<HTMLElement>('#app')!;
const start = new StartPage((files, settings) => void open(files, settings));

/** While files are read: nothing can be shown yet. */
function reading(files: InputFile[]): HTMLElement {
  const name = files.length === 1 ? files[0]!.path : `${files.length} files`;
  return el('div', { className: 'app skeleton' }, el('header', {}, el('h1', {}, 'Foldproof')), el('section', { className: 'stage' }, el('div', { className: 'loading', role: 'status' }, `Reading ${name}…`, el('progress', {}))), el('div', { className: 'timeline' }), el('aside', {}));
}

async function saveReport(engine: Engine, title: string): Promise<void> {
  const report = await engine.report();
  if (report) save(report, nameOf(title, '.html'));
  else alert('The report is there when the check has ended.');
}

async function open(files: InputFile[], settings: Settings): Promise<void> {
  start.warn('');
  root.replaceChildren(reading(files));
  const engine = new Engine();
  try {
    await engine.open(files, settings);
    useSource(engine.source);
    const scene = await getJson<SceneInfo>('scene');
    document.title = `${scene.title} – Foldproof`;
    await new App(root, scene).start();
    const button = (text: string, title: string, action: () => void) => el('button', { className: 'small', type: 'button', title, onclick: action }, text);
    root.querySelector('header .buttons')!.prepend(
      button('Report', 'Save what was found as one HTML file', () => void saveReport(engine, scene.title)),
      button('Stop', 'End the check after the current step', () => engine.stop()),
      // A page of its own for each motion: nothing of the one before stays behind.
      button('Open', 'Open another motion', () => location.assign(location.pathname)),
    );
  } catch (error) {
    engine.end();
    root.replaceChildren(start.element);
    start.warn(error instanceof Error ? error.message : String(error));
  }
}

startTheme();
root.replaceChildren(start.element);
// Without a network the page comes from the browser's store.
if (import.meta.env.PROD && 'serviceWorker' in navigator) void navigator.serviceWorker.register('offline.js');
