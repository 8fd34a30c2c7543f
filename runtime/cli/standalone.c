/* daft pack --standalone: a game as a program. The file is daft_stub (runtime/stub/) with a zip archive behind it,
 * which holds what the stub unpacks and starts: this program, the libraries that a desktop may not have, scripts/,
 * assets/ and the game. The archive's comment is the SHA-256 of all that lies before the archive's end. */
#include "cli/packing.h"

#include "files/libraries.h"
#include "files/module.h"
#include "files/sha256.h"
#include "platform/audio.h"
#include "stub/format.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <sys/utsname.h>

typedef struct program {
    const home *where;
    const game_info *game;
    const game_source *source;
    daft_writer *writer;
    archive *archive;
    sha256 hash;
    uint64_t size;
    libraries *libraries;
} program;

static void put(void *user, const void *bytes, size_t size)
{
    program *p = user;
    daft_writer_put(p->writer, bytes, size);
    sha256_add(&p->hash, bytes, size);
    p->size += size;
}

/* ---- the game ---- */

typedef struct memory {
    uint8_t *bytes;
    size_t size, capacity;
    bool failed;
} memory;

static void put_into_memory(void *user, const void *bytes, size_t size)
{
    memory *to = user;
    if (size > to->capacity - to->size) {
        const size_t capacity = 2 * to->capacity + size;
        uint8_t *more = realloc(to->bytes, capacity);
        to->failed = to->failed || !more;
        if (!more) return;
        to->bytes = more, to->capacity = capacity;
    }
    memcpy(to->bytes + to->size, bytes, size);
    to->size += size;
}

/* The bytes of a FILE.daft, from malloc. */
static uint8_t *pack_game(const program *p, size_t *size, daft_error *error)
{
    if (p->game->packed) return daft_read_file(NULL, p->game->folder, size, error);
    memory to = {0};
    size_t files;
    const archive_def def = {.put = put_into_memory, .user = &to, .path = p->game->folder};
    bool good = packing_put_game(&def, p->game, p->source, &files, error);
    if (good && to.failed) good = fail(error, DAFT_ERROR_MEMORY, "out of memory for a packed game");
    if (!good) free(to.bytes);
    *size = to.size;
    return good ? to.bytes : NULL;
}

/* ---- Assimp, where a file of the game is a model that takes it, or a text names one ---- */

static const char *const FOREIGN[] = {".gltf", ".glb", ".fbx", ".dae", ".ply", ".stl", ".3ds", ".blend"};

static bool names_model(const char *text, size_t size)
{
    for (size_t at = 0; at < size; at++) {
        for (size_t i = 0; text[at] == '.' && i < COUNT_OF(FOREIGN); i++)
            if (strncasecmp(text + at, FOREIGN[i], strlen(FOREIGN[i])) == 0) return true;
    }
    return false;
}

static bool takes_assimp(pack *game, const pack_file *file)
{
    for (size_t i = 0; i < COUNT_OF(FOREIGN); i++)
        if (has_extension(file->name, FOREIGN[i])) return true;
    if (!has_extension(file->name, ".lua") && !has_extension(file->name, ".scene")) return false;
    daft_error ignored; /* a file that is damaged is not played either */
    char *text = calloc(1, (size_t)file->size + 1);
    const bool found = text && pack_read(game, file->name, text, file->size, &ignored) == (int64_t)file->size &&
                       names_model(text, (size_t)file->size);
    free(text);
    return found;
}

static bool load_assimp(const void *bytes, size_t size, const char *path, daft_error *error)
{
    pack *game = pack_open(bytes, size, path, error);
    if (!game) return false;
    bool taken = false;
    for (size_t i = 0; i < pack_count(game) && !taken; i++) {
        const pack_file file = pack_file_at(game, i);
        taken = takes_assimp(game, &file);
    }
    pack_close(game);
    return !taken || libraries_load_assimp(error);
}

/* ---- the rest ---- */

static bool add_file(program *p, const char *name, const char *path, uint32_t mode, daft_error *error)
{
    size_t size;
    void *bytes = daft_read_file(NULL, path, &size, error);
    const bool good = bytes && archive_add(p->archive, name, bytes, size, mode, error);
    free(bytes);
    return good;
}

/* How assets are made is not for those who play. */
static bool is_for_makers(const char *name)
{
    return strcmp(name, "generate") == 0 || strcmp(name, "CMakeLists.txt") == 0;
}

static bool add_folder(program *p, const char *folder, const char *prefix, daft_error *error)
{
    const daft_root root = {.folder = folder};
    daft_files_def def = daft_default_files_def();
    def.roots = &root, def.root_count = 1;
    daft_files *files = daft_files_create(&def, error);
    const bool good = files && archive_add_folder(p->archive, files, folder, prefix, is_for_makers, error);
    daft_files_destroy(files);
    return good;
}

