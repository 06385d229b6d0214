// Connects all parts of the page. Every picture starts in tick().
import * as THREE from 'three';
import { Charts } from '../shared/charts';
import { el, setText } from '../shared/dom';
import { collisionsOf, spanOf } from '../shared/steps';
import { isDark, onTheme } from '../shared/theme';
import { guessUp, type Vector } from '../shared/upright';
import { startText } from '../shared/verdict';
import { ApiError, getIndices, GoneError, type SceneInfo } from './api';
import { savePicture } from './capture';
import { Check, kStart, PairStore } from './check';
import { Clock } from './clock';
import { CollisionPanel } from './collisions';
import { ContactPanel } from './contactpanel';
import { Contacts } from './contacts';
import { Content } from './content';
import { Data } from './data';
import { helpDialog } from './help';
import { HoverCard } from './hovercard';
import { Inspector } from './inspect';
import { keyActions, listen } from './keyboard';
import { LayerPanel } from './layers';
import { Layout, type Tab } from './layout';
import { legendItems } from './legend';
import { Navigator, type Parts } from './navigator';
import { Brush, Painting } from './painting';
import { RepairPanel } from './repair';
import { Repaired } from './repaired';
import { ShapePanel } from './shapes';
import { Stage } from './stage';
import { Timeline } from './timeline';
import { Track } from './track';
import { readUrl, writeUrl, type UrlState } from './urlstate';
import { ViewOptions } from './viewoptions';

const kAllPairsMs = 150; // How long a step is shown before all of its pairs are listed.
const kChartHeight = 150;

export class App {
  private readonly clock: Clock;
  private readonly layout: Layout;
  private readonly layers: LayerPanel;
  private readonly options: ViewOptions;
  private readonly check: Check;
  private readonly pairs: PairStore;
  private readonly contacts: Contacts;
  private readonly data: Data;
  private readonly track: Track;
  private readonly timeline: Timeline;
  private readonly hover: HoverCard;
  private readonly collisions: CollisionPanel;
  private readonly painting: Painting;
  private readonly repair: RepairPanel;
  private readonly repaired: Repaired;
  private readonly cards: ContactPanel;
  private readonly charts: Charts;
  private readonly stage: Stage;
  private readonly navigator: Navigator;
  private readonly help: HTMLDialogElement;
  private readonly motionBox: THREE.Box3; // of the whole motion, in the scene
  private readonly link: UrlState = readUrl();
  private content: Content | null = null; // null before the triangles are loaded
  private shapes: ShapePanel | null = null;
  private shapeObject = -1;
  private inspector: Inspector | null = null;

  private dirty = true;
  private last = 0;
  private waiting = false;
  private shaping = false; // the tab of the model's shapes is open
  private framed = false; // and its shape is in the picture
  private followed: THREE.Vector3 | null = null;
  private shownStep = -1;
  private stepSince = 0;
  private legendKey = '';
  private chartsDirty = true;
  private readonly spent = { script: 0, drawing: 0, pictures: 0, started: performance.now(), firstPicture: 0 };

