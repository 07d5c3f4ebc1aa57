"""A plugin for pytest: the fixture assert_mesh_close.

    def test_bracket(assert_mesh_close):
        assert_mesh_close(bracket(), "baselines/bracket.ply", max_distance="0.05 mm")

`pytest --meshgauge-update` writes the baselines that are missing or differ.
"""

from __future__ import annotations

import hashlib
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
from typing import Any, Callable, Optional

import pytest

from meshgauge import _meshes, _options, compare
from meshgauge.result import Result

_REPORT_SECONDS = 300.0  # pictures of large meshes take longer than the measurement
_LONGEST_NAME = 100  # bytes of a test's id in the name of a file; file systems take 143 to 255 in all


def pytest_addoption(parser: pytest.Parser) -> None:
    group = parser.getgroup("meshgauge")
    group.addoption("--meshgauge-update", action="store_true",
                    help="write the baselines of assert_mesh_close that are missing or differ by more than the limit")
    group.addoption("--meshgauge-reports", metavar="FOLDER",
                    help="where the HTML reports of failed comparisons go; default: in pytest's cache")


def pytest_configure(config: pytest.Config) -> None:
    config.stash[_WRITTEN] = []


def pytest_terminal_summary(terminalreporter: Any, config: pytest.Config) -> None:
    for path in config.stash[_WRITTEN]:
        terminalreporter.write_line(f"meshgauge: wrote {path}")


_WRITTEN: Any = pytest.StashKey["list[pathlib.Path]"]()


@pytest.fixture
def assert_mesh_close(request: pytest.FixtureRequest) -> Callable[..., Result]:
    """assert_mesh_close(actual, expected, max_distance=None, *, cloud=False, **options): fails unless no point of either mesh is
    farther from the other than `max_distance`, and the other limits among the options hold. One limit must be given.

    Meshes and options are those of meshgauge.compare(). A relative path of `expected` begins at the folder of the test.
    `cloud`: whether `actual` may be a point cloud, for a mesh that lost its faces looks the same. Returns the Result.
    """
    counted = iter(range(1, 1_000_000))

    def check(actual: Any, expected: Any, max_distance: Optional[_options.Length] = None, *, cloud: bool = False,
              **options: Any) -> Result:
        __tracebackhide__ = True
        baseline = _Baseline(request, expected)
        if baseline.is_missing:
            baseline.write(actual, "does not exist")
        result = compare(actual, baseline.mesh, max_distance, **options)
        if result.verdict is None:
            raise TypeError("assert_mesh_close needs a limit: max_distance, max_share_beyond or zone, or expect")
        found = result.document["meshes"]["a"]
        if found["triangles"] == 0 and found["format"] != "xyz" and not cloud:
            pytest.fail(f"actual has {found['vertices']} points and no faces; if it is a point cloud, declare it by cloud=True",
                        pytrace=False)
        if result.verdict != "pass" and baseline.may_be_written:
            baseline.write(actual, "differs")
            result = compare(actual, baseline.mesh, max_distance, **options)
        if result.verdict != "pass":
            name = f"{_file_name(request.node.nodeid)}-{next(counted)}.html"
            report = _Report(_folder_of_reports(request.config) / name, max_distance, {**options, "cloud": cloud})
            pytest.fail(_in_words(result, report.written(actual, baseline.mesh)), pytrace=False)
        return result

    return check


class _Baseline:
    """What a mesh is compared with. It may be written if it is a path and --meshgauge-update is given."""

    def __init__(self, request: pytest.FixtureRequest, expected: Any) -> None:
        is_path = isinstance(expected, (str, os.PathLike))
        self.mesh = request.path.parent / expected if is_path else expected
        self.is_missing = is_path and not self.mesh.exists()
        self.may_be_written = is_path and request.config.getoption("--meshgauge-update")
        self._written = request.config.stash[_WRITTEN]

    def write(self, actual: Any, why: str) -> None:
        __tracebackhide__ = True
        if not self.may_be_written:
            pytest.fail(f"the baseline {self.mesh} {why}; pytest --meshgauge-update writes it", pytrace=False)
        source = _meshes.source_of(actual, "actual")
        suffix = _suffix(source)
        if suffix is not None and self.mesh.suffix.lower() != suffix:
            pytest.fail(f"the baseline {self.mesh} cannot be written: name it *{suffix}", pytrace=False)
        self.mesh.parent.mkdir(parents=True, exist_ok=True)
        staged = self.mesh.with_name(f".meshgauge-{os.getpid()}")  # whatever the length of the baseline's name
        staged.write_bytes(source.to_file())
        staged.replace(self.mesh)
        self._written.append(self.mesh)


