#!/bin/sh
# run.sh FOLDPROOF SOURCES ADDON: the add-on's test in Blender, as an add-on and under the name of an extension. Exit code 77, which
# ctest calls skipped, without Blender.
set -eu
if ! command -v blender >/dev/null; then
  echo "skipped: Blender is not installed; Debian's package blender has it"
  exit 77
fi
for name in foldproof_addon bl_ext.user_default.foldproof; do
  work=$(mktemp -d)
  trap 'rm -rf "$work"' EXIT
  mkdir "$work/home" "$work/files"
  # Does not read or change the user's own Blender settings.
  HOME=$work/home BLENDER_USER_CONFIG=$work/home BLENDER_USER_SCRIPTS=$work/home \
    blender --background --factory-startup --python-exit-code 1 --python "$2/tests/blender/test_addon.py" \
    -- "$1" "$3" "$work/files" $name
  rm -rf "$work"
done
