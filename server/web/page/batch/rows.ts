// The comparisons of a batch as rows of its list: their content, their order, and where they come from.
import type { Batch, BatchCounts, BatchFailure, BatchResult } from "../api/types.js";
import { sidesOf } from "../form/options.js";
import { seenName } from "../text/names.js";
import { inPercent, plain, withUnits } from "../text/numbers.js";
import { asSentence } from "../text/problems.js";
import { unitOf } from "../text/verdict.js";

/** Outcome of a comparison. `measured`: an interval without a limit; `gone`: its result was removed. */
export type Kind = "fail" | "error" | "undecided" | "cancelled" | "gone" | "pass" | "measured";

/** `open`: ended without passing; the service lists these first. */
export type Filter = "open" | "all" | Kind;

export interface Row {
  position: number; // in the manifest, from 0
  name: string;
  id: string | null; // of the comparison; null: it was removed
  kind: Kind;
  distance: { lower: number; upper: number | null } | null;
  limit: number | null; // of the distance
  limits: string; // all of the gate; "": none
  units: string;
  words: string; // why there is no interval
}

/** In the order of the list and of the bar. */
export const kinds: readonly Kind[] = ["fail", "error", "undecided", "cancelled", "gone", "pass", "measured"];
const open = new Set<Kind>(["fail", "error", "undecided", "cancelled"]);

export function rowOfFailure(failure: BatchFailure): Row {
  return rowOf(failure, failure.distance, failure.gate, failure.unit);
}

export function rowOfResult(result: BatchResult): Row {
  return rowOf(result, result.result?.distance ?? null, result.result?.gate ?? null, result.result ? unitOf(result.result) : null);
}

function rowOf(
  of: Pick<BatchResult, "position" | "name" | "comparison" | "state" | "verdict" | "problem">,
  distance: Row["distance"],
  gate: BatchFailure["gate"],
  unit: BatchFailure["unit"],
): Row {
  const kind = kindOf(of.state, of.verdict);
  return {
    position: of.position,
    name: seenName(of.name) ?? `Comparison ${String(of.position)}`,
    id: of.comparison,
    kind,
    distance,
    limit: gate?.max_distance ?? null,
    limits: gate ? limitsOf(gate, unit ?? "") : "",
    units: unit ?? "",
    words: kind === "gone" ? "Its result is not kept any more." : asSentence(of.problem?.detail ?? ""),
  };
}

function limitsOf(gate: NonNullable<BatchFailure["gate"]>, units: string): string {
  const { max_distance, max_share_beyond: area } = gate, sides = sidesOf(gate);
  const length = (x: number) => withUnits(plain(x), units);
  return [
    ...(max_distance === null ? [] : [length(max_distance)]),
    ...(sides ? [`${length(sides.inside)} inside`, `${length(sides.outside)} outside`] : []),
    ...(area ? [`${inPercent(area.share)} beyond ${length(area.distance)}`] : []),
  ].join(", ");
}

function kindOf(state: BatchResult["state"], verdict: BatchResult["verdict"]): Kind {
  if (state === "done") return verdict ?? "measured";
  return state === "failed" ? "error" : state;
}

/** Returns the number of rows of each filter. */
export function tally(counts: BatchCounts): Record<Filter, number> {
  const { total, queued, running, done, failed, cancelled, gone, pass, fail, undecided } = counts;
  return {
    open: fail + failed + undecided + cancelled,
    all: total - queued - running,
    fail,
    error: failed,
    undecided,
    cancelled,
    gone,
    pass,
    measured: done - pass - fail - undecided,
  };
}

/** Orders rows: those that did not pass first, by kind; each kind in the order of the manifest. */
export function inOrder(rows: readonly Row[]): Row[] {
  const rank = (row: Row): number => Math.min(kinds.indexOf(row.kind), kinds.indexOf("pass"));
  return [...rows].sort((one, other) => rank(one) - rank(other) || one.position - other.position);
}

