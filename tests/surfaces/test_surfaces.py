"""One request is the same on every surface: its document, its verdict, the bits of its intervals, and what is wrong with it."""

import json
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "e2e"))
import contract  # noqa: E402
from harness import BINARY, ENVIRONMENT, ServerCase  # noqa: E402
from test_batches import accepted, ended, put, results, submit  # noqa: E402

import meshgauge  # noqa: E402
import rows  # noqa: E402

contract.check = lambda request, answer: None  # tests/e2e holds answers against openapi.yaml

CORNERS = [(x, y, z) for z in (0.0, 2.0) for y in (0.0, 2.0) for x in (0.0, 2.0)]
FACES = [(0, 2, 3), (0, 3, 1), (4, 5, 7), (4, 7, 6), (0, 1, 5), (0, 5, 4), (2, 6, 7), (2, 7, 3), (0, 4, 6), (0, 6, 2), (1, 3, 7), (1, 7, 5)]
TOLD = subprocess.run([BINARY, "compare", "--help"], capture_output=True, text=True, env=ENVIRONMENT, check=True).stdout
FLAGS = set(re.findall(r"^  (--[a-z-]+) TEXT", TOLD, re.M))


def cube(shift):
    lines = ["v %r %r %r" % (x + shift, y, z) for x, y, z in CORNERS] + ["f %d %d %d" % tuple(i + 1 for i in face) for face in FACES]
    return ("\n".join(lines) + "\n").encode()


def flags_of(request):
    """The request as flags; None: they cannot say it."""
    flags = []
    for name, value in request.items():
        flag = "--unit" if name == "units" else "--" + name.replace("_", "-")
        if name in ("tolerance", "statistics") and isinstance(value, dict) and value:
            parts = {"tolerance": ("absolute", "diagonal", "relative"), "statistics": ("samples", "seed")}[name]
            if not set(value) <= set(parts) or any(isinstance(one, (str, bool)) for one in value.values()):
                return None
            flags += [f"--{part}={one!r}" for part, one in value.items()]
        elif name == "statistics" and isinstance(value, bool):
            flags += ["--statistics"] if value else []
        elif name == "narrow" and isinstance(value, bool):
            flags += [] if value else ["--fast"]
        elif flag not in FLAGS or value == "" or (name == "units" and not isinstance(value, str)):  # an empty text is CLI11's own mistake
            return None
        else:
            text = value if isinstance(value, str) else json.dumps(value)
            is_text_of_a_number = isinstance(value, str) and name in ("points", "threads")
            if is_text_of_a_number or (name in ("max_share_beyond", "zone") and not isinstance(value, (dict, list))):
                return None  # a flag has no quotes, or a form of its own
            flags.append(f"{flag}={text}")
    return flags


def said(message):
    """A message without what a surface calls things."""
    message = re.sub(r"(?<![\w'\"])/[a-z_]+(/[\w]+)*", lambda found: dotted(found[0]), message)
    message = re.sub(r"--([a-z-]+)", lambda found: found[1].replace("-", "_"), message)
    for one, other in (("an object", "a map"), ("a mapping", "a map"), ("an empty mapping", "an empty map"), ("an empty object", "an empty map"),
                       ("an array", "a list"), ("unknown option", "unknown key"), (" None", " empty"), (" null", " empty"),
                       ("mesh a", "A"), ("mesh b", "B"), ("the candidate", "A"), ("the baseline:", "B:"), ("volume of the baseline", "volume of B"),
                       ("or candidate_to_baseline", "or a_to_b"), ("or baseline_to_candidate", "or b_to_a"), ("points of a:", "points of A:"),
                       ("group of b:", "group of B:"), ("volume of b,", "volume of B,")):
        message = message.replace(one, other)
    message = re.sub(r"tolerance\.(absolute|diagonal|relative)|statistics\.(samples|seed)", lambda found: found[1] or found[2], message)
    message = re.sub(r"^\w+: (?=unknown key|the region)", "", message)
    message = re.sub(r"unknown key '[^']*?([\w]+)'", r"unknown key '\1'", message)
    message = message.replace("unit_a", "units.candidate").replace("unit_b", "units.baseline")
    message = re.sub(r"^units\.?|^unit\b", "unit", message).replace(" leave units out", " leave unit out")
    return re.sub(r"; (known: .*|did you mean .*)$", "", message)


def is_own_of_python(request):
    """A form that Python reads in its own way, or a time that is too long for a service alone."""
    return (any(isinstance(request.get(name), list) for name in ("align", "units")) or not isinstance(request.get("tolerance", {}), dict)
            or "timeout" in request or set(request) & {"max_distnace", "colour"})


def dotted(pointer):
    return re.sub(r"/(\d+)", r"[\1]", pointer).lstrip("/").replace("/", ".")


def without_chance(document):
    kept = {name: value for name, value in document.items() if name not in ("id", "timings_ms", "view")}
    kept["engine"] = {name: value for name, value in document["engine"].items() if name != "threads"}
    return kept


def criteria_of(found):
    members = ("name", "of", "region", "side", "beyond", "limit", "uncertainty", "lower", "upper", "verdict", "found", "expected")
    return [{name: one[name] for name in members if name in one} for one in found["criteria"]]


