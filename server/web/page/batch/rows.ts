// The comparisons of a batch as rows of its list: their content and their order.
import type { BatchCounts, BatchFailure, BatchResult } from "../api/types.js";
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

const order: readonly Kind[] = ["fail", "error", "undecided", "cancelled", "gone", "pass", "measured"];
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

function limitsOf({ max_distance, max_share_beyond: area, zone }: NonNullable<BatchFailure["gate"]>, units: string): string {
  const length = (x: number) => withUnits(plain(x), units);
  return [
    ...(max_distance === null ? [] : [length(max_distance)]),
    ...(zone ? [`${length(0 - zone[0])} inside`, `${length(zone[1])} outside`] : []),
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
  const rank = (row: Row): number => Math.min(order.indexOf(row.kind), order.indexOf("pass"));
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
