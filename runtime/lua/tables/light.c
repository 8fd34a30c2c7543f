/* daft.light, daft.ambient, daft.fog and daft.sky. */
#include "lua/fields.h"

#include "common/util.h"

#include <string.h>

/* A cone that only says how wide it is fades over its outer quarter. */
static void narrow_inner(lua_State *L, host *h, int table, void *out)
{
    (void)h;
    daft_light_def *def = out;
    if (!api_has_field(L, table, "inner")) def->inner_angle = 0.75f * def->outer_angle;
}

static const api_special SPOT_SPECIALS[] = {{.name = "angle", .after = narrow_inner},
                                            {.name = "inner",
                                             .doc = "All of its light is within this angle of the direction; "
                                                    "three quarters of angle where only that is given"}};

const api_form api_sun_form = {"light.sun", "daft.light.sun", DAFT_STRUCT_LIGHT_DEF, DAFT_LIGHT_SUN, NULL, 0};
const api_form api_point_form = {"light.point", "daft.light.point", DAFT_STRUCT_LIGHT_DEF, DAFT_LIGHT_POINT, NULL, 0};
const api_form api_spot_form = {"light.spot",    "daft.light.spot", DAFT_STRUCT_LIGHT_DEF,
                                DAFT_LIGHT_SPOT, SPOT_SPECIALS,     COUNT_OF(SPOT_SPECIALS)};
const api_form api_rectangle_form = {
    "light.rectangle", "daft.light.rectangle", DAFT_STRUCT_LIGHT_DEF, DAFT_LIGHT_RECTANGLE, NULL, 0};

const api_form api_fog_form = {"fog", "daft.fog", DAFT_STRUCT_FOG, -1, NULL, 0};

const api_form api_exposure_form = {"exposure", "daft.exposure", DAFT_STRUCT_EXPOSURE, -1, NULL, 0};

/* Changes what the table at `table` names. */
static void read_light(lua_State *L, host *h, int table, daft_light_def *def)
{
    static const api_form *const FORMS[] = {[DAFT_LIGHT_POINT] = &api_point_form,
                                            [DAFT_LIGHT_SUN] = &api_sun_form,
                                            [DAFT_LIGHT_SPOT] = &api_spot_form,
                                            [DAFT_LIGHT_RECTANGLE] = &api_rectangle_form};
    api_read_struct(L, h, table, NULL, FORMS[def->kind], def);
}

static int create(lua_State *L, host *h, daft_light_kind kind)
{
    daft_light_def def = daft_default_light_def();
    def.kind = kind;
    read_light(L, h, 1, &def);
    daft_error error;
    daft_light light = daft_light_create(h->def.scene, &def, &error);
    if (light.id == 0) api_engine_error(L, h, &error);
    api_new_handle(L, API_LIGHT, light.id);
    return 1;
}

static int sun(lua_State *L, host *h) { return create(L, h, DAFT_LIGHT_SUN); }
static int point(lua_State *L, host *h) { return create(L, h, DAFT_LIGHT_POINT); }

static int spot(lua_State *L, host *h) { return create(L, h, DAFT_LIGHT_SPOT); }

static int rectangle(lua_State *L, host *h) { return create(L, h, DAFT_LIGHT_RECTANGLE); }

/* The lights of an entity's file where the entity stands. */
static int add_lights(lua_State *L, host *h)
{
    const daft_entity entity = api_entity_at(L, h, 1, "entity");
    daft_mesh mesh;
    daft_mesh_info info;
    daft_mesh_light one;
    daft_transform at;
    daft_error error;
    if (!daft_entity_get_mesh(h->def.scene, entity, &mesh, &error) ||
        !daft_mesh_get_info(h->def.scene, mesh, &info, &error) ||
        !daft_entity_get_world_transform(h->def.scene, entity, &at, &error))
        api_engine_error(L, h, &error);
    lua_newtable(L);
    for (uint32_t i = 0; i < info.light_count; i++) {
        api_poll(L, i);
        if (!daft_mesh_get_light(h->def.scene, mesh, i, &at, &one, &error)) api_engine_error(L, h, &error);
        const daft_light light = daft_light_create(h->def.scene, &one.light, &error);
        if (light.id == 0) api_engine_error(L, h, &error);
        api_new_handle(L, API_LIGHT, light.id);
        lua_rawseti(L, -2, (lua_Integer)i + 1);
    }
    return 1;
}

