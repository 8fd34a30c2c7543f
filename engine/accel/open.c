/* Cones of free directions (open.h). What bounds a triangle's free directions is gathered from the tree: nodes that stay below its plane
 * are passed over, those that are small from there are one ball, of the others each triangle counts. Each of these leaves out either the
 * directions into a ball or those behind a plane. The cone's axis begins as the triangle's normal and is moved away from what is
 * nearest to it, ever less. */
#include "accel/open.h"
#include "accel/find_sides.h"

enum { PLANES = 128, BALLS = 512, STEPS = 16, BLENDS = 5, TASK = 64 };
#define MARGIN   0x1p-10 /* of the mesh's size */
#define STEEPEST 1.732   /* tangent of 60 degrees: what shares a corner and rises more leaves no cone */
#define SMALL    0.15    /* a ball's radius in distances: less is not looked into */
#define UPRIGHT  0.5     /* cosine between a triangle and its corners' normals, at least */
#define LEAST    0.05    /* sine of a cone's half angle, at least */

static inline double larger(double a, double b) { return a > b ? a : b; }

/* What is left out: the directions around `way`, by half an angle. Those behind a plane are half of all. */
typedef struct blocker {
    daft_dvec3 way;
    double cosine, sine;
    double edge; /* of a plane: no place where rays may start is further along */
} blocker;

typedef struct opening {
    const daft_bvh *bvh;
    const daft_trimesh *mesh;
    uint32_t triangle, vertex[3];
    daft_dvec3 corner[3], normal, middle;
    daft_dvec3 lean[3]; /* the corners' normals */
    daft_dvec3 out[3];  /* across the edges, away from the triangle */
    double radius, margin, lift; /* of the triangle around its middle; what points may be beside it, and what they are lifted by */
    bool closed, near; /* of the tree only what shares corners is looked at, or only the rest */
    uint32_t plane_count, ball_count;
    blocker plane[PLANES], ball[BALLS]; /* plane[0]: the triangle's own */
} opening;

/* No place where rays may start is further along the unit vector. */
static double reach_along(const opening *o, daft_dvec3 way)
{
    double reach = -INFINITY, leans = 0;
    for (int k = 0; k < 3; k++) reach = larger(reach, daft_ddot(o->corner[k], way)), leans = larger(leans, daft_ddot(o->lean[k], way));
    return reach + o->margin + o->lift * leans;
}

/* What leaves out one thing often does the next. */
static void bring_forward(opening *o, uint32_t plane)
{
    const blocker b = o->plane[plane];
    o->plane[plane] = o->plane[1], o->plane[1] = b;
}

/* Directions below the plane that rises by `slope` along the unit vector `out` in the triangle's plane. */
static void add_slope(opening *o, daft_dvec3 out, double slope)
{
    daft_dvec3 n = daft_dsub(o->normal, daft_dscale(out, slope));
    daft_dvec3 way = daft_dscale(n, -1 / sqrt(daft_ddot(n, n)));
    if (o->plane_count == PLANES) o->closed = true;
    if (o->closed) return;
    o->plane[o->plane_count++] = (blocker){way, 0, 1, reach_along(o, way)};
}

static daft_dvec3 unit_of(daft_dvec3 a)
{
    double length = sqrt(daft_ddot(a, a));
    return length > 0 ? daft_dscale(a, 1 / length) : a;
}

static double height(const opening *o, daft_dvec3 p) { return daft_ddot(daft_dsub(p, o->corner[0]), o->normal); }

/* The least slope of a plane, from 0 up, that rises over all of these places; INFINITY: there is none. */
static double slope_over(const double *up, const double *along, int count)
{
    double slope = 0;
    for (int i = 0; i < count; i++)
        if (up[i] > 0) slope = along[i] > 0 ? larger(slope, up[i] / along[i]) : INFINITY;
    for (int i = 0; i < count && slope < INFINITY; i++)
        if (up[i] > 0 ? up[i] > slope * along[i] * (1 + 1e-12) : up[i] > slope * along[i]) slope = INFINITY;
    return slope;
}

/* In the triangle's plane, across the edge from corner k on, away from the triangle. */
static daft_dvec3 outward_of_edge(const opening *o, int k)
{
    daft_dvec3 out = unit_of(daft_dcross(daft_dsub(o->corner[(k + 1) % 3], o->corner[k]), o->normal));
    return daft_ddot(daft_dsub(o->corner[(k + 2) % 3], o->corner[k]), out) > 0 ? daft_dscale(out, -1) : out;
}

