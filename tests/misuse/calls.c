/* The arguments: for each type of daft.h's parameters a function that gives the good value first, then the bad ones. */
#include "calls.h"

#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define COUNT_OF(array) (sizeof(array) / sizeof((array)[0]))

#define REQUIRE(condition)                                                                                             \
    do {                                                                                                               \
        if (!(condition)) {                                                                                            \
            fprintf(stderr, "%s:%d: not so: %s\n", __FILE__, __LINE__, #condition);                                    \
            abort();                                                                                                   \
        }                                                                                                              \
    } while (0)

/* ---- choosing ---- */

void caller_choose(caller *c, int argument, int variant)
{
    c->argument = argument, c->variant = variant;
    c->bytes = NULL, c->byte_count = 0;
    c->variants_left = false;
}

void caller_feed(caller *c, const uint8_t *bytes, size_t count)
{
    c->argument = -1;
    c->bytes = bytes, c->byte_count = count;
}

static uint8_t next_byte(caller *c)
{
    if (c->byte_count == 0) return 0;
    c->byte_count--;
    return *c->bytes++;
}

static caller *begin_argument(caller *c, int at, const char *name)
{
    c->at = at, c->name = name;
    return c;
}

/* Which of `count` variants the argument takes. The first is the good one. */
static uint32_t choose(caller *c, uint32_t count)
{
    if (c->bytes) return next_byte(c) % count;
    if (c->at != c->argument) return 0;
    c->variants_left = (uint32_t)c->variant + 1 < count;
    return (uint32_t)c->variant % count;
}

static void say(caller *c, verdict v)
{
    if (v > c->said) c->said = v;
}

static bool is_name(const caller *c, const char *name) { return strcmp(c->name, name) == 0; }
static bool is_function(const caller *c, const char *name) { return strcmp(c->function, name) == 0; }

/* ---- numbers ---- */

static float give_float(caller *c)
{
    static const struct {
        const char *name;
        float good;
    } GOOD[] = {{"dt", 1.0f / 60}, {"lower", -0.5f}, {"height", 1.5f}, {"max_distance", 100}};
    static const float BAD[] = {NAN, -INFINITY, INFINITY, 0, -1, 3e38f, 1e-45f};
    uint32_t which = choose(c, 1 + COUNT_OF(BAD));
    if (which > 0) {
        say(c, which <= 2 ? VERDICT_WRONG : VERDICT_ODD);
        return BAD[which - 1];
    }
    for (size_t i = 0; i < COUNT_OF(GOOD); i++)
        if (is_name(c, GOOD[i].name)) return GOOD[i].good;
    return 0.5f;
}

static double give_double(caller *c)
{
    static const double VALUES[] = {0.5, NAN, INFINITY, -INFINITY, 0, -1, 1e308, 5e-324};
    uint32_t which = choose(c, COUNT_OF(VALUES));
    if (which) say(c, VERDICT_ODD);
    return VALUES[which];
}

/* A vector whose variants are its components, one by one not finite, then too large ones. */
static void give_components(caller *c, double *component, uint32_t count)
{
    static const double BAD[] = {NAN, INFINITY, -INFINITY, 1e300, 0};
    uint32_t which = choose(c, 1 + count * (uint32_t)COUNT_OF(BAD));
    if (which == 0) return;
    uint32_t kind = (which - 1) / count;
    say(c, kind < 3 ? VERDICT_WRONG : VERDICT_ODD);
    component[(which - 1) % count] = BAD[kind];
}

static daft_vec3 give_daft_vec3(caller *c)
{
    double v[3] = {0.25, -1, 0.5};
    if (is_name(c, "color") || is_name(c, "zenith") || is_name(c, "horizon")) v[1] = 1;
    give_components(c, v, 3);
    return (daft_vec3){(float)v[0], (float)v[1], (float)v[2]};
}

static daft_dvec3 give_daft_dvec3(caller *c)
{
    double v[3] = {0.5, 3, 0.5};
    give_components(c, v, 3);
    return (daft_dvec3){v[0], v[1], v[2]};
}

static int give_int(caller *c)
{
    static const int BAD[] = {0, -1, INT_MAX, INT_MIN, 100000};
    uint32_t which = choose(c, 1 + COUNT_OF(BAD));
    if (which) say(c, VERDICT_WRONG);
    return which ? BAD[which - 1] : 4;
}

/* Counts that must be those of the array beside them are only ever refused ones. */
static uint32_t give_uint32_t(caller *c)
{
    static const uint32_t BAD[] = {1000, UINT32_MAX, 5};
    if (is_name(c, "capacity")) return choose(c, 2) ? 0 : LIST;
    if (is_name(c, "layers") || is_name(c, "mask")) return (uint32_t[]){1, 0, UINT32_MAX}[choose(c, 3)];
    bool count = is_name(c, "count");
    if (is_function(c, "daft_path_camera")) { /* fewer than there are is fine as well */
        uint32_t none = choose(c, 2);
        if (none) say(c, VERDICT_WRONG);
        return none ? 0 : 4;
    }
    uint32_t which = choose(c, count ? 4 : 3);
    if (which) say(c, VERDICT_WRONG);
    return which ? BAD[which - 1] : count ? 4 : 0;
}

static uint64_t give_uint64_t(caller *c) { return choose(c, 2) ? UINT64_MAX : 0; }
static bool give_bool(caller *c) { return choose(c, 2) == 0; }

static size_t give_size_t(caller *c)
{
    uint32_t which = choose(c, 3);
    size_t whole = is_name(c, "capacity") ? sizeof c->output : is_name(c, "size") && c->size ? c->size : sizeof c->text;
    if (which && is_function(c, "daft_scene_load_bodies")) say(c, VERDICT_BAD);
    return which == 0 ? whole : which == 1 ? 0 : 1;
}

static daft_struct give_daft_struct(caller *c)
{
    uint32_t which = choose(c, DAFT_STRUCT_COUNT + 3);
    c->which = which == 0 ? DAFT_STRUCT_LIGHT_DEF : (daft_struct)(which - 1);
    if (which > DAFT_STRUCT_COUNT) say(c, VERDICT_WRONG);
    if (which > DAFT_STRUCT_COUNT + 1) c->which = (daft_struct)-1;
    return c->which;
}

#define GIVE_ENUM(type)                                                                                                \
    static type give_##type(caller *c)                                                                                 \
    {                                                                                                                  \
        static const int VALUES[] = {0, 1, -1, 1000, INT_MAX};                                                         \
        return (type)VALUES[choose(c, COUNT_OF(VALUES))];                                                              \
    }
GIVE_ENUM(daft_accel)
GIVE_ENUM(daft_preset)
GIVE_ENUM(daft_intersection)
GIVE_ENUM(daft_pace)

/* ---- handles ---- */

/* `none`: what handle 0 is. In bytes the pool's handles come by turns. */
static uint32_t give_handle(caller *c, const pool *from, verdict none)
{
    const uint32_t odd[] = {0, from->stale, UINT32_MAX, 0x00100fff, from->foreign};
    uint32_t which = choose(c, c->bytes ? 8 : 6);
    if (which > 5) return from->ids[next_byte(c) % POOL];
    if (which == 0) return from->count ? from->ids[0] : 0;
    say(c, which == 1 ? none : which == 5 ? VERDICT_ODD : VERDICT_BAD);
    return odd[which - 1];
}

static daft_entity give_daft_entity(caller *c)
{
    const bool may_be_none = is_name(c, "ignore") || is_name(c, "parent");
    uint32_t id = give_handle(c, &c->entities, may_be_none ? VERDICT_ODD : VERDICT_BAD);
    /* The first is a body, which has no parent. */
    if (is_function(c, "daft_entity_set_parent") && !may_be_none && id == c->entities.ids[0]) id = c->entities.ids[1];
    return (daft_entity){id};
}
static daft_mesh give_daft_mesh(caller *c) { return (daft_mesh){give_handle(c, &c->meshes, VERDICT_BAD)}; }
static daft_texture give_daft_texture(caller *c) { return (daft_texture){give_handle(c, &c->textures, VERDICT_BAD)}; }
static daft_material give_daft_material(caller *c)
{
    return (daft_material){give_handle(c, &c->materials, VERDICT_ODD)};
}
static daft_light give_daft_light(caller *c) { return (daft_light){give_handle(c, &c->lights, VERDICT_BAD)}; }
static daft_joint give_daft_joint(caller *c) { return (daft_joint){give_handle(c, &c->joints, VERDICT_BAD)}; }
static daft_character give_daft_character(caller *c)
{
    return (daft_character){give_handle(c, &c->characters, VERDICT_BAD)};
}

/* ---- objects ---- */

static void *object_or_null(caller *c, void *object)
{
    if (choose(c, 2) == 0) return object;
    say(c, VERDICT_WRONG);
    c->object_missing = true;
    return NULL;
}

static daft_engine *give_daft_engine_p(caller *c) { return object_or_null(c, c->engine); }
static const daft_engine *give_const_daft_engine_p(caller *c) { return object_or_null(c, c->engine); }
static daft_scene *give_daft_scene_p(caller *c)
{
    daft_scene *given = object_or_null(c, c->scene);
    if (given && is_function(c, "daft_scene_destroy") && !c->nested) c->scene = NULL;
    return given;
}
static const daft_scene *give_const_daft_scene_p(caller *c) { return object_or_null(c, c->scene); }
static daft_image *give_daft_image_p(caller *c)
{
    daft_image *given = object_or_null(c, c->image);
    if (given && is_function(c, "daft_image_destroy") && !c->drawing) c->image = NULL;
    return given;
}
static const daft_image *give_const_daft_image_p(caller *c) { return object_or_null(c, c->image); }

static daft_history *give_daft_history_p(caller *c)
{
    daft_history *given = choose(c, 2) ? c->history : NULL; /* NULL is fine */
    if (given && is_function(c, "daft_history_destroy")) c->history = NULL;
    return given;
}

/* A writer of its own for each call. */
static daft_writer *give_daft_writer_p(caller *c)
{
    if (choose(c, 2)) {
        say(c, VERDICT_WRONG);
        return NULL;
    }
    bool ends = is_function(c, "daft_writer_commit") || is_function(c, "daft_writer_abandon");
    snprintf(c->path, sizeof c->path, "%s/written.bin", c->folder);
    daft_writer *made = daft_writer_begin(c->path, NULL);
    REQUIRE(made);
    if (!ends) c->writer = made;
    return made;
}

static const daft_files *give_const_daft_files_p(caller *c)
{
    if (choose(c, 2) == 0) return c->files;
    say(c, is_function(c, "daft_engine_set_files") || is_function(c, "daft_read_file") ? VERDICT_ODD : VERDICT_WRONG);
    return NULL;
}

/* Only for the call that destroys it. */
static daft_files *give_daft_files_p(caller *c)
{
    daft_files_def def = daft_default_files_def();
    return choose(c, 2) ? NULL : daft_files_create(&def, NULL);
}

static const daft_files_def *give_const_daft_files_def_p(caller *c)
{
    static daft_root roots[2];
    static daft_files_def defs[6];
    roots[0] = (daft_root){.folder = c->folder};
    roots[1] = (daft_root){.folder = "/no/such/folder"};
    for (size_t i = 0; i < COUNT_OF(defs); i++) {
        defs[i] = daft_default_files_def();
        defs[i].roots = roots, defs[i].root_count = 1;
    }
    defs[1].cookie++;
    defs[2].roots = NULL;
    defs[3].root_count = UINT32_MAX;
    defs[4].root_count = 2;
    defs[5].max_file_bytes = 0;
    uint32_t which = choose(c, 1 + COUNT_OF(defs));
    if (which) say(c, which == 4 ? VERDICT_BAD : which == 5 ? VERDICT_ODD : VERDICT_WRONG);
    return which == COUNT_OF(defs) ? NULL : &defs[which];
}

static void count_name(void *user, const char *name) { (void)user, (void)name; }

static daft_name_callback *give_daft_name_callback_p(caller *c)
{
    if (choose(c, 2) == 0) return count_name;
    say(c, VERDICT_WRONG);
    return NULL;
}

static daft_error *give_daft_error_p(caller *c) { return c->no_error ? NULL : &c->error; }

static const daft_error *give_const_daft_error_p(caller *c)
{
    static const daft_error EXAMPLE = {DAFT_ERROR_IO, 3, 7, "file", "message"};
    return choose(c, 2) ? NULL : &EXAMPLE;
}

/* ---- structs in ---- */

/* A struct of the list daft_fields gives: NULL, a wrong cookie, then field by field what is no number, or a handle that
 * is none of this scene's. */
static const void *give_struct(caller *c, daft_struct which, const void *good, bool optional)
{
    static const double BAD[] = {NAN, INFINITY, -INFINITY, -7, 1e30};
    uint32_t count;
    const daft_field *fields = daft_fields(which, &count);
    uint32_t chosen = choose(c, 3 + count * (uint32_t)COUNT_OF(BAD));
    memcpy(c->value, good, daft_struct_size(which));
    if (chosen == 0) return c->value;
    if (chosen == 1) {
        say(c, optional ? VERDICT_ODD : VERDICT_WRONG);
        return NULL;
    }
    if (chosen == 2) {
        bool has_cookie = strcmp(fields[0].name, "cookie") == 0;
        if (!has_cookie) return c->value;
        say(c, VERDICT_WRONG);
        memset(c->value, 0x5a, sizeof(uint32_t));
        return c->value;
    }
    const daft_field *field = &fields[(chosen - 3) % count];
    double bad = BAD[(chosen - 3) / count];
    char *at = c->value + field->offset;
    bool single = field->type == DAFT_FIELD_FLOAT || field->type == DAFT_FIELD_VEC2 || field->type == DAFT_FIELD_VEC3 ||
                  field->type == DAFT_FIELD_COLOR || field->type == DAFT_FIELD_DIRECTION ||
                  field->type == DAFT_FIELD_ROTATION;
    bool twice = field->type == DAFT_FIELD_DOUBLE || field->type == DAFT_FIELD_POSITION;
    if (single || twice) say(c, isfinite(bad) ? VERDICT_ODD : VERDICT_WRONG);
    if (field->type == DAFT_FIELD_CHOICE) say(c, VERDICT_WRONG);
    if (field->type >= DAFT_FIELD_INT && field->type <= DAFT_FIELD_ENTITY) say(c, VERDICT_ODD);
    float number = (float)bad;
    uint32_t whole = isnan(bad) ? UINT32_MAX : bad < 0 ? 0x80000000u : 0x00100fffu;
    if (single) memcpy(at, &number, sizeof number);
    if (twice) memcpy(at, &bad, sizeof bad);
    if (!single && !twice && field->type != DAFT_FIELD_BOOL && field->type < DAFT_FIELD_STRUCT)
        memcpy(at, &whole, sizeof whole);
    return c->value;
}

static const daft_engine_def *give_const_daft_engine_def_p(caller *c)
{
    daft_engine_def def = daft_default_engine_def();
    def.threads = 1;
    return give_struct(c, DAFT_STRUCT_ENGINE_DEF, &def, false);
}

static const daft_material_def *give_const_daft_material_def_p(caller *c)
{
    daft_material_def def = daft_default_material_def();
    return give_struct(c, DAFT_STRUCT_MATERIAL_DEF, &def, false);
}

/* The kind of shape and body by turns; a list of colliders that is not there. */
static const daft_entity_def *give_const_daft_entity_def_p(caller *c)
{
    daft_entity_def def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_SPHERE;
    def.position.y = 4;
    def.body = DAFT_BODY_DYNAMIC;
    if (c->bytes) {
        static daft_collider colliders[2];
        def.shape = (daft_shape)(next_byte(c) % 4);
        def.body = (daft_body_kind)(next_byte(c) % 4);
        def.mesh.id = c->meshes.ids[next_byte(c) % POOL];
        def.parent.id = next_byte(c) < 64 ? c->entities.ids[next_byte(c) % POOL] : 0;
        colliders[0] = colliders[1] = daft_default_collider();
        colliders[0].kind = (daft_collider_kind)(next_byte(c) % 9);
        colliders[0].radius = 0.1f * (float)next_byte(c), colliders[0].height = 0.1f * (float)next_byte(c);
        colliders[0].mesh = def.mesh;
        def.collider_count = next_byte(c) % 3;
        def.colliders = next_byte(c) < 8 ? NULL : colliders;
    }
    const daft_entity_def *given = give_struct(c, DAFT_STRUCT_ENTITY_DEF, &def, false);
    return given;
}

static const daft_joint_def *give_const_daft_joint_def_p(caller *c)
{
    daft_joint_def def = daft_default_joint_def();
    def.b.id = c->entities.ids[0];
    if (c->bytes) {
        def.kind = (daft_joint_kind)(next_byte(c) % 8);
        def.a.id = c->entities.ids[next_byte(c) % POOL], def.b.id = c->entities.ids[next_byte(c) % POOL];
        def.limit = next_byte(c) & 1, def.motor = next_byte(c) & 1, def.spring = next_byte(c) & 1;
    }
    return give_struct(c, DAFT_STRUCT_JOINT_DEF, &def, false);
}

static const daft_light_def *give_const_daft_light_def_p(caller *c)
{
    daft_light_def def = daft_default_light_def();
    return give_struct(c, DAFT_STRUCT_LIGHT_DEF, &def, false);
}

static const daft_fog *give_const_daft_fog_p(caller *c)
{
    daft_fog fog = daft_default_fog();
    return give_struct(c, DAFT_STRUCT_FOG, &fog, false);
}

static const daft_exposure *give_const_daft_exposure_p(caller *c)
{
    daft_exposure exposure = daft_default_exposure();
    return give_struct(c, DAFT_STRUCT_EXPOSURE, &exposure, false);
}

static const daft_camera *give_const_daft_camera_p(caller *c)
{
    daft_camera camera = daft_default_camera();
    return give_struct(c, DAFT_STRUCT_CAMERA, &camera, false);
}

static const daft_surfaces *give_const_daft_surfaces_p(caller *c)
{
    const daft_surfaces together = {0.5f, 0.6f, 0.1f, 0};
    return give_struct(c, DAFT_STRUCT_SURFACES, &together, true);
}

static const daft_quality *give_const_daft_quality_p(caller *c)
{
    const daft_quality quality = daft_preset_quality(DAFT_PRESET_DRAFT);
    return give_struct(c, DAFT_STRUCT_QUALITY, &quality, false);
}

static const daft_view *give_const_daft_view_p(caller *c)
{
    daft_view view = daft_default_view();
    view.history = c->history;
    return give_struct(c, DAFT_STRUCT_VIEW, &view, false);
}

static const daft_query_filter *give_const_daft_query_filter_p(caller *c)
{
    daft_query_filter filter = daft_default_query_filter();
    static _Alignas(16) char copy[sizeof filter]; /* beside a volume */
    const void *given = give_struct(c, DAFT_STRUCT_QUERY_FILTER, &filter, true);
    return given ? memcpy(copy, given, sizeof filter) : NULL;
}

static const daft_volume *give_const_daft_volume_p(caller *c)
{
    daft_volume volume = daft_default_volume();
    static _Alignas(16) char copy[sizeof volume];
    const void *given = give_struct(c, DAFT_STRUCT_VOLUME, &volume, false);
    return given ? memcpy(copy, given, sizeof volume) : NULL;
}

/* Four rays. */
static const daft_scan_def *give_const_daft_scan_def_p(caller *c)
{
    static const daft_vec3 LIST_OF[4] = {{1, 0, 0}, {0, -1, 0}, {0, 0, 2}, {1, 1, 1}};
    daft_scan_def def = daft_default_scan_def();
    def.rows = def.columns = 2;
    def.position.y = 3;
    def.rays = LIST_OF, def.ray_count = 4;
    if (c->bytes) def.pattern = (daft_scan_pattern)(next_byte(c) % 3);
    const void *given = give_struct(c, DAFT_STRUCT_SCAN_DEF, &def, false);
    static _Alignas(16) char copy[sizeof def];
    if (!given) return NULL;
    memcpy(&def, given, sizeof def);
    /* A list is as long as its caller says: of a number that is in range the library believes it, and so it is true. */
    if (def.ray_count > 4 && def.ray_count <= 268435456) def.ray_count = 4;
    return memcpy(copy, &def, sizeof def);
}

static const daft_character_def *give_const_daft_character_def_p(caller *c)
{
    daft_character_def def = daft_default_character_def();
    def.position.y = 3;
    return give_struct(c, DAFT_STRUCT_CHARACTER_DEF, &def, false);
}

static const daft_play_def *give_const_daft_play_def_p(caller *c)
{
    daft_play_def def = daft_default_play_def();
    return give_struct(c, DAFT_STRUCT_PLAY_DEF, &def, false);
}

/* Structs that are in no list of fields. */

static const daft_checkpoint *give_const_daft_checkpoint_p(caller *c)
{
    static daft_checkpoint points[4];
    for (int i = 0; i < 4; i++) points[i] = (daft_checkpoint){daft_default_camera(), i};
    uint32_t which = choose(c, 5);
    if (which) say(c, VERDICT_WRONG);
    if (which == 2) points[2].time = (double)NAN;
    if (which == 3) points[2].time = 0.5;
    if (which == 4) points[1].camera.position.y = (double)INFINITY;
    return which == 1 ? NULL : points;
}

static const daft_transform *give_const_daft_transform_p(caller *c)
{
    static daft_transform t;
    t = (daft_transform){{1, 2, 3}, {0, 0, 0, 1}, {1, 1, 1}};
    double *positions[] = {&t.position.x, &t.position.y, &t.position.z};
    float *rest[] = {&t.rotation.x, &t.rotation.y, &t.rotation.z, &t.rotation.w, &t.scale.x, &t.scale.y, &t.scale.z};
    uint32_t which = choose(c, 2 + 2 * 10);
    if (which == 0) return &t;
    say(c, VERDICT_WRONG);
    if (which == 1) return NULL;
    double bad = which % 2 ? (double)NAN : (double)INFINITY;
    uint32_t member = (which - 2) / 2;
    if (member < 3)
        *positions[member] = bad;
    else
        *rest[member - 3] = (float)bad;
    return &t;
}

static const daft_vec3 CORNERS[4] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
static const uint32_t FACES[12] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};

