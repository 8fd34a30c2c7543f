/* Any bytes as calls of daft.h: what they make, move and destroy, with numbers of every size, is then drawn, hit by
 * rays and simulated. Promises tested:
 *   - calls take or refuse anything; afterwards nothing that comes out is NaN;
 *   - the pencil and single rays through the BVH see the same entity and triangle in every pixel;
 *   - two instruction sets give the same picture and the same state.
 *
 * A byte chooses the call, the bytes after it are its arguments; where they run out everything is 0. */
#include "fuzz.h"

#include <math.h>
#include <string.h>

enum { WIDTH = 32, HEIGHT = 24, PIXELS = WIDTH * HEIGHT, CALLS = 64 };
enum { ENTITIES = 24, LIGHTS = 4, MATERIALS = 8, MESHES = 4, VERTICES = 16, TRIANGLES = 16 };

typedef struct player {
    const uint8_t *at, *end;
    daft_scene *scene;
    daft_engine *engine;
    daft_entity entities[ENTITIES];
    daft_light lights[LIGHTS];
    daft_material materials[MATERIALS];
    daft_mesh meshes[MESHES];
    int entity_count, light_count, material_count, mesh_count, steps;
    uint64_t digest;
} player;

/* ---- bytes to values ---- */

static uint8_t take(player *p) { return p->at < p->end ? *p->at++ : 0; }

static void take_bytes(player *p, void *out, size_t size)
{
    for (size_t i = 0; i < size; i++) ((uint8_t *)out)[i] = take(p);
}

/* Mostly of a size with which something can be seen; also any float, any double, and the ends of their ranges. */
static double number(player *p)
{
    static const double special[16] = {0,       -0.0,  1,     -1,     NAN,     INFINITY, -INFINITY, 3.4e38,
                                       -3.4e38, 1e-38, 1e-45, 5e-324, 1.7e308, -1.7e308, 16777217,  1e7};
    float single;
    double whole;
    uint8_t kind = take(p);
    switch (kind & 15) {
    case 10: return ldexp((int8_t)take(p), (int8_t)take(p));
    case 11: return (int8_t)take(p) * 1e6 + (int8_t)take(p);
    case 12: return ldexp((int8_t)take(p), (int8_t)take(p) / 4);
    case 13: return take_bytes(p, &single, sizeof single), (double)single;
    case 14: return take_bytes(p, &whole, sizeof whole), whole;
    case 15: return special[take(p) & 15];
    default: return (int8_t)take(p) / 16.0 * (1 << (kind & 7));
    }
}

static float single_number(player *p) { return (float)number(p); }

static daft_vec3 vector(player *p)
{
    float x = single_number(p), y = single_number(p);
    return (daft_vec3){x, y, single_number(p)};
}

static daft_dvec3 place(player *p)
{
    double x = number(p), y = number(p);
    return (daft_dvec3){x, y, number(p)};
}

static daft_vec3 color(player *p)
{
    uint8_t kind = take(p);
    if (kind == 255) return vector(p);
    return (daft_vec3){(float)(kind & 3) / 3, (float)(kind >> 2 & 3) / 3, (float)(kind >> 4 & 3) / 3};
}

static daft_transform transform(player *p)
{
    daft_transform out = {place(p), {0, 0, 0, 1}, {1, 1, 1}};
    uint8_t kind = take(p);
    if (kind & 1) {
        daft_vec3 axis = vector(p);
        out.rotation = (daft_quat){axis.x, axis.y, axis.z, single_number(p)};
    }
    if (kind & 2) out.scale = vector(p);
    if (kind & 4) {
        float s = single_number(p);
        out.scale = (daft_vec3){s, s, s};
    }
    return out;
}

/* Now and then a handle that is none, or stale. */
#define PICK(p, array, count) ((array)[take(p) % ((count) + 1)])

/* ---- calls ---- */

