/* base: reading what somebody named: only regular files, never waiting, never more than they held. */
#include "fixtures.h"

#include "base/base.h"

#include <fcntl.h>
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

int main(void)
{
#define IN_A_FOLDER(test) cmocka_unit_test_setup_teardown(test, begin, end)
    const struct CMUnitTest tests[] = {IN_A_FOLDER(a_file_is_read_whole),
                                       IN_A_FOLDER(what_is_no_file_is_refused_at_once),
                                       IN_A_FOLDER(a_giant_is_refused)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
