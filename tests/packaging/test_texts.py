"""Man pages and completions are those of the program's own --help."""

import os
import pathlib
import re
import shlex
import shutil
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
BINARY = os.environ["MESHGAUGE_BINARY"]


def run(*command, **how):
    return subprocess.run([str(word) for word in command], check=True, text=True, capture_output=True, timeout=60, **how).stdout


class Texts(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp())
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        run(ROOT / "packaging/cli_texts.py", BINARY, cls.folder, env={**os.environ, "SOURCE_DATE_EPOCH": "86400"})
        cls.pages = {file.stem: file.read_text() for file in (cls.folder / "man").iterdir()}

    def test_each_command_has_its_page(self):
        names = re.findall(r"^  (\w+)  ", run(BINARY, "--help").split("Subcommands:")[1], re.M)
        self.assertGreater(len(names), 5)
        wanted = {"meshgauge", *(f"meshgauge-{name}" for name in names)}
        self.assertEqual({name for name in self.pages if not name.startswith("meshgauge-keys-")}, wanted)
        for name, page in self.pages.items():
            self.assertIn('1 "1970-01-02" "meshgauge ', page.splitlines()[0], name)

    def test_each_flag_is_on_its_page(self):
        for name, page in self.pages.items():
            flags = set(re.findall(r"^  (-\S+)", run(BINARY, *name.split("-")[1:], "--help"), re.M))
            for flag in {part for found in flags for part in found.split("{")[0].split(",")}:
                self.assertIn(f"\\fB{flag.replace('-', chr(92) + '-')}\\fR", page, name)

    @unittest.skipUnless(shutil.which("groff"), "no groff")
    def test_pages_are_free_of_warnings(self):
        for file in (self.folder / "man").iterdir():
            done = subprocess.run(["groff", "-man", "-Tutf8", "-ww", "-z", file], capture_output=True, text=True, check=True)
            self.assertEqual(done.stderr, "", file.name)

    def complete(self, line):
        words = shlex.split(line) + [""] * line.endswith(" ")
        script = (f"source {self.folder}/bash/meshgauge; COMP_WORDS=({' '.join(map(shlex.quote, words))}); COMP_CWORD={len(words) - 1}; "
                  '_meshgauge; printf "%s\\n" "${COMPREPLY[@]}"')
        return run("bash", "-c", script, cwd=ROOT).split()

    def test_bash_completes(self):
        self.assertEqual(self.complete("meshgauge comp"), ["compare"])
        self.assertEqual(sorted(self.complete("meshgauge compare --tim")), ["--timeout", "--timeout-ms"])
        self.assertEqual(self.complete("meshgauge check --undecided "), ["fail", "warn"])
        self.assertEqual(self.complete("meshgauge keys n"), ["new"])
        self.assertIn("LICENSE", self.complete("meshgauge compare LIC"))

    @unittest.skipUnless(shutil.which("zsh"), "no zsh")
    def test_zsh_accepts_its_completion(self):
        run("zsh", "-n", self.folder / "zsh/_meshgauge")


if __name__ == "__main__":
    unittest.main()
