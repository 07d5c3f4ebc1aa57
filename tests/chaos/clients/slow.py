"""Clients that send slowly, read slowly or never, end their half, or reset their connection at every point."""

import contextlib
import select
import socket
import time

from clients.arena import endless, half_close, holds, reset, stall
from clients.attack import CHUNKED, FORM, HEALTH, Family, chunks, demand, post, request
from clients.bodies import BODY, HEAD_BYTES, WHOLE
from harness import multipart
from victim import square

SENDERS, READERS, POINTS, HALVES, CROWDS, GONE = (
    Family(name) for name in ("slow senders", "slow readers", "resets", "half-closed", "crowds", "clients that vanish"))
FAMILIES = (SENDERS, READERS, POINTS, HALVES, CROWDS, GONE)
TCP_REPAIR = 19

# --- slow senders -----------------------------------------------------------------------------------------------------


def late(arena, start, rest, pause):
    """What arrives too slowly is answered 408, though a byte comes each `pause` seconds all the while."""
    def attempt():
        with arena.connect(silent=True) as connection:
            arena.send(connection, arena.filled(start))
            with contextlib.suppress(OSError):
                for i in range(len(rest)):
                    connection.sendall(rest[i:i + 1])
                    if select.select([connection], [], [], pause)[0]:
                        break
            answer = arena.read(connection.makefile("rb"))
        if answer is not None and answer.status in (429, 503):
            return None
        demand(answer is None or answer.status == 408, answer and answer.status)
        return True
    arena.patiently(attempt)


for name, start, rest in (("a line", b"GET /", b"x" * 200), ("a header", b"GET / HTTP/1.1\r\nX: ", b"x" * 200),
                          ("empty lines", b"\r\n", b"\r\n" * 100),
                          ("headers", b"GET / HTTP/1.1\r\n", b"a:b\r\n" * 40),
                          ("a body", post(BODY)[:HEAD_BYTES + 20], BODY[20:]),
                          ("chunks", request(b"POST /v1/comparisons", FORM, CHUNKED), b"1\r\n-\r\n" * 40),
                          ("a chunk's size", request(b"POST /v1/comparisons", FORM, CHUNKED), b"0" * 200)):
    SENDERS.add("of " + name, lambda arena, start=start, rest=rest: late(arena, start, rest, 0.04))
for name, start in (("before a byte", b""), ("in a line", b"GET /heal"), ("in a header", b"GET / HTTP/1.1\r\nX: "),
                    ("before the empty line", HEALTH[:-2])):
    @SENDERS.does("silent " + name)
    def _(arena, start=start):
        with arena.connect() as connection:
            connection.sendall(start.replace(b"@KEY@", b""))
            arena.closes(connection)
SENDERS.sends("a body that stops", WHOLE[:-50], 408)
SENDERS.sends("chunks that stop", request(b"POST /v1/comparisons", FORM, CHUNKED) + chunks(BODY)[:60], 408)
SENDERS.sends("an upload that stops", request(b"POST /v1/meshes", b"Content-Length: 500000") + b"#" * 300_000, 408)


def in_haste(connection, data):
    """With pauses that are just short enough: a body that never stops for too long is taken."""
    connection.sendall(data[:-60])
    for i in range(-60, 0, 20):
        time.sleep(0.3)
        connection.sendall(data[i:i + 20 or None])


SENDERS.sends("pauses that are just short enough", WHOLE, 200, send=in_haste)

# --- slow readers -----------------------------------------------------------------------------------------------------


def unread(arena, data, seconds=0.5, piece=0):
    """Asks, and then reads so many bytes each hundredth of a second, or none."""
    with arena.connect() as connection:
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        connection.settimeout(0.3)
        with contextlib.suppress(OSError):
            connection.sendall(arena.filled(data))
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            time.sleep(0.01)
            with contextlib.suppress(OSError):
                if piece and not connection.recv(piece):
                    return
    arena.ask(HEALTH, 200)


for name, data in (("the description", request(b"GET /openapi.yaml")),
                   ("the page", request(b"GET /", b"Accept: text/html")), ("the reference", request(b"GET /docs")),
                   ("its script", request(b"GET /docs/swagger-ui-bundle.js")),
                   ("a hundred descriptions", request(b"GET /openapi.yaml") * 100),
                   ("answers to a thousand requests", HEALTH * 1000), ("refusals", request(b"GET /none") * 1000),
                   ("a comparison", WHOLE)):
    READERS.add("that read nothing of " + name, lambda arena, data=data: unread(arena, data))
    READERS.add("that read a byte at a time of " + name, lambda arena, data=data: unread(arena, data, piece=1))


@READERS.does("fifty that read nothing of a script")
def _(arena):
    with contextlib.ExitStack() as stack:
        for i in range(50):
            connection = stack.enter_context(arena.connect(arena.address(i)))
            connection.sendall(request(b"GET /docs/swagger-ui-bundle.js").replace(b"@KEY@", b""))
        arena.ask(HEALTH, 200)


@READERS.does("that read an answer after all")
def _(arena):
    """Slow is not lost: the bytes are whole."""
    with arena.connect() as connection:
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        connection.sendall(arena.filled(request(b"GET /openapi.yaml")))
        time.sleep(0.5)
        answer = arena.read(connection.makefile("rb"))
    demand(answer is not None and len(answer.body) == int(answer.headers["content-length"]), "an answer is cut off")


# --- resets -----------------------------------------------------------------------------------------------------------

STOPS = {"before a byte": 0, "after a byte": 1, "in the line": 12, "before the empty line": HEAD_BYTES - 2,
         "after the head": HEAD_BYTES, "in the body": HEAD_BYTES + 100,
         "a byte before the end": -1, "at the end": None}
