"""Sockets that remember what was asked on them, so that each answer can be held against its request."""

import re
import socket
import ssl

MOST_BYTES = 16 << 20  # that are remembered of one connection; what is longer is no request of interest


class Request:
    """What can be told from the bytes of a request; `body` is None unless all of it is known."""

    def __init__(self, method, path="", query="", headers=None, body=None):
        self.method, self.path, self.query, self.headers, self.body = method, path, query, headers or {}, body

    def __repr__(self):
        return "%s %s?%s %s" % (self.method, self.path, self.query, (self.body or b"")[:500])


def take_request(sent):
    """The first request of `sent`, and what follows it; nothing follows one that is not whole."""
    sent = sent.lstrip(b"\r\n")
    if not sent:
        return None, b""
    head, end, rest = sent.partition(b"\r\n\r\n")
    line = re.match(rb"([!-~]+) ((?:http://[^/? ]*)?)([/?][!-~]*|\*)(?: HTTP/[0-9.]+)?(?:\r\n|$)", head)
    if not line:
        return Request(head.split(b" ", 1)[0].decode("latin-1")), b""
    path, _, query = line[3].decode().partition("?")
    request = Request(line[1].decode(), path or "/", query, headers_of(head))
    if not end:
        return request, b""
    request.body, rest = take_body(request.headers, rest)
    return request, rest


def headers_of(head):
    headers = {}
    for field in head.split(b"\r\n")[1:]:
        name, colon, value = field.partition(b":")
        if colon:
            headers.setdefault(name.decode("latin-1").lower(), value.decode("latin-1").strip())
    return headers


def take_body(headers, rest):
    if headers.get("transfer-encoding", "").lower() == "chunked":
        return take_chunks(rest)
    length = headers.get("content-length", "0")
    if not length.isdigit() or int(length) > len(rest):
        return None, b""
    return rest[:int(length)], rest[int(length):]


def take_chunks(rest):
    line = re.compile(rb"([0-9a-fA-F]{1,15})(?:;[^\r\n]*)?\r\n")
    body, at = [], 0
    while size := line.match(rest, at):
        start, count = size.end(), int(size[1], 16)
        at = start + count + 2
        if count == 0:
            return b"".join(body), rest[start:].partition(b"\r\n")[2]
        if at > len(rest):
            break
        body.append(rest[start:start + count])
    return None, b""


class Remembering:
    """Mixed into a socket. What is sent is noted before it is sent: a refusal may come first."""

    sent = b""  # since the last request that was answered

    def remember(self, data):
        if len(self.sent) <= MOST_BYTES:
            self.sent = bytearray(self.sent) if isinstance(self.sent, bytes) else self.sent
            self.sent += data

    def answered(self):
        """The request of the answer that comes next."""
        request, rest = take_request(bytes(self.sent))
        self.sent = bytearray(rest)
        return request


class PlainSocket(Remembering, socket.socket):
    def send(self, data, *flags):
        self.remember(data)
        return super().send(data, *flags)

    def sendall(self, data, *flags):
        self.remember(data)
        return super().sendall(data, *flags)


class TlsSocket(Remembering, ssl.SSLSocket):
    def send(self, data, *flags):  # sendall() calls it
        count = super().send(data, *flags)
        self.remember(data[:count])
        return count


def connect(address, timeout, source):
    plain = socket.create_connection(address, timeout=timeout, source_address=source)
    connection = PlainSocket(fileno=plain.detach())
    connection.settimeout(timeout)
    return connection


def request_of(stream):
    """What the answer that comes next on a socket's file is for."""
    return stream.raw._sock.answered()
