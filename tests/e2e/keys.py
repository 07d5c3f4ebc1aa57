"""Bearer keys for a test, as `meshgauge keys new` makes them."""

import json
import subprocess

from harness import BINARY


def new_key(name, *flags, **changes):
    """A token, and its entry for the file."""
    out = subprocess.run([BINARY, "keys", "new", name, *flags], capture_output=True, text=True, check=True).stdout
    token, entry = out.splitlines()
    return token, {**json.loads(entry), **changes}


def write_keys(path, *entries):
    path.write_text(json.dumps({"keys": entries}))


def bearer(token):
    return "Authorization: Bearer %s\r\n" % token
