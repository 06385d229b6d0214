// Repair: what may move, how far it is, before and after, what remains, and saving.
import { groupsOf, namesText, type Contact } from '../shared/contact';
import { counted } from '../shared/format';
import { el, setText } from '../shared/dom';
import type { Answer } from '../shared/verdict';
import { ApiError, getBlob, getJson, onRepairProgress, type SceneInfo } from './api';
import { nameOf, save } from './capture';
import { framesText, type Contacts } from './contacts';
import { paintTools } from './painttools';
import type { Painting } from './painting';

const kPollMs = 300;
const kSearched = 12; // parts
const kRemaining = 4; // that are listed

interface RepairedFrame {
  time: number;
  correction: number; // mesh units
  late: boolean;
  limit: string;
}

interface RepairAnswer {
  state: 'idle' | 'queued' | 'running' | 'done' | 'failed';
  progress: number;
  error: string;
  verdict?: Answer;
  frames?: RepairedFrame[];
  files?: { object: number; name: string }[]; // of what was moved
  remaining?: unknown[];
  left?: unknown[]; // of those that were not chosen
}

/** How the verdict of a repair is colored: not at all where contacts were left on purpose. */
export const kindShown = ({ kind }: Answer): string => ({ free: 'inside', found: 'outside', limited: '' })[kind];

export interface RepairActions {
  changed: () => void; // there is a result, or there is none any more
  show: (after: boolean) => void;
  goTo: (contact: Contact) => void; // one that remains
  redraw: () => void;
  failed: (error: unknown) => void;
}

/** Contacts of the same two parts, by the first of them in the list. */
export interface Chosen {
  index: number;
  title: string;
}

export class RepairPanel {
  readonly element = el('section', { className: 'repair', hidden: true, 'aria-label': 'Repair' });
  /** Each repair has another. */
  version = 0;
  /** What still touches after it, the worst first. */
  remaining: Contact[] = [];
  private readonly open = el('button', { className: 'small', type: 'button' });
  private readonly choose = el('button', { className: 'small', type: 'button' });
  private readonly chosenOnly = el('p', { className: 'note' });
  private readonly form = el('div', { className: 'form', hidden: true });
  private readonly movable: HTMLInputElement[];
  private readonly still: HTMLInputElement[]; // parts
  private only: Chosen | null = null;
  private readonly bar = el('progress', { max: 1 });
  private readonly running = el('div', { className: 'row', hidden: true });
  private readonly result = el('div', { hidden: true });
  private readonly said = el('p', { className: 'verdict', role: 'status' });
  private readonly sides: Record<'before' | 'after', HTMLButtonElement>;
  private readonly saving = el('div', { className: 'row' });
  private readonly list = el('div', { className: 'remaining' });
  private answer: RepairAnswer | null = null;

  constructor(
    private readonly scene: SceneInfo,
    private readonly contacts: Contacts,
    private readonly painting: Painting,
    private readonly actions: RepairActions,
  ) {
    this.movable = scene.objects.map(() => el('input', { type: 'checkbox', checked: true }));
    this.still = scene.parts.map(() => el('input', { type: 'checkbox' }));
    const button = (text: string, action: () => void, properties = {}) => el('button', { className: 'small', type: 'button', onclick: action, ...properties }, text);
    this.name('Repair');
    this.open.addEventListener('click', () => this.begin(null));
    this.choose.addEventListener('click', () => this.showForm(true));
    this.form.append(
      this.chosenOnly,
      ...(this.asks ? [el('p', { className: 'note' }, 'Ticked objects may move; the others stay as they are.'), ...scene.objects.map(({ name }, i) => line(this.movable[i]!, fileOf(name)))] : []),
      ...(scene.parts.length > 0 ? [this.partsList()] : []),
      paintTools(painting),
      el('div', { className: 'row' }, button('Repair', () => void this.start()), button('Cancel', () => this.showForm(false))),
    );
    this.running.append(this.bar, button('Cancel', () => void this.ask('repair/cancel'), { hidden: !scene.cancels }));
    const side = (name: 'before' | 'after', text: string) => button(text, () => actions.show(name === 'after'), { title: 'F shows one or the other' });
    this.sides = { before: side('before', 'Before'), after: side('after', 'After') };
    this.result.append(this.said, el('div', { className: 'row', role: 'group', 'aria-label': 'What is shown' }, this.sides.before, this.sides.after), this.saving, this.list);
    this.element.append(el('div', { className: 'row' }, this.open, this.choose), this.form, this.running, this.result);
    this.showForm(false);
    onRepairProgress((share) => (this.bar.value = share));
  }

