#!/usr/bin/env bash
# Makes the wheel: python/build.sh FOLDER LIBRARY
#
# FOLDER: where meshgauge-VERSION-py3-none-PLATFORM.whl goes. LIBRARY: python/meshgauge/libmeshgauge.so in a build folder, of
# the target meshgauge_python. The platform follows from it: manylinux with the newest version of glibc that it needs, or
# this machine's alone if it needs other shared libraries. The files licenses.txt and sbom.cdx.json beside it go into the wheel. Needs
# the Debian packages binutils and python3-wheel. The same input gives the same bytes, with SOURCE_DATE_EPOCH as the time of the files.
set -euo pipefail
here=$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")
(($# == 2)) || { echo "usage: python/build.sh FOLDER LIBRARY" >&2; exit 2; }
# Debian's own comes first: it sees the package python3-wheel.
python=/usr/bin/python3
[[ -x $python ]] || python=python3
exec "$python" "$here/wheel.py" "$1" "$2"
