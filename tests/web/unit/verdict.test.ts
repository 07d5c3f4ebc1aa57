import assert from "node:assert/strict";
import { test } from "node:test";
import { stageTimes } from "../../../server/web/page/result/times.js";
import { stageWords } from "../../../server/web/page/run/run.js";
import { witnessesOf, witnessesToShow } from "../../../server/web/page/text/criteria.js";
import { pairNotes, rangeOf, titleOf, unitsOf, wordingOf } from "../../../server/web/page/text/verdict.js";
import { comparison, directed, expectation, gate, limited, share } from "./samples.js";

const spaces = (text: string) => text.replaceAll("\u00A0", " ");
const words = (...args: Parameters<typeof wordingOf>) => {
  const { tone, heading, reason, proof } = wordingOf(...args);
  return { tone, heading, reason: spaces(reason), proof: spaces(proof) };
};

test("a pass says that every point is within the limit, and how far it is at most", () => {
  const told = words(comparison({ verdict: "pass", gate: gate(0.2) }));
  assert.equal(told.tone, "pass");
  assert.equal(told.reason, "Every point of both surfaces lies within 0.2 mm of the other surface: at most 0.0976 mm away.");
  assert.match(told.proof, /proves/);
});

test("a pass of one direction speaks of that direction alone", () => {
  const told = words(comparison({ verdict: "pass", gate: gate(0.2), direction: "a_to_b", b_to_a: null }));
  assert.match(told.reason, /^Every point of the candidate \(A\) lies within 0.2 mm of the baseline \(B\)/);
});

test("a fail names the point, its mesh and triangle, and how far it is at least", () => {
  const told = words(comparison({ verdict: "fail", gate: gate(0.05), status: "gate_decided", a_to_b: directed(0.0968, 0.0976), b_to_a: directed(0.01, 0.0976) }));
  assert.equal(told.tone, "fail");
  assert.equal(told.reason, "The point (1, 2, 3) mm of the candidate (A), on triangle 3, is 0.0968 mm or more from the baseline (B). The limit is 0.05 mm.");
});

test("a fail whose point is on the baseline says what the candidate lacks", () => {
  const told = words(comparison({ verdict: "fail", gate: gate(0.05) }));
  assert.match(told.reason, /of the baseline \(B\), on triangle 7.*The candidate \(A\) lacks what the baseline \(B\) has there/);
});

test("a fail without a witness still says why", () => {
  const none = { ...directed(0.0968, null), witness: null };
  assert.match(words(comparison({ verdict: "fail", gate: gate(0.05), a_to_b: none, b_to_a: none })).reason, /at least 0.0968 mm; the limit is 0.05 mm/);
});

test("undecided says why it ended and what would decide", () => {
  const told = words(comparison({ verdict: "undecided", gate: gate(0.097), status: "timeout" }), 5000);
  assert.equal(told.tone, "undecided");
  assert.match(told.reason, /between 0.0968 and 0.0976 mm, and the limit of 0.097 mm is not decided by that: the time was over/);
  assert.equal(told.proof, "What would decide: a limit of at least 0.0976 mm (pass) or below 0.0968 mm (fail), or more time than 5 s.");
});

test("each end of the work that leaves a gate undecided has its own advice", () => {
  const proof = (status: Parameters<typeof comparison>[0] & object) => words(comparison({ verdict: "undecided", gate: gate(0.097), ...status }), null).proof;
  assert.match(proof({ status: "cancelled" }), /letting it run to its end/);
  assert.match(proof({ status: "converged" }), /a smaller tolerance/);
  assert.match(proof({ status: "budget" }), /more memory/);
  assert.match(proof({ status: "precision_floor" }), /rounding/);
  assert.match(words(comparison({ verdict: "undecided", gate: gate(0.097), status: "timeout" }), 180_000).proof, /more threads/);
});

