/* daft.text and its kin: drawing over the picture, within daft.draw. */
#include "lua/api.h"

#include "common/util.h"

#include <string.h>

static const float DEFAULT_SIZE = 28;

static const char *const STYLE_FIELDS[] = {"size", "color", "align", "shadow"};
static const char *const ALIGNMENTS[] = {"left", "center", "right"};

static float read_size(lua_State *L, host *h, int index)
{
    float size = api_float(L, h, index, "size");
    if (!(size > 0) || size > 720) api_wrong(L, h, index, "size", "number above 0, up to 720");
    return size;
}

enum { LONGEST_TEXT = 16384 }; /* bytes: nobody can see more at once, and each glyph takes its time */

/* A string, or a number as text. */
static const char *read_shown(lua_State *L, host *h, int index)
{
    if (lua_type(L, index) == LUA_TNUMBER) return lua_tostring(L, index);
    if (lua_type(L, index) == LUA_TSTRING && lua_rawlen(L, index) > LONGEST_TEXT)
        api_error(L, h, "text: %d bytes at most expected, got %zu", (int)LONGEST_TEXT, (size_t)lua_rawlen(L, index));
    return api_text(L, h, index, "text");
}

static int text(lua_State *L, host *h)
{
    const char *shown = read_shown(L, h, 1);
    float x = api_float(L, h, 2, "x"), y = api_float(L, h, 3, "y");
    text_style style = {DEFAULT_SIZE, {255, 255, 255, 255}, TEXT_LEFT, true};
    if (!lua_isnoneornil(L, 4)) {
        api_fields(L, h, 4, "style", STYLE_FIELDS, COUNT_OF(STYLE_FIELDS));
        if (api_field(L, 4, "size")) style.size = read_size(L, h, -1);
        if (api_field(L, 4, "color")) style.color = api_hud_color(L, h, -1, "color");
        if (api_field(L, 4, "align"))
            style.align = (text_align)api_choice(L, h, -1, "align", ALIGNMENTS, COUNT_OF(ALIGNMENTS));
        if (api_field(L, 4, "shadow")) style.shadow = api_boolean(L, h, -1, "shadow");
    }
    text_draw(h->picture, h->def.face, shown, x, y, &style);
    return 0;
}

static int width_of_text(lua_State *L, host *h)
{
    const char *shown = read_shown(L, h, 1);
    float size = lua_isnoneornil(L, 2) ? DEFAULT_SIZE : read_size(L, h, 2);
    lua_pushnumber(L, (double)text_width(h->def.face, shown, size));
    return 1;
}

static int rect(lua_State *L, host *h)
{
    float x = api_float(L, h, 1, "x"), y = api_float(L, h, 2, "y");
    float w = api_float(L, h, 3, "width"), tall = api_float(L, h, 4, "height");
    canvas_color color = {255, 255, 255, 255};
    if (!lua_isnoneornil(L, 5)) color = api_hud_color(L, h, 5, "color");
    canvas_rect(h->picture, x, y, w, tall, color);
    return 0;
}

static int width(lua_State *L, host *h)
{
    lua_pushnumber(L, (double)h->hud_width);
    return 1;
}

static int height(lua_State *L, host *h)
{
    (void)h;
    lua_pushnumber(L, CANVAS_HEIGHT);
    return 1;
}

static const api_function FUNCTIONS[] = {
    {"text", "(string, x, y [, {size =, color =, align =, shadow =}])",
     "Within daft.draw. align is \"left\", \"center\" or \"right\" of x; y is the top. size 28, white, with a shadow.\n"
     "The string has at most 16384 bytes.",
     text, API_DRAWS},
    {"rect", "(x, y, width, height [, color])", "A filled rectangle; \"#rrggbbaa\" shines through.", rect, API_DRAWS},
    {"text_width", "(string [, size]) -> number", "Of the widest line.", width_of_text, 0},
    {"width", "() -> number", "The picture is 720 units high and as wide as its shape makes it.", width, 0},
    {"height", "() -> 720", "The picture's height in units.", height, 0},
};

const api_area api_hud = {"Drawing over the picture", FUNCTIONS, COUNT_OF(FUNCTIONS)};
