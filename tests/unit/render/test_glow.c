/* render: meshes and boxes that glow and light what is around. Against integration over their triangles in double. */
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

/* ---- shapes ---- */

typedef struct shape {
    daft_vec3 corners[600];
    uint32_t indices[3600], count, triangles;
    bool sheet; /* glows to both sides; else it is closed and convex */
} shape;

static void add_quad(shape *s, uint32_t a, uint32_t b, uint32_t c, uint32_t d)
{
    const uint32_t all[6] = {a, b, c, a, c, d};
    memcpy(&s->indices[3 * s->triangles], all, sizeof all);
    s->triangles += 2;
}

static shape quad(void)
{
    shape s = {.corners = {{-0.5f, 0, -0.5f}, {-0.5f, 0, 0.5f}, {0.5f, 0, 0.5f}, {0.5f, 0, -0.5f}}, .count = 4};
    s.sheet = true;
    add_quad(&s, 0, 1, 2, 3);
    return s;
}

static shape box(void)
{
    shape s = {.count = 8};
    for (int i = 0; i < 8; i++)
        s.corners[i] = (daft_vec3){i & 1 ? 0.5f : -0.5f, i & 2 ? 0.5f : -0.5f, i & 4 ? 0.5f : -0.5f};
    add_quad(&s, 0, 4, 6, 2), add_quad(&s, 1, 3, 7, 5), add_quad(&s, 0, 1, 5, 4);
    add_quad(&s, 2, 6, 7, 3), add_quad(&s, 0, 2, 3, 1), add_quad(&s, 4, 5, 7, 6);
    return s;
}

/* Rings of 24 from one end of the y axis to the other: of radius and height `ring` says, 0 to 1 along. */
static shape turned(uint32_t rings, void ring(double along, double *radius, double *height))
{
    shape s = {.count = 24 * rings};
    for (uint32_t i = 0; i < s.count; i++) {
        double radius, height;
        ring((double)(i / 24) / (rings - 1), &radius, &height);
        const double angle = 2 * PI * (i % 24) / 24;
        s.corners[i] = (daft_vec3){(float)(radius * cos(angle)), (float)height, (float)(radius * sin(angle))};
    }
    for (uint32_t i = 0; i + 24 < s.count; i++) {
        const uint32_t next = i / 24 * 24 + (i + 1) % 24;
        add_quad(&s, i, i + 24, next + 24, next);
    }
    return s;
}

static void ball_ring(double along, double *radius, double *height)
{
    *radius = 0.5 * sin(PI * fmin(fmax(along, 1e-3), 1 - 1e-3)), *height = -0.5 * cos(PI * along);
}
static void tube_ring(double along, double *radius, double *height)
{
    *radius = along < 0.1 || along > 0.9 ? 1e-4 : 0.125, *height = along < 0.5 ? -0.5 : 0.5;
}

/* ---- the truth ---- */

static d3 turn(daft_quat q, d3 v)
{
    const d3 u = {(double)q.x, (double)q.y, (double)q.z};
    const d3 t = mul(cross(u, v), 2);
    return add(add(v, mul(t, (double)q.w)), cross(u, t));
}

static d3 corner(const shape *s, uint32_t index, const daft_transform *t)
{
    const daft_vec3 c = s->corners[s->indices[index]];
    const d3 scaled = {(double)c.x * (double)t->scale.x, (double)c.y * (double)t->scale.y,
                       (double)c.z * (double)t->scale.z};
    return add(turn(t->rotation, scaled), (d3){t->position.x, t->position.y, t->position.z});
}

