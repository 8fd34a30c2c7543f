/* Planar mirrors as pencils: camera rays that a plane reflects meet in the mirrored eye, so they see what a camera
 * there would see through the mirror. That camera's visibility gives each ray's instance; the hit point is computed
 * from the ray itself. What lies behind the plane is left out triangle by triangle (daft_clip); one that reaches
 * through the plane may occlude, for the mirrored eye, what lies before it: where a ray's triangle lies behind its
 * origin, the ray is cast through the BVH, as rays of curved mirrors are.
 *
 * A mirror in a mirror is the same again: rays that one plane reflects and another meets next are a pencil through the
 * mirrored eye's mirror image. So mirrors are a tree, each known by the mirror that shows it and its own plane. The
 * largest in the picture come first, down to the depth of the quality. */
#include "render/internal.h"

#include <string.h>

enum {
    MIRROR_BOUND = 64 * 64,  /* pixels of its bounds below which a plane is not worth another pass */
    MIRROR_PIXELS = 128,     /* of a tile, likewise */
    MIRROR_COPIES = 1 << 16, /* instances in all mirrors together, in pictures of fewer than that */
    MIRROR_ALWAYS = 4,       /* but so many mirrors for pictures of more */
    MIRROR_IDLE = 256,       /* samples for which planes are kept unasked */
    MIRROR_WAITING = 4 * DAFT_MAX_MIRRORS
};

/* ---- which planes a mesh has ---- */

static bool is_smooth_mirror(const daft_frame *frame, const daft_surface *m)
{
    const bool rough = frame->plan.glossy && m->alpha > 0, bumpy = m->traits & DAFT_TRAIT_TANGENT;
    return !rough && !bumpy && (m->mirror.x > 0 || m->mirror.y > 0 || m->mirror.z > 0);
}

static double scale_of(const daft_instance *s)
{
    daft_vec3 a = daft_max3(daft_neg(s->low), s->high);
    return (double)a.x + (double)a.y + (double)a.z;
}

static void forget_meshes(daft_renderer *r)
{
    size_t kept = 0;
    for (size_t i = 0; i < r->mirror_mesh_count; i++) {
        daft_mirror_mesh *m = &r->mirror_meshes[i];
        if (m->idle++ < MIRROR_IDLE)
            r->mirror_meshes[kept++] = *m;
        else
            daft_mesh_planes_free(&r->allocator, &m->planes);
    }
    r->mirror_mesh_count = kept;
}

/* Which of the mesh's slots mirror, into r->mirror_slots; their hash, 0 if none does. False: memory is out. */
static bool mark_slots(const daft_frame *frame, const daft_instance *s, uint64_t *hash)
{
    daft_renderer *r = frame->renderer;
    const uint32_t count = s->mesh->slot_count ? s->mesh->slot_count : 1;
    bool some = false;
    *hash = 0;
    if (!daft_grow(&r->allocator, &r->mirror_slots, &r->mirror_slot_capacity, count, 0, sizeof *r->mirror_slots))
        return false;
    for (uint32_t i = 0; i < count; i++)
        some |= r->mirror_slots[i] = is_smooth_mirror(frame, &frame->snapshot->materials[s->materials[i]]);
    if (some) *hash = daft_hash(r->mirror_slots, count, 1) | 1;
    return true;
}

/* The mesh's planes, found when they are first asked for and there until the next ones are; NULL: it has none. False:
 * memory is out. */
