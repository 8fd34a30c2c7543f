/* From the tables of functions to the table `daft`: registration, the one function that every binding is called
 * through, and the types of handles. */
#include "lua/fields.h"

#include "common/util.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

/* clang-format off: one a line, so that two changes seldom meet in one */
static const api_area *const AREAS[] = {
    &api_entity,   &api_animation, &api_hierarchy, &api_tags,    &api_body, &api_joint, &api_character, &api_query,
    &api_material, &api_light,     &api_camera,    &api_input,   &api_hud,  &api_draw,  &api_time,      &api_world,
    &api_window,   &api_chance,    &api_particles, &api_picture, &api_save, &api_sound, &api_test,
};
/* clang-format on */

static const char *const CALLBACKS[] = {"load",        "update",    "draw", "keypressed",
                                        "keyreleased", "textinput", "keep", "reload"};
static const char *const TYPES[API_TYPES] = {"entity", "light", "material", "mesh",  "joint",  "character", "picture",
                                             "sound",  "voice", "font",     "image", "stream", "particles"};

/* Registry keys: the addresses of these. */
static const char DAFT_KEY, ENTITIES_KEY;
static const char TYPE_KEYS[API_TYPES];

const api_area *const *api_areas(size_t *count)
{
    *count = COUNT_OF(AREAS);
    return AREAS;
}

const char *const *api_callbacks(size_t *count)
{
    *count = COUNT_OF(CALLBACKS);
    return CALLBACKS;
}

host *api_host(lua_State *L) { return *(host **)lua_getextraspace(L); }

void api_push(lua_State *L) { lua_rawgetp(L, LUA_REGISTRYINDEX, &DAFT_KEY); }

void api_poll(lua_State *L, uint64_t step)
{
    if (step % HOST_POLL_STEPS == HOST_POLL_STEPS - 1) host_poll(L);
}

/* ---- errors ---- */

int api_error(lua_State *L, host *h, const char *format, ...)
{
    char message[900];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    const char *name = h->calling ? h->calling->name : "?";
    luaL_error(L, "%s%s: %s", strchr(name, ':') ? "" : "daft.", name, message);
    __builtin_unreachable();
}

void api_check_may_change(lua_State *L, host *h)
{
    if (h->picture)
        api_error(L, h, "not within daft.draw: drawing must not change the game, so do this in daft.update");
}

const char *api_type_name(lua_State *L, int index)
{
    for (int type = 0; type < API_TYPES; type++)
        if (api_test_handle(L, index, (api_type)type)) return TYPES[type];
    return luaL_typename(L, index);
}

/* What is in a table, as far as it helps to see the mistake: most tables stand for numbers. */
static void describe_table(lua_State *L, int index, char *out, size_t size)
{
    index = lua_absindex(L, index);
    size_t count = lua_rawlen(L, index);
    for (size_t i = 1; i <= count && i <= 4; i++) {
        int type = lua_rawgeti(L, index, (lua_Integer)i);
        bool finite = type == LUA_TNUMBER && isfinite(lua_tonumber(L, -1));
        lua_pop(L, 1);
        if (finite) continue;
        snprintf(out, size, "a list with %s in place %zu",
                 type == LUA_TNUMBER ? "a number that is not finite" : lua_typename(L, type), i);
        return;
    }
    if (count > 0)
        snprintf(out, size, "a list of %zu", count);
    else
        snprintf(out, size, "a table without that");
}

int api_wrong(lua_State *L, host *h, int index, const char *what, const char *wanted)
{
    if (lua_type(L, index) == LUA_TTABLE) {
        char text[80];
        describe_table(L, index, text, sizeof text);
        api_error(L, h, "%s: %s expected, got %s", what, wanted, text);
    }
    const char *type = api_type_name(L, index);
    if (lua_type(L, index) == LUA_TSTRING) {
        char text[40];
        snprintf(text, sizeof text, "%s", lua_tostring(L, index));
        api_error(L, h, "%s: %s expected, got the string '%s'", what, wanted, text);
    }
    if (lua_type(L, index) == LUA_TNUMBER)
        api_error(L, h, "%s: %s expected, got the number %g", what, wanted, lua_tonumber(L, index));
    api_error(L, h, "%s: %s expected, got %s", what, wanted, lua_isnone(L, index) ? "nothing" : type);
}

