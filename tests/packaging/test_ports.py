"""The ports for vcpkg and Conan ask the project for what it has. (vcpkg and conan themselves are no packages of Debian.)"""

import ast
import json
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
PORT = (ROOT / "packaging/vcpkg/meshgauge/portfile.cmake").read_text()
RECIPE = (ROOT / "packaging/conan/conanfile.py").read_text()
MANIFEST = json.loads((ROOT / "packaging/vcpkg/meshgauge/vcpkg.json").read_text())


class Ports(unittest.TestCase):
    def configure(self, source, options):
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run(["cmake", "-S", source, "-B", folder, "-G", "Ninja", "-Werror=unused-cli", *options],
                                  text=True, capture_output=True, check=False, timeout=200)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertNotIn("not used by the project", done.stderr)
            return (pathlib.Path(folder) / "cmake_install.cmake").read_text()

    def test_the_options_of_vcpkg(self):
        options = re.search(r"OPTIONS (.*)\)", PORT)[1].split()
        self.assertIn("cmake/meshgauge", self.configure(ROOT, options))
        self.assertIn("CONFIG_PATH lib/cmake/meshgauge", PORT)
        self.assertEqual(MANIFEST["version-semver"], re.search(r"meshgauge VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text())[1])

    def test_conan_exports_what_a_build_of_the_engine_reads(self):
        patterns = next(node for node in ast.walk(ast.parse(RECIPE)) if isinstance(node, ast.For) and "pattern" in ast.unparse(node.target))
        with tempfile.TemporaryDirectory() as folder:
            top = pathlib.Path(folder)
            for pattern in ast.literal_eval(patterns.iter):
                for file in ROOT.glob(pattern) if "*" in pattern else [ROOT / pattern]:
                    place = top / file.relative_to(ROOT)
                    if file.is_dir():
                        shutil.copytree(file, place, dirs_exist_ok=True)
                    else:
                        place.parent.mkdir(parents=True, exist_ok=True)
                        shutil.copy(file, place)
            options = [f"-D{name}=OFF" for name in re.findall(r'"(MESHGAUGE_\w+)"', RECIPE)]
            self.assertEqual(len(options), 3)
            self.assertIn("engine", self.configure(top, options))


if __name__ == "__main__":
    unittest.main()
