/* daft pack: a game's folder as one file. The archive is the same to the bit wherever it is made: names are sorted,
 * times are the first that archives know, and files are stored, since compressors differ from version to version. */
#include "cli/commands.h"

#include "cli/cli.h"
#include "files/pack.h"
#include "files/source.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

static const cli_command COMMAND = {"pack",
                                    "GAME",
                                    "Packs a game into one file, which 'daft play FILE.daft' plays.",
                                    "The file is a zip archive of the game's folder, without files whose names begin "
                                    "with a dot. The same folder gives the\n"
                                    "same bytes everywhere; their SHA-256 is printed.",
                                    1,
                                    1};

typedef struct packed {
    char *name; /* beneath the game's folder */
    uint64_t offset;
    uint32_t size, crc;
} packed;

typedef struct packer {
    const game_info *game;
    const game_source *source;
    packed *files;
    size_t count, capacity;
    daft_writer *writer;
    sha256 hash;
    uint64_t written;
    bool failed; /* while names are collected: *error says why */
    int depth;
    const char *folder; /* that is being listed */
    daft_error *error;
} packer;

/* ---- what there is ---- */

static void collect(packer *p, const char *folder);

static bool keep(packer *p, const char *name)
{
    if (!pack_name_is_good(name)) return fail_at(p->error, name, 0, 0, "is not a name that a packed file may have");
    if (p->count == PACK_FILES) return fail_at(p->error, p->game->folder, 0, 0, "holds more than 10000 files");
    if (p->count == p->capacity) {
        size_t more = p->capacity ? 2 * p->capacity : 64;
        packed *files = realloc(p->files, more * sizeof *files);
        if (!files) return fail(p->error, DAFT_ERROR_MEMORY, "out of memory for a packed game");
        p->files = files, p->capacity = more;
    }
    p->files[p->count] = (packed){.name = strdup(name)};
    return p->files[p->count++].name || fail(p->error, DAFT_ERROR_MEMORY, "out of memory for a packed game");
}

/* One name of the folder p->folder. Earlier packs are not packed again. */
static void look_at(void *user, const char *name)
{
    packer *p = user;
    struct stat status;
    char inner[PATH_SIZE], path[2 * PATH_SIZE];
    if (p->failed || has_extension(name, ".daft")) return;
    int length = snprintf(inner, sizeof inner, "%s%s%s", p->folder, p->folder[0] ? "/" : "", name);
    bool fits = length > 0 && (size_t)length < sizeof inner && path_join(path, sizeof path, p->game->folder, inner);
    if (!fits) {
        p->failed = !fail_at(p->error, inner, 0, 0, "the path is too long");
    } else if (lstat(path, &status) == 0 && S_ISDIR(status.st_mode)) {
        collect(p, inner);
    } else {
        p->failed = !keep(p, inner);
    }
}

static void collect(packer *p, const char *folder)
{
    enum { DEEPEST = 16 };
    const char *above = p->folder;
    if (p->depth == DEEPEST) {
        p->failed = !fail_at(p->error, folder, 0, 0, "folders are more than %d deep", (int)DEEPEST);
        return;
    }
    p->depth++;
    p->folder = folder;
    if (!daft_files_list(p->source->own, folder, look_at, p) && !p->failed)
        p->failed = !fail_at(p->error, folder[0] ? folder : p->game->folder, 0, 0, "the folder cannot be read");
    p->folder = above;
    p->depth--;
}

static int by_name(const void *a, const void *b)
{
    return strcmp(((const packed *)a)->name, ((const packed *)b)->name);
}

/* ---- the archive ---- */

static void put(packer *p, const void *bytes, size_t size)
{
    daft_writer_put(p->writer, bytes, size);
    sha256_add(&p->hash, bytes, size);
    p->written += size;
}

static uint8_t *put_number(uint8_t *at, uint64_t value, int bytes)
{
    for (int i = 0; i < bytes; i++) *at++ = (uint8_t)(value >> 8 * i);
    return at;
}

