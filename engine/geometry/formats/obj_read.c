/* The statements of an OBJ file, read once from front to back into growing arrays. Sizes come from what has been read,
 * never from a number in the file. The rules are in obj.c. */
#include "geometry/formats/obj.h"
#include "geometry/trimesh.h"
typedef struct reader {
    daft_obj_source *source;
    daft_error *error;
    uint32_t slot, group;          /* of the next face */
    daft_obj_name material;        /* the last usemtl's; `slot` is found when a face uses it */
    bool slot_known, run_is_stale; /* the next face starts a run */
    bool any_statement;
    bool malformed; /* what has just failed is the line alone, and that has been told */
    const char *first_unknown;
    uint32_t *buckets; /* hash table of slot numbers + 1 by name */
    size_t bucket_count;
} reader;

static bool fail_memory(const reader *r)
{
    return daft_fail_at(r->error, DAFT_ERROR_MEMORY, r->source->text.path, 0, 0, "out of memory for the mesh");
}

static inline bool grow(const reader *r, void *array_pointer, size_t *room, size_t needed, size_t used, size_t size)
{
    if (needed <= *room) return true;
    return daft_grow(r->source->allocator, array_pointer, room, needed, used, size) || fail_memory(r);
}

/* Arrays that share one room. Where the second cannot grow, the first is larger than the room says, which is no harm.
 */
static bool grow_alike(const reader *r, void *const arrays[], int count, size_t *room, size_t needed, size_t used)
{
    size_t grown = *room;
    for (int i = 0; i < count; i++) {
        grown = *room;
        if (!grow(r, arrays[i], &grown, needed, used, sizeof(float))) return false;
    }
    *room = grown;
    return true;
}

static bool grow_positions(const reader *r, size_t needed)
{
    daft_obj_source *s = r->source;
    void *const axes[] = {&s->x, &s->y, &s->z};
    return grow_alike(r, axes, 3, &s->position_room, needed, s->position_count);
}

static bool grow_corners(const reader *r, size_t needed)
{
    daft_obj_source *s = r->source;
    void *lists[3] = {&s->corner_positions};
    int count = 1;
    if (s->corner_uvs) lists[count++] = &s->corner_uvs;
    if (s->corner_normals) lists[count++] = &s->corner_normals;
    return grow_alike(r, lists, count, &s->corner_room, needed, s->corner_count);
}

void daft_obj_drop(daft_obj_source *source, const char *at, const char *reason)
{
    source->drops++;
    if (!source->first_drop) source->first_drop = at, source->first_drop_reason = reason;
    daft_text_warn(&source->text, at, "the face is left out: %s", reason);
}

/* ---- v, vt, vn ---- */

/* Reads one number of a statement; moves *cursor behind it and the blanks that follow. */
static inline bool read_number(reader *r, const char **cursor, const char *keyword, double *out)
{
    const char *p = *cursor;
    if (!daft_scan_number(&p, r->source->text.end, out) || !daft_token_ends(&r->source->text, p)) {
        daft_error why;
        daft_text *text = &r->source->text;
        r->malformed = true;
        daft_text_fail_number(text, *cursor, keyword, daft_text_is_told(text) ? &why : NULL);
        daft_text_lose(text, &why);
        return false;
    }
    *cursor = daft_skip_blanks(p);
    return true;
}

/* Numbers beyond those a statement needs; *count is how many there are. */
static bool read_rest(reader *r, const char **cursor, const char *keyword, int *count)
{
    double ignored;
    for (*count = 0; !daft_at_end(&r->source->text, *cursor); ++*count)
        if (!read_number(r, cursor, keyword, &ignored)) return false;
    return true;
}

/* Colours up to that of the next position; positions without one are white. */
static bool fill_colors(const reader *r, size_t count)
{
    daft_obj_source *s = r->source;
    if (!grow(r, &s->colors, &s->color_room, count, s->color_count, sizeof *s->colors)) return false;
    while (s->color_count < count) s->colors[s->color_count++] = daft_v3(1, 1, 1);
    return true;
}

/* The same of alphas; positions without one have 1. */
static bool fill_alphas(const reader *r, size_t count)
{
    daft_obj_source *s = r->source;
    if (!grow(r, &s->alphas, &s->alpha_room, count, s->alpha_count, sizeof *s->alphas)) return false;
    while (s->alpha_count < count) s->alphas[s->alpha_count++] = 1;
    return true;
}

