/* Smooth vertex normals, the part in lanes: normals and corner angles of many triangles at a time, in double, summed at
 * their vertices; and `unlist_rings`, which finds the vertices whose ring of triangles has at most one crease: these
 * sums decide such vertices, and smooth.c need not walk their rings. */
#include "geometry/analysis/smooth.h"
#include "math/simd/ops.h"

/* Triangles are worked on by the block, so that what one step leaves is in the cache for the next. */
enum { BLOCK = 64 };

/* Corners by axis; then normals and angles. */
typedef struct block {
    float corner[3][3][BLOCK];
    float normal[3][BLOCK], angle[3][BLOCK];
} block;

typedef struct vd3 {
    vd x, y, z;
} vd3;

DAFT_INLINE vd3 vd3_sub(vd3 a, vd3 b) { return (vd3){a.x - b.x, a.y - b.y, a.z - b.z}; }

DAFT_INLINE vd vd3_dot(vd3 a, vd3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

/* Abramowitz and Stegun 4.4.46 on 0..1; absolute error below 3e-8. */
DAFT_INLINE vd arc_cosine(vd x)
{
    const vd zero = {0}, one = zero + 1;
    vd a = vd_if_then_else((vl)(x < zero), -x, x);
    a = vd_if_then_else((vl)(a < one), a, one);
    vd series = zero - 0.0012624911;
    series = series * a + 0.0066700901;
    series = series * a - 0.0170881256;
    series = series * a + 0.0308918810;
    series = series * a - 0.0501743046;
    series = series * a + 0.0889789874;
    series = series * a - 0.2145988016;
    series = series * a + 1.5707963050;
    vd angle = vd_sqrt(one - a) * series;
    return vd_if_then_else((vl)(x < zero), DAFT_PI - angle, angle);
}

/* Half the lanes: out has the normal's x, y, z and the angles. A corner without an angle weighs nothing. */
DAFT_INLINE void measure(vd3 a, vd3 b, vd3 c, vd out[6])
{
    const vd zero = {0}, one = zero + 1;
    vd3 ab = vd3_sub(b, a), ac = vd3_sub(c, a), bc = vd3_sub(c, b);
    vd ab2 = vd3_dot(ab, ab), ac2 = vd3_dot(ac, ac), bc2 = vd3_dot(bc, bc);
    vd3 n = {ab.y * ac.z - ab.z * ac.y, ab.z * ac.x - ab.x * ac.z, ab.x * ac.y - ab.y * ac.x};
    vd length = vd_sqrt(vd3_dot(n, n));
    vd scale = one / vd_if_then_else((vl)(length > zero), length, one);
    out[0] = n.x * scale, out[1] = n.y * scale, out[2] = n.z * scale;
    vl wide = (vl)(ab2 > zero) & (vl)(ac2 > zero) & (vl)(bc2 > zero);
    vd at_a = arc_cosine(vd3_dot(ab, ac) / vd_if_then_else(wide, vd_sqrt(ab2 * ac2), one));
    vd at_b = arc_cosine(-vd3_dot(ab, bc) / vd_if_then_else(wide, vd_sqrt(ab2 * bc2), one));
    vd at_c = DAFT_PI - at_a - at_b;
    out[3] = vd_if_then_else(wide, at_a, zero);
    out[4] = vd_if_then_else(wide, at_b, zero);
    out[5] = vd_if_then_else(wide & (vl)(at_c > zero), at_c, zero);
}

/* Corners of `count` triangles from `first` on, and of the last again up to whole lanes. Calls for the sums they will
 * be added to: files often have triangles in an order that is far from the vertices'. */
static void gather(const daft_trimesh *mesh, uint32_t first, uint32_t count, block *b, const daft_smooth_sum *sums)
{
    uint32_t padded = (count + DAFT_VL - 1) / DAFT_VL * DAFT_VL;
    for (uint32_t i = 0; i < padded; i++) {
        const uint32_t *v = mesh->indices + 3 * (size_t)(first + (i < count ? i : count - 1));
        for (int k = 0; k < 3; k++) {
            b->corner[k][0][i] = mesh->x[v[k]];
            b->corner[k][1][i] = mesh->y[v[k]];
            b->corner[k][2][i] = mesh->z[v[k]];
            __builtin_prefetch(&sums[v[k]], 1);
        }
    }
}

static void measure_block(block *b, uint32_t count)
{
    for (uint32_t i = 0; i < count; i += DAFT_VL) {
        vd out[2][6];
        for (int half = 0; half < 2; half++) {
            vd3 corner[3];
            for (int k = 0; k < 3; k++) {
                corner[k].x = vd_promote_half(vf_load(&b->corner[k][0][i]), half);
                corner[k].y = vd_promote_half(vf_load(&b->corner[k][1][i]), half);
                corner[k].z = vd_promote_half(vf_load(&b->corner[k][2][i]), half);
            }
            measure(corner[0], corner[1], corner[2], out[half]);
        }
        for (int k = 0; k < 3; k++) {
            vf_store(&b->normal[k][i], vf_demote2(out[0][k], out[1][k]));
            vf_store(&b->angle[k][i], vf_demote2(out[0][k + 3], out[1][k + 3]));
        }
    }
}

typedef double pair __attribute__((vector_size(16)));
typedef float quad __attribute__((vector_size(16)));
typedef double pair_unaligned __attribute__((vector_size(16), aligned(8), may_alias));
typedef float quad_unaligned __attribute__((vector_size(16), aligned(4), may_alias));

/* Murmur's finaliser, cut short: neighbours have unlike numbers. */
DAFT_INLINE uint64_t hash_of(uint32_t vertex)
{
    uint64_t h = (vertex + UINT64_C(1)) * 0xff51afd7ed558ccdu;
    return (h ^ h >> 32) * 0xc4ceb9fe1a85ec53u;
}

DAFT_INLINE void add_corner(daft_smooth_sum *sum, pair xy, double z, quad plain, float angle, uint64_t link)
{
    double weight = (double)angle;
    pair_unaligned *weighted = (pair_unaligned *)(void *)sum->weighted;
    *weighted += xy * (pair){weight, weight};
    sum->weighted[2] += z * weight;
    sum->links += link;
    *(quad_unaligned *)(void *)sum->plain += plain; /* and the count */
}

static void scatter(const daft_trimesh *mesh, uint32_t first, uint32_t count, const block *b, daft_smooth_faces faces,
                    daft_smooth_sum *sums)
{
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t *v = mesh->indices + 3 * (size_t)(first + i);
        float x = b->normal[0][i], y = b->normal[1][i], z = b->normal[2][i];
        faces.normals[first + i] = daft_v3(x, y, z);
        for (size_t k = 0; k < 3; k++) faces.angles[3 * (size_t)(first + i) + k] = b->angle[k][i];
        pair xy = {(double)x, (double)y};
        quad plain = {x, y, z, 1};
        uint64_t h[3] = {hash_of(v[0]), hash_of(v[1]), hash_of(v[2])};
        add_corner(&sums[v[0]], xy, (double)z, plain, b->angle[0][i], h[1] - h[2]);
        add_corner(&sums[v[1]], xy, (double)z, plain, b->angle[1][i], h[2] - h[0]);
        add_corner(&sums[v[2]], xy, (double)z, plain, b->angle[2][i], h[0] - h[1]);
    }
}

