#!/bin/sh
# usage: check_layout.sh [--apply]
# C sources are laid out as .clang-format says, by version 14 of clang-format: versions differ. With --apply, lays them out
# so. Skipped where there is no such clang-format.
set -eu

root=$(CDPATH='' cd -- "$(dirname -- "$0")/../.." && pwd)
cd "$root"
format=
for name in clang-format-14 clang-format; do
    if [ -z "$format" ] && command -v "$name" >/dev/null && "$name" --version | grep -q 'version 14\.'; then format=$name; fi
done
[ -n "$format" ] || { echo 'there is no clang-format 14' && exit 77; }

# The samples of check_layers are bad on purpose.
sources=$(find engine runtime tests examples assets -name '*.[ch]' -not -path 'tests/checks/layers/*' | LC_ALL=C sort)
if [ "${1:-}" = --apply ]; then
    # Twice: what the first time wraps, the second may join.
    echo "$sources" | xargs "$format" -i
    echo "$sources" | xargs "$format" -i
    exit
fi
# One line for each file: xargs' own status says whether there was any.
if ! echo "$sources" | xargs "$format" --dry-run --Werror 2>&1 | grep 'error: code should be clang-formatted' |
    cut -d: -f1 | uniq -c | sed 's/^ *\([0-9]*\) \(.*\)/\2: \1 places; tests\/checks\/check_layout.sh --apply lays it out/' | grep .; then
    echo "$(echo "$sources" | wc -l) sources are laid out as .clang-format says"
    exit 0
fi
exit 1
