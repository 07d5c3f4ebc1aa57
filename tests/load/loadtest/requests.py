"""The requests that are sent: whole HTTP requests in files, made of meshes that the project makes itself."""
import json

from harness import meshes

BOUNDARY = "meshgauge-load-boundary"
SIZES = {"small": 1000, "medium": 50_000}  # triangles of each mesh
# Nine small ones for each medium one.
MIXES = {"small": {"small": 1}, "medium": {"medium": 1}, "mixed": {"small": 9, "medium": 1}}


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


def whole(body, key=None):
    """The request as it goes over the wire."""
    lines = [
        "POST /v1/comparisons HTTP/1.1",
        "Host: 127.0.0.1",
        f"Content-Type: multipart/form-data; boundary={BOUNDARY}",
        f"Content-Length: {len(body)}",
        *([f"Authorization: Bearer {key}"] if key else []),
    ]
    return "\r\n".join(lines).encode() + b"\r\n\r\n" + body


def make(folder, key=None, options=None):
    """{size: file}. Binary STL, as such files mostly are."""
    folder.mkdir(parents=True, exist_ok=True)
    files = {}
    for size, triangles in SIZES.items():
        parts = [(name, f"{name}.stl", meshes.WRITERS[".stl"](*mesh)) for name, mesh in zip("ab", pair(triangles))]
        parts.append(("options", "options.json", json.dumps(options or {}).encode()))
        files[size] = folder / f"{size}.http"
        files[size].write_bytes(whole(multipart(parts), key))
    return files


def arguments(files, mix):
    return [f"{files[size]}={weight}" for size, weight in MIXES[mix].items()]
