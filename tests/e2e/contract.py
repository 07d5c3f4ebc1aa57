"""openapi.yaml as a judge: of every answer, and of every request that was accepted or refused for its content.

What openapi.yaml does not declare is a failure: an operation's status, a header, a media type, a member, a problem's type.
"""

import atexit
import json
import os
import re
from pathlib import Path

import jsonschema
import yaml

ROOT = Path(__file__).resolve().parents[2]
OPENAPI = yaml.load((ROOT / "openapi.yaml").read_text(), yaml.CSafeLoader)
PROBLEMS = "/problems/"


def close(node):
    """Clients have to take members that they do not know; this service has none that its description does not name."""
    if isinstance(node, list):
        for one in node:
            close(one)
    if isinstance(node, dict):
        if node.get("type") == "object" and "properties" in node and not {"allOf", "anyOf", "oneOf"} & set(node):
            node.setdefault("additionalProperties", False)
        for one in node.values():
            close(one)


close(OPENAPI["components"]["schemas"])

# What HTTP itself, TLS in front of it or a browser's rules add to any answer.
OF_HTTP = {"content-type", "content-length", "connection", "transfer-encoding", "tracestate", "vary",
           "access-control-allow-origin", "access-control-expose-headers"}
ALWAYS = {"x-content-type-options": "nosniff", "referrer-policy": "no-referrer"}
KEPT = ("no-store", "no-cache", "private, no-cache", "public, max-age=3600", "public, max-age=31536000, immutable")


class Violation(AssertionError):
    pass


def demand(condition, *what):
    if not condition:
        raise Violation(" ".join(str(part)[:2000] for part in what))


# --- schemas ----------------------------------------------------------------------------------------------------------

# 1e3 is an integer to JSON Schema, and not to the service; a float has been one in the text.
STRICT = jsonschema.validators.extend(
    jsonschema.Draft202012Validator,
    type_checker=jsonschema.Draft202012Validator.TYPE_CHECKER.redefine("integer", lambda _, x: type(x) is int))
RESOLVER = jsonschema.RefResolver("", OPENAPI)


def defect(value, schema):
    """The violation, or None."""
    error = jsonschema.exceptions.best_match(STRICT(schema, resolver=RESOLVER).iter_errors(value))
    return error and "%s at %s" % (error.message, "/".join(map(str, error.absolute_path)))


def hold(value, schema, what):
    wrong = defect(value, schema)
    demand(wrong is None, what, "is not as its schema says:", wrong)


HELD = set()  # texts and the schemas that they hold: a client that polls gets the same document again and again


def hold_text(text, schema, what):
    """hold() of a JSON document."""
    if (text, id(schema)) not in HELD:
        hold(parse(text), schema, what)
        if len(text) < 10_000:
            HELD.add((text, id(schema)))


def validate(value, name):
    hold(value, {"$ref": "#/components/schemas/" + name}, name)


def without_repeats(pairs):
    if len({name for name, _ in pairs}) != len(pairs):
        raise ValueError("a name stands there twice")
    return dict(pairs)


def no_constant(name):
    raise ValueError(name)


def parse(text):
    """JSON as RFC 8259 has it, in UTF-8; a ValueError for NaN, and for names that repeat."""
    text = text.decode("utf-8-sig") if isinstance(text, (bytes, bytearray)) else text
    return json.loads(text, object_pairs_hook=without_repeats, parse_constant=no_constant)


def resolved(node):
    while "$ref" in node:
        place = OPENAPI
        for name in node["$ref"].removeprefix("#/").split("/"):
            place = place[name.replace("~1", "/")]
        node = place
    return node


# --- operations -------------------------------------------------------------------------------------------------------


class Operation:
    def __init__(self, path, method, node, parameters):
        self.path, self.method, self.id = path, method.upper(), node["operationId"]
        self.responses = node["responses"]
        self.parameters = [resolved(parameter) for parameter in parameters + node.get("parameters", [])]
        self.body = node.get("requestBody")
        self.open = node.get("security") == []


METHODS = ("get", "head", "post", "put", "delete")
OPERATIONS = [Operation(path, method, node[method], node.get("parameters", []))
              for path, node in OPENAPI["paths"].items() for method in METHODS if method in node]
ANY_REQUEST = OPENAPI["x-any-request"]["responses"]
BY_STATUS = OPENAPI["components"]["responses"]["Problem"]["x-by-status"]


