/* The items of .scene files as data. A value's range, unit and type are those of its field (scene/fields), so a field
 * is described once for C, Lua and .scene alike; angles are degrees here and nowhere else. After an item's values come
 * options, name=value: the fields with a .scene name that the item's kind uses.
 *
 * A new item is a row of FORMS, and what load.c does with it. */
#include "scene/format/items.h"

#include "math/trig.h"
#include "scene/fields/check.h"

#include <ctype.h>
#include <stdio.h>
#include <string.h>

enum { MAX_VALUES = 8, MAX_PATH = 1024, LONGEST_OPTION = 200, LONGEST_FORM = 128 };

#define DEGREE (DAFT_PI / 180)

/* Of entities, and no field of theirs: name=door. */
static const char NAME_OPTION[] = "name";

typedef daft_scene_item item;

/* What stands next on an item's line: a path, or the numbers of one field. */
typedef struct value {
    const char *names;     /* "x y z": of its numbers, or of its path */
    const char *member;    /* of the item's struct */
    const daft_field *own; /* instead: a field of the item itself */
    const char *path;      /* instead: a path, of what, for messages */
    int face;              /* of a path, not 0: which of a cube's images after the first */
    bool own_name;         /* instead: what the material is called */
    bool preset;           /* instead: a preset's name, of which the item's quality begins */
    bool stops;            /* instead: "auto" or a number of stops, of the item's exposure */
    bool optional;         /* the line may end before it */
    bool not_zero;         /* though the field may be */
    double fraction;       /* not 0: at most the number before it and, left out, this fraction of that */
} value;

typedef struct form {
    const char *word; /* or two of them */
    daft_scene_item_kind kind;
    daft_struct fields; /* DAFT_STRUCT_COUNT: none */
    size_t offset;      /* of that struct in an item */
    uint32_t choice;    /* of the struct's first choice, where it has one */
    value values[MAX_VALUES];
} form;

/* ---- the items ---- */

static const daft_field SECONDS = DAFT_ROW(item, time, ZERO_OR_MORE, .unit = "s", .doc = "Time on the path");
static const daft_field AMBIENT = DAFT_COLOR_ROW(item, ambient, ZERO_OR_MORE, .doc = "Light from everywhere");
static const daft_field OCCLUSION = DAFT_ROW(item, occlusion, FROM(0, 1e6), .unit = "m",
                                             .doc = "What stands within this distance keeps ambient light away");

static const daft_field STRENGTH =
    DAFT_ROW(item, strength, FROM(0, 1e6), .initial = {1}, .doc = "So many times the light of the sky");

static const daft_field ZENITH = DAFT_COLOR_ROW(item, zenith, ZERO_OR_MORE, .doc = "The sky's colour above");
static const daft_field HORIZON = DAFT_COLOR_ROW(item, horizon, ZERO_OR_MORE, .doc = "And at the horizon");

/* clang-format off */
#define NO_STRUCT     DAFT_STRUCT_COUNT, 0, 0
#define CAMERA        DAFT_STRUCT_CAMERA, offsetof(item, camera), 0
#define FOG           DAFT_STRUCT_FOG, offsetof(item, fog), 0
#define EXPOSURE      DAFT_STRUCT_EXPOSURE, offsetof(item, exposure), 0
#define QUALITY       DAFT_STRUCT_QUALITY, offsetof(item, quality), 0
#define MATERIAL      DAFT_STRUCT_MATERIAL_DEF, offsetof(item, def), 0
#define LIGHT(kind)   DAFT_STRUCT_LIGHT_DEF, offsetof(item, light), kind
#define ENTITY(shape) DAFT_STRUCT_ENTITY_DEF, offsetof(item, entity), shape
/* Each takes the names, the member or what the path is of, and designated initialisers of value. */
#define FIELD(n, m, ...) {.names = (n), .member = (m), __VA_ARGS__}
#define PATH(n, of)      {.names = (n), .path = (of)}
#define FACE(n, k)       {.names = (n), .path = "an image of the cube", .face = (k), .optional = (k) == 1}
#define NAME(n)          {.names = (n), .own_name = true}
#define PRESET(n)        {.names = (n), .preset = true, .optional = true}

