/* Walks through the trees of the broad phase, near boxes first. The first query after a step sees to it that they hold
 * all parts where they are. */
#include "sim/query/walk.h"
#include "sim/broad/broad.h"

#include "sim/shape/triangles.h"

enum { STACK_DEPTH = 64 }; /* see tree.c */

static bool passes_filter(const daft_world *world, uint32_t index, const daft_sim_filter *filter)
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

daft_sim_path daft_sim_path_of(const daft_sim_shape *shape, const daft_rigid *frame, daft_dvec3 motion)
{
    daft_daabb b = daft_shape_bounds(shape, frame);
    return (daft_sim_path){.origin = daft_dscale(daft_dadd(b.low, b.high), 0.5),
                           .motion = motion,
                           .reach = daft_dscale(daft_dsub(b.high, b.low), 0.5),
                           .end = 1};
}

/* ---- the walk ---- */

typedef struct entry {
    double enter;
    uint32_t node;
} entry;

static bool meets(const daft_sim_path *path, const daft_sim_bounds *bounds, double *enter)
{
    return daft_sweep_meets(path->origin, path->motion, path->reach, bounds->low, bounds->high, path->end, enter);
}

static void walk_tree(const daft_world *world, const daft_sim_tree *tree, daft_sim_path *path,
                      const daft_sim_filter *filter, daft_sim_visit *visit, void *context)
{
    entry stack[STACK_DEPTH], e[2];
    int depth = 0;
    if (tree->root != DAFT_SIM_NONE && meets(path, &tree->nodes[tree->root].bounds, &e[0].enter))
        stack[depth++] = (entry){e[0].enter, tree->root};
    while (depth > 0) {
        entry top = stack[--depth];
        if (top.enter > path->end) continue;
        const daft_sim_node *node = &tree->nodes[top.node];
        if (node->height == 0) {
            if (passes_filter(world, node->part, filter)) visit(context, node->part);
            continue;
        }
        bool met[2];
        for (int i = 0; i < 2; i++) {
            e[i].node = node->child[i];
            met[i] = meets(path, &tree->nodes[e[i].node].bounds, &e[i].enter);
        }
        int first = met[0] && met[1] && e[1].enter < e[0].enter; /* of the two to be visited */
        if (met[1 - first]) stack[depth++] = e[1 - first];
        if (met[first]) stack[depth++] = e[first];
    }
}

void daft_sim_walk(daft_world *world, daft_sim_path *path, const daft_sim_filter *filter, daft_sim_visit *visit,
                   void *context)
{
    daft_sim_broad_settle(world);
    for (int kind = DAFT_BODY_STATIC; kind <= DAFT_BODY_DYNAMIC; kind++)
        if (filter->kinds >> kind & 1) walk_tree(world, &world->trees[kind], path, filter, visit, context);
}
