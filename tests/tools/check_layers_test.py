#!/usr/bin/env python3
"""Shows that tools/check_layers finds what it is there to find, by running it on small bad trees."""
import pathlib
import subprocess
import sys
import tempfile
import unittest

TOOL = pathlib.Path(__file__).resolve().parents[2] / "tools" / "check_layers"


def check(files):
    """Runs the tool on a tree of {path: text}; returns (exit code, output)."""
    with tempfile.TemporaryDirectory() as root:
        for path, text in files.items():
            file = pathlib.Path(root) / path
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text)
        run = subprocess.run([sys.executable, str(TOOL), root], capture_output=True, text=True)
        return run.returncode, run.stdout


class CheckLayers(unittest.TestCase):
    def accepts(self, files):
        code, output = check(files)
        self.assertEqual(code, 0, output)

    def refuses(self, files, *words):
        code, output = check(files)
        self.assertEqual(code, 1, output)
        for word in words:
            self.assertIn(word, output)

    def test_includes_of_earlier_modules_pass(self):
        self.accepts({
            "include/foldproof/check.h": '#include "foldproof/bvh.h"\n',
            "include/foldproof/bvh.h": '#include "foldproof/base.h"\n',
            "include/foldproof/base.h": "#include <vector>\n",
            "src/check/step.cpp": '#include "foldproof/check.h"\n#include "check/pairs.h"\n#include "bvh/boxes.h"\n',
            "apps/main.cpp": '#include "foldproof/check.h"\n#include "commands.h"\n',
            "apps/commands.h": "",
        })

    def test_upward_include_is_found_with_its_line(self):
        self.refuses({"src/mesh/a.cpp": '#include <vector>\n\n#include "foldproof/check.h"\n'}, "src/mesh/a.cpp:3", "check")

    def test_upward_include_of_a_public_header_is_found(self):
        self.refuses({"include/foldproof/bvh.h": '#include "foldproof/check.h"\n'}, "include/foldproof/bvh.h:1")

    def test_modules_of_one_level_do_not_see_each_other(self):
        self.refuses({"src/io/a.cpp": '#include "foldproof/bvh.h"\n'}, "'io' must not see 'bvh'")

    def test_ccd_and_statistics_never_see_mesh(self):
        self.refuses({"src/ccd/a.cpp": '#include "foldproof/mesh.h"\n'}, "'ccd' must not see 'mesh'")
        self.refuses({"src/statistics/a.cpp": '#include "foldproof/mesh.h"\n'}, "'statistics' must not see 'mesh'")

    def test_nothing_in_the_library_sees_the_programs(self):
        self.refuses({"src/report/a.cpp": '#include "apps/terminal.h"\n'}, "'report' must not see 'apps'")

    def test_unknown_modules_are_found(self):
        self.refuses({"src/mesh/a.cpp": '#include "attic/old.h"\n'}, "belongs to no module")
        self.refuses({"src/attic/a.cpp": ""}, "module 'attic' has no level")

    def test_algorithms_are_there_for_the_page(self):
        offered = {"web/standard_library.h": "using ::ranges::sort;\n"}
        self.accepts({"src/mesh/a.cpp": "void f() { std::ranges::sort(x); }\n", **offered})
        self.accepts({"tests/mesh/a.cpp": "void f() { std::ranges::fill(x, 0); }\n", **offered})
        self.refuses({"src/mesh/a.cpp": "\nvoid f() { std::ranges::fill(x, 0); }\n", **offered}, "src/mesh/a.cpp:2", "std::ranges::fill")

    def test_sizes(self):
        self.accepts({"src/mesh/a.cpp": "\n" * 600, "include/foldproof/mesh.h": "\n" * 300})
        self.refuses({"src/mesh/a.cpp": "\n" * 601}, "601 lines")
        self.refuses({"include/foldproof/mesh.h": "\n" * 301}, "301 lines")

    def library(self, **sources):
        """A tree with sources a and b in one library, given what their unnamed namespaces have."""
        tree = {"src/CMakeLists.txt": "foldproof_library(foldproof base mesh)\n"}
        for (name, text), folder in zip(sources.items(), ("base", "mesh")):
            tree[f"src/{folder}/{name}.cpp"] = f"namespace foldproof {{\nnamespace {{\n\n{text}\n}}  // namespace\n}}  // namespace foldproof\n"
        return tree

    def test_sources_of_one_library_have_no_names_in_common(self):
        for text, name in [("int f(int a, std::map<int, int> b) {\n  g();\n}\n", "f() of 2 parameters"),
                           ("template <class T, class U>\nT f() {}\n", "f() of 0 parameters"), ("constexpr int kMost = 3;\n", "kMost"),
                           ("struct Side {\n  int x;\n};\n", "Side"), ("std::FILE* output = stdout;\n", "output")]:
            self.refuses(self.library(a=text, b="int before() { return {}; }\n\n" + text),
                         "src/mesh/b.cpp: src/base/a.cpp has " + name)
        self.refuses(self.library(a="using Points = std::vector<int>;\n", b="using Points = std::span<int>;\n"), "Points")

    def test_no_source_of_a_library_uses_a_whole_namespace(self):
        self.refuses(self.library(a="using namespace io;\n"), "src/base/a.cpp: 'using namespace io;'")
        self.accepts(self.library(a="using namespace std::chrono_literals;\nvoid f() {\n  using namespace io;\n}\n"))

    def test_names_that_can_be_told_apart_pass(self):
        self.accepts(self.library(a="int f(int a) {\n  int x = 1;\n}\n", b="int f(int a, int b = 0) {\n  int x = 1;\n}\n"))
        self.accepts(self.library(a="using V = Eigen::V;\nnamespace fs = std::fs;\nusing Eigen::V;\n",
                                  b="using V = Eigen::V;\nnamespace fs = std::fs;\nusing Eigen::V;\n"))


if __name__ == "__main__":
    unittest.main()
