"""Mesh files that are refused, one for each mistake that the page of messages shows."""

import gzip
import io
import json
import struct
import warnings
import zipfile

from broken_gltf import TRIANGLE, document, glb_files, gltf_files

OBJ = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
GOOD = OBJ.encode()


def text(old, new, whole):
    assert old in whole, old
    return whole.replace(old, new, 1).encode()


# --- OBJ --------------------------------------------------------------------------------------------------------------


def obj_files():
    def obj(old, new):
        return text(old, new, OBJ)

    return [
        ("a word in place of a coordinate", obj("0 1 0", "0 1 x")),
        ("a comma in place of the decimal point", obj("v 1 0 0", "v 1,5 0 0")),
        ("a vertex of two coordinates", obj("v 1 0 0", "v 1 0")),
        ("a vertex of eight numbers", obj("v 1 0 0", "v 1 0 0 1 1 1 1 1")),
        ("a coordinate that is NaN", obj("v 1 0 0", "v 1 nan 0")),
        ("a coordinate too large for a double", obj("v 1 0 0", "v 1 1e999 0")),
        ("a coordinate too large to measure", obj("v 1 0 0", "v 1 1e308 0")),
        ("index 0", obj("f 1 2 3", "f 0 2 3")),
        ("an index beyond the last vertex", obj("f 1 2 3", "f 1 2 4")),
        ("a relative index before the first vertex", obj("f 1 2 3", "f 1 2 -4")),
        ("a word in place of an index", obj("f 1 2 3", "f 1 2 x")),
        ("a face without corners", obj("f 1 2 3", "f")),
        ("a line that is no OBJ statement", obj("f 1 2 3", "?? 1 2 3")),
        ("a statement in capitals", obj("f 1 2 3", "F 1 2 3")),
        ("a statement joined to its first number", obj("f 1 2 3", "f1 2 3")),
        ("binary data", obj("f 1 2 3", "\0\0\nf 1 2 3")),
        ("no face", obj("f 1 2 3\n", "")),
        ("no face, a free-form surface alone", obj("f 1 2 3", "cstype bezier\ndeg 1 1\nsurf 0 1 0 1 1 2 3 1\nend")),
    ]


# --- XYZ --------------------------------------------------------------------------------------------------------------


def xyz_files():
    return [
        ("a point of two coordinates", b"0 0 0\n1 2\n"),
        ("a comma between coordinates", b"0,0,0\n"),
        ("a coordinate that is NaN", b"0 nan 0\n"),
        ("a coordinate too large for a double", b"0 0 1e999\n"),
        ("a heading of columns in another order", b"//Z Y X\n0 0 0\n"),
        ("another count than points", b"2\n0 0 0\n"),
        ("a file of a molecule", b"2\n\n8 0 0 0\n1 0 0 1\n"),
        ("binary data", b"0 0 0\n" + bytes(8) + b"1\n"),
        ("no point", b"# nothing\n"),
        ("points, in the default direction", b"0 0 0\n1 2 3\n"),
    ]


# --- STL --------------------------------------------------------------------------------------------------------------

STL = "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid x\n"


def binary_stl(count, facets, tail=b""):
    facet = struct.pack("<12fH", 0, 0, 1, *TRIANGLE[0], *TRIANGLE[1], *TRIANGLE[2], 0)
    return bytes(80) + struct.pack("<I", count) + facet * facets + tail


