// The meaning of a batch's state, in sentences.
import type { Batch, BatchProgressEvent } from "../api/types.js";
import { seenName, withoutOverrides } from "../text/names.js";
import { grouped } from "../text/numbers.js";
import type { Tone } from "../text/verdict.js";
import { kinds, tally, type Filter, type Kind } from "./rows.js";

export interface BatchWords {
  tone: Tone;
  heading: string;
  reason: string;
}

export const filterWords: Record<Filter, string> = {
  open: "Not passed",
  all: "All",
  fail: "Fail",
  error: "Error",
  undecided: "Undecided",
  cancelled: "Cancelled",
  gone: "Not kept",
  pass: "Pass",
  measured: "Measured",
};

export const toneOf: Record<Kind, Tone> = {
  fail: "fail", error: "fail", undecided: "undecided", cancelled: "measured", gone: "measured", pass: "pass", measured: "measured",
};

/** null: it has none. */
export function nameOf(batch: Batch): string | null {
  return seenName(batch.name);
}

export function wordsOf(now: BatchProgressEvent): BatchWords {
  return now.state === "running" ? whileRunning(now) : atTheEnd(now);
}

function whileRunning({ counts }: BatchProgressEvent): BatchWords {
  const so = tally(counts);
  const tone = counts.fail + counts.failed > 0 ? "fail" : counts.undecided > 0 ? "undecided" : "measured";
  const found = sentence(counted(so).filter(([kind]) => kind !== "pass" && kind !== "measured"));
  const ahead = `${grouped(counts.running)} ${counts.running === 1 ? "runs" : "run"}, ${grouped(counts.queued)} ${counts.queued === 1 ? "waits" : "wait"}.`;
  const well = so.all > 0 && so.pass === so.all ? "All well so far. " : "";
  const reason = found === "" ? `${well}${ahead}` : `${found} so far. ${ahead}`;
  return { tone, heading: `${grouped(so.all)} of ${grouped(counts.total)} compared`, reason };
}

function atTheEnd({ state, counts }: BatchProgressEvent): BatchWords {
  const all = tally(counts);
  const wordsFor = (tone: Tone, heading: string): BatchWords => ({ tone, heading, reason: `${sentence(counted(all))}.` });
  if (counts.fail > 0) return wordsFor("fail", "Fail");
  if (counts.failed > 0) return wordsFor("fail", "Error");
  if (state === "cancelled") return wordsFor("undecided", "Cancelled");
  if (counts.undecided > 0) return wordsFor("undecided", "Undecided");
  if (counts.cancelled > 0) return wordsFor("undecided", "Cancelled");
  if (counts.gone > 0) return wordsFor("measured", "Not all is kept");
  if (all.measured > 0) return wordsFor("measured", "Measured");
  return { tone: "pass", heading: "Pass", reason: counts.total === 1 ? "The comparison passes." : `All ${grouped(counts.total)} comparisons pass.` };
}

type Counted = [Kind, number];

function counted(so: Record<Filter, number>): Counted[] {
  return kinds.map((kind): Counted => [kind, so[kind]]).filter(([, count]) => count > 0);
}

const one: Record<Kind, string> = {
  fail: "fails", error: "could not be measured", undecided: "is undecided", cancelled: "was cancelled", gone: "is not kept any more",
  pass: "passes", measured: "is measured",
};
const many: Record<Kind, string> = {
  fail: "fail", error: "could not be measured", undecided: "are undecided", cancelled: "were cancelled", gone: "are not kept any more",
  pass: "pass", measured: "are measured",
};

/** "7 fail, 1 is undecided, 9,992 pass" */
function sentence(parts: Counted[]): string {
  return parts.map(([kind, count]) => `${grouped(count)} ${(count === 1 ? one : many)[kind]}`).join(", ");
}

/** The title of the browser's tab. */
export function titleOf(name: string | null, now: BatchProgressEvent): string {
  const { heading } = wordsOf(now);
  return `${heading}: ${withoutOverrides(name ?? "Batch")} · meshgauge`;
}

/** Formats the duration of a batch: "0.4 s", "12 s", "2 min 05 s", "3 h 20 min". */
export function lasting(ms: number): string {
  const seconds = Math.max(0, ms) / 1000;
  if (seconds < 10) return `${seconds.toFixed(1)}\u00A0s`;
  const two = (count: number): string => String(Math.floor(count)).padStart(2, "0");
  if (seconds < 60) return `${String(Math.floor(seconds))}\u00A0s`;
  if (seconds < 3600) return `${String(Math.floor(seconds / 60))}\u00A0min ${two(seconds % 60)}\u00A0s`;
  return `${String(Math.floor(seconds / 3600))}\u00A0h ${two((seconds % 3600) / 60)}\u00A0min`;
}

/** "1 to 50 of 312" */
export function pageWords(from: number, shown: number, total: number): string {
  if (total === 0) return "None";
  return `${grouped(from + 1)} to ${grouped(from + shown)} of ${grouped(total)}`;
}
