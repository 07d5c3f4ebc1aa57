// The time of each stage, as one bar with a table as its legend.
import type { Timings } from "../api/types.js";
import { h, scroller, svg } from "../dom.js";
import { inPercent, inTime } from "../text/numbers.js";

export interface StageTime {
  name: keyof Timings;
  label: string;
  ms: number;
}

const labels: [keyof Timings, string][] = [
  ["queue", "Waiting"],
  ["read_a", "Reading A"],
  ["read_b", "Reading B"],
  ["align", "Aligning"],
  ["build", "Building trees"],
  ["traverse", "Traversal"],
  ["reduce", "Reduction"],
  ["certify", "Certificate"],
  ["areas", "Areas"],
  ["statistics", "Statistics"],
];

/** In order of time, without the total. */
export function stageTimes(timings: Timings): StageTime[] {
  return labels.flatMap(([name, label]) => {
    const ms = timings[name];
    return ms === undefined ? [] : [{ name, label, ms }];
  });
}

const length = 1000; // of the bar, in units of the picture

export function timesOf(timings: Timings): Element[] {
  const stages = stageTimes(timings);
  const sum = stages.reduce((total, { ms }) => total + ms, 0);
  if (sum === 0) return [h("p", { class: "hint" }, "No time was spent.")];
  return [bar(stages, sum), table(stages, sum, timings.total)];
}

function bar(stages: StageTime[], sum: number): SVGSVGElement {
  const words = stages.map(({ label, ms }) => `${label} ${inTime(ms)}`).join(", ");
  const picture = svg("svg", {
    class: "stage-bar",
    viewBox: `0 0 ${String(length)} 20`,
    preserveAspectRatio: "none",
    role: "img",
    "aria-label": `Time of each stage: ${words}`,
  });
  let x = 0;
  for (const { name, ms } of stages) {
    const width = (ms / sum) * length;
    picture.append(svg("rect", { x, y: 0, width, height: 20, class: `stage-${name}` }));
    x += width;
  }
  return picture;
}

function table(stages: StageTime[], sum: number, total: number): HTMLElement {
  const rows = stages.map(({ name, label, ms }) =>
    h(
      "tr",
      {},
      h("th", { scope: "row" }, swatch(name), label),
      h("td", { class: "number" }, inTime(ms)),
      h("td", { class: "number" }, shareWords(ms / sum)),
    ),
  );
  const last = h("tr", { class: "total" }, h("th", { scope: "row" }, "From beginning to end"), h("td", { class: "number" }, inTime(total)), h("td"));
  const head = h("thead", {}, h("tr", {}, h("th", { scope: "col" }, "Stage"), h("th", { scope: "col", class: "number" }, "Time"), h("th", { scope: "col", class: "number" }, "Share")));
  return scroller("Time of each stage", h("table", {}, h("caption", { class: "unseen" }, "Time of each stage"), head, h("tbody", {}, ...rows, last)));
}

const shareWords = (share: number): string => (share > 0 && share < 5e-4 ? "<\u00A00.1\u00A0%" : inPercent(share, share < 0.01 ? 1 : 3));

function swatch(name: string): SVGSVGElement {
  return svg("svg", { class: "swatch", viewBox: "0 0 10 10", width: 10, height: 10, "aria-hidden": "true" }, svg("rect", { width: 10, height: 10, rx: 2, class: `stage-${name}` }));
}
