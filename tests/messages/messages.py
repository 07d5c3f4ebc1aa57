#!/usr/bin/env python3
"""docs/messages.md: every refusal that bad files, flags, manifests and requests provoke.

  messages.py            makes the page anew and fails if it differs from docs/messages.md
  messages.py --update   writes it

The program is MESHGAUGE_BINARY, build/meshgauge by default.
"""

import difflib
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import textwrap
from concurrent.futures import ThreadPoolExecutor

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tests/e2e"), str(pathlib.Path(__file__).parent)]

import contract  # noqa: E402
import refused_flags  # noqa: E402
import refused_requests  # noqa: E402
from broken_files import GOOD, all_files  # noqa: E402
from broken_gltf import SCENE_FILES, scene  # noqa: E402
from harness import BINARY, ENVIRONMENT, Server, multipart, post_head  # noqa: E402

contract.check = lambda request, answer: None  # tests/e2e holds answers against openapi.yaml

PAGE = ROOT / "docs/messages.md"
MANIFESTS = ROOT / "tests/check/manifests"
PLAIN = {**ENVIRONMENT, "LC_ALL": "C", "NO_COLOR": "1"}
NOT_REFUSED = "NOT REFUSED"
BEGINNING = """# Messages: what each refusal says

For users: every message of `meshgauge compare`, `meshgauge check` and the service that a test can
provoke, with what provokes it. A message says what is wrong, where, and what to do about it. In
messages about meshes the service says `'a'` and `'b'` where the command line names the file.

This page is made by `tests/messages/messages.py --update`, and a test compares it with what the
program says.
"""

KINDS = """
## Kinds of problems

The `type` of a problem, `/problems/` and its kind, is the path of a page of the service that says
what stands here. Kinds are never renamed.
"""


def shown(text):
    """Text as a cell of a table."""
    for old, new in (("\\", "\\\\"), ("|", "\\|"), ("<", "&lt;"), ("*", "\\*"), ("\n", "<br>")):
        text = text.replace(old, new)
    return text


def table(heading, columns, rows, words=""):
    lines = [f"\n## {heading}\n", *([words + "\n"] if words else []),
             "| " + " | ".join(columns) + " |", "|" + "---|" * len(columns)]
    lines += ["| " + " | ".join(shown(cell) for cell in row) + " |" for row in rows]
    return "\n".join(lines) + "\n"


def steady(text):
    """Without the name of the program and what differs between runs."""
    text = re.sub(r"^meshgauge: ", "", text.strip(), flags=re.M)
    text = re.sub(r"\d+\.\d\d s\b", "T s", text)
    # The last digits are the machine's.
    return re.sub(r"\d+\.\d{8,}(e-\d+)?", lambda number: f"{round(float(number[0]), 6):g}", text)


def run(folder, arguments, **more):
    """Exit code, standard output and standard error."""
    # A service that is not refused takes a free port, not one of another service.
    kept = {**PLAIN, "MESHGAUGE_DATA_DIR": "data", "MESHGAUGE_PORT": "0"}
    done = subprocess.run([BINARY, *arguments], cwd=folder, env=kept, text=True, capture_output=True, check=False,
                          timeout=60, stdin=subprocess.DEVNULL if "input" not in more else None, **more)
    return done.returncode, done.stdout, steady(done.stderr)


def write(folder, files):
    for name, content in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(content if isinstance(content, bytes) else content.encode())


# --- mesh files -------------------------------------------------------------------------------------------------------


def advice_of(folder, name):
    """What `check` says of a gate with this candidate."""
    code, out, err = run(folder, ["check", name, "good.obj", "--max-distance", "1", "--json"])
    assert code == 3, (name, code, err)
    return json.loads(out)["gates"][0]["advice"]


def about_file(place, name, files):
    """(message of compare, what check adds)"""
    with tempfile.TemporaryDirectory(dir=place) as made:
        folder = pathlib.Path(made)
        write(folder, {"good.obj": GOOD, **files})
        code, _, message = run(folder, ["compare", name, "good.obj"])
        if code != 3:
            return f"{NOT_REFUSED}: exit code {code}", ""
        return message, advice_of(folder, name).removeprefix(message).removeprefix(".").strip()


def answer_cells(answer):
    """Status and kind of a problem, and its detail."""
    if answer is None or answer.status < 400:
        return NOT_REFUSED, str(answer and answer.status), ""
    problem = answer.json()
    places = [":".join(filter(None, (error["part"], error["where"]))) for error in problem["errors"]]
    # openapi.yaml lists the options; here one more would change the page.
    detail = re.sub(r"(unknown option '[^']*'; known: )[\w, ]+", r"\1…", problem["detail"])
    return (f"{answer.status} {problem['type'].removeprefix(contract.PROBLEMS)}", detail, ", ".join(filter(None, places)))


def kind_of(server, name, content):
    """Status and kind of the service's problem for the same file."""
    body = multipart([("a", content), ("b", GOOD)]).replace(b'filename="a.obj"', f'filename="{name}"'.encode())
    return answer_cells(server.raw(post_head(len(body)) + body))[0]


def file_tables(place, pool):
    columns = ("what is wrong", "HTTP", "message", "`check` adds")
    server = Server("--workers", "2")
    try:
        out = ""
        for heading, files in all_files():
            said = list(pool.map(lambda file: about_file(place, file[1], {file[1]: file[2]}), files))
            rows = [(what, kind_of(server, name, content), *cells) for (what, name, content), cells in zip(files, said)]
            out += table(heading, columns, rows)
    finally:
        server.stop()
    said = list(pool.map(lambda file: about_file(place, "part.gltf", {"part.gltf": scene(file[1]), **file[2]}), SCENE_FILES))
    return out + table("glTF with files beside it", ("what the buffer names", "message", "`check` adds"),
                       [(what, *cells) for (what, _, _), cells in zip(SCENE_FILES, said)])


