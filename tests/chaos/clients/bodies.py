"""Lengths, chunks and expectations that are none, that lie, or that two parsers read differently; encoded bodies."""

import gzip
import zlib

from clients.arena import comparison, holds
from clients.attack import CHUNKED, FORM, HIDDEN, Family, chunks, cut_at, demand, in_pieces, post, request, shown
from harness import multipart
from victim import square

LENGTHS, SMUGGLED, CHUNKS, SPLITS, EXPECT, ENCODED, PIPED = (
    Family(name) for name in ("lengths", "smuggling", "chunks", "splits", "expectations", "encoded bodies",
                              "pipelines"))
FAMILIES = (LENGTHS, SMUGGLED, CHUNKS, SPLITS, EXPECT, ENCODED, PIPED)

POST = b"POST /v1/comparisons"
BODY = multipart([("a", square(0)), ("b", square(2)), ("options", b"{}")])
WHOLE = post(BODY)
HEAD_BYTES = WHOLE.index(b"\r\n\r\n") + 4


def lengths(*fields, body=b""):
    return request(POST, FORM, *fields) + body


# --- lengths ----------------------------------------------------------------------------------------------------------

for value in (b"", b" ", b"-1", b"+5", b"5,5", b"5, 6", b"5 5", b"0x5", b"5;", b"1e1", b"5.0", b"5L", b"\xd9\xa5",
              b"'5'", b'"5"', b"Infinity", b"0 ,5", b"null"):
    LENGTHS.sends("Content-Length '%s'" % shown(value), lengths(b"Content-Length: " + value, body=HIDDEN), 400)
for value in (b"2000001", b"4294967296", b"9223372036854775808", b"18446744073709551615", b"18446744073709551616",
              b"1" + b"0" * 30, b"9" * 4000):
    LENGTHS.sends("Content-Length %s" % shown(value), lengths(b"Content-Length: " + value, body=b"--XXboundaryXX"), 413)
LENGTHS.sends("a length with zeros before it", lengths(b"Content-Length: 00%d" % len(BODY), body=BODY), 200)
LENGTHS.sends("none", request(POST, FORM), 411)
LENGTHS.sends("one too many", lengths(b"Content-Length: %d" % (len(BODY) + 1), body=BODY), 408)
LENGTHS.sends("ten too few, then a request", lengths(b"Content-Length: %d" % (len(BODY) - 10), body=BODY) + b"\r\n\r\n",
              400, (400, 505))
LENGTHS.sends("none at all of what was announced", lengths(b"Content-Length: 100"), 408)
LENGTHS.sends("zero", lengths(b"Content-Length: 0"), 400)
LENGTHS.sends("zero, then a hidden request", lengths(b"Content-Length: 0", body=HIDDEN), 400, (401, 404))
LENGTHS.sends("garbage behind a body", WHOLE + b"\0\xff garbage\r\n\r\n", 200, 400)

# --- smuggling --------------------------------------------------------------------------------------------------------

for value, answer in ((b"chunked, identity", 501), (b"identity, chunked", 501), (b"identity", 501), (b"gzip", 501),
                      (b"gzip, chunked", 501),
                      (b"chunked, chunked", 501), (b"chunked;q=1", 501), (b"chunked,", 501), (b",chunked", 501),
                      (b"xchunked", 501), (b"chunke", 501),
                      (b'"chunked"', 501), (b"\x0bchunked", 400), (b"chunked\x00", 400), (b"chunked\x0c", 400),
                      (b"", 501), (b"\xe2\x80\x8bchunked", 501), (b"chunked\xa0", 501)):
    SMUGGLED.sends("Transfer-Encoding '%s'" % shown(value), lengths(b"Transfer-Encoding: " + value,
            body=b"0\r\n\r\n" + HIDDEN), answer)
