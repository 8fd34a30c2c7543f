/* From a hierarchy of meshes to one mesh. */
#include "geometry/foreign/assimp.h"

#include "geometry/trimesh.h"

#include <string.h>

enum { MOST_VERTICES = 1 << 28, MOST_SLOTS = 65535 };

typedef struct placing {
    const struct aiNode *node;
    double m[12]; /* to the scene's axes: three rows */
} placing;

typedef struct flattener {
    const daft_foreign *from;
    daft_trimesh mesh;
    placing *nodes;
    uint32_t node_count;
    daft_vec3 *positions; /* of all vertices, before those in one place become one */
    uint32_t count;
    bool bare;       /* some mesh has no normals */
    double *blended; /* 12 for each vertex of a skin */
} flattener;

/* ---- the hierarchy ---- */

static void from_assimp(const struct aiMatrix4x4 *a, double m[12])
{
    const float rows[12] = {a->a1, a->a2, a->a3, a->a4, a->b1, a->b2, a->b3, a->b4, a->c1, a->c2, a->c3, a->c4};
    for (int i = 0; i < 12; i++) m[i] = (double)rows[i];
}

static void multiply(const double a[12], const double b[12], double out[12])
{
    for (int row = 0; row < 3; row++)
        for (int k = 0; k < 4; k++)
            out[4 * row + k] = a[4 * row] * b[k] + a[4 * row + 1] * b[4 + k] + a[4 * row + 2] * b[8 + k] +
                               (k == 3 ? a[4 * row + 3] : 0);
}

static daft_vec3 move(const double m[12], struct aiVector3D v, double w)
{
    const double x = (double)v.x, y = (double)v.y, z = (double)v.z;
    return daft_v3((float)(m[0] * x + m[1] * y + m[2] * z + w * m[3]),
                   (float)(m[4] * x + m[5] * y + m[6] * z + w * m[7]),
                   (float)(m[8] * x + m[9] * y + m[10] * z + w * m[11]));
}

static double determinant(const double m[12])
{
    return m[0] * (m[5] * m[10] - m[6] * m[9]) - m[1] * (m[4] * m[10] - m[6] * m[8]) +
           m[2] * (m[4] * m[9] - m[5] * m[8]);
}

/* What normals are multiplied with: the cofactors, which turned surfaces keep at right angles. */
static void cofactors(const double m[12], double out[12])
{
    const double sign = determinant(m) < 0 ? -1 : 1;
    for (int row = 0; row < 3; row++)
        for (int k = 0; k < 3; k++) {
            const int r = (row + 1) % 3, s = (row + 2) % 3, c = (k + 1) % 3, d = (k + 2) % 3;
            out[4 * row + k] = sign * (m[4 * r + c] * m[4 * s + d] - m[4 * r + d] * m[4 * s + c]);
        }
    out[3] = out[7] = out[11] = 0;
}

/* parent: its matrix, or NULL. */
static void add_node(flattener *f, const struct aiNode *node, const double *parent)
{
    placing *made = &f->nodes[f->node_count++];
    double own[12];
    made->node = node;
    from_assimp(&node->mTransformation, own);
    if (parent)
        multiply(parent, own, made->m);
    else
        memcpy(made->m, own, sizeof own);
}

/* Without recursion, since a file may nest as deep as it likes: children follow once their parent is listed. */
static bool list_nodes(flattener *f)
{
    size_t capacity = 0;
    const struct aiNode *root = f->from->scene->mRootNode;
    if (!daft_grow(f->from->allocator, &f->nodes, &capacity, 1, 0, sizeof *f->nodes))
        return daft_fail_memory(f->from->error, "a model's nodes");
    add_node(f, root, NULL);
    for (uint32_t i = 0; i < f->node_count; i++) {
        const struct aiNode *node = f->nodes[i].node;
        if (!daft_grow(f->from->allocator, &f->nodes, &capacity, (size_t)f->node_count + node->mNumChildren,
                       f->node_count, sizeof *f->nodes))
            return daft_fail_memory(f->from->error, "a model's nodes");
        for (uint32_t k = 0; k < node->mNumChildren; k++) add_node(f, node->mChildren[k], f->nodes[i].m);
    }
    return true;
}

/* ---- skins ---- */

static const placing *find_node(const flattener *f, const struct aiString *name)
{
    for (uint32_t i = 0; i < f->node_count; i++)
        if (strcmp(f->nodes[i].node->mName.data, name->data) == 0) return &f->nodes[i];
    return NULL;
}

