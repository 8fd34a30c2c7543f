/* daft.test: tests of a game, in files of its folder tests/, for `daft test-game`. */
#include "lua/api.h"
#include "lua/trial.h"

#include "common/util.h"

#include <stdio.h>
#include <string.h>

/* Registry keys: the wanted test, then its task. */
static const char WANTED_KEY, TASK_KEY;

static trial *running_trial(lua_State *L, host *h)
{
    if (!h->trial) api_error(L, h, "only in files of the folder tests/, which 'daft test-game' runs");
    return h->trial;
}

static void copy_name(lua_State *L, host *h, char out[TRIAL_NAME])
{
    const char *name = api_text(L, h, 1, "name");
    size_t length = strlen(name);
    if (length == 0 || length >= TRIAL_NAME) api_error(L, h, "name: 1 to %d bytes expected", TRIAL_NAME - 1);
    snprintf(out, TRIAL_NAME, "%s", name);
}

static int test(lua_State *L, host *h)
{
    trial *self = running_trial(L, h);
    char name[TRIAL_NAME];
    copy_name(L, h, name);
    if (!lua_isfunction(L, 2)) api_wrong(L, h, 2, "function", "function");
    if (self->runs) api_error(L, h, "not within a test");
    if (self->count++ != self->wanted) return 0;
    memcpy(self->name, name, sizeof name);
    lua_settop(L, 2);
    lua_rawsetp(L, LUA_REGISTRYINDEX, &WANTED_KEY);
    return 0;
}

static double allowance(lua_State *L, host *h, const char *name, double usual)
{
    if (!api_field(L, 2, name)) return usual;
    double value = api_number(L, h, -1, name);
    if (!(value >= 0 && value <= 1)) api_wrong(L, h, -1, name, "number from 0 to 1");
    lua_pop(L, 1);
    return value;
}

static int picture(lua_State *L, host *h)
{
    static const char *const FIELDS[] = {"max", "mean"};
    trial *self = running_trial(L, h);
    trial_picture wanted = {.max = 0.25, .mean = 0.01};
    copy_name(L, h, wanted.name);
    if (strspn(wanted.name, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-") != strlen(wanted.name))
        api_error(L, h, "name: letters, digits, '_' and '-' expected, got '%.60s'", wanted.name);
    if (!self->runs) api_error(L, h, "only within a test");
    if (!lua_isnoneornil(L, 2)) {
        api_fields(L, h, 2, "its table", FIELDS, COUNT_OF(FIELDS));
        wanted.max = allowance(L, h, "max", wanted.max), wanted.mean = allowance(L, h, "mean", wanted.mean);
    }
    if (self->picture_count == TRIAL_PICTURES) api_error(L, h, "at most %d pictures in a tick", (int)TRIAL_PICTURES);
    self->pictures[self->picture_count++] = wanted;
    return 0;
}

static const api_function FUNCTIONS[] = {
    {"test.picture", "(name [, {max =, mean =}])",
     "Only in a test: the picture after this tick is like tests/pictures/NAME.png. max is how far any channel of any\n"
     "pixel may be off, of 1 (0.25); mean is the mean over all (0.01).",
     picture, 0},
    {"test", "(name, function)",
     "Only in files of the game's folder tests/: what `daft test-game` runs, as a task beside the game, from the\n"
     "beginning of a game of its own. An error in it fails the test. scripts/test.lua has more for tests.",
     test, 0},
};

const api_area api_test = {"Tests", FUNCTIONS, COUNT_OF(FUNCTIONS)};

/* ---- the host's side ---- */

/* A task of the test, as daft.start makes it. */
static int begin(lua_State *L)
{
    if (lua_rawgetp(L, LUA_REGISTRYINDEX, &WANTED_KEY) == LUA_TNIL) return 0;
    api_push(L);
    lua_getfield(L, -1, "start");
    lua_rotate(L, -3, 1);
    lua_pop(L, 1);
    api_host(L)->trial->runs = true;
    lua_call(L, 1, 1);
    lua_rawsetp(L, LUA_REGISTRYINDEX, &TASK_KEY);
    return 0;
}

static int look(lua_State *L)
{
    api_push(L);
    lua_getfield(L, -1, "running");
    lua_rawgetp(L, LUA_REGISTRYINDEX, &TASK_KEY);
    lua_call(L, 1, 1);
    api_host(L)->trial->runs = lua_toboolean(L, -1);
    return 0;
}

bool trial_begin(host *state, trial *self, const char *file)
{
    state->trial = self;
    return host_run_file(state, file) && host_call(state, "the test", begin);
}

void trial_look(host *state, trial *self)
{
    if (self->runs && !host_call(state, "the test", look)) self->runs = false;
}
