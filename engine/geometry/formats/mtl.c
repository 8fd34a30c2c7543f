/* MTL files: materials of the Phong kind. Errors, with line and column: a number that is none, is not finite, or is
 * missing; newmtl or a map without a name; a property before the first newmtl; an empty file. Values out of range are
 * cut with a warning. Statements that describe what the engine does not draw (displacement, clear coats) are skipped,
 * which a check tells, unknown ones with one warning each. Keywords are read whatever their case. */
#include "geometry/mesh.h"
#include "geometry/formats/mtl_map.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <strings.h>

typedef struct reader {
    daft_text text;
    const daft_allocator *allocator;
    const daft_files *files;
    daft_error *error; /* of the line that is being read; NULL: nobody will be told */
    bool out_of_memory;
    daft_mtl_list *list;
    daft_mtl *current;                        /* NULL before the first newmtl, and after one that is left out */
    bool has_ambient, has_d, has_tr, has_map; /* in the current material */
    float tr;
    const char *first_unknown;
    const char *cube; /* the last side of one in the current material; NULL: none */
    bool any_known;
} reader;

typedef bool statement_function(reader *r, const char *word, const char *p);

daft_mtl daft_mtl_default(void)
{
    return (daft_mtl){.ambient = {0.8f, 0.8f, 0.8f},
                      .diffuse = {0.8f, 0.8f, 0.8f},
                      .shininess = 32,
                      .index = 1,
                      .opacity = 1,
                      .alpha_cutoff = 0.5f,
                      .bump = 1,
                      .normal = 1,
                      .occlusion = 1,
                      .scale = {1, 1},
                      .diffuse_change = {.gain = 1},
                      .filter = {1, 1, 1},
                      .illum = 2};
}

void daft_mtl_drop(const daft_allocator *allocator, daft_mtl *mtl)
{
    for (int i = 0; mtl->maps && i < DAFT_MTL_MAPS; i++) daft_release(allocator, mtl->maps->map[i].bytes);
    daft_release(allocator, mtl->maps);
    daft_release(allocator, mtl->map_bytes);
    mtl->maps = NULL, mtl->map_bytes = NULL;
}

static bool copy_bytes(const daft_allocator *allocator, uint8_t **bytes, size_t size)
{
    uint8_t *copy = *bytes ? daft_alloc(allocator, size ? size : 1, 1) : NULL;
    const bool done = copy || !*bytes;
    if (copy) memcpy(copy, *bytes, size);
    *bytes = copy;
    return done;
}

bool daft_mtl_copy(const daft_allocator *allocator, const daft_mtl *from, daft_mtl *out)
{
    *out = *from;
    out->maps = NULL;
    bool done = copy_bytes(allocator, &out->map_bytes, out->map_size);
    if (!from->maps) return done;
    out->maps = daft_alloc(allocator, 1, sizeof *out->maps);
    if (!out->maps) return false;
    *out->maps = *from->maps;
    for (int i = 0; i < DAFT_MTL_MAPS; i++)
        done = copy_bytes(allocator, &out->maps->map[i].bytes, out->maps->map[i].size) && done;
    return done;
}

daft_mtl_map *daft_mtl_map_at(const daft_allocator *allocator, daft_mtl *mtl, daft_mtl_use use)
{
    if (!mtl->maps) mtl->maps = daft_alloc_zero(allocator, 1, sizeof *mtl->maps);
    return mtl->maps ? &mtl->maps->map[use] : NULL;
}

void daft_mtl_list_free(const daft_allocator *allocator, daft_mtl_list *list)
{
    for (size_t i = 0; i < list->count; i++) daft_mtl_drop(allocator, &list->items[i]);
    daft_release(allocator, list->items);
    *list = (daft_mtl_list){0};
}

static const char *keyword_of(const char *word, const char *p, daft_quoted *quoted)
{
    size_t length = 0;
    while (word + length < p && !daft_is_blank(word[length])) length++;
    *quoted = daft_text_quote(word, length);
    return quoted->text;
}

/* ---- numbers ---- */

static bool read_number(const reader *r, const char *word, const char **cursor, float *out)
{
    const char *p = *cursor;
    double value = 0;
    daft_quoted keyword;
    if (!daft_scan_number(&p, r->text.end, &value) || !daft_token_ends(&r->text, p))
        return daft_text_fail_number(&r->text, *cursor, keyword_of(word, *cursor, &keyword), r->error);
    if (!isfinite((float)value)) return daft_text_fail(&r->text, *cursor, r->error, "a finite number is needed here");
    *out = (float)value;
    *cursor = daft_skip_blanks(p);
    return true;
}