static void make_mesh(player *p)
{
    daft_vec3 positions[VERTICES], normals[VERTICES];
    daft_vec2 uvs[VERTICES];
    uint32_t indices[3 * TRIANGLES];
    uint8_t kind = take(p);
    daft_mesh_def def = daft_default_mesh_def();
    def.positions = positions;
    def.indices = indices;
    def.vertex_count = 3 + take(p) % (VERTICES - 2);
    def.triangle_count = 1 + take(p) % TRIANGLES;
    for (uint32_t i = 0; i < def.vertex_count; i++) positions[i] = vector(p);
    for (uint32_t i = 0; i < 3 * def.triangle_count; i++) {
        uint8_t index = take(p);
        indices[i] = kind & 1 ? index : index % def.vertex_count;
    }
    if (kind & 2) def.normals = normals;
    if (kind & 4) def.uvs = uvs;
    for (uint32_t i = 0; i < def.vertex_count && (kind & 2); i++) normals[i] = vector(p);
    for (uint32_t i = 0; i < def.vertex_count && (kind & 4); i++)
        uvs[i] = (daft_vec2){single_number(p), single_number(p)};
    daft_mesh made = daft_mesh_create(p->scene, &def, NULL);
    if (made.id && p->mesh_count < MESHES - 1) p->meshes[p->mesh_count++] = made;
}

static void make_material(player *p)
{
    daft_material_def def = daft_default_material_def();
    uint8_t kind = take(p);
    def.diffuse = color(p);
    def.mirror = kind & 1 ? 0.5f : kind & 2 ? single_number(p) : 0;
    if (kind & 4) def.specular = color(p), def.shininess = single_number(p);
    if (kind & 8) def.emission = color(p);
    if (kind & 16) def.mirror_tint = color(p), def.ambient = color(p);
    if (kind & 32) def.transmission = kind & 64 ? 1 : single_number(p), def.transmission_tint = color(p);
    if (kind & 128) def.refractive_index = single_number(p);
    daft_material made = {0};
    if (p->material_count < MATERIALS - 1) made = daft_material_create(p->scene, &def, NULL);
    if (made.id)
        p->materials[p->material_count++] = made;
    else
        daft_material_set(p->scene, PICK(p, p->materials, p->material_count), &def, NULL);
}

static void make_entity(player *p)
{
    daft_entity_def def = daft_default_entity_def();
    uint8_t kind = take(p);
    def.shape = (daft_shape)(kind & 3);
    if (def.shape == DAFT_SHAPE_MESH) def.mesh = PICK(p, p->meshes, p->mesh_count);
    if (def.shape == DAFT_SHAPE_SPHERE) def.radius = single_number(p);
    if (def.shape == DAFT_SHAPE_BOX) def.size = vector(p);
    def.body = (daft_body_kind)(kind >> 2 & 3);
    def.material = PICK(p, p->materials, p->material_count);
    if (kind & 16) def.parent = PICK(p, p->entities, p->entity_count);
    if (kind & 32) {
        daft_transform pose = transform(p);
        def.position = pose.position;
        def.rotation = pose.rotation;
        def.scale = pose.scale;
    } else
        def.position = place(p);
    if (kind & 64) {
        def.density = single_number(p);
        def.friction = single_number(p);
        def.restitution = single_number(p);
        def.rolling_resistance = single_number(p);
    }
    def.casts_shadow = !(kind & 128);
    if (p->entity_count >= ENTITIES - 1) return;
    daft_entity made = daft_entity_create(p->scene, &def, NULL);
    if (made.id) p->entities[p->entity_count++] = made;
}

static void make_light(player *p)
{
    daft_light_def def = daft_default_light_def();
    uint8_t kind = take(p);
    def.kind = kind & 1    ? DAFT_LIGHT_SUN
               : kind & 4  ? DAFT_LIGHT_SPOT
               : kind & 16 ? DAFT_LIGHT_RECTANGLE
                           : DAFT_LIGHT_POINT;
    def.position = place(p);
    if (kind & 21) def.direction = vector(p);
    if (def.kind == DAFT_LIGHT_RECTANGLE)
        def.size.x = single_number(p), def.size.y = single_number(p), def.turn = single_number(p);
    if (def.kind == DAFT_LIGHT_SPOT) def.inner_angle = single_number(p), def.outer_angle = single_number(p);
    def.color = color(p);
    def.casts_shadow = !(kind & 2);
    daft_light made = {0};
    if (p->light_count < LIGHTS - 1) made = daft_light_create(p->scene, &def, NULL);
    if (made.id)
        p->lights[p->light_count++] = made;
    else
        daft_light_set(p->scene, PICK(p, p->lights, p->light_count), &def, NULL);
    if (kind & 128) daft_light_destroy(p->scene, PICK(p, p->lights, p->light_count), NULL);
}

