// A service with keys: the page asks the user for one, keeps it in this tab and sends it to this service only.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { begun, square, stored } from "./batches.mjs";
import { Tab } from "./browser.mjs";
import { dented, obj, sphere } from "./meshes.mjs";
import { Walk } from "./page.mjs";
import { asked, binary } from "./service.mjs";
import { workplace } from "./workplace.mjs";

const made = (name) => {
  const [token, entry] = execFileSync(binary, ["keys", "new", name], { encoding: "utf8" }).split("\n");
  return { token, entry: JSON.parse(entry) };
};
const ours = made("ours"), others = made("others");

const place = workplace(() => ({
  "sphere.obj": obj(sphere(12)), "dented.obj": obj(dented(12)),
  "keys.json": Buffer.from(JSON.stringify({ keys: [ours.entry, others.entry] })),
}), { serve: ["--keys-file", ({ files }) => files["keys.json"]] });

const refusals = /40[134].*\/v1\//;

async function enter(walk, key) {
  await walk.page.locator("#key-dialog[open]").waitFor();
  await walk.page.locator("#key").fill(key);
  await walk.press("Use the key");
}

test("a key is asked for, refused in words when it is wrong, and the work goes on with the right one", async () => {
  const walk = await place.open(), { page, tab } = walk;
  await walk.fill({ a: place.files["dented.obj"], b: place.files["sphere.obj"] });
  await walk.measure();
  await page.locator("#key-dialog[open]").waitFor();
  await tab.shot("key_asked");
  const reason = await walk.text("#key-reason");
  await enter(walk, "mg_wrong");
  await page.waitForFunction((before) => document.querySelector("#key-dialog[open]") && document.querySelector("#key-reason").textContent !== before, reason);
  await tab.shot("key_refused");
  await enter(walk, ours.token);
  await walk.measured();
  await walk.viewer();
  await tab.shot("key_result");
  assert.deepEqual(await page.evaluate(() => Object.keys(localStorage)), [], "nothing outlives the tab");
  assert.ok(!page.url().includes(ours.token));
  tab.assertClean({ expected: [refusals] });
  const { result } = await (await asked(place.service, `/v1/comparisons/${walk.id()}`, { headers: { Authorization: `Bearer ${ours.token}` } })).json();
  assert.equal(result.direction, "symmetric");
  await otherKey(new URL(page.url()).pathname);
  await tab.close();
});

test("a batch asks for a key as well, and its reports come with it", async () => {
  const { service, browser } = place, headers = { Authorization: `Bearer ${ours.token}` };
  const flat = await stored(service, square(0), headers);
  const { view } = await begun(service, { name: "ours", comparisons: [{ name: "same", a: flat, b: flat }] }, headers);
  const tab = await Tab.open(browser, service), walk = new Walk(tab);
  await tab.go(view);
  await enter(walk, ours.token);
  await tab.page.locator("#batch-view h1", { hasText: "Measured" }).waitFor();
  await tab.page.getByRole("link", { name: "same", exact: true }).waitFor();
  const [saved] = await Promise.all([tab.page.waitForEvent("download"), walk.press("JUnit report")]);
  assert.match(readFileSync(await saved.path(), "utf8"), /<testsuite name="ours"/);
  tab.assertClean({ expected: [refusals] });
  await tab.close();
});

// For any other key the comparison does not exist; a fresh browser is asked for a key first.
async function otherKey(path) {
  const tab = await Tab.open(place.browser, place.service), walk = new Walk(tab);
  await tab.go(path);
  await enter(walk, others.token);
  await walk.page.waitForFunction(() => document.querySelector("#trouble")?.textContent !== "");
  await walk.reads("#trouble", /no such comparison/i);
  await tab.shot("key_of_others");
  await tab.page.reload();
  await tab.page.locator("#trouble").waitFor();
  tab.assertClean({ expected: [refusals] });
  await tab.close();
  const right = await Tab.open(place.browser, place.service), again = new Walk(right);
  await right.go(path);
  await enter(again, ours.token);
  await again.measured();
  right.assertClean({ expected: [refusals] });
  await right.close();
}
