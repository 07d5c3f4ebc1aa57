#!/usr/bin/python3
"""Deviation maps as another program reads them: every number that it keeps is the one that was written.

usage: readers_test.py READER DEVIATION_FILES FOLDER

FOLDER holds the program read_by_assimp, and what is made here. Exit code 77: READER is not there.
"""
import json
import pathlib
import shutil
import struct
import subprocess
import sys
import unittest

HERE = pathlib.Path(__file__).parent
THREE = "three@0.185.1"
SKIPPED = 77
CASES = ("egg", "far", "grid")  # of make_files.cpp


def to_linear(byte):
    c = byte / 255
    return c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4


def single(x):
    return struct.unpack("<f", struct.pack("<f", x))[0]


def run(*command):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise AssertionError(f"{command[0]}: {done.stdout[-2000:]}{done.stderr[-2000:]}")
    return done.stdout


def has_module(name):
    """The Python that has the module, or None."""
    probe = subprocess.run([sys.executable, "-c", "import " + name], capture_output=True, check=False)
    return sys.executable if probe.returncode == 0 else None


class Reader:
    """How a program is asked, and what it keeps of each format."""
    formats = (".ply", ".glb")
    positions = staticmethod(single)           # of a PLY
    scalars = (".ply", ".glb")                 # of which it keeps `quality`, `_DISTANCE`
    tree = True                                # of a GLB: names of nodes, where they are, extras

    most_wrong = 2e-7                          # of a coordinate of a GLB

    def __init__(self, folder):
        self.folder = folder

    def program(self):
        return shutil.which(self.name)

    def kept(self, byte):
        """What it makes of a colour of a PLY."""
        return byte

    def colours(self, rows, suffix):
        """The colours as bytes of sRGB, or of a GLB as 16 bits of linear light."""
        most = 65535 if suffix == ".glb" else 255
        return [[round(value * most) for value in row] for row in rows]


class Meshio(Reader):
    """meshio takes an unsigned byte as a signed one."""
    formats = (".ply",)
    positions = staticmethod(float)

    def program(self):
        return has_module("meshio")

    def read(self, path):
        import meshio
        mesh = meshio.read(path)
        data = mesh.point_data
        return {"positions": mesh.points.tolist(), "triangles": mesh.cells_dict["triangle"].tolist(),
                "distance": data["distance"].tolist(), "quality": data["quality"].tolist(),
                "colours": [list(row) for row in zip(*(data[name].tolist() for name in ("red", "green", "blue")))]}

    def colours(self, rows, suffix):
        return [[byte % 256 for byte in row] for row in rows]


class Assimp(Reader):
    positions = staticmethod(single)
    scalars = ()
    tree = False

    def program(self):
        return shutil.which(self.folder / "read_by_assimp")

    def read(self, path):
        return json.loads(run(self.program(), path))


class Blender(Reader):
    name = "blender"
    scalars = ()  # before version 4

    def read(self, path):
        out = path.with_suffix(path.suffix + ".blender.json")
        run(self.program(), "--background", "--factory-startup", "--python-exit-code", "1", "--python",
            HERE / "read_by_blender.py", "--", path, out)
        return json.loads(out.read_text())


class Meshlab(Reader):
    """MeshLab reads a PLY and writes it again: its own file shows what it kept."""
    name = "meshlabserver"
    formats = (".ply",)

    def program(self):
        return super().program() if shutil.which("xvfb-run") else None

    def read(self, path):
        out = path.with_suffix(".meshlab.ply")
        run("xvfb-run", "-a", self.program(), "-i", path, "-o", out, "-m", "vc", "vq")
        return self.parse(out.read_bytes())

    @staticmethod
    def parse(data):
        head, _, body = data.partition(b"end_header\n")
        lines = head.decode().splitlines()
        counts = [int(line.split()[2]) for line in lines if line.startswith("element")]
        names = [line.split()[2] for line in lines if line.startswith("property") and "list" not in line]
        kinds = [line.split()[1] for line in lines if line.startswith("property") and "list" not in line]
        form = struct.Struct("<" + "".join({"float": "f", "double": "d", "uchar": "B"}[kind] for kind in kinds))
        rows = [dict(zip(names, form.unpack_from(body, i * form.size))) for i in range(counts[0])]
        face = struct.Struct("<B3i")
        faces = [face.unpack_from(body, counts[0] * form.size + i * face.size)[1:] for i in range(counts[1])]
        return {"positions": [[row[axis] for axis in "xyz"] for row in rows],
                "colours": [[row["red"], row["green"], row["blue"]] for row in rows],
                "quality": [row["quality"] for row in rows], "triangles": [list(face) for face in faces]}

    def colours(self, rows, suffix):
        return rows


