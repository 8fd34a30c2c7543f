/* Values that outlast the game: daft.save and daft.load_saved. A value becomes one line of text, as Lua would write it
 * with its keys in order, so that the same value is always the same text; and only that is read back. */
#include "lua/api.h"

#include "common/util.h"
#include "files/saves.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { DEEPEST = 32 };

/* ---- writing ---- */

typedef struct save_writer {
    lua_State *L;
    host *h;
    char *text; /* a userdata, at TEXT on the stack */
    size_t size, capacity;
    bool lenient; /* what cannot be written is nil, or left out where it is a key */
} save_writer;

enum { TEXT = 3 };

static void grow(save_writer *w, size_t needed)
{
    size_t capacity = w->capacity ? w->capacity : 1024;
    while (capacity < needed) capacity *= 2;
    char *more = lua_newuserdatauv(w->L, capacity, 0);
    if (w->size) memcpy(more, w->text, w->size);
    lua_replace(w->L, TEXT);
    w->text = more, w->capacity = capacity;
}

static void put(save_writer *w, const char *bytes, size_t size)
{
    if (size > SAVES_SIZE - w->size) api_error(w->L, w->h, "the value takes more than %d bytes", SAVES_SIZE);
    if (w->size + size >= w->capacity) grow(w, w->size + size + 1);
    memcpy(w->text + w->size, bytes, size);
    w->size += size;
    api_poll(w->L, 1);
}

static void put_string(save_writer *w, const char *s, size_t length)
{
    put(w, "\"", 1);
    for (size_t i = 0; i < length; i++) {
        const unsigned char c = (unsigned char)s[i];
        char escape[8];
        if (c == '"' || c == '\\')
            put(w, escape, (size_t)snprintf(escape, sizeof escape, "\\%c", c));
        else if (c < 32 || c == 127)
            put(w, escape, (size_t)snprintf(escape, sizeof escape, "\\x%02x", c));
        else
            put(w, &s[i], 1);
    }
    put(w, "\"", 1);
}

/* A float has a point, an exponent or both, so that it comes back as one. */
static void put_number(save_writer *w, int index)
{
    char text[40];
    if (lua_isinteger(w->L, index)) {
        put(w, text, (size_t)snprintf(text, sizeof text, "%lld", (long long)lua_tointeger(w->L, index)));
        return;
    }
    const double value = lua_tonumber(w->L, index);
    if (!isfinite(value) && w->lenient) {
        put(w, "nil", 3);
        return;
    }
    if (!isfinite(value)) api_error(w->L, w->h, "a number that is not finite cannot be saved");
    size_t length = (size_t)snprintf(text, sizeof text, "%.17g", value);
    if (!strpbrk(text, ".e")) length += (size_t)snprintf(text + length, sizeof text - length, ".0");
    put(w, text, length);
}

static void put_value(save_writer *w, int index, int depth);

typedef struct key {
    bool is_text;
    lua_Integer number;
    const char *text; /* the table holds it */
    size_t length;
} key;

static int by_key(const void *a, const void *b)
{
    const key *x = a, *y = b;
    if (x->is_text != y->is_text) return x->is_text ? 1 : -1;
    if (!x->is_text) return (x->number > y->number) - (x->number < y->number);
    const int order = memcmp(x->text, y->text, x->length < y->length ? x->length : y->length);
    return order ? order : (x->length > y->length) - (x->length < y->length);
}

/* Pushes a userdata with the table's keys in order. */
static key *sorted_keys(save_writer *w, int table, size_t *count)
{
    lua_State *L = w->L;
    size_t all = 0;
    for (lua_pushnil(L); lua_next(L, table); lua_pop(L, 1), all++) {
        if (all > SAVES_SIZE) api_error(L, w->h, "the value takes more than %d bytes", SAVES_SIZE);
        api_poll(L, 1);
    }
    key *keys = lua_newuserdatauv(L, all * sizeof *keys, 0);
    *count = 0;
    for (lua_pushnil(L); lua_next(L, table); lua_pop(L, 1)) {
        key *k = &keys[(*count)++];
        *k = (key){.is_text = lua_type(L, -2) == LUA_TSTRING};
        if (k->is_text)
            k->text = lua_tolstring(L, -2, &k->length);
        else if (lua_isinteger(L, -2))
            k->number = lua_tointeger(L, -2);
        else if (w->lenient)
            --*count;
        else
            api_error(L, w->h, "a table's keys must be strings or whole numbers to be saved");
    }
    qsort(keys, *count, sizeof *keys, by_key);
    return keys;
}

