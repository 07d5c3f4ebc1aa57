"""What `meshgauge mcp` makes of broken messages, and of clients that want more than they may have."""

import base64
import json
import os
import pathlib
import tempfile
import unittest

from client import Session, square

MEGABYTE = b"x" * (1 << 20)
DEEP = b'{"jsonrpc":"2.0","id":9,"method":"ping","params":' + b'{"a":' * 40 + b"1" + b"}" * 40 + b"}"
GATE = "version: 1\ngates: [{name: x, candidate: '%s', baseline: '%s', max_distance: 1, unmatched_baselines: ignore}]\n"


class Messages(Session):
    def error(self, data):
        self.client.send_bytes(data + b"\n")
        return self.client.unnamed_error()

    def code(self, data):
        return self.error(data)["code"]

    def test_what_is_no_json(self):
        for data in (b"{", b"nonsense", b'{"id":1,}', b"\xff\xfe", b"[1,", b'{"a":"\xc3"}', b'"\\ud800"', b"{}\0", b"\0", b'{"jsonrpc": "2.0"} {}'):
            self.assertEqual(self.code(data), -32700, data)

    def test_what_is_no_message(self):
        for data in (b"1", b"null", b'"x"', b"{}", b'{"jsonrpc":"2.0"}', b'{"jsonrpc":"1.0","method":"ping"}', b'{"method":"ping"}',
                     b'{"jsonrpc":"2.0","method":5}', b'{"jsonrpc":"2.0","id":null,"method":"ping"}', b'{"jsonrpc":"2.0","id":1.5,"method":"ping"}',
                     b'{"jsonrpc":"2.0","id":[],"method":"ping"}', b'{"jsonrpc":"2.0","id":"' + b"i" * 300 + b'","method":"ping"}'):
            self.assertEqual(self.code(data), -32600, data)

    def test_batches_are_refused(self):
        one = b'{"jsonrpc":"2.0","id":1,"method":"ping"}'
        for data in (b"[]", b"[1]", b"[" + one + b"," + one + b"]"):
            self.assertEqual(self.code(data), -32600, data)
        self.assertEqual(self.client.answers, {})

    def test_a_broken_message_of_a_known_id_is_refused_under_it(self):
        broken = [(b'{"jsonrpc":"1.0","id":9,"method":"ping"}', -32600), (b'{"jsonrpc":"2.0","id":9}', -32600), (DEEP, -32600),
                  (b'{"jsonrpc":"2.0","id":9,"method":"ping","method":"ping"}', -32600), (b'{"jsonrpc":"2.0","id":9,"method":"ping","params":[]}', -32602),
                  (b'{"jsonrpc":"2.0","id":9,"method":"pong"}', -32601), (b'{"jsonrpc":"2.0","id":9,"method":"resources/list"}', -32601)]
        for data, code in broken:
            self.client.send_bytes(data + b"\n")
            self.assertEqual(self.client.answer(9)["error"]["code"], code, data)

    def test_notifications_and_answers_get_no_answer(self):
        for message in ({"method": "notifications/initialized"}, {"method": "notifications/nothing", "params": []}, {"method": "ping"},
                        {"method": "tools/call", "params": {"name": "none"}}, {"id": 3, "result": {}}, {"id": 3, "error": {"code": 1, "message": ""}},
                        {"id": None, "error": {"code": 1, "message": ""}},
                        {"method": "notifications/cancelled", "params": {"requestId": 99}}, {"method": "notifications/cancelled"}):
            self.client.send(message)
        self.client.send_bytes(b"\n \r\n")
        self.assertEqual(self.client.ask("ping")["result"], {})
        self.assertEqual((len(self.client.unnamed), self.client.answers, self.client.notifications), (0, {1: []}, []))

    def test_calls_that_name_no_tool(self):
        for params in ({}, {"name": 5}, {"name": "measure"}, {"name": "compare_meshes", "arguments": []}):
            self.assertEqual(self.client.ask("tools/call", params)["error"]["code"], -32602, params)
        self.assertEqual(self.client.ask("tools/list", {"cursor": "x"})["error"]["code"], -32602)
        self.assertEqual(self.client.ask("initialize", {})["error"]["code"], -32602)
        self.assertIn("'measure'; known: compare_meshes, ", self.client.ask("tools/call", {"name": "measure"})["error"]["message"])

    def test_errors_say_no_more_of_a_message_than_is_needed(self):
        self.assertLess(len(json.dumps(self.error(b'{"a": "' + MEGABYTE))), 1000)
        answer = self.client.ask("x" * (1 << 20))
        self.assertLess(len(json.dumps(answer)), 1000)

    def test_a_message_that_is_too_long_is_refused_and_not_kept(self):
        head, tail = b'{"jsonrpc":"2.0","method":"tools/call","params":{"id":1,"x":"', b'"},"id":77}\n'
        self.client.send_bytes(head)
        for _ in range(300):
            self.client.send_bytes(MEGABYTE)
        self.client.send_bytes(tail)
        self.assertEqual(self.client.answer(77)["error"]["code"], -32600)
        self.assertEqual(self.client.ask("ping")["result"], {})
        if "MESHGAUGE_SANITIZED" not in os.environ:
            status = pathlib.Path(f"/proc/{self.client.process.pid}/status").read_text()
            peak_kb = int(status.split("VmHWM:")[1].split()[0])
            self.assertLess(peak_kb, 200_000)

    def test_nor_is_one_without_an_end(self):
        for _ in range(60):
            self.client.send_bytes(MEGABYTE)
        self.client.process.stdin.close()
        self.assertEqual(self.client.unnamed_error()["code"], -32600)
        self.assertEqual(self.client.process.wait(), 0)


