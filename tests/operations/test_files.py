"""What is in docker/: files that name each other, settings that exist, and what the programs that read them say.

promtool, docker-compose and caddy are taken from the PATH or from build/tools, where `./dev test` puts them.
"""

import contextlib
import http.client
import json
import os
import re
import shlex
import shutil
import ssl
import subprocess
import tempfile
import unittest
from pathlib import Path

import yaml
from harness import BINARY, ENVIRONMENT, RAISED, ROOT, SQUARE, Server, free_port, multipart, until, validate

DOCKER = ROOT / "docker"
MANUAL = (ROOT / "docs/operations.md").read_text()
COMPOSE = {name: yaml.safe_load((DOCKER / name).read_text())
           for name in ("compose.yaml", "compose.production.yaml", "compose.cluster.yaml")}  # fmt: skip
ALONE = ("compose.yaml", "compose.production.yaml")
WATCHED = {"compose.production.yaml": "prometheus.yml", "compose.cluster.yaml": "cluster.yml"}
TOOLS = Path(os.environ.get("MESHGAUGE_TOOLS", ROOT / "build/tools"))
TRACE = "00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01"


def tool(name):
    found = shutil.which(name, path=os.pathsep.join([os.environ.get("PATH", ""), str(TOOLS / "usr/bin")]))
    return found or unittest.SkipTest(f"no {name} (./dev setup test)")


def bearer(token):
    return f"Authorization: Bearer {token}\r\n"


def run(name, *arguments, **options):
    program = tool(name)
    if isinstance(program, unittest.SkipTest):
        raise program
    done = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True, check=False, **options)
    assert done.returncode == 0, f"{name} {arguments}:\n{done.stdout}{done.stderr}"
    return done.stdout


def services(name):
    """{name: service} of a file of compose, with what it extends."""
    return {service: of if "extends" not in of else services(of["extends"]["file"])[of["extends"]["service"]] | of
            for service, of in COMPOSE[name]["services"].items()}


class Secrets:
    """The files that the manual's first lines make, by the built program in place of the image's."""

    def __init__(self, test):
        folder = Path(test.enterContext(tempfile.TemporaryDirectory()))
        docker = folder / "docker-for-tests"
        docker.write_text(f'#!/bin/sh\n[ "$1" = build ] || {{ shift 3; exec {shlex.quote(BINARY)} "$@"; }}\n')
        docker.chmod(0o755)
        lines = next(block for block in re.findall(r"^```sh\n(.*?)^```$", MANUAL, re.M | re.S) if "keys new" in block)
        subprocess.run(["sh", "-euc", f'docker() {{ {shlex.quote(str(docker))} "$@"; }}\n{lines}'], cwd=folder, check=True)
        self.folder = folder / "docker/secrets"

    def path(self, mounted):
        """The file that a container finds as /run/secrets/..."""
        return self.folder / Path(COMPOSE["compose.production.yaml"]["secrets"][Path(mounted).name]["file"]).name

    def first_line(self, name):
        return (self.folder / name).read_text().splitlines()[0]