static const form FORMS[] = {
    {"camera", DAFT_ITEM_CAMERA, CAMERA, {
        FIELD("x y z", "position"),
        FIELD("pitch", "pitch", .optional = true),
        FIELD("yaw", "yaw"),
        FIELD("fov", "fov", .optional = true)}},
    {"skybox", DAFT_ITEM_SKYBOX, NO_STRUCT, {
        PATH("path", "an image"),
        FACE("left", 1), FACE("top", 2), FACE("bottom", 3), FACE("front", 4), FACE("back", 5)}},
    {"light", DAFT_ITEM_LIGHT, LIGHT(DAFT_LIGHT_POINT), {
        FIELD("x y z", "position"),
        FIELD("r g b", "color")}},
    {"sphere", DAFT_ITEM_SPHERE, ENTITY(DAFT_SHAPE_SPHERE), {
        FIELD("x y z", "position"),
        FIELD("r", "radius"),
        PATH("material_path", "an .mtl file")}},
    {"mesh", DAFT_ITEM_MESH, ENTITY(DAFT_SHAPE_MESH), {
        PATH("mesh_path", "a mesh"),
        FIELD("x y z", "position"),
        FIELD("scale", "scale", .optional = true, .not_zero = true),
        FIELD("rot_x rot_y rot_z", "rotation", .optional = true)}},
    {"material", DAFT_ITEM_MATERIAL, MATERIAL, {
        NAME("name")}},
    {"sun", DAFT_ITEM_LIGHT, LIGHT(DAFT_LIGHT_SUN), {
        FIELD("dx dy dz", "direction"),
        FIELD("r g b", "color")}},
    {"spot", DAFT_ITEM_LIGHT, LIGHT(DAFT_LIGHT_SPOT), {
        FIELD("x y z", "position"),
        FIELD("dx dy dz", "direction"),
        FIELD("r g b", "color"),
        FIELD("angle", "outer_angle", .optional = true),
        FIELD("inner", "inner_angle", .optional = true, .fraction = 0.75)}},
    {"rectangle", DAFT_ITEM_LIGHT, LIGHT(DAFT_LIGHT_RECTANGLE), {
        FIELD("x y z", "position"),
        FIELD("dx dy dz", "direction"),
        FIELD("width height", "size"),
        FIELD("r g b", "color")}},
    {"ambient", DAFT_ITEM_AMBIENT, NO_STRUCT, {
        FIELD("r g b", NULL, .own = &AMBIENT),
        FIELD("occlusion", NULL, .own = &OCCLUSION, .optional = true)}},
    {"ambient sky", DAFT_ITEM_AMBIENT_SKY, NO_STRUCT, {
        FIELD("strength", NULL, .own = &STRENGTH, .optional = true),
        FIELD("occlusion", NULL, .own = &OCCLUSION, .optional = true)}},
    {"exposure", DAFT_ITEM_EXPOSURE, EXPOSURE, {
        {.names = "ev", .stops = true},
        FIELD("curve", "curve", .optional = true)}},
    {"sky", DAFT_ITEM_SKY, NO_STRUCT, {
        FIELD("r g b", NULL, .own = &ZENITH),
        FIELD("hr hg hb", NULL, .own = &HORIZON)}},
    {"fog", DAFT_ITEM_FOG, FOG, {
        FIELD("r g b", "color"),
        FIELD("density", "density")}},
    {"quality", DAFT_ITEM_QUALITY, QUALITY, {
        PRESET("preset")}},
    {"path", DAFT_ITEM_PATH, CAMERA, {
        FIELD("seconds", NULL, .own = &SECONDS),
        FIELD("x y z", "position"),
        FIELD("pitch", "pitch"),
        FIELD("yaw", "yaw"),
        FIELD("fov", "fov", .optional = true)}},
    {"include", DAFT_ITEM_INCLUDE, NO_STRUCT, {
        PATH("path", "a .scene file")}},
};
/* clang-format on */

static size_t value_count(const form *f)
{
    size_t count = 0;
    while (count < MAX_VALUES && f->values[count].names) count++;
    return count;
}

