/* Metered exposure. A small picture of the same view says how bright the whole is: the mean of log2 of its luminance
 * becomes middle grey (Reinhard, Stark, Shirley, Ferwerda, "Photographic Tone Reproduction for Digital Images",
 * SIGGRAPH 2002, with a key of 0.18). So one picture by itself has the exposure that a series of it settles on, and
 * what is metered does not depend on bands, samples, or how much of the picture is drawn anew.
 *
 * In a series the exposure follows: with a time constant of half a second, from where it is more than 1/8 of a stop off
 * until it is within 1/64. In between it stays as it is, so that nothing flickers and pictures that do not change are
 * kept. */
#include "math/trig.h"
#include "render/internal.h"

#include <math.h>

enum { SIDE = 64 }; /* pixels of the longer side */

#define GREY        0.18
#define MOST_STOPS  8.0  /* brighter or darker than light is */
#define LEAST_LIGHT 1e-5 /* what is darker counts as so much */
#define STARTS      0.125f
#define ENDS        0.015625f
#define SECONDS     0.5f

struct daft_meter_picture {
    uint8_t pixels[4 * SIDE * SIDE];
    daft_vec3 color[SIDE * SIDE];
};

/* One sample a pixel, and nothing that is sampled or lies deep in mirrors. */
static daft_quality quality_of(const daft_quality *q)
{
    daft_quality out = *q;
    out.samples = 1, out.edge_samples = 0, out.denoise = false;
    out.shadow_samples = out.occlusion_samples = out.glossy_samples = 0;
    out.mirror_depth = daft_min_i(q->mirror_depth, 1), out.refraction_depth = daft_min_i(q->refraction_depth, 4);
    return out;
}

static daft_snapshot small_of(const daft_snapshot *s)
{
    daft_snapshot out = *s;
    const int longer = daft_max_i(s->width, s->height), most = daft_min_i(longer, SIDE);
    out.width = daft_max_i((s->width * most + longer / 2) / longer, 1);
    out.height = daft_max_i((s->height * most + longer / 2) / longer, 1);
    out.first_row = 0, out.row_count = out.height;
    out.focal = s->focal * (float)out.width / (float)s->width;
    out.quality = quality_of(&s->quality);
    out.tone = (daft_tone){0}, out.metered = false, out.seed = 0;
    out.before = NULL, out.past = NULL, out.kept = NULL, out.metering = NULL;
    return out;
}

/* The stops that make the mean middle grey. */
static float stops_of(const daft_vec3 *color, int count)
{
    double sum = 0;
    for (int i = 0; i < count; i++) {
        const double y = 0.2126 * (double)color[i].x + 0.7152 * (double)color[i].y + 0.0722 * (double)color[i].z;
        sum += daft_log2(y > LEAST_LIGHT ? fmin(y, 1 / LEAST_LIGHT) : LEAST_LIGHT); /* a NaN is dark */
    }
    return (float)fmax(-MOST_STOPS, fmin(MOST_STOPS, daft_log2(GREY) - sum / count));
}

static void follow(daft_metering *m, float wanted, float seconds)
{
    const float gap = wanted - m->ev;
    if (!m->some) {
        *m = (daft_metering){.some = true, .ev = wanted};
        return;
    }
    m->moving = fabsf(gap) > (m->moving ? ENDS : STARTS);
    if (m->moving) m->ev += gap * (seconds / (seconds + SECONDS));
}

bool daft_meter(daft_renderer *r, daft_snapshot *s, double *ms, daft_error *error)
{
    const daft_snapshot small = small_of(s);
    daft_counters counters = {0};
    if (!r->meter) r->meter = daft_alloc(&r->allocator, 1, sizeof *r->meter);
    if (!r->meter) return daft_fail_memory(error, "the picture that is metered");
    const daft_frame_target target = {.pixels = r->meter->pixels, .aov = {.color = r->meter->color}};
    if (!daft_render_frame(r, &small, &target, &counters, error)) return false;
    daft_metering all = s->metering ? *s->metering : (daft_metering){0};
    follow(&all, stops_of(r->meter->color, small.width * small.height), s->elapsed);
    if (s->metering && s->row_count == s->height) *s->metering = all;
    s->tone.ev += all.ev;
    *ms = counters.frame_ms;
    return true;
}
