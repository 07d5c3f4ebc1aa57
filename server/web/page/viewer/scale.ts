// The colour bar with its ticks and the limit, the histogram above it, the brush over both, and the axis that they share.
import { aboveLimit, colourOf, css, limitOf, mapColour, ticks, type ColourScale, type Path, type Rgb } from "./colours";
import { AreaDistribution } from "./distribution";
import { button, make, makeSvg } from "./dom";
import { nameOf, other, pathsOf, type Side, type Store, type ViewerInput } from "./settings";
import { figure, isBeyond, limitWords, percent, sideWords, withUnits, type Beyond, type OneSide } from "./words";

const kAbovePart = 0.2;

// The axis shared by the colour bar, the histogram and the brush: places from 0 to 1 for distances from 0 to the largest.
// Distances above the limit get a fixed part at the end, so that an outlier does not compress all colours.
export interface Axis {
  top: number; // the limit, or the largest distance without one
  largest: number; // at the end; not below `top`
  split: number; // the place of `top`; 1 if nothing is above it
}

export function axisOf(top: number, largest: number): Axis {
  if (!(largest > top)) return { top, largest: top, split: 1 };
  return { top, largest, split: top > 0 ? 1 - kAbovePart : 0 };
}

export function placeOf(axis: Axis, distance: number): number {
  if (distance <= axis.top) return axis.top > 0 ? (axis.split * Math.max(distance, 0)) / axis.top : 0;
  if (axis.largest <= axis.top) return 1;
  return Math.min(1, axis.split + ((1 - axis.split) * (distance - axis.top)) / (axis.largest - axis.top));
}

export function distanceAt(axis: Axis, place: number): number {
  if (place >= 1) return axis.largest;
  if (place <= 0) return 0;
  if (place <= axis.split) return (axis.top * place) / axis.split;
  return axis.top + ((axis.largest - axis.top) * (place - axis.split)) / (1 - axis.split);
}

// Edges of `count` bins of equal width; one edge is at the limit.
export function binEdges(axis: Axis, count: number): number[] {
  return Array.from({ length: count + 1 }, (_, i) => distanceAt(axis, i / count));
}

// A brushed range, as numbers of bin edges; the whole axis is no range.
export interface Brush {
  from: number;
  to: number;
}

export const wholeBrush = (bins: number): Brush => ({ from: 0, to: bins });
export const isWhole = (brush: Brush, bins: number): boolean => brush.from <= 0 && brush.to >= bins;

// Moves one end to `edge`; the ends neither cross nor meet, so the range is never empty.
export function moveEnd(brush: Brush, end: "from" | "to", edge: number, bins: number): Brush {
  const at = Math.round(edge);
  if (end === "from") return { from: Math.min(Math.max(at, 0), brush.to - 1), to: brush.to };
  return { from: brush.from, to: Math.max(Math.min(at, bins), brush.from + 1) };
}

// The range between the places where a drag started and ended, at least one bin.
export function brushBetween(a: number, b: number, bins: number): Brush {
  const clamped = (place: number): number => Math.min(Math.max(place, 0), 1) * bins;
  const from = Math.min(Math.floor(clamped(Math.min(a, b))), bins - 1);
  return { from, to: Math.max(Math.ceil(clamped(Math.max(a, b))), from + 1) };
}

const kBins = 120; // a multiple of 5, so that an edge is at the limit
const kHeight = 100;
const kGap = 6; // px between labels

export class Scale {
  readonly element = make("section", { class: "viewer-scale", attributes: { "aria-label": "Distances" } });
  private readonly axis: Axis;
  private readonly edges: number[];
  private readonly shares: Record<Side, Partial<Record<Path, Float64Array>>>; // of each bin
  private readonly bar = makeSvg("svg", { preserveAspectRatio: "none", "aria-hidden": "true", class: "viewer-bar" });
  private readonly bars = makeSvg("svg", { viewBox: `0 0 ${kBins} ${kHeight}`, preserveAspectRatio: "none", "aria-hidden": "true", class: "viewer-bars" });
  private readonly track = make("div", { class: "viewer-track" });
  private readonly words = make("p", { class: "viewer-words" });
  private readonly caption = make("p", { class: "viewer-caption" });
  private readonly ends: Record<"from" | "to", HTMLElement>;
  private readonly clear = button("All distances", "Highlight nothing (Escape)", () => this.setBrush(wholeBrush(kBins)));
  private readonly beyond: Record<Side, Beyond>;
  private brush = wholeBrush(kBins);