def matches(template, path):
    """Matches like the router: braces stand for one segment that is not empty."""
    before, brace, rest = template.partition("{")
    if not brace:
        return path == template
    after = rest.partition("}")[2]
    middle = path[len(before):len(path) - len(after)]
    return (len(path) > len(before) + len(after) and path.startswith(before) and path.endswith(after)
            and "/" not in middle)


def operations_at(path):
    return [operation for operation in OPERATIONS if matches(operation.path, path)]


def operation_of(method, path):
    there = {operation.method: operation for operation in operations_at(path)}
    return there.get(method) or (there.get("GET") if method == "HEAD" else None)


def allowed_at(path):
    methods = {operation.method for operation in operations_at(path)}
    return methods | ({"HEAD"} if "GET" in methods else set())


# --- answers ----------------------------------------------------------------------------------------------------------


class Seen:
    """Which answers of which operations there were; left in a file for coverage.py when it is named."""

    def __init__(self):
        self.pairs = set()
        self.problems = set()

    def leave(self, file):
        Path(file).parent.mkdir(parents=True, exist_ok=True)
        Path(file).write_text(json.dumps({"pairs": sorted(self.pairs), "problems": sorted(self.problems)}))


SEEN = Seen()
if "MESHGAUGE_CONTRACT_SEEN" in os.environ:
    atexit.register(lambda: SEEN.leave(os.environ["MESHGAUGE_CONTRACT_SEEN"]))


def check(request, answer):
    """`request` is None when nothing that could be one was sent."""
    operation = operation_of(request.method, request.path) if request and request.path else None
    name = operation.id if operation else "no operation"
    what = "%s: %d" % (name, answer.status)
    responses = operation.responses if operation else ANY_REQUEST
    declared = responses.get(str(answer.status), BY_STATUS.get(str(answer.status)) if "default" in responses else None)
    demand(declared is not None, what, "is not declared", request, answer.body)
    declared = resolved(declared)
    check_headers(declared.get("headers", {}), answer, what)
    if operation and answer.status < 400:
        check_accepted(operation, request)
    empty = request is not None and request.method == "HEAD"
    check_body(declared.get("content"), answer, what, empty)
    if answer.status >= 400 and not empty and not answer.headers["content-type"].startswith("text/html"):
        slug = check_problem(declared, answer, what)
        check_refused(operation, request, slug, answer.json())
        SEEN.problems.add((name, slug))
    check_answer_of(operation, request, answer, what)
    SEEN.pairs.add((name, answer.status))


def check_headers(declared, answer, what):
    declared = {name.lower(): resolved(header) for name, header in declared.items()}
    for name, value in ALWAYS.items():
        demand(answer.headers.get(name) == value, what, "has not", name, answer.headers)
    demand(answer.headers.get("cache-control") in KEPT, what, answer.headers)
    for name, value in answer.headers.items():
        if name in declared:
            schema = declared[name]["schema"]
            hold(int(value) if schema.get("type") == "integer" else value, schema, "%s, header %s" % (what, name))
        else:
            demand(name in OF_HTTP or name in ALWAYS or name == "cache-control", what, "has an undeclared header:", name, value)
    for name, header in declared.items():
        demand(name in answer.headers or not header.get("required"), what, "has no header", name)


def check_body(content, answer, what, empty):
    if content is None:
        demand(not answer.body and "content-type" not in answer.headers and "content-length" not in answer.headers,
               what, "has a body", answer.headers, answer.body)
        return
    media_type = answer.headers.get("content-type", "").partition(";")[0]
    demand(media_type in content, what, "is", media_type, "and not one of", list(content))
    if empty:
        demand(not answer.body, what, "has a body")
    elif media_type.endswith("json"):
        hold_text(answer.body, content[media_type]["schema"], what)
    elif media_type == "application/jsonl":
        for line in answer.body.splitlines():
            hold_text(line, content[media_type]["x-lines"], what)
    elif media_type == "text/event-stream":
        check_events(content[media_type]["x-events"], answer.body, what)


def check_problem(declared, answer, what):
    problem = answer.json()
    demand(problem["status"] == answer.status, what, "says", problem)
    slug = problem["type"].removeprefix(PROBLEMS)
    demand(slug in declared["content"]["application/problem+json"]["examples"], what, "is a", slug, "which is not declared")
    return slug


def events_of(body):
    """Name and data of each server-sent event."""
    for block in body.decode().split("\n\n"):
        lines = [line for line in block.split("\n") if line and not line.startswith(":")]
        if lines:
            fields = dict(line.split(": ", 1) for line in lines)
            yield fields["event"], parse(fields["data"])


