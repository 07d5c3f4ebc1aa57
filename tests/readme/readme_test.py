#!/usr/bin/env python3
"""Holds README.md and the pages that continue it to what the program does.

  readme_test.py BUILD_DIR            the README's request gets its response, which docs/api.md shows in full; the table of
                                      docs/settings.md is that of `meshgauge serve --help`; the requests of docs/api.md do what
                                      it says; the machines of docs/scaling.md answer; the C++ of docs/library.md is that of
                                      tests/consumer/main.cpp; links lead to files and headings; the README is short
  readme_test.py BUILD_DIR --update   writes the responses and the table anew
"""

import contextlib
import json
import math
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import time
import urllib.request

ROOT = pathlib.Path(__file__).resolve().parents[2]
README, API, SETTINGS, SCALING, LIBRARY = (ROOT / page for page in (
    "README.md", "docs/api.md", "docs/settings.md", "docs/scaling.md", "docs/library.md"))
MAX_LINES, MAX_WORDS = 200, 1800
# The services run on this machine: requests go to them without a proxy.
for variable in [name for name in os.environ if name.lower().endswith("_proxy")]:
    del os.environ[variable]
# The pages show the defaults: settings of the machine that runs the test do not count.
ENVIRONMENT = {k: v for k, v in os.environ.items() if not k.startswith("MESHGAUGE_")} | {"TMPDIR": "/tmp"}
ADDRESS = "127.0.0.1:8080"
# What another version of the engine, another machine or another run may change: the shape is compared, the value is not.
VARYING = {"id", "timings_ms", "engine", "distance", "a_to_b", "b_to_a", "reached", "precision_floor", "view"}


def fail(message):
    sys.exit(f"readme_test: {message}")


def block(text, language, beginning):
    """The body of the first ```language block that holds `beginning`, and its span."""
    for found in re.finditer(rf"^```{language}\n(.*?)^```$", text, re.M | re.S):
        if beginning in found[1]:
            return found[1], found.span(1)
    fail(f"no ```{language} block with {beginning!r}")


# --- the request and its response -------------------------------------------------------------------------------------


def request_of(readme):
    body, _ = block(readme, "sh", "curl ")
    return next(line for line in body.splitlines() if line.startswith("curl "))


