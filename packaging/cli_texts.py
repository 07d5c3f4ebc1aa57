#!/usr/bin/env python3
"""Makes man pages and completions for bash and zsh from the texts that the program itself prints for --help.

  cli_texts.py PROGRAM FOLDER

Writes FOLDER/man/meshgauge.1 and a page for each subcommand, FOLDER/bash/meshgauge and FOLDER/zsh/_meshgauge. SOURCE_DATE_EPOCH is
the date of the pages.
"""

import os
import pathlib
import re
import subprocess
import sys
import time
from dataclasses import dataclass, field

# The files that an argument of the name may be; other values are words.
OF_FILES = re.compile(r"FILE|^A$|^B$|file|folder|certificate|key$|config|junit|sarif|markdown|code-quality|html|deviation|dir$|root$", re.I)
# `--direction TEXT=symmetric (Env:NAME) Excludes: --x`: names, and what CLI11 writes behind them.
ENTRY = re.compile(r"(?P<names>-\S+?|[A-Za-z_]+)(?P<value>\{[-\w]+\}(?: :\{[\w,]+\})?|(?: (?:TEXT|UINT|INT|FLOAT)\S*| \[\S*\])?(?: \.\.\.)?)"
                   r"(?P<required> REQUIRED)?(?: \(Env:(?P<variable>\w+)\))?(?: (?P<relations>(?:Needs|Excludes): .*))?")
DEFAULT = re.compile(r"( (?:TEXT|UINT|INT|FLOAT)\S*) \[(\S+)\] ")  # newer than that: `TEXT [symmetric]  (Env:NAME)`
NOTES = re.compile(r" +(?=\(Env:|\.\.\.)")


@dataclass
class Entry:
    names: list[str]
    value: str  # as CLI11 prints it: " TEXT=auto"; empty: none
    variable: str
    relations: str
    text: str

    def words(self):
        """The values that the text or the type lists, for completion."""
        listed = re.search(r":\{([\w,]+)\}", self.value)
        if listed:
            return listed[1].split(",")
        first = re.split(r"[:;]", self.text)[-1].strip()
        return first.split(", ") if re.fullmatch(r"[a-z_\d]+(?:, [a-z_\d]+)+", first) else []

    def takes_file(self):
        return bool(self.value) and not self.words() and bool(OF_FILES.search(self.names[-1]))


@dataclass
class Command:
    words: list[str]
    text: str = ""
    usage: str = ""
    sections: dict[str, list[Entry]] = field(default_factory=dict)
    subcommands: list["Command"] = field(default_factory=list)

    @property
    def name(self):
        return "-".join(["meshgauge", *self.words])

    def entries(self, section):
        return self.sections.get(section, [])

    def everything(self):
        return [self, *(one for child in self.subcommands for one in child.everything())]


def entry_of(head, text):
    found = ENTRY.fullmatch(head)
    if not found:
        raise ValueError(f"--help has a line of another form: {head}")
    return Entry(found["names"].split(","), found["value"] + (found["required"] or ""), found["variable"] or "",
                 found["relations"] or "", text)


def read(program, words=()):
    """The command with these words, and all below it."""
    lines = subprocess.run([program, *words, "--help"], check=True, text=True, stdout=subprocess.PIPE).stdout.splitlines()
    command = Command(list(words), lines[0], lines[1].removeprefix("Usage: "))
    section, head = "", ""
    for line in lines[2:]:
        line = NOTES.sub(" ", DEFAULT.sub(r"\1=\2  ", line)).rstrip()
        if found := re.fullmatch(r"(\w+):", line):
            section = command.sections.setdefault(found[1], [])
        elif head and line.startswith(" " * 30):
            section.append(entry_of(head, line.strip()))
            head = ""
        elif found := re.fullmatch(r"  (\S.*?)(?:  +(\S.*))?", line):
            if found[2]:
                section.append(entry_of(found[1], found[2]))
            else:
                head = found[1]
    command.subcommands = [read(program, (*words, entry.names[0])) for entry in command.sections.pop("Subcommands", [])]
    return command


# --- man pages ---------------------------------------------------------------------------------------------------------


def roff(text):
    """A line of text, none of whose characters is markup."""
    escaped = text.replace("\\", r"\e").replace("-", r"\-").replace("'", r"\(aq").replace("`", r"\(ga").replace("^", r"\(ha").replace("~", r"\(ti")
    return r"\&" + escaped if escaped.startswith((".", "'")) else escaped


def item(entry):
    names = ", ".join(rf"\fB{roff(name)}\fR" for name in entry.names)
    notes = [f"Environment: {entry.variable}." if entry.variable else "", f"{entry.relations}." if entry.relations else ""]
    text = entry.text + ("" if entry.text.endswith(".") else ".")
    return f".TP\n{names}{roff(entry.value)}\n{roff(' '.join([text, *filter(None, notes)]))}\n"


