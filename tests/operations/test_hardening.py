"""How the built programs are hardened (cmake/hardening.cmake), read off their ELF files."""

import os
import platform
import subprocess
import unittest

BINARY = os.environ["MESHGAUGE_BINARY"]
READER = os.environ.get("MESHGAUGE_READER")
PROGRAMS = [BINARY] + ([READER] if READER else [])
LEAST_FUNCTIONS = 1000  # a program that is compiled with it has many more


def readelf(program, *flags):
    return subprocess.run(["readelf", "-W", *flags, program], capture_output=True, text=True, check=True,
                          env={**os.environ, "LC_ALL": "C"}).stdout


def segments(program):
    """{type: flags} of the program headers, the flags without blanks; LOAD has those of all."""
    found = {}
    for line in readelf(program, "-l").splitlines():
        fields = line.split()
        if len(fields) > 6 and fields[1].startswith("0x"):
            flags = "".join(field for field in fields[6:-1] if field in ("R", "W", "E", "RW", "RE", "RWE"))
            found.setdefault(fields[0], []).append(flags)
    return found


class Hardening(unittest.TestCase):
    def test_the_program_is_loaded_anywhere(self):
        for program in PROGRAMS:
            self.assertRegex(readelf(program, "-h"), r"Type:\s+DYN")

    def test_what_the_linker_fills_in_is_read_only_from_the_start(self):
        for program in PROGRAMS:
            self.assertIn("GNU_RELRO", segments(program))
            self.assertRegex(readelf(program, "-d"), r"\(FLAGS_1\)\s+Flags:.* ?NOW|\(BIND_NOW\)|\(FLAGS\)\s+.*BIND_NOW")

    def test_nothing_is_writable_and_executable(self):
        for program in PROGRAMS:
            self.assertEqual(segments(program)["GNU_STACK"], ["RW"])
            self.assertNotIn("RWE", segments(program)["LOAD"])

    def test_stack_and_library_calls_are_checked(self):
        imported = [line.split()[7].split("@")[0] for line in readelf(BINARY, "--dyn-syms").splitlines() if len(line.split()) > 7]
        self.assertIn("__stack_chk_fail", imported)
        self.assertGreater(len([name for name in imported if name.startswith("__") and name.endswith("_chk")]), 1)
        self.assertTrue(any("__glibcxx_assert_fail" in name for name in imported))

    @unittest.skipUnless(platform.machine() == "x86_64", "endbr64 is of x86-64")
    def test_indirect_calls_land_on_marks(self):
        for program in PROGRAMS:
            with open(program, "rb") as file:
                self.assertGreater(file.read().count(b"\xf3\x0f\x1e\xfa"), LEAST_FUNCTIONS)


if __name__ == "__main__":
    unittest.main()
