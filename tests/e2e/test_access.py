"""Bearer keys, their limits and their reload; headers for browsers; which clients are served without keys."""

import json
import os
import pty
import signal
import subprocess
import tempfile
import time
import unittest
from pathlib import Path

from harness import BINARY, ENVIRONMENT, OWN_DATA, Server, comparison, post_head, read_answer, until
from keys import new_key


class Keys(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.path = Path(folder.name) / "keys.json"

    def write(self, *entries):
        self.path.write_text(json.dumps({"keys": entries}))

    def start(self, *flags):
        server = Server("--keys-file", str(self.path), *flags)
        self.addCleanup(server.stop)
        return server

    def get(self, server, path, token=None, method="GET", extra=""):
        extra += "Authorization: Bearer %s\r\n" % token if token else ""
        return server.get(path, method, extra)

    def compare(self, server, token):
        body = comparison()
        return server.raw(post_head(len(body), "Authorization: Bearer %s\r\n" % token) + body)

    def refused(self, answer, status, slug):
        self.assertEqual(answer.status, status, answer.body)
        self.assertEqual(answer.json()["type"], "/problems/" + slug)

    def test_a_key_opens_what_its_scopes_name(self):
        token, entry = new_key("ci")
        other, metrics = new_key("prometheus", "--scope", "metrics")
        self.write(entry, metrics)
        server = self.start()
        self.assertEqual(self.compare(server, token).status, 200)
        self.refused(self.compare(server, other), 403, "forbidden")
        self.refused(self.get(server, "/metrics", token), 403, "forbidden")
        self.assertNotIn(self.get(server, "/metrics", other).status, (401, 403))
        for path in ("/", "/healthz", "/openapi.yaml"):
            self.assertEqual(server.get(path).status, 200)
        for path in ("/v1/comparisons", "/metrics", "/none"):
            answer = server.get(path)
            self.refused(answer, 401, "unauthorized")
            self.assertEqual(answer.headers["www-authenticate"], 'Bearer realm="meshgauge"')
            answer = self.get(server, path, token[:-1])
            self.refused(answer, 401, "unauthorized")
            self.assertIn('error="invalid_token"', answer.headers["www-authenticate"])

    def test_a_stranger_is_refused_before_the_body_is_read(self):
        self.write(new_key("ci")[1])
        server = self.start()
        with server.connect() as connection:
            connection.sendall(post_head(1 << 20, "Expect: 100-continue\r\n"))
            stream = connection.makefile("rb")
            self.refused(read_answer(stream), 401, "unauthorized")
            self.assertEqual(stream.read(), b"")  # what follows would be taken for a request

    def test_two_keys_in_one_request_are_none(self):
        token, entry = new_key("ci")
        self.write(entry)
        server = self.start()
        twice = "Authorization: Bearer %s\r\n" % token
        self.refused(self.get(server, "/none", token, extra=twice), 400, "malformed-request")

    def test_expired_and_disabled_keys(self):
        late, old = new_key("late", expires="2020-01-01T00:00:00Z")
        off, disabled = new_key("off", disabled=True)
        self.write(old, disabled)
        server = self.start()
        bodies = {self.get(server, "/none", token).body for token in (late, off, "mg_" + "0" * 64)}
        self.assertEqual(len(bodies), 1)

    def test_the_rate_of_one_key_is_not_the_others(self):
        token, entry = new_key("ci", requests_per_minute=6, burst=3)
        other, second = new_key("other")
        self.write(entry, second)
        server = self.start()
        self.assertEqual([self.get(server, "/none", token).status for _ in range(3)], [404] * 3)
        answer = self.get(server, "/none", token)
        self.refused(answer, 429, "too-many-requests")
        self.assertIn(int(answer.headers["retry-after"]), range(1, 11))
        self.assertEqual(self.get(server, "/none", other).status, 404)
        self.assertEqual(server.get("/healthz").status, 200)

    def test_reload(self):
        token, entry = new_key("ci", burst=1, requests_per_minute=1)
        self.write(entry)
        server = self.start()
        self.assertEqual(self.get(server, "/none", token).status, 404)
        self.path.write_text('{"keys": [{"id": "ci", "id": "ci"}]}')
        self.reload(server, "/keys/0/id: the key 'id' occurs twice")
        self.refused(self.get(server, "/none", token), 429, "too-many-requests")  # the old file and its bucket
        other, second = new_key("other")
        self.write(entry, second)
        self.reload(server, "keys: 2")
        self.refused(self.get(server, "/none", token), 429, "too-many-requests")
        self.assertEqual(self.get(server, "/none", other).status, 404)
        self.write(second)
        self.reload(server, "keys: 1")
        self.refused(self.get(server, "/none", token), 401, "unauthorized")
        self.assertEqual(server.stop(), 0)

    def reload(self, server, saying):
        server.process.send_signal(signal.SIGHUP)
        until(lambda: any('"reload"' in line and saying in line for line in list(server.log)))

    def test_the_log_names_the_key_and_never_the_token(self):
        token, entry = new_key("ci")
        self.write(entry)
        server = self.start()
        self.get(server, "/none", token)
        self.get(server, "/none", "x" * 40)
        self.assertEqual(server.stop(), 0)
        log = "".join(server.log)
        self.assertIn('"key":"ci"', log)
        self.assertNotIn(token, log)
        self.assertNotIn("x" * 40, log)
        self.assertIn("sent unencrypted", log)  # there is no TLS

    def test_a_bad_file_ends_the_start(self):
        for text, saying in (("{}", "the one field 'keys'"), ('{"keys": [1]}', "/keys/0: must be an object"),
                             ("{\n\n,}", "line 3: not JSON"), ('{"keys": []}', "chmod go-w")):
            self.path.write_text(text)
            self.path.chmod(0o666 if saying == "chmod go-w" else 0o600)
            done = subprocess.run([BINARY, "serve", "--port", "0", "--keys-file", str(self.path)], capture_output=True,
                                  text=True, timeout=60, env=OWN_DATA)
            self.assertEqual(done.returncode, 3)
            self.assertIn(saying, done.stderr)

    def test_hash_is_that_of_the_file(self):
        token, entry = new_key("ci")
        done = subprocess.run([BINARY, "keys", "hash"], input=token + "\n", capture_output=True, text=True)
        self.assertEqual(done.stdout.strip(), entry["sha256"])
        done = subprocess.run([BINARY, "keys", "hash"], input="hunter2\n", capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stdout), (3, ""))
        self.assertNotEqual(new_key("ci")[0], token)


