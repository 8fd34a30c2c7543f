# Turns the declarations of daft.h into C: for each function one that asks give_TYPE() for its arguments, calls it and hands
# the result to took_TYPE(); and the table CALLS of them all. A function with a type that tests/misuse/calls.c does not know
# yet fails to compile there.
function trim(s) { gsub(/^[ \t]+|[ \t]+$/, "", s); return s }
# "const daft_scene *" -> "const_daft_scene_p"
function word(type) {
    gsub(/\*/, " p", type)
    type = trim(type)
    gsub(/[ \t]+/, "_", type)
    return type
}
# Splits "const daft_scene *scene" into `type` and `name`.
function split_parameter(text) {
    text = trim(text)
    array = sub(/\[[0-9]*\]$/, "", text) # is passed as a pointer
    match(text, /[A-Za-z0-9_]+$/)
    name = substr(text, RSTART)
    type = trim(substr(text, 1, RSTART - 1)) (array ? " *" : "")
}
function emit(declaration,   open, head, list, count, i, result, function_name, arguments, reports, changes, first) {
    sub(/^DAFT_API[ \t]+/, "", declaration)
    open = index(declaration, "(")
    split_parameter(substr(declaration, 1, open - 1))
    function_name = name
    result = type
    list = substr(declaration, open + 1)
    sub(/\)[ \t]*;.*$/, "", list)
    count = trim(list) == "void" ? 0 : split(list, parts, ",")
    printf "static void call_%s(caller *c)\n{\n", function_name
    print "    (void)c;"
    first = ""
    reports = 0
    for (i = 1; i <= count; i++) {
        split_parameter(parts[i])
        if (i == 1) first = type
        if (type == "daft_error *") reports = 1
        printf "    %s a%d = give_%s(begin_argument(c, %d, \"%s\"));\n", type, i, word(type), i - 1, name
        arguments = arguments (i > 1 ? ", " : "") "a" i
    }
    if (result == "void") {
        printf "    %s(%s);\n    took_nothing(c);\n}\n\n", function_name, arguments
    } else {
        printf "    %s r = %s(%s);\n    took_%s(c, r);\n}\n\n", result, function_name, arguments, word(result)
    }
    changes = (first == "daft_scene *" || first == "daft_engine *") && function_name !~ /_get($|_)/
    rows = rows sprintf("    {\"%s\", call_%s, %d, %s, %s},\n", function_name, function_name, count, reports ? "true" : "false",
        changes ? "true" : "false")
}
{
    gsub(/\/\*[^*]*\*\//, "") # comments that end on their line
    sub(/\/\*.*$/, "")
}
/^DAFT_API/ { text = "" ; inside = 1 }
inside {
    text = text " " $0
    if (index($0, ";")) {
        inside = 0
        emit(trim(text))
    }
}
END { printf "const call CALLS[] = {\n%s};\n", rows }