def stl_files():
    def stl(old, new):
        return text(old, new, STL)

    not_finite = bytearray(binary_stl(2, 2))
    not_finite[84 + 12:84 + 16] = struct.pack("<f", float("inf"))
    with_data = b"".join([bytes(80), struct.pack("<I", 2)] + [binary_stl(1, 1)[84:132] + b"\4\0data"] * 2)
    big_endian = bytes(80) + struct.pack(">I", 2) + struct.pack(">12fH", 0, 0, 1, *sum(TRIANGLE, ()), 0) * 2
    return [
        ("ASCII: a word in place of a coordinate", stl("vertex 1 0 0", "vertex 1 0 x")),
        ("ASCII: a vertex of two coordinates", stl("vertex 1 0 0", "vertex 1 0")),
        ("ASCII: a facet of two vertices", stl("vertex 1 0 0\n", "")),
        ("ASCII: no endfacet", stl("endfacet\n", "")),
        ("ASCII: a coordinate that is infinite", stl("vertex 1 0 0", "vertex 1 inf 0")),
        ("ASCII: a fourth vertex", stl("endloop\n", "vertex 0 0 0\nendloop\n")),
        ("ASCII: no facet", b"solid x\nendsolid x\n"),
        ("ASCII: a comment first", b"# made by x\n" + STL.encode()),
        ("ASCII: no 'solid'", stl("solid x\nfacet", "facet")),
        ("text of another kind", b"Moved to another server\n"),
        ("binary: fewer facets than announced", binary_stl(3, 2)),
        ("binary: more bytes than announced", binary_stl(1, 1, bytes(90))),
        ("binary: a count of 0 over whole facets", binary_stl(0, 12)),
        ("binary: a count too small by a facet", binary_stl(11, 12)),
        ("binary: attribute data after facets", with_data),
        ("binary: big-endian", big_endian),
        ("binary: cut within a facet", binary_stl(2, 2)[:-7]),
        ("binary: no facet", binary_stl(0, 0)),
        ("binary: a coordinate that is infinite", bytes(not_finite)),
    ]


# --- PLY --------------------------------------------------------------------------------------------------------------

PLY = ("ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
       "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")


def ply_files():
    def ply(old, new):
        return text(old, new, PLY)

    binary = ply("ascii", "binary_little_endian").split(b"end_header\n")[0] + b"end_header\n"
    body = struct.pack("<9f", *sum(TRIANGLE, ())) + struct.pack("<B3i", 3, 0, 1, 2)
    return [
        ("an unknown encoding", ply("ascii", "utf8")),
        ("another version", ply("1.0", "2.0")),
        ("no format", ply("format ascii 1.0\n", "")),
        ("an unknown type", ply("float y", "real y")),
        ("a count that is no number", ply("vertex 3", "vertex three")),
        ("faces under another name", ply("element face", "element polygon")),
        ("triangles in properties of their own", text("face 1\nproperty list uchar int vertex_indices",
                                                      "triangle 1\nproperty int a\nproperty int b\nproperty int c",
                                                      PLY.replace("3 0 1 2", "0 1 2"))),
        ("edges alone", text("face 1\nproperty list uchar int vertex_indices", "edge 1\nproperty int vertex1\nproperty int vertex2",
                             PLY.replace("3 0 1 2", "0 1"))),
        ("no 'ply' as line 1", ply("ply\n", "# a scan\n")),
        ("an element twice", ply("element face", "element vertex")),
        ("a property before any element", ply("format ascii 1.0\n", "format ascii 1.0\nproperty float x\n")),
        ("a property twice", ply("float y", "float x")),
        ("a property without a name", ply("property float y", "property float")),
        ("a line of no known keyword", ply("element face", "elements face")),
        ("no property z", ply("property float z\n", "")),
        ("no list of vertices", ply("vertex_indices", "corners")),
        ("a list of an unsuitable type", ply("list uchar int", "list uchar float")),
        ("the header has no end", ply("end_header", "comment")),
        ("a word in place of a coordinate", ply("0 1 0", "0 1 x")),
        ("a coordinate that is NaN", ply("0 1 0", "0 nan 0")),
        ("a vertex of two coordinates", ply("0 1 0", "0 1")),
        ("an index beyond the last vertex", ply("3 0 1 2", "3 0 1 3")),
        ("a face without corners", ply("3 0 1 2", "0")),
        ("a face of a negative length", ply("3 0 1 2", "-1")),
        ("fewer lines than announced", ply("3 0 1 2\n", "")),
        ("more lines than announced", ply("3 0 1 2\n", "3 0 1 2\n3 0 1 2\n")),
        ("more elements than the file can hold", ply("vertex 3", "vertex 3000000")),
        ("no element of faces", text("element face 1\nproperty list uchar int vertex_indices\n", "", PLY)),
        ("binary: cut", binary + body[:-3]),
        ("binary: bytes behind the last face", binary + body + b"left"),
        ("binary: a coordinate that is NaN", binary + struct.pack("<f", float("nan")) + body[4:]),
    ]


