"""The command `meshgauge`: the program's command line, without the subcommands of the service."""

from __future__ import annotations

import signal
import sys
from typing import NoReturn

from meshgauge import _native


def main() -> NoReturn:
    for sign in (signal.SIGINT, signal.SIGPIPE):  # as in a program: Python's own ways with them end here
        signal.signal(sign, signal.SIG_DFL)
    sys.exit(_native.run_command(["meshgauge", *sys.argv[1:]]))
