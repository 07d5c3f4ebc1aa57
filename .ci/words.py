#!/usr/bin/env python3
"""Words and lines that this project's text does without: .ci/words.py [file ...], all files by default.

In comments and strings of C++ and TypeScript, and in scripts and their names: code is not a person, so no "who" or
"nobody"; a comment above a C++ declaration begins with what it is about, not with "Of" or a pronoun. In README.md and
docs/: lines of prose of at most 100 characters; tables, pictures and blocks of code do not count, nor a word that is
longer by itself.
"""

import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]
# Part of a name, as in test_nobody_waits, counts as well.
PERSONS = re.compile(r"(?<![a-z])(who|whoever|whom|whomever|nobody|somebody|one had better|(?<!other )one's|his)(?![a-z])", re.I)
BEGINNING = re.compile(r"(Of|It|Its|They|Their|Them|He|She|Whose)\b")
MAX_PROSE = 100
# (file, a part of the line): right as it is.
ALLOWED = [("tests/server/store/postgres_server.cpp", 'getpwnam("nobody")'), ("tests/cluster/scratch.py", "'nobody'"),
           ("tests/cluster/scratch.py", '"nobody"'), ("tests/e2e/test_sandbox.py", "as the user nobody")]
SOURCES = ("*.h", "*.cpp", "*.ts")
SCRIPTS = ("*.py", "*.mjs", "*.sh", "*.yaml", "*.yml", "*.tpl", "CMakeLists.txt", "*.cmake", "dev")
PROSE = ("README.md", "docs/*.md")

# A raw string, a string, a character, a comment of a line, a comment of lines; of TypeScript also a template.
TOKEN = re.compile(r'R"(?P<tag>[^\s()\\]{0,16})\((?P<raw>.*?)\)(?P=tag)"|"(?P<text>(?:[^"\\\n]|\\.)*)"|(?<![\w])\'(?P<char>(?:[^\'\\\n]|\\.)*)\''
                   r"|//(?P<line>[^\n]*)|/\*(?P<lines>.*?)\*/|`(?P<template>(?:[^`\\]|\\.)*)`", re.S)


def pieces(text):
    """(line number, kind, text) of every comment and string."""
    for found in TOKEN.finditer(text):
        kind = found.lastgroup
        yield text.count("\n", 0, found.start(kind)) + 1, kind, found[kind]


def in_source(name, text):
    rows = text.split("\n")
    for number, kind, piece in pieces(text):
        if kind == "text" and rows[number - 1].lstrip().startswith("#include"):
            continue
        for offset, row in enumerate(piece.split("\n")):
            for word in PERSONS.finditer(row):
                yield number + offset, f'"{word[0]}": name the client, caller, thread or owner'
    for i, row in enumerate(rows):
        found = re.match(r"\s*// ?(.*)", row)
        first = found and not (i and rows[i - 1].lstrip().startswith("//"))
        if first and BEGINNING.match(found[1]):
            yield i + 1, f'a comment that begins with "{found[1].split()[0]}": begin with what it is about'


def in_script(name, text):
    for i, row in enumerate(text.split("\n")):
        for word in PERSONS.finditer(row):
            yield i + 1, f'"{word[0]}": name the client, process, job or user'


def in_prose(name, text):
    fenced = False
    for i, row in enumerate(text.split("\n")):
        if row.lstrip().startswith("```"):
            fenced = not fenced
        too_long = len(row) > MAX_PROSE and " " in row.lstrip(" *0123456789.-")[:MAX_PROSE]
        if not fenced and too_long and not row.lstrip().startswith(("|", "![", "<")):
            yield i + 1, f"{len(row)} characters, more than {MAX_PROSE}"


def main(names):
    if not names:
        listed = subprocess.run(["git", "ls-files", "--cached", "--others", "--exclude-standard", "--", *SOURCES, *SCRIPTS, *PROSE],
                                cwd=ROOT, capture_output=True, text=True, check=True)
        names = [name for name in listed.stdout.split("\n") if (ROOT / name).is_file()]
    bad = 0
    for name in names:
        if name == ".ci/words.py" or name.endswith(".d.ts") and "generated" in name:
            continue
        check = in_prose if name.endswith(".md") else in_source if name.endswith((".h", ".cpp", ".ts")) else in_script
        text = (ROOT / name).read_text(errors="replace")
        rows = text.split("\n")
        for line, what in check(name, text):
            if any(name == file and part in rows[line - 1] for file, part in ALLOWED):
                continue
            print(f"{name}:{line}: {what}", file=sys.stderr)
            bad += 1
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
