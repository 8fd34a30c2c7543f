/* sim/shape: what bodies are made of, as pure geometry. No world, no bodies; nothing here is kept between calls but
 * what the caller keeps.
 *
 *   shape.c, mass.c       making shapes, bounds, support, mass
 *   hull.c, hull_build.c  convex hulls from points
 *   mesh_shape.c          adjacency of a triangle mesh
 *   heightfield.c         the same of a grid of heights
 *   compound.c            children of a compound
 *   gjk.c, distance.c     distance and closest points
 *   cast.c, ray.c         sweeps and rays
 *
 * Public headers: shape.h triangles.h gjk.h
 *
 * Sizes 1e-4 to 1e7 m. All numbers are finite after a maker has returned true; makers refuse anything else with a
 * message. Same bits on every machine: only +, -, *, / and square roots. No function but the makers allocates. */
#ifndef DAFT_SIM_SHAPE_H
#define DAFT_SIM_SHAPE_H

#include "base/base.h"
#include "geometry/mesh.h"
#include "math/vec.h"

#define DAFT_SHAPE_MIN_SIZE 1e-4f
#define DAFT_SHAPE_MAX_SIZE 1e7f
#define DAFT_NO_FEATURE     UINT32_MAX

/* ---- where a thing is ---- */

/* A rigid frame in double. m: row-major rotation, local to parent; orthonormal to 1e-15 when made by daft_rigid_make.
 */
typedef struct daft_rigid {
    daft_dvec3 p;
    double m[9];
} daft_rigid;

/* The rotation is normalised in double first, so that m is orthonormal whatever the float quaternion's last bits are. A
 * zero or non-finite quaternion counts as no rotation. */
daft_rigid daft_rigid_make(daft_dvec3 position, daft_quat rotation);
daft_rigid daft_rigid_identity(void);
daft_rigid daft_rigid_mul(const daft_rigid *a, const daft_rigid *b);      /* b, given in a, seen from a's parent */
daft_rigid daft_rigid_relative(const daft_rigid *a, const daft_rigid *b); /* b as seen from a */
daft_rigid daft_rigid_inverse(const daft_rigid *a);

static inline daft_dvec3 daft_rigid_vector(const daft_rigid *f, daft_dvec3 v)
{
    const double *m = f->m;
    return daft_dv3((m[0] * v.x + m[1] * v.y) + m[2] * v.z, (m[3] * v.x + m[4] * v.y) + m[5] * v.z,
                    (m[6] * v.x + m[7] * v.y) + m[8] * v.z);
}
static inline daft_dvec3 daft_rigid_to_local_vector(const daft_rigid *f, daft_dvec3 v)
{
    const double *m = f->m;
    return daft_dv3((m[0] * v.x + m[3] * v.y) + m[6] * v.z, (m[1] * v.x + m[4] * v.y) + m[7] * v.z,
                    (m[2] * v.x + m[5] * v.y) + m[8] * v.z);
}
static inline daft_dvec3 daft_rigid_point(const daft_rigid *f, daft_dvec3 v)
{
    return daft_dadd(f->p, daft_rigid_vector(f, v));
}
static inline daft_dvec3 daft_rigid_to_local(const daft_rigid *f, daft_dvec3 v)
{
    return daft_rigid_to_local_vector(f, daft_dsub(v, f->p));
}

/* Bounds in float. Empty: low > high. */
typedef struct daft_aabb {
    daft_vec3 low, high;
} daft_aabb;
typedef struct daft_daabb {
    daft_dvec3 low, high;
} daft_daabb;

/* ---- shapes ---- */

typedef enum daft_geometry {
    DAFT_GEOMETRY_NONE = 0,
    DAFT_GEOMETRY_SPHERE,  /* around the origin */
    DAFT_GEOMETRY_CAPSULE, /* around a segment on the y axis, centred */
    DAFT_GEOMETRY_BOX,     /* around the origin */
    DAFT_GEOMETRY_HULL,    /* convex; vertices wherever they were given */
    DAFT_GEOMETRY_MESH,    /* triangles; static or kinematic bodies only: a surface, no inside, no mass */
    DAFT_GEOMETRY_FIELD,   /* height field; static or kinematic bodies only */
    DAFT_GEOMETRY_COMPOUND /* children of the kinds above, not of this one */
} daft_geometry;

typedef struct daft_hull daft_hull;
typedef struct daft_mesh_shape daft_mesh_shape;
typedef struct daft_height_field daft_height_field;
typedef struct daft_compound daft_compound;

