/* What the tests of images and meshes share: an allocator that counts and can fail, a log that remembers. */
#ifndef SUPPORT_CONTENT_H
#define SUPPORT_CONTENT_H

#include "base/base.h"
#include "base/files.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

/* Live blocks and calls so far; the call numbered `fail_at` (from 0) returns NULL. */
typedef struct counting {
    long live, calls, fail_at;
} counting;

static void *counting_allocate(void *user, size_t size, size_t alignment)
{
    counting *c = user;
    if (c->calls++ == c->fail_at) return NULL;
    daft_allocator plain = daft_malloc_allocator();
    c->live++;
    return plain.allocate(plain.user, size, alignment);
}

static void counting_release(void *user, void *pointer)
{
    counting *c = user;
    daft_allocator plain = daft_malloc_allocator();
    if (pointer) c->live--;
    plain.release(plain.user, pointer);
}

static inline daft_allocator counting_allocator(counting *c)
{
    *c = (counting){0, 0, -1};
    return (daft_allocator){.user = c, .allocate = counting_allocate, .release = counting_release};
}

typedef struct memo {
    int count;
    char text[40][1100];
} memo;

static void memo_warn(void *user, const daft_error *warning)
{
    memo *m = user;
    if (m->count < (int)DAFT_COUNT_OF(m->text)) daft_error_text(warning, m->text[m->count], sizeof m->text[0]);
    m->count++;
}

static inline daft_log memo_log(memo *m)
{
    m->count = 0;
    return (daft_log){.warn = memo_warn, .user = m};
}

static inline bool memo_has(const memo *m, const char *part)
{
    for (int i = 0; i < m->count && i < (int)DAFT_COUNT_OF(m->text); i++)
        if (strstr(m->text[i], part)) return true;
    return false;
}

/* A folder of its own for a test's files, under the system's temporary folder. */
static char test_folder[64];

static inline int make_test_folder(void **state)
{
    (void)state;
    snprintf(test_folder, sizeof test_folder, "/tmp/daft-test-XXXXXX");
    return mkdtemp(test_folder) ? 0 : -1;
}

static inline int remove_test_folder(void **state)
{
    (void)state;
    char command[128];
    snprintf(command, sizeof command, "rm -rf '%s'", test_folder);
    return system(command);
}

static inline const char *test_path(const char *name)
{
    static char path[4][512];
    static unsigned turn;
    char *out = path[turn++ % 4];
    snprintf(out, sizeof path[0], "%s/%s", test_folder, name);
    return out;
}

static inline const char *write_test_file(const char *name, const void *bytes, size_t size)
{
    const char *path = test_path(name);
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
    return path;
}

static inline const char *write_test_text(const char *name, const char *text)
{
    return write_test_file(name, text, strlen(text));
}

/* A file of tests/data. */
static inline const char *data_file(const char *name)
{
    static char path[4][1024];
    static unsigned turn;
    char *out = path[turn++ % 4];
    snprintf(out, sizeof path[0], "%s/tests/data/%s", DAFT_ROOT, name);
    if (!daft_file_exists(NULL, out)) fail_msg("tests/data/%s is missing", name);
    return out;
}

/* A file of the folder that may stand beside the checkout; NULL (and a message) where it is not there. */
static inline const char *shared_file(const char *name)
{
    static char path[4][1024];
    static unsigned turn;
    char *out = path[turn++ % 4];
    snprintf(out, sizeof path[0], "%s/../shared/data/%s", DAFT_ROOT, name);
    if (daft_file_exists(NULL, out)) return out;
    print_message("skipped: ../shared/data/%s is not there\n", name);
    return NULL;
}

static uint64_t random_state = 88172645463325252u;

static inline uint32_t random_below(uint32_t bound)
{
    random_state ^= random_state << 13, random_state ^= random_state >> 7, random_state ^= random_state << 17;
    return (uint32_t)((random_state >> 33) % bound);
}

#define assert_contains(text, part)                                                                                    \
    do {                                                                                                               \
        if (!strstr(text, part)) fail_msg("'%s' does not contain '%s'", text, part);                                   \
    } while (0)

#endif
