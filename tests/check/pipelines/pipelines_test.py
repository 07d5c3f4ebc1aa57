#!/usr/bin/env python3
"""Reports for pipelines, held against the schemas of the programs that read them; and GitLab's pipeline, run. Schemas come by npm."""

import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

import jsonschema
import yaml

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "reports"))
import npm_tools
from harness import ROOT
from manual import MANUAL, PIPELINE, REPOSITORY, Releases, all_of, files, repository, tools

GITLAB_SCHEMA = "gitlab.com/gitlab-org/gitlab/-/raw/master/app/assets/javascripts/editor/schema/ci.json"
WORKFLOW = ".github/workflows/meshes.yml"


class Yaml(yaml.CSafeLoader):
    """Booleans are true and false alone, so that GitHub's key `on` is a name."""


Yaml.yaml_implicit_resolvers = {
    first: [(tag, pattern) for tag, pattern in resolvers if tag != "tag:yaml.org,2002:bool"]
    for first, resolvers in yaml.SafeLoader.yaml_implicit_resolvers.items()}
Yaml.add_implicit_resolver("tag:yaml.org,2002:bool", re.compile(r"^(true|false)$"), list("tf"))


def problems(schema, text):
    rules = json.loads((MODULES / "schemastore/schemas/json" / schema).read_text())
    validator = jsonschema.Draft7Validator(rules)
    return [f"{list(e.path)}: {e.message}" for e in validator.iter_errors(yaml.load(text, Yaml))]


class Schemas(unittest.TestCase):
    shown = {
        "github-action.json": (ROOT / "action.yml").read_text(),
        "github-workflow.json": files(MANUAL)[WORKFLOW],
        # A job whose name begins with a dot is for others to extend, and may hold anything.
        GITLAB_SCHEMA: (ROOT / "docker/ci/gitlab.yml").read_text().replace("\n.meshgauge:", "\nmeshgauge:"),
        "pre-commit-hooks.json": (ROOT / ".pre-commit-hooks.yaml").read_text(),
        "pre-commit-config.json": files(MANUAL)[".pre-commit-config.yaml"],
    }

    def test_valid(self):
        for schema, text in self.shown.items():
            with self.subTest(schema=schema):
                self.assertEqual(problems(schema, text), [])
        for page in (MANUAL, PIPELINE):
            for text in all_of(page, WORKFLOW):
                self.assertEqual(problems("github-workflow.json", text), [])
        # The schema is older than GitHub's attestations.
        release = (ROOT / ".github/workflows/release.yml").read_text().replace("      attestations: write\n", "")
        self.assertEqual(problems("github-workflow.json", release), [])
        for name in (".gitlab-ci.yml", "meshes.gitlab-ci.yml"):
            self.assertEqual(problems(GITLAB_SCHEMA, files(MANUAL)[name]), [])

    def test_the_schemas_refuse(self):
        worse = {"github-action.json": ("using: composite", "using: compost"), "github-workflow.json": ("runs-on:", "run-on:"),
                 GITLAB_SCHEMA: ("when: always", "when: sometimes"), "pre-commit-hooks.json": ("  language: system\n", ""),
                 "pre-commit-config.json": ("repos:", "repositories:")}
        for schema, (right, wrong) in worse.items():
            with self.subTest(schema=schema):
                self.assertIn(right, self.shown[schema])
                self.assertTrue(problems(schema, self.shown[schema].replace(right, wrong)))

    def test_the_workflow_gives_what_the_action_takes(self):
        action = yaml.safe_load((ROOT / "action.yml").read_text())
        workflows = [*all_of(MANUAL, WORKFLOW), *all_of(PIPELINE, WORKFLOW)]
        self.assertEqual(len(workflows), 3)
        for text in workflows:
            workflow = yaml.load(text, Yaml)
            self.assertEqual(workflow["permissions"]["pull-requests"], "write")
            steps = [step for job in workflow["jobs"].values() for step in job["steps"]]
            (step,) = [step for step in steps if step["uses"].endswith("/meshgauge@v0")]
            self.assertLessEqual(set(step.get("with", {})), set(action["inputs"]))


class GitLab(unittest.TestCase):
    """gitlab-ci-local runs the job of docs/ci.md in a shell, with the built program as the release's."""

    def pipeline(self, broken, sha256=None):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        top = pathlib.Path(folder.name)
        environment = {**tools(top), "CI": "", "FORCE_COLOR": "0"}
        place = repository(top / "repository", broken)
        config = yaml.safe_load(files(MANUAL)[".gitlab-ci.yml"])
        (included,) = config["include"]
        place_of_template = re.fullmatch(rf"https://raw\.githubusercontent\.com/{REPOSITORY}/v0/(\S+)", included["remote"])[1]
        template = ROOT / place_of_template
        releases = Releases(top)
        self.addCleanup(releases.close)
        config["meshes"]["variables"] |= {"MESHGAUGE_RELEASES": releases.url, "MESHGAUGE_SHA256": sha256 or releases.sha256}
        config["include"] = [{"local": place_of_template}]
        (place / place_of_template).parent.mkdir(parents=True)
        (place / place_of_template).write_text(template.read_text())
        (place / ".gitlab-ci.yml").write_text(yaml.safe_dump(config))
        for command in (("init", "-q"), ("remote", "add", "origin", "git@gitlab.example:owner/parts.git"), ("add", "-A"),
                        ("commit", "-qm", "parts")):
            subprocess.run(["git", *command], cwd=place, env=environment, check=True)
        done = subprocess.run([MODULES / ".bin/gitlab-ci-local", "--force-shell-executor", "--home", top, "meshes"], cwd=place,
                              env=environment, text=True, capture_output=True, check=False, timeout=200)
        return done, place

    def test_a_hole_makes_it_red(self):
        done, place = self.pipeline(broken=True)
        self.assertRegex(done.stderr, r"meshes .*finished in .* FAIL 1\b", done.stdout)
        self.assertIn("FAIL  bracket", done.stdout)
        (finding,) = json.loads((place / "meshgauge-reports/code-quality.json").read_text())
        self.assertEqual(finding["location"]["path"], "gates.yaml")
        self.assertIn('<failure message="the distance is at least', (place / "meshgauge-reports/junit.xml").read_text())

    def test_three_parts_as_they_should_be(self):
        done, place = self.pipeline(broken=False)
        self.assertRegex(done.stdout, r" PASS +meshes", done.stderr)
        self.assertEqual(json.loads((place / "meshgauge-reports/code-quality.json").read_text()), [])

    def test_another_archive_than_was_meant(self):
        done, place = self.pipeline(broken=False, sha256="1" * 64)
        self.assertRegex(done.stderr, r"meshes .*finished in .* FAIL 1\b", done.stdout)
        self.assertFalse((place / "meshgauge-reports").exists())

    def test_artefacts_are_what_is_written(self):
        job = yaml.safe_load((ROOT / "docker/ci/gitlab.yml").read_text())[".meshgauge"]
        for path in job["artifacts"]["reports"].values():
            self.assertIn(path, " ".join(job["script"]))


if __name__ == "__main__":
    MODULES = npm_tools.installed(os.environ["MESHGAUGE_CHECK_TOOLS"])
    if not MODULES:
        print("SKIP: no npm, which brings the schemas")
        sys.exit(77)
    unittest.main(verbosity=2)
