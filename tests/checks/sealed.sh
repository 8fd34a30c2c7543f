#!/bin/sh
# usage: sealed.sh PROGRAM
# Games that try to read what lies outside their folder: by names, by links, and through every file that names another. None of them may show a word
# of it, read it, or hang; each ends with one line that says why. Odd files in their way do no harm either.
set -u

program=$1
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
bad=0
printf 'camera 0 0 0\nTOPSECRET words here\n' >"$out/secret"
printf 'newmtl TOPSECRET\nKd 1 0 0\n' >"$out/secret.mtl"
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n' >"$out/secret.obj"
printf 'return "TOPSECRET"\n' >"$out/secret.lua"

# game NAME LUA: a folder with a main.lua, left in $game.
game() {
    game=$out/$1
    mkdir "$game"
    printf '%s\n' "$2" >"$game/main.lua"
}

# fails NAME WORDS: the game ends within ten seconds with status 1, says the words, and nothing secret.
fails() {
    timeout 10 "$program" play "$game" --headless --ticks 3 >"$out/said" 2>&1
    status=$?
    [ $status = 1 ] || { echo "$1: exit status $status" && cat "$out/said" && bad=1; }
    grep -q "$2" "$out/said" || { echo "$1: does not say '$2':" && cat "$out/said" && bad=1; }
    grep -q TOPSECRET "$out/said" && echo "$1: tells what is outside" && bad=1
    timeout 20 "$program" check "$game" >"$out/checked" 2>&1
    [ $? = 1 ] || { echo "$1: daft check finds nothing" && bad=1; }
    grep -q TOPSECRET "$out/checked" && echo "$1: daft check tells what is outside" && bad=1
    return 0
}

game include_up 'function daft.load() daft.scene("a.scene") end'
printf 'include ../secret\n' >"$game/a.scene"
fails include_up 'leads outside'
game include_absolute 'function daft.load() daft.scene("a.scene") end'
printf 'include %s/secret\n' "$out" >"$game/a.scene"
fails include_absolute 'leads outside'
game include_link 'function daft.load() daft.scene("a.scene") end'
printf 'include b.scene\n' >"$game/a.scene"
ln -s ../secret "$game/b.scene"
fails include_link 'symbolic link'
game scene_link 'function daft.load() daft.scene("a.scene") end'
ln -s ../secret "$game/a.scene"
fails scene_link 'there is no file'
game folder_link 'function daft.load() daft.scene("in/a.scene") end'
ln -s .. "$game/in"
cp "$out/secret" "$out/a.scene"
fails folder_link 'there is no file'
game sphere_material 'function daft.load() daft.scene("a.scene") end'
printf 'sphere 0 0 0 1 ../secret.mtl#x\n' >"$game/a.scene"
fails sphere_material 'leads outside'
game scene_mesh 'function daft.load() daft.scene("a.scene") end'
printf 'mesh ../secret.obj 0 0 0\n' >"$game/a.scene"
fails scene_mesh 'leads outside'
game scene_sky 'function daft.load() daft.scene("a.scene") end'
printf 'skybox ../secret\n' >"$game/a.scene"
fails scene_sky 'leads outside'
game require_link 'print(require("a"))'
ln -s ../secret.lua "$game/a.lua"
fails require_link "there is no 'a.lua'"
game main_link ''
rm "$game/main.lua"
ln -s ../secret.lua "$game/main.lua"
fails main_link 'symbolic link'
game texture_link 'function daft.load() daft.material { texture = "a" } end'
mkdir "$game/textures"
ln -s ../../secret "$game/textures/a.png"
fails texture_link 'there is no texture'
game mesh_library 'function daft.load() daft.entity { mesh = "a.obj" } error("went on") end'
printf 'mtllib ../secret.mtl\nusemtl TOPSECRET2\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n' >"$game/a.obj"
sed -i s/TOPSECRET2/other/ "$game/a.obj"
fails mesh_library 'went on'

# Odd files where a game names one.
game fifo 'function daft.load() daft.scene("a.scene") end'
mkfifo "$game/a.scene"
fails fifo 'there is no file'
game fifo_inside 'function daft.load() daft.scene("a.scene") end'
printf 'include b.scene\n' >"$game/a.scene"
mkfifo "$game/b.scene"
fails fifo_inside 'is a pipe'
game sparse 'function daft.load() daft.scene("a.scene") end'
truncate -s 1T "$game/a.scene" 2>/dev/null && fails sparse 'there is no file'

# Odd files that the user names: one line, no waiting, no control characters.
mkfifo "$out/pipe" "$out/fifo.scene" "$out/fifo.rec" "$out/fifo.obj"
mkdir "$out/folder.scene"
newline=$(printf '%s/a\nb\033[2J.scene' "$out")
printf 'nonsense\n' >"$newline"
game quiet ''
# odd WORDS COMMAND...: as `fails`, for a command of the program.
odd() {
    words=$1
    shift
    timeout 10 "$program" "$@" >"$out/said" 2>&1
    status=$?
    [ $status = 1 ] || { echo "$*: exit status $status" && cat "$out/said" && bad=1; }
    grep -q "$words" "$out/said" || { echo "$*: does not say '$words':" && cat "$out/said" && bad=1; }
    LC_ALL=C grep -q "$(printf '\033')" "$out/said" && echo "$*: prints control characters" && bad=1
    return 0
}
odd 'is a pipe' render "$out/fifo.scene" -o "$out/a.png"
odd 'is a directory' render "$out/folder.scene" -o "$out/a.png"
odd 'a\\nb\\x1b\[2J.scene:1' render "$newline" -o "$out/a.png"
odd 'a\\nb\\x1b\[2J.scene:1' check "$newline"
odd 'is a pipe' check "$out/fifo.obj"
odd 'is a pipe' check "$out/fifo.rec"
odd 'is a pipe' play "$game" --headless --replay "$out/fifo.rec"
odd 'is a directory' play "$game" --headless --replay "$out/folder.scene"
odd 'there is no' play "$out/pipe" --headless
odd 'there is no' play "$newline-no" --headless
odd . video "$out/fifo.scene" -o "$out/a.mp4"

[ $bad = 0 ] && echo "nothing outside a game's folder is read"
exit $bad