static const daft_mesh_def *give_const_daft_mesh_def_p(caller *c)
{
    static daft_mesh_def def;
    static const uint32_t wild[12] = {0, 2, 1, 0, 1, 3, UINT32_MAX, 3, 2, 1, 2, 4};
    static const daft_vec3 not_finite[4] = {{NAN, 0, 0}, {1, INFINITY, 0}, {0, 1, -INFINITY}, {3e38f, 0, 1}};
    def = daft_default_mesh_def();
    def.positions = CORNERS, def.vertex_count = 4, def.indices = FACES, def.triangle_count = 4;
    switch (choose(c, 11)) {
    case 0: return &def;
    case 1: say(c, VERDICT_WRONG); return NULL;
    case 2: say(c, VERDICT_WRONG), def.cookie = 1; break;
    case 3: say(c, VERDICT_WRONG), def.positions = NULL; break;
    case 4: say(c, VERDICT_WRONG), def.indices = NULL; break;
    case 5: say(c, VERDICT_WRONG), def.indices = wild; break;
    case 6: say(c, VERDICT_ODD), def.positions = not_finite; break;
    case 7: say(c, VERDICT_ODD), def.vertex_count = 0; break;
    case 8: say(c, VERDICT_ODD), def.triangle_count = 0; break;
    case 9: say(c, VERDICT_ODD), def.normals = not_finite; break;
    default: say(c, VERDICT_ODD), def.uvs = (const daft_vec2 *)not_finite;
    }
    return &def;
}

