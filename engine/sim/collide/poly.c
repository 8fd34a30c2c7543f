/* Convex cores posed in a's frame, and the points of them that are closest to points. */
#include "sim/collide/manifold_parts.h"

/* Faces 2k and 2k + 1 look along -axis k and +axis k; bit k of a corner's number: it is at the high end of axis k. */
const daft_half_edge daft_box_half_edges[24] = {{2, 4, 0},  {17, 6, 5}, {4, 6, 0},  {20, 2, 3}, {6, 2, 0},  {23, 0, 4},
                                                {0, 0, 0},  {18, 4, 2}, {10, 1, 1}, {19, 3, 4}, {12, 3, 1}, {22, 7, 3},
                                                {14, 7, 1}, {21, 5, 5}, {8, 5, 1},  {16, 1, 2}, {7, 5, 2},  {13, 4, 5},
                                                {15, 0, 2}, {5, 1, 4},  {11, 6, 3}, {1, 7, 5},  {3, 3, 3},  {9, 2, 4}};
static const uint16_t box_first[6] = {0, 8, 15, 3, 23, 17};
static const daft_half_edge triangle_half_edges[6] = {{2, 0, 0}, {5, 1, 1}, {4, 1, 0}, {1, 2, 1}, {0, 2, 0}, {3, 0, 1}};
static const uint16_t triangle_first[2] = {0, 1};
static const daft_half_edge segment_half_edges[2] = {{1, 0, 0}, {0, 1, 0}};

/* Near to a in double, then turned. */
static daft_vec3 posed_point(const daft_relpose *pose, daft_vec3 v)
{
    if (!pose) return v;
    daft_vec3 d = daft_to_float(daft_dsub(daft_to_double(v), pose->q));
    const float *r = pose->r;
    return daft_v3((r[0] * d.x + r[1] * d.y) + r[2] * d.z, (r[3] * d.x + r[4] * d.y) + r[5] * d.z,
                   (r[6] * d.x + r[7] * d.y) + r[8] * d.z);
}

static daft_plane posed_plane(const daft_relpose *pose, daft_vec3 n, float offset)
{
    if (!pose) return (daft_plane){n, offset};
    const float *r = pose->r;
    daft_vec3 turned = daft_v3((r[0] * n.x + r[1] * n.y) + r[2] * n.z, (r[3] * n.x + r[4] * n.y) + r[5] * n.z,
                               (r[6] * n.x + r[7] * n.y) + r[8] * n.z);
    return (daft_plane){turned, (float)((double)offset - daft_ddot(daft_to_double(n), pose->q))};
}

static void set_topology(daft_poly *poly, const daft_half_edge *edges, const uint16_t *first, uint32_t vertices,
                         uint32_t faces, uint32_t half_edges)
{
    poly->half_edges = edges, poly->first_half_edges = first;
    poly->vertex_count = vertices, poly->face_count = faces, poly->half_edge_count = half_edges;
}

static void set_extent(daft_poly *poly)
{
    daft_vec3 low = poly->vertices[0], high = low;
    for (uint32_t i = 1; i < poly->vertex_count; i++) {
        low = daft_min3(low, poly->vertices[i]);
        high = daft_max3(high, poly->vertices[i]);
    }
    poly->low = low, poly->high = high;
    poly->centre = daft_scale(daft_add(low, high), 0.5f);
    poly->size = 0.5f * daft_length(daft_sub(high, low));
}

static void set_box(daft_poly *poly, daft_vec3 h, const daft_relpose *pose)
{
    poly->core = DAFT_CORE_SOLID;
    set_topology(poly, daft_box_half_edges, box_first, 8, 6, 24);
    for (uint32_t i = 0; i < 8; i++)
        poly->vertices[i] = posed_point(pose, daft_v3(i & 1 ? h.x : -h.x, i & 2 ? h.y : -h.y, i & 4 ? h.z : -h.z));
    for (int k = 0; k < 3; k++)
        for (int high = 0; high < 2; high++) {
            float s = high ? 1.0f : -1.0f;
            daft_vec3 n = daft_v3(k == 0 ? s : 0, k == 1 ? s : 0, k == 2 ? s : 0);
            poly->planes[2 * k + high] = posed_plane(pose, n, daft_v3_at(h, k));
        }
}

static void set_hull(daft_poly *poly, const daft_hull *hull, const daft_relpose *pose)
{
    poly->core = DAFT_CORE_SOLID;
    set_topology(poly, hull->half_edges, hull->first_half_edges, hull->vertex_count, hull->face_count,
                 hull->half_edge_count);
    for (uint32_t i = 0; i < hull->vertex_count; i++) poly->vertices[i] = posed_point(pose, hull->vertices[i]);
    for (uint32_t i = 0; i < hull->face_count; i++)
        poly->planes[i] = posed_plane(pose, hull->planes[i].normal, hull->planes[i].offset);
}

