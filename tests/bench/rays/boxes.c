/* Visibility by projected boxes alone: each triangle is drawn as the rectangle of pixels it may cover, at the depth of
 * its nearest corner, and the nearest rectangle wins. The pencil starts from these boxes; this file measures
 * the time and the error without the ray test. Instances are projected in parallel into bands of rows, and bands are
 * drawn in parallel. */
#include "harness/scenes.h"

#include <string.h>

enum { BAND = 16 };
#define NEAREST 1e-4f /* metres in front of the camera: the near plane */

typedef struct box {
    uint64_t seen;
    float z;
    int16_t x0, x1, y0, y1;
} box;

typedef struct band {
    box *boxes;
    size_t count, capacity;
} band;

struct bench_boxes {
    daft_allocator allocator;
    const bench_scene *scene;
    int bands, workers;
    band *found;  /* of each worker: one for each band */
    float *depth; /* of each pixel */
    uint64_t *seen;
    bool failed;
};

typedef struct bounds {
    float x0, x1, y0, y1, z;
} bounds;

static void take(bounds *b, daft_vec3 p, float focal)
{
    float scale = focal / p.z, x = p.x * scale, y = p.y * scale;
    b->x0 = x < b->x0 ? x : b->x0, b->x1 = x > b->x1 ? x : b->x1;
    b->y0 = y < b->y0 ? y : b->y0, b->y1 = y > b->y1 ? y : b->y1;
    b->z = p.z < b->z ? p.z : b->z;
}

/* The part of a triangle in front of the near plane. */
static bounds triangle_bounds(const daft_vec3 corner[3], float focal)
{
    bounds b = {INFINITY, -INFINITY, INFINITY, -INFINITY, INFINITY};
    for (int k = 0; k < 3; k++) {
        daft_vec3 p = corner[k], q = corner[(k + 1) % 3];
        if (p.z >= NEAREST) take(&b, p, focal);
        if ((p.z < NEAREST) == (q.z < NEAREST)) continue;
        daft_vec3 cut = daft_add(p, daft_scale(daft_sub(q, p), (NEAREST - p.z) / (q.z - p.z)));
        cut.z = NEAREST;
        take(&b, cut, focal);
    }
    return b;
}

static bounds sphere_bounds(daft_vec3 c, float radius, float focal)
{
    bounds b = {INFINITY, -INFINITY, INFINITY, -INFINITY, INFINITY};
    if (c.z - radius < NEAREST) return b;
    float half = focal * radius / sqrtf(c.z * c.z - radius * radius), x = focal * c.x / c.z, y = focal * c.y / c.z;
    return (bounds){x - half, x + half, y - half, y + half, c.z - radius};
}

/* The pixels whose centres lie within the triangle's bounds; false: none. */
static bool pixels_of(const bench_view *view, const bounds *b, box *out)
{
    float w = (float)view->width * 0.5f - 0.5f, h = (float)view->height * 0.5f - 0.5f;
    float x0 = ceilf(b->x0 + w), x1 = floorf(b->x1 + w), y0 = ceilf(h - b->y1), y1 = floorf(h - b->y0);
    x0 = x0 > 0 ? x0 : 0, y0 = y0 > 0 ? y0 : 0;
    x1 = x1 < 2 * w ? x1 : 2 * w, y1 = y1 < 2 * h ? y1 : 2 * h;
    if (!(x0 <= x1) || !(y0 <= y1)) return false;
    out->z = b->z;
    out->x0 = (int16_t)x0, out->x1 = (int16_t)x1, out->y0 = (int16_t)y0, out->y1 = (int16_t)y1;
    return true;
}

static void keep(bench_boxes *job, const box *b, uint32_t worker)
{
    for (int i = b->y0 / BAND; i <= b->y1 / BAND; i++) {
        band *to = &job->found[(int)worker * job->bands + i];
        if (!daft_grow(&job->allocator, &to->boxes, &to->capacity, to->count + 1, to->count, sizeof *to->boxes)) {
            job->failed = true;
            return;
        }
        to->boxes[to->count++] = *b;
    }
}

static daft_vec3 to_view(const bench_view *view, daft_vec3 p)
{
    return daft_v3(daft_dot(view->right, p), daft_dot(view->up, p), daft_dot(view->forward, p));
}

static bool beyond_sides(const bench_view *view, const daft_instance *instance)
{
    daft_vec3 half = daft_scale(daft_sub(instance->high, instance->low), 0.5f);
    daft_vec3 c = to_view(view, daft_add(instance->low, half));
    float r = daft_length(half), w = (float)view->width * 0.5f, h = (float)view->height * 0.5f, f = view->focal;
    return c.z < -r || (fabsf(c.x) * f - c.z * w) > r * sqrtf(f * f + w * w) ||
           (fabsf(c.y) * f - c.z * h) > r * sqrtf(f * f + h * h);
}

