/* Sculptures: solids given by a signed distance, turned into quadrilaterals by surface nets (Gibson 1998): a sitting
 * cat and a woman with a lamp for the hall, a bust and a torso for the gallery. A net has one vertex for each cell that
 * the surface crosses, put where the distance is zero along its gradient; four cells around an edge that crosses it
 * make a face. The OBJ counts its vertices backwards (`f -1 -40 …`), which keeps the file short. */
#include "mesh.h"

#include <math.h>
#include <stdlib.h>

static const double TAU = 6.283185307179586;

/* ---- distances: metres, negative inside ---- */

/* A sharp union where `blend` is 0, else one with a fillet of about that radius. */
static double join(double a, double b, double blend)
{
    double h = fmax(blend - fabs(a - b), 0);
    return fmin(a, b) - (blend > 0 ? h * h / (4 * blend) : 0);
}

/* Near enough to the distance for shapes that are not much longer than wide. */
static double ellipsoid(vec p, vec center, vec r)
{
    vec q = sub(p, center), k = v3(q.x / r.x, q.y / r.y, q.z / r.z);
    vec g = v3(q.x / (r.x * r.x), q.y / (r.y * r.y), q.z / (r.z * r.z));
    double l = length(k), m = length(g);
    return m > 1e-9 ? l * (l - 1) / m : -fmin(r.x, fmin(r.y, r.z));
}

/* Between two balls. */
static double limb(vec p, vec a, double ra, vec b, double rb)
{
    vec d = sub(b, a), q = sub(p, a);
    double t = clamp01((q.x * d.x + q.y * d.y + q.z * d.z) / (d.x * d.x + d.y * d.y + d.z * d.z));
    return length(sub(q, times(d, t))) - (ra + (rb - ra) * t);
}

static double slab(vec p, vec center, vec half, double round)
{
    vec q = sub(p, center), d = v3(fabs(q.x) - half.x + round, fabs(q.y) - half.y + round, fabs(q.z) - half.z + round);
    return length(v3(fmax(d.x, 0), fmax(d.y, 0), fmax(d.z, 0))) + fmin(fmax(d.x, fmax(d.y, d.z)), 0) - round;
}

/* A ring about the direction `axis` (unit). */
static double ring(vec p, vec center, vec axis, double major, double minor)
{
    vec q = sub(p, center);
    double along = q.x * axis.x + q.y * axis.y + q.z * axis.z, out = length(sub(q, times(axis, along))) - major;
    return sqrt(along * along + out * out) - minor;
}

/* ---- the cat: sits, looks along +Z, 1.5 m tall with its plinth ---- */

static double cat_side(vec p) /* x is never negative: both sides are one */
{
    double d = ellipsoid(p, v3(0.20, 0.27, -0.04), v3(0.15, 0.24, 0.26)); /* thigh */
    d = join(d, ellipsoid(p, v3(0.235, 0.055, 0.17), v3(0.068, 0.06, 0.15)), 0.05);
    double fore = limb(p, v3(0.105, 0.74, 0.10), 0.085, v3(0.098, 0.10, 0.205), 0.058);
    fore = join(fore, ellipsoid(p, v3(0.098, 0.05, 0.25), v3(0.068, 0.055, 0.10)), 0.05);
    for (int i = -1; i <= 1; i++) /* clefts between the toes */
        if (i)
            fore = -join(-fore,
                         limb(p, v3(0.098 + 0.022 * i, 0.045, 0.30), 0.006, v3(0.098 + 0.028 * i, 0.03, 0.37), 0.009),
                         0.02);
    return join(d, fore, 0.03);
}

