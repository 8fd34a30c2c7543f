/* What a clip reaches, at every time of it and not only at keys.
 *
 * A vertex is a weighted mean of where its joints carry it, so the boxes of what each joint carries hold it. These are
 * put together at evenly spaced times, and made wider by the way that any of its points goes from one time to the next,
 * which is as far as it can be from where it is then. The way is bounded node by node. Let r be how far from a node's
 * origin a point is and m how far it goes there; of a node whose scale is at most s, that moves by p, turns by a and
 * scales by d,
 *
 *     m' = s m + (s a + d) r + p        r' = s r + |position|
 *
 * in its parent's axes. Both are linear in m and r, so one pass from the root down gives all of them. */
#include "geometry/rig/skin.h"

#include "math/trig.h"

#include <float.h>
#include <string.h>

enum { MOST_SAMPLES = 600, SAMPLES_A_SECOND = 60, MOST_WORK = 1 << 22 };

typedef struct box {
    double low[3], high[3];
} box;

static const box NOTHING = {{DBL_MAX, DBL_MAX, DBL_MAX}, {-DBL_MAX, -DBL_MAX, -DBL_MAX}};

static void box_add(box *b, const double low[3], const double high[3])
{
    for (int k = 0; k < 3; k++) {
        if (low[k] < b->low[k]) b->low[k] = low[k];
        if (high[k] > b->high[k]) b->high[k] = high[k];
    }
}

/* How a node moves from one time to the next, and the bound on the way in the model's axes:
 * m(r) = further·m + wider·r + way. */
typedef struct motion {
    double path, turn, stretch; /* p, a, d */
    double further, wider, way;
} motion;

typedef struct reach {
    const daft_allocator *allocator;
    const daft_rig *rig;
    const daft_rig_clip *clip;
    daft_rig_space *space;
    box *joints;            /* what each carries, in the vertices' axes */
    daft_rig_local *before; /* of each node, one time ago */
    motion *motions;
} reach;

/* ---- what a joint carries ---- */

/* Of a target in this clip. */
static void weight_range(const reach *r, uint32_t target, double *low, double *high)
{
    *low = *high = (double)r->rig->targets[target].rest;
    for (uint32_t i = 0; i < r->clip->track_count; i++) {
        const daft_rig_track *t = &r->clip->tracks[i];
        if (t->channel != DAFT_RIG_WEIGHT || t->of != target) continue;
        *low = *high = (double)t->values[0];
        for (uint32_t k = 1; k < t->count; k++) {
            *low = fmin(*low, (double)t->values[k]);
            *high = fmax(*high, (double)t->values[k]);
        }
        for (uint32_t k = 0; t->between == DAFT_RIG_CUBIC && k + 1 < t->count; k++) {
            double c[2];
            daft_rig_controls(t, k, 0, c);
            *low = fmin(*low, fmin(c[0], c[1])), *high = fmax(*high, fmax(c[0], c[1]));
        }
    }
}

/* Widens the range of each vertex by what the targets add. */
static void add_targets(const reach *r, box *vertices)
{
    for (uint32_t i = 0; i < r->rig->target_count; i++) {
        const daft_rig_target *target = &r->rig->targets[i];
        double low, high;
        weight_range(r, i, &low, &high);
        for (uint32_t k = 0; k < target->vertex_count; k++) {
            box *b = &vertices[target->vertices[k].point];
            for (int axis = 0; axis < 3; axis++) {
                const double by = (double)daft_v3_at(target->vertices[k].by, axis);
                b->low[axis] += fmin(low * by, high * by), b->high[axis] += fmax(low * by, high * by);
            }
        }
    }
}

static bool box_joints(reach *r)
{
    const daft_rig_points *v = &r->rig->vertices;
    box *vertices = daft_alloc(r->allocator, (size_t)v->count + 1, sizeof *vertices);
    if (!vertices) return false;
    for (uint32_t i = 0; i < v->count; i++) {
        const double p[3] = {(double)v->x[i], (double)v->y[i], (double)v->z[i]};
        memcpy(vertices[i].low, p, sizeof p), memcpy(vertices[i].high, p, sizeof p);
    }
    add_targets(r, vertices);
    for (uint32_t i = 0; i < r->rig->joint_count; i++) r->joints[i] = NOTHING;
    for (uint32_t i = 0; i < v->count; i++)
        for (int k = 0; k < DAFT_RIG_WEIGHTS; k++)
            if (v->weights[k][i] > 0) box_add(&r->joints[v->joints[k][i]], vertices[i].low, vertices[i].high);
    daft_release(r->allocator, vertices);
    return true;
}

/* ---- how far points go ---- */

#define HALF_TURN 3.1415927 /* radians, and a little */

static double pow2(double x) { return x * x; }

