"""Starts that the system does not grant what they need: each ends in a running service, or in a line and code 3."""

import json
import os
import random
import resource
import subprocess
import tempfile
import threading
import unittest
from pathlib import Path

import victim
from seeds import seed
from shim import KINDS, SHIM, Faults
from victim import BINARY, Gone, ask

EVERY_PROCESS = -1
START_SECONDS = 120  # most of it is waited for memory


class Start:
    """One start, and the end of its service. `running`: it served; `port`: where, unless the log lost that line; `text`: all
    that it wrote. After `patience` seconds without its last line it is told to end: one that ends well was running."""

    def __init__(self, folder, *flags, limits=(), environment=None, patience=START_SECONDS):
        def lower():
            for what, most in limits:
                resource.setrlimit(what, (most, most))
        self.text, self.port, self.answers, last = "", None, False, False
        with tempfile.TemporaryDirectory(dir=folder) as data:
            process = subprocess.Popen(
                [BINARY, "serve", "--port", "0", "--workers", "2", "--data-dir", data + "/data", "--temp-dir", data, *flags],
                stderr=subprocess.PIPE, env={**victim.ENVIRONMENT, **(environment or {})}, preexec_fn=lower)
            timers = [threading.Timer(patience, process.terminate), threading.Timer(2 * START_SECONDS, process.kill)]
            [timer.start() for timer in timers]
            for line in process.stderr:
                self.text += line.decode(errors="replace")
                event = json.loads(line) if line.startswith(b"{") else {}
                if event.get("event") == "listening":
                    self.port = int(event["detail"].rsplit(":", 1)[1])
                if event.get("event") == "descriptors" and not last:
                    last = True
                    self.answers = self.port is not None and self.is_alive()
                    process.terminate()
            self.code = process.wait()
            process.stderr.close()
            [timer.cancel() for timer in timers]
            self.running = last or self.code == 0

    def is_alive(self):
        try:
            return ask(self.port, "GET", "/healthz").status == 200
        except Gone:
            return False


class Case(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="meshgauge-start-")
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.dice = random.Random(seed("today"))

    def check(self, start, answers=True):
        """A running service, which ends well; or the line and the code."""
        if start.running:
            self.assertEqual(start.code, 0, start.text)
            self.assertTrue(start.answers or not answers, start.text)
            return
        self.assertEqual(start.code, 3, start.text)
        self.assertRegex(start.text, "(?m)^meshgauge: .")


class Limits(Case):
    @unittest.skipIf(os.environ.get("MESHGAUGE_SANITIZED"), "a sanitizer reserves terabytes")
    def test_memory(self):
        for megabytes in (300, 400):
            with self.subTest(megabytes=megabytes):
                start = Start(self.folder, limits=[(resource.RLIMIT_AS, megabytes << 20)])
                self.check(start, answers=False)
        self.assertEqual(start.code, 3, "the threads of 64 requests need more")
        self.assertIn("--io-threads", start.text)

    def test_descriptors(self):
        for most in (8, 16, 32, 64, 128):
            with self.subTest(descriptors=most):
                start = Start(self.folder, limits=[(resource.RLIMIT_NOFILE, most)])
                self.assertEqual(start.code, 3, start.text)
                self.check(start)
        self.assertIn("the limit on open files is 128, but these settings need", start.text)

    def test_descriptors_that_are_few(self):
        """Fewer connections, as the log says."""
        start = Start(self.folder, "--queue", "4", "--parsers", "2", limits=[(resource.RLIMIT_NOFILE, 220)])
        self.check(start)
        self.assertTrue(start.running, start.text)
        self.assertIn("at most 78 connections, fewer than three quarters of the limit", start.text)

    def test_sizes_of_files(self):
        for most in (0, 4096, 100_000):
            with self.subTest(bytes=most):
                self.check(Start(self.folder, limits=[(resource.RLIMIT_FSIZE, most)]))


@unittest.skipIf(os.environ.get("MESHGAUGE_SANITIZED"), "a sanitizer comes before every other library")
class Calls(Case):
    """Calls of the system that fail while a service starts."""

    def setUp(self):
        super().setUp()
        self.faults = Faults(self.folder / "faults")
        self.faults.watch(EVERY_PROCESS)
        self.environment = {"LD_PRELOAD": SHIM, "MESHGAUGE_FAULTS": str(self.faults.path)}

    def start(self, *flags, patience=START_SECONDS):
        return Start(self.folder, *flags, environment=self.environment, patience=patience)

    def made(self, kind, *flags):
        """How many calls of a kind a start makes, up to the end of its service."""
        self.faults.watch(EVERY_PROCESS)
        before = self.faults.calls()[kind]
        self.check(self.start(*flags), answers=not flags)
        return self.faults.calls()[kind] - before

    def test_threads(self):
        number = self.made("thread")
        self.assertGreater(number, 64)
        for after in sorted({0, 1, 8, number - 10, self.dice.randrange(number)}):
            with self.subTest(threads=after):
                self.faults.fail("thread", True, after=after)
                start = self.start()
                self.check(start, answers=False)
                self.assertTrue(start.running or "grants no further thread" in start.text, start.text)
        self.faults.fail("thread", True, after=30)
        self.assertFalse(self.start().running)

    def test_threads_of_handshakes(self):
        """One in the midst of them, where some run already."""
        key, certificate = str(self.folder / "k.pem"), str(self.folder / "c.pem")
        subprocess.run(["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-days", "2",
                        "-subj", "/CN=localhost", "-keyout", key, "-out", certificate], check=True, capture_output=True)
        flags = ("--tls-key", key, "--tls-certificate", certificate, "--io-threads", "1", "--handshake-threads", "32")
        self.faults.fail("thread", True, after=self.made("thread", *flags) // 2)
        start = self.start(*flags)
        self.check(start)
        self.assertIn("grants no further thread", start.text)

    def test_one_call(self):
        for kind in [kind for kind in KINDS if kind not in ("thread", "allocation", "connect")]:
            number = self.made(kind)
            for after in sorted({0, self.dice.randrange(max(number, 1))}):
                with self.subTest(kind=kind, after=after):
                    self.faults.fail(kind, False, after=after)
                    self.check(self.start(patience=20), answers=False)  # a write that fails may be the log's

    def test_memory(self):
        """One allocation that fails, and all of them from one on."""
        self.faults.watch(EVERY_PROCESS)
        subprocess.run([BINARY, "serve", "--print-config"], env={**victim.ENVIRONMENT, **self.environment}, check=True,
                       stdout=subprocess.DEVNULL)
        first = self.faults.calls()["allocation"]  # before, only libraries and flags are set up
        number = self.made("allocation")
        for after in [self.dice.randrange(first, number) for _ in range(6)]:
            with self.subTest(after=after):
                self.faults.fail("allocation", False, after=after)
                self.check(self.start(), answers=False)
        for after in (first, first + (number - first) // 4):
            with self.subTest(from_then_on=after):
                self.faults.fail("allocation", True, after=after)
                start = self.start()
                self.assertFalse(start.running, start.text)
                self.check(start)


if __name__ == "__main__":
    unittest.main()
