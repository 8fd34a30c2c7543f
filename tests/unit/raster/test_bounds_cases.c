/* Screen boxes against exact ones: every row of tests/data/cases/bounds_cases.csv names a triangle, a sphere or a box,
 * the number of the 64 × 48 pixel centres that it covers, and the rectangle around them, all found with exact rational
 * arithmetic: px = 32 + 24·X/-Z, py = 24 - 24·Y/-Z, near plane at 0.125.
 *
 * The pencil on every instruction set and the reference path must see each row's pixels (hit_open <= count <=
 * hit_closed), and the boxes by which the pencil finds candidates must hold the whole rectangle. The engine has no near
 * plane: what it sees is counted where the instance goes on to a depth of 0.125 or more. */
#include "fixtures.h"

#include "math/exact.h"
#include "raster/raster.h"

#define NEAR 0.125

enum { WIDTH = 64, HEIGHT = 48, PIXELS = WIDTH * HEIGHT, MAX_ROWS = 4096 };

typedef enum kind { TRIANGLE, SPHERE, BOX } kind;

typedef struct row {
    char id[32];
    kind kind;
    float g[9];
    int closed, open;
    bool some; /* whether there is a rectangle */
    int x0, x1, y0, y1;
} row;

static row rows[MAX_ROWS];
static int row_count;

/* ---- reading ---- */

/* Cuts the line up. */
static bool row_parse(char *line, row *out)
{
    char kind_name[16] = "";
    char *field = line;
    *out = (row){.closed = 0};
    for (int column = 0; column < 17 && field; column++) {
        char *next = strchr(field, ',');
        if (next) *next++ = 0;
        if (column == 0) snprintf(out->id, sizeof out->id, "%.31s", field);
        if (column == 1) snprintf(kind_name, sizeof kind_name, "%.15s", field);
        if (column >= 2 && column < 11) out->g[column - 2] = strtof(field, NULL);
        int number = (int)strtol(field, NULL, 10);
        if (column == 11) out->closed = number;
        if (column == 12) out->open = number;
        if (column == 13) out->x0 = number, out->some = *field != 0;
        if (column == 14) out->x1 = number;
        if (column == 15) out->y0 = number;
        if (column == 16) out->y1 = number;
        field = next;
    }
    out->kind = strcmp(kind_name, "tri") == 0 ? TRIANGLE : strcmp(kind_name, "sphere") == 0 ? SPHERE : BOX;
    return field != NULL;
}

static void rows_load(void)
{
    if (row_count) return;
    char line[1024];
    FILE *file = fopen(DAFT_ROOT "/tests/data/cases/bounds_cases.csv", "r");
    assert_non_null(file);
    if (!fgets(line, sizeof line, file)) fail_msg("bounds_cases.csv is empty");
    while (row_count < MAX_ROWS && fgets(line, sizeof line, file))
        if (row_parse(line, &rows[row_count])) row_count++;
    fclose(file);
    assert_true(row_count > 40);
}

static daft_vec3 corner_of(const row *r, int k) { return daft_v3(r->g[3 * k], r->g[3 * k + 1], r->g[3 * k + 2]); }

/* ---- instances ---- */

static fixture_mesh triangle_mesh(daft_vec3 a, daft_vec3 b, daft_vec3 c)
{
    const daft_vec3 p[3] = {a, b, c};
    const uint32_t index[3] = {0, 1, 2};
    return mesh_make(p, 3, index, 1);
}

/* Corner i has bit k of i set where its k-th coordinate is the high one. */
static fixture_mesh box_mesh(const float g[6])
{
    static const uint32_t index[36] = {0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5, 0, 1, 5, 0, 5, 4,
                                       2, 6, 7, 2, 7, 3, 0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6};
    daft_vec3 p[8];
    for (int i = 0; i < 8; i++) p[i] = daft_v3(g[i & 1 ? 3 : 0], g[i & 2 ? 4 : 1], g[i & 4 ? 5 : 2]);
    return mesh_make(p, 8, index, 12);
}

