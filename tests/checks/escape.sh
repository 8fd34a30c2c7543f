#!/bin/sh
# usage: escape.sh PROGRAM
# A real window, on an X server without a screen: Esc closes it at once while the game is stuck in a callback, wherever that is, and the recording
# is saved; else it opens the pause menu. Skipped without Xvfb and xdotool.
set -u

program=$1
for tool in Xvfb xdotool; do
    command -v "$tool" >/dev/null || { echo "skipped: there is no $tool" && exit 77; }
done
out=$(mktemp -d)
server=
game=
trap 'kill $server $game 2>/dev/null; rm -rf "$out"' EXIT

Xvfb -displayfd 3 -screen 0 800x600x24 3>"$out/display" 2>/dev/null &
server=$!
for _ in 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20; do
    [ -s "$out/display" ] && break
    sleep 0.5
done
[ -s "$out/display" ] || { echo "skipped: Xvfb does not start" && exit 77; }
DISPLAY=:$(cat "$out/display")
export DISPLAY SDL_AUDIODRIVER=dummy
export ASAN_OPTIONS=detect_leaks=0 # of the window system's libraries, which keep things for the whole process
unset WAYLAND_DISPLAY SDL_VIDEODRIVER

now_ms() { echo $(($(date +%s%N) / 1000000)); }

# start NAME LUA: plays the game; `window` is its window.
start() {
    mkdir "$out/$1"
    printf '%s\n' "$2" >"$out/$1/main.lua"
    "$program" play "$out/$1" --size 320x180 --time-limit 60 --record "$out/$1.rec" --saves "$out" 2>"$out/said" &
    game=$!
    window=$(timeout 20 xdotool search --sync --onlyvisible --pid "$game" 2>/dev/null | head -n 1)
    [ -n "$window" ] || { echo "$1: no window" && exit 1; }
}

# leave NAME KEYS: presses them, and waits for the window to go.
leave() {
    began=$(now_ms)
    # shellcheck disable=SC2086 # a list of keys
    xdotool windowfocus "$window" key $2 2>/dev/null
    while xdotool getwindowname "$window" >/dev/null 2>&1 && xdotool search --onlyvisible --pid "$game" >/dev/null 2>&1; do
        [ $(($(now_ms) - began)) -lt 5000 ] || { echo "$1: $2 does not close the window" && exit 1; }
    done
    echo "$1: $(($(now_ms) - began)) ms, of which xdotool takes some"
    wait "$game" || { echo "$1: exit status $?" && cat "$out/said" && exit 1; }
    game=
    tail -n 1 "$out/$1.rec" | grep -q '^end ' || { echo "$1: no recording" && exit 1; }
}

# try NAME LUA SECONDS: presses Esc after so many seconds.
try() {
    start "$1" "$2"
    sleep "$3"
    leave "$1" Escape
}

try load 'function daft.load() while true do end end' 1
try update 'function daft.update() if daft.tick() == 30 then pcall(function() while true do end end) end end' 1.5
try draw 'function daft.draw() if daft.tick() >= 30 then while true do end end end' 1.5
try pattern 'function daft.update() if daft.tick() == 30 then ("a"):rep(60):find(("a-"):rep(25) .. "c") end end' 1.5
try library 'local a = ("\0"):rep(60000000)
local b = a .. "x"
function daft.update() while daft.tick() == 30 do local less = a < b end end' 2.5

# A game that works pauses, and its menu's last row leaves.
start fine 'function daft.update() end'
sleep 1
xdotool windowfocus "$window" key Escape
sleep 0.5
kill -0 "$game" 2>/dev/null || { echo "fine: Esc does not open the menu" && exit 1; }
leave fine 'Up Return'