  constructor(
    private readonly colours: ColourScale,
    private readonly input: ViewerInput,
    private readonly areas: Record<Side, AreaDistribution>,
    private readonly store: Store,
    private readonly hasPicture: boolean, // there is a picture to highlight in
  ) {
    this.axis = axisOf(colours.top, Math.max(areas.a.largest, areas.b.largest));
    this.edges = binEdges(this.axis, kBins);
    this.shares = { a: this.sharesOf("a"), b: this.sharesOf("b") };
    this.beyond = { a: this.beyondOf("a"), b: this.beyondOf("b") };
    this.ends = { from: this.makeEnd("from"), to: this.makeEnd("to") };
    this.track.append(this.bars, this.bar, ...this.makeTicks(), this.ends.from, this.ends.to);
    this.element.append(this.caption, this.track, make("div", { class: "viewer-line" }, [this.words, this.clear]));
    this.listen();
    new ResizeObserver(() => this.settleTicks()).observe(this.track);
    let drawn = "";
    store.watch(({ coloured, split }) => {
      if (drawn === coloured + String(split)) return;
      drawn = coloured + String(split);
      this.drawBar(split ? [coloured, other(coloured)] : [coloured]);
      this.drawBars(coloured);
      this.drawBrush();
    });
  }

  private get units(): string {
    return this.input.units;
  }

  // Inside, the signed distance is negative: the bins of both sides are those of one distribution.
  private sharesOf(side: Side): Partial<Record<Path, Float64Array>> {
    const map = this.input[side];
    const { sides } = map;
    if (!sides) return { plain: this.areas[side].bins(this.edges) };
    const distances = map.distances.map((distance, v) => (sides[v] === -1 ? -distance : distance));
    const [, ...outwards] = this.edges;
    const all = new AreaDistribution({ ...map, distances }).bins([...outwards.map((edge) => -edge).reverse(), ...this.edges]);
    return { outside: all.slice(kBins), inside: all.slice(0, kBins).reverse() };
  }

  // One row for each path of colours that is seen.
  private drawBar(sides: Side[]): void {
    const steps = 2 * kBins;
    const rows = [...new Set(sides.flatMap((side) => pathsOf(this.input[side])))];
    this.bar.setAttribute("viewBox", `0 0 ${steps} ${rows.length}`);
    this.bar.replaceChildren();
    rows.forEach((path, y) => {
      for (let i = 0; i < steps; ++i) {
        const fill = css(colourOf(distanceAt(this.axis, (i + 0.5) / steps), this.colours, path));
        this.bar.append(makeSvg("rect", { x: i, y, width: 2, height: 1, fill }));
      }
    });
  }

  private makeTicks(): HTMLElement[] {
    const { top, largest, split } = this.axis;
    const all = ticks(top);
    const made = all.map((value, i) => {
      const isTop = i === all.length - 1 && value > 0;
      const text = isTop && this.colours.limited ? `limit ${withUnits(figure(value), this.units)}` : isTop ? withUnits(figure(value), this.units) : figure(value);
      const touches = !isTop && value > 0 && value > top * (this.colours.limited ? 0.86 : 0.9);
      return this.tick(placeOf(this.axis, value), touches ? "" : text, isTop && this.colours.limited ? "viewer-limit" : "");
    });
    if (split < 1) made.push(this.tick(1, withUnits(figure(largest, 3), this.units), "viewer-last"));
    return made;
  }

