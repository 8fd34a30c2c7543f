/* The world as bytes: its records as they are, behind a header with their size and hash. Trees, lists and the set of
 * pairs are built anew when loading, since no result depends on their shape; what free slots are taken next is kept.
 * Every index and number is checked, so that bytes which were made up, and not only damaged ones, are an error. */
#include "sim/world.h"
#include "sim/broad/broad.h"
#include "sim/contact/contact.h"
#include "sim/joint/joint.h"

#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#define MAGIC   0x4d495344u /* "DSIM" */
#define VERSION 5u

typedef struct header {
    uint32_t magic, version, layout; /* layout: sizes of the records */
    uint32_t bodies, parts, pairs, joints;
    uint32_t free_body, free_part, free_pair, free_joint;
    uint32_t live_bodies, live_joints, live_pairs;
    uint32_t awake, movers, moved, has_pairs;
    uint32_t sleeping;
    int32_t substeps;
    daft_vec3 gravity;
    uint64_t size, hash; /* of all that follows the header */
} header;

static uint32_t layout(void)
{
    const size_t sizes[] = {sizeof(daft_sim_body), sizeof(daft_sim_part), sizeof(daft_sim_pair), sizeof(daft_sim_joint),
                            sizeof(daft_sim_manifold)};
    return (uint32_t)daft_hash(sizes, sizeof sizes, 0);
}

/* ---- saving ---- */

typedef struct writer {
    unsigned char *at; /* NULL: only counts */
    size_t size;
} writer;

static void put(writer *w, const void *bytes, size_t size)
{
    if (w->at && size) memcpy(w->at + w->size, bytes, size);
    w->size += size;
}

static void write_world(writer *w, const daft_world *world)
{
    put(w, world->bodies, world->body_count * sizeof *world->bodies);
    put(w, world->parts, world->part_count * sizeof *world->parts);
    put(w, world->fat, world->part_count * sizeof *world->fat);
    put(w, world->tight, world->part_count * sizeof *world->tight);
    put(w, world->pairs, world->pair_count * sizeof *world->pairs);
    for (uint32_t i = 0; i < world->pair_count; i++)
        if (world->pairs[i].more) put(w, world->pairs[i].more, DAFT_SIM_MAX_MANIFOLDS * sizeof(daft_sim_manifold));
    put(w, world->joints, world->joint_count * sizeof *world->joints);
    put(w, world->awake.items, world->awake.count * sizeof *world->awake.items);
    put(w, world->movers.items, world->movers.count * sizeof *world->movers.items);
    put(w, world->moved.items, world->moved.count * sizeof *world->moved.items);
    if (world->material_pairs)
        put(w, world->material_pairs,
            DAFT_SIM_MATERIAL_KINDS * DAFT_SIM_MATERIAL_KINDS * sizeof *world->material_pairs);
}

bool daft_world_save(const daft_world *world, void **bytes, size_t *size, daft_error *error)
{
    writer count = {0};
    write_world(&count, world);
    *bytes = NULL, *size = 0;
    unsigned char *memory = daft_alloc(&world->allocator, 1, sizeof(header) + count.size);
    if (!memory) return daft_fail_memory(error, "the state of a simulation");
    writer w = {memory + sizeof(header), 0};
    write_world(&w, world);
    header h;
    memset(&h, 0, sizeof h);
    h.magic = MAGIC, h.version = VERSION, h.layout = layout();
    h.bodies = world->body_count, h.parts = world->part_count;
    h.pairs = world->pair_count, h.joints = world->joint_count;
    h.free_body = world->free_body, h.free_part = world->free_part;
    h.free_pair = world->free_pair, h.free_joint = world->free_joint;
    h.live_bodies = world->live_bodies, h.live_joints = world->live_joints, h.live_pairs = world->live_pairs;
    h.awake = (uint32_t)world->awake.count, h.movers = (uint32_t)world->movers.count;
    h.moved = (uint32_t)world->moved.count, h.has_pairs = world->material_pairs != NULL;
    h.sleeping = world->sleeping, h.substeps = world->substeps, h.gravity = world->gravity;
    h.size = w.size, h.hash = daft_hash(memory + sizeof h, w.size, 0);
    memcpy(memory, &h, sizeof h);
    *bytes = memory, *size = sizeof h + w.size;
    return true;
}

/* ---- loading: records ---- */

typedef struct reader {
    const unsigned char *at;
    size_t left;
} reader;

