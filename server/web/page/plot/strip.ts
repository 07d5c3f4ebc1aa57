// The interval of a row on a small scale that all rows of its list share. With limits the scale is the distance divided by the
// limit, so that the limits of all rows are aligned.
import { svg } from "../dom.js";
import { axisFor, positionOf, type LogAxis, type Mark } from "./axis.js";
import { ground, line, rect, stripes } from "./picture.js";

export interface StripReading {
  lower: number;
  upper: number | null;
  limit: number | null;
}

export interface StripScale {
  axis: LogAxis;
  relative: boolean; // the scale is the distance divided by the limit
}

const width = 200;
const height = 20;
const side = 4;
const leastBar = 4; // narrower intervals stay visible
const mostRatio = 20; // distance divided by limit; larger ones are drawn at the end
const stripesId = "strip-stripes";

/** Returns the scale for these rows; null: there is nothing to draw. */
export function scaleFor(readings: readonly StripReading[]): StripScale | null {
  const relative = readings.some(({ limit }) => limit !== null && limit > 0);
  const marks = readings.flatMap((reading) => marksOf(reading, relative) ?? []);
  if (marks.length === 0) return null;
  return { axis: axisFor(relative ? [...marks.map(nearLimit), 1] : marks), relative };
}

// One outlier must not compress all other rows.
function nearLimit(mark: Mark): Mark {
  return mark === null || mark === 0 ? mark : Math.min(Math.max(mark, 1 / mostRatio), mostRatio);
}

// null: this row has no place on such a scale.
function marksOf({ lower, upper, limit }: StripReading, relative: boolean): [Mark, Mark] | null {
  if (!relative) return [lower, upper];
  if (limit === null || limit === 0) return null;
  return [lower / limit, upper === null ? null : upper / limit];
}

/** The shared definitions that all strips of a page refer to; must be in the document once. */
export function stripStripes(): SVGSVGElement {
  return svg("svg", { class: "unseen", width: 1, height: 1, "aria-hidden": "true" }, stripes(stripesId));
}

/** null: the row has no place on this scale. */
export function strip(scale: StripScale, reading: StripReading): SVGSVGElement | null {
  const marks = marksOf(reading, scale.relative);
  if (!marks) return null;
  const x = (mark: Mark): number => side + positionOf(scale.axis, mark) * (width - 2 * side);
  const [from, to] = marks.map(x) as [number, number];
  const wide = Math.max(to - from, leastBar);
  const left = besideLimit((from + to) / 2 - wide / 2, wide, scale.relative ? x(1) : null, reading);
  const picture = svg("svg", { viewBox: `0 0 ${String(width)} ${String(height)}`, width, height, "aria-hidden": "true" });
  picture.append(...ground(0, 0, width, height, scale.relative ? x(1) : null, stripesId));
  picture.append(rect(left, 5, wide, height - 10, reading.upper === null ? "bar open" : "bar", { rx: 1.5 }));
  if (scale.relative) picture.append(line(x(1), 0, x(1), height, "limit-line"));
  return picture;
}

// What is proved to be on one side of the limit is drawn on that side only.
function besideLimit(left: number, wide: number, at: number | null, { lower, upper, limit }: StripReading): number {
  let moved = left;
  if (at !== null && limit !== null && upper !== null && upper <= limit) moved = Math.min(left, at - wide);
  else if (at !== null && limit !== null && lower > limit) moved = Math.max(left, at);
  return Math.min(Math.max(moved, 0), width - wide);
}
