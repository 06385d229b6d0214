#!/usr/bin/env python3
"""Writes a C++ source that holds the built page, so that the program needs no files beside it.

usage: tools/embed.py DIST OUTPUT

DIST is page/dist; where it is not there the source holds no files, and the program says so. OUTPUT is left
alone when nothing has changed. Beside each file of report/ comes its SHA-256 in base64 as NAME.sha256: the report's
security policy allows the script with that sum and no other.
"""
import base64
import hashlib
import pathlib
import sys

# What would end the element that holds the file in the report.
FORBIDDEN = {".js": (b"</script", b"<!--"), ".css": (b"</style",)}
PIECE = 4096


def literal(data):
    """C++ string literals; octal escapes of full length need no care about what follows."""
    plain = {c for c in range(32, 127)} - set(b'"\\?')
    for at in range(0, len(data), PIECE):
        yield '"' + "".join(chr(c) if c in plain else f"\\{c:03o}" for c in data[at : at + PIECE]) + '"'


def files_of(dist):
    for path in sorted(p for p in dist.rglob("*") if p.is_file()):
        name, data = path.relative_to(dist).as_posix(), path.read_bytes()
        yield name, data
        if not name.startswith("report/"):
            continue
        for text in FORBIDDEN.get(path.suffix, ()):
            if text in data.lower():
                sys.exit(f"{path}: contains '{text.decode()}', which would end it inside the report; build it without")
        yield name + ".sha256", base64.b64encode(hashlib.sha256(data).digest())


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__.strip())
    dist, output = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
    lines = ["// Made by tools/embed.py.", '#include "page_files.h"', "", "namespace foldproof {", "namespace {", ""]
    entries = []
    for number, (name, data) in enumerate(files_of(dist) if dist.is_dir() else ()):
        lines.append(f"constexpr char kFile{number}[] =")
        lines += [f"    {piece}" for piece in literal(data)] or ['    ""']
        lines[-1] += ";"
        entries.append(f'{{"{name}", {{kFile{number}, {len(data)}}}}}')
    lines += ["", "}  // namespace", "", "std::vector<PageFile> page_files() {"]
    lines += ["  return {" + ",\n          ".join(entries) + "};", "}", "", "}  // namespace foldproof", ""]
    text = "\n".join(lines)
    if not output.exists() or output.read_text() != text:
        output.write_text(text)


if __name__ == "__main__":
    main()