/* A copy of the next `count` records, in an array of the world's. NULL with `*good` false: too short, or no memory. */
static void *take(daft_world *world, reader *r, size_t count, size_t size, size_t *capacity, bool *good)
{
    if (!*good || count == 0) return NULL;
    *good = false;
    if (count > r->left / size) return NULL;
    void *copy = daft_alloc(&world->allocator, count, size);
    if (!copy) return NULL;
    memcpy(copy, r->at, count * size);
    r->at += count * size, r->left -= count * size;
    *capacity = count;
    *good = true;
    return copy;
}

/* Whether every byte that stands for a truth value holds one: reading another as a bool would be undefined. `fields`:
 * their offsets in a record. */
static bool truths(const void *records, size_t count, size_t size, const size_t *fields, size_t field_count)
{
    const unsigned char *bytes = records;
    for (size_t i = 0; i < count; i++)
        for (size_t f = 0; f < field_count; f++)
            if (bytes[i * size + fields[f]] > 1) return false;
    return true;
}

#define TRUTHS(records, count, ...)                                                                                    \
    truths(records, count, sizeof *(records), (const size_t[]){__VA_ARGS__},                                           \
           sizeof((const size_t[]){__VA_ARGS__}) / sizeof(size_t))

static bool check_truths(const daft_world *w, const header *h)
{
#define BODY(f)  offsetof(daft_sim_body, f)
#define PART(f)  offsetof(daft_sim_part, f)
#define PAIR(f)  offsetof(daft_sim_pair, f)
#define JOINT(f) offsetof(daft_sim_joint, f)
    return TRUTHS(w->bodies, h->bodies, BODY(bullet), BODY(may_sleep), BODY(asleep), BODY(round), BODY(has_target),
                  BODY(follows), BODY(ball), BODY(joined_far)) &&
           TRUTHS(w->parts, h->parts, PART(round), PART(posed), PART(sensor)) &&
           TRUTHS(w->pairs, h->pairs, PAIR(sensor), PAIR(active), PAIR(owned_by_a), PAIR(touching),
                  PAIR(materials_cached), PAIR(surface_moves)) &&
           TRUTHS(w->joints, h->joints, JOINT(limit), JOINT(motor), JOINT(spring), JOINT(collide));
#undef BODY
#undef PART
#undef PAIR
#undef JOINT
}

static bool read_records(daft_world *w, reader *r, const header *h)
{
    bool good = true;
    size_t unused;
    w->bodies = take(w, r, h->bodies, sizeof *w->bodies, &w->body_capacity, &good);
    w->parts = take(w, r, h->parts, sizeof *w->parts, &w->part_capacity, &good);
    w->fat = take(w, r, h->parts, sizeof *w->fat, &w->fat_capacity, &good);
    w->tight = take(w, r, h->parts, sizeof *w->tight, &w->tight_capacity, &good);
    w->pairs = take(w, r, h->pairs, sizeof *w->pairs, &w->pair_capacity, &good);
    for (uint32_t i = 0; w->pairs && i < h->pairs; i++) {
        bool more = w->pairs[i].more != NULL;
        w->pairs[i].more = NULL;
        w->pair_count = i + 1; /* what destroying the world looks at */
        if (more) w->pairs[i].more = take(w, r, DAFT_SIM_MAX_MANIFOLDS, sizeof(daft_sim_manifold), &unused, &good);
    }
    w->joints = take(w, r, h->joints, sizeof *w->joints, &w->joint_capacity, &good);
    w->awake.items = take(w, r, h->awake, sizeof *w->awake.items, &w->awake.capacity, &good);
    w->movers.items = take(w, r, h->movers, sizeof *w->movers.items, &w->movers.capacity, &good);
    w->moved.items = take(w, r, h->moved, sizeof *w->moved.items, &w->moved.capacity, &good);
    if (h->has_pairs)
        w->material_pairs =
            take(w, r, DAFT_SIM_MATERIAL_KINDS * DAFT_SIM_MATERIAL_KINDS, sizeof *w->material_pairs, &unused, &good);
    w->body_count = h->bodies, w->part_count = h->parts, w->joint_count = h->joints;
    w->awake.count = h->awake, w->movers.count = h->movers, w->moved.count = h->moved;
    w->free_body = h->free_body, w->free_part = h->free_part;
    w->free_pair = h->free_pair, w->free_joint = h->free_joint;
    w->live_bodies = h->live_bodies, w->live_joints = h->live_joints;
    w->sleeping = h->sleeping != 0, w->substeps = h->substeps, w->gravity = h->gravity;
    return good && r->left == 0 && check_truths(w, h);
}

