"""Schemas and programs that come by npm, in the versions of a package-lock.json."""

import fcntl
import hashlib
import pathlib
import shutil
import subprocess

HERE = pathlib.Path(__file__).resolve().parent
FILES = ("package.json", "package-lock.json", ".npmrc")


def installed(folder, source=HERE):
    """The node_modules of `folder`, filled when the versions in `source` changed; None without npm. Others may ask at the
    same time."""
    if not shutil.which("npm"):
        return None
    folder = pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    wanted = hashlib.sha256(b"".join((source / name).read_bytes() for name in FILES)).hexdigest()
    stamp = folder / "installed"
    with open(folder / "lock", "w", encoding="utf-8") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not stamp.exists() or stamp.read_text() != wanted:
            for name in FILES:
                shutil.copy(source / name, folder)
            subprocess.run(["npm", "ci", "--loglevel=error"], cwd=folder, check=True)
            stamp.write_text(wanted)
    return folder / "node_modules"
