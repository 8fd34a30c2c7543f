/* Planar mirrors as pencils: camera rays that a plane reflects meet in the mirrored eye, so they see what a camera
 * there would see through the mirror. That camera's visibility gives each ray's instance; the hit point is computed
 * from the ray itself. An instance that reaches through the plane may occlude, for the mirrored eye, what lies before
 * the plane: where a ray's instance lies behind its origin, the ray is cast through the BVH, as rays of curved mirrors
 * are. */
#include "render/internal.h"

enum {
    MIRROR_TRIANGLES = 64,  /* of a mesh that is looked through for planes */
    MIRROR_BOUND = 64 * 64, /* pixels of its bounds below which it is not worth another pass */
    MIRROR_PIXELS = 128     /* of a tile, likewise */
};

/* ---- which planes ---- */

typedef struct plane {
    daft_dvec3 normal; /* unit, towards the eye */
    double away;       /* of the eye */
} plane;

static daft_vec3 frame_corner(const daft_instance *s, uint32_t vertex)
{
    const daft_trimesh *m = s->mesh;
    return daft_affine_point(&s->to_frame, daft_v3(m->x[vertex], m->y[vertex], m->z[vertex]));
}

static double scale_of(const daft_instance *s)
{
    daft_vec3 a = daft_max3(daft_neg(s->low), s->high);
    return (double)a.x + (double)a.y + (double)a.z;
}

/* Whether the triangle's shading normals are the plane's. */
static bool normals_agree(const daft_instance *s, uint32_t triangle, daft_vec3 normal)
{
    const daft_trimesh *m = s->mesh;
    if (!m->normals) return true;
    const uint32_t *at = &(m->normal_indices ? m->normal_indices : m->indices)[3 * (size_t)triangle];
    for (int k = 0; k < 3; k++) {
        daft_vec3 n = daft_normalize(daft_affine_transposed(&s->to_object, m->normals[at[k]]));
        if (!(fabsf(daft_dot(n, normal)) >= 0.999999f)) return false;
    }
    return true;
}

/* The plane of a triangle, if all of its mesh lies in it or behind it and the eye clearly before it. */
static bool triangle_plane(const daft_instance *s, uint32_t triangle, plane *out)
{
    const uint32_t *corner = &s->mesh->indices[3 * (size_t)triangle];
    daft_dvec3 c[3];
    for (int k = 0; k < 3; k++) c[k] = daft_to_double(frame_corner(s, corner[k]));
    daft_dvec3 n = daft_dcross(daft_dsub(c[1], c[0]), daft_dsub(c[2], c[0]));
    double length = sqrt(daft_ddot(n, n)), tolerance = 1e-6 * scale_of(s);
    if (!(length > 0)) return false;
    n = daft_dscale(n, 1 / length);
    if (daft_ddot(n, c[0]) > 0) n = daft_dscale(n, -1);
    *out = (plane){n, -daft_ddot(n, c[0])};
    if (!(out->away > 16 * tolerance) || !(out->away < 1e15)) return false;
    for (uint32_t v = 0; v < 3 * s->mesh->triangle_count; v++)
        if (daft_ddot(n, daft_to_double(frame_corner(s, s->mesh->indices[v]))) + out->away > tolerance) return false;
    return normals_agree(s, triangle, daft_to_float(n));
}

static void set_mirror(const daft_pencil *p, uint32_t instance, const plane *at, daft_mirror *m)
{
    const daft_vec3 *axes = &p->right;
    daft_vec3 mirrored[3];
    for (int k = 0; k < 3; k++) {
        daft_dvec3 axis = daft_to_double(axes[k]);
        mirrored[k] = daft_to_float(daft_dsub(axis, daft_dscale(at->normal, 2 * daft_ddot(axis, at->normal))));
    }
    m->instance = instance, m->triangles = 0;
    m->normal = daft_to_float(at->normal), m->away = (float)at->away;
    m->eye = daft_to_float(daft_dscale(at->normal, -2 * at->away));
    m->pencil = *p;
    m->pencil.right = mirrored[0], m->pencil.up = mirrored[1], m->pencil.forward = mirrored[2];
}

static void add_triangle(daft_frame *frame, uint32_t instance, uint32_t triangle, const plane *at)
{
    daft_mirror *mirrors = frame->renderer->mirrors;
    daft_vec3 normal = daft_to_float(at->normal);
    float near = 1e-5f * (float)at->away;
    for (int i = 0; i < frame->mirror_count; i++) {
        daft_mirror *m = &mirrors[i];
        if (m->instance != instance || daft_dot(normal, m->normal) < 0.9999999f ||
            fabsf((float)at->away - m->away) > near)
            continue;
        m->triangles |= (uint64_t)1 << triangle;
        return;
    }
    if (frame->mirror_count == DAFT_MAX_MIRRORS) return;
    daft_mirror *m = &mirrors[frame->mirror_count++];
    set_mirror(&frame->pencil, instance, at, m);
    m->triangles = (uint64_t)1 << triangle;
}

