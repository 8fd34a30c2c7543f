/* daft.picture: what a camera of the game sees, for the game itself: a robot's eye, a minimap's depth, what a bot can
 * tell. Pixels are the same everywhere, whatever quality the player chose, so a game may decide by them.
 *
 * A picture's arrays are in its userdata, so that they count towards what the game may hold. */
#include "lua/fields.h"

#include "common/util.h"

#include <string.h>

enum {
    MOST = 1024 * 1024, /* pixels */
    PIXEL_BYTES = 3 * sizeof(daft_vec3) + sizeof(daft_vec2) + 4 * sizeof(uint32_t)
};

static const char *const FIELDS[] = {"width", "height"};

const api_form api_picture_form = {"picture:draw", "picture:draw", DAFT_STRUCT_CAMERA, -1, NULL, 0};

typedef struct sight {
    api_handle handle;
    bool drawn;
    int width, height;
    daft_camera camera;
    daft_history *history;
    daft_aov arrays;
} sight;

/* Arrays one after the other behind the struct; largest members first, so that all are aligned. */
static void place_arrays(sight *s, char *from, size_t pixels)
{
    char *to = from;
    s->arrays = (daft_aov){0};
    s->arrays.normal = (daft_vec3 *)(void *)to, to += pixels * sizeof *s->arrays.normal;
    s->arrays.color = (daft_vec3 *)(void *)to, to += pixels * sizeof *s->arrays.color;
    s->arrays.albedo = (daft_vec3 *)(void *)to, to += pixels * sizeof *s->arrays.albedo;
    s->arrays.motion = (daft_vec2 *)(void *)to, to += pixels * sizeof *s->arrays.motion;
    s->arrays.depth = (float *)(void *)to, to += pixels * sizeof *s->arrays.depth;
    s->arrays.entity = (daft_entity *)(void *)to, to += pixels * sizeof *s->arrays.entity;
    s->arrays.triangle = (uint32_t *)(void *)to, to += pixels * sizeof *s->arrays.triangle;
    s->arrays.cost = (uint32_t *)(void *)to;
}

static int side(lua_State *L, host *h, const char *name)
{
    if (!api_field(L, 1, name)) api_error(L, h, "%s: whole number of pixels expected, got nil", name);
    lua_Integer value = api_whole(L, h, -1, name);
    if (value < 1 || value > 4096) api_error(L, h, "%s: 1 to 4096 pixels expected, got %d", name, (int)value);
    lua_pop(L, 1);
    return (int)value;
}

static int create(lua_State *L, host *h)
{
    api_fields(L, h, 1, NULL, FIELDS, COUNT_OF(FIELDS));
    const int width = side(L, h, "width"), height = side(L, h, "height");
    if (width * height > MOST) api_error(L, h, "%d x %d pixels are too many: %d at most", width, height, MOST);
    const size_t pixels = (size_t)width * (size_t)height, bytes = sizeof(sight) + pixels * PIXEL_BYTES;
    sight *s = lua_newuserdatauv(L, bytes, 0);
    memset(s, 0, bytes);
    place_arrays(s, (char *)(s + 1), pixels);
    s->handle.id = ++h->pictures;
    s->width = width, s->height = height;
    s->camera = daft_default_camera();
    api_set_type(L, API_PICTURE);
    daft_error error;
    s->history = daft_history_create(h->def.engine, &error);
    if (!s->history) api_engine_error(L, h, &error);
    return 1;
}

int api_release_picture(lua_State *L)
{
    sight *s = lua_touserdata(L, 1);
    daft_history_destroy(s->history);
    s->history = NULL;
    return 0;
}

static sight *check(lua_State *L, host *h) { return (sight *)api_check_handle(L, h, 1, API_PICTURE, "picture"); }

static bool keep_drawing(void *user, float unused)
{
    (void)unused;
    return watchdog_look(user) <= WATCHDOG_RUNNING;
}

static int draw(lua_State *L, host *h)
{
    sight *s = check(L, h);
    if (!lua_isnoneornil(L, 2)) api_read_struct(L, h, 2, NULL, &api_picture_form, &s->camera);
    daft_view view = daft_default_view();
    view.camera = s->camera;
    view.alpha = 1;
    view.quality = daft_preset_quality(DAFT_PRESET_GAME), view.quality.edge_samples = 0;
    view.aov = s->arrays, view.history = s->history;
    view.progress = keep_drawing, view.progress_user = h->dog;
    daft_error error;
    daft_image *image = daft_image_create(h->def.engine, s->width, s->height, &error);
    bool good = image && daft_render(h->def.scene, &view, image, &error);
    daft_image_destroy(image);
    if (!good && error.code == DAFT_ERROR_CANCELLED) host_poll(L); /* says what took too long */
    if (!good) api_engine_error(L, h, &error);
    s->drawn = true;
    return 0;
}

