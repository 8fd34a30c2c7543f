#!/bin/sh
# usage: check_paths.sh [ROOT]
# Paths that the manual names in backticks or links to are there, so that a renamed file takes the manual along.
set -eu

here=$(CDPATH='' cd -- "$(dirname -- "$0")" && pwd)
cd "${1:-$here/../..}"
out=$(mktemp)
trap 'rm -f "$out"' EXIT

# page:path of each `engine/x.c`, `tests/y/` … and of each [link](../z.md#part), as seen from the root.
find README.md CONTRIBUTING.md CHANGELOG.md SECURITY.md docs examples tests/data -name '*.md' 2>/dev/null | LC_ALL=C sort | while IFS= read -r page; do
    # shellcheck disable=SC2016 # backticks as text
    grep -o '`\(engine\|runtime\|tests\|assets\|games\|scripts\|docs\|examples\|\.ci\|\.github\)/[^` *…{<$]*`' "$page" | tr -d '`' |
        grep -v '[A-Z][A-Z]' | sed "s,^,$page:,"
    grep -o '](\([^):#]*\)[)#]' "$page" | sed 's/^](//; s/[)#]$//' | grep -v '^$' | sed "s,^,$page:$(dirname "$page")/,"
done >"$out" || true
count=0
bad=0
while IFS=: read -r page path; do
    count=$((count + 1))
    [ -e "$path" ] || { echo "$page: there is no $path" && bad=1; }
done <"$out"
[ "$count" -gt 20 ] || { echo "only $count paths found" && exit 1; }
[ "$bad" = 0 ] || exit 1
echo "$count paths named in the manual, all there"
