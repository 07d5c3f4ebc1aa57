// The interval over time: a band that shrinks, on a logarithmic axis of distance, and the limit as a line across it.
import { axisFor, positionOf, ticksOf, type LogAxis } from "./axis.js";
import { frame, ground, line, Picture, readingWords, striped, stripes, text } from "./picture.js";
import { inTime, plain, withUnits } from "../text/numbers.js";
import { svg } from "../dom.js";

export interface Sample {
  ms: number; // since the start of the comparison
  lower: number;
  upper: number | null; // null: unknown
}

const mostSamples = 500;

/** Bounds only improve, so each holds until the next one. */
export class History {
  private readonly kept: Sample[] = [];

  get samples(): readonly Sample[] {
    return this.kept;
  }

  get last(): Sample | undefined {
    return this.kept.at(-1);
  }

  add(sample: Sample): void {
    const last = this.kept.at(-1);
    if (last && sample.ms < last.ms) return; // a response that arrived after a later one
    if (last && last.lower === sample.lower && last.upper === sample.upper) return;
    this.kept.push({ ...sample });
    if (this.kept.length > mostSamples) this.thin();
  }

  // Drops every other sample of the older half; the first, the last and the recent ones stay.
  private thin(): void {
    const half = mostSamples / 2;
    const thinned = this.kept.filter((_, i) => i === 0 || i >= half || i % 2 === 0);
    this.kept.splice(0, this.kept.length, ...thinned);
  }
}

/** Returns the ends of an axis of time that grows in steps, in ms, with round numbers along it. */
export function timeAxis(ms: number): { end: number; ticks: number[] } {
  const end = [10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10_000, 20_000, 30_000, 60_000, 120_000, 180_000].find((one) => ms <= one) ?? ms;
  const step = [2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10_000, 20_000, 30_000, 60_000].find((one) => end / one <= 6) ?? end / 5;
  const ticks: number[] = [];
  for (let at = 0; at <= end; at += step) ticks.push(at);
  return { end, ticks };
}

const stripesId = "timeline-stripes";
const height = 300;
const room = { left: 62, right: 16, top: 14, bottom: 36 };

export interface Timeline {
  history: History;
  limit: number | null;
  units: string;
  now: number; // ms: the end of the known time
}

export class TimelinePlot {
  private readonly picture: Picture;

  constructor(
    host: HTMLElement,
    private timeline: Timeline,
  ) {
    this.picture = new Picture(host, (width) => draw(width, this.timeline));
  }

  show(now: number): void {
    this.timeline = { ...this.timeline, now };
    this.picture.refresh();
  }

  dispose(): void {
    this.picture.dispose();
  }
}

interface Plane {
  axis: LogAxis;
  x(ms: number): number;
  y(mark: number | null): number;
  width: number;
  ticks: number[];
}

function draw(width: number, timeline: Timeline): SVGSVGElement {
  const { history, limit, units, now } = timeline;
  const samples = history.samples.filter((sample) => sample.ms <= now);
  const plane = planeOf(width, samples, limit, now);
  const last = samples.at(-1) ?? { ms: 0, lower: 0, upper: null };
  const picture = frame(width, height, `${readingWords({ ...last, limit, units })}; after ${inTime(now)}`);
  picture.append(stripes(stripesId), ...behind(plane, limit), grid(plane), ...band(plane, samples, now));
  if (limit !== null) picture.append(limitLine(plane, limit, units));
  return picture;
}

function planeOf(width: number, samples: readonly Sample[], limit: number | null, now: number): Plane {
  const marks = samples.flatMap((sample) => [sample.lower, sample.upper]);
  const axis = axisFor([...(marks.length === 0 ? [0, null] : marks), ...(limit === null ? [] : [limit])], true);
  const { end, ticks } = timeAxis(Math.max(now, samples.at(-1)?.ms ?? 0));
  const right = width - room.right;
  const bottom = height - room.bottom;
  return {
    axis,
    ticks,
    width,
    x: (ms) => room.left + (ms / end) * (right - room.left),
    y: (mark) => bottom - positionOf(axis, mark) * (bottom - room.top),
  };
}

function behind(plane: Plane, limit: number | null): SVGElement[] {
  const wide = plane.width - room.right - room.left;
  const whole = ground(room.left, room.top, wide, height - room.bottom - room.top, null, stripesId);
  return limit === null ? whole : [...whole, striped(room.left, room.top, wide, plane.y(limit) - room.top, stripesId)];
}

function grid(plane: Plane): SVGGElement {
  const group = svg("g");
  const bottom = height - room.bottom;
  for (const tick of ticksOf(plane.axis, 7)) {
    const y = bottom - tick.at * (bottom - room.top);
    if (tick.label === "") {
      group.append(line(room.left - 4, y, room.left, y, "tick"));
      continue;
    }
    group.append(line(room.left - 8, y, room.left, y, "tick major"), line(room.left, y, plane.width - room.right, y, "grid"));
    group.append(text(room.left - 12, y + 4, tick.label, "tick-name", "end"));
  }
  for (const ms of plane.ticks) {
    const x = plane.x(ms);
    group.append(line(x, bottom, x, bottom + 6, "tick major"));
    group.append(text(Math.min(x, plane.width - 20), bottom + 22, ms === 0 ? "0" : inTime(ms), "tick-name"));
  }
  return group;
}

// Each bound holds until a better one arrives, so both edges are stairs.
function band(plane: Plane, samples: readonly Sample[], now: number): SVGElement[] {
  if (samples.length === 0) return [];
  const upper = stairs(plane, samples, now, (sample) => sample.upper);
  const lower = stairs(plane, samples, now, (sample) => sample.lower);
  const outline = [...upper, ...[...lower].reverse()];
  const end = upper.at(-1) ?? [0, 0];
  const start = lower.at(-1) ?? [0, 0];
  return [
    svg("polygon", { class: "band", points: toPoints(outline) }),
    svg("polyline", { class: "edge", points: toPoints(upper) }),
    svg("polyline", { class: "edge", points: toPoints(lower) }),
    svg("line", { class: "now", x1: end[0], y1: end[1], x2: start[0], y2: start[1] }),
  ];
}

type XY = [number, number];

function stairs(plane: Plane, samples: readonly Sample[], now: number, pick: (sample: Sample) => number | null): XY[] {
  const points: XY[] = [];
  samples.forEach((sample, i) => {
    const y = plane.y(pick(sample));
    const until = samples[i + 1]?.ms ?? Math.max(now, sample.ms);
    points.push([plane.x(sample.ms), y], [plane.x(until), y]);
  });
  return points;
}

const toPoints = (points: readonly XY[]): string => points.map(([x, y]) => `${x.toFixed(1)},${y.toFixed(1)}`).join(" ");

function limitLine(plane: Plane, limit: number, units: string): SVGGElement {
  const y = plane.y(limit);
  const right = plane.width - room.right;
  const below = y < room.top + 22;
  return svg(
    "g",
    { class: "limit" },
    line(room.left, y, right, y, "limit-line"),
    text(right - 6, below ? y + 16 : y - 6, `limit ${withUnits(plain(limit), units)}`, "limit-name", "end"),
  );
}