/* What shares a corner: lifted points must stay before the plane as well, so no corner's normal may lean behind it. */
static void add_touching(opening *o, daft_dvec3 out, double slope)
{
    const daft_dvec3 before = daft_dsub(o->normal, daft_dscale(out, slope));
    o->closed = o->closed || !(slope < STEEPEST);
    for (int k = 0; k < 3; k++) o->closed = o->closed || daft_ddot(o->lean[k], before) < 0;
    if (!o->closed) add_slope(o, out, slope);
}

/* Shares the edge from corner k on. */
static void add_beside_edge(opening *o, int k, daft_dvec3 free)
{
    double along = daft_ddot(daft_dsub(free, o->corner[k]), o->out[k]), up = height(o, free);
    add_touching(o, o->out[k], along > 0 ? up / along : INFINITY);
}

/* Shares corner k: some plane through that has the two triangles on its sides. */
static void add_beside_corner(opening *o, int k, const daft_dvec3 free[2])
{
    daft_dvec3 edge[2] = {o->out[k], o->out[(k + 2) % 3]}, best = edge[0];
    double least = INFINITY;
    for (int i = 0; i < BLENDS; i++) {
        double share = i / (BLENDS - 1.0);
        daft_dvec3 out = unit_of(daft_dadd(daft_dscale(edge[0], 1 - share), daft_dscale(edge[1], share)));
        const double up[2] = {height(o, free[0]), height(o, free[1])};
        const double along[2] = {daft_ddot(daft_dsub(free[0], o->corner[k]), out), daft_ddot(daft_dsub(free[1], o->corner[k]), out)};
        double slope = slope_over(up, along, 2);
        if (slope < least) least = slope, best = out;
    }
    add_touching(o, best, least);
}

/* The least slope along `out` of a plane that begins beyond all that may start here and rises over the corners of what is apart. */
static double slope_apart(const opening *o, daft_dvec3 out, const daft_dvec3 c[3])
{
    double reach = reach_along(o, out), up[3], along[3];
    for (int k = 0; k < 3; k++) up[k] = height(o, c[k]), along[k] = daft_ddot(c[k], out) - reach;
    return slope_over(up, along, 3);
}

/* Shares nothing: towards its middle, or across an edge. */
static void add_apart(opening *o, const daft_dvec3 c[3])
{
    for (uint32_t n = 1; n < o->plane_count; n++) {
        const blocker b = o->plane[n];
        bool behind = daft_ddot(c[0], b.way) > b.edge && daft_ddot(c[1], b.way) > b.edge && daft_ddot(c[2], b.way) > b.edge;
        if (behind) bring_forward(o, n);
        if (behind) return;
    }
    daft_dvec3 way = daft_dsub(daft_dscale(daft_dadd(c[0], daft_dadd(c[1], c[2])), 1.0 / 3), o->middle);
    daft_dvec3 best = unit_of(daft_dsub(way, daft_dscale(o->normal, daft_ddot(way, o->normal))));
    double least = slope_apart(o, best, c);
    for (int k = 0; k < 3; k++) {
        double slope = slope_apart(o, o->out[k], c);
        if (slope < least) least = slope, best = o->out[k];
    }
    if (least < INFINITY)
        add_slope(o, best, least);
    else
        o->closed = true;
}

static void meet_triangle(opening *o, uint32_t triangle)
{
    daft_dvec3 c[3], free[3];
    int shared = 0, one = 0, frees = 0;
    double most = -INFINITY;
    bool on[3] = {false};
    if (triangle == o->triangle) return;
    for (uint32_t k = 0; k < 3; k++) {
        uint32_t vertex = o->mesh->indices[3 * (size_t)triangle + k];
        int which = -1;
        c[k] = daft_corner_of(o->mesh, triangle, k);
        for (int i = 0; i < 3; i++)
            if (vertex == o->vertex[i]) which = i;
        if (which >= 0) {
            shared++, one = which, on[which] = true;
        } else {
            free[frees++] = c[k];
            most = larger(most, height(o, c[k]));
        }
    }
    if (most <= 0 || o->near != (shared > 0)) return;
    if (shared == 2)
        add_beside_edge(o, !on[2] ? 0 : !on[0] ? 1 : 2, free[0]);
    else if (shared == 1)
        add_beside_corner(o, one, free);
    else
        add_apart(o, c);
}

static void meet_leaf(opening *o, uint32_t child)
{
    const daft_block *block = &o->bvh->blocks[(child & ~DAFT_CHILD_LEAF) >> 2];
    for (uint32_t b = 0; b <= (child & 3); b++)
        for (int i = 0; i < DAFT_BLOCK && !o->closed; i++)
            if (block[b].triangle[i] != DAFT_NO_TRIANGLE) meet_triangle(o, block[b].triangle[i]);
}