for name, stop in STOPS.items():
    @POINTS.does("by a reset " + name)
    def _(arena, stop=stop):
        connection = arena.connect()
        connection.sendall(arena.filled(WHOLE)[:stop])
        reset(connection)

    @POINTS.does("by a close " + name)
    def _(arena, stop=stop):
        with arena.connect() as connection:
            connection.sendall(arena.filled(WHOLE)[:stop])

    @HALVES.does(name)
    def _(arena, stop=stop):
        def attempt():
            with arena.connect() as connection:
                arena.send(connection, arena.filled(WHOLE)[:stop])
                half_close(connection)
                answer = arena.read(connection.makefile("rb"))
            if answer is None and (stop == 0 or arena.variant.tls):  # TLS whose end is not said is broken
                return True
            allowed = (200, 409, 503) if stop is None else (400,)  # a whole one is cancelled
            if answer is None or answer.status in (408, 429, 503) and answer.status not in allowed:
                return None
            demand(answer.status in allowed, answer.status, answer.body)
            return True
        arena.patiently(attempt)


@POINTS.does("in the middle of an answer")
def _(arena):
    for _ in range(20):
        connection = arena.connect()
        connection.sendall(arena.filled(request(b"GET /openapi.yaml")))
        connection.recv(100)
        reset(connection)


@POINTS.does("behind refusals that are not read")
def _(arena):
    for data in (post(BODY, kind=b"Content-Type: text/plain"), b"x" * 5000,
                 request(b"POST /v1/comparisons", FORM, b"Content-Length: 10000000000"), WHOLE[:-1] + b"!"):
        connection = arena.connect()
        with contextlib.suppress(OSError):
            connection.sendall(arena.filled(data))
        reset(connection)


@HALVES.does("and then silent for ever")
def _(arena):
    with arena.connect() as connection:
        half_close(connection)
        arena.closes(connection)


@HALVES.does("while an upload is slow")
def _(arena):
    with arena.connect() as connection:
        connection.sendall(arena.filled(request(b"POST /v1/meshes", b"Content-Length: 100000")) + b"#" * 500)
        stall()
        with contextlib.suppress(OSError):
            half_close(connection)
        arena.closes(connection)


# --- crowds -----------------------------------------------------------------------------------------------------------


def crowd(arena, count, data, source=None):
    """So many connections that have sent this, as far as the service takes them; of many addresses, or of one. None:
    not even the first byte of TLS."""
    connections = []
    for i in range(count):
        with contextlib.suppress(OSError):  # refused, or no descriptor is left
            address = source or arena.address(i)
            connections.append(arena.service.plain(address) if data is None else arena.service.connect(address,
                    tries=1))
            connections[-1].sendall(arena.filled(data or b""))
    return connections


def beside(arena, connections):
    """Asserts that another client is served, and lets the crowd go."""
    try:
        arena.ask(HEALTH, 200, source="127.0.0.1")
    finally:
        for connection in connections:
            connection.close()


for name, count, data in (("idle", 300, None), ("that have been answered", 200, HEALTH),
                          ("of half a line", 300, b"GET /heal"), ("of half a header", 300, b"GET / HTTP/1.1\r\nX: "),
                          ("of half a body", 60, WHOLE[:-50]), ("of bodies that are expected", 60,
                           request(b"POST /v1/meshes", b"Content-Length: 1000", b"Expect: 100-continue")),
                          ("that never read", 100, request(b"GET /openapi.yaml") * 20)):
    CROWDS.add("%d connections %s" % (count, name), lambda arena, count=count,
               data=data: beside(arena, crowd(arena, count, data)), alone=True)
    CROWDS.add("%d connections of one address %s" % (count, name), lambda arena, count=count,
               data=data: beside(arena, crowd(arena, count, data, "127.0.3.1")), alone=True)


@CROWDS.does("connected and closed five hundred times")
def _(arena):
    for i in range(500):
        connection = arena.service.plain(arena.address(i))
        if i % 2:
            reset(connection)
        connection.close()


@CROWDS.does("a hundred comparisons at once", alone=True)
def _(arena):
    """Each is right or refused with a time to come back."""
    connections = crowd(arena, 100, post(multipart([("a", square(0, 8)), ("b", square(3, 8)), ("options", b"{}")])))
    served = 0
    for connection in connections:
        answer = arena.read(connection.makefile("rb"))
        demand(answer is None or answer.status in (200, 429, 503), answer and answer.status)
        served += answer is not None and answer.status == 200
        connection.close()
    demand(served > 0, "none of a hundred is served")


# --- clients that vanish ----------------------------------------------------------------------------------------------


def vanish(connection):
    """Closes without a word, as a machine that loses its power: no packet is sent."""
    try:
        connection.setsockopt(socket.IPPROTO_TCP, TCP_REPAIR, 1)
    except OSError:  # not allowed here: a reset comes near
        return reset(connection)
    connection.close()


for name, data in (("idle", b""), ("in a head", b"GET / HTT"), ("in a body", WHOLE[:-50]),
                   ("with an answer unread", request(b"GET /openapi.yaml") * 5), ("at once", WHOLE)):
    @GONE.does(name)
    def _(arena, data=data):
        connection = arena.connect()
        connection.sendall(arena.filled(data))
        vanish(connection)
        arena.ask(HEALTH, 200)


@GONE.does("and come back while their comparisons run", alone=True)
def _(arena):
    """A client that lost its connections is served again, at the latest when what it left behind is over."""
    for _ in range(8):
        connection = arena.connect()
        connection.sendall(arena.filled(endless(500)))
        vanish(connection)
    holds(arena.compare().json(), 2)
