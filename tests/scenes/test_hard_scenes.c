/* Pictures of scenes that are hard for numbers (assets/scenes/hard). Each is compared three ways: the pencil with the
 * reference path, pixel by pixel; both with the truth, in double or in closed form, and not merely with yesterday; and
 * its bytes with a constant, which is the same on every instruction set and for any number of threads. */
#include "hard_scenes.h"

enum { WIDTH = 320, HEIGHT = 200, PIXELS = WIDTH * HEIGHT };

typedef bool truth(const stage *s, int i);

/* What a scene is to show. `truth` gives false where a pixel is wrong. */
typedef struct hard_scene {
    const char *name;
    uint32_t camera;
    uint64_t hash;
    truth *truth;
    int min_seen; /* pixels that see something */
} hard_scene;

static stage *scene_load(const hard_scene *h, const char *isa, int threads)
{
    stage *s = stage_make(WIDTH, HEIGHT, isa, threads);
    char path[512];
    daft_error error = {0};
    snprintf(path, sizeof path, "%s/assets/scenes/hard/%s.scene", DAFT_ROOT, h->name);
    if (!daft_scene_load(s->scene, path, &error)) fail_msg("%s", error.message);
    assert_true(daft_scene_get_camera(s->scene, h->camera, &s->view.camera, &error));
    return s;
}

/* ---- truths ---- */

static daft_transform transform_of(const stage *s, uint32_t entity)
{
    daft_transform out;
    daft_error error = {0};
    if (!daft_entity_get_transform(s->scene, (daft_entity){entity}, &out, &error)) fail_msg("%s", error.message);
    return out;
}

/* The handle of the n-th entity that the file lists. */
static uint32_t nth(const stage *s, uint32_t n)
{
    uint32_t id = 1u << 20 | n; /* the first generation is in the upper bits */
    if (!daft_entity_is_valid(s->scene, (daft_entity){id})) fail_msg("there is no entity %u", n);
    return id;
}

static daft_dvec3 dquat_rotate(daft_quat q, daft_dvec3 v, double sign)
{
    daft_dvec3 u = daft_dv3((double)q.x * sign, (double)q.y * sign, (double)q.z * sign);
    double w = (double)q.w, n = 1 / (daft_ddot(u, u) + w * w);
    daft_dvec3 t = daft_dscale(daft_dcross(u, v), 2 * n);
    return daft_dadd(v, daft_dadd(daft_dscale(t, w), daft_dcross(u, t)));
}

/* The single-ray kernel agrees on what is seen; rays differ by roundings of 2^-24, so where a pixel's ray passes an
 * outline within 10⁻⁵ of a pixel it may see the next thing: neighbouring rays then tell. */
static bool seen_by_rays(const stage *s, int i)
{
    static const double SHIFT[5][2] = {{0, 0}, {1e-4, 0}, {-1e-4, 0}, {0, 1e-4}, {0, -1e-4}};
    daft_dvec3 ray = pixel_ray(s, i % WIDTH, i / WIDTH), side = daft_dsub(pixel_ray(s, 1, 0), pixel_ray(s, 0, 0)),
               down = daft_dsub(pixel_ray(s, 0, 1), pixel_ray(s, 0, 0));
    for (int k = 0; k < 5; k++) {
        daft_dvec3 d = daft_dadd(ray, daft_dadd(daft_dscale(side, SHIFT[k][0]), daft_dscale(down, SHIFT[k][1])));
        daft_ray_hit hit = {0};
        daft_error error;
        bool found = daft_scene_cast_ray(s->scene, s->view.camera.position, daft_to_float(d), INFINITY,
                                         (daft_entity){0}, &hit, &error);
        if ((found ? hit.entity.id : 0) == s->entity[i].id && (!found || hit.triangle == s->triangle[i])) return true;
    }
    return false;
}

/* Red where a stripe's half of the pitch is, green else; a millimetre decides, a kilometre away. */
static bool stripes_in_front(const stage *s, int i)
{
    uint32_t wall = nth(s, 0), stripes = nth(s, 1);
    daft_transform t = transform_of(s, stripes);
    daft_dvec3 d = dquat_rotate(t.rotation, pixel_ray(s, i % WIDTH, i / WIDTH), -1);
    daft_dvec3 o = dquat_rotate(t.rotation, daft_dscale(t.position, -1), -1);
    double along = -o.x / d.x, y = (o.y + along * d.y) / 300, z = (o.z + along * d.z) / 300;
    double pitch = (z + 1) * 8, in = pitch - floor(pitch), edge = fmin(fmin(in, 1 - in), fabs(in - 0.5));
    if (edge < 1e-4 || fabs(fabs(z) - 1) < 1e-4 || fabs(fabs(y) - 1) < 1e-4) return true; /* on an outline */
    uint32_t expected = fabs(z) > 1 || fabs(y) > 1 ? 0 : in < 0.5 ? stripes : wall;
    return s->entity[i].id == expected;
}

