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

/* ---- memory ---- */

/* Bytes that are reserved with the engine at once, so that few of Lua's many small allocations have to ask it. */
enum { RESERVE_STEP = 256 << 10 };

/* Makes the reservation cover `bytes`. False: the game's limit is reached. */
static bool reserve(host *state, size_t bytes)
{
    if (bytes <= state->reserved) return true;
    size_t more = bytes - state->reserved, rounded = (more + RESERVE_STEP - 1) / RESERVE_STEP * RESERVE_STEP;
    if (!daft_engine_reserve(state->def.engine, rounded)) {
        rounded = more;
        if (!daft_engine_reserve(state->def.engine, more)) return false;
    }
    state->reserved += rounded;
    return true;
}

/* Gives back what is more than a step beyond what is held. */
static void unreserve(host *state)
{
    if (state->reserved < state->memory + 2 * RESERVE_STEP) return;
    size_t excess = state->reserved - state->memory - RESERVE_STEP;
    daft_engine_unreserve(state->def.engine, excess);
    state->reserved -= excess;
}

static void *move(const daft_allocator *memory, void *old, size_t old_size, size_t new_size)
{
    void *fresh = memory_take(memory, new_size);
    if (fresh && old) {
        memcpy(fresh, old, old_size < new_size ? old_size : new_size);
        memory_release(memory, old);
    }
    return fresh;
}

static void *allocate(void *user, void *pointer, size_t old_size, size_t new_size)
{
    host *state = user;
    size_t held = pointer ? old_size : 0; /* without a pointer, old_size is the kind of the new object */
    if (new_size == 0) {
        memory_release(state->def.memory, pointer);
        state->memory -= held;
        unreserve(state);
        return NULL;
    }
    if (!pointer && old_size == LUA_TSTRING && new_size > HOST_STRING) {
        state->long_string = true;
        return NULL;
    }
    if (new_size > held && !reserve(state, state->memory - held + new_size)) return NULL;
    void *grown = state->def.memory ? move(state->def.memory, pointer, held, new_size) : realloc(pointer, new_size);
    if (grown) state->memory += new_size - held;
    unreserve(state);
    return grown;
}

/* ---- stopping ----
 *
 * Where a call is to end, the hook below is set for every kind of event, in the state that runs and in each that the
 * error comes through, so that the next instruction or call raises the error again: no handler, __close or loop gets
 * further. */

enum { WATCH_STEP = 200000, EVERY_EVENT = LUA_MASKCALL | LUA_MASKRET | LUA_MASKLINE | LUA_MASKCOUNT };

bool host_stopping(const host *state)
{
    return state->stopped || (state->dog && watchdog_look(state->dog) > WATCHDOG_RUNNING);
}

void host_set_running(host *state, lua_State *L) { atomic_store_explicit(&state->running, L, memory_order_relaxed); }

static void describe_stop(const host *state, watchdog_state why, char *out, size_t size)
{
    if (why == WATCHDOG_LATE)
        snprintf(out, size, "%s ran for %g s without coming to an end", state->callback, watchdog_limit(state->dog));
    else
        snprintf(out, size, why == WATCHDOG_ASKED ? "%s was stopped" : "%s ran too long", state->callback);
}

enum { TRACE_LEVELS = 12 };

/* The first level from `level` on that is a script's, whose line is known; TRACE_LEVELS: none. */
static int next_script_level(lua_State *L, int level, lua_Debug *place)
{
    for (; level < TRACE_LEVELS && lua_getstack(L, level, place); level++)
        if (lua_getinfo(L, "Sln", place) && place->currentline > 0) return level;
    return TRACE_LEVELS;
}

/* Where the script is, without allocating, and without a look at tables of any size. */
static void describe_place(lua_State *L, host *state)
{
    lua_Debug place;
    char what[200];
    describe_stop(state, watchdog_look(state->dog), what, sizeof what);
    int level = next_script_level(L, 0, &place);
    if (level == TRACE_LEVELS) {
        snprintf(state->failure.message, sizeof state->failure.message, "%s", what);
        return;
    }
    snprintf(state->failure.message, sizeof state->failure.message, "%s:%d: %s", place.short_src, place.currentline,
             what);
    size_t used = (size_t)snprintf(state->failure.trace, sizeof state->failure.trace, "stack traceback:");
    for (; level < TRACE_LEVELS && used + 256 < sizeof state->failure.trace;
         level = next_script_level(L, level + 1, &place))
        used +=
            (size_t)snprintf(state->failure.trace + used, sizeof state->failure.trace - used, "\n\t%s:%d: in %s%.60s%s",
                             place.short_src, place.currentline, place.name ? "function '" : "a function",
                             place.name ? place.name : "", place.name ? "'" : "");
}

