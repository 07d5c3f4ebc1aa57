// The meaning of a result in sentences, in the words of `meshgauge check`.
import type { Comparison, Direction, Side, Status, Verdict } from "../api/types.js";
import {
  criteriaOf, decidingLimit, foremostOf, isLimit, placeWords, plusMinus, shownLimit, whyOpen, witnessesOf, type Criterion, type Limit,
} from "./criteria.js";
import { capital, withoutOverrides } from "./names.js";
import { inPercent, inTime, intervalText, intervalWords, plain, pointText, toDigitsBelow, withUnits } from "./numbers.js";

export type Tone = "pass" | "fail" | "undecided" | "measured";

export interface Wording {
  tone: Tone;
  heading: string; // "Fail"
  reason: string; // why, with the numbers
  proof: string; // what makes it certain, or would
}

export const meshName: Record<Side, string> = { a: "candidate (A)", b: "baseline (B)" };

/** What a mesh is measured by: a cloud by its points. */
export const pieceOf = (result: Comparison, side: Side): string => (result.meshes[side].triangles === 0 ? "point" : "triangle");

/** A document that states its unit, or none, as results made before 0.2.0. */
interface OfUnit {
  unit?: Pick<Comparison["unit"], "name">;
}

/** The unit of all lengths of the result; null: unknown. */
export function unitOf({ unit }: OfUnit): Comparison["unit"]["name"] {
  return unit?.name ?? null;
}

/** The same as text; "": unknown. */
export function unitsOf(result: OfUnit): string {
  return unitOf(result) ?? "";
}

/** Notes of the pair. Results made before 0.2.0 have none. */
export function pairNotes({ notes }: { notes?: string[] }): string[] {
  return notes ?? [];
}

const headings: Record<Verdict, string> = { pass: "Pass", fail: "Fail", undecided: "Undecided" };
const one: Record<Verdict, string> = { pass: "passes", fail: "fails", undecided: "is undecided" };
const several: Record<Verdict, string> = { pass: "pass", fail: "fail", undecided: "are undecided" };
const mostOthers = 3; // criteria said after the foremost; all are in the table

/** `timeoutMs`: the time limit that was asked for, if it is known. */
export function wordingOf(result: Comparison, timeoutMs: number | null = null): Wording {
  const { verdict } = result, first = foremostOf(result);
  if (verdict === null || !first) return withoutGate(result, timeoutMs);
  const { reason, proof } = wordsOf(first, result, timeoutMs);
  const others = criteriaOf(result).filter((other) => other.name !== first.name && other.verdict === verdict);
  const more = others.length - mostOthers;
  const said = others.slice(0, mostOthers).map(({ finding }) => sentenceOf(finding)).filter((sentence) => sentence !== reason);
  if (more > 0) said.push(`${String(more)} more ${more === 1 ? one[verdict] : several[verdict]}.`);
  return { tone: verdict, heading: headings[verdict], reason: [reason, ...said].join(" "), proof };
}

function wordsOf(criterion: Criterion, result: Comparison, timeoutMs: number | null): Pick<Wording, "reason" | "proof"> {
  const { verdict, finding } = criterion;
  if (!isLimit(criterion)) return { reason: `Of the candidate (A) itself: ${withoutOverrides(finding)}.`, proof: "" };
  if (criterion.of === "share") return { reason: sentenceOf(finding), proof: areaProofs[verdict] };
  if (criterion.refused) return { reason: sentenceOf(finding), proof: "" };
  const words = verdict === "pass" ? forPass(criterion, result) : verdict === "fail" ? forFail(criterion, result) : forUndecided(criterion, result, timeoutMs);
  const place = withoutOverrides(placeWords(criterion));
  return place === "" ? words : { ...words, reason: place + words.reason.charAt(0).toLowerCase() + words.reason.slice(1) };
}

const sentenceOf = (finding: string): string => `${capital(withoutOverrides(finding))}.`;

const areaProofs: Record<Verdict, string> = {
  pass: "The interval proves it: its upper end is a bound of the exact share, not an estimate from samples.",
  fail: "The interval proves it: its lower end is a bound of the exact share, not an estimate from samples.",
  undecided: "What would decide: more time.",
};

