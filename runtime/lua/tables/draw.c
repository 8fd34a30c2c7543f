/* daft.image, shapes, clipping and the canvas: drawing over the picture beside text (tables/hud.c). */
#include "lua/api.h"

#include "common/util.h"

#include <math.h>
#include <stdlib.h>

static const canvas_color WHITE = {255, 255, 255, 255};

/* ---- images ---- */

typedef struct image_handle {
    api_handle handle;
    daft_image *what;
} image_handle;

int api_release_image(lua_State *L)
{
    image_handle *i = lua_touserdata(L, 1);
    daft_image_destroy(i->what);
    i->what = NULL;
    return 0;
}

static int make_image(lua_State *L, host *h)
{
    enum { TEXELS = 65536 }; /* that count as one thing more towards the next collection */
    char path[PATH_SIZE];
    daft_error error;
    const char *name = api_text(L, h, 1, "file");
    image_handle *i = lua_newuserdatauv(L, sizeof *i, 0);
    *i = (image_handle){.handle.id = ++h->images};
    api_set_type(L, API_IMAGE);
    if (host_find_file(h, name, path, sizeof path, &error)) i->what = daft_image_load(h->def.engine, path, &error);
    if (!i->what) api_engine_error(L, h, &error);
    h->made += 1 + (uint32_t)daft_image_width(i->what) * (uint32_t)daft_image_height(i->what) / TEXELS;
    return 1;
}

static daft_image *check_image(lua_State *L, host *h)
{
    return ((image_handle *)api_check_handle(L, h, 1, API_IMAGE, "image"))->what;
}

static int size_of_image(lua_State *L, host *h)
{
    const daft_image *image = check_image(L, h);
    lua_pushinteger(L, daft_image_width(image));
    lua_pushinteger(L, daft_image_height(image));
    return 2;
}

static float positive(lua_State *L, host *h, const char *name)
{
    const float value = api_float(L, h, -1, name);
    if (!(value > 0)) api_wrong(L, h, -1, name, "number above 0");
    return value;
}

/* {a, b, …}: so many numbers. */
static void numbers(lua_State *L, host *h, const char *name, int count, float *out)
{
    if (lua_type(L, -1) != LUA_TTABLE || lua_rawlen(L, -1) != (size_t)count)
        api_error(L, h, "%s: a list of %d numbers expected", name, count);
    for (int i = 0; i < count; i++) {
        lua_rawgeti(L, -1, i + 1);
        out[i] = api_float(L, h, -1, name);
        lua_pop(L, 1);
    }
}

static void read_source(lua_State *L, host *h, const daft_image *image, canvas_sprite *s)
{
    float v[4];
    numbers(L, h, "source", 4, v);
    const float width = (float)daft_image_width(image), height = (float)daft_image_height(image);
    if (!(v[0] >= 0) || !(v[1] >= 0) || !(v[2] > 0) || !(v[3] > 0) || v[0] + v[2] > width || v[1] + v[3] > height)
        api_error(L, h, "source: x, y, width and height within the image's %g x %g pixels expected", (double)width,
                  (double)height);
    s->source_x = v[0], s->source_y = v[1], s->source_width = s->width = v[2], s->source_height = s->height = v[3];
}

static void read_sprite(lua_State *L, host *h, const daft_image *image, canvas_sprite *s)
{
    static const char *const FIELDS[] = {"source", "scale",  "width",  "height", "rotation",
                                         "origin", "border", "smooth", "color"};
    float origin[2];
    api_fields(L, h, 4, "style", FIELDS, COUNT_OF(FIELDS));
    if (api_field(L, 4, "source")) read_source(L, h, image, s);
    if (api_field(L, 4, "scale")) s->scale = positive(L, h, "scale");
    s->width *= s->scale, s->height *= s->scale;
    if (api_field(L, 4, "width")) s->width = positive(L, h, "width");
    if (api_field(L, 4, "height")) s->height = positive(L, h, "height");
    if (api_field(L, 4, "rotation")) s->rotation = api_float(L, h, -1, "rotation");
    if (api_field(L, 4, "border")) s->border = positive(L, h, "border");
    if (api_field(L, 4, "smooth")) s->smooth = api_boolean(L, h, -1, "smooth");
    if (api_field(L, 4, "color")) s->tint = api_hud_color(L, h, -1, "color");
    if (!api_field(L, 4, "origin")) return;
    numbers(L, h, "origin", 2, origin);
    s->origin_x = origin[0], s->origin_y = origin[1];
}

