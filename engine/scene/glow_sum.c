/* What glows of a mesh, summed up along axes of its own: a box that stands askew in its mesh is a box along these. They
 * are those of the smallest bounds, by their surface, among
 *
 * - the mesh's own, unless others are smaller by a fiftieth at least;
 * - the normals of the two largest families of parallel faces that are at right angles: of any box its own;
 * - the normal of the largest family and an edge of its largest triangle: of a rectangle its own;
 * - the principal axes of the surface: of a tube, that along it.
 *
 * Time is linear in the triangles that glow. */
#include "scene/glow.h"

#include "math/jacobi.h"

enum { FAMILIES = 16, FRAMES = 6 };

static const double SMALLER = 0.98;
static const double PARALLEL = 0.9994; /* the cosine of 2 degrees */
static const double SQUARE = 0.02;     /* the cosine of what is a right angle, but for a degree */

/* Faces that are parallel. */
typedef struct family {
    daft_dvec3 normal;    /* of the first of them, unit */
    daft_dvec3 sum;       /* of their normals times areas, all on the same side */
    double area, largest; /* of all of them, and of one */
    daft_dvec3 edges[3];  /* that one's */
} family;

typedef struct frame {
    daft_dvec3 axes[3], low, high;
} frame;

typedef struct survey {
    const daft_trimesh *mesh;
    const bool *glows;
    family families[FAMILIES];
    int family_count, frame_count;
    double area, square[9]; /* of the surface: its second moments about the mesh's origin */
    daft_dvec3 middle;      /* times the area */
    frame frames[FRAMES];
} survey;

/* ---- triangles ---- */

static bool corners_of(const survey *s, uint32_t triangle, daft_dvec3 out[3])
{
    const daft_trimesh *mesh = s->mesh;
    if (!s->glows[mesh->slots ? mesh->slots[triangle] : 0]) return false;
    for (size_t k = 0; k < 3; k++) {
        const uint32_t v = mesh->indices[3 * (size_t)triangle + k];
        out[k] = daft_dv3((double)mesh->x[v], (double)mesh->y[v], (double)mesh->z[v]);
    }
    return true;
}

/* Half of it is the triangle's area, along its normal. */
static daft_dvec3 cross_of(const daft_dvec3 c[3]) { return daft_dcross(daft_dsub(c[1], c[0]), daft_dsub(c[2], c[0])); }

static double length_of(daft_dvec3 v) { return sqrt(daft_ddot(v, v)); }

static daft_dvec3 along(const daft_dvec3 axes[3], daft_dvec3 v)
{
    return daft_dv3(daft_ddot(axes[0], v), daft_ddot(axes[1], v), daft_ddot(axes[2], v));
}

static daft_dvec3 least(daft_dvec3 a, daft_dvec3 b) { return daft_dv3(fmin(a.x, b.x), fmin(a.y, b.y), fmin(a.z, b.z)); }
static daft_dvec3 most(daft_dvec3 a, daft_dvec3 b) { return daft_dv3(fmax(a.x, b.x), fmax(a.y, b.y), fmax(a.z, b.z)); }

/* ---- axes ---- */

/* Where all are taken, the smallest goes for what is larger. */
static family *family_for(survey *s, daft_dvec3 normal, double area)
{
    family *smallest = s->families;
    for (int i = 0; i < s->family_count; i++) {
        family *f = &s->families[i];
        if (fabs(daft_ddot(f->normal, normal)) > PARALLEL) return f;
        if (f->area < smallest->area) smallest = f;
    }
    if (s->family_count < FAMILIES)
        smallest = &s->families[s->family_count++];
    else if (smallest->area >= area)
        return NULL;
    *smallest = (family){.normal = normal};
    return smallest;
}

static void add_moments(survey *s, const daft_dvec3 c[3], double area)
{
    const daft_dvec3 sum = daft_dadd(daft_dadd(c[0], c[1]), c[2]), all[4] = {c[0], c[1], c[2], sum};
    s->area += area, s->middle = daft_dadd(s->middle, daft_dscale(sum, area / 3));
    for (int k = 0; k < 4; k++) /* the integral of the products of linear functions over a triangle */
        for (int i = 0; i < 9; i++) s->square[i] += area / 12 * daft_dv3_at(all[k], i / 3) * daft_dv3_at(all[k], i % 3);
}

static void survey_triangle(survey *s, const daft_dvec3 c[3])
{
    const daft_dvec3 cross = cross_of(c);
    const double length = length_of(cross);
    if (!(length > 0)) return;
    const daft_dvec3 normal = daft_dscale(cross, 1 / length);
    add_moments(s, c, length / 2);
    family *f = family_for(s, normal, length / 2);
    if (!f) return;
    f->sum = daft_dadd(f->sum, daft_dscale(cross, daft_ddot(f->normal, normal) < 0 ? -0.5 : 0.5)),
    f->area += length / 2;
    if (!(length / 2 > f->largest)) return;
    f->largest = length / 2;
    for (int k = 0; k < 3; k++) f->edges[k] = daft_dsub(c[(k + 1) % 3], c[k]);
}

/* Axes by the first and by what of the second is at a right angle to it. */
static void add_frame(survey *s, daft_dvec3 first, daft_dvec3 second)
{
    frame *f = &s->frames[s->frame_count];
    const double length = length_of(first), side = length_of(second);
    f->axes[0] = daft_dscale(first, 1 / length);
    const daft_dvec3 across = daft_dsub(second, daft_dscale(f->axes[0], daft_ddot(f->axes[0], second)));
    const double width = length_of(across);
    if (!(length > 0) || !(width > 1e-6 * side)) return;
    f->axes[1] = daft_dscale(across, 1 / width);
    f->axes[2] = daft_dcross(f->axes[0], f->axes[1]);
    s->frame_count++;
}

