"""The action's comment on a pull request, written to a stand-in for GitHub's API."""

import http.server
import json
import os
import re
import shutil
import subprocess
import threading
import unittest

from harness import ROOT
from manual import box, repository
from test_action import Runner

TOKEN = "ghs_secretOfThisRun"
REPOSITORY = "Owner/parts"
STRANGER = {"user": {"type": "User"}, "author_association": "NONE"}


class GitHub:
    """Comments of pull request 7. `failing`: how it answers instead, by the method."""

    def __init__(self):
        self.comments, self.requests, self.failing = [], [], {}
        self.head, self.login, self.after_post = "c" * 40, None, None
        github = self

        class Handler(http.server.BaseHTTPRequestHandler):
            def log_message(self, *words):
                pass

            def do(self):
                length = int(self.headers.get("Content-Length") or 0)
                body = json.loads(self.rfile.read(length)) if length else None
                github.requests.append((self.command, self.path))
                if self.headers.get("Authorization") != f"Bearer {TOKEN}":
                    return self.answer(401, {"message": "Bad credentials"})
                if self.command in github.failing:
                    return github.failing[self.command](self)
                return self.answer(*github.done(self.command, self.path, body))

            do_GET = do_POST = do_PATCH = do_DELETE = do

            def answer(self, status, document, **headers):
                text = document if isinstance(document, bytes) else json.dumps(document).encode()
                self.send_response(status)
                for name, value in {"Content-Length": len(text), **headers}.items():
                    self.send_header(name, str(value))
                self.end_headers()
                self.wfile.write(text)

        self.server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self.server.daemon_threads = True
        self.url = f"http://127.0.0.1:{self.server.server_port}"
        threading.Thread(target=self.server.serve_forever, args=(0.05,), daemon=True).start()

    def add(self, body, **more):
        self.comments.append({"id": 100 + len(self.comments), "body": body, "user": {"type": "Bot"}, "author_association": "NONE", **more})
        return self.comments[-1]

    def done(self, method, path, body):
        if found := re.fullmatch(rf"/repos/{REPOSITORY}/issues/7/comments(?:\?per_page=(\d+)&page=(\d+))?", path):
            if method == "POST":
                comment = self.add(body["body"], **({"user": {"type": "User", "login": self.login}} if self.login else {}))
                if self.after_post:
                    self.after_post()
                return 201, comment
            size, page = int(found[1]), int(found[2])
            return 200, self.comments[size * (page - 1):size * page]
        if method == "GET" and path == f"/repos/{REPOSITORY}/pulls/7":
            return 200, {"head": {"sha": self.head}}
        if path == "/user":
            return (200, {"login": self.login}) if self.login else (403, {"message": "Resource not accessible by integration"})
        if method in ("PATCH", "DELETE") and (found := re.fullmatch(rf"/repos/{REPOSITORY}/issues/comments/(\d+)", path)):
            (comment,) = [one for one in self.comments if one["id"] == int(found[1])]
            if method == "DELETE":
                self.comments.remove(comment)
                return 204, b""
            comment["body"] = body["body"]
            return 200, comment
        return 404, {"message": "Not Found"}

    def writes(self):
        return [method for method, _ in self.requests if method != "GET"]

    def close(self):
        self.server.shutdown()
        self.server.server_close()