static void add_faces(const daft_trimesh *mesh, daft_smooth_faces faces, daft_smooth_sum *sums)
{
    block b;
    for (uint32_t first = 0; first < mesh->triangle_count; first += BLOCK) {
        uint32_t left = mesh->triangle_count - first, count = left < BLOCK ? left : BLOCK;
        gather(mesh, first, count, &b, sums);
        measure_block(&b, count);
        scatter(mesh, first, count, &b, faces, sums);
    }
}

/* ---- going around a vertex ---- */

typedef uint32_t v8u __attribute__((vector_size(32)));

typedef struct ring {
    uint32_t next[DAFT_SMOOTH_RING], previous[DAFT_SMOOTH_RING]; /* the other two vertices of each triangle */
    float normal[3][DAFT_SMOOTH_RING];
    uint32_t group[DAFT_SMOOTH_RING];
} ring;

DAFT_INLINE v8u v8u_permute(v8u a, v8u from) { return (v8u)v8i_table_lookup((v8i)a, (v8i)from); }

DAFT_INLINE v8u v8u_load(const void *p)
{
    v8u value;
    memcpy(&value, p, sizeof value);
    return value;
}

/* Always eight, of which those behind the vertex's own are not looked at: valences differ, and a loop that ends
 * unforeseen costs more. */
static inline void gather_ring(const daft_trimesh *mesh, const daft_vec3 *normals, const uint32_t *groups,
                               const uint32_t *corners, ring *r)
{
    for (uint32_t i = 0; i < DAFT_SMOOTH_RING; i++) {
        uint32_t corner = corners[i], triangle = corner / 3, k = corner - 3 * triangle;
        const uint32_t *v = mesh->indices + 3 * (size_t)triangle;
        uint32_t soon = corners[i + DAFT_SMOOTH_AHEAD - DAFT_SMOOTH_RING] / 3;
        __builtin_prefetch(&normals[soon]);
        __builtin_prefetch(&mesh->indices[3 * (size_t)soon]);
        r->next[i] = v[k == 2 ? 0 : k + 1];
        r->previous[i] = v[k == 0 ? 2 : k - 1];
        r->normal[0][i] = normals[triangle].x;
        r->normal[1][i] = normals[triangle].y;
        r->normal[2][i] = normals[triangle].z;
        r->group[i] = groups ? groups[triangle] : 1;
    }
}

