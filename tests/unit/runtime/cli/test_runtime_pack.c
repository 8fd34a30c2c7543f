/* runtime/files/pack and `daft pack`: archives are the same to the bit, read back, and refused where they are hostile.
 */
#include "files/pack.h"
#include "cli/commands.h"
#include "common/util.h"
#include "files/archive.h"
#include "files/libraries.h"

#include "fixtures.h"

#include <sys/stat.h>
#include <unistd.h>

static char folder[64];

/* ---- archives of any kind ---- */

typedef struct part {
    const char *name, *text;
    uint32_t mode, size, flags; /* size: what the directory claims; 0: the text's */
    int method;
    const char *local; /* the name in its own header, where it is another */
} part;

static unsigned char zip[1 << 16];
static size_t used;

static void number(uint64_t value, int bytes)
{
    for (int i = 0; i < bytes; i++) zip[used++] = (unsigned char)(value >> 8 * i);
}

static void text(const char *bytes)
{
    memcpy(zip + used, bytes, strlen(bytes));
    used += strlen(bytes);
}

static void shared(const part *p, const char *name)
{
    uint32_t size = (uint32_t)strlen(p->text);
    number(20, 2), number(p->flags, 2), number((uint64_t)p->method, 2), number(0, 4);
    number(pack_crc(p->text, size), 4), number(size, 4), number(p->size ? p->size : size, 4);
    number(strlen(name), 2), number(0, 2);
}

static void build(const part *parts, size_t count)
{
    size_t offsets[16], begin;
    used = 0;
    for (size_t i = 0; i < count; i++) {
        const char *name = parts[i].local ? parts[i].local : parts[i].name;
        offsets[i] = used;
        number(0x04034b50, 4), shared(&parts[i], name), text(name), text(parts[i].text);
    }
    begin = used;
    for (size_t i = 0; i < count; i++) {
        number(0x02014b50, 4), number(0x0314, 2), shared(&parts[i], parts[i].name), number(0, 6);
        number((uint64_t)parts[i].mode << 16, 4), number(offsets[i], 4), text(parts[i].name);
    }
    size_t size = used - begin;
    number(0x06054b50, 4), number(0, 4), number(count, 2), number(count, 2), number(size, 4), number(begin, 4);
    number(0, 2);
}

static pack *open_it(daft_error *error)
{
    memset(error, 0, sizeof *error);
    return pack_open(zip, used, "it.daft", error);
}

static void assert_refused(const part *parts, size_t count, const char *why)
{
    daft_error error;
    build(parts, count);
    pack *p = open_it(&error);
    if (p) fail_msg("an archive is taken that %s", why);
    if (!strstr(error.message, why)) fail_msg("'%s' does not say '%s'", error.message, why);
}

static void a_good_archive_is_read(void **unused)
{
    (void)unused;
    static const part PARTS[] = {{"main.lua", "print(1)", 0100644, 0, 0, 0, NULL},
                                 {"a/", "", 040755, 0, 0, 0, NULL},
                                 {"a/b", "bb", 0, 0, 0, 0, NULL},
                                 {"a/empty", "", 0, 0, 0, 0, NULL}};
    daft_error error;
    char bytes[16];
    build(PARTS, 4);
    pack *p = open_it(&error);
    if (!p) fail_msg("%s", error.message);
    assert_int_equal(pack_read(p, "main.lua", NULL, 0, &error), 8);
    assert_int_equal(pack_read(p, "main.lua", bytes, sizeof bytes, &error), 8);
    assert_memory_equal(bytes, "print(1)", 8);
    assert_int_equal(pack_read(p, "a/b", bytes, sizeof bytes, &error), 2);
    assert_int_equal(pack_read(p, "a/empty", bytes, sizeof bytes, &error), 0);
    assert_int_equal(pack_read(p, "a", bytes, sizeof bytes, &error), -1);
    assert_int_equal(error.code, DAFT_OK);
    pack_close(p);
}