static bool find_planes(const daft_frame *frame, const daft_instance *s, const daft_mesh_planes **out)
{
    daft_renderer *r = frame->renderer;
    uint64_t slots;
    *out = NULL;
    if (!s->mesh || !s->mesh->triangle_count) return true;
    if (!mark_slots(frame, s, &slots)) return false;
    if (!slots) return true;
    size_t i = 0;
    for (; i < r->mirror_mesh_count; i++) {
        const daft_mirror_mesh *m = &r->mirror_meshes[i];
        if (m->mesh == s->mesh && m->shape == s->shape && m->slots == slots) break;
    }
    if (i == r->mirror_mesh_count) {
        if (!daft_grow(&r->allocator, &r->mirror_meshes, &r->mirror_mesh_capacity, i + 1, i, sizeof *r->mirror_meshes))
            return false;
        daft_mirror_mesh *m = &r->mirror_meshes[i];
        *m = (daft_mirror_mesh){
            .mesh = s->mesh, .shape = s->shape, .slots = slots, .triangles = s->mesh->triangle_count};
        if (!daft_trimesh_planes(&r->allocator, s->mesh, r->mirror_slots, &m->planes)) return false;
        r->mirror_mesh_count++;
    }
    r->mirror_meshes[i].idle = 0;
    if (r->mirror_meshes[i].planes.count) *out = &r->mirror_meshes[i].planes;
    return true;
}

/* ---- which of them are seen ---- */

/* A plane that may become a mirror. */
typedef struct candidate {
    uint8_t parent;
    uint32_t instance, plane;
    const uint8_t *planes;
    daft_dvec3 normal;
    double offset, away;
    int x0, x1, y0, y1;
} candidate;

typedef struct candidates {
    daft_frame *frame;
    uint32_t count;
    candidate items[MIRROR_WAITING];
} candidates;

static int64_t pixels_of(const candidate *c) { return (int64_t)(c->x1 - c->x0 + 1) * (c->y1 - c->y0 + 1); }

static const daft_mirror *mirror_of(const daft_frame *frame, uint8_t number)
{
    return number < DAFT_MAX_MIRRORS ? &frame->renderer->mirrors[number] : NULL;
}

/* A point of the object's space in frame space, not rounded. */
static daft_dvec3 map_point(const daft_affine *a, daft_dvec3 p)
{
    double out[3];
    for (int k = 0; k < 3; k++)
        out[k] =
            (double)a->m[3 * k] * p.x + (double)a->m[3 * k + 1] * p.y + (double)a->m[3 * k + 2] * p.z + (double)a->t[k];
    return daft_dv3(out[0], out[1], out[2]);
}

/* Two vectors in the plane of a unit normal, as long as the bounds are wide. */
static void lay_axes(daft_dvec3 normal, double length, daft_dvec3 *u, daft_dvec3 *v)
{
    const daft_dvec3 other = fabs(normal.x) < 0.5 ? daft_dv3(1, 0, 0) : daft_dv3(0, 1, 0);
    const daft_dvec3 across = daft_dcross(normal, other);
    *u = daft_dscale(across, length / sqrt(daft_ddot(across, across)));
    *v = daft_dcross(normal, *u);
}

/* The plane in frame space, and the eye clearly before it. */
static bool place_plane(const daft_instance *s, const daft_mesh_plane *p, daft_dvec3 eye, candidate *out)
{
    const daft_dvec3 low = daft_to_double(p->low), high = daft_to_double(p->high), size = daft_dsub(high, low);
    daft_dvec3 middle = daft_dscale(daft_dadd(low, high), 0.5), u, v;
    middle = daft_dsub(middle, daft_dscale(p->normal, daft_ddot(p->normal, middle) - p->offset));
    lay_axes(p->normal, size.x + size.y + size.z, &u, &v);
    const daft_dvec3 a = map_point(&s->to_frame, middle);
    daft_dvec3 n = daft_dcross(daft_dsub(map_point(&s->to_frame, daft_dadd(middle, u)), a),
                               daft_dsub(map_point(&s->to_frame, daft_dadd(middle, v)), a));
    const double length = sqrt(daft_ddot(n, n));
    if (!(length > 0)) return false;
    n = daft_dscale(n, 1 / length);
    if (daft_ddot(n, daft_dsub(eye, a)) < 0) n = daft_dscale(n, -1);
    out->normal = n, out->offset = -daft_ddot(n, a), out->away = daft_ddot(n, eye) + out->offset;
    const double scale = scale_of(s) + fabs(eye.x) + fabs(eye.y) + fabs(eye.z);
    return out->away > 16e-6 * scale && out->away < 1e15;
}

