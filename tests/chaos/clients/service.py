"""The service that is attacked, in four forms and one with few descriptors, and what it holds."""

import collections
import contextlib
import dataclasses
import json
import os
import re
import ssl
import sys
import tempfile
import threading
import time
from pathlib import Path

from victim import ROOT

sys.path.append(str(ROOT / "tests/e2e"))
from harness import BINARY, Server, read_answer  # noqa: E402
from keys import bearer, new_key, write_keys  # noqa: E402
from test_tls import TlsServer, client, make_certificate  # noqa: E402

HEAD_MS, STALL_MS = 1500, 1000
# Deadlines that an attack can wait for, and limits that it can reach.
FLAGS = ("--head-timeout-ms", str(HEAD_MS), "--body-timeout-ms", "4000", "--keep-alive-ms", "3000", "--grace-ms",
         "2000",
         "--max-part-bytes", "1000000", "--max-request-bytes", "2000000", "--max-expanded-bytes", "20000000",
         "--max-triangles", "20000",
         "--workers", "2", "--max-event-streams", "16", "--max-batch-pairs", "2000", "--max-kept-results", "500",
         "--max-cache-bytes", "4000000", "--map-cache-bytes", "4000000", "--log-requests", "problems")
HONEST = "127.0.0.1"
TRIES = 20  # a handshake may be refused for its rate
# What the log may say while clients attack. Anything else may be a line that a client has written.
EVENTS = {"access", "descriptors", "listening", "log", "memory", "readiness", "refused", "request", "sandbox",
          "stopped", "stopping", "store", "sweep"}
DOCUMENTED_5XX = {"501", "503", "505"}
OUR_OWN_FAULT = ("crashed", "untrue", "failed")  # ends of reader processes
IDLE = ("queue_depth", "jobs_running", "upload_bytes", "memory_reserved_bytes", "event_streams")
WITHOUT_TICKETS = client(maximum_version=ssl.TLSVersion.TLSv1_2)
SANITIZED = os.environ.get("MESHGAUGE_SANITIZED") == "1"


@dataclasses.dataclass(frozen=True)
class Variant:
    name: str
    tls: bool = False
    keys: bool = False
    descriptors: int = 0  # its limit; 0: that of this process
    flags: tuple = ()
    families: tuple = ()  # of attacks; none: all


HUNGRY = ("clients that vanish", "crowds", "half-closed", "parts", "pipelines", "races", "resets", "slow readers",
          "slow senders", "streams")
VARIANTS = (Variant("plain"), Variant("plain with keys", keys=True), Variant("tls", tls=True),
            Variant("tls with keys", tls=True, keys=True),
            Variant("few descriptors", descriptors=220, flags=("--queue", "4", "--parsers", "2"), families=HUNGRY))


@dataclasses.dataclass(frozen=True)
class Sizes:
    """What a process holds."""

    resident_kb: int
    descriptors: int  # without those of the database, which keeps up to eight connections for reading
    threads: int
    files: int  # in its temporary folder, or arriving in its data folder

    def __str__(self):
        return "%d kB, %d descriptors, %d threads, %d files" % dataclasses.astuple(self)


