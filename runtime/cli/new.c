/* daft new: begins a game as a copy of a template, a small game that plays and has tests. */
#include "cli/commands.h"

#include "cli/cli.h"
#include "common/json.h"
#include "common/util.h"
#include "files/home.h"

#include <ctype.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

static const cli_command COMMAND = {
    "new",
    "FOLDER",
    "Begins a game: makes the folder, with a small game that plays, and tests for it.",
    "Templates: empty (a floor, a ball and a camera), first-person (walk and find), marble (roll and collect), "
    "top-down\n"
    "(run and dodge). An editor with the Lua language server completes the functions of DAFT in it.",
    1,
    1};

typedef struct copier {
    daft_files *files; /* the templates */
    const char *title;
    char from[PATH_SIZE], to[PATH_SIZE]; /* the folder that is being copied, among the templates and on the disk */
    bool failed;                         /* *error says why */
    daft_error *error;
} copier;

static bool make_folder(const char *path, daft_error *error)
{
    if (mkdir(path, 0777) == 0) return true;
    return fail_at(error, path, 0, 0, "the folder cannot be made: %s", strerror(errno));
}

/* "red-ball" → "Red ball" */
static void title_of(const char *path, char out[128])
{
    path_base_name(path, out, 128);
    out[0] = (char)toupper((unsigned char)out[0]);
    for (char *at = out; *at; at++)
        if (*at == '-' || *at == '_') *at = ' ';
}

/* main.lua's first line is "-- TITLE: what it is": it gets the game's own title. */
static bool write_main(const char *path, const char *title, const char *text, size_t size, daft_error *error)
{
    const char *colon = memchr(text, ':', size);
    draft_file out;
    if (!draft_open(&out, error)) return false;
    fprintf(out.file, "-- %s", title);
    fwrite(colon, 1, size - (size_t)(colon - text), out.file);
    return draft_commit(&out, path, error);
}

static bool copy_file(const copier *c, const char *from, const char *to)
{
    size_t size;
    char *text = daft_read_file(c->files, from, &size, c->error);
    if (!text) return false;
    const char *name = strrchr(from, '/');
    const bool titled = strcmp(name, "/main.lua") == 0 && strncmp(text, "-- ", 3) == 0 && memchr(text, ':', size);
    bool good = titled ? write_main(to, c->title, text, size, c->error) : daft_write_file(to, text, size, c->error);
    free(text);
    return good;
}

static bool copy_folder(const copier *c, const char *from, const char *to);

/* One name of the folder. What is no file is a folder. */
static void copy_name(void *user, const char *name)
{
    copier *c = user;
    char from[PATH_SIZE], to[PATH_SIZE], found[PATH_SIZE];
    if (c->failed || name[0] == '.') return;
    if (!path_join(from, sizeof from, c->from, name) || !path_join(to, sizeof to, c->to, name))
        c->failed = !fail_at(c->error, c->to, 0, 0, "the path is too long");
    else if (daft_files_find(c->files, from, found, sizeof found))
        c->failed = !copy_file(c, from, to);
    else
        c->failed = !copy_folder(c, from, to);
}

static bool copy_folder(const copier *c, const char *from, const char *to)
{
    copier inner = *c;
    snprintf(inner.from, sizeof inner.from, "%s", from);
    snprintf(inner.to, sizeof inner.to, "%s", to);
    if (!make_folder(to, c->error)) return false;
    if (!daft_files_list(c->files, from, copy_name, &inner) && !inner.failed)
        return fail_at(c->error, from, 0, 0, "the folder cannot be read");
    return !inner.failed;
}

/* Tells the Lua language server where the annotations are. The path is this machine's, so a pack leaves it out. */
static bool write_editor_settings(const char *folder, const home *where, daft_error *error)
{
    char path[PATH_SIZE];
    draft_file out;
    if (!path_join(path, sizeof path, folder, ".luarc.json") || !draft_open(&out, error)) return false;
    fputs("{\n  \"runtime.version\": \"Lua 5.4\",\n  \"workspace.library\": [", out.file);
    json_put_text(out.file, where->scripts);
    fputs("]\n}\n", out.file);
    return draft_commit(&out, path, error);
}

typedef struct template_names {
    char names[16][64];
    const char *pointers[16];
    size_t count;
} template_names;

static void take_name(void *user, const char *name)
{
    template_names *t = user;
    if (name[0] == '.' || t->count == COUNT_OF(t->names)) return;
    snprintf(t->names[t->count], sizeof *t->names, "%s", name);
    t->pointers[t->count] = t->names[t->count], t->count++;
}

static int unknown_template(const daft_files *files, const char *wanted)
{
    template_names known = {.count = 0};
    char hint[HINT_SIZE];
    daft_files_list(files, "", take_name, &known);
    return cli_refuse("new", "--template: there is no template '%s'%s", wanted,
                      did_you_mean(hint, "", wanted, known.pointers, known.count));
}

static int write_game(const home *where, daft_files *files, const char *folder, const char *template)
{
    daft_error error;
    char main_file[PATH_SIZE], found[PATH_SIZE], title[128], shown[PATH_SIZE];
    if (strchr(template, '/') || !path_join(main_file, sizeof main_file, template, "main.lua") ||
        !daft_files_find(files, main_file, found, sizeof found))
        return unknown_template(files, template);
    title_of(folder, title);
    const copier c = {.files = files, .title = title, .error = &error};
    if (!copy_folder(&c, template, folder) || !write_editor_settings(folder, where, &error)) return report(&error);
    daft_escape(folder, shown, sizeof shown);
    printf("%s: a game that plays. What now:\n"
           "  daft play %s         play it; leave the window open while you change main.lua\n"
           "  daft test-game %s    run its tests\n"
           "  daft check %s        look for mistakes in code that has not run\n",
           shown, shown, shown, shown);
    return STATUS_DONE;
}

static int begin(const char *folder, const char *template)
{
    home where;
    daft_error error;
    if (!home_find(&where, &error)) return report(&error);
    const daft_root root = {.folder = where.templates};
    daft_files_def def = daft_default_files_def();
    def.roots = &root, def.root_count = 1;
    daft_files *files = daft_files_create(&def, &error);
    int status = files ? write_game(&where, files, folder, template) : report(&error);
    daft_files_destroy(files);
    return status;
}

int command_new(int argc, char **argv)
{
    const char *template = "empty";
    const cli_option options[] = {
        {"template", 0, CLI_TEXT, "NAME", &template, 0, 0, "empty (default), first-person, marble or top-down"}};
    const char *operands[CLI_OPERANDS];
    size_t count;
    cli_outcome outcome = cli_parse(&COMMAND, options, COUNT_OF(options), argc, argv, operands, &count);
    if (outcome != CLI_READY) return outcome == CLI_HELPED ? STATUS_DONE : STATUS_BAD_USAGE;
    return begin(operands[0], template);
}
