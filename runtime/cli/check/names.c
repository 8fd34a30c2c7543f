/* Puts together what the scripts of a game use, and reports what nothing has. */
#include "cli/check/names.h"

#include "cli/check/listing.h"
#include "common/util.h"
#include "lua/fields.h"

#include <stdlib.h>
#include <string.h>

typedef struct use {
    listing_kind kind;
    char *path, *name;
    const char *file; /* one of names.files */
    int line;
} use;

typedef struct text_list {
    char **texts;
    size_t count, capacity;
} text_list;

struct names {
    use *uses;
    size_t count, capacity;
    text_list files, globals, fields; /* globals that are set; fields that any table is given */
    const char *file;                 /* that is being read */
    bool ours, has_globals;
};

/* ---- keeping ---- */

static bool grow(void *items, size_t *capacity, size_t count, size_t size)
{
    if (count < *capacity) return true;
    const size_t more = *capacity ? 2 * *capacity : 64;
    void *grown = realloc(*(void **)items, more * size);
    if (!grown) return false;
    *(void **)items = grown, *capacity = more;
    return true;
}

static const char *add_text(text_list *list, const char *text)
{
    char *copy = grow(&list->texts, &list->capacity, list->count, sizeof *list->texts) ? strdup(text) : NULL;
    if (copy) list->texts[list->count++] = copy;
    return copy;
}

static bool has_text(const text_list *list, const char *text)
{
    for (size_t i = 0; i < list->count; i++)
        if (strcmp(list->texts[i], text) == 0) return true;
    return false;
}

static void free_texts(text_list *list)
{
    for (size_t i = 0; i < list->count; i++) free(list->texts[i]);
    free(list->texts);
}

names *names_create(void) { return calloc(1, sizeof(names)); }

void names_destroy(names *all)
{
    if (!all) return;
    for (size_t i = 0; i < all->count; i++) free(all->uses[i].path), free(all->uses[i].name);
    free(all->uses);
    free_texts(&all->files);
    free_texts(&all->globals);
    free_texts(&all->fields);
    free(all);
}

/* A listing_callback. Where memory runs out a name is not looked at. */
static void take_use(void *user, listing_kind kind, const char *path, const char *name, int line)
{
    names *all = user;
    const bool sets_global = kind == LISTING_SET && !strchr(path, '.');
    if (sets_global && !has_text(&all->globals, name)) add_text(&all->globals, name);
    if ((kind == LISTING_FIELD || kind == LISTING_SET) && !has_text(&all->fields, name)) add_text(&all->fields, name);
    if (all->ours || kind == LISTING_FIELD || sets_global || !all->file) return;
    if (!grow(&all->uses, &all->capacity, all->count, sizeof *all->uses)) return;
    use *u = &all->uses[all->count];
    *u = (use){kind, strdup(path), strdup(name), all->file, line};
    if (u->path && u->name)
        all->count++;
    else
        free(u->path), free(u->name);
}

void names_take(names *all, lua_State *L, const char *path, bool ours)
{
    all->ours = ours;
    all->file = add_text(&all->files, path);
    listing_read(L, take_use, all);
}

void names_take_globals(names *all, lua_State *L)
{
    all->has_globals = true;
    lua_pushglobaltable(L);
    for (lua_pushnil(L); lua_next(L, -2); lua_pop(L, 1))
        if (lua_type(L, -2) == LUA_TSTRING) add_text(&all->globals, lua_tostring(L, -2));
    lua_pop(L, 1);
}

/* ---- what the API has ---- */

enum { MOST = 512 };

typedef struct known {
    const char *names[MOST];
    size_t count;
} known;

static void add_known(known *list, const char *name)
{
    if (list->count < MOST) list->names[list->count++] = name;
}

/* Whether the table daft.TABLE ("" is daft itself) has the field; `near` gets all that it has. A field's name may go on
 * after a dot, so names are compared up to it. */
static bool api_has(const char *table, const char *field, known *near, char (*parts)[48])
{
    size_t areas, length = strlen(table), callbacks;
    const api_area *const *all = api_areas(&areas);
    const char *const *called = api_callbacks(&callbacks);
    bool found = false;
    for (size_t area = 0; area < areas; area++)
        for (size_t i = 0; i < all[area]->count; i++) {
            const char *name = all[area]->functions[i].name;
            if (strchr(name, ':') || strncmp(name, table, length) != 0 || (length && name[length] != '.')) continue;
            char *part = parts[near->count < MOST ? near->count : MOST - 1];
            snprintf(part, 48, "%.*s", (int)strcspn(name + length + (length > 0), "."), name + length + (length > 0));
            found |= strcmp(part, field) == 0;
            add_known(near, part);
        }
    for (size_t i = 0; i < callbacks && !length; i++) {
        found |= strcmp(called[i], field) == 0;
        add_known(near, called[i]);
    }
    return found;
}

