// Facts of a mesh for display: bounding box, orientation, edges, a coarse version for moving pictures.
import type { Vec3 } from "./vec";

export interface Mesh {
  positions: Float32Array;
  indices: Uint32Array;
  cloud?: boolean; // the triangles are points
}

export interface Bounds {
  low: Vec3;
  high: Vec3;
}

// The box of the vertices that triangles use; null for a mesh without triangles.
export function boundsOf({ positions, indices }: Mesh, moved: Vec3): Bounds | undefined {
  if (indices.length === 0) return undefined;
  const low: Vec3 = [Infinity, Infinity, Infinity];
  const high: Vec3 = [-Infinity, -Infinity, -Infinity];
  for (const index of indices) {
    for (let k = 0; k < 3; ++k) {
      const x = positions[3 * index + k]!;
      if (x < low[k]!) low[k] = x;
      if (x > high[k]!) high[k] = x;
    }
  }
  return { low: low.map((x, k) => x + moved[k]!) as Vec3, high: high.map((x, k) => x + moved[k]!) as Vec3 };
}

// The distance from a point to the farthest vertex that a triangle uses.
export function reachOf({ positions, indices }: Mesh, moved: Vec3, from: Vec3): number {
  const [x, y, z] = [from[0] - moved[0], from[1] - moved[1], from[2] - moved[2]];
  let most = 0;
  for (const index of indices) {
    const [u, v, w] = [positions[3 * index]! - x, positions[3 * index + 1]! - y, positions[3 * index + 2]! - z];
    most = Math.max(most, u * u + v * v + w * w);
  }
  return Math.sqrt(most);
}

export function unionOf(all: readonly (Bounds | undefined)[]): Bounds {
  const some = all.filter((one): one is Bounds => one !== undefined);
  if (some.length === 0) return { low: [-1, -1, -1], high: [1, 1, 1] };
  const pick = (k: number, end: "low" | "high", of: (...x: number[]) => number): number => of(...some.map((b) => b[end][k]!));
  return {
    low: [0, 1, 2].map((k) => pick(k, "low", Math.min)) as Vec3,
    high: [0, 1, 2].map((k) => pick(k, "high", Math.max)) as Vec3,
  };
}

// Six times the enclosed volume; negative if the triangles' fronts face inwards.
export function signedVolume({ positions: p, indices }: Mesh): number {
  if (indices.length === 0) return 0;
  const o = 3 * indices[0]!;
  const [ox, oy, oz] = [p[o]!, p[o + 1]!, p[o + 2]!];
  let sum = 0;
  for (let i = 0; i < indices.length; i += 3) {
    const [a, b, c] = [3 * indices[i]!, 3 * indices[i + 1]!, 3 * indices[i + 2]!];
    const [ax, ay, az] = [p[a]! - ox, p[a + 1]! - oy, p[a + 2]! - oz];
    const [bx, by, bz] = [p[b]! - ox, p[b + 1]! - oy, p[b + 2]! - oz];
    const [cx, cy, cz] = [p[c]! - ox, p[c + 1]! - oy, p[c + 2]! - oz];
    sum += ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx);
  }
  return sum;
}

// Each edge once, two indices per edge, in linear time: edges are grouped by their smaller vertex, with few in each group.
// Works in steps of some ten thousand triangles, so that input is not blocked.
export function* edgesInSteps({ positions, indices }: Mesh): Generator<undefined, Uint32Array> {
  const vertices = positions.length / 3;
  const begins = new Uint32Array(vertices + 1);
  for (let i = 0; i < indices.length; i += kStep) {
    eachEdge(indices.subarray(i, i + kStep), (low) => ++begins[low + 1]!);
    yield;
  }
  for (let v = 0; v < vertices; ++v) begins[v + 1]! += begins[v]!;
  const others = new Uint32Array(begins[vertices]!);
  const filled = begins.slice(0, vertices);
  for (let i = 0; i < indices.length; i += kStep) {
    eachEdge(indices.subarray(i, i + kStep), (low, high) => (others[filled[low]!++] = high));
    yield;
  }
  const edges = new Uint32Array(2 * others.length);
  let size = 0;
  for (let v = 0; v < vertices; ++v) {
    size = addEdges(v, others.subarray(begins[v], begins[v + 1]), edges, size);
    if (v % (kStep / 3) === 0) yield;
  }
  return edges.slice(0, size);
}

const kStep = 30_000; // indices

export function edgesOf(mesh: Mesh): Uint32Array {
  const steps = edgesInSteps(mesh);
  for (;;) {
    const step = steps.next();
    if (step.done) return step.value;
  }
}

// Appends the distinct values of `ends` to `edges`; returns its new size.
function addEdges(vertex: number, ends: Uint32Array, edges: Uint32Array, size: number): number {
  ends.sort();
  for (let i = 0; i < ends.length; ++i) {
    if (i > 0 && ends[i] === ends[i - 1]) continue;
    edges[size++] = vertex;
    edges[size++] = ends[i]!;
  }
  return size;
}

function eachEdge(indices: Uint32Array, visit: (low: number, high: number) => void): void {
  for (let i = 0; i < indices.length; i += 3) {
    for (let k = 0; k < 3; ++k) {
      const a = indices[i + k]!;
      const b = indices[i + ((k + 1) % 3)]!;
      if (a !== b) visit(Math.min(a, b), Math.max(a, b));
    }
  }
}

// Returns at most about `most` triangles between vertices of the mesh, by vertex clustering: one vertex represents all of a
// grid cell. The same buffers of positions and distances serve both meshes. O(n).
export function coarsened(mesh: Mesh, most: number): Uint32Array {
  if (mesh.indices.length / 3 <= most) return mesh.indices;
  if (mesh.cloud) return thinned(mesh.indices, most);
  const box = boundsOf(mesh, [0, 0, 0])!;
  const size = Math.max(...[0, 1, 2].map((k) => box.high[k]! - box.low[k]!)) || 1;
  let cells = Math.max(4, Math.sqrt(most / 4));
  let found = clustered(mesh, box.low, size / cells);
  for (let i = 0; i < 3 && (found.length > 3 * most || found.length < 1.5 * most); ++i) {
    cells *= Math.sqrt((2.4 * most) / Math.max(found.length, 1));
    if (cells > 2e5) break;
    found = clustered(mesh, box.low, size / cells);
  }
  return found;
}

// Returns `most` points at most, evenly many all over the list.
function thinned(indices: Uint32Array, most: number): Uint32Array {
  const step = Math.ceil(indices.length / 3 / most);
  return indices.filter((_, i) => Math.floor(i / 3) % step === 0);
}

function clustered({ positions, indices }: Mesh, low: Vec3, cell: number): Uint32Array {
  const side = 2 ** 17;
  const first = new Map<number, number>();
  const stands = new Int32Array(positions.length / 3).fill(-1);
  const standsFor = (v: number): number => {
    if (stands[v]! >= 0) return stands[v]!;
    const at = (k: number): number => Math.floor((positions[3 * v + k]! - low[k]!) / cell);
    const key = (at(0) * side + at(1)) * side + at(2);
    const known = first.get(key);
    if (known === undefined) first.set(key, v);
    return (stands[v] = known ?? v);
  };
  const kept = new Uint32Array(indices.length);
  let size = 0;
  for (let i = 0; i < indices.length; i += 3) {
    const [a, b, c] = [standsFor(indices[i]!), standsFor(indices[i + 1]!), standsFor(indices[i + 2]!)];
    if (a === b || b === c || c === a) continue;
    kept[size++] = a;
    kept[size++] = b;
    kept[size++] = c;
  }
  return kept.slice(0, size);
}
