import '../shared/base.css';
import './view.css';
import { el } from '../shared/dom';
import { startTheme } from '../shared/theme';
import { getJson, type SceneInfo } from './api';
import { App } from './app';

async function start(): Promise<void> {
  const root = document.querySelector<HTMLElement>('#app')!;
  startTheme();
  try {
    const scene = await getJson<SceneInfo>('scene');
    document.title = `${scene.title} – Foldproof`;
    await new App(root, scene).start();
  } catch (error) {
    const gl = error instanceof Error && /WebGL/.test(error.message);
    root.replaceChildren(
      el(
        'div',
        { className: 'fatal', role: 'alert' },
        el('h1', {}, 'This cannot be shown'),
        el('p', {}, error instanceof Error ? error.message : String(error)),
        el('p', {}, gl ? 'The page needs WebGL 2: use a current browser, or switch hardware acceleration on in its settings.' : 'See that foldproof view still runs in its terminal, then load this page again.'),
        el('button', { className: 'small', type: 'button', onclick: () => location.reload() }, 'Load again'),
      ),
    );
  }
}

void start();
