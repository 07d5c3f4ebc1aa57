// The picture: one canvas, drawn only when something has changed. Runs on the page's only thread; the graphics process draws
// on its own and gets at most one frame at a time, so that input never waits behind pictures.
import { PerspectiveCamera, Scene, Vector2, Vector4, WebGLRenderer } from "three";
import { axesOf, nearFar, type CameraState, type Rect } from "./camera";
import type { ColourScale } from "./colours";
import { Eye } from "./eye";
import { hiddenBy, Marks, type MarkPlace } from "./marks";
import { FrameClock, Pace, type Fineness } from "./pace";
import { Refiner, type PartToDraw } from "./refiner";
import { Rays } from "./rays";
import { nameOf, other, shownAt, type Settings, type Shown, type Side, type Store, type ViewerInput } from "./settings";
import { boundsOf, reachOf, unionOf } from "./shape";
import { makeTable, Surface, type Tones } from "./surface";
import { add, dot, mix, scale, sub, type Vec3 } from "./vec";

const kStillAfter = 180; // ms without a change before the picture is drawn in full
const kEdgeTime = 12; // ms per frame for making edges
const kMostPixels = 2; // per CSS pixel and axis
const kFull: Fineness = { scale: 1, coarse: 0 };

export interface LabelPlace {
  at: MarkPlace | undefined;
  viewport: Rect;
  side: Side;
}

// True if pictures are rendered by software, as far as the browser tells. Asked before the real context is created, whose
// antialiasing cannot change later: in software it takes many times as long with it.
function drawsInSoftware(): boolean {
  const gl = document.createElement("canvas").getContext("webgl2");
  if (!gl) return true;
  const named = gl.getExtension("WEBGL_debug_renderer_info");
  const name = named ? String(gl.getParameter(named.UNMASKED_RENDERER_WEBGL)) : "";
  gl.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|softpipe|software|basic render/i.test(name);
}

export class Stage {
  readonly centre: Vec3;
  readonly radius: number;
  readonly eye: Eye;
  readonly clock: FrameClock;
  onLabels: (places: LabelPlace[]) => void = () => undefined;

  private readonly renderer: WebGLRenderer;
  private readonly scene = new Scene();
  private readonly lens = new PerspectiveCamera();
  private readonly marks = new Marks();
  private readonly table = makeTable();
  private readonly surfaces: Record<Side, Surface>;
  private readonly rays: Record<Side, Rays>;
  private readonly pace: Pace;
  private readonly refiner: Refiner | undefined;
  private size = { width: 1, height: 1 };
  private lastChange = -Infinity;
  private stillTimer = 0;
  private scheduled = 0;
  private disposed = false;
  private full = false; // the canvas shows everything, at rest
  private loaded = false;
  private waiting: (() => void)[] = [];

  // Throws if there is no WebGL 2.
  constructor(
    readonly canvas: HTMLCanvasElement,
    private readonly input: ViewerInput,
    colours: ColourScale,
    private readonly store: Store,
  ) {
    const bounds = unionOf([boundsOf(input.a, input.a.translation), boundsOf(input.b, input.b.translation)]);
    this.centre = mix(bounds.low, bounds.high, 0.5);
    this.radius = Math.max(...[input.a, input.b].map((map) => reachOf(map, map.translation, this.centre))) || 1;
    const slow = drawsInSoftware();
    this.renderer = new WebGLRenderer({ canvas, antialias: !slow, alpha: true, powerPreference: "high-performance" });
    this.renderer.setClearColor(0, 0);
    this.renderer.autoClear = false;
    const make = (map: ViewerInput["a"]): Surface => new Surface(map, { origin: this.centre, size: this.radius }, this.table, colours);
    this.surfaces = { a: make(input.a), b: make(input.b) };
    this.rays = { a: new Rays(input.a), b: new Rays(input.b) };
    this.pace = new Pace(slow, (input.a.indices.length + input.b.indices.length) / 3);
    this.clock = new FrameClock(this.renderer.getContext() as WebGL2RenderingContext);
    this.scene.add(this.surfaces.a.group, this.surfaces.b.group, this.marks.mesh);
    if (slow) {
      this.refiner = new Refiner(this.renderer, this.scene, this.lens);
      for (const surface of Object.values(this.surfaces)) surface.prepareCoarse();
    }
    const first = input.witnesses[0];
    const sees = (from: Vec3): boolean => !first || this.isFree(from, first.point);
    this.eye = new Eye(this.lens, canvas, this.centre, this.radius, () => this.changed(), sees);
    store.watch(() => this.settingsChanged());
  }

