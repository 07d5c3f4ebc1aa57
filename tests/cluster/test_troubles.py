"""Runs troubles.py with leases of 1.5 s, each on a database of its own."""

import unittest

import troubles
from postgres import Missing, Postgres

POSTGRES = None


def setUpModule():
    global POSTGRES
    try:
        POSTGRES = Postgres()
    except Missing as reason:
        raise unittest.SkipTest(str(reason)) from None


def tearDownModule():
    if POSTGRES is not None:
        POSTGRES.close()


class Troubles(unittest.TestCase):
    def test_a_worker_that_was_stopped_past_its_lease(self):
        print(troubles.stopped(postgres=POSTGRES))

    def test_a_job_that_kills_its_workers(self):
        print(troubles.poison(postgres=POSTGRES))

    def test_the_database_is_gone(self):
        print(troubles.gone(1.5, postgres=POSTGRES))

    def test_a_worker_that_is_asked_to_end(self):
        print(troubles.drained(postgres=POSTGRES))

    def test_a_front_end_that_dies(self):
        print(troubles.broken(postgres=POSTGRES))


if __name__ == "__main__":
    unittest.main()
