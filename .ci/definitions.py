#!/usr/bin/env python3
"""Names each class of the product that two files define under one name: the linker merges what templates make of both."""
import collections
import re
import subprocess
import sys

files = subprocess.run(["git", "ls-files", "--cached", "--others", "--exclude-standard", "*.h", "*.cpp"], capture_output=True, text=True,
                       check=True).stdout.split()
BEGIN = re.compile(r"namespace(?: ([\w:]+))? \{$")
END = re.compile(r"\}  // (?:anonymous )?namespace")
CLASS = re.compile(r"(?:template <.*> )?(?:struct|class|union|enum class|enum)(?: alignas\([^)]*\)| \[\[\w+\]\])* (\w+)(?: final)?(?: :[^:].*)? ?\{")

places = collections.defaultdict(set)
for file in files:
    if file.startswith("tests/"):
        continue
    namespaces = []
    try:
        lines = open(file, encoding="utf-8").read().splitlines()
    except FileNotFoundError:  # deleted, and not yet committed
        continue
    for line in lines:
        if begin := BEGIN.match(line):
            namespaces.append(begin[1])
        elif END.match(line):
            namespaces.pop()
        elif (found := CLASS.match(line)) and None not in namespaces:
            places["::".join([*namespaces, found[1]])].add(file)

twice = [f"{name} is defined in {' and '.join(sorted(of))}" for name, of in sorted(places.items()) if len(of) > 1]
print("\n".join(twice), file=sys.stderr, end="\n" if twice else "")
sys.exit(bool(twice))
