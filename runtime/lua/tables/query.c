/* daft.query: what rays, moving shapes, volumes and points meet among the bodies. */
#include "lua/tables/body.h"
#include "lua/fields.h"

#include "common/util.h"

#include <float.h>

enum { MOST = 256 }; /* hits in a list */

static const char *const SHAPES[] = {"sphere", "box", "capsule", "rotation"};

static void read_layer(lua_State *L, host *h, int table, void *out)
{
    (void)table;
    ((daft_query_filter *)out)->layers = api_layers(L, h, -1, "layer");
}

static void read_hits(lua_State *L, host *h, int table, void *out)
{
    (void)table;
    ((daft_query_filter *)out)->mask = api_layers(L, h, -1, "hits");
}

static const api_special SPECIALS[] = {{.name = "layer", .read = read_layer, .value = "name or names"},
                                       {.name = "hits", .read = read_hits, .value = "name or names"}};

const api_form api_filter_form = {"query.ray", "daft.query's options", DAFT_STRUCT_QUERY_FILTER, -1,
                                  SPECIALS,    COUNT_OF(SPECIALS)};

/* The table of options at index, or none. */
static daft_query_filter read_filter(lua_State *L, host *h, int index)
{
    daft_query_filter f = daft_default_query_filter();
    if (!lua_isnoneornil(L, index)) api_read_struct(L, h, index, "options", &api_filter_form, &f);
    return f;
}

static daft_volume read_volume(lua_State *L, host *h, int index)
{
    daft_volume v = daft_default_volume();
    int shapes = 0;
    api_fields(L, h, index, "shape", SHAPES, COUNT_OF(SHAPES));
    if (api_field(L, index, "sphere")) {
        v.radius = api_float(L, h, -1, "sphere"), shapes++;
        if (!(v.radius > 0)) api_wrong(L, h, -1, "sphere", "radius above 0");
    }
    if (api_field(L, index, "box")) v.size = api_vec3(L, h, -1, "box"), shapes++;
    if (api_field(L, index, "capsule")) {
        api_capsule(L, h, -1, &v.radius, &v.height);
        shapes++;
    }
    if (api_field(L, index, "rotation")) v.rotation = api_rotation(L, h, -1, "rotation");
    if (shapes != 1) api_error(L, h, "shape: one of sphere, box and capsule expected, got %d of them", shapes);
    return v;
}

static float read_distance(lua_State *L, host *h, int index)
{
    if (lua_isnoneornil(L, index)) return FLT_MAX;
    float distance = api_float(L, h, index, "max_distance");
    if (!(distance >= 0)) api_wrong(L, h, index, "max_distance", "number of 0 or more");
    return distance;
}

/* Sets the fields of the table on top. */
static void put_hit(lua_State *L, const daft_query_hit *hit)
{
    api_push_entity(L, hit->entity.id);
    lua_setfield(L, -2, "entity");
    lua_pushnumber(L, (double)hit->distance);
    lua_setfield(L, -2, "distance");
    api_set_vec3(L, "position", hit->position.x, hit->position.y, hit->position.z);
    api_set_vec3(L, "normal", (double)hit->normal.x, (double)hit->normal.y, (double)hit->normal.z);
    lua_pushboolean(L, hit->inside);
    lua_setfield(L, -2, "inside");
}

/* `into`: the place of a table for it, or of nil. */
static int answer(lua_State *L, host *h, bool found, const daft_query_hit *hit, int into, const daft_error *error)
{
    if (!found && error->code != DAFT_OK) api_engine_error(L, h, error);
    if (!found) {
        lua_pushnil(L);
        return 1;
    }
    api_push_out(L, h, into, "hit");
    put_hit(L, hit);
    return 1;
}

static int ray(lua_State *L, host *h)
{
    lua_settop(L, 5); /* fields of tables are pushed beyond */
    daft_dvec3 from = api_place(L, h, 1, "from");
    daft_vec3 direction = api_vec3(L, h, 2, "direction");
    float far_limit = read_distance(L, h, 3);
    daft_query_filter filter = read_filter(L, h, 4);
    daft_query_hit hit;
    daft_error error;
    bool found = daft_query_ray(h->def.scene, from, direction, far_limit, &filter, &hit, &error);
    return answer(L, h, found, &hit, 5, &error);
}

