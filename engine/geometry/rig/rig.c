/* A rig's memory, and the working memory of poses. */
#include "geometry/rig/skin.h"

static void points_free(const daft_allocator *allocator, daft_rig_points *points)
{
    daft_release(allocator, points->x), daft_release(allocator, points->y), daft_release(allocator, points->z);
    for (int k = 0; k < DAFT_RIG_WEIGHTS; k++) {
        daft_release(allocator, points->joints[k]);
        daft_release(allocator, points->weights[k]);
    }
    daft_release(allocator, points->most);
}

static void clip_free(const daft_allocator *allocator, daft_rig_clip *clip)
{
    for (uint32_t i = 0; i < clip->track_count; i++) {
        daft_release(allocator, clip->tracks[i].times);
        daft_release(allocator, clip->tracks[i].values);
        daft_release(allocator, clip->tracks[i].tangents);
    }
    daft_release(allocator, clip->tracks);
    daft_release(allocator, clip->name);
}

void daft_rig_free(const daft_allocator *allocator, daft_rig *rig)
{
    if (!rig) return;
    for (uint32_t i = 0; i < rig->clip_count; i++) clip_free(allocator, &rig->clips[i]);
    for (uint32_t i = 0; i < rig->target_count; i++) {
        daft_release(allocator, rig->targets[i].vertices);
        daft_release(allocator, rig->targets[i].normals);
    }
    points_free(allocator, &rig->vertices);
    points_free(allocator, &rig->normals);
    daft_release(allocator, rig->nodes), daft_release(allocator, rig->joints);
    daft_release(allocator, rig->targets), daft_release(allocator, rig->clips);
    daft_release(allocator, rig);
}

static size_t padded(size_t count) { return (count + DAFT_RIG_BLOCK - 1) / DAFT_RIG_BLOCK * DAFT_RIG_BLOCK; }

static size_t points_bytes(const daft_rig_points *points)
{
    const size_t room = padded(points->count);
    return room * (3 * sizeof(float) + DAFT_RIG_WEIGHTS * (sizeof(int32_t) + sizeof(float))) + room / DAFT_RIG_BLOCK;
}

size_t daft_rig_bytes(const daft_rig *rig)
{
    size_t bytes = sizeof *rig + rig->node_count * sizeof *rig->nodes + rig->joint_count * sizeof *rig->joints +
                   rig->target_count * sizeof *rig->targets + rig->clip_count * sizeof *rig->clips +
                   points_bytes(&rig->vertices) + points_bytes(&rig->normals);
    for (uint32_t i = 0; i < rig->target_count; i++)
        bytes += ((size_t)rig->targets[i].vertex_count + rig->targets[i].normal_count) * sizeof(daft_rig_shift);
    for (uint32_t i = 0; i < rig->clip_count; i++)
        for (uint32_t k = 0; k < rig->clips[i].track_count; k++) {
            const daft_rig_track *t = &rig->clips[i].tracks[k];
            const size_t values = t->tangents ? 3 : 1;
            bytes += sizeof *t + (size_t)t->count * (1 + values * daft_rig_width(t->channel)) * sizeof(float);
        }
    return bytes;
}

static bool floats_make(const daft_allocator *allocator, daft_rig_points *points, size_t room)
{
    points->x = daft_alloc_zero(allocator, room, sizeof(float));
    points->y = daft_alloc_zero(allocator, room, sizeof(float));
    points->z = daft_alloc_zero(allocator, room, sizeof(float));
    return points->x && points->y && points->z;
}

bool daft_rig_points_make(const daft_allocator *allocator, daft_rig_points *points, uint32_t count)
{
    const size_t room = count ? padded(count) : DAFT_RIG_BLOCK;
    points->count = count;
    bool done = floats_make(allocator, points, room);
    for (int k = 0; k < DAFT_RIG_WEIGHTS; k++) {
        points->joints[k] = daft_alloc_zero(allocator, room, sizeof(int32_t));
        points->weights[k] = daft_alloc_zero(allocator, room, sizeof(float));
        done = done && points->joints[k] && points->weights[k];
    }
    points->most = daft_alloc_zero(allocator, room / DAFT_RIG_BLOCK, 1);
    return done && points->most;
}

void daft_rig_points_measure(daft_rig_points *points)
{
    for (uint32_t i = 0; i < points->count; i++)
        for (uint32_t k = 0; k < DAFT_RIG_WEIGHTS; k++) {
            uint8_t *most = &points->most[i / DAFT_RIG_BLOCK];
            if (points->weights[k][i] > 0 && *most < k + 1) *most = (uint8_t)(k + 1);
        }
}

/* ---- spaces ---- */

/* The joints and weights are the rig's. */
static bool shifted_make(const daft_allocator *allocator, const daft_rig_points *from, daft_rig_points *out)
{
    *out = *from;
    out->x = out->y = out->z = NULL;
    return floats_make(allocator, out, from->count ? padded(from->count) : DAFT_RIG_BLOCK);
}

daft_rig_space *daft_rig_space_make(const daft_allocator *allocator, const daft_rig *rig, daft_error *error)
{
    daft_rig_space *s = daft_alloc_zero(allocator, 1, sizeof *s);
    bool done = s != NULL;
    if (done) {
        s->allocator = *allocator;
        s->local = daft_alloc_zero(allocator, rig->node_count, sizeof *s->local);
        s->layer = daft_alloc_zero(allocator, rig->node_count, sizeof *s->layer);
        s->world = daft_alloc_zero(allocator, rig->node_count, 12 * sizeof(double));
        s->joints = daft_alloc_zero(allocator, rig->joint_count, 12 * sizeof(double));
        s->matrices = daft_alloc_zero(allocator, rig->joint_count, 12 * sizeof(float));
        s->weights = daft_alloc_zero(allocator, (size_t)rig->target_count + 1, sizeof(double));
        s->layered = daft_alloc_zero(allocator, (size_t)rig->target_count + 1, sizeof(double));
        s->touched = daft_alloc_zero(allocator, (size_t)rig->target_count + 1, sizeof(bool));
        done = s->local && s->layer && s->world && s->joints && s->matrices && s->weights && s->layered && s->touched;
    }
    if (done && rig->target_count)
        done = shifted_make(allocator, &rig->vertices, &s->shifted[0]) &&
               shifted_make(allocator, &rig->normals, &s->shifted[1]);
    if (done) return s;
    daft_rig_space_free(s);
    daft_fail_memory(error, "a pose");
    return NULL;
}

void daft_rig_space_free(daft_rig_space *s)
{
    if (!s) return;
    const daft_allocator allocator = s->allocator;
    void *gone[] = {s->local,        s->layer,        s->world,        s->joints,       s->matrices,
                    s->weights,      s->layered,      s->touched,      s->shifted[0].x, s->shifted[0].y,
                    s->shifted[0].z, s->shifted[1].x, s->shifted[1].y, s->shifted[1].z};
    for (size_t i = 0; i < DAFT_COUNT_OF(gone); i++) daft_release(&allocator, gone[i]);
    daft_release(&allocator, s);
}
