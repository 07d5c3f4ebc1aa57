"""meshgauge.compare(): what a mesh may be, options, results."""

import json
import math
import os
import pathlib
import subprocess
import tempfile
import types
import unittest

import numpy

import meshgauge
import shapes

PROGRAM = os.environ["MESHGAUGE_BINARY"]
SQUARE = shapes.grid(2)
RAISED = (SQUARE[0] + [0, 0, 2.0], SQUARE[1])


def one_thread(document):
    """The members that do not depend on time or on a file."""
    names = ("status", "verdict", "gate", "unit", "direction", "distance", "a_to_b", "b_to_a", "tolerance", "precision_floor")
    return {name: document[name] for name in names}


class Meshes(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def write(self, name, content):
        path = pathlib.Path(self.folder.name) / name
        path.write_bytes(content)
        return path

    def assert_two(self, result):
        self.assertLessEqual(result.lower, 2)
        self.assertGreaterEqual(result.upper, 2)
        self.assertAlmostEqual(result.lower, 2, delta=1e-9)

    def test_paths_bytes_and_arrays_have_the_same_distance(self):
        path = self.write("square.obj", shapes.obj(SQUARE))
        for a in (path, str(path), path.read_bytes(), bytearray(path.read_bytes()), memoryview(path.read_bytes()), SQUARE,
                  list(SQUARE), (SQUARE[0].tolist(), SQUARE[1].tolist())):
            with self.subTest(type(a)):
                self.assert_two(meshgauge.compare(a, RAISED))

    def test_the_answer_is_the_program_s(self):
        a, b = (self.write(name, shapes.obj(mesh)) for name, mesh in (("a.obj", shapes.sphere(20)), ("b.obj", shapes.sphere(13))))
        run = subprocess.run([PROGRAM, "compare", "--json", "--threads=1", a, b], capture_output=True, check=True)
        of_files = meshgauge.compare(a, b, threads=1)
        self.assertEqual(one_thread(of_files.document), one_thread(json.loads(run.stdout)))
        of_arrays = meshgauge.compare(shapes.sphere(20), shapes.sphere(13), threads=1)
        self.assertEqual(one_thread(of_arrays.document), one_thread(of_files.document))

    def test_objects_of_other_libraries(self):
        vertices, faces = SQUARE
        packed = numpy.hstack([numpy.full((len(faces), 1), 3), faces.astype(int)]).ravel()
        quads = numpy.array([[0, 1, 4, 3], [1, 2, 5, 4], [3, 4, 7, 6], [4, 5, 8, 7]])
        cells = [types.SimpleNamespace(type="quad", data=quads[:2]), types.SimpleNamespace(type="line", data=quads[:, :2]),
                 types.SimpleNamespace(type="triangle", data=numpy.array([[3, 4, 7], [3, 7, 6], [4, 5, 8], [4, 8, 7]]))]
        for like, mesh in {
                "trimesh": types.SimpleNamespace(vertices=vertices, faces=faces.astype(numpy.int64)),
                "Open3D": types.SimpleNamespace(vertices=vertices, triangles=faces.astype(numpy.int32)),
                "PyVista": types.SimpleNamespace(points=vertices.astype(numpy.float32), faces=packed, n_strips=0),
                "PyVista, quads": types.SimpleNamespace(points=vertices, faces=numpy.insert(quads, 0, 4, 1).ravel()),
                "meshio": types.SimpleNamespace(points=vertices, cells=cells)}.items():
            with self.subTest(like):
                result = meshgauge.compare(mesh, RAISED)
                self.assert_two(result)
                polygons = "quads" in like or like == "meshio"
                self.assertEqual(result.document["meshes"]["a"]["format"], "ply" if polygons else "arrays")
                self.assertEqual(result.document["meshes"]["a"]["triangles"], 8)

    def test_a_real_meshio_mesh(self):
        try:
            import meshio
        except ImportError:
            self.skipTest("meshio is not installed")
        self.assert_two(meshgauge.compare(meshio.Mesh(SQUARE[0], [("triangle", SQUARE[1])]), RAISED))

    def test_units_that_an_object_names(self):
        inches = types.SimpleNamespace(vertices=SQUARE[0], faces=SQUARE[1], units="inches")
        result = meshgauge.compare(inches, inches, "1 mm")
        self.assertEqual(result.document["meshes"]["a"]["unit"], {"name": "in", "source": "declared"})
        self.assertEqual((result.verdict, result.unit), ("pass", "mm"))
        declared = meshgauge.compare(inches, inches, units="mm")
        self.assertEqual(declared.unit, "mm")
        with self.assertRaisesRegex(meshgauge.InputError, "parsecs"):
            meshgauge.compare(types.SimpleNamespace(vertices=SQUARE[0], faces=SQUARE[1], units="parsecs"), RAISED)

    def test_a_gltf_with_its_file(self):
        vertices = SQUARE[0].astype("<f4")
        faces = SQUARE[1].astype("<u4")
        scene = {"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
                 "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
                 "accessors": [{"bufferView": 0, "componentType": 5126, "count": len(vertices), "type": "VEC3"},
                               {"bufferView": 1, "componentType": 5125, "count": faces.size, "type": "SCALAR"}],
                 "bufferViews": [{"buffer": 0, "byteLength": vertices.nbytes},
                                 {"buffer": 0, "byteOffset": vertices.nbytes, "byteLength": faces.nbytes}],
                 "buffers": [{"byteLength": vertices.nbytes + faces.nbytes, "uri": "mesh.bin"}]}
        self.write("mesh.bin", vertices.tobytes() + faces.tobytes())
        result = meshgauge.compare(self.write("mesh.gltf", json.dumps(scene).encode()), RAISED, units=(None, "m"))
        self.assert_two(result)
        self.assertEqual(result.unit, "m")

    def test_files_that_are_none(self):
        with self.assertRaises(FileNotFoundError):
            meshgauge.compare("there is no such file.stl", SQUARE)
        with self.assertRaisesRegex(ValueError, "is a folder"):
            meshgauge.compare(self.folder.name, SQUARE)
        bad = self.write("bad.obj", b"v 0 0 0\nv 1 0 zero\n")
        with self.assertRaisesRegex(meshgauge.InputError, "line 2 of '.*bad.obj'") as caught:
            meshgauge.compare(bad, SQUARE)
        self.assertEqual((caught.exception.kind, caught.exception.where), ("unreadable-mesh", "line 2"))
        for content in (b"", b"\0" * 100, b"no mesh"):
            with self.assertRaises(meshgauge.InputError):
                meshgauge.compare(content, SQUARE)


class Vertices(unittest.TestCase):
    def test_not_asked_for(self):
        result = meshgauge.compare(SQUARE, RAISED, sides=True)
        self.assertIsNone(result.vertex_distances)
        self.assertIsNone(result.signed_vertex_distances)

    def test_the_distance_of_each_vertex_and_its_sign(self):
        a, b = shapes.box(0.5, (-0.25, 0, 0.125)), shapes.box(1)
        result = meshgauge.compare(a, b, sides=True, vertex_distances=True)
        outside = numpy.maximum(numpy.maximum(-a[0], a[0] - 1), 0)
        inside = numpy.minimum(a[0], 1 - a[0]).min(1)
        expected = numpy.where(inside > 0, -inside, numpy.linalg.norm(outside, axis=1))
        numpy.testing.assert_allclose(result.vertex_distances, abs(expected), atol=1e-12)
        signed = result.signed_vertex_distances
        numpy.testing.assert_array_equal(signed[expected != 0], (numpy.sign(expected) * result.vertex_distances)[expected != 0])
        self.assertTrue(all(sign == 0 or math.isnan(sign) for sign in signed[expected == 0]))
        self.assertEqual({-1, 0, 1}, set(numpy.sign(expected)))

    def test_they_are_those_of_the_map(self):
        with tempfile.TemporaryDirectory() as folder:
            for name, mesh in (("a.obj", shapes.sphere(20)), ("b.obj", shapes.sphere(13))):
                pathlib.Path(folder, name).write_bytes(shapes.obj(mesh))
            flags = ("--unit-a=mm", "--unit-b=cm", "--align=rigid", "--threads=1", "--timeout-ms=180000", "--map=map.csv")
            subprocess.run([PROGRAM, "compare", "a.obj", "b.obj", *flags], cwd=folder, capture_output=True, check=True)
            lines = pathlib.Path(folder, "map.csv").read_text().splitlines()[1:]
            result = meshgauge.compare(pathlib.Path(folder, "a.obj"), pathlib.Path(folder, "b.obj"), units=("mm", "cm"), align="rigid",
                                       threads=1, timeout=180, vertex_distances=True)
        self.assertEqual(result.vertex_distances.tolist(), [float(line.split(",")[3]) for line in lines])
        self.assertIsNone(result.signed_vertex_distances)

    def test_without_sides_there_is_no_sign(self):
        result = meshgauge.compare(shapes.box(1), SQUARE, sides=True, vertex_distances=True)
        self.assertIsNone(result.signed_vertex_distances)
        self.assertEqual(result.document["sides"]["refused"]["reason"], "open")
        self.assertEqual(sorted(result.vertex_distances), [0] * 4 + [1] * 4)

    def test_a_cloud(self):
        result = meshgauge.compare(SQUARE[0] + [0, 0, 0.5], SQUARE, direction="a_to_b", vertex_distances=True)
        self.assertEqual(set(result.vertex_distances), {0.5})


class Results(unittest.TestCase):
    def test_verdicts(self):
        for limit, verdict in ((2.5, "pass"), ("1.5", "fail"), ("2.5 mm", "pass"), ("0.15 cm", "fail"), (" .25cm ", "pass"), ("1e-2m", "pass")):
            with self.subTest(limit=limit):
                self.assertEqual(meshgauge.compare(SQUARE, RAISED, limit, units="mm").verdict, verdict)
        self.assertIsNone(meshgauge.compare(SQUARE, RAISED).verdict)

    def test_a_limit_close_to_the_distance_is_decided(self):
        self.assertEqual(meshgauge.compare(SQUARE, RAISED, 2.00001).verdict, "pass")
        self.assertEqual(meshgauge.compare(SQUARE, RAISED, 1.99999).verdict, "fail")

    def test_witness_and_directions(self):
        hole = (SQUARE[0], SQUARE[1][:-1])
        one_sided = meshgauge.compare(hole, SQUARE, direction="a_to_b")
        self.assertEqual((one_sided.lower, one_sided.b_to_a), (0.0, None))
        result = meshgauge.compare(hole, SQUARE)
        witness = result.witness
        self.assertEqual(witness.on, "b")
        self.assertEqual(witness.triangle, len(SQUARE[1]) - 1)
        distance = math.dist(witness.point, witness.nearest)
        self.assertGreaterEqual(distance, result.lower - 1e-12)
        self.assertEqual(result.b_to_a.lower, result.lower)

    def test_document_and_timings(self):
        result = meshgauge.compare(SQUARE, RAISED, statistics={"samples": 2000, "seed": 7})
        self.assertEqual(json.loads(result.json()), result.document)
        self.assertEqual(result.document["statistics"]["a_to_b"]["samples"], 2000)
        self.assertGreater(result.timings["total"], 0)
        self.assertEqual(result.document["meshes"]["a"]["sha256"], None)
        self.assertEqual(result.document["meshes"]["a"]["bytes"], SQUARE[0].nbytes + SQUARE[1].nbytes)
        self.assertIn(" .. ", repr(result))
        self.assertEqual(meshgauge.__version__, result.document["engine"]["version"])

    def test_areas(self):
        result = meshgauge.compare(SQUARE, RAISED, areas={"beyond": (0.5,), "quantiles": [0.5], "mean": True})
        found = result.document["areas"]["a_to_b"]
        self.assertEqual(found["beyond"][0]["distance"], 0.5)
        self.assertLessEqual(found["mean"]["lower"], found["mean"]["upper"])
        with self.assertRaisesRegex(meshgauge.InputError, "areas must be a mapping"):
            meshgauge.compare(SQUARE, RAISED, areas=True)

    def test_topology(self):
        found = meshgauge.compare(SQUARE, RAISED, topology=True).document["meshes"]["a"]["topology"]
        self.assertEqual((found["watertight"], found["components"], found["open_edges"]["count"]), (False, 1, 8))
        self.assertNotIn("topology", meshgauge.compare(SQUARE, RAISED).document["meshes"]["a"])

    def test_a_limit_of_the_area(self):
        low = {"distance": 1.5, "share": 0.5}  # every point is at 2
        high = {"distance": "2.5 mm", "share": 0}
        result = meshgauge.compare(SQUARE, RAISED, max_share_beyond=low)
        self.assertEqual(result.verdict, "fail")
        self.assertEqual(result.document["share_beyond"]["verdict"], "fail")
        self.assertEqual(meshgauge.compare(SQUARE, RAISED, max_share_beyond=high).verdict, "pass")
        self.assertEqual(meshgauge.compare(SQUARE, RAISED, "3 mm", max_share_beyond=high).verdict, "pass")
        self.assertEqual(meshgauge.compare(SQUARE, RAISED, "1 mm", max_share_beyond=high).verdict, "fail")
        self.assertEqual(meshgauge.compare(SQUARE, RAISED, "2.1 mm", uncertainty="0.2 mm").verdict, "undecided")
        narrow = meshgauge.compare(SQUARE, RAISED, "90 mm", narrow=True)
        self.assertTrue(narrow.verdict == "pass" and narrow.upper <= 1.1 * narrow.lower, narrow)
        for wrong in (1, {}, {"distance": 1}, {"distance": 1, "share": 2}, {"distance": "x", "share": 0.5},
                      {"distance": 1, "share": 0.5, "more": 1}):
            with self.subTest(wrong), self.assertRaises(meshgauge.InputError):
                meshgauge.compare(SQUARE, RAISED, max_share_beyond=wrong)
        with self.assertRaisesRegex(meshgauge.InputError, "both in the same"):
            meshgauge.compare(SQUARE, RAISED, 1, max_share_beyond=high)
        left = {"name": "left", "box": {"min": (-9, -9, -9), "max": (0.5, 9, 9)}, "max_distance": 0}
        for zero in ({"uncertainty": 0}, {"max_share_beyond": {"distance": 0, "share": 1}}, {"regions": [left]}):
            with self.subTest(zero):  # needs no unit
                self.assertEqual(meshgauge.compare(SQUARE, RAISED, "3 mm", **zero).verdict, "fail" if "regions" in zero else "pass")
        with self.assertRaisesRegex(meshgauge.InputError, "both in the same"):
            meshgauge.compare(SQUARE, RAISED, 2, uncertainty="1 mm")

    def test_regions(self):
        left = {"name": "left", "box": {"min": numpy.array([-9, -9, -9]), "max": (0.5, 9, 9)}, "max_distance": "1.5 mm"}
        ball = {"name": "ball", "sphere": {"centre": [1, 0.5, 1], "radius": 1.2}}
        result = meshgauge.compare(SQUARE, RAISED, "3 mm", regions=[left, ball])  # every point is at 2
        self.assertEqual(result.verdict, "fail")
        self.assertEqual({name: region["verdict"] for name, region in result.regions.items()},
                         {"left": "fail", "ball": "pass", "rest": "pass"})
        self.assertEqual(meshgauge.compare(SQUARE, RAISED).regions, {})
        self.assertEqual(meshgauge.compare(SQUARE, RAISED, regions=[ball]).verdict, None)
        for wrong in (1, "x", [1], [{"name": "x"}], [left], [{**ball, "sphere": {"centre": ["x", 0, 0], "radius": 1}}]):
            with self.subTest(wrong), self.assertRaises(meshgauge.InputError):
                meshgauge.compare(SQUARE, RAISED, regions=wrong)
        with self.assertRaisesRegex(meshgauge.InputError, "both in the same"):
            meshgauge.compare(SQUARE, RAISED, 3, regions=[left])

    def test_groups(self):
        lid = {"name": "lid", "group": "Lid", "max_distance": "1.5 mm"}
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder, "b.obj")
            file.write_text("v 0 0 2\nv 1 0 2\nv 0 1 2\ng Lid\nf 1 2 3\n")
            self.assertEqual(meshgauge.compare(SQUARE, file, "3 mm", regions=[lid]).regions["lid"]["verdict"], "fail")
        with self.assertRaisesRegex(meshgauge.InputError, "no group 'Lid': 'b' has none"):
            meshgauge.compare(SQUARE, RAISED, "3 mm", regions=[lid])

    def test_an_alignment(self):
        matrix = [[1, 0, 0, 0.5], [0, 1, 0, 0], [0, 0, 1, 2], [0, 0, 0, 1]]
        for align in (matrix, {"transform": matrix}, {"transform": {"row_major": sum(matrix, [])}}):
            found = meshgauge.compare(SQUARE, RAISED, align=align).document["alignment"]
            self.assertEqual((found["method"], found["transform"]["row_major"]), ("given", sum(matrix, [])))
        self.assertLess(meshgauge.compare(SQUARE, RAISED, align="rigid").upper, 1e-3)
        self.assertNotIn("alignment", meshgauge.compare(SQUARE, RAISED, align="none").document)
        for wrong in (1, [1, 2], [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "stiff", {"overlap": 7}):
            with self.subTest(wrong), self.assertRaises(meshgauge.InputError):
                meshgauge.compare(SQUARE, RAISED, align=wrong)

    def test_expectations(self):
        result = meshgauge.compare(SQUARE, RAISED, "3 mm", units="mm", expect={"watertight": True, "triangles": {"min": 1}})
        self.assertEqual([(one["name"], one["verdict"]) for one in result.document["expectations"]],
                         [("watertight", "fail"), ("triangles", "pass")])
        self.assertEqual((result.verdict, meshgauge.compare(SQUARE, RAISED, expect={"triangles": {"min": 1}}).verdict), ("fail", "pass"))
        self.assertEqual(result.document["expect"], {"watertight": True, "triangles": {"min": 1}})
        for wrong in ({}, {"water": True}, {"volume": {"within": "1 mm"}}):
            with self.subTest(wrong), self.assertRaises(meshgauge.InputError):
                meshgauge.compare(SQUARE, RAISED, expect=wrong)

    def test_sides_and_a_zone(self):
        cube = [(x, y, z) for z in (0.0, 2.0) for y in (0.0, 2.0) for x in (0.0, 2.0)]
        faces = [(0, 2, 3), (0, 3, 1), (4, 5, 7), (4, 7, 6), (0, 1, 5), (0, 5, 4),
                 (2, 6, 7), (2, 7, 3), (0, 4, 6), (0, 6, 2), (1, 3, 7), (1, 7, 5)]
        solid, moved = (cube, faces), ([(x + 0.25, y, z) for x, y, z in cube], faces)
        found = meshgauge.compare(moved, solid, sides={"length_tolerance": 0.001}).document["sides"]
        for side in ("outside", "inside"):
            self.assertLessEqual(found[side]["lower"], 0.25)
            self.assertGreaterEqual(found[side]["upper"], 0.25)
        for zone, verdict in (((-0.3, 0.3), "pass"), (("-0.2", "0.3"), "fail"), (("-0.3 mm", "+0.2 mm"), "fail"),
                              ((0, "0.3 mm"), "fail"), (("-0.2 mm", "0"), "fail"), ((0, 0), "fail")):
            self.assertEqual(meshgauge.compare(moved, solid, zone=zone).verdict, verdict)
        self.assertEqual(meshgauge.compare(moved, solid, zone=(-0.3, 0.3), uncertainty=0.1).verdict, "undecided")
        refused = meshgauge.compare(solid, (cube, faces[1:]), zone=(-1, 1))
        self.assertEqual((refused.verdict, refused.document["sides"]["refused"]["reason"]), ("undecided", "open"))
        for wrong in ("1", (1,), (0.1, 0.2), (-0.1, -0.2), ("-1 mm", "1 in"), (None, 1)):
            with self.subTest(wrong), self.assertRaises(meshgauge.InputError):
                meshgauge.compare(moved, solid, zone=wrong)

    def test_a_timeout_leaves_an_interval(self):
        flat = shapes.grid(120), shapes.grid(127)
        result = meshgauge.compare(*flat, tolerance=0, strategy="four_point", timeout=0.2, threads=1)
        self.assertEqual(result.status, "timeout")
        self.assertLessEqual(result.lower, result.upper)

    def test_options_that_are_refused(self):
        for options, named in (({"tolerance": -1}, "tolerance.absolute"), ({"tolerance": {"relativ": 1}}, "relativ"),
                               ({"tolerance": "small"}, "tolerance"), ({"timeout": 0}, "timeout"), ({"timeout": math.nan}, "timeout"),
                               ({"threads": 0}, "threads"), ({"threads": 1.5}, "threads"), ({"threads": 65}, "threads"),
                               ({"direction": "up"}, "direction"), ({"units": "parsec"}, "parsec"), ({"units": ("mm",)}, "units"),
                               ({"strategy": "best"}, "strategy"), ({"points": 4}, "points"), ({"max_distance": "5,0 mm"}, "5,0 mm"),
                               ({"max_distance": "-1 mm"}, "-1 mm"), ({"max_distance": "1 parsec"}, "parsec"),
                               ({"max_distance": math.inf}, "max_distance"), ({"statistics": {"samples": 1}}, "statistics.samples")):
            with self.subTest(options):
                with self.assertRaises(meshgauge.InputError) as caught:
                    meshgauge.compare(SQUARE, RAISED, **options)
                self.assertIn(named, str(caught.exception))
        with self.assertRaises(TypeError):
            meshgauge.compare(SQUARE, RAISED, timeout_ms=1)

    def test_units_that_contradict(self):
        with self.assertRaises(meshgauge.InputError) as caught:
            meshgauge.compare(SQUARE, RAISED, "1 mm", units=("in", None))
        self.assertEqual(caught.exception.kind, "unit-conflict")
        self.assertIn("arrays", str(caught.exception))


if __name__ == "__main__":
    unittest.main()
