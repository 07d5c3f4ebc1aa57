"""One place holds the repository's name, and one the version: what other files show of them is the same."""

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
SHOWN = [ROOT / name for name in ("README.md", "docs/ci.md", "docs/install.md", "docs/packaging.md", "docker/ci/gitlab.yml", "action.yml")]


class Names(unittest.TestCase):
    def test_the_debian_package_has_the_version_of_the_project(self):
        first = (ROOT / "packaging/debian/changelog").read_text().splitlines()[0]
        self.assertRegex(first, rf"^meshgauge \({re.escape(VERSION)}-\d+\) ")

    def test_the_repository_is_the_same_everywhere(self):
        for file in SHOWN:
            for found in re.findall(r"(?:uses: |github\.com/|--repo |ghcr\.io/)([\w.-]+/[\w.-]+?)(?=[@/:`\s)]|$)", file.read_text()):
                if "meshgauge" in found.lower():
                    self.assertIn(found, (NAME, NAME.lower()), file.name)
        self.assertIn(f"github.com/{NAME}/", INSTALL)

    def test_versions_are_those_of_the_project(self):
        for file in SHOWN:
            text = file.read_text()
            for found in re.findall(r"(?:meshgauge[-_]|download/v|MESHGAUGE_VERSION: )(\d+\.\d+\.\d+)", text):
                self.assertEqual(found, VERSION, file.name)

    def test_another_name_reaches_every_file(self):
        with tempfile.TemporaryDirectory() as folder:
            top = pathlib.Path(folder)
            for file in [*SHOWN, ROOT / "packaging/repository", ROOT / "packaging/rename"]:
                place = top / file.relative_to(ROOT)
                place.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy(file, place)
            subprocess.run([top / "packaging/rename", "Some.One/meshes"], check=True)
            self.assertEqual((top / "packaging/repository").read_text(), "Some.One/meshes\n")
            self.assertIn("https://github.com/Some.One/meshes/releases/download", (top / "docker/ci/gitlab.yml").read_text())
            for file in top.rglob("*.*"):
                if file.is_file():
                    self.assertNotIn(NAME, file.read_text(), file.name)

    def test_four_ways_in_eight_lines(self):
        lines = re.search(r"^```sh\n(.*?)^```$", INSTALL, re.M | re.S)[1].splitlines()
        self.assertLessEqual(len(lines), 8)
        for way in ("pip install", "tar -xz", "apt-get install", "docker run"):
            self.assertEqual(sum(way in line for line in lines), 1, way)


if __name__ == "__main__":
    unittest.main()
