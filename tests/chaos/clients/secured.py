"""TLS: what is none, hellos that are cut, repeated or left, and records, alerts and updates of keys without end."""

import contextlib
import ssl
import struct
import subprocess
import sys
import time
import warnings

from clients.arena import half_close, reset
from clients.attack import HEALTH, Broken, Family, Skipped, demand, with_tls
from harness import ROOT, post_head
from test_tls import Pipe, client, recorded_hello

sys.path.append(str(ROOT / "tests/load"))
from handshakes import Flood  # noqa: E402

NONE, HELLOS, RECORDS, CHOICES, FLOODS = (Family(name, with_tls) for name in ("no TLS", "hellos", "records",
        "versions and ciphers", "floods of hellos"))
FAMILIES = (NONE, HELLOS, RECORDS, CHOICES, FLOODS)
ALERT, HANDSHAKE, DATA, HEARTBEAT, CHANGE = 21, 22, 23, 24, 20
OPENSSL_SECONDS = 30


def record(kind, content, version=b"\x03\x03"):
    return struct.pack("!B2sH", kind, version, len(content)) + content


def spoken(arena, data, end=None):
    """Sends bytes below TLS and ends its half, or ends as told. The service closes, and serves nothing in the clear."""
    connection = arena.service.plain(arena.source)
    with connection, contextlib.suppress(OSError):
        connection.sendall(data)
        if end:
            return end(connection)
        half_close(connection)
        connection.settimeout(30)
        received = b""
        while piece := connection.recv(65536):
            received += piece
        demand(not received.startswith(b"HTTP/1.1 2"), "plain HTTP is served:", received[:200])


def says(family, name, data, end=None):
    def act(arena):
        spoken(arena, data() if callable(data) else data, end)
        arena.ask(HEALTH, 200)
    family.add(name, act)


# --- no TLS -----------------------------------------------------------------------------------------------------------

for name, data in (
        ("a request", HEALTH.replace(b"@KEY@", b"")), ("a request with a body", post_head(100) + bytes(100)),
        ("DELETE", b"DELETE / HTTP/1.1\r\n\r\n"), ("zeros", bytes(100)),
        ("bytes beyond ASCII", bytes(range(128, 256)) * 10),
        ("SSLv2", b"\x80\x2e\x01\x00\x02\x00\x15\x00\x00\x00\x10" + bytes(40)), ("SSH", b"SSH-2.0-x\r\n"),
        ("a letter", b"G"), ("a record of 65,535 bytes", b"\x16\x03\x01\xff\xff" + b"x" * 70_000),
        ("a record of no bytes", record(HANDSHAKE, b"") * 50), ("an alert", record(ALERT, b"\x02\x28")),
        ("a thousand alerts", record(ALERT, b"\x01\x5a") * 1000), ("data before a hello", record(DATA, HEALTH)),
        ("a change of ciphers", record(CHANGE, b"\x01") * 100),
        ("a heartbeat", record(HEARTBEAT, b"\x01\xff\xff")), ("a record of another kind", record(99, b"x" * 50)),
        ("a hello of another kind", record(HANDSHAKE, b"\x02\0\0\x05hello")),
        ("a hello of 16 MB", record(HANDSHAKE, b"\x01\xff\xff\xff" + bytes(16_000)) * 40),
        ("an empty hello", record(HANDSHAKE, b"\x01\0\0\0"))):
    says(NONE, name, data)

# --- hellos -----------------------------------------------------------------------------------------------------------

for length in (1, 2, 3, 5, 6, 9, 11, 43, 44, 76, 100, 200, -1):
    says(HELLOS, "%d bytes of one, then the end" % length, lambda length=length: recorded_hello()[:length])
    says(HELLOS, "%d bytes of one, then a reset" % length, lambda length=length: recorded_hello()[:length], reset)
says(HELLOS, "one, then a reset", recorded_hello, reset)
says(HELLOS, "one, then plain HTTP", lambda: recorded_hello() + HEALTH)
says(HELLOS, "one, twice", lambda: recorded_hello() * 2)
says(HELLOS, "one, a thousand times", lambda: recorded_hello() * 1000)
says(HELLOS, "one, then garbage", lambda: recorded_hello() + bytes(range(256)) * 20)
says(HELLOS, "one in records of a byte",
     lambda: b"".join(record(HANDSHAKE, recorded_hello()[5:][i:i + 1]) for i in range(len(recorded_hello()) - 5)))
