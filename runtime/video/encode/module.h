/* module: what the program takes from daft_film.so, which is linked with FFmpeg's libraries. */
#ifndef RUNTIME_VIDEO_MODULE_H
#define RUNTIME_VIDEO_MODULE_H

#include "video/encode/encoder.h"
#include "video/soundtrack.h"

/* As in encoder.h and soundtrack.h. */
typedef struct film_module {
    encoder *(*encoder_open)(const video_def *def, daft_error *error);
    bool (*encoder_add)(encoder *self, const uint8_t *pixels, packet_list *out, daft_error *error);
    bool (*encoder_finish)(encoder *self, packet_list *out, daft_error *error);
    void (*encoder_close)(encoder *self);
    muxer *(*muxer_open)(const video_def *def, daft_error *error);
    bool (*muxer_add)(muxer *self, const packet_list *clip, uint64_t start, daft_error *error);
    bool (*muxer_commit)(muxer *self, daft_error *error);
    void (*muxer_abandon)(muxer *self);
    soundtrack *(*soundtrack_open)(video_format format, daft_error *error);
    bool (*soundtrack_add)(soundtrack *self, const int16_t *frames, uint32_t count, daft_error *error);
    bool (*soundtrack_finish)(soundtrack *self, daft_error *error);
    void (*soundtrack_close)(soundtrack *self);
} film_module;

extern const film_module daft_film;

#endif
