// Two files, a limit, the interval as it shrinks, the verdict, its permanent link, and a job that is cancelled.
import assert from "node:assert/strict";
import { Tab } from "./browser.mjs";
import { corpus, dented, obj, ply, rough, sphere, written } from "./meshes.mjs";
import { seenInterval, Walk, watchInterval } from "./page.mjs";
import { asked } from "./service.mjs";
import { endless, endlessMeshes, lookup, todays, workplace } from "./workplace.mjs";

const test = todays(2);
const place = workplace(() => ({ "sphere.obj": obj(sphere(60)), "dented.ply": ply(dented(40)), ...endlessMeshes() }));

const pair = () => {
  const [a, b] = ["bunny_half.ply", "bunny.obj.gz"].map(corpus);
  return a && b ? { a, b, limit: "0.0005" } : { a: place.files["dented.ply"], b: place.files["sphere.obj"], limit: "0.02" };
};

test("two files and a limit give a verdict in words, which are those of the API, and a link that opens in another browser", async () => {
  const walk = await place.open(), { tab } = walk;
  await tab.shot("1_form");
  await walk.fill({ ...pair(), units: "mm" });
  await tab.shot("2_chosen");
  await walk.measure();
  await walk.measured();
  await walk.viewer();
  await tab.shot("3_result", { whole: true });
  const { result, view } = await walk.job();
  assert.equal(view ?? result.view, new URL(tab.page.url()).pathname);
  const shown = await walk.text("#result-view");
  assert.match(shown, result.verdict === "pass" ? /Pass/ : /Fail/);
  assertShows(shown, result);
  tab.assertClean({ expected: [lookup] });
  await openElsewhere(tab.page.url(), shown);
  await tab.close();
});

// The interval as the page writes it encloses that of the API and is hardly wider.
function assertShows(shown, { distance, gate }) {
  const found = [...shown.matchAll(/(\d[\d.e+-]*) (?:…|to|and) (\d[\d.e+-]*)/g)].map(([, low, high]) => [Number(low), Number(high)]);
  const right = ([low, high]) => low <= distance.lower && high >= distance.upper && low > 0.99 * distance.lower && high < 1.01 * distance.upper;
  assert.ok(found.some(right), `${JSON.stringify(distance)} is not among ${JSON.stringify(found)}`);
  assert.match(shown, new RegExp(`${gate.max_distance}\\s*${gate.units ?? ""}`));
}

async function openElsewhere(url, before) {
  const fresh = await Tab.open(place.browser, place.service), walk = new Walk(fresh);
  await fresh.go(new URL(url).pathname);
  await walk.measured();
  await walk.viewer();
  await fresh.shot("4_permanent_link");
  const numbers = (text) => text.match(/\d+\.\d+/g).slice(0, 6);
  assert.deepEqual(numbers(await walk.text("#result-view")), numbers(before), "the link shows the same numbers");
  fresh.assertClean();
  await fresh.close();
}

test("the interval is drawn while it shrinks: never wider, and with a point for each step", async () => {
  // A search that is faster than the service reports shows few steps: a larger pair has more.
  let seen = [];
  for (const n of [200, 600, 1600]) {
    seen = await seenWhileMeasured(written(place.folder, { "rough.ply": ply(rough(n, 0.2, 1)), "other.ply": ply(rough(n + 1, 0.2, 2)) }));
    console.log(`${4 * n * n} triangles: ${stepsOf(seen).size} steps`);
    if (stepsOf(seen).size >= 3 && cornersOf(seen) >= 12) break;
  }
  assertShrinks(seen);
  assert.ok(cornersOf(seen) >= 12, "the plot has steps");
});

async function seenWhileMeasured(files) {
  const walk = await place.open(), { tab } = walk;
  await walk.fill({ a: files["rough.ply"], b: files["other.ply"], tolerance: ["relative", "1e-8"], strategy: "four_point", threads: "1" });
  await watchInterval(tab.page);
  await walk.measure();
  await tab.page.locator("#run-view .band").waitFor();
  await tab.shot("5_running");
  await walk.measured();
  const seen = await seenInterval(tab.page);
  tab.assertClean({ expected: [lookup] });
  await tab.close();
  return seen;
}

const cornersOf = (seen) => Math.max(...seen.map((each) => each.corners));
const stepsOf = (seen) => new Set(seen.filter((each) => each.upper < Infinity).map((each) => each.text));

function assertShrinks(seen) {
  const known = seen.filter((each) => each.upper < Infinity), steps = stepsOf(seen);
  assert.ok(steps.size >= 3, `only ${[...steps].join("; ")}`);
  for (let i = 1; i < seen.length; ++i) {
    assert.ok(seen[i].lower >= seen[i - 1].lower, `${seen[i - 1].text}, then ${seen[i].text}`);
    assert.ok(seen[i].upper <= seen[i - 1].upper, `${seen[i - 1].text}, then ${seen[i].text}`);
  }
  const [first, last] = [known[0], known.at(-1)];
  assert.ok(last.upper - last.lower < first.upper - first.lower);
}

test("a long job is cancelled, and the interval that it had reached is kept", async () => {
  const walk = await place.open(), { tab } = walk;
  await walk.fill(endless(place));
  await walk.measure();
  await walk.searching();
  await walk.press("Cancel");
  await walk.measured();
  await tab.shot("6_cancelled", { whole: true });
  const job = await walk.job();
  assert.equal(job.state, "cancelled");
  assert.equal(job.result.status, "cancelled");
  assert.ok(job.result.distance.upper < 2);
  await walk.reads("#result-view", /cancelled/i);
  tab.assertClean({ expected: [lookup] });
  await tab.close();
});

test("measuring again with other settings makes another comparison of the same stored meshes", async () => {
  const walk = await place.open(), { tab } = walk;
  await walk.fill({ a: place.files["dented.ply"], b: place.files["sphere.obj"] });
  await walk.measure();
  await walk.measured();
  const first = await walk.job();
  await tab.go("/");
  await walk.fill({ a: place.files["dented.ply"], b: place.files["sphere.obj"], direction: "b_to_a" });
  const sent = tab.requests.length;
  await walk.measure();
  await walk.measured();
  const second = await walk.job();
  assert.notEqual(second.id, first.id);
  assert.equal(second.result.direction, "b_to_a");
  assert.deepEqual(tab.requests.slice(sent).filter((line) => line.startsWith("POST") && line.endsWith("/v1/meshes")), [], "sent once");
  const { meshes } = await (await asked(place.service, `/v1/comparisons/${second.id}`)).json().then((job) => job.result);
  assert.equal(meshes.a.sha256, first.result.meshes.a.sha256);
  tab.assertClean({ expected: [lookup] });
  await tab.close();
});
