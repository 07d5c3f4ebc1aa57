"""The truth table of units (tests/units/units.tsv) through compare, check and HTTP."""

import base64
import json
import struct
import subprocess
import tempfile
from pathlib import Path

from contract import validate
from harness import BINARY, OWN_DATA, ROOT, ServerCase, post_head
from packages import package_3mf

WORDS_OF_3MF = {"um": "micron", "mm": "millimeter", "cm": "centimeter", "m": "meter", "in": "inch", "ft": "foot"}


def scene(binary, uri=None):
    buffer = {"byteLength": len(binary), **({"uri": uri} if uri else {})}
    return json.dumps({
        "asset": {"version": "2.0"}, "buffers": [buffer], "bufferViews": [{"buffer": 0, "byteLength": len(binary)}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}], "nodes": [{"mesh": 0}],
        "scenes": [{"nodes": [0]}], "scene": 0}).encode()


def triangle(kind, size):
    """The bytes of a file with the corners (0,0), (size,0) and (0,size), and its suffix."""
    corners = [("0", "0", "0"), (size, "0", "0"), ("0", size, "0")]
    lines = [" ".join(corner) for corner in corners]
    binary = struct.pack("<9f", *(float(x) for corner in corners for x in corner))
    if kind == "stl":
        return ("solid t\nfacet normal 0 0 1\nouter loop\n%s\nendloop\nendfacet\nendsolid t\n"
                % "\n".join("vertex " + line for line in lines)).encode(), "stl"
    if kind == "obj":
        return ("".join("v %s\n" % line for line in lines) + "f 1 2 3\n").encode(), "obj"
    if kind == "off":
        return ("OFF\n3 1 0\n%s\n3 0 1 2\n" % "\n".join(lines)).encode(), "off"
    if kind == "ply":
        return ("ply\nformat ascii 1.0\nelement vertex 3\nproperty double x\nproperty double y\nproperty double z\n"
                "element face 1\nproperty list uchar int vertex_indices\nend_header\n%s\n3 0 1 2\n"
                % "\n".join(lines)).encode(), "ply"
    if kind == "gltf":
        return scene(binary, "data:application/octet-stream;base64," + base64.b64encode(binary).decode()), "gltf"
    if kind == "glb":
        text = scene(binary)
        text += b" " * (-len(text) % 4)
        return (struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(binary)) + struct.pack("<I4s", len(text), b"JSON")
                + text + struct.pack("<I4s", len(binary), b"BIN\0") + binary), "glb"
    return package_3mf(WORDS_OF_3MF[kind.removeprefix("3mf:")], corners, [(0, 1, 2)]), "3mf"


def given(cell):
    return None if cell == "-" else cell


class Row:
    def __init__(self, line):
        (self.a, self.size_a, a, self.b, self.size_b, b, limit, unit, self.source, distance, self.verdict,
         self.says) = line.split("\t")
        self.line = line
        self.declared = {part: cell for part, cell in (("a", a), ("b", b)) if given(cell)}
        self.limit, self.unit, self.distance = given(limit), given(unit), given(distance) and float(distance)

    def options(self):
        options = {"tolerance": {"diagonal": 1e-9}, "threads": 1}
        if self.declared:
            options["units"] = self.declared
        if self.limit:
            number, *unit = self.limit.split()
            options["gate"] = {"max_distance": float(number), **({"units": unit[0]} if unit else {})}
        return options

    def flags(self):
        flags = [flag for part, unit in self.declared.items() for flag in ("--unit-" + part, unit)]
        return flags + (["--max-distance", self.limit] if self.limit else [])


ROWS = [Row(line) for line in (ROOT / "tests" / "units" / "units.tsv").read_text().splitlines() if not line.startswith("#")]