static daft_affine still(void) { return affine_make(daft_quat_identity(), daft_v3(1, 1, 1), daft_v3(0, 0, 0)); }

/* ---- seeing ---- */

typedef struct sight {
    bool hit[PIXELS];
    bool found; /* some candidate box */
    int x0, x1, y0, y1;
    bool seen; /* the whole instance's box */
    int seen_x0, seen_x1, seen_y0, seen_y1;
} sight;

static daft_pencil file_pencil(void)
{
    return (daft_pencil){
        .right = {1, 0, 0}, .up = {0, 1, 0}, .forward = {0, 0, -1}, .focal = 24, .width = WIDTH, .height = HEIGHT};
}

static void keep_box(sight *out, int x0, int x1, int y0, int y1)
{
    if (x0 > x1 || y0 > y1) return;
    out->found = true;
    out->x0 = daft_min_i(out->x0, x0), out->x1 = daft_max_i(out->x1, x1);
    out->y0 = daft_min_i(out->y0, y0), out->y1 = daft_max_i(out->y1, y1);
}

static void keep_boxes(const daft_raster *raster, int isa, sight *out)
{
    daft_screen_box boxes[12];
    const daft_view_instance *s = &raster->visible[0];
    out->found = false, out->x0 = WIDTH, out->y0 = HEIGHT, out->x1 = out->y1 = -1;
    out->seen = s->instance != NULL;
    if (!out->seen) return;
    out->seen_x0 = s->x0, out->seen_x1 = s->x1, out->seen_y0 = s->y0, out->seen_y1 = s->y1;
    if (!s->instance->mesh)
        keep_box(out, s->x0, s->x1, s->y0, s->y1);
    else if (isa >= 0)
        daft_raster_kernels_for(isa)->boxes(raster, 0, boxes);
    for (uint32_t i = 0; isa >= 0 && s->instance->mesh && i < s->instance->mesh->triangle_count; i++)
        keep_box(out, boxes[i].x0, boxes[i].x1, boxes[i].y0, boxes[i].y1);
}

/* isa < 0: the reference path, which has no candidate boxes. */
static void see(const daft_instance *instance, int isa, sight *out)
{
    static daft_tile tile;
    daft_allocator allocator = daft_malloc_allocator();
    daft_pencil pencil = file_pencil();
    daft_raster raster;
    daft_arena arena;
    daft_arena_init(&arena, &allocator);
    assert_true(daft_raster_init(&raster, &allocator, 1, daft_isa_best(), NULL));
    assert_true(daft_raster_begin(&raster, &pencil, instance, 1, NULL));
    const daft_tlas *tlas = daft_tlas_build(&arena, instance, 1, NULL);
    assert_non_null(tlas);
    for (uint32_t i = 0; i < raster.work_count; i++) daft_raster_bin(&raster, i, 0);
    for (uint32_t i = 0; i < (uint32_t)(raster.tiles_x * raster.tiles_y); i++) {
        if (isa >= 0)
            daft_raster_kernels_for(isa)->tile(&raster, i, 0, NULL, &tile);
        else
            daft_reference_tile(&raster, tlas, i, NULL, &tile);
        for (int at = 0; at < tile.width * tile.height; at++) {
            int x = at % tile.width, y = at / tile.width;
            out->hit[(tile.y + y) * WIDTH + tile.x + x] = tile.instance[y * DAFT_TILE_STRIDE + x] != DAFT_NOTHING;
        }
    }
    keep_boxes(&raster, isa, out);
    daft_raster_free(&raster);
    daft_arena_free(&arena);
}

/* ---- the near plane ---- */

/* The depth at which the ray leaves the instance, in double. A little is allowed for rounding: the file has instances
 * that lie exactly in the near plane, and none that end within a millionth of it. */
