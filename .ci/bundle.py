#!/usr/bin/env python3
"""Writes config.json of an OCI bundle: an image as docker/compose.yaml runs it, for crun.

  bundle.py ROOT INSPECTED DATA SAMPLES NAME=VALUE... <of-buildah-inspect >config.json

User, folder, variables and entry point are the image's own. The root is read-only, nothing but /tmp and the volume can be
written, all capabilities are dropped. The network is the machine's, so that it can be reached.
"""

import json
import sys


def mount(target, kind, source, *options):
    return {"destination": target, "type": kind, "source": source, "options": list(options)}


def bundle(image, root, data, samples, extra):
    user, group = map(int, image["User"].split(":"))
    (volume,) = image["Volumes"]
    no_rights = ["nosuid", "noexec", "nodev"]
    return {
        "ociVersion": "1.0.0",
        "process": {
            "user": {"uid": user, "gid": group},
            "args": image["Entrypoint"],
            "env": image["Env"] + extra,
            "cwd": image["WorkingDir"],
            "capabilities": {which: [] for which in ("bounding", "effective", "inheritable", "permitted", "ambient")},
            "noNewPrivileges": True,
        },
        "root": {"path": root, "readonly": True},
        "mounts": [
            mount("/proc", "proc", "proc", *no_rights),
            mount("/dev", "tmpfs", "tmpfs", "nosuid", "mode=755", "size=64k"),
            mount("/tmp", "tmpfs", "tmpfs", *no_rights, "mode=1777", "size=1g"),
            mount(volume, "bind", data, "rbind", "rw"),
            mount("/samples", "bind", samples, "rbind", "ro"),
        ],
        "linux": {"namespaces": [{"type": kind} for kind in ("pid", "mount", "ipc", "uts")]},
    }


if __name__ == "__main__":
    image = json.load(sys.stdin)["OCIv1"]["config"]
    json.dump(bundle(image, *sys.argv[1:4], sys.argv[4:]), sys.stdout, indent=1)
