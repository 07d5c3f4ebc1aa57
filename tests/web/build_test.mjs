// Tests of server/web/build.mjs: node --test build_test.mjs
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { cpSync, mkdtempSync, readdirSync, readFileSync, rmSync, symlinkSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import test, { after } from "node:test";
import { fileURLToPath } from "node:url";
import { gunzipSync } from "node:zlib";

const web = join(dirname(fileURLToPath(import.meta.url)), "../../server/web");
const work = mkdtempSync(join(tmpdir(), "meshgauge-web-"));
after(() => rmSync(work, { recursive: true }));

// A folder like server/web, of which parts can be changed.
function another(name) {
  const folder = join(work, name);
  cpSync(web, folder, { recursive: true, filter: (path) => !path.endsWith("node_modules") });
  symlinkSync(join(web, "node_modules"), join(folder, "node_modules"));
  return folder;
}

function build(folder) {
  const out = join(folder, "out");
  const done = spawnSync(process.execPath, [join(folder, "build.mjs"), out], { encoding: "utf8" });
  return { ...done, out };
}

const contents = (folder) => new Map(readdirSync(folder).sort().map((name) => [name.replace(/\.gz$/, ""), gunzipSync(readFileSync(join(folder, name)))]));

const first = build(another("first"));
const files = first.status === 0 ? contents(join(first.out, "page")) : new Map();

test("it builds and prints the size of the page", () => {
  assert.equal(first.status, 0, first.stderr);
  assert.match(first.stdout, /^page: [0-9]+ files, [0-9]+ bytes of gzip/m);
});

test("the same sources give the same bytes, wherever they are", () => {
  const second = build(another("second"));
  for (const folder of ["page", "docs"]) {
    const [one, other] = [first.out, second.out].map((out) => readdirSync(join(out, folder)).sort());
    assert.deepEqual(one, other);
    for (const name of one) assert.ok(readFileSync(join(first.out, folder, name)).equals(readFileSync(join(second.out, folder, name))), name);
  }
});

test("every file that the page names is there, and none is elsewhere", () => {
  const page = files.get("index.html").toString();
  const named = [...page.matchAll(/(?:src|href)="([^"]*)"/g)].map(([, url]) => url).filter((url) => url.startsWith("/page/"));
  assert.ok(named.length >= 3, page);
  for (const url of named) assert.ok(files.has(url.slice("/page/".length)), url);
  assert.doesNotMatch(page, /(?:src|href)="(?:https?:)?\/\//);
  assert.doesNotMatch(page, /<style|<script>| style=| on\w+=/);
  for (const [name, bytes] of files) {
    for (const [, other] of bytes.toString().matchAll(/(?:from|import\(?) ?"\.\/([^"]+)"/g)) assert.ok(files.has(other), `${name} imports ${other}`);
  }
});

test("a file's name changes with its contents", () => {
  for (const name of files.keys()) {
    if (name !== "index.html" && name !== "licenses.txt") assert.match(name, /^[\w.]+-[A-Z2-7]{8}\.(js|css|svg)$/);
  }
  const changed = another("changed");
  writeFileSync(join(changed, "page/style.css"), "\nbody { margin: 1px }\n", { flag: "a" });
  const names = readdirSync(join(build(changed).out, "page"));
  const style = [...files.keys()].find((name) => name.startsWith("style-"));
  assert.ok(!names.includes(`${style}.gz`));
  assert.equal(names.filter((name) => files.has(name.replace(/\.gz$/, ""))).length, names.length - 1);
});

test("the licences of bundled packages are in the bundle", () => {
  const folder = another("licences");
  writeFileSync(join(folder, "page/main.ts"), 'import { Vector3 } from "three"; document.title = String(new Vector3().length());');
  const made = contents(join(build(folder).out, "page"));
  assert.match(made.get("licenses.txt").toString(), /three 0\.[0-9.]+\n[^]*The MIT License[^]*Copyright © [0-9-]+ three\.js authors/);
  for (const [name, bytes] of made) if (name.endsWith(".js")) assert.match(bytes.toString(), /^\/\*! Licences: \/page\/licenses\.txt \*\//);
});

test("an error is reported with its place, and the last build stays", () => {
  const folder = another("mistaken");
  const before = readdirSync(join(build(folder).out, "page"));
  writeFileSync(join(folder, "page/main.ts"), "let x: = 3\n");
  const wrong = build(folder);
  assert.equal(wrong.status, 1);
  assert.match(wrong.stderr, /main\.ts:1:/);
  assert.deepEqual(readdirSync(join(wrong.out, "page")), before);
});

test("an entry that index.html does not name is an error", () => {
  const folder = another("unnamed");
  const page = join(folder, "page/index.html");
  writeFileSync(page, readFileSync(page, "utf8").replace("style.css", "styl.css"));
  const wrong = build(folder);
  assert.equal(wrong.status, 1);
  assert.match(wrong.stderr, /does not name style\.css/);
});