static const daft_extrude_def *give_const_daft_extrude_def_p(caller *c)
{
    static daft_extrude_def def;
    static const daft_vec2 points[6] = {{0, 0}, {2, 0}, {0, 2}, {1, 1}, {-1, 1}, {1, -1}};
    static const daft_vec2 not_finite[6] = {{0, 0}, {2, NAN}, {0, 2}, {1, 1}, {-1, INFINITY}, {1, -1}};
    static const uint32_t counts[2] = {3, 3}, wild[2] = {UINT32_MAX, 7};
    def = daft_default_extrude_def();
    def.points = points, def.point_count = 6, def.counts = counts, def.contour_count = 2;
    switch (choose(c, 9)) {
    case 0: return &def;
    case 1: say(c, VERDICT_WRONG); return NULL;
    case 2: say(c, VERDICT_WRONG), def.cookie = 1; break;
    case 3: say(c, VERDICT_WRONG), def.points = NULL; break;
    case 4: say(c, VERDICT_WRONG), def.counts = NULL; break;
    case 5: say(c, VERDICT_WRONG), def.counts = wild; break;
    case 6: say(c, VERDICT_WRONG), def.points = not_finite; break;
    case 7: say(c, VERDICT_WRONG), def.depth = NAN; break;
    default: say(c, VERDICT_WRONG), def.point_count = UINT32_MAX;
    }
    return &def;
}

