#!/usr/bin/env python3
"""What ./dev refuses, before it installs or builds anything: commands and names of tests that there are not, and a copied tree,
whose build folder names the files of the other one."""
import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

SOURCE = pathlib.Path(__file__).resolve().parents[2]


class Dev(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        (self.folder / "tree/tools").mkdir(parents=True)
        for file in ("dev", "tools/packages.txt"):
            shutil.copy(SOURCE / file, self.folder / "tree" / file)
        (self.folder / "tree/tests").symlink_to(SOURCE / "tests")
        # Stand-ins in PATH say that they were called.
        (self.folder / "bin").mkdir()
        for name in ("apt-get", "cmake", "ctest", "npm", "sudo"):
            self.stand_in(name, f'echo {name} >>"{self.folder}/called"')
        self.stand_in("dpkg-query", "echo installed")

    def stand_in(self, name, text):
        path = self.folder / "bin" / name
        path.write_text(f"#!/bin/sh\n{text}\n")
        path.chmod(0o755)

    def dev(self, *arguments):
        path = f"{self.folder}/bin:{os.environ['PATH']}"
        return subprocess.run(["bash", "dev", *arguments], cwd=self.folder / "tree", capture_output=True, text=True,
                              env={**os.environ, "PATH": path})

    def called(self):
        file = self.folder / "called"
        return file.read_text().split() if file.exists() else []

    def refuses(self, *arguments):
        done = self.dev(*arguments)
        self.assertEqual((done.returncode, self.called()), (2, []), done)
        return done.stderr

    def test_names_that_no_test_has_are_refused(self):
        for name in ("chek", "fuzz", "Hierarchi", "Hierarchy.NoSuchTest"):
            self.assertIn(f"is called '{name}'", self.refuses("test", "base", name))

    def test_names_of_tests_are_built_and_run(self):
        for name, target in (("check", "test_check"), ("python", "test_python"), ("motions", "all"), ("Hierarchy", "test_bvh")):
            done = self.dev("test", name)
            self.assertEqual(done.returncode, 0, done)
            self.assertIn(f"$ cmake --build --preset release --target {target}\n", done.stdout)
            self.assertEqual(self.called()[-2:], ["cmake", "ctest"])

    def test_unknown_commands_are_refused(self):
        self.assertIn("no command 'tset'", self.refuses("tset"))
        self.assertIn("takes no arguments", self.refuses("demo", "twice"))

    def test_every_listed_command_is_there(self):
        listed = set(re.findall(r"^  ([a-z]+)", self.dev("help").stdout, re.MULTILINE))
        self.assertEqual(listed, {"demo", "build", "test", "web", "windows", "install"})
        for command in listed:
            self.assertNotIn("there is no command", self.dev(command).stderr)

    def test_a_copied_build_folder_is_refused(self):
        (self.folder / "tree/build").mkdir()
        (self.folder / "tree/build/CMakeCache.txt").write_text("CMAKE_HOME_DIRECTORY:INTERNAL=/elsewhere/foldproof\n")
        self.assertEqual(self.refuses("build"), "./dev: build/ was made in /elsewhere/foldproof, of which this seems to be a "
                         "copy; remove it (rm -r build)\n")


if __name__ == "__main__":
    unittest.main()
