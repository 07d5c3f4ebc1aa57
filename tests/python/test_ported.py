"""The table of docs/python.md: how many planted faults each way to compare meshes catches."""

import pathlib
import unittest

import ported

ROOT = pathlib.Path(__file__).resolve().parents[2]


class Ported(unittest.TestCase):
    def test_the_table_of_the_docs(self):
        """After a change, `python3 ported.py` prints the new one."""
        self.assertIn(ported.table(), (ROOT / "docs/python.md").read_text())

    def test_equal_parts_are_equal_in_every_way(self):
        for name, way in ported.WAYS.items():
            for part in ported.PARTS.values():
                self.assertTrue(way(part, part), name)


if __name__ == "__main__":
    unittest.main()
