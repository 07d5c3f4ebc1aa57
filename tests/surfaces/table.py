#!/usr/bin/env python3
"""What follows from the table of options (api/options/table.h) in files that are not C++.

  table.py BUILD_DIR            fails if one of the files does not have it
  table.py BUILD_DIR --update   writes it: the properties of Options in openapi.yaml, the settings in check/gates.schema.json, the
                                keywords of compare() in python/meshgauge/__init__.py, the table of options in docs/python.md

An option that is a shape or a time has its schema by hand: a component of openapi.yaml, a definition of check/gates.schema.json.
"""

import difflib
import json
import pathlib
import re
import subprocess
import sys
import textwrap

import yaml

ROOT = pathlib.Path(__file__).resolve().parents[2]
MESHES = {"http": ("mesh a", "mesh b"), "manifest": ("the candidate", "the baseline"), "python": ("a", "b")}
# Components of openapi.yaml that have another name than their option.
COMPONENTS = {"max_share_beyond": "ShareBeyondLimit", "zone": "ZoneLimits", "gate": "GateLimits", "areas": "AreaQuestions",
              "sides": "SideQuestions", "statistics": "Sampling"}
# Settings of a gate that no request has.
OF_GATES = ("name", "candidate", "baseline", "cloud", "on_fail", "unmatched_baselines")
TYPES = {"length": "_options.Length", "limit": "_options.Length", "count": "int", "choice": "str", "toggle": "bool",
         "points": "int", "timeout": "Union[float, str]", "tolerance": "_options.Tolerance", "units": "_options.Units",
         "regions": "Iterable[Mapping[str, Any]]", "max_share_beyond": "Mapping[str, Any]", "zone": "Sequence[_options.Length]",
         "areas": "Mapping[str, Any]", "sides": "Union[bool, Mapping[str, float]]", "statistics": "Union[bool, Mapping[str, int]]",
         "expect": "Mapping[str, Any]"}

NO_BREAK = "\0"


# --- the options ------------------------------------------------------------------------------------------------------


def help_of(option, surface):
    a, b = MESHES[surface]
    return option["help"].replace("{a}", a).replace("{b}", b)


def value_of(option, name):
    """What stands there as in a manifest, as a value; None: nothing does."""
    return yaml.safe_load(option[name]) if option[name] else None


def words_of(option):
    return [yaml.safe_load(word) for word in option["words"]]


def component_of(option):
    return COMPONENTS.get(option["key"], option["key"].title().replace("_", ""))


def by_hand(option):
    return option["kind"] in ("shape", "time")


def schema_of(option, surface, limit):
    """The schema of an option that has none by hand. `limit`: where that of a limit is."""
    schema = {"description": help_of(option, surface)}
    if option["kind"] in ("limit", "length"):
        schema["$ref"] = limit
    if option["kind"] == "length":
        schema["not"] = {"type": "string", "pattern": "%"}
    if option["kind"] == "count":
        low, high = map(int, option["range"])
        schema |= {"type": "integer", "minimum": low, "maximum": high}
    if option["kind"] == "choice":
        words = words_of(option)
        schema |= {"type": "integer" if isinstance(words[0], int) else "string", "enum": words}
    if option["kind"] == "toggle":
        schema["type"] = "boolean"
    if (usual := value_of(option, "usual")) is not None:
        schema["default"] = usual
    return schema


# --- openapi.yaml -----------------------------------------------------------------------------------------------------


def flow(value):
    """A value in YAML's flow style, on one line; the blank behind a key is NO_BREAK."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key}:{NO_BREAK}{flow(one)}" for key, one in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(flow, value)) + "]"
    if isinstance(value, str):
        is_plain = re.fullmatch(r"[A-Za-z][\w ]*", value) and yaml.safe_load(value) == value
        return value if is_plain else "'" + value.replace("'", "''") + "'"
    return json.dumps(value)


def filled(text, step):
    """Lines of at most 120 characters, those behind the first with `step` more blanks before them."""
    lines = textwrap.fill(text, 120, initial_indent=" " * 8, subsequent_indent=" " * (8 + step), break_long_words=False, break_on_hyphens=False)
    return lines.replace(NO_BREAK, " ") + "\n"


def of_service(options):
    text = ""
    for option in options:
        schema = {"$ref": "#/components/schemas/" + component_of(option)}
        if not by_hand(option):
            schema = schema_of(option, "http", "#/components/schemas/Limit")
            if (example := value_of(option, "example")) is not None:
                schema["example"] = example
        lines = filled(f"{option['key']}: {flow(schema)}", 2)
        assert yaml.safe_load(lines) == {option["key"]: schema}, lines
        text += lines
    return text


# --- check/gates.schema.json ------------------------------------------------------------------------------------------


def setting_of(option):
    if by_hand(option):
        return {"$ref": "#/$defs/" + option["key"]}
    schema = schema_of(option, "manifest", "#/$defs/limit")
    schema["description"] += "."
    if (example := value_of(option, "example")) is not None:
        schema["examples"] = [example]
    return schema


def of_manifests(options):
    settings = {key: {"$ref": "#/$defs/" + key} for key in OF_GATES} | {option["key"]: setting_of(option) for option in options}
    lines = ",\n".join(f'        "{key}": {json.dumps(schema)}' for key, schema in settings.items())
    return lines + "\n"


# --- python/meshgauge and docs/python.md ------------------------------------------------------------------------------


def literal(value):
    """A value as Python has it, texts in double quotes."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{literal(key)}: {literal(one)}" for key, one in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(literal, value)) + "]"
    return json.dumps(value) if isinstance(value, str) else repr(value)


