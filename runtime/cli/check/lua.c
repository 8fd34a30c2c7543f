/* Static checks of a script: syntax, the modules it requires, and the files its strings name.
 *
 * A string names a file by its extension ("meshes/cup.obj") or by the field it is assigned to (mesh = "cup.obj",
 * texture = "brick"). Strings joined with .. or holding a % are skipped. */
#include "cli/check/names.h"

#include "common/util.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>

#include <lauxlib.h>

/* ---- syntax ---- */

/* Splits Lua's "x:LINE: message"; line 0 when there is none. */
static const char *split_message(const char *message, int *line)
{
    char *end;
    *line = 0;
    if (strncmp(message, "x:", 2) != 0) return message;
    long number = strtol(message + 2, &end, 10);
    if (end == message + 2 || *end != ':') return message;
    *line = (int)number;
    return end + 1 + (end[1] == ' ');
}

static void check_syntax(checker *c, const char *path, const char *text, size_t size)
{
    lua_State *L = luaL_newstate();
    if (!L) {
        check_add(c, DAFT_SEVERITY_ERROR, path, 0, 0, "out of memory");
        return;
    }
    size_t mark = size >= 3 && memcmp(text, "\xEF\xBB\xBF", 3) == 0 ? 3 : 0;
    if (luaL_loadbufferx(L, text + mark, size - mark, "@x", "t") != LUA_OK) {
        const char *message = lua_tostring(L, -1);
        int line;
        message = split_message(message ? message : "syntax error", &line);
        check_add(c, DAFT_SEVERITY_ERROR, path, line, 0, "%s", message);
    } else if (c->names) {
        names_take(c->names, L, path, false);
    }
    lua_close(L);
}

/* ---- tokens ---- */

typedef enum token_kind { TOKEN_END, TOKEN_WORD, TOKEN_STRING, TOKEN_OTHER, TOKEN_JOIN } token_kind;

typedef struct token {
    token_kind kind;
    const char *at; /* without the quotes */
    size_t length;
    int line, column;
} token;

typedef struct scanner {
    const char *at, *end, *line_start;
    int line;
} scanner;

static void step(scanner *s)
{
    if (*s->at++ == '\n') {
        s->line++;
        s->line_start = s->at;
    }
}

/* Skips [[…]] or [==[…]==]. False, reading nothing, when none begins here. */
static bool skip_long_bracket(scanner *s)
{
    const char *p = s->at + 1;
    while (p < s->end && *p == '=') p++;
    if (*s->at != '[' || p >= s->end || *p != '[') return false;
    size_t level = (size_t)(p - s->at) - 1;
    while (s->at < s->end) {
        bool closes = *s->at == ']' && (size_t)(s->end - s->at) > level + 1 && s->at[level + 1] == ']' &&
                      strspn(s->at + 1, "=") == level;
        if (closes) {
            s->at += level + 2;
            return true;
        }
        step(s);
    }
    return true;
}

static void skip_blanks_and_comments(scanner *s)
{
    while (s->at < s->end) {
        if (isspace((unsigned char)*s->at)) {
            step(s);
        } else if (s->at[0] == '-' && s->at[1] == '-') {
            s->at += 2;
            if (s->at < s->end && *s->at == '[' && skip_long_bracket(s)) continue;
            while (s->at < s->end && *s->at != '\n') s->at++;
        } else {
            return;
        }
    }
}

static token read_string(scanner *s, token out)
{
    char quote = *s->at++;
    out.kind = TOKEN_STRING;
    out.at = s->at;
    while (s->at < s->end && *s->at != quote && *s->at != '\n') {
        if (*s->at == '\\' && s->at + 1 < s->end) s->at++;
        step(s);
    }
    out.length = (size_t)(s->at - out.at);
    if (s->at < s->end && *s->at == quote) s->at++;
    return out;
}

static token next_token(scanner *s)
{
    skip_blanks_and_comments(s);
    token out = {.at = s->at, .line = s->line, .column = (int)(s->at - s->line_start) + 1};
    if (s->at == s->end) return out;
    if (*s->at == '"' || *s->at == '\'') return read_string(s, out);
    if (*s->at == '[' && skip_long_bracket(s)) {
        out.kind = TOKEN_OTHER;
    } else if (isalnum((unsigned char)*s->at) || *s->at == '_') {
        while (s->at < s->end && (isalnum((unsigned char)*s->at) || *s->at == '_')) s->at++;
        out.kind = TOKEN_WORD;
    } else {
        out.kind = s->at[0] == '.' && s->at[1] == '.' ? TOKEN_JOIN : TOKEN_OTHER;
        s->at += out.kind == TOKEN_JOIN ? 2 : 1;
    }
    out.length = (size_t)(s->at - out.at);
    return out;
}

/* ---- files that strings name ---- */

typedef struct script {
    checker *check;
    const char *path, *folder;
    const char *text;
} script;

static bool is_word(token word, const char *text)
{
    return word.length == strlen(text) && memcmp(word.at, text, word.length) == 0;
}

