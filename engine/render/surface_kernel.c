/* From "this pixel sees that triangle" to points with normals, texture coordinates and places to spawn rays from. A run of
 * neighbouring pixels that see the same triangle shares its set-up; what depends on the triangle is filled in for the run,
 * and what does not (unit vectors, distances, offsets) for the whole batch after, with all lanes at work.
 *
 * Points lie where their ray meets the triangle's plane, whose normal and height are taken in double once a triangle: so a
 * point's error is a few 2^-24 of its own distance along the ray, and less across the plane, even on a triangle that
 * reaches to the horizon. Rays that leave start off the surface by more than that, and than the rounding on their way
 * into an instance's space. They start towards the viewer by as much again: in a concave corner a point may lie across the
 * other wall by its error, where going off its own surface, which runs along that wall, does not bring it back; the way
 * that its ray came is free. No constant depends on the scene's scale. Shadow rays start from a point lifted to where the
 * smooth surface would be, so that facets do not show in the terminator (Hanika, "Hacking the Shadow Terminator", Ray
 * Tracing Gems II, 2021, chapter 4). */
#include "math/simd_real.h"
#include "render/kernels.h"

typedef struct facet {
    daft_vec3 corner[3], normal[3], outward; /* frame space; normals unit, on the viewer's side */
    daft_vec2 uv[3];
    bool smooth, textured;
    float least, most; /* a ray's t lies between: the corners' range along it */
    float height;      /* of the plane over the rays' origin, against `outward`: 0 or less */
    float density; /* units of uv a metre */
    float size;    /* sum of the instance's translation, for the spawn error */
    uint32_t instance, triangle, material;
} facet;

static void facet_normals(const daft_instance *instance, const uint32_t *corner, facet *f)
{
    const daft_trimesh *mesh = instance->mesh;
    daft_vec3 sum = {0, 0, 0};
    f->smooth = false;
    if (!mesh->normals) return;
    for (int k = 0; k < 3; k++) {
        f->normal[k] = daft_normalize(daft_affine_transposed(&instance->to_object, mesh->normals[corner[k]]));
        sum = daft_add(sum, f->normal[k]);
    }
    if (daft_dot(sum, f->outward) < 0) f->outward = daft_neg(f->outward);
    for (int k = 0; k < 3; k++) f->smooth |= daft_dot(f->normal[k], f->outward) < 0.999999f;
}

static void facet_uvs(const daft_trimesh *mesh, const uint32_t *corner, float area, facet *f)
{
    for (int k = 0; k < 3; k++) {
        bool has = mesh->uvs && corner[k] != DAFT_NO_UV;
        f->uv[k] = has ? mesh->uvs[corner[k]] : (daft_vec2){0, 0};
    }
    float ax = f->uv[1].x - f->uv[0].x, ay = f->uv[1].y - f->uv[0].y;
    float bx = f->uv[2].x - f->uv[0].x, by = f->uv[2].y - f->uv[0].y;
    f->density = area > 0 ? sqrtf(fabsf(ax * by - ay * bx) / area) : 0;
}

static void facet_setup(const daft_snapshot *snapshot, uint32_t index, uint32_t triangle, daft_vec3 origin,
                        daft_vec3 direction, facet *f)
{
    const daft_instance *instance = &snapshot->instances[index];
    const daft_trimesh *mesh = instance->mesh;
    size_t at = 3 * (size_t)triangle;
    const uint32_t *corner = &mesh->indices[at];
    for (int k = 0; k < 3; k++)
        f->corner[k] = daft_affine_point(&instance->to_frame, daft_v3(mesh->x[corner[k]], mesh->y[corner[k]], mesh->z[corner[k]]));
    daft_dvec3 first = daft_to_double(f->corner[0]), cross = daft_dcross(daft_dsub(daft_to_double(f->corner[1]), first),
                                                                        daft_dsub(daft_to_double(f->corner[2]), first));
    double length = sqrt(daft_ddot(cross, cross));
    float area = (float)length;
    f->outward = length > 0 ? daft_to_float(daft_dscale(cross, 1 / length)) : daft_neg(daft_normalize(direction));
    facet_normals(instance, mesh->normal_indices ? &mesh->normal_indices[at] : corner, f);
    f->height = (float)daft_ddot(daft_to_double(f->outward), daft_dsub(first, daft_to_double(origin)));
    if (f->height > 0) {
        f->outward = daft_neg(f->outward);
        f->height = -f->height;
        for (int k = 0; k < 3; k++) f->normal[k] = daft_neg(f->normal[k]);
    }
    const float *t = instance->to_frame.t;
    f->size = fabsf(t[0]) + fabsf(t[1]) + fabsf(t[2]);
    f->instance = index;
    f->triangle = triangle;
    f->material = instance->materials[mesh->slots ? mesh->slots[triangle] : 0];
    f->textured = snapshot->materials[f->material].texture != DAFT_NO_TEXTURE;
    f->density = 0;
    if (f->textured) facet_uvs(mesh, mesh->uv_indices ? &mesh->uv_indices[at] : corner, area, f);
}

