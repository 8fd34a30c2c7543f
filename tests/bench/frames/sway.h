/* How the camera of a scene's rows moves, as a person looking around does: up to 40 cm along and 20 cm across, 6
 * degrees to the sides, so that no frame repeats the one before. */
#ifndef DAFT_BENCH_SWAY_H
#define DAFT_BENCH_SWAY_H

#include "daft.h"
#include "math/vec.h"
#include "math/trig.h"
#include "scene/scene.h"

#include <stdlib.h>

enum { SWAY_FRAMES = 120, SWAY_WIDTH = 1280, SWAY_HEIGHT = 720 };

static inline daft_camera sway(const daft_camera *from, int frame)
{
    double turn = 2 * DAFT_PI * (frame + 0.5) / SWAY_FRAMES, along = 0.4 * daft_sin(turn),
           across = 0.2 * daft_sin(2 * turn);
    double c = daft_cos((double)from->yaw), s = daft_sin((double)from->yaw); /* yaw 0 looks along +X, positive turns to
                                                                                +Z */
    daft_camera camera = *from;
    camera.position.x += along * c - across * s, camera.position.z += along * s + across * c;
    camera.yaw += (float)(6 * DAFT_PI / 180 * daft_sin(turn));
    return camera;
}

/* Whether the scene's first sun casts shadows: the peer's only ones, unless it casts those of all lights. */
static inline bool sway_has_sun(daft_scene *scene, const daft_view *view)
{
    daft_error error;
    daft_scene_frame *frame = daft_frame_take(scene, view, SWAY_WIDTH, SWAY_HEIGHT, &error);
    bool casts = false;
    if (!frame) return false;
    for (uint32_t i = 0; i < frame->snapshot.light_count; i++) {
        if (!frame->snapshot.lights[i].sun) continue;
        casts = frame->snapshot.lights[i].casts_shadow;
        break;
    }
    daft_frame_release(scene, frame);
    return casts;
}

/* What the peer leaves out is off: light is not sampled, mirrors and what transmits show the sky. */
static inline void sway_equal_work(daft_quality *q, bool shadows)
{
    q->shadows = shadows;
    q->shadow_samples = q->occlusion_samples = q->glossy_samples = q->mirror_depth = q->refraction_depth = 0;
    q->denoise = false;
}

static inline int sway_by_time(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return x < y ? -1 : x > y;
}

/* The median and the 95th percentile; the times end up in order. */
static inline double sway_median(double *ms, int count)
{
    qsort(ms, (size_t)count, sizeof ms[0], sway_by_time);
    return ms[count / 2];
}
static inline double sway_p95(const double *sorted, int count) { return sorted[count * 95 / 100 - (count >= 20)]; }

#endif