/* ---- loading: checks ---- */

static bool all_finite(const float *values, size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (!isfinite(values[i])) return false;
    return true;
}

static bool unit(daft_quat q) { return fabsf(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w - 1) < 1e-3f; }

static bool near(daft_dvec3 p)
{
    return fabs(p.x) <= 1.1 * DAFT_SIM_MAX_DISTANCE && fabs(p.y) <= 1.1 * DAFT_SIM_MAX_DISTANCE &&
           fabs(p.z) <= 1.1 * DAFT_SIM_MAX_DISTANCE;
}

static bool check_body(daft_world *w, uint32_t index)
{
    daft_sim_body *b = &w->bodies[index];
    if (b->kind == DAFT_BODY_NONE) return true;
    const float numbers[] = {b->linear.x,       b->linear.y,        b->linear.z,       b->angular.x, b->angular.y,
                             b->angular.z,      b->force.x,         b->force.y,        b->force.z,   b->torque.x,
                             b->torque.y,       b->torque.z,        b->gravity_scale,  b->rest,      b->wanted_mass,
                             b->linear_damping, b->angular_damping, b->substep_demand, b->h,         b->gone.x,
                             b->gone.y,         b->gone.z,          b->turned.x,       b->turned.y,  b->turned.z};
    if (b->kind > DAFT_BODY_DYNAMIC || !all_finite(numbers, DAFT_COUNT_OF(numbers)) || !unit(b->rotation) ||
        !near(b->position) || !near(b->centre) || b->linear_damping < 0 || b->angular_damping < 0 ||
        b->wanted_mass < 0 || !(b->substep_demand >= 0 && b->substep_demand <= DAFT_SIM_FINEST) || b->h < 0 ||
        (b->asleep && (b->kind != DAFT_BODY_DYNAMIC || b->ring >= w->body_count)))
        return false;
    if (b->has_target && (!near(b->target_position) || !unit(b->target_rotation))) return false;
    uint32_t parts = 0;
    for (uint32_t i = b->first_part; i != DAFT_SIM_NONE; i = w->parts[i].next)
        if (i >= w->part_count || w->parts[i].body != index || ++parts > w->part_count) return false;
    daft_dvec3 centre = b->centre;
    daft_error ignored;
    if (!daft_sim_body_weigh(w, b, &ignored)) return false;
    daft_sim_body_place(b, b->position, b->rotation);
    b->centre = centre;
    b->first_pair = b->first_joint = b->list_slot = DAFT_SIM_NONE;
    b->locks &= DAFT_LOCK_ROTATION | DAFT_LOCK_POSITION;
    b->joined = 0, b->joined_far = false;
    b->fixed_pairs = 0;
    w->asleep_count += b->asleep;
    return true;
}

static bool check_part(daft_world *w, uint32_t index, daft_sim_find_shape *find, void *context)
{
    daft_sim_part *p = &w->parts[index];
    if (p->body == DAFT_SIM_NONE) return true;
    if (p->body >= w->body_count || w->bodies[p->body].kind == DAFT_BODY_NONE) return false;
    daft_geometry type = p->shape.type;
    if (type >= DAFT_GEOMETRY_HULL && type <= DAFT_GEOMETRY_COMPOUND &&
        (!find || !find(context, p->geometry_id, type, &p->shape) || p->shape.type != type))
        return false;
    daft_sim_shape_def def = {.shape = p->shape,
                              .position = p->place,
                              .rotation = p->turn,
                              .density = p->density,
                              .material = p->material,
                              .layers = p->layers,
                              .mask = p->mask,
                              .sensor = p->sensor,
                              .user = p->user,
                              .geometry_id = p->geometry_id};
    daft_error ignored;
    if (!daft_sim_shape_check(&def, w->bodies[p->body].kind, &ignored)) return false;
    uint32_t next = p->next, body = p->body, moved = p->moved_slot;
    const daft_sim_bounds *fat = &w->fat[index], *tight = &w->tight[index];
    if (!near(fat->low) || !near(fat->high) || !near(tight->low) || !near(tight->high)) return false;
    daft_sim_part_fill(p, &def, body);
    p->next = next, p->moved_slot = moved;
    return true;
}

