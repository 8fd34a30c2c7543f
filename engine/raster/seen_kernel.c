/* Instances of meshes as the camera sees them, DAFT_VL of them at a time: what raster.c does for one, operation for
 * operation in double, so that the bits are the same. */
#include "accel/bound_lanes.h"
#include "math/simd/ops.h"
#include "raster/kernels.h"

/* What is read of instances and meshes, by lane; a mesh that nothing is known of the sides of has `middle` 0. */
typedef struct group {
    const daft_instance *instances;
    vf frame[12]; /* to_frame */
    daft_bounded meshes;
    double middle[3][DAFT_VL];
} group;

/* What is found of them. */
typedef struct views {
    float map[12][DAFT_VL]; /* to_camera */
    float low[3][DAFT_VL], high[3][DAFT_VL]; /* of the bounds in camera space */
    int32_t first[2][DAFT_VL], end[2][DAFT_VL]; /* pixels: columns, rows */
    float outlook[5][DAFT_VL]; /* all but w */
    int32_t front[DAFT_VL];
    vbits seen;
} views;

static void read_group(const daft_instance *instances, group *g)
{
    const float *frames[DAFT_VL];
    g->instances = instances;
    for (int i = 0; i < DAFT_VL; i++) {
        frames[i] = (const float *)&instances[i].to_frame;
        const daft_sides *sides = instances[i].bvh->sides;
        const double *middle = sides ? &sides->middle.x : (const double[3]){0};
        for (int k = 0; k < 3; k++) g->middle[k][i] = middle[k];
    }
    for (int k = 0; k < 12; k += 4) vf_gather_rows4(frames, k, g->frame + k);
    daft_bounded_read(instances, &g->meshes);
}