for place in (6, 9, 11, 43, 44, 77, 80, 120, 160):
    says(HELLOS, "one with the byte %d changed" % place,
         lambda place=place: recorded_hello()[:place] + b"\xff" + recorded_hello()[place + 1:])


@HELLOS.does("silent ones, which are cut")
def _(arena):
    for first in (b"", recorded_hello()[:1], recorded_hello()[:100]):
        with arena.service.plain(arena.source) as connection:
            connection.sendall(first)
            arena.closes(connection)


@HELLOS.does("a handshake that is finished and left")
def _(arena):
    for end in (reset, half_close, lambda connection: connection.close()):
        with arena.connect() as connection:
            end(connection)


# --- records ----------------------------------------------------------------------------------------------------------


def piped(arena):
    """TLS whose records are made here."""
    class Listening:
        plain = staticmethod(lambda: arena.service.plain(arena.source))
    for _ in range(20):
        try:
            return Pipe(Listening)
        except (ssl.SSLError, OSError):  # refused for a rate
            time.sleep(0.3)
    raise Broken("no handshake is taken")


def rest_of(pipe):
    """What the service sends until it closes; nothing when that is by a reset."""
    try:
        return pipe.rest()
    except ConnectionError:
        return b""


@RECORDS.does("one for each byte of a request")
def _(arena):
    pipe = piped(arena)
    for byte in HEALTH.replace(b"@KEY@", b""):
        pipe.tls.write(bytes([byte]))
        pipe.flush()
    pipe.tls.write(b"GET /none HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n")
    pipe.flush()
    demand(rest_of(pipe).count(b"HTTP/1.1 ") == 2, "answers to records of a byte")
    pipe.socket.close()


@RECORDS.does("with a byte changed")
def _(arena):
    pipe = piped(arena)
    pipe.tls.write(HEALTH.replace(b"@KEY@", b""))
    data = bytearray(pipe.outgoing.read())
    data[-1] ^= 1
    pipe.socket.sendall(data)
    demand(b"HTTP/1.1" not in rest_of(pipe), "a record that was changed is served")
    pipe.socket.close()


@RECORDS.does("the same twice")
def _(arena):
    pipe = piped(arena)
    pipe.tls.write(HEALTH.replace(b"@KEY@", b""))
    pipe.socket.sendall(pipe.outgoing.read() * 2)
    demand(rest_of(pipe).count(b"HTTP/1.1 200") <= 1, "a record that was repeated is served")
    pipe.socket.close()


for name, data in (("garbage", bytes(range(256)) * 8), ("plain HTTP", HEALTH), ("a hello", None),
                   ("alerts", record(ALERT, b"\x01\x5a") * 500), ("empty records", record(DATA, b"") * 500),
                   ("a record that is too long", record(DATA, b"")[:3] + b"\x48\x00" + bytes(0x4800)),
                   ("changes of ciphers", record(CHANGE, b"\x01") * 500)):
    @RECORDS.does("%s behind a handshake" % name)
    def _(arena, data=data):
        pipe = piped(arena)
        with contextlib.suppress(OSError):
            pipe.socket.sendall(data or recorded_hello())
            pipe.socket.settimeout(10)
            while pipe.socket.recv(65536):
                pass
        pipe.socket.close()
        arena.ask(HEALTH, 200)


@RECORDS.does("the end of the data, then more of it")
def _(arena):
    pipe = piped(arena)
    pipe.tls.write(HEALTH.replace(b"@KEY@", b""))
    pipe.flush()
    pipe.say_goodbye()
    with contextlib.suppress(OSError):
        pipe.socket.sendall(record(DATA, bytes(500)))
    rest_of(pipe)
    pipe.socket.close()


