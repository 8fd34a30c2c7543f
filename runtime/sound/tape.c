/* The header counts bytes in 32 bits: what is longer than six hours says as much as fits there, as other programs do.
 */
#include "sound/tape.h"

#include <string.h>

enum { HEADER = 44, BLOCK = 4 }; /* bytes; of a frame */

static void put_le(uint8_t *to, uint64_t value, int bytes)
{
    for (int i = 0; i < bytes; i++) to[i] = (uint8_t)(value >> 8 * i);
}

/* RIFF with one "fmt " of PCM and one "data" (Multimedia Programming Interface and Data Specifications 1.0, 1991). */
static void fill_header(uint8_t h[HEADER], uint64_t bytes)
{
    const uint64_t most = UINT32_MAX - HEADER;
    if (bytes > most) bytes = most;
    static const uint8_t riff[16] = {'R', 'I', 'F', 'F', 0, 0, 0, 0, 'W', 'A', 'V', 'E', 'f', 'm', 't', ' '},
                         data[4] = {'d', 'a', 't', 'a'};
    memcpy(h, riff, sizeof riff);
    memcpy(h + 36, data, sizeof data);
    put_le(h + 4, bytes + HEADER - 8, 4);
    put_le(h + 16, 16, 4);
    put_le(h + 20, 1, 2), put_le(h + 22, 2, 2);
    put_le(h + 24, SOUND_RATE, 4), put_le(h + 28, SOUND_RATE * BLOCK, 4);
    put_le(h + 32, BLOCK, 2), put_le(h + 34, 16, 2);
    put_le(h + 40, bytes, 4);
}

bool tape_begin(tape *out, const char *path, daft_error *error)
{
    uint8_t header[HEADER];
    *out = (tape){.writer = daft_writer_begin(path, error)};
    fill_header(header, 0);
    daft_writer_put(out->writer, header, HEADER);
    return out->writer != NULL;
}

void tape_put(tape *self, const int16_t *frames, uint32_t count)
{
    uint8_t bytes[BLOCK * SOUND_TICK];
    while (count) {
        const uint32_t some = count < SOUND_TICK ? count : SOUND_TICK;
        for (uint32_t i = 0; i < 2 * some; i++) put_le(&bytes[2 * i], (uint16_t)frames[i], 2);
        daft_writer_put(self->writer, bytes, BLOCK * some);
        self->bytes += BLOCK * some, frames += 2 * some, count -= some;
    }
}

bool tape_commit(tape *self, daft_error *error)
{
    uint8_t header[HEADER];
    daft_writer *writer = self->writer;
    self->writer = NULL;
    if (!writer) return true;
    fill_header(header, self->bytes);
    daft_writer_put_at(writer, 0, header, HEADER);
    return daft_writer_commit(writer, error);
}
