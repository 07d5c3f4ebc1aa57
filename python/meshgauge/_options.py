"""The options of a comparison as the JSON document of a request (openapi.yaml, Options), whose reader checks them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Optional, Union

from meshgauge.errors import InputError

Length = Union[float, str]
Tolerance = Union[float, Mapping[str, float]]
Units = Union[str, Sequence[Optional[str]]]


def plain(value: Any, name: str) -> Any:
    """`value` as JSON has it: arrays and other sequences as lists, numbers of any type as Python's.

    Raises InputError, which names the option, for what JSON cannot say.
    """
    if value is None or isinstance(value, (bool, str)):
        return value
    if isinstance(value, Mapping):
        return {str(key): plain(one, f"{name}.{key}") for key, one in value.items()}
    if hasattr(value, "tolist"):  # arrays and numbers of numpy
        value = value.tolist()
        if isinstance(value, bool):
            return value
    if isinstance(value, Iterable):
        return [plain(one, f"{name}[{i}]") for i, one in enumerate(value)]
    try:
        number = float(value)
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"{name} must be a number, not {value!r}") from None
    if not math.isfinite(number):
        raise InputError(f"{name} must be finite, not {value!r}")
    return int(number) if number.is_integer() and abs(number) < 2**53 else number


def _units(units: Units) -> Any:
    if isinstance(units, (str, Mapping)) or not isinstance(units, Sequence):
        return units
    pair = tuple(units)
    if len(pair) != 2:
        raise InputError(f"units must be one unit, or a pair of those of a and b, not {units!r}")
    return {name: unit for name, unit in zip("ab", pair) if unit is not None}


def _transform(value: Any) -> Any:
    """A 4x4 matrix as the 16 numbers of its rows; anything else as it is."""
    if isinstance(value, list) and len(value) == 4 and all(isinstance(row, list) and len(row) == 4 for row in value):
        return {"row_major": [one for row in value for one in row]}
    return value


def _align(align: Any) -> Any:
    """A word, a mapping as the service has it, or a 4x4 matrix."""
    if isinstance(align, list):
        return {"transform": _transform(align)}
    if isinstance(align, dict) and "transform" in align:
        return {**align, "transform": _transform(align["transform"])}
    return align


def document(**options: Any) -> dict[str, Any]:
    """The document of the options that are not None, in Python's own forms: a number as the tolerance is its width, units may be
    a pair, a transform a 4x4 matrix."""
    given = {name: value for name, value in options.items() if value is not None}
    if "units" in given:
        given["units"] = _units(given["units"])
    sent = {name: plain(value, name) for name, value in given.items()}
    if "tolerance" in sent and not isinstance(sent["tolerance"], dict):
        sent["tolerance"] = {"absolute": sent["tolerance"]}
    if "align" in sent:
        sent["align"] = _align(sent["align"])
    return sent
