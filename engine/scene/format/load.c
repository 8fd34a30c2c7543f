/* The .scene format (docs have the whole): every line becomes an item of a list, then all files are loaded that the
 * items name, then room is made for everything, and only then, when nothing can fail any more, the scene changes.
 * Angles are degrees here and nowhere else. */
#include "math/trig.h"
#include "scene/format/load.h"
#include "scene/format/text.h"

#include <ctype.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

enum { MAX_INCLUDES = 16, MAX_PATH = 1024 };

typedef daft_scene_item item;

/* A file that is being read, and the one that includes it. */
typedef struct source {
    const char *path;
    dev_t device;
    ino_t inode;
    const struct source *parent;
    int depth;
} source;

typedef struct loader {
    daft_scene *scene;
    daft_arena arena; /* paths */
    item *items;
    size_t count, capacity;
    daft_sky_item *sky;            /* the last one named, or NULL */
    const daft_scene_watch *watch; /* or NULL */
    daft_error error;
} loader;

typedef struct reader {
    loader *loader;
    daft_scene_text text;
    const source *source;
    int column; /* of the keyword */
} reader;

static bool read_file(loader *load, const char *path, const source *parent);

/* ---- fields ---- */

static bool read_position(reader *read, daft_dvec3 *out)
{
    const char *allowed = "a finite number";
    return daft_scene_text_number(&read->text, "x", -DBL_MAX, DBL_MAX, allowed, &out->x) &&
           daft_scene_text_number(&read->text, "y", -DBL_MAX, DBL_MAX, allowed, &out->y) &&
           daft_scene_text_number(&read->text, "z", -DBL_MAX, DBL_MAX, allowed, &out->z);
}

static bool read_float(reader *read, const char *what, double low, double high, const char *allowed, float *out)
{
    double value;
    if (!daft_scene_text_number(&read->text, what, low, high, allowed, &value)) return false;
    *out = (float)value;
    return true;
}

static bool read_color(reader *read, daft_vec3 *out)
{
    const char *allowed = "0 or more (1 is full)";
    return read_float(read, "r", 0, DAFT_ANY_FLOAT, allowed, &out->x) &&
           read_float(read, "g", 0, DAFT_ANY_FLOAT, allowed, &out->y) &&
           read_float(read, "b", 0, DAFT_ANY_FLOAT, allowed, &out->z);
}

static bool read_degrees(reader *read, const char *what, double *radians)
{
    double degrees;
    if (!daft_scene_text_number(&read->text, what, -1e7, 1e7, "between -1e7 and 1e7 degrees", &degrees)) return false;
    *radians = degrees * (DAFT_PI / 180);
    return true;
}

/* A path, joined to the folder of the file that names it and kept in the arena. */
static bool read_path(reader *read, const char *what, item *into)
{
    daft_token token;
    char name[MAX_PATH], joined[MAX_PATH];
    if (!daft_scene_text_word(&read->text, what, &token)) return false;
    into->column = token.column;
    bool fits = token.length < sizeof name;
    if (fits) {
        memcpy(name, token.text, token.length);
        name[token.length] = 0;
        fits = daft_path_beside(read->source->path, name, joined, sizeof joined);
    }
    if (!fits)
        return daft_scene_text_fail(&read->text, token.column, "the path has more than %d characters", MAX_PATH - 1);
    size_t size = strlen(joined) + 1;
    char *copy = daft_arena_alloc(&read->loader->arena, size, 1);
    if (!copy) return daft_fail_memory(&read->loader->error, "a scene file's paths");
    into->path = memcpy(copy, joined, size);
    return true;
}

/* ---- options: name=value after an item's numbers and paths, for the fields that have .scene names ---- */

enum { LONGEST_OPTION = 200 };

/* The word that comes next, if it is an option: a letter first, a '=' in it. */
static size_t option_length(daft_scene_text *text)
{
    if (daft_scene_text_ends(text) || !isalpha((unsigned char)*text->at)) return 0;
    const char *at = text->at;
    bool equals = false;
    for (; at < text->end && !strchr(" \t\r\n", *at); at++) equals |= *at == '=';
    return equals ? (size_t)(at - text->at) : 0;
}

/* Whether one of an item's optional numbers comes next. */
static bool more_numbers(reader *read) { return !daft_scene_text_ends(&read->text) && option_length(&read->text) == 0; }

static const daft_field *option_field(daft_struct which, const char *name)
{
    uint32_t count;
    const daft_field *fields = daft_fields(which, &count);
    for (uint32_t i = 0; i < count; i++)
        if (fields[i].scene && strcmp(fields[i].scene, name) == 0) return &fields[i];
    return NULL;
}

