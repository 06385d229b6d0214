#!/usr/bin/env python3
"""Links between documents lead somewhere, and every file that names the version names the project's.

usage: links_test.py SOURCE
"""
import pathlib
import re
import sys
import unittest

SOURCE = pathlib.Path(sys.argv[1]).resolve()
# (target) of [text](target) and ![text](target), outside code.
LINK = re.compile(r"\]\(([^)\s]+)\)")
CODE = re.compile(r"^```.*?^```|^    .*?$|`[^`\n]*`", re.DOTALL | re.MULTILINE)


def without_code(text):
    return CODE.sub("", text)


def anchors(text):
    """Of headings, as the common viewers of repositories make them."""
    headings = re.findall(r"^#+ (.*)$", re.sub(r"^```.*?^```", "", text, flags=re.DOTALL | re.MULTILINE), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", h)).strip().lower().replace(" ", "-") for h in headings}


class Documents(unittest.TestCase):
    def test_links(self):
        documents = [*SOURCE.glob("*.md"), *(SOURCE / "docs").rglob("*.md"), SOURCE / "npm" / "README.md"]
        found = 0
        for document in documents:
            for target in LINK.findall(without_code(document.read_text())):
                if re.match(r"[a-z]+:", target):
                    continue
                found += 1
                path, _, anchor = target.partition("#")
                to = (document.parent / path) if path else document
                with self.subTest(document=str(document.relative_to(SOURCE)), link=target):
                    self.assertTrue(to.exists())
                    if anchor and to.suffix == ".md":
                        self.assertIn(anchor, anchors(to.read_text()))
        self.assertGreater(found, 100)

    def test_versions(self):
        version = re.search(r"project\(foldproof VERSION (\S+)", (SOURCE / "CMakeLists.txt").read_text()).group(1)
        for file, pattern in (
            ("CITATION.cff", r"^version: (\S+)$"),
            ("blender/foldproof_addon/blender_manifest.toml", r'^version = "(\S+)"$'),
            ("blender/foldproof_addon/__init__.py", r'^    "version": \((\d+, \d+, \d+)\),$'),
        ):
            with self.subTest(file=file):
                self.assertEqual(re.search(pattern, (SOURCE / file).read_text(), re.MULTILINE).group(1).replace(", ", "."), version)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
