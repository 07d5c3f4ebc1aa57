"""A plugin for pytest: the fixture assert_mesh_close.

    def test_bracket(assert_mesh_close):
        assert_mesh_close(bracket(), "baselines/bracket.ply", max_distance="0.05 mm")

    def test_lid(assert_mesh_close):  # in test_parts.py: baselines/test_parts/test_lid.ply
        assert_mesh_close(lid(), max_distance="0.05 mm")

`pytest --meshgauge-update` writes the baselines that are missing or differ.
"""

from __future__ import annotations

import itertools
import json
import os
import pathlib
import subprocess
import sys
import tempfile
from typing import Any, Callable, Optional

import pytest

from meshgauge import _meshes, _options, compare
from meshgauge._baselines import Baseline, Run, default_place, digest_of, slug_of, suffix_of
from meshgauge.result import Result

_REPORT_SECONDS = 300.0  # pictures of large meshes take longer than the measurement
_DEFAULT: Any = object()  # in place of a path: the baseline that the test's module and name say
_WORKER_OUTPUT = "meshgauge_written"  # what a worker of xdist tells the process that reports


def pytest_addoption(parser: pytest.Parser) -> None:
    group = parser.getgroup("meshgauge")
    group.addoption("--meshgauge-update", action="store_true",
                    help="write the baselines of assert_mesh_close that are missing or differ by more than the limit")
    group.addoption("--meshgauge-reports", metavar="FOLDER",
                    help="where the HTML reports of failed comparisons and their pictures go; default: in pytest's cache")


def pytest_configure(config: pytest.Config) -> None:
    config.stash[_RUN] = Run(config)


def pytest_sessionfinish(session: pytest.Session) -> None:
    output = getattr(session.config, "workeroutput", None)
    if output is not None:
        output[_WORKER_OUTPUT] = session.config.stash[_RUN].written


@pytest.hookimpl(optionalhook=True)  # type: ignore[misc]
def pytest_testnodedown(node: Any, error: Any) -> None:
    node.config.stash[_RUN].written += getattr(node, "workeroutput", {}).get(_WORKER_OUTPUT, [])


def pytest_terminal_summary(terminalreporter: Any, config: pytest.Config) -> None:
    for path in config.stash[_RUN].written:
        terminalreporter.write_line(f"meshgauge: wrote {path}")


_RUN: Any = pytest.StashKey["Run"]()


@pytest.fixture
def assert_mesh_close(request: pytest.FixtureRequest) -> Callable[..., Result]:
    """assert_mesh_close(actual, expected, max_distance=None, *, cloud=False, **options): fails unless no point of either mesh is
    farther from the other than `max_distance`, and the other limits among the options hold. One limit must be given.

    Meshes and options are those of meshgauge.compare(). A relative path of `expected` begins at the folder of the test;
    without `expected` it is baselines/MODULE/TEST there, with the suffix that fits, and TEST+2 at the second such call.
    `cloud`: whether `actual` may be a point cloud, for a mesh that lost its faces looks the same. Returns the Result.
    """
    calls, defaults, reports = itertools.count(1), itertools.count(1), itertools.count(1)
    run = request.config.stash[_RUN]

    def check(actual: Any, expected: Any = _DEFAULT, max_distance: Optional[_options.Length] = None, *, cloud: bool = False,
              **options: Any) -> Result:
        __tracebackhide__ = True
        is_default = expected is _DEFAULT
        if is_default:
            expected = default_place(request, actual, next(defaults))
        baseline = Baseline(run, request, expected, next(calls), is_default)
        mesh: Any = baseline.mesh
        if baseline.is_missing:  # it is written when nothing else is wrong
            content = baseline.content_for(actual)
            mesh = actual if isinstance(actual, (str, os.PathLike)) else content
        result = compare(actual, mesh, max_distance, **options)
        if result.verdict is None:
            raise TypeError("assert_mesh_close needs a limit: max_distance, max_share_beyond or zone, or expect")
        found = result.document["meshes"]["a"]
        if found["triangles"] == 0 and found["format"] != "xyz" and not cloud:
            pytest.fail(f"actual has {found['vertices']} points and no faces; if it is a point cloud, declare it by cloud=True",
                        pytrace=False)
        if baseline.may_be_written and baseline.is_missing == (result.verdict == "pass"):
            baseline.write(actual)
            mesh = baseline.mesh
            result = compare(actual, mesh, max_distance, **options)
            if result.verdict != "pass" and baseline.writer:
                pytest.fail(f"the baseline {baseline.mesh} is that of {baseline.writer} as well, of another mesh: give each "
                            "its own", pytrace=False)
        if result.verdict != "pass":
            name = f"{slug_of(request.node.nodeid)}-{digest_of(request.node.nodeid)}-{next(reports)}.html"
            report = _Report(_folder_of_reports(request.config) / name, max_distance, {**options, "cloud": cloud})
            pytest.fail(_in_words(result, report.written(actual, mesh)), pytrace=False)
        return result

    return check


