"""Lines and headers that are none, that two parsers read differently, or that have no end."""

from clients.attack import HEALTH, HIDDEN, KEY, Family, in_pieces, request, without_tls

LINES, FIELDS, CHARACTERS, TWICE, LIMITS, METHODS, OLD = (
    Family(name) for name in ("request lines", "headers", "characters in headers", "headers twice", "long heads",
                              "methods", "HTTP/1.0"))
FAMILIES = (LINES, FIELDS, CHARACTERS, TWICE, LIMITS, METHODS, OLD)

HOST = b"Host: localhost\r\n"
END = HOST + b"\r\n"

# --- request lines ----------------------------------------------------------------------------------------------------

LINES.table([
    ("HTTP/0.9", b"GET /\r\n\r\n", 400),
    ("no target", b"GET HTTP/1.1\r\n" + END, 400),
    ("no method", b"/ HTTP/1.1\r\n" + END, 400),
    ("a blank before the method", b" GET /healthz HTTP/1.1\r\n" + END, 400),
    ("two blanks", b"GET  /healthz HTTP/1.1\r\n" + END, 400),
    ("two blanks before the version", b"GET /healthz  HTTP/1.1\r\n" + END, 400),
    ("a blank after the version", b"GET /healthz HTTP/1.1 \r\n" + END, (400, 505)),
    ("tabs", b"GET\t/healthz\tHTTP/1.1\r\n" + END, 400),
    ("a form feed", b"GET\x0c/healthz HTTP/1.1\r\n" + END, 400),
    ("lines that end with LF", b"GET /healthz HTTP/1.1\nHost: localhost\n\n", 400),
    ("the first line ends with LF", b"GET /healthz HTTP/1.1\n" + END, 505),
    ("lines that end with CR", b"GET /healthz HTTP/1.1\rHost: localhost\r\r" + b"\r\n\r\n", 505),
    ("CR in the line", b"GET /healthz\r HTTP/1.1\r\n" + END, 400),
    ("NUL in the target", b"GET /health\0z HTTP/1.1\r\n" + END, 400),
    ("NUL in the method", b"GE\0T /healthz HTTP/1.1\r\n" + END, 400),
    ("a quoted method", b'"GET" /healthz HTTP/1.1\r\n' + END, 400),
    ("a method with a bracket", b"GE(T /healthz HTTP/1.1\r\n" + END, 400),
    ("bytes beyond ASCII in the method", b"G\xc3\x89T /healthz HTTP/1.1\r\n" + END, 400),
    ("bytes beyond ASCII in the target", b"GET /h\xc3\xa9 HTTP/1.1\r\n" + END, 400),
    ("a version in lower case", b"GET /healthz http/1.1\r\n" + END, 400),
    ("another protocol", b"GET /healthz RTSP/1.0\r\n" + END, 400),
    ("HTTP/1.2", b"GET /healthz HTTP/1.2\r\n" + END, 505),
    ("HTTP/1.10", b"GET /healthz HTTP/1.10\r\n" + END, 505),
    ("HTTP/01.1", b"GET /healthz HTTP/01.1\r\n" + END, 505),
    ("HTTP/2.0", b"GET /healthz HTTP/2.0\r\n" + END, 505),
    ("HTTP/3", b"GET /healthz HTTP/3\r\n" + END, 505),
    ("HTTP/ alone", b"GET /healthz HTTP/\r\n" + END, 505),
    ("the preface of HTTP/2", b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n\0\0\0\x04\0\0\0\0\0", 505),
    ("SSH", b"SSH-2.0-OpenSSH_9.2\r\n\r\n", 400),
    ("SMTP", b"EHLO example.org\r\n\r\n", 400),
    ("SOCKS 5", b"\x05\x01\x00\r\n\r\n", 400),
    ("the PROXY protocol", b"PROXY TCP4 1.2.3.4 5.6.7.8 1 2\r\n" + HEALTH, 400),
    ("its second version", b"\r\n\r\n\0\r\nQUIT\n" + bytes(16) + HEALTH, 400),
    ("every byte", bytes(range(256)) * 4 + b"\r\n\r\n", 400),
    ("an empty head", b"\r\n" * 3 + HEALTH, 200),
    ("a request behind an empty head and a blank", b"\r\n \r\n" + HEALTH, 400),
    ("nothing but blanks", b" " * 500 + b"\r\n\r\n", 400),
    ("a line break in the target", b"GET /healthz HTTP/1.1\r\nX: y HTTP/1.1\r\n" + END, 200),
])
LINES.sends("TLS to a port without", b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03" + bytes(40), 400,
            where=without_tls)
LINES.sends("byte by byte", HEALTH, 200, send=in_pieces(1))

# --- headers ----------------------------------------------------------------------------------------------------------

for name, field in (
        ("no colon", b"X"), ("no name", b": a"), ("a blank in the name", b"X Y: a"),
        ("a blank before the colon", b"X : a"),
        ("a tab before the colon", b"X\t: a"), ("a folded line", b"X: a\r\n folded"),
        ("folded by a tab", b"X: a\r\n\tfolded"),
        ("a folded first line", b" X: a"), ("CR in a value", b"X: a\rHost: y"), ("LF in a value", b"X: a\nHost: y"),
        ("CR before the end", b"X: a\r"), ("NUL in a name", b"X\0: a"),
        ("a header of a proxy that is two", b"X: a\r\r\n"),
        ("a comment as a name", b"(X): a"), ("a quoted name", b'"X": a'),
        ("a colon behind a blank line's start", b"\x0bX: a"),
        ("bytes beyond ASCII in a name", b"X\xff: a"), ("a line of equals signs", b"===="),
        ("Expect of another kind", b"Expect: 200-ok"),
        ("Expect of two kinds", b"Expect: 100-continue, x"), ("an underscore and a blank", b"Content_Length : 5")):
    FIELDS.sends(name, request(b"GET /healthz", field), 400)
for name, field in (
        ("an empty value", b"X:"), ("no blank after the colon", b"X:y"), ("blanks around a value", b"X: \t y \t "),
        ("bytes beyond ASCII in a value", b"X: caf\xc3\xa9 \xff\xfe"),
        ("every character of a name", b"!#$%&'*+-.^_`|~: x"),
        ("a header that looks like a length", b"Content_Length: 5"), ("a length with a prefix", b"X-Content-Length: 5"),
        ("an upgrade", b"Connection: Upgrade, HTTP2-Settings\r\nUpgrade: h2c\r\nHTTP2-Settings: AAMAAABkAAQAoAAAAAIA"),
        ("a web socket", b"Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ=="),
        ("Connection of many options", b"Connection: " + b"x, " * 500 + b"keep-alive"),
        ("Connection that names Host", b"Connection: Host"),
        ("Connection that names the key", b"Connection: Authorization"),
        ("X-Forwarded-For", b"X-Forwarded-For: 127.0.0.1"),
        ("other methods by header", b"X-HTTP-Method-Override: DELETE"),
        ("other targets by header", b"X-Original-URL: /metrics"),
        ("a log line in a header", b'User-Agent: "}\\n{"event":"stopped"}'),
        ("escapes of a terminal", b"User-Agent: %1b[2J"),
        ("an encoded line break", b"X: %0d%0aSet-Cookie: x=1"), ("a cookie of 8 kB", b"Cookie: " + b"a=b; " * 1600),
        ("Accept of a thousand kinds", b"Accept: " + b"text/x;q=0.1," * 1000),
        ("Accept with broken weights", b"Accept: */*;q=1e999, text/html;q=-1, a/b;q"),
        ("Accept-Encoding of nothing", b"Accept-Encoding: *;q=0, gzip;q=0"), ("Range", b"Range: bytes=0-0"),
        ("If-Range", b'If-Range: "x"'), ("Max-Forwards", b"Max-Forwards: 0"), ("Trailer", b"Trailer: Content-Length"),
        ("TE", b"TE: trailers, chunked;q=0.5"),
        ("an empty Transfer-Encoding of a proxy", b"X-Transfer-Encoding: chunked"),
        ("a hundred headers", b"\r\n".join(b"H%d: v" % i for i in range(100)))):
    FIELDS.sends(name, request(b"GET /healthz", field), 200)
for name, value in (("no version", b"0af7651916cd43dd8448eb211c80319c"),
                    ("zeros", b"00-" + b"0" * 32 + b"-" + b"0" * 16 + b"-01"),
                    ("upper case", b"00-0AF7651916CD43DD8448EB211C80319C-00F067AA0BA902B7-01"),
                    ("too long", b"00-" + b"a" * 5000),
                    ("a line break", b"00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01%0d%0aX: y")):
    FIELDS.sends("traceparent: " + name, request(b"GET /healthz", b"traceparent: " + value,
                                                 b"tracestate: " + b"a=\xff" * 100), 200)

# --- characters -------------------------------------------------------------------------------------------------------

for code in [*range(9), 10, 11, 12, 13, *range(14, 32), 127]:
    CHARACTERS.sends("0x%02x in a value" % code, request(b"GET /healthz", b"X: a%cb" % code), 400)
for code in b'"(),/:;<=>?@[\\]{}':
    CHARACTERS.sends("%c in a name" % code, request(b"GET /healthz", b"%cX%c: a" % (code, code)), 400)

# --- headers twice ----------------------------------------------------------------------------------------------------

for name, field in (("Content-Length", b"Content-Length: 0"), ("Transfer-Encoding", b"Transfer-Encoding: chunked"),
                    ("Host", b"Host: localhost"),
                    ("Content-Type", b"Content-Type: text/plain"), ("Expect", b"Expect: 100-continue"),
                    ("Origin", b"Origin: http://localhost"), ("Authorization", b"Authorization: Bearer x")):
    other = field.replace(b": ", b":").lower()
    TWICE.sends(name, request(b"GET /healthz", field, field), 400)
    TWICE.sends(name + ", in another case", request(b"GET /healthz", field, b"X: y", other), 400)
TWICE.sends("Host twice, the second one foreign", request(b"GET /metrics", b"Host: evil.example"), 400)
TWICE.sends("Idempotency-Key", request(b"POST /v1/comparisons", b"Content-Type: application/json",
                                       b"Idempotency-Key: a", b"Idempotency-Key: b", body=b"{}"), 400)
TWICE.sends("a thousand times the same", request(b"GET /healthz", *[b"X: y"] * 1000), 200)
TWICE.sends("If-None-Match", request(b"GET /openapi.yaml", *[b'If-None-Match: "x"'] * 50), (200, 304))

# --- limits -----------------------------------------------------------------------------------------------------------

for length, status in ((2047, 404), (2048, 404), (2049, 414), (4000, 414), (100_000, 414)):
    LIMITS.sends("a target of %d bytes" % length,
                 b"GET /" + b"x" * (length - 1) + b" HTTP/1.1\r\n" + HOST + KEY + b"\r\n", status)
for length, status in ((15_000, 200), (16_500, 431), (100_000, 431)):
    LIMITS.sends("a header of %d bytes" % length, request(b"GET /healthz", b"X: " + b"x" * length), status)
LIMITS.sends("a query of 3000 bytes", request(b"GET /openapi.yaml?" + b"x" * 3000), 414)
LIMITS.sends("a method of 3000 bytes", request(b"X" * 3000 + b" /healthz"), (414, 501))
LIMITS.sends("a name of 20,000 bytes", request(b"GET /healthz", b"x" * 20_000 + b": y"), 431)
LIMITS.sends("5000 headers", request(b"GET /healthz", *[b"a: b"] * 5000), 431)
LIMITS.sends("a value of 10,000 blanks", request(b"GET /healthz", b"X:" + b" " * 10_000 + b"y"), 200)
LIMITS.sends("a line without end", b"x" * 100_000, 414)
LIMITS.sends("a header without end", b"GET / HTTP/1.1\r\nX: " + b"x" * 100_000, 431)


@LIMITS.does("empty lines without end")
def _(arena):
    arena.flood(b"", b"\r\n" * 100, 408, most=float("inf"))


@LIMITS.does("a flood of headers")
def _(arena):
    arena.flood(b"GET /healthz HTTP/1.1\r\n" + HOST, b"a: b\r\n" * 5000, 431)


@LIMITS.does("a flood of one line")
def _(arena):
    arena.flood(b"GET /", b"x" * 65536, 414)


# --- methods ----------------------------------------------------------------------------------------------------------

TAKEN = (200, 204, 400, 401, 403, 404, 405, 411, 413, 415, 422)  # openapi.yaml says which of them, and when
for method in (b"GET", b"HEAD", b"POST", b"PUT", b"PATCH", b"DELETE", b"OPTIONS"):
    for path in (b"/", b"/healthz", b"/metrics", b"/openapi.yaml", b"/v1/comparisons", b"/v1/meshes", b"/v1/batches",
                 b"/v1/options", b"/none"):
        METHODS.sends("%s %s" % (method.decode(), path.decode()), request(method + b" " + path, b"Content-Length: 0"),
                      TAKEN)
for method in (b"TRACE", b"get", b"BREW", b"PROPFIND", b"GETT", b"M-SEARCH", b"DEBUG"):
    METHODS.sends(method.decode() + ", which is unknown", request(method + b" /healthz"), 501)
METHODS.sends("CONNECT", b"CONNECT example.org:443 HTTP/1.1\r\n" + END, 400)
METHODS.sends("OPTIONS *", request(b"OPTIONS *"), TAKEN)
METHODS.sends("a body on GET", request(b"GET /healthz", body=HIDDEN), 200)
METHODS.sends("a body on HEAD", request(b"HEAD /healthz", body=HIDDEN), 200)
METHODS.sends("a body on DELETE", request(b"DELETE /healthz", body=HIDDEN), 405)
METHODS.sends("a chunked body on GET", request(b"GET /healthz", b"Transfer-Encoding: chunked") + b"0\r\n\r\n" + HIDDEN,
              200)

# --- HTTP/1.0 ---------------------------------------------------------------------------------------------------------


def old(line, *fields, body=b""):
    return request(line, *fields, body=body).replace(b"HTTP/1.1", b"HTTP/1.0", 1)


OLD.sends("once", old(b"GET /healthz"), 200)
OLD.sends("without a host", b"GET /healthz HTTP/1.0\r\n\r\n", 200)
OLD.sends("that keeps alive", old(b"GET /healthz", b"Connection: keep-alive"), 200)
OLD.sends("twice on a connection", old(b"GET /healthz", b"Connection: keep-alive") * 2, 200)
OLD.sends("chunks", old(b"POST /v1/comparisons", b"Transfer-Encoding: chunked") + b"0\r\n\r\n" + HIDDEN, 400)
OLD.sends("an expectation", old(b"GET /healthz", b"Expect: 100-continue"), 200)
OLD.sends("a hidden request", old(b"POST /none", body=HIDDEN), 404)
OLD.sends("a length and more", old(b"GET /healthz") + HIDDEN, 200)
