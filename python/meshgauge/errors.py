"""The exceptions of meshgauge."""

from __future__ import annotations

from typing import Any, Optional


class InputError(ValueError):
    """A mesh or an option is refused. The message names the defect: "vertex 17 of 'a' is NaN".

    Attributes:
        kind: the kind of the problem, such as "unreadable-mesh" or "unit-conflict" (docs/messages.md lists them).
        where: the place of the defect, such as "line 12" or "/tolerance/relative"; "" if unknown.
    """

    def __init__(self, message: str, kind: str = "invalid-request", where: str = "") -> None:
        super().__init__(message)
        self.kind = kind
        self.where = where


class ServiceError(RuntimeError):
    """A service could not be reached, or refused the request for a reason that is not in the meshes or options.

    Attributes:
        status: the HTTP status; None if there was no answer.
        kind: the kind of the problem, such as "unauthorized" or "overloaded"; "" if the answer names none.
        retry_after: seconds after which the service asks to try again; None if it does not say.
    """

    def __init__(self, message: str, status: Optional[int] = None, kind: str = "",
                 retry_after: Optional[float] = None) -> None:
        super().__init__(message)
        self.status = status
        self.kind = kind
        self.retry_after = retry_after


# The kinds of problems that are defects of the input: InputError, here and from a service.
INPUT_KINDS = frozenset((
    "invalid-request", "unit-conflict", "unsupported-format", "unreadable-mesh", "empty-mesh", "non-finite-vertex",
    "index-out-of-range", "coordinate-too-large", "too-large"))


def kind_of(problem: dict[str, Any]) -> str:
    """The last component of the problem's type: "/problems/not-found", before 0.2.0 "urn:meshgauge:problem:not-found"."""
    return str(problem.get("type", "")).rpartition("/")[2].rpartition(":")[2]


def input_error(problem: dict[str, Any]) -> Optional[Exception]:
    """The exception for a problem document about the input or its time; None for any other problem."""
    kind = kind_of(problem)
    detail = str(problem.get("detail") or problem.get("title") or kind)
    if kind == "out-of-time":
        return TimeoutError(detail)
    if kind not in INPUT_KINDS:
        return None
    items = problem.get("errors") or [{}]
    more = [str(item["message"]) for item in items[1:] if item.get("message")]  # all mistakes of the options at once
    return InputError("; ".join([detail, *more]), kind, str(items[0].get("where", "")))
