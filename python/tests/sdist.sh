#!/bin/sh
# usage: sdist.sh PYTHON SOURCE WHERE BUILD
# Packs the source for pip, and configures it as pip does. Compiling would take minutes; instead, every file that BUILD, made by
# Ninja, compiled for the module has to be there. Exit code 77, which ctest calls skipped, without Ninja.
set -e
python=$1 source=$(realpath "$2") where=$3 build=$(realpath "$4")
command -v ninja >/dev/null && test -f "$build/build.ninja" || exit 77
rm -rf "$where"
sh "$source/python/sdist.sh" "$python" "$source" "$where"
cd "$where"
tar xf foldproof-*.tar.gz
mv foldproof-*/ unpacked
cmake -S unpacked -B build -G Ninja -DPython3_EXECUTABLE="$python" -DFOLDPROOF_PYTHON=ON -DFOLDPROOF_PROGRAM=OFF \
  -DFOLDPROOF_TESTS=OFF -DFOLDPROOF_INSTALL=OFF >log || { cat log && exit 1; }
if grep "^PNG" build/CMakeCache.txt; then
  echo "the module does not need libpng"
  exit 1
fi
ninja -C "$build" -t deps >deps
"$python" - "$source" "$build" <<'TEXT'
import os.path
import pathlib
import re
import sys

source, build, needed = *sys.argv[1:], set()
for part in re.split(r"\n(?=\S)", pathlib.Path("deps").read_text()):
    if re.match(r"(src/CMakeFiles/foldproof(_io|_model|_repair|_report)?|python/CMakeFiles/foldproof_python)\.dir/", part):
        paths = (os.path.relpath(os.path.join(build, path), source) for path in re.findall(r"^ +(\S+)$", part, re.MULTILINE))
        needed.update(path for path in paths if path.startswith(("src/", "include/", "python/")))
assert len(needed) > 200, len(needed)
missing = sorted(each for each in needed if not pathlib.Path("unpacked", each).exists())
assert not missing, missing
print(f"complete: {len(needed)} files")
TEXT