static double cat_head(vec p, vec q) /* q: p with x made positive */
{
    double d = ellipsoid(p, v3(0, 1.18, 0.10), v3(0.168, 0.145, 0.160));
    d = join(d, ellipsoid(q, v3(0.085, 1.145, 0.16), v3(0.085, 0.075, 0.09)), 0.05);   /* cheek */
    d = join(d, ellipsoid(q, v3(0.032, 1.117, 0.245), v3(0.048, 0.042, 0.055)), 0.03); /* muzzle */
    d = join(d, ellipsoid(p, v3(0, 1.075, 0.215), v3(0.045, 0.035, 0.05)), 0.03);      /* chin */
    d = join(d, limb(p, v3(0, 1.24, 0.215), 0.028, v3(0, 1.15, 0.285), 0.020), 0.04);  /* bridge and nose */
    d = -join(-d, ellipsoid(q, v3(0.083, 1.205, 0.262), v3(0.046, 0.026, 0.034)), 0.02);
    d = join(d, ellipsoid(q, v3(0.080, 1.203, 0.222), v3(0.036, 0.027, 0.036)), 0.005); /* eye */
    vec r = v3(q.x, q.y, (p.z - 0.075) * 1.7 + 0.075);                                  /* ears are flat */
    double ear = limb(r, v3(0.105, 1.27, 0.075), 0.085, v3(0.150, 1.495, 0.075), 0.008);
    ear = -join(
        -ear,
        limb(v3(q.x, q.y, (p.z - 0.135) * 1.5 + 0.135), v3(0.108, 1.275, 0.135), 0.062, v3(0.146, 1.46, 0.135), 0.006),
        0.02);
    return join(d, ear, 0.03);
}

static double cat(vec p)
{
    vec q = v3(fabs(p.x), p.y, p.z);
    double d = ellipsoid(p, v3(0, 0.30, -0.13), v3(0.27, 0.31, 0.33));
    d = join(d, limb(p, v3(0, 0.40, -0.10), 0.24, v3(0, 0.84, 0.06), 0.165), 0.12);
    d = join(d, ellipsoid(p, v3(0, 0.72, 0.10), v3(0.16, 0.22, 0.14)), 0.08);
    d = join(d, limb(p, v3(0, 0.86, 0.05), 0.13, v3(0, 1.10, 0.08), 0.105), 0.08);
    d = join(d, cat_side(q), 0.035);
    d = join(d, cat_head(p, q), 0.05);
    d = join(d, ring(p, v3(0, 0.985, 0.075), v3(0, 0.966, 0.259), 0.125, 0.022), 0.006);
    d = join(d, ellipsoid(p, v3(0, 0.925, 0.215), v3(0.035, 0.045, 0.02)), 0.006);
    for (int i = 0; i < 14; i++) { /* the tail lies around its right side */
        double a = TAU * (0.75 + 0.034 * i), b = TAU * (0.75 + 0.034 * (i + 1)), s = 0.062 - 0.0016 * i;
        vec from = v3(0.40 * cos(a), s, -0.02 + 0.46 * sin(a)), to = v3(0.40 * cos(b), s, -0.02 + 0.46 * sin(b));
        d = join(d, limb(p, from, s, to, s - 0.0016), 0.01);
    }
    return join(d, slab(p, v3(0, -0.06, -0.02), v3(0.50, 0.065, 0.56), 0.02), 0.012);
}

/* ---- the woman with a lamp: looks along +Z, 2.1 m to the flame ---- */

/* The robe: a profile turned about a leaning axis, in folds that run down and fan out. */
static double robe(vec p)
{
    double y = p.y, lean = 0.035 * sin(3.0 * y), x = p.x - lean, z = p.z + 0.02 * sin(2.5 * y);
    double angle = atan2(z, x), down = clamp01(1 - y / 1.12);
    double radius = 0.145 + 0.19 * pow(down, 1.25) + 0.05 * exp(-pow((y - 0.92) / 0.16, 2));
    double fold = fabs(sin(6.5 * angle + 1.1 * sin(2.2 * y) + 0.6 * sin(2 * angle + 3 * y)));
    radius += (0.008 + 0.055 * pow(down, 1.2)) * (fold - 0.5) + 0.014 * down * sin(21 * angle + 5 * y);
    double flat = sqrt(x * x + z * z * (1 + 0.55 * clamp01(y / 0.9))); /* hips are wider than deep */
    return fmax(0.6 * (flat - radius), fmax(y - 1.12, -0.02 - y));
}

