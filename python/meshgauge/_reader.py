"""Walks through what a user gives: arrays, objects of other libraries, and lists, blocks and scenes of them."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from typing import Any, Optional

from meshgauge import _arrays, _hints, _objects
from meshgauge._attributes import Attributes, Place, guarded
from meshgauge._meshes import NOT_PLACED, Source
from meshgauge._surface import Surface
from meshgauge.errors import InputError

_DEEPEST = 16  # lists in lists, blocks in blocks, scenes in lists
_MOST_MESHES = 1_000_000  # of all lists, blocks and scenes of one mesh: an iterator may have no end
_MAKERS = ("dump", "to_geometry", "to_mesh")  # of the meshes of a scene at their places, in trimesh


def source_of_objects(mesh: Any, part: str) -> Source:
    """What is no file, for _meshes.source_of()."""
    reader = _Reader(part)
    reader.add(mesh, part, None)
    return reader.surface.source()


class _Reader:
    """Adds every mesh that it comes to, to one surface."""

    def __init__(self, part: str) -> None:
        self.surface = Surface(part)
        self._part = part
        self._above: list[Any] = []  # the lists, blocks and scenes that hold what is read
        self._meshes = 0

    def add(self, mesh: Any, part: str, unit: Optional[str]) -> None:
        """`unit`: of the scene that holds the mesh."""
        self._meshes += 1
        if self._meshes > _MOST_MESHES:
            raise InputError(f"'{self._part}' holds more than {_MOST_MESHES} meshes", "too-large")
        attributes = Attributes(mesh, part)
        if _is_scene(attributes):
            self._add_scene(attributes, unit)
        elif _holds_blocks(attributes):
            self._add_blocks(attributes, unit)
        elif (add := _objects.adder_of(attributes)) is not None:
            add(attributes, self.surface, unit)
        elif _arrays.is_array(mesh) or isinstance(mesh, (list, tuple)):
            self._add_sequence(mesh, part, unit)
        else:
            raise self._refusal(attributes)

    def _refusal(self, mesh: Attributes) -> InputError:
        return _hints.refusal(mesh, "a list of meshes holds objects and pairs (vertices, faces)" if self._above else "")

    def _add_sequence(self, mesh: Any, part: str, unit: Optional[str]) -> None:
        if _is_list_of_meshes(mesh, part):
            self._add_each(mesh, part, unit, enumerate(mesh), "a list")
        elif isinstance(mesh, (list, tuple)) and len(mesh) == 2:
            vertices = _arrays.vertices(mesh[0], Place(part))
            self.surface.add(Place(part), vertices, _arrays.triangles(mesh[1], len(vertices), Place(part)), unit)
        elif _arrays.is_array(mesh) and not self._above:
            self.surface.add(Place(part), _arrays.vertices(mesh, Place(part)), _arrays.triangles(None, 0, Place(part)), unit)
        else:
            raise self._refusal(Attributes(mesh, part))

    def _add_each(self, holder: Any, part: str, unit: Optional[str], meshes: Iterable[tuple[int, Any]], kind: str) -> None:
        """`meshes`: with their numbers in the holder. `kind`: that of the holder, for the note."""
        self.surface.holder = self.surface.holder or kind
        if any(above is holder for above in self._above):
            raise InputError(f"'{part}' holds itself")
        if len(self._above) == _DEEPEST:
            raise InputError(f"'{self._part}' holds lists in lists, more than {_DEEPEST} deep")
        self._above.append(holder)
        for number, mesh in meshes:
            self.add(mesh, f"{part}[{number}]", unit)
        self._above.pop()

    def _add_blocks(self, mesh: Attributes, unit: Optional[str]) -> None:
        """A MultiBlock of PyVista, where None stands for a block without content."""
        blocks = _listed(mesh.mesh, mesh.place.of("the blocks"))
        present = [(number, block) for number, block in enumerate(blocks) if block is not None]
        self._add_each(mesh.mesh, mesh.part, unit, present, "blocks")
        self.surface.count("blocks without content, left out", len(blocks) - len(present))

    def _add_scene(self, mesh: Attributes, unit: Optional[str]) -> None:
        """A scene of trimesh, whose meshes it places."""
        maker = next((name for name in _MAKERS if mesh.has_method(name)), None)
        if maker is None:
            raise InputError(f"{mesh.said()}, a scene that does not place its meshes: give scene.to_mesh(), or in older versions of "
                             "trimesh scene.dump(concatenate=True)")
        made = mesh.call(maker)
        is_list = isinstance(made, (list, tuple)) or (_arrays.is_array(made) and made.dtype == object)
        meshes = _listed(made, mesh.place.of(maker + "()")) if is_list else [made]
        placed = [(number, one) for number, one in enumerate(meshes) if not self._is_path(one)]
        self._add_each(mesh.mesh, mesh.part, _objects.unit_of(mesh) or unit, placed, "a scene, at their places")
        self.surface.count(NOT_PLACED, _not_placed(mesh))

    def _is_path(self, mesh: Any) -> bool:
        """Whether one of a scene is a path of trimesh, without a surface. Counts its lines."""
        attributes = Attributes(mesh, self._part)
        if not attributes.has("vertices", "entities"):
            return False
        self.surface.lines += guarded(attributes.place.of("entities"), lambda: len(attributes.data("entities")))
        return True


def _listed(values: Iterable[Any], what: str) -> list[Any]:
    listed: list[Any] = []

    def fill() -> None:
        for value in values:
            listed.append(value)
            if len(listed) > _MOST_MESHES:
                raise InputError(f"{what} are more than {_MOST_MESHES} meshes", "too-large")

    guarded(what, fill)
    return listed


def _is_scene(mesh: Attributes) -> bool:
    return isinstance(mesh.data("geometry"), Mapping)


def _not_placed(scene: Attributes) -> int:
    """The number of a scene's meshes that have no place in it."""
    placed = guarded(scene.place.of("graph"), lambda: getattr(scene.get("graph"), "geometry_nodes", None))
    return len(set(scene.data("geometry")) - set(placed)) if isinstance(placed, Mapping) else 0