/* What a white floor's point sends on of a light of radiance 1: `side`² places a triangle. */
static double irradiance(const shape *s, const daft_transform *t, d3 p, int side)
{
    const double mirrored = (double)(t->scale.x * t->scale.y * t->scale.z) < 0 ? -1 : 1;
    double sum = 0;
    for (uint32_t i = 0; i < s->triangles; i++) {
        const d3 a = corner(s, 3 * i, t), u = sub(corner(s, 3 * i + 1, t), a), v = sub(corner(s, 3 * i + 2, t), a),
                 n = mul(cross(u, v), mirrored * 0.5);
        for (int k = 0; k < side * side; k++) {
            double x = (k % side + 1 / 3.0) / side, y = (k / side + 1 / 3.0) / side;
            if (x + y > 1) x = 1 - x, y = 1 - y;
            const d3 to = sub(add(a, add(mul(u, x), mul(v, y))), p);
            const double there = s->sheet ? fabs(dot(n, to)) : fmax(-dot(n, to), 0);
            sum += fmax(to.y, 0) * there / (PI * dot(to, to) * dot(to, to)) / (side * side);
        }
    }
    return sum;
}

/* Of these sizes, and then turned within its mesh. */
static shape askew(shape s, daft_vec3 size)
{
    const daft_quat q = {0.3f, 0.5f, -0.2f, 0.78740079f};
    for (uint32_t i = 0; i < s.count; i++) {
        const daft_vec3 c = s.corners[i];
        const d3 v = turn(q, (d3){(double)(c.x * size.x), (double)(c.y * size.y), (double)(c.z * size.z)});
        s.corners[i] = (daft_vec3){(float)v.x, (float)v.y, (float)v.z};
    }
    return s;
}

/* ---- pictures ---- */

static daft_material_def white(void)
{
    daft_material_def m = daft_default_material_def();
    m.ambient = m.diffuse = (daft_vec3){1, 1, 1}, m.specular = (daft_vec3){0, 0, 0};
    return m;
}

static daft_material material_of(stage *s, float emission)
{
    daft_error error = {0};
    daft_material_def m = white();
    m.emission = (daft_vec3){emission, emission, emission};
    return daft_material_create(s->scene, &m, &error);
}

static daft_entity put(stage *s, const daft_entity_def *def)
{
    daft_error error = {0};
    const daft_entity made = daft_entity_create(s->scene, def, &error);
    if (!made.id) fail_msg("%s", error.message);
    return made;
}

static daft_entity_def box_def(stage *s, daft_dvec3 at, daft_vec3 size, float emission)
{
    daft_entity_def def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_BOX, def.size = size, def.position = at, def.material = material_of(s, emission);
    return def;
}

/* The floor at y = 0, and nothing that lights. */
static stage *on_a_floor(int threads, const char *isa)
{
    stage *s = stage_make(threads, isa);
    daft_scene_set_ambient(s->scene, (daft_vec3){0, 0, 0});
    daft_scene_set_sky_color(s->scene, (daft_vec3){0, 0, 0});
    const daft_entity_def floor = box_def(s, (daft_dvec3){0, -0.05, 0}, (daft_vec3){20, 0.1f, 20}, 0);
    put(s, &floor);
    s->view.camera.position = (daft_dvec3){-3, 3, 0};
    s->view.camera.pitch = 0.8f, s->view.camera.fov = 1;
    s->view.quality.edge_samples = 0, s->view.quality.denoise = false;
    return s;
}

static daft_entity_def glowing(stage *s, const shape *of, const daft_transform *at)
{
    daft_error error = {0};
    daft_mesh_def mesh = daft_default_mesh_def();
    daft_entity_def def = daft_default_entity_def();
    mesh.positions = of->corners, mesh.vertex_count = of->count;
    mesh.indices = of->indices, mesh.triangle_count = of->triangles;
    def.shape = DAFT_SHAPE_MESH, def.mesh = daft_mesh_create(s->scene, &mesh, &error);
    if (!def.mesh.id) fail_msg("%s", error.message);
    def.position = at->position, def.rotation = at->rotation, def.scale = at->scale;
    def.material = material_of(s, 3), def.lights = true;
    return def;
}

static bool is_floor(const stage *s, int pixel, d3 *p)
{
    const daft_vec3 ray = daft_camera_ray(&s->view.camera, (pixel % WIDTH + 0.5) / WIDTH,
                                          (pixel / WIDTH + 0.5) / HEIGHT, (double)HEIGHT / WIDTH);
    const d3 d = {(double)ray.x, (double)ray.y, (double)ray.z}, o = {-3, 3, 0};
    *p = add(o, mul(d, -o.y / d.y));
    const double far = sqrt(dot(sub(*p, o), sub(*p, o)));
    return (double)s->normal[pixel].y > 0.999 && fabs((double)s->depth[pixel] - far) < 0.05;
}

