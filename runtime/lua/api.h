/* api: the functions a game sees as `daft`. Each area is one file in lua/tables/ and one table of functions, with their
 * form and what they do beside them: registration, messages and the reference (`daft help lua`) all come from these
 * tables.
 *
 * A binding reads its arguments, calls libdaft, and only then may raise an error.
 * Public headers: api.h host.h statement.h profile.h watchdog.h fields.h failure.h trial.h */
#ifndef RUNTIME_API_H
#define RUNTIME_API_H

#include "lua/host.h"

#include <lauxlib.h>
#include <lua.h>
#include <lualib.h>

enum {
    API_CHANGES = 1, /* changes the game, so daft.draw must not call it */
    API_DRAWS = 2    /* only within daft.draw */
};

/* Names: "light.sun" is daft.light.sun; "entity:push" is a method of the type "entity". */
struct api_function {
    const char *name;
    const char *form; /* the arguments and what comes back */
    const char *doc;
    int (*call)(lua_State *L, host *h);
    unsigned flags;
};

typedef struct api_area {
    const char *title;
    const api_function *functions;
    size_t count;
} api_area;

extern const api_area api_entity, api_animation, api_hierarchy, api_tags, api_body, api_joint, api_character, api_query,
    api_material, api_light, api_camera, api_input, api_hud, api_draw, api_time, api_world, api_window, api_chance,
    api_particles, api_picture, api_save, api_sound, api_test;
/* All areas, for registration and for the reference. */
const api_area *const *api_areas(size_t *count);
/* The functions that a game may define in `daft`. */
const char *const *api_callbacks(size_t *count);

/* Builds the table `daft` and leaves it as a global and in the registry. */
void api_register(lua_State *L, host *h);
/* Pushes the table `daft`. */
void api_push(lua_State *L);
/* The host of a state. */
host *api_host(lua_State *L);
/* In loops as long as a table or a string: stops now and then to ask whether the script is to end (host_poll). */
void api_poll(lua_State *L, uint64_t step);
/* ---- reference.c, annotate.c: the same tables as text ---- */

/* Everything, or with a name (a function, also without "daft.", a type's method, a type, a table such as "input") what
 * has it. False: nothing has it; *near is then a name like it, or NULL. */
bool api_print_reference(const char *name, const char **near);
/* Annotations for editors: the functions and their types in the form of the Lua language server (scripts/daft.d.lua).
 */
void api_print_annotations(void);

/* The library tables a script gets, with what would break determinism taken out or replaced (sandbox.c). */
void sandbox_open(lua_State *L);

/* ---- errors: none of these return ---- */

/* "daft.NAME: message", with the script's file and line before it. */
int api_error(lua_State *L, host *h, const char *format, ...) __attribute__((format(printf, 3, 4), noreturn));
/* "WHAT: WANTED expected, got TYPE" for the value at index. */
int api_wrong(lua_State *L, host *h, int index, const char *what, const char *wanted) __attribute__((noreturn));
int api_engine_error(lua_State *L, host *h, const daft_error *error) __attribute__((noreturn));

/* For getters that set when they have arguments: not within daft.draw. */
void api_check_may_change(lua_State *L, host *h);

/* ---- arguments: `what` is the argument's name in messages ---- */

double api_number(lua_State *L, host *h, int index, const char *what); /* finite */
float api_float(lua_State *L, host *h, int index, const char *what);   /* fits a float */
lua_Integer api_whole(lua_State *L, host *h, int index, const char *what);
bool api_boolean(lua_State *L, host *h, int index, const char *what);
const char *api_text(lua_State *L, host *h, int index, const char *what); /* without zero bytes */
/* {x, y, z} or {x =, y =, z =}. */
daft_dvec3 api_dvec3(lua_State *L, host *h, int index, const char *what);
daft_vec3 api_vec3(lua_State *L, host *h, int index, const char *what);
/* Like api_dvec3, or three numbers from index on; or, with an entity there, its place in the world. */
daft_dvec3 api_place(lua_State *L, host *h, int index, const char *what);
daft_vec3 api_triple(lua_State *L, host *h, int index, const char *what); /* a table or three numbers */
/* "#rgb", "#rrggbb" (sRGB) or {r, g, b} (linear light). */
daft_vec3 api_color(lua_State *L, host *h, int index, const char *what);
/* The same and "#rrggbbaa" or {r, g, b, a}, for the HUD. */
canvas_color api_hud_color(lua_State *L, host *h, int index, const char *what);
/* {yaw, pitch, roll} or a quaternion {x, y, z, w}. */
daft_quat api_rotation(lua_State *L, host *h, int index, const char *what);
daft_quat api_quat_from_angles(double yaw, double pitch, double roll);
/* One of the names; its index. */
size_t api_choice(lua_State *L, host *h, int index, const char *what, const char *const *names, size_t count);
int api_key(lua_State *L, host *h, int index, const char *what);

