/* Our side of the simulation's benchmarks: a scene as a world of sim/. */
#include "sim_scenes.h"

#include "math/simd/dispatch.h"

typedef struct ours {
    bench *self;
    daft_world *world;
    uint32_t *ids;
} ours;

static uint32_t add(daft_world *world, daft_body_kind kind, const sim_body *body)
{
    daft_sim_shape_def shape = daft_default_sim_shape_def();
    shape.shape = body->shape;
    daft_sim_body_def def = daft_default_sim_body_def();
    def.kind = kind, def.position = body->position, def.rotation = body->rotation, def.may_sleep = !body->restless;
    def.shapes = &shape, def.shape_count = 1;
    return daft_world_add(world, &def, NULL);
}

static bool add_joint(const ours *self, const sim_joint *joint)
{
    daft_sim_joint_def def = daft_default_sim_joint_def();
    def.kind = joint->hinge ? DAFT_JOINT_HINGE : DAFT_JOINT_BALL;
    def.body_a = self->ids[joint->a], def.body_b = self->ids[joint->b], def.anchor = joint->anchor;
    if (joint->hinge) def.axis = joint->axis, def.limit = true, def.lower = joint->lower, def.upper = joint->upper;
    return daft_world_add_joint(self->world, &def, NULL) != 0;
}

static bool add_static(daft_world *world, daft_vec3 half, daft_dvec3 position)
{
    sim_body body = {.position = position, .rotation = daft_quat_identity()};
    return daft_shape_box(half, &body.shape, NULL) && add(world, DAFT_BODY_STATIC, &body) != 0;
}

static bool add_walls(daft_world *world, double x, double z)
{
    bool good = true;
    for (int sign = -1; sign <= 1; sign += 2)
        good = good && add_static(world, daft_v3(1, 100, 1000), daft_dv3(sign * (x + 1), 99, 0)) &&
               add_static(world, daft_v3(1000, 100, 1), daft_dv3(0, 99, sign * (z + 1)));
    return good;
}

static bool fill(ours *self, const sim_scene *scene)
{
    bool good = add_static(self->world, daft_v3(1000, 1, 1000), daft_dv3(0, -1, 0));
    if (scene->half[0] > 0) good = good && add_walls(self->world, scene->half[0], scene->half[1]);
    for (uint32_t i = 0; good && i < scene->body_count; i++) {
        self->ids[i] = add(self->world, DAFT_BODY_DYNAMIC, &scene->bodies[i]);
        good = self->ids[i] != 0;
        if (good && scene->bodies[i].asleep) daft_world_set_awake(self->world, self->ids[i], false);
    }
    for (uint32_t i = 0; good && i < scene->joint_count; i++) good = add_joint(self, &scene->joints[i]);
    return good;
}

static void destroy(void *world)
{
    ours *self = world;
    daft_world_destroy(self->world);
    daft_release(&self->self->allocator, self->ids);
    daft_release(&self->self->allocator, self);
}

static void *create(bench *owner, const sim_scene *scene, int threads)
{
    ours *self = daft_alloc_zero(&owner->allocator, 1, sizeof *self);
    if (!self) return NULL;
    self->self = owner;
    self->world = daft_world_create(&owner->allocator, NULL);
    self->ids = daft_alloc(&owner->allocator, scene->body_count, sizeof *self->ids);
    int isa;
    bool good = self->world && self->ids && daft_isa_parse(owner->isa, &isa);
    if (good) {
        daft_world_set_workers(self->world, threads, isa);
        daft_world_set_sleeping(self->world, scene->sleeping);
        daft_world_set_gravity(self->world, daft_v3(0, -9.81f, 0));
    }
    if (good && fill(self, scene)) return self;
    destroy(self);
    return NULL;
}

static bool step(void *world) { return daft_world_step(((ours *)world)->world, 1.0f / BENCH_SIM_HZ, NULL); }

static daft_rigid pose(void *world, uint32_t body)
{
    const ours *self = world;
    daft_sim_state state;
    daft_world_get(self->world, self->ids[body], &state);
    return daft_rigid_make(state.position, state.rotation);
}

const sim_engine *bench_sim_ours(void)
{
    static const sim_engine engine = {"ours", create, destroy, step, pose};
    return &engine;
}