/* The worst and the mean error over the truth, at the floor's pixels farther from the middle than that. */
static void compare(const stage *s, const shape *of, const daft_transform *at, double beyond, double *worst,
                    double *mean)
{
    int count = 0;
    *worst = *mean = 0;
    for (int i = 0; i < PIXELS; i += 37) {
        d3 p;
        if (!is_floor(s, i, &p)) continue;
        const d3 to = sub(p, (d3){at->position.x, at->position.y, at->position.z});
        if (dot(to, to) < beyond * beyond) continue;
        const double truth = 3 * irradiance(of, at, p, of->triangles > 20 ? 3 : 24);
        const double gap = fabs((double)s->color[i].x - truth) / truth;
        if (truth < 1e-4) continue; /* edge on */
        *worst = fmax(*worst, gap), *mean += gap, count++;
    }
    assert_true(count > 300);
    *mean /= count;
}

static daft_transform at(double x, double y, double z)
{
    return (daft_transform){.position = {x, y, z}, .rotation = {0, 0, 0, 1}, .scale = {1, 1, 1}};
}

/* Boxes and flat meshes are lit as they are, even near; what is round from two of its sizes on; others about so. */
static void floors_are_lit_as_integration_says(void **unused)
{
    (void)unused;
    static const struct {
        const char *name;
        int shape; /* 0: quad, 1: box, 2: ball, 3: tube; 4 to 7: these, askew in their mesh */
        daft_vec3 scale;
        daft_quat rotation;
        double height, beyond, worst, mean;
    } CASES[] = {
        {"level quad", 0, {1, 1, 0.6f}, {0, 0, 0, 1}, 0.6, 0, 3e-3, 1e-3},
        {"tilted quad", 0, {1, 1, 0.6f}, {0.3f, 0.2f, 0.1f, 0.9f}, 1, 0, 0.01, 1e-3},
        {"box", 1, {0.5f, 0.5f, 0.5f}, {0, 0, 0, 1}, 0.5, 0, 3e-3, 1e-3},
        {"turned box", 1, {0.5f, 0.3f, 0.8f}, {0.3f, 0.2f, 0.1f, 0.9f}, 0.8, 0, 6e-3, 2e-3},
        {"mirrored thin box", 1, {-0.5f, 0.02f, 0.5f}, {0.1f, 0.2f, 0.1f, 0.9f}, 0.8, 0, 6e-3, 2e-3},
        {"ball", 2, {0.5f, 0.5f, 0.5f}, {0.1f, 0.2f, 0.1f, 0.9f}, 1, 1, 0.01, 2e-3},
        {"flattened ball", 2, {1, 0.15f, 1}, {0, 0, 0, 1}, 2, 2, 0.2, 0.08},
        {"lying tube", 3, {1, 1, 1}, {0.7f, 0, 0, 0.7f}, 2, 2, 0.2, 0.1},
        {"askew quad", 4, {1, 1, 1}, {0.3f, 0.2f, 0.1f, 0.9f}, 1, 0, 0.01, 1e-3},
        {"askew box", 5, {1, 1, 1}, {0, 0, 0, 1}, 0.7, 0, 6e-3, 2e-3},
        {"askew box, stretched", 5, {0.8f, 1.2f, -0.5f}, {0.3f, 0.2f, 0.1f, 0.9f}, 0.9, 0, 6e-3, 2e-3},
        {"askew ball", 6, {0.5f, 0.5f, 0.5f}, {0.1f, 0.2f, 0.1f, 0.9f}, 1, 1, 0.01, 2e-3},
        {"askew tube", 7, {1, 1, 1}, {0.7f, 0, 0, 0.7f}, 2, 2, 0.2, 0.1},
    };
    static shape shapes[8];
    shapes[0] = quad(), shapes[1] = box(), shapes[2] = turned(13, ball_ring), shapes[3] = turned(4, tube_ring);
    shapes[4] = askew(quad(), (daft_vec3){1, 1, 0.4f}), shapes[5] = askew(box(), (daft_vec3){0.6f, 0.3f, 0.4f});
    shapes[6] = askew(shapes[2], (daft_vec3){1, 1, 1}), shapes[7] = askew(shapes[3], (daft_vec3){1, 1, 1});
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++) {
        stage *s = on_a_floor(2, NULL);
        const shape *of = &shapes[CASES[i].shape];
        daft_transform t = at(0.2, CASES[i].height, 0.1);
        const daft_quat q = CASES[i].rotation;
        const float length = sqrtf(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
        t.scale = CASES[i].scale, t.rotation = (daft_quat){q.x / length, q.y / length, q.z / length, q.w / length};
        const daft_entity_def def = glowing(s, of, &t);
        put(s, &def);
        draw(s);
        double worst, mean;
        compare(s, of, &t, CASES[i].beyond, &worst, &mean);
        print_message("%s: off by %.4f at most, %.4f in the mean\n", CASES[i].name, worst, mean);
        assert_true(worst < CASES[i].worst && mean < CASES[i].mean);
        stage_drop(s);
    }
}