def check_events(schemas, body, what):
    for name, data in events_of(body):
        demand(name in schemas, what, "has an undeclared event", name)
        hold(data, schemas[name], "%s, event %s" % (what, name))


def check_answer_of(operation, request, answer, what):
    """What no schema can say."""
    if answer.status == 405:
        demand(set(answer.headers["allow"].split(", ")) == allowed_at(request.path), what, answer.headers["allow"])
    if operation and operation.id == "createComparison" and answer.status == 200 and "location" not in answer.headers:
        demand(answer.json()["id"] == answer.headers["x-request-id"], what, "has another id than its result")
    if answer.status == 202:
        demand(answer.headers["location"] == operation.path + "/" + answer.json()["id"], what, answer.headers)


# --- requests ---------------------------------------------------------------------------------------------------------


def check_accepted(operation, request):
    """What the service takes is what the description allows."""
    wrong = wrong_with(operation, request)
    demand(wrong is None, operation.id, "accepted what the description does not allow:", wrong)


def check_refused(operation, request, slug, problem):
    """... and what it refuses as invalid is what the description does not allow."""
    # No schema can say that a box is upside down, names are equal or a region has no surface, or that a matrix is rigid.
    in_words = any(error["where"].startswith(("/regions", "/align/")) for error in problem.get("errors", []))
    if slug == "invalid-request" and request.body is not None and not in_words:
        demand(wrong_with(operation, request) is not None, operation.id, "refused what the description allows:", request)


def as_typed(text, schema):
    """A parameter's text as the type that its schema asks for, if it can be read so."""
    if schema.get("type") == "boolean":
        return {"true": True, "false": False}.get(text, text)
    return int(text) if schema.get("type") == "integer" and text.isdigit() else text


def wrong_with(operation, request):
    path = re.fullmatch(re.sub(r"\{(\w+)\}", r"(?P<\1>[^/]+)", re.escape(operation.path).replace(r"\{", "{").replace(r"\}", "}")),
                        request.path)
    known = {parameter["name"] for parameter in operation.parameters if parameter["in"] == "query"}
    query = [field.partition("=") for field in request.query.split("&") if request.query]
    if (request.path.startswith("/v1/") and  # elsewhere one is ignored
            ({name for name, _, _ in query} - known or len({name for name, _, _ in query}) < len(query))):
        return "a query"
    given = {"path": path.groupdict(), "query": {name: value for name, _, value in query}, "header": request.headers}
    for parameter in operation.parameters:
        name, place = parameter["name"], parameter["in"]
        value = given[place].get(name.lower() if place == "header" else name)
        if value is not None and (wrong := defect(as_typed(value, parameter["schema"]), parameter["schema"])):
            return "%s: %s" % (name, wrong)
    return wrong_body(operation.body, request) if operation.body and request.body is not None else None


def wrong_body(declared, request):
    media_type = request.headers.get("content-type", "").partition(";")[0].strip().lower()
    if media_type not in declared["content"] and "*/*" not in declared["content"]:
        return "media type " + media_type
    if media_type == "application/json":
        return wrong_json(request.body, declared["content"][media_type]["schema"])
    if media_type == "multipart/form-data":
        return wrong_form(request, declared["content"][media_type]["schema"])
    return None


def wrong_json(text, schema):
    try:
        return defect(parse(text), schema)
    except (ValueError, RecursionError) as error:
        return "not JSON: %s" % error


def wrong_form(request, schema):
    boundary = re.search(r'(?i)boundary="?([^";]+)"?', request.headers["content-type"])[1].encode()
    parts, counts = {}, {}
    for part in (b"\r\n" + request.body).split(b"\r\n--" + boundary)[1:]:
        if part.startswith(b"--"):  # the closing boundary
            break
        head, _, content = part.partition(b"\r\n\r\n")
        name = re.search(rb'[; ]name="?([^";]+)"?', head)[1].decode()
        several = schema["properties"].get(name, {}).get("type") == "array"
        counts[name] = counts.get(name, 0) + 1
        if counts[name] > (schema["properties"][name]["maxItems"] if several else 1):
            return "the part %s %d times" % (name, counts[name])
        parts[name] = content
    missing, unknown = set(schema["required"]) - set(parts), set(parts) - set(schema["properties"])
    if missing or (unknown and not schema.get("additionalProperties")):
        return "parts missing: %s, unknown: %s" % (missing, unknown)
    documents = [name for name in ("options", "manifest") if name in parts and name in schema["properties"]]
    wrong = [wrong_json(parts[name], schema["properties"][name]) for name in documents]
    return next(filter(None, wrong), None)
