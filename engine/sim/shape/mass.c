/* Mass, centre and inertia of shapes of constant density, in double. Hulls: the integrals of 1, x and x·x over
 * tetrahedra (Blow and Binstock, "How to find the inertia tensor of a polyhedron", 2004; Tonon 2004). */
#include "sim/shape/shape.h"

#include "math/jacobi.h"

#include <string.h>

static void diagonal(double out[9], double x, double y, double z)
{
    memset(out, 0, 9 * sizeof *out);
    out[0] = x, out[4] = y, out[8] = z;
}

/* The cylinder's and the two half balls' inertia; a half ball's centre of mass is 3/8·r off its base. */
static void capsule_mass(double half, double r, double density, daft_mass *out)
{
    double cylinder = density * DAFT_PI * r * r * 2 * half, ball = density * DAFT_PI * 4 / 3 * r * r * r;
    double along = cylinder * r * r / 2 + ball * 2 / 5 * r * r;
    double across = cylinder * (r * r / 4 + half * half / 3) + ball * (2 * r * r / 5 + half * half + 3 * half * r / 4);
    out->mass = cylinder + ball;
    diagonal(out->inertia, across, along, across);
}

/* covariance: the integral of x·x over the volume, about the reference point. */
typedef struct integrals {
    double volume;
    double first[3];
    double covariance[9];
} integrals;

static void add_tetrahedron(integrals *sum, daft_dvec3 u, daft_dvec3 v, daft_dvec3 w)
{
    double det = daft_ddot(u, daft_dcross(v, w));
    const double a[3] = {u.x, u.y, u.z}, b[3] = {v.x, v.y, v.z}, c[3] = {w.x, w.y, w.z};
    sum->volume += det / 6;
    for (int i = 0; i < 3; i++) {
        double total = (a[i] + b[i]) + c[i];
        sum->first[i] += det / 24 * total;
        for (int j = 0; j < 3; j++)
            sum->covariance[3 * i + j] +=
                det / 120 * ((a[i] * a[j] + b[i] * b[j]) + (c[i] * c[j] + total * ((a[j] + b[j]) + c[j])));
    }
}

static void integrate_hull(const daft_hull *hull, daft_dvec3 reference, integrals *out)
{
    *out = (integrals){0};
    for (uint16_t f = 0; f < hull->face_count; f++) {
        uint16_t first = hull->first_half_edges[f], e = hull->half_edges[first].next;
        daft_dvec3 u = daft_dsub(daft_to_double(hull->vertices[hull->half_edges[first].origin]), reference);
        for (; hull->half_edges[e].next != first; e = hull->half_edges[e].next) {
            const daft_half_edge *h = &hull->half_edges[e];
            daft_dvec3 v = daft_dsub(daft_to_double(hull->vertices[h->origin]), reference);
            daft_dvec3 w = daft_dsub(daft_to_double(hull->vertices[hull->half_edges[h->next].origin]), reference);
            add_tetrahedron(out, u, v, w);
        }
    }
}

static bool hull_mass(const daft_hull *hull, double density, daft_mass *out)
{
    daft_dvec3 middle = {0, 0, 0};
    for (uint16_t i = 0; i < hull->vertex_count; i++) middle = daft_dadd(middle, daft_to_double(hull->vertices[i]));
    middle = daft_dscale(middle, 1.0 / hull->vertex_count);
    integrals sum;
    integrate_hull(hull, middle, &sum);
    if (!(sum.volume > 0)) return false;
    middle = daft_dadd(middle, daft_dscale(daft_dv3(sum.first[0], sum.first[1], sum.first[2]), 1 / sum.volume));
    integrate_hull(hull, middle, &sum); /* again about the centre, where nothing cancels */
    double trace = (sum.covariance[0] + sum.covariance[4]) + sum.covariance[8];
    for (int i = 0; i < 9; i++) out->inertia[i] = density * ((i % 4 == 0 ? trace : 0) - sum.covariance[i]);
    out->mass = density * sum.volume;
    out->centre = middle;
    return true;
}

