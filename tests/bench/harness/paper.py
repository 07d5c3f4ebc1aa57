"""The paper's evidence on our pairs, for tables and pictures: its Table 1 and its Figures 2 to 5, 8 and 9."""
import math
import statistics

from . import plan, text
from .results import Ratios

METHODS = ("four_point", "triangle_set")  # the paper's, and that of [TLK09]
# The paper's Table 1: finished by its four-point method, by Tang's, by both; mean speed-up; winnings.
TABLE1 = {
    "decimated": ("97.65 %", "91.05 %", "89.01 %", "4.38x", "–", "87.94 %"),
    "tetwild": ("97.49 %", "66.44 %", "65.28 %", "27.5x", "–", "97.86 %"),
}
GROUPS = 10  # of the pairs in the order of A's vertices, in Figures 3 and 4
SLOPE = -5.3e-6  # of Figure 2's trend line; the paper does not name the unit of its time


def speedups(results, experiment, tolerance):
    """{kind of pair: Ratios} of the four-point method over triangle-set, for each kind that has any."""
    every = results.ratios(experiment, tolerance, *METHODS)
    found = {kind: Ratios([t for t in every.triples if plan.paper_kind(t[0]) == kind]) for kind in (*TABLE1, "made")}
    return {kind: ratios for kind, ratios in found.items() if ratios}


def table1(results):
    rows = []
    settings = [("paper", tolerance, " of the unit, 180 s") for tolerance in results.tolerances("paper")]
    settings += [("pairs", tolerance, " of the diagonal, 60 s") for tolerance in results.tolerances()]
    for experiment, tolerance, unit in settings:
        kinds = speedups(results, experiment, tolerance)
        every = results.ratios(experiment, tolerance, *METHODS)
        if experiment == "pairs" and every:
            kinds["all pairs"] = every
        for kind, found in kinds.items():
            cells = [f"{own} / {theirs}" for own, theirs in zip(_speed(found), TABLE1.get(kind, ("–",) * 6))]
            rows.append((kind, f"{tolerance:g}{unit}", len(found.triples), *cells, text.ratio(found.most()[1])))
    header = ("finished: `four_point`", "`triangle_set`", "both", "mean speed-up", "geometric mean", "winnings")
    return text.table(("pairs", "tolerance", "count", *(f"{name}, here / paper" for name in header), "most"), rows)


def _speed(ratios):
    count = len(ratios.triples)
    done = [sum(run.finished for run in column) / count for column in list(zip(*ratios.triples))[1:]]
    parts = [text.percent(part) for part in (*done, len(ratios.both) / count)]
    return [*parts, text.ratio(ratios.mean()), text.ratio(ratios.geometric_mean()), text.percent(ratios.winnings())]


