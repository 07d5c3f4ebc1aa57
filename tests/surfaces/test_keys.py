"""Every list of options is that of the reader's table: of the API's description, of the manifest's schema, of Python, of the flags."""

import inspect
import json
import re
import subprocess
import sys
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests/e2e"))
import contract  # noqa: E402
from harness import BINARY, ENVIRONMENT, ServerCase  # noqa: E402

import meshgauge  # noqa: E402

OF_SERVICE = {"gate", "timeout_ms", "budget"}  # other forms of what stands beside them, and what a caller of a library does not need
OF_GATES = {"cloud", "on_fail", "unmatched_baselines", "name", "candidate", "baseline"}  # of a gate alone: no request has them
OF_LIBRARY = {"a", "b", "vertex_distances"}
PARTS = {"tolerance": ("--absolute", "--diagonal", "--relative"), "areas": ("--beyond", "--quantiles", "--mean"), "units": ("--unit", "--unit-a", "--unit-b"),
         "narrow": ("--fast",), "budget": ("--work-items", "--memory-bytes")}


class Keys(ServerCase):
    def table(self):
        """The reader's own list: what it says of an option that there is not."""
        answer = self.server.send("POST", "/v1/options", json.dumps({"?": 1}).encode(), "Content-Type: application/json\r\n")
        return set(re.search(r"known: (.*)", answer.json()["errors"][0]["message"])[1].split(", "))

    def test_the_description_of_the_api(self):
        self.assertEqual(set(contract.OPENAPI["components"]["schemas"]["Options"]["properties"]), self.table())

    def test_the_schema_of_manifests(self):
        schema = json.loads((ROOT / "check/gates.schema.json").read_text())
        self.assertLessEqual(set(schema["$defs"]["settings"]["properties"]) - OF_GATES, self.table())

    def test_python(self):
        known = self.table() - OF_SERVICE
        of_compare = set(inspect.signature(meshgauge.compare).parameters) - OF_LIBRARY
        self.assertEqual(of_compare, known)

    def test_the_flags(self):
        told = subprocess.run([BINARY, "compare", "--help"], capture_output=True, text=True, env=ENVIRONMENT, check=True).stdout
        flags = set(re.findall(r"(--[a-z-]+)", told))
        for key in self.table() - {"gate"}:
            for flag in PARTS.get(key, ("--" + key.replace("_", "-"),)):
                self.assertIn(flag, flags, key)


if __name__ == "__main__":
    unittest.main()
