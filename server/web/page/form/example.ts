// Two meshes to try the page with, made here as OBJ text: a sphere, and a coarser one with a dent.
import type { Vec3 } from "../api/types.js";

const dentAt: Vec3 = normalised([0.3, -0.8, 0.42]);
const dentRadius = 0.45; // as an angle
const dentDepth = 0.1; // relative to the sphere's radius

/** The baseline: a sphere of radius 20. */
export function sphere(rings = 48): string {
  return toObj("sphere", rings, () => 1);
}

/** The candidate: as sphere(), with a smooth dent 2 deep. */
export function dentedSphere(rings = 64): string {
  return toObj("dented", rings, (direction) => 1 - dentDepth * bump(angleBetween(direction, dentAt) / dentRadius));
}

export function exampleFiles(): { a: File; b: File } {
  return {
    a: new File([dentedSphere()], "dented-sphere.obj", { type: "model/obj" }),
    b: new File([sphere()], "sphere.obj", { type: "model/obj" }),
  };
}

const scale = 20;

function toObj(name: string, rings: number, radius: (direction: Vec3) => number): string {
  const segments = 2 * rings;
  const lines = [`o ${name}`];
  for (const direction of directions(rings, segments)) {
    const r = scale * radius(direction);
    lines.push(`v ${direction.map((x) => (r * x).toFixed(6)).join(" ")}`);
  }
  for (const corners of faces(rings, segments)) lines.push(`f ${corners.map((i) => i + 1).join(" ")}`);
  return lines.join("\n") + "\n";
}

// The poles are first and last, the rings between them.
function directions(rings: number, segments: number): Vec3[] {
  const all: Vec3[] = [[0, 0, 1]];
  for (let ring = 1; ring < rings; ++ring) {
    const polar = (Math.PI * ring) / rings;
    for (let i = 0; i < segments; ++i) {
      const turn = (2 * Math.PI * i) / segments;
      all.push([Math.sin(polar) * Math.cos(turn), Math.sin(polar) * Math.sin(turn), Math.cos(polar)]);
    }
  }
  all.push([0, 0, -1]);
  return all;
}

function faces(rings: number, segments: number): Vec3[] {
  const at = (ring: number, i: number) => 1 + (ring - 1) * segments + (i % segments);
  const last = 1 + (rings - 1) * segments;
  const all: Vec3[] = [];
  for (let i = 0; i < segments; ++i) {
    all.push([0, at(1, i), at(1, i + 1)]);
    for (let ring = 1; ring < rings - 1; ++ring) {
      all.push([at(ring, i), at(ring + 1, i), at(ring + 1, i + 1)], [at(ring, i), at(ring + 1, i + 1), at(ring, i + 1)]);
    }
    all.push([last, at(rings - 1, i + 1), at(rings - 1, i)]);
  }
  return all;
}

function normalised(v: Vec3): Vec3 {
  const length = Math.hypot(...v);
  return [v[0] / length, v[1] / length, v[2] / length];
}

function angleBetween(v: Vec3, w: Vec3): number {
  return Math.acos(Math.min(1, Math.max(-1, v[0] * w[0] + v[1] * w[1] + v[2] * w[2])));
}

// 1 in the middle, 0 from 1 on, smooth at both ends.
function bump(x: number): number {
  return x >= 1 ? 0 : (1 - x * x) ** 2;
}
