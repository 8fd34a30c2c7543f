/* Light through bodies of glass: where Snell's law and Fresnel's equations put it, in closed form and against a
 * double-precision tracer of spheres; each surface counted once, at every scale and place; and nothing spent where no
 * light passes. */
#include "hard_scenes.h"

enum { WIDTH = 160, HEIGHT = 120, RINGS = 40 };

static int encoded(double linear)
{
    double e = linear <= 0.0031308 ? 12.92 * linear : 1.055 * pow(linear, 1 / 2.4) - 0.055;
    return (int)floor(255 * fmin(fmax(e, 0), 1) + 0.5);
}

/* No light of its own, no highlight: what is seen came through, or was mirrored. */
static daft_material glass(stage *s, float index, daft_vec3 tint)
{
    daft_material_def def = daft_default_material_def();
    daft_error error = {0};
    def.specular = daft_v3(0, 0, 0), def.transmission = 1, def.transmission_tint = tint, def.refractive_index = index;
    daft_material out = daft_material_create(s->scene, &def, &error);
    if (!out.id) fail_msg("%s", error.message);
    return out;
}

static daft_material glowing(stage *s, daft_vec3 emission)
{
    daft_material_def def = daft_default_material_def();
    def.diffuse = def.ambient = def.specular = daft_v3(0, 0, 0), def.emission = emission;
    daft_material out = daft_material_create(s->scene, &def, NULL);
    assert_true(out.id);
    return out;
}

static const daft_vec3 WHITE = {1, 1, 1}, BLACK = {0, 0, 0};

/* The fraction that is mirrored, from the sines: Fresnel as in the textbook, not as the kernel writes it. */
static double fresnel(double cosine, double from, double to)
{
    double sine = from / to * sqrt(fmax(0, 1 - cosine * cosine));
    if (sine >= 1) return 1;
    double a = acos(cosine), b = asin(sine);
    if (a < 1e-6) return (from - to) / (from + to) * ((from - to) / (from + to));
    double s = sin(a - b) / sin(a + b), p = tan(a - b) / tan(a + b);
    return (s * s + p * p) / 2;
}

/* ---- closed forms ---- */

/* A thick pane before a wall of glowing stripes: a ray goes on in parallel, aside by d·sin(a - b) / cos b, and what
 * comes through two surfaces is (1 - F) times (1 - F), the light that goes to and fro within coming on top. */
static void pane_shifts_by_snell(void **unused)
{
    (void)unused;
    const double thick = 1.5, index = 1.5, wall = 6, stripe = 0.5;
    stage *s = stage_make(WIDTH, HEIGHT, NULL, 2);
    daft_scene_set_sky_color(s->scene, BLACK);
    for (int i = -40; i < 40; i++)
        add(s, box(daft_dv3(wall + 0.5, 0, (i + 0.5) * stripe), daft_v3(1, 100, (float)stripe),
                   glowing(s, i % 2 ? BLACK : WHITE)));
    add(s, box(daft_dv3(2 + thick / 2, 0, 0), daft_v3((float)thick, 100, 100), glass(s, (float)index, WHITE)));
    s->view.camera.fov = 1.8f, s->view.quality = daft_preset_quality(DAFT_PRESET_DRAFT);
    const daft_counters *c = draw(s);
    assert_true(c->refraction_rays == 2 * WIDTH * HEIGHT && c->effects[DAFT_EFFECT_REFRACTION].ran);
    int looked = 0, wrong = 0, moved = 0;
    for (int i = 0; i < s->pixels; i++) {
        daft_dvec3 d = pixel_ray(s, i % WIDTH, i / WIDTH);
        double across = sqrt(d.y * d.y + d.z * d.z), length = sqrt(daft_ddot(d, d));
        double sine = across / length / index, inside = thick * sine / sqrt(1 - sine * sine);
        double reach = (wall - thick) * across / d.x + inside, z = across > 0 ? reach * d.z / across : 0;
        double in_stripes = z / stripe - floor(z / stripe), straight = wall * d.z / d.x / stripe;
        if (in_stripes < 0.02 || in_stripes > 0.98) continue;
        bool bright = ((int)floor(z / stripe) & 1) == 0;
        looked++, wrong += pixel(s, i % WIDTH, i / WIDTH)[0] != (bright ? 255 : 0);
        moved += bright != (((int)floor(straight) & 1) == 0);
    }
    assert_true(looked > s->pixels * 9 / 10 && moved > s->pixels / 10);
    assert_int_equal(wrong, 0);
    stage_drop(s);
}