static void add_frames_of_faces(survey *s)
{
    const family *first = s->families, *second = NULL;
    for (int i = 1; i < s->family_count; i++)
        if (s->families[i].area > first->area) first = &s->families[i];
    for (int i = 0; i < s->family_count; i++) {
        const family *f = &s->families[i];
        if (fabs(daft_ddot(f->normal, first->normal)) < SQUARE && (!second || f->area > second->area)) second = f;
    }
    if (second) add_frame(s, first->sum, second->sum);
    for (int k = 0; k < 3; k++) add_frame(s, first->sum, first->edges[k]);
}

static void add_principal_frame(survey *s)
{
    const double m[3] = {s->middle.x / s->area, s->middle.y / s->area, s->middle.z / s->area};
    double a[9], v[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    for (int i = 0; i < 9; i++) a[i] = s->square[i] / s->area - m[i / 3] * m[i % 3];
    for (int sweep = 0; sweep < 8; sweep++)
        daft_jacobi_rotate(a, v, 0, 1), daft_jacobi_rotate(a, v, 0, 2), daft_jacobi_rotate(a, v, 1, 2);
    add_frame(s, daft_dv3(v[0], v[3], v[6]), daft_dv3(v[1], v[4], v[7]));
}

static void bound_frames(survey *s)
{
    for (int i = 0; i < s->frame_count; i++) {
        s->frames[i].low = daft_dv3(INFINITY, INFINITY, INFINITY);
        s->frames[i].high = daft_dv3(-INFINITY, -INFINITY, -INFINITY);
    }
    for (uint32_t t = 0; t < s->mesh->triangle_count; t++) {
        daft_dvec3 c[3];
        if (!corners_of(s, t, c)) continue;
        for (int i = 0; i < 3 * s->frame_count; i++) {
            frame *f = &s->frames[i / 3];
            const daft_dvec3 p = along(f->axes, c[i % 3]);
            f->low = least(f->low, p), f->high = most(f->high, p);
        }
    }
}

static double surface_of(const frame *f)
{
    const daft_dvec3 d = daft_dsub(f->high, f->low);
    return d.x * d.y + d.y * d.z + d.z * d.x;
}

static const frame *choose_frame(survey *s)
{
    add_frame(s, daft_dv3(1, 0, 0), daft_dv3(0, 1, 0));
    for (uint32_t t = 0; t < s->mesh->triangle_count; t++) {
        daft_dvec3 c[3];
        if (corners_of(s, t, c)) survey_triangle(s, c);
    }
    if (s->area > 0) add_frames_of_faces(s), add_principal_frame(s);
    bound_frames(s);
    const frame *best = &s->frames[0];
    double limit = SMALLER * surface_of(best);
    for (int i = 1; i < s->frame_count; i++)
        if (surface_of(&s->frames[i]) < limit) best = &s->frames[i], limit = surface_of(best);
    return best;
}

/* ---- sums ---- */

/* By its largest axis, and whether it is near that along either of the others: a normal's components are no less than
 * 0. */
static int slant_of(daft_dvec3 n)
{
    const int k = n.x >= n.y && n.x >= n.z ? 0 : n.y >= n.z ? 1 : 2;
    const double near = 0.41421356 * daft_dv3_at(n, k); /* the tangent of an eighth of a turn */
    return 4 * k + 2 * (daft_dv3_at(n, (k + 1) % 3) > near) + (daft_dv3_at(n, (k + 2) % 3) > near);
}

static void add_triangle(daft_glow *sum, uint32_t slot, const daft_dvec3 corners[3])
{
    const daft_dvec3 c[3] = {along(sum->axes, corners[0]), along(sum->axes, corners[1]), along(sum->axes, corners[2])};
    const daft_dvec3 n = daft_dscale(cross_of(c), 0.5),
                     middle = daft_dscale(daft_dadd(daft_dadd(c[0], c[1]), c[2]), 1.0 / 3);
    const double area = length_of(n);
    const daft_dvec3 sizes = daft_dv3(fabs(n.x), fabs(n.y), fabs(n.z));
    const int slant = slant_of(sizes);
    sum->area += area, sum->areas[slot] += area, sum->middle = daft_dadd(sum->middle, daft_dscale(middle, area));
    sum->slanted[slant] += area, sum->slants[slant] = daft_dadd(sum->slants[slant], sizes);
    for (int axis = 0; axis < 3; axis++) {
        const double facing = daft_dv3_at(n, axis);
        const int way = 2 * axis + (facing < 0);
        sum->facing[way] += fabs(facing);
        sum->middles[way] = daft_dadd(sum->middles[way], daft_dscale(middle, fabs(facing)));
    }
}

daft_glow *daft_glow_sum(const daft_allocator *allocator, const daft_trimesh *mesh, const bool *glows)
{
    const size_t slots = daft_max_u(mesh->slot_count, 1);
    survey s = {.mesh = mesh, .glows = glows};
    daft_glow *sum = daft_alloc_zero(allocator, 1, sizeof *sum + slots * sizeof *sum->areas);
    if (!sum) return NULL;
    const frame *best = choose_frame(&s);
    for (int k = 0; k < 3; k++) sum->axes[k] = best->axes[k];
    sum->low = best->low, sum->high = best->high;
    for (uint32_t t = 0; t < mesh->triangle_count; t++) {
        daft_dvec3 c[3];
        if (corners_of(&s, t, c)) add_triangle(sum, mesh->slots ? mesh->slots[t] : 0, c);
    }
    return sum;
}
