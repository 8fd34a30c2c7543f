/* daft.camera, and camera paths. */
#include "lua/fields.h"

#include "common/util.h"

#include <stdio.h>

static const char *const LOOK_FIELDS[] = {"from", "at", "fov", "teleport"};
static const api_special SET_SPECIALS[] = {
    {.name = "teleport", .value = "true or false", .doc = "Whether it jumps there without a glide"}};

const api_form api_camera_form = {"camera.set", "daft.camera.set", DAFT_STRUCT_CAMERA,
                                  -1,           SET_SPECIALS,      COUNT_OF(SET_SPECIALS)};

static bool read_teleport(lua_State *L, host *h)
{
    return api_field(L, 1, "teleport") && api_boolean(L, h, -1, "teleport");
}

static int put(lua_State *L, host *h, const daft_camera *camera, bool teleport)
{
    daft_error error;
    if (!daft_scene_set_camera(h->def.scene, camera, teleport, &error)) api_engine_error(L, h, &error);
    return 0;
}

static int look(lua_State *L, host *h)
{
    api_fields(L, h, 1, NULL, LOOK_FIELDS, COUNT_OF(LOOK_FIELDS));
    daft_camera now = daft_scene_camera(h->def.scene, 1);
    daft_dvec3 from = now.position;
    float fov = now.fov;
    if (api_field(L, 1, "from")) from = api_place(L, h, -1, "from");
    if (api_field(L, 1, "fov")) fov = api_float(L, h, -1, "fov");
    bool teleport = read_teleport(L, h);
    if (!api_field(L, 1, "at")) api_error(L, h, "at: {x, y, z} or an entity expected, got nil");
    daft_dvec3 at = api_place(L, h, -1, "at");
    if (at.x == from.x && at.y == from.y && at.z == from.z)
        api_error(L, h, "at: the camera cannot look at the place where it is");
    daft_camera camera = daft_camera_look_at(from, at, fov);
    return put(L, h, &camera, teleport);
}

static int set(lua_State *L, host *h)
{
    daft_camera camera = daft_scene_camera(h->def.scene, 1);
    api_read_struct(L, h, 1, NULL, &api_camera_form, &camera);
    return put(L, h, &camera, read_teleport(L, h));
}

static int get(lua_State *L, host *h)
{
    daft_camera camera = daft_scene_camera(h->def.scene, 1);
    api_push_struct(L, DAFT_STRUCT_CAMERA, &camera);
    return 1;
}

/* ---- paths ---- */

static const api_special POINT_SPECIALS[] = {{.name = "time", .value = "number, s", .doc = "When; in ascending order"}};

const api_form api_checkpoint_form = {"camera.along", "a checkpoint",          DAFT_STRUCT_CAMERA, -1,
                                      POINT_SPECIALS, COUNT_OF(POINT_SPECIALS)};

enum { MOST_POINTS = 10000 };

/* The list at 1 as checkpoints, in a userdata that stays on the stack. */
static daft_checkpoint *read_points(lua_State *L, host *h, uint32_t *count)
{
    if (!lua_istable(L, 1)) api_wrong(L, h, 1, "points", "list of checkpoints");
    const size_t length = lua_rawlen(L, 1);
    if (length == 0 || length > MOST_POINTS)
        api_error(L, h, "points: 1 to %d checkpoints expected, got %zu", (int)MOST_POINTS, length);
    daft_checkpoint *points = lua_newuserdatauv(L, length * sizeof *points, 0);
    const int top = lua_gettop(L);
    for (size_t i = 0; i < length; i++) {
        char what[40];
        snprintf(what, sizeof what, "points[%zu]", i + 1);
        lua_rawgeti(L, 1, (lua_Integer)i + 1);
        points[i] = (daft_checkpoint){daft_default_camera(), (double)i};
        api_read_struct(L, h, top + 1, what, &api_checkpoint_form, &points[i].camera);
        if (api_field(L, top + 1, "time")) points[i].time = api_number(L, h, -1, "time");
        lua_settop(L, top);
        api_poll(L, i);
    }
    *count = (uint32_t)length;
    return points;
}

