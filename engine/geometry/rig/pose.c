/* Poses: keys to transforms of nodes, layers over each other, the hierarchy, then the vertices. All in double, with
 * trigonometry of our own, so that a pose is the same bits everywhere. */
#include "geometry/rig/skin.h"

#include "geometry/trimesh.h"
#include "math/trig.h"

#include <string.h>

void daft_rig_multiply(const double a[12], const double b[12], double out[12])
{
    for (int row = 0; row < 3; row++)
        for (int k = 0; k < 4; k++)
            out[4 * row + k] = a[4 * row] * b[k] + a[4 * row + 1] * b[4 + k] + a[4 * row + 2] * b[8 + k] +
                               (k == 3 ? a[4 * row + 3] : 0);
}

/* ---- between two values ---- */

static void mix(const double *a, const double *b, double t, int count, double *out)
{
    for (int i = 0; i < count; i++) out[i] = a[i] + (b[i] - a[i]) * t;
}

/* On the shorter arc at constant speed (Shoemake, "Animating Rotation with Quaternion Curves", 1985); nearly equal
 * ones in a straight line. */
static void slerp(const double a[4], const double b[4], double t, double out[4])
{
    double dot = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3], u = 1 - t, v = t;
    const double sign = dot < 0 ? -1 : 1;
    dot *= sign;
    if (dot < 0.9995) {
        const double angle = daft_acos(dot), s = daft_sin(angle);
        u = daft_sin(angle * (1 - t)) / s, v = daft_sin(angle * t) / s;
    }
    double length = 0;
    for (int i = 0; i < 4; i++) out[i] = u * a[i] + sign * v * b[i], length += out[i] * out[i];
    length = sqrt(length);
    for (int i = 0; i < 4; i++) out[i] = length > 0 ? out[i] / length : i == 3;
}

/* ---- keys ---- */

/* The last key that is not after the time; the first, where all are. */
static uint32_t key_before(const daft_rig_track *track, double time)
{
    uint32_t low = 0, high = track->count;
    while (high - low > 1) {
        const uint32_t middle = low + (high - low) / 2;
        if ((double)track->times[middle] <= time)
            low = middle;
        else
            high = middle;
    }
    return low;
}

void daft_rig_controls(const daft_rig_track *t, uint32_t k, uint32_t i, double out[2])
{
    const size_t width = daft_rig_width(t->channel), a = k * width + i, b = a + width;
    const double third = ((double)t->times[k + 1] - (double)t->times[k]) / 3;
    const float *leaving = t->tangents + (2 * (size_t)k + 1) * width, *arriving = leaving + width;
    out[0] = (double)t->values[a] + third * (double)leaving[i];
    out[1] = (double)t->values[b] - third * (double)arriving[i];
}

/* By the Bezier form of Hermite's spline; t: 0..1 from key k to the next. */
static void spline(const daft_rig_track *track, uint32_t k, double t, double out[4])
{
    const uint32_t width = daft_rig_width(track->channel);
    const double u = 1 - t;
    double length = 0;
    for (uint32_t i = 0; i < width; i++) {
        const double a = (double)track->values[(size_t)k * width + i],
                     b = (double)track->values[((size_t)k + 1) * width + i];
        double c[2];
        daft_rig_controls(track, k, i, c);
        out[i] = u * u * u * a + 3 * u * t * (u * c[0] + t * c[1]) + t * t * t * b;
        length += out[i] * out[i];
    }
    length = sqrt(length);
    for (uint32_t i = 0; i < width && track->channel == DAFT_RIG_ROTATION; i++)
        out[i] = length > 0 ? out[i] / length : i == 3;
}

static void sample(const daft_rig_track *track, double time, double out[4])
{
    const uint32_t at = key_before(track, time);
    const uint32_t next = at + 1 < track->count && track->between != DAFT_RIG_STEP ? at + 1 : at;
    const int width = (int)daft_rig_width(track->channel);
    const double from = (double)track->times[at], to = (double)track->times[next];
    double a[4], b[4], t = to > from ? (time - from) / (to - from) : 0;
    t = t < 0 ? 0 : t > 1 ? 1 : t;
    if (track->between == DAFT_RIG_CUBIC && next > at) {
        spline(track, at, t, out);
        return;
    }
    for (int i = 0; i < width; i++) {
        a[i] = (double)track->values[(size_t)at * (size_t)width + (size_t)i];
        b[i] = (double)track->values[(size_t)next * (size_t)width + (size_t)i];
    }
    if (track->channel == DAFT_RIG_ROTATION)
        slerp(a, b, t, out);
    else
        mix(a, b, t, width, out);
}

/* ---- layers ---- */

static void sample_layer(const daft_rig *rig, const daft_rig_layer *layer, daft_rig_space *s)
{
    const daft_rig_clip *clip = &rig->clips[layer->clip];
    for (uint32_t i = 0; i < rig->node_count; i++) s->layer[i].moved = false;
    for (uint32_t i = 0; i < rig->target_count; i++) s->touched[i] = false;
    for (uint32_t i = 0; i < clip->track_count; i++) {
        const daft_rig_track *track = &clip->tracks[i];
        double value[4];
        sample(track, layer->time, value);
        if (track->channel == DAFT_RIG_WEIGHT) {
            s->layered[track->of] = value[0], s->touched[track->of] = true;
            continue;
        }
        daft_rig_local *to = &s->layer[track->of];
        if (!to->moved) to->parts = rig->nodes[track->of].parts, to->moved = true;
        if (track->channel == DAFT_RIG_POSITION) memcpy(to->parts.position, value, sizeof to->parts.position);
        if (track->channel == DAFT_RIG_ROTATION) memcpy(to->parts.rotation, value, sizeof to->parts.rotation);
        if (track->channel == DAFT_RIG_SCALE) memcpy(to->parts.scale, value, sizeof to->parts.scale);
    }
}