  // Among labels that touch, the limit's stays, then the last, then the others from the left; the last goes a line down instead.
  private settleTicks(): void {
    const all = [...this.track.querySelectorAll<HTMLElement>(".viewer-tick")];
    const rank = (one: HTMLElement): number => (one.classList.contains("viewer-limit") ? 0 : one.classList.contains("viewer-last") ? 1 : 2);
    const seen: DOMRect[] = [];
    let deep = false;
    for (const one of all.sort((x, y) => rank(x) - rank(y))) {
      one.classList.remove("viewer-below", "viewer-unseen");
      const { left, right } = one.getBoundingClientRect();
      const touches = seen.some((other) => left < other.right + kGap && other.left - kGap < right);
      if (touches) one.classList.add(rank(one) === 1 ? "viewer-below" : "viewer-unseen");
      else seen.push(one.getBoundingClientRect());
      deep ||= touches && rank(one) === 1;
    }
    this.track.classList.toggle("viewer-deep", deep);
  }

  private tick(place: number, text: string, kind: string): HTMLElement {
    const made = make("span", { class: `viewer-tick ${kind}${place >= 1 ? " viewer-last" : ""}`, text });
    made.style.left = `${100 * place}%`;
    return made;
  }

  // The highest bar is full; heights are by the square root, so that a surface that is close almost everywhere has more than one bar.
  private drawBars(side: Side): void {
    const paths = pathsOf(this.input[side]);
    const sums = Array.from({ length: kBins }, (_, i) => paths.reduce((sum, path) => sum + this.shares[side][path]![i]!, 0));
    const most = Math.max(...sums, 1e-300);
    this.bars.replaceChildren();
    sums.forEach((sum, i) => {
      if (sum <= 0) return;
      const height = Math.max(1.5, kHeight * Math.sqrt(sum / most));
      const middle = distanceAt(this.axis, (i + 0.5) / kBins);
      let y = kHeight - height;
      for (const path of paths) {
        const part = (height * this.shares[side][path]![i]!) / sum;
        if (part > 0) this.bars.append(makeSvg("rect", { x: i, y, width: 0.94, height: part, fill: css(colourOf(middle, this.colours, path)) }));
        y += part;
      }
    });
    const [one, two] = [nameOf(side), nameOf(other(side))];
    const [what, root] = this.areas[side].of === "area" ? ["Area of", "area"] : ["Points of", "number"];
    const legend = paths.length > 1 ? paths.flatMap((path) => [", ", ...this.legendOf(path, two)]) : [];
    this.caption.replaceChildren(`${what} ${one} by its distance to ${two}`, ...legend, ` (computed; heights by the square root of the ${root})`);
  }

  private legendOf(path: Path, of: string): (HTMLElement | string)[] {
    const swatch = (colour: Rgb): HTMLElement => {
      const made = make("span", { class: "viewer-swatch" });
      made.style.background = css(colour);
      return made;
    };
    const limit = limitOf(this.colours, path);
    const above = limit < Infinity ? [", ", swatch(aboveLimit(path)), ` above ${withUnits(figure(limit), this.units)}`] : [];
    return [swatch(mapColour(1, path)), ` ${path} of ${of}`, ...above];
  }

  private makeEnd(end: "from" | "to"): HTMLElement {
    const label = end === "from" ? "Smallest distance that is highlighted" : "Largest distance that is highlighted";
    const made = make("div", { class: `viewer-end viewer-end-${end}`, attributes: { role: "slider", tabindex: "0", "aria-label": label, "aria-orientation": "horizontal", "aria-valuemin": "0" } });
    made.setAttribute("aria-valuemax", String(this.axis.largest));
    made.addEventListener("keydown", (event) => this.key(event, end));
    return made;
  }

