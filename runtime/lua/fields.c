/* Between tables of Lua and structs of daft.h, by the structs' lists of fields. */
#include "lua/fields.h"

#include "common/util.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

enum { MAX_NAMES = 64 };

/* ---- which names ---- */

static const api_list *list_of(const api_form *form)
{
    if (form == &api_synth_form) return &api_synth_list;
    if (form == &api_voice_form) return &api_voice_list;
    return form == &api_particles_form ? &api_particles_list : NULL;
}

static const daft_field *fields_of(const api_form *form, uint32_t *count)
{
    const api_list *own = list_of(form);
    if (!own) return daft_fields(form->which, count);
    *count = own->count;
    return own->fields;
}

static const api_special *special_of(const api_form *form, const char *name)
{
    for (size_t i = 0; i < form->special_count; i++)
        if (strcmp(form->specials[i].name, name) == 0) return &form->specials[i];
    return NULL;
}

static bool has_field(const api_form *form, const daft_field *field)
{
    return field->lua && (form->kind < 0 || !field->kinds || (field->kinds >> form->kind & 1));
}

/* The fields' names in the order of the list, then what is special and no field. */
static size_t names_of(const api_form *form, const char *names[MAX_NAMES])
{
    uint32_t count;
    const daft_field *fields = fields_of(form, &count);
    size_t used = 0;
    for (uint32_t i = 0; i < count; i++)
        if (has_field(form, &fields[i])) names[used++] = fields[i].lua;
    size_t of_fields = used;
    for (size_t i = 0; i < form->special_count; i++) {
        bool known = false;
        for (size_t k = 0; k < of_fields && !known; k++) known = strcmp(names[k], form->specials[i].name) == 0;
        if (!known) names[used++] = form->specials[i].name;
    }
    return used;
}

/* ---- reading ---- */

static uint32_t size_of_vector(daft_field_type type) { return type == DAFT_FIELD_VEC2 ? 2 : 3; }

static void read_vec2(lua_State *L, host *h, const char *what, float *out)
{
    if (lua_type(L, -1) != LUA_TTABLE || lua_rawlen(L, -1) != 2) api_wrong(L, h, -1, what, "number or {u, v}");
    for (int i = 0; i < 2; i++) {
        lua_rawgeti(L, -1, i + 1);
        out[i] = api_float(L, h, -1, what);
        lua_pop(L, 1);
    }
}

static void read_vector(lua_State *L, host *h, const daft_field *field, float *out)
{
    const char *what = field->lua;
    if ((field->flags & DAFT_FIELD_UNIFORM) && lua_type(L, -1) == LUA_TNUMBER) {
        out[0] = out[1] = api_float(L, h, -1, what);
        if (size_of_vector(field->type) == 3) out[2] = out[0];
        return;
    }
    if (field->type == DAFT_FIELD_VEC2) {
        read_vec2(L, h, what, out);
        return;
    }
    daft_vec3 v = field->type == DAFT_FIELD_COLOR ? api_color(L, h, -1, what) : api_vec3(L, h, -1, what);
    memcpy(out, &v, sizeof v);
}

/* An entity stands for where it is. */
static daft_dvec3 read_position(lua_State *L, host *h, const char *what)
{
    return api_test_handle(L, -1, API_ENTITY) ? api_place(L, h, -1, what) : api_dvec3(L, h, -1, what);
}

static uint32_t read_choice(lua_State *L, host *h, const daft_field *field)
{
    const char *names[MAX_NAMES];
    uint32_t values[MAX_NAMES], count = 0;
    for (uint32_t i = 0; i < field->choice_count; i++)
        if (field->choices[i]) names[count] = field->choices[i], values[count++] = i;
    return values[api_choice(L, h, -1, field->lua, names, count)];
}

