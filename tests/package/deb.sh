#!/bin/sh
# usage: deb.sh CPACK BUILD WHERE [THREADS]
# Makes the Debian packages of a build in WHERE, unpacks them there into `root` and runs the program from it.
set -e
cpack=$1 build=$2 where=$3
library=libtbb12
test "${4:-tbb}" = tbb || library=libzip4
rm -rf "$where"
mkdir -p "$where"
"$cpack" -G DEB --config "$build/CPackConfig.cmake" -B "$where" >"$where/log" 2>&1 || {
  cat "$where/log" >&2
  exit 1
}
for package in "$where"/*.deb; do
  dpkg-deb --extract "$package" "$where/root"
  echo "$(basename "$package"): needs $(dpkg-deb --field "$package" Depends)"
done
dpkg-deb --field "$where"/foldproof_*.deb Depends | grep -q "$library" || {
  echo "foldproof does not name the libraries that it is linked with" >&2
  exit 1
}
test -f "$where/root/usr/include/foldproof/check.h"
for file in man/man1/foldproof-check.1 bash-completion/completions/foldproof; do
  test -f "$where/root/usr/share/$file"
done
test -z "$(find "$where/root" -mindepth 1 -maxdepth 1 ! -name usr)"
"$where/root/usr/bin/foldproof" --version
