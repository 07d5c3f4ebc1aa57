// The page's colour map is that of api/colour_map.h: both are held to tests/web/unit/colours.json, the other one by
// tests/api/colour_map_test.cpp.
import assert from "node:assert/strict";
import test from "node:test";
import { colourOf, colourTable, kAboveLimit, kSteps, mapColour, ticks } from "../../../server/web/page/viewer/colours";
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
  assert.equal(table.length, 4 * (kSteps + 1));
  for (const i of [0, 1, 511, kSteps]) assert.deepEqual([...table.slice(4 * i, 4 * i + 4)], [...mapColour(i / kSteps), 255]);
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
