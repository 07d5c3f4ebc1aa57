"""Stores that earlier versions left behind, each brought up and served by the present program: nothing that clients were
promised is lost."""

import json
import re
import sqlite3
import subprocess
import tempfile
import unittest
from pathlib import Path

from documents import lost
from fixtures import Fixture, archives
from postgres import Missing, Postgres
from processes import BINARY, ENVIRONMENT, QUICK, Fleet, migrate
from rig import holds
from schemas import SHAPE
from scratch import Scratch
from story import ENDED, JSON, Client
from victim import Victim

class Owner:
    """What one owner was promised, asked for again."""

    def __init__(self, test, client, promised, shift_ms):
        self.test, self.client, self.promised, self.shift_ms = test, client, promised, shift_ms

    def get(self, path):
        return self.client.ask("GET", path)

    def same(self, before, now):
        self.test.assertEqual(list(lost(before, now, self.shift_ms)), [])

    def check(self):
        self.what_ended_is_as_it_was()
        self.a_key_names_the_same()
        self.what_had_not_ended_ends()
        self.meshes_are_there()
        if self.client.head:  # it has a key: only what belongs to a key can be listed
            self.lists_have_all()
        self.deletes_work()

    def what_ended_is_as_it_was(self):
        for one in self.promised["ended"]:
            path = "/v1/comparisons/" + one["id"]
            self.same(one["document"], self.get(path).json())
            if one["document"]["result"]:
                self.client.ask("GET", path + "/deviation.ply", expected=(200,) if self.has_meshes(one) else (200, 410))
        for batch in self.ended_batches():
            self.same(batch["document"], self.get("/v1/batches/" + batch["id"]).json())
            self.same(batch["results"], self.results(batch))

    def has_meshes(self, comparison):
        """Whether its meshes are stored. A file that came with the request goes some time after the end."""
        stored = {one["document"]["id"] for one in self.promised["meshes"]}
        return {mesh["sha256"] for mesh in comparison["document"]["result"]["meshes"].values()} <= stored

    def ended_batches(self):
        return [batch for batch in self.promised["batches"] if batch["document"]["state"] in ENDED]

    def results(self, batch):
        return [json.loads(line) for line in self.get("/v1/batches/%s/results.jsonl" % batch["id"]).body.splitlines()]

    def a_key_names_the_same(self):
        for one in self.promised["keys"]:
            headers = {**one["headers"], "Idempotency-Key": one["key"]}
            answer = self.client.ask("POST", one["path"], one["body"].encode(), headers, (200, 202))
            self.test.assertEqual(answer.headers["location"], "%s/%s" % (one["path"], one["id"]))

    def what_had_not_ended_ends(self):
        for one in self.promised["unended"]:
            document = self.end_of("/v1/comparisons/" + one["id"])
            self.test.assertEqual(document["state"], "done", document)
            self.test.assertTrue(holds(document, one["distance"]), document)
            if document["result"]["gate"]:
                verdict = "pass" if one["distance"] <= document["result"]["gate"]["max_distance"] else "fail"
                self.test.assertEqual(document["result"]["verdict"], verdict)
        for batch in self.promised["batches"]:
            document = self.end_of("/v1/batches/" + batch["id"])
            self.test.assertEqual(document["counts"]["done"], len(batch["distances"]) - batch["distances"].count(None), document)
            results = {one["position"]: one for one in self.results(batch)}
            for position, distance in enumerate(batch["distances"]):
                self.test.assertTrue(distance is None or holds(results[position], distance), results)

    def end_of(self, path):
        """The document, once it has ended."""
        self.client.wait(path, *ENDED)
        return self.get(path).json()

    def meshes_are_there(self):
        first = self.promised["meshes"][0]
        for one in self.promised["meshes"]:
            before, now = one["document"], self.get("/v1/meshes/" + one["document"]["id"]).json()
            self.same({name: before[name] for name in before if name not in ("expires", "last_used")}, now)  # both moved on by its use
            pair = json.dumps({"a": first["document"]["id"], "b": before["id"], "options": {}}).encode()
            answer = self.client.ask("POST", "/v1/comparisons", pair, JSON)
            self.test.assertTrue(holds({"result": answer.json()}, one["height"] - first["height"]), answer.body)
            self.test.assertEqual(answer.json()["meshes"]["b"]["sha256"], before["id"])

    def lists_have_all(self):
        for kind, expected in (("comparisons", [*self.promised["ended"], *self.promised["unended"]]), ("batches", self.promised["batches"]),
                               ("meshes", [one["document"] for one in self.promised["meshes"]])):
            missing = {one["id"] for one in expected} - {entry["id"] for entry in self.pages(kind)}
            self.test.assertEqual(missing, set(), kind)

    def pages(self, kind):
        query = "?limit=3"
        while query:
            document = self.get("/v1/%s%s" % (kind, query)).json()
            yield from document[kind]
            query = document["next"] and "?limit=3&after=" + document["next"]

    def deletes_work(self):
        for kind, ones in (("batches", self.promised["batches"]), ("comparisons", [*self.promised["ended"], *self.promised["unended"]]),
                           ("meshes", [one["document"] for one in self.promised["meshes"]])):
            for one in ones:
                path = "/v1/%s/%s" % (kind, one["id"])
                self.client.ask("DELETE", path, expected=(204,))
                self.client.ask("GET", path, expected=(404,))


