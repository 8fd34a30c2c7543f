/* A frame as one would write it with Embree: packets of 16 camera rays, smooth normals, packets of 16 shadow rays to
 * the lamp from what faces it, Lambert's law, sRGB bytes by table. The same picture as frames.c's, but for rounding. */
#include "embree.h"

#ifdef DAFT_EMBREE
#include <math.h>
#include <string.h>

enum { SRGB_STEPS = 4096 };

typedef struct frame_job {
    const bench_embree *self;
    const bench_scene *scene;
    uint8_t *pixels;
    uint32_t srgb[SRGB_STEPS]; /* words, which the compiler can gather */
} frame_job;

typedef struct surface16 {
    float x[16], y[16], z[16];    /* where */
    float nx[16], ny[16], nz[16]; /* normal, unit */
    int hit[16] __attribute__((aligned(64)));
} surface16;

static daft_vec3 turned(const bench_thing *thing, daft_vec3 n)
{
    return daft_quat_rotate(thing->rotation, n);
}

static daft_vec3 smooth_normal(const bench_embree *self, const bench_scene *scene, const struct RTCRayHit16 *packet,
                               int i)
{
    uint32_t instance = packet->hit.instID[0][i], geometry = packet->hit.geomID[i], triangle = packet->hit.primID[i];
    if (instance == RTC_INVALID_GEOMETRY_ID && geometry == self->first_sphere)
        return daft_v3(packet->hit.Ng_x[i], packet->hit.Ng_y[i], packet->hit.Ng_z[i]);
    const bench_thing *thing = &scene->things[instance == RTC_INVALID_GEOMETRY_ID ? geometry : instance];
    const daft_trimesh *mesh = &scene->mesh[thing->mesh];
    const uint32_t *n = (mesh->normal_indices ? mesh->normal_indices : mesh->indices) + 3 * (size_t)triangle;
    float u = packet->hit.u[i], v = packet->hit.v[i];
    daft_vec3 normal = daft_add(daft_scale(mesh->normals[n[0]], 1 - u - v),
                                daft_add(daft_scale(mesh->normals[n[1]], u), daft_scale(mesh->normals[n[2]], v)));
    return instance == RTC_INVALID_GEOMETRY_ID ? normal : turned(thing, normal);
}

static int find_surfaces(const frame_job *job, const struct RTCRayHit16 *packet, surface16 *s)
{
    int hits = 0;
    for (int i = 0; i < 16; i++) {
        s->hit[i] = packet->hit.geomID[i] != RTC_INVALID_GEOMETRY_ID ? -1 : 0;
        hits += s->hit[i] != 0;
        float t = s->hit[i] ? packet->ray.tfar[i] : 0;
        s->x[i] = packet->ray.org_x[i] + t * packet->ray.dir_x[i];
        s->y[i] = packet->ray.org_y[i] + t * packet->ray.dir_y[i];
        s->z[i] = packet->ray.org_z[i] + t * packet->ray.dir_z[i];
    }
    for (int i = 0; i < 16; i++) {
        daft_vec3 n = s->hit[i] ? smooth_normal(job->self, job->scene, packet, i) : daft_v3(0, 1, 0);
        s->nx[i] = n.x, s->ny[i] = n.y, s->nz[i] = n.z;
    }
    for (int i = 0; i < 16; i++) {
        float d = s->nx[i] * packet->ray.dir_x[i] + s->ny[i] * packet->ray.dir_y[i] + s->nz[i] * packet->ray.dir_z[i];
        float length2 = s->nx[i] * s->nx[i] + s->ny[i] * s->ny[i] + s->nz[i] * s->nz[i];
        float scale =
            length2 > 0 ? (d > 0 ? -1.0f : 1.0f) / sqrtf(length2) : 0; /* finite in lanes that ask nothing, too */
        s->nx[i] *= scale, s->ny[i] *= scale, s->nz[i] *= scale;
    }
    return hits;
}

