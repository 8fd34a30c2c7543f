# The rules of the house, one file after another. See check_layers.sh.

BEGIN {
    # A room may use rooms of a lower level. Rooms of one level are siblings and do not see each other.
    split("base 0 math 1 image 2 geometry 2 accel 3 raster 4 shade 4 cost 5 render 6 sim 6 scene 7", word, " ")
    for (i = 1; i in word; i += 2) level[word[i]] = word[i + 1]
}

function complain(what, rule) {
    printf "%s:%d: %s (%s)\n", FILENAME, FNR, what, rule
    bad++
}

# "engine/accel/../math/vec.h" -> "engine/math/vec.h"
function normalised(path) {
    gsub(/\/\.\//, "/", path)
    while (match(path, /[^\/.]+\/\.\.\//)) path = substr(path, 1, RSTART - 1) substr(path, RSTART + RLENGTH)
    return path
}

# The file a quoted or angled name means, as seen from the root of the checkout. Names that start with a room are seen
# from engine/, as the build's include path has it; others from the folder of the including file.
function target(name, first) {
    first = name
    sub(/\/.*/, "", first)
    if (name == "daft.h" || (first in level && index(name, "/"))) return "engine/" name
    if (first ~ /^(lua|common|platform|hud|game|cli)$/ && index(name, "/")) return "runtime/" name
    return normalised(folder name)
}

function room_of(path, part) { return split(path, part, "/") > 2 && part[1] == "engine" ? part[2] : "" }

function check_engine(name, quoted, path, other) {
    if (name ~ /^(SDL|lua|lauxlib|lualib)/) {
        complain("includes " name, "engine/ has no SDL and no Lua")
        return
    }
    path = target(name)
    if (path == "engine/daft.h") return
    if (!quoted && path !~ /^engine\/[a-z]+\/[a-z]/) return
    if (!quoted && room_of(path) == room) return # <math.h> seen from math/
    if (path !~ /^engine\//) {
        if (path ~ /^(runtime|scripts|games|tests|assets)\// || path ~ /^\.\.\//)
            complain("includes " name, "engine/ uses nothing above it")
        return
    }
    other = room_of(path)
    if (other == room || other == "") return
    if (room == "") complain("includes " name, "daft.h stands alone")
    else if (!(other in level)) complain("includes " name, "engine/ has no room called " other)
    else if (level[other] > level[room]) complain("includes " name, room "/ is below " other "/")
    else if (level[other] == level[room]) complain("includes " name, room "/ and " other "/ are siblings")
}

function check_runtime(name, path) {
    path = target(name)
    if (path ~ /^engine\// && path != "engine/daft.h")
        complain("includes " name, "runtime/ uses nothing of engine/ but daft.h")
}

# Replaces comments and the text of strings by nothing; `comment` lives on to the next line.
function code_of(line, out, two, c) {
    out = ""
    while (line != "") {
        two = substr(line, 1, 2)
        c = substr(line, 1, 1)
        if (comment) {
            if (two == "*/") { comment = 0; line = substr(line, 3) } else line = substr(line, 2)
        } else if (two == "/*") { comment = 1; line = substr(line, 3) }
        else if (two == "//") return out
        else if (c == "\"" || c == "'") {
            line = substr(line, 2)
            while (line != "" && substr(line, 1, 1) != c) line = substr(line, substr(line, 1, 1) == "\\" ? 3 : 2)
            line = substr(line, 2)
            out = out c c
        } else { out = out c; line = substr(line, 2) }
    }
    return out
}

FNR == 1 {
    comment = 0
    files++
    folder = FILENAME
    sub(/[^\/]*$/, "", folder)
    engine = folder ~ /^engine\//
    room = room_of(FILENAME)
    if (engine && room != "" && !(room in level)) complain("is in " room "/", "engine/ has no room called " room)
}

# An include, unless it is inside a comment.
!comment && /^[ \t]*#[ \t]*include[ \t]*[<"]/ {
    name = $0
    sub(/^[^<"]*[<"]/, "", name)
    sub(/[>"].*$/, "", name)
    if (engine) check_engine(name, $0 ~ /include[ \t]*"/)
    else check_runtime(name)
    next
}

{
    code = code_of($0)
    if (!engine) next
    if (code ~ /(^|[^A-Za-z0-9_])(stdout|stderr|stdin)($|[^A-Za-z0-9_])/)
        complain("names a standard stream", "engine/ reads and prints nothing by itself")
    if (code ~ /(^|[^A-Za-z0-9_])(v?printf|puts|putchar|perror)[ \t]*\(/)
        complain("prints", "engine/ reads and prints nothing by itself")
    if (code ~ /(^|[^A-Za-z0-9_])(exit|_exit|_Exit|quick_exit|abort)[ \t]*\(/)
        complain("ends the process", "engine/ returns errors")
}

END {
    if (bad) exit 1
    printf "%d files keep to the order of the rooms\n", files
}
