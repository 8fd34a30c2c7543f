/* SHA-256 (FIPS 180-4): what a packed game is known by. */
#ifndef RUNTIME_FILES_SHA256_H
#define RUNTIME_FILES_SHA256_H

#include <stddef.h>
#include <stdint.h>

enum { SHA256_TEXT = 65 /* 64 hexadecimal digits and the zero byte */ };

typedef struct sha256 {
    uint32_t state[8];
    uint64_t size; /* bytes so far */
    uint8_t block[64];
} sha256;

void sha256_begin(sha256 *s);
void sha256_add(sha256 *s, const void *bytes, size_t size);
void sha256_end(sha256 *s, char out[SHA256_TEXT]);

#endif
