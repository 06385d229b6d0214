#!/bin/sh
# usage: standalone.sh PYTHON SOURCE PROGRAM WHERE
# Makes the folder that needs nothing of the system in WHERE. Every library has to come from it, also where the folder is reached
# by a link and nothing is in PATH.
set -e
python=$1 source=$2 program=$3 where=$4
"$python" -B "$source/tools/standalone" "$program" "$where/folder"
ln -sf folder/foldproof "$where/link"
loader=$(echo "$where"/folder/lib/ld-linux*)
"$loader" --library-path "$where/folder/lib" --list "$where/folder/lib/foldproof" |
  grep -v "$where/folder/lib/\|linux-vdso" && exit 1
test -f "$where/folder/licenses/libc6.copyright"
cd "$where"
rm -rf demo
env -i PATH=/nowhere "$where/link" demo --quiet demo
env -i PATH=/nowhere "$where/link" check demo/walk.glb || test $? = 1
