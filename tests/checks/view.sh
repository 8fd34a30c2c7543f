#!/bin/sh
# usage: view.sh PROGRAM
# daft view in a real window, on an X server without a screen, with real keys and a real mouse: it flies, toggles, finds what is under the cursor,
# opens each kind of file, leaves by Esc and by the close button, and refuses what it cannot show. Skipped without Xvfb and xdotool.
set -u

program=$1
root=$(cd "$(dirname "$0")/../.." && pwd)
for tool in Xvfb xdotool; do
    command -v "$tool" >/dev/null || { echo "skipped: there is no $tool" && exit 77; }
done
out=$(mktemp -d)
server=
viewer=
trap 'kill $server $viewer 2>/dev/null; rm -rf "$out"' EXIT

fail() {
    echo "$*"
    cat "$out/said"
    exit 1
}

# refuse WORDS ARGUMENTS...: the program ends with status 1 and one message that has these words.
refuse() {
    words=$1
    shift
    "$program" view "$@" >"$out/said" 2>&1
    [ $? -eq 1 ] || fail "$*: status 1 expected"
    grep -q "$words" "$out/said" && [ "$(wc -l <"$out/said")" -eq 1 ] || fail "$*: one message with '$words' expected"
}

(unset DISPLAY WAYLAND_DISPLAY SDL_VIDEODRIVER && refuse 'there is no display' "$root/assets/scenes/hello.scene") || exit 1

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

refuse 'missing.scene' "$out/missing.scene"
printf 'camera 0 0 0\nlihgt 1\n' >"$out/bad.scene"
refuse 'bad.scene:2:1: ' "$out/bad.scene"
printf 'no picture' >"$out/bad.png"
refuse 'bad.png' "$out/bad.png"

# open FILE: waits for the window.
open() {
    "$program" view "$1" --size 400x300 >"$out/said" 2>&1 &
    viewer=$!
    window=$(timeout 20 xdotool search --sync --onlyvisible --pid "$viewer" 2>/dev/null | head -n 1)
    [ -n "$window" ] || fail "$1: no window"
    xdotool windowfocus "$window"
    sleep 0.5
}

# leave WHAT: the viewer ends with status 0 and without a word.
leave() {
    wait "$viewer" || fail "$1: exit status $?"
    viewer=
    [ -s "$out/said" ] && fail "$1: it says something"
    echo "$1: left"
}

# Processor time of the viewer, in hundredths of a second.
used() { awk '{ print $14 + $15 }' "/proc/$viewer/stat"; }

# Once the picture is as fine as it gets, a window in which nothing moves rests.
rests() {
    [ -r "/proc/$viewer/stat" ] || return 0
    for _ in 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25 26 27 28 29 30; do
        before=$(used)
        sleep 1
        [ $(($(used) - before)) -ge 50 ] || return 0
    done
    fail "a window in which nothing moves keeps a processor busy"
}

open "$root/assets/scenes/hello.scene"
case $(xdotool getwindowname "$window") in *hello.scene*) ;; *) fail "the title does not name the file" ;; esac
for key in i i r r t t y y k k l l x x g 2 3 4 5 6 1 g F1 F1 h question Home F5; do xdotool key "$key"; done
xdotool keydown w && sleep 0.3 && xdotool keyup w keydown Shift keydown e && sleep 0.2 && xdotool keyup e keyup Shift
xdotool mousemove 200 200 click 1 click 4 click 5 mousedown 1 mousemove 260 220 mouseup 1 mousedown 3 mousemove 220 180 mouseup 3
xdotool key o keydown a && sleep 0.2 && xdotool keyup a key o key Escape
leave scene
open "$root/assets/meshes/cup.obj"
rests
xdotool windowquit "$window" 2>/dev/null || xdotool key Escape
leave mesh
open "$root/assets/textures/checker.png"
xdotool mousemove 200 200 click 4 click 1 mousedown 1 mousemove 250 210 mouseup 1 key Escape
leave picture
