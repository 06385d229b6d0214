// Keyboard shortcuts, except in fields that use the keys themselves.
import { toggleTheme } from '../shared/theme';
import type { LayerPanel } from './layers';
import type { Navigator, Parts } from './navigator';
import type { ViewOptions } from './viewoptions';

export type KeyActions = Record<string, (event: KeyboardEvent) => void>;

export function listen(actions: KeyActions): void {
  document.addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey || document.querySelector('dialog[open]')) return;
    const target = event.target as HTMLElement;
    if (target instanceof HTMLInputElement && target.type === 'number') return;
    const typing = target instanceof HTMLSelectElement || (target instanceof HTMLInputElement && (['range', 'radio'].includes(target.type)));
    if (typing && /^(Arrow|Home|End|Page)/.test(event.key)) return;
    if (event.key === ' ' && (target instanceof HTMLButtonElement || target instanceof HTMLInputElement) && target.getAttribute('role') !== 'option') return;
    const action = actions[(event.shiftKey && event.key.length > 1 ? 'Shift+' : '') + event.key];
    if (!action) return;
    event.preventDefault();
    action(event);
  });
}

export interface Keyed extends Parts {
  navigator: Navigator;
  layers: LayerPanel;
  options: ViewOptions;
  help: HTMLDialogElement;
  beforeOrAfter: () => void;
  leave: () => void;
}

/** What each key does; help.ts lists them. */
export function keyActions({ beforeOrAfter, clock, help, layers, layout, leave, navigator, options, stage, timeline }: Keyed): KeyActions {
  const { camera } = stage;
  const step = (by: number) => () => navigator.goTo(() => clock.move(by));
  const time = (by: number) => () => navigator.goTo(() => clock.seekPosition(clock.position + by / clock.substeps));
  return {
    ' ': () => navigator.play(!clock.playing),
    ArrowLeft: step(-1), ArrowRight: step(1), 'Shift+ArrowLeft': step(-10), 'Shift+ArrowRight': step(10),
    ',': time(-0.01), '.': time(0.01),
    Home: () => navigator.goTo(() => clock.seek(0)), End: () => navigator.goTo(() => clock.seek(clock.steps, 1)),
    '[': () => timeline.changeSpeed(-1), ']': () => timeline.changeSpeed(1), g: () => timeline.typeFrame(),
    p: () => navigator.nextCollision(-1), n: () => navigator.nextCollision(1),
    ArrowUp: () => navigator.moveInList(-1), ArrowDown: () => navigator.moveInList(1),
    r: () => navigator.showAll(), '0': () => navigator.showAll(), Escape: leave,
    '1': () => camera.side('front'), '2': () => camera.side('right'), '3': () => camera.side('top'),
    '4': () => camera.side('back'), '5': () => camera.side('left'), '6': () => camera.side('bottom'),
    W: () => camera.orbit(0, 0.1), S: () => camera.orbit(0, -0.1), A: () => camera.orbit(-0.1, 0), D: () => camera.orbit(0.1, 0),
    '+': () => camera.zoom(0.85), '=': () => camera.zoom(0.85), '-': () => camera.zoom(1.18),
    z: () => options.turn(options.state.up === 'y' ? 'z' : 'y'),
    v: () => layers.cyclePaint(), f: beforeOrAfter,
    c: () => layers.toggle('collisions'), m: () => layers.toggle('meets'), t: () => layers.toggle('contacts'), k: () => layers.toggle('keyPoints'),
    b: () => layers.toggle('boxes'), e: () => layers.toggle('edges'), x: () => layers.toggle('seeThrough'),
    d: toggleTheme, l: () => layout.legend.classList.toggle('closed'), '?': () => help.showModal(),
  };
}
