#!/usr/bin/env python3
"""PostgreSQL on three nodes: Patroni, synchronous replication, etcd to vote by; on loopback, private, gone afterwards. As a command:

    patroni.py                  starts one, kills the leader three times and says how long nothing could be written
    patroni.py -- COMMAND...    runs the command with MESHGAUGE_DATABASE, the url of all nodes; its exit code
"""

import argparse
import contextlib
import json
import os
import secrets
import shutil
import subprocess
import sys
import time
import urllib.request

from postgres import DATABASE, ENVIRONMENT, USER, Missing, or_skip, psql, usable_binaries
from scratch import TOOLS, Scratch, end_inside, free_port, servant, within_reach

READY_SECONDS = 120
# A leader that is silent for so long is replaced. Patroni asks for LOOP + 2 * RETRY <= TTL.
TTL, LOOP, RETRY = 5, 1, 2


class Programs:
    """Where patroni and etcd are; `environment`, what patroni needs to find its own."""

    def __init__(self, scratch):
        self.environment = {}
        unpacked = TOOLS / "usr"
        if all((unpacked / "bin" / name).exists() for name in ("etcd", "patroni")):
            usr = within_reach(scratch, unpacked, "bin/etcd", "bin/patroni", "lib/python3")
            self.etcd, self.patroni = usr / "bin/etcd", usr / "bin/patroni"
            self.environment = {"PYTHONPATH": str(usr / "lib/python3/dist-packages")}
            return
        self.etcd, self.patroni = shutil.which("etcd"), shutil.which("patroni")
        if self.etcd is None or self.patroni is None:
            raise Missing("no patroni and etcd: neither in build/tools (./dev chaos cluster) nor on PATH")


class Etcd:
    """The only member of etcd, which holds the leader's key. It is not under test, so it is never killed."""

    def __init__(self, scratch, program):
        self.folder, self.port = scratch.folder("etcd"), free_port()
        ours, peers = ("http://127.0.0.1:%d" % port for port in (self.port, free_port()))
        with open(self.folder / "log", "wb") as log:
            self.process = subprocess.Popen(
                [program, "--name", "one", "--data-dir", self.folder / "data", "--logger", "zap", "--log-level", "error",
                 "--listen-client-urls", ours, "--advertise-client-urls", ours, "--listen-peer-urls", peers,
                 "--initial-advertise-peer-urls", peers, "--initial-cluster", "one=" + peers],
                stdin=subprocess.DEVNULL, stdout=log, stderr=log, cwd=self.folder, env=ENVIRONMENT, **servant())


class Node:
    """One PostgreSQL and its Patroni."""

    def __init__(self, scratch, name, programs, binaries, etcd, password):
        self.name, self.folder = name, scratch.folder(name)
        self.port, self.rest_port = free_port(), free_port()
        self.process = None
        self.programs = programs
        self.configuration = self.folder / "patroni.json"
        self.configuration.write_text(json.dumps(self._settings(binaries, etcd, password)))
        self.configuration.chmod(0o644)  # its folder is closed

    def _settings(self, binaries, etcd, password):
        hosts = ["local all all trust", "host all all 127.0.0.1/32 scram-sha-256", "host replication all 127.0.0.1/32 scram-sha-256"]
        return {
            "scope": "meshgauge", "name": self.name, "log": {"level": "INFO"},
            "restapi": {"listen": "127.0.0.1:%d" % self.rest_port, "connect_address": "127.0.0.1:%d" % self.rest_port},
            "etcd3": {"host": "127.0.0.1:%d" % etcd.port},
            "bootstrap": {
                "dcs": {
                    "ttl": TTL, "loop_wait": LOOP, "retry_timeout": RETRY, "primary_start_timeout": 0, "maximum_lag_on_failover": 1 << 20,
                    "synchronous_mode": True, "synchronous_mode_strict": True,
                    "postgresql": {"use_pg_rewind": True, "parameters": {"max_connections": 200, "wal_log_hints": "on"}}},
                "initdb": [{"encoding": "UTF8"}, {"locale": "C.UTF-8"}, {"auth": "scram-sha-256"}]},
            "postgresql": {
                "listen": "127.0.0.1:%d" % self.port, "connect_address": "127.0.0.1:%d" % self.port,
                "data_dir": str(self.folder / "data"), "bin_dir": str(binaries), "pgpass": str(self.folder / "pgpass"),
                "authentication": {"superuser": {"username": USER, "password": password},
                                   "replication": {"username": "replicator", "password": password}},
                # A follower finds a new leader at once, not after 5 s.
                "parameters": {"unix_socket_directories": str(self.folder), "shared_buffers": "64MB", "jit": "off",
                               "wal_retrieve_retry_interval": "200ms", "dynamic_shared_memory_type": "mmap"},
                # Half-rewound data of a node that was killed is no use: it fetches all of it anew.
                "remove_data_directory_on_rewind_failure": True, "remove_data_directory_on_diverged_timelines": True,
                "pg_hba": hosts}}

    def start(self):
        assert self.process is None
        with open(self.folder / "log", "ab") as log:
            self.process = subprocess.Popen(["/usr/bin/python3", self.programs.patroni, self.configuration], stdin=subprocess.DEVNULL,
                                            stdout=log, stderr=log, cwd=self.folder, env={**ENVIRONMENT, **self.programs.environment},
                                            **servant())

    def kill(self):
        """kill -9 of PostgreSQL and Patroni, as when the machine loses its power."""
        self.process.kill()
        end_inside(self.folder)
        self.process.wait()
        self.process = None

    def rest(self, path):
        return "http://127.0.0.1:%d/%s" % (self.rest_port, path)

    def tail(self):
        return (self.folder / "log").read_text(errors="replace")[-3000:]


