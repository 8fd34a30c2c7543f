/* One Lua state that runs one game. */
#include "lua/host.h"

#include "lua/api.h"
#include "common/util.h"
#include "lua/patterns.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- random numbers ---- */

static uint64_t rotate(uint64_t x, int k) { return x << k | x >> (64 - k); }

uint64_t random_next(random_state *state)
{
    uint64_t *s = state->s, result = rotate(s[1] * 5, 7) * 9, t = s[1] << 17;
    s[2] ^= s[0], s[3] ^= s[1], s[1] ^= s[2], s[0] ^= s[3];
    s[2] ^= t;
    s[3] = rotate(s[3], 45);
    return result;
}

void random_seed(random_state *state, uint64_t seed)
{
    for (int i = 0; i < 4; i++) { /* splitmix64, as the authors of xoshiro advise */
        uint64_t z = seed += 0x9e3779b97f4a7c15u;
        z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
        z = (z ^ z >> 27) * 0x94d049bb133111ebu;
        state->s[i] = z ^ z >> 31;
    }
}

/* ---- memory and time ---- */

static void *allocate(void *user, void *pointer, size_t old_size, size_t new_size)
{
    host *state = user;
    size_t held = pointer ? old_size : 0; /* without a pointer, old_size is the kind of the new object */
    if (new_size == 0) {
        free(pointer);
        state->memory -= held;
        return NULL;
    }
    size_t max = state->def.memory ? state->def.memory : HOST_MEMORY;
    if (new_size > held && state->memory - held + new_size > max) return NULL;
    void *grown = realloc(pointer, new_size);
    if (grown) state->memory += new_size - held;
    return grown;
}

enum { WATCH_STEP = 200000 };

/* Raises an error where the callback has run for too long; `steps` of it since the last look. */
static void watch_steps(lua_State *L, uint64_t steps)
{
    host *state = api_host(L);
    uint64_t ran = clock_now_ns() - state->call_began;
    const char *name = state->callback;
    state->call_ran += steps;
    if (state->def.instructions && state->call_ran > state->def.instructions) {
        state->stopped = true;
        luaL_error(L, "%s ran too long", name);
    }
    if (ran > (uint64_t)HOST_CALL_SECONDS * 1000000000u) {
        state->stopped = true;
        luaL_error(L, "%s ran for %d s without coming to an end", name, (int)HOST_CALL_SECONDS);
    }
    if (ran > 500000000u && state->def.interrupted && state->def.interrupted(state->def.user)) {
        state->stopped = true;
        luaL_error(L, "%s was stopped", name);
    }
}

/* Called every WATCH_STEP instructions: a game in an endless loop must not take the window with it. */
static void watch(lua_State *L, lua_Debug *unused)
{
    (void)unused;
    watch_steps(L, WATCH_STEP);
}

void host_poll(lua_State *L) { watch_steps(L, PATTERNS_POLL_STEPS); }

/* ---- files ---- */

/* Neither absolute nor with a part "..": a game that somebody was sent must not read what else is on the machine. */
static bool stays_inside(const char *name)
{
    if (name[0] == '/') return false;
    for (const char *part = name; part;) {
        if (strncmp(part, "..", 2) == 0 && (part[2] == 0 || part[2] == '/')) return false;
        part = strchr(part, '/');
        if (part) part++;
    }
    return true;
}

bool host_find_file(const host *state, const char *name, char *out, size_t size, daft_error *error)
{
    if (!stays_inside(name))
        return fail(error, DAFT_ERROR_ARGUMENT, "'%s' leads outside: files are in the game's folder or in assets/",
                    name);
    if (path_join(out, size, state->def.folder, name) && path_is_file(out)) return true;
    if (path_join(out, size, state->def.where->assets, name) && path_is_file(out)) return true;
    return fail(error, DAFT_ERROR_IO, "there is no file '%s', neither in the game's folder nor in assets/", name);
}

