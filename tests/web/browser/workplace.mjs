// Setup and end of each file of tests: a browser, a service, a folder of meshes.
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { launch, plainPage, Tab } from "./browser.mjs";
import { ply, sphere, written } from "./meshes.mjs";
import { Walk } from "./page.mjs";
import { startService } from "./service.mjs";

// `make()` gives {name: bytes} of the meshes, `flags` are those of the service and of the browser; the members are there when
// the tests run.
export function workplace(make = () => ({}), { serve = [], browse = [plainPage] } = {}) {
  const place = {};
  before(async () => {
    place.folder = mkdtempSync(join(tmpdir(), "meshgauge-web-"));
    place.files = written(place.folder, make());
    place.browser = await launch(...browse);
    place.service = await startService(...serve.map((flag) => (typeof flag === "function" ? flag(place) : flag)));
  });
  after(async () => {
    await place.browser?.close();
    await place.service?.stop();
    rmSync(place.folder, { recursive: true, force: true });
  });
  // A tab of these settings, or the one that tests without settings share, one after the other: a new one takes a second.
  place.tab = async (how) => {
    if (how) return Tab.open(place.browser, place.service, how);
    if (place.shared) await place.shared.renew();
    else place.shared = Object.assign(await Tab.open(place.browser, place.service), { close() {} });
    return place.shared;
  };
  place.open = async (how) => Walk.begin(await place.tab(how));
  return place;
}

// Of what takes long each day tries another part: the date, as 20261129, is the seed. MESHGAUGE_SEED is another day's; with
// `all` each part is tried.
const seed = process.env.MESHGAUGE_SEED || new Date().toISOString().slice(0, 10).replaceAll("-", "");
if (!/^(all|\d+)$/.test(seed)) throw new Error(`MESHGAUGE_SEED is a number or all, not ${seed}`);

// Whether the i-th of many is of today's part, one of so many parts.
export const isOfToday = (i, parts) => seed === "all" || i % parts === Number(seed) % parts;

// `test` for walks that do not need each other: of them, in their order, today's part is tried.
export function todays(parts) {
  let number = 0;
  return (name, walk) => test(name, { skip: isOfToday(number++, parts) ? false : `on another day than ${seed}` }, walk);
}

export const seedText = `seed ${seed}`;

// A pair that runs until its timeout, however fast the machine is: a test that looks at a running comparison must never
// find one that has ended. `four_point` works for minutes where the default strategy needs seconds.
export const endlessMeshes = () => ({ "core.ply": ply(sphere(60, 0.02)), "shell.ply": ply(sphere(200)) });
export const endless = (place) => ({
  a: place.files["core.ply"], b: place.files["shell.ply"], tolerance: ["relative", "1e-8"], strategy: "four_point", timeout: "170",
  threads: "1", // the other processors are the browser's
});

// The page first asks whether the service has a mesh; the browser logs the answer when it has not.
export const lookup = /404.*\/v1\/meshes\/[0-9a-f]{64}\)/;
