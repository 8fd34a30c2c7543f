/* What makes an entity a body: the fields of daft.entity that say so, and the methods of bodies. */
#include "lua/tables/body.h"

#include "common/util.h"

#include <math.h>

/* Registry keys: tables from names to numbers, in the order in which a game first says them. */
static const char LAYERS_KEY, SURFACES_KEY;

enum { LAYERS = 32, SURFACES = 64, MAX_COLLIDERS = 4096 };

/* ---- names ---- */

/* The number of a name, from `first` on; new names get the next one. */
static uint32_t name_number(lua_State *L, host *h, int index, const char *what, const void *key, uint32_t first,
                            uint32_t limit)
{
    const char *name = api_text(L, h, index, what);
    if (lua_rawgetp(L, LUA_REGISTRYINDEX, key) != LUA_TTABLE) {
        lua_pop(L, 1);
        lua_newtable(L);
        lua_pushvalue(L, -1);
        lua_rawsetp(L, LUA_REGISTRYINDEX, key);
    }
    if (lua_getfield(L, -1, name) == LUA_TNIL) {
        lua_Integer number = (lua_Integer)first;
        for (lua_pushnil(L); lua_next(L, -3); lua_pop(L, 1)) number++;
        if (number >= (lua_Integer)limit)
            api_error(L, h, "%s: '%s' is one name too many: there can be %d", what, name, (int)(limit - first));
        lua_pushinteger(L, number);
        lua_setfield(L, -3, name);
        lua_pop(L, 1);
        lua_pushinteger(L, number);
    }
    uint32_t number = (uint32_t)lua_tointeger(L, -1);
    lua_pop(L, 2);
    return number;
}

uint32_t api_surface(lua_State *L, host *h, int index, const char *what)
{
    return name_number(L, h, index, what, &SURFACES_KEY, 1, SURFACES);
}

/* A name, or a list of them. The first bit is what has no layer of its own. */
uint32_t api_layers(lua_State *L, host *h, int index, const char *what)
{
    index = lua_absindex(L, index);
    if (lua_type(L, index) == LUA_TSTRING) return 1u << name_number(L, h, index, what, &LAYERS_KEY, 1, LAYERS);
    if (lua_type(L, index) != LUA_TTABLE) api_wrong(L, h, index, what, "name or list of names");
    uint32_t bits = 0;
    for (lua_Integer i = 1, count = (lua_Integer)lua_rawlen(L, index); i <= count; i++) {
        lua_rawgeti(L, index, i);
        api_poll(L, (uint64_t)i);
        bits |= 1u << name_number(L, h, -1, what, &LAYERS_KEY, 1, LAYERS);
        lua_pop(L, 1);
    }
    return bits;
}

/* ---- colliders ---- */

static float above_zero(lua_State *L, host *h, int index, const char *what)
{
    float value = api_float(L, h, index, what);
    if (!(value > 0)) api_wrong(L, h, index, what, "number above 0");
    return value;
}

static void read_round(lua_State *L, host *h, int index, const char *what, float *radius, float *height)
{
    static const char *const NAMES[] = {"radius", "height"};
    float *numbers[] = {radius, height};
    int table = lua_absindex(L, index);
    bool list = lua_type(L, table) == LUA_TTABLE && lua_rawlen(L, table) == 2;
    if (!list) api_fields(L, h, table, what, NAMES, COUNT_OF(NAMES));
    for (int i = 0; i < 2; i++) {
        if (list)
            lua_rawgeti(L, table, i + 1);
        else if (!api_field(L, table, NAMES[i]))
            continue;
        char name[32];
        snprintf(name, sizeof name, "%s's %s", what, NAMES[i]);
        *numbers[i] = above_zero(L, h, -1, name);
        lua_pop(L, 1);
    }
}

void api_capsule(lua_State *L, host *h, int index, float *radius, float *height)
{
    read_round(L, h, index, "capsule", radius, height);
}