static const char *form_text(const form *f, char *buffer, size_t size)
{
    size_t used = (size_t)snprintf(buffer, size, "%s", f->word), open = 0;
    for (size_t i = 0; i < value_count(f); i++) {
        open += f->values[i].optional;
        used +=
            (size_t)snprintf(buffer + used, size - used, f->values[i].optional ? " [%s" : " %s", f->values[i].names);
    }
    for (; open > 0; open--) used += (size_t)snprintf(buffer + used, size - used, "]");
    if (f->kind == DAFT_ITEM_MESH)
        snprintf(buffer + used, size - used, " [clip name] [material name] [lights] [cameras]");
    if (f->kind == DAFT_ITEM_MATERIAL) snprintf(buffer + used, size - used, " [option=value …]");
    return buffer;
}

const char *daft_scene_item_form(size_t index, char *buffer, size_t size)
{
    return index < DAFT_COUNT_OF(FORMS) ? form_text(&FORMS[index], buffer, size) : NULL;
}

/* ---- fields in degrees ---- */

static bool is_angle(const daft_field *field) { return field->unit && strcmp(field->unit, "rad") == 0; }

/* The field as a .scene file shows it. */
static daft_field shown_field(const daft_field *field)
{
    daft_field shown = *field;
    if (!is_angle(field)) return shown;
    shown.unit = "degrees";
    if (shown.min != DAFT_ABOVE_ZERO) shown.min /= DEGREE;
    shown.max /= DEGREE;
    return shown;
}

static const daft_field *field_of(const form *f, const value *v)
{
    return v->own ? v->own : daft_field_find(f->fields, v->member);
}

/* ---- values ---- */

typedef struct reader {
    daft_scene_text *text;
    daft_arena *arena;
    const form *form;
    item *out;
    double last; /* the number that was read last */
} reader;

static void *struct_of(const reader *read) { return (char *)read->out + read->form->offset; }

/* The struct that a value's field lies in. */
static void *target_of(const reader *read, const value *v) { return v->own ? (void *)read->out : struct_of(read); }

static int next_column(reader *read)
{
    daft_scene_text_ends(read->text); /* goes past blanks */
    return (int)(read->text->at - read->text->line_start) + 1;
}

/* The word as a string of the arena; NULL: no memory. */
static char *keep_word(reader *read, const char *text, size_t length)
{
    char *copy = daft_arena_alloc(read->arena, length + 1, 1);
    if (!copy) return daft_fail_memory(read->text->error, "a scene file's names"), NULL;
    memcpy(copy, text, length);
    copy[length] = 0;
    return copy;
}

/* The token as a path, joined to the folder of the file that names it; NULL: failed. */
static const char *keep_path(reader *read, daft_token token)
{
    char name[MAX_PATH], joined[MAX_PATH];
    bool fits = token.length < sizeof name;
    if (fits) {
        memcpy(name, token.text, token.length);
        name[token.length] = 0;
        fits = daft_path_beside(read->text->path, name, joined, sizeof joined);
    }
    if (fits) return keep_word(read, joined, strlen(joined));
    daft_scene_text_fail(read->text, token.column, "the path has more than %d characters", MAX_PATH - 1);
    return NULL;
}

/* "material NAME" of a mesh, the name of a material, or the path of a sphere's, which may be such a name. */
static bool keep_material(reader *read, daft_token token)
{
    read->out->material = keep_word(read, token.text, token.length);
    read->out->material_column = token.column;
    return read->out->material != NULL;
}

static bool read_path(reader *read, const char *of, int face)
{
    daft_token token;
    char what[64];
    snprintf(what, sizeof what, "the path of %s", of);
    if (!daft_scene_text_word(read->text, what, &token)) return false;
    if (!face) read->out->column = token.column;
    const char *path = keep_path(read, token);
    *(face ? &read->out->faces[face - 1] : &read->out->path) = path;
    return path && (read->form->kind != DAFT_ITEM_SPHERE || keep_material(read, token));
}

static bool read_own_name(reader *read)
{
    daft_token token;
    if (!daft_scene_text_word(read->text, "the name of the material", &token)) return false;
    if (token.text[token.length - 1] == '{')
        return daft_scene_text_fail(read->text, token.column + (int)token.length - 1,
                                    "expected a name and a blank before the {");
    return keep_material(read, token);
}

