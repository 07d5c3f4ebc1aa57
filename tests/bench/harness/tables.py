"""The Markdown tables of docs/benchmarks.md that are about the pairs, each by its name."""
import collections
import statistics

from . import targets, text
from .results import WRONG, height, triangles


def rivals(results):
    """All contenders but our own."""
    return [name for name in results.contenders() if not name.startswith("auto")]


def machine(results, sessions):
    used = {row["session"] for row in results.rows}
    rows = []
    for facts in sessions:
        if facts["session"] in used:
            load = max(row["load"] for row in results.rows if row["session"] == facts["session"])
            rows.append(
                (
                    facts["session"],
                    facts["processor"],
                    facts["cores"],
                    facts["memory"],
                    facts["kernel"],
                    facts["commit"],
                    facts["cgal"],
                    f"{load:.1f}",
                )
            )
    return text.table(
        ("session (UTC)", "processor", "cores", "memory", "kernel", "commit", "CGAL", "largest load"), rows
    )


def mixed(results):
    """Says whether all figures of a contender come from one build: a ratio should compare builds that ran in turn."""
    programs = collections.defaultdict(set)
    for by_name in results.cases.values():
        for name, result in by_name.items():
            is_other = name == "cgal" or name in results.published()
            programs[name if is_other else "meshgauge"].add(result["program"])
    several = [f"{name}: {len(found)}" for name, found in programs.items() if len(found) > 1]
    if several:
        return f"**The figures below come from several builds ({', '.join(several)}): not a record.**"
    return "All figures of one contender come from one build of it."


def finished(results):
    rows = []
    for tolerance in results.tolerances():
        for name in results.contenders():
            runs = [by_name[name] for _, _, _, by_name in results.of("pairs", tolerance) if name in by_name]
            if not runs:
                continue
            count = collections.Counter(run.status for run in runs if not run.finished)
            done = [run for run in runs if run.finished]
            rows.append(
                (
                    f"{tolerance:g}",
                    f"`{name}`",
                    len(runs),
                    text.percent(len(done) / len(runs)),
                    count.pop("timeout", 0),
                    count.pop("memory", 0),
                    count.pop(WRONG, 0),
                    sum(count.values()),
                    text.seconds(statistics.geometric_mean(run.seconds for run in done)) if done else "–",
                    text.seconds(sum(run.seconds for run in done)),
                    text.percent(statistics.median(run.spread for run in done)) if done else "–",
                )
            )
    return text.table(
        (
            "tolerance",
            "contender",
            "pairs",
            "finished",
            "over time",
            "over memory",
            "wrong intervals",
            "other end",
            "geometric mean",
            "sum",
            "spread of repetitions",
        ),
        rows,
    )


def process(results):
    """What the whole process took, reading included, on the pairs that every contender finishes."""
    rows = []
    for tolerance in results.tolerances():
        names = results.contenders()
        cases = [by_name for _, _, _, by_name in results.of("pairs", tolerance)]
        shared = [case for case in cases if all(name in case and case[name].finished for name in names)]
        for name in names if shared else ():
            runs = [case[name] for case in shared]
            peaks = [run.peak_bytes() / (1 << 20) for run in runs]
            rows.append(
                (
                    f"{tolerance:g}",
                    f"`{name}`",
                    len(runs),
                    *(text.seconds(sum(run.least(field) for run in runs)) for field in ("wall", "user", "system")),
                    f"{statistics.median(peaks):.0f} MiB",
                    f"{max(peaks):.0f} MiB",
                )
            )
    header = ("tolerance", "contender", "pairs", "wall", "user", "system", "median peak memory", "largest")
    return text.table(header, rows)


def speedups(results):
    rows = []
    for tolerance in results.tolerances():
        for rival in rivals(results):
            ratios = results.ratios("pairs", tolerance, "auto", rival)
            if not ratios:
                continue
            (least_pair, least), (most_pair, most) = ratios.least(), ratios.most()
            rows.append(
                (
                    f"{tolerance:g}",
                    f"`{rival}`",
                    len(ratios.values),
                    text.ratio(ratios.geometric_mean()),
                    text.ratio(ratios.median()),
                    f"{text.ratio(least)} ({least_pair})",
                    f"{text.ratio(most)} ({most_pair})",
                    len(ratios.below(1)),
                    sum(fast.finished and not slow.finished for _, fast, slow in ratios.triples),
                )
            )
    return text.table(
        (
            "tolerance",
            "over",
            "pairs both finish",
            "geometric mean",
            "median",
            "least",
            "most",
            "losses",
            "only `auto` finishes",
        ),
        rows,
    )


def by_kind(results):
    rows = []
    names = rivals(results)
    published = results.published()
    for tolerance in results.tolerances():
        kinds = collections.Counter(
            next(iter(by_name.values()))["kind"] for _, _, _, by_name in results.of("pairs", tolerance)
        )
        for kind, count in sorted(kinds.items()):
            columns = [results.ratios("pairs", tolerance, "auto", rival, kind) for rival in names]
            columns += [results.over_published(tolerance, kind)] if published else []
            cells = [text.ratio(ratios.geometric_mean()) if ratios else "–" for ratios in columns]
            rows.append((kind, f"{tolerance:g}", count, *cells))
    header = [f"over `{rival}`" for rival in names] + (["over the fastest of " + ", ".join(f"`{name}`" for name in published)] if published else [])
    return text.table(("kind", "tolerance", "pairs", *header), rows)


