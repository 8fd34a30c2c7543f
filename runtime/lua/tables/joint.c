/* Joints, what happened in the last step, and the simulation as a whole. */
#include "lua/tables/body.h"
#include "lua/fields.h"

#include "common/util.h"

static const char *const MOTOR_FIELDS[] = {"speed", "force"};
static const char *const SPRING_FIELDS[] = {"hertz", "damping"};

static daft_joint joint_at(lua_State *L, host *h, int index)
{
    return (daft_joint){api_check_handle(L, h, index, API_JOINT, "joint")->id};
}

/* ---- daft.joint ---- */

static float field_number(lua_State *L, host *h, int table, const char *name, const char *what, float otherwise)
{
    return api_field(L, table, name) ? api_float(L, h, -1, what) : otherwise;
}

/* {lower, upper}, or one number for a cone or a rope. */
static void read_limit(lua_State *L, host *h, int whole, void *out)
{
    (void)whole;
    daft_joint_def *def = out;
    int table = lua_absindex(L, -1);
    def->limit = true;
    if (lua_type(L, table) == LUA_TNUMBER) {
        def->upper = api_float(L, h, table, "limit");
        return;
    }
    if (lua_type(L, table) != LUA_TTABLE || lua_rawlen(L, table) != 2)
        api_wrong(L, h, table, "limit", "number or {lower, upper}");
    lua_rawgeti(L, table, 1);
    def->lower = api_float(L, h, -1, "limit");
    lua_rawgeti(L, table, 2);
    def->upper = api_float(L, h, -1, "limit");
}

static void read_motor(lua_State *L, host *h, int whole, void *out)
{
    (void)whole;
    daft_joint_def *def = out;
    int table = lua_absindex(L, -1);
    api_fields(L, h, table, "motor", MOTOR_FIELDS, COUNT_OF(MOTOR_FIELDS));
    def->motor = true;
    def->motor_speed = field_number(L, h, table, "speed", "motor.speed", 0);
    def->motor_force = field_number(L, h, table, "force", "motor.force", 0);
}

static void read_spring(lua_State *L, host *h, int whole, void *out)
{
    (void)whole;
    daft_joint_def *def = out;
    int table = lua_absindex(L, -1);
    api_fields(L, h, table, "spring", SPRING_FIELDS, COUNT_OF(SPRING_FIELDS));
    def->spring = true;
    def->hertz = field_number(L, h, table, "hertz", "spring.hertz", def->hertz);
    def->damping = field_number(L, h, table, "damping", "spring.damping", def->damping);
}

static const api_special SPECIALS[] = {
    {.name = "at",
     .value = "{x, y, z} or entity",
     .doc = "Where, in the world; distance: the point on a; where b is unless given"},
    {.name = "to",
     .value = "{x, y, z} or entity",
     .doc = "distance: the point on b; drag: the target; where b is unless given"},
    {.name = "limit",
     .read = read_limit,
     .value = "{lower, upper} or number",
     .doc = "Radians of a hinge, metres of a slider or a distance; a number: a ball's cone, a rope's length"},
    {.name = "motor",
     .read = read_motor,
     .value = "{speed =, force =}",
     .doc = "rad/s and N m, or m/s and N; of a ball: a brake, the friction of a shoulder"},
    {.name = "spring", .read = read_spring, .value = "{hertz =, damping =}"}};

const api_form api_joint_form = {"joint", "daft.joint", DAFT_STRUCT_JOINT_DEF, -1, SPECIALS, COUNT_OF(SPECIALS)};

static int create(lua_State *L, host *h)
{
    daft_joint_def def = daft_default_joint_def();
    daft_transform place;
    daft_error error;
    if (lua_type(L, 1) == LUA_TTABLE && api_field(L, 1, "b")) { /* the anchors are where b is unless the table says so
                                                                 */
        def.b = api_entity_at(L, h, -1, "b");
        if (!daft_entity_get_transform(h->def.scene, def.b, &place, &error)) api_engine_error(L, h, &error);
        def.anchor = def.anchor_b = place.position;
    }
    api_read_struct(L, h, 1, NULL, &api_joint_form, &def);
    if (!def.b.id) api_error(L, h, "b: which entity does it hold?");
    daft_joint joint = daft_joint_create(h->def.scene, &def, &error);
    if (joint.id == 0) api_engine_error(L, h, &error);
    api_new_handle(L, API_JOINT, joint.id);
    return 1;
}

static int destroy(lua_State *L, host *h)
{
    daft_error error;
    if (!daft_joint_destroy(h->def.scene, joint_at(L, h, 1), &error)) api_engine_error(L, h, &error);
    return 0;
}

static int valid(lua_State *L, host *h)
{
    lua_pushboolean(L, daft_joint_is_valid(h->def.scene, joint_at(L, h, 1)));
    return 1;
}

