#!/bin/bash
# usage: many.sh PROGRAM
# Several processes make a film or a picture together: the bytes of one process, whichever their number; a process that
# fails is named, one that is killed ends the job and loses nothing that was finished. Skipped without mpirun.
set -u

program=$1
root=$(CDPATH='' cd -- "$(dirname -- "$0")/../.." && pwd)
command -v mpirun >/dev/null || { echo "skipped: there is no mpirun" && exit 77; }
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
cd "$out" || exit 1
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_rmaps_base_oversubscribe=1
export OMPI_MCA_orte_abort_print_stack=0 ASAN_OPTIONS=detect_leaks=0 # MPI's own
export OMPI_MCA_plm=isolated OMPI_MCA_btl_vader_single_copy_mechanism=none # neither ssh nor rights that containers lack
mpirun -n 2 true >log 2>&1 || { echo "skipped: mpirun does not work here: $(grep -v '^-*$' log | head -n 1)" && exit 77; }
scene=$root/assets/scenes/temple.scene
flight=$root/assets/scenes/town.scene
failed=0

wrong() {
    echo "[  FAILED  ] $1"
    [ ! -s log ] || head -20 log
    failed=1
}
many() { # many N ARGUMENT...
    local n=$1
    shift
    timeout 300 mpirun -n "$n" "$program" "$@" >log 2>&1
}
same() { # same WHAT FILE FILE
    cmp -s "$2" "$3" || wrong "$1: not the bytes of one process"
}

many 2 video "$scene" -o x.png >/dev/null # a name without a number
if grep -q 'built without MPI' log; then echo "skipped: built without MPI" && exit 77; fi
grep -q 'number of the picture' log || wrong "what process 0 says is heard"
[ "$(grep -c 'number of the picture' log)" = 1 ] || wrong "what all would say is heard once"

# Films: clips of which the last is short; pictures; raw frames; a game that ends before the film does.
small='--size 64x36 --fps 10 --threads 1'
film() { "$program" video "$@" >log 2>&1 || wrong "video $*"; }
if "$program" video "$flight" -o one.mp4 $small --to 5 2>log; then
    for n in 2 4; do
        many $n video "$flight" -o "many$n.mp4" $small --to 5 || wrong "$n processes, mp4"
        same "$n processes, mp4" one.mp4 "many$n.mp4"
        [ ! -e "many$n.mp4.parts" ] || wrong "$n processes, mp4: parts are left"
    done
    film marble --to 40 -o game.mp4 $small
    many 3 video marble --to 40 -o game3.mp4 $small || wrong "3 processes, a game"
    same "3 processes, a game that ends" game.mp4 game3.mp4

    # One is killed: nothing stands under the film's name, and the same call goes on.
    long='--size 160x90 --fps 10 --to 20 --threads 1 --quality high'
    many 3 video "$flight" -o cut.mp4 $long &
    job=$!
    for _ in $(seq 2000); do
        [ -z "$(ls cut.mp4.parts/0* 2>/dev/null)" ] || break
        sleep 0.02
    done
    pkill -9 -n -f "$program video $flight -o cut.mp4"
    wait $job && wrong "a process was killed, and the job ends well"
    [ ! -e cut.mp4 ] || wrong "a process was killed, and there is a film"
    [ -n "$(ls cut.mp4.parts/0* 2>/dev/null)" ] || wrong "a process was killed, and finished parts are gone"
    many 2 video "$flight" -o cut.mp4 $long || wrong "going on after a kill"
    grep -q 'took over' log || wrong "going on after a kill: nothing is taken over"
    film "$flight" -o whole.mp4 $long
    same "going on after a kill" whole.mp4 cut.mp4
else
    grep -q 'without FFmpeg' log || wrong "video"
fi
film "$flight" -o one%02d.png $small --to 1
many 3 video "$flight" -o many%02d.png $small --to 1 || wrong "3 processes, pictures"
for picture in one*.png; do same "3 processes, pictures" "$picture" "many${picture#one}"; done
"$program" video "$flight" -o - $small --to 1 >one.raw 2>log
timeout 300 mpirun -n 3 "$program" video "$flight" -o - $small --to 1 >many.raw 2>log
same "3 processes, raw frames" one.raw many.raw

# Pictures in bands, with everything that is kept of a pixel.
"$program" render "$scene" -o one.png --size 333x301 --quality high --aov depth,normal,id,triangle >log 2>&1
for n in 1 2 4; do
    many $n render "$scene" -o "band$n.png" --size 333x301 --quality high --aov depth,normal,id,triangle
    for part in png depth.pfm normal.pfm id.png triangle.png; do same "$n processes, $part" "one.$part" "band$n.$part"; done
done

# What goes wrong elsewhere is told with the process it happened to.
timeout 300 mpirun -n 1 "$program" render "$scene" -o bad.png : -n 1 "$program" render nothere.scene -o bad.png >log 2>&1 &&
    wrong "one process has no scene, and the job ends well"
grep -q 'process 1 on .*nothere.scene: cannot open' log || wrong "the failure of process 1 is not told"
[ ! -e bad.png ] || wrong "the failure of process 1 leaves a picture"
many 2 render "$scene" -o nowhere/x.png && wrong "a folder that is missing"
many 2 render "$scene" -o x.png --stats - && wrong "--stats of several processes"

[ $failed = 0 ] && echo "several processes: the bytes of one"
exit $failed