static int along(lua_State *L, host *h)
{
    static const char *const PACES[] = {
        [DAFT_PACE_TIMED] = "timed", [DAFT_PACE_CONSTANT] = "constant", [DAFT_PACE_EASED] = "eased"};
    lua_settop(L, 3);
    const double seconds = api_number(L, h, 2, "seconds");
    size_t pace = DAFT_PACE_TIMED;
    if (!lua_isnil(L, 3)) pace = api_choice(L, h, 3, "pace", PACES, COUNT_OF(PACES));
    uint32_t count;
    const daft_checkpoint *points = read_points(L, h, &count);
    daft_camera camera;
    daft_error error;
    if (!daft_path_camera(points, count, (daft_pace)pace, seconds, &camera, &error)) api_engine_error(L, h, &error);
    api_push_struct(L, DAFT_STRUCT_CAMERA, &camera);
    return 1;
}

static int checkpoints(lua_State *L, host *h)
{
    const uint32_t count = daft_scene_path_count(h->def.scene);
    lua_createtable(L, (int)count, 0);
    for (uint32_t i = 0; i < count; i++) {
        daft_checkpoint point;
        daft_error error;
        if (!daft_scene_get_checkpoint(h->def.scene, i, &point, &error)) api_engine_error(L, h, &error);
        api_push_struct(L, DAFT_STRUCT_CAMERA, &point.camera);
        lua_pushnumber(L, point.time);
        lua_setfield(L, -2, "time");
        lua_rawseti(L, -2, (lua_Integer)i + 1);
    }
    return 1;
}

/* A list, and the same by their names. */
static int cameras(lua_State *L, host *h)
{
    const daft_entity entity = api_entity_at(L, h, 1, "entity");
    daft_mesh mesh;
    daft_mesh_info info;
    daft_mesh_camera one;
    daft_transform at;
    daft_error error;
    if (!daft_entity_get_mesh(h->def.scene, entity, &mesh, &error) ||
        !daft_mesh_get_info(h->def.scene, mesh, &info, &error) ||
        !daft_entity_get_world_transform(h->def.scene, entity, &at, &error))
        api_engine_error(L, h, &error);
    lua_newtable(L);
    for (uint32_t i = 0; i < info.camera_count; i++) {
        api_poll(L, i);
        if (!daft_mesh_get_camera(h->def.scene, mesh, i, &at, &one, &error)) api_engine_error(L, h, &error);
        api_push_struct(L, DAFT_STRUCT_CAMERA, &one.camera);
        lua_pushvalue(L, -1);
        lua_setfield(L, -3, one.name);
        lua_rawseti(L, -2, (lua_Integer)i + 1);
    }
    return 1;
}

static const api_function FUNCTIONS[] = {
    {"camera.look", "{from =, at =, fov =, teleport =}",
     "From a place to a place; either may be an entity: where it is now. fov is horizontal, in radians.\n"
     "teleport = true jumps there without a glide.",
     look, API_CHANGES},
    {"camera.set", "{...}", "What is not named stays.", set, API_CHANGES},
    {"camera.get", "() -> {...}", "The same fields but teleport.", get, 0},
    {"camera.along", "(points, seconds [, pace]) -> {...}",
     "Where the camera is, as of daft.camera.get, so many seconds into a smooth path through a list of checkpoints.\n"
     "pace: \"timed\", \"constant\" or \"eased\".",
     along, 0},
    {"entity:cameras", "() -> table",
     "The cameras that its mesh's file has, where it stands now, for daft.camera.set: by their numbers and names.",
     cameras, 0},
    {"camera.checkpoints", "() -> list", "The checkpoints of the `path` items of scene files.", checkpoints, 0},
};

const api_area api_camera = {"Camera", FUNCTIONS, COUNT_OF(FUNCTIONS)};