# --- OFF --------------------------------------------------------------------------------------------------------------

OFF = "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"


def off_files():
    def off(old, new):
        return text(old, new, OFF)

    return [
        ("counts that are no numbers", off("3 1 0", "three 1 0")),
        ("a word in place of a coordinate", off("0 1 0", "0 1 x")),
        ("a coordinate that is NaN", off("0 1 0", "0 nan 0")),
        ("a vertex of two coordinates", off("0 1 0", "0 1")),
        ("an index beyond the last vertex", off("3 0 1 2", "3 0 1 3")),
        ("a face without corners", off("3 0 1 2", "0")),
        ("fewer lines than announced", off("3 0 1 2\n", "")),
        ("more lines than announced", off("3 0 1 2\n", "3 0 1 2\n3 0 1 2\n")),
        ("more elements than the file can hold", off("3 1 0", "3000000 1 0")),
        ("four-dimensional vertices", off("OFF", "4OFF")),
        ("another object of Geomview", b"LIST\n{ " + OFF.encode() + b"}\n"),
        ("binary: damaged", b"OFF BINARY\n" + struct.pack(">3I", 3, 9, 0) + bytes(40)),
        ("no face", b"OFF\n3 0 0\n0 0 0\n1 0 0\n0 1 0\n"),
    ]


# --- 3MF --------------------------------------------------------------------------------------------------------------

CORE = 'xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"'
STANDARD = "http://schemas.microsoft.com/3dmanufacturing"
CHOICE = '<x:choice xmlns:x="http://example.com/x"><object id="2"><components/></object></x:choice>'
VERTICES = "".join(f'<vertex x="{x}" y="{y}" z="{z}"/>' for x, y, z in [*TRIANGLE, (0, 0, 1)])
FACES = "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)])
MODEL = (f'<?xml version="1.0"?>\n<model unit="millimeter" {CORE}>\n<resources><object id="1"><mesh>\n'
         f'<vertices>{VERTICES}</vertices>\n<triangles>{FACES}</triangles>\n</mesh></object></resources>\n'
         '<build><item objectid="1"/></build>\n</model>\n')
RELATIONS = ('<?xml version="1.0"?>\n<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">'
             '<Relationship Target="/3D/3dmodel.model" Id="r" '
             'Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>')


def zipped(files):
    out = io.BytesIO()
    with warnings.catch_warnings(), zipfile.ZipFile(out, "w", zipfile.ZIP_STORED) as archive:
        warnings.simplefilter("ignore")  # a name that is there twice is meant so
        for name, content in files:
            archive.writestr(zipfile.ZipInfo(name), content)
    return out.getvalue()


def package(model, relations=RELATIONS):
    return zipped([("_rels/.rels", relations), ("3D/3dmodel.model", model)])


