"""Which process brings the schema up, and what a process without the rights to do so reports."""

import random
import subprocess
import tempfile
import time
import unittest

from postgres import USER, Missing, Postgres
from processes import BINARY, ENVIRONMENT, Process, migrate, until
from schemas import AT_ONCE, MIGRATING, SHAPE, SLOWLY

SERVER = None
NEWEST = 0  # the version that a new database gets
VERBS = ("serve", "worker", "migrate")


def setUpModule():
    global SERVER, NEWEST
    try:
        SERVER = Postgres()
        SERVER.query("CREATE ROLE app LOGIN PASSWORD 'app'")
    except Missing as reason:
        raise unittest.SkipTest(str(reason)) from None
    migrate(SERVER.new_database("newest"))
    NEWEST = int(SERVER.query("SELECT version FROM meshgauge_schema", "newest"))


def tearDownModule():
    if SERVER is not None:
        SERVER.close()


def as_app(url):
    return url.replace("%s:%s@" % (USER, SERVER.password), "app:app@")


class Migrate(unittest.TestCase):
    def setUp(self):
        self.database = self._testMethodName
        self.url = SERVER.new_database(self.database)

    def query(self, sql):
        return SERVER.query(sql, self.database)

    def said(self, verb, url):
        """The message of a process that cannot start."""
        with tempfile.TemporaryDirectory() as folder:
            flags = () if verb == "migrate" else ("--port", "0", "--data-dir", folder + "/data")
            done = subprocess.run([BINARY, verb, *flags], env={**ENVIRONMENT, "MESHGAUGE_DATABASE": url}, capture_output=True,
                                  text=True, timeout=60)
        self.assertEqual(done.returncode, 3, done.stdout + done.stderr)
        self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
        self.assertNotIn(SERVER.password, done.stderr)
        return done.stderr

    def runs(self, name, verb, url):
        """The log of a process that is started and stopped."""
        process = Process(SERVER.scratch, name, verb, url)
        process.start(wait=False)
        self.addCleanup(lambda: process.process and process.kill())
        process.wait_ready()
        process.stop()
        return process.lines()

    def test_the_first_process_says_so_in_one_line(self):
        said = [[line["detail"] for line in self.runs("first-" + verb, verb, self.url) if line["event"] == "store"]
                for verb in ("worker", "serve")]
        self.assertEqual(said, [["the schema was brought from version 0 to %d" % NEWEST], []])

    def test_the_command_says_what_it_did(self):
        for said in ("was brought from version 0 to %d", "is of version %d already"):
            done = subprocess.run([BINARY, "migrate"], env={**ENVIRONMENT, "MESHGAUGE_DATABASE": self.url}, check=True,
                                  capture_output=True, text=True)
            self.assertEqual(done.stdout, "the schema " + said % NEWEST + "\n")

    def test_no_tickets_of_kerberos_unless_asked(self):
        """libpq refuses a wrong word in this variable, which it reads only where the program sets nothing."""
        for url, code in ((self.url, 0), (self.url + "?gssencmode=nonsense", 3)):
            done = subprocess.run([BINARY, "migrate"], env={**ENVIRONMENT, "PGGSSENCMODE": "nonsense", "MESHGAUGE_DATABASE": url},
                                  capture_output=True, text=True)
            self.assertEqual(done.returncode, code, done.stderr)

    def test_a_role_that_may_create_nothing(self):
        for verb in VERBS:
            said = self.said(verb, as_app(self.url))
            self.assertIn("the database's role 'app' may not bring the schema from version 0 to %d: " % NEWEST, said)
            self.assertIn("permission denied for schema public. Grant it CREATE on the schema 'public'", said)

    def test_a_role_that_may_not_change_what_another_one_owns(self):
        migrate(self.url)
        for verb in VERBS:
            said = self.said(verb, as_app(self.url))
            self.assertIn("may not use the tables of meshgauge: permission denied for table meshgauge_schema", said)
            self.assertIn("Grant it SELECT, INSERT, UPDATE and DELETE", said)
        self.query("GRANT SELECT, INSERT, UPDATE, DELETE ON ALL TABLES IN SCHEMA public TO app")
        self.runs("app", "serve", as_app(self.url))  # there is nothing to bring up
        self.query("UPDATE meshgauge_schema SET version = %d" % (NEWEST - 1))
        for verb in VERBS:
            said = self.said(verb, as_app(self.url))
            self.assertIn("may not bring the schema from version %d to %d: " % (NEWEST - 1, NEWEST), said)
            self.assertRegex(said, r"must be owner of (table|index) \w+\. Run `meshgauge migrate` as the role that owns the tables")

    def test_a_schema_that_is_newer_than_the_program(self):
        migrate(self.url)
        self.query("UPDATE meshgauge_schema SET version = 1000")
        for verb in VERBS:
            self.assertIn("was written by a later version of meshgauge (schema 1000; this one knows %d): run that version, or "
                          "restore an older backup" % NEWEST, self.said(verb, self.url))
        self.assertEqual(self.query("SELECT version FROM meshgauge_schema"), "1000")

    def test_a_database_that_dies_meanwhile(self):
        """Nothing is left of what was brought up until then, and the next process brings up all of it."""
        self.query(SLOWLY)
        migration = subprocess.Popen([BINARY, "migrate"], env={**ENVIRONMENT, "MESHGAUGE_DATABASE": self.url}, text=True,
                                     stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        until(lambda: int(self.query(MIGRATING)) > 0, what="the migration to begin")
        time.sleep(random.uniform(0, 1))
        SERVER.kill()
        said = migration.communicate(timeout=60)
        SERVER.start()
        self.assertEqual((migration.returncode, said[0], said[1].count("\n")), (3, "", 1), said)
        self.assertTrue(said[1].startswith("meshgauge: "), said)
        self.assertEqual(self.query("SELECT count(*) FROM pg_tables WHERE schemaname = 'public'"), "0")
        self.query(AT_ONCE)
        migrate(self.url)
        self.assertEqual(self.query(SHAPE), SERVER.query(SHAPE, "newest"))

    def test_no_schema_of_the_search_path_exists(self):
        said = self.said("serve", self.url + "?options=-csearch_path%3Dnowhere")
        self.assertIn("No schema of its search_path exists: create one", said)


if __name__ == "__main__":
    unittest.main()
