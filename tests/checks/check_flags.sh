#!/bin/sh
# usage: check_flags.sh BUILD_FOLDER
# Every source of the engine is compiled with contraction off, and none with a flag that lets the compiler change
# results. Reads compile_commands.json, so it sees what is really run.
set -eu

commands=$1/compile_commands.json
[ -f "$commands" ] || { echo "$commands is missing" >&2 && exit 1; }

grep '"command":' "$commands" | grep '/engine/[a-z]*/[a-z0-9_]*\.c' >"$1/engine_commands.txt" || true
count=$(wc -l <"$1/engine_commands.txt")
[ "$count" -gt 0 ] || { echo "$commands names no source of the engine" >&2 && exit 1; }

bad=0
while IFS= read -r line; do
    source=${line##* }
    case $line in
    *' -ffp-contract=off '*) ;;
    *) echo "$source is compiled without -ffp-contract=off" && bad=1 ;;
    esac
    for flag in -ffast-math -Ofast -funsafe-math-optimizations -ffp-contract=fast -ffp-contract=on -freciprocal-math \
        -fassociative-math -ffinite-math-only; do
        case $line in *" $flag "*) echo "$source is compiled with $flag" && bad=1 ;; esac
    done
done <"$1/engine_commands.txt"
[ "$bad" = 0 ] || exit 1
echo "$count commands, contraction is off in each"