/* A value to copy about. What it points to is immutable, may be shared by any number of shapes, and must outlive them.
 */
typedef struct daft_sim_shape {
    daft_geometry type;
    float radius;      /* sphere, capsule */
    float half_height; /* capsule: half the length of its core segment, 0 or more */
    daft_vec3 half;    /* box: half edge lengths */
    union {
        const daft_hull *hull;
        const daft_mesh_shape *mesh;
        const daft_height_field *field;
        const daft_compound *compound;
    };
} daft_sim_shape;

/* False with a message for sizes that are not finite or out of range. */
bool daft_shape_sphere(float radius, daft_sim_shape *out, daft_error *error);
bool daft_shape_capsule(float half_height, float radius, daft_sim_shape *out, daft_error *error);
bool daft_shape_box(daft_vec3 half, daft_sim_shape *out, daft_error *error);
daft_sim_shape daft_shape_hull(const daft_hull *hull);
daft_sim_shape daft_shape_mesh(const daft_mesh_shape *mesh);
daft_sim_shape daft_shape_field(const daft_height_field *field);
daft_sim_shape daft_shape_compound(const daft_compound *compound);

/* Whether it is sphere, capsule, box or hull. */
static inline bool daft_shape_is_convex(const daft_sim_shape *s)
{
    return s->type >= DAFT_GEOMETRY_SPHERE && s->type <= DAFT_GEOMETRY_HULL;
}
/* Whether it can be dynamic: convex, or a compound of convex children. */
bool daft_shape_has_mass(const daft_sim_shape *s);

/* Bounds as seen from the frame's parent; never smaller than the shape. */
daft_daabb daft_shape_bounds(const daft_sim_shape *s, const daft_rigid *pose);
/* No point of the shape is farther from this local point; for conservative bounds under rotation. */
float daft_shape_reach(const daft_sim_shape *s, daft_vec3 from);
/* Radius of the largest ball around `from` that fits in a convex shape, roughly (0 for others): half this is a motion
 * that cannot carry the shape's middle through a surface unseen. */
float daft_shape_inner_radius(const daft_sim_shape *s, daft_vec3 from);

/* ---- mass ---- */

/* inertia: symmetric 3x3 about the centre, local axes, row-major, kg·m². */
typedef struct daft_mass {
    double mass;
    daft_dvec3 centre;
    double inertia[9];
} daft_mass;

/* density in kg/m³. False for shapes without mass (the result is zero then). */
bool daft_shape_mass(const daft_sim_shape *s, double density, daft_mass *out);
/* The same body seen from the frame's parent. */
daft_mass daft_mass_moved(const daft_mass *m, const daft_rigid *pose);
daft_mass daft_mass_sum(const daft_mass *a, const daft_mass *b);
/* Principal moments and the rotation (local to principal axes' frame: columns are the axes), by Jacobi's method. */
void daft_mass_principal(const double inertia[9], daft_vec3 *moments, daft_quat *axes);

/* ---- hulls (hull.c) ---- */

enum {
    DAFT_HULL_MAX_VERTICES = 64,
    DAFT_HULL_MAX_FACES = 2 * DAFT_HULL_MAX_VERTICES - 4,
    DAFT_HULL_MAX_HALF_EDGES = 2 * (3 * DAFT_HULL_MAX_VERTICES - 6)
};

/* Half-edges of one face follow each other counter-clockwise seen from outside; an edge and its twin are 2i and 2i + 1.
 */
typedef struct daft_half_edge {
    uint16_t next, origin, face;
} daft_half_edge;

typedef struct daft_plane {
    daft_vec3 normal;
    float offset; /* normal·x = offset on the plane */
} daft_plane;

struct daft_hull {
    daft_allocator allocator;
    uint16_t vertex_count, face_count, half_edge_count;
    daft_vec3 *vertices;
    daft_plane *planes;         /* of faces, outward; no vertex is in front of any */
    uint16_t *first_half_edges; /* of faces */
    daft_half_edge *half_edges;
    daft_vec3 low, high;
    daft_vec3 centre; /* of mass */
    float deviation;  /* metres: how far the farthest point given sticks out, where the limit on vertices left it out */
    float cylinder;   /* its radius, where the hull stands for a cylinder around its y axis, centred; else 0 */
};

