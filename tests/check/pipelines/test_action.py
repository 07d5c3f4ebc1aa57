"""The GitHub Action: its step is run as a runner runs it, with the built program as the release's."""

import json
import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

import yaml
from harness import ROOT, Server
from manual import Releases, repository, tools

ACTION = yaml.safe_load((ROOT / "action.yml").read_text())
EXPRESSION = re.compile(r"\$\{\{ *([\w.-]+) *\}\}")


class Runner(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.top = pathlib.Path(folder.name)
        self.environment = tools(self.top)
        self.releases = Releases(self.top)
        self.addCleanup(self.releases.close)
        self.workspace = self.top / "work space"
        self.summary = self.top / "summary.md"

    def use(self, broken=False, repository_of_action="Owner/MeshGauge", **inputs):
        """What `uses:` does with such inputs: the exit code. Sets self.outputs, self.log and self.docker."""
        if not self.workspace.exists():
            repository(self.workspace, broken)
        values = {"github.action_repository": repository_of_action}
        inputs.setdefault("releases", self.releases.url)
        for name, declared in ACTION["inputs"].items():
            values[f"inputs.{name}"] = inputs.pop(name.replace("-", "_"), declared.get("default", ""))
        self.assertFalse(inputs)
        (step,) = ACTION["runs"]["steps"]
        output = self.top / "output"
        for file in (self.summary, output):
            file.write_text("")
        environment = {**self.environment, "GITHUB_STEP_SUMMARY": str(self.summary), "GITHUB_OUTPUT": str(output),
                       "GITHUB_ACTION_PATH": str(ROOT), "GITHUB_WORKSPACE": str(self.workspace)}
        for name, value in step["env"].items():
            environment[name] = EXPRESSION.sub(lambda found: values[found[1]], value)
        done = subprocess.run(["bash", "--noprofile", "--norc", "-eo", "pipefail", "-c", step["run"]], cwd=self.workspace,
                              env=environment, text=True, capture_output=True, check=False, timeout=200)
        given = dict(line.split("=", 1) for line in output.read_text().splitlines())
        self.outputs = {name: given.get(EXPRESSION.fullmatch(declared["value"])[1].rsplit(".", 1)[1], "")
                        for name, declared in ACTION["outputs"].items()}
        self.assertLessEqual(set(given), set(ACTION["outputs"]))
        self.log = done.stdout + done.stderr
        docker = self.top / "tools/docker.log"
        self.docker = docker.read_text().splitlines() if docker.exists() else []
        return done.returncode


class Verdicts(Runner):
    def test_pass(self):
        self.assertEqual(self.use(), 0, self.log)
        self.assertEqual(self.outputs, {"verdict": "pass", "exit-code": "0", "reports": "meshgauge-reports",
                                        "sarif": "meshgauge-reports/meshgauge.sarif"})
        self.assertTrue(self.summary.read_text().startswith("## ✅ meshgauge: all gates hold\n"))
        self.assertEqual({file.name for file in (self.workspace / "meshgauge-reports").iterdir()},
                         {"junit.xml", "log.txt", "meshgauge.sarif", "report.html", "report.json", "summary.md"})

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
        self.assertEqual([line for line in self.docker if line != "info"], [])
        self.assertEqual((self.outputs["verdict"], self.outputs["sarif"]), ("error", ""))
        self.assertEqual({file.name for file in (self.workspace / "meshgauge-reports").iterdir()}, {"log.txt"})
        self.assertIn(reason, self.summary.read_text())

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
    def runs(self):
        return [line for line in self.docker if line.startswith("run ")]

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
        self.assertEqual(self.use(broken=True), 1, self.log)
        self.assertEqual(self.docker, ["info"])

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


class Script(unittest.TestCase):
    def test_every_variable_is_given(self):
        script = (ROOT / "docker/ci/action.sh").read_text()
        (step,) = ACTION["runs"]["steps"]
        self.assertEqual(set(re.findall(r"\b(?:INPUT|ACTION)_[A-Z\d]+\b", script)) | {"MESHGAUGE_KEY"}, set(step["env"]))
        used = {found for value in step["env"].values() for found in EXPRESSION.findall(value)}
        self.assertLessEqual({f"inputs.{name}" for name in ACTION["inputs"]}, used)
        self.assertNotIn("${{", step["run"])
