"""A session with `meshgauge mcp` over every tool."""

import base64
import json
import math
import subprocess
import unittest

import jsonschema
from client import PNG, Session, cube, square
from harness import BINARY, ENVIRONMENT


def inline(data, name=None):
    return {"base64": base64.b64encode(data).decode(), **({"name": name} if name else {})}


class Protocol(Session):
    def test_the_revision_is_the_clients_where_it_is_known(self):
        for asked, got in (("2025-11-25", "2025-11-25"), ("2025-06-18", "2025-06-18"), ("2025-03-26", "2025-11-25"),
                           ("2024-11-05", "2024-11-05"), ("1999-01-01", "2025-11-25")):
            result = self.client.initialize(asked)
            self.assertEqual(result["protocolVersion"], got)
            self.assertEqual(result["capabilities"], {"tools": {}})
            self.assertEqual(result["serverInfo"]["name"], "meshgauge")

    def test_ping_and_ids(self):
        for id_ in (0, -7, 2**53, "x", "", "\u00e9\n"):
            self.assertEqual(self.client.ask("ping", id_=id_), {"jsonrpc": "2.0", "id": id_, "result": {}})

    def test_each_tool_has_schemas_that_are_schemas(self):
        tools = self.client.result("tools/list")["tools"]
        self.assertEqual([tool["name"] for tool in tools], ["compare_meshes", "inspect_mesh", "check_gates"])
        for tool in tools:
            for schema in (tool["inputSchema"], tool["outputSchema"]):
                self.assertEqual(schema["type"], "object")
                jsonschema.Draft202012Validator.check_schema(schema)
            self.assertTrue(tool["annotations"]["readOnlyHint"])
        options = tools[0]["inputSchema"]["properties"]["options"]["properties"]
        self.assertEqual(options["direction"]["default"], "symmetric")
        self.assertEqual(options["points"]["enum"][0], 4)
        self.assertEqual(options["max_distance"]["examples"], ["0.05 mm"])
        self.assertTrue({"align", "units", "expect", "regions", "timeout"} <= set(options))

    def test_what_is_found_is_as_the_schemas_say(self):
        tools = {tool["name"]: tool for tool in self.client.result("tools/list")["tools"]}
        self.file("gates.yaml", "version: 1\ngates: [{name: x, candidate: raised.obj, baseline: flat.obj, max_distance: 1}]\n")
        calls = [("compare_meshes", {"a": {"path": "raised.obj"}, "b": {"path": "flat.obj"}}),
                 ("compare_meshes", {"a": {"path": "raised.obj"}, "b": inline(square(), "b.obj"), "picture": True,
                                     "options": {"max_distance": "1 mm", "align": "none", "units": "mm", "expect": {"watertight": False}}}),
                 ("inspect_mesh", {"mesh": {"path": "cube.obj"}, "unit": "mm"}), ("check_gates", {})]
        for name, arguments in calls:
            jsonschema.validate(arguments, tools[name]["inputSchema"])
            jsonschema.validate(self.found(self.client.call(name, arguments)), tools[name]["outputSchema"])

    def test_at_the_end_of_its_input_it_ends(self):
        self.client.initialize()
        self.assertEqual(self.client.close(), 0)

    def test_the_last_message_may_lack_its_end(self):
        self.client.send_bytes(b'{"jsonrpc":"2.0","id":5,"method":"ping"}')
        self.client.process.stdin.close()
        self.assertEqual(self.client.answer(5)["result"], {})
        self.assertEqual(self.client.process.wait(), 0)

    def test_progress_rises(self):
        self.file("gates.yaml", "version: 1\ndefaults: {max_distance: 1}\ngates:\n"
                  + "".join("- {name: g%d, candidate: raised.obj, baseline: flat.obj}\n" % i for i in range(5)))
        for token in ("t", 7):
            id_ = self.client.begin_call("check_gates", {}, token=token)
            self.client.answer(id_)
            told = [one["params"] for one in self.client.notifications]
            self.client.notifications.clear()
            self.assertEqual([one["progress"] for one in told], [1, 2, 3, 4, 5])
            for one in told:
                self.assertEqual((one["progressToken"], one["total"]), (token, 5))
                self.assertRegex(one["message"], r"^g\d: fail$")


