// The reader of deviation maps: what it takes, and that every broken file is refused in words.
import assert from "node:assert/strict";
import test from "node:test";
import { AreaDistribution } from "../../../server/web/page/viewer/distribution";
import { parseMap } from "../../../server/web/page/viewer/map";
import { shownAt } from "../../../server/web/page/viewer/settings";
import { coarsened } from "../../../server/web/page/viewer/shape";
import { notesOf } from "../../../server/web/page/viewer/words";

type Fields = Record<string, unknown>;

interface Parts {
  positions?: number[];
  distances?: number[];
  sides?: number[];
  indices?: number[];
  node?: Fields;
  change?: (document: Fields & { accessors: Fields[]; bufferViews: Fields[]; meshes: Fields[] }) => void;
}

const extras = { limit: 0.5, units: "mm", candidate_triangles: 1, candidate_vertices: 3 };

function glb({ positions = [0, 0, 0, 1, 0, 0, 0, 1, 0], distances = [0, 0.25, 1], indices = [0, 1, 2], sides, node = {}, change }: Parts = {}): ArrayBuffer {
  const arrays = [new Float32Array(positions), new Float32Array(distances), new Uint32Array(indices), ...(sides ? [new Float32Array(sides)] : [])];
  const types = ["VEC3", "SCALAR", "SCALAR", "SCALAR"];
  let at = 0;
  const bufferViews = arrays.map(({ byteLength }) => ({ buffer: 0, byteOffset: (at += byteLength) - byteLength, byteLength }));
  const accessors = arrays.map((array, i) => ({
    bufferView: i,
    componentType: i === 2 ? 5125 : 5126,
    type: types[i],
    count: i === 0 ? array.length / 3 : array.length,
  }));
  const document = {
    asset: { version: "2.0" },
    buffers: [{ byteLength: at }],
    bufferViews,
    accessors,
    meshes: [{ primitives: [{ mode: 4, attributes: { POSITION: 0, _DISTANCE: 1, ...(sides ? { _SIDE: 3 } : {}) }, indices: 2 }] }],
    nodes: [{ name: "candidate", mesh: 0, extras, ...node }],
  };
  change?.(document);
  return packed(JSON.stringify(document), arrays);
}

function packed(json: string, arrays: { buffer: ArrayBuffer }[]): ArrayBuffer {
  const text = new TextEncoder().encode(json.padEnd(Math.ceil(json.length / 4) * 4));
  const size = arrays.reduce((sum, { buffer }) => sum + buffer.byteLength, 0);
  const bytes = new Uint8Array(28 + text.length + size);
  new Uint32Array(bytes.buffer, 0, 5).set([0x46546c67, 2, bytes.length, text.length, 0x4e4f534a]);
  bytes.set(text, 20);
  new DataView(bytes.buffer).setUint32(20 + text.length, size, true);
  new DataView(bytes.buffer).setUint32(24 + text.length, 0x004e4942, true);
  let at = 28 + text.length;
  for (const { buffer } of arrays) {
    bytes.set(new Uint8Array(buffer), at);
    at += buffer.byteLength;
  }
  return bytes.buffer;
}

test("a map is read with its extras", async () => {
  const display = { form: "decimated", triangles: 1000, vertices: 502 };
  const map = await parseMap(glb({ node: { translation: [1e6, 0, -3], extras: { ...extras, display } } }));
  assert.deepEqual([...map.positions], [0, 0, 0, 1, 0, 0, 0, 1, 0]);
  assert.deepEqual([...map.distances], [0, 0.25, 1]);
  assert.deepEqual([...map.indices], [0, 1, 2]);
  assert.deepEqual(map.translation, [1e6, 0, -3]);
  assert.equal(map.units, "mm");
  assert.deepEqual(map.display, display);
  assert.deepEqual(map.scale, { top: 0.5, limited: true });
});

test("a map has sides, or says why it has none", async () => {
  const map = await parseMap(glb({ sides: [0, -1, 1] }));
  assert.deepEqual([...map.sides!], [0, -1, 1]);
  assert.equal(map.noSides, undefined);
  const without = await parseMap(glb({ node: { extras: { ...extras, no_sides: "the baseline is open: here" } } }));
  assert.equal(without.sides, undefined);
  assert.equal(without.noSides, "the baseline is open: here");
  const input = { a: without, b: without, limit: null, units: "mm", witnesses: [] };
  assert.ok(notesOf(input).includes("A has no sides of B: B is open: here."));
});

test("a point has a side only where the corners of its triangle prove one", async () => {
  const middle = { triangle: 0, weights: [0.25, 0.25, 0.5] as [number, number, number] };
  const at = async (sides?: number[]): Promise<unknown> => shownAt(await parseMap(glb({ distances: [1, 1, 1], ...(sides ? { sides } : {}) })), middle);
  assert.deepEqual(await at([0, 0, 0]), { distance: 1, path: "outside", proved: false });
  assert.deepEqual(await at([1, 1, 1]), { distance: 1, path: "outside", proved: true });
  assert.deepEqual(await at([1, 0, -1]), { distance: 1, path: "inside", proved: true });
  assert.deepEqual(await at(), { distance: 1, path: "plain", proved: false });
});

