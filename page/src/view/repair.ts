// Repair: what may move, how far it is, before and after, and saving.
import { counted } from '../shared/format';
import { el, setText } from '../shared/dom';
import type { Answer } from '../shared/verdict';
import { ApiError, getBlob, getJson, onRepairProgress, type SceneInfo } from './api';
import { save } from './capture';

const kPollMs = 300;

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
  files?: { object: number; name: string }[]; // empty where nothing was changed
}

export interface RepairActions {
  changed: () => void; // there is a result, or there is none any more
  show: (after: boolean) => void;
  failed: (error: unknown) => void;
}

export class RepairPanel {
  readonly element = el('section', { className: 'repair', hidden: true, 'aria-label': 'Repair' });
  /** Each repair has another. */
  version = 0;
  private readonly open = el('button', { className: 'small', type: 'button' });
  private readonly form = el('div', { className: 'form', hidden: true });
  private readonly movable: HTMLInputElement[];
  private readonly bar = el('progress', { max: 1 });
  private readonly running = el('div', { className: 'row', hidden: true });
  private readonly result = el('div', { hidden: true });
  private readonly said = el('p', { className: 'verdict', role: 'status' });
  private readonly sides: Record<'before' | 'after', HTMLButtonElement>;
  private readonly saving = el('div', { className: 'row' });
  private answer: RepairAnswer | null = null;

  constructor(
    private readonly scene: SceneInfo,
    private readonly actions: RepairActions,
  ) {
    this.movable = scene.objects.map(() => el('input', { type: 'checkbox', checked: true }));
    const button = (text: string, action: () => void, properties = {}) => el('button', { className: 'small', type: 'button', onclick: action, ...properties }, text);
    this.name('Repair');
    this.open.addEventListener('click', () => this.begin());
    this.form.append(
      el('p', { className: 'note' }, 'Ticked objects may move; the others stay as they are.'),
      ...scene.objects.map(({ name }, i) => el('label', { className: 'line' }, this.movable[i]!, el('span', { title: name }, name.replace(/^.*[\\/]/, '')))),
      el('div', { className: 'row' }, button('Repair', () => void this.start()), button('Cancel', () => this.showForm(false))),
    );
    this.running.append(this.bar, button('Cancel', () => void this.ask('repair/cancel'), { hidden: !scene.cancels }));
    const side = (name: 'before' | 'after', text: string) => button(text, () => actions.show(name === 'after'), { title: 'F shows one or the other' });
    this.sides = { before: side('before', 'Before'), after: side('after', 'After') };
    this.result.append(this.said, el('div', { className: 'row', role: 'group', 'aria-label': 'What is shown' }, this.sides.before, this.sides.after), this.saving);
    this.element.append(this.open, this.form, this.running, this.result);
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
  private name(text: string): void {
    setText(this.open, this.scene.objects.length > 1 ? `${text}…` : text);
  }

  private showForm(shown: boolean): void {
    this.form.hidden = !shown;
    this.open.hidden = shown;
  }

  private begin(): void {
    if (this.scene.objects.length > 1) this.showForm(true);
    else void this.start();
  }

  private async start(): Promise<void> {
    const fixed = this.movable.flatMap(({ checked }, i) => (checked ? [] : [i]));
    await this.ask(`repair/start?fixed=${fixed.join()}`);
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
    this.form.hidden = true;
    this.open.hidden = this.busy;
    this.name(state === 'done' || state === 'failed' ? 'Repair again' : 'Repair');
    if (answer.progress > 0) this.bar.value = answer.progress;
    else this.bar.removeAttribute('value');
    this.result.hidden = state !== 'done' && state !== 'failed';
    setText(this.said, state === 'failed' ? answer.error : (answer.verdict?.text ?? ''));
    this.said.dataset['kind'] = answer.verdict?.kind === 'free' ? 'inside' : 'outside';
    for (const button of Object.values(this.sides)) button.hidden = !this.repaired;
    this.saving.replaceChildren(...(this.repaired ? answer.files!.map(({ object, name }) => this.saveButton(object, name)) : []));
    if (this.repaired === had) return;
    ++this.version;
    this.actions.changed();
    this.actions.show(this.repaired);
  }

  private saveButton(object: number, name: string): HTMLElement {
    const moved = this.corrections.filter((correction) => correction > 0).length;
    const button = el('button', { className: 'small', type: 'button', title: `${counted(moved, 'frame')} moved` }, `Save ${name}`);
    button.addEventListener('click', async () => {
      button.disabled = true;
      try {
        save(await getBlob(`objects/${object}/repaired/file`), name);
      } catch (error) {
        this.actions.failed(error);
      }
      button.disabled = false;
    });
    return button;
  }
}
