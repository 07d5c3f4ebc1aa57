#!/usr/bin/env python3
"""A test double of S3: the operations that the store uses, on objects in memory, for requests whose signatures are right
byte for byte (sigv4.py). No S3: what it does was written from AWS's reference, and is stricter where that is vague.

    s3_double.py ACCOUNT        JSON: access_key, secret_key, token, region, bucket

It writes its port to standard output and ends with its standard input. Paths that begin with /-/ are the test's own and
are not signed: see Control.
"""
import base64
import copy
import datetime
import hashlib
import http.server
import json
import re
import socket
import ssl
import sys
import threading
import time
import urllib.parse
import xml.etree.ElementTree
from email.utils import formatdate
from xml.sax.saxutils import escape

import sigv4

LEAST_PART = 5 << 20


class Stored:
    def __init__(self, body, clock, etag=None, sha256=None):
        self.body, self.modified = body, clock
        self.etag = etag or '"' + hashlib.md5(body).hexdigest() + '"'
        self.sha256 = sha256 or base64.b64encode(hashlib.sha256(body).digest()).decode()


class Upload:
    def __init__(self, key, clock):
        self.key, self.begun, self.parts = key, clock, {}


class Parts:
    """The number of requests under way: from their heads until their answers."""

    def __init__(self):
        self.changed, self.sending, self.most, self.crossed = threading.Condition(), 0, 0, 0

    def add(self, difference):
        with self.changed:
            self.sending += difference
            self.most = max(self.most, self.sending)
            self.changed.notify_all()

    def gather(self, count):
        """Waits until so many requests are under way at once, or until it is certain that there will not be."""
        with self.changed:
            self.changed.wait_for(lambda: self.most >= count, timeout=10)


class World:
    """The server's state, and the faults that a test has requested."""

    def __init__(self, account):
        self.account, self.lock = account, threading.Lock()
        self.objects, self.uploads, self.log, self.faults = {}, {}, [], []
        self.earlier = {}  # each object as it was before its last change; None: there was none
        self.page, self.checksums, self.least_part, self.ahead, self.last_id = 1000, True, LEAST_PART, 0.0, 0
        self.parts, self.released = Parts(), threading.Event()

    def clock(self):
        return time.time() + self.ahead

    def fault(self, method, target):
        """The first fault that matches; its count falls by one."""
        with self.lock:
            for fault in self.faults:
                if fault["times"] > 0 and fault["method"] == method and re.search(fault["match"], target):
                    fault["times"] -= 1
                    return fault
        return None


def xml_time(seconds):
    return datetime.datetime.fromtimestamp(seconds, datetime.timezone.utc).strftime("%Y-%m-%dT%H:%M:%S.") + f"{int(seconds * 1000) % 1000:03}Z"


class Answer(Exception):
    def __init__(self, status, body=b"", **headers):
        super().__init__(status)
        self.status, self.body, self.headers = status, body, {name.replace("_", "-"): value for name, value in headers.items()}


def refusal(status, code, message=""):
    text = f'<?xml version="1.0" encoding="UTF-8"?>\n<Error><Code>{code}</Code><Message>{escape(message)}</Message></Error>'
    return Answer(status, text.encode(), Content_Type="application/xml")


def document(text):
    return Answer(200, ('<?xml version="1.0" encoding="UTF-8"?>\n' + text).encode(), Content_Type="application/xml")


class Control:
    """The test's own requests: POST /-/NAME with JSON, answered with JSON."""

    def __init__(self, world):
        self.world = world

    def settings(self, values):
        for name, value in values.items():
            setattr(self.world, name, value)

    def faults(self, faults):
        """[{"method", "match", "times", "what"}]: slow_down, status (with status and code, or with a body that is not
        S3's), reset, stall (with seconds), late (carried out after seconds), hold (until release), gather (until there
        were count parts at once), cut (after the body's half), stall_body (there, for seconds), slow (seconds before the
        head and before each tenth of the body), wrong_bytes, stale (of a read: each object as it was before its last
        change), late_error (200, then an error in the body), done_but_lost (carried out, then a reset)."""
        self.world.faults = faults

    def release(self, _):
        self.world.released.set()

    def log(self, _):
        log = list(self.world.log)  # to which another thread may add at any time
        del self.world.log[:len(log)]
        return log

    def state(self, _):
        return {"objects": {key: len(stored.body) for key, stored in self.world.objects.items()},
                "uploads": sorted(upload.key for upload in self.world.uploads.values()),
                "most_parts": self.world.parts.most, "crossed": self.world.parts.crossed}  # fmt: skip

    def plant(self, plants):
        """[{"key", "text", "age_s"}]: objects without a signature."""
        for plant in plants:
            self.world.objects[plant["key"]] = Stored(plant["text"].encode(), self.world.clock() - plant.get("age_s", 0))

    def truncate(self, wanted):
        """{"key", "bytes"}: an object loses what is behind so many bytes; its checksum stays."""
        stored = self.world.objects[wanted["key"]]
        stored.body = stored.body[: wanted["bytes"]]

    def age(self, seconds):
        for thing in self.world.objects.values():
            thing.modified -= seconds
        for thing in self.world.uploads.values():
            thing.begun -= seconds


