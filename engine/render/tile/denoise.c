/* Denoising: what was sampled with few rays (tile/soft.c) is filtered before it becomes part of the picture. Filtered
 * is the fraction of sampled light that arrives (Heitz, Hill, McGuire, "Combining Analytic Direct Illumination and
 * Stochastic Shadows", I3D 2018): the light itself, with its textures, highlights and other lights' sharp shadows,
 * stays as it is.
 *
 * Tiles at work write what the filter needs into planes; where a tile has sampled nothing, or the picture's margin, the
 * inverse depth is 0 and the filter looks away. Then each pass of the filter goes over all tiles that have, and the
 * last step makes their bytes. */
#include "render/denoise.h"
#include "render/tile/tile.h"

#include <string.h>

enum { MARGIN = 16, PASSES = 4 }; /* columns on either side, and room for a register on the right */
enum { FROM = 0, TO = 3, FROM_VARIANCE = 6, TO_VARIANCE, NORMAL, INVERSE = 11, WHOLE, SHARP = 15, SEEN = 18, PLANES };

static ptrdiff_t stride_of(const daft_snapshot *s) { return (ptrdiff_t)daft_tile_columns(s) * DAFT_TILE + 3 * MARGIN; }

static size_t plane_size(const daft_frame *frame)
{
    return (size_t)stride_of(frame->snapshot) * (frame->tile_count / daft_tile_columns(frame->snapshot)) * DAFT_TILE;
}

/* The first float of the running pass's first tile in a plane. */
static float *plane(const daft_frame *frame, int number)
{
    return frame->renderer->planes + (size_t)number * frame->plane_size + MARGIN;
}

bool daft_denoise_prepare(daft_frame *frame, daft_error *error)
{
    daft_renderer *r = frame->renderer;
    daft_past *past = frame->snapshot->past;
    if (!frame->plan.denoise && past) past->some = false;
    if (!frame->plan.denoise) return true;
    const size_t size = plane_size(frame), stride = (size_t)stride_of(frame->snapshot);
    const size_t before = r->plane_capacity;
    frame->plane_size = size;
    if (!daft_grow(&r->allocator, &r->planes, &r->plane_capacity, PLANES * size, 0, sizeof *r->planes) ||
        !daft_grow(&r->allocator, &r->noisy, &r->noisy_capacity, frame->tile_count, 0, sizeof *r->noisy))
        return daft_fail_memory(error, "what is denoised");
    if (before != r->plane_capacity || stride != r->plane_stride || size != r->plane_size)
        memset(r->planes, 0, PLANES * size * sizeof *r->planes); /* margins stay 0 */
    r->plane_stride = stride, r->plane_size = size;
    return !past || daft_past_prepare(past, &r->allocator, frame->snapshot, error);
}

/* Where the tile's first pixel is in a plane. */
static size_t tile_place(const daft_frame *frame, uint32_t number)
{
    const uint32_t columns = daft_tile_columns(frame->snapshot), at = number - frame->first_tile;
    return at / columns * DAFT_TILE * (size_t)stride_of(frame->snapshot) + at % columns * DAFT_TILE;
}

void daft_denoise_begin(const tile_job *j)
{
    const daft_frame *frame = j->frame;
    float *inverse = plane(frame, INVERSE) + tile_place(frame, j->number);
    for (int y = 0; y < DAFT_TILE; y++)
        memset(inverse + y * stride_of(frame->snapshot), 0, DAFT_TILE * sizeof *inverse);
    j->r->noisy[j->number - frame->first_tile] = false;
}

/* The planes that pixels see. */
void daft_denoise_see(const tile_job *j)
{
    const daft_frame *frame = j->frame;
    const daft_snapshot *s = j->snapshot;
    const daft_batch *b = &j->s->points;
    const size_t first = tile_place(frame, j->number), stride = (size_t)stride_of(s);
    float *const normal[3] = {plane(frame, NORMAL), plane(frame, NORMAL + 1), plane(frame, NORMAL + 2)},
                 *inverse = plane(frame, INVERSE), *seen = plane(frame, SEEN);
    const daft_vec3 axes[3] = {s->right, s->up, s->forward};
    for (uint32_t i = 0; i < b->count; i++) {
        const uint32_t x = b->pixel[i] % DAFT_TILE, y = b->pixel[i] / DAFT_TILE;
        const size_t at = first + y * stride + x;
        const daft_vec3 ray = daft_pencil_ray(&frame->pencil, j->s->tile.x + (int)x, j->s->tile.y + (int)y),
                        n = daft_v3(b->normal.x[i], b->normal.y[i], b->normal.z[i]);
        const float found = sqrtf(daft_dot(ray, ray)) / (b->distance[i] * s->focal);
        for (int c = 0; c < 3; c++) normal[c][at] = daft_dot(n, axes[c]);
        inverse[at] = found < 0x1p60f ? found : 0;
        memcpy(&seen[at], &b->instance[i], sizeof *seen);
    }
}

