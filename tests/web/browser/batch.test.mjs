// The page of a batch: while it runs and at its end, its list, its link on the way back, a key, and damaged links.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { batchAt, begun, ended, square, stored } from "./batches.mjs";
import { faults } from "./browser.mjs";
import { ply, sphere } from "./meshes.mjs";
import { Walk } from "./page.mjs";
import { asked } from "./service.mjs";
import { todays, workplace } from "./workplace.mjs";

const test = todays(3);
const place = workplace(() => ({}), { serve: ["--workers", "4"] });
const gate = { max_distance: 0.5, units: "mm" };

async function opened(path, how) {
  const walk = new Walk(await place.tab(how));
  await walk.tab.go(path);
  await walk.page.locator("#batch-view:not([hidden]), #trouble .trouble").first().waitFor();
  return walk;
}

const tile = (walk, name) => walk.page.locator(".tile", { hasText: name });
const names = (walk) => walk.page.locator(".rows tbody th").allInnerTexts();
const words = (walk, pattern) => walk.page.locator(".list-words", { hasText: pattern }).waitFor();

// 130 pairs of squares: the first 70 are near enough, the next 58 are not, one cannot be read, one has a limit of its own.
let made = null;
function mixed() {
  made ??= (async () => {
    const { service } = place, flat = await stored(service, square(0)), near = await stored(service, square(0.25)), far = await stored(service, square(2));
    const broken = await stored(service, Buffer.from("v 0 0 0\nv 1 0 0\nf 1 2 9\n"));
    const comparisons = Array.from({ length: 128 }, (_, i) => ({ name: `part ${i}`, a: i < 70 ? near : far, b: flat }));
    comparisons.push({ name: "<b>broken</b>", a: broken, b: flat }, { a: flat, b: far, options: { gate: { max_distance: 1e-9 } } });
    const { id, view } = await begun(service, { name: "nightly & <i>more</i>", options: { gate }, comparisons });
    await ended(service, id);
    return { id, view };
  })();
  return made;
}

async function slow(name) {
  const { service } = place;
  const core = await stored(service, ply(sphere(60, 0.02))), shell = await stored(service, ply(sphere(200)));
  const flat = await stored(service, square(0)), far = await stored(service, square(3));
  const comparisons = [1, 2, 3].map((i) => ({ name: `slow ${i}`, a: core, b: shell, options: { strategy: "four_point", tolerance: { relative: 1e-8, absolute: i * 1e-12 }, timeout_ms: 170000, threads: 1 } }));
  comparisons.unshift({ name: "quick", a: flat, b: far, options: { gate } }); // it ends in any order: there is a thread for each
  return begun(service, { name, comparisons });
}

test("comparisons that did not pass come first, without reading all results", async () => {
  const { id, view } = await mixed(), walk = await opened(view);
  await walk.reads("#batch-view h1", /Fail/);
  await walk.reads("#batch-view .reason", /59 fail, 1 could not be measured, 70 pass\./);
  await walk.reads("#batch-view .pair-names", /nightly & <i>more<\/i>/);
  assert.equal(await tile(walk, "Not passed").getAttribute("aria-pressed"), "true");
  await words(walk, "1 to 50 of 60");
  assert.equal((await names(walk))[0], "part 70");
  const row = walk.page.locator(".rows tbody tr").first();
  assert.match(await row.innerText(), /Fail\s+1\.\d+ to 2\.\d+\smm\s+limit 0\.5\smm/);
  assert.equal(await row.locator(".strip .limit-line").count(), 1);
  await walk.press("Next");
  await words(walk, "51 to 60 of 60");
  assert.deepEqual((await names(walk)).slice(-2), ["Comparison 129", "<b>broken</b>"]);
  await walk.reads(".rows tbody tr:last-child", /Line 3 .* index 9/i);
  await walk.page.locator("#row-search").fill("PART 127");
  await words(walk, "1 to 1 of 1");
  assert.deepEqual(walk.tab.requests.filter((line) => line.includes("results.jsonl")), []);
  const lines = (await (await asked(place.service, `/v1/batches/${id}/results.jsonl`)).text()).trim().split("\n").map((line) => JSON.parse(line));
  assert.equal(await walk.page.locator(".rows a").getAttribute("href"), `/c/${lines[127].comparison}`);
  walk.tab.assertClean();
  await walk.tab.close();
});

test("by the keyboard: a filter, a page, a comparison, and back to where it was", async () => {
  const walk = await opened((await mixed()).view), { page } = walk;
  await page.locator("#batch-view h1:focus").waitFor();
  await tile(walk, "Not passed").focus();
  await page.keyboard.press("Tab");
  await page.keyboard.press("Enter");
  assert.equal(await tile(walk, "All").getAttribute("aria-pressed"), "true");
  await words(walk, "1 to 50 of 130");
  const next = page.getByRole("button", { name: "Next", exact: true });
  await next.focus();
  await page.keyboard.press("Enter");
  await page.keyboard.press("Enter");
  await words(walk, "101 to 130 of 130");
  await walk.focused("Previous");
  await walk.reads("#status", /All: 101 to 130 of 130/);
  const link = page.getByRole("link", { name: "part 69", exact: true });
  await link.focus();
  await page.keyboard.press("Enter");
  await walk.measured();
  await walk.reads("#result-view h1", /Pass/);
  await page.goBack();
  await words(walk, "101 to 130 of 130");
  await walk.focused("part 69");
  assert.equal(walk.tab.requests.filter((line) => line.includes("results.jsonl")).length, 1);
  await page.reload();
  await words(walk, "101 to 130 of 130");
  walk.tab.assertClean();
  await walk.tab.close();
});