/* A weight (4 numbers), which is not used, or a colour (6 or, with an alpha, 7). */
static bool read_position_rest(reader *r, const char *start, const char **cursor)
{
    double more[4] = {0, 0, 0, 0}, ignored;
    int count = 0;
    for (; !daft_at_end(&r->source->text, *cursor); count++)
        if (!read_number(r, cursor, "v", count < 4 ? &more[count] : &ignored)) return false;
    if (count != 1 && count != 3 && count != 4)
        daft_text_warn(&r->source->text, start, "'v' has %d numbers, of which the first 3 are used", 3 + count);
    if (count != 3 && count != 4) return true;
    if (!fill_colors(r, r->source->position_count + 1)) return false;
    r->source->colors[r->source->position_count] =
        daft_v3(daft_trimesh_color(more[0]), daft_trimesh_color(more[1]), daft_trimesh_color(more[2]));
    if (count != 4) return true;
    if (!fill_alphas(r, r->source->position_count + 1)) return false;
    r->source->alphas[r->source->position_count] = daft_trimesh_alpha((float)more[3]);
    return true;
}

static bool push_position(const reader *r, const char *statement, const double p[3])
{
    daft_obj_source *s = r->source;
    size_t at = s->position_count;
    if (at >= DAFT_OBJ_MAX_INDEX)
        return daft_text_fail(&s->text, statement, r->error, "more vertices than 32 bits can count");
    if (at == s->position_room && !grow_positions(r, at + 1)) return false;
    daft_vec3 position = {(float)p[0], (float)p[1], (float)p[2]};
    s->bad_position |= !daft_finite3(position);
    s->x[at] = position.x, s->y[at] = position.y, s->z[at] = position.z;
    s->position_count++;
    return true;
}

static bool read_position(reader *r, const char **cursor)
{
    const char *start = *cursor;
    double p[3];
    for (int i = 0; i < 3; i++)
        if (!read_number(r, cursor, "v", &p[i])) return false;
    if (!daft_is_break(**cursor) && !read_position_rest(r, start, cursor)) return false;
    return push_position(r, start, p);
}

static bool push_normal(const reader *r, const char *statement, const double n[3])
{
    daft_obj_source *s = r->source;
    if (s->normal_count >= DAFT_OBJ_MAX_INDEX)
        return daft_text_fail(&s->text, statement, r->error, "more normals than 32 bits can count");
    if (!grow(r, &s->normals, &s->normal_room, s->normal_count + 1, s->normal_count, sizeof *s->normals)) return false;
    s->normals[s->normal_count++] = daft_v3((float)n[0], (float)n[1], (float)n[2]);
    return true;
}

static bool read_normal(reader *r, const char **cursor)
{
    const char *start = *cursor;
    double n[3];
    int more = 0;
    for (int i = 0; i < 3; i++)
        if (!read_number(r, cursor, "vn", &n[i])) return false;
    if (!daft_is_break(**cursor) && !read_rest(r, cursor, "vn", &more)) return false;
    if (more > 0)
        daft_text_warn(&r->source->text, start, "'vn' has %d numbers, of which the first 3 are used", 3 + more);
    return push_normal(r, start, n);
}

static bool push_uv(const reader *r, const char *statement, const double p[2])
{
    daft_obj_source *s = r->source;
    if (s->uv_count >= DAFT_OBJ_MAX_INDEX)
        return daft_text_fail(&s->text, statement, r->error, "more texture coordinates than 32 bits can count");
    if (!grow(r, &s->uvs, &s->uv_room, s->uv_count + 1, s->uv_count, sizeof *s->uvs)) return false;
    daft_vec2 uv = {(float)p[0], (float)p[1]};
    s->bad_uv |= !isfinite(uv.x) || !isfinite(uv.y);
    s->uvs[s->uv_count++] = uv;
    return true;
}

/* One number (v is 0), two, or three (the third is for solid textures and not used). */
static bool read_uv(reader *r, const char **cursor)
{
    daft_text *text = &r->source->text;
    const char *start = *cursor;
    double uv[2] = {0, 0};
    int more = 0;
    if (!read_number(r, cursor, "vt", &uv[0])) return false;
    if (!daft_at_end(text, *cursor) && !read_number(r, cursor, "vt", &uv[1])) return false;
    if (!daft_is_break(**cursor) && !read_rest(r, cursor, "vt", &more)) return false;
    if (more > 1) daft_text_warn(text, start, "'vt' has %d numbers, of which the first 2 are used", 2 + more);
    return push_uv(r, start, uv);
}

/* ---- f ---- */

