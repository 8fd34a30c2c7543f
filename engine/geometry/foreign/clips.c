/* From a file's animations to clips. Times become seconds; keys that are no numbers, or before the one before, are left
 * out. */
#include "geometry/foreign/assimp.h"

#include <stdio.h>
#include <string.h>

#define LONGEST 1e6 /* seconds: floats tell frames apart up to there */

typedef struct maker {
    daft_flattener *f;
    const struct aiAnimation *from;
    uint32_t number; /* of the clip in a glTF file; UINT32_MAX: it is linear all over */
    daft_rig_clip *clip;
    size_t capacity;
    double second; /* ticks */
    uint32_t left_out;
    bool straight; /* some cubic spline could not be read */
} maker;

/* ---- a track ---- */

/* Room for `keys`, none of them there yet. NULL: memory is out. */
static daft_rig_track *track_begin(maker *m, daft_rig_channel channel, uint32_t of, uint32_t keys)
{
    const daft_allocator *allocator = m->f->from->allocator;
    daft_rig_clip *clip = m->clip;
    if (!daft_grow(allocator, &clip->tracks, &m->capacity, (size_t)clip->track_count + 1, clip->track_count,
                   sizeof *clip->tracks))
        return NULL;
    daft_rig_track *t = &clip->tracks[clip->track_count++];
    *t = (daft_rig_track){.channel = channel, .of = of};
    t->times = daft_alloc(allocator, keys, sizeof *t->times);
    t->values = daft_alloc(allocator, keys, daft_rig_width(channel) * sizeof *t->values);
    return t->times && t->values ? t : NULL;
}

static bool make_unit(double v[4])
{
    const double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2] + v[3] * v[3]);
    for (int i = 0; i < 4; i++) v[i] /= length;
    return length > 0 && isfinite(length);
}

static void add_key(maker *m, daft_rig_track *t, double seconds, const double value[4])
{
    const uint32_t width = daft_rig_width(t->channel);
    const float time = (float)seconds;
    double v[4] = {0};
    bool good = time >= 0 && (double)time <= LONGEST && (t->count == 0 || time >= t->times[t->count - 1]);
    memcpy(v, value, width * sizeof *v);
    if (t->channel == DAFT_RIG_ROTATION) good = good && make_unit(v);
    for (uint32_t i = 0; i < width; i++) good = good && fabs(v[i]) <= 1e30;
    m->left_out += !good;
    if (!good) return;
    t->times[t->count] = time;
    for (uint32_t i = 0; i < width; i++) t->values[(size_t)t->count * width + i] = (float)v[i];
    t->count++;
}

/* A track without keys goes. */
static void track_end(maker *m)
{
    const daft_allocator *allocator = m->f->from->allocator;
    daft_rig_clip *clip = m->clip;
    const daft_rig_track *t = &clip->tracks[clip->track_count - 1];
    if (t->count > 0) {
        clip->duration = fmax(clip->duration, (double)t->times[t->count - 1]);
        return;
    }
    daft_release(allocator, t->times), daft_release(allocator, t->values), daft_release(allocator, t->tangents);
    clip->track_count--;
}

/* ---- between keys, which Assimp does not tell ---- */

/* A track of a cubic spline from the file itself. Its output has for each key `row` numbers three times: of arriving at
 * it, of the key, of leaving it; those of the track begin at `first`. */
static bool put_spline(maker *m, daft_rig_channel channel, uint32_t of, const float *times, uint32_t count,
                       const float *rows, size_t row, size_t first)
{
    const size_t width = daft_rig_width(channel);
    daft_rig_track *t = track_begin(m, channel, of, count);
    if (t) t->tangents = daft_alloc(m->f->from->allocator, count, 2 * width * sizeof *t->tangents);
    if (!t || !t->tangents) return false;
    t->between = DAFT_RIG_CUBIC;
    for (uint32_t i = 0; i < count; i++) {
        const float *arriving = rows + 3 * row * i + first, *value = arriving + row, *leaving = value + row;
        float *to = t->tangents + 2 * width * t->count;
        double v[4] = {0};
        bool good = true;
        for (size_t k = 0; k < width; k++) {
            v[k] = (double)value[k], to[k] = arriving[k], to[width + k] = leaving[k];
            good = good && fabsf(arriving[k]) <= 1e30f && fabsf(leaving[k]) <= 1e30f;
        }
        if (good)
            add_key(m, t, (double)times[i], v);
        else
            m->left_out++;
    }
    track_end(m);
    return true;
}

