#!/bin/sh
# The launcher, in a checkout of its own with a compiler that is only pretended: what it builds when, what it installs, and
# that it hands everything else to the program.
set -eu

here=$(CDPATH='' cd -- "$(dirname -- "$0")" && pwd)
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
root="$out/my checkout"
log=$out/log
mkdir -p "$root/engine/base" "$root/runtime" "$root/tests/bench" "$out/bin" "$out/else where"
cp "$here/../../daft" "$root/daft"
echo >"$root/CMakeLists.txt"
echo >"$root/CMakePresets.json"
echo >"$root/engine/base/base.c"

passed=0
check() { # check WHAT COMMAND...
    what=$1
    shift
    "$@" || { echo "[  FAILED  ] $what" && cat "$out/err" "$log" && exit 1; }
    passed=$((passed + 1))
}

# A cmake that leaves traces, and a program that says how it was called.
cat >"$out/bin/cmake" <<END
#!/bin/sh
echo "cmake \$*" >>"$log"
[ ! -e "$out/broken" ] || { echo 'FAILED: base.c.o'; echo 'base.c:1: error: broken'; exit 1; }
mkdir -p "$root/build/release"
case \$1 in
--preset)
    mkdir -p "$root/build/\$2"
    echo "CMAKE_HOME_DIRECTORY:INTERNAL=$root" >"$root/build/\$2/CMakeCache.txt"
    echo 'DAFT_BUILD_TESTS:BOOL=OFF' >>"$root/build/\$2/CMakeCache.txt"
    : >"$root/build/\$2/build.ninja" ;;
--build)
    printf '#!/bin/sh\necho "in \$PWD: \$*"\nexit 7\n' >"$root/build/release/daft"
    chmod +x "$root/build/release/daft" ;;
esac
END
# A pkg-config that knows SDL only once it is installed, and package managers that write down what they were asked.
cat >"$out/bin/pkg-config" <<END
#!/bin/sh
case "\$*" in *sdl2*) [ -e "$out/has-sdl" ] ;; esac
END
cat >"$out/bin/apt-get" <<END
#!/bin/sh
echo "apt-get \$*" >>"$log"
case \$1 in install) : >"$out/has-sdl" ;; esac
END
# shellcheck disable=SC2016 # the fake expands these
printf '#!/bin/sh\n[ "$1" = -n ] && shift\nexec "$@"\n' >"$out/bin/sudo"
printf '#!/bin/sh\n' | tee "$out/bin/ninja" "$out/bin/clang" "$out/bin/clang-format" "$out/bin/clang-tidy" "$out/bin/valgrind" >"$out/bin/cc"
# A ctest that runs two tests, of which one is a program with three cases.
cat >"$out/bin/ctest" <<END
#!/bin/sh
echo "ctest \$* seed=\${DAFT_SEED:-}" >>"$log"
case "\$*" in *' -N '*) exit 0 ;; *nothing*) echo 'No tests were found!!!' && exit 0 ;; esac
echo '1/2 Test #1: script ...........   Passed    0.01 sec'
echo '2/2 Test #2: program ..........***Failed    0.01 sec'
mkdir -p "\$2/Testing/Temporary"
cat >"\$2/Testing/Temporary/LastTest.log" <<LOG
1/2 Testing: script
Output:
----------------------------------------------------------
fine
<end of output>
2/2 Testing: program
Output:
----------------------------------------------------------
[  PASSED  ] 2 test(s).
[  FAILED  ] 1 test(s), listed below:
<end of output>
LOG
END
chmod +x "$out"/bin/*
PATH=$out/bin:$PATH

# run [ARGUMENT]...: status, out and err of the launcher, with a fresh log.
run() {
    : >"$log"
    status=0
    "$launcher" "$@" >"$out/out" 2>"$out/err" </dev/null || status=$?
}
builds() { [ "$(grep -c 'cmake --build' "$log")" = "$1" ] && [ "$(grep -c 'cmake --preset' "$log")" = "$2" ]; }
says() { grep -qF -- "$2" "$out/$1"; }

launcher=$root/daft
run --help
check 'help needs no build' [ "$status" = 0 ] && check 'help is on stdout' says out './daft play'
check 'help builds nothing' builds 0 0
run
check 'no command is wrong usage' [ "$status" = 2 ]
run test --preset nonsense
check 'an unknown preset is wrong usage' [ "$status" = 2 ] && check 'and is named' says err "'nonsense'"
run test --filter
check 'a filter needs its value' [ "$status" = 2 ]
run test --fuzz --seconds 0
check 'a fuzzer needs its time' [ "$status" = 2 ] && check 'and says so' says err "not '0'"
run test --seed soon
check 'a seed is a number' [ "$status" = 2 ] && check 'and says so' says err "not 'soon'"
run test --help
check 'the tests have a help of their own' says out '--memcheck'

cd "$out/else where"
run play 'a game' --ticks 3
check 'it says what is missing and why' says err 'missing: sdl2 (window and input)'
check 'it installs that' grep -q 'apt-get install .*libsdl2-dev' "$log"
check 'and nothing else' [ "$(grep -c 'libcmocka\|ninja-build' "$log")" = 0 ]
check 'the first call configures and builds' builds 1 1
check "the program's arguments, folder and output" [ "$(cat "$out/out")" = "in $out/else where: play a game --ticks 3" ]
check "the program's exit status" [ "$status" = 7 ]

run play
check 'the second call builds nothing' builds 0 0
check 'and says nothing' [ ! -s "$out/err" ]

ln -s "$root/daft" "$out/bin/daft-link"
(cd "$out/bin" && ln -s daft-link daft-link-2)
launcher=$out/bin/daft-link-2
run render x
check 'a link to a link works' [ "$(cat "$out/out")" = "in $out/else where: render x" ]
check 'and builds nothing' builds 0 0
launcher=$root/daft

sleep 0.01
echo >"$root/engine/base/more.c"
run play
check 'a new source is built, without configuring' builds 1 0
sleep 0.01
rm "$root/engine/base/more.c"
run play
check 'so is a source that went' builds 1 0
sleep 0.01
touch "$root/CMakePresets.json"
run play
check 'new presets configure again' builds 1 1

sleep 0.01
touch "$root/engine/base/base.c" "$out/broken"
run play
check 'a broken build is status 1' [ "$status" = 1 ] && check 'and is shown' says err 'base.c:1: error: broken'
run test
check 'tests that cannot be built are one failure' [ "$(tail -n 1 "$out/out")" = '0 passed, 1 failed' ]
rm "$out/broken"
run play
check 'and is tried again' builds 1 0

run test --filter 'a|b'
check 'a test that failed is status 1' [ "$status" = 1 ]
check 'the last line counts the cases' [ "$(tail -n 1 "$out/out")" = '3 passed, 1 failed' ]
check 'slow tests are left out' grep -q 'ctest .* -R a|b .*-LE ^slow\$' "$log"
run test --all --seed 7
check 'unless all are wanted' [ "$(grep -c -e '-LE .*slow' "$log")" = 0 ]
check 'which do what their samples do' grep -q -e '-LE ^sample\$' "$log"
check 'random tests get their seed' grep -q 'ctest .* seed=7' "$log" && check 'and it is told' says err 'is 7'
run test --seed fresh
check 'a fresh seed is a number' grep -q 'ctest .* seed=[0-9][0-9]*$' "$log"
run test --memcheck
check 'Valgrind has a build of its own' grep -q 'ctest .*/build/memcheck .*-L ^memcheck\$' "$log"
run test --filter nothing
check 'no test is a failure' [ "$status" = 1 ] && check 'and nothing passed' says out '0 passed, 0 failed'

