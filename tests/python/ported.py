"""How three public test suites compare meshes, on parts with planted faults and with harmless changes.

* build123d, tests/test_mesher.py: the volume agrees to 0 decimal places and the size of the bounding box to 2.
* OpenSCAD, tests/image_compare.py: the pictures of 512 x 512 pixels agree; they differ where all pixels of a 3 x 3 block
  are off by 8 or more in the same direction. The camera looks from its usual place and fits the part by itself.
* OpenSCAD's export tests and conway's digests: the exported text is the same, or its SHA-1 is.

The parts and faults are made here.
"""

import hashlib

import numpy

import meshgauge
import shapes

LIMIT = 0.05
PIXELS = 512


def by_volume(actual, expected):
    size = [numpy.ptp(vertices[faces].reshape(-1, 3), axis=0) for vertices, faces in (actual, expected)]
    return round(abs(shapes.volume(actual) - shapes.volume(expected)), 0) == 0 and (abs(size[0] - size[1]).round(2) == 0).all()


def by_picture(actual, expected):
    off = picture_of(actual) - picture_of(expected)
    for wrong in (off >= 8, off <= -8):
        if not wrong.any():
            continue
        block = numpy.lib.stride_tricks.sliding_window_view(wrong, (3, 3))
        if block.all(axis=(2, 3)).any():
            return False
    return True


def by_digest(actual, expected):
    return len({hashlib.sha1(shapes.obj(mesh)).digest() for mesh in (actual, expected)}) == 1


def by_distance(actual, expected):
    return meshgauge.compare(actual, expected, LIMIT).verdict == "pass"


WAYS = {"volume and bounding box (build123d)": by_volume, "picture (OpenSCAD)": by_picture,
        "text or digest (OpenSCAD, conway)": by_digest, "`assert_mesh_close`": by_distance}


def picture_of(mesh):
    """picture(), once of each part."""
    for name, part in PARTS.items():
        if mesh is part:
            return PICTURES[name] if name in PICTURES else PICTURES.setdefault(name, picture(part))
    return picture(mesh)


def picture(mesh):
    """Grey values, by a z-buffer, of the part as OpenSCAD's camera shows it: rotated by 55 and 25 degrees, fitted."""
    vertices, faces = mesh
    x, z = numpy.radians(-55), numpy.radians(-25)
    turn_z = numpy.array([[numpy.cos(z), -numpy.sin(z), 0], [numpy.sin(z), numpy.cos(z), 0], [0, 0, 1]])
    turn_x = numpy.array([[1, 0, 0], [0, numpy.cos(x), -numpy.sin(x)], [0, numpy.sin(x), numpy.cos(x)]])
    seen = (vertices - (vertices.max(0) + vertices.min(0)) / 2) @ (turn_x @ turn_z).T
    seen[:, :2] = seen[:, :2] * (0.9 * PIXELS / numpy.linalg.norm(numpy.ptp(vertices, axis=0))) + PIXELS / 2
    grey, depth = numpy.full((PIXELS, PIXELS), 255.0), numpy.full((PIXELS, PIXELS), -numpy.inf)
    corners = seen[faces]
    low, high = (numpy.clip(f(corners[:, :, :2], axis=1), 0, PIXELS - 1).astype(int) for f in (numpy.min, numpy.max))
    normals = numpy.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    for i in numpy.flatnonzero(normals[:, 2]):
        draw(*corners[i], normals[i], low[i], high[i], grey, depth)
    return grey


def draw(a, b, c, normal, low, high, grey, depth):
    """One triangle, in the pixels from `low` to `high`."""
    x, y = numpy.arange(low[0], high[0] + 1)[None, :] + 0.5, numpy.arange(low[1], high[1] + 1)[:, None] + 0.5
    u = ((c[0] - b[0]) * (y - b[1]) - (c[1] - b[1]) * (x - b[0])) / normal[2]
    v = ((a[0] - c[0]) * (y - c[1]) - (a[1] - c[1]) * (x - c[0])) / normal[2]
    w = 1 - u - v
    at = u * a[2] + v * b[2] + w * c[2]
    window = numpy.s_[low[1]:high[1] + 1, low[0]:high[0] + 1]
    nearer = (u >= 0) & (v >= 0) & (w >= 0) & (at > depth[window])
    depth[window][nearer] = at[nearer]
    # Back faces are dark, as where OpenSCAD shows that a part is inside out.
    unit = normal / numpy.linalg.norm(normal)
    grey[window][nearer] = 40 + 190 * max(0.0, unit @ [0.36, 0.48, 0.8])


def reversed_faces(mesh):
    return mesh[0], mesh[1][:, ::-1]


def hollow():
    """A cylinder with a box hidden in it."""
    return shapes.joined(shapes.tube(48, 5, 10), reversed_faces(shapes.box(5, (-2.5, -2.5, 2.5))))


def bushing():
    return shapes.tube(48, 8, 6, 5)


def plate():
    """A plate with three pins, of which one is below."""
    pins = [shapes.tube(24, 2, 4), shapes.tube(24, 2, 4), shapes.tube(24, 2, 4)]
    places = [(6, 6, 3), (24, 14, 3), (15, 10, -4)]
    return shapes.joined(shapes.box((30, 20, 3)), *[(vertices + place, faces) for (vertices, faces), place in zip(pins, places)])


PARTS = {"hollow": hollow(), "bushing": bushing(), "plate": plate()}
PICTURES = {}  # by part


