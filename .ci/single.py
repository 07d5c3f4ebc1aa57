#!/usr/bin/python3
"""Whether a file compiles by itself, by its command in build-single/: .ci/single.py FILE"""
import json
import pathlib
import shlex
import subprocess
import sys

file = pathlib.Path(sys.argv[1]).resolve()
for command in json.loads(pathlib.Path("build-single/compile_commands.json").read_text()):
    if command["file"] == str(file):
        words = shlex.split(command["command"])
        sys.exit(subprocess.run([*words[: words.index("-o")], "-fsyntax-only", str(file)], cwd=command["directory"], check=False).returncode)
