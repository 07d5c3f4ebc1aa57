"""How long health checks take, on new connections and on an open one. A process of its own asks: that attackers are
busy must not count."""

import contextlib
import math
import multiprocessing
import socket
import ssl
import time

GET = b"GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n"
SOURCE = "127.0.0.3"  # of no other client
NEW_PER_SECOND, OPEN_PER_SECOND = 10, 40
ANSWER_SECONDS = 30
KINDS = ("new", "open")


def percentile(times, share):
    """In ms; NaN of none."""
    times = sorted(times)
    return 1000 * times[min(len(times) - 1, math.ceil(share * len(times)) - 1)] if times else math.nan


class Health:
    """Checks until end(). `phase`: the number under which a time is kept; the caller sets it."""

    def __init__(self, port, tls):
        self.port, self.tls = port, tls
        self.phase, self.ended = multiprocessing.Value("i", 0), multiprocessing.Event()
        self.found, theirs = multiprocessing.Pipe(duplex=False)
        self.process = multiprocessing.Process(target=self._run, args=(theirs,), daemon=True)
        self.process.start()

    def end(self):
        """(phase, kind) to the times of checks, in seconds; infinite: there was no right answer."""
        self.ended.set()
        found = self.found.recv()
        self.process.join()
        return found

    def _run(self, found):
        times, connection, i, start = {}, None, 0, time.monotonic()
        while not self.ended.is_set():
            kind = KINDS[i % (1 + OPEN_PER_SECOND // NEW_PER_SECOND) > 0]
            phase, began = self.phase.value, time.monotonic()
            try:
                if kind == "new":
                    with self._connect() as one:
                        self._ask(one)
                else:
                    connection = connection or self._connect()
                    self._ask(connection)
                taken = time.monotonic() - began
            except OSError:  # also of ssl
                taken = math.inf
                with contextlib.suppress(AttributeError):
                    connection = connection.close() if kind == "open" else connection
            times.setdefault((phase, kind), []).append(taken)
            i += 1
            time.sleep(max(0.0, start + i / (NEW_PER_SECOND + OPEN_PER_SECOND) - time.monotonic()))
        found.send(times)

    def _connect(self):
        one = socket.create_connection(("127.0.0.1", self.port), ANSWER_SECONDS, (SOURCE, 0))
        one.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        if not self.tls:
            return one
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
        context.check_hostname, context.verify_mode = False, ssl.CERT_NONE
        return context.wrap_socket(one)

    @staticmethod
    def _ask(connection):
        connection.sendall(GET)
        answer = b""
        while not answer.endswith(b"}"):
            piece = connection.recv(65536)
            if not piece:
                raise ConnectionError("closed")
            answer += piece
        if not answer.startswith(b"HTTP/1.1 200"):
            raise ConnectionError(answer[:100])
