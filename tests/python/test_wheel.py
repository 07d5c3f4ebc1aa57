"""The wheel: its size, its platform, the same bytes twice, and an installation in a virtual environment."""

import importlib.util
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest
import zipfile

import shapes

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = pathlib.Path(os.environ["MESHGAUGE_BINARY"]).parent


def has(module):
    return importlib.util.find_spec(module) is not None


@unittest.skipUnless(has("wheel") and has("venv"), "needs python3-wheel and python3-venv")
class Wheel(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)
        library = cls.folder / "libmeshgauge.so"
        subprocess.run(["strip", "-o", library, BUILD / "python/meshgauge/libmeshgauge.so"], check=True)
        for name in ("licenses.txt", "sbom.cdx.json"):
            (cls.folder / name).write_text(f"the text of {name}")
        cls.wheels = [cls.build(cls.folder / name, library) for name in ("one", "two")]

    @classmethod
    def build(cls, out, library):
        environment = {**os.environ, "SOURCE_DATE_EPOCH": "1700000000"}
        subprocess.run([ROOT / "python/build.sh", out, library], check=True, capture_output=True, env=environment)
        return next(out.glob("*.whl"))

    def test_size_and_bytes(self):
        one, two = (wheel.read_bytes() for wheel in self.wheels)
        self.assertEqual(one, two)
        self.assertLessEqual(len(one), 8_000_000)

    def test_names_and_modes(self):
        self.assertRegex(self.wheels[0].name, r"^meshgauge-\d+\.\d+\.\d+-py3-none-(manylinux_2_\d+|linux)_(x86_64|aarch64)\.whl$")
        with zipfile.ZipFile(self.wheels[0]) as archive:
            names = set(archive.namelist())
            self.assertTrue({"meshgauge/py.typed", "meshgauge/libmeshgauge.so", "meshgauge/__init__.py"} <= names)
            self.assertEqual(archive.read("meshgauge/gates.schema.json"), (ROOT / "check/gates.schema.json").read_bytes())
            for place, name in (("licenses.txt", "licenses.txt"), ("sboms/meshgauge.cdx.json", "sbom.cdx.json")):
                found = next(one for one in names if one.endswith(f".dist-info/{place}"))
                self.assertEqual(archive.read(found).decode(), f"the text of {name}")
            self.assertFalse([name for name in names if "__pycache__" in name])
            self.assertEqual(archive.getinfo("meshgauge/libmeshgauge.so").external_attr >> 16 & 0o777, 0o755)
            self.assertEqual(archive.getinfo("meshgauge/__init__.py").external_attr >> 16 & 0o777, 0o644)

    def test_an_installation(self):
        """pip installs it; command, library and plugin work there."""
        place = self.folder / "venv"
        pip = ["--without-pip"] if has("pip") else []  # the system's is there, too, and one of its own takes long to install
        subprocess.run([sys.executable, "-m", "venv", "--system-site-packages", *pip, place], check=True)
        python = place / "bin/python"
        install = [python, "-m", "pip", "install", "-q", "--no-index", "--no-deps", "--disable-pip-version-check", self.wheels[0]]
        environment = {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "LD_PRELOAD")}
        subprocess.run(install, check=True, env=environment)

        def run(*command):
            done = subprocess.run(command, cwd=self.folder, env=environment, capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, done.stderr)
            return done.stdout

        version = run(place / "bin/meshgauge", "--version")
        self.assertRegex(version, r"^meshgauge \d+\.\d+\.\d+$")
        (self.folder / "a.obj").write_bytes(shapes.obj(shapes.box(1)))
        (self.folder / "b.obj").write_bytes(shapes.obj(shapes.box(1.01)))
        (self.folder / "gates.yaml").write_text(
            "version: 1\ngates:\n  - {name: box, candidate: a.obj, baseline: b.obj, max_distance: 0.05}\n")
        self.assertIn("1 pass", run(place / "bin/meshgauge", "check", "gates.yaml"))
        source = "import meshgauge; print(meshgauge.__file__, meshgauge.compare('a.obj', 'b.obj', 0.05).verdict)"
        self.assertRegex(run(python, "-c", source), re.escape(str(place)) + r"\S+ pass\n")
        if has("pytest"):
            (self.folder / "test_it.py").write_text(
                "def test_it(assert_mesh_close):\n    assert assert_mesh_close('a.obj', 'b.obj', 0.05).verdict == 'pass'\n")
            self.assertIn("1 passed", run(python, "-m", "pytest", "-q", "-p", "no:cacheprovider", "test_it.py"))


if __name__ == "__main__":
    unittest.main()
