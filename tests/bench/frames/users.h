/* Users' frames: what games and scenes cost as people meet them, at 1280x720. Each gives two rows, the median and the
 * 95th percentile of its frames, with the milliseconds of each effect. These rows lead the table. */
#ifndef DAFT_BENCH_USERS_H
#define DAFT_BENCH_USERS_H

#include "harness/bench.h"

#include "daft.h"

/* A scene of a file, drawn through daft.h alone by its first camera. */
typedef struct users_show {
    daft_engine *engine;
    daft_scene *scene;
    daft_image *image;
    daft_view view; /* quality: DAFT_PRESET_GAME */
    int threads;
} users_show;

/* False: see the error; users_close is needed all the same. */
bool users_open(bench *self, const char *path, int threads, int width, int height, users_show *out, daft_error *error);
void users_close(users_show *show);
/* A picture of the view, which is asked for with one of its own where what it reads changes. Milliseconds by
 * bench_clock_ms; negative on failure. */
double users_draw(users_show *show, const daft_view *view, daft_error *error);

/* The frames of one game or scene with so many threads. */
typedef struct users_frames {
    double median, p95;                /* milliseconds */
    double effects[DAFT_EFFECT_COUNT]; /* milliseconds, mean of all frames */
    const char *names[DAFT_EFFECT_COUNT];
    int frames;
} users_frames;

/* A peer: llvmpipe. */
typedef struct users_beside {
    const char *options; /* of its command line, each after a space */
    double floor, aim;   /* so many times as fast as it the median is to be */
    users_frames best;   /* frames 0: it has not run */
} users_beside;

/* One sample a pixel, and of all shadows the sun's; four; and one, with the shadows of all lights and trilinear
 * textures. */
#define USERS_BESIDE_PLAIN                                                                                             \
    {                                                                                                                  \
        .options = "", .floor = 1.3, .aim = 2                                                                          \
    }
#define USERS_BESIDE_ANTIALIASED                                                                                       \
    {                                                                                                                  \
        .options = " --antialiased", .floor = 1.3, .aim = 2                                                            \
    }
#define USERS_BESIDE_ALL_SHADOWS                                                                                       \
    {                                                                                                                  \
        .options = " --all-shadows", .floor = 1.8, .aim = 3                                                            \
    }

/* Adds the two rows. `note` stands before the effects; floor and aim are for the 95th percentile, in milliseconds; 0:
 * none. */
void users_report(bench *self, const char *scene, int threads, const users_frames *f, const users_beside *peer,
                  const char *note, double floor, double aim);
/* Whether the user asked for one of the two rows. */
bool users_wants(bench *self, const char *scene);
/* Where peers are asked for, runs llvmpipe on the scene or game (kind "scene" or "game"); `best` is what it reached,
 * unless that is slower than what it was. */
void users_peer(bench *self, const char *kind, const char *name, int threads, users_beside *peer);
/* The number after "name": in a JSON text; negative where there is none. */
double users_number(const char *json, const char *name);
/* "frame_ms" of a JSON text; the rest is 0. */
void users_read_times(const char *json, users_frames *out);
/* For scandir: files of scenes; games of games/ that have a demo.rec. */
struct dirent;
int users_is_scene(const struct dirent *entry);
int users_has_demo(const struct dirent *entry);

#endif