static bool fail_option(reader *read, int column, daft_struct which, const char *name)
{
    char known[LONGEST_OPTION] = "";
    uint32_t count;
    const daft_field *fields = daft_fields(which, &count);
    for (uint32_t i = 0; i < count; i++)
        if (fields[i].scene)
            snprintf(known + strlen(known), sizeof known - strlen(known), "%s%s", *known ? ", " : "", fields[i].scene);
    return daft_scene_text_fail(&read->text, column, "unknown option '%.40s'; known are %s", name, known);
}

/* Angles are degrees here. */
static bool set_option(const daft_field *field, const char *value, void *out, daft_error *error)
{
    daft_field shown = *field;
    bool angle = field->unit && strcmp(field->unit, "rad") == 0;
    double numbers[4], degree = DAFT_PI / 180;
    shown.name = field->scene;
    if (angle) shown.unit = "degrees", shown.min /= degree, shown.max /= degree;
    if (!daft_field_parse(&shown, value, out, error)) return false;
    if (!angle) return true;
    uint32_t count = daft_field_numbers(field, out, numbers);
    for (uint32_t i = 0; i < count; i++) numbers[i] *= degree;
    daft_field_set_numbers(field, out, numbers);
    return true;
}

static bool read_options(reader *read, daft_struct which, void *out)
{
    for (size_t length; (length = option_length(&read->text)) > 0;) {
        daft_token token;
        char text[LONGEST_OPTION];
        daft_error why;
        if (!daft_scene_text_word(&read->text, "an option", &token)) return false;
        snprintf(text, sizeof text, "%.*s", (int)token.length, token.text);
        char *value = strchr(text, '=');
        if (token.length >= sizeof text || !value)
            return daft_scene_text_fail(&read->text, token.column, "the option has more than %d characters",
                                        LONGEST_OPTION - 1);
        *value++ = 0;
        const daft_field *field = option_field(which, text);
        if (!field) return fail_option(read, token.column, which, text);
        if (!set_option(field, value, out, &why))
            return daft_scene_text_fail(&read->text, token.column, "%s", why.message);
    }
    return true;
}

/* ---- items ---- */

static bool read_camera(reader *read, item *out)
{
    out->kind = DAFT_ITEM_CAMERA;
    out->camera = daft_default_camera();
    if (!read_position(read, &out->camera.position)) return false;
    if (!more_numbers(read)) return true;
    double pitch, yaw, fov;
    if (!read_degrees(read, "pitch", &pitch) || !read_degrees(read, "yaw", &yaw)) return false;
    out->camera.pitch = (float)pitch;
    out->camera.yaw = (float)yaw;
    if (!more_numbers(read)) return true;
    if (!daft_scene_text_number(&read->text, "fov", 1e-4, 179.99, "above 0 and below 180 degrees", &fov)) return false;
    out->camera.fov = (float)(fov * (DAFT_PI / 180));
    return true;
}

static bool read_skybox(reader *read, item *out)
{
    out->kind = DAFT_ITEM_SKYBOX;
    return read_path(read, "the path of an image", out);
}

static bool read_light(reader *read, item *out)
{
    out->kind = DAFT_ITEM_LIGHT;
    out->light = daft_default_light_def();
    return read_position(read, &out->light.position) && read_color(read, &out->light.color);
}

/* name: of the light, for what is said. */
static bool read_direction(reader *read, const char *name, daft_vec3 *d)
{
    const char *allowed = "a finite number";
    daft_scene_text_ends(&read->text);
    int column = (int)(read->text.at - read->text.line_start) + 1;
    if (!read_float(read, "dx", -DAFT_ANY_FLOAT, DAFT_ANY_FLOAT, allowed, &d->x) ||
        !read_float(read, "dy", -DAFT_ANY_FLOAT, DAFT_ANY_FLOAT, allowed, &d->y) ||
        !read_float(read, "dz", -DAFT_ANY_FLOAT, DAFT_ANY_FLOAT, allowed, &d->z))
        return false;
    if (d->x != 0 || d->y != 0 || d->z != 0) return true;
    return daft_scene_text_fail(&read->text, column, "the %s's direction is 0 0 0; it must have a length", name);
}

static bool read_sun(reader *read, item *out)
{
    out->kind = DAFT_ITEM_LIGHT;
    out->light = daft_default_light_def();
    out->light.kind = DAFT_LIGHT_SUN;
    return read_direction(read, "sun", &out->light.direction) && read_color(read, &out->light.color);
}

