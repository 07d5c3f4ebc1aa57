#!/usr/bin/env python3
"""Faults of a cluster, one at a time. Each function raises AssertionError for a promise that was not kept, and returns a line of
figures; it leaves the rig as it was. test_troubles.py runs them quickly; as a command, with the service's own times:

    troubles.py stopped|poison|gone|drained|broken|clocks [--seconds N]
"""

import argparse
import datetime
import time

from rig import ASYNC, ENDED, Client, Rig, endless, holds, square, until

# Short times, for quick tests. While the database is gone, no lease may expire.
BRIEF = ("--lease-ms", "1500", "--heartbeat-ms", "300")
BRIEF_WITH_LEASES = ("--lease-ms", "10000", "--heartbeat-ms", "300")
REAL = ()
MAX_TRIES = 5
TEN_MINUTES = 600


def rig_of(flags, postgres=None):
    return Rig(2, 1, flags, worker_flags=("--workers", "2", "--grace-ms", "300"), postgres=postgres)


def rows_changed(rig, path):
    """A value that changes with every write to the job's row."""
    return rig.query("SELECT xmin, ctid FROM jobs WHERE id = '%s'" % path.rsplit("/", 1)[1])


def stopped(rig, timeout_ms=1500):
    """A worker that was stopped past its lease wakes up with a result that is not wanted any more."""
    client, first = rig.client(), rig.workers[0]
    path = client.begin_endless(timeout_ms)
    client.wait_for(path, "running")
    first.pause()
    began = time.monotonic()
    second = rig.fleet.add_worker("--workers", "2")
    second.wait_ready()
    document = client.wait_for(path, *ENDED, seconds=300)
    seconds = time.monotonic() - began
    assert (document["state"], document["tries"]) == ("done", 2), document
    row = rows_changed(rig, path)
    first.go_on()
    second.stop()
    after = client.wait_for(client.begin(0, 3, salt="afterwards"), *ENDED)
    assert (after["state"], after["tries"]) == ("done", 1) and holds(after, 3), after
    first.stop()  # it has nothing left to say
    first.start()
    assert client.get(path).json() == document, "a late result was taken"
    assert rows_changed(rig, path) == row, "its row was written again"
    return "stopped: done by another %.1f s after the stop, the late result refused" % seconds


def poison(rig):
    """A job whose worker dies each time is given up, and does not fail other jobs."""
    client, worker = rig.client(), rig.workers[0]
    path = client.begin_endless()
    others = [client.begin(0, height, salt="beside") for height in range(1, 9)]
    for tries in range(1, MAX_TRIES + 1):
        until(lambda: has_begun(client.get(path).json(), tries), 300, "try %d" % tries)
        worker.kill()
        others.append(client.begin(0, len(others) + 1, salt="beside"))
        worker.start()
    document = client.wait_for(path, *ENDED, seconds=300)
    assert (document["state"], document["tries"], document["result"]) == ("failed", MAX_TRIES, None), document
    assert "given up: " in document["problem"]["detail"], document
    for number, other in enumerate(others):
        ended = client.wait_for(other, *ENDED)
        assert ended["state"] == "done" and holds(ended, number + 1), ended
    tries = [client.get(other).json()["tries"] for other in others]
    return "poison: failed after %d tries (%s), %d others done after at most %d" % (
        MAX_TRIES, document["problem"]["detail"], len(others), max(tries))


def has_begun(document, tries):
    """Whether this try runs, or a later one: a lease may expire under a worker that a busy machine does not let run."""
    return document["state"] == "running" and document["tries"] >= tries