sed -i 's,INTERNAL=.*,INTERNAL=/nowhere,' "$root/build/release/CMakeCache.txt"
touch "$root/engine/base/base.c"
run play
check 'a checkout that was moved is configured anew' builds 1 1

# ---- only these tools ----

# The tools that the launcher itself needs, beside which nothing is installed: no flock, and one package manager or none.
only=$out/only
mkdir "$only"
for tool in sh awk cat chmod cksum cp cut date dirname env find getconf grep head id ls mkdir mv od printf ps readlink rm rmdir sed \
    sleep sort tail tee touch tr uname; do
    ln -s "$(command -v "$tool")" "$only/$tool"
done
for tool in cmake pkg-config ninja cc sudo; do ln -s "$out/bin/$tool" "$only/$tool"; done

# ---- two at once ----

two_at_once() { # two_at_once PATH: 0 where both ran the program after one build
    rm -rf "$root/build"
    : >"$log"
    (PATH=$1 "$launcher" play one >"$out/one" 2>"$out/err" </dev/null) &
    first=$!
    (PATH=$1 "$launcher" play two >"$out/two" 2>"$out/err2" </dev/null) &
    wait $! || [ $? = 7 ] || return 1
    wait $first || [ $? = 7 ] || return 1
    builds 1 1 && grep -q 'play one' "$out/one" && grep -q 'play two' "$out/two"
}
sed -i 's,^echo "cmake,sleep 0.2; echo "cmake,' "$out/bin/cmake"
if command -v flock >/dev/null; then check 'two at once build once' two_at_once "$PATH"; fi
check 'and without flock' two_at_once "$only"
check 'and leave no lock' [ ! -e "$root/build/.lock.d" ]
rm "$out/has-sdl"
check 'two at once install once' two_at_once "$PATH"
check 'as apt-get can tell' [ "$(grep -c 'apt-get install' "$log")" = 1 ]

# ---- interrupted ----

rm -rf "$root/build"
mkdir -p "$root/build/.lock.d"
sh -c 'echo $$' >"$root/build/.lock.d/pid" # of a process that is gone
PATH=$only run play
check 'the lock of a launcher that is gone counts no more' builds 1 1

