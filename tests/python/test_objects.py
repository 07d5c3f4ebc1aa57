"""Objects of other libraries: each is measured whole, with notes on what has no surface, or is refused by a sentence that helps."""

import math
import unittest

import numpy

import meshgauge
import objects
import shapes
from meshgauge import _arrays

VERTICES, FACES = shapes.box(9.0)
BOX = (VERTICES, FACES)
SQUARE = numpy.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)], float)
TRIANGLES_OF_SQUARE = numpy.array([(0, 1, 2), (0, 2, 3)])
NO_SURFACE = "points, lines, faces of fewer than three corners and joins of strips, left out, since they have no surface"
STRIPS = "strips of triangles, split into triangles and measured"


def packed(*cells):
    return numpy.array([number for cell in cells for number in (len(cell), *cell)], int)


class Case(unittest.TestCase):
    def facts(self, mesh, **options):
        """What the result says of a mesh, which is measured against a box."""
        result = meshgauge.compare(mesh, BOX, **options)
        self.assertEqual([note for note in result.notes if note.startswith("a: ")],
                         [f"a: {note}" for note in result.document["meshes"]["a"]["notes"]])
        return result.document["meshes"]["a"]

    def assert_same(self, mesh, expected, triangles, *notes):
        """`notes`: those that the object adds to the engine's."""
        result = meshgauge.compare(mesh, expected, threads=1)
        self.assertLessEqual(result.upper, 1e-6)
        facts = result.document["meshes"]["a"]
        self.assertEqual(facts["triangles"], triangles)
        self.assertEqual([note for note in facts["notes"] if not note.startswith("faces of more than three")], list(notes))

    def assert_refused(self, mesh, *words, kind=None):
        with self.assertRaises(meshgauge.InputError) as caught:
            meshgauge.compare(mesh, BOX)
        for word in words:
            self.assertIn(word, str(caught.exception))
        if kind is not None:
            self.assertEqual(caught.exception.kind, kind)


