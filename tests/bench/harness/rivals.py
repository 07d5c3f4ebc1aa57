"""Published codes beside CGAL: programs that are not part of the project, and records of runs made elsewhere.

A rival is given as NAME=COMMAND and called `COMMAND A.obj B.obj TOLERANCE LIMIT_S`: the largest upper - lower that is asked
for, a length in the files' unit, and the seconds after which it is to give up. It prints one line of JSON:

    {"status": "converged", "lower": 0.0101, "upper": 0.0102, "user_s": 0.12}

`user_s` is the time of the one call, its trees included, reading left out. A program that samples says `sampled` and leaves
`upper` out. Any other `status` (timeout, memory, error) needs no numbers. An interval that does not meet the reference's or
auto's is reported as wrong.
"""
import collections
import dataclasses
import hashlib
import json
import math
import pathlib
import re
import shlex
import shutil
import statistics
import subprocess

from . import pairs, text

_NAME = re.compile(r"[a-z][a-z0-9_-]*")


@dataclasses.dataclass(frozen=True)
class Rival:
    name: str
    command: tuple

    def hash(self):
        """Of the command line and of the program that it starts."""
        program = pathlib.Path(self.command[0])
        return hashlib.sha256(shlex.join(self.command).encode() + program.read_bytes()).hexdigest()[:16]


def parsed(argument, taken):
    """The rival of NAME=COMMAND. `taken`: whether a name is that of another contender."""
    name, is_given, command = argument.partition("=")
    words = shlex.split(command)
    if not is_given or not _NAME.fullmatch(name) or not words:
        raise SystemExit(f"bench: --rival takes NAME=COMMAND, the name of a-z, 0-9, _ and -; this is {argument!r}")
    if taken(name):
        raise SystemExit(f"bench: --rival {name}: a contender of the project has this name")
    program = shutil.which(words[0])
    if not program:
        raise SystemExit(f"bench: --rival {name}: no such program: {words[0]}")
    return Rival(name, (program, *words[1:]))


class ObjFiles:
    """Meshes as OBJ, each written once."""

    def __init__(self, program, folder):
        self.program, self.folder = program, folder

    def of(self, mesh):
        path = self.folder / (pairs.content_hash(mesh) + ".obj")
        if not path.exists():
            self.folder.mkdir(parents=True, exist_ok=True)
            half = path.with_name("half-written." + path.name)
            subprocess.run([self.program, mesh, half], check=True)
            half.rename(path)
        return path

    def diagonal(self, mesh):
        with self.of(mesh).open() as file:
            return float(file.readline().split()[2])


def command(rival, job, files, seconds):
    tolerance = job.tolerance * (1 if job.absolute else files.diagonal(job.pair.a))
    return [*rival.command, str(files.of(job.pair.a)), str(files.of(job.pair.b)), repr(tolerance), repr(seconds)]


def outcome(stdout, diagonal):
    """The fields of a run's row. Raises ValueError where the answer is not as agreed."""
    answer = json.loads(stdout)
    status = answer["status"] if isinstance(answer, dict) else None
    if not isinstance(status, str) or not re.fullmatch(r"[a-z_-]+", status):
        raise ValueError("no status")
    if status not in ("converged", "sampled"):
        return {"status": status}
    needed = ("user_s", "lower", "upper") if status == "converged" else ("user_s", "lower")
    numbers = {name: float(answer[name]) for name in needed}
    if not all(map(math.isfinite, numbers.values())) or numbers["user_s"] < 0:
        raise ValueError("not a number")
    return {
        "status": status,
        "seconds": numbers["user_s"],
        "lower": numbers["lower"],
        "upper": numbers.get("upper"),
        "diagonal": diagonal,
        "threads": 1,
    }


# --- records of runs made elsewhere ---


@dataclasses.dataclass(frozen=True)
class Record:
    """Lines of text and rows (pair, tolerance, {contender: seconds or None}); meshgauge is one of the contenders."""

    notes: list
    rows: list

    @classmethod
    def read(cls, path):
        """Tab-separated: lines of `#`, the last of them the columns: pair, tolerance, sizes, then one a contender."""
        lines = path.read_text().splitlines()
        comments = [line.lstrip("# ") for line in lines if line.startswith("#")]
        columns = comments[-1].split("\t") if comments else []
        if columns[:2] != ["pair", "tolerance"] or "meshgauge" not in columns:
            raise SystemExit(f"bench: {path}: its last line of # must name the columns: pair, tolerance, .., meshgauge")
        first = next(i for i, name in enumerate(columns) if i > 1 and "triangles" not in name and name != "of B")
        rows = []
        for number, line in enumerate(lines, 1):
            if not line or line.startswith("#"):
                continue
            cells = line.split("\t")
            if len(cells) != len(columns):
                raise SystemExit(f"bench: {path}, line {number}: {len(cells)} columns, not {len(columns)}")
            rows.append((cells[0], float(cells[1]), dict(zip(columns[first:], map(_seconds, cells[first:])))))
        return cls(comments[:-1], rows)

    def table(self):
        rows = []
        for tolerance in sorted({row[1] for row in self.rows}, reverse=True):
            cases = [times for _, at, times in self.rows if at == tolerance]
            names = [name for name in cases[0] if name != "meshgauge"]
            for name in [*names, "the faster of them"] if len(names) > 1 else names:
                ratios, over, alone, short = _ratios(cases, [name] if name in names else names)
                rows.append(
                    (
                        name,
                        f"{tolerance:g}",
                        len(cases),
                        text.ratio(statistics.geometric_mean(ratios)) if ratios else "–",
                        text.ratio(min(ratios)) if ratios else "–",
                        text.ratio(max(ratios)) if ratios else "–",
                        over,
                        alone,
                        short,
                    )
                )
        header = ("over", "tolerance", "pairs", "geometric mean", "least", "most", "not finished", "only `auto` finishes")
        header += ("too short to measure",)
        return "\n".join([*(f"{note[:1].upper()}{note[1:]}." for note in self.notes), "", text.table(header, rows)])

    def by_kind(self):
        """{(kind, tolerance): speed-ups over the faster rival}"""
        found = collections.defaultdict(list)
        for pair, tolerance, times in self.rows:
            found[pair.partition("/")[0], tolerance] += _ratios([times], [n for n in times if n != "meshgauge"])[0]
        rows = [
            (kind, f"{tolerance:g}", len(values), text.ratio(statistics.geometric_mean(values)))
            for (kind, tolerance), values in sorted(found.items())
            if values
        ]
        return text.table(("kind", "tolerance", "pairs", "over the faster published code"), rows)


def _seconds(cell):
    try:
        return float(cell)
    except ValueError:
        return None  # timeout, memory, crash


def _ratios(cases, names):
    """Speed-ups over the fastest of the named ones; how often none of them finishes; how often meshgauge does alone; how
    often a time is 0, which gives no ratio."""
    ratios, over, alone, short = [], 0, 0, 0
    for times in cases:
        own, finished = times["meshgauge"], [times[name] for name in names if times[name] is not None]
        over += not finished
        alone += not finished and own is not None
        short += bool(finished) and (not min(finished) or own == 0)
        if finished and min(finished) and own:
            ratios.append(min(finished) / own)
    return ratios, over, alone, short
