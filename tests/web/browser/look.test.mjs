// The page in light, dark and narrow: nothing wider than the window, and no serious fault that axe finds.
import assert from "node:assert/strict";
import { test } from "node:test";
import { faults } from "./browser.mjs";
import { dented, obj, sphere } from "./meshes.mjs";
import { Walk } from "./page.mjs";
import { asked } from "./service.mjs";
import { endless, endlessMeshes, isOfToday, workplace } from "./workplace.mjs";

const place = workplace(() => ({
  "sphere.obj": obj(sphere(40)), "dented.obj": obj(dented(30)), "broken.obj": Buffer.from("f 1 2 3\n"),
  ...endlessMeshes(),
}));

// The narrow ones have one style (40rem): axe looks at one of them. Each day it looks at a third of all.
const looks = {
  light: {}, dark: { colorScheme: "dark" }, narrow: { size: [360, 740], checked: false },
  narrowest: { size: [320, 640] }, // 1280 at 400 %
  contrast: { forcedColors: "active" }, "large type": { size: [640, 450], checked: false }, // 1280 at 200 %
};

// Each state of the page; `reached` when it is there.
const states = {
  async form() {},
  async filled(walk) {
    await walk.fill({ a: place.files["dented.obj"], b: place.files["sphere.obj"], limit: "abc", strategy: "n_point" });
    await walk.measure();
  },
  async running(walk) {
    await walk.fill(endless(place));
    await walk.measure();
    await walk.page.locator("#run-view .band").waitFor();
  },
  async result(walk) {
    await walk.fill({ a: place.files["dented.obj"], b: place.files["sphere.obj"], limit: "0.02", inside: "1", outside: "1", units: "mm" });
    await walk.page.locator("#more").evaluate((more) => (more.open = true));
    await walk.page.locator("#statistics").check();
    await walk.measure();
    await walk.measured();
    await walk.viewer();
  },
  async problem(walk) {
    await walk.fill({ a: place.files["broken.obj"], b: place.files["sphere.obj"] });
    await walk.measure();
    await walk.page.waitForFunction(() => document.querySelector("#trouble")?.textContent !== "");
  },
};

// Labels of the colour bar that lie on another.
const overprinted = () => {
  const seen = [...document.querySelectorAll(".viewer-tick")].filter((one) => one.textContent && !one.classList.contains("viewer-unseen"));
  const boxes = seen.map((one) => {
    const range = document.createRange();
    range.selectNodeContents(one);
    return { text: one.textContent, box: range.getBoundingClientRect() };
  });
  return boxes.flatMap(({ text, box }, i) => boxes.slice(i + 1).filter(({ box: b }) => box.left < b.right && b.left < box.right && box.top < b.bottom && b.top < box.bottom).map((one) => `${text} / ${one.text}`));
};

const stageColours = () => [...document.querySelectorAll(".swatch rect")].map((one) => getComputedStyle(one).fill);

let tab = null, number = 0;
for (const [state, reach] of Object.entries(states))
  test(state, async (all) => {
    await tab?.renew();
    tab ??= await place.tab({ bypassCSP: true });
    const walk = await Walk.begin(tab);
    await reach(walk);
    for (const [look, { colorScheme = "light", forcedColors = "none", size: [width, height] = [1280, 900], checked = true }] of Object.entries(looks))
      await all.test(look, async () => {
        await tab.page.emulateMedia({ colorScheme, forcedColors });
        await tab.page.setViewportSize({ width, height });
        await walk.still();
        await tab.shot(`look_${state}_${look.replace(" ", "_")}`, { whole: true });
        const { wide, room } = await tab.page.evaluate(() => ({ wide: document.documentElement.scrollWidth, room: innerWidth }));
        assert.ok(wide <= room, `${wide} pixels wide in a window of ${room}`);
        assert.deepEqual(await tab.page.evaluate(overprinted), []);
        if (state === "form" && height >= 480) {
          const { y, height: tall } = await tab.page.locator("#measure").boundingBox();
          assert.ok(y + tall <= height, "Measure is seen without scrolling");
        }
        if (checked && isOfToday(number++, 3)) assert.deepEqual(await faults(tab), []);
        assert.deepEqual(tab.foreign, []);
      });
    if (state === "result") {
      const colours = await tab.page.evaluate(stageColours);
      assert.ok(colours.length > 5 && new Set(colours).size === colours.length, colours.join(" "));
      assert.ok(!colours.includes("rgb(0, 0, 0)"), "each stage has a colour");
    }
    if (state === "running") {
      assert.ok(await tab.page.locator("#run-view").isVisible(), "it still runs");
      await asked(place.service, `/v1/comparisons/${walk.id()}`, { method: "DELETE" });
    }
  });
