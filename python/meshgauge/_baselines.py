"""Baselines of tests of pytest: where they lie, and how they are written, each by one test alone."""

from __future__ import annotations

import contextlib
import fcntl
import hashlib
import os
import pathlib
import re
from collections.abc import Iterator
from typing import Any, Optional

import pytest

from meshgauge import _meshes

_FOLDER = "baselines"
_SUFFIXES = (".ply", ".stl", ".obj", ".off", ".glb", ".gltf", ".3mf", ".xyz", ".mesh")
_MOST_LETTERS = 100  # of a name of a file; file systems take 143 to 255 bytes in all


class Run:
    """A run of pytest, of which each worker of xdist has one of its own."""

    def __init__(self, config: pytest.Config) -> None:
        self.updates = bool(config.getoption("--meshgauge-update"))
        self.written: list[str] = []  # by this worker, and in the process that reports by all of them
        self._is_worker = hasattr(config, "workerinput")

    @contextlib.contextmanager
    def turn(self, request: pytest.FixtureRequest, place: pathlib.Path) -> Iterator[pathlib.Path]:
        """Excludes the other workers. Gives the file that holds which test has written `place` in this run, if one has."""
        base: pathlib.Path = request.getfixturevalue("tmp_path_factory").getbasetemp()
        folder = (base.parent if self._is_worker else base) / "meshgauge"
        folder.mkdir(exist_ok=True)
        with open(folder / "lock", "w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            yield folder / hashlib.sha256(os.fsencode(os.path.realpath(place))).hexdigest()


class Baseline:
    """What a mesh is compared with. It may be written if it is a path and --meshgauge-update is given."""

    def __init__(self, run: Run, request: pytest.FixtureRequest, expected: Any, call: int, is_default: bool) -> None:
        """`call`: from 1 on, of those of the test. `is_default`: the test's name says the path."""
        self._run, self._request = run, request
        is_path = isinstance(expected, (str, os.PathLike))
        self.mesh = request.path.parent / expected if is_path else expected
        self.is_missing = is_path and not self.mesh.exists()
        self.may_be_written = is_path and run.updates
        self._is_default = is_default
        self.writer: Optional[str] = None  # another test, or another call of this one, that has written it in this run
        self._test = request.node.nodeid + (f", call {call}" if call > 1 else "")

    def content_for(self, actual: Any) -> bytes:
        """What write() would write; fails the test if it could not."""
        __tracebackhide__ = True
        if not self.may_be_written:
            pytest.fail(f"the baseline {self.mesh} does not exist; pytest --meshgauge-update writes it", pytrace=False)
        source = _meshes.source_of(actual, "actual")
        suffix, content = suffix_of(source), source.to_file()
        why = ""
        if suffix is not None and self.mesh.suffix.lower() != suffix:
            why = f"remove it, so that *{suffix} takes its place" if self._is_default else f"name it *{suffix}"
        elif suffix == ".gltf" and _meshes.names_files(content):
            why = "actual is a glTF of several files; give a .glb"
        if why:
            pytest.fail(f"the baseline {self.mesh} cannot be written: {why}", pytrace=False)
        return content

    def write(self, actual: Any) -> None:
        """Writes it unless this run has done so for another test, which `writer` then names."""
        __tracebackhide__ = True
        content = self.content_for(actual)
        self.mesh.parent.mkdir(parents=True, exist_ok=True)
        with self._run.turn(self._request, self.mesh) as record:
            if record.exists() and (writer := record.read_text()) != self._test:
                self.writer = writer
                return
            staged = self.mesh.with_name(f".meshgauge-{os.getpid()}")  # whatever the length of the baseline's name
            staged.write_bytes(content)
            staged.replace(self.mesh)
            record.write_text(self._test)
        self._run.written.append(str(self.mesh))


def suffix_of(source: _meshes.Source) -> Optional[str]:
    """The suffix that a baseline with the bytes of `source` must have; None: any, since its content says the format."""
    if isinstance(source, _meshes.File):
        return pathlib.Path(os.fsdecode(source.path)).suffix.lower()
    return None if isinstance(source, _meshes.Content) else ".ply"


def default_place(request: pytest.FixtureRequest, actual: Any, number: int) -> pathlib.Path:
    """baselines/test_module/test_name beside the test, with the suffix of the file that is there, else with that of `actual`.
    `number`: from 1 on, of the test's default baselines."""
    __tracebackhide__ = True
    folder = request.path.parent / _FOLDER / request.path.stem
    name = _name_of_test(request.node.nodeid) + (f"+{number}" if number > 1 else "")
    there = [place for suffix in _SUFFIXES if (place := folder / (name + suffix)).exists()]
    if len(there) > 1:
        pytest.fail(f"there are {len(there)} baselines of this test, {' and '.join(map(str, there))}: remove all but one",
                    pytrace=False)
    return there[0] if there else folder / (name + _suffix_of_default(actual))


def _suffix_of_default(actual: Any) -> str:
    if isinstance(actual, (str, os.PathLike)):
        return pathlib.Path(actual).suffix.lower()
    return ".mesh" if isinstance(actual, (bytes, bytearray, memoryview)) else ".ply"


def _name_of_test(nodeid: str) -> str:
    """As a file's: "TestBox.test_lid-10" for test_it.py::TestBox::test_lid[10]. No two tests of a module have the same."""
    whole = nodeid.split("::", 1)[-1]
    name, bracket, parameters = whole.partition("[")
    plain = name.replace("::", ".") + (f"-{parameters[:-1]}" if bracket else "")
    slug = slug_of(plain)
    return slug if slug == plain else f"{slug}-{digest_of(whole)}"


def slug_of(text: str) -> str:
    return re.sub(r"[^A-Za-z0-9_.-]+", "-", text)[:_MOST_LETTERS]


def digest_of(text: str) -> str:
    """Eight digits that tell texts of one slug apart."""
    return hashlib.sha256(text.encode(errors="surrogatepass")).hexdigest()[:8]
