#!/usr/bin/env python3
"""Writes what the program contains: BUILD/sbom.cdx.json (CycloneDX 1.5) and BUILD/licenses.txt, the texts of all licences. The same
of the wheel's library is beside it, in BUILD/python/meshgauge.

  sbom.py BUILD

Nothing is listed by hand. The linker's maps name the static libraries of which the program has a part, Ninja the headers that it
was compiled from, server/web's bundle the packages of its scripts. dpkg names the Debian package of each file.
"""

import gzip
import hashlib
import json
import os
import pathlib
import re
import subprocess
import sys
import time
import uuid
from dataclasses import dataclass

ROOT = pathlib.Path(__file__).resolve().parent.parent
# Headers of the compiler, of its library and of the kernel leave nothing in the program that the libraries do not account for.
TOOLCHAIN = re.compile(r"libc6-dev|linux-libc-dev|libgcc-\d+-dev|libstdc\+\+-\d+-dev")


def output(*command):
    return subprocess.run(command, check=True, text=True, stdout=subprocess.PIPE).stdout


@dataclass
class Product:
    folder: str  # where its files go, below the build
    name: str    # in sentences
    targets: tuple[str, ...]  # it, and what is within it
    has_page: bool


PRODUCTS = (Product(".", "program", ("meshgauge", "meshgauge_reader"), True),
            Product("python/meshgauge", "library", ("meshgauge_python",), False))


def linked(build, product):
    """The paths of the archives that gave the product an object."""
    archives = set()
    for name in product.targets:
        beginning = (build / f"{name}.map").read_text().split("\n\n")[1]
        archives |= set(re.findall(r"^(\S+\.a)\(", beginning, re.M))
    return {(build / archive).resolve() for archive in archives}


def headers(build, product):
    """The paths of the system's headers that the product was compiled from."""
    objects = [line for line in output("ninja", "-C", build, "-t", "inputs", *product.targets).splitlines() if line.endswith(".o")]
    return {pathlib.Path(line.strip()).resolve() for line in output("ninja", "-C", build, "-t", "deps", *objects).splitlines()
            if line.startswith("    /usr/include/")}


def packages(files):
    """The Debian packages of these files."""
    found = output("dpkg-query", "-S", *sorted(map(str, files)))
    return {line.split(":")[0] for line in found.splitlines()}


def field(package, name):
    return output("dpkg-query", "-W", "-f", f"${{{name}}}", package).strip()


def component(name, version, kind, purl, **more):
    return {"type": kind, "bom-ref": purl, "name": name, "version": version, "purl": purl, **more}


def debian(source, version, binary=None):
    purl = f"pkg:deb/debian/{source}@{version.replace('+', '%2B').replace(':', '%3A')}?arch=source&distro=debian-12"
    return component(source, version, "library", purl, **({"description": f"from {binary}"} if binary else {}))


def of_debian(build, product):
    """Component and text of the licence of each Debian source that the product has a part of."""
    archives = {file for file in linked(build, product) if not file.is_relative_to(build)}
    names = packages(archives) | {name for name in packages(headers(build, product)) if not TOOLCHAIN.fullmatch(name)}
    for name in sorted(names):
        copyright_of = pathlib.Path(f"/usr/share/doc/{name}/copyright")
        yield debian(field(name, "source:Package"), field(name, "source:Version"), name), copyright_of.read_text(errors="replace")


def of_sources(build, product):
    """The same of those that packaging/static_libraries has compiled."""
    parts = {file.name for file in linked(build, product)}
    for line in (build / "static/versions").read_text().splitlines():
        archive, source, version = line.split()
        if archive in parts:
            text = (build / "static/src" / source / "debian/copyright").read_text(errors="replace")
            yield debian(source, version), text


def of_page(build):
    """The same of the page's scripts: those of page/, whose texts are in the bundle, and swagger-ui."""
    given = re.search(r"^MESHGAUGE_WEB_BUNDLE:PATH=(.+)$", (build / "CMakeCache.txt").read_text(), re.M)
    bundle = pathlib.Path(given[1]) if given else build / "server/web/bundle"
    if not bundle.exists():
        return
    text = gzip.decompress((bundle / "page/licenses.txt.gz").read_bytes()).decode()
    for name, version in re.findall(r"^((?:@[\w.-]+/)?[\w.-]+) (\d+\.\d+\.\d+\S*)\n\n", text, re.M):
        yield npm(name, version), text
    lock = json.loads((ROOT / "server/web/package-lock.json").read_text())
    texts = [gzip.decompress(file.read_bytes()).decode() for file in sorted((bundle / "docs").iterdir()) if re.search("LICENSE|NOTICE", file.name)]
    yield npm("swagger-ui-dist", lock["packages"]["node_modules/swagger-ui-dist"]["version"]), "\n\n".join(texts)


def npm(name, version):
    return component(name, version, "library", f"pkg:npm/{name.replace('@', '%40')}@{version}")


def project():
    version = re.search(r"project\(meshgauge VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text())[1]
    name = (ROOT / "packaging/repository").read_text().strip()
    return component("meshgauge", version, "application", f"pkg:github/{name.lower()}@v{version}", licenses=[{"license": {"id": "MIT"}}])


def describe(build, product):
    found = [*of_debian(build, product), *of_sources(build, product), *(of_page(build) if product.has_page else [])]
    texts = {}
    components = {}
    for one, text in found:
        # One component a source: several of its packages may be linked.
        components.setdefault(one["purl"], one)
        texts.setdefault(text, []).append(f"{one['name']} {one['version']}")
    listed = sorted(components.values(), key=lambda one: one["purl"])
    digest = hashlib.sha256(json.dumps(listed).encode()).hexdigest()
    when = time.gmtime(int(os.environ["SOURCE_DATE_EPOCH"]))
    document = {"$schema": "http://cyclonedx.org/schema/bom-1.5.schema.json", "bomFormat": "CycloneDX", "specVersion": "1.5",
                "serialNumber": f"urn:uuid:{uuid.uuid5(uuid.NAMESPACE_OID, digest)}", "version": 1,
                "metadata": {"timestamp": time.strftime("%Y-%m-%dT%H:%M:%SZ", when), "component": project()},
                "components": listed}
    folder = build / product.folder
    (folder / "sbom.cdx.json").write_text(json.dumps(document, indent=1) + "\n")
    with (folder / "licenses.txt").open("w") as file:
        file.write(f"meshgauge is under the MIT licence, see LICENSE. Its {product.name} contains the following parts, under the licences below.\n")
        for text, names in texts.items():
            file.write(f"\n{'=' * 100}\n{', '.join(sorted(set(names)))}\n{'=' * 100}\n\n{text.strip()}\n")


if __name__ == "__main__":
    for each in PRODUCTS:
        describe(pathlib.Path(sys.argv[1]).resolve(), each)
