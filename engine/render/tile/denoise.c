/* Denoising: what was sampled with few rays is filtered before it becomes part of the picture. Filtered are the
 * fraction of sampled light (tile/soft.c) that arrives (Heitz, Hill, McGuire, "Combining Analytic Direct Illumination
 * and Stochastic Shadows", I3D 2018), and the light that rough surfaces mirror and let through (tile/gloss.c), as a
 * mean over the weights of their rays; each by itself. The light itself, with its textures, highlights, sharp shadows
 * and sharp mirrors, stays as it is.
 *
 * Tiles at work write what the filter needs into planes, summed up over a pixel's samples; where nothing is sampled,
 * and in the picture's margin, a kind's inverse depth is 0 and the filter looks away. Then each pass of the filter goes
 * over all tiles that have something of the kind, and the last step makes their bytes. */
#include "render/denoise.h"
#include "render/tile/tile.h"

#include <math.h>
#include <string.h>

enum { MARGIN = 16, PASSES = 4 }; /* columns on either side, and room for a register on the right */
enum {
    NORMAL = 0,
    INVERSE = 3, /* of all that is seen */
    SEEN,
    SHARP,
    LIGHT = 8, /* three of the ratio, three of the whole, one of the inverse depth */
    PLANES_UNFILTERED = 14,
    TO = 15,
    FROM_VARIANCE = 18,
    TO_VARIANCE,
    GLOSS = 20, /* as of the light */
    REACH = 27, /* of the gloss: pixels that the filter may reach */
    VIRTUAL,    /* and the inverse depth of what is shown, behind the surface */
    PLANES,
    PLANES_WITHOUT_GLOSS = GLOSS
};
enum { WHOLE = 3, KIND_INVERSE = 6 };

static int first_plane(int kind) { return kind == DAFT_NOISY_GLOSS ? GLOSS : LIGHT; }

static bool is_last(const daft_frame *frame) { return frame->sample == frame->snapshot->quality.samples - 1; }

/* The pixels whose sampled light is found and filtered. */
static const daft_grid *grid_of(const daft_frame *frame, int kind)
{
    return kind == DAFT_NOISY_LIGHT ? &frame->light_grid : &frame->grid;
}

static bool is_half(const daft_frame *frame) { return frame->light_grid.step > 1; }

/* The first float of the running pass's first tile in a plane. */
static float *plane(const daft_grid *g, int number) { return g->planes + (size_t)number * g->plane_size + MARGIN; }

/* The pixel of four that is sampled goes round from picture to picture. */
static daft_grid make_grid(const daft_frame *frame, int step)
{
    static const uint8_t X[4] = {0, 1, 1, 0}, Y[4] = {0, 1, 0, 1};
    const daft_snapshot *s = frame->snapshot;
    const uint32_t columns = daft_tile_columns(s), turn = step > 1 ? s->seed % 4 : 0;
    daft_grid g = {.first_tile = frame->first_tile, .tile = DAFT_TILE / step, .step = step, .x = X[turn], .y = Y[turn]};
    g.rows = (int)(frame->tile_count / columns) * g.tile;
    g.stride = (ptrdiff_t)columns * g.tile + 3 * MARGIN;
    g.plane_size = (size_t)g.stride * (size_t)g.rows;
    return g;
}

bool daft_denoise_prepare(daft_frame *frame, daft_error *error)
{
    daft_renderer *r = frame->renderer;
    const daft_snapshot *s = frame->snapshot;
    daft_past *past = s->past;
    const bool half = frame->plan.quality->half_light, glossy = frame->plan.glossy;
    frame->grid = frame->light_grid = (daft_grid){.step = 1};
    for (int i = 0; past && i < DAFT_PASTS; i++)
        past[i].some &= frame->plan.denoise && (i == DAFT_PAST_GLOSS ? glossy : frame->plan.samples_light);
    if (!frame->plan.denoise) return true;
    daft_grid full = make_grid(frame, 1), light = make_grid(frame, half ? 2 : 1);
    const size_t planes = glossy ? PLANES
                          : half ? PLANES_UNFILTERED
                                 : PLANES_WITHOUT_GLOSS,
                 first = planes * full.plane_size, size = first + (half ? PLANES_WITHOUT_GLOSS * light.plane_size : 0);
    if (!daft_grow(&r->allocator, &r->planes, &r->plane_capacity, size, 0, sizeof *r->planes) ||
        !daft_grow(&r->allocator, &r->noisy, &r->noisy_capacity, frame->tile_count, 0, sizeof *r->noisy))
        return daft_fail_memory(error, "what is denoised");
    full.planes = r->planes, light.planes = half ? r->planes + first : r->planes;
    const bool same = memcmp(&r->grid, &full, sizeof full) == 0 && r->plane_count == planes &&
                      r->light_grid.planes == light.planes && r->light_grid.step == light.step;
    if (!same) memset(r->planes, 0, size * sizeof *r->planes); /* margins stay 0 */
    r->plane_count = planes, r->grid = frame->grid = full, r->light_grid = frame->light_grid = light;
    for (int i = 0; past && i < DAFT_PASTS; i++)
        if ((i == DAFT_PAST_GLOSS ? glossy : frame->plan.samples_light) &&
            !daft_past_prepare(&past[i], &r->allocator, s, i == DAFT_PAST_GLOSS ? &full : &light, error))
            return false;
    return true;
}

