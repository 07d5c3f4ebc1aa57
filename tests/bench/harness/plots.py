"""The pictures of docs/benchmarks.md, as SVG that is the same for the same figures."""
import functools
import itertools
import math

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
OTHER_LOOKS = itertools.cycle((("#444444", "x"), ("#009e73", "v"), ("#cc79a7", "P"), ("#8c564b", "*")))
STAGE_COLOURS = {
    "read_a": "#bbbbbb",
    "read_b": "#888888",
    "build": "#e69f00",
    "traverse": "#56b4e9",
    "reduce": "#009e73",
    "certify": "#cc79a7",
}


@functools.cache
def _look(name):
    """Colour and marker of a line; a rival gets the next of OTHER_LOOKS, and keeps them."""
    return (COLOURS[name], MARKERS[name]) if name in COLOURS else next(OTHER_LOOKS)


def _style(name):
    colour, marker = _look(name.split("@")[0].split("+")[0])
    return {
        "color": colour,
        "marker": marker,
        "linestyle": "--" if "@" in name else "-",
        "label": name,
    }


def save(figure, path):
    figure.savefig(path, metadata={"Date": None, "Creator": None})
    pyplot.close(figure)
    return True


def panels(columns, height=3.2, width=3.6):
    figure, axes = pyplot.subplots(1, columns, figsize=(width * columns, height), squeeze=False)
    return figure, list(axes[0])


def ones(axis, value=1.0):
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
    """A point a pair."""
    found = _speedups(results, fast, rivals)
    if not found:
        return False
    sizes = {(pair, tol): triangles(by_name) for pair, tol, _, by_name in results.of("pairs")}
    shown = sorted({rival for rival, _, _ in found}, key=rivals.index)
    figure, axes = panels(len(shown))
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
        ones(axis)
        axis.legend(fontsize=7)
    return save(figure, path)


def speedup_histogram(results, path, fast, rivals):
    """On a logarithmic axis."""
    found = _speedups(results, fast, rivals)
    if not found:
        return False
    shown = sorted({rival for rival, _, _ in found}, key=rivals.index)
    figure, axes = panels(len(shown))
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
    return save(figure, path)


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
    save(figure, path)
    return drawn


def _linear_growth(axis):
    x, y = axis.lines[0].get_xdata(), axis.lines[0].get_ydata()
    axis.plot([x[0], x[-1]], [y[-1] * x[0] / x[-1], y[-1]], color="black", linewidth=0.6, linestyle=":", label="linear")


def scaling_tolerance(results, path):
    pairs = sorted({pair for pair, _, _, _ in results.of("tolerance")})
    if not pairs:
        return False
    figure, axes = panels(len(pairs))
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
    return save(figure, path)


def scaling_threads(results, path):
    """Speed-up over one thread against the threads asked for."""
    figure, (axis,) = panels(1, 3.4, 5)
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
    return save(figure, path)


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
    figure, (axis,) = panels(1, 0.6 + 0.32 * len(runs), 6.5)
    labels = [f"{kind}, {name}" for kind, name, _ in runs]
    left = [0.0] * len(runs)
    for stage in ("read_a", "read_b", *STAGES):
        widths = [run[stage] for _, _, run in runs]
        axis.barh(labels, widths, left=left, color=STAGE_COLOURS[stage], label=stage)
        left = [a + b for a, b in zip(left, widths)]
    axis.set(xlabel="seconds")
    axis.invert_yaxis()
    axis.legend(fontsize=7, ncol=6, loc="lower center", bbox_to_anchor=(0.5, 1))
    return save(figure, path)


def all_of(results, tightness_rows, folder):
    """Writes what there are figures for; the names of the files written."""
    from . import paper_plots

    rivals = ["cgal", "four_point", "triangle_set", *results.published()]
    drawn = {
        "tightness.svg": lambda path: paper_plots.tightness(tightness_rows, path),
        "speedup_by_size.svg": lambda path: speedup_by_size(results, path, "auto", rivals),
        "speedup_histogram.svg": lambda path: speedup_histogram(results, path, "auto", rivals),
        "paper_speedup.svg": lambda path: paper_plots.speedups(results, path),
        "placement.svg": lambda path: paper_plots.stages(results, path, "placement"),
        "resolution.svg": lambda path: paper_plots.stages(results, path, "resolution"),
        "scaling_triangles.svg": lambda path: scaling_triangles(results, path),
        "scaling_tolerance.svg": lambda path: scaling_tolerance(results, path),
        "scaling_threads.svg": lambda path: scaling_threads(results, path),
        "reading.svg": lambda path: reading(results, path),
    }
    folder.mkdir(parents=True, exist_ok=True)
    return [name for name, draw in drawn.items() if draw(folder / name)]