static bool read_cone(reader *read, daft_light_def *out)
{
    double outer, inner;
    if (!more_numbers(read)) return true;
    if (!daft_scene_text_number(&read->text, "angle", 1e-4, 180, "above 0 and at most 180 degrees", &outer))
        return false;
    inner = 0.75 * outer;
    if (more_numbers(read) &&
        !daft_scene_text_number(&read->text, "inner", 0, outer, "0 or more and at most the angle before it", &inner))
        return false;
    out->outer_angle = fminf((float)(outer * (DAFT_PI / 180)), (float)DAFT_PI);
    out->inner_angle = fminf((float)(inner * (DAFT_PI / 180)), out->outer_angle);
    return true;
}

static bool read_spot(reader *read, item *out)
{
    out->kind = DAFT_ITEM_LIGHT;
    out->light = daft_default_light_def();
    out->light.kind = DAFT_LIGHT_SPOT;
    return read_position(read, &out->light.position) && read_direction(read, "spot", &out->light.direction) &&
           read_color(read, &out->light.color) && read_cone(read, &out->light);
}

static bool read_ambient(reader *read, item *out)
{
    out->kind = DAFT_ITEM_AMBIENT;
    return read_color(read, &out->ambient);
}

static bool read_sphere(reader *read, item *out)
{
    out->kind = DAFT_ITEM_SPHERE;
    out->entity = daft_default_entity_def();
    out->entity.shape = DAFT_SHAPE_SPHERE;
    return read_position(read, &out->entity.position) &&
           read_float(read, "r", DAFT_ABOVE_ZERO, DAFT_ANY_FLOAT, "above 0 (metres)", &out->entity.radius) &&
           read_path(read, "the path of an .mtl file", out);
}

static daft_quat axis_turn(int axis, double angle)
{
    float s = (float)daft_sin(angle / 2), c = (float)daft_cos(angle / 2);
    return (daft_quat){axis == 0 ? s : 0, axis == 1 ? s : 0, axis == 2 ? s : 0, c};
}

static bool read_scale(reader *read, float *out)
{
    const char *allowed = "a finite number that is not 0";
    daft_scene_text_ends(&read->text);
    int column = (int)(read->text.at - read->text.line_start) + 1;
    if (!read_float(read, "scale", -DAFT_ANY_FLOAT, DAFT_ANY_FLOAT, allowed, out)) return false;
    return *out != 0 || daft_scene_text_fail(&read->text, column, "scale is 0; it must be %s", allowed);
}

static bool read_mesh(reader *read, item *out)
{
    out->kind = DAFT_ITEM_MESH;
    out->entity = daft_default_entity_def();
    out->entity.shape = DAFT_SHAPE_MESH;
    if (!read_path(read, "the path of a mesh", out) || !read_position(read, &out->entity.position)) return false;
    if (!more_numbers(read)) return true;
    float scale;
    if (!read_scale(read, &scale)) return false;
    out->entity.scale = daft_v3(scale, scale, scale);
    if (!more_numbers(read)) return true;
    double x, y, z;
    if (!read_degrees(read, "rot_x", &x) || !read_degrees(read, "rot_y", &y) || !read_degrees(read, "rot_z", &z))
        return false;
    /* about X first: the rightmost factor turns the mesh first */
    out->entity.rotation = daft_quat_mul(axis_turn(2, z), daft_quat_mul(axis_turn(1, y), axis_turn(0, x)));
    return true;
}

static const struct {
    const char *word, *usage;
    bool (*read)(reader *read, item *out);
    daft_struct options; /* whose fields may follow; DAFT_STRUCT_COUNT: none */
    size_t offset;       /* of that struct in an item */
} KEYWORDS[] = {
    {"camera", "camera x y z [pitch yaw [fov]]", read_camera, DAFT_STRUCT_CAMERA, offsetof(item, camera)},
    {"skybox", "skybox path", read_skybox, DAFT_STRUCT_COUNT, 0},
    {"light", "light x y z r g b", read_light, DAFT_STRUCT_LIGHT_DEF, offsetof(item, light)},
    {"sphere", "sphere x y z r material_path", read_sphere, DAFT_STRUCT_ENTITY_DEF, offsetof(item, entity)},
    {"mesh", "mesh mesh_path x y z [scale [rot_x rot_y rot_z]]", read_mesh, DAFT_STRUCT_ENTITY_DEF,
     offsetof(item, entity)},
    {"sun", "sun dx dy dz r g b", read_sun, DAFT_STRUCT_LIGHT_DEF, offsetof(item, light)},
    {"spot", "spot x y z dx dy dz r g b [angle [inner]]", read_spot, DAFT_STRUCT_LIGHT_DEF, offsetof(item, light)},
    {"ambient", "ambient r g b", read_ambient, DAFT_STRUCT_COUNT, 0},
    {"include", "include path", NULL, DAFT_STRUCT_COUNT, 0},
};