/** `search`: text that the name has to contain, ignoring case. */
export function select(rows: readonly Row[], filter: Filter, search: string): Row[] {
  const wanted = search.trim().toLowerCase();
  return rows.filter((row) => fits(row.kind, filter) && (wanted === "" || row.name.toLowerCase().includes(wanted)));
}

function fits(kind: Kind, filter: Filter): boolean {
  return filter === "all" || (filter === "open" ? open.has(kind) : filter === kind);
}

export interface Shown {
  rows: Row[]; // of the requested page
  total: number; // rows on all pages
  complete: boolean; // false: not all rows are read yet
}

const leastRestMs = 3000;
const restFactor = 10;
const reportEveryMs = 250; // while all rows are read

/**
 * The source of a batch's rows. Its document has the first hundred that did not pass; all rows are read only when more than
 * these are shown. While the batch runs they are read again, so rarely that reading takes a tenth of the time.
 */
export class RowSource {
  private batch: Batch;
  private failures: Row[] = [];
  private whole: Row[] = []; // all rows, in order
  private wholeOf = -1; // how many comparisons had ended when all rows were read; -1: never read
  private restUntil = 0; // as performance.now()
  private reading = false;
  /** Number of rows read so far, while all are read for the first time. */
  readSoFar: number | null = null;

  /** `read` yields all ended comparisons in portions. `changed` is called when there is more to show. */
  constructor(
    batch: Batch,
    private readonly read: (signal: AbortSignal) => AsyncIterable<BatchResult[]>,
    public changed: () => void = () => undefined,
  ) {
    this.batch = batch;
    this.take(batch);
  }

  /** Sets the batch's newest document. */
  take(batch: Batch): void {
    this.batch = batch;
    this.failures = batch.failures.map(rowOfFailure);
  }

  counts(): Record<Filter, number> {
    return tally(this.batch.counts);
  }

  shown(filter: Filter, search: string, from: number, most: number): Shown {
    const count = this.counts()[filter];
    const page = (rows: Row[], total: number, complete: boolean): Shown => ({ rows: rows.slice(from, from + most), total, complete });
    const first = select(this.failures, filter, "");
    const enough = search.trim() === "" ? Math.min(count, from + most) : count;
    const found = select(this.failures, filter, search);
    if (first.length >= enough) return page(found, search.trim() === "" ? count : found.length, true);
    const all = select(this.whole, filter, search);
    const rows = this.wholeOf < 0 && all.length < found.length ? found : all;
    return page(rows, search.trim() === "" ? Math.max(count, rows.length) : rows.length, this.wholeOf >= this.counts().all);
  }

  /** Reads all rows, unless it is doing so or has just done so. Returns the ms until it should be called again, else 0. Throws as `read`. */
  async load(signal: AbortSignal): Promise<number> {
    const rest = this.restUntil - performance.now();
    if (this.reading) return leastRestMs;
    if (this.wholeOf >= 0 && rest > 0 && this.batch.state === "running") return rest;
    const began = performance.now();
    this.reading = true;
    try {
      await this.readAll(signal);
    } finally {
      this.reading = false;
      this.readSoFar = null;
      this.restUntil = performance.now() + Math.max(leastRestMs, restFactor * (performance.now() - began));
    }
    this.changed();
    return 0;
  }

  private async readAll(signal: AbortSignal): Promise<void> {
    const rows: Row[] = [];
    const ended = this.counts().all; // at least this many are read
    let reported = performance.now();
    for await (const some of this.read(signal)) {
      rows.push(...some.map(rowOfResult));
      if (this.wholeOf >= 0 || performance.now() < reported + reportEveryMs) continue;
      reported = performance.now();
      this.readSoFar = rows.length;
      this.whole = inOrder(rows);
      this.changed();
    }
    this.whole = inOrder(rows);
    this.wholeOf = Math.max(ended, rows.length);
  }
}
