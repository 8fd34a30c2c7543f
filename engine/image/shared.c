/* A list, looked through once for each file that is loaded: that takes much longer. */
#include "image/shared.h"

#include <string.h>

struct daft_shared_image {
    struct daft_shared_image *next, **link;
    uint64_t hash, size; /* of all that it is made of */
    uint32_t holders;
    daft_texture_data texture; /* or */
    daft_sky_image sky;
};

typedef struct key {
    uint64_t hash, size;
} key;

enum { KEY_TEXTURE = 1, KEY_SKY }; /* where the hash starts */

/* By chance two of a thousand files have the same 64 bits once in 10^13 scenes. */
static key key_with(key before, const void *bytes, size_t size)
{
    return (key){daft_hash(bytes, size, before.hash), before.size + size};
}

/* Held once more; NULL: nobody has it. */
static daft_shared_image *find(const daft_image_cache *cache, key wanted)
{
    for (daft_shared_image *s = cache->first; s; s = s->next) {
        if (s->hash != wanted.hash || s->size != wanted.size) continue;
        s->holders++;
        return s;
    }
    return NULL;
}

static void add(daft_image_cache *cache, daft_shared_image *s, key made_of)
{
    s->hash = made_of.hash, s->size = made_of.size, s->holders = 1;
    s->next = cache->first, s->link = &cache->first;
    if (s->next) s->next->link = &s->next;
    cache->first = s;
}

void daft_shared_image_release(const daft_allocator *allocator, daft_shared_image *s)
{
    if (--s->holders) return;
    *s->link = s->next;
    if (s->next) s->next->link = s->link;
    s->texture.shared = s->sky.shared = NULL;
    daft_texture_free(allocator, &s->texture);
    daft_sky_free(allocator, &s->sky);
    daft_release(allocator, s);
}

/* ---- textures ---- */

static key key_of_texture(const daft_image_file *file, const daft_texture_change *change)
{
    key made_of = key_with((key){KEY_TEXTURE, 0}, file->bytes, file->size);
    if (!change) return made_of;
    const float numbers[] = {(float)change->channel, change->base, change->gain, (float)change->most};
    return key_with(made_of, numbers, sizeof numbers);
}

bool daft_texture_share(daft_image_cache *cache, const daft_allocator *allocator, const daft_image_file *file,
                        const daft_texture_change *change, daft_texture_data *out, daft_error *error)
{
    const key made_of = key_of_texture(file, change);
    daft_shared_image *s = find(cache, made_of);
    if (!s) {
        s = daft_alloc_zero(allocator, 1, sizeof *s);
        if (!s) return daft_fail_memory(error, "a texture");
        if (!daft_texture_decode(allocator, file, change, &s->texture, error)) {
            daft_release(allocator, s);
            return false;
        }
        s->texture.shared = s;
        add(cache, s, made_of);
    }
    *out = s->texture;
    return true;
}

/* ---- skies ---- */

bool daft_sky_share(daft_image_cache *cache, const daft_allocator *allocator, const daft_image_file *files, int count,
                    daft_sky_image *out, daft_error *error)
{
    key made_of = {KEY_SKY, 0};
    for (int i = 0; i < count; i++) made_of = key_with(made_of, files[i].bytes, files[i].size);
    daft_shared_image *s = find(cache, made_of);
    if (!s) {
        s = daft_alloc_zero(allocator, 1, sizeof *s);
        if (!s) return daft_fail_memory(error, "a sky");
        if (!(count == 6 ? daft_sky_decode_cube(allocator, files, &s->sky, error)
                         : daft_sky_decode(allocator, &files[0], &s->sky, error))) {
            daft_release(allocator, s);
            return false;
        }
        s->sky.shared = s;
        add(cache, s, made_of);
    }
    *out = s->sky;
    return true;
}