void daft_poly_set(daft_poly *poly, const daft_sim_shape *shape, const daft_relpose *pose)
{
    poly->radius = 0;
    switch (shape->type) {
    case DAFT_GEOMETRY_BOX: set_box(poly, shape->half, pose); break;
    case DAFT_GEOMETRY_HULL: set_hull(poly, shape->hull, pose); break;
    case DAFT_GEOMETRY_CAPSULE:
        poly->core = DAFT_CORE_SEGMENT;
        poly->radius = shape->radius;
        set_topology(poly, segment_half_edges, NULL, 2, 0, 2);
        poly->vertices[0] = posed_point(pose, daft_v3(0, -shape->half_height, 0));
        poly->vertices[1] = posed_point(pose, daft_v3(0, shape->half_height, 0));
        break;
    default:
        poly->core = DAFT_CORE_POINT;
        poly->radius = shape->radius;
        set_topology(poly, NULL, NULL, 1, 0, 0);
        poly->vertices[0] = posed_point(pose, daft_v3(0, 0, 0));
        break;
    }
    set_extent(poly);
}

void daft_poly_set_triangle(daft_poly *poly, const daft_vec3 corners[3], daft_vec3 normal)
{
    poly->core = DAFT_CORE_TRIANGLE;
    poly->radius = 0;
    set_topology(poly, triangle_half_edges, triangle_first, 3, 2, 6);
    float nearest = INFINITY, offset = 0;
    for (int k = 0; k < 3; k++) {
        poly->vertices[k] = corners[k];
        float square = daft_dot(corners[k], corners[k]); /* the corner nearest to a says best where the plane is */
        if (square < nearest) nearest = square, offset = daft_dot(normal, corners[k]);
    }
    poly->planes[0] = (daft_plane){normal, offset};
    poly->planes[1] = (daft_plane){daft_neg(normal), -offset};
    set_extent(poly);
}

/* ---- closest points ---- */

static float clamp01(float x) { return x > 0 ? x < 1 ? x : 1 : 0; }

void daft_segments_closest(daft_vec3 p0, daft_vec3 p1, daft_vec3 q0, daft_vec3 q1, float *s, float *t)
{
    daft_vec3 d1 = daft_sub(p1, p0), d2 = daft_sub(q1, q0), r = daft_sub(p0, q0);
    float a = daft_dot(d1, d1), e = daft_dot(d2, d2), f = daft_dot(d2, r), c = daft_dot(d1, r), b = daft_dot(d1, d2);
    float determinant = a * e - b * b;
    *s = determinant > 1e-6f * a * e ? clamp01((b * f - c * e) / determinant)
         : e > 0 || !(a > 0)         ? 0.5f
                                     : clamp01(-c / a);
    *t = e > 0 ? (b * *s + f) / e : 0;
    if (*t < 0 || *t > 1) {
        *t = clamp01(*t);
        *s = a > 0 ? clamp01((*t * b - c) / a) : 0;
    }
}

/* On the polygon of a face. */
static daft_vec3 closest_on_face(const daft_poly *poly, uint32_t face, daft_vec3 p, float height)
{
    daft_vec3 n = poly->planes[face].normal, best = daft_sub(p, daft_scale(n, height));
    float least = INFINITY;
    uint32_t first = poly->first_half_edges[face], e = first;
    do {
        daft_vec3 from = daft_poly_edge_start(poly, e), d = daft_sub(daft_poly_edge_end(poly, e), from);
        daft_vec3 w = daft_sub(p, from);
        if (daft_dot(daft_cross(d, n), w) > 0) {
            float square = daft_dot(d, d), t = square > 0 ? clamp01(daft_dot(w, d) / square) : 0;
            daft_vec3 on = daft_add(from, daft_scale(d, t)), gap = daft_sub(p, on);
            float distance = daft_dot(gap, gap);
            if (distance < least) least = distance, best = on;
        }
        e = poly->half_edges[e].next;
    } while (e != first);
    return best;
}

float daft_poly_closest(const daft_poly *poly, daft_vec3 p, daft_vec3 *on_poly)
{
    float least = INFINITY;
    bool outside = false;
    for (uint32_t f = 0; f < poly->face_count; f++) {
        float height = daft_dot(poly->planes[f].normal, p) - poly->planes[f].offset;
        if (height < 0 || (outside && height * height >= least)) continue;
        daft_vec3 on = closest_on_face(poly, f, p, height), gap = daft_sub(p, on);
        float square = daft_dot(gap, gap);
        outside = true;
        if (square < least) least = square, *on_poly = on;
    }
    if (outside) return sqrtf(least);
    *on_poly = p;
    return 0;
}
