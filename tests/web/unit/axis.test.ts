import assert from "node:assert/strict";
import { test } from "node:test";
import { axisFor, logarithmicPart, niceStep, positionOf, ticksOf } from "../../../server/web/page/plot/axis.js";
import { History, timeAxis } from "../../../server/web/page/plot/timeline.js";

const labels = (marks: (number | null)[], whole = false, most?: number) =>
  ticksOf(axisFor(marks, whole), most).flatMap(({ label }) => (label === "" ? [] : [label]));

test("all marks lie on the axis, with room on both sides", () => {
  const axis = axisFor([0.01, 3, 0.5]);
  assert.ok(axis.low < 0.01 && axis.high > 3);
  assert.equal(axis.zero, false);
  assert.equal(axis.unknown, false);
});

test("equal factors are equal lengths", () => {
  const axis = axisFor([0.001, 1000]);
  const step = positionOf(axis, 1) - positionOf(axis, 0.1);
  assert.ok(Math.abs(positionOf(axis, 100) - positionOf(axis, 10) - step) < 1e-12);
});

test("zero and unknown values have places at the ends", () => {
  const axis = axisFor([0, null, 1]);
  const [begin, end] = logarithmicPart(axis);
  assert.equal(positionOf(axis, 0), 0);
  assert.equal(positionOf(axis, null), 1);
  assert.equal(positionOf(axis, Infinity), 1);
  assert.ok(begin > 0 && end < 1);
  assert.ok(positionOf(axis, 1) > begin && positionOf(axis, 1) < end);
  assert.deepEqual([labels([0, null, 1])[0], labels([0, null, 1]).at(-1)], ["0", "∞"]);
});

test("what is below or above the axis lies at the ends of its numbers", () => {
  const axis = axisFor([0, 1, 2]);
  const [begin] = logarithmicPart(axis);
  assert.equal(positionOf(axis, 1e-30), begin);
  assert.equal(positionOf(axis, 1e30), 1);
  assert.equal(positionOf(axis, NaN), 0);
});

test("equal bounds still have an axis, with at least two numbers", () => {
  for (const x of [1, 0.0968, 7e-9, 123456]) {
    const axis = axisFor([x, x]);
    assert.ok(axis.low < x && x < axis.high, String(x));
    assert.ok(labels([x, x]).length >= 2, String(labels([x, x])));
  }
});

test("an axis for zero only, for unknown values only, and for nothing", () => {
  for (const marks of [[0, 0], [0, null], []]) {
    const axis = axisFor(marks);
    assert.ok(axis.low > 0 && axis.high > axis.low);
    assert.ok(axis.zero);
  }
});

test("bounds at the ends of what a double holds", () => {
  const axis = axisFor([5e-324, 1.7e308, 0, null]);
  assert.ok(axis.low > 0 && Number.isFinite(axis.high));
  for (const mark of [0, 5e-324, 1, 1.7e308, null]) {
    const at = positionOf(axis, mark);
    assert.ok(at >= 0 && at <= 1);
  }
  assert.ok(ticksOf(axis).length < 60);
});

test("a whole axis ends at powers of ten, and does not move for a small change", () => {
  const axis = axisFor([0.02, 3], true);
  assert.deepEqual([axis.low, axis.high], [0.01, 10]);
  assert.deepEqual(axisFor([0.03, 2.5], true), axis);
});

test("labels are round, rising and few", () => {
  assert.deepEqual(labels([0.02, 3], true, 4), ["0.01", "0.1", "1", "10"]);
  assert.deepEqual(labels([0.02, 3], true), ["0.01", "0.03", "0.1", "0.3", "1", "3", "10"]);
  for (const marks of [[1e-12, 1], [0.9, 1.1], [3, 4000], [1e-5, 1e5]]) {
    const values = ticksOf(axisFor(marks)).filter(({ label }) => label !== "").map(({ value }) => value ?? Infinity);
    assert.ok(values.length >= 2 && values.length <= 7, String(values));
    assert.deepEqual(values, [...values].sort((a, b) => a - b));
    assert.equal(new Set(values).size, values.length);
  }
});

test("steps of ticks are 1, 2 or 5", () => {
  assert.deepEqual([0.011, 0.3, 1, 4, 70].map(niceStep), [0.02, 0.5, 1, 5, 100]);
});

test("a history keeps what changed, in order, and not too much", () => {
  const history = new History();
  history.add({ ms: 0, lower: 0, upper: null });
  history.add({ ms: 5, lower: 0, upper: null });
  history.add({ ms: 10, lower: 0, upper: 2 });
  history.add({ ms: 7, lower: 0, upper: 3 });
  assert.deepEqual(history.samples.map(({ ms }) => ms), [0, 10]);
  for (let i = 0; i < 5000; ++i) history.add({ ms: 20 + i, lower: i / 5000, upper: 2 });
  assert.ok(history.samples.length <= 500);
  assert.equal(history.samples[0]?.ms, 0);
  assert.equal(history.last?.ms, 5019);
});

test("the axis of time grows in steps", () => {
  assert.equal(timeAxis(150).end, 200);
  assert.equal(timeAxis(5000).end, 5000);
  for (const ms of [0, 1, 99, 3333, 179_000, 400_000]) {
    const { end, ticks } = timeAxis(ms);
    assert.ok(end >= ms && ticks.length >= 3 && ticks.length <= 8, `${String(ms)}: ${String(ticks)}`);
  }
});
