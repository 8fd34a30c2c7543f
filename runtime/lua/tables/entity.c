/* daft.entity and the methods of entities. */
#include "lua/tables/animation.h"
#include "lua/tables/body.h"

#include "common/util.h"

#include <stdlib.h>
#include <string.h>

daft_entity api_entity_at(lua_State *L, host *h, int index, const char *what)
{
    return (daft_entity){api_check_handle(L, h, index, API_ENTITY, what)->id};
}

/* ---- creation ---- */

static daft_vec3 read_scale(lua_State *L, host *h, int index)
{
    if (lua_type(L, index) != LUA_TNUMBER) return api_vec3(L, h, index, "scale");
    float scale = api_float(L, h, index, "scale");
    return (daft_vec3){scale, scale, scale};
}

static void show_mesh(lua_State *L, host *h, int table, void *out)
{
    (void)L, (void)h, (void)table;
    ((daft_entity_def *)out)->shape = DAFT_SHAPE_MESH;
}

static void show_sphere(lua_State *L, host *h, int table, void *out)
{
    (void)L, (void)h, (void)table;
    ((daft_entity_def *)out)->shape = DAFT_SHAPE_SPHERE;
}

static void show_box(lua_State *L, host *h, int table, void *out)
{
    (void)L, (void)h, (void)table;
    ((daft_entity_def *)out)->shape = DAFT_SHAPE_BOX;
}

/* 0 says in C that the density counts; here one leaves the field out. */
static void check_mass(lua_State *L, host *h, int table, void *out)
{
    (void)table;
    if (!(((daft_entity_def *)out)->mass > 0)) api_error(L, h, "mass is 0; it must be above 0");
}

static const api_special SPECIALS[] = {
    {.name = "mesh",
     .after = show_mesh,
     .doc = "The mesh that is drawn; an entity without mesh, sphere and box is a group"},
    {.name = "sphere", .after = show_sphere},
    {.name = "box", .after = show_box},
    {.name = "mass",
     .after = check_mass,
     .value = "number, kg, above 0",
     .doc = "Its mass; from the density unless given"},
    {.name = "collider", .read = api_read_colliders, .value = "\"hull\", \"mesh\", table or list of tables"},
    {.name = "surface", .read = api_read_surface, .value = "name", .doc = "The kind of its surface, for daft.surfaces"},
    {.name = "lock",
     .read = api_read_locks,
     .value = "name or list of names",
     .doc = "\"rotation\", \"x\", \"y\", \"z\": axes of the world about which it does not turn; \"position\", "
            "\"position x\", "
            "\"position y\", \"position z\": along which its centre of mass does not move"},
    {.name = "layer", .read = api_read_layer, .value = "name or names"},
    {.name = "hits", .read = api_read_hits, .value = "name or names"},
    {.name = "velocity", .value = "{x, y, z}, m/s", .doc = "Of a body that moves"},
    {.name = "angular_velocity", .value = "{x, y, z}, rad/s", .doc = "Of a body that moves"},
    {.name = "clip", .value = "name or number", .doc = "The clip of its mesh that it plays, looped: see e:play"},
    {.name = "name", .value = "string", .doc = "e.name can be read and set; daft.find finds it"},
    {.name = "tags", .value = "name or list of names", .doc = "What it is, for e:has_tag and daft.find"},
    {.name = "data", .value = "anything", .doc = "e.data can be read and set"}};

const api_form api_entity_form = {"entity", "daft.entity", DAFT_STRUCT_ENTITY_DEF, -1, SPECIALS, COUNT_OF(SPECIALS)};

static int create(lua_State *L, host *h)
{
    daft_entity_def def = daft_default_entity_def();
    api_read_struct(L, h, 1, NULL, &api_entity_form, &def);
    if (api_has_field(L, 1, "mesh") + api_has_field(L, 1, "sphere") + api_has_field(L, 1, "box") > 1)
        api_error(L, h, "only one of mesh, sphere and box expected");
    daft_vec3 linear = {0, 0, 0}, angular = {0, 0, 0};
    bool moves = api_field(L, 1, "velocity");
    if (moves) linear = api_vec3(L, h, -1, "velocity");
    bool turns = api_field(L, 1, "angular_velocity");
    if (turns) angular = api_vec3(L, h, -1, "angular_velocity");
    if ((moves || turns) && def.body != DAFT_BODY_DYNAMIC && def.body != DAFT_BODY_KINEMATIC)
        api_error(L, h, "velocity: only a body that is \"dynamic\" or \"kinematic\" has one");
    if (api_field(L, 1, "name")) api_text(L, h, -1, "name");
    if (api_field(L, 1, "tags")) api_check_tags(L, h, -1);
    const bool plays = api_field(L, 1, "clip");
    if (plays && def.shape != DAFT_SHAPE_MESH) api_error(L, h, "clip: only a mesh has clips");
    const daft_play_def clip = plays ? api_read_play(L, h, -1, def.mesh) : daft_default_play_def();
    daft_error error;
    daft_entity entity = daft_entity_create(h->def.scene, &def, &error);
    if (entity.id == 0) api_engine_error(L, h, &error);
    if (((moves || turns) && !daft_entity_set_velocity(h->def.scene, entity, linear, angular, &error)) ||
        (plays && !daft_entity_play(h->def.scene, entity, &clip, &error))) {
        daft_entity_destroy(h->def.scene, entity, NULL);
        api_engine_error(L, h, &error);
    }
    api_push_entity(L, entity.id);
    ((api_handle *)lua_touserdata(L, -1))->visible = def.visible;
    if (api_field(L, 1, "data")) api_set_own(L, -2, "data");
    if (api_field(L, 1, "name")) api_set_name(L, -2);
    if (api_field(L, 1, "tags")) api_add_tags(L, -2);
    return 1;
}