static const daft_vec3 *give_const_daft_vec3_p(caller *c)
{
    static const daft_vec3 bad[4] = {{0, 0, 0}, {1, 0, NAN}, {0, INFINITY, 0}, {0, 0, 1}};
    uint32_t which = choose(c, 3);
    if (which == 0) return CORNERS;
    bool optional = is_name(c, "normals");
    say(c, optional ? VERDICT_ODD : VERDICT_WRONG);
    return which == 1 ? NULL : bad;
}

static const daft_field *give_const_daft_field_p(caller *c)
{
    c->which = DAFT_STRUCT_LIGHT_DEF;
    if (choose(c, 2) == 0) return daft_field_find(c->which, "inner_angle");
    say(c, VERDICT_WRONG);
    return NULL;
}

/* ---- bytes and text ---- */

static const void *give_const_void_p(caller *c)
{
    c->size = sizeof c->text;
    const void *good = c->text;
    if (is_function(c, "daft_scene_load_bodies")) good = c->saved, c->size = c->saved_size;
    if (is_name(c, "value")) {
        memset(c->value, 0, sizeof c->value);
        daft_struct_default(c->which, c->value);
        good = c->value;
    }
    if (choose(c, 2) == 0) return good;
    say(c, is_function(c, "daft_hash") ? VERDICT_ODD : VERDICT_BAD);
    return NULL;
}