static double key_distance(const daft_rig_track *t, uint32_t key)
{
    const uint32_t width = daft_rig_width(t->channel);
    const float *a = t->values + (size_t)key * width, *b = a + width;
    double dot = 0, square = 0, most = 0;
    for (uint32_t i = 0; i < width; i++) {
        const double apart = (double)b[i] - (double)a[i];
        dot += (double)a[i] * (double)b[i], square += apart * apart, most = fmax(most, fabs(apart));
    }
    if (t->channel == DAFT_RIG_ROTATION) return 2 * daft_acos(fabs(dot)) + 1e-6; /* floats are unit to 1e-7 */
    return t->channel == DAFT_RIG_SCALE ? most : sqrt(square);
}

/* What a cubic's speed between two keys, times the time between them, is below: three times the longest leg of the
 * polygon of its Bezier form, whose legs are the control points of its derivative. A rotation turns by at most twice
 * the way of its quaternion over the least length that this has. */
static double cubic_distance(const daft_rig_track *t, uint32_t key)
{
    const uint32_t width = daft_rig_width(t->channel);
    double point[4][4] = {{0}}, most = 0, least = DBL_MAX;
    for (uint32_t i = 0; i < width; i++) {
        point[0][i] = (double)t->values[(size_t)key * width + i];
        point[3][i] = (double)t->values[((size_t)key + 1) * width + i];
        double c[2];
        daft_rig_controls(t, key, i, c);
        point[1][i] = c[0], point[2][i] = c[1];
    }
    for (int leg = 0; leg < 3; leg++) {
        double square = 0;
        for (int i = 0; i < 4; i++) square += pow2(point[leg + 1][i] - point[leg][i]);
        most = fmax(most, 3 * sqrt(square));
    }
    if (t->channel != DAFT_RIG_ROTATION) return most;
    double middle[4], length = 0;
    for (int i = 0; i < 4; i++) middle[i] = point[0][i] + point[3][i], length += pow2(middle[i]);
    for (int k = 0; k < 4; k++) {
        double along = 0;
        for (int i = 0; i < 4; i++) along += point[k][i] * middle[i];
        least = fmin(least, along / sqrt(length));
    }
    return least > 0 ? 2 * most / least : INFINITY;
}

/* What the track does between two times. */
static double track_way(const daft_rig_track *t, double from, double to)
{
    double way = 0;
    uint32_t low = 0, high = t->count;
    while (high - low > 1) { /* the last key that is not after `from` */
        const uint32_t middle = low + (high - low) / 2;
        if ((double)t->times[middle] <= from)
            low = middle;
        else
            high = middle;
    }
    for (uint32_t k = low; k + 1 < t->count && (double)t->times[k] < to; k++) {
        const double begin = fmax((double)t->times[k], from), end = fmin((double)t->times[k + 1], to);
        const double length = (double)t->times[k + 1] - (double)t->times[k];
        if (t->between == DAFT_RIG_STEP)
            way += (double)t->times[k + 1] <= to ? key_distance(t, k) : 0;
        else if (end > begin)
            way += (t->between == DAFT_RIG_CUBIC ? cubic_distance(t, k) : key_distance(t, k)) *
                   (length > 0 ? (end - begin) / length : 1);
    }
    return t->channel == DAFT_RIG_ROTATION ? fmin(way, HALF_TURN) : way; /* nothing is turned further */
}

static void find_motions(reach *r, double from, double to)
{
    for (uint32_t i = 0; i < r->rig->node_count; i++)
        r->motions[i].path = r->motions[i].turn = r->motions[i].stretch = 0;
    for (uint32_t i = 0; i < r->clip->track_count; i++) {
        const daft_rig_track *t = &r->clip->tracks[i];
        if (t->channel == DAFT_RIG_WEIGHT) continue;
        motion *m = &r->motions[t->of];
        *(t->channel == DAFT_RIG_POSITION   ? &m->path
          : t->channel == DAFT_RIG_ROTATION ? &m->turn
                                            : &m->stretch) += track_way(t, from, to);
    }
}

static double length3(const double v[3]) { return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }

/* The largest scale and distance from the parent's origin of a node in a pose. */
static void extent(const daft_rig_node *node, const daft_rig_local *local, double *scale, double *distance)
{
    if (local->moved) {
        const double *s = local->parts.scale;
        *scale = fmax(fabs(s[0]), fmax(fabs(s[1]), fabs(s[2]))), *distance = length3(local->parts.position);
        return;
    }
    const double *m = node->rest, at[3] = {m[3], m[7], m[11]};
    double square = 0;
    for (int row = 0; row < 3; row++)
        for (int k = 0; k < 3; k++) square += m[4 * row + k] * m[4 * row + k];
    *scale = sqrt(square), *distance = length3(at); /* Frobenius: no vector gets longer by more */
}

