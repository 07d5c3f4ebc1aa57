import assert from "node:assert/strict";
import { test } from "node:test";
import type { Batch, BatchCounts, BatchFailure, BatchResult } from "../../../server/web/page/api/types.js";
import { partsOf } from "../../../server/web/page/batch/batch.js";
import { listStateOf } from "../../../server/web/page/batch/list.js";
import { inOrder, rowOfFailure, rowOfResult, RowSource, select, tally } from "../../../server/web/page/batch/rows.js";
import { lasting, nameOf, pageWords, titleOf, wordsOf } from "../../../server/web/page/batch/words.js";
import { scaleFor } from "../../../server/web/page/plot/strip.js";
import { positionOf } from "../../../server/web/page/plot/axis.js";
import { areaGate, comparison, gate } from "./samples.js";

const id = "0d67c9a2d1b307386f8fc157855c4351";
const never = new AbortController().signal;
const none: BatchCounts = { total: 1, queued: 0, running: 0, done: 0, failed: 0, cancelled: 0, gone: 0, pass: 0, fail: 0, undecided: 0 };
const counts = (change: Partial<BatchCounts>): BatchCounts => ({ ...none, ...change });

const result = (position: number, change: Partial<BatchResult> = {}): BatchResult => ({
  position, name: `part ${String(position)}`, comparison: id, state: "done", verdict: "pass", result: comparison({ gate: gate(0.5) }), problem: null, ...change,
});
const cancelled = { type: "/problems/cancelled", title: "Cancelled", status: 409, detail: "it was cancelled", errors: [] } as unknown as BatchResult["problem"];
const failure = (position: number, change: Partial<BatchFailure> = {}): BatchFailure => ({
  position, name: null, comparison: id, state: "done", verdict: "fail", gate: gate(0.05), unit: "mm", distance: { lower: 0.1, upper: 0.2 }, problem: null, ...change,
});
const batch = (change: Partial<BatchCounts>, failures: BatchFailure[] = [], state: Batch["state"] = "done"): Batch => ({
  id, name: "nightly", state, created: "2026-03-01T12:00:00.000Z", finished: state === "running" ? null : "2026-03-01T12:00:09.000Z",
  expires: null, counts: counts(change), failures, running: [],
});

test("a line of the results and a failure are the same row", () => {
  const line = result(3, { name: null, verdict: "fail", result: comparison({ gate: gate(0.05), distance: { lower: 0.1, upper: 0.2 } }) });
  assert.deepEqual(rowOfResult(line), rowOfFailure(failure(3)));
  assert.deepEqual(rowOfResult(line), {
    position: 3, name: "Comparison 3", id, kind: "fail", distance: { lower: 0.1, upper: 0.2 }, limit: 0.05, limits: "0.05\u00A0mm", units: "mm", words: "",
  });
});

test("a row shows all limits of its gate", () => {
  const limits = (gate: BatchFailure["gate"]) => rowOfFailure(failure(0, { gate })).limits;
  assert.equal(limits(null), "");
  assert.equal(limits(areaGate), "1\u00A0% beyond 0.05\u00A0mm");
  assert.equal(limits({ ...gate(0.5), zone: [-0.05, 0.1] }), "0.5\u00A0mm, 0.05\u00A0mm inside, 0.1\u00A0mm outside");
});

test("outcomes of a comparison", () => {
  const kindOf = (change: Partial<BatchResult>) => rowOfResult(result(0, change)).kind;
  assert.equal(kindOf({}), "pass");
  assert.equal(kindOf({ verdict: null }), "measured");
  assert.equal(kindOf({ state: "failed", verdict: null, result: null }), "error");
  assert.equal(kindOf({ state: "cancelled", verdict: "undecided" }), "cancelled");
  const gone = rowOfResult(result(0, { state: "gone", comparison: null, result: null, verdict: null }));
  assert.deepEqual([gone.kind, gone.id, gone.words], ["gone", null, "Its result is not kept any more."]);
  assert.equal(rowOfResult(result(0, { state: "cancelled", result: null, problem: cancelled })).words, "It was cancelled.");
});

test("an invisible name is dropped, and a name that changes the text direction affects only itself", () => {
  for (const name of ["  ", "\u200B\u202E", "\u00A0", ""]) assert.equal(rowOfResult(result(7, { name })).name, "Comparison 7", JSON.stringify(name));
  for (const name of ["é", "部品", "…", "👍"]) assert.equal(rowOfResult(result(7, { name })).name, name);
  assert.equal(nameOf({ ...batch({}), name: " \t" }), null);
  assert.equal(titleOf("\u202Eyl", { state: "done", counts: counts({ done: 1, pass: 1 }) }), "Pass: yl · meshgauge");
});