/* Compiles one of the game's files. Its name in messages is short: where the folder stands does not matter. */
static int load_file(lua_State *L, const char *path, const char *shown)
{
    daft_error error;
    size_t size;
    char *text = read_whole_file(path, &size, &error);
    if (!text) {
        char message[1200];
        lua_pushstring(L, daft_error_text(&error, message, sizeof message));
        return LUA_ERRFILE;
    }
    const char *begin = text;
    if (size >= 3 && memcmp(begin, "\xEF\xBB\xBF", 3) == 0) begin += 3;
    int status = luaL_loadbufferx(L, begin, size - (size_t)(begin - text), shown, "t");
    free(text);
    return status;
}

/* "a.b" → a/b.lua in the game's folder, then in scripts/. */
static int find_module(lua_State *L, host *state, const char *name)
{
    char file[256], path[PATH_SIZE], shown[300];
    size_t length = strlen(name);
    if (length == 0 || length > 200 || name[0] == '/' || strstr(name, ".."))
        return luaL_error(L, "require: '%s' is not a module's name", name);
    snprintf(file, sizeof file, "%s.lua", name);
    for (size_t i = 0; i < length; i++)
        if (file[i] == '.') file[i] = '/';
    snprintf(shown, sizeof shown, "@%s/%s", state->def.name, file);
    if (path_join(path, sizeof path, state->def.folder, file) && path_is_file(path)) return load_file(L, path, shown);
    snprintf(shown, sizeof shown, "@scripts/%s", file);
    if (path_join(path, sizeof path, state->def.where->scripts, file) && path_is_file(path))
        return load_file(L, path, shown);
    return luaL_error(L, "require: there is no '%s' in the game's folder, nor in scripts/", file);
}

static int require(lua_State *L)
{
    host *state = api_host(L);
    const char *name = luaL_checkstring(L, 1);
    lua_settop(L, 1);
    luaL_getsubtable(L, LUA_REGISTRYINDEX, LUA_LOADED_TABLE);
    if (lua_getfield(L, 2, name) != LUA_TNIL) {
        if (lua_islightuserdata(L, -1)) return luaL_error(L, "require: '%s' requires itself", name);
        return 1;
    }
    lua_pop(L, 1);
    if (find_module(L, state, name) != LUA_OK) return lua_error(L);
    lua_pushlightuserdata(L, state); /* marks a module that is being loaded */
    lua_setfield(L, 2, name);
    lua_pushvalue(L, 1);
    lua_call(L, 1, 1);
    if (lua_isnil(L, -1)) {
        lua_pop(L, 1);
        lua_pushboolean(L, true);
    }
    lua_pushvalue(L, -1);
    lua_setfield(L, 2, name);
    return 1;
}

/* ---- calls ---- */

/* Turns any error value into the message, and keeps the trace. */
static int on_error(lua_State *L)
{
    host *state = api_host(L);
    const char *message = lua_tostring(L, 1);
    if (!message && luaL_callmeta(L, 1, "__tostring") && lua_isstring(L, -1)) message = lua_tostring(L, -1);
    if (!message) message = lua_pushfstring(L, "(an error that is a %s)", luaL_typename(L, 1));
    snprintf(state->message, sizeof state->message, "%s", message);
    luaL_traceback(L, L, NULL, 1);
    const char *trace = lua_tostring(L, -1), *last = strrchr(trace, '\n');
    /* The last line is this file's own call, which tells the author of a game nothing. */
    size_t length = last && strcmp(last, "\n\t[C]: in ?") == 0 ? (size_t)(last - trace) : strlen(trace);
    if (!memchr(trace, '\n', length)) length = 0;
    snprintf(state->trace, sizeof state->trace, "%.*s", (int)length, trace);
    return 1;
}

