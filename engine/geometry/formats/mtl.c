/* MTL files: materials of the Phong kind. Errors, with line and column: a number that is none, is not finite, or is
 * missing; newmtl or a map without a name; a property before the first newmtl; an empty file. Values out of range are
 * cut with a warning. Statements that describe what the engine does not draw (roughness, bump maps, ...) are skipped
 * quietly, unknown ones with one warning each. Keywords are read whatever their case. */
#include "geometry/mesh.h"
#include "geometry/formats/text.h"

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
    daft_mtl *current;               /* NULL before the first newmtl, and after one that is left out */
    bool has_ambient, has_d, has_tr; /* in the current material */
    float tr;
    const char *first_unknown;
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
                      .filter = {1, 1, 1},
                      .illum = 2};
}

void daft_mtl_list_free(const daft_allocator *allocator, daft_mtl_list *list)
{
    for (size_t i = 0; i < list->count; i++) daft_release(allocator, list->items[i].map_bytes);
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
    return true;
}

static bool read_illum(reader *r, const char *word, const char *p)
{
    float value;
    if (!read_last_number(r, word, p, &value)) return false;
    r->current->illum = (int)clamp(r, word, value, 0, 10);
    return true;
}

/* ---- maps ---- */

typedef struct map_option {
    const char *name;
    int least, most; /* numbers; 0, 0: one word */
    bool changes_picture;
} map_option;

static const map_option map_options[] = {
    {"-blendu", 0, 0, false},  {"-blendv", 0, 0, false}, {"-cc", 0, 0, false},         {"-clamp", 0, 0, false},
    {"-imfchan", 0, 0, false}, {"-type", 0, 0, false},   {"-colorspace", 0, 0, false}, {"-boost", 1, 1, false},
    {"-bm", 1, 1, false},      {"-texres", 1, 1, false}, {"-mm", 1, 2, true},          {"-o", 1, 3, true},
    {"-s", 1, 3, true},        {"-t", 1, 3, true},
};

static const map_option *find_option(const char *at, size_t length)
{
    for (size_t i = 0; i < DAFT_COUNT_OF(map_options); i++)
        if (daft_word_is(at, length, map_options[i].name)) return &map_options[i];
    return NULL;
}

/* Skips up to `most` numbers; returns how many there were. The first token that is none may be the file's name. */
static int skip_numbers(const reader *r, const char **cursor, int most)
{
    int count = 0;
    double ignored;
    while (count < most) {
        const char *p = *cursor;
        if (!daft_scan_number(&p, r->text.end, &ignored) || !daft_token_ends(&r->text, p)) break;
        *cursor = daft_skip_blanks(p);
        count++;
    }
    return count;
}

/* Skips options from *cursor on. Returns false, with *cursor at the place, where one lacks its argument. */
static bool skip_options(reader *r, const char **cursor, bool quiet, bool *changes_picture)
{
    while (**cursor == '-' && !daft_token_ends(&r->text, *cursor + 1)) {
        const char *start = *cursor, *p = daft_skip_token(&r->text, start);
        const map_option *option = find_option(start, (size_t)(p - start));
        if (!option && quiet) return true;
        if (!option) daft_text_warn_unknown(&r->text, start, (size_t)(p - start), "map option");
        p = daft_skip_blanks(p);
        int numbers = skip_numbers(r, &p, option ? option->most : 3);
        bool word = option && option->most == 0;
        if ((option && numbers < option->least) || (word && daft_at_end(&r->text, p))) {
            *cursor = p;
            return false;
        }
        if (word) p = daft_skip_blanks(daft_skip_token(&r->text, p));
        if (option && option->changes_picture) *changes_picture = true;
        *cursor = p;
    }
    return true;
}

/* Some write options behind the name: it ends before a blank and options that fill the rest of the line. */
static size_t name_length(reader *r, const char *name, size_t length)
{
    bool ignored;
    if (length > 4096) return length; /* too long for a name anyway, and the search below is quadratic */
    for (size_t i = 1; i + 1 < length; i++) {
        const char *p = name + i + 1;
        if (!daft_is_blank(name[i]) || *p != '-') continue;
        if (skip_options(r, &p, true, &ignored) && p >= name + length) {
            while (i > 0 && daft_is_blank(name[i - 1])) i--;
            return i;
        }
    }
    return length;
}

