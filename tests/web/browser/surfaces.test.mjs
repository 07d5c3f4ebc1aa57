// The page as one surface of many: what its form sends is read as the same request is when it is sent by itself, and refused in
// the same words, at the field. The rows are those of tests/surfaces, which hold the other surfaces against each other.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { join } from "node:path";
import { test } from "node:test";
import { obj, sphere } from "./meshes.mjs";
import { root } from "./service.mjs";
import { isOfToday, seedText, workplace } from "./workplace.mjs";

const place = workplace(() => ({ "a.obj": obj(sphere(6)), "b.obj": obj(sphere(5)) }));

const program = "import json, rows; print(json.dumps([rows.wholes(), rows.mistakes()]))";
const told = spawnSync("python3", ["-c", program], { cwd: join(root, "tests/surfaces"), encoding: "utf8", env: { ...process.env, PYTHONDONTWRITEBYTECODE: "1" } });
assert.equal(told.status, 0, told.stderr);
const [wholes, mistakes] = JSON.parse(told.stdout);

const isTyped = (value) => typeof value === "number" || (typeof value === "string" && value.trim() !== "");
const isNumber = (value) => typeof value === "number" || (isTyped(value) && Number.isNaN(Number(value))); // typed, "2" is one
const lengths = ["um", "mm", "cm", "m", "in", "ft"];

// What of a request has a field: [its value in the form, what the form sends for it]; null: none, it is a further option.
const fields = {
  max_distance: (value) => isTyped(value) && { limit: value },
  zone: (value) => Array.isArray(value) && value.length === 2 && value.every(isTyped) && /^-|^0$/.test(value[0]) && { inside: value[0], outside: value[1] },
  direction: (value) => ["symmetric", "a_to_b", "b_to_a"].includes(value) && { direction: value },
  strategy: (value, { points = 4 }) => ["auto", "four_point", "triangle_set"].includes(value) || (value === "n_point" && isChoice(points)) ? { strategy: value } : null,
  points: (value, { strategy }) => strategy === "n_point" && isChoice(value) && { points: value },
  tolerance: (value) => value?.absolute !== undefined && Object.keys(value).length === 1 && isNumber(value.absolute) && { toleranceKind: "absolute", tolerance: value.absolute },
  timeout: (value) => isTyped(value) && { timeout: value },
  threads: (value) => isNumber(value) && { threads: value },
  units: (value) => lengths.includes(value?.candidate) && lengths.includes(value?.baseline) && { unitA: value.candidate, unitB: value.baseline },
  statistics: (value) => value === true && { statistics: true },
  align: (value) => value === "rigid" && { align: true },
};
const isChoice = (points) => [4, 10, 31, 109, 409, 1585].includes(points);
const ofGate = ["max_distance", "max_share_beyond", "zone", "uncertainty", "narrow"];

// The request with its limits in `gate`, where the form has them.
function gated(request) {
  const entries = Object.entries(request), limits = entries.filter(([name]) => ofGate.includes(name));
  return { ...Object.fromEntries(entries.filter(([name]) => !ofGate.includes(name))), ...(limits.length > 0 ? { gate: Object.fromEntries(limits) } : {}) };
}

function filled(request) {
  const values = {}, rest = {};
  for (const [name, value] of Object.entries(request)) {
    const own = fields[name]?.(value, request);
    if (own) Object.assign(values, own);
    else rest[name] = value;
  }
  const further = gated(rest);
  return { values, further: Object.keys(further).length > 0 ? JSON.stringify(further) : "" };
}

// As a user's typing and choosing, at once.
function fill({ values, further }) {
  const form = document.querySelector("#form");
  for (const input of form.querySelectorAll("input:not([type=file]), select, textarea")) {
    const value = input.name === "further" ? further : values[input.name];
    if (input.type === "radio") input.checked = input.value === (values[input.name] ?? "symmetric");
    else if (input.type === "checkbox") input.checked = value === true;
    else input.value = String(value ?? { toleranceKind: "default", strategy: "auto", points: "4" }[input.name] ?? "");
  }
  form.dispatchEvent(new Event("change", { bubbles: true }));
}

async function byThePage(walk, request) {
  const { page } = walk;
  await page.locator("#form-view:not([hidden])").waitFor();
  await page.evaluate(fill, filled(request));
  const answer = new Promise((done) => (walk.heard = done));
  await page.locator("#measure").press("Enter");
  return answer;
}

async function directly(request) {
  const answer = await fetch(`${place.service.origin}/v1/options`, { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(gated(request)) });
  return { status: answer.status, document: await answer.json() };
}

async function opened() {
  const walk = await place.open();
  await walk.page.route(/\/v1\/(meshes|comparisons)/, (route) => route.abort()); // nothing is measured
  await walk.page.route("**/v1/options", async (route) => {
    const response = await route.fetch(), body = await response.text();
    await route.fulfill({ response, body });
    walk.heard({ status: response.status(), document: JSON.parse(body) });
  });
  await walk.fill({ a: place.files["a.obj"], b: place.files["b.obj"] });
  return walk;
}

const hasField = (request) => Object.keys(filled(request).values).length > 0;

// The rows that have a field: each day another eighth of them.
const todays = (rows) => rows.filter(hasField).filter((_, i) => isOfToday(i, 8));

test(`what is asked by the form is what is asked without it, ${seedText}`, async () => {
  const walk = await opened();
  const rows = todays(wholes);
  assert.ok(rows.length > 20, String(rows.length));
  for (const request of rows) assert.deepEqual(await byThePage(walk, request), { status: 200, document: (await directly(request)).document }, JSON.stringify(request));
  await walk.tab.close();
});

test(`what is wrong in the form is said in the service's words, at a field, ${seedText}`, async () => {
  const walk = await opened();
  const rows = todays(mistakes);
  assert.ok(rows.length > 12, String(rows.length));
  for (const request of rows) {
    const [form, alone] = [await byThePage(walk, request), await directly(request)];
    const about = JSON.stringify(request), messages = ({ document }) => document.errors.map(({ message }) => message).sort();
    assert.deepEqual([form.status, alone.status], [422, 422], about);
    assert.deepEqual(messages(form), messages(alone), about);
    const said = walk.page.locator("#form .error:not([hidden])").first();
    await said.waitFor();
    assert.notEqual((await said.innerText()).trim(), "", about);
  }
  await walk.tab.close();
});