/* From under water, a white sky fills a cone of twice asin(1 / 1.33); at its rim it fades as Fresnel says, and beyond
 * it the surface mirrors the black floor. */
static void window_of_snell(void **unused)
{
    (void)unused;
    const double index = (double)1.33f;
    stage *s = stage_make(WIDTH, HEIGHT, NULL, 2);
    daft_scene_set_sky_color(s->scene, WHITE);
    add(s, box(daft_dv3(0, -5, 0), daft_v3(1e4f, 10, 1e4f), glass(s, (float)index, WHITE)));
    add(s, box(daft_dv3(0, -8, 0), daft_v3(1e4f, 1, 1e4f), glowing(s, BLACK)));
    s->view.camera.position = daft_dv3(3, -2, 1), s->view.camera.pitch = -1.57f, s->view.camera.fov = 2;
    draw(s);
    int bright = 0, dark = 0;
    for (int i = 0; i < s->pixels; i++) {
        daft_dvec3 d = pixel_ray(s, i % WIDTH, i / WIDTH);
        double cosine = d.y / sqrt(daft_ddot(d, d)), fraction = fresnel(cosine, index, 1);
        if (fraction < 1 && fraction > 0.9) continue; /* within a pixel's width the light goes from some to none */
        int expected = encoded(1 - fraction), value = pixel(s, i % WIDTH, i / WIDTH)[1];
        if (abs(value - expected) > 1) fail_msg("pixel %d: %d, not %d", i, value, expected);
        bright += fraction < 0.1, dark += fraction == 1;
    }
    assert_true(bright > 2000 && dark > 1000);
    stage_drop(s);
}

/* ---- a tracer of spheres in double ---- */

typedef struct ball {
    daft_dvec3 centre;
    double radius, index; /* index 0: lets nothing through */
    daft_vec3 color;      /* what it glows with, or its tint */
} ball;

typedef struct world {
    const ball *balls;
    int count, mirrors, surfaces; /* how deep the quality goes */
} world;

/* As daft_scene_set_sky_gradient describes it, with these two colours. */
static const daft_vec3 ZENITH = {0.1f, 0.2f, 0.9f}, HORIZON = {0.9f, 0.8f, 0.4f};

static void sky_light(daft_dvec3 d, double out[3])
{
    double y = d.y / sqrt(daft_ddot(d, d)), rise = sqrt(fabs(y)), shade = 1 + fmin(y, 0) / 3;
    const float *z = &ZENITH.x, *h = &HORIZON.x;
    for (int k = 0; k < 3; k++) out[k] = ((double)h[k] + ((double)z[k] - (double)h[k]) * rise) * shade;
}

static double hit_ball(const ball *b, daft_dvec3 o, daft_dvec3 d)
{
    daft_dvec3 c = daft_dsub(b->centre, o);
    double along = daft_ddot(c, d), root = along * along - daft_ddot(c, c) + b->radius * b->radius;
    if (root < 0) return INFINITY;
    double near = along - sqrt(root), far = along + sqrt(root);
    return near > 1e-9 ? near : far > 1e-9 ? far : INFINITY;
}

/* d is unit. */
static void trace_light(const world *w, daft_dvec3 o, daft_dvec3 d, int depth, double out[3])
{
    const ball *b = NULL;
    double t = INFINITY;
    for (int i = 0; i < w->count; i++) {
        double at = hit_ball(&w->balls[i], o, d);
        if (at < t) t = at, b = &w->balls[i];
    }
    out[0] = out[1] = out[2] = 0;
    if (!b) {
        sky_light(d, out);
        return;
    }
    const float *color = &b->color.x;
    if (b->index == 0 || depth >= w->surfaces) {
        for (int k = 0; k < 3; k++) out[k] = b->index == 0 ? (double)color[k] : 0;
        return;
    }
    daft_dvec3 p = daft_dadd(o, daft_dscale(d, t)), n = daft_dscale(daft_dsub(p, b->centre), 1 / b->radius);
    bool inside = daft_ddot(n, d) > 0;
    if (inside) n = daft_dscale(n, -1);
    double from = inside ? b->index : 1, to = inside ? 1 : b->index, cosine = fmin(-daft_ddot(n, d), 1);
    double back = fresnel(cosine, from, to), eta = from / to, light[3];
    if (depth >= w->mirrors && back < 1) back = 0;
    if (back > 0) {
        trace_light(w, p, daft_dadd(d, daft_dscale(n, 2 * cosine)), depth + 1, light);
        for (int k = 0; k < 3; k++) out[k] += back * light[k];
    }
    if (back == 1) return;
    double beyond = sqrt(1 - eta * eta * (1 - cosine * cosine));
    trace_light(w, p, daft_dadd(daft_dscale(d, eta), daft_dscale(n, eta * cosine - beyond)), depth + 1, light);
    for (int k = 0; k < 3; k++) out[k] += (1 - back) * (double)color[k] * light[k];
}

