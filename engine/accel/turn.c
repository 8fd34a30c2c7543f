/* Frames for trees. Boxes along the mesh's axes are large around what is long or flat and lies across them, and a ray meets a
 * box as often as its surface is large (Goldsmith and Salmon, "Automatic Creation of Object Hierarchies for Ray Tracing", 1987).
 * So what a frame is worth is told by the sum of the surfaces of boxes in it: first of some triangles, before anything is built;
 * then of some of a tree's lowest nodes, since what is long or flat may be made of small triangles.
 *
 * Frames that are tried: those of the triangles with the largest boxes, along an edge and the normal, as oriented boxes are found
 * from extremal triangles (Larsson and Källberg, "Fast Computation of Tight-Fitting Oriented Bounding Boxes", 2011); the principal
 * axes of edges, for bundles that go one way only in the mean; and those of the nodes' corners, each about their own middle
 * (Gottschalk, Lin, Manocha, "OBBTree: A Hierarchical Structure for Rapid Interference Detection", 1996).
 *
 * One is taken only where boxes become much smaller, and in each of four parts of the sample, so that a few huge triangles do
 * not decide for all: every ray into the mesh is turned once more then. */
#include "accel/bvh.h"
#include "math/simd.h"

enum { PARTS = 4, SAMPLE = 256, ONE_IN = 96, LEAST = 2048, SWEEPS = 6 };
enum { SPREAD = 8, LEVELS = 8, RUNS = 16, LEAST_BLOCKS = 4096 };
/* Boxes' surfaces must be less than WORTH of what they are along the mesh's axes, those of each part less than BETTER. Groups
 * are few, and cut by planes across the mesh's axes: in another frame they look larger than those of a tree that is built in it. */
#define WORTH 0.7f
#define BETTER 0.9f
#define WORTH_GROUPS 0.8f
#define BETTER_GROUPS 2.0f
#define LEAST_REACH 1e-12f /* between these nothing that boxes need over- or underflows */
#define MOST_REACH 1e15f

static const float NONE[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};

/* Two edges of each triangle from its first corner. Triangles in a row belong to one part. */
typedef struct sample {
    uint32_t count; /* a multiple of 4·PARTS */
    float edge[2][3][SAMPLE];
} sample;

/* Half the surfaces of boxes, summed by part; and the triangle with the largest one in each. */
typedef struct surfaces {
    float sum[PARTS];
    uint32_t largest[PARTS];
} surfaces;

static void take_sample(const daft_trimesh *mesh, sample *out)
{
    const float *axes[3] = {mesh->x, mesh->y, mesh->z};
    uint32_t count = mesh->triangle_count / ONE_IN & ~(4u * PARTS - 1);
    out->count = count < 4 * PARTS ? 4 * PARTS : count < SAMPLE ? count : SAMPLE;
    for (uint32_t i = 0; i < out->count; i++) {
        /* multiples of the golden ratio: even, and in step with no pattern of the mesh's */
        uint32_t at = (uint32_t)((uint64_t)(i * 2654435769u) * mesh->triangle_count >> 32);
        const uint32_t *corner = &mesh->indices[3 * (size_t)at];
        for (int k = 0; k < 3; k++) {
            float from = axes[k][corner[0]];
            out->edge[0][k][i] = axes[k][corner[1]] - from, out->edge[1][k][i] = axes[k][corner[2]] - from;
        }
    }
}

/* Four triangles' boxes along an axis. */
static inline v4 sides(const sample *s, uint32_t i, const float *axis)
{
    v4 along[2], zero = v4_set(0);
    for (int e = 0; e < 2; e++) {
        const float(*edge)[SAMPLE] = s->edge[e];
        along[e] = v4_load(edge[0] + i) * v4_set(axis[0]) + v4_load(edge[1] + i) * v4_set(axis[1]) + v4_load(edge[2] + i) * v4_set(axis[2]);
    }
    return v4_max(v4_max(along[0], along[1]), zero) - v4_min(v4_min(along[0], along[1]), zero);
}

