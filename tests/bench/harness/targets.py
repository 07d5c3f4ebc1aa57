"""What the engine set out to reach, beside what was measured."""
import math
import statistics

from . import text
from .results import WRONG, doublings, slope, triangles

LARGE = 2000  # triangles of a pair: below, a run is mostly its start
LONG_SECONDS = 0.05
ENOUGH_SECONDS = 0.005  # a doubling from less says nothing: fixed costs and caches


def rows(results):
    """[(what, target, measured, met or None)]"""
    found = []
    for tolerance in results.tolerances():
        found += (
            _against(results.ratios("pairs", tolerance, "auto", "cgal"), results, tolerance, "CGAL", 45)
            + _against_published(results, tolerance)
            + _finishing(results, tolerance)
            + _against_four_point(results, tolerance)
        )
    return (
        found
        + _threads(results)
        + _zero(results)
        + _growth(results)
        + _memory(results)
        + _gate(results)
        + _reference(results)
    )


def table(results):
    verdicts = {True: "met", False: "**missed**", None: "–"}
    return text.table(
        ("what", "target", "measured", "verdict"), [(*row[:3], verdicts[row[3]]) for row in rows(results)]
    )


# Least geometric means over the faster of the published codes.
KINDS = {
    "decimate-half": 15,
    "resolution": 15,
    "smooth": 20,
    "far": 20,
    "placement": 20,
    "remesh": 8,
    "soup": 8,
}


def _against_published(results, tolerance):
    found = _against(results.over_published(tolerance), results, tolerance, "the faster published code", 20)
    for kind, least in KINDS.items() if found else ():
        ratios = results.over_published(tolerance, kind)
        if ratios:
            mean = ratios.geometric_mean()
            what = f"the same, {len(ratios.values)} pairs of kind {kind}, geometric mean"
            found.append((what, f"≥ {least}x", text.ratio(mean), mean >= least))
    return found


def _against(ratios, results, tolerance, rival, least_mean):
    if not ratios:
        return []
    mean = ratios.geometric_mean()
    sizes = {pair: triangles(by_name) for pair, _, _, by_name in results.of("pairs", tolerance)}
    large = {pair: value for pair, value in ratios.values.items() if sizes[pair] > LARGE}
    found = [
        (
            f"`auto` against {rival} at {tolerance:g}, {len(ratios.values)} pairs, geometric mean",
            f"≥ {least_mean}x",
            text.ratio(mean),
            mean >= least_mean,
        )
    ]
    if large:
        pair, least = min(large.items(), key=lambda item: item[1])
        found.append(
            (
                f"the same, least on {len(large)} pairs of more than 2,000 triangles",
                "≥ 3x",
                f"{text.ratio(least)} ({pair})",
                least >= 3,
            )
        )
    return found


def _finishing(results, tolerance):
    runs = [(pair, by_name["auto"]) for pair, _, _, by_name in results.of("pairs", tolerance) if "auto" in by_name]
    missed = [pair for pair, result in runs if not result.finished]
    measured = f"{len(runs) - len(missed)} of {len(runs)}" + (": not " + ", ".join(missed) if missed else "")
    return [(f"`auto` finishes at {tolerance:g}", "every pair", measured, not missed)] if runs else []


def _against_four_point(results, tolerance):
    ratios = results.ratios("pairs", tolerance, "auto", "four_point")
    if not ratios:
        return []
    mean = ratios.geometric_mean()
    return [(f"`auto` against `four_point` at {tolerance:g}, geometric mean", "≥ 8x", text.ratio(mean), mean >= 8)]


def _threads(results):
    ratios = [
        (slow.seconds / fast.seconds, fast["threads"])
        for experiment in ("pairs", "threads", "growth")
        for _, _, _, by_name in results.of(experiment)
        for fast, slow in [(by_name.get("auto@2"), by_name.get("auto"))]
        if fast and slow and fast.finished and slow.finished and slow.seconds > LONG_SECONDS
    ]
    if not ratios:
        return []
    mean = statistics.geometric_mean(value for value, _ in ratios)
    note = "" if all(used == 2 for _, used in ratios) else " (the engine used one)"
    return [
        (
            f"two threads against one, {len(ratios)} jobs above 50 ms, geometric mean",
            "≥ 1.75x",
            f"{text.ratio(mean)}, least {text.ratio(min(ratios)[0])}{note}",
            mean >= 1.75,
        )
    ]


