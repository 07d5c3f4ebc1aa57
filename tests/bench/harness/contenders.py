"""What is measured: how each contender is called, and what it answers.

A contender is named STRATEGY[@THREADS][+SIMD]: `auto`, `auto@2`, `four_point`, `auto+scalar`; `cgal`, the peer; or as a
rival was named (rivals.py).
"""
import dataclasses
import hashlib
import json
import math
import pathlib
import re

from . import rivals

FINISHED = ("converged", "precision_floor", "gate_decided")
SAMPLED = "sampled"  # a rival's largest of some samples: a time and a lower bound
STAGES = ("build", "traverse", "reduce", "certify")
_NAME = re.compile(r"(?P<strategy>[a-z_]+)(?:@(?P<threads>\d+))?(?:\+(?P<simd>[a-z0-9_]+))?")


@dataclasses.dataclass(frozen=True)
class Limits:
    seconds: float = 60.0
    bytes: int = 6 << 30

    def text(self):
        return f"{self.seconds:g}s {self.bytes / (1 << 30):g}GiB"


@dataclasses.dataclass(frozen=True)
class Job:
    """One measurement: everything but the repetition."""

    experiment: str
    pair: object
    contender: str
    tolerance: float  # of A's diagonal
    gate: str = ""  # "2h" or "h/2": what max_distance is
    max_distance: float = math.nan
    series: str = ""  # a contender that fails in a series is not given what comes after
    absolute: bool = False  # the tolerance is a length in the files' unit
    seconds: float = math.nan  # the limit, if it is not that of all runs

    def limits(self, common):
        return common if math.isnan(self.seconds) else dataclasses.replace(common, seconds=self.seconds)


class Programs:
    """The executables of one build folder, and the rivals."""

    def __init__(self, build, given_rivals=()):
        build = pathlib.Path(build)
        self.meshgauge = build / "meshgauge"
        self.cgal = build / "tests/bench/bench_cgal"
        self.launch = build / "tests/bench/bench_launch"
        self.tightness = build / "tests/bench/bench_tightness"
        self.rivals = {rival.name: rival for rival in given_rivals}
        self.obj_files = rivals.ObjFiles(build / "tests/bench/bench_as_obj", build / "bench/obj")
        self._hashes = {}

    def of(self, contender):
        return self.cgal if contender == "cgal" else self.meshgauge

    def hash_of(self, contender):
        if contender not in self._hashes:
            if contender in self.rivals:
                self._hashes[contender] = self.rivals[contender].hash()
            else:
                self._hashes[contender] = hashlib.sha256(self.of(contender).read_bytes()).hexdigest()[:16]
        return self._hashes[contender]

    def has(self, contender):
        return contender in self.rivals or self.of(contender).exists()


STRATEGIES = ("auto", "four_point", "n_point", "triangle_set")


def is_name(text):
    """Whether a contender of the project or the peer may have this name."""
    return text == "cgal" or _NAME.fullmatch(text) is not None


def is_own(name):
    """Whether a rival may not have this name."""
    return name in (*STRATEGIES, "cgal")


def command(job, programs, limits):
    if job.contender in programs.rivals:
        return rivals.command(programs.rivals[job.contender], job, programs.obj_files, limits.seconds)
    a, b = str(job.pair.a), str(job.pair.b)
    if job.contender == "cgal":
        tolerance = job.tolerance
        if job.absolute:
            tolerance /= programs.obj_files.diagonal(job.pair.a)
        return [str(programs.cgal), a, b, repr(tolerance), repr(limits.seconds)]
    name = _NAME.fullmatch(job.contender)
    flags = [
        "--json",
        "--direction",
        "a_to_b",
        "--absolute" if job.absolute else "--diagonal",
        repr(job.tolerance),
        "--strategy",
        name["strategy"],
        "--threads",
        name["threads"] or "1",
        "--timeout-ms",
        str(int(1000 * limits.seconds)),
        "--memory-bytes",
        str(limits.bytes),
    ]
    if name["simd"]:
        flags += ["--simd", name["simd"]]
    if not math.isnan(job.max_distance):
        flags += ["--max-distance", repr(job.max_distance), "--fast"]
    return [str(programs.meshgauge), "compare", a, b, *flags]


def outcome(job, programs, stdout, stderr, report):
    """The fields of a run's row that the contender itself answers for."""
    try:
        if job.contender in programs.rivals:
            return rivals.outcome(stdout, programs.obj_files.diagonal(job.pair.a))
        answer = json.loads(stdout)
    except (ValueError, KeyError, TypeError):
        return {"status": _failure(stderr, report)}
    return _of_cgal(answer) if job.contender == "cgal" else _of_meshgauge(answer)


def _failure(stderr, report):
    if report["killed"]:
        return "timeout"
    if "bad_alloc" in stderr or "not enough memory" in stderr:
        return "memory"
    return "crash" if report["signal"] else "error"


def _of_cgal(answer):
    if answer["status"] != "converged":
        return {"status": answer["status"]}
    return {
        "status": "converged",
        "seconds": answer["seconds"],
        "prepare": answer["prepare_seconds"],
        "lower": answer["distance"],
        "upper": answer["distance"],
        "diagonal": answer["diagonal"],
        "threads": 1,
        "triangles_a": answer["faces_a"],
        "triangles_b": answer["faces_b"],
    }


def _of_meshgauge(answer):
    times = {stage: answer["timings_ms"][stage] / 1000 for stage in (*STAGES, "read_a", "read_b", "total")}
    directed, engine, meshes = answer["a_to_b"], answer["engine"], answer["meshes"]
    return {
        "status": answer["status"],
        "seconds": sum(times[stage] for stage in STAGES),
        **times,
        "lower": answer["distance"]["lower"],
        "upper": answer["distance"]["upper"],
        "diagonal": meshes["a"]["diagonal"],
        "verdict": answer["verdict"] or "",
        "triangles_a": meshes["a"]["triangles"],
        "triangles_b": meshes["b"]["triangles"],
        "vertices_a": meshes["a"]["vertices"],
        "survivors": directed["culling"]["survivors"],
        "queries": directed["work"]["nearest_queries"],
        "cache_hits": directed["work"]["cache_hits"],
        "subdivisions": directed["work"]["subdivisions"],
        "threads": engine["threads"],
        "simd": engine["simd"],
    }