  private key(event: KeyboardEvent, end: "from" | "to"): void {
    const steps: Record<string, number> = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1, PageDown: -10, PageUp: 10, Home: -kBins, End: kBins };
    const step = steps[event.key];
    if (step !== undefined) this.setBrush(moveEnd(this.brush, end, this.brush[end] + step, kBins));
    else if (event.key === "Escape") this.setBrush(wholeBrush(kBins));
    else return;
    event.preventDefault();
  }

  // Dragging an end moves it; dragging elsewhere draws a new range.
  private listen(): void {
    let drag: ((place: number) => void) | undefined;
    const placeAt = (event: PointerEvent): number => {
      const { left, width } = this.track.getBoundingClientRect();
      return (event.clientX - left) / (width || 1);
    };
    this.track.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      const end = (["from", "to"] as const).find((name) => this.ends[name].contains(event.target as Node));
      const start = placeAt(event);
      drag = end
        ? (place) => this.setBrush(moveEnd(this.brush, end, place * kBins, kBins))
        : (place) => Math.abs(place - start) * kBins > 0.5 && this.setBrush(brushBetween(start, place, kBins));
      this.track.setPointerCapture(event.pointerId);
      if (end) this.ends[end].focus();
      event.preventDefault();
    });
    this.track.addEventListener("pointermove", (event) => drag?.(placeAt(event)));
    for (const name of ["pointerup", "pointercancel"] as const) this.track.addEventListener(name, () => (drag = undefined));
    this.track.addEventListener("dblclick", () => this.setBrush(wholeBrush(kBins)));
  }

  private setBrush(brush: Brush): void {
    if (brush.from === this.brush.from && brush.to === this.brush.to) return;
    this.brush = brush;
    this.store.set({ brush: isWhole(brush, kBins) ? null : { low: this.edges[brush.from]!, high: this.edges[brush.to]! } });
    this.drawBrush();
  }

  private drawBrush(): void {
    const off = isWhole(this.brush, kBins);
    this.track.style.setProperty("--from", `${(100 * this.brush.from) / kBins}%`);
    this.track.style.setProperty("--to", `${(100 * this.brush.to) / kBins}%`);
    this.track.classList.toggle("viewer-brushed", !off);
    this.clear.disabled = off;
    for (const end of ["from", "to"] as const) {
      const value = this.edges[this.brush[end]]!;
      this.ends[end].setAttribute("aria-valuenow", String(value));
      this.ends[end].setAttribute("aria-valuetext", withUnits(figure(value), this.units));
    }
    this.words.textContent = off ? this.wholeWords() : this.brushWords();
  }

  private wholeWords(): string {
    const hint = this.hasPicture ? "Drag here, or move the two ends, to highlight a range of distances." : "Drag here, or move the two ends, to ask for the area of a range of distances.";
    const { limited, top } = this.colours;
    if (!limited && !this.beyond.a.ofSides) return hint;
    return `${limitWords(this.store.value, this.beyond, this.input.witnesses, limited ? top : null)} ${hint}`;
  }

  // Distances are rounded to single precision: one that equals the limit is not beyond it.
  private beyondOf(side: Side): Beyond {
    const map = this.input[side], { sides } = map, { sideLimits } = this.colours;
    if (!sideLimits || !sides) return beyondLimit(this.areas[side], this.colours.top);
    const both = (["inside", "outside"] as const).map((path): OneSide => {
      const sign = path === "inside" ? -1 : 1, limit = limitOf(this.colours, path);
      const distances = map.distances.map((distance, v) => sign * sides[v]! * distance); // 0 where no side is proved: within rounding of B
      return { side: path, limit, lower: sideLimits[path].lower, ...beyondLimit(new AreaDistribution({ ...map, distances }), limit) };
    });
    return { farther: both.some(isBeyond), share: 0, of: this.areas[side].of, ofSides: sideWords(both, this.units) };
  }

  private brushWords(): string {
    const [low, high] = [this.edges[this.brush.from]!, this.edges[this.brush.to]!];
    const { coloured, split } = this.store.value;
    const sides: Side[] = split ? [coloured, other(coloured)] : [coloured];
    const said = sides.map((side) => `${percent(this.areas[side].share(low, high))} of ${nameOf(side)}’s ${this.areas[side].of}`);
    const range = `${figure(low)} to ${withUnits(figure(high), this.units)}`;
    return `${said.join(" and ")} ${split ? "are" : "is"} ${range} from the other mesh.`;
  }
}

function beyondLimit(areas: AreaDistribution, limit: number): Beyond {
  return { farther: areas.largest > Math.fround(limit), share: areas.total > 0 ? 1 - areas.share(-Infinity, limit) : 0, of: areas.of };
}