  constructor(
    root: HTMLElement,
    private readonly scene: SceneInfo,
  ) {
    const failed = (error: unknown) => this.fail(error);
    const changed = () => (this.dirty = true);
    this.clock = new Clock(scene);
    this.check = new Check(scene, (from) => this.checked(from), failed);
    this.help = helpDialog(this.check.poses);
    this.pairs = new PairStore(changed, failed);
    this.contacts = new Contacts(scene, () => this.contactsKnown(), failed);
    this.layers = new LayerPanel(scene, changed);
    const size = scene.high.map((high, k) => high - scene.low[k]!) as [number, number, number];
    this.options = new ViewOptions(this.link.up ?? 'y', (turned) => this.optionsChanged(turned));
    this.data = new Data(scene, this.check, () => this.layers.state, changed, failed);
    this.track = new Track(scene, this.clock, this.check, this.contacts, {
      seek: (position) => this.navigator.goTo(() => this.clock.seekPosition(position), true),
      choose: (index) => void this.navigator.chooseContact(index),
      hover: (position, x, lane) => this.hover.show(position, x, this.track.element.clientWidth, lane),
      leave: () => this.hover.hide(),
    });
    this.hover = new HoverCard(scene, this.check, this.contacts, (position, width, height) => this.thumbnail(position, width, height));
    this.timeline = new Timeline(scene, this.clock, this.check, this.track, this.hover, {
      play: () => this.navigator.play(!this.clock.playing),
      move: (by) => this.navigator.goTo(() => this.clock.move(by)),
      seekPosition: (position) => this.navigator.goTo(() => this.clock.seekPosition(position), true),
      seekTime: (t) => this.navigator.goTo(() => this.clock.seek(this.clock.step, t)),
      collision: (direction) => this.navigator.nextCollision(direction),
    });
    this.collisions = new CollisionPanel(scene, this.check, (pair) => this.navigator.choose(pair), (direction) => this.navigator.nextCollision(direction), () => this.navigator.goTo(() => this.clock.seek(0)));
    this.painting = new Painting(scene);
    this.painting.onChange(changed);
    this.repair = new RepairPanel(scene, this.contacts, this.painting, { changed: () => this.repaired.changed(), show: (after) => this.repaired.show(after), goTo: (contact) => this.repaired.goTo(contact), redraw: changed, failed });
    this.cards = new ContactPanel(scene, this.check, this.contacts, (index) => void this.navigator.chooseContact(index), this.repair);
    this.charts = this.makeCharts();
    this.layout = new Layout(root, scene, () => this.timeline.element, this.tools());
    root.append(this.help);
    const scale = 2 / Math.max(...size, 1e-30);
    this.motionBox = this.boxOf(scene.low, scene.high, scale);
    this.stage = new Stage(this.layout.stage, scale, () => this.bounds(), () => this.poseBounds() ?? this.bounds());
    this.layout.stage.append(this.stage.gizmo.element);
    this.navigator = new Navigator(this.parts(), changed, failed);
    this.repaired = new Repaired(this.repair, this.layers, this.data, this.navigator, this.parts(), changed);
    this.optionsChanged(true);
    if (this.link.at !== null) this.clock.seekPosition(this.link.at);
    if (this.link.camera) this.stage.camera.place(new THREE.Vector3(...(this.link.camera.slice(0, 3) as [number, number, number])), new THREE.Vector3(...(this.link.camera.slice(3) as [number, number, number])));
    this.navigator.touched = this.link.at !== null || this.link.camera !== null;
  }

  async start(): Promise<void> {
    this.fillPanels();
    listen(keyActions({ ...this.parts(), navigator: this.navigator, layers: this.layers, options: this.options, help: this.help, beforeOrAfter: () => this.repaired.show(!this.repaired.shown), leave: () => this.leave() }));
    this.check.startPolling();
    this.data.frames.prefetch(this.clock.frame);
    onTheme(() => this.restyle());
    this.restyle();
    const triangles = await Promise.all(this.scene.objects.map((_, i) => getIndices(`objects/${i}/triangles`)));
    this.content = this.navigator.content = new Content(this.scene, this.stage, this.data, triangles);
    this.inspector = new Inspector(this.stage, this.content.surfaces, this.scene, this.layout.card, (point, size) => this.stage.camera.approach(point.multiplyScalar(this.stage.scale), 5 * size * this.stage.scale));
    new Brush(this.stage, this.content.surfaces, this.painting);
    this.navigator.onDeselect = () => this.inspector?.close();
    this.beginAtContact();
    this.restyle();
    Object.defineProperty(window, 'foldproof', { value: { state: () => this.report() } });
    requestAnimationFrame((now) => this.loop(now));
  }

  private makeCharts(): Charts {
    const { frame_numbers: numbers, substeps } = this.scene;
    const stride = (numbers[1] ?? 1) - (numbers[0] ?? 0);
    const margin = this.clock.still ? stride / 2 : 0;
    return new Charts({
      poses: this.check.poses,
      spanOf: (step) => spanOf(step, substeps, stride),
      low: (numbers[0] ?? 0) - margin,
      high: (numbers.at(-1) ?? 1) + margin,
      height: kChartHeight,
      seek: (step) => this.navigator.goTo(() => this.clock.seek(step)),
    });
  }