/* What the headers of a file share: version 2.0, names in UTF-8, stored, 1980-01-01 0:00, sums and sizes. */
static uint8_t *put_shared(uint8_t *at, const packed *f)
{
    at = put_number(put_number(put_number(at, 20, 2), 0x0800, 2), 0, 2);
    at = put_number(put_number(at, 0, 2), 0x0021, 2);
    at = put_number(put_number(put_number(at, f->crc, 4), f->size, 4), f->size, 4);
    return put_number(put_number(at, strlen(f->name), 2), 0, 2);
}

static bool put_file(packer *p, packed *f)
{
    uint8_t head[30], *at = put_number(head, 0x04034b50, 4);
    size_t size;
    char *bytes = daft_read_file(p->source->own, f->name, &size, p->error);
    if (!bytes) return false;
    f->offset = p->written;
    f->size = (uint32_t)size;
    f->crc = pack_crc(bytes, size);
    bool fits = p->written + size <= PACK_BYTES;
    if (fits) put(p, head, (size_t)(put_shared(at, f) - head));
    if (fits) put(p, f->name, strlen(f->name));
    if (fits) put(p, bytes, size);
    free(bytes);
    return fits || fail_at(p->error, p->game->folder, 0, 0, "holds more than 1 GiB of files");
}

static void put_directory(packer *p)
{
    uint64_t begin = p->written;
    for (size_t i = 0; i < p->count; i++) {
        const packed *f = &p->files[i];
        uint8_t head[46], *at = put_number(put_number(head, 0x02014b50, 4), 0x0314, 2); /* made on Unix */
        at = put_number(put_shared(at, f), 0, 6);
        at = put_number(put_number(at, (uint64_t)0100644 << 16, 4), f->offset, 4);
        put(p, head, (size_t)(at - head));
        put(p, f->name, strlen(f->name));
    }
    uint8_t end[22], *at = put_number(put_number(end, 0x06054b50, 4), 0, 4);
    at = put_number(put_number(at, p->count, 2), p->count, 2);
    at = put_number(put_number(put_number(at, p->written - begin, 4), begin, 4), 0, 2);
    put(p, end, (size_t)(at - end));
}

static bool put_all(packer *p, const char *out)
{
    collect(p, "");
    if (p->failed) return false;
    if (p->count > 1) qsort(p->files, p->count, sizeof *p->files, by_name);
    sha256_begin(&p->hash);
    p->writer = daft_writer_begin(out, p->error);
    bool good = p->writer != NULL;
    for (size_t i = 0; good && i < p->count; i++) good = put_file(p, &p->files[i]);
    if (good) put_directory(p);
    if (good) return daft_writer_commit(p->writer, p->error);
    daft_writer_abandon(p->writer);
    return false;
}

static bool pack_game(const char *name, const char *out, daft_error *error)
{
    home where;
    game_info game;
    game_source source = {0};
    packer p = {.game = &game, .source = &source, .folder = "", .error = error};
    if (!home_find(&where, error) || !home_find_game(&where, name, &game, error)) return false;
    bool good = !game.packed || fail_at(error, game.folder, 0, 0, "is packed already");
    good = good && source_open(&source, &where, &game, error) && put_all(&p, out);
    char hash[SHA256_TEXT], shown[PATH_SIZE];
    if (good) sha256_end(&p.hash, hash);
    if (good) printf("%s: %zu files, SHA-256 %s\n", daft_escape(out, shown, sizeof shown), p.count, hash);
    for (size_t i = 0; i < p.count; i++) free(p.files[i].name);
    free(p.files);
    source_close(&source);
    return good;
}

int command_pack(int argc, char **argv)
{
    const char *out = NULL;
    const cli_option options[] = {
        {"output", 'o', CLI_TEXT, "FILE", &out, 0, 0, "the packed game, as in marble.daft (needed)"}};
    const char *operands[CLI_OPERANDS];
    size_t count;
    cli_outcome outcome = cli_parse(&COMMAND, options, COUNT_OF(options), argc, argv, operands, &count);
    if (outcome != CLI_READY) return outcome == CLI_HELPED ? STATUS_DONE : STATUS_BAD_USAGE;
    if (!out || !has_extension(out, ".daft")) return cli_refuse("pack", "-o FILE.daft is missing");
    daft_error error;
    return pack_game(operands[0], out, &error) ? STATUS_DONE : report(&error);
}
