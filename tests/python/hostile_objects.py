"""Objects that run code while they are read, that hold themselves, or that are no meshes at all."""

import numpy

import shapes

SQUARE, TRIANGLES = shapes.grid(2)


class Reshaping:
    """Gives the faces, and then the vertices have another shape."""

    def __init__(self, vertices, shape):
        self.vertices, self.shape = vertices, shape

    def __array__(self, dtype=None, copy=None):
        self.vertices.shape = self.shape
        return TRIANGLES


class Raising:
    """Each attribute raises."""

    def __init__(self, error):
        self.__dict__["error"] = error

    def __getattr__(self, name):
        raise self.__dict__["error"]


class Endless:
    """Attributes of attributes, without end."""

    def __getattr__(self, name):
        return Endless() if not name.startswith("__") else object.__getattribute__(self, name)

    def __call__(self, *arguments, **more):
        return Endless()


class Blocks:
    """As a MultiBlock of PyVista that has itself as a block."""

    n_blocks = 1

    def __iter__(self):
        return iter([self])

    def extract_surface(self):
        return self


class Lengths:
    """Says that it has more than it has."""

    vertices = SQUARE
    faces = TRIANGLES

    def __len__(self):
        return 1 << 62

    def __getitem__(self, place):
        return self


class ArrayOf:
    def __init__(self, made):
        self.made = made

    def __array__(self, dtype=None, copy=None):
        if isinstance(self.made, Exception):
            raise self.made
        return self.made


def reshaping(shape):
    vertices = numpy.array(SQUARE)
    return vertices, Reshaping(vertices, shape)


def itself():
    mesh = []
    mesh.append(mesh)
    return mesh


def deep(depth):
    mesh = (SQUARE, TRIANGLES)
    for _ in range(depth):
        mesh = [mesh]
    return mesh


class Packed:
    points = SQUARE

    def __init__(self, faces):
        self.faces = faces


# Name: a function that makes it, and whether it is a mesh, the square.
THINGS = {
    "vertices that become a column": (lambda: reshaping((-1, 1)), True),
    "vertices that become a row": (lambda: reshaping((1, -1)), True),
    "vertices that become flat": (lambda: reshaping((-1,)), True), "an object with a length that lies": (Lengths, True),
    "a list 16 deep": (lambda: deep(16), True),
    "a list in itself": (itself, False), "a list 17 deep": (lambda: deep(17), False),
    "a list 900 deep": (lambda: deep(900), False), "blocks in themselves": (Blocks, False),
    "attributes without end": (Endless, False), "None": (lambda: None, False), "a number": (lambda: 7, False),
    "a type": (lambda: dict, False), "a module": (lambda: numpy, False),
    "a function": (lambda: deep, False), "a dictionary": (lambda: {"vertices": SQUARE}, False),
    "three arrays": (lambda: (SQUARE, TRIANGLES, TRIANGLES), False),
    "bytes of nothing": (lambda: b"", False), "bytes of garbage": (lambda: bytes(range(256)) * 20, False),
    "a byte array": (lambda: bytearray(b"v 0 0 0\nf 1 1"), False),
    "half a memory view": (lambda: memoryview(b"x" * 100)[::2], False), "a path with NUL": (lambda: "a\0b", False),
    "a path that is not there": (lambda: "/none/x.obj", False),
    "a folder": (lambda: "/", False), "a path of a megabyte": (lambda: "x" * 1_000_000, False),
    "an array of nothing": (lambda: numpy.empty((0, 3)), False),
    "an array of no dimension": (lambda: numpy.array(5.0), False),
    "an object that gives no array": (lambda: (ArrayOf([1, 2]), TRIANGLES), False),
    "an object that fails": (lambda: (ArrayOf(RuntimeError("no")), TRIANGLES), False),
    "an object without memory": (lambda: (ArrayOf(MemoryError()), TRIANGLES), False),
    "an object that gives itself": (lambda: (ArrayOf(numpy.array(None)), TRIANGLES), False),
    "rows of different lengths": (lambda: ([[0, 0, 0], [1, 0]], TRIANGLES), False),
    "attributes that fail": (lambda: Raising(RuntimeError("no")), False),
    "attributes that recurse": (lambda: Raising(RecursionError("no")), False),
    "attributes without memory": (lambda: Raising(MemoryError("no")), False),
    "attributes with a wrong key": (lambda: Raising(KeyError("no")), False),
    "faces of 2^62 corners": (lambda: Packed(numpy.array([2**62, 0, 1, 2])), False),
    "faces of -1 corners": (lambda: Packed(numpy.array([-1, 0, 1, 2])), False),
    "faces that end early": (lambda: Packed(numpy.array([4, 0, 1, 2])), False),
    "faces of floats": (lambda: Packed(numpy.array([3.0, 0, 1, 2])), False),
}


def drawn(dice):
    """The name of a thing, the thing, and whether it is a mesh."""
    name = dice.choice(sorted(THINGS))
    make, is_mesh = THINGS[name]
    return name, make(), is_mesh