class Arguments(Session):
    def mistakes(self, tool, arguments):
        return self.refused(self.client.call(tool, arguments)).split("\n")

    def test_every_mistake_is_named_with_its_pointer(self):
        said = self.mistakes("compare_meshes", {"a": {"path": 5}, "c": {}, "picture": "yes", "options": {
            "max_distance": "5 parsec", "directon": "a_to_b", "regions": [{"name": "x", "box": {"min": [0, 0, "0"], "max": [1, 1, 1]}}]}})
        for pointer in ("/a/path", "/b", "/c", "/picture", "/options/max_distance", "/options/directon", "/options/regions/0/box/min/2"):
            self.assertTrue(any(line.startswith(pointer + " ") or line.startswith(pointer + ": ") for line in said), (pointer, said))
        self.assertTrue(any("did you mean 'direction'?" in line for line in said))

    def test_meshes_that_are_none(self):
        flat = {"path": "flat.obj"}
        for a, words in ((5, "/a must be an object"), ({}, "/a must have a path or base64"), ({"path": "flat.obj", "base64": ""}, "one of both"),
                         ({"path": "flat.obj", "name": "x"}, "/a/name goes with base64"), ({"path": ""}, "/a/path is empty"),
                         ({"base64": "????"}, "must be base64"), ({"base64": "QQ="}, "must be base64"), ({"base64": "QQ==QQ=="}, "must be base64"),
                         ({"base64": "=QQQ"}, "must be base64"), ({"base64": 7}, "/a/base64 must be a text"), ({"base64": ""}, "empty"),
                         ({"base64": "QQ==", "name": "x\ny"}, "without control characters"), ({"path": "none.obj"}, "No such file"),
                         ({"path": "flat.obj\0"}, "has a control character"), ({"path": "."}, "names a folder")):
            self.assertIn(words, " ".join(self.mistakes("compare_meshes", {"a": a, "b": flat})), a)

    def test_limits_of_what_is_asked(self):
        pair = {"a": {"path": "flat.obj"}, "b": {"path": "raised.obj"}}
        for options, words in (({"timeout": "1 h"}, "timeout"), ({"timeout": 181}, "timeout"), ({"timeout_ms": 5}, "unknown option"),
                               ({"budget": {}}, "unknown option"), ({"gate": {"max_distance": 1}}, "unknown option"), ({"threads": 100}, "from 1 to 64"),
                               ([], "must be an object"), (5, "must be an object")):
            self.assertIn(words, " ".join(self.mistakes("compare_meshes", {**pair, "options": options})), options)

    def test_a_mesh_inside_of_a_message_has_a_limit(self):
        large = base64.b64encode(b"# " + bytes(17 << 20)).decode()
        said = self.mistakes("inspect_mesh", {"mesh": {"base64": large}})
        self.assertEqual(said, ["/mesh/base64 has more than 16777216 bytes: write the mesh to a file below a root, and give its path"])

    def test_counts_that_a_file_cannot_hold(self):
        bomb = b"ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\nproperty float x\nproperty float y\nproperty float z\nend_header\n"
        self.assertTrue(self.client.call("inspect_mesh", {"mesh": {"base64": base64.b64encode(bomb).decode()}})["isError"])

    def test_other_tools(self):
        self.assertIn("/mesh is missing", self.mistakes("inspect_mesh", {})[0])
        self.assertIn("/unit must be a unit", self.mistakes("inspect_mesh", {"mesh": {"path": "flat.obj"}, "unit": "league"})[0])
        for arguments, words in (({"manifest": 5}, "/manifest must be a text"), ({"only": []}, "/only must be an array"),
                                 ({"only": [""]}, "/only/0 is empty"), ({"comparisons": 1}, "/comparisons must be true or false"),
                                 ({"server": "http://x"}, "unknown argument 'server'")):
            self.assertIn(words, " ".join(self.mistakes("check_gates", arguments)), arguments)


