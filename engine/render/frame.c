/* A frame: the plan, then for each sample the pencil's three passes and the tiles. */
#include "math/trig.h"
#include "render/internal.h"
#include "render/redraw.h"

#include <string.h>

static const char *const EFFECT_NAMES[DAFT_EFFECT_COUNT] = {
    "visibility", "surface", "texture",      "shadow",    "lighting", "reflection", "refraction",
    "sky",        "resolve", "antialiasing", "occlusion", "denoise",  "fog"};

static const daft_render_kernels *kernels_for(int isa)
{
    static const daft_render_kernels *const TABLE[DAFT_ISA_COUNT] = DAFT_KERNEL_TABLE(daft_render);
    return TABLE[isa];
}

daft_renderer *daft_renderer_create(const daft_allocator *allocator, int threads, int isa, daft_error *error)
{
    daft_renderer *r = daft_alloc_zero(allocator, 1, sizeof *r);
    if (!r) {
        daft_fail_memory(error, "the renderer");
        return NULL;
    }
    r->allocator = *allocator;
    r->threads = threads;
    r->isa = isa;
    r->accel = daft_accel_kernels_for(isa);
    r->raster_kernels = daft_raster_kernels_for(isa);
    r->sample_kernels = daft_sample_kernels_for(isa);
    r->shade = daft_shade_kernels_for(isa);
    r->kernels = kernels_for(isa);
    daft_arena_init(&r->arena, &r->allocator);
    for (int i = 0; i < 1 << DAFT_TURN_BITS; i++) {
        const double angle = 2 * DAFT_PI * i / (1 << DAFT_TURN_BITS);
        r->turns[i] = (daft_vec2){(float)daft_cos(angle), (float)daft_sin(angle)};
    }
    r->scratch = daft_alloc_zero(allocator, (size_t)threads, sizeof *r->scratch);
    r->sample_scratch = daft_alloc_zero(allocator, (size_t)threads, r->sample_kernels->scratch_size);
    bool some = r->scratch && r->sample_scratch;
    if (some && daft_raster_init(&r->raster, &r->allocator, threads, isa, error)) return r;
    if (!some) daft_fail_memory(error, "the renderer");
    daft_renderer_destroy(r);
    return NULL;
}

void daft_renderer_destroy(daft_renderer *r)
{
    if (!r) return;
    daft_allocator allocator = r->allocator;
    daft_raster_free(&r->raster);
    daft_arena_free(&r->arena);
    daft_release(&allocator, r->scratch);
    daft_release(&allocator, r->sample_scratch);
    daft_release(&allocator, r->passed);
    daft_release(&allocator, r->meter);
    daft_release(&allocator, r->sampled);
    daft_release(&allocator, r->gloss);
    daft_release(&allocator, r->third);
    daft_release(&allocator, r->varying);
    daft_release(&allocator, r->footprints);
    daft_release(&allocator, r->refracted);
    daft_release(&allocator, r->crossings);
    daft_release(&allocator, r->media);
    daft_mirrors_free(r);
    daft_release(&allocator, r->sum);
    daft_release(&allocator, r->edges);
    daft_release(&allocator, r->ids);
    daft_release(&allocator, r->own);
    daft_release(&allocator, r->apron);
    daft_release(&allocator, r->smooth);
    daft_release(&allocator, r->planes);
    daft_release(&allocator, r->noisy);
    daft_release(&allocator, r->corners);
    daft_release(&allocator, r);
}

/* Where in the pixel a sample lies. Four: a rotated grid; eight and sixteen: each column and each row of an 8 × 8 or
 * 16 × 16 grid holds one. */
static void sample_shift(int samples, int i, float *x, float *y)
{
    static const float FOUR[4][2] = {{-0.125f, -0.375f}, {0.375f, -0.125f}, {0.125f, 0.375f}, {-0.375f, 0.125f}};
    *x = *y = 0;
    if (samples == 4) *x = FOUR[i][0], *y = FOUR[i][1];
    if (samples == 8) {
        static const int ROW[8] = {2, 5, 0, 7, 3, 6, 1, 4};
        *x = (float)i / 8 - 0.4375f, *y = (float)ROW[i] / 8 - 0.4375f;
    }
    if (samples == 16) {
        *x = (float)(i % 4) / 4 + (float)(i / 4) / 16 - 0.46875f;
        *y = (float)(i / 4) / 4 + (float)(i % 4) / 16 - 0.46875f;
    }
}

