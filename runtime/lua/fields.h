/* Tables of Lua from the lists of fields in daft.h: reading, checking, writing and describing them. A field with a Lua
 * name needs nothing here; one whose value in Lua is not the value in C has a reader of its own. */
#ifndef RUNTIME_LUA_FIELDS_H
#define RUNTIME_LUA_FIELDS_H

#include "lua/api.h"

#include <stddef.h>

/* `table` is the whole table's place on the stack. A reader finds the value on top of it; what `out` then points to
 * stays there. */
typedef void api_reader(lua_State *L, host *h, int table, void *out);

typedef struct api_special {
    const char *name;  /* in Lua: of a field, or of what is no field */
    api_reader *read;  /* instead of reading by the field's type; NULL for what is no field: who reads the table looks
                          for it */
    api_reader *after; /* called once the field, which is there, and all others are read */
    const char *value; /* for the reference: what it may be; NULL: as its type says */
    const char *doc;   /* NULL: the field's */
} api_special;

/* The fields of a struct that daft.h does not have: fields.c says which form has them. */
typedef struct api_list {
    const daft_field *fields;
    uint32_t count;
    void (*set_default)(void *out);
} api_list;

#define API_ROW(struct_type, member, label, kind, ...)                                                                 \
    {                                                                                                                  \
        .name = label, .type = kind, .offset = offsetof(struct_type, member),                                          \
        .size = sizeof(((struct_type *)0)->member), .lua = label, __VA_ARGS__                                          \
    }

/* What a table of Lua may have: the fields of a struct that have Lua names, and what is special. */
typedef struct api_form {
    const char *function; /* that takes it: "light.sun" */
    const char *title;    /* "daft.light.sun"; of a table within another what it is: "collider" */
    daft_struct which;    /* DAFT_STRUCT_COUNT: the fields are an api_list */
    int kind;             /* only the fields that this kind of the struct uses; -1: all */
    const api_special *specials;
    size_t special_count;
} api_form;

/* Sets what the table names. `what` names the table in messages, NULL: it is the only argument. */
void api_read_struct(lua_State *L, host *h, int table, const char *what, const api_form *form, void *value);
/* Pushes a table of the fields that have Lua names, but for handles. */
void api_push_struct(lua_State *L, daft_struct which, const void *value);

/* ---- the reference ---- */

const api_form *const *api_forms(size_t *count);
/* Calls `row` for every name in the form: what it may be, its default ("" where there is none to tell), its sentence.
 */
void api_describe_form(const api_form *form,
                       void (*row)(void *user, const char *name, const char *value, const char *initial,
                                   const char *doc),
                       void *user);

extern const api_form api_entity_form, api_collider_form, api_material_form, api_sun_form, api_point_form,
    api_spot_form, api_rectangle_form, api_fog_form, api_exposure_form, api_camera_form, api_joint_form,
    api_surfaces_form, api_character_form, api_filter_form, api_picture_form, api_checkpoint_form, api_quality_form,
    api_play_form, api_synth_form, api_voice_form, api_particles_form;
extern const api_list api_synth_list, api_voice_list, api_particles_list;

#endif