class Comment(Runner):
    def setUp(self):
        super().setUp()
        self.github = GitHub()
        self.addCleanup(self.github.close)
        self.event = {"number": 7, "pull_request": {"number": 7, "head": {"sha": "c" * 40, "repo": {"full_name": REPOSITORY}}}}

    def reported(self, text="## the report\n", verdict="fail", name="comment.md"):
        """What the step `check` leaves, without running it."""
        reports = self.workspace / "meshgauge-reports"
        reports.mkdir(parents=True, exist_ok=True)
        (reports / name).write_text(text)
        self.summary.write_text("")
        self.outputs = {"verdict": verdict}

    def comment(self, token=TOKEN, comment="auto", event_name="pull_request", manifest="gates.yaml", pictures="", **more):
        self.values = {"inputs.comment": comment, "inputs.token": token, "inputs.manifest": manifest, "inputs.reports": "meshgauge-reports",
                       "steps.check.outputs.verdict": self.outputs["verdict"], "steps.pictures.outputs.address": pictures}
        event = self.top / "event.json"
        event.write_text(json.dumps(self.event))
        done = self.run_step("comment", **{
            "GITHUB_EVENT_PATH": str(event), "GITHUB_EVENT_NAME": event_name, "GITHUB_REPOSITORY": REPOSITORY,
            "GITHUB_SERVER_URL": "https://github.example", "GITHUB_RUN_ID": "42", "GITHUB_API_URL": self.github.url, **more})
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertNotIn(token.strip() or TOKEN, done.stdout + done.stderr + self.summary.read_text())
        self.assertEqual(done.stderr, "")
        return done.stdout

    def refused(self, why, **how):
        self.assertIn(why, self.comment(**how))
        self.assertRegex(self.summary.read_text(), rf"\nThere is no comment on the pull request: .*{re.escape(why)}.*\.\n$")


class Runs(Comment):
    def test_one_comment_over_three_runs(self):
        repository(self.workspace, broken=True)
        self.assertEqual(self.use(event="pull_request"), 1, self.log)
        self.comment()
        self.assertEqual(self.github.writes(), ["POST"])
        (comment,) = self.github.comments
        self.assertTrue(comment["body"].startswith("<!-- meshgauge: gates.yaml -->\n## ❌ meshgauge: failed\n"))
        self.assertIn("| ❌ fail | `bracket` |", comment["body"])
        self.assertIn("<details><summary>2 gates passed</summary>", comment["body"])
        self.assertIn("[The run](https://github.example/Owner/parts/actions/runs/42) of ccccccc has all reports.", comment["body"])
        self.assertNotIn("<!-- picture", comment["body"])

        (self.workspace / "parts/pin.off").write_text(box(5, 5, 60, hole=True))
        self.assertEqual(self.use(event="pull_request"), 1, self.log)
        self.comment()
        self.assertIn("| ❌ fail | `pin` |", comment["body"])

        for name, size in (("pin", (5, 5, 60)), ("bracket", (20, 20, 20))):
            (self.workspace / f"parts/{name}.off").write_text(box(*size))
        self.assertEqual(self.use(event="pull_request"), 0, self.log)
        self.comment()
        self.assertEqual(self.github.writes(), ["POST", "PATCH", "PATCH"])
        self.assertIn("## ✅ meshgauge: all gates hold\n", comment["body"])
        self.assertEqual(len(self.github.comments), 1)
        self.assertNotIn("There is no comment", self.summary.read_text())

    def test_a_program_that_was_not_fetched_is_told(self):
        self.assertEqual(self.use(event="pull_request", version="9.9.9"), 3)
        self.comment()
        self.assertIn("## ❌ meshgauge: nothing was measured\n\n    ", self.github.comments[0]["body"])

    def test_each_manifest_has_its_own(self):
        for manifest in ("gates.yaml", "a/gates.yaml", "--> x\n.yaml", "gates.yaml", "./gates.yaml", "a/../a//gates.yaml"):
            self.reported()
            self.comment(manifest=manifest)
        self.assertEqual(self.github.writes(), ["POST", "POST", "POST", "PATCH", "PATCH", "PATCH"])
        self.assertTrue(self.github.comments[2]["body"].startswith("<!-- meshgauge: --%3E x%0A.yaml -->\n"))


