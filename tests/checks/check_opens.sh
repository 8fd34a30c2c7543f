#!/bin/sh
# usage: check_opens.sh ROOT
# Files are opened for reading in engine/base/files.c alone, and for writing in engine/base/writer.c and, line by line as it is played, in
# runtime/game/recorder.c. Folders are listed in files.c, by home.c (the games that are installed) and by `daft check` (what the user named). many.c opens /dev/null; content.c lists the folder of
# what is viewed, and watch.c those of the game that is played, whose times tell what was saved again. heap.c maps memory, and no file.
# Libraries are loaded by foreign/import.c (Assimp), module.c and libraries.c. runtime/stub/ is a program of its own, which unpacks itself.
set -eu

cd "$1"
calls='\b(fopen|freopen|fopen64|open|open64|openat|creat|opendir|scandir|nftw|ftw|mmap|dlopen|popen|system)[ ]*\('
found=$(grep -rnE "$calls" engine runtime --include=*.c --include=*.h | grep -vE '^[^:]*:[0-9]*: *(\* |/\*|//)' || true)
allowed='^(engine/base/files\.c|engine/geometry/foreign/import\.c|runtime/files/(module|libraries)\.c|runtime/stub/(stub|unpack)\.c|engine/base/writer\.c|runtime/game/recorder\.c|runtime/game/heap\.c|runtime/files/home\.c|runtime/cli/check/check\.c|runtime/cli/video\.c|runtime/view/picture/content\.c|runtime/files/watch\.c|runtime/many/many\.c|runtime/platform/seal[a-z_]*\.c):'
bad=$(printf '%s\n' "$found" | grep -vE "$allowed" | grep . || true)
if [ -n "$bad" ]; then
    echo "files are opened by engine/base/files.h and engine/base/writer.h only:"
    printf '%s\n' "$bad"
    exit 1
fi
# The exceptions open folders, or write.
bad=$(grep -nE '\b(fopen|freopen|creat|mmap|system|popen)[ ]*\(|\bopen(at)?[ ]*\(.*O_RDONLY' runtime/files/home.c runtime/cli/check/check.c runtime/cli/video.c \
    runtime/game/recorder.c | grep -vE 'O_DIRECTORY|O_NOFOLLOW' || true)
[ -z "$bad" ] || { echo "these are to go through daft_read_file:" && printf '%s\n' "$bad" && exit 1; }
echo "$(printf '%s\n' "$found" | wc -l) places open files, all where they may"