/* The convex hull of points. Coplanar faces are merged. With more than max_vertices (4 to DAFT_HULL_MAX_VERTICES, 0
 * means the most) corners it is simplified: the points that stick out farthest are kept; `deviation` says what that
 * cost. Fails for non-finite points, fewer than four, and points that are all in one plane, line or spot within
 * rounding (4e-7 of the size). */
daft_hull *daft_hull_create(const daft_allocator *allocator, const daft_vec3 *points, uint32_t count,
                            uint32_t max_vertices, daft_error *error);
/* Of the corners of a mesh's triangles, scaled. */
daft_hull *daft_hull_create_mesh(const daft_allocator *allocator, const daft_trimesh *mesh, daft_vec3 scale,
                                 uint32_t max_vertices, daft_error *error);
/* A prism of 32 sides that stands for a cylinder: mass, bounds and contacts are a cylinder's, so it rolls as one; rays
 * and casts meet the prism, which is 0.5 % of the radius within. */
daft_hull *daft_hull_create_cylinder(const daft_allocator *allocator, float radius, float half_height,
                                     daft_error *error);
bool daft_shape_is_cylinder(const daft_sim_shape *s);
void daft_hull_free(daft_hull *hull);

/* ---- triangle meshes (mesh_shape.c) ---- */

struct daft_bvh;

struct daft_mesh_shape {
    daft_allocator allocator;
    const daft_trimesh *mesh;
    const struct daft_bvh *bvh;
    uint32_t *neighbours; /* of 3·triangle + k, the edge from corner k to k + 1: the same of the edge across, or
                             DAFT_NO_FEATURE */
    bool *no_area;        /* of triangles: such are never hit */
    bool one_sided;
    bool closed; /* every edge has exactly one triangle across: a good reason to make it one-sided */
};

/* Mesh and BVH (accel's) must outlive it. Neighbours are found by the positions of vertices, so seams of doubled
 * vertices do not matter. Triangles without area are never hit. one_sided: bodies are pushed to the front of a triangle
 * (the side from which its corners run counter-clockwise) however deep they are, as closed meshes want it; otherwise to
 * the side that is nearer, as sheets want it (where a body is near to one side of a thin wedge, its other side then
 * touches it too). Rays and sweeps always stop on both sides. */
daft_mesh_shape *daft_mesh_shape_create(const daft_allocator *allocator, const daft_trimesh *mesh,
                                        const struct daft_bvh *bvh, bool one_sided, daft_error *error);
void daft_mesh_shape_free(daft_mesh_shape *shape);

/* ---- height fields (heightfield.c) ---- */

/* Heights on a grid: sample (column, row) is at x = column·spacing_x, y = heights[row·columns + column], z =
 * row·spacing_z. A cell whose corners are not all finite is a hole. Each cell is two triangles, 2·cell and 2·cell + 1,
 * cut from (0, 0) to (1, 1), with cell = row·(columns - 1) + column. The front is up; a body
 * that touches the ground is pushed up however deep it is. */
struct daft_height_field {
    daft_allocator allocator;
    uint32_t columns, rows;
    float spacing_x, spacing_z;
    float *heights;  /* a copy */
    float *ranges;   /* least and greatest height of each block of cells, level by level; NaN where all are holes */
    uint32_t levels; /* level 0: blocks of 8×8 cells; each next one halves both counts */
    uint32_t level_first[16], level_columns[16], level_rows[16];
    float low, high; /* over all cells that are no holes; low > high: all are holes */
};

/* 2 to 16,384 columns and rows; spacings 1e-4 to 1e5 m; heights within 1e7 m, or NaN. */
daft_height_field *daft_height_field_create(const daft_allocator *allocator, const float *heights, uint32_t columns,
                                            uint32_t rows, float spacing_x, float spacing_z, daft_error *error);
void daft_height_field_free(daft_height_field *field);

/* ---- compounds (compound.c) ---- */

typedef struct daft_child {
    daft_sim_shape shape;
    daft_rigid pose; /* in the compound */
} daft_child;

/* A binary tree in depth-first order: a node's first child follows it. */
typedef struct daft_compound_node {
    daft_aabb bounds;
    uint32_t second; /* the second child; 0: a leaf */
    uint32_t skip;   /* the node after this one's subtree */
    uint32_t child;  /* leaf: index into children */
} daft_compound_node;

struct daft_compound {
    daft_allocator allocator;
    uint32_t count;
    daft_child *children; /* a copy, in the order given */
    daft_compound_node *nodes;
};

