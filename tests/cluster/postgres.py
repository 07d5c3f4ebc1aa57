#!/usr/bin/env python3
"""A private PostgreSQL: own folder, free port, any user, gone afterwards. As a command:

    postgres.py -- COMMAND...    runs the command with MESHGAUGE_DATABASE; its exit code; 77: there is no PostgreSQL here
"""

import argparse
import contextlib
import os
import re
import secrets
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

from scratch import TOOLS, Scratch, end_inside, free_port, servant, signal_inside, within_reach

SKIPPED = 77
READY_SECONDS = 60
USER = DATABASE = "meshgauge"
ENVIRONMENT = {k: v for k, v in os.environ.items() if not k.startswith(("PG", "MESHGAUGE_"))}
# Shared memory is in the data's folder: a server that is killed would leave it in /dev/shm.
SETTINGS = {"dynamic_shared_memory_type": "mmap", "max_connections": 200, "shared_buffers": "64MB", "jit": "off",
            "log_min_messages": "warning"}


class Missing(Exception):
    """There is no PostgreSQL on this machine."""


@contextlib.contextmanager
def or_skip():
    """Ends a program, as a test that is skipped, where something is missing."""
    try:
        yield
    except Missing as reason:
        print("skipped: %s" % reason, file=sys.stderr)
        sys.exit(SKIPPED)


def find_binaries():
    """The folder of initdb, postgres and psql; of several the newest version."""
    named = [Path(os.environ["MESHGAUGE_POSTGRES"])] if "MESHGAUGE_POSTGRES" in os.environ else []
    on_path = shutil.which("initdb")
    packaged = [*TOOLS.glob("usr/lib/postgresql/*/bin"), *Path("/usr/lib/postgresql").glob("*/bin")]
    packaged.sort(key=lambda path: int(re.sub(r"\D", "", path.parent.name) or 0), reverse=True)
    for folder in [*named, *packaged, *([Path(on_path).parent] if on_path else [])]:
        if all((folder / name).exists() for name in ("initdb", "postgres", "psql")):
            return folder
    raise Missing("no PostgreSQL: neither in build/tools (./dev test), in /usr/lib/postgresql nor on PATH")


def usable_binaries(scratch):
    """The binaries, where servant() may run them. They find their other files by relative paths."""
    found = find_binaries()
    usr = found.parents[3]
    return within_reach(scratch, usr, "lib/postgresql", "share/postgresql") / found.relative_to(usr)


def psql(binaries, url, sql):
    """The rows as text, columns separated by |. A CalledProcessError has the server's message."""
    done = subprocess.run([binaries / "psql", "--no-psqlrc", "-qAt", "-v", "ON_ERROR_STOP=1", url, "-c", sql], check=True,
                          capture_output=True, text=True, env=ENVIRONMENT, timeout=60)
    return done.stdout.strip()


class Postgres:
    """One server, running. Its port and its data stay the same while it is stopped, killed and started again."""

    def __init__(self, scratch=None, **settings):
        self.own_scratch = Scratch() if scratch is None else None
        self.scratch = scratch or self.own_scratch
        try:
            self.binaries = usable_binaries(self.scratch)
            self.folder = self.scratch.folder("postgres-%s" % secrets.token_hex(4))
            self.data, self.log = self.folder / "data", self.folder / "log"
            self.port, self.password, self.process = free_port(), secrets.token_hex(8), None
            self.settings = {**SETTINGS, **settings, "port": self.port, "listen_addresses": "127.0.0.1",
                             "unix_socket_directories": self.folder}
            self._initialise()
            self.start()
            psql(self.binaries, self.url("postgres"), "CREATE DATABASE " + DATABASE)
        except BaseException:
            self.close()
            raise

    def _initialise(self):
        secret = self.folder / "password"
        secret.write_text(self.password)
        secret.chmod(0o644)  # its folder is closed
        subprocess.run([self.binaries / "initdb", "-D", self.data, "-U", USER, "-E", "UTF8", "--locale=C.UTF-8", "--no-sync",
                        "--auth=scram-sha-256", "--pwfile", secret], check=True, capture_output=True, cwd=self.folder,
                       env=ENVIRONMENT, **servant())

    def url(self, database=DATABASE):
        return "postgresql://%s:%s@127.0.0.1:%d/%s" % (USER, self.password, self.port, database)

    def socket_url(self, database=DATABASE):
        """The connection string for its unix socket."""
        return "host=%s port=%d user=%s password=%s dbname=%s" % (self.folder, self.port, USER, self.password, database)

    def query(self, sql, database=DATABASE):
        return psql(self.binaries, self.url(database), sql)

    def new_database(self, name):
        """Creates an empty database beside the first; returns its url."""
        self.query("CREATE DATABASE " + name)
        return self.url(name)

    def start(self):
        """Starts the server and waits until it takes connections."""
        assert self.process is None
        flags = [part for name, value in self.settings.items() for part in ("-c", "%s=%s" % (name, value))]
        with open(self.log, "ab") as log:
            self.process = subprocess.Popen([self.binaries / "postgres", "-D", self.data, *flags], stdout=log, stderr=log,
                                            stdin=subprocess.DEVNULL, cwd=self.data, env=ENVIRONMENT, **servant())
        end = time.monotonic() + READY_SECONDS
        while not self._is_ready():
            assert self.process.poll() is None and time.monotonic() < end, "it does not start:\n" + self.tail()
            time.sleep(0.02)

    def _is_ready(self):
        with contextlib.suppress(FileNotFoundError):
            lines = (self.data / "postmaster.pid").read_text().split("\n")
            return len(lines) > 7 and lines[0] == str(self.process.pid) and lines[7].strip() == "ready"
        return False

    def stop(self):
        """Shuts down in order, at once: open connections are cut off."""
        self.process.send_signal(signal.SIGINT)
        self._ended()

    def kill(self):
        """Kills all its processes with -9."""
        self.process.kill()
        end_inside(self.data)
        self._ended()

    def _ended(self):
        self.process.wait(READY_SECONDS)
        self.process = None

    def pause(self):
        """Stops all its processes, like a machine that hangs: connections stay open and nothing answers."""
        signal_inside(self.data, signal.SIGSTOP)

    def go_on(self):
        signal_inside(self.data, signal.SIGCONT)

    def tail(self):
        return self.log.read_text(errors="replace")[-4000:]

    def close(self):
        if getattr(self, "process", None) is not None:
            self.kill()
        if self.own_scratch is not None:
            self.own_scratch.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("command", nargs="+")
    command = parser.parse_args().command
    with or_skip():
        server = Postgres()
    with server:
        signal.signal(signal.SIGTERM, lambda *_: sys.exit(128 + signal.SIGTERM))
        code = subprocess.run(command, env={**os.environ, "MESHGAUGE_DATABASE": server.url()}).returncode
    sys.exit(code if code >= 0 else 128 - code)


if __name__ == "__main__":
    main()
