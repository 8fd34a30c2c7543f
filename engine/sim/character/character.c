/* The character: one move is riding on what it stands on, taking up speed, sliding (or a step up), and finding the
 * ground again. */
#include "sim/character/character.h"

#include "math/trig.h"
#include "sim/character/mover.h"

#include <string.h>

/* Of the radius, and at most, in metres. */
#define SKIN     0.02
#define MAX_SKIN 0.02
/* What it stands on may move it by this, in m/s; more is a teleport, which leaves it behind. */
#define MAX_RIDE 200.0
/* Steep sides that leave less than this fraction of a fall hold it as well as ground does. */
#define HELD 0.1
/* Overlap that cannot be undone, as a fraction of the radius. */
#define CRUSHED 0.05

daft_sim_character_def daft_default_sim_character_def(void)
{
    return (daft_sim_character_def){.radius = 0.3f,
                                    .height = 1.8f,
                                    .step_height = 0.35f,
                                    .max_slope = 0.8727f,
                                    .acceleration = 60,
                                    .air_acceleration = 12,
                                    .gravity_scale = 1,
                                    .mass = 80,
                                    .push_force = 400,
                                    .layers = 1,
                                    .mask = UINT32_MAX};
}

static bool check(daft_error *error, const char *what, float value, float least, float most)
{
    if (value >= least && value <= most) return true;
    return daft_fail(error, DAFT_ERROR_ARGUMENT, "character: %s %g is not within %g to %g", what, (double)value,
                     (double)least, (double)most);
}

static bool check_position(daft_dvec3 p, daft_error *error)
{
    double limit = DAFT_SIM_MAX_DISTANCE;
    if (fabs(p.x) <= limit && fabs(p.y) <= limit && fabs(p.z) <= limit) return true;
    return daft_fail(error, DAFT_ERROR_ARGUMENT, "character: position (%g, %g, %g) is not finite or too far away", p.x,
                     p.y, p.z);
}

bool daft_sim_character_init(daft_sim_character *character, const daft_sim_character_def *def, daft_error *error)
{
    if (!check_position(def->position, error) || !check(error, "radius", def->radius, 1e-3f, 1e3f) ||
        !check(error, "height", def->height, 2 * def->radius, 1e4f) ||
        !check(error, "step height", def->step_height, 0, 0.5f * def->height) ||
        !check(error, "slope", def->max_slope, 0, 1.5f) || !check(error, "acceleration", def->acceleration, 0, 1e6f) ||
        !check(error, "acceleration in the air", def->air_acceleration, 0, 1e6f) ||
        !check(error, "gravity scale", def->gravity_scale, 0, 1e3f) || !check(error, "mass", def->mass, 0, 1e9f) ||
        !check(error, "push force", def->push_force, 0, 1e9f))
        return false;
    memset(character, 0, sizeof *character); /* padding too: its bytes may be saved and hashed */
    character->def = *def;
    character->position = def->position;
    character->ground_rotation = daft_quat_identity();
    return true;
}

static void set_capsule(daft_mover *m, const daft_sim_character_def *def)
{
    float half = 0.5f * def->height - def->radius;
    m->capsule.type = DAFT_GEOMETRY_CAPSULE;
    m->capsule.radius = def->radius;
    m->capsule.half_height = half > DAFT_SHAPE_MIN_SIZE ? half : 0;
}

static void begin(daft_mover *m, daft_world *world, const daft_sim_character *c)
{
    m->world = world;
    m->filter = daft_default_sim_filter();
    m->filter.layers = c->def.layers;
    m->filter.mask = c->def.mask;
    m->filter.ignore = c->def.ignore;
    memset(&m->capsule, 0, sizeof m->capsule);
    set_capsule(m, &c->def);
    m->skin = fmin(SKIN * (double)c->def.radius, MAX_SKIN);
    m->max_slope = daft_cos((double)c->def.max_slope);
    m->walking = false;
    m->skip = 0;
    m->position = c->position;
    m->collected = false;
    m->count = 0;
}

/* ---- riding ---- */

static bool has_moved(const daft_sim_character *c, const daft_sim_body *body)
{
    daft_dvec3 p = c->ground_position;
    daft_quat a = c->ground_rotation, b = body->rotation;
    return p.x != body->position.x || p.y != body->position.y || p.z != body->position.z || a.x != b.x || a.y != b.y ||
           a.z != b.z || a.w != b.w;
}

