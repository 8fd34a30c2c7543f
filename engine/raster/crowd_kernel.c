/* A mesh of many instances against a tile: groups of clusters, clusters, patches of triangles (accel/patches.h), each a list of
 * balls, for patches of ellipsoids, too, that are held against the tile's rays a register at a time. One is left out when it holds no
 * ray of the tile's pixels, when all in it looks away, or when the pixels in its reach see something nearer. Each list is
 * gone through before the next one: how many a step leaves cannot be guessed, and lists cost no branch that depends on it. Instances that
 * are little in the tile share the lists, so that these are long: what they hide of each other is little, too.
 *
 * Ellipses. A ray of pixel p meets a patch where, for some point of it, h from the ball's middle, d + P·h/z = 0: d is from p to the middle
 * in the picture, z the middle's, and P maps to pixels times z as the ray of p sees it, (column - p.x)·z and (row - p.y)·z. With P0 that of the
 * ray through the tile's middle instead, P·h = P0·h - (p - p0)·z(h), the last within 23 pixels times the radius in z. As h is in the ellipsoid M and
 * in the ball, d is in the ellipse S0 = P0·M·P0ᵀ/z² widened by b, for that and for what the middle is off by, and so in
 * (1 + 1/8)·S0 + (1 + 8)·b². It is taken as (1 + 3/16)·S0 + 17·b²: its determinant and forms are off by less than 2^-20 of the squares of
 * its largest terms, and 8·b² is over 2^-15 of those, since b is taken as no less than 2^-9 of the ball's reach. */
#include "raster/hidden.h"

enum { LISTED = 256 }; /* of a list, before the next one is made of them */

/* A crowd at work. */
typedef struct show {
    daft_tile_job *job;
    daft_waiting *waiting;
    const daft_crowd *crowd;
} show;

/* Balls that hold rays: what they are of, and of which member, the pixels of the tile, and the largest w. */
typedef struct sights {
    uint32_t count;
    uint32_t what[LISTED + 2 * DAFT_VL], pixels[LISTED + 2 * DAFT_VL];
    float nearest[LISTED + 2 * DAFT_VL];
} sights;

static void shapes_begin(daft_member *w)
{
    float row[2][3], inverse = 1 / w->seen->near_z;
    for (int k = 0; k < 2; k++)
        for (int i = 0; i < 3; i++) row[k][i] = (w->ball[3 * i + k] - DAFT_TILE / 2 * w->ball[3 * i + 2]) * inverse;
    for (int k = 0; k < 3; k++) {
        const float *a = row[k / 2], *b = row[(k + 1) / 2];
        const float all[DAFT_SHAPE] = {a[0] * b[0], a[1] * b[1], a[2] * b[2], a[0] * b[1] + a[1] * b[0], a[0] * b[2] + a[2] * b[0], a[1] * b[2] + a[2] * b[1]};
        for (int i = 0; i < DAFT_SHAPE; i++) w->shape[k][i] = all[i] * (1 + 3.0f / 16);
    }
    w->blur = w->z_reach[0] * 24 + w->reach[0] * 0x1p-9f;
}

/* Corners a and b that are L apart are L/z·(focal + |x|) or less apart in the picture, in x and in y, z being that of one and x that of
 * the other. So corners of a patch that holds a ray of the tile are within R0 = the tile's largest and 2r/z·(focal + R0), with r the
 * patch's radius, and a triangle's extent, both ways in sum, is below 2·edge/z·(focal + R0)·(1 + 2r/z). 4D is taken with the mesh's largest
 * r, and, in R, with its longest edge. */
static void doubt_begin(daft_member *w, const daft_tile_job *job, float grow)
{
    float inverse = 1 / w->seen->near_z, reach = daft_tile_reach(job), radius = w->z_reach[0] * w->patches->radius * inverse;
    float extent = 2 * grow * inverse * (job->raster->pencil.focal + reach) * (1 + 2 * radius) * (1 + 0x1p-6f);
    float each = 20 * 0x1p-24f * (1 + 0x1p-6f) * (reach + 2 * extent * w->patches->edge);
    w->doubt[0] = each * extent, w->doubt[1] = each * 0x1p-4f;
}

static inline float larger(float a, float b) { return a > b ? a : b; }

/* How balls come to the tile. Where a ray of slope t (x and y of it over z) meets the ball around c, c is from the ray, in the
 * plane of its own z, by r·sqrt(1 + t²) at most, in any direction of that plane. `pad`: what a moved corner is off by in x
 * and y, times z, and in z, 2^-20 of the magnitudes; centres are moved with no more error than twice that, and corners by as
 * much. False: z is not known to a part in 2^10. */