/* The tracer's colour of a place in the picture. False: a little aside it is another one, so rounding decides. */
static bool steady_color(const stage *s, const world *w, int x, int y, int color[3])
{
    for (int k = 0; k < 5; k++) {
        double light[3], aside[5][2] = {{0, 0}, {1, 0}, {-1, 0}, {0, 1}, {0, -1}};
        daft_dvec3 a = pixel_ray(s, x, y), b = pixel_ray(s, x + 1, y), c = pixel_ray(s, x, y + 1);
        daft_dvec3 d = daft_dadd(a, daft_dadd(daft_dscale(daft_dsub(b, a), 2e-3 * aside[k][0]),
                                              daft_dscale(daft_dsub(c, a), 2e-3 * aside[k][1])));
        trace_light(w, s->view.camera.position, daft_dscale(d, 1 / sqrt(daft_ddot(d, d))), 0, light);
        for (int i = 0; i < 3; i++) {
            int value = encoded(light[i]);
            if (k == 0) color[i] = value;
            if (abs(value - color[i]) > 1) return false;
        }
    }
    return true;
}

static void compare_with_tracer(stage *s, const world *w, const char *what)
{
    daft_scene_set_sky_gradient(s->scene, ZENITH, HORIZON);
    for (int i = 0; i < w->count; i++) {
        const ball *b = &w->balls[i];
        add(s, sphere(b->centre, (float)b->radius,
                      b->index > 0 ? glass(s, (float)b->index, b->color) : glowing(s, b->color)));
    }
    s->view.quality.samples = 1, s->view.quality.edge_samples = 0;
    draw(s);
    int looked = 0, far_off = 0;
    for (int i = 0; i < s->pixels; i++) {
        int color[3] = {0, 0, 0};
        const uint8_t *p = pixel(s, i % WIDTH, i / WIDTH);
        if (!steady_color(s, w, i % WIDTH, i / WIDTH, color)) continue;
        looked++;
        for (int k = 0; k < 3; k++)
            if (abs(color[k] - p[k]) > 2) {
                far_off++;
                break;
            }
    }
    print_message("%s: %d of %d pixels are not as traced in double\n", what, far_off, looked);
    assert_true(looked > s->pixels * 3 / 4);
    assert_int_equal(far_off, 0);
}

/* The sky upside down within the ball, and a light's image where the lens maker's formula has it. */
static void ball_is_a_lens(void **unused)
{
    (void)unused;
    const ball balls[] = {{{4, 0, 0}, 1, 1.5, {1, 1, 1}}, {{12, 0.35, 0.5}, 0.2, 0, {1, 0, 0}}};
    world w = {balls, 2, 2, 12};
    stage *s = stage_make(WIDTH, HEIGHT, NULL, 2);
    s->view.camera.fov = 0.7f;
    compare_with_tracer(s, &w, "ball");
    /* Paraxial rays of a ball of index 1.5 meet 1.5 r behind its centre if they come from afar; the light 8 away is
     * seen at 1 / (1/1.5 - 1/8) = 1.846 before it, smaller and on the other side. */
    double distance = 1 / (1 / 1.5 - 1.0 / 8), size = distance / 8, away = 4 - distance;
    int x = (int)(WIDTH / 2.0 - WIDTH / 2.0 / daft_tan(0.35) * 0.5 * size / away);
    int y = (int)(HEIGHT / 2.0 + WIDTH / 2.0 / daft_tan(0.35) * 0.35 * size / away);
    const uint8_t *p = pixel(s, x, y);
    assert_true(p[0] > 200 && p[2] < 120);
    stage_drop(s);
}

