#!/bin/sh
# usage: docs/reports.sh PROGRAM [--quick] [--out DIR] [NAME…]
# Makes the reports of docs/reports anew: `daft cost` of six scenes and of games, pictures and simulation, without their pictures; and the
# plot that the README shows. With names, those alone; each takes about three minutes, all ten half an hour. --quick: coarse ones of half a
# minute, to try it; --out: into another folder than docs/reports, and no plot.
set -eu

usage() {
    sed -n 's/^# //p' "$0" | head -5 >&2
    exit 2
}

[ $# -gt 0 ] || usage
program=$1
shift
root=$(CDPATH='' cd -- "$(dirname -- "$0")/.." && pwd)
cd "$root"
out=docs/reports
quick=
while [ $# -gt 0 ]; do
    case $1 in
    --quick) quick=--quick ;;
    --out)
        [ $# -gt 1 ] || usage
        out=$2
        shift
        ;;
    -*) usage ;;
    *) break ;;
    esac
    shift
done
[ $# -gt 0 ] || set -- hello temple islands glass hall town marble marble-sim toppler toppler-sim
mkdir -p "$out"

number=0
for name in "$@"; do
    number=$((number + 1))
    echo "$(date +%H:%M:%S) $number of $#: $name"
    what=$name
    [ ! -f "assets/scenes/$name.scene" ] || what=assets/scenes/$name.scene
    case $name in
    *-sim) "$program" cost "${name%-sim}" --sim $quick -o "$out/$name" ;;
    *) "$program" cost "$what" --no-pictures $quick --budget 16 -o "$out/$name" ;;
    esac >"$out/$name.txt" || {
        rm -f "$out/$name.txt"
        exit 1
    }
    mv "$out/$name.txt" "$out/$name/table.txt"
    echo "$(date +%H:%M:%S) $out/$name written"
    # The first plot of the temple's page, as a file of its own.
    [ "$name $out" != "temple docs/reports" ] ||
        awk '/<svg /{ sub(/.*<svg /, "<svg xmlns=\"http://www.w3.org/2000/svg\" font-family=\"sans-serif\" font-size=\"11\" "); on = 1 }
             on { if (sub(/<\/svg>.*/, "</svg>")) { print; exit } print }' "$out/temple/index.html" >docs/images/cost-temple.svg
done
