// All comparisons of a batch as one bar: their outcomes, those running and those waiting.
import type { BatchCounts, BatchProgressEvent } from "../api/types.js";
import { svg } from "../dom.js";
import { tally, type Kind } from "./rows.js";
import { toneOf, wordsOf } from "./words.js";

export interface BarPart {
  kind: Kind | "runs" | "waits";
  x: number;
  width: number;
}

const barLength = 1000; // in units of the picture
const leastPart = 4; // so that one of 10,000 is visible
const kinds: readonly Kind[] = ["fail", "error", "undecided", "cancelled", "gone", "pass", "measured"];

/** The segments that are not empty, side by side from 0 to 1000. */
export function partsOf(counts: BatchCounts): BarPart[] {
  const so = tally(counts);
  const all: [BarPart["kind"], number][] = [...kinds.map((kind): [Kind, number] => [kind, so[kind]]), ["runs", counts.running], ["waits", counts.queued]];
  const there = all.filter(([, count]) => count > 0);
  const shared = barLength - leastPart * there.length;
  let x = 0;
  return there.map(([kind, count]) => {
    const part = { kind, x, width: leastPart + (count / counts.total) * shared };
    x += part.width;
    return part;
  });
}

export function stackedBar(now: BatchProgressEvent): SVGSVGElement {
  const { heading, reason } = wordsOf(now);
  const picture = svg("svg", { viewBox: `0 0 ${String(barLength)} 20`, preserveAspectRatio: "none", role: "img", "aria-label": `${heading}. ${reason}` });
  for (const { kind, x, width } of partsOf(now.counts)) picture.append(svg("rect", { x, width, height: 20, class: classOf(kind) }));
  return picture;
}

function classOf(kind: BarPart["kind"]): string {
  return kind === "runs" || kind === "waits" ? `part ${kind}` : `part ${toneOf[kind]} ${kind}`;
}