class Cluster:
    """Three nodes, of which one leads and one follows synchronously."""

    def __init__(self, nodes=3):
        self.scratch = Scratch()
        try:
            self.password = secrets.token_hex(8)
            self.binaries = usable_binaries(self.scratch)
            programs = Programs(self.scratch)
            self.etcd = Etcd(self.scratch, programs.etcd)
            self.nodes = [Node(self.scratch, "node%d" % i, programs, self.binaries, self.etcd, self.password) for i in range(1, nodes + 1)]
            self.nodes[0].start()
            self._until(lambda: self.leader() is not None)
            for node in self.nodes[1:]:
                node.start()
            self.wait_whole()
            psql(self.binaries, self.url("postgres"), "CREATE DATABASE " + DATABASE)
        except BaseException:
            self.close()
            raise

    def url(self, database=DATABASE):
        hosts = ",".join("127.0.0.1:%d" % node.port for node in self.nodes)
        return "postgresql://%s:%s@%s/%s?target_session_attrs=read-write&connect_timeout=2" % (USER, self.password, hosts, database)

    def query(self, sql, database=DATABASE):
        return psql(self.binaries, self.url(database), sql)

    def ask(self, sql, database=DATABASE):
        """query(), as soon as a node takes the connection and writes. What was sent is not repeated."""
        found = []

        def asked():
            try:
                found.append(self.query(sql, database))
            except subprocess.CalledProcessError as error:
                if not error.stderr.startswith("psql: error: connection to server at"):
                    raise
            return found
        self._until(asked)
        return found[0]

    def members(self):
        """Name to role, state and lag of all nodes, from the first Patroni that answers."""
        for node in self.nodes:
            if node.process is not None:
                with contextlib.suppress(OSError, ValueError):
                    with urllib.request.urlopen(node.rest("cluster"), timeout=2) as answer:
                        return {one["name"]: one for one in json.load(answer)["members"]}
        return {}

    def leader(self):
        """The node that leads and takes writes; None: none does at the moment."""
        for node in self.nodes:
            with contextlib.suppress(OSError):
                if node.process is not None and urllib.request.urlopen(node.rest("primary"), timeout=2).status == 200:
                    return node
        return None

    def is_whole(self):
        """Whether all run, one leads, and one follows it synchronously: then the leader may die."""
        members = self.members().values()
        roles = [one["role"] for one in members]
        return len(members) == len(self.nodes) and all(one["state"] in ("running", "streaming") for one in members) and \
            "leader" in roles and "sync_standby" in roles

    def wait_whole(self):
        self._until(self.is_whole)

    def _until(self, condition):
        end = time.monotonic() + READY_SECONDS
        while not condition():
            assert time.monotonic() < end, "waited in vain: %s\n%s" % (self.members(), "\n".join(node.tail() for node in self.nodes
                                                                                                if (node.folder / "log").exists()))
            time.sleep(0.1)

    def close(self):
        self.scratch.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()


def writes_again(cluster):
    """Waits until the database takes a write; returns the seconds that took."""
    began = time.monotonic()
    while True:
        with contextlib.suppress(subprocess.SubprocessError):
            cluster.query("INSERT INTO pulse DEFAULT VALUES")
            return time.monotonic() - began
        assert time.monotonic() < began + READY_SECONDS, "nothing can be written any more"
        time.sleep(0.05)


def measure(cluster, kills):
    cluster.query("CREATE TABLE pulse (at timestamptz DEFAULT now())")
    for _ in range(kills):
        leader = cluster.leader()
        print("%s leads: %s" % (leader.name, {name: one["role"] for name, one in cluster.members().items()}), flush=True)
        leader.kill()
        gone = writes_again(cluster)
        leader.start()
        began = time.monotonic()
        cluster.wait_whole()
        print("  killed: written again after %.1f s, whole %.1f s later" % (gone, time.monotonic() - began), flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kills", type=int, default=3)
    parser.add_argument("command", nargs="*")
    arguments = parser.parse_args()
    with or_skip():
        cluster = Cluster()
    with cluster:
        if not arguments.command:
            return measure(cluster, arguments.kills)
        code = subprocess.run(arguments.command, env={**os.environ, "MESHGAUGE_DATABASE": cluster.url()}).returncode
    sys.exit(code if code >= 0 else 128 - code)


if __name__ == "__main__":
    main()
