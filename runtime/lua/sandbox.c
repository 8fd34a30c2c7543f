/* The standard library as a game sees it: the same input must give the same game on every machine, and a game must not
 * reach beyond its folder. So:
 *   - io, os, package and most of debug are not there (debug.traceback is); using io or os says so;
 *   - load takes text only; dofile and loadfile are not there;
 *   - math's functions come from libdaft, since libm's last bits differ between systems; `^` with the exponent 2
 *     is exact, other exponents are libm's: use math.pow where a replay depends on it;
 *   - math.random and math.randomseed are daft.random and daft.randomseed;
 *   - pairs() goes in a fixed order: numbers rising, strings in the order of their bytes, false and true, then the
 *     rest in no fixed order (Lua's own order hangs on addresses);
 *   - table.sort is a stable merge sort (Lua's own picks pivots by the clock);
 *   - pcall, xpcall and coroutines pass on the error with which the watchdog stops a script;
 *   - there is no __gc, and functions that would loop for ever out of the watchdog's sight refuse to. */
#include "lua/api.h"

#include "common/util.h"
#include "lua/patterns.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- pairs ---- */

typedef enum key_kind { KEY_NUMBER, KEY_STRING, KEY_BOOLEAN, KEY_OTHER } key_kind;

typedef struct key_entry {
    key_kind kind;
    long double number; /* holds every integer and every double of Lua exactly */
    const char *text;   /* stays where it is while the table holds it */
    size_t length;
    lua_Integer place; /* in the order of next() */
} key_entry;

static int by_key(const void *left, const void *right)
{
    const key_entry *a = left, *b = right;
    if (a->kind != b->kind) return a->kind < b->kind ? -1 : 1;
    if (a->kind == KEY_NUMBER || a->kind == KEY_BOOLEAN) return a->number < b->number ? -1 : a->number > b->number;
    if (a->kind == KEY_STRING) {
        int order = memcmp(a->text, b->text, a->length < b->length ? a->length : b->length);
        return order ? order : a->length < b->length ? -1 : a->length > b->length;
    }
    return a->place < b->place ? -1 : a->place > b->place;
}

static key_entry describe_key(lua_State *L, int index, lua_Integer place)
{
    key_entry entry = {.kind = KEY_OTHER, .place = place};
    switch (lua_type(L, index)) {
    case LUA_TNUMBER:
        entry.kind = KEY_NUMBER;
        entry.number =
            lua_isinteger(L, index) ? (long double)lua_tointeger(L, index) : (long double)lua_tonumber(L, index);
        break;
    case LUA_TSTRING:
        entry.kind = KEY_STRING;
        entry.text = lua_tolstring(L, index, &entry.length);
        break;
    case LUA_TBOOLEAN:
        entry.kind = KEY_BOOLEAN;
        entry.number = lua_toboolean(L, index);
        break;
    default: break;
    }
    return entry;
}

/* Upvalues: the table, the list of keys, how many have been given. Keys that are gone by now are passed over. */
static int next_pair(lua_State *L)
{
    lua_Integer place = lua_tointeger(L, lua_upvalueindex(3));
    for (;;) {
        place++;
        if (lua_rawgeti(L, lua_upvalueindex(2), place) == LUA_TNIL) return 1;
        lua_pushvalue(L, -1);
        if (lua_rawget(L, lua_upvalueindex(1)) != LUA_TNIL) break;
        lua_pop(L, 2);
    }
    lua_pushinteger(L, place);
    lua_replace(L, lua_upvalueindex(3));
    return 2;
}

/* Leaves the sorted list of the keys of the table at 1 on the stack. */
static void push_keys(lua_State *L)
{
    lua_Integer count = 0;
    for (lua_pushnil(L); lua_next(L, 1); lua_pop(L, 1)) count++;
    key_entry *entries = lua_newuserdatauv(L, (size_t)(count + 1) * sizeof *entries, 0);
    lua_createtable(L, (int)count, 0);
    lua_Integer place = 0;
    for (lua_pushnil(L); lua_next(L, 1) && place < count;) {
        lua_pop(L, 1);
        entries[place] = describe_key(L, -1, place + 1);
        lua_pushvalue(L, -1);
        lua_rawseti(L, -3, ++place);
    }
    qsort(entries, (size_t)count, sizeof *entries, by_key);
    lua_createtable(L, (int)count, 0);
    for (lua_Integer i = 0; i < count; i++) {
        lua_rawgeti(L, -2, entries[i].place);
        lua_rawseti(L, -2, i + 1);
    }
}