def keywords_of(options):
    lines = ""
    for option in options:
        type_ = TYPES.get(option["key"], TYPES.get(option["kind"], "Any"))
        usual = "30.0" if option["key"] == "timeout" else "None"
        lines += f"            {option['key']}: {type_ if type_ == 'Any' else f'Optional[{type_}]'} = {usual},\n"
    return lines


def in_words(option, mark=""):
    """What the option says, with what may stand there."""
    text = help_of(option, "python")
    if option["kind"] == "choice":
        return text + ": " + ", ".join(mark + literal(word) + mark for word in words_of(option))
    if option["kind"] == "count":
        return text + ", {:.0f} to {:.0f}".format(*option["range"])
    example = value_of(option, "example")
    return text if example is None else f"{text}: {mark}{literal(example)}{mark}"


def default_of(option):
    usual = value_of(option, "usual")
    return "" if usual is None else literal(usual)


def arguments_of(options):
    defaults = {option["key"]: f" Default: {default_of(option)}." if option["usual"] else "" for option in options}
    return "".join(filled(f"{option['key']}: {in_words(option)}.{defaults[option['key']]}", 4) for option in options)


def rows_of(options):
    rows = "".join(f"| `{option['key']}` | {in_words(option, '`')} | {f'`{default_of(option)}` ' if option['usual'] else ''}|\n"
                   for option in options)
    return re.sub(r"\(docs/(\w+\.md)\)", r"([\1](\1))", rows)


# --- the files --------------------------------------------------------------------------------------------------------


def replaced(text, before, after, made, name):
    """`text` with what is made between two patterns."""
    found = re.search(f"(?<={before}).*?(?={after})", text, re.M | re.S)
    if not found:
        sys.exit(f"table.py: {name} has no {before!r}, with {after!r} behind it")
    return text[:found.start()] + made + text[found.end():]


def made(options):
    """{file: what it has to be}"""
    of = {surface: [option for option in options if surface in option["surfaces"]] for surface in MESHES}
    blocks = [("openapi.yaml", r"^      properties:  # made by tests/surfaces/table\.py\n", r"^      \w", of_service(of["http"])),
              ("check/gates.schema.json", r'^      "\$comment": "Made by tests/surfaces/table\.py\.",\n      "properties": \{\n',
               r"^      \}", of_manifests(of["manifest"])),
              ("python/meshgauge/__init__.py", r"^def compare\(a: Any, b: Any, max_distance: Optional\[_options\.Length\] = None, \*,\n",
               r"^            vertex_distances: ", keywords_of(of["python"][1:])),
              ("python/meshgauge/__init__.py", r"^    Args:\n", r"^        vertex_distances: ", arguments_of(of["python"])),
              ("docs/python.md", r"^\| option \| meaning \| default \|\n\|---\|---\|---\|\n", r"^\| `vertex_distances`",
               rows_of(of["python"]))]
    files = {}
    for name, before, after, block in blocks:
        files[name] = replaced(files.get(name) or (ROOT / name).read_text(), before, after, block, name)
    return files


def main(build, update):
    table = subprocess.run([build / "tests/surfaces/option_table"], capture_output=True, text=True, check=True).stdout
    differ = 0
    for name, text in made(json.loads(table)).items():
        file = ROOT / name
        there = file.read_text()
        if update:
            file.write_text(text)
        elif text != there:
            differ += 1
            sys.stdout.writelines(difflib.unified_diff(there.splitlines(True), text.splitlines(True), name, "by the table"))
    if differ:
        sys.exit("table.py: files do not follow from the table of options: tests/surfaces/table.py BUILD_DIR --update")


if __name__ == "__main__":
    if len(sys.argv) < 2 or sys.argv[2:] not in ([], ["--update"]):
        sys.exit(__doc__)
    main(pathlib.Path(sys.argv[1]).resolve(), bool(sys.argv[2:]))
