/* Reading arguments: each reader names the argument, what it wanted and what it got. */
#include "lua/api.h"

#include "common/util.h"

#include <ctype.h>
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

double api_number(lua_State *L, host *h, int index, const char *what)
{
    if (lua_type(L, index) != LUA_TNUMBER) api_wrong(L, h, index, what, "number");
    double value = lua_tonumber(L, index);
    if (!isfinite(value)) api_wrong(L, h, index, what, "finite number");
    return value;
}

float api_float(lua_State *L, host *h, int index, const char *what)
{
    double value = api_number(L, h, index, what);
    if (fabs(value) > (double)FLT_MAX) api_wrong(L, h, index, what, "number below 3.4e38");
    return (float)value;
}

lua_Integer api_whole(lua_State *L, host *h, int index, const char *what)
{
    int whole;
    lua_Integer value = lua_type(L, index) == LUA_TNUMBER ? lua_tointegerx(L, index, &whole) : (whole = 0);
    if (!whole) api_wrong(L, h, index, what, "whole number");
    return value;
}

bool api_boolean(lua_State *L, host *h, int index, const char *what)
{
    if (!lua_isboolean(L, index)) api_wrong(L, h, index, what, "true or false");
    return lua_toboolean(L, index);
}

const char *api_text(lua_State *L, host *h, int index, const char *what)
{
    if (lua_type(L, index) != LUA_TSTRING) api_wrong(L, h, index, what, "string");
    size_t length;
    const char *text = lua_tolstring(L, index, &length);
    if (strlen(text) != length) api_error(L, h, "%s: the string has a zero byte in it", what);
    return text;
}

/* The numbers of a table: by place, or by the letters of `names`. False when it is not such a table. */
static bool read_numbers(lua_State *L, int index, const char *names, int count, double *out)
{
    index = lua_absindex(L, index);
    if (lua_type(L, index) != LUA_TTABLE) return false;
    bool by_place = lua_rawlen(L, index) > 0;
    if (by_place && lua_rawlen(L, index) != (size_t)count) return false;
    for (int i = 0; i < count; i++) {
        if (by_place) {
            lua_rawgeti(L, index, i + 1);
        } else {
            lua_pushlstring(L, names + i, 1);
            lua_rawget(L, index);
        }
        bool good = lua_type(L, -1) == LUA_TNUMBER && isfinite(lua_tonumber(L, -1));
        out[i] = lua_tonumber(L, -1);
        lua_pop(L, 1);
        if (!good) return false;
    }
    return true;
}

daft_dvec3 api_dvec3(lua_State *L, host *h, int index, const char *what)
{
    double v[3];
    if (!read_numbers(L, index, "xyz", 3, v)) api_wrong(L, h, index, what, "{x, y, z}");
    return (daft_dvec3){v[0], v[1], v[2]};
}

static daft_vec3 to_float(lua_State *L, host *h, daft_dvec3 v, const char *what)
{
    if (fabs(v.x) > (double)FLT_MAX || fabs(v.y) > (double)FLT_MAX || fabs(v.z) > (double)FLT_MAX)
        api_error(L, h, "%s: numbers below 3.4e38 expected", what);
    return (daft_vec3){(float)v.x, (float)v.y, (float)v.z};
}

daft_vec3 api_vec3(lua_State *L, host *h, int index, const char *what)
{
    return to_float(L, h, api_dvec3(L, h, index, what), what);
}

static daft_dvec3 three_numbers(lua_State *L, host *h, int index, const char *what)
{
    if (lua_type(L, index) != LUA_TNUMBER) return api_dvec3(L, h, index, what);
    return (daft_dvec3){api_number(L, h, index, what), api_number(L, h, index + 1, what),
                        api_number(L, h, index + 2, what)};
}

