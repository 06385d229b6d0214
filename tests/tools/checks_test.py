#!/usr/bin/env python3
"""Shows that tools/checks.sh and tools/all.sh, of ./dev guard and ./dev all, report what came of each check."""
import pathlib
import re
import shutil
import signal
import subprocess
import tempfile
import time
import unittest

TOOLS = pathlib.Path(__file__).resolve().parents[2] / "tools"
BEGIN = f"set -euo pipefail\nsource {TOOLS}/checks.sh\n"


def run(checks):
    """Runs {name: what its function does} one after the other; returns {name: (result, counts)} and all that was printed."""
    with tempfile.TemporaryDirectory() as folder:
        script = BEGIN
        for name, body in checks.items():
            script += f"do_{name}() {{\n{body}\n}}\nrun_check {name} do_{name}\n"
        script += "echo TABLE\nprint_checks\necho failed: $checks_failed\n"
        output = subprocess.run(["bash", "-c", script], cwd=folder, capture_output=True, text=True, timeout=60)
    assert output.returncode == 0, output.stderr
    rows = output.stdout.split("TABLE\n")[1].splitlines()
    table = {row.split()[0]: (row.split()[1], " ".join(row.split()[3:])) for row in rows[1:-1]}
    return table, output.stdout


class Checks(unittest.TestCase):
    def test_goes_on_after_a_failure(self):
        table, printed = run({"first": "echo one; false; echo two", "second": "exit 2", "third": "echo fine"})
        self.assertEqual(table, {"first": ("FAILED", "one"), "second": ("FAILED", ""), "third": ("passed", "fine")})
        self.assertIn("failed: 2", printed)
        self.assertNotIn("two", printed)

    def test_skipped_says_why(self):
        table, printed = run({"first": 'helper() { echo "no data here"; return "$skipped"; }; helper; echo not reached'})
        self.assertEqual(table, {"first": ("skipped", "no data here")})
        self.assertIn("failed: 0", printed)

    def test_counts(self):
        table, _ = run({
            "ctest": "echo ' 1/8 Test #1: blender ...***Skipped 0.01 sec'; echo '[  PASSED  ] 3 tests.'\n"
                     "echo '75% tests passed, 2 tests failed out of 8'; echo '# tests 5'; echo '# fail 1'; echo '# skipped 2'; return 8",
            "gtest": "echo '[  PASSED  ] 7 tests.'; echo '[  SKIPPED ] 2 tests, listed below:'; echo '[  PASSED  ] 1 test.'",
            "fuzz": "echo 'obj      clean, 12 inputs'; echo 'ply      clean, 30 inputs'",
            "one": "echo 'obj      clean, 12 inputs'",
            "search": "echo 'answers_1      clean, 12 cases, 99 steps in 3 s'; echo 'answers_2      clean, 30 cases, 9 steps in 3 s'\n"
                      "echo 'certificates   clean, 7 attacks, 90 of 99 moves accepted'",
        })
        self.assertEqual(table, {"ctest": ("FAILED", "13 tests, 3 failed, 3 skipped"),
                                 "gtest": ("passed", "10 tests, 0 failed, 2 skipped"),
                                 "fuzz": ("passed", "2 targets, 42 inputs"),
                                 "one": ("passed", "1 target, 12 inputs"),
                                 "search": ("passed", "42 cases, 7 attacks on certificates")})

    def test_an_interrupt_ends_what_runs_and_leaves_the_table(self):
        script = BEGIN + ("trap 'stop_checks; print_checks; exit 130' INT TERM\n"
                          "fast() { echo done; }\nslow() { echo so far; sleep 1000 & echo $! >child; wait; }\n"
                          "run_check fast fast\nrun_check slow slow\necho not reached\n")
        for name in (signal.SIGINT, signal.SIGTERM):
            with self.subTest(name), tempfile.TemporaryDirectory() as folder:
                process = subprocess.Popen(["bash", "-c", script], cwd=folder, stdout=subprocess.PIPE, text=True)
                child = pathlib.Path(folder) / "child"
                while not child.exists() or not child.read_text().strip():
                    time.sleep(0.05)
                process.send_signal(name)
                printed, _ = process.communicate(timeout=30)
                self.assertEqual(process.returncode, 130)
                self.assertRegex(printed, r"fast +passed +0:00 +done\nslow +stopped +0:\d\d +so far\n$")
                status = pathlib.Path("/proc") / child.read_text().strip() / "stat"
                deadline = time.monotonic() + 10
                while status.exists() and status.read_text().split()[2] != "Z" and time.monotonic() < deadline:
                    time.sleep(0.05)
                self.assertTrue(not status.exists() or status.read_text().split()[2] == "Z")


