/* Functions that run over many ticks: daft.start and its kin. Each is a coroutine, a task, that the host resumes after
 * daft.update of the tick it waits for. They count ticks and know no clock, so a replay repeats them: ticks of the
 * game's time, which daft.time_scale slows down, where seconds were given, else updates.
 *
 * The registry has two tables: tasks in the order in which they began, and what each waits for: the number of
 * an update, a time as a float (host.clock), a function that is to say true, or true while it runs, false once it has
 * been cancelled there. A task that is not in the second has ended. */
#include "lua/api.h"

#include "common/util.h"

#include <math.h>

static const char LIST_KEY, WAITS_KEY, YIELDED; /* registry keys; what a task yields before what it waits for */

static void push_registry(lua_State *L, const char *key)
{
    if (lua_rawgetp(L, LUA_REGISTRYINDEX, key) != LUA_TNIL) return;
    lua_pop(L, 1);
    lua_newtable(L);
    lua_pushvalue(L, -1);
    lua_rawsetp(L, LUA_REGISTRYINDEX, key);
}

/* Takes what the task at index waits for from the top; nil: it has ended. */
static void set_wait(lua_State *L, int task)
{
    task = lua_absindex(L, task);
    push_registry(L, &WAITS_KEY);
    lua_pushvalue(L, task);
    lua_pushvalue(L, -3);
    lua_rawset(L, -3);
    lua_pop(L, 2);
}

/* Pushes what the task at index waits for, or nil, and gives its type. */
static int get_wait(lua_State *L, int task)
{
    task = lua_absindex(L, task);
    push_registry(L, &WAITS_KEY);
    lua_pushvalue(L, task);
    int type = lua_rawget(L, -2);
    lua_remove(L, -2);
    return type;
}

/* Ticks of the game's time as a float, at least 1; no seconds: 1 as a whole number, which is an update, however fast
 * time goes. */
static void push_period(lua_State *L, host *h, int index)
{
    const double seconds = api_number(L, h, index, "seconds");
    if (!(seconds >= 0 && seconds <= 1e9)) api_wrong(L, h, index, "seconds", "number from 0 to a billion");
    const double ticks = ceil(seconds * 60 - 1e-6);
    if (seconds == 0)
        lua_pushinteger(L, 1);
    else
        lua_pushnumber(L, ticks > 1 ? ticks : 1);
}

/* Replaces the period on top by when it is over, counted from now. */
static void from_now(lua_State *L, host *h)
{
    if (lua_isinteger(L, -1))
        lua_pushinteger(L, (lua_Integer)h->tick + lua_tointeger(L, -1));
    else
        lua_pushnumber(L, h->clock + lua_tonumber(L, -1));
    lua_remove(L, -2);
}

/* ---- running ----------------------------------------------------------------------------------------------------- */

/* The task on top of L has failed; its error is on top of its own stack. */
static int pass_error(lua_State *L, lua_State *co)
{
    lua_pushnil(L);
    set_wait(L, -2);
    host_keep_trace(api_host(L), L, co);
    lua_xmove(co, L, 1);
    return lua_error(L);
}

/* Resumes the task on top of L, which stays there; one that has not begun has its function and arguments on its stack.
 */
static void run(lua_State *L, host *h)
{
    lua_State *co = lua_tothread(L, -1);
    const int count = lua_status(co) == LUA_OK ? lua_gettop(co) - 1 : 0;
    int results;
    lua_pushboolean(L, true);
    set_wait(L, -2);
    host_set_running(h, co);
    int status = lua_resume(co, L, count, &results);
    host_set_running(h, L);
    if (host_stopping(h)) host_poll(L);
    if (status != LUA_OK && status != LUA_YIELD) pass_error(L, co);
    get_wait(L, -1);
    const bool goes_on = status == LUA_YIELD && lua_toboolean(L, -1);
    lua_pop(L, 1);
    if (!goes_on)
        lua_pushnil(L);
    else if (results == 2 && lua_touserdata(co, -2) == &YIELDED)
        lua_xmove(co, L, 1), results--;
    else /* coroutine.yield: until the next tick */
        lua_pushinteger(L, (lua_Integer)h->tick + 1);
    set_wait(L, -2);
    lua_pop(co, results);
}