static daft_joint_state get_state(lua_State *L, host *h)
{
    daft_joint_state state;
    daft_error error;
    if (!daft_joint_get(h->def.scene, joint_at(L, h, 1), &state, &error)) api_engine_error(L, h, &error);
    return state;
}

static int value(lua_State *L, host *h)
{
    daft_joint_state state = get_state(L, h);
    lua_pushnumber(L, (double)state.value);
    lua_pushnumber(L, (double)state.speed);
    return 2;
}

static int force(lua_State *L, host *h)
{
    daft_joint_state state = get_state(L, h);
    lua_pushnumber(L, (double)state.force);
    lua_pushnumber(L, (double)state.torque);
    return 2;
}

/* The two numbers of a drive or a limit; false: there are none, which turns it off. */
static bool two_numbers(lua_State *L, host *h, const char *first, const char *second, float *a, float *b)
{
    *a = *b = 0;
    if (lua_isnoneornil(L, 2)) return false;
    *a = api_float(L, h, 2, first), *b = api_float(L, h, 3, second);
    return true;
}

static int motor(lua_State *L, host *h)
{
    daft_error error;
    float speed, max_force;
    bool on = two_numbers(L, h, "speed", "force", &speed, &max_force);
    if (!daft_joint_set_motor(h->def.scene, joint_at(L, h, 1), on, speed, max_force, &error))
        api_engine_error(L, h, &error);
    return 0;
}

static int limit(lua_State *L, host *h)
{
    daft_error error;
    float lower, upper;
    bool on = two_numbers(L, h, "lower", "upper", &lower, &upper);
    if (!daft_joint_set_limit(h->def.scene, joint_at(L, h, 1), on, lower, upper, &error))
        api_engine_error(L, h, &error);
    return 0;
}

static int spring(lua_State *L, host *h)
{
    daft_error error;
    float hertz, damping;
    bool on = two_numbers(L, h, "hertz", "damping", &hertz, &damping);
    if (!daft_joint_set_spring(h->def.scene, joint_at(L, h, 1), on, hertz, damping, &error))
        api_engine_error(L, h, &error);
    return 0;
}

static int target(lua_State *L, host *h)
{
    daft_error error;
    if (!daft_joint_set_target(h->def.scene, joint_at(L, h, 1), api_place(L, h, 2, "target"), &error))
        api_engine_error(L, h, &error);
    return 0;
}

/* ---- events ---- */

/* Sets the fields of the table on top, which may have been another event's. */
static void put_event(lua_State *L, const daft_event *e)
{
    static const char *const NAMES[] = {"", "begin", "end", "enter", "leave", "break", "gone", "sleep", "wake"};
    static const char *const SOME[] = {"joint", "point", "normal", "speed"}; /* of some kinds */
    const size_t some = e->kind == DAFT_EVENT_CONTACT_BEGIN ? 1 : COUNT_OF(SOME);
    for (size_t i = 0; i < some; i++) {
        lua_pushnil(L);
        lua_setfield(L, -2, SOME[i]);
    }
    lua_pushstring(L, NAMES[e->kind]);
    lua_setfield(L, -2, "kind");
    if (e->kind == DAFT_EVENT_JOINT_BREAK || e->kind == DAFT_EVENT_JOINT_GONE) {
        api_new_handle(L, API_JOINT, e->joint.id);
        lua_setfield(L, -2, "joint");
    }
    api_push_entity(L, e->a.id);
    lua_setfield(L, -2, "a");
    api_push_entity(L, e->b.id);
    lua_setfield(L, -2, "b");
    if (e->kind == DAFT_EVENT_CONTACT_BEGIN) {
        api_set_vec3(L, "point", e->point.x, e->point.y, e->point.z);
        api_set_vec3(L, "normal", (double)e->normal.x, (double)e->normal.y, (double)e->normal.z);
        lua_pushnumber(L, (double)e->speed);
        lua_setfield(L, -2, "speed");
    }
    lua_pushnumber(L, (double)e->impulse);
    lua_setfield(L, -2, "impulse");
}

static int events(lua_State *L, host *h)
{
    uint32_t count = h->still ? 0 : daft_scene_events(h->def.scene, NULL, 0);
    daft_event *all = api_scratch(L, count * sizeof *all);
    if (count > 0) count = daft_scene_events(h->def.scene, all, count);
    api_push_out(L, h, 1, "list");
    for (uint32_t i = 0; i < count; i++) {
        api_push_item(L, (lua_Integer)i + 1);
        put_event(L, &all[i]);
        lua_pop(L, 1);
    }
    api_end_list(L, (lua_Integer)count);
    return 1;
}

/* ---- the simulation as a whole ---- */

