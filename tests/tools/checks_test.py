#!/usr/bin/env python3
"""Shows that tools/checks.sh, with which ./dev guard and ./dev all run checks, reports what came of each."""
import pathlib
import signal
import subprocess
import tempfile
import time
import unittest

TOOL = pathlib.Path(__file__).resolve().parents[2] / "tools" / "checks.sh"
BEGIN = f"set -euo pipefail\nsource {TOOL}\n"


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
                     "echo '75% tests passed, 2 tests failed out of 8'; echo '# tests 5'; echo '# fail 1'; return 8",
            "gtest": "echo '[  PASSED  ] 7 tests.'; echo '[  SKIPPED ] 2 tests, listed below:'; echo '[  PASSED  ] 1 test.'",
            "fuzz": "echo 'obj      clean, 12 inputs'; echo 'ply      clean, 30 inputs'",
        })
        self.assertEqual(table, {"ctest": ("FAILED", "13 tests, 3 failed, 1 skipped"),
                                 "gtest": ("passed", "10 tests, 0 failed, 2 skipped"),
                                 "fuzz": ("passed", "2 targets, 42 inputs")})

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


if __name__ == "__main__":
    unittest.main()