/* The angle about Y of the turn from a to b (its twist). */
static float turn_between(daft_quat a, daft_quat b)
{
    daft_quat d = daft_quat_mul(b, (daft_quat){-a.x, -a.y, -a.z, a.w});
    double sign = d.w < 0 ? -1 : 1;
    return (float)(2 * daft_atan2(sign * (double)d.y, sign * (double)d.w));
}

static void let_go(daft_sim_character *c)
{
    c->grounded = false;
    c->ground = 0;
    c->ground_velocity = daft_v3(0, 0, 0);
}

/* Carries it along with what it stands on. */
static void ride(daft_mover *m, daft_sim_character *c, double dt)
{
    const daft_sim_body *body = daft_sim_find(m->world, c->ground);
    c->turn = 0;
    if (!c->grounded) return;
    if (!body) {
        let_go(c);
        return;
    }
    if (!has_moved(c, body)) return;
    daft_dvec3 displacement = daft_dsub(daft_rigid_point(&body->frame, c->ground_local), m->position);
    if (!(sqrt(daft_ddot(displacement, displacement)) <= MAX_RIDE * dt)) {
        let_go(c);
        return;
    }
    c->turn = turn_between(c->ground_rotation, body->rotation);
    m->walking = true;
    m->skip = c->ground;
    daft_mover_slide(m, displacement);
    m->skip = 0;
    m->collected = false;
}

/* ---- speed ---- */

static daft_dvec3 level(daft_dvec3 v) { return daft_dv3(v.x, 0, v.z); }

static double length_of(daft_dvec3 v) { return sqrt(daft_ddot(v, v)); }

/* The level part of a velocity comes nearer to `wish` by at most `gain`. */
static daft_dvec3 take_up(daft_dvec3 velocity, daft_dvec3 wish, double gain)
{
    daft_dvec3 missing = daft_dsub(wish, level(velocity));
    double length = length_of(missing);
    if (length > gain) missing = daft_dscale(missing, gain / length);
    return daft_dadd(velocity, missing);
}

/* Steep ground cannot be walked up by pressing against it. */
static daft_dvec3 not_uphill(const daft_sim_character *c, daft_dvec3 wish)
{
    daft_dvec3 n = level(daft_to_double(c->ground_normal));
    double square = daft_ddot(n, n), into = daft_ddot(wish, n);
    if (!c->sliding || into >= 0 || !(square > 0)) return wish;
    return daft_dsub(wish, daft_dscale(n, into / square));
}

/* ---- steps ---- */

/* Level, into the wall that stopped a motion in this direction. */
static daft_dvec3 into_wall(daft_mover *m, daft_dvec3 direction)
{
    daft_dvec3 best = direction;
    double most = 0.05;
    daft_mover_collect(m);
    for (uint32_t i = 0; i < m->count; i++) {
        daft_dvec3 n = level(m->planes[i].normal);
        double length = length_of(n), against = -daft_ddot(n, direction);
        if (daft_mover_walkable(m, m->planes[i].normal) || against <= most * length) continue;
        most = against / length;
        best = daft_dscale(n, -1 / length);
    }
    return best;
}

/* Whether it could stand a little further on, where its edge is no longer what it touches, no higher than `most`. */
static bool can_land(daft_mover *m, const daft_sim_character_def *def, daft_dvec3 into, double fall, double most)
{
    daft_dvec3 before = m->position;
    daft_mover_plane hit;
    double sine = sqrt(fmax(0, 1 - m->max_slope * m->max_slope));
    double ahead = (double)def->radius * (1 - 0.9 * sine) + 2 * m->skin;
    double fraction = daft_mover_cast(m, daft_dscale(into, ahead), 0.5 * m->skin, NULL);
    m->position = daft_dadd(m->position, daft_dscale(into, fraction * ahead));
    fraction = daft_mover_cast(m, daft_dv3(0, -fall, 0), m->skin, &hit);
    double height = fraction < 1 ? m->position.y - fraction * fall + hit.point.y : INFINITY;
    m->position = before;
    return height <= most && daft_mover_walkable(m, hit.normal);
}

