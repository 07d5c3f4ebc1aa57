// The meaning of a result in sentences, in the words of `meshgauge check`.
import type { Comparison, Direction, Directed, Side, Status, Vec3, Verdict } from "../api/types.js";
import { inPercent, inTime, intervalText, intervalWords, plain, pointText, toDigitsAbove, toDigitsBelow, withUnits } from "./numbers.js";
import { ofRest, regionsSentence } from "./regions.js";

export type Tone = "pass" | "fail" | "undecided" | "measured";

export interface Wording {
  tone: Tone;
  heading: string; // "Fail"
  reason: string; // why, with the numbers
  proof: string; // what makes it certain, or would
}

export const meshName: Record<Side, string> = { a: "candidate (A)", b: "baseline (B)" };

/** A point at least `lower` away from the other mesh. */
export interface FoundWitness {
  from: Side;
  point: Vec3;
  nearest: Vec3;
  lower: number;
  upper: number;
  triangle: number;
  nearestTriangle: number;
}

/** What a mesh is measured by: a cloud by its points. */
export const pieceOf = (result: Comparison, side: Side): string => (result.meshes[side].triangles === 0 ? "point" : "triangle");

/** One per direction that has one; the first attains the lower end of the interval. */
export function witnessesOf(result: Comparison): FoundWitness[] {
  const found = [witnessOf("a", result.a_to_b), witnessOf("b", result.b_to_a)].filter((one) => one !== null);
  return found.sort((one, other) => other.lower - one.lower);
}

/** The same, but first the point of a limit that is not kept, which may be a region's. */
export function witnessesToShow(result: Comparison): FoundWitness[] {
  const found = witnessesOf(result), first = result.verdict === "pass" ? null : foremostWitness(result);
  return first ? [first, ...found.filter(({ from }) => from !== first.from)] : found;
}

// Results made before 0.2.0 have no criteria; a side's point has no nearest one.
function foremostWitness({ verdict, foremost, criteria = [] }: Pick<Comparison, "verdict"> & Partial<Pick<Comparison, "foremost" | "criteria">>): FoundWitness | null {
  const worst = criteria.filter((one) => one.verdict === verdict && one.witness?.nearest_point);
  const shown = worst.find(({ name }) => name === foremost) ?? worst[0], at = shown?.witness;
  if (!at?.nearest_point || at.nearest_triangle === null) return null;
  const { on, point, triangle, nearest_point, nearest_triangle } = at;
  return { from: on, point, nearest: nearest_point, lower: shown?.lower ?? 0, upper: shown?.upper ?? Infinity, triangle, nearestTriangle: nearest_triangle };
}

function witnessOf(from: Side, directed: Directed | null): FoundWitness | null {
  if (!directed?.witness) return null;
  const { point_a, point_b, triangle_a, triangle_b } = directed.witness;
  const { lower, upper } = directed;
  return {
    from,
    point: point_a,
    nearest: point_b,
    lower,
    upper: upper ?? Infinity,
    triangle: triangle_a,
    nearestTriangle: triangle_b,
  };
}

/** The unit of a limit before there is a result; "b" stands for the unit of mesh b, which is not known yet. */
export function unitAsked(units: string | null | undefined): string {
  return units === "b" ? "" : (units ?? "");
}

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

/** `timeoutMs`: the time limit that was asked for, if it is known. */
export function wordingOf(result: Comparison, timeoutMs: number | null = null): Wording {
  const { verdict } = result;
  if (verdict === null) return withoutGate(result, timeoutMs);
  const others = [regionsSentence(result, unitsOf(result)), zoneSentence(result), areaSentence(result), expectationsSentence(result)].filter((one) => one !== "").join(" ");
  const rest = ofRest(result);
  if (verdict !== distanceVerdict(rest)) return { tone: verdict, heading: headings[verdict], reason: others, proof: result.regions || result.gate?.zone || result.expectations ? "" : areaProofs[verdict] };
  const words = verdict === "pass" ? forPass(rest) : verdict === "fail" ? forFail(rest) : forUndecided(rest, timeoutMs);
  const reason = result.regions ? `Outside of the regions: ${words.reason}` : words.reason;
  return { ...words, reason: others === "" ? reason : `${reason} ${others}` };
}