for name, fields in (
        ("length before chunks", (b"Content-Length: 5", CHUNKED)),
        ("chunks before length", (CHUNKED, b"Content-Length: 5")),
        ("length 0 and chunks", (b"Content-Length: 0", CHUNKED)),
        ("length of all and chunks", (b"Content-Length: %d" % (len(HIDDEN) + 5), CHUNKED)),
        ("in lower and upper case", (b"content-length: 5", b"TRANSFER-ENCODING: chunked")),
        ("with a tab", (b"Content-Length:\t5", b"Transfer-Encoding:\tchunked")),
        ("two lengths that differ", (b"Content-Length: 3", b"Content-Length: 300")),
        ("two lengths that agree", (b"Content-Length: 5", b"Content-Length: 5")),
        ("two codings", (b"Transfer-Encoding: identity", CHUNKED)), ("chunked twice", (CHUNKED, CHUNKED)),
        ("a coding that is folded", (b"X: y\r\n Transfer-Encoding: chunked", b"Content-Length: 5")),
        ("a blank before the colon", (b"Content-Length : 5",)),
        ("a coding behind a bare LF", (b"X: y\nTransfer-Encoding: chunked", b"Content-Length: 5")),
        ("a coding behind a bare CR", (b"X: y\rTransfer-Encoding: chunked", b"Content-Length: 5")),
        ("a name with NUL", (b"Transfer-Encoding\0: chunked", b"Content-Length: 5"))):
    SMUGGLED.sends(name, lengths(*fields, body=b"0\r\n\r\n" + HIDDEN), 400)
for name, line in (("GET", b"GET /healthz"), ("HEAD", b"HEAD /healthz"), ("an unknown path", b"POST /none"),
                   ("a wrong method", b"PUT /v1/comparisons"), ("DELETE", b"DELETE /v1/comparisons/" + b"0" * 32),
                   ("a query that is refused", b"POST /v1/comparisons?x=1")):
    SMUGGLED.sends("in a body of " + name, request(line, b"Content-Type: text/plain", body=HIDDEN),
                   (200, 400, 404, 405, 415))
    SMUGGLED.sends("in chunks of " + name, request(line, b"Content-Type: text/plain",
                                                   CHUNKED) + chunks(HIDDEN) + HIDDEN, (200, 400, 404, 405, 415))
SMUGGLED.sends("in a refused media type", post(HIDDEN, kind=b"Content-Type: text/plain"), 415)
SMUGGLED.sends("in a part", post(multipart([("a", HIDDEN), ("b", square(0)), ("options", b"{}")])), (415, 422))
SMUGGLED.sends("in an epilogue", post(BODY + HIDDEN), 200)

# --- chunks -----------------------------------------------------------------------------------------------------------


def chunked(raw):
    return request(POST, FORM, CHUNKED) + raw


for raw in (b"x\r\n", b"-1\r\nx\r\n", b"+1\r\nx\r\n", b"0x1\r\nx\r\n", b" 1\r\nx\r\n", b"1 \r\nx\r\n", b"\t1\r\nx\r\n",
            b"\r\nx\r\n", b"g\r\n", b"1.0\r\nx\r\n", b"1_0\r\n",
            b"1" * 17 + b"\r\n", b"0" * 1000, b"1;" + b"x" * 1000, b"1;a\nb\r\nx\r\n", b"1;a\rb\r\nx\r\n",
            b"1;a\0b\r\nx\r\n", b"1\nx\n0\n\n\r\n", b"1\rx\r0\r\r\r\n",
            b"1\r\nxy\r\n0\r\n\r\n", b"1\r\nx\n0\r\n\r\n", b"1\r\nx\r\r\n", b"1\r\n", b"ffffffffffffffffffff\r\n",
            b"0\r\nT: " + b"x" * 1000, b"0\r\nT: x\n\n" + HIDDEN,
            b"0\r\nT: x\ry\r\n\r\n", b"0\r\n" + b"T: x\r\n" * 100 + b"\r\n", b"0\n\n\r\n", b";\r\n",
            b"\xef\xbc\x91\r\nx\r\n"):
    CHUNKS.sends(shown(raw), chunked(raw), (400, 408) if raw == b"1\r\n" else 400)
for raw in (b"ffffffffffffffff\r\n", b"1e8481\r\n", b"7fffffffffffffff\r\n", b"8000000000000000\r\n",
            b"00ffffffff\r\n"):
    CHUNKS.sends("too large: %s" % shown(raw), chunked(raw), 413)
for name, extension in (("none", b""), ("a name", b";x"), ("a value", b";x=y"), ("a quoted value", b';x="a;b"'),
                        ("an open quote", b';x="'), ("blanks", b"; x = y"),
                        ("many", b";a=b" * 40), ("bytes beyond ASCII", b";\xff=\xfe"), ("a size", b";5"),
                        ("nothing", b";;;")):
    CHUNKS.sends("an extension: " + name,
                 chunked(b"%x%s\r\n%s\r\n0%s\r\n\r\n" % (len(BODY), extension, BODY, extension)), 200)