static double bust(vec p, vec q)
{
    double d = ellipsoid(p, v3(0, 1.25, -0.005), v3(0.150, 0.22, 0.108));
    d = join(d, ellipsoid(q, v3(0.072, 1.275, 0.078), v3(0.066, 0.070, 0.062)), 0.035);
    d = join(d, limb(q, v3(0, 1.425, -0.01), 0.062, v3(0.175, 1.405, -0.01), 0.060), 0.06);
    double pleat = 0.006 * sin(60 * p.x + 12 * p.y) * smoothstep(1.44, 1.30, p.y);
    d += pleat;
    d = join(d, ring(v3(p.x, p.y, p.z * 1.3), v3(0.01, 1.085, 0), v3(0, 1, 0), 0.148, 0.020), 0.012); /* girdle */
    return join(d, limb(p, v3(0, 1.42, -0.012), 0.058, v3(0.008, 1.565, 0.012), 0.050), 0.05);
}

static double head(vec p)
{
    double c = cos(0.25), s = sin(0.25); /* she looks a little to the lamp */
    vec o = v3(0.008, 1.665, 0.02), q = sub(p, o);
    q = v3(c * q.x - s * q.z, q.y, s * q.x + c * q.z);
    vec m = v3(fabs(q.x), q.y, q.z);
    double d = ellipsoid(q, v3(0, 0.02, 0), v3(0.080, 0.100, 0.096));
    d = join(d, ellipsoid(q, v3(0, -0.055, 0.028), v3(0.056, 0.062, 0.062)), 0.04);       /* jaw */
    d = join(d, limb(q, v3(0, 0.020, 0.092), 0.008, v3(0, -0.030, 0.111), 0.012), 0.018); /* nose */
    d = -join(-d, ellipsoid(m, v3(0.034, 0.012, 0.096), v3(0.022, 0.013, 0.017)), 0.012);
    d = join(d, ellipsoid(m, v3(0.032, 0.010, 0.078), v3(0.016, 0.010, 0.012)), 0.006); /* eye */
    d = join(d, limb(m, v3(0.006, -0.062, 0.088), 0.007, v3(0.018, -0.060, 0.080), 0.004), 0.008);
    d = join(d, limb(m, v3(0, -0.072, 0.086), 0.008, v3(0.012, -0.070, 0.080), 0.004), 0.006);
    d = join(d, ellipsoid(q, v3(0, -0.100, 0.062), v3(0.024, 0.020, 0.024)), 0.03); /* chin */
    double wave = 0.005 * sin(55 * atan2(q.x, q.y + 0.02) + 30 * q.z);
    double hair = ellipsoid(q, v3(0, 0.045, -0.022), v3(0.098, 0.100, 0.104)) + wave;
    hair = -join(-hair, ellipsoid(q, v3(0, -0.01, 0.125), v3(0.068, 0.088, 0.085)), 0.02); /* the face is free */
    double bun = ellipsoid(q, v3(0, 0.035, -0.140), v3(0.058, 0.055, 0.055)) + 0.004 * sin(90 * (q.x + q.y));
    hair = join(hair, bun, 0.015);
    hair = join(hair, ring(q, v3(0, 0.075, -0.02), v3(0, 0.83, -0.55), 0.088, 0.010), 0.004); /* a fillet */
    return join(d, hair, 0.006);
}

static double arms(vec p)
{
    double right = limb(p, v3(-0.185, 1.405, -0.01), 0.054, v3(-0.335, 1.515, 0.04), 0.043); /* up to the lamp */
    right = join(right, limb(p, v3(-0.335, 1.515, 0.04), 0.041, v3(-0.290, 1.760, 0.12), 0.029), 0.02);
    right = join(right, ellipsoid(p, v3(-0.285, 1.800, 0.128), v3(0.036, 0.050, 0.036)), 0.02);
    double left = limb(p, v3(0.185, 1.405, -0.01), 0.054, v3(0.262, 1.150, -0.03), 0.043); /* down to the robe */
    left = join(left, limb(p, v3(0.262, 1.150, -0.03), 0.041, v3(0.232, 0.930, 0.085), 0.029), 0.02);
    left = join(left, ellipsoid(p, v3(0.222, 0.890, 0.105), v3(0.033, 0.048, 0.034)), 0.02);
    return fmin(right, left);
}

