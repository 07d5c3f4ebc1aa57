"""Command lines that are refused: what is wrong, the arguments, and the files that they need beside good.obj and far.obj."""

import json

TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
FAR = "v 0 0 2\nv 1 0 2\nv 0 1 2\nf 1 2 3\n"
BOX = "v 0 0 0\nv 2 0 0\nv 0 2 0\nv 0 0 2\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"
FILES = {"good.obj": TRIANGLE, "lid.obj": TRIANGLE.replace("f ", "g Lid\nf "), "far.obj": FAR, "box.obj": BOX, "broken.obj": TRIANGLE.replace("0 1 0", "0 1 x"),
         "folder/part.obj": TRIANGLE}
HASH = "0" * 64


def manifest(gate, more=""):
    lines = "".join(f"    {line}\n" for line in gate)
    return f"version: 1\n{more}gates:\n  - name: part\n{lines}"


def compare_flags():
    pair = ["compare", "good.obj", "far.obj"]
    return [
        ("no subcommand", []),
        ("an unknown subcommand", ["measure"]),
        ("one file", ["compare", "good.obj"]),
        ("a file that does not exist", ["compare", "gone.obj", "far.obj"]),
        ("a folder", ["compare", "folder", "far.obj"]),
        ("standard input for both meshes", ["compare", "-", "-"]),
        ("an empty standard input", ["compare", "-", "far.obj"]),
        ("an unknown flag", [*pair, "--directon", "a_to_b"]),
        ("an unknown direction", [*pair, "--direction", "both"]),
        ("an unknown strategy", [*pair, "--strategy", "fast"]),
        ("points of another strategy", [*pair, "--points", "4"]),
        ("a number of points that there is not", [*pair, "--strategy", "n_point", "--points", "5"]),
        ("a tolerance below zero", [*pair, "--absolute", "-1"]),
        ("a word in place of a number", [*pair, "--relative", "little"]),
        ("a limit in an unknown unit", [*pair, "--max-distance", "5 parsec"]),
        ("an unknown unit", [*pair, "--unit", "pt"]),
        ("a limit in a unit, meshes of unknown unit", [*pair, "--max-distance", "1 mm", "--unit-a", "mm"]),
        ("a timeout of nothing", [*pair, "--timeout-ms", "0"]),
        ("no work", [*pair, "--work-items", "0"]),
        ("too many threads", [*pair, "--threads", "5000"]),
        ("too few samples", [*pair, "--statistics", "--samples", "5"]),
    ]


def check_flags():
    pair = ["check", "good.obj", "far.obj"]
    limit = ["--max-distance", "1"]
    return [
        ("two files without a limit", pair),
        ("one mesh", ["check", "good.obj"]),
        ("one file twice", ["check", "good.obj", "good.obj", *limit]),
        ("three meshes", ["check", "good.obj", "far.obj", "box.obj", *limit]),
        ("a folder", ["check", "folder"]),
        ("three files, one of them a report", [*pair, "--json", "report.json"]),
        ("a first manifest where one is", ["check", "--init"]),
        ("a first manifest of a folder that does not exist", ["check", "--init", "gone"]),
        ("a first manifest, and a report", ["check", "--init", "folder", "--json"]),
        ("two manifests", ["check", "gates.yaml", "more.yaml"]),
        ("a manifest that does not exist", ["check", "gone.yaml"]),
        ("a limit of a manifest by a flag", ["check", "gates.yaml", *limit]),
        ("a candidate that does not exist", ["check", "gone.obj", "far.obj", *limit]),
        ("a candidate that is a folder", ["check", "folder", "far.obj", *limit]),
        ("a candidate that cannot be read", ["check", "broken.obj", "far.obj", *limit]),
        ("a candidate without faces", ["check", "cut.obj", "far.obj", *limit, "--direction", "a_to_b"]),
        ("a limit with a comma", [*pair, "--max-distance", "0,5"]),
        ("a timeout in hours", [*pair, *limit, "--timeout", "1 h"]),
        ("an unknown direction", [*pair, *limit, "--direction", "both"]),
        ("an unknown unit", [*pair, *limit, "--unit", "pt"]),
        ("too many jobs", [*pair, *limit, "--jobs", "5000"]),
        ("a pattern that names no gate", [*pair, *limit, "--only", "pin"]),
        ("an empty pattern", [*pair, *limit, "--only", ""]),
        ("another rule for undecided gates", [*pair, *limit, "--undecided", "ignore"]),
        ("a report in a folder that does not exist", [*pair, *limit, "--junit", "gone/junit.xml"]),
        ("a report over an input", [*pair, *limit, "--junit", "far.obj"]),
        ("two reports in one file", [*pair, *limit, "--junit", "report", "--sarif", "report"]),
        ("two reports on standard output", [*pair, *limit, "--junit", "-", "--sarif", "-"]),
        ("a deviation map of another format", [*pair, *limit, "--deviation", "map.obj"]),
        ("`--json` with a blank before its file", ["check", "gates.yaml", "--json", "report.json"]),
        ("a service by an address that is none", [*pair, *limit, "--server", "example.com"]),
        ("a key by http", [*pair, *limit, "--server", "http://192.0.2.1", "--key-file", "key"]),
        ("a file of a key that does not exist", [*pair, *limit, "--server", "http://127.0.0.1", "--key-file", "gone"]),
        ("a key without a service", [*pair, *limit, "--key-file", "key"]),
        ("baselines to be updated, and a report", [*pair, "--update-baselines", "--json"]),
        ("a baseline to be updated by a broken mesh", ["check", "broken.obj", "folder/part.obj", "--update-baselines"]),
    ]


