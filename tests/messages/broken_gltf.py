"""glTF and GLB files that are refused, one for each mistake that the page of messages shows."""

import base64
import json
import struct

TRIANGLE = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
DATA = struct.pack("<9f3H", *sum(TRIANGLE, ()), 0, 1, 2) + bytes(2)


def document(uri=True):
    buffer = {"byteLength": len(DATA)}
    if uri:
        buffer["uri"] = "data:application/octet-stream;base64," + base64.b64encode(DATA).decode()
    return {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "buffers": [buffer],
        "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 6}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
                      {"bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR"}]}


def gltf(change):
    """The document after `change(document)`."""
    whole = document()
    change(whole)
    return json.dumps(whole).encode()


def put(path, value):
    """A change: sets the member at a path such as "nodes.0.mesh"."""
    def change(whole):
        *places, last = path.split(".")
        for place in places:
            whole = whole[int(place) if place.isdigit() else place]
        whole[int(last) if last.isdigit() else last] = value
    return change


def gltf_files():
    nan = struct.pack("<f", float("nan")) + DATA[4:]
    beyond = DATA[:36] + struct.pack("<3H", 0, 1, 9) + bytes(2)

    restart = DATA[:36] + struct.pack("<3H", 0, 1, 65535) + bytes(2)

    def stride(whole):
        whole["bufferViews"][1].update(byteOffset=24, byteLength=20, byteStride=4)

    def data(content):
        return put("buffers.0.uri", "data:application/octet-stream;base64," + base64.b64encode(content).decode())

    return [
        ("not JSON", b'{"asset": {"version": "2.0"}, "scenes": ['),
        ("version 1.0", gltf(put("asset.version", "1.0"))),
        ("an extension that is required and not known", gltf(put("extensionsRequired", ["EXT_of_tomorrow"]))),
        ("a scene that does not exist", gltf(put("scene", 4))),
        ("a node that does not exist", gltf(put("scenes.0.nodes", [7]))),
        ("a node that is its own child", gltf(put("nodes.0.children", [0]))),
        ("a mesh that does not exist", gltf(put("nodes.0.mesh", 3))),
        ("a matrix of 15 numbers", gltf(put("nodes.0.matrix", [1] * 15))),
        ("a primitive without POSITION", gltf(put("meshes.0.primitives.0.attributes", {"NORMAL": 0}))),
        ("an accessor that does not exist", gltf(put("meshes.0.primitives.0.attributes.POSITION", 5))),
        ("positions of type VEC2", gltf(put("accessors.0.type", "VEC2"))),
        ("indices of floats", gltf(put("accessors.1.componentType", 5126))),
        ("more indices than the view holds", gltf(put("accessors.1.count", 6))),
        ("a view beyond its buffer", gltf(put("bufferViews.0.byteLength", 4000))),
        ("a view that does not exist", gltf(put("accessors.0.bufferView", 9))),
        ("a buffer that is longer than its data", gltf(put("buffers.0.byteLength", 4000))),
        ("a buffer without data", gltf(lambda whole: whole["buffers"][0].pop("uri"))),
        ("data that are not base64", gltf(put("buffers.0.uri", "data:application/octet-stream;base64,***"))),
        ("a coordinate that is NaN", gltf(data(nan))),
        ("an index beyond the last vertex", gltf(data(beyond))),
        ("an index that restarts a primitive", gltf(data(restart))),
        ("indices with a byteStride", gltf(stride)),
        ("a byteStride less than an element", gltf(put("bufferViews.0.byteStride", 6))),
        ("voxels alone", gltf(put("meshes.0.primitives.0", {"attributes": {}, "mode": 2147483647, "extensions": {
            "EXT_primitive_voxels": {}}}))),
        ("no triangles, lines alone", gltf(put("meshes.0.primitives.0.mode", 1))),
    ]


def glb(json_text, binary=DATA, version=2, length=None, kind=0x4E4F534A):
    json_text += b" " * (-len(json_text) % 4)
    body = struct.pack("<II", len(json_text), kind) + json_text + struct.pack("<II", len(binary), 0x004E4942) + binary
    return struct.pack("<4sII", b"glTF", version, length or 12 + len(body)) + body


def glb_files():
    good = json.dumps(document(uri=False)).encode()
    return [
        ("cut in the header", b"glTF\x02\0\0\0"),
        ("version 1", glb(good, version=1)),
        ("another length than announced", glb(good, length=4096)),
        ("cut within a chunk", glb(good)[:-20]),
        ("a length that cuts a chunk", glb(good, length=500)),
        ("two GLB in one file", glb(good) + glb(good)),
        ("a chunk after the end", glb(good) + struct.pack("<II", 4, 0x004E4942) + b"more"),
        ("a first chunk that is not JSON", glb(good, kind=0x12345678)),
        ("a buffer that is longer than the BIN chunk", glb(good, binary=DATA[:20])),
    ]


# The files beside a .gltf: for `compare` and `check` from its folder. (what, URI, content of other files)
SCENE_FILES = [
    ("a file that is not there", "gone.bin", {}),
    ("a file above the folder", "../up.bin", {}),
    ("an absolute path", "/data/part.bin", {}),
    ("an address in the web", "https://example.com/part.bin", {}),
    ("a file that is shorter than its buffer", "short.bin", {"short.bin": DATA[:10]}),
    ("a folder", "folder/", {}),
]


def scene(uri):
    whole = document(uri=False)
    whole["buffers"][0]["uri"] = uri
    return json.dumps(whole).encode()