class Three(Reader):
    """three.js takes the bytes of a PLY as sRGB and turns them into bytes of linear light."""
    name = "node"
    positions = staticmethod(float)

    def program(self):
        return super().program() if shutil.which("npm") else None

    def kept(self, byte):
        return round(255 * to_linear(byte))

    def read(self, path):
        modules = self.folder / "npm"
        if not (modules / THREE).exists():
            run("npm", "install", "--loglevel=error", "--no-fund", "--no-audit", "--prefix", modules, THREE)
            (modules / THREE).touch()
        return json.loads(run(self.program(), HERE / "read_by_three.mjs", modules / "node_modules", path))


class Vtk(Reader):
    """What ParaView reads a GLB by; its reader of PLY knows no scalars. It places what it reads, in single precision."""
    formats = (".glb",)
    tree = False
    most_wrong = 0.2  # 3e6 away

    def program(self):
        return has_module("vtkmodules.vtkIOGeometry")

    def read(self, path):
        return json.loads(run(self.program(), HERE / "read_by_vtk.py", path))


READERS = {"meshio": Meshio, "assimp": Assimp, "blender": Blender, "meshlab": Meshlab, "three": Three, "vtk": Vtk}


class Maps(unittest.TestCase):
    reader = None
    maps = None

    def test_all_that_the_reader_keeps_is_what_was_written(self):
        for case in CASES:
            wanted = json.loads((self.maps / (case + ".json")).read_text())
            for suffix in self.reader.formats:
                with self.subTest(case + suffix):
                    self.check(wanted, self.reader.read(self.maps / (case + suffix)), suffix)

    def check(self, wanted, found, suffix):
        self.assertEqual(len(found["positions"]), len(wanted["positions"]))
        found = self.as_numbered(wanted, found)
        self.check_positions(wanted, found, suffix)
        self.check_colours(wanted, found, suffix)
        self.check_scalars(wanted, found, suffix)
        if suffix == ".glb" and self.reader.tree:
            self.assertEqual(found["nodes"], ["candidate", "witness"])
            self.assertEqual(found["extras"]["limit"], wanted["limit"])
            self.assertEqual(found["extras"]["units"], "mm")

    def as_numbered(self, wanted, found):
        """What was found by the numbers of the vertices that were wanted: a reader may number them anew."""
        numbers = {}
        self.assertEqual(len(found["triangles"]), len(wanted["triangles"]))
        for i, (one, other) in enumerate(zip(found["triangles"], wanted["triangles"])):
            self.assertEqual([numbers.setdefault(a, b) for a, b in zip(one, other)], other, f"triangle {i}")
        self.assertEqual(sorted(numbers.values()), list(range(len(found["positions"]))))
        order = sorted(numbers, key=numbers.get)
        return found | {name: [values[i] for i in order] for name, values in found.items()
                        if name in ("positions", "colours", "quality", "distance")}

    def same(self, found, wanted, what):
        """Like assertEqual, which takes minutes to describe how long lists differ."""
        self.assertEqual(len(found), len(wanted), what)
        for i, (one, other) in enumerate(zip(found, wanted)):
            self.assertEqual(one, other, f"{what} {i}")

    def check_positions(self, wanted, found, suffix):
        if suffix == ".ply":
            keeps = self.reader.positions
            self.same(found["positions"], [[keeps(x) for x in p] for p in wanted["positions"]], "position")
            return
        place = found.get("place", [0, 0, 0])
        worst = max(abs(x + o - w) for p, q in zip(found["positions"], wanted["positions"])
                    for x, o, w in zip(p, place, q))
        self.assertLess(worst, self.reader.most_wrong)

    def check_colours(self, wanted, found, suffix):
        colours = self.reader.colours(found["colours"], suffix)
        if suffix == ".ply":
            self.same(colours, [[self.reader.kept(b) for b in c] for c in wanted["colours"]], "colour")
            return
        worst = max(abs(c - round(65535 * to_linear(b))) for p, q in zip(colours, wanted["colours"]) for c, b in zip(p, q))
        self.assertLessEqual(worst, 1)

    def check_scalars(self, wanted, found, suffix):
        if suffix in self.reader.scalars:
            self.assertIn("quality", found)
        if "quality" in found:
            self.same(found["quality"], [single(d) for d in wanted["distance"]], "quality")
        if "distance" in found:
            self.same(found["distance"], wanted["distance"], "distance")


def main():
    name, make, folder = sys.argv[1], sys.argv[2], pathlib.Path(sys.argv[3])
    Maps.reader = READERS[name](folder)
    if not Maps.reader.program():
        print(f"SKIPPED: {name} is not installed")
        return SKIPPED
    Maps.maps = folder / name
    run(make, Maps.maps)
    result = unittest.TextTestRunner(verbosity=2).run(unittest.defaultTestLoader.loadTestsFromTestCase(Maps))
    return 0 if result.wasSuccessful() else 1


if __name__ == "__main__":
    sys.exit(main())
