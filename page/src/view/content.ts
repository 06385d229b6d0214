// What is in the picture: surfaces and marks, in the pose of the timeline or of the model's sliders.
import * as THREE from 'three';
import { kBlue, kSky, type Rgb } from '../shared/colors';
import { isDark } from '../shared/theme';
import type { Pair, SceneInfo } from './api';
import type { PairsOfStep } from './check';
import type { Clock } from './clock';
import { ContactView } from './contactview';
import type { Data } from './data';
import { Distances } from './errors';
import type { LayerState } from './layers';
import { countFaces, type FaceCounts } from './legend';
import { Boxes, ContactPoints, keyPoints, PairLines } from './marks';
import type { ShapePanel } from './shapes';
import type { Stage } from './stage';
import { Surface, type Poses } from './surface';

export class Content {
  readonly surfaces: Surface[] = [];
  readonly errors: Distances; // of predictions
  corrections: Distances; // of the repair
  readonly lines: PairLines;
  readonly contact: ContactView;
  readonly center: THREE.Vector3; // mesh units
  /** The step whose answer for the triangles is shown; -1 for none. */
  shownFaces = -1;
  counts: FaceCounts | null = null;
  private readonly boxes: Boxes[] = [];
  private readonly keys: (THREE.Group | null)[] = [];
  private readonly points: ContactPoints;
  private repair = 0;
  private shownPairs: Pair[] | null = null;
  private shownBoxes: Float32Array[] | null = null;

  constructor(
    private readonly scene: SceneInfo,
    private readonly stage: Stage,
    private readonly data: Data,
    triangles: Uint32Array[],
  ) {
    this.errors = new Distances(scene);
    this.corrections = new Distances(scene);
    this.center = new THREE.Vector3(...(scene.center as [number, number, number]));
    scene.objects.forEach((object, i) => {
      const surface = new Surface(object, i, triangles[i]!, scene.reasons, stage.scale, stage.focusUniforms);
      surface.mesh.visible = false; // until its first frame is loaded
      this.surfaces.push(surface);
      const boxes = new Boxes(stage.scale);
      this.boxes.push(boxes);
      const ids = object.model?.key_points ?? [];
      const keys = ids.length > 0 ? keyPoints(surface, ids, stage.ratio) : null;
      this.keys.push(keys);
      stage.scene.add(surface.mesh, boxes.lines, ...(keys ? [keys] : []));
    });
    this.points = new ContactPoints(this.center, stage.scale, stage.ratio, this.surfaces[0]!.positionUniforms);
    this.lines = new PairLines(stage.viewport);
    this.contact = new ContactView(stage, this.surfaces, this.center);
    stage.scene.add(this.points.group, this.lines.group, this.contact.group);
  }

  /** A point in mesh units, relative to the scene's center. */
  relative(point: readonly number[]): THREE.Vector3 {
    return new THREE.Vector3(...(point as [number, number, number])).sub(this.center);
  }

  get visible(): boolean {
    return this.surfaces.some(({ mesh }) => mesh.visible);
  }

  restyle(): void {
    for (const boxes of this.boxes) boxes.color(isDark() ? kSky : kBlue);
  }

  /** The bounds of the vertices that are shown, in the scene. */
  bounds(): THREE.Box3 {
    const box = new THREE.Box3();
    const at = new THREE.Vector3();
    for (const surface of this.surfaces) {
      if (!surface.mesh.visible) continue;
      for (let v = 0; v < surface.info.vertices; ++v) box.expandByPoint(surface.vertex(v, at).multiplyScalar(this.stage.scale));
    }
    return box;
  }

  /** About the middle of what is shown, in the scene: the mean of some vertices. */
  middle(): THREE.Vector3 {
    const sum = new THREE.Vector3();
    const at = new THREE.Vector3();
    let count = 0;
    for (const surface of this.surfaces) {
      const stride = Math.max(1, Math.floor(surface.info.vertices / 500));
      for (let v = 0; v < surface.info.vertices; v += stride, ++count) sum.add(surface.vertex(v, at));
    }
    return sum.multiplyScalar(this.stage.scale / Math.max(1, count));
  }

  showShape(shapes: ShapePanel, object: number, layers: LayerState): void {
    if (!shapes.ready) return; // The motion is shown until the mean is loaded.
    this.surfaces[object]!.setContact(shapes.uncertified);
    const pose = { data: shapes.shape, tag: `shape/${shapes.version}` };
    this.surfaces[object]!.pose(pose, pose, 0);
    this.surfaces.forEach((surface, i) => {
      surface.mesh.visible = i === object;
      surface.paint({ ...layers, paint: 'plain', collisions: false, meets: false, errorScale: 1, edgeColor: edgeColor() });
    });
  }

