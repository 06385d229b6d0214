// The layout of the page.
import { append, el, icon, setText } from '../shared/dom';
import { themeButton } from '../shared/theme';
import type { Verdict } from '../shared/verdict';
import type { SceneInfo } from './api';

export type Tab = 'contacts' | 'collisions' | 'layers' | 'shapes' | 'charts';
const kTabs: [Tab, string][] = [
  ['contacts', 'Contacts'],
  ['collisions', 'Pairs'],
  ['layers', 'Layers'],
  ['shapes', 'Shapes'],
  ['charts', 'Charts'],
];

export interface ToolActions {
  reset: () => void;
  side: (side: 'front' | 'right' | 'top') => void;
  zoom: (factor: number) => void;
  legend: () => void;
  help: () => void;
  picture: () => void;
  first: () => void;
  worst: () => void;
}

export class Layout {
  readonly stage = el('section', { className: 'stage', 'aria-label': 'Picture' });
  readonly legend = el('ul', { className: 'legend closed', 'aria-label': 'Legend' });
  readonly card = el('div', { className: 'card', hidden: true, role: 'status' });
  readonly verdict = el('div', { className: 'badge', hidden: true });
  private readonly status = el('div', { className: 'status', role: 'status' });
  private readonly statusText = el('span', { className: 'text' });
  private readonly numbers = el('span', { className: 'numbers', hidden: true });
  private readonly leads = el('span', { className: 'leads', hidden: true });
  private readonly worst: HTMLButtonElement;
  private readonly loading = el('div', { className: 'loading', role: 'status' }, 'Loading the first frame…', el('progress', {}));
  private readonly progress = el('progress', { max: 1, value: 0, hidden: true });
  private readonly banner = el('div', { className: 'banner', role: 'alert', hidden: true });
  private readonly bannerText = el('span', {});
  private readonly panels = new Map<Tab, HTMLElement>();
  private readonly tabs = new Map<Tab, HTMLButtonElement>();
  private readonly aside = el('aside', {});
  private tab: Tab = 'contacts';
  onTab: (tab: Tab) => void = () => {};

  constructor(
    root: HTMLElement,
    scene: SceneInfo,
    timeline: (layout: Layout) => HTMLElement,
    private readonly actions: ToolActions,
  ) {
    const lead = (text: string, title: string, action: () => void) => el('button', { type: 'button', title, onclick: action }, text);
    this.worst = lead('Worst', 'Go to the worst contact', () => actions.worst());
    this.leads.append(lead('First', 'Go to what touches or crosses first', () => actions.first()), this.worst);
    // A click shows what it leaves out.
    this.statusText.addEventListener('click', () => {
      const whole = this.statusText.classList.toggle('whole');
      this.numbers.hidden = !whole || this.numbers.textContent === '';
    });
    this.status.append(el('span', { className: 'said' }, this.statusText, this.numbers), this.progress, this.leads);
    this.banner.append(this.bannerText, el('button', { className: 'small', type: 'button', onclick: () => location.reload() }, 'Load again'));
    const tabBar = el('div', { className: 'tabs', role: 'tablist' });
    const body = el('div', { className: 'body' });
    for (const [tab, title] of kTabs) {
      const button = el('button', { type: 'button', role: 'tab', id: `tab-${tab}`, 'aria-controls': `panel-${tab}`, onclick: () => this.open(tab) }, title);
      const panel = el('div', { role: 'tabpanel', id: `panel-${tab}`, 'aria-labelledby': `tab-${tab}`, hidden: true });
      this.tabs.set(tab, button);
      this.panels.set(tab, panel);
      tabBar.append(button);
      body.append(panel);
    }
    this.aside.append(tabBar, body);
    append(this.stage, this.loading, this.tools(), this.legend, this.card, this.verdict, this.banner);
    root.replaceChildren(el('div', { className: 'app' }, this.header(scene), this.stage, timeline(this), this.aside));
    this.open('contacts');
  }

  private header(scene: SceneInfo): HTMLElement {
    const title = el('span', { className: 'title', title: scene.title }, scene.title);
    return el(
      'header',
      {},
      el('h1', { title: `${scene.program} ${scene.version}` }, 'Foldproof'),
      title,
      this.status,
      el('div', { className: 'buttons' }, themeButton(), el('button', { className: 'quiet', type: 'button', title: 'Keys and help (?)', 'aria-label': 'Keys and help', onclick: () => this.actions.help() }, el('b', {}, '?'))),
    );
  }

  private tools(): HTMLElement {
    const tool = this.tool.bind(this);
    return el(
      'div',
      { className: 'tools' },
      tool(icon('M4 4h6v2H6v4H4zm10 0h6v6h-2V6h-4zM4 14h2v4h4v2H4zm14 0h2v6h-6v-2h4z'), 'See everything (R)', () => this.actions.reset()),
      tool('Front', 'From the front (1)', () => this.actions.side('front')),
      tool('Side', 'From the side (2)', () => this.actions.side('right')),
      tool('Top', 'From the top (3)', () => this.actions.side('top')),
      tool('+', 'Nearer (+)', () => this.actions.zoom(0.8)),
      tool('−', 'Farther (−)', () => this.actions.zoom(1.25)),
      tool('Legend', 'Legend (L)', () => this.actions.legend()),
      tool(icon('M4 7h4l1.5-2h5L16 7h4v12H4zm8 2.5a3.5 3.5 0 1 0 0 7 3.5 3.5 0 0 0 0-7z'), 'Save the picture (PNG)', () => this.actions.picture()),
    );
  }

  private tool(text: Node | string, title: string, action: () => void): HTMLButtonElement {
    return el('button', { type: 'button', title, 'aria-label': title, onclick: action }, text);
  }

  /** The first frame is shown. */
  loaded(): void {
    this.loading.hidden = true;
  }

  /** Whether there is a worst contact, and a first thing, to go to. */
  lead(contacts: boolean, any: boolean): void {
    this.leads.hidden = !any;
    this.worst.disabled = !contacts;
  }

  fill(tab: Tab, content: HTMLElement): void {
    this.panels.get(tab)!.replaceChildren(content);
  }

  /** Shows why a tab has no content. */
  refuse(tab: Tab, why: string): void {
    this.fill(tab, el('div', { className: 'panel' }, el('p', { className: 'note' }, why)));
  }

  open(tab: Tab): void {
    this.tab = tab;
    for (const [name, panel] of this.panels) panel.hidden = name !== tab;
    for (const [name, button] of this.tabs) button.setAttribute('aria-selected', String(name === tab));
    this.onTab(tab);
  }

  get openTab(): Tab {
    return this.tab;
  }

  /** `numbers`: what a click on the text adds. */
  say({ text, kind }: Verdict, numbers: string, share: number | null): void {
    setText(this.statusText, text);
    setText(this.numbers, numbers);
    this.statusText.title = [text, numbers].filter(Boolean).join('. ');
    this.status.dataset['kind'] = kind;
    this.progress.hidden = share === null;
    if (share !== null) this.progress.value = share;
  }

  /** Shows an error with a remedy; an empty text hides it. */
  warn(text: string): void {
    setText(this.bannerText, text);
    this.banner.hidden = text === '';
  }
}
