/* Bounds of where triangles look, and those below a node (sides.h has what they promise). Blocks stand in depth-first order, so
 * those below a child are a range, and each child's bound is made of its own triangles. Parts of many triangles look
 * every way and are not even tried, so time is linear. */
#include "accel/find_sides.h"
#include "math/simd/ops.h"

enum { MOST_BLOCKS = 1024, STEPS = 8 };
#define NEVER_AWAY 0x80000000u

/* Four triangles, by lanes. */
typedef struct faces {
    v4 normal[3], corner[3]; /* one corner of each */
    v4 thinness; /* one over the least height; infinite: of two sides, or no normal worth the name */
} faces;

typedef struct cone_job {
    const daft_bvh *bvh;
    daft_sides *sides;
    faces *faces; /* of each block */
    faces *patches; /* of each quarter of a patch */
    uint32_t *first, *end; /* of each node: its blocks */
} cone_job;

static daft_dvec3 block_corner(const daft_block *block, int corner, uint32_t lane)
{
    const float(*c)[DAFT_BLOCK] = block->corner[corner];
    return daft_dv3((double)c[0][lane], (double)c[1][lane], (double)c[2][lane]);
}

static daft_dvec3 patch_corner(const daft_patch *p, int corner, uint32_t triangle)
{
    uint32_t at = p->at[corner][triangle];
    return daft_dv3((double)p->corner[0][at], (double)p->corner[1][at], (double)p->corner[2][at]);
}

static void face_make(daft_dvec3 a, daft_dvec3 b, daft_dvec3 c, bool one_sided, uint32_t lane, faces *out)
{
    daft_dvec3 e = daft_dsub(b, a), f = daft_dsub(c, b), g = daft_dsub(a, c), n = daft_dcross(e, f);
    double longest = sqrt(fmax(fmax(daft_ddot(e, e), daft_ddot(f, f)), daft_ddot(g, g))), area = sqrt(daft_ddot(n, n));
    bool fit = one_sided && area > longest * longest * 0x1p-20;
    daft_dvec3 unit = fit ? daft_dscale(n, 1 / area) : daft_dv3(0, 0, 0);
    out->normal[0][lane] = (float)unit.x, out->normal[1][lane] = (float)unit.y, out->normal[2][lane] = (float)unit.z;
    out->corner[0][lane] = (float)a.x, out->corner[1][lane] = (float)a.y, out->corner[2][lane] = (float)a.z;
    out->thinness[lane] = fit ? (float)(longest / area * (1 + 0x1p-20)) : INFINITY;
}

static void find_ranges(cone_job *j)
{
    for (size_t n = j->bvh->nodes.count; n-- > 0;) {
        const daft_node *node = &j->bvh->nodes.items[n];
        j->first[n] = UINT32_MAX, j->end[n] = 0;
        for (int i = 0; i < DAFT_WIDTH; i++) {
            uint32_t child = node->child[i];
            if (child == DAFT_CHILD_NONE) continue;
            uint32_t block = (child & ~DAFT_CHILD_LEAF) >> 2;
            bool leaf = child & DAFT_CHILD_LEAF;
            j->first[n] = daft_min_u(j->first[n], leaf ? block : j->first[child]);
            j->end[n] = daft_max_u(j->end[n], leaf ? block + (child & 3) + 1 : j->end[child]);
        }
    }
}

static v4 along(const faces *f, daft_dvec3 axis)
{
    return f->normal[0] * v4_set((float)axis.x) + f->normal[1] * v4_set((float)axis.y) + f->normal[2] * v4_set((float)axis.z);
}

static daft_dvec3 normal_at(const faces *f, uint32_t lane)
{
    return daft_dv3((double)f->normal[0][lane], (double)f->normal[1][lane], (double)f->normal[2][lane]);
}

static daft_dvec3 unit(daft_dvec3 v)
{
    double length = sqrt(daft_ddot(v, v));
    return length > 0 ? daft_dscale(v, 1 / length) : v;
}

/* ---- looks ---- */

/* Four times the mean of those that have a height: for the few beyond, the others would have to keep a wide margin. */
static float usual_thinness(const cone_job *j)
{
    double sum = 0, count = 0;
    for (size_t b = 0; b < j->bvh->block_count; b++)
        for (uint32_t i = 0; i < DAFT_BLOCK; i++) {
            float thinness = j->faces[b].thinness[i];
            if (thinness < INFINITY) sum += (double)thinness, count++;
        }
    return count > 0 ? (float)(4 * sum / count) : 0;
}

