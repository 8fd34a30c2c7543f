/* What every list of fields is read by: look-up, defaults, components as numbers, bytes, the state's hash. */
#include "scene/fields/fields.h"

#include <string.h>

static const daft_field_list *const LISTS[DAFT_STRUCT_COUNT] = {
    [DAFT_STRUCT_ENGINE_DEF] = &daft_engine_fields,
    [DAFT_STRUCT_MATERIAL_DEF] = &daft_material_fields,
    [DAFT_STRUCT_ENTITY_DEF] = &daft_entity_fields,
    [DAFT_STRUCT_COLLIDER] = &daft_collider_fields,
    [DAFT_STRUCT_JOINT_DEF] = &daft_joint_fields,
    [DAFT_STRUCT_SURFACES] = &daft_surfaces_fields,
    [DAFT_STRUCT_CAMERA] = &daft_camera_fields,
    [DAFT_STRUCT_LIGHT_DEF] = &daft_light_fields,
    [DAFT_STRUCT_QUALITY] = &daft_quality_fields,
    [DAFT_STRUCT_VIEW] = &daft_view_fields,
    [DAFT_STRUCT_QUERY_FILTER] = &daft_query_filter_fields,
    [DAFT_STRUCT_VOLUME] = &daft_volume_fields,
    [DAFT_STRUCT_CHARACTER_DEF] = &daft_character_fields,
    [DAFT_STRUCT_SCAN_DEF] = &daft_scan_fields,
    [DAFT_STRUCT_COUNTERS] = &daft_counters_fields,
    [DAFT_STRUCT_SIM_COUNTERS] = &daft_sim_counters_fields,
    [DAFT_STRUCT_PLAY_DEF] = &daft_play_fields,
    [DAFT_STRUCT_FOG] = &daft_fog_fields,
    [DAFT_STRUCT_EXPOSURE] = &daft_exposure_fields,
};

const daft_field_list *daft_field_list_of(daft_struct which)
{
    return (unsigned)which < DAFT_STRUCT_COUNT ? LISTS[which] : NULL;
}

const daft_field *daft_fields(daft_struct which, uint32_t *count)
{
    const daft_field_list *list = daft_field_list_of(which);
    if (count) *count = list ? list->count : 0;
    return list ? list->fields : NULL;
}

const char *daft_struct_name(daft_struct which)
{
    const daft_field_list *list = daft_field_list_of(which);
    return list ? list->name : "unknown";
}

size_t daft_struct_size(daft_struct which)
{
    const daft_field_list *list = daft_field_list_of(which);
    return list ? list->size : 0;
}

const daft_field *daft_field_find(daft_struct which, const char *name)
{
    uint32_t count;
    const daft_field *fields = daft_fields(which, &count);
    for (uint32_t i = 0; name && i < count; i++)
        if (strcmp(fields[i].name, name) == 0) return &fields[i];
    return NULL;
}

bool daft_field_used(const daft_field_list *list, const daft_field *field, const void *value)
{
    if (!field->kinds) return true;
    for (uint32_t i = 0; i < list->count; i++) {
        if (list->fields[i].type != DAFT_FIELD_CHOICE) continue;
        uint32_t kind;
        memcpy(&kind, (const char *)value + list->fields[i].offset, sizeof kind);
        return kind < 32 && (field->kinds >> kind & 1);
    }
    return true;
}

/* ---- components as numbers ---- */

typedef enum component { NONE, BYTE, WHOLE, WHOLE64, SINGLE, TWICE } component;

/* What a field is an array of. */
static component component_of(daft_field_type type)
{
    switch (type) {
    case DAFT_FIELD_BOOL: return BYTE;
    case DAFT_FIELD_INT:
    case DAFT_FIELD_UINT:
    case DAFT_FIELD_CHOICE:
    case DAFT_FIELD_MESH:
    case DAFT_FIELD_TEXTURE:
    case DAFT_FIELD_MATERIAL:
    case DAFT_FIELD_ENTITY: return WHOLE;
    case DAFT_FIELD_UINT64: return WHOLE64;
    case DAFT_FIELD_FLOAT:
    case DAFT_FIELD_VEC2:
    case DAFT_FIELD_VEC3:
    case DAFT_FIELD_COLOR:
    case DAFT_FIELD_DIRECTION:
    case DAFT_FIELD_ROTATION: return SINGLE;
    case DAFT_FIELD_DOUBLE:
    case DAFT_FIELD_POSITION: return TWICE;
    case DAFT_FIELD_STRUCT:
    case DAFT_FIELD_TEXT:
    case DAFT_FIELD_OTHER:
    case DAFT_FIELD_TYPE_COUNT: break;
    }
    return NONE;
}

static size_t component_size(component c)
{
    static const size_t SIZES[] = {1, sizeof(bool), sizeof(uint32_t), sizeof(uint64_t), sizeof(float), sizeof(double)};
    return SIZES[c];
}

static double read_component(component c, daft_field_type type, const char *at)
{
    union {
        bool byte;
        int32_t whole;
        uint32_t natural;
        uint64_t wide;
        float single;
        double twice;
    } v;
    memcpy(&v, at, component_size(c));
    if (c == BYTE) return v.byte;
    if (c == WHOLE) return type == DAFT_FIELD_INT ? (double)v.whole : (double)v.natural;
    if (c == WHOLE64) return (double)v.wide;
    return c == SINGLE ? (double)v.single : v.twice;
}

