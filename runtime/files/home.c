/* Finds the program's folders and the games. */
#include "files/home.h"

#include "files/source.h"

#include <sys/stat.h>
#include <errno.h>
#include <ctype.h>
#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

bool home_program_folder(char *out, size_t size)
{
    ssize_t length = readlink("/proc/self/exe", out, size - 1);
    if (length <= 0) return false;
    out[length] = 0;
    char *slash = strrchr(out, '/');
    if (!slash) return false;
    slash[slash == out] = 0;
    return true;
}

static bool try_root(home *out, const char *root)
{
    return path_join(out->games, PATH_SIZE, root, "games") && path_join(out->assets, PATH_SIZE, root, "assets") &&
           path_join(out->scripts, PATH_SIZE, root, "scripts") &&
           path_join(out->templates, PATH_SIZE, root, "templates") && path_is_folder(out->games) &&
           path_is_folder(out->scripts);
}

bool home_find(home *out, daft_error *error)
{
    const char *wish = getenv("DAFT_HOME");
    if (wish && wish[0]) {
        if (try_root(out, wish)) return true;
        return fail(error, DAFT_ERROR_IO, "DAFT_HOME is '%s', which has no folders games and scripts", wish);
    }
    char folder[PATH_SIZE], shared[PATH_SIZE];
    if (!home_program_folder(folder, sizeof folder))
        return fail(error, DAFT_ERROR_IO,
                    "the program cannot find its own folder: set DAFT_HOME to the folder that holds games/");
    if (path_join(shared, sizeof shared, folder, "../share/daft") && try_root(out, shared)) return true;
    for (;;) {
        if (try_root(out, folder)) return true;
        char *slash = strrchr(folder, '/');
        if (!slash || folder[1] == 0) break;
        slash[slash == folder] = 0;
    }
    return fail(error, DAFT_ERROR_IO,
                "no folders games and scripts above the program or in ../share/daft: set DAFT_HOME to the folder that "
                "holds them");
}

/* Reads the comment lines at the top of main.lua: the title up to the first colon, then the description. */
static void describe(game_info *game, const char *script)
{
    snprintf(game->title, sizeof game->title, "%s", game->name);
    game->title[0] = (char)toupper((unsigned char)game->title[0]);
    game->description[0] = 0;
    const char *rest = script;
    for (int number = 0; rest && strncmp(rest, "--", 2) == 0; number++) {
        char line[512];
        snprintf(line, sizeof line, "%.*s", (int)strcspn(rest, "\n"), rest);
        rest = strchr(rest, '\n');
        if (rest) rest++;
        char *text = line + strspn(line, "- \t");
        text[strcspn(text, "\r\n")] = 0;
        if (number == 0) {
            char *colon = strstr(text, ": ");
            if (text[0]) snprintf(game->title, sizeof game->title, "%.*s", (int)(colon ? colon - text : 127), text);
            text = colon ? colon + 2 : text + strlen(text);
            text[0] = (char)toupper((unsigned char)text[0]);
        }
        size_t used = strlen(game->description);
        if (text[0]) snprintf(game->description + used, sizeof game->description - used, "%s%s", used ? " " : "", text);
    }
}

/* "." and ".." get the name of the folder they stand for. */
static void name_game(game_info *out, const char *path)
{
    char real[PATH_SIZE * 4];
    char *resolved = realpath(path, NULL);
    snprintf(real, sizeof real, "%s", resolved ? resolved : path);
    free(resolved);
    path_base_name(real, out->name, sizeof out->name);
    char *dot = out->packed ? strrchr(out->name, '.') : NULL;
    if (dot && dot != out->name) *dot = 0;
}

/* A folder with a main.lua, or a packed game. A pack that is damaged is a game as well: opening it tells. */
static bool read_game(const char *folder, game_info *out)
{
    char path[PATH_SIZE + 16];
    snprintf(path, sizeof path, "%s/main.lua", folder);
    out->packed = path_is_file(folder) && has_extension(folder, ".daft");
    if (!out->packed && !path_is_file(path)) return false;
    snprintf(out->folder, sizeof out->folder, "%s", folder);
    name_game(out, folder);
    game_source source;
    char *script = source_open_alone(&source, out, NULL) ? daft_read_file(source.own, "main.lua", NULL, NULL) : NULL;
    describe(out, script);
    free(script);
    source_close(&source);
    return true;
}

static int by_name(const void *a, const void *b)
{
    return strcmp(((const game_info *)a)->name, ((const game_info *)b)->name);
}

game_info *home_list_games(const home *where, size_t *count)
{
    *count = 0;
    DIR *folder = opendir(where->games);
    if (!folder) return NULL;
    game_info *games = NULL;
    for (struct dirent *entry; (entry = readdir(folder));) {
        char path[PATH_SIZE];
        if (entry->d_name[0] == '.' || !path_join(path, sizeof path, where->games, entry->d_name)) continue;
        game_info *more = realloc(games, (*count + 1) * sizeof *games);
        if (!more) break;
        games = more;
        if (read_game(path, &games[*count])) ++*count;
    }
    closedir(folder);
    if (*count > 0) qsort(games, *count, sizeof *games, by_name);
    return games;
}

bool home_find_game(const home *where, const char *name, game_info *out, daft_error *error)
{
    if (strlen(name) >= PATH_SIZE / 2) return fail(error, DAFT_ERROR_ARGUMENT, "the name of the game is too long");
    if (read_game(name, out)) return true;
    char path[PATH_SIZE];
    if (name[0] && name[0] != '/' && path_join(path, sizeof path, where->games, name) && read_game(path, out))
        return true;
    if (path_is_folder(name)) return fail(error, DAFT_ERROR_IO, "%s: there is no main.lua in this folder", name);

    size_t count;
    game_info *games = home_list_games(where, &count);
    const char **names = calloc(count + 1, sizeof *names);
    char list[300] = "";
    for (size_t i = 0; names && i < count; i++) {
        names[i] = games[i].name;
        size_t used = strlen(list);
        snprintf(list + used, sizeof list - used, "%s%s", i ? ", " : "", games[i].name);
    }
    const char *near = names ? nearest_name(name, names, count) : NULL;
    if (near)
        fail(error, DAFT_ERROR_ARGUMENT, "there is no game '%s': did you mean '%s'?", name, near);
    else
        fail(error, DAFT_ERROR_ARGUMENT, "there is no game '%s'; games/ has: %s", name, count ? list : "nothing");
    free(names);
    free(games);
    return false;
}

/* With all above it. */
static bool make_folders(char *path)
{
    for (char *at = path + 1; *at; at++) {
        if (*at != '/') continue;
        *at = 0;
        const bool made = mkdir(path, 0700) == 0 || errno == EEXIST || errno == EROFS;
        *at = '/';
        if (!made) return false;
    }
    return (mkdir(path, 0700) == 0 || errno == EEXIST) && path_is_folder(path);
}

bool home_user_folder(const char *variable, const char *below_home, char *out, size_t size)
{
    const char *set = getenv(variable), *top = getenv("HOME");
    int length = -1;
    if (set && set[0] == '/')
        length = snprintf(out, size, "%s/daft", set);
    else if (top && top[0] == '/')
        length = snprintf(out, size, "%s/%s/daft", top, below_home);
    return length > 0 && (size_t)length < size && make_folders(out);
}