static double exit_depth(const row *r, daft_vec3 d)
{
    if (r->kind == TRIANGLE) {
        daft_vec3 c[3];
        for (int k = 0; k < 3; k++) c[k] = daft_v3(r->g[3 * k], r->g[3 * k + 1], -r->g[3 * k + 2]);
        return daft_pencil_depth(c[0], c[1], c[2], d);
    }
    daft_dvec3 ray = daft_to_double(d);
    if (r->kind == SPHERE) {
        daft_dvec3 c = daft_dv3((double)r->g[0], (double)r->g[1], -(double)r->g[2]);
        double dd = daft_ddot(ray, ray), along = daft_ddot(c, ray) / dd;
        daft_dvec3 aside = daft_dsub(c, daft_dscale(ray, along));
        double square = (double)r->g[3] * (double)r->g[3] - daft_ddot(aside, aside);
        return (along + sqrt(square > 0 ? square / dd : 0)) * ray.z;
    }
    const double direction[3] = {ray.x, ray.y, -ray.z};
    double far = INFINITY;
    for (int k = 0; k < 3; k++) {
        double a = (double)r->g[k] / direction[k], b = (double)r->g[k + 3] / direction[k];
        if (direction[k] != 0 && fmax(a, b) < far) far = fmax(a, b);
    }
    return far * ray.z;
}

static int count_beyond(const row *r, const sight *s)
{
    daft_pencil pencil = file_pencil();
    int count = 0;
    for (int i = 0; i < PIXELS; i++)
        count += s->hit[i] && exit_depth(r, daft_pencil_ray(&pencil, i % WIDTH, i / WIDTH)) >= NEAR - 1e-9;
    return count;
}

/* ---- tests ---- */

static bool boxes_hold(const row *r, const sight *s)
{
    if (!r->some || r->open == 0) return true; /* what has no area need not be looked for */
    return s->found && s->x0 <= r->x0 && r->x1 <= s->x1 && s->y0 <= r->y0 && r->y1 <= s->y1 && s->seen &&
           s->seen_x0 <= r->x0 && r->x1 <= s->seen_x1 && s->seen_y0 <= r->y0 && r->y1 <= s->seen_y1;
}

static void check_row(const row *r, const daft_instance *instance)
{
    sight pencil, reference;
    see(instance, -1, &reference);
    for (int isa = 0; isa <= daft_isa_best(); isa++) {
        see(instance, isa, &pencil);
        int count = count_beyond(r, &pencil);
        if (count < r->open || count > r->closed)
            fail_msg("%s, %s: %d pixels, not %d to %d", r->id, daft_isa_name(isa), count, r->open, r->closed);
        if (!boxes_hold(r, &pencil))
            fail_msg("%s, %s: %d..%d, %d..%d are looked at (of %d..%d, %d..%d), not all of %d..%d, %d..%d", r->id,
                     daft_isa_name(isa), pencil.x0, pencil.x1, pencil.y0, pencil.y1, pencil.seen_x0, pencil.seen_x1,
                     pencil.seen_y0, pencil.seen_y1, r->x0, r->x1, r->y0, r->y1);
        if (memcmp(pencil.hit, reference.hit, sizeof pencil.hit) != 0)
            fail_msg("%s, %s: the pencil and the reference path see different pixels", r->id, daft_isa_name(isa));
    }
}

static void every_row(void **unused)
{
    (void)unused;
    rows_load();
    int done[3] = {0, 0, 0};
    for (int i = 0; i < row_count; i++) {
        const row *r = &rows[i];
        if (r->kind == SPHERE) {
            daft_instance instance = sphere_make(corner_of(r, 0), r->g[3]);
            check_row(r, &instance);
        } else {
            fixture_mesh mesh =
                r->kind == BOX ? box_mesh(r->g) : triangle_mesh(corner_of(r, 0), corner_of(r, 1), corner_of(r, 2));
            daft_instance instance = instance_make(&mesh, still());
            check_row(r, &instance);
            mesh_drop(&mesh);
        }
        done[r->kind]++;
    }
    print_message("%d triangles, %d spheres, %d boxes\n", done[TRIANGLE], done[SPHERE], done[BOX]);
}

static void see_triangle(daft_vec3 a, daft_vec3 b, daft_vec3 c, int isa, sight *out)
{
    fixture_mesh mesh = triangle_mesh(a, b, c);
    daft_instance instance = instance_make(&mesh, still());
    see(&instance, isa, out);
    mesh_drop(&mesh);
}

