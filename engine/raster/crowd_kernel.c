/* A mesh of many instances against a tile: groups of clusters, clusters, leaves, blocks of triangles (accel/clusters.h), each a
 * list of balls that are held against the tile's rays a register at a time. One is left out when its ball holds no ray of the
 * tile's pixels, when all in it looks away, or when the pixels in its reach see something nearer. Each list is
 * gone through before the next one: how many a step leaves cannot be guessed, and lists cost no branch that depends on it. */
#include "raster/hidden.h"

enum {
    CLUSTERS = 128,                        /* listed before their leaves are */
    LEAVES = 128,                          /* and leaves before they are found hidden or not */
    PARTS = DAFT_CLUSTER_GROUP / DAFT_VL   /* registers to a group's clusters */
};

/* An instance's balls as the tile sees them. */
typedef struct crowd {
    daft_tile_job *job;
    daft_waiting *waiting;
    const daft_seen *seen;
    const daft_sides *sides;
    float ball[12];               /* a ball's centre to x and y in pixels times z, and z; then the translation */
    float reach[2], z_reach[2];   /* its radius to pixels times z and to z, and what is added */
    daft_glance glance;
    uint32_t leaf_count, leaves[DAFT_LEAVES_ROOM + 16]; /* to be drawn: their codes */
    uint32_t block_count, blocks[DAFT_LEAVES_ROOM * DAFT_MAX_LEAF_BLOCKS + DAFT_VL];
} crowd;

/* Balls that hold rays: what they are of, the pixels of the tile, and the largest w. */
typedef struct sights {
    uint32_t count;
    uint32_t what[LEAVES + 2 * DAFT_VL], pixels[LEAVES + 2 * DAFT_VL];
    float nearest[LEAVES + 2 * DAFT_VL];
} sights;

/* How balls come to the tile. Where a ray of slope t (x and y of it over z) meets the ball around c, c is from the ray, in the
 * plane of its own z, by r·sqrt(1 + t²) at most, in any direction of that plane. `pad`: what a moved corner is off by in x
 * and y, times z, and in z, 2^-20 of the magnitudes; centres are moved with no more error than twice that, and corners by as
 * much. False: z is not known to a part in 2^10. */
static bool crowd_begin(crowd *w, daft_tile_job *job, const daft_seen *seen, daft_waiting *waiting)
{
    const float *m = seen->to_camera.m, *t = seen->to_camera.t, focal = job->raster->pencil.focal;
    const float *low = &seen->mesh->low.x, *high = &seen->mesh->high.x;
    float pad[3], stretch = 0; /* the square of what lengths grow by, at most: a sum over a row of m·mᵀ */
    if (!seen->front) return false;
    for (int k = 0; k < 3; k++) {
        float size = fabsf(t[k]), sum = 0;
        for (int i = 0; i < 3; i++) {
            size += fabsf(m[3 * k + i]) * fmaxf(fabsf(low[i]), fabsf(high[i]));
            sum += fabsf(m[3 * k] * m[3 * i] + m[3 * k + 1] * m[3 * i + 1] + m[3 * k + 2] * m[3 * i + 2]);
        }
        pad[k] = size * 0x1p-20f;
        stretch = fmaxf(stretch, sum);
    }
    if (!(pad[2] * 0x1p12f < seen->near_z)) return false;
    w->job = job, w->seen = seen, w->waiting = waiting, w->leaf_count = w->block_count = 0;
    w->sides = seen->bvh->sides;
    w->glance = daft_glance_of(w->sides, &seen->outlook);
    const daft_balls *balls = &w->sides->balls;
    for (int i = 0; i < 4; i++) {
        float at[3];
        for (int k = 0; k < 3; k++)
            at[k] = i < 3 ? m[3 * k + i] * balls->unit
                          : m[3 * k] * balls->low.x + m[3 * k + 1] * balls->low.y + m[3 * k + 2] * balls->low.z + t[k];
        float *to = &w->ball[3 * i];
        to[0] = at[0] * focal - at[2] * job->left, to[1] = at[2] * job->top - at[1] * focal, to[2] = at[2];
    }
    float slant = sqrtf(focal * focal + job->max_dx * job->max_dx + job->max_dy * job->max_dy);
    float x = pad[0] * focal + pad[2] * fabsf(job->left), y = pad[1] * focal + pad[2] * fabsf(job->top);
    w->z_reach[0] = sqrtf(stretch) * balls->unit * (1 + 0x1p-8f), w->z_reach[1] = 4 * pad[2];
    w->reach[0] = w->z_reach[0] * slant, w->reach[1] = 4 * (x + y) + 2 * DAFT_TILE * 4 * pad[2];
    return true;
}

