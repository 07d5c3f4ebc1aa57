# What the scripts of packaging/ share; sourced at the root of the project.
# shellcheck shell=bash disable=SC2034  # the scripts that source this use its variables
version=$(sed -nE 's/^project\(meshgauge VERSION (\S+).*/\1/p' CMakeLists.txt)
packages=build/packages

# The same bytes of the same sources: every time in a package is that of the last commit, and modes are not the caller's.
umask 022
: "${SOURCE_DATE_EPOCH:=$(git log -1 --format=%ct 2>/dev/null || stat -c %Y CHANGELOG.md)}"
export SOURCE_DATE_EPOCH TZ=UTC LC_ALL=C.UTF-8

# Prints the folder's files, of root, as a tar archive.
tar_of() {  # FOLDER NAMES...
  tar --sort=name --mtime="@$SOURCE_DATE_EPOCH" --format=gnu --owner=0 --group=0 --numeric-owner --mode=go=rX,u+rw,a-s -C "$1" -c "${@:2}"
}
