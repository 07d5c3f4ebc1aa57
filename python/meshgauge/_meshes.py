"""Meshes as the engine and the service take them: files, their content, arrays, faces of any number of corners."""

from __future__ import annotations

import ctypes
import json
import os
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Optional, Union

from meshgauge import _arrays, _native, _ply
from meshgauge._attributes import Place

if TYPE_CHECKING:
    from meshgauge._packed import Packed


NO_SURFACE = "points, lines, faces of fewer than three corners and joins of strips, left out, since they have no surface"
MERGED = "vertices merged with another at exactly the same position"
NOT_PLACED = "objects outside of the build or the scene, left out"
# Notes that the engine has as well (api/result/notes.cpp), and the member of the result that has their count.
_MEMBERS = {NO_SURFACE: "skipped_primitives", MERGED: "welded_vertices", NOT_PLACED: "unused_objects"}


class Source:
    """One mesh."""

    counts: Mapping[str, int] = {}  # of notes: on what an object holds and is not measured, and how it was taken
    unit: Optional[str] = None  # that an object names

    def to_native(self) -> _native.Mesh:
        raise NotImplementedError

    def to_file(self) -> bytes:
        raise NotImplementedError


class Arrays(Source):
    """A mesh in arrays of numpy: C-contiguous float64 (n, 3) and uint32 (m, 3). Copies only what has another layout. No
    triangles: a point cloud."""

    def __init__(self, vertices: Any, triangles: Any, part: str) -> None:
        self.vertices = _arrays.vertices(vertices, Place(part))
        self.triangles = _arrays.triangles(triangles, len(self.vertices), Place(part))

    @classmethod
    def of_checked(cls, vertices: Any, triangles: Any) -> Arrays:
        """Of arrays that _arrays.vertices() and _arrays.triangles() returned."""
        mesh = cls.__new__(cls)
        mesh.vertices, mesh.triangles = vertices, triangles
        return mesh

    def to_native(self) -> _native.Mesh:
        mesh = _native.Mesh(positions=_arrays.address(self.vertices), vertices=len(self.vertices),
                            triangles=_arrays.address(self.triangles), triangle_count=len(self.triangles))
        mesh.kept = (self.vertices, self.triangles)
        return mesh

    def to_file(self) -> bytes:
        """A PLY file with the same numbers."""
        return _ply.of_triangles(self.vertices, self.triangles)


class Polygons(Source):
    """A mesh whose faces have any number of corners. They are handed over as a PLY file, whose reader splits them."""

    def __init__(self, vertices: Any, faces: Packed) -> None:
        self.vertices, self.faces = vertices, faces

    def to_native(self) -> _native.Mesh:
        return Content(self.to_file()).to_native()

    def to_file(self) -> bytes:
        return _ply.of_polygons(self.vertices, self.faces.row, len(self.faces.starts))


class Content(Source):
    """The content of a mesh file."""

    def __init__(self, content: bytes) -> None:
        self.content = content

    def to_native(self) -> _native.Mesh:
        address = ctypes.cast(ctypes.c_char_p(self.content), ctypes.c_void_p)
        mesh = _native.Mesh(bytes=address, byte_count=len(self.content))
        mesh.kept = (self.content,)
        return mesh

    def to_file(self) -> bytes:
        return self.content


class File(Source):
    """A mesh file, which the engine reads."""

    def __init__(self, path: Union[str, bytes, os.PathLike[Any]]) -> None:
        self.path = os.fspath(path)
        os.stat(self.path)  # raises the OSError of Python

    def to_native(self) -> _native.Mesh:
        return _native.Mesh(path=os.fsencode(self.path))

    def to_file(self) -> bytes:
        with open(self.path, "rb") as file:
            return file.read()


def source_of(mesh: Any, part: str) -> Source:
    """The one way in for whatever a user gives. Raises InputError when it is no mesh, OSError for a path without a file."""
    if isinstance(mesh, (str, os.PathLike)):
        return File(mesh)
    if isinstance(mesh, (bytes, bytearray, memoryview)):
        return Content(bytes(mesh))
    from meshgauge import _reader  # with all that it needs; files need it not

    return _reader.source_of_objects(mesh, part)


def names_files(scene: bytes) -> bool:
    """Whether a glTF names files beside it. A scene that cannot be read is left to its reader to refuse."""
    try:
        uris = [buffer.get("uri", "data:") for buffer in json.loads(scene).get("buffers", [])]
        return any(not uri.startswith("data:") for uri in uris)
    except (ValueError, AttributeError, TypeError, RecursionError):
        return False


def units_of(a: Source, b: Source) -> Optional[tuple[Optional[str], Optional[str]]]:
    """The units that the objects name themselves, as trimesh's do; None: neither does."""
    return None if (a.unit, b.unit) == (None, None) else (a.unit, b.unit)


Notes = dict[str, Mapping[str, int]]


def notes_of(a: Source, b: Source) -> Notes:
    """What was noted when the meshes were read here, for noted()."""
    return {name: mesh.counts for name, mesh in (("a", a), ("b", b)) if mesh.counts}


def noted(document: dict[str, Any], notes: Notes) -> dict[str, Any]:
    """Adds notes to the result document, and returns it."""
    for name, counts in notes.items():
        mesh = document["meshes"][name]
        mesh["notes"] = [*mesh.get("notes", ()), *(f"{what}: {number}" for what, number in counts.items())]
        for what, number in counts.items():
            if what in _MEMBERS:
                mesh[_MEMBERS[what]] = mesh.get(_MEMBERS[what], 0) + number
    return document
