#!/bin/sh
# usage: pack.sh BUILD OUT
# Makes the npm package from BUILD, which has compiled the engine, in OUT. TypeScript is the page's.
set -e
here=$(dirname "$0")
build=$1 out=$2
version=$(sed -n -E 's/^project\(foldproof VERSION ([0-9.]+).*/\1/p' "$here/../CMakeLists.txt")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"$here/../page/node_modules/.bin/tsc" -p "$here" --outDir "$work"
cp "$here/src/engine.d.ts" "$work"
cp "$build/package_engine.js" "$work/engine.js"
sed "s/\"0\.0\.0\"/\"$version\"/" "$here/package.json" >"$work/package.json"
cp -r "$here/README.md" "$here/example" "$here/../LICENSE" "$build/licenses.txt" "$work"
mkdir -p "$out"
rm -f "$out"/foldproof-*.tgz
npm pack --silent "$work" --pack-destination "$out" >/dev/null