static bool read_stops(reader *read)
{
    daft_token token;
    char range[64];
    const daft_field *ev = daft_field_find(DAFT_STRUCT_EXPOSURE, "ev");
    double stops;
    if (daft_scene_text_next_is(read->text, "auto")) {
        daft_scene_text_word(read->text, "auto", &token);
        read->out->exposure.automatic = true;
        return true;
    }
    daft_field_range(ev, range, sizeof range);
    if (!daft_scene_text_number(read->text, "ev, a number of stops or auto", ev->min, ev->max, range, &stops))
        return false;
    read->out->exposure.ev = (float)stops;
    return true;
}

static bool read_preset(reader *read)
{
    daft_token token;
    daft_preset preset;
    char name[32];
    if (!daft_scene_text_word(read->text, "a preset", &token)) return false;
    snprintf(name, sizeof name, "%.*s", (int)token.length, token.text);
    if (token.length >= sizeof name || !daft_preset_parse(name, &preset))
        return daft_scene_text_fail(read->text, token.column,
                                    "unknown preset '%s'; known are draft, game, high, reference",
                                    daft_token_show(token).text);
    read->out->quality = daft_preset_quality(preset);
    return true;
}

/* One number for each of the names. Returns how many; 0: failed. */
static uint32_t read_numbers(reader *read, const char *names, const daft_field *field, double *out)
{
    daft_field shown = shown_field(field);
    double low, high;
    char range[128];
    uint32_t count = 0;
    daft_field_range(&shown, range, sizeof range);
    daft_field_limits(&shown, &low, &high);
    while (*names) {
        char name[16];
        size_t length = strcspn(names, " ");
        snprintf(name, sizeof name, "%.*s", (int)length, names);
        if (!daft_scene_text_number(read->text, name, low, high, range, &out[count++])) return 0;
        names += length + (names[length] == ' ');
    }
    read->last = out[count - 1];
    return count;
}

static daft_quat axis_turn(int axis, double angle)
{
    float s = (float)daft_sin(angle / 2), c = (float)daft_cos(angle / 2);
    return (daft_quat){axis == 0 ? s : 0, axis == 1 ? s : 0, axis == 2 ? s : 0, c};
}

/* About X first: the rightmost factor turns first. */
static void set_rotation(const daft_field *field, void *out, const double *degrees)
{
    daft_quat x = axis_turn(0, degrees[0] * DEGREE), y = axis_turn(1, degrees[1] * DEGREE);
    daft_quat q = daft_quat_mul(axis_turn(2, degrees[2] * DEGREE), daft_quat_mul(y, x));
    daft_field_set_numbers(field, out, (double[4]){(double)q.x, (double)q.y, (double)q.z, (double)q.w});
}

/* `count` numbers as the file has them. One stands for all components. */
static void set_numbers(const daft_field *field, void *out, const double *numbers, uint32_t count)
{
    double scaled[4];
    for (uint32_t i = 0; i < 4; i++) {
        scaled[i] = numbers[count == 1 ? 0 : i < count ? i : count - 1];
        if (is_angle(field)) scaled[i] *= DEGREE;
    }
    daft_field_set_numbers(field, out, scaled);
}

static bool read_choice(reader *read, const daft_field *field)
{
    daft_token token;
    daft_error why;
    char text[LONGEST_OPTION];
    if (!daft_scene_text_word(read->text, field->name, &token)) return false;
    snprintf(text, sizeof text, "%.*s", (int)token.length, token.text);
    return daft_field_parse(field, text, struct_of(read), &why) ||
           daft_scene_text_fail(read->text, token.column, "%s", why.message);
}

