"""Targets, hosts and origins that lead elsewhere, or that two parsers read differently."""

from clients.attack import JSON, Family, request, shown, with_keys, without_keys

FORMS, PATHS, QUERIES, HOSTS, ORIGINS, PAGES = (Family(name) for name in ("targets", "paths", "queries", "hosts",
        "origins", "pages"))
FAMILIES = (FORMS, PATHS, QUERIES, HOSTS, ORIGINS, PAGES)
ID = b"0" * 32


def target(text, host=b"Host: localhost"):
    return request(b"GET " + text, host=host)


# --- forms of a target ------------------------------------------------------------------------------------------------

for text, answer in (
        (b"http://localhost/healthz", 200), (b"HTTP://LOCALHOST/healthz", 200), (b"https://localhost/healthz", 200),
        (b"http://[::1]/healthz", 200), (b"http://[::1]:80/healthz", 200), (b"http://127.0.0.1/healthz", 200),
        (b"http://localhost:/healthz", 200),
        (b"http://localhost", (200, 404)), (b"http://localhost?x=/metrics", (200, 404)),
        (b"http://localhost/none?/healthz", 404), (b"http://user@localhost/healthz", 400),
        (b"http://user:word@localhost/healthz", 400), (b"http:///healthz", 400), (b"http://:80/healthz", 400),
        (b"http://localhost:x/healthz", 400),
        (b"http://localhost:80:80/healthz", 400), (b"http://[::1/healthz", 400), (b"http://[::1]x/healthz", 400),
        (b"http://[::1%25lo]/healthz", 400),
        (b"http://[1.2.3.4]/healthz", 400), (b"http://lo cal/healthz", 400), (b"http:/localhost/healthz", 400),
        (b"http:localhost", 400),
        (b"ftp://localhost/healthz", 400), (b"file:///etc/passwd", 400), (b"gopher://localhost:25/x", 400),
        (b"javascript:alert(1)", 400),
        (b"://localhost/healthz", 400), (b"healthz", 400), (b"?x=1", 400), (b"*", 400), (b"**", 400), (b"*?x", 400),
        (b"localhost:80", 400),
        (b"[::1]:80", 400), (b"localhost:80/healthz", 400), (b"\\healthz", 400), (b"http://localhost#x", 400),
        (b"/healthz#x", 400),
        (b"http://local\xc3\xa9/healthz", 400)):
    FORMS.sends(shown(text), target(text), answer)
FORMS.sends("a target that names another host", target(b"http://evil.example/none"), 403, where=without_keys)
FORMS.sends("a target of this host below a foreign Host", target(b"http://localhost/none", b"Host: evil.example"), 404)
FORMS.sends("an open path of another host", target(b"http://evil.example/healthz"), 200)

# --- paths ------------------------------------------------------------------------------------------------------------

