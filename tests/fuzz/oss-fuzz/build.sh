#!/bin/bash -eu
# Builds each fuzzer for OSS-Fuzz, with its seeds and its dictionary. OSS-Fuzz sets CC, CFLAGS, LIB_FUZZING_ENGINE, SRC, WORK and
# OUT; `OUT=/tmp/out WORK=/tmp/work SRC=.. CC=clang CFLAGS=-fsanitize=address,fuzzer-no-link
# LIB_FUZZING_ENGINE=-fsanitize=fuzzer bash tests/fuzz/oss-fuzz/build.sh` does the same by hand.
root=$(cd "$(dirname "$0")/../../.." 2>/dev/null && [ -f CMakePresets.json ] && pwd || echo "$SRC/daft")
cmake -S "$root" -B "$WORK/daft" -G Ninja -DCMAKE_BUILD_TYPE=RelWithDebInfo -DCMAKE_C_COMPILER="$CC" -DCMAKE_C_FLAGS="$CFLAGS" \
    -DDAFT_FUZZ=ON -DDAFT_FUZZ_ENGINE="$LIB_FUZZING_ENGINE" -DDAFT_WERROR=OFF -DDAFT_ISAS="sse2;avx2"
cmake --build "$WORK/daft" --target fuzzers
for folder in "$root"/tests/fuzz/seeds/*; do
    name=${folder##*/}
    cp "$WORK/daft/tests/fuzz_$name" "$OUT/"
    ldd "$OUT/fuzz_$name" | awk '/libSDL2|liblua/ { print $3 }' | xargs -r cp -t "$OUT"
    (cd "$root/tests/fuzz" && zip -qr "$OUT/fuzz_${name}_seed_corpus.zip" "seeds/$name" $([ ! -d "corpus/$name" ] || echo "corpus/$name"))
    [ ! -f "$root/tests/fuzz/$name.dict" ] || cp "$root/tests/fuzz/$name.dict" "$OUT/fuzz_$name.dict"
done
mkdir -p "$OUT/daft/assets"
cp -r "$root/scripts" "$OUT/daft/"
cp -r "$root/assets/fonts" "$OUT/daft/assets/"
