/* base: reading what somebody named: only regular files, never waiting, never more than they held; and with roots, only
 * what lies beneath them. */
#include "fixtures.h"

#include "base/files.h"

#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <stdatomic.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

static char folder[32], path[64];
static daft_allocator allocator;

static int begin(void **unused)
{
    (void)unused;
    allocator = daft_malloc_allocator();
    snprintf(folder, sizeof folder, "/tmp/daft-file-XXXXXX");
    if (!mkdtemp(folder)) return -1;
    snprintf(path, sizeof path, "%s/it", folder);
    return 0;
}

static int end(void **unused)
{
    (void)unused;
    unlink(path);
    return rmdir(folder);
}

static void assert_refused(const char *name, const char *why)
{
    size_t size;
    daft_error error;
    assert_null(daft_file_read(&allocator, NULL, name, &size, &error));
    assert_int_equal(error.code, DAFT_ERROR_IO);
    assert_string_equal(error.file, name);
    if (!strstr(error.message, why)) fail_msg("'%s' does not say '%s'", error.message, why);
}

static void a_file_is_read_whole(void **unused)
{
    (void)unused;
    size_t size;
    daft_error error;
    FILE *file = fopen(path, "w");
    fwrite("a\0b", 1, 3, file);
    fclose(file);
    char *bytes = daft_file_read(&allocator, NULL, path, &size, &error);
    assert_non_null(bytes);
    assert_int_equal(size, 3);
    assert_memory_equal(bytes, "a\0b", 4);
    daft_release(&allocator, bytes);
    assert_true(daft_file_exists(NULL, path));
}

static void what_is_no_file_is_refused_at_once(void **unused)
{
    (void)unused;
    assert_refused(path, "No such file");
    assert_refused(folder, "is a directory");
    assert_refused("/dev/zero", "is a device");
    assert_int_equal(mkfifo(path, 0666), 0);
    assert_refused(path, "is a pipe");
    assert_false(daft_file_exists(NULL, path));
    unlink(path);
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    snprintf(address.sun_path, sizeof address.sun_path, "%s", path);
    int listener = socket(AF_UNIX, SOCK_STREAM, 0);
    assert_int_equal(bind(listener, (struct sockaddr *)&address, sizeof address), 0);
    assert_refused(path, "is a socket");
    close(listener);
}

/* A hole of a terabyte takes no room on the disk, and must take none in memory. */
static void a_giant_is_refused(void **unused)
{
    (void)unused;
    int file = open(path, O_WRONLY | O_CREAT, 0666);
    assert_true(file >= 0);
    if (ftruncate(file, (off_t)1 << 40) == 0) assert_refused(path, "is larger than");
    close(file);
}

/* ---- names ---- */

static void names_are_shown_escaped(void **unused)
{
    (void)unused;
    static const char *const PAIRS[][2] = {{"plain name.obj", "plain name.obj"},
                                           {"a\nb\tc\x1b[2J\x7f", "a\\nb\\tc\\x1b[2J\\x7f"},
                                           {"gr\xc3\xbc\xc3\x9f \xe2\x9c\x93 \xf0\x9f\x8e\xb2", NULL},
                                           {"\xff\xc3", "\\xff\\xc3"},
                                           {"\xc0\x80 \xed\xa0\x80", "\\xc0\\x80 \\xed\\xa0\\x80"},
                                           {"\xc2\x9b"
                                            "2J",
                                            "\\xc2\\x9b2J"},
                                           {"\xe2\x9c", "\\xe2\\x9c"}};
    char out[128];
    for (size_t i = 0; i < sizeof PAIRS / sizeof PAIRS[0]; i++) {
        const char *wanted = PAIRS[i][1] ? PAIRS[i][1] : PAIRS[i][0];
        assert_string_equal(daft_escape(PAIRS[i][0], out, sizeof out), wanted);
        assert_string_equal(daft_escape(wanted, out, sizeof out), wanted);
    }
    assert_string_equal(daft_escape("ab\n", out, 4), "ab");
    daft_error error;
    size_t size;
    assert_null(daft_file_read(&allocator, NULL, "no\nsuch\xff", &size, &error));
    assert_string_equal(error.file, "no\\nsuch\\xff");
}