/* Where a pencil sees some points: pixels, not whole numbers. */
typedef struct view_bounds {
    double x0, x1, y0, y1;
} view_bounds;

static void see_point(const daft_pencil *p, daft_dvec3 at, view_bounds *b)
{
    const double scale = (double)p->focal / at.z;
    const double x = at.x * scale + daft_pencil_middle_x(p), y = daft_pencil_middle_y(p) - at.y * scale;
    b->x0 = fmin(b->x0, x), b->x1 = fmax(b->x1, x), b->y0 = fmin(b->y0, y), b->y1 = fmax(b->y1, y);
}

/* Of a box with these corners in view space, as far as it lies before the eye. False: none does. */
static bool see_box(const daft_pencil *p, const daft_dvec3 corner[8], view_bounds *b)
{
    double farthest = 0;
    *b = (view_bounds){INFINITY, -INFINITY, INFINITY, -INFINITY};
    for (int i = 0; i < 8; i++) farthest = fmax(farthest, corner[i].z);
    const double near = farthest * 1e-4;
    for (int i = 0; i < 8; i++) {
        if (corner[i].z > near) see_point(p, corner[i], b);
        for (int bit = 1; bit < 8; bit *= 2) {
            const daft_dvec3 c = corner[i], d = corner[i ^ bit];
            if (!(c.z > near && d.z <= near)) continue;
            see_point(p, daft_dadd(c, daft_dscale(daft_dsub(d, c), (c.z - near) / (c.z - d.z))), b);
        }
    }
    return farthest > 0;
}

static daft_dvec3 bounds_corner(const daft_mesh_plane *p, int i)
{
    return daft_to_double(
        daft_v3(i & 1 ? p->high.x : p->low.x, i & 2 ? p->high.y : p->low.y, i & 4 ? p->high.z : p->low.z));
}

/* The pixels that the plane's bounds may cover, of those of the parent. False: none, or they lie behind its plane. */
static bool place_bounds(const daft_pencil *pencil, const daft_mirror *parent, const daft_instance *s,
                         const daft_mesh_plane *p, candidate *out)
{
    const daft_dvec3 x = daft_to_double(pencil->right), y = daft_to_double(pencil->up),
                     z = daft_to_double(pencil->forward), eye = parent ? parent->eye : daft_dv3(0, 0, 0);
    daft_dvec3 corner[8];
    view_bounds b;
    double before = parent ? -INFINITY : INFINITY;
    for (int i = 0; i < 8; i++) {
        const daft_dvec3 at = map_point(&s->to_frame, bounds_corner(p, i)), from = daft_dsub(at, eye);
        corner[i] = daft_dv3(daft_ddot(x, from), daft_ddot(y, from), daft_ddot(z, from));
        if (parent) before = fmax(before, daft_ddot(parent->normal, at) + parent->offset);
    }
    if (!(before > 1e-6 * scale_of(s)) || !see_box(pencil, corner, &b)) return false;
    out->x0 = parent ? parent->x0 : 0, out->x1 = parent ? parent->x1 : pencil->width - 1;
    out->y0 = parent ? parent->y0 : 0, out->y1 = parent ? parent->y1 : pencil->height - 1;
    if (b.x0 > out->x0) out->x0 = (int)fmin(b.x0, pencil->width);
    if (b.x1 < out->x1) out->x1 = (int)fmax(b.x1, -1);
    if (b.y0 > out->y0) out->y0 = (int)fmin(b.y0, pencil->height);
    if (b.y1 < out->y1) out->y1 = (int)fmax(b.y1, -1);
    return out->x0 <= out->x1 && out->y0 <= out->y1;
}

/* Where there is no room, in place of the smallest if that is smaller. */
static void add_candidate(candidates *all, const candidate *c)
{
    uint32_t at = all->count;
    if (at == MIRROR_WAITING) {
        at = 0;
        for (uint32_t i = 1; i < MIRROR_WAITING; i++)
            if (pixels_of(&all->items[i]) < pixels_of(&all->items[at])) at = i;
        if (pixels_of(c) <= pixels_of(&all->items[at])) return;
    } else {
        all->count++;
    }
    all->items[at] = *c;
}

