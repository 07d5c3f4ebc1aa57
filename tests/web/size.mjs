// Fails when the page adds more to the binary than it may: node size.mjs BUNDLE, the folder whose files were embedded.
import { readdirSync, statSync } from "node:fs";
import { join } from "node:path";

const most = 1_000_000;
const folder = join(process.argv[2], "page");
const sizes = readdirSync(folder).map((name) => [statSync(join(folder, name)).size, name]).sort(([a], [b]) => b - a);
const sum = sizes.reduce((bytes, [size]) => bytes + size, 0);
for (const [size, name] of sizes) console.log(String(size).padStart(9), name);
console.log(`${sum} bytes of gzip; ${most} at most`);
if (!sizes.some(([, name]) => name === "index.html.gz")) throw new Error(`${folder} has no page`);
process.exit(sum < most ? 0 : 1);