/* What the layer does not move it draws to rest. */
static void add_layer(const daft_rig *rig, double weight, daft_rig_space *s)
{
    for (uint32_t i = 0; i < rig->node_count; i++) {
        daft_rig_local *to = &s->local[i];
        const daft_rig_local *from = &s->layer[i];
        if (!to->moved && !from->moved) continue;
        const daft_rig_parts a = to->moved ? to->parts : rig->nodes[i].parts,
                             b = from->moved ? from->parts : rig->nodes[i].parts;
        mix(a.position, b.position, weight, 3, to->parts.position);
        mix(a.scale, b.scale, weight, 3, to->parts.scale);
        slerp(a.rotation, b.rotation, weight, to->parts.rotation);
        to->moved = true;
    }
    for (uint32_t i = 0; i < rig->target_count; i++) {
        const double other = s->touched[i] ? s->layered[i] : (double)rig->targets[i].rest;
        s->weights[i] += (other - s->weights[i]) * weight;
    }
}

static void matrix_of(const daft_rig_parts *p, double m[12])
{
    const double x = p->rotation[0], y = p->rotation[1], z = p->rotation[2], w = p->rotation[3];
    const double turn[9] = {1 - 2 * (y * y + z * z), 2 * (x * y - z * w),     2 * (x * z + y * w),
                            2 * (x * y + z * w),     1 - 2 * (x * x + z * z), 2 * (y * z - x * w),
                            2 * (x * z - y * w),     2 * (y * z + x * w),     1 - 2 * (x * x + y * y)};
    for (int row = 0; row < 3; row++) {
        for (int k = 0; k < 3; k++) m[4 * row + k] = turn[3 * row + k] * p->scale[k];
        m[4 * row + 3] = p->position[row];
    }
}

void daft_rig_pose(const daft_rig *rig, const daft_rig_layer *layers, uint32_t count, daft_rig_space *s)
{
    for (uint32_t i = 0; i < rig->node_count; i++) s->local[i].moved = false;
    for (uint32_t i = 0; i < rig->target_count; i++) s->weights[i] = (double)rig->targets[i].rest;
    for (uint32_t i = 0; i < count; i++) {
        sample_layer(rig, &layers[i], s);
        add_layer(rig, i == 0 ? 1 : layers[i].weight, s);
    }
    for (uint32_t i = 0; i < rig->node_count; i++) {
        const daft_rig_node *node = &rig->nodes[i];
        double own[12];
        if (s->local[i].moved)
            matrix_of(&s->local[i].parts, own);
        else
            memcpy(own, node->rest, sizeof own);
        if (node->parent == DAFT_RIG_NONE)
            memcpy(s->world + 12 * (size_t)i, own, sizeof own);
        else
            daft_rig_multiply(s->world + 12 * (size_t)node->parent, own, s->world + 12 * (size_t)i);
    }
    for (uint32_t i = 0; i < rig->joint_count; i++)
        daft_rig_multiply(s->world + 12 * (size_t)rig->joints[i].node, rig->joints[i].offset,
                          s->joints + 12 * (size_t)i);
}

const double *daft_rig_joint_matrix(const daft_rig_space *space, uint32_t joint)
{
    return space->joints + 12 * (size_t)joint;
}

/* ---- vertices ---- */

static void shift_all(daft_rig_points *to, const daft_rig_shift *shifts, uint32_t count, float weight)
{
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t p = shifts[i].point;
        to->x[p] += weight * shifts[i].by.x, to->y[p] += weight * shifts[i].by.y, to->z[p] += weight * shifts[i].by.z;
    }
}

/* The points with the targets added, in the space's own memory; those of the rig where no target has any weight. */
static const daft_rig_points *add_targets(const daft_rig *rig, daft_rig_space *s, int which)
{
    const daft_rig_points *from = which ? &rig->normals : &rig->vertices;
    bool any = false;
    for (uint32_t i = 0; i < rig->target_count; i++) any = any || s->weights[i] != 0;
    if (!any) return from;
    daft_rig_points *to = &s->shifted[which];
    memcpy(to->x, from->x, from->count * sizeof(float)), memcpy(to->y, from->y, from->count * sizeof(float));
    memcpy(to->z, from->z, from->count * sizeof(float));
    for (uint32_t i = 0; i < rig->target_count; i++) {
        const daft_rig_target *target = &rig->targets[i];
        if (s->weights[i] == 0) continue;
        shift_all(to, which ? target->normals : target->vertices, which ? target->normal_count : target->vertex_count,
                  (float)s->weights[i]);
    }
    return to;
}

/* Larger numbers than floats hold become the largest. */
static float rounded(double x) { return (float)(x > 3e38 ? 3e38 : x < -3e38 ? -3e38 : x == x ? x : 0); }

void daft_rig_skin(const daft_rig *rig, daft_rig_space *s, int isa, daft_trimesh *mesh)
{
    static const daft_rig_kernels *const TABLE[DAFT_ISA_COUNT] = DAFT_KERNEL_TABLE(daft_rig);
    for (size_t i = 0; i < 12 * (size_t)rig->joint_count; i++) s->matrices[i] = rounded(s->joints[i]);
    TABLE[isa]->vertices(add_targets(rig, s, 0), s->matrices, mesh->x, mesh->y, mesh->z);
    TABLE[isa]->normals(add_targets(rig, s, 1), s->matrices, mesh->normals);
    daft_trimesh_set_bounds(mesh);
}
