#!/bin/sh
# usage: wheel.sh PYTHON SOURCE WHERE BUILD
# Makes the wheel, installs it, and runs an example with it. Exit code 77, which ctest calls skipped, without patchelf.
set -e
python=$1 source=$2 where=$3 build=$4
command -v patchelf >/dev/null || exit 77
rm -rf "$where"
sh "$source/python/wheel.sh" "$python" "$source" "$where" "$build"
"$python" -m venv --system-site-packages "$where/venv"
"$where/venv/bin/pip" install --quiet --no-index "$where"/*.whl
cd "$where"
unset PYTHONPATH
"$where/venv/bin/python" "$source/python/examples/check.py"
# Libraries come from the wheel, apart from those that every system has; each with its license.
"$where/venv/bin/python" - <<'TEXT'
import importlib.metadata
import pathlib
import re
import foldproof
used = {p for p in re.findall(r"/\S+\.so\S*", pathlib.Path("/proc/self/maps").read_text())}
for name in ("libtbb", "libfmt", "libhwy", "libzip"):
    path, = (p for p in used if name in p)
    assert "foldproof.libs" in path, path
files = [str(f) for f in importlib.metadata.files("foldproof")]
for package in ("libtbb12", "libeigen3-dev", "pybind11-dev"):
    assert any(f.endswith(f"licenses/{package}.copyright") for f in files), package
print("stands alone:", importlib.metadata.metadata("foldproof")["Name"], foldproof.__version__)
TEXT
