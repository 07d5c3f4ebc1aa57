"""What `./dev bench` measures: each experiment is a list of rounds, a round is a list of jobs that are interleaved.

An experiment is planned when its turn comes, so that it can use what earlier ones found.
"""
import dataclasses
import fnmatch
import re

from .contenders import FINISHED, Job
from .pairs import Pair

# name: what it shows
EXPERIMENTS = {
    "pairs": "every pair, every contender, both tolerances",
    "paper": "the paper's Table 1 at its settings: 1e-3 of the files' unit, 180 s",
    "gate": "a limit of 2h and of h/2, against converging",
    "growth": "time and memory against triangles",
    "zero": "h = 0: identical and re-triangulated meshes",
    "tolerance": "time against tolerance",
    "threads": "time against threads",
    "placement": "the paper's Figure 8: a mesh against itself, displaced",
    "resolution": "the paper's Figure 9: meshes of all resolutions against the finest",
    "reading": "end to end on large files of every format",
}


TIGHTNESS_PAIR = "res/hand_dec4"  # the pair of the paper's Figure 2


@dataclasses.dataclass(frozen=True)
class Profile:
    """How much of each experiment."""

    tolerances: tuple = (1e-4, 1e-6)
    sizes: tuple = tuple(1000 * 2**k for k in range(11))  # 1e3 .. 1e6 triangles
    zero_sizes: tuple = tuple(1000 * 2**k for k in range(9))
    tolerance_series: tuple = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8)
    paper_tolerance: float = 1e-3  # of the files' unit
    paper_seconds: float = 180
    tolerance_size: int = 32_000
    displacements: tuple = (0.0, *(k / 100 for k in range(1, 10)))
    placement_size: int = 32_000
    resolutions: tuple = tuple(1000 * 2**k for k in range(8))
    resolution_of: int = 128_000
    reading_size: int = 1_000_000
    reading_formats: tuple = (".obj", ".obj.gz", ".stl", ".ply", ".glb")
    thread_sizes: tuple = (64_000, 256_000, 1_024_000)
    most_bytes_of_tightness: int = 1 << 19  # of both files
    tightness_sample: int = 100  # triangles; all of TIGHTNESS_PAIR


QUICK = Profile(
    sizes=(1000, 2000),
    zero_sizes=(1000, 2000),
    tolerance_series=(1e-2, 1e-4),
    tolerance_size=1000,
    displacements=(0.0, 1e-3, 0.1),
    placement_size=1000,
    resolutions=(500, 1000),
    resolution_of=2000,
    reading_size=2000,
    thread_sizes=(2000,),
    tolerances=(1e-4,),
    paper_seconds=5,
    tightness_sample=20,
)


def paper_kind(name):
    """Which row of the paper's Table 1 a pair belongs to: "decimated", "tetwild" or, to try it, "made"; "": none."""
    kind, _, rest = name.partition("/")
    if kind in ("half", "decimate-half"):
        return "decimated"
    if kind == "made":
        return "made" if rest.startswith("near_") else ""
    return "tetwild" if rest.endswith("_ftet") or rest == "tw107100-tw107100_sf" else ""


def model(name):
    """The model that a pair of kind "resolution" decimates, and how often: ("hand", 2); (None, 0): none."""
    found = re.fullmatch(r"(?:.*/)?(.+)_dec(\d+)", name)
    return (found[1], int(found[2])) if found else (None, 0)