static void bin_task(void *context, uint32_t index, uint32_t worker)
{
    const daft_frame *frame = context;
    if (!atomic_load_explicit(&frame->cancelled, memory_order_relaxed))
        daft_raster_bin(&frame->renderer->raster, index, worker);
}

static void count_bins(const daft_renderer *r, daft_counters *c)
{
    for (int i = 0; i < r->threads; i++) {
        const daft_bins *bins = &r->raster.bins[i];
        c->triangles_tested += bins->tested;
        c->triangles_binned += bins->binned;
        c->spheres_binned += bins->spheres;
        c->exact_edges += bins->exact_edges;
        c->exact_depths += bins->exact_depths;
        c->instances_seen += bins->visible;
    }
    c->effects[DAFT_EFFECT_VISIBILITY].bytes += daft_raster_bytes(&r->raster);
}

static bool out_of_memory(const daft_renderer *r)
{
    for (int i = 0; i < r->threads; i++)
        if (r->raster.bins[i].out_of_memory) return true;
    return false;
}

/* Refracted rays are queued, in batches of their own for each depth: mirrored rays are followed first. */
static bool prepare_refractions(daft_frame *frame, daft_error *error)
{
    daft_renderer *r = frame->renderer;
    if (!frame->plan.refracts) return true;
    const size_t lists = (size_t)(frame->plan.through_depth * frame->plan.through_lists);
    const size_t all = lists * (size_t)r->threads;
    if (!daft_grow(&r->allocator, &r->refracted, &r->refracted_capacity, all, 0, sizeof *r->refracted))
        return daft_fail_memory(error, "refracted rays");
    for (size_t i = 0; i < all; i++) r->refracted[i].count = 0;
    for (int i = 0; i < r->threads; i++) r->scratch[i].refracted = r->refracted + (size_t)i * lists;
    return true;
}

/* Builds the TLAS where visible instances may spawn rays or lights cast shadows. The frame's other samples reuse it,
 * and so do later frames while no instance and no camera moves. */
static bool prepare_tree(daft_frame *frame, daft_error *error)
{
    daft_renderer *r = frame->renderer;
    const daft_snapshot *s = frame->snapshot;
    bool asked = frame->plan.shadows || frame->plan.occlusion || frame->plan.reflects || frame->plan.refracts ||
                 s->quality.tree != DAFT_TREE_RASTER || (frame->plan.media && daft_media_near_eye(s));
    if (!asked) return true;
    const daft_tlas_def def = {.intersection = s->quality.visibility, .threads = r->threads, .isa = r->isa};
    if (!r->tlas) r->tlas = daft_tlas_build_for(&r->arena, s->instances, s->instance_count, &def, error);
    if (!r->tlas) r->revision = 0; /* half of one is forgotten, too */
    frame->tlas = r->tlas;
    return frame->tlas != NULL;
}

/* The tiles of the band, and of so many rows above and below it. */
static void choose_rows(daft_frame *frame, int apron)
{
    const daft_snapshot *s = frame->snapshot;
    const uint32_t tiles_x = daft_tile_columns(s);
    int first = daft_max_i(s->first_row - apron, 0), end = daft_min_i(s->first_row + s->row_count + apron, s->height);
    frame->first_tile = tiles_x * (uint32_t)(first / DAFT_TILE);
    frame->tile_count = tiles_x * (uint32_t)((end - first + DAFT_TILE - 1) / DAFT_TILE);
}

/* Rows above and below the band that decide about its pixels. */
static int apron_of(const daft_frame *frame) { return frame->edge_scale || frame->plan.denoise ? DAFT_TILE : 0; }