int api_engine_error(lua_State *L, host *h, const daft_error *error)
{
    char text[1100];
    api_error(L, h, "%s", daft_error_text(error, text, sizeof text));
}

/* ---- calls ---- */

static void no_method(lua_State *L, host *h, const api_function *function, api_type type)
{
    api_error(L, h, "%s expected before the colon, got %s: call it as x:%s(...)", TYPES[type],
              lua_isnone(L, 1) ? "nothing" : api_type_name(L, 1), strchr(function->name, ':') + 1);
}

typedef struct binding {
    const api_function *function;
    int type; /* an api_type that it is a method of, or -1 */
} binding;

/* Every function of the API is called through this. Upvalue: its binding. */
static int dispatch(lua_State *L)
{
    const binding *called = lua_touserdata(L, lua_upvalueindex(1));
    const api_function *function = called->function;
    host *h = api_host(L);
    h->calling = function;
    if (h->picture && (function->flags & API_CHANGES))
        api_error(L, h, "not within daft.draw: drawing must not change the game, so do this in daft.update");
    if (!h->picture && (function->flags & API_DRAWS)) api_error(L, h, "only within daft.draw");
    if (called->type >= 0) {
        const api_handle *self = lua_type(L, 1) == LUA_TUSERDATA ? lua_touserdata(L, 1) : NULL;
        if (!self || self->type != called->type) no_method(L, h, function, (api_type)called->type);
        h->self = self;
    }
    return function->call(L, h);
}

static void push_binding(lua_State *L, const api_function *function, int type)
{
    binding *made = lua_newuserdatauv(L, sizeof *made, 0);
    *made = (binding){function, type};
}

static void push_function(lua_State *L, const api_function *function, int type)
{
    push_binding(L, function, type);
    lua_pushcclosure(L, dispatch, 1);
}

/* daft.input.mouse is a table that can be called; the call must not see the table. */
static int call_table(lua_State *L)
{
    lua_remove(L, 1);
    return dispatch(L);
}

/* ---- the table `daft` ---- */

/* Reading a name that is not there: nil for callbacks, else an error with a near miss. */
static int missing(lua_State *L)
{
    const char *name = lua_type(L, 2) == LUA_TSTRING ? lua_tostring(L, 2) : NULL;
    const char *path = lua_tostring(L, lua_upvalueindex(1));
    for (size_t i = 0; name && strcmp(path, "daft") == 0 && i < COUNT_OF(CALLBACKS); i++)
        if (strcmp(name, CALLBACKS[i]) == 0) return 0;
    if (!name) return luaL_error(L, "%s has no field that is a %s", path, luaL_typename(L, 2));
    const char *names[128];
    size_t count = 0;
    for (lua_pushnil(L); lua_next(L, 1) && count < COUNT_OF(names); lua_pop(L, 1))
        if (lua_type(L, -2) == LUA_TSTRING) names[count++] = lua_tostring(L, -2);
    const char *near = nearest_name(name, names, count);
    return luaL_error(L, near ? "%s has no '%s': did you mean '%s'?" : "%s has no '%s'", path, name, near);
}

/* Setting a new name: callbacks only. */
static int refuse(lua_State *L)
{
    const char *name = lua_type(L, 2) == LUA_TSTRING ? lua_tostring(L, 2) : luaL_typename(L, 2);
    const char *path = lua_tostring(L, lua_upvalueindex(1));
    if (strcmp(path, "daft") != 0) return luaL_error(L, "%s.%s cannot be set", path, name);
    for (size_t i = 0; i < COUNT_OF(CALLBACKS); i++) {
        if (strcmp(name, CALLBACKS[i]) != 0) continue;
        if (!lua_isfunction(L, 3) && !lua_isnil(L, 3))
            return luaL_error(L, "daft.%s must be a function, got %s", name, luaL_typename(L, 3));
        lua_rawset(L, 1);
        return 0;
    }
    const char *near = nearest_name(name, CALLBACKS, COUNT_OF(CALLBACKS));
    return luaL_error(L,
                      near ? "daft calls no function '%s': did you mean '%s'?"
                           : "daft calls no function '%s': it has load, update, draw, keypressed, keyreleased, "
                             "textinput, keep and reload",
                      name, near);
}

