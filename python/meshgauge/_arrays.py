"""Arrays of numpy from what users give: exact numbers in the layout of the engine, or InputError."""

from __future__ import annotations

import functools
import sys
from typing import Any

from meshgauge._attributes import Place, guarded
from meshgauge.errors import InputError


def numpy_module() -> Any:
    import numpy  # takes longer than everything else here, and files need it not

    return numpy


def is_array(values: Any) -> bool:
    """Whether `values` is an array of numpy. Does not import numpy, without which there is none."""
    numpy = sys.modules.get("numpy")
    return numpy is not None and isinstance(values, numpy.ndarray)


def address(array: Any) -> int:
    return int(array.__array_interface__["data"][0])


def as_array(values: Any, what: str) -> Any:
    numpy = numpy_module()
    if not is_array(values):
        values = _on_the_host(values, what)
    if numpy.ma.is_masked(values):
        raise InputError(f"{what} has masked elements")
    return guarded(what, lambda: numpy.asarray(values), "is no array of numbers")


def _on_the_host(values: Any, what: str) -> Any:
    """A tensor of Open3D or PyTorch, which may be on a GPU, as an array of numpy; anything else as it is."""
    for method in ("detach", "cpu", "numpy"):
        step = guarded(what, functools.partial(getattr, values, method, None))
        if callable(step):
            values = guarded(f"{method}() of {what}", step)
    return values


def vertices(values: Any, place: Place, attribute: str = "vertices") -> Any:
    """Exactly the given numbers as float64 of the shape (n, 3). Copies only what has another layout."""
    numpy = numpy_module()
    array = _checked(values, place.of(attribute), "fiu", "real numbers")
    converted = numpy.require(array, numpy.float64, ["C_CONTIGUOUS", "ALIGNED"])
    if array.dtype.itemsize > 8 or (array.dtype.kind in "iu" and array.dtype.itemsize == 8):
        with numpy.errstate(invalid="ignore"):
            inexact = (converted.astype(array.dtype) != array) & (array == array)
        if inexact.any():
            row = int(numpy.argmax(inexact.any(axis=1)))
            raise InputError(f"vertex {row} of '{place.part}' is no float64: round the {array.dtype} first")
    return converted


def triangles(values: Any, vertex_count: int, place: Place, attribute: str = "faces") -> Any:
    """uint32 indices of the shape (m, 3); none for None. Those of another type are checked before they lose their sign or
    their upper half."""
    numpy = numpy_module()
    array = as_array(() if values is None else values, place.of(attribute))
    if array.size == 0:
        return numpy.empty((0, 3), numpy.uint32)
    array = _checked(array, place.of(attribute), "iu", "integers")
    _check_indices(array, vertex_count, place)
    if array.dtype == numpy.int32:
        array = array.view(numpy.uint32)  # not negative: the same bits
    return numpy.require(array, numpy.uint32, ["C_CONTIGUOUS", "ALIGNED"])


def check_finite(points: Any, used: Any, part: str) -> None:
    """Raises InputError, as the engine does, for a vertex among `used` indices that is NaN or infinite."""
    numpy = numpy_module()
    finite = numpy.isfinite(points).all(axis=1)
    if finite.all():
        return
    wrong = used[~finite[used]]
    if wrong.size:
        vertex = int(wrong[0])
        what = "NaN" if numpy.isnan(points[vertex]).any() else "infinite"
        raise InputError(f"vertex {vertex} of '{part}' is {what}", "non-finite-vertex", f"vertex {vertex}")


def welded(corners: Any) -> tuple[Any, Any]:
    """Merges points (n, 3) at exactly the same position, in the order of their first appearance. Returns the points that are
    left, and for each of `corners` the index of its point."""
    numpy = numpy_module()
    order = numpy.lexsort(corners.T)  # stable: the first of equal corners comes first
    in_order = corners[order]
    begins = numpy.ones(len(corners), bool)
    begins[1:] = (in_order[1:] != in_order[:-1]).any(axis=1)
    firsts = order[begins]
    rank = numpy.empty(len(firsts), numpy.uint32)
    rank[numpy.argsort(firsts)] = numpy.arange(len(firsts), dtype=numpy.uint32)
    index = numpy.empty(len(corners), numpy.uint32)
    index[order] = rank[numpy.cumsum(begins) - 1]
    return corners[numpy.sort(firsts)], index


def _checked(values: Any, what: str, kinds: str, kinds_in_words: str) -> Any:
    """An array of the shape (n, 3), of numbers of these kinds."""
    array = as_array(values, what)
    if array.ndim != 2 or array.shape[1] != 3:
        raise InputError(f"{what} must have the shape (n, 3), not {array.shape}")
    if array.dtype.kind not in kinds:
        raise InputError(f"{what} must be {kinds_in_words}, not {array.dtype}")
    return array


def _check_indices(faces: Any, vertex_count: int, place: Place) -> None:
    unsigned = faces.view(faces.dtype.str.replace("i", "u"))  # a negative index becomes a large one
    if int(unsigned.max()) < vertex_count:
        return
    row = int(((faces < 0) | (faces >= vertex_count)).any(axis=1).argmax())
    index = next((int(i) for i in faces[row] if not 0 <= i < vertex_count), vertex_count)  # another thread may change it
    raise InputError(f"triangle {row} of '{place.part}' uses vertex {index} of {vertex_count}", "index-out-of-range",
                     f"triangle {row}")