  /** Another repair is shown from now on. */
  setRepair(version: number): void {
    this.repair = version;
    this.corrections = new Distances(this.scene);
  }

  /** Shows the pose of the timeline; false while it is not loaded. */
  showFrame(clock: Clock, state: LayerState): boolean {
    const { data, scene } = this;
    const k = clock.frame;
    const next = Math.min(k + 1, scene.frames - 1);
    const [a, b] = [data.frames.get(k), data.frames.get(next)];
    const predicted = state.source === 'prediction' || state.paint === 'error';
    const repaired = data.repaired !== null && (state.source === 'repaired' || state.paint === 'correction');
    // What the shape is compared with, or what is shown in its place.
    const others = repaired ? data.repaired! : predicted ? data.predictions : null;
    others?.prefetch(k);
    const [oa, ob] = [others?.get(k), others?.get(next)];
    if (!a || !b || (others && (!oa || !ob))) return false;
    const name = repaired ? `repaired ${this.repair}` : 'prediction';
    const distances = repaired ? this.corrections : this.errors;
    this.surfaces.forEach((surface, i) => {
      const truth: [Poses, Poses] = [{ data: a.parts[i]!, tag: `frame/${k}` }, { data: b.parts[i]!, tag: `frame/${next}` }];
      let shown = truth;
      const hasOther = others !== null && (repaired || data.predicts(i));
      if (hasOther) {
        const other: [Poses, Poses] = [{ data: oa!.parts[i]!, tag: `${name}/${k}` }, { data: ob!.parts[i]!, tag: `${name}/${next}` }];
        if (state.source !== 'motion') shown = other;
        surface.reference(...(shown === other ? truth : other));
        distances.measure(k, i, a.parts[i]!, oa!.parts[i]!);
      }
      surface.pose(shown[0], shown[1], clock.blend);
      surface.showEnd(clock.t >= 0.5);
      surface.mesh.visible = state.visible[i]!;
      const paint = (state.paint === 'error' && (repaired || !hasOther)) || (state.paint === 'correction' && !repaired) ? 'plain' : state.paint;
      const marked = state.source !== 'repaired'; // marks are of what was checked
      surface.paint({ ...state, collisions: state.collisions && marked, meets: state.meets && marked, paint, errorScale: distances.scale, edgeColor: edgeColor() });
    });
    return true;
  }

  /** Shows the answer of a step for the triangles; null for none (yet). */
  showFaces(step: number, parts: Uint8Array<ArrayBuffer>[] | null): void {
    const changed = parts !== null && this.shownFaces !== step;
    this.surfaces.forEach((surface, i) => surface.setFaces(parts?.[i] ?? null, changed));
    this.shownFaces = parts ? step : -1;
    if (!parts) this.counts = null;
    else if (changed || !this.counts) this.counts = countFaces(parts, this.scene.objects.map(({ triangles }) => triangles));
  }

  showPoints(pairs: PairsOfStep | undefined, visible: boolean, clock: Clock): void {
    this.points.group.visible = visible && (pairs?.items.length ?? 0) > 0;
    if (pairs && (pairs.items !== this.shownPairs || !pairs.complete)) {
      this.shownPairs = pairs.complete ? pairs.items : null;
      this.points.set(pairs.items);
    }
    this.points.setTime(clock.t);
  }

  showKeysAndBoxes(state: LayerState, clock: Clock, shaping: boolean): void {
    this.keys.forEach((keys, i) => {
      if (keys) keys.visible = state.keyPoints && this.surfaces[i]!.mesh.visible;
    });
    if (state.boxes && !shaping) void this.data.requestBoxes(Math.round(clock.frame + clock.blend), state.level);
    const { boxes } = this.data;
    if (boxes && boxes.data !== this.shownBoxes) {
      this.shownBoxes = boxes.data;
      boxes.data.forEach((values, i) => this.boxes[i]!.set(values));
    }
    this.boxes.forEach((one, i) => (one.lines.visible = state.boxes && !shaping && boxes !== null && state.visible[i]!));
  }

  /** The size of the pair's triangle or edges, mesh units. */
  sizeOf(pair: Pair): number {
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
}

const edgeColor = (): Rgb => (isDark() ? [10, 14, 17] : [40, 48, 54]);