  private parts(): Parts {
    const { clock, check, contacts, collisions, cards, layout, stage, timeline, track } = this;
    return { clock, check, contacts, collisions, cards, layout, stage, timeline, track };
  }

  private tools() {
    return {
      reset: () => this.navigator.showAll(),
      side: (side: 'front' | 'right' | 'top') => this.stage.camera.side(side),
      zoom: (factor: number) => this.stage.camera.zoom(factor),
      legend: () => this.layout.legend.classList.toggle('closed'),
      help: () => this.help.showModal(),
      picture: () => void savePicture(this.stage.png(), this.scene.title, this.frameName()),
      first: () => this.navigator.goToFirst(),
      worst: () => void this.navigator.chooseContact(0),
    };
  }

  private fillPanels(): void {
    const { layout, scene } = this;
    layout.fill('contacts', this.cards.element);
    layout.fill('collisions', this.collisions.element);
    this.layers.element.append(this.options.element);
    layout.fill('layers', this.layers.element);
    layout.fill('charts', el('div', { className: 'panel' }, this.charts.element));
    if (this.clock.frames === 1) layout.refuse('charts', 'A single frame has no charts.');
    this.shapeObject = scene.objects.findIndex((object) => (object.model?.modes ?? 0) > 0);
    const object = scene.objects[this.shapeObject];
    if (object) {
      this.shapes = new ShapePanel(object, this.shapeObject, () => (this.dirty = true), (error) => this.fail(error));
      layout.fill('shapes', this.shapes.element);
    } else {
      const any = scene.objects.some(({ model }) => model);
      layout.refuse('shapes', any ? 'The model has learned no shapes: train it on more poses (foldproof train POSES... -o body.model).' : 'Shapes come from a model. Make one with foldproof train POSES... -o body.model and start with --model body.model.');
    }
    layout.onTab = (tab: Tab) => {
      const left = this.shaping && tab !== 'shapes';
      if (this.shaping !== (tab === 'shapes')) this.navigator.deselect(); // also what a shape marks
      this.shaping = tab === 'shapes';
      this.framed = false;
      if (left) this.stage.camera.showAll();
      if (this.shaping) this.shapes?.open();
      this.chartsDirty = true;
      this.dirty = true;
    };
  }

  // --- Actions

  private leave(): void {
    if (this.painting.active) this.painting.change({ active: false });
    else this.navigator.deselect();
  }

  private frameName(): string {
    return `frame_${Number(this.clock.position.toFixed(2))}`;
  }

  private optionsChanged(turned: boolean): void {
    const { state } = this.options;
    const { stage } = this;
    if (turned) {
      stage.camera.setUp(state.up);
      stage.camera.showAll(false);
    }
    stage.ground.grid.visible = state.ground;
    stage.ground.place(this.motionBox, stage.camera.up);
    this.followed = null;
    const axis = 'xyz'.indexOf(state.cut || '-');
    const plane = new THREE.Vector3();
    if (axis >= 0) plane.setComponent(axis, state.cutTurned ? -1 : 1);
    const at = axis < 0 ? 1 : this.motionBox.min.getComponent(axis) + state.cutAt * (this.motionBox.max.getComponent(axis) - this.motionBox.min.getComponent(axis));
    stage.focusUniforms.clip.value.set(plane.x, plane.y, plane.z, axis < 0 ? 1 : state.cutTurned ? -at : at);
    this.dirty = true;
    stage.redraw();
  }

  // --- What the camera sees

  private boxOf(low: number[], high: number[], scale: number): THREE.Box3 {
    const at = (point: number[]) => new THREE.Vector3(...(point.map((value, k) => (value - this.scene.center[k]!) * scale) as [number, number, number]));
    return new THREE.Box3(at(low), at(high));
  }

  private poseBounds(): THREE.Box3 | null {
    return this.content?.visible ? this.content.bounds() : null;
  }

  /** The whole motion as far as it is known; of a shape of the model, or with a camera that follows, what is shown. */
  private bounds(): THREE.Box3 {
    const own = this.shaping || this.options?.state.follow;
    const shown = own ? this.poseBounds() : null;
    return shown && !shown.isEmpty() ? shown : this.motionBox;
  }

