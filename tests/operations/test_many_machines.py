"""Front ends, workers and their database have what the dashboard, the alerts, docs/operations.md and KEDA query."""

import subprocess
import sys
import unittest

from harness import BINARY, ENVIRONMENT, RAISED, ROOT, SQUARE, multipart

import promql
from test_dashboard import DASHBOARDS, SHARED, alert_queries, dashboard_queries, listed

sys.path.insert(0, str(ROOT / "tests/cluster"))
from postgres import Missing, Postgres  # noqa: E402
from processes import Fleet, migrate, until  # noqa: E402
from scratch import Scratch  # noqa: E402

SCALED = ROOT / "docker/helm/meshgauge/templates/scaledobject.yaml"


def setUpModule():
    text = subprocess.run([BINARY, "--help"], env=ENVIRONMENT, capture_output=True, text=True, check=True).stdout
    if "  worker " not in text:
        raise unittest.SkipTest("this program has no workers")


class ManyMachines(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = cls.enterClassContext(Scratch())
        try:
            cls.database = cls.enterClassContext(Postgres(cls.scratch))
        except Missing as reason:
            raise unittest.SkipTest(str(reason)) from None
        migrate(cls.database.url())
        fleet = Fleet(cls.scratch, cls.database.url())
        cls.addClassCleanup(fleet.kill_all)
        cls.front_end, cls.worker = fleet.add_front_end(), fleet.add_worker()
        fleet.wait()
        assert cls.compare().status == 200
        cls.pages = {one.name: one.ask("GET", "/metrics").body.decode() for one in (cls.front_end, cls.worker)}
        cls.families = {family for page in cls.pages.values() for family in promql.families(page)}

    @classmethod
    def compare(cls, **headers):
        return cls.front_end.ask("POST", "/v1/comparisons", multipart([("a", SQUARE), ("b", RAISED)]),
                                 {"Content-Type": "multipart/form-data; boundary=XXboundaryXX", **headers})

    def test_the_manual_lists_what_they_show(self):
        self.assertLessEqual(SHARED, self.families)
        self.assertLessEqual(self.families, SHARED | listed("Metrics"))

    def test_the_dashboard_and_the_alerts_ask_for_what_is_there(self):
        exposed = {name for page in self.pages.values() for name in promql.exposed(page)}
        (path,) = (path for path in DASHBOARDS if path.name == "cluster.json")
        asked = [*dashboard_queries(path), *alert_queries()]
        names = {name for _, query in asked for name, _ in promql.selectors(query)}
        self.assertLessEqual(names & SHARED, exposed)
        # A metric that workers show, and front ends do not.
        self.assertIn("meshgauge_worker_claimed_total", promql.exposed(self.pages[self.worker.name]))

    def test_keda_asks_for_what_waits_and_runs(self):
        template = SCALED.read_text()
        query = next(line.split(": ", 1)[1] for line in template.splitlines() if line.strip().startswith("query: "))
        self.assertEqual(self.database.query(query), "0")
        self.worker.pause()
        try:
            self.assertEqual(self.compare(Prefer="respond-async").status, 202)
            self.assertEqual(self.database.query(query), "1")
        finally:
            self.worker.go_on()
        until(lambda: self.database.query(query) == "0")


if __name__ == "__main__":
    unittest.main()
