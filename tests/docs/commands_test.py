#!/usr/bin/env python3
"""Runs every command of the documents and of the help texts, as a reader would after `foldproof demo`.

usage: commands_test.py FOLDPROOF SOURCE

A command is a line of a code block that starts with `foldproof`. Of view and report, which need the built page, and of
those whose comment says (real data), only the options are checked.
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

PROGRAM, SOURCE = (pathlib.Path(argument).resolve() for argument in sys.argv[1:3])
# --watch does not end.
NEEDS_MORE = re.compile(r"foldproof (view|report) |\(real data\)|\| jq|--watch")


def run(command, folder):
    """As a shell does, with foldproof in PATH; exit codes 0 and 1 are answers."""
    path = f"{PROGRAM.parent}:{os.environ['PATH']}"
    return subprocess.run(["bash", "-o", "pipefail", "-c", command], cwd=folder, capture_output=True, text=True,
                          stdin=subprocess.DEVNULL, env={**os.environ, "PATH": path}, timeout=60)


def document_commands(text):
    """The commands of a document's indented code blocks."""
    return [match.group(1).strip() for match in re.finditer(r"^ {4}(foldproof .*)$", text, re.MULTILINE)]


def example_commands(text):
    """The commands of a help text; what is said of them stands two spaces or more behind."""
    lines = text[text.find("\nExamples:"):].splitlines()
    return [re.split(r" {2,}", line.strip())[0] for line in lines if line.startswith("  foldproof ")]


def options_of(command):
    return re.findall(r"(?<=\s)--?[a-z][a-z-]*", command.split("#")[0])


class Commands(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp())
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        done = run("foldproof demo -q demo", cls.folder)
        assert done.returncode == 0, done.stderr

    def in_new_folder(self, name, commands):
        folder = self.folder / name
        shutil.copytree(self.folder / "demo", folder)
        for command in commands:
            with self.subTest(document=name, command=command):
                if NEEDS_MORE.search(command):
                    known = run(f"foldproof help {command.split()[1]}", folder).stdout
                    for option in options_of(command):
                        self.assertRegex(known, rf"(^|[\s,]){option}\b")
                    continue
                done = run(command, folder)
                self.assertIn(done.returncode, (0, 1), done.stderr)
                self.assertNotIn("foldproof:", done.stderr)

    def test_documents(self):
        documents = [SOURCE / "README.md", *sorted((SOURCE / "docs").glob("*.md"))]
        found = {document.name: document_commands(document.read_text()) for document in documents}
        self.assertGreater(sum(map(len, found.values())), 20)
        for name, commands in found.items():
            if commands:
                self.in_new_folder(name, commands)

    def test_help_texts(self):
        listed = run("foldproof help", self.folder).stdout.split("Subcommands:\n")[1].split("\n\n")[0]
        names = re.findall(r"^  ([a-z]+) ", listed, re.MULTILINE)
        self.assertIn("check", names)
        for name in names:
            text = run(f"foldproof help {name}", self.folder).stdout
            self.in_new_folder(f"help {name}", example_commands(text))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