static double lamp(vec p)
{
    vec q = sub(p, v3(-0.283, 1.84, 0.13));
    double r = sqrt(q.x * q.x + q.z * q.z), d = limb(q, v3(0, -0.12, 0), 0.016, v3(0, 0.03, 0), 0.020);
    double bowl = fmax(ellipsoid(q, v3(0, 0.085, 0), v3(0.095, 0.075, 0.095)), q.y - 0.095);
    d = join(d, fmax(bowl, 0.02 - q.y), 0.01);
    d = join(d, ring(q, v3(0, 0.095, 0), v3(0, 1, 0), 0.090, 0.010), 0.004);
    double twist = atan2(q.z, q.x) + 9 * q.y,
           flame = 0.058 * sin(clamp01((q.y - 0.07) / 0.23) * 2.6) + 0.010 * sin(3 * twist);
    return join(d, fmax(0.6 * (r - flame), fmax(0.07 - q.y, q.y - 0.29)), 0.01);
}

/* A cloth over the left shoulder, around the hip and over the left arm. */
static double shawl(vec p)
{
    vec axis = normal_of(v3(0.55, 0.83, 0.06)), q = v3(p.x, p.y, p.z * 1.22);
    double fold = 0.010 * sin(34 * (p.x * axis.x + p.y * axis.y) + 5 * p.z);
    double d = ring(q, v3(0.02, 1.19, 0), axis, 0.190, 0.034) + fold;
    double fall = limb(p, v3(0.262, 1.10, -0.035), 0.040, v3(0.300, 0.42, -0.02), 0.052) +
                  0.012 * sin(16 * atan2(p.z, p.x - 0.28) + 4 * p.y);
    return join(d, fall, 0.03);
}

static double woman(vec p)
{
    vec q = v3(fabs(p.x), p.y, p.z);
    double d = join(robe(p), bust(p, q), 0.05);
    d = join(d, ellipsoid(p, v3(-0.085, 0.60, 0.115), v3(0.095, 0.24, 0.105)), 0.06); /* the free knee */
    d = join(d, ellipsoid(p, v3(-0.11, 0.025, 0.315), v3(0.05, 0.035, 0.095)), 0.02);
    d = join(d, ellipsoid(p, v3(0.09, 0.025, 0.290), v3(0.05, 0.035, 0.095)), 0.02);
    d = join(d, arms(p), 0.025), d = join(d, shawl(p), 0.015), d = join(d, head(p), 0.02), d = join(d, lamp(p), 0.008);
    double round = sqrt(p.x * p.x + p.z * p.z) - 0.46;
    return join(d, fmax(round, fabs(p.y + 0.05) - 0.05), 0.015);
}

/* ---- for the gallery: her head on a foot, 0.5 m tall, and a torso, 1.1 m tall; both look along +Z ---- */

static double head_and_foot(vec p)
{
    vec at = add(p, v3(0, 1.18, 0)), q = v3(fabs(at.x), at.y, at.z);
    double d = join(head(at), bust(at, q), 0.02);
    double cut = length(v3(at.x * 0.8, fmin(at.y - 1.52, 0), at.z * 1.1)) - 0.215; /* its lower edge is round */
    d = fmax(d, cut);
    double round = sqrt(p.x * p.x + p.z * p.z);
    double foot = fmax(round - 0.045 - 0.05 * exp(-pow(p.y / 0.05, 2)), fmax(p.y - 0.16, -p.y));
    d = join(d, foot, 0.03);
    return join(d, slab(p, v3(0, 0.015, 0), v3(0.115, 0.025, 0.115), 0.008), 0.01);
}