/* The heights stay on the stack until the entity is made. */
static void read_heights(lua_State *L, host *h, int table, int index, daft_collider *out)
{
    index = lua_absindex(L, index);
    if (lua_type(L, index) != LUA_TTABLE) api_wrong(L, h, index, "heights", "list of numbers");
    size_t count = lua_rawlen(L, index);
    if (!api_field(L, table, "columns")) api_error(L, h, "columns: how many heights are in a row?");
    lua_Integer columns = api_whole(L, h, -1, "columns");
    if (columns < 2 || (size_t)columns > count || count % (size_t)columns != 0)
        api_error(L, h, "columns: %d heights do not make rows of %lld", (int)count, (long long)columns);
    float *heights = lua_newuserdatauv(L, count * sizeof *heights, 0);
    for (size_t i = 0; i < count; i++) {
        lua_rawgeti(L, index, (lua_Integer)i + 1);
        heights[i] = lua_isboolean(L, -1) && !lua_toboolean(L, -1) ? (float)NAN : api_float(L, h, -1, "heights");
        lua_pop(L, 1);
    }
    out->kind = DAFT_COLLIDER_FIELD;
    out->heights = heights;
    out->columns = (uint32_t)columns, out->rows = (uint32_t)(count / (size_t)columns);
    if (!api_field(L, table, "spacing")) return;
    if (lua_type(L, -1) == LUA_TNUMBER) {
        out->spacing.x = out->spacing.y = above_zero(L, h, -1, "spacing");
        return;
    }
    daft_vec3 spacing = api_vec3(L, h, -1, "spacing");
    out->spacing = (daft_vec2){spacing.x, spacing.z};
}

static void collide_sphere(lua_State *L, host *h, int table, void *out)
{
    (void)table;
    daft_collider *c = out;
    c->kind = DAFT_COLLIDER_SPHERE, c->radius = above_zero(L, h, -1, "sphere");
}

static void collide_box(lua_State *L, host *h, int table, void *out)
{
    (void)table;
    daft_collider *c = out;
    c->kind = DAFT_COLLIDER_BOX, c->size = api_vec3(L, h, -1, "box");
}

static void collide_capsule(lua_State *L, host *h, int table, void *out)
{
    (void)table;
    daft_collider *c = out;
    c->kind = DAFT_COLLIDER_CAPSULE;
    api_capsule(L, h, -1, &c->radius, &c->height);
    if (!(c->height > 2 * c->radius)) api_error(L, h, "capsule: its height must be more than twice its radius");
}

static void collide_cylinder(lua_State *L, host *h, int table, void *out)
{
    (void)table;
    daft_collider *c = out;
    c->kind = DAFT_COLLIDER_CYLINDER;
    read_round(L, h, -1, "cylinder", &c->radius, &c->height);
}

static void collide_hull(lua_State *L, host *h, int table, void *out)
{
    (void)table;
    daft_collider *c = out;
    c->kind = DAFT_COLLIDER_HULL, c->mesh = api_mesh_at(L, h, -1, "hull");
}

static void collide_mesh(lua_State *L, host *h, int table, void *out)
{
    (void)table;
    daft_collider *c = out;
    c->kind = DAFT_COLLIDER_MESH, c->mesh = api_mesh_at(L, h, -1, "mesh");
}

static void collide_heights(lua_State *L, host *h, int table, void *out) { read_heights(L, h, table, -1, out); }

enum { COLLIDER_SHAPES = 7 }; /* the first of these; one must be there */
static const api_special COLLIDER_SPECIALS[] = {
    {.name = "sphere", .read = collide_sphere, .value = "number, m", .doc = "A sphere's radius"},
    {.name = "box", .read = collide_box, .value = "{x, y, z}, m", .doc = "A box's edge lengths"},
    {.name = "capsule",
     .read = collide_capsule,
     .value = "{radius =, height =}",
     .doc = "Upright, height from end to end"},
    {.name = "cylinder",
     .read = collide_cylinder,
     .value = "{radius =, height =}",
     .doc = "Upright; rays and casts meet a prism of 32 sides within it"},
    {.name = "hull",
     .read = collide_hull,
     .value = "mesh or \"file.obj\"",
     .doc = "The convex hull of a mesh, of at most 64 corners"},
    {.name = "mesh",
     .read = collide_mesh,
     .value = "mesh or \"file.obj\"",
     .doc = "Its triangles, from both sides; static and kinematic bodies"},
    {.name = "heights",
     .read = collide_heights,
     .value = "list of numbers",
     .doc = "A grid of heights, row by row; false makes a hole; static and kinematic bodies"},
    {.name = "columns", .value = "whole number", .doc = "Heights in a row"},
    {.name = "spacing", .value = "number or {x, 0, z}, m", .doc = "Between columns and rows; 1 unless given"}};

