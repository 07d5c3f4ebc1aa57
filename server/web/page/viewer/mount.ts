// The viewer: one mesh coloured by its distance to the other, which lies over it like glass, the witness, the scale. It builds
// everything inside of a host element and removes it again. It needs no network, no `eval` and no HTML in strings.
import { AreaDistribution } from "./distribution";
import type { CameraState } from "./camera";
import type { ColourScale } from "./colours";
import { Commands, witnessLabel } from "./commands";
import { LiveRegion, make } from "./dom";
import { listenToKeys, makeHelp } from "./keys";
import { Overlay } from "./overlay";
import { composed, save } from "./picture";
import { Scale } from "./scale";
import { initialSettings, pathsOf, Store, type Side, type ViewerInput } from "./settings";
import { Stage } from "./stage";
import type { Tones } from "./surface";
import { makeToolbar } from "./toolbar";
import { notesOf } from "./words";

export type { CameraState } from "./camera";
export type { ViewerInput, Witness } from "./settings";

export interface ViewerHandle {
  flyToWitness(index?: number): Promise<void>; // resolves when the camera has arrived
  camera(): CameraState;
  setCamera(camera: Partial<Pick<CameraState, "position" | "target" | "up" | "fov">>): void;
  settled(): Promise<void>; // resolves when the picture is at rest and drawn in full
  frameTimes(): number[]; // ms, of the last frames while the picture moved, since it was first complete
  dispose(): void; // removes everything: elements, listeners, buffers, the graphics context
}

export function mountViewer(host: HTMLElement, input: ViewerInput): ViewerHandle {
  const viewer = new Viewer(host, input);
  const handle: ViewerHandle = {
    flyToWitness: (index) => viewer.commands?.witness(index) ?? Promise.resolve(),
    camera: () => viewer.need().camera(),
    setCamera: (camera) => viewer.need().eye.setPose(camera),
    settled: () => viewer.stage?.settled() ?? Promise.resolve(),
    frameTimes: () => viewer.stage?.clock.frameTimes() ?? [],
    dispose: () => {
      viewer.dispose();
      delete (host as { viewer?: ViewerHandle }).viewer;
    },
  };
  (host as { viewer?: ViewerHandle }).viewer = handle;
  return handle;
}

const kLight: Tones = { faded: [165, 168, 176], section: [222, 214, 200], tint: [112, 128, 156], line: [20, 24, 34] };
const kDark: Tones = { faded: [74, 77, 86], section: [150, 142, 130], tint: [176, 192, 220], line: [235, 238, 245] };

// The end of the colours: the limit, or the largest distance that was asked for.
export function colourScaleOf({ a, b, limit, sideLimits, measured = ["a", "b"] }: ViewerInput, areas: Record<Side, AreaDistribution>): ColourScale {
  if (limit !== null) return { top: limit, limited: true, sideLimits };
  const largest = measured.map((side) => {
    const { scale } = side === "a" ? a : b;
    return Math.max(areas[side].largest, scale && !scale.limited ? scale.top : 0);
  });
  return { top: Math.max(...largest), limited: false, sideLimits };
}

class Viewer {
  stage?: Stage;
  commands?: Commands;
  private readonly root = make("div", { class: "viewer" });
  private readonly picture = make("div", { class: "viewer-picture" });
  private readonly live = new LiveRegion();
  private readonly store: Store;
  private readonly areas: Record<Side, AreaDistribution>;
  private readonly colours: ColourScale;
  private readonly gone = new AbortController();

  constructor(host: HTMLElement, private readonly input: ViewerInput) {
    this.store = new Store(initialSettings(input));
    this.areas = { a: new AreaDistribution(input.a), b: new AreaDistribution(input.b) };
    this.colours = colourScaleOf(input, this.areas);
    const toolbar = this.build();
    if (toolbar) this.root.append(toolbar);
    const scale = new Scale(this.colours, input, this.areas, this.store, this.stage !== undefined);
    this.root.append(this.picture, scale.element);
    this.root.append(make("div", { class: "viewer-notes" }, notesOf(input).map((text) => make("p", { text }))), this.live.element);
    host.replaceChildren(this.root);
    this.followSizeAndTheme();
  }

