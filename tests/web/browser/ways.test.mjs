// Ways through the page that cross: cancelling, going back, measuring again, a service that is away.
import assert from "node:assert/strict";
import { dented, obj, sheet, sphere, xyz } from "./meshes.mjs";
import { difference, picture, spot } from "./pixels.mjs";
import { asked } from "./service.mjs";
import { endless, endlessMeshes, lookup, todays, workplace } from "./workplace.mjs";

// A closed torus that faces outwards, of this inner radius.
const ring = (radius) => sheet(24, 12, (u, v) => {
  const [a, b] = [2 * Math.PI * u, -2 * Math.PI * v], wide = 1 + radius * Math.cos(b);
  return [wide * Math.cos(a), wide * Math.sin(a), radius * Math.sin(b)];
}, { ring: true });

const test = todays(3);
const place = workplace(() => ({
  "sphere.obj": obj(sphere(30)), "dented.obj": obj(dented(30)), "small.obj": obj(sphere(12)), "smaller.obj": obj(dented(12)),
  "scan.xyz": xyz(dented(20)), "away.obj": obj(dented(30, 0.1, [0.2, 0, 0.1])), "ring.obj": obj(ring(0.4)), "thick.obj": obj(ring(0.5)),
  ...endlessMeshes(),
}));

const isThere = (id) => asked(place.service, `/v1/comparisons/${id}`).then((answer) => answer.json());

async function running(walk) {
  await walk.fill(endless(place));
  await walk.measure();
  await walk.searching();
  return walk.id();
}

const stopped = (id) => asked(place.service, `/v1/comparisons/${id}`, { method: "DELETE" });

test("cancelling an order that waits for a busy service leaves the result it came from", async () => {
  const walk = await place.open(), { page } = walk;
  await walk.fill({ a: place.files["dented.obj"], b: place.files["sphere.obj"], limit: "0.0001", tolerance: ["diagonal", "1e-12"] });
  await walk.measure();
  await walk.measured();
  const id = walk.id();
  const busy = { type: "/problems/overloaded", title: "Busy", status: 503, detail: "Busy", errors: [] };
  await page.route("**/v1/comparisons", (route) =>
    route.fulfill({ status: 503, headers: { "Retry-After": "60", "Content-Type": "application/problem+json" }, body: JSON.stringify(busy) }));
  await walk.press("Narrow the interval");
  await page.locator("#waiting:not([hidden])").waitFor();
  await walk.press("Cancel");
  await walk.measured();
  assert.equal(walk.id(), id);
  assert.equal((await isThere(id)).state, "done");
  assert.deepEqual(walk.tab.requests.filter((line) => line.startsWith("DELETE")), []);
  assert.ok(await page.locator("#waiting").isHidden());
  await walk.tab.close();
});

test("cancelling a comparison that has ended unseen shows its result and forgets nothing", async () => {
  const walk = await place.open(), { page } = walk;
  await page.route("**/v1/comparisons/*/events", () => undefined); // the tab hears nothing
  await walk.fill(endless(place));
  await walk.measure();
  await page.waitForURL("**/c/*");
  const id = walk.id();
  await stopped(id);
  while (["queued", "running"].includes((await isThere(id)).state)) await page.waitForTimeout(50);
  await walk.press("Cancel");
  await page.waitForFunction(() => !document.querySelector("#result-view").hidden || document.querySelector("#trouble").textContent !== "");
  assert.equal((await isThere(id)).state, "cancelled");
  assert.deepEqual(walk.tab.requests.filter((line) => line.startsWith("DELETE")), []);
  await walk.tab.close();
});

test("a cancellation that does not arrive may be tried again", async () => {
  const walk = await place.open(), { page } = walk;
  const id = await running(walk);
  await page.route(`**/v1/comparisons/${id}/cancel`, (route) => route.abort());
  await walk.press("Cancel");
  await page.locator("#trouble .trouble").waitFor();
  await page.unroute(`**/v1/comparisons/${id}/cancel`);
  await walk.press("Cancel");
  await walk.measured();
  assert.equal((await isThere(id)).state, "cancelled");
  await walk.tab.close();
});