daft_dvec3 api_place(lua_State *L, host *h, int index, const char *what)
{
    const api_handle *handle = lua_type(L, index) == LUA_TUSERDATA ? api_test_handle(L, index, API_ENTITY) : NULL;
    if (!handle) return three_numbers(L, h, index, what);
    daft_transform transform;
    daft_error error;
    if (!daft_entity_get_world_transform(h->def.scene, (daft_entity){handle->id}, &transform, &error))
        api_engine_error(L, h, &error);
    return transform.position;
}

daft_vec3 api_triple(lua_State *L, host *h, int index, const char *what)
{
    return to_float(L, h, three_numbers(L, h, index, what), what);
}

/* ---- colours ---- */

static double srgb_to_linear(double encoded)
{
    return encoded <= 0.04045 ? encoded / 12.92 : daft_pow((encoded + 0.055) / 1.055, 2.4);
}

static uint8_t linear_to_srgb_byte(double linear)
{
    double value = linear <= 0.0031308 ? linear * 12.92 : 1.055 * daft_pow(linear < 1 ? linear : 1, 1 / 2.4) - 0.055;
    return (uint8_t)(value <= 0 ? 0 : value >= 1 ? 255 : value * 255 + 0.5);
}

/* "#rgb", "#rrggbb" or "#rrggbbaa". False when it is none of these. */
static bool parse_hex(const char *text, bool with_alpha, uint8_t out[4])
{
    size_t length = strlen(text);
    if (text[0] != '#' || (length != 4 && length != 7 && !(with_alpha && length == 9))) return false;
    for (size_t i = 1; i < length; i++)
        if (!isxdigit((unsigned char)text[i])) return false;
    out[3] = 255;
    size_t digits = length == 4 ? 1 : 2;
    for (size_t i = 0; 1 + i * digits < length; i++) {
        char pair[3] = {text[1 + i * digits], text[i * digits + digits], 0};
        unsigned value = 0;
        sscanf(pair, "%x", &value);
        out[i] = (uint8_t)value;
    }
    return true;
}

static const char COLOR_FORM[] = "\"#rgb\", \"#rrggbb\" or {r, g, b}";

daft_vec3 api_color(lua_State *L, host *h, int index, const char *what)
{
    uint8_t bytes[4];
    double v[3];
    if (lua_type(L, index) == LUA_TSTRING) {
        if (!parse_hex(lua_tostring(L, index), false, bytes)) api_wrong(L, h, index, what, COLOR_FORM);
        for (int i = 0; i < 3; i++) v[i] = srgb_to_linear(bytes[i] / 255.0);
    } else if (!read_numbers(L, index, "rgb", 3, v)) {
        api_wrong(L, h, index, what, COLOR_FORM);
    }
    if (v[0] < 0 || v[1] < 0 || v[2] < 0) api_error(L, h, "%s: a colour cannot be negative", what);
    return to_float(L, h, (daft_dvec3){v[0], v[1], v[2]}, what);
}

canvas_color api_hud_color(lua_State *L, host *h, int index, const char *what)
{
    uint8_t bytes[4];
    double v[4] = {0, 0, 0, 1};
    if (lua_type(L, index) == LUA_TSTRING && parse_hex(lua_tostring(L, index), true, bytes))
        return (canvas_color){bytes[0], bytes[1], bytes[2], bytes[3]};
    if (!read_numbers(L, index, "rgba", 4, v)) {
        v[3] = 1;
        if (!read_numbers(L, index, "rgb", 3, v))
            api_wrong(L, h, index, what, "\"#rgb\", \"#rrggbb\", \"#rrggbbaa\", {r, g, b} or {r, g, b, a}");
    }
    double alpha = v[3] < 0 ? 0 : v[3] > 1 ? 1 : v[3];
    return (canvas_color){linear_to_srgb_byte(v[0]), linear_to_srgb_byte(v[1]), linear_to_srgb_byte(v[2]),
                          (uint8_t)(alpha * 255 + 0.5)};
}

/* ---- rotations ---- */

static daft_quat quat_mul(daft_quat a, daft_quat b)
{
    return (daft_quat){a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y, a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
                       a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w, a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z};
}

