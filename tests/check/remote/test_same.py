"""A service and this process give the same results for the same meshes."""

import gzip
import hashlib
import struct
import tempfile
import unittest
from pathlib import Path

from gates import gate, measure, requests, url_of, without_chance
from harness import RAISED, SQUARE, ServerCase, wavy_grid

TRIANGLE_STL = b"solid t\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid t\n"


def stl(*triangles):
    """Binary STL."""
    return bytes(80) + struct.pack("<I", len(triangles)) + b"".join(struct.pack("<12fH", 0, 0, 1, *t, 0) for t in triangles)


OFF = b"OFF\n4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n"
SCENE = (b'{"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}], "meshes": [{"primitives": '
         b'[{"attributes": {"POSITION": 0}}]}], "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}], '
         b'"bufferViews": [{"buffer": 0, "byteLength": 36}], "buffers": [{"byteLength": 36, "uri": "scene%20data.bin"}]}')
FILES = {
    "scene.gltf": SCENE,
    "scene data.bin": struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0),
    "square.obj": SQUARE,
    "raised.obj": RAISED,
    "square.off": OFF,
    "square.stl": stl((0, 0, 0, 1, 0, 0, 1, 1, 0), (0, 0, 0, 1, 1, 0, 0, 1, 0)),
    "raised.stl": stl((0, 0, 1, 1, 0, 1, 1, 1, 1), (0, 0, 1, 1, 1, 1, 0, 1, 1)),
    "square.obj.gz": gzip.compress(SQUARE, mtime=0),
    "raised.stl.gz": gzip.compress(stl((0, 0, 1, 1, 0, 1, 1, 1, 1), (0, 0, 1, 1, 1, 1, 0, 1, 1)), mtime=0),
    "compressed, unsaid.stl": gzip.compress(OFF, mtime=0),
    "cut.stl": stl((0, 0, 0, 1, 0, 0, 1, 1, 0), (0, 0, 0, 1, 1, 0, 0, 1, 0))[:-20],
    "cut.obj.gz": gzip.compress(SQUARE, mtime=0)[:-12],
    "triangle.stl": TRIANGLE_STL,
    "contradicts its name.ply": b"# not a PLY\n" + SQUARE,
    "caf\u00e9 \"x\".obj": b"# another\n" + SQUARE,
    "waves.obj": wavy_grid(30, 0.1),
    "waves2.obj": wavy_grid(31, 0.11),
    "broken.obj": b"v 0 0 0\nv 1 0 0\nv 2,5 0 0\nf 1 2 3\n",
    "nan.obj": b"v 0 0 0\nv 1 0 nan\nv 1 1 0\nf 1 2 3\n",
    "index.obj": b"v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 9\n",
    "points.obj": b"v 0 0 0\nv 1 0 0\nv 1 1 0\n",
    "empty.obj": b"",
    "image.obj": b"\x89PNG\r\n\x1a\n" + bytes(100),
}

REGIONS = {"regions": [
    {"name": "left", "box": {"min": [-9, -9, -9], "max": [0.3, 9, 9]}, "max_distance": 1},
    {"name": "ball", "sphere": {"centre": [1, 0.5, 1], "radius": 1.2}}]}


