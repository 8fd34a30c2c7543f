#!/bin/sh
# Where the instructions of a benchmark go, by function: for each pixel and for each triangle tested.
# usage: tests/bench/profile.sh 'SCENE ROW' [ISA]      in the checkout, after ./daft bench has built the benchmarks
#   tests/bench/profile.sh 'bunny, whole camera rays, exact' avx2
#   tests/bench/profile.sh 'bunny, whole frame, one light' sse2
# Counts with valgrind's callgrind, which knows no AVX-512; one frame, one thread, without what comes before and after.
set -eu

[ $# -ge 1 ] || { sed -n '2,5s/^# //p' "$0" >&2 && exit 2; }
row=$1
isa=${2:-avx2}
root=$(CDPATH='' cd -- "$(dirname -- "$0")/../.." && pwd)
bench=$root/build/release/tests/daft_bench
case $row in
*camera*) function=bench_camera_ms ;;
*) function=daft_render ;;
esac
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT

valgrind --tool=callgrind --toggle-collect="$function" --callgrind-out-file="$out/calls" \
    "$bench" --only "$row" --rounds 1 --threads 1 --isa "$isa" --json "$out/rows.json" >"$out/log" 2>&1 ||
    { cat "$out/log" >&2 && exit 1; }
[ "$(grep -c '"scene"' "$out/rows.json")" = 1 ] || { echo "'$row' is the name of more than one row" >&2 && exit 1; }
triangles=$(sed -n 's/.*[ "]\([0-9]*\) triangles tested.*/\1/p' "$out/rows.json")
callgrind_annotate "$out/calls" >"$out/functions"
awk -v triangles="${triangles:-0}" -v row="$row" -v isa="$isa" '
    function line(count, name) {
        each = triangles ? sprintf("%.1f", count / triangles) : "-"
        printf("%12d %5.1f%% %9.2f %11s  %s\n", count, 100 * count / total, count / 921600, each, name)
    }
    { count = $1; gsub(",", "", count) }
    /PROGRAM TOTALS/ {
        total = count + 0
        printf("%s, %s, one frame of 1280x720%s\n", row, isa, triangles ? ", " triangles " triangles tested" : "")
        printf("%12s %6s %9s %11s  %s\n", "instructions", "of all", "a pixel", "a triangle", "function")
        line(total, "all of it")
        next
    }
    total && count * 200 > total && sub(/^[^)]*%\) +/, "") && /:/ { sub(/^[^:]*:/, "", $1); line(count, $1) }' "$out/functions"