const headings: Record<Verdict, string> = { pass: "Pass", fail: "Fail", undecided: "Undecided" };

const areaProofs: Record<Verdict, string> = {
  pass: "The interval proves it: its upper end is a bound of the exact share, not an estimate from samples.",
  fail: "The interval proves it: its lower end is a bound of the exact share, not an estimate from samples.",
  undecided: "What would decide: more time.",
};

// The verdict of max_distance alone; null: there is no such limit.
function distanceVerdict({ gate, distance: { lower, upper } }: Comparison): Verdict | null {
  const limit = gate?.max_distance ?? null;
  if (limit === null) return null;
  const uncertainty = gate?.uncertainty ?? 0;
  if (upper !== null && upper <= limit - uncertainty) return "pass";
  return lower > limit + uncertainty ? "fail" : "undecided";
}

/** What is known of the area beyond the limit's distance; "": there is no such limit. */
export function areaSentence(result: Comparison): string {
  const { gate, share_beyond: found } = result;
  if (!gate?.max_share_beyond || !found) return "";
  const { lower, upper } = found.share;
  const from = toDigitsBelow(100 * lower, 4), to = toDigitsAbove(100 * (upper ?? 1), 4);
  const most = inPercent(gate.max_share_beyond.share);
  const range = lower === 0 ? `At most ${to} %` : `Between ${from} and ${to} %`;
  const open = found.verdict === "undecided" ? `: whether at most ${most} is, is not decided` : `; at most ${most} may be`;
  return `${range} of the area is farther than ${withUnits(plain(found.distance), unitsOf(result))}${open}.`;
}

/** What was found of the candidate itself, against what is expected; "": nothing is. */
export function expectationsSentence({ expectations = [] }: Comparison): string {
  const unmet = expectations.filter((one) => one.verdict !== "pass").map(({ name, verdict, found, expected }) => `${name} ${found}, expected ${expected}${verdict === "undecided" ? " (undecided)" : ""}`);
  if (unmet.length > 0) return `Of the candidate (A) itself: ${unmet.join("; ")}.`;
  return expectations.length === 0 ? "" : `The candidate (A) itself is as expected: ${expectations.map(({ name, found }) => `${name} ${found}`).join(", ")}.`;
}

/** How far the candidate reaches to each side of the baseline, or why it has no sides; "": there is no zone. */
function zoneSentence({ gate, sides, ...result }: Comparison): string {
  if (!gate?.zone || !sides) return "";
  const { refused, inside, outside } = sides;
  if (refused) return `Nothing is inside or outside of the baseline (B): ${refused.detail}.`;
  if (!inside || !outside) return "";
  const units = unitsOf(result), [below, above] = gate.zone, uncertainty = gate.uncertainty ?? 0;
  const side = (name: string, { lower, upper }: NonNullable<typeof inside>, limit: number) => {
    const text = intervalText(lower, upper, limit), allowed = withUnits(plain(limit), units) + (uncertainty ? ` ± ${withUnits(plain(uncertainty), units)}` : "");
    const fails = lower > limit + uncertainty, passes = upper <= limit - uncertainty;
    const found = fails
      ? `at least ${withUnits(text.lower, units)}, beyond the limit of ${allowed}`
      : passes
        ? `at most ${withUnits(text.upper, units)}, within the limit of ${allowed}`
        : `${intervalWords(lower, upper, units, limit)}, which does not decide the limit of ${allowed}`;
    return { fails, words: `${name} of the baseline (B) the candidate reaches ${found}.` };
  };
  const both = [side("Inside", inside, 0 - below), side("Outside", outside, above)];
  return both.sort((one, other) => Number(other.fails) - Number(one.fails)).map(({ words }) => words).join(" ");
}

function figures(result: Comparison) {
  const { lower, upper } = result.distance;
  const text = intervalText(lower, upper, result.gate?.max_distance ?? null);
  const units = unitsOf(result);
  const uncertainty = result.gate?.uncertainty ? ` ± ${withUnits(plain(result.gate.uncertainty), units)}` : "";
  return { lower: withUnits(text.lower, units), upper: withUnits(text.upper, units), limit: withUnits(text.limit, units) + uncertainty };
}