/* Whether what is on top has come true. */
static bool is_due(lua_State *L, host *h)
{
    if (lua_isinteger(L, -1)) return lua_tointeger(L, -1) <= (lua_Integer)h->tick;
    if (lua_type(L, -1) == LUA_TNUMBER) return lua_tonumber(L, -1) <= h->clock + 1e-6;
    if (!lua_isfunction(L, -1)) return false; /* it runs */
    lua_pushvalue(L, -1);
    lua_call(L, 0, 1);
    bool due = lua_toboolean(L, -1);
    lua_pop(L, 1);
    return due;
}

/* Drops the tasks that have ended. The list is on top. */
static void compact(lua_State *L, host *h)
{
    lua_Integer kept = 0, count = (lua_Integer)lua_rawlen(L, -1);
    for (lua_Integer i = 1; i <= count; i++) {
        lua_rawgeti(L, -1, i);
        bool live = get_wait(L, -1) != LUA_TNIL;
        lua_pop(L, 1);
        if (live)
            lua_rawseti(L, -2, ++kept);
        else
            lua_pop(L, 1);
    }
    for (lua_Integer i = kept + 1; i <= count; i++) {
        lua_pushnil(L);
        lua_rawseti(L, -2, i);
    }
    h->tasks = (uint32_t)kept;
}

int api_step_tasks(lua_State *L)
{
    host *h = api_host(L);
    push_registry(L, &LIST_KEY);
    const lua_Integer count = (lua_Integer)lua_rawlen(L, -1); /* those that begin now have run already */
    for (lua_Integer i = 1; i <= count; i++) {
        lua_rawgeti(L, -1, i);
        bool due = get_wait(L, -1) != LUA_TNIL && is_due(L, h);
        lua_pop(L, 1);
        if (due && get_wait(L, -1) != LUA_TNIL) { /* what it waited for may have ended it */
            lua_pop(L, 1);
            run(L, h);
        } else if (due) {
            lua_pop(L, 1);
        }
        lua_pop(L, 1);
        api_poll(L, (uint64_t)i);
    }
    compact(L, h);
    return 0;
}

/* ---- functions --------------------------------------------------------------------------------------------------- */

static void check_function(lua_State *L, host *h, int index)
{
    if (!lua_isfunction(L, index)) api_wrong(L, h, index, "function", "function");
}

/* Pushes a new task, listed, without a function on its stack. */
static lua_State *new_task(lua_State *L, host *h)
{
    lua_State *co = lua_newthread(L);
    push_registry(L, &LIST_KEY);
    lua_pushvalue(L, -2);
    lua_rawseti(L, -2, (lua_Integer)lua_rawlen(L, -2) + 1);
    lua_pop(L, 1);
    h->tasks++;
    return co;
}

static int start(lua_State *L, host *h)
{
    check_function(L, h, 1);
    int count = lua_gettop(L);
    lua_State *co = new_task(L, h);
    lua_insert(L, 1);
    luaL_checkstack(co, count, "too many arguments");
    lua_xmove(L, co, count);
    run(L, h);
    return 1;
}

static int after(lua_State *L, host *h)
{
    push_period(L, h, 1);
    from_now(L, h);
    lua_replace(L, 1);
    check_function(L, h, 2);
    lua_State *co = new_task(L, h);
    lua_pushvalue(L, 2);
    lua_xmove(L, co, 1);
    lua_pushvalue(L, 1);
    set_wait(L, -2);
    return 1;
}

/* The function, its period, and when it is next due are on the stack. */
static int repeat_again(lua_State *L, int status, lua_KContext context);

static int repeat_ended(lua_State *L, int status, lua_KContext unused)
{
    (void)status, (void)unused;
    if (lua_isboolean(L, -1) && !lua_toboolean(L, -1)) return 0;
    const double clock = api_host(L)->clock;
    lua_settop(L, 3);
    lua_pushvalue(L, 2);
    lua_arith(L, LUA_OPADD);
    /* What is due more often than once a tick, since time goes fast, does not fall behind for ever. */
    if (!lua_isinteger(L, 3) && lua_tonumber(L, 3) < clock) {
        lua_pushnumber(L, clock);
        lua_replace(L, 3);
    }
    lua_pushlightuserdata(L, (void *)(uintptr_t)&YIELDED);
    lua_pushvalue(L, 3);
    return lua_yieldk(L, 2, 0, repeat_again);
}