static void balls_among_balls(void **unused)
{
    (void)unused;
    /* side by side, one within another, one of air in glass, a diamond, an opaque one inside, one that holds the camera
     */
    const ball balls[] = {
        {{5, 0.3, -1.3}, 1, 1.5, {1, 0.5, 0.5}},        {{7, -0.2, 0.6}, 1.2, (double)1.33f, {1, 1, 1}},
        {{5, -0.6, 0.9}, 0.7, 1.5, {0.4f, 1, 0.6f}},    {{5, 0.3, -1.3}, 0.5, 0.625, {1, 1, 1}},
        {{7, -0.2, 0.6}, 0.3, 0, {0.9f, 0.9f, 0.1f}},   {{4, 0.9, 0.5}, 0.3, (double)2.42f, {1, 1, 1}},
        {{0, 0, 0}, 1.5, (double)1.2f, {0.9f, 0.9f, 1}}};
    static const struct {
        daft_preset quality;
        int mirrors, surfaces;
    } kinds[] = {{DAFT_PRESET_DRAFT, 0, 6}, {DAFT_PRESET_GAME, 2, 12}, {DAFT_PRESET_HIGH, 6, 16}};
    for (int k = 0; k < 3; k++)
        for (int inside = 0; inside < 2; inside++) {
            world w = {balls, inside ? 7 : 6, kinds[k].mirrors, kinds[k].surfaces};
            stage *s = stage_make(WIDTH, HEIGHT, NULL, 2);
            s->view.quality = daft_preset_quality(kinds[k].quality), s->view.camera.fov = inside ? 1.2f : 0.9f;
            if (inside) s->view.camera.position = daft_dv3(-0.7, 0.3, 0.2);
            compare_with_tracer(s, &w, daft_preset_name(kinds[k].quality));
            stage_drop(s);
        }
}

/* ---- each surface once, at every scale ---- */

static uint64_t state = 11;

static float any(float low, float high)
{
    state = state * 6364136223846793005u + 1442695040888963407u;
    return low + (high - low) * (float)(state >> 40) * 0x1p-24f;
}

/* One number after the other: in which order arguments are taken, compilers decide for themselves. */
static daft_quat any_turn(void)
{
    float x = any(-1, 1), y = any(-1, 1), z = any(-1, 1), w = any(-1, 1);
    return daft_quat_normalize((daft_quat){x, y, z, w});
}

static daft_dvec3 any_way(void)
{
    float x = any(-1, 1), y = any(-1, 1), z = any(-1, 1);
    daft_dvec3 d = daft_to_double(daft_v3(x, y, z));
    double length = sqrt(daft_ddot(d, d));
    return length > 0.1 ? daft_dscale(d, 1 / length) : daft_dv3(0.6, 0.8, 0);
}

/* A closed ball of `rings` by 2·rings vertices and two poles. Few rings: flat facets; many: smooth normals. */
static daft_mesh ball_mesh(stage *s, uint32_t rings)
{
    static daft_vec3 p[2 * RINGS * RINGS + 2];
    static uint32_t index[12 * RINGS * RINGS];
    uint32_t columns = 2 * rings, n = 0, south = rings * columns, north = south + 1;
    for (uint32_t i = 0; i < south; i++) {
        double latitude = DAFT_PI * ((i / columns + 1.0) / (rings + 1.0) - 0.5);
        double longitude = 2 * DAFT_PI * (i % columns) / columns;
        p[i] = daft_to_float(daft_dv3(daft_cos(latitude) * daft_cos(longitude), daft_sin(latitude),
                                      daft_cos(latitude) * daft_sin(longitude)));
    }
    p[south] = daft_v3(0, -1, 0), p[north] = daft_v3(0, 1, 0);
    for (uint32_t j = 0; j < columns; j++) {
        uint32_t k = (j + 1) % columns, last = (rings - 1) * columns;
        const uint32_t caps[6] = {south, j, k, north, last + k, last + j};
        memcpy(index + 3 * n, caps, sizeof caps), n += 2;
        for (uint32_t i = 0; i + 1 < rings; i++) {
            uint32_t a = i * columns + j, b = i * columns + k;
            const uint32_t quad[6] = {a, a + columns, b, b, a + columns, b + columns};
            memcpy(index + 3 * n, quad, sizeof quad), n += 2;
        }
    }
    daft_mesh_def def = daft_default_mesh_def();
    def.positions = p, def.vertex_count = north + 1, def.indices = index, def.triangle_count = n;
    daft_mesh out = daft_mesh_create(s->scene, &def, NULL);
    assert_true(out.id);
    return out;
}

