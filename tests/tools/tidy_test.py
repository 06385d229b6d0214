#!/usr/bin/env python3
"""Shows that tools/tidy checks a source again when anything changes that the answer depends on, and only then."""
import json
import pathlib
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
# Finds whatever has the word "finding", and notes each source that it reads.
TIDY = """#!/bin/sh
[ "$1" = --version ] && { echo version 14; exit; }
for source; do :; done
echo "$source" >> read.txt
echo "1 warning generated."
! grep -n finding "$source"
"""


class Tidy(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name).resolve()
        self.write("tidy", TIDY)
        (self.root / "tidy").chmod(0o755)
        self.write("header.h", "#pragma once\n#define VALUE 1\n")
        self.write("src/.clang-tidy", "Checks: a")
        for name in ("a", "b"):
            self.write(f"src/{name}.cpp", '#include "../header.h"\n')
        self.compile_with("-O1")

    def write(self, name, text):
        (self.root / name).parent.mkdir(exist_ok=True)
        (self.root / name).write_text(text)

    def compile_with(self, flags):
        files = [self.root / f"src/{name}.cpp" for name in ("a", "b")]
        self.write("build/compile_commands.json", json.dumps([
            {"directory": str(self.root / "build"), "file": str(file), "command": f"c++ {flags} -o {file.stem}.o -c {file}"}
            for file in files]))

    def run_tidy(self, *sources):
        """The exit code, what was printed, and which sources were read."""
        (self.root / "read.txt").write_text("")
        done = subprocess.run([ROOT / "tools/tidy", "./tidy", "build", "2", *sources], cwd=self.root, text=True,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
        return done.returncode, done.stdout, sorted((self.root / "read.txt").read_text().split())

    def read_again(self):
        code, text, read = self.run_tidy("src/a.cpp", "src/b.cpp")
        self.assertEqual((code, text), (0, ""))
        return read

    def test_reads_again_what_changed(self):
        both = ["src/a.cpp", "src/b.cpp"]
        self.assertEqual(self.read_again(), both)
        self.assertEqual(self.read_again(), [])
        self.write("header.h", "#pragma once\n#define VALUE 1\n// a comment\nextern int a;\n")
        self.assertEqual(self.read_again(), both)
        self.write("header.h", "#pragma once\n#define VALUE 1\n// another\n\n// comment\nextern int a;\n")
        self.assertEqual(self.read_again(), [])
        self.write("header.h", "#pragma once\n#define VALUE 1\n// NOLINTNEXTLINE\nextern int a;\n")
        self.assertEqual(self.read_again(), both)
        self.write("src/b.cpp", '#include "../header.h"\nint b;  // beside code\n')
        self.assertEqual(self.read_again(), ["src/b.cpp"])
        self.write("header.h", "#pragma once\n#define VALUE 2\n")
        self.assertEqual(self.read_again(), both)
        self.write("src/.clang-tidy", "Checks: b")
        self.assertEqual(self.read_again(), both)
        self.compile_with("-O2")
        self.assertEqual(self.read_again(), both)
        self.assertEqual(self.read_again(), [])

    def test_tells_findings_each_time(self):
        self.write("src/b.cpp", "int finding;\n")
        for _ in range(2):
            code, text, read = self.run_tidy("src/a.cpp", "src/b.cpp")
            self.assertEqual((code, text), (1, "1:int finding;\n"))
            self.assertIn("src/b.cpp", read)

    def test_reads_what_does_not_compile(self):
        self.write("src/a.cpp", '#include "nothing.h"\n')
        for _ in range(2):
            self.assertEqual(self.run_tidy("src/a.cpp"), (0, "", ["src/a.cpp"]))

    def test_names_a_source_that_is_not_compiled(self):
        code, text, _ = self.run_tidy("src/c.cpp")
        self.assertEqual(code, 1)
        self.assertIn("src/c.cpp is not in build/compile_commands.json", text)


if __name__ == "__main__":
    unittest.main()