static void add_planes(candidates *all, uint8_t parent, uint32_t number, const daft_mesh_planes *planes)
{
    const daft_frame *frame = all->frame;
    const daft_mirror *m = mirror_of(frame, parent);
    const daft_instance *s = &frame->snapshot->instances[number];
    for (uint32_t i = 0; i < planes->count; i++) {
        candidate c = {.parent = parent, .instance = number, .plane = i, .planes = planes->of};
        const daft_mesh_plane *p = &planes->planes[i];
        if (p->low.x > p->high.x || (m && m->instance == number && m->plane == i)) continue;
        if (place_plane(s, p, m ? m->eye : daft_dv3(0, 0, 0), &c) &&
            place_bounds(m ? &m->pencil : &frame->pencil, m, s, p, &c) && pixels_of(&c) >= MIRROR_BOUND)
            add_candidate(all, &c);
    }
}

/* The planes that the camera or a mirror sees. False: memory is out. */
static bool find_candidates(candidates *all, uint8_t parent)
{
    const daft_frame *frame = all->frame;
    const daft_mirror *m = mirror_of(frame, parent);
    const daft_raster *raster = m ? &m->raster : &frame->renderer->raster;
    for (uint32_t i = 0; i < raster->instance_count; i++) {
        const daft_view_instance *view = &raster->visible[i];
        const daft_mesh_planes *planes;
        if (!view->instance || (view->x1 - view->x0 + 1) * (view->y1 - view->y0 + 1) < MIRROR_BOUND) continue;
        if (!find_planes(frame, view->instance, &planes)) return false;
        if (planes) add_planes(all, parent, m ? m->numbers[i] : i, planes);
    }
    return true;
}

/* The one that may cover most pixels; of equals, the one that was found first. */
static candidate take_largest(candidates *all)
{
    uint32_t best = 0;
    for (uint32_t i = 1; i < all->count; i++)
        if (pixels_of(&all->items[i]) > pixels_of(&all->items[best])) best = i;
    const candidate c = all->items[best];
    all->count--;
    memmove(&all->items[best], &all->items[best + 1], (all->count - best) * sizeof c);
    return c;
}

static void set_mirror(const daft_frame *frame, const candidate *c, daft_mirror *m)
{
    const daft_mirror *parent = mirror_of(frame, c->parent);
    const daft_vec3 *axes = parent ? &parent->pencil.right : &frame->pencil.right;
    daft_vec3 mirrored[3];
    for (int k = 0; k < 3; k++) {
        daft_dvec3 axis = daft_to_double(axes[k]);
        mirrored[k] = daft_to_float(daft_dsub(axis, daft_dscale(c->normal, 2 * daft_ddot(axis, c->normal))));
    }
    m->parent = c->parent, m->depth = parent ? parent->depth + 1 : 1;
    m->instance = c->instance, m->plane = c->plane, m->planes = c->planes;
    m->normal = c->normal, m->offset = c->offset, m->away = c->away;
    m->eye = daft_dsub(parent ? parent->eye : daft_dv3(0, 0, 0), daft_dscale(c->normal, 2 * c->away));
    m->x0 = c->x0, m->x1 = c->x1, m->y0 = c->y0, m->y1 = c->y1;
    m->pencil = frame->pencil;
    m->pencil.right = mirrored[0], m->pencil.up = mirrored[1], m->pencil.forward = mirrored[2];
}

/* ---- what they show ---- */

/* How far the bounds reach before the plane. */
static double reach_before(const daft_mirror *m, const daft_instance *s)
{
    const daft_dvec3 n = m->normal;
    double reach = m->offset, own = m->offset;
    for (int k = 0; k < 3; k++) {
        const double by = daft_dv3_at(n, k);
        reach += by * (double)daft_v3_at(by > 0 ? s->high : s->low, k);
        own += by * (double)s->to_frame.t[k];
    }
    if (!s->mesh) return reach;
    for (int k = 0; k < 3; k++) {
        double by = 0;
        for (int i = 0; i < 3; i++) by += daft_dv3_at(n, i) * (double)s->to_frame.m[3 * i + k];
        own += by * (double)daft_v3_at(by > 0 ? s->mesh->high : s->mesh->low, k);
    }
    return fmin(reach, own);
}