static void on_stop(lua_State *L, lua_Debug *unused);

static void raise_stop(lua_State *L, host *state)
{
    lua_sethook(L, on_stop, EVERY_EVENT, 1);
    if (!state->stopped) {
        state->stopped = true;
        state->asked = watchdog_look(state->dog) == WATCHDOG_ASKED;
        describe_place(L, state);
    }
    lua_pushstring(L, state->failure.message);
    lua_error(L);
}

static void on_stop(lua_State *L, lua_Debug *unused)
{
    (void)unused;
    host *state = api_host(L);
    if (host_stopping(state)) raise_stop(L, state);
    lua_sethook(L, NULL, 0, 0); /* a coroutine that outlived a call that was stopped */
}

/* In the watchdog's signal handler, on the thread that runs the script. lua_sethook is made for that. */
static void interrupt(void *user)
{
    lua_State *L = atomic_load_explicit(&((host *)user)->running, memory_order_relaxed);
    if (L) lua_sethook(L, on_stop, EVERY_EVENT, 1);
}

static void count_steps(lua_State *L, uint64_t steps)
{
    host *state = api_host(L);
    state->call_ran += steps;
    const uint64_t limit = state->call_limit ? state->call_limit : state->def.instructions;
    if (host_stopping(state) || (limit && state->call_ran > limit)) raise_stop(L, state);
}

static void watch(lua_State *L, lua_Debug *unused)
{
    (void)unused;
    count_steps(L, WATCH_STEP);
}

_Static_assert((int)HOST_POLL_STEPS == (int)PATTERNS_POLL_STEPS, "patterns poll by host_poll");
void host_poll(lua_State *L) { count_steps(L, HOST_POLL_STEPS); }

void host_limit_steps(lua_State *L, uint64_t steps)
{
    api_host(L)->call_limit = steps;
    lua_sethook(L, watch, LUA_MASKCOUNT, WATCH_STEP);
}

/* ThreadSanitizer holds signals back until the thread calls the system, which a loop in Lua never does. */
#if defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define __SANITIZE_THREAD__
#endif
#endif
#if defined(__SANITIZE_THREAD__)
static const bool HOLDS_SIGNALS = true;
#else
static const bool HOLDS_SIGNALS = false;
#endif

/* Counting instructions makes every one of them slower: only where somebody wants it. */
static void set_usual_hook(host *state, lua_State *L)
{
    if (state->def.instructions || HOLDS_SIGNALS)
        lua_sethook(L, watch, LUA_MASKCOUNT, WATCH_STEP);
    else
        lua_sethook(L, NULL, 0, 0);
}

/* ---- files ---- */

/* Absolute, or with a part "..". */
static bool leads_outside(const char *name)
{
    for (const char *part = name; part; part = strchr(part, '/') ? strchr(part, '/') + 1 : NULL)
        if (strncmp(part, "..", 2) == 0 && (part[2] == 0 || part[2] == '/')) return true;
    return name[0] == '/';
}

enum { MOST_NEAR = 512 };

typedef struct file_names {
    const char *names[MOST_NEAR];
    char text[16384];
    size_t count, used;
} file_names;

static void keep_name(void *user, const char *name)
{
    file_names *list = user;
    const size_t size = strlen(name) + 1;
    if (list->count == MOST_NEAR || list->used + size > sizeof list->text) return;
    memcpy(list->text + list->used, name, size);
    list->names[list->count++] = list->text + list->used;
    list->used += size;
}