static void count_work(daft_frame *frame)
{
    choose_rows(frame, apron_of(frame));
    frame->tiles_in_all = frame->tile_count * (uint32_t)frame->snapshot->quality.samples;
    choose_rows(frame, 0);
    frame->band_tile = frame->first_tile;
    if (frame->edge_scale) frame->tiles_in_all += frame->tile_count;
    if (frame->tiles)
        frame->tiles_in_all =
            frame->listed * ((uint32_t)frame->snapshot->quality.samples + (frame->edge_scale ? 1 : 0));
}

/* Scaled coordinates of pixels are below 2^15, so very large pictures have no grids. */
static int edge_scale_of(const daft_snapshot *s)
{
    const bool grid = s->quality.edge_samples == 16 && daft_max_i(s->width, s->height) <= 32768 / 4;
    return grid ? 2 : s->quality.edge_samples ? 1 : 0;
}

/* Many samples of a pixel average a texture over its footprint, whichever way that is stretched. Where only edges get
 * them, an anisotropic filter does that for the rest. */
static daft_texture_filter filter_of(const daft_frame *frame)
{
    const daft_texture_filter asked = frame->snapshot->quality.texture_filter;
    return frame->edge_scale > 1 && asked == DAFT_TEXTURE_TRILINEAR ? DAFT_TEXTURE_ANISOTROPIC4 : asked;
}

static bool prepare_edges(daft_frame *frame, daft_error *error)
{
    daft_renderer *r = frame->renderer;
    const daft_snapshot *s = frame->snapshot;
    const size_t row = (size_t)s->width, rows = (size_t)s->row_count;
    const size_t apron = apron_of(frame) && s->row_count < s->height ? 2 * DAFT_TILE * 4 * row : 0;
    if (!daft_grow(&r->allocator, &r->apron, &r->apron_capacity, apron, 0, 1))
        return daft_fail_memory(error, "the rows around a band");
    if (!frame->edge_scale) return true;
    const bool corners = frame->edge_scale == 1;
    choose_rows(frame, 0);
    const bool more = s->first_row + s->row_count < s->height;
    const size_t packed = corners ? 0 : (size_t)frame->tile_count * (4 * DAFT_TILE * DAFT_TILE);
    frame->corner_tiles = frame->tile_count + (more ? daft_tile_columns(s) : 0);
    if (daft_grow(&r->allocator, &r->edges, &r->edge_capacity, frame->corner_tiles, 0, sizeof *r->edges) &&
        daft_grow(&r->allocator, &r->ids, &r->id_capacity, row * (rows + 2 * DAFT_TILE), 0, sizeof *r->ids) &&
        daft_grow(&r->allocator, &r->own, &r->own_capacity, frame->keeps_own ? row * (rows + 2 * DAFT_TILE) : 0, 0,
                  sizeof *r->own) &&
        daft_grow(&r->allocator, &r->corners, &r->corner_capacity, corners ? daft_corner_words(frame) : 0, 0,
                  sizeof *r->corners) &&
        daft_grow(&r->allocator, &r->smooth, &r->smooth_capacity, packed, 0, 1))
        return true;
    return daft_fail_memory(error, "the pixels at edges");
}

/* Samples at edges stand for less of their pixel, and are several: they need no samples along their footprint. */
static void begin_edges(daft_frame *frame)
{
    const daft_texture_filter asked = frame->snapshot->quality.texture_filter;
    if (frame->texture_filter == asked) return;
    frame->texture_filter = asked;
    for (int i = 0; i < frame->renderer->threads; i++) {
        daft_scratch *s = &frame->renderer->scratch[i];
        s->points.footprints = s->next.footprints = NULL;
        if (s->third) s->third->footprints = NULL;
    }
}

static bool render_edges(daft_frame *frame, daft_error *error)
{
    const int threads = frame->renderer->threads;
    const bool corners = frame->edge_scale == 1;
    choose_rows(frame, 0);
    begin_edges(frame);
    const uint32_t asked = frame->tiles ? frame->listed : corners ? frame->corner_tiles : frame->tile_count;
    daft_parallel_for(threads, asked, corners ? daft_corners_tile : daft_refine_tile, frame);
    if (atomic_load(&frame->cancelled)) return daft_fail(error, DAFT_ERROR_CANCELLED, "rendering was stopped");
    daft_parallel_for(threads, frame->tiles ? frame->mixed_count : frame->tile_count,
                      corners ? daft_mix_tile : daft_show_edges, frame);
    return true;
}

