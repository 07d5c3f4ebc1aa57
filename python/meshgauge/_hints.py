"""What to do with an object that is no mesh, and holds or makes one."""

from __future__ import annotations

from collections.abc import Callable

from meshgauge._attributes import Attributes
from meshgauge._surface import LINES_ALONE
from meshgauge.errors import InputError


def hint_for(mesh: Attributes) -> str:
    """What is wrong with an object and what to give instead; "" for an object about which nothing is known."""
    for is_like, says in _HINTS:
        if is_like(mesh):
            return f"{mesh.said()}, {says}"
    for pair in (("vertices", "faces"), ("points", "faces"), ("points", "cells")):
        if all(mesh.get(name) is not None for name in pair) and any(mesh.has_method(name) for name in pair):
            return f"{mesh.said()}, whose {pair[0]} and {pair[1]} are methods: give a pair of arrays, (vertices, faces)"
    return ""


def refusal(mesh: Attributes, of_list: str) -> InputError:
    """The exception for an object that is not read. `of_list`: what the list that holds it may hold; "": no list holds it."""
    if hint := hint_for(mesh):
        return InputError(hint)
    if mesh.has("vertices", "entities") or mesh.has("points", "lines"):  # a path of trimesh, a LineSet of Open3D
        return InputError(f"'{mesh.part}' {LINES_ALONE}: it is a {mesh.owner}", "empty-mesh")
    if of_list:
        return InputError(f"{mesh.said()}: {of_list}")
    return InputError(f"'{mesh.part}' must be a path, bytes, points, (vertices, faces), an object with vertices and faces or with "
                      f"points and faces or cells, or a list of such objects, not {mesh.owner}")


def _of(*libraries: str) -> Callable[[Attributes], bool]:
    return lambda mesh: mesh.owner.partition(".")[0] in libraries


def _is_of_blender(mesh: Attributes) -> bool:
    """An Object, a Mesh or a BMesh."""
    has_loops = any(mesh.get(name) is not None for name in ("loops", "loop_triangles"))
    return _of("bpy", "bpy_types", "bmesh")(mesh) or mesh.get("matrix_world") is not None or (has_loops and not mesh.has("faces"))


_CAD = ("a shape without triangles, which its tessellate() makes: points, triangles = {0}.tessellate(0.01), then give "
        "([{1} for p in points], triangles)")
_HINTS: tuple[tuple[Callable[[Attributes], bool], str], ...] = (
    (lambda mesh: _of("cadquery")(mesh) and mesh.has_method("toCompound"), _CAD.format("assembly.toCompound()", "p.toTuple()")),
    (lambda mesh: _of("cadquery")(mesh) and not mesh.has_method("tessellate") and mesh.has_method("val"),
     _CAD.format("part.val()", "p.toTuple()")),
    (lambda mesh: _of("cadquery")(mesh) and mesh.has_method("tessellate"), _CAD.format("shape", "p.toTuple()")),
    (lambda mesh: mesh.has_method("extract_surface"), "which has no faces of its own: give its surface, .extract_surface()"),
    (lambda mesh: mesh.has_method("tessellate"), _CAD.format("shape", "tuple(p)")),
    (lambda mesh: _of("build123d")(mesh) and mesh.get("part") is not None, _CAD.format("builder.part", "tuple(p)")),
    (_is_of_blender,
     "of Blender: give arrays, with m = object.to_mesh() and m.calc_loop_triangles() before: ([tuple(object.matrix_world @ v.co) "
     "for v in m.vertices], [tuple(t.vertices) for t in m.loop_triangles]); or write a file, bpy.ops.wm.stl_export()"),
    (lambda mesh: mesh.has_method("current_mesh"),
     "a set of meshes: give the arrays of one, m = set.current_mesh(): (m.vertex_matrix(), m.face_matrix())"),
    (lambda mesh: mesh.has_method("vertex_matrix", "face_matrix"), "whose arrays are (mesh.vertex_matrix(), mesh.face_matrix()): give these"),
    (lambda mesh: mesh.has_method("verts_packed", "faces_packed"), "whose arrays are (meshes.verts_packed(), meshes.faces_packed()): give these"),
    (lambda mesh: any(mesh.has_method(name) for name in ("GetClassName", "GetPolys", "GetCells", "GetBlock")), "of VTK: give pyvista.wrap() of it"),
    (lambda mesh: mesh.get("Topology") is not None,
     "of FreeCAD: points, triangles = mesh.Topology, then give ([tuple(p) for p in points], triangles)"),
    (lambda mesh: mesh.has("vertices", "tetras"), "of tetrahedra, which are not read: give its surface, (vertices, faces)"),
)
