// Connects all parts of the page. Every picture starts in tick().
import * as THREE from 'three';
import { Charts } from '../shared/charts';
import { kBlue, kSky, type Rgb } from '../shared/colors';
import { el, setText } from '../shared/dom';
import { startText } from '../shared/verdict';
import { isDark, onTheme, toggleTheme } from '../shared/theme';
import { ApiError, getBytes, getIndices, GoneError, type Pair, type SceneInfo } from './api';
import { Check, kStart, PairStore } from './check';
import { Clock } from './clock';
import { CollisionPanel } from './collisions';
import { Data } from './data';
import { helpDialog } from './help';
import { Inspector } from './inspect';
import { listen } from './keyboard';
import { clearDirection } from './sight';
import { LayerPanel } from './layers';
import { Layout, type Tab } from './layout';
import { countFaces, legendItems, type FaceCounts } from './legend';
import { Boxes, ContactPoints, keyPoints, PairLines } from './marks';
import { ShapePanel } from './shapes';
import { Stage } from './stage';
import { Surface, type Poses } from './surface';
import { Timeline } from './timeline';

const kAllPairsMs = 150; // How long a step is shown before all of its pairs are listed.
const kChartHeight = 150;

export class App {
  private readonly clock: Clock;
  private readonly layout: Layout;
  private readonly layers: LayerPanel;
  private readonly check: Check;
  private readonly pairs: PairStore;
  private readonly data: Data;
  private readonly timeline: Timeline;
  private readonly collisions: CollisionPanel;
  private readonly charts: Charts;
  private readonly stage: Stage;
  private readonly surfaces: Surface[] = [];
  private readonly boxes: Boxes[] = [];
  private readonly keys: (THREE.Group | null)[] = [];
  private readonly help = helpDialog();
  private contacts!: ContactPoints;
  private lines: PairLines;
  private shapes: ShapePanel | null = null;
  private shapeObject = -1;
  private inspector!: Inspector;

  private dirty = true;
  private last = 0;
  private waiting = false;
  private chosen: { step: number; pair: Pair } | null = null;
  private shownStep = -1;
  private stepSince = 0;
  private shownPairs: Pair[] | null = null;
  private shownFaces = -1;
  private crossingsRequested = false;
  private both = false;
  private shownBoxes: Float32Array[] | null = null;
  private counts: FaceCounts | null = null;
  private readonly errors = new Map<number, { largest: number; rms: number }>();
  private errorScale = 0;
  private legendKey = '';
  private chartsDirty = true;
  private readonly spent = { script: 0, drawing: 0, pictures: 0, started: performance.now(), firstPicture: 0 };

  constructor(
    root: HTMLElement,
    private readonly scene: SceneInfo,
  ) {
    const failed = (error: unknown) => this.fail(error);
    const changed = () => (this.dirty = true);
    this.clock = new Clock(scene.steps, scene.substeps, scene.frames);
    this.check = new Check(scene, (from) => this.checked(from), failed);
    this.pairs = new PairStore(changed, failed);
    this.layers = new LayerPanel(scene, changed);
    this.data = new Data(scene, this.check, () => this.layers.state, () => this.arrived(), failed);
    this.timeline = new Timeline(scene, this.clock, this.check, {
      play: () => this.play(!this.clock.playing),
      move: (by) => this.goTo(() => this.clock.move(by)),
      seekPosition: (position) => this.goTo(() => this.clock.seekPosition(position), true),
      seekTime: (t) => this.goTo(() => this.clock.seek(this.clock.step, t)),
      collision: (direction) => this.nextCollision(direction),
    });
    this.collisions = new CollisionPanel(scene, this.check, (pair) => this.choose(pair), (direction) => this.nextCollision(direction), () => this.goTo(() => this.clock.seek(0)));
    const numbers = scene.frame_numbers;
    this.charts = new Charts({
      substeps: scene.substeps,
      low: numbers[0] ?? 0,
      high: numbers.at(-1) ?? 1,
      height: kChartHeight,
      seek: (step) => this.goTo(() => this.clock.seek(step)),
    });
    this.layout = new Layout(root, scene, () => this.timeline.element, {
      reset: () => this.stage.reset(),
      side: (side) => this.stage.side(side),
      zoom: (factor) => this.stage.zoom(factor),
      legend: () => this.layout.legend.classList.toggle('closed'),
      help: () => this.help.showModal(),
    });
    root.append(this.help);
    const low = new THREE.Vector3(...scene.low);
    const high = new THREE.Vector3(...scene.high);
    const size = high.clone().sub(low);
    const scale = 2 / Math.max(size.x, size.y, size.z, 1e-30);
    this.stage = new Stage(this.layout.stage, { center: low.clone().add(high).multiplyScalar(0.5), scale }, () => this.bounds(new THREE.Box3(low, high)));
    this.lines = new PairLines(this.stage.viewport);
  }