class Operations:
    """One request that was signed and whose body is whole. Each method raises its Answer."""

    def __init__(self, world, key, query, headers, body, stale=False):
        self.world, self.key, self.query, self.headers, self.body, self.stale = world, key, query, headers, body, stale

    def objects(self):
        """What a read sees."""
        before = self.world.earlier if self.stale else {}
        return {key: stored for key, stored in {**self.world.objects, **before}.items() if stored}

    def change(self, stored):
        """Replaces the object; None: removes it."""
        self.world.earlier[self.key] = self.world.objects.pop(self.key, None)
        if stored:
            self.world.objects[self.key] = stored

    def name(self, method):
        what = "bucket" if not self.key else "object"
        for one in ("uploads", "uploadId"):
            if one in self.query:
                what += "_" + one.lower()
        return f"{method.lower()}_{what}"

    def run(self, method):
        with self.world.lock:
            getattr(self, self.name(method), self.unknown)()

    def unknown(self):
        raise refusal(501, "NotImplemented")

    def found(self):
        objects = self.objects()
        if self.key not in objects:
            raise refusal(404, "NoSuchKey")
        return objects[self.key]

    def put_object(self):
        if "x-amz-copy-source" in self.headers:
            return self.copy()
        wanted = self.headers.get("x-amz-checksum-sha256")
        if wanted and wanted != base64.b64encode(hashlib.sha256(self.body).digest()).decode():
            raise refusal(400, "BadDigest")
        stored = Stored(self.body, self.world.clock())
        self.change(stored)
        raise Answer(200, ETag=stored.etag)

    def copy(self):
        bucket, _, source = sigv4.decoded(self.headers["x-amz-copy-source"].lstrip("/")).decode().partition("/")
        if self.body or bucket != self.world.account["bucket"] or source != self.key:
            raise refusal(400, "InvalidRequest", "the store copies objects onto themselves alone")
        if self.headers.get("x-amz-metadata-directive") != "REPLACE":
            raise refusal(400, "InvalidRequest", "This copy request is illegal because it is trying to copy an object to itself without changing it")
        stored = copy.copy(self.found())
        stored.modified = self.world.clock()
        self.change(stored)
        raise document(f"<CopyObjectResult><ETag>{escape(stored.etag)}</ETag></CopyObjectResult>")

    def head_object(self):
        stored = self.found()
        headers = {"Last-Modified": formatdate(stored.modified, usegmt=True), "ETag": stored.etag}
        if self.world.checksums and self.headers.get("x-amz-checksum-mode") == "ENABLED":
            headers["x-amz-checksum-sha256"] = stored.sha256
        raise Answer(200, stored.body, **headers)

    def get_object(self):
        stored = self.found()
        match = re.fullmatch(r"bytes=(\d+)-", self.headers.get("range", ""))
        begin = int(match[1]) if match else 0
        if begin and begin >= len(stored.body):
            raise refusal(416, "InvalidRange")
        raise Answer(206 if match else 200, stored.body[begin:], ETag=stored.etag)

    def delete_object(self):
        self.change(None)
        raise Answer(204)

    def get_bucket(self):
        prefix, token = self.query.get("prefix", ""), self.query.get("continuation-token", "")
        if self.query.get("list-type") != "2":
            raise refusal(501, "NotImplemented")
        after = base64.b64decode(token).decode() if token else ""
        objects = self.objects()
        keys = sorted(key for key in objects if key.startswith(prefix) and key > after)
        page, more = keys[: self.world.page], len(keys) > self.world.page
        text = "".join(
            f"<Contents><Key>{escape(key)}</Key><LastModified>{xml_time(objects[key].modified)}</LastModified>"
            f"<ETag>&quot;x&quot;</ETag><Size>{len(objects[key].body)}</Size></Contents>" for key in page)  # fmt: skip
        next_token = f"<NextContinuationToken>{base64.b64encode(page[-1].encode()).decode()}</NextContinuationToken>" if more else ""
        raise document(f'<ListBucketResult xmlns="http://s3.amazonaws.com/doc/2006-03-01/"><IsTruncated>{str(more).lower()}</IsTruncated>{text}{next_token}</ListBucketResult>')

    def post_object_uploads(self):
        self.world.last_id += 1
        name = f"id/{self.world.last_id}+ & <x>"  # S3's ids are opaque: this one must be encoded wherever it goes
        self.world.uploads[name] = Upload(self.key, self.world.clock())
        raise document(f"<InitiateMultipartUploadResult><Key>{escape(self.key)}</Key><UploadId>{escape(name)}</UploadId></InitiateMultipartUploadResult>")

    def upload(self):
        upload = self.world.uploads.get(self.query["uploadId"])
        if not upload or upload.key != self.key:
            raise refusal(404, "NoSuchUpload")
        return upload

    def put_object_uploadid(self):
        upload, number = self.upload(), int(self.query["partNumber"])
        etag = '"' + hashlib.md5(self.body).hexdigest() + '"'
        upload.parts[number] = (etag, self.body)
        raise Answer(200, ETag=etag)

    def post_object_uploadid(self):
        upload = self.upload()
        listed = [(int(part.findtext("PartNumber")), part.findtext("ETag")) for part in xml.etree.ElementTree.fromstring(self.body)]
        if [number for number, _ in listed] != list(range(1, len(listed) + 1)):
            raise refusal(400, "InvalidPartOrder")
        if any(number not in upload.parts or upload.parts[number][0] != etag for number, etag in listed):
            raise refusal(400, "InvalidPart")
        parts = [upload.parts[number][1] for number, _ in listed]
        if any(len(part) < self.world.least_part for part in parts[:-1]):
            raise refusal(400, "EntityTooSmall")
        digests = b"".join(hashlib.sha256(part).digest() for part in parts)
        composite = base64.b64encode(hashlib.sha256(digests).digest()).decode() + f"-{len(parts)}"
        stored = Stored(b"".join(parts), self.world.clock(), f'"{hashlib.md5(digests).hexdigest()}-{len(parts)}"', composite)
        self.change(stored)
        del self.world.uploads[self.query["uploadId"]]
        raise document(f"<CompleteMultipartUploadResult><ETag>{escape(stored.etag)}</ETag></CompleteMultipartUploadResult>")

    def delete_object_uploadid(self):
        self.upload()
        self.world.parts.crossed += self.world.parts.sending  # such a part may stay for ever: no client aborts it
        del self.world.uploads[self.query["uploadId"]]
        raise Answer(204)

    def get_bucket_uploads(self):
        after = (self.query.get("key-marker", ""), self.query.get("upload-id-marker", ""))
        found = sorted((upload.key, name) for name, upload in self.world.uploads.items())
        found = [one for one in found if one[0].startswith(self.query.get("prefix", "")) and one > after]
        page, more = found[: self.world.page], len(found) > self.world.page
        text = "".join(f"<Upload><Key>{escape(key)}</Key><UploadId>{escape(name)}</UploadId><Initiated>{xml_time(self.world.uploads[name].begun)}</Initiated></Upload>" for key, name in page)
        marks = f"<NextKeyMarker>{escape(page[-1][0])}</NextKeyMarker><NextUploadIdMarker>{escape(page[-1][1])}</NextUploadIdMarker>" if more else ""
        raise document(f"<ListMultipartUploadsResult><IsTruncated>{str(more).lower()}</IsTruncated>{marks}{text}</ListMultipartUploadsResult>")


