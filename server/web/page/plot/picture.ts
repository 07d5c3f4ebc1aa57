// Shared by the pictures of an interval: an SVG as wide as its place, redrawn when the width changes; and its parts.
import { svg } from "../dom.js";
import { intervalWords, withUnits, plain } from "../text/numbers.js";

export interface Reading {
  lower: number;
  upper: number | null;
  limit: number | null;
  units: string;
  name?: string; // "Distance inside"
}

export class Picture {
  private width = 0;
  private readonly observer: ResizeObserver;
  private frame = 0;

  /** `draw` returns the picture for a width in px; `height` is fixed. */
  constructor(
    readonly host: HTMLElement,
    private readonly draw: (width: number) => SVGSVGElement,
  ) {
    this.observer = new ResizeObserver(() => {
      if (Math.abs(host.clientWidth - this.width) >= 1) this.refresh();
    });
    this.observer.observe(host);
    this.refresh();
  }

  /** Redraws in the next frame, once. */
  refresh(): void {
    if (this.frame !== 0) return;
    this.frame = requestAnimationFrame(() => {
      this.frame = 0;
      this.width = this.host.clientWidth;
      if (this.width > 0) this.host.replaceChildren(this.draw(this.width));
    });
  }

  dispose(): void {
    this.observer.disconnect();
    cancelAnimationFrame(this.frame);
  }
}

/** The picture's frame; `words` is its text for screen readers. */
export function frame(width: number, height: number, words: string): SVGSVGElement {
  return svg("svg", { viewBox: `0 0 ${String(width)} ${String(height)}`, width, height, role: "img", "aria-label": words });
}

export function text(x: number, y: number, words: string, kind: string, anchor: "start" | "middle" | "end" = "middle"): SVGTextElement {
  return svg("text", { x, y, class: kind, "text-anchor": anchor }, words);
}

export function line(x1: number, y1: number, x2: number, y2: number, kind: string): SVGLineElement {
  return svg("line", { x1, y1, x2, y2, class: kind });
}

export function rect(x: number, y: number, width: number, height: number, kind: string, more: Record<string, number | string> = {}): SVGRectElement {
  return svg("rect", { x, y, width: Math.max(width, 0), height: Math.max(height, 0), class: kind, ...more });
}

/** Stripes above the limit, so that the area is not marked by colour alone. */
export function stripes(id: string): SVGDefsElement {
  const pattern = svg("pattern", { id, width: 7, height: 7, patternUnits: "userSpaceOnUse", patternTransform: "rotate(45)" });
  pattern.append(rect(0, 0, 2, 7, "stripe"));
  return svg("defs", {}, pattern);
}

/** A rectangle of the stripes with this id. */
export function striped(x: number, y: number, width: number, height: number, id: string): SVGRectElement {
  return rect(x, y, width, height, "", { fill: `url(#${id})` });
}

/** What lies behind an interval: two colours that meet at the limit, with stripes above it; without a limit one colour. */
export function ground(left: number, top: number, width: number, height: number, limit: number | null, id: string): SVGElement[] {
  if (limit === null) return [rect(left, top, width, height, "ground", { rx: 3 })];
  const above = left + width - limit;
  return [
    rect(left, top, limit - left, height, "ground within"),
    rect(limit, top, above, height, "ground above"),
    striped(limit, top, above, height, id),
  ];
}

export function readingWords(reading: Reading): string {
  const { lower, upper, limit, units } = reading;
  const range = intervalWords(lower, upper, units, limit);
  const gate = limit === null ? "" : `; the limit is ${withUnits(plain(limit), units)}`;
  return `${reading.name || "The distance"}: ${range}${gate}`;
}

/** Returns a label's middle, moved so that the label stays in the picture; assumes an average width per letter. */
export function kept(x: number, letters: number, low: number, high: number): number {
  const half = letters * 3.7;
  return Math.min(Math.max(x, low + half), Math.max(high - half, low + half));
}