/* ---- pixels ---- */

static size_t pixel_at(lua_State *L, host *h, const sight *s)
{
    const lua_Integer x = api_whole(L, h, 2, "x"), y = api_whole(L, h, 3, "y");
    if (!s->drawn) api_error(L, h, "nothing is drawn yet: call picture:draw first");
    if (x < 0 || x >= s->width || y < 0 || y >= s->height)
        api_error(L, h, "pixel (%d, %d) is outside: 0 to %d, 0 to %d", (int)x, (int)y, s->width - 1, s->height - 1);
    return (size_t)y * (size_t)s->width + (size_t)x;
}

static int size(lua_State *L, host *h)
{
    const sight *s = check(L, h);
    lua_pushinteger(L, s->width), lua_pushinteger(L, s->height);
    return 2;
}

static int push3(lua_State *L, daft_vec3 v) { return api_push_numbers(L, (double)v.x, (double)v.y, (double)v.z); }

static int depth(lua_State *L, host *h)
{
    const sight *s = check(L, h);
    lua_pushnumber(L, (double)s->arrays.depth[pixel_at(L, h, s)]);
    return 1;
}

static int entity(lua_State *L, host *h)
{
    const sight *s = check(L, h);
    const daft_entity e = s->arrays.entity[pixel_at(L, h, s)];
    api_push_entity(L, daft_entity_is_valid(h->def.scene, e) ? e.id : 0);
    return 1;
}

static int normal(lua_State *L, host *h)
{
    const sight *s = check(L, h);
    return push3(L, s->arrays.normal[pixel_at(L, h, s)]);
}

static int color(lua_State *L, host *h)
{
    const sight *s = check(L, h);
    return push3(L, s->arrays.color[pixel_at(L, h, s)]);
}

static int albedo(lua_State *L, host *h)
{
    const sight *s = check(L, h);
    return push3(L, s->arrays.albedo[pixel_at(L, h, s)]);
}

static int motion(lua_State *L, host *h)
{
    const sight *s = check(L, h);
    const daft_vec2 m = s->arrays.motion[pixel_at(L, h, s)];
    lua_pushnumber(L, (double)m.x), lua_pushnumber(L, (double)m.y);
    return 2;
}

static int triangle(lua_State *L, host *h)
{
    const sight *s = check(L, h);
    lua_pushinteger(L, (lua_Integer)s->arrays.triangle[pixel_at(L, h, s)]);
    return 1;
}

static int cost(lua_State *L, host *h)
{
    const sight *s = check(L, h);
    lua_pushinteger(L, (lua_Integer)s->arrays.cost[pixel_at(L, h, s)]);
    return 1;
}

static const api_function FUNCTIONS[] = {
    {"picture", "{width =, height =} -> picture",
     "What a camera of the game sees, for the game to read; up to 1,048,576 pixels. It has no pixels until it is "
     "drawn.",
     create, API_CHANGES},
    {"picture:draw", "([{...}])",
     "Draws what the camera sees now. What is not named stays as in the last call; first it is daft.camera's default.",
     draw, API_CHANGES},
    {"picture:size", "() -> width, height", "In pixels.", size, 0},
    {"picture:depth", "(x, y) -> number", "Metres along the ray; math.huge where the sky is. Pixels count from 0, 0.",
     depth, 0},
    {"picture:entity", "(x, y) -> entity or nil", "nil where the sky is, or what has been destroyed since.", entity, 0},
    {"picture:normal", "(x, y) -> x, y, z", "Of the surface, unit; zeros where the sky is.", normal, 0},
    {"picture:color", "(x, y) -> r, g, b", "Linear light, not limited to 1.", color, 0},
    {"picture:albedo", "(x, y) -> r, g, b", "The surface's own colour, linear; zeros where the sky is.", albedo, 0},
    {"picture:motion", "(x, y) -> x, y",
     "Pixels to the right and down that what is seen has moved since the picture was drawn before.", motion, 0},
    {"picture:triangle", "(x, y) -> number", "Of the entity's mesh, from 0.", triangle, 0},
    {"picture:cost", "(x, y) -> number", "Rays that were cast for the pixel.", cost, 0},
};

const api_area api_picture = {"Pictures that the game reads", FUNCTIONS, COUNT_OF(FUNCTIONS)};
