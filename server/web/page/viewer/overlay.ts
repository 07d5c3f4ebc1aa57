// The layer over the canvas: the witness's label, captions of the parts, the distance under the pointer.
import { rayThrough, type Rect } from "./camera";
import { colourOf, css, type ColourScale } from "./colours";
import { make } from "./dom";
import type { MarkPlace } from "./marks";
import { nameOf, other, type Shown } from "./settings";
import type { LabelPlace, Stage } from "./stage";
import { figure, withUnits } from "./words";

const kHoverTriangles = 400_000; // with more, the distance is shown on a click
const kHoverEvery = 60; // ms
const kGap = 16; // CSS pixels from the marks to the label
const kEdge = 4; // CSS pixels from the picture's edge to the label

export class Overlay {
  readonly element = make("div", { class: "viewer-overlay" });
  private readonly labels = [0, 1].map(() => make("span", { class: "viewer-label", attributes: { "aria-hidden": "true" } }));
  private readonly captions = [0, 1].map(() => make("span", { class: "viewer-part" }));
  private readonly readout = make("span", { class: "viewer-readout", attributes: { "aria-hidden": "true" } });
  private readonly swatch = make("span", { class: "viewer-swatch" });
  private readonly readoutText = make("span");
  private lastHover = 0;

  constructor(
    private readonly stage: Stage,
    private readonly text: () => string,
  ) {
    this.readout.append(this.swatch, this.readoutText);
    this.readout.hidden = true;
    this.element.append(...this.labels, ...this.captions, this.readout);
    stage.onLabels = (places) => this.place(places);
  }

  // Where the labels are, in CSS pixels within the canvas.
  shown(): { x: number; y: number; text: string }[] {
    return this.labels
      .filter((label) => !label.hidden)
      .map((label) => ({ x: Number(label.dataset.x), y: Number(label.dataset.y), text: label.textContent }));
  }

  watchPointer(colours: ColourScale, units: string, triangles: number, say: (text: string) => void): void {
    const { canvas } = this.stage;
    const report = (event: PointerEvent, aloud: boolean): void => {
      const picked = this.pick(event.clientX, event.clientY);
      this.readout.hidden = picked === undefined;
      if (!picked) return;
      const way = picked.proved ? `${picked.path} of` : "from";
      const text = `${withUnits(figure(picked.distance, 3), units)} ${way} ${nameOf(other(picked.side))}`;
      this.swatch.style.background = css(colourOf(picked.distance, colours, picked.path));
      this.readoutText.textContent = text;
      if (aloud) say(`Here ${nameOf(picked.side)} is ${text}.`);
    };
    canvas.addEventListener("pointermove", (event) => {
      if (event.buttons !== 0 || triangles > kHoverTriangles || performance.now() - this.lastHover < kHoverEvery) return;
      this.lastHover = performance.now();
      report(event, false);
    });
    canvas.addEventListener("click", (event) => report(event, true));
    canvas.addEventListener("pointerleave", () => (this.readout.hidden = true));
  }

  private pick(x: number, y: number): (Shown & { side: "a" | "b" }) | undefined {
    const part = this.stage.viewports().find(({ rect }) => x >= rect.left && x < rect.left + rect.width);
    if (!part) return undefined;
    const picked = this.stage.pick(rayThrough(this.stage.camera(), x, y, part.rect), part.side);
    return picked && { ...picked, side: part.side };
  }

  private place(places: LabelPlace[]): void {
    const { left, top } = places[0]!.viewport;
    this.labels.forEach((label, i) => this.placeLabel(label, places[i], left, top));
    this.captions.forEach((caption, i) => {
      const place = places[i];
      caption.hidden = !place || places.length < 2;
      if (!place) return;
      caption.textContent = `${nameOf(place.side)}, by its distance to ${nameOf(other(place.side))}`;
      caption.style.left = `${place.viewport.left - left + 10}px`;
    });
    this.element.classList.toggle("viewer-split", places.length > 1);
  }

  private placeLabel(label: HTMLElement, place: LabelPlace | undefined, left: number, top: number): void {
    const text = this.text();
    const at = place?.at;
    const rect = place?.viewport;
    label.hidden = !at || !rect || !text || at.right < rect.left || at.left > rect.left + rect.width || at.y < rect.top || at.y > rect.top + rect.height;
    if (label.hidden || !at || !rect) return;
    if (label.textContent !== text) label.textContent = text;
    label.style.maxWidth = `${rect.width - 8}px`;
    const { x, y } = labelPlace(at, rect, { width: label.offsetWidth, height: label.offsetHeight });
    label.dataset.x = String(x - left);
    label.dataset.y = String(y - top);
    label.style.transform = `translate(${label.dataset.x}px, ${label.dataset.y}px) translateY(-50%)`;
  }
}

// Places a label beside a segment: to its right or left, else below or above it; never cut by the picture's edge. Returns the
// label's left side and vertical middle, in CSS pixels of the window.
export function labelPlace({ left, right, y }: MarkPlace, picture: Rect, size: { width: number; height: number }): { x: number; y: number } {
  const [first, last] = [picture.left + kEdge, picture.left + picture.width - kEdge - size.width];
  const [top, bottom] = [picture.top + kEdge + size.height / 2, picture.top + picture.height - kEdge - size.height / 2];
  const within = (value: number, from: number, to: number): number => Math.max(from, Math.min(value, to));
  const beside = [right + kGap, left - kGap - size.width].find((x) => x >= first && x <= last);
  if (beside !== undefined) return { x: beside, y: within(y, top, bottom) };
  const below = y + kGap + size.height / 2;
  return { x: within((left + right - size.width) / 2, first, last), y: within(below <= bottom ? below : y - kGap - size.height / 2, top, bottom) };
}