/* From `start`: up, on, and down again. Where that brings it farther than sliding did, it is there. */
static bool step_up(daft_mover *m, const daft_sim_character_def *def, daft_dvec3 start, daft_dvec3 direction,
                    double length)
{
    daft_dvec3 slid = m->position, into = into_wall(m, direction);
    double step = (double)def->step_height, gap = DAFT_MOVER_CLEAR * m->skin;
    double least = daft_ddot(daft_dsub(slid, start), direction) + m->skin;
    double top = start.y - 0.5 * (double)def->height + step + m->skin;
    length = fmax(length, least + m->skin);
    m->position = start;
    double rise = step * daft_mover_cast(m, daft_dv3(0, step, 0), 0.5 * m->skin, NULL);
    m->position.y += rise;
    if (rise > m->skin) {
        double reach = length * daft_mover_cast(m, daft_dscale(direction, length), gap, NULL);
        m->position = daft_dadd(m->position, daft_dscale(direction, reach));
        if (reach > least && can_land(m, def, into, rise + step, top)) {
            m->position.y -= rise * daft_mover_cast(m, daft_dv3(0, -rise, 0), m->skin, NULL);
            return true;
        }
    }
    m->position = slid;
    return false;
}

/* ---- ground ---- */

/* The plane that is most nearly level of those to stand on; or of all that lean back, if `steep`. */
static const daft_mover_plane *floor_plane(const daft_mover *m, bool steep)
{
    const daft_mover_plane *best = NULL;
    for (uint32_t i = 0; i < m->count; i++) {
        const daft_mover_plane *p = &m->planes[i];
        if (steep ? p->normal.y < 0.02 : !daft_mover_walkable(m, p->normal)) continue;
        if (!best || p->normal.y > best->normal.y) best = p;
    }
    return best;
}

static void stand(daft_mover *m, daft_sim_character *c, uint32_t body_index, daft_dvec3 normal, daft_dvec3 point)
{
    const daft_sim_body *body = &m->world->bodies[body_index];
    daft_dvec3 arm = daft_dsub(point, body->centre);
    c->grounded = true;
    c->sliding = false;
    c->ground = body_index + 1;
    c->ground_normal = daft_to_float(normal);
    c->ground_velocity =
        daft_to_float(daft_dadd(daft_to_double(body->linear), daft_dcross(daft_to_double(body->angular), arm)));
    c->ground_local = daft_rigid_to_local(&body->frame, m->position);
    c->ground_position = body->position;
    c->ground_rotation = body->rotation;
}

static bool stand_on_plane(daft_mover *m, daft_sim_character *c)
{
    const daft_mover_plane *p = floor_plane(m, false);
    if (!p) return false;
    stand(m, c, m->world->parts[p->part].body, p->normal, daft_dadd(m->position, p->point));
    return true;
}

/* On the edge of a step nothing below is level, but what is under its middle may be. */
static bool stand_over(daft_mover *m, daft_sim_character *c)
{
    double depth = 0.5 * (double)c->def.height + (double)c->def.step_height + 2 * m->skin;
    daft_sim_hit hit;
    if (!daft_world_cast_ray(m->world, m->position, daft_dv3(0, -depth, 0), &m->filter, &hit)) return false;
    if (hit.inside || !daft_mover_walkable(m, daft_to_double(hit.normal))) return false;
    stand(m, c, hit.body - 1, daft_to_double(hit.normal), hit.point);
    return true;
}

/* Ground that fell away less than a step is followed. */
static bool snap_down(daft_mover *m, daft_sim_character *c)
{
    daft_dvec3 before = m->position;
    double depth = (double)c->def.step_height + m->skin;
    double fraction = daft_mover_cast(m, daft_dv3(0, -depth, 0), m->skin, NULL);
    if (fraction >= 1) return false;
    m->position.y -= fraction * depth;
    daft_mover_collect(m);
    if (stand_on_plane(m, c) || (m->count > 0 && stand_over(m, c))) return true;
    m->position = before;
    daft_mover_collect(m);
    return false;
}

/* Held by steep sides that together leave no way down. */
static bool stand_wedged(daft_mover *m, daft_sim_character *c, const daft_mover_plane *steep)
{
    daft_dvec3 zero = {0, 0, 0}, down = {0, -1, 0};
    m->walking = false;
    daft_dvec3 fall = daft_mover_clip(m, down, zero);
    if (length_of(fall) > HELD) return false;
    stand(m, c, m->world->parts[steep->part].body, daft_dv3(0, 1, 0), daft_dadd(m->position, steep->point));
    return true;
}

