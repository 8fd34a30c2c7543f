/* Rays, points of the screen, gravity, time, and the life of the game. */
#include "lua/api.h"
#include "lua/fields.h"

#include "common/util.h"

#include <float.h>
#include <math.h>

/* ---- rays ---- */

/* `into`: the place of a table for it, or of nil. */
static int push_hit(lua_State *L, host *h, const daft_ray_hit *hit, int into)
{
    api_push_out(L, h, into, "hit");
    api_push_entity(L, hit->entity.id);
    lua_setfield(L, -2, "entity");
    lua_pushnumber(L, (double)hit->distance);
    lua_setfield(L, -2, "distance");
    api_set_vec3(L, "position", hit->position.x, hit->position.y, hit->position.z);
    api_set_vec3(L, "normal", (double)hit->normal.x, (double)hit->normal.y, (double)hit->normal.z);
    lua_pushinteger(L, (lua_Integer)hit->triangle + 1);
    lua_setfield(L, -2, "triangle");
    return 1;
}

/* [, max_distance [, ignore [, hit]]] from `index` on. */
static int cast(lua_State *L, host *h, daft_dvec3 from, daft_vec3 direction, int index)
{
    float far_limit = FLT_MAX;
    if (!lua_isnoneornil(L, index)) far_limit = api_float(L, h, index, "max_distance");
    if (!(far_limit > 0)) api_wrong(L, h, index, "max_distance", "number above 0");
    daft_entity ignore = {0};
    if (!lua_isnoneornil(L, index + 1)) ignore = api_entity_at(L, h, index + 1, "ignore");
    daft_ray_hit hit;
    daft_error error = {0};
    if (daft_scene_cast_ray(h->def.scene, from, direction, far_limit, ignore, &hit, &error))
        return push_hit(L, h, &hit, index + 2);
    if (error.code != DAFT_OK) api_engine_error(L, h, &error);
    lua_pushnil(L);
    return 1;
}

static int raycast(lua_State *L, host *h)
{
    daft_dvec3 from = api_place(L, h, 1, "from");
    daft_vec3 direction = api_vec3(L, h, 2, "direction");
    if (direction.x == 0 && direction.y == 0 && direction.z == 0) api_error(L, h, "direction: it has no length");
    return cast(L, h, from, direction, 3);
}

/* ---- points of the screen ---- */

/* Two numbers from `index` on, or the mouse's place where there are none. */
static daft_vec3 read_screen_ray(lua_State *L, host *h, const daft_camera *camera)
{
    double x = (double)h->def.keys->mouse_x, y = (double)h->def.keys->mouse_y;
    if (!lua_isnoneornil(L, 1)) x = api_number(L, h, 1, "x"), y = api_number(L, h, 2, "y");
    const double width = (double)host_width(h), height = CANVAS_HEIGHT;
    return daft_camera_ray(camera, x / width, y / height, height / width);
}

static int screen_ray(lua_State *L, host *h)
{
    const daft_camera camera = daft_scene_camera(h->def.scene, 1);
    const daft_vec3 ray = read_screen_ray(L, h, &camera);
    api_push_vec3(L, camera.position.x, camera.position.y, camera.position.z);
    api_push_vec3(L, (double)ray.x, (double)ray.y, (double)ray.z);
    return 2;
}

static int pick_entity(lua_State *L, host *h)
{
    const daft_camera camera = daft_scene_camera(h->def.scene, 1);
    const daft_vec3 ray = read_screen_ray(L, h, &camera);
    return cast(L, h, camera.position, ray, 3);
}

/* ---- time ---- */

static int gravity(lua_State *L, host *h)
{
    daft_scene_set_gravity(h->def.scene, api_triple(L, h, 1, "gravity"));
    return 0;
}

static int time_now(lua_State *L, host *h)
{
    lua_pushnumber(L, h->clock / 60.0);
    return 1;
}

static int time_scale(lua_State *L, host *h)
{
    enum { FASTEST = 4 }; /* longer steps of the simulation would be less exact than games bear */
    if (lua_gettop(L) == 0) {
        lua_pushnumber(L, h->next_scale);
        return 1;
    }
    api_check_may_change(L, h);
    const double scale = api_number(L, h, 1, "scale");
    if (!(scale >= 0 && scale <= FASTEST)) api_wrong(L, h, 1, "scale", "number from 0 to 4");
    h->next_scale = scale;
    return 0;
}

static int tick(lua_State *L, host *h)
{
    lua_pushinteger(L, (lua_Integer)h->tick);
    return 1;
}

/* ---- life ---- */

static int quit(lua_State *L, host *h)
{
    (void)L;
    h->quit = true;
    return 0;
}

static int restart(lua_State *L, host *h)
{
    (void)L;
    h->restart = true;
    return 0;
}