static bool render_sample(daft_frame *frame, daft_counters *counters, daft_error *error)
{
    daft_renderer *r = frame->renderer;
    const daft_snapshot *s = frame->snapshot;
    double start = daft_clock_ms();
    frame->pencil = (daft_pencil){.right = s->right,
                                  .up = s->up,
                                  .forward = s->forward,
                                  .focal = s->focal,
                                  .width = s->width,
                                  .height = s->height,
                                  .intersection = s->quality.visibility};
    float *x = &frame->pencil.shift_x, *y = &frame->pencil.shift_y;
    sample_shift(s->quality.samples, frame->sample, x, y);
    if (frame->edge_scale) frame->pencil.reach = 0.5f + fmaxf(fabsf(*x), fabsf(*y));
    if (!daft_raster_begin(&r->raster, &frame->pencil, s->instances, s->instance_count, error)) return false;
    daft_parallel_for(r->threads, r->raster.work_count, bin_task, frame);
    if (out_of_memory(r)) return daft_fail_memory(error, "the visible triangles");
    daft_plan_narrow(&frame->plan, s, &r->raster);
    r->raster.passes_holes = frame->plan.refracts && !daft_filter_is_anisotropic(frame->texture_filter) &&
                             !daft_filter_is_anisotropic(s->quality.texture_filter);
    const bool hard = s->quality.samples == 1 && s->quality.edge_samples == 0; /* the outlines of masks: all or none */
    r->raster.textures = hard && frame->texture_filter == DAFT_TEXTURE_TRILINEAR ? s->textures : NULL;
    if (!prepare_refractions(frame, error) || !prepare_tree(frame, error) || !daft_media_prepare(frame, error) ||
        !daft_mirrors_prepare(frame, error))
        return false;
    counters->effects[DAFT_EFFECT_VISIBILITY].ms += daft_clock_ms() - start;
    choose_rows(frame, apron_of(frame));
    if (frame->sample == 0 && !daft_denoise_prepare(frame, error)) return false;
    daft_parallel_for(r->threads, frame->tiles ? frame->listed : frame->tile_count, daft_render_tile, frame);
    if (frame->sample == s->quality.samples - 1 && !daft_denoise(frame, error)) return false;
    count_bins(r, counters);
    if (atomic_load(&frame->cancelled)) return daft_fail(error, DAFT_ERROR_CANCELLED, "rendering was stopped");
    return true;
}

static bool prepare_tints(daft_renderer *r, daft_error *error)
{
    if (!daft_grow(&r->allocator, &r->passed, &r->passed_capacity, (size_t)r->threads, 0, sizeof *r->passed))
        return daft_fail_memory(error, "the light that comes through");
    for (int i = 0; i < r->threads; i++) r->scratch[i].passed = &r->passed[i];
    return true;
}

/* Where rough surfaces send rays on: a batch more if there are several of a point, and what is filtered. */
static bool prepare_gloss(daft_renderer *r, const daft_plan *plan, daft_error *error)
{
    const size_t filtered = plan->glossy && plan->denoise ? (size_t)r->threads : 0,
                 several = plan->glossy && plan->quality->glossy_samples > 1 ? (size_t)r->threads : 0;
    if (!daft_grow(&r->allocator, &r->gloss, &r->gloss_capacity, filtered, 0, sizeof *r->gloss) ||
        !daft_grow(&r->allocator, &r->third, &r->third_capacity, several, 0, sizeof *r->third))
        return daft_fail_memory(error, "what rough surfaces show");
    for (int i = 0; i < r->threads; i++) {
        r->scratch[i].gloss = filtered ? &r->gloss[i] : NULL;
        r->scratch[i].third = several ? &r->third[i] : NULL;
        if (filtered) r->gloss[i].some = r->gloss[i].asks = false;
    }
    return true;
}