static bool read_field(reader *read, const value *v)
{
    static const daft_field TURN = {.name = "angle", .type = DAFT_FIELD_FLOAT, .unit = "rad", DAFT_ANGLES};
    const daft_field *field = field_of(read->form, v);
    bool turns = field->type == DAFT_FIELD_ROTATION;
    int column = next_column(read);
    double numbers[4], before = read->last;
    daft_error why;
    uint32_t count = read_numbers(read, v->names, turns ? &TURN : field, numbers);
    if (count == 0) return false;
    if (v->not_zero && numbers[0] == 0)
        return daft_scene_text_fail(read->text, column, "%s is 0; it must not be 0", v->names);
    if (v->fraction > 0 && numbers[0] > before)
        return daft_scene_text_fail(read->text, column, "%s is %g; it must be at most %g, the number before it",
                                    v->names, numbers[0], before);
    if (turns)
        set_rotation(field, target_of(read, v), numbers);
    else
        set_numbers(field, target_of(read, v), numbers, count);
    return daft_field_check(field, target_of(read, v), "", &why) ||
           daft_scene_text_fail(read->text, column, "%s", why.message);
}

/* ---- options ---- */

/* The length of the word that comes next, if it is an option: a letter first, a '=' in it; else 0. */
static size_t option_length(daft_scene_text *text)
{
    if (daft_scene_text_ends(text) || !isalpha((unsigned char)*text->at)) return 0;
    const char *at = text->at;
    bool equals = false;
    for (; at < text->end && !strchr(" \t\r\n", *at); at++) equals |= *at == '=';
    return equals ? (size_t)(at - text->at) : 0;
}

static bool is_option(const reader *read, const daft_field *field)
{
    return field->scene && daft_field_used(daft_field_list_of(read->form->fields), field, struct_of(read));
}

static const daft_field *option_field(const reader *read, const char *name)
{
    uint32_t count;
    const daft_field *fields = daft_fields(read->form->fields, &count);
    for (uint32_t i = 0; i < count; i++)
        if (is_option(read, &fields[i]) && strcmp(fields[i].scene, name) == 0) return &fields[i];
    return NULL;
}

static bool has_name(const reader *read) { return read->form->fields == DAFT_STRUCT_ENTITY_DEF; }

static bool fail_option(const reader *read, int column, const char *name)
{
    char known[4 * LONGEST_OPTION] = "";
    if (has_name(read)) snprintf(known, sizeof known, "%s", NAME_OPTION);
    uint32_t count;
    const daft_field *fields = daft_fields(read->form->fields, &count);
    const char *near = NULL;
    for (uint32_t i = 0; i < count; i++)
        if (is_option(read, &fields[i])) near = daft_scene_text_nearer(name, fields[i].scene, near);
    if (read->form->kind == DAFT_ITEM_MATERIAL && near)
        return daft_scene_text_fail(read->text, column, "unknown option '%.40s': did you mean '%s'?", name, near);
    for (uint32_t i = 0; i < count; i++) {
        size_t used = strlen(known);
        if (is_option(read, &fields[i]))
            snprintf(known + used, sizeof known - used, "%s%s", used ? ", " : "", fields[i].scene);
    }
    return daft_scene_text_fail(read->text, column, "unknown option '%.40s'; known are %s", name, known);
}

static bool set_option(const daft_field *field, const char *text, void *out, daft_error *error)
{
    daft_field shown = shown_field(field);
    double numbers[4];
    char thrice[3 * LONGEST_OPTION + 2];
    shown.name = field->scene;
    if (field->type == DAFT_FIELD_COLOR && (field->flags & DAFT_FIELD_UNIFORM) && !strchr(text, ',')) {
        snprintf(thrice, sizeof thrice, "%s,%s,%s", text, text, text);
        text = thrice;
    }
    if (!daft_field_parse(&shown, text, out, error)) return false;
    if (is_angle(field)) set_numbers(field, out, numbers, daft_field_numbers(field, out, numbers));
    return true;
}

static bool keep_name(reader *read, const char *name)
{
    const size_t size = strlen(name) + 1;
    char *copy = daft_arena_alloc(read->arena, size, 1);
    if (!copy) return daft_fail_memory(read->text->error, "a scene file's names");
    read->out->name = memcpy(copy, name, size);
    return true;
}