const api_form api_collider_form = {"entity", "collider",        DAFT_STRUCT_COLLIDER,
                                    -1,       COLLIDER_SPECIALS, COUNT_OF(COLLIDER_SPECIALS)};

/* A name for what is drawn, or a table. Values that the collider points to stay on the stack. */
static void read_collider(lua_State *L, host *h, int index, daft_collider *out)
{
    static const char *const NAMES[] = {"hull", "mesh"};
    index = lua_absindex(L, index);
    *out = daft_default_collider();
    if (lua_type(L, index) == LUA_TSTRING) {
        size_t choice = api_choice(L, h, index, "collider", NAMES, COUNT_OF(NAMES));
        out->kind = choice == 0 ? DAFT_COLLIDER_HULL : DAFT_COLLIDER_MESH;
        return;
    }
    api_read_struct(L, h, index, "collider", &api_collider_form, out);
    int kinds = 0;
    for (size_t i = 0; i < COLLIDER_SHAPES; i++) kinds += api_has_field(L, index, COLLIDER_SPECIALS[i].name);
    if (kinds != 1) api_error(L, h, "collider: one of sphere, box, capsule, cylinder, hull, mesh and heights expected");
}

void api_read_colliders(lua_State *L, host *h, int whole, void *out)
{
    (void)whole;
    daft_entity_def *def = out;
    int table = lua_absindex(L, -1);
    size_t count = lua_type(L, table) == LUA_TTABLE ? lua_rawlen(L, table) : 0;
    if (count > MAX_COLLIDERS) api_error(L, h, "collider: at most %d parts expected", MAX_COLLIDERS);
    daft_collider *colliders = lua_newuserdatauv(L, (count ? count : 1) * sizeof *colliders, 0);
    if (count == 0) read_collider(L, h, table, colliders);
    for (size_t i = 0; i < count; i++) {
        luaL_checkstack(L, 24, NULL);
        lua_rawgeti(L, table, (lua_Integer)i + 1);
        read_collider(L, h, -1, &colliders[i]);
    }
    def->colliders = colliders;
    def->collider_count = count ? (uint32_t)count : 1;
}

/* ---- fields of daft.entity ---- */

void api_read_surface(lua_State *L, host *h, int table, void *out)
{
    (void)table;
    ((daft_entity_def *)out)->surface = api_surface(L, h, -1, "surface");
}

void api_read_layer(lua_State *L, host *h, int table, void *out)
{
    (void)table;
    ((daft_entity_def *)out)->layers = api_layers(L, h, -1, "layer");
}

void api_read_hits(lua_State *L, host *h, int table, void *out)
{
    (void)table;
    ((daft_entity_def *)out)->mask = api_layers(L, h, -1, "hits");
}

/* "rotation", "position", or some of "x", "y", "z" and "position x", … */
void api_read_locks(lua_State *L, host *h, int whole, void *out)
{
    static const char *const AXES[] = {"x", "y", "z", "rotation", "position x", "position y", "position z", "position"};
    static const uint32_t BITS[] = {DAFT_LOCK_X,          DAFT_LOCK_Y,          DAFT_LOCK_Z,
                                    DAFT_LOCK_ROTATION,   DAFT_LOCK_POSITION_X, DAFT_LOCK_POSITION_Y,
                                    DAFT_LOCK_POSITION_Z, DAFT_LOCK_POSITION};
    (void)whole;
    daft_entity_def *def = out;
    int table = lua_absindex(L, -1);
    def->locks = 0;
    if (lua_type(L, table) != LUA_TTABLE) {
        def->locks = BITS[api_choice(L, h, table, "lock", AXES, COUNT_OF(AXES))];
        return;
    }
    for (lua_Integer i = 1, count = (lua_Integer)lua_rawlen(L, table); i <= count; i++) {
        lua_rawgeti(L, table, i);
        api_poll(L, (uint64_t)i);
        def->locks |= BITS[api_choice(L, h, -1, "lock", AXES, COUNT_OF(AXES))];
        lua_pop(L, 1);
    }
}

/* ---- methods ---- */