/* Index from 0, or DAFT_OBJ_ABSENT where it is 0 or reaches before the first. */
static inline uint32_t resolve(int64_t index, size_t count)
{
    if (index > 0) return index - 1 < (int64_t)DAFT_OBJ_MAX_INDEX ? (uint32_t)(index - 1) : DAFT_OBJ_MAX_INDEX;
    index += (int64_t)count;
    return index < 0 || index == (int64_t)count ? DAFT_OBJ_ABSENT : (uint32_t)index;
}

static bool fail_corner(reader *r, const char *at)
{
    daft_error why;
    daft_text *text = &r->source->text;
    size_t length = (size_t)(daft_skip_token(text, at) - at);
    r->malformed = true;
    daft_text_fail(text, at, daft_text_is_told(text) ? &why : NULL,
                   "'%s' is not a corner of a face: v, v/vt, v//vn or v/vt/vn", daft_text_quote(at, length).text);
    daft_text_lose(text, &why);
    return false;
}

/* A place that says "none": empty or 0. Anything else that cannot be had is worth a warning. */
static uint32_t resolve_attribute(const reader *r, const char *at, int64_t index, size_t count, const char *what)
{
    uint32_t resolved = resolve(index, count);
    if (resolved == DAFT_OBJ_ABSENT && index != 0)
        daft_text_warn(&r->source->text, at, "%s %lld reaches before the first, so the corner has none", what,
                       (long long)index);
    return resolved;
}

/* A corner by its three indices. */
enum { POSITION, UV, NORMAL };

/* The part of a corner behind the position: /vt, //vn, /vt/vn. *cursor stands on the first slash. */
static inline bool read_attributes(reader *r, const char *start, const char **cursor, uint32_t corner[3])
{
    const daft_obj_source *s = r->source;
    const char *p = *cursor + 1;
    int64_t index;
    if (*p != '/' && !daft_token_ends(&s->text, p)) {
        if (!daft_scan_integer(&p, s->text.end, &index)) return fail_corner(r, start);
        corner[UV] = resolve_attribute(r, start, index, s->uv_count, "texture coordinate");
    }
    if (*p == '/' && !daft_token_ends(&s->text, ++p)) {
        if (!daft_scan_integer(&p, s->text.end, &index)) return fail_corner(r, start);
        corner[NORMAL] = resolve_attribute(r, start, index, s->normal_count, "normal");
    }
    *cursor = p;
    return true;
}

/* Appends a corner. A list of uvs or normals begins with the first corner that has one. */
static bool push_corner(const reader *r, const uint32_t corner[3])
{
    daft_obj_source *s = r->source;
    size_t at = s->corner_count;
    if (at == s->corner_room && !grow_corners(r, at + 1)) return false;
    uint32_t **lists[3] = {&s->corner_positions, &s->corner_uvs, &s->corner_normals};
    for (int i = 0; i < 3; i++) {
        if (!*lists[i] && corner[i] != DAFT_OBJ_ABSENT) {
            *lists[i] = daft_alloc(s->allocator, s->corner_room, sizeof(uint32_t));
            if (!*lists[i]) return fail_memory(r);
            memset(*lists[i], 0xff, at * sizeof(uint32_t)); /* DAFT_OBJ_ABSENT */
        }
        if (*lists[i]) (*lists[i])[at] = corner[i];
    }
    s->corner_count++;
    return true;
}

/* Appends the corners of a face. *reason stays NULL unless the face has to be dropped, and *where is then the place. */
static bool read_corners(reader *r, const char **cursor, const char **reason, const char **where)
{
    const daft_obj_source *s = r->source;
    const char *p = *cursor;
    while (!daft_at_end(&s->text, p)) {
        const char *start = p;
        int64_t index;
        if (!daft_scan_integer(&p, s->text.end, &index)) return fail_corner(r, start);
        uint32_t corner[3] = {resolve(index, s->position_count), DAFT_OBJ_ABSENT, DAFT_OBJ_ABSENT};
        if (corner[POSITION] == DAFT_OBJ_ABSENT && !*reason) {
            *reason = index ? "a negative index reaches before the first vertex" : "vertex index 0 (the first is 1)";
            *where = start;
        }
        if (*p == '/' && !read_attributes(r, start, &p, corner)) return false;
        if (!daft_token_ends(&s->text, p)) return fail_corner(r, start);
        if (!push_corner(r, corner)) return false;
        p = daft_skip_blanks(p);
    }
    *cursor = p;
    return true;
}

