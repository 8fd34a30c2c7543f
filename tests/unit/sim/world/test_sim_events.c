/* sim: what happened in a step is told once, in order, with numbers that physics asks for, and may be answered by
 * changing the world. */
#include "sim_scene.h"

static const daft_sim_event *find(const daft_world *world, daft_sim_event_kind kind, int *count)
{
    const daft_sim_event *events, *found = NULL;
    uint32_t n = daft_world_events(world, &events);
    *count = 0;
    for (uint32_t i = 0; i < n; i++)
        if (events[i].kind == kind && ++*count == 1) found = &events[i];
    return found;
}

/* ---- contacts ---- */

/* A ball that falls 1 m meets the floor at sqrt(2 g h) and takes m v (1 + e) from it; then it leaves. */
static void a_contact_begins_with_its_speed_and_impulse(void **unused)
{
    (void)unused;
    static const float restitutions[] = {0, 0.5f, 1};
    for (int k = 0; k < 3; k++) {
        daft_world *world = new_world();
        add_floor(world, 5);
        one_shape def = sphere(0.1, 0.5, 1.1, -0.25);
        def.restitution = restitutions[k];
        def.user = 77;
        uint32_t ball = add(world, def);
        int begins = 0, ends = 0, count;
        double mass = (double)daft_world_mass(world, ball), v = sqrt(2 * G);
        for (int i = 0; i < 40; i++) {
            steps(world, 1);
            const daft_sim_event *begin = find(world, DAFT_SIM_CONTACT_BEGIN, &count);
            begins += count;
            if (begin) {
                assert_int_equal(begin->body_a, 1);
                assert_int_equal(begin->body_b, ball);
                assert_int_equal(begin->user_b, 77);
                assert_near((double)begin->speed, v, 0.05 * v);
                assert_near((double)begin->impulse, mass * v * (1 + (double)restitutions[k]), 0.07 * mass * v);
                assert_near((double)begin->normal.y, 1, 1e-6);
                assert_near(begin->point.x, 0.5, 1e-3);
                assert_near(begin->point.y, 0, 0.02);
            }
            find(world, DAFT_SIM_CONTACT_END, &count);
            ends += count;
        }
        assert_int_equal(begins, 1);
        assert_int_equal(ends, k > 0);
        daft_world_destroy(world);
    }
}

/* What has begun and not ended is what daft_world_contacts tells, also while bodies come, go, fall asleep and wake.
 * Bodies are told apart by their users, as numbers are used again. */
enum { MOST_USERS = 600 };
static bool open_contacts[MOST_USERS][MOST_USERS];

static void follow_events(daft_world *world, int *open)
{
    const daft_sim_event *events;
    uint32_t n = daft_world_events(world, &events);
    for (uint32_t i = 0; i < n; i++) {
        bool begin = events[i].kind == DAFT_SIM_CONTACT_BEGIN;
        if (!begin && events[i].kind != DAFT_SIM_CONTACT_END) continue;
        uint32_t a = events[i].user_a, b = events[i].user_b;
        if (a > b) a = events[i].user_b, b = events[i].user_a;
        assert_true(open_contacts[a][b] != begin);
        open_contacts[a][b] = begin;
        *open += begin ? 1 : -1;
    }
    const daft_sim_contact *contacts;
    uint32_t count = daft_world_contacts(world, &contacts);
    assert_int_equal(count, *open);
    for (uint32_t i = 0; i < count; i++) {
        uint32_t a = contacts[i].user_a, b = contacts[i].user_b;
        assert_true(a < b ? open_contacts[a][b] : open_contacts[b][a]);
    }
}

static void every_begin_has_its_end(void **unused)
{
    (void)unused;
    seed_random(5005);
    memset(open_contacts, 0, sizeof open_contacts);
    daft_world *world = new_world();
    add_tray(world, daft_dv3(0, 0, 0), 3);
    daft_world_remove(world, 1);
    one_shape ground = box(daft_v3(3, 1, 3), 0, -1, 0);
    ground.user = 599;
    add(world, ground);
    for (uint32_t wall = 2; wall <= 5; wall++) daft_world_remove(world, wall);
    int open = 0, seen = 0;
    uint32_t ids[80] = {0}, next_user = 1;
    for (int tick = 0; tick < 900; tick++) {
        uint32_t slot = (uint32_t)uniform(0, 80);
        if (tick % 2 == 0 && tick < 700) {
            daft_world_remove(world, ids[slot]);
            double x = uniform(-2, 2), z = uniform(-2, 2), size = uniform(0.1, 0.4);
            one_shape def = tick % 4 ? sphere(size, x, 3, z) : dynamic_box(daft_v3((float)size, 0.2f, 0.3f), x, 3, z);
            def.user = next_user++;
            def.restitution = 0.3f;
            ids[slot] = add(world, def);
        }
        steps(world, 1);
        follow_events(world, &open);
        seen += open;
    }
    assert_true(seen > 5000);
    daft_world_destroy(world);
}