static void find_planes(daft_frame *frame)
{
    const daft_raster *raster = &frame->renderer->raster;
    for (uint32_t i = 0; i < raster->instance_count; i++) {
        const daft_view_instance *view = &raster->visible[i];
        const daft_instance *s = view->instance;
        if (!s || !s->mesh || s->mesh->triangle_count > MIRROR_TRIANGLES) continue;
        if ((view->x1 - view->x0 + 1) * (view->y1 - view->y0 + 1) < MIRROR_BOUND) continue;
        for (uint32_t t = 0; t < s->mesh->triangle_count; t++) {
            plane at;
            const daft_surface *m = &frame->snapshot->materials[s->materials[s->mesh->slots ? s->mesh->slots[t] : 0]];
            const bool rough = frame->plan.glossy && m->alpha > 0;
            if (!rough && (m->mirror.x > 0 || m->mirror.y > 0 || m->mirror.z > 0))
                if (triangle_plane(s, t, &at)) add_triangle(frame, i, t, &at);
        }
    }
}

/* ---- what they see ---- */

/* How far the bounds reach before the plane. */
static float reach_before(const daft_mirror *m, const daft_instance *s)
{
    daft_vec3 n = m->normal;
    daft_vec3 p =
        daft_v3(n.x > 0 ? s->high.x : s->low.x, n.y > 0 ? s->high.y : s->low.y, n.z > 0 ? s->high.z : s->low.z);
    return daft_dot(n, p) + m->away;
}

/* The instances that reach before the plane, seen from the mirrored eye. */
static bool fill_mirror(daft_renderer *r, const daft_snapshot *snapshot, daft_mirror *m, daft_error *error)
{
    uint32_t count = snapshot->instance_count;
    if (!daft_grow(&r->allocator, &m->instances, &m->instance_capacity, count, 0, sizeof *m->instances) ||
        !daft_grow(&r->allocator, &m->numbers, &m->number_capacity, count, 0, sizeof *m->numbers) ||
        (!m->raster.bins && !daft_raster_init(&m->raster, &r->allocator, r->threads, r->isa, error)))
        return daft_fail_memory(error, "what a mirror shows");
    m->count = 0;
    for (uint32_t i = 0; i < count; i++) {
        const daft_instance *s = &snapshot->instances[i];
        if (i == m->instance || reach_before(m, s) <= 1e-6f * (float)scale_of(s)) continue;
        daft_instance *moved = &m->instances[m->count];
        *moved = *s;
        moved->to_frame.t[0] -= m->eye.x, moved->to_frame.t[1] -= m->eye.y, moved->to_frame.t[2] -= m->eye.z;
        moved->low = daft_sub(s->low, m->eye), moved->high = daft_sub(s->high, m->eye);
        m->numbers[m->count++] = i;
    }
    return daft_raster_begin(&m->raster, &m->pencil, m->instances, m->count, error);
}

static void bin_task(void *context, uint32_t index, uint32_t worker) { daft_raster_bin(context, index, worker); }

bool daft_mirrors_prepare(daft_frame *frame, daft_error *error)
{
    daft_renderer *r = frame->renderer;
    frame->mirror_count = 0;
    if (!frame->plan.reflects || frame->snapshot->quality.tree != DAFT_TREE_RASTER) return true;
    find_planes(frame);
    size_t tiles = (size_t)frame->mirror_count * (size_t)r->threads;
    if (!daft_grow(&r->allocator, &r->mirrored, &r->mirrored_capacity, tiles, 0, sizeof *r->mirrored))
        return daft_fail_memory(error, "what a mirror shows");
    for (int i = 0; i < frame->mirror_count; i++) {
        daft_mirror *m = &r->mirrors[i];
        if (!fill_mirror(r, frame->snapshot, m, error)) return false;
        daft_parallel_for(r->threads, m->raster.work_count, bin_task, &m->raster);
        for (int k = 0; k < r->threads; k++)
            if (m->raster.bins[k].out_of_memory) return daft_fail_memory(error, "what a mirror shows");
    }
    if (frame->mirror_count)
        frame->plan.why[DAFT_EFFECT_REFLECTION] = "a mirror is seen; flat ones show a mirrored camera's picture";
    return true;
}

void daft_mirrors_free(daft_renderer *r)
{
    for (int i = 0; i < DAFT_MAX_MIRRORS; i++) {
        daft_raster_free(&r->mirrors[i].raster);
        daft_release(&r->allocator, r->mirrors[i].instances);
        daft_release(&r->allocator, r->mirrors[i].numbers);
    }
    daft_release(&r->allocator, r->mirrored);
}

size_t daft_mirrors_bytes(const daft_renderer *r)
{
    size_t bytes = r->mirrored_capacity * sizeof *r->mirrored;
    for (int i = 0; i < DAFT_MAX_MIRRORS; i++) {
        const daft_mirror *m = &r->mirrors[i];
        bytes += m->instance_capacity * sizeof *m->instances + m->number_capacity * sizeof *m->numbers;
        bytes += daft_raster_bytes(&m->raster);
    }
    return bytes;
}

