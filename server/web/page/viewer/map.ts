// Reads the service's deviation map (GLB, api/map/deviation_glb.h) into arrays. Needs one primitive without animation, texture or
// skin; three.js's GLTFLoader would add 90 kB, and gives access to extras only after it has built a scene. Every length,
// index and number is checked; an Error says what is wrong.

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

type Json = null | boolean | number | string | Json[] | { [name: string]: Json };
type Fields = Record<string, Json>;

const kMagic = 0x46546c67; // "glTF"
const kJsonChunk = 0x4e4f534a;
const kBinaryChunk = 0x004e4942;
const kFloat = 5126;
const kUnsignedInt = 5125;
const kPoints = 0;
const kTriangles = 4;
const kWidths = { SCALAR: 1, VEC3: 3 } as const;

function fail(what: string): never {
  throw new Error(`The deviation map cannot be read: ${what}.`);
}

function objectOf(value: Json | undefined, name: string): Fields {
  if (value === null || typeof value !== "object" || Array.isArray(value)) fail(`${name} is missing or not an object`);
  return value;
}

function arrayOf(value: Json | undefined, name: string): Json[] {
  if (!Array.isArray(value)) fail(`${name} is missing or not a list`);
  return value;
}

function wholeOf(value: Json | undefined, name: string, missing?: number): number {
  if (value === undefined && missing !== undefined) return missing;
  if (typeof value !== "number" || !Number.isInteger(value) || value < 0) fail(`${name} is not a whole number`);
  return value;
}

interface Chunks {
  json: Uint8Array;
  binary: Uint8Array<ArrayBuffer>;
}

function chunksOf(bytes: ArrayBuffer): Chunks {
  const view = new DataView(bytes);
  if (view.byteLength < 20) fail(`its ${view.byteLength} bytes are too few for a GLB`);
  if (view.getUint32(0, true) !== kMagic) fail("it is not a GLB");
  if (view.getUint32(4, true) !== 2) fail(`it is glTF ${view.getUint32(4, true)}, not 2`);
  const total = view.getUint32(8, true);
  if (total !== view.byteLength) fail(`it should be ${total} bytes long and is ${view.byteLength}`);
  const found = new Map<number, Uint8Array<ArrayBuffer>>();
  for (let at = 12; at < total; ) {
    if (at + 8 > total) fail("a chunk is cut short");
    const size = view.getUint32(at, true);
    const kind = view.getUint32(at + 4, true);
    if (at + 8 + size > total) fail("a chunk reaches beyond its end");
    if (!found.has(kind)) found.set(kind, new Uint8Array(bytes, at + 8, size));
    at += 8 + size;
  }
  const json = found.get(kJsonChunk);
  if (!json) fail("it has no JSON");
  return { json: json, binary: found.get(kBinaryChunk) ?? new Uint8Array(0) };
}

function parsed(json: Uint8Array): Fields {
  let value: Json;
  try {
    value = JSON.parse(new TextDecoder("utf-8", { fatal: true }).decode(json)) as Json;
  } catch {
    fail("its JSON is broken");
  }
  return objectOf(value, "the document");
}

// Reads the subset of binary glTF 2.0 that a deviation map uses. Any other file ends in an Error that names the defect.
class GlbReader {
  private readonly document: Fields;
  private readonly binary: Uint8Array<ArrayBuffer>;

  constructor(bytes: ArrayBuffer) {
    const chunks = chunksOf(bytes);
    this.document = parsed(chunks.json);
    this.binary = chunks.binary;
  }

  namedNode(name: string): Fields {
    for (const node of arrayOf(this.document.nodes, "the list of nodes")) {
      const fields = objectOf(node, "a node");
      if (fields.name === name) return fields;
    }
    return fail(`it has no node "${name}"`);
  }

  // Returns the first primitive of the node's mesh.
  primitiveOf(node: Fields): Fields {
    const mesh = this.member("meshes", node.mesh, "the mesh");
    const primitive = objectOf(arrayOf(mesh.primitives, "the primitives")[0], "the first primitive");
    const mode = wholeOf(primitive.mode, "the mode", kTriangles);
    if (mode !== kTriangles && mode !== kPoints) fail("its mesh is neither of triangles nor of points");
    return primitive;
  }

  // Whether a primitive is of points.
  isCloud(primitive: Fields): boolean {
    return primitive.mode === kPoints;
  }

  translationOf(node: Fields): [number, number, number] {
    for (const name of ["matrix", "rotation", "scale"]) {
      if (node[name] !== undefined) fail(`its node has a ${name}, which meshgauge never writes`);
    }
    if (node.translation === undefined) return [0, 0, 0];
    const moved = arrayOf(node.translation, "the translation");
    if (moved.length !== 3 || !moved.every((x) => typeof x === "number" && Number.isFinite(x))) {
      fail("its translation is not three numbers");
    }
    return moved as [number, number, number];
  }

  // Returns a copy, so that the file's bytes can be freed.
  floats(accessor: Json | undefined, type: keyof typeof kWidths, name: string): Float32Array {
    return new Float32Array(this.bytesOf(accessor, type, kFloat, name));
  }

  indices(accessor: Json | undefined): Uint32Array {
    return new Uint32Array(this.bytesOf(accessor, "SCALAR", kUnsignedInt, "the list of triangles"));
  }

  private member(list: string, index: Json | undefined, name: string): Fields {
    const all = arrayOf(this.document[list], `the list of ${list}`);
    const at = wholeOf(index, `the number of ${name}`);
    if (at >= all.length) fail(`${name} has number ${at} of ${all.length}`);
    return objectOf(all[at], name);
  }

  private bytesOf(index: Json | undefined, type: keyof typeof kWidths, component: number, name: string): ArrayBuffer {
    const accessor = this.member("accessors", index, name);
    if (accessor.type !== type) fail(`${name} is not of type ${type}`);
    if (accessor.componentType !== component) fail(`${name} has numbers of another kind than ${component}`);
    if (accessor.sparse !== undefined) fail(`${name} is sparse`);
    const view = this.member("bufferViews", accessor.bufferView, `the bytes of ${name}`);
    if (wholeOf(view.buffer, "the number of the buffer") !== 0) fail(`${name} lies in another file`);
    const element = 4 * kWidths[type];
    if (wholeOf(view.byteStride, "the stride", element) !== element) fail(`${name} is interleaved`);
    const size = element * wholeOf(accessor.count, `the count of ${name}`);
    const within = wholeOf(accessor.byteOffset, "an offset", 0);
    const from = wholeOf(view.byteOffset, "an offset", 0) + within;
    if (within + size > wholeOf(view.byteLength, "a length") || from + size > this.binary.length) {
      fail(`${name} reaches beyond the end of its bytes`);
    }
    return this.binary.slice(from, from + size).buffer;
  }
}