/* Acts over the next step; while time stands still there is none, and pushes must not add up. */
static daft_vec3 read_force(lua_State *L, host *h, const char *what)
{
    const daft_vec3 force = api_triple(L, h, 2, what), none = {0, 0, 0};
    return h->scale > 0 ? force : none;
}

static int push(lua_State *L, host *h)
{
    daft_error error;
    if (!daft_entity_apply_force(h->def.scene, api_entity_at(L, h, 1, "entity"), read_force(L, h, "force"), &error))
        api_engine_error(L, h, &error);
    return 0;
}

static int impulse(lua_State *L, host *h)
{
    daft_error error;
    daft_entity entity = api_entity_at(L, h, 1, "entity");
    daft_vec3 kick = api_triple(L, h, 2, "impulse");
    int point = lua_type(L, 2) == LUA_TNUMBER ? 5 : 3;
    bool done = lua_isnoneornil(L, point)
                    ? daft_entity_apply_impulse(h->def.scene, entity, kick, &error)
                    : daft_entity_apply_impulse_at(h->def.scene, entity, kick, api_dvec3(L, h, point, "point"), &error);
    if (!done) api_engine_error(L, h, &error);
    return 0;
}

static int torque(lua_State *L, host *h)
{
    daft_error error;
    if (!daft_entity_apply_torque(h->def.scene, api_entity_at(L, h, 1, "entity"), read_force(L, h, "torque"), &error))
        api_engine_error(L, h, &error);
    return 0;
}

static int angular_impulse(lua_State *L, host *h)
{
    daft_error error;
    if (!daft_entity_apply_angular_impulse(h->def.scene, api_entity_at(L, h, 1, "entity"),
                                           api_triple(L, h, 2, "impulse"), &error))
        api_engine_error(L, h, &error);
    return 0;
}

static int mass(lua_State *L, host *h)
{
    daft_error error;
    float kg;
    if (!daft_entity_get_mass(h->def.scene, api_entity_at(L, h, 1, "entity"), &kg, &error))
        api_engine_error(L, h, &error);
    lua_pushnumber(L, (double)kg);
    return 1;
}

static int awake(lua_State *L, host *h)
{
    daft_error error;
    daft_entity entity = api_entity_at(L, h, 1, "entity");
    if (lua_gettop(L) < 2) {
        bool is;
        if (!daft_entity_get_awake(h->def.scene, entity, &is, &error)) api_engine_error(L, h, &error);
        lua_pushboolean(L, is);
        return 1;
    }
    if (h->picture)
        api_error(L, h, "not within daft.draw: drawing must not change the game, so do this in daft.update");
    if (!daft_entity_set_awake(h->def.scene, entity, api_boolean(L, h, 2, "awake"), &error))
        api_engine_error(L, h, &error);
    return 0;
}

static int layers(lua_State *L, host *h)
{
    daft_error error;
    uint32_t what = lua_isnoneornil(L, 2) ? 1 : api_layers(L, h, 2, "layer");
    uint32_t meets = lua_isnoneornil(L, 3) ? UINT32_MAX : api_layers(L, h, 3, "hits");
    if (!daft_entity_set_layers(h->def.scene, api_entity_at(L, h, 1, "entity"), what, meets, &error))
        api_engine_error(L, h, &error);
    return 0;
}

static const api_function FUNCTIONS[] = {
    {"entity:push", "(x, y, z)", "A force in newtons over the next step, at the centre of a dynamic body.", push,
     API_CHANGES},
    {"entity:impulse", "(x, y, z [, point])",
     "A kick in kilograms times metres a second, at the centre of a dynamic body or at a point {x, y, z} of the world.",
     impulse, API_CHANGES},
    {"entity:torque", "(x, y, z)", "A torque in newton metres over the next step.", torque, API_CHANGES},
    {"entity:angular_impulse", "(x, y, z)", "A twist in kg·m²/s.", angular_impulse, API_CHANGES},
    {"entity:mass", "() -> kilograms", "Of a body; 0 where it is not dynamic.", mass, 0},
    {"entity:awake", "([on]) -> on", "Whether a body is awake; or wakes its island, or lets it sleep.", awake, 0},
    {"entity:layers", "([layer [, hits]])",
     "Gives a body other layers, as the fields layer and hits of daft.entity do.", layers, API_CHANGES},
};

const api_area api_body = {"Bodies", FUNCTIONS, COUNT_OF(FUNCTIONS)};
