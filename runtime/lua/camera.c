/* daft.camera. */
#include "lua/api.h"

#include "common/util.h"

#include <math.h>

static const char *const LOOK_FIELDS[] = {"from", "at", "fov", "teleport"};
static const char *const SET_FIELDS[] = {"position", "yaw", "pitch", "roll", "fov", "teleport"};

static float read_fov(lua_State *L, host *h)
{
    float fov = api_float(L, h, -1, "fov");
    if (!(fov > 0) || !(fov < 3.14159f)) api_wrong(L, h, -1, "fov", "angle between 0 and pi, in radians");
    return fov;
}

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
    if (api_field(L, 1, "fov")) fov = read_fov(L, h);
    bool teleport = read_teleport(L, h);
    if (!api_field(L, 1, "at")) api_error(L, h, "at: {x, y, z} or an entity expected, got nil");
    daft_dvec3 at = api_place(L, h, -1, "at");
    if (at.x == from.x && at.y == from.y && at.z == from.z)
        api_error(L, h, "at: the camera cannot look at the place where it is");
    daft_camera camera = daft_camera_look_at(from, at, fov);
    return put(L, h, &camera, teleport);
}

static float read_angle(lua_State *L, host *h, const char *name, float otherwise)
{
    return api_field(L, 1, name) ? api_float(L, h, -1, name) : otherwise;
}

static int set(lua_State *L, host *h)
{
    api_fields(L, h, 1, NULL, SET_FIELDS, COUNT_OF(SET_FIELDS));
    daft_camera camera = daft_scene_camera(h->def.scene, 1);
    if (api_field(L, 1, "position")) camera.position = api_place(L, h, -1, "position");
    camera.yaw = read_angle(L, h, "yaw", camera.yaw);
    camera.pitch = read_angle(L, h, "pitch", camera.pitch);
    camera.roll = read_angle(L, h, "roll", camera.roll);
    if (api_field(L, 1, "fov")) camera.fov = read_fov(L, h);
    return put(L, h, &camera, read_teleport(L, h));
}

static int get(lua_State *L, host *h)
{
    daft_camera camera = daft_scene_camera(h->def.scene, 1);
    lua_createtable(L, 0, 5);
    api_push_vec3(L, camera.position.x, camera.position.y, camera.position.z);
    lua_setfield(L, -2, "position");
    const struct {
        const char *name;
        float value;
    } angles[] = {{"yaw", camera.yaw}, {"pitch", camera.pitch}, {"roll", camera.roll}, {"fov", camera.fov}};
    for (size_t i = 0; i < COUNT_OF(angles); i++) {
        lua_pushnumber(L, (double)angles[i].value);
        lua_setfield(L, -2, angles[i].name);
    }
    return 1;
}

static const api_function FUNCTIONS[] = {
    {"camera.look", "{from =, at =, fov =, teleport =}",
     "From a place to a place; either may be an entity: where it is now. fov is horizontal, in radians.\n"
     "teleport = true jumps there without a glide.",
     look, API_CHANGES},
    {"camera.set", "{position =, yaw =, pitch =, roll =, fov =, teleport =}",
     "What is not named stays. Yaw 0 looks along +X, positive yaw turns right, positive pitch looks down.", set,
     API_CHANGES},
    {"camera.get", "() -> {position =, yaw =, pitch =, roll =, fov =}", "Where the camera is.", get, 0},
};

const api_area api_camera = {"Camera", FUNCTIONS, COUNT_OF(FUNCTIONS)};