/* The value at index is a table that has no key but these; otherwise an error that names a near miss. what may be NULL:
 * the function's one argument. */
void api_fields(lua_State *L, host *h, int index, const char *what, const char *const *names, size_t count);
/* Pushes the field and is true; or pushes nothing and is false where it is nil. */
bool api_field(lua_State *L, int table, const char *name);
bool api_has_field(lua_State *L, int table, const char *name);

int api_push_vec3(lua_State *L, double x, double y, double z);    /* as a table */
int api_push_numbers(lua_State *L, double x, double y, double z); /* as three values */

/* ---- what is given back in tables that the script may give, so that a steady game makes no garbage ---- */

/* Pushes the table at `into`, or a new one where there is none. */
void api_push_out(lua_State *L, host *h, int into, const char *what);
/* Pushes place i of the list on top: the table there, or a new one. */
void api_push_item(lua_State *L, lua_Integer i);
/* Sets a field of the table on top to {x, y, z}, in the table there, if there is one. */
void api_set_vec3(lua_State *L, const char *name, double x, double y, double z);
/* Takes what is behind place `count` out of the list on top. */
void api_end_list(lua_State *L, lua_Integer count);
/* Memory for this call alone; fails where there is none. */
void *api_scratch(lua_State *L, size_t size);

/* ---- handles ---- */

typedef enum api_type {
    API_ENTITY,
    API_LIGHT,
    API_MATERIAL,
    API_MESH,
    API_JOINT,
    API_CHARACTER,
    API_PICTURE,
    API_SOUND,
    API_VOICE,
    API_FONT,
    API_IMAGE,
    API_STREAM,
    API_PARTICLES,
    API_TYPES
} api_type;

/* What every userdata that a script can hold begins with. */
typedef struct api_handle {
    uint32_t id;
    uint16_t type; /* an api_type: see api_set_type */
    bool visible;  /* of an entity, as last set */
} api_handle;

/* Pushes a new userdata of the type. */
api_handle *api_new_handle(lua_State *L, api_type type, uint32_t id);
/* Makes the userdata on top, which begins with an api_handle, one of the type. */
void api_set_type(lua_State *L, api_type type);
/* The handle at index, or NULL when it is not of this type. */
api_handle *api_test_handle(lua_State *L, int index, api_type type);
/* Pushes the table of the type's methods, and is true. */
bool api_push_methods(lua_State *L, api_type type);
api_handle *api_check_handle(lua_State *L, host *h, int index, api_type type, const char *what);
const char *api_type_name(lua_State *L, int index);

/* Goes on with the tasks that are due; host.tasks is how many there are (tables/time.c). */
int api_step_tasks(lua_State *L);
/* wait and wait_until as globals. */
void api_set_wait(lua_State *L);
/* Lets go of what nothing holds: see tables/material.c. */
int api_collect(lua_State *L);
/* Leaves in host.handed what daft.keep returns, or the global variables. */
int api_hand_over(lua_State *L);
/* Pushes that value. */
void api_push_handed(lua_State *L, const char *text);
/* __gc of materials and meshes. */
int api_release_handle(lua_State *L);
/* __gc of pictures. */
int api_release_picture(lua_State *L);
/* __gc of systems of particles. */
int api_release_particles(lua_State *L);
/* __gc of sounds. */
int api_release_sound(lua_State *L);
/* __gc of images. */
int api_release_image(lua_State *L);
/* __gc of fonts. */
int api_release_font(lua_State *L);

/* ---- what the script keeps with an entity (tables/tags.c) ----
 * Each takes its value from the top; `entity` is the userdata's place on the stack. */

void api_set_own(lua_State *L, int entity, const char *field); /* e.data, …, in its user value */
void api_set_name(lua_State *L, int entity);
/* Fails for what is neither a name nor a list of names. */
void api_check_tags(lua_State *L, host *h, int index);
void api_add_tags(lua_State *L, int entity); /* which have been checked */

/* Pushes the userdata of an entity, always the same one for the same entity; nil for none. */
void api_push_entity(lua_State *L, uint32_t id);
/* Pushes it where the script has met it, and is true; makes nothing. */
bool api_push_known_entity(lua_State *L, uint32_t id);
daft_entity api_entity_at(lua_State *L, host *h, int index, const char *what);
/* A texture name, "#colour", file.mtl#name, a table or a material. */
daft_material api_material_at(lua_State *L, host *h, int index, const char *what);
daft_mesh api_mesh_at(lua_State *L, host *h, int index, const char *what);
/* The program's own font where there is none. */
font *api_font_at(lua_State *L, host *h, int index);
/* ---- letters.c: meshes of text ---- */

/* Pushes the mesh that the table at `table`, {text =, size =, …}, describes: the same one for the same description. */
int api_push_letters(lua_State *L, host *h, int table);
/* Around a full collection of Lua: lets go of the meshes of texts that the game does not hold. */
void api_begin_letters_collection(lua_State *L);
void api_end_letters_collection(lua_State *L);

#endif