@contextlib.contextmanager
def service(build):
    """A running service; gives its address."""
    with tempfile.TemporaryDirectory() as folder:
        command = [build / "meshgauge", "serve", "--port", "0", "--data-dir", folder]
        server = subprocess.Popen(command, env=ENVIRONMENT, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        try:
            started = server.stderr.readline()
            if '"listening"' not in started:
                fail(f"the service said {started!r}")
            yield "127.0.0.1:" + json.loads(started)["detail"].rsplit(":", 1)[1]
        finally:
            server.send_signal(signal.SIGTERM)
            _, log = server.communicate(timeout=60)
    if server.returncode != 0:
        fail(f"the service ended with {server.returncode}:\n{log}")


def has_pages(address):
    """Whether the service was built with its pages."""
    request = urllib.request.Request(f"http://{address}/", headers={"Accept": "text/html"})
    with urllib.request.urlopen(request, timeout=60) as answer:
        return answer.headers["Content-Type"].startswith("text/html")


def said(request, address, build):
    """What a line of a page prints."""
    line = re.sub(r"(?<=[@ ])build/", f"{build}/", request.replace(ADDRESS, address))
    done = subprocess.run(["sh", "-c", line], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        fail(f"{request!r} failed: {done.stderr}")
    return done.stdout


def ask(request, address, build, member="distance"):
    text = said(request, address, build)
    try:
        answer = json.loads(text)
    except json.JSONDecodeError:
        fail(f"{request!r} gave no JSON but {text!r}")
    if member not in answer:
        fail(f"{request!r} gave no {member} but {text}")
    return answer


def check_jobs(page, address, build):
    body, _ = block(page, "sh", "respond-async")
    later, baseline, candidate, stored, again = (line for line in body.splitlines() if line.startswith("curl "))
    accepted = said(later, address, build)
    location = re.search(r"^location: (/v1/comparisons/\w+)\r?$", accepted, re.M | re.I)
    if not re.match(r"HTTP/1.1 202 ", accepted) or not location:
        fail(f"{later!r} gave {accepted!r}")
    for _ in range(600):
        with urllib.request.urlopen(f"http://{address}{location[1]}", timeout=60) as answer:
            job = json.load(answer)
        if job["finished"]:
            break
        time.sleep(0.05)
    if job["state"] != "done" or "distance" not in job["result"]:
        fail(f"{location[1]} is {job}")
    sent = [ask(line, address, build, "bytes")["id"] for line in (baseline, candidate)]
    got = ask(stored, address, build)
    if [got["meshes"][part]["sha256"] for part in "ab"] != sent:
        fail(f"{stored!r} measured other meshes than {sent}")
    if ask(again, address, build)["id"] != ask(again, address, build)["id"]:
        fail(f"{again!r}, twice, is two comparisons")


def same(shown, got, path="response"):
    """Fails unless both have the same members and types, and the same values where they do not vary from run to run."""
    number = (int, float)
    if not (isinstance(shown, number) and isinstance(got, number)) and type(shown) is not type(got):
        fail(f"{path} is {got!r}, not {shown!r}")
    if isinstance(shown, dict):
        if list(shown) != list(got):
            fail(f"{path} has the members {list(got)}, not {list(shown)}")
        for key in shown:
            if key in VARYING:
                same_shape(shown[key], got[key], f"{path}.{key}")
            else:
                same(shown[key], got[key], f"{path}.{key}")
    elif isinstance(shown, list):
        if len(shown) != len(got):
            fail(f"{path} has {len(got)} elements, not {len(shown)}")
        for i, (s, g) in enumerate(zip(shown, got)):
            same(s, g, f"{path}[{i}]")
    elif isinstance(shown, float):
        # Another compiler may round otherwise; the last digits are all that may differ.
        if not math.isclose(shown, got, rel_tol=1e-9, abs_tol=1e-12):
            fail(f"{path} is {got!r}, not {shown!r}")
    elif shown != got:
        fail(f"{path} is {got!r}, not {shown!r}")


def part_of(shown, got, path="README.md's response"):
    """Fails unless every member that the README shows is in the full response of docs/api.md, with the same value."""
    if isinstance(shown, dict):
        for key in shown:
            if key not in got:
                fail(f"{path} has the member {key!r}, which docs/api.md has not")
            part_of(shown[key], got[key], f"{path}.{key}")
    elif shown != got:
        fail(f"{path} is {shown!r}, and {got!r} in docs/api.md")


def cut(shown, got):
    """The members of `got` that `shown` has."""
    return {key: cut(shown[key], got[key]) for key in shown} if isinstance(shown, dict) else got


def overlap(shown, got):
    """Asserts that both intervals meet, since both hold the true distance, and that each is as narrow as requested."""
    (lower, upper), (low, high) = ((r["distance"]["lower"], r["distance"]["upper"]) for r in (shown, got))
    if not 0 < lower <= upper or not 0 < low <= high or upper < low or high < lower:
        fail(f"the distance is [{low!r}, {high!r}], not [{lower!r}, {upper!r}]")
    for response in (shown, got):
        if response["tolerance"]["reached"]["relative"] > response["tolerance"]["asked"]["relative"]:
            fail(f"the tolerance is not met: {response['tolerance']}")


def same_shape(shown, got, path):
    if isinstance(shown, dict):
        if not isinstance(got, dict) or list(shown) != list(got):
            fail(f"{path} is {got!r}, which has not the members {list(shown)}")
        for key in shown:
            same_shape(shown[key], got[key], f"{path}.{key}")
    elif isinstance(shown, (str, list)) != isinstance(got, (str, list)):
        fail(f"{path} is {got!r}, not like {shown!r}")


def laid_out(value, indent="", width=112):
    """JSON with line breaks only where a line gets too long, and around nested values."""
    line = json.dumps(value)
    if len(indent) + len(line) <= width or not isinstance(value, dict):
        return line
    inner, lines, flows = indent + "  ", [], False
    for key, member in value.items():
        text = f"{json.dumps(key)}: {laid_out(member, inner, width - len(key) - 4)}"
        simple = not isinstance(member, dict)
        if simple and flows and len(inner) + len(lines[-1]) + len(text) + 3 <= width:
            lines[-1] += ", " + text
        else:
            lines.append(text)
        flows = simple
    return "{\n" + ",\n".join(inner + text for text in lines) + "\n" + indent + "}"


# --- many machines ------------------------------------------------------------------------------------------------------


def check_cluster(page, build):
    """Follows the lines of docs/scaling.md, on a PostgreSQL of this test's and on ports that are free."""
    sys.path.insert(0, str(ROOT / "tests/cluster"))
    from postgres import Missing, Postgres
    from scratch import free_port

    lines, _ = block(page, "sh", "meshgauge migrate")
    try:
        database = Postgres()
    except Missing as reason:
        print(f"docs/scaling.md: its commands are not run: {reason}")
        return
    with database, tempfile.TemporaryDirectory() as folder:
        lines = re.sub(r"(?<=^export MESHGAUGE_DATABASE=).*", f"'{database.url()}'", lines, count=1, flags=re.M)
        lines = re.sub(r"(?<=[@ ])build/|^build/", f"{build}/", lines, flags=re.M)
        for port in sorted(set(re.findall(r"(?<=--port )\d+", lines))):
            lines = lines.replace(port, str(free_port()))
        script = f"trap 'kill $(jobs -p); wait' EXIT\nset -eu\n{lines}"
        done = subprocess.run(["bash", "-c", script], cwd=folder, env=ENVIRONMENT, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        fail(f"many machines: {done.stdout}{done.stderr}")
    same_shape({"lower": 0.0, "upper": 0.0}, json.loads(done.stdout.splitlines()[-1])["distance"], "distance")  # after what migrate says


# --- the settings ------------------------------------------------------------------------------------------------------


def settings_of(build):
    """[(flag, default, meaning)] from `meshgauge serve --help`."""
    text = subprocess.run([build / "meshgauge", "serve", "--help"], env=ENVIRONMENT, capture_output=True, text=True,
                          check=True).stdout
    # CLI11 shows a default as `UINT=8080` in its version 2.3, as `UINT [8080] ` in 2.4; a flag has none.
    found = [(flag, default or bracketed, variable, meaning) for flag, default, bracketed, variable, meaning in re.findall(
        r"^ +(--[a-z0-9-]+)(?: [A-Z]+(?:=(\S*)| \[(\S*)\])?)? +\(Env:(\w+)\)\s+(.*)$", text, re.M)]
    for flag, _, variable, _ in found:
        if variable != "MESHGAUGE_" + flag[2:].replace("-", "_").upper():
            fail(f"{flag} has the variable {variable}")
    # --print-config sets nothing and has no variable.
    if len(found) != len(re.findall(r"^ +--(?!print-config)", text, re.M)):
        fail(f"the help has flags that are not understood:\n{text}")
    return [(flag, default, meaning.strip()) for flag, default, _, meaning in found]


TABLE = re.compile(r"(?<=^\| flag \| default \| meaning \|\n\|---\|---\|---\|\n)(?:\|.*\n)+", re.M)


def rows_of(page):
    table = TABLE.search(page) or fail("no table of settings")
    rows = [[cell.strip() for cell in re.split(r"(?<!\\)\|", row)[1:4]] for row in table[0].splitlines()]
    return [(flag.strip("`"), default.strip("`"), meaning) for flag, default, meaning in rows]


def check_settings(page, build):
    shown, real = rows_of(page), settings_of(build)
    for row in real:
        if row not in shown:
            fail(f"the table of settings has not {row}")
    for row in shown:
        if row not in real:
            fail(f"the table of settings has {row}, which `meshgauge serve --help` has not")


# --- size and links ----------------------------------------------------------------------------------------------------


def anchors(text):
    """The anchors of a page's headings, as GitHub makes them."""
    return {re.sub(r"[^\w -]", "", heading).strip().lower().replace(" ", "-") for heading in re.findall(r"^#+ (.*)$", text, re.M)}


def check_links():
    """Every link of every page leads to a file, and to a heading where it names one."""
    for page in [README, ROOT / "CHANGELOG.md", *sorted((ROOT / "docs").rglob("*.md")), *sorted((ROOT / "docker").rglob("*.md"))]:
        text = re.sub(r"^```.*?^```$", "", page.read_text(), flags=re.M | re.S)
        for target in re.findall(r"\]\(([^)\s]+)\)", text):
            path, _, anchor = target.partition("#")
            if ":" in path:
                continue
            file = page.parent / path if path else page
            if not file.exists():
                fail(f"{page.relative_to(ROOT)} links to {target}, which is not there")
            if anchor and file.suffix == ".md" and anchor not in anchors(file.read_text()):
                fail(f"{page.relative_to(ROOT)} links to {target}, which has no such heading")


def check_size(readme):
    lines, words = readme.count("\n"), len(readme.split())
    if lines > MAX_LINES or words > MAX_WORDS:
        fail(f"README.md has {lines} lines and {words} words, at most {MAX_LINES} and {MAX_WORDS} are allowed")


# --- all of it ---------------------------------------------------------------------------------------------------------


def response_of(page):
    return json.loads(block(page, "json", '"distance"')[0])


def check(build):
    readme = README.read_text()
    check_size(readme)
    check_links()
    request = request_of(readme)
    if request.replace(ADDRESS, "%s") not in (ROOT / "dev").read_text():
        fail(f"./dev run prints another line than {request!r}")
    example = block(LIBRARY.read_text(), "cpp", "meshgauge::measure")[0]
    if example not in (ROOT / "tests/consumer/main.cpp").read_text().replace("\n  ", "\n"):
        fail("the C++ of docs/library.md is not the one that tests/consumer/main.cpp compiles")
    check_settings(SETTINGS.read_text(), build)
    shown = response_of(API.read_text())
    part_of(response_of(readme), shown)
    with service(build) as address:
        got = ask(request, address, build)
        if not has_pages(address):
            del shown["view"]
        same(shown, got)
        overlap(shown, got)
        check_jobs(API.read_text(), address, build)
    verbs = subprocess.run([build / "meshgauge", "--help"], env=ENVIRONMENT, capture_output=True, text=True, check=True).stdout
    if "  worker " in verbs:
        check_cluster(SCALING.read_text(), build)
    print(f"README.md holds: {request}\n{json.dumps(got['distance'])}")


def update(build):
    with service(build) as address:
        got = ask(request_of(README.read_text()), address, build)
    for page in (README, API):
        text = page.read_text()
        _, (start, end) = block(text, "json", '"distance"')
        shown = cut(response_of(text), got) if page == README else got
        page.write_text(text[:start] + laid_out(shown) + "\n" + text[end:])
    rows = "".join(f"| `{flag}` | {f'`{default}` ' if default else ''}| {meaning} |\n"
                   for flag, default, meaning in settings_of(build))
    SETTINGS.write_text(TABLE.sub(lambda _: rows, SETTINGS.read_text()))


if __name__ == "__main__":
    if len(sys.argv) < 2 or sys.argv[2:] not in ([], ["--update"]):
        sys.exit(__doc__)
    (update if sys.argv[2:] else check)(pathlib.Path(sys.argv[1]).resolve())
