#!/usr/bin/env python3
"""Every test has two labels, of its module and of what it takes, on which the presets rely; the modules fuzz and package have
the same name as what their tests take. labels_test.py CTEST BUILD"""
import json
import subprocess
import sys

KINDS = {"quick", "motions", "package", "heavy", "fuzz"}


def labels_of(test):
    return next((p["value"] for p in test["properties"] if p["name"] == "LABELS"), [])


def main(ctest, build):
    shown = subprocess.run([ctest, "--test-dir", build, "-C", "Heavy", "--show-only=json-v1"], capture_output=True, text=True,
                           check=True).stdout
    tests = [test for test in json.loads(shown)["tests"] if not test["name"].endswith("_NOT_BUILT")]
    wrong = []
    for test in tests:
        labels = set(labels_of(test)) - {"command"}
        if len(labels & KINDS) != 1 or (len(labels) != 2 and labels not in ({"fuzz"}, {"package"})):
            wrong.append(f"{test['name']} has the labels {sorted(labels)}")
        if "heavy" in labels:
            continue
        of_googletest = any(word.startswith("--gtest_filter=") for word in test.get("command", []))
        if of_googletest == ("command" in labels_of(test)):
            wrong.append(f"{test['name']} has {'the' if of_googletest else 'no'} label 'command'")
        if of_googletest and ("Real" in test["name"]) != ("motions" in labels):
            wrong.append(f"{test['name']} has the labels {sorted(labels)}")
    assert tests
    print("\n".join(wrong) or f"{len(tests)} tests have their labels")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