/* Parents stand before their children. */
static void bound_ways(reach *r)
{
    for (uint32_t i = 0; i < r->rig->node_count; i++) {
        const daft_rig_node *node = &r->rig->nodes[i];
        motion *m = &r->motions[i];
        double scale, distance, scale_before, distance_before;
        extent(node, &r->space->local[i], &scale, &distance);
        extent(node, &r->before[i], &scale_before, &distance_before);
        scale = fmax(scale, scale_before) + m->stretch, distance = fmax(distance, distance_before) + m->path;
        const motion still = {.further = 1, .wider = 0, .way = 0},
                     *above = node->parent == DAFT_RIG_NONE ? &still : &r->motions[node->parent];
        const double around = scale * m->turn + m->stretch;
        m->further = above->further * scale;
        m->wider = above->further * around + above->wider * scale;
        m->way = above->further * m->path + above->wider * distance + above->way;
    }
}

/* ---- the whole ---- */

static double farthest(const box *b, const double offset[12])
{
    double square = 0;
    for (int row = 0; row < 3; row++) {
        double low = offset[4 * row + 3], high = low;
        for (int k = 0; k < 3; k++) {
            const double a = offset[4 * row + k] * b->low[k], c = offset[4 * row + k] * b->high[k];
            low += fmin(a, c), high += fmax(a, c);
        }
        const double most = fmax(fabs(low), fabs(high));
        square += most * most;
    }
    return sqrt(square);
}

static void add_pose(const reach *r, bool moving, box *all)
{
    for (uint32_t i = 0; i < r->rig->joint_count; i++) {
        const daft_rig_joint *joint = &r->rig->joints[i];
        const box *b = &r->joints[i];
        const double *m = daft_rig_joint_matrix(r->space, i);
        double low[3], high[3], margin = 0;
        if (b->low[0] > b->high[0]) continue;
        if (moving) margin = r->motions[joint->node].wider * farthest(b, joint->offset) + r->motions[joint->node].way;
        for (int row = 0; row < 3; row++) {
            low[row] = high[row] = m[4 * row + 3];
            for (int k = 0; k < 3; k++) {
                const double x = m[4 * row + k] * b->low[k], y = m[4 * row + k] * b->high[k];
                low[row] += fmin(x, y), high[row] += fmax(x, y);
            }
            low[row] -= margin, high[row] += margin;
        }
        box_add(all, low, high);
    }
}

static void bound_clip(reach *r, box *all)
{
    const uint64_t size = (uint64_t)r->rig->node_count + r->rig->joint_count + 1;
    uint32_t steps = (uint32_t)fmin(ceil(r->clip->duration * SAMPLES_A_SECOND), MOST_SAMPLES);
    if (steps * size > MOST_WORK) steps = (uint32_t)(MOST_WORK / size);
    if (steps == 0) steps = 1;
    daft_rig_layer layer = {.clip = (uint32_t)(r->clip - r->rig->clips), .weight = 1};
    daft_rig_pose(r->rig, &layer, 1, r->space);
    add_pose(r, false, all);
    for (uint32_t i = 1; i <= steps; i++) {
        const double from = layer.time;
        layer.time = r->clip->duration * i / steps;
        find_motions(r, from, layer.time);
        memcpy(r->before, r->space->local, r->rig->node_count * sizeof *r->before);
        daft_rig_pose(r->rig, &layer, 1, r->space);
        bound_ways(r);
        add_pose(r, true, all);
    }
}

/* A little wider than computed: vertices are moved in floats. */
static daft_vec3 outwards(const double v[3], const box *all, double sign)
{
    float out[3];
    for (int k = 0; k < 3; k++) {
        const double slack = 1e-5 * (fabs(all->low[k]) + fabs(all->high[k])) + 1e-30;
        const double wide = v[k] + sign * slack;
        out[k] = (float)(wide > 3e38 ? 3e38 : wide < -3e38 ? -3e38 : wide == wide ? wide : sign * 3e38);
    }
    return daft_v3(out[0], out[1], out[2]);
}

static bool bound_all(reach *r, daft_rig *rig)
{
    for (uint32_t i = 0; i < rig->clip_count; i++) {
        box all = NOTHING;
        r->clip = &rig->clips[i];
        if (!box_joints(r)) return false;
        bound_clip(r, &all);
        rig->clips[i].low = outwards(all.low, &all, -1), rig->clips[i].high = outwards(all.high, &all, 1);
    }
    return true;
}

bool daft_rig_bound(const daft_allocator *allocator, daft_rig *rig, daft_error *error)
{
    reach r = {.allocator = allocator, .rig = rig};
    r.space = daft_rig_space_make(allocator, rig, error);
    r.joints = daft_alloc(allocator, (size_t)rig->joint_count + 1, sizeof *r.joints);
    r.before = daft_alloc(allocator, (size_t)rig->node_count + 1, sizeof *r.before);
    r.motions = daft_alloc(allocator, (size_t)rig->node_count + 1, sizeof *r.motions);
    const bool done = r.space && r.joints && r.before && r.motions && bound_all(&r, rig);
    daft_rig_space_free(r.space);
    daft_release(allocator, r.joints), daft_release(allocator, r.before), daft_release(allocator, r.motions);
    return done || daft_fail_memory(error, "the bounds of a clip");
}
