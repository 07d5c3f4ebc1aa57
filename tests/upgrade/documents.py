"""What of a document one version wrote another one does not say."""

import datetime
import re

TIMES = ("created", "started", "finished", "expires", "last_used")


def milliseconds(text):
    return round(datetime.datetime.fromisoformat(text.replace("Z", "+00:00")).timestamp() * 1000)


def lost(before, now, shift_ms=0, where=""):
    """What of a document is gone or has changed. It may have got more members; its times are those of the shifted store."""
    if isinstance(before, dict) and isinstance(now, dict):
        for name, value in before.items():
            if name not in now:
                yield "%s.%s is gone" % (where, name)
            elif name == "type" and is_problem(before):
                if slug_of(now[name]) != slug_of(value):
                    yield "%s.type is %s, promised was %s" % (where, now[name], value)
            elif name in TIMES and value is not None and now[name] is not None:
                if milliseconds(now[name]) != milliseconds(value) + shift_ms:
                    yield "%s.%s is %s, promised was %s" % (where, name, now[name], value)
            else:
                yield from lost(value, now[name], shift_ms, where + "." + name)
    elif isinstance(before, list) and isinstance(now, list) and len(before) == len(now):
        for number, (one, other) in enumerate(zip(before, now)):
            yield from lost(one, other, shift_ms, "%s[%d]" % (where, number))
    elif before != now:
        yield "%s is %s, promised was %s" % (where, now, before)


def is_problem(document):
    return {"type", "title", "status"} <= document.keys()


def slug_of(problem_type):
    """The last word. Until schema 7 types were urn:meshgauge:problem:WORD; problems that are kept are served as they were written."""
    return re.split("[:/]", problem_type)[-1]
