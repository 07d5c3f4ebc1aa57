// Bundles page/ and compresses all files that the service serves to browsers: node build.mjs FOLDER
//
// Empties FOLDER and writes page/*.gz and docs/*.gz to it, each served under its name without the .gz. The same sources
// give the same bytes. Scripts, styles and pictures have a digest in their names, so browsers may cache them for ever.
import { mkdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { basename, dirname, join, relative } from "node:path";
import { fileURLToPath } from "node:url";
import { gzipSync } from "node:zlib";
import * as esbuild from "esbuild";

const here = dirname(fileURLToPath(import.meta.url));
const entries = ["main.ts", "style.css", "favicon.svg"];
const licences = "licenses.txt";

const bundling = {
  absWorkingDir: join(here, "page"),
  entryPoints: entries,
  entryNames: "[name]-[hash]",
  chunkNames: "[name]-[hash]",
  assetNames: "[name]-[hash]",
  outdir: "bundle", // required by esbuild, which writes nothing itself
  write: false,
  metafile: true,
  bundle: true,
  format: "esm",
  splitting: true,
  minify: true,
  sourcemap: false,
  legalComments: "none", // licenses.txt has the whole texts; each script names it
  banner: { js: `/*! Licences: /page/${licences} */` },
  loader: { ".svg": "copy" },
  target: ["chrome111", "firefox114", "safari16.4"],
  logLevel: "warning",
};

// Returns the name, version and licence of each package in the bundle.
function licenceTexts(inputs) {
  const packages = new Set();
  for (const input of Object.keys(inputs)) {
    const [, name] = /node_modules\/((?:@[^/]+\/)?[^/]+)\/[^]*$/.exec(input) ?? [];
    if (name) packages.add(name);
  }
  const texts = [...packages].sort().map((name) => {
    const folder = join(here, "node_modules", name);
    const { version } = JSON.parse(readFileSync(join(folder, "package.json"), "utf8"));
    return `${name} ${version}\n\n${readFileSync(join(folder, "LICENSE"), "utf8").trim()}\n`;
  });
  const intro = "The page of meshgauge is under the MIT licence, as meshgauge is.\n";
  return texts.length ? `${intro}Its scripts contain:\n\n${texts.join("\n\n")}` : intro;
}

// Returns index.html with the names of page/ replaced by those of the bundle.
function indexPage(outputs) {
  const named = new Map(Object.entries(outputs).flatMap(([name, { entryPoint }]) =>
    entries.includes(entryPoint) ? [[entryPoint, name]] : []));
  const url = (name) => `/page/${basename(name)}`;
  const missing = new Set(entries);
  const text = readFileSync(join(here, "page/index.html"), "utf8").replace(/(src|href)="([^"]+)"/g, (whole, attribute, name) => {
    if (!named.has(name)) return whole;
    missing.delete(name);
    return `${attribute}="${url(named.get(name))}"`;
  });
  if (missing.size) throw new Error(`page/index.html does not name ${[...missing].join(", ")}`);
  const early = outputs[named.get("main.ts")].imports.filter(({ kind }) => kind === "import-statement");
  return text.replace("</head>", early.map(({ path }) => `<link rel="modulepreload" href="${url(path)}">`).join("") + "</head>");
}

async function page() {
  const { outputFiles, metafile } = await esbuild.build(bundling);
  const files = new Map(outputFiles.map(({ path, contents }) => [basename(path), contents]));
  files.set("index.html", indexPage(metafile.outputs));
  files.set(licences, licenceTexts(metafile.inputs));
  return files;
}

// Returns the files of /docs: two of this folder, and swagger-ui unchanged.
function docs() {
  const swagger = join(here, "node_modules/swagger-ui-dist");
  const theirs = ["swagger-ui-bundle.js", "swagger-ui.css", "favicon-32x32.png", "LICENSE", "NOTICE", "swagger-ui-bundle.js.LICENSE.txt"];
  const paths = [join(here, "docs.html"), join(here, "docs.js"), ...theirs.map((name) => join(swagger, name))];
  return new Map(paths.map((path) => [basename(path), readFileSync(path)]));
}

// Writes the files, compressed, and returns the number of bytes written.
function write(folder, files) {
  mkdirSync(folder, { recursive: true });
  let bytes = 0;
  for (const [name, contents] of [...files].sort(([a], [b]) => (a < b ? -1 : 1))) {
    const compressed = gzipSync(contents, { level: 9 });
    writeFileSync(join(folder, `${name}.gz`), compressed);
    bytes += compressed.length;
  }
  return bytes;
}

const out = process.argv[2];
if (!out) {
  console.error("usage: node build.mjs FOLDER");
  process.exit(2);
}
try {
  const files = { page: await page(), docs: docs() };
  rmSync(out, { recursive: true, force: true });
  for (const [name, some] of Object.entries(files)) {
    console.log(`${name}: ${some.size} files, ${write(join(out, name), some)} bytes of gzip in ${relative("", out) || out}`);
  }
} catch (error) {
  if (!error.errors) console.error(`build.mjs: ${error.message}`); // esbuild has printed its errors
  process.exit(1);
}