class When(Comment):
    def test_a_first_comment_is_for_what_does_not_pass(self):
        self.reported(verdict="pass")
        self.comment()
        self.assertEqual(self.github.writes(), [])
        for verdict in ("fail", "undecided", "error"):
            self.github.comments.clear()
            self.reported(verdict=verdict)
            self.comment()
        self.assertEqual(self.github.writes(), ["POST"] * 3)

    def test_always(self):
        self.reported(verdict="pass")
        self.comment(comment="always")
        self.assertEqual(self.github.writes(), ["POST"])

    def test_never_and_events_without_a_pull_request_are_skipped_by_the_runner(self):
        text = (ROOT / "action.yml").read_text()
        self.assertIn("inputs.comment != 'never' && startsWith(github.event_name, 'pull_request') }}", text)

    def test_none_on_a_fork(self):
        for head in ({"full_name": "Stranger/parts"}, None):
            self.event["pull_request"]["head"]["repo"] = head
            self.reported()
            self.refused("it comes from a fork")
        self.assertEqual(self.github.requests, [])
        self.comment(event_name="pull_request_target")
        self.assertEqual(self.github.writes(), ["POST"])

    def test_it_is_found_behind_many_others(self):
        for i in range(230):
            self.github.add(f"comment {i}", **STRANGER)
        self.github.add("<!-- meshgauge: gates.yaml -->\nold")
        self.reported()
        self.comment()
        self.assertEqual(self.github.writes(), ["PATCH"])
        self.assertIn("the report", self.github.comments[230]["body"])

    def test_what_a_stranger_begins_with_the_marker_is_left(self):
        self.github.add("<!-- meshgauge: gates.yaml -->\nmine", **STRANGER)
        self.github.add("> <!-- meshgauge: gates.yaml -->\nquoted")
        self.github.add("<!-- meshgauge: gates.yaml.old -->\nanother")
        self.github.add("<!-- meshgauge: gates.yaml -->\na member's", user={"type": "User", "login": "m"}, author_association="MEMBER")
        self.reported()
        self.comment()
        self.assertEqual(self.github.writes(), ["POST"])

    def test_the_account_of_the_token_where_it_is_known(self):
        self.github.login = "robot"
        self.github.add("<!-- meshgauge: gates.yaml -->\nof another bot")
        for writes in (["POST"], ["POST", "PATCH"]):
            self.reported()
            self.comment()
            self.assertEqual(self.github.writes(), writes)
        self.assertIn("of another bot", self.github.comments[0]["body"])
        self.assertIn("the report", self.github.comments[1]["body"])

    def test_the_run_of_an_older_commit_leaves_it(self):
        self.github.head = "d" * 40
        self.github.add("<!-- meshgauge: gates.yaml -->\nof the newer one")
        self.reported()
        self.assertIn("has a newer commit", self.comment())
        self.assertEqual(self.github.writes(), [])

    def test_runs_at_the_same_time_leave_one(self):
        self.reported()
        self.github.after_post = lambda: self.github.comments.insert(0, {
            **self.github.comments[-1], "id": 7, "body": "<!-- meshgauge: gates.yaml -->\nof another run"})
        self.comment()
        self.assertEqual(self.github.writes(), ["POST", "PATCH", "DELETE"])
        (comment,) = self.github.comments
        self.assertIn("the report", comment["body"])
        self.github.failing = {"DELETE": lambda handler: handler.answer(404, {})}
        self.github.comments.clear()
        self.reported()
        self.assertIn("the pull request has a comment", self.comment())


class Pictures(Comment):
    def test_marks_become_pictures_that_are_there(self):
        self.reported("\n### a\n\n<!-- picture: a.png -->\n\n### b\n\n<!-- picture: b~0.png -->\n\nx <!-- picture: a.png -->\n")
        (self.workspace / "meshgauge-reports/pictures").mkdir()
        (self.workspace / "meshgauge-reports/pictures/a.png").write_bytes(b"")
        self.comment(pictures="https://pictures.example/x/")
        (comment,) = self.github.comments
        self.assertIn("\n### a\n\n![a.png](https://pictures.example/x/a.png)\n\n### b\n\n\nx <!-- picture: a.png -->\n", comment["body"])

    def test_ten_at_most(self):
        pictures = self.workspace / "meshgauge-reports/pictures"
        pictures.mkdir(parents=True)
        for i in range(12):
            (pictures / f"{i}.png").write_bytes(b"")
        self.reported("".join(f"<!-- picture: {i}.png -->\n" for i in range(12)))
        self.comment(pictures="https://pictures.example")
        self.assertEqual(self.github.comments[0]["body"].count("!["), 10)

    def test_a_long_report_fits(self):
        self.reported("é" * 70_000)
        self.comment()
        self.assertLessEqual(len(self.github.comments[0]["body"]), 65_536)
        self.assertIn("has all reports", self.github.comments[0]["body"])


