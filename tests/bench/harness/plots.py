"""The pictures of docs/benchmarks.md, as SVG that is the same for the same figures."""
import math
import re
import statistics

import matplotlib

matplotlib.use("svg")
from matplotlib import pyplot  # noqa: E402

from .contenders import STAGES  # noqa: E402
from .results import triangles  # noqa: E402

matplotlib.rcParams.update(
    {
        "svg.hashsalt": "meshgauge",
        "svg.fonttype": "none",
        "font.size": 9,
        "axes.grid": True,
        "grid.alpha": 0.3,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "figure.constrained_layout.use": True,
        "lines.markersize": 4,
        "font.family": "sans-serif",
        "figure.facecolor": "white",
    }
)
COLOURS = {"auto": "#0060a8", "four_point": "#d55e00", "triangle_set": "#7a7a00", "cgal": "#7b3fa0"}
MARKERS = {"auto": "o", "four_point": "s", "triangle_set": "^", "cgal": "D"}
STAGE_COLOURS = {
    "read_a": "#bbbbbb",
    "read_b": "#888888",
    "build": "#e69f00",
    "traverse": "#56b4e9",
    "reduce": "#009e73",
    "certify": "#cc79a7",
}


def _style(name):
    base = name.split("@")[0].split("+")[0]
    return {
        "color": COLOURS.get(base, "#444444"),
        "marker": MARKERS.get(base, "x"),
        "linestyle": "--" if "@" in name else "-",
        "label": name,
    }


def _save(figure, path):
    figure.savefig(path, metadata={"Date": None, "Creator": None})
    pyplot.close(figure)


def _panels(columns, height=3.2, width=3.6):
    figure, axes = pyplot.subplots(1, columns, figsize=(width * columns, height), squeeze=False)
    return figure, list(axes[0])


def _ones(axis, value=1.0):
    axis.axhline(value, color="black", linewidth=0.8)


def _speedups(results, fast, rivals):
    """(rival, tolerance, ratios) of the pairs that were measured."""
    every = [
        (rival, tolerance, results.ratios("pairs", tolerance, fast, rival))
        for rival in rivals
        for tolerance in results.tolerances()
    ]
    return [entry for entry in every if entry[2]]


def speedup_by_size(results, path, fast, rivals):
    """The paper's Figures 3 and 4: a point a pair."""
    found = _speedups(results, fast, rivals)
    if not found:
        return False
    sizes = {(pair, tol): triangles(by_name) for pair, tol, _, by_name in results.of("pairs")}
    shown = sorted({rival for rival, _, _ in found}, key=rivals.index)
    figure, axes = _panels(len(shown))
    for rival, tolerance, ratios in found:
        axis = axes[shown.index(rival)]
        axis.scatter(
            [sizes[pair, tolerance] for pair in ratios.values],
            list(ratios.values.values()),
            s=9,
            alpha=0.7,
            label=f"{tolerance:g}: geometric mean {ratios.geometric_mean():.3g}x",
        )
    for rival, axis in zip(shown, axes):
        axis.set(
            xscale="log",
            yscale="log",
            xlabel="triangles of both meshes",
            ylabel="speed-up",
            title=f"{fast} over {rival}",
        )
        _ones(axis)
        axis.legend(fontsize=7)
    return _save(figure, path) or True


def speedup_histogram(results, path, fast, rivals):
    """The paper's Figure 5, on a logarithmic axis."""
    found = _speedups(results, fast, rivals)
    if not found:
        return False
    shown = sorted({rival for rival, _, _ in found}, key=rivals.index)
    figure, axes = _panels(len(shown))
    logs = [math.log2(value) for _, _, ratios in found for value in ratios.values.values()]
    edges = [2.0**k for k in range(math.floor(min(logs)), math.ceil(max(logs)) + 2)]
    for rival, axis in zip(shown, axes):
        entries = [(tolerance, ratios) for name, tolerance, ratios in found if name == rival]
        axis.hist(
            [list(ratios.values.values()) for _, ratios in entries],
            edges,
            label=[f"{tolerance:g}" for tolerance, _ in entries],
        )
        axis.set(xlabel="speed-up", ylabel="pairs", title=f"{fast} over {rival}")
        axis.set_xscale("log", base=2)
        axis.axvline(1, color="black", linewidth=0.8)
        axis.legend(fontsize=7, title="tolerance")
    return _save(figure, path) or True


def _curves(axis, results, experiment, key, keep=lambda row: True):
    """A line a contender, of what it finished."""
    drawn = False
    for name in results.contenders(experiment):
        points = sorted(
            (key(result, by_name), result.seconds)
            for _, _, _, by_name in results.of(experiment)
            for result in [by_name.get(name)]
            if result and result.finished and keep(result)
        )
        if points:
            axis.plot(*zip(*points), **_style(name))
            drawn = True
    return drawn


