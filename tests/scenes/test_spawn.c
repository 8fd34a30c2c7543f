/* Where rays leave surfaces: shadow and mirrored rays start outside the error of the point that was hit, and not
 * further. What a light lights in full shows no dark pixel (acne), where no light comes there is exactly none (leaks),
 * and convex mirrors do not see themselves: for spheres from 10⁻³ to 10⁶ m, meshes scaled by 10⁻³ to 10³ and turned,
 * from 1 m to 10⁵ m away. Wrong pixels are counted, and there must be none. */
#include "hard_scenes.h"

enum { WIDTH = 160, HEIGHT = 160, RINGS = 40 };

static uint64_t state = 5;

static float any(float low, float high)
{
    state = state * 6364136223846793005u + 1442695040888963407u;
    return low + (high - low) * (float)(state >> 40) * 0x1p-24f;
}

/* C leaves open in which order a call's arguments are computed: random ones are drawn one at a time. */
static daft_vec3 any3(float low, float high)
{
    float x = any(low, high), y = any(low, high), z = any(low, high);
    return daft_v3(x, y, z);
}

static daft_quat any_turn(void)
{
    daft_vec3 v = any3(-1, 1);
    return daft_quat_normalize((daft_quat){v.x, v.y, v.z, any(-1, 1)});
}

static daft_dvec3 any_way(void)
{
    daft_dvec3 d = daft_to_double(any3(-1, 1));
    double length = sqrt(daft_ddot(d, d));
    return length > 0.1 ? daft_dscale(d, 1 / length) : daft_dv3(0.6, 0.8, 0);
}

static int encoded(double linear)
{
    double e = linear <= 0.0031308 ? 12.92 * linear : 1.055 * pow(linear, 1 / 2.4) - 0.055;
    return (int)floor(255 * fmin(fmax(e, 0), 1) + 0.5);
}

/* ---- meshes ---- */

/* A ball of `rings` by 2·rings vertices and two poles, convex up to the rounding of its corners. Few rings: flat
 * facets, since its edges are sharper than 40 degrees; many: smooth normals. */