/* Of the picture, that planes begin with. */
static int first_row(const daft_frame *frame)
{
    return (int)(frame->grid.first_tile / daft_tile_columns(frame->snapshot)) * DAFT_TILE;
}

/* Where the tile's first pixel is in a plane. */
static size_t tile_place(const daft_frame *frame, const daft_grid *g, uint32_t number)
{
    const uint32_t columns = daft_tile_columns(frame->snapshot), at = number - g->first_tile;
    return at / columns * (size_t)g->tile * (size_t)g->stride + at % columns * (size_t)g->tile;
}

static void clear(const daft_grid *g, int number, size_t first)
{
    float *to = plane(g, number) + first;
    for (int y = 0; y < g->tile; y++) memset(to + y * g->stride, 0, (size_t)g->tile * sizeof *to);
}

void daft_denoise_begin(const tile_job *j)
{
    const daft_frame *frame = j->frame;
    if (j->s->sampled) j->s->sampled->tile_some = false;
    if (frame->sample > 0) return;
    const daft_grid *full = &frame->grid, *light = &frame->light_grid;
    clear(full, INVERSE, tile_place(frame, full, j->number));
    clear(light, INVERSE, tile_place(frame, light, j->number));
    clear(light, LIGHT + KIND_INVERSE, tile_place(frame, light, j->number));
    if (frame->plan.glossy) clear(full, GLOSS + KIND_INVERSE, tile_place(frame, full, j->number));
    j->r->noisy[j->number - frame->first_tile] = 0;
}

/* What a point is, for the filter. */
typedef struct seen_plane {
    float normal[3], inverse;
    uint32_t instance;
} seen_plane;

static void put_seen(const daft_grid *g, size_t at, const seen_plane *p)
{
    for (int c = 0; c < 3; c++) plane(g, NORMAL + c)[at] = p->normal[c];
    plane(g, INVERSE)[at] = p->inverse;
    memcpy(&plane(g, SEEN)[at], &p->instance, sizeof p->instance);
}

/* The planes that pixels see, by their first sample. */
void daft_denoise_see(const tile_job *j)
{
    const daft_frame *frame = j->frame;
    const daft_snapshot *s = j->snapshot;
    const daft_batch *b = &j->s->points;
    const daft_grid *full = &frame->grid, *light = &frame->light_grid;
    const size_t first = tile_place(frame, full, j->number), first_light = tile_place(frame, light, j->number);
    const daft_vec3 axes[3] = {s->right, s->up, s->forward};
    if (frame->sample > 0) return;
    for (uint32_t i = 0; i < b->count; i++) {
        const uint32_t x = b->pixel[i] % DAFT_TILE, y = b->pixel[i] / DAFT_TILE;
        const daft_vec3 ray = daft_pencil_ray(&frame->pencil, j->s->tile.x + (int)x, j->s->tile.y + (int)y),
                        n = daft_v3(b->normal.x[i], b->normal.y[i], b->normal.z[i]);
        const float found = sqrtf(daft_dot(ray, ray)) / (b->distance[i] * s->focal);
        seen_plane p = {.inverse = found < 0x1p60f ? found : 0, .instance = b->instance[i]};
        for (int c = 0; c < 3; c++) p.normal[c] = daft_dot(n, axes[c]);
        put_seen(full, first + y * (size_t)full->stride + x, &p);
        if (is_half(frame) && daft_grid_has(light, x, y))
            put_seen(light, first_light + y / 2 * (size_t)light->stride + x / 2, &p);
    }
}

/* What arrives belongs to what a rough surface shows, which is filtered by itself. */
static void add_to_gloss(const tile_job *j, daft_batch *points, uint32_t i)
{
    const daft_sampled_light *light = j->s->sampled;
    points->light.x[i] += light->arrived.x[i], points->light.y[i] += light->arrived.y[i];
    points->light.z[i] += light->arrived.z[i];
}