function forPass(result: Comparison): Wording {
  const { upper, limit } = figures(result);
  return {
    tone: "pass",
    heading: "Pass",
    reason: `${everyPoint[result.direction]} within ${limit} of ${otherMesh[result.direction]}: at most ${upper} away.`,
    proof: "The interval proves it: its upper end is a bound for every point, not the largest of some samples.",
  };
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

function forFail(result: Comparison): Wording {
  const { lower, limit } = figures(result);
  const [witness] = witnessesOf(result);
  if (!witness) return { tone: "fail", heading: "Fail", reason: `The distance is at least ${lower}; the limit is ${limit}.`, proof: provedFail };
  const other = witness.from === "a" ? "b" : "a";
  const lacking = witness.from === "b" ? ` The ${meshName.a} lacks what the ${meshName.b} has there, or has it elsewhere.` : "";
  return {
    tone: "fail",
    heading: "Fail",
    reason:
      `The point ${withUnits(pointText(witness.point), unitsOf(result))} of the ${meshName[witness.from]}, on ${pieceOf(result, witness.from)} ${String(witness.triangle)}, ` +
      `is ${lower} or more from the ${meshName[other]}. The limit is ${limit}.${lacking}`,
    proof: provedFail,
  };
}

const provedFail = "The interval proves it: its lower end is attained at that point, and is above the limit.";

function forUndecided(result: Comparison, timeoutMs: number | null): Wording {
  const { lower, upper } = result.distance;
  const { limit } = figures(result);
  const range = intervalWords(lower, upper, unitsOf(result), result.gate?.max_distance ?? null);
  const known = range === "not known yet" ? "Nothing is known of the distance yet" : `The distance is ${between(range)}`;
  const limitWords = decidingLimit(result);
  const effort = moreEffort(result.status, timeoutMs);
  const either = [limitWords, effort].filter((one) => one !== "").join(", or ");
  return {
    tone: "undecided",
    heading: "Undecided",
    reason: `${known}, and the limit of ${limit} is not decided by that: ${whyEnded[result.status]}.`,
    proof: effort === "" ? `Decided by ${either}. The limit is within rounding error of the distance.` : `What would decide: ${either}.`,
  };
}

const between = (range: string) => (range.includes(" to ") ? `between ${range.replace(" to ", " and ")}` : range);

function decidingLimit(result: Comparison): string {
  const { lower, upper } = result.distance;
  const units = unitsOf(result);
  const parts: string[] = [];
  if (upper !== null) parts.push(`of at least ${withUnits(toDigitsAbove(upper, 6), units)} (pass)`);
  if (lower > 0) parts.push(`below ${withUnits(toDigitsBelow(lower, 6), units)} (fail)`);
  return parts.length === 0 ? "" : `a limit ${parts.join(" or ")}`;
}

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
  return { tone: "measured", heading: headingFor(range), reason, proof: statusSentence(result) };
}

// Names the surface on which the difference is visible; with one direction the subject has named it.
function whereFound(result: Comparison): string {
  const [witness] = witnessesOf(result);
  if (!witness || witness.lower === 0 || result.direction !== "symmetric") return "";
  return ` A point that is ${withUnits(toDigitsBelow(witness.lower, 4), unitsOf(result))} or more away lies on the ${meshName[witness.from]}.`;
}

const headingFor = (range: string) => (range.startsWith("at least") ? range.replace("at", "At") : range);

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
  const why = whyEnded[result.status];
  return `${why.charAt(0).toUpperCase()}${why.slice(1)}. The interval reached so far is still valid.`;
}

/** The title of the browser's tab. */
export function titleOf(result: Comparison): string {
  const range = intervalWords(result.distance.lower, result.distance.upper, unitsOf(result), result.gate?.max_distance ?? null);
  const { tone, heading } = wordingOf(result);
  return `${tone === "measured" ? range : `${heading}: ${range}`} · meshgauge`;
}