static int draw_image(lua_State *L, host *h)
{
    const daft_image *image = check_image(L, h);
    const float x = api_float(L, h, 2, "x"), y = api_float(L, h, 3, "y");
    canvas_sprite s = canvas_default_sprite(image);
    if (!lua_isnoneornil(L, 4)) read_sprite(L, h, image, &s);
    canvas_draw_sprite(h->picture, image, x, y, &s);
    return 0;
}

/* ---- shapes ---- */

typedef struct style {
    canvas_color color;
    float width; /* of the line; 0: filled */
    bool closed;
} style;

/* A colour, or a table of what is named. */
static style read_style(lua_State *L, host *h, int index, float width)
{
    static const char *const FIELDS[] = {"color", "width", "closed"};
    style s = {WHITE, width, false};
    if (lua_isnoneornil(L, index)) return s;
    const bool table = lua_type(L, index) == LUA_TTABLE && lua_rawlen(L, index) == 0 && !api_has_field(L, index, "r");
    if (!table) {
        s.color = api_hud_color(L, h, index, "color");
        return s;
    }
    api_fields(L, h, index, "style", FIELDS, COUNT_OF(FIELDS));
    if (api_field(L, index, "color")) s.color = api_hud_color(L, h, -1, "color");
    if (api_field(L, index, "width")) s.width = positive(L, h, "width");
    if (api_field(L, index, "closed")) s.closed = api_boolean(L, h, -1, "closed");
    return s;
}

static int rect(lua_State *L, host *h)
{
    const float x = api_float(L, h, 1, "x"), y = api_float(L, h, 2, "y");
    const float w = api_float(L, h, 3, "width"), tall = api_float(L, h, 4, "height");
    const style s = read_style(L, h, 5, 0);
    const canvas_point corners[] = {{x, y}, {x + w, y}, {x + w, y + tall}, {x, y + tall}};
    if (s.width > 0)
        canvas_line(h->picture, corners, 4, true, s.width, s.color);
    else
        canvas_rect(h->picture, x, y, w, tall, s.color);
    return 0;
}

static int circle(lua_State *L, host *h)
{
    const float x = api_float(L, h, 1, "x"), y = api_float(L, h, 2, "y"), radius = api_float(L, h, 3, "radius");
    const style s = read_style(L, h, 4, 0);
    canvas_circle(h->picture, x, y, radius, s.width, s.color);
    return 0;
}

enum { MOST_POINTS = 1024 };

/* {x, y, x, y, …} */
static size_t read_points(lua_State *L, host *h, int index, size_t least, canvas_point *out)
{
    if (lua_type(L, index) != LUA_TTABLE) api_wrong(L, h, index, "points", "list of numbers {x, y, x, y, ...}");
    const size_t count = lua_rawlen(L, index);
    if (count % 2 != 0 || count < 2 * least || count > 2 * (size_t)MOST_POINTS)
        api_error(L, h, "points: %d to %d of two numbers each expected, got %d numbers", (int)least, (int)MOST_POINTS,
                  (int)count);
    for (size_t i = 0; i < count; i++) {
        lua_rawgeti(L, index, (lua_Integer)i + 1);
        const float value = api_float(L, h, -1, "points");
        lua_pop(L, 1);
        *(i % 2 ? &out[i / 2].y : &out[i / 2].x) = value;
    }
    return count / 2;
}

static int polygon(lua_State *L, host *h)
{
    canvas_point points[MOST_POINTS];
    const size_t count = read_points(L, h, 1, 3, points);
    const style s = read_style(L, h, 2, 0);
    if (s.width > 0)
        canvas_line(h->picture, points, count, true, s.width, s.color);
    else
        canvas_polygon(h->picture, points, count, s.color);
    return 0;
}