/* The segment from the wall's point to the light meets the ridge's box: dark; else lit. */
static bool in_ridge_shadow(double y, double z)
{
    const double low[3] = {-0.005, -1, 3.99}, high[3] = {0, 1, 4.01}, o[3] = {0, y, z}, d[3] = {-0.01, -y, -z};
    double near = 1e-9, far = 1;
    for (int k = 0; k < 3; k++) {
        double a = (low[k] - o[k]) / d[k], b = (high[k] - o[k]) / d[k];
        near = fmax(near, fmin(a, b)), far = fmin(far, fmax(a, b));
    }
    return near < far;
}

static bool wall_is_lit(const stage *s, int i)
{
    daft_dvec3 d = pixel_ray(s, i % WIDTH, i / WIDTH);
    double t = 11 / d.x, y = t * d.y, z = t * d.z;
    if (s->entity[i].id != nth(s, 0)) return fabs(y) > 10 || fabs(z) > 10 || s->entity[i].id == nth(s, 1);
    bool dark = in_ridge_shadow(y, z), lit = pixel(s, i % WIDTH, i / WIDTH)[1] > 0;
    for (int k = 0; k < 4; k++) /* within a centimetre of the shadow's edge */
        if (in_ridge_shadow(y + (k - 1) % 2 * 0.01, z + (k - 2) % 2 * 0.01) != dark) return true;
    return lit == !dark;
}

/* The nearest sphere by the textbook's formula in double, where no outline is within a thousandth of a radius. */
static bool nearest_sphere(const stage *s, int i)
{
    static const double CLOSE = 1e-3;
    daft_dvec3 d = pixel_ray(s, i % WIDTH, i / WIDTH);
    double nearest = INFINITY, dd = daft_ddot(d, d);
    uint32_t expected = 0;
    for (uint32_t n = 0; n < 10; n++) {
        uint32_t id = nth(s, n);
        daft_dvec3 c = transform_of(s, id).position;
        double r = sqrt(daft_ddot(c, c)) / 4, along = daft_ddot(c, d) / dd; /* each is four radii away */
        daft_dvec3 aside = daft_dsub(c, daft_dscale(d, along));
        double square = 1 - daft_ddot(aside, aside) / (r * r);
        if (fabs(square) < CLOSE) return true;
        if (square < 0 || along < 0) continue;
        double t = along - r * sqrt(square / dd);
        if (t < nearest) nearest = t, expected = id;
    }
    bool deep = expected == 0 || fabs((double)s->depth[i] - nearest * sqrt(dd)) <= 1e-5 * nearest * sqrt(dd);
    return s->entity[i].id == expected && deep;
}

/* Walls by their axis: the plane at ±5 that the ray reaches first. */
static bool walls_of_corner(const stage *s, int i)
{
    if (s->entity[i].id == 0) return false; /* the room is closed */
    if (s->entity[i].id != nth(s, 0)) return seen_by_rays(s, i);
    daft_dvec3 eye = s->view.camera.position, ray = pixel_ray(s, i % WIDTH, i / WIDTH);
    const double o[3] = {eye.x, eye.y, eye.z}, d[3] = {ray.x, ray.y, ray.z};
    const float n[3] = {s->normal[i].x, s->normal[i].y, s->normal[i].z};
    double t[3];
    int first = 0;
    for (int k = 0; k < 3; k++) {
        t[k] = ((d[k] > 0 ? 5 : -5) - o[k]) / d[k];
        if (t[k] < t[first]) first = k;
    }
    for (int k = 0; k < 3; k++)
        if (k != first && t[k] < t[first] * 1.006) return true; /* at an edge, of walls 10⁻⁴ ± 2.4e-7 m away */
    /* the room's corners are floats, 2.4e-7 m apart there: the point lies on the wall within a micrometre, and the
     * rounding of its depth */
    double off = (double)s->depth[i] / sqrt(daft_ddot(ray, ray)) * d[first] + o[first] - (d[first] > 0 ? 5 : -5);
    return fabs((double)n[first] + (d[first] > 0 ? 1 : -1)) < 1e-6 && fabs(off) <= 1e-6 + 2e-7 * (double)s->depth[i];
}

