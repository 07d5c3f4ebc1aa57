"""The seed of a campaign, as an argument."""

import time


def seed(text):
    """A number; `today`: the date in UTC, as 20261129, so that each day's tests try something else, all day the same."""
    return int(time.strftime("%Y%m%d", time.gmtime()) if text == "today" else text)