static void move_by(float t[3], daft_dvec3 eye)
{
    for (int k = 0; k < 3; k++) t[k] = (float)((double)t[k] - daft_dv3_at(eye, k));
}

/* The instances that reach before the plane, seen from the mirrored eye. */
static bool fill_mirror(daft_renderer *r, const daft_snapshot *snapshot, daft_mirror *m, daft_error *error)
{
    uint32_t count = snapshot->instance_count, owner = DAFT_NOTHING;
    if (!daft_grow(&r->allocator, &m->instances, &m->instance_capacity, count, 0, sizeof *m->instances) ||
        !daft_grow(&r->allocator, &m->numbers, &m->number_capacity, count, 0, sizeof *m->numbers) ||
        (!m->raster.bins && !daft_raster_init(&m->raster, &r->allocator, r->threads, r->isa, error)))
        return daft_fail_memory(error, "what a mirror shows");
    m->count = 0;
    for (uint32_t i = 0; i < count; i++) {
        const daft_instance *s = &snapshot->instances[i];
        if (reach_before(m, s) <= 1e-6 * scale_of(s)) continue;
        if (i == m->instance) owner = m->count;
        daft_instance *moved = &m->instances[m->count];
        *moved = *s;
        move_by(moved->to_frame.t, m->eye);
        moved->low = daft_to_float(daft_dsub(daft_to_double(s->low), m->eye));
        moved->high = daft_to_float(daft_dsub(daft_to_double(s->high), m->eye));
        m->numbers[m->count++] = i;
    }
    if (!daft_raster_begin(&m->raster, &m->pencil, m->instances, m->count, error)) return false;
    m->raster.passes_holes = r->raster.passes_holes;
    m->raster.textures = r->raster.textures;
    const daft_vec3 *axes = &m->pencil.right;
    daft_vec3 *normal = &m->raster.clip.normal;
    m->raster.clip.some = true, m->raster.clip.away = (float)m->away, m->raster.clip.owner = owner;
    for (int k = 0; k < 3; k++) daft_v3_put(normal, k, (float)daft_ddot(daft_to_double(axes[k]), m->normal));
    return true;
}

static void bin_task(void *context, uint32_t index, uint32_t worker) { daft_raster_bin(context, index, worker); }

static bool add_mirror(daft_frame *frame, const candidate *c, daft_error *error)
{
    daft_renderer *r = frame->renderer;
    daft_mirror *m = &r->mirrors[frame->mirror_count];
    set_mirror(frame, c, m);
    if (!fill_mirror(r, frame->snapshot, m, error)) return false;
    daft_parallel_for(r->threads, m->raster.work_count, bin_task, &m->raster);
    for (int k = 0; k < r->threads; k++)
        if (m->raster.bins[k].out_of_memory) return daft_fail_memory(error, "what a mirror shows");
    frame->mirror_count++;
    return true;
}

/* Whether one more mirror is worth its copies of instances. */
static bool has_room(const daft_frame *frame, size_t copies)
{
    if (frame->mirror_count >= DAFT_MAX_MIRRORS) return false;
    return frame->mirror_count < MIRROR_ALWAYS || copies + frame->snapshot->instance_count <= MIRROR_COPIES;
}

static const char *reason(const daft_frame *frame)
{
    for (int i = 0; i < frame->mirror_count; i++)
        if (frame->renderer->mirrors[i].depth > 1)
            return "a mirror is seen; flat ones show a mirrored camera's picture, also in each other";
    return "a mirror is seen; flat ones show a mirrored camera's picture";
}

