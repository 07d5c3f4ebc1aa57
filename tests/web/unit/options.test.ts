import assert from "node:assert/strict";
import { test } from "node:test";
import { asTyped, buildOptions, hasPlace, noValues, valuesOf, type FormValues } from "../../../server/web/page/form/options.js";
import { formatOf } from "../../../server/web/page/form/slot.js";
import { curlCommand, gatesYaml, optionsOf } from "../../../server/web/page/text/snippets.js";
import { areaGate, comparison, gate, share } from "./samples.js";
import type { MeshFacts } from "../../../server/web/page/api/types.js";

const build = (values: Partial<FormValues>) => buildOptions({ ...noValues, ...values });
const blamed = (values: Partial<FormValues>) => build(values).mistakes.map(({ field }) => field);

test("an empty form asks for nothing", () => assert.deepEqual(build({}).options, {}));

test("everything that can be asked for", () => {
  const built = build({
    limit: "0.05", units: "mm", direction: "a_to_b", toleranceKind: "relative", tolerance: "0.5", strategy: "n_point", points: "31",
    timeout: "2.5", threads: "4", statistics: true, align: true,
  });
  assert.deepEqual(built.options, {
    gate: { max_distance: 0.05, narrow: true, units: "mm" }, direction: "a_to_b", tolerance: { relative: 0.005 }, strategy: "n_point", points: 31,
    timeout: 2.5, threads: 4, statistics: true, align: "rigid",
  });
});

test("tolerances are percent where they are shares", () => {
  assert.deepEqual(build({ toleranceKind: "absolute", tolerance: "0.5" }).options, { tolerance: { absolute: 0.5 } });
  assert.deepEqual(build({ toleranceKind: "diagonal", tolerance: "0.01" }).options, { tolerance: { diagonal: 0.0001 } });
  assert.deepEqual(build({ toleranceKind: "default", tolerance: "nonsense" }).options, {});
});

test("a limit may have its unit with it, or be a share", () => {
  assert.deepEqual(build({ limit: " 0.05 mm " }).options?.["gate"], { max_distance: "0.05 mm", narrow: true });
  assert.deepEqual(build({ limit: "0.05mm", units: "in" }).options?.["gate"], { max_distance: "0.05mm", narrow: true, units: "in" });
  assert.deepEqual(build({ limit: "0.5 %" }).options?.["gate"], { max_distance: "0.5 %", narrow: true });
  assert.deepEqual(build({ limit: " 1e-3 " }).options?.["gate"], { max_distance: 0.001, narrow: true });
  assert.deepEqual(build({ limit: "0" }).options?.["gate"], { max_distance: 0, narrow: true });
});

test("what is no number goes as it was typed: the service says what is wrong", () => {
  for (const typed of ["abc", "0,5", "1 2", "NaN", "Infinity", "1e999", "0x10", "1_000"]) {
    const asked = { limit: typed, inside: typed, outside: typed, toleranceKind: "relative", tolerance: typed, timeout: typed, threads: typed } as const;
    const whole = { gate: { max_distance: typed, narrow: true, zone: [`-${typed}`, typed] }, tolerance: { relative: typed }, timeout: typed, threads: typed };
    assert.deepEqual(build(asked).options, whole);
  }
  assert.deepEqual(build({ limit: "-1", units: "mm" }).options?.["gate"], { max_distance: -1, narrow: true, units: "mm" });
});

test("what is missing is said at its field", () => {
  assert.deepEqual(blamed({ toleranceKind: "absolute", tolerance: " ", inside: "1", further: "{" }), ["further", "outside", "tolerance"]);
});

test("units of the meshes are declared, one or both", () => {
  assert.deepEqual(build({ unitA: "in" }).options, { units: { a: "in" } });
  assert.deepEqual(build({ limit: "1", units: "mm", unitA: "in", unitB: "m" }).options, { gate: { max_distance: 1, narrow: true, units: "mm" }, units: { a: "in", b: "m" } });
});

test("points apply to one strategy only", () => {
  assert.deepEqual(build({ strategy: "four_point", points: "5" }).options, { strategy: "four_point" });
  assert.deepEqual(build({ strategy: "n_point", points: "31" }).options, { strategy: "n_point", points: 31 });
});

test("numbers as people write them", () => {
  assert.deepEqual([" .5 ", "5.", "+2", "1E3", "", "1_000 "].map(asTyped), [0.5, 5, 2, 1000, "", "1_000"]);
});