CHECK_FILES = {
    "gates.yaml": manifest(["candidate: good.obj", "baseline: far.obj", "max_distance: 1"]),
    "more.yaml": manifest(["candidate: good.obj", "baseline: far.obj", "max_distance: 1"]),
    "cut.obj": "v 0 0 0\nv 1 0 0\nv 0 1 0\n",
    "key": "mg_" + "k" * 43 + "\n",
}


def gates():
    """The report of a gate that did not pass."""
    def gate(candidate, *more, limit="1"):
        return manifest([f"candidate: {candidate}", "baseline: far.obj", f"max_distance: {limit}", *more])

    return [
        ("the candidate is too far away", gate("good.obj")),
        ("the baseline has what the candidate lacks", gate("far.obj").replace("baseline: far.obj", "baseline: box.obj")),
        ("the limit lies inside of the interval", manifest(["candidate: box.obj", "baseline: far.obj", "max_distance: 2.4",
                                                            "tolerance: {diagonal: 0.9}"])),
        ("the limit is the distance", manifest(["candidate: good.obj", "baseline: far.obj", "max_distance: 2", "tolerance: {absolute: 0}"])),
        ("too much of the area is too far away", manifest(["candidate: good.obj", "baseline: far.obj",
                                                           "max_share_beyond: {distance: 1, share: 1 %}"])),
        ("the distance of the area is that of a whole patch", manifest(["candidate: good.obj", "baseline: far.obj",
                                                                        "max_share_beyond: {distance: 2, share: 1 %}"])),
        ("a region is beyond its limit", manifest(["candidate: good.obj", "baseline: far.obj", "max_distance: 3",
                                                   "regions: [{name: bore, sphere: {centre: [0, 0, 0], radius: 9}, max_distance: 1}]"])),
        ("a region has no surface", manifest(["candidate: good.obj", "baseline: far.obj", "max_distance: 3",
                                              "regions: [{name: bore, sphere: {centre: [90, 0, 0], radius: 9}}]"])),
        ("a region is a group that the baseline does not have", manifest(["candidate: good.obj", "baseline: far.obj", "max_distance: 3",
                                                                    "regions: [{name: lid, group: Lid}]"])),
        ("a region is a group of the candidate", manifest(["candidate: lid.obj", "baseline: far.obj", "max_distance: 3",
                                                           "regions: [{name: lid, group: Lid}]"])),
        ("the candidate is too far outside of the baseline", manifest(["candidate: far.obj", "baseline: box.obj", "zone: [-9, 0.1]"])),
        ("the baseline of a zone is open", manifest(["candidate: good.obj", "baseline: far.obj", "zone: [-1, 1]"])),
        ("the candidate cannot be read", gate("broken.obj")),
        ("the candidate has no faces, and is not declared a cloud", gate("cut.obj", "direction: candidate_to_baseline")),
        ("the limit is in a unit, the meshes in none, and one is declared", gate("good.obj", "units: {candidate: mm}", limit="1 mm")),
    ]


