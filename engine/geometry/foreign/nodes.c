/* The nodes of a model, parents first, and their matrices. */
#include "geometry/foreign/assimp.h"

#include <string.h>

bool daft_foreign_matrix(const struct aiMatrix4x4 *a, double m[12])
{
    const float rows[12] = {a->a1, a->a2, a->a3, a->a4, a->b1, a->b2, a->b3, a->b4, a->c1, a->c2, a->c3, a->c4};
    bool finite = true;
    for (int i = 0; i < 12; i++) finite = finite && isfinite(rows[i]);
    for (int i = 0; i < 12; i++) m[i] = finite ? (double)rows[i] : i % 5 == 0;
    return finite;
}

daft_vec3 daft_foreign_move(const double m[12], struct aiVector3D v, double w)
{
    const double x = (double)v.x, y = (double)v.y, z = (double)v.z;
    return daft_v3((float)(m[0] * x + m[1] * y + m[2] * z + w * m[3]),
                   (float)(m[4] * x + m[5] * y + m[6] * z + w * m[7]),
                   (float)(m[8] * x + m[9] * y + m[10] * z + w * m[11]));
}

double daft_foreign_determinant(const double m[12])
{
    return m[0] * (m[5] * m[10] - m[6] * m[9]) - m[1] * (m[4] * m[10] - m[6] * m[8]) +
           m[2] * (m[4] * m[9] - m[5] * m[8]);
}

static void add_node(const daft_foreign *from, daft_foreign_nodes *nodes, const struct aiNode *node, uint32_t parent)
{
    daft_foreign_node *made = &nodes->items[nodes->count++];
    made->node = node, made->parent = parent;
    if (!daft_foreign_matrix(&node->mTransformation, made->own))
        daft_warn_at(from->log, DAFT_ERROR_SYNTAX, from->path, 0, 0,
                     "the node '%.100s' has a transform that is not finite: it stays where its parent is",
                     node->mName.data);
    if (parent == DAFT_RIG_NONE)
        memcpy(made->m, made->own, sizeof made->own);
    else
        daft_rig_multiply(nodes->items[parent].m, made->own, made->m);
}

/* Without recursion, since a file may nest as deep as it likes: children follow once their parent is listed. */
static bool list(const daft_foreign *from, daft_foreign_nodes *nodes)
{
    size_t capacity = 0;
    if (!daft_grow(from->allocator, &nodes->items, &capacity, 1, 0, sizeof *nodes->items)) return false;
    add_node(from, nodes, from->scene->mRootNode, DAFT_RIG_NONE);
    for (uint32_t i = 0; i < nodes->count; i++) {
        const struct aiNode *node = nodes->items[i].node;
        if (!daft_grow(from->allocator, &nodes->items, &capacity, (size_t)nodes->count + node->mNumChildren,
                       nodes->count, sizeof *nodes->items))
            return false;
        for (uint32_t k = 0; k < node->mNumChildren; k++) add_node(from, nodes, node->mChildren[k], i);
    }
    return true;
}

/* The place of a name in the table, or the empty one where it would be. */
static uint32_t place_of(const daft_foreign_nodes *nodes, const char *name)
{
    uint32_t at = (uint32_t)(daft_hash(name, strlen(name), 0) >> 32) & nodes->mask;
    while (nodes->by_name[at] != DAFT_RIG_NONE && strcmp(nodes->items[nodes->by_name[at]].node->mName.data, name) != 0)
        at = (at + 1) & nodes->mask;
    return at;
}

bool daft_foreign_nodes_list(const daft_foreign *from, daft_foreign_nodes *nodes)
{
    uint32_t room = 16;
    bool done = list(from, nodes);
    while (room < 2 * (uint64_t)nodes->count) room *= 2;
    nodes->by_name = done ? daft_alloc(from->allocator, room, sizeof *nodes->by_name) : NULL;
    if (!nodes->by_name) return daft_fail_memory(from->error, "a model's nodes");
    nodes->mask = room - 1;
    for (uint32_t i = 0; i < room; i++) nodes->by_name[i] = DAFT_RIG_NONE;
    for (uint32_t i = 0; i < nodes->count; i++) {
        const uint32_t at = place_of(nodes, nodes->items[i].node->mName.data);
        if (nodes->by_name[at] == DAFT_RIG_NONE) nodes->by_name[at] = i;
    }
    return true;
}

void daft_foreign_nodes_free(const daft_foreign *from, daft_foreign_nodes *nodes)
{
    daft_release(from->allocator, nodes->items);
    daft_release(from->allocator, nodes->by_name);
}

uint32_t daft_foreign_nodes_find(const daft_foreign_nodes *nodes, const char *name)
{
    return nodes->by_name[place_of(nodes, name)];
}