for text in (
        b"//healthz", b"/healthz/", b"/healthz/.", b"/healthz/..", b"/./healthz", b"/../healthz", b"/x/../healthz",
        b"/%68ealthz", b"/healthz%00",
        b"/healthz%20", b"/healthz;a=b", b"/healthz%2f", b"/healthz%0d%0aSet-Cookie:%20x=1", b"/HEALTHZ", b"/..",
        b"/%2e%2e/%2e%2e/etc/passwd",
        b"/../../../../etc/passwd", b"/..%2f..%2f..%2fetc%2fpasswd", b"/%252e%252e%252fetc/passwd", b"/..;/..;/metrics",
        b"/docs/../metrics",
        b"/docs/..%2fmetrics", b"/docs/%2e%2e%2fmetrics", b"/page/..%2f..%2fkeys.json", b"/page/....//x",
        b"/page/%c0%ae%c0%ae/x", b"/docs/.git/config",
        b"/page/", b"/page/x/y", b"/docs/nothing.js", b"/.env", b"/jobs.sqlite", b"/data/jobs.sqlite", b"/v1", b"/v1/",
        b"/v1//comparisons", b"/V1/comparisons",
        b"/v2/comparisons", b"/v1/comparisons/", b"/v1/comparisons/%2e%2e/x", b"/v1/comparisons/../../metrics",
        b"/v1/comparisons/" + ID,
        b"/v1/comparisons/" + ID[1:], b"/v1/comparisons/" + b"0" * 1000, b"/v1/comparisons/" + ID + b"/events",
        b"/v1/comparisons/" + ID + b"/deviation.ply",
        b"/v1/comparisons/" + ID + b"/deviation.exe", b"/v1/comparisons/'%20OR%201=1--", b"/v1/comparisons/%00",
        b"/v1/comparisons/$(id)",
        b"/v1/batches/" + ID, b"/v1/batches/../comparisons", b"/v1/batches/" + ID + b"/results.jsonl",
        b"/v1/batches/" + ID + b"/junit.xml",
        b"/v1/batches/" + ID + b"/nothing", b"/" + b"x/" * 800, b"/" + b"%25" * 600):
    PATHS.sends(shown(text, 80), target(text), (404, 405))
for text in (b"/v1/meshes/x", b"/v1/meshes/" + b"A" * 64, b"/v1/meshes/" + b"0" * 63, b"/v1/meshes/..",
             b"/v1/meshes/%2e%2e%2f" + b"0" * 55, b"/v1/meshes/" + b"g" * 64, b"/v1/meshes/" + b"0" * 65):
    PATHS.sends(shown(text, 80), target(text), 400)
PATHS.sends("a mesh that is not stored", target(b"/v1/meshes/" + b"0" * 64), 404)
PATHS.sends("/metrics with a key of another scope", target(b"/metrics"), 403, where=with_keys)
for code in [*range(1, 33), *b'"<>\\^`{|}[]', 127, 128, 255]:
    if code not in b"\r\n":
        PATHS.sends("0x%02x" % code, target(b"/a%cb" % code), 400)
for text in (b"/%", b"/%2", b"/%zz", b"/%2g", b"/%u0041"):
    PATHS.sends(text.decode() + ", which is no escape", target(text), 400)

# --- queries ----------------------------------------------------------------------------------------------------------

for text in (b"?x=1", b"?=", b"?wait=5", b"?a=%00", b"?a=1&a=2", b"?" + b"x&" * 900):
    QUERIES.sends("of a path that takes none: " + shown(text), target(b"/v1/comparisons/" + ID + text), 400)
for text in (b"?", b"?x=%0d%0aX:y", b"?x=<script>", b"?x=" + b"%41" * 600):
    QUERIES.sends("of a page: " + shown(text), target(b"/openapi.yaml" + text), (200, 400))
for text in (b"limit=0", b"limit=101", b"limit=-1", b"limit=1e9", b"limit=%31", b"limit=99999999999999999999",
             b"after=", b"after=x-1", b"after=1-" + b"0" * 65, b"after=1'--", b"limit=1&limit=2", b"page=2"):
    QUERIES.sends("of a list: " + shown(text), target(b"/v1/meshes?" + text), 400, where=with_keys)
for text in (b"of=c", b"max_triangles=0", b"max_triangles=x", b"of=a&of=b", b"normals=maybe"):
    QUERIES.sends("of a map: " + text.decode(), target(b"/v1/comparisons/" + ID + b"/deviation.glb?" + text),
                  (400, 404))

# --- hosts ------------------------------------------------------------------------------------------------------------

for text in (b"localhost", b"LOCALHOST", b"localhost:", b"localhost:99999", b"127.0.0.1", b"10.1.2.3:80", b"[::1]",
             b"[::1]:8080", b"[::ffff:127.0.0.1]", b""):
    HOSTS.sends("'%s'" % shown(text), target(b"/none", b"Host: " + text), 404)
