#!/usr/bin/python3
"""Sampled statistics against those of MeshLab, on pairs of the corpus, both directions.

usage: meshlab_test.py MESHGAUGE   (the corpus: environment variable MESHGAUGE_CORPUS)

MeshLab samples as well ("Hausdorff Distance", Monte Carlo on the faces), by other code and with other points. Both mean and
both RMS must agree within what sampling explains: 3.5 standard errors of the difference, for eight comparisons. Exits with 77,
which CTest reports as skipped, where there is no meshlabserver or no corpus.
"""
import gzip
import json
import math
import os
import pathlib
import re
import shutil
import struct
import subprocess
import sys
import tempfile

CORPUS = pathlib.Path(os.environ.get("MESHGAUGE_CORPUS", "../shared/corpus"))
PAIRS = (("armadillo.obj.gz", "armadillo_half.ply"), ("3holes.obj.gz", "3holes_voxel.obj.gz"))
SAMPLES = 1_000_000
MOST_ERRORS = 3.5
SCALE = 2.0 ** 16  # MeshLab prints six digits behind the point; a power of two changes no other digit
SKIPPED = 77

SCRIPT = """<!DOCTYPE FilterScript>
<FilterScript>
 <filter name="Hausdorff Distance">
  <Param type="RichMesh" name="SampledMesh" value="0"/>
  <Param type="RichMesh" name="TargetMesh" value="1"/>
  <Param type="RichBool" name="SaveSample" value="false"/>
  <Param type="RichBool" name="SampleVert" value="false"/>
  <Param type="RichBool" name="SampleEdge" value="false"/>
  <Param type="RichBool" name="SampleFauxEdge" value="false"/>
  <Param type="RichBool" name="SampleFace" value="true"/>
  <Param type="RichInt" name="SampleNum" value="{samples}"/>
  <Param type="RichAbsPerc" name="MaxDist" value="{reach}" min="0" max="{reach}"/>
 </filter>
</FilterScript>
"""


def read_obj(data):
    vertices, faces = [], []
    for line in data.decode().splitlines():
        kind, *words = line.split() or [""]
        if kind == "v":
            vertices.append(tuple(map(float, words[:3])))
        elif kind == "f":
            faces.append(tuple(int(word.partition("/")[0]) - 1 for word in words))
    return vertices, faces


def read_ply(data):
    """Binary, little-endian, float coordinates and triangles: what the corpus has."""
    head, _, body = data.partition(b"end_header\n")
    count = {name: int(number) for name, number in re.findall(rb"element (\w+) (\d+)", head)}
    vertices = list(struct.iter_unpack("<3f", body[:12 * count[b"vertex"]]))
    faces = [face[1:] for face in struct.iter_unpack("<B3i", body[12 * count[b"vertex"]:])]
    return vertices, faces


def read(path):
    data = path.read_bytes()
    if path.suffix == ".gz":
        data = gzip.decompress(data)
    return (read_ply if data.startswith(b"ply") else read_obj)(data)


def write_scaled(path, vertices, faces):
    """A PLY in MeshLab's own precision; MeshLab reads most OBJ files badly."""
    head = ("ply\nformat binary_little_endian 1.0\nelement vertex %d\nproperty float x\nproperty float y\nproperty float z\n"
            "element face %d\nproperty list uchar int vertex_indices\nend_header\n" % (len(vertices), len(faces)))
    path.write_bytes(head.encode() + b"".join(struct.pack("<3f", *(SCALE * x for x in v)) for v in vertices)
                     + b"".join(struct.pack("<B3i", 3, *face) for face in faces))


def meshlab(folder, a, b, reach):
    """Mean and RMS from a to b, and of how many samples."""
    (folder / "script.mlx").write_text(SCRIPT.format(samples=SAMPLES, reach=reach))
    command = ["meshlabserver", "-i", str(a), str(b), "-s", str(folder / "script.mlx")]
    if not os.environ.get("DISPLAY"):
        command = ["xvfb-run", "-a", *command]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=900)
    said = re.search(r"mean : ([0-9.]+)\s+RMS : ([0-9.]+)", done.stdout + done.stderr)
    taken = re.search(r"Sampled (\d+) pts", done.stdout + done.stderr)
    if not said or not taken:
        sys.exit("meshlabserver gave no distance:\n" + done.stdout + done.stderr)
    return float(said[1]) / SCALE, float(said[2]) / SCALE, int(taken[1])


def meshgauge(binary, a, b):
    command = [binary, "compare", str(a), str(b), "--json", "--statistics", "--samples", str(SAMPLES)]
    found = json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout)
    reach = max(mesh["diagonal"] for mesh in found["meshes"].values()) + found["distance"]["upper"]
    return found["statistics"], SCALE * reach


def spread(ours, mean, rms, samples):
    """Standard errors of MeshLab's mean and RMS, which MeshLab does not report. Its points are independent, so the mean's follows from
    the two; the RMS's needs the fourth moment, which our histogram gives."""
    bins = ours["histogram"]
    width = bins["high"] / len(bins["shares"])
    fourth = sum(share * ((i + 0.5) * width) ** 4 for i, share in enumerate(bins["shares"]))
    of_mean = math.sqrt(max(rms ** 2 - mean ** 2, 0) / samples)
    return of_mean, math.sqrt(max(fourth - rms ** 4, 0) / samples) / (2 * rms)


def check(name, ours, theirs):
    mean, rms, samples = theirs
    worst = 0
    for what, value, error in zip(("mean", "rms"), (mean, rms), spread(ours, mean, rms, samples)):
        mine = ours[what]
        off = abs(mine["value"] - value) / math.hypot(mine["standard_error"], error)
        worst = max(worst, off)
        print("| %s | %s | %.7g ± %.1g | %.7g ± %.1g | %.2f |"
              % (name, what, mine["value"], mine["standard_error"], value, error, off), flush=True)
    return worst


def main(binary):
    missing = [tool for tool in ("meshlabserver",) + (() if os.environ.get("DISPLAY") else ("xvfb-run",))
               if not shutil.which(tool)]
    if missing or not (CORPUS / "meshes").is_dir():
        print("SKIP: " + (" and ".join(missing) + " not found: packages meshlab, xvfb and xauth" if missing
                          else "no corpus: set MESHGAUGE_CORPUS"))
        return SKIPPED
    worst = 0
    print("| from, to | estimate | meshgauge | MeshLab | standard errors apart |\n|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        for names in PAIRS:
            paths = [CORPUS / "meshes" / name for name in names]
            plain = [folder / (name.partition(".")[0] + ".ply") for name in names]
            for path, copy in zip(paths, plain):
                write_scaled(copy, *read(path))
            found, reach = meshgauge(binary, *paths)
            worst = max(worst, check("%s, %s" % names, found["a_to_b"], meshlab(folder, *plain, reach)),
                        check("%s, %s" % names[::-1], found["b_to_a"], meshlab(folder, *plain[::-1], reach)))
    if worst > MOST_ERRORS:
        print("FAIL: %.2f standard errors apart, more than %.1f" % (worst, MOST_ERRORS), file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1] if len(sys.argv) > 1 else "build/meshgauge"))