bool daft_mirrors_prepare(daft_frame *frame, daft_error *error)
{
    daft_renderer *r = frame->renderer;
    candidates all = {.frame = frame};
    size_t copies = 0;
    frame->mirror_count = 0;
    forget_meshes(r);
    if (!frame->plan.reflects || frame->snapshot->quality.tree != DAFT_TREE_RASTER) return true;
    bool found = find_candidates(&all, DAFT_SEEN_BY_CAMERA);
    while (found && all.count && has_room(frame, copies)) {
        const candidate c = take_largest(&all);
        const uint8_t number = (uint8_t)frame->mirror_count;
        if (!add_mirror(frame, &c, error)) return false;
        copies += r->mirrors[number].count;
        if (r->mirrors[number].depth < frame->plan.quality->mirror_depth) found = find_candidates(&all, number);
    }
    const size_t tiles = (size_t)frame->mirror_count * (size_t)r->threads;
    if (!found || !daft_grow(&r->allocator, &r->mirrored, &r->mirrored_capacity, tiles, 0, sizeof *r->mirrored))
        return daft_fail_memory(error, "what a mirror shows");
    if (frame->mirror_count) frame->plan.why[DAFT_EFFECT_REFLECTION] = reason(frame);
    return true;
}

void daft_mirrors_free(daft_renderer *r)
{
    for (int i = 0; i < DAFT_MAX_MIRRORS; i++) {
        daft_raster_free(&r->mirrors[i].raster);
        daft_release(&r->allocator, r->mirrors[i].instances);
        daft_release(&r->allocator, r->mirrors[i].numbers);
    }
    for (size_t i = 0; i < r->mirror_mesh_count; i++) daft_mesh_planes_free(&r->allocator, &r->mirror_meshes[i].planes);
    daft_release(&r->allocator, r->mirror_meshes);
    daft_release(&r->allocator, r->mirror_slots);
    daft_release(&r->allocator, r->mirrored);
}

size_t daft_mirrors_bytes(const daft_renderer *r)
{
    size_t bytes = r->mirrored_capacity * sizeof *r->mirrored + r->mirror_mesh_capacity * sizeof *r->mirror_meshes +
                   r->mirror_slot_capacity * sizeof *r->mirror_slots;
    for (size_t i = 0; i < r->mirror_mesh_count; i++)
        if (r->mirror_meshes[i].planes.of) bytes += r->mirror_meshes[i].triangles;
    for (int i = 0; i < DAFT_MAX_MIRRORS; i++) {
        const daft_mirror *m = &r->mirrors[i];
        bytes += m->instance_capacity * sizeof *m->instances + m->number_capacity * sizeof *m->numbers;
        bytes += daft_raster_bytes(&m->raster);
    }
    return bytes;
}

/* ---- a tile ---- */

static uint8_t mirror_at(const daft_frame *frame, uint8_t parent, uint32_t instance, uint32_t triangle)
{
    for (int i = 0; i < frame->mirror_count; i++) {
        const daft_mirror *m = &frame->renderer->mirrors[i];
        if (m->parent == parent && m->instance == instance && m->planes[triangle] == m->plane) return (uint8_t)i;
    }
    return DAFT_SEEN_BY_RAYS;
}

void daft_mirrors_follow(const daft_frame *frame, const daft_batch *points, uint8_t *by)
{
    for (uint32_t i = 0; i < points->count; i++) {
        uint8_t *own = &by[points->pixel[i]];
        if (*own != DAFT_SEEN_BY_RAYS) *own = mirror_at(frame, *own, points->instance[i], points->triangle[i]);
    }
}

uint32_t daft_mirrors_tile(const daft_frame *frame, uint32_t number, uint32_t worker, const uint8_t *by,
                           const daft_ray_batch *rays)
{
    const daft_renderer *r = frame->renderer;
    uint32_t count[DAFT_MAX_MIRRORS] = {0}, shown = 0;
    for (uint32_t i = 0; i < rays->count; i++) {
        const uint8_t which = by[rays->pixel[i]];
        if (which < DAFT_MAX_MIRRORS) count[which]++;
    }
    for (int i = 0; i < frame->mirror_count; i++) {
        if (count[i] < MIRROR_PIXELS) continue;
        daft_tile *out = &r->mirrored[worker * (uint32_t)frame->mirror_count + (uint32_t)i];
        r->raster_kernels->tile(&r->mirrors[i].raster, number, worker, NULL, out);
        shown |= (uint32_t)1 << i;
    }
    return shown;
}