/* A batch's sampled light, as far as it arrives at the pixels. */
void daft_denoise_take(const tile_job *j, daft_batch *points, bool seen)
{
    daft_sampled_light *light = j->s->sampled;
    if (!light->tile_some) {
        memset(&light->tile_whole, 0, sizeof light->tile_whole);
        memset(&light->tile_arrived, 0, sizeof light->tile_arrived);
        light->tile_some = true;
    }
    const float *const weight[3] = {points->weight.x, points->weight.y, points->weight.z};
    const float *const whole[3] = {light->whole.x, light->whole.y, light->whole.z}, *const arrived[3] = {
                                                                                        light->arrived.x,
                                                                                        light->arrived.y,
                                                                                        light->arrived.z};
    float *const to_whole[3] = {light->tile_whole.x, light->tile_whole.y, light->tile_whole.z},
                 *const to_arrived[3] = {light->tile_arrived.x, light->tile_arrived.y, light->tile_arrived.z};
    for (uint32_t i = 0; i < points->count; i++) {
        const uint32_t pixel = points->pixel[i];
        if (!seen && daft_gloss_is_rough(j->s->gloss, pixel)) {
            add_to_gloss(j, points, i);
            continue;
        }
        for (int c = 0; c < 3; c++) {
            const float share = seen ? 1 : weight[c][i];
            to_whole[c][pixel] += whole[c][i] * share, to_arrived[c][pixel] += arrived[c][i] * share;
        }
    }
}

/* Rays of a point, the fewer where there are two kinds. */
static int samples_of(const daft_frame *frame)
{
    const daft_quality *p = frame->plan.quality;
    if (!frame->plan.soft) return daft_max_i(p->occlusion_samples, 1);
    const int rays = frame->plan.occlusion ? daft_min_i(p->shadow_samples, p->occlusion_samples) : p->shadow_samples;
    return daft_max_i(rays, 1);
}

/* ---- a tile's sums ---- */

/* A tile's row, of every `step`-th value from `first` on. */
static void put_some(const daft_frame *frame, const daft_grid *g, int number, size_t row, const float *value,
                     float share)
{
    float *to = plane(g, number) + row;
    if (frame->sample == 0)
        for (int x = 0; x < g->tile; x++) to[x] = value[x * g->step + g->x] * share;
    else
        for (int x = 0; x < g->tile; x++) to[x] += value[x * g->step + g->x] * share;
}

static void put(const daft_frame *frame, int number, size_t row, const float *value, float share)
{
    float *to = plane(&frame->grid, number) + row;
    if (frame->sample == 0)
        for (int x = 0; x < DAFT_TILE; x++) to[x] = value[x] * share;
    else
        for (int x = 0; x < DAFT_TILE; x++) to[x] += value[x] * share;
}

static const float *lane_of(const daft_lanes3 *v, int c, int y)
{
    const float *const lanes[3] = {v->x, v->y, v->z};
    return lanes[c] + y * DAFT_TILE;
}

static float clamp_to(float x, float most) { return x > 0 ? (x < most ? x : most) : 0; }

/* The light that is sharp. Samples are clamped to what a display shows before they are averaged, as without a filter;
 * but the tone is that of the mean, as what is filtered is light. */
static void keep_sharp(const tile_job *j, size_t row, int y, float share)
{
    const daft_gloss *g = j->s->gloss;
    const float white = daft_tone_white(&j->snapshot->tone);
    for (int c = 0; c < 3; c++) {
        const float *color = lane_of(j->color, c, y), *own = g && g->some ? lane_of(&g->sharp, c, y) : NULL;
        float sharp[DAFT_TILE];
        for (int x = 0; x < DAFT_TILE; x++) {
            const float found = own && daft_gloss_is_rough(g, (uint32_t)(y * DAFT_TILE + x)) ? own[x] : color[x];
            sharp[x] = share < 1 ? clamp_to(found, white) : found;
        }
        put(j->frame, SHARP + c, row, sharp, share);
    }
}