@unittest.skipUnless(shutil.which("git"), "no git")
class Branch(Comment):
    """The branch of pictures, of a repository on this machine."""

    def setUp(self):
        super().setUp()
        self.remote = self.top / "server" / REPOSITORY
        self.remote.mkdir(parents=True)
        self.git("init", "-q", "--bare", ".")
        self.pictures = self.workspace / "meshgauge-reports/pictures"
        self.pictures.mkdir(parents=True)

    def git(self, *words):
        return subprocess.run(["git", *words], cwd=self.remote, env=self.environment, check=True, text=True,
                              stdout=subprocess.PIPE).stdout

    def put(self, *names, pull=7, run=1, branch="meshgauge-pictures", manifest="gates.yaml", reports="meshgauge-reports",
            job="meshes"):
        """What the step does with these pictures. Returns the address for the comment, "" if there is none, and sets self.said."""
        self.reported("".join(f"<!-- picture: {name} -->\n" for name in names))
        for name in names:
            (self.pictures / name).write_bytes(f"{name} of {run}".encode())
        self.values = {"inputs.pictures-branch": branch, "inputs.token": TOKEN, "inputs.manifest": manifest,
                       "github.event.pull_request.number": str(pull), "inputs.reports": reports}
        output = self.top / "output"
        output.write_text("")
        done = self.run_step("pictures", GITHUB_SERVER_URL=f"file://{self.top}/server", GITHUB_REPOSITORY=REPOSITORY, GITHUB_RUN_ID=str(run),
                             GITHUB_OUTPUT=str(output), GITHUB_JOB=job)
        self.assertEqual(done.returncode, 0)
        self.said = done.stdout + done.stderr
        self.assertNotIn(TOKEN, self.said)
        return dict(line.split("=", 1) for line in output.read_text().splitlines()).get("address", "")

    def files(self, branch="meshgauge-pictures"):
        return self.git("ls-tree", "-r", "--name-only", branch).split()

    def test_a_commit_of_the_last_run_of_each_manifest(self):
        address = self.put("a.png", "b~0.png")
        place = address.removeprefix(f"file://{self.top}/server/{REPOSITORY}/raw/meshgauge-pictures/")
        self.assertRegex(place, r"^7-\d+/1-1$")
        self.assertEqual(self.files(), [f"{place}/a.png", f"{place}/b~0.png"])
        self.put("a.png", run=2, manifest="other.yaml")
        self.put("a.png", run=3)
        self.put("a.png", run=4, pull=8)
        self.assertEqual(sorted(file.partition("/")[2] for file in self.files()), ["2-1/a.png", "3-1/a.png", "4-1/a.png"])
        self.assertEqual(self.git("rev-list", "--count", "meshgauge-pictures").strip(), "1")
        (one,) = [file for file in self.files() if "/3-1/" in file]
        self.assertEqual(self.git("show", f"meshgauge-pictures:{one}"), "a.png of 3")

    def test_the_oldest_pull_requests_go(self):
        for pull in (40, 5, 100):
            self.put("a.png", pull=pull)
        self.put("a.png", pull=100, manifest="other.yaml")
        self.put("a.png", pull=100, job="another")
        self.assertEqual(len(self.files()), 5)
        for pull in range(200, 228):
            self.put("a.png", pull=pull)
        kept = {file.split("-")[0] for file in self.files()}
        self.assertEqual((len(kept), len(self.files())), (30, 32))
        self.assertNotIn("5", kept)
        self.assertIn("40", kept)

    def test_a_folder_of_reports_that_is_absolute(self):
        self.assertTrue(self.put("a.png", reports=str(self.workspace / "meshgauge-reports")), self.said)
        self.assertEqual(len(self.files()), 1)

    def test_another_branch_is_left_alone(self):
        tree = self.git("write-tree").strip()
        commit = self.git("commit-tree", "-m", "work", tree).strip()
        self.git("update-ref", "refs/heads/main", commit)
        self.assertEqual(self.put("a.png", branch="main"), "")
        self.assertIn("has something else", self.said)
        self.assertEqual(self.git("rev-parse", "main").strip(), commit)

    def test_names_that_are_no_branch_and_no_picture(self):
        for branch in ("-f", "a b", "a..b", "$(touch pwned)", "x:y", "../x"):
            self.assertEqual(self.put("a.png", branch=branch), "", branch)
            self.assertIn("no name of a branch", self.said)
        self.assertEqual(self.put(), "")
        self.assertIn("there are none", self.said)
        self.assertFalse([*self.top.rglob("pwned")])

    def test_a_branch_that_cannot_be_written(self):
        shutil.rmtree(self.remote)
        self.assertEqual(self.put("a.png"), "")
        self.assertIn("contents: write", self.said)


