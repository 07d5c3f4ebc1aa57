"""The GitHub Action: its step `check` is run as a runner runs it, with the built program as the release's."""

import json
import os
import pathlib
import platform
import re
import shutil
import subprocess
import tempfile
import unittest

import yaml
from harness import ROOT, Server
from manual import Releases, box, repository, tools

ACTION = yaml.safe_load((ROOT / "action.yml").read_text())
STEPS = {step["id"]: step for step in ACTION["runs"]["steps"]}
EXPRESSION = re.compile(r"\$\{\{ *([\w.-]+) *\}\}")


class Runner(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.top = pathlib.Path(folder.name)
        self.environment = {**{k: v for k, v in tools(self.top).items() if not k.startswith("GITHUB_")}, "GITHUB_ACTIONS": "true",
                            "GITHUB_ACTION_PATH": str(ROOT), "GITHUB_SHA": "5" * 40}
        self.releases = Releases(self.top)
        self.addCleanup(self.releases.close)
        self.workspace = self.top / "work space"
        self.summary = self.top / "summary.md"

    def use(self, broken=False, repository_of_action="Owner/MeshGauge", event="", base_key="", **inputs):
        """What `uses:` does with such inputs until the step `check` ends: its exit code. Sets self.outputs, self.log and self.docker.

        base_key: the key of the cache that the step `base` has found.
        """
        if not self.workspace.exists():
            repository(self.workspace, broken)
        self.values = {"github.action_repository": repository_of_action, "steps.base.outputs.cache-matched-key": base_key}
        inputs.setdefault("releases", self.releases.url)
        for name, declared in ACTION["inputs"].items():
            self.values[f"inputs.{name}"] = inputs.pop(name.replace("-", "_"), declared.get("default", ""))
        self.assertFalse(inputs)
        self.summary.write_text("")
        output = self.top / "output"
        output.write_text("")
        done = self.run_step("check", GITHUB_EVENT_NAME=event, GITHUB_OUTPUT=str(output))
        given = dict(line.split("=", 1) for line in output.read_text().splitlines())
        self.outputs = {name: given.get(EXPRESSION.fullmatch(declared["value"])[1].rsplit(".", 1)[1], "")
                        for name, declared in ACTION["outputs"].items()}
        self.assertLessEqual(set(given), {*ACTION["outputs"], "kept"})
        self.kept = given.get("kept")
        self.log = done.stdout + done.stderr
        docker = self.top / "tools/docker.log"
        self.docker = docker.read_text().splitlines() if docker.exists() else []
        return done.returncode

    def run_step(self, name, **variables):
        """Runs a step of the action with its variables, and with these beside them."""
        step = STEPS[name]
        environment = {**self.environment, "GITHUB_STEP_SUMMARY": str(self.summary), "GITHUB_WORKSPACE": str(self.workspace), **variables}
        for variable, value in step["env"].items():
            environment[variable] = EXPRESSION.sub(lambda found: self.values[found[1]], value)
        return subprocess.run(["bash", "--noprofile", "--norc", "-eo", "pipefail", "-c", step["run"]], cwd=self.workspace,
                              env=environment, text=True, capture_output=True, check=False, timeout=200)


class Verdicts(Runner):
    def test_pass(self):
        self.assertEqual(self.use(), 0, self.log)
        self.assertEqual(self.outputs, {"verdict": "pass", "exit-code": "0", "reports": "meshgauge-reports",
                                        "sarif": "meshgauge-reports/meshgauge.sarif"})
        self.assertTrue(self.summary.read_text().startswith("## ✅ meshgauge: all gates hold\n"))
        self.assertEqual({file.name for file in (self.workspace / "meshgauge-reports").iterdir()},
                         {"annotations.txt", "comment.md", "junit.xml", "log.txt", "meshgauge.sarif", "pictures", "report.html",
                          "report.json", "summary.md"})

    def test_fail(self):
        self.assertEqual(self.use(broken=True, reports="out/of it"), 1, self.log)
        self.assertEqual((self.outputs["verdict"], self.outputs["exit-code"]), ("fail", "1"))
        self.assertIn("### ❌ `bracket`", self.summary.read_text())
        self.assertIn("(20, 14.14", self.log)
        sarif = json.loads((self.workspace / self.outputs["sarif"]).read_text())
        (result,) = sarif["runs"][0]["results"]
        place = result["locations"][0]["physicalLocation"]
        self.assertEqual(place["artifactLocation"]["uri"], "gates.yaml")
        self.assertIn('- name: "{stem}"', (self.workspace / "gates.yaml").read_text().splitlines()[place["region"]["startLine"] - 1])

    def undecided(self, **inputs):
        repository(self.workspace)
        # The distance equals the limit, which floating-point arithmetic cannot decide.
        text = (self.workspace / "parts/pin.off").read_text()
        (self.workspace / "parts/pin.off").write_text(re.sub(r"\b60$", "60.1", text, flags=re.M))
        manifest = self.workspace / "gates.yaml"
        manifest.write_text(manifest.read_text().replace("0.05 mm", "0.10000000000000142 mm"))
        return self.use(**inputs)

    def test_undecided(self):
        self.assertEqual(self.undecided(), 2, self.log)
        self.assertEqual((self.outputs["verdict"], self.outputs["exit-code"]), ("undecided", "2"))
        self.assertTrue(self.summary.read_text().startswith("## ❔ meshgauge: undecided\n"))

    def test_undecided_counts_as_it_is_said(self):
        self.assertEqual(self.undecided(undecided="warn"), 0, self.log)
        self.assertEqual(self.outputs["verdict"], "pass")
        self.assertEqual(self.use(undecided="fail"), 1, self.log)

    def test_nothing_measured(self):
        self.assertEqual(self.use(manifest="``` missing.yaml\n## title"), 3, self.log)
        self.assertEqual(self.outputs["verdict"], "error")
        self.assertIn("missing.yaml", (self.workspace / self.outputs["sarif"]).read_text())
        self.assertIn("missing.yaml", self.summary.read_text())

    def assert_not_fetched(self, reason, **inputs):
        self.assertEqual(self.use(**inputs), 3, self.log)
        self.assertEqual(self.docker, [])
        self.assertEqual((self.outputs["verdict"], self.outputs["sarif"]), ("error", ""))
        reports = self.workspace / "meshgauge-reports"
        self.assertEqual({file.name for file in reports.iterdir()}, {"comment.md", "log.txt", "summary.md"})
        self.assertIn(reason, self.summary.read_text())
        self.assertIn(reason, (reports / "comment.md").read_text())

    def test_no_such_release(self):
        self.assert_not_fetched("404", version="9.9.9")

    def test_another_digest_than_was_given(self):
        self.assert_not_fetched("SHA-256: " + "1" * 64, sha256="1" * 64)

    def test_another_file_than_the_release_lists(self):
        with self.releases.archive.open("ab") as archive:
            archive.write(b"more")
        self.assert_not_fetched("SHA-256: " + self.releases.sha256)

    def test_a_release_without_this_machine(self):
        (self.releases.place / "SHA256SUMS").write_text("")
        self.assert_not_fetched("does not list")

    def test_a_runner_that_no_release_is_for(self):
        uname = self.top / "tools/uname"
        uname.write_text("#!/bin/sh\n[ \"$1\" = -s ] && echo Darwin || echo arm64\n")
        uname.chmod(0o755)
        self.assert_not_fetched("no program for this runner, darwin-arm64")
        self.assertIn(f"There are programs for: linux-{platform.machine()}. ", self.log)

    def test_refused_before_a_report(self):
        self.assertEqual(self.use(arguments="--no-such-flag"), 3, self.log)
        self.assertEqual((self.outputs["verdict"], self.outputs["sarif"]), ("error", ""))
        title, blank, *log = self.summary.read_text().splitlines()
        self.assertEqual((title, blank), ("## ❌ meshgauge: nothing was measured", ""))
        self.assertTrue(log and all(line.startswith("    ") for line in log), log)

    def test_reports_of_a_step_before_are_not_shown(self):
        self.use()
        self.assertEqual(self.use(arguments="--no-such-flag"), 3, self.log)
        self.assertEqual(self.outputs["sarif"], "")
        self.assertNotIn("all gates hold", self.summary.read_text())


class Container(Runner):
    def use(self, **inputs):
        return super().use(**{"container": "true", **inputs})

    def runs(self):
        return [line for line in self.docker if line.startswith("run ")]

    def test_only_where_it_is_asked_for(self):
        self.assertEqual(self.use(broken=True, container="false"), 1, self.log)
        self.assertEqual(self.docker, [])

    def test_without_rights_and_network(self):
        self.use()
        self.assertEqual([line.split()[0] for line in self.docker], ["info", "import", "run"])
        (line,) = self.runs()
        for words in ("--rm", "--read-only", "--cap-drop ALL", "--security-opt no-new-privileges", "--network none",
                      f"--user {os.getuid()}:{os.getgid()}", f"--workdir {self.workspace}",
                      f"--mount type=bind,source={self.workspace},target={self.workspace}",
                      "--entrypoint /meshgauge sha256:imported check gates.yaml "):
            self.assertIn(words, line)
        self.assertIn("./meshgauge\n", (self.top / "tools/docker.log.image").read_text())

    def test_where_there_is_no_docker(self):
        self.environment["DOCKER_INFO"] = "1"
        self.assertEqual(self.use(broken=True), 3, self.log)
        self.assertEqual(self.docker, ["info"])
        self.assertIn("needs docker, which does not run here", self.summary.read_text())

    def test_a_docker_that_has_other_folders(self):
        self.environment["DOCKER_RUN"] = "125"
        self.assertEqual(self.use(), 3, self.log)
        self.assertIn(f"it has no folder {self.workspace}", self.summary.read_text())

    def test_version_and_digest_are_given(self):
        shutil.copytree(self.releases.place, self.releases.place.parent / "v1.2.3")
        name = self.releases.archive.name
        (self.releases.place.parent / "v1.2.3" / name).rename(self.releases.place.parent / "v1.2.3" / name.replace(self.releases.version, "1.2.3"))
        self.assertEqual(self.use(version="1.2.3", sha256=self.releases.sha256), 0, self.log)

    def test_releases_are_those_of_the_repository(self):
        self.environment["GITHUB_SERVER_URL"] = f"{self.releases.url}/no-such"
        self.assertEqual(self.use(releases=""), 3)
        self.assertIn(f"{self.releases.url}/no-such/Owner/MeshGauge/releases/download", self.log)

    def test_a_service_measures(self):
        server = Server()
        try:
            self.assertEqual(self.use(broken=True, server=f"http://127.0.0.1:{server.port}", key="mg_secret_of_ci"), 1, self.log)
        finally:
            server.stop()
        (line,) = self.runs()
        self.assertNotIn("--network", line)
        self.assertIn("--env MESHGAUGE_KEY", line)
        self.assertNotIn("mg_secret_of_ci", "".join(self.docker) + self.log)
        self.assertIn("PUT", "".join(server.log))

    def test_inputs_are_no_commands(self):
        evil = '$(touch pwned) `touch pwned`; touch pwned #\' "'
        for name in ("manifest", "undecided", "server", "version", "sha256", "releases", "arguments"):
            self.use(**{name: evil})
            self.assertFalse([*self.top.rglob("pwned")], name)
        self.assertIn(evil, self.runs()[-1])

    def test_arguments_are_one_a_line(self):
        self.assertEqual(self.use(broken=True, arguments="--only\np*\n\n--quiet\n"), 0, self.log)
        report = json.loads((self.workspace / "meshgauge-reports/report.json").read_text())
        self.assertEqual([gate["name"] for gate in report["gates"]], ["pin", "plate"])


class Log(Runner):
    def test_annotations_are_the_only_commands(self):
        repository(self.workspace, broken=True)
        for name in ("##[error]x", "%0A::error::y"):
            (self.workspace / f"parts/{name}.off").write_bytes((self.workspace / "parts/bracket.off").read_bytes())
            (self.workspace / f"baselines/{name}.off").write_bytes((self.workspace / "baselines/bracket.off").read_bytes())
        self.assertEqual(self.use(), 1, self.log)
        lines = [line for line in self.log.splitlines() if line.startswith("::") or "##[" in line]
        word = re.fullmatch(r"::stop-commands::([0-9a-f]{32})", lines[0])[1]
        end = lines.index(f"::{word}::")
        self.assertEqual(lines[1:end], [])
        self.assertIn("##\\x5Berror]x", self.log)
        commands = lines[end + 1:]
        self.assertEqual(len(commands), 3)
        for line in commands:
            self.assertRegex(line, r"^::error file=gates\.yaml,line=\d+,title=meshgauge%3A [^:,]+::Gate '")

    def test_the_words_differ(self):
        self.use()
        first = self.log.splitlines()[0]
        self.use()
        self.assertNotEqual(self.log.splitlines()[0], first)


class Base(Runner):
    """The report that a push leaves, and what a pull request says of it."""

    def test_a_push_keeps_its_report_for_pull_requests(self):
        self.assertEqual(self.use(event="push"), 0, self.log)
        self.assertEqual(self.kept, f"meshgauge-reports/base/{'5' * 40}.json")
        self.assertEqual(self.use(event="pull_request", base_key=f"meshgauge-1-2-{'5' * 40}"), 0, self.log)
        self.assertIsNone(self.kept)
        self.assertIn(f"Nothing changed since `{'5' * 40}`.", self.summary.read_text())
        (self.workspace / "parts/bracket.off").write_text(box(hole=True))
        self.assertEqual(self.use(event="pull_request", base_key=f"meshgauge-1-2-{'5' * 40}"), 1, self.log)
        for text in (self.summary.read_text(), (self.workspace / "meshgauge-reports/comment.md").read_text()):
            self.assertIn(f"Changed since `{'5' * 40}`:", text)
            self.assertRegex(text, r"\n\| `bracket` \| pass, .* \| fail, .* \|\n")

    def test_a_base_without_a_report_or_with_a_damaged_one(self):
        self.assertEqual(self.use(event="pull_request", base_key="meshgauge-1-2-abc"), 0, self.log)
        self.assertNotIn("since", self.summary.read_text())
        base = self.workspace / "meshgauge-reports/base"
        base.mkdir()
        (base / "abc.json").write_text('{"gates": [')
        self.assertEqual(self.use(event="pull_request", base_key="meshgauge-1-2-abc"), 0, self.log)
        self.assertIn("What changed since `abc` is not known", self.summary.read_text())

    def test_nothing_is_kept_where_nothing_was_measured(self):
        self.assertEqual(self.use(event="push", manifest="none.yaml"), 3, self.log)
        self.assertIsNone(self.kept)

    def test_the_key_holds_no_character_that_a_cache_refuses(self):
        keys = set()
        for manifest in ("gates.yaml", "a,b.yaml", "$(touch pwned)\n", "x" * 5000):
            output = self.top / "key"
            output.write_text("")
            done = subprocess.run(["bash", "-eo", "pipefail", "-c", STEPS["key"]["run"]], check=False, cwd=self.top, env={
                **self.environment, "INPUT_MANIFEST": manifest, "INPUT_ARGUMENTS": "", "GITHUB_OUTPUT": str(output)})
            self.assertEqual(done.returncode, 0)
            self.assertRegex(output.read_text(), r"^key=meshgauge-\d+-\d+\n$")
            keys.add(output.read_text())
        self.assertEqual(len(keys), 4)
        self.assertFalse((self.top / "pwned").exists())


class Script(unittest.TestCase):
    def test_every_variable_is_given(self):
        script = (ROOT / "docker/ci/action.sh").read_text()
        self.assertEqual(set(re.findall(r"\b(?:INPUT|ACTION)_[A-Z\d]+\b", script)) | {"MESHGAUGE_KEY"}, set(STEPS["check"]["env"]))
        script = (ROOT / "docker/ci/comment.py").read_text()
        self.assertEqual(set(re.findall(r"\bCOMMENT(?:_[A-Z]+)?\b", script)) - {"COMMENT_SECONDS"}, set(STEPS["comment"]["env"]))
        script = (ROOT / "docker/ci/pictures.sh").read_text()
        self.assertEqual(set(re.findall(r"\bPICTURES_[A-Z]+\b", script)), set(STEPS["pictures"]["env"]))

    def test_inputs_are_used_and_stand_in_no_command(self):
        used = set(re.findall(r"\binputs\.([\w-]+)", json.dumps(ACTION["runs"])))
        self.assertEqual(used, set(ACTION["inputs"]))
        for step in STEPS.values():
            self.assertNotIn("${{", step.get("run", ""))

    def test_no_step_that_runs_the_program_has_the_token(self):
        holders = [name for name, step in STEPS.items() if "inputs.token" in json.dumps(step)]
        self.assertEqual(holders, ["pictures", "comment"])