  /** Takes in the steps from this one on. */
  private grow(from: number): void {
    const box = this.motionBox.clone();
    for (const { low, high } of this.check.bounds.slice(from)) box.union(this.boxOf(low, high, this.stage.scale));
    if (this.motionBox.containsBox(box)) return;
    this.motionBox.copy(box);
    this.stage.ground.place(this.motionBox, this.stage.camera.up);
    if (!this.stage.camera.moved) this.stage.camera.showAll(false);
  }

  private follow(content: Content): void {
    if (!this.options.state.follow) return;
    const middle = content.middle();
    if (this.followed) this.stage.camera.shift(middle.clone().sub(this.followed));
    this.followed = middle;
  }

  /** A small picture of another frame; null if it is not loaded. */
  private thumbnail(position: number, width: number, height: number): ImageData | null {
    const { content } = this;
    if (!content || this.clock.playing || this.shaping) return null;
    const there = new Clock(this.scene);
    there.seekPosition(position);
    if (!content.showFrame(there, this.layers.state)) return null;
    const image = this.stage.thumbnail(width, height);
    content.showFrame(this.clock, this.layers.state);
    return image;
  }

  // --- Answers

  private checked(from: number): void {
    const { check } = this;
    if (check.steps.length > from || from === 0) this.timeline.paint();
    this.chartsDirty = true;
    this.dirty = true;
    this.grow(from);
    this.layout.warn(check.state === 'failed' ? `The check stopped: ${check.error}` : '');
    this.showVerdict();
    if (check.state === 'running' || check.state === 'gone' || this.contacts.state !== 'waiting') return;
    this.guessUp();
    void this.contacts.load();
  }

  /** All poses are known: guesses which axis is up, unless the user or the page's address says it. */
  private guessUp(): void {
    if (this.link.up !== null || this.options.turned) return;
    const up = guessUp([this.scene, ...this.check.bounds].map(({ low, high }) => ({ min: low as unknown as Vector, max: high as unknown as Vector })));
    if (up !== this.options.state.up) this.options.setUp(up);
  }

  private showVerdict(): void {
    const { check, contacts } = this;
    this.layout.say(check.verdict(), check.answer?.numbers ?? '', check.state === 'running' ? check.done / Math.max(1, check.total) : null);
    this.layout.lead(contacts.state === 'known' && contacts.total > 0, check.pairs > 0 || check.startsCrossing);
  }

  private contactsKnown(): void {
    if (!this.check.poses) this.repair.offer(this.contacts.total);
    this.showVerdict();
    this.timeline.paint();
    this.dirty = true;
    this.beginAtContact();
  }

  /** Opens the contact of the page's address, else the worst one, once both the list and the meshes are loaded. */
  private beginAtContact(): void {
    if (!this.content || this.contacts.state !== 'known') return;
    const linked = this.link.contact === null ? -1 : this.contacts.items.findIndex(({ number }) => number === this.link.contact);
    if (linked >= 0) void this.chooseLinked(linked);
    else if (!this.navigator.touched && this.contacts.items.length > 0) void this.navigator.chooseContact(0);
  }

  /** The contact of the page's address, seen as it was. */
  private async chooseLinked(index: number): Promise<void> {
    const { at, camera } = this.link;
    await this.navigator.chooseContact(index, camera === null);
    if (at !== null) this.navigator.goTo(() => this.clock.seekPosition(at));
  }

  private fail(error: unknown): void {
    if (error instanceof GoneError) this.layout.warn(`${error.message} Start foldproof view again and load this page again; what is loaded stays here.`);
    else if (error instanceof ApiError) this.layout.warn(error.message);
    else throw error;
    this.dirty = true;
  }

  private restyle(): void {
    const style = getComputedStyle(document.documentElement);
    this.stage.background(style.getPropertyValue('--stage').trim(), style.getPropertyValue('--grid').trim());
    this.content?.restyle();
    this.timeline.paint();
    this.charts.restyle();
    this.dirty = true;
  }

  // --- Every picture

