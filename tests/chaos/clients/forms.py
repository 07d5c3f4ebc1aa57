"""Forms whose parts are none, hide from another parser, or lead elsewhere; options that are no JSON, or too deep."""

import json

from clients.arena import holds
from clients.attack import CHUNKED, JSON, Family, chunks, demand, post, request, shown
from harness import multipart
from victim import square

BOUNDARIES, AROUND, HEADS, PARTS, NAMES, OPTIONS, BODIES = (
    Family(name) for name in ("boundaries", "around the parts", "heads of parts", "parts", "names", "options",
                              "JSON bodies"))
FAMILIES = (BOUNDARIES, AROUND, HEADS, PARTS, NAMES, OPTIONS, BODIES)

A, B = ("a", square(0)), ("b", square(2))
BODY = multipart([A, B, ("options", b"{}")])
LIMIT = multipart([("options", b'{"gate": {"max_distance": 1}}')])
KIND = b"Content-Type: multipart/form-data; boundary="

# --- boundaries -------------------------------------------------------------------------------------------------------

for value in (b"", b'""', b"x" * 71, b'"x', b'x"', b"a\xffb", b"a b;c", b"a;boundary", b"=", b'"' + b"\\" * 200 + b'"',
              b"x y", b"a\tb", b"x/y", b"'x y'"):
    BOUNDARIES.sends("'%s'" % shown(value), post(b"--x\r\n\r\nhello\r\n--x--\r\n", kind=KIND + value), 400)
BOUNDARIES.sends("none", post(BODY, kind=b"Content-Type: multipart/form-data"), 400)
BOUNDARIES.sends("an extended one", post(BODY,
                                         kind=b"Content-Type: multipart/form-data; boundary*=utf-8''XXboundaryXX"), 400)
BOUNDARIES.sends("two, the second one right", post(BODY, kind=KIND + b"y; boundary=XXboundaryXX"), 400)
BOUNDARIES.sends("two, the first one right", post(BODY, kind=KIND + b"XXboundaryXX; Boundary=y"), 400)
BOUNDARIES.sends("in quotes", post(BODY, kind=KIND + b'"XXboundaryXX"'), 200)
BOUNDARIES.sends("in upper case", post(BODY, kind=b"CONTENT-TYPE: MULTIPART/FORM-DATA; BOUNDARY=XXboundaryXX"), 200)
BOUNDARIES.sends("another case in the body", post(BODY.replace(b"XXboundaryXX", b"xxBOUNDARYxx")), 400)
BOUNDARIES.sends("of 70 dashes", post(BODY.replace(b"XXboundaryXX", b"-" * 70), kind=KIND + b"-" * 70), 200)
MANY = b"".join(b"; x%d=y" % i for i in range(1000))
BOUNDARIES.sends("a thousand parameters", post(BODY, kind=KIND + b"XXboundaryXX" + MANY), 200)
for kind in (b"multipart/mixed", b"multipart/related", b"text/plain", b"application/x-www-form-urlencoded",
             b"multipart/form-data2", b"multipart/*", b"", b"model/obj"):
    BOUNDARIES.sends("of %s" % kind.decode(), post(BODY, kind=b"Content-Type: " + kind + b"; boundary=XXboundaryXX"),
                     415)


@BOUNDARIES.does("nearly, a thousand times in a mesh")
def _(arena):
    near = square(0) + b"#\r\n--XXboundaryX\r\n--XXboundar" * 1000 + b"\n"
    answer = arena.ask(post(multipart([("a", near), B])), 422)
    demand(answer.json()["errors"][0]["part"] == "a", answer.body)


# --- around the parts -------------------------------------------------------------------------------------------------