static void warn_rest(reader *r, const char *p)
{
    if (daft_at_end(&r->text, p)) return;
    size_t length = (size_t)(daft_skip_token(&r->text, p) - p);
    daft_text_warn(&r->text, p, "'%s' is more than is needed here, and is skipped", daft_text_quote(p, length).text);
}

static bool read_last_number(reader *r, const char *word, const char *p, float *out)
{
    if (!read_number(r, word, &p, out)) return false;
    warn_rest(r, p);
    return true;
}

static float clamp(reader *r, const char *word, float value, float low, float high)
{
    float cut = value < low ? low : value > high ? high : value;
    if (cut != value)
        daft_text_warn(&r->text, word, "%g is out of range, and is taken as %g", (double)value, (double)cut);
    return cut;
}

/* Three numbers, or one for a grey. Spectra and CIE XYZ are not understood: *known is then false. */
static bool read_color(reader *r, const char *word, const char *p, daft_vec3 *out, bool *known)
{
    size_t length = (size_t)(daft_skip_token(&r->text, p) - p);
    *known = !daft_word_is(p, length, "spectral") && !daft_word_is(p, length, "xyz");
    if (!*known) {
        daft_text_warn(&r->text, p, "colours given as '%s' are skipped", daft_text_quote(p, length).text);
        return true;
    }
    float c[3];
    if (!read_number(r, word, &p, &c[0])) return false;
    if (daft_at_end(&r->text, p))
        c[1] = c[2] = c[0];
    else if (!read_number(r, word, &p, &c[1]) || !read_number(r, word, &p, &c[2]))
        return false;
    warn_rest(r, p);
    for (int i = 0; i < 3; i++) c[i] = clamp(r, word, c[i], 0, INFINITY);
    *out = daft_v3(c[0], c[1], c[2]);
    return true;
}

static bool read_color_into(reader *r, const char *word, const char *p, daft_vec3 *target)
{
    bool known;
    daft_vec3 color;
    if (!read_color(r, word, p, &color, &known)) return false;
    if (known) *target = color;
    return true;
}

static bool read_ka(reader *r, const char *word, const char *p)
{
    r->has_ambient = true;
    return read_color_into(r, word, p, &r->current->ambient);
}

/* Ambient light is reflected as diffuse light is, unless Ka says otherwise. */
static bool read_kd(reader *r, const char *word, const char *p)
{
    if (!read_color_into(r, word, p, &r->current->diffuse)) return false;
    if (!r->has_ambient) r->current->ambient = r->current->diffuse;
    return true;
}

static bool read_ks(reader *r, const char *word, const char *p)
{
    return read_color_into(r, word, p, &r->current->specular);
}

static bool read_ke(reader *r, const char *word, const char *p)
{
    return read_color_into(r, word, p, &r->current->emission);
}

/* Tf, also written Kt: what comes through, by colour. */
static bool read_tf(reader *r, const char *word, const char *p)
{
    bool known;
    daft_vec3 tf;
    if (!read_color(r, word, p, &tf, &known)) return false;
    if (!known) return true;
    r->current->filter = daft_v3(clamp(r, word, tf.x, 0, 1), clamp(r, word, tf.y, 0, 1), clamp(r, word, tf.z, 0, 1));
    r->current->has_filter = true;
    return true;
}

/* Ours: as in .scene files. */
static bool read_tint_distance(reader *r, const char *word, const char *p)
{
    float value;
    if (!read_last_number(r, word, p, &value)) return false;
    r->current->tint_distance = clamp(r, word, value, 0, INFINITY);
    return true;
}

static bool read_priority(reader *r, const char *word, const char *p)
{
    float value;
    if (!read_last_number(r, word, p, &value)) return false;
    if (value != floorf(value)) daft_text_warn(&r->text, word, "%g is no whole number: it is cut", (double)value);
    r->current->priority = (int)clamp(r, word, value, 0, 255);
    return true;
}

static bool read_ns(reader *r, const char *word, const char *p)
{
    float value;
    if (!read_last_number(r, word, p, &value)) return false;
    r->current->shininess = clamp(r, word, value, 0, 1000);
    return true;
}

static bool read_ni(reader *r, const char *word, const char *p)
{
    float value;
    if (!read_last_number(r, word, p, &value)) return false;
    if (!(value > 0)) { /* some write 0 for "not known" */
        daft_text_warn(&r->text, word, "%g is no index of refraction, and is taken as 1", (double)value);
        value = 1;
    }
    r->current->index = clamp(r, word, value, 0.001f, 10);
    return true;
}