static bool member_begin(daft_member *w, const daft_tile_job *job, const daft_seen *seen)
{
    const float *m = seen->to_camera.m, *t = seen->to_camera.t, focal = job->raster->pencil.focal;
    const float *low = &seen->mesh->low.x, *high = &seen->mesh->high.x;
    float pad[3], stretch = 0; /* the square of what lengths grow by, at most: a sum over a row of m·mᵀ */
    if (!seen->front) return false;
    for (int k = 0; k < 3; k++) {
        float size = fabsf(t[k]), sum = 0;
        for (int i = 0; i < 3; i++) {
            size += fabsf(m[3 * k + i]) * larger(fabsf(low[i]), fabsf(high[i]));
            sum += fabsf(m[3 * k] * m[3 * i] + m[3 * k + 1] * m[3 * i + 1] + m[3 * k + 2] * m[3 * i + 2]);
        }
        pad[k] = size * 0x1p-20f;
        stretch = larger(stretch, sum);
    }
    if (!(pad[2] * 0x1p12f < seen->near_z)) return false;
    w->seen = seen;
    w->glance = daft_glance_of(seen->bvh->sides, &seen->outlook);
    const daft_patches *balls = w->patches = &seen->bvh->sides->patches;
    if (balls->level[0].count + 2 * DAFT_PATCH > DAFT_ITEM) return false;
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
    shapes_begin(w);
    doubt_begin(w, job, sqrtf(stretch));
    return true;
}

/* ---- balls ---- */

/* A register's balls, in their units. */
typedef struct balls {
    vf x, y, z, radius;
} balls;

/* A register of sixteen items, from lane `at` on. */
DAFT_INLINE balls balls_load(const daft_outlines *o, uint32_t at)
{
    return (balls){vf_load(&o->ball[0][at]), vf_load(&o->ball[1][at]), vf_load(&o->ball[2][at]), vf_load(&o->ball[3][at])};
}

/* Where balls are in the picture. */
typedef struct discs {
    vf column, row, reach, z, inverse;
    vm apart; /* no ray of the tile's pixels meets them */
} discs;

/* Comparisons are written so that a NaN leaves a ball in. */
DAFT_INLINE discs balls_project(const daft_tile_job *job, const daft_member *w, const balls *b)
{
    vf p[3], zero = vf_set(0), whole = vf_set(0x1.8p23f);
    for (int k = 0; k < 3; k++)
        p[k] = vf_set(w->ball[k]) * b->x + vf_set(w->ball[3 + k]) * b->y + vf_set(w->ball[6 + k]) * b->z + vf_set(w->ball[9 + k]);
    vf inverse = vf_set(1) / p[2], column = p[0] * inverse, row = p[1] * inverse;
    vf reach = (b->radius * vf_set(w->reach[0]) + vf_set(w->reach[1])) * inverse + vf_set(DAFT_SCREEN_SLACK);
    vf x = column - vf_min(vf_max((column + whole) - whole, zero), vf_set(job->last_x));
    vf y = row - vf_min(vf_max((row + whole) - whole, zero), vf_set(job->last_y));
    return (discs){column, row, reach, p[2], inverse, vm_and(vf_lt(reach * reach, x * x + y * y), vf_lt(zero, inverse))};
}

/* The pixels that outlines reach. */
typedef struct spans {
    vi x0, x1, y0, y1;
    vm none; /* there is no pixel */
} spans;

/* One axis of the pixels within reach, or but for a part in 2^8 there. Gives the lanes without any, for which it is some pixel. */
DAFT_INLINE vm span_of(vf at, vf reach, float last, vi *first, vi *end)
{
    vf zero = vf_set(0), most = vf_set(last);
    vf low = vf_min(vf_max(at - reach, zero), vf_set(2 * DAFT_TILE)), high = vf_min(at + reach, most);
    *first = vi_convert_to(low + vf_set(1 - 0x1p-8f)), *end = vi_convert_to(high);
    vm none = vi_lt(*end, *first);
    *first = vi_if_then_else(none, *end, *first);
    return none;
}

DAFT_INLINE spans disc_spans(const daft_tile_job *job, const discs *d)
{
    spans s;
    span_of(d->column, d->reach, job->last_x, &s.x0, &s.x1), span_of(d->row, d->reach, job->last_y, &s.y0, &s.y1);
    s.none = vm_from_bits(0); /* the disc holds one */
    return s;
}

/* The form of ellipses at x and y from their middle: beyond them it is over their determinant. */
DAFT_INLINE vf form_at(const vf e[3], vf x, vf y) { return e[2] * x * x - (e[1] + e[1]) * x * y + e[0] * y * y; }