/* A batch's sampled light, as far as it arrives at the pixels. */
void daft_denoise_take(const tile_job *j, const daft_batch *points, bool seen)
{
    daft_sampled_light *light = j->s->sampled;
    bool *noisy = &j->r->noisy[j->number - j->frame->first_tile];
    if (!*noisy) {
        memset(&light->tile_whole, 0, sizeof light->tile_whole);
        memset(&light->tile_arrived, 0, sizeof light->tile_arrived);
        *noisy = true;
    }
    const float *const weight[3] = {points->weight.x, points->weight.y, points->weight.z};
    const float *const whole[3] = {light->whole.x, light->whole.y, light->whole.z}, *const arrived[3] = {
                                                                                        light->arrived.x,
                                                                                        light->arrived.y,
                                                                                        light->arrived.z};
    float *const to_whole[3] = {light->tile_whole.x, light->tile_whole.y, light->tile_whole.z},
                 *const to_arrived[3] = {light->tile_arrived.x, light->tile_arrived.y, light->tile_arrived.z};
    for (int c = 0; c < 3; c++)
        for (uint32_t i = 0; i < points->count; i++) {
            const uint32_t pixel = points->pixel[i];
            const float share = seen ? 1 : weight[c][i];
            to_whole[c][pixel] += whole[c][i] * share, to_arrived[c][pixel] += arrived[c][i] * share;
        }
}

/* Rays of a point, the fewer where there are two kinds. */
static int samples_of(const daft_frame *frame)
{
    const daft_preset *p = frame->plan.preset;
    if (!frame->plan.soft) return p->occlusion_samples;
    return frame->plan.occlusion ? daft_min_i(p->shadow_samples, p->occlusion_samples) : p->shadow_samples;
}

/* The light without what is sampled, as long as that is filtered, and the fraction of that which arrives. */
bool daft_denoise_keep(const tile_job *j)
{
    const daft_frame *frame = j->frame;
    const daft_sampled_light *light = j->s->sampled;
    const size_t first = tile_place(frame, j->number);
    if (!j->r->noisy[j->number - frame->first_tile]) {
        daft_denoise_begin(j);
        return false;
    }
    const float *const color[3] = {j->color->x, j->color->y, j->color->z},
                       *const whole[3] = {light->tile_whole.x, light->tile_whole.y, light->tile_whole.z},
                       *const arrived[3] = {light->tile_arrived.x, light->tile_arrived.y, light->tile_arrived.z};
    /* Rays of a point are stratified: the variance of their mean falls with the square of their number, about. */
    const float rays = (float)samples_of(frame), share = 1 / (rays * rays);
    for (int y = 0; y < DAFT_TILE; y++) {
        const size_t row = first + (size_t)(y * stride_of(frame->snapshot));
        float some[DAFT_TILE] = {0}, *inverse = plane(frame, INVERSE) + row;
        for (int c = 0; c < 3; c++) {
            const float *all = whole[c] + y * DAFT_TILE, *part = arrived[c] + y * DAFT_TILE;
            float *ratio = plane(frame, FROM + c) + row;
            for (int x = 0; x < DAFT_TILE; x++) {
                const float found = part[x] / all[x];
                ratio[x] = found >= 0 && found <= 1 ? found : 1; /* 0/0 and what overflows, too */
                some[x] += all[x];
            }
            memcpy(plane(frame, WHOLE + c) + row, all, DAFT_TILE * sizeof(float));
            memcpy(plane(frame, SHARP + c) + row, color[c] + y * DAFT_TILE, DAFT_TILE * sizeof(float));
        }
        float *variance = plane(frame, FROM_VARIANCE) + row;
        for (int x = 0; x < DAFT_TILE; x++) inverse[x] = some[x] > 0 ? inverse[x] : 0, variance[x] = share;
    }
    return true;
}

/* ---- passes ---- */

/* Rows of the band alone are remembered. */
static void reuse_task(void *context, uint32_t index, uint32_t worker)
{
    daft_frame *frame = context;
    const daft_snapshot *s = frame->snapshot;
    if (atomic_load_explicit(&frame->cancelled, memory_order_relaxed)) return;
    const uint64_t since = daft_clock_ticks();
    const tile_job j = daft_tile_again(frame, index, worker);
    const daft_tile *tile = &j.s->tile;
    const size_t first = tile_place(frame, j.number), stride = (size_t)stride_of(s);
    for (int y = 0; y < tile->height; y++)
        for (int x = 0; x < tile->width; x++) {
            const size_t at = first + (size_t)y * stride + (size_t)x;
            daft_seen_pixel seen = {.x = tile->x + x, .y = tile->y + y, .inverse = plane(frame, INVERSE)[at]};
            float ratio[3];
            if (!frame->renderer->noisy[index] || !(seen.inverse > 0)) {
                daft_past_pixel_clear(s->past, seen.x, seen.y);
                continue;
            }
            seen.ray = daft_pencil_ray(&frame->pencil, seen.x, seen.y);
            memcpy(&seen.instance, &plane(frame, SEEN)[at], sizeof seen.instance);
            for (int c = 0; c < 3; c++) ratio[c] = plane(frame, FROM + c)[at];
            const float pictures = daft_past_pixel_reuse(s->past, s, &seen, ratio);
            plane(frame, FROM_VARIANCE)[at] /= pictures * pictures;
            for (int c = 0; c < 3; c++) plane(frame, FROM + c)[at] = ratio[c];
        }
    j.s->ticks[DAFT_EFFECT_DENOISE] += daft_clock_ticks() - since;
}