/* ---- triggers ---- */

static void triggers_tell_who_enters_and_leaves(void **unused)
{
    (void)unused;
    daft_world *world = new_world();
    uint32_t gates[2], balls[3];
    for (int i = 0; i < 2; i++) {
        one_shape gate = box(daft_v3(4, 0.5f, 4), 0, -2 - 1.5 * i, 0);
        gate.part.sensor = true;
        gate.user = 10 + (uint32_t)i;
        gates[i] = add(world, gate);
    }
    for (int i = 0; i < 3; i++) balls[i] = add(world, sphere(0.1, 2 - 2 * i, 0, 0));
    static const struct {
        daft_sim_event_kind kind;
        int gate;
        double height; /* of the ball's middle when it happens */
    } wanted[] = {{DAFT_SIM_TRIGGER_ENTER, 0, -1.4},
                  {DAFT_SIM_TRIGGER_LEAVE, 0, -2.6},
                  {DAFT_SIM_TRIGGER_ENTER, 1, -2.9},
                  {DAFT_SIM_TRIGGER_LEAVE, 1, -4.1}};
    int next = 0;
    for (int tick = 0; tick < 70; tick++) {
        steps(world, 1);
        const daft_sim_event *events;
        uint32_t n = daft_world_events(world, &events);
        assert_true(n % 3 == 0); /* all three balls at once, in the order of their numbers */
        for (uint32_t i = 0; i < n; i++) {
            if (i % 3 == 0) assert_true(next++ < 4);
            assert_int_equal(events[i].kind, wanted[next - 1].kind);
            assert_int_equal(events[i].body_a, gates[wanted[next - 1].gate]);
            assert_int_equal(events[i].user_a, 10 + wanted[next - 1].gate);
            assert_int_equal(events[i].body_b, balls[i % 3]);
            daft_sim_state s = state_of(world, balls[i % 3]);
            double late = wanted[next - 1].height - s.position.y; /* where bodies stood before the step counts */
            assert_true(late >= 0 && late < 2 * speed_of(s) / 60);
        }
    }
    assert_int_equal(next, 4);
    double t = 70 / 60.0; /* it fell as if nothing had been there */
    assert_near(state_of(world, balls[0]).position.y, -0.5 * G * t * t, 0.01 * 0.5 * G * t * t + 0.05);
    assert_near((double)state_of(world, balls[0]).linear.y, -G * t, 0.01);
    daft_world_destroy(world);
}

/* ---- joints ---- */

static uint32_t hang(daft_world *world, uint32_t body, float break_force, uint32_t user)
{
    daft_sim_joint_def def = daft_default_sim_joint_def();
    daft_error error = {0};
    def.body_b = body, def.anchor = state_of(world, body).position;
    def.break_force = break_force, def.user = user;
    uint32_t joint = daft_world_add_joint(world, &def, &error);
    assert_true(joint);
    return joint;
}

static void joints_break_and_go_with_their_bodies(void **unused)
{
    (void)unused;
    daft_world *world = new_world();
    uint32_t balls[3], joints[3];
    double weight = 0;
    for (int i = 0; i < 3; i++) {
        balls[i] = add(world, sphere(0.2, i, 0, 0));
        weight = G * (double)daft_world_mass(world, balls[i]);
        joints[i] = hang(world, balls[i], (float)((i == 1 ? 0.9 : 1.1) * weight), 40 + (uint32_t)i);
    }
    int breaks = 0, count;
    for (int tick = 0; tick < 120; tick++) {
        steps(world, 1);
        const daft_sim_event *event = find(world, DAFT_SIM_JOINT_BREAK, &count);
        breaks += count;
        if (!event) continue;
        assert_int_equal(event->joint, joints[1]);
        assert_int_equal(event->joint_user, 41);
        assert_int_equal(event->body_b, balls[1]);
        assert_true((double)event->impulse > 0.9 * weight && (double)event->impulse < 1.1 * weight);
    }
    assert_int_equal(breaks, 1);
    daft_sim_joint_state state;
    assert_false(daft_world_get_joint(world, joints[1], &state));
    assert_true(daft_world_get_joint(world, joints[0], &state) && state_of(world, balls[1]).position.y < -10);
    assert_near(state_of(world, balls[0]).position.y, 0, 1e-3);
    daft_world_remove(world, balls[2]);
    daft_world_remove_joint(world, joints[0]); /* asked for: no event */
    steps(world, 1);
    const daft_sim_event *gone = find(world, DAFT_SIM_JOINT_GONE, &count);
    assert_int_equal(count, 1);
    assert_int_equal(gone->joint, joints[2]);
    assert_int_equal(gone->joint_user, 42);
    assert_int_equal(gone->body_b, balls[2]);
    steps(world, 1);
    assert_null(find(world, DAFT_SIM_JOINT_GONE, &count));
    daft_world_destroy(world);
}

