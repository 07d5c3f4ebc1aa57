"""Makes the wheel, for build.sh: lays out its files and packs them by `python3 -m wheel pack`."""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent
# Libraries of every Linux with glibc (PEP 600).
EVERYWHERE = re.compile(r"lib(c|m|dl|rt|pthread|gcc_s)\.so\.\d+|ld-linux.*\.so\.\d+")
OLDEST = 17  # of glibc 2: there is no platform manylinux for an older one
FIRST_TIME = "315532800"  # 1980: a zip archive has no earlier time

METADATA = """\
Metadata-Version: 2.1
Name: meshgauge
Version: {version}
Summary: Certified Hausdorff distance between triangle meshes
License: MIT
Requires-Python: >=3.9
Provides-Extra: numpy
Requires-Dist: numpy; extra == 'numpy'
Classifier: Operating System :: POSIX :: Linux
Classifier: Programming Language :: Python :: 3
Classifier: Framework :: Pytest
Classifier: Typing :: Typed
Description-Content-Type: text/markdown

"""
WHEEL = """\
Wheel-Version: 1.0
Generator: meshgauge
Root-Is-Purelib: false
Tag: py3-none-{platform}
"""
ENTRY_POINTS = """\
[console_scripts]
meshgauge = meshgauge._command:main

[pytest11]
meshgauge = meshgauge.pytest_plugin
"""


def read_elf(flags, file):
    return subprocess.run(["readelf", "-W", flags, file], check=True, capture_output=True, text=True,
                          env={**os.environ, "LC_ALL": "C"}).stdout


def machine_of(file):
    found = re.search(r"Machine:\s+(.*)", read_elf("-h", file))[1]
    return {"Advanced Micro Devices X86-64": "x86_64", "AArch64": "aarch64"}[found]


def platform_of(library):
    """The platform tag of a wheel with this library."""
    machine = machine_of(library)
    needed = re.findall(r"\(NEEDED\).*\[(.*)\]", read_elf("-d", library))
    others = sorted(name for name in needed if not EVERYWHERE.fullmatch(name))
    if others:
        print(f"build.sh: a wheel for this machine's libraries alone; needed are {', '.join(others)}", file=sys.stderr)
        return "linux_" + machine
    versions = [int(minor) for minor in re.findall(r"Name: GLIBC_2\.(\d+)", read_elf("-V", library))]
    return f"manylinux_2_{max([OLDEST, *versions])}_{machine}"


def version():
    return re.search(r"project\(meshgauge VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text())[1]


def put(place, content, mode=0o644):
    place.parent.mkdir(parents=True, exist_ok=True)
    if isinstance(content, pathlib.Path):
        shutil.copyfile(content, place)
    else:
        place.write_text(content)
    place.chmod(mode)


def lay_out(folder, library):
    package, info = folder / "meshgauge", folder / f"meshgauge-{version()}.dist-info"
    for module in [*(HERE / "meshgauge").glob("*.py"), HERE / "meshgauge/py.typed"]:
        put(package / module.name, module)
    put(package / "gates.schema.json", ROOT / "check/gates.schema.json")
    put(package / "libmeshgauge.so", library, 0o755)
    put(info / "METADATA", METADATA.format(version=version()) + (HERE / "README.md").read_text())
    put(info / "WHEEL", WHEEL.format(platform=platform_of(library)))
    put(info / "entry_points.txt", ENTRY_POINTS)
    put(info / "LICENSE", ROOT / "LICENSE")
    # What packaging/sbom.py has written beside the library of a static build. PEP 770 names the place of SBOMs.
    for place, name in (("licenses.txt", "licenses.txt"), ("sboms/meshgauge.cdx.json", "sbom.cdx.json")):
        if (library.parent / name).exists():
            put(info / place, library.parent / name)


def main(out, library):
    with tempfile.TemporaryDirectory() as folder:
        lay_out(pathlib.Path(folder), pathlib.Path(library))
        pathlib.Path(out).mkdir(parents=True, exist_ok=True)
        environment = {"SOURCE_DATE_EPOCH": FIRST_TIME, **os.environ}
        subprocess.run([sys.executable, "-m", "wheel", "pack", "--dest-dir", out, folder], check=True, env=environment)


if __name__ == "__main__":
    main(*sys.argv[1:])