static bool add_libraries(program *p, daft_error *error)
{
    char name[sizeof STUB_LIBRARIES + sizeof p->libraries->carried[0].name];
    for (size_t i = 0; i < p->libraries->carried_count; i++) {
        const library *l = &p->libraries->carried[i];
        snprintf(name, sizeof name, STUB_LIBRARIES "%s", l->name);
        if (!add_file(p, name, l->path, 0644, error)) return false;
    }
    return true;
}

static bool add_game(program *p, daft_error *error)
{
    char name[sizeof STUB_GAMES + sizeof p->game->name + 8];
    size_t size;
    uint8_t *bytes = pack_game(p, &size, error);
    snprintf(name, sizeof name, STUB_GAMES "%s.daft", p->game->name);
    bool good = bytes && load_assimp(bytes, size, p->game->folder, error);
    if (good && !audio_load_decoders())
        fprintf(stderr, "daft: this program was built without SDL2_mixer: so the game will be silent\n");
    good = good && libraries_find(p->libraries, error) && archive_add(p->archive, name, bytes, size, 0644, error);
    free(bytes);
    return good;
}

static bool add_all(program *p, daft_error *error)
{
    return add_game(p, error) && add_file(p, STUB_PROGRAM, "/proc/self/exe", 0755, error) && add_libraries(p, error) &&
           add_folder(p, p->where->scripts, "scripts/", error) &&
           (!path_is_folder(p->where->assets) || add_folder(p, p->where->assets, "assets/", error));
}

static bool put_stub(program *p, daft_error *error)
{
    char path[2 * PATH_SIZE];
    size_t size;
#ifndef __linux__
    return fail(error, DAFT_ERROR_UNSUPPORTED,
                "--standalone works on Linux only; 'daft pack GAME -o FILE.daft' works everywhere");
#endif
    if (!module_find("daft_stub", path, sizeof path))
        return fail(error, DAFT_ERROR_UNSUPPORTED,
                    "--standalone takes the file daft_stub, which is neither beside this program nor where DAFT is "
                    "installed: build or install DAFT again");
    void *bytes = daft_read_file(NULL, path, &size, error);
    if (bytes) put(p, bytes, size);
    free(bytes);
    return bytes != NULL;
}

static bool put_archive(program *p, const char *out, daft_error *error)
{
    char comment[STUB_COMMENT + 1] = STUB_MARK;
    const archive_def def = {.put = put, .user = p, .begin = p->size, .deflate = true, .path = out};
    p->archive = archive_open(&def, error);
    const bool good = p->archive && add_all(p, error);
    if (good) {
        archive_put_directory(p->archive);
        sha256 before = p->hash;
        sha256_end(&before, comment + strlen(STUB_MARK));
        archive_put_end(p->archive, comment);
    }
    archive_close(p->archive);
    return good;
}

/* As the umask has it for programs. */
static bool make_executable(const char *path, daft_error *error)
{
    struct stat status;
    if (stat(path, &status) == 0 && chmod(path, status.st_mode | (status.st_mode & 0444) >> 2) == 0) return true;
    return fail_at(error, path, 0, 0, "cannot be made a program: %s", strerror(errno));
}

static void tell(const program *p, const char *out, const char *hash)
{
    char shown[PATH_SIZE];
    struct utsname system;
    const bool known = uname(&system) == 0;
    printf("%s: %.1f MB, SHA-256 %s\n", daft_escape(out, shown, sizeof shown), (double)p->size / 1e6, hash);
    printf("carries:");
    for (size_t i = 0; i < p->libraries->carried_count; i++) printf(" %s", p->libraries->carried[i].name);
    printf("\nneeds: Linux on %s", known ? system.machine : "this kind of processor");
    if (p->libraries->glibc) printf(", glibc 2.%d", p->libraries->glibc);
    printf(", and of a desktop not older than this one:");
    for (size_t i = 0; i < p->libraries->desktop_count; i++) printf(" %s", p->libraries->desktop[i]);
    printf("\n");
}

bool standalone_write(const home *where, const game_info *game, const game_source *source, const char *out,
                      daft_error *error)
{
    program p = {.where = where, .game = game, .source = source, .libraries = calloc(1, sizeof *p.libraries)};
    if (!p.libraries) return fail(error, DAFT_ERROR_MEMORY, "out of memory for the list of libraries");
    p.writer = daft_writer_begin(out, error);
    sha256_begin(&p.hash);
    bool good = p.writer && put_stub(&p, error) && put_archive(&p, out, error);
    if (good)
        good = daft_writer_commit(p.writer, error) && make_executable(out, error);
    else
        daft_writer_abandon(p.writer);
    char hash[SHA256_TEXT];
    sha256_end(&p.hash, hash);
    if (good) tell(&p, out, hash);
    free(p.libraries);
    return good;
}
