#!/bin/sh
# usage: check_symbols.sh STATIC_LIBRARY SHARED_LIBRARY
# The shared library exports daft.h's functions and nothing else. The archive needs no terminal and never ends the process,
# and has no data that anyone writes to: two engines in one process are independent. No kernel fuses operations.
set -eu

archive=$1
shared=$2
header=$(dirname -- "$0")/../../engine/daft.h
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
bad=0

# What is defined and exported, against what the header declares.
nm -D --defined-only "$shared" | awk '$2 != "A" { print $3 }' | sort -u >"$out/exported"
grep '^DAFT_API' "$header" | sed 's/.*[ *]\(daft_[a-z0-9_]*\)(.*/\1/' | sort -u >"$out/declared"
comm -13 "$out/declared" "$out/exported" >"$out/extra"
comm -23 "$out/declared" "$out/exported" >"$out/lacking"
[ ! -s "$out/extra" ] || { echo "exported, but not in daft.h:" && cat "$out/extra" && bad=1; }
[ ! -s "$out/lacking" ] || { echo "in daft.h, but not exported:" && cat "$out/lacking" && bad=1; }

# What a library leaves to its caller.
nm -A --undefined-only "$archive" 2>/dev/null | awk '{ print $NF " in " $1 }' |
    grep -E '^(stdout|stderr|stdin|printf|vprintf|puts|putchar|perror|exit|_exit|_Exit|quick_exit|abort|__printf_chk|SDL_.*|lua.*) ' \
        >"$out/forbidden" || true
[ ! -s "$out/forbidden" ] || { echo "the library must not use:" && cat "$out/forbidden" && bad=1; }

# Sections that stay writable. .data.rel.ro is not: the loader seals it. What stb writes to
# nowhere may stay: switches that nobody turns, two tables it forgot to call const, a message it fills in. So may the
# thread-local pointer by which stb's allocations find the allocator of the call that runs (engine/image/stb_memory.c).
objdump -t "$archive" | awk '
    /file format/ { object = $1; next }
    {
        section = ""
        for (i = 2; i <= NF; i++) if ($i ~ /^\.(data|bss|tdata|tbss)/ || $i == "*COM*") section = $i
        if (section == "" || section ~ /^\.data\.rel\.ro/ || $NF ~ /^\./ || $NF ~ /^(stbiw?_|daft_stb_session$|firstmap\.|mapping\.|invalid_chunk\.)/) next
        print object ": " $NF " in " section
    }' >"$out/writable"
[ ! -s "$out/writable" ] || { echo "data that can be written:" && cat "$out/writable" && bad=1; }

# -ffp-contract=off is not the whole promise: with AVX-512 some compilers' vectorizers still make fused operations.
objdump -d --no-show-raw-insn "$archive" 2>/dev/null | awk '
    /file format/ { object = $1; next }
    $2 ~ /^vfn?m(add|sub)/ { print object ": " $2; exit }' >"$out/fused"
[ ! -s "$out/fused" ] || { echo "fused multiply-adds, whose last bit differs:" && cat "$out/fused" && bad=1; }

[ "$bad" = 0 ] || exit 1
echo "$(wc -l <"$out/exported") functions exported, no terminal, no exit, no writable data, nothing fused"