/* What varies over surfaces, of each batch of a worker. */
static bool prepare_varying(daft_renderer *r, const daft_plan *plan, daft_error *error)
{
    enum { BATCHES = 3 };
    const size_t all = plan->varies ? (size_t)r->threads * BATCHES : 0;
    if (!daft_grow(&r->allocator, &r->varying, &r->varying_capacity, all, 0, sizeof *r->varying))
        return daft_fail_memory(error, "what varies over surfaces");
    for (int i = 0; i < r->threads; i++) {
        daft_scratch *s = &r->scratch[i];
        daft_batch *const batches[BATCHES] = {&s->points, &s->next, s->third};
        for (int k = 0; k < BATCHES; k++)
            if (batches[k]) batches[k]->varying = all ? &r->varying[BATCHES * i + k] : NULL;
        s->facets.colors = plan->colors, s->facets.tangents = plan->tangents, s->facets.fades = plan->fades;
    }
    return true;
}

/* Where the filter of textures asks, of each batch of a worker. */
static bool prepare_footprints(const daft_frame *frame, daft_error *error)
{
    daft_renderer *r = frame->renderer;
    const daft_snapshot *snapshot = frame->snapshot;
    enum { BATCHES = 3 };
    const bool some = snapshot->texture_count && daft_filter_is_anisotropic(frame->texture_filter);
    const size_t all = some ? (size_t)r->threads * BATCHES : 0;
    if (!daft_grow(&r->allocator, &r->footprints, &r->footprint_capacity, all, 0, sizeof *r->footprints))
        return daft_fail_memory(error, "the footprints of pixels");
    for (int i = 0; i < r->threads; i++) {
        daft_scratch *s = &r->scratch[i];
        daft_batch *const batches[BATCHES] = {&s->points, &s->next, s->third};
        for (int k = 0; k < BATCHES; k++)
            if (batches[k]) batches[k]->footprints = all ? &r->footprints[BATCHES * i + k] : NULL;
        for (int k = 0; all && k < BATCHES; k++) r->footprints[BATCHES * i + k].spread = snapshot->quality.samples == 1;
    }
    return true;
}

static bool prepare_sampled(daft_renderer *r, bool some, daft_error *error)
{
    for (int i = 0; i < r->threads; i++) r->scratch[i].sampled = NULL;
    if (!some) return true;
    if (!daft_grow(&r->allocator, &r->sampled, &r->sampled_capacity, (size_t)r->threads, 0, sizeof *r->sampled))
        return daft_fail_memory(error, "the light that is sampled");
    for (int i = 0; i < r->threads; i++) r->scratch[i].sampled = &r->sampled[i];
    return true;
}

static void forget_tree(daft_renderer *r, const daft_snapshot *s)
{
    if (s->revision && s->revision == r->revision && s->quality.visibility == r->intersection) return;
    daft_arena_reset(&r->arena);
    r->tlas = NULL, r->revision = s->revision, r->intersection = s->quality.visibility;
}

static bool prepare(daft_frame *frame, daft_error *error)
{
    daft_renderer *r = frame->renderer;
    const daft_snapshot *s = frame->snapshot;
    forget_tree(r, s);
    for (int i = 0; i < r->threads; i++) {
        daft_scratch *scratch = &r->scratch[i];
        memset(scratch->ticks, 0, sizeof scratch->ticks);
        memset(scratch->tiles, 0, sizeof scratch->tiles);
        memset(scratch->rays_cast, 0, sizeof scratch->rays_cast);
        scratch->shadow_points = scratch->alpha_rays = scratch->alpha_reads = 0;
    }
    count_work(frame);
    if ((frame->plan.tints || frame->plan.filters) && !prepare_tints(r, error)) return false;
    if (!prepare_sampled(r, frame->plan.samples_light, error)) return false;
    if (!prepare_gloss(r, &frame->plan, error) || !prepare_varying(r, &frame->plan, error) ||
        !prepare_footprints(frame, error))
        return false;
    if (!prepare_edges(frame, error)) return false;
    size_t floats = s->quality.samples > 1 && !frame->plan.denoise ? 3 * (size_t)s->width * (size_t)s->height : 0;
    if (daft_grow(&r->allocator, &r->sum, &r->sum_capacity, floats, 0, sizeof *r->sum)) return true;
    return daft_fail_memory(error, "the samples of a picture");
}

