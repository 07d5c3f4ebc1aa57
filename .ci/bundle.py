#!/usr/bin/env python3
"""Writes config.json of an OCI bundle: an image as docker/compose.yaml runs it, for crun.

  bundle.py ROOT DATA SAMPLES TOOLS NAME=VALUE... [-- ARGUMENT...] <of-buildah-inspect >config.json

Program, folder, variables, arguments, unless there are others, and user, unless RUN_AS names another, are the image's own. The root is
read-only, nothing but /tmp and the volume can be written, all capabilities are dropped. The network is the machine's, so that it can be
reached.
"""

import json
import os
import sys


def mount(target, kind, source, *options):
    return {"destination": target, "type": kind, "source": source, "options": list(options)}


def bundle(image, arguments, root, data, samples, tools, *variables):
    user, group = map(int, (os.environ.get("RUN_AS") or image.get("User") or "0:0").split(":"))
    volumes = list(image.get("Volumes") or ())
    no_rights = ["nosuid", "noexec", "nodev"]
    return {
        "ociVersion": "1.0.0",
        "process": {
            "user": {"uid": user, "gid": group},
            "args": image["Entrypoint"] + (arguments or image["Cmd"]),
            "env": [*image["Env"], *variables],
            "cwd": image["WorkingDir"],
            "capabilities": {which: [] for which in ("bounding", "effective", "inheritable", "permitted", "ambient")},
            "noNewPrivileges": True,
        },
        "root": {"path": root, "readonly": True},
        "mounts": [
            mount("/proc", "proc", "proc", *no_rights),
            mount("/dev", "tmpfs", "tmpfs", "nosuid", "mode=755", "size=64k"),
            mount("/tmp", "tmpfs", "tmpfs", *no_rights, "mode=1777", "size=1g"),
            *[mount(volume, "bind", data, "rbind", "rw") for volume in volumes],
            mount("/samples", "bind", samples, "rbind", "ro"),
            mount("/tools", "bind", tools, "rbind", "ro"),
        ],
        "linux": {"namespaces": [{"type": kind} for kind in ("pid", "mount", "ipc", "uts")]},
    }


if __name__ == "__main__":
    image = json.load(sys.stdin)["OCIv1"]["config"]
    own = sys.argv.index("--") if "--" in sys.argv else len(sys.argv)
    json.dump(bundle(image, sys.argv[own + 1:], *sys.argv[1:own]), sys.stdout, indent=1)