static double light_at_middle(stage *s)
{
    draw(s);
    return (double)s->color[PIXELS / 2 + WIDTH / 2].x;
}

/* What glows is as bright as it is, on all sides, however its stand-in lies; it stops no ray of its own light. */
static void it_neither_lights_nor_hides_itself(void **unused)
{
    (void)unused;
    static shape shapes[4];
    shapes[0] = quad(), shapes[1] = box(), shapes[2] = turned(13, ball_ring), shapes[3] = turned(4, tube_ring);
    for (int k = 0; k < 8; k++) {
        stage *s = on_a_floor(2, NULL);
        daft_transform t = at(0, 0.9, 0);
        t.rotation = (daft_quat){0.6f, 0, 0, 0.8f};
        daft_entity_def def = glowing(s, &shapes[k % 4], &t);
        put(s, &def);
        s->view.quality.shadow_samples = k < 4 ? 0 : 4;
        draw(s);
        int own = 0, dark = 0;
        for (int i = 0; i < PIXELS; i++) {
            d3 p;
            if (is_floor(s, i, &p)) {
                dark += !((double)s->color[i].x > 1e-4);
            } else if (isfinite(s->depth[i])) {
                own++;
                if (fabs((double)s->color[i].x - 3) > 1e-5) fail_msg("shape %d: %.5f", k, (double)s->color[i].x);
            }
        }
        print_message("shape %d: %d pixels of its own, %d dark ones of the floor\n", k % 4, own, dark);
        assert_true(own > 200 && dark < (k % 4 ? 1 : 200)); /* a sheet lights nothing in its own plane */
        stage_drop(s);
    }
}

static void it_throws_shadows_of_others(void **unused)
{
    (void)unused;
    stage *s = on_a_floor(2, NULL);
    daft_entity_def lamp = box_def(s, (daft_dvec3){0, 1.5, 0}, (daft_vec3){0.3f, 0.3f, 0.3f}, 3);
    lamp.lights = true;
    put(s, &lamp);
    const double open = light_at_middle(s);
    const daft_entity_def board = box_def(s, (daft_dvec3){0, 0.7, 0}, (daft_vec3){1, 0.02f, 1}, 0);
    const daft_entity between = put(s, &board);
    s->view.camera.position = (daft_dvec3){-1.2, 0.6, 0}, s->view.camera.pitch = 0.46f; /* below the board */
    const double shadowed = light_at_middle(s);
    daft_error error = {0};
    assert_true(daft_entity_destroy(s->scene, between, &error));
    const double again = light_at_middle(s);
    print_message("open %.4f, in shadow %.4f, below %.4f\n", open, shadowed, again);
    assert_true(open > 0.04 && shadowed < 1e-6 && again > 0.04);
    stage_drop(s);
}