for name, raw in (("zeros before a size", b"0000%x\r\n%s\r\n000\r\n\r\n" % (len(BODY), BODY)),
                  ("upper case", b"%X\r\n%s\r\n0\r\n\r\n" % (len(BODY), BODY)),
                  ("30 trailers", chunks(BODY)[:-2] + b"Content-Length: 5\r\n" * 30 + b"\r\n"),
                  ("a trailer that names the key", chunks(BODY)[:-2] + b"Authorization: x\r\n\r\n"),
                  ("of one byte", chunks(BODY, 1)), ("of 7 bytes", chunks(BODY, 7)),
                  ("of 1000 bytes", chunks(BODY, 1000))):
    CHUNKS.sends("odd but right: " + name, chunked(raw), 200)
CHUNKS.sends("a request behind the last one", chunked(chunks(BODY)) + HIDDEN, 200, (401, 404))
CHUNKS.sends("an empty body", chunked(b"0\r\n\r\n"), 400)


@CHUNKS.does("without end")
def _(arena):
    part = b'--XXboundaryXX\r\nContent-Disposition: form-data; name="a"; filename="a"\r\n\r\n'
    arena.flood(chunked(b"%x\r\n%s\r\n" % (len(part), part)), b"1\r\nx\r\n" * 5000, 413)


@CHUNKS.does("without end, each with an extension")
def _(arena):
    arena.flood(chunked(b""), b"1;x=y\r\nx\r\n" * 5000, 400, 413)


@CHUNKS.does("a flood behind a refused length")
def _(arena):
    arena.flood(lengths(b"Content-Length: 1000000000000"), b"x" * 65536, 413)


# --- splits -----------------------------------------------------------------------------------------------------------


def whole(arena, data, send):
    """A comparison that is right however it is cut into packets."""
    def attempt():
        with arena.connect() as connection:
            arena.send(connection, arena.filled(data), send)
            answer = arena.read(connection.makefile("rb"))
        if answer is None or answer.status in (408, 429, 503):
            return None
        demand(answer.status == 200, answer.status, answer.body)
        holds(answer.json(), 2)
        return True
    arena.patiently(attempt)


def split(name, data, send):
    SPLITS.add(name, lambda arena: whole(arena, data, send))


for place in (1, 3, 4, 5, 24, 25, 29, 34, 35, 36, HEAD_BYTES - 3, HEAD_BYTES - 2, HEAD_BYTES - 1, HEAD_BYTES,
              HEAD_BYTES + 1):
    split("at byte %d" % place, WHOLE, cut_at(place))
for back in (1, 2, 3, 4, 5, 14, 16, 17, 18, 20, 60, 100):
    split("%d bytes before the end" % back, WHOLE, cut_at(-back))
for size in (1, 2, 3, 7, 16, 64, 500):
    split("in pieces of %d" % size, WHOLE, in_pieces(size))
    split("chunks in pieces of %d" % size, chunked(chunks(BODY, 100)), in_pieces(size))
for back in (1, 2, 3, 4, 5, 6):
    split("chunks, %d bytes before the end" % back, chunked(chunks(BODY, 100)), cut_at(-back))

# --- expectations -----------------------------------------------------------------------------------------------------


def expected(arena, head, body, statuses, sent_at_once=False):
    """An expectation is met by 100 and then an answer, or by an answer alone."""
    def attempt():
        with arena.connect() as connection:
            stream = connection.makefile("rb")
            arena.send(connection, arena.filled(head) + (body if sent_at_once else b""))
            if not sent_at_once:
                line = stream.readline()
                if line.startswith(b"HTTP/1.1 100"):
                    demand(stream.readline() == b"\r\n", "an interim answer of more than a line")
                    arena.send(connection, body)
                elif line:
                    status = int(line.split()[1])
                    return None if status in (408, 429, 503) else demand(status in statuses, status) or True
            answer = arena.read(stream)
        if answer is None or answer.status in (408, 429, 503):
            return None
        demand(answer.status in statuses, answer.status, answer.body)
        return True
    arena.patiently(attempt)


def expects(name, head, body=BODY, statuses=(200,), sent_at_once=False):
    EXPECT.add(name, lambda arena: expected(arena, head, body, statuses, sent_at_once))