def gone(rig, seconds):
    """The database is away. Front ends say so, and a worker goes on and delivers."""
    clients = [rig.client(number) for number in (0, 1)]
    path = clients[0].begin_endless(int(1000 * seconds / 2) + 500)
    clients[0].wait_for(path, "running")
    ended = clients[1].begin(0, 4)
    clients[1].wait_for(ended, "done")
    rig.postgres.stop()
    try:
        asked = refused(rig, clients, path, ended, time.monotonic() + seconds)
    finally:
        rig.postgres.start()
    began = time.monotonic()
    document = clients[1].wait_for(path, *ENDED, away=True)
    back = time.monotonic() - began
    assert (document["state"], document["tries"]) == ("done", 1), document
    assert document["result"]["status"] in ("timeout", "budget") and holds(document, 0), document
    for client in clients:
        until(lambda: client.compare(square(0), square(5)).status == 200, what="the first after it")
    return "gone for %.0f s: %d rounds of refusals; delivered %.1f s after its return, in the first try" % (seconds, asked, back)


def refused(rig, clients, path, ended, end):
    """How often front ends refused everything until then."""
    asked = 0
    while time.monotonic() < end or asked == 0:
        for number, client in enumerate(clients):
            check_refusals(client, path, ended)
            assert rig.front_ends[number].ask("GET", "/healthz").status == 200
            assert rig.front_ends[number].ask("GET", "/readyz").status == 503
        asked += 1
        time.sleep(0.1)
    assert rig.workers[0].ask("GET", "/healthz").status == 200
    return asked


def check_refusals(client, running, ended):
    """Asserts that requests of all kinds get a 503 with Retry-After."""
    for answer in (client.compare(), client.compare(extra=ASYNC), client.compare(extra="Idempotency-Key: gone\r\n"), client.get(running),
                   client.get(ended), client.send("DELETE", ended), client.send("POST", "/v1/meshes", square(9))):
        assert answer is not None and answer.status == 503, answer and (answer.status, answer.body)
        assert int(answer.headers["retry-after"]) > 0, answer.headers


def drained(rig):
    """SIGTERM: a worker hands back what it cannot finish within its grace, with the interval; that counts as no try."""
    client, first = rig.client(), rig.workers[0]
    path, known = begun_endless(client, 4000)
    began = time.monotonic()
    first.stop()
    seconds = time.monotonic() - began
    document = client.get(path).json()
    assert document["state"] == "queued", document
    kept, identity = interval_of(document), path.rsplit("/", 1)[1]
    said = [line["detail"] for line in first.lines() if line["event"] == "handed_back"]
    assert said == ["1 job: " + identity], said
    assert kept and kept[0] >= known[0] and kept[1] <= known[1], (known, document)
    first.start()
    document = client.wait_for(path, *ENDED)
    assert document["state"] == "done" and holds(document, 0), document
    return "drained in %.1f s: handed back with [%r, %r], done by the next" % (seconds, *kept)


def begun_endless(client, timeout_ms):
    """The path and the first interval of a running comparison. If one ends before its interval was seen, begins another."""
    for _ in range(10):
        path = client.begin_endless(timeout_ms)
        document = until(lambda: (now := client.get(path).json()) and (interval_of(now) or now["state"] in ENDED) and now, what="its first interval")
        if document["state"] not in ENDED:
            return path, interval_of(document)
    raise AssertionError("ten comparisons ended before they were seen to run")


def interval_of(document):
    progress = document["progress"]
    return progress and progress["upper"] is not None and (progress["lower"], progress["upper"])


def broken(rig):
    """A front end dies while a client waits at it. Durable jobs go on."""
    one, other = rig.client(0), rig.client(1)
    key = "Idempotency-Key: broken\r\n"
    with one.connect() as connection:
        connection.sendall(one.request_of(**endless(2000), extra=key))
        until(lambda: running(rig) == 1, what="it to run")
        rig.front_ends[0].kill()
        try:
            assert connection.recv(1) == b"", "an answer of the dead"
        except ConnectionResetError:
            pass
    answer = other.compare(**endless(2000), extra=key)
    assert answer.status == 200 and answer.json()["status"] == "timeout", answer.body
    document = other.get(answer.headers["location"]).json()
    assert (document["state"], document["tries"]) == ("done", 1), document
    rig.front_ends[0].start()
    assert Client(rig.front_ends[0]).get(answer.headers["location"]).json() == document
    return "broken: the job went on and was found by its key at the other front end"