test("one of 10,000 is visible in the bar", () => {
  const parts = partsOf(counts({ total: 10_000, done: 9_999, queued: 1, fail: 1, pass: 9_998 }));
  assert.deepEqual(parts.map(({ kind }) => kind), ["fail", "pass", "waits"]);
  let end = 0;
  for (const { x, width } of parts) {
    assert.ok(Math.abs(x - end) < 1e-9 && width >= 4, `${String(x)}, ${String(width)}`);
    end = x + width;
  }
  assert.ok(Math.abs(end - 1000) < 1e-9, String(end));
  assert.deepEqual(partsOf(counts({ total: 3, queued: 3 })), [{ kind: "waits", x: 0, width: 1000 }]);
});

test("counts are those of the filters", () => {
  const so = tally(counts({ total: 30, queued: 3, running: 2, done: 15, failed: 4, cancelled: 5, gone: 1, pass: 7, fail: 3, undecided: 1 }));
  assert.deepEqual(so, { open: 13, all: 25, fail: 3, error: 4, undecided: 1, cancelled: 5, gone: 1, pass: 7, measured: 4 });
});

test("what did not pass comes first, each kind in the order of the manifest", () => {
  const lines = [
    result(0), result(1, { verdict: "undecided" }), result(2, { verdict: null }), result(3, { verdict: "fail" }),
    result(4, { state: "failed", result: null }), result(5, { state: "cancelled", result: null }), result(6, { verdict: "fail" }), result(7),
  ];
  const rows = inOrder(lines.map(rowOfResult));
  assert.deepEqual(rows.map(({ position }) => position), [3, 6, 4, 1, 5, 0, 2, 7]);
  assert.deepEqual(select(rows, "open", "").map(({ position }) => position), [3, 6, 4, 1, 5]);
  assert.deepEqual(select(rows, "all", " PART 7").map(({ position }) => position), [7]);
  assert.deepEqual(select(rows, "pass", "part").map(({ position }) => position), [0, 7]);
});

function source(of: Batch, lines: BatchResult[][] = []) {
  const read: number[] = [];
  let changes = 0;
  const made = new RowSource(of, async function* () {
    read.push(lines.length);
    for (const some of lines) yield await Promise.resolve(some);
  }, () => void ++changes);
  return { made, read, changes: () => changes };
}

test("the results are not read while the document's failures suffice", () => {
  const { made } = source(batch({ total: 10_000, done: 10_000, pass: 9998, fail: 2 }, [failure(4), failure(9)]));
  const { rows, total, complete } = made.shown("open", "", 0, 50);
  assert.deepEqual([rows.map(({ position }) => position), total, complete], [[4, 9], 2, true]);
  assert.ok(made.shown("fail", "comparison 9", 0, 50).complete);
  assert.ok(made.shown("error", "", 0, 50).complete);
  assert.ok(!made.shown("all", "", 0, 50).complete);
  assert.equal(made.shown("pass", "", 0, 50).total, 9998);
});

test("with more failures than the document has, the first pages are there and a search reads all", () => {
  const first = Array.from({ length: 100 }, (_, i) => failure(i));
  const { made } = source(batch({ total: 300, done: 300, fail: 300 }, first));
  assert.ok(made.shown("fail", "", 50, 50).complete);
  assert.ok(made.shown("all", "", 50, 50).complete);
  assert.ok(!made.shown("fail", "", 100, 50).complete);
  assert.ok(!made.shown("fail", "comparison 1", 0, 50).complete);
  assert.equal(made.shown("fail", "", 100, 50).total, 300);
});

test("all results are read once, with progress", async () => {
  const { made, read, changes } = source(batch({ total: 3, done: 3, pass: 2, fail: 1 }, [failure(1)]), [[result(0), result(1, { verdict: "fail" })], [result(2)]]);
  assert.equal(await made.load(never), 0);
  assert.equal(changes(), 1);
  const { rows, total, complete } = made.shown("all", "", 0, 50);
  assert.deepEqual([rows.map(({ position }) => position), total, complete], [[1, 0, 2], 3, true]);
  assert.deepEqual(made.shown("pass", "2", 0, 50).rows.map(({ position }) => position), [2]);
  assert.deepEqual(read, [2]);
});

test("while the batch runs the results are read again after a pause", async () => {
  const lines = [[result(0)]];
  const { made, read } = source(batch({ total: 9, running: 8, done: 1, pass: 1 }, [], "running"), lines);
  await made.load(never);
  assert.ok(made.shown("pass", "", 0, 50).complete);
  made.take(batch({ total: 9, running: 7, done: 2, pass: 2 }, [], "running"));
  const stale = made.shown("pass", "", 0, 50);
  assert.deepEqual([stale.rows.length, stale.total, stale.complete], [1, 2, false]);
  const wait = await made.load(never);
  assert.ok(wait > 0 && wait <= 3000, String(wait));
  assert.equal(read.length, 1);
  made.take(batch({ total: 9, done: 9, pass: 9 }));
  lines.push([result(1)]);
  assert.equal(await made.load(never), 0);
  assert.equal(read.length, 2);
});

