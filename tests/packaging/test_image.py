"""The images, as far as they can be tried without one: what they begin with, and what ./dev container makes of that."""

import json
import os
import pathlib
import re
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
SERVES = ["serve", "--host", "0.0.0.0"]


def stages():
    """The instructions of each stage of docker/Dockerfile, by its name; "" is the last one, which is built by default."""
    text = re.sub(r"\\\\\n", "", (ROOT / "docker/Dockerfile").read_text())
    found, name = {}, None
    for line in text.splitlines():
        if begin := re.match(r"FROM \S+(?: AS (\S+))?$", line):
            name = begin[1] or ""
            found[name] = []
        elif name is not None and re.match(r"[A-Z]+ ", line):
            found[name].append(tuple(line.split(" ", 1)))
    return found


def exec_form(stage, instruction):
    """The words of the stage's instruction."""
    (words,) = [json.loads(rest) for name, rest in stages()[stage] if name == instruction]
    return words


class Dockerfile(unittest.TestCase):
    def test_the_image_is_the_program_and_serves_by_default(self):
        self.assertEqual(list(stages())[-1], "")
        self.assertEqual((exec_form("", "ENTRYPOINT"), exec_form("", "CMD")), (["meshgauge"], SERVES))
        self.assertEqual((exec_form("ci", "ENTRYPOINT"), exec_form("ci", "CMD")), (["/bin/entry"], SERVES))

    def test_only_the_image_of_pipelines_has_a_shell(self):
        copied = {stage: [rest for name, rest in stages()[stage] if name == "COPY"] for stage in ("", "ci")}
        self.assertEqual(copied[""], ["--from=program /image/ /"])
        self.assertIn("--from=shell /shell/ /", copied["ci"])

    def test_the_release_has_both(self):
        release = (ROOT / ".github/workflows/release.yml").read_text()
        self.assertIn('--tag "$name:${TAG#v}" ', release)
        self.assertIn('--target ci --tag "$name:${TAG#v}-ci" ', release)


class Entry(unittest.TestCase):
    """docker/ci/entry.sh, which the image for pipelines begins with."""

    def run_entry(self, *arguments):
        with tempfile.TemporaryDirectory() as folder:
            program = pathlib.Path(folder) / "meshgauge"
            program.write_text('#!/bin/sh\nprintf "meshgauge"; printf " [%s]" "$@"\n')
            program.chmod(0o755)
            done = subprocess.run([ROOT / "docker/ci/entry.sh", *arguments], text=True, capture_output=True, check=False, input="echo from stdin",
                                  env={"PATH": f"{folder}:{os.environ['PATH']}"})
        return done.returncode, done.stdout

    def test_a_program_runs(self):
        self.assertEqual(self.run_entry("sh", "-c", 'echo "$0"; exit 4', "a b"), (4, "a b\n"))
        self.assertEqual(self.run_entry("sh"), (0, "from stdin\n"))  # as GitLab sends a script

    def test_a_verb_is_one_of_meshgauge(self):
        self.assertEqual(self.run_entry("check", "a b.yaml"), (0, "meshgauge [check] [a b.yaml]"))
        self.assertEqual(self.run_entry("--version"), (0, "meshgauge [--version]"))
        self.assertEqual(self.run_entry(*SERVES), (0, "meshgauge [serve] [--host] [0.0.0.0]"))
        self.assertEqual(self.run_entry("meshgauge", "check"), (0, "meshgauge [check]"))


class Bundle(unittest.TestCase):
    """.ci/bundle.py, by which ./dev container runs an image without a daemon."""

    def process(self, *arguments, run_as="", **image):
        config = {"Entrypoint": ["meshgauge"], "Cmd": SERVES, "Env": ["A=b"], "WorkingDir": "/tmp", "User": "10001:0",
                  "Volumes": {"/var/lib/meshgauge": {}}, **image}
        done = subprocess.run([ROOT / ".ci/bundle.py", "/root", "/data", "/samples", "/tools", "C=d", *arguments], text=True, check=True,
                              stdout=subprocess.PIPE, input=json.dumps({"OCIv1": {"config": config}}), env={**os.environ, "RUN_AS": run_as})
        made = json.loads(done.stdout)
        self.assertTrue(made["root"]["readonly"])
        self.assertEqual("/var/lib/meshgauge" in [mount["destination"] for mount in made["mounts"]], bool(config["Volumes"]))
        return made["process"]

    def test_arguments_are_the_image_s_own_or_others(self):
        self.assertEqual(self.process()["args"], ["meshgauge", *SERVES])
        self.assertEqual(self.process("--", "check", "x")["args"], ["meshgauge", "check", "x"])
        self.assertEqual(self.process()["env"], ["A=b", "C=d"])

    def test_users(self):
        self.assertEqual(self.process()["user"], {"uid": 10001, "gid": 0})
        self.assertEqual(self.process(run_as="4711:12")["user"], {"uid": 4711, "gid": 12})
        self.assertEqual(self.process(User="", Volumes=None)["user"], {"uid": 0, "gid": 0})


if __name__ == "__main__":
    unittest.main()
