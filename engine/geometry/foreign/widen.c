/* Floats for Assimp. Version 5.2 copies what vertices and clips have of a glTF file as if it were floats, whatever it
 * is; of bytes and 16-bit numbers (weights of skins, texture coordinates, everything under KHR_mesh_quantization) it
 * makes numbers that the file does not have, of memory that nobody wrote. And it crashes at a skin without matrices,
 * which glTF takes for the identity. So it is given another text: these accessors are of floats there, in a buffer of
 * their own behind the others, and all skins have matrices. */
#include "geometry/foreign/assimp.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { FLOAT = 5126, ITEM_TEXT = 128 };
static const size_t MOST = (size_t)1 << 30; /* bytes of floats */

/* Something of the text that becomes something else. */
typedef struct edit {
    const char *at;
    size_t removed, length;
    const char *text;
} edit;

typedef struct widening {
    daft_gltf g;
    bool *wanted; /* of each accessor */
    edit *edits;
    uint32_t edit_count, made; /* made: new views */
    float *floats;
    size_t count;
    uint32_t added;          /* new accessors */
    char *views, *accessors; /* text of the new ones, and how long it is */
    size_t views_used, accessors_used;
    const char *broken; /* why Assimp must not see it; NULL: it may */
} widening;

/* ---- which ---- */

static void want(widening *w, daft_json number)
{
    const uint32_t index = daft_json_index(number);
    if (index < w->g.accessors.count) w->wanted[index] = true;
}

/* Joints are whole numbers, and colours are read as what they are. */
static void want_attributes(widening *w, daft_json attributes)
{
    static const char *const NAMES[] = {"POSITION",   "NORMAL",     "TANGENT",    "WEIGHTS_0",  "WEIGHTS_1",
                                        "TEXCOORD_0", "TEXCOORD_1", "TEXCOORD_2", "TEXCOORD_3", "TEXCOORD_4"};
    for (size_t i = 0; i < DAFT_COUNT_OF(NAMES); i++) want(w, daft_json_member(attributes, NAMES[i]));
}

static void want_meshes(widening *w)
{
    daft_json mesh = daft_json_first(daft_json_member(w->g.root, "meshes"));
    for (; mesh.at; mesh = daft_json_next(mesh)) {
        daft_json part = daft_json_first(daft_json_member(mesh, "primitives"));
        for (; part.at; part = daft_json_next(part)) {
            want_attributes(w, daft_json_member(part, "attributes"));
            daft_json target = daft_json_first(daft_json_member(part, "targets"));
            for (; target.at; target = daft_json_next(target)) want_attributes(w, target);
        }
    }
}

static void want_clips(widening *w)
{
    for (uint32_t i = 0; i < w->g.clips.count; i++) {
        daft_json sampler = daft_json_first(daft_json_member(w->g.clips.items[i], "samplers"));
        for (; sampler.at; sampler = daft_json_next(sampler)) want(w, daft_json_member(sampler, "output"));
    }
}

/* ---- floats ---- */

/* glTF 2.0, 3.11: of signed numbers the least two stand for -1. */
static float number_at(const uint8_t *at, uint32_t type, bool normalized)
{
    int8_t signed8;
    int16_t signed16;
    uint16_t unsigned16;
    uint32_t unsigned32;
    switch (type) {
    case 5120: memcpy(&signed8, at, 1); return normalized ? fmaxf((float)signed8 / 127, -1) : (float)signed8;
    case 5121: return normalized ? (float)*at / 255 : (float)*at;
    case 5122: memcpy(&signed16, at, 2); return normalized ? fmaxf((float)signed16 / 32767, -1) : (float)signed16;
    case 5123: memcpy(&unsigned16, at, 2); return normalized ? (float)unsigned16 / 65535 : (float)unsigned16;
    default: memcpy(&unsigned32, at, 4); return (float)unsigned32;
    }
}

static size_t size_of(uint32_t type) { return type < 5122 ? 1 : type < 5124 ? 2 : 4; }

static void unpack(const daft_gltf_packed *p, float *out)
{
    const size_t size = size_of(p->type);
    for (size_t i = 0; i < p->items; i++)
        for (size_t k = 0; k < p->width; k++)
            *out++ = number_at(p->first + i * p->stride + k * size, p->type, p->normalized);
}

static bool must_widen(widening *w, uint32_t index, daft_gltf_packed *p)
{
    return w->wanted[index] && daft_gltf_locate(&w->g, w->g.accessors.items[index], p) && p->type != FLOAT;
}

static void put_edit(widening *w, const char *at, size_t removed, const char *text)
{
    w->edits[w->edit_count++] = (edit){at, removed, strlen(text), text};
}

/* Text of an accessor of the next `items` items of floats, with a view of its own. NULL: memory is out. */
static const char *next_floats(widening *w, size_t items, const char *type, size_t width)
{
    char *text = daft_arena_alloc(&w->g.arena, ITEM_TEXT, 1);
    const size_t size = sizeof(float);
    if (!text) return NULL;
    snprintf(text, ITEM_TEXT, "{\"bufferView\":%u,\"componentType\":5126,\"count\":%zu,\"type\":\"%s\"}",
             w->g.views.count + w->made++, items, type);
    w->views_used +=
        (size_t)snprintf(w->views + w->views_used, ITEM_TEXT, ",{\"buffer\":%u,\"byteOffset\":%zu,\"byteLength\":%zu}",
                         w->g.buffers.count, w->count * size, items * width * size);
    w->count += items * width;
    return text;
}

