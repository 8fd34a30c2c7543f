/* Where a sphere touches another shape: now, or on its way through the step.
 *
 * Both come from one function, the signed distance of a point from a shape. Along a straight line the distance to a
 * convex shape is a convex function of time, so Newton's method that starts outside approaches the first touch from
 * before it and never oversteps; the plane through that touch separates the shape from the sphere's path up to it. A
 * further convex shape needs its distance function and nothing else. */
#include "sim/internal.h"

/* Newton's method stops when the gap is below this share of the radius. Along a face it needs one iteration, at a
 * grazing edge the gap still quarters each time. */
#define SWEEP_TOLERANCE 1e-7
enum { SWEEP_ITERATIONS = 32 };

static double distance_to_sphere(const daft_sim_body *body, daft_dvec3 p, daft_dvec3 *point, daft_dvec3 *normal)
{
    daft_dvec3 d = daft_dsub(p, body->position);
    double length = sqrt(daft_ddot(d, d));
    *normal = length > 0 ? daft_dscale(d, 1 / length) : daft_dv3(0, 1, 0);
    *point = daft_dadd(body->position, daft_dscale(*normal, (double)body->radius));
    return length - (double)body->radius;
}

static daft_dvec3 to_local(const double m[9], daft_dvec3 v)
{
    return daft_dv3(m[0] * v.x + m[3] * v.y + m[6] * v.z, m[1] * v.x + m[4] * v.y + m[7] * v.z,
                    m[2] * v.x + m[5] * v.y + m[8] * v.z);
}

static daft_dvec3 to_world(const double m[9], daft_dvec3 v)
{
    return daft_dv3(m[0] * v.x + m[1] * v.y + m[2] * v.z, m[3] * v.x + m[4] * v.y + m[5] * v.z,
                    m[6] * v.x + m[7] * v.y + m[8] * v.z);
}

static double clamp(double x, double limit)
{
    return x > limit ? limit : x < -limit ? -limit : x;
}

/* Depth of a local point under one of the six faces: 0 and 1 are high and low in y, then x, then z. */
static double face_depth(daft_dvec3 p, daft_dvec3 h, int face)
{
    double sign = face & 1 ? -1 : 1;
    return face < 2 ? h.y - sign * p.y : face < 4 ? h.x - sign * p.x : h.z - sign * p.z;
}

/* p inside the box: out through a face. */
static double exit_box(daft_dvec3 p, daft_dvec3 h, int face, daft_dvec3 *point, daft_dvec3 *normal)
{
    double depth = face_depth(p, h, face), sign = face & 1 ? -1 : 1;
    *normal = daft_dv3(face >> 1 == 1 ? sign : 0, face >> 1 == 0 ? sign : 0, face >> 1 == 2 ? sign : 0);
    *point = daft_dadd(p, daft_dscale(*normal, depth));
    return -depth;
}

/* Of equal depths the first counts, so y before the others: up is the likeliest way out. */
static int nearest_face(daft_dvec3 p, daft_dvec3 h)
{
    int best = 0;
    for (int face = 1; face < 6; face++)
        if (face_depth(p, h, face) < face_depth(p, h, best)) best = face;
    return best;
}

static double distance_to_box(const daft_sim_body *body, daft_dvec3 p, daft_dvec3 *point, daft_dvec3 *normal)
{
    daft_dvec3 h = daft_to_double(body->half_extent);
    daft_dvec3 local = to_local(body->basis, daft_dsub(p, body->position));
    daft_dvec3 nearest = daft_dv3(clamp(local.x, h.x), clamp(local.y, h.y), clamp(local.z, h.z));
    daft_dvec3 d = daft_dsub(local, nearest);
    double length = sqrt(daft_ddot(d, d)), distance = length;
    daft_dvec3 n = d;
    if (length > 0)
        n = daft_dscale(d, 1 / length);
    else
        distance = exit_box(local, h, nearest_face(local, h), &nearest, &n);
    *normal = to_world(body->basis, n);
    *point = daft_dadd(body->position, to_world(body->basis, nearest));
    return distance;
}

double daft_sim_distance(const daft_sim_body *body, daft_dvec3 p, daft_dvec3 *point, daft_dvec3 *normal)
{
    return body->shape == DAFT_SHAPE_SPHERE ? distance_to_sphere(body, p, point, normal)
                                            : distance_to_box(body, p, point, normal);
}

bool daft_sim_exit(const daft_sim_body *body, daft_dvec3 p, int face, daft_dvec3 *point, daft_dvec3 *normal,
                   double *distance)
{
    if (body->shape != DAFT_SHAPE_BOX || face >= 6) return false;
    daft_dvec3 local = to_local(body->basis, daft_dsub(p, body->position)), nearest, n;
    *distance = exit_box(local, daft_to_double(body->half_extent), face, &nearest, &n);
    *normal = to_world(body->basis, n);
    *point = daft_dadd(body->position, to_world(body->basis, nearest));
    return true;
}

bool daft_sim_touch_sphere(const daft_sim_body *other, daft_dvec3 centre, double radius, daft_dvec3 motion,
                           double margin, daft_sim_touch *touch)
{
    daft_dvec3 normal;
    touch->centre = centre;
    touch->time = 0;
    double gap = daft_sim_distance(other, centre, &touch->point, &normal) - radius;
    touch->separation = gap;
    if (gap > margin) {
        for (int i = 0; i < SWEEP_ITERATIONS && gap > SWEEP_TOLERANCE * radius; i++) {
            double closing = -daft_ddot(normal, motion);
            if (closing <= 0 || (touch->time += gap / closing) > 1) return false;
            touch->centre = daft_dadd(centre, daft_dscale(motion, touch->time));
            gap = daft_sim_distance(other, touch->centre, &touch->point, &normal) - radius;
        }
        touch->separation = daft_ddot(daft_dsub(centre, touch->point), normal) - radius;
    }
    touch->normal = daft_normalize(daft_to_float(normal));
    return true;
}
