/* Bounds of instances in the frame, from a 26-DOP of the mesh (Kay and Kajiya, "Ray Tracing Complex Scenes", 1986).
 *
 * The box around a rotated box is much larger than its contents: a beam along a diagonal would get a cube. So a mesh is
 * also measured along the diagonals of the box's faces and of the box: 13 directions, both ways. Any direction n is a
 * sum, with weights that are not negative, of one axis, one face diagonal and one space diagonal: with |n| sorted as a
 * >= b >= c, (a - b) of the largest component's axis, b - c of the diagonal between the larger two, and c of the
 * octant's. No point reaches further along n than the same sum of the support along these three. */
#include "accel/bvh.h"
#include "accel/reach.h"
#include "math/simd/ops.h"

enum { AXES = DAFT_REACH_AXES, FACES = DAFT_REACH_FACES, OCTANTS = DAFT_REACH_OCTANTS };

/* Lanes' least and largest of sums and differences. */
typedef struct extremes {
    v4 least[10], most[10];
} extremes;

static inline void add_points(extremes *e, v4 x, v4 y, v4 z)
{
    v4 a = x + y, b = x - y;
    const v4 along[10] = {y + z, y - z, x + z, x - z, a, b, a + z, a - z, b + z, b - z};
    for (int i = 0; i < 10; i++) e->least[i] = v4_min(e->least[i], along[i]), e->most[i] = v4_max(e->most[i], along[i]);
}

static float least_of(v4 a) { return fminf(fminf(a[0], a[1]), fminf(a[2], a[3])); }

static float most_of(v4 a) { return fmaxf(fmaxf(a[0], a[1]), fmaxf(a[2], a[3])); }

void daft_bvh_measure(daft_bvh *bvh, const daft_trimesh *mesh)
{
    /* Signs of what is least and largest along each: x, y, z are bits 0, 1, 2. */
    static const uint8_t place[10][2] = {
        {FACES + 0, FACES + 6},     {FACES + 4, FACES + 2},    {FACES + 8, FACES + 13}, {FACES + 12, FACES + 9},
        {FACES + 16, FACES + 19},   {FACES + 18, FACES + 17},  {OCTANTS, OCTANTS + 7},  {OCTANTS + 4, OCTANTS + 3},
        {OCTANTS + 2, OCTANTS + 5}, {OCTANTS + 6, OCTANTS + 1}};
    extremes e;
    for (int i = 0; i < 10; i++) e.least[i] = v4_set(INFINITY), e.most[i] = v4_set(-INFINITY);
    uint32_t count = mesh->vertex_count, i = 0;
    for (; i + 4 <= count; i += 4) add_points(&e, v4_load(mesh->x + i), v4_load(mesh->y + i), v4_load(mesh->z + i));
    for (; i < count; i++) add_points(&e, v4_set(mesh->x[i]), v4_set(mesh->y[i]), v4_set(mesh->z[i]));
    for (int k = 0; k < 10; k++) {
        bvh->support[place[k][0]] = most_of(e.most[k]);
        bvh->support[place[k][1]] = -least_of(e.least[k]);
    }
    for (int k = 0; k < 3; k++) {
        bvh->support[AXES + 2 * k] = daft_v3_at(mesh->high, k);
        bvh->support[AXES + 2 * k + 1] = -daft_v3_at(mesh->low, k);
    }
}

/* What is reached along n and against it, at most. */
static void reach(const float *support, const double n[3], double out[2])
{
    double size[3] = {fabs(n[0]), fabs(n[1]), fabs(n[2])};
    unsigned sign = (n[0] < 0) | (unsigned)(n[1] < 0) << 1 | (unsigned)(n[2] < 0) << 2;
    const uint8_t *o = DAFT_REACH_ORDER[(size[0] >= size[1]) | (unsigned)(size[1] >= size[2]) << 1 |
                                        (unsigned)(size[0] >= size[2]) << 2];
    double a = size[o[0]] - size[o[1]], b = size[o[1]] - size[o[2]], c = size[o[2]];
    for (int end = 0; end < 2; end++, sign ^= 7) {
        float axis = support[daft_reach_axis(o, sign)], face = support[daft_reach_face(o, sign)],
              octant = support[daft_reach_octant(sign)];
        out[end] = a * (double)axis + b * (double)face + c * (double)octant;
    }
}

static void bound_sphere(daft_instance *instance)
{
    for (int k = 0; k < 3; k++) {
        float at = instance->to_frame.t[k], slack = (fabsf(at) + instance->radius) * 0x1p-22f;
        daft_v3_put(&instance->low, k, at - instance->radius - slack);
        daft_v3_put(&instance->high, k, at + instance->radius + slack);
    }
}

/* The bounds hold every vertex as daft_affine_point rounds it: the exact image of the object-space box, widened by the
 * error of that formula (3 products, 3 sums: below 4·2^-24 of the sum of magnitudes), and by what rays are off that are
 * moved into the object's space (single_kernel.c: 13·2^-24 of the magnitudes on all axes). What is reached along
 * diagonals is off by another 2·2^-24 of them. */
void daft_instance_bound(daft_instance *instance)
{
    if (!instance->mesh) {
        bound_sphere(instance);
        return;
    }
    const daft_vec3 a = instance->mesh->low, b = instance->mesh->high;
    const daft_affine *map = &instance->to_frame;
    double low[3], high[3], size = 0;
    for (int k = 0; k < 3; k++) {
        double centre = (double)map->t[k], half = 0, row[3], along[2];
        size += fabs(centre);
        for (int j = 0; j < 3; j++) {
            double m = row[j] = (double)map->m[3 * k + j], l = (double)daft_v3_at(a, j), h = (double)daft_v3_at(b, j);
            centre += m * (l + h) * 0.5;
            half += fabs(m) * (h - l) * 0.5;
            size += fabs(m) * (fabs(l) > fabs(h) ? fabs(l) : fabs(h));
        }
        low[k] = centre - half, high[k] = centre + half;
        if (!instance->bvh) continue;
        reach(instance->bvh->support, row, along);
        double ahead = (double)map->t[k] + along[0], behind = (double)map->t[k] - along[1];
        high[k] = ahead < high[k] ? ahead : high[k]; /* not where large numbers have made it NaN */
        low[k] = behind > low[k] ? behind : low[k];
    }
    double slack = size * (0x1p-20 + 0x1p-23);
    for (int k = 0; k < 3; k++) {
        daft_v3_put(&instance->low, k, (float)(low[k] - slack));
        daft_v3_put(&instance->high, k, (float)(high[k] + slack));
    }
}
