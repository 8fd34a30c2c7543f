/* The tables of functions as annotations of the Lua language server, so that editors complete names, show what they do
 * and find what is misspelt. A form such as "(from, direction [, max_distance]) -> hit or nil" becomes @param and
 * @return lines, and {a =, b =} a table with these fields; a word's type is looked up below, and one that is not there
 * is `any`: tests/checks/docs.sh says which may. */
#include "lua/fields.h"

#include "common/util.h"

#include <ctype.h>
#include <stdio.h>
#include <string.h>

enum { TEXT = 400, PARTS = 16 };

/* ---- types of words ---- */

typedef struct word_type {
    const char *type, *words; /* with a space before and after each */
} word_type;

static const word_type ARGUMENTS[] = {
    {"nil", " nil "},
    {"number", " x y z w s p v x1 y1 x2 y2 yaw pitch roll width height max_distance speed force lower upper hertz "
               "damping seconds metres "
               "size occlusion m n seed radius strength scale rate "},
    {"integer", " button ticks count "},
    {"boolean", " on down "},
    {"string", " key negative positive name group string file other tag action input pace "
               "right left top bottom front back "},
    {"string|integer", " clip "},
    {"daft.font", " font "},
    {"string|string[]", " layer hits "},
    {"daft.place", " from at place point target "},
    {"daft.vector", " direction axis "},
    {"daft.color", " color zenith horizon "},
    {"daft.value", " value "},
    {"daft.anymaterial", " material "},
    {"daft.entity", " entity ignore parent "},
    {"daft.sound", " sound "},
    {"thread", " task "},
    {"function", " f "},
    {"daft.shape", " shape "},
    {"daft.camera.along.options[]", " points "},
    {"table", " options hit list "}};

/* Of a table's fields where a form spells them out. */
static const word_type FIELDS[] = {
    {"number", " speed blend start fov width height size depth fade volume scale rotation border max mean "},
    {"boolean", " restart loop teleport smooth shadow full_screen closed "},
    {"string", " tag name title icon "},
    {"string|number", " text "},
    {"\"left\"|\"center\"|\"right\"", " align "},
    {"daft.color", " color "},
    {"daft.place", " from at "},
    {"daft.font", " font "},
    {"number[]", " origin source "},
    {"number[]|daft.vector[]", " positions normals "},
    {"number[]|number[][]", " uvs "},
    {"integer[][]", " triangles "}};

/* What lists and tables hold, by the function that gives them, or is given them to fill. */
static const struct {
    const char *function, *type;
} CONTENTS[] = {{"entity:contacts", "daft.contact[]"},
                {"entity:clips", "daft.clip[]"},
                {"entity:animation", "daft.animation|nil"},
                {"entity:children", "daft.entity[]"},
                {"entity:tags", "string[]"},
                {"find", "daft.entity[]"},
                {"events", "daft.event[]"},
                {"physics", "table<string, integer>"},
                {"query.ray", "daft.hit"},
                {"query.all", "daft.hit[]"},
                {"query.cast", "daft.hit"},
                {"query.closest", "daft.hit"},
                {"query.overlap", "daft.entity[]"},
                {"raycast", "daft.hit"},
                {"pick", "daft.hit"},
                {"camera.get", "daft.camera.set.options"},
                {"camera.along", "daft.camera.set.options"},
                {"entity:cameras", "table<integer|string, daft.camera.set.options>"},
                {"entity:add_lights", "daft.light[]"},
                {"camera.checkpoints", "daft.camera.along.options[]"},
                {"scene", "table<string, daft.entity>"},
                {"quality", "daft.quality.options"}};

static const char *contents_of(const char *function)
{
    for (size_t i = 0; i < COUNT_OF(CONTENTS); i++)
        if (strcmp(CONTENTS[i].function, function) == 0) return CONTENTS[i].type;
    return "table";
}

