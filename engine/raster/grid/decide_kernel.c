/* Rays one by one, where floats do not decide: by the exact predicates, and the depths of the reference path. A ray's
 * place is that of what it sees: of a fine tile 16 to a pixel, else its pixel's. */
#include "math/exact.h"
#include "raster/grid/grid.h"

/* What is kept of a ray. */
typedef struct kept {
    float *low, *high;
    uint32_t *instance, *triangle;
    int x, y; /* the ray, in the tile */
} kept;

static kept kept_of(daft_tile_job *j, int at)
{
    if (!j->fine)
        return (kept){&j->w_low[at],          &j->w_high[at],        &j->tile->instance[at],
                      &j->tile->triangle[at], at % DAFT_TILE_STRIDE, at / DAFT_TILE_STRIDE};
    const int pixel = at / DAFT_FINE_RAYS, ray = at % DAFT_FINE_RAYS;
    return (kept){&j->fine_depths->low[at],
                  &j->fine_depths->high[at],
                  &j->fine->instance[at],
                  &j->fine->triangle[at],
                  DAFT_FINE * (pixel % DAFT_TILE) + ray % DAFT_FINE,
                  DAFT_FINE * (pixel / DAFT_TILE) + ray / DAFT_FINE};
}

static daft_vec3 ray_of(const daft_tile_job *j, const kept *k)
{
    return daft_pencil_ray(&j->pencil, j->x + k->x, j->y + k->y);
}

static void keep(const kept *k, const daft_primitive *t, float low, float high)
{
    *k->low = low, *k->high = high;
    *k->instance = t->view->index, *k->triangle = t->triangle;
}

/* The depths are too close for floats: compare the true ones, then the numbers. */
static void compare(daft_tile_job *j, const kept *k, const daft_primitive *t, float low, float high)
{
    const daft_vec3 ray = ray_of(j, k);
    const uint32_t instance = *k->instance, triangle = *k->triangle;
    double mine = daft_view_depth(t->view, t->triangle, ray),
           other = daft_view_depth(&j->raster->visible[instance], triangle, ray);
    j->counters->exact_depths++;
    bool wins = mine < other || (mine == other &&
                                 (t->view->index < instance || (t->view->index == instance && t->triangle < triangle)));
    if (wins) keep(k, t, low, high);
}

/* A hit with the interval of its w: nearer, farther, or to be looked at closely. */
static void offer(daft_tile_job *j, const kept *k, const daft_primitive *t, float low, float high)
{
    if (!(low <= high)) low = -INFINITY, high = INFINITY; /* an overflow: nothing is known */
    if (*k->instance == DAFT_NOTHING || low > *k->high)
        keep(k, t, low, high);
    else if (!(high < *k->low))
        compare(j, k, t, low, high);
}

static bool meets(daft_tile_job *j, const kept *k, const daft_primitive *t)
{
    const daft_vec3 ray = ray_of(j, k);
    if (!t->view->mesh) return daft_view_depth(t->view, 0, ray) < INFINITY;
    daft_vec3 corner[3];
    daft_view_corners(t->view, t->triangle, corner);
    j->counters->exact_edges++;
    return daft_pencil_hits(corner[0], corner[1], corner[2], ray);
}

void DAFT_KERNEL(daft_ray_decide)(daft_tile_job *j, int at, const daft_primitive *t, bool sure, float low, float high)
{
    const kept k = kept_of(j, at);
    if (sure || meets(j, &k, t)) offer(j, &k, t, low, high);
}

bool DAFT_KERNEL(daft_ray_in_hole)(const daft_tile_job *j, int x, int y, const daft_view_instance *view,
                                   uint32_t triangle)
{
    daft_holes h;
    return daft_holes_make(&j->holes, view, triangle, &h) && daft_in_hole(&h, x, y);
}

vbits DAFT_KERNEL(daft_hits_in_holes)(daft_tile_job *j, const daft_primitive *t, int x, int y, vbits hits)
{
    daft_holes *h = t->holes;
    if (!hits || h->none) return 0;
    if (!h->known) {
        h->known = true, h->none = !daft_holes_make(&j->holes, t->view, t->triangle, h);
        if (h->none) return 0;
    }
    return DAFT_KERNEL(daft_holes_pass)(h, x, y, hits);
}
