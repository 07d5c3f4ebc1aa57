"""A client of `meshgauge mcp`, of the standard library alone, and a folder with meshes for it."""

import contextlib
import json
import pathlib
import subprocess
import tempfile
import threading
import unittest

from harness import BINARY, ENVIRONMENT

PATIENCE = 120  # seconds; no test depends on how soon something comes
PNG = b"\x89PNG\r\n\x1a\n"


class Client:
    """Starts the program. Answers are kept by their ids, notifications and answers to no id in lists."""

    def __init__(self, folder, *flags):
        self.process = subprocess.Popen([BINARY, "mcp", *map(str, flags)], cwd=folder, env=ENVIRONMENT, stdin=subprocess.PIPE,
                                        stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
        self.changed = threading.Condition()
        self.answers, self.notifications, self.unnamed = {}, [], []
        self.ended = False
        self.last_id = 0
        self.reader = threading.Thread(target=self._read, daemon=True)
        self.reader.start()

    def _read(self):
        for line in self.process.stdout:
            message = json.loads(line)
            assert message["jsonrpc"] == "2.0", line
            with self.changed:
                if "method" in message:
                    self.notifications.append(message)
                elif message["id"] is None:
                    self.unnamed.append(message)
                else:
                    self.answers.setdefault(message["id"], []).append(message)
                self.changed.notify_all()
        with self.changed:
            self.ended = True
            self.changed.notify_all()

    def wait_for(self, condition, what):
        with self.changed:
            assert self.changed.wait_for(lambda: condition() or self.ended, PATIENCE) and condition(), what

    def send_bytes(self, data):
        self.process.stdin.write(data)
        self.process.stdin.flush()

    def send(self, message):
        self.send_bytes(json.dumps({"jsonrpc": "2.0", **message}).encode() + b"\n")

    def notify(self, method, params=None):
        self.send({"method": method, "params": params or {}})

    def begin(self, method, params=None, id_=None):
        """Sends a request and returns its id."""
        if id_ is None:
            self.last_id += 1
            id_ = self.last_id
        self.send({"id": id_, "method": method, **({} if params is None else {"params": params})})
        return id_

    def answer(self, id_):
        """The next answer to this id."""
        self.wait_for(lambda: self.answers.get(id_), f"no answer to {id_}")
        return self.answers[id_].pop(0)

    def ask(self, method, params=None, id_=None):
        return self.answer(self.begin(method, params, id_))

    def result(self, method, params=None):
        answer = self.ask(method, params)
        assert "result" in answer, answer
        return answer["result"]

    def begin_call(self, tool, arguments, id_=None, token=None):
        meta = {} if token is None else {"_meta": {"progressToken": token}}
        return self.begin("tools/call", {"name": tool, "arguments": arguments, **meta}, id_)

    def call(self, tool, arguments):
        return self.result("tools/call", {"name": tool, "arguments": arguments})

    def initialize(self, revision="2025-06-18"):
        result = self.result("initialize", {"protocolVersion": revision, "capabilities": {}, "clientInfo": {"name": "test", "version": "1"}})
        self.notify("notifications/initialized")
        return result

    def unnamed_error(self):
        """The next answer to a message whose id is not known."""
        self.wait_for(lambda: self.unnamed, "no answer to a broken message")
        return self.unnamed.pop(0)["error"]

    def close(self):
        """Closes standard input; returns the exit code."""
        self.process.stdin.close()
        return self.process.wait(PATIENCE)

    def kill(self):
        self.process.kill()
        self.process.wait(PATIENCE)
        self.reader.join(PATIENCE)
        self.process.stdout.close()
        with contextlib.suppress(BrokenPipeError):  # of what was not taken
            self.process.stdin.close()


def square(height=0.0):
    """A square of size 1 in the plane z = height, as an OBJ."""
    corners = "".join("v %r %r %r\n" % (x, y, height) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1)))
    return (corners + "f 1 2 3\nf 1 3 4\n").encode()


def cube(size=1.0):
    """A closed cube, as an OBJ."""
    corners = "".join("v %r %r %r\n" % (x * size, y * size, z * size) for z in (0, 1) for y in (0, 1) for x in (0, 1))
    faces = "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n"
    return (corners + faces).encode()


class Session(unittest.TestCase):
    """A folder with flat.obj, raised.obj (2 above it) and cube.obj, and a client whose root it is."""

    flags = ()

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name).resolve()
        self.file("flat.obj", square())
        self.file("raised.obj", square(2.0))
        self.file("cube.obj", cube())
        self.client = self.start(*self.flags)

    def start(self, *flags):
        client = Client(self.folder, *flags)
        self.addCleanup(client.kill)
        return client

    def file(self, name, data):
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data if isinstance(data, bytes) else data.encode())
        return str(path)

    def compare(self, a="raised.obj", b="flat.obj", **more):
        return self.client.call("compare_meshes", {"a": {"path": a}, "b": {"path": b}, **more})

    def found(self, result):
        """What a call found; the same stands there as text."""
        self.assertFalse(result["isError"], result["content"])
        self.assertEqual(json.loads(result["content"][1]["text"]), result["structuredContent"])
        return result["structuredContent"]

    def refused(self, result):
        """Why a call found nothing."""
        self.assertTrue(result["isError"], result)
        self.assertNotIn("structuredContent", result)
        [content] = result["content"]
        return content["text"]
