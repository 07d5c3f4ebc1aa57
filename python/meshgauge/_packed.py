"""Cells with any number of corners in one row of integers, [n, i, j, k, ..., n, ...], as VTK has them."""

from __future__ import annotations

from typing import Any, NamedTuple

from meshgauge._arrays import as_array, numpy_module
from meshgauge._attributes import Place
from meshgauge.errors import InputError


class Packed(NamedTuple):
    """Cells whose corners are indices of vertices."""

    row: Any  # uint32: the number of corners and the corners of each cell
    starts: Any  # the place of each number of corners

    @property
    def counts(self) -> Any:
        return self.row[self.starts]

    @property
    def corners(self) -> Any:
        """The corners of all cells, one cell after the other."""
        is_corner = numpy_module().ones(len(self.row), bool)
        is_corner[self.starts] = False
        return self.row[is_corner]

    @property
    def are_triangles(self) -> bool:
        return bool((self.counts == 3).all())

    def moved(self, by: int) -> Packed:
        """The same cells of vertices that come `by` others later."""
        row = self.row + numpy_module().uint32(by)
        row[self.starts] = self.counts
        return Packed(row, self.starts)

    def select(self, wanted: Any) -> Packed:
        """The cells for which `wanted` is true."""
        numpy = numpy_module()
        counts = self.counts[wanted].astype(numpy.int64)
        row = self.row[numpy.repeat(wanted, self.counts.astype(numpy.int64) + 1)]
        return Packed(row, numpy.cumsum(counts + 1) - counts - 1)


def of_rows(rows: Any) -> Packed:
    """The rows (m, k) of an array of uint32 as cells of k corners."""
    numpy = numpy_module()
    count, corners = rows.shape
    row = numpy.empty((count, corners + 1), numpy.uint32)
    row[:, 0] = corners
    row[:, 1:] = rows
    return Packed(row.reshape(-1), numpy.arange(count) * (corners + 1))


def joined(parts: list[Packed]) -> Packed:
    numpy = numpy_module()
    if not parts:
        return Packed(numpy.empty(0, numpy.uint32), numpy.empty(0, numpy.int64))
    before = numpy.cumsum([0, *(len(part.row) for part in parts[:-1])])
    return Packed(numpy.concatenate([part.row for part in parts]),
                  numpy.concatenate([part.starts + moved for part, moved in zip(parts, before)]))


def cells(values: Any, vertex_count: int, place: Place, attribute: str, cell: str, least: int) -> Packed:
    """The cells of an attribute; none for None. `cell`: the word for one in messages; `least`: the corners that each has at
    least."""
    numpy = numpy_module()
    array = as_array(() if values is None else values, place.of(attribute))
    if array.size == 0:
        return joined([])
    if array.ndim != 1 or array.dtype.kind not in "iu":
        pair = ": give a pair, (vertices, faces)" if array.ndim == 2 and array.shape[1] == 3 else ""
        raise InputError(f"{place.of(attribute)} must be one row of integers, [n, i, j, k, ...], not {array.dtype} of the "
                         f"shape {array.shape}{pair}")
    starts = _starts(array, place, cell, least)
    is_corner = numpy.ones(len(array), bool)
    is_corner[starts] = False
    wrong = is_corner & ((array < 0) | (array >= vertex_count))
    if wrong.any():
        at = int(wrong.argmax())
        number = int(numpy.searchsorted(starts, at)) - 1
        raise InputError(f"{cell} {number} of '{place.part}' uses vertex {int(array[at])} of {vertex_count}",
                         "index-out-of-range", f"{cell} {number}")
    return Packed(array.astype(numpy.uint32), starts)


def cells_of_rows(rows: Any, vertex_count: int, place: Place, attribute: str, cell: str) -> Packed:
    """As cells(), for the rows (m, k) of an array of integers."""
    numpy = numpy_module()
    counts = numpy.full((len(rows), 1), rows.shape[1], numpy.int64)
    return cells(numpy.hstack((counts, rows.astype(numpy.int64))).reshape(-1), vertex_count, place, attribute, cell, 3)


def _starts(array: Any, place: Place, cell: str, least: int) -> Any:
    """Where each cell begins."""
    numpy = numpy_module()
    step = int(array[0]) + 1
    if step > least and len(array) % step == 0 and (array[::step] == step - 1).all():
        return numpy.arange(0, len(array), step)
    numbers, at = array.tolist(), 0
    starts: list[int] = []
    while at < len(numbers):
        corners = numbers[at]
        if corners < least or corners >= len(numbers) - at:
            raise InputError(f"{cell} {len(starts)} of '{place.part}' has {corners} corners, and {len(numbers) - at - 1} "
                             "numbers follow")
        starts.append(at)
        at += corners + 1
    return numpy.array(starts)


def triangles_of_strips(strips: Packed) -> tuple[Any, int]:
    """The triangles (m, 3) of strips, every second one reversed so that all face the same way, and the number of joins: of
    triangles with a repeated corner, which are left out (api/formats/polygons/polygons.h has the same rule)."""
    numpy = numpy_module()
    counts, corners = strips.counts.astype(numpy.int64), strips.corners
    place_in_strip = numpy.arange(len(corners)) - numpy.repeat(numpy.cumsum(counts) - counts, counts)
    at = numpy.flatnonzero(place_in_strip >= 2)
    before, previous, last = corners[at - 2], corners[at - 1], corners[at]
    is_even = place_in_strip[at] % 2 == 0
    made = numpy.stack((before, numpy.where(is_even, previous, last), numpy.where(is_even, last, previous)), axis=1)
    is_join = (before == previous) | (previous == last) | (before == last)
    return made[~is_join], int(is_join.sum())
