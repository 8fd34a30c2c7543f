/* daft.camera. */
#include "lua/fields.h"

#include "common/util.h"

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

static const api_function FUNCTIONS[] = {
    {"camera.look", "{from =, at =, fov =, teleport =}",
     "From a place to a place; either may be an entity: where it is now. fov is horizontal, in radians.\n"
     "teleport = true jumps there without a glide.",
     look, API_CHANGES},
    {"camera.set", "{...}", "What is not named stays.", set, API_CHANGES},
    {"camera.get", "() -> {...}", "The same fields but teleport.", get, 0},
};

const api_area api_camera = {"Camera", FUNCTIONS, COUNT_OF(FUNCTIONS)};