static void put_table(save_writer *w, int table, int depth)
{
    lua_State *L = w->L;
    size_t count;
    if (depth == DEEPEST && w->lenient) {
        put(w, "nil", 3);
        return;
    }
    if (depth == DEEPEST) api_error(L, w->h, "tables nest deeper than %d, or hold themselves", DEEPEST);
    luaL_checkstack(L, 8, "too many tables");
    const key *keys = sorted_keys(w, table, &count);
    put(w, "{", 1);
    for (size_t i = 0; i < count; i++) {
        char text[40];
        if (keys[i].is_text) {
            put(w, "[", 1);
            put_string(w, keys[i].text, keys[i].length);
            put(w, "]=", 2);
            lua_pushlstring(L, keys[i].text, keys[i].length);
        } else {
            put(w, text, (size_t)snprintf(text, sizeof text, "[%lld]=", (long long)keys[i].number));
            lua_pushinteger(L, keys[i].number);
        }
        lua_rawget(L, table);
        put_value(w, lua_gettop(L), depth + 1);
        lua_pop(L, 1);
        if (i + 1 < count) put(w, ",", 1);
    }
    put(w, "}", 1);
    lua_pop(L, 1);
}

static void put_value(save_writer *w, int index, int depth)
{
    size_t length;
    const char *text;
    switch (lua_type(w->L, index)) {
    case LUA_TNIL: put(w, "nil", 3); return;
    case LUA_TBOOLEAN: text = lua_toboolean(w->L, index) ? "true" : "false", put(w, text, strlen(text)); return;
    case LUA_TNUMBER: put_number(w, index); return;
    case LUA_TSTRING: text = lua_tolstring(w->L, index, &length), put_string(w, text, length); return;
    case LUA_TTABLE: put_table(w, index, depth); return;
    default:
        if (!w->lenient) api_error(w->L, w->h, "a %s cannot be saved", luaL_typename(w->L, index));
        put(w, "nil", 3);
    }
}

/* ---- reading ---- */

typedef struct save_reader {
    lua_State *L;
    const char *begin, *at;
    const char *wrong; /* what was expected where it stopped; NULL: nothing is wrong */
} save_reader;

static bool wrong(save_reader *r, const char *expected)
{
    r->wrong = expected;
    return false;
}

static bool take(save_reader *r, const char *word)
{
    const size_t length = strlen(word);
    if (strncmp(r->at, word, length) != 0) return false;
    r->at += length;
    return true;
}

static int hex(char c) { return c >= '0' && c <= '9' ? c - '0' : c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1; }

/* Pushes it. */
static bool read_string(save_reader *r)
{
    luaL_Buffer out;
    luaL_buffinit(r->L, &out);
    for (r->at++; *r->at != '"'; r->at++) {
        char c = *r->at;
        if (c == '\\' && (r->at[1] == '"' || r->at[1] == '\\')) {
            c = *++r->at;
        } else if (c == '\\' && r->at[1] == 'x' && hex(r->at[2]) >= 0 && hex(r->at[3]) >= 0) {
            c = (char)(hex(r->at[2]) * 16 + hex(r->at[3]));
            r->at += 3;
        } else if (c == '\\' || c == 0) {
            luaL_pushresult(&out);
            return wrong(r, c ? "one of \\\", \\\\ and \\x00 expected" : "the end of a string expected");
        }
        luaL_addchar(&out, c);
    }
    r->at++;
    luaL_pushresult(&out);
    return true;
}

static bool read_number(save_reader *r)
{
    char *end, *whole_end;
    errno = 0;
    const long long whole = strtoll(r->at, &whole_end, 10);
    const bool fits = errno == 0;
    const double value = strtod(r->at, &end);
    if (end == r->at || !isfinite(value) || isalpha((unsigned char)r->at[0])) return wrong(r, "a value expected");
    if (whole_end == end && fits)
        lua_pushinteger(r->L, whole);
    else
        lua_pushnumber(r->L, value);
    r->at = end;
    return true;
}

static bool read_value(save_reader *r, int depth);

static bool read_table(save_reader *r, int depth)
{
    if (depth == DEEPEST) return wrong(r, "fewer tables in each other expected");
    luaL_checkstack(r->L, 8, "too many tables");
    r->at++;
    lua_newtable(r->L);
    if (take(r, "}")) return true;
    do {
        if (!take(r, "[")) return wrong(r, "'[' expected");
        const char *place = r->at;
        if (!(*r->at == '"' ? read_string(r) : read_number(r))) return false;
        if (*place != '"' && !lua_isinteger(r->L, -1))
            return r->at = place, wrong(r, "a string or a whole number expected");
        if (!take(r, "]=")) return wrong(r, "']=' expected");
        if (!read_value(r, depth + 1)) return false;
        lua_rawset(r->L, -3);
        api_poll(r->L, 1);
    } while (take(r, ","));
    return take(r, "}") || wrong(r, "',' or '}' expected");
}