static bool fail_unknown(reader *read, daft_token word)
{
    char known[256] = "";
    for (size_t i = 0; i < DAFT_COUNT_OF(KEYWORDS); i++) {
        if (i > 0) strcat(known, ", ");
        strcat(known, KEYWORDS[i].word);
    }
    return daft_scene_text_fail(&read->text, word.column, "unknown item '%s'; known are %s", daft_token_show(word).text,
                                known);
}

/* ---- files ---- */

/* An error about a file as a whole is told where the .scene file names it; one with a line of its own stays. */
static bool fail_inside(loader *load, const item *named)
{
    daft_error inner = load->error;
    if (inner.code == DAFT_ERROR_MEMORY || inner.line > 0) return false;
    return daft_fail_at(&load->error, inner.code, named->source, named->line, named->column, "%s%s%s", inner.file,
                        inner.file[0] ? ": " : "", inner.message);
}

/* Whether a watch takes the error, so that the load goes on. Memory that is out ends it. */
static bool goes_on(loader *load)
{
    if (!load->watch || load->error.code == DAFT_ERROR_MEMORY) return false;
    load->watch->refused(load->watch->user, &load->error);
    return true;
}

static bool read_include(reader *read, item *named)
{
    if (!read_path(read, "the path of a .scene file", named) || !daft_scene_text_finish(&read->text)) return false;
    if (read->source->depth == MAX_INCLUDES)
        return daft_scene_text_fail(&read->text, named->column, "includes are more than %d deep", MAX_INCLUDES);
    struct stat status;
    bool exists = stat(named->path, &status) == 0;
    for (const source *above = read->source; exists && above; above = above->parent)
        if (above->device == status.st_dev && above->inode == status.st_ino)
            return daft_scene_text_fail(&read->text, named->column, "%.300s includes itself", named->path);
    return read_file(read->loader, named->path, read->source) || fail_inside(read->loader, named);
}

static bool keep_item(loader *load, const item *made)
{
    if (!daft_grow(load->scene->allocator, &load->items, &load->capacity, load->count + 1, load->count, sizeof *made))
        return daft_fail_memory(&load->error, "a scene file");
    load->items[load->count++] = *made;
    return true;
}

static bool read_line(reader *read)
{
    daft_token word;
    read->text.usage = "an item and its values";
    if (!daft_scene_text_word(&read->text, "an item", &word)) return false;
    item made = {.source = read->source->path, .line = read->text.line, .column = word.column};
    for (size_t i = 0; i < DAFT_COUNT_OF(KEYWORDS); i++) {
        if (strlen(KEYWORDS[i].word) != word.length || memcmp(KEYWORDS[i].word, word.text, word.length) != 0) continue;
        read->text.usage = KEYWORDS[i].usage;
        if (!KEYWORDS[i].read) return read_include(read, &made);
        return KEYWORDS[i].read(read, &made) &&
               (KEYWORDS[i].options == DAFT_STRUCT_COUNT ||
                read_options(read, KEYWORDS[i].options, (char *)&made + KEYWORDS[i].offset)) &&
               daft_scene_text_finish(&read->text) && keep_item(read->loader, &made);
    }
    return fail_unknown(read, word);
}

static bool read_lines(reader *read)
{
    bool any = false;
    while (daft_scene_text_line(&read->text)) {
        if (!read_line(read)) {
            if (!goes_on(read->loader)) return false;
            daft_scene_text_skip_line(&read->text);
        }
        any = true;
    }
    return any || daft_fail_at(&read->loader->error, DAFT_ERROR_SYNTAX, read->source->path, read->text.line, 1,
                               "no item in the file; expected at least one, as in: camera 0 0 0");
}

static bool read_file(loader *load, const char *path, const source *parent)
{
    const daft_allocator *allocator = load->scene->allocator;
    source self = {.path = path, .parent = parent, .depth = parent ? parent->depth + 1 : 0};
    struct stat status;
    if (stat(path, &status) == 0) {
        self.device = status.st_dev;
        self.inode = status.st_ino;
    }
    size_t size;
    char *bytes = daft_file_read(allocator, path, &size, &load->error);
    if (!bytes) return false;
    reader read = {.loader = load, .source = &self};
    read.text = daft_scene_text_open(path, bytes, size, &load->error);
    bool done = read_lines(&read);
    daft_release(allocator, bytes);
    return done;
}