def man(command, date, version):
    parts = [f'.TH {command.name.upper()} 1 "{date}" "meshgauge {version}" "User Commands"\n',
             f".SH NAME\n{roff(command.name)} \\- {roff(command.text)}\n",
             f".SH SYNOPSIS\n.B {roff(command.usage)}\n"]
    for title, entries in command.sections.items():
        parts += [f".SH {roff(title.upper())}\n", *map(item, entries)]
    if command.subcommands:
        parts.append(".SH SUBCOMMANDS\n")
        parts += [f".TP\n\\fB{roff(child.words[-1])}\\fR\n{roff(child.text)}; see\n.BR {roff(child.name)} (1).\n" for child in command.subcommands]
    others = [name for name in ("meshgauge", "meshgauge-compare", "meshgauge-check", "meshgauge-serve") if name != command.name]
    parts.append(".SH SEE ALSO\n" + ",\n".join(f".BR {roff(name)} (1)" for name in others) + "\n")
    return "".join(parts)


# --- completions -------------------------------------------------------------------------------------------------------


def bash(top):
    cases, values = [], []
    for command in top.everything():
        words = [child.words[-1] for child in command.subcommands]
        flags = [name for entry in command.entries("Options") for name in entry.names if name.startswith("--")]
        cases.append(f"    '{' '.join(command.words)}') words='{' '.join([*words, *flags])}' ;;")
        for entry in command.entries("Options"):
            if entry.value and entry.words():
                values.append(f"    '{' '.join([*command.words, entry.names[-1]])}') words='{' '.join(entry.words())}' ;;")
    names = "|".join(sorted({word for command in top.everything() for word in command.words}))
    return f"""# bash completion of meshgauge, made from its --help
_meshgauge() {{
  local current=${{COMP_WORDS[COMP_CWORD]}} before=${{COMP_WORDS[COMP_CWORD - 1]}} command='' words='' word
  for word in "${{COMP_WORDS[@]:1:COMP_CWORD-1}}"; do
    case $word in {names}) command+="${{command:+ }}$word" ;; esac
  done
  case "${{command:+$command }}$before" in
{chr(10).join(values)}
  esac
  if [[ -z $words && ($current == -* || -z $command || $command == keys) ]]; then
    case $command in
{chr(10).join(cases)}
    esac
  fi
  mapfile -t COMPREPLY < <(compgen -W "$words" -- "$current")
  [[ -n $words ]] || mapfile -t COMPREPLY < <(compgen -f -- "$current")
}}
complete -o filenames -F _meshgauge meshgauge
"""


def quoted(text):
    return "'" + text.replace("'", "'\\''") + "'"


def zsh_spec(entry):
    text = re.sub(r"([\[\]:\\])", r"\\\1", entry.text)
    if not entry.names[0].startswith("-"):
        return quoted(f":{text}:{'_files' if entry.takes_file() else ''}")
    action = f"({' '.join(entry.words())})" if entry.words() else "_files" if entry.takes_file() else " "
    value = f":value:{action}" if entry.value and entry.value != "{-}" else ""
    repeated = "*" if "..." in entry.value else ""
    return " ".join(quoted(f"{repeated}{name}[{text}]{value}") for name in entry.names)


def zsh(top):
    functions = []
    for command in top.everything():
        specs = [zsh_spec(entry) for section in ("Options", "Positionals") for entry in command.entries(section)]
        lines = " \\\n    ".join(specs)
        name = "_" + command.name.replace("-", "_")
        if not command.subcommands:
            functions.append(f"{name}() {{\n  _arguments {lines}\n}}\n")
            continue
        listed = " ".join(quoted(f"{child.words[-1]}:{re.sub(r':', ' -', child.text)}") for child in command.subcommands)
        functions.append(f"""{name}() {{
  local line state
  _arguments -C {lines} \\
    '1: :->command' '*:: :->arguments'
  case $state in
    command) local -a commands=({listed}); _describe command commands ;;
    arguments) (( $+functions[{name}_$line[1]] )) && {name}_$line[1] ;;
  esac
}}
""")
    return "#compdef meshgauge\n# zsh completion of meshgauge, made from its --help\n" + "\n".join(functions) + '\n_meshgauge "$@"\n'


def main(program, folder):
    top = read(program)
    version = subprocess.run([program, "--version"], check=True, text=True, stdout=subprocess.PIPE).stdout.split()[-1]
    date = time.strftime("%Y-%m-%d", time.gmtime(int(os.environ.get("SOURCE_DATE_EPOCH", "0"))))
    files = {f"man/{command.name}.1": man(command, date, version) for command in top.everything()}
    files |= {"bash/meshgauge": bash(top), "zsh/_meshgauge": zsh(top)}
    for name, text in files.items():
        file = folder / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)


if __name__ == "__main__":
    main(sys.argv[1], pathlib.Path(sys.argv[2]))
