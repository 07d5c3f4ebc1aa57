#!/usr/bin/env bash
# Makes the wheel: python/build.sh FOLDER PROGRAM [LIBRARY]
#
# FOLDER: where meshgauge-VERSION-py3-none-PLATFORM.whl goes. PROGRAM: the program meshgauge that it carries. LIBRARY: the
# engine, libmeshgauge.so of the target meshgauge_python; that of build/ by default. The platform follows from the two
# files: manylinux with the newest version of glibc that they need, or this machine's alone if they need other shared
# libraries. Needs the Debian packages binutils and python3-wheel. The same input gives the same bytes, with
# SOURCE_DATE_EPOCH as the time of the files.
set -euo pipefail
here=$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")
(($# == 2 || $# == 3)) || { echo "usage: python/build.sh FOLDER PROGRAM [LIBRARY]" >&2; exit 2; }
# Debian's own comes first: it sees the package python3-wheel.
python=/usr/bin/python3
[[ -x $python ]] || python=python3
exec "$python" "$here/wheel.py" "$1" "$2" "${3:-$here/../build/python/meshgauge/libmeshgauge.so}"
