"""What the Python package costs: python3 tests/python/cost.py [triangles]

Prints how long `import meshgauge` takes beside numpy, and what compare() of two meshes in arrays takes more than the
engine alone: the stages that the program reports as the engine's. The pairs are two meshes with triangles of their own, and a
mesh with a copy whose vertices are moved, which the engine measures by the faces that both have. PYTHONPATH is the build's python/.
"""

import statistics
import subprocess
import sys
import time

import numpy

import meshgauge
import shapes

ENGINE = ("build", "traverse", "reduce", "certify")


def import_ms(module):
    program = f"import numpy, time; t = time.perf_counter(); import {module}; print((time.perf_counter() - t) * 1e3)"
    return statistics.median(float(subprocess.run([sys.executable, "-c", program], capture_output=True, check=True).stdout)
                             for _ in range(9))


def cost(a, b, kind, threads):
    """Of five calls the one with the median share: what it takes more than the engine, its time and the engine's in ms."""
    shares = []
    for _ in range(5):
        pair = [(vertices, faces.astype(kind)) for vertices, faces in (a, b)]
        start = time.perf_counter()
        result = meshgauge.compare(*pair, threads=threads)
        wall_ms = (time.perf_counter() - start) * 1e3
        engine_ms = sum(result.timings[stage] for stage in ENGINE)
        shares.append((wall_ms / engine_ms - 1, wall_ms, engine_ms))
    return sorted(shares)[len(shares) // 2]


def main(triangles):
    print(f"import: {import_ms('meshgauge'):.1f} ms")
    n = round((triangles / 2) ** 0.5)
    a = shapes.grid(n, 0.1)
    for title, b in (("another mesh", shapes.grid(n + 1, 0.101)), ("a moved copy", shapes.grid(n, 0.101))):
        for kind, threads in ((numpy.uint32, 1), (numpy.int64, 1), (numpy.uint32, None)):
            share, wall_ms, engine_ms = cost(a, b, kind, threads)
            print(f"compare with {title}, {len(a[1])} triangles, faces of {kind.__name__}, threads={threads}: {wall_ms:.0f} ms, "
                  f"engine {engine_ms:.0f} ms, {100 * share:.1f} % more")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 1_000_000)