/* It rests on its right leg: the hips lean one way, the shoulders the other. */
static double torso(vec p)
{
    double y = p.y, lean = 0.035 * sin(3.4 * y - 0.6), tilt = 0.16 * (0.52 - y);
    p = v3(p.x - lean, y + tilt * p.x, p.z - 0.018 * sin(5 * y));
    vec q = v3(fabs(p.x), p.y, p.z);
    double d = ellipsoid(p, v3(0, 0.79, -0.005), v3(0.180, 0.200, 0.120));
    d = join(d, ellipsoid(p, v3(0, 0.55, 0.012), v3(0.132, 0.210, 0.100)), 0.08);
    d = join(d, ellipsoid(p, v3(0, 0.345, -0.012), v3(0.182, 0.140, 0.125)), 0.08);
    d = join(d, ellipsoid(q, v3(0.088, 0.31, -0.075), v3(0.095, 0.105, 0.085)), 0.04);
    d = join(d, ellipsoid(q, v3(0.082, 0.795, 0.088), v3(0.072, 0.072, 0.062)), 0.035);
    d = join(d, limb(q, v3(0.095, 0.32, 0), 0.108, v3(0.088, -0.04, 0.025), 0.078), 0.035);
    d = join(d, limb(q, v3(0, 0.945, -0.015), 0.065, v3(0.185, 0.925, -0.015), 0.068), 0.06);
    d = join(d, limb(q, v3(0.205, 0.905, -0.02), 0.064, v3(0.235, 0.745, -0.04), 0.050), 0.04);
    d = join(d, limb(p, v3(0, 0.95, -0.012), 0.062, v3(0.01, 1.09, 0.012), 0.056), 0.05);
    d = -join(-d, ellipsoid(p, v3(0, 0.515, 0.118), v3(0.010, 0.014, 0.02)), 0.02); /* navel */
    d = -join(-d, limb(p, v3(0, 0.74, 0.135), 0.004, v3(0, 0.56, 0.125), 0.004), 0.03);
    d = -join(-d, limb(p, v3(0, 0.85, -0.135), 0.006, v3(0, 0.42, -0.13), 0.010), 0.05);
    return fmax(d, fmax(y - 1.06, -y)); /* broken off at the neck and above the knees */
}

/* ---- surface nets ---- */

typedef double solid(vec p);

typedef struct net {
    solid *inside;
    vec low;
    double cell;
    int n[3];
    float *distance; /* at (n[0]+1)(n[1]+1)(n[2]+1) grid points */
    int *vertex;     /* of each cell; 0: none, else counted from 1 */
    FILE *file;
    int count;
} net;

static size_t grid_index(const net *s, int x, int y, int z)
{
    return ((size_t)y * (size_t)(s->n[2] + 1) + (size_t)z) * (size_t)(s->n[0] + 1) + (size_t)x;
}

static vec gradient(const net *s, vec p)
{
    double e = 0.1 * s->cell, d = s->inside(p);
    return times(
        v3(s->inside(add(p, v3(e, 0, 0))) - d, s->inside(add(p, v3(0, e, 0))) - d, s->inside(add(p, v3(0, 0, e))) - d),
        1 / e);
}

/* The mean of where the cell's edges cross the surface, then moved onto it. */
static vec net_vertex(const net *s, int x, int y, int z)
{
    vec sum = v3(0, 0, 0);
    int crossed = 0;
    for (int i = 0; i < 8; i++) {
        for (int axis = 0; axis < 3; axis++) {
            int j = i | 1 << axis;
            if (i == j) continue;
            double a = (double)s->distance[grid_index(s, x + (i & 1), y + (i >> 1 & 1), z + (i >> 2))];
            double b = (double)s->distance[grid_index(s, x + (j & 1), y + (j >> 1 & 1), z + (j >> 2))];
            if ((a < 0) == (b < 0)) continue;
            double t = a / (a - b);
            vec from = v3(i & 1, i >> 1 & 1, i >> 2), to = v3(j & 1, j >> 1 & 1, j >> 2);
            sum = add(sum, add(from, times(sub(to, from), t))), crossed++;
        }
    }
    vec p = add(s->low, times(add(v3(x, y, z), times(sum, 1.0 / crossed)), s->cell)), start = p;
    for (int i = 0; i < 3; i++) {
        vec g = gradient(s, p);
        double g2 = g.x * g.x + g.y * g.y + g.z * g.z;
        p = sub(p, times(g, s->inside(p) / fmax(g2, 0.1)));
    }
    p = length(sub(p, start)) < 0.6 * s->cell ? p : start; /* at sharp creases the gradient leads astray */
    vec corner_of_cell = add(s->low, times(v3(x, y, z), s->cell)), in = times(sub(p, corner_of_cell), 1 / s->cell);
    in = v3(fmin(fmax(in.x, 0.06), 0.94), fmin(fmax(in.y, 0.06), 0.94), fmin(fmax(in.z, 0.06), 0.94)); /* no two meet */
    return add(corner_of_cell, times(in, s->cell));
}