static int pairs(lua_State *L)
{
    luaL_checkany(L, 1);
    if (luaL_getmetafield(L, 1, "__pairs") != LUA_TNIL) {
        lua_pushvalue(L, 1);
        lua_call(L, 1, 3);
        return 3;
    }
    luaL_checktype(L, 1, LUA_TTABLE);
    lua_settop(L, 1);
    lua_pushvalue(L, 1);
    push_keys(L);
    lua_replace(L, 3);
    lua_settop(L, 3);
    lua_pushinteger(L, 0);
    lua_pushcclosure(L, next_pair, 3);
    lua_pushvalue(L, 1);
    lua_pushnil(L);
    return 3;
}

/* ---- sort ---- */

/* Whether the value at `a` must come before the one at `b`, by the function at 2 or by <. */
static bool comes_before(lua_State *L, int a, int b)
{
    a = lua_absindex(L, a), b = lua_absindex(L, b);
    if (lua_isnil(L, 2)) return lua_compare(L, a, b, LUA_OPLT);
    lua_pushvalue(L, 2);
    lua_pushvalue(L, a);
    lua_pushvalue(L, b);
    lua_call(L, 2, 1);
    bool before = lua_toboolean(L, -1);
    lua_pop(L, 1);
    return before;
}

/* Merges [low, middle) and [middle, high) of the list at `from` into the one at `to`. */
static void merge(lua_State *L, int from, int to, lua_Integer low, lua_Integer middle, lua_Integer high)
{
    lua_Integer left = low, right = middle;
    for (lua_Integer out = low; out < high; out++) {
        lua_rawgeti(L, from, left < middle ? left : right);
        lua_rawgeti(L, from, right < high ? right : left);
        bool take_right = left >= middle || (right < high && comes_before(L, -1, -2));
        if (!take_right) lua_pop(L, 1);
        lua_rawseti(L, to, out);
        if (take_right) lua_pop(L, 1);
        if (take_right)
            right++;
        else
            left++;
    }
}

/* Sorted in two lists of its own, so that a comparison that fails leaves the table as it was. */
static int sort(lua_State *L)
{
    luaL_checktype(L, 1, LUA_TTABLE);
    if (!lua_isnoneornil(L, 2)) luaL_checktype(L, 2, LUA_TFUNCTION);
    lua_settop(L, 2);
    lua_Integer count = luaL_len(L, 1);
    luaL_argcheck(L, count < INT32_MAX, 1, "too long to sort");
    lua_createtable(L, (int)(count > 0 ? count : 0), 0);
    lua_createtable(L, (int)(count > 0 ? count : 0), 0);
    for (lua_Integer i = 1; i <= count; i++) {
        lua_geti(L, 1, i);
        lua_rawseti(L, 3, i);
    }
    int from = 3, to = 4;
    for (lua_Integer width = 1; width < count; width *= 2) {
        for (lua_Integer low = 1; low <= count; low += 2 * width) {
            lua_Integer middle = low + width < count + 1 ? low + width : count + 1;
            lua_Integer high = low + 2 * width < count + 1 ? low + 2 * width : count + 1;
            merge(L, from, to, low, middle, high);
        }
        int other = from;
        from = to, to = other;
    }
    for (lua_Integer i = 1; i <= count; i++) {
        lua_rawgeti(L, from, i);
        lua_seti(L, 1, i);
    }
    return 0;
}

/* ---- math ---- */

static double argument(lua_State *L, int index) { return luaL_checknumber(L, index); }

static int push_number(lua_State *L, double value)
{
    lua_pushnumber(L, value);
    return 1;
}

static const double LOG2_E = 1.4426950408889634;

static int m_sin(lua_State *L) { return push_number(L, daft_sin(argument(L, 1))); }
static int m_cos(lua_State *L) { return push_number(L, daft_cos(argument(L, 1))); }
static int m_tan(lua_State *L) { return push_number(L, daft_tan(argument(L, 1))); }
static int m_asin(lua_State *L) { return push_number(L, daft_asin(argument(L, 1))); }
static int m_acos(lua_State *L) { return push_number(L, daft_acos(argument(L, 1))); }
static int m_atan(lua_State *L) { return push_number(L, daft_atan2(argument(L, 1), luaL_optnumber(L, 2, 1))); }
static int m_exp(lua_State *L) { return push_number(L, daft_exp2(argument(L, 1) * LOG2_E)); }
static int m_sqrt(lua_State *L) { return push_number(L, sqrt(argument(L, 1))); }

