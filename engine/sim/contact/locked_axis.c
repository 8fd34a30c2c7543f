/* Contacts of bodies that may not move along some axis of the world, as in a game in a plane. What presses them
 * together along it can push nothing, so it must not ask to: an impulse that never has an effect only grows, and lets
 * friction hold what nothing holds. So normals lie in what is free, and separations are those along them. Two that are
 * within each other beside their plane, whose shortest way out is out of it, part along the line between their middles.
 */
#include "sim/world.h"
#include "sim/contact/contact.h"

#define MIN_FREE 0.3f /* of a normal: what leans away from the plane by more is beside it */

/* Bits of the axes along which no push moves any point of it: it would turn the body about the others. */
static uint32_t locked_along(const daft_sim_body *body)
{
    uint32_t along = body->locks / DAFT_LOCK_POSITION_X & 7, about = body->locks / DAFT_LOCK_X & 7, held = 0;
    if (body->kind != DAFT_BODY_DYNAMIC) return 7;
    for (uint32_t k = 0; k < 3; k++)
        if (along >> k & 1 && (about | 1u << k) == 7) held |= 1u << k;
    return held;
}

static daft_vec3 free_part(daft_vec3 v, uint32_t locks)
{
    return daft_v3(locks & 1 ? 0 : v.x, locks & 2 ? 0 : v.y, locks & 4 ? 0 : v.z);
}

static daft_dvec3 middle_of(const daft_sim_body *body, const daft_sim_part *part)
{
    daft_rigid frame = daft_sim_part_frame(body, part);
    return daft_rigid_point(&frame, daft_to_double(part->middle));
}

/* The balls within them, as they are seen along what is locked. */
static void part_middles(const daft_world *world, const daft_sim_pair *pair, uint32_t locks,
                         daft_sim_manifold *manifold)
{
    const daft_sim_part *a = &world->parts[pair->part_a], *b = &world->parts[pair->part_b];
    const daft_sim_body *body = &world->bodies[pair->body_a];
    daft_dvec3 from = middle_of(body, a), to = middle_of(&world->bodies[pair->body_b], b);
    daft_vec3 apart = free_part(daft_to_float(daft_dsub(to, from)), locks);
    float deepest = 0, length = daft_length(apart), separation = length - (a->inner + b->inner);
    for (uint32_t i = 0; i < manifold->count; i++) deepest = daft_sim_min(deepest, manifold->points[i].separation);
    manifold->count = 0;
    if (!(separation < 0) || -deepest < daft_sim_min(a->inner, b->inner)) return; /* side by side */
    manifold->normal =
        length > 1e-4f * a->inner ? daft_scale(apart, 1 / length) : daft_normalize(free_part(daft_v3(1, 2, 3), locks));
    daft_dvec3 at = daft_dadd(from, daft_to_double(daft_scale(apart, 0.5f)));
    manifold->points[manifold->count++] =
        (daft_sim_manifold_point){.anchor = daft_to_float(daft_dsub(at, body->centre)), .separation = separation};
}

void daft_sim_lock_axes(const daft_world *world, const daft_sim_pair *pair, daft_sim_manifold *manifold)
{
    const daft_sim_body *a = &world->bodies[pair->body_a], *b = &world->bodies[pair->body_b];
    uint32_t locks = locked_along(a) & locked_along(b);
    daft_vec3 normal = free_part(manifold->normal, locks);
    float length = daft_length(normal);
    if (locks == 0) return;
    if (locks == 7) {
        manifold->count = 0;
        return;
    }
    if (length < MIN_FREE) {
        part_middles(world, pair, locks, manifold);
        return;
    }
    manifold->normal = daft_scale(normal, 1 / length);
    for (uint32_t i = 0; i < manifold->count; i++) manifold->points[i].separation /= length;
}