def scaling_triangles(results, path):
    """Time and memory against triangles, with straight growth beside."""
    figure, axes = pyplot.subplots(2, 2, figsize=(8.4, 6.4))
    near, memory, same, flat = axes.flat
    size = lambda result, by_name: triangles(by_name)
    drawn = _curves(near, results, "growth", size)
    drawn |= _curves(same, results, "zero", size, lambda row: row["kind"] == "same")
    drawn |= _curves(flat, results, "zero", size, lambda row: row["kind"] == "retriangulated")
    for name in results.contenders("growth"):
        points = sorted(
            (triangles(by_name), by_name[name].peak_bytes() / 2**20)
            for _, _, _, by_name in results.of("growth")
            if name in by_name and by_name[name].finished
        )
        if points:
            memory.plot(*zip(*points), **_style(name))
    titles = ("near meshes, 1e-4 of the diagonal", "identical, 1e-6", "re-triangulated plane, 1e-6", "near meshes")
    for axis, title in zip((near, same, flat, memory), titles):
        axis.set(
            xscale="log",
            yscale="log",
            xlabel="triangles of both meshes",
            title=title,
            ylabel="peak memory of the process, MiB" if axis is memory else "seconds",
        )
        if axis.lines:
            _linear_growth(axis)
            axis.legend(fontsize=7)
    return _save(figure, path) or drawn


def _linear_growth(axis):
    x, y = axis.lines[0].get_xdata(), axis.lines[0].get_ydata()
    axis.plot([x[0], x[-1]], [y[-1] * x[0] / x[-1], y[-1]], color="black", linewidth=0.6, linestyle=":", label="linear")


def scaling_tolerance(results, path):
    pairs = sorted({pair for pair, _, _, _ in results.of("tolerance")})
    if not pairs:
        return False
    figure, axes = _panels(len(pairs))
    for pair, axis in zip(pairs, axes):
        _curves(
            axis,
            results,
            "tolerance",
            lambda result, _: result["tolerance"],
            lambda row, pair=pair: row["pair"] == pair,
        )
        axis.set(xscale="log", yscale="log", xlabel="tolerance, part of the diagonal", ylabel="seconds", title=pair)
        axis.invert_xaxis()
        axis.legend(fontsize=7)
    return _save(figure, path) or True


def scaling_threads(results, path):
    """Speed-up over one thread against the threads asked for."""
    figure, (axis,) = _panels(1, 3.4, 5)
    most = 1
    for pair, tolerance, _, by_name in results.of("threads"):
        one = by_name.get("auto")
        if not one or not one.finished:
            continue
        counts = {int(name.partition("@")[2] or 1): result for name, result in by_name.items() if result.finished}
        axis.plot(
            sorted(counts),
            [one.seconds / counts[n].seconds for n in sorted(counts)],
            marker="o",
            label=f"{pair}, {one.seconds:.2g} s",
        )
        most = max(most, *counts)
    if not axis.lines:
        pyplot.close(figure)
        return False
    axis.plot([1, most], [1, most], color="black", linewidth=0.6, linestyle=":", label="ideal")
    axis.set(xlabel="threads", ylabel="speed-up over one thread", xticks=range(1, most + 1))
    axis.legend(fontsize=6)
    return _save(figure, path) or True


def placement(results, path):
    """The paper's Figure 8: above, the time of each stage against the displacement; below, the culling rate."""
    found = [
        (by_name, experiment)
        for experiment in ("placement", "pairs")
        for _, tolerance, _, by_name in results.of(experiment)
        if next(iter(by_name.values()))["kind"] == "placement" and tolerance == 1e-4
    ]
    shapes = sorted({_shape(by_name) for by_name, _ in found})
    names = [
        name for name in ("auto", "four_point", "triangle_set", "cgal") if any(name in by_name for by_name, _ in found)
    ]
    if not shapes:
        return False
    figure, axes = pyplot.subplots(2, len(shapes), figsize=(3.4 * len(shapes), 5.4), squeeze=False, sharex="col")
    for column, shape in enumerate(shapes):
        time, culling = axes[0][column], axes[1][column]
        for name in names:
            runs = sorted(
                (
                    (by_name[name]["at"], by_name[name])
                    for by_name, _ in found
                    if _shape(by_name) == shape and name in by_name and by_name[name].finished
                ),
                key=lambda run: run[0],
            )
            if not runs:
                continue
            at = [d for d, _ in runs]
            time.plot(at, [run.seconds for _, run in runs], **_style(name))
            if name == "cgal":
                continue
            time.plot(at, [run["traverse"] for _, run in runs], color=COLOURS[name], linewidth=0.8, linestyle="--")
            time.plot(at, [run["reduce"] for _, run in runs], color=COLOURS[name], linewidth=0.8, linestyle=":")
            culling.plot(at, [100 * (1 - run["survivors"] / run["triangles_a"]) for _, run in runs], **_style(name))
        smallest = min(
            (
                by_name[name]["at"]
                for by_name, _ in found
                if _shape(by_name) == shape
                for name in by_name
                if by_name[name]["at"]
            ),
            default=1e-4,
        )
        for axis in (time, culling):
            axis.set_xscale("symlog", linthresh=smallest)
        time.set(yscale="log", title=shape, ylabel="seconds (dashed: traverse, dotted: reduce)" if not column else "")
        time.set_ylim(bottom=1e-5)  # less is no stage
        culling.set(
            xlabel="displacement d, part of the diagonal",
            ylabel="culling rate, %" if not column else "",
            ylim=(-3, 103),
        )
        time.legend(fontsize=7)
    return _save(figure, path) or True