static bool exists_in(const script *s, const char *folder, const char *sub, const char *name, const char *extension)
{
    char inner[PATH_SIZE], path[PATH_SIZE];
    int written = snprintf(inner, sizeof inner, "%s%s%s", sub, name, extension);
    if (written <= 0 || (size_t)written >= sizeof inner) return false;
    if (s->check->game.files) return daft_files_find(s->check->game.files, inner, path, sizeof path);
    return path_join(path, sizeof path, folder, inner) && path_is_file(path);
}

/* Searches as the Lua API does: the game's folder, then assets/; in each also meshes/ and textures/. */
static bool asset_exists(const script *s, const char *name)
{
    static const char *const subs[] = {"", "meshes/", "textures/"};
    static const char *const extensions[] = {"", ".png", ".jpg", ".jpeg", ".tga", ".bmp"};
    const char *folders[] = {s->folder, s->check->has_home ? s->check->where.assets : s->folder};
    for (size_t f = 0; f < COUNT_OF(folders); f++)
        for (size_t i = 0; i < COUNT_OF(subs); i++)
            for (size_t k = 0; k < COUNT_OF(extensions); k++)
                if (exists_in(s, folders[f], subs[i], name, extensions[k])) return true;
    return false;
}

static bool looks_like_asset(const char *name)
{
    static const char *const extensions[] = {".obj", ".mtl", ".gltf", ".glb", ".fbx", ".dae", ".ply", ".stl", ".scene",
                                             ".png", ".jpg", ".jpeg", ".tga", ".bmp", ".hdr", ".gif", ".psd"};
    for (size_t i = 0; i < COUNT_OF(extensions); i++)
        if (has_extension(name, extensions[i])) return true;
    return false;
}

/* False when it is empty, too long, or holds a zero byte. */
static bool copy_text(token string, char *out, size_t size)
{
    if (string.length == 0 || string.length >= size || memchr(string.at, 0, string.length)) return false;
    memcpy(out, string.at, string.length);
    out[string.length] = 0;
    return true;
}

static void check_asset(const script *s, token string, bool is_field)
{
    char name[PATH_SIZE / 2];
    if (!copy_text(string, name, sizeof name) || strpbrk(name, "\\%*")) return;
    name[strcspn(name, "#")] = 0; /* file.mtl#name, and #rrggbb */
    if (!name[0]) return;
    if ((!is_field && !looks_like_asset(name)) || asset_exists(s, name)) return;
    check_add(s->check, is_field ? DAFT_SEVERITY_ERROR : DAFT_SEVERITY_WARNING, s->path, string.line, string.column,
              "there is no file '%s', neither in the game's folder nor in assets/", name);
}

static void check_module(const script *s, token string)
{
    char name[256];
    if (!copy_text(string, name, sizeof name)) return;
    for (char *p = name; *p; p++)
        if (*p == '.') *p = '/';
    if (exists_in(s, s->folder, "", name, ".lua")) return;
    if (s->check->has_home && exists_in(s, s->check->where.scripts, "", name, ".lua")) return;
    check_add(s->check, DAFT_SEVERITY_ERROR, s->path, string.line, string.column,
              "there is no module '%s.lua', neither in the game's folder nor in scripts/", name);
}

/* Checks a string given the three tokens before it, nearest last, and the one after it. */
static void check_string(const script *s, const token before[3], token string, token after)
{
    if (before[2].kind == TOKEN_JOIN || after.kind == TOKEN_JOIN) return;
    bool called = before[2].kind == TOKEN_WORD || (is_word(before[2], "(") && before[1].kind == TOKEN_WORD);
    token name = before[2].kind == TOKEN_WORD ? before[2] : before[1];
    if (called && is_word(name, "require")) {
        check_module(s, string);
        return;
    }
    bool assigned = is_word(before[2], "=") && (is_word(before[1], "mesh") || is_word(before[1], "texture"));
    /* local texture = "..." is any value; { texture = "..." } and material.texture = "..." are fields */
    check_asset(s, string, assigned && !is_word(before[0], "local"));
}

static void check_strings(const script *s, size_t size)
{
    scanner scan = {s->text, s->text + size, s->text, 1};
    token before[3] = {0}, now = next_token(&scan);
    while (now.kind != TOKEN_END) {
        token after = next_token(&scan);
        if (now.kind == TOKEN_STRING) check_string(s, before, now, after);
        before[0] = before[1], before[1] = before[2], before[2] = now;
        now = after;
    }
}

void check_lua(checker *c, const char *path, const char *folder)
{
    daft_error error;
    size_t size;
    char *text = daft_read_file(c->game.files, path, &size, &error);
    if (!text) {
        check_problem(c, DAFT_SEVERITY_ERROR, &error);
        return;
    }
    size_t before = c->errors;
    check_syntax(c, path, text, size);
    script s = {c, path, folder, text};
    if (c->errors == before) check_strings(&s, size);
    free(text);
}

void check_library(checker *c, const char *path)
{
    size_t size;
    char *text = daft_read_file(c->game.files, path, &size, NULL);
    lua_State *L = text ? luaL_newstate() : NULL;
    if (L && luaL_loadbufferx(L, text, size, "@x", "t") == LUA_OK) names_take(c->names, L, path, true);
    if (L) lua_close(L);
    free(text);
}