class UnitCase(ServerCase):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = Path(folder.name)

    def files(self, row):
        paths = []
        for part, kind, size in (("a", row.a, row.size_a), ("b", row.b, row.size_b)):
            data, suffix = triangle(kind, size)
            paths.append(self.folder / ("%s.%s" % (part, suffix)))
            paths[-1].write_bytes(data)
        return paths

    def run_cli(self, *arguments):
        return subprocess.run([BINARY, *map(str, arguments)], capture_output=True, text=True, timeout=120, env=OWN_DATA)

    def post(self, a, b, options):
        body = b""
        for part, path in (("a", a), ("b", b)):
            body += (b'--XXboundaryXX\r\nContent-Disposition: form-data; name="%s"; filename="%s"\r\n\r\n%s\r\n'
                     % (part.encode(), path.name.encode(), path.read_bytes()))
        body += (b'--XXboundaryXX\r\nContent-Disposition: form-data; name="options"\r\n\r\n%s\r\n--XXboundaryXX--\r\n'
                 % json.dumps(options).encode())
        return self.server.raw(post_head(len(body)) + body)

    def matches(self, row, result):
        self.assertEqual(result["unit"], {"name": row.unit, "source": row.source})
        self.assertEqual(result["verdict"] or "-", row.verdict)
        slack = 1e-6 * max(row.distance, 1)  # a GLB has coordinates of 24 bits
        self.assertLessEqual(result["distance"]["lower"], row.distance + slack)
        self.assertGreaterEqual(result["distance"]["upper"], row.distance - slack)
        if row.limit is None:
            self.assertLessEqual(result["distance"]["upper"] - result["distance"]["lower"], 1e-3 * max(row.distance, 1))
        notes = " | ".join(result["notes"])
        self.assertEqual(notes, "") if row.says == "-" else self.assertIn(row.says, notes)


class Table(UnitCase):
    def test_http(self):
        for row in ROWS:
            with self.subTest(row.line):
                answer = self.post(*self.files(row), row.options())
                if row.verdict == "error":
                    self.refused(answer, 422, "unit-conflict")
                    problem = answer.json()
                    for part in (row.says, "'a'", "'b'"):
                        self.assertIn(part, problem["detail"])
                else:
                    self.assertEqual(answer.status, 200, answer.body)
                    self.matches(row, answer.json())

    def test_compare(self):
        for row in ROWS:
            with self.subTest(row.line):
                done = self.run_cli("compare", *self.files(row), *row.flags(), "--json", "--diagonal", "1e-9")
                if row.verdict == "error":
                    self.assertEqual(done.returncode, 3, done.stdout)
                    self.assertIn(row.says.split(" '")[0], done.stderr)
                else:
                    document = json.loads(done.stdout)
                    validate(document, "Comparison")
                    self.assertEqual(done.returncode, {"fail": 1, "undecided": 2}.get(row.verdict, 0), done.stderr)
                    self.matches(row, document)

    def test_check(self):
        exits = {"pass": 0, "fail": 1, "error": 3}
        for row in ROWS:
            if row.limit is None:
                continue  # check has no gate without one
            with self.subTest(row.line):
                a, b = self.files(row)
                done = self.run_cli("check", a, b, *row.flags(), "--json")
                gate = json.loads(done.stdout)["gates"][0]
                self.assertEqual(done.returncode, exits[row.verdict], done.stdout)
                if row.verdict == "error":
                    self.assertIn(row.says.split(" '")[0], gate["error"]["message"])
                    for path in (a, b):
                        self.assertIn("'%s'" % path, gate["error"]["message"])
                else:
                    self.matches(row, gate["comparison"])
                    self.assertEqual(gate["limit"]["units"], row.unit)
                    if row.says != "-":
                        text = self.run_cli("check", a, b, *row.flags()).stdout
                        self.assertIn(row.says.replace("mesh a", "the candidate").replace("mesh b", "the baseline"), text)

    def test_check_at_a_service(self):
        for row in ROWS[::5] + [row for row in ROWS if row.verdict == "error"][::4]:
            if row.limit is None:
                continue
            with self.subTest(row.line):
                a, b = self.files(row)
                here = json.loads(self.run_cli("check", a, b, *row.flags(), "--json").stdout)["gates"][0]
                there = json.loads(self.run_cli("check", a, b, *row.flags(), "--json", "--server",
                                                "http://127.0.0.1:%d" % self.server.port).stdout)["gates"][0]
                for member in ("verdict", "limit", "distance", "notes", "error", "advice"):
                    if member == "error" and here["error"]:
                        self.assertEqual(here["error"]["message"], there["error"]["message"])
                    else:
                        self.assertEqual(here[member], there[member], member)