/* ---- transforms ---- */

static daft_transform get_transform(lua_State *L, host *h)
{
    daft_transform transform;
    daft_error error;
    if (!daft_entity_get_transform(h->def.scene, (daft_entity){h->self->id}, &transform, &error))
        api_engine_error(L, h, &error);
    return transform;
}

static int set_transform(lua_State *L, host *h, const daft_transform *transform, bool teleport)
{
    daft_error error;
    if (!daft_entity_set_transform(h->def.scene, (daft_entity){h->self->id}, transform, teleport, &error))
        api_engine_error(L, h, &error);
    return 0;
}

static int set_position(lua_State *L, host *h, bool teleport)
{
    daft_error error;
    const daft_entity entity = {h->self->id};
    const daft_dvec3 place = api_place(L, h, 2, "position");
    if (!daft_entity_set_position(h->def.scene, entity, place, teleport, &error)) api_engine_error(L, h, &error);
    return 0;
}

static int position(lua_State *L, host *h)
{
    if (lua_gettop(L) >= 2) {
        api_check_may_change(L, h);
        return set_position(L, h, false);
    }
    const daft_transform transform = get_transform(L, h);
    return api_push_numbers(L, transform.position.x, transform.position.y, transform.position.z);
}

static int teleport(lua_State *L, host *h) { return set_position(L, h, true); }

static int rotation(lua_State *L, host *h)
{
    daft_transform transform = get_transform(L, h);
    if (lua_gettop(L) < 2) {
        daft_quat q = transform.rotation;
        api_push_numbers(L, (double)q.x, (double)q.y, (double)q.z);
        lua_pushnumber(L, (double)q.w);
        return 4;
    }
    api_check_may_change(L, h);
    if (lua_type(L, 2) == LUA_TNUMBER) {
        int count = lua_gettop(L) - 1;
        if (count != 3 && count != 4) api_error(L, h, "rotation: 3 or 4 numbers expected, got %d", count);
        lua_createtable(L, count, 0);
        for (int i = 0; i < count; i++) {
            lua_pushvalue(L, 2 + i);
            lua_rawseti(L, -2, i + 1);
        }
        lua_replace(L, 2);
    }
    transform.rotation = api_rotation(L, h, 2, "rotation");
    return set_transform(L, h, &transform, false);
}

static int scale(lua_State *L, host *h)
{
    daft_transform transform = get_transform(L, h);
    if (lua_gettop(L) < 2)
        return api_push_numbers(L, (double)transform.scale.x, (double)transform.scale.y, (double)transform.scale.z);
    api_check_may_change(L, h);
    transform.scale = lua_gettop(L) >= 4 ? api_triple(L, h, 2, "scale") : read_scale(L, h, 2);
    return set_transform(L, h, &transform, false);
}

/* ---- looks ---- */

static int material(lua_State *L, host *h)
{
    daft_entity entity = api_entity_at(L, h, 1, "entity");
    daft_error error;
    if (!daft_entity_set_material(h->def.scene, entity, api_material_at(L, h, 2, "material"), &error))
        api_engine_error(L, h, &error);
    return 0;
}

static int visible(lua_State *L, host *h)
{
    api_handle *handle = api_check_handle(L, h, 1, API_ENTITY, "entity");
    get_transform(L, h); /* refuses an entity that is gone */
    if (lua_gettop(L) < 2) {
        lua_pushboolean(L, handle->visible);
        return 1;
    }
    api_check_may_change(L, h);
    bool wish = api_boolean(L, h, 2, "visible");
    daft_error error;
    if (!daft_entity_set_visible(h->def.scene, (daft_entity){handle->id}, wish, &error)) api_engine_error(L, h, &error);
    handle->visible = wish;
    return 0;
}

/* ---- motion ---- */

static void get_velocity(lua_State *L, host *h, daft_vec3 *linear, daft_vec3 *angular)
{
    daft_error error;
    if (!daft_entity_get_velocity(h->def.scene, api_entity_at(L, h, 1, "entity"), linear, angular, &error))
        api_engine_error(L, h, &error);
}