/* Of patches by their ellipses. Where these reach two pixels a side at most, each of the up to four is tried. Comparisons
 * and minima are written so that a NaN, from an overflow, leaves a patch in: pixels are within a reach and one of the middle, and so forms of
 * ellipses that are less than 2^30 wide are none. */
DAFT_INLINE spans ellipse_spans(const daft_tile_job *job, const daft_member *w, const balls *b, const discs *d, const daft_shapes *shapes, uint32_t at)
{
    spans s;
    vf nearer = vf_set(w->seen->near_z) * d->inverse, square = nearer * nearer, e[3], wide = vf_set(1 + 0x1p-10f);
    vf blur = (b->radius * vf_set(w->blur) + vf_set(w->reach[1])) * d->inverse + vf_set(DAFT_SCREEN_SLACK), more = vf_set(17) * blur * blur;
    for (int k = 0; k < 3; k++) {
        vf part[DAFT_SHAPE];
        for (int i = 0; i < DAFT_SHAPE; i++) part[i] = vf_load(&shapes->m[i][at]) * vf_set(w->shape[k][i]);
        vf sum = (part[0] + part[1]) + (part[2] + part[3]) + (part[4] + part[5]);
        e[k] = k == 1 ? sum * square : sum * square + more;
    }
    vm none_x = span_of(d->column, vf_min(vf_approximate_sqrt(e[0]) * wide, d->reach), job->last_x, &s.x0, &s.x1);
    vm none_y = span_of(d->row, vf_min(vf_approximate_sqrt(e[2]) * wide, d->reach), job->last_y, &s.y0, &s.y1);
    vf det = e[0] * e[2] - e[1] * e[1];
    vf xa = d->column - vf_convert_to(s.x0), xb = d->column - vf_convert_to(s.x1), ya = d->row - vf_convert_to(s.y0), yb = d->row - vf_convert_to(s.y1);
    vm few = vm_and(vi_lt((s.x1 - s.x0) | (s.y1 - s.y0), vi_set(2)), vf_lt(e[0] + e[2], vf_set(0x1p60f)));
    vf least = vf_min(vf_min(form_at(e, xa, ya), form_at(e, xb, ya)), vf_min(form_at(e, xa, yb), form_at(e, xb, yb)));
    s.none = vm_or(vm_or(none_x, none_y), vf_lt(vf_if_then_else(few, det, vf_set(INFINITY)), least));
    return s;
}

/* Lanes that look away: daft_looks_away. */
DAFT_INLINE vm away(const daft_member *w, const daft_outlines *o, uint32_t at)
{
    const daft_glance *g = &w->glance;
    vf towards = vf_load(&o->look[0][at]) * vf_set(g->x) + vf_load(&o->look[1][at]) * vf_set(g->y) + vf_load(&o->look[2][at]) * vf_set(g->z) + vf_set(g->margin);
    return vf_lt(towards + vf_load(&o->spread[at]) * vf_set(g->reach), vf_load(&o->look[3][at]) * vf_set(g->step));
}

/* Adds those of a register of the items that one of the level above consists of that hold rays and do not look away. */
DAFT_INLINE void add_sights(const daft_tile_job *job, const daft_member *w, int level, uint32_t above, uint32_t at, sights *out)
{
    const daft_outline_level *l = &w->patches->level[level];
    const daft_outlines *o = &l->items[above];
    uint32_t first = above * DAFT_PATCH + at;
    int left = (int)(l->count - first);
    balls b = balls_load(o, at);
    discs d = balls_project(job, w, &b);
    spans s = level ? disc_spans(job, &d) : ellipse_spans(job, w, &b, &d, &w->patches->shapes[above], at);
    vbits lanes = DAFT_VL == DAFT_PATCH || left > 0 ? vbits_first_n(left) : 0; /* an item of the level above holds one or more */
    lanes &= ~vbits_from_mask(level ? vm_or(vm_or(d.apart, away(w, o, at)), s.none) : vm_or(away(w, o, at), s.none));
    vf z = d.z - (b.radius * vf_set(w->z_reach[0]) + vf_set(w->z_reach[1]));
    vf nearest = vf_if_then_else(vf_lt(vf_set(0), z), vf_approximate_reciprocal(z) * vf_set(1 + 0x1p-10f), vf_set(INFINITY));
    vi_compress_store(&out->what[out->count], lanes, vi_set((int32_t)(first | w->tag)) + vi_iota());
    vi_compress_store(&out->pixels[out->count], lanes, s.x0 | s.x1 << 8 | s.y0 << 16 | s.y1 << 24);
    vf_compress_store(&out->nearest[out->count], lanes, nearest);
    out->count += (uint32_t)__builtin_popcount(lanes);
}