def without_comments(sql):
    return " ".join(re.sub("--.*", "", sql).split())


def shape_of(database):
    with sqlite3.connect(database) as connection:
        rows = connection.execute("SELECT type, name, sql FROM sqlite_master WHERE sql IS NOT NULL ORDER BY type, name").fetchall()
        version = connection.execute("PRAGMA user_version").fetchone()
    connection.close()
    return [version, *((kind, name, without_comments(sql)) for kind, name, sql in rows)]


def keys_of(fixture):
    """The path of its file of keys."""
    path = fixture.folder / "keys.json"
    path.write_text(json.dumps(fixture.promised["keys"]))
    return str(path)


class Embedded(unittest.TestCase):
    def serve(self, folder, *flags):
        server = Victim("--data-dir", str(folder), "--workers", "1", *flags)
        self.addCleanup(server.process.kill)
        return server

    def test_fixtures(self):
        with tempfile.TemporaryDirectory() as folder:
            self.serve(folder).stop()
            new = shape_of(Path(folder) / "jobs.sqlite")
        found = archives("embedded")
        self.assertTrue(found)
        # All of them start first, and run what had not ended meanwhile.
        for path, (fixture, server) in [(path, self.begin(path)) for path in found]:
            with self.subTest(path.name):
                self.check(server, fixture, fixture.promised["token"], "of_key")
                self.check(self.serve(fixture.data), fixture, None, "without")
                self.assertEqual(shape_of(fixture.data / "jobs.sqlite"), new)

    def begin(self, path):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        fixture = Fixture(path, folder.name)
        fixture.shift_data_folder()
        return fixture, self.serve(fixture.data, "--keys-file", keys_of(fixture))

    def check(self, server, fixture, token, owner):
        Owner(self, Client(server.port, token), fixture.promised[owner], fixture.shift_ms).check()
        server.stop()

    def test_a_schema_that_is_newer_than_the_program(self):
        """PostgreSQL's is in tests/cluster/test_migrate.py."""
        with tempfile.TemporaryDirectory() as folder:
            self.serve(folder).stop()
            file = Path(folder) / "jobs.sqlite"
            with sqlite3.connect(file) as database:
                newest = database.execute("PRAGMA user_version").fetchone()[0]
                database.execute("PRAGMA user_version = %d" % (newest + 1))
            database.close()
            before = shape_of(file)
            done = subprocess.run([BINARY, "serve", "--port", "0", "--data-dir", folder], env=ENVIRONMENT, capture_output=True, text=True,
                                  timeout=60)
            self.assertEqual(done.returncode, 3, done.stderr)
            self.assertIn("was written by a later version of meshgauge (schema %d; this one knows %d): run that version, or restore an "
                          "older backup" % (newest + 1, newest), done.stderr)
            self.assertEqual(shape_of(file), before)


class PostgreSql(unittest.TestCase):
    def setUp(self):
        try:
            self.postgres = Postgres()
        except Missing as reason:
            self.skipTest(str(reason))
        self.addCleanup(self.postgres.close)

    def test_fixtures(self):
        migrate(self.postgres.new_database("new"))
        new = self.postgres.query(SHAPE, "new")
        found = archives("postgresql")
        self.assertTrue(found)
        # All of them start first: none takes jobs from a worker that is gone before it has run for 15 s.
        for path, (fixture, database, fleet) in [(path, self.begin(path)) for path in found]:
            with self.subTest(path.name):
                self.check(fixture, fleet)
                self.assertEqual(self.postgres.query(SHAPE, database), new)

    def begin(self, path):
        """Starts processes on a fixture, without waiting until they are ready."""
        scratch = Scratch()
        self.addCleanup(scratch.close)
        fixture = Fixture(path, scratch.path)
        database = re.sub(r"\W", "_", "of_" + fixture.name)
        url = self.postgres.new_database(database)
        fixture.load(self.postgres.binaries, url)
        columns = self.postgres.query("SELECT table_name, column_name FROM information_schema.columns", database)
        self.postgres.query(";".join(fixture.shifts([tuple(line.split("|")) for line in columns.splitlines()])), database)
        fleet = Fleet(scratch, url, QUICK)
        self.addCleanup(fleet.kill_all)
        fleet.add_front_end("--keys-file", keys_of(fixture))
        fleet.add_front_end()
        fleet.add_worker("--workers", "1")
        return fixture, database, fleet

    def check(self, fixture, fleet):
        fleet.wait()
        for front_end, token, owner in zip(fleet.front_ends, (fixture.promised["token"], None), ("of_key", "without")):
            Owner(self, Client(front_end.port, token), fixture.promised[owner], fixture.shift_ms).check()
        for one in fleet.all():
            one.stop()


if __name__ == "__main__":
    unittest.main()