class Handler(http.server.BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"
    world = None
    disable_nagle_algorithm = True

    def log_message(self, *_):
        pass

    def serve(self):
        method, target, _ = self.requestline.split(" ")  # self.path is not what was sent: leading slashes are merged
        self.part = "partNumber=" in target
        self.world.parts.add(int(self.part))
        body = self.rfile.read(int(self.headers.get("Content-Length", 0)))
        try:
            if target.startswith("/-/"):
                result = getattr(Control(self.world), target[3:])(json.loads(body))
                raise Answer(200, json.dumps(result).encode())
            self.world.log.append({"method": method, "target": target, "range": self.headers.get("Range", ""), "peer": self.client_address[1], "bytes": len(body)})
            self.serve_s3(method, target, body)
        except sigv4.Refused as error:
            self.send(method, refusal(error.status, error.code, error.message))
        except Answer as answer:
            self.send(method, answer)

    def serve_s3(self, method, target, body):
        fault = self.world.fault(method, target) or {"what": ""}
        if fault["what"] == "slow_down":
            raise refusal(503, "SlowDown", "Reduce your request rate.")
        if fault["what"] == "status":
            raise refusal(fault["status"], fault["code"]) if "code" in fault else Answer(fault["status"], fault["body"].encode())
        if fault["what"] == "stall":
            time.sleep(fault["seconds"])
            return self.reset()
        if fault["what"] == "late":
            time.sleep(fault["seconds"])
        if fault["what"] == "hold":
            self.world.released.wait(timeout=20)
        if fault["what"] == "gather":
            self.world.parts.gather(fault["count"])
        if fault["what"] == "late_error":
            raise refusal(200, "InternalError")
        if fault["what"] == "reset":
            return self.reset()
        try:
            self.operate(method, target, body, fault["what"] == "stale")
        except Answer as answer:
            if fault["what"] == "done_but_lost":
                return self.reset()
            if fault["what"] == "wrong_bytes":
                answer.body = answer.body[:-1] + bytes([answer.body[-1] ^ 1])
            self.send(method, answer, fault["what"] in ("cut", "stall_body"), fault["seconds"] if fault["what"] == "slow" else 0)
            if fault["what"] == "stall_body":
                time.sleep(fault["seconds"])

    def operate(self, method, target, body, stale):
        names = {name.lower() for name in self.headers}
        now = datetime.datetime.fromtimestamp(self.world.clock(), datetime.timezone.utc)
        digest = sigv4.check(method, target, {name: self.headers.get_all(name) for name in names}, self.world.account, now)
        if hashlib.sha256(body).hexdigest() != digest:
            raise refusal(400, "XAmzContentSHA256Mismatch")
        path, _, query = target.partition("?")
        path = sigv4.decoded(path).decode()[1:]
        host = self.headers["Host"].rsplit(":", 1)[0]
        bucket, key = (host.split(".")[0], path) if host.endswith(".localhost") else path.partition("/")[::2]
        if bucket != self.world.account["bucket"]:
            raise refusal(404, "NoSuchBucket")
        fields = {name: values[0] for name, values in urllib.parse.parse_qs(query.replace("+", "%2B"), keep_blank_values=True).items()}
        Operations(self.world, key, fields, {name: self.headers[name] for name in names}, body, stale).run(method)

    def part_ends(self):
        self.world.parts.add(-int(self.part))
        self.part = False

    def send(self, method, answer, cut=False, pause=0):
        """`pause`: seconds before the head and before each tenth of the body."""
        self.part_ends()
        headers = {"Date": formatdate(self.world.clock(), usegmt=True), "Content-Length": len(answer.body), **answer.headers}
        head = f"HTTP/1.1 {answer.status} x\r\n" + "".join(f"{name}: {value}\r\n" for name, value in headers.items()) + "\r\n"
        body = b"" if method == "HEAD" else answer.body[: len(answer.body) // 2] if cut else answer.body
        if pause:
            tenth = len(body) // 10 + 1
            for piece in (head.encode(), *(body[i : i + tenth] for i in range(0, len(body), tenth))):
                time.sleep(pause)
                self.wfile.write(piece)
        else:
            self.wfile.write(head.encode() + body)
        self.close_connection = cut

    def reset(self):
        self.part_ends()
        linger_none = b"\1\0\0\0\0\0\0\0"
        self.connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, linger_none)
        self.connection.close()
        self.close_connection = True

    do_GET = do_PUT = do_HEAD = do_POST = do_DELETE = serve


class Server(http.server.ThreadingHTTPServer):
    daemon_threads = True
    request_queue_size = 128

    def handle_error(self, request, client_address):
        if not isinstance(sys.exc_info()[1], OSError):  # a client that has gone is none of ours
            super().handle_error(request, client_address)


def main():
    account = json.loads(sys.argv[1])
    Handler.world = World(account)
    server = Server(("127.0.0.1", 0), Handler)
    if account.get("certificate"):
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        context.load_cert_chain(account["certificate"], account["key"])
        server.socket = context.wrap_socket(server.socket, server_side=True)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    print(server.server_address[1], flush=True)
    sys.stdin.read()


if __name__ == "__main__":
    main()