/* Of a box. */
static double least_along(const daft_dvec3 *way, daft_dvec3 middle, const double half[3])
{
    return daft_ddot(*way, middle) - (fabs(way->x) * half[0] + fabs(way->y) * half[1] + fabs(way->z) * half[2]);
}

/* False: the box has to be looked into. What lies behind a plane that is known is left out already. */
static bool settle_box(opening *o, const daft_node *node, int i)
{
    double half[3], middle[3], square = 0;
    for (int k = 0; k < 3; k++) {
        double low = (double)node->bounds[k][i], high = (double)node->bounds[3 + k][i];
        middle[k] = (low + high) / 2, half[k] = (high - low) / 2;
        square += half[k] * half[k];
    }
    daft_dvec3 at = daft_dv3(middle[0], middle[1], middle[2]), way = daft_dsub(at, o->middle);
    if (least_along(&o->plane[0].way, at, half) > daft_ddot(o->corner[0], o->plane[0].way)) return true;
    for (uint32_t n = 1; n < o->plane_count; n++) {
        const blocker b = o->plane[n];
        if (!(least_along(&b.way, at, half) > b.edge)) continue;
        bring_forward(o, n);
        return true;
    }
    double away = sqrt(daft_ddot(way, way)), sine = (o->radius + o->margin + o->lift + sqrt(square)) / away;
    if (!(sine < 1) || o->near) return !(sine >= 1);
    if (!(sine < SMALL)) return false;
    if (o->ball_count == BALLS)
        o->closed = true;
    else
        o->ball[o->ball_count++] = (blocker){daft_dscale(way, 1 / away), sqrt(1 - sine * sine), sine, 0};
    return true;
}

static void gather(opening *o)
{
    uint32_t stack[DAFT_STACK];
    int top = 0;
    stack[top++] = 0;
    while (top > 0 && !o->closed) {
        const daft_node *node = &o->bvh->nodes.items[stack[--top]];
        for (int i = 0; i < DAFT_WIDTH && !o->closed; i++) {
            uint32_t child = node->child[i];
            if (child == DAFT_CHILD_NONE || settle_box(o, node, i)) continue;
            if (child & DAFT_CHILD_LEAF)
                meet_leaf(o, child);
            else
                stack[top++] = child;
        }
    }
}

/* The sine of the angle between the axis and what is left out, 1 for a right angle and more: sin(a - b), a the angle to the normal. */
static double room_beside(const blocker *b, daft_dvec3 axis)
{
    double along = daft_ddot(axis, b->way), across = sqrt(larger(1 - along * along, 0));
    if (along * b->cosine + across * b->sine <= 0) return 1;
    return across * b->cosine - along * b->sine;
}

/* The least of that, and what it is of. */
static double room_around(const opening *o, daft_dvec3 axis, const blocker **nearest)
{
    double least = 2;
    for (uint32_t i = 0; i < o->plane_count; i++) {
        double room = -daft_ddot(axis, o->plane[i].way);
        if (room < least) least = room, *nearest = &o->plane[i];
    }
    for (uint32_t i = 0; i < o->ball_count; i++) {
        double room = room_beside(&o->ball[i], axis);
        if (room < least) least = room, *nearest = &o->ball[i];
    }
    return least;
}

/* The axis is rounded to bytes first, then what that one has room for. */
static uint32_t pack(const opening *o, daft_dvec3 axis)
{
    const blocker *nearest;
    uint32_t word = 0;
    double a[3] = {rint(axis.x * 127), rint(axis.y * 127), rint(axis.z * 127)}, length = sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
    double room = room_around(o, daft_dscale(daft_dv3(a[0], a[1], a[2]), 1 / length), &nearest);
    if (!(room > LEAST)) return 0;
    double least = ceil(length * sqrt(larger(1 - room * room, 0)) + 0.01);
    if (!(least <= 126)) return 0;
    for (int k = 0; k < 3; k++) word |= (uint32_t)((int32_t)a[k] & 255) << (8 * k);
    return word | (uint32_t)larger(least, 1) << 24;
}

static uint32_t widest_cone(const opening *o)
{
    daft_dvec3 axis = o->normal, best = axis;
    double most = -1, step = 0.5;
    for (int i = 0; i < STEPS; i++, step *= 0.8) {
        const blocker *nearest = &o->plane[0];
        double room = room_around(o, axis, &nearest);
        if (room > most) most = room, best = axis;
        axis = unit_of(daft_dsub(axis, daft_dscale(nearest->way, step)));
    }
    return pack(o, best);
}

/* The side of the corners' normals is the front, as render/ has it, and points are pulled up to the tangent planes there. False:
 * the normals lean too much. */
