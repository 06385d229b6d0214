#!/bin/sh
# Writes the manual pages, of what --help prints: manual.sh FOLDPROOF DIRECTORY. Needs help2man.
set -eu
program=$1 directory=$2
version=$("$program" --version | sed -n '1s/foldproof //p')
mkdir -p "$directory"
rm -f "$directory"/foldproof*.1

# page NAME [COMMAND]
page() {
  about=$("$program" ${2:-} --help | head -n 1)
  help2man --no-info --version-string="$version" --name="$about" "$program${2:+ $2}" |
    sed "s/^\\.TH FOLDPROOF /.TH $1 /; s/^foldproof ${2:-} *\\\\-/$1 \\\\-/" >"$directory/$1.1"
}

page foldproof
for command in $("$program" --help | sed -n '/^Subcommands:/,/^$/ s/^  \([a-z]*\) .*/\1/p'); do
  [ "$command" = help ] || page "foldproof-$command" "$command"
done
