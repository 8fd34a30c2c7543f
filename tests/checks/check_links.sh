#!/bin/sh
# usage: check_links.sh [ROOT]
# What the manual names is there. Links: each relative link and image of a page names a file, each #anchor a heading of that
# page, and docs/index.md links every page. Paths: `engine/x.c`, `tests/y/` and the like exist, on any page. Code: each
# `function()` and `daft_type` of architecture.md stands in the sources, a function in a file that its line names.
# shellcheck disable=SC2013,SC2016 # names without blanks; backticks as text
set -eu

root=$(CDPATH='' cd -- "${1:-$(dirname -- "$0")/../..}" && pwd)
cd "$root"
out=$(mktemp)
trap 'rm -f "$out"' EXIT
bad=0
count=0

complain() { echo "$1: $2" && bad=1; }

# GitHub's anchors: lower case, punctuation gone, blanks to dashes.
anchors_of() {
    sed -n '/^```/,/^```/d; s/^##*  *//p' "$1" | tr '[:upper:]' '[:lower:]' | sed 's/[^a-z0-9 _-]//g; s/ /-/g'
}

# Names in backticks, outside of code blocks. Upper case marks a placeholder: `tests/unit/ROOM/`.
names_of() { sed '/^```/,/^```/d' "$1" | grep -o '`[^` ]*`' | tr -d '`' | sort -u; }

pages=$(find . -name '*.md' -not -path './build/*' -not -path './.git/*' -not -path './tests/checks/layers/*' | LC_ALL=C sort)
for page in $pages; do
    folder=$(dirname "$page")
    for link in $(sed '/^```/,/^```/d; s/`[^`]*`//g' "$page" | grep -o '\](\([^)]*\))' | sed 's/^](//; s/)$//; s/ ".*//'); do
        case $link in http:* | https:* | mailto:*) continue ;; esac
        count=$((count + 1))
        file=${link%%#*}
        if [ -n "$file" ]; then target=$folder/$file; else target=$page; fi
        if [ ! -e "$target" ]; then
            complain "$page" "the link '$link' leads nowhere"
            continue
        fi
        case $link in *#*) anchors_of "$target" | grep -qxF -- "${link#*#}" ||
            complain "$page" "there is no heading for '$link'" ;; esac
    done
    for name in $(names_of "$page"); do
        case $name in
        *[A-Z*…\{\<$]*) ;;
        engine/* | runtime/* | tests/* | assets/* | games/* | scripts/* | docs/* | examples/* | .ci/* | .github/*)
            count=$((count + 1))
            [ -e "$name" ] || complain "$page" "there is no '$name'" ;;
        esac
    done
done

# Every page of the manual is in its index.
for page in $(find docs -name '*.md' -not -name index.md | LC_ALL=C sort); do
    grep -qF "](${page#docs/})" docs/index.md || complain docs/index.md "leaves out $page"
done

page=docs/concepts/architecture.md
grep -rhoE --include='*.[ch]' '[A-Za-z_][A-Za-z0-9_]*' engine runtime tests | sort -u >"$out" # all words of the sources
for name in $(names_of "$page"); do
    case $name in
    *.* | */*) continue ;;
    *'()') name=${name%??} ;;
    daft_*) ;;
    *) continue ;;
    esac
    count=$((count + 1))
    grep -qxF -- "$name" "$out" || complain "$page" "no source has '$name'"
done

# A line that names functions beside files: each function stands in one of these files.
grep -n '`[^`]*()`.*`[^`]*\.[ch]`' "$page" | tr -d '|' >"$out"
while IFS= read -r line; do
    names=$(echo "$line" | grep -o '`[^` ]*`' | tr -d '`')
    files=$(echo "$names" | grep '/.*\.[ch]$')
    for name in $(echo "$names" | grep '()$'); do
        # shellcheck disable=SC2086 # a list of files
        grep -qw -- "${name%??}" $files 2>/dev/null || complain "$page:${line%%:*}" "no file of this line has $name"
    done
done <"$out"

[ "$count" -gt 100 ] || { echo "only $count names found: the pages were not read" && exit 1; }
[ "$bad" = 0 ] || exit 1
echo "$count links and names in the manual, all there"