static const word_type RESULTS[] = {
    {"number", " x y z w r g b s v width height number seconds kilograms radians newtons metres value speed force yaw "
               "pitch roll index count left top scale rate "},
    {"boolean", " on boolean down "},
    {"string", " string message name key "},
    {"number", " newton newtons "},
    {"daft.value", " value "},
    {"table", " counts list hits entities table knobs hit "},
    {"daft.entity", " entity "},
    {"daft.light", " light "},
    {"daft.material", " material "},
    {"daft.mesh", " mesh "},
    {"daft.joint", " joint "},
    {"daft.character", " character "},
    {"daft.picture", " picture "},
    {"daft.sound", " sound "},
    {"daft.voice", " voice "},
    {"daft.font", " font "},
    {"daft.image", " image "},
    {"daft.stream", " stream "},
    {"daft.particles", " particles "},
    {"number[]", " from direction "},
    {"thread", " task "},
    {"nil", " nil "}};

static const word_type VALUES[] = {{"number", " number "},
                                   {"integer", " whole "},
                                   {"boolean", " true false "},
                                   {"daft.vector", " {x, "},
                                   {"daft.color", " colour "},
                                   {"daft.anymaterial", " material "},
                                   {"daft.entity", " entity "},
                                   {"daft.mesh", " mesh "},
                                   {"string", " string name "},
                                   {"number[]", " {from, "},
                                   {"table", " list table {radius {speed {hertz {lower, {yaw, {u, names "}};

static const char *type_of(const char *word, const word_type *types, size_t count)
{
    char wanted[TEXT + 4];
    snprintf(wanted, sizeof wanted, " %.300s ", word);
    for (size_t i = 0; i < count; i++)
        if (strstr(types[i].words, wanted)) return types[i].type;
    return "any";
}

static void add(char out[TEXT], const char *text)
{
    const size_t used = strlen(out);
    snprintf(out + used, TEXT - used, "%s", text);
}

static void add_type(char out[TEXT], const char *type)
{
    if (out[0]) add(out, "|");
    add(out, type);
}

/* Splits at the separator where it stands outside of brackets and quotes. The text is cut into pieces. */
static size_t split(char *text, const char *separator, char *parts[PARTS])
{
    size_t count = 0, length = strlen(separator);
    int depth = 0;
    bool quoted = false;
    parts[count++] = text;
    for (char *at = text; *at; at++) {
        if (*at == '"') quoted = !quoted;
        if (!quoted) depth += (*at == '{' || *at == '(') - (*at == '}' || *at == ')');
        if (quoted || depth > 0 || strncmp(at, separator, length) != 0 || count == PARTS) continue;
        *at = 0;
        at += length - 1;
        parts[count++] = at + 1;
    }
    return count;
}

static char *trim(char *text)
{
    while (*text == ' ') text++;
    for (size_t n = strlen(text); n && text[n - 1] == ' ';) text[--n] = 0;
    return text;
}

/* ---- fields of tables ---- */

/* "colour or number", "{x, y, z} or entity, m": the first word of each alternative tells. */
static void type_of_value(const char *value, char out[TEXT])
{
    char text[TEXT], *parts[PARTS];
    snprintf(text, sizeof text, "%s", value);
    out[0] = 0;
    if (text[0] == '"') { /* a choice */
        size_t count = split(text, ", ", parts);
        for (size_t i = 0; i < count; i++)
            add_type(out, parts[i][0] != '"' ? "table" : strchr(parts[i], ' ') ? "string" : parts[i]);
        return;
    }
    split(text, ", ", parts); /* cuts off the unit and the range */
    size_t count = split(text, " or ", parts);
    for (size_t i = 0; i < count; i++) {
        char word[TEXT];
        if (parts[i][0] == '"') {
            add_type(out, "string");
            continue;
        }
        if (parts[i][0] == '{')
            snprintf(word, sizeof word, "%.*s", (int)strcspn(parts[i], " }="), parts[i]);
        else
            snprintf(word, sizeof word, "%.*s", (int)strcspn(parts[i], ", ="), parts[i]);
        const char *type = type_of(word, VALUES, COUNT_OF(VALUES));
        if (!strstr(out, type)) add_type(out, type);
    }
}