  // Draws soon: coarsely while changes follow each other, then in full.
  changed(): void {
    if (this.disposed) return;
    this.lastChange = performance.now();
    this.full = false;
    if (this.refiner) this.refiner.active = false;
    window.clearTimeout(this.stillTimer);
    this.stillTimer = window.setTimeout(() => this.schedule(), kStillAfter + 10);
    this.schedule();
  }

  // Resolves when the picture is at rest and drawn in full.
  settled(): Promise<void> {
    return this.full || this.disposed ? Promise.resolve() : new Promise((resolve) => this.waiting.push(resolve));
  }

  setTones(tones: Tones): void {
    this.surfaces.a.setTones(tones);
    this.surfaces.b.setTones(tones);
    this.changed();
  }

  resize(width: number, height: number): void {
    this.size = { width: Math.max(1, Math.floor(width)), height: Math.max(1, Math.floor(height)) };
    this.canvas.style.width = `${this.size.width}px`;
    this.canvas.style.height = `${this.size.height}px`;
    this.changed();
  }

  // Returns which mesh is coloured in which part of the canvas, in CSS pixels of the window.
  viewports(): { side: Side; rect: Rect }[] {
    const { left, top } = this.canvas.getBoundingClientRect();
    const { width, height } = this.size;
    const { split, coloured } = this.store.value;
    if (!split) return [{ side: coloured, rect: { left, top, width, height } }];
    const half = Math.floor(width / 2);
    return [
      { side: coloured, rect: { left, top, width: half, height } },
      { side: other(coloured), rect: { left: left + half, top, width: width - half, height } },
    ];
  }

  camera(): CameraState {
    const rects = this.viewports().map(({ rect }) => rect);
    const { position, target, up } = this.eye.pose();
    const fov = this.eye.fovFor(rects[0]!.width / rects[0]!.height);
    const planes = nearFar(position, target, this.centre, this.radius);
    return { position, target, up, fov, ...planes, origin: this.centre, viewport: rects[0]!, viewports: rects };
  }

  // True if no part of the coloured mesh is in front of the point.
  isFree(eye: Vec3, point: Vec3, side: Side = this.store.value.coloured): boolean {
    if (!this.store.value.shown[side]) return true;
    const map = this.input[side];
    const slack = this.radius * (map.display.form === "decimated" ? 4e-3 : 2e-4);
    const blocked = (from: Vec3, way: Vec3, to: number): boolean =>
      this.rays[side].first(sub(from, map.translation), way, 0, to, (p) => this.keeps(add(p, map.translation))) !== undefined;
    return !hiddenBy(blocked, eye, point, slack);
  }

  // Returns what is drawn at the first point of the coloured mesh that a ray from the eye meets.
  pick(direction: Vec3, side: Side): Shown | undefined {
    const map = this.input[side];
    const eye = sub(this.eye.pose().position, map.translation);
    const hit = this.rays[side].first(eye, direction, 0, Infinity, (p) => this.keeps(add(p, map.translation)));
    return hit && this.store.value.shown[side] ? shownAt(map, hit) : undefined;
  }

  // Draws in full now, so that the canvas can be copied in the same task.
  drawNow(): void {
    this.prepareEdges(Infinity);
    this.draw(kFull, false);
  }

  dispose(): void {
    this.disposed = true;
    this.settle();
    window.clearTimeout(this.stillTimer);
    window.cancelAnimationFrame(this.scheduled);
    this.eye.dispose();
    this.clock.dispose();
    this.refiner?.dispose();
    this.surfaces.a.dispose();
    this.surfaces.b.dispose();
    this.marks.dispose();
    this.table.dispose();
    this.renderer.dispose();
    this.renderer.forceContextLoss();
  }

