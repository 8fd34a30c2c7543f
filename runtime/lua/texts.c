/* tostring, print and string.format as in Lua 5.4, but that they never show an address: it differs from run to run, and
 * a game that hung on one could not be replayed. What has no text of its own is numbered instead, in the order in which
 * texts were asked for: "table 1", "function 2". Within daft.draw, which a replay may leave out, numbers come from a
 * list of their own: "table draw 1". */
#include "lua/api.h"

#include "common/util.h"
#include "lua/sandbox.h"

#include <ctype.h>
#include <stdio.h>
#include <string.h>

/* In the registry: tables from objects, which they do not hold, to numbers; ["last"] is the last number. */
static const char GAME_KEY, DRAW_KEY;

/* Pushes the object's number in that table, or nil. */
static int push_number(lua_State *L, int index, const char *key)
{
    lua_rawgetp(L, LUA_REGISTRYINDEX, key);
    lua_pushvalue(L, index);
    lua_rawget(L, -2);
    lua_remove(L, -2);
    return lua_type(L, -1);
}

static lua_Integer give_number(lua_State *L, int index, const char *key)
{
    lua_rawgetp(L, LUA_REGISTRYINDEX, key);
    lua_getfield(L, -1, "last");
    const lua_Integer number = lua_tointeger(L, -1) + 1;
    lua_pop(L, 1);
    lua_pushinteger(L, number);
    lua_setfield(L, -2, "last");
    lua_pushvalue(L, index);
    lua_pushinteger(L, number);
    lua_rawset(L, -3);
    lua_pop(L, 1);
    return number;
}

/* Pushes "NAME 7". */
static void push_numbered(lua_State *L, int index, const char *name)
{
    const bool draws = api_host(L)->picture != NULL;
    if (push_number(L, index, &GAME_KEY) == LUA_TNUMBER || !draws) {
        const lua_Integer known = lua_tointeger(L, -1);
        lua_pop(L, 1);
        lua_pushfstring(L, "%s %I", name, known ? known : give_number(L, index, &GAME_KEY));
        return;
    }
    push_number(L, index, &DRAW_KEY);
    const lua_Integer known = lua_tointeger(L, -1);
    lua_pop(L, 2);
    lua_pushfstring(L, "%s draw %I", name, known ? known : give_number(L, index, &DRAW_KEY));
}

/* Pushes the value's text, as tostring gives it to games: without addresses. */
static void push_text(lua_State *L, int index)
{
    index = lua_absindex(L, index);
    const int type = lua_type(L, index);
    if (type != LUA_TTABLE && type != LUA_TFUNCTION && type != LUA_TUSERDATA && type != LUA_TTHREAD) {
        luaL_tolstring(L, index, NULL);
        return;
    }
    if (luaL_getmetafield(L, index, "__tostring") != LUA_TNIL) {
        lua_pop(L, 1);
        luaL_tolstring(L, index, NULL);
        return;
    }
    const int top = lua_gettop(L);
    const char *name = luaL_typename(L, index);
    if (luaL_getmetafield(L, index, "__name") == LUA_TSTRING) name = lua_tostring(L, -1);
    push_numbered(L, index, name);
    if (lua_gettop(L) > top + 1) lua_replace(L, top + 1); /* the name */
    lua_settop(L, top + 1);
}

static int to_text(lua_State *L)
{
    luaL_checkany(L, 1);
    push_text(L, 1);
    return 1;
}

static void write_piece(const host *h, const char *text, size_t length)
{
    lua_writestring(text, length);
    if (h->def.printed) h->def.printed(h->def.user, text, length);
}

static int print(lua_State *L)
{
    const host *h = api_host(L);
    const int count = lua_gettop(L);
    const bool quiet = h->def.quiet;
    for (int i = 1; i <= count; i++) {
        size_t length;
        push_text(L, i); /* which may number an object */
        const char *text = lua_tolstring(L, -1, &length);
        if (i > 1 && !quiet) write_piece(h, "\t", 1);
        if (!quiet) write_piece(h, text, length);
        lua_pop(L, 1);
    }
    if (!quiet) write_piece(h, "\n", 1);
    if (!quiet) fflush(stdout);
    return 0;
}

/* Past flags, width and precision of a conversion; at its letter. */
static const char *conversion(const char *at)
{
    while (*at && strchr("-+ #0", *at)) at++;
    while (isdigit((unsigned char)*at)) at++;
    if (*at == '.') at++;
    while (isdigit((unsigned char)*at)) at++;
    return at;
}

/* Lua's own, the upvalue, with the texts of objects in place of these. */
static int format(lua_State *L)
{
    const char *at = luaL_checkstring(L, 1);
    const int count = lua_gettop(L);
    for (int argument = 1; (at = strchr(at, '%')); at++) {
        at = conversion(at + 1);
        if (!*at) break;
        if (*at == '%') continue;
        if (*at == 'p')
            return luaL_error(L, "string.format: there is no %%p in games: addresses differ from run to run");
        if (++argument > count || *at != 's') continue;
        push_text(L, argument);
        lua_replace(L, argument);
    }
    lua_pushvalue(L, lua_upvalueindex(1));
    lua_insert(L, 1);
    lua_call(L, count, 1);
    return 1;
}

static void make_list(lua_State *L, const char *key)
{
    lua_newtable(L);
    lua_createtable(L, 0, 1);
    lua_pushliteral(L, "k");
    lua_setfield(L, -2, "__mode");
    lua_setmetatable(L, -2);
    lua_rawsetp(L, LUA_REGISTRYINDEX, key);
}

void texts_open(lua_State *L)
{
    make_list(L, &GAME_KEY);
    make_list(L, &DRAW_KEY);
    lua_pushcfunction(L, to_text);
    lua_setglobal(L, "tostring");
    lua_pushcfunction(L, print);
    lua_setglobal(L, "print");
    lua_getglobal(L, LUA_STRLIBNAME);
    lua_getfield(L, -1, "format");
    lua_pushcclosure(L, format, 1);
    lua_setfield(L, -2, "format");
    lua_pop(L, 1);
}