static int m_log(lua_State *L)
{
    double x = argument(L, 1);
    if (x < 0) return push_number(L, (double)NAN);
    if (lua_isnoneornil(L, 2)) return push_number(L, daft_log2(x) / LOG2_E);
    return push_number(L, daft_log2(x) / daft_log2(argument(L, 2)));
}

static int m_pow(lua_State *L)
{
    double base = argument(L, 1), exponent = argument(L, 2);
    if (base >= 0) return push_number(L, daft_pow(base, exponent));
    if (exponent != floor(exponent)) return push_number(L, (double)NAN);
    double size = daft_pow(-base, exponent);
    return push_number(L, fmod(exponent, 2) == 0 ? size : -size);
}

static const luaL_Reg MATH[] = {{"sin", m_sin},   {"cos", m_cos},   {"tan", m_tan}, {"asin", m_asin},
                                {"acos", m_acos}, {"atan", m_atan}, {"exp", m_exp}, {"sqrt", m_sqrt},
                                {"log", m_log},   {"pow", m_pow},   {NULL, NULL}};

/* ---- code and protected calls ---- */

/* load with text only, and with the game's globals. */
static int load(lua_State *L)
{
    size_t length;
    const char *text = luaL_checklstring(L, 1, &length), *name = luaL_optstring(L, 2, text);
    bool has_environment = !lua_isnone(L, 4);
    if (luaL_loadbufferx(L, text, length, name, "t") != LUA_OK) {
        lua_pushnil(L);
        lua_insert(L, -2);
        return 2;
    }
    if (has_environment) {
        lua_pushvalue(L, 4);
        if (!lua_setupvalue(L, -2, 1)) lua_pop(L, 1);
    }
    return 1;
}

/* Calls the original (the first upvalue); when the watchdog has stopped the script in it, the error goes on. */
static int pass_on(lua_State *L, int status, lua_KContext context)
{
    (void)status, (void)context;
    if (api_host(L)->stopped) return luaL_error(L, "%s was stopped", api_host(L)->callback);
    return lua_gettop(L);
}

static int guarded(lua_State *L)
{
    lua_pushvalue(L, lua_upvalueindex(1));
    lua_insert(L, 1);
    lua_callk(L, lua_gettop(L) - 1, LUA_MULTRET, 0, pass_on);
    return pass_on(L, LUA_OK, 0);
}

/* ---- what the watchdog cannot see ---- */

/* Lua calls no hook within a finalizer; and when finalizers run depends on memory, so that replays could differ. */
static int set_metatable(lua_State *L)
{
    luaL_checktype(L, 1, LUA_TTABLE);
    luaL_argexpected(L, lua_istable(L, 2) || lua_isnil(L, 2), 2, "nil or table");
    if (luaL_getmetafield(L, 1, "__metatable") != LUA_TNIL) return luaL_error(L, "cannot change a protected metatable");
    lua_settop(L, 2);
    if (lua_istable(L, 2)) {
        lua_pushliteral(L, "__gc");
        if (lua_rawget(L, 2) != LUA_TNIL) return luaL_error(L, "setmetatable: __gc is not there in games");
        lua_pop(L, 1);
    }
    lua_setmetatable(L, 1);
    return 1;
}

/* Nor within these functions, which loop as often as their arguments say. What fits into memory stays far below. */
static const lua_Integer MOST_ELEMENTS = 100000000;

static int call_original(lua_State *L)
{
    lua_pushvalue(L, lua_upvalueindex(1));
    lua_insert(L, 1);
    lua_call(L, lua_gettop(L) - 1, LUA_MULTRET);
    return lua_gettop(L);
}

/* table.insert and table.remove move the rest of a list, whose length may come from __len. */
static int with_short_list(lua_State *L)
{
    if (lua_istable(L, 1) && luaL_len(L, 1) > MOST_ELEMENTS) return luaL_argerror(L, 1, "the list is too long");
    return call_original(L);
}

static int move(lua_State *L)
{
    lua_Integer first = luaL_checkinteger(L, 2), last = luaL_checkinteger(L, 3);
    if (last >= first && (lua_Unsigned)last - (lua_Unsigned)first > (lua_Unsigned)MOST_ELEMENTS)
        return luaL_argerror(L, 3, "too many elements to move");
    return call_original(L);
}