  private loop(now: number): void {
    const start = performance.now();
    this.tick(now);
    const middle = performance.now();
    const drew = this.stage.draw(now);
    if (drew) {
      this.spent.script += middle - start;
      this.spent.drawing += performance.now() - middle;
      ++this.spent.pictures;
      if (this.spent.firstPicture === 0 && this.content?.visible) {
        this.spent.firstPicture = performance.now();
        this.layout.loaded();
      }
      writeUrl(() => this.linkNow());
    }
    requestAnimationFrame((next) => this.loop(next));
  }

  private tick(now: number): void {
    const { clock } = this;
    const seconds = Math.min(0.1, Math.max(0, (now - this.last) / 1000));
    this.last = now;
    // Playing waits for frames that are not loaded; none is skipped.
    if (clock.playing && !this.waiting) {
      if (!clock.advance(seconds * this.scene.fps * clock.speed)) this.navigator.play(false);
      this.dirty = true;
    }
    if (!this.dirty && !this.waiting && now - this.stepSince < kAllPairsMs) return;
    if (this.dirty || this.waiting) this.update();
    if (!clock.playing && now - this.stepSince >= kAllPairsMs) this.requestAllPairs();
  }

  private requestAllPairs(): void {
    if (this.atStart && !this.pairs.get(kStart)?.complete) return this.pairs.request(kStart, true);
    const step = this.check.steps[this.clock.step];
    if (step && collisionsOf(step) > 0 && !this.pairs.get(step.number)?.complete) this.pairs.request(step.number, true);
  }

  /** Crossings of the first frame are listed with its step. */
  private get atStart(): boolean {
    return this.check.startsCrossing && this.clock.step === 0;
  }

  private update(): void {
    const { content, clock } = this;
    this.dirty = false;
    if (clock.step !== this.shownStep) {
      this.shownStep = clock.step;
      this.stepSince = performance.now();
    }
    this.navigator.leave(clock.step);
    this.data.frames.prefetch(clock.frame);
    this.data.faces.prefetch(clock.step);
    if (!content) return;
    const shaping = this.shaping && this.shapes !== null;
    if (shaping) content.showShape(this.shapes!, this.shapeObject, this.layers.state);
    if (shaping && this.shapes!.ready && !this.framed) {
      this.framed = true;
      this.stage.camera.showAll();
    }
    this.waiting = !shaping && !content.showFrame(clock, this.layers.state);
    if (!this.waiting && !shaping) this.follow(content);
    this.showFaces(content, shaping);
    this.showMarks(content, shaping);
    if (!this.waiting) this.navigator.arrive();
    this.showText(content, shaping);
    this.stage.redraw();
  }

  private showFaces(content: Content, shaping: boolean): void {
    const needed = !shaping && !this.repaired.shown && this.data.needsFaces(this.clock.step);
    const slot = needed ? this.data.faces.get(this.clock.step) : undefined;
    if (needed && !slot && this.clock.playing) this.waiting = true;
    content.showFaces(this.clock.step, slot?.parts ?? null);
  }

  private showMarks(content: Content, shaping: boolean): void {
    const { clock } = this;
    const { state } = this.layers;
    const step = this.check.steps[clock.step];
    const colliding = step !== undefined && collisionsOf(step) > 0;
    if (this.atStart && !this.pairs.get(kStart)) this.pairs.request(kStart, false);
    else if (colliding && !this.pairs.get(clock.step)) this.pairs.request(clock.step, false);
    const marked = !shaping && !this.repaired.shown; // marks are of what was before
    content.showPoints(colliding ? this.pairs.get(clock.step) : undefined, state.contacts && marked, clock);
    content.lines.group.visible = this.navigator.chosen !== null && marked;
    if (!shaping) content.contact.mark(this.repaired.marked(content.contact.chosen));
    content.contact.show(this.navigator.contact !== null && marked, clock.position, this.navigator.contact === null ? 0 : this.navigator.worstPosition(this.navigator.contact));
    content.showKeysAndBoxes(state, clock, shaping);
  }