class _Report:
    """The HTML report of one failure, which the command writes."""

    def __init__(self, place: pathlib.Path, max_distance: Optional[_options.Length], options: dict[str, Any]) -> None:
        self._place = place
        self._max_distance = max_distance
        self._options = options

    def written(self, actual: Any, expected: Any) -> list[str]:
        """Writes it, and the picture beside it. Returns lines with their addresses, or why there is none: that must not hide
        the difference."""
        try:
            self._place.parent.mkdir(parents=True, exist_ok=True)
            # Beside the report, so that it is put there as a whole, also when another worker does the same.
            with tempfile.TemporaryDirectory(prefix=".meshgauge-", dir=self._place.parent) as folder:
                sources = _meshes.source_of(actual, "actual"), _meshes.source_of(expected, "expected")
                command = [sys.executable, "-m", "meshgauge", "check", _as_file(sources[0], folder, "actual"),
                           _as_file(sources[1], folder, "expected"), "--html=report.html", "--pictures=pictures",
                           *self._flags(*sources)]
                run = subprocess.run(command, cwd=folder, env=_environment(), capture_output=True, text=True,
                                     timeout=_REPORT_SECONDS)
                return self._taken(pathlib.Path(folder), run.stderr.strip())
        except (OSError, subprocess.TimeoutExpired) as trouble:
            return [f"report: none: {trouble}"]

    def _taken(self, folder: pathlib.Path, trouble: str) -> list[str]:
        report = folder / "report.html"
        if not report.exists():
            return [f"report: none: {trouble}"]
        lines = [f"report: {report.replace(self._place).as_uri()}"]
        for picture in (folder / "pictures").glob("*.png"):
            lines.append(f"picture: {picture.replace(self._place.with_suffix('.png')).as_uri()}")
        return lines

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


def _folder_of_reports(config: pytest.Config) -> pathlib.Path:
    folder = config.getoption("--meshgauge-reports")
    if folder is not None:
        return pathlib.Path(folder).absolute()
    cache = getattr(config, "cache", None)  # none with -p no:cacheprovider
    return cache.mkdir("meshgauge") if cache else pathlib.Path(tempfile.gettempdir()) / f"meshgauge-{os.getpid()}"


def _as_file(source: _meshes.Source, folder: str, name: str) -> str:
    if isinstance(source, _meshes.File):
        return os.path.abspath(os.fsdecode(source.path))
    path = pathlib.Path(folder) / (name + (suffix_of(source) or ".mesh"))
    path.write_bytes(source.to_file())
    return path.name


def _in_words(result: Result, report: list[str]) -> str:
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
    return "\n".join([*lines, *report])


def _point(point: Any) -> str:
    return "(" + ", ".join(f"{x:.9g}" for x in point) + ")"