const box = { min: [0, 0, 0], max: [1, 1, 1] };
const expect = { watertight: true, triangles: { max: 20000 }, degenerate: 0, volume: { within: 0.01, min: 900 } };
const topology: MeshFacts["topology"] = {
  watertight: true, oriented: true, components: 1, euler_characteristic: 2, edges: 18, open_edges: { count: 0, first: null },
  non_manifold_edges: { count: 0, first: null }, flipped_edges: { count: 0, first: null }, volume: { lower: 1, upper: 1 },
};
const examined = { ...comparison().meshes, a: { ...comparison().meshes.a, topology } };
const beyond = { status: "complete" as const, pieces: 2, beyond: [{ distance: 0.1, share: { lower: 0, upper: 0.5 } }], quantiles: [], mean: null, rms: null };
const sides = { certified: true as const, status: "complete" as const, length_tolerance: 0.1, pieces: 1, refused: null, outside: null, inside: null };
const region = (name: string, more: object) => ({
  name, ...more, distance: { lower: 0.1, upper: 0.2 }, status: "converged", empty: false, precision_floor: 0, a_to_b: null, b_to_a: null, verdict: null,
});
const moved = { moved: "a" as const, method: "best_fit" as const, transform: { row_major: [1, 0, 0, 5, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1] }, angle_degrees: 0, shift: 5,
  largest_displacement: 5, residual: 0.1, residual_before: 5, samples: 8192, principal_axes: false, overlap: 1, converged: true, steps: 3, starts: 19 };

test("the form that leads to a result asks for the same", () => {
  const results = [
    comparison({ expect, meshes: examined }),
    comparison({ gate: { ...gate(0.05), uncertainty: 0.01 }, expect: { triangles: 12 }, meshes: examined, alignment: { ...moved, overlap: 0.5 } }),
    comparison({ gate: gate(2, null), regions: [region("bore", { box, max_distance: 1 }), region("rest", { max_distance: 2 })] }),
    comparison({ gate: areaGate }),
    comparison({ gate: { max_distance: null, zone: [-0.05, 0.1], uncertainty: 0.01, units: "mm" }, sides }),
    comparison({ sides, areas: { certified: true, share_tolerance: 0.001, length_tolerance: 0.02, a_to_b: beyond, b_to_a: null } }),
    comparison({ tolerance: { ...comparison().tolerance, asked: { absolute: 0.25, relative: 0.1 } }, alignment: { ...moved, method: "given" } }),
    comparison(),
    comparison({ gate: gate(0.05), direction: "b_to_a" }),
    comparison({ meshes: { ...comparison().meshes, b: { ...comparison().meshes.b, unit: { name: "in", source: "declared" } } } }),
    comparison({ gate: gate(2, null), tolerance: { ...comparison().tolerance, asked: { relative: 0.07 } } }),
    comparison({ tolerance: { ...comparison().tolerance, asked: { absolute: 0.25 } }, engine: { ...comparison().engine, strategy: "n_point", points: 109 } }),
  ];
  for (const result of results) assert.deepEqual(buildOptions(valuesOf(result)).options, optionsOf(result));
});

test("limits of each side, alone or beside another", () => {
  assert.deepEqual(build({ inside: "0.05", outside: "0.1", units: "mm" }).options, { gate: { zone: [-0.05, 0.1], narrow: true, units: "mm" } });
  assert.deepEqual(build({ inside: "-0.05", outside: "+0", limit: "1" }).options, { gate: { max_distance: 1, narrow: true, zone: [-0.05, 0] } });
  assert.deepEqual(build({ outside: "1" }).mistakes, [{ field: "inside", message: "Enter both limits; 0 for a side that allows nothing." }]);
  assert.deepEqual(build({ inside: "- 0.05 mm", outside: "0.5 %" }).options, { gate: { zone: ["-0.05 mm", "0.5 %"], narrow: true } });
  const values = valuesOf(comparison({ gate: { max_distance: null, zone: [-0.05, 0.1], units: "mm" } }));
  assert.deepEqual([values.limit, values.inside, values.outside, values.units], ["", "0.05", "0.1", "mm"]);
});

test("further options are merged with those of the fields", () => {
  const further = { expect, regions: [{ name: "bore", box }], gate: { uncertainty: 0.01 }, timeout_ms: 7 };
  assert.deepEqual(build({ limit: "1", further: JSON.stringify(further) }).options, { ...further, gate: { max_distance: 1, narrow: true, uncertainty: 0.01 } });
  assert.deepEqual(build({ further: ' {"statistics": {"samples": 5000}}\n' }).options, { statistics: { samples: 5000 } });
  const area = { max_share_beyond: { distance: 0.05, share: 0.01 } };
  assert.deepEqual(build({ units: "mm", further: JSON.stringify({ gate: area }) }).options, { gate: { ...area, narrow: true, units: "mm" } });
  assert.deepEqual(build({ limit: "1", further: '{"gate": {"narrow": false}}' }).options, { gate: { max_distance: 1, narrow: false } });
  assert.deepEqual(build({ further: '{"gate": 5, "units": {}, "toString": 1}' }).options, { gate: 5, units: {}, toString: 1 }, "the service says what is wrong");
  assert.equal(JSON.stringify(build({ further: '{"__proto__": {"threads": 2}}' }).options), '{"__proto__":{"threads":2}}');
});

