#!/usr/bin/env python3
"""Makes the fixtures of one version, by its program: make.py PROGRAM --name NAME --commit COMMIT.

The program is built of that commit. The present one (MESHGAUGE_BINARY) then brings a copy up to its schema, and PROGRAM
must refuse that copy; what it says is printed.
"""

import argparse
import contextlib
import datetime
import json
import os
import subprocess
import sys
import time
import types
from pathlib import Path

from fixtures import FOLDER, FORMS, Fixture, pack
from story import Client, briefly, until_killed

from postgres import ENVIRONMENT as PLAIN, Postgres, or_skip
from processes import BINARY, ENVIRONMENT, Fleet, migrate
from scratch import Scratch

FLAGS = ("--lease-ms", "3000", "--heartbeat-ms", "500")
LIFE_SECONDS = 60


class Service:
    """The old service on one store, from one life to the next."""

    def __init__(self, scratch, program, url, keys):
        self.scratch, self.program, self.url, self.keys, self.lives = scratch, program, url, keys, 0
        self.data = scratch.path / "store"

    def live(self, token, story):
        """One life: `story` is told to it, and then it is killed. Returns what its clients were promised."""
        self.lives += 1
        home = types.SimpleNamespace(path=self.scratch.folder("life%d" % self.lives))
        fleet = Fleet(home, self.url or "", FLAGS)
        keys = ("--keys-file", str(self.keys)) if token else ()
        front = fleet.add("serve", *keys, *(() if self.url else ("--workers", "1", "--data-dir", str(self.data))))
        if self.url:
            fleet.add("worker", "--workers", "1")
        try:
            for one in fleet.all():
                self.prepare(one)
                one.start()
            client = Client(front.port, token)
            running = story(client)
            if running:
                assert client.state(running) == "running"
            time.sleep(0.2)  # rows of awaited comparisons are written behind their answers
            for one in fleet.all():
                one.kill()
        finally:
            fleet.kill_all()
        return client.promised

    def prepare(self, process):
        """The old program takes --data-dir once, and no empty database."""
        process.command[0] = self.program
        if not self.url:
            place = process.command.index("--data-dir")
            del process.command[place:place + 2]
            del process.environment["MESHGAUGE_DATABASE"]


def new_key(program):
    """A token, and the file of keys that has it."""
    token, entry = subprocess.run([program, "keys", "new", "nightly"], capture_output=True, text=True, check=True).stdout.splitlines()
    return token, {"keys": [{**json.loads(entry), "requests_per_minute": 1000000}]}


def make(path, form, program, commit, postgres):
    with Scratch() as scratch:
        token, keys = new_key(program)
        (scratch.path / "keys.json").write_text(json.dumps(keys))
        service = Service(scratch, program, postgres and postgres.new_database("made"), scratch.path / "keys.json")
        promised = {"commit": commit, "token": token, "keys": keys, "without": service.live(None, briefly),
                    "of_key": service.live(token, until_killed), "made_ms": round(time.time() * 1000),
                    "made": datetime.date.today().isoformat()}
        pack(path, promised, form, dump(postgres) if postgres else service.data)


def dump(postgres):
    """SQL of the database, without the lines that only the psql of the same release reads."""
    done = subprocess.run([postgres.binaries / "pg_dump", "--no-owner", "--no-privileges", postgres.url("made")], check=True,
                          capture_output=True, env=PLAIN)
    return b"".join(line for line in done.stdout.splitlines(True) if not line.startswith((b"\\restrict", b"\\unrestrict")))


def refusal(path, form, program, postgres):
    """What the old program says of its store once the present one has brought it up."""
    with Scratch() as scratch:
        fixture = Fixture(path, scratch.path)
        flags, url = ["--port", "0", "--data-dir", str(fixture.data)], None
        if postgres:
            url = postgres.new_database("again")
            fixture.load(postgres.binaries, url)
            migrate(url)
        else:
            brought = subprocess.Popen([BINARY, "serve", *flags], env=ENVIRONMENT, stderr=subprocess.PIPE, text=True)
            while '"listening"' not in brought.stderr.readline():
                assert brought.poll() is None
            brought.terminate()
            brought.communicate(timeout=LIFE_SECONDS)
        environment = {**ENVIRONMENT, **({"MESHGAUGE_DATABASE": url} if url else {})}
        done = subprocess.run([program, "serve", *flags], env=environment, capture_output=True, text=True, timeout=LIFE_SECONDS)
        return done.returncode, done.stderr.replace(str(scratch.path), "")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=Path)
    parser.add_argument("--name", required=True)
    parser.add_argument("--commit", required=True)
    parser.add_argument("--form", choices=FORMS, help="only this one")
    arguments = parser.parse_args()
    program = str(arguments.program.resolve())
    for form in [arguments.form] if arguments.form else FORMS:
        with or_skip(), Postgres() if form == "postgresql" else contextlib.nullcontext() as postgres:
            path = FOLDER / ("%s-%s.tar.xz" % (arguments.name, form))
            make(path, form, program, arguments.commit, postgres)
            said = "is the present one" if os.path.samefile(program, BINARY) else refusal(path, form, program, postgres)
            print("%s: %d bytes; the old program: %s" % (path.name, path.stat().st_size, said), flush=True)


if __name__ == "__main__":
    sys.exit(main())
