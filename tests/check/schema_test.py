#!/usr/bin/python3
"""check/gates.schema.json, and the manifests of tests/check/manifests.

Each wrong manifest says in a line at its top what a schema can do about it: "refuses"; "cannot", for what only the files on the
disk or the program's own rules show; "not YAML", for what does not get as far. The program's tests (manifest_test.cpp) hold the
program against the same files.
"""

import json
import re
import unittest
from pathlib import Path

import jsonschema
import yaml

ROOT = Path(__file__).resolve().parents[2]
MANIFESTS = Path(__file__).parent / "manifests"
SCHEMA = json.loads((ROOT / "check/gates.schema.json").read_text())
# 1.0 is an integer to JSON Schema, and not to the program; a float has been one in the text.
STRICT = jsonschema.validators.extend(
    jsonschema.Draft202012Validator,
    type_checker=jsonschema.Draft202012Validator.TYPE_CHECKER.redefine("integer", lambda _, x: type(x) is int))
VALIDATOR = STRICT(SCHEMA)


class Yaml12(yaml.CSafeLoader):
    """YAML by the core schema of version 1.2, as editors and the program read it: `yes` is a text, `<<` a key like any other."""

    yaml_implicit_resolvers = {}


for tag, pattern, first in (("bool", "true|True|TRUE|false|False|FALSE", "tTfF"),
                            ("null", "~|null|Null|NULL|", ["~", "n", "N", ""]),
                            ("int", "[-+]?[0-9]+|0o[0-7]+|0x[0-9a-fA-F]+", "-+0123456789"),
                            ("float", r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?", "-+0123456789.")):
    Yaml12.add_implicit_resolver("tag:yaml.org,2002:" + tag, re.compile(f"^(?:{pattern})$"), list(first))


def defects(document):
    return [error.message for error in VALIDATOR.iter_errors(document)]


def verdict(manifest):
    try:
        document = yaml.load(manifest.read_bytes(), Yaml12)
    except yaml.YAMLError:
        return "not YAML"
    return "refuses" if defects(document) else "cannot"


def gate(**settings):
    return {"version": 1, "gates": [{"name": "x", "candidate": "a", "baseline": "b", "max_distance": 1} | settings]}


def examples(schema, root=SCHEMA):
    """(schema, example) for all that stand in it."""
    if isinstance(schema, dict):
        if not isinstance(schema.get("examples"), dict):
            yield from ((schema, example) for example in schema.get("examples", ()))
        if "default" in schema:
            yield schema, schema["default"]
    for part in schema.values() if isinstance(schema, dict) else schema if isinstance(schema, list) else ():
        yield from examples(part)


class Schema(unittest.TestCase):
    def test_is_a_schema(self):
        jsonschema.Draft202012Validator.check_schema(SCHEMA)
        self.assertEqual(SCHEMA["$schema"], "https://json-schema.org/draft/2020-12/schema")

    def test_accepts_good_manifests(self):
        manifests = sorted((MANIFESTS / "good").glob("*.yaml"))
        self.assertGreaterEqual(len(manifests), 8)
        for manifest in manifests:
            with self.subTest(manifest.name):
                self.assertEqual(defects(yaml.load(manifest.read_bytes(), Yaml12)), [])

    def test_refuses_wrong_manifests(self):
        manifests = sorted((MANIFESTS / "wrong").glob("*.yaml"))
        said = {m: re.search(rb"^# schema: (.*)$", m.read_bytes(), re.M)[1].decode() for m in manifests}
        self.assertGreaterEqual(sum(word == "refuses" for word in said.values()), 50)
        for manifest, word in said.items():
            with self.subTest(manifest.name):
                self.assertEqual(verdict(manifest), word)

    def test_examples_and_defaults_are_valid(self):
        found = list(examples(SCHEMA))
        self.assertGreaterEqual(len(found), 15)
        for schema, example in found:
            with self.subTest(example=example):
                part = schema if schema is SCHEMA else schema | {"$defs": SCHEMA["$defs"]}
                self.assertEqual([error.message for error in STRICT(part).iter_errors(example)], [])

    def test_every_key_is_explained(self):
        def described(schema):
            return "description" in schema or "description" in SCHEMA["$defs"].get(schema.get("$ref", "").rpartition("/")[2], {})

        for name, schema in {"manifest": SCHEMA, "defaults": SCHEMA["properties"]["defaults"], **SCHEMA["$defs"]}.items():
            for key, value in schema.get("properties", {}).items():
                with self.subTest(f"{name}.{key}"):
                    self.assertTrue(described(value) or "const" in value)

    def test_defaults_are_no_gate(self):
        of_two = {"version": 1, "defaults": {"timeout": 1}, "gates": gate()["gates"]}
        self.assertEqual(defects(of_two), [])
        for key in ("name", "candidate", "baseline", "tiemout"):
            self.assertNotEqual(defects(of_two | {"defaults": {"timeout": 1, key: "x"}}), [], key)

    def test_every_limit_and_time_that_is_read(self):
        for limit in (0, 0.05, "0.05 mm", "0.05mm", "5e-2", ".5 m", "5.", "0.5 %", " 3 in ", "1 \u00b5m", "5 Inches", "2\"", "1 metre"):
            self.assertEqual(defects(gate(max_distance=limit)), [], limit)
        for limit in (-1, "", "mm", "0,05", "1 000 mm", "0x10", "1_000", "nan", "5 % mm", "5 m2", "0.5 percent", "5 PCT", "5 pct ", "3 permille", "5em", "1 parsec",
                      "5 \u2030", "5 \uff05", "5 x\u2030", "5e-", "5e", "5 E+mm", "-0.05", True, None, [1]):
            self.assertNotEqual(defects(gate(max_distance=limit)), [], limit)
        for units in ("mm", " Feet", "'", {"candidate": "in"}, {"candidate": "in", "baseline": "mm"}):
            self.assertEqual(defects(gate(units=units)), [], units)
        for units in ("parsec", "", "1 mm", 5, {}, {"a": "mm"}, ["mm"], {"candidate": "pt"}):
            self.assertNotEqual(defects(gate(units=units)), [], units)
        for time in (1.5, 180, "60 s", "500 ms", "2 min", "60s", "90"):
            self.assertEqual(defects(gate(timeout=time)), [], time)
        for time in (0, 181, "1 h", "1 sec", "1 min 30 s", "1:30", "", True):
            self.assertNotEqual(defects(gate(timeout=time)), [], time)


if __name__ == "__main__":
    unittest.main(verbosity=2)
