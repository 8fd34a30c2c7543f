/* What a tile tells of itself while it is drawn, so that the next picture knows which changes may reach it (redraw.c):
 * boxes of the points that were lit, and of the directions in which these sent rays on. */
#include "render/redraw.h"
#include "render/tile/tile.h"

#include <math.h>

static const daft_reach NOTHING = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};

static void include(daft_reach *b, daft_vec3 low, daft_vec3 high)
{
    b->low = daft_min3(b->low, low);
    b->high = daft_max3(b->high, high);
}

static daft_kept_pass *pass_of(const tile_job *j) { return &j->frame->kept->tiles[j->number].pass[j->refines]; }

void daft_redraw_tile(const tile_job *j)
{
    const daft_kept *k = j->frame->kept;
    if (!k || (j->frame->sample && !j->refines)) return;
    if (j->refines && j->frame->tiles && k->state[j->number] == DAFT_TILE_BESIDE)
        return; /* its corners are known better */
    *pass_of(j) = (daft_kept_pass){{NOTHING, NOTHING}, {NOTHING, NOTHING}};
    if (!j->frame->edge_scale) k->tiles[j->number].pass[1] = *pass_of(j); /* there are no corners */
}

void daft_redraw_points(const tile_job *j, const daft_batch *points, bool seen)
{
    if (!j->frame->kept || !points->count) return;
    daft_vec3 low, high;
    daft_reach *reach = &pass_of(j)->points[!seen];
    j->r->shade->extent(&points->point, points->count, &low, &high);
    include(reach, low, high);
    j->r->shade->extent(&points->shadow_origin, points->count, &low, &high);
    if (j->frame->plan.shadows) include(reach, low, high);
}

void daft_redraw_rays(const tile_job *j, const daft_ray_batch *rays, int depth)
{
    if (!j->frame->kept || !rays->count) return;
    daft_vec3 low, high;
    j->r->shade->extent(&rays->direction, rays->count, &low, &high);
    include(&pass_of(j)->rays[depth > 0], low, high);
}