test("a zone is worded by the side that fails, with its point", () => {
  const witness = { on: "a" as const, point: [5.55e-17, 2, 12.345678901] as [number, number, number], triangle: 9, nearest_point: null, nearest_triangle: null };
  const inside = limited("pass", 0.01, 0.02, 0.05, { side: "inside" }), outside = limited("fail", 0.2, 0.21, 0.1, { side: "outside", witness });
  const zone = gate(0.1);
  const told = words(comparison({ verdict: "fail", foremost: "distance outside", gate: zone, criteria: [inside, outside] }));
  assert.equal(told.reason, "The point (0, 2, 12.34568) mm of the candidate (A), on triangle 9, is 0.2 mm or more outside of the baseline (B). The limit is 0.1 mm.");
  const passes = words(comparison({ verdict: "pass", foremost: "distance inside", gate: zone, criteria: [inside, { ...outside, verdict: "pass", lower: 0.01, upper: 0.03 }] }));
  assert.equal(passes.reason, "No point of the candidate (A) lies farther than 0.05 mm inside of the baseline (B): at most 0.02 mm. The distance outside is found.");
  const open = { ...inside, verdict: "undecided" as const, uncertainty: 0.04 };
  assert.match(words(comparison({ verdict: "undecided", gate: zone, criteria: [open, outside] })).reason, /^The distance inside is between 0.01 and 0.02 mm, and the limit of 0.05 mm ± 0.04 mm is not decided by that/);
  const refused = { ...open, refused: "it is not watertight", finding: "nothing is inside or outside: it is not watertight" };
  assert.equal(words(comparison({ verdict: "undecided", gate: zone, criteria: [refused] })).reason, "Nothing is inside or outside: it is not watertight.");
});

test("expectations are worded alone, and beside a limit of the distance", () => {
  const open = expectation("watertight", "fail", "no: 4 open edges, the first at (0, 0, 0)", "yes"), count = expectation("triangles", "pass", "12", "at most 20");
  const alone = words(comparison({ verdict: "fail", gate: null, criteria: [open, count] }));
  assert.deepEqual(alone, { tone: "fail", heading: "Fail", reason: "Of the candidate (A) itself: watertight: no: 4 open edges, the first at (0, 0, 0), expected yes.", proof: "" });
  const both = words(comparison({ verdict: "pass", gate: gate(0.2), foremost: "distance", criteria: [limited("pass", 0.0968, 0.0976, 0.2), count] }));
  assert.match(both.reason, /away\. Triangles: 12, expected at most 20\.$/);
  assert.equal(titleOf(comparison({ verdict: "fail", criteria: [open, count] })), "Fail: watertight · meshgauge");
});

test("a limit of the area is worded by its finding, alone and beside one of the distance", () => {
  const area = share("pass", 0.0021, 0.0027), result = comparison({ verdict: "pass", gate: gate(0.2), criteria: [area] });
  const told = words(result);
  assert.equal(told.reason, "The share is found.");
  assert.match(told.proof, /bound of the exact share/);
  assert.equal(spaces(rangeOf(area, result)), "0.21 to 0.27 %");
  const both = words(comparison({ verdict: "pass", gate: gate(0.2), foremost: "distance", criteria: [limited("pass", 0.0968, 0.0976, 0.2), area] }));
  assert.match(both.reason, /^Every point of both surfaces lies within 0.2 mm.* away\. The share is found\.$/);
  const fails = words(comparison({ verdict: "fail", gate: gate(0.05), foremost: "distance", criteria: [limited("fail", 0.0968, 0.0976, 0.05), area] }));
  assert.equal(fails.reason, "The distance is at least 0.0968 mm; the limit is 0.05 mm.");
});

test("after three more criteria their number is said", () => {
  const regions = ["r1", "r2", "r3", "r4", "r5", "r6"].map((region) => limited("pass", 0, 0.1, 0.2, { region }));
  const told = words(comparison({ verdict: "pass", gate: gate(0.2), foremost: "distance in r1", criteria: regions }));
  assert.equal(told.reason, "In r1: every point of both surfaces lies within 0.2 mm of the other surface: at most 0.1 mm away. The distance in r2 is found. The distance in r3 is found. The distance in r4 is found. 2 more pass.");
});

test("an uncertainty stands behind the limit, and is the service's to decide", () => {
  const told = words(comparison({ verdict: "pass", gate: gate(0.2), criteria: [limited("pass", 0.0968, 0.0976, 0.2, { uncertainty: 0.01 })] }));
  assert.match(told.reason, /within 0.2 mm ± 0.01 mm of the other surface/);
});

test("within the uncertainty no narrower interval decides, but other limits do", () => {
  const open = limited("undecided", 0.9375, 1.0625, 1, { uncertainty: 0.125, status: "gate_decided" });
  const told = words(comparison({ verdict: "undecided", status: "gate_decided", gate: gate(1), criteria: [open] }));
  assert.equal(told.proof, "Decided by a limit of at least 1.1875 mm (pass) or below 0.8125 mm (fail). The interval lies within the uncertainty of the limit.");
});

test("refused sides are said once", () => {
  const side = (name: string) => limited("undecided", 0, 1, 0.1, { side: name as "inside", refused: "it is not watertight", finding: "nothing is inside or outside: it is not watertight" });
  const told = words(comparison({ verdict: "undecided", gate: gate(1), criteria: [side("inside"), side("outside")] }));
  assert.equal(told.reason, "Nothing is inside or outside: it is not watertight.");
});