static void put_field(void *unused, const char *name, const char *value, const char *initial, const char *doc)
{
    (void)unused;
    char type[TEXT];
    type_of_value(value, type);
    printf("---@field %s? %s %s", name, type, doc);
    if (value[0] && strcmp(type, "number") == 0 && strcmp(value, "number") != 0) printf(" (%s)", value);
    printf(*initial ? "; %s unless given\n" : "\n", initial);
}

/* Functions that take what another one takes. */
static const char *const ALIKE[][2] = {{"material:set", "material"}, {"light:set", "light.spot"}};

static const api_form *form_of(const char *function)
{
    size_t count;
    const api_form *const *forms = api_forms(&count);
    for (size_t i = 0; i < COUNT_OF(ALIKE); i++)
        if (strcmp(ALIKE[i][0], function) == 0) function = ALIKE[i][1];
    for (size_t i = 0; i < count; i++)
        if (strcmp(forms[i]->function, function) == 0 && strcmp(forms[i]->title, "collider") != 0) return forms[i];
    return NULL;
}

/* "light.sun", "picture:draw" → "daft.light.sun.options", "daft.picture.draw.options" */
static void options_type(const char *function, char out[TEXT])
{
    snprintf(out, TEXT, "daft.%s.options", function);
    for (char *at = out; *at; at++)
        if (*at == ':') *at = '.';
}

static void put_option_classes(void)
{
    size_t count;
    const api_form *const *forms = api_forms(&count);
    for (size_t i = 0; i < count; i++) {
        char name[TEXT];
        if (form_of(forms[i]->function) != forms[i]) continue;
        options_type(forms[i]->function, name);
        printf("\n---@class %s\n", name);
        api_describe_form(forms[i], put_field, NULL);
    }
}

/* ---- functions ---- */

typedef struct argument {
    char name[40], type[TEXT];
    bool optional;
} argument;

/* A word that can name a parameter. */
static void name_argument(argument *a, const char *text, const argument *before, size_t count)
{
    snprintf(a->name, sizeof a->name, "%.*s", (int)strspn(text, "abcdefghijklmnopqrstuvwxyz_"), text);
    if (strcmp(a->name, "function") == 0) strcpy(a->name, "f");
    if (!a->name[0] || strcmp(a->name, "or") == 0) strcpy(a->name, "options");
    for (size_t i = 0; i < count; i++)
        if (strcmp(before[i].name, a->name) == 0) strcat(a->name, "2");
}

/* "{a =, b =, …}" as a table of fields; what ends in an ellipsis may have more. */
static void type_table(char out[TEXT], const char *part)
{
    char inside[TEXT], *names[PARTS];
    snprintf(inside, sizeof inside, "%s", part + 1);
    inside[strcspn(inside, "}")] = 0;
    const size_t count = split(inside, ",", names);
    if (!strchr(inside, '=')) {
        add_type(out, "number[]"); /* {x, y, …} */
        return;
    }
    if (out[0]) add(out, "|");
    add(out, "{");
    for (size_t i = 0, put = 0; i < count; i++) {
        char name[40];
        const char *at = trim(names[i]);
        snprintf(name, sizeof name, "%.*s", (int)strspn(at, "abcdefghijklmnopqrstuvwxyz_"), at);
        if (!name[0]) continue;
        if (put++) add(out, ", ");
        add(out, name), add(out, "?: "), add(out, type_of(name, FIELDS, COUNT_OF(FIELDS)));
    }
    add(out, "}");
}

