/* Maps of MTL files: the options of a map and the name of its file, which may stand in front of its options, have
 * blanks and quotes, or be a path of the machine that wrote the file. */
#include "geometry/formats/mtl_map.h"

#include <math.h>
#include <strings.h>

typedef enum option_kind {
    OPTION_IGNORED,
    OPTION_CLAMP,
    OPTION_CHANNEL,
    OPTION_BUMP,
    OPTION_RESOLUTION,
    OPTION_RANGE,
    OPTION_OFFSET,
    OPTION_SCALE,
    OPTION_TYPE
} option_kind;

typedef struct map_option {
    const char *name;
    int least, most; /* numbers; 0, 0: one word */
    option_kind kind;
} map_option;

static const map_option map_options[] = {
    {"-blendu", 0, 0, OPTION_IGNORED},
    {"-blendv", 0, 0, OPTION_IGNORED},
    {"-cc", 0, 0, OPTION_IGNORED},
    {"-clamp", 0, 0, OPTION_CLAMP},
    {"-imfchan", 0, 0, OPTION_CHANNEL},
    {"-type", 0, 0, OPTION_TYPE},
    {"-colorspace", 0, 0, OPTION_IGNORED},
    {"-boost", 1, 1, OPTION_IGNORED},
    {"-bm", 1, 1, OPTION_BUMP},
    {"-texres", 1, 1, OPTION_RESOLUTION},
    {"-mm", 1, 2, OPTION_RANGE},
    {"-o", 1, 3, OPTION_OFFSET},
    {"-s", 1, 3, OPTION_SCALE},
    {"-t", 1, 3, OPTION_IGNORED},
};

static const map_option *find_option(const char *at, size_t length)
{
    for (size_t i = 0; i < DAFT_COUNT_OF(map_options); i++)
        if (daft_word_is(at, length, map_options[i].name)) return &map_options[i];
    return NULL;
}

/* Reads up to `most` numbers; returns how many there were. The first token that is none may be the file's name. */
static int read_numbers(const daft_text *text, const char **cursor, int most, double out[3])
{
    int count = 0;
    while (count < most) {
        const char *p = *cursor;
        if (!daft_scan_number(&p, text->end, &out[count]) || !daft_token_ends(text, p)) break;
        *cursor = daft_skip_blanks(p);
        count++;
    }
    return count;
}

static float finite_or(double value, float other) { return isfinite((float)value) ? (float)value : other; }

const char *const daft_mtl_cube_sides[6] = {"cube_right",  "cube_left",  "cube_top",
                                            "cube_bottom", "cube_front", "cube_back"};

static int side_of(const char *word)
{
    for (int i = 0; i < 6; i++)
        if (strncasecmp(word, daft_mtl_cube_sides[i], strlen(daft_mtl_cube_sides[i])) == 0) return i + 1;
    return strncasecmp(word, "cube", 4) == 0 ? -1 : 0;
}

/* Missing numbers of -s are 1, of -o 0; the third is for solid textures. */
static void apply_option(option_kind kind, const double n[3], int count, const char *word, daft_mtl_settings *out)
{
    switch (kind) {
    case OPTION_CLAMP: out->clamps = out->places = daft_word_is(word, 2, "on"); break;
    case OPTION_CHANNEL: out->change.channel = strchr("rgbmlz", *word) ? *word : 0; break;
    case OPTION_BUMP: out->bump = finite_or(n[0], 1); break;
    case OPTION_RESOLUTION: out->change.most = n[0] >= 1 && n[0] <= 16384 ? (int)n[0] : 0; break;
    case OPTION_RANGE:
        out->change.base = finite_or(n[0], 0);
        if (count > 1) out->change.gain = finite_or(n[1], 1);
        break;
    case OPTION_OFFSET:
        out->offset = (daft_vec2){finite_or(n[0], 0), count > 1 ? finite_or(n[1], 0) : 0};
        out->places = true;
        break;
    case OPTION_SCALE:
        out->scale = (daft_vec2){finite_or(n[0], 1), count > 1 ? finite_or(n[1], 1) : 1};
        out->places = true;
        break;
    case OPTION_TYPE: out->side = side_of(word); break;
    case OPTION_IGNORED: break;
    }
}

/* Reads options from *cursor on. Returns false, with *cursor at the place, where one lacks its argument. */
static bool read_options(daft_text *text, const char **cursor, bool quiet, daft_mtl_settings *out)
{
    while (**cursor == '-' && !daft_token_ends(text, *cursor + 1)) {
        const char *start = *cursor, *p = daft_skip_token(text, start);
        const map_option *option = find_option(start, (size_t)(p - start));
        if (!option && quiet) return true;
        if (!option) daft_text_warn_unknown(text, start, (size_t)(p - start), "map option");
        p = daft_skip_blanks(p);
        double numbers[3] = {0, 0, 0};
        const char *first = p;
        int count = read_numbers(text, &p, option ? option->most : 3, numbers);
        bool word = option && option->most == 0;
        if ((option && count < option->least) || (word && daft_at_end(text, p))) {
            *cursor = p;
            return false;
        }
        if (word) p = daft_skip_blanks(daft_skip_token(text, p));
        if (option) apply_option(option->kind, numbers, count, first, out);
        *cursor = p;
    }
    return true;
}

/* Some write options behind the name: it ends before a blank and options that fill the rest of the line. */
static size_t name_length(daft_text *text, const char *name, size_t length, daft_mtl_settings *settings)
{
    if (length > 4096) return length; /* too long for a name anyway, and the search below is quadratic */
    for (size_t i = 1; i + 1 < length; i++) {
        const char *p = name + i + 1;
        if (!daft_is_blank(name[i]) || *p != '-') continue;
        daft_mtl_settings behind = *settings;
        if (read_options(text, &p, true, &behind) && p >= name + length) {
            *settings = behind;
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
static bool resolve_map(const daft_text *text, const daft_files *files, const char *name, char *out, size_t size)
{
    if (!daft_path_beside(text->path, name, out, size)) return false;
    const char *slash = strrchr(name, '/');
    if (!slash || daft_file_exists(files, out)) return true;
    char other[sizeof((daft_mtl_map *)0)->path];
    if (daft_path_beside(text->path, slash + 1, other, sizeof other) && daft_file_exists(files, other))
        memcpy(out, other, size < sizeof other ? size : sizeof other);
    return true;
}

bool daft_mtl_map_read(daft_text *text, const daft_files *files, const char *word, const char *p,
                       daft_mtl_settings *settings, daft_mtl_map *out, daft_error *error)
{
    *settings = (daft_mtl_settings){.change = {.gain = 1}, .scale = {1, 1}, .bump = 1};
    if (!read_options(text, &p, false, settings))
        return daft_text_fail(text, p, error, "the map option before this lacks its value");
    size_t length;
    const char *at = daft_rest_of_line(text, p, &length);
    if (length == 0) return daft_text_fail(text, word, error, "the map has no file name");
    length = name_length(text, at, length, settings);
    char name[sizeof out->path], path[sizeof name];
    if (!copy_name(at, length, name, sizeof name) || !resolve_map(text, files, name, path, sizeof path))
        return daft_text_fail(text, at, error, "'%s' cannot be a file name", daft_text_quote(at, length).text);
    memcpy(out->path, path, sizeof path);
    out->change = settings->change;
    daft_text_place(text, at, &out->line, &out->column);
    return true;
}