rm -rf "$root/build"
sed -i 's,^sleep 0.2,sleep 2,' "$out/bin/cmake"
: >"$log"
PATH=$only "$launcher" play >/dev/null 2>&1 </dev/null &
sleep 0.5
kill -9 $!
wait $! 2>/dev/null || :
sleep 2
sed -i 's,^sleep 2; ,,' "$out/bin/cmake"
PATH=$only run play
check 'a build whose launcher was killed goes on' [ "$status" = 7 ]

rm "$root/build/release/build.ninja" "$root/build/release/daft"
# shellcheck disable=SC2016 # the fake expands these
sed -i '2i[ "$1" != --preset ] || [ ! -f "'"$root"'/build/release/CMakeCache.txt" ] || exit 1' "$out/bin/cmake"
run play
check 'a configuration that was cut short begins anew' [ "$status" = 7 ]
sed -i 2d "$out/bin/cmake"

# ---- a checkout that cannot be written ----

closed=
if [ "$(id -u)" != 0 ]; then
    closed='env'
elif command -v setpriv >/dev/null; then
    closed='setpriv --reuid=65534 --regid=65534 --clear-groups'
    chmod 755 "$out"
fi
read_only() { # read_only ARGUMENT...: status, out and err of a launcher that may write only $out/cache
    status=0
    # shellcheck disable=SC2086 # a command and its options
    XDG_CACHE_HOME=$out/cache $closed "$launcher" "$@" >"$out/out" 2>"$out/err" </dev/null || status=$?
}
if [ -n "$closed" ]; then
    mkdir -p "$out/cache"
    chmod 777 "$out/cache"
    chmod 666 "$log"
    chmod -R a+rX,go-w "$root" "$out/bin"
    [ "$closed" != env ] || chmod -R u-w "$root"
    touch -d '+1 minute' "$root/engine/base/base.c" 2>/dev/null || :
    read_only play here
    check 'a read-only checkout runs what is built' grep -q 'play here' "$out/out"
    check 'and writes nothing' [ -z "$(find "$out/cache" -mindepth 1)" ]
    chmod -R u+w "$root"
    rm -rf "$root/build"
    # shellcheck disable=SC2016 # the fake expands these
    sed -i "s,$root/build,\$XDG_CACHE_HOME/built," "$out/bin/cmake"
    cat >"$out/bin/cmake" <<END
#!/bin/sh
case \$1 in
--preset) mkdir -p "\$4" && : >"\$4/build.ninja" && echo "CMAKE_HOME_DIRECTORY:INTERNAL=$root" >"\$4/CMakeCache.txt" ;;
--build) printf '#!/bin/sh\necho "home \$DAFT_HOME: \$*"\n' >"\$2/daft" && chmod +x "\$2/daft" ;;
esac
END
    [ "$closed" != env ] || chmod u-w "$root"
    read_only play there
    check 'or builds into the cache' [ "$(cat "$out/out")" = "home $root: play there" ]
    chmod u+w "$root"
fi

# ---- package managers, with and without a network ----

# manager NAME: the only one, which fails and knows all packages but those of the list $unknown.
manager() {
    rm -f "$only/apt-get" "$only/apt-cache" "$only/dnf" "$only/pacman" "$only/brew" "$out/has-sdl"
    for name in "$@"; do
        cat >"$only/$name" <<END
#!/bin/sh
echo "$name \$*" >>"$log"
for last in "\$@"; do :; done
case "\$1 \$2" in
--prefix*) echo "$out/brew" && exit ;;
'show '* | '-q list' | '-Si '* | 'info '*) case " \$UNKNOWN " in *" \$last "*) exit 1 ;; esac; exit 0 ;;
esac
echo 'Temporary failure resolving the archive'
exit 100
END
        chmod +x "$only/$name"
    done
}
cat >"$out/bin/pkg-config" <<END
#!/bin/sh
exit 1
END
by_hand() { # by_hand WANTED COMMAND: what the launcher says to type
    PATH=$only run play
    check "$2 without a network is status 1" [ "$status" = 1 ]
    check "$2: what to type by hand" says err "by hand: $1"
    check "$2: the manager's own words" says err 'Temporary failure resolving'
}
unset UNKNOWN
rm -rf "$root/build"
manager apt-get apt-cache
by_hand 'sudo apt-get update && sudo apt-get install libsdl2-dev liblua5.4-dev' apt-get
manager dnf
by_hand 'sudo dnf install SDL2-devel lua-devel' dnf
manager pacman
by_hand 'sudo pacman -Sy --needed sdl2-compat lua54' pacman
export UNKNOWN='lua54 sdl2-compat'
by_hand 'sudo pacman -Sy --needed sdl2 lua' 'an older pacman'
unset UNKNOWN
manager brew
by_hand 'brew install sdl2 lua@5.4' brew
manager
PATH=$only run play
check 'no manager is status 1' [ "$status" = 1 ]
check 'and says what is needed' says err 'needed: sdl2, window and input; Debian calls it libsdl2-dev, Fedora SDL2-devel'

echo "[  PASSED  ] $passed test(s)"