def clocks_rig(flags, postgres=None):
    """A front end and a worker ten minutes behind the database, and one of each ten minutes ahead of it."""
    rig = Rig(0, 0, flags, postgres=postgres)
    try:
        for clock in (-TEN_MINUTES, TEN_MINUTES):
            rig.fleet.add_front_end(clock=clock)
            rig.fleet.add_worker("--workers", "1", "--grace-ms", "300", clock=clock)
        rig.fleet.wait()
    except BaseException:
        rig.close()
        raise
    return rig


def clocks(rig, timeout_ms=1500):
    """Processes that disagree about the time. All times are the database's, no lease is over before its time, and nothing
    expires. `timeout_ms`: of a job; after 15 s processes look for leases that are over."""
    clients = [rig.client(number) for number in (0, 1)]
    check_clocks(rig)
    now = float(rig.query("SELECT extract(epoch FROM clock_timestamp())"))
    paths = [(height, client.begin(0, height, salt="clocks")) for height in range(1, 5) for client in clients]
    long, watched = clients[0].begin_endless(timeout_ms), clients[1].begin_endless(8000)
    elapsed = [elapsed_seen(front, watched) for front in rig.front_ends]
    assert clients[0].send("DELETE", watched).status in (200, 204)
    assert all(0 < most < TEN_MINUTES * 500 for most in elapsed), "ms since it began, by both clocks: %s" % elapsed
    for height, path in [*paths, (0, long)]:
        document, other = (client.wait_for(path, *ENDED, seconds=300) for client in clients)
        assert document == other, "two answers of one job"
        assert (document["state"], document["tries"]) == ("done", 1) and holds(document, height), document
        times = [since_1970(document[name]) for name in ("created", "started", "finished", "expires")]
        # Front ends and workers estimate the database's clock, each within a moment.
        assert all(one <= next_ + 1 for one, next_ in zip(times, times[1:])) and abs(times[0] - now) < TEN_MINUTES / 2, (now, document)
        assert times[-1] - times[-2] > TEN_MINUTES, "it is kept for too short: %s" % document
    key = "Idempotency-Key: clocks\r\n"
    first, again = (client.compare(square(0), square(2), extra=key) for client in clients)
    assert (first.status, first.json()) == (again.status, again.json()), (first.body, again.body)
    waited = clients[1].compare(square(0), square(6), extra="Prefer: wait=60\r\n")
    assert waited.status == 200 and holds({"result": waited.json()}, 6), waited.body
    return "clocks that are 20 minutes apart: %d jobs done in their first try" % (len(paths) + 1)


def check_clocks(rig):
    """Asserts that the clocks of the processes are wrong indeed."""
    for among in (rig.front_ends, rig.workers):
        for process, clock in zip(among, (-TEN_MINUTES, TEN_MINUTES)):
            said = since_1970(process.lines()[-1]["time"])
            assert abs(said - time.time() - clock) < TEN_MINUTES / 2, "%s logs at %r" % (process.name, said)


def since_1970(text):
    return datetime.datetime.fromisoformat(text.replace("Z", "+00:00")).timestamp()


def elapsed_seen(front_end, path):
    """The first elapsed_ms above 0 of the events of a job; 0: there was none."""
    told = (data["elapsed_ms"] for name, data in front_end.events(path + "/events") if name == "progress")
    return next((elapsed for elapsed in told if elapsed > 0), 0)


def running(rig):
    return int(rig.query("SELECT count(*) FROM jobs WHERE state = 1"))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("what", choices=["stopped", "poison", "gone", "drained", "broken", "clocks"])
    parser.add_argument("--seconds", type=float, default=60, help="of gone and of the long job of clocks: how long")
    arguments = parser.parse_args()
    runs = {"stopped": lambda rig: stopped(rig, 5000), "poison": poison, "gone": lambda rig: gone(rig, arguments.seconds),
            "drained": drained, "broken": broken, "clocks": lambda rig: clocks(rig, int(1000 * arguments.seconds))}
    with clocks_rig(BRIEF_WITH_LEASES) if arguments.what == "clocks" else rig_of(REAL) as rig:
        print(runs[arguments.what](rig), flush=True)


if __name__ == "__main__":
    main()