/* What to call. All of it happens under protection, since even pushing a string may run out of memory. */
typedef struct request {
    const char *callback; /* daft.NAME; NULL: function */
    lua_CFunction function;
    const char *key;  /* an argument, or NULL */
    const double *dt; /* an argument, or NULL */
} request;

static int carry_out(lua_State *L)
{
    const request *what = lua_touserdata(L, 1);
    if (!what->callback) return what->function(L);
    api_push(L);
    lua_pushstring(L, what->callback);
    lua_rawget(L, -2);
    if (!lua_isfunction(L, -1)) return 0;
    if (what->key) lua_pushstring(L, what->key);
    if (what->dt) lua_pushnumber(L, *what->dt);
    lua_call(L, (what->key != NULL) + (what->dt != NULL), 0);
    return 0;
}

static bool call(host *state, const char *shown, request what)
{
    lua_State *L = state->L;
    state->message[0] = state->trace[0] = 0;
    state->callback = shown;
    state->call_began = clock_now_ns();
    state->call_ran = 0;
    lua_settop(L, 0);
    lua_pushcfunction(L, on_error);
    lua_pushcfunction(L, carry_out);
    lua_pushlightuserdata(L, &what);
    int status = lua_pcall(L, 1, 0, 1);
    if (status != LUA_OK && state->message[0] == 0) /* out of memory, or an error in on_error: the handler did not run
                                                     */
        snprintf(state->message, sizeof state->message, "%s: %s", shown,
                 lua_type(L, -1) == LUA_TSTRING ? lua_tostring(L, -1) : "an error while handling an error");
    state->calling = NULL;
    lua_settop(L, 0);
    return status == LUA_OK;
}

bool host_load(host *state) { return call(state, "daft.load", (request){.callback = "load"}); }

bool host_update(host *state, double dt)
{
    return call(state, "daft.update", (request){.callback = "update", .dt = &dt});
}

bool host_key(host *state, int key, bool down)
{
    const char *name = input_key_name(key);
    if (down) return call(state, "daft.keypressed", (request){.callback = "keypressed", .key = name});
    return call(state, "daft.keyreleased", (request){.callback = "keyreleased", .key = name});
}

bool host_draw(host *state, const canvas *picture)
{
    state->hud_width = canvas_hud_width(picture);
    state->picture = picture;
    bool good = call(state, "daft.draw", (request){.callback = "draw"});
    state->picture = NULL;
    return good;
}

/* ---- opening and closing ---- */

static int build(lua_State *L)
{
    sandbox_open(L);
    api_register(L, api_host(L));
    lua_pushcfunction(L, require);
    lua_setglobal(L, "require");
    lua_sethook(L, watch, LUA_MASKCOUNT, WATCH_STEP);
    return 0;
}

static int run_main(lua_State *L)
{
    host *state = api_host(L);
    char path[PATH_SIZE + 16], shown[200];
    snprintf(path, sizeof path, "%s/main.lua", state->def.folder);
    snprintf(shown, sizeof shown, "@%s/main.lua", state->def.name);
    if (load_file(L, path, shown) != LUA_OK) return lua_error(L);
    lua_call(L, 0, 0);
    return 0;
}

bool host_open(host *state, const host_def *def)
{
    *state = (host){.def = *def, .hud_width = CANVAS_HEIGHT * 16.0f / 9.0f};
    random_seed(&state->random, def->seed);
    random_seed(&state->draw_random, ~def->seed);
    state->L = lua_newstate(allocate, state);
    if (!state->L) {
        snprintf(state->message, sizeof state->message, "out of memory for Lua");
        return false;
    }
    *(host **)lua_getextraspace(state->L) = state;
    return call(state, "daft", (request){.function = build}) &&
           call(state, "main.lua", (request){.function = run_main});
}

void host_close(host *state)
{
    if (!state->L) return;
    state->call_began = clock_now_ns(); /* finalizers run now */
    state->call_ran = 0;
    state->callback = "closing the game";
    lua_close(state->L);
    state->L = NULL;
}