/* ---- balls ---- */

/* A register's balls, in their units. */
typedef struct balls {
    vf x, y, z, radius;
} balls;

/* Four one after the other from each of the places. */
DAFT_INLINE balls balls_load(const daft_ball *const from[DAFT_VL / 4])
{
    const float *low[DAFT_VL / 4], *high[DAFT_VL / 4];
    for (int i = 0; i < DAFT_VL / 4; i++) low[i] = (const float *)(const void *)from[i], high[i] = low[i] + 4;
    vf a = vf_gather_rows(low), b = vf_gather_rows(high);
    vi first = (vi)vf_even_fours(a, b), second = (vi)vf_odd_fours(a, b), half = vi_set(0xffff);
    return (balls){vf_from_int(first & half), vf_from_int(first >> 16 & half), vf_from_int(second & half), vf_from_int(second >> 16 & half)};
}

/* Where balls are in the picture. */
typedef struct discs {
    vf column, row, reach, z;
    vbits apart; /* no ray of the tile's pixels meets them */
} discs;

/* Comparisons are written so that a NaN leaves a ball in. */
DAFT_INLINE discs balls_project(const crowd *w, const balls *b)
{
    vf p[3], zero = vf_set(0), whole = vf_set(0x1.8p23f);
    for (int k = 0; k < 3; k++)
        p[k] = vf_set(w->ball[k]) * b->x + vf_set(w->ball[3 + k]) * b->y + vf_set(w->ball[6 + k]) * b->z + vf_set(w->ball[9 + k]);
    vf inverse = vf_set(1) / p[2], column = p[0] * inverse, row = p[1] * inverse;
    vf reach = (b->radius * vf_set(w->reach[0]) + vf_set(w->reach[1])) * inverse + vf_set(DAFT_SCREEN_SLACK);
    vf x = column - vf_min(vf_max((column + whole) - whole, zero), vf_set(w->job->last_x));
    vf y = row - vf_min(vf_max((row + whole) - whole, zero), vf_set(w->job->last_y));
    return (discs){column, row, reach, p[2], vm_bits(vm_and(vf_lt(reach * reach, x * x + y * y), vf_lt(zero, inverse)))};
}

/* One axis of the pixels within a disc that holds one of them; or, but for a part in 2^8, nearly does. */
DAFT_INLINE void disc_span(vf at, vf reach, float last, vi *first, vi *end)
{
    vf zero = vf_set(0), most = vf_set(last);
    vf low = vf_min(vf_max(at - reach, zero), most), high = vf_min(vf_max(at + reach, zero), most);
    *first = vi_truncate(low + vf_set(1 - 0x1p-8f)), *end = vi_truncate(high);
    *first = vi_select(vi_lt(*end, *first), *end, *first);
}

/* Lanes that look away: daft_looks_away. */
DAFT_INLINE vbits away(const crowd *w, vi look, vf spread)
{
    const daft_glance *g = &w->glance;
    vf towards = vf_from_int(look << 24 >> 24) * vf_set(g->x) + vf_from_int(look << 16 >> 24) * vf_set(g->y) +
                 vf_from_int(look << 8 >> 24) * vf_set(g->z) + vf_set(g->margin);
    return vm_bits(vf_lt(towards + spread * vf_set(g->reach), vf_from_int(look >> 24) * vf_set(g->step)));
}

