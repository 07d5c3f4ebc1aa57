"""Calls of `meshgauge mcp` beside each other, that are cancelled, and whose client goes away."""

import base64
import json
import subprocess
import unittest

from client import PATIENCE, Session
from harness import BINARY, ENVIRONMENT, SLOW, flat_grid

PING = b'{"jsonrpc":"2.0","id":1,"method":"ping"}\n'
HARD = {"strategy": "four_point", "tolerance": {"absolute": 0}, "timeout": 100}  # runs for at least ten seconds


def inline(data):
    return {"base64": base64.b64encode(data).decode(), "name": "x.obj"}


class Many(Session):
    def setUp(self):
        super().setUp()
        for name in "ab":
            self.file(name + ".obj", SLOW[name])

    def begin_slow(self, id_=None, token="slow"):
        arguments = {"a": {"path": "a.obj"}, "b": {"path": "b.obj"}, "options": HARD}
        return self.client.begin_call("compare_meshes", arguments, id_, token)

    def wait_for_progress(self, token):
        self.client.wait_for(lambda: any(one["params"]["progressToken"] == token for one in self.client.notifications), "no progress")

    def test_twenty_calls_at_once(self):
        grid = flat_grid(12).decode()
        begun = {}
        for i in range(20):
            raised = "\n".join(line + str(i) if line.startswith("v ") else line for line in grid.split("\n"))  # z is 0 .. 019
            limit = 0.5 if i % 2 else 50
            arguments = {"a": inline(raised.encode()), "b": inline(grid.encode()), "options": {"max_distance": limit}, "picture": False}
            begun[self.client.begin_call("compare_meshes", arguments)] = (i, limit)
            begun[self.client.begin_call("inspect_mesh", {"mesh": inline(raised.encode())})] = (i, None)
        for id_, (i, limit) in begun.items():
            found = self.found(self.client.answer(id_)["result"])
            if limit is None:
                self.assertEqual((found["triangles"], found["bbox"]["high"][2]), (288, i))
            else:
                self.assertEqual(found["verdict"], "pass" if i <= limit else "fail", i)
                self.assertTrue(found["distance"]["lower"] <= i <= found["distance"]["upper"] or i > limit, (i, found["distance"]))

    def test_everything_else_is_answered_while_calls_run(self):
        for i in range(8):
            self.begin_slow(f"slow-{i}", f"t{i}")
        self.wait_for_progress("t0")
        self.assertEqual(self.client.ask("ping")["result"], {})
        self.assertEqual(len(self.client.result("tools/list")["tools"]), 3)
        self.assertEqual(self.client.close(), 0)

    def test_a_cancelled_call_ends_and_gets_no_answer(self):
        self.begin_slow("x")
        self.wait_for_progress("slow")
        refused = self.client.ask("tools/call", {"name": "inspect_mesh", "arguments": {"mesh": {"path": "cube.obj"}}}, "x")
        self.assertEqual(refused["error"]["code"], -32600)  # while it runs
        self.client.notify("notifications/cancelled", {"requestId": "x", "reason": "test"})
        while True:  # when it has ended the id is free again
            answer = self.client.ask("tools/call", {"name": "inspect_mesh", "arguments": {"mesh": {"path": "cube.obj"}}}, "x")
            if "result" in answer:
                break
            self.assertEqual(answer["error"]["code"], -32600)
        self.assertEqual(self.found(answer["result"])["triangles"], 12)
        self.assertEqual(self.client.answers["x"], [])

    def test_a_cancelled_call_that_waits_does_not_begin(self):
        first = [self.begin_slow(f"slow-{i}", f"t{i}") for i in range(200)]
        for id_ in first:
            self.client.notify("notifications/cancelled", {"requestId": id_})
        self.assertEqual(self.found(self.client.call("inspect_mesh", {"mesh": {"path": "cube.obj"}}))["triangles"], 12)
        self.assertTrue(all(not answers for id_, answers in self.client.answers.items() if id_ in first))

    def test_too_many_calls(self):
        ids = [self.begin_slow(f"slow-{i}", f"t{i}") for i in range(300)]
        self.client.wait_for(lambda: sum(len(self.client.answers.get(id_, [])) for id_ in ids) >= 300 - 256, "no call was refused")
        for id_ in ids:
            for answer in self.client.answers.get(id_, []):
                self.assertEqual(answer["error"]["code"], -32000)
        self.assertEqual(self.client.close(), 0)

    def test_gates_are_cancelled(self):
        self.file("gates.yaml", "version: 1\ngates: [{name: x, candidate: a.obj, baseline: b.obj, max_distance: 0, strategy: four_point, timeout: 100 s}]\n")
        self.client.begin_call("check_gates", {}, "gates")
        self.client.notify("notifications/cancelled", {"requestId": "gates"})
        while "result" not in self.client.ask("tools/call", {"name": "inspect_mesh", "arguments": {"mesh": {"path": "cube.obj"}}}, "gates"):
            pass
        self.assertEqual(self.client.close(), 0)

    def test_a_client_that_goes_away_in_mid_call(self):
        for i in range(4):
            self.begin_slow(f"slow-{i}", f"t{i}")
        self.wait_for_progress("t0")
        self.assertEqual(self.client.close(), 0)

    def test_a_client_that_reads_nothing_and_ends(self):
        with subprocess.Popen([BINARY, "mcp"], cwd=self.folder, env=ENVIRONMENT, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                              stderr=subprocess.DEVNULL) as process:
            self.addCleanup(process.kill)
            for _ in range(100):  # more answers than a pipe holds
                process.stdin.write(b'{"jsonrpc":"2.0","id":1,"method":"tools/list"}\n')
            process.stdin.close()
            self.assertEqual(process.wait(PATIENCE), 0)

    def test_a_client_that_no_longer_reads(self):
        with subprocess.Popen([BINARY, "mcp"], cwd=self.folder, env=ENVIRONMENT, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                              stderr=subprocess.DEVNULL) as process:
            self.addCleanup(process.kill)
            process.stdin.write(PING)
            process.stdin.flush()
            self.assertEqual(json.loads(process.stdout.readline())["result"], {})
            process.stdout.close()
            process.stdin.write(PING)
            process.stdin.flush()
            self.assertEqual(process.wait(PATIENCE), 0)


if __name__ == "__main__":
    unittest.main()
