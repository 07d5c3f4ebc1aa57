// Problems as a user sees them: which file or field they are about, and what to do.
import assert from "node:assert/strict";
import { dented, obj, ply, sphere } from "./meshes.mjs";
import { Walk } from "./page.mjs";
import { lookup, todays, workplace } from "./workplace.mjs";

const good = obj(sphere(8));
const test = todays(2);
const place = workplace(() => ({
  "good.obj": good,
  "other.obj": obj(dented(8)),
  "cut_off.ply": ply(sphere(8)).subarray(0, 600),
  "broken.obj": Buffer.from("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n"),
  "nan.obj": Buffer.from("v 0 0 0\nv 1 nan 0\nv 0 1 0\nf 1 2 3\n"),
  "picture.png": Buffer.from("89504e470d0a1a0a0000000d49484452", "hex"),
  "empty.stl": Buffer.alloc(84),
  "large.obj": Buffer.concat([good, Buffer.alloc(200_000, "# nothing\n")]),
}), { serve: ["--max-part-bytes", "100000"] });

async function trouble(walk, name) {
  const box = walk.page.locator("#trouble");
  await walk.page.waitForFunction(() => document.querySelector("#trouble")?.textContent !== "");
  await walk.tab.shot(`problem_${name}`, { whole: true });
  return box.innerText();
}

const refused = [
  ["cut_off.ply", /truncated/i, 422],
  ["broken.obj", /vertex 9|index|inconsistent/i, 422],
  ["nan.obj", /nan|not a number|no number/i, 422],
  ["picture.png", /OBJ, STL, PLY/, 415],
  ["empty.stl", /no (surface|triangles?)|empty|0 triangles/i, 422],
];

test("a file that cannot be measured is refused in words that name it, and another one is taken instead", async (all) => {
  const walk = await place.open(), expected = [lookup];
  await walk.fill({ b: place.files["good.obj"] });
  for (const [name, words, status] of refused)
    await all.test(name, async () => {
      await walk.fill({ a: place.files[name] });
      await walk.measure();
      const said = await trouble(walk, name.replace(".", "_"));
      assert.match(said, words);
      await walk.reads("#main", /Candidate/);
      assert.ok(await walk.page.locator("#form-view").isVisible(), "the form is there to try again");
      expected.push(new RegExp(`${status}.*/v1/comparisons`));
      walk.tab.assertClean({ expected });
    });
  await walk.fill({ a: place.files["other.obj"] });
  await walk.measure();
  await walk.measured();
  walk.tab.assertClean({ expected });
  await walk.tab.close();
});

test("a file above the limit is refused with the limit", async () => {
  const walk = await place.open();
  await walk.fill({ a: place.files["good.obj"], b: place.files["large.obj"] });
  await walk.measure();
  const said = await trouble(walk, "too_large");
  assert.match(said, /100[,. ]?000|100 kB/);
  assert.match(said, /smaller|gzip/);
  assert.match(said, /Baseline \(B\)/);
  await walk.reads("#slot-b", /larger than the limit/);
  walk.tab.assertClean({ expected: [lookup, /413|ERR_/] });
  await walk.tab.close();
});

test("what is missing, and fields that make no sense, are named beside them before any mesh is sent", async () => {
  const walk = await place.open(), { page } = walk;
  await walk.fill({ a: place.files["good.obj"], limit: "0,5", timeout: "1000" });
  await walk.measure();
  await walk.reads("#form-view", /Choose the baseline/);
  assert.deepEqual(walk.tab.requests.filter((line) => line.includes("/v1/")), []);
  await walk.fill({ b: place.files["other.obj"], inside: "1 parsec", outside: "2" });
  await walk.measure();
  await walk.reads("#limit-error", /^Must be a number .* write the decimals behind a point\.$/);
  await walk.reads("#inside-error", /^Must have a unit of length /);
  await walk.reads("#timeout-error", /^Must be from 1 ms to 180 s, not '1000'\.$/);
  await walk.tab.shot("problem_fields", { whole: true });
  assert.equal(await page.locator("#limit").getAttribute("aria-invalid"), "true");
  assert.deepEqual(walk.tab.requests.filter((line) => line.includes("/v1/meshes")), []);
  walk.tab.assertClean({ expected: [/422.*\/v1\/options/] });
  await walk.tab.close();
});

test("a link to nothing says so, and leads to the form", async () => {
  const tab = await place.tab(), walk = new Walk(tab);
  await tab.go("/c/00000000000000000000000000000000");
  assert.match(await trouble(walk, "link"), /no such comparison/i);
  tab.assertClean({ expected: [/404/] });
  await tab.page.getByRole("link", { name: "meshgauge" }).click();
  await tab.page.locator("#form-view").waitFor();
  await tab.close();
});

test("the page reports a service that is gone, and the same order succeeds when it is back", async () => {
  const walk = await place.open(), { context } = walk.tab;
  await walk.fill({ a: place.files["good.obj"], b: place.files["other.obj"] });
  await context.setOffline(true);
  await walk.measure();
  assert.match(await trouble(walk, "offline"), /did not answer/);
  await context.setOffline(false);
  await walk.measure();
  await walk.measured();
  walk.tab.assertClean({ expected: [lookup, /ERR_INTERNET_DISCONNECTED/] });
  await walk.tab.close();
});
