// Documents of the service for the tests, as openapi.yaml has them.
import type { Comparison, Directed, MeshFacts, Verdict } from "../../../server/web/page/api/types.js";
import type { Criterion } from "../../../server/web/page/text/criteria.js";

function mesh(name: string): MeshFacts {
  return {
    format: "obj", format_mismatch: null, unit: { name: null, source: "unknown" }, bytes: 1000, sha256: name.repeat(64).slice(0, 64), vertices: 8, triangles: 12,
    degenerate: 0, bbox: { low: [0, 0, 0], high: [1, 1, 1] }, diagonal: 1.7320508075688772, gzip: false, polygons: { count: 0, concave: 0, non_planar: 0, self_crossing: 0, largest_deviation: 0 },
    skipped_primitives: 0, unused_objects: 0, helper_objects: 0, welded_vertices: 0, notes: [],
  };
}

export function directed(lower: number, upper: number | null, triangle = 3): Directed {
  return {
    lower, upper,
    witness: { point_a: [1, 2, 3], triangle_a: triangle, point_b: [1, 2, 4], triangle_b: 5 },
    culling: { triangles: 12, survivors: 0, rate: 1 },
    work: { nearest_queries: 1, cache_hits: 0, triangle_tests: 1, subdivisions: 0, max_depth: 0, peak_heap: 0 },
  };
}

// As of two meshes without a unit.
function unitOf({ gate }: Partial<Comparison>): Comparison["unit"] {
  return gate?.units ? { name: gate.units as Comparison["unit"]["name"], source: "assumed" } : { name: null, source: "unknown" };
}

export function comparison(change: Partial<Comparison> = {}): Comparison {
  return {
    id: "0".repeat(32), status: "converged", verdict: null, gate: null, unit: unitOf(change), notes: [], direction: "symmetric",
    distance: { lower: 0.0968, upper: 0.0976 },
    a_to_b: directed(0.0967, 0.0976), b_to_a: directed(0.0968, 0.09763, 7),
    tolerance: {
      asked: { diagonal: 1e-6, relative: 0.01 },
      reached: { absolute: 0.0008, diagonal: 0.0002, relative: 0.0084 },
      met_by: "relative",
    },
    precision_floor: 7e-14,
    timings_ms: { queue: 0, read_a: 1, read_b: 1, build: 1, traverse: 3, reduce: 0.5, certify: 0.02, total: 6.8 },
    meshes: { a: mesh("a"), b: mesh("b") },
    engine: { version: "0.2.0", strategy: "auto", points: null, simd: "avx512", threads: 1 },
    statistics: null,
    foremost: null,
    criteria: [],
    ...change,
  };
}

/** A limit of a distance; its name as the service makes it. */
export function limited(verdict: Verdict, lower: number, upper: number, limit: number, change: Partial<Criterion> = {}): Criterion {
  const { region = null, side = null } = change;
  const name = side ? `distance ${side}` : region === "rest" ? "distance outside of all regions" : region ? `distance in ${region}` : "distance";
  return { name, of: "distance", verdict, finding: `the ${name} is found`, region, side, limit, uncertainty: 0, lower, upper, status: "gate_decided", witness: null, refused: null, ...change };
}

/** At most 1 % of the area beyond 0.05 mm. */
export function share(verdict: Verdict, lower: number, upper: number): Criterion {
  return { ...limited(verdict, lower, upper, 0.01, { beyond: 0.05 }), name: "share beyond", of: "share", finding: "the share is found" };
}

export function expectation(name: string, verdict: Verdict, found: string, expected: string): Criterion {
  return { name, of: "expectation", verdict, found, expected, finding: `${name}: ${found}, expected ${expected}` };
}

/** A gate of area alone. */
export const areaGate = { max_distance: null, max_share_beyond: { distance: 0.05, share: 0.01 }, units: "mm" };

export const gate = (max_distance: number, units: string | null = "mm") => ({ max_distance, units });
