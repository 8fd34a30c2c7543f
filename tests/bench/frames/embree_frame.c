/* A frame as an expert would write it with Embree: packets of 16 camera rays, and everything between them in 16 lanes
 * as well: points, smooth normals, facing, packets of 16 shadow rays to the light from what faces it, Lambert's law,
 * sRGB bytes by table. The same picture as frames.c's, but for rounding. Compiled for the processor that builds it. */
#include "harness/embree.h"

#ifdef DAFT_EMBREE
#include <math.h>
#include <string.h>

enum { SRGB_STEPS = 4096 };

typedef float lanes __attribute__((vector_size(64), aligned(64)));
typedef int32_t mask __attribute__((vector_size(64), aligned(64))); /* -1 or 0; also 16 indices */
typedef struct lanes3 {
    lanes x, y, z;
} lanes3;

/* What an instance's normals are read from, and how they are turned to the world. */
typedef struct shape {
    const float *normals; /* three a vertex; NULL: a sphere, whose geometric normal is right */
    const uint32_t *indices;
    float turn[9];
} shape;

typedef struct frame_job {
    const bench_embree *self;
    const bench_scene *scene;
    uint8_t *pixels;
    const shape *shapes;
    uint32_t srgb[SRGB_STEPS]; /* words, which are gathered */
} frame_job;

