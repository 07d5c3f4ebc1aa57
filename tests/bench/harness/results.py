"""From runs to figures: repetitions reduced to one, ratios pair by pair."""
import collections
import dataclasses
import math
import statistics

from .contenders import FINISHED, SAMPLED, STAGES, STRATEGIES

WRONG = "wrong interval"
NEWEST = ("program", "meshes", "limits")  # of these the newest counts


@dataclasses.dataclass
class Result:
    """A contender on a pair: the fastest of its repetitions."""

    rows: list

    def __post_init__(self):
        self.best = min(self.rows, key=lambda row: math.inf if row["seconds"] is None else row["seconds"])
        self.status = next((row["status"] for row in self.rows if row["status"] not in FINISHED), self.best["status"])

    @property
    def finished(self):
        return self.status in FINISHED

    def __getitem__(self, name):
        return self.best[name]

    @property
    def seconds(self):
        return self.best["seconds"]

    @property
    def spread(self):
        """How much slower the slowest repetition was."""
        return max(row["seconds"] for row in self.rows) / self.seconds - 1

    def least(self, name):
        return min(row[name] for row in self.rows)

    def peak_bytes(self):
        return max(row["peak_bytes"] for row in self.rows)

    def stages(self):
        return [self.best[stage] for stage in STAGES]

    def culling(self):
        """The share of A's triangles that the traversal culls; nan: the contender does not say."""
        survivors, count = self.best["survivors"], self.best["triangles_a"]
        return math.nan if survivors is None or not count else 1 - survivors / count

    def is_wrong(self, certified):
        """Whether the interval is none, or does not meet the reference's, without one that of `certified`, a result or None:
        then one of them is wrong."""
        low, high = self.best["reference_lower"], self.best["reference_upper"]
        if low is None and certified and certified.finished:
            low, high = certified["lower"], certified["upper"]
        if not self.finished or self.best["gate"]:
            return False
        if self.best["lower"] > self.best["upper"]:
            return True
        if low is None:
            return False
        slack = self.best["tolerance"] * self.best["diagonal"] if self.best["contender"] == "cgal" else 0
        return self.best["lower"] - slack > high or self.best["upper"] + slack < low


def select(rows):
    """{(experiment, pair, tolerance, gate): {contender: Result}}; of each the newest program, meshes and limits, and of a
    repetition the newest run. A wrong interval is a status of its own: it has not finished and takes part in no mean."""
    groups = collections.defaultdict(list)
    for row in rows:
        groups[row["experiment"], row["pair"], row["tolerance"], row["gate"], row["contender"]].append(row)
    found = collections.defaultdict(dict)
    for (*case, contender), group in groups.items():
        newest = [group[-1][name] for name in NEWEST]
        same = {row["repetition"]: row for row in group if [row[name] for name in NEWEST] == newest}
        found[tuple(case)][contender] = Result(list(same.values()))
    for by_name in found.values():
        wrong = [result for result in by_name.values() if result.is_wrong(by_name.get("auto"))]
        for result in wrong:  # marked when all are judged, since `auto` may be one of them
            result.status = WRONG
    return dict(found)


def fastest(results):
    """Of several contenders on a pair: the fastest that finishes, or else one that does not. None: there are none."""
    return min(results, key=lambda result: result.seconds if result.finished else math.inf, default=None)


class Results:
    def __init__(self, rows):
        self.rows = rows
        self.cases = select([row for row in rows if row["status"] != SAMPLED])
        self.samplers = select([row for row in rows if row["status"] == SAMPLED])

    def of(self, experiment, tolerance=None):
        """[(pair, tolerance, gate, {contender: Result})]"""
        return [
            (pair, tol, gate, by_name)
            for (name, pair, tol, gate), by_name in self.cases.items()
            if name == experiment and tolerance in (None, tol)
        ]

    def tolerances(self, experiment="pairs"):
        return sorted({tol for name, _, tol, _ in self.cases if name == experiment}, reverse=True)

    def contenders(self, experiment="pairs"):
        names = {name for case, by_name in self.cases.items() if case[0] == experiment for name in by_name}
        order = ("auto", "four_point", "triangle_set", "cgal")
        return sorted(
            names, key=lambda name: (order.index(name.split("@")[0]) if name.split("@")[0] in order else 99, name)
        )

    def ratios(self, experiment, tolerance, fast, slow, kind=None):
        return Ratios(
            [
                (pair, by_name[fast], by_name[slow])
                for pair, _, _, by_name in self.of(experiment, tolerance)
                if fast in by_name and slow in by_name and kind in (None, by_name[fast]["kind"])
            ]
        )

    def published(self):
        """The rivals that took part beside CGAL."""
        return [name for name in self.contenders() if name.partition("@")[0].partition("+")[0] not in (*STRATEGIES, "cgal")]

    def over_published(self, tolerance, kind=None):
        """Speed-ups of `auto` over the fastest of published() on each pair."""
        names = self.published()
        found = [
            (pair, by_name["auto"], fastest(by_name[name] for name in names if name in by_name))
            for pair, _, _, by_name in self.of("pairs", tolerance)
            if "auto" in by_name and kind in (None, by_name["auto"]["kind"])
        ]
        return Ratios([case for case in found if case[2]])


def triangles(by_name):
    """The triangles of both meshes. The peer drops degenerate ones, so the larger count is the files'."""
    counts = [
        result["triangles_a"] + result["triangles_b"]
        for result in by_name.values()
        if result["triangles_a"] is not None
    ]
    return int(max(counts)) if counts else 0


def height(by_name):
    """h as a part of A's diagonal, as well as it is known."""
    found = [result for result in by_name.values() if result["upper"] is not None and result["contender"] != "cgal"]
    if not found:
        return math.nan
    best = min(found, key=lambda result: result["upper"] - result["lower"])
    return (best["upper"] + best["lower"]) / 2 / best["diagonal"]


class Ratios:
    """seconds(slow) / seconds(fast), pair by pair, where both finish in a time that the clock resolves."""

    def __init__(self, triples):
        self.triples = triples
        self.both = [(pair, fast, slow) for pair, fast, slow in triples if fast.finished and slow.finished]
        self.values = {pair: slow.seconds / fast.seconds for pair, fast, slow in self.both if slow.seconds > 0}

    def __bool__(self):
        return bool(self.values)

    def geometric_mean(self):
        return statistics.geometric_mean(self.values.values())

    def mean(self):
        return statistics.fmean(self.values.values())

    def median(self):
        return statistics.median(self.values.values())

    def least(self):
        return min(self.values.items(), key=lambda item: item[1])

    def most(self):
        return max(self.values.items(), key=lambda item: item[1])

    def winnings(self):
        """The share of the pairs that `fast` wins, of those that both finish, as in the paper."""
        return sum(value > 1 for value in self.values.values()) / len(self.values) if self.values else math.nan

    def below(self, ratio):
        return sorted((value, pair) for pair, value in self.values.items() if value < ratio)


def slope(points):
    """The exponent of growth: the slope of the straight line through (log x, log y)."""
    logs = [(math.log(x), math.log(y)) for x, y in points]
    return statistics.linear_regression(*zip(*logs)).slope if len(logs) > 1 else math.nan


def doublings(points):
    """[(x, factor)]: how much y grows when x doubles, between neighbours in x."""
    points = sorted(points)
    return [
        (x1, (y1 / y0) ** (math.log(2) / math.log(x1 / x0)))
        for (x0, y0), (x1, y1) in zip(points, points[1:])
        if x1 > x0
    ]