static void hostile_archives_are_refused(void **unused)
{
    (void)unused;
    static const char *const NAMES[] = {"/etc/passwd", "../x", "a/../../x", "a//b", "./a",
                                        "a\\b",        "c:x",  "a\nb",      "",     ".."};
    for (size_t i = 0; i < COUNT_OF(NAMES); i++)
        assert_refused(&(part){.name = NAMES[i], .text = "x"}, 1, "is not a name");
    assert_refused((part[]){{.name = "a", .text = "x"}, {.name = "b", .text = "y"}, {.name = "a", .text = "z"}}, 3,
                   "twice");
    assert_refused(&(part){.name = "a", .text = "/etc/passwd", .mode = 0120777}, 1, "is a link");
    assert_refused(&(part){.name = "a", .text = "", .mode = 0010644}, 1, "is a link or a device");
    assert_refused(&(part){.name = "a", .text = "x", .flags = 1}, 1, "encrypted");
    assert_refused(&(part){.name = "a", .text = "x", .method = 12}, 1, "not supported");
    assert_refused(&(part){.name = "a", .text = "x", .size = 2}, 1, "two sizes");
    assert_refused(&(part){.name = "a", .text = "x", .size = 1 << 30, .method = 8}, 1, "more than 200 times");
    assert_refused(&(part){.name = "a", .text = "x", .local = "b"}, 1, "another name");
}

/* A deflated file that does not give what its header says is refused as it is read. */
static void damaged_files_are_refused(void **unused)
{
    (void)unused;
    daft_error error;
    char bytes[64];
    build(&(part){.name = "a", .text = "no deflate stream", .method = 8}, 1);
    pack *p = open_it(&error);
    assert_non_null(p);
    assert_int_equal(pack_read(p, "a", bytes, sizeof bytes, &error), -1);
    assert_int_not_equal(error.code, DAFT_OK);
    pack_close(p);
}

/* Every byte of an archive changed, and every length cut: it is refused, or read within its bounds. */
static void no_damage_breaks_it(void **unused)
{
    (void)unused;
    static const part PARTS[] = {{.name = "main.lua", .text = "print(1)"}, {.name = "a/b", .text = "bb", .method = 8}};
    build(PARTS, 2);
    static unsigned char whole[sizeof zip];
    size_t size = used;
    memcpy(whole, zip, size);
    for (size_t at = 0; at < 2 * size; at++)
        for (int value = 0; value < 256; value += at < size ? 5 : 256) {
            used = at < size ? size : at - size;
            unsigned char *copy = malloc(used + 1); /* of just that size, so that checkers of memory see */
            memcpy(copy, whole, used);
            if (at < size) copy[at] = (unsigned char)value;
            daft_error error;
            char bytes[64];
            pack *p = pack_open(copy, used, "it", &error);
            if (p) pack_read(p, "main.lua", bytes, sizeof bytes, &error);
            if (p) pack_read(p, "a/b", bytes, sizeof bytes, &error);
            pack_close(p);
            free(copy);
        }
}

/* ---- writing ---- */

typedef struct written {
    unsigned char bytes[1 << 21];
    size_t size;
} written;

static void take(void *user, const void *bytes, size_t size)
{
    written *to = user;
    assert_true(to->size + size <= sizeof to->bytes);
    memcpy(to->bytes + to->size, bytes, size);
    to->size += size;
}

enum { FILES = 60, LARGEST = 1 << 15 };

/* The i-th file: none, few or many bytes; noise, text, or one byte again and again. */
static size_t make_file(size_t i, unsigned char bytes[LARGEST])
{
    uint32_t state = (uint32_t)i * 2654435761u + 1;
    const size_t size = i % 5 == 0 ? i / 5 : (size_t)(state % LARGEST);
    for (size_t k = 0; k < size; k++) {
        state = state * 1664525u + 1013904223u;
        bytes[k] = (unsigned char)(i % 3 == 0   ? state >> 24
                                   : i % 3 == 1 ? (uint32_t) "the words"[state >> 29]
                                                : (uint32_t)i);
    }
    return size;
}

static void write_files(written *to, bool deflate)
{
    static unsigned char bytes[LARGEST];
    daft_error error;
    to->size = 0;
    take(to, "a program", 9);
    const archive_def def = {.put = take, .user = to, .begin = 9, .deflate = deflate, .path = "it"};
    archive *made = archive_open(&def, &error);
    assert_non_null(made);
    for (size_t i = FILES; i-- > 0;) { /* in another order than that of names */
        char name[32];
        snprintf(name, sizeof name, "folder%zu/file%02zu", i % 4, i);
        const size_t size = make_file(i, bytes);
        if (!archive_add(made, name, bytes, size, i % 2 ? 0755 : 0644, &error)) fail_msg("%s", error.message);
    }
    assert_false(archive_add(made, "../x", "x", 1, 0644, &error));
    assert_int_equal(archive_count(made), FILES);
    archive_put_directory(made);
    archive_put_end(made, "a comment");
    archive_close(made);
}

