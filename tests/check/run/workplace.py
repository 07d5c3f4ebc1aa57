"""A folder with meshes and a manifest, and the built `meshgauge check` on them."""

import json
import os
import pathlib
import subprocess
import tempfile
import unittest

from harness import BINARY, ENVIRONMENT

ROOM = {**ENVIRONMENT, "TERM": "dumb"}


def square(height=0.0, size=1.0, hole=False):
    """A square in the plane z = height, as an OBJ; `hole`: without one of its two triangles."""
    lines = ["v %r %r %r" % (x * size, y * size, height) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]
    return ("\n".join(lines + ["f 1 2 3"] + ([] if hole else ["f 1 3 4"])) + "\n").encode()


class Workplace(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.file("flat.obj", square())
        self.file("raised.obj", square(2.0))

    def file(self, name, data):
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data if isinstance(data, bytes) else data.encode())
        return str(path)

    def manifest(self, gates, defaults="", name="gates.yaml"):
        """`gates`: (name, candidate, baseline, limit[, further lines])."""
        text = "version: 1\n"
        if defaults:
            text += "defaults: {%s}\n" % defaults
        text += "gates:\n"
        for gate in gates:
            title, candidate, baseline, limit, *further = gate
            text += "  - name: %s\n    candidate: %s\n    baseline: %s\n    max_distance: %s\n" % (
                title, candidate, baseline, limit)
            text += "".join("    %s\n" % line for line in further)
        return self.file(name, text)

    def start(self, *arguments, environment=None, **how):
        how = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, **how}
        return subprocess.Popen([BINARY, "check", *map(str, arguments)], cwd=self.folder, text=True,
                                env={**ROOM, **(environment or {})}, **how)

    def check(self, *arguments, **how):
        process = self.start(*arguments, **how)
        out, err = process.communicate(timeout=120)
        return subprocess.CompletedProcess(arguments, process.returncode, out, err)

    def exits(self, code, *arguments, **how):
        result = self.check(*arguments, **how)
        self.assertEqual(result.returncode, code, (arguments, result.stdout, result.stderr))
        return result

    def report(self, code, *arguments, **how):
        """The whole report."""
        return json.loads(self.exits(code, *arguments, "--json", **how).stdout)

    def fails(self, *arguments, saying):
        """Nothing is measured, and standard error says why."""
        result = self.exits(3, *arguments)
        self.assertIn(saying, result.stderr)
        self.assertEqual(result.stdout, "")
        return result


def threads():
    return len(os.sched_getaffinity(0))
