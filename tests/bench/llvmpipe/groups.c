/* What is drawn, by calls: the instances of the snapshot that are in sight, those of one mesh and material together,
 * nearest first. */
#include "llvmpipe/peer.h"

#include <math.h>
#include <stdlib.h>

typedef struct peer_item {
    uint32_t mesh, range, material, instance;
    float distance;
} peer_item;

bool peer_is_outside(const daft_instance *i, const peer_planes *inside)
{
    for (int k = 0; k < inside->count; k++) {
        const float *p = inside->at[k];
        const float x = p[0] > 0 ? i->high.x : i->low.x, y = p[1] > 0 ? i->high.y : i->low.y,
                    z = p[2] > 0 ? i->high.z : i->low.z;
        if (p[0] * x + p[1] * y + p[2] * z + p[3] < 0) return true;
    }
    return false;
}

float peer_distance(const daft_instance *i, daft_vec3 from)
{
    const float x = fmaxf(fmaxf(i->low.x - from.x, from.x - i->high.x), 0),
                y = fmaxf(fmaxf(i->low.y - from.y, from.y - i->high.y), 0),
                z = fmaxf(fmaxf(i->low.z - from.z, from.z - i->high.z), 0);
    return sqrtf(x * x + y * y + z * z);
}

static int by_call(const void *a, const void *b)
{
    const peer_item *x = a, *y = b;
    if (x->mesh != y->mesh) return x->mesh < y->mesh ? -1 : 1;
    if (x->range != y->range) return x->range < y->range ? -1 : 1;
    if (x->material != y->material) return x->material < y->material ? -1 : 1;
    return x->distance < y->distance ? -1 : x->distance > y->distance;
}

/* What blends last, farthest first. */
static int by_distance(const void *a, const void *b)
{
    const peer_group *x = a, *y = b;
    if (x->blends != y->blends) return x->blends ? 1 : -1;
    const float p = x->blends ? y->nearest : x->nearest, q = x->blends ? x->nearest : y->nearest;
    return p < q ? -1 : p > q;
}

static bool add_part(peer_groups *g, const daft_allocator *allocator, peer_item item)
{
    if (!daft_grow(allocator, &g->parts, &g->part_capacity, g->part_count + 1, g->part_count, sizeof *g->parts))
        return false;
    g->parts[g->part_count++] = item;
    return true;
}

static bool casts(const daft_instance *instance, const peer_pick *pick)
{
    if (pick->glowing && instance->entity == pick->glowing) return false;
    return instance->flags & (DAFT_INSTANCE_CASTS_SHADOW | DAFT_INSTANCE_FILTERS_SHADOW);
}

/* Slot by slot, but for casters without masks. What blends casts none. */
static bool add_instance(peer_groups *g, peer_assets *assets, const daft_snapshot *s, uint32_t number,
                         const peer_pick *pick)
{
    const daft_instance *instance = &s->instances[number];
    const uint32_t mesh = peer_mesh_of(assets, instance->mesh);
    if (mesh == UINT32_MAX) return false;
    peer_item item = {mesh, UINT32_MAX, UINT32_MAX, number, peer_distance(instance, pick->from)};
    if (pick->casters && !(instance->flags & DAFT_INSTANCE_FILTERS_SHADOW))
        return add_part(g, &assets->allocator, item);
    for (uint32_t k = 0; k < assets->meshes[mesh].range_count; k++) {
        item.range = k, item.material = instance->materials[assets->meshes[mesh].ranges[k].slot];
        if (pick->casters && peer_traits_of(&s->materials[item.material]) & PEER_BLEND) continue;
        if (!add_part(g, &assets->allocator, item)) return false;
    }
    return true;
}

static bool find_parts(peer_groups *g, peer_assets *assets, const daft_snapshot *s, const peer_pick *pick)
{
    g->part_count = 0;
    for (uint32_t i = 0; i < s->instance_count; i++) {
        const daft_instance *instance = &s->instances[i];
        if ((pick->casters && !casts(instance, pick)) || peer_is_outside(instance, &pick->inside)) continue;
        if (!add_instance(g, assets, s, i, pick)) return false;
    }
    return true;
}

