// Reads the subset of binary glTF 2.0 that a deviation map uses. Any other file ends in an Error that names the defect.

export type Json = null | boolean | number | string | Json[] | { [name: string]: Json };
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

export function objectOf(value: Json | undefined, name: string): Fields {
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

export class GlbReader {
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
