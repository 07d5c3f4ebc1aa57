"""Objects of other libraries, recognised by their attributes: none of these libraries is imported."""

from __future__ import annotations

import functools
import re
from collections.abc import Callable, Mapping
from typing import Any, Optional

from meshgauge import _arrays, _packed, _vtk_cells
from meshgauge._attributes import Attributes, Place, guarded
from meshgauge._meshes import MERGED
from meshgauge._surface import Surface
from meshgauge.errors import InputError

_OTHER_FACES = ("quads", "polygons", "ngons", "strips")

# Adds an object to a surface. The unit is that of the scene which the object is in.
Add = Callable[[Attributes, Surface, Optional[str]], None]


def adder_of(mesh: Attributes) -> Optional[Add]:
    """Returns the function that adds an object like this one, or None for an unknown kind."""
    return next((add for is_like, add in _KINDS if is_like(mesh)), None)


def unit_of(mesh: Attributes) -> Optional[str]:
    """The unit that an object names, as trimesh's do."""
    unit = mesh.data("units")
    if unit is not None and not isinstance(unit, str):
        raise InputError(f"{mesh.place.of('units')} must be a unit such as 'mm', not {class_name(unit)}")
    return unit


def class_name(value: Any) -> str:
    return type(value).__name__


def _add_arrays(mesh: Attributes, surface: Surface, unit: Optional[str]) -> None:
    """trimesh; Open3D's legacy meshes."""
    name = "faces" if mesh.has("faces") else "triangles"
    for other in _OTHER_FACES:
        value = mesh.data(other)
        if hasattr(type(value), "__len__") and guarded(mesh.place.of(other), functools.partial(len, value)):
            raise InputError(f"{mesh.said()} with {other} beside {name}, which are not read: give all faces as triangles, "
                             "(vertices, faces)", "unsupported-format")
    vertices = _arrays.vertices(mesh.data("vertices"), mesh.place)
    faces = _arrays.triangles(mesh.data(name), len(vertices), mesh.place, name)
    surface.add(mesh.place, vertices, faces, unit_of(mesh) or unit)


def _add_vectors(mesh: Attributes, surface: Surface, unit: Optional[str]) -> None:
    """numpy-stl: the three corners of each triangle. Equal corners are merged, as those of an STL file are."""
    numpy = _arrays.numpy_module()
    vectors = _arrays.as_array(mesh.data("vectors"), mesh.place.of("vectors"))
    if vectors.ndim != 3 or vectors.shape[1:] != (3, 3):
        raise InputError(f"{mesh.place.of('vectors')} must have the shape (n, 3, 3), not {vectors.shape}")
    if not len(vectors):
        raise InputError(f"'{mesh.part}' has no triangles", "empty-mesh")
    corners = _arrays.vertices(vectors.reshape(-1, 3), mesh.place, "vectors")
    finite = numpy.isfinite(corners).all(axis=1)
    if not finite.all():
        corner = int(finite.argmin())
        what = "NaN" if numpy.isnan(corners[corner]).any() else "infinite"
        raise InputError(f"a corner of triangle {corner // 3} of '{mesh.part}' is {what}", "non-finite-vertex",
                         f"triangle {corner // 3}")
    points, index = _arrays.welded(corners)
    surface.count(MERGED, len(corners) - len(points))
    surface.add(mesh.place, points, index.reshape(-1, 3), unit)


def _add_properties(mesh: Attributes, surface: Surface, unit: Optional[str]) -> None:
    """manifold3d's Mesh: the first three properties of a vertex are its position."""
    properties = _arrays.as_array(mesh.data("vert_properties"), mesh.place.of("vert_properties"))
    if properties.ndim != 2 or properties.shape[1] < 3:
        raise InputError(f"{mesh.place.of('vert_properties')} must have the shape (n, 3) or wider, not {properties.shape}")
    vertices = _arrays.vertices(properties[:, :3], mesh.place, "vert_properties")
    surface.add(mesh.place, vertices, _arrays.triangles(mesh.data("tri_verts"), len(vertices), mesh.place, "tri_verts"), unit)


def _add_manifold(mesh: Attributes, surface: Surface, unit: Optional[str]) -> None:
    """manifold3d's Manifold, whose coordinates are of double precision in newer versions."""
    name = "to_mesh64" if mesh.has_method("to_mesh64") else "to_mesh"
    made = Attributes(mesh.call(name), mesh.part)
    if not made.has("vert_properties", "tri_verts"):
        raise InputError(f"{mesh.place.of(name + '()')} must have vert_properties and tri_verts, and is a {made.owner}")
    _add_properties(made, surface, unit)


def _add_tensors(mesh: Attributes, surface: Surface, unit: Optional[str]) -> None:
    """Open3D's meshes of tensors."""
    vertices = _arrays.vertices(_entry(mesh, "vertex", "positions"), mesh.place, "vertex.positions")
    faces = _entry(mesh, "triangle", "indices")
    surface.add(mesh.place, vertices, _arrays.triangles(faces, len(vertices), mesh.place, "triangle.indices"), unit)


