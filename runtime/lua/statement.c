/* Runs a line of Lua among the game's own names, and describes what it gives. */
#include "lua/statement.h"

#include "common/util.h"
#include "lua/api.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Appends as much as fits. */
static void put(char *out, const char *format, ...) __attribute__((format(printf, 2, 3)));
static void put(char *out, const char *format, ...)
{
    const size_t used = strlen(out);
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(out + used, STATEMENT_ANSWER - used, format, arguments);
    va_end(arguments);
}

/* ---- the locals of the game ----
 *
 * Two tables from a name to a list {function, number of its upvalue}: NEAR has those that the callbacks use, FAR those
 * of the functions that they reach. */

enum { MOST_FUNCTIONS = 2000, UPVALUES = 255 };

/* Stack places of a search. */
enum { NEAR = 1, FAR, QUEUE, SEEN };

/* Keeps upvalue `number`, `name`, of the function on top, unless the name is known. */
static void keep_name(lua_State *L, int names, const char *name, int number)
{
    if (lua_getfield(L, names, name) == LUA_TNIL) {
        lua_createtable(L, 2, 0);
        lua_pushvalue(L, -3);
        lua_rawseti(L, -2, 1);
        lua_pushinteger(L, number);
        lua_rawseti(L, -2, 2);
        lua_setfield(L, names, name);
    }
    lua_pop(L, 1);
}

/* Takes a function from the top to the end of the queue, once. */
static void enqueue(lua_State *L)
{
    lua_pushvalue(L, -1);
    if (lua_rawget(L, SEEN) == LUA_TNIL && lua_rawlen(L, QUEUE) < MOST_FUNCTIONS) {
        lua_pushvalue(L, -2);
        lua_pushboolean(L, true);
        lua_rawset(L, SEEN);
        lua_pushvalue(L, -2);
        lua_rawseti(L, QUEUE, (lua_Integer)lua_rawlen(L, QUEUE) + 1);
    }
    lua_pop(L, 2);
}

/* Takes a function from the top. */
static void search_function(lua_State *L, int names)
{
    for (int i = 1; i <= UPVALUES; i++) {
        const char *name = lua_getupvalue(L, -1, i);
        if (!name) break;
        const bool is_function = lua_isfunction(L, -1) && !lua_iscfunction(L, -1);
        if (is_function)
            enqueue(L);
        else
            lua_pop(L, 1);
        if (name[0] && name[0] != '(' && strcmp(name, "_ENV") != 0) keep_name(L, names, name, i);
    }
    lua_pop(L, 1);
}

/* Fills the stack's first two places. */
static void find_locals(lua_State *L)
{
    size_t count;
    const char *const *callbacks = api_callbacks(&count);
    for (int i = NEAR; i <= SEEN; i++) lua_newtable(L);
    api_push(L);
    for (size_t i = 0; i < count; i++) {
        lua_pushstring(L, callbacks[i]);
        if (lua_rawget(L, -2) == LUA_TFUNCTION && !lua_iscfunction(L, -1))
            enqueue(L);
        else
            lua_pop(L, 1);
    }
    lua_pop(L, 1);
    const lua_Integer roots = (lua_Integer)lua_rawlen(L, QUEUE);
    for (lua_Integer i = 1; i <= (lua_Integer)lua_rawlen(L, QUEUE); i++) {
        lua_rawgeti(L, QUEUE, i);
        search_function(L, i <= roots ? NEAR : FAR);
        host_poll(L);
    }
    lua_settop(L, FAR);
}

/* ---- the environment of a line: upvalues 1 and 2 are NEAR and FAR ---- */

/* Pushes the function, and returns the number of its upvalue; 0, with nothing pushed: there is no such name. */
static int find_local(lua_State *L, int names)
{
    lua_pushvalue(L, 2);
    if (lua_type(L, 2) != LUA_TSTRING || lua_rawget(L, lua_upvalueindex(names)) != LUA_TTABLE) {
        lua_pop(L, 1);
        return 0;
    }
    lua_rawgeti(L, -1, 2);
    const int number = (int)lua_tointeger(L, -1);
    lua_pop(L, 1);
    lua_rawgeti(L, -1, 1);
    lua_remove(L, -2);
    return number;
}

static bool push_local(lua_State *L, int names)
{
    const int number = find_local(L, names);
    return number > 0 && lua_getupvalue(L, -1, number) != NULL;
}

/* "entity_31". */
static bool push_numbered_entity(lua_State *L)
{
    static const char prefix[] = "entity_";
    const char *name = lua_type(L, 2) == LUA_TSTRING ? lua_tostring(L, 2) : "";
    if (strncmp(name, prefix, sizeof prefix - 1) != 0) return false;
    char *end;
    const char *digits = name + sizeof prefix - 1;
    const unsigned long id = digits[0] >= '1' && digits[0] <= '9' ? strtoul(digits, &end, 10) : 0;
    if (id == 0 || *end || id > UINT32_MAX) return false;
    if (!daft_entity_is_valid(api_host(L)->def.scene, (daft_entity){(uint32_t)id}))
        luaL_error(L, "there is no entity %d", (int)id);
    api_push_entity(L, (uint32_t)id);
    return true;
}

/* Pushes what the global is. */
static bool push_global(lua_State *L)
{
    lua_pushglobaltable(L);
    lua_pushvalue(L, 2);
    return lua_gettable(L, -2) != LUA_TNIL;
}

static int get_name(lua_State *L)
{
    if (!push_local(L, NEAR) && !push_global(L) && !push_numbered_entity(L) && !push_local(L, FAR)) lua_pushnil(L);
    return 1;
}