  private schedule(): void {
    if (!this.scheduled && !this.disposed) this.scheduled = window.requestAnimationFrame(() => this.frame());
  }

  private frame(): void {
    this.scheduled = 0;
    if (this.renderer.getContext().isContextLost()) return;
    if (this.clock.busy()) return this.schedule();
    const flying = this.eye.fly(performance.now());
    const moving = flying || performance.now() - this.lastChange < kStillAfter;
    if (!moving && !this.prepareEdges(kEdgeTime)) return this.schedule();
    if (!moving && this.refiner) return this.refine(this.refiner);
    const begun = performance.now();
    this.draw(moving ? this.pace.moving : kFull, moving);
    this.clock.given(begun, moving, (ms) => moving && this.pace.took(ms));
    if (!moving) this.settle();
    if (flying) this.changed();
    else if (this.clock.busy()) this.awaitClock();
  }

  // True if the edges to be drawn are ready.
  private prepareEdges(ms: number): boolean {
    const { wire, shown } = this.store.value;
    return !wire || (["a", "b"] as Side[]).every((side) => !shown[side] || this.surfaces[side].prepareEdges(ms));
  }

  // Draws one portion of the full picture, or finishes it.
  private refine(refiner: Refiner): void {
    const begun = performance.now();
    const ratio = this.ratio(kFull);
    if (!refiner.active) refiner.begin(this.partsToDraw(), this.size.width, this.size.height, ratio < 1.5 ? 2 * ratio : ratio);
    if (refiner.step()) {
      this.clock.given(begun, false, (ms) => refiner.took(ms));
      return this.schedule();
    }
    this.fit(ratio);
    this.hideAll();
    this.renderer.clear();
    refiner.present();
    this.drawMarks(1 / ratio);
    this.settle();
  }

  private settle(): void {
    this.full = true;
    if (!this.loaded) this.clock.forget(); // the first pictures include compiling the shaders
    this.loaded = true;
    for (const done of this.waiting.splice(0)) done();
  }

  private partsToDraw(): PartToDraw[] {
    const camera = this.camera();
    return this.viewports().map(({ side, rect }) => {
      this.look(side, kFull, false);
      const objects = (["a", "b"] as Side[]).sort((x) => (x === side ? -1 : 1)).flatMap((one) => this.surfaces[one].visible());
      const prepare = (): void => {
        this.look(side, kFull, false);
        this.hideAll();
        this.updateCut(camera);
        this.eye.aim(camera, rect.width / rect.height);
      };
      return { rect: { ...rect, left: rect.left - camera.viewport.left, top: 0 }, objects, prepare };
    });
  }

  private hideAll(): void {
    for (const surface of Object.values(this.surfaces)) for (const object of surface.visible()) object.visible = false;
    this.marks.mesh.visible = false;
  }

  // Draws only the marks, over the canvas as it is.
  private drawMarks(pixel: number): void {
    this.drawParts(this.camera(), pixel, () => undefined);
  }

  // Draws each part of the canvas after `prepare`, and tells where the labels are.
  private drawParts(camera: CameraState, pixel: number, prepare: (side: Side) => void): void {
    this.renderer.setScissorTest(true);
    this.onLabels(this.viewports().map(({ side, rect }) => {
      prepare(side);
      const place = { at: this.updateMarks(camera, side, rect, pixel), viewport: rect, side };
      this.renderPart(camera, rect);
      return place;
    }));
  }

  // Polls until the frame is done.
  private awaitClock(): void {
    window.requestAnimationFrame(() => {
      if (!this.disposed && this.clock.busy()) this.awaitClock();
    });
  }

  private ratio(fineness: Fineness): number {
    return Math.max(0.25, Math.min(window.devicePixelRatio || 1, kMostPixels) * fineness.scale);
  }