static bool check_manifolds(daft_sim_pair *t)
{
    if (t->manifold_count > (t->more ? DAFT_SIM_MAX_MANIFOLDS : 1u)) return false;
    for (uint32_t i = 0; i < t->manifold_count && !t->sensor; i++) {
        const daft_sim_manifold *p = &daft_sim_manifolds(t)[i];
        if (p->count == 0 || p->count > DAFT_MANIFOLD_POINTS) return false;
        const float numbers[] = {p->normal.x,
                                 p->normal.y,
                                 p->normal.z,
                                 p->twist_impulse,
                                 p->friction_impulse.x,
                                 p->friction_impulse.y,
                                 p->friction_impulse.z,
                                 p->twist_slip,
                                 p->rolling_impulse.x,
                                 p->rolling_impulse.y,
                                 p->rolling_impulse.z,
                                 p->slip.x,
                                 p->slip.y,
                                 p->slip.z,
                                 p->total_impulse,
                                 p->speed,
                                 p->load};
        if (!all_finite(numbers, DAFT_COUNT_OF(numbers)) || p->load < 0) return false;
        for (uint32_t k = 0; k < p->count; k++) {
            const daft_sim_manifold_point *q = &p->points[k];
            if (!daft_finite3(q->anchor) || !isfinite(q->separation) || !isfinite(q->impulse)) return false;
        }
    }
    return true;
}

static bool check_joint(const daft_world *w, const daft_sim_joint *j)
{
    if (j->kind == 0) return true;
    if (j->kind > DAFT_JOINT_DRAG || !daft_dfinite3(j->fixed)) return false;
    const float numbers[] = {j->lower,
                             j->upper,
                             j->motor_speed,
                             j->motor_force,
                             j->hertz,
                             j->damping,
                             j->length,
                             j->break_force,
                             j->break_torque,
                             j->motor_impulse,
                             j->lower_impulse,
                             j->upper_impulse,
                             j->spring_impulse,
                             j->force,
                             j->torque,
                             j->linear_impulse.x,
                             j->linear_impulse.y,
                             j->linear_impulse.z,
                             j->angular_impulse.x,
                             j->angular_impulse.y,
                             j->angular_impulse.z,
                             j->spin[0].x,
                             j->spin[0].y,
                             j->spin[0].z,
                             j->spin[1].x,
                             j->spin[1].y,
                             j->spin[1].z};
    if (!all_finite(numbers, DAFT_COUNT_OF(numbers)) || j->hertz < 0 || j->damping < 0) return false;
    bool dynamic = false;
    for (int side = 0; side < 2; side++) {
        if (!unit(j->frame[side]) || !daft_finite3(j->anchor[side])) return false;
        if (j->body[side] == DAFT_SIM_NONE) continue;
        if (j->body[side] >= w->body_count || w->bodies[j->body[side]].kind == DAFT_BODY_NONE) return false;
        dynamic |= w->bodies[j->body[side]].kind == DAFT_BODY_DYNAMIC;
    }
    return dynamic && j->body[0] != j->body[1];
}

/* Free slots are a chain that ends, and there are as many as there must be. */
static bool check_chain(const daft_world *w, int what, uint32_t first, uint32_t count, uint32_t live)
{
    uint32_t found = 0;
    for (uint32_t i = first; i != DAFT_SIM_NONE; found++) {
        if (i >= count || found > count) return false;
        bool is_free = what == 0   ? w->bodies[i].kind == DAFT_BODY_NONE
                       : what == 1 ? w->parts[i].body == DAFT_SIM_NONE
                       : what == 2 ? w->pairs[i].part_a == DAFT_SIM_NONE
                                   : w->joints[i].kind == 0;
        if (!is_free) return false;
        i = what == 0   ? w->bodies[i].next_free
            : what == 1 ? w->parts[i].next
            : what == 2 ? w->pairs[i].next[0]
                        : w->joints[i].next[0];
    }
    return found + live == count;
}

/* ---- loading: what hangs on the records ---- */

