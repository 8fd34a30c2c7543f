#!/bin/sh
# usage: check_links.sh [ROOT]
# The manual's links lead somewhere: each relative link and image of a page names a file that exists, each #anchor a
# heading of that page, and docs/index.md links every page. Code names in architecture.md are true: `path/file.c` exists
# below the root, engine/ or runtime/; `function()` and `daft_type` stand in the sources.
set -eu

root=$(CDPATH='' cd -- "${1:-$(dirname -- "$0")/../..}" && pwd)
cd "$root"
bad=0
count=0

complain() { echo "$1: $2" && bad=1; }

# GitHub's anchors: lower case, punctuation gone, blanks to dashes.
anchors_of() {
    sed -n '/^```/,/^```/d; s/^##*  *//p' "$1" | tr '[:upper:]' '[:lower:]' | sed 's/[^a-z0-9 _-]//g; s/ /-/g'
}

pages=$(find . -name '*.md' -not -path './build/*' -not -path './.git/*' | LC_ALL=C sort)
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
done

# Every page of the manual is in its index.
for page in $(find docs -name '*.md' -not -name index.md | LC_ALL=C sort); do
    grep -qF "](${page#docs/})" docs/index.md || complain docs/index.md "leaves out $page"
done

# Names of code in the pages that guide through it.
for page in docs/concepts/architecture.md; do
    [ -e "$page" ] || continue
    for name in $(sed '/^```/,/^```/d' "$page" | grep -o '`[^` ]*`' | tr -d '`' | sort -u); do
        count=$((count + 1))
        case $name in
        *.lua | daft.* | -* | *=* | *'*'* | *'{'* | *'<'* | *:* ) ;;
        */*)
            [ -e "$name" ] || [ -e "engine/$name" ] || [ -e "runtime/$name" ] ||
                complain "$page" "there is no file '$name'" ;;
        *'()')
            grep -rqw --include='*.[ch]' -- "${name%??}" engine runtime tests ||
                complain "$page" "no source has '$name'" ;;
        daft_*)
            grep -rqw --include='*.[ch]' -- "$name" engine runtime tests ||
                complain "$page" "no source has '$name'" ;;
        esac
    done
done

[ "$count" -gt 30 ] || { echo "too few links: the pages were not read" && exit 1; }
[ "$bad" = 0 ] || exit 1
echo "$count links and names lead somewhere"