def by_rank(ratios):
    """[(rank by A's vertices, speed-up)] and the ten groups' [(their middle, their mean)]."""
    values = [slow.seconds / fast.seconds for _, fast, slow in sorted(ratios.both, key=lambda t: t[1]["vertices_a"])]
    count = min(GROUPS, len(values))
    cuts = [len(values) * k // count for k in range(count + 1)]
    groups = [((low + high + 1) / 2, statistics.fmean(values[low:high])) for low, high in zip(cuts, cuts[1:])]
    return list(enumerate(values, 1)), groups


# --- Figure 2 ---


def bounds(rows):
    """{group: {bound: (seconds, tau)}}: means on the paper's pair; medians over the other pairs."""
    found = {}
    for row in rows:
        name = row["strategy"] if row["strategy"] != "n_point" else f"{row['points']}-point"
        is_paper = row["pair"] == plan.TIGHTNESS_PAIR
        value = float(row["mean_tightness" if is_paper else "median_tightness"])
        group = found.setdefault(row["pair"] if is_paper else "other pairs", {})
        group.setdefault(name, []).append((float(row["seconds_per_bound"]), value))
    return {
        group: {name: tuple(map(statistics.median, zip(*points))) for name, points in by_name.items()}
        for group, by_name in found.items()
    }


def trend(by_name):
    """Slope, a second, and intercept of the straight line through the n-point bounds; None: fewer than two."""
    points = [point for name, point in by_name.items() if name.endswith("-point")]
    return statistics.linear_regression(*zip(*points)) if len(points) > 1 else None


def tightness(rows):
    cells = []
    found = bounds(rows)
    for group, by_name in found.items():
        for name, (seconds, tau) in by_name.items():
            cells.append((group, f"`{name}`", text.rounded(tau), text.seconds(seconds)))
    lines = [text.table(("pair", "bound", "tau", "time of a bound"), cells)]
    line = trend(found.get(plan.TIGHTNESS_PAIR, {}))
    if line:
        lines.append(
            f"\nTrend line through the n-point bounds of {plan.TIGHTNESS_PAIR}: {line.slope * 1e-6:.2g} a microsecond, "
            f"{line.slope * 1e-9:.2g} a nanosecond; the paper's: {SLOPE:g} a unit that it does not name."
        )
    return "\n".join(lines)


# --- Figures 8 and 9 ---


def stages(results, experiment):
    """{model: [(label, {contender: Result})]}, sorted by displacement or from fine to coarse."""
    found = {}
    for pair, _, _, by_name in results.of(experiment):
        first = next(iter(by_name.values()))
        base = pair.rpartition("/")[2]
        if experiment == "placement":
            shape, order, label = base.rpartition("_d")[0], first["at"], f"{first['at']:g}"
        else:
            name, times = plan.model(pair)
            shape = name or base.rpartition("_of_")[0].rpartition("_")[0] or base
            is_made = "_of_" in base
            label = f"dec{times}" if times else text.count(first["at"]) if is_made else "original"
            order = -first["at"] if is_made else times
        found.setdefault(shape, []).append((order, label, by_name))
    return {shape: [case[1:] for case in sorted(cases, key=lambda c: c[0])] for shape, cases in found.items()}


def stage_table(results, experiment):
    names = [name for name in (*METHODS, "auto") if name in results.contenders(experiment)]
    rows = [
        (shape, label, *(cell for name in names for cell in _stage_cells(by_name.get(name))))
        for shape, cases in stages(results, experiment).items()
        for label, by_name in cases
    ]
    what = "d" if experiment == "placement" else "A"
    header = [text_of for name in names for text_of in (f"`{name}`: traverse + reduce", "total", "culled")]
    return text.table(("model", what, *header), rows)


def subdivisions(results):
    """The sizes of the paper's Table 2, and what explains its Figure 9."""
    rows = []
    for shape, cases in stages(results, "resolution").items():
        for label, by_name in cases:
            runs = [by_name.get(name) for name in METHODS]
            counts = (run[field] if run and run.finished else None for run in runs for field in ("survivors", "subdivisions"))
            cells = ("–" if count is None else text.count(count) for count in counts)
            rows.append((shape, label, text.count(next(iter(by_name.values()))["triangles_a"]), *cells))
    header = (cell for name in METHODS for cell in (f"`{name}`: left by the traversal", "subdivisions"))
    return text.table(("model", "A", "triangles of A", *header), rows)


def _stage_cells(result):
    if result is None or not result.finished:
        return ("–", result.status if result else "–", "–")
    return (
        f"{text.seconds(result['traverse'])} + {text.seconds(result['reduce'])}",
        text.seconds(result.seconds),
        text.percent(result.culling()),
    )


# --- sentences ---


def sharing(results):
    """How many points `four_point` did not ask the tree for, because a neighbour had."""
    runs = [by_name["four_point"] for _, _, _, by_name in results.of("pairs") if "four_point" in by_name]
    runs = [run for run in runs if run.finished and run["cache_hits"] is not None]
    if not runs:
        return "*No figures: `four_point` was not measured.*"
    asked, shared, split = (int(sum(run[name] for run in runs)) for name in ("queries", "cache_hits", "subdivisions"))
    return (
        f"Over the {len(runs)} runs of `four_point` above: {text.count(split)} subdivisions, {text.count(asked)} queries, and "
        f"{text.count(shared)} points ({text.percent(shared / (asked + shared))} of all) that a neighbour had asked for."
    )


def distances(report):
    """The claim that a point-triangle distance is faster, by the micro-benchmarks of both."""
    times = {run["name"]: run["real_time"] for run in report.get("benchmarks", []) if "real_time" in run}
    point, triangle = (times.get("distance_" + name, math.nan) for name in ("point_triangle", "triangle_triangle"))
    if math.isnan(point) or math.isnan(triangle):
        return "*No figures: run `./dev bench micro`.*"
    return (
        f"`distance_point_triangle` {text.seconds(point * 1e-9)}, `distance_triangle_triangle` "
        f"{text.seconds(triangle * 1e-9)}: {text.ratio(triangle / point)}. The paper: 5 to 10 times."
    )
