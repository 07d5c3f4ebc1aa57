// The page's colour map is that of api/map/colour_map.h: both are held to tests/web/unit/colours.json, the other one by
// tests/api/map/colour_map_test.cpp.
import assert from "node:assert/strict";
import test from "node:test";
import { aboveLimit, colourOf, colourTable, kAboveLimit, kPaths, kSteps, mapColour, ticks } from "../../../server/web/page/viewer/colours";
import reference from "./colours.json";

const colours = reference.colours.join("").match(/.{6}/g) ?? [];
const hex = (colour: readonly number[]): string => colour.map((byte) => byte.toString(16).padStart(2, "0")).join("");

test("the colour map is the service's to the last byte", () => {
  assert.equal(colours.length, 257);
  colours.forEach((colour, i) => assert.equal(hex(mapColour(i / 256)), colour, `at ${i} of 256`));
  assert.equal(hex(kAboveLimit), reference.above);
});

test("ticks follow the service's rule", () => {
  for (const { top, values } of reference.ticks) assert.deepEqual(ticks(top), values, `up to ${top}`);
});

test("the shader's table has the same colours, opaque", () => {
  const table = colourTable();
  assert.equal(table.length, 4 * (kSteps + 1) * kPaths.length);
  kPaths.forEach((path, row) => {
    for (const i of [0, 1, 511, kSteps]) {
      const at = 4 * (row * (kSteps + 1) + i);
      assert.deepEqual([...table.slice(at, at + 4)], [...mapColour(i / kSteps, path), 255]);
    }
  });
});

test("both sides begin with one grey and end apart, each darker all the way, and beyond the limit by a colour of their own", () => {
  assert.deepEqual(mapColour(0, "inside"), mapColour(0, "outside"));
  const [grey] = mapColour(0, "inside");
  assert.ok(Math.max(...mapColour(0, "inside")) - Math.min(...mapColour(0, "inside")) < 4 && grey > 200);
  const light = ([r, g, b]: readonly number[]): number => 0.2126 * r! + 0.7152 * g! + 0.0722 * b!;
  for (const path of ["inside", "outside"] as const) {
    for (let i = 1; i <= 16; ++i) assert.ok(light(mapColour(i / 16, path)) < light(mapColour((i - 1) / 16, path)), `${path} ${i}`);
    assert.deepEqual(colourOf(3, { top: 2, limited: true }, path), aboveLimit(path));
    assert.deepEqual(colourOf(0, { top: 2, limited: true }, path), mapColour(0, path));
  }
  const sided = { top: 4, limited: false, sideLimits: { inside: { limit: 1, lower: 0 }, outside: { limit: 2, lower: 0 } } };
  assert.deepEqual(colourOf(1, sided, "inside"), mapColour(0.25, "inside"));
  assert.deepEqual(colourOf(1.01, sided, "inside"), aboveLimit("inside"));
  assert.deepEqual(colourOf(1.01, sided, "outside"), mapColour(1.01 / 4, "outside"));
  assert.deepEqual(colourOf(2.01, sided, "outside"), aboveLimit("outside"));
  assert.deepEqual(colourOf(3, sided), mapColour(0.75));
  assert.deepEqual(colourOf(1.5, { ...sided, top: 1.2, limited: true }, "outside"), aboveLimit("outside"));
  const [outside, inside] = [mapColour(1, "outside"), mapColour(1, "inside")];
  assert.ok(outside[0] - outside[2] > 150 && inside[2] - inside[0] > 100, `${outside.join()} and ${inside.join()}`);
  assert.notDeepEqual(aboveLimit("inside"), aboveLimit("outside"));
});

test("colours of distances: what is nearer than 0, at the limit, above it and without a limit", () => {
  const limited = { top: 2, limited: true };
  assert.deepEqual(colourOf(0, limited), mapColour(0));
  assert.deepEqual(colourOf(2, limited), mapColour(1));
  assert.deepEqual(colourOf(2.0001, limited), kAboveLimit);
  assert.deepEqual(colourOf(2.0001, { top: 2, limited: false }), mapColour(1));
  assert.deepEqual(colourOf(0, { top: 0, limited: true }), mapColour(0));
  assert.deepEqual(colourOf(1e-9, { top: 0, limited: true }), kAboveLimit);
  assert.deepEqual(mapColour(NaN), mapColour(0));
});