/* The camera's angles: what faces +X faces where a camera of this yaw and pitch looks. Yaw turns from +X to +Z, which
 * is a negative turn about Y; pitch down is a negative turn about Z; roll to the right a positive one about X. */
daft_quat api_quat_from_angles(double yaw, double pitch, double roll)
{
    daft_quat y = {0, (float)-daft_sin(yaw / 2), 0, (float)daft_cos(yaw / 2)};
    daft_quat p = {0, 0, (float)-daft_sin(pitch / 2), (float)daft_cos(pitch / 2)};
    daft_quat r = {(float)daft_sin(roll / 2), 0, 0, (float)daft_cos(roll / 2)};
    return quat_mul(quat_mul(y, p), r);
}

daft_quat api_rotation(lua_State *L, host *h, int index, const char *what)
{
    double v[4];
    static const char form[] = "{yaw, pitch, roll} or a quaternion {x, y, z, w}";
    if (read_numbers(L, index, "xyzw", 4, v)) {
        double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2] + v[3] * v[3]);
        if (!(length > 1e-30) || !isfinite(length)) api_error(L, h, "%s: a quaternion of length %g", what, length);
        return (daft_quat){(float)(v[0] / length), (float)(v[1] / length), (float)(v[2] / length),
                           (float)(v[3] / length)};
    }
    if (lua_type(L, index) != LUA_TTABLE || lua_rawlen(L, index) != 3 || !read_numbers(L, index, "ypr", 3, v))
        api_wrong(L, h, index, what, form);
    for (int i = 0; i < 3; i++)
        if (fabs(v[i]) > 1e6) api_error(L, h, "%s: angles up to a million radians expected", what);
    return api_quat_from_angles(v[0], v[1], v[2]);
}

/* ---- names ---- */

size_t api_choice(lua_State *L, host *h, int index, const char *what, const char *const *names, size_t count)
{
    const char *text = lua_type(L, index) == LUA_TSTRING ? lua_tostring(L, index) : NULL;
    for (size_t i = 0; text && i < count; i++)
        if (strcmp(text, names[i]) == 0) return i;
    char list[300] = "";
    for (size_t i = 0; i < count; i++) {
        size_t used = strlen(list);
        snprintf(list + used, sizeof list - used, "%s\"%s\"", i == 0 ? "" : i + 1 == count ? " or " : ", ", names[i]);
    }
    const char *near = text ? nearest_name(text, names, count) : NULL;
    if (near) api_error(L, h, "%s: %s expected, got the string '%s': did you mean \"%s\"?", what, list, text, near);
    api_wrong(L, h, index, what, list);
}

int api_key(lua_State *L, host *h, int index, const char *what)
{
    const char *name = api_text(L, h, index, what);
    int key = input_key_find(name);
    if (key >= 0) return key;
    size_t count;
    const char *const *names = input_key_names(&count);
    const char *near = nearest_name(name, names, count);
    if (near) api_error(L, h, "%s: there is no key '%s': did you mean '%s'?", what, name, near);
    api_error(L, h, "%s: there is no key '%s': they are named as in \"a\", \"left\", \"space\", \"left shift\"", what,
              name);
}

/* What has a material has its colour from it. */
static bool is_color_of_material(const char *key, const char *const *names, size_t count)
{
    if (strcmp(key, "color") != 0 && strcmp(key, "colour") != 0) return false;
    for (size_t i = 0; i < count; i++)
        if (strcmp(names[i], "material") == 0) return true;
    return false;
}