static bool set_local(lua_State *L, int names)
{
    const int number = find_local(L, names);
    if (number == 0) return false;
    lua_pushvalue(L, 3);
    lua_setupvalue(L, -2, number);
    return true;
}

static int set_name(lua_State *L)
{
    if (set_local(L, NEAR)) return 0;
    if (!push_global(L) && set_local(L, FAR)) return 0;
    lua_pushglobaltable(L);
    lua_pushvalue(L, 2);
    lua_pushvalue(L, 3);
    lua_settable(L, -3);
    return 0;
}

static void set_meta(lua_State *L, const char *event, lua_CFunction function)
{
    lua_pushvalue(L, NEAR);
    lua_pushvalue(L, FAR);
    lua_pushcclosure(L, function, 2);
    lua_setfield(L, -2, event);
}

static void push_environment(lua_State *L)
{
    find_locals(L);
    lua_newtable(L);
    lua_createtable(L, 0, 2);
    set_meta(L, "__index", get_name);
    set_meta(L, "__newindex", set_name);
    lua_setmetatable(L, -2);
    lua_replace(L, NEAR);
    lua_settop(L, NEAR);
}

/* ---- values ---- */

enum { SHOWN_NAMES = 48, SHOWN_ITEMS = 24 };

static int compare(const void *a, const void *b) { return strcmp(*(const char *const *)a, *(const char *const *)b); }

/* The first names of the table on top, in order; *others: keys that are neither these nor shown items. */
static size_t list_names(lua_State *L, const char *names[SHOWN_NAMES], size_t *others)
{
    size_t count = 0;
    *others = 0;
    for (lua_pushnil(L); lua_next(L, -2); lua_pop(L, 1)) {
        host_poll(L);
        if (lua_isinteger(L, -2) && lua_tointeger(L, -2) >= 1 && lua_tointeger(L, -2) <= SHOWN_ITEMS) continue;
        if (lua_type(L, -2) != LUA_TSTRING || count == SHOWN_NAMES)
            ++*others;
        else
            names[count++] = lua_tostring(L, -2);
    }
    qsort(names, count, sizeof *names, compare);
    return count;
}

/* A line for each field. */
static void put_table(lua_State *L, char *out)
{
    const char *names[SHOWN_NAMES];
    size_t others;
    for (lua_Integer i = 1; i <= SHOWN_ITEMS; i++) {
        if (lua_rawgeti(L, -1, i) != LUA_TNIL) {
            put(out, "%s[%d] = ", out[0] ? "\n" : "", (int)i);
            failure_describe(L, -1, out, STATEMENT_ANSWER);
        }
        lua_pop(L, 1);
    }
    const size_t count = list_names(L, names, &others);
    for (size_t i = 0; i < count; i++) {
        put(out, "%s%.60s = ", out[0] ? "\n" : "", names[i]);
        lua_pushstring(L, names[i]);
        lua_rawget(L, -2);
        failure_describe(L, -1, out, STATEMENT_ANSWER);
        lua_pop(L, 1);
    }
    if (others) put(out, "%sand %zu more", out[0] ? "\n" : "", others);
    if (!out[0]) put(out, "{}");
}

static void put_values(lua_State *L, int first, char *out)
{
    const int last = lua_gettop(L);
    if (first == last && lua_type(L, first) == LUA_TTABLE) {
        put_table(L, out);
        return;
    }
    for (int i = first; i <= last; i++) {
        char safe[STATEMENT_ANSWER];
        put(out, "%s", i > first ? ", " : "");
        if (lua_type(L, i) == LUA_TSTRING)
            put(out, "\"%s\"", daft_escape(lua_tostring(L, i), safe, sizeof safe));
        else
            failure_describe(L, i, out, STATEMENT_ANSWER);
    }
}

/* ---- running ---- */

/* Whether the message on top tells of an expression that lacks its end. */
static bool lacks_end(lua_State *L)
{
    static const char end[] = "<eof>";
    size_t length;
    const char *message = lua_tolstring(L, -1, &length);
    return length >= sizeof end - 1 && strcmp(message + length - (sizeof end - 1), end) == 0;
}

/* Leaves the function on top, or the message: as an expression first. */
static bool compile(lua_State *L, const char *text)
{
    const size_t length = strlen(text);
    lua_pushfstring(L, "return %s", text);
    if (luaL_loadbufferx(L, lua_tostring(L, -1), length + 7, "=console", "t") == LUA_OK) return true;
    const bool begun = lacks_end(L);
    if (luaL_loadbufferx(L, text, length, "=console", "t") == LUA_OK) return true;
    if (begun) lua_pop(L, 1);
    return false;
}

static int run(lua_State *L)
{
    host *h = api_host(L);
    lua_settop(L, 0);
    host_limit_steps(L, STATEMENT_STEPS);
    push_environment(L);
    if (!compile(L, h->statement)) return lua_error(L);
    lua_pushvalue(L, 1);
    if (!lua_setupvalue(L, -2, 1)) lua_pop(L, 1);
    const int first = lua_gettop(L);
    lua_call(L, 0, LUA_MULTRET);
    if (lua_gettop(L) >= first) put_values(L, first, h->answer);
    return 0;
}

statement_end host_run_statement(host *state, const char *text, char answer[STATEMENT_ANSWER])
{
    answer[0] = 0;
    state->statement = text, state->answer = answer;
    const bool good = host_call(state, "the line", run);
    state->statement = NULL, state->answer = NULL;
    if (good) return STATEMENT_DONE;
    snprintf(answer, STATEMENT_ANSWER, "%s", state->failure.message);
    if (state->ended != WATCHDOG_RUNNING) return STATEMENT_STOPPED;
    failure_clear(&state->failure);
    return STATEMENT_FAILED;
}