/* texture=wood.png; the last one of a field counts, as with all options. */
static bool keep_map(reader *read, const daft_field *field, daft_token path)
{
    if (path.length == 0) return daft_scene_text_fail(read->text, path.column, "the path of %s is empty", field->scene);
    daft_scene_map *map = read->out->maps;
    while (map && map->field != field) map = map->next;
    if (!map) {
        map = daft_arena_alloc(read->arena, 1, sizeof *map);
        if (!map) return daft_fail_memory(read->text->error, "a scene file's materials");
        *map = (daft_scene_map){.field = field, .next = read->out->maps};
        read->out->maps = map;
    }
    map->path = keep_path(read, path);
    map->line = read->text->line, map->column = path.column;
    return map->path != NULL;
}

static bool read_option(reader *read)
{
    daft_token token;
    char text[LONGEST_OPTION];
    daft_error why;
    if (!daft_scene_text_word(read->text, "an option", &token)) return false;
    snprintf(text, sizeof text, "%.*s", (int)token.length, token.text);
    char *set = strchr(text, '=');
    if (token.length >= sizeof text || !set)
        return daft_scene_text_fail(read->text, token.column, "the option has more than %d characters",
                                    LONGEST_OPTION - 1);
    *set++ = 0;
    if (has_name(read) && strcmp(text, NAME_OPTION) == 0)
        return *set ? keep_name(read, set) : daft_scene_text_fail(read->text, token.column, "the name is empty");
    const daft_field *field = option_field(read, text);
    if (!field) return fail_option(read, token.column, text);
    if (field->type == DAFT_FIELD_TEXTURE)
        return keep_map(read, field, (daft_token){set, strlen(set), token.column + (int)(set - text)});
    return set_option(field, set, struct_of(read), &why) ||
           daft_scene_text_fail(read->text, token.column, "%s", why.message);
}

/* "clip NAME" */
static bool read_clip(reader *read)
{
    daft_token token;
    daft_scene_text_word(read->text, "clip", &token);
    if (read->out->clip) return daft_scene_text_fail(read->text, token.column, "there is a clip already");
    if (!daft_scene_text_word(read->text, "the name of a clip", &token)) return false;
    char *copy = daft_arena_alloc(read->arena, token.length + 1, 1);
    if (!copy) return daft_fail_memory(read->text->error, "a scene file's names");
    memcpy(copy, token.text, token.length);
    copy[token.length] = 0;
    read->out->clip = copy, read->out->clip_column = token.column;
    return true;
}

/* "material NAME" */
static bool read_material(reader *read)
{
    daft_token token;
    daft_scene_text_word(read->text, "material", &token);
    if (read->out->material) return daft_scene_text_fail(read->text, token.column, "there is a material already");
    return daft_scene_text_word(read->text, "the name of a material", &token) && keep_material(read, token);
}

static bool read_lights(reader *read)
{
    daft_token token;
    return read->out->lights = daft_scene_text_word(read->text, "lights", &token);
}

static bool read_cameras(reader *read)
{
    daft_token token;
    return read->out->cameras = daft_scene_text_word(read->text, "cameras", &token);
}

typedef bool word_reader(reader *read);

/* What reads the word that may follow a mesh's numbers, if one does; or NULL. */
static word_reader *word_that_follows(const reader *read)
{
    static const struct {
        const char *word;
        word_reader *read;
    } WORDS[] = {{"clip", read_clip}, {"material", read_material}, {"lights", read_lights}, {"cameras", read_cameras}};
    for (size_t i = 0; read->form->kind == DAFT_ITEM_MESH && i < DAFT_COUNT_OF(WORDS); i++)
        if (daft_scene_text_next_is(read->text, WORDS[i].word)) return WORDS[i].read;
    return NULL;
}

/* "{", options on as many lines as they like, "}". */
static bool read_block(reader *read)
{
    daft_scene_text *text = read->text;
    daft_token token;
    text->block = daft_scene_text_word(text, "{", &token);
    while (daft_scene_text_line(text)) {
        if (daft_scene_text_next_is(text, "}")) {
            text->block = false;
            return daft_scene_text_word(text, "}", &token);
        }
        if (option_length(text) > 0) {
            if (!read_option(read)) return false;
        } else if (daft_scene_text_word(text, "an option", &token)) {
            return daft_scene_text_fail(text, token.column, "expected an option, name=value, or }, but '%s' came",
                                        daft_token_show(token).text);
        } else {
            return false;
        }
    }
    return daft_scene_text_fail(text, next_column(read), "the file ends, but the { of line %d is not closed by a }",
                                read->out->line);
}

