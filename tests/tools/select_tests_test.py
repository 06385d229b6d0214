#!/usr/bin/env python3
"""Shows that tools/select_tests, of ./dev test NAME..., finds parts, programs, folders, suites and filters."""
import pathlib
import subprocess
import tempfile
import unittest

TOOL = pathlib.Path(__file__).resolve().parents[2] / "tools" / "select_tests"
PARTS = "bvh: test_bvh\noracle: test_oracle\napps: foldproof_program test_apps\ntools: \n"
SOURCES = {
    "bvh/hierarchy_test.cpp": "TEST(Hierarchy, Builds) {}\nTEST_F(Refit, Moves) {}\n// TEST(Hierarchy, IsNone)\n",
    "oracle/tests/oracle_test.cpp": "TEST(Oracle, Counts) {}\n",
    "apps/files_test.cpp": "TEST_P(\n    Files, Opens) {}\nINSTANTIATE_TEST_SUITE_P(\n    Formats, Files, Values(1));\n"
                           "TEST(Oracle, OfFiles) {}\n",
}


class SelectTests(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        (self.folder / "parts").write_text(PARTS)
        for name, text in SOURCES.items():
            path = self.folder / "tests" / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text)

    def run_tool(self, *names):
        return subprocess.run([TOOL, self.folder / "parts", self.folder / "tests", *names], capture_output=True, text=True)

    def select(self, *names):
        process = self.run_tool(*names)
        self.assertEqual(process.returncode, 0, process.stderr)
        return process.stdout.splitlines()

    def test_parts_by_every_name(self):
        for name in ("bvh", "test_bvh", "build/test_bvh", "src/bvh", "./tests/bvh/", "src/bvh/hierarchy.cpp"):
            self.assertEqual(self.select(name), ["target test_bvh", "label bvh"], name)
        self.assertEqual(self.select("tools"), ["label tools"])
        self.assertEqual(self.select("apps/files.cpp", "apps"),
                         ["target foldproof_program", "target test_apps", "label apps"])

    def test_suites_and_filters_find_their_programs(self):
        self.assertEqual(self.select("Hierarchy"), ["target test_bvh", "filter test_bvh Hierarchy.*:*/Hierarchy.*"])
        self.assertEqual(self.select("Hier*:Refit.*-*Slow"), ["target test_bvh", "filter test_bvh Hier*:Refit.*-*Slow"])
        self.assertEqual(self.select("Oracle.?o*"), ["target test_oracle", "filter test_oracle Oracle.?o*"])
        self.assertEqual(self.select("Oracle.*"),
                         ["target test_oracle", "target foldproof_program", "target test_apps",
                          "filter test_oracle Oracle.*", "filter test_apps Oracle.*"])

    def test_filters_of_tests_with_parameters(self):
        for name in ("Formats/Files.*", "*Files.Opens*", "Formats/Files.Opens/0", "*/obj", "*obj"):
            self.assertIn(f"filter test_apps {name}", self.select(name))
        for name in ("Files.Opens", "Other/Files.*", "Formats/Files.Opens"):
            self.assertEqual(self.run_tool(name).returncode, 2, name)

    def test_unknown_names_are_answered_with_those_there_are(self):
        for name, meant in (("bhv", "bvh"), ("Hierachy.*", "Hierarchy"), ("IsNone", None), ("Hierarchy.IsNone", "Hierarchy")):
            process = self.run_tool("bvh", name)
            self.assertEqual((process.returncode, process.stdout), (2, ""))
            self.assertIn(f"no test is named '{name}'" + (f"; did you mean {meant}" if meant else "\n"), process.stderr)
            self.assertIn("apps bvh oracle tools\n", process.stderr)


if __name__ == "__main__":
    unittest.main()
