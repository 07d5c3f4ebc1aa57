// Reads the service's deviation map (GLB, api/deviation_glb.h) into arrays. Needs one primitive without animation, texture or
// skin; three.js's GLTFLoader would add 90 kB, and gives access to extras only after it has built a scene. Every length,
// index and number is checked; an Error says what is wrong.
import { GlbReader, objectOf, type Json } from "./glb";

export interface Display {
  form: "as_is" | "refined" | "decimated";
  triangles: number; // of the whole mesh, not of the displayed one; 0: a point cloud
  vertices: number;
}

export interface DeviationMap {
  positions: Float32Array; // xyz, relative to `translation`
  indices: Uint32Array; // three per triangle, all within `positions`; of a point cloud each vertex three times
  cloud: boolean;
  distances: Float32Array; // one per vertex, finite, not negative
  sides?: Float32Array; // one per vertex: 1 outside of the other mesh, -1 inside, 0 where neither is proved
  noSides?: string; // why there are none though they were asked for
  translation: [number, number, number];
  units: string; // may be empty
  display: Display;
  // The end of the file's colours: the limit, or the largest distance of the whole mesh without one.
  scale?: { top: number; limited: boolean };
}

// Throws if the file is not as the service writes it.
export function parseMap(bytes: ArrayBuffer): Promise<DeviationMap> {
  return new Promise((resolve) => resolve(mapOf(bytes)));
}

function mapOf(bytes: ArrayBuffer): DeviationMap {
  const reader = new GlbReader(bytes);
  const node = reader.namedNode("candidate");
  const primitive = reader.primitiveOf(node);
  const attributes = objectOf(primitive.attributes, "the attributes of the mesh");
  const positions = reader.floats(attributes.POSITION, "VEC3", "POSITION");
  const distances = reader.floats(attributes._DISTANCE, "SCALAR", "_DISTANCE");
  const cloud = reader.isCloud(primitive);
  const indices = cloud ? pointIndices(positions.length / 3) : reader.indices(primitive.indices);
  checkArrays(positions, distances, indices);
  const sides = attributes._SIDE === undefined ? undefined : reader.floats(attributes._SIDE, "SCALAR", "_SIDE");
  if (sides) checkSides(sides, distances.length);
  const extras = objectOf(node.extras ?? {}, "the extras of the mesh");
  return {
    positions,
    indices,
    cloud,
    distances,
    ...(sides ? { sides } : {}),
    ...(typeof extras.no_sides === "string" ? { noSides: extras.no_sides } : {}),
    translation: reader.translationOf(node),
    units: typeof extras.units === "string" ? extras.units : "",
    display: displayOf(extras, positions.length / 3, cloud ? 0 : indices.length / 3),
    ...scaleOf(extras),
  };
}

function pointIndices(points: number): Uint32Array {
  return new Uint32Array(3 * points).map((_, i) => Math.floor(i / 3));
}

function checkArrays(positions: Float32Array, distances: Float32Array, indices: Uint32Array): void {
  const vertices = positions.length / 3;
  if (distances.length !== vertices) {
    throw new Error(`The deviation map has ${vertices} vertices and ${distances.length} distances.`);
  }
  if (indices.length % 3 !== 0) {
    throw new Error(`The deviation map has ${indices.length} indices; triangles need a multiple of three.`);
  }
  for (const index of indices) {
    if (index >= vertices) throw new Error(`The deviation map names vertex ${index} and has only ${vertices}.`);
  }
  for (let v = 0; v < vertices; ++v) {
    if (!(distances[v]! >= 0 && distances[v]! < Infinity)) {
      throw new Error(`The deviation map's distance at vertex ${v} is not a length.`);
    }
    if (!Number.isFinite(positions[3 * v]! + positions[3 * v + 1]! + positions[3 * v + 2]!)) {
      throw new Error(`The deviation map's vertex ${v} is not a finite point.`);
    }
  }
}

function checkSides(sides: Float32Array, vertices: number): void {
  if (sides.length !== vertices) throw new Error(`The deviation map has ${vertices} vertices and ${sides.length} sides.`);
  const wrong = sides.findIndex((side) => side !== 0 && side !== 1 && side !== -1);
  if (wrong >= 0) throw new Error(`The deviation map's side at vertex ${wrong} is neither 1, 0 nor -1.`);
}

function countOf(value: Json | undefined): number | undefined {
  return typeof value === "number" && Number.isInteger(value) && value >= 0 ? value : undefined;
}

const kForms = ["as_is", "refined", "decimated"] as const;

// Files of `meshgauge check --deviation` have no "display": they are refined or the mesh itself.
function displayOf(extras: Record<string, Json>, vertices: number, triangles: number): Display {
  const display = objectOf(extras.display ?? {}, "what the map says about display");
  const whole = countOf(display.triangles) ?? countOf(extras.candidate_triangles) ?? triangles;
  const form = kForms.find((one) => one === display.form);
  if (display.form !== undefined && !form) throw new Error("The deviation map has a form of display that is unknown.");
  return {
    form: form ?? (triangles > whole ? "refined" : "as_is"),
    triangles: whole,
    vertices: countOf(display.vertices) ?? countOf(extras.candidate_vertices) ?? vertices,
  };
}

function scaleOf(extras: Record<string, Json>): Pick<DeviationMap, "scale"> {
  const limited = typeof extras.limit === "number";
  const top = limited ? extras.limit : extras.largest;
  return typeof top === "number" && top >= 0 ? { scale: { top, limited } } : {};
}