/* Adds those of `lanes` that hold rays and do not look away. */
DAFT_INLINE void add_sights(const crowd *w, const balls *b, vi look, vf spread, vi what, vbits lanes, sights *out)
{
    discs d = balls_project(w, b);
    lanes &= ~(d.apart | away(w, look, spread));
    vi x0, x1, y0, y1;
    disc_span(d.column, d.reach, w->job->last_x, &x0, &x1);
    disc_span(d.row, d.reach, w->job->last_y, &y0, &y1);
    vf z = d.z - (b->radius * vf_set(w->z_reach[0]) + vf_set(w->z_reach[1]));
    vf nearest = vf_select(vf_lt(vf_set(0), z), vf_rough_reciprocal(z) * vf_set(1 + 0x1p-10f), vf_set(INFINITY));
    vi_compress(&out->what[out->count], lanes, what);
    vi_compress(&out->pixels[out->count], lanes, x0 | x1 << 8 | y0 << 16 | y1 << 24);
    vf_compress(&out->nearest[out->count], lanes, nearest);
    out->count += (uint32_t)__builtin_popcount(lanes);
}

/* What is not hidden of a list, side by side. Gives how many they are. */
DAFT_INLINE uint32_t not_hidden(const crowd *w, const sights *s, uint32_t *out)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < s->count; i += DAFT_VL) {
        vbits lanes = vbits_first((int)(s->count - i));
        vi pixels = vi_select(vm_from_bits(lanes), vi_load(&s->pixels[i]), vi_set(0));
        lanes &= ~hidden_lanes(w->job, pixels, vf_load(&s->nearest[i]), lanes);
        vi_compress(&out[count], lanes, vi_load(&s->what[i]));
        count += (uint32_t)__builtin_popcount(lanes);
    }
    return count;
}

/* ---- blocks ---- */

/* Lanes of blocks whose triangles all look away: daft_looks_away. */
DAFT_INLINE vbits blocks_away(const crowd *w, const uint32_t *block)
{
    const daft_glance *g = &w->glance;
    vbits all = 0;
    for (int leaf = 0; leaf < DAFT_VL / 4; leaf++) {
        const uint32_t *look = w->sides->looks[block[leaf]];
        uint32_t bits = 0;
        for (int i = 0; i < 16; i += DAFT_VL) {
            vi v = vi_load(look + i);
            vf towards = vf_from_int(v << 24 >> 24) * vf_set(g->x) + vf_from_int(v << 16 >> 24) * vf_set(g->y) +
                         vf_from_int(v << 8 >> 24) * vf_set(g->z) + vf_set(g->margin);
            bits |= vm_bits(vf_lt(towards, vf_from_int(v >> 24) * vf_set(g->step))) << i;
        }
        bits &= bits >> 1, bits &= bits >> 2;
        all |= ((bits & 0x1111) * 0x1248 >> 12 & 15) << (4 * leaf);
    }
    return all;
}

/* The blocks of leaves that may hold a ray and look towards it. */
static void list_blocks(crowd *w)
{
    vi slot = vi_iota() & vi_set(3), leaf = vi_iota() >> 2;
    for (uint32_t i = 0; i < w->leaf_count; i += DAFT_VL / 4) {
        const uint32_t *code = &w->leaves[i];
        vi codes = (vi)vf_lookup16((const float *)(const void *)code, leaf);
        uint32_t some = daft_min_u(w->leaf_count - i, DAFT_VL / 4), block[DAFT_VL / 4];
        const daft_ball *from[DAFT_VL / 4];
        for (uint32_t k = 0; k < DAFT_VL / 4; k++) {
            block[k] = (code[k < some ? k : 0] & ~DAFT_CHILD_LEAF) >> 2;
            from[k] = &w->sides->balls.items[block[k]];
        }
        balls b = balls_load(from);
        vbits lanes = vbits_first((int)(4 * some)) & ~vm_bits(vi_lt(codes & vi_set(3), slot));
        lanes &= ~(balls_project(w, &b).apart | blocks_away(w, block));
        vi_compress(&w->blocks[w->block_count], lanes, ((codes & vi_set(INT32_MAX)) >> 2) + slot);
        w->block_count += (uint32_t)__builtin_popcount(lanes);
    }
}

static void draw_leaves(crowd *w)
{
    list_blocks(w);
    DAFT_KERNEL(daft_blocks_project)(w->job, w->seen, true, w->blocks, w->block_count, &w->waiting->projected);
    while (w->waiting->projected.count) DAFT_KERNEL(daft_projected_take)(w->job, w->seen, &w->waiting->projected, w->waiting);
    w->leaf_count = w->block_count = 0;
    DAFT_KERNEL(daft_hits_draw)(w->job, w->seen, &w->waiting->hits);
    while (w->waiting->count >= DAFT_VL) DAFT_KERNEL(daft_waiting_draw)(w->job, w->waiting);
}