/* Gives the table on top a metatable that knows its path. */
static void guard(lua_State *L, const char *path, const api_function *call_as)
{
    lua_createtable(L, 0, 4);
    lua_pushstring(L, path);
    lua_pushcclosure(L, missing, 1);
    lua_setfield(L, -2, "__index");
    lua_pushstring(L, path);
    lua_pushcclosure(L, refuse, 1);
    lua_setfield(L, -2, "__newindex");
    lua_pushboolean(L, false);
    lua_setfield(L, -2, "__metatable");
    if (call_as) {
        push_binding(L, call_as, -1);
        lua_pushcclosure(L, call_table, 1);
        lua_setfield(L, -2, "__call");
    }
    lua_setmetatable(L, -2);
}

/* With a table on top: puts the function at its dotted path, making tables on the way. A function whose name is already
 * a table becomes what calling the table does: "input.mouse" must come after "input.mouse.down". */
static void put_function(lua_State *L, const api_function *function)
{
    int top = lua_gettop(L);
    char path[64] = "daft";
    const char *part = function->name;
    for (const char *dot; (dot = strchr(part, '.')); part = dot + 1) {
        size_t used = strlen(path);
        snprintf(path + used, sizeof path - used, ".%.*s", (int)(dot - part), part);
        lua_pushlstring(L, part, (size_t)(dot - part));
        lua_pushvalue(L, -1);
        if (lua_rawget(L, -3) == LUA_TNIL) {
            lua_pop(L, 1);
            lua_newtable(L);
            guard(L, path, NULL);
            lua_pushvalue(L, -2);
            lua_pushvalue(L, -2);
            lua_rawset(L, -5);
        }
        lua_remove(L, -2);
    }
    lua_pushstring(L, part);
    lua_pushvalue(L, -1);
    if (lua_rawget(L, -3) == LUA_TTABLE) {
        char full[96];
        snprintf(full, sizeof full, "daft.%s", function->name);
        guard(L, full, function);
    } else {
        lua_pop(L, 1);
        push_function(L, function, -1);
        lua_rawset(L, -3);
    }
    lua_settop(L, top);
}

/* ---- types ---- */

static int handle_text(lua_State *L)
{
    const api_handle *handle = lua_touserdata(L, 1);
    lua_pushfstring(L, "%s %d", api_type_name(L, 1), (int)(handle ? handle->id : 0));
    return 1;
}

/* Two handles of the same entity, light, … are equal. */
static int handle_equal(lua_State *L)
{
    const api_handle *a = lua_touserdata(L, 1), *b = lua_touserdata(L, 2);
    bool equal = a && b && a->id == b->id;
    for (int type = 0; equal && type < API_TYPES; type++)
        equal = (api_test_handle(L, 1, (api_type)type) != NULL) == (api_test_handle(L, 2, (api_type)type) != NULL);
    lua_pushboolean(L, equal);
    return 1;
}

