"""One place holds the repository's name, and one the version: what other files show of them is the same."""

import json
import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
NAME = (ROOT / "packaging/repository").read_text().strip()
VERSION = re.search(r"project\(meshgauge VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text())[1]
INSTALL = (ROOT / "README.md").read_text().split("## Install\n")[1].split("\n## ")[0]
SHOWN = [ROOT / name for name in ("README.md", "docs/ci.md", "docs/install.md", "docs/packaging.md", "docker/ci/gitlab.yml", "action.yml",
                                  "check/gates.schema.json", ".pre-commit-hooks.yaml")]


class Names(unittest.TestCase):
    def test_the_debian_package_has_the_version_of_the_project(self):
        first = (ROOT / "packaging/debian/changelog").read_text().splitlines()[0]
        self.assertRegex(first, rf"^meshgauge \({re.escape(VERSION)}-\d+\) ")

    def test_the_repository_is_the_same_everywhere(self):
        for file in SHOWN:
            for found in re.findall(r"(?:uses: |github\.com/|raw\.githubusercontent\.com/|--repo |ghcr\.io/)([\w.-]+/[\w.-]+?)(?=[@/:`\s)]|$)", file.read_text()):
                if "meshgauge" in found.lower():
                    self.assertIn(found, (NAME, NAME.lower()), file.name)
        self.assertIn(f"github.com/{NAME}/", INSTALL)

    def test_versions_are_those_of_the_project(self):
        for file in SHOWN:
            text = file.read_text()
            for found in re.findall(r"(?:meshgauge[-_:]|download/v|MESHGAUGE_VERSION: |rev: v)(\d+\.\d+\.\d+)", text):
                self.assertEqual(found, VERSION, file.name)

    def test_pipelines_name_the_tag_of_the_project_that_moves(self):
        major = "v" + VERSION.split(".")[0]
        named = [found for file in SHOWN for found in re.findall(rf"{re.escape(NAME)}(?:@|/)(v\d[\d.]*)(?=[/\s`}}\"])", file.read_text())]
        self.assertGreaterEqual(len(named), 5)
        self.assertEqual(set(named), {major})

    def test_the_schema_of_manifests_is_where_its_id_says(self):
        schema = json.loads((ROOT / "check/gates.schema.json").read_text())
        tree, _, file = schema["$id"].partition("/check/")
        self.assertEqual(tree, f"https://raw.githubusercontent.com/{NAME}/v{VERSION.split('.')[0]}")
        self.assertTrue((ROOT / "check" / file).is_file())
        self.assertIn(f"\n# yaml-language-server: $schema={schema['$id']}\n", (ROOT / "docs/ci.md").read_text())

    def test_packages_have_the_schema_of_manifests(self):
        for file in ("packaging/package", "packaging/debian/rules", "python/wheel.py", "cmake/install.cmake"):
            self.assertIn("check/gates.schema.json", (ROOT / file).read_text(), file)

    @unittest.skipUnless(shutil.which("git") and (ROOT / ".git").exists(), "no repository of git")
    def test_another_name_reaches_every_file(self):
        owner = NAME.split("/")[0]
        names = subprocess.run(["git", "grep", "-lIi", "-e", f"{owner}/"], cwd=ROOT, text=True, capture_output=True, check=True).stdout.split()
        self.assertLessEqual({str(file.relative_to(ROOT)) for file in SHOWN}, set(names))
        with tempfile.TemporaryDirectory() as folder:
            top = pathlib.Path(folder)
            for name in {*names, "packaging/rename"}:
                (top / name).parent.mkdir(parents=True, exist_ok=True)
                shutil.copy(ROOT / name, top / name)
            subprocess.run([top / "packaging/rename", "Some.One/meshes"], check=True)
            subprocess.run([top / "packaging/rename", "Another/Parts"], check=True)
            self.assertIn("ghcr.io/another/parts:", (top / "docs/install.md").read_text())
            self.assertFalse([name for name in names if "ome.one/" in (top / name).read_text().lower()])
            subprocess.run([top / "packaging/rename", "Some.One/meshes"], check=True)
            self.assertEqual((top / "packaging/repository").read_text(), "Some.One/meshes\n")
            self.assertIn("https://github.com/Some.One/meshes/releases/download", (top / "docker/ci/gitlab.yml").read_text())
            self.assertIn("ghcr.io/some.one/meshes:", (top / "README.md").read_text())
            for name in names:
                text = (top / name).read_text()
                left = re.findall(rf"\b{re.escape(owner)}/(?!NAME\b)\S*|{re.escape(NAME.lower())}", text)
                self.assertEqual(left, [], name)

    def test_four_ways_in_eight_lines(self):
        lines = re.search(r"^```sh\n(.*?)^```$", INSTALL, re.M | re.S)[1].splitlines()
        self.assertLessEqual(len(lines), 8)
        for way in ("pip install", "tar -xz", "apt-get install", "docker run"):
            self.assertEqual(sum(way in line for line in lines), 1, way)


@unittest.skipUnless(shutil.which("git"), "no git")
class MovingTags(unittest.TestCase):
    """packaging/move_tags, as the release runs it, on a repository of this machine."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.top = pathlib.Path(folder.name)
        self.environment = {"PATH": os.environ["PATH"], "HOME": folder.name, "GIT_CONFIG_NOSYSTEM": "1", "GIT_AUTHOR_NAME": "t",
                            "GIT_AUTHOR_EMAIL": "t@example.com", "GIT_COMMITTER_NAME": "t", "GIT_COMMITTER_EMAIL": "t@example.com"}
        self.git("init", "-q", "--bare", "remote", folder=self.top)
        self.git("clone", "-q", "remote", "clone", folder=self.top)

    def git(self, *words, folder=None):
        return subprocess.run(["git", *words], cwd=folder or self.top / "clone", env=self.environment, text=True, check=True,
                              stdout=subprocess.PIPE, stderr=subprocess.DEVNULL).stdout.strip()

    def release(self, version, *how):
        """A commit with this tag, after which the release moves the others. Returns the commit."""
        self.git("commit", "-q", "--allow-empty", "-m", version)
        self.git("tag", *how, f"v{version}")
        self.git("push", "-q", "origin", f"v{version}")
        subprocess.run([ROOT / "packaging/move_tags", f"v{version}"], cwd=self.top / "clone", env=self.environment, check=True,
                       stdout=subprocess.DEVNULL)
        return self.git("rev-parse", "HEAD")

    def at(self, tag):
        return self.git("ls-remote", "origin", f"refs/tags/{tag}").split("\t")[0]

    def test_they_follow_the_highest_release(self):
        first = self.release("0.2.0")
        self.assertEqual((self.at("v0"), self.at("v0.2")), (first, first))
        newer = self.release("0.10.0", "-a", "-m", "annotated")
        self.assertEqual((self.at("v0"), self.at("v0.10"), self.at("v0.2")), (newer, newer, first))
        patch = self.release("0.2.1")
        self.assertEqual((self.at("v0"), self.at("v0.2")), (newer, patch))
        self.release("1.0.0")
        self.assertEqual(self.at("v0"), newer)

    def test_what_is_no_release_moves_nothing(self):
        self.release("0.2.0")
        for tag in ("v0.2", "0.2.0", "v0.2.0-rc1", "v9.9.9", ""):
            done = subprocess.run([ROOT / "packaging/move_tags", tag], cwd=self.top / "clone", env=self.environment, check=False,
                                  capture_output=True)
            self.assertNotEqual(done.returncode, 0, tag)

    def test_the_release_moves_them_after_it_is_published(self):
        steps = (ROOT / ".github/workflows/release.yml").read_text()
        self.assertLess(steps.index("gh release create"), steps.index("packaging/move_tags"))


if __name__ == "__main__":
    unittest.main()
