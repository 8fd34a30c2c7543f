/* From a hierarchy of meshes to one mesh. */
#include "geometry/foreign/assimp.h"

#include "geometry/trimesh.h"

#include <string.h>

enum { MOST_VERTICES = 1 << 28, MOST_SLOTS = 65535 };

typedef daft_flattener flattener;

/* ---- skins at rest ---- */

/* What normals are multiplied with: the cofactors, which turned surfaces keep at right angles. */
static void cofactors(const double m[12], double out[12])
{
    const double sign = daft_foreign_determinant(m) < 0 ? -1 : 1;
    for (int row = 0; row < 3; row++)
        for (int k = 0; k < 3; k++) {
            const int r = (row + 1) % 3, s = (row + 2) % 3, c = (k + 1) % 3, d = (k + 2) % 3;
            out[4 * row + k] = sign * (m[4 * r + c] * m[4 * s + d] - m[4 * r + d] * m[4 * s + c]);
        }
    out[3] = out[7] = out[11] = 0;
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
        const uint32_t node = daft_foreign_nodes_find(&f->nodes, bone->mName.data);
        double offset[12], m[12];
        if (node == DAFT_RIG_NONE) continue;
        daft_foreign_matrix(&bone->mOffsetMatrix, offset);
        daft_rig_multiply(f->nodes.items[node].m, offset, m);
        for (uint32_t k = 0; k < bone->mNumWeights; k++) {
            const struct aiVertexWeight *weight = &bone->mWeights[k];
            if (weight->mVertexId >= mesh->mNumVertices || !isfinite(weight->mWeight)) continue;
            for (int j = 0; j < 12; j++)
                f->blended[12 * (size_t)weight->mVertexId + (size_t)j] += (double)weight->mWeight * m[j];
        }
    }
    return true;
}

/* ---- vertices and triangles ---- */

/* glTF's are linear; other formats do not say, and their exporters write what their pickers show. */
static daft_vec3 color_of(const flattener *f, const struct aiColor4D *c)
{
    if (!isfinite(c->r) || !isfinite(c->g) || !isfinite(c->b)) return daft_v3(1, 1, 1);
    if (f->linear_colors) return daft_min3(daft_max3(daft_v3(c->r, c->g, c->b), daft_v3(0, 0, 0)), daft_v3(1, 1, 1));
    return daft_v3(daft_trimesh_color((double)c->r), daft_trimesh_color((double)c->g),
                   daft_trimesh_color((double)c->b));
}