/* The name as a path: without quotes, with slashes. False if it does not fit. */
static bool copy_name(const char *name, size_t length, char *out, size_t size)
{
    if (length >= 2 && name[0] == '"' && name[length - 1] == '"') name++, length -= 2;
    if (length == 0 || length >= size || memchr(name, 0, length)) return false;
    for (size_t i = 0; i < length; i++) out[i] = name[i] == '\\' ? '/' : name[i];
    out[length] = 0;
    return true;
}

/* Beside the MTL file. Paths of the machine that wrote the file are replaced by their last part, if that exists. */
static bool resolve_map(const reader *r, const char *name, char *out, size_t size)
{
    if (!daft_path_beside(r->text.path, name, out, size)) return false;
    const char *slash = strrchr(name, '/');
    if (!slash || daft_file_exists(r->files, out)) return true;
    char other[sizeof r->current->diffuse_map];
    if (daft_path_beside(r->text.path, slash + 1, other, sizeof other) && daft_file_exists(r->files, other))
        memcpy(out, other, size < sizeof other ? size : sizeof other);
    return true;
}

static bool read_map_kd(reader *r, const char *word, const char *p)
{
    bool changes_picture = false;
    if (!skip_options(r, &p, false, &changes_picture))
        return daft_text_fail(&r->text, p, r->error, "the map option before this lacks its value");
    size_t length;
    const char *at = daft_rest_of_line(&r->text, p, &length);
    if (length == 0) return daft_text_fail(&r->text, word, r->error, "the map has no file name");
    length = name_length(r, at, length);
    char name[sizeof r->current->diffuse_map], path[sizeof name];
    if (!copy_name(at, length, name, sizeof name) || !resolve_map(r, name, path, sizeof path))
        return daft_text_fail(&r->text, at, r->error, "'%s' cannot be a file name", daft_text_quote(at, length).text);
    if (changes_picture) daft_text_warn(&r->text, word, "the map's offset, scale or gain is not used");
    memcpy(r->current->diffuse_map, path, sizeof path);
    daft_text_place(&r->text, at, &r->current->diffuse_map_line, &r->current->diffuse_map_column);
    return true;
}

/* ---- statements ---- */

static bool read_newmtl(reader *r, const char *word, const char *p)
{
    size_t length;
    const char *name = daft_rest_of_line(&r->text, p, &length);
    daft_mtl material = daft_mtl_default();
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
    r->has_ambient = r->has_d = r->has_tr = false;
    return true;
}

static const struct {
    const char *word;
    statement_function *read;
} statements[] = {
    {"newmtl", read_newmtl}, {"Ka", read_ka},         {"Kd", read_kd},       {"Ks", read_ks}, {"Ke", read_ke},
    {"Kt", read_tf},         {"Tf", read_tf},         {"Ns", read_ns},       {"Ni", read_ni}, {"d", read_d},
    {"Tr", read_tr},         {"map_Kd", read_map_kd}, {"illum", read_illum}, {"Pr", read_pr},
};

/* Known and not used. */
static const char *const quiet_statements[] = {
    "map_Ka",  "map_Ks",   "map_Ke", "map_Ns",  "map_d",     "map_Tr",  "map_bump", "bump",
    "disp",    "map_disp", "decal",  "refl",    "map_refl",  "norm",    "map_norm", "map_Kn",
    "map_aat", "Pm",       "Ps",     "Pc",      "Pcr",       "aniso",   "anisor",   "map_Pr",
    "map_Pm",  "map_Ps",   "map_Pc", "map_Pcr", "map_aniso", "map_RMA", "map_ORM",  "sharpness",
};

static bool is_word(const char *word, size_t length, const char *keyword)
{
    return strlen(keyword) == length && strncasecmp(keyword, word, length) == 0;
}

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
    if (is_skipped_quietly(word, length)) {
        r->any_known = true;
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
