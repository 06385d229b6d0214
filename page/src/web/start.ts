// What is seen before a motion is open: where to drop it.
import sample from 'foldproof-sample?inline';
import { el } from '../shared/dom';
import { themeButton } from '../shared/theme';
import { kReadable } from './arguments';
import { chosen, dropped } from './dropped';
import type { InputFile, Settings } from './messages';

/** The sample is a part of the script, since the page loads nothing. */
function sampleFile(): InputFile {
  const bytes = Uint8Array.from(atob(sample.slice(sample.indexOf(',') + 1)), (c) => c.charCodeAt(0));
  return { path: 'walk.glb', blob: new Blob([bytes]) };
}

export class StartPage {
  private readonly files = el('input', { type: 'file', multiple: true, hidden: true, accept: [...kReadable, '.bin'].join() });
  private readonly folder = el('input', { type: 'file', multiple: true, hidden: true, webkitdirectory: true });
  private readonly thickness = el('input', { type: 'number', required: true, min: '0', step: 'any', value: '0', id: 'thickness' });
  private readonly substeps = el('input', { type: 'number', required: true, min: '1', max: '1000', value: '1', id: 'substeps' });
  private readonly poses = el('input', { type: 'checkbox', id: 'poses' });
  private readonly fps = el('input', { type: 'number', required: true, min: '1', max: '1000', value: '24', id: 'fps' });
  private readonly seams = el('select', { id: 'seams' }, ...[['by_format', 'As the format says'], ['always', 'Merge all at one place'], ['never', 'Merge none']].map(([value = '', text = '']) => el('option', { value }, text)));
  private readonly clip = el('input', { type: 'text', id: 'clip' });
  private readonly meshes = el(
    'select',
    { id: 'meshes' },
    el('option', { value: 'names' }, 'frames if numbered'),
    el('option', { value: 'sequence' }, 'frames (--sequence)'),
    el('option', { value: 'separate' }, 'bodies (--separate)'),
  );
  private readonly alert = el('p', { className: 'alert', role: 'alert', hidden: true });
  private readonly zone: HTMLElement;
  readonly element: HTMLElement;

  constructor(private readonly open: (files: InputFile[], settings: Settings) => void) {
    const button = (text: string, action: () => void, className = '') => el('button', { type: 'button', className, onclick: action }, text);
    for (const input of [this.files, this.folder]) {
      input.addEventListener('change', () => {
        const files = chosen(input.files ?? []);
        input.value = ''; // so that the same file can be chosen again
        this.take(files);
      });
    }
    this.zone = el(
      'section',
      { className: 'zone' },
      el('p', { className: 'call' }, 'Drop a motion here'),
      el('p', {}, 'A GLB, an NPZ, a mesh with its PC2 or MDD cache, a folder of meshes, a single pose; several of them are several objects.'),
      el('div', { className: 'choices' }, button('Choose files', () => this.files.click(), 'main'), button('Choose a folder', () => this.folder.click()), button('Try the sample', () => this.take([sampleFile()]))),
    );
    this.element = el(
      'div',
      { className: 'start' },
      el('header', {}, el('h1', {}, 'Foldproof'), el('div', { className: 'buttons' }, themeButton())),
      el('h2', {}, 'Does anything go through anything, at any time?'),
      el('p', { className: 'lead' }, 'Foldproof finds every collision of deforming triangle meshes, between frames too, or proves that there is none. It runs in this page: your files stay on this machine.'),
      this.zone,
      this.alert,
      this.options(),
      el('p', { className: 'note' }, 'Big motions are checked several times faster by the program and its library, which read more formats and use all cores.'),
      this.files,
      this.folder,
    );
    this.element.addEventListener('dragover', (event) => {
      event.preventDefault();
      this.zone.classList.add('over');
    });
    this.element.addEventListener('dragleave', () => this.zone.classList.remove('over'));
    this.element.addEventListener('drop', (event) => {
      event.preventDefault();
      this.zone.classList.remove('over');
      if (event.dataTransfer) void dropped(event.dataTransfer).then((files) => this.take(files), (error: unknown) => this.warn(String(error)));
    });
  }

  private options(): HTMLElement {
    // Both are about the ways between frames.
    this.poses.addEventListener('change', () => {
      for (const input of [this.thickness, this.substeps]) input.disabled = this.poses.checked;
    });
    const row = (input: HTMLInputElement | HTMLSelectElement, text: string, note: string) => el('label', { htmlFor: input.id }, el('span', {}, text), input, el('small', {}, note));
    return el(
      'details',
      {},
      el('summary', {}, 'Options'),
      row(this.thickness, 'Thickness', 'A distance up to this is a collision, in mesh units'),
      row(this.substeps, 'Parts of a step', 'Straight parts that each step between two frames is divided into'),
      row(this.poses, 'Poses', 'The frames are single poses, not a motion: find what crosses in each'),
      row(this.meshes, 'Several meshes', 'Frames of one motion, or bodies'),
      row(this.fps, 'Frames per second', 'How glTF animations are sampled'),
      row(this.seams, 'Seams', 'Which vertices at one place are one; without a choice those of glTF and STL'),
      row(this.clip, 'Clip', 'The name of the glTF animation; the longest if empty'),
    );
  }

  private take(files: InputFile[]): void {
    const poses = this.poses.checked;
    for (const input of [this.thickness, this.substeps, this.fps]) if (!input.reportValidity()) return;
    if (files.length > 0) this.open(files, { thickness: poses ? 0 : this.thickness.valueAsNumber, substeps: poses ? 1 : this.substeps.valueAsNumber, static: poses, fps: this.fps.valueAsNumber, seams: this.seams.value as Settings['seams'], clip: this.clip.value.trim(), meshes: this.meshes.value });
  }

  warn(text: string): void {
    this.alert.textContent = text;
    this.alert.hidden = text === '';
  }
}
