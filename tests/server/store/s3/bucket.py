"""A bucket on a real S3-compatible server of this machine, and how commands find it."""
import datetime
import hashlib
import hmac
import http.client
import os

BUCKET = "meshes-of-tests"


def make(port, user, secret):
    """Makes the bucket by a request with a signature of version 4."""
    stamp = datetime.datetime.now(datetime.timezone.utc).strftime("%Y%m%dT%H%M%SZ")
    scope = [stamp[:8], "us-east-1", "s3", "aws4_request"]
    nothing = hashlib.sha256(b"").hexdigest()
    canonical = f"PUT\n/{BUCKET}\n\nhost:127.0.0.1:{port}\nx-amz-content-sha256:{nothing}\nx-amz-date:{stamp}\n\nhost;x-amz-content-sha256;x-amz-date\n{nothing}"
    to_sign = "\n".join(["AWS4-HMAC-SHA256", stamp, "/".join(scope), hashlib.sha256(canonical.encode()).hexdigest()])
    key = ("AWS4" + secret).encode()
    for part in [*scope, to_sign]:
        key = hmac.new(key, part.encode(), hashlib.sha256).digest()
    credential = f"Credential={user}/{'/'.join(scope)},SignedHeaders=host;x-amz-content-sha256;x-amz-date,Signature={key.hex()}"
    connection = http.client.HTTPConnection("127.0.0.1", port)
    headers = {"x-amz-content-sha256": nothing, "x-amz-date": stamp, "Authorization": "AWS4-HMAC-SHA256 " + credential}
    connection.request("PUT", f"/{BUCKET}", headers=headers)
    answer = connection.getresponse()
    if answer.status != 200:
        raise SystemExit(f"the server makes no bucket: {answer.read().decode()}")


def environment(port, user, secret):
    return os.environ | {"AWS_ACCESS_KEY_ID": user, "AWS_SECRET_ACCESS_KEY": secret,
                         "MESHGAUGE_TEST_S3": f"http://127.0.0.1:{port}", "MESHGAUGE_TEST_S3_BLOBS": f"s3://{BUCKET}/run"}  # fmt: skip
