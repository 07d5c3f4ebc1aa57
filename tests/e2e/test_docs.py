"""The page /docs, as its files and as a browser sees it."""

import http.server
import json
import os
import re
import shutil
import subprocess
import tempfile
import threading
import unittest
from pathlib import Path

from harness import ServerCase

BUILT_WITHOUT = os.environ.get("MESHGAUGE_DOCS", "1") == "0"
CHROMIUM = shutil.which("chromium")


def browse(url):
    """The page's final content, the browser's messages, and the addresses that the page requested."""
    with tempfile.TemporaryDirectory() as folder:
        log = Path(folder) / "net.json"
        done = subprocess.run(
            [CHROMIUM, "--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--no-first-run",
             "--user-data-dir=%s/profile" % folder, "--enable-logging=stderr", "--log-net-log=%s" % log,
             "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1", "--virtual-time-budget=20000", "--dump-dom", url],
            capture_output=True, text=True, timeout=200, check=True)
        events = [event.get("params", {}) for event in json.loads(log.read_text())["events"]]
    ours = url.rsplit("/", 1)[0]
    asked = {event["url"] for event in events if "url" in event and event.get("initiator", "").startswith("http")}
    # Chrome's own pages write messages as well, of a slow network for instance.
    said = [line for line in done.stderr.splitlines() if "CONSOLE" in line and "source: chrome://" not in line]
    return done.stdout, said, asked, ours


class Page(ServerCase):
    @unittest.skipIf(BUILT_WITHOUT, "built without npm")
    def test_all_that_it_names_is_there_and_ours(self):
        page = self.server.get("/docs")
        self.assertEqual(page.status, 200)
        text = page.body.decode()
        self.assertNotIn("//", text)
        self.assertNotRegex(text, r"<style|<script>| style=| on\w+=")
        names = re.findall(r'(?:src|href)="([^"]*)"', text)
        self.assertGreaterEqual(len(names), 5)
        for name in names:
            answer = self.server.get("/" + name)
            self.assertEqual(answer.status, 200, name)
            self.assertGreater(len(answer.body), 100)
        for name in ("LICENSE", "NOTICE", "swagger-ui-bundle.js.LICENSE.txt"):  # of what is passed on
            self.assertEqual(self.server.get("/docs/" + name).status, 200)

    @unittest.skipIf(BUILT_WITHOUT, "built without npm")
    def test_its_policy(self):
        policy = dict(rule.strip().split(" ", 1) for rule in
                      self.server.get("/docs").headers["content-security-policy"].split(";"))
        self.assertEqual(policy["default-src"], "'none'")
        self.assertEqual((policy["script-src"], policy["style-src"], policy["connect-src"]), ("'self'",) * 3)
        self.assertEqual(policy["frame-ancestors"], "'none'")

    @unittest.skipUnless(BUILT_WITHOUT, "built with npm")
    def test_without_it_is_said(self):
        self.assertIn("npm", self.refused(self.server.get("/docs"), 404, "not-found")["detail"])

    def test_no_other_file_is_served(self):
        for name in ("index.html", "docs.html", "..", "%2e%2e", "LICENSE/", ".npmrc"):
            self.refused(self.server.get("/docs/" + name), 404, "not-found")

    @unittest.skipIf(BUILT_WITHOUT or not CHROMIUM, "no chromium, or built without npm")
    def test_in_a_browser(self):
        page, said, asked, ours = browse("http://127.0.0.1:%d/docs" % self.server.port)
        for shown in ("Certified Hausdorff distance", "/v1/comparisons", "/v1/meshes", "Check whether the service is alive"):
            self.assertTrue(shown in page, shown)
        self.assertEqual(said, [])
        self.assertGreaterEqual(len(asked), 5)
        self.assertEqual([url for url in asked if not url.startswith(ours + "/")], [])

    @unittest.skipUnless(CHROMIUM, "no chromium")
    def test_the_browser_would_say_so(self):
        """The control of the test above: the browser reports a page that breaks the same policy."""
        policy = "default-src 'none'; script-src 'self'"

        class Breaks(http.server.BaseHTTPRequestHandler):
            def do_GET(self):
                self.send_response(200)
                self.send_header("Content-Security-Policy", policy)
                self.send_header("Content-Type", "text/html")
                self.end_headers()
                self.wfile.write(b"<script>document.title = 'x'</script><script src='http://127.0.0.1:9/x.js'></script>")

            def log_message(self, *_):
                pass

        with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Breaks) as server:
            threading.Thread(target=server.serve_forever, daemon=True).start()
            _, said, _, _ = browse("http://127.0.0.1:%d/" % server.server_port)
            server.shutdown()
        self.assertTrue(any("Content Security Policy" in line for line in said), said)


if __name__ == "__main__":
    unittest.main()