static void keep_light(const tile_job *j, size_t row, int y, float share)
{
    static const float NONE[DAFT_TILE];
    const daft_frame *frame = j->frame;
    const daft_sampled_light *light = j->s->sampled;
    const daft_grid *g = &frame->light_grid;
    const bool some = light && light->tile_some, has = daft_grid_has(g, (uint32_t)g->x, (uint32_t)y);
    const size_t there = tile_place(frame, g, j->number) + (size_t)(y / g->step * g->stride);
    for (int c = 0; c < 3; c++) {
        const float *whole = some ? lane_of(&light->tile_whole, c, y) : NONE,
                    *arrived = some ? lane_of(&light->tile_arrived, c, y) : NONE;
        put(frame, LIGHT + WHOLE + c, row, whole, share);
        if (!is_half(frame)) put(frame, LIGHT + c, row, arrived, share);
        if (!has || !is_half(frame)) continue;
        put_some(frame, g, LIGHT + c, there, arrived, share);
        put_some(frame, g, LIGHT + WHOLE + c, there, whole, share);
    }
}

/* How much a surface bends between a tile's pixel and one beside it, 1/m: above 0 where it bulges. 0: they see
 * different things. */
static float bend_to(const tile_job *j, size_t at, int x, int y, size_t beside, int dx, int dy)
{
    const daft_frame *f = j->frame;
    const float *inverse = plane(&f->grid, INVERSE), *seen = plane(&f->grid, SEEN);
    if (!(inverse[beside] > 0) || memcmp(&seen[at], &seen[beside], sizeof *seen) != 0) return 0;
    daft_vec3 p[2], n[2];
    for (int k = 0; k < 2; k++) {
        const size_t i = k ? beside : at;
        const daft_vec3 ray = daft_pencil_ray(&f->pencil, j->s->tile.x + x + k * dx, j->s->tile.y + y + k * dy);
        p[k] = daft_scale(ray, 1 / (inverse[i] * j->snapshot->focal));
        n[k] = daft_v3(plane(&f->grid, NORMAL)[i], plane(&f->grid, NORMAL + 1)[i], plane(&f->grid, NORMAL + 2)[i]);
    }
    const daft_vec3 dp = daft_sub(p[1], p[0]), dn = daft_sub(n[1], n[0]);
    const float bend = sqrtf(daft_dot(dn, dn) / daft_dot(dp, dp));
    return bend < 1e6f ? (daft_dot(dn, dp) < 0 ? -bend : bend) : 0;
}

/* Across or down, whichever is more. */
static float bend_at(const tile_job *j, size_t at, int x, int y)
{
    const int dx = x ? -1 : 1, dy = y ? -1 : 1;
    const size_t stride = (size_t)j->frame->grid.stride, above = dy < 0 ? at - stride : at + stride;
    const float across = bend_to(j, at, x, y, dx < 0 ? at - 1 : at + 1, dx, 0),
                down = bend_to(j, at, x, y, above, 0, dy);
    return fabsf(across) > fabsf(down) ? across : down;
}

static void keep_gloss(const tile_job *j, size_t row, int y, float share)
{
    const daft_gloss *g = j->s->gloss;
    const float focal = j->snapshot->focal, *inverse = plane(&j->frame->grid, INVERSE) + row;
    float part[3][DAFT_TILE] = {{0}}, whole[3][DAFT_TILE] = {{0}}, reach[DAFT_TILE] = {0}, behind[DAFT_TILE] = {0};
    for (int x = 0; x < DAFT_TILE; x++) {
        const int pixel = y * DAFT_TILE + x;
        if (!daft_gloss_is_rough(g, (uint32_t)pixel) || !(g->rays[pixel] > 0)) continue;
        for (int c = 0; c < 3; c++) {
            const float found = lane_of(j->color, c, y)[x] - lane_of(&g->sharp, c, y)[x];
            part[c][x] = found < 0x1p60f ? found : 0, whole[c][x] = lane_of(&g->weight, c, y)[x];
        }
        /* What the rays meet is shown behind the surface, at 1 / `near` of the eye's distance before it: the mirror
         * equation. Half of all rays leave within twice the facets' slope. */
        const float near =
            g->distance[pixel] * fabsf(g->inverse[pixel] / g->rays[pixel] + 2 * bend_at(j, row + (size_t)x, x, y));
        reach[x] = 2 * g->alpha[pixel] * focal / (1 + near);
        behind[x] = inverse[x] * near / (1 + near);
        if (!(reach[x] < 1000)) reach[x] = 1000;
        if (!(behind[x] < 0x1p60f)) behind[x] = inverse[x];
    }
    for (int c = 0; c < 3; c++)
        put(j->frame, GLOSS + c, row, part[c], share), put(j->frame, GLOSS + WHOLE + c, row, whole[c], share);
    put(j->frame, REACH, row, reach, share), put(j->frame, VIRTUAL, row, behind, share);
}