class Plan:
    def __init__(self, profile, pairs, made, names, cores, runs):
        """`names`: the contenders; `runs`: the store, of what is known already."""
        self.profile, self.pairs, self.made = profile, pairs, made
        self.names, self.cores, self.runs = names, cores, runs

    def rounds(self, experiment):
        return getattr(self, "_" + experiment)()

    def _series(self, experiment, pairs, tolerances, names=None, series=True):
        """Sorted from easy to hard."""
        return [
            [
                Job(experiment, pair, name, tolerance, series=experiment + "/" + pair.kind if series else "")
                for name in names or self.single()
            ]
            for tolerance in tolerances
            for pair in pairs
        ]

    def single(self):
        """The contenders on one thread."""
        return [name for name in self.names if "@" not in name]

    def own(self):
        return [name for name in self.names if name.startswith("auto")] or ["auto"]

    def _pairs(self):
        return self._series("pairs", self.pairs, self.profile.tolerances, self.names, series=False)

    def of_paper(self):
        """The contenders of the paper's figures: its two methods, and `auto` beside them."""
        return [name for name in ("four_point", "triangle_set", "auto") if name in self.names]

    def _paper(self):
        """The paper's pairs are decimated meshes and surfaces of TetWild's tetrahedral meshes."""
        return [
            [
                Job("paper", pair, name, self.profile.paper_tolerance, absolute=True, seconds=self.profile.paper_seconds)
                for name in self.of_paper()
            ]
            for pair in self.pairs
            if paper_kind(pair.name)
        ]

    def _gate(self):
        rounds = []
        for pair in self.pairs:
            h, diagonal = self._distance(pair)
            if h is None or h <= 1e-5 * diagonal:
                continue  # a limit of 0 is no gate
            limits = (("", float("nan")), ("2h", 2 * h), ("h/2", h / 2))
            rounds.append([Job("gate", pair, "auto", 1e-4, gate, limit) for gate, limit in limits])
        return rounds

    def _distance(self, pair):
        """h as well as it is known from the runs of `pairs`, and A's diagonal."""
        found = [
            row
            for row in self.runs.rows
            if row["pair"] == pair.name
            and row["experiment"] == "pairs"
            and row["contender"].startswith("auto")
            and row["status"] in FINISHED
        ]
        if not found:
            return None, None
        best = min(found, key=lambda row: row["upper"] - row["lower"])
        return (best["lower"] + best["upper"]) / 2, best["diagonal"]

    def _growth(self):
        return self._series("growth", [self.made.near(n) for n in self.profile.sizes], [1e-4], self.names)

    def _zero(self):
        sizes = self.profile.zero_sizes
        pairs = [self.made.same(n) for n in sizes] + [self.made.retriangulated(n) for n in sizes]
        return self._series("zero", pairs, [1e-6])

    def _tolerance(self):
        pairs = [self.made.near(self.profile.tolerance_size)]
        pairs += [pair for pair in self.pairs if fnmatch.fnmatch(pair.name, "remesh/tw107100-tw107100_sf")]
        return [
            [dataclasses.replace(job, series="tolerance/" + job.pair.name) for job in jobs]
            for jobs in self._series("tolerance", pairs, self.profile.tolerance_series)
        ]

    def _threads(self):
        counts = sorted({self.cores, *(2**k for k in range(self.cores.bit_length() + 1))})
        names = ["auto" if count == 1 else f"auto@{count}" for count in counts]
        large = (
            "decimate-half/armadillo_voxel1M*",
            "remesh/arm_voxel",
            "remesh/tw107100-tw107100_sf",
            "half/armadillo",
        )
        pairs = [self.made.near(n) for n in self.profile.thread_sizes]
        pairs += [pair for pair in self.pairs if any(fnmatch.fnmatch(pair.name, glob) for glob in large)]
        return self._series("threads", pairs, [1e-6], names, series=False)

    def _models(self):
        """{name: file} of the meshes that the corpus has in many resolutions, as the paper's Table 2 has."""
        found = {model(pair.name)[0]: pair.b for pair in self.pairs if pair.kind == "resolution"}
        return {name: mesh for name, mesh in found.items() if name}

    def _placement(self):
        far = self.profile.displacements
        pairs = [self.made.moved(name, mesh, d) for name, mesh in self._models().items() for d in far]
        pairs = pairs or [self.made.placed(self.profile.placement_size, d) for d in far]
        return self._series("placement", pairs, [1e-4], self.of_paper(), series=False)

    def _resolution(self):
        pairs = [Pair("res/" + name, "resolution", mesh, mesh) for name, mesh in self._models().items()]
        pairs += [pair for pair in self.pairs if pair.kind == "resolution" and model(pair.name)[0]]
        pairs = pairs or [self.made.resolution(n, self.profile.resolution_of) for n in self.profile.resolutions]
        return self._series("resolution", pairs, [1e-4], self.of_paper(), series=False)

    def _reading(self):
        pairs = [self.made.in_format(self.profile.reading_size, suffix) for suffix in self.profile.reading_formats]
        return self._series("reading", pairs, [1e-4], self.own(), series=False)
