/* The standard library as a game sees it: the same input must give the same game on every machine, and a game must not
 * reach beyond its folder. So:
 *   - io, os, package and most of debug are not there (debug.traceback is); using io or os says so;
 *   - load takes text only; dofile and loadfile are not there;
 *   - math's functions come from libdaft, since libm's last bits differ between systems; `^` with the exponent 2
 *     is exact, other exponents are libm's: use math.pow where a replay depends on it;
 *   - math.random and math.randomseed are daft.random and daft.randomseed;
 *   - pairs() goes in a fixed order: numbers rising, strings in the order of their bytes, false and true, then the
 *     rest in no fixed order (Lua's own order hangs on addresses);
 *   - tostring, print and string.format show no addresses, but numbers in the order in which they were asked for;
 *   - table.sort is a stable merge sort (Lua's own picks pivots by the clock);
 *   - pcall, xpcall and coroutines pass on the error with which the watchdog stops a script;
 *   - there is no __gc, and functions that would loop for ever out of the watchdog's sight refuse to. */
#include "lua/api.h"

#include "common/util.h"
#include "lua/patterns.h"
#include "lua/sandbox.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

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

/* ---- code ---- */

/* Text on its way to the compiler, in pieces, so that a long one can be stopped. */
typedef struct pieces {
    const char *at;
    size_t left;
} pieces;

static const char *next_piece(lua_State *L, void *user, size_t *size)
{
    enum { PIECE = 16384 };
    pieces *text = user;
    const char *piece = text->at;
    host_poll(L);
    *size = text->left < PIECE ? text->left : PIECE;
    text->at += *size, text->left -= *size;
    return piece;
}

/* load with text only, and with the game's globals. */
static int load(lua_State *L)
{
    pieces text;
    text.at = luaL_checklstring(L, 1, &text.left);
    const char *name = luaL_optstring(L, 2, text.at);
    bool has_environment = !lua_isnone(L, 4);
    if (lua_load(L, next_piece, &text, name, "t") != LUA_OK) {
        if (host_stopping(api_host(L))) host_poll(L);
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

/* Lua's own copies piece by piece, and as often as it is told where there is nothing to copy. */
static int repeat(lua_State *L)
{
    size_t length, between;
    const char *text = luaL_checklstring(L, 1, &length);
    lua_Integer count = luaL_checkinteger(L, 2);
    const char *separator = luaL_optlstring(L, 3, "", &between);
    size_t unit = length + between; /* each at most HOST_STRING */
    if (count <= 0 || unit == 0) {
        lua_pushliteral(L, "");
        return 1;
    }
    if ((size_t)count > (HOST_STRING + between) / unit) return luaL_error(L, "resulting string too large");
    size_t size = (size_t)count * unit - between;
    luaL_Buffer out;
    char *at = luaL_buffinitsize(L, &out, size);
    memcpy(at, text, length);
    if (count > 1) memcpy(at + length, separator, between);
    for (size_t done = unit; done < size;) { /* doubles what is there */
        size_t more = done < size - done ? done : size - done;
        memcpy(at + done, at, more);
        done += more;
    }
    luaL_pushresultsize(&out, size);
    return 1;
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

/* Returns debug.traceback. */
static lua_CFunction open_debug(lua_State *L)
{
    luaL_requiref(L, LUA_DBLIBNAME, luaopen_debug, 0);
    lua_newtable(L);
    lua_getfield(L, -2, "traceback");
    lua_CFunction traceback = lua_tocfunction(L, -1);
    lua_setfield(L, -2, "traceback");
    lua_pushvalue(L, -1);
    lua_setglobal(L, LUA_DBLIBNAME);
    luaL_getsubtable(L, LUA_REGISTRYINDEX, LUA_LOADED_TABLE);
    lua_pushvalue(L, -2);
    lua_setfield(L, -2, LUA_DBLIBNAME);
    lua_pop(L, 3);
    return traceback;
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
    protect_open(L, open_debug(L));
    lists_open(L);
    texts_open(L);
    const luaL_Reg globals[] = {{"load", load}, {"setmetatable", set_metatable}, {NULL, NULL}};
    lua_pushglobaltable(L);
    luaL_setfuncs(L, globals, 0);
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
    lua_getfield(L, -1, LUA_STRLIBNAME);
    lua_pushcfunction(L, repeat);
    lua_setfield(L, -2, "rep");
    patterns_open(L, host_poll);
    lua_pushnil(L);
    lua_setfield(L, -2, "dump");
    lua_pop(L, 2);
    forbid(L, "io");
    forbid(L, "os");
}
