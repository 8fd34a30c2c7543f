/* The peer ODE: the same scenes as worlds of its QuickStep, everything at its defaults (20 iterations), on the thread
 * that calls. Its sweep-and-prune space was the fastest of its spaces on the piles. */
#include "sim_scenes.h"

#include <ode/ode.h>

enum { POINTS = 4 }; /* of a pair, as ours has at most */

typedef struct ode_world {
    bench *self;
    dWorldID world;
    dSpaceID space;
    dJointGroupID contacts;
    dBodyID *bodies;
} ode_world;

static void near_pair(void *data, dGeomID a, dGeomID b)
{
    ode_world *self = data;
    dContact contacts[POINTS];
    dBodyID body_a = dGeomGetBody(a), body_b = dGeomGetBody(b);
    bool awake = (body_a && dBodyIsEnabled(body_a)) || (body_b && dBodyIsEnabled(body_b));
    if (!awake || (body_a && body_b && dAreConnectedExcluding(body_a, body_b, dJointTypeContact))) return;
    int count = dCollide(a, b, POINTS, &contacts[0].geom, sizeof contacts[0]);
    for (int i = 0; i < count; i++) {
        contacts[i].surface.mode = dContactApprox1;
        contacts[i].surface.mu = 0.6;
        dJointAttach(dJointCreateContact(self->world, self->contacts, &contacts[i]), body_a, body_b);
    }
}

/* ODE's capsules lie along z. */
static dGeomID make_geometry(dSpaceID space, const daft_sim_shape *shape, dMass *mass)
{
    const double density = 1000;
    double radius = (double)shape->radius, length = 2 * (double)shape->half_height;
    daft_dvec3 side = daft_dscale(daft_to_double(shape->half), 2);
    if (shape->type == DAFT_GEOMETRY_BOX) {
        dMassSetBox(mass, density, side.x, side.y, side.z);
        return dCreateBox(space, side.x, side.y, side.z);
    }
    if (shape->type == DAFT_GEOMETRY_SPHERE) {
        dMassSetSphere(mass, density, radius);
        return dCreateSphere(space, radius);
    }
    dMassSetCapsule(mass, density, 2, radius, length);
    return dCreateCapsule(space, radius, length);
}

static dBodyID make_body(ode_world *self, const sim_body *body)
{
    dMass mass;
    dBodyID id = dBodyCreate(self->world);
    dGeomID geometry = make_geometry(self->space, &body->shape, &mass);
    const dQuaternion rotation = {(double)body->rotation.w, (double)body->rotation.x, (double)body->rotation.y,
                                  (double)body->rotation.z};
    dBodySetMass(id, &mass);
    dBodySetPosition(id, body->position.x, body->position.y, body->position.z);
    dBodySetQuaternion(id, rotation);
    dGeomSetBody(geometry, id);
    if (body->shape.type == DAFT_GEOMETRY_CAPSULE) {
        dMatrix3 upright;
        dRFromAxisAndAngle(upright, 1, 0, 0, M_PI / 2);
        dGeomSetOffsetRotation(geometry, upright);
    }
    if (body->asleep) dBodyDisable(id);
    if (body->restless) dBodySetAutoDisableFlag(id, 0);
    return id;
}

static void make_joint(ode_world *self, const sim_joint *joint)
{
    dJointID id = joint->hinge ? dJointCreateHinge(self->world, 0) : dJointCreateBall(self->world, 0);
    dJointAttach(id, self->bodies[joint->a], self->bodies[joint->b]);
    if (!joint->hinge) {
        dJointSetBallAnchor(id, joint->anchor.x, joint->anchor.y, joint->anchor.z);
        return;
    }
    dJointSetHingeAnchor(id, joint->anchor.x, joint->anchor.y, joint->anchor.z);
    /* The angle is of a relative to b: the other way round than ours. */
    dJointSetHingeAxis(id, -(double)joint->axis.x, -(double)joint->axis.y, -(double)joint->axis.z);
    dJointSetHingeParam(id, dParamLoStop, (double)joint->lower);
    dJointSetHingeParam(id, dParamHiStop, (double)joint->upper);
}

static void destroy(void *world)
{
    ode_world *self = world;
    dJointGroupDestroy(self->contacts);
    dSpaceDestroy(self->space);
    dWorldDestroy(self->world);
    dCloseODE();
    daft_release(&self->self->allocator, self->bodies);
    daft_release(&self->self->allocator, self);
}

static void *create(bench *owner, const sim_scene *scene, int threads)
{
    ode_world *self = daft_alloc_zero(&owner->allocator, 1, sizeof *self);
    dBodyID *bodies = daft_alloc(&owner->allocator, scene->body_count, sizeof *bodies);
    if (!self || !bodies || threads != 1 || !dInitODE2(0)) {
        daft_release(&owner->allocator, self);
        daft_release(&owner->allocator, bodies);
        return NULL;
    }
    *self =
        (ode_world){owner, dWorldCreate(), dSweepAndPruneSpaceCreate(0, dSAP_AXES_XZY), dJointGroupCreate(0), bodies};
    dWorldSetGravity(self->world, 0, -9.81, 0);
    dWorldSetAutoDisableFlag(self->world, scene->sleeping);
    dCreatePlane(self->space, 0, 1, 0, 0);
    for (int wall = 0; scene->half[0] > 0 && wall < 4; wall++) {
        double sign = wall & 1 ? -1 : 1, x = wall < 2 ? sign : 0, z = wall < 2 ? 0 : sign;
        dCreatePlane(self->space, x, 0, z, -scene->half[wall / 2]);
    }
    for (uint32_t i = 0; i < scene->body_count; i++) bodies[i] = make_body(self, &scene->bodies[i]);
    for (uint32_t i = 0; i < scene->joint_count; i++) make_joint(self, &scene->joints[i]);
    return self;
}

static bool step(void *world)
{
    ode_world *self = world;
    dSpaceCollide(self->space, self, near_pair);
    bool good = dWorldQuickStep(self->world, 1.0 / BENCH_SIM_HZ) != 0;
    dJointGroupEmpty(self->contacts);
    return good;
}

static daft_rigid pose(void *world, uint32_t body)
{
    const ode_world *self = world;
    const dReal *p = dBodyGetPosition(self->bodies[body]), *r = dBodyGetRotation(self->bodies[body]);
    daft_rigid pose = {.p = {p[0], p[1], p[2]}};
    for (int row = 0; row < 3; row++)
        for (int column = 0; column < 3; column++) pose.m[3 * row + column] = r[4 * row + column];
    return pose;
}

const sim_engine *bench_find_ode(void)
{
    static const sim_engine engine = {"ODE QuickStep", create, destroy, step, pose};
    return &engine;
}