static bool enter_lists(daft_world *w)
{
    size_t dynamic = 0;
    for (uint32_t i = 0; i < w->body_count; i++)
        dynamic += w->bodies[i].kind == DAFT_BODY_DYNAMIC && !w->bodies[i].asleep;
    if (dynamic != w->awake.count) return false;
    const daft_sim_list *lists[] = {&w->awake, &w->movers};
    for (int k = 0; k < 2; k++)
        for (size_t i = 0; i < lists[k]->count; i++) {
            uint32_t index = lists[k]->items[i];
            if (index >= w->body_count) return false;
            daft_sim_body *body = &w->bodies[index];
            if (body->kind != (k ? DAFT_BODY_KINEMATIC : DAFT_BODY_DYNAMIC) || body->asleep ||
                body->list_slot != DAFT_SIM_NONE)
                return false;
            body->list_slot = (uint32_t)i;
        }
    return daft_sim_list_reserve(w, &w->awake, w->body_count) && daft_sim_list_reserve(w, &w->movers, w->body_count) &&
           daft_grow(&w->allocator, &w->scratch.island_parents, &w->scratch.island_capacity, w->body_count, 0,
                     sizeof *w->scratch.island_parents);
}

static bool enter_parts(daft_world *w)
{
    if (!daft_grow(&w->allocator, &w->slots, &w->slots_capacity, w->part_count, 0, sizeof *w->slots) ||
        !daft_sim_list_reserve(w, &w->moved, w->part_count) ||
        !daft_sim_list_reserve(w, &w->scratch.astray, w->part_count) || !daft_sim_outlines_reserve(w, w->part_count))
        return false;
    w->newcomers = true;
    for (uint32_t i = 0; i < w->part_count; i++) {
        daft_sim_part *part = &w->parts[i];
        w->slots[i] = DAFT_SIM_NONE;
        if (part->body == DAFT_SIM_NONE) continue;
        uint32_t slot = part->moved_slot;
        if (slot != DAFT_SIM_NONE && (slot >= w->moved.count || w->moved.items[slot] != i)) return false;
        daft_sim_tree *tree = &w->trees[w->bodies[part->body].kind];
        if (!daft_sim_tree_reserve(tree, &w->allocator, 1)) return false;
        part->leaf = daft_sim_tree_insert(tree, &w->fat[i], i);
        part->dynamic = w->bodies[part->body].kind == DAFT_BODY_DYNAMIC;
        daft_rigid frame = daft_sim_part_frame(&w->bodies[part->body], part);
        daft_sim_outline_set(w, i, &frame, 0);
    }
    for (size_t i = 0; i < w->moved.count; i++)
        if (w->moved.items[i] >= w->part_count || w->parts[w->moved.items[i]].body == DAFT_SIM_NONE ||
            w->parts[w->moved.items[i]].moved_slot != i)
            return false;
    return true;
}

/* As groups.c has them: a dynamic one first, the sensor first, else the lower index. */
static bool is_in_order(const daft_sim_pair *t, const daft_sim_part *a, const daft_sim_part *b)
{
    if (t->sensor) return a->sensor && !b->sensor;
    return a->dynamic && (!b->dynamic || t->part_a < t->part_b);
}

static int by_value(const void *p, const void *q)
{
    uint64_t a = *(const uint64_t *)p, b = *(const uint64_t *)q;
    return (a > b) - (a < b);
}

/* No pair may touch twice. */
static bool differ(daft_world *w, uint32_t live)
{
    size_t count = 0;
    if (!daft_grow(&w->allocator, &w->scratch.candidates, &w->scratch.candidate_capacity, live, 0,
                   sizeof *w->scratch.candidates))
        return false;
    for (uint32_t i = 0; i < w->pair_count; i++)
        if (w->pairs[i].part_a != DAFT_SIM_NONE) w->scratch.candidates[count++] = daft_sim_pair_key(&w->pairs[i]);
    if (count > 1) qsort(w->scratch.candidates, count, sizeof *w->scratch.candidates, by_value);
    for (size_t i = 1; i < count; i++)
        if (w->scratch.candidates[i - 1] == w->scratch.candidates[i]) return false;
    return true;
}

/* Records whose slots are checked already are linked where they stand. */
static bool enter_pairs(daft_world *w, uint32_t live)
{
    if (live > w->pair_count || !daft_sim_pairs_reserve(w, 0)) return false;
    for (uint32_t i = 0; i < w->pair_count; i++) {
        daft_sim_pair *t = &w->pairs[i];
        if (t->part_a == DAFT_SIM_NONE) continue;
        if (t->part_a >= w->part_count || t->part_b >= w->part_count || t->part_a == t->part_b) return false;
        const daft_sim_part *a = &w->parts[t->part_a], *b = &w->parts[t->part_b];
        if (a->body == DAFT_SIM_NONE || b->body == DAFT_SIM_NONE || a->body == b->body) return false;
        if (t->sensor != (a->sensor || b->sensor)) return false;
        t->body_a = a->body, t->body_b = b->body;
        if (!is_in_order(t, a, b) || !check_manifolds(t)) return false;
        daft_sim_pair_enter(w, i);
    }
    return w->live_pairs == live && differ(w, live);
}