/* Sets the range of t of rays along `unit`, on which t is the way along it. */
static void facet_limit(facet *f, daft_vec3 origin, daft_vec3 unit)
{
    f->least = INFINITY, f->most = -INFINITY;
    for (int k = 0; k < 3; k++) {
        float along = daft_dot(daft_sub(f->corner[k], origin), unit);
        if (along < f->least) f->least = along;
        if (along > f->most) f->most = along;
    }
}

DAFT_INLINE vf3 set3(daft_vec3 a) { return (vf3){vf_set(a.x), vf_set(a.y), vf_set(a.z)}; }
DAFT_INLINE vf3 all3(float s) { return (vf3){vf_set(s), vf_set(s), vf_set(s)}; }
DAFT_INLINE vf3 add3(vf3 a, vf3 b) { return (vf3){a.x + b.x, a.y + b.y, a.z + b.z}; }
DAFT_INLINE vf3 sub3(vf3 a, vf3 b) { return (vf3){a.x - b.x, a.y - b.y, a.z - b.z}; }
DAFT_INLINE vf3 scale3(vf3 a, vf s) { return (vf3){a.x * s, a.y * s, a.z * s}; }
DAFT_INLINE vf3 mean3(const daft_vec3 a[3], const vf w[3])
{
    return (vf3){vf_set(a[0].x) * w[0] + vf_set(a[1].x) * w[1] + vf_set(a[2].x) * w[2],
                 vf_set(a[0].y) * w[0] + vf_set(a[1].y) * w[1] + vf_set(a[2].y) * w[2],
                 vf_set(a[0].z) * w[0] + vf_set(a[1].z) * w[1] + vf_set(a[2].z) * w[2]};
}
DAFT_INLINE vf3 unit3(vf3 a)
{
    vf length2 = vf3_dot(a, a);
    return scale3(a, vf_select(vf_lt(vf_set(0), length2), vf_set(1) / vf_sqrt(length2), vf_set(0)));
}
DAFT_INLINE vf3 load3(const daft_lanes3 *a, uint32_t at)
{
    return (vf3){vf_load(&a->x[at]), vf_load(&a->y[at]), vf_load(&a->z[at])};
}
DAFT_INLINE void store3(daft_lanes3 *out, uint32_t at, vf3 v)
{
    vf_store(&out->x[at], v.x), vf_store(&out->y[at], v.y), vf_store(&out->z[at], v.z);
}

/* A batch between the two passes: `normal` and `view` are not unit yet, `point` and `lifted` lie on the surface, `extent`
 * holds the size that the spawn error adds to the point's own, `footprint` the density of uv. */
DAFT_INLINE void store_point(daft_batch *b, uint32_t at, vf3 direction, vf3 point, vf3 lifted, vf3 normal, vf3 outward,
                             float size, float density)
{
    store3(&b->point, at, point);
    store3(&b->lifted, at, lifted);
    store3(&b->normal, at, normal);
    store3(&b->outward, at, outward);
    store3(&b->view, at, direction);
    vf_store(&b->extent[at], vf_set(size));
    vf_store(&b->footprint[at], vf_set(density));
}

/* The second pass. Points seen from the camera have come as far as they are from the frame's origin. */
static void finish_points(daft_batch *b, float focal, bool seen_by_camera)
{
    for (uint32_t i = 0; i < b->count; i += DAFT_VL) {
        vf3 point = load3(&b->point, i), outward = load3(&b->outward, i), view = scale3(unit3(load3(&b->view, i)), vf_set(-1));
        vf error = (vf_abs(point.x) + vf_abs(point.y) + vf_abs(point.z) + vf_load(&b->extent[i])) * vf_set(DAFT_SPAWN_ERROR);
        vf reach = seen_by_camera ? vf_sqrt(vf3_dot(point, point)) : vf_load(&b->reach[i]), spread = reach / vf_set(focal);
        vf cosine = vf_max(vf_abs(vf3_dot(outward, view)), vf_set(0.01f));
        vf3 off = scale3(add3(outward, view), error);
        store3(&b->point, i, add3(point, off));
        store3(&b->lifted, i, add3(load3(&b->lifted, i), off));
        store3(&b->normal, i, unit3(load3(&b->normal, i)));
        store3(&b->view, i, view);
        vf_store(&b->reach[i], reach);
        vf_store(&b->footprint[i], spread * vf_load(&b->footprint[i]) / vf_sqrt(cosine));
    }
}