/* The ground is a square of 10⁷ m to each side, 2 m below the eye: below the horizon and not beyond its end. */
static bool ground_to_the_horizon(const stage *s, int i)
{
    uint32_t ground = nth(s, 0);
    if (s->entity[i].id != 0 && s->entity[i].id != ground) return seen_by_rays(s, i);
    daft_dvec3 d = pixel_ray(s, i % WIDTH, i / WIDTH);
    double t = d.y < 0 ? -2 / d.y : INFINITY, reach = fmax(fabs(t * d.x), fabs(t * d.z)) / 1e7;
    if (reach > 0.999 && reach < 1.001) return true;
    if (s->entity[i].id != (reach < 1 ? ground : 0)) return false;
    double depth = t * sqrt(daft_ddot(d, d));
    return reach > 1 || fabs((double)s->depth[i] - depth) <= 1e-5 * depth;
}

static const hard_scene SCENES[] = {
    {"needles", 0, 0x442f9e6ff25aeb99u, seen_by_rays, 30000},
    {"layers", 0, 0xed268b6df68b2585u, stripes_in_front, 40000},
    {"grazing", 0, 0xabe9f1627497b72du, wall_is_lit, 60000},
    {"spheres", 0, 0x9b74a02d04fee7dcu, nearest_sphere, 15000},
    {"corner", 0, 0xeb6b3f0eac42c441u, walls_of_corner, PIXELS},
    {"horizon", 0, 0x86192af54d15ed1cu, ground_to_the_horizon, 30000},
    {"horizon", 1, 0x8b9e2bb8b60daf25u, ground_to_the_horizon, 20000},
};

/* ---- tests ---- */

static void like_the_reference(void **unused)
{
    (void)unused;
    for (size_t k = 0; k < DAFT_COUNT_OF(SCENES); k++) {
        stage *s = scene_load(&SCENES[k], NULL, 2);
        s->view.quality.tree = DAFT_TREE_BVH, s->view.quality.edge_samples = 16;
        draw(s);
        picture reference = picture_take(s);
        s->view.quality.tree = DAFT_TREE_RASTER;
        draw(s);
        if (others_seen(&reference, s))
            fail_msg("%s: %d pixels see something else", SCENES[k].name, others_seen(&reference, s));
        assert_memory_equal(reference.rgba, daft_image_pixels(s->image), 4 * PIXELS);
        picture_drop(&reference);
        stage_drop(s);
    }
}

static void like_the_truth(void **unused)
{
    (void)unused;
    for (size_t k = 0; k < DAFT_COUNT_OF(SCENES); k++) {
        const hard_scene *h = &SCENES[k];
        stage *s = scene_load(h, NULL, 2);
        draw(s);
        int wrong = 0, seen = 0, first = -1;
        for (int i = 0; i < PIXELS; i++) {
            bool right = h->truth(s, i);
            wrong += !right, seen += s->entity[i].id != 0;
            if (!right && first < 0) first = i;
        }
        print_message("%s, camera %u: %d pixels see something, %d are wrong\n", h->name, h->camera, seen, wrong);
        if (wrong)
            fail_msg("%s: %d pixels are wrong, the first at %d, %d", h->name, wrong, first % WIDTH, first / WIDTH);
        assert_true(seen >= h->min_seen);
        stage_drop(s);
    }
}

static void same_bytes_everywhere(void **unused)
{
    (void)unused;
    int wrong = 0;
    for (size_t k = 0; k < DAFT_COUNT_OF(SCENES); k++)
        for (int isa = 0; isa <= daft_isa_best(); isa++)
            for (int threads = 1; threads <= 3; threads += 2) {
                stage *s = scene_load(&SCENES[k], daft_isa_name(isa), threads);
                draw(s);
                uint64_t hash = picture_hash(s);
                if (hash != SCENES[k].hash)
                    print_message("%s, camera %u, %s, %d threads: 0x%016llxu\n", SCENES[k].name, SCENES[k].camera,
                                  daft_isa_name(isa), threads, (unsigned long long)hash);
                wrong += hash != SCENES[k].hash;
                stage_drop(s);
            }
    assert_int_equal(wrong, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(like_the_reference), cmocka_unit_test(like_the_truth),
                                       cmocka_unit_test(same_bytes_everywhere)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