static daft_mesh ball_mesh(stage *s, uint32_t rings)
{
    static daft_vec3 p[2 * RINGS * RINGS + 2];
    static uint32_t index[12 * RINGS * RINGS];
    uint32_t columns = 2 * rings, n = 0, south = rings * columns, north = south + 1;
    for (uint32_t i = 0; i < rings; i++)
        for (uint32_t j = 0; j < columns; j++) {
            double latitude = DAFT_PI * ((i + 1.0) / (rings + 1.0) - 0.5), longitude = 2 * DAFT_PI * j / columns;
            p[i * columns + j] = daft_to_float(daft_dv3(daft_cos(latitude) * daft_cos(longitude), daft_sin(latitude),
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

/* A square from -1 to 1 in x and z at height 0, of 2·side² triangles, seen from above. */
static daft_mesh floor_mesh(stage *s, uint32_t side)
{
    static daft_vec3 p[65 * 65];
    static uint32_t index[6 * 64 * 64];
    uint32_t n = 0;
    for (uint32_t i = 0; i <= side; i++)
        for (uint32_t j = 0; j <= side; j++)
            p[i * (side + 1) + j] = daft_v3(2 * (float)i / (float)side - 1, 0, 2 * (float)j / (float)side - 1);
    for (uint32_t i = 0; i < side; i++)
        for (uint32_t j = 0; j < side; j++) {
            uint32_t a = i * (side + 1) + j, b = a + side + 1;
            const uint32_t quad[6] = {a, a + 1, b, b, a + 1, b + 1};
            memcpy(index + 3 * n, quad, sizeof quad), n += 2;
        }
    daft_mesh_def def = daft_default_mesh_def();
    def.positions = p, def.vertex_count = (side + 1) * (side + 1), def.indices = index, def.triangle_count = n;
    daft_mesh out = daft_mesh_create(s->scene, &def, NULL);
    assert_true(out.id);
    return out;
}

/* ---- looking ---- */

/* The camera, `distance` from the middle of something of that radius, with a view that it fills; not narrower than
 * 1/500, where 32-bit angles end. */
static void look(stage *s, daft_dvec3 middle, double radius, double distance)
{
    daft_dvec3 from = daft_dadd(middle, daft_dscale(any_way(), distance));
    double fov = distance > radius ? 2.4 * daft_asin(radius / distance) : 2;
    s->view.camera = daft_camera_look_at(from, middle, (float)fmin(fmax(fov, 2e-3), 2));
}

typedef struct tally {
    int pictures, looked, wrong;
} tally;

static void report(const char *what, tally t)
{
    print_message("%s: %d pictures, %d of %d pixels are wrong\n", what, t.pictures, t.wrong, t.looked);
    assert_true(t.looked > 200 * t.pictures);
    assert_int_equal(t.wrong, 0);
}

/* The cosine between a facet and the light, where a pixel sees one: that of the flat triangle, not of the smooth
 * normal. */
static daft_vec3 facet_normal(const stage *s, const daft_entity_def *def, int i)
{
    if (def->shape != DAFT_SHAPE_MESH) return s->normal[i];
    daft_error error;
    daft_ray_hit hit;
    bool found =
        daft_scene_cast_ray(s->scene, s->view.camera.position, daft_to_float(pixel_ray(s, i % WIDTH, i / WIDTH)),
                            INFINITY, (daft_entity){0}, &hit, &error);
    return found ? hit.normal : daft_v3(0, 0, 0);
}

/* Everything that faces the sun, by its shading normal and by its facet, has all its light. */
static void sunlit(const stage *s, const daft_entity_def *def, daft_vec3 to_sun, tally *t)
{
    for (int i = 0; i < s->pixels; i++) {
        if (s->entity[i].id == 0) continue;
        double cosine = (double)daft_dot(s->normal[i], to_sun);
        int full = encoded(cosine), value = pixel(s, i % WIDTH, i / WIDTH)[0];
        if (cosine < 0.02) continue;
        t->looked++;
        if (abs(value - full) > 2 && (value > full || daft_dot(facet_normal(s, def, i), to_sun) > 0.02f)) t->wrong++;
    }
    t->pictures++;
}

static void sunlit_view(const daft_entity_def *def, stage *s, double radius, double distance, tally *t)
{
    daft_scene_set_ambient(s->scene, daft_v3(0, 0, 0));
    look(s, def->position, radius, distance);
    add(s, *def);
    daft_dvec3 to_eye = daft_dscale(daft_dsub(s->view.camera.position, def->position), 1 / distance);
    daft_vec3 light = daft_normalize(daft_to_float(daft_dadd(to_eye, any_way()))); /* often from aside */
    sun(s, daft_neg(light), 1);
    draw(s);
    sunlit(s, def, light, t);
}

static void spheres_in_the_sun(void **unused)
{
    (void)unused;
    tally t = {0, 0, 0};
    for (double radius = 1e-3; radius < 2e6; radius *= 10)
        for (double away = 1.001; away < 600; away *= 1.9) {
            stage *s = stage_make(WIDTH, HEIGHT, NULL, 1);
            daft_entity_def def = sphere(daft_dv3(3e3, -7e4, 20), (float)radius, matte(s, daft_v3(1, 1, 1), 0));
            sunlit_view(&def, s, radius, radius * away, &t);
            stage_drop(s);
        }
    report("spheres", t);
}

/* Unlike spheres and boxes, nobody knows that a mesh is convex: its shadow rays meet its own triangles. */
static void meshes_in_the_sun(void **unused)
{
    (void)unused;
    tally flat = {0, 0, 0}, smooth = {0, 0, 0};
    for (double scale = 1e-3; scale < 2e3; scale *= 10)
        for (double distance = 1; distance < 2e5; distance *= 10) {
            if (scale > distance || scale < distance * 1e-3)
                continue; /* inside, or smaller than a narrow view's pixel */
            for (uint32_t rings = 3; rings <= RINGS; rings += RINGS - 3) {
                stage *s = stage_make(WIDTH, HEIGHT, NULL, 1);
                daft_entity_def def = instance(ball_mesh(s, rings), daft_dv3(-1e5, 300, 2), (float)scale, any_turn(),
                                               matte(s, daft_v3(1, 1, 1), 0));
                sunlit_view(&def, s, scale, scale == distance ? 1.5 * distance : distance,
                            rings == 3 ? &flat : &smooth);
                stage_drop(s);
            }
        }
    report("flat balls", flat);
    report("smooth balls", smooth);
}

/* ---- rooms ---- */

/* A light and the camera within one closed, convex thing: every wall that is seen is lit. */
static void count_dark(const stage *s, daft_dvec3 light_at, tally *t)
{
    for (int i = 0; i < s->pixels; i++) {
        daft_dvec3 ray = pixel_ray(s, i % WIDTH, i / WIDTH);
        daft_dvec3 direction_to =
            daft_dsub(light_at, daft_dadd(s->view.camera.position,
                                          daft_dscale(ray, (double)s->depth[i] / sqrt(daft_ddot(ray, ray)))));
        double cosine =
            daft_ddot(direction_to, daft_to_double(s->normal[i])) / sqrt(daft_ddot(direction_to, direction_to));
        if (s->entity[i].id == 0) {
            t->wrong++; /* a crack */
            continue;
        }
        if (cosine < 0.01) continue;
        t->looked++;
        t->wrong += pixel(s, i % WIDTH, i / WIDTH)[0] == 0;
    }
    t->pictures++;
}

static daft_entity_def room(stage *s, int kind, daft_dvec3 position, double size)
{
    daft_material white = matte(s, daft_v3(1, 1, 1), 0);
    if (kind == 0) return sphere(position, (float)(0.5 * size), white);
    daft_entity_def def = box(position, daft_to_float(daft_dv3(size, size, size)), white);
    if (kind == 2) def = instance(ball_mesh(s, 4), position, (float)(0.5 * size), daft_quat_identity(), white);
    def.rotation = any_turn();
    return def;
}

/* A point that is within the room however it is turned. */
static daft_dvec3 within(const daft_entity_def *def, double size, double part)
{
    return daft_dadd(def->position, daft_dscale(any_way(), size * part));
}

static void lights_inside(void **unused)
{
    (void)unused;
    tally t = {0, 0, 0};
    for (double size = 1e-3; size < 2e6; size *= 10)
        for (int i = 0; i < 9; i++) {
            stage *s = stage_make(WIDTH, HEIGHT, NULL, 1);
            daft_entity_def def = room(s, i % 3, daft_dv3(100, 1e6, -7), size);
            daft_scene_set_ambient(s->scene, daft_v3(0, 0, 0));
            add(s, def);
            daft_dvec3 light_at = within(&def, size, i < 3 ? 0.4 : 0.1);
            source(s, light_at, 4);
            daft_dvec3 from = within(&def, size, 0.3), at = within(&def, size, 0.05);
            s->view.camera = daft_camera_look_at(from, at, 2);
            draw(s);
            count_dark(s, light_at, &t);
            stage_drop(s);
        }
    report("lights in rooms", t);
}

static void count_light(const stage *s, tally *t)
{
    for (int i = 0; i < s->pixels; i++) {
        const uint8_t *p = pixel(s, i % WIDTH, i / WIDTH);
        t->wrong += (p[0] | p[1] | p[2]) != 0 || s->entity[i].id == 0;
        t->looked++;
    }
    t->pictures++;
}

/* Lights and the sun outside, the camera inside, often close to a wall or in a corner: black. */
static void lights_outside(void **unused)
{
    (void)unused;
    tally t = {0, 0, 0};
    for (double size = 1e-3; size < 2e6; size *= 10)
        for (int i = 0; i < 12; i++) {
            stage *s = stage_make(WIDTH, HEIGHT, NULL, 1);
            daft_entity_def def = room(s, i % 3, daft_dv3(100, 1e6, -7), size);
            daft_scene_set_ambient(s->scene, daft_v3(0, 0, 0));
            if (i % 3 == 1) def.rotation = daft_quat_identity();
            add(s, def);
            /* beside a wall, near an edge's line, far away */
            source(s, daft_dadd(def.position, daft_dscale(any_way(), size * (i < 6 ? 0.9 : 100))), 1000);
            source(s, daft_dadd(def.position, daft_dv3(0.5001 * size, (double)any(-0.49f, 0.49f) * size, 0.499 * size)),
                   1000);
            sun(s, any3(-1, 1), 1000);
            double corner = i % 3 == 1 ? 0.4999 : 0.2;
            daft_dvec3 eye = daft_dadd(def.position, daft_dscale(daft_dv3(corner, -corner, corner), size));
            s->view.camera = daft_camera_look_at(eye, i % 2 ? def.position : daft_dv3(eye.x - size, eye.y, eye.z), 2);
            draw(s);
            count_light(s, &t);
            stage_drop(s);
        }
    report("lights outside of rooms", t);
}

/* A room of six slabs that only touch: nothing comes in along the seams. */
static void seams_are_tight(void **unused)
{
    (void)unused;
    tally t = {0, 0, 0};
    for (double size = 1e-2; size < 2e4; size *= 10)
        for (int i = 0; i < 4; i++) {
            stage *s = stage_make(WIDTH, HEIGHT, NULL, 1);
            daft_material white = matte(s, daft_v3(1, 1, 1), 0);
            double h = size * 0.5, d = size * 0.01;
            for (int k = 0; k < 6; k++) {
                double side = k % 2 ? 1 : -1, middle[3] = {0, 0, 0}, length[3] = {size, size, size};
                middle[k / 2] = side * (h + d / 2), length[k / 2] = d;
                add(s, box(daft_dv3(middle[0], middle[1], middle[2]),
                           daft_to_float(daft_dv3(length[0], length[1], length[2])), white));
            }
            daft_scene_set_ambient(s->scene, daft_v3(0, 0, 0));
            daft_vec3 down = any3(-1, 1);
            down.y = -1;
            sun(s, down, 1000);
            source(s, daft_dv3(size * 3, size * 2, size), 1000);
            s->view.camera = daft_camera_look_at(daft_dv3(-0.3 * size, -0.2 * size, 0.1 * size),
                                                 daft_dv3(i % 2 ? h : 0, h, i > 1 ? -h : h), 2);
            draw(s);
            count_light(s, &t);
            stage_drop(s);
        }
    report("rooms of slabs", t);
}

/* ---- grazing light ---- */

/* A light close above a floor lights all of it, just below it nothing. */
static void grazing(double scale, double height, uint32_t side, double away, tally *lit, tally *dark)
{
    for (int below = 0; below < 2; below++) {
        stage *s = stage_make(WIDTH, HEIGHT, NULL, 1);
        daft_scene_set_ambient(s->scene, daft_v3(0, 0, 0));
        daft_quat turn = any_turn();
        add(s, instance(floor_mesh(s, side), daft_dv3(0, 0, 0), (float)scale, turn, matte(s, daft_v3(1, 1, 1), 0)));
        daft_dvec3 up = daft_to_double(daft_quat_rotate(turn, daft_v3(0, 1, 0)));
        daft_dvec3 along = daft_to_double(daft_quat_rotate(turn, daft_v3(0.83f, 0, 0.31f)));
        daft_dvec3 light_at = daft_dadd(daft_dscale(along, scale), daft_dscale(up, (below ? -1 : 1) * height * scale));
        source(s, light_at, (float)(100 / height));
        daft_dvec3 eye = daft_dscale(daft_dadd(daft_dscale(up, 1), daft_dscale(along, -1)), scale * away);
        s->view.camera = daft_camera_look_at(eye, daft_dv3(0, 0, 0), (float)fmin(1, 1 / away));
        draw(s);
        tally *t = below ? dark : lit;
        for (int i = 0; i < s->pixels; i++) {
            if (s->entity[i].id == 0) continue;
            bool light = pixel(s, i % WIDTH, i / WIDTH)[0] != 0;
            t->looked++, t->wrong += light != !below;
        }
        t->pictures++;
        stage_drop(s);
    }
}

static void grazing_lights(void **unused)
{
    (void)unused;
    tally lit = {0, 0, 0}, dark = {0, 0, 0};
    for (double scale = 1e-3; scale < 2e3; scale *= 10)
        for (double height = 1e-1; height > 5e-4; height *= 0.1)
            for (uint32_t side = 1; side <= 64; side *= 8)
                for (double away = 1; away <= 64; away *= 8) grazing(scale, height, side, away, &lit, &dark);
    report("floors lit by a grazing light", lit);
    report("floors over a light", dark);
}

/* ---- mirrors ---- */

/* Half of the sky's red is all that a convex mirror of one half shows; what it saw of itself would be a quarter. */
static void mirrored_sky(stage *s, const daft_entity_def *def, double radius, double distance, tally *t)
{
    daft_scene_set_ambient(s->scene, daft_v3(0, 0, 0));
    daft_scene_set_sky_color(s->scene, daft_v3(1, 0.2f, 0));
    look(s, def->position, radius, distance);
    add(s, *def);
    draw(s);
    int red = encoded(0.5), green = encoded(0.1);
    for (int i = 0; i < s->pixels; i++) {
        if (s->entity[i].id == 0) continue;
        const uint8_t *p = pixel(s, i % WIDTH, i / WIDTH);
        t->looked++, t->wrong += p[0] != red || p[1] != green;
    }
    t->pictures++;
}

static daft_entity_def mirror_of(stage *s, int kind, double radius)
{
    daft_material half = matte(s, daft_v3(0, 0, 0), 0.5f);
    daft_dvec3 position = daft_dv3(-4e5, 80, 3);
    if (kind == 0) return sphere(position, (float)radius, half);
    daft_entity_def def = box(position, daft_to_float(daft_dv3(radius, radius, 1.2 * radius)), half);
    if (kind > 1)
        def = instance(ball_mesh(s, kind == 2 ? 3 : RINGS), position, (float)radius, daft_quat_identity(), half);
    def.rotation = any_turn();
    return def;
}

static void convex_mirrors(void **unused)
{
    (void)unused;
    static const char *const NAMES[] = {"mirrored spheres", "mirrored boxes", "mirrored flat balls",
                                        "mirrored smooth balls"};
    for (int kind = 0; kind < 4; kind++) {
        tally t = {0, 0, 0};
        for (double radius = 1e-3; radius < (kind ? 2e3 : 2e6); radius *= 10)
            for (double away = 1.3; away < 600; away *= 2.1) {
                stage *s = stage_make(WIDTH, HEIGHT, NULL, 1);
                daft_entity_def def = mirror_of(s, kind, radius);
                mirrored_sky(s, &def, radius, radius * away, &t);
                stage_drop(s);
            }
        report(NAMES[kind], t);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(spheres_in_the_sun), cmocka_unit_test(meshes_in_the_sun), cmocka_unit_test(lights_inside),
        cmocka_unit_test(lights_outside),     cmocka_unit_test(seams_are_tight),   cmocka_unit_test(grazing_lights),
        cmocka_unit_test(convex_mirrors),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
