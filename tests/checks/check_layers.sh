#!/bin/sh
# usage: check_layers.sh [ROOT]
# The rooms of the house depend one way. Reads every #include under ROOT/engine and ROOT/runtime, and what the engine must
# not touch: the terminal, the process, SDL, Lua. Prints "file:line: what is wrong (the rule)" and fails if there is any.
set -eu

here=$(CDPATH='' cd -- "$(dirname -- "$0")" && pwd)
cd "${1:-$here/../..}"
sources=$(find engine runtime -name '*.[ch]' | LC_ALL=C sort)
[ -n "$sources" ] || { echo "no sources under $PWD" >&2 && exit 1; }
# shellcheck disable=SC2086 # the checkout's file names have no spaces
exec awk -f "$here/check_layers.awk" $sources
