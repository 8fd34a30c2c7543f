/* robot [SECONDS]: a robot drives round a room with a table, columns and a wall across half of it. All it knows is a
 * flat lidar with errors: ten times a second it turns towards the middle of the widest gap ahead. */
#include <daft.h>
#include <stdio.h>
#include <stdlib.h>

enum { BEAMS = 360, STEPS_A_SECOND = 10 };
static const double PI = 3.14159265358979, RADIUS = 0.25, SPEED = 0.6, TURN = 1.5; /* m, m/s, rad/s */

typedef struct robot {
    double x, z, heading; /* metres; radians, 0 along +X, positive to the right */
    daft_entity body;
} robot;

static int fail(const daft_error *error)
{
    char text[1200];
    fprintf(stderr, "robot: %s\n", daft_error_text(error, text, sizeof text));
    return 1;
}

static bool add_box(daft_scene *scene, double x, double z, float width, float depth, daft_error *error)
{
    daft_entity_def def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_BOX;
    def.position = (daft_dvec3){x, 1, z};
    def.size = (daft_vec3){width, 2, depth};
    return daft_entity_create(scene, &def, error).id != 0;
}

static bool furnish(daft_scene *scene, daft_error *error)
{
    return add_box(scene, 0, -4.1, 12, 0.2f, error) && add_box(scene, 0, 4.1, 12, 0.2f, error) && /* walls, */
           add_box(scene, -6.1, 0, 0.2f, 8, error) && add_box(scene, 6.1, 0, 0.2f, 8, error) &&
           add_box(scene, 1, -2.2, 0.2f, 3.6f, error) && /* one across, */
           add_box(scene, -3, 0.4, 1.6f, 1, error) &&    /* a table, */
           add_box(scene, 3.4, 1.6, 0.4f, 0.4f, error) && add_box(scene, 3.4, -1.4, 0.4f, 0.4f, error); /* columns */
}

static bool look(daft_scene *scene, const robot *r, uint64_t step, float ranges[BEAMS], daft_error *error)
{
    daft_scan_return returns[BEAMS];
    daft_scan_def scan = daft_default_scan_def();
    scan.rows = 1, scan.columns = BEAMS, scan.bottom = scan.top = 0; /* one beam, level */
    scan.position = (daft_dvec3){r->x, 0.3, r->z};
    scan.rotation = (daft_quat){0, (float)-daft_sin(r->heading / 2), 0, (float)daft_cos(r->heading / 2)};
    scan.min_range = 0.05f, scan.max_range = 12;
    scan.range_noise = 0.01f, scan.drop_out = 0.02f, scan.seed = step;
    scan.ignore = r->body;
    if (!daft_scan(scene, &scan, returns, NULL, error)) return false;
    for (int i = 0; i < BEAMS; i++) ranges[i] = returns[i].range > 0 ? returns[i].range : scan.max_range;
    return true;
}

/* The range that is left for a robot as wide as this one: the least among the beams that its width covers. */
static double room_towards(const float ranges[BEAMS], int beam)
{
    double least = 12;
    for (int i = -60; i <= 60; i++) {
        const double angle = i * 2 * PI / BEAMS, range = (double)ranges[(beam + i + BEAMS) % BEAMS];
        const double aside = range * daft_sin(angle), along = range * daft_cos(angle);
        if ((aside < 0 ? -aside : aside) < RADIUS + 0.15 && along < least) least = along;
    }
    return least;
}

/* The angle to steer for: much room, and not far from straight ahead. */
static double choose_way(const float ranges[BEAMS], double *room)
{
    double best = -1, way = 0;
    for (int i = -120; i <= 120; i += 3) {
        const double free = room_towards(ranges, (i + BEAMS) % BEAMS), angle = i * 2 * PI / BEAMS;
        const double worth = (free < 3 ? free : 3) - 0.4 * (angle < 0 ? -angle : angle);
        if (worth > best) best = worth, way = angle;
    }
    *room = room_towards(ranges, 0);
    return way;
}

static void drive(robot *r, double way, double room)
{
    const double dt = 1.0 / STEPS_A_SECOND, most = TURN * dt, speed = room < 0.5 ? 0 : SPEED;
    r->heading += way > most ? most : way < -most ? -most : way;
    r->x += speed * dt * daft_cos(r->heading);
    r->z += speed * dt * daft_sin(r->heading);
}

int main(int argc, char **argv)
{
    const int steps = (argc > 1 ? atoi(argv[1]) : 60) * STEPS_A_SECOND;
    daft_error error;
    daft_engine_def def = daft_default_engine_def();
    daft_engine *engine = daft_engine_create(&def, &error);
    daft_scene *scene = engine ? daft_scene_create(engine, &error) : NULL;
    if (!scene || !furnish(scene, &error)) return fail(&error);

    robot r = {-4.5, -2.5, 0.3, {0}};
    double way_driven = 0, closest = 12;
    for (int step = 0; step < steps; step++) {
        float ranges[BEAMS];
        double room, x = r.x, z = r.z;
        if (!look(scene, &r, (uint64_t)step, ranges, &error)) return fail(&error);
        for (int i = 0; i < BEAMS; i++) closest = (double)ranges[i] < closest ? (double)ranges[i] : closest;
        const double way = choose_way(ranges, &room);
        drive(&r, way, room);
        x -= r.x, z -= r.z;
        way_driven += SPEED / STEPS_A_SECOND * (x != 0 || z != 0);
        if (step % (5 * STEPS_A_SECOND) == 0)
            printf("%3d s: at %5.2f, %5.2f, heading %4.0f degrees\n", step / STEPS_A_SECOND, r.x, r.z,
                   r.heading * 180 / PI);
    }
    printf("drove %.1f m, and came no nearer to anything than %.2f m\n", way_driven, closest);

    daft_scene_destroy(scene);
    daft_engine_destroy(engine);
    return closest > RADIUS ? 0 : 1;
}
