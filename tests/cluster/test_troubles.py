"""Runs troubles.py with leases of 1.5 s."""

import unittest

import troubles
from postgres import Missing, find_binaries


def there_is_none():
    try:
        find_binaries()
        return False
    except Missing:
        return True


@unittest.skipIf(there_is_none(), "no PostgreSQL: ./dev test brings it")
class Troubles(unittest.TestCase):
    def test_a_worker_that_was_stopped_past_its_lease(self):
        print(troubles.stopped())

    def test_a_job_that_kills_its_workers(self):
        print(troubles.poison())

    def test_the_database_is_gone(self):
        print(troubles.gone(1.5))

    def test_a_worker_that_is_asked_to_end(self):
        print(troubles.drained())

    def test_a_front_end_that_dies(self):
        print(troubles.broken())


if __name__ == "__main__":
    unittest.main()