class All(unittest.TestCase):
    """./dev all, with checks that only count how often they ran."""
    SCRIPT = """set -euo pipefail
say() { :; }; need() { :; }; die() { echo "$*" >&2; exit 2; }
source tools/all.sh
all_checks=(test fuzz_query floats)
all_test() { echo ran >>ran; echo '[  PASSED  ] 3 tests.'; }
all_fuzz_query() {
  echo ran >>ran
  echo 'obj      clean, 12 inputs'
  [[ ! -f broken ]] || { echo 'ply      FAILED; what it printed is in a file'; return 1; }
  echo 'ply      clean, 30 inputs'
}
all_floats() { [[ -f fixed ]]; echo 'every float'; }
do_all "$@"
"""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        (self.folder / "tools").symlink_to(TOOLS)
        (self.folder / "docs").mkdir()
        (self.folder / ".gitignore").write_text("/out\n/ran\n/fixed\n/broken\n")
        self.git("init", "--quiet")
        self.commit()

    def git(self, *arguments):
        subprocess.run(["git", "-c", "user.name=Tester", "-c", "user.email=tester@example.org", *arguments],
                       cwd=self.folder, check=True)

    def commit(self):
        self.git("add", "--all")
        self.git("commit", "--quiet", "--message=change")

    def run_all(self, *arguments, killed=False):
        """Killed once the page has been written, if asked for.
        Returns the exit code, the table {name: (result, counts)} of docs/quality.md and how many checks ran."""
        ran = self.folder / "ran"
        ran.unlink(missing_ok=True)
        script = self.SCRIPT
        if killed:
            script = script.replace("do_all", """eval "as_ever_$(declare -f write_quality)"
write_quality() { as_ever_write_quality "$@"; kill -KILL $$; }
do_all""")
        process = subprocess.run(["bash", "-c", script, "all", *arguments], cwd=self.folder,
                                 capture_output=True, text=True, timeout=60)
        rows = [row.split(" | ") for row in (self.folder / "docs" / "quality.md").read_text().splitlines()
                if row.startswith("| ")][1:]
        return (process.returncode, {row[0][2:]: (row[2], row[3]) for row in rows},
                len(ran.read_text().splitlines()) if ran.exists() else 0)

    def test_goes_on_with_what_has_not_passed(self):
        table = {"test": ("passed", "3 tests, 0 failed, 0 skipped"), "fuzz_query": ("passed", "2 targets, 42 inputs"),
                 "fuzz_query_obj": ("passed", "12 inputs"), "fuzz_query_ply": ("passed", "30 inputs"),
                 "floats": ("FAILED", "")}
        self.assertEqual(self.run_all(), (2, table, 2))
        log = self.folder / "out" / "checks" / "fuzz_query.log"
        log.write_text("obj      clean, 1 inputs\n")  # of a shorter run since
        (self.folder / "fixed").touch()
        table["floats"] = ("passed", "every float")
        self.assertEqual(self.run_all(), (0, table, 0))
        self.assertEqual(self.run_all(), (0, table, 0))

    def test_a_part_that_failed_fails_the_check_until_it_passes(self):
        (self.folder / "fixed").touch()
        (self.folder / "broken").touch()
        parts = {"fuzz_query_obj": "passed", "fuzz_query_ply": "FAILED"}
        for ran, *arguments in ((2,), (1,), (0, "--only", "floats")):
            code, table, runs = self.run_all(*arguments)
            self.assertEqual((code, runs), (2, ran))
            self.assertEqual(table["fuzz_query"][0], "FAILED")
            self.assertEqual({name: table[name][0] for name in parts}, parts)
        (self.folder / "broken").unlink()
        code, table, _ = self.run_all()
        self.assertEqual((code, table["fuzz_query"][0], table["fuzz_query_ply"][0]), (0, "passed", "passed"))

    def test_goes_on_where_only_the_page_is(self):
        self.assertEqual(self.run_all("--only", "fuzz_query")[2], 1)
        shutil.rmtree(self.folder / "out")
        self.run_all("--only", "test", killed=True)
        self.assertEqual(self.run_all("--only", "test")[1]["fuzz_query_ply"], ("passed", "30 inputs"))

    def test_only_a_change_of_what_it_reads_runs_a_check_again(self):
        (self.folder / "tests" / "fuzz").mkdir(parents=True)
        page = self.folder / "docs" / "quality.md"
        for changed, again in (("apps", ["test"]), ("tests/fuzz/target.cpp", ["test", "fuzz_query"]),
                               ("docs/page.md", ["test"]), ("CHANGELOG.md", []),
                               ("CMakeLists.txt", ["test", "fuzz_query"])):
            with self.subTest(changed):
                self.run_all("--only", "test,fuzz_query")
                self.commit()
                (self.folder / changed).write_text("changed")
                self.commit()
                old = set(re.findall(r"\| ([0-9a-f]+) \|$", page.read_text(), re.MULTILINE))
                self.assertEqual(self.run_all("--only", "test,fuzz_query")[2], len(again))
                rows = dict(re.findall(r"^\| (\w+) \|.* \| ([0-9a-f]+) \|$", page.read_text(), re.MULTILINE))
                self.assertEqual([name for name in ("test", "fuzz_query") if rows[name] not in old], again)
                self.assertEqual(rows["fuzz_query_obj"], rows["fuzz_query"])

    def test_comments_run_no_check_again_that_compiles(self):
        source = self.folder / "src" / "ccd"
        source.parent.mkdir()
        self.run_all("--only", "test,fuzz_query")
        for text, ran in (("int a;\n", 2), ("// Why.\n  /// What.\n//\nint a;\n", 1), ("// Why not.\nint a;\n", 1),
                          ("// Why not. \\\nint a;\n", 2), ("int a;\n", 2), ("int a;  // Why.\n", 2)):
            with self.subTest(text):
                source.write_text(text)
                self.commit()
                self.assertEqual(self.run_all("--only", "test,fuzz_query")[2], ran)

    def test_rows_of_a_commit_that_is_not_here_do_not_count(self):
        self.run_all("--only", "test")
        page = self.folder / "docs" / "quality.md"
        page.write_text(re.sub(r"\| [0-9a-f]+ \|$", "| 0123456 |", page.read_text(), flags=re.MULTILINE))
        self.assertEqual(self.run_all("--only", "test")[2], 1)

    def test_another_commit_or_length_or_a_change_begins_anew(self):
        self.assertEqual(self.run_all("--only", "test")[2], 1)
        self.assertEqual(self.run_all("--only", "test")[2], 0)
        self.commit()  # only of docs/quality.md
        self.assertEqual(self.run_all("--only", "test")[2], 0)
        self.assertEqual(self.run_all("--only", "test", "--minutes", "3")[2], 1)
        self.assertEqual(self.run_all("--only", "test")[2], 1)
        (self.folder / "source").write_text("changed")
        self.assertEqual(self.run_all("--only", "test")[2], 1)
        self.assertEqual(self.run_all("--only", "test")[2], 1)
        self.commit()
        self.assertEqual(self.run_all("--only", "test")[2], 1)

    def test_what_was_not_asked_for_is_said(self):
        self.assertEqual(self.run_all("--only", "test")[:2], (0, {
            "test": ("passed", "3 tests, 0 failed, 0 skipped"), "fuzz_query": ("skipped", "not asked for"),
            "floats": ("skipped", "not asked for")}))


