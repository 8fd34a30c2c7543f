#!/bin/sh
# usage: hostile.sh PROGRAM FOLDER LIMIT SLACK [NAME...]
# Games that never end. Each FOLDER/NAME.lua is a game's main.lua; without NAMEs all of them are played, two at a time. With a time limit of
# LIMIT seconds each must end, within the limit and SLACK seconds more, with exit status 1 and a message. Where the first line of the file says
# "-- CALLBACK: …", the message must name that callback. Without FOLDER the test is skipped.
set -u

program=$1 folder=$2 limit=$3 slack=$4
shift 4
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
[ -d "$folder" ] || { echo "skipped: there is no $folder" && exit 77; }
command -v timeout >/dev/null || { echo "skipped: there is no timeout" && exit 77; }

complain() {
    echo "$1: $2"
    sed 's/^/    /;5q' "$out/$1/said"
    : >"$out/bad"
}

# Plays one game. Of its output only what it says on standard error is kept.
play_once() {
    timeout -s KILL $((limit + slack)) "$program" play "$out/$1" --headless --ticks 60 --hash --time-limit "$limit" 2>"$out/$1/said" >/dev/null
    status=$?
}

# A machine that is busy with other things gets a second chance.
play() {
    game=$out/$1
    mkdir "$game"
    cp "$folder/$1.lua" "$game/main.lua"
    play_once "$1"
    [ "$status" != 137 ] || play_once "$1"
    named=$(sed -n '1s/^-- \([^:]*\): .*/\1/p' "$game/main.lua")
    if [ "$status" = 137 ]; then
        complain "$1" "it is still there after $((limit + slack)) s"
    elif [ "$status" != 1 ]; then
        complain "$1" "exit status $status, not 1"
    elif ! grep -q "^daft: .*$named" "$game/said"; then
        complain "$1" "no message that names '$named'"
    fi
    rm "$game/main.lua"
}

if [ $# = 0 ]; then
    for file in "$folder"/*.lua; do
        name=${file##*/}
        set -- "$@" "${name%.lua}"
    done
fi
count=$#
while [ $# -gt 0 ]; do
    play "$1" &
    if [ $# -gt 1 ]; then
        play "$2"
        shift
    fi
    shift
    wait
done
[ ! -e "$out/bad" ] || exit 1
echo "$count games that never end: each was stopped"