class Gates(UnitCase):
    def test_two_glb_files_40_mm_apart_fail_a_limit_of_005_mm(self):
        a, b = self.files(Row("glb\t1\t-\tglb\t1.04\t-\t0.05 mm\tmm\tdeclared\t40\tfail\t-"))
        done = self.run_cli("check", a, b, "--max-distance", "0.05 mm")
        self.assertEqual(done.returncode, 1, done.stdout)
        self.assertIn("at most 0.05 mm", done.stdout)
        result = self.post(a, b, {"gate": {"max_distance": 0.05, "units": "mm"}}).json()
        self.assertEqual((result["verdict"], result["unit"]["name"]), ("fail", "mm"))
        self.assertAlmostEqual(result["distance"]["lower"], 40, places=3)
        self.assertAlmostEqual(result["b_to_a"]["witness"]["point_a"][0], 1040, places=2)
        self.assertAlmostEqual(result["meshes"]["b"]["bbox"]["high"][0], 1.04, places=6)

    def test_a_mesh_is_equal_to_itself_in_any_unit(self):
        a, _ = self.files(Row("glb\t0.1\t-\tglb\t1\t-\t0 in\tin\tdeclared\t0\tpass\t-"))
        self.assertEqual(self.run_cli("check", a, self.copy(a), "--max-distance", "0 in").returncode, 0)

    def copy(self, path):
        other = path.with_name("copy" + path.suffix)
        other.write_bytes(path.read_bytes())
        return other

    def test_a_manifest_declares_units(self):
        a, b = self.files(Row("stl\t1\tin\tstl\t25.4\tmm\t-\tmm\tdeclared\t0\t-\t-"))
        for units, limit, expected in (("{candidate: in, baseline: mm}", "0.001 mm", 0), ("mm", "0.001 mm", 1),
                                       ("{candidate: in, baseline: mm}", "0.01 %", 0),
                                       ("{candidate: in}", "0.001 mm", 3)):
            with self.subTest(units):
                manifest = self.folder / "gates.yaml"
                manifest.write_text("version: 1\ndefaults: {units: %s}\ngates:\n- {name: n, candidate: a.stl, "
                                    "baseline: b.stl, max_distance: %s}\n" % (units, limit))
                done = self.run_cli("check", manifest, "--json")
                self.assertEqual(done.returncode, expected, done.stdout)
                there = self.run_cli("check", manifest, "--json", "--server", "http://127.0.0.1:%d" % self.server.port)
                self.assertEqual(there.returncode, expected, there.stdout)

    def test_a_map_is_in_the_unit_of_the_result(self):
        a, b = self.files(Row("3mf:in\t1\t-\tstl\t30\tmm\t0.05 mm\tmm\tdeclared\t4.6\tfail\t-"))
        for suffix in ("ply", "glb"):
            target = self.folder / ("map." + suffix)
            done = self.run_cli("check", a, b, "--unit-b", "mm", "--max-distance", "0.05 mm", "--deviation", target)
            self.assertEqual(done.returncode, 1, done.stderr)
            self.assertIn(b"25.4" if suffix == "ply" else b'"units":"mm"', target.read_bytes())
        html = self.folder / "report.html"
        self.run_cli("check", a, b, "--unit-b", "mm", "--max-distance", "0.05 mm", "--html", html)
        self.assertIn("was converted from inches to millimetres", html.read_text())

    def test_words_that_are_no_unit_are_refused_with_those_that_are(self):
        a, b = self.files(ROWS[0])
        answer = self.post(a, b, {"gate": {"max_distance": 1, "units": "parsec"}})
        self.refused(answer, 422, "invalid-request")
        self.assertIn("um, mm, cm, m, in, ft", answer.json()["detail"])
        for flags in (["--unit", "parsec"], ["--unit-a", ""], ["--unit-b", "5"], ["--max-distance", "1 parsec"]):
            for command in ("compare", "check"):
                done = self.run_cli(command, a, b, *(["--max-distance", "1"] if "unit" in flags[0] else []), *flags)
                self.assertEqual(done.returncode, 3, flags)
                self.assertIn("um, mm, cm, m, in, ft", done.stderr)