static int set_velocity(lua_State *L, host *h, daft_vec3 linear, daft_vec3 angular)
{
    daft_error error;
    if (!daft_entity_set_velocity(h->def.scene, api_entity_at(L, h, 1, "entity"), linear, angular, &error))
        api_engine_error(L, h, &error);
    return 0;
}

static int velocity(lua_State *L, host *h)
{
    daft_vec3 linear, angular;
    get_velocity(L, h, &linear, &angular);
    if (lua_gettop(L) < 2) return api_push_numbers(L, (double)linear.x, (double)linear.y, (double)linear.z);
    api_check_may_change(L, h);
    return set_velocity(L, h, api_triple(L, h, 2, "velocity"), angular);
}

static int angular_velocity(lua_State *L, host *h)
{
    daft_vec3 linear, angular;
    get_velocity(L, h, &linear, &angular);
    if (lua_gettop(L) < 2) return api_push_numbers(L, (double)angular.x, (double)angular.y, (double)angular.z);
    api_check_may_change(L, h);
    return set_velocity(L, h, linear, api_triple(L, h, 2, "angular_velocity"));
}

/* Sets other, point, normal and impulse of the table on top; `sign` turns the normal to point away from the other. */
static void put_contact(lua_State *L, const daft_contact *contact, uint32_t other, double sign)
{
    api_push_entity(L, other);
    lua_setfield(L, -2, "other");
    api_set_vec3(L, "point", contact->point.x, contact->point.y, contact->point.z);
    api_set_vec3(L, "normal", sign * (double)contact->normal.x, sign * (double)contact->normal.y,
                 sign * (double)contact->normal.z);
    lua_pushnumber(L, (double)contact->impulse);
    lua_setfield(L, -2, "impulse");
}

static int contacts(lua_State *L, host *h)
{
    get_transform(L, h); /* refuses an entity that is gone */
    const uint32_t self = api_entity_at(L, h, 1, "entity").id;
    uint32_t count = daft_scene_contacts(h->def.scene, NULL, 0);
    daft_contact *all = api_scratch(L, count * sizeof *all);
    count = daft_scene_contacts(h->def.scene, all, count);
    api_push_out(L, h, 2, "list");
    lua_Integer found = 0;
    for (uint32_t i = 0; i < count; i++) {
        if (all[i].a.id != self && all[i].b.id != self) continue;
        const bool first = all[i].a.id == self;
        api_push_item(L, ++found);
        put_contact(L, &all[i], first ? all[i].b.id : all[i].a.id, first ? -1 : 1);
        lua_pop(L, 1);
    }
    api_end_list(L, found);
    return 1;
}

/* ---- life ---- */

static int destroy(lua_State *L, host *h)
{
    daft_error error;
    if (!daft_entity_destroy(h->def.scene, api_entity_at(L, h, 1, "entity"), &error)) api_engine_error(L, h, &error);
    return 0;
}

static int valid(lua_State *L, host *h)
{
    lua_pushboolean(L, daft_entity_is_valid(h->def.scene, api_entity_at(L, h, 1, "entity")));
    return 1;
}

static const api_function FUNCTIONS[] = {
    {"entity", "{...} -> entity",
     "Makes an entity: at most one of mesh, sphere and box is drawn, and a body is simulated.", create, API_CHANGES},
    {"entity:position", "([x, y, z]) -> x, y, z",
     "Where it is, or puts it there (also {x, y, z}). Drawing glides from the last place to this one.", position, 0},
    {"entity:teleport", "(x, y, z)", "Puts it there at once, without a glide.", teleport, API_CHANGES},
    {"entity:rotation", "([yaw, pitch, roll]) -> x, y, z, w",
     "The rotation as a quaternion, or sets it from three angles or a quaternion's four numbers.", rotation, 0},
    {"entity:scale", "([s | x, y, z]) -> x, y, z", "The scale, or sets it.", scale, 0},
    {"entity:material", "(material)", "Gives it another material, as in daft.entity.", material, API_CHANGES},
    {"entity:visible", "([on]) -> on", "Whether it is drawn and hit by rays, or sets it.", visible, 0},
    {"entity:velocity", "([x, y, z]) -> x, y, z", "Metres a second; of a body.", velocity, 0},
    {"entity:angular_velocity", "([x, y, z]) -> x, y, z", "Radians a second about each axis; of a body.",
     angular_velocity, 0},
    {"entity:contacts", "([list]) -> list",
     "What touched it in the last step: a list of {other = entity, point = {x, y, z}, normal = {x, y, z},\n"
     "impulse = n}; the normal points away from the other. list: one to fill again.",
     contacts, 0},
    {"entity:destroy", "()", "Takes it and its children out of the world.", destroy, API_CHANGES},
    {"entity:valid", "() -> boolean", "False once it has been destroyed.", valid, 0},
};

const api_area api_entity = {"Entities", FUNCTIONS, COUNT_OF(FUNCTIONS)};
