/* render: lights that are areas: rectangles, spheres that glow, a sun's disc in the sky. Against integration over the
 * area in double, with the horizon and what stands in between decided place by place. */
#include "math/simd/dispatch.h"
#include "shade/shade.h"
#include "stage.h"

#include <stdio.h>

#define PI 3.14159265358979

typedef struct d3 {
    double x, y, z;
} d3;

static d3 add(d3 a, d3 b) { return (d3){a.x + b.x, a.y + b.y, a.z + b.z}; }
static d3 sub(d3 a, d3 b) { return (d3){a.x - b.x, a.y - b.y, a.z - b.z}; }
static d3 mul(d3 a, double s) { return (d3){a.x * s, a.y * s, a.z * s}; }
static double dot(d3 a, d3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static d3 cross(d3 a, d3 b) { return (d3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
static d3 unit(d3 a) { return mul(a, 1 / sqrt(dot(a, a))); }
static daft_vec3 single(d3 a) { return (daft_vec3){(float)a.x, (float)a.y, (float)a.z}; }

/* ---- the truth ---- */

/* A light as the test sees it: a rectangle with half sides u and v that shines along d, or (radius > 0) a sphere. */
typedef struct area {
    d3 at, u, v, d;
    double radius;
} area;

/* A box in the way; low.x > high.x: none. */
typedef struct box {
    d3 low, high;
} box;
static const box NO_BOX = {{1, 0, 0}, {0, 0, 0}};

static bool is_hidden(d3 from, d3 to, const box *b)
{
    const double o[3] = {from.x, from.y, from.z}, e[3] = {to.x, to.y, to.z}, low[3] = {b->low.x, b->low.y, b->low.z},
                 high[3] = {b->high.x, b->high.y, b->high.z};
    double t0 = 0, t1 = 1;
    if (b->low.x > b->high.x) return false;
    for (int k = 0; k < 3; k++) {
        const double d = e[k] - o[k] == 0 ? 1e-30 : e[k] - o[k], a = (low[k] - o[k]) / d, c = (high[k] - o[k]) / d;
        t0 = fmax(t0, fmin(a, c)), t1 = fmin(t1, fmax(a, c));
    }
    return t0 < t1;
}

/* What a lobe sends on of a place in direction l: Lambert's cosine over pi, or a highlight. */
typedef double lobe(const void *user, d3 n, d3 l);
static double lambert(const void *user, d3 n, d3 l)
{
    (void)user;
    return dot(n, l) / PI;
}

/* The integral of the lobe over what is seen of the light, over side² places. */
static double integrate(const area *a, d3 p, d3 n, const box *between, lobe *f, const void *user, int side)
{
    double sum = 0;
    for (int i = 0; i < side * side; i++) {
        const double s = (i % side + 0.5) / side, t = (i / side + 0.5) / side;
        d3 q;
        double measure; /* solid angle of the place */
        if (a->radius > 0) {
            const d3 to = sub(a->at, p), w = unit(to);
            const double far2 = dot(to, to), open = 1 - sqrt(fmax(0, 1 - a->radius * a->radius / far2)),
                         z = 1 - s * open;
            const d3 x = unit(cross(w, fabs(w.x) < 0.5 ? (d3){1, 0, 0} : (d3){0, 1, 0})), y = cross(w, x);
            const double sine = sqrt(1 - z * z), off = a->radius * a->radius - far2 * sine * sine;
            const d3 l = add(mul(w, z), mul(add(mul(x, cos(2 * PI * t)), mul(y, sin(2 * PI * t))), sine));
            q = add(p, mul(l, sqrt(far2) * z - sqrt(fmax(0, off))));
            measure = 2 * PI * open / (side * side);
        } else {
            q = add(a->at, add(mul(a->u, 2 * s - 1), mul(a->v, 2 * t - 1)));
            const d3 to = sub(q, p);
            const double there = -dot(to, a->d) / sqrt(dot(to, to));
            measure = fmax(there, 0) / dot(to, to) * 4 * sqrt(dot(a->u, a->u) * dot(a->v, a->v)) / (side * side);
        }
        const d3 l = unit(sub(q, p));
        if (dot(n, l) > 0 && measure > 0 && !is_hidden(p, q, between)) sum += f(user, n, l) * measure;
    }
    return sum;
}

/* ---- the kernels' form factors ---- */

static uint64_t state = 20261127;
static double chance(double low, double high)
{
    state = state * 6364136223846793005u + 1442695040888963407u;
    return low + (high - low) * (double)(state >> 40) / (1 << 24);
}
static d3 any_direction(void)
{
    for (;;) {
        const d3 a = {chance(-1, 1), chance(-1, 1), chance(-1, 1)};
        if (dot(a, a) <= 1 && dot(a, a) > 0.01) return unit(a);
    }
}

static area random_area(bool sphere)
{
    area a = {.at = {chance(-2, 2), chance(-2, 2), chance(-2, 2)}, .d = any_direction()};
    const d3 u = unit(cross(a.d, any_direction()));
    a.u = mul(u, chance(0.05, 1.5)), a.v = mul(cross(u, a.d), chance(0.05, 1.5));
    if (sphere) a.radius = chance(0.05, 1.5);
    return a;
}

static daft_light_source source_of(const area *a)
{
    return (daft_light_source){.area = a->radius > 0 ? DAFT_AREA_SPHERE : DAFT_AREA_RECTANGLE,
                               .position = single(a->at),
                               .to_light = single(mul(a->d, -1)),
                               .edges = {single(mul(a->u, 2)), single(mul(a->v, 2))},
                               .radius = (float)a->radius,
                               .color = {1, 1, 1}};
}

/* Points and normals all round, also behind the light and where it sinks below the horizon. */
static void form_factors_are_integrals(void **unused)
{
    (void)unused;
    enum { AREAS = 24, POINTS = 32 };
    static daft_batch batch, other;
    print_message("seed %llu\n", (unsigned long long)state);
    for (int sphere = 0; sphere < 2; sphere++) {
        double worst = 0, cut = 0, most = 0;
        int lit = 0, dark = 0;
        for (int k = 0; k < AREAS; k++) {
            const area a = random_area(sphere);
            const daft_light_source source = source_of(&a);
            d3 p[POINTS], n[POINTS];
            batch.count = other.count = POINTS;
            for (int i = 0; i < POINTS; i++) {
                do p[i] = (d3){chance(-4, 4), chance(-4, 4), chance(-4, 4)};
                while (fabs(dot(sub(p[i], a.at), a.d)) < 0.3 || sqrt(dot(sub(p[i], a.at), sub(p[i], a.at))) < a.radius);
                n[i] = any_direction();
                const daft_vec3 at = single(p[i]), normal = single(n[i]);
                batch.point.x[i] = at.x, batch.point.y[i] = at.y, batch.point.z[i] = at.z;
                batch.normal.x[i] = normal.x, batch.normal.y[i] = normal.y, batch.normal.z[i] = normal.z;
            }
            other = batch;
            uint32_t bits[DAFT_BATCH_WORDS], again[DAFT_BATCH_WORDS];
            daft_shade_kernels_for(0)->facing(&batch, &source, bits);
            for (int isa = 1; isa <= daft_isa_best(); isa++) {
                daft_shade_kernels_for(isa)->facing(&other, &source, again);
                assert_memory_equal(bits, again, sizeof bits);
                assert_memory_equal(batch.cosine, other.cosine, POINTS * sizeof(float));
            }
            for (int i = 0; i < POINTS; i++) {
                const double truth = integrate(&a, p[i], n[i], &NO_BOX, lambert, NULL, 400);
                const double gap = fabs(truth - (double)batch.cosine[i]);
                const bool is_lit = bits[0] >> i & 1;
                const double upright = dot(n[i], unit(sub(a.at, p[i])));
                worst = fmax(worst, gap), most = fmax(most, truth);
                if (fabs(upright) < 0.2) cut = fmax(cut, gap);
                lit += is_lit, dark += !is_lit;
                if (is_lit) assert_true((double)batch.cosine[i] > 0);
                if (truth > 1e-4) assert_true(is_lit);
            }
        }
        print_message("%s: %d lit, %d dark, up to %.3f; off by %.2g at most, near the horizon %.2g\n",
                      sphere ? "spheres" : "rectangles", lit, dark, most, worst, cut);
        assert_true(lit > 100 && dark > 100 && most > 0.2 && worst < 3e-4);
    }
}

/* Far away, where the sum over edges cancels. */
static void far_rectangles_keep_their_digits(void **unused)
{
    (void)unused;
    static daft_batch batch;
    const area a = {.at = {0, 0, 0}, .u = {0.5, 0, 0}, .v = {0, 0, -0.25}, .d = {0, -1, 0}};
    const daft_light_source source = source_of(&a);
    uint32_t bits[DAFT_BATCH_WORDS];
    batch.count = 5;
    for (uint32_t i = 0; i < 5; i++)
        batch.point.y[i] = -powf(10, (float)i), batch.normal.y[i] = 1, batch.normal.x[i] = batch.normal.z[i] = 0;
    daft_shade_kernels_for(daft_isa_best())->facing(&batch, &source, bits);
    for (uint32_t i = 1; i < 5; i++) {
        const double far = pow(10, i), truth = 0.5 / (PI * far * far);
        print_message("at %g m: off by %.2g of it\n", far, fabs((double)batch.cosine[i] / truth - 1));
        assert_true(fabs((double)batch.cosine[i] / truth - 1) < 0.3 / far + 4e-6 * far);
    }
}

/* ---- pictures ---- */

static void add_box(stage *s, daft_dvec3 at, daft_vec3 size, const daft_material_def *material)
{
    daft_error error = {0};
    daft_entity_def def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_BOX, def.size = size, def.position = at;
    def.material = daft_material_create(s->scene, material, &error);
    if (!daft_entity_create(s->scene, &def, &error).id) fail_msg("%s", error.message);
}

static daft_material_def white(void)
{
    daft_material_def m = daft_default_material_def();
    m.ambient = m.diffuse = (daft_vec3){1, 1, 1}, m.specular = (daft_vec3){0, 0, 0};
    return m;
}

/* The floor at y = 0 and nothing else that lights. */
static stage *on_a_floor(const daft_material_def *material)
{
    stage *s = stage_make(2, NULL);
    daft_scene_set_ambient(s->scene, (daft_vec3){0, 0, 0});
    daft_scene_set_sky_color(s->scene, (daft_vec3){0, 0, 0});
    add_box(s, (daft_dvec3){0, -0.05, 0}, (daft_vec3){20, 0.1f, 20}, material);
    s->view.camera.position = (daft_dvec3){-3, 3, 0};
    s->view.camera.pitch = 0.8f, s->view.camera.fov = 1;
    s->view.quality.edge_samples = 0, s->view.quality.denoise = false;
    return s;
}

static d3 seen_point(const stage *s, int pixel)
{
    const daft_vec3 ray = daft_camera_ray(&s->view.camera, (pixel % WIDTH + 0.5) / WIDTH,
                                          (pixel / WIDTH + 0.5) / HEIGHT, (double)HEIGHT / WIDTH);
    const d3 d = {(double)ray.x, (double)ray.y, (double)ray.z}, o = {-3, 3, 0};
    return add(o, mul(d, -o.y / d.y));
}

/* A rectangle by its definition: the level side along d × y, then turned. */
static area rectangle_of(const daft_light_def *def)
{
    area a = {.at = {def->position.x, def->position.y, def->position.z},
              .d = unit((d3){(double)def->direction.x, (double)def->direction.y, (double)def->direction.z})};
    const d3 u = fabs(a.d.y) > 0.999999 ? (d3){1, 0, 0} : unit(cross(a.d, (d3){0, 1, 0})), v = cross(u, a.d);
    const double c = cos((double)def->turn), t = sin((double)def->turn);
    a.u = mul(add(mul(u, c), mul(v, t)), (double)def->size.x / 2);
    a.v = mul(add(mul(u, -t), mul(v, c)), (double)def->size.y / 2);
    return a;
}

static daft_light_def rectangle(daft_dvec3 at, daft_vec3 direction, float width, float height)
{
    daft_light_def def = daft_default_light_def();
    def.kind = DAFT_LIGHT_RECTANGLE, def.position = at, def.direction = direction;
    def.size = (daft_vec2){width, height};
    return def;
}

static area shine(stage *s, const daft_light_def *def)
{
    daft_error error = {0};
    if (!daft_light_create(s->scene, def, &error).id) fail_msg("%s", error.message);
    return rectangle_of(def);
}

static area glow(stage *s, daft_dvec3 at, float radius, float light)
{
    daft_error error = {0};
    daft_material_def m = white();
    daft_entity_def def = daft_default_entity_def();
    m.emission = (daft_vec3){light, light, light};
    def.shape = DAFT_SHAPE_SPHERE, def.radius = radius, def.position = at, def.lights = true;
    def.material = daft_material_create(s->scene, &m, &error);
    if (!daft_entity_create(s->scene, &def, &error).id) fail_msg("%s", error.message);
    return (area){.at = {at.x, at.y, at.z}, .radius = (double)radius};
}

typedef struct gaps {
    double worst, mean, most;
    int count, partly;
} gaps;

/* Of the floor's pixels, each `step`-th, of which the box hides none. */
static gaps compare(const stage *s, const area *a, const box *between, lobe *f, const void *user, double factor,
                    int step)
{
    gaps g = {0};
    for (int i = 0; i < PIXELS; i += step) {
        const d3 p = seen_point(s, i), eye = {-3, 3, 0};
        if ((double)s->normal[i].y < 0.999 || fabs((double)s->depth[i] - sqrt(dot(sub(p, eye), sub(p, eye)))) > 0.5)
            continue;
        if (is_hidden(eye, add(p, (d3){0, 1e-6, 0}), between)) continue;
        const d3 up = {0, 1, 0};
        const double truth = factor * integrate(a, p, up, between, f, user, 64),
                     open = factor * integrate(a, p, up, &NO_BOX, f, user, 64);
        const double gap = fabs(truth - (double)s->color[i].x);
        g.worst = fmax(g.worst, gap), g.mean += gap, g.most = fmax(g.most, truth), g.count++;
        g.partly += truth > 0.05 * open && truth < 0.95 * open;
    }
    g.mean /= fmax(g.count, 1);
    return g;
}

/* A wall light with its lower half below the floor, a panel above, and a ball that glows; each with a box before it. */
static void penumbras_are_integrals(void **unused)
{
    (void)unused;
    for (int k = 0; k < 3; k++) {
        const daft_material_def m = white();
        stage *s = on_a_floor(&m);
        area a;
        if (k < 2) {
            daft_light_def def = k ? rectangle((daft_dvec3){0, 1.6, 0}, (daft_vec3){0.2f, -1, 0.1f}, 1.5f, 0.6f)
                                   : rectangle((daft_dvec3){1.4, 0.1, 0}, (daft_vec3){-1, 0, 0}, 1.2f, 1.6f);
            def.turn = k ? 0.5f : 0, def.color = (daft_vec3){2, 2, 2};
            a = shine(s, &def);
        } else {
            a = glow(s, (daft_dvec3){0.3, 1.3, 0.2}, 0.4f, 2);
        }
        const box b = k ? (box){{-0.3, 0.4, -0.3}, {0.1, 0.6, 0.2}} : (box){{0.3, 0, -0.2}, {0.5, 0.5, 0.3}};
        add_box(s, (daft_dvec3){(b.low.x + b.high.x) / 2, (b.low.y + b.high.y) / 2, (b.low.z + b.high.z) / 2},
                single(sub(b.high, b.low)), &m);
        s->view.quality.shadow_samples = 64;
        const daft_counters *c = draw(s);
        assert_true(c->effects[DAFT_EFFECT_SHADOW].rays > 10000);
        const gaps g = compare(s, &a, &b, lambert, NULL, 2, 17);
        print_message("light %d: up to %.2f; off by %.3f at most, %.4f in the mean of %d, %d in penumbra\n", k, g.most,
                      g.worst, g.mean, g.count, g.partly);
        assert_true(g.count > 700 && g.partly > 30 && g.worst < 0.06 && g.mean < 0.003);
        /* One ray a pixel is right in the mean: over many seeds by samples. */
        s->view.quality.shadow_samples = 1, s->view.quality.samples = 16;
        draw(s);
        const gaps few = compare(s, &a, &b, lambert, NULL, 2, 17);
        print_message("  one ray in 16 samples: off by %.4f in the mean\n", few.mean);
        assert_true(few.mean < 0.012);
        stage_drop(s);
    }
}

/* A ball that glows is no shadow of its own, however many rays ask; nor does it light itself. */
static void what_glows_does_not_hide_itself(void **unused)
{
    (void)unused;
    for (int k = 0; k < 4; k++) {
        const daft_material_def m = white();
        stage *s = on_a_floor(&m);
        const daft_dvec3 at = {1, 0.3, 0.4};
        const area a = glow(s, at, 0.3f, 0.7f); /* it touches the floor */
        s->view.quality.shadow_samples = k < 3 ? k * k : 1, s->view.quality.denoise = k == 3;
        draw(s);
        const box around = {{0.7, 0, 0.1}, {1.3, 0.6, 0.7}}; /* what the picture of the ball hides */
        double worst = 0;
        int own = 0, count = 0;
        for (int i = 0; i < PIXELS; i += 5) {
            const d3 p = seen_point(s, i), eye = {-3, 3, 0};
            if ((double)s->normal[i].y < 0.9999 || is_hidden(eye, p, &around)) continue;
            const double truth = 0.7 * integrate(&a, p, (d3){0, 1, 0}, &NO_BOX, lambert, NULL, 64);
            worst = fmax(worst, fabs(truth - (double)s->color[i].x)), count++;
        }
        for (int i = 0; i < PIXELS; i++)
            own += fabs((double)s->color[i].x - 0.7) < 1e-5 && (double)s->normal[i].y < 0.9;
        print_message("%d rays: off by %.2g at most of %d; %d pixels of the ball\n", s->view.quality.shadow_samples,
                      worst, count, own);
        assert_true(count > 3000 && worst < 1e-3 && own > 200);
        stage_drop(s);
    }
}

/* Within six walls that shine all around, a white ball is as bright as they are. */
static void a_white_furnace_stays_white(void **unused)
{
    (void)unused;
    static const daft_vec3 SIDES[6] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    stage *s = stage_make(2, NULL);
    daft_error error = {0};
    daft_scene_set_ambient(s->scene, (daft_vec3){0, 0, 0});
    daft_material_def m = white();
    daft_entity_def def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_SPHERE, def.radius = 1, def.material = daft_material_create(s->scene, &m, &error);
    assert_true(daft_entity_create(s->scene, &def, &error).id);
    for (int i = 0; i < 6; i++) {
        const daft_dvec3 at = {-3 * (double)SIDES[i].x, -3 * (double)SIDES[i].y, -3 * (double)SIDES[i].z};
        const daft_light_def light = rectangle(at, SIDES[i], 6, 6);
        shine(s, &light);
    }
    s->view.camera.position = (daft_dvec3){-2.5, 0, 0}, s->view.camera.fov = 1;
    draw(s);
    int count = 0;
    for (int i = 0; i < PIXELS; i++) {
        if (!isfinite(s->depth[i])) continue;
        count++;
        if (fabs((double)s->color[i].x - 1) > 2e-3) fail_msg("pixel %d is %.4f", i, (double)s->color[i].x);
    }
    assert_true(count > 5000);
    stage_drop(s);
}

/* ---- highlights ---- */

typedef struct gleam {
    d3 view;
    double exponent, alpha; /* of Phong, or (alpha > 0) of GGX, all of metal */
} gleam;

static double phong(const void *user, d3 n, d3 l)
{
    const gleam *g = user;
    const d3 r = sub(mul(n, 2 * dot(n, g->view)), g->view);
    return pow(fmax(dot(r, l), 0), g->exponent) / PI;
}

/* As facet_light() has it, over pi. */
static double ggx(const void *user, d3 n, d3 l)
{
    const gleam *g = user;
    const d3 h = unit(add(l, g->view));
    const double a2 = g->alpha * g->alpha, nh = dot(n, h), nv = dot(n, g->view), nl = dot(n, l);
    const double s = nh * nh * (a2 - 1) + 1, d = a2 / (s * s);
    const double hidden = nl * sqrt(nv * nv * (1 - a2) + a2) + nv * sqrt(nl * nl * (1 - a2) + a2);
    return d * 0.5 / hidden * nl / (1 - 0.55 * sqrt(g->alpha)) / PI;
}

/* The mean of the gaps over the mean of the truth, where the highlight is seen. */
static double highlight_error(const stage *s, const area *a, const gleam *like)
{
    double off = 0, truth = 0;
    for (int i = 0; i < PIXELS; i += 13) {
        const d3 p = seen_point(s, i);
        gleam g = *like;
        if ((double)s->normal[i].y < 0.9999) continue;
        g.view = unit(sub((d3){-3, 3, 0}, p));
        const double t = integrate(a, p, (d3){0, 1, 0}, &NO_BOX, g.alpha > 0 ? ggx : phong, &g, 48);
        off += fabs(t - (double)s->color[i].x), truth += t;
    }
    assert_true(truth > 0);
    return off / truth;
}

static void highlights_are_near_integration(void **unused)
{
    (void)unused;
    static const double EXPONENTS[] = {1, 8, 60}, ROUGHNESSES[] = {0.3, 0.5, 0.8};
    for (int k = 0; k < 12; k++) {
        const bool facets = k % 6 >= 3, ball = k >= 6;
        gleam g = {.exponent = EXPONENTS[k % 3], .alpha = facets ? pow(ROUGHNESSES[k % 3], 2) : 0};
        daft_material_def m = white();
        m.diffuse = m.ambient = (daft_vec3){0, 0, 0};
        if (facets)
            m.shading = DAFT_SHADING_PHYSICAL, m.metallic = 1, m.roughness = (float)ROUGHNESSES[k % 3],
            m.diffuse = (daft_vec3){1, 1, 1};
        else
            m.specular = (daft_vec3){1, 1, 1}, m.shininess = (float)g.exponent;
        stage *s = on_a_floor(&m);
        daft_light_def def = rectangle((daft_dvec3){2, 1.2, 0}, (daft_vec3){-1, -0.6f, 0.2f}, 1.4f, 0.8f);
        s->view.quality.mirror_depth = 0; /* then a surface shows what glows by its highlight alone */
        const area a = ball ? glow(s, (daft_dvec3){1.2, 1, 0}, 0.4f, 1) : shine(s, &def);
        draw(s);
        const double error = highlight_error(s, &a, &g);
        print_message("%s, %s %.3g: off by %.0f %% in the mean\n", ball ? "ball" : "rectangle",
                      facets ? "GGX alpha" : "Phong", facets ? g.alpha : g.exponent, 100 * error);
        assert_true(error < 0.36);
        stage_drop(s);
    }
}

/* ---- what it costs ---- */

static void what_shines_away_costs_nothing(void **unused)
{
    (void)unused;
    static uint8_t without[4 * PIXELS];
    for (int k = 0; k < 5; k++) {
        const daft_material_def m = white();
        stage *s = on_a_floor(&m);
        add_box(s, (daft_dvec3){0, 0.5, 0}, (daft_vec3){1, 1, 1}, &m);
        daft_scene_set_ambient(s->scene, (daft_vec3){0.4f, 0.4f, 0.4f});
        daft_light_def up = rectangle((daft_dvec3){0, 3, 0}, (daft_vec3){0.1f, 1, 0}, 2, 2), past = up, near = up;
        past.position = (daft_dvec3){9, 1, 0}, past.direction = (daft_vec3){1, 0, 0};
        near.direction = (daft_vec3){0, -1, 0}, near.range = 1.5f;
        if (k == 1) shine(s, &up);
        if (k == 2) shine(s, &past);
        if (k == 3) shine(s, &near);
        if (k == 4) glow(s, (daft_dvec3){0, -9, 0}, 0.2f, 50); /* below the floor: nothing that is seen faces it */
        const daft_counters *c = draw(s);
        assert_int_equal(c->effects[DAFT_EFFECT_SHADOW].rays, 0);
        assert_false(c->effects[DAFT_EFFECT_SHADOW].ran || c->effects[DAFT_EFFECT_LIGHTING].ran);
        if (k == 0) memcpy(without, daft_image_pixels(s->image), sizeof without);
        assert_memory_equal(without, daft_image_pixels(s->image), sizeof without);
        stage_drop(s);
    }
}

/* The same bytes for any number of threads and any instruction set; and what glows only lights where that is asked. */
static void pictures_of_areas_are_the_same_everywhere(void **unused)
{
    (void)unused;
    static const char *const NAMES[] = {NULL, "plain", "sse2", "avx2", "avx512"};
    static uint8_t first[4 * PIXELS];
    for (int isa = 0; isa < 5; isa++) {
        daft_engine_def def = daft_default_engine_def();
        daft_error error = {0};
        def.isa = NAMES[isa];
        daft_engine *probe = daft_engine_create(&def, NULL);
        if (!probe) continue; /* this machine or build lacks it */
        daft_engine_destroy(probe);
        stage *s = stage_make(isa + 1, def.isa);
        if (!daft_scene_load(s->scene, DAFT_ROOT "/assets/scenes/panels.scene", &error)) fail_msg("%s", error.message);
        assert_true(daft_scene_get_camera(s->scene, 0, &s->view.camera, &error));
        draw(s);
        if (isa == 0) memcpy(first, daft_image_pixels(s->image), sizeof first);
        assert_memory_equal(first, daft_image_pixels(s->image), sizeof first);
        stage_drop(s);
    }
}

/* ---- the sun's disc ---- */

static void the_sun_is_seen_where_it_stands(void **unused)
{
    (void)unused;
    for (int k = 0; k < 3; k++) {
        stage *s = stage_make(2, NULL);
        daft_light_def sun = daft_default_light_def();
        const float disc = k == 2 ? 0.3f : 0.1f;
        sun.kind = DAFT_LIGHT_SUN, sun.direction = (daft_vec3){-1, -0.1f, 0.05f}, sun.disc = disc, sun.visible = k > 0;
        sun.color = (daft_vec3){1, 0.5f, 0.25f};
        daft_scene_set_sky_color(s->scene, (daft_vec3){0.1f, 0.1f, 0.1f});
        shine(s, &sun);
        s->view.camera.fov = 1;
        draw(s);
        const double bright = fmin(16, 1 / pow(sin((double)disc), 2));
        int seen = 0;
        for (int i = 0; i < PIXELS; i++) {
            const daft_vec3 ray = daft_camera_ray(&s->view.camera, (i % WIDTH + 0.5) / WIDTH,
                                                  (i / WIDTH + 0.5) / HEIGHT, (double)HEIGHT / WIDTH);
            const d3 d = unit((d3){(double)ray.x, (double)ray.y, (double)ray.z}), to = unit((d3){1, 0.1, -0.05});
            const double angle = acos(fmin(1, dot(d, to)));
            if (fabs(angle - (double)disc) < 1e-4) continue;
            const bool inside = k > 0 && angle < (double)disc;
            seen += inside;
            assert_true(fabs((double)s->color[i].x - (inside ? 0.1 + bright : 0.1)) < 1e-3);
            assert_true(fabs((double)s->color[i].z - (inside ? 0.1 + bright / 4 : 0.1)) < 1e-3);
        }
        assert_true(k == 0 ? seen == 0 : seen > 500);
        stage_drop(s);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(form_factors_are_integrals),     cmocka_unit_test(far_rectangles_keep_their_digits),
        cmocka_unit_test(penumbras_are_integrals),        cmocka_unit_test(what_glows_does_not_hide_itself),
        cmocka_unit_test(a_white_furnace_stays_white),    cmocka_unit_test(highlights_are_near_integration),
        cmocka_unit_test(what_shines_away_costs_nothing), cmocka_unit_test(pictures_of_areas_are_the_same_everywhere),
        cmocka_unit_test(the_sun_is_seen_where_it_stands)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
