/* FNV-1a, 64 bits: <http://www.isthe.com/chongo/tech/comp/fnv/>. */
#include "base/base.h"

uint64_t daft_hash(const void *bytes, size_t size, uint64_t seed)
{
    const unsigned char *byte = bytes;
    uint64_t hash = seed ? seed : 0xcbf29ce484222325u;
    for (size_t i = 0; byte && i < size; i++) hash = (hash ^ byte[i]) * 0x100000001b3u;
    return hash;
}