class Inputs(unittest.TestCase):
    """A row of ./dev all holds until one of its inputs changes, so what they include belongs to them."""
    CHECKS = ("lint_query lint_models address_query address_models thread_query thread_models fuzz_query fuzz_models "
              "fuzz_gltf search floats frames mutants proofs arm64 s390x compilers").split()

    def files_of(self, check):
        inputs = subprocess.run(["bash", "-c", f"set -euo pipefail\nsource tools/all.sh\ninputs_of {check}"],
                                cwd=TOOLS.parent, capture_output=True, text=True, check=True).stdout.split()

        def files_at(names):
            paths = [path for name in names for path in TOOLS.parent.glob(name)]
            return {file for path in paths for file in ([path] if path.is_file() else path.rglob("*")) if file.is_file()}

        excluded = [name.removeprefix(":!") for name in inputs if name.startswith(":!")]
        return files_at(name for name in inputs if not name.startswith(":!")) - files_at(excluded)

    def test_hold_what_they_include(self):
        places = [TOOLS.parent / name for name in ("src", "tests", "include", "bench")]
        for check in self.CHECKS:
            files = self.files_of(check)
            self.assertGreater(len(files), 100, check)
            for file in (file for file in files if file.suffix in (".cpp", ".h")):
                for name in re.findall(r'#include "([^"]+)"', file.read_text()):
                    found = [path for place in (file.parent, *places) if (path := place / name).is_file()]
                    if found:  # else a header that the build makes
                        self.assertTrue(found[0].resolve() in files, f"{check} leaves out {name}, which {file} includes")

    def test_read_no_gltf_where_its_reader_is_left_out(self):
        reader = TOOLS.parent / "src" / "io" / "gltf.cpp"
        without = [check for check in self.CHECKS if reader not in self.files_of(check)]
        self.assertEqual(without, ["lint_query", "address_query", "thread_query", "fuzz_query", "fuzz_models", "search",
                                   "floats", "frames", "mutants", "proofs"])
        for check in without:
            for file in self.files_of(check):
                if TOOLS.parent / "tests" in file.parents and file.suffix in (".cpp", ".h"):
                    self.assertNotRegex(file.read_text(), r"(?i)gltf|\.glb", f"{check} runs {file}")

    def test_lines_that_count_as_comments_are_comments(self):
        """Not text in a raw string, nor a line of a language with other comments."""
        if not (TOOLS.parent / ".git").exists():
            self.skipTest("not a checkout")
        listed = subprocess.run(["git", "ls-files"], cwd=TOOLS.parent, capture_output=True, text=True, check=True).stdout
        for name in listed.splitlines():
            if name.endswith((".fbs", ".js", ".md", ".mjs", ".ts", "/defects")) or not (TOOLS.parent / name).is_file():
                continue
            text = (TOOLS.parent / name).read_bytes()
            if name.endswith((".cpp", ".h", ".hpp")):
                text = b"".join(found[0] for found in re.finditer(rb'R"(\w*)\(.*?\)\1"', text, re.DOTALL))
            if b"\0" not in text:
                self.assertIsNone(re.search(rb"^ *//(|.*[^\\\n])$", text, re.MULTILINE), name)


if __name__ == "__main__":
    unittest.main()