static void set_camera(player *p)
{
    daft_camera camera = daft_default_camera();
    uint8_t kind = take(p);
    camera.position = place(p);
    if (kind & 1) {
        camera = daft_camera_look_at(camera.position, place(p), kind & 2 ? single_number(p) : 1.5f);
    } else {
        camera.yaw = single_number(p);
        camera.pitch = single_number(p);
        if (kind & 2) camera.roll = single_number(p), camera.fov = single_number(p);
    }
    daft_scene_set_camera(p->scene, &camera, kind & 4, NULL);
}

/* From beside an entity, however far away and small it is. */
static void look_at_entity(player *p)
{
    daft_transform pose;
    if (!daft_entity_get_transform(p->scene, PICK(p, p->entities, p->entity_count), &pose, NULL)) return;
    daft_dvec3 from = place(p);
    from.x += pose.position.x, from.y += pose.position.y, from.z += pose.position.z;
    daft_camera camera = daft_camera_look_at(from, pose.position, 1.5f);
    daft_scene_set_camera(p->scene, &camera, true, NULL);
}

static void set_surroundings(player *p)
{
    switch (take(p) & 3) {
    case 0: daft_scene_set_ambient(p->scene, color(p)); break;
    case 1: daft_scene_set_sky_color(p->scene, color(p)); break;
    case 2: daft_scene_set_sky_gradient(p->scene, color(p), color(p)); break;
    default: daft_scene_set_gravity(p->scene, vector(p));
    }
}

static void change_entity(player *p)
{
    daft_entity entity = PICK(p, p->entities, p->entity_count);
    uint8_t kind = take(p);
    daft_transform pose;
    daft_vec3 push;
    switch (kind & 7) {
    case 0:
    case 1:
        pose = transform(p);
        daft_entity_set_transform(p->scene, entity, &pose, kind & 8, NULL);
        break;
    case 2: daft_entity_set_visible(p->scene, entity, kind & 8, NULL); break;
    case 3: daft_entity_set_material(p->scene, entity, PICK(p, p->materials, p->material_count), NULL); break;
    case 4:
        push = vector(p);
        daft_entity_set_velocity(p->scene, entity, push, vector(p), NULL);
        break;
    case 5: daft_entity_apply_force(p->scene, entity, vector(p), NULL); break;
    case 6: daft_entity_apply_impulse(p->scene, entity, vector(p), NULL); break;
    default: daft_entity_destroy(p->scene, entity, NULL);
    }
}

/* ---- what comes out ---- */

static bool is_finite(daft_vec3 v) { return isfinite(v.x) && isfinite(v.y) && isfinite(v.z); }

static void add_to_digest(player *p, const void *bytes, size_t size) { p->digest = daft_hash(bytes, size, p->digest); }

static void cast_ray(player *p)
{
    daft_ray_hit hit;
    daft_error error = {0};
    daft_dvec3 origin = place(p);
    daft_vec3 direction = vector(p);
    float distance = single_number(p);
    daft_entity ignore = PICK(p, p->entities, p->entity_count);
    if (!daft_scene_cast_ray(p->scene, origin, direction, distance, ignore, &hit, &error)) return;
    FUZZ_CHECK(daft_entity_is_valid(p->scene, hit.entity) && hit.entity.id != ignore.id);
    FUZZ_CHECK(hit.distance >= 0 && !isnan(hit.position.x) && !isnan(hit.position.y) && !isnan(hit.position.z));
    FUZZ_CHECK(is_finite(hit.normal) && isfinite(hit.uv.x) && isfinite(hit.uv.y));
    add_to_digest(p, &hit.distance, sizeof hit.distance);
}