/* Slots are numbered by the first face that uses them. Open addressing; at most half full. */
static bool grow_buckets(reader *r)
{
    daft_obj_source *s = r->source;
    if (2 * (s->slot_count + 1) <= r->bucket_count) return true;
    size_t count = r->bucket_count ? 2 * r->bucket_count : 64;
    uint32_t *buckets = daft_alloc_zero(s->allocator, count, sizeof *buckets);
    if (!buckets) return fail_memory(r);
    daft_release(s->allocator, r->buckets);
    r->buckets = buckets;
    r->bucket_count = count;
    for (size_t i = 0; i < s->slot_count; i++) {
        size_t at = daft_hash(s->slots[i].at, s->slots[i].length, 0) & (count - 1);
        while (buckets[at]) at = (at + 1) & (count - 1);
        buckets[at] = (uint32_t)i + 1;
    }
    return true;
}

static bool find_slot(reader *r)
{
    daft_obj_source *s = r->source;
    if (!grow_buckets(r)) return false;
    size_t at = daft_hash(r->material.at, r->material.length, 0) & (r->bucket_count - 1);
    for (; r->buckets[at]; at = (at + 1) & (r->bucket_count - 1)) {
        const daft_obj_name *slot = &s->slots[r->buckets[at] - 1];
        if (slot->length != r->material.length || memcmp(slot->at, r->material.at, slot->length) != 0) continue;
        r->slot = r->buckets[at] - 1;
        return true;
    }
    if (s->slot_count > UINT16_MAX)
        return daft_text_fail(&s->text, r->material.at, r->error, "more than 65,536 materials in one mesh");
    if (!grow(r, &s->slots, &s->slot_room, s->slot_count + 1, s->slot_count, sizeof *s->slots)) return false;
    s->slots[s->slot_count++] = r->material;
    r->slot = (uint32_t)s->slot_count - 1;
    r->buckets[at] = r->slot + 1;
    return true;
}

static bool start_run(reader *r)
{
    daft_obj_source *s = r->source;
    if (!r->slot_known && !find_slot(r)) return false;
    r->slot_known = true;
    r->run_is_stale = false;
    if (s->run_count > 0) {
        const daft_obj_run *last = &s->runs[s->run_count - 1];
        if (last->slot == r->slot && last->group == r->group) return true;
    }
    if (!grow(r, &s->runs, &s->run_room, s->run_count + 1, s->run_count, sizeof *s->runs)) return false;
    s->runs[s->run_count++] = (daft_obj_run){(uint32_t)s->face_count, r->slot, r->group};
    return true;
}

/* How many corners the next face has. The list begins with the first face that has not three. */
static bool push_count(const reader *r, uint32_t count)
{
    daft_obj_source *s = r->source;
    if (s->faces || count != 3) {
        bool first = !s->faces;
        if (!grow(r, &s->faces, &s->face_room, s->face_count + 1, first ? 0 : s->face_count, sizeof *s->faces))
            return false;
        for (size_t i = 0; first && i < s->face_count; i++) s->faces[i] = 3;
        s->faces[s->face_count] = count;
    }
    s->face_count++;
    return true;
}

/* A face that cannot be read counts as one that has been dropped. */
static bool lose_face(reader *r, const char *statement, size_t corners_before)
{
    daft_obj_source *s = r->source;
    if (!r->malformed) return false;
    s->corner_count = corners_before;
    s->drops++;
    if (!s->first_drop) s->first_drop = statement, s->first_drop_reason = "a corner of it cannot be read";
    r->malformed = push_count(r, 0); /* else memory is out */
    return false;
}

static bool read_face(reader *r, const char *statement, const char **cursor)
{
    daft_obj_source *s = r->source;
    const char *reason = NULL, *where = statement;
    size_t before = s->corner_count;
    if (!read_corners(r, cursor, &reason, &where)) return lose_face(r, statement, before);
    size_t count = s->corner_count - before;
    if (!reason && count < 3) reason = "it has fewer than 3 corners";
    if (reason) {
        daft_obj_drop(s, where, reason);
        s->corner_count = before;
        count = 0;
    } else {
        if (r->run_is_stale && !start_run(r)) return false;
        s->triangle_count += count - 2;
        if (count > s->largest_face) s->largest_face = (uint32_t)count;
        const uint32_t *v = s->corner_positions + before;
        if (count == 3) s->repeats |= v[0] == v[1] || v[1] == v[2] || v[2] == v[0];
    }
    if (s->triangle_count > UINT32_MAX / 3 || s->face_count >= UINT32_MAX)
        return daft_text_fail(&s->text, statement, r->error, "more triangles than 32-bit indices can hold");
    return push_count(r, (uint32_t)count);
}

