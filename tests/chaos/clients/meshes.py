"""Files that expand, lie about their counts, name other files or are cut off: each is refused, or is a mesh."""

import gzip
import io
import json
import struct
import warnings
import zipfile

from clients.arena import holds, until
from clients.attack import Family, demand, post, shown
from harness import RAISED, SQUARE, multipart
from packages import MODEL, RELATIONSHIPS, package_3mf, zipped
from test_gltf_files import SQUARE_BIN, scene

BOMBS, COUNTS, VALUES, REFERENCES, PACKAGES, CUT, KINDS = (
    Family(name) for name in ("bombs", "counts that lie", "values", "references", "packages", "files cut off",
                              "files of other kinds"))
FAMILIES = (BOMBS, COUNTS, VALUES, REFERENCES, PACKAGES, CUT, KINDS)
REFUSED = (413, 415, 422)
MEGABYTES = 30_000_000  # more than may be expanded


def with_mesh(mesh, name="a.obj", files=()):
    """The comparison of a mesh with a square."""
    body = multipart([("a", mesh), ("b", RAISED)]).replace(b"a.obj", name.encode(), 1)
    part = b'--XXboundaryXX\r\nContent-Disposition: form-data; name="a.files"; filename="%s"\r\n\r\n%s\r\n'
    beside = b"".join(part % file for file in files)
    return post(beside + body)


def refused(family, name, mesh, file="a.obj", files=(), statuses=REFUSED):
    """`mesh`: bytes, or a function that makes them when they are needed."""
    family.sends(name, lambda: with_mesh(mesh() if callable(mesh) else mesh, file, files), statuses)


# --- bombs ------------------------------------------------------------------------------------------------------------


def zipped_up(data, times):
    """A gzip of the same again and again."""
    return lambda: gzip.compress(data * times, 6)


