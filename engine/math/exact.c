/* See exact.h. Products of two floats are exact in double; sums are kept as expansions: lists of doubles that do not
 * overlap, smallest first, whose sum is the number. */
#include "math/exact.h"

/* 2^-53: half a unit in the last place of 1 in double. */
static const double ROUNDOFF = 0x1p-53;

/* x + y = *sum + *error exactly (Knuth). */
static void two_sum(double x, double y, double *sum, double *error)
{
    double s = x + y, bb = s - x;
    *error = (x - (s - bb)) + (y - bb);
    *sum = s;
}

/* x·y = *product + *error exactly, for |x·y| well inside the range: x is split at 27 bits (Dekker), y is a float and
 * fits 24 bits, so each partial product is exact. */
static void two_product_float(double x, double y, double *product, double *error)
{
    double p = x * y, c = 134217729.0 * x, high = c - (c - x), low = x - high;
    *error = (high * y - p) + low * y;
    *product = p;
}

/* Adds y to the expansion e[0..n). Returns the new length, n + 1. */
static int grow(double *e, int n, double y)
{
    double q = y;
    for (int i = 0; i < n; i++) {
        double h;
        two_sum(q, e[i], &q, &h);
        e[i] = h;
    }
    e[n] = q;
    return n + 1;
}

static int exact_det_sign(const double a[3], const double b[3], const double c[3])
{
    double e[12];
    int n = 0;
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        double terms[2] = {a[j] * b[k], -(a[k] * b[j])}; /* exact: 24 + 24 bits */
        for (int t = 0; t < 2; t++) {
            double product, error;
            two_product_float(terms[t], c[i], &product, &error);
            n = grow(e, n, error);
            n = grow(e, n, product);
        }
    }
    for (int i = n - 1; i >= 0; i--)
        if (e[i] != 0) return e[i] > 0 ? 1 : -1;
    return 0;
}

int daft_det_sign(daft_vec3 a, daft_vec3 b, daft_vec3 c)
{
    double p[3] = {(double)a.x, (double)a.y, (double)a.z}, q[3] = {(double)b.x, (double)b.y, (double)b.z};
    double r[3] = {(double)c.x, (double)c.y, (double)c.z};
    double det = 0, size = 0;
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        double left = p[j] * q[k], right = p[k] * q[j];
        det += (left - right) * r[i];
        size += (fabs(left) + fabs(right)) * fabs(r[i]);
    }
    /* left and right are exact; the difference, the product and two sums round: 4 roundings, and 8 leaves room for
     * those of `size` itself. */
    double bound = 8 * ROUNDOFF * size;
    if (det > bound) return 1;
    if (det < -bound) return -1;
    return exact_det_sign(p, q, r);
}

/* The sign of x·w - y·z for floats: both products are exact in double. */
static int minor_sign(float x, float w, float y, float z)
{
    double left = (double)x * (double)w, right = (double)y * (double)z;
    return (left > right) - (left < right);
}

int daft_ray_side(daft_vec3 a, daft_vec3 b, daft_vec3 d)
{
    int side = daft_det_sign(a, b, d);
    if (side == 0) side = minor_sign(a.y, b.z, a.z, b.y);
    if (side == 0) side = minor_sign(a.z, b.x, a.x, b.z);
    if (side == 0) side = minor_sign(a.x, b.y, a.y, b.x);
    return side;
}

bool daft_pencil_hits(daft_vec3 a, daft_vec3 b, daft_vec3 c, daft_vec3 d)
{
    int facing = daft_det_sign(a, b, c);
    return facing != 0 && daft_ray_side(b, c, d) == facing && daft_ray_side(c, a, d) == facing &&
           daft_ray_side(a, b, d) == facing;
}

/* ---- rays from anywhere ---- */

/* x·y = *product + *error exactly (Dekker). */
static void two_product(double x, double y, double *product, double *error)
{
    double p = x * y, cx = 134217729.0 * x, cy = 134217729.0 * y;
    double xh = cx - (cx - x), xl = x - xh, yh = cy - (cy - y), yl = y - yh;
    *error = ((xh * yh - p) + xh * yl + xl * yh) + xl * yl;
    *product = p;
}

/* A difference of two floats, exactly: high + low. */
typedef struct difference {
    double high, low;
} difference;

static void subtract(daft_vec3 a, daft_vec3 o, difference out[3])
{
    two_sum((double)a.x, -(double)o.x, &out[0].high, &out[0].low);
    two_sum((double)a.y, -(double)o.y, &out[1].high, &out[1].low);
    two_sum((double)a.z, -(double)o.z, &out[2].high, &out[2].low);
}

/* Adds x·y·z to the expansion. */
static int add_product(double *e, int n, double x, double y, double z)
{
    if (x == 0 || y == 0 || z == 0) return n;
    double xy[2], term, error;
    two_product(x, y, &xy[0], &xy[1]);
    for (int i = 0; i < 2; i++) {
        if (xy[i] == 0) continue;
        two_product(xy[i], z, &term, &error);
        if (error != 0) n = grow(e, n, error);
        n = grow(e, n, term);
    }
    return n;
}