LAST = BODY[:BODY.rindex(b"--XXboundaryXX--")]
AROUND.table([
    ("an empty line before", post(b"\r\n" + BODY), 200),
    ("a preamble", post(b"This is a multi-part message.\r\n" + BODY), 200),
    ("a preamble of 8190 bytes", post(b"x" * 8190 + b"\r\n" + BODY), 200),
    ("a preamble of 9000 bytes", post(b"x" * 9000 + b"\r\n" + BODY), 400),
    ("a byte order mark", post(b"\xef\xbb\xbf" + BODY), 400),
    ("LF before the first boundary", post(b"\n" + BODY), 400),
    ("LF everywhere", post(BODY.replace(b"\r\n", b"\n")), 400),
    ("blanks behind boundaries", post(BODY.replace(b"--XXboundaryXX\r\n", b"--XXboundaryXX \t \r\n")), 200),
    ("text behind a boundary", post(BODY.replace(b"--XXboundaryXX\r\n", b"--XXboundaryXXx\r\n")), 400),
    ("no line end at the end", post(LAST + b"--XXboundaryXX--"), 200),
    ("no closing boundary", post(LAST), 400),
    ("half a closing boundary", post(LAST + b"--XXboundaryXX-"), 400),
    ("an epilogue", post(BODY + b"The end.\r\n" * 1000), 200),
    ("parts behind the end", post(multipart([A, B]) + LIMIT), 400),
    ("closed twice", post(BODY + b"--XXboundaryXX--\r\n"), 200),
    ("options before an odd beginning", post(b"x" + LIMIT[:LIMIT.rindex(b"--XX")] + BODY), 400),
    ("nothing", post(b"\r\n"), 400),
    ("no part", post(b"--XXboundaryXX--\r\n"), 400),
    ("another boundary", post(BODY.replace(b"XXboundaryXX", b"other")), 400),
])


@AROUND.does("blanks behind a boundary without end")
def _(arena):
    arena.flood(request(b"POST /v1/comparisons", KIND + b"XXboundaryXX", CHUNKED) + b"e\r\n--XXboundaryXX\r\n",
                b"8000\r\n" + b" " * 0x8000 + b"\r\n", 413)


@AROUND.does("a preamble without end")
def _(arena):
    arena.flood(request(b"POST /v1/comparisons", KIND + b"XXboundaryXX", CHUNKED),
                b"8000\r\n" + b"x" * 0x8000 + b"\r\n", 400)


# --- heads of parts ---------------------------------------------------------------------------------------------------


def with_head(*lines, content=square(0)):
    """The form whose first part has these header lines."""
    head = b"".join(line + b"\r\n" for line in lines)
    return post(b"--XXboundaryXX\r\n%s\r\n%s\r\n" % (head, content) + multipart([B]))


DISPOSITION = b'Content-Disposition: form-data; name="a"; filename="a.obj"'
for name, lines in (
        ("none", ()), ("no name", (b"Content-Disposition: form-data",)),
        ("an empty name", (b'Content-Disposition: form-data; name=""',)),
        ("an attachment", (b'Content-Disposition: attachment; name="a"; filename="a.obj"',)),
        ("no colon", (b"Content-Disposition",)),
        ("a blank before the colon", (b'Content-Disposition : form-data; name="a"',)),
        ("a folded line", (b"Content-Disposition: form-data;", b' name="a"')),
        ("NUL", (DISPOSITION, b"X: a\0b")), ("bare CR", (DISPOSITION, b"X: a\rb")),
        ("bare LF", (b'Content-Disposition: form-data;\n name="a"',)),
        ("an open quote", (b'Content-Disposition: form-data; name="a',)),
        ("a name of 9000 bytes", (b'Content-Disposition: form-data; name="' + b"a" * 9000 + b'"',)),
        ("5000 lines", (DISPOSITION, *[b"X: y"] * 5000)),
        ("an encoded name", (b"Content-Disposition: form-data; name*=utf-8''a; filename=a.obj",)),
        ("a name in parts", (b"Content-Disposition: form-data; name*0=a; filename=a.obj",)),
        ("two dispositions", (DISPOSITION, b'Content-Disposition: form-data; name="options"')),
        ("two names", (DISPOSITION + b'; name="options"',)), ("two file names", (DISPOSITION + b'; FILENAME="x"',)),
        ("backslashes", (DISPOSITION[:-1] + b"\\" * 9000 + b'"',))):
    HEADS.sends(name, with_head(*lines), 400)
for name, lines in (
        ("in lower case", (DISPOSITION.lower(),)),
        ("without quotes", (b"Content-Disposition: form-data; name=a; filename=a.obj",)),
        ("a content type of another kind", (DISPOSITION, b"Content-Type: text/html")),
        ("a hundred lines", (DISPOSITION, *[b"X: y"] * 100)),
        ("an encoded file name", (DISPOSITION + b"; filename*=UTF-8''%2e%2e%2fetc%2fpasswd",)),
        ("a length that lies", (DISPOSITION, b"Content-Length: 1"))):
    HEADS.sends("odd but right: " + name, with_head(*lines), 200)

