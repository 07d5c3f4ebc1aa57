// A pair of a million triangles: it loads, is decimated for display, and says so; what is certified is not.
import assert from "node:assert/strict";
import { test } from "node:test";
import { largePair } from "./frames.mjs";
import { seenInterval, watchInterval } from "./page.mjs";
import { lookup, workplace } from "./workplace.mjs";

const place = workplace();

test("a million triangles are measured whole and shown decimated", async () => {
  const pair = await largePair(place.folder), walk = await place.open({ viewport: { width: 900, height: 640 } });
  await walk.fill({ a: pair.a, b: pair.b, tolerance: ["relative", "0.1"] });
  await watchInterval(walk.page);
  await walk.measure();
  await walk.measured();
  const seen = await seenInterval(walk.page);
  console.log(seen.map((each) => each.text).join("; "));
  for (let i = 1; i < seen.length; ++i) assert.ok(seen[i].lower >= seen[i - 1].lower && seen[i].upper <= seen[i - 1].upper);
  await walk.viewer();
  await walk.tab.shot("large", { whole: true });
  const { result } = await walk.job(), said = await walk.text("#result-view");
  const triangles = result.meshes.a.triangles.toLocaleString("en");
  assert.ok(said.includes(triangles), `${triangles} triangles are named`);
  assert.match(said, /[\d,]+ (triangles )?(are )?shown|decimated/i);
  walk.tab.assertClean({ expected: [lookup] });
  await walk.tab.close();
});