/* The matrix of each vertex of a skin as its bones stand: weighted sums (linear blend skinning). */
static bool blend(flattener *f, const struct aiMesh *mesh)
{
    const daft_allocator *allocator = f->from->allocator;
    daft_release(allocator, f->blended);
    f->blended = daft_alloc_zero(allocator, mesh->mNumVertices, 12 * sizeof *f->blended);
    if (!f->blended) return daft_fail_memory(f->from->error, "a model's skin");
    for (uint32_t i = 0; i < mesh->mNumBones; i++) {
        const struct aiBone *bone = mesh->mBones[i];
        const placing *node = find_node(f, &bone->mName);
        double offset[12], m[12];
        if (!node) continue;
        from_assimp(&bone->mOffsetMatrix, offset);
        multiply(node->m, offset, m);
        for (uint32_t k = 0; k < bone->mNumWeights; k++) {
            const struct aiVertexWeight *weight = &bone->mWeights[k];
            if (weight->mVertexId >= mesh->mNumVertices) continue;
            for (int j = 0; j < 12; j++)
                f->blended[12 * (size_t)weight->mVertexId + (size_t)j] += (double)weight->mWeight * m[j];
        }
    }
    return true;
}

/* ---- vertices and triangles ---- */

static void put_vertices(flattener *f, const struct aiMesh *mesh, const double place[12])
{
    f->bare |= !mesh->mNormals;
    for (uint32_t i = 0; i < mesh->mNumVertices; i++) {
        const uint32_t at = f->count + i;
        const double *own = mesh->mNumBones ? f->blended + 12 * (size_t)i : NULL, *m = own ? own : place;
        double turned[12];
        if (own && determinant(own) == 0) m = place; /* a vertex that no bone holds */
        cofactors(m, turned);
        f->positions[at] = move(m, mesh->mVertices[i], 1);
        const daft_dvec3 n = mesh->mNormals ? daft_to_double(move(turned, mesh->mNormals[i], 0)) : daft_dv3(0, 0, 0);
        const double length = sqrt(daft_ddot(n, n));
        f->mesh.normals[at] =
            isfinite(length) && length > 0 ? daft_to_float(daft_dscale(n, 1 / length)) : daft_v3(0, 1, 0);
        const struct aiVector3D uv = mesh->mTextureCoords[0] ? mesh->mTextureCoords[0][i] : (struct aiVector3D){0};
        f->mesh.uvs[at] = isfinite(uv.x) && isfinite(uv.y) ? (daft_vec2){uv.x, uv.y} : (daft_vec2){0, 0};
    }
}

static void put_triangles(flattener *f, const struct aiMesh *mesh, bool mirrored)
{
    daft_trimesh *to = &f->mesh;
    for (uint32_t i = 0; i < mesh->mNumFaces; i++) {
        const struct aiFace *face = &mesh->mFaces[i];
        if (face->mNumIndices != 3) continue;
        uint32_t *corner = &to->indices[3 * (size_t)to->triangle_count];
        bool good = true;
        for (int k = 0; k < 3; k++) {
            const uint32_t index = face->mIndices[mirrored ? 2 - k : k];
            good = good && index < mesh->mNumVertices && daft_finite3(f->positions[f->count + index]);
            corner[k] = f->count + index;
        }
        to->left_out += !good;
        if (!good) continue;
        to->slots[to->triangle_count++] = (uint16_t)mesh->mMaterialIndex;
    }
}

static bool put_meshes(flattener *f)
{
    const struct aiScene *scene = f->from->scene;
    for (uint32_t i = 0; i < f->node_count; i++) {
        const placing *p = &f->nodes[i];
        for (uint32_t k = 0; k < p->node->mNumMeshes; k++) {
            const struct aiMesh *mesh = scene->mMeshes[p->node->mMeshes[k]];
            if (mesh->mNumBones && !blend(f, mesh)) return false;
            put_vertices(f, mesh, p->m);
            put_triangles(f, mesh, determinant(p->m) < 0 && !mesh->mNumBones);
            f->count += mesh->mNumVertices;
        }
    }
    return true;
}