/* By the names of files in the same folder. */
static const char *near_file(const host *state, const char *name, char out[HINT_SIZE])
{
    file_names *list = calloc(1, sizeof *list);
    const char *slash = strrchr(name, '/');
    char folder[PATH_SIZE];
    out[0] = 0;
    if (!list) return out;
    const int length = slash ? (int)(slash - name) : 0;
    snprintf(folder, sizeof folder, "%.*s", length, name);
    daft_files_list(state->def.files, folder, keep_name, list);
    if (!slash) daft_files_list(state->def.files, "meshes", keep_name, list); /* which may be left out */
    char prefix[64];
    if (snprintf(prefix, sizeof prefix, "%.*s", slash ? length + 1 : 0, name) < (int)sizeof prefix)
        did_you_mean(out, prefix, slash ? slash + 1 : name, list->names, list->count);
    free(list);
    return out;
}

bool host_find_file(const host *state, const char *name, char *out, size_t size, daft_error *error)
{
    if (daft_files_find(state->def.files, name, out, size)) return true;
    if (leads_outside(name))
        return fail(error, DAFT_ERROR_ARGUMENT, "'%s' leads outside: files are in the game's folder or in assets/",
                    name);
    char hint[HINT_SIZE];
    return error && fail(error, DAFT_ERROR_IO, "there is no file '%s', neither in the game's folder nor in assets/%s",
                         name, near_file(state, name, hint));
}

/* Compiles one of the game's files. Its name in messages is short: where the folder stands does not matter. `module`:
 * it is this one of scripts/; NULL: it is none. */