class Openness(unittest.TestCase):
    def test_a_public_address_needs_keys_or_a_word(self):
        done = subprocess.run([BINARY, "serve", "--host", "0.0.0.0", "--port", "0"], capture_output=True, text=True,
                              timeout=60, env=OWN_DATA)
        self.assertEqual(done.returncode, 3)
        self.assertIn("--public-without-keys", done.stderr)
        for flags, environment in ((["--public-without-keys"], {}), ([], {"MESHGAUGE_PUBLIC_WITHOUT_KEYS": "true"})):
            server = Server("--host", "0.0.0.0", *flags, environment=environment)
            self.addCleanup(server.stop)
            self.assertEqual(server.compare().status, 200)

    def test_the_refusal_of_a_public_address_comes_before_all_else(self):
        """Also where the port and the data directory are another service's: nothing is bound, opened or waited for."""
        other = Server()
        self.addCleanup(other.stop)
        for host in ("0.0.0.0", "::"):
            done = subprocess.run([BINARY, "serve", "--host", host, "--port", str(other.port)], capture_output=True, text=True, timeout=60,
                                  env={**ENVIRONMENT, "MESHGAUGE_DATA_DIR": os.path.join(other.data_dir.name, "data")})
            self.assertEqual(done.returncode, 3)
            self.assertIn(f"other machines can reach {host}: give --keys-file, or --public-without-keys", done.stderr)
            self.assertNotIn("cannot listen", done.stderr)

    def test_with_keys_it_may_be_public(self):
        with tempfile.NamedTemporaryFile("w") as file:
            file.write('{"keys": []}')
            file.flush()
            server = Server("--host", "0.0.0.0", "--keys-file", file.name)
            self.addCleanup(server.stop)
            self.assertEqual(server.compare().status, 401)

    def test_loopback_has_several_names(self):
        for host in ("localhost", "127.0.0.2"):
            server = Server("--host", host)
            self.assertEqual(server.stop(), 0)

    def test_a_reload_without_anything_to_read_does_no_harm(self):
        server = Server()
        server.process.send_signal(signal.SIGHUP)
        until(lambda: any('"reload"' in line for line in list(server.log)))
        self.assertEqual(server.compare().status, 200)
        self.assertEqual(server.stop(), 0)