# --- parts ------------------------------------------------------------------------------------------------------------

PARTS.table([
    ("a alone", post(multipart([A])), 400), ("b alone", post(multipart([B])), 400), ("options alone", post(LIMIT), 400),
    ("a twice", post(multipart([A, B, A])), 400),
    ("options twice", post(multipart([A, B, ("options", b"{}"), ("options", b"{}")])), 400),
    ("an unknown one", post(multipart([A, B, ("c", b"x")])), 400),
    ("names in upper case", post(multipart([("A", A[1]), ("B", B[1])])), 400),
    ("5000 unknown ones", post(multipart([("x%d" % i, b"") for i in range(5000)])), 400),
    ("3000 times the same", post(multipart([A] * 3000)), 400),
    ("empty ones", post(multipart([("a", b""), ("b", b"")])), 422),
    ("one that is too large", post(multipart([A, ("b", b"#" * 1_000_001)])), 413),
    ("the name of a file in place of it",
     post(multipart([A, B]).replace(b'; filename="a.obj"', b"", 1).replace(A[1], b"part.stl", 1)), 400),
    ("3000 files beside a mesh", post(multipart([A, B])[:-18] + b"".join(
        b'--XXboundaryXX\r\nContent-Disposition: form-data; name="a.files"; filename="f%d"\r\n\r\n\r\n' % i
        for i in range(3000)) + b"--XXboundaryXX--\r\n"), 400),
    ("an unknown one of a megabyte", post(multipart([("x", b"y" * 1_500_000), A, B])), 400),
])

# --- names ------------------------------------------------------------------------------------------------------------


def with_file(name):
    """A form with a file of this name beside its first mesh."""
    part = b'--XXboundaryXX\r\nContent-Disposition: form-data; name="a.files"; filename="%s"\r\n\r\nx\r\n' % name
    return post(part + multipart([A, B]))


for name in (b"../x.bin", b"../../../../etc/passwd", b"/etc/passwd", b"a/../../x", b"..", b"C:/x",
             b"http://evil.example/x", b"file:///etc/passwd", b"x/..",
             b"%2e%2e/x", b"..%2fx", b"%2fetc%2fpasswd", b"a%00b", b"x\\\\..\\\\y", b"~/../x", b"data:,x",
             b"a%5c..%5cb", b"./../x", b""):
    NAMES.sends("a file beside a mesh, '%s'" % shown(name), with_file(name), 400)
for name in (b"../../../../etc/passwd", b"/dev/zero", b"C:\\\\x.stl", b"http://evil.example/x.stl", b"a%00.stl", b"|id",
             b"$(id).obj", b"`id`.obj", b"; rm -rf /", b"CON", b"nul.obj",
             b"\xff\xfe", b"'\\\" OR 1=1", b"<script>.obj", b"x" * 4000, b"a.stl.exe", b".", b"%0d%0aX: y",
             b"\xe2\x80\xae" b"jbo.a"):
    NAMES.sends("a mesh, '%s'" % shown(name),
                with_head(b'Content-Disposition: form-data; name="a"; filename="%s"' % name), 200)
for name in (b'attachment; filename="../../x"', b'attachment; filename="' + b"x" * 5000 + b'"',
             b"attachment; filename*=utf-8''%0d%0aX", b'filename="\xff"', b"=", b'attachment; filename="'):
    NAMES.sends("a stored mesh, '%s'" % shown(name), request(b"POST /v1/meshes", b"Content-Disposition: " + name,
            body=square(7, 1, "named")), (200, 201, 400))

# --- options ----------------------------------------------------------------------------------------------------------


def with_options(text):
    return post(multipart([A, B, ("options", text)]))


