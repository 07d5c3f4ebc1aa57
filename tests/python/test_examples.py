"""The example of the README, and those of docs/python.md that need no service."""

import contextlib
import io
import os
import pathlib
import re
import tempfile
import unittest

import shapes

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = pathlib.Path(os.environ["MESHGAUGE_BINARY"]).parent


def example(page, beginning):
    """The block of Python that has `beginning`."""
    blocks = re.findall(r"^```python\n(.*?)^```$", (ROOT / page).read_text(), re.M | re.S)
    return next(block for block in blocks if beginning in block)


def printed(source, **names):
    output = io.StringIO()
    with contextlib.redirect_stdout(output):
        exec(source, names)
    return output.getvalue()


class Examples(unittest.TestCase):
    def test_the_readme_s(self):
        source = example("README.md", "meshgauge.compare").replace("build/samples", str(BUILD / "samples"))
        self.assertEqual(printed(source), re.search(r"# (pass .*)", source)[1] + "\n")

    def test_the_page_s_and_the_package_s(self):
        vertices, faces = shapes.box(1)
        with tempfile.NamedTemporaryFile(suffix=".obj") as part:
            part.write(shapes.obj(shapes.box(1.01)))
            part.flush()
            for page in ("docs/python.md", "python/README.md"):
                source = example(page, "meshgauge.compare").replace("part.stl", part.name)
                self.assertRegex(printed(source, vertices=vertices, faces=faces), r"^pass 0.01\d+ 0.01\d+")


if __name__ == "__main__":
    unittest.main()
