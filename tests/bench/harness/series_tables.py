"""The Markdown tables of docs/benchmarks.md that are about series and stages, each by its name."""

import statistics

from . import targets, text
from .results import triangles
from .tables import time_of


def gate(results):
    rows = []
    for kind in ("2h", "h/2"):
        values = targets.gate_ratios(results, kind)
        if values:
            pair, least = min(values.items(), key=lambda item: item[1])
            rows.append(
                (
                    kind,
                    len(values),
                    text.ratio(statistics.geometric_mean(values.values())),
                    text.ratio(statistics.median(values.values())),
                    f"{text.ratio(least)} ({pair})",
                    sum(value < 1 for value in values.values()),
                )
            )
    return text.table(("limit", "decisions", "geometric mean", "median", "least", "slower than converging"), rows)


def _by_size(results, experiment, kind=None):
    names = results.contenders(experiment)
    cases = sorted(
        (
            (triangles(by_name), by_name)
            for _, _, _, by_name in results.of(experiment)
            if kind in (None, next(iter(by_name.values()))["kind"])
        ),
        key=lambda case: case[0],
    )
    rows = [(text.count(n), *(time_of(by_name.get(name)) for name in names)) for n, by_name in cases]
    return text.table(("triangles of both", *(f"`{name}`" for name in names)), rows)


def growth(results):
    return _by_size(results, "growth")


def zero(results):
    return (
        "Identical meshes:\n\n"
        + _by_size(results, "zero", "same")
        + "\n\nRe-triangulated planes:\n\n"
        + _by_size(results, "zero", "retriangulated")
    )


def tolerance(results):
    return "![against tolerance](benchmarks/scaling_tolerance.svg)" if results.of("tolerance") else text.NO_FIGURES


def memory(results):
    rows = []
    for name in results.contenders("growth"):
        points = targets.series(results, "growth", name, "peak_bytes")
        large = [point for point in points if point[0] >= 50_000]
        if large:
            rows.append(
                (
                    f"`{name}`",
                    text.count(large[-1][0]),
                    f"{large[-1][1] / (1 << 20):.0f} MiB",
                    f"{targets.bytes_per_triangle(large):.0f}",
                )
            )
    return text.table(("contender", "triangles of the largest pair", "peak memory there", "bytes a triangle"), rows)


def reading(results):
    rows = []
    for _, _, _, by_name in results.of("reading"):
        for name, run in by_name.items():
            if run.finished:
                read = run["read_a"] + run["read_b"]
                rows.append(
                    (
                        run["kind"],
                        f"`{name}`",
                        text.count(triangles(by_name)),
                        text.seconds(run["read_a"]),
                        text.seconds(run["read_b"]),
                        *(text.seconds(stage) for stage in run.stages()),
                        text.seconds(run["total"]),
                        text.percent(read / run["total"]),
                    )
                )
    if not rows:
        return text.NO_FIGURES
    return "![stages](benchmarks/reading.svg)\n\n" + text.table(
        (
            "format",
            "contender",
            "triangles of both",
            "read_a",
            "read_b",
            "build",
            "traverse",
            "reduce",
            "certify",
            "total",
            "reading",
        ),
        rows,
    )


def micro(report):
    """The rows of a report of Google Benchmark."""
    rows = []
    for run in report.get("benchmarks", []):
        if run.get("run_type") == "iteration" and "error_occurred" not in run:
            factor = {"ns": 1e-9, "us": 1e-6, "ms": 1e-3, "s": 1}[run["time_unit"]]
            per, held = run.get("per_triangle"), run.get("bytes_per_triangle")
            rows.append(
                (
                    f"`{run['name']}`",
                    text.seconds(run["real_time"] * factor),
                    text.seconds(per) if per else "–",
                    f"{held:.0f}" if held else "–",
                )
            )
    return text.table(("benchmark", "time", "a triangle", "bytes a triangle"), rows)
