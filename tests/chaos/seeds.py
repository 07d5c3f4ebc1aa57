"""The date as a seed: of a campaign, as an argument, and of the part of many things that is tried today."""

import os
import time


def seed(text):
    """A number; `today`: the date in UTC, as 20261129, so that each day's tests try something else, all day the same."""
    return int(time.strftime("%Y%m%d", time.gmtime()) if text == "today" else text)


def todays(things, parts):
    """Those of the list that are tried today, one of so many parts; MESHGAUGE_SEED is another day's, or `all`."""
    day = os.environ.get("MESHGAUGE_SEED") or "today"
    return things if day == "all" else things[seed(day) % parts::parts]