def samples(results):
    """How soon an interval is certified, beside programs that sample."""
    rows = []
    cases = {(pair, tolerance): by_name for pair, tolerance, _, by_name in results.of("pairs")}
    for name in sorted({name for by_name in results.samplers.values() for name in by_name}):
        for tolerance in results.tolerances():
            found = [
                (cases[pair, at]["auto"], by_name[name])
                for (_, pair, at, _), by_name in results.samplers.items()
                if at == tolerance and name in by_name and "auto" in cases.get((pair, at), {})
            ]
            found = [(own, sampled) for own, sampled in found if own.finished]
            if not found:
                continue
            ratios = [sampled.seconds / max(own.seconds, 1e-9) for own, sampled in found]
            short = [1 - sampled["lower"] / own["lower"] for own, sampled in found if own["lower"] > 0]
            rows.append(
                (
                    f"a certified answer before the samples of `{name}`",
                    f"{tolerance:g}",
                    f"{sum(ratio > 1 for ratio in ratios)} of {len(ratios)}",
                    text.ratio(statistics.geometric_mean(max(ratio, 1e-9) for ratio in ratios)),
                    text.ratio(min(ratios)),
                    text.percent(statistics.median(short)) if short else "–",
                    text.percent(max(short)) if short else "–",
                )
            )
    header = ("what", "tolerance", "pairs", "geometric mean", "least", "samples below `lower`: median", "most")
    return text.table(header, rows)


def losses(results):
    """Every pair on which a rival is faster, and every pair above 2,000 triangles on which CGAL is within 3x."""
    rows = []
    for tolerance in results.tolerances():
        cases = {pair: by_name for pair, _, _, by_name in results.of("pairs", tolerance)}
        for rival in rivals(results):
            ratios = results.ratios("pairs", tolerance, "auto", rival)
            for value, pair in ratios.below(3 if rival == "cgal" else 1):
                by_name = cases[pair]
                if value >= 1 and triangles(by_name) <= targets.LARGE:
                    continue
                auto = by_name["auto"]
                stages = " + ".join(text.seconds(stage) for stage in auto.stages()[:3])
                rows.append(
                    (
                        pair,
                        f"{tolerance:g}",
                        f"`{rival}`",
                        text.ratio(value),
                        text.count(triangles(by_name)),
                        f"{height(by_name):.1e}",
                        text.seconds(by_name[rival].seconds),
                        text.seconds(auto.seconds),
                        stages,
                    )
                )
    if not rows and results.of("pairs"):
        return "None."
    return text.table(
        (
            "pair",
            "tolerance",
            "rival",
            "speed-up",
            "triangles",
            "h / diagonal",
            "rival",
            "`auto`",
            "of that build + traverse + reduce",
        ),
        rows,
    )


def failures(results):
    rows = [
        (
            pair,
            f"{tolerance:g}",
            f"`{name}`",
            result.status,
            text.count(triangles(by_name)),
            f"{height(by_name):.1e}",
            time_of(by_name.get("auto")),
        )
        for tolerance in results.tolerances()
        for pair, _, _, by_name in results.of("pairs", tolerance)
        for name, result in by_name.items()
        if not result.finished
    ]
    if not rows and results.of("pairs"):
        return "None."
    return text.table(
        ("pair", "tolerance", "contender", "end", "triangles", "h / diagonal", "`auto`"),
        sorted(rows, key=lambda r: r[2]),
    )


def time_of(result):
    return "–" if result is None else text.seconds(result.seconds) if result.finished else result.status


def all_pairs(results):
    """Every pair, every contender: a page of its own."""
    parts = []
    for tolerance in results.tolerances():
        names = results.contenders()
        rows = []
        for pair, _, _, by_name in results.of("pairs", tolerance):
            auto = by_name.get("auto")
            interval = f"{auto['lower']:.6g} .. {auto['upper']:.6g}" if auto and auto["upper"] is not None else "–"
            rows.append(
                (
                    pair,
                    text.count(triangles(by_name)),
                    f"{height(by_name):.1e}",
                    *(time_of(by_name.get(name)) for name in names),
                    interval,
                )
            )
        parts.append(
            f"## Tolerance {tolerance:g} of the diagonal\n\n"
            + text.table(
                ("pair", "triangles", "h / diagonal", *(f"`{name}`" for name in names), "interval of `auto`"), rows
            )
        )
    return (
        "# Every pair\n\nFor users and contributors: every measurement of the pairs, one table a tolerance. Made by\n"
        "`./dev bench report`; [benchmarks.md](../benchmarks.md) says how.\n\n"
        + text.with_handicap("\n\n".join(parts), "../benchmarks.md")
        + "\n"
    )