/* ---- assets, then the scene itself ---- */

static bool load_sky(loader *load, const char *path)
{
    daft_sky_item *sky = daft_sky_item_read(load->scene, path, &load->error);
    if (!sky) return false;
    daft_sky_item_free(load->scene, load->sky);
    load->sky = sky;
    return true;
}

static bool load_asset(loader *load, item *named)
{
    daft_scene *scene = load->scene;
    daft_entity_def *entity = &named->entity;
    switch (named->kind) {
    case DAFT_ITEM_SKYBOX: return load_sky(load, named->path);
    case DAFT_ITEM_SPHERE:
        entity->material = daft_material_load(scene, named->path, &load->error);
        return entity->material.id && daft_entity_check(scene, entity, &load->error);
    case DAFT_ITEM_MESH:
        entity->mesh = daft_mesh_load(scene, named->path, &load->error);
        return entity->mesh.id && daft_entity_check(scene, entity, &load->error);
    case DAFT_ITEM_LIGHT: return daft_light_check(&named->light, &load->error);
    case DAFT_ITEM_CAMERA: return daft_check_camera(&load->error, "camera", &named->camera);
    case DAFT_ITEM_AMBIENT:
    case DAFT_ITEM_REFUSED: break;
    }
    return true;
}

static bool reserve(loader *load)
{
    uint32_t cameras = 0, lights = 0, entities = 0;
    for (size_t i = 0; i < load->count; i++) {
        cameras += load->items[i].kind == DAFT_ITEM_CAMERA;
        lights += load->items[i].kind == DAFT_ITEM_LIGHT;
        entities += load->items[i].kind == DAFT_ITEM_SPHERE || load->items[i].kind == DAFT_ITEM_MESH;
    }
    return daft_cameras_reserve(load->scene, cameras, &load->error) &&
           daft_lights_reserve(load->scene, lights, &load->error) &&
           daft_entities_reserve(load->scene, entities, &load->error);
}

/* Cannot fail. */
static void commit(loader *load)
{
    daft_scene *scene = load->scene;
    for (size_t i = 0; i < load->count; i++) {
        const item *made = &load->items[i];
        switch (made->kind) {
        case DAFT_ITEM_CAMERA: daft_camera_insert(scene, &made->camera); break;
        case DAFT_ITEM_LIGHT: daft_light_insert(scene, &made->light); break;
        case DAFT_ITEM_AMBIENT: scene->ambient = made->ambient; break;
        case DAFT_ITEM_SPHERE:
        case DAFT_ITEM_MESH: daft_entity_insert(scene, &made->entity, DAFT_NONE, NULL); break;
        case DAFT_ITEM_SKYBOX:
        case DAFT_ITEM_REFUSED: break;
        }
    }
    if (load->sky) daft_sky_adopt(scene, load->sky);
    load->sky = NULL;
}

static bool load_all(loader *load, const char *path)
{
    if (!read_file(load, path, NULL)) return false;
    for (size_t i = 0; i < load->count; i++) {
        if (load_asset(load, &load->items[i])) continue;
        fail_inside(load, &load->items[i]);
        if (!goes_on(load)) return false;
        load->items[i].kind = DAFT_ITEM_REFUSED;
    }
    return reserve(load);
}

bool daft_scene_load(daft_scene *scene, const char *path, daft_error *error)
{
    daft_error_clear(error);
    if (!daft_check_pointer(error, "scene", scene) || !daft_check_pointer(error, "path", path)) return false;
    return daft_scene_load_watched(scene, path, NULL, error);
}

bool daft_scene_load_watched(daft_scene *scene, const char *path, const daft_scene_watch *watch, daft_error *error)
{
    loader load = {.scene = scene, .watch = watch};
    daft_arena_init(&load.arena, scene->allocator);
    daft_assets_mark mark = daft_assets_remember(scene);
    bool done = load_all(&load, path);
    if (done)
        commit(&load);
    else
        daft_assets_roll_back(scene, mark);
    if (done && watch) watch->loaded(watch->user, load.items, load.count);
    daft_sky_item_free(scene, load.sky);
    daft_release(scene->allocator, load.items);
    daft_arena_free(&load.arena);
    if (!done && error) *error = load.error;
    return done;
}