static int repeat_again(lua_State *L, int status, lua_KContext context)
{
    (void)status;
    lua_settop(L, 3);
    lua_pushvalue(L, 1);
    lua_callk(L, 0, 1, context, repeat_ended);
    return repeat_ended(L, LUA_OK, context);
}

static int repeat(lua_State *L) { return repeat_again(L, LUA_OK, 0); }

static int every(lua_State *L, host *h)
{
    push_period(L, h, 1);
    lua_replace(L, 1);
    check_function(L, h, 2);
    lua_settop(L, 2);
    lua_State *co = new_task(L, h);
    lua_pushcfunction(co, repeat);
    lua_pushvalue(L, 2);
    lua_pushvalue(L, 1);
    lua_pushvalue(L, 1);
    from_now(L, h);
    lua_pushvalue(L, -1);
    lua_insert(L, 3); /* when it is due, below the task */
    lua_xmove(L, co, 3);
    lua_pushvalue(L, 3);
    set_wait(L, -2);
    return 1;
}

/* The state that calls is a task, and not a coroutine that one has made. */
static void check_task(lua_State *L, host *h)
{
    lua_pushthread(L);
    bool task = get_wait(L, -1) != LUA_TNIL;
    lua_pop(L, 2);
    if (!task || !lua_isyieldable(L)) api_error(L, h, "only within a function that daft.start, after or every runs");
}

static int yield(lua_State *L)
{
    lua_pushlightuserdata(L, (void *)(uintptr_t)&YIELDED);
    lua_insert(L, -2);
    return lua_yield(L, 2);
}

static int wait(lua_State *L, host *h)
{
    if (lua_isnoneornil(L, 1))
        lua_pushinteger(L, 1);
    else
        push_period(L, h, 1);
    check_task(L, h);
    from_now(L, h);
    return yield(L);
}

static int wait_until(lua_State *L, host *h)
{
    check_function(L, h, 1);
    check_task(L, h);
    lua_settop(L, 1);
    return yield(L);
}

static void check_is_task(lua_State *L, host *h)
{
    if (!lua_isthread(L, 1)) api_wrong(L, h, 1, "task", "what daft.start, after or every gave");
}

static int cancel(lua_State *L, host *h)
{
    check_is_task(L, h);
    lua_settop(L, 1);
    if (get_wait(L, 1) == LUA_TBOOLEAN)
        lua_pushboolean(L, false);
    else
        lua_pushnil(L);
    set_wait(L, 1);
    return 0;
}

static int running(lua_State *L, host *h)
{
    check_is_task(L, h);
    get_wait(L, 1);
    lua_pushboolean(L, lua_toboolean(L, -1));
    return 1;
}

static const api_function FUNCTIONS[] = {
    {"start", "(function, ...) -> task",
     "Calls the function at once, as a task: it may wait, and goes on in a later tick, after daft.update. An error in\n"
     "it is the game's.",
     start, API_CHANGES},
    {"wait", "([seconds])",
     "Only in a task: goes on after so many seconds of the game, in the next tick at the earliest. Also just "
     "wait(...).",
     wait, 0},
    {"wait_until", "(function)",
     "Only in a task: goes on in the first tick, from the next one on, in which the function says true. It is called\n"
     "once a tick. Also just wait_until(...).",
     wait_until, 0},
    {"after", "(seconds, function) -> task", "Calls the function once, as a task, so many seconds from now.", after,
     API_CHANGES},
    {"every", "(seconds, function) -> task",
     "Calls the function again and again, as a task, first so many seconds from now; until it returns false.", every,
     API_CHANGES},
    {"cancel", "(task)", "The task does not go on. One that has ended is left alone.", cancel, API_CHANGES},
    {"running", "(task) -> boolean", "Whether the task runs or waits.", running, 0},
};

const api_area api_time = {"Time", FUNCTIONS, COUNT_OF(FUNCTIONS)};

void api_set_wait(lua_State *L)
{
    static const char *const NAMES[] = {"wait", "wait_until"};
    api_push(L);
    for (size_t i = 0; i < COUNT_OF(NAMES); i++) {
        lua_pushstring(L, NAMES[i]);
        lua_rawget(L, -2);
        lua_setglobal(L, NAMES[i]);
    }
    lua_pop(L, 1);
}
