/* The inside of manifold making: polygons in the plane of a reference face, and convex cores posed in a's frame. */
#ifndef DAFT_SIM_MANIFOLD_PARTS_H
#define DAFT_SIM_MANIFOLD_PARTS_H

#include "sim/collide/manifold.h"

/* ---- clipping (manifold_clip.c) ---- */

/* A corner of the incident polygon over the reference face: u, v in its plane, w the height above it; metres. */
typedef struct daft_clip_point {
    float u, v, w;
    uint32_t id; /* a feature of the incident one; where clipped, with the clipping edge */
} daft_clip_point;

enum { DAFT_CLIP_MAX = 136 }; /* a face of 64 corners clipped by another */

/* Clips a polygon (or a segment, count 2) by u·a + v·b <= c; edge names the clipping line in new ids. Gives the new
 * count. */
uint32_t daft_clip(const daft_clip_point *in, uint32_t count, float a, float b, float c, uint32_t edge,
                   daft_clip_point *out);
/* Where two edges overlap by no more than this fraction less than a face does, the face's axis is the one: edges hold
 * by a single point, round which what lies on it turns farther in, and of solids deep in each other the best pair of
 * edges is another one in every step. (ODE asks for 5 %.) */
#define DAFT_EDGE_FRACTION 0.1f
static inline float daft_edges_beyond(float face) { return face < 0 ? (1 - DAFT_EDGE_FRACTION) * face : face; }

/* Leaves at most four points that matter: of the deepest (within `even` of each other) one on the rim, the one farthest
 * from it, and the farthest to each side of the line between. Gives the count; the points keep their order. */
uint32_t daft_clip_reduce(daft_clip_point *points, uint32_t count, float even);

/* ---- many pairs side by side (manifold_box.h, manifold_round.h) ---- */

enum { DAFT_PAIR_LANES = 16 };

/* What kernels find: manifolds of one part of each, points from the origin of the first. */
typedef struct daft_found_lanes {
    int32_t count[DAFT_PAIR_LANES]; /* points; 0: no manifold */
    float normal[3][DAFT_PAIR_LANES];
    float point[DAFT_MANIFOLD_POINTS][3][DAFT_PAIR_LANES], separation[DAFT_MANIFOLD_POINTS][DAFT_PAIR_LANES];
    int32_t id[DAFT_MANIFOLD_POINTS][DAFT_PAIR_LANES];
} daft_found_lanes;

static inline daft_vec3 daft_lane_get(const float lanes[3][DAFT_PAIR_LANES], int lane)
{
    return daft_v3(lanes[0][lane], lanes[1][lane], lanes[2][lane]);
}

/* ---- one pair of boxes, spheres and capsules, in a lane of the kernels (manifold_single.c) ---- */

uint32_t daft_collide_boxes(daft_vec3 half_a, daft_vec3 half_b, const daft_relpose *pose, float margin,
                            daft_manifold *out, daft_pair_cache *cache);

uint32_t daft_collide_rounds(const daft_sim_shape *a, const daft_sim_shape *b, const daft_relpose *pose, float margin,
                             daft_manifold *out);
/* One is a box, the other round. False where the closest points do not decide: the core is in the box. */
bool daft_collide_round_box(const daft_sim_shape *a, const daft_sim_shape *b, const daft_relpose *pose, float margin,
                            daft_manifold *out, uint32_t *count);

/* ---- pairs of a convex part and a part that is no compound (manifold.c, cylinder.c) ---- */

/* A cylinder counts as the prism that its hull is. */
uint32_t daft_collide_plain(const daft_sim_shape *a, const daft_sim_shape *b, const daft_relpose *pose, float margin,
                            daft_manifold *out, uint32_t capacity, daft_pair_cache *cache);
/* At least one of both is a cylinder. */
uint32_t daft_collide_cylinder(const daft_sim_shape *a, const daft_sim_shape *b, const daft_relpose *pose, float margin,
                               daft_manifold *out, uint32_t capacity, daft_pair_cache *cache);

/* ---- convex cores (poly.c) ---- */

typedef enum daft_core { DAFT_CORE_POINT, DAFT_CORE_SEGMENT, DAFT_CORE_TRIANGLE, DAFT_CORE_SOLID } daft_core;

/* What a shape is without its rounding, posed in a's frame. A triangle has two faces, its front (0) and its back (1),
 * and half-edges like a solid's; a segment one pair of half-edges, no face. */
typedef struct daft_poly {
    daft_core core;
    float radius;                /* rounding */
    float size;                  /* of the core: no vertex is farther from the centre */
    daft_vec3 centre, low, high; /* of the core */
    uint32_t vertex_count, face_count, half_edge_count;
    const daft_half_edge *half_edges;
    const uint16_t *first_half_edges;
    daft_vec3 vertices[DAFT_HULL_MAX_VERTICES];
    daft_plane planes[DAFT_HULL_MAX_FACES];
} daft_poly;

/* Of a box's core: says that one is a box. As a itself it is around the origin. */
extern const daft_half_edge daft_box_half_edges[24];

