#!/bin/sh
# usage: examples.sh FOLDER_OF_PROGRAMS
# The examples include daft.h and the C library alone, are short, run, and write what they promise.
set -eu

programs=$1
root=$(CDPATH='' cd -- "$(dirname -- "$0")/../.." && pwd)
scene=$root/assets/scenes/temple.scene
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
passed=0

fail() { echo "$*" && exit 1; }
ok() { passed=$((passed + 1)); }

for source in "$root"/examples/*.c; do
    [ "$(wc -l <"$source")" -le 120 ] || fail "$source has more than 120 lines"
    other=$(sed -n 's/^# *include *[<"]\(.*\)[>"].*/\1/p' "$source" | grep -v -E '^(daft|stdio|stdlib|string)\.h$') &&
        fail "$source includes $other"
    [ -x "$programs/$(basename "$source" .c)" ] || fail "$source was not built"
    ok
done

cd "$out"
"$programs/hello" red.png && head -c 4 red.png | grep -q PNG || fail 'hello wrote no picture'
ok
"$programs/lidar" "$scene" sweep.ply >said || fail 'lidar failed'
[ "$(sed -n 's/^element vertex //p' sweep.ply)" = "$(sed '1,/end_header/d' sweep.ply | wc -l)" ] || fail 'the sweep is not whole'
[ "$(sed -n 's/^element vertex //p' sweep.ply)" -gt 1000 ] || fail 'the sweep has too few points'
ok
"$programs/robot" 60 >said || fail 'the robot touched something'
grep -q '^drove 3[0-9]' said || fail 'the robot did not go round'
ok
"$programs/depth" "$scene" . >said || fail 'depth failed'
[ "$(wc -l <said)" = 8 ] && [ "$(wc -c <depth-7.pgm)" = $((2 * 160 * 120 + 17)) ] || fail 'a depth image is not whole'
grep -q '[0-9] m to the nearest obstacle' said || fail 'depth does not say how far'
ok
"$programs/loop" 20 >once && "$programs/loop" 20 >again || fail 'loop failed'
[ "$(tail -n 1 once)" = "$(tail -n 1 again)" ] && grep -q '^pictures [0-9a-f]*, state' once ||
    fail 'two runs of loop differ'
ok
echo "[  PASSED  ] $passed test(s)"