class Vtk(Case):
    def test_strips_beside_faces(self):
        """A box whose sides are strips, as PyVista's extrude() makes it."""
        points = SQUARE * [1, 1, 9]
        caps = packed((0, 1, 2, 3), (4, 5, 6, 7))
        sides = packed((0, 1, 4, 5), (1, 2, 5, 6), (2, 3, 6, 7), (3, 0, 7, 4))
        only_caps = (points, numpy.array([(0, 1, 2), (0, 2, 3), (4, 5, 6), (4, 6, 7)]))
        mesh = objects.PolyData(points, caps, sides)
        result = meshgauge.compare(mesh, only_caps, max_distance=0.01)
        self.assertEqual(result.verdict, "fail")
        self.assertIn(f"a: {STRIPS}: 4", result.notes)
        whole = numpy.array([*only_caps[1].tolist(), *((i, (i + 1) % 4, 4 + i) for i in range(4)),
                             *((4 + i, (i + 1) % 4, 4 + (i + 1) % 4) for i in range(4))])
        self.assert_same(mesh, (points, whole), 12, f"{STRIPS}: 4")
        self.assert_same(objects.PolyData(points, strips=sides), (points, whole[4:]), 8, f"{STRIPS}: 4")

    def test_strips_face_the_same_way_and_skip_joins(self):
        points = shapes.grid(2)[0]
        strip = (0, 3, 1, 4, 2, 5, 5, 3, 3, 6, 4, 7, 5, 8)  # two rows of the grid, joined
        mesh = objects.PolyData(points, strips=packed(strip, (0, 1)))
        result = meshgauge.compare(mesh, shapes.grid(2), topology=True)
        facts = result.document["meshes"]["a"]
        self.assertEqual((facts["triangles"], facts["skipped_primitives"]), (8, 5))
        self.assertEqual(facts["notes"], [f"{STRIPS}: 1", f"{NO_SURFACE}: 5"])
        self.assertLessEqual(result.upper, 1e-9)
        self.assertTrue(facts["topology"]["oriented"])

    def test_lines_and_points_are_counted(self):
        mesh = objects.PolyData(SQUARE, packed((0, 1, 2)), lines=packed((0, 1), (1, 2, 3)), verts=packed((0,)))
        facts = self.facts(mesh)
        self.assertEqual((facts["skipped_primitives"], facts["notes"]), (3, [f"{NO_SURFACE}: 3"]))
        mesh.n_lines, mesh.n_verts = 7, 8
        self.assertEqual(self.facts(mesh)["skipped_primitives"], 15)
        self.assert_refused(objects.PolyData(SQUARE, lines=packed((0, 1))), "lines alone", kind="empty-mesh")
        self.assert_refused(objects.PolyData(SQUARE, strips=packed((0, 0, 1))), "no triangles", kind="empty-mesh")

    def test_regular_faces(self):
        mesh = objects.PolyData(SQUARE, None)
        mesh.regular_faces = numpy.array([(0, 1, 2, 3)])
        self.assert_same(mesh, (SQUARE, TRIANGLES_OF_SQUARE), 2)
        mesh.regular_faces = numpy.array([(0, 1)])
        self.assert_refused(mesh, "regular_faces of 'a' (objects.PolyData)", "(1, 2)")

    def test_cells_of_a_grid(self):
        square = (SQUARE, TRIANGLES_OF_SQUARE)
        for kind, corners in ((9, (0, 1, 2, 3)), (8, (0, 1, 3, 2)), (7, (0, 1, 2, 3)), (6, (0, 1, 3, 2))):
            with self.subTest(kind):
                self.assert_same(objects.UnstructuredGrid(SQUARE, (kind, corners)), square, 2, *([f"{STRIPS}: 1"] if kind == 6 else []))
        mixed = objects.UnstructuredGrid(SQUARE, (3, (0, 1)), (5, (0, 1, 2)), (1, (4,)), (5, (0, 2, 3)), (4, (0, 1, 2)), (0, ()))
        self.assert_same(mixed, square, 2, f"{NO_SURFACE}: 3")
        self.assert_refused(objects.UnstructuredGrid(SQUARE, (3, (0, 1))), "lines alone", kind="empty-mesh")
        self.assertEqual(self.facts(objects.UnstructuredGrid(SQUARE, (1, (0,))), direction="a_to_b")["triangles"], 0)

    def test_cells_that_are_no_surface(self):
        for kind, name in ((10, "tetra"), (12, "hexahedron"), (22, "quadratic triangle"), (42, "polyhedron"), (99, "unknown")):
            with self.subTest(name):
                mesh = objects.UnstructuredGrid(SQUARE, (5, (0, 1, 2)), (kind, range(8)), (kind, range(8)))
                self.assert_refused(mesh, f"{name} (VTK type {kind}): 2", ".extract_surface()", kind="unsupported-format")
        self.assert_refused(objects.StructuredGrid(), "objects.StructuredGrid", ".extract_surface()")

    def test_broken_grids(self):
        for kind, corners, message in ((5, (0, 1, 2, 3), "cell 0 of 'a' is a triangle of 4 corners"), (9, (0, 1, 2), "a quad of 3"),
                                       (8, (0, 1, 2), "a pixel of 3"), (7, (0, 1), "a polygon of 2"), (5, (0, 1, 8), "uses vertex 8 of 8")):
            with self.subTest(message):
                self.assert_refused(objects.UnstructuredGrid(SQUARE, (kind, corners)), message)
        mesh = objects.UnstructuredGrid(SQUARE, (5, (0, 1, 2)))
        mesh.celltypes = numpy.array([5, 5])
        self.assert_refused(mesh, "celltypes of 'a' (objects.UnstructuredGrid)", "1 cells, not 2")
        mesh.celltypes = numpy.array([5.0])
        self.assert_refused(mesh, "celltypes of 'a'", "float64")
        mesh.celltypes, mesh.cells = numpy.array([5]), numpy.array([3, 0, 1])
        self.assert_refused(mesh, "cell 0 of 'a' has 3 corners, and 2 numbers follow")

    def test_broken_strips(self):
        for strips, message in (([4, 0, 1, 2], "strip 0 of 'a' has 4 corners, and 3 numbers"), ([3, 0, 1, 8], "uses vertex 8 of 8"),
                                ([-1, 0], "-1 corners"), ([3.0, 0, 1, 2], "strips of 'a' (objects.PolyData) must be one row of integers")):
            with self.subTest(message):
                self.assert_refused(objects.PolyData(SQUARE, strips=numpy.array(strips)), message)
        mesh = objects.PolyData(SQUARE, packed((0, 1, 2)), strips=None)
        mesh.n_strips = 3
        self.assert_refused(mesh, "n_strips", "triangulate()")
        self.assert_refused(objects.PolyData(SQUARE, TRIANGLES_OF_SQUARE), "faces of 'a' (objects.PolyData)",
                            "(2, 3): give a pair, (vertices, faces)")

    def test_vtk_itself(self):
        self.assert_refused(objects.VtkPolyData(), "objects.VtkPolyData", "pyvista.wrap()")


