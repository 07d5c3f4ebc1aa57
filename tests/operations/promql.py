"""What a PromQL query asks for: enough of its grammar to name metrics and label matchers, not to evaluate them."""
import re

WORDS = {
    "by", "without", "and", "or", "unless", "on", "ignoring", "group_left", "group_right", "offset", "bool",
    "sum", "min", "max", "avg", "count", "topk", "quantile",
    "rate", "increase", "irate", "changes", "delta", "deriv", "predict_linear", "histogram_quantile", "clamp_max",
    "clamp_min", "absent", "time", "vector",
}  # fmt: skip
STRING = re.compile(r'"(?:[^"\\]|\\.)*"')
MATCHER = re.compile(r'\s*([a-zA-Z_]\w*)\s*(=~|!~|!=|=)\s*"((?:[^"\\]|\\.)*)"\s*(?:,|$)')


def selectors(query):
    """[(metric, [(label, operator, value)])], in the order of the query."""
    found = []
    hidden = STRING.sub(lambda match: '"' + "x" * (len(match[0]) - 2) + '"', query)  # braces in strings are none
    for match in re.finditer(r"([a-zA-Z_:][\w:]*)\s*(\{[^}]*\})?", hidden):
        name, braces = match[1], match[2]
        if _is_metric(hidden, match):
            found.append((name, matchers(query[match.start(2) + 1 : match.end(2) - 1]) if braces else []))
    return found


def _is_metric(query, match):
    before, after = query[: match.start()], query[match.end(1) :].lstrip()
    if match[1] in WORDS:
        return False
    inside = before.count("{") > before.count("}") or before.count("[") > before.count("]") or before.count('"') % 2
    if inside or re.search(r"[\d$.]$", before):  # 1e9, 5m, $__rate_interval
        return False
    return not (re.search(r"\b(by|without|on|ignoring)\s*\([^)]*$", before) or after.startswith("("))


def matchers(text):
    found, at = [], 0
    while at < len(text.rstrip()):
        match = MATCHER.match(text, at)
        if not match:
            raise ValueError(f"not a list of matchers: {text!r}")
        found.append((match[1], match[2], match[3]))
        at = match.end()
    return found


def groupings(query):
    """The labels that it groups by."""
    return {
        label.strip()
        for match in re.finditer(r"\b(?:by|without|on|ignoring)\s*\(([^)]*)\)", STRING.sub('""', query))
        for label in match[1].split(",")
        if label.strip()
    }


def functions(query):
    """Called words that are not known functions."""
    return set(re.findall(r"\b([a-zA-Z_]\w*)\s*\(", STRING.sub('""', query))) - WORDS


def exposed(text):
    """{sample name: {label: {values}}} of a page in the text format."""
    found = {}
    for line in text.splitlines():
        if not line or line.startswith("#"):
            continue
        name, labels = re.fullmatch(r"([a-zA-Z_:][\w:]*)(?:\{(.*)\})? \S+", line).groups()
        of = found.setdefault(name, {})
        for label, _, value in matchers(labels or ""):
            of.setdefault(label, set()).add(value)
    return found


def families(text):
    """{name: type}"""
    return dict(re.findall(r"^# TYPE (\S+) (\S+)$", text, re.M))
