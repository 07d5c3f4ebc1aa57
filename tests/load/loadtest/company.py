"""What goes on beside the even load of a soak: a client that walks through all of the API, readers that are killed, keys
that are read again."""
import contextlib
import os
import pathlib
import random
import signal
import sys
import threading
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "chaos"))  # its walk through the API

from ledger import Ledger  # noqa: E402
from walk import User  # noqa: E402

from .service import family  # noqa: E402

PAUSE, KILLS, RELOADS = 2, 10, 30  # seconds between walks, kills of a reader, reloads
VISIT = 60  # seconds; far below the time that results are kept, so that nothing a visitor looks at may have expired


class Company:
    """Begins with the block and ends with it. `ledger`: what was promised; `counts`: what was done."""

    def __init__(self, service, seed):
        self.service, self.dice, self.seed = service, random.Random(seed), seed
        self.ledger, self.over = Ledger(), threading.Event()
        self.counts = {"walks": 0, "readers killed": 0, "reloads": 0}
        self.threads = [threading.Thread(target=work) for work in (self._walk, self._kill, self._reload)]

    def __enter__(self):
        for thread in self.threads:
            thread.start()
        return self

    def __exit__(self, *_):
        self.over.set()
        for thread in self.threads:
            thread.join()

    def _walk(self):
        visits = 0
        while not self.over.is_set():
            visits += 1
            user, end = User(self.ledger, f"{self.seed}-{visits}", f"visitor{visits}"), time.monotonic() + VISIT
            while time.monotonic() < end and not self.over.wait(PAUSE):
                if silent := user.walk(self.service.port):
                    self.ledger.violated(f"{silent} requests without an answer")
                self.counts["walks"] += 1

    def _kill(self):
        while not self.over.wait(KILLS):
            readers = family(self.service.process.pid)[1:]
            if readers:
                with contextlib.suppress(ProcessLookupError):
                    os.kill(self.dice.choice(readers), signal.SIGKILL)
                    self.counts["readers killed"] += 1

    def _reload(self):
        while not self.over.wait(RELOADS):
            self.service.process.send_signal(signal.SIGHUP)
            self.counts["reloads"] += 1
