"""The surface of one mesh, which is put together from one or more objects."""

from __future__ import annotations

from typing import Any, NamedTuple, Optional, Union

from meshgauge import _arrays, _packed
from meshgauge._attributes import Place
from meshgauge._meshes import NO_SURFACE, Arrays, Polygons, Source
from meshgauge._packed import Packed
from meshgauge.errors import InputError

LINES_ALONE = "has lines alone, and no triangles"


class _Piece(NamedTuple):
    part: str
    vertices: Any  # as _arrays.vertices() returns them
    faces: Union[Any, Packed]  # as _arrays.triangles() returns them, or of any number of corners
    unit: Optional[str]

    @property
    def is_packed(self) -> bool:
        return isinstance(self.faces, Packed)

    @property
    def face_count(self) -> int:
        return len(self.faces.starts if self.is_packed else self.faces)

    @property
    def packed(self) -> Packed:
        return self.faces if self.is_packed else _packed.of_rows(self.faces)


class Surface:
    """Collects pieces of surface, and counts what has none."""

    def __init__(self, part: str) -> None:
        self._part = part
        self._pieces: list[_Piece] = []
        self._counts: dict[str, int] = {}
        self.holder = ""  # of the meshes: "a list", "blocks"; "": there is one mesh
        self.points = 0  # that no face needs
        self.lines = 0
        self.joins = 0  # of strips, and strips without a triangle

    def add(self, place: Place, vertices: Any, faces: Union[Any, Packed], unit: Optional[str]) -> None:
        """Adds a mesh, or a cloud without faces. `vertices` and `faces`: as _arrays or _packed returned them."""
        if isinstance(faces, Packed) and faces.are_triangles:
            faces = faces.corners.reshape(-1, 3)
        self._pieces.append(_Piece(place.part, vertices, faces, unit))

    def count(self, what: str, number: int = 1) -> None:
        """Adds `number` to the count of a note."""
        if number:
            self._counts[what] = self._counts.get(what, 0) + number

    def source(self) -> Source:
        """All pieces as one mesh. Raises InputError when there is none."""
        pieces = self._measured()
        mesh = self._joined(pieces)
        mesh.unit = self._unit(pieces)
        has_faces = pieces[0].face_count > 0
        if self.holder:
            self.count(f"{'meshes' if has_faces else 'clouds'} of {self.holder}, measured as one", len(pieces))
        if has_faces:
            self.count(NO_SURFACE, self.points + self.lines + self.joins)
        mesh.counts = self._counts
        return mesh

    def _measured(self) -> list[_Piece]:
        """The pieces with faces; if none has any, the clouds."""
        with_faces = [piece for piece in self._pieces if piece.face_count]
        clouds = [piece for piece in self._pieces if not piece.face_count and len(piece.vertices)]
        if with_faces:
            self.count("meshes without faces, left out", len(self._pieces) - len(with_faces))
            return with_faces
        if self.lines:
            raise InputError(f"'{self._part}' {LINES_ALONE}", "empty-mesh")
        if self.joins or not self._pieces:
            raise InputError(f"'{self._part}' has no triangles", "empty-mesh")
        return clouds or self._pieces[:1]

    def _joined(self, pieces: list[_Piece]) -> Source:
        numpy = _arrays.numpy_module()
        if len(pieces) == 1:
            piece = pieces[0]
            return Polygons(piece.vertices, piece.faces) if piece.is_packed else Arrays.of_checked(piece.vertices, piece.faces)
        for piece in pieces:  # the engine knows no piece by its name
            used = piece.packed.corners if piece.face_count else numpy.arange(len(piece.vertices))
            _arrays.check_finite(piece.vertices, used, piece.part)
        vertices = numpy.concatenate([piece.vertices for piece in pieces])
        before = numpy.cumsum([0, *(len(piece.vertices) for piece in pieces)])
        if before[-1] >= 2**32:
            raise InputError(f"'{self._part}' has {before[-1]} vertices, more than 4294967295", "too-large")
        if any(piece.is_packed for piece in pieces):
            return Polygons(vertices, _packed.joined([piece.packed.moved(int(by)) for piece, by in zip(pieces, before)]))
        return Arrays.of_checked(vertices, numpy.concatenate(
            [piece.faces + numpy.uint32(by) for piece, by in zip(pieces, before)]))

    def _unit(self, pieces: list[_Piece]) -> Optional[str]:
        by_unit = {piece.unit: piece.part for piece in pieces}
        if len(by_unit) > 1:
            found = ", ".join(f"'{part}' {'names none' if unit is None else 'is in ' + repr(unit)}" for unit, part in by_unit.items())
            raise InputError(f"the meshes of '{self._part}' are in different units ({found}): convert them to one unit first",
                             "unit-conflict")
        return pieces[0].unit