function figures(criterion: Limit, units: string) {
  const { lower, upper, limit } = criterion;
  const text = intervalText(lower, upper, shownLimit(criterion)), more = plusMinus(criterion, units);
  const allowed = withUnits(more ? plain(limit) : text.limit, units) + more;
  return { lower: withUnits(text.lower, units), upper: withUnits(text.upper, units), limit: allowed };
}

function forPass(criterion: Limit, result: Comparison): Pick<Wording, "reason" | "proof"> {
  const { upper, limit } = figures(criterion, unitsOf(result));
  const from = directionOf(criterion, result);
  const where = criterion.side ? `No point of the candidate (A) lies farther than ${limit} ${criterion.side} of the baseline (B)` : `${everyPoint[from]} within ${limit} of ${otherMesh[from]}`;
  return {
    reason: `${where}: at most ${upper}${criterion.side ? "" : " away"}.`,
    proof: "The interval proves it: its upper end is a bound for every point, not the largest of some samples.",
  };
}

// A group is one of the baseline, and measured from it alone.
function directionOf({ region }: Criterion, { regions, direction }: Comparison): Direction {
  return regions?.some(({ name, group }) => name === region && group) ? "b_to_a" : direction;
}

const everyPoint: Record<Direction, string> = {
  symmetric: "Every point of both surfaces lies",
  a_to_b: "Every point of the candidate (A) lies",
  b_to_a: "Every point of the baseline (B) lies",
};

const otherMesh: Record<Direction, string> = {
  symmetric: "the other surface",
  a_to_b: "the baseline (B)",
  b_to_a: "the candidate (A)",
};

function forFail(criterion: Limit, result: Comparison): Pick<Wording, "reason" | "proof"> {
  const units = unitsOf(result), { lower, limit } = figures(criterion, units), { witness, side } = criterion;
  if (!witness) return { reason: side ? sentenceOf(criterion.finding) : `The distance is at least ${lower}; the limit is ${limit}.`, proof: provedFail };
  const other = witness.on === "a" ? "b" : "a";
  const from = side ? `${side} of` : "from";
  const lacking = witness.on === "b" ? ` The ${meshName.a} lacks what the ${meshName.b} has there, or has it elsewhere.` : "";
  return {
    reason:
      `The point ${withUnits(pointText(witness.point), units)} of the ${meshName[witness.on]}, on ${pieceOf(result, witness.on)} ${String(witness.triangle)}, ` +
      `is ${lower} or more ${from} the ${meshName[other]}. The limit is ${limit}.${lacking}`,
    proof: "The interval proves it: its lower end is attained at that point, and is above the limit.",
  };
}

const provedFail = "The interval proves it: its lower end is above the limit.";

function forUndecided(criterion: Limit, result: Comparison, timeoutMs: number | null): Pick<Wording, "reason" | "proof"> {
  const units = unitsOf(result), { lower, upper, limit, side } = criterion;
  const range = intervalWords(lower, upper, units, limit), what = side ? `distance ${side}` : "distance";
  const known = range === "not known yet" ? `Nothing is known of the ${what} yet` : `The ${what} is ${between(range)}`;
  const status = endOf(criterion, result);
  const effort = moreEffort(status, timeoutMs);
  const either = [decidingLimit(criterion, units), effort].filter((one) => one !== "").join(", or ");
  return {
    reason: `${known}, and the limit of ${figures(criterion, units).limit} is not decided by that: ${whyEnded[status]}.`,
    proof: effort === "" ? `Decided by ${either}. ${whyOpen(criterion)}` : `What would decide: ${either}.`,
  };
}

// Work on sides that is complete was as narrow as asked.
function endOf({ status }: Criterion, result: Comparison): Status {
  if (status === "complete") return "converged";
  return status && status in whyEnded ? (status as Status) : result.status;
}

const between = (range: string) => (range.includes(" to ") ? `between ${range.replace(" to ", " and ")}` : range);

const longestTimeoutMs = 180_000;