static uint32_t read_whole(lua_State *L, host *h, const daft_field *field)
{
    lua_Integer value = api_whole(L, h, -1, field->lua);
    if (value < 0 || value > (lua_Integer)UINT32_MAX) api_wrong(L, h, -1, field->lua, "whole number of 0 or more");
    return (uint32_t)value;
}

/* What is out of range is told by its name in Lua, in the words of libdaft. */
static void check_range(lua_State *L, host *h, const daft_field *field, const double *values, uint32_t count)
{
    char range[128];
    bool any = field->min == 0 && field->max == 0;
    for (uint32_t i = 0; i < count && !any; i++) {
        const double value = values[i];
        if (value >= field->min && value <= field->max) continue;
        const char *part = count == 1 ? "" : i == 0 ? ".x" : i == 1 ? ".y" : ".z";
        daft_field_range(field, range, sizeof range);
        api_error(L, h, "%s%s is %g; it must be %s", field->lua, part, value, range);
    }
}

static void check_floats(lua_State *L, host *h, const daft_field *field, const float *values, uint32_t count)
{
    const double wide[3] = {(double)values[0], (double)values[1], (double)values[2]};
    check_range(L, h, field, wide, count);
}

/* The value on top of the stack. */
static void read_field(lua_State *L, host *h, const daft_field *field, char *out)
{
    const char *what = field->lua;
    union {
        bool on;
        uint32_t whole;
        float numbers[3];
        double twice;
        daft_dvec3 place;
        daft_quat turn;
    } v = {0};
    switch (field->type) {
    case DAFT_FIELD_BOOL: v.on = api_boolean(L, h, -1, what); break;
    case DAFT_FIELD_CHOICE: v.whole = read_choice(L, h, field); break;
    case DAFT_FIELD_INT:
    case DAFT_FIELD_UINT:
        v.whole = read_whole(L, h, field);
        check_range(L, h, field, &(double){v.whole}, 1);
        break;
    case DAFT_FIELD_FLOAT:
        v.numbers[0] = api_float(L, h, -1, what);
        check_floats(L, h, field, v.numbers, 1);
        break;
    case DAFT_FIELD_DOUBLE:
        v.twice = api_number(L, h, -1, what);
        check_range(L, h, field, &v.twice, 1);
        break;
    case DAFT_FIELD_VEC2:
    case DAFT_FIELD_VEC3:
    case DAFT_FIELD_COLOR:
    case DAFT_FIELD_DIRECTION:
        read_vector(L, h, field, v.numbers);
        check_floats(L, h, field, v.numbers, size_of_vector(field->type));
        break;
    case DAFT_FIELD_POSITION: v.place = read_position(L, h, what); break;
    case DAFT_FIELD_ROTATION: v.turn = api_rotation(L, h, -1, what); break;
    case DAFT_FIELD_MESH: v.whole = api_mesh_at(L, h, -1, what).id; break;
    case DAFT_FIELD_MATERIAL: v.whole = api_material_at(L, h, -1, what).id; break;
    case DAFT_FIELD_ENTITY: v.whole = api_entity_at(L, h, -1, what).id; break;
    default: api_error(L, h, "%s cannot be set", what);
    }
    memcpy(out + field->offset, &v, field->size);
}

/* Specials leave their values on the stack, since the definition may point to them. */
void api_read_struct(lua_State *L, host *h, int table, const char *what, const api_form *form, void *value)
{
    const char *names[MAX_NAMES];
    uint32_t count;
    const daft_field *fields = fields_of(form, &count);
    table = lua_absindex(L, table);
    api_fields(L, h, table, what, names, names_of(form, names));
    luaL_checkstack(L, MAX_NAMES + 16, NULL);
    for (uint32_t i = 0; i < count; i++) {
        const daft_field *field = &fields[i];
        const api_special *special = field->lua ? special_of(form, field->lua) : NULL;
        if (!has_field(form, field) || (special && special->read) || !api_field(L, table, field->lua)) continue;
        read_field(L, h, field, value);
        lua_pop(L, 1);
    }
    for (size_t i = 0; i < form->special_count; i++)
        if (form->specials[i].read && api_field(L, table, form->specials[i].name))
            form->specials[i].read(L, h, table, value);
    for (size_t i = 0; i < form->special_count; i++)
        if (form->specials[i].after && api_has_field(L, table, form->specials[i].name))
            form->specials[i].after(L, h, table, value);
}

