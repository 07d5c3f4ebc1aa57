"""The options of a comparison as the JSON document of the service (openapi.yaml, Options)."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, Optional, Union

from meshgauge.errors import InputError

Length = Union[float, str]
Tolerance = Union[float, Mapping[str, float]]
Units = Union[str, Sequence[Optional[str]]]

_LENGTH = re.compile(r"\s*(\d+\.?\d*(?:[eE][+-]?\d+)?|\.\d+(?:[eE][+-]?\d+)?)\s*(\D*?)\s*")


def number(value: Any, name: str) -> float:
    """`value` as a finite float. Raises InputError, which names the option."""
    try:
        converted = float(value)
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"{name} must be a number, not {value!r}") from None
    if not math.isfinite(converted):
        raise InputError(f"{name} must be finite, not {value!r}")
    return converted


def _length(value: Length, name: str) -> tuple[float, str]:
    """Number and unit of a number or a text such as "0.05 mm"; without a unit, ""."""
    if not isinstance(value, str):
        return number(value, name), ""
    found = _LENGTH.fullmatch(value)
    if not found:
        raise InputError(f"{name} must be a length such as '0.05' or '0.05 mm', not {value!r}")
    return number(found[1], name), found[2]


def _signed_length(value: Length, name: str) -> tuple[float, str]:
    """As _length(), for a number that may have a sign."""
    if not isinstance(value, str):
        return number(value, name), ""
    text = value.strip()
    size, unit = _length(text[1:] if text[:1] in ("-", "+") else text, name)
    return -size if text.startswith("-") else size, unit


def _add(length: tuple[float, str], units: set[str]) -> float:
    """The number; its unit goes to `units`. 0 needs no unit."""
    if any(length):
        units.add(length[1])
    return length[0]


def gate(max_distance: Optional[Length] = None, max_share_beyond: Optional[Mapping[str, Any]] = None,
         zone: Optional[Sequence[Length]] = None,
         uncertainty: Optional[Length] = None, narrow: Optional[bool] = None,
         units: Optional[set[str]] = None) -> dict[str, Any]:
    """The limits, of which one is given at least, and the uncertainty of the distances. `units`: of other limits."""
    sent: dict[str, Any] = {}
    units = set(units or ())
    if max_distance is not None:
        sent["max_distance"], unit = _length(max_distance, "max_distance")
        units.add(unit)
    if max_share_beyond is not None:
        if not isinstance(max_share_beyond, Mapping) or set(max_share_beyond) != {"distance", "share"}:
            raise InputError(f"max_share_beyond must be a mapping such as {{'distance': '0.05 mm', 'share': 0.01}}, "
                             f"not {max_share_beyond!r}")
        distance = _length(max_share_beyond["distance"], "max_share_beyond['distance']")
        sent["max_share_beyond"] = {"distance": _add(distance, units),
                                    "share": number(max_share_beyond["share"], "max_share_beyond['share']")}
    if zone is not None:
        if isinstance(zone, str) or len(zone) != 2:
            raise InputError(f"zone must be two limits such as ('-0.05 mm', '0.1 mm'), not {zone!r}")
        sent["zone"] = [_add(_signed_length(end, f"zone[{i}]"), units) for i, end in enumerate(zone)]
    if uncertainty is not None:
        sent["uncertainty"] = _add(_length(uncertainty, "uncertainty"), units)
    if narrow is not None:
        sent["narrow"] = bool(narrow)
    if len(units) > 1:
        raise InputError("max_distance, the distance of max_share_beyond, zone, uncertainty and the limits of regions must have "
                         "the same unit")
    unit = units.pop() if units else ""
    return {**sent, **({"units": unit} if unit else {})}


def _regions(regions: Any) -> tuple[list[dict[str, Any]], set[str]]:
    """The regions to send, and the units of their limits."""
    if isinstance(regions, (str, Mapping)) or not isinstance(regions, Iterable):
        raise InputError(f"regions must be a list of mappings such as {{'name': 'bore', 'box': {{'min': [0, 0, 0], "
                         f"'max': [1, 1, 1]}}}}, not {regions!r}")
    sent = []
    units: set[str] = set()
    for index, region in enumerate(regions):
        if not isinstance(region, Mapping):
            raise InputError(f"regions[{index}] must be a mapping, not {region!r}")
        one = {str(name): plain(value) for name, value in region.items()}
        if one.get("max_distance") is not None:
            one["max_distance"] = _add(_length(region["max_distance"], f"regions[{index}]['max_distance']"), units)
        sent.append(one)
    return sent, units


def plain(value: Any) -> Any:
    """`value` with arrays as lists of numbers."""
    if isinstance(value, Mapping):
        return {str(name): plain(one) for name, one in value.items()}
    if isinstance(value, str) or not isinstance(value, Iterable):
        return value
    return [number(one, "a coordinate") for one in value]


def _tolerance(tolerance: Tolerance) -> dict[str, float]:
    if not isinstance(tolerance, Mapping):
        return {"absolute": number(tolerance, "tolerance")}
    return {str(rule): number(value, f"tolerance[{rule!r}]") for rule, value in tolerance.items()}


def _units(units: Units) -> dict[str, str]:
    pair = (units, units) if isinstance(units, str) else tuple(units)
    if len(pair) != 2:
        raise InputError(f"units must be one unit, or a pair of those of a and b, not {units!r}")
    return {name: unit for name, unit in zip("ab", pair) if unit is not None}


def _integer(value: Any, name: str) -> int:
    converted = number(value, name)
    if converted != int(converted):
        raise InputError(f"{name} must be an integer, not {value!r}")
    return int(converted)


def _timeout_ms(timeout: float) -> int:
    seconds = number(timeout, "timeout")
    if seconds <= 0:
        raise InputError(f"timeout must be more than 0 seconds, not {timeout!r}")
    return max(1, round(seconds * 1000))


def _statistics(statistics: Union[bool, Mapping[str, int]]) -> Any:
    if not isinstance(statistics, Mapping):
        return bool(statistics)
    return {str(name): _integer(value, f"statistics[{name!r}]") for name, value in statistics.items()}


def _sides(sides: Union[bool, Mapping[str, float]]) -> Any:
    if not isinstance(sides, Mapping):
        return bool(sides)
    return {str(name): number(value, f"sides[{name!r}]") for name, value in sides.items()}


def _areas(areas: Any) -> dict[str, Any]:
    if not isinstance(areas, Mapping):
        raise InputError(f"areas must be a mapping such as {{'beyond': [0.05]}}, not {areas!r}")
    sent: dict[str, Any] = {}
    for name, value in areas.items():
        if isinstance(value, bool):
            sent[str(name)] = value
        elif isinstance(value, Iterable) and not isinstance(value, str):
            sent[str(name)] = [number(one, f"areas[{name!r}]") for one in value]
        else:
            sent[str(name)] = number(value, f"areas[{name!r}]")
    return sent


def _align(align: Any) -> Any:
    """A word, a mapping as the service has it, or a 4x4 matrix: a transform in row-major order."""
    if isinstance(align, str):
        return align
    if not isinstance(align, Mapping):
        return {"transform": {"row_major": _matrix(align, "align")}}
    sent = dict(align)
    transform = sent.get("transform")
    if transform is not None and not isinstance(transform, Mapping):
        sent["transform"] = {"row_major": _matrix(transform, "align['transform']")}
    return plain(sent)


def _matrix(matrix: Any, name: str) -> list[float]:
    try:
        rows = [[number(one, name) for one in row] for row in matrix]
    except TypeError:
        rows = []
    if [len(row) for row in rows] != [4, 4, 4, 4]:
        raise InputError(f"{name} must be 'none', 'rigid', a mapping, or a 4x4 matrix")
    return [one for row in rows for one in row]


_TOLERANCE_OF_GATES = {"diagonal": 1e-9}
_TOLERANCE_OF_AREA = {"diagonal": 1e-3, "relative": 0.1}  # the distance is shown, and decides nothing

# A function for each option that is not sent as it is given.
_CONVERTED: dict[str, tuple[str, Callable[[Any], Any]]] = {
    "tolerance": ("tolerance", _tolerance),
    "timeout": ("timeout_ms", _timeout_ms),
    "units": ("units", _units),
    "threads": ("threads", lambda value: _integer(value, "threads")),
    "points": ("points", lambda value: _integer(value, "points")),
    "statistics": ("statistics", _statistics),
    "areas": ("areas", _areas),
    "sides": ("sides", _sides),
    "topology": ("topology", bool),
    "align": ("align", _align),
    "expect": ("expect", plain),
}


def document(**options: Any) -> dict[str, Any]:
    """The document of the options that are not None. Ranges and names are checked where it is read."""
    sent: dict[str, Any] = {}
    limits = {name: options.pop(name, None) for name in ("max_distance", "max_share_beyond", "zone", "uncertainty", "narrow")}
    units: set[str] = set()
    if (regions := options.pop("regions", None)) is not None:
        sent["regions"], units = _regions(regions)
    if any(limit is not None for limit in limits.values()):
        sent["gate"] = gate(**limits, units=units)
    for name, value in options.items():
        if value is None:
            continue
        key, converted = _CONVERTED.get(name, (name, str))
        sent[key] = converted(value)
    if "gate" in sent:  # as `meshgauge check`: the work shall end with a verdict, not with a narrow interval
        sent.setdefault("tolerance", dict(_TOLERANCE_OF_GATES if "max_distance" in sent["gate"] else _TOLERANCE_OF_AREA))
    return sent