/* ---- the rest ---- */

static void read_group(reader *r, const char *statement, const char *p)
{
    daft_text *text = &r->source->text;
    size_t length = (size_t)(daft_skip_token(text, p) - p);
    const char *after = p;
    int64_t group;
    if (daft_word_is(p, length, "off"))
        group = 0;
    else if (!daft_scan_integer(&after, text->end, &group) || !daft_token_ends(text, after) || group < 0) {
        daft_text_warn(text, statement, "'s' takes a number or 'off', and this one is skipped");
        return;
    }
    r->group = (uint32_t)(group % DAFT_OBJ_GROUP_NONE);
    r->run_is_stale = true;
}

static bool read_library(const reader *r, const char *p)
{
    daft_obj_source *s = r->source;
    const char *end = daft_skip_statement(&s->text, p);
    if (!grow(r, &s->libraries, &s->library_room, s->library_count + 1, s->library_count, sizeof *s->libraries))
        return false;
    s->libraries[s->library_count++] = (daft_obj_name){p, (size_t)(end - p)};
    return true;
}

/* Statements that neither change the triangles nor deserve a word. */
static bool is_skipped_quietly(const char *at, size_t length)
{
    static const char *const known[] = {"o",        "g",          "l",         "p",      "vw",
                                        "vp",       "mg",         "bevel",     "lod",    "c_interp",
                                        "d_interp", "shadow_obj", "trace_obj", "usemap", "maplib"};
    for (size_t i = 0; i < DAFT_COUNT_OF(known); i++)
        if (daft_word_is(at, length, known[i])) return true;
    return false;
}

/* Any statement, by its first word. *cursor stands on the word. */
static bool read_statement(reader *r, const char **cursor)
{
    daft_text *text = &r->source->text;
    const char *word = *cursor, *p = daft_skip_token(text, word);
    size_t length = (size_t)(p - word);
    p = *cursor = daft_skip_blanks(p);
    if (daft_word_is(word, length, "v")) return read_position(r, cursor);
    if (daft_word_is(word, length, "vt")) return read_uv(r, cursor);
    if (daft_word_is(word, length, "vn")) return read_normal(r, cursor);
    if (daft_word_is(word, length, "f")) return read_face(r, word, cursor);
    *cursor = daft_skip_statement(text, p);
    if (daft_word_is(word, length, "usemtl")) {
        r->material.at = daft_rest_of_line(text, p, &r->material.length);
        r->slot_known = false;
        r->run_is_stale = true;
    } else if (daft_word_is(word, length, "s")) {
        read_group(r, word, p);
    } else if (daft_word_is(word, length, "mtllib")) {
        if (!read_library(r, p)) return false;
    } else if (!is_skipped_quietly(word, length)) {
        if (!r->first_unknown) r->first_unknown = word;
        daft_text_warn_unknown(text, word, length, "statement");
        return true;
    }
    r->any_statement = true;
    return true;
}

/* The statements that fill large files, by their first bytes; then the general case. */
static inline bool read_line(reader *r, const char **cursor)
{
    const char *p = *cursor;
    if (p[0] == 'v' && p[1] == ' ') return *cursor = daft_skip_blanks(p + 2), read_position(r, cursor);
    if (p[0] == 'f' && p[1] == ' ') return *cursor = daft_skip_blanks(p + 2), read_face(r, p, cursor);
    if (p[0] == 'v' && p[1] == 't' && p[2] == ' ') return *cursor = daft_skip_blanks(p + 3), read_uv(r, cursor);
    if (p[0] == 'v' && p[1] == 'n' && p[2] == ' ') return *cursor = daft_skip_blanks(p + 3), read_normal(r, cursor);
    return read_statement(r, cursor);
}

/* A line that cannot be read is left out. What later lines count keeps its number: a position without
 * numbers is not finite, so the faces that use it are dropped. */
static bool lose_line(reader *r, const char *line, const char **cursor)
{
    static const double NOTHING[3] = {NAN, NAN, NAN}, NOWHERE[3] = {0, 0, 0};
    daft_obj_source *s = r->source;
    if (!r->malformed) return false;
    r->malformed = false;
    *cursor = daft_skip_statement(&s->text, line);
    const bool more = daft_is_blank(line[1]) || daft_is_break(line[1]);
    if (line[0] == 'v' && more) return push_position(r, line, NOTHING);
    if (line[0] == 'v' && line[1] == 't') return push_uv(r, line, NOTHING);
    if (line[0] == 'v' && line[1] == 'n') return push_normal(r, line, NOWHERE);
    return true;
}

