// The comment of the README's picture: what the action writes on a pull request whose gear is out of tolerance.
import { execFileSync, spawnSync } from "node:child_process";
import { mkdirSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { pathToFileURL } from "node:url";
import { scaled, stl, written } from "./browser/meshes.mjs";
import { binary, root } from "./browser/service.mjs";
import { drawn, printed } from "./gallery_meshes.mjs";

const base = "5d0c1b7e92a64f38b1e07c5a9d2f6e4083ab71c4", head = "c29f4e61d8b35a07f6120e9bd4738ac51f0e62d9"; // commits

const manifest = `version: 1
defaults:
  max_distance: 0.3 mm
gates:
  - name: "{stem}"
    candidate: "parts/*.stl"
    baseline: "baselines/{stem}.stl"
`;

// The header and the frame of a comment on GitHub, and how Markdown looks there.
const style = `
  * { box-sizing: border-box; }
  body { margin: 0; background: #fff; color: #1d2228; font: 14px/1.5 system-ui, "Noto Sans", sans-serif, "Noto Color Emoji"; }
  article { border: 1px solid #ced4da; border-radius: 6px; overflow: hidden; }
  header { padding: 8px 16px; background: #f4f6f8; border-bottom: 1px solid #ced4da; color: #5b646e; }
  header b { color: #1d2228; }
  header i { margin: 0 4px; padding: 0 6px; border: 1px solid #ced4da; border-radius: 9px; font-size: 12px; font-style: normal; }
  section { padding: 16px; overflow-wrap: anywhere; }
  section > :first-child { margin-top: 0; }
  section > :last-child { margin-bottom: 0; }
  h2, h3 { margin: 20px 0 12px; line-height: 1.25; }
  h2 { padding-bottom: 6px; border-bottom: 1px solid #dfe3e8; font-size: 20px; }
  h3 { font-size: 17px; }
  p, ul, table, details { margin: 0 0 14px; }
  ul { padding-left: 26px; }
  a { color: #0b5cad; }
  code { padding: 2px 5px; border-radius: 5px; background: #eef0f3; font: 12px ui-monospace, "DejaVu Sans Mono", monospace; }
  h3 code { font-size: inherit; }
  table { border-collapse: collapse; font-variant-numeric: tabular-nums; }
  th, td { padding: 5px 12px; border: 1px solid #ced4da; }
  td { white-space: nowrap; }
  img { display: block; max-width: 100%; }
  summary { cursor: default; }
`;

// Writes a page into the folder, whose <article> is the comment. Returns the address of the page.
export function commented(folder) {
  const place = join(folder, "pull"), reports = join(place, "reports");
  for (const made of [reports, join(place, "base")]) mkdirSync(made, { recursive: true });
  writeFileSync(join(place, "gates.yaml"), manifest);
  put(join(place, "baselines"), { gear: drawn(), idler: scaled(drawn(), 0.3), pinion: scaled(drawn(), 0.2) });
  put(join(place, "parts"), { gear: scaled(drawn(), 0.998), idler: scaled(printed(), 0.3), pinion: scaled(printed(), 0.2) });
  check(place, 0, `--json=base/${base}.json`);
  put(join(place, "parts"), { gear: printed() });
  check(place, 1, "--since", `base/${base}.json`, "--comment", "reports/comment.md", "--pictures", "reports/pictures");
  const page = join(place, "comment.html"), body = html(markdown(place, reports));
  writeFileSync(page, `<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>A comment</title><style>${style}</style></head>
<body><article><header><b>github-actions</b> <i>bot</i> commented</header><section>${body}</section></article></body></html>
`);
  return pathToFileURL(page).href;
}

function put(folder, meshes) {
  written(folder, Object.fromEntries(Object.entries(meshes).map(([name, mesh]) => [`${name}.stl`, stl(mesh)])));
}

// Runs the gates, which must end with this exit code.
function check(place, code, ...flags) {
  const { status, stderr } = spawnSync(binary, ["check", "gates.yaml", ...flags], { cwd: place, encoding: "utf8" });
  if (status !== code) throw new Error(`check ended with ${status}: ${stderr}`);
}

// The text that the action's own program sends to GitHub, with the pictures at their places on this machine.
function markdown(place, reports) {
  const program = "import comment, sys; print(comment.body_of('<!-- meshgauge: gates.yaml -->', sys.argv[1]))";
  const env = {
    ...process.env, PYTHONPATH: join(root, "docker/ci"), PYTHONUTF8: "1",
    COMMENT_REPORTS: reports, COMMENT_PICTURES: pathToFileURL(join(reports, "pictures")).href,
    GITHUB_SERVER_URL: "https://github.com", GITHUB_REPOSITORY: "example/parts", GITHUB_RUN_ID: "1",
  };
  return execFileSync("python3", ["-B", "-c", program, head], { cwd: place, env, encoding: "utf8" });
}

function html(text) {
  const extensions = ["table", "autolink", "strikethrough", "tasklist"].flatMap((name) => ["--extension", name]);
  return execFileSync("cmark-gfm", ["--unsafe", ...extensions], { input: text, encoding: "utf8" });
}
