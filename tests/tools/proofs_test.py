#!/usr/bin/env python3
"""Shows that tools/proofs notices when a constant or an operation changes, in the code or in a proof."""
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
CONSTANT = re.compile(r"^# constant (\S+): .*\n(?:#.*\n)*(\w+) = ([^;]*);", re.M)


class Proofs(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)

    def copy(self, *names):
        """A tree with these proofs, a table that names them, and the code that they quote."""
        (self.root / "docs").mkdir()
        (self.root / "proofs").mkdir()
        rows = "".join(f"| S | [it](../proofs/{name}) | - |\n" for name in names)
        (self.root / "docs/soundness.md").write_text(f"## What machines prove\n\n| a | b | c |\n|---|---|---|\n{rows}")
        for name in names:
            shutil.copy(ROOT / "proofs" / name, self.root / "proofs")
            for source in re.findall(r"(?:code|constant) ((?:src|include)/[^\s:]+)", (ROOT / "proofs" / name).read_text()):
                (self.root / source).parent.mkdir(parents=True, exist_ok=True)
                shutil.copy(ROOT / source, self.root / source)

    def edit(self, name, old, new):
        file = self.root / name
        text = file.read_text()
        self.assertIn(old, text)
        file.write_text(text.replace(old, new))

    def run_tool(self, *arguments):
        run = subprocess.run([sys.executable, ROOT / "tools/proofs", *arguments, self.root], capture_output=True, text=True)
        return run.returncode, run.stdout + run.stderr

    def refuses(self, said, *arguments):
        code, output = self.run_tool(*arguments)
        self.assertEqual(code, 1, output)
        self.assertIn(said, output)

    def test_every_constant_is_compared_with_the_code(self):
        names = sorted(path.name for path in (ROOT / "proofs").glob("*.g"))
        self.copy(*names)
        self.assertEqual(self.run_tool("--code")[0], 0)
        compared = 0
        for name in names:
            file = self.root / "proofs" / name
            text = file.read_text()
            for _, constant, value in CONSTANT.findall(text):
                file.write_text(text.replace(f"{constant} = {value};", f"{constant} = 2 * ({value});"))
                self.refuses(f"the proof has {constant} = 2 * ({value})", "--code")
                compared += 1
            file.write_text(text)
        self.assertGreater(compared, 25)

    def test_a_constant_of_the_code(self):
        self.copy("n1_threshold.g")
        self.edit("src/ccd/bounds.h", "kDotError = 23 * kUnit", "kDotError = 22 * kUnit")
        self.refuses("src/ccd/bounds.h has 22*kUnit where the proof has kDotError = 23b-53", "--code")

    def test_an_operation_of_the_code(self):
        self.copy("n_corners.g")
        self.edit("src/ccd/lanes.h", "const V s = hn::Sub(Number(1), t);", "const V s = hn::Sub(t, Number(1));")
        self.refuses("src/ccd/lanes.h no longer has the line: const V s", "--code")

    def test_a_constant_that_is_gone(self):
        self.copy("n1_threshold.g")
        self.edit("src/ccd/bounds.h", "kDotError", "kProjectionError")
        self.refuses("src/ccd/bounds.h no longer has the constant", "--code")

    def test_the_table_names_all_proofs(self):
        self.copy("n_corners.g")
        shutil.copy(ROOT / "proofs/n5_middle.g", self.root / "proofs")
        (self.root / "proofs/n_corners.g").unlink()
        self.refuses("docs/soundness.md does not name proofs/n5_middle.g", "--code")
        self.refuses("docs/soundness.md names proofs/n_corners.g, which is not there", "--code")

    @unittest.skipUnless(shutil.which("gappa"), "Gappa is not installed")
    def test_constants_that_are_too_small_are_not_proven(self):
        """In the code and in the proof alike."""
        for name, source, of_code, of_proof in (
            ("n1_threshold.g", "src/ccd/bounds.h", ("23 * kUnit", "22 * kUnit"), ("23b-53", "22b-53")),
            ("n3_threshold.g", "src/ccd/bounds.h", ("139 * kUnit", "138 * kUnit"), ("139b-53", "138b-53")),
            ("v4_lists.g", "src/solver/candidate_lists.cpp", ("kUp = 1 + 0x1p-50", "kUp = 1 + 0x1p-53"),
             ("kUp = 1125899906842625b-50", "kUp = 9007199254740993b-53")),
        ):
            with self.subTest(name):
                self.setUp()
                self.copy(name)
                self.assertEqual(self.run_tool()[0], 0)
                self.edit(source, *of_code)
                self.edit(f"proofs/{name}", *of_proof)
                self.assertEqual(self.run_tool("--code")[0], 0)
                self.refuses(f"proofs/{name}: gappa does not prove it")

    @unittest.skipUnless(shutil.which("coqc"), "Coq is not installed")
    def test_a_theorem_may_not_assume(self):
        self.copy("r4_trees.v")
        proof = self.root / "proofs/r4_trees.v"
        proof.write_text("(* A: b *)\nRequire Import Reals.\nAxiom wish : forall r : R, (r > 0)%R.\n"
                         "Theorem T r : (r > 0)%R. Proof. apply wish. Qed.\nPrint Assumptions T.\n")
        self.refuses("rests on wish")
        proof.write_text("Theorem T : 1 = 1. Proof. reflexivity. Qed.\n")
        self.refuses("prints the assumptions of 0 theorems out of 1")


if __name__ == "__main__":
    unittest.main()
