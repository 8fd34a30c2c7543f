/* A packed game: what opens can be listed, and each of its files is read or refused, within its own size. */
#include "fuzz.h"

#include "files/pack.h"

#include <string.h>

enum { READ_AT_MOST = 4 << 20 };

static void look_at(void *user, const char *name)
{
    daft_error error = {0};
    FUZZ_CHECK(pack_name_is_good(name) && !strchr(name, '/'));
    int64_t size = pack_read(user, name, NULL, 0, &error);
    FUZZ_CHECK(size >= 0 && (uint64_t)size <= PACK_BYTES);
    if (size > READ_AT_MOST) return;
    uint8_t *bytes = malloc((size_t)size + 1);
    FUZZ_CHECK(bytes);
    int64_t got = pack_read(user, name, bytes, (uint64_t)size + 1, &error);
    FUZZ_CHECK(got == size || got == -1);
    if (size > 0) fuzz_check_error(got == size, &error);
    free(bytes);
}

int pack_input(const uint8_t *data, size_t size)
{
    daft_error error = {0};
    pack *p = pack_open(data, size, "game.daft", &error);
    fuzz_check_error(p != NULL, &error);
    if (!p) return 0;
    pack_list(p, "", look_at, p);
    pack_close(p);
    return 0;
}
