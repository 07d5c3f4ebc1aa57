"""Hostile arrays: each is refused with its defect, or is a mesh; nothing crashes, nothing is changed or copied in vain."""

import unittest

import numpy

import meshgauge
import objects
import shapes
from meshgauge import _meshes

VERTICES, FACES = shapes.grid(3, 0.1)
GOOD = (VERTICES, FACES)


def with_value(array, place, value):
    changed = array.copy()
    changed[place] = value
    return changed


class Refused(unittest.TestCase):
    CASES = {
        "two columns": (VERTICES[:, :2], FACES, r"vertices of 'a' must have the shape \(n, 3\), not \(16, 2\)"),
        "flat": (VERTICES.ravel(), FACES, r"shape"),
        "three dimensions": (VERTICES[None], FACES, r"shape"),
        "a number": (1.0, FACES, r"shape"),
        "None": (None, FACES, r"shape"),
        "text": (VERTICES.astype(str), FACES, r"real numbers, not <U"),
        "complex": (VERTICES.astype(complex), FACES, r"real numbers, not complex128"),
        "bool": (VERTICES > 0, FACES, r"real numbers, not bool"),
        "objects": (VERTICES.astype(object), FACES, r"real numbers, not object"),
        "dates": (VERTICES.astype("datetime64[s]"), FACES, r"real numbers, not datetime64"),
        "ragged": ([[0, 0, 0], [1, 0]], FACES, r"shape|no array of numbers"),
        "records": (numpy.zeros(16, [("x", float), ("y", float), ("z", float)]), FACES, r"shape"),
        "NaN": (with_value(VERTICES, (7, 1), numpy.nan), FACES, r"vertex 7 of 'a' is NaN"),
        "infinite": (with_value(VERTICES, (7, 2), -numpy.inf), FACES, r"vertex 7 of 'a' is infinite"),
        "NaN of float32": (with_value(VERTICES, (7, 1), numpy.nan).astype(numpy.float32), FACES, r"vertex 7 of 'a' is NaN"),
        "too large": (with_value(VERTICES, (7, 2), 1e308), FACES, r"vertex 7 of 'a' has a coordinate beyond"),
        "not exact": (numpy.full((16, 3), 2**53 + 1), FACES, r"vertex 0 of 'a' is no float64: round the int64 first"),
        "masked": (numpy.ma.masked_less(VERTICES, 0.1), FACES, r"masked"),
        "no vertices": (VERTICES[:0], FACES, r"uses vertex \d+ of 0"),
        "index beyond": (VERTICES, with_value(FACES, (4, 2), 16), r"triangle 4 of 'a' uses vertex 16 of 16"),
        "index beyond, int64": (VERTICES, with_value(FACES.astype(numpy.int64), (4, 2), 2**32), r"triangle 4 of 'a' uses vertex 4294967296"),
        "index negative": (VERTICES, with_value(FACES.astype(numpy.int32), (4, 2), -1), r"triangle 4 of 'a' uses vertex -1 of 16"),
        "index of uint64": (VERTICES, with_value(FACES.astype(numpy.uint64), (4, 2), 2**64 - 1),
                            r"triangle 4 of 'a' uses vertex 18446744073709551615"),
        "index of int8": (VERTICES, with_value(FACES.astype(numpy.int8), (4, 2), -128), r"triangle 4 of 'a' uses vertex -128"),
        "faces of floats": (VERTICES, FACES.astype(float), r"faces of 'a' must be integers, not float64"),
        "faces of bool": (VERTICES, FACES > 0, r"integers, not bool"),
        "faces of four": (VERTICES, numpy.zeros((2, 4), int), r"faces of 'a' must have the shape \(n, 3\), not \(2, 4\)"),
        "faces flat": (VERTICES, FACES.ravel(), r"shape"),
        "no faces": (VERTICES, FACES[:0], r"'a' has no triangles"),
        "nothing": ([], [], r"shape"),
        "faces None": (VERTICES, None, r"'a' has no triangles: it is a point cloud of 16 points"),
    }

    def test_each_is_a_value_error_with_the_defect(self):
        for name, (vertices, faces, message) in self.CASES.items():
            with self.subTest(name), self.assertRaisesRegex(ValueError, message):
                meshgauge.compare((vertices, faces), GOOD)

    def test_the_second_mesh_is_named_b(self):
        with self.assertRaisesRegex(ValueError, "vertex 7 of 'b' is NaN"):
            meshgauge.compare(GOOD, (with_value(VERTICES, (7, 1), numpy.nan), FACES))

    def test_more_rows_than_indices(self):
        """Arrays of no stride, which take no memory."""
        many = numpy.broadcast_to(VERTICES[:1], (2**32, 3)), numpy.broadcast_to(FACES[:1], (2**40, 3))
        for mesh, message in (((many[0], FACES), "vertices of 'a' have 4294967296 rows, more than 4294967295"),
                              ((VERTICES, many[1]), "faces of 'a' have 1099511627776 rows, more than 4294967295")):
            with self.assertRaisesRegex(meshgauge.InputError, message) as refused:
                meshgauge.compare(mesh, GOOD)
            self.assertEqual(refused.exception.kind, "too-large")

    def test_packed_faces(self):
        class Packed:
            points = VERTICES

            def __init__(self, faces):
                self.faces = numpy.array(faces)

        for faces, message in (([3, 0, 1], "3 corners"), ([4, 0, 1, 2], "4 corners"), ([-1, 0, 1, 2], "-1 corners"),
                               ([2, 0, 1], "2 corners"), ([0, 0, 0], "0 corners"), ([4, 0, 1, 2, 99], "face 0 of 'a' uses vertex 99 of 16"),
                               ([3, 0, 1, -5], "uses vertex -5"), ([2**62, 0, 1, 2], "corners"), ([], "no triangles"),
                               ([[3, 0, 1, 2]], "one row"), ([3.0, 0, 1, 2], "integers")):
            with self.subTest(faces), self.assertRaisesRegex(ValueError, message):
                meshgauge.compare(Packed(faces), GOOD)

    def test_objects_that_are_no_meshes(self):
        for thing in (None, 5, object(), (), (VERTICES,), (VERTICES, FACES, FACES), {"vertices": VERTICES}):
            with self.subTest(repr(thing)[:30]), self.assertRaisesRegex(ValueError, "'a' must be a path"):
                meshgauge.compare(thing, GOOD)


