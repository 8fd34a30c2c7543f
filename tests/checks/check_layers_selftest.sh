#!/bin/sh
# check_layers.sh on a small tree of good and bad samples. A bad line says, in a comment, which complaint it expects;
# all of these and no others must come.
set -eu

here=$(CDPATH='' cd -- "$(dirname -- "$0")" && pwd)
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT

cd "$here/layers"
grep -rn 'expect: ' engine runtime | sed 's/^\([^:]*:[0-9]*\):.*expect: \(.*\) \*\/.*/\1 \2/' | LC_ALL=C sort >"$out/expected"
if sh "$here/check_layers.sh" "$here/layers" docs/map.md >"$out/all"; then
    echo "check_layers.sh passes a tree of bad samples" && exit 1
fi
sed 's/^\([^:]*:[0-9]*\): .*(\(.*\))$/\1 \2/' "$out/all" | LC_ALL=C sort >"$out/found"
diff "$out/expected" "$out/found" || { echo "< expected, > found" && exit 1; }
echo "$(wc -l <"$out/found") bad samples found, nothing else"
