import assert from "node:assert/strict";
import { File } from "node:buffer";
import { createHash } from "node:crypto";
import { test } from "node:test";
import { bundle, hasScene, pairUp, pathsIn } from "../../../server/web/page/form/pairing.js";
import { formatOf } from "../../../server/web/page/form/slot.js";

Object.assign(globalThis, { File }); // of a browser; global in later versions of Node

const file = (name: string, content = "") => new File([content], name) as unknown as globalThis.File;
const scene = (...uris: string[]) => JSON.stringify({ buffers: uris.map((uri) => ({ uri })) });
const names = async (...files: globalThis.File[]) => (await pairUp(files)).files.map(({ name }) => name);
const complaint = async (...files: globalThis.File[]) => (await pairUp(files)).complaint;

test("the archive is that of the service, byte for byte", async () => {
  const made = await bundle(file("any.gltf", scene("x.bin")), [
    { path: "x.bin", content: file("x.bin", "abc") },
    { path: "sub/ä.bin", content: file("ä.bin", "de") },
  ]);
  assert.ok(made);
  assert.equal(made.name, "any.gltf.zip");
  assert.equal(made.type, "application/zip");
  const digest = createHash("sha256").update(new Uint8Array(await made.arrayBuffer())).digest("hex");
  // tests/server/http/comparison_form_test.cpp has the same.
  assert.equal(digest, "98ead8770aaa7e0f62eed5be5e86f7fce4602a8b818a4319bc7a85036f5eef31");
});

test("the paths that a .gltf names", () => {
  assert.deepEqual(pathsIn(scene("x.bin", "./a//b%20c.bin", "100%.bin", "%C3%A4.bin")), ["x.bin", "a/b c.bin", "100%.bin", "ä.bin"]);
  assert.deepEqual(pathsIn("\uFEFF" + scene("x.bin", "data:application/octet-stream;base64,AAAA")), ["x.bin"]);
  for (const uri of ["../x", "a/%2e%2e/x", "/x", "%2Fx", "http://h/x", "file:///x", "C:x", "a\\x", "a/", "."]) {
    assert.deepEqual(pathsIn(scene("x.bin", uri)), [], uri);
  }
  for (const text of ["", "{", "null", "[]", '{"buffers": 3}', '{"buffers": [3, {"uri": 4}, {}]}']) assert.deepEqual(pathsIn(text), []);
});

test("a .gltf and the files that it names are one mesh", async () => {
  const [gltf, bin, picture, stl] = [file("s.gltf", scene("sub/x.bin")), file("x.bin", "abc"), file("p.png"), file("t.stl")];
  assert.deepEqual(await names(bin, gltf, picture), ["s.gltf.zip"]);
  assert.deepEqual(await names(stl, bin, gltf), ["t.stl", "s.gltf.zip"]);
  assert.deepEqual(await names(file("S.GLTF", scene("a.bin")), file("a.bin"), file("u.gltf", scene("b.bin")), file("b.bin")), ["S.GLTF.zip", "u.gltf.zip"]);
  assert.deepEqual(await names(file("whole.gltf", scene("data:,"))), ["whole.gltf"]);
  assert.deepEqual(await names(file("broken.gltf", "{")), ["broken.gltf"]); // the service says what is wrong with it
  assert.equal(hasScene([bin, gltf]), true);
  assert.equal(hasScene([bin, stl, file("s.gltf.gz")]), false);
});

test("missing and ambiguous files are reported", async () => {
  const gltf = file("s.gltf", scene("sub/x.bin"));
  assert.equal(await complaint(gltf), "s.gltf names the file “sub/x.bin”: drop or choose both together, or a .zip of them.");
  assert.match(await complaint(gltf, file("y.bin")), /^s.gltf names the file/);
  assert.equal(await complaint(gltf, file("x.bin"), file("x.bin")), "Several of these files are called “x.bin”: take one mesh at a time, or a .zip of each.");
});

test("an archive is said to be a glTF", () => assert.equal(formatOf("s.gltf.zip"), "glTF, zipped"));