class Roots(Session):
    """The root is the folder "in"; "out" beside it has a file that must not be read."""

    flags = ("--root", "in")

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name).resolve()
        for name in ("in/flat.obj", "out/secret.obj", "inner/secret.obj"):
            self.file(name, square())
        self.client = self.start(*self.flags)

    def why_not(self, path):
        return self.refused(self.client.call("inspect_mesh", {"mesh": {"path": path}}))

    def test_paths_below_the_root(self):
        for path in ("flat.obj", "./flat.obj", str(self.folder / "in/flat.obj")):
            self.found(self.client.call("inspect_mesh", {"mesh": {"path": path}}))

    def test_paths_that_lead_out(self):
        for path in ("../out/secret.obj", "sub/../../out/secret.obj", "..", "./../out/secret.obj"):
            self.assertIn("has '..'", self.why_not(path), path)
        for path in (str(self.folder / "out/secret.obj"), str(self.folder / "inner/secret.obj"), "/etc/passwd", "/proc/self/environ", "/dev/zero", "/"):
            self.assertRegex(self.why_not(path), "is outside of the folders|names a folder", path)

    def test_symbolic_links(self):
        (self.folder / "in/link.obj").symlink_to(self.folder / "out/secret.obj")
        (self.folder / "in/inner.obj").symlink_to("flat.obj")
        (self.folder / "in/folder").symlink_to(self.folder / "out")
        (self.folder / "in/up").symlink_to("..")
        for path in ("link.obj", "inner.obj", "folder/secret.obj", "up/out/secret.obj", "up/in/flat.obj"):
            self.assertIn("is a symbolic link or lies behind one, which is not followed", self.why_not(path), path)

    def test_what_is_no_file(self):
        os.mkfifo(self.folder / "in/pipe.obj")
        (self.folder / "in/folder.obj").mkdir()
        self.assertIn("is not a regular file", self.why_not("pipe.obj"))
        self.assertIn("is a folder", self.why_not("folder.obj"))

    def test_files_that_a_gltf_names(self):
        def scene(uri):
            return json.dumps({"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
                               "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
                               "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
                               "bufferViews": [{"buffer": 0, "byteLength": 36}], "buffers": [{"byteLength": 36, "uri": uri}]})

        self.file("out/x.bin", bytes(36))
        self.file("in/sub/x.bin", bytes(36))
        (self.folder / "in/sub/link.bin").symlink_to(self.folder / "out/x.bin")
        self.file("in/sub/good.gltf", scene("x.bin"))
        self.found(self.client.call("inspect_mesh", {"mesh": {"path": "sub/good.gltf"}}))
        for uri, words in (("../../out/x.bin", "has '..'"), ("../sub/x.bin", "has '..'"), ("link.bin", "symbolic link"),
                           (str(self.folder / "out/x.bin"), "is absolute"), ("file:///etc/passwd", "has a scheme"), ("http://x/", "has a scheme")):
            self.file("in/sub/bad.gltf", scene(uri))
            self.assertIn(words, self.why_not("sub/bad.gltf"), uri)
        inline = base64.b64encode(scene("x.bin").encode()).decode()
        self.assertTrue(self.client.call("inspect_mesh", {"mesh": {"base64": inline, "name": "sub/x.gltf"}})["isError"])

    def why_no_gates(self, manifest="gates.yaml"):
        return self.refused(self.client.call("check_gates", {"manifest": manifest}))

    def test_files_that_a_manifest_names(self):
        self.file("in/base/flat.obj", square())
        (self.folder / "in/link").symlink_to(self.folder / "out")
        out = str(self.folder / "out")
        for candidate, baseline in (("../out/secret.obj", "base/flat.obj"), (out + "/secret.obj", "base/flat.obj"), ("../out/*.obj", "base/flat.obj"),
                                    (out + "/*.obj", "base/flat.obj"), ("flat.obj", "../out/secret.obj"), ("flat.obj", out + "/secret.obj")):
            self.file("in/gates.yaml", GATE % (candidate, baseline))
            self.assertIn("may lead out of the folders that may be read", self.why_no_gates(), candidate)
        for candidate in ("link/*.obj", "*/secret.obj"):
            self.file("in/gates.yaml", GATE % (candidate, "base/flat.obj"))
            said = self.why_no_gates()
            self.assertIn("symbolic link", said)
            self.assertNotIn("link/secret.obj", said)
        for candidate, baseline in (("link/secret.obj", "base/flat.obj"), ("flat.obj", "link/secret.obj")):
            self.file("in/gates.yaml", GATE % (candidate, baseline))
            [gate] = self.found(self.client.call("check_gates", {}))["gates"]
            self.assertEqual(gate["verdict"], "error")
            self.assertIn("symbolic link", gate["error"]["message"])

    def test_manifests_elsewhere(self):
        self.file("out/gates.yaml", GATE % ("secret.obj", "secret.obj"))
        (self.folder / "in/link.yaml").symlink_to(self.folder / "out/gates.yaml")
        self.assertIn("has '..'", self.why_no_gates("../out/gates.yaml"))
        self.assertIn("is outside of the folders", self.why_no_gates(str(self.folder / "out/gates.yaml")))
        self.assertIn("symbolic link", self.why_no_gates("link.yaml"))
        self.assertIn("No such file", self.why_no_gates("none.yaml"))
        self.file("in/large.yaml", b"#" * (2 << 20))
        self.assertIn("is larger than", self.why_no_gates("large.yaml"))

    def test_several_roots(self):
        client = self.start("--root", str(self.folder / "in"), "--root=out")
        for path in ("flat.obj", "secret.obj", str(self.folder / "out/secret.obj")):
            self.assertFalse(client.call("inspect_mesh", {"mesh": {"path": path}})["isError"], path)
        self.assertTrue(client.call("inspect_mesh", {"mesh": {"path": str(self.folder / "inner/secret.obj")}})["isError"])

    def test_a_root_that_is_no_folder(self):
        self.assertEqual(self.start("--root", "none").process.wait(), 3)


if __name__ == "__main__":
    unittest.main()
