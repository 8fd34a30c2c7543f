#!/bin/sh
# usage: check_layers.sh [ROOT [MAP]]
# The rooms of the house depend one way. Reads every #include under ROOT/engine and ROOT/runtime, and what the engine must
# not touch: the terminal, the process, SDL, Lua. Private headers stay in their rooms, and files include each other in no
# circle. With MAP, a page of the manual below ROOT, rooms form no circle either, each says which of its headers are public,
# and each stands on the map, as `engine/sim/solve/`. Prints "file:line: what is wrong (the rule)", fails if anything is.
set -eu

here=$(CDPATH='' cd -- "$(dirname -- "$0")" && pwd)
cd "${1:-$here/../..}"
sources=$(find engine runtime -name '*.[ch]' | LC_ALL=C sort)
[ -n "$sources" ] || { echo "no sources under $PWD" >&2 && exit 1; }
# shellcheck disable=SC2086 # the checkout's file names have no spaces
exec awk -v map="${2:-}" -f "$here/check_layers.awk" $sources