static void type_argument(argument *a, char *text, const char *function)
{
    char *parts[PARTS];
    size_t count = split(text, " or ", parts);
    for (size_t i = 0; i < count; i++) {
        char *part = trim(parts[i]), options[TEXT];
        options_type(form_of(function) ? form_of(function)->function : function, options);
        if (strcmp(part, "{...}") == 0)
            add_type(a->type, form_of(function) ? options : "table");
        else if (part[0] == '{')
            type_table(a->type, part);
        else if (strcmp(part, "list") == 0 || strcmp(part, "hit") == 0)
            add_type(a->type, contents_of(function)), add_type(a->type, "table"); /* an empty one, the first time */
        else if (strcmp(part, "options") == 0 && strncmp(function, "query.", 6) == 0)
            add_type(a->type, "daft.query.ray.options");
        else if (part[0] == '"')
            add_type(a->type, "string");
        else if (strcmp(part, "options") == 0 && form_of(function))
            add_type(a->type, options);
        else
            add_type(a->type, type_of(strcmp(part, "function") == 0 ? "f" : part, ARGUMENTS, COUNT_OF(ARGUMENTS)));
    }
}

/* "(a, b [, c [, d]])" or "{...}": what comes after an opening bracket need not be given. */
static size_t read_arguments(const char *form, const char *function, argument out[PARTS])
{
    char text[TEXT], *parts[PARTS];
    const char *arrow = strstr(form, " -> ");
    int length = arrow ? (int)(arrow - form) : (int)strlen(form);
    snprintf(text, sizeof text, "%.*s", length, form);
    char *other = strstr(text, ") or {");
    const bool bare = text[0] == '{', either = other != NULL;
    if (other) *other = 0, other += strlen(") or ");
    char *inside = trim(text);
    if (!bare) inside++;
    if (!bare && !either && inside[0]) inside[strlen(inside) - 1] = 0;
    size_t brackets = 0, count = 0, total;
    total = split(inside, ",", parts);
    for (size_t i = 0; i < total && count < PARTS; i++) {
        char *part = trim(parts[i]);
        const bool opens_next = part[0] && part[strlen(part) - 1] == '[';
        const bool opened = part[0] == '[';
        if (opened) part = trim(part + 1), brackets++;
        part[strcspn(part, part[0] == '{' ? "" : "[]|")] = 0;
        if (part[0] == '{')
            for (size_t n = strlen(part); n && strchr(" []", part[n - 1]);) part[--n] = 0;
        part = trim(part);
        argument *a = &out[count];
        *a = (argument){.optional = brackets > 0};
        if (part[0] && strcmp(part, "...") != 0) {
            name_argument(a, part, out, count);
            type_argument(a, part, function);
            if (either) type_argument(a, other, function);
            count++;
        } else if (part[0]) {
            /* More of the same; to a function, whatever it takes. */
            strcpy(a->name, "...");
            snprintf(a->type, TEXT, "%s",
                     count && strcmp(out[count - 1].type, "function") != 0 ? out[count - 1].type : "any");
            a->optional = false, count++;
        }
        if (opens_next) brackets++;
    }
    return count;
}

/* "entity or nil, "ground", "air" or "crushed"": words of a choice that follow each other are one value. */
static size_t read_results(const char *form, const char *function, char out[PARTS][TEXT])
{
    const char *arrow = strstr(form, " -> ");
    if (!arrow) return 0;
    char text[TEXT], *parts[PARTS], *words[PARTS];
    snprintf(text, sizeof text, "%s", arrow + 4);
    size_t count = 0;
    bool choice = false, optional = false;
    if (text[0] == '-' || isdigit((unsigned char)text[0])) { /* "-1, 0 or 1" */
        strcpy(out[0], "number");
        return 1;
    }
    size_t total = split(text, ",", parts);
    for (size_t i = 0; i < total && count < PARTS; i++) {
        char *part = trim(parts[i]);
        part[strcspn(part, "]")] = 0;
        const bool opens = strchr(part, '[') != NULL;
        part[strcspn(part, "[")] = 0;
        const bool quoted = trim(part)[0] == '"';
        if (!(quoted && choice)) out[count++][0] = 0;
        size_t alternatives = split(trim(part), " or ", words);
        for (size_t k = 0; k < alternatives; k++) {
            const char *word = trim(words[k]);
            char first[40];
            snprintf(first, sizeof first, "%.*s", (int)strcspn(word, " "), word);
            const char *type = word[0] == '"'                   ? word
                               : strcmp(word, "{x, y, z}") == 0 ? "daft.vector"
                               : word[0] == '{'                 ? "table"
                                                                : type_of(first, RESULTS, COUNT_OF(RESULTS));
            add_type(out[count - 1], strcmp(type, "table") == 0 ? contents_of(function) : type);
        }
        if (optional) add_type(out[count - 1], "nil");
        optional |= opens;
        choice = quoted;
    }
    return count;
}