/* The value that daft_field_parse changes, or room for a result. */
static void *give_void_p(caller *c)
{
    bool is_value = is_name(c, "value"), user = is_name(c, "user");
    if (is_value) daft_struct_default(c->which, c->value);
    if (choose(c, 2) == 0) return is_value ? (void *)c->value : user ? (void *)c : (void *)c->output;
    say(c, is_value ? VERDICT_WRONG : VERDICT_ODD);
    return NULL;
}

static char *give_char_p(caller *c) { return choose(c, 2) ? NULL : c->text; }

static const char *good_text(caller *c)
{
    static const struct {
        const char *function, *file;
    } FILES[] = {{"daft_write_file", "written.bin"},
                 {"daft_writer_begin", "written.bin"},
                 {"daft_image_load", "picture.png"},
                 {"daft_image_write", "written.png"},
                 {"daft_scene_load", "room.scene"},
                 {"daft_mesh_load", "thing.obj"},
                 {"daft_texture_load", "picture.png"},
                 {"daft_material_load", "paint.mtl"},
                 {"daft_scene_set_sky_image", "picture.png"},
                 {"daft_check_file", "room.scene"},
                 {"daft_read_file", "room.scene"}};
    for (size_t i = 0; i < COUNT_OF(FILES); i++) {
        if (!is_function(c, FILES[i].function)) continue;
        snprintf(c->path, sizeof c->path, "%s/%s", c->folder, FILES[i].file);
        return c->path;
    }
    if (is_function(c, "daft_files_find")) return "room.scene";
    if (is_function(c, "daft_files_list")) return ".";
    if (is_function(c, "daft_accel_parse")) return "kdtree";
    if (is_function(c, "daft_preset_parse")) return "high";
    if (is_function(c, "daft_intersection_parse")) return "fast";
    return is_function(c, "daft_field_parse") ? "0.25" : "color";
}

static const char *give_const_char_p(caller *c)
{
    static char long_text[5000];
    memset(long_text, 'a', sizeof long_text - 1);
    const char *bad[] = {NULL, "", long_text, "/no/such/folder/file.obj", "nan", "%s%n%d", "\n\x01\xff"};
    bool writes = strstr(c->function, "_write") != NULL; /* the last names are ones that a file may have */
    uint32_t which = choose(c, 1 + (writes ? 4 : (uint32_t)COUNT_OF(bad)));
    if (which == 0) return good_text(c);
    /* A file that is not there is a problem and no failure; a writer tells when it commits. */
    bool later = which > 1 && (is_function(c, "daft_check_file") || is_function(c, "daft_writer_begin"));
    say(c, later ? VERDICT_ODD : which == 1 ? VERDICT_WRONG : VERDICT_BAD);
    return bad[which - 1];
}

