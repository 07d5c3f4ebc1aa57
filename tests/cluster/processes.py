"""Front ends and workers: processes of one binary with a data folder each, and nothing between them but the database."""

import contextlib
import http.client
import json
import os
import signal
import struct
import subprocess
import sys
import time

from scratch import ROOT, free_port, signal_inside

sys.path.insert(0, str(ROOT / "tests/chaos"))
from victim import Gone, ask  # noqa: E402

BINARY = os.environ.get("MESHGAUGE_BINARY", str(ROOT / "build" / "meshgauge"))
ENVIRONMENT = {k: v for k, v in os.environ.items() if not k.startswith(("PG", "MESHGAUGE_"))}
START_SECONDS = 60
CLOCK = os.environ.get("MESHGAUGE_FAILING_DISK_LIBRARY", str(ROOT / "build/tests/chaos/libfailing_disk.so"))
QUICK = ("--lease-ms", "2000", "--heartbeat-ms", "300")  # so that a test need not wait for a minute


def until(condition, seconds=60, what="it"):
    """Waits until the condition holds; returns its value."""
    end = time.monotonic() + seconds
    while not (found := condition()):
        assert time.monotonic() < end, "waited in vain for " + what
        time.sleep(0.01)
    return found


class Ended(AssertionError):
    """A process ended that was expected to become ready."""


class Process:
    """`meshgauge serve` or `meshgauge worker`, listening. Its port and its folder stay the same from one life to the next.
    `clock`: seconds by which its clock is wrong, from its start on (failing_disk.cpp)."""

    def __init__(self, scratch, name, verb, url, *flags, clock=0):
        self.name, self.port = name, free_port()
        self.folder = scratch.path / name
        self.folder.mkdir()
        for part in ("data", "tmp"):
            (self.folder / part).mkdir(mode=0o700)
        self.command = [BINARY, verb, "--port", str(self.port), "--data-dir", str(self.folder / "data"), "--temp-dir",
                        str(self.folder / "tmp"), *flags]
        self.environment = {**ENVIRONMENT, "MESHGAUGE_DATABASE": url}
        if clock:
            (self.folder / "orders").write_bytes(struct.pack("iii", -1, 0, clock))
            wrong = "%s:%s" % (self.folder / "none", self.folder / "orders")
            self.environment.update(LD_PRELOAD=CLOCK, MESHGAUGE_FAILING_DISK=wrong)
        self.process = None

    def start(self, wait=True):
        assert self.process is None
        self.log = self.folder / ("log-%d" % time.monotonic_ns())
        with open(self.log, "wb") as log:
            self.process = subprocess.Popen(self.command, stdin=subprocess.DEVNULL, stdout=log, stderr=log, cwd=self.folder,
                                            env=self.environment)
        if wait:
            self.wait_ready()

    def start_again(self):
        """Starts again and again, as a supervisor does, since no process can start while the database is away."""
        end = time.monotonic() + START_SECONDS
        while True:
            self.start(wait=False)
            try:
                return self.wait_ready()
            except Ended:
                self._ended()
                if time.monotonic() > end:
                    raise
            time.sleep(0.2)

    def wait_ready(self):
        until(self.is_ready, START_SECONDS, self.name + " to be ready")

    def is_ready(self):
        if self.process.poll() is not None:
            raise Ended("%s ended: %d\n%s" % (self.name, self.process.returncode, self.tail()))
        with contextlib.suppress(Gone):
            return self.ask("GET", "/readyz").status == 200
        return False

    def ask(self, method, path, body=None, headers=None):
        """One request on a connection of its own; Gone when there is no answer."""
        return ask(self.port, method, path, body, headers)

    def events(self, path, headers=None):
        """The events of a job as they come: (name, data). Ends with the last."""
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=60)
        try:
            connection.request("GET", path, headers={"Accept": "text/event-stream", **(headers or {})})
            response = connection.getresponse()
            assert response.status == 200, (response.status, response.read())
            name = None
            for line in response:
                field, _, value = line.decode().rstrip("\r\n").partition(": ")
                if field == "event":
                    name = value
                elif field == "data":
                    yield name, json.loads(value)
        except (OSError, http.client.HTTPException) as error:
            raise Gone(str(error)) from None
        finally:
            connection.close()

    def kill(self):
        """Kills with -9. An earlier end by any other cause is a defect."""
        self.process.kill()
        code = self._ended()
        assert code == -signal.SIGKILL, "%s ended by itself: %d\n%s" % (self.name, code, self.tail())

    def terminate(self):
        self.process.terminate()

    def stop(self):
        """Sends SIGTERM, and expects the exit code 0 in time."""
        self.terminate()
        self.ended()

    def ended(self):
        code = self._ended()
        assert code == 0, "%s: exit %d\n%s" % (self.name, code, self.tail())

    def _ended(self):
        code = self.process.wait(START_SECONDS)
        self.process = None
        return code

    def pause(self):
        self.process.send_signal(signal.SIGSTOP)

    def go_on(self):
        self.process.send_signal(signal.SIGCONT)

    def lines(self):
        """What it has logged in this life."""
        found = []
        for line in self.log.read_text(errors="replace").splitlines():
            with contextlib.suppress(ValueError):
                found.append(json.loads(line))
        return found

    def tail(self):
        return self.log.read_text(errors="replace")[-4000:]


class Fleet:
    """All processes on one database. Whatever still runs at the end is killed."""

    def __init__(self, scratch, url, flags=QUICK):
        self.scratch, self.url, self.flags = scratch, url, flags
        self.front_ends, self.workers = [], []

    def add_front_end(self, *flags, clock=0):
        """Starts the process without waiting until it is ready."""
        return self._started(self.add("serve", *flags, clock=clock))

    def add_worker(self, *flags, clock=0):
        return self._started(self.add("worker", *flags, clock=clock))

    @staticmethod
    def _started(process):
        process.start(wait=False)
        return process

    def add(self, verb, *flags, clock=0):
        """A process that is not started: `serve` or `worker`."""
        among, name = {"serve": (self.front_ends, "front"), "worker": (self.workers, "worker")}[verb]
        name = "%s%d" % (name, len(among) + 1)
        among.append(Process(self.scratch, name, verb, self.url, *self.flags, *flags, clock=clock))
        return among[-1]

    def wait(self):
        """Waits until all running processes are ready."""
        for one in self.all():
            if one.process is not None:
                one.wait_ready()

    def all(self):
        return [*self.front_ends, *self.workers]

    def print_tails(self):
        for one in self.all():
            print("--- %s\n%s" % (one.name, one.tail()), file=sys.stderr)

    def kill_all(self):
        for one in self.all():
            signal_inside(one.folder, signal.SIGKILL)
            if one.process is not None:
                one.process.kill()
                one._ended()


def migrate(url):
    """Migrates a database, which may be empty, to the schema of this binary."""
    done = subprocess.run([BINARY, "migrate"], env={**ENVIRONMENT, "MESHGAUGE_DATABASE": url}, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