/* *done: the track is there. `part`: which of the targets, of weights. False: memory is out. */
static bool put_cubic(maker *m, daft_json sampler, daft_rig_channel channel, uint32_t of, size_t part, bool *done)
{
    size_t count = 0, numbers = 0;
    daft_gltf *gltf = &m->f->gltf;
    *done = false;
    if (!daft_json_is(daft_json_member(sampler, "interpolation"), "CUBICSPLINE")) return true;
    const float *times = daft_gltf_floats(gltf, daft_json_member(sampler, "input"), &count),
                *rows = daft_gltf_floats(gltf, daft_json_member(sampler, "output"), &numbers);
    const size_t width = daft_rig_width(channel), row = times && rows && count ? numbers / 3 / count : 0;
    *done = row >= width * (part + 1) && numbers == 3 * row * count && count <= UINT32_MAX;
    m->straight |= !*done;
    if (gltf->out_of_memory) return *done = false;
    if (*done && !put_spline(m, channel, of, times, (uint32_t)count, rows, row, width * part)) return *done = false;
    return true;
}

static daft_rig_between between_of(daft_json sampler)
{
    return daft_json_is(daft_json_member(sampler, "interpolation"), "STEP") ? DAFT_RIG_STEP : DAFT_RIG_LINEAR;
}

/* ---- what the file has ---- */

static bool put_vectors(maker *m, daft_rig_channel channel, uint32_t node, const struct aiVectorKey *keys,
                        uint32_t count)
{
    const daft_json sampler =
        daft_gltf_sampler(&m->f->gltf, m->number, node, channel == DAFT_RIG_SCALE ? "scale" : "translation");
    bool done;
    if (!put_cubic(m, sampler, channel, node, 0, &done) || done) return done;
    daft_rig_track *t = count ? track_begin(m, channel, node, count) : NULL;
    if (!t) return count == 0;
    t->between = between_of(sampler);
    for (uint32_t i = 0; i < count; i++) {
        const struct aiVector3D v = keys[i].mValue;
        add_key(m, t, keys[i].mTime / m->second, (double[4]){(double)v.x, (double)v.y, (double)v.z});
    }
    track_end(m);
    return true;
}

static bool put_rotations(maker *m, uint32_t node, const struct aiQuatKey *keys, uint32_t count)
{
    const daft_json sampler = daft_gltf_sampler(&m->f->gltf, m->number, node, "rotation");
    bool done;
    if (!put_cubic(m, sampler, DAFT_RIG_ROTATION, node, 0, &done) || done) return done;
    daft_rig_track *t = count ? track_begin(m, DAFT_RIG_ROTATION, node, count) : NULL;
    if (!t) return count == 0;
    t->between = between_of(sampler);
    for (uint32_t i = 0; i < count; i++) {
        const struct aiQuaternion q = keys[i].mValue;
        add_key(m, t, keys[i].mTime / m->second, (double[4]){(double)q.x, (double)q.y, (double)q.z, (double)q.w});
    }
    track_end(m);
    return true;
}

static bool put_channel(maker *m, const struct aiNodeAnim *channel)
{
    const uint32_t node = daft_foreign_nodes_find(&m->f->nodes, channel->mNodeName.data);
    if (node == DAFT_RIG_NONE) return true;
    return put_vectors(m, DAFT_RIG_POSITION, node, channel->mPositionKeys, channel->mNumPositionKeys) &&
           put_rotations(m, node, channel->mRotationKeys, channel->mNumRotationKeys) &&
           put_vectors(m, DAFT_RIG_SCALE, node, channel->mScalingKeys, channel->mNumScalingKeys);
}

static const double *find_weight(const struct aiMeshMorphKey *key, uint32_t shape)
{
    if (!key->mValues || !key->mWeights) return NULL;
    if (shape < key->mNumValuesAndWeights && key->mValues[shape] == shape) return &key->mWeights[shape];
    for (uint32_t i = 0; i < key->mNumValuesAndWeights; i++)
        if (key->mValues[i] == shape) return &key->mWeights[i];
    return NULL;
}