/* Of the six images of a sky. */
static const char *const *give_const_char_pconst_p(caller *c)
{
    snprintf(c->path, sizeof c->path, "%s/picture.png", c->folder);
    for (int i = 0; i < 6; i++) c->paths[i] = c->path;
    const uint32_t which = choose(c, 4);
    if (which) say(c, which == 3 ? VERDICT_BAD : VERDICT_WRONG);
    if (which > 1) c->paths[5] = which == 2 ? NULL : "/no/such/folder/file.obj";
    return which == 1 ? NULL : c->paths;
}

static void count_problem(void *user, daft_severity severity, const daft_error *problem)
{
    (void)user, (void)severity, (void)problem;
}

static daft_problem_callback *give_daft_problem_callback_p(caller *c)
{
    if (choose(c, 2) == 0) return count_problem;
    say(c, VERDICT_WRONG);
    return NULL;
}

/* ---- results: room for them, or NULL ---- */

static void *room_or_null(caller *c, verdict null)
{
    if (choose(c, 2) == 0) return c->output;
    say(c, null);
    return NULL;
}

#define GIVE_ROOM(type, null)                                                                                          \
    static type *give_##type##_p(caller *c)                                                                            \
    {                                                                                                                  \
        _Static_assert(LIST * sizeof(type) <= sizeof c->output, "there is room");                                      \
        return room_or_null(c, null);                                                                                  \
    }
GIVE_ROOM(daft_accel, VERDICT_WRONG)
GIVE_ROOM(daft_preset, VERDICT_WRONG)
GIVE_ROOM(daft_intersection, VERDICT_WRONG)
GIVE_ROOM(daft_sim_measure, VERDICT_WRONG)
GIVE_ROOM(daft_mesh, VERDICT_WRONG)
GIVE_ROOM(daft_mesh_info, VERDICT_WRONG)
GIVE_ROOM(daft_clip_info, VERDICT_WRONG)
GIVE_ROOM(daft_mesh_camera, VERDICT_WRONG)
GIVE_ROOM(daft_mesh_light, VERDICT_WRONG)
GIVE_ROOM(daft_animation, VERDICT_WRONG)
GIVE_ROOM(daft_mesh_report, VERDICT_WRONG)
GIVE_ROOM(daft_material_def, VERDICT_WRONG)
GIVE_ROOM(daft_light_def, VERDICT_WRONG)
GIVE_ROOM(daft_entity_def, VERDICT_WRONG)
GIVE_ROOM(daft_joint_state, VERDICT_WRONG)
GIVE_ROOM(daft_character_state, VERDICT_WRONG)
GIVE_ROOM(daft_transform, VERDICT_WRONG)
GIVE_ROOM(daft_camera, VERDICT_WRONG)
GIVE_ROOM(daft_checkpoint, VERDICT_WRONG)
GIVE_ROOM(daft_named_entity, VERDICT_WRONG)
GIVE_ROOM(daft_dvec3, VERDICT_ODD) /* the corners of bounds, which an empty scene has not */
GIVE_ROOM(float, VERDICT_WRONG)
GIVE_ROOM(double, VERDICT_ODD) /* when a ray of a scan leaves */
GIVE_ROOM(bool, VERDICT_WRONG)
GIVE_ROOM(uint32_t, VERDICT_ODD)       /* daft_fields' count */
GIVE_ROOM(size_t, VERDICT_ODD)         /* daft_read_file's size */
GIVE_ROOM(daft_vec3, VERDICT_ODD)      /* either velocity */
GIVE_ROOM(daft_event, VERDICT_ODD)     /* lists tell how long they are */
GIVE_ROOM(daft_entity, VERDICT_ODD)    /* the same */
GIVE_ROOM(daft_contact, VERDICT_ODD)   /* the same */
GIVE_ROOM(daft_body_edge, VERDICT_ODD) /* the same */
GIVE_ROOM(daft_query_hit, VERDICT_ODD) /* whether something is hit */
GIVE_ROOM(daft_ray_hit, VERDICT_ODD)   /* the same */

static daft_scan_return *give_daft_scan_return_p(caller *c)
{
    static daft_scan_return returns[2][4];
    const bool last = strcmp(c->name, "last") == 0;
    if (choose(c, 2) == 0) return returns[last];
    say(c, last ? VERDICT_ODD : VERDICT_WRONG);
    return NULL;
}

/* ---- what comes back ---- */

static void took_nothing(caller *c) { c->succeeded = false; }
static void took_bool(caller *c, bool r) { c->succeeded = r; }
static void took_int(caller *c, int r) { c->succeeded = r != 0; }
static void took_uint32_t(caller *c, uint32_t r) { c->succeeded = r != 0; }
static void took_uint64_t(caller *c, uint64_t r) { c->succeeded = r != 0; }
static void took_size_t(caller *c, size_t r) { c->succeeded = r != 0; }
static void took_const_char_p(caller *c, const char *r) { c->succeeded = r != NULL; }
static void took_uint8_t_p(caller *c, const uint8_t *r) { c->succeeded = r != NULL; }
static void took_const_daft_field_p(caller *c, const daft_field *r) { c->succeeded = r != NULL; }
static void took_const_daft_counters_p(caller *c, const daft_counters *r) { c->succeeded = r != NULL; }

static void took_daft_engine_p(caller *c, daft_engine *made)
{
    c->succeeded = made != NULL;
    daft_engine_destroy(made);
}

static void took_daft_scene_p(caller *c, daft_scene *made)
{
    c->succeeded = made != NULL;
    daft_scene_destroy(made);
}

static void took_daft_files_p(caller *c, daft_files *made)
{
    c->succeeded = made != NULL;
    daft_files_destroy(made);
}

