#!/bin/sh
# usage: sdist.sh PYTHON SOURCE OUT
# Packs what pip needs to compile the module into OUT, the same bytes each time; nothing is left in the sources.
set -e
python=$1 source=$(realpath "$2") out=$(realpath -m "$3")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
printf '[egg_info]\negg_base = %s\n' "$work" >"$work/elsewhere.cfg"
cd "$source"
DIST_EXTRA_CONFIG=$work/elsewhere.cfg "$python" setup.py --quiet sdist --dist-dir "$work/dist"
cd "$work/dist"
tar xf ./*.tar.gz
rm ./*.tar.gz
name=$(echo foldproof-*)
mkdir -p "$out"
tar --sort=name --owner=0 --group=0 --numeric-owner --mode=u=rwX,go=rX --mtime="@${SOURCE_DATE_EPOCH:-0}" -c "$name" |
  gzip -9n >"$out/$name.tar.gz"
