/* daft check: loads each file as the engine would and applies further checks. Folders are walked in alphabetical order;
 * a folder with a main.lua is a game, which also runs for one second. */
#include "cli/check/names.h"

#include "cli/cli.h"
#include "cli/commands.h"
#include "common/util.h"

#include <dirent.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

static const cli_command COMMAND = {
    "check",
    "PATH...",
    "Checks scenes (.scene), meshes (.obj, .gltf, .fbx, ...), materials (.mtl), pictures, scripts (.lua), recordings "
    "(.rec), games, and\n"
    "folders of them.",
    "Prints each problem as 'file:line:column: error|warning|note: text'. A game also runs for one second without a\n"
    "window. Exit status 1 on any error.",
    1,
    CLI_OPERANDS};

static void check_folder(checker *c, const char *folder, const game_info *game);

/* ---- files ---- */

/* NULL: a kind of file that is not checked. */
static const char *extension_of(const char *path)
{
    static const char *const known[] = {".scene", ".obj", ".mtl", ".gltf", ".glb", ".fbx", ".dae",
                                        ".ply",   ".stl", ".lua", ".rec",  ".png", ".jpg", ".jpeg",
                                        ".tga",   ".bmp", ".hdr", ".gif",  ".psd", ".ppm"};
    for (size_t i = 0; i < COUNT_OF(known); i++)
        if (has_extension(path, known[i])) return known[i];
    return NULL;
}

/* Removes the last part of a path; "." when none is left. False at the top. */
static bool to_parent(char *path)
{
    char *slash = strrchr(path, '/');
    if (slash && slash != path) {
        *slash = 0;
        return true;
    }
    bool more = !slash && strcmp(path, ".") != 0;
    if (more) strcpy(path, ".");
    return more;
}

/* A script given by itself belongs to the game whose main.lua is in its folder or above. */
static void folder_of_script(const char *path, char out[PATH_SIZE])
{
    char above[PATH_SIZE], main_file[PATH_SIZE];
    snprintf(above, sizeof above, "%s", path);
    to_parent(above);
    snprintf(out, PATH_SIZE, "%s", above);
    do {
        if (!path_join(main_file, sizeof main_file, above, "main.lua") || !path_is_file(main_file)) continue;
        snprintf(out, PATH_SIZE, "%s", above);
        return;
    } while (to_parent(above));
}

/* For what is known once all files are. Where memory runs out, one is not looked for. */
static void keep_path(checker *c, const char *path)
{
    if (c->own_count == c->own_capacity) {
        size_t more = c->own_capacity ? 2 * c->own_capacity : 64;
        char **grown = realloc(c->own, more * sizeof *grown);
        if (!grown) return;
        c->own = grown, c->own_capacity = more;
    }
    c->own[c->own_count] = strdup(path);
    c->own_count += c->own[c->own_count] != NULL;
}

static bool is_heard(const char *path)
{
    return has_extension(path, ".wav") || has_extension(path, ".ogg") || has_extension(path, ".flac") ||
           has_extension(path, ".mp3");
}

static void check_file(checker *c, const char *path, const game_info *game)
{
    c->path = path;
    c->files++;
    if (has_extension(path, ".lua")) {
        char folder[PATH_SIZE];
        if (!game) folder_of_script(path, folder);
        if (check_need_home(c)) check_lua(c, path, game ? game->folder : folder);
    } else if (has_extension(path, ".rec")) {
        check_recording(c, path, game ? game->name : NULL);
    } else {
        daft_error error;
        if (!daft_check_file(c->engine, path, check_problem, c, &error)) check_problem(c, DAFT_SEVERITY_ERROR, &error);
    }
}

/* ---- folders ---- */

static int is_module(const struct dirent *entry)
{
    return entry->d_name[0] != '.' && has_extension(entry->d_name, ".lua");
}

static void take_library(checker *c)
{
    struct dirent **entries;
    int count = scandir(c->where.scripts, &entries, is_module, alphasort);
    for (int i = 0; i < count; i++) {
        char path[PATH_SIZE];
        if (path_join(path, sizeof path, c->where.scripts, entries[i]->d_name)) check_library(c, path);
        free(entries[i]);
    }
    if (count >= 0) free(entries);
}

/* Once all is read and the game has run: names that nothing has, and files that nothing names. */
static void check_whole(checker *c, const game_info *info)
{
    c->path = info->folder;
    names_report(c->names, c);
    check_unused(c);
    for (size_t i = 0; i < c->own_count; i++) free(c->own[i]);
    free(c->own);
    c->own = NULL, c->own_count = c->own_capacity = 0;
    names_destroy(c->names);
    c->names = NULL;
}

