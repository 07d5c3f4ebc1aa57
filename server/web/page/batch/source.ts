// The source of a batch's rows. Its document has the first hundred that did not pass; all rows are read only when more than
// these are shown. While the batch runs they are read again, so rarely that reading takes a tenth of the time.
import type { Batch, BatchResult } from "../api/types.js";
import { inOrder, rowOfFailure, rowOfResult, select, tally, type Filter, type Row } from "./rows.js";

export interface Shown {
  rows: Row[]; // of the requested page
  total: number; // rows on all pages
  complete: boolean; // false: not all rows are read yet
}

const leastRestMs = 3000;
const restFactor = 10;
const reportEveryMs = 250; // while all rows are read

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
