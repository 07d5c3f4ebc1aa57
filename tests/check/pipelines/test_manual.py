"""docs/ci.md does what it says: its commands, its tables, its recipes, its links."""

import json
import pathlib
import re
import shlex
import subprocess
import tempfile
import unittest

import manual
import yaml
from harness import ROOT, Server
from manual import MANUAL, PIPELINE, README, RELEASES, Releases, as_glb, blocks, box, box_and_support, files, repository, rows, tools

SECONDS = re.compile(r"\d+\.\d+ s\b")
DIGITS = re.compile(r"\d+\.\d{8,}")
RECIPES = {name: text for name, text in files(MANUAL).items() if text.split("\n")[1] == "version: 1" and name != "gates.yaml"}


def steady(text):
    """Without what differs from run to run: times, and the last digits, which are the machine's."""
    return DIGITS.sub(lambda number: f"{float(number[0]):.6g}", SECONDS.sub("T s", text))


class Place(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.top = pathlib.Path(folder.name)
        self.environment = tools(self.top)
        self.folder = self.top / "repository"
        self.releases = Releases(self.top)
        self.addCleanup(self.releases.close)

    def run_in(self, *command, folder=None, **how):
        return subprocess.run([str(c) for c in command], cwd=folder or self.folder, env=self.environment, text=True,
                              capture_output=True, check=False, timeout=200, **how)

    def check(self, *arguments):
        return self.run_in("meshgauge", "check", *arguments)


class Commands(Place):
    def run_page(self, page, service):
        """[(block, exit code, output, errors)] of a page's commands, one after the other in one shell and one folder."""
        self.folder.mkdir(exist_ok=True)
        for name, text in files(page).items():
            (self.folder / name).parent.mkdir(parents=True, exist_ok=True)
            (self.folder / name).write_text(text)
        scripts = [block for block in blocks(page) if block.language == "sh"]
        top = shlex.quote(str(self.top))
        script = "".join(f"{{\n{b.text}}} > {top}/{i}.out 2> {top}/{i}.err\necho $? > {top}/{i}.code\n"
                         for i, b in enumerate(scripts))
        done = self.run_in("sh", "-uc", script.replace("http://127.0.0.1:8080", service).replace(RELEASES, self.releases.url))
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return [(b, int((self.top / f"{i}.code").read_text()), (self.top / f"{i}.out").read_text(),
                 (self.top / f"{i}.err").read_text()) for i, b in enumerate(scripts)]

    def try_page(self, page):
        """Every command ends as the page says, and each output shown is that of a command."""
        self.environment["GIT_DIR"] = str(self.top / "git")
        self.environment["GIT_WORK_TREE"] = str(self.folder)
        self.assertEqual(self.run_in("git", "init", "-q", folder=self.top).returncode, 0)
        server = Server()
        try:
            ran = self.run_page(page, f"http://127.0.0.1:{server.port}")
        finally:
            server.stop()
        for block, code, out, err in ran:
            wanted = re.search(r"exit=(\d)", block.note)
            self.assertEqual(code, int(wanted[1]) if wanted else 0, (block, out, err))
        printed = [steady(out) for _, _, out, _ in ran]
        for block in blocks(page):
            if block.language == "text":
                self.assertIn(steady(block.text), printed)
        return ran

    def test_the_manual(self):
        if self.run_in("git", "lfs", "version", folder=self.top).returncode != 0:
            self.skipTest("no git-lfs (./dev setup test)")
        self.try_page(MANUAL)
        self.assertIn("baselines/** filter=lfs", (self.folder / ".gitattributes").read_text())
        for name in ("report.json", "junit.xml", "meshgauge.sarif", "code-quality.json", "report.html", "summary.md"):
            self.assertGreater((self.folder / name).stat().st_size, 0, name)

    def test_the_readme(self):
        repository(self.folder, broken=True)
        for part in [*self.folder.glob("*/*.off")]:
            part.rename(part.with_suffix(".stl"))  # files are read by what they hold
        self.try_page(PIPELINE)

    def test_the_witness_is_in_the_hole(self):
        repository(self.folder, broken=True)
        done = self.check("gates.yaml", "--json")
        gates = {gate["name"]: gate for gate in json.loads(done.stdout)["gates"]}
        self.assertEqual({name: gate["verdict"] for name, gate in gates.items()},
                         {"bracket": "fail", "pin": "pass", "plate": "pass"})
        x, y, z = gates["bracket"]["witness"]["point"]
        self.assertEqual((gates["bracket"]["witness"]["on"], x), ("baseline", 20))
        # The triangle that is missing: (20, 20, 0), (20, 20, 20), (20, 0, 20).
        self.assertTrue(0 < y < 20 and 0 < z < 20 and y + z > 20, (y, z))


class Recipes(Place):
    def try_recipe(self, name, candidate, baseline):
        self.folder.mkdir(exist_ok=True)
        (self.folder / name).write_text(RECIPES[name])
        gates = yaml.safe_load(RECIPES[name])["gates"]
        for gate in gates:
            for path, text in ((gate["candidate"].replace("*", "part"), candidate),
                               (gate["baseline"].replace("{stem}", "part"), baseline)):
                (self.folder / path).parent.mkdir(parents=True, exist_ok=True)
                content = as_glb(text) if path.endswith(".glb") else text.encode()
                (self.folder / path).write_bytes(content)
        done = self.check(name, "--json")
        self.assertIn(done.returncode, (0, 1), done.stderr)
        return {gate["name"]: (gate["verdict"], gate["level"]) for gate in json.loads(done.stdout)["gates"]}

    def test_all_pass_and_fail_as_they_say(self):
        self.assertEqual(set(RECIPES), {"decimation.yaml", "exporter.yaml", "print.yaml", "lod.yaml"})
        for name, text in RECIPES.items():
            gates = yaml.safe_load(text)["gates"]
            with self.subTest(recipe=name):
                self.assertEqual(set(self.try_recipe(name, box(), box()).values()), {("pass", "ok")})
                worse = self.try_recipe(name, box_and_support(), box())
                for gate in gates:
                    level = "warning" if gate.get("on_fail") == "warn" else "failure"
                    nothing_missing = gate.get("direction") == "baseline_to_candidate"
                    self.assertEqual(worse[gate["name"].replace("{stem}", "part")],
                                     ("pass", "ok") if nothing_missing else ("fail", level), gate)


class Words(Place):
    def test_flags_are_those_of_the_program(self):
        self.folder.mkdir()
        help_text = self.check("--help").stdout
        for page in (MANUAL, PIPELINE):
            shown = {flag for block in blocks(page) if block.language == "sh" for line in block.text.splitlines()
                     if "meshgauge check" in line or line.startswith("  --") for flag in re.findall(r"--[a-z-]+", line)}
            shown |= set(re.findall(r"`(--[a-z-]+)[=` ]", page))
            for flag in shown:
                self.assertRegex(help_text, rf"{flag}\b")

    def test_links_lead_somewhere(self):
        for page, folder in ((MANUAL, ROOT / "docs"), (PIPELINE, ROOT)):
            for target in re.findall(r"\]\(([^)\s]+)\)", page):
                path, _, anchor = target.partition("#")
                self.assertTrue((folder / path).exists(), target)
                text = page
                if path:  # a picture has no headings
                    text = (folder / path).read_text() if path.endswith(".md") else ""
                headings = {re.sub(r"[^\w -]", "", h).strip().lower().replace(" ", "-") for h in re.findall(r"^#+ (.*)$", text, re.M)}
                self.assertTrue(not anchor or anchor in headings, target)

    def test_inputs_and_outputs_are_those_of_the_action(self):
        action = yaml.safe_load((ROOT / "action.yml").read_text())
        named = [name for row in rows(MANUAL, "input | default") for name in re.findall(r"`([\w-]+)`", row[0])]
        self.assertEqual(sorted(named), sorted(action["inputs"]))
        self.assertEqual(sorted(row[0].strip("`") for row in rows(MANUAL, "output")), sorted(action["outputs"]))
        for name, default in ((row[0], row[1]) for row in rows(MANUAL, "input | default") if row[1]):
            self.assertEqual(action["inputs"][name.strip("`")]["default"], default.strip("`"))

    def test_the_readme_leads_here(self):
        self.assertIn("(docs/ci.md", README)
        self.assertEqual(manual.files(PIPELINE).keys() & {"gates.yaml"}, {"gates.yaml"})
