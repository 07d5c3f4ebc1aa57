// The page's unit tests: node run_unit.mjs FOLDER [NAME...] bundles unit/NAME.test.ts, by default all, into one file of the
// folder, and runs it: one process costs less than one for each. The bundler and three come from server/web.
import { spawnSync } from "node:child_process";
import { mkdirSync, readdirSync, rmSync } from "node:fs";
import { createRequire } from "node:module";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

const here = dirname(fileURLToPath(import.meta.url));
const web = join(here, "../../server/web");
const [folder, ...names] = process.argv.slice(2);
if (!folder) {
  console.error("usage: node run_unit.mjs FOLDER [NAME...]");
  process.exit(2);
}
const ending = ".test.ts";
const wanted = names.length ? names.map((name) => name + ending) : readdirSync(join(here, "unit")).filter((name) => name.endsWith(ending));

rmSync(folder, { recursive: true, force: true });
mkdirSync(folder, { recursive: true });
const esbuild = createRequire(join(web, "build.mjs"))("esbuild");
const bundle = join(folder, "unit.mjs");
await esbuild.build({
  stdin: { contents: wanted.map((name) => `import "./${name}";`).join("\n"), resolveDir: join(here, "unit") },
  outfile: bundle,
  bundle: true,
  format: "esm",
  platform: "node",
  target: "node18",
  sourcemap: "inline",
  nodePaths: [join(web, "node_modules")],
  logLevel: "warning",
}).catch(() => process.exit(1)); // it has said why
process.exit(spawnSync(process.execPath, ["--enable-source-maps", bundle], { stdio: "inherit" }).status ?? 1);