  private fit(ratio: number): void {
    const { width, height } = this.size;
    if (this.renderer.getPixelRatio() !== ratio) this.renderer.setPixelRatio(ratio);
    if (this.canvas.width !== Math.floor(width * ratio) || this.canvas.height !== Math.floor(height * ratio)) {
      this.renderer.setSize(width, height, false);
    }
  }

  private draw(fineness: Fineness, moving: boolean): void {
    const ratio = this.ratio(fineness);
    this.fit(ratio);
    const camera = this.camera();
    this.renderer.setScissorTest(false);
    this.renderer.clear();
    this.drawParts(camera, 1 / ratio, (side) => {
      this.look(side, fineness, moving);
      this.updateCut(camera);
    });
  }

  private look(side: Side, fineness: Fineness, moving: boolean): void {
    const { split, shown, wire } = this.store.value;
    const look = { wire, moving, coarse: fineness.coarse };
    this.surfaces[side].setLook({ ...look, role: shown[side] ? "coloured" : "none" });
    this.surfaces[other(side)].setLook({ ...look, role: shown[other(side)] && !split ? "overlay" : "none" });
  }

  private renderPart(camera: CameraState, rect: Rect): void {
    const left = rect.left - camera.viewport.left;
    this.renderer.setViewport(left, 0, rect.width, rect.height);
    this.renderer.setScissor(left, 0, rect.width, rect.height);
    this.eye.aim(camera, rect.width / rect.height);
    this.renderer.render(this.scene, this.lens);
  }

  private updateMarks(camera: CameraState, side: Side, rect: Rect, pixel: number): MarkPlace | undefined {
    const pair = this.input.witnesses[this.store.value.witness];
    this.marks.mesh.visible = pair !== undefined;
    if (!pair) return undefined;
    const hides = (p: Vec3): boolean => !this.isFree(camera.position, p, side);
    return this.marks.update(camera, rect, { pair, hidden: { point: hides(pair.point), nearest: hides(pair.nearest) } }, pixel);
  }

  // The part that the cut leaves: the side of the plane that its normal points away from.
  private plane(): { normal: Vec3; offset: number } | undefined {
    const { axis, normal, offset, flipped } = this.store.value.cut;
    if (axis === "off") return undefined;
    const sign = flipped ? -1 : 1;
    return { normal: scale(normal, sign), offset: sign * offset * this.radius };
  }

  private keeps(p: Vec3): boolean {
    const plane = this.plane();
    return !plane || dot(plane.normal, sub(p, this.centre)) <= plane.offset;
  }

  private updateCut(camera: CameraState): void {
    const plane = this.plane();
    if (!plane) return;
    const { right, up, back } = axesOf(camera);
    const beyond = plane.offset - dot(plane.normal, sub(camera.position, this.centre));
    const seen = new Vector4(-dot(plane.normal, right), -dot(plane.normal, up), -dot(plane.normal, back), beyond / this.radius);
    for (const surface of Object.values(this.surfaces)) surface.uniforms.clip!.value = seen;
  }

  private settingsChanged(): void {
    const settings: Settings = this.store.value;
    for (const { uniforms } of Object.values(this.surfaces)) {
      uniforms.plain!.value = settings.plain;
      uniforms.opacity!.value = settings.opacity;
      uniforms.clipped!.value = settings.cut.axis !== "off";
      uniforms.brushed!.value = settings.brush !== null;
      if (settings.brush) uniforms.brush!.value = new Vector2(settings.brush.low, settings.brush.high);
    }
    this.canvas.setAttribute("aria-label", describe(settings));
    this.eye.settings(settings.up, settings.split);
    this.changed();
  }
}

function describe({ coloured, split, shown }: Settings): string {
  const [one, two] = [nameOf(coloured), nameOf(other(coloured))];
  if (split) return `Meshes ${one} and ${two} side by side, each coloured by its distance to the other. Press ? for keys.`;
  const over = shown[other(coloured)] ? `, ${two} over it like glass` : "";
  return `Mesh ${one} coloured by its distance to ${two}${over}. Press ? for keys.`;
}
