/* The materials of an OBJ file: finding the files that mtllib names, and in them the materials that usemtl names. */
#include "geometry/formats/obj.h"

#include <stdio.h>

enum { MAX_LIBRARIES = 64 };

typedef struct slots {
    daft_obj_source *source;
    daft_error *error;
    daft_mtl_list materials; /* of all libraries */
    uint32_t *buckets;       /* hash table of material numbers + 1 by name */
    size_t bucket_count;
    unsigned loaded;
    bool any_missing;
    char missing[256]; /* the names of one mtllib that are not there */
} slots;

/* Writes a name as a path: `\ ` is a blank, other backslashes are slashes. False if it does not fit. */
static bool to_path(const char *name, size_t length, char *path, size_t size)
{
    size_t used = 0;
    for (size_t i = 0; i < length; i++) {
        char c = name[i];
        if (c == '\\') {
            bool escape = i + 1 < length && name[i + 1] == ' ';
            c = escape ? ' ' : '/';
            i += escape;
        }
        if (c == 0 || used + 1 >= size) return false;
        path[used++] = c;
    }
    path[used] = 0;
    return used > 0;
}

/* Beside the OBJ; failing that, in the asset roots; failing that, its last part beside the OBJ, for paths of the
 * machine that wrote the file. */
static bool find_file(const slots *s, const char *name, size_t length, char *path, size_t size)
{
    char relative[1024];
    if (!to_path(name, length, relative, sizeof relative)) return false;
    if (daft_path_beside(s->source->text.path, relative, path, size) && daft_file_exists(s->source->files, path))
        return true;
    if (s->source->files && strlen(relative) < size && daft_file_exists(s->source->files, relative)) {
        memcpy(path, relative, strlen(relative) + 1);
        return true;
    }
    const char *slash = strrchr(relative, '/');
    return slash && slash[1] && daft_path_beside(s->source->text.path, slash + 1, path, size) &&
           daft_file_exists(s->source->files, path);
}

static bool load(slots *s, const char *path)
{
    s->loaded++;
    return daft_mtl_load(s->source->allocator, s->source->files, path, s->source->text.log, &s->materials, s->error);
}

static void note_missing(slots *s, const char *name, size_t length)
{
    size_t used = strlen(s->missing);
    snprintf(s->missing + used, sizeof s->missing - used, "%s'%s'", used ? ", " : "",
             daft_text_quote(name, length).text);
    s->any_missing = true;
}

/* A backslash before a line end joins the two lines. */
static bool is_joint(const char *p, const char *end) { return *p == '\\' && p + 1 < end && daft_is_break(p[1]); }

/* One name of several: up to a blank that no backslash precedes. */
static const char *skip_name(const char *p, const char *end)
{
    while (p < end && !daft_is_blank(*p) && !daft_is_break(*p) && !is_joint(p, end))
        p += *p == '\\' && p + 1 < end && p[1] == ' ' ? 2 : 1;
    return p;
}

/* Either one file, whose name may hold blanks, or a list of which all that exist are used. */
static bool load_library(slots *s, const daft_obj_name *library)
{
    char path[1024];
    const char *p = library->at, *end = p + library->length;
    while (end > p && (daft_is_blank(end[-1]) || daft_is_break(end[-1]))) end--;
    if (find_file(s, p, (size_t)(end - p), path, sizeof path)) return load(s, path);
    s->missing[0] = 0;
    while (p < end && *p != '#') {
        const char *last = skip_name(p, end);
        size_t length = (size_t)(last - p);
        if (length > 0 && !find_file(s, p, length, path, sizeof path))
            note_missing(s, p, length);
        else if (length > 0 && !load(s, path))
            return false;
        for (p = last; p < end && (daft_is_blank(*p) || daft_is_break(*p) || is_joint(p, end));) p++;
    }
    if (s->missing[0])
        daft_text_warn(&s->source->text, library->at, "no such material file: %s (looked beside the OBJ file%s)",
                       s->missing, s->source->files ? " and in the asset roots" : "");
    return true;
}

static bool is_repeated(const daft_obj_source *source, size_t library)
{
    const daft_obj_name *names = source->libraries;
    for (size_t i = 0; i < library; i++)
        if (names[i].length == names[library].length && memcmp(names[i].at, names[library].at, names[i].length) == 0)
            return true;
    return false;
}

/* Files often name the same library before every object. Only so many different ones are looked at that time stays
 * linear in the size of the file. */
