"""Files that common programs write and that were once refused, misread or passed without a word: each is made here, and gets
the same answer on the command line and over HTTP: read whole, read with a note, or refused with the remedy."""

import io
import json
import pathlib
import struct
import subprocess
import tempfile
import unittest
import zipfile

from harness import BINARY, OWN_DATA
from packages import package_3mf, zipped
from test_formats import FormatCase

CORNERS = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
FACES = [(0, 2, 1), (0, 3, 2), (4, 5, 6), (4, 6, 7), (0, 1, 5), (0, 5, 4), (1, 2, 6), (1, 6, 5), (2, 3, 7), (2, 7, 6), (3, 0, 4), (3, 4, 7)]
POINTS = [CORNERS[i] for face in FACES for i in face]

OBJ = ("".join("v %d %d %d\n" % corner for corner in CORNERS) +
       "".join("f %d %d %d\n" % tuple(i + 1 for i in face) for face in FACES)).encode()
PATCH = (b"".join(b"v %d %d %g\n" % (x + 10, y, 0.3 * x * y) for y in range(4) for x in range(4)) +
         b"cstype bezier\ndeg 3 3\nsurf 0 1 0 1 " + b" ".join(b"%d" % i for i in range(-16, 0)) + b"\nparm u 0 1\nparm v 0 1\nend\n")


def ascii_stl(begin="solid a\n", end="endsolid a\n"):
    facets = "".join("facet normal 0 0 0\n outer loop\n%s endloop\nendfacet\n" % "".join("  vertex %d %d %d\n" % CORNERS[i] for i in face)
                     for face in FACES)
    return (begin + facets + end).encode()


def binary_stl(count=len(FACES), payload=b"", attribute=None, header=b"made by a test"):
    facets = b"".join(struct.pack("<12fH", 0, 0, 0, *(x for i in face for x in CORNERS[i]), len(payload) if attribute is None else attribute) + payload
                      for face in FACES)
    return header.ljust(80, b"\0") + struct.pack("<I", count) + facets


def glb(position=struct.Struct("<3f"), component=5126, stride=None, after=b"", extra=b""):
    data = b"".join(position.pack(*point).ljust(stride or 0, b"\0") for point in POINTS)
    view = {"buffer": 0, "byteLength": len(data), **({"byteStride": stride} if stride else {})}
    document = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
                "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}], "buffers": [{"byteLength": len(data)}], "bufferViews": [view],
                "accessors": [{"bufferView": 0, "componentType": component, "count": len(POINTS), "type": "VEC3",
                               "min": [0, 0, 0], "max": [1, 1, 1]}],
                **({"extensionsRequired": ["KHR_mesh_quantization"], "extensionsUsed": ["KHR_mesh_quantization"]} if component != 5126 else {})}
    chunks = b""
    for kind, content, padding in ((b"JSON", json.dumps(document).encode(), b" "), (b"BIN\0", data, b"\0")):
        content += padding * (-len(content) % 4)
        chunks += struct.pack("<I", len(content)) + kind + content
    return b"glTF" + struct.pack("<II", 2, 12 + len(chunks)) + chunks + after


def cube_3mf(old="", new=""):
    """The cube as a 3MF, in whose model `old` is replaced where it stands last."""
    with zipfile.ZipFile(io.BytesIO(package_3mf("millimeter", CORNERS, FACES))) as archive:
        files = {name: archive.read(name).decode() for name in archive.namelist()}
    before, found, after = files["3D/m.model"].rpartition(old) if old else (files["3D/m.model"], "", "")
    assert found == old
    files["3D/m.model"] = before + new + after
    return zipped(files)


