#!/usr/bin/env python3
"""The shapes of the loops of docs/mcp.md, as the programs there would write them: shapes.py FOLDER

A reference of each part, its first version with a mistake (PART_1.stl) and its second without (PART_2.stl), whose triangles are
others than those of the reference.
"""

import math
import pathlib
import sys


def stl(triangles):
    lines = ["solid shape"]
    for triangle in triangles:
        lines += ["facet normal 0 0 0", "outer loop", *("vertex %r %r %r" % tuple(map(float, p)) for p in triangle), "endloop", "endfacet"]
    return "\n".join([*lines, "endsolid shape", ""])


def quad(a, b, c, d, turned=False):
    """Two triangles, split along either diagonal."""
    return [(b, c, d), (b, d, a)] if turned else [(a, b, c), (a, c, d)]


def bracket(thickness, turned=False):
    """An L of 40 x 30, its sides `thickness` and 5 thick, extruded along y by 20. Its outline runs clockwise as seen from -y."""
    t = thickness
    outline = [(0, 0), (40, 0), (40, t), (5, t), (5, 30), (0, 30)]
    near, far = ([(x, y, z) for x, z in outline] for y in (0, 20))
    triangles = []
    for i in range(6):
        j = (i + 1) % 6
        triangles += quad(near[i], near[j], far[j], far[i], turned)
    parts = [(0, 1, 2, 3), (0, 3, 4, 5)]
    for part in parts:
        triangles += quad(*(near[i] for i in reversed(part)), turned)
        triangles += quad(*(far[i] for i in part), turned)
    return [(a, c, b) for a, b, c in triangles]


def shaft(shoulder, sides=96, turned=False):
    """A shaft along z of radius 10 up to the shoulder, then of radius 6 up to 50."""
    profile = [(0, 0), (10, 0), (10, shoulder), (6, shoulder), (6, 50), (0, 50)]
    rings = [[(r * math.cos(2 * math.pi * i / sides), r * math.sin(2 * math.pi * i / sides), z) for i in range(sides)] for r, z in profile]
    triangles = []
    for low, high in zip(rings, rings[1:]):
        for i in range(sides):
            j = (i + 1) % sides
            triangles += quad(low[i], low[j], high[j], high[i], turned)
    return [triangle for triangle in triangles if len(set(triangle)) == 3]


def tray(floor, turned=False):
    """A box of 30 x 20 x 10 with a pocket from above, whose walls are 2 thick."""
    def loop(inset, z):
        return [(inset, inset, z), (30 - inset, inset, z), (30 - inset, 20 - inset, z), (inset, 20 - inset, z)]

    loops = [loop(0, 0), loop(0, 10), loop(2, 10), loop(2, floor)]
    triangles = quad(*reversed(loops[0]), turned) + quad(*loops[3], turned)
    for low, high in zip(loops, loops[1:]):
        for i in range(4):
            j = (i + 1) % 4
            triangles += quad(low[i], low[j], high[j], high[i], turned)
    return triangles


SHAPES = {"bracket": (bracket(5), bracket(4), bracket(5, True)), "shaft": (shaft(20), shaft(18), shaft(20, turned=True)),
          "tray": (tray(2), tray(1), tray(2, True))}


def write(folder):
    folder.mkdir(parents=True, exist_ok=True)
    for name, versions in SHAPES.items():
        for suffix, triangles in zip(("_reference", "_1", "_2"), versions):
            (folder / f"{name}{suffix}.stl").write_text(stl(triangles))


if __name__ == "__main__":
    write(pathlib.Path(sys.argv[1]))