static int line(lua_State *L, host *h)
{
    canvas_point points[MOST_POINTS];
    const bool list = lua_type(L, 1) == LUA_TTABLE;
    size_t count = 2;
    if (list)
        count = read_points(L, h, 1, 2, points);
    else
        for (int i = 0; i < 2; i++)
            points[i] = (canvas_point){api_float(L, h, 1 + 2 * i, i ? "x2" : "x1"),
                                       api_float(L, h, 2 + 2 * i, i ? "y2" : "y1")};
    const style s = read_style(L, h, list ? 2 : 5, 2);
    canvas_line(h->picture, points, count, s.closed, s.width, s.color);
    return 0;
}

/* ---- where it is drawn ---- */

static int clip(lua_State *L, host *h)
{
    if (lua_isnone(L, 1)) {
        canvas_unclip(h->picture);
        return 0;
    }
    const float x = api_float(L, h, 1, "x"), y = api_float(L, h, 2, "y");
    const float w = api_float(L, h, 3, "width"), tall = api_float(L, h, 4, "height");
    canvas_clip(h->picture, x, y, w, tall);
    return 0;
}

static int fixed_canvas(lua_State *L, host *h)
{
    float width = canvas_hud_width(h->picture), tall = CANVAS_HEIGHT;
    canvas_reset(h->picture);
    if (!lua_isnone(L, 1)) {
        width = api_float(L, h, 1, "width"), tall = api_float(L, h, 2, "height");
        if (!(width >= 1) || !(tall >= 1) || width > 1e5f || tall > 1e5f)
            api_error(L, h, "a width and a height of 1 to 100000 expected, got %g and %g", (double)width, (double)tall);
        canvas_fit(h->picture, width, tall);
    }
    const float unit = (float)h->picture->height / CANVAS_HEIGHT;
    return api_push_numbers(L, (double)(h->picture->origin_x / unit), (double)(h->picture->origin_y / unit),
                            (double)(h->picture->unit / unit));
}

static const api_function FUNCTIONS[] = {
    {"rect", "(x, y, width, height [, color or {color =, width =}])",
     "A filled rectangle; \"#rrggbbaa\" shines through. With a width, its outline.", rect, API_DRAWS},
    {"line", "(x1, y1, x2, y2 [, color or {color =, width =}])",
     "2 wide where nothing else is said. Or through many points: daft.line({x, y, x, y, ...}, {closed = true}).", line,
     API_DRAWS},
    {"circle", "(x, y, radius [, color or {color =, width =}])", "A disc; with a width, a ring.", circle, API_DRAWS},
    {"polygon", "({x, y, x, y, ...} [, color or {color =, width =}])",
     "Fills what 3 to 1024 points enclose; with a width, its outline.", polygon, API_DRAWS},
    {"image", "(file) -> image", "A picture file of the game's, to be drawn by image:draw.", make_image, API_CHANGES},
    {"image:draw",
     "(x, y [, {scale =, width =, height =, rotation =, origin =, source =, border =, color =, smooth =}])",
     "A pixel of it is a unit, times the scale; or it is as large as width and height say. rotation: radians "
     "clockwise\n"
     "about the origin, which is put at x, y: {0, 0} is the top left, {0.5, 0.5} the middle. source: {x, y, width,\n"
     "height} in its pixels. border: so many of its pixels at the edges are not stretched (nine patches). color\n"
     "multiplies it; smooth = false keeps its pixels square.",
     draw_image, API_DRAWS},
    {"image:size", "() -> width, height", "In pixels.", size_of_image, 0},
    {"clip", "([x, y, width, height])", "Nothing is drawn outside from here on; without numbers, everywhere again.",
     clip, API_DRAWS},
    {"canvas", "([width, height]) -> left, top, scale",
     "From here on coordinates go from 0, 0 to width, height, as large as fits, in the middle of the picture. Its "
     "left\n"
     "top and a unit in the picture's units come back: ((mouse x) - left) / scale. Without numbers: as at the start.",
     fixed_canvas, API_DRAWS},
};

const api_area api_draw = {"Images and shapes", FUNCTIONS, COUNT_OF(FUNCTIONS)};
