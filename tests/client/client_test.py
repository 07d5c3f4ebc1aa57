#!/usr/bin/env python3
"""Generates a client's types from openapi.yaml, checks a client that uses them, and runs it: client_test.py BINARY FOLDER

FOLDER is written to. The programs are those of `npm ci` in this folder.
"""

import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]


def run(*command, **more):
    print("+", *command, flush=True)
    subprocess.run(command, check=True, **more)


def build(folder):
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    for name in ("compare.ts", "tsconfig.json", "package.json"):
        shutil.copy(HERE / name, folder)
    (folder / "node_modules").symlink_to(HERE / "node_modules")
    tools = HERE / "node_modules" / ".bin"
    # A member with a default need not be sent.
    run(tools / "openapi-typescript", ROOT / "openapi.yaml", "--default-non-nullable=false", "-o", folder / "api.d.ts")
    run(tools / "tsc", "--project", folder)


def serve_and_run(binary, folder):
    environment = {name: value for name, value in os.environ.items() if not name.startswith("MESHGAUGE_")}
    with tempfile.TemporaryDirectory() as data:
        service = subprocess.Popen([binary, "serve", "--port", "0", "--log-requests", "none", "--data-dir", data],
                                   stderr=subprocess.PIPE, env=environment)
        try:
            address = json.loads(service.stderr.readline())["detail"]
            run("node", folder / "compare.js", "http://" + address)
        finally:
            service.terminate()
            service.communicate()
    if service.returncode != 0:
        sys.exit("the service ended with %d" % service.returncode)


if __name__ == "__main__":
    build(Path(sys.argv[2]))
    serve_and_run(sys.argv[1], Path(sys.argv[2]))
