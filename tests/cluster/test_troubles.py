"""Runs troubles.py with leases of 1.5 s, most of it on one cluster: no process requeues jobs in its first 15 s."""

import os
import unittest

import troubles
from postgres import Missing, Postgres

POSTGRES = RIG = None


def setUpModule():
    global POSTGRES, RIG
    try:
        POSTGRES = Postgres()
    except Missing as reason:
        raise unittest.SkipTest(str(reason)) from None
    unittest.addModuleCleanup(POSTGRES.close)
    RIG = troubles.rig_of(troubles.BRIEF, POSTGRES)
    unittest.addModuleCleanup(RIG.stop)


class Troubles(unittest.TestCase):
    def test_a_worker_that_was_stopped_past_its_lease(self):
        print(troubles.stopped(RIG))

    def test_a_job_that_kills_its_workers(self):
        print(troubles.poison(RIG))

    def test_a_worker_that_is_asked_to_end(self):
        print(troubles.drained(RIG))

    def test_a_front_end_that_dies(self):
        print(troubles.broken(RIG))

    def test_the_database_is_gone(self):
        with troubles.rig_of(troubles.BRIEF_WITH_LEASES, POSTGRES) as rig:
            print(troubles.gone(rig, 1.5))

    @unittest.skipIf(os.environ.get("MESHGAUGE_SANITIZED"), "a sanitizer comes before every other library")
    def test_clocks_that_disagree(self):
        with troubles.clocks_rig(troubles.BRIEF_WITH_LEASES, POSTGRES) as rig:
            print(troubles.clocks(rig))


if __name__ == "__main__":
    unittest.main()