class Compare(Session):
    def test_a_pass_has_no_picture(self):
        result = self.compare(options={"max_distance": 2.5})
        found = self.found(result)
        self.assertEqual((found["verdict"], found["foremost"]), ("pass", "distance"))
        self.assertTrue(found["distance"]["lower"] <= 2 <= found["distance"]["upper"] <= 2.5)
        self.assertEqual(len(result["content"]), 2)
        self.assertRegex(result["content"][0]["text"], r"^pass: the distance is at most 2\.?\d*, within the limit of 2\.5\n")

    def test_a_fail_names_the_point_and_shows_it(self):
        result = self.compare(options={"max_distance": "1 mm"})
        found = self.found(result)
        self.assertEqual(found["verdict"], "fail")
        self.assertEqual(found["unit"], {"name": "mm", "source": "assumed"})
        self.assertIn(found["witness"]["on"], "ab")
        self.assertAlmostEqual(abs(found["witness"]["point"][2] - found["witness"]["nearest_point"][2]), 2)
        text, _, image = result["content"]
        self.assertRegex(text["text"], r"^fail: the distance is at least (2|1\.9+) mm, above the limit of 1 mm\n")
        self.assertIn("Look at (", text["text"])
        self.assertEqual((image["type"], image["mimeType"]), ("image", "image/png"))
        png = base64.b64decode(image["data"], validate=True)
        self.assertTrue(png.startswith(PNG))
        self.assertLessEqual(len(png), 200_000)
        self.assertIn("\nthe picture shows mesh b (before), mesh a (after)", text["text"])

    def test_the_picture_is_the_same_each_time(self):
        one, two = (self.compare(options={"max_distance": 1, "threads": 1})["content"][2]["data"] for _ in range(2))
        self.assertEqual(one, two)

    def test_a_picture_may_be_wanted_or_not(self):
        self.assertEqual(len(self.compare(options={"max_distance": 1}, picture=False)["content"]), 2)
        self.assertEqual(len(self.compare(options={"max_distance": 3}, picture=True)["content"]), 3)
        self.assertEqual(len(self.compare(picture=True)["content"]), 3)

    def test_without_a_limit_there_is_an_interval_and_no_verdict(self):
        result = self.compare()
        found = self.found(result)
        self.assertEqual((found["verdict"], found["criteria"], found["foremost"]), (None, [], None))
        self.assertEqual(len(result["content"]), 2)
        self.assertRegex(result["content"][0]["text"], r"^the distance \(symmetric\) is from (2|1\.9+) to 2\.?\d*\n.*farthest off is \(")

    def test_the_foremost_criterion_comes_first(self):
        found = self.found(self.compare(options={"max_distance": 3, "expect": {"triangles": 2, "watertight": True}}))
        self.assertEqual([one["verdict"] for one in found["criteria"]], ["fail", "pass", "pass"])
        self.assertEqual(found["criteria"][0]["name"], found["foremost"])
        self.assertEqual(found["foremost"], "watertight")

    def test_with_regions_the_witness_is_that_of_the_whole_distance(self):
        self.file("larger.obj", cube(1.2))
        options = {"max_distance": 0.3, "regions": [{"name": "far", "box": {"min": [0.9, -9, -9], "max": [9, 9, 9]}, "max_distance": 5}]}
        result = self.compare("cube.obj", "larger.obj", options=options, picture=True)
        found = self.found(result)
        self.assertEqual(found["verdict"], "pass")
        witness = found["witness"]
        self.assertGreaterEqual(math.dist(witness["point"], witness["nearest_point"]), found["distance"]["lower"] * (1 - 1e-12))
        self.assertAlmostEqual(found["distance"]["lower"], math.sqrt(0.12), 3)
        text = result["content"][0]["text"]
        self.assertIn("farthest off is (1.2, 1.2, 1.2)", text)
        self.assertIn("the mark is on the point that is farthest off", text)
        options["regions"][0]["max_distance"] = 0.1
        result = self.compare("cube.obj", "larger.obj", options=options)
        self.assertEqual(self.found(result)["verdict"], "fail")
        self.assertIn("the mark is on the point to look at of 'distance in far'", result["content"][0]["text"])

    def test_what_only_an_expectation_refuses_still_has_a_place(self):
        text = self.compare(options={"max_distance": 3, "expect": {"watertight": True}})["content"][0]["text"]
        self.assertIn("\nRepair mesh a, or change what is expected of it.\nfarthest off is (", text)
        self.assertIn("dark red is beyond the limit", text)
        self.assertIn("red is the largest distance", self.compare(picture=True)["content"][0]["text"])

    def test_meshes_inside_of_the_message(self):
        pairs = [(inline(square(2.0), "x.obj"), {"path": "flat.obj"}), (inline(square(2.0)), inline(square())),
                 ({"path": str(self.folder / "raised.obj")}, inline(square(), "flat.obj"))]
        for a, b in pairs:
            found = self.found(self.client.call("compare_meshes", {"a": a, "b": b, "options": {"max_distance": 1}}))
            self.assertEqual(found["verdict"], "fail")
        lines = base64.encodebytes(square(2.0)).decode()  # with line ends
        found = self.found(self.client.call("compare_meshes", {"a": {"base64": lines}, "b": {"path": "flat.obj"}}))
        self.assertAlmostEqual(found["distance"]["lower"], 2)

    def test_alignment_and_units(self):
        found = self.found(self.compare("cube.obj", "cube.obj", options={"max_distance": "1 um", "align": "rigid", "units": "mm"}))
        self.assertEqual(found["verdict"], "pass")
        self.assertEqual(found["alignment"]["method"], "best_fit")
        found = self.found(self.compare("cube.obj", "cube.obj", options={"units": {"a": "in", "b": "mm"}}, picture=False))
        self.assertEqual(found["unit"]["name"], "mm")
        self.assertTrue(any("converted" in note for note in found["notes"]))

    def test_a_file_that_is_no_mesh(self):
        self.file("broken.obj", "v 0 0 x\n")
        self.assertIn("broken.obj", self.refused(self.compare("broken.obj")))
        self.assertIn("'a'", self.refused(self.client.call("compare_meshes", {"a": inline(b"?"), "b": {"path": "flat.obj"}})))


