"""Pairs of meshes of all sizes, their options, and their true distance: exact, or the interval of `meshgauge compare`."""

import json
import subprocess
import sys

from processes import BINARY
from scratch import ROOT

sys.path[:0] = [str(ROOT / "tests/chaos"), str(ROOT / "tests/e2e")]
from harness import wavy_grid  # noqa: E402
from victim import square  # noqa: E402

DIRECTIONS = ("symmetric", "a_to_b", "b_to_a")
REFERENCE_DIAGONAL = "1e-6"  # how closely the truth is known, of the diagonal


class Pair:
    """Two meshes; `truth`: a direction to an interval that holds the distance."""

    def __init__(self, name, a, b, truth):
        self.name, self.a, self.b, self.truth = name, a, b, truth

    def contradicts(self, result, direction):
        """Whether two intervals contradict each other: both hold the distance, so they must meet."""
        lower, upper = result["distance"]["lower"], result["distance"]["upper"]
        least, most = self.truth[direction]
        return lower > most or (upper is not None and upper < least)

    def contradicts_verdict(self, verdict, gate, direction):
        least, most = self.truth[direction]
        return (verdict == "pass" and least > gate) or (verdict == "fail" and most <= gate)


def compare(folder, a, b, direction):
    files = [folder / "a.obj", folder / "b.obj"]
    for path, mesh in zip(files, (a, b)):
        path.write_bytes(mesh)
    done = subprocess.run([BINARY, "compare", *files, "--json", "--direction", direction, "--diagonal", REFERENCE_DIAGONAL],
                          capture_output=True, check=True)
    distance = json.loads(done.stdout)["distance"]
    return distance["lower"], distance["upper"]


def pairs(folder):
    """Pairs of flat squares, whose distance is exact, and pairs of wavy ones."""
    found = []
    for n, low, high in ((1, 0, 2), (2, 1, 1.5), (8, 3, 0.25), (30, 0, 7), (70, 2, 2.125)):
        truth = {direction: (abs(high - low),) * 2 for direction in DIRECTIONS}
        found.append(Pair("flat%d" % n, square(low, n), square(high, n), truth))
    for n, m, height, other in ((6, 5, 0.1, 0.2), (20, 25, 0.1, 0.12), (40, 40, 0.3, 0.1), (80, 60, 0.2, 0.21), (120, 130, 0.1, 0.13)):
        a, b = wavy_grid(n, height), wavy_grid(m, other)
        found.append(Pair("wavy%d" % n, a, b, {direction: compare(folder, a, b, direction) for direction in DIRECTIONS}))
    return found