static bool is_table_of_api(const char *path)
{
    size_t areas, length = strlen(path);
    const api_area *const *all = api_areas(&areas);
    if (!length) return true;
    for (size_t area = 0; area < areas; area++)
        for (size_t i = 0; i < all[area]->count; i++)
            if (strncmp(all[area]->functions[i].name, path, length) == 0 && all[area]->functions[i].name[length] == '.')
                return true;
    return false;
}

static void add_methods(known *list)
{
    size_t areas;
    const api_area *const *all = api_areas(&areas);
    for (size_t area = 0; area < areas; area++)
        for (size_t i = 0; i < all[area]->count; i++) {
            const char *colon = strchr(all[area]->functions[i].name, ':');
            if (colon) add_known(list, colon + 1);
        }
}

static void add_field(void *user, const char *name, const char *value, const char *initial, const char *doc)
{
    (void)value, (void)initial, (void)doc;
    add_known(user, name);
}

/* The fields of the table that daft.FUNCTION takes; none where it is no form's. */
static void add_options(known *list, const char *function)
{
    size_t count;
    const api_form *const *forms = api_forms(&count);
    for (size_t i = 0; i < count; i++)
        if (strcmp(forms[i]->function, function) == 0 && strcmp(forms[i]->title, "collider") != 0)
            api_describe_form(forms[i], add_field, list);
}

static bool is_known(const known *list, const char *name)
{
    for (size_t i = 0; i < list->count; i++)
        if (strcmp(list->names[i], name) == 0) return true;
    return false;
}

/* ---- the report ---- */

static void report_global(const names *all, checker *c, const use *u)
{
    char hint[HINT_SIZE];
    if (!all->has_globals || has_text(&all->globals, u->name)) return;
    check_add(c, DAFT_SEVERITY_WARNING, u->file, u->line, 0, "nothing sets the global '%s'%s", u->name,
              did_you_mean(hint, "", u->name, (const char *const *)all->globals.texts, all->globals.count));
}

/* "daft.light.sun": the last part is a field of what is before it. */
static void report_field(checker *c, const use *u)
{
    if (strncmp(u->path, "daft.", 5) != 0) return;
    char table[128], hint[HINT_SIZE];
    char(*parts)[48] = calloc(MOST, sizeof *parts);
    known near = {.count = 0};
    const char *last = strrchr(u->path, '.');
    snprintf(table, sizeof table, "%.*s", last > u->path + 4 ? (int)(last - u->path - 5) : 0, u->path + 5);
    if (parts && is_table_of_api(table) && !api_has(table, u->name, &near, parts))
        check_add(c, DAFT_SEVERITY_ERROR, u->file, u->line, 0, "daft%s%s has no '%s'%s", table[0] ? "." : "", table,
                  u->name, did_you_mean(hint, "", u->name, near.names, near.count));
    free(parts);
}

/* Methods of the game's own tables are not known, so only what looks like a slip is told. */
static void report_method(const names *all, checker *c, const use *u)
{
    known methods = {.count = 0};
    add_methods(&methods);
    if (is_known(&methods, u->name) || has_text(&all->fields, u->name) || strncmp(u->path, "daft", 4) == 0) return;
    static const char *const STRINGS[] = {"byte",  "char", "find",     "format", "gmatch",  "gsub", "len",    "lower",
                                          "match", "pack", "packsize", "rep",    "reverse", "sub",  "unpack", "upper"};
    for (size_t i = 0; i < COUNT_OF(STRINGS); i++)
        if (strcmp(STRINGS[i], u->name) == 0) return;
    char hint[HINT_SIZE];
    if (did_you_mean(hint, "", u->name, methods.names, methods.count)[0])
        check_add(c, DAFT_SEVERITY_WARNING, u->file, u->line, 0, "nothing has a method '%s'%s", u->name, hint);
}

static void report_option(checker *c, const use *u)
{
    known fields = {.count = 0};
    char hint[HINT_SIZE];
    if (strncmp(u->path, "daft.", 5) != 0) return;
    add_options(&fields, u->path + 5);
    if (fields.count == 0 || is_known(&fields, u->name)) return;
    check_add(c, DAFT_SEVERITY_ERROR, u->file, u->line, 0, "%s: its table: there is no '%s'%s", u->path, u->name,
              did_you_mean(hint, "", u->name, fields.names, fields.count));
}

void names_report(const names *all, checker *c)
{
    for (size_t i = 0; i < all->count; i++) {
        const use *u = &all->uses[i];
        if (u->kind == LISTING_METHOD)
            report_method(all, c, u);
        else if (u->kind == LISTING_OPTION)
            report_option(c, u);
        else if (strchr(u->path, '.'))
            report_field(c, u);
        else
            report_global(all, c, u);
    }
}
