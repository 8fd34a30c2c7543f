/* What manifolds found anew have of those of the step before. Points are known again by the features that made them.
 * What a point carried that is not there any more goes to those beside it: two capsules that lie along each other touch
 * in two points in one step and in one in the next, and a load of a thousand newtons that is forgotten whenever they do
 * is a blow that keeps a pile of ragdolls awake. */
#include "sim/contact/persistence.h"

#include <math.h>

/* ---- where contacts go within the step ---- */

/* Manifolds are found once a step, so what rolls is held in all of its substeps where it was when they began: on the
 * mean of n substeps (n - 1)/(2n) of a step too late, by which whatever sways gains amplitude, omega²/2 of that delay
 * in a second: a box on a ball rocked until it fell off. So points and normals are put ahead by as much as they go in
 * that time, which is found from where they were put in the step before: x + k (x - before) is ahead by k/(k + 1) of a
 * step. A little more than what is wanted makes the swaying fade, much more would amplify what trembles, by (1 + k)/(1
 * - k). Islands that take more substeps than the world's are put ahead by more: the last step says in how many (b
 * may be one that does not move). */
#define LEAD_FADES 0.05f
#define LEAD_ALONE 0.04f /* with one substep: all of it fades */
#define MAX_LEAD   0.9f
#define SMOOTH     0.3f /* of its length: what has changed by more is another place */

float daft_sim_extrapolation(const daft_world *world, const daft_sim_pair *pair, float dt)
{
    float h = world->bodies[pair->body_a].h,
          n = h > 0 ? floorf(daft_sim_min(dt / h, 99) + 0.5f) : (float)world->substeps;
    return n > 1 ? daft_sim_min((n - 1) / (n + 1) + LEAD_FADES, MAX_LEAD) : LEAD_ALONE;
}

static daft_vec3 ahead(daft_vec3 now, daft_vec3 before, float lead)
{
    daft_vec3 change = daft_sub(now, before);
    if (daft_dot(change, change) > SMOOTH * SMOOTH * daft_dot(now, now)) return now;
    return daft_add(now, daft_scale(change, lead));
}

/* Of unit length, as both are: the square of x + k (x - before) is 1 + k (1 + k) (x - before)². */
static daft_vec3 normal_ahead(daft_vec3 now, daft_vec3 before, float lead)
{
    daft_vec3 change = daft_sub(now, before);
    float square = daft_dot(change, change);
    if (square > SMOOTH * SMOOTH) return now;
    return daft_scale(daft_add(now, daft_scale(change, lead)), 1 / sqrtf(1 + lead * (1 + lead) * square));
}

/* ---- points ---- */

#define BESIDE 0.5f /* of its arm: what is farther from a point than this has nothing of it */

/* What a point carried goes to the one nearest to where it was, and to the next, by where it was between them. */
static void pass_on(daft_sim_manifold *manifold, daft_vec3 anchor, float impulse)
{
    float squares[2] = {INFINITY, INFINITY};
    daft_sim_manifold_point *nearest[2] = {NULL, NULL};
    for (uint32_t i = 0; i < manifold->count; i++) {
        daft_vec3 d = daft_sub(manifold->points[i].anchor, anchor);
        float square = daft_dot(d, d);
        uint32_t place = square < squares[0] ? 0 : 1;
        if (!(square < squares[place])) continue;
        if (place == 0) squares[1] = squares[0], nearest[1] = nearest[0];
        squares[place] = square, nearest[place] = &manifold->points[i];
    }
    if (!(squares[0] < BESIDE * BESIDE * daft_dot(anchor, anchor))) return;
    float fraction = 0;
    if (nearest[1]) {
        daft_vec3 from = nearest[0]->anchor, span = daft_sub(nearest[1]->anchor, from);
        float square = daft_dot(span, span), along = daft_dot(daft_sub(anchor, from), span);
        fraction = along > 0 && square > 0 ? daft_sim_min(along / square, 0.5f) : 0;
        nearest[1]->impulse += fraction * impulse;
    }
    nearest[0]->impulse += (1 - fraction) * impulse;
}