/* pose: NULL for a itself. */
void daft_poly_set(daft_poly *poly, const daft_sim_shape *shape, const daft_relpose *pose);
/* In a's frame already; the normal is that of its front, unit. */
void daft_poly_set_triangle(daft_poly *poly, const daft_vec3 corners[3], daft_vec3 normal);

/* The point of a solid or a triangle nearest to p. Gives the distance; 0 inside a solid. */
float daft_poly_closest(const daft_poly *poly, daft_vec3 p, daft_vec3 *on_poly);
/* Closest points of the segments p0 p1 and q0 q1, as shares of their lengths (Ericson, "Real-Time Collision Detection",
 * 2005, 5.1.9). */
void daft_segments_closest(daft_vec3 p0, daft_vec3 p1, daft_vec3 q0, daft_vec3 q1, float *s, float *t);

static inline daft_vec3 daft_poly_edge_start(const daft_poly *p, uint32_t half_edge)
{
    return p->vertices[p->half_edges[half_edge].origin];
}

static inline daft_vec3 daft_poly_edge_end(const daft_poly *p, uint32_t half_edge)
{
    return p->vertices[p->half_edges[half_edge ^ 1].origin];
}

/* ---- separating axes of cores (sat.c) ---- */

typedef enum daft_axis_kind {
    DAFT_AXIS_NONE = 0,
    DAFT_AXIS_FACE_A,
    DAFT_AXIS_FACE_B,
    DAFT_AXIS_EDGES,
    DAFT_AXIS_CLOSEST /* between the closest points of cores that are apart, and that no face separates */
} daft_axis_kind;

typedef struct daft_axis {
    daft_axis_kind kind;
    uint32_t a, b;        /* face of either, or half-edges of both */
    float separation;     /* of the cores */
    daft_vec3 normal;     /* unit, from a to b */
    daft_vec3 on_a, on_b; /* the closest points */
} daft_axis;

/* The axis of greatest separation of two cores, at least one of them a solid or a triangle. Stops early where one is
 * over `enough`. Of about equal axes a face comes before edges and the one in the cache before others. `sides`: which
 * faces of a triangle count: 1 front, 2 back, 3 both. */
daft_axis daft_sat(const daft_poly *a, const daft_poly *b, float enough, uint32_t sides, const daft_pair_cache *cache);

/* The same for cores that overlap, but of about equal axes the best, whatever its kind: the slower answer where the
 * preferred face turns out to have nothing over it. */
daft_axis daft_sat_strict(const daft_poly *a, const daft_poly *b, uint32_t sides);

/* ---- manifolds of cores (manifold_poly.c) ---- */

typedef struct daft_face_basis {
    daft_vec3 origin, u, v, n;
} daft_face_basis;

/* What of a core looks at a face, laid in a plane parallel to the face; the same for all faces of one normal. */
typedef struct daft_face_frame {
    daft_face_basis basis;
    uint32_t incident, count;                        /* face; corners */
    daft_clip_point polygon[DAFT_HULL_MAX_VERTICES]; /* w: along the normal, from a's origin */
} daft_face_frame;

void daft_face_frame_set(daft_face_frame *frame, daft_vec3 normal, const daft_poly *other);
/* The points of `other` over a face of `mine`, at most four or all; sets the normal of `out`. frame: of the
 * face's normal and `other`. Gives how many. */
uint32_t daft_face_points(const daft_face_frame *frame, const daft_poly *mine, const daft_poly *other, uint32_t face,
                          bool is_b, float margin, bool all, daft_manifold *out,
                          daft_manifold_point points[DAFT_CLIP_MAX]);
/* The whole of a convex pair that is not special, in two steps: the axis, false where the two are farther apart than
 * the margin; and the contact. */
bool daft_axis_find(const daft_poly *a, const daft_poly *b, float margin, uint32_t sides, daft_pair_cache *cache,
                    daft_axis *out);
uint32_t daft_collide_along(const daft_poly *a, const daft_poly *b, const daft_axis *axis, float margin, uint32_t sides,
                            daft_manifold *out);
uint32_t daft_collide_polys(const daft_poly *a, const daft_poly *b, float margin, uint32_t sides, daft_manifold *out,
                            daft_pair_cache *cache);

/* ---- results of several parts ---- */

typedef struct daft_sink {
    daft_manifold *out;
    uint32_t capacity, count;
} daft_sink;

/* Adds; when full, in the place of the shallowest if that is shallower. */
void daft_sink_put(daft_sink *sink, const daft_manifold *m);

/* ---- meshes and fields (mesh_contact.c) ---- */

/* a: convex; b: mesh or field. Contacts of coplanar triangles are one manifold. */
void daft_collide_triangles(const daft_sim_shape *a, const daft_sim_shape *b, const daft_relpose *pose, float margin,
                            daft_sink *sink);

/* ---- compounds ---- */

/* Bounds of a shape whose frame is (r, p), grown by the margin and by rounding. */
daft_aabb daft_bounds_in(const daft_sim_shape *s, const float r[9], daft_dvec3 p, float margin);

#endif