/* What is not hidden of a list, side by side. Gives how many they are. */
DAFT_INLINE uint32_t not_hidden(const show *w, const sights *s, uint32_t *out)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < s->count; i += DAFT_VL) {
        vbits lanes = vbits_first_n((int)(s->count - i));
        vi pixels = vi_if_then_else(vm_from_bits(lanes), vi_load(&s->pixels[i]), vi_set(0));
        lanes &= ~hidden_lanes(w->job, pixels, vf_load(&s->nearest[i]), lanes);
        vi_compress_store(&out[count], lanes, vi_load(&s->what[i]));
        count += (uint32_t)__builtin_popcount(lanes);
    }
    return count;
}

/* ---- patches ---- */

/* Up to DAFT_LEAVES of them at a time. */
static void draw_patches(show *w, const uint32_t *patches, uint32_t count)
{
    daft_projected *projected = &w->waiting->projected;
    DAFT_KERNEL(daft_patches_project)(w->job, w->crowd, patches, count, w->waiting);
    DAFT_KERNEL(daft_projected_hits)(w->job, projected, &w->waiting->hits);
    DAFT_KERNEL(daft_hits_draw)(w->job, projected, &w->waiting->hits);
    while (w->waiting->count >= DAFT_VL) DAFT_KERNEL(daft_waiting_draw)(w->job, w->waiting);
}

static void take_patches(show *w, sights *patches)
{
    uint32_t list[LISTED + 2 * DAFT_VL], count = not_hidden(w, patches, list);
    patches->count = 0;
    for (uint32_t i = 0; i < count; i += DAFT_LEAVES) draw_patches(w, &list[i], daft_min_u(count - i, DAFT_LEAVES));
}

/* ---- lists ---- */

/* The sixteen items of a level that belong to one of the level above. */
DAFT_INLINE void add_outlines(const show *w, const daft_member *m, int level, uint32_t above, sights *out)
{
    for (uint32_t at = 0; at < DAFT_PATCH; at += DAFT_VL) add_sights(w->job, m, level, above, at, out);
}

static void take_clusters(show *w, sights *clusters, sights *patches)
{
    uint32_t list[LISTED + 2 * DAFT_VL], count = not_hidden(w, clusters, list);
    clusters->count = 0;
    w->job->counters->nodes += count;
    for (uint32_t i = 0; i < count; i++) {
        add_outlines(w, &w->crowd->members[list[i] >> DAFT_TAG_SHIFT], 0, list[i] & DAFT_ITEM, patches);
        if (patches->count > LISTED - DAFT_PATCH) take_patches(w, patches);
    }
}

static void take_groups(show *w, sights *groups, sights *clusters, sights *patches)
{
    for (uint32_t i = 0; i < groups->count; i++) {
        add_outlines(w, &w->crowd->members[groups->what[i] >> DAFT_TAG_SHIFT], 1, groups->what[i] & DAFT_ITEM, clusters);
        if (clusters->count > LISTED - DAFT_PATCH) take_clusters(w, clusters, patches);
    }
    groups->count = 0;
}

bool DAFT_KERNEL(daft_crowd_add)(const daft_tile_job *job, const daft_seen *seen, daft_crowd *crowd)
{
    daft_member *m = &crowd->members[crowd->count];
    if (!member_begin(m, job, seen)) return false;
    m->tag = crowd->count++ << DAFT_TAG_SHIFT;
    return true;
}

void DAFT_KERNEL(daft_crowd_draw)(daft_tile_job *job, daft_crowd *crowd, daft_waiting *waiting)
{
    show w = {.job = job, .waiting = waiting, .crowd = crowd};
    sights groups, clusters, patches;
    groups.count = clusters.count = patches.count = 0;
    if (crowd->count) job->crowded = true;
    for (uint32_t i = 0; i < crowd->count; i++) {
        const daft_member *m = &crowd->members[i];
        uint32_t above = (m->patches->level[DAFT_PATCH_LEVELS - 1].count + DAFT_PATCH - 1) / DAFT_PATCH;
        for (uint32_t k = 0; k < above; k++) {
            add_outlines(&w, m, DAFT_PATCH_LEVELS - 1, k, &groups);
            if (groups.count > LISTED - DAFT_PATCH) take_groups(&w, &groups, &clusters, &patches);
        }
    }
    take_groups(&w, &groups, &clusters, &patches);
    take_clusters(&w, &clusters, &patches);
    take_patches(&w, &patches);
    crowd->count = 0;
}