def series(results, experiment, name, field="seconds", kind=None):
    """[(triangles, value)] of a contender in an experiment of made meshes."""
    return sorted(
        (triangles(by_name), by_name[name].seconds if field == "seconds" else by_name[name].peak_bytes())
        for _, _, _, by_name in results.of(experiment)
        if name in by_name and by_name[name].finished and kind in (None, by_name[name]["kind"])
    )


def _zero(results):
    found = []
    for kind, label in (("same", "identical meshes"), ("retriangulated", "re-triangulated planes")):
        points = series(results, "zero", "auto", kind=kind)
        if len(points) < 2:
            continue
        exponent = slope(points)
        n, value = min(points, key=lambda point: abs(math.log(point[0] / 8000)))
        found.append(
            (
                f"h = 0, {label}: exponent of time against triangles",
                "linear (≤ 1.1)",
                f"{exponent:.2f}; {text.seconds(value)} for {text.count(n)} triangles",
                exponent <= 1.1,
            )
        )
    return found


def _growth(results):
    points = series(results, "growth", "auto")
    factors = [(factor, x) for (x0, y0), (x, factor) in zip(points, doublings(points)) if y0 >= ENOUGH_SECONDS]
    if not factors:
        return []
    worst, at = max(factors)
    return [
        (
            "doubling both meshes, the largest growth between neighbours above 5 ms",
            "≤ 2.2x",
            f"{text.ratio(worst)} (to {text.count(at)} triangles)",
            worst <= 2.2,
        )
    ]


def bytes_per_triangle(points):
    """Bytes a triangle: the slope of a straight line through (triangles, peak bytes), which leaves out what every process takes."""
    return statistics.linear_regression(*zip(*points)).slope if len(points) > 1 else math.nan


def _memory(results):
    points = [point for point in series(results, "growth", "auto", "peak_bytes") if point[0] >= 50_000]
    value = bytes_per_triangle(points)
    if math.isnan(value):
        return []
    return [
        (
            "memory of the whole process a triangle, files and meshes included",
            "≤ 170 bytes",
            f"{value:.0f} bytes",
            value <= 170,
        )
    ]


def gate_ratios(results, gate):
    """{pair: seconds of converging / seconds until the gate is decided}"""
    converging = {
        pair: by_name["auto"] for pair, _, kind, by_name in results.of("gate") if kind == "" and "auto" in by_name
    }
    return {
        pair: converging[pair].seconds / by_name["auto"].seconds
        for pair, _, kind, by_name in results.of("gate")
        if kind == gate and pair in converging and converging[pair].finished and by_name["auto"].finished
    }


def _gate(results):
    by_gate = {gate: list(gate_ratios(results, gate).values()) for gate in ("2h", "h/2")}
    values = sum(by_gate.values(), [])
    if not values:
        return []
    mean = statistics.geometric_mean(values)
    apart = ", ".join(f"{gate} {text.ratio(statistics.geometric_mean(v))}" for gate, v in by_gate.items() if v)
    verdicts = [
        (pair, gate, by_name["auto"]["verdict"])
        for pair, _, gate, by_name in results.of("gate")
        if gate and by_name["auto"].finished
    ]
    wrong = [pair for pair, gate, verdict in verdicts if verdict == {"2h": "fail", "h/2": "pass"}[gate]]
    undecided = [f"{pair} at {gate}" for pair, gate, verdict in verdicts if verdict == "undecided"]
    measured = f"{text.ratio(mean)} ({apart})" + (", wrong verdict: " + ", ".join(wrong) if wrong else ", no wrong verdict")
    if undecided:
        measured += ", undecided as the tolerance was reached first: " + ", ".join(undecided)
    return [
        (
            f"gates at 2h and h/2 against converging to 1e-4, {len(values)} decisions, geometric mean",
            "≥ 2x",
            measured,
            mean >= 2 and not wrong,
        )
    ]


def _reference(results):
    runs = [
        (pair, result)
        for pair, _, _, by_name in results.of("pairs")
        for name, result in by_name.items()
        if name.startswith("auto") and result["reference_lower"] is not None and (result.finished or result.status == WRONG)
    ]
    wrong = sorted({pair for pair, result in runs if result.status == WRONG})
    return (
        [
            (
                "intervals of `auto` that meet reference.tsv",
                "all",
                f"{len(runs) - len(wrong)} of {len(runs)}" + (": not " + ", ".join(wrong) if wrong else ""),
                not wrong,
            )
        ]
        if runs
        else []
    )
