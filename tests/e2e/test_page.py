"""The page /, /c/{id} and /b/{id}: its files, how they are sent, and which answers link to it. tests/web has what it does."""

import gzip
import os
import re
import unittest
from pathlib import Path

from contract import events_of
from harness import RAISED, SQUARE, Server, ServerCase, comparison, post_head
from keys import bearer, new_key, write_keys

BUILT_WITHOUT = os.environ.get("MESHGAUGE_DOCS", "1") == "0"
ID = "0d67c9a2d1b307386f8fc157855c4351"


@unittest.skipIf(BUILT_WITHOUT, "built without npm")
class Page(ServerCase):
    def files(self):
        return re.findall(r'(?:src|href)="/page/([^"]*)"', self.server.get("/").body.decode())

    def test_all_that_it_names_is_there_and_ours(self):
        page = self.server.get("/")
        self.assertEqual(page.headers["content-type"], "text/html; charset=utf-8")
        text = page.body.decode()
        self.assertNotIn("//", text.replace("<!--", ""))
        self.assertNotRegex(text, r"<style|<script>| style=| on\w+=")
        names = self.files()
        self.assertGreaterEqual(len(names), 3)
        kinds = {"js": "text/javascript; charset=utf-8", "css": "text/css; charset=utf-8", "svg": "image/svg+xml"}
        for name in names:
            answer = self.server.get("/page/" + name)
            self.assertEqual((answer.status, answer.headers["content-type"]), (200, kinds[name.rpartition(".")[2]]), name)
            self.assertEqual(answer.headers["cache-control"], "public, max-age=31536000, immutable")
        licences = self.server.get("/page/licenses.txt")
        self.assertIn("MIT", licences.body.decode())
        self.assertEqual(licences.headers["cache-control"], "public, max-age=3600")

    def test_its_policy(self):
        for path in ("/", "/c/" + ID, "/b/" + ID):
            answer = self.server.get(path)
            policy = dict(rule.strip().split(" ", 1) for rule in answer.headers["content-security-policy"].split(";"))
            self.assertEqual(policy.pop("img-src"), "'self' data: blob:")
            self.assertEqual({policy.pop(name) for name in ("script-src", "style-src", "connect-src")}, {"'self'"})
            self.assertEqual(policy.pop("require-trusted-types-for"), "'script'")
            self.assertEqual(set(policy), {"default-src", "base-uri", "form-action", "frame-ancestors", "trusted-types"})
            self.assertEqual(set(policy.values()), {"'none'"})
            self.assertEqual(answer.headers["cache-control"], "no-cache")

    def test_compressed_for_clients_that_accept_it(self):
        for path in ["/", "/b/" + ID, "/c/" + ID, "/docs", "/docs/docs.js"] + ["/page/" + name for name in self.files()]:
            plain = self.server.get(path)
            packed = self.server.get(path, extra="Accept-Encoding: br, gzip\r\n")
            self.assertNotIn("content-encoding", plain.headers)
            self.assertEqual(packed.headers["content-encoding"], "gzip")
            self.assertEqual(gzip.decompress(packed.body), plain.body)
            self.assertIn("Accept-Encoding", packed.headers["vary"])
            self.assertNotEqual(packed.headers["etag"], plain.headers["etag"])
            refused = self.server.get(path, extra="Accept-Encoding: gzip;q=0, *\r\n")
            self.assertEqual(refused.body, plain.body)

    def test_not_sent_twice(self):
        for path in ["/", "/b/" + ID, "/c/" + ID, "/docs", "/docs/docs.js", "/page/" + self.files()[0]]:
            for coding in ("", "Accept-Encoding: gzip\r\n"):
                first = self.server.get(path, extra=coding)
                again = self.server.get(path, extra=coding + "If-None-Match: \"x\", W/%s\r\n" % first.headers["etag"])
                self.assertEqual((again.status, again.body), (304, b""), path)
                other = self.server.get(path, extra=coding + 'If-None-Match: "%s"\r\n' % ("0" * 32))
                self.assertEqual(other.body, first.body)

    def test_head(self):
        for path in ("/", "/b/" + ID, "/c/" + ID, "/page/" + self.files()[0]):
            whole, head = self.server.get(path), self.server.get(path, "HEAD")
            self.assertEqual((head.status, head.body), (200, b""))
            for name in ("content-length", "content-type", "etag", "cache-control"):
                self.assertEqual(head.headers[name], whole.headers[name])

    def test_clients_that_prefer_text(self):
        for accept, kind in (("text/html,application/xhtml+xml,*/*;q=0.8", "text/html"), ("*/*", "text/html"),
                             ("application/json", "text/html"), ("text/plain", "text/plain"),
                             ("text/html;q=0.5, text/plain", "text/plain")):
            answer = self.server.get("/", extra="Accept: %s\r\n" % accept)
            self.assertEqual(answer.headers["content-type"].partition(";")[0], kind, accept)
            self.assertIn("Accept", answer.headers["vary"])
        self.assertIn("/openapi.yaml", answer.body.decode())

    def test_every_id_gets_the_same_answer(self):
        known = self.server.compare().json()["id"]
        pages = [self.server.get(path) for path in ("/c/" + known, "/c/" + ID, "/b/" + ID)]
        self.assertEqual(len({page.body for page in pages}), 1)
        self.assertEqual(len({page.headers["etag"] for page in pages}), 1)

    def test_a_damaged_link_is_a_page_for_browsers(self):
        page = self.server.get("/").body
        browser = "text/html,application/xhtml+xml,application/xml;q=0.9,*/*;q=0.8"
        for path in ("/c/nonsense", "/b/nonsense", "/c/" + ID[1:], "/b/" + ID.upper(), "/b", "/b/", "/c", "/c/", "/c/%s/" % ID, "/b/x/"):
            shown = self.server.get(path, extra="Accept: %s\r\nAccept-Encoding: gzip\r\n" % browser)
            self.assertEqual((shown.status, gzip.decompress(shown.body)), (404, page))
            self.assertIn("script-src 'self'", shown.headers["content-security-policy"])
            self.assertEqual(shown.headers["cache-control"], "no-store")
            self.assertEqual(shown.headers["vary"], "Accept, Accept-Encoding")
            self.assertNotIn("etag", shown.headers)
            self.assertEqual(self.server.get(path, extra="Accept: text/html\r\n").body, page)
            head = self.server.get(path, "HEAD", extra="Accept: text/html\r\n")
            self.assertEqual((head.status, head.headers["content-length"]), (404, str(len(page))))
            for accept in ("", "Accept: */*\r\n", "Accept: application/json\r\n", "Accept: text/html, application/json\r\n",
                           "Accept: application/problem+json, text/html;q=0.5\r\n"):
                told = self.server.get(path, extra=accept)
                self.refused(told, 404, "not-found")
                self.assertEqual(told.headers["vary"], "Accept")

    def test_with_keys_it_needs_none(self):
        token, entry = new_key("ci")
        keys = Path(self.server.data_dir.name) / "keys.json"
        write_keys(keys, entry)
        server = Server("--keys-file", str(keys))
        self.addCleanup(server.stop)
        for path in ["/", "/b/" + ID, "/c/" + ID, "/page/" + self.files()[0], "/b", "/b/x"]:
            self.assertEqual(server.get(path).status, 404 if path in ("/b", "/b/x") else 200)
        self.refused(server.get("/v1/comparisons/" + ID), 401, "unauthorized")
        self.refused(server.get("/v1/comparisons/" + ID, extra=bearer(token)), 404, "not-found")

    def test_answers_point_to_it(self):
        awaited = self.server.compare().json()
        self.assertEqual(awaited["view"], "/c/" + awaited["id"])
        body = comparison(SQUARE, RAISED)
        accepted = self.server.raw(post_head(len(body), "Prefer: respond-async\r\n") + body)
        self.assertEqual(accepted.status, 202)
        path = accepted.headers["location"]
        view = "/c/" + path.rpartition("/")[2]
        self.assertEqual(accepted.json()["view"], view)
        name, last = list(events_of(self.server.get(path + "/events").body))[-1]
        self.assertEqual((name, last["view"], last["result"]["view"]), ("end", view, view))
        self.assertEqual(self.server.get(path).json(), last)
        self.assertEqual(self.server.get("/v1/comparisons/" + awaited["id"]).json()["result"], awaited)


class Files(ServerCase):
    def test_no_other_file_is_served(self):
        for name in ("index.html", "docs.js", "main.ts", "style.css", "..", "%2e%2e", "../docs/docs.js", ".npmrc"):
            self.refused(self.server.get("/page/" + name), 404, "not-found")

    def test_what_cannot_be_an_id(self):
        for id in ("", "x", ID[1:], ID + "0", ID.upper(), "%30" + ID[1:], "..", ID + "/", ID + "/more"):
            for folder in ("/b/", "/c/"):
                self.refused(self.server.get(folder + id), 404, "not-found")

    @unittest.skipUnless(BUILT_WITHOUT, "built with npm")
    def test_without_it(self):
        answer = self.server.get("/", extra="Accept: text/html\r\n")
        self.assertEqual((answer.status, answer.headers["content-type"]), (200, "text/plain"))
        for folder in ("/b/", "/c/"):
            self.assertIn("npm", self.refused(self.server.get(folder + ID), 404, "not-found")["detail"])
            self.refused(self.server.get(folder + "x", extra="Accept: text/html\r\n"), 404, "not-found")
        self.assertNotIn("view", self.server.compare().json())


if __name__ == "__main__":
    unittest.main()
