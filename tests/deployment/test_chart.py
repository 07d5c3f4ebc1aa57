"""The chart of docker/helm makes objects that a Kubernetes API server takes, confined as the container is elsewhere."""

import copy
import json
import os
import re
import subprocess
import unittest

import yaml
from chart import ALL, CHART, HERE, LEAST, ROOT, VARIANTS, complaints, complaints_of_each, container, environment, helm, objects, quantity, rendered, run_helm

BINARY = os.environ.get("MESHGAUGE_BINARY", str(ROOT / "build/meshgauge"))
LABEL_VALUE = re.compile(r"([A-Za-z0-9]([-A-Za-z0-9_.]{0,61}[A-Za-z0-9])?)?")
LABEL_NAME = re.compile(r"([a-z0-9]([-a-z0-9.]*[a-z0-9])?/)?[A-Za-z0-9]([-A-Za-z0-9_.]{0,61}[A-Za-z0-9])?")
NAME = re.compile(r"[a-z]([-a-z0-9]{0,61}[a-z0-9])?")


def setUpModule():
    helm()


def changed(made, path, value):
    """A copy with another value at the path."""
    made = at = copy.deepcopy(made)
    *folders, last = path.split("/")
    for step in folders:
        at = at[int(step) if isinstance(at, list) else step]
    at[last] = value
    return made


def every(test):
    """Runs it on all variants."""

    def over_variants(self):
        for variant in VARIANTS:
            with self.subTest(variant):
                test(self, objects(variant))

    return over_variants