/* The scene's textures with all their levels, and what their filter needs. */
static size_t texture_bytes(const daft_frame *frame)
{
    const daft_snapshot *s = frame->snapshot;
    const daft_renderer *r = frame->renderer;
    size_t bytes = r->scratch[0].points.footprints ? r->footprint_capacity * sizeof *r->footprints : 0;
    for (uint32_t i = 0; i < s->texture_count; i++) bytes += daft_texture_bytes(&s->textures[i]);
    return bytes;
}

/* The tree over instances is the first one's of the effects that ask for rays. */
static void count_bytes(const daft_frame *frame, daft_counters *c)
{
    static const daft_effect_kind ON_TREE[] = {DAFT_EFFECT_SHADOW, DAFT_EFFECT_OCCLUSION, DAFT_EFFECT_REFLECTION,
                                               DAFT_EFFECT_REFRACTION};
    const daft_renderer *r = frame->renderer;
    daft_effect *e = c->effects;
    for (size_t i = 0; i < DAFT_COUNT_OF(ON_TREE); i++) {
        if (!e[ON_TREE[i]].ran) continue;
        e[ON_TREE[i]].bytes = r->arena.bytes;
        break;
    }
    if (e[DAFT_EFFECT_SHADOW].ran && (frame->plan.tints || frame->plan.filters))
        e[DAFT_EFFECT_SHADOW].bytes += r->passed_capacity * sizeof *r->passed;
    if (e[DAFT_EFFECT_OCCLUSION].ran) e[DAFT_EFFECT_OCCLUSION].bytes += r->sampled_capacity * sizeof *r->sampled;
    if (e[DAFT_EFFECT_DENOISE].ran) e[DAFT_EFFECT_DENOISE].bytes = daft_denoise_bytes(r);
    if (e[DAFT_EFFECT_REFLECTION].ran) e[DAFT_EFFECT_REFLECTION].bytes += daft_mirrors_bytes(r);
    if (frame->plan.glossy && (e[DAFT_EFFECT_REFLECTION].ran || e[DAFT_EFFECT_REFRACTION].ran))
        e[e[DAFT_EFFECT_REFLECTION].ran ? DAFT_EFFECT_REFLECTION : DAFT_EFFECT_REFRACTION].bytes +=
            r->gloss_capacity * sizeof *r->gloss + r->third_capacity * sizeof *r->third;
    if (e[DAFT_EFFECT_REFRACTION].ran)
        e[DAFT_EFFECT_REFRACTION].bytes += r->refracted_capacity * sizeof *r->refracted + daft_media_bytes(r);
    if (frame->snapshot->quality.samples > 1 && !frame->plan.denoise)
        e[DAFT_EFFECT_RESOLVE].bytes = r->sum_capacity * sizeof *r->sum;
    if (e[DAFT_EFFECT_ANTIALIASING].ran)
        e[DAFT_EFFECT_ANTIALIASING].bytes = r->edge_capacity * sizeof *r->edges + r->id_capacity * sizeof *r->ids +
                                            r->own_capacity * sizeof *r->own + r->apron_capacity + r->smooth_capacity +
                                            r->corner_capacity * sizeof *r->corners;
    if (e[DAFT_EFFECT_TEXTURE].ran) e[DAFT_EFFECT_TEXTURE].bytes = texture_bytes(frame);
    e[DAFT_EFFECT_SURFACE].bytes = (size_t)r->threads * sizeof *r->scratch + r->varying_capacity * sizeof *r->varying;
}