static lanes splat(float x) { return x - (lanes){0}; }
static lanes blend(mask m, lanes a, lanes b) { return (lanes)(((mask)a & m) | ((mask)b & ~m)); }
static lanes load(const float from[16])
{
    lanes x;
    memcpy(&x, from, sizeof x);
    return x;
}
static void store(lanes x, float to[16]) { memcpy(to, &x, sizeof x); }
static lanes dot(lanes3 a, lanes3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

static lanes root(lanes x)
{
    float r[16];
    store(x, r);
    for (int i = 0; i < 16; i++) r[i] = sqrtf(r[i]);
    return load(r);
}

static bool any(mask m)
{
    int32_t all = 0;
    for (int i = 0; i < 16; i++) all |= m[i];
    return all != 0;
}

/* The instance that each lane hits: 0 where there is none. */
static mask instances_hit(const bench_embree *self, const struct RTCRayHit16 *packet, mask hit)
{
    mask instance, geometry;
    memcpy(&instance, packet->hit.instID[0], sizeof instance);
    memcpy(&geometry, packet->hit.geomID, sizeof geometry);
    mask direct = (mask)(instance == -1);
    mask item = (geometry & direct) | (instance & ~direct);
    mask sphere = direct & (mask)(geometry == (int32_t)self->first_sphere);
    return ((item & ~sphere) | ((int32_t)self->first_sphere & sphere)) & hit;
}

/* The interpolated normal, where all lanes hit one instance of a mesh: its arrays are gathered from. */
static lanes3 normals_of_one(const shape *s, const struct RTCRayHit16 *packet, mask hit)
{
    lanes n[3];
    lanes u = load(packet->hit.u), v = load(packet->hit.v), w = splat(1) - u - v;
    mask triangle;
    memcpy(&triangle, packet->hit.primID, sizeof triangle);
    triangle &= hit;
    int32_t corner[3][16];
    for (int k = 0; k < 3; k++)
        for (int i = 0; i < 16; i++) corner[k][i] = 3 * (int32_t)s->indices[3 * triangle[i] + k];
    for (int axis = 0; axis < 3; axis++) {
        float c[3][16];
        for (int k = 0; k < 3; k++)
            for (int i = 0; i < 16; i++) c[k][i] = s->normals[corner[k][i] + axis];
        n[axis] = w * load(c[0]) + u * load(c[1]) + v * load(c[2]);
    }
    const float *m = s->turn;
    return (lanes3){m[0] * n[0] + m[1] * n[1] + m[2] * n[2], m[3] * n[0] + m[4] * n[1] + m[5] * n[2],
                    m[6] * n[0] + m[7] * n[1] + m[8] * n[2]};
}

/* Not unit; anything where nothing is hit. */
static lanes3 normals_hit(const frame_job *job, const struct RTCRayHit16 *packet, mask hit)
{
    lanes3 n = {load(packet->hit.Ng_x), load(packet->hit.Ng_y), load(packet->hit.Ng_z)};
    mask instances = instances_hit(job->self, packet, hit), left = hit;
    for (int i = 0; i < 16; i++) { /* once for each instance in the packet; mostly there is one */
        if (!left[i]) continue;
        mask same = (mask)(instances == instances[i]) & hit;
        left &= ~same;
        const shape *s = &job->shapes[instances[i]];
        if (!s->normals) continue;
        lanes3 smooth = normals_of_one(s, packet, same);
        n.x = blend(same, smooth.x, n.x), n.y = blend(same, smooth.y, n.y), n.z = blend(same, smooth.z, n.z);
    }
    return n;
}

/* Towards the viewer, unit. */
static lanes3 facing(lanes3 n, lanes3 direction)
{
    lanes length2 = dot(n, n), away = dot(n, direction);
    lanes sign = blend((mask)(away > 0), splat(-1), splat(1));
    lanes scale = blend((mask)(length2 > 0), sign / root(length2), splat(0)); /* finite where nothing is hit, too */
    return (lanes3){n.x * scale, n.y * scale, n.z * scale};
}

/* Lambert's cosine of each lit point, 0 of the others. */
static lanes light_reaching(const frame_job *job, lanes3 p, lanes3 n, mask hit)
{
    static const float ZEROS[16] = {0}, ONES[16] = {1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1};
    struct RTCRay16 rays __attribute__((aligned(64)));
    daft_vec3 light = job->scene->light;
    lanes3 to = {light.x - p.x, light.y - p.y, light.z - p.z};
    lanes length = root(dot(to, to)), cosine = dot(n, to) / length, offset = (length + 1) * 1e-5f; /* off the surface */
    mask valid = hit & (mask)(cosine > 0);
    if (!any(valid)) return splat(0);
    lanes3 from = {p.x + n.x * offset, p.y + n.y * offset, p.z + n.z * offset};
    store(from.x, rays.org_x), store(from.y, rays.org_y), store(from.z, rays.org_z);
    store(light.x - from.x, rays.dir_x), store(light.y - from.y, rays.dir_y), store(light.z - from.z, rays.dir_z);
    memcpy(rays.tnear, ZEROS, 64), memcpy(rays.tfar, ONES, 64), memcpy(rays.time, ZEROS, 64);
    memset(rays.mask, 0xff, 64), memset(rays.id, 0, 64), memset(rays.flags, 0, 64);
    bench_embree_occluded(job->self, !job->self->instanced, (const int *)&valid, &rays);
    return blend(valid & (mask)(load(rays.tfar) >= 0), cosine, splat(0));
}

static void write_pixels(const frame_job *job, mask hit, lanes cosine, int x0, int y0)
{
    const daft_vec3 albedo = BENCH_ALBEDO, ambient = BENCH_AMBIENT, color = BENCH_LIGHT_COLOR, sky = BENCH_SKY;
    const float still[3] = {albedo.x * ambient.x, albedo.y * ambient.y, albedo.z * ambient.z},
                lit[3] = {albedo.x * color.x, albedo.y * color.y, albedo.z * color.z},
                beyond[3] = {sky.x, sky.y, sky.z};
    uint32_t rgba[16];
    for (int i = 0; i < 16; i++) rgba[i] = 0xff000000u;
    for (int channel = 0; channel < 3; channel++) {
        lanes value = blend(hit, still[channel] + lit[channel] * cosine, splat(beyond[channel]));
        value = blend((mask)(value < 1), value, splat(1)) * (SRGB_STEPS - 1) + 0.5f;
        mask step = __builtin_convertvector(value, mask);
        for (int i = 0; i < 16; i++) rgba[i] |= job->srgb[step[i]] << (8 * channel);
    }
    for (int y = 0; y < 4; y++) {
        size_t at = (size_t)(y0 + y) * (size_t)job->scene->view.width + (size_t)x0;
        memcpy(job->pixels + 4 * at, &rgba[4 * y], 16);
    }
}

static void draw_packet(const frame_job *job, int x, int y, struct RTCRayHit16 *packet)
{
    bench_embree_rays(&job->scene->view, x, y, packet);
    bench_embree_intersect(job->self, true, packet);
    mask geometry;
    memcpy(&geometry, packet->hit.geomID, sizeof geometry);
    mask hit = (mask)(geometry != -1);
    lanes cosine = splat(0);
    if (any(hit)) {
        lanes3 direction = {load(packet->ray.dir_x), load(packet->ray.dir_y), load(packet->ray.dir_z)};
        lanes t = blend(hit, load(packet->ray.tfar), splat(0));
        daft_vec3 eye = job->scene->view.from;
        lanes3 point = {eye.x + t * direction.x, eye.y + t * direction.y, eye.z + t * direction.z};
        cosine = light_reaching(job, point, facing(normals_hit(job, packet, hit), direction), hit);
    }
    write_pixels(job, hit, cosine, x, y);
}

static void draw_row(void *context, uint32_t row, uint32_t worker)
{
    (void)worker;
    const frame_job *job = context;
    struct RTCRayHit16 packet __attribute__((aligned(64)));
    for (int x = 0; x < job->scene->view.width; x += 4) draw_packet(job, x, (int)row * 4, &packet);
}

static void fill_shapes(const bench_scene *scene, shape *shapes)
{
    for (uint32_t i = 0; i < scene->instance_count; i++) {
        const bench_instance *from = &scene->instances[i];
        if (from->mesh == BENCH_SPHERE) continue;
        const daft_trimesh *mesh = &scene->mesh[from->mesh];
        double turn[9];
        daft_quat_matrix(from->rotation, turn);
        shapes[i].normals = &mesh->normals[0].x;
        shapes[i].indices = mesh->normal_indices ? mesh->normal_indices : mesh->indices;
        for (int k = 0; k < 9; k++) shapes[i].turn[k] = (float)turn[k];
    }
}

/* Width and height: multiples of four. */
double bench_embree_frame_ms(bench_embree *self, const bench_scene *scene, uint8_t *pixels)
{
    const daft_allocator allocator = daft_malloc_allocator();
    shape *shapes = daft_alloc_zero(&allocator, scene->instance_count, sizeof *shapes);
    if (!shapes) return -1;
    frame_job job = {.self = self, .scene = scene, .pixels = pixels, .shapes = shapes};
    fill_shapes(scene, shapes); /* as for the tree over them: made once in a still scene, so outside of the time */
    for (int i = 0; i < SRGB_STEPS; i++) {
        double l = (double)i / (SRGB_STEPS - 1);
        job.srgb[i] = (uint32_t)(255 * (l <= 0.0031308 ? 12.92 * l : 1.055 * pow(l, 1 / 2.4) - 0.055) + 0.5);
    }
    double start = bench_clock_ms(self->threads);
    daft_parallel_for(self->threads, (uint32_t)scene->view.height / 4, draw_row, &job);
    double ms = bench_clock_ms(self->threads) - start;
    daft_release(&allocator, shapes);
    return ms;
}
#endif