static bool crosses(const net *s, int x, int y, int z)
{
    bool first = s->distance[grid_index(s, x, y, z)] < 0;
    for (int i = 1; i < 8; i++)
        if ((s->distance[grid_index(s, x + (i & 1), y + (i >> 1 & 1), z + (i >> 2))] < 0) != first) return true;
    return false;
}

/* The face around the grid edge that starts at (x, y, z) and goes along `axis`, if that edge crosses the surface. */
static void net_face(net *s, int x, int y, int z, int axis)
{
    int step[3] = {0, 0, 0}, at[3] = {x, y, z}, u = (axis + 1) % 3, v = (axis + 2) % 3, quad[4];
    step[axis] = 1;
    if (at[u] == 0 || at[v] == 0) return;
    bool a = s->distance[grid_index(s, x, y, z)] < 0;
    if (a == (s->distance[grid_index(s, x + step[0], y + step[1], z + step[2])] < 0)) return;
    for (int i = 0; i < 4; i++) {
        int cell[3] = {x, y, z};
        cell[u] -= i == 1 || i == 2, cell[v] -= i > 1;
        quad[i] = s->vertex[grid_index(s, cell[0], cell[1], cell[2])] - s->count - 1;
    }
    fprintf(s->file, a ? "f %d %d %d %d\n" : "f %4$d %3$d %2$d %1$d\n", quad[0], quad[1], quad[2], quad[3]);
}

static void net_layer(net *s, int y)
{
    for (int z = 0; z < s->n[2]; z++) {
        for (int x = 0; x < s->n[0]; x++) {
            if (!crosses(s, x, y, z)) continue;
            vec p = net_vertex(s, x, y, z);
            s->vertex[grid_index(s, x, y, z)] = ++s->count;
            fprintf(s->file, "v %.4g %.5g %.4g\n", round(p.x * 1e4) / 1e4, round(p.y * 1e4) / 1e4,
                    round(p.z * 1e4) / 1e4);
            for (int axis = 0; axis < 3; axis++) net_face(s, x, y, z, axis);
        }
    }
}

/* `material`: "FILE.mtl\nusemtl NAME", as the OBJ has it. */
static bool cast(const char *root, const char *path, solid *inside, vec low, vec high, double cell,
                 const char *material)
{
    vec size = times(sub(high, low), 1 / cell);
    net s = {.inside = inside, .low = low, .cell = cell, .n = {(int)size.x, (int)size.y, (int)size.z}};
    size_t points = grid_index(&s, s.n[0], s.n[1], s.n[2]) + 1;
    s.distance = calloc(points, sizeof *s.distance), s.vertex = calloc(points, sizeof *s.vertex);
    s.file = s.distance && s.vertex ? open_output(root, path) : NULL;
    bool ok = s.file != NULL;
    for (int y = 0; ok && y <= s.n[1]; y++)
        for (int z = 0; z <= s.n[2]; z++)
            for (int x = 0; x <= s.n[0]; x++)
                s.distance[grid_index(&s, x, y, z)] = (float)inside(add(low, times(v3(x, y, z), cell)));
    if (ok) fprintf(s.file, "# made by daft_generate, CC0\nmtllib %s\n", material);
    for (int y = 0; ok && y < s.n[1]; y++) net_layer(&s, y);
    if (s.file) ok = close_output(s.file, path) && ok;
    free(s.distance), free(s.vertex);
    return ok;
}

bool generate_sculptures(const char *root)
{
    return cast(root, "assets/meshes/hall/cat.obj", cat, v3(-0.6, -0.15, -0.65), v3(0.6, 1.56, 0.65), 0.0158,
                "hall.mtl\nusemtl bronze") &&
           cast(root, "assets/meshes/hall/woman.obj", woman, v3(-0.55, -0.13, -0.55), v3(0.55, 2.2, 0.55), 0.0140,
                "hall.mtl\nusemtl white_marble");
}

bool generate_statues(const char *root)
{
    return cast(root, "assets/meshes/gallery/bust.obj", head_and_foot, v3(-0.26, -0.03, -0.2), v3(0.26, 0.66, 0.2),
                0.0100, "gallery.mtl\nusemtl marble") &&
           cast(root, "assets/meshes/gallery/torso.obj", torso, v3(-0.36, -0.03, -0.25), v3(0.36, 1.12, 0.25), 0.0155,
                "gallery.mtl\nusemtl marble");
}
