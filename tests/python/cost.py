"""What the Python package costs: python3 tests/python/cost.py [triangles]

Prints how long `import meshgauge` takes beside numpy, and what compare() of two meshes in arrays takes more than the
engine alone: the stages that the program reports as the engine's. PYTHONPATH is the build's python/.
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


def main(triangles):
    print(f"import: {import_ms('meshgauge'):.1f} ms")
    n = round((triangles / 2) ** 0.5)
    a, b = shapes.grid(n, 0.1), shapes.grid(n, 0.101)
    for name, kind, threads in (("uint32", numpy.uint32, 1), ("int64", numpy.int64, 1), ("uint32", numpy.uint32, None)):
        shares = []
        for _ in range(5):
            pair = [(vertices, faces.astype(kind)) for vertices, faces in (a, b)]
            start = time.perf_counter()
            result = meshgauge.compare(*pair, threads=threads)
            wall_ms = (time.perf_counter() - start) * 1e3
            engine_ms = sum(result.timings[stage] for stage in ENGINE)
            shares.append((wall_ms / engine_ms - 1, wall_ms, engine_ms))
        share, wall_ms, engine_ms = sorted(shares)[len(shares) // 2]
        print(f"compare, {len(a[1])} triangles each, faces of {name}, threads={threads}: {wall_ms:.0f} ms, engine {engine_ms:.0f} ms, "
              f"{100 * share:.1f} % more")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 1_000_000)