test("a comparison without a limit has not passed", async () => {
  const { service } = place, flat = await stored(service, square(0)), near = await stored(service, square(0.25));
  const { id, view } = await begun(service, { comparisons: [{ name: " ", a: near, b: flat }, { a: near, b: flat, options: { gate } }] });
  await ended(service, id);
  const walk = await opened(view);
  await walk.reads("#batch-view .reason", /1 passes, 1 is measured\./);
  await tile(walk, "Not passed").click();
  await words(walk, /^None\.$/);
  await tile(walk, "All").click();
  await words(walk, "1 to 2 of 2");
  assert.deepEqual((await names(walk)).sort(), ["Comparison 0", "Comparison 1"]);
  walk.tab.assertClean();
  await walk.tab.close();
});

test("the reports are saved", async () => {
  const { id, view } = await mixed(), walk = await opened(view);
  for (const [label, path, name] of [["JUnit report", "junit.xml", /^batch-[0-9a-f]{8}-junit\.xml$/], ["Results as JSON lines", "results.jsonl", /^batch-[0-9a-f]{8}\.jsonl$/]]) {
    const [saved] = await Promise.all([walk.page.waitForEvent("download"), walk.press(label)]);
    await walk.focused(label);
    assert.match(saved.suggestedFilename(), name);
    assert.equal(readFileSync(await saved.path(), "utf8"), await (await asked(place.service, `/v1/batches/${id}/${path}`)).text());
  }
  walk.tab.assertClean();
  await walk.tab.close();
});

test("a running batch: its counts follow, also after a lost connection, until it is cancelled", async () => {
  const { id, view } = await slow("sweep");
  const tab = await place.tab(), walk = new Walk(tab), { page } = walk;
  let broken = 0;
  await page.route("**/events", (route) => (++broken === 1 ? route.abort() : route.fallback()));
  await tab.go(view);
  await page.locator("#batch-view h1", { hasText: "of 4 compared" }).waitFor();
  await page.getByRole("link", { name: "quick", exact: true }).waitFor();
  await walk.reads("#batch-view .reason", /1 fails so far\. \d runs?, \d waits?\./);
  assert.ok(broken >= 1);
  assert.ok(await page.getByRole("button", { name: "JUnit report" }).isDisabled());
  await tab.shot("batch_running", { whole: true });
  await walk.press("Cancel");
  await page.locator("#batch-view h1:focus", { hasText: "Fail" }).waitFor();
  await walk.reads("#batch-view .reason", /1 fails, 3 were cancelled\./);
  await tile(walk, "Cancelled").press("Enter");
  await words(walk, "1 to 3 of 3");
  assert.equal((await batchAt(place.service, id)).state, "cancelled");
  assert.ok(await page.getByRole("button", { name: "Cancel", exact: true }).isHidden());
  tab.assertClean({ expected: [/ERR_FAILED/] });
  await tab.close();
});

const looks = {
  light: { viewport: { width: 1280, height: 900 } }, "dark and narrow": { colorScheme: "dark", viewport: { width: 320, height: 640 } }, // 1280 at 400 %
  "contrast and large type": { forcedColors: "active", viewport: { width: 640, height: 450 } }, // 1280 at 200 %
};
for (const [look, how] of Object.entries(looks))
  test(`its look, ${look}`, async () => {
    const walk = await opened((await mixed()).view, { ...how, bypassCSP: true });
    await walk.page.locator("#row-search").fill("part 12");
    await words(walk, "1 to 8 of 8");
    await walk.still();
    await walk.tab.shot(`batch_${look.replaceAll(" ", "_")}`, { whole: true });
    const { wide, room } = await walk.page.evaluate(() => ({ wide: document.documentElement.scrollWidth, room: innerWidth }));
    assert.ok(wide <= room, `${wide} pixels wide in a window of ${room}`);
    assert.deepEqual(await faults(walk.tab), []);
    await walk.tab.close();
  });

test("a link that is damaged, and one that leads nowhere", async () => {
  const walk = await opened("/b/0d67c9a2");
  await walk.reads("#trouble", /This link is damaged\s+A link to a batch ends in 32 .* This one has 8: the rest was cut off/);
  const { id, view } = await mixed();
  await walk.tab.go(`/b/${id.toUpperCase()}).`);
  await walk.page.getByRole("link", { name: id }).click();
  await walk.page.locator("#batch-view:not([hidden])").waitFor();
  assert.equal(new URL(walk.page.url()).pathname, view);
  await walk.tab.go("/b/");
  await walk.reads("#trouble", /This link is damaged\s+A link to a batch .* This one has 0: /);
  await walk.tab.go(`${view}/`);
  await walk.page.locator("#batch-view:not([hidden])").waitFor();
  await walk.tab.go(`/b/${"0".repeat(32)}`);
  await walk.page.locator("#trouble h1").waitFor();
  await walk.reads("#trouble", /There is no such batch, or it was removed/);
  walk.tab.assertClean({ expected: [/404/] });
  await walk.tab.close();
});