static int add_differences(double *e, int n, difference x, difference y, difference z, double sign)
{
    const double xs[2] = {sign * x.high, sign * x.low}, ys[2] = {y.high, y.low}, zs[2] = {z.high, z.low};
    for (int i = 0; i < 8; i++) n = add_product(e, n, xs[i & 1], ys[i >> 1 & 1], zs[i >> 2]);
    return n;
}

static int exact_differences_sign(const difference a[3], const difference b[3], const difference c[3])
{
    double e[6 * 8 * 4];
    int n = 0;
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        n = add_differences(e, n, a[j], b[k], c[i], 1);
        n = add_differences(e, n, a[k], b[j], c[i], -1);
    }
    for (int i = n - 1; i >= 0; i--)
        if (e[i] != 0) return e[i] > 0 ? 1 : -1;
    return 0;
}

/* The sign of det(a, b, c) of differences: in double with an error bound, then exactly. */
static int differences_sign(const difference a[3], const difference b[3], const difference c[3])
{
    double value = 0, size = 0;
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        double left = a[j].high * b[k].high, right = a[k].high * b[j].high;
        value += (left - right) * c[i].high;
        size += (fabs(left) + fabs(right)) * fabs(c[i].high);
    }
    /* three rounded factors, two products, a difference and two sums: 8 roundings; 16 leaves room for those of `size`
     */
    double bound = 16 * ROUNDOFF * size;
    if (value > bound) return 1;
    if (value < -bound) return -1;
    return exact_differences_sign(a, b, c);
}

static int side_of(const difference a[3], const difference b[3], daft_vec3 d)
{
    const difference directions[4][3] = {{{(double)d.x, 0}, {(double)d.y, 0}, {(double)d.z, 0}},
                                         {{1, 0}, {0, 0}, {0, 0}},
                                         {{0, 0}, {1, 0}, {0, 0}},
                                         {{0, 0}, {0, 0}, {1, 0}}};
    int side = 0;
    for (int i = 0; i < 4 && side == 0; i++) side = differences_sign(a, b, directions[i]);
    return side;
}

bool daft_line_hits(daft_vec3 o, daft_vec3 a, daft_vec3 b, daft_vec3 c, daft_vec3 d)
{
    difference p[3], q[3], r[3];
    subtract(a, o, p);
    subtract(b, o, q);
    subtract(c, o, r);
    int side = side_of(q, r, d);
    return side != 0 && side_of(r, p, d) == side && side_of(p, q, d) == side && differences_sign(p, q, r) != 0;
}

bool daft_line_touches(daft_vec3 o, daft_vec3 a, daft_vec3 b, daft_vec3 c, daft_vec3 d)
{
    const difference ray[3] = {{(double)d.x, 0}, {(double)d.y, 0}, {(double)d.z, 0}};
    difference p[3], q[3], r[3];
    subtract(a, o, p);
    subtract(b, o, q);
    subtract(c, o, r);
    int u = differences_sign(q, r, ray), v = differences_sign(r, p, ray), w = differences_sign(p, q, ray);
    bool left = u >= 0 && v >= 0 && w >= 0, right = u <= 0 && v <= 0 && w <= 0;
    return left != right && differences_sign(p, q, r) != 0;
}

/* ---- distances ---- */

static double det(daft_dvec3 a, daft_dvec3 b, daft_dvec3 d) { return daft_ddot(daft_dcross(a, b), d); }

void daft_pencil_weights(daft_dvec3 a, daft_dvec3 b, daft_dvec3 c, daft_vec3 d, double weight[3])
{
    daft_dvec3 ray = daft_to_double(d);
    double u = det(b, c, ray), v = det(c, a, ray), w = det(a, b, ray), sign = u + v + w < 0 ? -1 : 1;
    u *= sign, v *= sign, w *= sign;
    u = u > 0 ? u : 0, v = v > 0 ? v : 0, w = w > 0 ? w : 0;
    double sum = u + v + w;
    bool some = sum > 0;
    weight[0] = some ? u / sum : 1;
    weight[1] = some ? v / sum : 0;
    weight[2] = some ? w / sum : 0;
}

double daft_pencil_depth(daft_vec3 a, daft_vec3 b, daft_vec3 c, daft_vec3 d)
{
    double w[3];
    daft_pencil_weights(daft_to_double(a), daft_to_double(b), daft_to_double(c), d, w);
    return w[0] * (double)a.z + w[1] * (double)b.z + w[2] * (double)c.z;
}

bool daft_pencil_sphere(daft_vec3 centre, float radius, daft_vec3 d, double *t)
{
    daft_dvec3 c = daft_to_double(centre), ray = daft_to_double(d);
    double dd = daft_ddot(ray, ray), along = daft_ddot(c, ray) / dd, r = (double)radius;
    daft_dvec3 aside = daft_dsub(c, daft_dscale(ray, along));
    double discriminant = r * r - daft_ddot(aside, aside);
    if (!(discriminant >= 0)) return false;
    double half = sqrt(discriminant / dd);
    *t = along - half > 0 ? along - half : along + half;
    return *t > 0;
}