static void project_task(void *context, uint32_t index, uint32_t worker)
{
    bench_boxes *job = context;
    const bench_view *view = &job->scene->view;
    daft_instance instance = bench_engine_instance(job->scene, index);
    if (beyond_sides(view, &instance)) return;
    box out = {.seen = (uint64_t)index << 32};
    if (!instance.mesh) {
        bounds b = sphere_bounds(
            to_view(view, daft_v3(instance.to_frame.t[0], instance.to_frame.t[1], instance.to_frame.t[2])),
            instance.radius, view->focal);
        if (pixels_of(view, &b, &out)) keep(job, &out, worker);
        return;
    }
    const daft_trimesh *mesh = instance.mesh;
    for (uint32_t i = 0; i < mesh->triangle_count && !job->failed; i++) {
        daft_vec3 corner[3];
        for (int k = 0; k < 3; k++) {
            uint32_t v = mesh->indices[3 * (size_t)i + (size_t)k];
            corner[k] =
                to_view(view, daft_affine_point(&instance.to_frame, daft_v3(mesh->x[v], mesh->y[v], mesh->z[v])));
        }
        bounds b = triangle_bounds(corner, view->focal);
        out.seen = (uint64_t)index << 32 | i;
        if (pixels_of(view, &b, &out)) keep(job, &out, worker);
    }
}

/* Ties go to the lower number, so that the order of drawing does not matter. */
static void draw(bench_boxes *job, const box *b, int y0, int y1)
{
    for (int y = daft_max_i(b->y0, y0); y <= daft_min_i(b->y1, y1); y++) {
        size_t row = (size_t)y * (size_t)job->scene->view.width;
        float *depth = job->depth + row;
        uint64_t *seen = job->seen + row;
        for (int x = b->x0; x <= b->x1; x++) {
            if (b->z > depth[x] || (b->z == depth[x] && b->seen > seen[x])) continue;
            depth[x] = b->z;
            seen[x] = b->seen;
        }
    }
}

static void draw_task(void *context, uint32_t index, uint32_t worker)
{
    (void)worker;
    bench_boxes *job = context;
    const bench_view *view = &job->scene->view;
    int y0 = (int)index * BAND, y1 = daft_min_i(y0 + BAND, view->height) - 1;
    size_t first = (size_t)y0 * (size_t)view->width, end = (size_t)(y1 + 1) * (size_t)view->width;
    for (size_t i = first; i < end; i++) job->depth[i] = INFINITY, job->seen[i] = BENCH_NOTHING;
    for (int w = 0; w < job->workers; w++) {
        const band *found = &job->found[w * job->bands + (int)index];
        for (size_t i = 0; i < found->count; i++) draw(job, &found->boxes[i], y0, y1);
    }
}

double bench_boxes_see(bench_boxes *job, uint64_t *seen)
{
    double start = bench_clock_ms(job->workers);
    job->seen = seen;
    for (int i = 0; i < job->workers * job->bands; i++) job->found[i].count = 0;
    daft_parallel_for(job->workers, job->scene->instance_count, project_task, job);
    daft_parallel_for(job->workers, (uint32_t)job->bands, draw_task, job);
    return job->failed ? -1 : bench_clock_ms(job->workers) - start;
}

bench_boxes *bench_boxes_create(bench *self, const bench_scene *scene, int threads)
{
    bench_boxes *job = daft_alloc_zero(&self->allocator, 1, sizeof *job);
    if (!job) return NULL;
    job->allocator = self->allocator;
    job->scene = scene;
    job->workers = threads;
    job->bands = (scene->view.height + BAND - 1) / BAND;
    job->found = daft_alloc_zero(&self->allocator, (size_t)(threads * job->bands), sizeof *job->found);
    job->depth =
        daft_alloc(&self->allocator, (size_t)scene->view.width * (size_t)scene->view.height, sizeof *job->depth);
    if (job->found && job->depth) return job;
    bench_boxes_destroy(job);
    return NULL;
}

void bench_boxes_destroy(bench_boxes *job)
{
    if (!job) return;
    daft_allocator allocator = job->allocator;
    for (int i = 0; job->found && i < job->workers * job->bands; i++) daft_release(&allocator, job->found[i].boxes);
    daft_release(&allocator, job->found);
    daft_release(&allocator, job->depth);
    daft_release(&allocator, job);
}
