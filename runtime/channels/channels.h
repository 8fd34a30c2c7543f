/* channels: what `daft render --aov` writes of each pixel, as files of their own beside the picture or as layers of one
 * EXR file. Public headers: channels.h */
#ifndef RUNTIME_CHANNELS_CHANNELS_H
#define RUNTIME_CHANNELS_CHANNELS_H

#include "daft.h"

typedef enum channel_kind {
    CHANNEL_DEPTH,
    CHANNEL_NORMAL,
    CHANNEL_ID,
    CHANNEL_TRIANGLE,
    CHANNEL_COLOR,
    CHANNEL_ALBEDO,
    CHANNEL_MOTION,
    CHANNEL_COST,
    CHANNEL_COUNT
} channel_kind;

/* All zero: none. */
typedef struct channel_set {
    bool wanted[CHANNEL_COUNT];
    int width, height;
    daft_aov arrays;
} channel_set;

/* "depth,normal,…"; false, and which word is none. */
bool channels_parse(const char *list, channel_set *set, daft_error *error);
bool channels_allocate(channel_set *set, int width, int height, daft_error *error);
/* The array of a wanted channel, or NULL, and the bytes of a pixel. */
void *channels_array(const daft_aov *arrays, channel_kind kind, size_t *bytes);
/* Beside a picture of this name: NAME.depth.pfm and so on. */
bool channels_write(const channel_set *set, daft_engine *engine, const char *image, daft_error *error);
/* All that are wanted, CHANNEL_COLOR among them, as layers of one EXR file (OpenEXR's channel names: R, G, B; depth.Z;
 * normal.X, .Y, .Z; albedo.R, .G, .B; motion.X, .Y; entity.id; triangle.id; cost.rays). */
bool channels_write_exr(const channel_set *set, const char *path, daft_error *error);
void channels_free(channel_set *set);

#endif
