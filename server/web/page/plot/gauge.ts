// The interval on a horizontal scale with the limit: a picture of the verdict.
import { axisFor, positionOf, ticksOf, type LogAxis } from "./axis.js";
import { frame, ground, kept, line, Picture, readingWords, rect, stripes, text, type Reading } from "./picture.js";
import { intervalText, plain, withUnits } from "../text/numbers.js";
import { svg } from "../dom.js";

const height = 132;
const scaleY = 88; // y of the scale's line
const groundTop = 42;
const side = 14;
const leastBar = 4; // px; narrower intervals stay visible

let made = 0; // for names of patterns, which are the document's

export function gaugeIn(host: HTMLElement, reading: Reading): Picture {
  const pattern = `gauge-stripes-${String(++made)}`;
  return new Picture(host, (width) => draw(width, reading, pattern));
}

interface Scale {
  axis: LogAxis;
  x(mark: number | null): number;
  left: number;
  right: number;
}

function draw(width: number, reading: Reading, pattern: string): SVGSVGElement {
  const { lower, upper, limit } = reading;
  const marks = limit === null ? [lower, upper] : [lower, upper, limit];
  const axis = axisFor(marks);
  const scale = { axis, left: side, right: width - side, x: (mark: number | null) => side + positionOf(axis, mark) * (width - 2 * side) };
  const picture = frame(width, height, readingWords(reading));
  const behind = ground(scale.left, groundTop, scale.right - scale.left, scaleY - groundTop, limit === null ? null : scale.x(limit), pattern);
  picture.append(stripes(pattern), ...behind, scaleOf(scale, width), bar(scale, reading));
  if (limit !== null) picture.append(limitMark(scale, limit, reading.units));
  return picture;
}

function scaleOf(scale: Scale, width: number): SVGGElement {
  const group = svg("g", {}, line(scale.left, scaleY, scale.right, scaleY, "scale"));
  let free = -Infinity; // where the last label ends
  for (const tick of ticksOf(scale.axis, Math.max(3, Math.floor(width / 90)))) {
    const x = scale.left + tick.at * (scale.right - scale.left);
    const major = tick.label !== "";
    group.append(line(x, scaleY, x, scaleY + (major ? 10 : 5), major ? "tick major" : "tick"));
    const half = tick.label.length * 3.7 + 3;
    if (!major || x - half < free) continue;
    free = x + half;
    group.append(text(kept(x, tick.label.length, 0, width), scaleY + 26, tick.label, "tick-name"));
  }
  return group;
}

function bar(scale: Scale, reading: Reading): SVGGElement {
  const { lower, upper, limit, units } = reading;
  const from = scale.x(lower);
  const to = scale.x(upper);
  const middle = (from + to) / 2;
  const wide = Math.max(to - from, leastBar);
  const left = Math.min(Math.max(middle - wide / 2, scale.left), scale.right - wide);
  const figures = intervalText(lower, upper, limit);
  const same = figures.lower === figures.upper;
  const words = same ? withUnits(figures.lower, units) : `${figures.lower} … ${withUnits(figures.upper, units)}`;
  const y = (groundTop + scaleY) / 2;
  return svg(
    "g",
    { class: "interval" },
    rect(left, y - 9, wide, 18, upper === null ? "bar open" : "bar", { rx: 2 }),
    line(left, y - 15, left, y + 15, "cap"),
    upper === null ? null : line(left + wide, y - 15, left + wide, y + 15, "cap"),
    text(kept(middle, words.length, scale.left, scale.right), scaleY + 42, words, "value"),
  );
}

function limitMark(scale: Scale, limit: number, units: string): SVGGElement {
  const x = scale.x(limit);
  const words = `limit ${withUnits(plain(limit), units)}`;
  return svg(
    "g",
    { class: "limit" },
    line(x, 26, x, scaleY + 12, "limit-line"),
    text(kept(x, words.length, scale.left, scale.right), 18, words, "limit-name"),
  );
}
