"""Fixtures: what a version of the service left behind, and what its clients were promised. One archive for each form of store.

embedded:   data/, the data folder as kill -9 left it, with the log of writes that SQLite had not yet merged
postgresql: database.sql, by pg_dump
both:       promised.json, by make.py
"""

import io
import json
import os
import sqlite3
import subprocess
import tarfile
import time
from pathlib import Path

FOLDER = Path(__file__).resolve().parent / "fixtures"
FORMS = ("embedded", "postgresql")
# All columns of the stores that hold a time, in milliseconds since 1970.
TIMES = {"jobs": ("created", "expires_if_never_run", "lease_until", "started", "finished", "expires", "deadline"),
         "meshes": ("created", "last_used", "expires"), "batches": ("created",), "checks": ("at",), "origin": ("born", "doubted"),
         "blobs": ("renewed",), "blob_uploads": ("begun",)}


def pack(path, promised, form, source):
    """Writes an archive of a data folder, or of the bytes of a dump."""
    with tarfile.open(path, "w:xz", preset=9) as archive:
        for name, data in (("promised.json", json.dumps(promised, indent=1, sort_keys=True).encode()),
                           *([("database.sql", source)] if form == "postgresql" else [])):
            entry = tarfile.TarInfo(name)
            entry.size = len(data)
            archive.addfile(entry, io.BytesIO(data))
        if form == "embedded":
            archive.add(source, "data", filter=anonymous)


def anonymous(entry):
    """Without the maker's name, and without the file that only keeps room on the disk."""
    if entry.name == "data/reserve":
        return None
    entry.uid = entry.gid = entry.mtime = 0
    entry.uname = entry.gname = ""
    return entry


class Fixture:
    """One archive, unpacked to a folder. Its times are shifted as if it had been made just now: results and meshes expire."""

    def __init__(self, path, folder):
        self.name, self.form = path.name.split(".tar")[0].rsplit("-", 1)
        self.folder = Path(folder)
        with tarfile.open(path) as archive:
            archive.extractall(self.folder)
        self.promised = json.loads((self.folder / "promised.json").read_text())
        self.shift_ms = round(time.time() * 1000) - self.promised["made_ms"]

    @property
    def data(self):
        return self.folder / "data"

    def load(self, binaries, url):
        """Fills an empty database by the dump."""
        subprocess.run([binaries / "psql", "--no-psqlrc", "-q", "-v", "ON_ERROR_STOP=1", url, "-f", self.folder / "database.sql"], check=True,
                       capture_output=True, env={k: v for k, v in os.environ.items() if not k.startswith("PG")})

    def shift_data_folder(self):
        with sqlite3.connect(self.data / "jobs.sqlite") as database:
            columns = database.execute("SELECT m.name, c.name FROM sqlite_master m, pragma_table_info(m.name) c WHERE m.type = 'table'")
            for statement in self.shifts(columns.fetchall()):
                database.execute(statement)
        database.close()
        for path in (self.data / "blobs").rglob("*"):
            os.utime(path)

    def shifts(self, columns):
        """Statements that shift the times. `columns`: (table, column) of all that this version has."""
        for table, names in TIMES.items():
            there = [name for name in names if (table, name) in columns]
            if there:
                changes = ", ".join("{0} = CASE WHEN {0} > 0 THEN {0} + {1} ELSE {0} END".format(name, self.shift_ms) for name in there)
                yield "UPDATE %s SET %s" % (table, changes)


def archives(form):
    return sorted(FOLDER.glob("*-%s.tar.xz" % form))