  private showText(content: Content, shaping: boolean): void {
    const { check, clock, scene } = this;
    this.timeline.show(this.waiting);
    this.cards.show(this.navigator.contact);
    this.collisions.show(check.steps[clock.step], this.pairs.get(clock.step), this.atStart ? this.pairs.get(kStart) : undefined);
    if (this.layout.openTab === 'charts' && clock.frames > 1) this.showCharts();
    const { verdict } = this.layout;
    if (!shaping) this.repaired.say(verdict);
    if (shaping) {
      verdict.hidden = false;
      const { text, kind } = this.shapes!.verdictText();
      setText(verdict, text);
      verdict.dataset['kind'] = kind;
    }
    this.inspector!.show(shaping ? null : this.data.faces.get(clock.step)?.parts ?? null, clock.step);
    const boxFrame = this.data.boxes ? (scene.frame_numbers[this.data.boxes.frame] ?? null) : null;
    this.showLegend(content, shaping, boxFrame);
  }

  private showCharts(): void {
    const { check, clock, scene } = this;
    if (this.chartsDirty) {
      this.charts.setSteps(check.steps);
      if (check.start && check.startsCrossing) this.charts.setStart(check.start.frame, startText(check.start));
    }
    this.chartsDirty = false;
    const first = scene.frame_numbers[clock.frame] ?? 0;
    const second = scene.frame_numbers[Math.min(clock.frame + 1, scene.frames - 1)] ?? first;
    this.charts.setNow(first + clock.blend * (second - first), clock.step);
  }

  private showLegend(content: Content, shaping: boolean, boxFrame: number | null): void {
    const { check, scene } = this;
    const layers = this.layers.state;
    const error = (layers.paint === 'correction' ? content.corrections : content.errors).at(this.clock.frame);
    const end = this.clock.t >= 0.5;
    const remaining = this.repaired.shown && this.repaired.marked(null).length > 0;
    const key = JSON.stringify([layers, end, check.free > 0, check.calm, shaping, content.shownFaces, boxFrame, this.navigator.chosen !== null, this.navigator.contact, error, this.repair.version, remaining]);
    if (key === this.legendKey) return;
    this.legendKey = key;
    const contact = this.navigator.contact === null || this.repaired.shown ? null : this.contacts.sideNames(this.contacts.items[this.navigator.contact]!);
    this.layout.legend.replaceChildren(
      ...legendItems({ layers, poses: check.poses, shapes: shaping, end, free: check.free > 0, calm: check.calm, reasons: scene.reasons, objects: scene.objects.map(({ name }) => name), counts: content.counts, boxFrame, chosen: this.navigator.chosen !== null, contact, error, repaired: this.repair.repaired, remaining }),
    );
  }

  private linkNow(): UrlState {
    const { eye, target, moved } = this.stage.camera;
    return {
      at: this.clock.position,
      contact: this.navigator.contact === null ? null : this.contacts.items[this.navigator.contact]!.number,
      up: this.options.state.up,
      camera: moved ? [...eye.position.toArray(), ...target.toArray()] : null,
    };
  }

  /** For tests and for the browser's console. */
  private report(): Record<string, unknown> {
    const { clock, spent, content } = this;
    return {
      step: clock.step,
      t: clock.t,
      position: clock.position,
      playing: clock.playing,
      waiting: this.waiting,
      camera: this.stage.camera.eye.position.toArray(),
      up: this.stage.camera.up.toArray(),
      bytes: this.data.bytes(),
      budget: this.data.budget,
      framesAhead: this.data.frames.ahead(clock.frame),
      steps: this.check.steps.length,
      state: this.check.state,
      contacts: this.contacts.state === 'known' ? this.contacts.items.length : null,
      contact: this.navigator.contact === null ? null : this.contacts.items[this.navigator.contact]!.number,
      curve: content?.contact.group.visible ?? false,
      start: this.check.start,
      inside: content?.counts?.inside ?? null,
      meets: content?.counts?.meets ?? null,
      pictures: spent.pictures,
      scriptMs: spent.script,
      drawMs: spent.drawing,
      firstPicture: spent.firstPicture,
      radius: this.shapes?.radius ?? null,
      norm: this.shapes?.norm ?? null,
      facesShown: content?.shownFaces ?? -1,
      dark: isDark(),
      repaired: this.repair.repaired,
      painted: this.painting.count,
      left: this.repaired.marked(null).length,
      shape: this.layers.state.source,
    };
  }
}