test("a broken stream of results is reported and retried", async () => {
  let tries = 0;
  const made = new RowSource(batch({ total: 2, done: 2, pass: 2 }), async function* () {
    yield await Promise.resolve([result(tries)]);
    if (++tries === 1) throw new Error("broken");
  });
  await assert.rejects(made.load(never), /broken/);
  assert.ok(!made.shown("all", "", 0, 50).complete);
  await made.load(never);
  assert.ok(made.shown("all", "", 0, 50).complete);
});

test("words for a running and an ended batch", () => {
  const at = (state: Batch["state"], change: Partial<BatchCounts>) => wordsOf({ state, counts: counts(change) });
  assert.deepEqual(at("running", { total: 10_000, queued: 9000, running: 1, done: 999, pass: 999 }), {
    tone: "measured", heading: "999 of 10,000 compared", reason: "All well so far. 1 runs, 9,000 wait.",
  });
  assert.equal(at("running", { total: 5, queued: 1, running: 1, done: 3, pass: 2 }).reason, "1 runs, 1 waits."); // one has no limit
  assert.equal(at("running", { total: 5, running: 2, done: 2, pass: 2, gone: 1 }).reason, "1 is not kept any more so far. 2 run, 0 wait.");
  assert.deepEqual(at("running", { total: 5, queued: 1, running: 2, done: 1, failed: 1, fail: 1 }), {
    tone: "fail", heading: "2 of 5 compared", reason: "1 fails, 1 could not be measured so far. 2 run, 1 waits.",
  });
  assert.equal(at("running", { total: 5, queued: 5 }).reason, "0 run, 5 wait.");
  assert.deepEqual(at("done", { total: 1200, done: 1200, pass: 1200 }), { tone: "pass", heading: "Pass", reason: "All 1,200 comparisons pass." });
  assert.deepEqual(at("done", { total: 4, done: 3, failed: 1, pass: 2, fail: 1 }), {
    tone: "fail", heading: "Fail", reason: "1 fails, 1 could not be measured, 2 pass.",
  });
  const headings: [Batch["state"], Partial<BatchCounts>, string][] = [
    ["done", { failed: 1 }, "Error"], ["done", { done: 1, undecided: 1 }, "Undecided"], ["cancelled", { cancelled: 1 }, "Cancelled"],
    ["cancelled", { total: 2, cancelled: 1, done: 1, fail: 1 }, "Fail"], ["done", { gone: 1 }, "Not all is kept"], ["done", { done: 1 }, "Measured"],
  ];
  for (const [state, change, heading] of headings) assert.equal(at(state, change).heading, heading);
  assert.equal(titleOf("nightly", { state: "done", counts: counts({ total: 1, done: 1, pass: 1 }) }), "Pass: nightly · meshgauge");
});

test("durations and page numbers", () => {
  assert.deepEqual([-5, 400, 12_900, 125_000, 12_000_000].map(lasting), ["0.0\u00A0s", "0.4\u00A0s", "12\u00A0s", "2\u00A0min 05\u00A0s", "3\u00A0h 20\u00A0min"]);
  assert.equal(pageWords(50, 50, 1234), "51 to 100 of 1,234");
  assert.equal(pageWords(0, 0, 0), "None");
});

test("the list's state is read from the history, anything else is ignored", () => {
  const listState = { filter: "pass", search: "x", from: 50, opened: 7 };
  assert.deepEqual(listStateOf({ listState }), listState);
  const fresh = { filter: null, search: "", from: 0, opened: null };
  for (const state of [null, 7, {}, { listState: { filter: "toString", search: 1, from: -1, opened: 0.5 } }]) assert.deepEqual(listStateOf(state), fresh);
});

test("the scale of all rows: limits one below the other, and far ones at its ends", () => {
  const scale = scaleFor([{ lower: 0.1, upper: 0.2, limit: 0.5 }, { lower: 1e6, upper: null, limit: 1 }, { lower: 0, upper: 1, limit: null }, { lower: 1, upper: 2, limit: 0 }]);
  assert.ok(scale?.relative);
  const at = positionOf(scale.axis, 1);
  assert.ok(at > 0.1 && at < 0.9);
  assert.ok(positionOf(scale.axis, 0.2) < at);
  assert.equal(positionOf(scale.axis, null), 1);
  assert.equal(scaleFor([{ lower: 1, upper: 2, limit: null }])?.relative, false);
  assert.equal(scaleFor([]), null);
});
