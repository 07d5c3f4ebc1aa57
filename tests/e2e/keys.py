"""Bearer keys for a test, as `meshgauge keys new` makes them."""

import json
import subprocess
import tempfile
import unittest
from pathlib import Path

from harness import BINARY, Server


def new_key(name, *flags, **changes):
    """A token, and its entry for the file."""
    out = subprocess.run([BINARY, "keys", "new", name, *flags], capture_output=True, text=True, check=True).stdout
    token, entry = out.splitlines()
    return token, {**json.loads(entry), **changes}


def write_keys(path, *entries):
    path.write_text(json.dumps({"keys": entries}))


def bearer(token):
    return "Authorization: Bearer %s\r\n" % token


class TwoKeys(unittest.TestCase):
    """A service with two keys, one of them with small limits."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.mine, first = new_key("mine", max_storage_bytes=1_000_000, max_jobs=1)
        self.theirs, second = new_key("theirs")
        write_keys(Path(folder.name) / "keys.json", first, second)
        self.server = Server("--keys-file", folder.name + "/keys.json", "--workers", "2")
        self.addCleanup(self.server.stop)

    def send(self, token, method, path, body=b"", extra=""):
        return self.server.send(method, path, body, extra + bearer(token))