bool daft_shape_mass(const daft_sim_shape *s, double density, daft_mass *out)
{
    *out = (daft_mass){0};
    double r = (double)s->radius;
    switch (s->type) {
    case DAFT_GEOMETRY_SPHERE:
        out->mass = density * DAFT_PI * 4 / 3 * r * r * r;
        diagonal(out->inertia, out->mass * 2 / 5 * r * r, out->mass * 2 / 5 * r * r, out->mass * 2 / 5 * r * r);
        return true;
    case DAFT_GEOMETRY_CAPSULE: capsule_mass((double)s->half_height, r, density, out); return true;
    case DAFT_GEOMETRY_BOX: {
        double x = (double)s->half.x, y = (double)s->half.y, z = (double)s->half.z;
        double m = out->mass = density * 8 * x * y * z;
        diagonal(out->inertia, m / 3 * (y * y + z * z), m / 3 * (x * x + z * z), m / 3 * (x * x + y * y));
        return true;
    }
    case DAFT_GEOMETRY_HULL: {
        if (!(s->hull->cylinder > 0)) return hull_mass(s->hull, density, out);
        double c = (double)s->hull->cylinder, h = (double)s->hull->high.y,
               m = out->mass = density * DAFT_PI * c * c * 2 * h;
        diagonal(out->inertia, m * (c * c / 4 + h * h / 3), m * c * c / 2, m * (c * c / 4 + h * h / 3));
        return true;
    }
    case DAFT_GEOMETRY_COMPOUND:
        if (!daft_shape_has_mass(s)) return false;
        for (uint32_t i = 0; i < s->compound->count; i++) {
            daft_mass child;
            daft_shape_mass(&s->compound->children[i].shape, density, &child);
            child = daft_mass_moved(&child, &s->compound->children[i].pose);
            *out = daft_mass_sum(out, &child);
        }
        return out->mass > 0;
    default: return false;
    }
}

daft_mass daft_mass_moved(const daft_mass *m, const daft_rigid *pose)
{
    daft_mass out = {.mass = m->mass, .centre = daft_rigid_point(pose, m->centre)};
    const double *r = pose->m;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            for (int k = 0; k < 3; k++)
                for (int l = 0; l < 3; l++)
                    out.inertia[3 * i + j] += r[3 * i + k] * m->inertia[3 * k + l] * r[3 * j + l];
    return out;
}

/* Steiner: what a mass whose centre is off by d adds. */
static void add_shifted(double inertia[9], const daft_mass *m, daft_dvec3 d)
{
    const double *v = &d.x;
    double square = daft_ddot(d, d);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            inertia[3 * i + j] += m->inertia[3 * i + j] + m->mass * ((i == j ? square : 0) - v[i] * v[j]);
}

daft_mass daft_mass_sum(const daft_mass *a, const daft_mass *b)
{
    double mass = a->mass + b->mass;
    if (!(mass > 0)) return (daft_mass){0};
    daft_mass out = {.mass = mass};
    out.centre = daft_dadd(a->centre, daft_dscale(daft_dsub(b->centre, a->centre), b->mass / mass));
    add_shifted(out.inertia, a, daft_dsub(a->centre, out.centre));
    add_shifted(out.inertia, b, daft_dsub(b->centre, out.centre));
    return out;
}

/* ---- principal axes ---- */

/* The unit quaternion of a rotation matrix, by the largest of its components. */
static daft_quat quat_of(const double m[9])
{
    double square[4] = {1 + m[0] - m[4] - m[8], 1 - m[0] + m[4] - m[8], 1 - m[0] - m[4] + m[8], 1 + m[0] + m[4] + m[8]};
    int best = 3;
    for (int i = 0; i < 3; i++)
        if (square[i] > square[best]) best = i;
    double s = sqrt(square[best]) / 2, k = 1 / (4 * s);
    double yz = (m[7] + m[5]) * k, xz = (m[2] + m[6]) * k, xy = (m[3] + m[1]) * k;
    double wx = (m[7] - m[5]) * k, wy = (m[2] - m[6]) * k, wz = (m[3] - m[1]) * k;
    switch (best) {
    case 0: return (daft_quat){(float)s, (float)xy, (float)xz, (float)wx};
    case 1: return (daft_quat){(float)xy, (float)s, (float)yz, (float)wy};
    case 2: return (daft_quat){(float)xz, (float)yz, (float)s, (float)wz};
    default: return (daft_quat){(float)wx, (float)wy, (float)wz, (float)s};
    }
}

void daft_mass_principal(const double inertia[9], daft_vec3 *moments, daft_quat *axes)
{
    double a[9], v[9];
    memcpy(a, inertia, sizeof a);
    diagonal(v, 1, 1, 1);
    for (int sweep = 0; sweep < 8; sweep++) /* converges quadratically; four are enough */
        daft_jacobi_rotate(a, v, 0, 1), daft_jacobi_rotate(a, v, 0, 2), daft_jacobi_rotate(a, v, 1, 2);
    *moments = daft_v3((float)a[0], (float)a[4], (float)a[8]);
    *axes = quat_of(v);
}