/* From sums to ratios, and where there are some. Of light at most all arrives. */
static void finish_sums(const daft_grid *g, int kind, size_t row)
{
    const int planes = first_plane(kind);
    const float none = kind == DAFT_NOISY_LIGHT ? 1 : 0, most = kind == DAFT_NOISY_LIGHT ? 1 : 0x1p60f;
    float some[DAFT_TILE] = {0};
    for (int c = 0; c < 3; c++) {
        float *ratio = plane(g, planes + c) + row;
        const float *whole = plane(g, planes + WHOLE + c) + row;
        for (int x = 0; x < g->tile; x++) {
            const float found = ratio[x] / whole[x];
            ratio[x] = found >= 0 && found <= most ? found : none; /* 0/0 and what overflows, too */
            some[x] += whole[x];
        }
    }
    const float *seen = plane(g, INVERSE) + row;
    float *inverse = plane(g, planes + KIND_INVERSE) + row;
    for (int x = 0; x < g->tile; x++) inverse[x] = some[x] > 0 ? seen[x] : 0;
}

static void finish_tile(const daft_frame *frame, uint32_t number, uint8_t noisy)
{
    /* Rays of a point are stratified: the variance of their mean falls with the square of their number, about. */
    const float rays = (float)samples_of(frame), share = 1 / (rays * rays * (float)frame->snapshot->quality.samples);
    for (int kind = DAFT_NOISY_LIGHT; kind <= DAFT_NOISY_GLOSS; kind++) {
        const daft_grid *g = grid_of(frame, kind);
        const size_t first = tile_place(frame, g, number);
        for (int y = 0; noisy & kind && y < g->tile; y++) {
            const size_t row = first + (size_t)(y * g->stride);
            finish_sums(g, kind, row);
            float *variance = plane(g, FROM_VARIANCE) + row;
            for (int x = 0; kind == DAFT_NOISY_LIGHT && x < g->tile; x++) variance[x] = share;
        }
    }
}

/* The light without what is sampled, as long as that is filtered, and the fraction of that which arrives. */
bool daft_denoise_keep(const tile_job *j)
{
    const daft_frame *frame = j->frame;
    const daft_sampled_light *light = j->s->sampled;
    const size_t first = tile_place(frame, &frame->grid, j->number);
    const bool many = frame->snapshot->quality.samples > 1;
    const float share = 1 / (float)frame->snapshot->quality.samples;
    uint8_t *noisy = &j->r->noisy[j->number - frame->first_tile];
    *noisy |=
        (light && light->tile_some ? DAFT_NOISY_LIGHT : 0) | (j->s->gloss && j->s->gloss->some ? DAFT_NOISY_GLOSS : 0);
    if (*noisy || many) {
        for (int y = 0; y < DAFT_TILE; y++) {
            const size_t row = first + (size_t)(y * frame->grid.stride);
            keep_sharp(j, row, y, share);
            if (many || *noisy & DAFT_NOISY_LIGHT) keep_light(j, row, y, share);
            if (frame->plan.glossy && (many || *noisy & DAFT_NOISY_GLOSS)) keep_gloss(j, row, y, share);
        }
    }
    if (is_last(frame)) finish_tile(frame, j->number, *noisy);
    return *noisy || many;
}

/* ---- passes ---- */

/* Where a grid's pixels are, and the planes they see. */
static daft_filter filter_on(const daft_frame *frame, const daft_grid *g)
{
    const daft_vec3 ray = daft_pencil_ray(&frame->pencil, g->x, first_row(frame) + g->y);
    const float step = (float)g->step;
    daft_filter f = {.stride = g->stride,
                     .height = g->rows,
                     .step = 1,
                     .left = ray.x / step,
                     .top = ray.y / step,
                     .focal = ray.z / step};
    for (int c = 0; c < 3; c++) f.normal[c] = plane(g, NORMAL + c);
    return f;
}

static daft_reusing reusing_of(const daft_frame *frame, int kind)
{
    const daft_snapshot *s = frame->snapshot;
    const daft_grid *g = grid_of(frame, kind);
    const int planes = first_plane(kind);
    const bool gloss = kind == DAFT_NOISY_GLOSS;
    daft_past *past = &s->past[gloss ? DAFT_PAST_GLOSS : DAFT_PAST_LIGHT];
    daft_reusing r = {.snapshot = s,
                      .past = past,
                      .grid = filter_on(frame, g),
                      .first_row = first_row(frame) / g->step,
                      .remembers = past->some && s->before,
                      .inverse = plane(g, planes + KIND_INVERSE),
                      .seen = plane(g, SEEN),
                      .shown = gloss ? plane(g, VIRTUAL) : NULL,
                      .variance = gloss ? NULL : plane(g, FROM_VARIANCE)};
    for (int c = 0; c < 3; c++) r.ratio[c] = plane(g, planes + c);
    return r;
}

