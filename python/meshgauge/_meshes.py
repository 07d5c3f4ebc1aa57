"""Meshes as Python knows them, for the engine: paths, bytes, arrays, and objects of other libraries."""

from __future__ import annotations

import ctypes
import os
from typing import Any, Optional, Union

from meshgauge import _native, _ply
from meshgauge.errors import InputError


class Arrays:
    """A mesh in arrays of numpy: C-contiguous float64 (n, 3) and uint32 (m, 3). Copies only what has another layout. No
    triangles: a point cloud."""

    def __init__(self, vertices: Any, triangles: Any, part: str) -> None:
        self.vertices = _vertices(vertices, part)
        self.triangles = _triangles(triangles, len(self.vertices), part)

    def to_native(self) -> _native.Mesh:
        mesh = _native.Mesh(positions=_address(self.vertices), vertices=len(self.vertices),
                            triangles=_address(self.triangles), triangle_count=len(self.triangles))
        mesh.kept = (self.vertices, self.triangles)
        return mesh

    def to_file(self) -> bytes:
        """A PLY file with the same numbers."""
        return _ply.of_triangles(self.vertices, self.triangles)


class Packed:
    """A mesh whose faces have any number of corners, as one array [n, i, j, k, ..., n, ...]. They are handed over
    as a PLY file, whose reader splits them."""

    def __init__(self, vertices: Any, faces: Any, part: str) -> None:
        self.vertices = _vertices(vertices, part)
        self.faces, self.count = _packed(faces, len(self.vertices), part)

    def to_native(self) -> _native.Mesh:
        return Content(self.to_file()).to_native()

    def to_file(self) -> bytes:
        return _ply.of_polygons(self.vertices, self.faces, self.count)


class Content:
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


class File:
    """A mesh file, which the engine reads."""

    def __init__(self, path: Union[str, bytes, os.PathLike[Any]]) -> None:
        self.path = os.fspath(path)
        os.stat(self.path)  # raises the OSError of Python

    def to_native(self) -> _native.Mesh:
        return _native.Mesh(path=os.fsencode(self.path))

    def to_file(self) -> bytes:
        with open(self.path, "rb") as file:
            return file.read()


Source = Union[Arrays, Packed, Content, File]


def source_of(mesh: Any, part: str) -> Source:
    """Finds out what `mesh` is. Raises InputError when it is no mesh, OSError for a path without a file."""
    if isinstance(mesh, (str, os.PathLike)):
        return File(mesh)
    if isinstance(mesh, (bytes, bytearray, memoryview)):
        return Content(bytes(mesh))
    if isinstance(mesh, (tuple, list)) and len(mesh) == 2:
        return Arrays(mesh[0], mesh[1], part)
    if type(mesh).__name__ == "ndarray":
        return Arrays(mesh, None, part)
    return _of_object(mesh, part)


def own_units(a: Any, b: Any) -> Optional[tuple[Optional[str], Optional[str]]]:
    """The units that the objects name themselves, as trimesh's do; None: neither does."""
    units = _own_unit(a), _own_unit(b)
    return None if units == (None, None) else units


def _own_unit(mesh: Any) -> Optional[str]:
    return getattr(mesh, "units", None) if hasattr(mesh, "vertices") else None


def _of_object(mesh: Any, part: str) -> Source:
    for name in ("faces", "triangles"):  # trimesh; Open3D
        if hasattr(mesh, "vertices") and hasattr(mesh, name):
            return Arrays(mesh.vertices, getattr(mesh, name), part)
    if hasattr(mesh, "points") and hasattr(mesh, "faces"):  # PyVista
        if getattr(mesh, "n_strips", 0):
            raise InputError(f"'{part}' has strips of triangles: call its triangulate()")
        if getattr(mesh, "n_lines", 0) and not len(mesh.faces):
            raise InputError(f"'{part}' has lines alone, and no triangles", "empty-mesh")
        return _of_packed(mesh.points, mesh.faces, part)
    if hasattr(mesh, "points") and isinstance(getattr(mesh, "cells", None), list):  # meshio
        return _of_packed(mesh.points, _faces_of_cells(mesh.cells, part), part)
    for name in ("vertices", "points"):  # trimesh; Open3D
        if type(mesh).__name__ == "PointCloud" and hasattr(mesh, name):
            return Arrays(getattr(mesh, name), None, part)
    raise InputError(
        f"'{part}' must be a path, bytes, points, (vertices, faces) or an object with vertices and faces or with points and "
        f"faces or cells, not {type(mesh).__module__}.{type(mesh).__qualname__}")


def _of_packed(points: Any, faces: Any, part: str) -> Source:
    """Arrays if all faces are triangles, which need not be split."""
    numpy = _numpy()
    packed = numpy.asarray(faces)
    if packed.size == 0:
        return Arrays(points, None, part)
    if packed.ndim == 1 and packed.size % 4 == 0 and (packed[::4] == 3).all():
        return Arrays(points, packed.reshape(-1, 4)[:, 1:], part)
    return Packed(points, packed, part)


