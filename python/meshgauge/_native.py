"""The engine, by ctypes: python/native.h says what each function does."""

from __future__ import annotations

import ctypes
import functools
import json
import os
import pathlib
from typing import Any

from meshgauge.errors import input_error

# Signals, such as Ctrl-C, are handled between two waits.
_TICK_MS = 50

_Doubles = ctypes.POINTER(ctypes.c_double)


class Mesh(ctypes.Structure):
    """meshgauge_mesh. `kept` holds the Python objects whose memory it borrows."""

    _fields_ = [("path", ctypes.c_char_p), ("bytes", ctypes.c_void_p), ("byte_count", ctypes.c_size_t),
                ("positions", ctypes.c_void_p), ("vertices", ctypes.c_size_t),
                ("triangles", ctypes.c_void_p), ("triangle_count", ctypes.c_size_t)]
    kept: tuple[Any, ...] = ()


@functools.lru_cache(maxsize=None)
def _library() -> ctypes.CDLL:
    library = ctypes.CDLL(str(pathlib.Path(__file__).with_name("libmeshgauge.so")))
    mesh, job = ctypes.POINTER(Mesh), ctypes.c_void_p
    for name, returned, taken in (
            ("version", ctypes.c_char_p, []), ("create", job, []),
            ("main", ctypes.c_int, [ctypes.c_int, ctypes.POINTER(ctypes.c_char_p)]),
            ("start", ctypes.c_int, [job, mesh, mesh, ctypes.c_char_p, ctypes.c_int]), ("wait", ctypes.c_int, [job, ctypes.c_int]),
            ("stop", None, [job]), ("answer", ctypes.c_char_p, [job, ctypes.POINTER(ctypes.c_char_p)]),
            ("at_vertices", ctypes.c_size_t, [job, ctypes.POINTER(_Doubles), ctypes.POINTER(_Doubles)]), ("free", None, [job])):
        function = getattr(library, "meshgauge_" + name)
        function.restype, function.argtypes = returned, taken
    return library


def version() -> str:
    return _library().meshgauge_version().decode()


def run_command(arguments: list[str]) -> int:
    """Runs the command line in this process and returns its exit code."""
    words = (ctypes.c_char_p * (len(arguments) + 1))(*map(os.fsencode, arguments), None)
    return int(_library().meshgauge_main(len(arguments), words))


class _Job:
    """A comparison on a thread of the engine. The job keeps the meshes until that thread has ended.

    An exception can occur after any call, since a signal's handler may raise one. So each call of the engine may be
    repeated, and only the destructor, which runs once, frees the job.
    """

    _handle = None

    def __init__(self, a: Mesh, b: Mesh) -> None:
        self._a, self._b, self._kept = a, b, (a.kept, b.kept)
        self._library = _library()
        self._free = self._library.meshgauge_free
        self._handle = self._library.meshgauge_create()
        if not self._handle:
            raise MemoryError("no memory for a comparison")

    def __del__(self) -> None:
        if self._handle:
            self._free(self._handle)

    def start(self, options: bytes, at_vertices: bool) -> None:
        if not self._library.meshgauge_start(self._handle, self._a, self._b, options, at_vertices):
            raise RuntimeError("no thread can be started for a comparison")

    def wait(self) -> bool:
        return bool(self._library.meshgauge_wait(self._handle, _TICK_MS))

    def stop(self) -> None:
        self._library.meshgauge_stop(self._handle)

    def answer(self) -> dict[str, Any]:
        problem = ctypes.c_char_p()
        result = self._library.meshgauge_answer(self._handle, problem)
        if result is not None:
            return json.loads(result)
        refusal = json.loads(problem.value or b"{}")
        raise input_error(refusal) or RuntimeError(refusal.get("detail", "the comparison failed unexpectedly"))

    def at_vertices(self) -> tuple[Any, Any]:
        """The distance of each vertex of a, and the same with signs or None: arrays of numpy."""
        import numpy

        both = _Doubles(), _Doubles()
        count = self._library.meshgauge_at_vertices(self._handle, *both)
        distances, with_signs = (numpy.ctypeslib.as_array(one, (count,)).copy() if one else None for one in both)
        return distances, with_signs


def measure(a: Mesh, b: Mesh, options: dict[str, Any], at_vertices: bool) -> tuple[dict[str, Any], Any, Any]:
    """Compares two meshes and returns the result document, and at_vertices() of the job if asked for. An exception in
    between, such as KeyboardInterrupt, cancels the comparison."""
    job = _Job(a, b)
    try:
        job.start(json.dumps(options).encode(), at_vertices)
        while not job.wait():
            pass
        document = job.answer()
        return (document, *job.at_vertices()) if at_vertices else (document, None, None)
    finally:
        job.stop()