static void find_ground(daft_mover *m, daft_sim_character *c, bool walked, daft_dvec3 velocity)
{
    c->grounded = c->sliding = false;
    daft_mover_collect(m);
    const daft_mover_plane *p = floor_plane(m, false);
    bool leaves = !walked && p && daft_ddot(daft_dsub(velocity, daft_mover_speed(m, p)), p->normal) > 0.1;
    if (!leaves && (stand_on_plane(m, c) || (walked && snap_down(m, c)))) return;
    p = floor_plane(m, true);
    if (!leaves && p && !daft_mover_walkable(m, p->normal)) {
        if (stand_wedged(m, c, p)) return;
        c->sliding = true;
        c->ground_normal = daft_to_float(p->normal);
    }
    let_go(c);
}

/* ---- what it does to others ---- */

static void push_others(daft_mover *m, const daft_sim_character *c, daft_dvec3 velocity, double dt)
{
    double budget = (double)c->def.push_force * dt, own = (double)c->def.mass;
    for (uint32_t i = 0; i < m->count; i++) {
        const daft_mover_plane *p = &m->planes[i];
        uint32_t body = m->world->parts[p->part].body + 1;
        double mass = (double)m->world->bodies[body - 1].mass;
        if (m->world->bodies[body - 1].kind != DAFT_BODY_DYNAMIC || daft_mover_walkable(m, p->normal)) continue;
        double closing = daft_ddot(daft_dsub(daft_mover_speed(m, p), velocity), p->normal);
        if (!(closing > 0) || !(own + mass > 0)) continue;
        double impulse = fmin(budget, closing * own * mass / (own + mass));
        budget -= impulse;
        daft_world_apply_impulse_at(m->world, body, daft_to_float(daft_dscale(p->normal, -impulse)),
                                    daft_dadd(m->position, p->point));
    }
}

/* Its weight, on what is awake: what sleeps bears it already. */
static void weigh_down(daft_mover *m, const daft_sim_character *c, bool landed, double dt)
{
    const daft_sim_body *body = daft_sim_find(m->world, c->ground);
    if (!c->grounded || !body || body->kind != DAFT_BODY_DYNAMIC || (body->asleep && !landed)) return;
    double weight = (double)c->def.mass * (double)(m->world->gravity.y * c->def.gravity_scale);
    daft_dvec3 feet = m->position;
    feet.y -= 0.5 * (double)c->def.height;
    daft_world_apply_impulse_at(m->world, c->ground, daft_v3(0, (float)(weight * dt), 0), feet);
}

/* ---- a move ---- */

/* Seen from what it stands on. Gives the velocity with which it ends. */
static daft_dvec3 walk(daft_mover *m, const daft_sim_character *c, daft_dvec3 velocity, double dt)
{
    daft_dvec3 n = daft_to_double(c->ground_normal), start = m->position,
               displacement = daft_dscale(level(velocity), dt);
    double length = length_of(displacement);
    m->walking = true;
    if (n.y > 0) displacement.y = -(n.x * displacement.x + n.z * displacement.z) / n.y;
    daft_mover_slide(m, displacement);
    daft_dvec3 direction = daft_dscale(level(displacement), length > 0 ? 1 / length : 0);
    double missing = length - daft_ddot(daft_dsub(m->position, start), direction);
    if (missing <= 0.02 * length + 1e-3 * m->skin) return velocity;
    if (c->def.step_height > 0 && step_up(m, &c->def, start, direction, length)) return velocity;
    daft_mover_collect(m);
    daft_dvec3 out = daft_mover_clip(m, velocity, daft_to_double(c->ground_velocity));
    return level(out);
}

static daft_dvec3 fly(daft_mover *m, daft_dvec3 velocity, double dt)
{
    daft_dvec3 zero = {0, 0, 0};
    m->walking = false;
    daft_mover_slide(m, daft_dscale(velocity, dt));
    daft_mover_collect(m);
    return daft_mover_clip(m, velocity, zero);
}

