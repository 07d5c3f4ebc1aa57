// What stands around the picture: the sentence on the limit, the witness's label, what is coloured first.
import assert from "node:assert/strict";
import test from "node:test";
import { labelPlace } from "../../../server/web/page/viewer/overlay";
import { initialSettings, type Side, type Witness } from "../../../server/web/page/viewer/settings";
import { limitWords, sideWords, type Beyond, type OneSide } from "../../../server/web/page/viewer/words";

const witness = (from: Side, lower: number): Witness => ({ from, lower, upper: lower, point: [0, 0, 0], nearest: [0, 0, lower], triangle: 0, nearestTriangle: 0 });
const within: Beyond = { farther: false, share: 0 };
const beyond: Beyond = { farther: true, share: 0.25 };

test("the side of the verdict's witness is coloured first", () => {
  assert.equal(initialSettings({ witnesses: [witness("b", 2), witness("a", 1)] }).coloured, "b");
  assert.equal(initialSettings({ witnesses: [witness("a", 2), witness("b", 1)] }).coloured, "a");
  assert.equal(initialSettings({ witnesses: [] }).coloured, "a");
  assert.equal(initialSettings({ witnesses: [], up: "y" }).up, "y");
});

test("the sentence on the limit covers both surfaces", () => {
  const said = (coloured: Side, a: Beyond, b: Beyond, witnesses: Witness[] = [], split = false): string => limitWords({ coloured, split }, { a, b }, witnesses, 1);
  assert.equal(said("a", within, within), "All of A and of B that is shown is within the limit.");
  assert.equal(said("a", beyond, within), "25 % of A’s area is farther from B than the limit.");
  assert.match(said("a", within, beyond), /^All of A that is shown is within the limit; B is not: 25 % of B’s area .* “Swap” colours B\.$/);
  assert.match(said("b", within, beyond), /^25 % of B’s area/);
  assert.match(said("a", { ...beyond, of: "points" }, within), /^25 % of A’s points are farther/);
  assert.match(said("a", beyond, beyond, [], true), /25 % of A’s area .* 25 % of B’s area/);
  assert.doesNotMatch(said("a", within, beyond, [], true), /Swap/);
});

test("the sentence on the limits of both sides says how much of A is beyond which", () => {
  const inside: OneSide = { ...beyond, side: "inside", limit: 0.05, lower: 0.07 }, outside: OneSide = { ...within, side: "outside", limit: 0.1, lower: 0.1 };
  assert.equal(sideWords([inside, outside], "mm"), "25 % of A’s area is more than 0.05 mm inside of B.");
  const both = sideWords([{ ...inside, share: 0, of: "points" }, { ...outside, lower: 0.2 }], "");
  assert.equal(both, "less than 0.01 % of A’s points are more than 0.05 inside of B, and A reaches more than 0.1 outside of B, where it is too small to show.");
  assert.equal(sideWords([{ ...inside, ...within, lower: 0 }, outside], "mm"), "All of A that is shown is within the limits of both sides.");
  const said = (a: Beyond, limit: number | null): string => limitWords({ coloured: "b", split: false }, { a, b: beyond }, [witness("b", 2)], limit);
  assert.match(said({ ...beyond, ofSides: both }, null), /^Less than 0.01 % .* to show\.$/);
  assert.match(limitWords({ coloured: "a", split: true }, { a: { ...beyond, ofSides: both }, b: beyond }, [], 1), /^Less than .* to show\. 25 % of B’s area is farther from A/);
  assert.equal(said({ ...within, ofSides: "All." }, null), "All.");
});

test("a witness beyond the limit is reported even if the display has lost it", () => {
  const words = limitWords({ coloured: "a", split: false }, { a: within, b: within }, [witness("a", 1.5)], 1);
  assert.match(words, /witness of A is farther from B than the limit/);
  assert.doesNotMatch(words, /All of A/);
  assert.match(limitWords({ coloured: "a", split: false }, { a: { farther: true, share: 0 }, b: within }, [], 1), /^Less than 0.01 % of A’s area/);
  assert.match(limitWords({ coloured: "a", split: false }, { a: within, b: within }, [witness("a", 1)], 1), /^All of A and of B/);
});

test("the witness's label is never cut by the picture's edge", () => {
  const size = { width: 150, height: 26 };
  for (const width of [160, 180, 320, 360, 960])
    for (let left = 100; left <= 100 + width; left += 7)
      for (const length of [0, 20, width])
        for (const y of [50, 51, 200, 349, 350]) {
          const right = Math.min(left + length, 100 + width);
          const place = labelPlace({ left, right, y }, { left: 100, top: 50, width, height: 300 }, size);
          assert.ok(place.x >= 100 && place.x + size.width <= 100 + width, `${place.x} of ${left} in ${width}`);
          assert.ok(place.y - 13 >= 50 && place.y + 13 <= 350, `${place.y}`);
          const over = place.x < right && place.x + size.width > left && Math.abs(place.y - y) < 13;
          assert.ok(!over || y < 80 || y > 320, "it does not lie over the segment");
        }
});