  async start(): Promise<void> {
    this.fillPanels();
    this.bindKeys();
    this.check.startPolling();
    this.data.frames.prefetch(0);
    await this.makeSurfaces();
    this.requestCrossings();
    onTheme(() => this.restyle());
    this.restyle();
    Object.defineProperty(window, 'foldproof', { value: { state: () => this.report() } });
    requestAnimationFrame((now) => this.loop(now));
  }

  private async makeSurfaces(): Promise<void> {
    const { scene, stage } = this;
    const all = await Promise.all(scene.objects.map((_, i) => getIndices(`objects/${i}/triangles`)));
    scene.objects.forEach((object, i) => {
      const surface = new Surface(object, i, all[i]!, scene.reasons, stage.frame);
      surface.mesh.visible = false; // until its first frame is loaded
      this.surfaces.push(surface);
      const boxes = new Boxes(stage.frame);
      this.boxes.push(boxes);
      const ids = object.model?.key_points ?? [];
      const keys = ids.length > 0 ? keyPoints(surface, ids, stage.ratio) : null;
      this.keys.push(keys);
      stage.scene.add(surface.mesh, boxes.lines, ...(keys ? [keys] : []));
    });
    this.contacts = new ContactPoints(stage.frame, stage.ratio, this.surfaces[0]!.positionUniforms);
    stage.scene.add(this.contacts.group, this.lines.group);
    this.inspector = new Inspector(stage, this.surfaces, scene, this.layout.card, (point, size) => stage.approach(point, size));
  }