static bool find_front(opening *o)
{
    const daft_trimesh *mesh = o->mesh;
    const uint32_t *at = mesh->normal_indices ? &mesh->normal_indices[3 * (size_t)o->triangle] : o->vertex;
    daft_dvec3 *normal = o->lean, sum = {0, 0, 0};
    o->lift = 0;
    for (int k = 0; k < 3; k++) normal[k] = o->normal;
    if (!mesh->normals) return true;
    for (int k = 0; k < 3; k++) normal[k] = daft_to_double(mesh->normals[at[k]]), sum = daft_dadd(sum, normal[k]);
    if (daft_ddot(sum, o->normal) < 0) o->normal = daft_dscale(o->normal, -1);
    for (int k = 0; k < 3; k++) {
        if (!(daft_ddot(normal[k], o->normal) > UPRIGHT)) return false;
        for (int j = 0; j < 3; j++) o->lift = larger(o->lift, daft_ddot(daft_dsub(o->corner[k], o->corner[j]), normal[k]));
    }
    return true;
}

static uint32_t cone_of(const daft_bvh *bvh, const daft_trimesh *mesh, uint32_t triangle, double margin)
{
    opening o;
    o.bvh = bvh, o.mesh = mesh, o.triangle = triangle, o.closed = false, o.plane_count = o.ball_count = 0;
    o.middle = daft_dv3(0, 0, 0), o.radius = 0;
    for (uint32_t k = 0; k < 3; k++) {
        o.corner[k] = daft_corner_of(mesh, triangle, k);
        o.vertex[k] = mesh->indices[3 * (size_t)triangle + k];
        o.middle = daft_dadd(o.middle, daft_dscale(o.corner[k], 1.0 / 3));
    }
    o.normal = unit_of(daft_dcross(daft_dsub(o.corner[1], o.corner[0]), daft_dsub(o.corner[2], o.corner[0])));
    if (!(daft_ddot(o.normal, o.normal) > 0.5) || !find_front(&o)) return 0;
    for (int k = 0; k < 3; k++) {
        daft_dvec3 d = daft_dsub(o.corner[k], o.middle);
        o.radius = larger(o.radius, sqrt(daft_ddot(d, d)));
        o.out[k] = outward_of_edge(&o, k);
    }
    o.margin = margin;
    add_slope(&o, o.normal, 0);
    o.near = true, gather(&o);
    o.near = false, gather(&o);
    return o.closed ? 0 : widest_cone(&o);
}

typedef struct open_job {
    const daft_bvh *bvh;
    const daft_trimesh *mesh;
    daft_open *out;
    uint32_t end;
} open_job;

static void find_some(void *context, uint32_t index, uint32_t worker)
{
    const open_job *job = context;
    (void)worker;
    const uint32_t first = job->out->found + index * TASK;
    for (uint32_t i = first; i < daft_min_u(first + TASK, job->end); i++)
        job->out->cone[i] = cone_of(job->bvh, job->mesh, i, (double)job->out->margin);
}

void daft_open_drop(daft_bvh *bvh)
{
    if (bvh->open) daft_release(&bvh->allocator, bvh->open->cone);
    daft_release(&bvh->allocator, bvh->open);
    bvh->open = NULL;
}

size_t daft_open_bytes(const daft_bvh *bvh)
{
    return bvh->open ? sizeof *bvh->open + bvh->open->count * sizeof *bvh->open->cone : 0;
}

static daft_open *make_open(daft_bvh *bvh, const daft_trimesh *mesh)
{
    if (bvh->nodes.count == 0) return NULL;
    daft_vec3 size = daft_sub(mesh->high, mesh->low);
    daft_open *out = daft_alloc_zero(&bvh->allocator, 1, sizeof *out);
    uint32_t *cone = daft_alloc_zero(&bvh->allocator, mesh->triangle_count, sizeof *cone);
    if (!out || !cone) {
        daft_release(&bvh->allocator, out);
        daft_release(&bvh->allocator, cone);
        return NULL;
    }
    const float margin = fmaxf(size.x, fmaxf(size.y, size.z)) * (float)MARGIN;
    *out = (daft_open){.cone = cone, .count = mesh->triangle_count, .normals = mesh->normals, .margin = margin};
    return out;
}

uint32_t daft_bvh_find_open(daft_bvh *bvh, const daft_trimesh *mesh, uint32_t triangles, int threads)
{
    if (!bvh->open) bvh->open = make_open(bvh, mesh);
    daft_open *open = bvh->open;
    if (!open) return 0;
    open_job job = {bvh, mesh, open, open->found + daft_min_u(triangles, open->count - open->found)};
    daft_parallel_for(threads, (job.end - open->found + TASK - 1) / TASK, find_some, &job);
    open->found = job.end;
    return open->count - open->found;
}
