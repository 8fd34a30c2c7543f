#!/bin/sh
# usage: docs.sh PROGRAM BUILD_FOLDER C_COMPILER SANITIZERS
# The examples of README.md and docs/ do what they say: Lua is played, scenes are rendered, C is compiled and run.
# And the manual leaves out no function that a game can call, and no option of a command.
set -eu

program=$1
build=$2
cc=$3
extra=${4:+-fsanitize=$4}
root=$(CDPATH='' cd -- "$(dirname -- "$0")/../.." && pwd)
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
passed=0

fail() { echo "$*" && cat "$out/log" && exit 1; }

# Every block between ```LANGUAGE and ``` becomes FILE-NUMBER.LANGUAGE. One of Lua whose first line is "-- FOLDER/FILE.lua" or
# "-- FILE.lua" is a file of the game before it; files of tests/ are then run by daft test-game.
for page in "$root/README.md" $(find "$root/docs" -name "*.md"); do
    awk -v out="$out/$(basename "$page" .md)" '
        /^```$/ { name = "" }
        name != "" { print > name }
        /^```(lua|scene|c)$/ { name = sprintf("%s-%d.%s", out, ++count, substr($0, 4)) }' "$page"
done

game=
for example in $(find "$out" -maxdepth 1 -name '*.lua' | sort -V); do
    file=$(sed -n '1s/^-- \([a-z_]*\/\{0,1\}[a-z_]*\.lua\)$/\1/p' "$example")
    if [ -n "$file" ]; then
        mkdir -p "$(dirname "$game/$file")" && mv "$example" "$game/$file"
        continue
    fi
    game=${example%.lua}
    mkdir "$game" && mv "$example" "$game/main.lua"
done

for game in "$out"/*/main.lua; do
    game=$(dirname "$game")
    DAFT_HOME=$root "$program" play "$game" --headless --ticks 90 >"$out/log" 2>&1 ||
        fail "the example $(basename "$game") fails: $(cat "$game/main.lua")"
    passed=$((passed + 1))
    [ -d "$game/tests" ] || continue
    # Pictures that are written stand the test when it runs again.
    for update in --update ""; do
        # shellcheck disable=SC2086 # an option or none
        DAFT_HOME=$root "$program" test-game "$game" $update >"$out/log" 2>&1 || fail "the tests of $(basename "$game") fail"
    done
    passed=$((passed + 1))
done

mkdir -p "$out/assets/scenes"
ln -s "$root/assets/meshes" "$root/assets/sky" "$root/assets/textures" "$out/assets/"
for example in "$out"/*.scene; do
    mv "$example" "$out/assets/scenes/"
    "$program" render "$out/assets/scenes/$(basename "$example")" -o "$out/picture.png" --size 64x36 >"$out/log" 2>&1 ||
        fail "the scene $(basename "$example") does not render"
    passed=$((passed + 1))
done

cmake --install "$build" --prefix "$out/usr" >"$out/log"
PKG_CONFIG_PATH=$(dirname "$(find "$out/usr" -name daft.pc)")
export PKG_CONFIG_PATH
for example in "$out"/*.c; do
    # shellcheck disable=SC2046,SC2086 # lists of flags
    "$cc" -std=c11 -Wall -Wextra -Werror $extra -o "$out/example" "$example" $(pkg-config --cflags --libs daft) \
        >"$out/log" 2>&1 || fail "$(basename "$example") does not compile"
    (cd "$out" && ./example >"$out/log" 2>&1) || fail "$(basename "$example") fails"
    passed=$((passed + 1))
done

# `daft help lua` is printed from the tables that the functions are registered from.
"$program" help lua >"$out/log"
sed -n 's/^  \(daft\.[a-z_.]*\|[a-z]*:[a-z_]*\).*/\1/p' "$out/log" | sort -u >"$out/names"
while read -r name; do
    case $name in *:*) name=:${name#*:} ;; esac
    grep -qF -- "$name" "$root/docs/reference/lua-api.md" || fail "docs/reference/lua-api.md leaves out $name"
    passed=$((passed + 1))
done <"$out/names"
[ "$(wc -l <"$out/names")" -gt 50 ] || fail "the program names too few functions"
# And the page's tables name no other: `daft.NAME(` and `e:NAME(` in the first column, whatever the variable is called.
# The callbacks and `daft.NAME {` stand in the text.
awk -F'|' '/^\| *`/ { print $2 } /^### daft/ { print $0 "(" }' "$root/docs/reference/lua-api.md" |
    grep -o '\(daft\.[a-z_.]*\|[a-z]*:[a-z_]*\) *[({]' | sed 's/ *[({]$//' | sort -u >"$out/written"
while read -r name; do
    case $name in *:*) name=".*:${name#*:}" ;; *) name=$(echo "$name" | sed 's/\./\\./g') ;; esac
    grep -qx -- "$name" "$out/names" || fail "docs/reference/lua-api.md has $name, which the program does not"
    passed=$((passed + 1))
done <"$out/written"
[ "$(wc -l <"$out/written")" -gt 50 ] || fail "docs/reference/lua-api.md has too few functions in its tables"
# scripts/daft.d.lua: `any` stands only where a game may give anything, and every type that is named there is made there.
sed -n -e 's/^---@\(param\|field\) [a-z_.]*? *//p' -e 's/^---@\(param\|field\) [a-z_.]* *//p' -e 's/^---@return //p' \
    -e 's/^---@overload //p' -e 's/^---@alias [a-z.]* //p' "$root/scripts/daft.d.lua" >"$out/types"
anything=$(grep -cE '^any( |$)|\|any|any\||: any' "$out/types")
[ "$anything" = 5 ] || fail "scripts/daft.d.lua: any stands $anything times, not 5: e.data twice, what daft.start passes on, what daft.keep gives and daft.reload gets"
grep -oE '\bdaft\.[a-z_.]+' "$out/types" | sed 's/\.$//' | sort -u >"$out/named"
sed -nE 's/^---@(class|alias) (daft\.[a-z_.]+).*/\2/p' "$root/scripts/daft.d.lua" | sort -u >"$out/made"
while read -r type; do
    grep -qxF -- "$type" "$out/made" || grep -qF "function $type(" "$root/scripts/daft.d.lua" || fail "scripts/daft.d.lua: there is no type $type"
done <"$out/named"
# docs/reference/command-line.md names the options that `--help` prints, no more and no fewer.
page=$root/docs/reference/command-line.md
for command in play render check new test-game bench test; do
    case $command in
    bench) help=$build/tests/daft_bench ;;
    test) help="$root/daft test" ;;
    *) help="$program $command" ;;
    esac
    $help --help >"$out/log" 2>&1 || fail "daft $command --help fails"
    [ "$command" != test ] || sed -i '/^  .*test/,/^  [^ ]*daft [^t]/!d' "$out/log"
    grep -o -- '--[a-z][a-z-]*' "$out/log" | grep -vx -- '--help' | sort -u >"$out/accepted"
    awk -v head="$command" '/^## / { on = ($0 ~ "daft " head "( |$)") } on && /^\|/' "$page" |
        grep -o -- '`-[^`]*`' | grep -o -- '--[a-z][a-z-]*' | sort -u >"$out/written"
    sed -i '/^--output$/d' "$out/accepted" # written as -o
    diff "$out/accepted" "$out/written" >"$out/log" ||
        fail "command-line.md and daft $command --help differ (< accepted, > written)"
    passed=$((passed + 1))
done
echo "[  PASSED  ] $passed test(s)"
