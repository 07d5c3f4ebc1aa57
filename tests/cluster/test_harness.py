"""The PostgreSQL of other tests: commits survive its death, and none of its processes outlives the test."""

import os
import signal
import subprocess
import sys
import time
import unittest
from pathlib import Path

from postgres import Missing, Postgres, find_binaries, psql
from scratch import inside


def there_is_none():
    try:
        find_binaries()
        return False
    except Missing:
        return True


@unittest.skipIf(there_is_none(), "no PostgreSQL: ./dev test brings it")
class OwnPostgres(unittest.TestCase):
    def test_stopped_paused_and_killed(self):
        with Postgres() as server:
            server.query("CREATE TABLE kept (i int)")
            server.query("INSERT INTO kept VALUES (1)")
            server.stop()
            with self.assertRaises(subprocess.CalledProcessError):
                server.query("SELECT 1")
            server.start()
            self.assertEqual(server.query("SELECT count(*) FROM kept"), "1")
            self.assertEqual(psql(server.binaries, server.socket_url(), "SHOW fsync"), "on")
            server.pause()
            with self.assertRaises(subprocess.TimeoutExpired):
                subprocess.run([server.binaries / "psql", server.url(), "-c", "SELECT 1"], timeout=0.5, capture_output=True)
            server.go_on()
            self.assertEqual(psql(server.binaries, server.new_database("other"), "SELECT current_database()"), "other")
            server.kill()
            self.assertEqual(inside(server.data), [])
        self.assertFalse(server.folder.exists())

    def test_gone_with_its_maker(self):
        maker = subprocess.Popen([sys.executable, "postgres.py", "--", "sleep", "60"], stdin=subprocess.DEVNULL)
        folder = self.wait_for(lambda: next((Path(os.readlink("/proc/%d/cwd" % one)) for one in self.servers(maker.pid)), None))
        maker.send_signal(signal.SIGKILL)
        maker.wait()
        self.wait_for(lambda: not folder.exists() and not inside(folder))

    def servers(self, parent):
        """The processes of postgres that it began."""
        children = Path("/proc/%d/task/%d/children" % (parent, parent))
        return [one for one in map(int, children.read_text().split()) if Path("/proc/%d/comm" % one).read_text() == "postgres\n"]

    def wait_for(self, condition):
        end = time.monotonic() + 30
        while not (found := condition()):
            self.assertLess(time.monotonic(), end)
            time.sleep(0.05)
        return found


if __name__ == "__main__":
    unittest.main()