/* d (opacity) and Tr (transparency) say the same thing; many exporters write both, and some of them one wrongly. */
static void warn_contradiction(reader *r, const char *word)
{
    if (r->has_d && r->has_tr && fabsf(r->current->opacity + r->tr - 1) > 1e-3f)
        daft_text_warn(&r->text, word, "d and Tr contradict each other: d is used");
}

static bool read_d(reader *r, const char *word, const char *p)
{
    size_t length = (size_t)(daft_skip_token(&r->text, p) - p);
    if (daft_word_is(p, length, "-halo")) p = daft_skip_blanks(p + length);
    float value;
    if (!read_last_number(r, word, p, &value)) return false;
    r->current->opacity = clamp(r, word, value, 0, 1);
    r->has_d = true;
    warn_contradiction(r, word);
    return true;
}

static bool read_tr(reader *r, const char *word, const char *p)
{
    float value;
    if (!read_last_number(r, word, p, &value)) return false;
    r->tr = clamp(r, word, value, 0, 1);
    r->has_tr = true;
    if (!r->has_d) r->current->opacity = 1 - r->tr;
    warn_contradiction(r, word);
    return true;
}

static bool read_pr(reader *r, const char *word, const char *p)
{
    float value;
    if (!read_last_number(r, word, p, &value)) return false;
    r->current->roughness = clamp(r, word, value, 0, 1);
    r->current->has_roughness = true;
    return true;
}

static bool read_pm(reader *r, const char *word, const char *p)
{
    float value;
    if (!read_last_number(r, word, p, &value)) return false;
    r->current->metallic = clamp(r, word, value, 0, 1);
    r->current->physical = true;
    return true;
}

static bool read_illum(reader *r, const char *word, const char *p)
{
    float value;
    if (!read_last_number(r, word, p, &value)) return false;
    r->current->illum = (int)clamp(r, word, value, 0, 10);
    return true;
}

/* ---- maps: mtl_map.c reads their options and names ---- */

/* A material's maps lie in one place: that of map_Kd or, without one, of the first. */
static void place_maps(reader *r, const char *word, const daft_mtl_settings *s, bool first)
{
    daft_mtl *m = r->current;
    const uint32_t wrap = s->clamps ? DAFT_WRAP_CLAMP : DAFT_WRAP_REPEAT;
    const bool same = m->scale.x == s->scale.x && m->scale.y == s->scale.y && m->offset.x == s->offset.x &&
                      m->offset.y == s->offset.y && m->wrap == wrap;
    if (same) return;
    if (first || !r->has_map) {
        m->scale = s->scale, m->offset = s->offset, m->wrap = wrap;
        return;
    }
    if (s->places) daft_text_warn(&r->text, word, "all maps of a material lie as its map_Kd or its first does");
}

static bool read_map_kd(reader *r, const char *word, const char *p)
{
    daft_mtl_settings settings;
    daft_mtl_map map = {0};
    if (!daft_mtl_map_read(&r->text, r->files, word, p, &settings, &map, r->error)) return false;
    memcpy(r->current->diffuse_map, map.path, sizeof map.path);
    r->current->diffuse_map_line = map.line, r->current->diffuse_map_column = map.column;
    r->current->diffuse_change = map.change;
    place_maps(r, word, &settings, true);
    return r->has_map = true;
}

/* The keywords of the other maps. */
static const struct {
    const char *word;
    daft_mtl_use use;
} other_maps[] = {
    {"map_Ka", DAFT_MTL_AMBIENT},   {"map_Ks", DAFT_MTL_SPECULAR},     {"map_Ke", DAFT_MTL_EMISSION},
    {"map_Ns", DAFT_MTL_SHININESS}, {"map_d", DAFT_MTL_ALPHA},         {"map_Bump", DAFT_MTL_BUMP},
    {"bump", DAFT_MTL_BUMP},        {"norm", DAFT_MTL_NORMAL},         {"map_norm", DAFT_MTL_NORMAL},
    {"map_Kn", DAFT_MTL_NORMAL},    {"map_Pr", DAFT_MTL_ROUGHNESS},    {"map_Pm", DAFT_MTL_METALLIC},
    {"refl", DAFT_MTL_REFLECTION},  {"map_refl", DAFT_MTL_REFLECTION}, {"map_AO", DAFT_MTL_OCCLUSION},
};

static bool is_word(const char *word, size_t length, const char *keyword)
{
    return strlen(keyword) == length && strncasecmp(keyword, word, length) == 0;
}

