"""The double's own verification against the examples that AWS prints, and against requests that were tampered with."""
import datetime
import hashlib
import unittest

import sigv4

ACCOUNT = {"access_key": "AKIAIOSFODNN7EXAMPLE", "secret_key": "wJalrXUtnFEMI/K7MDENG/bPxRfiCYEXAMPLEKEY", "region": "us-east-1", "token": ""}
NOW = datetime.datetime(2013, 5, 24, 0, 5, tzinfo=datetime.timezone.utc)
NOTHING = hashlib.sha256(b"").hexdigest()


def headers(signature, digest=NOTHING, **more):
    found = {"host": "examplebucket.s3.amazonaws.com", "x-amz-date": "20130524T000000Z", "x-amz-content-sha256": digest}
    found |= {name.replace("_", "-"): value for name, value in more.items()}
    signed = ";".join(sorted(found))
    found["authorization"] = f"AWS4-HMAC-SHA256 Credential=AKIAIOSFODNN7EXAMPLE/20130524/us-east-1/s3/aws4_request,SignedHeaders={signed},Signature={signature}"
    return {name: [value] for name, value in found.items()}


LIST = ("GET", "/?max-keys=2&prefix=J", headers("34b48302e7b5fa45bde8084f4b7868a86f0a534bc59db6670ed5711ef69dc6f7"))
PUT_DIGEST = hashlib.sha256(b"Welcome to Amazon S3.").hexdigest()
EXAMPLES = [
    ("GET", "/test.txt", headers("f0e8bdb87c964420e857bd35b5d6ed310bd44f0170aba48dd91039c6036bdb41", range="bytes=0-9")),
    ("PUT", "/test%24file.text", headers("98ad721746da40c64f1a55b78f14c238d841ea1380cd77a1b5971af0ece108bd", PUT_DIGEST,
                                         date="Fri, 24 May 2013 00:00:00 GMT", x_amz_storage_class="REDUCED_REDUNDANCY")),
    ("GET", "/?lifecycle=", headers("fea454ca298b7da1c68078a5d1bdbfbbe0d65c699e0f91ac7a200a0136783543")),
    LIST,
]  # fmt: skip


class Verification(unittest.TestCase):
    def refused(self, code, method, target, sent, now=NOW, account=ACCOUNT):
        with self.assertRaises(sigv4.Refused) as caught:
            sigv4.check(method, target, sent, account, now)
        self.assertEqual(caught.exception.code, code)

    def test_examples_of_aws_are_let_in(self):
        for method, target, sent in EXAMPLES:
            self.assertEqual(sigv4.check(method, target, sent, ACCOUNT, NOW), sent["x-amz-content-sha256"][0])

    def test_one_changed_byte_is_refused(self):
        method, target, sent = LIST
        self.refused("SignatureDoesNotMatch", "PUT", target, sent)
        self.refused("SignatureDoesNotMatch", method, target.replace("J", "K"), sent)
        self.refused("SignatureDoesNotMatch", method, "/?prefix=J&max-keys=2", sent)  # sent in another order than signed
        self.refused("SignatureDoesNotMatch", method, target, sent | {"host": ["example.com"]})
        self.refused("SignatureDoesNotMatch", method, target, sent | {"x-amz-content-sha256": [PUT_DIGEST]})
        self.refused("SignatureDoesNotMatch", *LIST, account=ACCOUNT | {"secret_key": "x"})

    def test_what_is_not_signed_is_refused(self):
        method, target, sent = LIST
        self.refused("AccessDenied", method, target, sent | {"x-amz-acl": ["public-read"]})
        self.refused("AccessDenied", method, target, {"host": ["x"]})
        self.refused("InvalidRequest", method, target, sent | {"x-amz-date": ["20130524T000000Z"] * 2})

    def test_scope_and_time(self):
        self.refused("AuthorizationHeaderMalformed", *LIST, account=ACCOUNT | {"region": "eu-central-1"})
        self.refused("InvalidAccessKeyId", *LIST, account=ACCOUNT | {"access_key": "AKIAOTHER"})
        self.refused("RequestTimeTooSkewed", *LIST, now=NOW + datetime.timedelta(minutes=11))
        self.refused("RequestTimeTooSkewed", *LIST, now=NOW - datetime.timedelta(minutes=21))
        self.refused("InvalidToken", *LIST, account=ACCOUNT | {"token": "t"})


if __name__ == "__main__":
    unittest.main()