static void reuse_tile(const daft_frame *frame, uint32_t index, int kind)
{
    const daft_reusing r = reusing_of(frame, kind);
    const uint32_t columns = daft_tile_columns(frame->snapshot);
    const int side = grid_of(frame, kind)->tile, x = (int)(index % columns) * side, y = (int)(index / columns) * side;
    if (frame->renderer->noisy[index] & kind)
        frame->renderer->kernels->reuse(&r, x, y, side, side);
    else
        daft_past_clear(r.past, x, y + r.first_row, side);
}

static void reuse_task(void *context, uint32_t index, uint32_t worker)
{
    daft_frame *frame = context;
    if (atomic_load_explicit(&frame->cancelled, memory_order_relaxed)) return;
    const uint64_t since = daft_clock_ticks();
    for (int kind = DAFT_NOISY_LIGHT; kind <= DAFT_NOISY_GLOSS; kind++)
        if (frame->filtered & kind) reuse_tile(frame, index, kind);
    frame->renderer->scratch[worker].ticks[DAFT_EFFECT_DENOISE] += daft_clock_ticks() - since;
}

static daft_filter filter_of(const daft_frame *frame)
{
    const bool odd = frame->filter_pass % 2;
    const int planes = first_plane(frame->filtered), from = odd ? TO : planes, to = odd ? planes : TO;
    const daft_grid *g = grid_of(frame, frame->filtered);
    daft_filter f = filter_on(frame, g);
    f.step = 1 << frame->filter_pass;
    f.inverse = plane(g, planes + KIND_INVERSE);
    f.reach = frame->filtered == DAFT_NOISY_GLOSS ? plane(g, REACH) : NULL;
    f.from_variance = plane(g, odd ? TO_VARIANCE : FROM_VARIANCE);
    f.to_variance = plane(g, odd ? FROM_VARIANCE : TO_VARIANCE);
    for (int c = 0; c < 3; c++) f.from[c] = plane(g, from + c), f.to[c] = plane(g, to + c);
    return f;
}

/* From the light's pixels, one in four, to all. An odd number of passes leaves it in other planes. */
static void enlarge(const daft_frame *frame, const daft_tile *tile)
{
    const daft_grid *full = &frame->grid, *g = &frame->light_grid;
    daft_enlarging e = {.to = filter_on(frame, full), .from = filter_on(frame, g), .x = g->x, .y = g->y};
    e.to.inverse = plane(full, INVERSE), e.from.inverse = plane(g, LIGHT + KIND_INVERSE);
    for (int c = 0; c < 3; c++)
        e.to.to[c] = plane(full, LIGHT + c), e.from.from[c] = plane(g, (PASSES % 2 ? TO : LIGHT) + c);
    frame->renderer->kernels->enlarge(&e, tile->x, tile->y - first_row(frame), DAFT_TILE, DAFT_TILE);
}

typedef void filter_kernel(const daft_filter *filter, int x, int y, int width, int height);

static void run(daft_frame *frame, uint32_t index, uint32_t worker, filter_kernel *kernel)
{
    if (!(frame->renderer->noisy[index] & frame->filtered) ||
        atomic_load_explicit(&frame->cancelled, memory_order_relaxed))
        return;
    const uint32_t columns = daft_tile_columns(frame->snapshot);
    const daft_filter f = filter_of(frame);
    const int tile = grid_of(frame, frame->filtered)->tile;
    const uint64_t since = daft_clock_ticks();
    kernel(&f, (int)(index % columns) * tile, (int)(index / columns) * tile, tile, tile);
    frame->renderer->scratch[worker].ticks[DAFT_EFFECT_DENOISE] += daft_clock_ticks() - since;
}

static void noise_task(void *context, uint32_t index, uint32_t worker)
{
    daft_frame *frame = context;
    run(frame, index, worker, frame->renderer->kernels->filter_noise);
}

static void spread_task(void *context, uint32_t index, uint32_t worker)
{
    daft_frame *frame = context;
    run(frame, index, worker, frame->renderer->kernels->filter_spread);
}

static void pass_task(void *context, uint32_t index, uint32_t worker)
{
    daft_frame *frame = context;
    run(frame, index, worker, frame->renderer->kernels->filter_pass);
}

/* What is sampled, by its filtered ratio. */
static void add_filtered(const daft_frame *frame, int kind, size_t row, int c, float *color)
{
    const int planes = first_plane(kind);
    const float *ratio = plane(&frame->grid, planes + c) + row, *whole = plane(&frame->grid, planes + WHOLE + c) + row;
    for (int x = 0; x < DAFT_TILE; x++) color[x] += whole[x] * ratio[x];
}