static void put_vertices(flattener *f, const struct aiMesh *mesh, const double place[12])
{
    static const double AS_IT_IS[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    f->bare |= !mesh->mNormals;
    if (f->rig) place = AS_IT_IS;
    for (uint32_t i = 0; i < mesh->mNumVertices; i++) {
        const uint32_t at = f->count + i;
        const double *own = mesh->mNumBones && !f->rig ? f->blended + 12 * (size_t)i : NULL, *m = own ? own : place;
        double turned[12];
        if (own && daft_foreign_determinant(own) == 0) m = place; /* a vertex that no bone holds */
        cofactors(m, turned);
        f->positions[at] = daft_foreign_move(m, mesh->mVertices[i], 1);
        const daft_dvec3 n =
            mesh->mNormals ? daft_to_double(daft_foreign_move(turned, mesh->mNormals[i], 0)) : daft_dv3(0, 0, 0);
        const double length = sqrt(daft_ddot(n, n));
        f->mesh.normals[at] =
            isfinite(length) && length > 0 ? daft_to_float(daft_dscale(n, 1 / length)) : daft_v3(0, 1, 0);
        const struct aiVector3D uv = mesh->mTextureCoords[0] ? mesh->mTextureCoords[0][i] : (struct aiVector3D){0};
        f->mesh.uvs[at] = isfinite(uv.x) && isfinite(uv.y) ? (daft_vec2){uv.x, uv.y} : (daft_vec2){0, 0};
        if (f->mesh.colors)
            f->mesh.colors[at] = mesh->mColors[0] ? color_of(f, &mesh->mColors[0][i]) : daft_v3(1, 1, 1);
        if (f->mesh.alphas) f->mesh.alphas[at] = mesh->mColors[0] ? daft_trimesh_alpha(mesh->mColors[0][i].a) : 1;
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
    for (uint32_t i = 0; i < f->nodes.count; i++) {
        const daft_foreign_node *p = &f->nodes.items[i];
        for (uint32_t k = 0; k < p->node->mNumMeshes; k++) {
            const struct aiMesh *mesh = scene->mMeshes[p->node->mMeshes[k]];
            if (f->rig ? !daft_foreign_rig_bind(f, mesh, i) : mesh->mNumBones && !blend(f, mesh)) return false;
            put_vertices(f, mesh, p->m);
            put_triangles(f, mesh, daft_foreign_determinant(p->m) < 0 && !mesh->mNumBones);
            f->count += mesh->mNumVertices;
        }
    }
    return true;
}

static bool reserve_colors(flattener *f, size_t vertices, size_t triangles)
{
    daft_trimesh *m = &f->mesh;
    m->color_count = (uint32_t)vertices;
    m->colors = daft_alloc(f->from->allocator, vertices, sizeof *m->colors);
    m->color_indices = daft_alloc(f->from->allocator, triangles, 3 * sizeof *m->color_indices);
    m->alphas = daft_alloc(f->from->allocator, vertices, sizeof *m->alphas);
    return (m->colors && m->color_indices && m->alphas) || daft_fail_memory(f->from->error, "a model's colours");
}

static bool reserve(flattener *f)
{
    const daft_allocator *allocator = f->from->allocator;
    const struct aiScene *scene = f->from->scene;
    uint64_t vertices = 0, triangles = 0;
    bool colored = false;
    for (uint32_t i = 0; i < f->nodes.count; i++)
        for (uint32_t k = 0; k < f->nodes.items[i].node->mNumMeshes; k++) {
            const struct aiMesh *mesh = scene->mMeshes[f->nodes.items[i].node->mMeshes[k]];
            vertices += mesh->mNumVertices, triangles += mesh->mNumFaces;
            colored |= mesh->mColors[0] != NULL;
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
    if (colored && !reserve_colors(f, v, t)) return false;
    if (f->rig) f->bindings = daft_alloc_zero(allocator, v, sizeof *f->bindings);
    return (f->positions && (f->bindings || !f->rig) && m->normals && m->uvs && m->indices && m->normal_indices &&
            m->uv_indices && m->slots) ||
           daft_fail_memory(f->from->error, "a model");
}

/* ---- vertices in one place ---- */

static uint32_t slot_of(daft_vec3 p, uint32_t mask)
{
    const float bits[3] = {p.x + 0.0f, p.y + 0.0f, p.z + 0.0f}; /* -0 is 0 */
    return (uint32_t)(daft_hash(bits, sizeof bits, 0) >> 32) & mask;
}

/* The place in the table of a vertex that this one becomes one with, or of none. */
static uint32_t find_place(const flattener *f, const uint32_t *table, uint32_t mask, uint32_t vertex)
{
    const daft_vec3 p = f->positions[vertex];
    uint32_t at = slot_of(p, mask);
    for (; table[at] != UINT32_MAX; at = (at + 1) & mask) {
        const daft_vec3 q = f->positions[table[at]];
        if (q.x == p.x && q.y == p.y && q.z == p.z && (!f->rig || daft_foreign_rig_alike(f, table[at], vertex))) break;
    }
    return at;
}

/* Numbers positions anew, without repetition. Returns how many there are. */
static uint32_t number_vertices(flattener *f, uint32_t *table, uint32_t room)
{
    uint32_t kept = 0;
    for (uint32_t i = 0; i < room; i++) table[i] = UINT32_MAX;
    for (uint32_t i = 0; i < f->count; i++) {
        const uint32_t at = find_place(f, table, room - 1, i);
        const bool fresh = table[at] == UINT32_MAX;
        f->number[i] = fresh ? kept++ : f->number[table[at]];
        if (fresh) table[at] = i;
    }
    return kept;
}

/* Triangles that have become lines or points go. */
static void number_triangles(flattener *f)
{
    daft_trimesh *m = &f->mesh;
    uint32_t triangles = 0;
    for (uint32_t t = 0; t < m->triangle_count; t++) {
        const uint32_t *from = &m->indices[3 * (size_t)t], corner[3] = {from[0], from[1], from[2]};
        const uint32_t a = f->number[corner[0]], b = f->number[corner[1]], c = f->number[corner[2]];
        if (a == b || b == c || c == a) {
            m->left_out++;
            continue;
        }
        const size_t to = 3 * (size_t)triangles;
        for (size_t k = 0; k < 3; k++) {
            m->normal_indices[to + k] = m->uv_indices[to + k] = corner[k];
            if (m->colors) m->color_indices[to + k] = corner[k];
            m->indices[to + k] = f->number[corner[k]];
        }
        m->slots[triangles++] = m->slots[t];
    }
    m->triangle_count = triangles;
}

static bool weld(flattener *f)
{
    const daft_allocator *allocator = f->from->allocator;
    uint32_t room = 16;
    while (room < 2 * (uint64_t)f->count) room *= 2;
    uint32_t *table = daft_alloc(allocator, room, sizeof *table);
    daft_vec3 *kept = daft_alloc(allocator, (size_t)f->count + 1, sizeof *kept);
    f->number = daft_alloc(allocator, (size_t)f->count + 1, sizeof *f->number);
    bool good = (table && kept && f->number) || daft_fail_memory(f->from->error, "a model");
    if (good) {
        const uint32_t count = number_vertices(f, table, room);
        for (uint32_t i = f->count; i-- > 0;) kept[f->number[i]] = f->positions[i]; /* the first of each counts */
        number_triangles(f);
        good = daft_trimesh_set_positions(allocator, &f->mesh, kept, count, f->from->error);
    }
    daft_release(allocator, table), daft_release(allocator, kept);
    return good;
}

/* White says nothing, and costs nothing. */
static void drop_white(flattener *f)
{
    daft_trimesh *m = &f->mesh;
    bool faint = false;
    for (uint32_t i = 0; m->alphas && i < f->count && !faint; i++) faint = m->alphas[i] < 1;
    if (faint) return;
    daft_release(f->from->allocator, m->alphas);
    m->alphas = NULL;
    for (uint32_t i = 0; m->colors && i < f->count; i++)
        if (m->colors[i].x < 1 || m->colors[i].y < 1 || m->colors[i].z < 1) return;
    daft_release(f->from->allocator, m->colors), daft_release(f->from->allocator, m->color_indices);
    m->colors = NULL, m->color_indices = NULL, m->color_count = 0;
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

bool daft_foreign_mesh(const daft_foreign *from, daft_obj *out)
{
    flattener f = {.from = from, .linear_colors = daft_foreign_is_gltf(from)};
    bool good = daft_foreign_nodes_list(from, &f.nodes) && daft_gltf_open(from, &f.nodes, &f.gltf) &&
                daft_foreign_rig_begin(&f) && reserve(&f) && put_meshes(&f) && weld(&f) && make_normals(&f) &&
                (!f.rig || daft_foreign_rig_end(&f)) && daft_foreign_scenery(&f, out);
    if (good) drop_white(&f);
    daft_gltf_close(&f.gltf);
    daft_foreign_nodes_free(from, &f.nodes);
    daft_release(from->allocator, f.positions), daft_release(from->allocator, f.number);
    daft_release(from->allocator, f.blended), daft_release(from->allocator, f.bindings);
    if (good) {
        daft_trimesh_set_bounds(&f.mesh);
        out->mesh = f.mesh, out->rig = f.rig;
    } else {
        daft_trimesh_free(from->allocator, &f.mesh);
        daft_rig_free(from->allocator, f.rig);
    }
    return good;
}