test("a map of points is a cloud", async () => {
  const display = { form: "decimated", triangles: 0, vertices: 1000 };
  const map = await parseMap(glb({
    node: { extras: { ...extras, candidate_triangles: 0, candidate_vertices: 1000, display } },
    change: ({ meshes }) => {
      const [primitive] = meshes[0]!.primitives as Fields[];
      primitive!.mode = 0;
      delete primitive!.indices;
    },
  }));
  assert.equal(map.cloud, true);
  assert.deepEqual([...map.indices], [0, 0, 0, 1, 1, 1, 2, 2, 2]);
  assert.deepEqual(map.display, display);
  assert.equal(new AreaDistribution(map).share(0, 0.3), 2 / 3);
  assert.deepEqual([...coarsened(map, 2)], [0, 0, 0, 2, 2, 2]);
  assert.deepEqual([...coarsened(map, 3)], [...map.indices]);
});

test("a map without display information is the mesh itself, or refined if it has more triangles", async () => {
  assert.equal((await parseMap(glb())).display.form, "as_is");
  const refined = await parseMap(glb({ indices: [0, 1, 2, 2, 1, 0], node: { extras: { largest: 1, candidate_triangles: 1 } } }));
  assert.deepEqual([refined.display.form, refined.display.triangles], ["refined", 1]);
  assert.deepEqual(refined.scale, { top: 1, limited: false });
});

test("a file that is cut short anywhere is refused", async () => {
  const whole = glb();
  for (let size = 0; size < whole.byteLength; ++size) {
    await assert.rejects(parseMap(whole.slice(0, size)), /The deviation map cannot be read: /, `${size} bytes`);
  }
});

test("a file that is cut short and says so is refused as well", async () => {
  const whole = glb();
  for (let size = 20; size < whole.byteLength; size += 4) {
    const part = whole.slice(0, size);
    new DataView(part).setUint32(8, size, true);
    await assert.rejects(parseMap(part), /The deviation map /, `${size} bytes`);
  }
});

const wrong: Record<string, [Parts, RegExp]> = {
  "an index beyond the vertices": [{ indices: [0, 1, 3] }, /names vertex 3 and has only 3/],
  "indices that are no triangles": [{ indices: [0, 1] }, /multiple of three/],
  "fewer distances than vertices": [{ distances: [0, 1] }, /3 vertices and 2 distances/],
  "a negative distance": [{ distances: [0, -1, 1] }, /distance at vertex 1/],
  "a distance that is no number": [{ distances: [NaN, 0, 1] }, /distance at vertex 0/],
  "a vertex at infinity": [{ positions: [0, 0, 0, 1, 0, 0, 0, Infinity, 0] }, /vertex 2 is not a finite point/],
  "fewer sides than vertices": [{ sides: [0, 1] }, /3 vertices and 2 sides/],
  "a side that is none": [{ sides: [0, 0.5, 1] }, /side at vertex 1/],
  "no mesh of that name": [{ node: { name: "other" } }, /no node "candidate"/],
  "a mesh that is not there": [{ node: { mesh: 7 } }, /number 7 of 1/],
  "a turned node": [{ node: { rotation: [0, 0, 0, 1] } }, /has a rotation/],
  "a translation of two numbers": [{ node: { translation: [1, 2] } }, /translation is not three numbers/],
  "an unknown form": [{ node: { extras: { display: { form: "melted" } } } }, /form of display that is unknown/],
  "an accessor of another type": [{ change: ({ accessors }) => (accessors[0]!.type = "VEC2") }, /POSITION is not of type VEC3/],
  "an accessor of other numbers": [{ change: ({ accessors }) => (accessors[2]!.componentType = 5123) }, /another kind/],
  "a sparse accessor": [{ change: ({ accessors }) => (accessors[1]!.sparse = {}) }, /_DISTANCE is sparse/],
  "a count beyond the bytes": [{ change: ({ accessors }) => (accessors[0]!.count = 4) }, /reaches beyond the end/],
  "an absurd count": [{ change: ({ accessors }) => (accessors[0]!.count = 2 ** 52) }, /reaches beyond the end/],
  "a count that is no number": [{ change: ({ accessors }) => (accessors[0]!.count = -1) }, /count of POSITION is not a whole number/],
  "an offset beyond the bytes": [{ change: ({ bufferViews }) => (bufferViews[2]!.byteOffset = 52) }, /reaches beyond the end/],
  "interleaved numbers": [{ change: ({ bufferViews }) => (bufferViews[0]!.byteStride = 16) }, /interleaved/],
  "bytes of another file": [{ change: ({ bufferViews }) => (bufferViews[0]!.buffer = 1) }, /another file/],
  "no nodes": [{ change: (document) => delete document["nodes"] }, /list of nodes is missing/],
  "a mesh of lines": [{ change: ({ meshes }) => (meshes[0]!.primitives = [{ mode: 1 }]) }, /neither of triangles nor of points/],
};

for (const [name, [parts, message]] of Object.entries(wrong)) {
  test(`refused: ${name}`, () => assert.rejects(parseMap(glb(parts)), message));
}

test("refused: what is no GLB, another version, broken JSON", async () => {
  const changed = (at: number, value: number): ArrayBuffer => {
    const bytes = glb();
    new DataView(bytes).setUint32(at, value, true);
    return bytes;
  };
  await assert.rejects(parseMap(changed(0, 1)), /not a GLB/);
  await assert.rejects(parseMap(changed(4, 1)), /glTF 1, not 2/);
  await assert.rejects(parseMap(changed(20, 0)), /JSON is broken/);
  await assert.rejects(parseMap(changed(16, 0)), /no JSON/);
});
