"""The pictures of the load test, as SVG, in the style of the benchmarks'."""
from harness import plots
from matplotlib import pyplot

COLOURS = {"small": "#0060a8", "stored": "tab:purple", "medium": "#d55e00", "mixed": "#7a7a00"}


def by_load(record, path):
    """Throughput, latency and refusals against the load that was offered."""
    mixes = [mix for mix in COLOURS if mix in record["capacity"]]
    figure, (through, latency, refusal) = pyplot.subplots(1, 3, figsize=(11, 3.2))
    for mix in mixes:
        runs = sorted((run for run in record["runs"] if run["mix"] == mix and run.get("multiple")), key=lambda r: r["multiple"])
        at = [run["multiple"] for run in runs]
        through.plot(at, [run["throughput"] / record["capacity"][mix] for run in runs], "o-", color=COLOURS[mix], label=mix)
        latency.plot(at, [run["p99"] for run in runs], "o-", color=COLOURS[mix], label=f"{mix}, p99")
        latency.plot(at, [run["p50"] for run in runs], "o--", color=COLOURS[mix], linewidth=0.8, label=f"{mix}, p50")
        told = [(run["multiple"], run["refusal_p99"]) for run in runs if run["refusal_p99"] is not None]
        if told:
            refusal.plot(*zip(*told), "o-", color=COLOURS[mix], label=mix)
    refusal.axhline(0.05, color="black", linewidth=0.8)
    through.set(xscale="log", xlabel="offered, in capacities", ylabel="answered, in capacities")
    latency.set(xscale="log", yscale="log", xlabel="offered, in capacities", ylabel="seconds, of what was accepted")
    refusal.set(xscale="log", yscale="log", xlabel="offered, in capacities", ylabel="seconds to a 503, p99")
    for axis in (through, latency, refusal):
        axis.set_xticks(record["multiples"], [f"{m:g}x" for m in record["multiples"]])
        axis.minorticks_off()
        axis.legend(fontsize=7)
    plots.save(figure, path)


def overload(record, path):
    """The heaviest phase of each mix, second by second."""
    top = max(record["multiples"])
    runs = [run for run in record["runs"] if run.get("multiple") == top]
    figure, axes = pyplot.subplots(2, len(runs), figsize=(3.6 * len(runs), 4.6), squeeze=False, sharex="col")
    for column, run in enumerate(runs):
        counts, times = axes[0][column], axes[1][column]
        at = range(len(run["seconds_by"]))
        counts.plot(at, [bin_["accepted"] for bin_ in run["seconds_by"]], color=COLOURS[run["mix"]], label="answered")
        counts.plot(at, [bin_["refused"] for bin_ in run["seconds_by"]], color="#888888", label="refused")
        times.plot(at, [bin_["p99"] for bin_ in run["seconds_by"]], color=COLOURS[run["mix"]])
        counts.set(title=f"{run['mix']}, {top:g}x", yscale="symlog", ylabel="a second" if not column else "")
        times.set(xlabel="seconds", ylabel="p99 of the accepted, s" if not column else "", ylim=(0, None))
        counts.legend(fontsize=7)
    plots.save(figure, path)


def soak(record, path):
    rows = record["soak"]["watched"]
    figure, axes = pyplot.subplots(1, 2, figsize=(8, 3))
    for axis, what, scale, title in zip(
        axes, ("memory", "descriptors"), (1 << 20, 1), ("memory of all processes, MiB", "descriptors")
    ):
        axis.plot([row["at"] / 60 for row in rows], [row[what] / scale for row in rows], linewidth=0.6, color="#0060a8")
        axis.set(xlabel="minutes", ylabel=title, ylim=(0, None))
    plots.save(figure, path)


def all_of(record, folder):
    folder.mkdir(parents=True, exist_ok=True)
    if any(run.get("multiple") for run in record["runs"]):
        by_load(record, folder / "load.svg")
        overload(record, folder / "load_overload.svg")
    if record.get("soak"):
        soak(record, folder / "load_soak.svg")
