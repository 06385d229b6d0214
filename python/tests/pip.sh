#!/bin/sh
# usage: pip.sh PYTHON SOURCE WHERE BUILD
# Installs the module with pip, as docs/python.md says, and uses it. What that leaves goes to WHERE, not to the sources. BUILD has
# compiled the module already, so that this does not take minutes.
set -e
python=$1 source=$2 where=$3 build=$4
rm -rf "$where"
mkdir -p "$where"
printf '[build]\nbuild_base = %s\n[egg_info]\negg_base = %s\n' "$where/build" "$where" >"$where/elsewhere.cfg"
"$python" -m venv --system-site-packages "$where/venv"
FOLDPROOF_BUILD=$build DIST_EXTRA_CONFIG=$where/elsewhere.cfg \
  "$where/venv/bin/pip" install --quiet --no-build-isolation --no-index "$source"
cd "$where"
unset PYTHONPATH
"$where/venv/bin/python" - <<'TEXT'
import pathlib
import foldproof
x0 = [[-9, -9, 0], [20, -9, 0], [-9, 20, 0], [0, 0, 0.6], [1, 0, 2], [0, 1, 2]]
x1 = [[-9, -9, 0], [20, -9, 0], [-9, 20, 0], [0, 0, -0.4], [1, 0, 1], [0, 1, 1]]
hit, = foldproof.check(foldproof.Motion([[0, 1, 2], [3, 4, 5]], [x0, x1])).vertex_face
package = pathlib.Path(foldproof.__file__).parent
assert (package / "py.typed").exists() and (package / "_core.pyi").exists() and "venv" in str(package)
print(f"installed and works: {hit['face']} {hit['toi']:.3f}")
TEXT