ZEROS, LINES = zipped_up(b"#", MEGABYTES), zipped_up(b"v 0 0 0\n", MEGABYTES // 8)
refused(BOMBS, "gzip of one comment", ZEROS)
refused(BOMBS, "gzip of vertices", LINES)
refused(BOMBS, "gzip within gzip", lambda: gzip.compress(ZEROS()))
refused(BOMBS, "gzip of many members", lambda: gzip.compress(b"# x\n" * 1000) * 10_000)
refused(BOMBS, "a hundred gzips one after the other", lambda: gzip.compress(b"#" * 1_000_000) * 100)
refused(BOMBS, "faces of one vertex", lambda: b"v 0 0 0\nv 1 0 0\nv 0 1 0\n" + b"f " + b"1 2 3 " * 30_000 + b"\n")
refused(BOMBS, "a line of a megabyte", lambda: b"v " + b"0" * 990_000)
refused(BOMBS, "a STL of nothing but solids", lambda: b"solid x\n" * 60_000 + b"endsolid\n" * 10)
refused(BOMBS, "a PLY header without end", lambda: b"ply\nformat ascii 1.0\n" + b"comment x\n" * 90_000)
refused(BOMBS, "an OFF of comments", lambda: b"OFF\n" + b"# x\n" * 200_000)


def packed(model, relationships=RELATIONSHIPS.encode(), **files):
    return zipped({"_rels/.rels": relationships, "3D/m.model": model, **files})


START = (b'<?xml version="1.0"?>\n<model xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02" '
         b'unit="millimeter">')
for name, piece, times in (("blanks", b" ", MEGABYTES), ("depth", b"<x>", 100_000), ("text", b"x", MEGABYTES),
                           ("a comment", b"<!-- x -->", MEGABYTES // 10)):
    refused(BOMBS, "a 3MF of " + name, lambda piece=piece, times=times: packed(START + piece * times + b"</model>"),
            "a.3mf")
refused(BOMBS, "a 3MF of attributes",
        lambda: packed(START + b"<x " + b" ".join(b'a%d=""' % i for i in range(50_000)) + b"/>"), "a.3mf")
LAUGHS = b'<!DOCTYPE m [<!ENTITY a0 "ha">' + b"".join(b'<!ENTITY a%d "%s">' % (i + 1,
        b"&a%d;" % i * 10) for i in range(12)) + b"]>"
refused(BOMBS, "a 3MF of a billion laughs", packed(b'<?xml version="1.0"?>' + LAUGHS + b"<model>&a12;</model>"),
        "a.3mf")
refused(BOMBS, "a 3MF of 5000 files", lambda: packed(START, **{"x%d" % i: b"" for i in range(5000)}), "a.3mf")


def nested(depth):
    content = b"x"
    for _ in range(depth):
        content = zipped({"a.zip": content})
    return content


refused(BOMBS, "zip within zip", nested(20), "a.zip")
refused(BOMBS, "a zip of one huge file", lambda: zipped({"a.bin": bytes(MEGABYTES)}), "a.zip")

# --- counts that lie --------------------------------------------------------------------------------------------------

PLY = (b"ply\nformat %s 1.0\nelement vertex %d\nproperty double x\nproperty double y\nproperty double z\n"
       b"element face %d\nproperty list %s int vertex_indices\nend_header\n")
for count in (4_000_000_000, 2**63, 2**64 - 1, 100_000_000):
    refused(COUNTS, "a PLY of %d vertices" % count, PLY % (b"binary_little_endian", count, 1, b"uchar"), "a.ply")
    refused(COUNTS, "a PLY of %d faces" % count, PLY % (b"binary_big_endian", 1, count, b"uchar") + bytes(24), "a.ply")
    refused(COUNTS, "a text PLY of %d vertices" % count, PLY % (b"ascii", count, 1, b"uchar") + b"0 0 0\n", "a.ply")
    refused(COUNTS, "an OFF of %d vertices" % count, b"OFF\n%d 1 0\n0 0 0\n" % count, "a.off")
refused(COUNTS, "a PLY of a face of 2^32 corners", PLY % (b"binary_little_endian", 1, 1,
                                                          b"uint") + bytes(24) + b"\xff" * 4, "a.ply")
refused(COUNTS, "a PLY of negative counts", PLY.replace(b"%d", b"-%d") % (b"ascii", 3, 1, b"uchar"), "a.ply")
refused(COUNTS, "a PLY of a thousand elements",
        b"ply\nformat ascii 1.0\n" + b"element x 1000000000\nproperty int y\n" * 1000 + b"end_header\n", "a.ply")
for count in (0xffffffff, 0x7fffffff, 1_000_000, 1):
    refused(COUNTS, "a STL of %d facets" % count, bytes(80) + struct.pack("<I", count), "a.stl")
refused(COUNTS, "a STL of no facets", bytes(84), "a.stl")
refused(COUNTS, "a STL with more than it says", bytes(80) + struct.pack("<I", 1) + bytes(500), "a.stl")


def glb(document, binary=SQUARE_BIN):
    text = document + b" " * (-len(document) % 4)
    binary += bytes(-len(binary) % 4)
    body = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(binary), 0x004E4942) + binary
    return struct.pack("<III", 0x46546C67, 2, 12 + len(body)) + body


SCENE = json.loads(scene("x"))
SCENE["buffers"][0].pop("uri")
for name, path, value in (
        ("an accessor of 2^31 values", ("accessors", 0, "count"), 2**31),
        ("an accessor of -1 values", ("accessors", 0, "count"), -1),
        ("an accessor before its view", ("accessors", 0, "byteOffset"), -4),
        ("an accessor behind its view", ("accessors", 0, "byteOffset"), 2**40),
        ("a view behind its buffer", ("bufferViews", 0, "byteOffset"), 2**32),
        ("a view of a stride of 2^31", ("bufferViews", 0, "byteStride"), 2**31),
        ("a view that is not there", ("accessors", 0, "bufferView"), 99),
        ("a negative view", ("accessors", 0, "bufferView"), -1),
        ("a buffer of 2^40 bytes", ("buffers", 0, "byteLength"), 2**40),
        ("a mesh that is not there", ("nodes", 0, "mesh"), 7),
        ("a node that is its own child", ("nodes", 0, "children"), [0]),
        ("a matrix of NaN", ("nodes", 0, "matrix"), [1e999] * 16),
        ("a component of no type", ("accessors", 0, "componentType"), 1),
        ("vectors of no type", ("accessors", 0, "type"), "VEC99"),
        ("a version of the future", ("asset", "version"), "99.0")):
    changed = json.loads(json.dumps(SCENE))
    place = changed
    for step in path[:-1]:
        place = place[step]
    place[path[-1]] = value
    refused(COUNTS, "a GLB with " + name, glb(json.dumps(changed).encode()), "a.glb")
refused(COUNTS, "a GLB of another length", glb(json.dumps(SCENE).encode())[:12] + b"\xff" * 8 + bytes(100), "a.glb")

# --- values -----------------------------------------------------------------------------------------------------------

for name, old, new in (
        ("NaN", b"v 1 1 0", b"v 1 nan 0"), ("infinity", b"v 1 1 0", b"v 1 inf 0"),
        ("1e999", b"v 1 1 0", b"v 1 1e999 0"), ("1e308", b"v 1 1 0", b"v 1 1e308 0"),
        ("a comma", b"v 1 1 0", b"v 1 1,5 0"), ("two numbers", b"v 1 1 0", b"v 1 1"),
        ("hexadecimal", b"v 1 1 0", b"v 0x1 1 0"), ("NUL", b"v 1 1 0", b"v 1 1 0\0"),
        ("an index beyond", b"f 1 3 4", b"f 1 3 5"), ("an index of zero", b"f 1 3 4", b"f 0 3 4"),
        ("an index before", b"f 1 3 4", b"f 1 3 -9"), ("an index of 2^32 + 1", b"f 1 3 4", b"f 1 3 4294967297"),
        ("an index of 2^64 + 1", b"f 1 3 4", b"f 1 3 18446744073709551617"),
        ("an index of a fraction", b"f 1 3 4", b"f 1 3 1.5")):
    refused(VALUES, name, SQUARE.replace(old, new))
refused(VALUES, "no faces", b"v 0 0 0\n" * 10)
refused(VALUES, "nothing", b"")
refused(VALUES, "one byte", b"v")

# --- references -------------------------------------------------------------------------------------------------------

for uri in ("../../../../etc/passwd", "/etc/passwd", "file:///etc/passwd", "http://127.0.0.1:1/x.bin", "x.bin",
            "data:,x", "data:application/octet-stream;base64,!!!!",
            "%2e%2e%2fx.bin", "..\\x.bin", "\0", "/proc/self/environ", "con", "x" * 5000):
    refused(REFERENCES, "a glTF that names %s" % shown(uri.encode()), scene(uri), "a.gltf", [(b"y.bin", SQUARE_BIN)])
refused(REFERENCES, "a glTF of a file that is too short", scene("x.bin"), "a.gltf", [(b"x.bin", SQUARE_BIN[:10])])
refused(REFERENCES, "an entity of XML from a file",
        packed(b'<?xml version="1.0"?><!DOCTYPE m [<!ENTITY x SYSTEM "file:///etc/passwd">]><model>&x;</model>'),
        "a.3mf")
refused(REFERENCES, "an entity of XML from a host",
        packed(b'<?xml version="1.0"?><!DOCTYPE m SYSTEM "http://127.0.0.1:1/x.dtd"><model/>'), "a.3mf")
refused(REFERENCES, "a 3MF whose model is elsewhere", packed(b"",
        RELATIONSHIPS.replace("/3D/m.model", "/../../etc/passwd").encode()), "a.3mf")
refused(REFERENCES, "an OBJ of materials alone", b"mtllib /etc/passwd\nusemtl x\n")

# --- packages ---------------------------------------------------------------------------------------------------------


def tampered(change):
    """A zip whose bytes are changed after it was made."""
    whole = bytearray(package_3mf("millimeter", ((0, 0, 0), (1, 0, 0), (0, 1, 0)), ((0, 1, 2),)))
    change(whole)
    return bytes(whole)


def at_end(offset, value):
    """Changes a field of the end of the central directory."""
    def change(whole):
        place = whole.rindex(b"PK\x05\x06") + offset
        whole[place:place + len(value)] = value
    return change


def in_directory(offset, value):
    def change(whole):
        place = whole.index(b"PK\x01\x02") + offset
        whole[place:place + len(value)] = value
    return change


for name, change in (
        ("a directory that is elsewhere", at_end(16, b"\xff\xff\xff\x7f")),
        ("more entries than there are", at_end(10, b"\xff\xff")), ("another disk", at_end(4, b"\x01\x00")),
        ("an entry that is elsewhere", in_directory(42, b"\xff\xff\xff\x7f")),
        ("an entry of 4 GB", in_directory(24, b"\xfe\xff\xff\xff")),
        ("a size of -1", in_directory(20, b"\xff\xff\xff\xff")), ("a method of no kind", in_directory(10, b"\x63\x00")),
        ("an encrypted entry", in_directory(8, b"\x01\x00")), ("a name of 65,535 bytes", in_directory(28, b"\xff\xff")),
        ("another checksum", in_directory(16, b"\0\0\0\0"))):
    refused(PACKAGES, name, tampered(change), "a.3mf")


def twice():
    out = io.BytesIO()
    with warnings.catch_warnings(), zipfile.ZipFile(out, "w") as archive:
        warnings.simplefilter("ignore")  # that a name stands there twice is the point
        for content in (MODEL % ("inch", "", ""), MODEL % ("metre", "", "")):
            archive.writestr(zipfile.ZipInfo("3D/m.model"), content)
        archive.writestr(zipfile.ZipInfo("_rels/.rels"), RELATIONSHIPS)
    return out.getvalue()


refused(PACKAGES, "an entry twice", twice(), "a.3mf")
refused(PACKAGES, "names that lead out", zipped({"../../x.gltf": scene("y"), "/y": b""}), "a.zip")
refused(PACKAGES, "no entry", zipped({}), "a.zip")
refused(PACKAGES, "a zip of two scenes", zipped({"a.gltf": scene("x"), "b.gltf": scene("x"), "x": SQUARE_BIN}), "a.zip")

# --- files cut off ----------------------------------------------------------------------------------------------------

GZIP, STL = gzip.compress(SQUARE), bytes(80) + struct.pack("<I", 2) + bytes(100)
THREE_MF, GLB = package_3mf("millimeter", ((0, 0, 0), (1, 0, 0), (0, 1, 0)),
                            ((0, 1, 2),)), glb(json.dumps(SCENE).encode())
for name, whole in (("a.obj.gz", GZIP), ("a.stl", STL), ("a.3mf", THREE_MF), ("a.glb", GLB)):
    for eighth in range(1, 8):
        refused(CUT, "%s, %d of 8 parts" % (name, eighth), whole[:len(whole) * eighth // 8], name)

# --- other kinds ------------------------------------------------------------------------------------------------------

for name, content in (
        ("PNG", b"\x89PNG\r\n\x1a\n" + bytes(range(256))), ("ELF", b"\x7fELF" + bytes(500)),
        ("PDF", b"%PDF-1.7\n" + bytes(500)), ("HTML", b"<!doctype html><script>alert(1)</script>"),
        ("JSON", b'{"a": 1}'), ("XML", b'<?xml version="1.0"?><a/>'), ("SQLite", b"SQLite format 3\0" + bytes(500)),
        ("random bytes", bytes((i * 7919 + i // 256 * 31) % 256 for i in range(5000))),
        ("zeros", bytes(5000)), ("blanks", b" " * 5000), ("a script", b"#!/bin/sh\nid\n"),
        ("tar", b"x" * 257 + b"ustar" + bytes(500)), ("bzip2", b"BZh91AY&SY" + bytes(100)),
        ("xz", b"\xfd7zXZ\0" + bytes(100)), ("zstd", b"\x28\xb5\x2f\xfd" + bytes(100)),
        ("STEP", b"ISO-10303-21;\nHEADER;\nENDSEC;\n"), ("an unfinished glTF", b'{"asset": {"version": "2.0"'),
        ("a pickle", b"\x80\x04cos\nsystem\n(S'id'\ntR.")):
    refused(KINDS, name, content, "a.dat")
    refused(KINDS, name + " as STL", content, "a.stl")


@BOMBS.does("stored, and then compared")
def _(arena):
    """A bomb is stored as what it is, and refused each time that it is read."""
    answer = arena.ask(post(ZEROS(), kind=b"Content-Type: model/obj", line=b"POST /v1/meshes"), 200, 201)
    body = json.dumps({"a": answer.json()["id"], "b": answer.json()["id"]}).encode()
    for _ in range(2):
        arena.ask(post(body, kind=b"Content-Type: application/json"), *REFUSED)
    arena.delete("/v1/meshes/" + answer.json()["id"])


@BOMBS.does("as a job, which ends by itself")
def _(arena):
    path = arena.ask(post(multipart([("a", LINES()), ("b", SQUARE)]), b"Prefer: respond-async"),
                     202).headers["location"]
    until(lambda: arena.get(path, 200).json()["state"] == "failed")
    arena.delete(path)


PACKAGES.sends("a comment that is longer than its file", with_mesh(tampered(at_end(20, b"\xff\xff")), "a.3mf"),
               (200, *REFUSED))


@VALUES.does("coordinates of 1e300")
def _(arena):
    huge = b"v 0 0 0\nv 1e300 0 0\nv 0 1e300 0\nf 1 2 3\n"
    answer = arena.ask(post(multipart([("a", huge), ("b", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")])), 200, 422)
    if answer.status == 200:
        holds(answer.json(), 1e300)


@VALUES.does("the smallest triangles there are")
def _(arena):
    tiny = b"v 0 0 0\nv 5e-324 0 0\nv 0 5e-324 0\nf 1 2 3\n"
    answer = arena.ask(post(multipart([("a", tiny), ("b", b"v 0 0 3\nv 5e-324 0 3\nv 0 5e-324 3\nf 1 2 3\n")])), 200,
                       422)
    if answer.status == 200:
        holds(answer.json(), 3)


@VALUES.does("a mesh whose triangles all lie on a point")
def _(arena):
    point = b"v 1 1 1\nf 1 1 1\n" * 500
    answer = arena.ask(post(multipart([("a", point), ("b", b"v 1 1 4\nf 1 1 1\n")])), 200, 422)
    if answer.status == 200:
        holds(answer.json(), 3)
    else:
        demand(answer.json()["errors"], answer.body)
