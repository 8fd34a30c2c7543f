/* The scenes of the simulation's benchmarks, and the faults of an engine's poses. */
#include "sim_scenes.h"

#include "math/trig.h"
#include "sim/collide/manifold.h"

#include <stdlib.h>

/* ---- making them ---- */

static float noise(uint64_t *state) /* -1..1 */
{
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return (float)(*state >> 40) * 0x1p-23f - 1;
}

static bool add_body(bench *self, sim_scene *scene, daft_sim_shape shape, daft_dvec3 position, daft_quat rotation)
{
    if (!daft_grow(&self->allocator, &scene->bodies, &scene->body_capacity, scene->body_count + 1u, scene->body_count,
                   sizeof *scene->bodies))
        return false;
    scene->bodies[scene->body_count++] = (sim_body){.shape = shape, .position = position, .rotation = rotation};
    return true;
}

static bool add_joint(bench *self, sim_scene *scene, sim_joint joint)
{
    if (!daft_grow(&self->allocator, &scene->joints, &scene->joint_capacity, scene->joint_count + 1u,
                   scene->joint_count, sizeof *scene->joints))
        return false;
    scene->joints[scene->joint_count++] = joint;
    return true;
}

static daft_sim_shape box_of(float x, float y, float z)
{
    daft_sim_shape shape;
    daft_shape_box(daft_v3(x, y, z), &shape, NULL);
    return shape;
}

/* Boxes of 1 m, turned at random, in a block so loose that none touches another; they fall between walls. */
bool bench_sim_heap(bench *self, uint32_t columns, uint32_t rows, uint32_t layers, sim_scene *out)
{
    const double pitch = 1.75; /* a little more than a box's diagonal */
    uint64_t state = 11;
    bool good = true;
    *out = (sim_scene){.half = {0.5 * pitch * columns, 0.5 * pitch * rows}};
    for (uint32_t i = 0; good && i < columns * rows * layers; i++) {
        float x = noise(&state), y = noise(&state), z = noise(&state);
        daft_quat turn = daft_quat_normalize((daft_quat){x, y, z, noise(&state)});
        daft_dvec3 at = daft_dv3(pitch * (i % columns + 0.5) - out->half[0], pitch * (i / (columns * rows) + 0.6),
                                 pitch * (i / columns % rows + 0.5) - out->half[1]);
        good = add_body(self, out, box_of(0.5f, 0.5f, 0.5f), at, turn);
    }
    return good;
}

bool bench_sim_stack(bench *self, uint32_t boxes, sim_scene *out)
{
    bool good = true;
    *out = (sim_scene){0};
    for (uint32_t i = 0; good && i < boxes; i++)
        good = add_body(self, out, box_of(0.5f, 0.5f, 0.5f), daft_dv3(0, 0.5 + i, 0), daft_quat_identity());
    return good;
}

bool bench_sim_sleepers(bench *self, uint32_t count, sim_scene *out)
{
    bool good = true;
    *out = (sim_scene){.sleeping = true};
    for (uint32_t i = 0; good && i <= count; i++) {
        daft_dvec3 at = daft_dv3(2.0 * (i % 100) - 100, 0.5, 2.0 * (i / 100) - 100);
        good = add_body(self, out, box_of(0.5f, 0.5f, 0.5f), at, daft_quat_identity());
        if (good) out->bodies[i].asleep = i < count, out->bodies[i].restless = i == count;
    }
    return good;
}

/* ---- ragdolls ---- */

enum { PELVIS, CHEST, HEAD, ARM, LEG = ARM + 4, PARTS = LEG + 4 }; /* limbs: left upper, lower, right upper, lower */

/* A limb of two capsules along y, hung on `trunk`; the lower one bends one way. */
static bool add_limb(bench *self, sim_scene *scene, uint32_t trunk, daft_dvec3 top, float half, float radius,
                     float bend)
{
    daft_sim_shape shape;
    daft_shape_capsule(half, radius, &shape, NULL);
    uint32_t upper = scene->body_count;
    double reach = 2 * ((double)half + (double)radius);
    sim_joint root = {.a = trunk, .b = upper, .anchor = top};
    sim_joint middle = {.a = upper,
                        .b = upper + 1,
                        .anchor = daft_dv3(top.x, top.y - reach, top.z),
                        .hinge = true,
                        .axis = daft_v3(1, 0, 0),
                        .lower = bend < 0 ? bend : 0,
                        .upper = bend < 0 ? 0 : bend};
    return add_body(self, scene, shape, daft_dv3(top.x, top.y - 0.5 * reach, top.z), daft_quat_identity()) &&
           add_body(self, scene, shape, daft_dv3(top.x, top.y - 1.5 * reach, top.z), daft_quat_identity()) &&
           add_joint(self, scene, root) && add_joint(self, scene, middle);
}

/* About 1.8 m tall, standing; `at`: its hips. */
static bool add_ragdoll(bench *self, sim_scene *scene, daft_dvec3 at)
{
    uint32_t first = scene->body_count;
    daft_quat straight = daft_quat_identity();
    daft_sim_shape head;
    daft_shape_sphere(0.11f, &head, NULL);
    bool good = add_body(self, scene, box_of(0.17f, 0.1f, 0.1f), at, straight) &&
                add_body(self, scene, box_of(0.18f, 0.24f, 0.11f), daft_dv3(at.x, at.y + 0.36, at.z), straight) &&
                add_body(self, scene, head, daft_dv3(at.x, at.y + 0.75, at.z), straight);
    sim_joint waist = {.a = first + PELVIS, .b = first + CHEST, .anchor = daft_dv3(at.x, at.y + 0.11, at.z)};
    sim_joint neck = {.a = first + CHEST, .b = first + HEAD, .anchor = daft_dv3(at.x, at.y + 0.62, at.z)};
    good = good && add_joint(self, scene, waist) && add_joint(self, scene, neck);
    for (int side = -1; side <= 1; side += 2)
        good = good && add_limb(self, scene, first + CHEST, daft_dv3(at.x + 0.26 * side, at.y + 0.55, at.z), 0.1f,
                                0.05f, -2.4f);
    for (int side = -1; side <= 1; side += 2)
        good = good && add_limb(self, scene, first + PELVIS, daft_dv3(at.x + 0.1 * side, at.y - 0.12, at.z), 0.14f,
                                0.07f, 2.4f);
    return good;
}

