/* Entities that play the clips of their mesh. */
#include "lua/tables/animation.h"

#include "lua/fields.h"

#include "common/util.h"

const api_form api_play_form = {"entity:play", "entity:play", DAFT_STRUCT_PLAY_DEF, -1, NULL, 0};

static daft_mesh mesh_of(lua_State *L, host *h, daft_entity entity)
{
    daft_mesh mesh;
    daft_error error;
    if (!daft_entity_get_mesh(h->def.scene, entity, &mesh, &error)) api_engine_error(L, h, &error);
    return mesh;
}

/* A name, or a number counted from 1. */
static uint32_t clip_at(lua_State *L, host *h, int index, daft_mesh mesh)
{
    uint32_t clip;
    daft_error error;
    daft_mesh_info info;
    if (!daft_mesh_get_info(h->def.scene, mesh, &info, &error)) api_engine_error(L, h, &error);
    if (lua_type(L, index) == LUA_TNUMBER) {
        const lua_Integer number = api_whole(L, h, index, "clip");
        if (number < 1 || number > (lua_Integer)info.clip_count)
            api_error(L, h, "clip: %lld, but the mesh has %u clips", (long long)number, info.clip_count);
        return (uint32_t)number - 1;
    }
    if (lua_type(L, index) != LUA_TSTRING) api_wrong(L, h, index, "clip", "name or number");
    if (!daft_mesh_find_clip(h->def.scene, mesh, api_text(L, h, index, "clip"), &clip, &error))
        api_engine_error(L, h, &error);
    return clip;
}

daft_play_def api_read_play(lua_State *L, host *h, int index, daft_mesh mesh)
{
    daft_play_def def = daft_default_play_def();
    def.clip = clip_at(L, h, index, mesh);
    return def;
}

static int play(lua_State *L, host *h)
{
    const daft_entity entity = api_entity_at(L, h, 1, "entity");
    daft_play_def def = api_read_play(L, h, 2, mesh_of(L, h, entity));
    daft_error error;
    if (!lua_isnoneornil(L, 3)) api_read_struct(L, h, 3, "options", &api_play_form, &def);
    if (!daft_entity_play(h->def.scene, entity, &def, &error)) api_engine_error(L, h, &error);
    return 0;
}

static int stop(lua_State *L, host *h)
{
    daft_error error;
    if (!daft_entity_stop(h->def.scene, api_entity_at(L, h, 1, "entity"), &error)) api_engine_error(L, h, &error);
    return 0;
}

static daft_clip_info get_clip(lua_State *L, host *h, daft_mesh mesh, uint32_t clip)
{
    daft_clip_info info;
    daft_error error;
    if (!daft_mesh_get_clip(h->def.scene, mesh, clip, &info, &error)) api_engine_error(L, h, &error);
    return info;
}

static int clips(lua_State *L, host *h)
{
    const daft_mesh mesh = mesh_of(L, h, api_entity_at(L, h, 1, "entity"));
    daft_mesh_info info;
    daft_error error;
    if (!daft_mesh_get_info(h->def.scene, mesh, &info, &error)) api_engine_error(L, h, &error);
    lua_newtable(L);
    for (uint32_t i = 0; i < info.clip_count; i++) {
        const daft_clip_info clip = get_clip(L, h, mesh, i);
        api_poll(L, i);
        lua_createtable(L, 0, 2);
        lua_pushstring(L, clip.name);
        lua_setfield(L, -2, "name");
        lua_pushnumber(L, clip.duration);
        lua_setfield(L, -2, "duration");
        lua_rawseti(L, -2, (lua_Integer)i + 1);
    }
    return 1;
}

static void set_number(lua_State *L, const char *name, double value)
{
    lua_pushnumber(L, value);
    lua_setfield(L, -2, name);
}

static void set_boolean(lua_State *L, const char *name, bool value)
{
    lua_pushboolean(L, value);
    lua_setfield(L, -2, name);
}

static int animation(lua_State *L, host *h)
{
    const daft_entity entity = api_entity_at(L, h, 1, "entity");
    daft_animation now;
    daft_error error;
    if (!daft_entity_get_animation(h->def.scene, entity, &now, &error)) {
        if (error.code != DAFT_OK) api_engine_error(L, h, &error);
        lua_pushnil(L);
        return 1;
    }
    const daft_clip_info clip = get_clip(L, h, mesh_of(L, h, entity), now.clip);
    lua_createtable(L, 0, 7);
    lua_pushstring(L, clip.name);
    lua_setfield(L, -2, "clip");
    set_number(L, "time", now.time), set_number(L, "duration", clip.duration);
    set_number(L, "speed", (double)now.speed), set_number(L, "weight", (double)now.weight);
    set_boolean(L, "loop", now.loop), set_boolean(L, "playing", now.playing);
    return 1;
}

static int animation_time(lua_State *L, host *h)
{
    daft_error error;
    if (!daft_entity_set_animation_time(h->def.scene, api_entity_at(L, h, 1, "entity"), api_number(L, h, 2, "seconds"),
                                        &error))
        api_engine_error(L, h, &error);
    return 0;
}

static const api_function FUNCTIONS[] = {
    {"entity:play", "(clip, [{speed =, blend =, start =, loop =, restart =}])",
     "Plays a clip of its mesh, by name or number. One that plays already goes on; from another the pose passes\n"
     "over in `blend` seconds.",
     play, API_CHANGES},
    {"entity:stop", "()", "Back to the pose of the file.", stop, API_CHANGES},
    {"entity:clips", "() -> list", "The clips of its mesh: a list of {name = text, duration = seconds}.", clips, 0},
    {"entity:animation", "() -> table",
     "What it plays: {clip = name, time =, duration =, speed =, weight =, loop =, playing =}, or nil. weight is below\n"
     "1 while the pose passes over into it; playing is false once a clip that is not looped has ended.",
     animation, 0},
    {"entity:animation_time", "(seconds)", "Puts the clip that it plays at this time.", animation_time, API_CHANGES},
};

const api_area api_animation = {"Animation", FUNCTIONS, COUNT_OF(FUNCTIONS)};
