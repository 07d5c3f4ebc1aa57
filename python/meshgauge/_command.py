"""The program that the package carries."""

from __future__ import annotations

import os
import pathlib
import sys
from typing import NoReturn

PROGRAM = pathlib.Path(__file__).with_name("bin") / "meshgauge"


def main() -> NoReturn:
    """The command `meshgauge`: becomes the program."""
    os.execv(PROGRAM, ["meshgauge", *sys.argv[1:]])
