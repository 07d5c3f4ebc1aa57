#!/usr/bin/python3
"""Runs a command with a real S3-compatible server: Ceph's object gateway over a cluster of one monitor and one OSD, of
Debian's packages.

    apt-get install --no-install-recommends ceph-mon ceph-osd radosgw
    tests/server/store/s3/with_ceph.py build/tests/server/store/store_tests -tc='blobs:*<S3>'

All is on the loopback interface, in memory and in a temporary folder. The command finds the server by MESHGAUGE_TEST_S3,
MESHGAUGE_TEST_S3_BLOBS and AWS_*.
"""
import contextlib
import os
import signal
import socket
import subprocess
import sys
import tempfile
import time
import uuid

import bucket

USER, SECRET = "TESTSOFMESHGAUGE", "s3-secret/key+"
START_S = 120
CONF = """
[global]
fsid = {fsid}
mon host = [v2:127.0.0.1:{mon},v1:127.0.0.1:{mon_v1}]
public addr = 127.0.0.1
run dir = {folder}
admin socket = {folder}/$name.asok
log file = {folder}/$name.log
crash dir = {folder}
keyring = {folder}/keyring
osd pool default size = 1
osd pool default min size = 1
osd pool default pg num = 8
osd pool default pg autoscale mode = off
osd crush chooseleaf type = 0
mon allow pool size one = true
mon max pg per osd = 1000
[mon]
mon data = {folder}/mon
[osd]
osd data = {folder}/osd
osd objectstore = memstore
memstore device bytes = 4294967296
[client]
rgw frontends = beast endpoint=127.0.0.1:{gateway}
rgw multipart min part size = 1
rgw data = {folder}
"""


def free_ports(count):
    with contextlib.ExitStack() as held:
        sockets = [held.enter_context(socket.socket()) for _ in range(count)]
        for one in sockets:
            one.bind(("127.0.0.1", 0))
        return [one.getsockname()[1] for one in sockets]


class Cluster:
    def __init__(self, folder):
        self.folder, self.running = folder, []
        self.conf, self.keys = os.path.join(folder, "ceph.conf"), os.path.join(folder, "keyring")

    def call(self, *words):
        done = subprocess.run([words[0], "-c", self.conf, *words[1:]], capture_output=True, text=True, timeout=START_S, check=False)
        if done.returncode:
            raise SystemExit(f"{' '.join(words)} has failed: {done.stderr}")
        return done.stdout.strip()

    def start(self, *words):
        log = open(os.path.join(self.folder, words[0] + ".out"), "wb")
        self.running.append(subprocess.Popen([words[0], "-c", self.conf, "-f", *words[1:]], stdout=log, stderr=log))

    def stop(self):
        """The newest first; nothing in it is worth waiting for."""
        for process in reversed(self.running):
            process.send_signal(signal.SIGKILL)
            process.wait()

    def make_keys(self):
        """One keyring for all: the cluster is private."""
        self.call("ceph-authtool", "--create-keyring", self.keys)
        for name, rights in ("mon.", ["mon"]), ("client.admin", ["mon", "osd"]), ("osd.0", ["mon", "osd"]):
            caps = [word for right in rights for word in ("--cap", right, "allow *")]
            self.call("ceph-authtool", self.keys, "--gen-key", "-n", name, *caps)

    def bring_up(self):
        mon, mon_v1, gateway = free_ports(3)
        fsid = str(uuid.uuid4())
        with open(self.conf, "w", encoding="utf-8") as file:
            file.write(CONF.format(folder=self.folder, fsid=fsid, mon=mon, mon_v1=mon_v1, gateway=gateway))
        for name in "mon", "osd":
            os.mkdir(os.path.join(self.folder, name))
        self.make_keys()
        monmap = os.path.join(self.folder, "monmap")
        self.call("monmaptool", "--create", "--fsid", fsid, "--addv", "a", f"[v2:127.0.0.1:{mon},v1:127.0.0.1:{mon_v1}]", monmap)
        self.call("ceph-mon", "-i", "a", "--mkfs", "--monmap", monmap, "--keyring", self.keys)
        self.start("ceph-mon", "-i", "a")
        osd = str(uuid.uuid4())
        self.call("ceph", "--connect-timeout", "60", "osd", "new", osd)
        self.call("ceph-osd", "-i", "0", "--mkfs", "--osd-uuid", osd)
        self.start("ceph-osd", "-i", "0")
        self.call("radosgw-admin", "user", "create", "--uid=tests", "--display-name=tests", "--access-key=" + USER, "--secret=" + SECRET)
        self.start("radosgw", "-n", "client.admin")
        self.wait_for(gateway)
        return gateway

    def wait_for(self, port):
        end = time.monotonic() + START_S
        while time.monotonic() < end:
            if any(process.poll() is not None for process in self.running):
                break
            with contextlib.suppress(OSError), socket.create_connection(("127.0.0.1", port), timeout=1):
                return
            time.sleep(0.1)
        raise SystemExit("Ceph's gateway does not start")


def main():
    with tempfile.TemporaryDirectory(prefix="meshgauge-ceph-") as folder:
        cluster = Cluster(folder)
        try:
            port = cluster.bring_up()
            bucket.make(port, USER, SECRET)
            code = subprocess.run(sys.argv[1:], env=bucket.environment(port, USER, SECRET), check=False).returncode
        finally:
            cluster.stop()
    raise SystemExit(code)


if __name__ == "__main__":
    main()