# --- flags, manifests, settings ---------------------------------------------------------------------------------------


def command_table(folder, heading, rows, prefix=(), words=""):
    cells = []
    for what, arguments in rows:
        more = {"input": "short\n"} if arguments == ["keys", "hash"] else {}
        code, out, message = run(folder, [*prefix, *arguments], **more)
        if "check" in arguments[:1] and not message:
            message = steady(out)
        line = "`meshgauge " + " ".join(f"'{a}'" if not a or " " in a else a for a in arguments) + "`"
        cells.append((what, line, message if code not in (0, 2) else f"{NOT_REFUSED}: exit code {code}"))
    return table(heading, ("what is wrong", "command", "message"), cells, words)


def check_pairs(folder, rows):
    """`check` of two files prints its advice on standard output."""
    out = []
    for what, arguments in rows:
        code, text, message = run(folder, arguments)
        assert code in (1, 3), (arguments, code, text, message)
        lines = [line for line in text.splitlines() if line.startswith("    ")]
        errors = "\n".join(line for line in message.splitlines() if not line.startswith("[1/1]"))
        out.append((what, "`" + " ".join(f"'{a}'" if not a or " " in a else a for a in arguments) + "`",
                    errors or steady("\n".join(line.strip() for line in lines))))
    return table("Flags of `meshgauge check`", ("what is wrong", "command", "message"), out)


def gate_table(folder):
    rows = []
    for what, text in refused_flags.gates():
        write(folder, {"gates.yaml": text})
        _, out, err = run(folder, ["check", "gates.yaml", "--json"])
        gate = json.loads(out)["gates"][0]
        assert gate["verdict"] != "pass", (what, err)
        rows.append((what, gate["verdict"], steady(gate["advice"])))
    return table("Gates that do not pass", ("what is so", "verdict", "advice"), rows)


def manifest_table(place):
    folder = place / "manifests"
    shutil.copytree(MANIFESTS, folder)
    rows = []
    for file in sorted((folder / "wrong").glob("*.yaml")):
        code, _, message = run(folder / "wrong", ["check", file.name])
        assert code == 3, file
        if message.startswith("[1/"):  # an error of one gate
            report = json.loads(run(folder / "wrong", ["check", file.name, "--json"])[1])
            message = "; ".join("%s:%s: %s" % (file.name, gate["name"], gate["error"]["message"]) for gate in report["gates"] if gate["error"])
        rows.append((file.stem.replace("_", " "), message))
    return table("Manifests", ("what is wrong", "message"), rows,
                 "The manifests are those of [tests/check/manifests/wrong](../tests/check/manifests/wrong).")


def flag_tables(folder):
    write(folder, {**refused_flags.FILES, **refused_flags.CHECK_FILES, **refused_flags.SERVICE_FILES})
    return (command_table(folder, "Flags of `meshgauge compare`", refused_flags.compare_flags())
            + check_pairs(folder, refused_flags.check_flags())
            + gate_table(folder)
            + manifest_table(folder)
            + command_table(folder, "Settings of `meshgauge serve`, its files of settings and keys",
                            [(what, ["serve", *arguments]) for what, arguments in refused_flags.service_flags()])
            + command_table(folder, "Other subcommands", refused_flags.other_verbs()))


# --- requests ---------------------------------------------------------------------------------------------------------


def request_tables():
    columns = ("what is wrong", "HTTP", "detail", "part and place")
    return "".join(table(heading, columns, [(what, *answer_cells(answer)) for what, answer in rows])
                   for heading, rows in refused_requests.sections())


def kinds():
    """What the service's pages say of each kind of problem."""
    server = Server("--workers", "1")
    try:
        listed = re.findall(r'<a href="/problems/([a-z-]+)">', server.get("/problems").body.decode())
        pages = {slug: server.get(contract.PROBLEMS + slug).body.decode() for slug in listed}
    finally:
        server.stop()
    assert set(pages) == set(contract.OPENAPI["components"]["examples"]), listed
    out = KINDS
    for slug, text in pages.items():
        title, status, words = re.search(r"<h1>(.*)</h1>\n<p><code>[a-z-]+</code>, HTTP status (\d+)</p>\n<p>(.*)</p>\n", text).groups()
        out += f"\n### {slug}\n\n" + textwrap.fill(f"{title} (HTTP status {status}). {words}", 100, break_on_hyphens=False) + "\n"
    return out


def page():
    with tempfile.TemporaryDirectory() as made, ThreadPoolExecutor(4) as pool:
        place = pathlib.Path(made)
        (place / "flags").mkdir()
        text = BEGINNING + file_tables(place, pool) + flag_tables(place / "flags") + request_tables() + kinds()
    for private in (made, str(ROOT)):
        assert private not in text, f"the page names the folder {private}"
    accepted = [line for line in text.splitlines() if NOT_REFUSED in line]
    if accepted:
        sys.exit("\n".join(["these should be refused:", *accepted]))
    return text


def main():
    if sys.argv[1:] not in ([], ["--update"]):
        sys.exit(__doc__)
    made = page()
    if sys.argv[1:]:
        PAGE.write_text(made)
    elif made != PAGE.read_text():
        sys.stdout.writelines(difflib.unified_diff(PAGE.read_text().splitlines(True), made.splitlines(True), "docs/messages.md", "the program"))
        sys.exit("docs/messages.md is not what the program says; read the difference, then: tests/messages/messages.py --update")


if __name__ == "__main__":
    main()
