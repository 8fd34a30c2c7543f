#!/bin/sh
# usage: docs/reports.sh PROGRAM [NAME…]
# Makes the reports of docs/reports anew: `daft cost` of six scenes and of games, pictures and simulation, without their pictures; and the
# plot that the README shows. With names, those alone. Takes about a quarter of an hour.
set -eu

program=$1
shift
root=$(CDPATH='' cd -- "$(dirname -- "$0")/.." && pwd)
out=$root/docs/reports
cd "$root"
mkdir -p "$out"
[ $# -gt 0 ] || set -- hello temple islands glass hall town marble marble-sim toppler toppler-sim

for name in "$@"; do
    what=$name
    [ ! -f "assets/scenes/$name.scene" ] || what=assets/scenes/$name.scene
    case $name in
    *-sim) "$program" cost "${name%-sim}" --sim -o "docs/reports/$name" ;;
    *) "$program" cost "$what" --no-pictures --budget 16 -o "docs/reports/$name" ;;
    esac >"$out/$name.txt"
    mv "$out/$name.txt" "$out/$name/table.txt"
    echo "docs/reports/$name written"
done

# The first plot of a page, as a file of its own.
awk '/<svg /{ sub(/.*<svg /, "<svg xmlns=\"http://www.w3.org/2000/svg\" font-family=\"sans-serif\" font-size=\"11\" "); on = 1 }
     on { if (sub(/<\/svg>.*/, "</svg>")) { print; exit } print }' "$out/temple/index.html" >docs/images/cost-temple.svg