/* `since`, `ticks`: the two clocks when the frame began. */
static void sum_effects(const daft_frame *frame, daft_counters *c, double since, uint64_t ticks)
{
    const daft_renderer *r = frame->renderer;
    double spent = (double)(daft_clock_ticks() - ticks), scale = spent > 0 ? (daft_clock_ms() - since) / spent : 0;
    for (int e = 0; e < DAFT_EFFECT_COUNT; e++) {
        daft_effect *effect = &c->effects[e];
        uint64_t sum = 0;
        effect->name = EFFECT_NAMES[e];
        for (int i = 0; i < r->threads; i++) {
            sum += r->scratch[i].ticks[e];
            effect->tiles += r->scratch[i].tiles[e];
            effect->rays += r->scratch[i].rays_cast[e];
        }
        effect->ms += (double)sum * scale / r->threads;
        effect->ran = effect->tiles > 0;
        effect->why = effect->ran ? frame->plan.why[e] : frame->plan.why_not_seen[e];
        if (!effect->ran) effect->ms = 0; /* what it took to find out belongs to nobody */
    }
    for (int i = 0; i < r->threads; i++) {
        c->shadow_points_kept += r->scratch[i].shadow_points;
        c->alpha_rays += r->scratch[i].alpha_rays, c->alpha_reads += r->scratch[i].alpha_reads;
    }
    c->camera_rays = c->effects[DAFT_EFFECT_VISIBILITY].rays + c->effects[DAFT_EFFECT_ANTIALIASING].rays;
    c->shadow_rays = c->effects[DAFT_EFFECT_SHADOW].rays;
    c->reflection_rays = c->effects[DAFT_EFFECT_REFLECTION].rays;
    c->refraction_rays = c->effects[DAFT_EFFECT_REFRACTION].rays;
    count_bytes(frame, c);
}

/* Keeps what the caller counts across frames. */
static void counters_begin(daft_counters *c, const daft_snapshot *s, const daft_renderer *r)
{
    const daft_counters kept = *c;
    memset(c, 0, sizeof *c);
    c->width = s->width, c->height = s->height, c->threads = r->threads;
    c->isa = kept.isa, c->query_rays = kept.query_rays, c->mesh_builds = kept.mesh_builds;
    c->mesh_refits = kept.mesh_refits, c->instance_updates = kept.instance_updates;
    c->poses = kept.poses, c->poses_unseen = kept.poses_unseen;
}

static bool render(daft_frame *frame, daft_counters *counters, daft_error *error)
{
    for (frame->sample = 0; frame->sample < frame->snapshot->quality.samples; frame->sample++)
        if (!render_sample(frame, counters, error)) return false;
    return !frame->edge_scale || render_edges(frame, error);
}

bool daft_render_frame(daft_renderer *renderer, const daft_snapshot *snapshot, const daft_frame_target *target,
                       daft_counters *counters, daft_error *error)
{
    double start = daft_clock_ms();
    uint64_t ticks = daft_clock_ticks();
    daft_snapshot metered;
    double metering = 0;
    if (snapshot->metered) {
        metered = *snapshot, snapshot = &metered;
        if (!daft_meter(renderer, &metered, &metering, error)) return false;
    }
    daft_frame frame = {.renderer = renderer, .snapshot = snapshot, .target = target, .plan = daft_plan_make(snapshot)};
    frame.edge_scale = edge_scale_of(snapshot);
    frame.texture_filter = filter_of(&frame);
    frame.keeps_own = frame.edge_scale > 1 && frame.texture_filter != DAFT_TEXTURE_NEAREST &&
                      frame.texture_filter != DAFT_TEXTURE_BILINEAR;
    counters_begin(counters, snapshot, renderer);
    if (!daft_redraw_begin(&frame, error) || !prepare(&frame, error)) return false;
    const bool some = !frame.tiles || frame.listed;
    if (some && !render(&frame, counters, error)) return false;
    if (!daft_redraw_end(&frame, error)) return false;
    counters->tiles_drawn = frame.tiles ? frame.listed : frame.tile_count;
    for (int e = 0; e < DAFT_EFFECT_COUNT && !some; e++) frame.plan.why_not_seen[e] = "nothing has changed";
    sum_effects(&frame, counters, start, ticks);
    counters->ev = (double)snapshot->tone.ev;
    counters->effects[DAFT_EFFECT_RESOLVE].ms += metering;
    counters->frame_ms = daft_clock_ms() - start;
    return true;
}