static void put_doc(const char *doc)
{
    for (const char *line = doc; line && *line;) {
        const size_t length = strcspn(line, "\n");
        printf("---%.*s\n", (int)length, line);
        line = line[length] ? line + length + 1 : NULL;
    }
}

/* "fun(a: number, b?: string): number" for tables that can be called. */
static void put_overload(const argument *arguments, size_t count, char results[PARTS][TEXT], size_t result_count)
{
    printf("---@overload fun(");
    for (size_t i = 0; i < count; i++)
        printf("%s%s%s: %s", i ? ", " : "", arguments[i].name, arguments[i].optional ? "?" : "", arguments[i].type);
    putchar(')');
    for (size_t i = 0; i < result_count; i++) printf("%s %s", i ? "," : ":", results[i]);
    putchar('\n');
}

static void put_function(const api_function *function)
{
    argument arguments[PARTS];
    char results[PARTS][TEXT];
    const size_t count = read_arguments(function->form, function->name, arguments);
    const size_t result_count = read_results(function->form, function->name, results);
    putchar('\n');
    put_doc(function->doc);
    for (size_t i = 0; i < count; i++)
        printf("---@param %s%s %s\n", arguments[i].name, arguments[i].optional ? "?" : "", arguments[i].type);
    for (size_t i = 0; i < result_count; i++) printf("---@return %s\n", results[i]);
    printf("function %s%s(", strchr(function->name, ':') ? "" : "daft.", function->name);
    for (size_t i = 0; i < count; i++) printf("%s%s", i ? ", " : "", arguments[i].name);
    puts(") end");
}

/* ---- tables and types ---- */

static bool is_inside(const char *name, const char *table)
{
    const size_t length = strlen(table);
    return strncmp(name, table, length) == 0 && name[length] == '.';
}

/* The function that is what calling the table does, or NULL. */
static const api_function *call_of(const char *table)
{
    size_t areas;
    const api_area *const *all = api_areas(&areas);
    for (size_t area = 0; area < areas; area++)
        for (size_t i = 0; i < all[area]->count; i++)
            if (strcmp(all[area]->functions[i].name, table) == 0) return &all[area]->functions[i];
    return NULL;
}

static bool has_members(const char *name)
{
    size_t areas;
    const api_area *const *all = api_areas(&areas);
    for (size_t area = 0; area < areas; area++)
        for (size_t i = 0; i < all[area]->count; i++)
            if (is_inside(all[area]->functions[i].name, name)) return true;
    return false;
}

static void put_table(const char *table)
{
    const api_function *call = call_of(table);
    putchar('\n');
    if (call) {
        argument arguments[PARTS];
        char results[PARTS][TEXT];
        put_doc(call->doc);
        printf("---@class daft.%s\n", table);
        const size_t count = read_arguments(call->form, call->name, arguments);
        put_overload(arguments, count, results, read_results(call->form, call->name, results));
    }
    printf("daft.%s = {}\n", table);
}

/* The tables within daft, each before what is in it. */
static void put_tables(void)
{
    size_t areas, count = 0;
    const api_area *const *all = api_areas(&areas);
    char done[64][40];
    for (size_t area = 0; area < areas; area++)
        for (size_t i = 0; i < all[area]->count; i++) {
            const char *name = all[area]->functions[i].name;
            if (strchr(name, ':')) continue;
            for (const char *dot = name; (dot = strchr(dot, '.')); dot++) {
                char table[40];
                bool known = false;
                snprintf(table, sizeof table, "%.*s", (int)(dot - name), name);
                for (size_t k = 0; k < count; k++) known |= strcmp(done[k], table) == 0;
                if (known || count == COUNT_OF(done)) continue;
                strcpy(done[count++], table);
                put_table(table);
            }
        }
}

