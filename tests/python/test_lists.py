"""Lists, blocks and scenes of meshes: one surface, with the units that its meshes name; the same for the client and for pytest."""

import unittest

import numpy

import meshgauge
import objects
import shapes
from meshgauge import _meshes

LEFT, RIGHT = shapes.box(1.0), shapes.box(1.0, (5.0, 0.0, 0.0))
BOTH = (numpy.concatenate([LEFT[0], RIGHT[0]]), numpy.concatenate([LEFT[1], RIGHT[1] + 8]))
OF_LIST = "meshes of a list, measured as one: "
OF_BLOCKS = "meshes of blocks, measured as one: "
OF_SCENE = "meshes of a scene, at their places, measured as one: "
NO_SURFACE = "points, lines, faces of fewer than three corners and joins of strips, left out, since they have no surface: "


class Case(unittest.TestCase):
    def assert_both(self, mesh, *notes, triangles=24):
        result = meshgauge.compare(mesh, BOTH, threads=1)
        self.assertLessEqual(result.upper, 1e-9)
        facts = result.document["meshes"]["a"]
        self.assertEqual((facts["triangles"], facts["notes"]), (triangles, list(notes)))
        return result

    def assert_refused(self, mesh, *words, kind="invalid-request"):
        with self.assertRaises(meshgauge.InputError) as caught:
            meshgauge.compare(mesh, BOTH)
        for word in words:
            self.assertIn(word, str(caught.exception))
        self.assertEqual(caught.exception.kind, kind)


class Lists(Case):
    def test_what_a_list_may_hold(self):
        left, right = (objects.Trimesh(*mesh) for mesh in (LEFT, RIGHT))
        for mesh in ([left, right], (left, right), [LEFT, RIGHT], (LEFT, RIGHT), [left, RIGHT], [LEFT, right],
                     [objects.Manifold(*LEFT), objects.LegacyMesh(*RIGHT)], numpy.array([left, right], object),
                     [(points.tolist(), faces.tolist()) for points, faces in (LEFT, RIGHT)], iter_of(left, right)):
            with self.subTest(str(mesh)[:60]):
                self.assert_both(mesh, (OF_LIST if not isinstance(mesh, objects.MultiBlock) else OF_BLOCKS) + "2")
        self.assert_both([[left], [[right]]], OF_LIST + "2")
        self.assert_both([objects.Trimesh(*BOTH)], OF_LIST + "1")
        self.assert_both([left, right, left], OF_LIST + "3", triangles=36)

    def test_a_pair_of_arrays_is_no_list(self):
        points = numpy.array([(0, 0, 0), (1, 0, 0)], float)  # two vertices, as a list has two meshes
        self.assert_refused((points, numpy.array([(0, 1, 2), (0, 1, 1)])), "triangle 0 of 'a' uses vertex 2 of 2", kind="index-out-of-range")
        for pair in ((points.tolist(), [(0, 1, 1), (0, 0, 1)]), (points, numpy.array([(0, 1, 1), (0, 0, 1)])),
                     (tuple(points), [(0, 1, 1), (0, 0, 1)])):
            self.assertEqual(meshgauge.compare(pair, pair).document["meshes"]["a"]["triangles"], 2)

    def test_faces_of_any_number_of_corners(self):
        points, quads = LEFT[0], numpy.array([4, 0, 2, 3, 1, 4, 4, 5, 7, 6, 4, 0, 1, 5, 4, 4, 2, 6, 7, 3, 4, 0, 4, 6, 2, 4, 1, 3, 7, 5])
        mesh = [objects.PolyData(points, quads), RIGHT, objects.PolyData(points + [5, 0, 0], quads)]
        result = self.assert_both(mesh, "faces of more than three corners, split into triangles: 12", OF_LIST + "3", triangles=36)
        self.assertEqual(result.document["meshes"]["a"]["format"], "ply")

    def test_clouds(self):
        cloud = objects.PointCloud(LEFT[0])
        self.assert_both([objects.Trimesh(*BOTH), cloud], "meshes without faces, left out: 1", OF_LIST + "1")
        result = meshgauge.compare([cloud, objects.PointCloud(RIGHT[0])], BOTH, direction="a_to_b")
        self.assertLessEqual(result.upper, 1e-9)
        self.assertEqual((result.document["meshes"]["a"]["vertices"], result.notes[-1]), (16, "a: clouds of a list, measured as one: 2"))

    def test_what_is_refused(self):
        mesh = objects.Trimesh(*LEFT)
        for held, *words in ((["a.stl", "b.stl"], "'a[0]' is a str", "a list of meshes holds"), ([mesh, b"solid"], "'a[1]' is a bytes"),
                             ([mesh, None], "'a[1]' is a NoneType"), ([None, mesh], "'a[0]' is a NoneType"),
                             ([mesh, LEFT[0]], "'a[1]' is a numpy.ndarray"),
                             ([mesh, 5], "'a[1]' is a int"), ([mesh, object()], "'a[1]' is a object"), ([mesh, []], "'a[1]' is a list"),
                             ([mesh, objects.StructuredGrid()], "'a[1]' is a objects.StructuredGrid", "extract_surface()"),
                             ([objects.of_library("build123d", "Part", tessellate=None)] * 2, "'a[0]'", "tessellate")):
            with self.subTest(words[0]):
                self.assert_refused(held, *words)
        self.assert_refused([mesh, (LEFT[0], LEFT[1] + 1)], "triangle", "of 'a[1]' uses vertex 8 of 8", kind="index-out-of-range")
        broken = LEFT[0].copy()
        broken[3, 1] = numpy.nan
        self.assert_refused([mesh, (broken, LEFT[1])], "vertex 3 of 'a[1]' is NaN", kind="non-finite-vertex")

    def test_lists_without_an_end(self):
        mesh = objects.Trimesh(*LEFT)
        itself = [mesh]
        itself.append(itself)
        self.assert_refused(itself, "'a[1]' holds itself")
        alone = []
        alone.append(alone)
        self.assert_refused(alone, "holds itself")
        deep = mesh
        for _ in range(17):
            deep = [deep]
        self.assert_refused(deep, "more than 16 deep")
        self.assert_both([deep[0][0], objects.Trimesh(*RIGHT)], OF_LIST + "2")

        class Endless:
            n_blocks = 1

            def __iter__(self):
                while True:
                    yield Endless()

        self.assert_refused(Endless(), "more than 1000000 meshes", kind="too-large")