def by_openssl(arena, commands, *flags):
    """What `openssl s_client` writes that is given these commands."""
    try:
        process = subprocess.Popen(["openssl", "s_client", "-connect", "127.0.0.1:%d" % arena.service.port, "-bind",
                                    arena.source + ":0", *flags],
                                   stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    except FileNotFoundError:
        raise Skipped("no openssl") from None
    try:
        return process.communicate(commands, timeout=OPENSSL_SECONDS)[0]
    except subprocess.TimeoutExpired:
        process.kill()
        return process.communicate()[0]


@RECORDS.does("a renegotiation")
def _(arena):
    said = by_openssl(arena, b"R\n", "-tls1_2")
    demand(b"RENEGOTIATING" not in said or b"no renegotiation" in said or b"error" in said, said[-300:])


@RECORDS.does("a thousand updates of keys")
def _(arena):
    by_openssl(arena, b"K\n" * 1000 + b"Q\n", "-tls1_3")
    arena.ask(HEALTH, 200)


# --- versions and ciphers ---------------------------------------------------------------------------------------------


def chosen(arena, change, taken):
    """A handshake whose client insists on something; whether it is taken."""
    context = client()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # that some of it is old is the point
        change(context)
    for _ in range(20):
        try:
            with context.wrap_socket(arena.service.plain(arena.source), server_hostname="localhost") as connection:
                demand(taken, "taken: %s, %s" % (connection.version(), connection.cipher()))
                return
        except (ConnectionError, ssl.SSLEOFError):  # closed without a word, as for a rate
            time.sleep(0.3)
        except ssl.SSLError as error:
            return demand(not taken, error)
    demand(not taken, "no handshake is taken")


def limits(**values):
    def change(context):
        context.set_ciphers("ALL:@SECLEVEL=0")
        for name, value in values.items():
            setattr(context, name, value)
    return change


for version, taken in (("TLSv1", False), ("TLSv1_1", False), ("TLSv1_2", True), ("TLSv1_3", True)):
    one = getattr(ssl.TLSVersion, version)
    CHOICES.add(version, lambda arena, one=one, taken=taken: chosen(arena,
            limits(minimum_version=one, maximum_version=one), taken))
for cipher in ("AES128-SHA", "ECDHE-ECDSA-AES128-SHA256", "NULL-SHA256", "ADH-AES128-SHA", "AES256-GCM-SHA384"):
    def weak(context, cipher=cipher):
        context.maximum_version = ssl.TLSVersion.TLSv1_2
        try:
            context.set_ciphers(cipher + ":@SECLEVEL=0")
        except ssl.SSLError:
            raise Skipped("this OpenSSL has no %s" % cipher) from None
    CHOICES.add(cipher, lambda arena, weak=weak: chosen(arena, weak, False))
for protocols, taken in ((["h2"], False), (["http/1.0"], False), (["x" * 255], False), (["h2", "http/1.1"], True)):
    CHOICES.add("ALPN %s" % ", ".join(protocols)[:20], lambda arena, protocols=protocols,
                taken=taken: chosen(arena, lambda context: context.set_alpn_protocols(protocols), taken))

# --- floods -----------------------------------------------------------------------------------------------------------

FLOOD_SECONDS = 4


def flooded(arena, rate, addresses):
    """Repeats a recorded hello, while another client shakes hands and is answered."""
    flood, end, served = Flood(arena.service.port, rate, addresses), time.monotonic() + FLOOD_SECONDS, 0
    try:
        while time.monotonic() < end:
            with arena.service.connect() as connection:  # of an address that has its own handshakes
                connection.sendall(HEALTH.replace(b"@KEY@", b""))
                answer = arena.read(connection.makefile("rb"))
                demand(answer is not None and answer.status == 200, "an honest client beside a flood:",
                       answer and answer.status)
                served += 1
            time.sleep(0.1)
    finally:
        flood.end()
    demand(served > 0, "no honest handshake beside a flood")


for rate, addresses in ((500, 1), (2000, 1), (2000, 40)):
    FLOODS.add("%d a second of %d addresses" % (rate, addresses), lambda arena, rate=rate,
               addresses=addresses: flooded(arena, rate, addresses), alone=True)


@FLOODS.does("three hundred that are left at once", alone=True)
def _(arena):
    hello = recorded_hello()
    for i in range(300):
        connection = arena.service.plain(arena.address(i))
        with contextlib.suppress(OSError):
            connection.sendall(hello)
        reset(connection)
    arena.ask(HEALTH, 200)