/* A map without its factor is all of it. */
static void complete_factor(reader *r, daft_mtl_use use)
{
    daft_mtl *m = r->current;
    if (use == DAFT_MTL_SPECULAR && m->specular.x + m->specular.y + m->specular.z == 0) m->specular = daft_v3(1, 1, 1);
    if (use == DAFT_MTL_EMISSION && m->emission.x + m->emission.y + m->emission.z == 0) m->emission = daft_v3(1, 1, 1);
    if (use == DAFT_MTL_ROUGHNESS && m->roughness == 0) m->roughness = 1;
    if (use == DAFT_MTL_METALLIC && m->metallic == 0) m->metallic = 1;
    m->physical |= use == DAFT_MTL_ROUGHNESS || use == DAFT_MTL_METALLIC;
    if (use == DAFT_MTL_ALPHA) m->alpha_mode = DAFT_ALPHA_MASK;
}

static bool read_other_map(reader *r, const char *word, const char *p)
{
    const size_t length = (size_t)(daft_skip_token(&r->text, word) - word);
    size_t k = 0;
    while (!is_word(word, length, other_maps[k].word)) k++;
    daft_mtl_settings settings;
    daft_mtl_map map = {0};
    if (!daft_mtl_map_read(&r->text, r->files, word, p, &settings, &map, r->error)) return false;
    daft_mtl_use use = other_maps[k].use;
    if (use == DAFT_MTL_REFLECTION && settings.side) {
        if (settings.side < 0)
            return daft_text_fail(&r->text, word, r->error,
                                  "a side of a cube is cube_right, cube_left, cube_top, cube_bottom, cube_front or "
                                  "cube_back");
        use = (daft_mtl_use)(DAFT_MTL_CUBE + settings.side - 1), r->cube = word;
    }
    daft_mtl_map *at = daft_mtl_map_at(r->allocator, r->current, use);
    if (!at) {
        r->out_of_memory = true;
        return false;
    }
    *at = map;
    if (other_maps[k].use == DAFT_MTL_REFLECTION)
        return true; /* also of a cube: it lies around all, not on the surface */
    if (use == DAFT_MTL_BUMP) r->current->bump = settings.bump;
    if (use == DAFT_MTL_NORMAL) r->current->normal = settings.bump;
    place_maps(r, word, &settings, false);
    complete_factor(r, use);
    return r->has_map = true;
}

/* A cube has six sides, or is none. */
static void close_cube(reader *r)
{
    char missing[100];
    size_t used = 0;
    if (!r->cube || !r->current) return;
    daft_mtl_map *sides = &r->current->maps->map[DAFT_MTL_CUBE];
    for (int i = 0; i < 6; i++)
        if (!sides[i].path[0])
            used += (size_t)snprintf(missing + used, sizeof missing - used, "%s%s", used ? ", " : "",
                                     daft_mtl_cube_sides[i]);
    if (used > 0) {
        daft_text_warn(&r->text, r->cube, "the cube that is mirrored lacks %s: it is left out", missing);
        memset(sides, 0, 6 * sizeof *sides);
    }
    r->cube = NULL;
}

/* ---- statements ---- */

static bool read_newmtl(reader *r, const char *word, const char *p)
{
    size_t length;
    const char *name = daft_rest_of_line(&r->text, p, &length);
    daft_mtl material = daft_mtl_default();
    close_cube(r);
    r->current = NULL;
    if (length == 0) daft_text_warn(&r->text, word, "this material has no name");
    if (length >= sizeof material.name || memchr(name, 0, length))
        return daft_text_fail(&r->text, name, r->error, "a material's name has at most %zu characters",
                              sizeof material.name - 1);
    memcpy(material.name, name, length);
    snprintf(material.file, sizeof material.file, "%s", r->text.path);
    daft_mtl_list *list = r->list;
    if (!daft_grow(r->allocator, &list->items, &list->capacity, list->count + 1, list->count, sizeof material)) {
        r->out_of_memory = true;
        return false;
    }
    list->items[list->count] = material;
    r->current = &list->items[list->count++];
    r->has_ambient = r->has_d = r->has_tr = r->has_map = false;
    return true;
}

static const struct {
    const char *word;
    statement_function *read;
} statements[] = {
    {"newmtl", read_newmtl},
    {"Ka", read_ka},
    {"Kd", read_kd},
    {"Ks", read_ks},
    {"Ke", read_ke},
    {"Kt", read_tf},
    {"Tf", read_tf},
    {"Ns", read_ns},
    {"Ni", read_ni},
    {"d", read_d},
    {"Tr", read_tr},
    {"map_Kd", read_map_kd},
    {"illum", read_illum},
    {"Pr", read_pr},
    {"Pm", read_pm},
    {"tint_distance", read_tint_distance},
    {"medium_priority", read_priority},
};

