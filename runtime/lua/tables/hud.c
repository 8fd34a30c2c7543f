/* daft.text, daft.font and their kin: drawing over the picture, within daft.draw. */
#include "lua/api.h"

#include "common/util.h"

#include <string.h>

static const float DEFAULT_SIZE = 28;

static const char *const STYLE_FIELDS[] = {"size", "color", "align", "shadow", "font", "width"};
static const char *const ALIGNMENTS[] = {"left", "center", "right"};

/* ---- fonts ---- */

typedef struct font_handle {
    api_handle handle;
    font *face;
} font_handle;

int api_release_font(lua_State *L)
{
    font_handle *f = lua_touserdata(L, 1);
    if (api_host(L)->def.keep_font)
        font_uncount(f->face);
    else
        font_close(f->face);
    f->face = NULL;
    return 0;
}

static int make_font(lua_State *L, host *h)
{
    enum { COUNTS_AS = 16 }; /* towards the next collection: a font holds megabytes */
    char path[PATH_SIZE];
    daft_error error;
    const char *name = api_text(L, h, 1, "file");
    font_handle *f = lua_newuserdatauv(L, sizeof *f, 0);
    *f = (font_handle){.handle.id = ++h->fonts};
    api_set_type(L, API_FONT);
    if (host_find_file(h, name, path, sizeof path, &error))
        f->face = font_open(h->def.engine, h->def.files, path, name, &error);
    if (!f->face) api_engine_error(L, h, &error);
    if (h->def.keep_font) h->def.keep_font(h->def.keeper, f->face);
    h->made += COUNTS_AS;
    return 1;
}

font *api_font_at(lua_State *L, host *h, int index)
{
    if (lua_isnoneornil(L, index)) return h->def.face;
    return ((font_handle *)api_check_handle(L, h, index, API_FONT, "font"))->face;
}

/* ---- text ---- */

static float read_size(lua_State *L, host *h, int index)
{
    float size = api_float(L, h, index, "size");
    if (!(size > 0) || size > 720) api_wrong(L, h, index, "size", "number above 0, up to 720");
    return size;
}

static float read_width(lua_State *L, host *h, int index)
{
    float width = api_float(L, h, index, "width");
    if (!(width > 0)) api_wrong(L, h, index, "width", "number above 0");
    return width;
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
    float x = api_float(L, h, 2, "x"), y = api_float(L, h, 3, "y"), wrap = 0;
    text_style style = {DEFAULT_SIZE, {255, 255, 255, 255}, TEXT_LEFT, true};
    font *face = h->def.face;
    if (!lua_isnoneornil(L, 4)) {
        api_fields(L, h, 4, "style", STYLE_FIELDS, COUNT_OF(STYLE_FIELDS));
        if (api_field(L, 4, "size")) style.size = read_size(L, h, -1);
        if (api_field(L, 4, "color")) style.color = api_hud_color(L, h, -1, "color");
        if (api_field(L, 4, "align"))
            style.align = (text_align)api_choice(L, h, -1, "align", ALIGNMENTS, COUNT_OF(ALIGNMENTS));
        if (api_field(L, 4, "shadow")) style.shadow = api_boolean(L, h, -1, "shadow");
        if (api_field(L, 4, "font")) face = api_font_at(L, h, -1);
        if (api_field(L, 4, "width")) wrap = read_width(L, h, -1);
    }
    if (wrap > 0)
        text_draw_wrapped(h->picture, face, shown, x, y, wrap, &style);
    else
        text_draw(h->picture, face, shown, x, y, &style);
    return 0;
}

static int width_of_text(lua_State *L, host *h)
{
    const char *shown = read_shown(L, h, 1);
    float size = lua_isnoneornil(L, 2) ? DEFAULT_SIZE : read_size(L, h, 2);
    lua_pushnumber(L, (double)text_width(api_font_at(L, h, 3), shown, size));
    return 1;
}

static int height_of_text(lua_State *L, host *h)
{
    const char *shown = read_shown(L, h, 1);
    const float width = read_width(L, h, 2);
    const text_style style = {.size = lua_isnoneornil(L, 3) ? DEFAULT_SIZE : read_size(L, h, 3)};
    lua_pushnumber(L, (double)text_draw_wrapped(NULL, api_font_at(L, h, 4), shown, 0, 0, width, &style));
    return 1;
}

/* ---- the rest ---- */

static int width(lua_State *L, host *h)
{
    lua_pushnumber(L, (double)host_width(h));
    return 1;
}

static int height(lua_State *L, host *h)
{
    (void)h;
    lua_pushnumber(L, CANVAS_HEIGHT);
    return 1;
}

static const api_function FUNCTIONS[] = {
    {"text", "(string, x, y [, {size =, color =, align =, shadow =, font =, width =}])",
     "Within daft.draw. align is \"left\", \"center\" or \"right\" of x; y is the top. size 28, white, with a shadow.\n"
     "With a width, lines are broken at blanks. The string has at most 16384 bytes of UTF-8; bytes that are none show\n"
     "as boxes, and so do letters that the font does not have.",
     text, API_DRAWS},
    {"font", "(file) -> font",
     "A TrueType file (.ttf) of the game's, for daft.text{font =}. The program's own font has Latin, Greek and\n"
     "Cyrillic letters. It holds the file and 4 MB while the game holds it.",
     make_font, API_CHANGES},
    {"text_width", "(string [, size [, font]]) -> number", "Of the widest line.", width_of_text, 0},
    {"text_height", "(string, width [, size [, font]]) -> number", "Of the lines that it is broken into.",
     height_of_text, 0},
    {"width", "() -> number", "The picture is 720 units high and as wide as its shape makes it. Recorded.", width, 0},
    {"height", "() -> 720", "The picture's height in units.", height, 0},
};

const api_area api_hud = {"Text over the picture", FUNCTIONS, COUNT_OF(FUNCTIONS)};
