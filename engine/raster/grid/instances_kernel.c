/* Screen bounds of mesh instances, DAFT_VL at a time: what bounds.c computes for one, operation for operation in
 * double, so that the bits are the same. */
#include "accel/bound_lanes.h"
#include "math/simd/ops.h"
#include "raster/grid/grid.h"

/* What is read of instances and meshes, by lane. */
typedef struct group {
    const daft_instance *instances;
    vf frame[12]; /* to_frame */
    daft_bounded meshes;
} group;

/* What is found of them. */
typedef struct views {
    float map[12][DAFT_VL];                     /* to_view */
    float low[3][DAFT_VL], high[3][DAFT_VL];    /* of the bounds in camera space */
    int32_t first[2][DAFT_VL], end[2][DAFT_VL]; /* pixels: columns, rows */
    vbits visible;
} views;

static void read_group(const daft_instance *instances, group *g)
{
    const float *frames[DAFT_VL];
    g->instances = instances;
    for (int i = 0; i < DAFT_VL; i++) frames[i] = (const float *)&instances[i].to_frame;
    for (int k = 0; k < 12; k += 4) vf_gather_rows4(frames, k, g->frame + k);
    daft_bounded_read(instances, &g->meshes);
}

/* daft_pencil_map; a grid's origin is 0 */
static void map_group(const daft_pencil *p, const group *g, views *v)
{
    const daft_vec3 axes[3] = {p->right, p->up, p->forward};
    for (int i = 0; i < 3; i++) {
        vd x = vd_set((double)axes[i].x), y = vd_set((double)axes[i].y), z = vd_set((double)axes[i].z);
        for (int j = 0; j < 4; j++) { /* the columns of m, then t */
            int at = j < 3 ? j : 9, step = j < 3 ? 3 : 1;
            vf a = g->frame[at], b = g->frame[at + step], c = g->frame[at + 2 * step];
            vd part[2];
            for (int h = 0; h < 2; h++)
                part[h] = x * vd_promote_half(a, h) + y * vd_promote_half(b, h) + z * vd_promote_half(c, h);
            vf_store(v->map[j < 3 ? 3 * i + j : 9 + i], vf_demote2(part[0], part[1]));
        }
    }
}

/* ---- pixels ---- */

static vm all_finite(float (*values)[DAFT_VL])
{
    vm all = vf_lt(vf_abs(vf_load(values[0])), vf_set(INFINITY));
    for (int k = 1; k < 3; k++) all = vm_and(all, vf_lt(vf_abs(vf_load(values[k])), vf_set(INFINITY)));
    return all;
}

/* outside_sides */
DAFT_INLINE vl beside(const daft_pencil *p, const views *v, int h)
{
    vd half_x = vd_set((double)p->width * 0.5 + 1), half_y = vd_set((double)p->height * 0.5 + 1),
       f = vd_set((double)p->focal);
    vd z = vd_promote_half(vf_load(v->high[2]), h);
    return (vl)(vd_promote_half(vf_load(v->low[0]), h) * f > z * half_x) |
           (vl)(-vd_promote_half(vf_load(v->high[0]), h) * f > z * half_x) |
           (vl)(vd_promote_half(vf_load(v->low[1]), h) * f > z * half_y) |
           (vl)(-vd_promote_half(vf_load(v->high[1]), h) * f > z * half_y);
}

/* To whole numbers, for magnitudes below 2^51. */
DAFT_INLINE vd vd_whole(vd a)
{
    const vd large = vd_set(0x1.8p52);
    return (a + large) - large;
}
DAFT_INLINE vd vd_ceiling(vd a)
{
    vd whole = vd_whole(a);
    return vd_if_then_else((vl)(whole < a), whole + 1, whole);
}
DAFT_INLINE vd vd_floor(vd a)
{
    vd whole = vd_whole(a);
    return vd_if_then_else((vl)(whole > a), whole - 1, whole);
}

/* Pixels along one side of the picture. */
typedef struct side {
    double focal, centre, reach;
    int size;
} side;