/* camera_map */
static void map_group(const daft_pencil *p, const group *g, views *v)
{
    const daft_vec3 axes[3] = {p->right, p->up, p->forward};
    for (int i = 0; i < 3; i++) {
        vd x = vd_set((double)axes[i].x), y = vd_set((double)axes[i].y), z = vd_set((double)axes[i].z);
        for (int j = 0; j < 4; j++) { /* the columns of m, then t */
            int at = j < 3 ? j : 9, step = j < 3 ? 3 : 1;
            vf a = g->frame[at], b = g->frame[at + step], c = g->frame[at + 2 * step];
            vd part[2];
            for (int h = 0; h < 2; h++) part[h] = x * vd_promote_half(a, h) + y * vd_promote_half(b, h) + z * vd_promote_half(c, h);
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
    vd half_x = vd_set((double)p->width * 0.5 + 1), half_y = vd_set((double)p->height * 0.5 + 1), f = vd_set((double)p->focal);
    vd z = vd_promote_half(vf_load(v->high[2]), h);
    return (vl)(vd_promote_half(vf_load(v->low[0]), h) * f > z * half_x) | (vl)(-vd_promote_half(vf_load(v->high[0]), h) * f > z * half_x) |
           (vl)(vd_promote_half(vf_load(v->low[1]), h) * f > z * half_y) | (vl)(-vd_promote_half(vf_load(v->high[1]), h) * f > z * half_y);
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
    return vd_select((vl)(whole < a), whole + 1, whole);
}
DAFT_INLINE vd vd_floor(vd a)
{
    vd whole = vd_whole(a);
    return vd_select((vl)(whole > a), whole - 1, whole);
}

/* Pixels along one side of the picture. */
typedef struct side {
    double focal, centre;
    int size;
} side;

/* pixel_range; what is beyond the picture's ends is brought near them first. Gives the lanes that have some. */
DAFT_INLINE vbits range_group(vf low, vf high, const views *v, const side *s, int32_t *first, int32_t *end)
{
    vd a[2], b[2], zero = {0}, last = vd_set(s->size - 1), beyond = last + 1;
    for (int h = 0; h < 2; h++) {
        vd l = vd_promote_half(low, h), u = vd_promote_half(high, h), near = vd_promote_half(vf_load(v->low[2]), h), far = vd_promote_half(vf_load(v->high[2]), h);
        vd x = s->focal * (l / vd_select((vl)(l < zero), near, far)) + s->centre;
        vd y = s->focal * (u / vd_select((vl)(u < zero), far, near)) + s->centre;
        x = vd_select((vl)(x < zero), zero, vd_select((vl)(x > beyond), beyond, x));
        y = vd_select((vl)(y > last), last, vd_select((vl)(y < zero - 1), zero - 1, y));
        vl before = (vl)(near > zero);
        a[h] = vd_select(before, vd_ceiling(x - 1e-3), zero), b[h] = vd_select(before, vd_floor(y + 1e-3), last);
    }
    vf from = vf_demote2(a[0], a[1]), to = vf_demote2(b[0], b[1]);
    vi_store(first, vi_convert_to(from)), vi_store(end, vi_convert_to(to));
    vm some = vm_and(vf_le(from, to), vf_le(from, vf_set((float)(s->size - 1))));
    return vbits_from_mask(vm_and(some, vf_le(vf_set(0), to)));
}

static void place_group(const daft_pencil *p, views *v)
{
    const vf zero = vf_set(0), x0 = vf_load(v->low[0]), x1 = vf_load(v->high[0]), y0 = vf_load(v->low[1]), y1 = vf_load(v->high[1]);
    const side across = {(double)p->focal, daft_pencil_middle_x(p), p->width}, down = {(double)p->focal, daft_pencil_middle_y(p), p->height};
    vd apart[2];
    for (int h = 0; h < 2; h++) apart[h] = vd_select(beside(p, v, h), vd_set(1), vd_set(0));
    v->seen = vbits_from_mask(vm_and(vm_and(all_finite(v->low), all_finite(v->high)), vf_lt(zero, vf_load(v->high[2]))));
    v->seen &= vbits_from_mask(vf_lt(vf_demote2(apart[0], apart[1]), vf_set(1)));
    v->seen &= range_group(x0, x1, v, &across, v->first[0], v->end[0]);
    v->seen &= range_group(-y1, -y0, v, &down, v->first[1], v->end[1]);
}

/* ---- outlooks: daft_outlook_from ---- */

typedef struct vd3 {
    vd x, y, z;
} vd3;

DAFT_INLINE vd3 vd3_cross(vd3 a, vd3 b)
{
    return (vd3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
DAFT_INLINE vd vd3_dot(vd3 a, vd3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

/* Half of the lanes. */
typedef struct outlook_half {
    vd at[3], reach, blur, front;
} outlook_half;

/* daft_outlook_at; `known`: the point is. */
DAFT_INLINE void look_from(const group *g, const vd point[3], vl known, vd det, int h, outlook_half *out)
{
    vd square = {0};
    vl outside = {0};
    for (int k = 0; k < 3; k++) {
        vd low = vd_promote_half(vf_load(g->meshes.low[k]), h), high = vd_promote_half(vf_load(g->meshes.high[k]), h), p = point[k];
        vd pad = out->blur + vd_abs(p) * 1e-9, far = vd_larger(vd_abs(p - low), vd_abs(p - high));
        outside |= (vl)(p < low - pad) | (vl)(p > high + pad);
        square += far * far;
        out->at[k] = p - vd_load(&g->middle[k][h * DAFT_VL / 2]);
    }
    out->reach = vd_sqrt(square) * (1 + 0x1p-20);
    out->front = vd_select(known & outside, vd_select((vl)(det < vd_set(0)), vd_set(1), vd_set(-1)), vd_set(0));
}

static void outlook_half_of(const group *g, const views *v, int h, outlook_half *out)
{
    vd m[9], t[3];
    for (int i = 0; i < 9; i++) m[i] = vd_promote_half(vf_load(v->map[i]), h);
    for (int i = 0; i < 3; i++) t[i] = vd_promote_half(vf_load(v->map[9 + i]), h);
    const vd3 row[3] = {{m[0], m[1], m[2]}, {m[3], m[4], m[5]}, {m[6], m[7], m[8]}};
    const vd3 column[3] = {vd3_cross(row[1], row[2]), vd3_cross(row[2], row[0]), vd3_cross(row[0], row[1])};
    vd det = vd3_dot(row[0], column[0]), size = vd_sqrt(vd3_dot(row[0], row[0]) * vd3_dot(column[0], column[0])), inverse = 1 / det;
    vd point[3] = {{0}, {0}, {0}};
    vd3 off = {{0}, {0}, {0}};
    for (int k = 0; k < 3; k++) {
        vd moved = {0}; /* moved_off_by */
        for (int j = 0; j < 3; j++) {
            vd low = vd_abs(vd_promote_half(vf_load(g->meshes.low[j]), h)), high = vd_abs(vd_promote_half(vf_load(g->meshes.high[j]), h));
            moved += vd_abs(m[3 * k + j]) * vd_larger(low, high);
        }
        vd e = (4.01 * moved + 1.01 * vd_abs(t[k])) * 0x1p-24;
        vd3 c = {column[k].x * inverse, column[k].y * inverse, column[k].z * inverse};
        point[0] -= c.x * t[k], point[1] -= c.y * t[k], point[2] -= c.z * t[k];
        off.x += vd_abs(c.x) * e, off.y += vd_abs(c.y) * e, off.z += vd_abs(c.z) * e;
    }
    out->blur = vd_sqrt(vd3_dot(off, off)) * (1 + 0x1p-20);
    look_from(g, point, (vl)(vd_abs(det) > 1e-12 * size), det, h, out);
}

static void outlook_group(const group *g, views *v)
{
    outlook_half half[2];
    for (int h = 0; h < 2; h++) outlook_half_of(g, v, h, &half[h]);
    for (int k = 0; k < 3; k++) vf_store(v->outlook[k], vf_demote2(half[0].at[k], half[1].at[k]));
    vf reach = vf_demote2(half[0].reach, half[1].reach), front = vf_demote2(half[0].front, half[1].front);
    vf_store(v->outlook[3], reach), vf_store(v->outlook[4], vf_demote2(half[0].blur, half[1].blur));
    vi_store(v->front, vi_convert_to(vf_if_then_else(vf_lt(reach, vf_set(INFINITY)), front, vf_set(0))));
}

/* ---- the whole ---- */

static void write_seen(const group *g, const views *v, int i, uint32_t index, daft_seen *out)
{
    const daft_instance *instance = &g->instances[i];
    if (!(v->seen >> i & 1)) {
        out->instance = NULL;
        return;
    }
    out->instance = instance, out->mesh = instance->mesh, out->bvh = instance->bvh, out->index = index;
    for (int k = 0; k < 9; k++) out->to_camera.m[k] = v->map[k][i];
    for (int k = 0; k < 3; k++) out->to_camera.t[k] = v->map[9 + k][i];
    out->near_z = v->low[2][i];
    out->x0 = v->first[0][i], out->x1 = v->end[0][i], out->y0 = v->first[1][i], out->y1 = v->end[1][i];
    out->dense = daft_seen_dense(out);
    out->front = instance->bvh->sides ? v->front[i] : 0;
    out->outlook = (daft_outlook){v->outlook[0][i], v->outlook[1][i], v->outlook[2][i], 1, v->outlook[3][i], v->outlook[4][i]};
}

void DAFT_KERNEL(daft_seen_group)(const daft_raster *raster, uint32_t first)
{
    group g;
    views v;
    read_group(&raster->instances[first], &g);
    map_group(&raster->pencil, &g, &v);
    daft_bound_lanes(&g.meshes, v.map, v.low, v.high);
    place_group(&raster->pencil, &v);
    outlook_group(&g, &v);
    for (int i = 0; i < DAFT_VL; i++) write_seen(&g, &v, i, first + (uint32_t)i, &raster->seen[first + (uint32_t)i]);
}