class Service:
    """Running. `key` and `other_key`: header lines of two clients; empty without keys."""

    def __init__(self, variant):
        self.variant, self.lock, self.statuses = variant, threading.Lock(), collections.Counter()
        self.holder = tempfile.TemporaryDirectory(prefix="meshgauge-clients-")
        self.folder = Path(self.holder.name)
        self.temporary = self.folder / "tmp"
        self.temporary.mkdir()
        self.key = self.other_key = self.metrics_key = self.small_key = b""
        flags = [*FLAGS, "--temp-dir", str(self.temporary), *variant.flags, *(self._keys() if variant.keys else ())]
        if variant.tls:
            make_certificate(self.folder)
            flags += ["--tls-certificate", str(self.folder / "c.pem"), "--tls-key", str(self.folder / "k.pem")]
        program = ("prlimit", "--nofile=%d:%d" % (variant.descriptors, variant.descriptors),
                   BINARY) if variant.descriptors else (BINARY,)
        self.server = (TlsServer if variant.tls else Server)(*flags, program=program)
        self.port, self.process = self.server.port, self.server.process

    def _keys(self):
        """The file of four keys: an attacker's, another client's, one for metrics and one of small limits."""
        much = {"requests_per_minute": 10_000_000, "burst": 1_000_000, "max_jobs": 1000}
        made = [new_key("attacker", **much), new_key("honest", **much),
                new_key("metrics", "--scope", "metrics", **much),
                new_key("small", requests_per_minute=6, burst=3, max_jobs=1, max_storage_bytes=100_000)]
        self.key, self.other_key, self.metrics_key, self.small_key = (bearer(token).encode() for token, _ in made)
        write_keys(self.folder / "keys.json", *(entry for _, entry in made))
        return "--keys-file", str(self.folder / "keys.json")

    # --- connections ---

    def plain(self, source=HONEST, timeout=60):
        """A connection without TLS, whatever the service speaks."""
        return Server.connect(self.server, timeout, source)

    def connect(self, source=HONEST, timeout=60, silent=False, tries=TRIES):
        """`silent`: the service sends nothing unasked; over TLS 1.3 it sends tickets. `tries`: of a handshake."""
        context = WITHOUT_TICKETS if silent else TlsServer.context
        if not self.variant.tls:
            return self.plain(source, timeout)
        for left in reversed(range(tries)):
            try:
                return context.wrap_socket(self.plain(source, timeout), server_hostname="localhost")
            except (ssl.SSLError, ConnectionError):  # refused for the rate of the address or of all
                if left == 0:
                    raise
                time.sleep(0.2)

    def read(self, stream):
        """The next answer, as openapi.yaml allows it; None: the connection is closed."""
        try:
            answer = read_answer(stream)
        except (ConnectionError, ssl.SSLError):
            return None
        if answer is not None:
            with self.lock:
                self.statuses[answer.status] += 1
            if answer.status in (429, 503):
                assert int(answer.headers["retry-after"]) > 0, "refused without Retry-After: %s" % answer.headers
        return answer

    # --- what it holds ---

    def metrics(self):
        with self.connect() as connection:
            connection.sendall(b"GET /metrics HTTP/1.1\r\nHost: localhost\r\n" + self.metrics_key + b"\r\n")
            return self.read(connection.makefile("rb")).body.decode()

    def levels(self, *names):
        text = self.metrics()
        return {name: float(re.search(r"^meshgauge_%s (\S+)$" % name, text, re.M)[1]) for name in names}

    def sizes(self):
        status = Path("/proc/%d/status" % self.process.pid).read_text()
        number = lambda field: int(re.search(field + r":\s+(\d+)", status)[1])
        arriving = self.folder_of_data() / "blobs/incoming"
        files = [*self.temporary.iterdir(), *(arriving.iterdir() if arriving.exists() else ())]
        return Sizes(number("VmRSS"), self.descriptors(), number("Threads"), len(files))

    def descriptors(self):
        found = 0
        for link in Path("/proc/%d/fd" % self.process.pid).iterdir():
            with contextlib.suppress(FileNotFoundError):  # closed meanwhile
                found += not Path(os.readlink(link)).name.startswith("jobs.sqlite")
        return found

    def folder_of_data(self):
        return Path(self.server.data_dir.name) / "data"

    def trouble(self):
        """What its counters and its log say of it that may not be, as texts."""
        metrics = self.metrics()
        codes = re.findall(r'^meshgauge_requests_total\{.*code="(5\d\d)".*\} (\S+)$', metrics, re.M)
        readers = re.findall(r'^meshgauge_sandbox_workers_ended_total\{outcome="(\w+)"\} (\S+)$', metrics, re.M)
        found = ["%s answers %s" % (count,
                                    code) for code, count in codes if code not in DOCUMENTED_5XX and float(count) > 0]
        found += ["%s readers %s" % (count, outcome) for outcome,
                  count in readers if outcome in OUR_OWN_FAULT and float(count) > 0]
        lines = [line for line in list(self.server.log) if not self._is_ours(line)]
        return found + ["a line of the log: %s" % line[:300] for line in lines[:3]]

    @staticmethod
    def _is_ours(line):
        try:
            return json.loads(line)["event"] in EVENTS
        except (ValueError, KeyError):
            return False

    def stop(self):
        """Its exit code."""
        try:
            return self.server.stop()
        finally:
            self.server.data_dir.cleanup()
            self.holder.cleanup()