for text in (b"evil.example", b"evil.example:80", b"localhost.evil.example", b"127.0.0.1.evil.example", b"127.1",
             b"0x7f.1", b"2130706433", b"127.0.0.01",
             b"localhost.", b"%6cocalhost", b"loc_alhost", b"xn--lcalhost-x4a", b"localhost%00",
             b"localhost,evil.example", b"*", b"0"):
    HOSTS.sends("'%s'" % shown(text), target(b"/none", b"Host: " + text), 403, where=without_keys)
    HOSTS.sends("'%s', open" % shown(text), target(b"/healthz", b"Host: " + text), 200)
for text in (b"[::1].evil.example", b"localhost:x.evil", b"localhost:80:80", b"localhost:-1", b"localhost: 80",
             b"user@localhost", b"a b", b"localhost/x",
             b"localhost?x", b"localhost#x", b"::1", b"[]", b"[", b"]", b"[::1", b"[::1]]", b"[[::1]]", b"[1.2.3.4]",
             b"[:::]", b"[::1%25lo]", b"[v1.x]",
             b"http://localhost", b"h\xc3\xa9", b"%", b"%6", b"localhost\\x", b'"localhost"'):
    HOSTS.sends("'%s'" % shown(text), target(b"/none", b"Host: " + text), 400)
HOSTS.sends("none", request(b"GET /healthz", host=None), 400)
HOSTS.sends("of 10,000 bytes", target(b"/healthz", b"Host: " + b"x" * 10_000), 200)

# --- origins ----------------------------------------------------------------------------------------------------------

for text in (b"https://evil.example", b"http://localhost:1", b"http://localhost.evil.example", b"null", b"file://",
             b"chrome-extension://x",
             b"http://127.0.0.1:1", b"http://localhost:80@evil.example", b"//localhost", b"localhost"):
    for method in (b"POST /v1/options", b"DELETE /v1/comparisons/" + ID):
        ORIGINS.sends("%s %s" % (text.decode(), method.split()[0].decode()),
                      request(method, b"Origin: " + text, JSON, b"Content-Length: 0"), 403,
                      where=without_keys)
ORIGINS.sends("asked for before", request(b"OPTIONS /v1/comparisons", b"Origin: https://evil.example",
                                          b"Access-Control-Request-Method: POST"), 405)

# --- pages ------------------------------------------------------------------------------------------------------------

for text in (b"/c/" + ID, b"/b/" + ID, b"/c/<script>alert(1)</script>", b"/c/%22%3E%3Cscript%3E", b"/b/../x", b"/c/",
             b"/b", b"/c/x/", b"/docs", b"/", b"/page/nothing"):
    PAGES.sends(text.decode(), target(text), (200, 400, 404))
for value in (b"bytes=0-0", b"bytes=-1", b"bytes=9-1", b"bytes=0-18446744073709551616", b"bytes=" + b"0-," * 100,
              b"bytes=" + b",".join(b"%d-" % i for i in range(500)), b"x", b"bytes=", b"lines=0-1"):
    PAGES.sends("a range of %s" % shown(value), request(b"GET /openapi.yaml", b"Range: " + value), 200)
for name, value in (("any", b"*"), ("a list without end", b'"a",' * 2000), ("weak", b'W/"x"'), ("no quotes", b"x"),
                    ("an open quote", b'"x'), ("bytes beyond ASCII", b'"\xff"')):
    PAGES.sends("If-None-Match: " + name, request(b"GET /", b"If-None-Match: " + value, b"Accept: text/html"),
                (200, 304))
PAGES.sends("If-Modified-Since of the future", request(b"GET /openapi.yaml",
                                                       b"If-Modified-Since: Fri, 31 Dec 9999 23:59:59 GMT"), 200)
PAGES.sends("a key where none is needed",
            b"GET /openapi.yaml HTTP/1.1\r\nHost: localhost\r\nAuthorization: Basic eDp5\r\n\r\n", 200)