def service_flags():
    return [
        ("a port that there is not", ["--port", "99999"]),
        ("a word in place of a number", ["--queue", "many"]),
        ("a certificate without its key", ["--tls-certificate", "gone.pem"]),
        ("a certificate that does not exist", ["--tls-certificate", "gone.pem", "--tls-key", "gone.pem"]),
        ("a public address without keys", ["--host", "0.0.0.0"]),
        ("an address of another machine", ["--host", "192.0.2.1", "--port", "0", "--public-without-keys"]),
        ("no thread for requests", ["--io-threads", "0"]),
        ("no TLS handshakes", ["--max-handshakes-per-second-per-peer", "0"]),
        ("too many workers", ["--workers", "100000"]),
        ("a largest timeout that is too large", ["--max-timeout-ms", "999999"]),
        ("a default timeout above the largest", ["--default-timeout-ms", "60000", "--max-timeout-ms", "50000"]),
        ("a grace of a day", ["--grace-ms", "86400000"]),
        ("a part larger than a request", ["--max-part-bytes", "2000", "--max-request-bytes", "1000"]),
        ("readers without memory", ["--parser-memory-bytes", "1"]),
        ("batches without pairs", ["--max-batch-pairs", "0"]),
        ("blobs without a database", ["--blobs", "s3://bucket"]),
        ("a database that is no connection string", ["--database", "jobs.sqlite"]),
        ("blobs of another kind", ["--database", "postgresql://u@127.0.0.1/d", "--blobs", "gs://bucket"]),
        ("an endpoint without a scheme", ["--database", "postgresql://u@127.0.0.1/d", "--blobs", "s3://bucket", "--s3-endpoint", "127.0.0.1"]),
        ("a lease shorter than two heartbeats", ["--lease-ms", "1000", "--heartbeat-ms", "900"]),
        ("another word for the log", ["--log-requests", "some"]),
        ("origins of pages that are none", ["--cors-origins", "example.com"]),
        ("hosts that are none", ["--allowed-hosts", "http://gauge.example"]),
        ("less memory than one comparison takes", ["--max-memory-bytes", "1000000"]),
        ("a file of settings that does not exist", ["--config", "gone.toml"]),
        ("settings: a line without `=`", ["--config", "line.toml"]),
        ("settings: an unknown name", ["--config", "name.toml"]),
        ("settings: a name twice", ["--config", "twice.toml"]),
        ("settings: a number in quotes", ["--config", "number.toml"]),
        ("settings: a text without quotes", ["--config", "text.toml"]),
        ("settings: a switch that is a number", ["--config", "switch.toml"]),
        ("a file of keys that does not exist", ["--keys-file", "gone.json"]),
        ("keys: not JSON", ["--keys-file", "keys_json.json"]),
        ("keys: no array", ["--keys-file", "keys_array.json"]),
        ("keys: an unknown field", ["--keys-file", "keys_field.json"]),
        ("keys: a field twice", ["--keys-file", "keys_twice.json"]),
        ("keys: no digest", ["--keys-file", "keys_digest.json"]),
        ("keys: a token where its digest belongs", ["--keys-file", "keys_token.json"]),
        ("keys: an unknown scope", ["--keys-file", "keys_scope.json"]),
        ("keys: a rate of nothing", ["--keys-file", "keys_rate.json"]),
        ("keys: a day without a time", ["--keys-file", "keys_time.json"]),
        ("keys: two keys of one id", ["--keys-file", "keys_ids.json"]),
    ]


def keys(*entries):
    return json.dumps({"keys": list(entries)})


ENTRY = {"id": "ci", "sha256": HASH}
SERVICE_FILES = {
    "line.toml": "port 9090\n", "name.toml": "prot = 9090\n", "twice.toml": "port = 9090\nport = 9091\n", "number.toml": 'port = "9090"\n',
    "text.toml": "host = localhost\n", "switch.toml": "public_without_keys = 1\n",
    "keys_json.json": '{"keys": [\n', "keys_array.json": '{"keys": {}}', "keys_field.json": keys({**ENTRY, "rate": 5}),
    "keys_twice.json": '{"keys": [{"id": "ci", "id": "ci"}]}', "keys_digest.json": keys({"id": "ci"}),
    "keys_token.json": keys({"id": "ci", "sha256": "mg_" + "k" * 43}), "keys_scope.json": keys({**ENTRY, "scopes": ["all"]}),
    "keys_rate.json": keys({**ENTRY, "requests_per_minute": 0}), "keys_time.json": keys({**ENTRY, "expires": "2027-01-31"}),
    "keys_ids.json": keys(ENTRY, {"id": "ci", "sha256": "1" * 64}),
}


def other_verbs():
    return [
        ("a migration without a database", ["migrate"]),
        ("a worker without a database", ["worker"]),
        ("a key for an id that is none", ["keys", "new", "two words"]),
        ("a key of an unknown scope", ["keys", "new", "ci", "--scope", "all"]),
        ("the digest of a token that is too short", ["keys", "hash"]),
        ("the health of a service that is not there", ["health", "--host", "127.0.0.1", "--port", "1"]),
        ("a root that does not exist", ["mcp", "--root", "gone"]),
    ]
