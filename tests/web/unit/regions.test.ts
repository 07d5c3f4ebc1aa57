import assert from "node:assert/strict";
import { test } from "node:test";
import { placeOf } from "../../../server/web/page/result/tables.js";
import { gatesYaml, optionsOf, regionsAsked, withoutLimits } from "../../../server/web/page/text/snippets.js";
import { wordingOf } from "../../../server/web/page/text/verdict.js";
import { comparison, gate, limited } from "./samples.js";
import type { Verdict } from "../../../server/web/page/api/types.js";

const box = { min: [0, 0, 0], max: [1, 1, 1] };

const region = (name: string, lower: number, upper: number, verdict: Verdict, max_distance: number) => ({
  name,
  ...(name === "rest" ? {} : { box }),
  max_distance,
  distance: { lower, upper },
  status: "gate_decided",
  empty: false,
  precision_floor: 0,
  a_to_b: { lower, upper, witness: null },
  b_to_a: null,
  verdict,
});

const rest = region("rest", 0.09, 0.1, "pass", 0.2);

test("the headline is of the region that fails, and the rest is not said", () => {
  const criteria = [limited("pass", 0.09, 0.1, 0.2, { region: "rest" }), limited("fail", 0.5, 0.6, 0.4, { region: "bore" })];
  const words = wordingOf(comparison({ verdict: "fail", foremost: "distance in bore", gate: gate(0.2), criteria }));
  assert.equal(words.tone, "fail");
  assert.equal(words.reason, "In bore: the distance is at least 0.5\u00A0mm; the limit is 0.4\u00A0mm.");
});

test("a pass is one of the rest and of each region", () => {
  const criteria = [limited("pass", 0.09, 0.1, 0.2, { region: "rest" }), limited("pass", 0.1, 0.2, 0.4, { region: "bore" })];
  const result = comparison({ verdict: "pass", foremost: "distance outside of all regions", gate: gate(0.2), criteria });
  assert.match(wordingOf(result).reason, /^Outside of the regions: every point .* The distance in bore is found\.$/);
});

test("a group is of the baseline, and measured from it alone", () => {
  const lid = { ...region("lid", 0.1, 0.2, "pass", 0.4), box: undefined, group: "Lid" };
  const criteria = [limited("pass", 0.1, 0.2, 0.4, { region: "lid" })];
  const result = comparison({ verdict: "pass", foremost: "distance in lid", gate: gate(0.4), criteria, regions: [lid, rest] });
  assert.match(wordingOf(result).reason, /^In lid: every point of the baseline \(B\) lies within 0\.4.mm of the candidate \(A\)/);
});

test("an undecided region says between what", () => {
  const criteria = [limited("pass", 0.09, 0.1, 0.2, { region: "rest" }), limited("undecided", 0.3, 0.5, 0.4, { region: "bore", status: "timeout" })];
  const result = comparison({ verdict: "undecided", foremost: "distance in bore", gate: gate(0.2), criteria });
  assert.match(wordingOf(result).reason, /^In bore: the distance is between 0\.3 and 0\.5.mm, and the limit of 0\.4.mm is not decided by that: the time was over\.$/);
});

test("the regions asked for are those of the result, without what is the gate's", () => {
  const result = comparison({ verdict: "pass", gate: gate(0.2), regions: [region("bore", 0.1, 0.2, "pass", 0.4), region("tip", 0.1, 0.2, "pass", 0.2), rest] });
  assert.deepEqual(regionsAsked(result), [{ name: "bore", box, max_distance: 0.4 }, { name: "tip", box }]);
  assert.deepEqual(optionsOf(result).regions, regionsAsked(result));
  assert.match(gatesYaml(result, { a: "a.stl", b: "b.stl" }), /\n {4}regions:\n {6}- \{"name":"bore",.*"max_distance":"0\.4 mm"\}\n {6}- \{"name":"tip"/);
  assert.equal(JSON.stringify(withoutLimits({ statistics: true, ...optionsOf(result) })), JSON.stringify({ statistics: true, regions: [{ name: "bore", box }, { name: "tip", box }] }));
  assert.equal(optionsOf(comparison()).regions, undefined);
  assert.equal(placeOf({ box }), JSON.stringify(box));
  assert.equal(placeOf({ group: "Lid" }), "Lid");
  const lid = { ...region("lid", 0.1, 0.2, "pass", 0.2), box: undefined, group: "Lid" };
  assert.deepEqual(regionsAsked(comparison({ gate: gate(0.2), regions: [lid, rest] })), [{ name: "lid", group: "Lid" }]);
});
