import assert from "node:assert/strict";
import { test } from "node:test";
import { unsearched } from "../../../server/web/page/result/directions.js";
import { comparison, directed } from "./samples.js";

test("a direction without a search was proved, or had no time", () => {
  assert.match(unsearched(comparison(), directed(0, 0), "A", "B"), /Proved .* surface of A is the same as that of B, or a part of it/);
  assert.match(unsearched(comparison({ status: "timeout" }), directed(0, 0), "B", "A"), /Proved/);
  assert.match(unsearched(comparison(), directed(0, 0.1), "A", "B"), /Proved without a search: bounds/);
  for (const status of ["timeout", "cancelled", "gate_decided"] as const)
    assert.match(unsearched(comparison({ status }), directed(0, null), "A", "B"), /ended before/, status);
});
