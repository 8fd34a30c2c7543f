/* What is told about a script that has stopped. */
#include "lua/failure.h"

#include "lua/api.h"
#include "common/util.h"

#include <ctype.h>
#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Appends as much as fits. */
static void put(char *out, size_t size, const char *format, ...) __attribute__((format(printf, 3, 4)));
static void put(char *out, size_t size, const char *format, ...)
{
    const size_t used = strlen(out);
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(out + used, size - used, format, arguments);
    va_end(arguments);
}

/* Every call begins with this: no more than needs to be is written. */
void failure_clear(failure *self)
{
    self->message[0] = self->trace[0] = self->source[0] = self->values[0] = self->file[0] = 0;
}

/* ---- values ---- */

enum {
    ENTRIES = 6,     /* shown of a table */
    SCANNED = 4096,  /* keys of a table that are looked at: the first by name of these are shown */
    DEPTH = 2,       /* of tables within tables */
    VALUE_SIZE = 200 /* bytes of one value's text */
};

static void put_value(lua_State *L, int index, int depth, char *out, size_t size);

static void put_string(lua_State *L, int index, char *out, size_t size)
{
    enum { SHOWN = 48 };
    size_t length;
    const char *text = lua_tolstring(L, index, &length);
    char part[SHOWN + 1], safe[4 * SHOWN + 1];
    snprintf(part, sizeof part, "%s", text);
    put(out, size, "\"%s\"", daft_escape(part, safe, sizeof safe));
    if (length > SHOWN) put(out, size, "… (%zu bytes)", length);
}

static bool is_name(const char *text)
{
    static const char letters[] = "_abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789";
    return text[0] && !isdigit((unsigned char)text[0]) && text[strspn(text, letters)] == 0;
}

/* The names of the table at index that come first in the order of their bytes, whatever order the table has. */
static int first_names(lua_State *L, int index, const char *names[ENTRIES], size_t *others)
{
    int count = 0, scanned = 0;
    *others = 0;
    for (lua_pushnil(L); lua_next(L, index); lua_pop(L, 1)) {
        if (scanned++ == SCANNED) {
            lua_pop(L, 2);
            break;
        }
        const bool listed = lua_isinteger(L, -2) && lua_tointeger(L, -2) >= 1 && lua_tointeger(L, -2) <= ENTRIES;
        if (listed && lua_rawlen(L, index) >= (size_t)lua_tointeger(L, -2)) continue;
        const char *name = lua_type(L, -2) == LUA_TSTRING ? lua_tostring(L, -2) : NULL;
        if (!name || !is_name(name) || (count == ENTRIES && strcmp(name, names[ENTRIES - 1]) > 0)) {
            ++*others;
            continue;
        }
        if (count == ENTRIES) count--, ++*others;
        int at = count++;
        for (; at > 0 && strcmp(names[at - 1], name) > 0; at--) names[at] = names[at - 1];
        names[at] = name;
    }
    return count;
}

static void put_table(lua_State *L, int index, int depth, char *out, size_t size)
{
    const char *names[ENTRIES], *comma = "";
    size_t others;
    if (depth == DEPTH) {
        put(out, size, "{…}");
        return;
    }
    put(out, size, "{");
    for (lua_Integer i = 1; i <= ENTRIES; i++, comma = ", ") {
        const bool there = lua_rawgeti(L, index, i) != LUA_TNIL;
        if (there) put(out, size, "%s", comma), put_value(L, -1, depth + 1, out, size);
        lua_pop(L, 1);
        if (!there) break;
    }
    const int count = first_names(L, index, names, &others);
    for (int i = 0; i < count; i++, comma = ", ") {
        lua_pushstring(L, names[i]);
        lua_rawget(L, index);
        put(out, size, "%s%s = ", comma, names[i]);
        put_value(L, -1, depth + 1, out, size);
        lua_pop(L, 1);
    }
    put(out, size, others ? "%s…}" : "}", comma);
}

static void put_function(lua_State *L, int index, char *out, size_t size)
{
    lua_Debug about;
    lua_pushvalue(L, index);
    lua_getinfo(L, ">S", &about);
    if (about.linedefined > 0)
        put(out, size, "function (%s:%d)", about.short_src, about.linedefined);
    else
        put(out, size, "function");
}

static void put_handle(lua_State *L, int index, char *out, size_t size)
{
    const api_handle *handle = lua_touserdata(L, index);
    const char *type = api_type_name(L, index);
    put(out, size, "%s %" PRIu32, type, handle->id);
    if (strcmp(type, "entity") != 0) return;
    if (lua_getiuservalue(L, index, 1) == LUA_TTABLE) {
        lua_pushliteral(L, "name");
        if (lua_rawget(L, -2) == LUA_TSTRING) put(out, size, " "), put_string(L, -1, out, size);
        lua_pop(L, 1);
    }
    lua_pop(L, 1);
    if (!daft_entity_is_valid(api_host(L)->def.scene, (daft_entity){handle->id})) put(out, size, " (destroyed)");
}

static void put_value(lua_State *L, int index, int depth, char *out, size_t size)
{
    index = lua_absindex(L, index);
    if (strlen(out) + 8 > size || !lua_checkstack(L, 8)) return;
    switch (lua_type(L, index)) {
    case LUA_TNIL: put(out, size, "nil"); break;
    case LUA_TBOOLEAN: put(out, size, lua_toboolean(L, index) ? "true" : "false"); break;
    case LUA_TNUMBER:
        if (lua_isinteger(L, index))
            put(out, size, "%lld", (long long)lua_tointeger(L, index));
        else
            put(out, size, "%.14g", lua_tonumber(L, index));
        break;
    case LUA_TSTRING: put_string(L, index, out, size); break;
    case LUA_TTABLE: put_table(L, index, depth, out, size); break;
    case LUA_TFUNCTION: put_function(L, index, out, size); break;
    case LUA_TTHREAD: put(out, size, "coroutine"); break;
    default: put_handle(L, index, out, size); break;
    }
}

