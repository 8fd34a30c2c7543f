/* base: the safe writer: a file is whole or as it was before, whatever fails or whoever is killed. */
#include "fixtures.h"

#include "base/writer.h"

#include <dirent.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

static char folder[64], path[512];

static int begin(void **unused)
{
    (void)unused;
    snprintf(folder, sizeof folder, "/tmp/daft-writer-XXXXXX");
    if (!mkdtemp(folder)) return -1;
    snprintf(path, sizeof path, "%s/file", folder);
    return 0;
}

static uint32_t files_there(void)
{
    uint32_t count = 0;
    DIR *list = opendir(folder);
    assert_non_null(list);
    for (struct dirent *entry; (entry = readdir(list));) count += entry->d_name[0] != '.' || strlen(entry->d_name) > 2;
    closedir(list);
    return count;
}

static int end(void **unused)
{
    (void)unused;
    DIR *list = opendir(folder);
    for (struct dirent *entry; list && (entry = readdir(list));) unlinkat(dirfd(list), entry->d_name, 0);
    if (list) closedir(list);
    return rmdir(folder);
}

static void assert_holds(const char *text)
{
    char bytes[64] = {0};
    FILE *file = fopen(path, "r");
    assert_non_null(file);
    size_t size = fread(bytes, 1, sizeof bytes - 1, file);
    fclose(file);
    assert_int_equal(size, strlen(text));
    assert_string_equal(bytes, text);
}

static void a_file_appears_whole_and_alone(void **unused)
{
    (void)unused;
    daft_error error;
    assert_true(daft_write_file(path, "one", 3, &error));
    assert_holds("one");
    assert_true(daft_write_file(path, "", 0, &error));
    assert_holds("");
    assert_int_equal(files_there(), 1);
}

static void the_old_file_stays_until_the_new_one_is_whole(void **unused)
{
    (void)unused;
    daft_error error;
    daft_allocator allocator = daft_malloc_allocator();
    assert_true(daft_write_file(path, "old", 3, &error));
    daft_writer *writer = daft_writer_open(&allocator, path, &error);
    for (int i = 0; i < 100000; i++) daft_writer_print(writer, "%d ", i);
    assert_holds("old");
    daft_writer_abandon(writer);
    assert_holds("old");
    assert_int_equal(files_there(), 1);
}

static void permissions_stay(void **unused)
{
    (void)unused;
    struct stat status;
    daft_error error;
    assert_true(daft_write_file(path, "x", 1, &error));
    assert_int_equal(chmod(path, 0640), 0);
    assert_true(daft_write_file(path, "y", 1, &error));
    assert_int_equal(stat(path, &status), 0);
    assert_int_equal(status.st_mode & 0777, 0640);
}

static void only_regular_files_are_replaced(void **unused)
{
    (void)unused;
    char other[600];
    daft_error error;
    snprintf(other, sizeof other, "%s/link", folder);
    assert_true(daft_write_file(path, "kept", 4, &error));
    assert_int_equal(symlink(path, other), 0);
    assert_false(daft_write_file(other, "x", 1, &error));
    assert_non_null(strstr(error.message, "symbolic link"));
    snprintf(other, sizeof other, "%s/pipe", folder);
    assert_int_equal(mkfifo(other, 0666), 0);
    assert_false(daft_write_file(other, "x", 1, &error));
    assert_non_null(strstr(error.message, "not a regular file"));
    assert_false(daft_write_file(folder, "x", 1, &error));
    assert_non_null(strstr(error.message, "is a folder"));
    assert_false(daft_write_file("/dev/null", "x", 1, &error));
    assert_false(daft_write_file("/nowhere/at/all", "x", 1, &error));
    assert_int_equal(error.code, DAFT_ERROR_IO);
    assert_false(daft_write_file(NULL, "x", 1, &error));
    assert_false(daft_write_file(path, NULL, 1, &error));
    assert_int_equal(error.code, DAFT_ERROR_ARGUMENT);
    assert_holds("kept");
    assert_int_equal(files_there(), 3);
}

static void the_longest_name_works(void **unused)
{
    (void)unused;
    size_t used = strlen(folder);
    memcpy(path, folder, used);
    path[used++] = '/';
    memset(path + used, 'n', 255);
    path[used + 255] = 0;
    daft_error error;
    assert_true(daft_write_file(path, "long", 4, &error));
    assert_holds("long");
}

/* A limit on the size of files stands for a disk that is full. */
static void a_full_disk_leaves_the_old_file(void **unused)
{
    (void)unused;
    static char bytes[1 << 20];
    daft_error error;
    struct rlimit before, small;
    assert_true(daft_write_file(path, "old", 3, &error));
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
    small = before, small.rlim_cur = 100000;
    signal(SIGXFSZ, SIG_IGN);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
    bool written = daft_write_file(path, bytes, sizeof bytes, &error);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &before), 0);
    signal(SIGXFSZ, SIG_DFL);
    assert_false(written);
    assert_int_equal(error.code, DAFT_ERROR_IO);
    assert_holds("old");
    assert_int_equal(files_there(), 1);
}

/* Two contents in turns, each of one letter and some hundred kilobytes. */
static void write_for_ever(void)
{
    static char bytes[300000];
    for (int i = 0;; i++) {
        memset(bytes, i % 2 ? 'a' : 'b', sizeof bytes);
        if (!daft_write_file(path, bytes, sizeof bytes, NULL)) _exit(1);
    }
}

