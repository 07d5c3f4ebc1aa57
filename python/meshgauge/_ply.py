"""Writes meshes as binary PLY, with exactly the given coordinates."""

from __future__ import annotations

from typing import Any


def of_triangles(vertices: Any, triangles: Any) -> bytes:
    """`vertices`: (n, 3) of float64; `triangles`: (m, 3) of uint32."""
    import numpy

    faces = numpy.empty((len(triangles), 4), "<u4")
    faces[:, 0] = 3
    faces[:, 1:] = triangles
    return of_polygons(vertices, faces, len(triangles))


def of_polygons(vertices: Any, packed: Any, count: int) -> bytes:
    """`packed`: the number of corners and the corners of each of `count` faces."""
    header = (f"ply\nformat binary_little_endian 1.0\nelement vertex {len(vertices)}\n"
              "property double x\nproperty double y\nproperty double z\n"
              f"element face {count}\nproperty list uint uint vertex_indices\nend_header\n")
    return header.encode() + vertices.astype("<f8").tobytes() + packed.astype("<u4").tobytes()
