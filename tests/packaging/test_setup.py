"""`./dev setup` beside another apt: it waits for the locks, and says so. apt and dpkg are stand-ins."""

import pathlib
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
# Fails with what `errors` holds as often as `fails` has lines, then succeeds; notes its arguments.
APT = """#!/bin/sh
echo "$*" >>"$(dirname "$0")/calls"
if [ -s "$(dirname "$0")/fails" ]; then
  sed -i 1d "$(dirname "$0")/fails"
  cat "$(dirname "$0")/errors" >&2
  exit 100
fi
"""
LOCKS = (
    "E: Could not get lock /var/lib/dpkg/lock-frontend. It is held by process 7 (unattended-upgr)",
    "E: Could not get lock /var/lib/apt/lists/lock. It is held by process 7 (apt-get)",
    "E: Could not get lock /var/cache/apt/archives/lock. It is held by process 7 (apt-get)",
    "dpkg: error: dpkg frontend lock was locked by another process with pid 7",
)


class Setup(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        for name, text in (("apt-get", APT), ("dpkg-query", "#!/bin/sh\nexit 1\n"), ("sudo", '#!/bin/sh\nexec "$@"\n'), ("sleep", "#!/bin/sh\n")):
            (self.folder / name).write_text(text)
            (self.folder / name).chmod(0o755)

    def setup_verb(self, errors, times):
        (self.folder / "calls").write_text("")
        (self.folder / "errors").write_text(errors + "\n")
        (self.folder / "fails").write_text("x\n" * times)
        done = subprocess.run([ROOT / "dev", "setup", "run"], env={"PATH": f"{self.folder}:/usr/bin:/bin"}, text=True, capture_output=True,
                              check=False, timeout=60)
        return done, (self.folder / "calls").read_text().splitlines()

    def test_it_waits_for_a_lock_and_says_so_once(self):
        for lock in LOCKS:
            done, calls = self.setup_verb(lock, 3)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual(done.stderr.count("another apt runs, waiting for it, 600 s at most: " + lock), 1, done.stderr)
            self.assertEqual(["update" in call for call in calls], [True] * 4 + [False])
            self.assertTrue(all("DPkg::Lock::Timeout=600" in call for call in calls[1:4]), calls)
            self.assertIn(" install ", calls[-1])

    def test_another_failure_ends_it(self):
        done, calls = self.setup_verb("E: Unable to locate package curl", 1)
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("Unable to locate package curl", done.stderr)
        self.assertNotIn("waiting", done.stderr)
        self.assertEqual(len(calls), 1)


if __name__ == "__main__":
    unittest.main()
