"""The loops of docs/mcp.md: each call that the page shows, on the shapes of shapes.py, is answered as it shows."""

import json
import math
import pathlib
import re
import unittest

import shapes
from client import Session

PAGE = pathlib.Path(__file__).resolve().parents[2] / "docs/mcp.md"
NUMBER = r"(?<![\w.])-?\d+(?:\.\d+)?(?:e-?\d+)?"


def shown():
    """[(call, lines of its answer)] of the page."""
    found = re.findall(r"^```json\n(\{\"name\": .*?)^```\n.*?^```text\n(.*?)^```", PAGE.read_text(), re.M | re.S)
    return [(json.loads(call), answer.splitlines()) for call, answer in found]


def is_like(line, wanted):
    """Whether both are the same, their numbers nearly."""
    if re.sub(NUMBER, "#", line) != re.sub(NUMBER, "#", wanted):
        return False
    return all(math.isclose(float(one), float(other), rel_tol=1e-3, abs_tol=1e-3)
               for one, other in zip(re.findall(NUMBER, line), re.findall(NUMBER, wanted)))


class Loops(Session):
    def setUp(self):
        super().setUp()
        shapes.write(self.folder)
        self.file("gates.yaml", re.search(r"^```yaml\n(.*?)^```", PAGE.read_text(), re.M | re.S)[1])

    def test_each_call_is_answered_as_the_page_shows(self):
        calls = shown()
        self.assertGreaterEqual(len(calls), 6)
        for call, wanted in calls:
            result = self.client.call(call["name"], call["arguments"])
            lines = result["content"][0]["text"].splitlines()
            for line in wanted:
                self.assertTrue(any(is_like(one, line) for one in lines), (call, line, lines))

    def test_first_versions_fail_and_second_ones_pass(self):
        for name in shapes.SHAPES:
            for version, verdict in ((1, "fail"), (2, "pass")):
                found = self.found(self.compare(f"{name}_{version}.stl", f"{name}_reference.stl", options={"max_distance": "0.05 mm"}))
                self.assertEqual(found["verdict"], verdict, (name, version))

    def test_the_shapes_are_closed(self):
        for name in shapes.SHAPES:
            for version in ("reference", "1", "2"):
                found = self.found(self.client.call("inspect_mesh", {"mesh": {"path": f"{name}_{version}.stl"}}))
                self.assertTrue(found["topology"]["watertight"] and found["topology"]["oriented"], (name, version))
                self.assertGreater(found["topology"]["volume"]["lower"], 0)

    def test_the_page_shows_each_tool(self):
        names = [tool["name"] for tool in self.client.result("tools/list")["tools"]]
        self.assertEqual({call["name"] for call, _ in shown()}, set(names))


if __name__ == "__main__":
    unittest.main()
