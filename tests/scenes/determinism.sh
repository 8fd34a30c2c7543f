#!/bin/sh
# usage: determinism.sh PROGRAM [others]
# Replays the demo of each game with 1 and with 2 threads; with `others`, also with every program that
# DAFT_OTHER_PROGRAMS names, one a line (other compilers and build types of the same sources; the test is skipped where it
# names none). State and pictures must be the same to the bit.
set -eu

root=$(CDPATH='' cd -- "$(dirname -- "$0")/../.." && pwd)
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT

number=0
echo "$1" >"$out/programs"
if [ "${2:-}" = others ]; then
    [ -n "${DAFT_OTHER_PROGRAMS:-}" ] || { echo 'DAFT_OTHER_PROGRAMS names no program' && exit 77; }
    printf '%s\n' "$DAFT_OTHER_PROGRAMS" >>"$out/programs"
fi
for demo in "$root"/games/*/demo.rec; do
    game=$(basename "$(dirname "$demo")")
    first=$((number + 1))
    while IFS= read -r program; do
        [ -n "$program" ] || continue
        for threads in 1 2; do
            number=$((number + 1))
            DAFT_HOME=$root "$program" play "$game" --headless --replay "$demo" --hash --threads "$threads" </dev/null >"$out/all" ||
                { echo "$program failed with $threads threads" && exit 1; }
            grep '^tick [0-9]* state 0x[0-9a-f]* frame 0x[0-9a-f]*$' "$out/all" >"$out/$number" ||
                { echo "$program prints no hashes" && exit 1; }
            echo "$game: $(wc -l <"$out/$number") states and pictures of $program, $threads threads: $(tail -n 1 "$out/$number")"
            cmp -s "$out/$first" "$out/$number" && continue
            diff "$out/$first" "$out/$number" | head -n 4
            exit 1
        done
    done <"$out/programs"
done
[ "$number" -gt 0 ] || { echo "$root/games has no demo.rec" && exit 1; }
echo "[  PASSED  ] $number test(s)"