/* The lane whose `next` is this lane's `previous`; *single has all bits where there is just one such. */
DAFT_INLINE v8u find_neighbours(const ring *r, v8u valid, v8u *single)
{
    const v8u none = {0};
    v8u previous = v8u_load(r->previous), to = none, hits = none;
    v8u next = v8u_load(r->next) | ~valid; /* no vertex has the largest number */
    for (uint32_t i = 0; i < DAFT_SMOOTH_RING; i++) {
        v8u match = (v8u)(previous == (none + next[i]));
        to |= match & (none + i);
        hits -= match;
    }
    *single = (v8u)(hits == none + 1);
    return to & *single & valid;
}

DAFT_INLINE v8u flat_edges(const ring *r, v8u to, float cosine)
{
    v8 dot = v8_set(0);
    for (int k = 0; k < 3; k++) {
        v8u own = v8u_load(r->normal[k]);
        v8 product = (v8)own * (v8)v8u_permute(own, to);
        dot = k ? dot + product : product;
    }
    const v8u none = {0};
    v8u group = v8u_load(r->group);
    return (v8u)(dot > v8_set(cosine)) & (v8u)(group == v8u_permute(group, to)) & (v8u)(group != none);
}

static inline bool is_smooth_ring(const ring *r, uint32_t count, float cosine)
{
    const v8u lane = {0, 1, 2, 3, 4, 5, 6, 7}, none = {0};
    v8u valid = (v8u)(lane < none + count), single, to = find_neighbours(r, valid, &single);
    v8u creases = valid & ~flat_edges(r, to, cosine), least = lane;
    v8u reached = (none + 1) << to & valid;
    uint32_t all = 0;
    for (uint32_t i = 0; i < DAFT_SMOOTH_RING; i++) all |= reached[i];
    for (int k = 0; k < 3; k++) { /* the smallest lane of the first 2, 4, 8 that are passed from here */
        v8u there = v8u_permute(least, to), less = (v8u)(there < least);
        least = (there & less) | (least & ~less);
        to = v8u_permute(to, to);
    }
    v8u wrong = valid & (~single | (v8u)(least != none));
    uint32_t bits = v8_bits_from_mask((v8i)creases);
    return all == (1u << count) - 1 && !v8_bits_from_mask((v8i)wrong) && !(bits & (bits - 1));
}

static void unlist_rings(const daft_trimesh *mesh, const daft_vec3 *normals, const uint32_t *groups, float cosine,
                         const daft_smooth_lists *lists, uint32_t first, uint32_t end)
{
    for (uint32_t vertex = first; vertex < end; vertex++) {
        uint32_t from = lists->first[vertex], count = lists->first[vertex + 1] - from;
        if (count - 1 >= DAFT_SMOOTH_RING) continue;
        ring r;
        gather_ring(mesh, normals, groups, lists->corners + from, &r);
        lists->listed[vertex] = !is_smooth_ring(&r, count, cosine);
    }
}

/* ---- normals ---- */

/* Half the lanes: the directions of as many sums. */
DAFT_INLINE vd3 directions(const daft_smooth_sum *sums)
{
    const vd zero = {0}, one = zero + 1;
    vd x = zero, y = zero, z = zero;
    for (int i = 0; i < DAFT_VL / 2; i++) {
        x[i] = sums[i].weighted[0];
        y[i] = sums[i].weighted[1];
        z[i] = sums[i].weighted[2];
    }
    vd3 v = {x, y, z};
    vd length = vd_sqrt(vd3_dot(v, v));
    vd scale = one / vd_if_then_else((vl)(length > zero), length, one);
    v.x *= scale, v.y *= scale, v.z *= scale;
    vl good = (vl)(vd3_dot(v, v) > zero + 0.5);
    return (vd3){vd_if_then_else(good, v.x, zero), vd_if_then_else(good, v.y, one), vd_if_then_else(good, v.z, zero)};
}

static inline void normalize_lanes(const daft_smooth_sum *sums, daft_vec3 *out)
{
    float x[DAFT_VL], y[DAFT_VL], z[DAFT_VL];
    vd3 low = directions(sums), high = directions(sums + DAFT_VL / 2);
    vf_store(x, vf_demote2(low.x, high.x));
    vf_store(y, vf_demote2(low.y, high.y));
    vf_store(z, vf_demote2(low.z, high.z));
    for (int i = 0; i < DAFT_VL; i++) out[i] = daft_v3(x[i], y[i], z[i]);
}

static void normalize(const daft_smooth_sum *sums, size_t count, daft_vec3 *out)
{
    if (count < DAFT_VL) {
        daft_smooth_sum few[DAFT_VL] = {0};
        daft_vec3 unit[DAFT_VL];
        if (count) memcpy(few, sums, count * sizeof *few);
        normalize_lanes(few, unit);
        if (count) memcpy(out, unit, count * sizeof *unit);
        return;
    }
    for (size_t first = 0; first + DAFT_VL <= count; first += DAFT_VL) normalize_lanes(sums + first, out + first);
    normalize_lanes(sums + count - DAFT_VL, out + count - DAFT_VL); /* some twice */
}

const daft_smooth_kernels DAFT_KERNEL(daft_smooth) = {add_faces, unlist_rings, normalize};