class Trouble(Comment):
    def setUp(self):
        super().setUp()
        self.reported()

    def test_a_token_without_the_right(self):
        for status in (401, 403, 404):
            self.github.failing = {"POST": lambda handler, status=status: handler.answer(status, {"message": TOKEN})}
            self.reported()
            self.refused("pull-requests: write")

    def test_no_token_and_one_that_is_no_token(self):
        for token in ("", "another", "a\nb", "\r\n"):
            self.reported()
            self.assertIn("no comment on the pull request", self.comment(token=token))

    def test_an_api_that_fails(self):
        self.github.failing = {"GET": lambda handler: handler.answer(500, {"message": "::error::x"})}
        self.refused("GitHub's API answered 500")

    def test_answers_that_are_no_comments(self):
        for text in (b"", b"<html>", b"{}", b"[" * 100_000, b"\xff", b"null"):
            self.github.failing = {"GET": lambda handler, text=text: handler.answer(200, text)}
            self.reported()
            self.refused("an answer of GitHub's API is no")
        odd = [7, None, {"id": "x"}, {"id": 1, "user": 3, "body": 4}, {"id": 1, "user": {"type": 3}}]
        self.github.failing = {"GET": lambda handler: handler.answer(200, {"head": {"sha": "c" * 40}} if "/pulls/" in handler.path else odd)}
        self.reported()
        self.comment()
        self.assertEqual(self.github.writes(), ["POST"])

    def test_an_answer_that_is_too_large(self):
        def flood(handler):
            handler.send_response(200)
            handler.end_headers()
            piece = b" " * 1_000_000
            try:
                for _ in range(200):
                    handler.wfile.write(piece)
            except OSError:
                pass  # it stopped reading

        self.github.failing = {"GET": flood}
        self.refused("too large")

    def test_an_answer_that_does_not_end(self):
        over = threading.Event()
        self.addCleanup(over.set)

        def drip(handler):
            handler.send_response(200)
            handler.end_headers()
            while not over.wait(0.05):
                try:
                    handler.wfile.write(b" ")
                except OSError:
                    return

        self.github.failing = {"GET": drip}
        self.refused("took longer than 1 s", COMMENT_SECONDS="1")

    def test_an_answer_that_leads_elsewhere(self):
        other = GitHub()
        self.addCleanup(other.close)
        self.github.failing = {"GET": lambda handler: handler.answer(301, b"", Location=other.url + handler.path)}
        self.refused("GitHub's API answered 301")
        self.assertEqual(other.requests, [])

    def test_an_api_that_is_not_there(self):
        self.github.close()
        self.refused("GitHub's API was not reached")

    def test_a_runner_without_python(self):
        bare = self.top / "bare"
        bare.mkdir()
        for program in ("bash", "dirname", "timeout"):
            found = next(os.path.join(folder, program) for folder in os.environ["PATH"].split(os.pathsep)
                         if os.path.exists(os.path.join(folder, program)))
            (bare / program).symlink_to(found)
        self.refused("no python3", PATH=str(bare))

    def test_no_report_at_all(self):
        (self.workspace / "meshgauge-reports/comment.md").unlink()
        self.refused("there is no report")
        self.assertEqual(self.github.requests, [])

    def test_an_event_that_is_none(self):
        self.event = {}
        self.refused("KeyError")


if __name__ == "__main__":
    unittest.main()
