"""The requests that are sent: whole HTTP requests in files, made of meshes that the project makes itself."""
import hashlib
import json
import urllib.request

from harness import meshes

BOUNDARY = "meshgauge-load-boundary"
SIZES = {"small": 1000, "medium": 50_000}  # triangles of each mesh
# Nine small ones for each medium one; `stored` is the small pair by its ids, as a gate asks again and again.
MIXES = {"small": {"small": 1}, "stored": {"stored": 1}, "medium": {"medium": 1}, "mixed": {"small": 9, "medium": 1}}


def pair(triangles):
    """Two bumpy tori, one a little displaced: a comparison that converges."""
    mesh = meshes.torus(triangles)
    return mesh, meshes.moved(meshes.torus(triangles, phase=0.3), 1e-3)


def multipart(parts):
    body = b""
    for name, file_name, data in parts:
        body += (
            f'--{BOUNDARY}\r\nContent-Disposition: form-data; name="{name}"; filename="{file_name}"\r\n\r\n'.encode()
            + data
            + b"\r\n"
        )
    return body + f"--{BOUNDARY}--\r\n".encode()


LARGE = 1 << 20  # bytes from which curl, and `check --server`, ask before they send a body


def whole(body, key=None, media_type=f"multipart/form-data; boundary={BOUNDARY}"):
    """The request as it goes over the wire."""
    lines = [
        "POST /v1/comparisons HTTP/1.1",
        "Host: 127.0.0.1",
        f"Content-Type: {media_type}",
        f"Content-Length: {len(body)}",
        *([f"Authorization: Bearer {key}"] if key else []),
        *(["Expect: 100-continue"] if len(body) > LARGE else []),
    ]
    return "\r\n".join(lines).encode() + b"\r\n\r\n" + body


def binary_stl(triangles):
    """Both meshes of a pair. Binary STL, as such files mostly are."""
    return [meshes.WRITERS[".stl"](*mesh) for mesh in pair(triangles)]


def make(folder, key=None, options=None):
    """{size: file}."""
    folder.mkdir(parents=True, exist_ok=True)
    asked = json.dumps(options or {}).encode()
    made = {}
    for size, triangles in SIZES.items():
        parts = [(name, f"{name}.stl", data) for name, data in zip("ab", binary_stl(triangles))]
        made[size] = whole(multipart([*parts, ("options", "options.json", asked)]), key)
    ids = [hashlib.sha256(data).hexdigest() for data in binary_stl(SIZES["small"])]
    made["stored"] = whole(json.dumps({"a": ids[0], "b": ids[1]}).encode(), key, "application/json")
    for size, request in made.items():
        (folder / f"{size}.http").write_bytes(request)
    return {size: folder / f"{size}.http" for size in made}


def store(port, key=None):
    """Stores the meshes of the mix `stored`."""
    for data in binary_stl(SIZES["small"]):
        request = urllib.request.Request(
            f"http://127.0.0.1:{port}/v1/meshes/{hashlib.sha256(data).hexdigest()}", data=data, method="PUT"
        )
        if key:
            request.add_header("Authorization", f"Bearer {key}")
        urllib.request.urlopen(request, timeout=30).close()


def arguments(files, mix):
    return [f"{files[size]}={weight}" for size, weight in MIXES[mix].items()]