static surfaces surfaces_in(const sample *s, const float frame[9])
{
    surfaces out;
    uint32_t part = s->count / PARTS;
    for (uint32_t p = 0; p < PARTS; p++) {
        v4 sum = v4_set(0);
        float most = -1;
        out.largest[p] = p * part;
        for (uint32_t i = p * part; i < (p + 1) * part; i += 4) {
            v4 x = sides(s, i, frame), y = sides(s, i, frame + 3), z = sides(s, i, frame + 6), area = x * (y + z) + y * z;
            sum += area;
            for (uint32_t k = 0; k < 4; k++)
                if (area[k] > most) most = area[k], out.largest[p] = i + k;
        }
        out.sum[p] = (sum[0] + sum[1]) + (sum[2] + sum[3]);
    }
    return out;
}

/* The share of what it was; infinite where that of some part is not below `better`. */
static float share(const surfaces *now, const surfaces *before, float better)
{
    float sum = 0, whole = 0;
    for (int p = 0; p < PARTS; p++) {
        if (!(now->sum[p] < better * before->sum[p])) return INFINITY;
        sum += now->sum[p], whole += before->sum[p];
    }
    return sum / whole;
}

/* ---- frames ---- */

typedef struct edges {
    daft_dvec3 middle, shortest; /* by length */
} edges;

/* The longest one is left: in a long quad of two triangles that is the diagonal, which lies a little askew. */
static edges edges_of(const sample *s, uint32_t i)
{
    daft_dvec3 e[3];
    for (int k = 0; k < 2; k++) e[k] = daft_dv3((double)s->edge[k][0][i], (double)s->edge[k][1][i], (double)s->edge[k][2][i]);
    e[2] = daft_dsub(e[1], e[0]);
    for (int k = 0; k < 3; k++) {
        int a = k % 2;
        daft_dvec3 first = e[a], second = e[a + 1];
        if (daft_ddot(first, first) > daft_ddot(second, second)) e[a] = second, e[a + 1] = first;
    }
    return (edges){e[1], e[0]};
}

/* Along `x`, and across it in the plane of x and y. False: these span none. */
static bool frame_of(daft_dvec3 x, daft_dvec3 y, float frame[9])
{
    daft_dvec3 z = daft_dcross(x, y);
    double xx = daft_ddot(x, x), zz = daft_ddot(z, z);
    if (!(xx > 1e-30 && xx < 1e30 && zz > 1e-12 * xx * daft_ddot(y, y))) return false;
    daft_dvec3 rows[3] = {daft_dscale(x, 1 / sqrt(xx)), {0, 0, 0}, daft_dscale(z, 1 / sqrt(zz))};
    rows[1] = daft_dcross(rows[2], rows[0]);
    for (int k = 0; k < 3; k++)
        frame[3 * k] = (float)rows[k].x, frame[3 * k + 1] = (float)rows[k].y, frame[3 * k + 2] = (float)rows[k].z;
    return true;
}

static bool frame_of_triangle(const sample *s, uint32_t i, float frame[9])
{
    edges e = edges_of(s, i);
    return frame_of(e.middle, e.shortest, frame);
}

/* Along one triangle's edge, and as near as may be to that which reaches furthest across it. */
static bool frame_of_pair(const sample *s, uint32_t i, float frame[9])
{
    daft_dvec3 x = edges_of(s, i).middle, widest = x;
    double most = 0, xx = daft_ddot(x, x);
    for (uint32_t j = 0; j < s->count; j++) {
        daft_dvec3 e = edges_of(s, j).middle;
        double along = daft_ddot(e, x), across = daft_ddot(e, e) * xx - along * along;
        if (across > most) most = across, widest = e;
    }
    return frame_of(x, widest, frame);
}

/* One of Jacobi's rotations of a symmetric matrix, which makes a[p][q] zero; v's columns are turned along. */
static void rotate(double a[3][3], double v[3][3], int p, int q)
{
    if (a[p][q] == 0) return;
    double theta = (a[q][q] - a[p][p]) / (2 * a[p][q]), t = 1 / (fabs(theta) + sqrt(theta * theta + 1));
    t = theta < 0 ? -t : t;
    double c = 1 / sqrt(t * t + 1), s = t * c;
    for (int k = 0; k < 3; k++) {
        double x = a[k][p], y = a[k][q];
        a[k][p] = c * x - s * y, a[k][q] = s * x + c * y;
    }
    for (int k = 0; k < 3; k++) {
        double x = a[p][k], y = a[q][k];
        a[p][k] = c * x - s * y, a[q][k] = s * x + c * y;
        x = v[k][p], y = v[k][q];
        v[k][p] = c * x - s * y, v[k][q] = s * x + c * y;
    }
}