test("undecided when nothing is known", () => {
  const told = words(comparison({ verdict: "undecided", gate: gate(1), status: "timeout", distance: { lower: 0, upper: null }, a_to_b: null, b_to_a: null }));
  assert.match(told.reason, /^Nothing is known of the distance yet/);
  assert.equal(told.proof, "What would decide: more time.");
});

test("without a gate the interval is the answer", () => {
  const told = words(comparison());
  assert.equal(told.heading, "0.0968 to 0.0976");
  assert.equal(told.reason, "The largest distance from any point of one surface to the other is between 0.0968 and 0.0976. A point that is 0.0968 or more away lies on the baseline (B).");
  assert.equal(told.proof, "The interval is as narrow as asked: 0.84 % of the distance.");
});

test("a cancelled comparison says that its interval is valid", () => {
  assert.match(words(comparison({ status: "cancelled" })).proof, /It was cancelled\. The interval reached so far is still valid/);
});

test("a comparison that was cancelled before anything was known", () => {
  const told = words(comparison({ status: "cancelled", distance: { lower: 0, upper: null } }));
  assert.equal(told.heading, "Nothing is known yet");
});

test("the first witness is the one that attains the lower end, and each has its own mesh", () => {
  const found = witnessesOf(comparison());
  assert.deepEqual(found.map(({ from, lower, triangle }) => ({ from, lower, triangle })), [
    { from: "b", lower: 0.0968, triangle: 7 },
    { from: "a", lower: 0.0967, triangle: 3 },
  ]);
  assert.deepEqual(witnessesOf(comparison({ b_to_a: null })).map(({ from }) => from), ["a"]);
  assert.equal(witnessesOf(comparison({ a_to_b: directed(1, null), b_to_a: null }))[0]?.upper, Infinity);
});

test("the witness that is shown first is that of the foremost criterion, as of a region that fails beside a rest that passes", () => {
  const limit = { of: "distance", verdict: "fail", finding: "", region: "bore", side: null, limit: 0.02, lower: 0.03, upper: 0.031 } as const;
  const point: [number, number, number] = [7, 8, 9], nearest_point: [number, number, number] = [7, 8, 10];
  const bore = { ...limit, name: "distance in bore", witness: { on: "a" as const, point, triangle: 11, nearest_point, nearest_triangle: 12 } };
  const [first, ...others] = witnessesToShow(comparison({ verdict: "fail", foremost: "distance in bore", criteria: [bore] }));
  assert.deepEqual(first, { from: "a", point: [7, 8, 9], nearest: [7, 8, 10], lower: 0.03, upper: 0.031, triangle: 11, nearestTriangle: 12 });
  assert.deepEqual(others.map(({ from }) => from), ["b"]);
  const outside = { ...limit, name: "distance outside", side: "outside" as const, witness: { ...bore.witness, nearest_point: null, nearest_triangle: null } };
  const of_side = witnessesToShow(comparison({ verdict: "fail", foremost: "distance outside", criteria: [outside] }))[0];
  assert.deepEqual([of_side?.triangle, of_side?.nearest], [11, point]);
});

test("the title of the document tells the verdict", () => {
  assert.equal(spaces(titleOf(comparison({ verdict: "pass", gate: gate(0.2) }))), "Pass: 0.0968 to 0.0976 mm · meshgauge");
  assert.equal(spaces(titleOf(comparison())), "0.0968 to 0.0976 · meshgauge");
});

test("stages have words, and times without statistics have no statistics", () => {
  assert.equal(stageWords("queued", null), "Waiting for a free worker");
  assert.equal(stageWords("running", null), "Reading both meshes");
  assert.match(stageWords("running", "reduce"), /Splitting/);
  const { timings_ms } = comparison();
  assert.deepEqual(stageTimes(timings_ms).map(({ name }) => name), ["queue", "read_a", "read_b", "build", "traverse", "reduce", "certify"]);
  assert.equal(stageTimes({ ...timings_ms, statistics: 4 }).at(-1)?.ms, 4);
});

test("a result of before 0.2.0 says no unit and has no notes", () => {
  const old: Record<string, unknown> = { ...comparison({ verdict: "pass", gate: { max_distance: 0.2, units: null } }) };
  delete old["unit"];
  delete old["notes"];
  const result = old as unknown as Parameters<typeof wordingOf>[0];
  assert.equal(unitsOf(result), "");
  assert.deepEqual(pairNotes(result), []);
  assert.match(words(result).reason, /within 0.2 of the other surface: at most 0.0976 away/);
});
