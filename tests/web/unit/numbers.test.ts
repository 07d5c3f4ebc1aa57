import assert from "node:assert/strict";
import { test } from "node:test";
import {
  grouped, inBytes, inPercent, inPercentAbove, intervalText, intervalWords, inTime, onClock, plain, pointText, toDigits, toDigitsAbove, toDigitsBelow, withUnits,
} from "../../../server/web/page/text/numbers.js";

const spaces = (text: string) => text.replaceAll("\u00A0", " ");

test("numbers that people have names for are written out, others with an exponent", () => {
  assert.deepEqual([0, 0.00012, 150000, -2.5, 1e9, 1.5e-12].map(plain), ["0", "0.00012", "150000", "-2.5", "1e9", "1.5e-12"]);
  assert.equal(plain(Infinity), "∞");
});

test("digits below and above enclose the number", () => {
  let x = 1;
  for (let i = 0; i < 5000; ++i) {
    x = (x * 16807) % 2147483647;
    const value = (x / 2147483647) * 10 ** ((i % 40) - 20);
    for (const digits of [1, 3, 4, 6, 16]) {
      assert.ok(Number(toDigitsBelow(value, digits)) <= value, `${String(value)} below, ${String(digits)}`);
      assert.ok(Number(toDigitsAbove(value, digits)) >= value, `${String(value)} above, ${String(digits)}`);
    }
  }
});

test("zeros at the end are left out", () => assert.equal(toDigits(0.1000001, 4), "0.1"));

test("an interval is written outward, with few digits", () => {
  assert.deepEqual(intervalText(0.09684358910987266, 0.0976576477982353, null), { lower: "0.09684", upper: "0.09766", limit: "" });
});

test("what is written is on the same side of the limit as what is meant", () => {
  const close = intervalText(0.0999999, 0.19999999, 0.2);
  assert.ok(Number(close.upper) <= 0.2 && Number(close.lower) <= 0.2);
  const above = intervalText(0.20000001, 0.3, 0.2);
  assert.ok(Number(above.lower) > 0.2, above.lower);
  const inside = intervalText(0.1, 0.20000001, 0.2);
  assert.ok(Number(inside.upper) > 0.2, inside.upper);
});

test("... also of a limit with many digits, whether it is written in full or not", () => {
  for (const [lower, upper, limit] of [[0.12, 0.12346, 0.12346999999], [0.123461, 0.2, 0.12346000001], [0.1, 0.1234649999, 0.12346499999]] as const) {
    const text = intervalText(lower, upper, limit);
    for (const end of [limit, Number(text.limit)]) {
      assert.equal(Number(text.upper) <= end, upper <= limit, `${text.upper} and ${String(end)}`);
      assert.equal(Number(text.lower) > end, lower > limit, `${text.lower} and ${String(end)}`);
    }
  }
});

test("a unit cannot change the text direction", () => assert.equal(spaces(withUnits("0.35", "\u202Emm\u202C")), "0.35 mm"));

test("equal bounds are one number, and zero is zero", () => {
  assert.equal(intervalWords(0, 0, "mm"), "0\u00A0mm");
  assert.equal(intervalWords(2, 2, ""), "2");
});

test("an upper end that is not known", () => {
  assert.equal(intervalText(0.5, null, null).upper, "unknown");
  assert.equal(spaces(intervalWords(0.5, null, "mm")), "at least 0.5 mm");
  assert.equal(intervalWords(0, null, "mm"), "not known yet");
  assert.equal(intervalWords(0, Infinity, "mm"), "not known yet");
});

test("huge and tiny bounds", () => {
  assert.equal(intervalWords(1e-300, 1e300, ""), "1e-300 to 1e300");
  assert.ok(!intervalWords(5e-324, 1.7976931348623157e308, "").includes("NaN"));
});

test("counts, bytes, times and shares", () => {
  assert.deepEqual([0, 999, 1000, 1234567].map(grouped), ["0", "999", "1,000", "1,234,567"]);
  assert.deepEqual([17, 257455, 5034660, 3e9].map(inBytes).map(spaces), ["17 B", "257 kB", "5.03 MB", "3 GB"]);
  assert.deepEqual([0, 0.0007, 6.8, 47.2, 5210, 125000].map(inTime).map(spaces), ["0 ms", "< 0.01 ms", "6.8 ms", "47.2 ms", "5.21 s", "2.08 min"]);
  assert.deepEqual([400, 12_340, 125_000].map(onClock).map(spaces), ["0.4 s", "12.3 s", "2 min 05 s"]);
  assert.deepEqual([0, 0.99267578125, 0.99999999, 1, 25].map((x) => spaces(inPercent(x))), ["0 %", "99.27 %", "99.99 %", "100 %", "2500 %"]);
});

test("a share that is a bound is not written below it", () => {
  assert.equal(spaces(inPercentAbove(0.012341, 3)), "1.24 %");
  assert.equal(spaces(inPercentAbove(1, 3)), "100 %");
});

test("points and units", () => {
  assert.equal(pointText([0.32270512, -1, -5.55e-17]), "(0.322705, -1, 0)");
  assert.equal(pointText([3e-7, 1.23456789e-6, 0]), "(3e-7, 1.234568e-6, 0)");
  assert.equal(pointText([0, 0, 0]), "(0, 0, 0)");
  assert.notEqual(pointText([1000000.05, 0, 0]), pointText([1000000.15, 0, 0])); // far from the origin, points stay apart
  assert.equal(withUnits("1", ""), "1");
});