static void end(daft_mover *m, daft_sim_character *c, daft_dvec3 velocity)
{
    c->crushed = false;
    for (uint32_t i = 0; i < m->count; i++) c->crushed |= m->planes[i].separation < -CRUSHED * (double)c->def.radius;
    c->position = m->position;
    c->velocity = daft_sim_clamp(daft_to_float(velocity), DAFT_SIM_MAX_SPEED);
}

static bool check_wish(const daft_sim_walk_wish *wish, float dt, daft_error *error)
{
    if (!daft_finite3(wish->velocity) || !isfinite(wish->jump))
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "character: the velocity or the jump asked for is not finite");
    return check(error, "time step", dt, 0, DAFT_SIM_MAX_DT);
}

bool daft_sim_character_move(daft_world *world, daft_sim_character *c, const daft_sim_walk_wish *wish, float dt,
                             daft_error *error)
{
    daft_mover m;
    if (!check_wish(wish, dt, error)) return false;
    if (dt < 1e-9f) return true;
    begin(&m, world, c);
    daft_dvec3 old = daft_to_double(c->ground_velocity), velocity = daft_to_double(c->velocity);
    daft_dvec3 wanted = level(daft_to_double(daft_sim_clamp(wish->velocity, DAFT_SIM_MAX_SPEED)));
    double h = (double)dt;
    ride(&m, c, h);
    bool stood = c->grounded, jumps = stood && wish->jump > 0;
    if (stood) {
        /* What carries it may have changed its speed: it keeps its own, seen from there. */
        const daft_sim_body *body = &world->bodies[c->ground - 1];
        stand(&m, c, c->ground - 1, daft_to_double(c->ground_normal), m.position);
        if (body->kind == DAFT_BODY_STATIC) c->ground_velocity = daft_v3(0, 0, 0);
        velocity = take_up(level(daft_dsub(velocity, old)), wanted, (double)c->def.acceleration * h);
    } else {
        velocity = take_up(velocity, not_uphill(c, wanted), (double)c->def.air_acceleration * h);
        velocity.y += (double)(world->gravity.y * c->def.gravity_scale) * h;
    }
    if (jumps) velocity.y = (double)wish->jump;
    daft_dvec3 carried = stood ? daft_to_double(c->ground_velocity) : daft_dv3(0, 0, 0), asked = velocity;
    if (stood && !jumps) {
        velocity = daft_dadd(walk(&m, c, velocity, h), carried);
        asked = wanted;
    } else {
        velocity = fly(&m, daft_dadd(velocity, carried), h);
    }
    push_others(&m, c, daft_dadd(asked, carried), h);
    find_ground(&m, c, stood && !jumps, velocity);
    weigh_down(&m, c, !stood, h);
    end(&m, c, velocity);
    return true;
}

bool daft_sim_character_teleport(daft_sim_character *c, daft_dvec3 position, daft_error *error)
{
    if (!check_position(position, error)) return false;
    c->position = position;
    c->sliding = false;
    let_go(c);
    return true;
}

bool daft_sim_character_set_height(daft_world *world, daft_sim_character *c, float height, daft_error *error)
{
    if (!check(error, "height", height, 2 * c->def.radius, 1e4f) ||
        !check(error, "height", height, 2 * c->def.step_height, 1e4f))
        return false;
    daft_sim_character next = *c;
    daft_mover m;
    double rise = 0.5 * ((double)height - (double)c->def.height);
    next.def.height = height;
    next.position.y += rise;
    next.ground_local = c->ground_local;
    const daft_sim_body *body = daft_sim_find(world, c->ground);
    if (body) next.ground_local = daft_rigid_to_local(&body->frame, next.position);
    begin(&m, world, &next);
    daft_error_clear(error);
    if (rise > 0 && daft_world_overlap(world, &m.capsule, next.position, daft_quat_identity(), &m.filter, NULL, 0) > 0)
        return false;
    *c = next;
    return true;
}

uint64_t daft_sim_character_hash(const daft_sim_character *c, uint64_t seed)
{
    uint64_t h = daft_hash(&c->position, sizeof c->position, seed);
    h = daft_hash(&c->velocity, sizeof c->velocity, h);
    h = daft_hash(&c->ground_local, sizeof c->ground_local, h);
    const uint32_t flags[2] = {(uint32_t)c->grounded | (uint32_t)c->sliding << 1, c->ground};
    return daft_hash(flags, sizeof flags, h);
}