class Inspect(Session):
    def test_a_closed_cube(self):
        result = self.client.call("inspect_mesh", {"mesh": {"path": "cube.obj"}, "unit": "mm"})
        found = self.found(result)
        self.assertEqual((found["triangles"], found["vertices"], found["format"]), (12, 8, "obj"))
        self.assertEqual(found["unit"], {"name": "mm", "source": "declared"})
        self.assertEqual(found["bbox"], {"low": [0, 0, 0], "high": [1, 1, 1]})
        self.assertEqual(found["area"], 6)
        self.assertEqual((found["topology"]["watertight"], found["topology"]["oriented"], found["topology"]["components"]), (True, True, 1))
        self.assertTrue(found["topology"]["volume"]["lower"] <= 1 <= found["topology"]["volume"]["upper"])
        self.assertRegex(result["content"][0]["text"], r"^cube\.obj: obj, in mm, 12 triangles, 8 vertices\nwatertight, oriented, components: 1")

    def test_an_open_square_and_its_notes(self):
        found = self.found(self.client.call("inspect_mesh", {"mesh": inline(square() + b"g lid\nf 1 2 4\n")}))
        self.assertEqual(found["unit"], {"name": None, "source": "unknown"})
        self.assertFalse(found["topology"]["watertight"])
        self.assertIsNone(found["topology"]["volume"])
        self.assertEqual(found["groups"], ["lid"])

    def test_a_point_cloud(self):
        found = self.found(self.client.call("inspect_mesh", {"mesh": inline(b"0 0 0\n1 0 0\n0 1 5\n", "points.xyz")}))
        self.assertEqual((found["triangles"], found["vertices"], found["area"]), (0, 3, 0))
        self.assertTrue(any("point cloud" in note for note in found["notes"]))
        self.assertIsNone(found["topology"])

    def test_what_faces_inwards(self):
        faces = [line.split() for line in cube().decode().splitlines()]
        inward = "\n".join(" ".join([kind, *(reversed(rest) if kind == "f" else rest)]) for kind, *rest in faces) + "\n"
        result = self.client.call("inspect_mesh", {"mesh": inline(inward.encode(), "x.obj"), "unit": "in"})
        self.assertLess(self.found(result)["topology"]["volume"]["upper"], 0)
        self.assertIn("\nvolume: -1 in^3: its triangles face inwards\n", result["content"][0]["text"])