static void write_component(component c, daft_field_type type, double number, char *at)
{
    const bool byte = number != 0;
    const int32_t whole = c == WHOLE && type == DAFT_FIELD_INT ? (int32_t)number : 0;
    const uint32_t natural = c == WHOLE && type != DAFT_FIELD_INT ? (uint32_t)number : 0;
    const uint64_t wide = c == WHOLE64 ? (uint64_t)number : 0;
    const float single = (float)number;
    if (c == BYTE) memcpy(at, &byte, sizeof byte);
    if (c == WHOLE) memcpy(at, type == DAFT_FIELD_INT ? (const void *)&whole : &natural, sizeof natural);
    if (c == WHOLE64) memcpy(at, &wide, sizeof wide);
    if (c == SINGLE) memcpy(at, &single, sizeof single);
    if (c == TWICE) memcpy(at, &number, sizeof number);
}

uint32_t daft_field_numbers(const daft_field *field, const void *value, double out[4])
{
    component c = component_of(field->type);
    if (c == NONE) return 0;
    uint32_t count = (uint32_t)(field->size / component_size(c));
    for (uint32_t i = 0; i < count; i++)
        out[i] = read_component(c, field->type, (const char *)value + field->offset + i * component_size(c));
    return count;
}

void daft_field_set_numbers(const daft_field *field, void *value, const double numbers[4])
{
    component c = component_of(field->type);
    if (c == NONE) return;
    for (uint32_t i = 0; i < field->size / component_size(c); i++)
        write_component(c, field->type, numbers[i], (char *)value + field->offset + i * component_size(c));
}

/* ---- defaults ---- */

void daft_struct_default(daft_struct which, void *out)
{
    const daft_field_list *list = daft_field_list_of(which);
    if (!list || !out) return;
    memset(out, 0, list->size);
    for (uint32_t i = 0; i < list->count; i++) {
        const daft_field *field = &list->fields[i];
        char *at = (char *)out + field->offset;
        const uint32_t cookie = DAFT_COOKIE;
        if (field->type == DAFT_FIELD_STRUCT)
            daft_struct_default(field->nested, at);
        else if (field->type == DAFT_FIELD_OTHER && strcmp(field->name, "cookie") == 0)
            memcpy(at, &cookie, sizeof cookie);
        else
            daft_field_set_numbers(field, out, field->initial);
    }
}

static bool is_default(const daft_field *field, const void *value)
{
    double numbers[4];
    uint32_t count = daft_field_numbers(field, value, numbers);
    for (uint32_t i = 0; i < count; i++) {
        double initial = component_of(field->type) == SINGLE ? (double)(float)field->initial[i] : field->initial[i];
        if (numbers[i] != initial) return false;
    }
    return true;
}

/* ---- bytes ---- */

static size_t pack_list(const daft_field_list *list, const char *value, char *out, size_t capacity, size_t used)
{
    for (uint32_t i = 0; i < list->count; i++) {
        const daft_field *field = &list->fields[i];
        const char *at = value + field->offset;
        if (field->type == DAFT_FIELD_OTHER || field->type == DAFT_FIELD_TEXT) continue;
        if (field->type == DAFT_FIELD_STRUCT) {
            used = pack_list(daft_field_list_of(field->nested), at, out, capacity, used);
            continue;
        }
        if (out && used + field->size <= capacity) memcpy(out + used, at, field->size);
        used += field->size;
    }
    return used;
}

size_t daft_struct_pack(daft_struct which, const void *value, void *out, size_t capacity)
{
    const daft_field_list *list = daft_field_list_of(which);
    return list && value ? pack_list(list, value, out, capacity, 0) : 0;
}

/* ---- the state's hash ---- */

/* The order in which fields are hashed. */
typedef enum hash_class { CHOICES, SWITCHES, HANDLES, NUMBERS, HASH_CLASSES, UNHASHED } hash_class;

static hash_class class_of(daft_field_type type)
{
    if (type == DAFT_FIELD_CHOICE) return CHOICES;
    if (type == DAFT_FIELD_BOOL) return SWITCHES;
    if (type >= DAFT_FIELD_MESH && type <= DAFT_FIELD_ENTITY) return HANDLES;
    return component_of(type) == NONE ? UNHASHED : NUMBERS;
}

static uint64_t hash_field(const daft_field *field, const void *value, uint64_t hash)
{
    double number[4];
    if (class_of(field->type) == NUMBERS) return daft_hash((const char *)value + field->offset, field->size, hash);
    daft_field_numbers(field, value, number);
    uint32_t whole = (uint32_t)number[0];
    return daft_hash(&whole, sizeof whole, hash);
}

static bool always_hashed(const daft_field_list *list, const daft_field *field, const void *value)
{
    return (field->flags & DAFT_FIELD_HASHED) ||
           ((field->flags & DAFT_FIELD_HASHED_USED) && daft_field_used(list, field, value));
}

uint64_t daft_struct_hash(daft_struct which, const void *value, uint64_t hash)
{
    const daft_field_list *list = daft_field_list_of(which);
    for (int c = CHOICES; c < HASH_CLASSES; c++)
        for (uint32_t i = 0; i < list->count; i++)
            if ((int)class_of(list->fields[i].type) == c && always_hashed(list, &list->fields[i], value))
                hash = hash_field(&list->fields[i], value, hash);
    for (uint32_t i = 0; i < list->count; i++) {
        const daft_field *field = &list->fields[i];
        const uint32_t elsewhere = DAFT_FIELD_HASHED | DAFT_FIELD_HASHED_USED | DAFT_FIELD_NOT_HASHED;
        if (class_of(field->type) == UNHASHED || (field->flags & elsewhere) || is_default(field, value)) continue;
        hash = daft_hash(field->name, strlen(field->name), hash);
        hash = hash_field(field, value, hash);
    }
    return hash;
}