/* The accessor becomes one of floats; its bounds, which were of whole numbers, are left out. */
static bool widen_one(widening *w, uint32_t index, const daft_gltf_packed *p)
{
    static const char *const TYPES[] = {"", "SCALAR", "VEC2", "VEC3", "VEC4"};
    const daft_json accessor = w->g.accessors.items[index];
    unpack(p, w->floats + w->count);
    const char *text = next_floats(w, p->items, TYPES[p->width], p->width);
    if (text) put_edit(w, accessor.at, (size_t)(daft_json_behind(accessor) - accessor.at), text);
    return text != NULL;
}

/* ---- skins ---- */

/* How many matrices a skin is to be given: where it has none, or fewer than joints; 0 elsewhere. */
static uint32_t matrices_missing(const widening *w, daft_json skin)
{
    const daft_json given = daft_json_member(skin, "inverseBindMatrices");
    const uint32_t index = daft_json_index(given), count = w->g.accessors.count;
    uint32_t joints = 0;
    daft_json joint = daft_json_first(daft_json_member(skin, "joints"));
    for (; joint.at; joint = daft_json_next(joint)) joints++;
    if (given.at && index >= count) return 0; /* Assimp says so */
    const bool enough = given.at && daft_json_index(daft_json_member(w->g.accessors.items[index], "count")) >= joints;
    return enough || *skin.at != '{' ? 0 : daft_max_u(joints, 1);
}

static bool give_matrices(widening *w, daft_json skin, uint32_t count)
{
    float *to = w->floats + w->count;
    for (uint32_t i = 0; i < 16 * count; i++) to[i] = i % 16 % 5 == 0;
    const char *accessor = next_floats(w, count, "MAT4", 16);
    char *text = daft_arena_alloc(&w->g.arena, ITEM_TEXT, 1);
    if (!accessor || !text) return false;
    w->accessors_used += (size_t)snprintf(w->accessors + w->accessors_used, ITEM_TEXT + 1, ",%s", accessor);
    const daft_json few = daft_json_member(skin, "inverseBindMatrices");
    const uint32_t number = w->g.accessors.count + w->added++;
    if (few.at) {
        snprintf(text, ITEM_TEXT, "%u", number);
        put_edit(w, few.at, (size_t)(daft_json_behind(few) - few.at), text);
    } else {
        snprintf(text, ITEM_TEXT, "\"inverseBindMatrices\":%u,", number);
        put_edit(w, skin.at + 1, 0, text);
    }
    return true;
}

/* ---- the text ---- */