static bool read_options(reader *read)
{
    if (read->form->kind == DAFT_ITEM_MATERIAL && daft_scene_text_next_is(read->text, "{")) return read_block(read);
    for (;;) {
        word_reader *word = word_that_follows(read);
        if (!word && (read->form->fields == DAFT_STRUCT_COUNT || option_length(read->text) == 0)) return true;
        if (!(word ? word : read_option)(read)) return false;
    }
}

/* ---- items ---- */

static void set_defaults(const reader *read)
{
    uint32_t count;
    for (size_t i = 0; i < value_count(read->form); i++)
        if (read->form->values[i].own)
            daft_field_set_numbers(read->form->values[i].own, read->out, read->form->values[i].own->initial);
    const daft_field *fields = daft_fields(read->form->fields, &count);
    daft_struct_default(read->form->fields, struct_of(read));
    for (uint32_t i = 0; i < count; i++) {
        if (fields[i].type != DAFT_FIELD_CHOICE) continue;
        daft_field_set_numbers(&fields[i], struct_of(read), (double[4]){read->form->choice});
        return;
    }
}

static bool read_value(reader *read, const value *v)
{
    const daft_field *field = v->own || v->member ? field_of(read->form, v) : NULL;
    if (v->path) return read_path(read, v->path, v->face);
    if (v->own_name) return read_own_name(read);
    if (v->preset) return read_preset(read);
    if (v->stops) return read_stops(read);
    return field->type == DAFT_FIELD_CHOICE ? read_choice(read, field) : read_field(read, v);
}

/* The first optional value that is left out ends the numbers; values that follow from the one before it are set. */
static bool read_values(reader *read)
{
    const size_t count = value_count(read->form);
    size_t i = 0;
    for (; i < count; i++) {
        const value *v = &read->form->values[i];
        if (v->optional &&
            (daft_scene_text_ends(read->text) || option_length(read->text) > 0 || word_that_follows(read)))
            break;
        if (!read_value(read, v)) return false;
    }
    if (i < count && read->form->values[i].fraction > 0) {
        double number = read->form->values[i].fraction * read->last;
        set_numbers(field_of(read->form, &read->form->values[i]), struct_of(read), &number, 1);
    }
    return true;
}

static bool fail_unknown(daft_scene_text *text, daft_token word)
{
    char known[256] = "";
    for (size_t i = 0; i < DAFT_COUNT_OF(FORMS); i++) {
        if (i > 0) strcat(known, ", ");
        strcat(known, FORMS[i].word);
    }
    return daft_scene_text_fail(text, word.column, "unknown item '%s'; known are %s", daft_token_show(word).text,
                                known);
}

static const form *form_of(daft_scene_text *text, daft_token word)
{
    const form *found = NULL;
    for (size_t i = 0; i < DAFT_COUNT_OF(FORMS); i++) {
        const char *known = FORMS[i].word;
        if (strncmp(known, word.text, word.length) != 0) continue;
        if (known[word.length] == 0) found = &FORMS[i];
        if (known[word.length] != ' ' || !daft_scene_text_next_is(text, known + word.length + 1)) continue;
        daft_scene_text_word(text, "an item", &word);
        return &FORMS[i];
    }
    return found;
}

bool daft_scene_item_read(daft_scene_text *text, daft_arena *arena, daft_scene_item *out)
{
    daft_token word;
    char usage[LONGEST_FORM];
    text->usage = "an item and its values";
    if (!daft_scene_text_word(text, "an item", &word)) return false;
    reader read = {.text = text, .arena = arena, .form = form_of(text, word), .out = out};
    if (!read.form) return fail_unknown(text, word);
    *out = (item){.kind = read.form->kind, .source = text->path, .line = text->line, .column = word.column};
    text->usage = form_text(read.form, usage, sizeof usage);
    set_defaults(&read);
    bool done = read_values(&read) && read_options(&read) && daft_scene_text_finish(text);
    text->usage = "";
    return done;
}
