"""The dashboard, the alerts and docs/operations.md name metrics that the running service shows."""

import json
import re
import unittest

import yaml
from harness import ROOT, Server

import promql

DOCKER = ROOT / "docker"
DASHBOARDS = sorted((DOCKER / "grafana/dashboards").glob("*.json"))
ALERTS = DOCKER / "prometheus/alerts.yml"
MANUAL = (ROOT / "docs/operations.md").read_text()
OF_PROMETHEUS = {"instance", "job"}  # labels that it adds itself


def listed(section):
    """The metrics that a section of the manual lists."""
    text = re.search(rf"^#+ {section}\n(.*?)(?=^#|\Z)", MANUAL, re.M | re.S)[1]
    return set(re.findall(r"^\| `((?:meshgauge|process)_\w+)", text, re.M))


SHARED = listed("Of front ends and workers")  # test_many_machines.py holds them against those


def dashboard_queries(path):
    dashboard = json.loads(path.read_text())
    for panel in dashboard["panels"]:
        for target in panel.get("targets", []):
            yield panel["title"], target["expr"]
    for annotation in dashboard["annotations"]["list"]:
        yield annotation["name"], annotation["expr"]
    for variable in dashboard["templating"]["list"]:
        yield variable["name"], re.fullmatch(r"label_values\((\w+), \w+\)", variable["definition"])[1]


def alert_queries():
    for group in yaml.safe_load(ALERTS.read_text())["groups"]:
        for rule in group["rules"]:
            yield rule["alert"], rule["expr"]


class Queries(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        server = Server()
        cls.addClassCleanup(server.stop)
        server.compare()
        server.get("/healthz")
        server.get("/v1/batches/0123456789abcdef0123456789abcdef")
        server.raw(b"BREW / HTTP/1.1\r\nHost: localhost\r\n\r\n")  # 501: there is a 5xx
        cls.text = server.get("/metrics").body.decode()
        cls.exposed = promql.exposed(cls.text)

    def check(self, where, query):
        self.assertEqual(promql.functions(query), set(), where)
        selectors = promql.selectors(query)
        self.assertTrue(selectors, f"{where}: asks for nothing: {query}")
        labels = set(OF_PROMETHEUS)
        for name, matchers in selectors:
            if name == "up" or name in SHARED:
                continue
            self.assertIn(name, self.exposed, f"{where}: nothing is called so")
            labels |= set(self.exposed[name])
            for label, operator, value in matchers:
                if label not in OF_PROMETHEUS:
                    self.check_matcher(f"{where}: {name}", self.exposed[name], label, operator, value)
        self.assertLessEqual(promql.groupings(query), labels, where)

    def check_matcher(self, where, labels, label, operator, value):
        self.assertIn(label, labels, where)
        if operator.startswith("!"):
            return
        for choice in value.split("|") if "~" in operator else [re.escape(value)]:
            self.assertTrue(any(re.fullmatch(choice, known) for known in labels[label]),
                            f"{where}: no {label} is {choice!r} among {sorted(labels[label])}")

    def test_the_dashboard_asks_for_what_is_there(self):
        for path, least in zip(DASHBOARDS, (20, 30), strict=True):
            queries = list(dashboard_queries(path))
            self.assertGreater(len(queries), least, path)
            for where, query in queries:
                self.check(where, query)

    def test_the_alerts_ask_for_what_is_there(self):
        for where, query in alert_queries():
            self.check(where, query)

    def test_the_manual_lists_what_is_shown(self):
        shown = set(promql.families(self.text))
        self.assertLessEqual(listed("Metrics"), shown)
        self.assertLessEqual(shown, listed("Metrics") | SHARED)

    def test_all_that_is_listed_for_many_machines_is_watched(self):
        asked = {name for path in DASHBOARDS for _, query in dashboard_queries(path) for name, _ in promql.selectors(query)}
        self.assertGreater(len(SHARED), 3)
        self.assertLessEqual(SHARED, asked)

    def test_the_manual_has_every_alert(self):
        for alert, _ in alert_queries():
            self.assertIn(f"| `{alert}` |", MANUAL)

    def test_the_dashboards_are_whole(self):
        self.assertEqual(len({json.loads(path.read_text())["uid"] for path in DASHBOARDS}), len(DASHBOARDS))
        for path in DASHBOARDS:
            with self.subTest(path.name):
                self.check_whole(json.loads(path.read_text()))

    def check_whole(self, dashboard):
        ids = [panel["id"] for panel in dashboard["panels"]]
        self.assertEqual(len(ids), len(set(ids)))
        places = set()
        for panel in dashboard["panels"]:
            at = panel["gridPos"]
            self.assertLessEqual(at["x"] + at["w"], 24)
            cells = {(x, y) for x in range(at["x"], at["x"] + at["w"]) for y in range(at["y"], at["y"] + at["h"])}
            self.assertFalse(places & cells, panel["title"])
            places |= cells
        source = yaml.safe_load((DOCKER / "grafana/provisioning/datasources/prometheus.yaml").read_text())
        uids = {source["uid"] for source in source["datasources"]}
        for panel in dashboard["panels"]:
            for item in [panel, *panel.get("targets", [])]:
                if "datasource" in item:
                    self.assertIn(item["datasource"]["uid"], uids)


class Reading(unittest.TestCase):
    """What this test relies on: a name that a query asks for is found."""

    def names(self, query):
        return [name for name, _ in promql.selectors(query)]

    def test_names_are_found(self):
        self.assertEqual(self.names("a_total"), ["a_total"])
        self.assertEqual(self.names('sum by (x, le) (rate(a{b="c}d",e=~"f|g"}[5m])) / b > 5e9'), ["a", "b"])
        self.assertEqual(self.names("histogram_quantile(0.99, sum(rate(a_bucket[$__rate_interval])))"), ["a_bucket"])
        self.assertEqual(promql.selectors('a{b="c",d!~"e{1}"}'), [("a", [("b", "=", "c"), ("d", "!~", "e{1}")])])
        self.assertEqual(promql.groupings('sum by (a, b) (c) / on(d) e{f="by (g)"}'), {"a", "b", "d"})
        self.assertEqual(promql.functions("ratee(a[5m])"), {"ratee"})

    def test_a_page_is_read(self):
        page = '# TYPE a counter\na{b="c",d="e"} 1\na{b="f",d="e"} 2\ng 3\n'
        self.assertEqual(promql.exposed(page), {"a": {"b": {"c", "f"}, "d": {"e"}}, "g": {}})
        self.assertEqual(promql.families(page), {"a": "counter"})


if __name__ == "__main__":
    unittest.main()