static bool principal_frame(double a[3][3], float frame[9])
{
    double v[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (int i = 0; i < SWEEPS; i++) rotate(a, v, 0, 1), rotate(a, v, 0, 2), rotate(a, v, 1, 2);
    return frame_of(daft_dv3(v[0][0], v[1][0], v[2][0]), daft_dv3(v[0][1], v[1][1], v[2][1]), frame);
}

static bool frame_of_edges(const sample *s, float frame[9])
{
    double a[3][3] = {{0}};
    for (uint32_t i = 0; i < s->count; i++) {
        daft_dvec3 e = edges_of(s, i).middle;
        const double along[3] = {e.x, e.y, e.z};
        for (int j = 0; j < 3; j++)
            for (int k = 0; k < 3; k++) a[j][k] += along[j] * along[k];
    }
    return principal_frame(a, frame);
}

static bool turn_begin(daft_turn *turn, const daft_trimesh *mesh)
{
    for (int k = 0; k < 3; k++) turn->centre[k] = 0.5f * (&mesh->low.x)[k] + 0.5f * (&mesh->high.x)[k];
    return daft_turn_fit(turn, mesh);
}

bool daft_turn_find(const daft_trimesh *mesh, daft_turn *out)
{
    sample s;
    float frame[9], best = INFINITY;
    memcpy(out->m, NONE, sizeof NONE);
    if (mesh->triangle_count < LEAST) return false;
    take_sample(mesh, &s);
    surfaces own = surfaces_in(&s, NONE);
    for (uint32_t i = 0; i <= PARTS; i++) {
        uint32_t large = own.largest[i % PARTS];
        if (!(i == PARTS ? frame_of_edges(&s, frame) : i % 2 ? frame_of_pair(&s, large, frame) : frame_of_triangle(&s, large, frame))) continue;
        surfaces turned = surfaces_in(&s, frame);
        float part = share(&turned, &own, BETTER);
        if (!(part < best)) continue;
        best = part;
        memcpy(out->m, frame, sizeof frame);
    }
    return best < WORTH && turn_begin(out, mesh);
}

/* ---- what a tree's nodes say ---- */

/* What some nodes hold, on each of the upper levels: a corner of the triangles of SPREAD of the blocks below each. */
typedef struct groups {
    uint32_t count;
    v4 corner[LEVELS * RUNS][SPREAD][3];
    float weight[LEVELS * RUNS]; /* how many nodes it stands for */
} groups;

/* Blocks stand in depth-first order, so those below a node are in a row: its first, or its last. */
static uint32_t block_below(const daft_bvh *bvh, uint32_t child, bool last)
{
    while (!(child & DAFT_CHILD_LEAF)) {
        const uint32_t *children = bvh->nodes.items[child].child;
        int i = 0;
        while (last && i < DAFT_WIDTH - 1 && children[i + 1] != DAFT_CHILD_NONE) i++;
        child = children[i];
    }
    return ((child & ~DAFT_CHILD_LEAF) >> 2) + (last ? child & 3 : 0);
}

static void take_group(const daft_bvh *bvh, uint32_t node, float weight, groups *out)
{
    uint32_t first = block_below(bvh, node, false), span = block_below(bvh, node, true) - first;
    for (uint32_t j = 0; j < SPREAD; j++)
        for (int k = 0; k < 3; k++)
            out->corner[out->count][j][k] = v4_load(bvh->blocks[first + (uint32_t)((uint64_t)span * j / (SPREAD - 1))].corner[0][k]);
    out->weight[out->count++] = weight;
}

/* From the root down to a lowest node, any child of a node being as likely as the next. */
static void take_groups(const daft_bvh *bvh, groups *out)
{
    uint32_t state = 1;
    out->count = 0;
    for (int run = 0; run < RUNS; run++) {
        uint32_t node = 0, below[DAFT_WIDTH];
        float weight = 1;
        for (int level = 0; level < LEVELS; level++) {
            uint32_t count = 0;
            take_group(bvh, node, weight, out);
            for (int i = 0; i < DAFT_WIDTH; i++)
                if (!(bvh->nodes.items[node].child[i] & DAFT_CHILD_LEAF)) below[count++] = bvh->nodes.items[node].child[i];
            if (count == 0) break;
            state = state * 747796405u + 2891336453u;
            node = below[(uint64_t)state * count >> 32];
            weight *= (float)count;
        }
    }
}

static float reduced_side(v4 low, v4 high)
{
    v4 side[2] = {low, -high};
    for (int k = 0; k < 2; k++) {
        v4 a = v4_min(side[k], __builtin_shufflevector(side[k], side[k], 2, 3, 0, 1));
        side[k] = v4_min(a, __builtin_shufflevector(a, a, 1, 0, 3, 2));
    }
    return -(side[0][0] + side[1][0]);
}

static surfaces group_surfaces(const groups *g, const float frame[9])
{
    surfaces out = {{0}, {0}};
    for (uint32_t i = 0; i < g->count; i++) {
        float side[3];
        for (int k = 0; k < 3; k++) {
            const float *axis = frame + 3 * k;
            v4 low = v4_set(INFINITY), high = -low;
            for (int j = 0; j < SPREAD; j++) {
                const v4 *p = g->corner[i][j];
                v4 along = p[0] * v4_set(axis[0]) + p[1] * v4_set(axis[1]) + p[2] * v4_set(axis[2]);
                low = v4_min(low, along), high = v4_max(high, along);
            }
            side[k] = reduced_side(low, high);
        }
        out.sum[i % PARTS] += (side[0] * (side[1] + side[2]) + side[1] * side[2]) * g->weight[i];
    }
    return out;
}

static float sum_of(v4 a) { return (a[0] + a[1]) + (a[2] + a[3]); }

/* The principal axes of the corners about their groups' middles. */
static bool frame_of_groups(const groups *g, float frame[9])
{
    double a[3][3] = {{0}};
    for (uint32_t i = 0; i < g->count; i++) {
        v4 middle[3], second[6];
        for (int k = 0; k < 3; k++) {
            v4 sum = v4_set(0);
            for (int j = 0; j < SPREAD; j++) sum += g->corner[i][j][k];
            middle[k] = v4_set(sum_of(sum) * (1.0f / (4 * SPREAD)));
        }
        for (int k = 0; k < 6; k++) second[k] = v4_set(0);
        for (int j = 0; j < SPREAD; j++) {
            v4 x = g->corner[i][j][0] - middle[0], y = g->corner[i][j][1] - middle[1], z = g->corner[i][j][2] - middle[2];
            second[0] += x * x, second[1] += x * y, second[2] += x * z, second[3] += y * y, second[4] += y * z, second[5] += z * z;
        }
        for (int j = 0, n = 0; j < 3; j++)
            for (int k = j; k < 3; k++, n++) a[j][k] += (double)sum_of(second[n]) * (double)g->weight[i];
    }
    a[1][0] = a[0][1], a[2][0] = a[0][2], a[2][1] = a[1][2];
    return principal_frame(a, frame);
}

static void try_frame(const groups *g, const surfaces *own, const float frame[9], float best_frame[9], float *best)
{
    surfaces turned = group_surfaces(g, frame);
    float part = share(&turned, own, BETTER_GROUPS);
    if (part < *best) *best = part, memmove(best_frame, frame, 9 * sizeof *frame);
}

bool daft_turn_find_grouped(const daft_bvh *bvh, const daft_trimesh *mesh, daft_turn *out)
{
    groups g;
    float frame[9], best = INFINITY;
    if (bvh->block_count < LEAST_BLOCKS) return false; /* few groups say too little */
    take_groups(bvh, &g);
    surfaces own = group_surfaces(&g, NONE);
    try_frame(&g, &own, out->m, out->m, &best);
    if (frame_of_groups(&g, frame)) try_frame(&g, &own, frame, out->m, &best);
    return best < WORTH_GROUPS && turn_begin(out, mesh);
}

bool daft_turn_fit(daft_turn *turn, const daft_trimesh *mesh)
{
    float sum = 0;
    for (int k = 0; k < 3; k++) {
        float below = turn->centre[k] - (&mesh->low.x)[k], above = (&mesh->high.x)[k] - turn->centre[k];
        sum += below > above ? below : above;
    }
    turn->reach = sum * (1 + 0x1p-20f);
    return turn->reach > LEAST_REACH && turn->reach < MOST_REACH;
}

/* ---- into the frame and out of it ---- */

static daft_dvec3 rows_of(const double m[9], daft_dvec3 d)
{
    return daft_dv3(m[0] * d.x + m[1] * d.y + m[2] * d.z, m[3] * d.x + m[4] * d.y + m[5] * d.z, m[6] * d.x + m[7] * d.y + m[8] * d.z);
}

daft_dvec3 daft_turn_vector(const daft_turn *turn, daft_dvec3 d)
{
    double m[9];
    for (int i = 0; i < 9; i++) m[i] = (double)turn->m[i];
    return rows_of(m, d);
}

daft_dvec3 daft_turn_point(const daft_turn *turn, daft_dvec3 p)
{
    const float *c = turn->centre;
    return daft_turn_vector(turn, daft_dsub(p, daft_dv3((double)c[0], (double)c[1], (double)c[2])));
}

daft_dvec3 daft_turn_reach(const daft_turn *turn, daft_dvec3 half)
{
    double m[9];
    for (int i = 0; i < 9; i++) m[i] = fabs((double)turn->m[i]);
    return rows_of(m, half);
}

void daft_turn_box(const daft_turn *turn, daft_vec3 *low, daft_vec3 *high)
{
    daft_dvec3 l = daft_to_double(*low), h = daft_to_double(*high);
    daft_dvec3 at = daft_turn_point(turn, daft_dscale(daft_dadd(l, h), 0.5)), reach = daft_turn_reach(turn, daft_dscale(daft_dsub(h, l), 0.5));
    const double q[3] = {at.x, at.y, at.z}, r[3] = {reach.x, reach.y, reach.z};
    float out[2][3];
    for (int k = 0; k < 3; k++) {
        double more = (fabs(q[k]) + r[k]) * 0x1p-23;
        out[0][k] = (float)(q[k] - r[k] - more), out[1][k] = (float)(q[k] + r[k] + more);
    }
    *low = daft_v3(out[0][0], out[0][1], out[0][2]), *high = daft_v3(out[1][0], out[1][1], out[1][2]);
}

/* The inverse of m. */
static void invert(const daft_turn *turn, double back[9])
{
    const float *m = turn->m;
    daft_dvec3 x = daft_dv3((double)m[0], (double)m[1], (double)m[2]), y = daft_dv3((double)m[3], (double)m[4], (double)m[5]);
    daft_dvec3 z = daft_dv3((double)m[6], (double)m[7], (double)m[8]);
    daft_dvec3 columns[3] = {daft_dcross(y, z), daft_dcross(z, x), daft_dcross(x, y)};
    double scale = 1 / daft_ddot(x, columns[0]);
    for (int k = 0; k < 3; k++)
        back[k] = columns[k].x * scale, back[3 + k] = columns[k].y * scale, back[6 + k] = columns[k].z * scale;
}

daft_dvec3 daft_turn_back(const daft_turn *turn, daft_dvec3 q)
{
    double back[9];
    const float *c = turn->centre;
    invert(turn, back);
    return daft_dadd(rows_of(back, q), daft_dv3((double)c[0], (double)c[1], (double)c[2]));
}

daft_affine daft_turn_map(const daft_turn *turn, const daft_affine *map)
{
    double back[9];
    invert(turn, back);
    daft_affine out;
    for (int i = 0; i < 3; i++) {
        const float *row = &map->m[3 * i];
        double at = (double)map->t[i];
        for (int j = 0; j < 3; j++) {
            at += (double)row[j] * (double)turn->centre[j];
            out.m[3 * i + j] = (float)((double)row[0] * back[j] + (double)row[1] * back[3 + j] + (double)row[2] * back[6 + j]);
        }
        out.t[i] = (float)at;
    }
    return out;
}