  private fillPanels(): void {
    const { layout, scene } = this;
    layout.fill('collisions', this.collisions.element);
    layout.fill('layers', this.layers.element);
    layout.fill('charts', el('div', { className: 'panel' }, this.charts.element));
    if (this.clock.still) layout.refuse('charts', 'A single frame has no steps, hence no charts.');
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
      if (tab === 'shapes') this.shapes?.open();
      this.chartsDirty = true;
      this.dirty = true;
    };
  }

  private bindKeys(): void {
    const { clock, layers, stage, timeline } = this;
    const step = (by: number) => () => this.goTo(() => clock.move(by));
    const time = (by: number) => () => this.goTo(() => clock.seekPosition(clock.position + by / clock.substeps));
    listen({
      ' ': () => this.play(!clock.playing),
      ArrowLeft: step(-1), ArrowRight: step(1), 'Shift+ArrowLeft': step(-10), 'Shift+ArrowRight': step(10),
      ',': time(-0.01), '.': time(0.01),
      Home: () => this.goTo(() => clock.seek(0)), End: () => this.goTo(() => clock.seek(clock.steps, 1)),
      '[': () => timeline.changeSpeed(-1), ']': () => timeline.changeSpeed(1),
      p: () => this.nextCollision(-1), n: () => this.nextCollision(1),
      ArrowUp: () => this.collisions.move(-1), ArrowDown: () => this.collisions.move(1),
      r: () => stage.reset(), '0': () => stage.reset(),
      '1': () => stage.side('front'), '2': () => stage.side('side'), '3': () => stage.side('top'),
      W: () => stage.orbit(0, 0.1), S: () => stage.orbit(0, -0.1), A: () => stage.orbit(-0.1, 0), D: () => stage.orbit(0.1, 0),
      '+': () => stage.zoom(0.85), '=': () => stage.zoom(0.85), '-': () => stage.zoom(1.18),
      v: () => layers.cyclePaint(),
      c: () => layers.toggle('collisions'), o: () => layers.toggle('crossings'), t: () => layers.toggle('contacts'), k: () => layers.toggle('keyPoints'),
      b: () => layers.toggle('boxes'), e: () => layers.toggle('edges'), x: () => layers.toggle('seeThrough'),
      d: toggleTheme, l: () => this.layout.legend.classList.toggle('closed'), '?': () => this.help.showModal(),
    });
  }

  // --- Actions

  private play(playing: boolean): void {
    if (playing && this.clock.still) return;
    if (playing) this.showMotion();
    if (playing && this.clock.atEnd) this.clock.seek(0);
    this.clock.playing = playing;
    this.timeline.showPlaying(playing);
    this.dirty = true;
  }

  /** Moves in time; a pair chosen in another step is deselected. */
  private goTo(move: () => void, playOn = false): void {
    if (!playOn) this.play(false);
    this.showMotion();
    move();
    this.dirty = true;
  }

  /** Using the timeline shows the motion instead of a shape of the model. */
  private showMotion(): void {
    if (this.layout.openTab === 'shapes') this.layout.open('collisions');
  }

  private nextCollision(direction: 1 | -1): void {
    const step = this.check.nextColliding(this.clock.step, this.clock.t, direction);
    if (step === kStart) this.goTo(() => this.clock.seek(0));
    else if (step !== null) this.goTo(() => this.clock.seek(step, this.check.steps[step]!.toi));
  }

  private choose(pair: Pair): void {
    this.chosen = { step: this.clock.step, pair };
    this.goTo(() => this.clock.seek(this.clock.step, pair.toi));
    this.update();
    this.lines.show(this.surfaces, pair);
    const point = new THREE.Vector3(...pair.point);
    const size = this.sizeOf(pair);
    this.stage.approach(point, size, clearDirection(this.surfaces, point, 2 * size, this.stage.direction));
    this.dirty = true;
  }

  /** The bounds of what is shown; `first` before anything is. */
  private bounds(first: THREE.Box3): THREE.Box3 {
    if (this.surfaces.length > 0 && this.dirty) this.update();
    const box = new THREE.Box3();
    const at = new THREE.Vector3();
    for (const surface of this.surfaces) {
      if (!surface.mesh.visible) continue;
      for (let v = 0; v < surface.info.vertices; ++v) box.expandByPoint(surface.vertex(v, at));
    }
    return box.isEmpty() ? first : box;
  }

  /** The size of the pair's triangle or edges, mesh units. */
  private sizeOf(pair: Pair): number {
    const [p, q] = [new THREE.Vector3(), new THREE.Vector3()];
    const a = this.surfaces[pair.object_a]!;
    const b = this.surfaces[pair.object_b]!;
    if (pair.kind === 'ee') {
      const first = a.vertex(pair.a[0]!, p).distanceTo(a.vertex(pair.a[1]!, q));
      return Math.max(first, b.vertex(pair.b[0]!, p).distanceTo(b.vertex(pair.b[1]!, q)));
    }
    const k = 3 * pair.b[0]!;
    const first = b.vertex(b.triangles[k]!, p).distanceTo(b.vertex(b.triangles[k + 1]!, q));
    return Math.max(first, q.distanceTo(b.vertex(b.triangles[k + 2]!, p)));
  }

  private checked(from: number): void {
    const { check } = this;
    if (check.steps.length > from || from === 0) this.timeline.paint();
    this.chartsDirty = true;
    this.dirty = true;
    this.layout.warn(check.state === 'failed' ? `The check stopped: ${check.error}` : '');
    this.layout.say(check.verdict(), check.state === 'running' ? check.done / Math.max(1, check.total) : null);
    this.requestCrossings();
  }

  /** Fetches the triangles that cross in the first frame, once, if there are any. */
  private requestCrossings(): void {
    if (this.crossingsRequested || !this.check.startsCrossing || this.surfaces.length === 0) return;
    this.crossingsRequested = true;
    this.surfaces.forEach((surface, i) => {
      getBytes(`start/faces/${i}`).then(
        (faces) => {
          surface.setCrossingFaces(faces);
          this.shownFaces = -1; // Recomputes `both`.
          this.dirty = true;
        },
        (error: unknown) => {
          this.crossingsRequested = false;
          this.fail(error);
        },
      );
    });
  }

  private arrived(): void {
    this.dirty = true;
  }

  private fail(error: unknown): void {
    if (error instanceof GoneError) this.layout.warn(`${error.message} Start foldproof view again and load this page again; what is loaded stays here.`);
    else if (error instanceof ApiError) this.layout.warn(error.message);
    else throw error;
    this.dirty = true;
  }

  private restyle(): void {
    const style = getComputedStyle(document.documentElement);
    this.stage.background(style.getPropertyValue('--stage').trim());
    for (const boxes of this.boxes) boxes.color(isDark() ? kSky : kBlue);
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
      if (this.spent.firstPicture === 0 && this.surfaces[0]?.mesh.visible) this.spent.firstPicture = performance.now();
    }
    requestAnimationFrame((next) => this.loop(next));
  }

  private tick(now: number): void {
    const { clock } = this;
    const seconds = Math.min(0.1, Math.max(0, (now - this.last) / 1000));
    this.last = now;
    // Playing waits for frames that are not loaded; none is skipped.
    if (clock.playing && !this.waiting) {
      if (!clock.advance(seconds * this.scene.fps * clock.speed)) this.play(false);
      this.dirty = true;
    }
    if (!this.dirty && !this.waiting && now - this.stepSince < kAllPairsMs) return;
    if (this.dirty || this.waiting) this.update();
    if (!clock.playing && now - this.stepSince >= kAllPairsMs) this.requestAllPairs();
  }

  private requestAllPairs(): void {
    if (this.atStart && !this.pairs.get(kStart)?.complete) return this.pairs.request(kStart, true);
    const step = this.check.steps[this.clock.step];
    if (step && step.vertex_face + step.edge_edge > 0 && !this.pairs.get(step.number)?.complete) this.pairs.request(step.number, true);
  }

  /** Crossings of the first frame are listed with its step. */
  private get atStart(): boolean {
    return this.check.startsCrossing && this.clock.step === 0;
  }

  private update(): void {
    this.dirty = false;
    if (this.clock.step !== this.shownStep) {
      this.shownStep = this.clock.step;
      this.stepSince = performance.now();
    }
    if (this.chosen && this.chosen.step !== this.clock.step) {
      this.chosen = null;
      this.lines.clear();
    }
    this.data.frames.prefetch(this.clock.frame);
    this.data.faces.prefetch(this.clock.step);
    const shaping = this.layout.openTab === 'shapes' && this.shapes !== null;
    this.waiting = shaping ? !this.showShape() : !this.showFrame();
    this.showFaces(shaping);
    this.showMarks(shaping);
    this.showText(shaping);
    this.stage.redraw();
  }

  private showShape(): boolean {
    const shapes = this.shapes!;
    if (!shapes.ready) return true; // The motion is shown until the mean is loaded.
    const surface = this.surfaces[this.shapeObject]!;
    const pose = { data: shapes.shape, tag: `shape/${shapes.version}` };
    surface.pose(pose, pose, 0);
    surface.mesh.visible = true;
    this.surfaces.forEach((other, i) => {
      if (i !== this.shapeObject) other.mesh.visible = false;
      other.paint({ ...this.layers.state, paint: 'plain', collisions: false, crossings: false, errorScale: 1, edgeColor: edgeColor() });
    });
    return true;
  }

  private showFrame(): boolean {
    const { clock, data, scene } = this;
    const { state } = this.layers;
    const k = clock.frame;
    const next = Math.min(k + 1, scene.frames - 1);
    const [a, b] = [data.frames.get(k), data.frames.get(next)];
    const predicted = state.source === 'prediction' || state.paint === 'error';
    if (predicted) data.predictions.prefetch(k);
    const [pa, pb] = predicted ? [data.predictions.get(k), data.predictions.get(next)] : [undefined, undefined];
    if (!a || !b || (predicted && (!pa || !pb))) return false;
    this.surfaces.forEach((surface, i) => {
      const truth: [Poses, Poses] = [{ data: a.parts[i]!, tag: `frame/${k}` }, { data: b.parts[i]!, tag: `frame/${next}` }];
      let shown = truth;
      const hasPrediction = predicted && data.predicts(i);
      if (hasPrediction) {
        const prediction: [Poses, Poses] = [{ data: pa!.parts[i]!, tag: `prediction/${k}` }, { data: pb!.parts[i]!, tag: `prediction/${next}` }];
        if (state.source === 'prediction') shown = prediction;
        surface.reference(...(shown === prediction ? truth : prediction));
        this.measure(k, i, a.parts[i]!, pa!.parts[i]!);
      }
      surface.pose(shown[0], shown[1], clock.blend);
      surface.mesh.visible = state.visible[i]!;
      const paint = state.paint === 'error' && !hasPrediction ? 'plain' : state.paint;
      surface.paint({ ...state, paint, errorScale: this.errorScale, edgeColor: edgeColor() });
    });
    return true;
  }

  /** Measures the error of a frame's prediction. The color scale grows to the largest error, in round numbers. */
  private measure(k: number, object: number, truth: Float32Array, prediction: Float32Array): void {
    const key = k * this.scene.objects.length + object;
    if (this.errors.has(key)) return;
    const n = 3 * this.scene.objects[object]!.vertices;
    let [largest, sum] = [0, 0];
    for (let c = 0; c < n; c += 3) {
      const d = (truth[c]! - prediction[c]!) ** 2 + (truth[c + 1]! - prediction[c + 1]!) ** 2 + (truth[c + 2]! - prediction[c + 2]!) ** 2;
      largest = Math.max(largest, d);
      sum += d;
    }
    this.errors.set(key, { largest: Math.sqrt(largest), rms: Math.sqrt((3 * sum) / n) });
    if (largest > this.errorScale ** 2) {
      const power = 10 ** Math.floor(Math.log10(Math.sqrt(largest)));
      this.errorScale = [1, 2, 5, 10].map((f) => f * power).find((s) => s >= Math.sqrt(largest)) ?? 10 * power;
    }
  }

  private showFaces(shaping: boolean): void {
    const needed = !shaping && this.data.needsFaces(this.clock.step);
    const slot = needed ? this.data.faces.get(this.clock.step) : undefined;
    if (needed && !slot && this.clock.playing) this.waiting = true;
    const changed = slot !== undefined && this.shownFaces !== this.clock.step;
    this.surfaces.forEach((surface, i) => surface.setFaces(slot?.parts[i] ?? null, changed));
    this.shownFaces = slot ? this.clock.step : -1;
    if (!slot) this.counts = null;
    else if (changed || !this.counts) this.counts = countFaces(slot.parts, this.scene.objects.map(({ triangles }) => triangles));
    if (changed || !slot) this.both = slot !== undefined && this.surfaces.some((surface, i) => slot.parts[i]!.subarray(0, surface.info.triangles).some((collides, face) => collides !== 0 && surface.crosses(face)));
  }

  private showMarks(shaping: boolean): void {
    const { clock, data, layers } = this;
    const { state } = layers;
    const step = this.check.steps[clock.step];
    const colliding = step !== undefined && step.vertex_face + step.edge_edge > 0;
    if (this.atStart && !this.pairs.get(kStart)) this.pairs.request(kStart, false);
    else if (colliding && !this.pairs.get(clock.step)) this.pairs.request(clock.step, false);
    const pairs = colliding ? this.pairs.get(clock.step) : undefined;
    this.contacts.group.visible = state.contacts && !shaping && (pairs?.items.length ?? 0) > 0;
    if (pairs && (pairs.items !== this.shownPairs || !pairs.complete)) {
      this.shownPairs = pairs.complete ? pairs.items : null;
      this.contacts.set(pairs.items);
    }
    this.contacts.setTime(clock.t);
    this.lines.group.visible = this.chosen !== null && !shaping;
    this.keys.forEach((keys, i) => {
      if (keys) keys.visible = state.keyPoints && this.surfaces[i]!.mesh.visible;
    });
    if (state.boxes && !shaping) void data.requestBoxes(Math.round(clock.frame + clock.blend), state.level);
    const { boxes } = data;
    if (boxes && boxes.data !== this.shownBoxes) {
      this.shownBoxes = boxes.data;
      boxes.data.forEach((values, i) => this.boxes[i]!.set(values));
    }
    this.boxes.forEach((one, i) => (one.lines.visible = state.boxes && !shaping && boxes !== null && state.visible[i]!));
  }

  private showText(shaping: boolean): void {
    const { check, clock, layers, scene } = this;
    this.timeline.show(this.waiting);
    this.collisions.show(check.steps[clock.step], this.pairs.get(clock.step), this.atStart ? this.pairs.get(kStart) : undefined);
    if (this.layout.openTab === 'charts' && !clock.still) {
      if (this.chartsDirty) {
        this.charts.setSteps(check.steps);
        if (check.start && check.startsCrossing) this.charts.setStart(check.start.frame, startText(check.start));
      }
      this.chartsDirty = false;
      const first = scene.frame_numbers[clock.frame] ?? 0;
      const second = scene.frame_numbers[Math.min(clock.frame + 1, scene.frames - 1)] ?? first;
      this.charts.setNow(first + clock.blend * (second - first), clock.step);
    }
    const { verdict } = this.layout;
    verdict.hidden = !shaping;
    if (shaping) {
      const { text, kind } = this.shapes!.verdictText();
      setText(verdict, text);
      verdict.dataset['kind'] = kind;
    }
    this.inspector.show(shaping ? null : this.data.faces.get(clock.step)?.parts ?? null, clock.step);
    const error = this.errorNow();
    const boxFrame = this.data.boxes ? (scene.frame_numbers[this.data.boxes.frame] ?? null) : null;
    const faces = this.surfaces.map(({ crossingFaces }) => crossingFaces);
    const start = check.start && check.startsCrossing ? { frame: check.start.frame, faces: faces.some((n) => n === null) ? null : faces.reduce<number>((sum, n) => sum + n!, 0) } : null;
    const key = JSON.stringify([layers.state, start, check.free > 0, check.calm, this.both, shaping, this.shownFaces, boxFrame, this.chosen !== null, error]);
    if (key === this.legendKey) return;
    this.legendKey = key;
    this.layout.legend.replaceChildren(
      ...legendItems({ layers: layers.state, shapes: shaping, start, free: check.free > 0, calm: check.calm, both: this.both, reasons: scene.reasons, objects: scene.objects.map(({ name }) => name), counts: this.counts, boxFrame, chosen: this.chosen !== null, error }),
    );
  }

  private errorNow(): { scale: number; largest: number; rms: number } | null {
    let [largest, squares, count] = [0, 0, 0];
    this.scene.objects.forEach((_, i) => {
      const error = this.errors.get(this.clock.frame * this.scene.objects.length + i);
      if (!error) return;
      largest = Math.max(largest, error.largest);
      squares += error.rms ** 2;
      ++count;
    });
    return count > 0 ? { scale: this.errorScale, largest, rms: Math.sqrt(squares / count) } : null;
  }

  /** For tests and for the browser's console. */
  private report(): Record<string, unknown> {
    const { clock, spent } = this;
    return {
      step: clock.step,
      t: clock.t,
      position: clock.position,
      playing: clock.playing,
      waiting: this.waiting,
      camera: this.stage.camera.position.toArray(),
      bytes: this.data.bytes(),
      budget: this.data.budget,
      framesAhead: this.data.frames.ahead(clock.frame),
      steps: this.check.steps.length,
      state: this.check.state,
      start: this.check.start,
      crossingFaces: this.surfaces.map(({ crossingFaces }) => crossingFaces),
      pictures: spent.pictures,
      scriptMs: spent.script,
      drawMs: spent.drawing,
      firstPicture: spent.firstPicture,
      radius: this.shapes?.radius ?? null,
      norm: this.shapes?.norm ?? null,
      facesShown: this.shownFaces,
    };
  }
}

const edgeColor = (): Rgb => (isDark() ? [10, 14, 17] : [40, 48, 54]);