/* A triangle in frame space: a corner, and the edges from it. Neighbouring rays often meet the same. */
typedef struct corners {
    uint32_t instance, triangle;
    daft_dvec3 a, e1, e2;
} corners;

static void set_corners(const daft_instance *s, uint32_t triangle, corners *c)
{
    const daft_trimesh *m = s->mesh;
    const uint32_t *at = &m->indices[3 * (size_t)triangle];
    daft_dvec3 p[3];
    for (int k = 0; k < 3; k++)
        p[k] = daft_to_double(daft_affine_point(&s->to_frame, daft_v3(m->x[at[k]], m->y[at[k]], m->z[at[k]])));
    c->a = p[0], c->e1 = daft_dsub(p[1], p[0]), c->e2 = daft_dsub(p[2], p[0]);
}

/* Intersects the ray with the triangle's plane, ahead of its origin. Weights are clamped to the triangle. */
static bool meet_triangle(const corners *c, daft_dvec3 o, daft_dvec3 d, daft_hit *hit)
{
    const daft_dvec3 from = daft_dsub(o, c->a);
    const daft_dvec3 p = daft_dcross(d, c->e2), q = daft_dcross(from, c->e1); /* Möller and Trumbore, 1997 */
    const double inverse = 1 / daft_ddot(c->e1, p), t = daft_ddot(c->e2, q) * inverse;
    double u = daft_ddot(from, p) * inverse, v = daft_ddot(d, q) * inverse;
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

/* False: the view does not decide it. */
static bool find_hit(const daft_frame *frame, const daft_mirror *m, const daft_tile *seen, const daft_ray_batch *rays,
                     uint32_t ray, corners *last, daft_hit *hit)
{
    const uint32_t pixel = rays->pixel[ray], number = seen->instance[pixel];
    *hit = (daft_hit){.t = INFINITY, .instance = DAFT_NOTHING};
    if (number == DAFT_NOTHING) return true;
    hit->instance = m->numbers[number], hit->triangle = seen->triangle[pixel];
    const daft_instance *s = &frame->snapshot->instances[hit->instance];
    const daft_dvec3 o =
        daft_dv3((double)rays->origin.x[ray], (double)rays->origin.y[ray], (double)rays->origin.z[ray]);
    const daft_dvec3 d =
        daft_dv3((double)rays->direction.x[ray], (double)rays->direction.y[ray], (double)rays->direction.z[ray]);
    if (!s->mesh) return meet_sphere(s, o, d, hit);
    if (last->instance != hit->instance || last->triangle != hit->triangle) {
        set_corners(s, hit->triangle, last);
        last->instance = hit->instance, last->triangle = hit->triangle;
    }
    return meet_triangle(last, o, d, hit);
}

uint32_t daft_mirrors_hits(const daft_frame *frame, uint32_t shown, uint32_t worker, const uint8_t *by,
                           const daft_ray_batch *rays, uint32_t first, uint32_t count, daft_hit *hits, uint16_t *others)
{
    const daft_renderer *r = frame->renderer;
    const daft_tile *views = &r->mirrored[worker * (uint32_t)frame->mirror_count];
    corners last = {.instance = DAFT_NOTHING};
    uint32_t left = 0;
    for (uint32_t i = 0; i < count; i++) {
        const uint8_t which = by[rays->pixel[first + i]];
        if (which >= DAFT_MAX_MIRRORS || !(shown >> which & 1) ||
            !find_hit(frame, &r->mirrors[which], &views[which], rays, first + i, &last, &hits[i]))
            others[left++] = (uint16_t)i;
    }
    return left;
}
