/* pcall, xpcall and the coroutines of Lua 5.4 (reference manual, 6.1 and 6.2), with two differences: the error with
 * which the watchdog stops a script passes through all of them, and the host always knows which coroutine runs, since
 * that is where a stop must strike.
 *
 * Where a script is stopped nothing of it runs any more: no message handler, and no __close of a coroutine that the
 * error ended. Such a coroutine is left as it is, and its memory goes with the state. */
#include "lua/api.h"

#include "lua/sandbox.h"

/* Coroutines that close within each other's __close would use up C's stack, which Lua does not count there. */
enum { MOST_CLOSING = 100 };

static void pass_stop(lua_State *L)
{
    if (host_stopping(api_host(L))) host_poll(L);
}

/* ---- protected calls ---- */

/* After a protected call: false and the error, or true and all results; the first `extra` values go. */
static int finish(lua_State *L, int status, lua_KContext extra)
{
    pass_stop(L);
    if (status == LUA_OK || status == LUA_YIELD) return lua_gettop(L) - (int)extra;
    host_forget_trace(api_host(L));
    lua_pushboolean(L, false);
    lua_pushvalue(L, -2);
    return 2;
}

static int protected_call(lua_State *L)
{
    luaL_checkany(L, 1);
    lua_pushboolean(L, true);
    lua_insert(L, 1);
    return finish(L, lua_pcallk(L, lua_gettop(L) - 2, LUA_MULTRET, 0, 0, finish), 0);
}

/* The script's handler, the upvalue, or nothing where the script is stopped: within the hook that stops it no other
 * hook would end the handler. */
static int handle(lua_State *L)
{
    if (host_stopping(api_host(L))) return 1;
    lua_pushvalue(L, lua_upvalueindex(1));
    lua_insert(L, 1);
    lua_call(L, lua_gettop(L) - 1, 1);
    return 1;
}

/* debug.traceback needs no wrapper, and would show it. */
static void wrap_handler(lua_State *L, int index)
{
    if (lua_tocfunction(L, index) && lua_tocfunction(L, index) == lua_tocfunction(L, lua_upvalueindex(1))) return;
    lua_pushvalue(L, index);
    lua_pushcclosure(L, handle, 1);
    lua_replace(L, index);
}

/* The upvalue is debug.traceback. */
static int protected_call_with_handler(lua_State *L)
{
    int arguments = lua_gettop(L) - 2;
    luaL_checktype(L, 2, LUA_TFUNCTION);
    wrap_handler(L, 2);
    lua_pushboolean(L, true);
    lua_pushvalue(L, 1);
    lua_rotate(L, 3, 2); /* function, handler, true, function, arguments */
    return finish(L, lua_pcallk(L, arguments, LUA_MULTRET, 2, 2, finish), 2);
}

/* ---- coroutines ---- */

static lua_State *coroutine_at(lua_State *L)
{
    lua_State *co = lua_tothread(L, 1);
    luaL_argexpected(L, co, 1, "coroutine");
    return co;
}

/* Resumes with the top `count` values of L. Leaves the results on top of L and returns how many; -1: the error. */
static int resume_with(lua_State *L, lua_State *co, int count)
{
    host *h = api_host(L);
    int results;
    if (!lua_checkstack(co, count)) {
        lua_pushliteral(L, "too many arguments to resume");
        return -1;
    }
    lua_xmove(L, co, count);
    host_set_running(h, co);
    int status = lua_resume(co, L, count, &results);
    host_set_running(h, L);
    pass_stop(L);
    if (status != LUA_OK && status != LUA_YIELD) {
        lua_xmove(co, L, 1);
        return -1;
    }
    if (!lua_checkstack(L, results + 1)) {
        lua_pop(co, results);
        lua_pushliteral(L, "too many results to resume");
        return -1;
    }
    lua_xmove(co, L, results);
    return results;
}

static int resume(lua_State *L)
{
    lua_State *co = coroutine_at(L);
    int results = resume_with(L, co, lua_gettop(L) - 1);
    lua_pushboolean(L, results >= 0);
    lua_insert(L, results >= 0 ? -(results + 1) : -2);
    return results >= 0 ? results + 1 : 2;
}

/* Runs the __close of all that a coroutine holds. */
static int close_coroutine(lua_State *L, lua_State *co)
{
    host *h = api_host(L);
    if (h->depth >= MOST_CLOSING) luaL_error(L, "C stack overflow: too many coroutines close each other");
    h->depth++;
    host_set_running(h, co);
    int status = lua_resetthread(co);
    host_set_running(h, L);
    h->depth--;
    pass_stop(L);
    return status;
}

/* The upvalue is the coroutine. */
static int call_wrapped(lua_State *L)
{
    lua_State *co = lua_tothread(L, lua_upvalueindex(1));
    int results = resume_with(L, co, lua_gettop(L));
    if (results >= 0) return results;
    host_keep_trace(api_host(L), L, co);
    int status = lua_status(co);
    if (status != LUA_OK && status != LUA_YIELD) { /* it failed: close what it holds, and take the last error */
        status = close_coroutine(L, co);
        lua_xmove(co, L, 1);
    }
    if (status != LUA_ERRMEM && lua_type(L, -1) == LUA_TSTRING) {
        luaL_where(L, 1);
        lua_insert(L, -2);
        lua_concat(L, 2);
    }
    return lua_error(L);
}

static int wrap(lua_State *L)
{
    luaL_checktype(L, 1, LUA_TFUNCTION);
    lua_State *co = lua_newthread(L);
    lua_pushvalue(L, 1);
    lua_xmove(L, co, 1);
    lua_pushcclosure(L, call_wrapped, 1);
    return 1;
}

/* NULL where the coroutine can be closed. */
static const char *not_closable(lua_State *L, lua_State *co)
{
    lua_Debug place;
    if (co == L) return "running";
    return lua_status(co) == LUA_OK && lua_getstack(co, 0, &place) ? "normal" : NULL;
}

static int close(lua_State *L)
{
    lua_State *co = coroutine_at(L);
    const char *state = not_closable(L, co);
    if (state) return luaL_error(L, "cannot close a %s coroutine", state);
    bool good = close_coroutine(L, co) == LUA_OK;
    lua_pushboolean(L, good);
    if (good) return 1;
    lua_xmove(co, L, 1);
    return 2;
}

void protect_open(lua_State *L, lua_CFunction traceback)
{
    static const luaL_Reg coroutines[] = {{"resume", resume}, {"wrap", wrap}, {"close", close}, {NULL, NULL}};
    lua_pushcfunction(L, protected_call);
    lua_setglobal(L, "pcall");
    lua_pushcfunction(L, traceback);
    lua_pushcclosure(L, protected_call_with_handler, 1);
    lua_setglobal(L, "xpcall");
    lua_getglobal(L, LUA_COLIBNAME);
    luaL_setfuncs(L, coroutines, 0);
    lua_pop(L, 1);
}