/* pixel_range; what is beyond the picture's ends is brought near them first. Gives the lanes that have some. */
DAFT_INLINE vbits range_group(vf low, vf high, const views *v, const side *s, int32_t *first, int32_t *end)
{
    vd a[2], b[2], zero = {0}, last = vd_set(s->size - 1), beyond = last + 1;
    for (int h = 0; h < 2; h++) {
        vd l = vd_promote_half(low, h), u = vd_promote_half(high, h), near = vd_promote_half(vf_load(v->low[2]), h),
           far = vd_promote_half(vf_load(v->high[2]), h);
        vd x = s->focal * (l / vd_if_then_else((vl)(l < zero), near, far)) + (s->centre - s->reach);
        vd y = s->focal * (u / vd_if_then_else((vl)(u < zero), far, near)) + (s->centre + s->reach);
        x = vd_if_then_else((vl)(x < zero), zero, vd_if_then_else((vl)(x > beyond), beyond, x));
        y = vd_if_then_else((vl)(y > last), last, vd_if_then_else((vl)(y < zero - 1), zero - 1, y));
        vl before = (vl)(near > zero);
        a[h] = vd_if_then_else(before, vd_ceiling(x - 1e-3), zero),
        b[h] = vd_if_then_else(before, vd_floor(y + 1e-3), last);
    }
    vf from = vf_demote2(a[0], a[1]), to = vf_demote2(b[0], b[1]);
    vi_store(first, vi_convert_to(from)), vi_store(end, vi_convert_to(to));
    vm some = vm_and(vf_le(from, to), vf_le(from, vf_set((float)(s->size - 1))));
    return vbits_from_mask(vm_and(some, vf_le(vf_set(0), to)));
}

static void place_group(const daft_pencil *p, views *v)
{
    const vf zero = vf_set(0), x0 = vf_load(v->low[0]), x1 = vf_load(v->high[0]), y0 = vf_load(v->low[1]),
             y1 = vf_load(v->high[1]);
    const side across = {(double)p->focal, daft_pencil_middle_x(p), (double)p->reach, p->width},
               down = {(double)p->focal, daft_pencil_middle_y(p), (double)p->reach, p->height};
    vd apart[2];
    for (int h = 0; h < 2; h++) apart[h] = vd_if_then_else(beside(p, v, h), vd_set(1), vd_set(0));
    v->visible =
        vbits_from_mask(vm_and(vm_and(all_finite(v->low), all_finite(v->high)), vf_lt(zero, vf_load(v->high[2]))));
    v->visible &= vbits_from_mask(vf_lt(vf_demote2(apart[0], apart[1]), vf_set(1)));
    v->visible &= range_group(x0, x1, v, &across, v->first[0], v->end[0]);
    v->visible &= range_group(-y1, -y0, v, &down, v->first[1], v->end[1]);
}

/* ---- the whole ---- */

static void write_view(const group *g, const views *v, int i, uint32_t index, daft_view_instance *out)
{
    const daft_instance *instance = &g->instances[i];
    if (!(v->visible >> i & 1)) {
        out->instance = NULL;
        return;
    }
    out->instance = instance, out->mesh = instance->mesh, out->bvh = instance->bvh, out->index = index;
    for (int k = 0; k < 9; k++) out->to_view.m[k] = v->map[k][i];
    for (int k = 0; k < 3; k++) out->to_view.t[k] = v->map[9 + k][i];
    out->near_z = v->low[2][i];
    out->x0 = v->first[0][i], out->x1 = v->end[0][i], out->y0 = v->first[1][i], out->y1 = v->end[1][i];
    out->dense = daft_view_dense(out);
}

void DAFT_KERNEL(daft_instances_project)(const daft_raster *raster, uint32_t first)
{
    group g;
    views v;
    read_group(&raster->instances[first], &g);
    map_group(&raster->pencil, &g, &v);
    daft_bound_lanes(&g.meshes, v.map, v.low, v.high);
    place_group(&raster->pencil, &v);
    for (int i = 0; i < DAFT_VL; i++) write_view(&g, &v, i, first + (uint32_t)i, &raster->visible[first + (uint32_t)i]);
}