class Same(ServerCase):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.folder = tempfile.TemporaryDirectory()
        cls.files = {}
        for name, data in FILES.items():
            cls.files[name] = Path(cls.folder.name) / name
            cls.files[name].write_bytes(data)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()
        super().tearDownClass()

    def gate(self, name, candidate, baseline, **more):
        return gate(name, self.files[candidate], self.files[baseline], **more)

    def both(self, gates):
        """The outcomes of the gates by a service, and by this process."""
        return measure(gates, {"url": url_of(self.server)}), measure(gates)

    def assert_same(self, gates):
        there, here = self.both(gates)
        for name in here:
            with self.subTest(name):
                self.assertIsNone(there[name]["error"])
                self.assertEqual(there[name]["verdict"], here[name]["verdict"])
                self.assertEqual(there[name]["limit"], here[name]["limit"])
                self.assertEqual(without_chance(there[name]["document"]), without_chance(here[name]["document"]))
        return there

    def test_links(self):
        there, here = self.both([self.gate("pass", "square.obj", "square.off"), self.gate("fail", "raised.obj", "square.obj")])
        page = self.server.get("/", extra="Accept: text/html\r\n").headers["content-type"].startswith("text/html")
        for name in here:
            self.assertEqual(here[name]["link"], "")
            self.assertNotIn("view", there[name]["document"])
            seen = url_of(self.server) + "/c/" + there[name]["document"]["id"]
            self.assertEqual(there[name]["link"], seen if page else "")
            # The service keeps the comparison.
            self.assertEqual(self.server.get("/v1/comparisons/" + there[name]["document"]["id"]).json()["state"], "done")

    def test_documents(self):
        there = self.assert_same([
            self.gate("pass", "square.obj", "square.off"),
            self.gate("fail", "raised.obj", "square.obj", max_distance="0.5 mm"),
            self.gate("waves", "waves.obj", "waves2.obj", max_distance=0.01),
            self.gate("one way", "square.obj", "triangle.stl", options={"direction": "a_to_b"}),
            self.gate("the other", "square.obj", "triangle.stl", options={"direction": "b_to_a"}),
            self.gate("points", "waves.obj", "waves2.obj", options={"strategy": "n_point", "points": 31}),
            self.gate("tolerance", "waves.obj", "waves2.obj", options={"tolerance": {"absolute": 0.001}}),
            self.gate("other name", "contradicts its name.ply", "raised.obj"),
            self.gate("several files", "scene.gltf", "triangle.stl"),
            self.gate("strange name", "caf\u00e9 \"x\".obj", "raised.obj"),
            self.gate("zero", "square.obj", "square.obj", max_distance=0),
            self.gate("area", "raised.obj", "square.obj", max_distance=None,
                      max_share_beyond={"distance": "0.5 mm", "share": 0.9}),
            self.gate("regions", "raised.obj", "square.obj", max_distance=3, options=REGIONS),
            self.gate("area kept", "waves.obj", "waves2.obj", max_distance=None, max_share_beyond={"distance": 0.01, "share": 1}),
        ])
        self.assertEqual({name: outcome["verdict"] for name, outcome in there.items()},
                         {"pass": "pass", "fail": "fail", "waves": "fail", "one way": "fail", "the other": "pass",
                          "points": "pass", "tolerance": "pass", "other name": "fail", "several files": "pass", "strange name": "fail",
                          "zero": "pass", "area": "fail", "regions": "fail", "area kept": "pass"})
        self.assertEqual(there["area"]["document"]["gate"],
                         {"max_distance": None, "max_share_beyond": {"distance": 0.5, "share": 0.9}, "units": "mm"})
        self.assertEqual(there["fail"]["document"]["gate"], {"max_distance": 0.5, "units": "mm"})

    def test_files_whose_format_their_bytes_hardly_say(self):
        """Binary STL has no mark of its own; of what is compressed the mark says nothing of the mesh."""
        pairs = [("square.stl", "raised.stl"), ("square.obj.gz", "raised.stl.gz"), ("raised.stl.gz", "square.stl"),
                 ("square.obj", "square.obj.gz"), ("compressed, unsaid.stl", "raised.stl")]
        there = self.assert_same([self.gate(a + " | " + b, a, b) for a, b in pairs])
        read = {}
        for (a, b), outcome in zip(pairs, there.values()):
            meshes = outcome["document"]["meshes"]
            read[a], read[b] = meshes["a"], meshes["b"]
        self.assertEqual({name: mesh["format"] for name, mesh in read.items()},
                         {"square.stl": "stl", "raised.stl": "stl", "square.obj.gz": "obj", "raised.stl.gz": "stl",
                          "square.obj": "obj", "compressed, unsaid.stl": "off"})
        self.assertEqual({mesh["triangles"] for mesh in read.values()}, {2})
        self.assertEqual([outcome["verdict"] for outcome in there.values()], ["fail", "fail", "fail", "pass", "fail"])

    def test_a_share_of_the_diagonal_is_the_same_to_the_last_bit(self):
        gates = [self.gate("share %d" % i, "waves.obj", baseline, max_distance=None, narrow=None,
                           gate={"max_distance": share, "units": "diagonal", "narrow": False})
                 for i, (baseline, share) in enumerate([("waves2.obj", 0.01), ("waves2.obj", 1 / 3), ("triangle.stl", 0.7),
                                                        ("square.off", 1e-300)])]
        self.assert_same(gates)

    def test_statistics(self):
        there = self.assert_same([self.gate("waves", "waves.obj", "waves2.obj", statistics=True)])
        self.assertIsNotNone(there["waves"]["document"]["statistics"])

    def test_files_that_are_no_meshes(self):
        wrong = ["broken.obj", "nan.obj", "index.obj", "points.obj", "empty.obj", "image.obj", "cut.stl", "cut.obj.gz"]
        gates = [self.gate("candidate " + name, name, "square.obj") for name in wrong]
        gates += [self.gate("baseline " + name, "square.obj", name) for name in wrong]
        gates.append(self.gate("cut before its faces", "points.obj", "square.obj", options={"direction": "a_to_b"}))
        gates.append(gate("missing", self.files["square.obj"], Path(self.folder.name) / "nowhere.obj"))
        gates.append(gate("folder", self.folder.name, self.files["square.obj"]))
        there, here = self.both(gates)
        for name in here:
            with self.subTest(name):
                self.assertEqual(there[name], here[name])
                self.assertEqual(there[name]["verdict"], "error")

    def test_what_cannot_be_a_mesh_does_not_travel(self):
        measure([self.gate("image", "image.obj", "empty.obj")], {"url": url_of(self.server)})
        sent = {line["path"].rsplit("/", 1)[1] for line in requests(self.server, "PUT")}
        self.assertFalse(sent & {hashlib.sha256(self.files[name].read_bytes()).hexdigest() for name in ("image.obj", "empty.obj")})


if __name__ == "__main__":
    unittest.main()