def _shape(by_name):
    return next(iter(by_name.values()))["pair"].rpartition("_d")[0]


def resolution(results, path):
    """The paper's Figure 9: a mesh of each resolution against one fine one."""
    found = [
        by_name
        for experiment in ("resolution", "pairs")
        for _, tolerance, _, by_name in results.of(experiment)
        if next(iter(by_name.values()))["kind"] == "resolution" and tolerance == 1e-4
    ]
    shapes = sorted({_base(by_name) for by_name in found})
    if not shapes:
        return False
    figure, axes = _panels(len(shapes), 3.2, 3.4)
    for name_of_shape, axis in zip(shapes, axes):
        for name in ("auto", "four_point", "triangle_set", "cgal"):
            points = sorted(
                (by_name[name]["triangles_a"], by_name[name].seconds)
                for by_name in found
                if _base(by_name) == name_of_shape and name in by_name and by_name[name].finished
            )
            if points:
                axis.plot(*zip(*points), **_style(name))
        axis.set(xscale="log", yscale="log", xlabel="triangles of A", ylabel="seconds", title=name_of_shape)
        axis.legend(fontsize=7)
    return _save(figure, path) or True


def _base(by_name):
    """res/bunny_dec2 -> res/bunny, made/torus_1000_of_2000 -> made/torus"""
    return re.sub(r"_dec\d+$|_\d+_of_\d+$", "", next(iter(by_name.values()))["pair"])


def reading(results, path):
    """Where the time of `compare` goes on large files."""
    runs = [
        (run["kind"], name, run)
        for _, _, _, by_name in results.of("reading")
        for name, run in by_name.items()
        if run.finished
    ]
    if not runs:
        return False
    figure, (axis,) = _panels(1, 0.6 + 0.32 * len(runs), 6.5)
    labels = [f"{kind}, {name}" for kind, name, _ in runs]
    left = [0.0] * len(runs)
    for stage in ("read_a", "read_b", *STAGES):
        widths = [run[stage] for _, _, run in runs]
        axis.barh(labels, widths, left=left, color=STAGE_COLOURS[stage], label=stage)
        left = [a + b for a, b in zip(left, widths)]
    axis.set(xlabel="seconds")
    axis.invert_yaxis()
    axis.legend(fontsize=7, ncol=6, loc="lower center", bbox_to_anchor=(0.5, 1))
    return _save(figure, path) or True


def tightness(rows, path):
    """The paper's Figure 2: how tight a bound is against what it costs, the mean over the pairs."""
    groups = {}
    for row in rows:
        label = row["strategy"] if row["strategy"] != "n_point" else f"{row['points']}-point"
        groups.setdefault(label, []).append((float(row["seconds_per_bound"]), float(row["mean_tightness"])))
    if not groups:
        return False
    figure, (axis,) = _panels(1, 3.4, 5)
    for label, points in groups.items():
        cost = statistics.geometric_mean(max(cost, 1e-12) for cost, _ in points)
        value = statistics.fmean(value for _, value in points)
        axis.scatter([cost], [value], color=COLOURS["four_point" if "point" in label else "triangle_set"], zorder=3)
        axis.annotate(label, (cost, value), textcoords="offset points", xytext=(4, 4), fontsize=7)
    axis.set(xscale="log", xlabel="seconds a bound", ylabel="tightness (best bound / bound)")
    return _save(figure, path) or True


def all_of(results, tightness_rows, folder):
    """Writes what there are figures for; the names of the files written."""
    rivals = ["cgal", "four_point", "triangle_set"]
    drawn = {
        "tightness.svg": lambda path: tightness(tightness_rows, path),
        "speedup_by_size.svg": lambda path: speedup_by_size(results, path, "auto", rivals),
        "speedup_histogram.svg": lambda path: speedup_histogram(results, path, "auto", rivals),
        "paper_speedup_by_size.svg": lambda path: speedup_by_size(results, path, "four_point", ["triangle_set"]),
        "paper_speedup_histogram.svg": lambda path: speedup_histogram(results, path, "four_point", ["triangle_set"]),
        "placement.svg": lambda path: placement(results, path),
        "resolution.svg": lambda path: resolution(results, path),
        "scaling_triangles.svg": lambda path: scaling_triangles(results, path),
        "scaling_tolerance.svg": lambda path: scaling_tolerance(results, path),
        "scaling_threads.svg": lambda path: scaling_threads(results, path),
        "reading.svg": lambda path: reading(results, path),
    }
    folder.mkdir(parents=True, exist_ok=True)
    return [name for name, draw in drawn.items() if draw(folder / name)]