/* Lambert's cosine of each lit point, 0 of the others. */
static void light(const frame_job *job, const surface16 *s, float cosine[16])
{
    struct RTCRay16 rays __attribute__((aligned(64)));
    int valid[16] __attribute__((aligned(64)));
    daft_vec3 lamp = job->scene->lamp;
    int asked = 0;
    for (int i = 0; i < 16; i++) {
        float x = lamp.x - s->x[i], y = lamp.y - s->y[i], z = lamp.z - s->z[i], length = sqrtf(x * x + y * y + z * z);
        cosine[i] = (s->nx[i] * x + s->ny[i] * y + s->nz[i] * z) / length;
        float off = (length + 1) * 1e-5f; /* away from the surface */
        rays.org_x[i] = s->x[i] + s->nx[i] * off, rays.org_y[i] = s->y[i] + s->ny[i] * off,
        rays.org_z[i] = s->z[i] + s->nz[i] * off;
        rays.dir_x[i] = lamp.x - rays.org_x[i], rays.dir_y[i] = lamp.y - rays.org_y[i],
        rays.dir_z[i] = lamp.z - rays.org_z[i];
        rays.tnear[i] = 0, rays.tfar[i] = 1, rays.time[i] = 0, rays.mask[i] = UINT32_MAX, rays.id[i] = 0,
        rays.flags[i] = 0;
        valid[i] = s->hit[i] && cosine[i] > 0 ? -1 : 0;
    }
    for (int i = 0; i < 16; i++) asked += valid[i];
    if (asked) bench_embree_occluded(job->self, !job->self->instanced, valid, &rays);
    for (int i = 0; i < 16; i++) cosine[i] = valid[i] && !(rays.tfar[i] < 0) ? cosine[i] : 0;
}

/* Adds one colour channel to the pixels' words. */
static void add_channel(const frame_job *job, const surface16 *s, const float cosine[16], int channel, uint32_t rgba[16])
{
    const daft_vec3 albedo = BENCH_ALBEDO, ambient = BENCH_AMBIENT, lamp = BENCH_LAMP_COLOR, sky = BENCH_SKY;
    float still = (&albedo.x)[channel] * (&ambient.x)[channel], lit = (&albedo.x)[channel] * (&lamp.x)[channel];
    float beyond = (&sky.x)[channel];
    for (int i = 0; i < 16; i++) {
        float surface = still + lit * cosine[i], value = s->hit[i] ? surface : beyond;
        int step = (int)((value < 1 ? value : 1) * (SRGB_STEPS - 1) + 0.5f);
        rgba[i] |= job->srgb[step] << (8 * channel);
    }
}

static void write_pixels(const frame_job *job, const surface16 *s, const float cosine[16], int x0, int y0)
{
    uint32_t rgba[16];
    for (int i = 0; i < 16; i++) rgba[i] = 0xff000000u;
    for (int channel = 0; channel < 3; channel++) add_channel(job, s, cosine, channel, rgba);
    for (int y = 0; y < 4; y++) {
        size_t at = (size_t)(y0 + y) * (size_t)job->scene->view.width + (size_t)x0;
        memcpy(job->pixels + 4 * at, &rgba[4 * y], 16);
    }
}

static void draw_row(void *context, uint32_t row, uint32_t worker)
{
    (void)worker;
    const frame_job *job = context;
    struct RTCRayHit16 packet __attribute__((aligned(64)));
    for (int x = 0; x < job->scene->view.width; x += 4) {
        float cosine[16] = {0};
        surface16 surface;
        bench_embree_rays(&job->scene->view, x, (int)row * 4, &packet);
        bench_embree_intersect(job->self, true, &packet);
        if (find_surfaces(job, &packet, &surface)) light(job, &surface, cosine);
        write_pixels(job, &surface, cosine, x, (int)row * 4);
    }
}

/* Width and height: multiples of four. */
double bench_embree_frame_ms(bench_embree *self, const bench_scene *scene, uint8_t *pixels)
{
    frame_job job = {.self = self, .scene = scene, .pixels = pixels};
    for (int i = 0; i < SRGB_STEPS; i++) {
        double l = (double)i / (SRGB_STEPS - 1);
        job.srgb[i] = (uint32_t)(255 * (l <= 0.0031308 ? 12.92 * l : 1.055 * pow(l, 1 / 2.4) - 0.055) + 0.5);
    }
    double start = bench_clock_ms(self->threads);
    daft_parallel_for(self->threads, (uint32_t)scene->view.height / 4, draw_row, &job);
    return bench_clock_ms(self->threads) - start;
}
#endif