test("a further option that a field has, too, is named", () => {
  const named = (values: Partial<FormValues>) => build(values).mistakes.map(({ field, message }) => [field, /"(.*?)"/.exec(message)?.[1]]);
  assert.deepEqual(named({ limit: "1", further: '{"gate": {"max_distance": 1}}' }), [["further", "gate.max_distance"]]);
  assert.deepEqual(named({ unitA: "mm", threads: "2", further: '{"units": {"a": "in", "b": "mm"}, "threads": 2}' }), [["further", "units.a"], ["further", "threads"]]);
  assert.deepEqual(named({ align: true, further: '{"align": {"overlap": 0.5}}' }), [["further", "align"]]);
  assert.deepEqual(named({ direction: "a_to_b", further: '{"direction": "a_to_b"}' }), [["further", "direction"]]);
  for (const further of ["bore", "[1]", "5", "null", '"x"', "{"]) assert.deepEqual(blamed({ further }), ["further"], further);
});

test("a place is among the further options, or is not", () => {
  const further = { expect: { triangles: { max: 1 } }, regions: [1] };
  for (const place of ["/expect", "/expect/triangles/max", "/regions/0/box"]) assert.ok(hasPlace(further, place), place);
  for (const place of ["/gate", "/expect/volume", "/toString"]) assert.ok(!hasPlace(further, place), place);
});

test("a result states what was expected, in the manifest in its own form", () => {
  const result = comparison({ expect, meshes: examined });
  assert.deepEqual(optionsOf(result), { expect });
  assert.deepEqual(optionsOf(comparison({ expect: { triangles: 12 }, meshes: examined })), { expect: { triangles: 12 }, topology: true });
  assert.ok(curlCommand("http://host", { a: "a.stl", b: "b.stl" }, optionsOf(result), false).includes(`-F 'options=${JSON.stringify({ expect })}'`));
  const lines = gatesYaml(result, { a: "a.stl", b: "b.stl" }).split("\n").filter((line) => line.includes("expect"));
  assert.deepEqual(lines, ['    expect: {"watertight":true,"triangles":{"max":20000},"degenerate":0,"volume":{"within":"1 %","min":900}}']);
  assert.ok(!gatesYaml(comparison(), { a: "a.stl", b: "b.stl" }).includes("expect"));
});

test("a result states its alignment", () => {
  assert.equal(optionsOf(comparison({ alignment: moved })).align, "rigid");
  assert.equal(valuesOf(comparison({ alignment: moved })).align, true);
  assert.deepEqual(optionsOf(comparison({ alignment: { ...moved, principal_axes: true, overlap: 0.5 } })).align, { principal_axes: true, overlap: 0.5 });
  assert.deepEqual(optionsOf(comparison({ alignment: { ...moved, start: moved.transform } })).align, { transform: moved.transform, fit: true });
  assert.deepEqual(optionsOf(comparison({ alignment: { ...moved, method: "given" } })).align, { transform: moved.transform });
  assert.match(gatesYaml(comparison({ alignment: moved }), { a: "a.stl", b: "b.stl" }), /\n {4}align: rigid\n/);
});

test("a result states the certified areas that were asked for", () => {
  const found = { status: "complete" as const, pieces: 2, beyond: [{ distance: 0.1, share: { lower: 0, upper: 0.5 } }], quantiles: [], mean: null, rms: null };
  const areas = { certified: true as const, share_tolerance: 0.001, length_tolerance: 0.02, a_to_b: null, b_to_a: found };
  assert.deepEqual(optionsOf(comparison({ areas })).areas, { beyond: [0.1], share_tolerance: 0.001, length_tolerance: 0.02 });
});

test("a result states the limit of the area, and not the question that it asked", () => {
  const found = { status: "complete" as const, pieces: 2, beyond: [{ distance: 0.05, share: { lower: 0, upper: 0.5 } }], quantiles: [], mean: null, rms: null };
  const areas = { certified: true as const, share_tolerance: 0.001, length_tolerance: 0.02, a_to_b: found, b_to_a: null };
  const result = comparison({ areas, gate: areaGate, criteria: [share("undecided", 0, 0.5)] });
  assert.equal(optionsOf(result).areas, undefined);
  assert.deepEqual(optionsOf(result).gate, { max_share_beyond: areaGate.max_share_beyond, narrow: true, units: "mm" });
  assert.equal(valuesOf(result).limit, "");
});

test("formats by name", () => {
  const names = ["a.STL", "b.obj.gz", "c.gltf", "d.png", "noname", ".gz", "x.3mf"];
  assert.deepEqual(names.map(formatOf), ["STL", "OBJ, gzip-compressed", "glTF", null, null, null, "3MF"]);
});
