#!/bin/sh
# run.sh FOLDPROOF: checks the page's types, and tests it in Chromium. Exit code 77, which ctest calls skipped, where it cannot.
set -e
cd "$(dirname "$0")/.."
if ! command -v chromium >/dev/null || ! test -d node_modules; then
  echo "skipped: Chromium is not installed, or the page is not made (cmake --build build --target page)"
  exit 77
fi
npm run --silent check
FOLDPROOF=$(realpath "$1") npm test --silent
