/* The lists behind daft_fields: one for each public struct, in the files of rows/. A row's type comes from the
 * member's own declaration, so a row that does not fit it does not compile; test_fields proves that no member is
 * missing.
 *
 * A new field of a light is: its line in daft.h, its row in rows/light.c, and the code that uses it. */
#ifndef DAFT_FIELDS_H
#define DAFT_FIELDS_H

#include "base/base.h"
#include "math/vec.h"

#include <float.h>
#include <math.h>

typedef struct daft_field_list {
    const char *name; /* of the struct */
    size_t size;
    const daft_field *fields;
    uint32_t count;
} daft_field_list;

extern const daft_field_list daft_engine_fields, daft_material_fields, daft_entity_fields, daft_collider_fields,
    daft_joint_fields, daft_surfaces_fields, daft_camera_fields, daft_light_fields, daft_quality_fields,
    daft_view_fields, daft_query_filter_fields, daft_volume_fields, daft_scan_fields, daft_character_fields,
    daft_play_fields, daft_fog_fields, daft_exposure_fields, daft_counters_fields, daft_sim_counters_fields;

const daft_field_list *daft_field_list_of(daft_struct which);

/* ---- rows ---- */

#define DAFT_MEMBER(S, m) (((S *)0)->m)

#define DAFT_TYPE_OF(S, m)                                                                                             \
    _Generic(DAFT_MEMBER(S, m),                                                                                         \
        bool: DAFT_FIELD_BOOL,                                                                                          \
        int: DAFT_FIELD_INT,                                                                                            \
        uint32_t: DAFT_FIELD_UINT,                                                                                      \
        uint64_t: DAFT_FIELD_UINT64,                                                                                    \
        float: DAFT_FIELD_FLOAT,                                                                                        \
        double: DAFT_FIELD_DOUBLE,                                                                                      \
        daft_vec2: DAFT_FIELD_VEC2,                                                                                     \
        daft_vec3: DAFT_FIELD_VEC3,                                                                                     \
        daft_dvec3: DAFT_FIELD_POSITION,                                                                                \
        daft_quat: DAFT_FIELD_ROTATION,                                                                                 \
        daft_mesh: DAFT_FIELD_MESH,                                                                                     \
        daft_texture: DAFT_FIELD_TEXTURE,                                                                               \
        daft_material: DAFT_FIELD_MATERIAL,                                                                             \
        daft_entity: DAFT_FIELD_ENTITY,                                                                                 \
        const char *: DAFT_FIELD_TEXT)

#define DAFT_ROW_AS(S, m, as, ...)                                                                                     \
    {                                                                                                                  \
        .name = #m, .type = as, .offset = offsetof(S, m), .size = sizeof DAFT_MEMBER(S, m), __VA_ARGS__                \
    }

/* Each takes the struct, the member and designated initialisers of daft_field. */
#define DAFT_ROW(S, m, ...) DAFT_ROW_AS(S, m, DAFT_TYPE_OF(S, m), __VA_ARGS__)
#define DAFT_COLOR_ROW(S, m, ...)                                                                                      \
    DAFT_ROW_AS(S, m, _Generic(DAFT_MEMBER(S, m), daft_vec3 : DAFT_FIELD_COLOR), __VA_ARGS__)
#define DAFT_DIRECTION_ROW(S, m, ...)                                                                                  \
    DAFT_ROW_AS(S, m, _Generic(DAFT_MEMBER(S, m), daft_vec3 : DAFT_FIELD_DIRECTION), __VA_ARGS__)
/* An enum, whose names are the array `names`. */
#define DAFT_CHOICE_ROW(S, m, names, ...)                                                                              \
    DAFT_ROW_AS(S, m,                                                                                                  \
                _Generic(DAFT_MEMBER(S, m), uint32_t                                                                   \
                         : DAFT_FIELD_CHOICE),                                                                         \
                .choices = names, .choice_count = DAFT_COUNT_OF(names), __VA_ARGS__)
#define DAFT_STRUCT_ROW(S, m, inner, which, ...)                                                                       \
    DAFT_ROW_AS(S, m, _Generic(DAFT_MEMBER(S, m), inner : DAFT_FIELD_STRUCT), .nested = which, __VA_ARGS__)
#define DAFT_OTHER_ROW(S, m, ...) DAFT_ROW_AS(S, m, DAFT_FIELD_OTHER, __VA_ARGS__)
#define DAFT_COOKIE_ROW(S)                                                                                             \
    DAFT_ROW_AS(S, cookie, DAFT_FIELD_OTHER, .initial = {DAFT_COOKIE},                                                 \
                .doc = "Set by the default maker; shows that it was called")

#define DAFT_FIELD_LIST(S, rows)                                                                                       \
    {                                                                                                                  \
#S, sizeof(S), rows, DAFT_COUNT_OF(rows)                                                                       \
    }

/* Ranges. */
#define DAFT_ABOVE_ZERO ((double)FLT_TRUE_MIN)
#define DAFT_ANY_FLOAT  ((double)FLT_MAX)
#define FROM(low, high) .min = (low), .max = (high)
#define ZERO_OR_MORE    .min = 0, .max = (double)INFINITY
#define ABOVE_ZERO      .min = DAFT_ABOVE_ZERO, .max = (double)INFINITY

/* daft_sin states its error up to a million radians. */
#define DAFT_ANGLES   FROM(-1e6, 1e6)
#define DAFT_PI_FLOAT ((double)(float)DAFT_PI) /* pi as a float has it */

/* ---- what is done with the lists inside the engine ---- */

/* The least and the largest finite number that a component may be. */
void daft_field_limits(const daft_field *field, double *min, double *max);
/* One field's range. `before` and the field's name begin the message: "camera." and "fov". */
bool daft_field_check(const daft_field *field, const void *value, const char *before, daft_error *error);
/* The same for a whole struct; `used` is false for fields that the struct's kind does not use: they need only be
 * finite. */
bool daft_struct_check_named(daft_struct which, const void *value, const char *before, daft_error *error);
/* The hash of a scene's state over the struct: choices, booleans and handles first, as 32 bits each, then the numbers,
 * each in the order of the list; last what flags leave out while it has its default, with its name. */
uint64_t daft_struct_hash(daft_struct which, const void *value, uint64_t hash);
/* Whether the struct's kind uses the field. */
bool daft_field_used(const daft_field_list *list, const daft_field *field, const void *value);
/* Components as doubles; returns how many, 0 for text, structs and others. */
uint32_t daft_field_numbers(const daft_field *field, const void *value, double out[4]);
void daft_field_set_numbers(const daft_field *field, void *value, const double numbers[4]);

#endif