/* ,{"byteLength":N,"uri":"data:…"}: RFC 4648. */
static char *make_buffer(widening *w)
{
    static const char DIGITS[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const size_t size = w->count * sizeof(float);
    const uint8_t *bytes = (const uint8_t *)w->floats;
    char *text = daft_arena_alloc(&w->g.arena, ITEM_TEXT + (size + 2) / 3 * 4, 1), *to = text;
    if (!text) return NULL;
    to += snprintf(text, ITEM_TEXT, ",{\"byteLength\":%zu,\"uri\":\"data:application/octet-stream;base64,", size);
    for (size_t i = 0; i < size; i += 3) {
        const uint32_t b = i + 1 < size ? bytes[i + 1] : 0, c = i + 2 < size ? bytes[i + 2] : 0;
        const uint32_t all = (uint32_t)bytes[i] << 16 | b << 8 | c;
        *to++ = DIGITS[all >> 18], *to++ = DIGITS[all >> 12 & 63];
        *to++ = i + 1 < size ? DIGITS[all >> 6 & 63] : '=', *to++ = i + 2 < size ? DIGITS[all & 63] : '=';
    }
    memcpy(to, "\"}", 3);
    return text;
}

static int by_place(const void *a, const void *b)
{
    const char *x = ((const edit *)a)->at, *y = ((const edit *)b)->at;
    return (x > y) - (x < y);
}

/* Before the bracket that closes an array, which is not empty. */
static void append(widening *w, const char *array, const char *text)
{
    const char *behind = daft_json_behind(daft_json_member(w->g.root, array));
    put_edit(w, behind - 1, 0, text);
}

static char *copy(char *to, const char *from, size_t size)
{
    memcpy(to, from, size);
    return to + size;
}

static void put_word(char *at, size_t value)
{
    for (int i = 0; i < 4; i++) at[i] = (char)(value >> 8 * i);
}

/* What is no JSON may have pieces within pieces. */
static bool edits_are_apart(const widening *w)
{
    for (uint32_t i = 1; i < w->edit_count; i++)
        if (w->edits[i].at < w->edits[i - 1].at + w->edits[i - 1].removed) return false;
    return true;
}

/* The file with its edits; a GLB's lengths are told anew, and its JSON is padded with blanks. */
static bool rewrite(widening *w, char **out, size_t *size)
{
    enum { HEADER = 12, CHUNK = 8 };
    const daft_foreign *from = w->g.from;
    const char *file = from->bytes, *file_end = file + from->size, *at = file;
    const bool glb = strcmp(from->format, "glb") == 0;
    size_t all = from->size + 4;
    qsort(w->edits, w->edit_count, sizeof *w->edits, by_place);
    if (!edits_are_apart(w)) w->broken = "the text of this glTF file is no JSON";
    if (w->broken) return false;
    for (uint32_t i = 0; i < w->edit_count; i++) all += w->edits[i].length;
    char *made = daft_alloc(from->allocator, all, 1), *to = made;
    if (!made) return false;
    const char *text_end = w->g.root.end;
    for (uint32_t i = 0; i < w->edit_count; i++) {
        const edit *e = &w->edits[i];
        to = copy(to, at, (size_t)(e->at - at));
        to = copy(to, e->text, e->length);
        at = e->at + e->removed;
    }
    to = copy(to, at, (size_t)(text_end - at));
    if (glb) {
        while ((to - made) % 4) *to++ = ' ';
        put_word(made + HEADER, (size_t)(to - made) - HEADER - CHUNK);
        const size_t padded = ((size_t)(text_end - file) + 3) / 4 * 4;
        if (padded < from->size) to = copy(to, file + padded, (size_t)(file_end - file) - padded);
        put_word(made + 8, (size_t)(to - made));
    }
    *out = made, *size = (size_t)(to - made);
    return true;
}

/* How many numbers there will be, in how many accessors. Matrices stand behind accessors that there are: without any,
 * Assimp must not see a skin that lacks them. */
static void measure(widening *w, size_t *numbers, size_t *items)
{
    daft_gltf_packed p;
    for (uint32_t i = 0; i < w->g.accessors.count; i++)
        if (must_widen(w, i, &p)) *numbers += p.items * p.width, ++*items;
    daft_json skin = daft_json_first(daft_json_member(w->g.root, "skins"));
    const bool has_numbers = w->g.accessors.count && w->g.views.count && w->g.buffers.count;
    for (; skin.at; skin = daft_json_next(skin)) {
        const uint32_t missing = matrices_missing(w, skin);
        if (missing && !has_numbers) w->broken = "a skin without numbers for its vertices";
        *numbers += 16 * (size_t)missing, *items += missing > 0;
    }
}

static bool make_room(widening *w, size_t numbers, size_t items)
{
    w->floats = daft_arena_alloc(&w->g.arena, numbers, sizeof *w->floats);
    w->edits = daft_arena_alloc(&w->g.arena, items + 3, sizeof *w->edits);
    w->views = daft_arena_alloc(&w->g.arena, items * ITEM_TEXT, 1);
    w->accessors = daft_arena_alloc(&w->g.arena, items * (ITEM_TEXT + 1), 1);
    if (!w->floats || !w->edits || !w->views || !w->accessors) return false;
    w->views[0] = w->accessors[0] = 0;
    return true;
}

static bool widen(widening *w, char **out, size_t *size)
{
    const uint32_t count = w->g.accessors.count;
    daft_gltf_packed p;
    size_t numbers = 0, items = 0;
    if (w->g.binary && w->g.buffers.count == 0) w->broken = "the file has a binary chunk, but no buffer for it";
    w->wanted = daft_arena_alloc(&w->g.arena, (size_t)count + 1, sizeof *w->wanted);
    if (!w->wanted || w->broken) return false;
    memset(w->wanted, 0, count * sizeof *w->wanted);
    want_meshes(w), want_clips(w);
    measure(w, &numbers, &items);
    if (w->broken) return false;
    if (items == 0 || numbers > MOST / sizeof(float)) return !w->g.out_of_memory;
    if (!make_room(w, numbers, items)) return false;
    for (uint32_t i = 0; i < count; i++)
        if (must_widen(w, i, &p) && !widen_one(w, i, &p)) return false;
    daft_json skin = daft_json_first(daft_json_member(w->g.root, "skins"));
    for (; skin.at; skin = daft_json_next(skin)) {
        const uint32_t missing = matrices_missing(w, skin);
        if (missing && !give_matrices(w, skin, missing)) return false;
    }
    char *buffer = make_buffer(w);
    if (!buffer) return false;
    append(w, "bufferViews", w->views), append(w, "buffers", buffer), append(w, "accessors", w->accessors);
    return rewrite(w, out, size);
}

bool daft_gltf_widen(const daft_foreign *from, char **out, size_t *size)
{
    widening w = {0};
    *out = NULL;
    if (!daft_gltf_begin(from, &w.g)) {
        daft_gltf_close(&w.g);
        return false;
    }
    const bool done = !w.g.root.at || widen(&w, out, size);
    daft_gltf_close(&w.g);
    if (w.broken) return daft_fail_at(from->error, DAFT_ERROR_SYNTAX, from->path, 0, 0, "%s", w.broken);
    return done || daft_fail_memory(from->error, "a glTF file's numbers");
}
