/* daft pack: a game's folder as one file, or as a program of its own. The archive is the same to the bit wherever it is
 * made: names are sorted, times are the first that archives know, and files are stored, since compressors differ from
 * version to version. */
#include "cli/commands.h"

#include "cli/cli.h"
#include "cli/packing.h"
#include "files/archive.h"
#include "files/sha256.h"
#include "files/source.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const cli_command COMMAND = {
    "pack",
    "GAME",
    "Packs a game into one file, which 'daft play FILE.daft' plays, or into a program of its own.",
    "The file is a zip archive of the game's folder, without files whose names begin with a dot. The same folder gives "
    "the\n"
    "same bytes everywhere; their SHA-256 is printed. With --standalone it is a program for systems like this one "
    "(Linux),\n"
    "which takes the options of 'daft play'; it holds DAFT and the libraries that a desktop may not have.",
    1,
    1};

typedef struct sink {
    daft_writer *writer;
    sha256 hash;
} sink;

static void put(void *user, const void *bytes, size_t size)
{
    sink *to = user;
    daft_writer_put(to->writer, bytes, size);
    sha256_add(&to->hash, bytes, size);
}

/* Earlier packs are not packed again. */
static bool is_pack(const char *name) { return has_extension(name, ".daft"); }

bool packing_put_game(const archive_def *def, const game_info *game, const game_source *source, size_t *count,
                      daft_error *error)
{
    archive *made = archive_open(def, error);
    const bool good = made && archive_add_folder(made, source->own, game->folder, "", is_pack, error);
    if (good) {
        archive_put_directory(made);
        archive_put_end(made, "");
        *count = archive_count(made);
    }
    archive_close(made);
    return good;
}

static bool write_archive(const game_info *game, const game_source *source, const char *out, daft_error *error)
{
    sink to = {.writer = daft_writer_begin(out, error)};
    if (!to.writer) return false;
    sha256_begin(&to.hash);
    const archive_def def = {.put = put, .user = &to, .path = game->folder};
    size_t count;
    bool good = packing_put_game(&def, game, source, &count, error);
    if (good)
        good = daft_writer_commit(to.writer, error);
    else
        daft_writer_abandon(to.writer);
    char hash[SHA256_TEXT], shown[PATH_SIZE];
    sha256_end(&to.hash, hash);
    if (good) printf("%s: %zu files, SHA-256 %s\n", daft_escape(out, shown, sizeof shown), count, hash);
    return good;
}

static bool pack_game(const char *name, const char *out, bool standalone, daft_error *error)
{
    home where;
    game_info game;
    game_source source = {0};
    if (!home_find(&where, error) || !home_find_game(&where, name, &game, error)) return false;
    bool good = !game.packed || standalone || fail_at(error, game.folder, 0, 0, "is packed already");
    good =
        good && source_open(&source, &where, &game, error) &&
        (standalone ? standalone_write(&where, &game, &source, out, error) : write_archive(&game, &source, out, error));
    source_close(&source);
    return good;
}

int command_pack(int argc, char **argv)
{
    const char *out = NULL;
    bool standalone = false;
    const cli_option options[] = {
        {"output", 'o', CLI_TEXT, "FILE", &out, 0, 0, "the packed game, as in marble.daft (needed)"},
        {"standalone", 0, CLI_FLAG, NULL, &standalone, 0, 0, "FILE is a program, which needs no DAFT to be installed"}};
    const char *operands[CLI_OPERANDS];
    size_t count;
    cli_outcome outcome = cli_parse(&COMMAND, options, COUNT_OF(options), argc, argv, operands, &count);
    if (outcome != CLI_READY) return outcome == CLI_HELPED ? STATUS_DONE : STATUS_BAD_USAGE;
    if (!out) return cli_refuse("pack", standalone ? "-o FILE is missing" : "-o FILE.daft is missing");
    if (standalone && has_extension(out, ".daft"))
        return cli_refuse("pack",
                          "--standalone makes a program: its name cannot end in .daft, which is a game for DAFT");
    if (!standalone && !has_extension(out, ".daft")) return cli_refuse("pack", "-o FILE.daft is missing");
    daft_error error;
    return pack_game(operands[0], out, standalone, &error) ? STATUS_DONE : report(&error);
}
