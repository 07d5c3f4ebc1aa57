// The axis shared by the colour bar, the histogram and the brush: places from 0 to 1 for distances from 0 to the largest.
// Distances above the limit get a fixed part at the end, so that an outlier does not compress all colours.

const kAbovePart = 0.2;

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

// Returns a brushed range as numbers of bin edges; the whole axis is no range.
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