static bool mirrors(const daft_affine *a)
{
    const float *m = a->m;
    return m[0] * (m[4] * m[8] - m[5] * m[7]) - m[1] * (m[3] * m[8] - m[5] * m[6]) +
               m[2] * (m[3] * m[7] - m[4] * m[6]) <
           0;
}

/* A sphere's radius counts the scale of its transform already. */
static void place(const daft_instance *i, float out[12])
{
    const float *m = i->to_frame.m;
    float scale = 1;
    if (!i->mesh) scale = i->radius / sqrtf(m[0] * m[0] + m[3] * m[3] + m[6] * m[6]);
    for (int row = 0; row < 3; row++) {
        for (int k = 0; k < 3; k++) out[4 * row + k] = m[3 * row + k] * scale;
        out[4 * row + 3] = i->to_frame.t[row];
    }
}

static bool same_call(const peer_item *a, const peer_item *b)
{
    return a->mesh == b->mesh && a->range == b->range && a->material == b->material;
}

bool peer_groups_fill(peer_groups *g, peer_assets *assets, const daft_snapshot *s, const peer_pick *pick)
{
    const daft_allocator *allocator = &assets->allocator;
    g->count = 0;
    if (!find_parts(g, assets, s, pick)) return false;
    if (g->part_count == 0) return true;
    if (!daft_grow(allocator, &g->items, &g->group_capacity, g->part_count, 0, sizeof *g->items) ||
        !daft_grow(allocator, &g->placements, &g->placement_capacity, 12 * g->part_count, 0, sizeof *g->placements))
        return false;
    qsort(g->parts, g->part_count, sizeof *g->parts, by_call);
    for (uint32_t i = 0; i < g->part_count; i++) {
        const peer_item *part = &g->parts[i];
        place(&s->instances[part->instance], g->placements + 12 * (size_t)i);
        if (i && same_call(part, part - 1))
            g->items[g->count - 1].count++;
        else
            g->items[g->count++] =
                (peer_group){part->mesh, part->range, part->material, i, 1, part->distance, false, false};
        peer_group *group = &g->items[g->count - 1];
        group->turned |= mirrors(&s->instances[part->instance].to_frame);
        group->blends = part->range != UINT32_MAX && peer_traits_of(&s->materials[part->material]) & PEER_BLEND;
    }
    qsort(g->items, g->count, sizeof *g->items, by_distance);
    if (!g->buffer) glGenBuffers(1, &g->buffer);
    glBindBuffer(GL_ARRAY_BUFFER, g->buffer);
    glBufferData(GL_ARRAY_BUFFER, (GLsizeiptr)(12 * g->part_count * sizeof *g->placements), g->placements,
                 GL_STREAM_DRAW);
    return true;
}

void peer_group_draw(const peer_groups *g, const peer_assets *assets, const peer_group *group, bool positions)
{
    const peer_mesh *mesh = &assets->meshes[group->mesh];
    const peer_range *last = &mesh->ranges[mesh->range_count - 1];
    const peer_range all = {0, 0, mesh->range_count ? last->first + last->count : 0},
                     *range = group->range == UINT32_MAX ? &all : &mesh->ranges[group->range];
    if (range->count == 0) return;
    if (mesh->closed && !group->turned)
        glEnable(GL_CULL_FACE);
    else
        glDisable(GL_CULL_FACE);
    glBindVertexArray(positions ? mesh->position_array : mesh->array);
    glBindBuffer(GL_ARRAY_BUFFER, g->buffer);
    for (GLuint i = 0; i < 3; i++)
        glVertexAttribPointer(3 + i, 4, GL_FLOAT, GL_FALSE, 12 * sizeof(float),
                              (const void *)((12 * (size_t)group->first + 4 * i) * sizeof(float)));
    glDrawElementsInstanced(GL_TRIANGLES, (GLsizei)range->count, GL_UNSIGNED_INT,
                            (const void *)(range->first * sizeof(uint32_t)), (GLsizei)group->count);
}

void peer_groups_free(peer_groups *g, const daft_allocator *allocator)
{
    daft_release(allocator, g->items);
    daft_release(allocator, g->parts);
    daft_release(allocator, g->placements);
}
