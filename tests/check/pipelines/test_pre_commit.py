"""The hook of pre-commit, run by pre-commit with the configuration of docs/ci.md."""

import pathlib
import shutil
import subprocess
import tempfile
import unittest

import yaml
from harness import ROOT
from manual import MANUAL, box, files, repository, tools


@unittest.skipUnless(shutil.which("pre-commit"), "no pre-commit (./dev setup test)")
class PreCommit(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.top = pathlib.Path(folder.name)
        self.environment = tools(self.top)
        self.hooks = self.top / "meshgauge"
        self.hooks.mkdir()
        shutil.copy(ROOT / ".pre-commit-hooks.yaml", self.hooks)
        self.git(self.hooks, "init", "-q")
        self.git(self.hooks, "add", "-A")
        self.git(self.hooks, "commit", "-qm", "hooks")

    def git(self, folder, *arguments):
        return self.run_in(folder, "git", *arguments, wanted=0)

    def run_in(self, folder, *command, wanted):
        done = subprocess.run(command, cwd=folder, env=self.environment, text=True, capture_output=True, check=False,
                              timeout=200)
        self.assertEqual(done.returncode, wanted, f"{command}:\n{done.stdout}{done.stderr}")
        return done.stdout

    def commit(self, hook):
        """A repository with the hook installed, and its first commit."""
        folder = repository(self.top / "repository")
        config = yaml.safe_load(files(MANUAL)[".pre-commit-config.yaml"])
        (entry,) = config["repos"]
        self.assertEqual([h["id"] for h in entry["hooks"]], ["meshgauge"])
        entry.update(repo=str(self.hooks), rev=self.git(self.hooks, "rev-parse", "HEAD").strip(), hooks=[{"id": hook}])
        (folder / ".pre-commit-config.yaml").write_text(yaml.safe_dump(config))
        self.git(folder, "init", "-q")
        self.run_in(folder, "pre-commit", "install", wanted=0)
        self.git(folder, "add", "-A")
        self.git(folder, "commit", "-qm", "parts")
        return folder

    def test_a_broken_part_is_not_committed(self):
        folder = self.commit("meshgauge")
        (folder / "parts/bracket.off").write_text(box(hole=True))
        done = subprocess.run(["git", "commit", "-qam", "worse"], cwd=folder, env=self.environment, text=True,
                              capture_output=True, check=False)
        self.assertEqual(done.returncode, 1)
        self.assertIn("FAIL  bracket", done.stdout + done.stderr)
        self.assertNotIn("plate", done.stdout + done.stderr)

    def test_other_files_run_nothing(self):
        folder = self.commit("meshgauge")
        (folder / "parts/bracket.off").write_text(box(hole=True))
        (folder / "notes.txt").write_text("no mesh\n")
        self.git(folder, "add", "notes.txt")
        self.git(folder, "commit", "-qm", "notes")

    def test_the_image(self):
        config = {hook["id"]: hook for hook in yaml.safe_load((self.hooks / ".pre-commit-hooks.yaml").read_text())}
        hook = config["meshgauge-docker"]
        self.assertEqual(hook["language"], "docker_image")
        # pre-commit puts `docker run --rm ... ` before the entry.
        folder = repository(self.top / "repository", broken=True)
        self.run_in(folder, "docker", "run", "--rm", *hook["entry"].split(), *hook["args"], wanted=1)
