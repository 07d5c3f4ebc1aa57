"""Attributes of objects of other libraries. Reading one runs code of that library, which may raise anything."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from meshgauge.errors import InputError


class Place(NamedTuple):
    """Where numbers come from, for messages."""

    part: str  # "a", "b[3]"
    owner: str = ""  # class of the object, "trimesh.base.Trimesh"; "": the numbers were given themselves

    def of(self, attribute: str) -> str:
        """"points of 'a' (pyvista.PolyData)"."""
        return f"{attribute} of '{self.part}'" + (f" ({self.owner})" if self.owner else "")


class Attributes:
    """The attributes of one object. Reads each once."""

    def __init__(self, mesh: Any, part: str) -> None:
        self.mesh = mesh
        self.place = Place(part, class_of(mesh))
        self._values: dict[str, Any] = {}

    @property
    def part(self) -> str:
        return self.place.part

    @property
    def owner(self) -> str:
        return self.place.owner

    def get(self, name: str) -> Any:
        """The attribute; None without it. Raises InputError when it cannot be read."""
        if name not in self._values:
            self._values[name] = guarded(self.place.of(name), lambda: getattr(self.mesh, name, None))
        return self._values[name]

    def data(self, name: str) -> Any:
        """The attribute; None without it, and for a method."""
        value = self.get(name)
        return None if callable(value) else value

    def has(self, *names: str) -> bool:
        return all(self.data(name) is not None for name in names)

    def has_method(self, *names: str) -> bool:
        return all(callable(self.get(name)) for name in names)

    def call(self, name: str) -> Any:
        """What the method returns without arguments."""
        return guarded(self.place.of(name + "()"), self.get(name))

    def said(self) -> str:
        """The beginning of a message about the object."""
        return f"'{self.part}' is a {self.owner}"


def class_of(mesh: Any) -> str:
    kind = type(mesh)
    return str(kind.__qualname__) if kind.__module__ == "builtins" else f"{kind.__module__}.{kind.__qualname__}"


def guarded(what: str, action: Callable[[], Any], problem: str = "cannot be read") -> Any:
    """The result of `action`, which may raise anything. Raises InputError with `what`, its problem and the cause."""
    try:
        return action()
    except (InputError, MemoryError):
        raise
    except Exception as defect:
        raise InputError(f"{what} {problem}: {_in_words(defect)}") from None


def _in_words(defect: Exception) -> str:
    try:
        return f"{type(defect).__name__}: {defect}"
    except Exception:
        return type(defect).__name__