void failure_describe(lua_State *L, int index, char *out, size_t size)
{
    char text[VALUE_SIZE] = "";
    put_value(L, index, 0, text, sizeof text);
    put(out, size, "%s", text);
}

/* ---- variables ---- */

/* Takes the variable's value from the top. */
static void put_variable(failure *self, lua_State *L, const char *name)
{
    put(self->values, sizeof self->values, "\n\t%s = ", name);
    failure_describe(L, -1, self->values, sizeof self->values);
    lua_pop(L, 1);
}

/* A later variable of the same name hides this one. */
static bool is_hidden(lua_State *L, const lua_Debug *level, int number, const char *name)
{
    for (const char *other; (other = lua_getlocal(L, level, ++number)) != NULL;) {
        lua_pop(L, 1);
        if (strcmp(other, name) == 0) return true;
    }
    return false;
}

enum { MOST_VARIABLES = 24 };

static void put_level(failure *self, lua_State *L, lua_Debug *level)
{
    int shown = 0;
    lua_getinfo(L, "nSlf", level);
    put(self->values, sizeof self->values, level->name ? "values in '%s' (%s:%d):" : "values in the %s (%s:%d):",
        level->name                        ? level->name
        : strcmp(level->what, "main") == 0 ? "main chunk"
                                           : "function",
        level->short_src, level->currentline);
    for (int i = 1; shown < MOST_VARIABLES; i++) {
        const char *name = lua_getlocal(L, level, i);
        if (!name) break;
        if (name[0] == '(' || is_hidden(L, level, i, name))
            lua_pop(L, 1);
        else
            put_variable(self, L, name), shown++;
    }
    for (int i = 1; shown < MOST_VARIABLES; i++) {
        const char *name = lua_getupvalue(L, -1, i);
        if (!name) break;
        if (strcmp(name, "_ENV") == 0 || lua_isfunction(L, -1))
            lua_pop(L, 1);
        else
            put_variable(self, L, name), shown++;
    }
    lua_pop(L, 1);
    if (shown == 0) self->values[0] = 0;
}

static bool is_named(const lua_Debug *level, const char *message)
{
    char place[LUA_IDSIZE + 16];
    snprintf(place, sizeof place, "%s:%d:", level->short_src, level->currentline);
    return strncmp(message, place, strlen(place)) == 0;
}

void failure_take_values(failure *self, lua_State *L, int level, const char *message)
{
    enum { MOST_LEVELS = 64 };
    lua_Debug place, first;
    bool found = false, exact = false;
    if (self->values[0] || !lua_checkstack(L, 16)) return;
    for (int end = level + MOST_LEVELS; level < end && !exact && lua_getstack(L, level, &place); level++) {
        if (!lua_getinfo(L, "Sl", &place) || place.currentline <= 0) continue;
        exact = is_named(&place, message);
        if (!found || exact) first = place;
        found = true;
    }
    if (found) put_level(self, L, &first);
}

/* ---- the source ---- */

/* Of "NAME/FILE:LINE: …": the line, and FILE within the game's roots. False: the message names none. */
static bool parse_place(const char *message, char *file, size_t size, int *line)
{
    const char *colon = strstr(message, ".lua:"), *slash = strchr(message, '/');
    if (!colon || !slash || slash > colon) return false;
    const int length = (int)(colon + 4 - (slash + 1));
    if (snprintf(file, size, "%.*s", length, slash + 1) >= (int)size) return false;
    return sscanf(colon + 5, "%d:", line) == 1 && *line > 0;
}

static const char *end_of_line(const char *at) { return at + strcspn(at, "\n"); }

void failure_find_source(failure *self, const daft_files *files)
{
    enum { AROUND = 3, SHOWN = 120 };
    char name[PATH_SIZE];
    daft_error error;
    size_t size;
    self->source[0] = self->file[0] = 0;
    if (!parse_place(self->message, name, sizeof name, &self->line) ||
        !daft_files_find(files, name, self->file, sizeof self->file))
        return;
    char *text = daft_read_file(files, self->file, &size, &error);
    int number = 1;
    for (const char *at = text; at && *at && number <= self->line + AROUND; number++) {
        const char *end = end_of_line(at);
        int length = (int)(end - at > SHOWN ? SHOWN : end - at);
        while (length > 0 && (at[length] & 0xC0) == 0x80) length--; /* not within a character */
        if (length > 0 && at[length - 1] == '\r') length--;
        if (number >= self->line - AROUND)
            put(self->source, sizeof self->source, "%s%c %4d | %.*s", self->source[0] ? "\n" : "",
                number == self->line ? '>' : ' ', number, length, at);
        at = *end ? end + 1 : end;
    }
    free(text);
}

/* ---- all of it ---- */

const char *failure_text(const failure *self, char *out, size_t size)
{
    out[0] = 0;
    put(out, size, "%s\n", self->message);
    if (self->source[0]) put(out, size, "%s\n", self->source);
    if (self->trace[0]) put(out, size, "%s\n", self->trace);
    if (self->values[0]) put(out, size, "%s\n", self->values);
    return out;
}
