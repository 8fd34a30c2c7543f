/* From nodes, bones and morph targets to a rig. Without clips there is none: skins stand as the file has them. */
#include "geometry/foreign/assimp.h"

#include "math/simd/dispatch.h"

#include <string.h>

typedef daft_flattener flattener;
typedef daft_foreign_binding binding;

static const double AS_IT_IS[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

/* ---- nodes ---- */

static bool channel_moves(const flattener *f, const struct aiNodeAnim *channel)
{
    return channel->mNumPositionKeys + channel->mNumRotationKeys + channel->mNumScalingKeys > 0 &&
           daft_foreign_nodes_find(&f->nodes, channel->mNodeName.data) != DAFT_RIG_NONE;
}

static bool anything_moves(const flattener *f)
{
    const struct aiScene *scene = f->from->scene;
    for (uint32_t i = 0; i < scene->mNumAnimations; i++) {
        const struct aiAnimation *a = scene->mAnimations[i];
        for (uint32_t k = 0; k < a->mNumChannels; k++)
            if (channel_moves(f, a->mChannels[k])) return true;
        for (uint32_t k = 0; k < a->mNumMorphMeshChannels; k++)
            if (a->mMorphMeshChannels[k]->mNumKeys > 0) return true;
    }
    return false;
}

/* Shepperd, "Quaternion from Rotation Matrix", 1978. `m`: three rows of three, a rotation. */
static void quaternion_of(const double m[9], double q[4])
{
    const double trace = m[0] + m[4] + m[8];
    int i = m[0] > m[4] ? 0 : 1;
    if (m[8] > m[4 * i]) i = 2;
    if (trace > m[4 * i]) {
        const double s = sqrt(trace + 1) * 2;
        q[0] = (m[7] - m[5]) / s, q[1] = (m[2] - m[6]) / s, q[2] = (m[3] - m[1]) / s, q[3] = s / 4;
        return;
    }
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    const double s = sqrt(1 + m[4 * i] - m[4 * j] - m[4 * k]) * 2;
    q[i] = s / 4, q[j] = (m[3 * j + i] + m[3 * i + j]) / s, q[k] = (m[3 * k + i] + m[3 * i + k]) / s;
    q[3] = (m[3 * k + j] - m[3 * j + k]) / s;
}

/* Columns are lengthened axes; those of a mirroring one are turned by a negative scale. Without three axes that differ
 * there is no rotation. */
static daft_rig_parts parts_of(const double m[12])
{
    daft_rig_parts p = {.position = {m[3], m[7], m[11]}, .rotation = {0, 0, 0, 1}};
    const double determinant = daft_foreign_determinant(m);
    double turn[9], length = 0;
    bool good = determinant != 0;
    for (int k = 0; k < 3; k++) {
        p.scale[k] = sqrt(m[k] * m[k] + m[4 + k] * m[4 + k] + m[8 + k] * m[8 + k]);
        if (k == 0 && determinant < 0) p.scale[k] = -p.scale[k];
        good = good && isfinite(1 / p.scale[k]);
    }
    if (!good) return p;
    for (int i = 0; i < 9; i++) turn[i] = m[4 * (i / 3) + i % 3] / p.scale[i % 3];
    quaternion_of(turn, p.rotation);
    for (int i = 0; i < 4; i++) length += p.rotation[i] * p.rotation[i];
    for (int i = 0; i < 4; i++) p.rotation[i] = length > 0 && isfinite(length) ? p.rotation[i] / sqrt(length) : i == 3;
    return p;
}

bool daft_foreign_rig_begin(flattener *f)
{
    const daft_allocator *allocator = f->from->allocator;
    if (!anything_moves(f)) return true;
    f->rig = daft_alloc_zero(allocator, 1, sizeof *f->rig);
    if (f->rig) f->rig->nodes = daft_alloc(allocator, f->nodes.count, sizeof *f->rig->nodes);
    if (!f->rig || !f->rig->nodes) return daft_fail_memory(f->from->error, "a model's nodes");
    f->rig->node_count = f->nodes.count;
    for (uint32_t i = 0; i < f->nodes.count; i++) {
        daft_rig_node *node = &f->rig->nodes[i];
        node->parent = f->nodes.items[i].parent;
        memcpy(node->rest, f->nodes.items[i].own, sizeof node->rest);
        node->parts = parts_of(node->rest);
    }
    return true;
}

/* ---- what carries vertices ---- */

static bool add_joint(flattener *f, uint32_t node, const double offset[12])
{
    daft_rig *rig = f->rig;
    if (rig->joint_count >= INT32_MAX / 12 ||
        !daft_grow(f->from->allocator, &rig->joints, &f->joint_capacity, (size_t)rig->joint_count + 1, rig->joint_count,
                   sizeof *rig->joints))
        return daft_fail_memory(f->from->error, "a model's joints");
    daft_rig_joint *joint = &rig->joints[rig->joint_count++];
    joint->node = node;
    memcpy(joint->offset, offset, sizeof joint->offset);
    return true;
}

/* Keeps the largest four, the largest first; of equal ones the first. */
static void add_weight(binding *b, int32_t joint, float weight)
{
    int at = DAFT_RIG_WEIGHTS;
    while (at > 0 && b->weight[at - 1] < weight) at--;
    for (int k = DAFT_RIG_WEIGHTS - 1; k > at; k--) b->weight[k] = b->weight[k - 1], b->joint[k] = b->joint[k - 1];
    if (at < DAFT_RIG_WEIGHTS) b->weight[at] = weight, b->joint[at] = joint;
}

static bool bind_bone(flattener *f, const struct aiMesh *mesh, const struct aiBone *bone)
{
    const uint32_t node = daft_foreign_nodes_find(&f->nodes, bone->mName.data);
    double offset[12];
    if (node == DAFT_RIG_NONE) return true;
    if (!daft_foreign_matrix(&bone->mOffsetMatrix, offset))
        daft_warn_at(f->from->log, DAFT_ERROR_SYNTAX, f->from->path, 0, 0,
                     "the bone '%.100s' has an inverse bind matrix that is not finite: it counts as none",
                     bone->mName.data);
    if (!add_joint(f, node, offset)) return false;
    for (uint32_t k = 0; k < bone->mNumWeights; k++) {
        const struct aiVertexWeight *w = &bone->mWeights[k];
        const bool good = w->mVertexId < mesh->mNumVertices && isfinite(w->mWeight) && w->mWeight >= 0;
        f->bad_weights += !good;
        if (good && w->mWeight > 0)
            add_weight(&f->bindings[f->count + w->mVertexId], (int32_t)f->rig->joint_count - 1, w->mWeight);
    }
    return true;
}

/* Those that no bone holds hang on the node. */
static void normalise(binding *b, int32_t node_joint)
{
    double sum = 0;
    for (int k = 0; k < DAFT_RIG_WEIGHTS; k++) sum += (double)b->weight[k];
    for (int k = 0; k < DAFT_RIG_WEIGHTS; k++) {
        b->weight[k] = sum > 0 ? (float)((double)b->weight[k] / sum) : k == 0;
        if (!(b->weight[k] > 0)) b->joint[k] = 0;
    }
    if (!(sum > 0)) b->joint[0] = node_joint;
}

bool daft_foreign_rig_bind(flattener *f, const struct aiMesh *mesh, uint32_t node)
{
    const int32_t own = (int32_t)f->rig->joint_count;
    const bool turned = daft_foreign_determinant(f->nodes.items[node].m) < 0 && !mesh->mNumBones;
    if (!add_joint(f, node, AS_IT_IS)) return false;
    for (uint32_t i = 0; i < mesh->mNumBones; i++)
        if (!bind_bone(f, mesh, mesh->mBones[i])) return false;
    for (uint32_t i = 0; i < mesh->mNumVertices; i++) {
        binding *b = &f->bindings[f->count + i];
        normalise(b, own);
        b->turned = turned, b->vertex = i;
        b->shaped = mesh->mNumAnimMeshes ? mesh : NULL;
    }
    return true;
}

static bool same(struct aiVector3D a, struct aiVector3D b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

bool daft_foreign_rig_alike(const flattener *f, uint32_t a, uint32_t b)
{
    const binding *p = &f->bindings[a], *q = &f->bindings[b];
    if (memcmp(p->joint, q->joint, sizeof p->joint) != 0 || p->turned != q->turned || p->shaped != q->shaped)
        return false;
    for (int k = 0; k < DAFT_RIG_WEIGHTS; k++)
        if (p->weight[k] != q->weight[k]) return false;
    for (uint32_t i = 0; p->shaped && i < p->shaped->mNumAnimMeshes; i++) {
        const struct aiAnimMesh *m = p->shaped->mAnimMeshes[i];
        if (m->mVertices && m->mNumVertices == p->shaped->mNumVertices &&
            !same(m->mVertices[p->vertex], m->mVertices[q->vertex]))
            return false;
    }
    return true;
}

/* ---- points ---- */

static void put_point(daft_rig_points *points, uint32_t at, daft_vec3 p, const binding *b)
{
    points->x[at] = p.x, points->y[at] = p.y, points->z[at] = p.z;
    for (int k = 0; k < DAFT_RIG_WEIGHTS; k++)
        points->joints[k][at] = b->joint[k], points->weights[k][at] = b->weight[k];
}

static daft_vec3 finite_or_zero(daft_vec3 p) { return daft_finite3(p) ? p : daft_v3(0, 0, 0); }

/* Normals of the file, or those that were computed of the triangles in the vertices' own axes, where those of mirrored
 * parts have been turned. */
static void put_normals(const flattener *f, const uint32_t *source)
{
    const daft_trimesh *m = &f->mesh;
    for (uint32_t i = 0; !f->bare && i < f->count; i++) put_point(&f->rig->normals, i, m->normals[i], &f->bindings[i]);
    const uint32_t *numbers = m->normal_indices ? m->normal_indices : m->indices;
    for (size_t i = 0; f->bare && i < 3 * (size_t)m->triangle_count; i++) {
        const binding *b = &f->bindings[source[m->indices[i]]];
        const daft_vec3 n = m->normals[numbers[i]];
        put_point(&f->rig->normals, numbers[i], b->turned ? daft_neg(n) : n, b);
    }
}

/* source: of each vertex the first of those that have become one with it. */
static bool put_points(const flattener *f, const uint32_t *source)
{
    const daft_allocator *allocator = f->from->allocator;
    daft_rig *rig = f->rig;
    if (!daft_rig_points_make(allocator, &rig->vertices, f->mesh.vertex_count) ||
        !daft_rig_points_make(allocator, &rig->normals, f->mesh.normal_count))
        return false;
    for (uint32_t v = 0; v < f->mesh.vertex_count; v++)
        put_point(&rig->vertices, v, finite_or_zero(f->positions[source[v]]), &f->bindings[source[v]]);
    put_normals(f, source);
    daft_rig_points_measure(&rig->vertices), daft_rig_points_measure(&rig->normals);
    return true;
}

/* ---- morph targets ---- */

/* What moves by how much; written where `out` is there. Returns how many. */
static uint32_t find_shifts(const struct aiVector3D *from, const struct aiVector3D *to, uint32_t count,
                            const uint32_t *number, const uint32_t *source, uint32_t first, daft_rig_shift *out)
{
    uint32_t found = 0;
    for (uint32_t i = 0; i < count; i++) {
        const daft_vec3 by = daft_v3(to[i].x - from[i].x, to[i].y - from[i].y, to[i].z - from[i].z);
        const uint32_t point = number ? number[first + i] : first + i;
        if (!daft_finite3(by) || (by.x == 0 && by.y == 0 && by.z == 0)) continue;
        if (number && source[point] != first + i) continue; /* another one of that place has it */
        if (out) out[found] = (daft_rig_shift){point, by};
        found++;
    }
    return found;
}

static bool put_shifts(const flattener *f, const struct aiVector3D *from, const struct aiVector3D *to,
                       uint32_t vertices, const uint32_t *number, const uint32_t *source, uint32_t first,
                       daft_rig_shift **out, uint32_t *count)
{
    if (!from || !to) return true;
    *count = find_shifts(from, to, vertices, number, source, first, NULL);
    *out = daft_alloc(f->from->allocator, (size_t)*count + 1, sizeof **out);
    if (!*out) return false;
    find_shifts(from, to, vertices, number, source, first, *out);
    return true;
}

/* Assimp gives a shape of an FBX file that is alone in its channel a weight of 1, whatever the file says. */
static bool put_target(flattener *f, const struct aiMesh *mesh, const struct aiAnimMesh *shape, const uint32_t *source,
                       uint32_t first)
{
    daft_rig *rig = f->rig;
    if (!daft_grow(f->from->allocator, &rig->targets, &f->target_capacity, (size_t)rig->target_count + 1,
                   rig->target_count, sizeof *rig->targets))
        return false;
    daft_rig_target *t = &rig->targets[rig->target_count++];
    *t = (daft_rig_target){0};
    if (shape->mNumVertices != mesh->mNumVertices) return true;
    t->rest = isfinite(shape->mWeight) && strcmp(f->from->format, "fbx") != 0 ? shape->mWeight : 0;
    return put_shifts(f, mesh->mVertices, shape->mVertices, mesh->mNumVertices, f->number, source, first, &t->vertices,
                      &t->vertex_count) &&
           (f->bare || put_shifts(f, mesh->mNormals, shape->mNormals, mesh->mNumVertices, NULL, source, first,
                                  &t->normals, &t->normal_count));
}

/* In the order in which vertices were put: by node, mesh, target. */
static bool put_targets(flattener *f, const uint32_t *source)
{
    uint32_t first = 0;
    for (uint32_t i = 0; i < f->nodes.count; i++) {
        const struct aiNode *node = f->nodes.items[i].node;
        for (uint32_t k = 0; k < node->mNumMeshes; k++) {
            const struct aiMesh *mesh = f->from->scene->mMeshes[node->mMeshes[k]];
            for (uint32_t t = 0; t < mesh->mNumAnimMeshes; t++)
                if (!put_target(f, mesh, mesh->mAnimMeshes[t], source, first)) return false;
            first += mesh->mNumVertices;
        }
    }
    return true;
}

/* ---- the whole ---- */

static bool stand(flattener *f)
{
    daft_rig_space *space = daft_rig_space_make(f->from->allocator, f->rig, f->from->error);
    if (!space) return false;
    daft_rig_pose(f->rig, NULL, 0, space);
    daft_rig_skin(f->rig, space, daft_isa_best(), &f->mesh);
    daft_rig_space_free(space);
    return true;
}

bool daft_foreign_rig_end(flattener *f)
{
    const daft_allocator *allocator = f->from->allocator;
    uint32_t *source = daft_alloc(allocator, (size_t)f->mesh.vertex_count + 1, sizeof *source);
    for (uint32_t i = f->count; source && i-- > 0;) source[f->number[i]] = i;
    bool good = (source && put_points(f, source) && put_targets(f, source)) ||
                daft_fail_memory(f->from->error, "what moves a model");
    daft_release(allocator, source);
    if (good && f->bad_weights > 0)
        daft_warn_at(f->from->log, DAFT_ERROR_SYNTAX, f->from->path, 0, 0,
                     "%u weights of skins are no numbers of 0 or more, or of no vertex: they count as 0",
                     f->bad_weights);
    return good && daft_foreign_clips(f) && daft_rig_bound(allocator, f->rig, f->from->error) && stand(f);
}
