#!/bin/sh
# usage: docs/tables.sh PROGRAM [--check]
# The manual's tables of fields come from the engine: what stands between "<!-- fields NAME -->" and "<!-- end of fields -->" in a
# page is what `PROGRAM help fields NAME` prints. And scripts/daft.d.lua, for editors, is what `PROGRAM help annotations` prints.
# Writes them anew, or with --check fails where one differs.
set -eu

program=$1
check=${2:-}
root=$(CDPATH='' cd -- "$(dirname -- "$0")" && pwd)
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
tables=0
stale=0

for page in $(grep -rl '^<!-- fields ' "$root" --include='*.md' | LC_ALL=C sort); do
    awk -v program="$program" '
        inside && $0 == "<!-- end of fields -->" { inside = 0 }
        !inside { print }
        /^<!-- fields .* -->$/ {
            name = substr($0, 13, length($0) - 16)
            command = program " help fields \"" name "\""
            lines = 0
            while ((command | getline line) > 0) { print line; lines++ }
            if (close(command) != 0 || lines < 3) exit 1
            inside = 1
        }
        END { if (inside) exit 1 }' "$page" >"$out/page" || { echo "$page: a table that cannot be made, or has no end" && exit 1; }
    tables=$((tables + $(grep -c '^<!-- fields ' "$page")))
    cmp -s "$page" "$out/page" && continue
    if [ "$check" = --check ]; then
        diff "$page" "$out/page" | head -n 6
        echo "$page is not what the lists of fields say: run docs/tables.sh $program"
        stale=1
    else
        cp "$out/page" "$page"
        echo "$page written"
    fi
done

annotations=$root/../scripts/daft.d.lua
"$program" help annotations >"$out/annotations"
if ! cmp -s "$annotations" "$out/annotations"; then
    if [ "$check" = --check ]; then
        diff "$annotations" "$out/annotations" | head -n 6
        echo "$annotations is not what the tables of functions say: run docs/tables.sh $program"
        stale=1
    else
        cp "$out/annotations" "$annotations"
        echo "$annotations written"
    fi
fi
[ "$stale" = 0 ] || exit 1
[ "$tables" -gt 20 ] || { echo "only $tables tables found" && exit 1; }
echo "[  PASSED  ] $tables test(s)"