/* The longest name that a folder takes, one with a newline, one that is no UTF-8. */
static void any_name_is_read(void **unused)
{
    (void)unused;
    char longest[256] = "", name[400];
    memset(longest, 'n', 251);
    const char *const names[] = {longest, "two\nlines", "\xff\xfe", "- --", "..."};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        size_t size;
        daft_error error;
        snprintf(name, sizeof name, "%s/%s", folder, names[i]);
        FILE *file = fopen(name, "w");
        assert_non_null(file);
        fputs("it", file);
        fclose(file);
        daft_root root = {.folder = folder};
        daft_files_def def = daft_default_files_def();
        def.roots = &root, def.root_count = 1;
        daft_files *files = daft_files_create(&def, &error);
        char *bytes = daft_read_file(files, names[i], &size, &error);
        assert_non_null(bytes);
        assert_string_equal(bytes, "it");
        free(bytes);
        daft_files_destroy(files);
        unlink(name);
    }
}

static void paths_are_put_into_normal_form(void **unused)
{
    (void)unused;
    static const char *const GOOD[][2] = {{"a/b", "a/b"},    {"./a//b/.", "a/b"},        {"a/../b", "b"}, {"", ""},
                                          {"a/b/../..", ""}, {"a/..b/...", "a/..b/..."}, {"/a", "a"}};
    static const char *const BAD[] = {"..", "a/../..", "a/../../b", "../a", "./.."};
    char out[64];
    for (size_t i = 0; i < sizeof GOOD / sizeof GOOD[0]; i++) {
        assert_true(daft_path_normalize(GOOD[i][0], out, sizeof out));
        assert_string_equal(out, GOOD[i][1]);
    }
    for (size_t i = 0; i < sizeof BAD / sizeof BAD[0]; i++) assert_false(daft_path_normalize(BAD[i], out, sizeof out));
    assert_false(daft_path_normalize("0123456789", out, 10));
}

/* ---- files that change ---- */

typedef struct changer {
    atomic_bool ends;
    atomic_size_t rounds;
} changer;

static void *change_size(void *user)
{
    changer *c = user;
    for (size_t i = 0; !atomic_load(&c->ends); i = atomic_fetch_add(&c->rounds, 1))
        if (truncate(path, i % 2 ? 1 << 20 : 100) != 0) break;
    return NULL;
}

/* What is read is as long as the file was at one moment, or the reading fails. */
static void a_file_that_changes_is_read_or_refused(void **unused)
{
    (void)unused;
    changer c;
    atomic_init(&c.ends, false);
    atomic_init(&c.rounds, 0);
    fclose(fopen(path, "w"));
    pthread_t thread;
    assert_int_equal(pthread_create(&thread, NULL, change_size, &c), 0);
    for (int i = 0; i < 300 || atomic_load(&c.rounds) < 10; i++) {
        size_t size = 1;
        daft_error error;
        char *bytes = daft_file_read(&allocator, NULL, path, &size, &error);
        if (bytes)
            assert_true(size == 0 || size == 100 || size == 1 << 20);
        else
            assert_string_equal(error.message, "became shorter while it was read");
        daft_release(&allocator, bytes);
    }
    atomic_store(&c.ends, true);
    pthread_join(thread, NULL);
}

/* ---- roots ---- */

static char outside[32], inside[64];

static void put(const char *in, const char *name, const char *text)
{
    char full[200];
    snprintf(full, sizeof full, "%s/%s", in, name);
    FILE *file = fopen(full, "w");
    assert_non_null(file);
    fputs(text, file);
    fclose(file);
}

static void link_to(const char *to, const char *name)
{
    char full[200];
    snprintf(full, sizeof full, "%s/%s", folder, name);
    assert_int_equal(symlink(to, full), 0);
}

/* `folder` with a file, a folder with a file, and links of every kind that lead out of it. */
static int begin_roots(void **unused)
{
    if (begin(unused) != 0) return -1;
    snprintf(outside, sizeof outside, "/tmp/daft-outside-XXXXXX");
    if (!mkdtemp(outside)) return -1;
    snprintf(inside, sizeof inside, "%s/inner", folder);
    mkdir(inside, 0777);
    put(outside, "secret", "root:x:0:0");
    put(outside, "shared", "shared");
    put(folder, "it", "it");
    put(inside, "deep", "deep");
    char secret[64];
    snprintf(secret, sizeof secret, "%s/secret", outside);
    link_to(secret, "link");
    link_to(outside, "folder_link");
    link_to("it", "link_inside");
    link_to("/proc/self/root", "magic");
    return 0;
}