/* What is written behind other bytes is read back, stored or deflated, with its modes, and is the same each time. */
static void archives_are_written_and_read(void **unused)
{
    (void)unused;
    static written all[2], again;
    static unsigned char wanted[LARGEST], got[LARGEST];
    for (int deflate = 0; deflate < 2; deflate++) {
        write_files(&all[deflate], deflate);
        write_files(&again, deflate);
        assert_int_equal(again.size, all[deflate].size);
        assert_memory_equal(again.bytes, all[deflate].bytes, again.size);
        daft_error error = {0};
        pack *p = pack_open(all[deflate].bytes, all[deflate].size, "it", &error);
        if (!p) fail_msg("%s", error.message);
        assert_int_equal(pack_count(p), FILES);
        for (size_t i = 0; i < FILES; i++) {
            const pack_file file = pack_file_at(p, i);
            const size_t number = (size_t)atoi(file.name + strlen("folder0/file")), size = make_file(number, wanted);
            assert_true(i == 0 || strcmp(pack_file_at(p, i - 1).name, file.name) < 0);
            assert_int_equal(file.size, size);
            assert_int_equal(file.runs, number % 2);
            assert_int_equal(pack_read(p, file.name, got, sizeof got, &error), size);
            assert_memory_equal(got, wanted, size);
        }
        pack_close(p);
    }
    assert_true(all[1].size < all[0].size * 3 / 4 || all[1].size == all[0].size); /* a build without zlib */
}

static void a_desktop_has_these_libraries(void **unused)
{
    (void)unused;
    static const char *const THERE[] = {
        "libc.so.6",   "libm.so.6",        "ld-linux-x86-64.so.2", "ld-linux-aarch64.so.1",
        "libX11.so.6", "libglib-2.0.so.0", "libasound.so.2",       "libwayland-client.so.0"};
    static const char *const CARRIED[] = {"libSDL2-2.0.so.0", "libSDL2_mixer-2.0.so.0", "liblua5.4.so.0", "libXss.so.1",
                                          "libcrypt.so.1",    "libjack.so.0",           "libm17n.so.0",   "libX"};
    for (size_t i = 0; i < COUNT_OF(THERE); i++)
        if (!libraries_desktop_has(THERE[i])) fail_msg("%s would be carried", THERE[i]);
    for (size_t i = 0; i < COUNT_OF(CARRIED); i++)
        if (libraries_desktop_has(CARRIED[i])) fail_msg("%s would be left out", CARRIED[i]);
}

/* What the stub sets for the program is not for what that starts: an editor, for one. */
static void the_stubs_environment_is_put_back(void **unused)
{
    (void)unused;
    char daft[] = "daft", version[] = "version", *arguments[] = {daft, version, NULL};
    setenv("LD_LIBRARY_PATH", "/cache/lib:/mine", 1);
    setenv("DAFT_LIBRARY_PATH", "/mine", 1);
    assert_int_equal(run_program(2, arguments), STATUS_DONE);
    assert_string_equal(getenv("LD_LIBRARY_PATH"), "/mine");
    assert_null(getenv("DAFT_LIBRARY_PATH"));
    setenv("LD_LIBRARY_PATH", "/cache/lib", 1);
    setenv("DAFT_LIBRARY_PATH", "", 1);
    assert_int_equal(run_program(2, arguments), STATUS_DONE);
    assert_null(getenv("LD_LIBRARY_PATH"));
    assert_null(getenv("DAFT_LIBRARY_PATH"));
}

/* ---- the programs ---- */

static int run(const char *format, ...) __attribute__((format(printf, 1, 2)));
static int run(const char *format, ...)
{
    char command[1024];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(command, sizeof command, format, arguments);
    va_end(arguments);
    return system(command);
}

