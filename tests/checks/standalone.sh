#!/bin/bash
# usage: standalone.sh PROGRAM
# A game that is packed as a program of its own: it plays as in DAFT, where nothing is but what a desktop has, and wherever
# its cache is, is full, was damaged or is being made by another. Where a file system can be entered that has the desktop's
# libraries alone (chroot), it is run there; elsewhere the linker is asked which libraries it would load.
set -u

program=$1
root=$(CDPATH='' cd -- "$(dirname -- "$0")/../.." && pwd)
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
cd "$out" || exit 1
mkdir cache
export XDG_CACHE_HOME=$out/cache TMPDIR=$out DAFT_HOME=$root
bad=0

wrong() { echo "$1" && bad=1; }
# fails STATUS WORDS COMMAND...: it ends with the status and one line that has the words.
fails() {
    local want=$1 words=$2 status
    shift 2
    "$@" >said 2>&1
    status=$?
    if [ $status != "$want" ] || ! grep -q "$words" said; then wrong "$*: status $status, and not '$words':" && cat said; fi
}
# same WHAT COMMAND...: prints what `daft play` prints.
same() {
    local what=$1
    shift
    "$@" --headless --ticks 60 --hash >got 2>said || { wrong "$what: fails:" && cat said; }
    cmp -s wanted got || { wrong "$what: plays otherwise:" && cat wanted got said; }
}

# ---- packing ----

mkdir game
printf '%s\n' '-- Figure: stands' 'function daft.load() daft.entity { mesh = "meshes/figure.glb" } end' >game/main.lua
"$program" play game --headless --ticks 1 >/dev/null 2>&1 || # a build without Assimp
    printf 'function daft.load() daft.entity { sphere = 1 } end\n' >game/main.lua
"$program" pack game --standalone -o one >packed 2>said || { cat said && exit 1; }
"$program" pack game --standalone -o two >/dev/null && cmp -s one two || wrong "packing twice gives other bytes"
"$program" pack game -o game.daft >/dev/null
"$program" pack game.daft --standalone -o two >/dev/null && cmp -s one two || wrong "a packed game gives other bytes"
"$program" play game.daft --headless --ticks 60 --hash >wanted 2>/dev/null || wrong "the game does not play"
[ -x one ] || wrong "it is no program"
[ "$(stat -c %s one)" -lt 25000000 ] || wrong "it has $(stat -c %s one) bytes"
for library in SDL2-2.0 lua; do grep -q "^carries:.* lib$library" packed || wrong "it carries no $library"; done
grep -E '^carries:.* lib(av|sw|mpi|X11|asound|pulse|GL|c\.|stdc)' packed && wrong "it carries what it should not"
grep -q "^needs: Linux on $(uname -m)" packed || wrong "it does not say what it needs"
fails 1 'cannot open for writing' "$program" pack game --standalone -o nowhere/game
fails 1 'is a folder' "$program" pack game --standalone -o cache
fails 2 'cannot end in .daft' "$program" pack game --standalone -o a.daft
fails 2 'is missing' "$program" pack game --standalone
cp "$program" alone
fails 1 'daft_stub, which is neither' ./alone pack game --standalone -o three
[ ! -e three ] || wrong "a program without a beginning was written"

# ---- playing ----

unset DAFT_HOME
same "at first" ./one
same "from the cache" ./one
hash=$(ls cache/daft)
folder=cache/daft/$hash
fails 2 'no option' ./one --nonsense
./one --help | grep -q headless || wrong "arguments do not reach it"
DAFT_HOME=/nowhere same "another DAFT_HOME" ./one
PATH=$out:$PATH same "found by PATH" one

# What the dynamic linker would load: what is carried from the cache, and nothing else but what a desktop has.
carried=$(sed -n 's/^carries: //p' packed)
LD_LIBRARY_PATH=$out/$folder/lib LD_TRACE_LOADED_OBJECTS=1 "$folder/daft" >loads
for name in $carried; do
    [ -e "$folder/lib/$name" ] || wrong "$name is not there"
    ! grep -q "^[[:space:]]$name => " loads || grep -q "^[[:space:]]$name => $out/$folder/lib/$name " loads ||
        wrong "$name is loaded from elsewhere"
done

# A system that has no more than a desktop: the libraries that `needs` lists, and what these need.
mkdir -p desktop/tmp
needed=$(sed -n 's/^needs:.*one: //p' packed)
for name in $needed; do
    path=$(awk -v n="$name" '$1 == n && $3 ~ /^\// { print $3 } $1 ~ "/" n "$" { print $1 }' loads)
    [ -n "$path" ] || continue # the program does not load it itself
    { echo "$path" && ldd "$path" | awk '$3 ~ /^\// { print $3 } $1 ~ /^\// { print $1 }'; } >>desktop.list