static int end_roots(void **unused)
{
    (void)unused;
    char command[160];
    snprintf(command, sizeof command, "rm -rf '%s' '%s'", folder, outside);
    return system(command);
}

static daft_files *open_roots(const char *first, const char *second)
{
    daft_error error;
    daft_root roots[] = {{.folder = first}, {.folder = second}};
    daft_files_def def = daft_default_files_def();
    def.roots = roots, def.root_count = second ? 2 : 1;
    daft_files *files = daft_files_create(&def, &error);
    if (!files) fail_msg("%s", error.message);
    return files;
}

static void assert_reads(const daft_files *files, const char *name, const char *text)
{
    daft_error error;
    char *bytes = daft_read_file(files, name, NULL, &error);
    if (!bytes) fail_msg("%s: %s", name, error.message);
    assert_string_equal(bytes, text);
    free(bytes);
}

static void assert_sealed(const daft_files *files, const char *name)
{
    daft_error error;
    char found[512];
    if (daft_read_file(files, name, NULL, &error)) fail_msg("%s is read", name);
    assert_int_equal(error.code, DAFT_ERROR_IO);
    assert_null(strstr(error.message, "root:"));
    assert_false(daft_files_find(files, name, found, sizeof found));
    assert_false(daft_file_exists(files, name));
}

static void what_lies_beneath_a_root_is_read(void **unused)
{
    (void)unused;
    daft_files *files = open_roots(folder, NULL);
    char full[200];
    assert_reads(files, "it", "it");
    assert_reads(files, "inner/deep", "deep");
    assert_reads(files, "inner/../it", "it");
    assert_reads(files, "./inner//./deep", "deep");
    snprintf(full, sizeof full, "%s/inner/../it", folder);
    assert_reads(files, full, "it");
    daft_files_destroy(files);
}

static void nothing_else_is_read(void **unused)
{
    (void)unused;
    daft_files *files = open_roots(folder, NULL);
    char full[200];
    static const char *const NAMES[] = {"link",
                                        "folder_link/secret",
                                        "magic/etc/passwd",
                                        "/etc/passwd",
                                        "../../etc/passwd",
                                        "inner/../../x",
                                        "link_inside",
                                        "",
                                        ".",
                                        "inner",
                                        "folder_link/../it/x",
                                        "//etc/passwd"};
    for (size_t i = 0; i < sizeof NAMES / sizeof NAMES[0]; i++) assert_sealed(files, NAMES[i]);
    snprintf(full, sizeof full, "%s/../%s/secret", folder, strrchr(outside, '/') + 1);
    assert_sealed(files, full);
    snprintf(full, sizeof full, "%s-more/it", folder);
    assert_sealed(files, full);
    snprintf(full, sizeof full, "%s/fifo", folder);
    assert_int_equal(mkfifo(full, 0666), 0);
    assert_sealed(files, "fifo");
    daft_files_destroy(files);
}

/* The walk for systems without openat2 decides the same. */
static void the_walk_follows_no_links(void **unused)
{
    (void)unused;
    int root = open(folder, O_RDONLY | O_DIRECTORY);
    static const char *const GOOD[] = {"it", "inner/deep"}, *const BAD[] = {"link",        "folder_link/secret",
                                                                            "link_inside", "magic/etc/passwd",
                                                                            "none/x",      "it/x"};
    for (size_t i = 0; i < sizeof GOOD / sizeof GOOD[0]; i++) {
        int file = daft_open_walking(root, GOOD[i], O_RDONLY | O_NONBLOCK);
        assert_true(file >= 0);
        close(file);
    }
    for (size_t i = 0; i < sizeof BAD / sizeof BAD[0]; i++)
        assert_int_equal(daft_open_walking(root, BAD[i], O_RDONLY | O_NONBLOCK), -1);
    char part[400];
    memset(part, 'a', sizeof part);
    part[399] = 0;
    assert_int_equal(daft_open_walking(root, part, O_RDONLY), -1);
    assert_int_equal(errno, ENAMETOOLONG);
    close(root);
}

