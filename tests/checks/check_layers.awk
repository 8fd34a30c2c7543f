# The rules of the house, one file after another. See check_layers.sh.
#
# A room is a folder of engine/ or runtime/ that holds sources; sim/solve is an inner room of sim. One header of each room
# says in its first comment which headers others may include:
#     Public headers: sim.h character/character.h     for everyone; in an inner room, for the other rooms of its top room
#     Inner headers: world.h                          for the room's own inner rooms
# An inner room's header is seen outside its top room only where the top room lists it with its folder.

BEGIN {
    # A top room may use rooms of a lower level. Rooms of one level are siblings and do not see each other.
    split("base 0 math 1 image 2 geometry 2 accel 3 raster 4 shade 4 cost 5 render 6 sim 6 scene 7", word, " ")
    for (i = 1; i in word; i += 2) level[word[i]] = word[i + 1]
    for (i = 1; i < ARGC; i++) read_head(ARGV[i])
}

function complain(what, rule) { complain_at(FILENAME ":" FNR, what, rule) }

function complain_at(place, what, rule) {
    printf "%s: %s (%s)\n", place, what, rule
    bad++
}

# "engine/accel/../math/vec.h" -> "engine/math/vec.h"
function normalised(path) {
    gsub(/\/\.\//, "/", path)
    while (match(path, /[^\/.]+\/\.\.\//)) path = substr(path, 1, RSTART - 1) substr(path, RSTART + RLENGTH)
    return path
}

# "engine/sim/solve/solver.h" -> "engine/sim/solve"; "engine/daft.h" -> ""
function room_of(path) {
    sub(/\/[^\/]*$/, "", path)
    return path ~ /\// ? path : ""
}

# "engine/sim/solve" -> "engine/sim"
function top_of(path, part) {
    split(path, part, "/")
    return part[1] "/" part[2]
}

function name_of(path, part) {
    split(path, part, "/")
    return part[2]
}

# Which headers the first comment of a header declares. A list ends at the first word that is no header's name.
function read_head(file, line, list, n, i, words, opened, place) {
    place = room_of(file)
    if (place != "" && !(place in rooms)) {
        rooms[place] = file
        order[++room_count] = place
    }
    if (file !~ /\.h$/ || place == "") return
    has_header[place] = 1
    known[file] = 1
    while ((getline line <file) > 0) {
        if (line ~ /\/\*/) opened = 1
        if (!opened) break
        n = split(line, words, /[ \t,;]+/)
        for (i = 1; i <= n; i++) {
            if (words[i] == "headers:" && words[i - 1] ~ /^(Public|Inner)$/) {
                list = words[i - 1]
                if (list == "Public" && place in front)
                    complain_at(file ":1", "lists public headers, as " front[place] " does", "one header of a room lists them")
                if (list == "Public") front[place] = file
            } else if (list != "" && words[i] ~ /\.h\.?$/) {
                sub(/\.$/, "", words[i])
                if (list == "Public") public[place, place "/" words[i]] = file
                else inner[place "/" words[i]] = file
            } else if (words[i] != "*" && words[i] != "" && words[i] != "*/") list = ""
        }
        if (line ~ /\*\//) break
    }
    close(file)
}

# The file a quoted or angled name means, as seen from the root of the checkout. Names that start with a room are seen
# from engine/ or runtime/, as the build's include paths have it; others from the folder of the including file.
function target(name, first) {
    first = name
    sub(/\/.*/, "", first)
    if (name == "daft.h" || (first in level && index(name, "/"))) return "engine/" name
    if (index(name, "/") && ("runtime/" first) in rooms) return "runtime/" name
    return normalised(folder name)
}

# Whether a header of another room may be included here.
function check_private(path, name, there) {
    if (!(path in known)) return
    there = room_of(path)
    if (there == room) return
    if (!((room, there) in first_use)) {
        uses[room] = uses[room] " " there
        first_use[room, there] = FILENAME ":" FNR
    }
    if (top_of(there) != top) {
        if (top_of(there) in front && !((top_of(there), path) in public))
            complain("includes " name, "it is private to " name_of(there) "/")
    } else if (there in front && !((there, path) in public) && !((path in inner) && index(room "/", there "/") == 1))
        complain("includes " name, "it is private to " there "/")
}

function check_engine(name, quoted, path, other, mine) {
    if (!targets && name ~ /intrin\.h$|^arm_neon\.h$|^wasm_simd128\.h$/) {
        complain("includes " name, "instruction sets are math/simd/'s")
        return
    }
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
    other = room_of(path) == "" ? "" : name_of(path)
    mine = room == "" ? "" : name_of(room)
    if (other == "") return
    if (mine == "") complain("includes " name, "daft.h stands alone")
    else if (!(other in level)) complain("includes " name, "engine/ has no room called " other)
    else if (mine in level && level[other] > level[mine]) complain("includes " name, mine "/ is below " other "/")
    else if (mine in level && other != mine && level[other] == level[mine])
        complain("includes " name, mine "/ and " other "/ are siblings")
    else check_private(path, name)
}

function check_runtime(name, path) {
    path = target(name)
    if (path ~ /^engine\// && path != "engine/daft.h")
        complain("includes " name, "runtime/ uses nothing of engine/ but daft.h")
    else if (path ~ /^runtime\// && room_of(path) != "") check_private(path, name)
}

# Replaces comments and the text of strings by nothing; `comment` lives on to the next line.
function code_of(line, out, two, c) {
    if (!comment && line !~ /[\/"']/) return line
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
    targets = folder == "engine/math/simd/"
    room = room_of(FILENAME)
    top = room == "" ? "" : top_of(room)
    if (engine && room != "" && !(name_of(room) in level))
        complain("is in " name_of(room) "/", "engine/ has no room called " name_of(room))
}

# An include, unless it is inside a comment.
!comment && /^[ \t]*#[ \t]*include[ \t]*[<"]/ {
    name = $0
    sub(/^[^<"]*[<"]/, "", name)
    sub(/[>"].*$/, "", name)
    path = target(name)
    if (path in known && path != FILENAME) {
        includes[FILENAME] = includes[FILENAME] " " path
        if (!((FILENAME, path) in line_of)) line_of[FILENAME, path] = FNR
    }
    if (engine) check_engine(name, $0 ~ /include[ \t]*"/)
    else check_runtime(name)
    next
}

{
    code = code_of($0)
    if (!engine) next
    if (!targets && code ~ /(^|[^A-Za-z0-9_])(_mm[0-9]*_|__m(128|256|512)|__builtin_ia32_|DAFT_ISA_(plain|sse2|avx2|avx512)($|[^A-Za-z0-9_]))/)
        complain("asks which machine it is on", "instruction sets are math/simd/'s")
    if (code ~ /(^|[^A-Za-z0-9_])(stdout|stderr|stdin)($|[^A-Za-z0-9_])/)
        complain("names a standard stream", "engine/ reads and prints nothing by itself")
    if (code ~ /(^|[^A-Za-z0-9_])(v?printf|puts|putchar|perror)[ \t]*\(/)
        complain("prints", "engine/ reads and prints nothing by itself")
    if (code ~ /(^|[^A-Za-z0-9_])(exit|_exit|_Exit|quick_exit|abort)[ \t]*\(/)
        complain("ends the process", "engine/ returns errors")
}

# Follows `edges` from a file or room; an edge back to where the walk still is closes a cycle.
function walk(node, edges, rule, list, n, i) {
    state[node] = 1
    n = split(edges[node], list, " ")
    for (i = 1; i <= n; i++) {
        if (state[list[i]] == 1)
            complain_at(rule == "rooms" ? first_use[node, list[i]] : node ":" line_of[node, list[i]],
                        node " and " list[i] " include each other", "no cycles between " rule)
        else if (!state[list[i]]) walk(list[i], edges, rule)
    }
    state[node] = 2
}

# What a room's inner rooms take from it is its ground, and what it takes from them is its roof: no cycle.
function without_ground(edges, room, list, n, i) {
    for (room in edges) {
        n = split(edges[room], list, " ")
        edges[room] = ""
        for (i = 1; i <= n; i++)
            if (index(room "/", list[i] "/") != 1) edges[room] = edges[room] " " list[i]
    }
}

# Every room says what others may include, and stands on the map in the manual.
function check_rooms(room, file, line, text, entry, part) {
    while ((getline line <map) > 0) text = text line "\n"
    for (room in rooms) {
        if (room ~ /^engine\// && !(name_of(room) in level)) continue
        if (room in has_header && !(room in front)) complain_at(rooms[room] ":1", "no header of " room "/ lists its public headers",
                                          "rooms name their public headers")
        if (!index(text, "`" room "/`")) complain_at(rooms[room] ":1", room "/ is not on the map", "rooms are on the map")
    }
    for (entry in public) {
        split(entry, part, SUBSEP)
        if (!(part[2] in known)) complain_at(public[entry] ":1", "lists " part[2], "listed headers exist")
    }
    for (file in inner) if (!(file in known)) complain_at(inner[file] ":1", "lists " file, "listed headers exist")
}

END {
    for (i = 1; i < ARGC; i++) if (!state[ARGV[i]]) walk(ARGV[i], includes, "files")
    without_ground(uses)
    if (map != "") {
        for (i = 1; i <= room_count; i++) if (!state[order[i]]) walk(order[i], uses, "rooms")
        check_rooms()
    }
    if (bad) exit 1
    printf "%d files in %d rooms keep to the order of the rooms\n", files, room_count
}
