/* The engine, the camera, and what a picture is asked with. */
#include "scene/fields/fields.h"

#define ENGINE(m, ...) DAFT_ROW(daft_engine_def, m, __VA_ARGS__)
#define CAMERA(m, ...) DAFT_ROW(daft_camera, m, __VA_ARGS__)
#define VIEW(m, ...)   DAFT_ROW(daft_view, m, __VA_ARGS__)

static const char *const ACCELS[] = {"bvh", "kdtree"};

static const daft_field ENGINE_ROWS[] = {
    DAFT_COOKIE_ROW(daft_engine_def),
    ENGINE(threads, .doc = "Worker threads, at most 64; 0: one for each processor"),
    ENGINE(isa, .doc = "The instruction set of the kernels: sse2, avx2 or avx512; none: the best this processor has"),
    DAFT_CHOICE_ROW(daft_engine_def, accel, ACCELS,
                    .doc = "What rays search meshes by; pictures and hits are the same"),
    DAFT_OTHER_ROW(daft_engine_def, allocator, .doc = "Where all memory comes from; all zero: malloc"),
    DAFT_OTHER_ROW(daft_engine_def, warn, .doc = "Called with each warning; none: they are dropped"),
    DAFT_OTHER_ROW(daft_engine_def, warn_user, .doc = "Handed to warn"),
    ENGINE(memory_limit, .unit = "bytes", .doc = "What the engine may hold, with what is reserved; 0: no limit"),
};

const daft_field_list daft_engine_fields = DAFT_FIELD_LIST(daft_engine_def, ENGINE_ROWS);

#define ANGLES .unit = "rad", DAFT_ANGLES

static const daft_field CAMERA_ROWS[] = {
    CAMERA(position, .unit = "m", .lua = "position", .flags = DAFT_FIELD_HASHED, .doc = "Where it is"),
    CAMERA(yaw, ANGLES, .lua = "yaw", .flags = DAFT_FIELD_HASHED,
           .doc = "0 looks along +X, positive turns right, towards +Z"),
    CAMERA(pitch, ANGLES, .lua = "pitch", .flags = DAFT_FIELD_HASHED, .doc = "Positive looks down"),
    CAMERA(roll, ANGLES, .lua = "roll", .scene = "roll", .flags = DAFT_FIELD_HASHED, .doc = "Positive leans right"),
    CAMERA(fov, .unit = "rad", FROM((double)1e-6f, 3.1415), .initial = {DAFT_PI / 2}, .lua = "fov",
           .flags = DAFT_FIELD_HASHED, .doc = "The horizontal angle of view, below pi"),
};

const daft_field_list daft_camera_fields = DAFT_FIELD_LIST(daft_camera, CAMERA_ROWS);

static const daft_field VIEW_ROWS[] = {
    DAFT_COOKIE_ROW(daft_view),
    DAFT_STRUCT_ROW(daft_view, camera, daft_camera, DAFT_STRUCT_CAMERA, .doc = "Where from"),
    VIEW(alpha, FROM(0, 1), .initial = {1}, .doc = "Between the last two ticks: 0 is the one before, 1 is now"),
    DAFT_STRUCT_ROW(daft_view, quality, daft_quality, DAFT_STRUCT_QUALITY,
                    .doc = "The knobs: how much work a picture may be"),
    VIEW(first_row, FROM(0, 16384), .doc = "Draws a band of the picture from this row on, a multiple of 32"),
    VIEW(row_count, FROM(0, 16384),
         .doc = "Rows of the band: a multiple of 32, or up to the last row; 0: all to the last"),
    VIEW(without, FROM(0, DAFT_WITHOUT_ALL), .doc = "Parts of the shading left out, bits DAFT_WITHOUT_…; 0: none"),
    DAFT_OTHER_ROW(daft_view, aov, .doc = "Arrays for what each pixel sees: depth, normal, entity and more"),
    DAFT_OTHER_ROW(daft_view, history,
                   .doc = "What remembers the picture before: for motion, for denoising, and for what has not changed"),
    VIEW(full, .doc = "Whether to draw what has not changed since the picture of history, too"),
    DAFT_OTHER_ROW(daft_view, progress, .doc = "Told how much is done, 0 to 1; returns false to stop"),
    DAFT_OTHER_ROW(daft_view, progress_user, .doc = "Handed to progress"),
};

const daft_field_list daft_view_fields = DAFT_FIELD_LIST(daft_view, VIEW_ROWS);