class _Report:
    """The HTML report of one failure, which the command writes."""

    def __init__(self, place: pathlib.Path, max_distance: Optional[_options.Length], options: dict[str, Any]) -> None:
        self._place = place
        self._max_distance = max_distance
        self._options = options

    def written(self, actual: Any, expected: Any) -> str:
        """Writes it and returns its address, or why there is none: that must not hide the difference."""
        try:
            self._place.parent.mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryDirectory(prefix="meshgauge-") as folder:
                sources = _meshes.source_of(actual, "actual"), _meshes.source_of(expected, "expected")
                command = [sys.executable, "-m", "meshgauge", "check", _as_file(sources[0], folder, "actual"),
                           _as_file(sources[1], folder, "expected"), f"--html={self._place}", *self._flags(*sources)]
                run = subprocess.run(command, cwd=folder, env=_environment(), capture_output=True, text=True,
                                     timeout=_REPORT_SECONDS)
            return self._place.as_uri() if self._place.exists() else f"none: {run.stderr.strip()}"
        except (OSError, subprocess.TimeoutExpired) as trouble:
            return f"none: {trouble}"

    def _flags(self, actual: _meshes.Source, expected: _meshes.Source) -> list[str]:
        given = {name: value for name, value in self._options.items() if name not in _NOT_OF_REPORTS}
        if given.get("units") is None:
            given["units"] = _meshes.units_of(actual, expected)
        sent = _options.document(max_distance=self._max_distance, **given)
        units = sent.pop("units", {})
        sides = {"candidate": "a", "baseline": "b"}
        flags = ([f"--unit={units}"] if isinstance(units, str)
                 else [f"--unit-{sides.get(name, name)}={unit}" for name, unit in units.items()])
        flags += ["--cloud"] if self._options["cloud"] else []
        flags += [f"--timeout={timeout} s"] if (timeout := self._options.get("timeout", 30.0)) else []
        return flags + [f"--{name.replace('_', '-')}={value if isinstance(value, str) else json.dumps(_in_percent(value))}"
                        for name, value in sent.items()]


# How the work is done, and what is measured besides the limits.
_NOT_OF_REPORTS = ("cloud", "tolerance", "timeout", "threads", "strategy", "points", "statistics", "areas", "topology", "sides",
                   "narrow", "vertex_distances")


def _in_percent(value: Any) -> Any:
    """As flags have it: shares of an area or of a volume with a '%'."""
    if not isinstance(value, dict):
        return value
    return {name: f"{100 * one!r} %" if name in ("share", "within") and not isinstance(one, str) else _in_percent(one)
            for name, one in value.items()}


def _environment() -> dict[str, str]:
    """In which another Python finds this package, however this one has."""
    places = [str(pathlib.Path(__file__).parents[1]), os.environ.get("PYTHONPATH", "")]
    return {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, places))}


def _file_name(nodeid: str) -> str:
    """Of a test, for any file system: a few characters, not too many, and other ones for another test."""
    name = re.sub(r"[^A-Za-z0-9_.-]+", "-", nodeid)
    if len(name) <= _LONGEST_NAME and re.fullmatch(r"[A-Za-z0-9_./:\[\]-]*", nodeid):
        return name
    return f"{name[:_LONGEST_NAME]}-{hashlib.sha256(nodeid.encode('utf-8', 'backslashreplace')).hexdigest()[:16]}"


def _folder_of_reports(config: pytest.Config) -> pathlib.Path:
    folder = config.getoption("--meshgauge-reports")
    if folder is not None:
        return pathlib.Path(folder).absolute()
    cache = getattr(config, "cache", None)  # none with -p no:cacheprovider
    return cache.mkdir("meshgauge") if cache else pathlib.Path(tempfile.gettempdir()) / f"meshgauge-{os.getpid()}"


def _suffix(source: _meshes.Source) -> Optional[str]:
    """The suffix that a baseline with the bytes of `source` must have; None: any, since its content says the format."""
    if isinstance(source, _meshes.File):
        return pathlib.Path(os.fsdecode(source.path)).suffix.lower()
    return None if isinstance(source, _meshes.Content) else ".ply"


def _as_file(source: _meshes.Source, folder: str, name: str) -> str:
    if isinstance(source, _meshes.File):
        return os.path.abspath(os.fsdecode(source.path))
    path = pathlib.Path(folder) / (name + (_suffix(source) or ".mesh"))
    path.write_bytes(source.to_file())
    return path.name


def _in_words(result: Result, report: str) -> str:
    unit = f" {result.unit}" if result.unit else ""
    criteria = sorted(result.criteria, key=lambda one: one["name"] != result.document["foremost"])
    lines = [f"{one['verdict']}: {one['finding']}" for one in criteria]
    worst = [one for one in criteria if one["verdict"] == criteria[0]["verdict"]]
    witness = next((one["witness"] for one in worst if one.get("witness")), None)
    if witness:
        names = {"a": ("actual", "expected"), "b": ("expected", "actual")}[witness["on"]]
        found = f"look at {_point(witness['point'])}{unit} on triangle {witness['triangle']} of {names[0]}"
        if witness["nearest_point"]:
            found += (f": the nearest point of {names[1]} is {_point(witness['nearest_point'])}{unit} on triangle "
                      f"{witness['nearest_triangle']}")
        lines.append(found)
    lines += [f"note: {note}" for note in result.notes]
    return "\n".join([*lines, f"report: {report}"])


def _point(point: Any) -> str:
    return "(" + ", ".join(f"{x:.9g}" for x in point) + ")"