def _entry(mesh: Attributes, name: str, key: str) -> Any:
    """An entry of a map of tensors. Open3D's have their entries as attributes as well, but not in every version. None: there is
    none, as in a mesh without triangles."""
    entries = mesh.get(name)

    def looked_up() -> Any:
        try:
            return entries[key]
        except (LookupError, TypeError):
            return None

    place = mesh.place.of(f"{name}.{key}")
    found = guarded(place, lambda: getattr(entries, key, None))
    return guarded(place, looked_up) if found is None or callable(found) else found


def _add_cells(mesh: Attributes, surface: Surface, unit: Optional[str]) -> None:
    """meshio: blocks of cells. Lines and vertices have no surface."""
    vertices = _arrays.vertices(mesh.data("points"), mesh.place, "points")
    cells = mesh.data("cells")
    blocks = cells.items() if isinstance(cells, Mapping) else cells
    faces = []
    for number, block in enumerate(guarded(mesh.place.of("cells"), lambda: list(blocks))):
        kind, corners = _block(block, Place(mesh.part, mesh.owner), number)
        if re.fullmatch(r"line\d*|VTK_LAGRANGE_CURVE", kind):
            surface.lines += len(corners)
        elif kind == "vertex":
            surface.points += len(corners)
        elif len(corners):
            faces.append(_faces_of_block(kind, corners, len(vertices), mesh, number))
    surface.add(mesh.place, vertices, _packed.joined(faces), unit)


def _block(block: Any, place: Place, number: int) -> tuple[str, Any]:
    """The type and the corners of a block: a pair, or an object with `type` and `data`."""
    name = f"cells[{number}]"
    if isinstance(block, tuple) and len(block) == 2:
        kind, data = block
    else:
        attributes = Attributes(block, f"{name} of {place.part}")
        kind, data = attributes.data("type"), attributes.data("data")
    if not isinstance(kind, str) or data is None:
        raise InputError(f"{place.of(name)} must have a type and data")
    size = guarded(place.of(name), lambda: len(data))
    return kind, data if size else ()


def _faces_of_block(kind: str, data: Any, vertices: int, mesh: Attributes, number: int) -> _packed.Packed:
    if not re.fullmatch(r"triangle|quad|polygon\d*", kind):
        raise InputError(f"{mesh.said()} with cells of the type '{kind}' ({len(data)}), which are not read: give its surface, "
                         "cells of triangles, quads or polygons", "unsupported-format")
    what = mesh.place.of(f"cells[{number}]")
    rows = _arrays.as_array(data, what)
    if rows.ndim != 2 or rows.dtype.kind not in "iu":
        raise InputError(f"{what} must be integers of the shape (m, n), not {rows.dtype} of the shape {rows.shape}")
    if rows.shape[1] != {"triangle": 3, "quad": 4}.get(kind, max(3, rows.shape[1])):
        raise InputError(f"{what} must have the corners of a {kind}, not {rows.shape[1]}")
    return _packed.cells_of_rows(rows, vertices, mesh.place, f"cells[{number}]", kind)


def _add_cloud(mesh: Attributes, surface: Surface, unit: Optional[str]) -> None:
    """The points of trimesh's, Open3D's and PyVista's clouds."""
    name = next((name for name in ("vertices", "points") if mesh.has(name)), None)
    points = mesh.data(name) if name else _entry(mesh, "point", "positions")
    vertices = _arrays.vertices(points, mesh.place, name or "point.positions")
    surface.add(mesh.place, vertices, _arrays.triangles(None, 0, mesh.place), unit_of(mesh) or unit)


def _is_poly_data(mesh: Attributes) -> bool:
    if not mesh.has("points"):
        return False
    alone = mesh.has("strips") and not mesh.has_method("GetPolys")  # VTK's own class has other faces beside its strips
    return mesh.has("faces") or mesh.has("regular_faces") or alone


def _has_blocks_of_cells(mesh: Attributes) -> bool:
    return mesh.has("points") and isinstance(mesh.data("cells"), (list, tuple, Mapping)) and not mesh.has_method("GetCells")


def _is_cloud(mesh: Attributes) -> bool:
    of_points = any(mesh.has(name) for name in ("vertices", "points")) or mesh.get("point") is not None
    return class_name(mesh.mesh) in ("PointCloud", "PointSet") and of_points


# What an object is like, and the function that adds it. The first that fits counts.
_KINDS: tuple[tuple[Callable[[Attributes], bool], Add], ...] = (
    (lambda mesh: mesh.has("vertices", "faces") or mesh.has("vertices", "triangles"), _add_arrays),
    (lambda mesh: mesh.has("points", "cells", "celltypes"), _vtk_cells.add_grid),
    (_is_poly_data, _vtk_cells.add_poly_data),
    (lambda mesh: mesh.has("vectors"), _add_vectors),
    (lambda mesh: mesh.has("vert_properties", "tri_verts"), _add_properties),
    (_has_blocks_of_cells, _add_cells),
    (lambda mesh: mesh.get("vertex") is not None and mesh.get("triangle") is not None, _add_tensors),
    (_is_cloud, _add_cloud),
    (lambda mesh: class_name(mesh.mesh) == "Manifold" and mesh.has_method("to_mesh"), _add_manifold),
)
