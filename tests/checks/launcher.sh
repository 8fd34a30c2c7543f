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
check 'unless all are wanted' [ "$(grep -c -e '-LE' "$log")" = 0 ]
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

echo "[  PASSED  ] $passed test(s)"