def moved(mesh, rows, by):
    vertices = mesh[0].copy()
    vertices[rows] += by
    return vertices, mesh[1]


def last(mesh, count):
    return numpy.arange(len(mesh[0]) - count, len(mesh[0]))


def spike(mesh):
    """A needle of hardly any volume in the middle of a large triangle."""
    vertices, faces = mesh
    corners = vertices[faces]
    areas = numpy.linalg.norm(numpy.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    a, b, c = corners[areas.argmax()]
    normal = numpy.cross(b - a, c - a)
    foot, tip = (a + b + c) / 3, (a + b + c) / 3 - 0.8 * normal / numpy.linalg.norm(normal)
    needle = numpy.array([foot, foot + 0.01 * (b - a), foot + 0.01 * (c - a), tip])
    return shapes.joined(mesh, (needle, numpy.array([[0, 1, 3], [1, 2, 3], [2, 0, 3]])))


def flipped(mesh):
    """A mirror image, with its faces outwards again."""
    vertices = mesh[0] * [-1, 1, 1]
    return reversed_faces((vertices - vertices.min(0) + mesh[0].min(0), mesh[1]))


# Name: (fault, the parts that can have it).
FAULTS = {
    "shifted by 1 mm": (lambda m: (m[0] + [1, 0, 0], m[1]), PARTS),
    "scaled by 1.5 %": (lambda m: (m[0] * 1.015, m[1]), PARTS),
    "0.2 mm too high": (lambda m: (m[0] + [0, 0, 0.2] * (m[0][:, 2:] > m[0][:, 2].max() - 1e-9), m[1]), PARTS),
    "turned by 90 degrees about x": (lambda m: (m[0] @ numpy.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]]), m[1]), PARTS),
    "a triangle is missing": (lambda m: (m[0], m[1][:-1]), PARTS),
    "inside out": (reversed_faces, PARTS),
    "a spike of 0.8 mm inwards": (spike, PARTS),
    "a vertex below is dented by 0.4 mm": (lambda m: moved(m, [int(m[0][:, 2].argmin())], [0, 0, 0.4]), PARTS),
    "cavity moved by 1 mm": (lambda m: moved(m, last(m, 8), [1, 0, 0]), ["hollow"]),
    "cavity turned by 45 degrees": (lambda m: (numpy.concatenate([m[0][:-8], m[0][-8:] @ numpy.array(
        [[0.5**0.5, 0.5**0.5, 0], [-(0.5**0.5), 0.5**0.5, 0], [0, 0, 1]])]), m[1]), ["hollow"]),
    "cavity is missing": (lambda m: (m[0], m[1][:-12]), ["hollow"]),
    "bore off the centre by 0.3 mm": (lambda m: moved(m, last(m, 96), [0.3, 0, 0]), ["bushing"]),
    "bore conical by 0.1 mm": (lambda m: (numpy.concatenate([m[0][:-48], m[0][-48:] * [1.02, 1.02, 1]]), m[1]), ["bushing"]),
    "half as many sides": (lambda m: shapes.tube(24, 8, 6, 5), ["bushing"]),
    "pin below moved by 2 mm": (lambda m: moved(m, last(m, 50), [2, 0, 0]), ["plate"]),
    "pin below is missing": (lambda m: (m[0], m[1][:-96]), ["plate"]),
    "mirrored": (flipped, ["plate"]),
}


def renumbered(mesh):
    order = numpy.random.default_rng(1).permutation(len(mesh[0]))
    return mesh[0][order], numpy.argsort(order)[mesh[1]].astype(numpy.uint32)


def unwelded(mesh):
    return mesh[0][mesh[1]].reshape(-1, 3), numpy.arange(3 * len(mesh[1]), dtype=numpy.uint32).reshape(-1, 3)


def subdivided(mesh):
    """Each triangle in three."""
    vertices, faces = mesh
    middles = len(vertices) + numpy.arange(len(faces))
    split = [numpy.stack([faces[:, i], faces[:, (i + 1) % 3], middles], 1) for i in range(3)]
    return numpy.concatenate([vertices, vertices[faces].mean(1)]), numpy.concatenate(split).astype(numpy.uint32)


HARMLESS = {
    "vertices in another order": renumbered,
    "triangles in another order": lambda m: (m[0], m[1][::-1]),
    "the last digit of coordinates": lambda m: (m[0] * (1 + 2**-52), m[1]),
    "rounded to float32, as in an STL": lambda m: (m[0].astype(numpy.float32).astype(float), m[1]),
    "vertices not shared, as in an STL": unwelded,
    "triangles subdivided": subdivided,
}


def counts():
    """For each way: faults caught, faults, harmless changes refused, harmless changes."""
    faults = [(fault(PARTS[part]), PARTS[part]) for fault, parts in FAULTS.values() for part in parts]
    harmless = [(change(part), part) for change in HARMLESS.values() for part in PARTS.values()]
    return {name: (sum(not way(*pair) for pair in faults), len(faults), sum(not way(*pair) for pair in harmless), len(harmless))
            for name, way in WAYS.items()}


def table():
    rows = [f"| {name} | {caught} of {faults} | {refused} of {harmless} |"
            for name, (caught, faults, refused, harmless) in counts().items()]
    return "\n".join(["| how meshes are compared | faults caught | harmless changes refused |", "|---|---|---|", *rows])


if __name__ == "__main__":
    print(table())