static void step(player *p)
{
    daft_error error = {0};
    if (p->steps++ > 8) return;
    daft_scene_begin_tick(p->scene);
    FUZZ_CHECK(daft_scene_step(p->scene, 1.0f / 60, &error));
    for (int i = 0; i < p->entity_count; i++) {
        daft_transform pose;
        if (!daft_entity_get_transform(p->scene, p->entities[i], &pose, NULL)) continue;
        FUZZ_CHECK(isfinite(pose.position.x) && isfinite(pose.position.y) && isfinite(pose.position.z));
        FUZZ_CHECK(isfinite(pose.rotation.x) && isfinite(pose.rotation.w));
    }
    daft_contact contacts[16];
    uint32_t count = daft_scene_contacts(p->scene, contacts, 16);
    for (uint32_t i = 0; i < count && i < 16; i++)
        FUZZ_CHECK(is_finite(contacts[i].normal) && !isnan(contacts[i].impulse));
}

typedef struct seen {
    float depth[PIXELS];
    daft_vec3 normal[PIXELS];
    daft_entity entity[PIXELS];
    uint32_t triangle[PIXELS];
} seen;

static void draw(player *p, bool reference, seen *out)
{
    daft_error error = {0};
    daft_image *picture = daft_image_create(p->engine, WIDTH, HEIGHT, &error);
    daft_view view = daft_default_view();
    view.camera = daft_scene_camera(p->scene, 1);
    view.quality = daft_preset_quality(DAFT_PRESET_GAME);
    view.quality.tree = reference ? DAFT_TREE_BVH : DAFT_TREE_RASTER;
    view.aov = (daft_aov){.depth = out->depth, .normal = out->normal, .entity = out->entity, .triangle = out->triangle};
    FUZZ_CHECK(picture && daft_render(p->scene, &view, picture, &error));
    add_to_digest(p, daft_image_pixels(picture), 4 * PIXELS);
    daft_image_destroy(picture);
    for (int i = 0; i < PIXELS; i++) {
        FUZZ_CHECK(out->depth[i] >= 0);
        FUZZ_CHECK(is_finite(out->normal[i]));
        FUZZ_CHECK(!out->entity[i].id || daft_entity_is_valid(p->scene, out->entity[i]));
    }
}

static void draw_both_ways(player *p)
{
    static seen pencil, single;
    draw(p, false, &pencil);
    draw(p, true, &single);
    for (int i = 0; i < PIXELS; i++) {
        if (pencil.entity[i].id == single.entity[i].id && pencil.triangle[i] == single.triangle[i]) continue;
        fprintf(stderr, "pixel %d, %d: pencil %08x %u at %.9g, single ray %08x %u at %.9g\n", i % WIDTH, i / WIDTH,
                pencil.entity[i].id, pencil.triangle[i], (double)pencil.depth[i], single.entity[i].id,
                single.triangle[i], (double)single.depth[i]);
        FUZZ_CHECK(pencil.entity[i].id == single.entity[i].id && pencil.triangle[i] == single.triangle[i]);
    }
}

static void play(player *p)
{
    for (int i = 0; i < CALLS && p->at < p->end; i++) switch (take(p) % 11) {
        case 0: make_mesh(p); break;
        case 1: make_material(p); break;
        case 2:
        case 3: make_entity(p); break;
        case 4: make_light(p); break;
        case 5: set_camera(p); break;
        case 6: set_surroundings(p); break;
        case 7: change_entity(p); break;
        case 8: cast_ray(p); break;
        case 10: look_at_entity(p); break;
        default: step(p);
        }
    draw_both_ways(p);
    step(p);
    step(p);
    draw_both_ways(p);
}

static uint64_t play_on(daft_engine *engine, const uint8_t *data, size_t size)
{
    player p = {.at = data, .end = data + size, .engine = engine, .scene = daft_scene_create(engine, NULL)};
    FUZZ_CHECK(p.scene);
    play(&p);
    uint64_t state = daft_scene_hash(p.scene);
    daft_scene_destroy(p.scene);
    return daft_hash(&state, sizeof state, p.digest);
}

static daft_engine *make_engine(const char *isa)
{
    daft_engine_def def = daft_default_engine_def();
    def.threads = 1;
    def.isa = isa;
    return daft_engine_create(&def, NULL);
}

int render_input(const uint8_t *data, size_t size)
{
    static daft_engine *least, *best;
    if (!least) least = make_engine(DAFT_NARROWEST_ISA);
    if (!best) best = make_engine(NULL);
    FUZZ_CHECK(best);
    uint64_t result = play_on(best, data, size);
    FUZZ_CHECK(!least || play_on(least, data, size) == result);
    return 0;
}