DAFT_INLINE void store_ids(daft_batch *b, uint32_t at, uint32_t instance, uint32_t triangle, uint32_t material)
{
    vi_store(&b->instance[at], vi_set((int32_t)instance));
    vi_store(&b->triangle[at], vi_set((int32_t)triangle));
    vi_store(&b->material[at], vi_set((int32_t)material));
}

/* The corner's tangent plane pulls the point up where the point lies below it. */
DAFT_INLINE vf3 lift_point(const facet *f, vf3 point, const vf w[3])
{
    vf3 lifted = point;
    for (int k = 0; k < 3; k++) {
        vf3 n = set3(f->normal[k]);
        vf below = vf_min(vf3_dot(sub3(point, set3(f->corner[k])), n), vf_set(0));
        lifted = sub3(lifted, scale3(n, below * w[k]));
    }
    return lifted;
}

/* Where the rays meet the plane, but no further than the triangle's nearest and farthest corners are along them: seen
 * edge-on, a plane says little. */
DAFT_INLINE vf plane_way(const facet *f, vf3 direction)
{
    vf t = vf_set(f->height) / vf3_dot(set3(f->outward), direction);
    return vf_min(vf_max(t, vf_set(f->least)), vf_set(f->most));
}

DAFT_INLINE void facet_points(const facet *f, vf3 direction, vf3 point, const vf w[3], daft_batch *b, uint32_t at)
{
    vf3 outward = set3(f->outward), normal = outward, lifted = point;
    if (f->smooth) {
        normal = mean3(f->normal, w);
        lifted = lift_point(f, point, w);
    }
    store_point(b, at, direction, point, lifted, normal, outward, f->size, f->density);
    store_ids(b, at, f->instance, f->triangle, f->material);
    if (!f->textured) return;
    vf_store(&b->u[at], vf_set(f->uv[0].x) * w[0] + vf_set(f->uv[1].x) * w[1] + vf_set(f->uv[2].x) * w[2]);
    vf_store(&b->v[at], vf_set(f->uv[0].y) * w[0] + vf_set(f->uv[1].y) * w[1] + vf_set(f->uv[2].y) * w[2]);
}

/* near: the points as first found; they are pushed onto the sphere along its normal. */
DAFT_INLINE void sphere_points(const daft_instance *s, uint32_t index, vf3 direction, vf3 near, daft_batch *b, uint32_t at)
{
    vf3 centre = set3(daft_v3(s->to_frame.t[0], s->to_frame.t[1], s->to_frame.t[2]));
    vf3 normal = unit3(sub3(near, centre)), point = add3(centre, scale3(normal, vf_set(s->radius)));
    const float *m = s->to_object.m;
    vf3 local = unit3((vf3){vf_set(m[0]) * normal.x + vf_set(m[1]) * normal.y + vf_set(m[2]) * normal.z,
                            vf_set(m[3]) * normal.x + vf_set(m[4]) * normal.y + vf_set(m[5]) * normal.z,
                            vf_set(m[6]) * normal.x + vf_set(m[7]) * normal.y + vf_set(m[8]) * normal.z});
    vf_store(&b->u[at], vf_set(0.5f) + vf_atan2(local.z, local.x) * vf_set(0.159154943f));
    vf_store(&b->v[at], vf_set(0.5f) + vf_asin(local.y) * vf_set(0.318309886f));
    vm inside = vf_lt(vf_set(0), vf3_dot(normal, direction));
    vf side = vf_select(inside, vf_set(-1), vf_set(1));
    normal = scale3(normal, side);
    float size = fabsf(s->to_frame.t[0]) + fabsf(s->to_frame.t[1]) + fabsf(s->to_frame.t[2]) + s->radius;
    /* the map's area is 2·pi·r by pi·r: its mean density is 1 / (sqrt(2)·pi·r) */
    store_point(b, at, direction, point, point, normal, normal, size, 0.225079079f / s->radius);
    store_ids(b, at, index, 0, s->materials[0]);
}