def iter_of(*meshes):
    """The blocks of a MultiBlock, which can only be iterated."""
    return objects.MultiBlock(*meshes)


class Blocks(Case):
    def test_blocks(self):
        left, right = (objects.Trimesh(*mesh) for mesh in (LEFT, RIGHT))
        self.assert_both(objects.MultiBlock(left, None, objects.MultiBlock(right, None)), "blocks without content, left out: 2", OF_BLOCKS + "2")
        self.assert_both([objects.MultiBlock(left), right], OF_LIST + "2")
        self.assert_refused(objects.MultiBlock(left, objects.UnstructuredGrid(LEFT[0], (10, range(4)))), "'a[1]' is a objects.UnstructuredGrid",
                            "tetra", kind="unsupported-format")
        self.assert_refused(objects.MultiBlock(None), "'a' has no triangles", kind="empty-mesh")

        class MultiBlock(list):
            """As a list of blocks with names."""

        self.assert_both(MultiBlock([left, None, right]), "blocks without content, left out: 1", OF_BLOCKS + "2")


class Scenes(Case):
    def scene(self, **units):
        box = objects.Trimesh(*LEFT, units.get("mesh"))
        return objects.Scene({"box": box, "spare": box}, [("box", [0, 0, 0]), ("box", [5, 0, 0])], units.get("scene"))

    def test_meshes_at_their_places(self):
        self.assert_both(self.scene(), "objects outside of the build or the scene, left out: 1", OF_SCENE + "2")
        for method in ("to_geometry", "to_mesh"):
            self.assert_both(objects.SceneOfOne(method, objects.Trimesh(*BOTH)), OF_SCENE + "1")

    def test_what_has_no_surface(self):
        path, cloud = objects.Path3D(LEFT[0], [1, 2, 3]), objects.PointCloud(LEFT[0])
        scene = objects.Scene({"a": objects.Trimesh(*BOTH), "path": path, "cloud": cloud}, [("a", 0), ("path", 0), ("cloud", 0)])
        self.assert_both(scene, "meshes without faces, left out: 1", OF_SCENE + "1", NO_SURFACE + "3")
        self.assert_refused(objects.Scene({"path": path}, [("path", 0)]), "lines alone", kind="empty-mesh")
        self.assert_refused(objects.Scene({}, []), "no triangles", kind="empty-mesh")

    def test_a_scene_that_places_nothing(self):
        class Scene:
            geometry = {"a": None}
            units = None

        self.assert_refused(Scene(), "Scene, a scene that does not place its meshes", "scene.to_mesh()")

    def test_units(self):
        for units in ({"scene": "inches"}, {"mesh": "inches"}, {"scene": "inches", "mesh": "inches"}):
            result = meshgauge.compare(self.scene(**units), objects.Trimesh(BOTH[0] * 25.4, BOTH[1], "mm"), "1 mm")
            self.assertEqual((result.verdict, result.unit), ("pass", "mm"))
            self.assertEqual(result.document["meshes"]["a"]["unit"], {"name": "in", "source": "declared"})
        mixed = [objects.Trimesh(*LEFT, "mm"), objects.Trimesh(*RIGHT, "in")]
        self.assert_refused(mixed, "different units", "'a[0]' is in 'mm', 'a[1]' is in 'in'", "convert them", kind="unit-conflict")
        self.assert_refused([objects.Trimesh(*LEFT, "mm"), RIGHT], "'a[1]' names none", kind="unit-conflict")
        self.assert_refused(self.scene(scene=5), "units of 'a' (objects.Scene)", "int")


class OtherWays(unittest.TestCase):
    def test_the_file_that_is_sent_or_written(self):
        for mesh in ([objects.Trimesh(*LEFT), objects.Trimesh(*RIGHT)], objects.MultiBlock(LEFT, RIGHT)):
            content = _meshes.source_of(mesh, "a").to_file()
            self.assertEqual(meshgauge.compare(content, BOTH).upper, 0)

    def test_notes_of_a_service_s_result(self):
        path = objects.PolyData(LEFT[0], [3, 0, 1, 2], lines=[2, 0, 1])
        sources = _meshes.source_of([path], "a"), _meshes.source_of(RIGHT, "b")
        document = {"meshes": {"a": {"notes": ["one"], "skipped_primitives": 2}, "b": {"notes": []}}}
        self.assertEqual(_meshes.noted(document, _meshes.notes_of(*sources)),
                         {"meshes": {"a": {"notes": ["one", OF_LIST + "1", NO_SURFACE + "1"], "skipped_primitives": 3}, "b": {"notes": []}}})


if __name__ == "__main__":
    unittest.main()