static bool put_weights(maker *m, const struct aiMeshMorphAnim *channel, daft_json sampler, uint32_t shape,
                        uint32_t target)
{
    bool done;
    if (!put_cubic(m, sampler, DAFT_RIG_WEIGHT, target, shape, &done) || done) return done;
    daft_rig_track *t = track_begin(m, DAFT_RIG_WEIGHT, target, channel->mNumKeys);
    if (!t) return false;
    t->between = between_of(sampler);
    for (uint32_t i = 0; i < channel->mNumKeys; i++) {
        const double *weight = find_weight(&channel->mKeys[i], shape);
        if (weight) add_key(m, t, channel->mKeys[i].mTime / m->second, (double[4]){*weight});
    }
    track_end(m);
    return true;
}

/* "name*3", as Assimp has it for FBX, is "name". */
static bool names_alike(const char *a, const char *b)
{
    const size_t n = strcspn(a, "*"), k = strcspn(b, "*");
    return n > 0 && n == k && memcmp(a, b, n) == 0;
}

/* Whether a channel of weights is about this mesh at this node. */
static bool is_about(const struct aiMeshMorphAnim *channel, const struct aiNode *node, const struct aiMesh *mesh)
{
    return names_alike(channel->mName.data, node->mName.data) || names_alike(channel->mName.data, mesh->mName.data);
}

/* Targets are in the order of nodes, meshes and shapes. */
static bool put_shapes(maker *m, const struct aiMeshMorphAnim *channel)
{
    const daft_flattener *f = m->f;
    uint32_t target = 0;
    for (uint32_t i = 0; channel->mNumKeys && i < f->nodes.count; i++) {
        const struct aiNode *node = f->nodes.items[i].node;
        const daft_json sampler = daft_gltf_sampler(&f->gltf, node->mNumMeshes ? m->number : UINT32_MAX, i, "weights");
        for (uint32_t k = 0; k < node->mNumMeshes; k++) {
            const struct aiMesh *mesh = f->from->scene->mMeshes[node->mMeshes[k]];
            const bool meant = mesh->mNumAnimMeshes && is_about(channel, node, mesh);
            for (uint32_t shape = 0; shape < mesh->mNumAnimMeshes; shape++, target++)
                if (meant && !put_weights(m, channel, sampler, shape, target)) return false;
        }
    }
    return true;
}

/* ---- clips ---- */

static bool put_clip(daft_flattener *f, const struct aiAnimation *from, uint32_t number, daft_rig_clip *clip)
{
    char name[160];
    /* no rate: 25 a second, as Assimp has it */
    const double rate = from->mTicksPerSecond;
    maker m = {.f = f, .from = from, .clip = clip, .second = rate > 0 && isfinite(rate) ? rate : 25};
    m.number = daft_gltf_is_linear(&f->gltf, number) ? UINT32_MAX : number;
    if (from->mName.data[0])
        snprintf(name, sizeof name, "%.120s", from->mName.data);
    else
        snprintf(name, sizeof name, "clip %u", number + 1);
    clip->name = daft_copy_string(f->from->allocator, name);
    bool good = clip->name != NULL;
    for (uint32_t i = 0; good && i < from->mNumChannels; i++) good = put_channel(&m, from->mChannels[i]);
    for (uint32_t i = 0; good && i < from->mNumMorphMeshChannels; i++)
        good = put_shapes(&m, from->mMorphMeshChannels[i]);
    if (good && m.left_out > 0)
        daft_warn_at(f->from->log, DAFT_ERROR_SYNTAX, f->from->path, 0, 0,
                     "the clip '%.100s': %u keys are left out: no numbers, or before the key before them", name,
                     m.left_out);
    if (good && m.straight)
        daft_warn_at(f->from->log, DAFT_ERROR_UNSUPPORTED, f->from->path, 0, 0,
                     "the clip '%.100s' goes straight between keys of cubic splines: they are not plain floats", name);
    return good || daft_fail_memory(f->from->error, "a model's clips");
}

bool daft_foreign_clips(daft_flattener *f)
{
    const struct aiScene *scene = f->from->scene;
    daft_rig *rig = f->rig;
    rig->clips = daft_alloc_zero(f->from->allocator, (size_t)scene->mNumAnimations + 1, sizeof *rig->clips);
    if (!rig->clips) return daft_fail_memory(f->from->error, "a model's clips");
    for (uint32_t i = 0; i < scene->mNumAnimations; i++)
        if (!put_clip(f, scene->mAnimations[i], i, &rig->clips[rig->clip_count++])) return false;
    return true;
}