/* ---- writing ---- */

static void push_floats(lua_State *L, const char *at, uint32_t count)
{
    float v[4];
    memcpy(v, at, count * sizeof *v);
    lua_createtable(L, (int)count, 0);
    for (uint32_t i = 0; i < count; i++) {
        lua_pushnumber(L, (double)v[i]);
        lua_rawseti(L, -2, (lua_Integer)i + 1);
    }
}

/* False: nothing was pushed. */
static bool push_field(lua_State *L, const daft_field *field, const char *value)
{
    const char *at = value + field->offset;
    bool on;
    float number;
    uint32_t whole;
    daft_dvec3 place;
    char text[64];
    switch (field->type) {
    case DAFT_FIELD_BOOL: memcpy(&on, at, sizeof on), lua_pushboolean(L, on); return true;
    case DAFT_FIELD_INT:
    case DAFT_FIELD_UINT: memcpy(&whole, at, sizeof whole), lua_pushinteger(L, (lua_Integer)whole); return true;
    case DAFT_FIELD_FLOAT: memcpy(&number, at, sizeof number), lua_pushnumber(L, (double)number); return true;
    case DAFT_FIELD_CHOICE: lua_pushstring(L, daft_field_print(field, value, text, sizeof text)); return true;
    case DAFT_FIELD_POSITION:
        memcpy(&place, at, sizeof place);
        api_push_vec3(L, place.x, place.y, place.z);
        return true;
    case DAFT_FIELD_VEC2:
    case DAFT_FIELD_VEC3:
    case DAFT_FIELD_COLOR:
    case DAFT_FIELD_DIRECTION:
    case DAFT_FIELD_ROTATION: push_floats(L, at, (uint32_t)(field->size / sizeof(float))); return true;
    default: return false;
    }
}

void api_push_struct(lua_State *L, daft_struct which, const void *value)
{
    uint32_t count;
    const daft_field *fields = daft_fields(which, &count);
    lua_createtable(L, 0, (int)count);
    for (uint32_t i = 0; i < count; i++)
        if (fields[i].lua && push_field(L, &fields[i], value)) lua_setfield(L, -2, fields[i].lua);
}

/* ---- the reference ---- */

static const api_form *const FORMS[] = {
    &api_entity_form,     &api_collider_form,  &api_joint_form,    &api_surfaces_form, &api_character_form,
    &api_filter_form,     &api_picture_form,   &api_material_form, &api_sun_form,      &api_point_form,
    &api_spot_form,       &api_rectangle_form, &api_fog_form,      &api_exposure_form, &api_camera_form,
    &api_checkpoint_form, &api_quality_form,   &api_play_form,     &api_synth_form,    &api_voice_form,
    &api_particles_form};

const api_form *const *api_forms(size_t *count)
{
    *count = COUNT_OF(FORMS);
    return FORMS;
}

static const char *type_text(const daft_field *field)
{
    bool uniform = field->flags & DAFT_FIELD_UNIFORM;
    switch (field->type) {
    case DAFT_FIELD_BOOL: return "true or false";
    case DAFT_FIELD_VEC2: return uniform ? "number or {u, v}" : "{u, v}";
    case DAFT_FIELD_VEC3: return uniform ? "number or {x, y, z}" : "{x, y, z}";
    case DAFT_FIELD_COLOR: return uniform ? "colour or number" : "colour";
    case DAFT_FIELD_DIRECTION: return "{x, y, z}, any length";
    case DAFT_FIELD_POSITION: return "{x, y, z} or entity";
    case DAFT_FIELD_ROTATION: return "{yaw, pitch, roll} or {x, y, z, w}";
    case DAFT_FIELD_MESH: return "mesh or \"file.obj\"";
    case DAFT_FIELD_TEXTURE: return "\"name\"";
    case DAFT_FIELD_MATERIAL: return "material";
    case DAFT_FIELD_ENTITY: return "entity";
    default: return "number";
    }
}

