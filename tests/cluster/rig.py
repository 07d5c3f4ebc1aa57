"""What most tests here begin with: a PostgreSQL with the schema, some processes on it, and clients of the front ends."""

import secrets
import sys

from postgres import Postgres
from processes import QUICK, Fleet, migrate, until
from scratch import ROOT, Scratch

sys.path.insert(0, str(ROOT / "tests/e2e"))
from harness import Server, comparison, post_head  # noqa: E402
from victim import ENDLESS, square  # noqa: E402

ASYNC = "Prefer: respond-async\r\n"
ENDED = ("done", "failed", "cancelled")


class Client(Server):
    """A client of a front end that runs already. Every answer is held against openapi.yaml."""

    def __init__(self, process, token=None):
        self.port = process.port
        self.head = "Authorization: Bearer %s\r\n" % token if token else ""

    def raw(self, data, timeout=60):
        first, rest = data.split(b"\r\n", 1)
        return super().raw(first + b"\r\n" + self.head.encode() + rest, timeout)

    def request_of(self, a, b, options, extra=""):
        """The bytes of compare()."""
        body = comparison(a, b, options)
        return post_head(len(body), self.head + extra) + body

    def begin(self, low=0, high=2, n=1, options=None, extra="", salt=""):
        """The path of a new asynchronous comparison."""
        answer = self.compare(square(low, n, salt), square(high, n), options or {}, ASYNC + extra)
        assert answer.status == 202, answer.body
        return answer.headers["location"]

    def begin_endless(self, timeout_ms=100000, extra=ASYNC):
        """The path of a comparison that runs until its timeout."""
        answer = self.compare(**endless(timeout_ms), extra=extra)
        assert answer.status == 202, answer.body
        return answer.headers["location"]

    def wait_for(self, path, *states, seconds=60, away=False):
        """The document, once it is in one of these states. `away`: the database may be."""
        def there():
            answer = self.get(path)
            assert answer.status == 200 or away and answer.status == 503, (answer.status, answer.body)
            return answer.status == 200 and answer.json()["state"] in states and answer.json()
        return until(there, seconds, "%s to be %s" % (path, " or ".join(states)))


def endless(timeout_ms):
    return dict(a=square(0, 40), b=square(0, 43), options={**ENDLESS, "timeout_ms": timeout_ms})


class Rig:
    """Clean up by close(), or as a context manager."""

    def __init__(self, front_ends=1, workers=1, flags=QUICK, front_flags=(), worker_flags=("--workers", "2"), prepare=None, postgres=None):
        """`prepare`: given a folder, more flags of all processes. `postgres`: a server where the rig gets a database of its own; else
        it has a server of its own."""
        self.scratch = Scratch()
        self.own_postgres = None
        try:
            self.own_postgres = None if postgres else Postgres(self.scratch)
            self.postgres = postgres or self.own_postgres
            self.database = "rig_" + secrets.token_hex(4)
            url = self.postgres.new_database(self.database)
            flags = (*flags, *(prepare(self.scratch.path) if prepare else ()))
            migrate(url)
            self.fleet = Fleet(self.scratch, url, flags)
            for _ in range(front_ends):
                self.fleet.add_front_end(*front_flags)
            for _ in range(workers):
                self.fleet.add_worker(*worker_flags)
            self.fleet.wait()
        except BaseException:
            self._close_servers()
            raise
        self.front_ends, self.workers = self.fleet.front_ends, self.fleet.workers

    def client(self, number=0, token=None):
        return Client(self.front_ends[number], token)

    def query(self, sql):
        return self.postgres.query(sql, self.database)

    def close(self):
        self.fleet.kill_all()
        self._close_servers()

    def _close_servers(self):
        if self.own_postgres:
            self.own_postgres.close()
        self.scratch.close()

    def stop(self):
        """Ends everything in order, and fails if an end fails."""
        try:
            for one in self.fleet.all():
                if one.process is not None:
                    one.terminate()
            for one in self.fleet.all():
                if one.process is not None:
                    one.ended()
        finally:
            self.close()

    def __enter__(self):
        return self

    def __exit__(self, kind, *_):
        if kind is None:
            self.stop()
        else:
            self.close()


def holds(document, distance):
    """Whether the interval of the result holds the distance."""
    interval = document["result"]["distance"]
    return interval["lower"] <= distance <= (float("inf") if interval["upper"] is None else interval["upper"])


__all__ = ["ASYNC", "ENDED", "Client", "Rig", "comparison", "endless", "holds", "post_head", "square", "until"]