function moreEffort(status: Status, timeoutMs: number | null): string {
  if (status === "timeout" && timeoutMs !== null && timeoutMs >= longestTimeoutMs) return "more threads or a faster machine";
  if (status === "timeout") return timeoutMs === null ? "more time" : `more time than ${inTime(timeoutMs)}`;
  if (status === "cancelled") return "letting it run to its end";
  if (status === "converged") return "a smaller tolerance";
  if (status === "budget") return "more memory for the pieces that wait";
  return "";
}

const whyEnded: Record<Status, string> = {
  converged: "the interval was as narrow as asked, and the work stopped",
  gate_decided: "the work stopped",
  timeout: "the time was over",
  cancelled: "it was cancelled",
  budget: "the budget was spent",
  precision_floor: "floating point allows no narrower interval",
};

function withoutGate(result: Comparison, timeoutMs: number | null): Wording {
  const { lower, upper } = result.distance;
  const range = intervalWords(lower, upper, unitsOf(result));
  if (range === "not known yet") {
    const effort = moreEffort(result.status, timeoutMs);
    return {
      tone: "measured",
      heading: "Nothing is known yet",
      reason: `The work ended before anything was measured: ${whyEnded[result.status]}.`,
      proof: effort === "" ? "" : `What would help: ${effort}.`,
    };
  }
  const reason = `${subject[result.direction]} is ${between(range)}.${whereFound(result)}`;
  return { tone: "measured", heading: capital(range), reason, proof: statusSentence(result) };
}

// Names the surface on which the difference is visible; with one direction the subject has named it.
function whereFound(result: Comparison): string {
  const [witness] = witnessesOf(result);
  if (!witness || witness.lower === 0 || result.direction !== "symmetric") return "";
  return ` A point that is ${withUnits(toDigitsBelow(witness.lower, 4), unitsOf(result))} or more away lies on the ${meshName[witness.from]}.`;
}

const subject: Record<Direction, string> = {
  symmetric: "The largest distance from any point of one surface to the other",
  a_to_b: "The largest distance from any point of the candidate (A) to the baseline (B)",
  b_to_a: "The largest distance from any point of the baseline (B) to the candidate (A)",
};

/** Why the work ended, and what holds nevertheless. */
export function statusSentence(result: Comparison): string {
  const { reached, met_by } = result.tolerance;
  if (result.status === "converged" && met_by === "relative" && reached.relative !== null)
    return `The interval is as narrow as asked: ${inPercent(reached.relative, 2)} of the distance.`;
  if (result.status === "converged") return "The interval is as narrow as asked.";
  if (result.status === "gate_decided") return "The limit was decided before the interval was as narrow as asked. Without a limit it gets as narrow as asked.";
  return `${capital(whyEnded[result.status])}. The interval reached so far is still valid.`;
}

/** The title of the browser's tab. */
export function titleOf(result: Comparison): string {
  const { tone, heading } = wordingOf(result), first = foremostOf(result);
  const { lower, upper } = result.distance;
  return `${tone === "measured" || !first ? intervalWords(lower, upper, unitsOf(result)) : `${heading}: ${shortWords(first, result)}`} · meshgauge`;
}

/** "0.0968 to 0.0976 mm", "distance in bore 0.5 to 0.6 mm", "watertight" */
function shortWords(criterion: Criterion, result: Comparison): string {
  const name = criterion.name === "distance" ? "" : withoutOverrides(criterion.name);
  return [name, rangeOf(criterion, result)].filter((one) => one !== "").join(" ");
}

/** What is known of a limit, as "0.0968 to 0.0976 mm" or "0.21 to 0.27 %"; "" of an expectation. */
export function rangeOf(criterion: Criterion, result: Comparison): string {
  if (!isLimit(criterion)) return "";
  if (criterion.refused) return "no sides";
  const { lower, upper, limit } = criterion;
  if (criterion.of !== "share") return intervalWords(lower, upper, unitsOf(result), shownLimit(criterion));
  return upper === null ? "" : intervalWords(100 * lower, 100 * upper, "%", 100 * limit);
}