def three_mf_files():
    def model(old, new):
        return package(text(old, new, MODEL))

    whole = package(MODEL.encode())
    return [
        ("no model in the archive", zipped([("_rels/.rels", RELATIONS)])),
        ("no relationships", zipped([("3D/3dmodel.model", MODEL)])),
        ("cut", whole[:-30]),
        ("two entries of one name", zipped([("_rels/.rels", RELATIONS), ("3D/3dmodel.model", MODEL), ("3D/3dmodel.model", MODEL)])),
        ("XML that does not end", model("</model>", "")),
        ("a document type", model("<model", "<!DOCTYPE model><model")),
        ("an unknown unit", model("millimeter", "furlong")),
        ("a word in place of a coordinate", model('x="1"', 'x="one"')),
        ("a vertex without z", model(' z="1"', "")),
        ("an index beyond the last vertex", model('v3="1"', 'v3="9"')),
        ("an item of an object that does not exist", model('objectid="1"', 'objectid="8"')),
        ("two objects of one id", model("</resources>", f'<object id="1"><mesh><vertices>{VERTICES}</vertices><triangles>{FACES}'
                                        "</triangles></mesh></object></resources>")),
        ("a transformation of 11 numbers", model('objectid="1"', 'objectid="1" transform="1 0 0 0 1 0 0 0 1 0 0"')),
        ("an extension that is required and not known", model("<model", '<model requiredextensions="q" xmlns:q="http://example.com/q"')),
        ("an object of an unknown type", model('<object id="1"', '<object id="1" type="cloud"')),
        ("nothing to print", model('<item objectid="1"/>', "")),
        ("a misspelt triangle", model('<triangle v1="2"', '<Triangle v1="2"')),
        ("a misspelt attribute", model("unit=", "Unit=")),
        ("other elements in place of the triangles", package(MODEL.replace("<triangle ", '<x:patch xmlns:x="http://example.com/x" '))),
        ("an object inside of an element that is not read", model("<resources>", f"<resources>{CHOICE}")),
        ("a beam lattice", model("</mesh>", f'<b:beamlattice xmlns:b="{STANDARD}/beamlattice/2017/02"/></mesh>')),
        ("slices in place of the mesh", model('<object id="1"', f'<object id="1" xmlns:s="{STANDARD}/slice/2015/07" s:meshresolution="lowres"')),
        ("an encrypted model", package("%3McF and the rest")),
        ("a path of an undeclared prefix", model('<item objectid="1"', '<item p:path="/3D/other.model" objectid="1"')),
        ("names that differ only by backslashes", zipped([("_rels/.rels", RELATIONS), ("3D/3dmodel.model", MODEL), ("3D\\3dmodel.model", MODEL)])),
    ]


# --- what is no mesh --------------------------------------------------------------------------------------------------


def other_files():
    pointer = b"version https://git-lfs.github.com/spec/v1\noid sha256:" + b"0" * 64 + b"\nsize 12345\n"
    two_scenes = zipped([("a.gltf", json.dumps(document())), ("b.gltf", json.dumps(document()))])
    return [
        ("an empty file", "empty.obj", b""),
        ("a pointer of Git LFS", "pointer.stl", pointer),
        ("a web page", "page.stl", b"<!DOCTYPE html><html><body>Not found</body></html>"),
        ("a PNG image", "picture.obj", b"\x89PNG\r\n\x1a\n" + bytes(40)),
        ("an FBX file", "part.fbx", b"Kaydara FBX Binary  \0\x1a\0" + bytes(40)),
        ("a STEP file", "part.step", b"ISO-10303-21;\nHEADER;\n"),
        ("an XML file", "part.dae", b'<?xml version="1.0"?><COLLADA/>'),
        ("bytes of no known format", "part.bin", bytes(range(128, 256))),
        ("text in UTF-16", "wide.obj", OBJ.encode("utf-16")),
        ("gzip that ends too early", "cut.obj.gz", gzip.compress(GOOD, mtime=0)[:-10]),
        ("gzip with left-over bytes", "more.obj.gz", gzip.compress(GOOD, mtime=0) + b"more"),
        ("gzip inside gzip", "twice.obj.gz", gzip.compress(gzip.compress(GOOD, mtime=0), mtime=0)),
        ("compressed by zstd", "part.obj.zst", b"\x28\xb5\x2f\xfd" + bytes(20)),
        ("an archive of no glTF", "parts.zip", zipped([("part.obj", GOOD)])),
        ("an archive of two .gltf", "scenes.zip", two_scenes),
    ]


def all_files():
    """[(heading, [(what is wrong, name of the file, content)])]"""
    def named(suffix, files):
        return [(what, f"part.{suffix}", content) for what, content in files]

    return [
        ("Files that are no mesh", other_files()),
        ("OBJ", named("obj", obj_files())),
        ("STL", named("stl", stl_files())),
        ("PLY", named("ply", ply_files())),
        ("OFF", named("off", off_files())),
        ("glTF", named("gltf", gltf_files())),
        ("GLB", named("glb", glb_files())),
        ("3MF", named("3mf", three_mf_files())),
        ("XYZ", named("xyz", xyz_files())),
    ]