class Others(Case):
    def test_numpy_stl(self):
        mesh = objects.NumpyStl(*BOX)
        self.assert_same(mesh, BOX, 12, "vertices merged with another at exactly the same position: 28")
        self.assertEqual(self.facts(mesh)["welded_vertices"], 28)
        result = meshgauge.compare(mesh, BOX, expect={"watertight": True}, vertex_distances=True)
        self.assertEqual((result.verdict, len(result.vertex_distances)), ("pass", 8))
        mesh.vectors = mesh.vectors.copy()
        mesh.vectors[3, 1, 2] = math.nan
        self.assert_refused(mesh, "a corner of triangle 3 of 'a' is NaN", kind="non-finite-vertex")
        mesh.vectors = mesh.vectors[:, :2]
        self.assert_refused(mesh, "vectors of 'a' (objects.NumpyStl) must have the shape (n, 3, 3), not (12, 2, 3)")
        mesh.vectors = numpy.empty((0, 3, 3))
        self.assert_refused(mesh, "no triangles", kind="empty-mesh")

    def test_merged_corners_keep_the_order_of_their_appearance(self):
        mesh = objects.NumpyStl([(5, 0, 0), (0, 5, 0), (-0.0, 0, 0), (0, 0, 0)], [(0, 1, 2), (3, 1, 0)])
        result = meshgauge.compare(mesh, (numpy.array([(5, 0, 0), (0, 5, 0), (1, 1, 0)], float), [(0, 1, 2)]), vertex_distances=True)
        self.assertEqual(result.vertex_distances[:2].tolist(), [0, 0])
        self.assertAlmostEqual(result.vertex_distances[2], math.sqrt(2))

    def test_corners_are_merged_where_they_are_equal(self):
        random = numpy.random.default_rng(3)
        corners = random.integers(-2, 3, (3000, 3)) * random.choice([1.0, 0.1, -0.0], (3000, 1))
        first = {}
        expected = [first.setdefault(tuple(corner), len(first)) for corner in corners.tolist()]
        points, index = _arrays.welded(corners)
        self.assertEqual(index.tolist(), expected)
        self.assertTrue((points[index] == corners).all())

    def test_a_real_numpy_stl_mesh(self):
        try:
            import stl.mesh
        except ImportError:
            self.skipTest("numpy-stl is not installed")
        mesh = stl.mesh.Mesh(numpy.zeros(12, stl.mesh.Mesh.dtype))
        mesh.vectors[:] = VERTICES[FACES]
        self.assert_same(mesh, BOX, 12, "vertices merged with another at exactly the same position: 28")

    def test_a_real_meshio_mesh(self):
        try:
            import meshio
        except ImportError:
            self.skipTest("meshio is not installed")
        mesh = meshio.Mesh(SQUARE, [("triangle", [[0, 1, 2]]), ("line", [[0, 1]]), ("quad", [[4, 5, 6, 7]]), ("vertex", [[0]])])
        self.assert_same(mesh, (SQUARE, numpy.array([(0, 1, 2), (4, 5, 6), (4, 6, 7)])), 3, f"{NO_SURFACE}: 2")
        self.assert_refused(meshio.Mesh(SQUARE, [("triangle", [[0, 1, 2]]), ("tetra", [[0, 1, 2, 4]])]), "meshio._mesh.Mesh", "'tetra' (1)")

    def test_real_meshes_of_open3d(self):
        try:
            import open3d
        except ImportError:
            self.skipTest("Open3D is not installed")
        legacy = open3d.geometry.TriangleMesh(open3d.utility.Vector3dVector(VERTICES), open3d.utility.Vector3iVector(FACES.astype(numpy.int32)))
        self.assert_same(legacy, BOX, 12)
        self.assert_same([legacy, legacy], BOX, 24, "meshes of a list, measured as one: 2")
        self.assert_same(open3d.t.geometry.TriangleMesh.from_legacy(legacy), BOX, 12)

    def test_cells_of_meshio(self):
        mesh = objects.Meshio(SQUARE, ("triangle", [[0, 1, 2]]), ("polygon", [[4, 5, 6, 7]]), ("line3", [[0, 1, 2]]),
                              ("tetra", numpy.empty((0, 4))))
        self.assert_same(mesh, (SQUARE, numpy.array([(0, 1, 2), (4, 5, 6), (4, 6, 7)])), 3, f"{NO_SURFACE}: 1")
        for kind, data, message in (("triangle6", [[0, 1, 2, 3, 4, 5]], "cells of the type 'triangle6' (1)"),
                                    ("hexahedron", [range(8)] * 2, "'hexahedron' (2)"),
                                    ("quad", [[0, 1, 2]], "cells[0] of 'a' (objects.Meshio) must have the corners of a quad, not 3"),
                                    ("triangle", [[0, 1, 8]], "triangle 0 of 'a' uses vertex 8 of 8"), ("triangle", [[0.5, 1, 2]], "float64"),
                                    ("triangle", [0, 1, 2], "(3,)"), ("polygon", [[0, 1]], "not 2")):
            with self.subTest(message):
                self.assert_refused(objects.Meshio(SQUARE, (kind, data)), message)
        circle = shapes.tube(200, 1.0, 1.0)[0][:200]  # more corners than a number of int8
        mesh = objects.Meshio(circle[:100], ("polygon", [range(100)]))
        mesh.cells[0].data = mesh.cells[0].data.astype(numpy.int8)
        self.assertEqual(self.facts(mesh)["triangles"], 98)
        mesh = objects.Meshio(circle, ("polygon", [range(200)]))
        mesh.cells[0].data = mesh.cells[0].data.astype(numpy.uint8)
        self.assertEqual(self.facts(mesh)["triangles"], 198)
        mesh.cells = [5]
        self.assert_refused(mesh, "cells[0] of 'a' (objects.Meshio) must have a type and data")

    def test_tensors(self):
        for entries in (objects.TensorMap, objects.OlderTensorMap):
            self.assert_same(objects.TensorMesh(*BOX, entries), BOX, 12)
        self.assert_same(objects.LegacyMesh(*BOX), BOX, 12)
        self.assert_refused(objects.TensorMesh(VERTICES, None), "point cloud of 8 points", kind="empty-mesh")
        self.assert_refused(objects.TensorMesh(VERTICES, FACES + 1), "triangle", "uses vertex 8 of 8", kind="index-out-of-range")
        self.assert_refused(objects.TensorMesh(VERTICES[:, :2], FACES), "vertex.positions of 'a' (objects.TensorMesh) must have the shape (n, 3)")
        self.assert_same(tuple(map(objects.Tensor, BOX)), BOX, 12)

    def test_manifold(self):
        for mesh in (objects.ManifoldMesh(*BOX), objects.ManifoldMesh(*BOX, more=0), objects.Manifold(*BOX)):
            self.assert_same(mesh, BOX, 12)
        mesh.to_mesh = lambda: 5
        self.assert_refused(mesh, "to_mesh() of 'a' (objects.Manifold)")
        mesh = objects.ManifoldMesh(*BOX)
        mesh.vert_properties = mesh.vert_properties[:, :2]
        self.assert_refused(mesh, "vert_properties of 'a' (objects.ManifoldMesh)", "(8, 2)")

    def test_doubles_of_a_manifold(self):
        mesh = objects.Manifold(*BOX)
        exact = objects.ManifoldMesh(*BOX)
        exact.vert_properties = VERTICES + 1e-9
        mesh.to_mesh64 = lambda: exact
        self.assertAlmostEqual(meshgauge.compare(mesh, BOX).lower, 3**0.5 * 1e-9, delta=1e-12)

    def test_faces_of_two_kinds(self):
        mesh = objects.LegacyMesh(*BOX)
        mesh.quads = []
        self.assert_same(mesh, BOX, 12)
        mesh.quads = [(0, 1, 2, 3)]
        self.assert_refused(mesh, "objects.LegacyMesh with quads beside triangles", kind="unsupported-format")


