#!/bin/sh
# usage: tidy.sh BUILD_FOLDER
# clang-tidy with the checks of .clang-tidy finds nothing in the engine, the runtime and the examples. Of sources that are
# compiled once for each instruction set, the baseline is read. Skipped where there is no clang-tidy.
set -eu

build=$1
root=$(CDPATH='' cd -- "$(dirname -- "$0")/../.." && pwd)
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT

command -v clang-tidy >/dev/null || { echo 'there is no clang-tidy' && exit 77; }
cd "$root"
# One command for each source, without the warnings that only the build's own compiler knows.
awk '
    /^\{/ { entry = "" }
    { entry = entry $0 "\n" }
    /"file":/ { file = $0; sub(/^[^"]*"file": "/, "", file); sub(/".*/, "", file) }
    /^\}/ { sub(/\},?\n$/, "}", entry); if (!seen[file]++) { printf "%s%s", comma, entry; comma = ",\n" } }
    BEGIN { print "[" } END { print "\n]" }' "$build/compile_commands.json" >"$out/compile_commands.json"
find engine runtime examples -name '*.c' | LC_ALL=C sort >"$out/files"
status=0
xargs -P "$(getconf _NPROCESSORS_ONLN)" -n 8 clang-tidy --quiet -p "$out" --extra-arg=-Wno-unknown-warning-option \
    <"$out/files" >"$out/found" 2>"$out/said" || status=$?
[ "$status" = 0 ] || { cat "$out/found" && grep -v 'warnings generated\|Suppressed\|Use -header' "$out/said" && exit 1; }
echo "$(wc -l <"$out/files") sources, nothing found"
