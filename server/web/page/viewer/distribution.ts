// The distribution of distance over a surface's area. Within a triangle the distance is linear between its vertices, as in
// the picture, so that shares and highlights agree to the pixel. Computed, not certified.
import type { Mesh } from "./shape";

// In a cloud each point counts as much as any other.
export interface Surface extends Mesh {
  distances: Float32Array;
}

// For a triangle with distances low <= middle <= high, returns the share of its area that is nearer than t.
export function shareBelow(t: number, low: number, middle: number, high: number): number {
  if (t <= low) return 0;
  if (t > high) return 1;
  if (t <= middle) return (t - low) ** 2 / ((middle - low) * (high - low));
  return 1 - (high - t) ** 2 / ((high - middle) * (high - low));
}

export class AreaDistribution {
  readonly of: "area" | "points";
  readonly total: number; // area, 0 if all triangles are degenerate; or the number of points
  readonly largest: number; // distance
  private readonly areas: Float64Array;
  private readonly sorted: Float32Array; // three distances per triangle, ascending

  constructor(surface: Surface) {
    this.of = surface.cloud ? "points" : "area";
    const triangles = surface.indices.length / 3;
    this.areas = new Float64Array(triangles);
    this.sorted = new Float32Array(surface.indices.length);
    let total = 0;
    let largest = 0;
    for (let t = 0; t < triangles; ++t) {
      this.sortDistances(surface, t);
      this.areas[t] = surface.cloud ? 1 : areaOf(surface, t);
      total += this.areas[t]!;
      largest = Math.max(largest, this.sorted[3 * t + 2]!);
    }
    this.total = total;
    this.largest = largest;
  }

  // Returns the share of the area with low <= distance <= high; 0 if there is no area.
  share(low: number, high: number): number {
    if (!(this.total > 0) || high < low) return 0;
    const above = nextAbove(high);
    const from = Math.min(low, Math.fround(low));
    let sum = 0;
    for (let t = 0; t < this.areas.length; ++t) {
      const [a, b, c] = [this.sorted[3 * t]!, this.sorted[3 * t + 1]!, this.sorted[3 * t + 2]!];
      if (c < from || a >= above) continue;
      sum += this.areas[t]! * (shareBelow(above, a, b, c) - shareBelow(from, a, b, c));
    }
    return Math.min(1, sum / this.total);
  }

  // Returns the share of the area between consecutive edges, ascending; a distance at the last edge belongs to the last bin.
  bins(edges: readonly number[]): Float64Array {
    const count = edges.length - 1;
    const shares = new Float64Array(count);
    if (!(this.total > 0)) return shares;
    for (let t = 0; t < this.areas.length; ++t) {
      const [a, b, c] = [this.sorted[3 * t]!, this.sorted[3 * t + 1]!, this.sorted[3 * t + 2]!];
      let below = 0;
      for (let i = binOf(edges, a); i < count && below < 1; ++i) {
        const next = i + 1 === count ? 1 : shareBelow(edges[i + 1]!, a, b, c);
        shares[i]! += (this.areas[t]! * (next - below)) / this.total;
        below = next;
      }
    }
    return shares;
  }

  private sortDistances({ indices, distances }: Surface, t: number): void {
    let a = distances[indices[3 * t]!]!;
    let b = distances[indices[3 * t + 1]!]!;
    let c = distances[indices[3 * t + 2]!]!;
    if (a > b) [a, b] = [b, a];
    if (b > c) [b, c] = [c, b];
    if (a > b) [a, b] = [b, a];
    this.sorted[3 * t] = a;
    this.sorted[3 * t + 1] = b;
    this.sorted[3 * t + 2] = c;
  }
}

// Distances are floats: one that equals `value` after rounding counts as within.
function nextAbove(value: number): number {
  return Math.max(value, Math.fround(value)) + Number.EPSILON * Math.max(value, Number.MIN_VALUE) + Number.MIN_VALUE;
}

function binOf(edges: readonly number[], value: number): number {
  let low = 0;
  let high = edges.length - 2;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (edges[middle]! <= value) low = middle;
    else high = middle - 1;
  }
  return low;
}

function areaOf({ positions: p, indices }: Surface, t: number): number {
  const [a, b, c] = [3 * indices[3 * t]!, 3 * indices[3 * t + 1]!, 3 * indices[3 * t + 2]!];
  const [ux, uy, uz] = [p[b]! - p[a]!, p[b + 1]! - p[a + 1]!, p[b + 2]! - p[a + 2]!];
  const [vx, vy, vz] = [p[c]! - p[a]!, p[c + 1]! - p[a + 1]!, p[c + 2]! - p[a + 2]!];
  return 0.5 * Math.hypot(uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx);
}