/* Of a normal, and an offset that is rounded down; a part may lie before the planes of all its triangles by more than the
 * radius. */
static uint32_t look_of(const cone_job *j, daft_dvec3 n, double offset)
{
    const double value[4] = {127 * n.x + 0.5, 127 * n.y + 0.5, 127 * n.z + 0.5, fmin(127 * offset / (double)j->sides->radius, 127)};
    uint32_t look = 0;
    if (!(value[3] >= -127)) return NEVER_AWAY;
    for (int k = 0; k < 4; k++) look |= ((uint32_t)(int32_t)floor(value[k]) & 255) << (8 * k);
    return look;
}

static void fill_faces(cone_job *j)
{
    for (size_t b = 0; b < j->bvh->block_count; b++)
        for (uint32_t i = 0; i < DAFT_BLOCK; i++) {
            const daft_block *block = &j->bvh->blocks[b];
            face_make(block_corner(block, 0, i), block_corner(block, 1, i), block_corner(block, 2, i), j->sides->blocks[b] >> i & 1, i, &j->faces[b]);
        }
    j->sides->thinness = usual_thinness(j);
}

/* Unused triangles of a patch count as its last one. */
static void fill_patch_faces(const cone_job *j)
{
    const daft_patches *patches = &j->sides->patches;
    for (uint32_t i = 0; i < patches->level[0].count * DAFT_PATCH; i++) {
        const daft_patch *p = &patches->items[i / DAFT_PATCH];
        uint32_t t = i % DAFT_PATCH;
        while (!(p->there >> t & 1)) t--;
        face_make(patch_corner(p, 0, t), patch_corner(p, 1, t), patch_corner(p, 2, t), p->one_sided >> t & 1, i % DAFT_BLOCK, &j->patches[i / DAFT_BLOCK]);
    }
}

/* ---- cones ---- */

/* The normal that is farthest from the axis; gives the cosine between the two. */
static float farthest(const faces *f, uint32_t count, daft_dvec3 axis, daft_dvec3 *normal)
{
    v4 least = v4_set(INFINITY);
    v4i at = {0};
    for (uint32_t i = 0; i < count; i++) {
        v4 cosine = along(&f[i], axis);
        v4i less = (v4i)(cosine < least);
        least = v4_min(cosine, least), at = (less & ((v4i){0} + (int32_t)i)) | (~less & at);
    }
    uint32_t lane = 0;
    for (uint32_t i = 1; i < DAFT_BLOCK; i++)
        if (least[i] < least[lane]) lane = i;
    *normal = normal_at(&f[at[lane]], lane);
    return least[lane];
}

/* The mean of the normals, then moved towards the farthest one, ever less (Badoiu and Clarkson, "Smaller Core-Sets for Balls",
 * 2003). *cosine: of the angle that holds all. */
static daft_dvec3 axis_of(const faces *f, uint32_t count, float *cosine)
{
    v4 sum[3] = {{0}, {0}, {0}};
    for (uint32_t i = 0; i < count; i++)
        for (int k = 0; k < 3; k++) sum[k] += f[i].normal[k];
    double s[3];
    for (int k = 0; k < 3; k++) s[k] = (double)sum[k][0] + (double)sum[k][1] + ((double)sum[k][2] + (double)sum[k][3]);
    daft_dvec3 axis = unit(daft_dv3(s[0], s[1], s[2])), best = axis, far;
    *cosine = farthest(f, count, axis, &far);
    for (int step = 0; step < STEPS && *cosine > 0.1f; step++) {
        axis = unit(daft_dadd(axis, daft_dscale(daft_dsub(far, axis), 1.0 / (step + 2))));
        float least = farthest(f, count, axis, &far);
        if (least > *cosine) *cosine = least, best = axis;
    }
    return best;
}

/* The least normal·(corner - middle). */
static double least_offset(const faces *f, uint32_t count, daft_dvec3 middle)
{
    double least = INFINITY;
    for (uint32_t b = 0; b < count; b++)
        for (uint32_t i = 0; i < DAFT_BLOCK; i++) {
            daft_dvec3 corner = daft_dv3((double)f[b].corner[0][i], (double)f[b].corner[1][i], (double)f[b].corner[2][i]);
            least = fmin(least, daft_ddot(normal_at(&f[b], i), daft_dsub(corner, middle)));
        }
    return least;
}