  /** Whether there is a repaired motion that is not the one before. */
  get repaired(): boolean {
    return this.answer?.state === 'done' && (this.answer.files?.length ?? 0) > 0;
  }

  get verdict(): Answer | null {
    return this.repaired ? this.answer!.verdict! : null;
  }

  /** How far each frame was moved; empty without a result. */
  get corrections(): number[] {
    return this.repaired ? this.answer!.frames!.map(({ correction }) => correction) : [];
  }

  /** Offers a repair once there is something to repair. */
  offer(contacts: number): void {
    this.element.hidden = contacts === 0 && this.answer === null;
  }

  showSide(after: boolean): void {
    this.sides.before.setAttribute('aria-pressed', String(!after));
    this.sides.after.setAttribute('aria-pressed', String(after));
  }

  /** With several objects a form comes first. */
  private get asks(): boolean {
    return this.scene.objects.length > 1;
  }

  private name(text: string): void {
    setText(this.open, this.asks ? `${text}…` : text);
  }

  private partsList(): HTMLElement {
    const { objects, parts } = this.scene;
    const several = new Set(parts.map(({ object }) => object)).size > 1;
    const lines = parts.map(({ object, name }, i) => line(this.still[i]!, name, several ? fileOf(objects[object]!.name) : ''));
    const count = el('span', {});
    const counts = () => setText(count, this.still.some(({ checked }) => checked) ? ` (${this.still.filter(({ checked }) => checked).length})` : '');
    const search = el('input', { type: 'search', placeholder: 'Search', 'aria-label': 'Search parts', hidden: lines.length < kSearched });
    search.addEventListener('input', () => lines.forEach((each) => (each.hidden = !each.textContent!.toLowerCase().includes(search.value.toLowerCase()))));
    const list = el('details', { className: 'parts', open: !this.asks }, el('summary', {}, 'Parts that stay as they are', count), search, el('div', { className: 'list' }, ...lines));
    list.addEventListener('change', counts);
    return list;
  }

  private showForm(shown: boolean): void {
    this.form.hidden = !shown;
    this.open.hidden = shown;
    this.choose.hidden = shown || this.asks;
    const still = this.still.filter(({ checked }) => checked).length;
    const { count } = this.painting;
    const stays = [still > 0 && counted(still, 'part'), count > 0 && counted(count, 'vertex', 'vertices')].filter(Boolean);
    setText(this.choose, stays.length > 0 ? `${stays.join(' and ')} ${still + count === 1 ? 'stays' : 'stay'}…` : 'What may move…');
    this.painting.change(shown ? { shown } : { shown, active: false });
    this.chosenOnly.hidden = this.only === null;
    setText(this.chosenOnly, this.only ? `Only this is repaired: ${this.only.title}. Other contacts stay.` : '');
  }

  /** Repairs everything, or contacts alone. */
  begin(only: Chosen | null): void {
    this.only = only;
    if (!this.asks) return void this.start();
    this.showForm(true);
    this.element.scrollIntoView({ block: 'nearest' });
  }

  private async start(): Promise<void> {
    const fixed = this.movable.flatMap(({ checked }, i) => (checked ? [] : [i]));
    const parts = this.still.flatMap(({ checked }, i) => (checked ? [i] : []));
    await this.ask(`repair/start?fixed=${fixed.join()}&parts=${parts.join()}&vertices=${this.painting.text()}${this.only ? `&contact=${this.only.index}` : ''}`);
  }

