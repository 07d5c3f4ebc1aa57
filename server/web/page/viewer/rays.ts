// Intersects a ray with a mesh. Runs of triangles have a bounding ball, so most are skipped; nothing else is sorted or built,
// so that a million triangles are ready at once.
import { dot, sub, type Vec3 } from "./vec";
import type { Mesh } from "./shape";

const kRun = 64;

export interface Hit {
  t: number; // in lengths of the direction vector
  triangle: number;
  weights: Vec3; // of the triangle's corners
}

export class Rays {
  private readonly balls: Float64Array; // centre and radius of each run

  constructor(private readonly mesh: Mesh) {
    const runs = Math.ceil(mesh.indices.length / 3 / kRun);
    this.balls = new Float64Array(4 * runs);
    for (let run = 0; run < runs; ++run) this.balls.set(this.ballOf(run), 4 * run);
  }

  // Returns the first hit with from < t < to for which `accepts` returns true (its argument is a point in the mesh's own frame).
  first(origin: Vec3, direction: Vec3, from = 0, to = Infinity, accepts?: (p: Vec3) => boolean): Hit | undefined {
    const squared = dot(direction, direction);
    let best: Hit | undefined;
    for (let run = 0; 4 * run < this.balls.length; ++run) {
      if (this.misses(run, origin, direction, squared, from, best?.t ?? to)) continue;
      const end = Math.min((run + 1) * kRun, this.mesh.indices.length / 3);
      for (let triangle = run * kRun; triangle < end; ++triangle) {
        const hit = this.meet(triangle, origin, direction);
        if (!hit || hit.t <= from || hit.t >= (best?.t ?? to)) continue;
        if (accepts && !accepts([0, 1, 2].map((k) => origin[k]! + hit.t * direction[k]!) as Vec3)) continue;
        best = hit;
      }
    }
    return best;
  }

  private corner(triangle: number, k: number): Vec3 {
    const at = 3 * this.mesh.indices[3 * triangle + k]!;
    return [this.mesh.positions[at]!, this.mesh.positions[at + 1]!, this.mesh.positions[at + 2]!];
  }

  private ballOf(run: number): [number, number, number, number] {
    const { positions, indices } = this.mesh;
    const begin = 3 * run * kRun;
    const end = Math.min(begin + 3 * kRun, indices.length);
    const centre: Vec3 = [0, 0, 0];
    for (let i = begin; i < end; ++i) {
      for (let k = 0; k < 3; ++k) centre[k]! += positions[3 * indices[i]! + k]! / (end - begin);
    }
    let radius = 0;
    for (let i = begin; i < end; ++i) {
      const at = 3 * indices[i]!;
      const far = (positions[at]! - centre[0]) ** 2 + (positions[at + 1]! - centre[1]) ** 2 + (positions[at + 2]! - centre[2]) ** 2;
      if (far > radius) radius = far;
    }
    return [...centre, Math.sqrt(radius) * (1 + 1e-6)];
  }

  private misses(run: number, o: Vec3, d: Vec3, squared: number, from: number, to: number): boolean {
    const at = 4 * run;
    const x = this.balls[at]! - o[0];
    const y = this.balls[at + 1]! - o[1];
    const z = this.balls[at + 2]! - o[2];
    const radius = this.balls[at + 3]!;
    const along = (x * d[0] + y * d[1] + z * d[2]) / squared;
    const reach = radius / Math.sqrt(squared);
    if (along + reach < from || along - reach > to) return true;
    return x * x + y * y + z * z - along * along * squared > radius * radius;
  }

  // Möller and Trumbore, 1997.
  private meet(triangle: number, o: Vec3, d: Vec3): Hit | undefined {
    const a = this.corner(triangle, 0);
    const u = sub(this.corner(triangle, 1), a);
    const v = sub(this.corner(triangle, 2), a);
    const px = d[1] * v[2] - d[2] * v[1];
    const py = d[2] * v[0] - d[0] * v[2];
    const pz = d[0] * v[1] - d[1] * v[0];
    const determinant = u[0] * px + u[1] * py + u[2] * pz;
    if (determinant === 0) return undefined;
    const s = sub(o, a);
    const second = (s[0] * px + s[1] * py + s[2] * pz) / determinant;
    if (!(second >= 0 && second <= 1)) return undefined;
    const qx = s[1] * u[2] - s[2] * u[1];
    const qy = s[2] * u[0] - s[0] * u[2];
    const qz = s[0] * u[1] - s[1] * u[0];
    const third = (d[0] * qx + d[1] * qy + d[2] * qz) / determinant;
    if (!(third >= 0 && second + third <= 1)) return undefined;
    const t = (v[0] * qx + v[1] * qy + v[2] * qz) / determinant;
    return { t, triangle, weights: [1 - second - third, second, third] };
  }
}