/* Pushes the value; where it fails, what it has pushed so far stays. */
static bool read_value(save_reader *r, int depth)
{
    if (*r->at == '{') return read_table(r, depth);
    if (*r->at == '"') return read_string(r);
    const bool yes = take(r, "true");
    if (yes || take(r, "false")) {
        lua_pushboolean(r->L, yes);
        return true;
    }
    if (take(r, "nil")) {
        lua_pushnil(r->L);
        return true;
    }
    return read_number(r);
}

/* ---- what live reload hands over ---- */

/* Pushes a table of the global variables that are the game's: no libraries, no functions. */
static void push_globals(lua_State *L)
{
    lua_newtable(L);
    const int out = lua_gettop(L);
    lua_pushglobaltable(L);
    luaL_getsubtable(L, LUA_REGISTRYINDEX, LUA_LOADED_TABLE);
    for (lua_pushnil(L); lua_next(L, out + 1); lua_pop(L, 1)) {
        const bool named = lua_type(L, -2) == LUA_TSTRING,
                   version = named && strcmp(lua_tostring(L, -2), "_VERSION") == 0;
        if (!named || version || lua_isfunction(L, -1)) continue;
        lua_pushvalue(L, -2);
        lua_rawget(L, out + 2);
        const bool library = lua_rawequal(L, -1, -2);
        lua_pop(L, 1);
        if (library) continue;
        lua_pushvalue(L, -2);
        lua_pushvalue(L, -2);
        lua_rawset(L, out);
    }
    lua_settop(L, out);
}

int api_hand_over(lua_State *L)
{
    static const api_function KEEP = {"keep", "", "", NULL, 0};
    host *h = api_host(L);
    lua_settop(L, TEXT);
    api_push(L);
    lua_pushliteral(L, "keep");
    lua_rawget(L, -2);
    const bool own = lua_isfunction(L, -1);
    if (own)
        lua_call(L, 0, 1);
    else
        push_globals(L);
    lua_replace(L, 2);
    save_writer w = {.L = L, .h = h, .lenient = !own};
    h->calling = &KEEP;
    put_value(&w, 2, 0);
    free(h->handed);
    h->handed = malloc(w.size + 1);
    if (!h->handed) return luaL_error(L, "not enough memory");
    memcpy(h->handed, w.text, w.size);
    h->handed[w.size] = 0;
    return 0;
}

void api_push_handed(lua_State *L, const char *text)
{
    save_reader r = {.L = L, .begin = text, .at = text};
    if (!read_value(&r, 0)) luaL_error(L, "what daft.keep handed over cannot be read");
}

/* ---- the functions ---- */

static const char *check_name(lua_State *L, host *h)
{
    size_t length;
    const char *name = lua_type(L, 1) == LUA_TSTRING ? lua_tolstring(L, 1, &length) : NULL;
    if (!name || strlen(name) != length || !saves_is_name(name))
        api_wrong(L, h, 1, "name", "string of up to 64 letters, digits, '_' and '-'");
    return name;
}

static int save(lua_State *L, host *h)
{
    const char *name = check_name(L, h);
    lua_settop(L, TEXT);
    save_writer w = {.L = L, .h = h};
    put_value(&w, 2, 0);
    w.text[w.size] = 0;
    daft_error error;
    if (!saves_put(h->def.saves, name, w.text, &error)) api_engine_error(L, h, &error);
    return 0;
}

static int load_saved(lua_State *L, host *h)
{
    const char *name = check_name(L, h), *text;
    daft_error error;
    if (!saves_get(h->def.saves, name, &text, &error)) {
        char message[HOST_MESSAGE];
        lua_pushnil(L);
        lua_pushstring(L, daft_error_text(&error, message, sizeof message));
        return 2;
    }
    if (!text) return 0;
    save_reader r = {.L = L, .begin = text, .at = text};
    const int top = lua_gettop(L);
    if (read_value(&r, 0) && *r.at == 0) return 1;
    saves_mark_broken(h->def.saves, name);
    lua_settop(L, top);
    lua_pushnil(L);
    lua_pushfstring(L, "'%s' was changed: line 2, column %d: %s", name, (int)(r.at - r.begin) + 1,
                    r.wrong ? r.wrong : "the end expected");
    return 2;
}

static const api_function FUNCTIONS[] = {
    {"save", "(name, value)",
     "Keeps a value for later starts: numbers, strings, booleans, and tables of them with strings or\n"
     "whole numbers as keys, up to a million bytes. A crash or a power cut leaves the old value or the new\n"
     "one. nil forgets it. While a recording plays nothing is written.",
     save, API_CHANGES},
    {"load_saved", "(name) -> value or nil [, message]",
     "What was saved last, in this start or an earlier one. The message says why a file cannot be read; it\n"
     "is kept beside the next one. Recordings hold what was loaded. A run without a window begins with nothing.",
     load_saved, 0},
};

const api_area api_save = {"Saves", FUNCTIONS, COUNT_OF(FUNCTIONS)};