class Clouds(unittest.TestCase):
    class PointCloud:
        def __init__(self, name, points):
            setattr(self, name, points)

    class Cells:
        points = VERTICES

        def __init__(self, *kinds):
            self.cells = [type("Cell", (), {"type": kind, "data": numpy.zeros((1, corners), int)}) for kind, corners in kinds]

    class PolyData:
        points = VERTICES
        faces = numpy.empty(0, int)

        def __init__(self, lines=0):
            self.n_lines = lines

    def test_points_without_faces(self):
        other = (VERTICES + [0, 0, 0.5], FACES)
        expected = meshgauge.compare((VERTICES, None), other, direction="a_to_b")
        self.assertEqual(expected.document["meshes"]["a"]["triangles"], 0)
        self.assertLess(expected.upper - expected.lower, 1e-12)
        for cloud in ((VERTICES, []), (VERTICES, FACES[:0]), VERTICES, VERTICES.astype(numpy.float32),
                      self.PointCloud("vertices", VERTICES), self.PointCloud("points", VERTICES), self.PolyData(),
                      self.Cells(("vertex", 1)), self.Cells()):
            found = meshgauge.compare(cloud, other, direction="a_to_b")
            self.assertAlmostEqual(found.upper, expected.upper, 6)  # as float32
            self.assertEqual(found.document["meshes"]["a"]["vertices"], 16)

    def test_by_a_file(self):
        content = _meshes.Arrays(VERTICES, None, "a").to_file()
        found = meshgauge.compare(content, GOOD, direction="a_to_b")
        self.assertEqual(found.document["meshes"]["a"]["triangles"], 0)

    def test_what_is_refused(self):
        for a, b, direction in (((VERTICES, None), GOOD, "symmetric"), ((VERTICES, None), GOOD, "b_to_a"),
                                (GOOD, VERTICES, "a_to_b"), (VERTICES, VERTICES, "a_to_b")):
            with self.assertRaisesRegex(meshgauge.InputError, "is a point cloud of 16 points") as refused:
                meshgauge.compare(a, b, direction=direction)
            self.assertEqual(refused.exception.kind, "empty-mesh")
        for lines in (self.PolyData(1), self.Cells(("line", 2), ("vertex", 1))):
            with self.assertRaisesRegex(meshgauge.InputError, "lines alone"):
                meshgauge.compare(lines, GOOD, direction="a_to_b")
        with self.assertRaisesRegex(meshgauge.InputError, "vertex 3 of 'a' is NaN"):
            meshgauge.compare(with_value(VERTICES, (3, 1), numpy.nan), GOOD, direction="a_to_b")