for text in (b"", b" ", b"nonsense", b"[]", b"7", b'"x"', b"null", b"{", b"}", b"{}{}", b"{},", b"{'a': 1}", b"{a: 1}",
             b'{"a": 1,}', b'{"timeout_ms": 01}', b'{"timeout_ms": +1}',
             b'{"timeout_ms": 1e3}', b'{"timeout_ms": NaN}', b'{"timeout_ms": Infinity}', b'{"timeout_ms": 1e999}',
             b'{"timeout_ms": -1}', b'{"timeout_ms": 99999999999999999999}',
             b'{"timeout_ms": "1"}', b'{"timeout_ms": null}', b'{"timeout_ms": [1]}', b'{"timeout_ms": true}',
             b'{"threads": 0}', b'{"threads": 65}', b'{"threads": 1.5}',
             b'{"tolerance": {"relative": -1}}', b'{"tolerance": 5}', b'{"tolerance": {}}', b'{"strategy": "fastest"}',
             b'{"strategy": ""}', b'{"strategy": "auto\\u0000"}', b'{"unknown": 1}', b'{"": 1}', b'{"__proto__": {}}',
             b'{"gate": {"max_distance": -1}}', b'{"gate": {"max_distance": 1, "max_distance": 9}}',
             b'{"direction": "a_to_b", "direction": "b_to_a"}', b"[" * 60_000, b'{"a":' * 10_000,
             b'{"tolerance": ' * 17 + b"{}" + b"}" * 17, b"[" * 1000 + b"]" * 1000,
             b"{/* x */}", b"{} // x", b"\xff\xfe{\0}\0", b'{"strategy": "\xff"}', b'{"strategy": "\\ud800"}',
             b'{"strategy": "\\x41"}', b'{"strategy": "a\nb"}',
             b"{\0}", b'{"units": "' + b"m" * 5000 + b'"}', b'{"align": [' + b"[1," * 500 + b"1" + b"]" * 501 + b"}",
             b'{"expect": {"triangles": {"max": -1}}}',
             b'{"regions": ' + json.dumps([{"name": "r%d" % i} for i in range(500)]).encode() + b"}"):
    OPTIONS.sends("'%s'" % shown(text), with_options(text), 422)
OPTIONS.sends("70,000 blanks", with_options(b" " * 70_000 + b"{}"), 413)
OPTIONS.sends("60,000 blanks", with_options(b" " * 60_000 + b"{}"), 200)
OPTIONS.sends("a byte order mark", with_options(b"\xef\xbb\xbf{}"), 200)
OPTIONS.sends("a tolerance that is zero when it is read",
              with_options(b'{"tolerance": {"relative": 1e-400}, "timeout_ms": 1000}'), 200)
OPTIONS.sends("an escaped name", with_options(b'{"timeout\\u005fms": 60000}'), 200)
OPTIONS.sends("of a time of a millisecond", with_options(b'{"timeout_ms": 1}'), (200, 503))
OPTIONS.sends("in chunks of a byte", request(b"POST /v1/options", JSON, CHUNKED) + chunks(b'{"timeout_ms": 1000}', 1),
              200)


@OPTIONS.does("every tolerance at its smallest")
def _(arena):
    answer = arena.compare(options={"tolerance": {"absolute": 5e-324, "relative": 5e-324, "diagonal": 5e-324},
                                    "timeout_ms": 1000}, allowed=(200, 422))
    if answer.status == 200:
        holds(answer.json(), 2)


# --- JSON bodies ------------------------------------------------------------------------------------------------------

for path, statuses in ((b"/v1/comparisons", (400, 413, 422)), (b"/v1/options", (413, 422)),
                       (b"/v1/batches", (400, 413, 422))):
    for name, text in (("nothing", b" "), ("a list", b"[]"), ("half an object", b'{"a": '), ("deep", b"[" * 60_000),
                       ("deep objects", b'{"comparisons":' * 4000), ("a string without end", b'"' + b"x" * 60_000),
                       ("bytes that are no UTF-8", b'{"a": "\xff\xfe\xfd"}'), ("UTF-16", '{"a": 1}'.encode("utf-16")),
                       ("a number of 60,000 digits", b'{"a": ' + b"9" * 60_000 + b"}"),
                       ("200,000 blanks", b" " * 200_000),
                       ("a name 5000 times", b"{" + b'"a": 1, ' * 5000 + b'"a": 1}'),
                       ("ids that are paths", b'{"a": "../../etc/passwd", "b": "/dev/zero"}'),
                       ("ids of numbers", b'{"a": 1, "b": 2}'),
                       ("ids in upper case", b'{"a": "%s", "b": "%s"}' % (b"A" * 64, b"B" * 64)),
                       ("ids that are not stored", b'{"a": "%s", "b": "%s"}' % (b"1" * 64, b"2" * 64))):
        BODIES.sends("%s: %s" % (path.decode(), name), post(text, kind=JSON, line=b"POST " + path), statuses)
