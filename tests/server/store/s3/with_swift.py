#!/usr/bin/python3
"""Runs a command with a real S3-compatible server: OpenStack Swift with its S3 interface, of Debian's packages.

    apt-get install swift-proxy swift-account swift-container swift-object
    with_swift.py build/tests/server/store/store_tests -tc='blobs:*<S3>'

All of Swift's servers are in this one process, on the loopback interface and in a temporary folder; it verifies version 4
of the signatures. The command finds the server by MESHGAUGE_TEST_S3, MESHGAUGE_TEST_S3_BLOBS and AWS_*.
"""
import os
import subprocess
import sys
import tempfile

import eventlet

eventlet.monkey_patch(thread=False)

# ruff: noqa: E402  Swift's modules must find patched ones.
from array import array

import bucket
from eventlet import wsgi
from eventlet.green import threading  # noqa: F401
from swift.common import utils

utils.SWIFT_CONF_FILE = "/dev/null"  # before anything reads it
utils.HASH_PATH_SUFFIX = b"tests"
utils.validate_hash_conf = lambda: None

from swift.account.server import AccountController
from swift.common import storage_policy
from swift.common.ring import RingData
from swift.common.wsgi import loadapp
from swift.container.server import ContainerController
from swift.obj.server import ObjectController

PART_POWER = 3
USER, SECRET = "tests:meshgauge", "s3-secret/key+"
PROXY = """
[DEFAULT]
swift_dir = {folder}
[pipeline:main]
pipeline = catch_errors listing_formats s3api tempauth copy slo proxy-server
[app:proxy-server]
use = egg:swift#proxy
account_autocreate = true
log_level = ERROR
[filter:catch_errors]
use = egg:swift#catch_errors
[filter:listing_formats]
use = egg:swift#listing_formats
[filter:s3api]
use = egg:swift#s3api
location = us-east-1
min_segment_size = 1
[filter:tempauth]
use = egg:swift#tempauth
user_tests_meshgauge = s3-secret/key+ .admin
[filter:copy]
use = egg:swift#copy
[filter:slo]
use = egg:swift#slo
rate_limit_under_size = 0
"""


class Memory:
    """Replaces memcached."""

    def __init__(self):
        self.values = {}

    def get(self, key, *_, **__):
        return self.values.get(key)

    def set(self, key, value, *_, **__):
        self.values[key] = value

    def incr(self, key, delta=1, **_):
        self.values[key] = int(self.values.get(key, 0)) + delta
        return self.values[key]

    def delete(self, key, *_, **__):
        self.values.pop(key, None)


def with_memory(app):
    memory = Memory()

    def call(environ, start_response):
        environ["swift.cache"] = memory
        return app(environ, start_response)

    return call


def listen():
    return eventlet.listen(("127.0.0.1", 0), backlog=128)


def serve(sock, app):
    eventlet.spawn(wsgi.server, sock, app, log=open(os.devnull, "w"), log_output=False, keepalive=True)


def save_ring(folder, name, port):
    device = {"id": 0, "zone": 0, "region": 1, "weight": 1.0, "device": "disk", "ip": "127.0.0.1", "port": port,
              "replication_ip": "127.0.0.1", "replication_port": port, "meta": ""}  # fmt: skip
    parts = [array("H", [0] * (1 << PART_POWER))]
    RingData(parts, [device], 32 - PART_POWER).save(os.path.join(folder, name + ".ring.gz"))


def start(folder):
    """The proxy's port."""
    os.makedirs(os.path.join(folder, "devices", "disk"))
    conf = {"devices": os.path.join(folder, "devices"), "mount_check": "false", "swift_dir": folder, "log_level": "ERROR"}
    storage_policy.reload_storage_policies()
    for name, controller in ("account", AccountController), ("container", ContainerController), ("object", ObjectController):
        sock = listen()
        save_ring(folder, name, sock.getsockname()[1])
        serve(sock, controller(conf))
    with open(os.path.join(folder, "proxy.conf"), "w", encoding="utf-8") as file:
        file.write(PROXY.format(folder=folder))
    sock = listen()
    serve(sock, with_memory(loadapp(file.name, global_conf={"log_level": "ERROR"})))
    return sock.getsockname()[1]


def run(command, environment):
    return eventlet.tpool.execute(subprocess.run, command, env=environment, check=False).returncode


def main():
    with tempfile.TemporaryDirectory(prefix="meshgauge-swift-") as folder:
        port = start(folder)
        bucket.make(port, USER, SECRET)
        code = run(sys.argv[1:], bucket.environment(port, USER, SECRET))
    raise SystemExit(code)


if __name__ == "__main__":
    main()
