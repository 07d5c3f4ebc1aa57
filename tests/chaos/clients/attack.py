"""What an attack is: a name, what it does, and where. The other files of this folder have tables of them."""

import dataclasses
import time
from collections.abc import Callable

KEY = b"@KEY@"  # in the bytes of an attack: the header with its key; nothing where the service has no keys
FORM = b"Content-Type: multipart/form-data; boundary=XXboundaryXX"
JSON = b"Content-Type: application/json"
CHUNKED = b"Transfer-Encoding: chunked"


class Broken(AssertionError):
    """The service did to an attack what it may not."""


class Skipped(Exception):
    """The machine does not let this attack be tried."""


def demand(condition, *what):
    if not condition:
        raise Broken(" ".join(str(part)[:600] for part in what))


def shown(data, most=40):
    """Bytes as a part of a name: their beginning, and how many there are."""
    text = repr(data[:most])[2:-1]
    return text if len(data) <= most else "%s... (%d bytes)" % (text, len(data))


def anywhere(_):
    return True


def with_tls(variant):
    return variant.tls


def without_tls(variant):
    return not variant.tls


def with_keys(variant):
    return variant.keys


def without_keys(variant):
    return not variant.keys


@dataclasses.dataclass(frozen=True)
class Attack:
    """`act` takes an Arena and raises an AssertionError for what may not be. `alone`: it uses up what all share, so
    that others would be refused beside it."""

    name: str
    act: Callable
    where: Callable = anywhere
    alone: bool = False

    def is_for(self, variant):
        family = self.name.partition(":")[0]
        return self.where(variant) and (not variant.families or family in variant.families)


class Family:
    """Attacks of one kind. `where`: on which variants of the service."""

    def __init__(self, name, where=anywhere):
        self.name, self.where, self.attacks = name, where, []

    def add(self, name, act, where=None, alone=False):
        self.attacks.append(Attack("%s: %s" % (self.name, name), act, where or self.where, alone))

    def sends(self, name, data, *answers, send=None, **more):
        """These bytes on one connection, which gets these answers (Arena.exchange()) and no other. `data` may be a
        function that makes the bytes."""
        self.add(name, lambda arena: arena.exchange(data, answers, send or at_once), **more)

    def table(self, rows, **more):
        """Each row: name, bytes, answers."""
        for name, data, *answers in rows:
            self.sends(name, data, *answers, **more)

    def does(self, name, **more):
        """A decorator: an attack that is a function of an arena."""
        def take(act):
            self.add(name, act, **more)
            return act
        return take


# --- bytes ------------------------------------------------------------------------------------------------------------


def request(line, *fields, body=b"", host=b"Host: localhost"):
    """A request: `line` is method and target, fields have no line ends. A body brings its length."""
    length = (b"Content-Length: %d" % len(body),) if body else ()
    return b"\r\n".join((line + b" HTTP/1.1", *((host,) if host else ()), *fields, *length, KEY + b"\r\n")) + body


def post(body, *fields, kind=FORM, line=b"POST /v1/comparisons"):
    return request(line, kind, *fields, body=body)


def chunks(body, size=None):
    """A body in chunks of this size, or in one."""
    size = size or max(len(body), 1)
    pieces = [body[i:i + size] for i in range(0, len(body), size)]
    return b"".join(b"%x\r\n%s\r\n" % (len(piece), piece) for piece in pieces) + b"0\r\n\r\n"


HEALTH = request(b"GET /healthz")
HIDDEN = b"GET /smuggled HTTP/1.1\r\nHost: localhost\r\n\r\n"  # a request that no parser may see


# --- ways of sending --------------------------------------------------------------------------------------------------


def at_once(connection, data):
    connection.sendall(data)


def in_pieces(size, pause=0.0):
    """`pause`: seconds between two pieces, each of which is a packet of its own."""
    def send(connection, data):
        for i in range(0, len(data), size):
            connection.sendall(data[i:i + size])
            time.sleep(pause)
    return send


def cut_at(*places):
    """Sends what lies between these bytes in packets of their own; a negative place counts from the end."""
    def send(connection, data):
        begin = 0
        for place in sorted(place % len(data) for place in places):
            connection.sendall(data[begin:place])
            time.sleep(0.005)
            begin = place
        connection.sendall(data[begin:])
    return send
