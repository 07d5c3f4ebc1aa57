"""The HTML report as others see it: a validator, and a browser without a network.

page_test.py MAKE_REPORT FOLDER TOOLS: writes a report of every kind of gate into FOLDER, and leaves the screenshots in
FOLDER/screenshots. Exit code 77: there is no npm or no chromium."""

import json
import pathlib
import shutil
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent / "reports"), str(HERE.parents[1] / "chaos")]
import npm_tools  # noqa: E402
from seeds import todays  # noqa: E402

CHROMIUM = ("chromium", "chromium-browser", "google-chrome")


def validate(modules, page):
    """The messages of html-validate, by its recommended and its accessibility rules."""
    told = page.with_suffix(".validated.json")  # a file: it ends before a pipe has taken all
    with open(told, "w", encoding="utf-8") as out:
        subprocess.run([modules / ".bin" / "html-validate", "--config", HERE / "htmlvalidate.json", "--formatter", "json", page],
                       stdout=out)
    results = json.loads(told.read_text(encoding="utf-8"))
    return [f"{m['line']}:{m['column']} {m['ruleId']}: {m['message']}" for r in results for m in r["messages"]]


def show(seen):
    for shot in seen["views"]:
        axe = f"{len(shot['findings'])} serious findings of axe, " if shot["checked"] else ""
        print(f"{shot['name']}: {shot['requests']} requests, {axe}{shot['width']} of {shot['room']} pixels wide")


def problems_of(seen):
    problems = []
    for shot in seen["views"]:
        if shot["requests"]:
            problems.append(f"{shot['name']}: asked for {shot['asked']}")
        if shot["width"] > shot["room"]:
            problems.append(f"{shot['name']}: {shot['width']} pixels wide in a window of {shot['room']}")
        problems += [f"{shot['name']}: the name '{word}' is broken" for word in shot["broken"]]
        problems += [f"{shot['name']}: axe: {finding}" for finding in shot["findings"]]
        problems += [f"{shot['name']}: console: {line}" for line in shot["console"]]
    problems += [f"filter: {line}" for line in seen["filter"]]
    return problems + [f"pictures: {line}" for line in seen["pictures"]]


def main(make_report, folder, tools):
    browser = next((path for path in map(shutil.which, CHROMIUM) if path), None)
    modules = npm_tools.installed(tools, HERE)
    if not modules or not browser:
        print("SKIP: there is no", "chromium" if modules else "npm")
        return 77
    folder = pathlib.Path(folder)
    page = folder / "report.html"
    made = subprocess.run([make_report, page, folder / "meshes"], stdout=subprocess.PIPE, text=True, errors="replace", check=True)
    kinds = {line.split("\t")[0] for line in made.stdout.splitlines()}
    problems = [f"no gate of the report is {kind}" for kind in {"pass", "fail", "undecided", "error"} - kinds]
    problems += [f"html-validate: {message}" for message in validate(modules, page)]
    print(f"html-validate: {len(problems)} problems, {page.stat().st_size} bytes")
    shutil.copy(HERE / "look.mjs", modules.parent)
    (folder / "screenshots").mkdir(exist_ok=True)
    by_axe = todays(["light", "dark", "narrow"], 3)
    seen = subprocess.run(["node", modules.parent / "look.mjs", browser, page, folder / "screenshots", *by_axe],
                          stdout=subprocess.PIPE, text=True, check=True)
    seen = json.loads(seen.stdout)
    show(seen)
    problems += problems_of(seen)
    problems += [f"axe did not see {name}" for name in by_axe if name not in {shot["name"] for shot in seen["views"] if shot["checked"]}]
    print("\n".join(problems))
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
