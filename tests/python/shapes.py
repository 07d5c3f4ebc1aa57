"""Meshes in arrays of numpy."""

import numpy


def grid(n, height=0.0):
    """The unit square in 2 n^2 triangles, bent to waves of this height."""
    x, y = numpy.meshgrid(numpy.linspace(0, 1, n + 1), numpy.linspace(0, 1, n + 1))
    z = height * numpy.sin(5 * x) * numpy.cos(7 * y)
    corner = (numpy.arange(n)[:, None] * (n + 1) + numpy.arange(n)).ravel()
    faces = numpy.concatenate([numpy.stack([corner, corner + 1, corner + n + 2], 1),
                               numpy.stack([corner, corner + n + 2, corner + n + 1], 1)])
    return numpy.stack([x, y, z], -1).reshape(-1, 3), faces.astype(numpy.uint32)


def box(size, at=(0.0, 0.0, 0.0)):
    """A box of 12 triangles that point outwards, with its lowest corner at `at`."""
    corners = numpy.array([[i & 1, i >> 1 & 1, i >> 2 & 1] for i in range(8)], float)
    quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    faces = [(a, b, c) for a, b, c, d in quads] + [(a, c, d) for a, b, c, d in quads]
    return corners * size + at, numpy.array(faces, numpy.uint32)


def tube(sides, radius, height, bore=0.0):
    """A cylinder, or with a bore a ring, around the z axis."""
    angle = 2 * numpy.pi * numpy.arange(sides) / sides
    circle = numpy.stack([numpy.cos(angle), numpy.sin(angle), 0 * angle], 1)
    up = numpy.array([0, 0, height])
    i, j = numpy.arange(sides), numpy.roll(numpy.arange(sides), -1)
    wall = [(i, j, sides + j), (i, sides + j, sides + i)]
    if bore:
        points = [circle * radius, circle * radius + up, circle * bore, circle * bore + up]
        s = sides
        wall += [(2 * s + i, 3 * s + j, 2 * s + j), (2 * s + i, 3 * s + i, 3 * s + j), (i, 2 * s + j, j),
                 (i, 2 * s + i, 2 * s + j), (s + i, s + j, 3 * s + j), (s + i, 3 * s + j, 3 * s + i)]
    else:
        points = [circle * radius, circle * radius + up, numpy.zeros((1, 3)), up[None]]
        low = numpy.full(sides, 2 * sides)
        wall += [(i, low, j), (sides + i, sides + j, low + 1)]
    return numpy.concatenate(points), numpy.concatenate([numpy.stack(face, 1) for face in wall]).astype(numpy.uint32)


def sphere(rings, radius=1.0):
    """A sphere of 2 rings (rings - 1) * 2 triangles or so, by latitude and longitude."""
    around = 2 * rings
    polar, angle = numpy.meshgrid(numpy.pi * numpy.arange(1, rings) / rings, numpy.pi * numpy.arange(around) / rings,
                                  indexing="ij")
    body = numpy.stack([numpy.sin(polar) * numpy.cos(angle), numpy.sin(polar) * numpy.sin(angle), numpy.cos(polar)], -1)
    points = radius * numpy.concatenate([body.reshape(-1, 3), [[0, 0, 1], [0, 0, -1]]])
    top, bottom = len(points) - 2, len(points) - 1
    faces = []
    for i in range(around):
        j = (i + 1) % around
        faces.append((top, i, j))
        faces.append((bottom, (rings - 2) * around + j, (rings - 2) * around + i))
        for ring in range(rings - 2):
            a, b = ring * around + i, ring * around + j
            faces += [(a, a + around, b), (b, a + around, b + around)]
    return points, numpy.array(faces, numpy.uint32)


def joined(*meshes):
    """Several meshes as one."""
    offsets = numpy.cumsum([0] + [len(vertices) for vertices, _ in meshes])
    return (numpy.concatenate([vertices for vertices, _ in meshes]),
            numpy.concatenate([faces + offset for (_, faces), offset in zip(meshes, offsets)]).astype(numpy.uint32))


def volume(mesh):
    """The signed volume that a closed mesh encloses."""
    a, b, c = (mesh[0][mesh[1][:, k]] for k in range(3))
    return float(numpy.einsum("ij,ij->", a, numpy.cross(b, c))) / 6


def obj(mesh):
    """The mesh as an OBJ file with all digits."""
    lines = ["v %r %r %r" % tuple(map(float, v)) for v in mesh[0]] + ["f %d %d %d" % tuple(f + 1) for f in mesh[1].astype(int)]
    return ("\n".join(lines) + "\n").encode()