static daft_light_def get(lua_State *L, host *h)
{
    daft_light_def def;
    daft_error error;
    if (!daft_light_get(h->def.scene, (daft_light){api_check_handle(L, h, 1, API_LIGHT, "light")->id}, &def, &error))
        api_engine_error(L, h, &error);
    return def;
}

static int put(lua_State *L, host *h, const daft_light_def *def)
{
    daft_error error;
    if (!daft_light_set(h->def.scene, (daft_light){api_check_handle(L, h, 1, API_LIGHT, "light")->id}, def, &error))
        api_engine_error(L, h, &error);
    return 0;
}

static int set(lua_State *L, host *h)
{
    daft_light_def def = get(L, h);
    read_light(L, h, 2, &def);
    return put(L, h, &def);
}

static int set_position(lua_State *L, host *h)
{
    daft_light_def def = get(L, h);
    if (def.kind == DAFT_LIGHT_SUN) api_error(L, h, "a sun has a direction, not a position");
    def.position = api_place(L, h, 2, "position");
    return put(L, h, &def);
}

static int set_direction(lua_State *L, host *h)
{
    daft_light_def def = get(L, h);
    if (def.kind == DAFT_LIGHT_POINT) api_error(L, h, "a point light has a position, not a direction");
    def.direction = api_triple(L, h, 2, "direction");
    return put(L, h, &def);
}

static int set_color(lua_State *L, host *h)
{
    daft_light_def def = get(L, h);
    def.color = api_color(L, h, 2, "color");
    return put(L, h, &def);
}

static int set_shadow(lua_State *L, host *h)
{
    daft_light_def def = get(L, h);
    def.casts_shadow = api_boolean(L, h, 2, "shadow");
    return put(L, h, &def);
}

static int destroy(lua_State *L, host *h)
{
    daft_error error;
    if (!daft_light_destroy(h->def.scene, (daft_light){api_check_handle(L, h, 1, API_LIGHT, "light")->id}, &error))
        api_engine_error(L, h, &error);
    return 0;
}

static int valid(lua_State *L, host *h)
{
    daft_light_def def;
    daft_light light = {api_check_handle(L, h, 1, API_LIGHT, "light")->id};
    lua_pushboolean(L, daft_light_get(h->def.scene, light, &def, NULL));
    return 1;
}

static int ambient(lua_State *L, host *h)
{
    const daft_vec3 color = api_color(L, h, 1, "color");
    const float occlusion = lua_isnoneornil(L, 2) ? 0 : api_float(L, h, 2, "occlusion");
    if (occlusion < 0 || occlusion > 1e6f) api_wrong(L, h, 2, "occlusion", "0 to 1e6 metres");
    daft_scene_set_ambient(h->def.scene, color);
    daft_scene_set_ambient_occlusion(h->def.scene, occlusion);
    return 0;
}

static int fog(lua_State *L, host *h)
{
    daft_fog fog = daft_default_fog();
    daft_error error;
    api_read_struct(L, h, 1, NULL, &api_fog_form, &fog);
    if (!daft_scene_set_fog(h->def.scene, &fog, &error)) api_engine_error(L, h, &error);
    return 0;
}

static int exposure(lua_State *L, host *h)
{
    daft_exposure exposure = daft_default_exposure();
    daft_error error;
    api_read_struct(L, h, 1, NULL, &api_exposure_form, &exposure);
    if (!daft_scene_set_exposure(h->def.scene, &exposure, &error)) api_engine_error(L, h, &error);
    return 0;
}

static int sky_color(lua_State *L, host *h)
{
    daft_scene_set_sky_color(h->def.scene, api_color(L, h, 1, "color"));
    return 0;
}

static int sky_gradient(lua_State *L, host *h)
{
    daft_vec3 zenith = api_color(L, h, 1, "zenith"), horizon = api_color(L, h, 2, "horizon");
    daft_scene_set_sky_gradient(h->def.scene, zenith, horizon);
    return 0;
}

static int sky_image(lua_State *L, host *h)
{
    const char *name = api_text(L, h, 1, "path");
    char path[PATH_SIZE];
    daft_error error;
    if (!host_find_file(h, name, path, sizeof path, &error)) api_engine_error(L, h, &error);
    if (!daft_scene_set_sky_image(h->def.scene, path, &error)) api_engine_error(L, h, &error);
    return 0;
}