static void check_game(checker *c, const game_info *info)
{
    daft_error error;
    if (!source_open(&c->game, &c->where, info, &error)) {
        check_problem(c, DAFT_SEVERITY_ERROR, &error);
        return;
    }
    daft_engine_set_files(c->engine, c->game.files, NULL);
    c->names = names_create();
    if (c->names) take_library(c);
    check_folder(c, info->folder, info);
    c->path = info->folder;
    check_run_game(c, info);
    if (c->names) check_whole(c, info);
    daft_engine_set_files(c->engine, NULL, NULL);
    source_close(&c->game);
}

static void enter_folder(checker *c, const char *path, const game_info *game)
{
    char main_file[PATH_SIZE];
    game_info inner;
    bool is_game = path_join(main_file, sizeof main_file, path, "main.lua") && path_is_file(main_file);
    if (!game && is_game && check_need_home(c) && home_find_game(&c->where, path, &inner, NULL))
        check_game(c, &inner);
    else
        check_folder(c, path, game);
}

static void check_entry(checker *c, const char *path, const game_info *game)
{
    struct stat info;
    if (lstat(path, &info) != 0) return;
    if (c->names && S_ISREG(info.st_mode) && (extension_of(path) || is_heard(path))) keep_path(c, path);
    if (S_ISDIR(info.st_mode)) /* symbolic links to folders are not followed: they may form cycles */
        enter_folder(c, path, game);
    else if (extension_of(path) && path_is_file(path))
        check_file(c, path, game);
}

static int is_visible(const struct dirent *entry) { return entry->d_name[0] != '.'; }

static void check_folder(checker *c, const char *folder, const game_info *game)
{
    struct dirent **entries;
    int count = scandir(folder, &entries, is_visible, alphasort);
    if (count < 0) {
        check_add(c, DAFT_SEVERITY_ERROR, folder, 0, 0, "cannot read the folder");
        return;
    }
    for (int i = 0; i < count; i++) {
        char path[PATH_SIZE];
        if (path_join(path, sizeof path, folder, entries[i]->d_name))
            check_entry(c, path, game);
        else
            check_add(c, DAFT_SEVERITY_WARNING, folder, 0, 0, "skipped '%.100s': its path is too long",
                      entries[i]->d_name);
        free(entries[i]);
    }
    free(entries);
}

/* ---- the command ---- */

/* A file, a folder, or the name of a game. */
static void check_path(checker *c, const char *path)
{
    c->path = path;
    if (path_is_file(path)) {
        check_file(c, path, NULL);
        return;
    }
    if (path_is_folder(path)) {
        size_t before = c->files;
        enter_folder(c, path, NULL);
        if (c->files == before) check_add(c, DAFT_SEVERITY_NOTE, path, 0, 0, "nothing in the folder can be checked");
        return;
    }
    game_info info;
    daft_error error;
    if (extension_of(path))
        check_add(c, DAFT_SEVERITY_ERROR, path, 0, 0, "there is no such file");
    else if (!check_need_home(c))
        return;
    else if (home_find_game(&c->where, path, &info, &error))
        check_game(c, &info);
    else
        check_problem(c, DAFT_SEVERITY_ERROR, &error);
}

static int check_all(checker *c, const char *const *paths, size_t count, bool strict, const char *json)
{
    daft_error error;
    if (json && !check_json_open(c, &error)) return report(&error);
    daft_engine_def def = daft_default_engine_def();
    def.warn = check_warning;
    def.warn_user = c;
    c->engine = open_engine(&def);
    if (!c->engine) return STATUS_BAD_INPUT;
    for (size_t i = 0; i < count; i++) check_path(c, paths[i]);
    printf("%zu file%s checked: %zu error%s, %zu warning%s\n", c->files, c->files == 1 ? "" : "s", c->errors,
           c->errors == 1 ? "" : "s", c->warnings, c->warnings == 1 ? "" : "s");
    if (!check_json_close(c, json, &error)) return report(&error);
    return c->errors > 0 || (strict && c->warnings > 0) ? STATUS_BAD_INPUT : STATUS_DONE;
}

int command_check(int argc, char **argv)
{
    bool strict = false;
    const char *json = NULL;
    const cli_option options[] = {
        {.name = "strict", .kind = CLI_FLAG, .target = &strict, .help = "exit with status 1 on warnings too"},
        {.name = "json",
         .kind = CLI_TEXT,
         .value = "FILE",
         .target = &json,
         .help = "also write the problems as a list of {file, line, column, severity, text}"}};
    const char *operands[CLI_OPERANDS];
    size_t count;
    cli_outcome outcome = cli_parse(&COMMAND, options, COUNT_OF(options), argc, argv, operands, &count);
    if (outcome != CLI_READY) return outcome == CLI_HELPED ? STATUS_DONE : STATUS_BAD_USAGE;
    checker c = {.path = ""};
    int status = check_all(&c, operands, count, strict, json);
    font_close(c.face);
    daft_engine_destroy(c.engine);
    free(c.printed);
    return status;
}