/* Where no entity asks, nothing is lit and no ray is cast; nor where it is black, hidden or gone. */
static void light_is_there_while_it_is_asked_for(void **unused)
{
    (void)unused;
    stage *s = on_a_floor(2, NULL);
    daft_error error = {0};
    daft_entity_def def = box_def(s, (daft_dvec3){0, 1.5, 0.3}, (daft_vec3){0.4f, 0.4f, 0.4f}, 3);
    const daft_entity silent = put(s, &def);
    const uint64_t without = daft_scene_hash(s->scene);
    assert_true(light_at_middle(s) == 0);
    assert_int_equal(daft_scene_counters(s->scene)->effects[DAFT_EFFECT_SHADOW].rays, 0);
    assert_false(daft_scene_counters(s->scene)->effects[DAFT_EFFECT_LIGHTING].ran);
    assert_true(daft_entity_destroy(s->scene, silent, &error));

    def.lights = true;
    const daft_entity lamp = put(s, &def);
    assert_true(daft_scene_hash(s->scene) != without);
    const double first = light_at_middle(s);
    daft_transform t = at(0, 1.5, 0.3);
    assert_true(first > 0.05);
    t.scale = (daft_vec3){2, 2, 2};
    assert_true(daft_entity_set_transform(s->scene, lamp, &t, true, &error));
    const double larger = light_at_middle(s);
    t = at(0, 4, 0.3);
    assert_true(daft_entity_set_transform(s->scene, lamp, &t, true, &error));
    const double farther = light_at_middle(s);
    print_message("%.4f; twice as large %.4f; farther %.4f\n", first, larger, farther);
    assert_true(larger > 3 * first && larger < 6 * first && farther < first / 4 && farther > 0);
    t = at(0, 1.5, 0.3);
    assert_true(daft_entity_set_transform(s->scene, lamp, &t, true, &error));
    assert_true(light_at_middle(s) == first);
    assert_true(daft_entity_set_visible(s->scene, lamp, false, &error));
    assert_true(light_at_middle(s) == 0);
    assert_true(daft_entity_set_visible(s->scene, lamp, true, &error));
    assert_true(light_at_middle(s) == first);
    assert_true(daft_entity_set_material(s->scene, lamp, material_of(s, 6), &error));
    assert_true(fabs(light_at_middle(s) - 2 * first) < 1e-5);
    assert_true(daft_entity_set_material(s->scene, lamp, material_of(s, 0), &error));
    assert_true(light_at_middle(s) == 0);
    assert_true(daft_entity_destroy(s->scene, lamp, &error));
    assert_true(light_at_middle(s) == 0);
    stage_drop(s);
}

static void write_text(const char *path, const char *text)
{
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fputs(text, file);
    fclose(file);
}