/* ---- sleep ---- */

static void what_rests_says_so_and_wakes_once(void **unused)
{
    (void)unused;
    daft_world *world = new_world();
    add_floor(world, 5);
    uint32_t low = add(world, dynamic_box(daft_v3(0.5f, 0.5f, 0.5f), 0, 0.5, 0)),
             high = add(world, dynamic_box(daft_v3(0.5f, 0.5f, 0.5f), 0, 1.5, 0));
    for (int round = 0; round < 3; round++) {
        int slept = 0, when = 0, count;
        for (int tick = 0; tick < 180; tick++) {
            steps(world, 1);
            const daft_sim_event *event = find(world, DAFT_SIM_SLEEP, &count);
            slept += count;
            if (!event) continue;
            when = tick;
            assert_int_equal(event[0].body_a, low); /* the island at once, in order */
            assert_int_equal(event[1].body_a, high);
        }
        assert_int_equal(slept, 2);
        assert_true(when < 120 && !daft_world_is_awake(world, low));
        daft_world_apply_impulse(world, high, daft_v3(0, 100, 0));
        steps(world, 1);
        const daft_sim_event *wake = find(world, DAFT_SIM_WAKE, &count);
        assert_int_equal(count, 2);
        assert_int_equal(wake[0].body_a, low);
        assert_int_equal(wake[1].body_a, high);
    }
    daft_world_destroy(world);
}

/* ---- changing the world ---- */

static void a_removed_body_ends_what_it_touched(void **unused)
{
    (void)unused;
    daft_world *world = new_world();
    add_floor(world, 5);
    one_shape gate = box(daft_v3(1, 1, 1), 0, 1, 0);
    gate.part.sensor = true;
    uint32_t sensor = add(world, gate);
    one_shape def = sphere(0.5, 0, 0.5, 0);
    def.user = 9;
    uint32_t ball = add(world, def);
    steps(world, 200);
    assert_false(daft_world_is_awake(world, ball));
    daft_world_remove(world, ball);
    const daft_sim_contact *contacts;
    assert_int_equal(daft_world_contacts(world, &contacts), 0);
    def.user = 10;
    def.position.x = 4;
    def.position.y = 3;
    assert_int_equal(add(world, def), ball); /* the number is used again; the events are of the old one */
    steps(world, 1);
    int count;
    const daft_sim_event *end = find(world, DAFT_SIM_CONTACT_END, &count);
    assert_int_equal(count, 1);
    assert_int_equal(end->body_b, ball);
    assert_int_equal(end->user_b, 9);
    const daft_sim_event *leave = find(world, DAFT_SIM_TRIGGER_LEAVE, &count);
    assert_int_equal(count, 1);
    assert_int_equal(leave->body_a, sensor);
    assert_int_equal(leave->user_b, 9);
    daft_world_destroy(world);
}

/* One answer of a game to an event: it removes, adds, joins, pushes, moves. */
static void answer(daft_world *world, const daft_sim_event *event)
{
    daft_error error;
    uint32_t body = uniform(0, 1) < 0.5 && event->body_a > 5 ? event->body_a : event->body_b;
    if (body <= 5) return;
    one_shape def = dynamic_box(daft_v3(0.2f, 0.3f, 0.2f), uniform(-2, 2), uniform(1, 5), uniform(-2, 2));
    daft_sim_joint_def joint = daft_default_sim_joint_def();
    joint.body_a = body, joint.body_b = 6 + (uint32_t)uniform(0, 40);
    joint.anchor = event->point;
    joint.break_force = 500;
    switch ((int)uniform(0, 6)) {
    case 0: daft_world_remove(world, body); break;
    case 1:
        if (daft_world_counters(world).bodies < 200) add(world, def); /* or each that is added may add more */
        break;
    case 2: daft_world_add_joint(world, &joint, &error); break;
    case 3: daft_world_apply_impulse(world, body, daft_v3(0, 50, 20)); break;
    case 4: daft_world_set_pose(world, body, def.position, daft_quat_identity(), true); break;
    default: daft_world_set_awake(world, body, uniform(0, 1) < 0.5); break;
    }
}

