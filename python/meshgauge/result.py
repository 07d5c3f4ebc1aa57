"""The result of a comparison, measured here or by a service."""

from __future__ import annotations

import json
import math
from typing import Any, NamedTuple, Optional

Point = tuple[float, float, float]


class Witness(NamedTuple):
    """A point of one mesh and the nearest point of the other: they are at least `lower` apart.

    Points are in the unit of the result. Triangles are 0-based indices into the mesh as read.
    """

    on: str  # "a" or "b": the mesh that `point` lies on
    point: Point
    triangle: int
    nearest: Point
    nearest_triangle: int


class Directed(NamedTuple):
    """The certified interval of one direction, in the unit of the result.

    In a symmetric comparison the smaller direction is followed only as far as it matters, so its interval may be wide.
    """

    lower: float
    upper: float
    witness: Optional[Witness]


class Result:
    """A certified interval: the distance is at least `lower` and at most `upper`, whatever ended the work."""

    def __init__(self, document: dict[str, Any], vertex_distances: Any = None, signed_vertex_distances: Any = None) -> None:
        self._document = document
        self._vertex_distances, self._signed_vertex_distances = vertex_distances, signed_vertex_distances

    @property
    def document(self) -> dict[str, Any]:
        """The whole answer, as `meshgauge compare --json` and the service give it (docs/api.md).

        Of meshes that were given as arrays, `format` is "arrays", `sha256` is None and `bytes` is their size in memory;
        arrays with polygons of more than three corners are read as a "ply".
        """
        return self._document

    def json(self) -> str:
        """The document as JSON text."""
        return json.dumps(self._document)

    @property
    def lower(self) -> float:
        """Lower bound of the distance, in `unit`."""
        return float(self._document["distance"]["lower"])

    @property
    def upper(self) -> float:
        """Upper bound of the distance, in `unit`; infinite if none was reached in time."""
        return _bound(self._document["distance"]["upper"])

    @property
    def unit(self) -> Optional[str]:
        """Unit of all lengths and points: "um", "mm", "cm", "m", "in" or "ft"; None: the meshes' own numbers."""
        return self._document["unit"]["name"]

    @property
    def verdict(self) -> Optional[str]:
        """The worst of the criteria: "fail" if a limit is certainly exceeded or an expectation not met, "pass" if all certainly
        hold, else "undecided" (docs/metrology.md). None without a limit and without expect.
        """
        return self._document["verdict"]

    @property
    def status(self) -> str:
        """Why the work ended: "converged", "gate_decided", "timeout", "cancelled", "budget" or "precision_floor"."""
        return self._document["status"]

    @property
    def a_to_b(self) -> Optional[Directed]:
        """From all points of a to b; None if not asked for."""
        return _directed(self._document["a_to_b"], "a")

    @property
    def b_to_a(self) -> Optional[Directed]:
        """From all points of b to a; None if not asked for."""
        return _directed(self._document["b_to_a"], "b")

    @property
    def witness(self) -> Optional[Witness]:
        """Where `lower` is attained; None if no point was measured in time."""
        witnessed = [d for d in (self.a_to_b, self.b_to_a) if d is not None and d.witness is not None]
        return max(witnessed, key=lambda directed: directed.lower).witness if witnessed else None

    @property
    def vertex_distances(self) -> Any:
        """The distance of each vertex of a from b, in `unit`: an array of numpy (float64), in the order of a's vertices.
        Computed, not certified (docs/deviation.md). A vertex that no triangle uses has 0. None if not asked for.
        """
        return self._vertex_distances

    @property
    def signed_vertex_distances(self) -> Any:
        """The same, positive outside of b and negative inside; NaN where neither is proved. None where the sides of b were
        not asked for, and where it has none: document["sides"]["refused"] says why.
        """
        return self._signed_vertex_distances

    @property
    def regions(self) -> dict[str, dict[str, Any]]:
        """What was measured of each region, by its name, then of the "rest": a dict with "distance", "verdict", ... as
        in the HTTP API. Empty if none were asked for.
        """
        return {region["name"]: region for region in self._document.get("regions", [])}

    @property
    def criteria(self) -> list[dict[str, Any]]:
        """Each limit, then each expectation: a dict with "name", "limit", "lower", "upper", "verdict", "finding", ... as in
        the HTTP API (docs/api.md). `verdict` is the worst of them. Empty without a limit and without expect.
        """
        return list(self._document.get("criteria", []))

    @property
    def notes(self) -> list[str]:
        """Sentences on what was assumed, converted or left out: of the pair, then of each mesh."""
        meshes = self._document["meshes"]
        return [*self._document["notes"], *(f"{name}: {note}" for name in "ab" for note in meshes[name]["notes"])]

    @property
    def timings(self) -> dict[str, float]:
        """Wall time of each stage, in milliseconds."""
        return self._document["timings_ms"]

    def __repr__(self) -> str:
        unit = f" {self.unit}" if self.unit else ""
        verdict = f"{self.verdict}, " if self.verdict else ""
        return f"<meshgauge.Result {verdict}{self.lower!r} .. {self.upper!r}{unit}, {self.status}>"


def _bound(value: Optional[float]) -> float:
    return math.inf if value is None else float(value)


def _point(found: list[float]) -> Point:
    x, y, z = found
    return x, y, z


def _directed(directed: Optional[dict[str, Any]], on: str) -> Optional[Directed]:
    if directed is None:
        return None
    found = directed["witness"]
    witness = found and Witness(on, _point(found["point_a"]), found["triangle_a"], _point(found["point_b"]),
                                found["triangle_b"])
    return Directed(float(directed["lower"]), _bound(directed["upper"]), witness)