class Chart(unittest.TestCase):
    def test_helm_has_nothing_to_say(self):
        for variant, values in VARIANTS.items():
            done = run_helm("lint", "--strict", values=values)
            self.assertEqual(done.returncode, 0, f"{variant}: {done.stdout}{done.stderr}")

    def test_the_notes_are_written(self):
        for variant, values in VARIANTS.items():
            done = run_helm("install", "--dry-run=client", "--generate-name", values=values)
            self.assertEqual(done.returncode, 0, f"{variant}: {done.stderr}")
            self.assertIn("front ends and", done.stdout.split("NOTES:")[1])

    def test_what_is_wrong_is_refused_by_name(self):
        for change, said in [
            ({"settings": {"max_trianglse": 3}}, "max_trianglse"),
            ({"settings": {"database": "host=db"}}, "database"),  # a secret has no place there
            ({"worker": {"replica": 3}}, "replica"),
            ({"worker": {"replicas": "three"}}, "replicas"),
            ({"frontend": {"replicas": 0}}, "replicas"),
            ({"blobs": {"url": "http://meshes"}}, "url"),
            ({"frontend": {"tmp": {"medium": "Disk"}}}, "medium"),
            ({"image": {"digest": "latest"}}, "digest"),
            ({"unknown": 1}, "unknown"),
            ({"podSecurityContext": {"runAsNonRoot": False}}, "runAsNonRoot"),
            ({"database": {"existingSecret": ""}}, "database.existingSecret"),
            ({"keys": {"existingSecret": ""}}, "keys.publicWithoutKeys"),
            ({"blobs": {"url": "s3://meshes"}}, "blobs.s3.existingSecret"),
            ({"ingress": {"enabled": True}}, "ingress.hosts"),
            ({"keda": {"enabled": True, "minReplicas": 3, "maxReplicas": 2}}, "keda.maxReplicas"),
        ]:
            done = run_helm("template", values={**LEAST, **change})
            self.assertNotEqual(done.returncode, 0, f"{change} is accepted")
            self.assertIn(said, done.stderr)

    def test_every_value_has_a_schema(self):
        """A default that is added must be one that may be set."""

        def walk(values, schema, path):
            schema = definitions[schema["$ref"].split("/")[-1]] if "$ref" in schema else schema
            self.assertTrue(schema.get("type") or schema.get("enum") or schema.get("oneOf"), path)
            if isinstance(values, dict) and "properties" in schema:
                self.assertIs(schema["additionalProperties"], False, path)
                self.assertLessEqual(set(values), set(schema["properties"]), path)
                self.assertLessEqual(set(schema["properties"]) - {"global"}, set(values), f"{path}: no default")
                for name, value in values.items():
                    walk(value, schema["properties"][name], f"{path}.{name}")

        schema = json.loads((CHART / "values.schema.json").read_text())
        definitions = schema["definitions"]
        walk(yaml.safe_load((CHART / "values.yaml").read_text()), schema, "")

    def test_it_is_of_this_version(self):
        chart = yaml.safe_load((CHART / "Chart.yaml").read_text())
        version = re.search(r"project\(meshgauge VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text())[1]
        self.assertEqual(chart["appVersion"], version)


class Schemas(unittest.TestCase):
    @every
    def test_the_objects_are_valid(self, made):
        self.assertGreaterEqual(len(made), 3)
        self.assertEqual(complaints(made), [])

    def test_everything_that_can_be_made_is_made(self):
        kinds = {o["kind"] for o in objects("all")}
        written = {kind for file in (CHART / "templates").glob("*.yaml") for kind in re.findall(r"^kind: (\w+)$", file.read_text(), re.M)}
        self.assertEqual(kinds, written)
        self.assertGreater(len(kinds), 10)

    def test_what_is_invalid_is_seen(self):
        """The schemas' functions pass over unknown fields; our code finds them."""
        front = "Deployment/meshgauge-frontend"
        container = "spec/template/spec/containers/0"
        changes = [(objects("all").deployment("frontend"), path, value, seen) for path, value, seen in [
            ("spec/replicas", "two", f"{front}/spec/replicas: type"),
            ("spec/selectors", {}, f"{front}/spec/selectors: unknown field"),
            (f"{container}/livenessProbe/httpGet/prt", 1, "/httpGet/prt: unknown field"),
            (f"{container}/env/0/valueFrom/secretKeyRef/namespace", "x", "/secretKeyRef/namespace: unknown field"),
            (f"{container}/securityContext/readonlyRootFilesystem", True, "/readonlyRootFilesystem: unknown field"),
            ("spec/template/spec/volumes/0/emptyDir/sizeLimits", "1Gi", "/sizeLimits: unknown field"),
            ("spec/template/spec/securityContext/seccompProfile/type", "Default", "/seccompProfile/type: enum"),
            ("metadata/labels/number", 1, "/metadata/labels/number: type"),
            ("kind", "Deploiment", "no Deploiment in apps/v1"),
        ]]
        changes += [(objects("all").one(kind, name), path, value, seen) for kind, name, path, value, seen in [
            ("ScaledObject", None, "spec/triggers/0/metdata", {}, "/metdata: unknown field"),
            ("ServiceMonitor", "meshgauge-worker", "spec/endpoints/0/authorisation", {}, "/authorisation: unknown field"),
            ("NetworkPolicy", "meshgauge-worker", "spec/egress/0/ports/0/port", [53], "/ports/0/port: "),
            ("PodDisruptionBudget", "meshgauge-worker", "spec/maxUnavailable", [], "/maxUnavailable: "),
        ]]
        for (_, path, value, seen), lines in zip(changes, complaints_of_each([changed(*change[:3]) for change in changes])):
            self.assertTrue(any(seen in line for line in lines), f"{path} = {value!r} gives {lines}, not {seen!r}")

    def test_what_is_missing_is_seen(self):
        made = copy.deepcopy(objects("all").deployment("worker"))
        del made["spec"]["selector"]
        self.assertIn('Deployment/meshgauge-worker/spec: required {"missingProperty":"selector"}', complaints([made]))


class Rules(unittest.TestCase):
    """What an API server, or a pod that starts, holds against objects beyond their schemas."""

    @every
    def test_names(self, made):
        self.assertEqual(len({(o["kind"], o["metadata"]["name"]) for o in made}), len(made))
        for o in made:
            self.assertRegex(o["metadata"]["name"], NAME)
            labels = [o["metadata"]["labels"]] + [t["metadata"]["labels"] for t in [o.get("spec", {}).get("template")] if t]
            for name, value in [pair for of in labels for pair in of.items()]:
                self.assertRegex(name, f"^{LABEL_NAME.pattern}$")
                self.assertRegex(value, f"^{LABEL_VALUE.pattern}$")

    def test_long_names_are_cut(self):
        name = "a-release-with-a-name-that-is-as-long-as-one-can-ever"
        done = run_helm("template", values=ALL, release=name)
        self.assertEqual(done.returncode, 0, done.stderr)
        for o in yaml.safe_load_all(done.stdout):
            self.assertLessEqual(len(o["metadata"]["name"]), 63)
            self.assertFalse(o["metadata"]["name"].endswith("-"))

    @every
    def test_everything_that_selects_finds_pods(self, made):
        for deployment in made.of("Deployment"):
            self.assertEqual(made.selected(deployment["spec"]["selector"]["matchLabels"]), [deployment["spec"]["template"]])
        for service in made.of("Service"):
            (template,) = made.selected(service["spec"]["selector"])
            for port in service["spec"]["ports"]:
                self.assertIn(port["targetPort"], [p["name"] for p in container(template)["ports"]])
        for budget in made.of("PodDisruptionBudget"):
            self.assertEqual(len(made.selected(budget["spec"]["selector"]["matchLabels"])), 1)
        for monitor in made.of("ServiceMonitor"):
            labels = monitor["spec"]["selector"]["matchLabels"].items()
            (service,) = [s for s in made.of("Service") if labels <= s["metadata"]["labels"].items()]
            self.assertIn(monitor["spec"]["endpoints"][0]["port"], [p["name"] for p in service["spec"]["ports"]])
        for scaled in made.of("ScaledObject"):
            made.one("Deployment", scaled["spec"]["scaleTargetRef"]["name"])
            made.one("TriggerAuthentication", scaled["spec"]["triggers"][0]["authenticationRef"]["name"])
        for ingress in made.of("Ingress"):
            backend = ingress["spec"]["rules"][0]["http"]["paths"][0]["backend"]["service"]
            ports = made.one("Service", backend["name"])["spec"]["ports"]
            self.assertIn(backend["port"]["number"], [p["port"] for p in ports])

    @every
    def test_pods_are_whole(self, made):
        for o, template in made.pods():
            of, name = container(template), o["metadata"]["name"]
            mounts = [m["name"] for m in of["volumeMounts"]]
            self.assertEqual(sorted(mounts), sorted(v["name"] for v in template["spec"]["volumes"]), name)
            self.assertEqual(len({m["mountPath"] for m in of["volumeMounts"]}), len(mounts), name)
            variables = [e["name"] for e in of["env"]]
            self.assertEqual(len(set(variables)), len(variables), name)
            ports = {p["name"] for p in of.get("ports", [])}
            for probe in ("startupProbe", "livenessProbe", "readinessProbe"):
                if o["kind"] == "Deployment":
                    self.assertIn(of[probe]["httpGet"]["port"], ports, name)
            for resource, most in of["resources"]["limits"].items():
                self.assertLessEqual(quantity(of["resources"]["requests"].get(resource, 0)), quantity(most), name)

    @every
    def test_secrets_are_referred_to_and_never_made(self, made):
        self.assertEqual(made.of("Secret") + made.of("ConfigMap"), [])
        for _, template in made.pods():
            (of,) = [e for e in container(template)["env"] if e["name"] == "MESHGAUGE_DATABASE"]
            self.assertEqual(set(of), {"name", "valueFrom"})
            for variable, value in environment(template).items():
                self.assertNotRegex(variable, "SECRET|PASSWORD|TOKEN")
                self.assertNotRegex(value, "password|postgres(ql)?://")

    def test_each_secret_is_the_one_that_was_named(self):
        made = objects("all")
        text = json.dumps(made)
        named = set(re.findall(r'"secretKeyRef": {"name": "([^"]+)"|"secretName": "([^"]+)"', text))
        self.assertEqual({a or b for a, b in named}, {"db", "db-ca", "db-of-owner", "s3", "keys", "tls", "a-tls"})
        job = container(made.one("Job")["spec"]["template"])
        self.assertEqual(job["env"][0]["valueFrom"]["secretKeyRef"]["name"], "db-of-owner")
        self.assertEqual(made.one("TriggerAuthentication")["spec"]["secretTargetRef"][0]["name"], "db-of-keda")
        self.assertEqual(objects("least").one("Job")["spec"]["template"]["spec"]["containers"][0]["env"][0]["valueFrom"]["secretKeyRef"]["name"], "db")

    def test_the_migration_comes_first_and_needs_nothing_of_the_release(self):
        made = objects("all")
        hooks = {o["kind"]: o["metadata"]["annotations"] for o in made if "helm.sh/hook" in o["metadata"].get("annotations", {})}
        self.assertEqual(set(hooks), {"Job", "NetworkPolicy"})
        for annotations in hooks.values():
            self.assertEqual(annotations["helm.sh/hook"], "pre-install,pre-upgrade")
        self.assertLess(int(hooks["NetworkPolicy"]["helm.sh/hook-weight"]), int(hooks["Job"]["helm.sh/hook-weight"]))
        job = made.one("Job")["spec"]["template"]["spec"]
        self.assertNotIn("serviceAccountName", job)
        self.assertEqual(job["containers"][0]["command"], ["meshgauge", "migrate"])

    def test_keda_and_a_fixed_number_exclude_each_other(self):
        self.assertNotIn("replicas", objects("all").deployment("worker")["spec"])
        self.assertNotIn("replicas", objects("none").deployment("worker")["spec"])
        self.assertEqual(objects("least").deployment("worker")["spec"]["replicas"], 2)
        self.assertEqual(objects("least").of("ScaledObject"), [])


class Confinement(unittest.TestCase):
    """Pod Security Standards, level restricted, and what is asked of the container elsewhere."""

    @every
    def test_pods(self, made):
        for o, template in made.pods():
            pod, name = template["spec"], o["metadata"]["name"]
            self.assertFalse(set(pod) & {"hostNetwork", "hostPID", "hostIPC", "initContainers"}, name)
            self.assertEqual(
                pod["securityContext"],
                {"runAsNonRoot": True, "runAsUser": 10001, "runAsGroup": 10001, "fsGroup": 10001, "seccompProfile": {"type": "RuntimeDefault"}},
                name)  # fmt: skip
            self.assertEqual(
                container(template)["securityContext"],
                {"allowPrivilegeEscalation": False, "readOnlyRootFilesystem": True, "capabilities": {"drop": ["ALL"]}},
                name)  # fmt: skip
            self.assertIs(pod["automountServiceAccountToken"], False, name)
            # A Service named meshgauge would set MESHGAUGE_PORT.
            self.assertIs(pod["enableServiceLinks"], False, name)
            self.assertIn("memory", container(template)["resources"]["limits"], name)

    @every
    def test_what_can_be_written_is_bounded(self, made):
        for o, template in made.pods():
            mounts = {m["name"]: m for m in container(template)["volumeMounts"]}
            for volume in template["spec"]["volumes"]:
                kind = next(iter(set(volume) - {"name"}))
                self.assertIn(kind, ("emptyDir", "secret"), o["metadata"]["name"])
                if kind == "emptyDir":
                    self.assertIn("sizeLimit", volume[kind])
                else:
                    self.assertTrue(mounts[volume["name"]]["readOnly"])
            # The image declares its volume there: without a mount the runtime makes one without a limit.
            self.assertIn("/var/lib/meshgauge", [m["mountPath"] for m in mounts.values()])

    @every
    def test_the_service_account_has_no_token(self, made):
        for account in made.of("ServiceAccount"):
            self.assertIs(account["automountServiceAccountToken"], False)

    def test_which_pods_may_connect_to_which(self):
        made = objects("all")
        policies = {p["metadata"]["name"].removeprefix("meshgauge-"): p["spec"] for p in made.of("NetworkPolicy")}
        self.assertEqual(set(policies), {"deny", "frontend", "worker", "migrate"})
        for policy in policies.values():
            self.assertEqual(policy["policyTypes"], ["Ingress", "Egress"])
        # Everything of the release is denied, and nothing by that policy allowed.
        self.assertEqual(made.selected(policies["deny"]["podSelector"]["matchLabels"]), [t for _, t in made.pods()])
        self.assertFalse(set(policies["deny"]) & {"ingress", "egress"})
        self.assertEqual([self.namespaces(p) for p in policies["frontend"]["ingress"]], [["ingress-nginx", "monitoring"]])
        self.assertEqual([self.namespaces(p) for p in policies["worker"]["ingress"]], [["monitoring"]])
        self.assertNotIn("ingress", policies["migrate"])
        database, s3 = {"10.1.2.0/24": [5432, 6432]}, {"10.1.3.0/24": [9000]}
        for name, allowed in [("frontend", database | s3), ("worker", database | s3), ("migrate", database)]:
            dns, *others = policies[name]["egress"]
            self.assertEqual([p["port"] for p in dns["ports"]], [53, 53])
            self.assertEqual(self.namespaces({"from": dns["to"]}), ["kube-system"])
            self.assertEqual({o["to"][0]["ipBlock"]["cidr"]: [p["port"] for p in o["ports"]] for o in others}, allowed)

    def test_workers_cannot_be_reached_by_default(self):
        self.assertNotIn("ingress", objects("least").one("NetworkPolicy", "meshgauge-worker")["spec"])
        ports = [p["port"] for rule in objects("least").one("NetworkPolicy", "meshgauge-worker")["spec"]["egress"] for p in rule["ports"]]
        self.assertEqual(ports, [53, 53, 5432])

    def namespaces(self, rule):
        return [peer["namespaceSelector"]["matchLabels"]["kubernetes.io/metadata.name"] for peer in rule["from"]]


class Sizes(unittest.TestCase):
    """The defaults fit each other: docs/operations.md, Sizing."""

    def each(self):
        for component in ("frontend", "worker"):
            template = objects("least").deployment(component)["spec"]["template"]
            volumes = {v["name"]: v["emptyDir"] for v in template["spec"]["volumes"] if "emptyDir" in v}
            settings = {k: int(v) for k, v in environment(template).items() if v.isdigit()}
            yield component, template, volumes, lambda name, of=settings: of[f"MESHGAUGE_{name.upper()}"]

    def test_memory(self):
        for component, template, volumes, of in self.each():
            worst = of("workers") * (2 * of("max_triangles") * 166 + of("max_heap_bytes") + of("parser_memory_bytes"))
            worst += of("max_cache_bytes") + 50e6
            if volumes["tmp"]["medium"] == "Memory":
                worst += quantity(volumes["tmp"]["sizeLimit"])
            self.assertLessEqual(worst, quantity(container(template)["resources"]["limits"]["memory"]), component)

    def test_disk(self):
        for component, template, volumes, of in self.each():
            kept = of("blob_cache_bytes") + (of("map_cache_bytes") if component == "frontend" else 0)
            self.assertLess(kept, quantity(volumes["data"]["sizeLimit"]), component)
            asked = quantity(container(template)["resources"]["requests"]["ephemeral-storage"])
            self.assertLessEqual(quantity(volumes["data"]["sizeLimit"]), asked, component)
            if component == "frontend":
                self.assertLessEqual(of("max_upload_bytes"), quantity(volumes["tmp"]["sizeLimit"]))

    def test_there_is_time_to_drain(self):
        for component, template, _, of in self.each():
            waits = container(template).get("lifecycle", {"preStop": {"sleep": {"seconds": 0}}})["preStop"]["sleep"]["seconds"]
            self.assertGreater(template["spec"]["terminationGracePeriodSeconds"], waits + of("grace_ms") / 1000 + 10, component)

    def test_both_take_the_same_meshes(self):
        limits = {component: {name: of(name) for name in ("max_triangles", "max_vertices", "max_part_bytes", "max_expanded_bytes")}
                  for component, _, _, of in self.each()}  # fmt: skip
        self.assertEqual(limits["frontend"], limits["worker"])


class Settings(unittest.TestCase):
    """The program knows what the chart sets."""

    @classmethod
    def setUpClass(cls):
        clean = {k: v for k, v in os.environ.items() if not k.startswith("MESHGAUGE_")}
        text = subprocess.run([BINARY, "serve", "--help"], env=clean, capture_output=True, text=True, check=True).stdout
        cls.known = set(re.findall(r"\(Env:(\w+)\)", text))
        cls.clean = clean
        if "MESHGAUGE_DATABASE" not in cls.known:
            raise unittest.SkipTest("this program has no distributed form")

    @every
    def test_every_variable_is_a_setting(self, made):
        for _, template in made.pods():
            variables = {e["name"] for e in container(template)["env"] if not e["name"].startswith(("AWS_", "PG"))}
            self.assertLessEqual(variables, self.known)

    def test_every_setting_has_a_place(self):
        schema = json.loads((CHART / "values.schema.json").read_text())
        free = {f"MESHGAUGE_{name.upper()}" for name in schema["definitions"]["settings"]["propertyNames"]["enum"]}
        made = {e["name"] for made in map(objects, VARIANTS) for _, t in made.pods() for e in container(t)["env"]}
        self.assertEqual(free | {name for name in made if name.startswith("MESHGAUGE_")}, self.known - {"MESHGAUGE_CONFIG"})

    def test_the_values_are_accepted(self):
        for component in ("frontend", "worker"):
            of = environment(objects("least").deployment(component)["spec"]["template"])
            of |= {"MESHGAUGE_DATABASE": "host=db user=meshgauge password=hidden"}
            done = subprocess.run([BINARY, "serve", "--print-config"], env=self.clean | of, capture_output=True, text=True, check=False)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertNotIn("hidden", done.stdout)
            shown = dict(re.findall(r'^(\w+) = "?([^"\n]*)"?$', done.stdout, re.M))
            for name, value in of.items():
                if name != "MESHGAUGE_DATABASE":
                    self.assertEqual(shown[name.removeprefix("MESHGAUGE_").lower()], value, name)


class Alerts(unittest.TestCase):
    def test_the_rules_are_those_of_docker_prometheus(self):
        rules = yaml.safe_load((ROOT / "docker/prometheus/alerts.yml").read_text())
        self.assertEqual(objects("all").one("PrometheusRule")["spec"], rules)

    def test_the_manual_s_examples_are_accepted(self):
        """Values files of the chart's README."""
        blocks = re.findall(r"^```yaml\n(.*?)^```$", (CHART / "README.md").read_text(), re.M | re.S)
        self.assertGreater(len(blocks), 1)
        for block in blocks:
            self.assertEqual(complaints(rendered(yaml.safe_load(block))), [])

    def test_the_schemas_are_there(self):
        self.assertTrue((HERE / "node_modules/kubernetes-models").is_dir())


if __name__ == "__main__":
    unittest.main()