/* The light of a tile's pixels: what is sharp, and what is sampled. */
static void finish_task(void *context, uint32_t index, uint32_t worker)
{
    daft_frame *frame = context;
    daft_renderer *r = frame->renderer;
    if (!r->noisy[index] && frame->snapshot->quality.samples == 1) return;
    daft_scratch *s = &r->scratch[worker];
    tile_job j = daft_tile_again(frame, index, worker);
    j.refines = false, j.color = &s->color;
    const size_t first = tile_place(frame, &frame->grid, j.number);
    const uint64_t since = daft_clock_ticks();
    if (is_half(frame) && r->noisy[index] & DAFT_NOISY_LIGHT) enlarge(frame, &s->tile);
    s->ticks[DAFT_EFFECT_DENOISE] += daft_clock_ticks() - since;
    float *const color[3] = {s->color.x, s->color.y, s->color.z};
    for (int c = 0; c < 3; c++)
        for (int y = 0; y < DAFT_TILE; y++) {
            const size_t row = first + (size_t)(y * frame->grid.stride);
            float *to = color[c] + y * DAFT_TILE;
            memcpy(to, plane(&frame->grid, SHARP + c) + row, DAFT_TILE * sizeof *to);
            for (int kind = DAFT_NOISY_LIGHT; kind <= DAFT_NOISY_GLOSS; kind++)
                if (r->noisy[index] & kind) add_filtered(frame, kind, row, c, to);
        }
    daft_tile_show(&j);
    s->tiles[DAFT_EFFECT_DENOISE] += r->noisy[index] != 0;
}

static void filter_kind(daft_frame *frame, int kind)
{
    const int threads = frame->renderer->threads;
    frame->filtered = kind, frame->filter_pass = 0;
    daft_parallel_for(threads, frame->tile_count, noise_task, frame);
    daft_parallel_for(threads, frame->tile_count, spread_task, frame);
    for (; frame->filter_pass < PASSES; frame->filter_pass++)
        daft_parallel_for(threads, frame->tile_count, pass_task, frame);
}

bool daft_denoise(daft_frame *frame, daft_error *error)
{
    const daft_renderer *r = frame->renderer;
    const daft_snapshot *s = frame->snapshot;
    int noisy = 0;
    if (!frame->plan.denoise) return true;
    for (uint32_t i = 0; i < frame->tile_count; i++) noisy |= r->noisy[i];
    if (s->past) {
        const int kinds =
            (frame->plan.samples_light ? DAFT_NOISY_LIGHT : 0) | (frame->plan.glossy ? DAFT_NOISY_GLOSS : 0);
        frame->filtered = kinds;
        daft_parallel_for(r->threads, frame->tile_count, reuse_task, frame);
        const bool whole = s->row_count == s->height && !atomic_load(&frame->cancelled);
        if (whole && kinds & DAFT_NOISY_LIGHT) daft_past_turn(&s->past[DAFT_PAST_LIGHT]);
        if (whole && kinds & DAFT_NOISY_GLOSS) daft_past_turn(&s->past[DAFT_PAST_GLOSS]);
    }
    for (int kind = DAFT_NOISY_LIGHT; kind <= DAFT_NOISY_GLOSS; kind++)
        if (noisy & kind) filter_kind(frame, kind);
    daft_parallel_for(r->threads, frame->tile_count, finish_task, frame);
    return !atomic_load(&frame->cancelled) || daft_fail(error, DAFT_ERROR_CANCELLED, "rendering was stopped");
}

/* ---- more samples of some pixels ---- */

/* Reflections that facets scatter over fewer pixels are nearly sharp: their own edges may lie in a pixel. */
#define LEAST_REACH 4.0f

/* How much a pixel of the picture is like a point: 0, if it sees another instance or nothing of the kind was sampled
 * there, or what was shows too sharply. */