static bool enter_joints(daft_world *w)
{
    for (uint32_t i = 0; i < w->joint_count; i++) {
        if (!check_joint(w, &w->joints[i])) return false;
        if (w->joints[i].kind) daft_sim_joint_link(w, i);
    }
    return true;
}

static bool rebuild(daft_world *w, const header *h, daft_sim_find_shape *find, void *context)
{
    uint32_t live_parts = 0;
    for (uint32_t i = 0; i < w->part_count; i++) {
        if (!check_part(w, i, find, context)) return false;
        live_parts += w->parts[i].body != DAFT_SIM_NONE;
    }
    for (uint32_t i = 0; i < w->body_count; i++)
        if (!check_body(w, i)) return false;
    for (uint32_t i = 0; w->material_pairs && i < DAFT_SIM_MATERIAL_KINDS * DAFT_SIM_MATERIAL_KINDS; i++)
        if (!all_finite((const float *)&w->material_pairs[i], 4)) return false;
    return check_chain(w, 0, h->free_body, h->bodies, h->live_bodies) &&
           check_chain(w, 1, h->free_part, h->parts, live_parts) &&
           check_chain(w, 2, h->free_pair, h->pairs, h->live_pairs) &&
           check_chain(w, 3, h->free_joint, h->joints, h->live_joints) && enter_lists(w) && enter_parts(w) &&
           enter_pairs(w, h->live_pairs) && enter_joints(w);
}

static bool check_header(const header *h, const unsigned char *bytes, size_t size)
{
    return h->magic == MAGIC && h->version == VERSION && h->layout == layout() && h->size == size &&
           h->hash == daft_hash(bytes, size, 0) && h->substeps >= 1 && h->substeps <= DAFT_SIM_MAX_SUBSTEPS &&
           daft_finite3(h->gravity) && h->bodies < INT32_MAX && h->parts < INT32_MAX && h->pairs < INT32_MAX &&
           h->joints < INT32_MAX;
}

bool daft_world_load(daft_world *world, const void *bytes, size_t size, daft_sim_find_shape *find, void *context,
                     daft_error *error)
{
    header h;
    const unsigned char *at = bytes;
    if (!bytes || size < sizeof h)
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "simulation state: %zu bytes are too few", size);
    memcpy(&h, at, sizeof h);
    if (!check_header(&h, at + sizeof h, size - sizeof h))
        return daft_fail(error, DAFT_ERROR_ARGUMENT,
                         "simulation state: the bytes are damaged, or from another build of the engine");
    daft_world *fresh = daft_world_create(&world->allocator, error);
    if (!fresh) return false;
    reader r = {at + sizeof h, size - sizeof h};
    if (!read_records(fresh, &r, &h) || !rebuild(fresh, &h, find, context)) {
        daft_world_destroy(fresh);
        return daft_fail(error, DAFT_ERROR_ARGUMENT,
                         "simulation state: memory is out, a shape was not found, or the bytes make no sense");
    }
    fresh->workers = world->workers, fresh->isa = world->isa;
    fresh->sleep_changed = true;
    daft_world swap = *world;
    *world = *fresh;
    *fresh = swap;
    daft_world_destroy(fresh);
    return true;
}

/* ---- the hash ---- */

uint64_t daft_world_hash(const daft_world *world, uint64_t seed)
{
    uint64_t hash = daft_hash(&world->body_count, sizeof world->body_count, seed);
    for (uint32_t i = 0; i < world->body_count; i++) {
        const daft_sim_body *body = &world->bodies[i];
        if (body->kind == DAFT_BODY_NONE) continue;
        const double position[] = {body->position.x, body->position.y, body->position.z};
        const float rest[] = {body->rotation.x, body->rotation.y, body->rotation.z, body->rotation.w, body->linear.x,
                              body->linear.y,   body->linear.z,   body->angular.x,  body->angular.y,  body->angular.z};
        const uint32_t flags[] = {i, body->asleep};
        hash = daft_hash(flags, sizeof flags, hash);
        hash = daft_hash(position, sizeof position, hash);
        hash = daft_hash(rest, sizeof rest, hash);
    }
    return hash;
}