enum { SPHERE, BOX, FLAT, SMOOTH, MIRRORED, SQUASHED, KINDS };
static const char *const KIND_NAMES[KINDS] = {"spheres",      "boxes",          "flat balls",
                                              "smooth balls", "mirrored balls", "squashed balls"};

static daft_entity_def thing(stage *s, int kind, daft_dvec3 position, double radius, daft_material material)
{
    if (kind == SPHERE) return sphere(position, (float)radius, material);
    daft_entity_def def = box(position, daft_to_float(daft_dv3(radius, radius, 1.2 * radius)), material);
    if (kind >= FLAT) {
        daft_mesh mesh = ball_mesh(s, kind == SMOOTH ? RINGS : 3);
        def = instance(mesh, position, (float)radius, daft_quat_identity(), material);
    }
    if (kind == MIRRORED) def.scale.z = -def.scale.z;
    if (kind == SQUASHED) def.scale.x *= 0.5f, def.scale.y *= -0.8f;
    def.rotation = any_turn();
    return def;
}

typedef struct tally {
    int pictures, looked, wrong;
} tally;

/* Through two surfaces of one half: a quarter of the sky. A surface that is missed leaves a half (a leak), one that is
 * met twice an eighth (acne). Nothing at all: bent light that is still mirrored within after all the surfaces the
 * quality follows, which a ball of flat sides may do, and a sphere may not. */
static void count_quarters(const stage *s, bool may_be_lost, tally *t)
{
    int quarter = encoded(0.25);
    for (int i = 0; i < s->pixels; i++) {
        if (s->entity[i].id == 0) continue;
        int value = pixel(s, i % WIDTH, i / WIDTH)[0];
        t->looked++, t->wrong += value != quarter && !(may_be_lost && value == 0);
    }
    t->pictures++;
}

static void count_surfaces(int kind, float index, double radius, double away, tally *t)
{
    stage *s = stage_make(WIDTH, HEIGHT, NULL, 1);
    daft_dvec3 position = radius < 1 ? daft_dv3(40, 80, -3) : daft_dv3(-4e5, 80, 3e6);
    daft_entity_def def = thing(s, kind, position, radius, glass(s, index, daft_v3(0.5f, 0.5f, 0.5f)));
    daft_scene_set_sky_color(s->scene, WHITE);
    daft_dvec3 from = daft_dadd(def.position, daft_dscale(any_way(), radius * away));
    double fov = fmin(fmax(2.4 * daft_asin(1 / away), 2e-3), 2);
    s->view.camera = daft_camera_look_at(from, def.position, (float)fov);
    s->view.quality = daft_preset_quality(DAFT_PRESET_DRAFT); /* nothing is mirrored that can be refracted */
    add(s, def);
    draw(s);
    count_quarters(s, index > 1 && kind != SPHERE, t);
    stage_drop(s);
}

static void surfaces_count_once(void **unused)
{
    (void)unused;
    for (int kind = 0; kind < KINDS; kind++)
        for (int bent = 0; bent < 2; bent++) {
            tally t = {0, 0, 0};
            for (double radius = 1e-4; radius < 2e4; radius *= 10)
                for (double away = 1.3; away < 600; away *= 2.1)
                    count_surfaces(kind, bent ? 1.5f : 1, radius, away, &t);
            print_message("%s%s: %d pictures, %d of %d pixels are wrong\n", KIND_NAMES[kind], bent ? ", bent" : "",
                          t.pictures, t.wrong, t.looked);
            assert_true(t.looked > 200 * t.pictures);
            assert_int_equal(t.wrong, 0);
        }
}

/* ---- shadows ---- */

/* What arrives at a white floor below, by Lambert, straight under what is in between. */
static int floor_light(stage *s)
{
    draw(s);
    return pixel(s, WIDTH / 2, HEIGHT / 2)[1];
}

/* A thing that transmits dims the light behind it, once, however thick; two of them dim it twice; what is opaque, even
 * in part, keeps all of it away, and what is as clear as air none. */