static float alike(const tile_job *j, int kind, int x, int y, const seen_plane *point, size_t *at)
{
    const daft_grid *g = &j->frame->grid;
    const int row = y - first_row(j->frame), columns = (int)daft_tile_columns(j->snapshot);
    const int inverse = kind == DAFT_NOISY_GLOSS ? GLOSS + KIND_INVERSE : INVERSE;
    if (x < 0 || x >= j->snapshot->width || row < 0 || row >= g->rows) return 0;
    if (!(j->r->noisy[row / DAFT_TILE * columns + x / DAFT_TILE] & kind)) return 0;
    *at = (size_t)row * (size_t)g->stride + (size_t)x;
    if (!(plane(g, inverse)[*at] > 0) || memcmp(&plane(g, SEEN)[*at], &point->instance, sizeof point->instance) != 0)
        return 0;
    if (kind == DAFT_NOISY_GLOSS && plane(g, REACH)[*at] < LEAST_REACH) return 0;
    float facing = 0;
    for (int c = 0; c < 3; c++) facing += plane(g, NORMAL + c)[*at] * point->normal[c];
    return facing > 0 ? facing * facing * facing * facing : 0;
}

typedef struct picture_place {
    int x, y;
} picture_place;

/* The pixel of the picture that a batch's point counts in. */
static picture_place place_of(const tile_job *j, const daft_batch *points, uint32_t i)
{
    const int place = (int)j->s->wanted[points->pixel[i]], columns = (int)daft_tile_columns(j->snapshot);
    return (picture_place){(int)j->number % columns * DAFT_TILE + place % DAFT_TILE,
                           (int)j->number / columns * DAFT_TILE + place / DAFT_TILE};
}

/* The filtered mean of the pixels around that are like a batch's point: the fraction of its light that arrives, or the
 * light that it shows. False: none is. */
static bool recall(const tile_job *j, int kind, const daft_batch *points, uint32_t i, float found[3])
{
    enum { AROUND = 9, OWN = 4 };
    const daft_grid *g = &j->frame->grid;
    const picture_place p = place_of(j, points, i);
    const daft_vec3 axes[3] = {j->snapshot->right, j->snapshot->up, j->snapshot->forward},
                    n = daft_v3(points->normal.x[i], points->normal.y[i], points->normal.z[i]);
    seen_plane point = {.instance = points->instance[i]};
    float sum = 0;
    for (int c = 0; c < 3; c++) point.normal[c] = daft_dot(n, axes[c]), found[c] = 0;
    for (int k = 0; k < AROUND; k++) {
        const int turn = (OWN + k) % AROUND; /* the pixel itself first: it is most often enough */
        const bool own = turn == OWN;
        size_t at = 0;
        const float weight = alike(j, kind, p.x + turn % 3 - 1, p.y + turn / 3 - 1, &point, &at);
        if (!(weight > 0)) continue;
        for (int c = 0; c < 3; c++) found[c] += weight * plane(g, first_plane(kind) + c)[at];
        sum += weight;
        if (own && weight > 0.8f) break;
    }
    for (int c = 0; c < 3; c++) found[c] = sum > 0 ? found[c] / sum : 0;
    return sum > 0;
}

/* The fraction of a pixel itself, which counts all that its paths meet; false: nothing was sampled there, or what a
 * rough surface shows was filtered apart. */
static bool recall_own(const tile_job *j, const daft_batch *points, uint32_t i, float fraction[3])
{
    const daft_grid *g = &j->frame->grid;
    const picture_place p = place_of(j, points, i);
    const int row = p.y - first_row(j->frame), columns = (int)daft_tile_columns(j->snapshot);
    const size_t at = (size_t)row * (size_t)g->stride + (size_t)p.x;
    if (!(j->r->noisy[row / DAFT_TILE * columns + p.x / DAFT_TILE] & DAFT_NOISY_LIGHT)) return false;
    if (!(plane(g, INVERSE)[at] > 0)) return false;
    if (j->frame->plan.glossy && plane(g, GLOSS + KIND_INVERSE)[at] > 0) return false;
    for (int c = 0; c < 3; c++) fraction[c] = plane(g, LIGHT + c)[at];
    return true;
}

void daft_denoise_recall(const tile_job *j, const daft_batch *points, bool seen)
{
    daft_sampled_light *light = j->s->sampled;
    memset(light->recalled, 0, sizeof light->recalled);
    for (uint32_t i = 0; i < points->count; i++) {
        float fraction[3];
        if (!(seen ? recall(j, DAFT_NOISY_LIGHT, points, i, fraction) : recall_own(j, points, i, fraction))) continue;
        light->recalled[i / 32] |= 1u << (i % 32);
        light->fraction.x[i] = fraction[0], light->fraction.y[i] = fraction[1], light->fraction.z[i] = fraction[2];
    }
}

bool daft_denoise_recall_gloss(const tile_job *j, const daft_batch *points, uint32_t i, float light[3])
{
    return recall(j, DAFT_NOISY_GLOSS, points, i, light);
}

size_t daft_denoise_bytes(const daft_renderer *r) { return r->plane_capacity * sizeof *r->planes; }
