// Meshes that the tests make, and those of the corpus. A mesh is {points: Float64Array, triangles: Uint32Array}.
import { existsSync, mkdirSync, writeFileSync } from "node:fs";
import { join } from "node:path";

// The same numbers everywhere: mulberry32.
function random(seed) {
  let state = seed;
  return () => {
    state = (state + 0x6d2b79f5) | 0;
    let t = Math.imul(state ^ (state >>> 15), 1 | state);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
  };
}

// A closed sheet of columns x rows quads: `at(u, v)` with u and v in [0, 1] gives the point. Around u it is closed, and so
// around v where `ring` is true.
export function sheet(columns, rows, at, { closed = true, ring = false } = {}) {
  const wide = closed ? columns : columns + 1, high = ring ? rows : rows + 1;
  const points = new Float64Array(3 * wide * high), triangles = new Uint32Array(6 * columns * rows);
  for (let j = 0; j < high; ++j)
    for (let i = 0; i < wide; ++i) points.set(at(i / columns, j / rows, i, j), 3 * (j * wide + i));
  let k = 0;
  for (let j = 0; j < rows; ++j)
    for (let i = 0; i < columns; ++i) {
      const a = j * wide + i, b = j * wide + ((i + 1) % wide), c = ((j + 1) % high) * wide + i, d = c - a + b;
      for (const corner of [a, c, d, a, d, b]) triangles[k++] = corner;
    }
  return { points, triangles };
}

// A sphere of 4 n^2 triangles; `radius(direction)` or a number.
export function sphere(n, radius = 1, centre = [0, 0, 0]) {
  const of = typeof radius === "function" ? radius : () => radius;
  return sheet(2 * n, n, (u, v) => {
    const t = Math.PI * v, p = 2 * Math.PI * u, across = v === 1 ? 0 : Math.sin(t); // closed: sin(pi) is not 0
    const d = [across * Math.cos(p), across * Math.sin(p), Math.cos(t)], r = of(d);
    return d.map((x, k) => centre[k] + r * x);
  });
}

// A smooth dent around a direction, `depth` deep.
export function dented(n, depth = 0.1, centre = [0, 0, 0]) {
  return sphere(n, (d) => 1 - depth * Math.exp(-20 * (1 - (d[0] + 2 * d[1] + 2 * d[2]) / 3)), centre);
}

// The unit square at height z, its vertices off by up to `rough`: two of them, not of the same grid, keep an engine busy.
export function rough(n, height, seed) {
  const next = random(seed);
  return sheet(n, n, (u, v) => [u, v, height * (next() - 0.5)], { closed: false });
}

export function scaled(mesh, factor, offset = [0, 0, 0]) {
  return { ...mesh, points: mesh.points.map((x, k) => x * factor + offset[k % 3]) };
}

// --- files ------------------------------------------------------------------------------------------------------

export function obj({ points, triangles }) {
  const lines = [];
  for (let k = 0; k < points.length; k += 3) lines.push(`v ${points[k]} ${points[k + 1]} ${points[k + 2]}`);
  for (let k = 0; k < triangles.length; k += 3)
    lines.push(`f ${triangles[k] + 1} ${triangles[k + 1] + 1} ${triangles[k + 2] + 1}`);
  return Buffer.from(lines.join("\n") + "\n");
}

export function xyz({ points }) {
  const lines = [];
  for (let k = 0; k < points.length; k += 3) lines.push(points.subarray(k, k + 3).join(" "));
  return Buffer.from(lines.join("\n") + "\n");
}

// Binary, little-endian, single precision.
export function ply({ points, triangles }) {
  const head = `ply\nformat binary_little_endian 1.0\nelement vertex ${points.length / 3}\nproperty float x\nproperty float y\n` +
    `property float z\nelement face ${triangles.length / 3}\nproperty list uchar int vertex_indices\nend_header\n`;
  const body = Buffer.alloc(4 * points.length + 13 * (triangles.length / 3));
  let at = 0;
  for (const x of points) at = body.writeFloatLE(x, at);
  for (let k = 0; k < triangles.length; k += 3) {
    at = body.writeUInt8(3, at);
    for (let c = 0; c < 3; ++c) at = body.writeInt32LE(triangles[k + c], at);
  }
  return Buffer.concat([Buffer.from(head), body]);
}

// Binary; the normals are 0, as readers allow.
export function stl({ points, triangles }) {
  const file = Buffer.alloc(84 + 50 * (triangles.length / 3));
  file.writeUInt32LE(triangles.length / 3, 80);
  for (let k = 0, at = 84; k < triangles.length; k += 3, at += 50)
    for (let c = 0; c < 3; ++c)
      for (let x = 0; x < 3; ++x) file.writeFloatLE(points[3 * triangles[k + c] + x], at + 12 + 12 * c + 4 * x);
  return file;
}

// Writes {name: bytes} into a folder and gives {name: path}.
export function written(folder, files) {
  mkdirSync(folder, { recursive: true });
  const paths = {};
  for (const [name, bytes] of Object.entries(files)) writeFileSync((paths[name] = join(folder, name)), bytes);
  return paths;
}

// The path of a mesh of the corpus (MESHGAUGE_CORPUS), or null.
export function corpus(name) {
  const folder = process.env.MESHGAUGE_CORPUS;
  const path = folder ? join(folder, "meshes", name) : null;
  return path && existsSync(path) ? path : null;
}
