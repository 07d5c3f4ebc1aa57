"""Pairs of mesh files: of a corpus, of any folder, and made here."""
import dataclasses
import hashlib
import pathlib
import subprocess
import sys

from . import meshes

SUFFIXES = (".obj", ".stl", ".ply", ".off", ".gltf", ".glb", ".gz")


@dataclasses.dataclass(frozen=True)
class Pair:
    name: str
    kind: str
    a: pathlib.Path
    b: pathlib.Path
    at: float = 0.0  # where it lies in a series: displacement, triangles
    reference: tuple = None  # (lower, upper) that hold h(A,B), when known


_hashes = {}


def content_hash(path):
    """A hash of the file's bytes. Reading them also brings them into memory before anything is timed."""
    if path not in _hashes:
        _hashes[path] = hashlib.sha256(path.read_bytes()).hexdigest()[:16]
    return _hashes[path]


def _rows(path):
    if not path.exists():
        return []
    return [line.split("\t") for line in path.read_text().splitlines() if line and not line.startswith("#")]


class Listed:
    """The pairs of FOLDER/pairs.tsv (name, A, B, kind, ...), with what FOLDER/reference.tsv knows of them."""

    def __init__(self, folder, made):
        self.folder, self.made = folder, made
        self.rows = _rows(folder / "pairs.tsv")
        self.references = {row[0]: (float(row[2]), float(row[3])) for row in _rows(folder / "reference.tsv")}

    def pairs(self):
        return [
            Pair(name, kind, self.folder / a, self._second(name, b), _displacement(name), self.references.get(name))
            for name, a, b, kind, *_ in self.rows
        ]

    def _second(self, name, text):
        """`gen:PROGRAM MESH ARGUMENT` is made by FOLDER/scripts/PROGRAM.py, once."""
        if not text.startswith("gen:"):
            return self.folder / text
        program, mesh, argument = text[len("gen:") :].split()
        out = self.made / (name.replace("/", "_") + ".obj")
        if not out.exists():
            out.parent.mkdir(parents=True, exist_ok=True)
            half = out.with_name("half-written." + out.name)
            subprocess.run(
                [sys.executable, self.folder / "scripts" / (program + ".py"), self.folder / mesh, argument, half],
                check=True,
                stdout=subprocess.DEVNULL,
            )
            half.rename(out)
        return out


def _displacement(name):
    _, found, number = name.rpartition("_d")
    try:
        return float(number) if found else 0.0
    except ValueError:
        return 0.0


def in_folder(folder, made):
    """FOLDER with a pairs.tsv, or with one sub-folder a pair that holds two mesh files: A is the first by name."""
    if (folder / "pairs.tsv").exists():
        return Listed(folder, made).pairs()
    found = []
    for sub in sorted(path for path in folder.iterdir() if path.is_dir()):
        files = sorted(path for path in sub.iterdir() if path.name.lower().endswith(SUFFIXES))
        if len(files) == 2:
            found.append(Pair(sub.name, folder.name, *files))
        elif files:
            print(f"bench: {sub} has {len(files)} meshes, not two: left out", file=sys.stderr)
    return found


class Made:
    """Pairs of made meshes, written on first use and kept."""

    def __init__(self, folder, obj_files):
        self.folder, self.obj_files = folder, obj_files

    def _file(self, name, make):
        path = self.folder / name
        if not path.exists():
            meshes.write(make(), path)
        return path

    def torus(self, triangles, other=False, suffix=".ply"):
        """`other`: the one next to it, of another triangulation."""
        return self._file(
            f"torus_{'b' if other else 'a'}_{triangles}{suffix}",
            lambda: meshes.torus(triangles, 0.2, 0.5) if other else meshes.torus(triangles),
        )

    def near(self, triangles):
        return Pair(f"made/near_{triangles}", "near", self.torus(triangles), self.torus(triangles, True), triangles)

    def same(self, triangles):
        mesh = self.torus(triangles)
        return Pair(f"made/same_{triangles}", "same", mesh, mesh, triangles, (0.0, 0.0))

    def retriangulated(self, triangles):
        a = self._file(f"plane_a_{triangles}.ply", lambda: meshes.plane(triangles))
        b = self._file(f"plane_b_{triangles}.ply", lambda: meshes.plane(triangles, True))
        return Pair(f"made/retriangulated_{triangles}", "retriangulated", a, b, triangles, (0.0, 0.0))

    def placed(self, triangles, displacement):
        b = self._file(
            f"torus_{triangles}_moved_{displacement:g}.ply", lambda: meshes.moved(meshes.torus(triangles), displacement)
        )
        return Pair(f"made/torus_d{displacement:g}", "placement", self.torus(triangles), b, displacement)

    def moved(self, name, mesh, displacement):
        """A mesh of a file against itself, displaced."""
        b = mesh
        if displacement:
            b = self._file(
                f"{content_hash(mesh)}_moved_{displacement:g}.obj",
                lambda: meshes.moved(meshes.read_obj(self.obj_files.of(mesh)), displacement),
            )
        return Pair(f"place/{name}_d{displacement:g}", "placement", mesh, b, displacement)

    def resolution(self, triangles_a, triangles_b):
        return Pair(
            f"made/torus_{triangles_a}_of_{triangles_b}",
            "resolution",
            self.torus(triangles_a),
            self.torus(triangles_b, True),
            triangles_a,
        )

    def in_format(self, triangles, suffix):
        return Pair(
            f"made/read{suffix}",
            suffix[1:],
            self.torus(triangles, False, suffix),
            self.torus(triangles, True, suffix),
            triangles,
        )