static int load_file(lua_State *L, const char *path, const char *shown, const char *module)
{
    daft_error error;
    size_t size;
    char *text = daft_read_file(api_host(L)->def.files, path, &size, &error);
    if (!text) {
        char message[1200];
        lua_pushstring(L, daft_error_text(&error, message, sizeof message));
        return LUA_ERRFILE;
    }
    const host_def *def = &api_host(L)->def;
    if (module && def->required) def->required(def->user, module, text, size);
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
    if (daft_files_find(state->def.files, file, path, sizeof path)) {
        size_t scripts = strlen(state->def.scripts);
        bool is_ours = strncmp(path, state->def.scripts, scripts) == 0 && path[scripts] == '/';
        snprintf(shown, sizeof shown, "@%s/%s", is_ours ? "scripts" : state->def.name, file);
        return load_file(L, path, shown, is_ours ? name : NULL);
    }
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

void host_keep_trace(host *state, lua_State *L, lua_State *failed)
{
    if (state->inner[0]) return;
    luaL_traceback(L, failed, NULL, 0);
    failure_take_values(&state->failure, failed, 0,
                        lua_type(failed, -1) == LUA_TSTRING ? lua_tostring(failed, -1) : "");
    snprintf(state->inner, sizeof state->inner, "%s", lua_tostring(L, -1));
    lua_pop(L, 1);
}

void host_forget_trace(host *state) { state->inner[0] = state->failure.values[0] = 0; }

/* Turns any error value into the message, and keeps the trace: that of the coroutine in which it began, and then its
 * caller's. */
static int on_error(lua_State *L)
{
    host *state = api_host(L);
    if (host_stopping(state)) return 1;
    const char *message = lua_tostring(L, 1);
    if (!message && luaL_callmeta(L, 1, "__tostring") && lua_isstring(L, -1)) message = lua_tostring(L, -1);
    if (!message) message = lua_pushfstring(L, "(an error that is a %s)", luaL_typename(L, 1));
    snprintf(state->failure.message, sizeof state->failure.message, "%s", message);
    failure_take_values(&state->failure, L, 1, message);
    luaL_traceback(L, L, NULL, 1);
    const char *trace = lua_tostring(L, -1), *last = strrchr(trace, '\n');
    /* The last line is this file's own call, which tells the author of a game nothing. */
    size_t length = last && strcmp(last, "\n\t[C]: in ?") == 0 ? (size_t)(last - trace) : strlen(trace);
    if (!memchr(trace, '\n', length)) length = 0;
    const char *lines = state->inner[0] && length ? memchr(trace, '\n', length) : trace;
    snprintf(state->failure.trace, sizeof state->failure.trace, "%s%.*s", state->inner,
             (int)(length - (size_t)(lines - trace)), lines);
    return 1;
}

/* What to call. All of it happens under protection, since even pushing a string may run out of memory. */
typedef struct request {
    const char *callback; /* daft.NAME; NULL: function */
    lua_CFunction function;
    const char *file;   /* the game's, which run_file runs */
    const char *key;    /* an argument, or NULL */
    const double *dt;   /* an argument, or NULL */
    const char *handed; /* an argument as text, or NULL */
    bool *has;          /* only says whether there is this callback; or NULL */
} request;

static int run_file(lua_State *L, const char *file)
{
    const host *state = api_host(L);
    char path[PATH_SIZE + 256], shown[400];
    snprintf(path, sizeof path, "%s/%s", state->def.folder, file);
    snprintf(shown, sizeof shown, "@%s/%s", state->def.name, file);
    if (load_file(L, path, shown, NULL) != LUA_OK) return lua_error(L);
    lua_call(L, 0, 0);
    return 0;
}

static int carry_out(lua_State *L)
{
    const request *what = lua_touserdata(L, 1);
    if (what->file) return run_file(L, what->file);
    if (!what->callback) return what->function(L);
    api_push(L);
    lua_pushstring(L, what->callback);
    lua_rawget(L, -2);
    if (what->has) *what->has = lua_isfunction(L, -1);
    if (!lua_isfunction(L, -1) || what->has) return 0;
    if (what->handed) api_push_handed(L, what->handed);
    if (what->key) lua_pushstring(L, what->key);
    if (what->dt) lua_pushnumber(L, *what->dt);
    lua_call(L, (what->key != NULL) + (what->dt != NULL) + (what->handed != NULL), 0);
    return 0;
}

/* The message of a call that failed without one: out of memory, or an error in on_error. */
static void describe_failure(host *state, int status, watchdog_state ended)
{
    lua_State *L = state->L;
    if (state->failure.message[0]) return;
    if (ended == WATCHDOG_RUNNING && status == LUA_ERRMEM && state->long_string) {
        snprintf(state->failure.message, sizeof state->failure.message,
                 "%s: not enough memory: a string may hold %zu MB at most", state->callback, HOST_STRING >> 20);
        return;
    }
    daft_memory memory = daft_engine_memory(state->def.engine);
    if (ended == WATCHDOG_RUNNING && status == LUA_ERRMEM && memory.limit) {
        snprintf(state->failure.message, sizeof state->failure.message,
                 "%s: not enough memory: of the %.1f MB that the game may hold, %.1f are in use (--memory-limit)",
                 state->callback, (double)memory.limit / 1e6, (double)memory.used / 1e6);
        return;
    }
    if (ended != WATCHDOG_RUNNING)
        describe_stop(state, ended, state->failure.message, sizeof state->failure.message);
    else
        snprintf(state->failure.message, sizeof state->failure.message, "%s: %s", state->callback,
                 lua_type(L, -1) == LUA_TSTRING ? lua_tostring(L, -1) : "an error while handling an error");
}

static bool call(host *state, const char *shown, request what)
{
    lua_State *L = state->L;
    failure_clear(&state->failure);
    state->inner[0] = 0;
    state->callback = shown;
    state->call_ran = state->call_limit = 0;
    state->stopped = state->asked = state->long_string = false;
    state->depth = 0;
    lua_settop(L, 0);
    lua_pushcfunction(L, on_error);
    lua_pushcfunction(L, carry_out);
    lua_pushlightuserdata(L, &what);
    host_set_running(state, L);
    const uint64_t began = trace_begin(state->def.spans);
    profile_enter(state->def.profile, &state->running);
    watchdog_begin(state->dog, shown, 1);
    int status = lua_pcall(L, 1, 0, 1);
    watchdog_state ended = watchdog_end(state->dog);
    trace_end(state->def.spans, shown, began);
    host_set_running(state, NULL);
    profile_leave(state->def.profile);
    set_usual_hook(state, L);
    bool good = status == LUA_OK && ended == WATCHDOG_RUNNING;
    state->ended = ended;
    if (ended == WATCHDOG_ASKED) state->asked = true;
    if (!good) describe_failure(state, status, ended);
    if (!good) failure_find_source(&state->failure, state->def.files);
    state->calling = NULL;
    lua_settop(L, 0);
    return good;
}

bool host_run_file(host *state, const char *file) { return call(state, file, (request){.file = file}); }

bool host_call(host *state, const char *shown, lua_CFunction function)
{
    return call(state, shown, (request){.function = function});
}

bool host_load(host *state) { return call(state, "daft.load", (request){.callback = "load"}); }

bool host_collect(host *state)
{
    enum { ENOUGH = 256 };
    if (state->made < ENOUGH) return true;
    state->made = 0;
    return call(state, "collecting", (request){.function = api_collect});
}

void host_begin_tick(host *state) { state->scale = state->next_scale; }

void host_end_tick(host *state)
{
    state->still = state->scale == 0;
    host_step_particles(state, state->scale / 60);
    state->clock += state->scale;
    state->tick++;
}

bool host_update(host *state, double dt)
{
    dt *= state->scale;
    return call(state, "daft.update", (request){.callback = "update", .dt = &dt}) &&
           (state->tasks == 0 || call(state, "a task of daft.start", (request){.function = api_step_tasks}));
}

bool host_key(host *state, int key, bool down)
{
    const char *name = input_key_name(key);
    if (down) return call(state, "daft.keypressed", (request){.callback = "keypressed", .key = name});
    return call(state, "daft.keyreleased", (request){.callback = "keyreleased", .key = name});
}

bool host_typed(host *state, int code)
{
    char letter[5];
    utf8_put((uint32_t)code, letter);
    return call(state, "daft.textinput", (request){.callback = "textinput", .key = letter});
}

bool host_has(host *state, const char *callback)
{
    bool has = false;
    return call(state, "daft", (request){.callback = callback, .has = &has}) && has;
}

bool host_hand_over(host *state) { return call(state, "daft.keep", (request){.function = api_hand_over}); }

bool host_reload(host *state, const char *handed)
{
    return call(state, "daft.reload", (request){.callback = "reload", .handed = handed});
}

static bool drawing_stops(void *user) { return host_stopping(user); }

float host_width(const host *state)
{
    if (state->picture) return canvas_hud_width(state->picture);
    return state->def.keys->width;
}

bool host_draw(host *state, const canvas *picture)
{
    canvas over = *picture;
    over.stops = drawing_stops, over.user = state, over.marks = &state->texts;
    state->texts = (canvas_marks){0};
    state->picture = &over;
    bool good = call(state, "daft.draw", (request){.callback = "draw"});
    state->picture = NULL;
    return good;
}

/* ---- opening and closing ---- */

static int build(lua_State *L)
{
    sandbox_open(L);
    api_register(L, api_host(L));
    api_set_wait(L);
    lua_pushcfunction(L, require);
    lua_setglobal(L, "require");
    set_usual_hook(api_host(L), L);
    return 0;
}

bool host_open(host *state, const host_def *def)
{
    *state = (host){.def = *def, .target_ms = -1, .window.full_screen = -1, .scale = 1, .next_scale = 1};
    mixer_init(&state->mixer);
    state->cache = def->sounds ? sound_cache_hold(def->sounds) : sound_cache_open(def->memory);
    random_seed(&state->random, def->seed);
    random_seed(&state->draw_random, ~def->seed);
    state->L = lua_newstate(allocate, state);
    if (!state->L) {
        snprintf(state->failure.message, sizeof state->failure.message, "out of memory for Lua");
        return false;
    }
    *(host **)lua_getextraspace(state->L) = state;
    watchdog_def watch_over = {
        .seconds = def->seconds, .interrupt = interrupt, .asked = def->asked, .user = state, .asker = def->user};
    daft_error error;
    state->dog = watchdog_open(&watch_over, &error);
    if (!state->dog) {
        snprintf(state->failure.message, sizeof state->failure.message, "%s", error.message);
        return false;
    }
    return call(state, "daft", (request){.function = build}) && host_run_file(state, "main.lua");
}

void host_close(host *state)
{
    watchdog_close(state->dog);
    state->dog = NULL;
    if (state->L) lua_close(state->L);
    state->L = NULL;
    free(state->handed);
    state->handed = NULL;
    mixer_free(&state->mixer);
    sound_cache_release(state->cache);
    state->cache = NULL;
    daft_image_destroy(state->window.icon);
    state->window.icon = NULL;
    daft_engine_unreserve(state->def.engine, state->reserved);
    state->reserved = 0;
}
