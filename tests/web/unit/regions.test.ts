import assert from "node:assert/strict";
import { test } from "node:test";
import { ofRest, placeOf, regionsAsked, regionsSentence } from "../../../server/web/page/text/regions.js";
import { gatesYaml, optionsOf, withoutLimits } from "../../../server/web/page/text/snippets.js";
import { wordingOf } from "../../../server/web/page/text/verdict.js";
import { comparison, gate } from "./samples.js";
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

test("the headline is of the rest, and a region that fails is named", () => {
  const result = comparison({ verdict: "fail", gate: gate(0.2), regions: [region("bore", 0.5, 0.6, "fail", 0.4), rest] });
  assert.deepEqual(ofRest(result).distance, { lower: 0.09, upper: 0.1 });
  const words = wordingOf(result);
  assert.equal(words.tone, "fail");
  assert.equal(words.reason, "In bore a point is at least 0.5\u00A0mm away; at most 0.4\u00A0mm is allowed.");
});

test("a pass is one of the rest and of each region", () => {
  const result = comparison({ verdict: "pass", gate: gate(0.2), regions: [region("bore", 0.1, 0.2, "pass", 0.4), rest] });
  assert.match(wordingOf(result).reason, /^Outside of the regions: Every point .* So is bore, within its own limit\.$/);
});

test("an undecided region says between what", () => {
  const result = comparison({ verdict: "undecided", gate: gate(0.2), regions: [region("bore", 0.3, 0.5, "undecided", 0.4), rest] });
  assert.match(regionsSentence(result, "mm"), /^In bore the distance lies between 0\.3 and 0\.5.mm: whether it is within 0\.4.mm is not decided\.$/);
  assert.equal(regionsSentence(comparison(), "mm"), "");
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