/* ---- pixels ---- */

enum { FACETS = 64 };

/* A facet seen from the camera. edge[k]: the plane of the eye and the edge opposite corner k; a ray's share of it, among
 * the three, is the corner's weight. */
typedef struct seen_facet {
    uint32_t instance, triangle;
    facet facet;
    daft_vec3 edge[3];
} seen_facet;

/* A triangle's runs are in rows below each other: the facets of the last rows are kept, each at its number's place. */
typedef struct view {
    const daft_snapshot *snapshot;
    const daft_pencil *pencil;
    const daft_tile *tile;
    seen_facet facets[FACETS];
} view;

static const seen_facet *find_facet(view *v, uint32_t instance, uint32_t triangle)
{
    seen_facet *seen = &v->facets[(triangle + 7 * instance) % FACETS];
    if (seen->instance == instance && seen->triangle == triangle) return seen;
    const daft_vec3 eye = {0, 0, 0};
    seen->instance = instance, seen->triangle = triangle;
    const daft_pencil *p = v->pencil;
    facet_setup(v->snapshot, instance, triangle, eye, p->forward, &seen->facet);
    facet_limit(&seen->facet, eye, daft_scale(p->forward, 1 / p->focal)); /* all rays go `focal` forwards */
    for (int k = 0; k < 3; k++) {
        daft_vec3 a = seen->facet.corner[(k + 1) % 3], c = seen->facet.corner[(k + 2) % 3];
        seen->edge[k] = daft_cross(daft_sub(a, c), daft_add(a, c));
    }
    return seen;
}

DAFT_INLINE vf3 pixel_rays(const daft_pencil *p, daft_vec3 first, int skip)
{
    vf x = vf_set(first.x + (float)skip) + vf_iota(), y = vf_set(first.y), f = vf_set(p->focal);
    return (vf3){vf_set(p->right.x) * x + vf_set(p->up.x) * y + vf_set(p->forward.x) * f,
                 vf_set(p->right.y) * x + vf_set(p->up.y) * y + vf_set(p->forward.y) * f,
                 vf_set(p->right.z) * x + vf_set(p->up.z) * y + vf_set(p->forward.z) * f};
}

/* One run of `length` pixels from `at` that all see the same triangle. */
static void facet_run(view *v, int at, int length, daft_batch *b)
{
    const daft_pencil *p = v->pencil;
    daft_vec3 first = daft_pencil_ray(p, v->tile->x + at % DAFT_TILE_STRIDE, v->tile->y + at / DAFT_TILE_STRIDE);
    const seen_facet *seen = find_facet(v, v->tile->instance[at], v->tile->triangle[at]);
    const daft_vec3 *edge = seen->edge;
    for (int i = 0; i < length; i += DAFT_VL) {
        vf3 direction = pixel_rays(p, first, i);
        vf w[3], zero = vf_set(0);
        for (int k = 0; k < 3; k++) w[k] = vf3_dot(set3(edge[k]), direction);
        vf sum = w[0] + w[1] + w[2], sign = vf_select(vf_lt(sum, zero), vf_set(-1), vf_set(1));
        for (int k = 0; k < 3; k++) w[k] = vf_max(w[k] * sign, zero);
        sum = w[0] + w[1] + w[2];
        vm some = vf_lt(zero, sum);
        vf share = vf_set(1) / sum;
        for (int k = 0; k < 3; k++) w[k] = vf_select(some, w[k] * share, vf_set(1.0f / 3));
        vf3 point = scale3(direction, plane_way(&seen->facet, direction));
        facet_points(&seen->facet, direction, point, w, b, b->count + (uint32_t)i);
    }
}

/* How far along rays from the origin, which are known to hit, the sphere is. As daft_pencil_sphere, in lanes. */
DAFT_INLINE vf sphere_way(const daft_instance *s, vf3 d)
{
    vf3 centre = set3(daft_v3(s->to_frame.t[0], s->to_frame.t[1], s->to_frame.t[2]));
    vf dd = vf3_dot(d, d), along = vf3_dot(centre, d) / dd;
    vf3 aside = sub3(centre, scale3(d, along));
    vf half = vf_sqrt(vf_max(vf_set(s->radius * s->radius) - vf3_dot(aside, aside), vf_set(0)) / dd), near = along - half;
    return vf_select(vf_lt(vf_set(0), near), near, along + half);
}

