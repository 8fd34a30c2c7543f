#!/bin/sh
# usage: modules.sh PROGRAM
# The libraries of films and of MPI are not loaded with the program, but with its modules; where one is missing, what needs
# it says so in one line with the package, and all else works.
set -u

program=$1
root=$(CDPATH='' cd -- "$(dirname -- "$0")/../.." && pwd)
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
export DAFT_HOME="$root"
scene=$root/assets/scenes/hello.scene
bad=0

wrong() { echo "$1" && bad=1; }

# fails WORDS ARGUMENT...: status 1, one line that has the words, and nothing written.
fails() {
    words=$1
    shift
    "$program" "$@" >"$out/said" 2>&1
    status=$?
    [ $status = 1 ] && [ "$(wc -l <"$out/said")" = 1 ] && grep -q "$words" "$out/said" ||
        { wrong "$*: status $status, and not one line that says '$words':" && cat "$out/said"; }
    [ ! -e "$out/film.mp4" ] && [ ! -e "$out/picture.png" ] || wrong "$*: writes a file"
}

needs() { readelf -d "$1" | grep NEEDED; }
if command -v readelf >/dev/null; then
    needs "$program" | grep -E 'lib(av|sw|mpi)' && wrong "the program is linked with these"
    for name in film mpi; do
        module=$(dirname "$program")/daft_$name.so
        [ ! -e "$module" ] || needs "$module" | grep -q 'lib\(avcodec\|mpi\)' || wrong "$module is linked with nothing"
        nm -D --defined-only "$module" 2>/dev/null | grep -v " \(__odr_asan\.\)*daft_$name\$" && wrong "$module exports this"
    done
fi

cp "$program" "$out/daft"
program=$out/daft
fails 'without FFmpeg.*install libavcodec-dev' video "$scene" -o "$out/film.mp4" --to 1
export OMPI_COMM_WORLD_SIZE=2 OMPI_COMM_WORLD_RANK=0
fails 'without MPI.*install.*libopenmpi-dev' render "$scene" -o "$out/picture.png"
echo 'no library' >"$out/daft_film.so"
echo 'no library' >"$out/daft_mpi.so"
fails 'MPI, which cannot be loaded: install.*libopenmpi' render "$scene" -o "$out/picture.png"
unset OMPI_COMM_WORLD_SIZE OMPI_COMM_WORLD_RANK
fails 'FFmpeg, which cannot be loaded: install.*ffmpeg' video "$scene" -o "$out/film.mp4" --to 1
"$program" video "$scene" -o "$out/a%d.png" --to 0.1 --fps 10 --size 32x18 >"$out/said" 2>&1 && [ -e "$out/a0.png" ] ||
    { wrong "numbered pictures need no module, but:" && cat "$out/said"; }

[ $bad = 0 ] && echo "what FFmpeg and MPI need is loaded with them"
exit $bad
