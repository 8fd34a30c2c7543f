/* Walks through the trees of the broad phase, near boxes first. Bounds in the trees were made before the last step and
 * hold where a body was expected to go; where a contact sent it elsewhere, it may have left them. Such parts are found
 * once, when the first query after a step asks, and are chained through their records, so nothing is allocated and the
 * trees stay as the next step expects them. */
#include "sim/walk.h"

#include "sim/triangles.h"

enum { STACK_DEPTH = 64 }; /* see tree.c */

bool daft_sim_passes(const daft_world *world, uint32_t index, const daft_sim_filter *filter)
{
    const daft_sim_part *part = &world->parts[index];
    if (part->sensor && !filter->sensors) return false;
    if (part->body + 1 == filter->ignore || !(filter->kinds >> world->bodies[part->body].kind & 1)) return false;
    return (part->layers & filter->mask) && (filter->layers & part->mask);
}

uint32_t daft_sim_part_ordinal(const daft_world *world, uint32_t part)
{
    uint32_t ordinal = 0;
    for (uint32_t i = world->bodies[world->parts[part].body].first_part; i != part; i = world->parts[i].next) ordinal++;
    return ordinal;
}

daft_sim_way daft_sim_way_of(const daft_sim_shape *shape, const daft_rigid *frame, daft_dvec3 motion)
{
    daft_daabb b = daft_shape_bounds(shape, frame);
    return (daft_sim_way){.origin = daft_dscale(daft_dadd(b.low, b.high), 0.5),
                          .motion = motion,
                          .reach = daft_dscale(daft_dsub(b.high, b.low), 0.5),
                          .end = 1};
}

/* ---- parts that left their bounds ---- */

static bool holds(const daft_sim_bounds *outer, const daft_sim_bounds *inner)
{
    return outer->low.x <= inner->low.x && outer->low.y <= inner->low.y && outer->low.z <= inner->low.z &&
           outer->high.x >= inner->high.x && outer->high.y >= inner->high.y && outer->high.z >= inner->high.z;
}

static void find_escaped_of(daft_world *world, const daft_sim_list *bodies)
{
    for (size_t k = 0; k < bodies->count; k++)
        for (uint32_t i = world->bodies[bodies->items[k]].first_part; i != DAFT_SIM_NONE; i = world->parts[i].next) {
            daft_sim_part *part = &world->parts[i];
            daft_sim_bounds bounds = daft_sim_part_bounds(world, i);
            if (holds(&world->fat[i], &bounds)) continue;
            part->next_escaped = world->first_escaped;
            part->escaped_at = world->changes;
            world->first_escaped = i;
        }
}

static void find_escaped(daft_world *world)
{
    if (world->escaped_at == world->changes) return;
    world->first_escaped = DAFT_SIM_NONE;
    find_escaped_of(world, &world->awake);
    find_escaped_of(world, &world->movers);
    world->escaped_at = world->changes;
}

/* ---- the walk ---- */

typedef struct entry {
    double enter;
    uint32_t node;
} entry;

static bool meets(const daft_sim_way *way, const daft_sim_bounds *bounds, double *enter)
{
    return daft_sweep_meets(way->origin, way->motion, way->reach, bounds->low, bounds->high, way->end, enter);
}

static void walk_tree(const daft_world *world, const daft_sim_tree *tree, daft_sim_way *way,
                      const daft_sim_filter *filter, daft_sim_visit *visit, void *context)
{
    entry stack[STACK_DEPTH], e[2];
    int depth = 0;
    if (tree->root != DAFT_SIM_NONE && meets(way, &tree->nodes[tree->root].bounds, &e[0].enter))
        stack[depth++] = (entry){e[0].enter, tree->root};
    while (depth > 0) {
        entry top = stack[--depth];
        if (top.enter > way->end) continue;
        const daft_sim_node *node = &tree->nodes[top.node];
        if (node->height == 0) {
            bool escaped = world->parts[node->part].escaped_at == world->changes; /* visited already */
            if (!escaped && daft_sim_passes(world, node->part, filter)) visit(context, node->part);
            continue;
        }
        bool met[2];
        for (int i = 0; i < 2; i++) {
            e[i].node = node->child[i];
            met[i] = meets(way, &tree->nodes[e[i].node].bounds, &e[i].enter);
        }
        int first = met[0] && met[1] && e[1].enter < e[0].enter; /* of the two to be visited */
        if (met[1 - first]) stack[depth++] = e[1 - first];
        if (met[first]) stack[depth++] = e[first];
    }
}

void daft_sim_walk(daft_world *world, daft_sim_way *way, const daft_sim_filter *filter, daft_sim_visit *visit,
                   void *context)
{
    find_escaped(world);
    for (uint32_t i = world->first_escaped; i != DAFT_SIM_NONE && way->end >= 0; i = world->parts[i].next_escaped)
        if (daft_sim_passes(world, i, filter)) visit(context, i);
    for (int kind = DAFT_BODY_STATIC; kind <= DAFT_BODY_DYNAMIC; kind++)
        if (filter->kinds >> kind & 1) walk_tree(world, &world->trees[kind], way, filter, visit, context);
}
