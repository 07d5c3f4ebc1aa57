"""Objects with the attributes of other libraries, which need not be installed. Names and shapes are theirs."""

import numpy

NONE = numpy.empty(0, int)


class Trimesh:
    """trimesh.Trimesh"""

    def __init__(self, vertices, faces, units=None):
        self.vertices, self.faces, self.units = vertices, faces, units

    @property
    def triangles(self):  # the corners of each face, not indices
        return self.vertices[self.faces]


class Path3D:
    """trimesh.path.Path3D"""

    def __init__(self, vertices, entities):
        self.vertices, self.entities, self.units = vertices, entities, None


class PointCloud:
    """trimesh.PointCloud"""

    def __init__(self, vertices):
        self.vertices = vertices


class Graph:
    def __init__(self, places):
        self.geometry_nodes = {name: [f"node {name}"] for name in places}


class Scene:
    """trimesh.Scene: `geometry` has the meshes without their places, dump() those at their places."""

    def __init__(self, geometry, places, units=None):
        self.geometry, self.places, self.units = geometry, places, units
        self.graph = Graph(name for name, _ in places)

    def dump(self, concatenate=False):
        assert not concatenate  # trimesh deprecates it
        placed = []
        for name, shift in self.places:
            mesh = self.geometry[name]
            placed.append(Trimesh(mesh.vertices + shift, mesh.faces, mesh.units) if isinstance(mesh, Trimesh) else mesh)
        return placed


class SceneOfOne:
    """A scene that gives one mesh, as by to_geometry() or to_mesh()."""

    def __init__(self, method, mesh):
        self.geometry = {"a": mesh}
        setattr(self, method, lambda: mesh)


class PolyData:
    """pyvista.PolyData"""

    def __init__(self, points, faces=NONE, strips=NONE, lines=NONE, verts=NONE):
        self.points, self.faces, self.strips, self.lines, self.verts = points, faces, strips, lines, verts

    def extract_surface(self):
        raise AssertionError("has faces")

    def tessellate(self):
        raise AssertionError("has faces")

    GetPolys = GetClassName = extract_surface


class UnstructuredGrid:
    """pyvista.UnstructuredGrid"""

    def __init__(self, points, *cells):
        """`cells`: the VTK type and the corners of each."""
        self.points = points
        self.cells = numpy.array([number for _, corners in cells for number in (len(corners), *corners)], int)
        self.celltypes = numpy.array([kind for kind, _ in cells], numpy.uint8)

    def extract_surface(self):
        raise AssertionError("is not called")

    GetCells = extract_surface


class StructuredGrid:
    """pyvista.StructuredGrid, ImageData and others"""

    points = numpy.zeros((8, 3))
    dimensions = (2, 2, 2)

    def extract_surface(self):
        raise AssertionError("is not called")

    tessellate = GetClassName = extract_surface


class MultiBlock:
    """pyvista.MultiBlock"""

    def __init__(self, *blocks):
        self._blocks = blocks
        self.n_blocks = len(blocks)

    def __iter__(self):
        return iter(self._blocks)

    def extract_surface(self):
        raise AssertionError("is not called")


class VtkPolyData:
    """vtkPolyData since VTK 9.4"""

    points = polys = strips = verts = lines = object()

    def GetPolys(self):
        raise AssertionError("is not called")

    GetClassName = GetStrips = GetPolys


class NumpyStl:
    """stl.mesh.Mesh"""

    def __init__(self, vertices, faces):
        self.vectors = numpy.asarray(vertices, numpy.float32)[faces]
        self.points = self.vectors.reshape(-1, 9)


class Tensor:
    """open3d.core.Tensor on a GPU: it is copied before it is an array."""

    def __init__(self, array, on_gpu=True):
        self._array, self._on_gpu = array, on_gpu

    def cpu(self):
        return Tensor(self._array, False)

    def numpy(self):
        if self._on_gpu:
            raise RuntimeError("can only be called on CPU tensors")
        return self._array


class TensorMap(dict):
    """open3d.t.geometry.TensorMap: its entries are attributes in newer versions."""

    with_attributes = True

    def __getattr__(self, name):
        if self.with_attributes and name in self:
            return self[name]
        raise AttributeError(name)


class OlderTensorMap(TensorMap):
    with_attributes = False


class TensorMesh:
    """open3d.t.geometry.TriangleMesh"""

    def __init__(self, vertices, faces, entries=TensorMap):
        self.vertex = entries(positions=Tensor(vertices))
        self.triangle = entries() if faces is None else entries(indices=Tensor(faces))


class LegacyMesh:
    """open3d.geometry.TriangleMesh"""

    def __init__(self, vertices, triangles):
        self.vertices, self.triangles = vertices, triangles


class LineSet:
    """open3d.geometry.LineSet"""

    points = numpy.zeros((2, 3))
    lines = numpy.array([[0, 1]])


class TetraMesh:
    """open3d.geometry.TetraMesh"""

    vertices = numpy.zeros((4, 3))
    tetras = numpy.array([[0, 1, 2, 3]])


class ManifoldMesh:
    """manifold3d.Mesh: properties beside the position follow it."""

    def __init__(self, vertices, faces, more=2):
        self.vert_properties = numpy.hstack([vertices, numpy.ones((len(vertices), more))]).astype(numpy.float32)
        self.tri_verts = faces.astype(numpy.uint32)


class Manifold:
    """manifold3d.Manifold"""

    def __init__(self, vertices, faces):
        self._mesh = ManifoldMesh(vertices, faces)

    def to_mesh(self):
        return self._mesh


class Cell:
    """meshio.CellBlock"""

    def __init__(self, type, data):
        self.type, self.data = type, numpy.array(data)


class Meshio:
    """meshio.Mesh"""

    def __init__(self, points, *cells):
        self.points = points
        self.cells = [Cell(*cell) for cell in cells]


def of_library(name, class_name, **members):
    """An object of a class of a library that has other methods than attributes."""
    kind = type(class_name, (), {**{member: (lambda self: None) if value is None else value for member, value in members.items()},
                                 "__module__": name})
    return kind()