class Accepted(unittest.TestCase):
    def assert_same(self, mesh):
        expected = meshgauge.compare(GOOD, shapes.grid(4), threads=1)
        got = meshgauge.compare(mesh, shapes.grid(4), threads=1)
        self.assertEqual((got.lower, got.upper, got.witness), (expected.lower, expected.upper, expected.witness))

    def test_layouts(self):
        every_second = numpy.zeros((32, 3))
        every_second[::2] = VERTICES
        unaligned = numpy.frombuffer(b"x" + VERTICES.tobytes(), numpy.uint8)[1:].view(numpy.float64).reshape(-1, 3)
        read_only = VERTICES.copy()
        read_only.flags.writeable = False
        for name, vertices in {"Fortran": numpy.asfortranarray(VERTICES), "strided": every_second[::2], "unaligned": unaligned,
                               "big endian": VERTICES.astype(">f8"), "read-only": read_only, "reversed twice": VERTICES[::-1][::-1],
                               "list": VERTICES.tolist(), "longdouble": VERTICES.astype(numpy.longdouble)}.items():
            with self.subTest(name):
                self.assert_same((vertices, FACES))
        for kind in (numpy.int8, numpy.uint8, numpy.int16, numpy.int32, numpy.int64, numpy.uint64, ">i4", ">u4"):
            with self.subTest(kind):
                self.assert_same((VERTICES, FACES.astype(kind)))
                self.assert_same((VERTICES, numpy.asfortranarray(FACES.astype(kind))))

    def test_nothing_is_copied_that_need_not_be(self):
        read_only = VERTICES.copy()
        read_only.flags.writeable = False
        for vertices, faces in ((VERTICES, FACES), (read_only, FACES.astype(numpy.int32))):
            for arrays in (_meshes.Arrays(vertices, faces, "a"), _meshes.source_of((vertices, faces), "a"),
                           _meshes.source_of(objects.Trimesh(vertices, faces), "a"), _meshes.source_of([(vertices, faces)], "a")):
                self.assertTrue(numpy.shares_memory(arrays.vertices, vertices))
                self.assertTrue(numpy.shares_memory(arrays.triangles, faces))

    def test_a_shape_that_changes_after_it_was_checked(self):
        """The faces are an object, which gives the vertices another shape when it is asked for its numbers."""
        for shape in ((-1, 1), (1, -1), (-1,)):
            vertices = VERTICES.copy()

            class Faces:
                def __array__(self, dtype=None, copy=None):
                    vertices.shape = shape
                    return FACES

            self.assert_same((vertices, Faces()))
            self.assertEqual(vertices.ndim, len(shape))

    def test_arrays_are_not_changed(self):
        vertices, faces = VERTICES.copy(), FACES.copy()
        meshgauge.compare((vertices, faces), (vertices, faces))
        self.assertTrue((vertices == VERTICES).all() and (faces == FACES).all())

    def test_vertices_that_no_triangle_uses_may_be_anything(self):
        vertices = numpy.vstack([VERTICES, [[numpy.nan, numpy.inf, 0]]])
        self.assert_same((vertices, FACES))

    def test_a_thousand_random_meshes(self):
        """Random shapes, types and values: an interval or a ValueError."""
        random = numpy.random.default_rng(1)
        kinds = [numpy.float64, numpy.float32, numpy.float16, numpy.int64, numpy.uint8, complex, bool, ">f8", "S3"]
        indices = [numpy.uint32, numpy.int32, numpy.int64, numpy.uint16, numpy.int8, numpy.float64, ">u8"]
        refused = 0
        for _ in range(1000):
            with numpy.errstate(all="ignore"):
                vertices = random.normal(size=(random.integers(0, 9), random.choice([2, 3, 3, 3, 3]))).astype(kinds[random.integers(9)])
                faces = random.integers(-1, 9, size=(random.integers(0, 9), random.choice([3, 3, 3, 4]))).astype(indices[random.integers(7)])
            try:
                result = meshgauge.compare((vertices, faces), GOOD, threads=1)
                self.assertLessEqual(result.lower, result.upper)
            except ValueError:
                refused += 1
        self.assertGreater(refused, 100)
        self.assertLess(refused, 1000)


if __name__ == "__main__":
    unittest.main()
