/* daft.mesh{text =}: letters in 3D.
 *
 * A text that was made is kept with its mesh until nothing holds that: a table from descriptions to handles, which
 * holds them between collections (api_collect) and lets go in one of those that the game does not hold. So what is
 * found there does not depend on when Lua collects. */
#include "lua/api.h"

#include "common/util.h"
#include "hud/letters.h"

#include <stdio.h>

/* Registry key of the table. */
static const char LETTERS_KEY;

enum {
    LONGEST_TEXT = 512, /* bytes */
    TRIANGLES = 2048    /* that count as one thing more towards the next collection */
};

static const char *const FIELDS[] = {"text", "size", "depth", "align", "font"};
static const char *const ALIGNMENTS[] = {"left", "center", "right"};

typedef struct description {
    const char *text;
    size_t length;
    float size, depth;
    text_align align;
    font *face;
    uint32_t font; /* the handle's number; 0: the program's own */
} description;

static float read_length(lua_State *L, host *h, const char *name)
{
    const float value = api_float(L, h, -1, name);
    if (!(value >= 1e-3f) || value > 1e4f) api_wrong(L, h, -1, name, "number from 0.001 to 10000");
    return value;
}

static description read_description(lua_State *L, host *h, int table)
{
    description d = {.size = 1, .align = TEXT_CENTER, .face = h->def.face};
    api_fields(L, h, table, "mesh", FIELDS, COUNT_OF(FIELDS));
    if (api_field(L, table, "size")) d.size = read_length(L, h, "size");
    d.depth = d.size / 5;
    if (api_field(L, table, "depth")) d.depth = read_length(L, h, "depth");
    if (api_field(L, table, "align"))
        d.align = (text_align)api_choice(L, h, -1, "align", ALIGNMENTS, COUNT_OF(ALIGNMENTS));
    if (api_field(L, table, "font")) {
        d.face = api_font_at(L, h, -1);
        d.font = api_check_handle(L, h, -1, API_FONT, "font")->id;
    }
    api_field(L, table, "text");
    d.text = lua_type(L, -1) == LUA_TNUMBER ? lua_tostring(L, -1) : api_text(L, h, -1, "text");
    d.length = lua_rawlen(L, -1);
    if (d.length > LONGEST_TEXT)
        api_error(L, h, "text: %d bytes at most expected, got %zu", (int)LONGEST_TEXT, d.length);
    return d;
}

static void push_table(lua_State *L)
{
    if (lua_rawgetp(L, LUA_REGISTRYINDEX, &LETTERS_KEY) == LUA_TTABLE) return;
    lua_pop(L, 1);
    lua_newtable(L);
    lua_pushvalue(L, -1);
    lua_rawsetp(L, LUA_REGISTRYINDEX, &LETTERS_KEY);
}

/* Into the handle on top. */
static void make_mesh(lua_State *L, host *h, const description *d, api_handle *handle)
{
    letters l;
    daft_error error;
    daft_mesh_info info;
    bool done = letters_make(&l, d->face, d->text, d->size, d->align, &error);
    if (done) {
        daft_extrude_def def = daft_default_extrude_def();
        def.points = l.points, def.counts = l.counts, def.depth = d->depth;
        def.point_count = l.point_count, def.contour_count = l.contour_count;
        if (l.contour_count > 0)
            handle->id = daft_mesh_extrude(h->def.scene, &def, &error).id;
        else
            fail(&error, DAFT_ERROR_ARGUMENT, "text: something to see expected, got blanks");
        done = handle->id != 0 && daft_mesh_get_info(h->def.scene, (daft_mesh){handle->id}, &info, &error);
        letters_free(&l);
    }
    if (!done) api_engine_error(L, h, &error);
    h->made += 1 + info.triangle_count / TRIANGLES;
}

int api_push_letters(lua_State *L, host *h, int table)
{
    char key[LONGEST_TEXT + 160];
    const description d = read_description(L, h, table);
    const int size =
        snprintf(key, sizeof key, "%a %a %d %u %s", (double)d.size, (double)d.depth, (int)d.align, d.font, d.text);
    push_table(L);
    lua_pushlstring(L, key, (size_t)size);
    if (lua_rawget(L, -2) == LUA_TUSERDATA) return 1;
    lua_pop(L, 1);
    make_mesh(L, h, &d, api_new_handle(L, API_MESH, 0));
    lua_pushlstring(L, key, (size_t)size);
    lua_pushvalue(L, -2);
    lua_rawset(L, -4);
    return 1;
}

void api_begin_letters_collection(lua_State *L)
{
    push_table(L);
    lua_createtable(L, 0, 1);
    lua_pushliteral(L, "v");
    lua_setfield(L, -2, "__mode");
    lua_setmetatable(L, -2);
    lua_pop(L, 1);
}

void api_end_letters_collection(lua_State *L)
{
    push_table(L);
    lua_pushnil(L);
    lua_setmetatable(L, -2);
    lua_pop(L, 1);
}