/* Known and not drawn. */
static const char *const quiet_statements[] = {
    "map_Tr", "disp",   "map_disp", "decal",   "map_aat",   "Ps",      "Pc",      "Pcr",       "aniso",
    "anisor", "map_Ps", "map_Pc",   "map_Pcr", "map_aniso", "map_RMA", "map_ORM", "sharpness",
};

static bool is_skipped_quietly(const char *word, size_t length)
{
    for (size_t i = 0; i < DAFT_COUNT_OF(quiet_statements); i++)
        if (is_word(word, length, quiet_statements[i])) return true;
    return false;
}

/* Reads the statement at *cursor and moves it to the end of its line. */
static bool read_statement(reader *r, const char **cursor)
{
    const char *word = *cursor, *p = daft_skip_token(&r->text, word);
    size_t length = (size_t)(p - word);
    *cursor = daft_skip_statement(&r->text, p);
    for (size_t i = 0; i < DAFT_COUNT_OF(statements); i++) {
        if (!is_word(word, length, statements[i].word)) continue;
        if (!r->current && statements[i].read != read_newmtl)
            return daft_text_fail(&r->text, word, r->error, "'%s' before the first newmtl",
                                  daft_text_quote(word, length).text);
        return statements[i].read(r, word, daft_skip_blanks(p));
    }
    for (size_t i = 0; i < DAFT_COUNT_OF(other_maps); i++) {
        if (!is_word(word, length, other_maps[i].word)) continue;
        if (!r->current)
            return daft_text_fail(&r->text, word, r->error, "'%s' before the first newmtl",
                                  daft_text_quote(word, length).text);
        return read_other_map(r, word, daft_skip_blanks(p));
    }
    if (is_skipped_quietly(word, length)) {
        r->any_known = true;
        if (r->text.log && r->text.log->checks) daft_text_warn_not_drawn(&r->text, word, length);
        return true;
    }
    if (!r->first_unknown) r->first_unknown = word;
    daft_text_warn_unknown(&r->text, word, length, "statement");
    return true;
}

/* A line that cannot be read is left out. False: memory is out. */
static bool read_guarded(reader *r, const char **cursor)
{
    daft_error why;
    r->error = daft_text_is_told(&r->text) ? &why : NULL;
    if (!read_statement(r, cursor) && !r->out_of_memory) daft_text_lose(&r->text, &why);
    return !r->out_of_memory;
}

static bool read_lines(reader *r)
{
    for (const char *p = r->text.begin; p < r->text.end;) {
        if (daft_is_break(*p))
            p++;
        else if (*p == '#')
            p = daft_skip_comment(&r->text, p);
        else if (daft_is_blank(*p) || (*p == '\\' && daft_is_break(p[1])))
            p = daft_skip_blanks(p);
        else if (!read_guarded(r, &p))
            return false;
    }
    return true;
}

/* Exporters write files with nothing but comments for scenes without materials. */
static bool check_content(reader *r, size_t before)
{
    if (r->list->count > before) return true;
    if (r->first_unknown && !r->any_known)
        return daft_text_fail(&r->text, r->first_unknown, r->error, "not an MTL file: nothing in it is known");
    const char *p = r->text.begin;
    while (p < r->text.end && (daft_is_blank(*p) || daft_is_break(*p))) p++;
    if (p == r->text.end)
        return daft_fail_at(r->error, DAFT_ERROR_SYNTAX, r->text.path, 0, 0, "the file is empty, not an MTL file");
    daft_text_warn(&r->text, p, "the file defines no material");
    return true;
}

bool daft_mtl_parse(const daft_allocator *allocator, const daft_files *files, const char *path, const char *text,
                    size_t size, const daft_log *log, daft_mtl_list *list, daft_error *error)
{
    size_t before = list->count;
    reader r = {.text = daft_text_open(path, text, size, log), .allocator = allocator, .files = files, .list = list};
    if (!daft_text_check_encoding(&r.text, error)) return false;
    bool done = read_lines(&r) || daft_fail_at(error, DAFT_ERROR_MEMORY, path, 0, 0, "out of memory for the materials");
    r.error = error;
    if (done) close_cube(&r);
    done = done && check_content(&r, before);
    if (done)
        daft_text_close(&r.text);
    else
        list->count = before;
    return done;
}

bool daft_mtl_load(const daft_allocator *allocator, const daft_files *files, const char *path, const daft_log *log,
                   daft_mtl_list *list, daft_error *error)
{
    size_t size;
    char *text = daft_file_read(allocator, files, path, &size, error);
    if (!text) return false;
    bool done = daft_mtl_parse(allocator, files, path, text, size, log, list, error);
    daft_release(allocator, text);
    return done;
}