/* ---- leaves and clusters ---- */

static void take_leaves(crowd *w, sights *leaves)
{
    uint32_t list[LEAVES + 2 * DAFT_VL], count = not_hidden(w, leaves, list);
    leaves->count = 0;
    for (uint32_t i = 0; i < count; i += DAFT_LEAVES) {
        uint32_t some = daft_min_u(count - i, DAFT_LEAVES);
        memcpy(w->leaves, &list[i], some * sizeof *list);
        w->leaf_count = some;
        draw_leaves(w);
    }
}

/* The leaves of up to DAFT_EIGHTS clusters. */
DAFT_INLINE void add_leaves(const crowd *w, const uint32_t *clusters, uint32_t count, sights *out)
{
    const daft_cluster *first = &w->sides->clusters.items[clusters[0]], *second = &w->sides->clusters.items[clusters[count > 1]];
    vbits there = vbits_first((int)(count * DAFT_CLUSTER_LEAVES));
    for (int part = 0; part < DAFT_EIGHT_PARTS; part++) {
        const daft_ball *from[DAFT_VL / 4];
        for (int i = 0; i < DAFT_VL / 4; i++) from[i] = &(i < 2 ? first : second)->ball[4 * ((i + part) & 1)];
        balls b = balls_load(from);
        vi look = (vi)vf_load_eights((const float *)(const void *)first->look, (const float *)(const void *)second->look, part);
        vi leaf = (vi)vf_load_eights((const float *)(const void *)first->leaf, (const float *)(const void *)second->leaf, part);
        vf spread = vf_load_eights(first->spread, second->spread, part);
        add_sights(w, &b, look, spread, leaf, there & ~vm_bits(vi_eq(leaf, vi_set((int32_t)DAFT_CHILD_NONE))), out);
    }
}

static void take_clusters(crowd *w, sights *clusters, sights *leaves)
{
    uint32_t list[CLUSTERS + 2 * DAFT_VL], count = not_hidden(w, clusters, list);
    clusters->count = 0;
    w->job->counters->nodes += count;
    for (uint32_t i = 0; i < count; i += DAFT_EIGHTS) {
        add_leaves(w, &list[i], count - i, leaves);
        if (leaves->count >= LEAVES) take_leaves(w, leaves);
    }
}

/* A register of a list of clusters, or of groups, from one on. */
DAFT_INLINE void add_outlines(const crowd *w, const daft_outlines *o, uint32_t first, sights *out)
{
    const daft_ball *from[DAFT_VL / 4];
    for (int i = 0; i < DAFT_VL / 4; i++) from[i] = &o->balls[first + 4 * (uint32_t)i];
    balls b = balls_load(from);
    vbits lanes = first < o->count ? vbits_first((int)(o->count - first)) : 0;
    add_sights(w, &b, vi_load(&o->looks[first]), vf_load(&o->spreads[first]), vi_set((int32_t)first) + vi_iota(), lanes, out);
}

bool DAFT_KERNEL(daft_crowd_draw)(daft_tile_job *job, const daft_seen *seen, daft_waiting *waiting)
{
    crowd w;
    sights groups, clusters, leaves;
    if (!crowd_begin(&w, job, seen, waiting)) return false;
    const daft_clusters *all = &w.sides->clusters;
    clusters.count = leaves.count = 0;
    for (uint32_t i = 0; i < all->groups.count; i += DAFT_VL) {
        groups.count = 0;
        add_outlines(&w, &all->groups, i, &groups);
        for (uint32_t g = 0; g < groups.count; g++) {
            for (uint32_t part = 0; part < PARTS; part++)
                add_outlines(&w, &all->all, groups.what[g] * DAFT_CLUSTER_GROUP + part * DAFT_VL, &clusters);
            if (clusters.count >= CLUSTERS - DAFT_CLUSTER_GROUP) take_clusters(&w, &clusters, &leaves);
        }
    }
    take_clusters(&w, &clusters, &leaves);
    take_leaves(&w, &leaves);
    return true;
}