static bool reserve(flattener *f)
{
    const daft_allocator *allocator = f->from->allocator;
    const struct aiScene *scene = f->from->scene;
    uint64_t vertices = 0, triangles = 0;
    for (uint32_t i = 0; i < f->node_count; i++)
        for (uint32_t k = 0; k < f->nodes[i].node->mNumMeshes; k++) {
            const struct aiMesh *mesh = scene->mMeshes[f->nodes[i].node->mMeshes[k]];
            vertices += mesh->mNumVertices, triangles += mesh->mNumFaces;
        }
    if (vertices > MOST_VERTICES || triangles > MOST_VERTICES || scene->mNumMaterials > MOST_SLOTS)
        return daft_fail_at(f->from->error, DAFT_ERROR_UNSUPPORTED, f->from->path, 0, 0,
                            "%llu vertices, %llu triangles and %u materials; at most 2^28, 2^28 and 65535 are possible",
                            (unsigned long long)vertices, (unsigned long long)triangles, scene->mNumMaterials);
    daft_trimesh *m = &f->mesh;
    m->normal_count = m->uv_count = (uint32_t)vertices;
    m->slot_count = scene->mNumMaterials;
    const size_t v = vertices ? vertices : 1, t = triangles ? triangles : 1;
    f->positions = daft_alloc(allocator, v, sizeof *f->positions);
    m->normals = daft_alloc(allocator, v, sizeof *m->normals);
    m->uvs = daft_alloc(allocator, v, sizeof *m->uvs);
    m->indices = daft_alloc(allocator, t, 3 * sizeof *m->indices);
    m->normal_indices = daft_alloc(allocator, t, 3 * sizeof *m->normal_indices);
    m->uv_indices = daft_alloc(allocator, t, 3 * sizeof *m->uv_indices);
    m->slots = daft_alloc(allocator, t, sizeof *m->slots);
    return (f->positions && m->normals && m->uvs && m->indices && m->normal_indices && m->uv_indices && m->slots) ||
           daft_fail_memory(f->from->error, "a model");
}

/* ---- vertices in one place ---- */

static uint32_t slot_of(daft_vec3 p, uint32_t mask)
{
    const float bits[3] = {p.x + 0.0f, p.y + 0.0f, p.z + 0.0f}; /* -0 is 0 */
    return (uint32_t)(daft_hash(bits, sizeof bits, 0) >> 32) & mask;
}

/* Numbers positions anew, without repetition; triangles that have become lines or points go. */
static bool weld(flattener *f)
{
    const daft_allocator *allocator = f->from->allocator;
    daft_trimesh *m = &f->mesh;
    uint32_t room = 16, kept = 0;
    while (room < 2 * (uint64_t)f->count) room *= 2;
    uint32_t *table = daft_alloc(allocator, room, sizeof *table),
             *number = daft_alloc(allocator, f->count + 1, sizeof *number);
    bool good = table && number;
    for (uint32_t i = 0; good && i < room; i++) table[i] = UINT32_MAX;
    for (uint32_t i = 0; good && i < f->count; i++) {
        const daft_vec3 p = f->positions[i];
        uint32_t at = slot_of(p, room - 1);
        for (; table[at] != UINT32_MAX; at = (at + 1) & (room - 1)) {
            const daft_vec3 q = f->positions[table[at]];
            if (q.x == p.x && q.y == p.y && q.z == p.z) break;
        }
        if (table[at] == UINT32_MAX) table[at] = kept, f->positions[kept++] = p;
        number[i] = table[at];
    }
    uint32_t triangles = 0;
    for (uint32_t t = 0; good && t < m->triangle_count; t++) {
        const uint32_t *from = &m->indices[3 * (size_t)t], corner[3] = {from[0], from[1], from[2]};
        const uint32_t a = number[corner[0]], b = number[corner[1]], c = number[corner[2]];
        if (a == b || b == c || c == a) {
            m->left_out++;
            continue;
        }
        const size_t to = 3 * (size_t)triangles;
        for (int k = 0; k < 3; k++) {
            m->normal_indices[to + (size_t)k] = m->uv_indices[to + (size_t)k] = corner[k];
            m->indices[to + (size_t)k] = number[corner[k]];
        }
        m->slots[triangles++] = m->slots[t];
    }
    m->triangle_count = triangles;
    daft_release(allocator, table), daft_release(allocator, number);
    if (!good) return daft_fail_memory(f->from->error, "a model");
    return daft_trimesh_set_positions(allocator, m, f->positions, kept, f->from->error);
}

/* Normals of our own, for all: smooth across edges flatter than 40 degrees. */
static bool make_normals(flattener *f)
{
    const daft_allocator *allocator = f->from->allocator;
    daft_trimesh *m = &f->mesh;
    if (!f->bare) return true;
    daft_release(allocator, m->normals);
    daft_release(allocator, m->normal_indices);
    m->normals = NULL, m->normal_indices = NULL;
    return daft_trimesh_smooth(allocator, m, DAFT_SMOOTH_CREASE, f->from->error);
}

bool daft_foreign_mesh(const daft_foreign *from, daft_trimesh *out)
{
    flattener f = {.from = from};
    bool good = list_nodes(&f) && reserve(&f) && put_meshes(&f) && weld(&f) && make_normals(&f);
    daft_release(from->allocator, f.nodes);
    daft_release(from->allocator, f.positions);
    daft_release(from->allocator, f.blended);
    if (good) {
        daft_trimesh_set_bounds(&f.mesh);
        *out = f.mesh;
    } else {
        daft_trimesh_free(from->allocator, &f.mesh);
    }
    return good;
}