bool bench_sim_ragdolls(bench *self, uint32_t count, sim_scene *out)
{
    uint64_t state = 5;
    bool good = true;
    *out = (sim_scene){0};
    for (uint32_t i = 0; good && i < count; i++) {
        double x = 0.2 * (double)noise(&state), z = 0.2 * (double)noise(&state);
        good = add_ragdoll(self, out, daft_dv3(1.1 * (i % 10) + x, 3 + 2.2 * (i / 100), 1.1 * (i / 10 % 10) + z));
    }
    return good;
}

void bench_sim_scene_free(bench *self, sim_scene *scene)
{
    daft_release(&self->allocator, scene->bodies);
    daft_release(&self->allocator, scene->joints);
    *scene = (sim_scene){0};
}

/* ---- looking at poses ---- */

typedef struct placed {
    double low, high; /* along x */
    daft_daabb bounds;
    daft_rigid pose;
    uint32_t body;
} placed;

static int by_low(const void *a, const void *b)
{
    double x = ((const placed *)a)->low, y = ((const placed *)b)->low;
    return (x > y) - (x < y);
}

static bool joined(const sim_scene *scene, uint32_t a, uint32_t b)
{
    for (uint32_t i = 0; i < scene->joint_count; i++) {
        const sim_joint *j = &scene->joints[i];
        if ((j->a == a && j->b == b) || (j->a == b && j->b == a)) return true;
    }
    return false;
}

static void add_pair(const daft_sim_shape *a, const daft_rigid *pa, const daft_sim_shape *b, const daft_rigid *pb,
                     sim_faults *faults)
{
    daft_manifold manifolds[4];
    daft_relpose pose = daft_relpose_make(pa, pb);
    uint32_t count = daft_collide(a, b, &pose, 0, manifolds, DAFT_COUNT_OF(manifolds), NULL);
    for (uint32_t m = 0; m < count; m++)
        for (uint32_t p = 0; p < manifolds[m].count; p++) {
            double depth = -(double)manifolds[m].points[p].separation;
            if (!(depth > 0)) continue;
            faults->deepest = fmax(faults->deepest, depth);
            faults->depth_sum += depth;
            faults->points++;
        }
}

static void look_at_joints(const sim_scene *scene, const sim_engine *engine, void *world, sim_faults *faults)
{
    for (uint32_t i = 0; i < scene->joint_count; i++) {
        const sim_joint *j = &scene->joints[i];
        const uint32_t ends[2] = {j->a, j->b};
        daft_dvec3 at[2];
        for (int k = 0; k < 2; k++) {
            const sim_body *body = &scene->bodies[ends[k]];
            daft_rigid start = daft_rigid_make(body->position, body->rotation), now = engine->pose(world, ends[k]);
            daft_dvec3 local = daft_rigid_to_local_vector(&start, daft_dsub(j->anchor, start.p));
            at[k] = daft_dadd(now.p, daft_rigid_vector(&now, local));
        }
        daft_dvec3 gap = daft_dsub(at[0], at[1]);
        faults->widest = fmax(faults->widest, sqrt(daft_ddot(gap, gap)));
    }
}

bool bench_sim_look(bench *self, const sim_scene *scene, const sim_engine *engine, void *world, sim_faults *faults)
{
    placed *all = daft_alloc(&self->allocator, scene->body_count, sizeof *all);
    if (!all) return false;
    daft_sim_shape floor = box_of(1000, 1, 1000);
    daft_rigid under = daft_rigid_make(daft_dv3(0, -1, 0), daft_quat_identity());
    for (uint32_t i = 0; i < scene->body_count; i++) {
        placed *p = &all[i];
        p->body = i, p->pose = engine->pose(world, i);
        p->bounds = daft_shape_bounds(&scene->bodies[i].shape, &p->pose);
        p->low = p->bounds.low.x, p->high = p->bounds.high.x;
        if (p->bounds.low.y < 0) add_pair(&scene->bodies[i].shape, &p->pose, &floor, &under, faults);
    }
    qsort(all, scene->body_count, sizeof *all, by_low);
    for (uint32_t i = 0; i < scene->body_count; i++)
        for (uint32_t k = i + 1; k < scene->body_count && all[k].low <= all[i].high; k++) {
            const placed *a = &all[i], *b = &all[k];
            bool apart = a->bounds.low.y > b->bounds.high.y || b->bounds.low.y > a->bounds.high.y ||
                         a->bounds.low.z > b->bounds.high.z || b->bounds.low.z > a->bounds.high.z;
            if (!apart && !joined(scene, a->body, b->body))
                add_pair(&scene->bodies[a->body].shape, &a->pose, &scene->bodies[b->body].shape, &b->pose, faults);
        }
    daft_release(&self->allocator, all);
    look_at_joints(scene, engine, world, faults);
    return true;
}
