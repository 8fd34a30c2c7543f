/* The character on triangle meshes: caves, and floors of many triangles. */
#include "character_fixture.h"
#include "sim_cases.h"

/* Corridors and a hall in one closed mesh: `size`² cells, each open or rock; open ones have bumpy floor and ceiling. */
enum { CAVE = 12, SUB = 4 };

typedef struct cave {
    bool open[CAVE][CAVE];
    daft_vec3 *points;
    uint32_t *index;
    uint32_t vertices, triangles;
} cave;

static uint32_t corner(cave *k, float x, float y, float z)
{
    k->points[k->vertices] = daft_v3(x, y, z);
    return k->vertices++;
}

static void quad(cave *k, const daft_vec3 p[4])
{
    uint32_t v[4];
    for (int i = 0; i < 4; i++) v[i] = corner(k, p[i].x, p[i].y, p[i].z);
    const uint32_t list[6] = {v[0], v[1], v[2], v[0], v[2], v[3]};
    memcpy(k->index + 3 * k->triangles, list, sizeof list);
    k->triangles += 2;
}

/* The same height wherever it is asked, so sheets meet without gaps. */
static float bumpy(float x, float z, float low, float amount)
{
    return low + amount * (float)(daft_sin(1.7 * (double)x) * daft_cos(1.3 * (double)z + 1) +
                                  0.5 * daft_sin(3.1 * (double)(x + z)));
}

