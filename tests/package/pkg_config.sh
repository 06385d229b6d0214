#!/bin/sh
# usage: pkg_config.sh COMPILER SOURCE PREFIX
# Builds a program against the installed library with what pkg-config says, and runs it.
set -e
PKG_CONFIG_PATH=$(dirname "$(find "$3" -name foldproof.pc)")
export PKG_CONFIG_PATH
# shellcheck disable=SC2046 # these are words
"$1" -std=c++20 "$2" -o "$3/pkg_config_example" $(pkg-config --cflags --libs foldproof)
"$3/pkg_config_example"