/* The types of handles: what has methods. */
static void put_classes(void)
{
    size_t areas, count = 0;
    const api_area *const *all = api_areas(&areas);
    char done[64][40];
    for (size_t area = 0; area < areas; area++)
        for (size_t i = 0; i < all[area]->count; i++) {
            const char *name = all[area]->functions[i].name, *colon = strchr(name, ':');
            char type[40];
            bool known = !colon;
            snprintf(type, sizeof type, "%.*s", colon ? (int)(colon - name) : 0, name);
            for (size_t k = 0; k < count; k++) known |= strcmp(done[k], type) == 0;
            if (known || count == COUNT_OF(done)) continue;
            strcpy(done[count++], type);
            printf("\n---@class daft.%s\n", type);
            if (strcmp(type, "entity") == 0) puts("---@field name string?\n---@field data any");
            printf("local %s = {}\n", type);
        }
}

void api_print_annotations(void)
{
    puts("---@meta\n"
         "-- What games see as `daft`, for the Lua language server. `daft help annotations` prints this file: "
         "docs/tables.sh.\n"
         "\n---@alias daft.vector number[]|{x: number, y: number, z: number}\n"
         "---@alias daft.place daft.vector|daft.entity\n"
         "---@alias daft.color string|number[]\n"
         "---@alias daft.anymaterial string|daft.material|daft.material.options\n"
         "---@alias daft.value string|number|boolean|table|nil\n"
         "---@alias daft.shape {sphere?: number, box?: daft.vector, capsule?: {radius: number, height: number}, "
         "rotation?: "
         "number[]}\n"
         "---@class daft.font\n---@class daft.hit\n---@field entity daft.entity\n---@field distance number\n---@field "
         "position number[]\n"
         "---@field normal number[]\n---@field inside boolean?\n"
         "---@class daft.contact\n---@field other daft.entity\n---@field point daft.vector\n---@field normal "
         "daft.vector\n---@field impulse number\n"
         "---@class daft.event\n---@field kind string\n---@field a daft.entity?\n---@field b daft.entity?\n---@field "
         "joint daft.joint?\n"
         "---@field impulse number?\n---@field speed number?\n---@field point daft.vector?\n---@field normal "
         "daft.vector?\n"
         "---@class daft.clip\n---@field name string\n---@field duration number\n"
         "---@class daft.animation\n---@field clip string\n---@field time number\n---@field duration number\n---@field "
         "speed number\n"
         "---@field weight number\n---@field loop boolean\n---@field playing boolean");
    printf("\n---@class daft\n");
    size_t callbacks;
    const char *const *names = api_callbacks(&callbacks);
    for (size_t i = 0; i < callbacks; i++) {
        const char *arguments = strcmp(names[i], "update") == 0   ? "dt: number"
                                : strstr(names[i], "key")         ? "key: string"
                                : strstr(names[i], "text")        ? "letter: string"
                                : strcmp(names[i], "reload") == 0 ? "old: any"
                                                                  : "";
        printf("---@field %s? fun(%s)%s\n", names[i], arguments, strcmp(names[i], "keep") == 0 ? ": any" : "");
    }
    puts("daft = {}");
    put_tables();
    put_classes();
    put_option_classes();
    size_t areas;
    const api_area *const *all = api_areas(&areas);
    for (size_t area = 0; area < areas; area++)
        for (size_t i = 0; i < all[area]->count; i++)
            if (!has_members(all[area]->functions[i].name)) put_function(&all[area]->functions[i]);
    puts("\nwait, wait_until = daft.wait, daft.wait_until");
}
