/* Outlines: what is asked of a part for each of its pairs, of shapes simple enough. They follow from what body and part
 * are, so they are no state of the world's. */
#include "sim/world.h"
#include "sim/broad/broad.h"

static daft_outline_kind kind_of(const daft_sim_part *part, const daft_sim_body *body)
{
    daft_geometry type = part->shape.type;
    if (part->sensor || body->locks & DAFT_LOCK_POSITION) return DAFT_OUTLINE_NONE; /* see locked_axis.c */
    if (type == DAFT_GEOMETRY_SPHERE || type == DAFT_GEOMETRY_CAPSULE) return DAFT_OUTLINE_ROUND;
    return type == DAFT_GEOMETRY_BOX ? DAFT_OUTLINE_BOX : DAFT_OUTLINE_NONE;
}

static uint8_t flags_of(const daft_sim_part *part, const daft_sim_body *body)
{
    int watched = body->kind != DAFT_BODY_DYNAMIC || body->bullet ? DAFT_OUTLINE_WATCHED : 0;
    int sphere = part->shape.type == DAFT_GEOMETRY_SPHERE ? DAFT_OUTLINE_SPHERE : 0;
    return (uint8_t)(watched | sphere);
}

static daft_vec3 half_of(const daft_sim_shape *shape, const daft_rigid *frame)
{
    if (shape->type == DAFT_GEOMETRY_BOX) return shape->half;
    if (shape->type == DAFT_GEOMETRY_SPHERE) return daft_v3(0, 0, 0);
    double half = (double)shape->half_height;
    return daft_v3((float)(half * frame->m[1]), (float)(half * frame->m[4]), (float)(half * frame->m[7]));
}

void daft_sim_outline_set(daft_world *world, uint32_t part_index, const daft_rigid *frame, float dt)
{
    const daft_sim_part *part = &world->parts[part_index];
    const daft_sim_body *body = &world->bodies[part->body];
    daft_outline *outline = &world->outlines[part_index];
    daft_outline_kind kind = kind_of(part, body);
    outline->kind = (uint8_t)kind;
    if (kind == DAFT_OUTLINE_NONE) return;
    outline->centre = frame->p;
    outline->reach = part->reach;
    outline->centred = !part->posed && daft_sim_is_zero(body->local_centre);
    outline->flags = flags_of(part, body);
    outline->half = half_of(&part->shape, frame);
    outline->radius = kind == DAFT_OUTLINE_ROUND ? part->shape.radius : 0;
    outline->move = daft_scale(body->linear, dt);
    outline->swing = daft_sim_is_zero(body->angular) ? 0 : daft_length(body->angular) * body->extent * dt;
    if (kind == DAFT_OUTLINE_BOX) world->box_frames[part_index] = *frame;
}

void daft_sim_outlines_rest(daft_world *world, uint32_t body)
{
    for (uint32_t i = world->bodies[body].first_part; i != DAFT_SIM_NONE; i = world->parts[i].next) {
        daft_rigid frame = daft_sim_part_frame(&world->bodies[body], &world->parts[i]);
        daft_sim_outline_set(world, i, &frame, 0);
    }
}

bool daft_sim_outlines_reserve(daft_world *world, size_t parts)
{
    const daft_allocator *a = &world->allocator;
    size_t used = world->outlines && world->box_frames ? world->part_count : 0; /* none yet in a world that is loaded */
    return daft_grow(a, &world->outlines, &world->outline_capacity, parts, used, sizeof *world->outlines) &&
           daft_grow(a, &world->box_frames, &world->box_frame_capacity, parts, used, sizeof *world->box_frames);
}