/* What daft_read_file read. */
static void took_void_p(caller *c, void *made)
{
    c->succeeded = made != NULL;
    free(made);
}

static void took_daft_writer_p(caller *c, daft_writer *made)
{
    c->succeeded = made != NULL;
    daft_writer_abandon(made);
}

static void took_daft_history_p(caller *c, daft_history *made)
{
    c->succeeded = made != NULL;
    daft_history_destroy(made);
}

static void took_daft_image_p(caller *c, daft_image *made)
{
    c->succeeded = made != NULL;
    daft_image_destroy(made);
}

static void keep(caller *c, pool *in, uint32_t id)
{
    c->succeeded = id != 0;
    if (id) in->ids[in->count++ % POOL] = id;
}

static void took_daft_entity(caller *c, daft_entity made) { keep(c, &c->entities, made.id); }
static void took_daft_mesh(caller *c, daft_mesh made) { keep(c, &c->meshes, made.id); }
static void took_daft_texture(caller *c, daft_texture made) { keep(c, &c->textures, made.id); }
static void took_daft_material(caller *c, daft_material made) { keep(c, &c->materials, made.id); }
static void took_daft_light(caller *c, daft_light made) { keep(c, &c->lights, made.id); }
static void took_daft_joint(caller *c, daft_joint made) { keep(c, &c->joints, made.id); }
static void took_daft_character(caller *c, daft_character made) { keep(c, &c->characters, made.id); }

/* Structs and doubles do not tell whether a call succeeded. */
#define TOOK_VALUE(type)                                                                                               \
    static void took_##type(caller *c, type r)                                                                         \
    {                                                                                                                  \
        (void)r;                                                                                                       \
        c->succeeded = false;                                                                                          \
    }
TOOK_VALUE(double)
TOOK_VALUE(daft_camera)
TOOK_VALUE(daft_vec3)
TOOK_VALUE(daft_memory)
TOOK_VALUE(daft_sim_counters)
TOOK_VALUE(daft_sim_times)
TOOK_VALUE(daft_engine_def)
TOOK_VALUE(daft_files_def)
TOOK_VALUE(daft_mesh_def)
TOOK_VALUE(daft_extrude_def)
TOOK_VALUE(daft_material_def)
TOOK_VALUE(daft_collider)
TOOK_VALUE(daft_entity_def)
TOOK_VALUE(daft_joint_def)
TOOK_VALUE(daft_light_def)
TOOK_VALUE(daft_quality)
TOOK_VALUE(daft_fog)
TOOK_VALUE(daft_exposure)
TOOK_VALUE(daft_view)
TOOK_VALUE(daft_query_filter)
TOOK_VALUE(daft_volume)
TOOK_VALUE(daft_scan_def)
TOOK_VALUE(daft_character_def)
TOOK_VALUE(daft_play_def)

#include "misuse_calls.inc" /* by calls.awk: a call for each function of daft.h, and CALLS */

const size_t CALL_COUNT = COUNT_OF(CALLS);

/* ---- the world ---- */

static void count_warning(void *user, const daft_error *warning)
{
    caller *c = user;
    c->warnings++;
    if (c->warn) c->warn(c->warn_user, warning);
}

static void write_text(const char *folder, const char *name, const char *text)
{
    char path[128];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "w");
    REQUIRE(file && fputs(text, file) >= 0 && fclose(file) == 0);
}

static void write_picture(const char *folder)
{
    char path[128];
    daft_engine_def def = daft_default_engine_def();
    daft_engine *engine = daft_engine_create(&def, NULL);
    daft_image *image = daft_image_create(engine, 2, 2, NULL);
    snprintf(path, sizeof path, "%s/picture.png", folder);
    REQUIRE(daft_image_write(image, path, NULL));
    daft_image_destroy(image);
    daft_engine_destroy(engine);
}