/* ---- a tile ---- */

static int mirror_at(const daft_frame *frame, const daft_tile *tile, uint32_t pixel)
{
    uint32_t instance = tile->instance[pixel], triangle = tile->triangle[pixel];
    for (int i = 0; i < frame->mirror_count; i++) {
        const daft_mirror *m = &frame->renderer->mirrors[i];
        if (m->instance == instance && m->triangles >> triangle & 1) return i;
    }
    return -1;
}

uint32_t daft_mirrors_tile(const daft_frame *frame, uint32_t number, uint32_t worker, const daft_tile *tile,
                           const daft_ray_batch *rays)
{
    const daft_renderer *r = frame->renderer;
    uint32_t count[DAFT_MAX_MIRRORS] = {0}, shown = 0;
    for (uint32_t i = 0; frame->mirror_count && i < rays->count; i++) {
        int which = mirror_at(frame, tile, rays->pixel[i]);
        if (which >= 0) count[which]++;
    }
    for (int i = 0; i < frame->mirror_count; i++) {
        if (count[i] < MIRROR_PIXELS) continue;
        daft_tile *out = &r->mirrored[worker * (uint32_t)frame->mirror_count + (uint32_t)i];
        r->raster_kernels->tile(&r->mirrors[i].raster, number, worker, NULL, out);
        shown |= (uint32_t)1 << i;
    }
    return shown;
}

/* Intersects the ray with the triangle's plane, ahead of its origin. Weights are clamped to the triangle. */
static bool meet_triangle(const daft_instance *s, uint32_t triangle, daft_dvec3 o, daft_dvec3 d, daft_hit *hit)
{
    const uint32_t *corner = &s->mesh->indices[3 * (size_t)triangle];
    daft_dvec3 a = daft_to_double(frame_corner(s, corner[0])), from = daft_dsub(o, a);
    daft_dvec3 e1 = daft_dsub(daft_to_double(frame_corner(s, corner[1])), a),
               e2 = daft_dsub(daft_to_double(frame_corner(s, corner[2])), a);
    daft_dvec3 p = daft_dcross(d, e2), q = daft_dcross(from, e1); /* Möller and Trumbore, 1997 */
    double det = daft_ddot(e1, p), t = daft_ddot(e2, q) / det, u = daft_ddot(from, p) / det, v = daft_ddot(d, q) / det;
    if (!(t > 0) || !(fabs(u) + fabs(v) < 1e6)) return false;
    u = fmin(fmax(u, 0), 1), v = fmin(fmax(v, 0), 1 - u);
    hit->t = (float)t, hit->u = (float)u, hit->v = (float)v;
    return hit->t > 0 && hit->t < INFINITY;
}

static bool meet_sphere(const daft_instance *s, daft_dvec3 o, daft_dvec3 d, daft_hit *hit)
{
    const float *c = s->to_frame.t;
    daft_dvec3 to = daft_dsub(daft_dv3((double)c[0], (double)c[1], (double)c[2]), o);
    double along = daft_ddot(to, d), r2 = (double)s->radius * (double)s->radius;
    daft_dvec3 aside = daft_dsub(to, daft_dscale(d, along));
    double t = along - sqrt(fmax(r2 - daft_ddot(aside, aside), 0));
    hit->t = (float)t, hit->u = hit->v = 0;
    return hit->t > 0 && hit->t < INFINITY;
}

bool daft_mirrors_hit(const daft_frame *frame, uint32_t shown, uint32_t worker, const daft_tile *tile,
                      const daft_ray_batch *rays, uint32_t ray, daft_hit *hit)
{
    uint32_t pixel = rays->pixel[ray];
    int which = mirror_at(frame, tile, pixel);
    if (which < 0 || !(shown >> which & 1)) return false;
    const daft_renderer *r = frame->renderer;
    const daft_tile *seen = &r->mirrored[worker * (uint32_t)frame->mirror_count + (uint32_t)which];
    uint32_t number = seen->instance[pixel];
    *hit = (daft_hit){.t = INFINITY, .instance = DAFT_NOTHING};
    if (number == DAFT_NOTHING) return true;
    hit->instance = r->mirrors[which].numbers[number], hit->triangle = seen->triangle[pixel];
    const daft_instance *s = &frame->snapshot->instances[hit->instance];
    daft_dvec3 o = daft_dv3((double)rays->origin.x[ray], (double)rays->origin.y[ray], (double)rays->origin.z[ray]);
    daft_dvec3 d =
        daft_dv3((double)rays->direction.x[ray], (double)rays->direction.y[ray], (double)rays->direction.z[ray]);
    return s->mesh ? meet_triangle(s, hit->triangle, o, d, hit) : meet_sphere(s, o, d, hit);
}