test("a comparison that the page loses sight of keeps its link, and is looked at again", async () => {
  const walk = await place.open(), { page } = walk;
  const failure = { type: "/problems/internal", title: "Broken", status: 500, detail: "Broken", errors: [] };
  await page.route("**/v1/comparisons/*/events", (route) =>
    route.fulfill({ status: 500, headers: { "Content-Type": "application/problem+json" }, body: JSON.stringify(failure) }));
  await walk.fill(endless(place));
  await walk.measure();
  await page.locator("#trouble .trouble").waitFor();
  const id = walk.id();
  await page.unroute("**/v1/comparisons/*/events");
  await walk.press("Look again");
  await page.locator("#run-view .band").waitFor();
  assert.equal(walk.id(), id);
  await stopped(id);
  await walk.tab.close();
});

test("a browser that keeps nothing for the page, and a key that no header may have", async () => {
  const walk = await place.open({}), { page } = walk;
  await page.addInitScript(() => {
    const blocked = () => {
      throw new DOMException("Access is denied for this document.", "SecurityError");
    };
    Object.defineProperty(globalThis, "sessionStorage", { get: blocked });
  });
  await page.reload();
  await page.locator("#form-view:not([hidden])").waitFor();
  await page.locator("#key-button").click();
  await page.locator("#key").fill("mg_„key“");
  await walk.press("Use the key");
  await walk.reads("#key-dialog", /remove all other characters/);
  await page.locator("#key").fill("mg_key");
  await walk.press("Use the key");
  await walk.reads("#key-button", /^Key: set$/);
  walk.tab.assertClean();
  await walk.tab.close();
});

test("measuring again takes the pair of its own result", async () => {
  const walk = await place.open(), { page } = walk;
  const measured = async (a, b) => {
    await walk.fill({ a: place.files[a], b: place.files[b], limit: "0.5" });
    await walk.measure();
    await walk.measured();
    return walk.job();
  };
  const first = await measured("dented.obj", "sphere.obj");
  await walk.newPair();
  await measured("smaller.obj", "small.obj");
  await page.goBack();
  await page.goBack();
  await page.waitForURL(`**/c/${first.id}`);
  await walk.measured();
  await walk.press("Measure again");
  await walk.reads("#slot-a", /dented\.obj/);
  await walk.reads("#slot-b", /sphere\.obj/);
  await walk.measure();
  await walk.measured();
  const again = await walk.job();
  assert.notEqual(again.id, first.id);
  assert.equal(again.result.meshes.a.sha256, first.result.meshes.a.sha256);
  walk.tab.assertClean({ expected: [lookup] });
  await walk.tab.close();
});

test("the same mesh twice is proved to be the same, without a search", async () => {
  const walk = await place.open();
  await walk.fill({ a: place.files["sphere.obj"], b: place.files["sphere.obj"] });
  await walk.measure();
  await walk.measured();
  const text = await walk.text("#result-view");
  assert.match(text, /Proved without a search: the surface of A is the same/);
  assert.doesNotMatch(text, /ended before this direction/);
  await walk.tab.close();
});

test("the limit is drawn for a running comparison opened by its link", async () => {
  const walk = await place.open();
  // The distance is 0.98001 and a little: a limit this near is not decided before the page is there again.
  await walk.fill({ ...endless(place), limit: "0.980015", units: "mm" });
  await walk.measure();
  await walk.page.locator("#run-view .band").waitFor();
  const id = walk.id();
  await walk.page.reload();
  await walk.page.locator("#run-view .band").waitFor();
  assert.match(await walk.page.locator("#run-view .plot").textContent(), /limit 0\.980015\s*mm/);
  await stopped(id);
  await walk.tab.close();
});

test("a viewer that came by trying again ends with its result", async () => {
  const walk = await place.open(), { page } = walk;
  await page.route("**/deviation.glb*", (route) => route.abort());
  await walk.fill({ a: place.files["smaller.obj"], b: place.files["small.obj"] });
  await walk.measure();
  await walk.measured();
  await page.getByRole("button", { name: "Try again" }).waitFor();
  await page.unroute("**/deviation.glb*");
  await walk.press("Try again");
  await walk.viewer();
  await walk.newPair();
  assert.equal(await page.evaluate(() => [...document.querySelectorAll("*")].some((each) => each.viewer)), false);
  await walk.tab.close();
});

test("the map of each mesh is saved", async () => {
  const walk = await place.open();
  await walk.fill({ a: place.files["smaller.obj"], b: place.files["small.obj"] });
  await walk.measure();
  await walk.measured();
  for (const of of ["A", "B"]) {
    const [saved] = await Promise.all([walk.page.waitForEvent("download"), walk.press(`Deviation map of ${of} as PLY`)]);
    assert.match(saved.suggestedFilename(), new RegExp(`^deviation-${of.toLowerCase()}-.*ply$`));
  }
  await walk.tab.close();
});