/* "number, rad, between 0 and 3.14159"; choices in quotes. */
static void value_text(const daft_field *field, char *out, size_t size)
{
    size_t used = 0;
    out[0] = 0;
    for (uint32_t i = 0; field->type == DAFT_FIELD_CHOICE && i < field->choice_count && used < size; i++)
        if (field->choices[i])
            used += (size_t)snprintf(out + used, size - used, "%s\"%s\"", used ? ", " : "", field->choices[i]);
    if (field->type == DAFT_FIELD_CHOICE) return;
    used = (size_t)snprintf(out, size, "%s", type_text(field));
    if (field->unit && used < size) used += (size_t)snprintf(out + used, size - used, ", %s", field->unit);
    if (field->value_count > 0 && used < size) {
        char range[64];
        snprintf(out + used, size - used, ", %s", daft_field_range(field, range, sizeof range));
        return;
    }
    bool limited = (field->min != 0 || field->max != 0) && field->type != DAFT_FIELD_COLOR;
    if (!limited || used >= size) return;
    bool above = field->min == (double)FLT_TRUE_MIN;
    if (isinf(field->max))
        snprintf(out + used, size - used, "%s", above ? ", above 0" : ", 0 or more");
    else if (above)
        snprintf(out + used, size - used, ", up to %.6g", field->max);
    else
        snprintf(out + used, size - used, ", %.6g to %.6g", field->min, field->max);
}

static void initial_text(const daft_field *field, const char *value, char *out, size_t size)
{
    char plain[120];
    out[0] = 0;
    if (field->type >= DAFT_FIELD_MESH || field->type == DAFT_FIELD_ROTATION) return;
    daft_field_print(field, value, plain, sizeof plain);
    bool listed = strchr(plain, ',') != NULL, uniform = field->flags & DAFT_FIELD_UNIFORM;
    if (listed && uniform)
        snprintf(out, size, "%.*s", (int)strcspn(plain, ","), plain);
    else if (field->type == DAFT_FIELD_CHOICE)
        snprintf(out, size, "\"%s\"", plain);
    else
        snprintf(out, size, listed ? "{%s}" : "%s", plain);
}

static const daft_field *field_named(const api_form *form, const char *name)
{
    uint32_t count;
    const daft_field *fields = fields_of(form, &count);
    for (uint32_t i = 0; i < count; i++)
        if (has_field(form, &fields[i]) && strcmp(fields[i].lua, name) == 0) return &fields[i];
    return NULL;
}

void api_describe_form(const api_form *form,
                       void (*row)(void *user, const char *name, const char *value, const char *initial,
                                   const char *doc),
                       void *user)
{
    const char *names[MAX_NAMES];
    size_t count = names_of(form, names);
    _Alignas(16) char defaults[2048];
    if (daft_struct_size(form->which) > sizeof defaults) return;
    if (list_of(form))
        list_of(form)->set_default(defaults);
    else
        daft_struct_default(form->which, defaults);
    for (size_t i = 0; i < count; i++) {
        const daft_field *field = field_named(form, names[i]);
        const api_special *special = special_of(form, names[i]);
        char value[160] = "", initial[160] = "";
        if (field) value_text(field, value, sizeof value);
        if (field && !(special && special->value)) initial_text(field, defaults, initial, sizeof initial);
        row(user, names[i], special && special->value ? special->value : value, initial,
            special && special->doc ? special->doc : field->doc);
    }
}
