// The whole page without a mouse.
import assert from "node:assert/strict";
import { test } from "node:test";
import { dented, obj, sphere } from "./meshes.mjs";
import { dot, length, minus, unit } from "./pixels.mjs";
import { lookup, workplace } from "./workplace.mjs";

const place = workplace(() => ({ "sphere.obj": obj(sphere(40)), "dented.obj": obj(dented(30)) }), { browse: [] });

// Presses Tab until the focus is where it should be; every stop must be visible.
async function tabTo(page, wanted) {
  for (let i = 0; i < 80; ++i) {
    await page.keyboard.press("Tab");
    const at = await page.evaluate((selector) => {
      const each = document.activeElement, style = getComputedStyle(each), label = each.closest("label") ?? (each.id && document.querySelector(`label[for="${each.id}"]`));
      const ring = (one) => one && (getComputedStyle(one).outlineStyle !== "none" || getComputedStyle(one).boxShadow !== "none");
      return { there: each.matches(selector), name: each.id || each.textContent.slice(0, 30) || each.tagName, seen: style.outlineStyle !== "none" || style.boxShadow !== "none" || ring(label) };
    }, wanted);
    assert.ok(at.seen, `the focus on ${at.name} is not seen`);
    if (at.there) return i + 1;
  }
  throw new Error(`${wanted} is not reached by Tab`);
}

test("files are chosen, a limit typed, the pair measured, and the witness flown to, by keys", async () => {
  const walk = await place.open({ reducedMotion: "no-preference" }), { page, tab } = walk;
  // Asked for early: a chooser that opens while the browser has not heard of it yet is not told.
  const waiting = [], choosers = ["a", "b"].map(() => new Promise((done) => waiting.push(done)));
  page.on("filechooser", (one) => waiting.shift()?.(one));
  for (const [side, name] of [["a", "dented.obj"], ["b", "sphere.obj"]]) {
    await tabTo(page, `#file-${side}`);
    await page.keyboard.press("Space");
    await (await choosers.shift()).setFiles(place.files[name]);
  }
  await tabTo(page, "#limit");
  await page.keyboard.type("0.02");
  await page.keyboard.press("Enter");
  await walk.measured();
  const focused = await page.evaluate(() => document.activeElement?.tagName);
  assert.notEqual(focused, "BODY", "the focus goes with the view");
  const viewer = await walk.viewer();
  await tabTo(page, "canvas");
  await tab.shot("keyboard_viewer", { whole: true });
  await turnsAndFlies(walk, viewer);
  tab.assertClean({ expected: [lookup] });
  assert.deepEqual(tab.stalls, [], "the page itself reads nothing back");
  await tab.close();
});

async function turnsAndFlies(walk, viewer) {
  const { page } = walk, cameraOf = () => viewer.evaluate((host) => host.viewer.camera());
  const first = await cameraOf();
  for (const key of ["ArrowLeft", "ArrowLeft", "ArrowUp"]) await page.keyboard.press(key);
  await walk.still();
  const turned = await cameraOf();
  const toward = (camera) => unit(minus(camera.position, camera.target));
  assert.ok(dot(toward(first), toward(turned)) < 0.999, "arrows turn");
  await page.keyboard.press("w");
  await walk.still(); // the flight is over
  const flown = await cameraOf(), { result } = await walk.job();
  const { point_a } = [result.a_to_b, result.b_to_a].sort((one, other) => other.lower - one.lower)[0].witness;
  assert.ok(length(minus(flown.target, point_a)) < 0.1, "w flies to the witness");
  assert.ok(length(minus(flown.position, flown.target)) < length(minus(turned.position, turned.target)), "and nearer");
  await walk.tab.shot("keyboard_witness");
  for (const key of ["x", "p", "s", "d", "c", "]", "f", "b", "0", "?"]) await page.keyboard.press(key);
  await walk.still();
  await walk.tab.shot("keyboard_help");
}