/* The array of events stays what it was while they are gone through. */
static uint64_t answer_all(int ticks)
{
    daft_world *world = new_world();
    random_state = 88172645463325252u;
    add_tray(world, daft_dv3(0, 0, 0), 3);
    uint64_t hash = 0;
    uint32_t answered = 0;
    for (int i = 0; i < 40; i++) add(world, sphere(0.3, -2 + i % 5, 0.5 + 0.7 * (i / 5.0), -2 + i % 4));
    for (int tick = 0; tick < ticks; tick++) {
        steps(world, 1);
        const daft_sim_event *events, *again;
        uint32_t count = daft_world_events(world, &events);
        daft_sim_event *copy = malloc((count + 1) * sizeof *copy);
        if (count > 0) memcpy(copy, events, count * sizeof *copy);
        /* One that wakes an island makes an event for each of its bodies: without an end to it they breed. */
        for (uint32_t i = 0; i < count && i < 50; i++) answer(world, &events[i]);
        assert_int_equal(daft_world_events(world, &again), count);
        assert_ptr_equal(again, events);
        if (count > 0) assert_memory_equal(copy, events, count * sizeof *copy);
        free(copy);
        answered += count;
        if (daft_world_counters(world).bodies < 40) add(world, sphere(0.3, 0, 4, 0));
        for (uint32_t id = 1; id < 80; id++) assert_true(daft_dfinite3(state_of(world, id).position));
        hash = daft_world_hash(world, hash);
    }
    print_message("%u events answered\n", answered);
    assert_true(answered > 1000);
    daft_world_destroy(world);
    return hash;
}

static void answering_events_changes_the_world(void **unused)
{
    (void)unused;
    assert_true(answer_all(600) == answer_all(600));
}

/* A step begins by looking what is in a sensor: who is there as a step ends is told by the next one, never later. */
static void triggers_are_one_step_late(void **unused)
{
    (void)unused;
    seed_random(41);
    for (int k = 0; k < 200; k++) {
        daft_world *world = new_world();
        daft_world_set_gravity(world, daft_v3(0, 0, 0));
        one_shape zone = box(daft_v3(0.5f, 0.5f, 0.5f), 0, 0, 0);
        zone.part.sensor = true;
        if (k & 1) zone.kind = DAFT_BODY_KINEMATIC;
        add(world, zone);
        double x = -uniform(1, 5), speed = k % 4 < 2 ? uniform(0.5, 10) : uniform(10, 40);
        uint32_t id = add(world, k % 3 ? sphere(0.2, x, 0, 0) : dynamic_box(daft_v3(0.2f, 0.2f, 0.2f), x, 0, 0));
        daft_world_set_velocity(world, id, daft_v3((float)speed, 0, 0), daft_v3(0, 0, 0));
        bool was = false, told = false;
        for (int tick = 0; tick < 800 && state_of(world, id).position.x < 2; tick++) {
            steps(world, 1);
            const daft_sim_event *events;
            uint32_t count = daft_world_events(world, &events);
            for (uint32_t i = 0; i < count; i++) {
                if (events[i].kind == DAFT_SIM_TRIGGER_ENTER) told = true;
                if (events[i].kind == DAFT_SIM_TRIGGER_LEAVE) told = false;
            }
            assert_true(told == was);
            was = fabs(state_of(world, id).position.x) < 0.7;
        }
        daft_world_destroy(world);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_contact_begins_with_its_speed_and_impulse),
        cmocka_unit_test(every_begin_has_its_end),
        cmocka_unit_test(triggers_tell_who_enters_and_leaves),
        cmocka_unit_test(triggers_are_one_step_late),
        cmocka_unit_test(joints_break_and_go_with_their_bodies),
        cmocka_unit_test(what_rests_says_so_and_wakes_once),
        cmocka_unit_test(a_removed_body_ends_what_it_touched),
        cmocka_unit_test(answering_events_changes_the_world),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