class Gates(Session):
    MANIFEST = ("version: 1\ndefaults: {max_distance: 1 mm}\ngates:\n- {name: flat, candidate: copy.obj, baseline: flat.obj}\n"
                "- {name: raised, candidate: raised.obj, baseline: flat.obj}\n- {name: gone, candidate: gone.obj, baseline: flat.obj}\n")

    def setUp(self):
        super().setUp()
        self.file("copy.obj", square())
        self.file("gates.yaml", self.MANIFEST)

    def test_the_report_is_that_of_check(self):
        self.file("gates.yaml", self.MANIFEST.rsplit("- ", 1)[0])
        found = self.found(self.client.call("check_gates", {"comparisons": True}))
        done = subprocess.run([BINARY, "check", "--json"], cwd=self.folder, env=ENVIRONMENT, capture_output=True, check=False)
        report = json.loads(done.stdout)
        self.assertEqual((found.pop("verdict"), found.pop("left_out")), ("fail", 0))
        self.assertEqual(list(found), list(report))
        self.assertEqual((found["exit_code"], found["counts"]), (1, report["counts"]))
        for one, other in zip(found["gates"], report["gates"]):
            self.assertEqual(list(one), list(other))
            for member in ("name", "verdict", "level", "limit", "candidate", "baseline", "direction", "timeout_ms"):
                self.assertEqual(one[member], other[member], member)
            self.assertEqual([[c["name"], c["verdict"], c["limit"]] for c in one["criteria"]],
                             [[c["name"], c["verdict"], c["limit"]] for c in other["criteria"]])
            self.assertEqual(list(one["comparison"]), list(other["comparison"]))

    def test_gates_are_judged_and_said_in_words(self):
        result = self.client.call("check_gates", {"manifest": "gates.yaml"})
        found = self.found(result)
        self.assertEqual((found["verdict"], found["exit_code"]), ("error", 3))
        self.assertEqual([(gate["name"], gate["verdict"]) for gate in found["gates"]], [("flat", "pass"), ("raised", "fail"), ("gone", "error")])
        self.assertNotIn("comparison", found["gates"][0])
        text = result["content"][0]["text"]
        self.assertRegex(text, r"(?m)^FAIL +raised ")
        self.assertRegex(text, r"(?m)^3 gates: 1 pass, 1 fail, ")

    def test_the_foremost_criterion_of_a_gate_comes_first(self):
        self.file("gates.yaml", "version: 1\ngates: [{name: x, candidate: raised.obj, baseline: flat.obj, max_distance: 9, "
                                "max_share_beyond: {distance: 1, share: 1 %}}]\n")
        [gate] = self.found(self.client.call("check_gates", {}))["gates"]
        self.assertEqual([one["verdict"] for one in gate["criteria"]], ["fail", "pass"])

    def test_some_of_the_gates(self):
        found = self.found(self.client.call("check_gates", {"only": ["fl*"]}))
        self.assertEqual((found["verdict"], len(found["gates"])), ("pass", 1))
        self.assertEqual(self.refused(self.client.call("check_gates", {"only": ["flat", "nix"]})),
                         "/only/1: no gate has a name that matches 'nix'")

    def test_mistakes_of_a_manifest_have_their_places(self):
        self.file("wrong.yaml", "version: 1\ngates:\n- {name: x, candidate: flat.obj, baseline: raised.obj, max_distanc: 1}\n")
        self.assertRegex(self.refused(self.client.call("check_gates", {"manifest": "wrong.yaml"})),
                         r"(?m)^wrong\.yaml:3:\d+: unknown key 'max_distanc'; did you mean 'max_distance'\?$")

    def test_a_long_report_leaves_out_gates_that_pass(self):
        lines = ["- {name: %s-%d, candidate: copy.obj, baseline: flat.obj}\n" % ("x" * 190, i) for i in range(1000)]
        self.file("gates.yaml", self.MANIFEST.rsplit("- ", 1)[0] + "".join(lines))
        result = self.client.call("check_gates", {})
        found = self.found(result)
        self.assertLess(len(json.dumps(found)), 2_000_000)
        self.assertEqual(found["left_out"] + len(found["gates"]), 1002)
        self.assertGreater(found["left_out"], 0)
        self.assertIn("raised", [gate["name"] for gate in found["gates"]])
        self.assertEqual(found["counts"]["pass"], 1001)

    def test_a_long_report_is_short_in_words(self):
        lines = ["- {name: %s-%d, candidate: raised.obj, baseline: flat.obj}\n" % ("x" * 190, i) for i in range(300)]
        self.file("gates.yaml", "version: 1\ndefaults: {max_distance: 1 mm}\ngates:\n" + "".join(lines))
        text = self.client.call("check_gates", {})["content"][0]["text"]
        self.assertLess(len(text), 70_000)
        self.assertRegex(text, r"\n\(\d+ lines are left out\)\n300 gates: 300 fail\n$")


if __name__ == "__main__":
    unittest.main()