def _holds_blocks(mesh: Attributes) -> bool:
    """Whether this is a MultiBlock of PyVista, or a PartitionedDataSet."""
    counts = (mesh.data(name) for name in ("n_blocks", "n_partitions"))
    is_like = type(mesh.mesh).__name__ == "MultiBlock" or any(isinstance(count, int) for count in counts)
    return is_like and any(hasattr(type(mesh.mesh), name) for name in ("__iter__", "__getitem__"))


def _is_list_of_meshes(values: Any, part: str, depth: int = 0) -> bool:
    """Whether a list holds meshes, and not vertices and faces, or points. Its first two members decide."""
    if _arrays.is_array(values):
        return bool(values.ndim == 1 and values.dtype == object and values.size)
    return any(_is_mesh(value, f"{part}[{number}]", depth) for number, value in enumerate(values[:2]))


def _is_mesh(value: Any, part: str, depth: int) -> bool:
    if value is None or isinstance(value, (int, float, complex)):
        return False
    if _arrays.is_array(value):
        return _is_list_of_meshes(value, part)
    if isinstance(value, (list, tuple)):  # a pair (vertices, faces), or again a list of meshes; not a row of numbers, nor rows
        return depth == _DEEPEST or _is_list_of_meshes(value, part, depth + 1) or (len(value) == 2 and _is_table(value[0]))
    if isinstance(value, (str, os.PathLike, bytes, bytearray, memoryview)):
        return True
    attributes = Attributes(value, part)
    return (_is_scene(attributes) or _holds_blocks(attributes) or _objects.adder_of(attributes) is not None
            or bool(_hints.hint_for(attributes)))


def _is_table(values: Any) -> bool:
    """Whether these are points: rows of numbers."""
    if _arrays.is_array(values):
        return bool(values.ndim == 2)
    if isinstance(values, (list, tuple)):
        return bool(values) and (isinstance(values[0], (list, tuple)) or (_arrays.is_array(values[0]) and values[0].ndim == 1))
    return hasattr(values, "__len__") and not isinstance(values, (str, bytes))
