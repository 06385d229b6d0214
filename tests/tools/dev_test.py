#!/usr/bin/env python3
"""Shows that ./dev says what to do in a copied tree, whose build folder names the files of the other one."""
import pathlib
import shutil
import subprocess
import tempfile
import unittest

SOURCE = pathlib.Path(__file__).resolve().parents[2]


class Dev(unittest.TestCase):
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