static void sphere_run(const view *v, int at, int length, daft_batch *b)
{
    const daft_pencil *p = v->pencil;
    uint32_t index = v->tile->instance[at];
    const daft_instance *s = &v->snapshot->instances[index];
    daft_vec3 first = daft_pencil_ray(p, v->tile->x + at % DAFT_TILE_STRIDE, v->tile->y + at / DAFT_TILE_STRIDE);
    for (int i = 0; i < length; i += DAFT_VL) {
        vf3 direction = pixel_rays(p, first, i);
        sphere_points(s, index, direction, scale3(direction, sphere_way(s, direction)), b, b->count + (uint32_t)i);
    }
}

static void sky_run(const view *v, int at, int length, daft_ray_batch *sky)
{
    daft_vec3 first = daft_pencil_ray(v->pencil, v->tile->x + at % DAFT_TILE_STRIDE, v->tile->y + at / DAFT_TILE_STRIDE);
    for (int i = 0; i < length; i += DAFT_VL)
        store3(&sky->direction, sky->count + (uint32_t)i, pixel_rays(v->pencil, first, i));
}

static uint32_t number_pixels(uint32_t *pixel, uint32_t count, int at, int length)
{
    uint32_t first = (uint32_t)(at / DAFT_TILE_STRIDE * DAFT_TILE + at % DAFT_TILE_STRIDE);
    for (int i = 0; i < length; i++) pixel[count + (uint32_t)i] = first + (uint32_t)i;
    return count + (uint32_t)length;
}

void DAFT_KERNEL(daft_surfaces)(const daft_snapshot *snapshot, const daft_pencil *pencil, const daft_tile *tile,
                                daft_batch *points, daft_ray_batch *sky)
{
    view v;
    v.snapshot = snapshot, v.pencil = pencil, v.tile = tile;
    for (int i = 0; i < FACETS; i++) v.facets[i].instance = DAFT_NOTHING;
    points->count = sky->count = 0;
    for (int row = 0; row < tile->height; row++) {
        const int base = row * DAFT_TILE_STRIDE;
        for (int x = 0, length; x < tile->width; x += length) {
            int at = base + x;
            uint32_t instance = tile->instance[at], triangle = tile->triangle[at];
            for (length = 1; x + length < tile->width; length++)
                if (tile->instance[at + length] != instance || tile->triangle[at + length] != triangle) break;
            if (instance == DAFT_NOTHING) {
                sky_run(&v, at, length, sky);
                sky->count = number_pixels(sky->pixel, sky->count, at, length);
                continue;
            }
            if (snapshot->instances[instance].mesh)
                facet_run(&v, at, length, points);
            else
                sphere_run(&v, at, length, points);
            points->count = number_pixels(points->pixel, points->count, at, length);
        }
    }
    for (uint32_t i = 0; i < points->count; i += DAFT_VL) store3(&points->weight, i, all3(1));
    finish_points(points, snapshot->focal, true);
}

/* ---- hits of single rays ---- */

void DAFT_KERNEL(daft_hit_point)(const daft_snapshot *snapshot, const daft_ray_batch *from, uint32_t ray,
                                 const daft_hit *hit, daft_batch *points)
{
    uint32_t at = points->count++;
    daft_vec3 o = daft_v3(from->origin.x[ray], from->origin.y[ray], from->origin.z[ray]);
    daft_vec3 d = daft_v3(from->direction.x[ray], from->direction.y[ray], from->direction.z[ray]);
    const daft_instance *instance = &snapshot->instances[hit->instance];
    if (instance->mesh) {
        facet f;
        facet_setup(snapshot, hit->instance, hit->triangle, o, d, &f);
        facet_limit(&f, o, d);
        vf w[3] = {vf_set(1 - hit->u - hit->v), vf_set(hit->u), vf_set(hit->v)};
        facet_points(&f, set3(d), add3(set3(o), scale3(set3(d), plane_way(&f, set3(d)))), w, points, at);
    } else {
        sphere_points(instance, hit->instance, set3(d), set3(daft_add(o, daft_scale(d, hit->t))), points, at);
    }
    points->reach[at] = from->reach[ray] + hit->t;
    points->pixel[at] = from->pixel[ray];
    points->weight.x[at] = from->weight.x[ray];
    points->weight.y[at] = from->weight.y[ray];
    points->weight.z[at] = from->weight.z[ray];
}

void DAFT_KERNEL(daft_finish_hits)(const daft_snapshot *snapshot, daft_batch *points)
{
    finish_points(points, snapshot->focal, false);
}