/* Fields of handles: methods, then e.name and e.data, which live in the user value. */
static int handle_index(lua_State *L)
{
    lua_pushvalue(L, 2);
    if (lua_rawget(L, lua_upvalueindex(1)) != LUA_TNIL) return 1;
    const char *type = api_type_name(L, 1), *name = luaL_checkstring(L, 2);
    if (strcmp(type, "entity") == 0 && (strcmp(name, "name") == 0 || strcmp(name, "data") == 0)) {
        lua_getiuservalue(L, 1, 1);
        lua_getfield(L, -1, name);
        return 1;
    }
    const char *names[64] = {"name", "data"};
    size_t count = strcmp(type, "entity") == 0 ? 2 : 0;
    for (lua_pushnil(L); count < COUNT_OF(names) && lua_next(L, lua_upvalueindex(1)); lua_pop(L, 1))
        names[count++] = lua_tostring(L, -2);
    const char *near = nearest_name(name, names, count);
    return luaL_error(L, near ? "%s has no '%s': did you mean '%s'?" : "%s has no '%s'", type, name, near);
}

static int handle_set(lua_State *L)
{
    const char *type = api_type_name(L, 1), *name = luaL_checkstring(L, 2);
    if (strcmp(type, "entity") != 0 || (strcmp(name, "name") != 0 && strcmp(name, "data") != 0))
        return luaL_error(L, "%s.%s cannot be set%s", type, name,
                          strcmp(type, "entity") == 0 ? ": keep what is yours in its data" : "");
    if (name[0] == 'n' && lua_type(L, 3) != LUA_TSTRING)
        return luaL_error(L, "entity.name: string expected, got %s", luaL_typename(L, 3));
    if (name[0] == 'n')
        api_set_name(L, 1);
    else
        api_set_own(L, 1, name);
    return 0;
}

static void register_type(lua_State *L, api_type type)
{
    lua_createtable(L, 0, 8);
    lua_pushstring(L, TYPES[type]);
    lua_setfield(L, -2, "__name");
    lua_pushcfunction(L, handle_text);
    lua_setfield(L, -2, "__tostring");
    lua_pushcfunction(L, handle_equal);
    lua_setfield(L, -2, "__eq");
    lua_pushcfunction(L, handle_set);
    lua_setfield(L, -2, "__newindex");
    lua_pushboolean(L, false);
    lua_setfield(L, -2, "__metatable");
    if (type == API_MATERIAL || type == API_MESH) {
        lua_pushinteger(L, type);
        lua_pushcclosure(L, api_release_handle, 1);
        lua_setfield(L, -2, "__gc");
    }
    static const lua_CFunction RELEASES[API_TYPES] = {[API_PICTURE] = api_release_picture,
                                                      [API_PARTICLES] = api_release_particles,
                                                      [API_SOUND] = api_release_sound,
                                                      [API_FONT] = api_release_font,
                                                      [API_IMAGE] = api_release_image};
    if (RELEASES[type]) {
        lua_pushcfunction(L, RELEASES[type]);
        lua_setfield(L, -2, "__gc");
    }
    lua_newtable(L);
    for (size_t area = 0; area < COUNT_OF(AREAS); area++) {
        for (size_t i = 0; i < AREAS[area]->count; i++) {
            const api_function *function = &AREAS[area]->functions[i];
            const char *colon = strchr(function->name, ':');
            size_t length = colon ? (size_t)(colon - function->name) : 0;
            if (!colon || strlen(TYPES[type]) != length || strncmp(function->name, TYPES[type], length) != 0) continue;
            push_function(L, function, (int)type);
            lua_setfield(L, -2, colon + 1);
        }
    }
    lua_pushcclosure(L, handle_index, 1);
    lua_setfield(L, -2, "__index");
    lua_rawsetp(L, LUA_REGISTRYINDEX, &TYPE_KEYS[type]);
}

void api_register(lua_State *L, host *h)
{
    (void)h;
    for (int type = 0; type < API_TYPES; type++) register_type(L, (api_type)type);
    lua_newtable(L);
    lua_rawsetp(L, LUA_REGISTRYINDEX, &ENTITIES_KEY);
    lua_newtable(L);
    for (size_t area = 0; area < COUNT_OF(AREAS); area++)
        for (size_t i = 0; i < AREAS[area]->count; i++)
            if (!strchr(AREAS[area]->functions[i].name, ':')) put_function(L, &AREAS[area]->functions[i]);
    guard(L, "daft", NULL);
    lua_pushvalue(L, -1);
    lua_rawsetp(L, LUA_REGISTRYINDEX, &DAFT_KEY);
    /* As a loaded module too, so that traces say "in function 'daft.text'". */
    luaL_getsubtable(L, LUA_REGISTRYINDEX, LUA_LOADED_TABLE);
    lua_pushvalue(L, -2);
    lua_setfield(L, -2, "daft");
    lua_pop(L, 1);
    lua_setglobal(L, "daft");
}