static int rays(lua_State *L, host *h)
{
    lua_settop(L, 5); /* fields of tables are pushed beyond */
    daft_dvec3 from = api_place(L, h, 1, "from");
    daft_vec3 direction = api_vec3(L, h, 2, "direction");
    float far_limit = read_distance(L, h, 3);
    daft_query_filter filter = read_filter(L, h, 4);
    daft_query_hit hits[MOST];
    daft_error error;
    uint32_t count = daft_query_ray_all(h->def.scene, from, direction, far_limit, &filter, hits, MOST, &error);
    if (error.code != DAFT_OK) api_engine_error(L, h, &error);
    if (count > MOST) count = MOST;
    api_push_out(L, h, 5, "list");
    for (uint32_t i = 0; i < count; i++) {
        api_push_item(L, (lua_Integer)i + 1);
        put_hit(L, &hits[i]);
        lua_pop(L, 1);
    }
    api_end_list(L, (lua_Integer)count);
    return 1;
}

static int cast(lua_State *L, host *h)
{
    lua_settop(L, 6); /* fields of tables are pushed beyond */
    daft_volume volume = read_volume(L, h, 1);
    daft_dvec3 from = api_place(L, h, 2, "from");
    daft_vec3 direction = api_vec3(L, h, 3, "direction");
    float far_limit = read_distance(L, h, 4);
    daft_query_filter filter = read_filter(L, h, 5);
    daft_query_hit hit;
    daft_error error;
    bool found = daft_query_cast(h->def.scene, &volume, from, direction, far_limit, &filter, &hit, &error);
    return answer(L, h, found, &hit, 6, &error);
}

static int overlap(lua_State *L, host *h)
{
    lua_settop(L, 4); /* fields of tables are pushed beyond */
    daft_volume volume = read_volume(L, h, 1);
    daft_dvec3 at = api_place(L, h, 2, "at");
    daft_query_filter filter = read_filter(L, h, 3);
    daft_query_hit hits[MOST];
    daft_error error;
    uint32_t count = daft_query_overlap(h->def.scene, &volume, at, &filter, hits, MOST, &error);
    if (error.code != DAFT_OK) api_engine_error(L, h, &error);
    if (count > MOST) count = MOST;
    api_push_out(L, h, 4, "list");
    for (uint32_t i = 0; i < count; i++) {
        api_push_entity(L, hits[i].entity.id);
        lua_rawseti(L, -2, (lua_Integer)i + 1);
    }
    api_end_list(L, (lua_Integer)count);
    return 1;
}

static int closest(lua_State *L, host *h)
{
    lua_settop(L, 4); /* fields of tables are pushed beyond */
    daft_dvec3 from = api_place(L, h, 1, "from");
    float far_limit = read_distance(L, h, 2);
    daft_query_filter filter = read_filter(L, h, 3);
    daft_query_hit hit;
    daft_error error;
    bool found = daft_query_closest(h->def.scene, from, far_limit, &filter, &hit, &error);
    return answer(L, h, found, &hit, 4, &error);
}

static const api_function FUNCTIONS[] = {
    {"query.ray", "(from, direction [, max_distance [, options [, hit]]]) -> hit or nil",
     "The nearest body along a ray: {entity =, distance =, position =, normal =, inside =}. hit, list: tables to fill.",
     ray, 0},
    {"query.all", "(from, direction [, max_distance [, options [, list]]]) -> hits",
     "All bodies along a ray, nearest first, up to 256.", rays, 0},
    {"query.cast", "(shape, from, direction [, max_distance [, options [, hit]]]) -> hit or nil",
     "The same for a shape that moves: {sphere = radius}, {box = {x, y, z}} or {capsule = {radius, height}},\n"
     "and rotation.",
     cast, 0},
    {"query.overlap", "(shape, at [, options [, list]]) -> entities", "The bodies that a shape overlaps, up to 256.",
     overlap, 0},
    {"query.closest", "(from [, max_distance [, options [, hit]]]) -> hit or nil", "The nearest point of any body.",
     closest, 0},
};

const api_area api_query = {"Queries of bodies", FUNCTIONS, COUNT_OF(FUNCTIONS)};
