#!/bin/sh
# usage: address_space.sh PROGRAM [all]
# The program under ulimit -v, from 16 MB to 2 GB: exit status 0, or 1 with a message. Only the system's loader, which finds
# no room for the libraries, may end it otherwise (127).
set -u

program=$1
root=$(cd -- "$(dirname -- "$0")/../.." && pwd)
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
cd "$root" || exit 1
sizes='16 128 272 304 352 448 768 2048'
[ "${2:-}" = all ] && sizes='16 24 32 48 64 96 128 160 192 224 256 264 272 280 288 296 304 312 320 336 352 368 384 416 448 480 512 576 640
    768 896 1024 1280 1536 2048'
scenes='assets/scenes/glass.scene'
[ "${2:-}" = all ] && scenes=$(echo assets/scenes/*.scene)
runs=0
bad=0

# try MEGABYTES ARGUMENTS...
try() {
    size=$1
    shift
    (ulimit -v $((size * 1024)) && ulimit -c 0 && exec "$program" "$@") >"$out/log" 2>&1 </dev/null
    status=$?
    runs=$((runs + 1))
    case $status in
    0) return ;;
    1) [ -s "$out/log" ] && return ;;
    127) grep -q 'shared librar' "$out/log" && return ;;
    esac
    bad=$((bad + 1))
    echo "ulimit -v $size MB, daft $*: exit status $status"
    tail -n 3 "$out/log"
}

for size in $sizes; do
    for threads in 2 16; do
        for scene in $scenes; do try "$size" render "$scene" -o "$out/a.png" --size 160x90 --threads "$threads"; done
        try "$size" play marble --headless --ticks 10 --record "$out/a.rec" --threads "$threads"
    done
    try "$size" check assets/scenes/hello.scene
    try "$size" help
done
echo "$runs runs, $bad bad"
[ "$bad" = 0 ]