def _faces_of_cells(cells: list[Any], part: str) -> Any:
    """meshio's blocks of triangles, quads and polygons as one packed array; empty for vertices alone. Lines and vertices
    have no surface."""
    numpy = _numpy()
    blocks = []
    for cell in cells:
        if cell.type in ("line", "vertex"):
            continue
        if cell.type not in ("triangle", "quad", "polygon"):
            raise InputError(f"'{part}' has cells of the type '{cell.type}': give its surface, triangles, quads or "
                             "polygons")
        corners = numpy.asarray(cell.data)
        if corners.ndim != 2 or corners.dtype.kind not in "iu":
            raise InputError(f"the cells of '{part}' must be integers of the shape (m, n)")
        counts = numpy.full((len(corners), 1), corners.shape[1], corners.dtype)
        blocks.append(numpy.hstack((counts, corners)).reshape(-1))
    if not blocks and any(cell.type == "line" for cell in cells):
        raise InputError(f"'{part}' has lines alone, and no triangles", "empty-mesh")
    return numpy.concatenate(blocks) if blocks else ()


def _numpy() -> Any:
    import numpy  # takes longer than everything else here, and files need it not

    return numpy


def _address(array: Any) -> int:
    return int(array.__array_interface__["data"][0])


def _as_array(values: Any, what: str) -> Any:
    numpy = _numpy()
    if numpy.ma.is_masked(values):
        raise InputError(f"{what} has masked elements")
    try:
        return numpy.asarray(values)
    except (TypeError, ValueError) as defect:
        raise InputError(f"{what} is no array of numbers: {defect}") from None


def _checked(values: Any, what: str, kinds: str, kinds_in_words: str) -> Any:
    """An array of the shape (n, 3), of numbers of these kinds."""
    array = _as_array(values, what)
    if array.ndim != 2 or array.shape[1] != 3:
        raise InputError(f"{what} must have the shape (n, 3), not {array.shape}")
    if array.dtype.kind not in kinds:
        raise InputError(f"{what} must be {kinds_in_words}, not {array.dtype}")
    return array


def _vertices(values: Any, part: str) -> Any:
    """Exactly the given numbers as float64."""
    numpy = _numpy()
    what = f"vertices of '{part}'"
    array = _checked(values, what, "fiu", "real numbers")
    converted = numpy.require(array, numpy.float64, ["C_CONTIGUOUS", "ALIGNED"])
    if array.dtype.itemsize > 8 or (array.dtype.kind in "iu" and array.dtype.itemsize == 8):
        with numpy.errstate(invalid="ignore"):
            inexact = (converted.astype(array.dtype) != array) & (array == array)
        if inexact.any():
            row = int(numpy.argmax(inexact.any(axis=1)))
            raise InputError(f"vertex {row} of '{part}' is no float64: round the {array.dtype} first")
    return converted


def _triangles(values: Any, vertices: int, part: str) -> Any:
    """uint32 indices; none for None. Those of another type are checked before they lose their sign or their upper half."""
    numpy = _numpy()
    array = _as_array(() if values is None else values, f"faces of '{part}'")
    if array.size == 0:
        return numpy.empty((0, 3), numpy.uint32)
    array = _checked(array, f"faces of '{part}'", "iu", "integers")
    _check_indices(array, vertices, part)
    if array.dtype == numpy.int32:
        array = array.view(numpy.uint32)  # not negative: the same bits
    return numpy.require(array, numpy.uint32, ["C_CONTIGUOUS", "ALIGNED"])


def _check_indices(faces: Any, vertices: int, part: str) -> None:
    unsigned = faces.view(faces.dtype.str.replace("i", "u"))  # a negative index becomes a large one
    if int(unsigned.max()) < vertices:
        return
    row = int(((faces < 0) | (faces >= vertices)).any(axis=1).argmax())
    index = next(int(i) for i in faces[row] if not 0 <= i < vertices)
    raise InputError(f"triangle {row} of '{part}' uses vertex {index} of {vertices}", "index-out-of-range",
                     f"triangle {row}")


def _packed(values: Any, vertices: int, part: str) -> tuple[Any, int]:
    """The faces as uint32, and their number."""
    numpy = _numpy()
    array = _as_array(values, f"faces of '{part}'")
    if array.size == 0:
        raise InputError(f"'{part}' has no triangles", "empty-mesh")
    if array.ndim != 1 or array.dtype.kind not in "iu":
        raise InputError(f"faces of '{part}' must be one row of integers, [n, i, j, k, ...], not {array.dtype} of the "
                         f"shape {array.shape}")
    numbers, at, count = array.tolist(), 0, 0
    while at < len(numbers):
        corners = numbers[at]
        face = numbers[at + 1:at + 1 + corners] if corners > 2 else []
        if not face or len(face) != corners:
            raise InputError(f"face {count} of '{part}' has {corners} corners, and {len(numbers) - at - 1} numbers follow")
        wrong = [i for i in face if not 0 <= i < vertices]
        if wrong:
            raise InputError(f"face {count} of '{part}' uses vertex {wrong[0]} of {vertices}", "index-out-of-range",
                             f"face {count}")
        at, count = at + 1 + corners, count + 1
    return array.astype(numpy.uint32), count