for value in (b"100-continue", b"100-Continue", b"100-CONTINUE"):
    expects(value.decode(), lengths(b"Expect: " + value, b"Content-Length: %d" % len(BODY)))
expects("and the body at once", lengths(b"Expect: 100-continue", b"Content-Length: %d" % len(BODY)), sent_at_once=True)
expects("and chunks", lengths(b"Expect: 100-continue", CHUNKED), chunks(BODY))
expects("of a body that is too large", lengths(b"Expect: 100-continue", b"Content-Length: 1000000000000"),
        statuses=(413,))
expects("of a body that is not read", request(b"POST /none", b"Expect: 100-continue", b"Content-Length: 100"),
        b"x" * 100, (404,))
expects("of no body", request(b"GET /healthz", b"Expect: 100-continue"), b"", (200,))
EXPECT.sends("and no body comes", lengths(b"Expect: 100-continue", b"Content-Length: 100"), 408)

# --- encoded bodies ---------------------------------------------------------------------------------------------------

BOMB = gzip.compress(bytes(1_000_000))
for coding in (b"gzip", b"deflate", b"br", b"zstd", b"gzip, identity", b"identity, gzip", b"x-gzip", b"compress", b"x",
               b"gzip;q=1", b"*"):
    ENCODED.sends("Content-Encoding %s, the head alone" % coding.decode(),
                  lengths(b"Content-Encoding: " + coding, b"Content-Length: 100"), 415)
    ENCODED.sends("Content-Encoding %s" % coding.decode(), post(BOMB, b"Content-Encoding: " + coding), 415)
ENCODED.sends("a bomb in chunks", request(POST, FORM, CHUNKED, b"Content-Encoding: gzip") + chunks(BOMB, 5000), 415)
ENCODED.sends("identity", post(BODY, b"Content-Encoding: identity"), 200)
ENCODED.sends("Content-Transfer-Encoding of a part",
              post(BODY.replace(b"form-data; name=\"a\"", b'form-data; name="a"', 1).replace(
    b"\r\n\r\n", b"\r\nContent-Transfer-Encoding: base64\r\n\r\n", 1)), (200, 400, 422))
ENCODED.sends("a form that is compressed", post(zlib.compress(BODY)), 400)

# --- pipelines --------------------------------------------------------------------------------------------------------

GET, NONE = request(b"GET /healthz"), request(b"GET /v1/none")
PIPED.sends("two", GET + NONE, 200, 404)
PIPED.sends("a hundred", (GET + NONE) * 50, *[200, 404] * 50)
PIPED.sends("a thousand at once", GET * 1000, *[200] * 1000)
PIPED.sends("empty lines between", GET + b"\r\n\r\n" + NONE + b"\r\n" + GET, 200, 404, 200)
PIPED.sends("a body between", GET + WHOLE + NONE, 200, 200, 404)
PIPED.sends("chunks between", GET + chunked(chunks(BODY, 50)) + NONE, 200, 200, 404)
PIPED.sends("closed in the middle", GET + request(b"GET /healthz", b"Connection: close") + NONE * 5, 200, 200)
PIPED.sends("refused in the middle", GET + b"GET /health z HTTP/1.1\r\n\r\n" + NONE * 5, 200, 400)
PIPED.sends("of HEAD", request(b"HEAD /healthz") * 3 + NONE, 200, 200, 200, 404)
PIPED.sends("cut in the middle of each", (GET + NONE) * 4, *[200, 404] * 4, send=in_pieces(37))
PIPED.sends("behind a refused body of half a megabyte", post(b"x" * 500_000, kind=b"Content-Type: text/plain") + NONE,
            415)


@PIPED.does("of comparisons")
def _(arena):
    """Each answer belongs to its request."""
    def attempt():
        with arena.connect() as connection:
            heights = [1, 3, 5, 2]
            arena.send(connection, arena.filled(b"".join(comparison(0, height) for height in heights)))
            stream = connection.makefile("rb")
            answers = [arena.read(stream) for _ in heights]
        if any(answer is None or answer.status in (408, 429, 503) for answer in answers):
            return None
        for height, answer in zip(heights, answers):
            demand(answer.status == 200, answer.status, answer.body)
            holds(answer.json(), height)
        return True
    arena.patiently(attempt)