/* A table from names to entities, of those from `first` on; of two with one name, the first. */
static int push_named(lua_State *L, host *h, uint32_t first)
{
    const uint32_t count = daft_scene_named_count(h->def.scene);
    lua_newtable(L);
    for (uint32_t i = first; i < count; i++) {
        daft_named_entity named;
        daft_scene_get_named(h->def.scene, i, &named, NULL);
        api_push_entity(L, named.entity.id);
        lua_pushstring(L, named.name);
        api_set_name(L, -2);
        lua_pushstring(L, named.name);
        const bool taken = lua_rawget(L, -3) != LUA_TNIL;
        lua_pop(L, 1);
        if (taken)
            lua_pop(L, 1);
        else
            lua_setfield(L, -2, named.name);
        api_poll(L, i);
    }
    return 1;
}

static int load_scene(lua_State *L, host *h)
{
    const char *name = api_text(L, h, 1, "file");
    char path[PATH_SIZE];
    daft_error error;
    if (!host_find_file(h, name, path, sizeof path, &error)) api_engine_error(L, h, &error);
    const uint32_t before = daft_scene_named_count(h->def.scene);
    if (!daft_scene_load(h->def.scene, path, &error)) api_engine_error(L, h, &error);
    return push_named(L, h, before);
}

static const api_special QUALITY_SPECIALS[] = {
    {"preset", NULL, NULL, "\"draft\", \"game\", \"high\", \"reference\"",
     "Sets all knobs to those of a preset, before the others are set"},
    {"target_ms", NULL, NULL, "number from 1 to 1000, or 0",
     "What a frame may take, by pictures that are less exact where they must be; 0: whatever it takes. What the player "
     "asked for goes first"}};
const api_form api_quality_form = {"quality", "daft.quality",   DAFT_STRUCT_QUALITY,
                                   -1,        QUALITY_SPECIALS, COUNT_OF(QUALITY_SPECIALS)};

static double target_ms(lua_State *L, host *h)
{
    const double ms = api_number(L, h, -1, "target_ms");
    if (ms != 0 && !(ms >= 1 && ms <= 1000)) api_wrong(L, h, -1, "target_ms", "number from 1 to 1000, or 0");
    return ms;
}

static void set_quality(lua_State *L, host *h)
{
    static const char *const PRESETS[] = {"draft", "game", "high", "reference"};
    daft_quality chosen = daft_scene_quality(h->def.scene);
    double ms = h->target_ms;
    daft_error error;
    if (lua_type(L, 1) == LUA_TTABLE && api_field(L, 1, "preset")) {
        chosen = daft_preset_quality((daft_preset)api_choice(L, h, -1, "preset", PRESETS, COUNT_OF(PRESETS)));
        lua_pop(L, 1);
    }
    api_read_struct(L, h, 1, NULL, &api_quality_form, &chosen);
    if (api_field(L, 1, "target_ms")) ms = target_ms(L, h);
    if (!daft_scene_set_quality(h->def.scene, &chosen, &error)) api_engine_error(L, h, &error);
    h->target_ms = ms;
}

static int quality(lua_State *L, host *h)
{
    if (!lua_isnoneornil(L, 1)) set_quality(L, h);
    const daft_quality now = daft_scene_quality(h->def.scene);
    api_push_struct(L, DAFT_STRUCT_QUALITY, &now);
    if (h->target_ms >= 0) {
        lua_pushnumber(L, h->target_ms);
        lua_setfield(L, -2, "target_ms");
    }
    return 1;
}

static const api_function FUNCTIONS[] = {
    {"raycast", "(from, direction [, max_distance [, ignore [, hit]]]) -> hit or nil",
     "The nearest visible entity along a ray: {entity =, distance =, position =, normal =, triangle =}.\n"
     "from may be an entity; ignore is one that the ray passes through; hit a table to fill.",
     raycast, 0},
    {"screen_ray", "([x, y]) -> from, direction",
     "The ray from the camera through a point of the picture, in HUD units; the mouse's unless given.", screen_ray, 0},
    {"pick", "([x, y [, max_distance [, ignore [, hit]]]]) -> hit or nil",
     "What is seen at a point of the picture, or under the mouse: what daft.raycast gives.", pick_entity, 0},
    {"gravity", "(x, y, z)", "In m/s²; 0, -9.81, 0 unless set.", gravity, API_CHANGES},
    {"time", "() -> seconds", "Of the game: ticks / 60, times what daft.time_scale said in each.", time_now, 0},
    {"time_scale", "([scale]) -> scale",
     "How fast the game's time goes from the next tick on: 1; slow motion below; 0: a pause; up to 4. dt of "
     "daft.update,\n"
     "the simulation, daft.time and tasks follow it; ticks do not.",
     time_scale, 0},
    {"tick", "() -> number", "Updates since the game began.", tick, 0},
    {"scene", "(\"file.scene\") -> table",
     "Adds what a scene file describes; gives the entities that it names, by name.", load_scene, API_CHANGES},
    {"quality", "([{...}]) -> knobs",
     "Sets what a picture costs and how exact it is: preset =, target_ms = and knobs by name, such as samples =.\n"
     "Gives them all. What the player asked for goes first. Pictures alone change, never the game.",
     quality, 0},
    {"restart", "()", "Starts the game afresh after this tick.", restart, API_CHANGES},
    {"quit", "()", "Ends the game after this tick.", quit, API_CHANGES},
};

const api_area api_world = {"World", FUNCTIONS, COUNT_OF(FUNCTIONS)};