/* Of a file's slots only those that glow light; an emission map counts by its mean, in linear light. */
static void materials_of_a_mesh_decide(void **unused)
{
    (void)unused;
    static uint8_t rows[18 + 3 * 4] = {0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 2, 0, 2, 0, 24, 0x20};
    memset(rows + 18, 0, 12);
    memset(rows + 18, 255, 3); /* one of four texels is white */
    FILE *image = fopen("glow_map.tga", "wb");
    assert_non_null(image);
    assert_int_equal(fwrite(rows, 1, sizeof rows, image), sizeof rows);
    fclose(image);
    write_text("glow_lamp.obj", "mtllib glow_lamp.mtl\n"
                                "v -1 0 -1\nv -1 0 1\nv 1 0 1\nv 1 0 -1\nv -.2 .5 -.2\nv -.2 .5 .2\nv .2 .5 .2\n"
                                "v .2 .5 -.2\nusemtl tube\nf 8 7 6 5\nusemtl shade\nf 1 4 3 2\n");
    double light[3];
    for (int k = 0; k < 3; k++) {
        write_text("glow_lamp.mtl", k == 0   ? "newmtl tube\nKe 4 4 4\nnewmtl shade\nKd 1 1 1\n"
                                    : k == 1 ? "newmtl tube\nKe 4 4 4\nmap_Ke glow_map.tga\nnewmtl shade\nKd 1 1 1\n"
                                             : "newmtl tube\nKd 1 1 1\nnewmtl shade\nKe 4 4 4\n");
        stage *s = on_a_floor(2, NULL);
        daft_error error = {0};
        daft_entity_def def = daft_default_entity_def();
        def.shape = DAFT_SHAPE_MESH, def.mesh = daft_mesh_load(s->scene, "glow_lamp.obj", &error);
        if (!def.mesh.id) fail_msg("%s", error.message);
        def.position = (daft_dvec3){3, 1.5, 0}, def.rotation = (daft_quat){0, 0, 0.70710678f, 0.70710678f};
        def.lights = true; /* on edge: the tube's side is seen from the floor's middle, past the shade */
        put(s, &def);
        light[k] = light_at_middle(s);
        stage_drop(s);
    }
    /* So does a ball's. */
    write_text("glow_lamp.mtl", "newmtl plain\nKe 4 4 4\nnewmtl mapped\nKe 4 4 4\nmap_Ke glow_map.tga\n");
    double ball[2];
    for (int k = 0; k < 2; k++) {
        stage *s = on_a_floor(2, NULL);
        daft_error error = {0};
        daft_entity_def def = daft_default_entity_def();
        def.shape = DAFT_SHAPE_SPHERE, def.radius = 0.3f, def.position = (daft_dvec3){0, 1.5, 1}, def.lights = true;
        def.material = daft_material_load(s->scene, k ? "glow_lamp.mtl#mapped" : "glow_lamp.mtl#plain", &error);
        if (!def.material.id) fail_msg("%s", error.message);
        put(s, &def);
        ball[k] = light_at_middle(s);
        stage_drop(s);
    }
    assert_true(ball[0] > 1e-2 && fabs(ball[1] / ball[0] - 0.25) < 5e-3);
    print_message("the tube %.5f, with a map %.5f, the shade %.5f\n", light[0], light[1], light[2]);
    assert_true(light[0] > 1e-3 && fabs(light[1] / light[0] - 0.25) < 5e-3);
    assert_true(light[2] > 10 * light[0]); /* 25 times the tube's area, a little farther */
}

static void pictures_are_the_same_everywhere(void **unused)
{
    (void)unused;
    static const char *const NAMES[] = {NULL, "plain", "sse2", "avx2", "avx512"};
    static uint8_t first[4 * PIXELS];
    static shape shapes[2];
    shapes[0] = box(), shapes[1] = turned(13, ball_ring);
    for (int isa = 0; isa < 5; isa++) {
        daft_engine_def engine = daft_default_engine_def();
        engine.isa = NAMES[isa];
        daft_engine *probe = daft_engine_create(&engine, NULL);
        if (!probe) continue; /* this machine or build lacks it */
        daft_engine_destroy(probe);
        stage *s = on_a_floor(isa + 1, engine.isa);
        for (int k = 0; k < 2; k++) {
            const daft_transform t = at(0.5 * k, 1.2 + 0.1 * k, k - 0.5);
            const daft_entity_def def = glowing(s, &shapes[k], &t);
            put(s, &def);
        }
        draw(s);
        if (isa == 0) memcpy(first, daft_image_pixels(s->image), sizeof first);
        assert_memory_equal(first, daft_image_pixels(s->image), sizeof first);
        stage_drop(s);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(floors_are_lit_as_integration_says), cmocka_unit_test(it_neither_lights_nor_hides_itself),
        cmocka_unit_test(it_throws_shadows_of_others),        cmocka_unit_test(light_is_there_while_it_is_asked_for),
        cmocka_unit_test(materials_of_a_mesh_decide),         cmocka_unit_test(pictures_are_the_same_everywhere)};
    const int failed = cmocka_run_group_tests(tests, NULL, NULL);
    remove("glow_lamp.mtl"), remove("glow_lamp.obj"), remove("glow_map.tga");
    return failed;
}
