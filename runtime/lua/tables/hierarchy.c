/* Entities in the world, and on each other: axes, look_at, parents and children. */
#include "lua/api.h"

#include "common/util.h"

static daft_transform get_world(lua_State *L, host *h)
{
    daft_transform transform;
    daft_error error;
    if (!daft_entity_get_world_transform(h->def.scene, api_entity_at(L, h, 1, "entity"), &transform, &error))
        api_engine_error(L, h, &error);
    return transform;
}

static int set_world(lua_State *L, host *h, const daft_transform *transform)
{
    daft_error error;
    if (!daft_entity_set_world_transform(h->def.scene, api_entity_at(L, h, 1, "entity"), transform, false, &error))
        api_engine_error(L, h, &error);
    return 0;
}

static int world_position(lua_State *L, host *h)
{
    daft_transform transform = get_world(L, h);
    if (lua_gettop(L) < 2) return api_push_numbers(L, transform.position.x, transform.position.y, transform.position.z);
    api_check_may_change(L, h);
    transform.position = api_place(L, h, 2, "position");
    return set_world(L, h, &transform);
}

/* ---- axes ---- */

/* A column of the rotation's matrix: 0 forward, +X; 1 up, +Y; 2 right, +Z. */
static int push_axis(lua_State *L, host *h, int axis)
{
    const daft_quat q = get_world(L, h).rotation;
    const double x = (double)q.x, y = (double)q.y, z = (double)q.z, w = (double)q.w;
    if (axis == 0) return api_push_numbers(L, 1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w));
    if (axis == 1) return api_push_numbers(L, 2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w));
    return api_push_numbers(L, 2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y));
}

static int forward(lua_State *L, host *h) { return push_axis(L, h, 0); }
static int up(lua_State *L, host *h) { return push_axis(L, h, 1); }
static int right(lua_State *L, host *h) { return push_axis(L, h, 2); }

static int look_at(lua_State *L, host *h)
{
    daft_transform transform = get_world(L, h);
    const daft_dvec3 at = api_place(L, h, 2, "place"), from = transform.position;
    if (at.x == from.x && at.y == from.y && at.z == from.z)
        api_error(L, h, "place: it cannot look at the place where it is");
    const daft_camera look = daft_camera_look_at(from, at, 1);
    transform.rotation = api_quat_from_angles((double)look.yaw, (double)look.pitch, 0);
    return set_world(L, h, &transform);
}

/* ---- parents and children ---- */

static int parent(lua_State *L, host *h)
{
    const daft_entity self = api_entity_at(L, h, 1, "entity");
    daft_error error;
    get_world(L, h); /* refuses an entity that is gone */
    if (lua_gettop(L) < 2) {
        api_push_entity(L, daft_entity_get_parent(h->def.scene, self).id);
        return 1;
    }
    api_check_may_change(L, h);
    const daft_entity to = lua_isnil(L, 2) ? (daft_entity){0} : api_entity_at(L, h, 2, "parent");
    if (!daft_entity_set_parent(h->def.scene, self, to, &error)) api_engine_error(L, h, &error);
    return 0;
}

static int children(lua_State *L, host *h)
{
    const daft_entity self = api_entity_at(L, h, 1, "entity");
    get_world(L, h);
    uint32_t count = daft_entity_children(h->def.scene, self, NULL, 0);
    daft_entity *all = lua_newuserdatauv(L, (count + 1) * sizeof *all, 0);
    count = daft_entity_children(h->def.scene, self, all, count);
    lua_createtable(L, (int)count, 0);
    for (uint32_t i = 0; i < count; i++) {
        api_push_entity(L, all[i].id);
        lua_rawseti(L, -2, (lua_Integer)i + 1);
    }
    return 1;
}

static const api_function FUNCTIONS[] = {
    {"entity:world_position", "([x, y, z]) -> x, y, z",
     "Where it is in the world, or puts it there; position is relative to its parent.", world_position, 0},
    {"entity:forward", "() -> x, y, z", "The direction of its +X axis in the world: where it looks.", forward, 0},
    {"entity:up", "() -> x, y, z", "The direction of its +Y axis in the world.", up, 0},
    {"entity:right", "() -> x, y, z", "The direction of its +Z axis in the world.", right, 0},
    {"entity:look_at", "(place)", "Turns it, level, so that its +X axis points at a place or an entity.", look_at,
     API_CHANGES},
    {"entity:parent", "([entity or nil]) -> entity or nil",
     "What it hangs on, or hangs it there; nil: on the world. It stays where and as it is.", parent, 0},
    {"entity:children", "() -> list", "What hangs on it, in the order in which that came.", children, 0},
};

const api_area api_hierarchy = {"Entities in the world", FUNCTIONS, COUNT_OF(FUNCTIONS)};
