"""Some of each kind of attack on the package (hostile.py), by the date; ./dev chaos python has them for minutes."""

import subprocess
import sys
import unittest


class Hostile(unittest.TestCase):
    def test_some_of_each_kind(self):
        command = [sys.executable, "hostile.py", "--in-part", "--seconds", "0", "--seed", "today"]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        print(done.stdout)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)


if __name__ == "__main__":
    unittest.main()
