#!/usr/bin/env python3
"""Shows that ./dev knows the commands that it lists, and what it says in a copied tree, whose build folder names the files of the
other one."""
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

SOURCE = pathlib.Path(__file__).resolve().parents[2]


class Dev(unittest.TestCase):
    def test_every_listed_command_is_there(self):
        script = (SOURCE / "dev").read_text()
        listed = set(re.findall(r"^  ([a-z]\w*)", subprocess.run([SOURCE / "dev", "help"], capture_output=True, text=True).stdout, re.MULTILINE))
        self.assertIn("test", listed)
        known = re.findall(r"[a-z]\w*", " ".join(re.findall(r"^  ([a-z0-9 |-]+)\)", script.split("\ncase $command in\n")[1], re.MULTILINE)))
        self.assertEqual(listed - set(known), set())

    def test_a_copied_build_folder_is_refused(self):
        with tempfile.TemporaryDirectory() as name:
            copy = pathlib.Path(name)
            (copy / "tools").mkdir()
            (copy / "build").mkdir()
            for file in ("dev", "tools/packages.txt"):
                shutil.copy(SOURCE / file, copy / file)
            (copy / "build/CMakeCache.txt").write_text("CMAKE_HOME_DIRECTORY:INTERNAL=/elsewhere/foldproof\n")
            process = subprocess.run(["bash", "dev", "search", "1"], cwd=copy, capture_output=True, text=True)
            self.assertEqual(process.returncode, 2)
            self.assertEqual(process.stderr.strip(), "./dev: build/ was made in /elsewhere/foldproof, of which this seems "
                             "to be a copy; remove it (rm -r build) and run this again")


if __name__ == "__main__":
    unittest.main()