void calls_folder_make(char folder[64])
{
    const char *temporary = getenv("TMPDIR");
    snprintf(folder, 64, "%.32s/daft-calls-XXXXXX", temporary && temporary[0] ? temporary : "/tmp");
    REQUIRE(mkdtemp(folder));
    write_text(folder, "thing.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    write_text(folder, "paint.mtl", "newmtl red\nKd 1 0 0\n");
    write_text(folder, "lost.mtl", "newmtl red\nmap_Kd none.png\n");
    write_text(folder, "room.scene", "camera 0 1 0\nlight 0 5 0 1 1 1\nsphere 3 0 0 1 paint.mtl name=ball\n");
    write_text(folder, "film.scene", "path 0 0 1 0 0 0\npath 1 1 1 0 0 0\n");
    write_picture(folder);
}

void calls_folder_remove(const char *folder)
{
    static const char *const NAMES[] = {"thing.obj",  "paint.mtl",   "lost.mtl",    "film.scene",
                                        "room.scene", "picture.png", "written.bin", "written.png"};
    char path[128];
    for (size_t i = 0; i < COUNT_OF(NAMES); i++) {
        snprintf(path, sizeof path, "%s/%s", folder, NAMES[i]);
        unlink(path);
    }
    rmdir(folder);
}

static daft_entity add_entity(daft_scene *scene, daft_shape shape, daft_body_kind body, double y)
{
    daft_entity_def def = daft_default_entity_def();
    def.shape = shape, def.body = body, def.position.y = y;
    if (shape == DAFT_SHAPE_BOX) def.size = (daft_vec3){20, 1, 20};
    daft_entity made = daft_entity_create(scene, &def, NULL);
    REQUIRE(made.id);
    return made;
}

/* The first of each pool, and one that is destroyed again. */
static void fill_scene(caller *c)
{
    daft_scene *s = c->scene;
    add_entity(s, DAFT_SHAPE_BOX, DAFT_BODY_STATIC, -0.5);
    keep(c, &c->entities, add_entity(s, DAFT_SHAPE_SPHERE, DAFT_BODY_DYNAMIC, 2).id);
    keep(c, &c->entities, add_entity(s, DAFT_SHAPE_NONE, DAFT_BODY_NONE, 4).id);
    daft_entity gone = add_entity(s, DAFT_SHAPE_SPHERE, DAFT_BODY_NONE, 9);
    c->entities.stale = gone.id;
    daft_mesh_def mesh = daft_default_mesh_def();
    mesh.positions = CORNERS, mesh.vertex_count = 4, mesh.indices = FACES, mesh.triangle_count = 4;
    keep(c, &c->meshes, daft_mesh_create(s, &mesh, NULL).id);
    char picture[512];
    snprintf(picture, sizeof picture, "%s/picture.png", c->folder);
    keep(c, &c->textures, daft_texture_load(s, picture, NULL).id);
    daft_material_def material = daft_default_material_def();
    keep(c, &c->materials, daft_material_create(s, &material, NULL).id);
    daft_light_def light = daft_default_light_def();
    keep(c, &c->lights, daft_light_create(s, &light, NULL).id);
    c->lights.stale = daft_light_create(s, &light, NULL).id;
    REQUIRE(daft_light_destroy(s, (daft_light){c->lights.stale}, NULL));
    daft_joint_def joint = daft_default_joint_def();
    joint.b.id = c->entities.ids[0];
    keep(c, &c->joints, daft_joint_create(s, &joint, NULL).id);
    c->joints.stale = daft_joint_create(s, &joint, NULL).id;
    REQUIRE(daft_joint_destroy(s, (daft_joint){c->joints.stale}, NULL));
    daft_character_def character = daft_default_character_def();
    character.position = (daft_dvec3){3, 1.2, 0};
    keep(c, &c->characters, daft_character_create(s, &character, NULL).id);
    c->characters.stale = daft_character_create(s, &character, NULL).id;
    REQUIRE(daft_character_destroy(s, (daft_character){c->characters.stale}, NULL));
    REQUIRE(daft_entity_destroy(s, gone, NULL));
    REQUIRE(c->joints.ids[0] && c->lights.ids[0] && c->characters.ids[0] && c->meshes.ids[0]);
    c->meshes.stale = c->materials.stale = c->textures.stale = 999;
}

static void make_scene(caller *c)
{
    char path[128];
    pool *pools[] = {&c->entities, &c->meshes, &c->textures, &c->materials, &c->lights, &c->joints, &c->characters};
    for (size_t i = 0; i < COUNT_OF(pools); i++) *pools[i] = (pool){0};
    c->scene = daft_scene_create(c->engine, NULL);
    REQUIRE(c->scene);
    fill_scene(c);
    for (size_t i = 0; i < COUNT_OF(pools); i++) pools[i]->foreign = pools[i]->ids[0] + 4; /* a later slot's */
    snprintf(path, sizeof path, "%s/room.scene", c->folder);
    REQUIRE(daft_scene_load(c->scene, path, NULL));
    snprintf(path, sizeof path, "%s/film.scene", c->folder);
    REQUIRE(daft_scene_load(c->scene, path, NULL));
    REQUIRE(daft_scene_step(c->scene, 1.0f / 60, NULL));
    free(c->saved);
    c->saved_size = daft_scene_save_bodies(c->scene, NULL, 0, NULL);
    c->saved = malloc(c->saved_size);
    REQUIRE(c->saved && daft_scene_save_bodies(c->scene, c->saved, c->saved_size, NULL) == c->saved_size);
}

static void make_image(caller *c)
{
    c->image = daft_image_create(c->engine, 8, 8, NULL);
    REQUIRE(c->image);
}

static void make_history(caller *c)
{
    c->history = daft_history_create(c->engine, NULL);
    REQUIRE(c->history);
}

void caller_open(caller *c)
{
    daft_engine_def def = daft_default_engine_def();
    def.threads = 1;
    def.allocator = c->allocator;
    def.warn = count_warning, def.warn_user = c;
    c->engine = daft_engine_create(&def, NULL);
    REQUIRE(c->engine);
    daft_root root = {.folder = c->folder};
    daft_files_def roots = daft_default_files_def();
    roots.roots = &root, roots.root_count = 1;
    REQUIRE(c->files = daft_files_create(&roots, NULL));
    make_image(c);
    make_history(c);
    make_scene(c);
    c->argument = -1;
}

void caller_close(caller *c)
{
    daft_scene_destroy(c->scene);
    daft_image_destroy(c->image);
    daft_history_destroy(c->history);
    daft_engine_destroy(c->engine);
    daft_files_destroy(c->files);
    free(c->saved);
    c->scene = NULL, c->engine = NULL, c->image = NULL, c->history = NULL, c->saved = NULL;
}

void caller_mend(caller *c)
{
    if (!c->image) make_image(c);
    if (!c->history) make_history(c);
    if (!c->scene) make_scene(c);
}

/* No mesh here has clips, cameras and lights, which come from files that Assimp reads. */
static bool takes_clips(const caller *c)
{
    static const char *const NAMES[] = {"daft_mesh_get_clip",        "daft_mesh_find_clip",
                                        "daft_entity_get_mesh",      "daft_entity_play",
                                        "daft_entity_get_animation", "daft_entity_set_animation_time",
                                        "daft_mesh_get_camera",      "daft_mesh_get_light"};
    for (size_t i = 0; i < COUNT_OF(NAMES); i++)
        if (is_function(c, NAMES[i])) return true;
    return false;
}

void caller_make(caller *c, size_t index)
{
    c->function = CALLS[index].function;
    c->said = takes_clips(c) ? VERDICT_ODD : VERDICT_GOOD;
    c->object_missing = c->succeeded = false;
    c->size = 0;
    c->which = DAFT_STRUCT_LIGHT_DEF;
    memset(&c->error, 0, sizeof c->error);
    CALLS[index].make(c);
    daft_writer_abandon(c->writer);
    c->writer = NULL;
    if (!c->nested) caller_mend(c);
}
