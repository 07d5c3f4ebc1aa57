"""The cells of VTK, which are those of PyVista: PolyData and UnstructuredGrid."""

from __future__ import annotations

from typing import Any, Optional

from meshgauge import _arrays, _packed
from meshgauge._attributes import Attributes
from meshgauge._surface import Surface
from meshgauge.errors import InputError

STRIPS = "strips of triangles, split into triangles and measured"

_TRIANGLE, _STRIP, _POLYGON, _PIXEL, _QUAD = 5, 6, 7, 8, 9
_CORNERS = {_TRIANGLE: 3, _PIXEL: 4, _QUAD: 4}
_EMPTY = (0,)
_POINTS = (1, 2)
_LINES = (3, 4, 21, 35, 68, 75)
_NAMES = {
    10: "tetra", 11: "voxel", 12: "hexahedron", 13: "wedge", 14: "pyramid", 15: "pentagonal prism", 16: "hexagonal prism",
    22: "quadratic triangle", 23: "quadratic quad", 24: "quadratic tetra", 25: "quadratic hexahedron", 26: "quadratic wedge",
    27: "quadratic pyramid", 28: "biquadratic quad", 29: "triquadratic hexahedron", 30: "quadratic linear quad",
    31: "quadratic linear wedge", 32: "biquadratic quadratic wedge", 33: "biquadratic quadratic hexahedron",
    34: "biquadratic triangle", 36: "quadratic polygon", 37: "triquadratic pyramid", 41: "convex point set", 42: "polyhedron",
    69: "Lagrange triangle", 70: "Lagrange quadrilateral", 71: "Lagrange tetrahedron", 72: "Lagrange hexahedron",
    73: "Lagrange wedge", 74: "Lagrange pyramid", 76: "Bezier triangle", 77: "Bezier quadrilateral", 78: "Bezier tetrahedron",
    79: "Bezier hexahedron", 80: "Bezier wedge", 81: "Bezier pyramid"}


def add_poly_data(mesh: Attributes, surface: Surface, unit: Optional[str]) -> None:
    """A PolyData: `points`, and rows of cells in `faces` and `strips`; `lines` and `verts` have no surface."""
    points = _arrays.vertices(mesh.data("points"), mesh.place, "points")
    if mesh.data("faces") is not None or not mesh.has("regular_faces"):
        faces = _packed.cells(mesh.data("faces"), len(points), mesh.place, "faces", "face", 3)
    else:
        faces = _regular(mesh, len(points))
    strips = _packed.cells(mesh.data("strips"), len(points), mesh.place, "strips", "strip", 0)
    if mesh.data("n_strips") and not len(strips.starts):
        raise InputError(f"{mesh.said()} with strips of triangles (n_strips) and without 'strips': call its triangulate()")
    for name in ("lines", "verts"):
        number = mesh.data("n_" + name)
        if not isinstance(number, int):
            number = len(_packed.cells(mesh.data(name), len(points), mesh.place, name, "cell", 0).starts)
        if name == "lines":
            surface.lines += number
        else:
            surface.points += number
    surface.add(mesh.place, points, _with_strips(faces, strips, surface), unit)


def add_grid(mesh: Attributes, surface: Surface, unit: Optional[str]) -> None:
    """An UnstructuredGrid: `points`, one row of `cells`, and `celltypes`. Raises InputError for cells that are no surface."""
    numpy = _arrays.numpy_module()
    points = _arrays.vertices(mesh.data("points"), mesh.place, "points")
    types = _arrays.as_array(mesh.data("celltypes"), mesh.place.of("celltypes"))
    if types.size and (types.ndim != 1 or types.dtype.kind not in "iu"):
        raise InputError(f"{mesh.place.of('celltypes')} must be one row of integers, not {types.dtype} of the shape {types.shape}")
    _refuse_others(mesh, types)
    cells = _packed.cells(mesh.data("cells"), len(points), mesh.place, "cells", "cell", 0)
    if len(cells.starts) != types.size:
        raise InputError(f"{mesh.place.of('celltypes')} must have a type for each of the {len(cells.starts)} cells, not {types.size}")
    _check_corners(mesh, types, cells.counts)
    third, fourth = (cells.starts[types == _PIXEL] + corner for corner in (3, 4))  # a pixel goes by rows, not around
    cells.row[third], cells.row[fourth] = cells.row[fourth], cells.row[third]
    surface.points += int(numpy.isin(types, _POINTS).sum())
    surface.lines += int(numpy.isin(types, _LINES).sum())
    faces = cells.select(numpy.isin(types, (_TRIANGLE, _POLYGON, _PIXEL, _QUAD)))
    surface.add(mesh.place, points, _with_strips(faces, cells.select(types == _STRIP), surface), unit)


def _with_strips(faces: _packed.Packed, strips: _packed.Packed, surface: Surface) -> _packed.Packed:
    if not len(strips.starts):
        return faces
    triangles, joins = _packed.triangles_of_strips(strips)
    short = int((strips.counts < 3).sum())
    surface.count(STRIPS, len(strips.starts) - short)
    surface.joins += joins + short
    return _packed.joined([faces, _packed.of_rows(triangles)])


def _regular(mesh: Attributes, vertices: int) -> _packed.Packed:
    """The faces of `regular_faces`, (m, k)."""
    what = mesh.place.of("regular_faces")
    rows = _arrays.as_array(mesh.data("regular_faces"), what)
    if rows.size == 0:
        return _packed.joined([])
    if rows.ndim != 2 or rows.shape[1] < 3 or rows.dtype.kind not in "iu":
        raise InputError(f"{what} must be integers of the shape (m, k) with k of 3 or more, not {rows.dtype} of the shape {rows.shape}")
    return _packed.cells_of_rows(rows, vertices, mesh.place, "regular_faces", "face")


def _refuse_others(mesh: Attributes, types: Any) -> None:
    numpy = _arrays.numpy_module()
    known = (*_CORNERS, _STRIP, _POLYGON, *_EMPTY, *_POINTS, *_LINES)
    kinds, counts = numpy.unique(types[~numpy.isin(types, known)] if types.size else types, return_counts=True)
    if len(kinds):
        found = ", ".join(f"{_NAMES.get(int(kind), 'unknown')} (VTK type {int(kind)}): {int(count)}" for kind, count in zip(kinds, counts))
        raise InputError(f"{mesh.said()} with cells that are not read, {found}: give its surface, .extract_surface()",
                         "unsupported-format")


def _check_corners(mesh: Attributes, types: Any, counts: Any) -> None:
    numpy = _arrays.numpy_module()
    for kind, corners in (*_CORNERS.items(), (_POLYGON, None)):
        wrong = (types == kind) & (counts < 3 if corners is None else counts != corners)
        if wrong.any():
            cell = int(numpy.argmax(wrong))
            name = {_TRIANGLE: "triangle", _PIXEL: "pixel", _QUAD: "quad", _POLYGON: "polygon"}[kind]
            raise InputError(f"cell {cell} of '{mesh.part}' is a {name} of {int(counts[cell])} corners", where=f"cell {cell}")
