/* Clipping triangles to sides of axis-parallel planes: in double, rounded outward. */
#include "accel/build/clip.h"

#include <float.h>
#include <math.h>

daft_part daft_part_of(const daft_trimesh *mesh, uint32_t triangle)
{
    const uint32_t *c = &mesh->indices[3 * (size_t)triangle];
    const float *axes[3] = {mesh->x, mesh->y, mesh->z};
    daft_part part = {.triangle = triangle};
    for (int k = 0; k < 3; k++) {
        float p = axes[k][c[0]], q = axes[k][c[1]], r = axes[k][c[2]];
        part.low[k] = fminf(fminf(p, q), r), part.high[k] = fmaxf(fmaxf(p, q), r);
    }
    return part;
}

/* Floats around a double. */
static float under(double x) { return nextafterf((float)x, -INFINITY); }
static float over(double x) { return nextafterf((float)x, INFINITY); }

void daft_part_clip(const daft_trimesh *mesh, daft_part *part, int axis, float at, bool below)
{
    const uint32_t *corner = &mesh->indices[3 * (size_t)part->triangle];
    double p[3][3], low[3] = {DBL_MAX, DBL_MAX, DBL_MAX}, high[3] = {-DBL_MAX, -DBL_MAX, -DBL_MAX},
                    plane_at = (double)at;
    for (int i = 0; i < 3; i++)
        p[i][0] = (double)mesh->x[corner[i]], p[i][1] = (double)mesh->y[corner[i]],
        p[i][2] = (double)mesh->z[corner[i]];
    for (int i = 0; i < 3; i++) {
        const double *a = p[i], *b = p[(i + 1) % 3];
        bool inside = below ? a[axis] <= plane_at : a[axis] >= plane_at;
        bool crosses = (a[axis] < plane_at && b[axis] > plane_at) || (a[axis] > plane_at && b[axis] < plane_at);
        double fraction = crosses ? (plane_at - a[axis]) / (b[axis] - a[axis]) : 0;
        for (int k = 0; k < 3; k++) {
            double cut = k == axis ? plane_at : a[k] + fraction * (b[k] - a[k]);
            if (inside) low[k] = fmin(low[k], a[k]), high[k] = fmax(high[k], a[k]);
            if (crosses) low[k] = fmin(low[k], cut), high[k] = fmax(high[k], cut);
        }
    }
    for (int k = 0; k < 3; k++) {
        float l = fmaxf(part->low[k], under(low[k])), h = fminf(part->high[k], over(high[k]));
        if (l <= h) part->low[k] = l, part->high[k] = h;
    }
    if (below)
        part->high[axis] = fminf(part->high[axis], at);
    else
        part->low[axis] = fmaxf(part->low[axis], at);
}