XYZ = "".join("%d %d %d\n" % corner for corner in CORNERS).encode()
SHORT = struct.Struct("<3h")
BYTE = struct.Struct("<3b")
LAST = '<triangle v1="%d" v2="%d" v3="%d"/>' % FACES[-1]
OTHER = '<x:triangle xmlns:x="http://example.com/x" v1="3" v2="4" v3="7"/>'
# Name of the file, its content, the triangles that are read, and what a note says; None: no note besides counts.
READ = [
    ("zbrush.obj", OBJ + b"\0", 12, "NUL or 0x1A bytes after the last line, ignored"),
    ("dos.obj", OBJ + b"\x1a", 12, "NUL or 0x1A bytes after the last line, ignored"),
    ("joined.stl", ascii_stl(end="endsolidAssimpScene\n"), 12, "endsolid"),
    ("mark.stl", b"\xef\xbb\xbf" + ascii_stl(), 12, None),
    ("patch.obj", OBJ + PATCH, 12, "surf"),
    ("colours.stl", binary_stl(attribute=0x7C1F), 12, None),
    ("stride6.glb", glb(SHORT, 5122, 6), 12, "byteStride"),
    ("stride3.glb", glb(BYTE, 5120, 3), 12, "byteStride"),
    ("after.glb", glb(after=b"\0" * 7), 12, "bytes after the end of the GLB, ignored: 7"),
    ("other.3mf", cube_3mf("</triangles>", OTHER + "</triangles>"), 12, "x:triangle"),
    ("heading.xyz", b"//X Y Z\n" + XYZ, 0, "'//X Y Z'"),
    ("counted.xyz", b"8\n" + XYZ, 0, "8"),
]
# Name of the file, its content, its status, and what the message says.
REFUSED = [
    ("only_patch.obj", PATCH, 415, "surf"),
    ("comment.stl", ascii_stl(begin="exported by x\nsolid a\n"), 422, "'solid'"),
    ("payload.stl", binary_stl(payload=b"abcd"), 415, "attribute"),
    ("count0.stl", binary_stl(count=0), 422, "holds 12"),
    ("count11.stl", binary_stl(count=11), 422, "12"),
    ("count.stl", binary_stl(count=0x2020202), 422, "12"),
    ("tri.3mf", cube_3mf(LAST, LAST.replace("<triangle ", "<tri ")), 422, "'tri'"),
]


class Field(FormatCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.cube = self.written("cube.obj", OBJ)

    def written(self, name, content):
        path = self.folder / name
        path.write_bytes(content)
        return path

    def on_the_command_line(self, name, content, *flags):
        return subprocess.run([BINARY, "compare", str(self.written(name, content)), str(self.cube), "--json", *flags], capture_output=True,
                              text=True, timeout=120, env=OWN_DATA)

    def check_read(self, result, triangles, saying):
        mesh = result["meshes"]["a"]
        self.assertEqual(mesh["triangles"], triangles)
        self.assertLessEqual(result["distance"]["upper"], 1e-5)
        if saying:
            self.assertTrue([note for note in mesh["notes"] if saying in note], mesh["notes"])

    def test_what_is_read(self):
        for name, content, triangles, saying in READ:
            with self.subTest(name):
                direction = "symmetric" if triangles else "a_to_b"
                done = self.on_the_command_line(name, content, "--direction", direction)
                self.assertEqual(done.returncode, 0, done.stderr)
                self.check_read(json.loads(done.stdout), triangles, saying)
                answer = self.compare((content, name), (OBJ, "cube.obj"), json.dumps({"direction": direction}).encode())
                self.assertEqual(answer.status, 200, answer.body)
                self.check_read(answer.json(), triangles, saying)

    def test_what_is_refused(self):
        for name, content, status, saying in REFUSED:
            with self.subTest(name):
                done = self.on_the_command_line(name, content)
                self.assertEqual((done.returncode, done.stdout), (3, ""))
                self.assertIn(saying, done.stderr)
                self.assertIn(name, done.stderr)
                answer = self.compare((content, name), (OBJ, "cube.obj"))
                self.assertEqual(answer.status, status, answer.body)
                self.assertIn(saying, answer.json()["detail"])

    def test_an_alignment_is_written_as_expectations_are(self):
        flags = ("--align", "{principal_axes: true}", "--expect", "{watertight: true}")
        done = self.on_the_command_line("a.obj", OBJ, *flags)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertTrue(json.loads(done.stdout)["alignment"]["principal_axes"])


if __name__ == "__main__":
    unittest.main()
