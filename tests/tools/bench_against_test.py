#!/usr/bin/env python3
"""tools/bench_against fails past both limits and only then, and says which row it was."""
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]

# Answers as foldproof-steps does, with the same time for everything.
FAKE = """#!/bin/sh
while read -r command rest; do
  case $command in
    scenes) echo "one two" ;;
    plan) echo "0/0/1 1/0/1 2/0/1" ;;
    checker) echo ok ;;
    *) echo "TIME TIME 3 HASH" ;;
  esac
done
"""


def run(folder, old, new, *options, hashes=("a", "a")):
    programs = []
    for name, time, hash_ in (("old", old, hashes[0]), ("new", new, hashes[1])):
        program = pathlib.Path(folder) / name
        program.write_text(FAKE.replace("TIME", str(time)).replace("HASH", hash_))
        program.chmod(0o755)
        programs.append(str(program))
    return subprocess.run([sys.executable, str(ROOT / "tools/bench_against"), *programs, "--rounds", "1", *options],
                          capture_output=True, text=True, check=False)


def main():
    with tempfile.TemporaryDirectory() as folder:
        same = run(folder, 5, 5)
        assert same.returncode == 0 and "two, tenth" in same.stdout, same
        assert "differ" not in same.stdout, same
        assert run(folder, 5, 4).returncode == 0
        assert run(folder, 5, 5.4).returncode == 0, "within the relative limit"
        assert run(folder, 0.1, 0.25).returncode == 0, "within the absolute limit"
        slower = run(folder, 5, 5.6, "--scene", "one")
        assert slower.returncode == 1 and "one, full" in slower.stderr and "SLOWER" in slower.stdout, slower
        assert run(folder, 5, 5.6, "--relative", "20").returncode == 0
        assert run(folder, 5, 5.6, "--absolute", "1").returncode == 0
        other = run(folder, 5, 5, hashes=("a", "b"))
        assert other.returncode == 0 and "answers differ in 3 steps" in other.stdout, other


if __name__ == "__main__":
    main()