class Compose(unittest.TestCase):
    def test_the_settings_exist(self):
        """A variable that names no setting would be ignored silently."""
        text = subprocess.run([BINARY, "serve", "--help"], env=ENVIRONMENT, capture_output=True, text=True, check=True).stdout
        known = set(re.findall(r"\(Env:(\w+)\)", text))
        self.assertGreater(len(known), 20)
        for name in ALONE:
            self.assertLessEqual(set(COMPOSE[name]["services"]["meshgauge"]["environment"]), known, name)

    def test_the_settings_are_accepted_together(self):
        both = {}
        for document in map(COMPOSE.get, ALONE):
            both |= {name: str(value) for name, value in document["services"]["meshgauge"]["environment"].items()}
        secrets = Secrets(self)
        both["MESHGAUGE_KEYS_FILE"] = str(secrets.path(both["MESHGAUGE_KEYS_FILE"]))
        server = Server(environment=both)
        self.addCleanup(server.stop)
        self.assertEqual(server.compare().status, 401)
        self.assertEqual(server.compare(extra=bearer(secrets.first_line("ci"))).status, 200)
        # The key of Prometheus is for metrics alone.
        config = yaml.safe_load((DOCKER / "prometheus/prometheus.yml").read_text())
        file = next(job for job in config["scrape_configs"] if job["job_name"] == "meshgauge")["authorization"]["credentials_file"]
        token = secrets.path(file).read_text().strip()
        self.assertEqual(server.get("/metrics", extra=bearer(token)).status, 200)
        self.assertEqual(server.compare(extra=bearer(token)).status, 403)

    def test_a_proxy_is_not_taken_for_one_client(self):
        for name, service in (("compose.production.yaml", "meshgauge"), ("compose.cluster.yaml", "frontend")):
            of = COMPOSE[name]["services"][service]["environment"]
            self.assertGreaterEqual(of["MESHGAUGE_MAX_ARRIVING_PER_PEER"], 1024)

    def test_secrets_are_given_to_the_services_that_read_them(self):
        for name, config in WATCHED.items():
            given = {secret for of in services(name).values() for secret in of.get("secrets", [])}
            self.assertEqual(given, set(COMPOSE[name]["secrets"]), name)
            read = set(re.findall(r"/run/secrets/(\w+)", (DOCKER / "prometheus" / config).read_text() + json.dumps(services(name))))
            self.assertEqual(read, given, name)

    def test_what_is_mounted_is_there(self):
        for name, document in COMPOSE.items():
            volumes = set(document.get("volumes", {}))
            for service in document["services"].values():
                for mount in service.get("volumes", []):
                    if ":" not in mount:  # of the container's own, without a name
                        continue
                    source = mount.split(":")[0]
                    there = (DOCKER / source).exists() if source.startswith(".") else source in volumes
                    self.assertTrue(there, f"{name}: {mount}")

    def test_everything_is_confined(self):
        for name in COMPOSE:
            for service, of in services(name).items():
                service = f"{name}: {service}"
                self.assertTrue(of["read_only"], service)
                self.assertEqual(of["cap_drop"], ["ALL"], service)
                self.assertIn("no-new-privileges:true", of["security_opt"], service)
                self.assertIn("mem_limit", of, service)
                self.assertIn("pids_limit", of, service)
                if not service.endswith("proxy"):  # the only one that others may reach
                    for port in of.get("ports", []):
                        self.assertTrue(port.startswith("127.0.0.1:"), f"{service}: {port}")

    def test_images_are_of_one_version(self):
        for name in COMPOSE:
            for of in services(name).values():
                self.assertRegex("a:1" if "build" in of else of["image"], r":v?\d+(\.\d+)*$")

    def test_the_schema_of_compose(self):
        for name in COMPOSE:
            run("docker-compose", "-f", DOCKER / name, "config", "-q")

    def test_the_dashboards_are_where_grafana_looks(self):
        provider = yaml.safe_load((DOCKER / "grafana/provisioning/dashboards/meshgauge.yaml").read_text())["providers"][0]
        grafana = COMPOSE["compose.production.yaml"]["services"]["grafana"]
        mounted = {mount.split(":")[1]: mount.split(":")[0] for mount in grafana["volumes"]}
        self.assertEqual(mounted[provider["options"]["path"]], "./grafana/dashboards")
        home = grafana["environment"]["GF_DASHBOARDS_DEFAULT_HOME_DASHBOARD_PATH"]
        self.assertTrue((DOCKER / "grafana/dashboards" / Path(home).name).exists())
        self.assertEqual(str(Path(home).parent), provider["options"]["path"])


