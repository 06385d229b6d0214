#!/bin/sh
# usage: wheel.sh PYTHON SOURCE OUT BUILD
# Makes a wheel that stands alone in OUT. BUILD has compiled the module; nothing is left in the sources.
set -e
python=$1 source=$2 out=$3 build=$(realpath "$4")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
printf '[build]\nbuild_base = %s\n[egg_info]\negg_base = %s\n' "$work/build" "$work" >"$work/elsewhere.cfg"
FOLDPROOF_BUILD=$build DIST_EXTRA_CONFIG=$work/elsewhere.cfg \
  "$python" -m pip wheel --quiet --no-build-isolation --no-index --no-deps --wheel-dir "$work" "$source"
"$python" -B "$source/tools/wheel" "$work"/*.whl "$out"
