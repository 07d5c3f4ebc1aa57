// A sign for each verdict, which differs from the others by more than its colour.
import { svg } from "../dom.js";
import type { Tone } from "../text/verdict.js";

const strokes: Record<Tone, string> = {
  pass: "M5 12.5l4.5 4.5L19 7.5",
  fail: "M6.5 6.5l11 11m0-11l-11 11",
  undecided: "M6 10h12M6 14.5h12",
  measured: "M5 7v10M19 7v10M5 12h14",
};

export function iconOf(tone: Tone): SVGSVGElement {
  return svg("svg", { class: "icon", viewBox: "0 0 24 24", "aria-hidden": "true" }, svg("circle", { cx: 12, cy: 12, r: 12 }), svg("path", { d: strokes[tone] }));
}
