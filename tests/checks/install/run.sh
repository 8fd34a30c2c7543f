#!/bin/sh
# usage: run.sh BUILD_FOLDER C_COMPILER SANITIZERS
# Installs into a temporary folder, and uses what is there as a stranger would: through pkg-config and daft.h alone.
set -eu

build=$1
cc=$2
extra=${3:+-fsanitize=$3} # a library built with sanitizers needs its users to link their run-time
here=$(CDPATH='' cd -- "$(dirname -- "$0")" && pwd)
prefix=$(mktemp -d)
trap 'rm -rf "$prefix"' EXIT

fail() { echo "$*" && exit 1; }

cmake --install "$build" --prefix "$prefix/usr" >"$prefix/log" || { cat "$prefix/log" && exit 1; }
# The files were installed to one place and are used from another: nothing may remember where they were.
mv "$prefix/usr" "$prefix/moved"
PKG_CONFIG_PATH=$(dirname "$(find "$prefix/moved" -name daft.pc)")
export PKG_CONFIG_PATH

for file in include/daft.h bin/daft share/daft/games/marble/main.lua share/daft/scripts share/daft/assets; do
    [ -e "$prefix/moved/$file" ] || fail "$file was not installed"
done
find "$prefix/moved" -name LICENSE | grep -q . || fail "the licence was not installed"

# shellcheck disable=SC2046,SC2086 # lists of flags
"$cc" -std=c11 -Wall -Wextra -Wpedantic -Werror $extra -o "$prefix/hello" "$here/hello.c" $(pkg-config --cflags --libs daft)
"$prefix/hello" || fail "the program that links the installed library saw the wrong picture"

found=
for cxx in c++ g++ clang++; do
    command -v "$cxx" >/dev/null 2>&1 && found=$cxx && break
done
if [ -n "$found" ]; then
    # shellcheck disable=SC2046 # a list of flags
    "$found" -std=c++11 -Wall -Wextra -Wpedantic -Werror -c -o "$prefix/header.o" "$here/header.cpp" \
        $(pkg-config --cflags daft)
    nm "$prefix/header.o" | grep -q ' daft_default_engine_def$' || fail "daft.h mangles its names in C++"
    echo "daft.h compiles as C++ with $found"
fi

"$prefix/moved/bin/daft" play marble --headless --ticks 60 --hash >"$prefix/out" || fail "the installed game does not play"
grep '^tick 60 ' "$prefix/out" || fail "the installed game printed no state"
if [ -e "$build/daft_film.so" ]; then # with whatever encoders this FFmpeg has: GIF is one that all have
    "$prefix/moved/bin/daft" video "$prefix/moved/share/daft/assets/scenes/hello.scene" -o "$prefix/film.gif" \
        --to 0.2 --size 32x18 || fail "the installed program does not find its module for films"
fi
if find "$prefix/moved" -name daft_stub | grep -q . && [ -z "$extra" ]; then
    "$prefix/moved/bin/daft" pack marble --standalone -o "$prefix/marble" >/dev/null || fail "the installed program packs no other"
    mv "$prefix/moved" "$prefix/gone"
    XDG_CACHE_HOME=$prefix "$prefix/marble" --headless --ticks 60 --hash | cmp - "$prefix/out" || fail "a game of its own plays otherwise"
fi
