"""Meshes that the harness makes, so that the curves need no corpus."""
import array
import gzip
import json
import math
import struct

DIRECTION = (0.48, 0.6, 0.64)  # of displacements; a unit vector


def torus(triangles, phase=0.0, shift=0.0):
    """A bumpy torus of about so many triangles, regular in its two angles: no poles, no slivers.

    `phase` turns the bumps, so that two tori are near each other and not the same; `shift` moves the grid by that
    part of a cell.
    """
    across = max(3, round(math.sqrt(triangles / 4)))
    along = 2 * across
    step_u, step_v = 2 * math.pi / along, 2 * math.pi / across
    rows = [
        (math.cos((j + shift) * step_v), math.sin((j + shift) * step_v), math.cos(5 * (j + shift) * step_v))
        for j in range(across)
    ]
    points = []
    for i in range(along):
        u = (i + shift) * step_u
        cos_u, sin_u, wave = math.cos(u), math.sin(u), 0.05 * math.sin(7 * u + phase)
        for cos_v, sin_v, bump in rows:
            radius = 0.4 * (1 + wave * bump)
            out = 1 + radius * cos_v
            points.append((out * cos_u, out * sin_u, radius * sin_v))
    return points, _wrapped_grid(along, across)


def _wrapped_grid(along, across):
    faces = []
    for i in range(along):
        here, there = i * across, (i + 1) % along * across
        for j in range(across):
            k = (j + 1) % across
            faces.append((here + j, there + j, there + k))
            faces.append((here + j, there + k, here + k))
    return faces


def plane(triangles, flip=False):
    """A unit square of about so many triangles; `flip` cuts its cells along the other diagonal: the same surface."""
    n = max(1, round(math.sqrt(triangles / 2)))
    points = [(i / n, j / n, 0.0) for j in range(n + 1) for i in range(n + 1)]
    faces = []
    for j in range(n):
        for i in range(n):
            a = j * (n + 1) + i
            b, c, d = a + 1, a + n + 1, a + n + 2
            faces += [(a, b, c), (b, d, c)] if flip else [(a, b, d), (a, d, c)]
    return points, faces


def diagonal(points):
    return math.dist([min(p[k] for p in points) for k in range(3)], [max(p[k] for p in points) for k in range(3)])


def moved(mesh, part_of_diagonal):
    points, faces = mesh
    by = [part_of_diagonal * diagonal(points) * x for x in DIRECTION]
    return [(x + by[0], y + by[1], z + by[2]) for x, y, z in points], faces


# --- files ---


def read_obj(path):
    """Of lines `v x y z` and `f a b c` alone, as bench_as_obj writes them."""
    points, faces = [], []
    for line in path.read_text().splitlines():
        what, *numbers = line.split()
        if what == "v":
            points.append(tuple(map(float, numbers)))
        elif what == "f":
            faces.append(tuple(int(number) - 1 for number in numbers))
    return points, faces


def _ply(points, faces):
    head = (
        "ply\nformat binary_little_endian 1.0\n"
        f"element vertex {len(points)}\nproperty double x\nproperty double y\nproperty double z\n"
        f"element face {len(faces)}\nproperty list uchar uint vertex_indices\nend_header\n"
    )
    pack = struct.Struct("<BIII").pack
    return head.encode() + _doubles(points) + b"".join(pack(3, *face) for face in faces)


def _doubles(points):
    return struct.pack(f"<{3 * len(points)}d", *(x for point in points for x in point))


def _obj(points, faces):
    lines = [f"v {x!r} {y!r} {z!r}\n" for x, y, z in points]
    lines += [f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in faces]
    return "".join(lines).encode()


def _stl(points, faces):
    pack = struct.Struct("<12fH").pack
    facets = (pack(0, 0, 0, *points[a], *points[b], *points[c], 0) for a, b, c in faces)
    return bytes(80) + struct.pack("<I", len(faces)) + b"".join(facets)


def _glb(points, faces):
    floats = array.array("f", (x for point in points for x in point))
    indices = array.array("I", (i for face in faces for i in face))
    body = floats.tobytes() + indices.tobytes()
    low, high = ([pick(floats[k::3]) for k in range(3)] for pick in (min, max))
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "buffers": [{"byteLength": len(body)}],
        "bufferViews": [
            {"buffer": 0, "byteLength": 4 * len(floats)},
            {"buffer": 0, "byteOffset": 4 * len(floats), "byteLength": 4 * len(indices)},
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": len(points), "type": "VEC3", "min": low, "max": high},
            {"bufferView": 1, "componentType": 5125, "count": len(indices), "type": "SCALAR"},
        ],
    }
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(body), 0x004E4942) + body
    return struct.pack("<III", 0x46546C67, 2, 12 + len(chunks)) + chunks


WRITERS = {
    ".ply": _ply,
    ".obj": _obj,
    ".stl": _stl,
    ".glb": _glb,
    ".obj.gz": lambda *mesh: gzip.compress(_obj(*mesh), 6, mtime=0),
}


def write(mesh, path):
    """Writes the format that the suffix of `path` names. The file is complete or absent, also after a stopped run."""
    suffix = next(suffix for suffix in WRITERS if path.name.endswith(suffix))
    path.parent.mkdir(parents=True, exist_ok=True)
    half = path.with_name("half-written." + path.name)
    half.write_bytes(WRITERS[suffix](*mesh))
    half.rename(path)
