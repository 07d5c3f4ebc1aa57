"""AWS Signature Version 4 as a strict server checks it: from the bytes of the request line and the headers alone.

Written from AWS's description, and shares nothing with what signs: neither code nor a library of HTTP or of S3.
"""
import datetime
import hashlib
import hmac
import re

ALGORITHM = "AWS4-HMAC-SHA256"
MOST_SKEW = datetime.timedelta(minutes=15)
UNRESERVED = frozenset(b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-._~")


class Refused(Exception):
    def __init__(self, status, code, message):
        super().__init__(message)
        self.status, self.code, self.message = status, code, message


def decoded(text):
    """Decodes %XX; a plus stays a plus. Any other % is refused, since a proxy might read it differently."""
    if re.search(r"%(?![0-9A-Fa-f]{2})", text):
        raise Refused(400, "InvalidURI", f"'{text}' is not encoded")
    return re.sub(rb"%([0-9A-Fa-f]{2})", lambda m: bytes([int(m[1], 16)]), text.encode("latin-1"))


def encoded(octets, keep=b""):
    return "".join(chr(b) if b in UNRESERVED or b in keep else f"%{b:02X}" for b in octets)


def canonical_query(query):
    pairs = []
    for pair in query.split("&") if query else []:
        name, _, value = pair.partition("=")
        pairs.append((encoded(decoded(name)), encoded(decoded(value))))
    return "&".join(f"{name}={value}" for name, value in sorted(pairs))


def parse_authorization(value):
    match = re.fullmatch(rf"{ALGORITHM} Credential=([^,]+), ?SignedHeaders=([a-z0-9;-]+), ?Signature=([0-9a-f]{{64}})", value)
    if not match:
        raise Refused(400, "AuthorizationHeaderMalformed", "the header Authorization is not of version 4")
    scope = match[1].split("/")
    if len(scope) != 5:
        raise Refused(400, "AuthorizationHeaderMalformed", "the credential has no scope of four parts")
    return scope, match[2].split(";"), match[3]


def check_scope(scope, account, stamp):
    key, day, region, service, end = scope
    if key != account["access_key"]:
        raise Refused(403, "InvalidAccessKeyId", f"there is no key {key}")
    if region != account["region"]:
        raise Refused(400, "AuthorizationHeaderMalformed", f"the region '{region}' is wrong; expecting '{account['region']}'")
    if (service, end) != ("s3", "aws4_request") or day != stamp[:8]:
        raise Refused(400, "AuthorizationHeaderMalformed", "the credential's scope is not this service on this day")


def check_time(stamp, now):
    try:
        sent = datetime.datetime.strptime(stamp, "%Y%m%dT%H%M%SZ").replace(tzinfo=datetime.timezone.utc)
    except ValueError as error:
        raise Refused(403, "AccessDenied", "x-amz-date is no date") from error
    if abs(now - sent) > MOST_SKEW:
        raise Refused(403, "RequestTimeTooSkewed", "the difference between the request time and the current time is too large")


def check_names(signed, headers):
    """Checks that every header that could change the request is signed, in order, once."""
    if signed != sorted(set(signed)):
        raise Refused(400, "AuthorizationHeaderMalformed", "the signed headers are not in order")
    needed = {name for name in headers if name.startswith("x-amz-") or name in ("host", "content-type", "range")}
    missing = sorted((needed | {"host", "x-amz-date", "x-amz-content-sha256"}) - set(signed))
    if missing:
        raise Refused(403, "AccessDenied", f"there were headers present in the request which were not signed: {missing}")


def check(method, target, headers, account, now):
    """Raises Refused unless the request was signed by the account. `headers`: a list of values for each name in lower
    case. Returns the SHA-256 that the body must have."""
    for name, values in headers.items():
        if len(values) != 1:
            raise Refused(400, "InvalidRequest", f"the header {name} is there twice")
    if "authorization" not in headers:
        raise Refused(403, "AccessDenied", "the request is not signed")
    one = {name: values[0] for name, values in headers.items()}
    scope, signed, signature = parse_authorization(one["authorization"])
    stamp = one.get("x-amz-date", "")
    check_time(stamp, now)
    check_scope(scope, account, stamp)
    check_names(signed, headers)
    if one.get("x-amz-security-token", "") != account["token"]:
        raise Refused(403, "InvalidToken", "the token is not the one of the key")

    path, _, query = target.partition("?")
    canonical_path = encoded(decoded(path), b"/")
    if path != canonical_path or query != canonical_query(query):
        raise Refused(403, "SignatureDoesNotMatch", f"'{target}' is not sent as it is signed: {canonical_path}?{canonical_query(query)}")
    lines = [f"{name}:{re.sub(' +', ' ', one.get(name, '').strip())}\n" for name in signed]
    canonical = "\n".join([method, canonical_path, canonical_query(query), "".join(lines), ";".join(signed), one["x-amz-content-sha256"]])
    to_sign = "\n".join([ALGORITHM, stamp, "/".join(scope[1:]), hashlib.sha256(canonical.encode("latin-1")).hexdigest()])
    key = ("AWS4" + account["secret_key"]).encode()
    for part in scope[1:]:
        key = hmac.new(key, part.encode(), hashlib.sha256).digest()
    if not hmac.compare_digest(hmac.new(key, to_sign.encode("latin-1"), hashlib.sha256).hexdigest(), signature):
        raise Refused(403, "SignatureDoesNotMatch", "the signature is not that of the request:\n" + canonical)
    payload = one["x-amz-content-sha256"]
    if not re.fullmatch("[0-9a-f]{64}", payload):
        raise Refused(400, "InvalidArgument", "x-amz-content-sha256 is no digest: this server wants bodies signed")
    return payload
