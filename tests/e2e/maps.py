"""Deviation maps for tests: comparisons to make them of, and what is in the files."""

import json
import struct

from harness import flat_grid, wavy_grid

KINDS = ("ply", "glb", "vtp", "csv")
WAVY, FLAT = wavy_grid(60, 0.1), flat_grid(50)  # 7200 and 5000 triangles
GATE = {"max_distance": "0.05 mm", "narrow": False, "threads": 1}


def store(server, mesh, extra=""):
    answer = server.send("POST", "/v1/meshes", mesh, extra)
    assert answer.status in (200, 201), answer.body
    return answer.json()["id"]


def compared(server, a=WAVY, b=FLAT, options=None, extra=""):
    """The path of a comparison of stored meshes, and its result."""
    body = json.dumps({"a": store(server, a, extra), "b": store(server, b, extra), "options": GATE if options is None else options}).encode()
    answer = server.send("POST", "/v1/comparisons", body, extra + "Content-Type: application/json\r\n")
    assert answer.status == 200, answer.body
    return "/v1/comparisons/" + answer.json()["id"], answer.json()


def ply_of(data):
    """Comments, and the distance of each vertex."""
    head, data = data.split(b"end_header\n", 1)
    lines = head.decode().splitlines()
    count = next(int(line.split()[-1]) for line in lines if line.startswith("element vertex"))
    faces = next(int(line.split()[-1]) for line in lines if line.startswith("element face"))
    size = 3 * (8 if "property double x" in lines else 4) + 3 + 4 + 8
    assert len(data) == count * size + faces * 13
    distances = [struct.unpack_from("<d", data, (v + 1) * size - 8)[0] for v in range(count)]
    return [line.removeprefix("comment ") for line in lines if line.startswith("comment ")], distances, faces


class Glb:
    def __init__(self, data):
        magic, version, length, size = struct.unpack_from("<4sIII", data)
        assert (magic, version, length) == (b"glTF", 2, len(data))
        self.document = json.loads(data[20:20 + size])
        self.bytes = data[28 + size:]
        self.node = self.document["nodes"][0]
        self.extras = self.node["extras"]
        self.primitive = self.document["meshes"][self.node["mesh"]]["primitives"][0]

    def accessor(self, name):
        at = self.primitive["indices"] if name == "indices" else self.primitive["attributes"][name]
        return self.document["accessors"][at]

    def numbers(self, name, code, width):
        accessor = self.accessor(name)
        view = self.document["bufferViews"][accessor["bufferView"]]
        found = struct.unpack_from("<%d%s" % (accessor["count"] * width, code), self.bytes, view.get("byteOffset", 0))
        return [found[i:i + width] for i in range(0, len(found), width)]

    @property
    def triangles(self):
        return self.accessor("indices")["count"] // 3


def positions_of(obj):
    return [tuple(map(float, line.split()[1:4])) for line in obj.decode().splitlines() if line.startswith("v ")]


def as_floats(point):
    return struct.unpack("<fff", struct.pack("<fff", *point))