static void shadows_let_light_through(void **unused)
{
    (void)unused;
    for (int by_light = 0; by_light < 2; by_light++) {
        stage *s = stage_make(WIDTH, HEIGHT, NULL, 2);
        daft_scene_set_ambient(s->scene, BLACK);
        add(s, box(daft_dv3(0, -0.5, 0), daft_v3(40, 1, 40), matte(s, WHITE, 0)));
        if (by_light)
            source(s, daft_dv3(0, 9, 0), 1);
        else
            sun(s, daft_v3(0, -1, 0), 1);
        s->view.camera = daft_camera_look_at(daft_dv3(-6, 1.5, 0), daft_dv3(0, 0, 0), 0.5f);
        assert_in_range(floor_light(s), 254, 255);
        assert_true(daft_scene_counters(s->scene)->shadow_rays == 0);
        daft_entity pane = add(s, box(daft_dv3(0, 4, 0), daft_v3(1, 0.1f, 1), glass(s, 1.5f, daft_v3(1, 0.5f, 1))));
        assert_in_range(floor_light(s), encoded(0.5) - 1, encoded(0.5) + 1);
        assert_true(daft_scene_counters(s->scene)->shadow_rays > 0);
        assert_true(daft_scene_counters(s->scene)->refraction_rays == 0); /* it is not seen */
        add(s, sphere(daft_dv3(0, 6, 0), 0.5f, glass(s, 1, daft_v3(1, 0.4f, 0))));
        assert_in_range(floor_light(s), encoded(0.2) - 1, encoded(0.2) + 1);
        assert_in_range(pixel(s, WIDTH / 2, HEIGHT / 2)[0], 254, 255);
        assert_true(daft_entity_set_material(s->scene, pane, glass(s, 1.5f, WHITE), NULL));
        assert_in_range(floor_light(s), encoded(0.4) - 1, encoded(0.4) + 1);
        assert_true(daft_entity_set_material(s->scene, pane, matte(s, WHITE, 0), NULL));
        assert_int_equal(floor_light(s), 0);
        stage_drop(s);
    }
}

/* A light within a ball of green glass lights the room in green; and a light among the points of one tile, where each
 * ray goes alone, does what the pencil does. */
static void lanterns(void **unused)
{
    (void)unused;
    stage *s = stage_make(WIDTH, HEIGHT, NULL, 2);
    daft_scene_set_ambient(s->scene, BLACK);
    daft_entity room = add(s, box(daft_dv3(0, 0, 0), daft_v3(12, 6, 12), matte(s, WHITE, 0)));
    add(s, sphere(daft_dv3(3, 0, 0), 0.5f, glass(s, 1, daft_v3(0, 1, 0.25f))));
    source(s, daft_dv3(3, 0, 0), 1);
    s->view.camera.position = daft_dv3(-3, 0, 0), s->view.camera.fov = 2.5f; /* small tiles see wall all around the
                                                                                light */
    draw(s);
    int seen = 0;
    for (int i = 0; i < s->pixels; i++) {
        const uint8_t *p = pixel(s, i % WIDTH, i / WIDTH);
        if (s->entity[i].id != room.id || p[1] < 60) continue;
        double linear = pow((p[1] / 255.0 + 0.055) / 1.055, 2.4);
        assert_int_equal(p[0], 0);
        assert_in_range(p[2], encoded(linear / 4) - 2, encoded(linear / 4) + 2);
        seen++;
    }
    assert_true(seen > 10000);
    stage_drop(s);
}

/* ---- what it costs ---- */

static void nothing_without_glass(void **unused)
{
    (void)unused;
    stage *s = stage_make(WIDTH, HEIGHT, NULL, 2);
    add(s, box(daft_dv3(6, -1, 0), daft_v3(10, 1, 10), matte(s, WHITE, 0.5f)));
    sun(s, daft_v3(1, -2, 0.5f), 1);
    const daft_effect *effect = &draw(s)->effects[DAFT_EFFECT_REFRACTION];
    assert_true(!effect->ran && effect->rays == 0 && effect->bytes == 0 && effect->tiles == 0 && effect->ms == 0);
    assert_string_equal(effect->why, "no material transmits");
    add(s, sphere(daft_dv3(-6, -9, 0), 1, glass(s, 1.5f, WHITE))); /* behind the camera, out of the mirror's reach */
    effect = &draw(s)->effects[DAFT_EFFECT_REFRACTION];
    assert_true(!effect->ran && effect->rays == 0 && effect->bytes == 0);
    assert_string_equal(effect->why, "nothing that transmits is seen");
    add(s, sphere(daft_dv3(5, 1, 0), 0.3f, glass(s, 1.5f, WHITE)));
    const daft_counters *c = draw(s);
    effect = &c->effects[DAFT_EFFECT_REFRACTION];
    assert_true(effect->ran && effect->rays > 0 && effect->rays < WIDTH * HEIGHT / 4 && effect->bytes > 0);
    assert_true(effect->rays == c->refraction_rays && strcmp(effect->name, "refraction") == 0);
    stage_drop(s);
}