class Cluster(unittest.TestCase):
    """docker/compose.cluster.yaml: the same limits as the service alone, and settings that its programs take."""

    parts = COMPOSE["compose.cluster.yaml"]["services"]

    def test_the_limits_are_those_of_the_service_alone(self):
        alone = COMPOSE["compose.yaml"]["services"]["meshgauge"]["environment"]
        for part in ("frontend", "worker"):
            of = self.parts[part]["environment"]
            common = {name for name in alone if re.search("_MAX_|PARSER", name) and "PER_PEER" not in name}
            self.assertGreater(len(common), 7)
            self.assertEqual({name: of[name] for name in common}, {name: alone[name] for name in common}, part)

    def test_no_service_starts_before_the_schema_is_there(self):
        for part in ("frontend", "worker"):
            self.assertEqual(self.parts[part]["depends_on"], {"migrate": {"condition": "service_completed_successfully"}})
        self.assertEqual(self.parts["migrate"]["depends_on"], {"postgres": {"condition": "service_healthy"}})

    def test_only_services_that_need_the_database_reach_it(self):
        self.assertTrue(COMPOSE["compose.cluster.yaml"]["networks"]["back"]["internal"])
        inside = {name for name, of in self.parts.items() if "back" in of["networks"]}
        self.assertEqual(inside, {"postgres", "migrate", "frontend", "worker"})
        self.assertEqual(self.parts["postgres"]["networks"], ["back"])

    def test_there_is_time_to_drain(self):
        for part in ("frontend", "worker"):
            of = self.parts[part]
            self.assertGreaterEqual(int(of["stop_grace_period"].rstrip("s")), of["environment"]["MESHGAUGE_GRACE_MS"] / 1000 + 10)

    def test_the_settings_are_accepted(self):
        """The settings, with the file of the connection string as docs/operations.md makes it."""
        text = subprocess.run([BINARY, "serve", "--help"], env=ENVIRONMENT, capture_output=True, text=True, check=True).stdout
        if "MESHGAUGE_DATABASE" not in text:
            self.skipTest("this program has no distributed form")
        secrets = Secrets(self)
        for part in ("frontend", "worker", "migrate"):
            of = {name: re.sub(r"^\$\{\w+:-(.*)\}$", r"\1", str(value)) for name, value in self.parts[part]["environment"].items()}
            of["MESHGAUGE_CONFIG"] = str(secrets.folder / "database.conf")
            done = subprocess.run([BINARY, "serve", "--print-config"], env=ENVIRONMENT | of, capture_output=True, text=True, check=False)
            self.assertEqual(done.returncode, 0, f"{part}: {done.stderr}")
            self.assertRegex(done.stdout, r"(?m)^database = .*host='?postgres", part)
            self.assertNotIn(secrets.first_line("postgres_password"), done.stdout, part)
            shown = dict(re.findall(r'^(\w+) = "?([^"\n]*)"?$', done.stdout, re.M))
            for name in set(of) - {"MESHGAUGE_CONFIG"}:
                if name.startswith("MESHGAUGE_"):
                    self.assertEqual(shown[name.removeprefix("MESHGAUGE_").lower()], of[name], f"{part}: {name}")


class Prometheus(unittest.TestCase):
    def test_the_configuration_and_the_rules(self):
        # The file of the token is missing; --syntax-only overlooks that alone.
        for config in WATCHED.values():
            run("promtool", "check", "config", "--syntax-only", DOCKER / "prometheus" / config)
        run("promtool", "check", "rules", DOCKER / "prometheus/alerts.yml")

    def test_the_alerts_fire_when_they_should(self):
        run("promtool", "test", "rules", Path(__file__).parent / "alerts_test.yml")

    def test_what_the_service_shows(self):
        server = Server()
        self.addCleanup(server.stop)
        server.compare()
        page = server.get("/metrics")
        self.assertEqual(page.headers["content-type"], "text/plain; version=0.0.4; charset=utf-8")
        # promtool also reports names against the conventions; no output means no complaint.
        self.assertEqual(run("promtool", "check", "metrics", input=page.body.decode()), "")

    def test_it_scrapes_what_compose_starts(self):
        jobs = {config: {job["job_name"]: job for job in yaml.safe_load((DOCKER / "prometheus" / config).read_text())["scrape_configs"]}
                for config in WATCHED.values()}  # fmt: skip
        self.assertEqual(jobs["prometheus.yml"]["meshgauge"]["static_configs"][0]["targets"], ["meshgauge:8080"])
        (found,) = jobs["cluster.yml"]["meshgauge"]["dns_sd_configs"]
        self.assertEqual((found["names"], found["port"]), (["frontend", "worker"], 8080))
        for name in found["names"]:
            self.assertIn("watch", services("compose.cluster.yaml")[name]["networks"])