class Refused(Case):
    def test_a_sentence_helps(self):
        of = objects.of_library
        for mesh, *words in (
                (of("build123d.topology", "Part", tessellate=None, vertices=None, faces=None),
                 "build123d.topology.Part", "shape.tessellate(0.01)", "tuple(p)"),
                (of("cadquery.occ_impl.shapes", "Solid", tessellate=None, Vertices=None), "shape.tessellate(0.01)", "p.toTuple()"),
                (of("cadquery.cq", "Workplane", val=None, faces=None, vertices=None), "part.val().tessellate(0.01)", "p.toTuple()"),
                (of("build123d.build_part", "BuildPart", part=1), "builder.part.tessellate(0.01)"),
                (of("bpy_types", "Object", to_mesh=None), "Blender", "calc_loop_triangles()"),
                (of("bpy_types", "Mesh", vertices=[1], polygons=[1]), "Blender"),
                (of("other", "Object", matrix_world=[1]), "Blender"), (of("other", "Mesh", vertices=[1], loop_triangles=[1]), "Blender"),
                (of("pymeshlab.pmeshlab", "MeshSet", current_mesh=None), "m.vertex_matrix(), m.face_matrix()"),
                (of("pymeshlab.pmeshlab", "Mesh", vertex_matrix=None, face_matrix=None), "mesh.vertex_matrix()"),
                (of("pytorch3d.structures.meshes", "Meshes", verts_packed=None, faces_packed=None), "verts_packed()"),
                (of("Mesh", "Feature", Topology=([], [])), "mesh.Topology"),
                (of("other", "Mesh", vertices=None, faces=None), "are methods", "(vertices, faces)"),
                (objects.TetraMesh(), "tetrahedra"), (objects.LineSet(), "lines alone"),
                (objects.Path3D(VERTICES, [1]), "lines alone")):
            with self.subTest(words[0]):
                self.assert_refused(mesh, "'a'", *words)

    def test_attributes_that_cannot_be_read(self):
        class Broken:
            def __init__(self, **broken):
                self._broken = broken

            def __getattr__(self, name):
                if name in self._broken:
                    if isinstance(self._broken[name], Exception):
                        raise self._broken[name]
                    return self._broken[name]
                raise AttributeError(name)

        class Silent(Exception):
            def __str__(self):
                raise ValueError("no words")

        class Array:
            def __array__(self, *_):
                raise OSError("on a disk that is gone")

        for attributes, message in (({"vertices": RuntimeError("boom")}, "vertices of 'a' (test_objects.Refused."),
                                    ({"vertices": VERTICES, "faces": RuntimeError("boom")}, "cannot be read: RuntimeError: boom"),
                                    ({"points": Silent()}, "cannot be read: Silent"), ({"geometry": KeyError("x")}, "geometry of 'a'"),
                                    ({"vertices": Array(), "faces": FACES}, "is no array of numbers: OSError: on a disk"),
                                    ({"vertices": VERTICES, "faces": Array()}, "is no array of numbers"),
                                    ({"points": VERTICES, "cells": [Array()]}, "must have a type and data"),
                                    ({"vertices": VERTICES, "faces": object()}, "faces of 'a'"), ({"vertices": VERTICES, "faces": 5}, "faces of 'a'"),
                                    ({"points": VERTICES, "faces": "abc"}, "faces of 'a'"), ({"vectors": object()}, "vectors of 'a'"),
                                    ({"vertex": 5, "triangle": 5}, "vertex.positions of 'a'"),
                                    ({"vertices": VERTICES, "faces": FACES, "units": 5}, "units of 'a'"),
                                    ({"points": VERTICES, "cells": [5], "celltypes": "abc"}, "celltypes of 'a'"),
                                    ({"vert_properties": [[0, 0, "x"]], "tri_verts": FACES}, "vert_properties of 'a'")):
            with self.subTest(message):
                self.assert_refused(Broken(**attributes), message)
        for passed in (MemoryError, KeyboardInterrupt):
            with self.assertRaises(passed):
                meshgauge.compare(type("Fails", (), {"vertices": property(lambda self: (_ for _ in ()).throw(passed()))})(), BOX)

    def test_a_thousand_random_objects(self):
        """Any attributes with any values: an interval or an InputError."""
        random = numpy.random.default_rng(2)
        names = ("vertices", "faces", "triangles", "points", "strips", "cells", "celltypes", "vectors", "vert_properties", "tri_verts", "vertex",
                 "triangle", "geometry", "n_blocks", "lines", "verts", "units", "regular_faces", "n_strips")
        values = (lambda: VERTICES, lambda: FACES, lambda: random.integers(-1, 9, random.integers(0, 30)), lambda: packed((0, 1, 2), (1, 2, 3, 4)),
                  lambda: random.integers(0, 99, 2), lambda: None, lambda: 5, lambda: "mm", lambda: {"positions": VERTICES, "indices": FACES},
                  lambda: [objects.Cell("triangle", [[0, 1, 2]])], lambda: VERTICES[FACES], lambda: [], lambda: numpy.empty((0, 3)), object)
        refused = 0
        for _ in range(1000):
            chosen = random.choice(names, random.integers(1, 6))
            mesh = type("Random", (), {name: values[random.integers(len(values))]() for name in chosen})()
            try:
                result = meshgauge.compare(mesh, BOX, threads=1)
                self.assertLessEqual(result.lower, result.upper)
            except meshgauge.InputError:
                refused += 1
        self.assertGreater(refused, 500)


if __name__ == "__main__":
    unittest.main()
