"""What attacks are made of: connections from an address of their own, and judged answers."""

import contextlib
import json
import select
import socket
import time

from clients.attack import HEALTH, KEY, Broken, at_once, demand, post, request
from clients.service import STALL_MS
from harness import multipart
from victim import square

BUSY = (408, 429, 503)  # refusals of a service, or of a machine, that is busy: the same is tried again
TRIES = 15
PAUSE = 0.3
ADDRESSES = 250
RESET = b"\1\0\0\0\0\0\0\0"  # SO_LINGER: closing sends a reset
FLOOD_BYTES = 100_000_000


class Arena:
    """One attack on a service. `source`: its address; attacks that run beside each other have different ones."""

    def __init__(self, service, number, dice):
        self.service, self.variant, self.dice = service, service.variant, dice
        self.source, self.tries = "127.0.1.%d" % (1 + number % ADDRESSES), 0

    def address(self, number):
        """Another address of an attacker."""
        return "127.0.2.%d" % (1 + number % ADDRESSES)

    def connect(self, source=None, silent=False):
        return self.service.connect(source or self.source, silent=silent)

    def filled(self, data):
        return (data() if callable(data) else data).replace(KEY, self.service.key)

    def read(self, stream):
        return self.service.read(stream)

    # --- exchanges ---

    @staticmethod
    def send(connection, data, send=at_once):
        """Sends all of it, or until it is refused, as where this machine is too slow for a time limit: the answer is
        there nevertheless."""
        with contextlib.suppress(OSError):
            send(connection, data)

    def exchange(self, data, answers, send=at_once):
        """Sends bytes and asserts the answers to them, each a status or several that may be. After the last one the
        connection is closed if it said so; else the next request on it is answered as if nothing had been before."""
        self.patiently(lambda: self._attempt(self.filled(data), answers, send))

    def patiently(self, attempt):
        """Repeats until it is not None, which stands for a refusal by a busy service, or for a connection that was closed
        without an answer where descriptors are few (docs/operations.md); returns what it is then."""
        for _ in range(TRIES):
            self.tries += 1
            found = attempt()
            if found is not None:
                return found
            time.sleep(PAUSE)
        raise AssertionError("refused as by a busy service, %d times" % TRIES)

    def is_turned_away(self, answer, *what):
        """Whether there is no answer, as may be where descriptors are few; elsewhere it is a fault, which `what` tells."""
        demand(answer is not None or self.variant.descriptors, *what)
        return answer is None

    def _attempt(self, data, answers, send):
        with self.connect() as connection:
            self.send(connection, data, send)
            stream, answer = connection.makefile("rb"), None
            for allowed in answers:
                allowed = allowed if isinstance(allowed, tuple) else (allowed,)
                answer = self.read(stream)
                if self.is_turned_away(answer, "closed in place of", allowed):
                    return None
                if answer.status in BUSY and answer.status not in allowed:
                    return None
                demand(answer.status in allowed, answer.status, "in place of", allowed, answer.body)
            return self.check_end(connection, stream, answer)

    def check_end(self, connection, stream, last):
        """True. None: the connection was closed, as an idle one may be."""
        if last is None or last.headers.get("connection") == "close":
            demand(self.read(stream) is None, "another answer after the last one")
            return True
        try:
            connection.sendall(self.filled(HEALTH))
            answer = self.read(stream)
        except OSError:
            return None
        demand(answer is None or answer.status == 200, "what was sent before is taken for a request:",
               answer and answer.status)
        return None if answer is None else True

    def ask(self, data, *allowed, source=None):
        """The answer to one request."""
        def attempt():
            with self.connect(source) as connection:
                self.send(connection, self.filled(data))
                answer = self.read(connection.makefile("rb"))
            if self.is_turned_away(answer, "no answer to", data[:200]):
                return None
            if answer.status in BUSY and answer.status not in allowed:
                return None
            demand(not allowed or answer.status in allowed, answer.status, "in place of", allowed, answer.body)
            return answer
        return self.patiently(attempt)

    def get(self, path, *allowed):
        return self.ask(request(b"GET " + path.encode()), *allowed)

    # --- comparisons ---

    def compare(self, low=0, high=2, n=1, options=None, fields=(), allowed=(200,)):
        return self.ask(comparison(low, high, n, options, *fields), *allowed)

    def begin(self, timeout_ms=1000, fields=(), allowed=(202,)):
        """The path of a comparison that runs until its time is over."""
        answer = self.ask(endless(timeout_ms, b"Prefer: respond-async", *fields), *allowed)
        return answer.headers.get("location")

    def delete(self, path):
        """Cancels what runs and removes what has ended; the answer."""
        return self.ask(request(b"DELETE " + path.encode()), 200, 204, 404)

    # --- patience ---

    def closes(self, connection, seconds=30):
        """Asserts that the service closes the connection."""
        connection.settimeout(seconds)
        try:
            while connection.recv(65536):
                pass
        except TimeoutError:
            raise Broken("a connection is still open after %d s" % seconds) from None
        except OSError:  # closed by a reset, or without the end of TLS
            pass

    def flood(self, start, piece, *allowed, most=FLOOD_BYTES):
        """Sends `start`, then `piece` again and again until there is an answer. The service takes less than `most`."""
        def attempt():
            with self.connect(silent=True) as connection:
                sent = 0
                with contextlib.suppress(OSError):
                    connection.sendall(self.filled(start))
                    while sent < most and not select.select([connection], [], [], 0)[0]:
                        sent += connection.send(piece)
                answer = self.read(connection.makefile("rb"))
            demand(sent < most, "all of a flood was taken")
            if answer is None or (answer.status in BUSY and answer.status not in allowed):
                return None  # reset behind the answer, or busy
            demand(answer.status in allowed, answer.status, "in place of", allowed)
            return True
        self.patiently(attempt)


def comparison(low=0, high=2, n=1, options=None, *fields):
    """A comparison of two squares, which are as far apart as their heights are."""
    parts = [("a", square(low, n)), ("b", square(high, n)), ("options", json.dumps(options or {}).encode())]
    return post(multipart(parts), *fields)


ENDLESS = {"strategy": "four_point", "tolerance": {"absolute": 0}}


def endless(timeout_ms, *fields):
    """A comparison that bisection would do for ever."""
    options = json.dumps({**ENDLESS, "timeout_ms": timeout_ms}).encode()
    return post(multipart([("a", square(1, 20)), ("b", square(1, 23)), ("options", options)]), *fields)


def holds(document, distance):
    """Asserts that the interval of a result holds the distance."""
    interval = document["distance"]
    upper = interval["upper"] if interval["upper"] is not None else float("inf")
    demand(interval["lower"] <= distance <= upper, "a wrong interval:", interval, "of", distance)


def half_close(connection):
    """Ends the client's direction, below TLS."""
    socket.socket.shutdown(connection, socket.SHUT_WR)


def reset(connection):
    """Closes by a reset."""
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, RESET)
    connection.close()


def until(condition, seconds=120):
    """Waits until the condition holds, with pauses that leave the processor to the service; returns its value."""
    end = time.monotonic() + seconds
    while not (found := condition()):
        demand(time.monotonic() < end, "waited in vain")
        time.sleep(0.05)
    return found


def stall():
    """For longer than a body may pause."""
    time.sleep(STALL_MS / 1000 + 0.2)