class Surfaces(ServerCase):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.folder = tempfile.TemporaryDirectory()
        cls.a, cls.b = Path(cls.folder.name, "a.obj"), Path(cls.folder.name, "b.obj")
        cls.a.write_bytes(cube(0.25))
        cls.b.write_bytes(cube(0))

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()
        super().tearDownClass()

    def http(self, request):
        return self.server.compare(self.a.read_bytes(), self.b.read_bytes(), json.dumps(request).encode())

    def options(self, request):
        return self.server.send("POST", "/v1/options", json.dumps(request).encode(), "Content-Type: application/json\r\n")

    def manifest(self, requests, *flags):
        """The report on a manifest with these gates, and what the terminal says."""
        gates = [{"name": str(i), "candidate": "a.obj", "baseline": "b.obj", **request} for i, request in enumerate(requests)]
        file = Path(self.folder.name, "gates.yaml")
        file.write_text("version: 1\ngates:\n" + "".join("- %s\n" % json.dumps(gate) for gate in gates))
        run = subprocess.run([BINARY, "check", file, "--json", *flags], capture_output=True, text=True, env=ENVIRONMENT)
        return (json.loads(run.stdout)["gates"] if run.stdout else []), run.stderr

    def errors_of(self, mistakes):
        """Returns the messages of `check` for each request. A manifest has fifty, since a report names a hundred mistakes at most."""
        found = [[] for _ in mistakes]
        for first in range(0, len(mistakes), 50):
            for gate in self.manifest(mistakes[first:first + 50])[0]:
                found[first + gate["manifest"]["line"] - 3].append(said(gate["error"]["message"]))
        return [sorted(messages) for messages in found]

    def by_flags(self, request):
        flags = flags_of(request)
        return flags and subprocess.run([BINARY, "compare", self.a, self.b, "--json", *flags], capture_output=True, text=True, env=ENVIRONMENT)

    def test_there_are_many(self):
        self.assertGreaterEqual(len(rows.wholes()) + len(rows.mistakes()), 300)

    def test_what_is_asked(self):
        asked = rows.wholes()
        gates, complaint = self.manifest(asked)
        self.assertEqual(len(gates), len(asked), complaint)
        by_flags = 0
        for request, gate in zip(asked, gates):
            with self.subTest(request):
                answer = self.http(request)
                self.assertEqual(answer.status, 200, answer.body)
                document = without_chance(answer.json())
                read = self.options(request)
                self.assertEqual(read.status, 200, read.body)
                self.assertEqual(self.options(read.json()).body, read.body)  # as it is written, it means the same
                here = meshgauge.compare(self.a, self.b, **request)
                self.assertEqual(without_chance(here.document), document)
                self.assertEqual(without_chance(gate["comparison"]), document)
                self.assertEqual((gate["verdict"], criteria_of(gate)), (document["verdict"], criteria_of(document)))
                if run := self.by_flags(request):
                    by_flags += 1
                    self.assertEqual(run.returncode, {"pass": 0, "fail": 1, "undecided": 2}[document["verdict"]], run.stderr)
                    self.assertEqual(without_chance(json.loads(run.stdout)), document)
        self.assertGreater(by_flags, 0.9 * len(asked))

    def test_what_is_wrong(self):
        by_flags = 0
        mistakes = rows.mistakes()
        for request, by_manifest in zip(mistakes, self.errors_of(mistakes)):
            with self.subTest(request):
                answer = self.http(request)
                self.assertEqual(answer.status, 422, answer.body)
                wrong = sorted(said(one["message"]) for one in answer.json()["errors"])
                self.assertEqual(self.options(request).body, answer.body)
                self.assertEqual(by_manifest, wrong)
                if not is_own_of_python(request):
                    with self.assertRaises(meshgauge.InputError) as caught:
                        meshgauge.compare(self.a, self.b, **request)
                    self.assertTrue(any(said(str(caught.exception)).startswith(one) for one in wrong), caught.exception)
                if run := self.by_flags(request):
                    by_flags += 1
                    self.assertEqual(run.returncode, 3, run.stdout)
                    self.assertEqual(sorted(said(line[11:]) for line in run.stderr.splitlines()), wrong)
        self.assertGreater(by_flags, 100)

    def test_a_manifest_is_a_batch(self):
        """Copied into a batch, and sent by `check --server`, a manifest gives the same criteria as here."""
        asked = [{**request, "narrow": False} for request in rows.wholes() if "statistics" not in request]
        here, _ = self.manifest(asked)
        there, complaint = self.manifest(asked, "--server", "http://127.0.0.1:%d" % self.server.port)
        self.assertEqual([(gate["verdict"], criteria_of(gate)) for gate in there], [(gate["verdict"], criteria_of(gate)) for gate in here], complaint)
        a, b = put(self.server, self.a.read_bytes()), put(self.server, self.b.read_bytes())
        path = accepted(submit(self.server, {"comparisons": [{"a": a, "b": b, "options": request} for request in asked]}))
        ended(self.server, path)
        batch = results(self.server, path)
        self.assertEqual([criteria_of(line["result"]) for line in batch], [criteria_of(gate) for gate in here])


if __name__ == "__main__":
    unittest.main()