static void dress(stage *s)
{
    daft_scene_set_sky_gradient(s->scene, ZENITH, HORIZON);
    add(s, box(daft_dv3(6, -2, 0), daft_v3(20, 1, 20), matte(s, daft_v3(0.9f, 0.5f, 0.3f), 0.2f)));
    for (int kind = 0; kind < KINDS; kind++) {
        daft_material material = glass(s, 1 + 0.2f * (float)kind, daft_v3(1, 0.7f, 0.5f));
        add(s, thing(s, kind, daft_dv3(6 + kind % 2, -0.4, kind - 2.5), 0.9, material));
    }
    add(s, sphere(daft_dv3(9, 1, 0), 0.5f, glowing(s, daft_v3(1, 1, 0))));
    sun(s, daft_v3(1, -2, 0.7f), 1);
    source(s, daft_dv3(4, 2, -3), 0.5f);
}

static void the_same_however_computed(void **unused)
{
    (void)unused;
    uint64_t start = state;
    for (int quality = DAFT_PRESET_DRAFT; quality <= DAFT_PRESET_GAME; quality++) {
        uint64_t expected = 0;
        for (int variant = 0; variant <= daft_isa_best() + 3; variant++) {
            bool by_isa = variant <= daft_isa_best();
            stage *s = stage_make(WIDTH, HEIGHT, by_isa ? daft_isa_name(variant) : NULL,
                                  by_isa ? 1 : 3 * (variant - daft_isa_best()));
            state = start; /* the same turns */
            dress(s);
            s->view.camera.fov = 1, s->view.quality = daft_preset_quality((daft_preset)quality),
            s->view.quality.tree = variant == daft_isa_best() + 3 ? DAFT_TREE_BVH : DAFT_TREE_RASTER;
            const daft_counters *c = draw(s);
            uint64_t hash = daft_hash(&c->refraction_rays, sizeof c->refraction_rays, picture_hash(s));
            hash = daft_hash(&c->reflection_rays, sizeof c->reflection_rays, hash);
            if (!expected) expected = hash;
            if (hash != expected) fail_msg("variant %d gives another picture", variant);
            assert_true(c->refraction_rays > 2000);
            stage_drop(s);
        }
    }
}

/* ---- definitions ---- */

static void definitions_are_checked(void **unused)
{
    (void)unused;
    stage *s = stage_make(8, 8, NULL, 1);
    static const struct {
        float transmission, tint, index;
        const char *says;
    } bad[] = {{-0.1f, 1, 1.5f, "transmission is -0.1; it must be between 0 and 1"},
               {NAN, 1, 1.5f, "transmission is"},
               {1, 1.5f, 1.5f, "transmission_tint.z is 1.5; it must be between 0 and 1"},
               {1, NAN, 1.5f, "transmission_tint.z is"},
               {1, 1, 0, "refractive_index is 0; it must be between 0.001 and 10"},
               {1, 1, INFINITY, "refractive_index is inf"}};
    for (size_t i = 0; i < DAFT_COUNT_OF(bad); i++) {
        daft_material_def def = daft_default_material_def();
        daft_error error = {0};
        def.transmission = bad[i].transmission, def.transmission_tint.z = bad[i].tint,
        def.refractive_index = bad[i].index;
        assert_false(daft_material_create(s->scene, &def, &error).id);
        if (!strstr(error.message, bad[i].says)) fail_msg("%s", error.message);
    }
    stage_drop(s);
}

int main(void)
{
    const char *seed = getenv("DAFT_SEED");
    if (seed) state = strtoull(seed, NULL, 0);
    print_message("seed %llu\n", (unsigned long long)state);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pane_shifts_by_snell),
        cmocka_unit_test(window_of_snell),
        cmocka_unit_test(ball_is_a_lens),
        cmocka_unit_test(balls_among_balls),
        cmocka_unit_test(surfaces_count_once),
        cmocka_unit_test(shadows_let_light_through),
        cmocka_unit_test(lanterns),
        cmocka_unit_test(nothing_without_glass),
        cmocka_unit_test(the_same_however_computed),
        cmocka_unit_test(definitions_are_checked),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
