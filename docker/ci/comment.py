#!/usr/bin/env python3
"""Keeps the one comment of a manifest on a pull request up to date, by GitHub's API; run by comment.sh.

Prints what it did and exits with 0, or prints why there is no comment, in words that hold nothing of an answer or of the token, and
exits with 1. The variables are those of the step `comment` of action.yml and GitHub's own.
"""

import http.client
import json
import os
import pathlib
import posixpath
import re
import signal
import sys
import urllib.error
import urllib.parse
import urllib.request

SECONDS = int(os.environ.get("COMMENT_SECONDS", "60"))  # for all of it
MOST_BYTES = 50_000_000  # of an answer: 100 comments of 65,536 characters, escaped
PER_PAGE = 100
MOST_PAGES = 50
MOST_CHARACTERS = 65_000  # GitHub takes 65,536
MOST_PICTURES = 10
NO_RIGHT = "the token may not write it: the job needs the permission `pull-requests: write`"
PICTURE = re.compile(r"^<!-- picture: ([a-z0-9_.~-]+) -->\n", re.M)


class NoComment(Exception):
    """Why there is none."""


class NoRight(NoComment):
    """The token is refused."""


class NoRedirect(urllib.request.HTTPRedirectHandler):
    """The token goes to no other host."""

    def redirect_request(self, *_):
        return None


OPENER = urllib.request.build_opener(NoRedirect)


def call(method, path, body=None):
    """The answer of a GET, as JSON. What follows the status of another one does not matter."""
    token = os.environ.get("COMMENT_TOKEN", "").strip()
    request = urllib.request.Request(os.environ.get("GITHUB_API_URL", "https://api.github.com") + path, method=method, headers={
        "Authorization": f"Bearer {token}", "Accept": "application/vnd.github+json", "Content-Type": "application/json",
        "User-Agent": "meshgauge", "X-GitHub-Api-Version": "2022-11-28"})
    if body is not None:
        request.data = json.dumps({"body": body}).encode()
    try:
        with OPENER.open(request, timeout=SECONDS) as answer:
            text = answer.read(MOST_BYTES + 1) if method == "GET" else b"null"
    except urllib.error.HTTPError as error:
        if error.code in (401, 403, 404):
            raise NoRight(NO_RIGHT) from None
        raise NoComment(f"GitHub's API answered {int(error.code)}") from None
    except (OSError, http.client.HTTPException):
        raise NoComment("GitHub's API was not reached") from None
    if len(text) > MOST_BYTES:
        raise NoComment("an answer of GitHub's API is too large")
    try:
        return json.loads(text)
    except (ValueError, RecursionError):
        raise NoComment("an answer of GitHub's API is no JSON") from None


def identity():
    """The name of the token's account; None: it is that of an app, such as the runs of a workflow, which GitHub does not tell."""
    try:
        user = call("GET", "/user")
    except NoRight:
        return None
    return user.get("login") if isinstance(user, dict) else None


def is_ours(comment, marker, login):
    """A comment that another account begins with the marker is not."""
    if not isinstance(comment, dict) or not isinstance(comment.get("id"), int):
        return False
    user = comment.get("user")
    if not isinstance(user, dict) or not str(comment.get("body")).startswith(marker):
        return False
    return user.get("type") == "Bot" if login is None else user.get("login") == login


def find(comments, marker, login):
    """The ids of the comments of this manifest, the oldest first."""
    ids = []
    for page in range(1, MOST_PAGES + 1):
        found = call("GET", f"{comments}?per_page={PER_PAGE}&page={page}")
        if not isinstance(found, list):
            raise NoComment("an answer of GitHub's API is no list")
        ids += [comment["id"] for comment in found if is_ours(comment, marker, login)]
        if len(found) < PER_PAGE:
            return ids
    raise NoComment("the pull request has too many comments")


def with_pictures(text, reports):
    """The marks of pictures that are there become pictures, the others go. COMMENT_PICTURES: address of the folder `pictures`."""
    address = os.environ.get("COMMENT_PICTURES", "").rstrip("/")
    left = MOST_PICTURES if address else 0

    def shown(mark):
        nonlocal left
        if left == 0 or not (reports / "pictures" / mark[1]).is_file():
            return ""
        left -= 1
        return f"![{mark[1]}]({address}/{mark[1]})\n"

    return PICTURE.sub(shown, text)


def body_of(marker, commit):
    reports = pathlib.Path(os.environ.get("COMMENT_REPORTS") or "meshgauge-reports")
    try:
        text = (reports / "comment.md").read_text("utf-8", "replace")
    except OSError:
        raise NoComment("there is no report") from None
    run = "{GITHUB_SERVER_URL}/{GITHUB_REPOSITORY}/actions/runs/{GITHUB_RUN_ID}".format_map(os.environ)
    end = f"\n[The run]({run}) of {commit[:7]} has all reports.\n"
    room = MOST_CHARACTERS - len(marker) - len(end)
    body = with_pictures(text, reports)
    if len(body) > room:
        body = PICTURE.sub("", text)[:room]
    return f"{marker}\n{body}{end}"


def newest_commit(repository, number):
    pull = call("GET", f"/repos/{repository}/pulls/{number}")
    head = pull.get("head") if isinstance(pull, dict) else None
    if not isinstance(head, dict):
        raise NoComment("an answer of GitHub's API is no pull request")
    return head.get("sha")


def remove(comment):
    """Another run may have removed it."""
    try:
        call("DELETE", comment)
    except NoRight:
        pass


def keep():
    """Writes the comment. Returns what was done."""
    event = json.loads(pathlib.Path(os.environ["GITHUB_EVENT_PATH"]).read_text("utf-8"))
    pull, repository = event["pull_request"], os.environ["GITHUB_REPOSITORY"]
    head = pull["head"].get("repo") or {}
    if os.environ.get("GITHUB_EVENT_NAME") == "pull_request" and head.get("full_name") != repository:
        raise NoComment("it comes from a fork, whose runs may not write one")
    manifest = posixpath.normpath(os.environ["COMMENT_MANIFEST"])
    marker = f"<!-- meshgauge: {urllib.parse.quote(manifest, safe='/._ ')} -->"
    place, number, commit = f"/repos/{repository}/issues", int(pull["number"]), str(pull["head"]["sha"])
    comments = f"{place}/{number}/comments"
    body = body_of(marker, commit)
    login = identity()
    known = find(comments, marker, login)
    if newest_commit(repository, number) != commit:
        return "the pull request has a newer commit, whose run writes the comment"
    if known:
        call("PATCH", f"{place}/comments/{known[0]}", body)
        return "the comment on the pull request is up to date"
    if os.environ.get("COMMENT") != "always" and os.environ.get("COMMENT_VERDICT") == "pass":
        return "every gate passes, and there is no comment to bring up to date"
    call("POST", comments, body)
    first, *others = find(comments, marker, login) or [None]
    if others:  # of runs at the same time
        call("PATCH", f"{place}/comments/{first}", body)
        for other in others:
            remove(f"{place}/comments/{other}")
    return "the pull request has a comment"


def too_slow(*_):
    raise NoComment(f"GitHub's API took longer than {SECONDS} s")


def main():
    if hasattr(signal, "SIGALRM"):
        signal.signal(signal.SIGALRM, too_slow)
        signal.alarm(SECONDS)
    try:
        print(keep())
    except NoComment as why:
        print(why)
        return 1
    except Exception as error:  # its text may hold the token
        print(f"{type(error).__name__} where it was written")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