void api_fields(lua_State *L, host *h, int index, const char *what, const char *const *names, size_t count)
{
    index = lua_absindex(L, index);
    if (lua_type(L, index) != LUA_TTABLE) api_wrong(L, h, index, what ? what : "its argument", "table {...}");
    const char *before = what ? what : "", *colon = what ? ": " : "";
    for (lua_pushnil(L); lua_next(L, index); lua_pop(L, 1)) {
        if (lua_type(L, -2) != LUA_TSTRING)
            api_error(L, h, "%s%sfields with names expected, got one with a %s", before, colon, luaL_typename(L, -2));
        const char *key = lua_tostring(L, -2);
        bool known = false;
        for (size_t i = 0; i < count && !known; i++) known = strcmp(key, names[i]) == 0;
        if (known) continue;
        const char *near = nearest_name(key, names, count);
        if (near) api_error(L, h, "%s%sthere is no '%s': did you mean '%s'?", before, colon, key, near);
        if (is_color_of_material(key, names, count))
            api_error(L, h, "%s%sthere is no '%s': a colour is a material, as in material = \"#ff8800\"", before, colon,
                      key);
        api_error(L, h, "%s%sthere is no '%s'", before, colon, key);
    }
}

bool api_field(lua_State *L, int table, const char *name)
{
    table = lua_absindex(L, table);
    lua_pushstring(L, name);
    if (lua_rawget(L, table) != LUA_TNIL) return true;
    lua_pop(L, 1);
    return false;
}

bool api_has_field(lua_State *L, int table, const char *name)
{
    bool has = api_field(L, table, name);
    if (has) lua_pop(L, 1);
    return has;
}

int api_push_vec3(lua_State *L, double x, double y, double z)
{
    lua_createtable(L, 3, 0);
    lua_pushnumber(L, x);
    lua_rawseti(L, -2, 1);
    lua_pushnumber(L, y);
    lua_rawseti(L, -2, 2);
    lua_pushnumber(L, z);
    lua_rawseti(L, -2, 3);
    return 1;
}

int api_push_numbers(lua_State *L, double x, double y, double z)
{
    lua_pushnumber(L, x);
    lua_pushnumber(L, y);
    lua_pushnumber(L, z);
    return 3;
}

/* ---- tables that are used again ---- */

void api_push_out(lua_State *L, host *h, int into, const char *what)
{
    if (lua_isnoneornil(L, into)) {
        lua_newtable(L);
        return;
    }
    if (!lua_istable(L, into)) api_wrong(L, h, into, what, "table to fill");
    lua_pushvalue(L, into);
}

void api_push_item(lua_State *L, lua_Integer i)
{
    if (lua_rawgeti(L, -1, i) == LUA_TTABLE) return;
    lua_pop(L, 1);
    lua_newtable(L);
    lua_pushvalue(L, -1);
    lua_rawseti(L, -3, i);
}

void api_set_vec3(lua_State *L, const char *name, double x, double y, double z)
{
    const double v[3] = {x, y, z};
    lua_pushstring(L, name);
    if (lua_rawget(L, -2) != LUA_TTABLE) {
        lua_pop(L, 1);
        api_push_vec3(L, x, y, z);
        lua_setfield(L, -2, name);
        return;
    }
    for (int i = 0; i < 3; i++) {
        lua_pushnumber(L, v[i]);
        lua_rawseti(L, -2, i + 1);
    }
    lua_pop(L, 1);
}

void api_end_list(lua_State *L, lua_Integer count)
{
    for (lua_Integer i = (lua_Integer)lua_rawlen(L, -1); i > count; i--) {
        lua_pushnil(L);
        lua_rawseti(L, -2, i);
    }
}

void *api_scratch(lua_State *L, size_t size)
{
    static const char KEY;
    const bool is_there = lua_rawgetp(L, LUA_REGISTRYINDEX, &KEY) == LUA_TUSERDATA;
    if (is_there && lua_rawlen(L, -1) >= size) {
        void *memory = lua_touserdata(L, -1);
        lua_pop(L, 1);
        return memory;
    }
    const size_t before = is_there ? lua_rawlen(L, -1) : 0;
    lua_pop(L, 1);
    void *memory = lua_newuserdatauv(L, size > 2 * before ? size : 2 * before, 0);
    lua_rawsetp(L, LUA_REGISTRYINDEX, &KEY);
    return memory;
}