static void assert_whole(void)
{
    static char bytes[300001];
    FILE *file = fopen(path, "r");
    if (!file) return; /* killed before the first one was there */
    assert_int_equal(fread(bytes, 1, sizeof bytes, file), 300000);
    fclose(file);
    assert_true(bytes[0] == 'a' || bytes[0] == 'b');
    for (size_t i = 1; i < 300000; i++) assert_true(bytes[i] == bytes[0]);
}

static void a_killed_process_leaves_whole_files(void **unused)
{
    (void)unused;
    fixture_seed(0x5eed);
    for (int i = 0; i < 60; i++) {
        pid_t child = fork();
        assert_true(child >= 0);
        if (child == 0) write_for_ever();
        usleep(random_bits() % 20000);
        kill(child, SIGKILL);
        waitpid(child, NULL, 0);
        assert_whole();
    }
}

/* Left-over files of dead processes go when the next file is written; those of living ones stay. */
static void left_over_files_are_removed(void **unused)
{
    (void)unused;
    char left[600], busy[600];
    const struct timeval old[2] = {{1000000, 0}, {1000000, 0}};
    daft_error error;
    snprintf(left, sizeof left, "%s/.daft-0123456789abcdef.tmp", folder);
    snprintf(busy, sizeof busy, "%s/.daft-fedcba9876543210.tmp", folder);
    fclose(fopen(left, "w"));
    FILE *living = fopen(busy, "w");
    assert_int_equal(flock(fileno(living), LOCK_EX), 0);
    assert_int_equal(utimes(left, old), 0);
    assert_int_equal(utimes(busy, old), 0);
    assert_true(daft_write_file(path, "x", 1, &error));
    assert_int_equal(access(left, F_OK), -1);
    assert_int_equal(access(busy, F_OK), 0);
    fclose(living);
}

/* Before a sudden end: nothing but the old file stays, and a writer that goes on says that it failed. */
static void temporaries_of_this_process_can_be_removed(void **unused)
{
    (void)unused;
    daft_error error;
    assert_true(daft_write_file(path, "old", 3, &error));
    daft_writer *writer = daft_writer_begin(path, &error);
    assert_non_null(writer);
    daft_writer_put(writer, "new", 3);
    assert_int_equal(files_there(), 2);
    daft_remove_temporaries();
    assert_int_equal(files_there(), 1);
    assert_false(daft_writer_commit(writer, &error));
    assert_holds("old");
}

static void large_files_grow_and_take_corrections(void **unused)
{
    (void)unused;
    daft_error error;
    snprintf(path, sizeof path, "%s/large", folder);
    daft_writer *writer = daft_writer_begin(path, &error);
    assert_non_null(writer);
    daft_writer_put(writer, "....", 4);
    for (int i = 0; i < 50000; i++) daft_writer_put(writer, "body", 4);
    daft_writer_put_at(writer, 0, "head", 4);
    daft_writer_put(writer, NULL, 4);
    daft_writer_put(NULL, "x", 1);
    daft_writer_put_at(NULL, 0, "x", 1);
    assert_int_not_equal(access(path, F_OK), 0);
    assert_true(daft_writer_commit(writer, &error));
    FILE *file = fopen(path, "rb");
    char first[9] = "";
    assert_non_null(file);
    assert_int_equal(fread(first, 1, 8, file), 8);
    assert_string_equal(first, "headbody");
    fseek(file, 0, SEEK_END);
    assert_int_equal(ftell(file), 200004);
    fclose(file);
    /* A correction past the end is an error that sticks, and the old file stays. */
    writer = daft_writer_begin(path, &error);
    assert_non_null(writer);
    daft_writer_put(writer, "short", 5);
    daft_writer_put_at(writer, 3, "xyz", 3);
    assert_false(daft_writer_commit(writer, &error));
    assert_int_equal(error.code, DAFT_ERROR_IO);
    file = fopen(path, "rb");
    assert_non_null(file);
    fseek(file, 0, SEEK_END);
    assert_int_equal(ftell(file), 200004);
    fclose(file);
    assert_false(daft_writer_commit(NULL, &error));
    assert_null(daft_writer_begin(NULL, &error));
    assert_null(daft_writer_begin("", &error));
    daft_writer_abandon(NULL);
}

int main(void)
{
#define IN_A_FOLDER(test) cmocka_unit_test_setup_teardown(test, begin, end)
    const struct CMUnitTest tests[] = {
        IN_A_FOLDER(a_file_appears_whole_and_alone),
        IN_A_FOLDER(the_old_file_stays_until_the_new_one_is_whole),
        IN_A_FOLDER(permissions_stay),
        IN_A_FOLDER(only_regular_files_are_replaced),
        IN_A_FOLDER(the_longest_name_works),
        IN_A_FOLDER(a_full_disk_leaves_the_old_file),
        IN_A_FOLDER(a_killed_process_leaves_whole_files),
        IN_A_FOLDER(left_over_files_are_removed),
        IN_A_FOLDER(temporaries_of_this_process_can_be_removed),
        IN_A_FOLDER(large_files_grow_and_take_corrections),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