static void roots_are_searched_in_order(void **unused)
{
    (void)unused;
    char found[200], wanted[200];
    put(outside, "it", "other");
    daft_files *files = open_roots(folder, outside);
    assert_reads(files, "it", "it");
    assert_reads(files, "shared", "shared");
    assert_true(daft_files_find(files, "shared", found, sizeof found));
    snprintf(wanted, sizeof wanted, "%s/shared", outside);
    assert_string_equal(found, wanted);
    assert_reads(files, found, "shared");
    snprintf(wanted, sizeof wanted, "%s/shared", folder);
    assert_sealed(files, wanted); /* beneath one root is not beneath another */
    daft_files_destroy(files);
}

static void count_names(void *user, const char *name)
{
    (void)name;
    ++*(int *)user;
}

static void folders_behind_links_are_not_listed(void **unused)
{
    (void)unused;
    daft_files *files = open_roots(folder, NULL);
    int count = 0;
    assert_false(daft_files_list(files, "folder_link", count_names, &count));
    assert_false(daft_files_list(files, "..", count_names, &count));
    assert_false(daft_files_list(files, "/", count_names, &count));
    assert_true(daft_files_list(files, "nothing_there", count_names, &count));
    assert_int_equal(count, 0);
    assert_true(daft_files_list(files, "inner", count_names, &count));
    assert_int_equal(count, 1);
    daft_files_destroy(files);
}

/* ---- files that a program has ---- */

static int64_t read_fake(void *user, const char *name, void *bytes, uint64_t capacity, daft_error *error)
{
    (void)user;
    if (strcmp(name, "bad") == 0) *error = (daft_error){.code = DAFT_ERROR_SYNTAX, .message = "is damaged"};
    if (strcmp(name, "huge") == 0) return INT64_MAX;
    if (strcmp(name, "inner/deep") != 0) return -1;
    if (capacity >= 4) memcpy(bytes, "fake", 4);
    return 4;
}

static void a_callback_gives_files(void **unused)
{
    (void)unused;
    daft_error error;
    daft_root root = {.folder = "/pack/game.daft", .read = read_fake};
    daft_files_def def = daft_default_files_def();
    def.roots = &root, def.root_count = 1;
    daft_files *files = daft_files_create(&def, &error);
    assert_reads(files, "inner/deep", "fake");
    assert_reads(files, "/pack/game.daft/x/../inner/deep", "fake");
    assert_sealed(files, "/pack/game.daft/../it");
    assert_sealed(files, "it");
    assert_null(daft_read_file(files, "bad", NULL, &error));
    assert_string_equal(error.message, "is damaged");
    assert_null(daft_read_file(files, "huge", NULL, &error));
    assert_non_null(strstr(error.message, "is larger than"));
    daft_files_destroy(files);
}

static void a_size_limit_holds(void **unused)
{
    (void)unused;
    daft_error error;
    daft_root root = {.folder = folder};
    daft_files_def def = daft_default_files_def();
    def.roots = &root, def.root_count = 1, def.max_file_bytes = 1;
    daft_files *files = daft_files_create(&def, &error);
    assert_null(daft_read_file(files, "it", NULL, &error));
    assert_string_equal(error.message, "is larger than the 1 bytes that a file may have");
    daft_files_destroy(files);
}

int main(void)
{
#define WITH_ROOTS(test)  cmocka_unit_test_setup_teardown(test, begin_roots, end_roots)
#define IN_A_FOLDER(test) cmocka_unit_test_setup_teardown(test, begin, end)
    const struct CMUnitTest tests[] = {IN_A_FOLDER(a_file_is_read_whole),
                                       IN_A_FOLDER(what_is_no_file_is_refused_at_once),
                                       IN_A_FOLDER(a_giant_is_refused),
                                       IN_A_FOLDER(names_are_shown_escaped),
                                       IN_A_FOLDER(any_name_is_read),
                                       IN_A_FOLDER(paths_are_put_into_normal_form),
                                       IN_A_FOLDER(a_file_that_changes_is_read_or_refused),
                                       WITH_ROOTS(what_lies_beneath_a_root_is_read),
                                       WITH_ROOTS(nothing_else_is_read),
                                       WITH_ROOTS(the_walk_follows_no_links),
                                       WITH_ROOTS(roots_are_searched_in_order),
                                       WITH_ROOTS(folders_behind_links_are_not_listed),
                                       IN_A_FOLDER(a_callback_gives_files),
                                       WITH_ROOTS(a_size_limit_holds)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