class Sites(unittest.TestCase):
    """Pages of other sites, of which a service without keys hears from the browsers of this machine."""

    def start(self, *flags):
        server = Server(*flags)
        self.addCleanup(server.stop)
        return server

    def ask(self, server, method, path, host, extra=""):
        return server.raw(("%s %s HTTP/1.1\r\nHost: %s\r\nContent-Length: 0\r\n%s\r\n" % (method, path, host, extra)).encode())

    def foreign(self, answer):
        self.assertEqual(answer.status, 403, answer.body)
        self.assertEqual(answer.json()["type"], "/problems/foreign-request")

    def test_a_name_that_is_made_to_resolve_here_is_refused(self):
        server = self.start()
        for method, path in (("GET", "/v1/comparisons/" + "0" * 32), ("DELETE", "/v1/meshes/" + "0" * 64), ("GET", "/metrics"),
                             ("POST", "/v1/meshes")):
            self.foreign(self.ask(server, method, path, "attacker.example:%d" % server.port))
            for own in ("localhost", "127.0.0.1", "[::1]"):
                self.assertNotEqual(self.ask(server, method, path, "%s:%d" % (own, server.port)).status, 403)
            for neither in ("[::1].attacker.example", "localhost:x.attacker.example", "x@localhost"):
                self.assertEqual(self.ask(server, method, path, neither).status, 400)
        for path in ("/healthz", "/readyz", "/openapi.yaml"):
            self.assertEqual(self.ask(server, "GET", path, "attacker.example").status, 200)

    def test_the_name_in_a_target_counts(self):
        server = self.start()
        self.foreign(self.ask(server, "GET", "http://attacker.example/metrics", "localhost"))
        self.assertEqual(self.ask(server, "GET", "http://localhost:%d/metrics" % server.port, "attacker.example").status, 200)

    def test_a_form_of_another_site_starts_nothing(self):
        server = self.start()
        body = comparison()
        for origin in ("https://attacker.example", "http://localhost:1", "null"):
            self.foreign(server.compare(extra="Origin: %s\r\n" % origin))
            self.foreign(server.raw(post_head(len(body), "Origin: %s\r\nExpect: 100-continue\r\n" % origin)))
        own = post_head(len(body), "Origin: http://localhost:%d\r\n" % server.port)
        own = own.replace(b"Host: localhost\r\n", b"Host: localhost:%d\r\n" % server.port)
        self.assertEqual(server.raw(own + body).status, 200)
        self.assertEqual(server.compare().status, 200)  # as curl asks

    def test_names_and_origins_that_are_set_are_allowed(self):
        server = self.start("--allowed-hosts", "gauge.example", "--cors-origins", "https://viewer.example")
        self.assertEqual(self.ask(server, "GET", "/none", "gauge.example").status, 404)
        self.assertEqual(self.ask(server, "DELETE", "/none", "gauge.example", "Origin: https://gauge.example\r\n").status, 404)
        self.assertEqual(server.compare(extra="Origin: https://viewer.example\r\n").status, 200)

    def test_with_keys_no_name_is_foreign(self):
        token, entry = new_key("ci")
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "keys.json"
            path.write_text(json.dumps({"keys": [entry]}))
            server = self.start("--keys-file", str(path))
            answer = self.ask(server, "GET", "/none", "gauge.example", "Authorization: Bearer %s\r\n" % token)
            self.assertEqual(answer.status, 404)


class Terminal(unittest.TestCase):
    def start(self, ignore):
        """The service as the only program on a terminal; gives its process id and the terminal's other end."""
        child, terminal = pty.fork()
        if child == 0:
            if ignore:
                signal.signal(signal.SIGHUP, signal.SIG_IGN)
            os.execve(BINARY, [BINARY, "serve", "--port", "0"], OWN_DATA)
        self.addCleanup(lambda: [os.kill(child, signal.SIGKILL), os.waitpid(child, 0)] if not self.ended else None)
        self.ended = False
        lines = b""
        while b"listening" not in lines or not lines.endswith(b"\n"):
            lines += os.read(terminal, 4096)
        start = next(line for line in map(json.loads, lines.splitlines()) if line["event"] == "listening")
        return child, terminal, int(start["detail"].rsplit(":", 1)[1])

    def end(self, child):
        code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        self.ended = True
        return code

    def test_a_closed_terminal_ends_the_service(self):
        child, terminal, _ = self.start(ignore=False)
        os.close(terminal)
        self.assertEqual(self.end(child), 0)

    def test_but_not_when_it_was_started_by_nohup(self):
        child, terminal, port = self.start(ignore=True)
        os.close(terminal)
        time.sleep(0.5)
        self.assertEqual(subprocess.run([BINARY, "health", "--port", str(port)], env=ENVIRONMENT).returncode, 0)
        os.kill(child, signal.SIGTERM)
        self.assertEqual(self.end(child), 0)


class Browsers(unittest.TestCase):
    ASK = "Origin: %s\r\nAccess-Control-Request-Method: POST\r\n"

    def test_no_page_may_read_by_default(self):
        server = Server()
        self.addCleanup(server.stop)
        answer = server.get("/healthz", extra="Origin: https://a.example\r\n")
        self.assertNotIn("access-control-allow-origin", answer.headers)
        self.assertEqual(server.get("/v1/comparisons", "OPTIONS", self.ASK % "https://a.example").status, 405)

    def test_named_origins_may(self):
        server = Server("--cors-origins", "https://a.example,https://b.example")
        self.addCleanup(server.stop)
        with server.connect() as connection:  # nothing but a head in the answer, and the connection lives on
            stream = connection.makefile("rb")
            for _ in range(2):
                connection.sendall(("OPTIONS /v1/comparisons HTTP/1.1\r\nHost: localhost\r\n%s\r\n"
                                    % (self.ASK % "https://b.example")).encode())
                answer = read_answer(stream)
                self.assertEqual(answer.status, 204)
                self.assertNotIn("content-length", answer.headers)
                self.assertNotIn("content-type", answer.headers)
                self.assertEqual(answer.headers["access-control-allow-origin"], "https://b.example")
                self.assertIn("Authorization", answer.headers["access-control-allow-headers"])
        answer = server.get("/none", extra="Origin: https://a.example\r\n")
        self.assertEqual(answer.headers["access-control-allow-origin"], "https://a.example")
        answer = server.get("/none", extra="Origin: https://evil.example\r\n")
        self.assertNotIn("access-control-allow-origin", answer.headers)
        self.assertEqual(answer.headers["vary"], "Origin")


if __name__ == "__main__":
    unittest.main()