/* string.rep copies an empty string as often as it is told. */
static int repeat(lua_State *L)
{
    size_t length, between = 0;
    luaL_checklstring(L, 1, &length);
    luaL_checkinteger(L, 2);
    luaL_optlstring(L, 3, "", &between);
    if (length + between > 0) return call_original(L);
    lua_pushliteral(L, "");
    return 1;
}

/* Replaces the function `name` of the table on top by `wrapper`, whose upvalue is the original. */
static void wrap(lua_State *L, const char *name, lua_CFunction wrapper)
{
    lua_getfield(L, -1, name);
    lua_pushcclosure(L, wrapper, 1);
    lua_setfield(L, -2, name);
}

/* ---- the whole ---- */

static int not_there(lua_State *L)
{
    return luaL_error(L, "%s is not there in games: they can be replayed and cannot reach beyond their folder",
                      lua_tostring(L, lua_upvalueindex(1)));
}

static void forbid(lua_State *L, const char *name)
{
    lua_newtable(L);
    lua_newtable(L);
    lua_pushstring(L, name);
    lua_pushcclosure(L, not_there, 1);
    lua_setfield(L, -2, "__index");
    lua_setmetatable(L, -2);
    lua_setglobal(L, name);
}

static void open_debug(lua_State *L)
{
    luaL_requiref(L, LUA_DBLIBNAME, luaopen_debug, 0);
    lua_newtable(L);
    lua_getfield(L, -2, "traceback");
    lua_setfield(L, -2, "traceback");
    lua_pushvalue(L, -1);
    lua_setglobal(L, LUA_DBLIBNAME);
    luaL_getsubtable(L, LUA_REGISTRYINDEX, LUA_LOADED_TABLE);
    lua_pushvalue(L, -2);
    lua_setfield(L, -2, LUA_DBLIBNAME);
    lua_pop(L, 3);
}

static int random_from_daft(lua_State *L)
{
    api_push(L);
    lua_getfield(L, -1, lua_tostring(L, lua_upvalueindex(1)));
    lua_replace(L, -2);
    lua_insert(L, 1);
    lua_call(L, lua_gettop(L) - 1, LUA_MULTRET);
    return lua_gettop(L);
}

void sandbox_open(lua_State *L)
{
    const luaL_Reg libraries[] = {{LUA_GNAME, luaopen_base},       {LUA_COLIBNAME, luaopen_coroutine},
                                  {LUA_TABLIBNAME, luaopen_table}, {LUA_STRLIBNAME, luaopen_string},
                                  {LUA_MATHLIBNAME, luaopen_math}, {LUA_UTF8LIBNAME, luaopen_utf8}};
    for (size_t i = 0; i < COUNT_OF(libraries); i++) {
        luaL_requiref(L, libraries[i].name, libraries[i].func, 1);
        lua_pop(L, 1);
    }
    open_debug(L);
    const luaL_Reg globals[] = {{"pairs", pairs}, {"load", load}, {"setmetatable", set_metatable}, {NULL, NULL}};
    lua_pushglobaltable(L);
    luaL_setfuncs(L, globals, 0);
    wrap(L, "pcall", guarded);
    wrap(L, "xpcall", guarded);
    lua_pushnil(L);
    lua_setfield(L, -2, "dofile");
    lua_pushnil(L);
    lua_setfield(L, -2, "loadfile");
    lua_getfield(L, -1, LUA_MATHLIBNAME);
    luaL_setfuncs(L, MATH, 0);
    static const char *const randoms[] = {"random", "randomseed"};
    for (size_t i = 0; i < COUNT_OF(randoms); i++) {
        lua_pushstring(L, randoms[i]);
        lua_pushcclosure(L, random_from_daft, 1);
        lua_setfield(L, -2, randoms[i]);
    }
    lua_pop(L, 1);
    lua_getfield(L, -1, LUA_TABLIBNAME);
    lua_pushcfunction(L, sort);
    lua_setfield(L, -2, "sort");
    wrap(L, "insert", with_short_list);
    wrap(L, "remove", with_short_list);
    wrap(L, "move", move);
    lua_pop(L, 1);
    lua_getfield(L, -1, LUA_COLIBNAME);
    wrap(L, "resume", guarded);
    lua_pop(L, 1);
    lua_getfield(L, -1, LUA_STRLIBNAME);
    wrap(L, "rep", repeat);
    patterns_open(L, host_poll);
    lua_pushnil(L);
    lua_setfield(L, -2, "dump");
    lua_pop(L, 2);
    forbid(L, "io");
    forbid(L, "os");
}