  need(): Stage {
    if (!this.stage) throw new Error("The viewer has no picture: this browser has no WebGL 2.");
    return this.stage;
  }

  dispose(): void {
    this.gone.abort();
    this.stage?.dispose();
    this.root.remove();
  }

  // The toolbar; missing if the browser cannot draw.
  private build(): HTMLElement | undefined {
    const canvas = make("canvas", { class: "viewer-canvas", attributes: { tabindex: "0", role: "application" } });
    try {
      this.stage = new Stage(canvas, this.input, this.colours, this.store);
    } catch (error) {
      console.warn(error);
      this.picture.append(this.message("This browser cannot draw in three dimensions here: WebGL 2 is missing or switched off. The numbers and the histogram are complete without it."));
      return undefined;
    }
    const { stage } = this;
    const commands = (this.commands = new Commands(stage, this.store, this.input, this.live));
    const overlay = new Overlay(stage, () => witnessLabel(this.input, this.store.value.witness));
    const triangles = Math.max(this.input.a.indices.length, this.input.b.indices.length) / 3;
    overlay.watchPointer(this.colours, this.input.units, triangles, (text) => this.live.say(text));
    const help = makeHelp();
    listenToKeys(stage, this.store, commands, () => help.showModal());
    this.picture.append(canvas, overlay.element, help);
    this.watchContext(canvas);
    return makeToolbar(this.input, this.store, commands, { help: () => help.showModal(), picture: () => this.savePicture(overlay) });
  }

  private message(text: string): HTMLElement {
    return make("p", { class: "viewer-message", text, attributes: { role: "alert" } });
  }

  private watchContext(canvas: HTMLCanvasElement): void {
    let lost: HTMLElement | undefined;
    canvas.addEventListener("webglcontextlost", (event) => {
      event.preventDefault();
      if (this.gone.signal.aborted || lost) return;
      lost = this.message("The graphics driver took the picture away. It comes back by itself if the driver does; else load the page again.");
      this.picture.append(lost);
    });
    canvas.addEventListener("webglcontextrestored", () => {
      lost?.remove();
      lost = undefined;
      this.stage?.clock.dispose();
      this.stage?.changed();
    });
  }

  private followSizeAndTheme(): void {
    const { stage } = this;
    if (!stage) return;
    const observer = new ResizeObserver(() => stage.resize(this.picture.clientWidth, this.picture.clientHeight));
    observer.observe(this.picture);
    const dark = window.matchMedia("(prefers-color-scheme: dark)");
    const follow = (): void => stage.setTones(dark.matches ? kDark : kLight);
    dark.addEventListener("change", follow, { signal: this.gone.signal });
    this.gone.signal.addEventListener("abort", () => observer.disconnect());
    follow();
    stage.resize(this.picture.clientWidth, this.picture.clientHeight);
  }

  private savePicture(overlay: Overlay): void {
    const stage = this.need();
    stage.drawNow();
    const style = window.getComputedStyle(this.root);
    const { coloured } = this.store.value;
    const picture = composed({
      canvas: stage.canvas,
      ratio: stage.canvas.width / (stage.canvas.clientWidth || 1),
      labels: overlay.shown(),
      title: `Distance of ${coloured.toUpperCase()} to ${coloured === "a" ? "B" : "A"}`,
      colours: this.colours,
      paths: pathsOf(this.input[coloured]),
      units: this.input.units,
      paper: style.backgroundColor,
      ink: style.color,
    });
    save(picture, "meshgauge.png", () => this.live.say("The picture could not be saved."));
    this.live.say("The picture is saved.");
  }
}