static bool load_libraries(slots *s)
{
    daft_obj_source *source = s->source;
    size_t different = 0;
    for (size_t i = 0; i < source->library_count; i++) {
        source->libraries[different] = source->libraries[i];
        if (is_repeated(source, different)) continue;
        if (++different > MAX_LIBRARIES) {
            daft_text_warn(&source->text, source->libraries[i].at, "more than %d mtllib: the rest is skipped",
                           MAX_LIBRARIES);
            return true;
        }
        if (!load_library(s, &source->libraries[different - 1])) return false;
    }
    return true;
}

/* The bucket of a name: that of the material with it, or the free one where it belongs. */
static uint32_t *find_bucket(const slots *s, const char *name, size_t length)
{
    size_t at = daft_hash(name, length, 0) & (s->bucket_count - 1);
    for (; s->buckets[at]; at = (at + 1) & (s->bucket_count - 1)) {
        const daft_mtl *material = &s->materials.items[s->buckets[at] - 1];
        if (strlen(material->name) == length && memcmp(material->name, name, length) == 0) break;
    }
    return &s->buckets[at];
}

/* Of two materials with one name the first counts. */
static bool index_materials(slots *s)
{
    s->bucket_count = 64;
    while (s->bucket_count < 2 * (s->materials.count + 1)) s->bucket_count *= 2;
    s->buckets = daft_alloc_zero(s->source->allocator, s->bucket_count, sizeof *s->buckets);
    if (!s->buckets) return daft_fail_memory(s->error, "a mesh's materials");
    for (size_t i = 0; i < s->materials.count; i++) {
        const char *name = s->materials.items[i].name;
        uint32_t *bucket = find_bucket(s, name, strlen(name));
        if (!*bucket) *bucket = (uint32_t)i + 1;
    }
    return true;
}

static bool fill(slots *s, daft_mtl_list *out)
{
    daft_obj_source *source = s->source;
    size_t count = source->slot_count ? source->slot_count : 1, undefined = 0;
    const daft_obj_name *first_undefined = NULL;
    if (!daft_grow(source->allocator, &out->items, &out->capacity, count, 0, sizeof *out->items))
        return daft_fail_memory(s->error, "a mesh's materials");
    for (size_t i = 0; i < count; i++) {
        const daft_obj_name *name = i < source->slot_count ? &source->slots[i] : NULL;
        uint32_t found = name && name->length ? *find_bucket(s, name->at, name->length) : 0;
        const daft_mtl none = daft_mtl_default();
        if (!daft_mtl_copy(source->allocator, found ? &s->materials.items[found - 1] : &none,
                           &out->items[out->count++]))
            return daft_fail_memory(s->error, "a mesh's materials");
        if (found || !name || !name->length) continue;
        if (!first_undefined) first_undefined = name;
        undefined++;
    }
    /* Where a file is missing its materials are too, and that has been said. */
    if (undefined == 0 || s->any_missing) return true;
    daft_quoted shown = daft_text_quote(first_undefined->at, first_undefined->length);
    if (undefined == 1)
        daft_text_warn(&source->text, first_undefined->at, "no material file defines '%s': the default is used",
                       shown.text);
    else
        daft_text_warn(&source->text, first_undefined->at,
                       "no material file defines '%s' and %zu more: the default is used", shown.text, undefined - 1);
    return true;
}

/* Libraries are shared between meshes, so materials that this one leaves unused are one note, not many warnings. */
static void note_unused(const slots *s, const daft_mtl_list *used)
{
    char names[200] = "";
    size_t unused = 0, length = 0;
    for (size_t i = 0; i < s->materials.count; i++) {
        const char *name = s->materials.items[i].name;
        bool is_used = false;
        for (size_t k = 0; k < used->count && !is_used; k++) is_used = strcmp(used->items[k].name, name) == 0;
        if (is_used) continue;
        if (unused++ < 5 && length < sizeof names)
            length += (size_t)snprintf(names + length, sizeof names - length, "%s%.60s", length ? ", " : "", name);
    }
    if (unused == 0) return;
    int line, column;
    daft_text_place(&s->source->text, s->source->libraries[0].at, &line, &column);
    daft_problem_at(s->source->problems, DAFT_SEVERITY_NOTE, DAFT_OK, s->source->text.path, line, column,
                    "materials that no face uses, %zu of %zu: %s%s", unused, s->materials.count, names,
                    unused > 5 ? ", ..." : "");
}

bool daft_obj_make_slots(daft_obj_source *source, daft_mtl_list *out, daft_error *error)
{
    slots s = {.source = source, .error = error};
    bool done = load_libraries(&s) && index_materials(&s) && fill(&s, out);
    if (done && source->problems) note_unused(&s, out);
    daft_mtl_list_free(source->allocator, &s.materials);
    daft_release(source->allocator, s.buckets);
    return done;
}
