import assert from "node:assert/strict";
import { test } from "node:test";
import { disposition, hex } from "../../../server/web/page/api/upload.js";
import { toEvent } from "../../../server/web/page/api/watch.js";
import type { Job } from "../../../server/web/page/api/types.js";
import { exampleFiles } from "../../../server/web/page/form/example.js";
import { damagedWords, idWithin, pathOf, routeOf } from "../../../server/web/page/route.js";
import { curlCommand, gatesYaml } from "../../../server/web/page/text/snippets.js";
import { areaGate, comparison, gate } from "./samples.js";

const id = "0d67c9a2d1b307386f8fc157855c4351";

test("addresses", () => {
  assert.deepEqual(routeOf("/"), { view: "form" });
  assert.deepEqual(routeOf(pathOf(id)), { view: "comparison", id });
  assert.deepEqual(routeOf(`/c/${id}/`), { view: "comparison", id });
  assert.deepEqual(routeOf(pathOf(id, "batch")), { view: "batch", id });
  for (const path of [`/c/${id}/more`, `/d/${id}`, "/docs"]) assert.equal(routeOf(path).view, "unknown", path);
  for (const path of ["/b", "/c/", "/c/xyz", `/c/${id.toUpperCase()}`, `/c/${id}0`]) assert.equal(routeOf(path).view, "damaged", path);
  assert.deepEqual(routeOf("/b/0d67"), { view: "damaged", of: "batch", id: "0d67" });
});

test("a damaged link: what is wrong with it, and what it may have been", () => {
  assert.match(damagedWords("batch", id.slice(0, 9)), /to a batch .* This one has 9: the rest was cut off/);
  for (const other of ["nonsense", `${id}0`, `${id}).`, id.toUpperCase()]) assert.match(damagedWords("comparison", other), /to a comparison .* something else/, other);
  assert.deepEqual([id.toUpperCase(), `${id}).`, `<${id}>`].map(idWithin), [id, id, id]);
  for (const other of [id.slice(1), `${id}0`, `${id}-${id}`, ""]) assert.equal(idWithin(other), null, other);
});

test("a file's name as a header: quoted, in bytes, on one line", () => {
  assert.equal(disposition("part.stl"), 'attachment; filename="part.stl"');
  assert.equal(disposition('a"b\\c.stl'), 'attachment; filename="a\\"b\\\\c.stl"');
  assert.equal(disposition("a\r\nX: y"), 'attachment; filename="a__X: y"');
  assert.ok(Array.from(disposition("µ€😀.stl")).every((c) => c.charCodeAt(0) < 256));
});

test("a digest as text", () => assert.equal(hex(new Uint8Array([0, 15, 255]).buffer), "000fff"));

test("a job that is asked for is progress like any other", () => {
  const job: Job = {
    id, state: "running", created: "2026-03-01T12:00:00.000Z", started: "2026-03-01T12:00:01.000Z", finished: null, expires: null, tries: 1, gate: null,
    progress: { lower: 1, upper: 2, stage: "reduce" }, result: null, problem: null,
  };
  const now = Date.parse("2026-03-01T12:00:03.500Z");
  assert.deepEqual(toEvent(job, now), { state: "running", lower: 1, upper: 2, stage: "reduce", elapsed_ms: 2500 });
  assert.deepEqual(toEvent({ ...job, state: "queued", started: null, progress: null }, now), { state: "queued", lower: 0, upper: null, stage: null, elapsed_ms: 3500 });
});

test("the command for a shell survives odd names and units", () => {
  const names = { a: "it's; rm -rf.stl", b: "b.obj" };
  const told = curlCommand("http://h", names, { gate: { max_distance: 1, units: "'" } }, true);
  assert.equal(told, 'curl -sS -H "Authorization: Bearer $MESHGAUGE_KEY" -F a=@candidate.stl -F b=@b.obj \\\n'
    + "  -F 'options={\"gate\":{\"max_distance\":1,\"units\":\"'\\''\"}}' \\\n  http://h/v1/comparisons");
  assert.match(curlCommand("http://h", { a: "x.stl", b: "x.stl" }, {}, false), /a=@x.stl -F b=@baseline-x.stl \\/);
});

test("the gate for a pipeline", () => {
  const told = gatesYaml(comparison({ gate: gate(0.05), direction: "a_to_b" }), { a: "part.stl.gz", b: "part.stl" });
  assert.equal(told, [
    "# gates.yaml", "version: 1", "gates:", '  - name: "part"', '    candidate: "part.stl.gz"', '    baseline: "baselines/part.stl"',
    "    max_distance: 0.05 mm", "    direction: candidate_to_baseline", "",
  ].join("\n"));
});

test("the gate for a pipeline declares what was declared, and a number in the unit of mesh b is in that of the result", () => {
  const plain = comparison();
  const meshes = { ...plain.meshes, a: { ...plain.meshes.a, unit: { name: "in", source: "declared" } as const } };
  const unit = { name: "mm", source: "file" } as const;
  const told = gatesYaml(comparison({ gate: gate(0.05, "b"), unit, meshes }), { a: "a.stl", b: "b.3mf" });
  assert.match(told, /max_distance: 0.05 mm\n {4}units: \{candidate: in\}\n/);
  assert.match(gatesYaml(comparison({ unit }), { a: "a.stl", b: "b.3mf" }), /max_distance: 0.0976 mm {2}# just above/);
});

test("the gate for a pipeline has the limit of the area", () => {
  const told = gatesYaml(comparison({ gate: areaGate }), { a: "a.stl", b: "b.stl" });
  assert.match(told, /b.stl"\n {4}max_share_beyond: \{distance: 0.05 mm, share: 1 %\}\n$/);
  const both = gatesYaml(comparison({ gate: { ...areaGate, max_distance: 0.1 } }), { a: "a.stl", b: "b.stl" });
  assert.match(both, /max_distance: 0.1 mm\n {4}max_share_beyond/);
});

test("without a gate the limit is just above what was measured", () => {
  assert.match(gatesYaml(comparison(), { a: "a.stl", b: "b.stl" }), /max_distance: 0.0976 {2}# just above/);
});

test("the example is two closed meshes", async () => {
  for (const file of Object.values(exampleFiles())) {
    const lines = (await file.text()).trimEnd().split("\n");
    const vertices = lines.filter((line) => line.startsWith("v ")).length;
    const edges = new Map<string, number>();
    for (const line of lines.filter((one) => one.startsWith("f "))) {
      const corners = line.slice(2).split(" ").map(Number);
      assert.equal(corners.length, 3);
      corners.forEach((from, i) => {
        const to = corners[(i + 1) % 3] ?? 0;
        assert.ok(from >= 1 && from <= vertices);
        edges.set(`${String(from)}-${String(to)}`, (edges.get(`${String(from)}-${String(to)}`) ?? 0) + 1);
      });
    }
    for (const [edge, count] of edges) {
      assert.equal(count, 1, edge);
      assert.ok(edges.has(edge.split("-").reverse().join("-")), `${file.name}: ${edge} has no other side`);
    }
  }
});