static int sky_cube(lua_State *L, host *h)
{
    static const char *const NAMES[6] = {"right", "left", "top", "bottom", "front", "back"};
    char paths[6][PATH_SIZE];
    const char *all[6];
    daft_error error;
    for (int i = 0; i < 6; i++) {
        if (!host_find_file(h, api_text(L, h, i + 1, NAMES[i]), paths[i], sizeof paths[i], &error))
            api_engine_error(L, h, &error);
        all[i] = paths[i];
    }
    if (!daft_scene_set_sky_cube(h->def.scene, all, &error)) api_engine_error(L, h, &error);
    return 0;
}

static int sky_light(lua_State *L, host *h)
{
    const float strength = lua_isnoneornil(L, 1) ? 1 : api_float(L, h, 1, "strength"),
                occlusion = lua_isnoneornil(L, 2) ? 0 : api_float(L, h, 2, "occlusion");
    if (strength < 0 || strength > 1e6f) api_wrong(L, h, 1, "strength", "0 to 1e6");
    if (occlusion < 0 || occlusion > 1e6f) api_wrong(L, h, 2, "occlusion", "0 to 1e6 metres");
    daft_scene_set_ambient_sky(h->def.scene, strength);
    daft_scene_set_ambient_occlusion(h->def.scene, occlusion);
    return 0;
}

static const api_function FUNCTIONS[] = {
    {"light.sun", "{...} -> light", "Light from infinitely far.", sun, API_CHANGES},
    {"light.point", "{...} -> light",
     "Light from a point, equally bright at any distance unless it has a range or is inverse_square.", point,
     API_CHANGES},
    {"light.spot", "{...} -> light", "A point light that shines into a cone.", spot, API_CHANGES},
    {"entity:add_lights", "() -> list",
     "Makes lights of those that its mesh's file has, where it stands now, and lists them. Those of glTF have their\n"
     "candela or lux / pi as colour: bright ones need daft.exposure.",
     add_lights, API_CHANGES},
    {"light.rectangle", "{...} -> light", "A rectangle that shines to one side, softly.", rectangle, API_CHANGES},
    {"light:set", "{...}", "Changes what the table names.", set, API_CHANGES},
    {"light:position", "(x, y, z)", "Moves a light that is no sun.", set_position, API_CHANGES},
    {"light:direction", "(x, y, z)", "Turns a light that is no point light.", set_direction, API_CHANGES},
    {"light:color", "(color)", "Values above 1 are brighter.", set_color, API_CHANGES},
    {"light:shadow", "(on)", "Whether entities cast shadows in it.", set_shadow, API_CHANGES},
    {"light:destroy", "()", "Puts it out for good.", destroy, API_CHANGES},
    {"light:valid", "() -> boolean", "False once it has been destroyed.", valid, 0},
    {"ambient", "(color [, occlusion])",
     "Light from everywhere; what stands within so many metres of a surface keeps it away (ambient occlusion).",
     ambient, API_CHANGES},
    {"fog", "{...}", "Fog between what is seen and the camera; an empty table takes it away.", fog, API_CHANGES},
    {"exposure", "{...}",
     "How bright the picture is shown, and by which curve what is brighter than white; an empty table: light as it is.",
     exposure, API_CHANGES},
    {"sky.color", "(color)", "The same sky everywhere.", sky_color, API_CHANGES},
    {"sky.gradient", "(zenith, horizon)", "A sky from one colour above to another at the horizon.", sky_gradient,
     API_CHANGES},
    {"sky.image", "(\"file\")", "One equirectangular image around the world.", sky_image, API_CHANGES},
    {"sky.cube", "(right, left, top, bottom, front, back)",
     "Six square image files as seen from within (px nx py ny pz nz of most sets): front towards -Z, right towards +X.",
     sky_cube, API_CHANGES},
    {"sky.light", "([strength [, occlusion]])",
     "The sky's own light, by the direction that a surface faces, in place of daft.ambient's colour; occlusion as "
     "there.",
     sky_light, API_CHANGES},
};

const api_area api_light = {"Lights and sky", FUNCTIONS, COUNT_OF(FUNCTIONS)};