static daft_filter filter_of(const daft_frame *frame)
{
    const bool odd = frame->filter_pass % 2;
    const int from = odd ? TO : FROM, to = odd ? FROM : TO;
    const daft_vec3 ray =
        daft_pencil_ray(&frame->pencil, 0, (int)(frame->first_tile / daft_tile_columns(frame->snapshot)) * DAFT_TILE);
    daft_filter f = {.stride = stride_of(frame->snapshot),
                     .height = (int)(frame->tile_count / daft_tile_columns(frame->snapshot)) * DAFT_TILE,
                     .step = 1 << frame->filter_pass,
                     .left = ray.x,
                     .top = ray.y,
                     .focal = ray.z,
                     .inverse = plane(frame, INVERSE),
                     .from_variance = plane(frame, odd ? TO_VARIANCE : FROM_VARIANCE),
                     .to_variance = plane(frame, odd ? FROM_VARIANCE : TO_VARIANCE)};
    for (int c = 0; c < 3; c++)
        f.from[c] = plane(frame, from + c), f.to[c] = plane(frame, to + c), f.normal[c] = plane(frame, NORMAL + c);
    return f;
}

typedef void filter_kernel(const daft_filter *filter, int x, int y, int width, int height);

static void run(daft_frame *frame, uint32_t index, uint32_t worker, filter_kernel *kernel)
{
    if (!frame->renderer->noisy[index] || atomic_load_explicit(&frame->cancelled, memory_order_relaxed)) return;
    const uint32_t columns = daft_tile_columns(frame->snapshot);
    const daft_filter f = filter_of(frame);
    const uint64_t since = daft_clock_ticks();
    kernel(&f, (int)(index % columns) * DAFT_TILE, (int)(index / columns) * DAFT_TILE, DAFT_TILE, DAFT_TILE);
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

/* The light of a tile's pixels: what is sharp, and what is sampled times its filtered fraction. */
static void finish_task(void *context, uint32_t index, uint32_t worker)
{
    daft_frame *frame = context;
    daft_renderer *r = frame->renderer;
    if (!r->noisy[index]) return;
    daft_scratch *s = &r->scratch[worker];
    tile_job j = daft_tile_again(frame, index, worker);
    j.refines = false, j.color = &s->color;
    const size_t first = tile_place(frame, j.number);
    const int from = PASSES % 2 ? TO : FROM;
    float *const color[3] = {s->color.x, s->color.y, s->color.z};
    for (int c = 0; c < 3; c++)
        for (int y = 0; y < DAFT_TILE; y++) {
            const size_t row = first + (size_t)(y * stride_of(frame->snapshot));
            const float *ratio = plane(frame, from + c) + row, *whole = plane(frame, WHOLE + c) + row,
                        *sharp = plane(frame, SHARP + c) + row, *inverse = plane(frame, INVERSE) + row;
            for (int x = 0; x < DAFT_TILE; x++)
                color[c][y * DAFT_TILE + x] = sharp[x] + (inverse[x] > 0 ? whole[x] * ratio[x] : 0);
        }
    daft_tile_resolve(&j);
    s->tiles[DAFT_EFFECT_DENOISE]++;
}

bool daft_denoise(daft_frame *frame, daft_error *error)
{
    daft_renderer *r = frame->renderer;
    if (!frame->plan.denoise) return true;
    if (frame->snapshot->past) {
        daft_parallel_for(r->threads, frame->tile_count, reuse_task, frame);
        if (frame->snapshot->row_count == frame->snapshot->height) daft_past_turn(frame->snapshot->past);
    }
    frame->filter_pass = 0;
    daft_parallel_for(r->threads, frame->tile_count, noise_task, frame);
    daft_parallel_for(r->threads, frame->tile_count, spread_task, frame);
    for (frame->filter_pass = 0; frame->filter_pass < PASSES; frame->filter_pass++)
        daft_parallel_for(r->threads, frame->tile_count, pass_task, frame);
    daft_parallel_for(r->threads, frame->tile_count, finish_task, frame);
    return !atomic_load(&frame->cancelled) || daft_fail(error, DAFT_ERROR_CANCELLED, "rendering was stopped");
}

size_t daft_denoise_bytes(const daft_renderer *r) { return r->plane_capacity * sizeof *r->planes; }