test("A is moved to B where that is asked for, and the page says how far", async () => {
  const walk = await place.open(), { page } = walk;
  await walk.fill({ a: place.files["away.obj"], b: place.files["dented.obj"], limit: "0.001", align: true });
  await walk.measure();
  await walk.measured();
  await page.getByText(/mesh a was moved before it was measured, by best fit: .* shifted by/).waitFor();
  await page.getByText("align: rigid").first().waitFor();
  assert.equal((await isThere(walk.id())).result.verdict, "pass");
  await walk.tab.close();
});

test("a limit for each side, and further options, as typed and as measured again", async () => {
  const walk = await place.open(), { page } = walk;
  await walk.fill({ a: place.files["thick.obj"], b: place.files["ring.obj"], inside: "0.2", further: "bore" });
  await walk.measure();
  await page.getByText("Enter both limits; 0 for a side that allows nothing.").waitFor();
  await page.getByText(/^The further options have to be an object in JSON/).waitFor();
  const further = JSON.stringify({ regions: [{ name: "top", box: { min: [-2, -2, 0], max: [2, 2, 2] }, max_distance: 2 }] });
  await walk.fill({ outside: "0.05", limit: "1", further });
  await walk.measure();
  await walk.measured();
  await page.getByText(/^The point .* is 0\.\d+ or more outside of the baseline \(B\)\. The limit is 0\.05\./).first().waitFor();
  assert.equal(await page.locator(".verdict .gauge").count(), 2, "a bar for each side of the zone");
  const { result } = await isThere(walk.id());
  assert.deepEqual([result.verdict, result.gate.zone, result.regions.map(({ name }) => name)], ["fail", [-0.2, 0.05], ["top", "rest"]]);
  await walk.press("Measure again");
  assert.deepEqual([await page.locator("#inside").inputValue(), await page.locator("#outside").inputValue(), await page.locator("#further").inputValue()], ["0.2", "0.05", further]);
  await walk.tab.close();
});

test("what A itself has to be like is asked for by further options, judged in a table, and asked for again", async () => {
  const walk = await place.open(), { page } = walk;
  await walk.fill({ a: place.files["thick.obj"], b: place.files["ring.obj"], limit: "1", further: '{"expect": {"water": true}}' });
  await walk.measure();
  await walk.reads("#further-error", /Unknown option '\/expect\/water'/);
  await walk.fill({ further: '{"expect": {"watertight": true}, "gate": {"max_distance": 2}}' });
  await walk.measure();
  await walk.reads("#further-error", /"gate\.max_distance" is asked for by another field, too/);
  const expect = { watertight: true, triangles: { max: 100 } }, further = JSON.stringify({ expect });
  await walk.fill({ further });
  await walk.measure();
  await walk.measured();
  const cells = page.getByRole("region", { name: "What is asked" }).locator("tbody :is(th, td)");
  const texts = (await cells.allInnerTexts()).slice(5); // after the distance
  assert.deepEqual(texts, ["watertight", "yes", "yes", "", "pass", "triangles", "576", "at most 100", "", "fail"]);
  await walk.reads("#result-view h1", /^Fail$/);
  await walk.reads("#result-view", /expect: \{"watertight":true,"triangles":\{"max":100\}\}/);
  const { result } = await isThere(walk.id());
  assert.deepEqual([result.verdict, result.expect], ["fail", expect]);
  await page.setViewportSize({ width: 360, height: 740 });
  await walk.viewer();
  await walk.tab.shot("expectations_narrow", { whole: true });
  assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), "nothing is wider than the window");
  await walk.click("Measure again");
  assert.equal(await page.locator("#further").inputValue(), further);
  await walk.tab.close();
});

test("a point cloud is drawn by its points, and refused in both directions", async () => {
  const walk = await place.open();
  await walk.fill({ a: place.files["scan.xyz"], b: place.files["sphere.obj"] });
  await walk.measure();
  await walk.page.getByText("ask for the direction a_to_b").first().waitFor();
  await walk.fill({ direction: "a_to_b" });
  await walk.measure();
  await walk.measured();
  await walk.page.getByText("A is a point cloud of").waitFor();
  await walk.viewer();
  await walk.press("Edges");
  await walk.still();
  const image = picture(await walk.page.locator(".viewer-canvas").screenshot());
  const ground = image.at(2, 2);
  assert.ok(spot(image, (colour) => difference(colour, ground) > 40).count > 1000, "points are seen");
  await walk.tab.close();
});