class Proxy(unittest.TestCase):
    """Caddy, with docker/Caddyfile, in front of the service."""

    @classmethod
    def setUpClass(cls):
        program = tool("caddy")
        if isinstance(program, unittest.SkipTest):
            raise program
        server = Server("--max-request-bytes", "100000", "--max-part-bytes", "100000")
        cls.addClassCleanup(server.stop)
        folder = Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
        config = folder / "Caddyfile"
        # Ports that need no root, and no certificate in the machine's store.
        config.write_text((DOCKER / "Caddyfile").read_text().replace(
            "admin off", f"admin off\n\tskip_install_trust\n\thttp_port {free_port()}"))
        cls.address = f"https://localhost:{free_port()}"
        environment = {"PATH": os.environ["PATH"], "HOME": str(folder), "XDG_DATA_HOME": str(folder),
                       "MESHGAUGE_DOMAIN": cls.address, "MESHGAUGE_UPSTREAM": f"127.0.0.1:{server.port}"}  # fmt: skip
        caddy = subprocess.Popen([program, "run", "--adapter", "caddyfile", "--config", config],
                                 env=environment, stderr=subprocess.DEVNULL)
        cls.addClassCleanup(caddy.wait)
        cls.addClassCleanup(caddy.terminate)
        authority = folder / "caddy/pki/authorities/local/root.crt"
        until(lambda: authority.exists() and "END CERTIFICATE" in authority.read_text())  # it is written in place
        cls.tls = ssl.create_default_context(cafile=str(authority))
        until(lambda: cls.answers("/healthz"))

    @classmethod
    def answers(cls, path):
        with contextlib.suppress(OSError):
            return cls.ask(path)[0] == 200
        return False

    @classmethod
    def ask(cls, path, body=None, headers=()):
        connection = http.client.HTTPSConnection(cls.address.removeprefix("https://"), context=cls.tls, timeout=30)
        with contextlib.closing(connection):
            connection.connect()
            # A client that is answered before all is sent may find the connection closed, with the answer in it.
            with contextlib.suppress(OSError):
                connection.request("POST" if body else "GET", path, body, dict(headers))
            answer = connection.getresponse()
            return answer.status, answer.headers, answer.read()

    def post(self, mesh):
        body = multipart([("a", mesh), ("b", RAISED)])
        return self.ask("/v1/comparisons", body, {"Content-Type": "multipart/form-data; boundary=XXboundaryXX",
                                                  "traceparent": TRACE})

    def test_a_comparison_by_tls(self):
        status, headers, body = self.post(SQUARE)
        self.assertEqual(status, 200)
        validate(json.loads(body), "Comparison")
        self.assertTrue(headers["Strict-Transport-Security"].startswith("max-age="))
        self.assertEqual(headers["traceparent"].split("-")[1], TRACE.split("-")[1])
        self.assertNotEqual(headers["traceparent"].split("-")[2], TRACE.split("-")[2])

    def test_metrics_are_not_forwarded(self):
        self.assertEqual(self.ask("/metrics")[0], 404)

    def test_a_body_beyond_the_limit_is_refused(self):
        # Slightly above the limit: a socket takes it in one piece.
        status, headers, body = self.post(SQUARE + b"#" * 100000)
        self.assertEqual((status, headers["Content-Type"]), (413, "application/problem+json"))
        self.assertEqual(json.loads(body)["type"], "/problems/too-large")

    def test_a_refusal_of_the_service_comes_through(self):
        status, headers, _ = self.post(b"v 0 0 nan\n")
        self.assertEqual((status, headers["Content-Type"]), (422, "application/problem+json"))


if __name__ == "__main__":
    unittest.main()