/* Each triangle is cut into three around a point within it, and has a neighbour put beside each edge: the parts cover
 * what the whole covers, each pixel once; no neighbour covers a pixel of it. */
static void neighbours(void **unused)
{
    (void)unused;
    rows_load();
    fixture_seed(71);
    int cut = 0, beside = 0;
    for (int i = 0; i < row_count; i++) {
        if (rows[i].kind != TRIANGLE || rows[i].closed == 0) continue;
        daft_vec3 c[3] = {corner_of(&rows[i], 0), corner_of(&rows[i], 1), corner_of(&rows[i], 2)}, middle = {0, 0, 0};
        float w[3] = {random_float(0.1f, 1), random_float(0.1f, 1), random_float(0.1f, 1)}, sum = w[0] + w[1] + w[2];
        for (int k = 0; k < 3; k++) middle = daft_add(middle, daft_scale(c[k], w[k] / sum));
        bool inside = daft_pencil_hits(c[0], c[1], c[2], middle);
        for (int isa = 0; isa <= daft_isa_best(); isa++) {
            sight whole, part[3], next;
            see_triangle(c[0], c[1], c[2], isa, &whole);
            for (int k = 0; k < 3; k++) {
                daft_vec3 a = c[k], b = c[(k + 1) % 3], mirror = daft_sub(daft_add(a, b), c[(k + 2) % 3]);
                see_triangle(a, b, middle, isa, &part[k]);
                bool apart = daft_det_sign(a, b, mirror) == -daft_det_sign(a, b, c[(k + 2) % 3]);
                if (!apart) continue;
                see_triangle(b, a, mirror, isa, &next);
                for (int at = 0; at < PIXELS; at++)
                    if (whole.hit[at] && next.hit[at]) fail_msg("%s: pixel %d is shaded twice", rows[i].id, at);
                beside++;
            }
            for (int at = 0; inside && at < PIXELS; at++) {
                int parts = part[0].hit[at] + part[1].hit[at] + part[2].hit[at];
                if (parts != whole.hit[at])
                    fail_msg("%s, %s: pixel %d, %d has %d of the parts", rows[i].id, daft_isa_name(isa), at % WIDTH,
                             at / WIDTH, parts);
            }
            cut += inside;
        }
    }
    print_message("%d triangles cut, %d neighbours\n", cut, beside);
    assert_true(cut > 15 && beside > 45);
}

/* The file's square whose outline runs through pixel centres, cut along either diagonal: the halves cover the open
 * square at least, the closed one at most, and nothing twice. */
static void complements(void **unused)
{
    (void)unused;
    rows_load();
    const row *left = NULL, *right = NULL;
    for (int i = 0; i < row_count; i++) {
        if (strcmp(rows[i].id, "tri_b02") == 0) left = &rows[i];
        if (strcmp(rows[i].id, "tri_b04") == 0) right = &rows[i];
    }
    assert_true(left && right);
    daft_vec3 a = corner_of(left, 0), b = corner_of(left, 1), c = corner_of(left, 2), d = corner_of(right, 2);
    const daft_vec3 halves[2][2][3] = {{{a, b, c}, {b, d, c}}, {{a, b, d}, {a, d, c}}};
    for (int isa = 0; isa <= 2 * daft_isa_best() + 1; isa++) {
        const daft_vec3(*half)[3] = halves[isa % 2];
        sight s[2];
        int once = 0, twice = 0;
        for (int k = 0; k < 2; k++) see_triangle(half[k][0], half[k][1], half[k][2], isa / 2, &s[k]);
        for (int at = 0; at < PIXELS; at++) {
            int x = at % WIDTH, y = at / WIDTH, parts = s[0].hit[at] + s[1].hit[at];
            once += parts == 1, twice += parts == 2;
            if (x > 10 && x < 20 && y > 10 && y < 20) assert_int_equal(parts, 1);
        }
        assert_int_equal(twice, 0);
        assert_true(once >= 81 && once <= 121);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(every_row), cmocka_unit_test(neighbours),
                                       cmocka_unit_test(complements)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