/* ---- handles ---- */

api_handle *api_new_handle(lua_State *L, api_type type, uint32_t id)
{
    api_handle *handle = lua_newuserdatauv(L, sizeof *handle, type == API_ENTITY ? 1 : 0);
    *handle = (api_handle){.id = id, .visible = true};
    api_set_type(L, type);
    return handle;
}

void api_set_type(lua_State *L, api_type type)
{
    ((api_handle *)lua_touserdata(L, -1))->type = (uint16_t)type;
    lua_rawgetp(L, LUA_REGISTRYINDEX, &TYPE_KEYS[type]);
    lua_setmetatable(L, -2);
}

bool api_push_methods(lua_State *L, api_type type)
{
    lua_rawgetp(L, LUA_REGISTRYINDEX, &TYPE_KEYS[type]);
    lua_getfield(L, -1, "__index");
    if (!lua_getupvalue(L, -1, 1)) return false;
    lua_replace(L, -3);
    lua_pop(L, 1);
    return true;
}

api_handle *api_test_handle(lua_State *L, int index, api_type type)
{
    api_handle *handle = lua_type(L, index) == LUA_TUSERDATA ? lua_touserdata(L, index) : NULL;
    return handle && handle->type == (uint16_t)type ? handle : NULL;
}

api_handle *api_check_handle(lua_State *L, host *h, int index, api_type type, const char *what)
{
    api_handle *handle = api_test_handle(L, index, type);
    if (!handle) api_wrong(L, h, index, what, TYPES[type]);
    return handle;
}

/* Userdata whose entity is gone are let go of once there are twice as many as entities. */
static void sweep_entities(lua_State *L, host *h, int table)
{
    lua_Integer held = 0;
    lua_getfield(L, table, "held");
    held = lua_tointeger(L, -1) + 1;
    lua_pop(L, 1);
    if (held > 256 + 2 * (lua_Integer)daft_entity_count(h->def.scene)) {
        held = 1;
        for (lua_pushnil(L); lua_next(L, table); lua_pop(L, 1)) {
            if (!lua_isinteger(L, -2)) continue;
            if (daft_entity_is_valid(h->def.scene, (daft_entity){(uint32_t)lua_tointeger(L, -2)})) {
                held++;
                continue;
            }
            lua_pushvalue(L, -2);
            lua_pushnil(L);
            lua_rawset(L, table);
        }
    }
    lua_pushinteger(L, held);
    lua_setfield(L, table, "held");
}

bool api_push_known_entity(lua_State *L, uint32_t id)
{
    lua_rawgetp(L, LUA_REGISTRYINDEX, &ENTITIES_KEY);
    const bool known = lua_rawgeti(L, -1, (lua_Integer)id) == LUA_TUSERDATA;
    lua_remove(L, -2);
    if (!known) lua_pop(L, 1);
    return known;
}

void api_push_entity(lua_State *L, uint32_t id)
{
    if (id == 0) {
        lua_pushnil(L);
        return;
    }
    lua_rawgetp(L, LUA_REGISTRYINDEX, &ENTITIES_KEY);
    if (lua_rawgeti(L, -1, (lua_Integer)id) == LUA_TNIL) {
        lua_pop(L, 1);
        sweep_entities(L, api_host(L), lua_gettop(L));
        api_new_handle(L, API_ENTITY, id);
        lua_newtable(L);
        lua_setiuservalue(L, -2, 1);
        lua_pushvalue(L, -1);
        lua_rawseti(L, -3, (lua_Integer)id);
    }
    lua_remove(L, -2);
}