static float thinnest(const faces *f, uint32_t count)
{
    v4 most = v4_set(0);
    for (uint32_t i = 0; i < count; i++) most = v4_max(f[i].thinness, most);
    return fmaxf(fmaxf(most[0], most[1]), fmaxf(most[2], most[3]));
}

/* Around a point near the faces. */
static void cone_make(const cone_job *j, const faces *f, uint32_t count, daft_dvec3 o, uint32_t *look, float *spread)
{
    float cosine = 0;
    daft_dvec3 axis = {0, 0, 0};
    *look = NEVER_AWAY, *spread = 0;
    if (count <= MOST_BLOCKS && thinnest(f, count) <= j->sides->thinness) axis = axis_of(f, count, &cosine);
    if (!(cosine > 0.01f)) return; /* every way, or of two sides */
    double c = fmin((double)cosine, 1) - 0x1p-21;
    daft_dvec3 scaled = daft_dscale(axis, c);
    *look = look_of(j, scaled, daft_ddot(scaled, daft_dsub(o, j->sides->middle)) + least_offset(f, count, o));
    *spread = (float)(127 * sqrt(1 - c * c) * (1 + 0x1p-20));
}

static daft_dvec3 box_middle(const daft_node *node, int child)
{
    double middle[3];
    for (int k = 0; k < 3; k++) middle[k] = ((double)node->bounds[k][child] + (double)node->bounds[k + 3][child]) * 0.5;
    return daft_dv3(middle[0], middle[1], middle[2]);
}

static void fill_nodes(const cone_job *j)
{
    for (size_t n = 0; n < j->bvh->nodes.count; n++) {
        const daft_node *node = &j->bvh->nodes.items[n];
        for (int i = 0; i < DAFT_WIDTH; i++) {
            uint32_t child = node->child[i], block = (child & ~DAFT_CHILD_LEAF) >> 2, first = 0, end = MOST_BLOCKS + 1;
            if (child != DAFT_CHILD_NONE) {
                bool leaf = child & DAFT_CHILD_LEAF;
                first = leaf ? block : j->first[child], end = leaf ? block + (child & 3) + 1 : j->end[child];
            }
            daft_cones *to = &j->sides->cones[n];
            cone_make(j, j->faces + first, end - first, box_middle(node, i), &to->look[i], &to->spread[i]);
        }
    }
}

static void fill_outline(const cone_job *j, int level, uint32_t i, const faces *f, uint32_t count)
{
    const daft_patches *p = &j->sides->patches;
    daft_outlines *to = &p->level[level].items[i / DAFT_PATCH];
    daft_dvec3 middle = daft_dadd(daft_to_double(p->low), daft_dscale(daft_outline_middle(&p->level[level], i), (double)p->unit));
    uint32_t look;
    cone_make(j, f, count, middle, &look, &to->spread[i % DAFT_PATCH]);
    for (int k = 0; k < 4; k++) to->look[k][i % DAFT_PATCH] = (float)(int8_t)(look >> 8 * k);
}

static void fill_patches(const cone_job *j)
{
    const daft_patches *p = &j->sides->patches;
    uint32_t quarters = p->level[0].count * (DAFT_PATCH / DAFT_BLOCK), each = DAFT_PATCH / DAFT_BLOCK;
    for (int level = 0; level < DAFT_PATCH_LEVELS; level++, each *= DAFT_PATCH)
        for (uint32_t i = 0; i < p->level[level].count; i++) fill_outline(j, level, i, j->patches + i * each, daft_min_u(each, quarters - i * each));
}

bool daft_cones_fill(const daft_bvh *bvh, daft_sides *sides)
{
    const daft_allocator *a = &bvh->allocator;
    cone_job job = {.bvh = bvh, .sides = sides};
    job.faces = daft_alloc(a, bvh->block_count, sizeof *job.faces);
    job.first = daft_alloc(a, bvh->nodes.count, sizeof *job.first);
    job.end = daft_alloc(a, bvh->nodes.count, sizeof *job.end);
    job.patches = daft_alloc(a, sides->patches.level[0].count, DAFT_PATCH / DAFT_BLOCK * sizeof *job.patches);
    bool done = job.patches && job.faces && job.first && job.end;
    if (done) {
        fill_faces(&job);
        find_ranges(&job);
        fill_nodes(&job);
        fill_patch_faces(&job);
        fill_patches(&job);
    }
    daft_release(a, job.faces);
    daft_release(a, job.patches);
    daft_release(a, job.first);
    daft_release(a, job.end);
    return done;
}
