"""Whether the end-to-end tests have seen all that openapi.yaml declares: coverage.py FOLDER SUITE...

Each suite leaves in FOLDER what it has seen (MESHGAUGE_CONTRACT_SEEN). Prints each operation with its statuses, and fails
when one of them, or a problem's type, was never seen, but for the exceptions below.
"""

import json
import os
import sys
from pathlib import Path

from contract import ANY_REQUEST, BY_STATUS, OPENAPI, OPERATIONS

SANITIZED = bool(os.environ.get("MESHGAUGE_SANITIZED"))
BUILT_WITHOUT_PAGES = os.environ.get("MESHGAUGE_DOCS") == "0"
PAGES = ("root", "showBatch", "showComparison", "getPageFile", "showReference", "getReferenceFile")


def excused(operation, status):
    """The reason why no test can see this answer; None: a test must."""
    if status == 500:
        return "only a fault of the service gives it"
    if operation == "showReference" and status == 404 and not BUILT_WITHOUT_PAGES:
        return "a service is built either with its pages or without"
    if operation in PAGES and status in (200, 304) and BUILT_WITHOUT_PAGES and (operation, status) != ("root", 200):
        return "built without the pages"
    if status == 507 and SANITIZED:
        return "a disk is made to fail by a library that a sanitizer does not let come first"
    return None


def declared():
    pairs = {(operation.id, int(status)) for operation in OPERATIONS for status in operation.responses if status != "default"}
    pairs |= {("any operation", int(status)) for status in BY_STATUS}
    return pairs | {("no operation", int(status)) for status in ANY_REQUEST if status != "default"}


def main(folder, suites):
    pairs, problems, defects = set(), set(), []
    for suite in suites:
        file = Path(folder) / (suite + ".json")
        if not file.exists():
            defects.append("e2e.%s has left nothing: run all of them" % suite)
            continue
        seen = json.loads(file.read_text())
        pairs |= {tuple(pair) for pair in seen["pairs"]} | {("any operation", status) for _, status in seen["pairs"]}
        problems |= {slug for _, slug in seen["problems"]}
    for name in sorted({name for name, _ in declared()}):
        statuses = sorted(status for operation, status in declared() if operation == name)
        print("%-18s" % name, *(status if (name, status) in pairs else "(%d)" % status for status in statuses))
    for name, status in sorted(declared() - pairs):
        reason = excused(name, status)
        print("%s %d: %s" % (name, status, reason)) if reason else defects.append("%s never answered %d" % (name, status))
    defects += ["no test saw the problem " + slug for slug in OPENAPI["components"]["examples"]
                if slug not in problems | {"internal"} and not (SANITIZED and slug.startswith("storage-"))]
    print("%d of %d pairs of operation and status were seen" % (len(pairs & declared()), len(declared())))
    for defect in defects:
        print("coverage:", defect, file=sys.stderr)
    return 1 if defects else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], sys.argv[2:]))