static bool read_lines(reader *r)
{
    const daft_text *text = &r->source->text;
    for (const char *p = text->begin; p < text->end;) {
        p = daft_obj_scan(r->source, p, !r->run_is_stale);
        if (daft_is_break(*p))
            p++;
        else if (*p == '#')
            p = daft_skip_comment(text, p);
        else if (daft_is_blank(*p) || (*p == '\\' && daft_is_break(p[1])))
            p = daft_skip_blanks(p);
        else {
            const char *line = p;
            if (!read_line(r, &p) && !lose_line(r, line, &p)) return false;
        }
    }
    return true;
}

/* A file that says nothing, or nothing that an OBJ file says. */
static bool check_content(const reader *r)
{
    const daft_obj_source *s = r->source;
    if (r->any_statement || s->position_count || s->normal_count || s->uv_count || s->face_count) return true;
    if (!r->first_unknown)
        return daft_fail_at(r->error, DAFT_ERROR_SYNTAX, s->text.path, 0, 0, "the file is empty, not an OBJ mesh");
    size_t length = (size_t)(daft_skip_token(&s->text, r->first_unknown) - r->first_unknown);
    return daft_text_fail(&s->text, r->first_unknown, r->error, "not an OBJ file: nothing in it is known, from '%s' on",
                          daft_text_quote(r->first_unknown, length).text);
}

/* Lines of each kind in the file, about: counted in 128 pieces of it, in all of it where it is small. */
typedef struct line_counts {
    size_t v, vt, vn, f;
} line_counts;

static void count_lines(const char *p, const char *end, line_counts *counts)
{
    while ((p = memchr(p, '\n', (size_t)(end - p))) != NULL) {
        p++; /* at most the text's end, which is a zero byte */
        if (p[0] == 'f')
            counts->f++;
        else if (p[0] == 'v')
            counts->v += p[1] == ' ', counts->vt += p[1] == 't', counts->vn += p[1] == 'n';
    }
}

static line_counts estimate(const daft_text *text)
{
    enum { PIECES = 128, PIECE = 256 };
    line_counts counts = {0};
    size_t size = (size_t)(text->end - text->begin), seen = 0;
    for (size_t i = 0; i < PIECES; i++) {
        const char *from = text->begin + size / PIECES * i, *next = i + 1 < PIECES ? from + size / PIECES : text->end;
        const char *to = next - from > PIECE ? from + PIECE : next;
        count_lines(from, to, &counts);
        seen += (size_t)(to - from);
    }
    size_t *all[] = {&counts.v, &counts.vt, &counts.vn, &counts.f};
    for (size_t i = 0; i < DAFT_COUNT_OF(all) && seen > 0; i++)
        if (*all[i] > 0)
            *all[i] = (size_t)((double)*all[i] * ((double)size / (double)seen) * (seen < size ? 1.03 : 1)) + 2;
    return counts;
}

/* Less grows, more is given back. */
static bool reserve(const reader *r)
{
    daft_obj_source *s = r->source;
    line_counts lines = estimate(&s->text);
    return grow_positions(r, lines.v) && grow_corners(r, 3 * lines.f) &&
           grow(r, &s->uvs, &s->uv_room, lines.vt, 0, sizeof *s->uvs) &&
           grow(r, &s->normals, &s->normal_room, lines.vn, 0, sizeof *s->normals);
}

bool daft_obj_read(daft_obj_source *source, daft_error *error)
{
    reader r = {.source = source,
                .error = error,
                .group = DAFT_OBJ_GROUP_NONE,
                .material = {source->text.begin, 0},
                .run_is_stale = true};
    bool done = daft_text_check_encoding(&source->text, error) && reserve(&r) && read_lines(&r) && check_content(&r);
    daft_release(source->allocator, r.buckets);
    return done;
}

const char *daft_obj_find_face(const daft_obj_source *source, size_t face)
{
    const daft_text *text = &source->text;
    const char *p = text->begin;
    while (p < text->end) {
        if (daft_is_break(*p)) {
            p++;
            continue;
        }
        p = daft_skip_blanks(p);
        if (*p == 'f' && daft_token_ends(text, p + 1) && face-- == 0) return p;
        p = *p == '#' ? daft_skip_comment(text, p) : daft_skip_statement(text, p);
    }
    return text->begin;
}
