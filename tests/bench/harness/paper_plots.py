"""The pictures of the paper's figures, of our runs: 2, 3 to 5, 8 and 9."""
import math

from matplotlib import pyplot

from . import paper, plan
from .plots import COLOURS, STAGE_COLOURS, ones, panels, save

TOTAL_COLOUR = "#555555"


def tightness(rows, path):
    """Figure 2: by how much a bound exceeds the distance against its time, with the trend line."""
    found = paper.bounds(rows)
    if not found:
        return False
    figure, axes = panels(len(found))
    for axis, (group, by_name) in zip(axes, found.items()):
        for name, (seconds, tau) in by_name.items():
            axis.scatter([seconds], [tau], color=COLOURS["four_point" if "point" in name else "triangle_set"], zorder=3)
            axis.annotate(name, (seconds, tau), textcoords="offset points", xytext=(4, 4), fontsize=7)
        line = paper.trend(by_name) if group == plan.TIGHTNESS_PAIR else None
        if line:
            low, high = (pick(seconds for seconds, _ in by_name.values()) for pick in (min, max))
            at = [low * (high / low) ** (k / 50) for k in range(51)]
            label = f"trend, {line.slope * 1e-6:.2g} a microsecond"
            axis.plot(at, [line.intercept + line.slope * x for x in at], "--", color="black", linewidth=0.8, label=label)
            axis.legend(fontsize=7)
        axis.set(xscale="log", xlabel="seconds a bound", ylabel="tau = (upper - h) / h", title=group)
        axis.margins(x=0.25)
    return save(figure, path)


def speedups(results, path):
    """Figures 3 to 5: speed-ups by the rank of A's vertices, with the means of ten groups; their histogram."""
    found = {}
    for tolerance in results.tolerances("paper"):
        found |= paper.speedups(results, "paper", tolerance)
    found = {kind: ratios for kind, ratios in found.items() if all(t[1]["vertices_a"] is not None for t in ratios.both)}
    if not found:
        return False
    figure, axes = panels(len(found) + 1)
    for axis, (kind, ratios) in zip(axes, found.items()):
        points, groups = paper.by_rank(ratios)
        axis.scatter(*zip(*points), s=9, color=COLOURS["auto"])
        axis.plot(*zip(*groups), color="red", marker="o", label=f"means of {len(groups)} groups")
        axis.set(yscale="log", xlabel="pairs by vertices of A", ylabel="speed-up", title=f"four_point over triangle_set, {kind}")
        ones(axis)
        axis.legend(fontsize=7)
    logs = [math.log2(value) for ratios in found.values() for value in ratios.values.values()]
    edges = [2.0**k for k in range(math.floor(min(logs)), math.ceil(max(logs)) + 2)]
    axes[-1].hist([list(ratios.values.values()) for ratios in found.values()], edges, label=list(found))
    axes[-1].set(xlabel="speed-up", ylabel="pairs", title="histogram")
    axes[-1].set_xscale("log", base=2)
    axes[-1].legend(fontsize=7)
    return save(figure, path)


def stages(results, path, experiment):
    """Figures 8 and 9: a row a method; the stages as bars, the culling rate as a line."""
    found = paper.stages(results, experiment)
    methods = [name for name in paper.METHODS if name in results.contenders(experiment)]
    if not found or not methods:
        return False
    figure, grid = pyplot.subplots(
        len(methods), len(found), figsize=(4.2 * len(found), 2.9 * len(methods)), squeeze=False
    )
    for axes, method in zip(grid, methods):
        for axis, (shape, cases) in zip(axes, found.items()):
            _bars(axis, [(label, by_name[method]) for label, by_name in cases if method in by_name])
            axis.set(title=f"{shape}, {method}", ylabel="seconds", xlabel="d" if experiment == "placement" else "A")
    grid[0][-1].legend(fontsize=7, loc="center right")
    return save(figure, path)


def _bars(axis, cases):
    runs = [(at, run) for at, (_, run) in enumerate(cases) if run.finished]
    for k, (name, colour) in enumerate(
        (("traverse", STAGE_COLOURS["traverse"]), ("reduce", STAGE_COLOURS["reduce"]), ("total", TOTAL_COLOUR))
    ):
        heights = [run.seconds if name == "total" else run[name] for _, run in runs]
        axis.bar([at + 0.27 * (k - 1) for at, _ in runs], heights, 0.27, color=colour, label=name)
    axis.plot([], [], color="red", marker="o", label="culling rate, %")
    axis.set_xticks(range(len(cases)), [label for label, _ in cases], rotation=45, fontsize=7)
    culling = axis.twinx()
    culling.plot([at for at, _ in runs], [100 * run.culling() for _, run in runs], color="red", marker="o")
    culling.set(ylim=(-3, 103))
    culling.grid(False)
