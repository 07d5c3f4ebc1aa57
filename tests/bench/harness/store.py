"""Every run as one line of runs.csv, written as soon as it has ended: a stopped benchmark goes on where it was."""
import csv
import json
import os

# What makes two runs the same measurement; with `repetition`, the same run.
KEY = ("experiment", "pair", "meshes", "contender", "program", "tolerance", "gate", "limits")
COLUMNS = (
    *KEY,
    "repetition",
    "session",
    "kind",
    "at",
    "triangles_a",
    "triangles_b",
    "vertices_a",
    "status",
    "seconds",
    "build",
    "traverse",
    "reduce",
    "certify",
    "read_a",
    "read_b",
    "total",
    "prepare",
    "wall",
    "user",
    "system",
    "peak_bytes",
    "diagonal",
    "lower",
    "upper",
    "reference_lower",
    "reference_upper",
    "max_distance",
    "verdict",
    "survivors",
    "queries",
    "cache_hits",
    "subdivisions",
    "threads",
    "simd",
    "load",
)
_TEXTS = {
    "experiment",
    "pair",
    "meshes",
    "contender",
    "program",
    "gate",
    "limits",
    "session",
    "kind",
    "status",
    "verdict",
    "simd",
}


def _parsed(row):
    return {name: text if name in _TEXTS else float(text) if text else None for name, text in row.items()}


def _written(value):
    return repr(value) if isinstance(value, float) else "" if value is None else str(value)


class Store:
    """Append-only. One writer at a time."""

    def __init__(self, folder):
        self.folder = folder
        self.path = folder / "runs.csv"
        self.rows = []

    def open(self):
        self.folder.mkdir(parents=True, exist_ok=True)
        if self.path.exists():
            self._drop_torn_line()
            self._load()
        else:
            self.path.write_text(",".join(COLUMNS) + "\n")
        return self

    def _drop_torn_line(self):
        """Repairs the end of the file after a run that was killed while writing."""
        whole = self.path.read_bytes().rfind(b"\n") + 1
        os.truncate(self.path, whole)

    def _load(self):
        with self.path.open(newline="") as file:
            reader = csv.DictReader(file)
            if tuple(reader.fieldnames or ()) != COLUMNS:
                raise SystemExit(
                    f"bench: {self.path} has other columns than this version writes; move it away or use --fresh"
                )
            self.rows = [_parsed(row) for row in reader]

    def add(self, row):
        texts = {name: _written(row.get(name)) for name in COLUMNS}
        with self.path.open("a", newline="") as file:
            csv.DictWriter(file, COLUMNS, lineterminator="\n").writerow(texts)
        self.rows.append(_parsed(texts))
        return self.rows[-1]

    def done(self):
        """{key: rows by repetition}"""
        found = {}
        for row in self.rows:
            found.setdefault(key_of(row), {})[int(row["repetition"])] = row
        return found

    def add_session(self, facts):
        with (self.folder / "sessions.jsonl").open("a") as file:
            file.write(json.dumps(facts) + "\n")

    def sessions(self):
        path = self.folder / "sessions.jsonl"
        if not path.exists():
            return []
        return [json.loads(line) for line in path.read_text().splitlines()]


def key_of(row):
    return tuple(row[name] for name in KEY)