void daft_sim_persisted_set(daft_sim_persisted *out, const daft_sim_manifold *manifold, uint32_t count, float lead)
{
    out->normal = manifold->normal, out->lead = lead, out->count = count, out->left = 0;
    for (uint32_t k = 0; k < count; k++) {
        const daft_sim_manifold_point *point = &manifold->points[k];
        out->ids[k] = point->id, out->impulses[k] = point->impulse, out->anchors[k] = point->anchor;
        out->left |= (uint32_t)(point->impulse > 0) << k;
    }
}

void daft_sim_persisted_put(daft_sim_persisted *old, daft_sim_manifold *manifold, daft_sim_manifold_point point)
{
    for (uint32_t k = 0; k < old->count; k++) {
        if (old->ids[k] != point.id) continue;
        point.impulse = old->impulses[k];
        point.anchor = ahead(point.anchor, old->anchors[k], old->lead);
        old->left &= ~(1u << k);
    }
    manifold->points[manifold->count++] = point;
}

void daft_sim_persisted_end(const daft_sim_persisted *old, daft_sim_manifold *manifold)
{
    for (uint32_t left = old->left; left; left &= left - 1) {
        uint32_t k = (uint32_t)__builtin_ctz(left);
        pass_on(manifold, old->anchors[k], old->impulses[k]);
    }
    if (old->count > 0) manifold->normal = normal_ahead(manifold->normal, old->normal, old->lead);
}

/* ---- manifolds ---- */

static bool same_shape(const daft_sim_manifold *a, const daft_sim_manifold *b)
{
    return a->part_a.child == b->part_a.child && a->part_b.child == b->part_b.child;
}

static bool same_parts(const daft_sim_manifold *a, const daft_sim_manifold *b)
{
    return same_shape(a, b) && a->part_a.triangle == b->part_a.triangle && a->part_b.triangle == b->part_b.triangle;
}

/* Friction carries over, too; the solver projects it onto the new plane. */
static void persist_manifold(daft_sim_manifold *manifold, const daft_sim_manifold *old, float lead)
{
    manifold->friction_impulse = old->friction_impulse;
    manifold->rolling_impulse = old->rolling_impulse;
    manifold->twist_impulse = old->twist_impulse;
    manifold->slip = old->slip;
    manifold->twist_slip = old->twist_slip;
    manifold->load = old->load;
    daft_sim_persisted kept;
    daft_sim_persisted_set(&kept, old, old->count, lead);
    uint32_t count = manifold->count;
    manifold->count = 0;
    for (uint32_t i = 0; i < count; i++) daft_sim_persisted_put(&kept, manifold, manifold->points[i]);
    daft_sim_persisted_end(&kept, manifold);
}

#define SAME_PLANE 0.98f /* cosine */

/* What a body rests on may be told by another triangle now: of the manifolds that are left, the one of about its plane.
 */
static uint32_t of_plane(const daft_sim_manifold *manifold, const daft_sim_manifold *old, uint32_t left)
{
    uint32_t best = DAFT_SIM_MAX_MANIFOLDS;
    float most = SAME_PLANE;
    for (; left; left &= left - 1) {
        uint32_t at = (uint32_t)__builtin_ctz(left);
        float cosine = daft_dot(manifold->normal, old[at].normal);
        if (cosine > most && same_shape(manifold, &old[at])) best = at, most = cosine;
    }
    return best;
}

void daft_sim_persist(daft_sim_manifold *fresh, uint32_t count, const daft_sim_manifold *old, uint32_t old_count,
                      float lead)
{
    uint32_t left = (1u << old_count) - 1, orphans = 0;
    for (uint32_t i = 0; i < count && old_count > 0; i++) {
        uint32_t at = 0;
        while (at < old_count && !same_parts(&fresh[i], &old[at])) at++;
        if (at == old_count) {
            orphans |= 1u << i;
            continue;
        }
        left &= ~(1u << at);
        persist_manifold(&fresh[i], &old[at], lead);
    }
    for (; orphans && left; orphans &= orphans - 1) {
        daft_sim_manifold *manifold = &fresh[__builtin_ctz(orphans)];
        uint32_t at = of_plane(manifold, old, left);
        if (at == DAFT_SIM_MAX_MANIFOLDS) continue;
        left &= ~(1u << at);
        persist_manifold(manifold, &old[at], lead);
    }
}