static void cave_cell(cave *k, int cx, int cz)
{
    const float cell = 2, step = cell / SUB;
    for (int i = 0; i < SUB; i++)
        for (int j = 0; j < SUB; j++) {
            float x = (float)cx * cell + (float)i * step, z = (float)cz * cell + (float)j * step;
            daft_vec3 floor[4], roof[4];
            for (int c = 0; c < 4; c++) {
                float px = x + (c == 1 || c == 2 ? step : 0), pz = z + (c >= 2 ? step : 0);
                floor[3 - c] = daft_v3(px, bumpy(px, pz, 0, 0.2f), pz);
                roof[c] = daft_v3(px, bumpy(px, pz, 3.2f, 0.3f), pz);
            }
            quad(k, floor);
            quad(k, roof);
        }
    static const int away[4][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
    for (int w = 0; w < 4; w++) {
        if (k->open[cx + away[w][0]][cz + away[w][1]]) continue;
        for (int j = 0; j < SUB; j++) {
            daft_vec3 p[4];
            for (int c = 0; c < 4; c++) {
                float along = ((float)j + (c == 1 || c == 2 ? 1.0f : 0.0f)) * step;
                float px = (float)cx * cell + (away[w][0] ? (away[w][0] > 0 ? cell : 0) : along);
                float pz = (float)cz * cell + (away[w][1] ? (away[w][1] > 0 ? cell : 0) : along);
                p[w == 1 || w == 2 ? 3 - c : c] =
                    daft_v3(px, c < 2 ? bumpy(px, pz, 0, 0.2f) : bumpy(px, pz, 3.2f, 0.3f), pz);
            }
            quad(k, p);
        }
    }
}

/* A walk of a miner through the rock. */
static fixture_mesh make_cave(cave *k, const variant *v)
{
    memset(k, 0, sizeof *k);
    k->points = malloc(200000 * sizeof *k->points);
    k->index = malloc(300000 * sizeof *k->index);
    int x = CAVE / 2, z = CAVE / 2;
    for (int i = 0; i < 90; i++) {
        k->open[x][z] = true;
        int dir = (int)uniform(0, 4);
        int nx = x + (dir == 0) - (dir == 1), nz = z + (dir == 2) - (dir == 3);
        if (nx > 0 && nx < CAVE - 1 && nz > 0 && nz < CAVE - 1) x = nx, z = nz;
    }
    for (x = 1; x < CAVE - 1; x++)
        for (z = 1; z < CAVE - 1; z++)
            if (k->open[x][z]) cave_cell(k, x, z);
    fixture_mesh mesh = variant_mesh(v, k->points, k->vertices, k->index, k->triangles);
    free(k->points);
    free(k->index);
    return mesh;
}

static bool is_in_cave(const cave *k, daft_dvec3 p)
{
    int x = (int)floor(p.x / 2), z = (int)floor(p.z / 2);
    return x > 0 && z > 0 && x < CAVE && z < CAVE && k->open[x][z] && p.y > 0 && p.y < 3;
}

static uint64_t wander(daft_world *world, const cave *k, const variant *v, double *far)
{
    double middle = CAVE / 2 * 2 + 1;
    daft_sim_character c = walker(v->side * middle, 0.5, middle);
    variant place = *v;
    place.origin = centre;
    double vx = 0, vz = 0;
    int still = 0;
    *far = 0;
    uint64_t hash = 1;
    for (int i = 0; i < 3600; i++) {
        if (i % 25 == 0 && still < 15) {
            double heading = uniform(0, 2 * DAFT_PI), speed = uniform(2, 9);
            vx = speed * daft_cos(heading), vz = speed * daft_sin(heading);
        }
        daft_dvec3 before = c.position;
        go(world, &c, v->side * vx, vz, i % 120 == 60 ? 5 : 0);
        daft_dvec3 d = daft_dsub(c.position, before), local = variant_from(&place, c.position);
        if (!is_in_cave(k, local)) fail_msg("outside at tick %d: %g %g %g", i, local.x, local.y, local.z);
        *far += sqrt(d.x * d.x + d.z * d.z);
        /* Facing a wall or a corner it may stand; but then it turns round, and there is a way back. */
        still = d.x * d.x + d.z * d.z < 1e-8 ? still + 1 : 0;
        if (still == 15) vx = -vx, vz = -vz;
        if (still > 15 + 29) fail_msg("stuck at tick %d: %g %g %g", i, local.x, local.y, local.z);
        hash = daft_sim_character_hash(&c, hash);
    }
    return hash;
}

/* Triangles of two sides, of one, and of two at 14,000 km. */
static uint64_t minutes_in_caves(const variant *v)
{
    uint64_t hash = 0;
    for (int round = 0; round < 3; round++) {
        double far = 0;
        centre = round == 2 ? daft_dadd(v->origin, daft_dv3(1e7, 0, -1e7)) : v->origin;
        daft_world *world = variant_world(v);
        daft_error error = {0};
        cave k;
        seed_random(40 + (uint64_t)round);
        fixture_mesh mesh = make_cave(&k, v);
        daft_mesh_shape *shape = daft_mesh_shape_create(&heap, &mesh.mesh, mesh.bvh, round == 1, &error);
        one_shape def = body_def(DAFT_BODY_STATIC, centre);
        def.part.shape = daft_shape_mesh(shape);
        add(world, def);
        hash = hash_of_both(hash, wander(world, &k, v, &far));
        print_message("%g m in a minute\n", far);
        assert_true(far > 60);
        daft_world_destroy(world);
        daft_mesh_shape_free(shape);
        mesh_drop(&mesh);
    }
    centre = daft_dv3(0, 0, 0);
    return hash;
}

static void a_minute_in_a_cave(void **state)
{
    (void)state;
    play_variants(minutes_in_caves);
}

/* A flat floor of many triangles is felt no more than one of a single box. */
static void seams_are_not_felt(void **state)
{
    (void)state;
    enum { N = 40 };
    centre = daft_dv3(0, 0, 0);
    daft_vec3 *p = malloc((N + 1) * (N + 1) * sizeof *p);
    uint32_t *index = malloc(6 * N * N * sizeof *index), count = 0;
    for (int i = 0; i <= N; i++)
        for (int j = 0; j <= N; j++) p[i * (N + 1) + j] = daft_v3((float)i * 0.37f, 0, (float)j * 0.37f);
    for (uint32_t i = 0; i < N; i++)
        for (uint32_t j = 0; j < N; j++) {
            uint32_t a = i * (N + 1) + j, b = a + 1, c = a + N + 1, d = c + 1;
            const uint32_t list[6] = {a, b, d, a, d, c};
            memcpy(index + count, list, sizeof list);
            count += 6;
        }
    fixture_mesh mesh = mesh_make(p, (N + 1) * (N + 1), index, count / 3);
    free(p);
    free(index);
    daft_world *world = new_world();
    daft_error error = {0};
    daft_mesh_shape *shape = daft_mesh_shape_create(&heap, &mesh.mesh, mesh.bvh, false, &error);
    one_shape def = body_def(DAFT_BODY_STATIC, daft_dv3(0, 0, 0));
    def.part.shape = daft_shape_mesh(shape);
    add(world, def);
    for (int heading = 0; heading < 40; heading++) {
        double angle = 2 * DAFT_PI * heading / 40, vx = 5 * daft_cos(angle), vz = 5 * daft_sin(angle);
        daft_sim_character c = walker(7.4, 0, 7.4);
        walk(world, &c, vx, vz, 20);
        daft_dvec3 from = c.position;
        for (int i = 0; i < 55; i++) {
            go(world, &c, vx, vz, 0);
            assert_true(c.grounded);
            assert_near(c.position.y, from.y, 1e-3);
        }
        assert_near(c.position.x - from.x, vx * 55 / 60, 2e-3);
        assert_near(c.position.z - from.z, vz * 55 / 60, 2e-3);
    }
    daft_world_destroy(world);
    daft_mesh_shape_free(shape);
    mesh_drop(&mesh);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_minute_in_a_cave),
        cmocka_unit_test(seams_are_not_felt),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