static int physics(lua_State *L, host *h)
{
    static const char *const NAMES[] = {"substeps", "sleeping"};
    daft_error error;
    if (!lua_isnoneornil(L, 1)) {
        if (h->picture)
            api_error(L, h, "not within daft.draw: drawing must not change the game, so do this in daft.update");
        api_fields(L, h, 1, NULL, NAMES, COUNT_OF(NAMES));
        if (api_field(L, 1, "substeps") &&
            !daft_scene_set_substeps(h->def.scene, (int)api_whole(L, h, -1, "substeps"), &error))
            api_engine_error(L, h, &error);
        if (api_field(L, 1, "sleeping")) daft_scene_set_sleeping(h->def.scene, api_boolean(L, h, -1, "sleeping"));
    }
    daft_sim_counters c = daft_scene_sim_counters(h->def.scene);
    api_push_struct(L, DAFT_STRUCT_SIM_COUNTERS, &c);
    return 1;
}

const api_form api_surfaces_form = {"surfaces", "daft.surfaces", DAFT_STRUCT_SURFACES, -1, NULL, 0};

static int surfaces(lua_State *L, host *h)
{
    daft_error error;
    uint32_t a = api_surface(L, h, 1, "surface"), b = api_surface(L, h, 2, "surface");
    daft_surfaces together = {0};
    bool some = !lua_isnoneornil(L, 3);
    if (some) api_read_struct(L, h, 3, "the table", &api_surfaces_form, &together);
    if (!daft_scene_set_surfaces(h->def.scene, a, b, some ? &together : NULL, &error)) api_engine_error(L, h, &error);
    return 0;
}

static int save_bodies(lua_State *L, host *h)
{
    daft_error error;
    size_t size = daft_scene_save_bodies(h->def.scene, NULL, 0, &error);
    if (!size) api_engine_error(L, h, &error);
    void *bytes = lua_newuserdatauv(L, size, 0);
    if (daft_scene_save_bodies(h->def.scene, bytes, size, &error) != size) api_engine_error(L, h, &error);
    lua_pushlstring(L, bytes, size);
    return 1;
}

static int load_bodies(lua_State *L, host *h)
{
    daft_error error;
    size_t size;
    if (lua_type(L, 1) != LUA_TSTRING) api_wrong(L, h, 1, "state", "string that daft.save_bodies gave");
    const char *bytes = lua_tolstring(L, 1, &size);
    if (!daft_scene_load_bodies(h->def.scene, bytes, size, &error)) api_engine_error(L, h, &error);
    return 0;
}

static const api_function FUNCTIONS[] = {
    {"joint", "{...} -> joint", "Joins two bodies, or one and the world.", create, API_CHANGES},
    {"joint:destroy", "()", "Takes it away.", destroy, API_CHANGES},
    {"joint:valid", "() -> boolean", "False once it was destroyed, broke, or went with a body.", valid, 0},
    {"joint:value", "() -> value, speed",
     "A hinge's angle, a slider's displacement, a distance's length; and how fast it changes.", value, 0},
    {"joint:force", "() -> newtons, newton metres", "What it had to hold, as the mean over the last step.", force, 0},
    {"joint:motor", "([speed, force])",
     "Drives a hinge or slider at a speed with at most a force, or brakes a ball; nothing: off.", motor, API_CHANGES},
    {"joint:limit", "([lower, upper])", "Limits its value; nothing: off.", limit, API_CHANGES},
    {"joint:spring", "([hertz, damping])", "Makes it a spring; nothing: stiff.", spring, API_CHANGES},
    {"joint:target", "(x, y, z)", "Where a drag joint draws to.", target, API_CHANGES},
    {"events", "([list]) -> list",
     "What happened in the last step: {kind =, a =, b =, impulse =}. kind is \"begin\" or \"end\" of a contact, "
     "\"enter\" or\n"
     "\"leave\" of a sensor (a), \"break\" or \"gone\" of a joint (joint =), \"sleep\" or \"wake\" of a body (a). A "
     "begin has\n"
     "point =, normal = and speed =, too.",
     events, 0},
    {"physics", "([{...}]) -> counts",
     "Sets substeps = 1 to 16 (4 unless set) and sleeping = true or false. Gives counts of the last step: bodies, "
     "awake,\n"
     "joints, islands, pairs, contacts, rows, colours, substeps (the most of any island), sweeps.",
     physics, 0},
    {"surfaces", "(name, name [, {...}])",
     "What counts where two kinds of surface meet; without the table, what the bodies say.", surfaces, API_CHANGES},
    {"save_bodies", "() -> string",
     "The state of all bodies, joints and characters, for daft.load_bodies in the same run of the game.", save_bodies,
     0},
    {"load_bodies", "(string)",
     "Puts all bodies, joints and characters back as they were; the entities must be the same.", load_bodies,
     API_CHANGES},
};

const api_area api_joint = {"Joints and physics", FUNCTIONS, COUNT_OF(FUNCTIONS)};
