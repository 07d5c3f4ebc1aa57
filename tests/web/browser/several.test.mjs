// A glTF of several files: chosen together for one place, dropped at once for both, and with one of them missing.
import assert from "node:assert/strict";
import { lookup, todays, workplace } from "./workplace.mjs";

const test = todays(3);
const place = workplace();

// A square at this height, whose numbers are in the file `bin`.
function square(height, bin) {
  const numbers = new Float32Array([0, 0, height, 1, 0, height, 1, 1, height, 0, 1, height]);
  const corners = new Uint16Array([0, 1, 2, 0, 2, 3]);
  const scene = {
    asset: { version: "2.0" }, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0 }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0 }, indices: 1 }] }],
    accessors: [{ bufferView: 0, componentType: 5126, count: 4, type: "VEC3" }, { bufferView: 1, componentType: 5123, count: 6, type: "SCALAR" }],
    bufferViews: [{ buffer: 0, byteLength: 48 }, { buffer: 0, byteOffset: 48, byteLength: 12 }],
    buffers: [{ byteLength: 60, uri: `buffers/${bin}` }],
  };
  return [
    { name: bin.replace(".bin", ".gltf"), mimeType: "model/gltf+json", buffer: Buffer.from(JSON.stringify(scene)) },
    { name: bin, mimeType: "", buffer: Buffer.concat([Buffer.from(numbers.buffer), Buffer.from(corners.buffer)]) },
  ];
}

async function drop(page, selector, files) {
  const sent = files.map(({ name, buffer }) => [name, buffer.toString("base64")]);
  const transfer = await page.evaluateHandle((all) => {
    const data = new DataTransfer();
    for (const [name, text] of all) data.items.add(new File([Uint8Array.from(atob(text), (c) => c.charCodeAt(0))], name));
    return data;
  }, sent);
  await page.dispatchEvent(selector, "drop", { dataTransfer: transfer });
}

const shown = (page, side) => page.locator(`#slot-${side} .file-name`);

async function measures(walk) {
  await walk.measure();
  await walk.measured();
  const { result } = await walk.job();
  assert.ok(result.distance.lower <= 2 && result.distance.upper >= 2);
  assert.deepEqual([result.meshes.a.format, result.meshes.a.notes], ["gltf", []]);
  walk.tab.assertClean({ expected: [lookup] });
  await walk.tab.close();
}

test("a .gltf and its .bin, chosen together for each place", async () => {
  const walk = await place.open(), { page } = walk;
  await walk.fill({ a: square(0, "low.bin"), b: square(2, "high.bin") });
  await page.locator("#slot-b .file-name").waitFor();
  await walk.reads("#slot-a .file-name", /^low\.gltf\.zip$/);
  await walk.reads("#slot-a .file-facts", /glTF, zipped/);
  await measures(walk);
});

test("four files, dropped at once on the page", async () => {
  const walk = await place.open(), { page } = walk;
  await drop(page, "#form-view", [...square(0, "low.bin"), ...square(2, "high.bin")]);
  await shown(page, "b").waitFor();
  await walk.reads("#slot-a .file-name", /^low\.gltf\.zip$/);
  await walk.reads("#slot-b .file-name", /^high\.gltf\.zip$/);
  await measures(walk);
});

test("a file that is missing is named at the place that the mesh was for, until it comes", async () => {
  const walk = await place.open(), { page } = walk;
  const [scene, data] = square(0, "low.bin");
  await drop(page, "#slot-b", [scene]);
  const error = page.locator("#file-b-error:not([hidden])");
  await error.waitFor();
  assert.equal(await error.textContent(), "low.gltf names the file “buffers/low.bin”: drop or choose both together, or a .zip of them.");
  assert.equal(await shown(page, "b").count(), 0);
  await drop(page, "#slot-b", [data, scene]);
  await shown(page, "b").waitFor();
  assert.equal(await error.count(), 0);
  await walk.tab.close();
});