static void sha256_is_the_standards(void **unused)
{
    (void)unused;
    char out[SHA256_TEXT];
    sha256 s;
    sha256_begin(&s);
    sha256_add(&s, "abc", 3);
    sha256_end(&s, out);
    assert_string_equal(out, "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    sha256_begin(&s);
    for (int i = 0; i < 1000000; i++) sha256_add(&s, "a", 1);
    sha256_end(&s, out);
    assert_string_equal(out, "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
    sha256_begin(&s);
    sha256_end(&s, out);
    assert_string_equal(out, "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
}

/* A game plays from its pack as from its folder, and packing twice gives the same bytes. */
static void a_game_is_packed_and_played(void **unused)
{
    (void)unused;
    assert_int_equal(run("cp -r '%s/games/marble' '%s/marble' && touch '%s/marble/.hidden'", DAFT_ROOT, folder, folder),
                     0);
    assert_int_equal(run("'%s' pack '%s/marble' -o '%s/a.daft' >'%s/said'", DAFT_PROGRAM, folder, folder, folder), 0);
    assert_int_equal(run("touch '%s/marble/main.lua' && '%s' pack '%s/marble' -o '%s/marble.daft' >/dev/null", folder,
                         DAFT_PROGRAM, folder, folder),
                     0);
    assert_int_equal(run("cmp '%s/a.daft' '%s/marble.daft'", folder, folder), 0);
    assert_int_equal(run("! grep -q hidden '%s/a.daft'", folder), 0);
    assert_int_equal(run("'%s' play '%s/marble' --headless --ticks 120 --hash >'%s/one'", DAFT_PROGRAM, folder, folder),
                     0);
    assert_int_equal(
        run("'%s' play '%s/marble.daft' --headless --ticks 120 --hash --record '%s/r.rec' >'%s/two' 2>'%s/err'",
            DAFT_PROGRAM, folder, folder, folder, folder),
        0);
    assert_int_equal(run("cmp '%s/one' '%s/two'", folder, folder), 0);
    assert_int_equal(run("hash=$(sed 's/.*SHA-256 //' '%s/said') && grep -q \"$hash\" '%s/err' && grep -q \"^pack "
                         "$hash\" '%s/r.rec'",
                         folder, folder, folder),
                     0);
    assert_int_equal(
        run("echo '-- more' >>'%s/marble/main.lua' && '%s' pack '%s/marble' -o '%s/marble.daft' >/dev/null", folder,
            DAFT_PROGRAM, folder, folder),
        0);
    assert_int_equal(run("'%s' play '%s/marble.daft' --headless --replay '%s/r.rec' >/dev/null 2>'%s/err'",
                         DAFT_PROGRAM, folder, folder, folder),
                     0);
    assert_int_equal(run("grep -q 'another version of the game' '%s/err'", folder), 0);
}

static void what_cannot_be_packed_is_refused(void **unused)
{
    (void)unused;
    assert_int_equal(
        run("mkdir '%s/bad' && echo >'%s/bad/main.lua' && ln -s /etc/passwd '%s/bad/link'", folder, folder, folder), 0);
    assert_int_not_equal(run("'%s' pack '%s/bad' -o '%s/bad.daft' 2>'%s/err'", DAFT_PROGRAM, folder, folder, folder),
                         0);
    assert_int_equal(run("grep -q 'symbolic link' '%s/err' && ! test -e '%s/bad.daft'", folder, folder), 0);
    assert_int_equal(run("echo nonsense >'%s/odd.daft'", folder), 0);
    assert_int_not_equal(run("'%s' play '%s/odd.daft' --headless 2>'%s/err'", DAFT_PROGRAM, folder, folder), 0);
    assert_int_equal(run("grep -q 'is not a packed game' '%s/err'", folder), 0);
}

static int begin(void **unused)
{
    (void)unused;
    snprintf(folder, sizeof folder, "/tmp/daft-pack-XXXXXX");
    return mkdtemp(folder) ? 0 : -1;
}

static int end(void **unused)
{
    (void)unused;
    return run("rm -rf '%s'", folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sha256_is_the_standards),       cmocka_unit_test(a_good_archive_is_read),
        cmocka_unit_test(hostile_archives_are_refused),  cmocka_unit_test(damaged_files_are_refused),
        cmocka_unit_test(no_damage_breaks_it),           cmocka_unit_test(archives_are_written_and_read),
        cmocka_unit_test(a_desktop_has_these_libraries), cmocka_unit_test(the_stubs_environment_is_put_back),
        cmocka_unit_test(a_game_is_packed_and_played),   cmocka_unit_test(what_cannot_be_packed_is_refused)};
    return cmocka_run_group_tests(tests, begin, end);
}