done
sort -u desktop.list | while read -r path; do mkdir -p "desktop$(dirname "$path")" && cp -L "$path" "desktop$path"; done
find desktop -name 'libSDL*' -o -name 'liblua*' -o -name 'libassimp*' | grep . && wrong "that is no bare desktop"
cp one desktop/tmp/game
enter=
for way in '' 'unshare -r'; do # shellcheck disable=SC2086 # words
    [ -n "$enter" ] || ! XDG_CACHE_HOME=/tmp $way chroot desktop /tmp/game --help >said 2>&1 || enter="$way chroot desktop"
done
# shellcheck disable=SC2086 # words
if [ -n "$enter" ]; then
    same "on a bare desktop" env XDG_CACHE_HOME=/tmp $enter /tmp/game
    [ -d "desktop/tmp/daft/$hash" ] || wrong "a bare desktop has no cache"
    mv "desktop/tmp/daft/$hash/lib" desktop/tmp/gone
    fails 127 'shared librar' env DAFT_HOME="/tmp/daft/$hash" $enter "/tmp/daft/$hash/daft" version
else
    echo "no chroot here: whether it runs on a bare desktop is known from the linker's list alone"
fi

# ---- the cache ----

rm "$folder/scripts/"*.lua
same "a cache without some files" ./one
[ "$(ls -A cache/daft)" = "$hash" ] || wrong "more than one folder in the cache: $(ls -A cache/daft)"
: >"$folder/daft"
same "a cache with an empty program" ./one

rm -rf cache/daft
for i in 1 2 3 4; do ./one --headless --ticks 60 --hash >"got$i" 2>"said$i" & done
wait
for i in 1 2 3 4; do cmp -s wanted "got$i" || { wrong "four at once: plays otherwise:" && cat "said$i"; }; done
[ "$(ls -A cache/daft)" = "$hash" ] || wrong "four at once leave: $(ls -A cache/daft)"

rm -rf cache/daft
for delay in 0.02 0.05 0.08 0.12 0.2; do
    ./one --headless --ticks 1 >/dev/null 2>&1 &
    sleep $delay
    kill -9 $! 2>/dev/null
    wait $! 2>/dev/null
done
rm -rf "$folder" # the last may have come to its end
mkdir cache/daft/.unpack-leftov
find cache/daft -maxdepth 1 -name '.unpack-*' -exec touch -d '2 hours ago' {} +
same "after some that were killed" ./one
[ "$(ls -A cache/daft)" = "$hash" ] || wrong "killed ones leave: $(ls -A cache/daft)"

# No cache: a temporary folder, which goes, and the game's exit status.
XDG_CACHE_HOME=/dev/null same "no cache" ./one
XDG_CACHE_HOME=/dev/null fails 2 'no option' ./one --nonsense
env -u HOME -u XDG_CACHE_HOME "$out/one" --headless --ticks 60 --hash >got 2>said && cmp -s wanted got || wrong "no home"
ls -d daft-* 2>/dev/null && wrong "temporary folders are left"
if unshare -rm true 2>/dev/null; then
    mkdir full
    unshare -rm sh -c 'mount -t tmpfs -o size=4m none full && XDG_CACHE_HOME=$PWD/full ./one --headless --ticks 60 --hash &&
        ls -A full/daft >&2' >got 2>said || { wrong "a full cache: fails:" && cat said; }
    cmp -s wanted got || { wrong "a full cache: plays otherwise" && cat said; }
    grep -q unpack said && wrong "a full cache: parts are left"
    unshare -rm sh -c 'mount -t tmpfs -o noexec none full && XDG_CACHE_HOME=$PWD/full ./one --headless --ticks 60 --hash' \
        >got 2>said && cmp -s wanted got || { wrong "a cache where no program may be started: fails:" && cat said; }
fi

# ---- damage ----

size=$(stat -c %s one)
head -c $((size - 1000)) one >cut && chmod +x cut
fails 1 'is not whole' ./cut --headless --ticks 1
cp one changed
printf x | dd of=changed bs=1 seek=$((size / 2)) conv=notrunc 2>/dev/null
digit=$(tail -c 64 one | head -c 1) # of the name in the cache, which has the file as it was
printf %s "$([ "$digit" = 0 ] && echo 1 || echo 0)" | dd of=changed bs=1 seek=$((size - 64)) conv=notrunc 2>/dev/null
fails 1 'is damaged' ./changed --headless --ticks 1
[ "$(ls -A cache/daft)" = "$hash" ] || wrong "what is damaged is unpacked"

[ $bad = 0 ] && echo "a game of $((size / 1000000)) MB runs by itself${enter:+, also on a bare desktop}"
exit $bad