/* 1 to 65,535 children, none of them a compound. */
daft_compound *daft_compound_create(const daft_allocator *allocator, const daft_child *children, uint32_t count,
                                    daft_error *error);
void daft_compound_free(daft_compound *compound);

/* ---- queries ---- */

/* child: in a compound, else 0. triangle: in a mesh or field, else DAFT_NO_FEATURE. */
typedef struct daft_shape_part {
    uint32_t child, triangle;
} daft_shape_part;

/* Closest points, in a's frame. distance 0: they overlap or touch, and points and normal mean nothing. */
typedef struct daft_distance {
    double distance;
    daft_dvec3 on_a, on_b;
    daft_dvec3 normal; /* unit, from a to b */
    daft_shape_part part_a, part_b;
} daft_distance;

/* Distance of a from b by GJK (Gilbert, Johnson and Keerthi 1988), in double. b_in_a: b as seen from a. At least one of
 * both is convex or a compound of convex children. Gives up at `limit` metres: false when they are farther apart. */
bool daft_shape_distance(const daft_sim_shape *a, const daft_sim_shape *b, const daft_rigid *b_in_a, double limit,
                         daft_distance *out);
/* Whether they overlap or are within `margin` of each other. */
bool daft_shape_overlap(const daft_sim_shape *a, const daft_sim_shape *b, const daft_rigid *b_in_a, double margin);

/* The point of a shape that is closest to a local point, within `limit`. Inside a solid shape the distance is 0 and the
 * point itself is returned. */
bool daft_shape_closest(const daft_sim_shape *s, daft_dvec3 point, double limit, daft_dvec3 *on_shape, double *distance,
                        daft_shape_part *part);

typedef struct daft_ray_result {
    double t;         /* in units of the direction */
    daft_vec3 normal; /* unit, local, against the ray */
    daft_shape_part part;
} daft_ray_result;

/* A ray in the shape's frame, 0 <= t <= tmax. A solid shape that contains the origin is hit at t = 0 with the normal
 * against the ray. False for a miss, a zero direction, or anything not finite. */
bool daft_shape_raycast(const daft_sim_shape *s, daft_dvec3 origin, daft_dvec3 direction, double tmax,
                        daft_ray_result *out);

/* A body's movement over a step: position goes in a straight line, rotation by the normalised straight line between
 * both quaternions (the shorter way). `centre`: the local point that goes straight (the centre of mass). */
typedef struct daft_sweep {
    daft_dvec3 from, to; /* of the centre */
    daft_quat rotation_from, rotation_to;
    daft_vec3 centre;
} daft_sweep;

/* The frame at time t, 0 to 1. */
daft_rigid daft_sweep_frame(const daft_sweep *sweep, double t);
daft_sweep daft_sweep_still(const daft_rigid *pose, daft_quat rotation);

typedef enum daft_impact_kind {
    DAFT_IMPACT_MISS = 0, /* apart by more than the target at all times up to 1 */
    DAFT_IMPACT_HIT,      /* at time t they are apart by the target */
    DAFT_IMPACT_OVERLAP,  /* nearer than the target at the start already */
    DAFT_IMPACT_GAVE_UP   /* out of iterations: up to time t they certainly do not touch */
} daft_impact_kind;

typedef struct daft_impact {
    double t;
    daft_dvec3 point;  /* on b, axes and origin as of the sweeps */
    daft_dvec3 normal; /* from a to b */
    daft_shape_part part_a, part_b;
} daft_impact;

/* Time of impact by conservative advancement (Mirtich 1996): the two are never nearer than `target` before t, and
 * within `target` + `tolerance` at t. Without rotation this is a shape cast. a: convex or a compound of such; b:
 * anything. Both are metres, more than 0. A part that is nearer than the target at the start, such as the ground
 * something rests on, is left to contacts and hides no other part: DAFT_IMPACT_OVERLAP means that nothing else is hit.
 */
daft_impact_kind daft_shape_impact(const daft_sim_shape *a, const daft_sweep *sweep_a, const daft_sim_shape *b,
                                   const daft_sweep *sweep_b, double target, double tolerance, daft_impact *out);
/* a, posed in b's frame, moves by `motion` without turning, and stops a millionth of its size before b. Result in b's
 * frame. An overlap with any part at the start is DAFT_IMPACT_OVERLAP with t = 0. */
daft_impact_kind daft_shape_cast(const daft_sim_shape *a, const daft_rigid *a_in_b, daft_dvec3 motion,
                                 const daft_sim_shape *b, daft_impact *out);

#endif