  /** Asks until the repair has ended. */
  private async ask(path: string): Promise<void> {
    try {
      this.show(await getJson<RepairAnswer>(path));
    } catch (error) {
      this.actions.failed(error);
      if (error instanceof ApiError) this.show({ state: 'failed', progress: 0, error: error.message });
      return;
    }
    if (path !== 'repair/cancel' && this.busy) setTimeout(() => void this.ask('repair'), kPollMs);
  }

  private get busy(): boolean {
    return this.answer?.state === 'queued' || this.answer?.state === 'running';
  }

  private show(answer: RepairAnswer): void {
    const had = this.repaired;
    const { state } = (this.answer = answer);
    this.running.hidden = !this.busy;
    this.showForm(false);
    this.open.hidden = this.busy;
    this.choose.hidden ||= this.busy;
    this.name(state === 'done' || state === 'failed' ? 'Repair again' : 'Repair');
    if (answer.progress > 0) this.bar.value = answer.progress;
    else this.bar.removeAttribute('value');
    this.result.hidden = state !== 'done' && state !== 'failed';
    setText(this.said, state === 'failed' ? answer.error : (answer.verdict?.text ?? ''));
    this.said.dataset['kind'] = answer.verdict ? kindShown(answer.verdict) : 'outside';
    for (const button of Object.values(this.sides)) button.hidden = !this.repaired;
    const moved = counted(this.corrections.filter((correction) => correction > 0).length, 'frame');
    this.saving.replaceChildren(...(this.repaired ? answer.files! : []).map(({ object, name }) => this.saveButton(`Save ${name}`, `${moved} moved`, `objects/${object}/repaired/file`, name)));
    if (state === 'done') this.saving.append(this.saveButton('Save report', 'What was done, as one HTML file', 'repair/report', nameOf(this.scene.title, '-repair.html')));
    void this.listRemaining();
    if (this.repaired === had) return;
    ++this.version;
    this.actions.changed();
    this.actions.show(this.repaired);
  }

  /** What still touches, by the same two parts. */
  private async listRemaining(): Promise<void> {
    const { answer } = this;
    this.remaining = [];
    this.list.replaceChildren();
    if (!this.repaired || (answer!.remaining!.length === 0 && answer!.left!.length === 0)) return;
    let items: Contact[];
    try {
      ({ items } = await getJson<{ items: Contact[] }>('repair/contacts'));
    } catch (error) {
      return this.actions.failed(error);
    }
    if (this.answer !== answer) return; // Another repair began meanwhile.
    this.remaining = items;
    const worst = groupsOf(items).map(({ contacts }) => contacts[0]!);
    const button = (contact: Contact) =>
      el('button', { className: 'small', type: 'button', title: 'Go there', onclick: () => this.actions.goTo(contact) }, `${namesText(contact)}: ${this.contacts.sizeText(contact)}, ${framesText(contact)}`);
    this.list.append(el('p', { className: 'note' }, 'What still touches, red and blue in After:'), ...worst.slice(0, kRemaining).map(button));
    if (worst.length > kRemaining) this.list.append(el('p', { className: 'note' }, `And ${worst.length - kRemaining} more, in the report.`));
    this.actions.redraw();
  }

  private saveButton(text: string, title: string, path: string, name: string): HTMLElement {
    const button = el('button', { className: 'small', type: 'button', title }, text);
    button.addEventListener('click', async () => {
      button.disabled = true;
      try {
        save(await getBlob(path), name);
      } catch (error) {
        this.actions.failed(error);
      }
      button.disabled = false;
    });
    return button;
  }
}

const fileOf = (path: string): string => path.replace(/^.*[\\/]/, '');

const line = (box: HTMLInputElement, name: string, owner = ''): HTMLElement =>
  el('label', { className: 'line' }, box, el('span', { title: name }, name, owner !== '' && el('small', {}, ` ${owner}`)));
