/* Whole frames through the public API: camera rays, shadows, Lambert's law, sRGB bytes; against the same written with
 * Embree. And the cost of an effect that the scene does not call for. */
#include "harness/scenes.h"

#include "math/trig.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct bench_frame {
    daft_allocator allocator;
    daft_engine *engine;
    daft_scene *scene;
    daft_image *image;
    daft_view view;
    const bench_scene *shown;
    const bench_embree_api *api; /* NULL: there is no peer */
    bench_embree *embree;
    uint8_t *peer_pixels;
    bool aside; /* the camera has moved */
};

/* ---- filling a scene ---- */

static daft_mesh copy_mesh(bench *self, daft_scene *scene, const daft_trimesh *mesh, daft_error *error)
{
    daft_mesh_def def = daft_default_mesh_def();
    daft_vec3 *positions = bench_positions(self, mesh);
    if (!positions) return (daft_mesh){0};
    def.positions = positions, def.vertex_count = mesh->vertex_count;
    def.indices = mesh->indices, def.triangle_count = mesh->triangle_count;
    daft_mesh made = daft_mesh_create(scene, &def, error);
    daft_release(&self->allocator, positions);
    return made;
}

static bool add_instances(bench *self, daft_scene *scene, const bench_scene *from, daft_error *error)
{
    daft_mesh mesh[2] = {{0}, {0}};
    for (int i = 0; i < from->mesh_count; i++) {
        mesh[i] = copy_mesh(self, scene, &from->mesh[i], error);
        if (!mesh[i].id) return false;
    }
    daft_material_def material = daft_default_material_def();
    material.diffuse = BENCH_ALBEDO;
    material.ambient = material.diffuse, material.specular = daft_v3(0, 0, 0);
    daft_entity_def def = daft_default_entity_def();
    def.material = daft_material_create(scene, &material, error);
    for (uint32_t i = 0; def.material.id && i < from->instance_count; i++) {
        const bench_instance *item = &from->instances[i];
        bool sphere = item->mesh == BENCH_SPHERE;
        def.shape = sphere ? DAFT_SHAPE_SPHERE : DAFT_SHAPE_MESH;
        def.mesh = sphere ? (daft_mesh){0} : mesh[item->mesh];
        def.radius = item->scale;
        def.scale = sphere ? daft_v3(1, 1, 1) : daft_v3(item->scale, item->scale, item->scale);
        def.position = daft_to_double(item->position), def.rotation = item->rotation;
        if (!daft_entity_create(scene, &def, error).id) return false;
    }
    return def.material.id != 0;
}

static bool add_lights(daft_scene *scene, const bench_scene *from, int lights, daft_error *error)
{
    daft_light_def light = daft_default_light_def();
    light.color = daft_scale(BENCH_LIGHT_COLOR, 1 / (float)(lights ? lights : 1));
    for (int i = 0; i < lights; i++) {
        double turn = 2 * DAFT_PI * i / lights, c = daft_cos(turn), s = daft_sin(turn);
        daft_dvec3 at = daft_to_double(from->light);
        light.position = daft_dv3(c * at.x - s * at.z, at.y, s * at.x + c * at.z);
        if (!daft_light_create(scene, &light, error).id) return false;
    }
    daft_scene_set_ambient(scene, BENCH_AMBIENT);
    daft_scene_set_sky_color(scene, BENCH_SKY);
    return true;
}

bench_frame *bench_frame_create(bench *self, const bench_scene *scene, int threads, int lights)
{
    daft_error error = {0};
    char text[1200];
    bench_frame *frame = daft_alloc_zero(&self->allocator, 1, sizeof *frame);
    if (!frame) return NULL;
    frame->allocator = self->allocator;
    frame->shown = scene;
    daft_engine_def def = daft_default_engine_def();
    def.threads = threads, def.isa = self->isa;
    frame->view = daft_default_view();
    frame->view.quality.edge_samples = 0; /* the peer has one sample a pixel, too */
    frame->view.camera =
        daft_camera_look_at(daft_to_double(scene->view.from), daft_to_double(scene->view.at), scene->view.fov);
    frame->engine = daft_engine_create(&def, &error);
    if (frame->engine) frame->scene = daft_scene_create(frame->engine, &error);
    if (frame->scene) frame->image = daft_image_create(frame->engine, scene->view.width, scene->view.height, &error);
    if (frame->image && add_instances(self, frame->scene, scene, &error) &&
        add_lights(frame->scene, scene, lights, &error))
        return frame;
    bench_note(self, true, "%s: %s", scene->name, daft_error_text(&error, text, sizeof text));
    bench_frame_destroy(frame);
    return NULL;
}

void bench_frame_destroy(bench_frame *frame)
{
    if (!frame) return;
    daft_allocator allocator = frame->allocator;
    daft_image_destroy(frame->image);
    if (frame->scene) daft_scene_destroy(frame->scene);
    daft_engine_destroy(frame->engine);
    daft_release(&allocator, frame->peer_pixels);
    daft_release(&allocator, frame);
}

double bench_frame_ms(bench_frame *frame)
{
    double start = bench_clock_ms(daft_engine_threads(frame->engine));
    if (!daft_render(frame->scene, &frame->view, frame->image, NULL)) return -1;
    return bench_clock_ms(daft_engine_threads(frame->engine)) - start;
}

const daft_counters *bench_frame_counters(const bench_frame *frame) { return daft_scene_counters(frame->scene); }
const uint8_t *bench_frame_pixels(const bench_frame *frame) { return daft_image_pixels(frame->image); }

/* ---- against Embree ---- */

static double frame_ours(void *context) { return bench_frame_ms(context); }

/* The camera moves by a millimetre to and fro, so each frame rebuilds the instance list and the TLAS. */
static double frame_moved(void *context)
{
    bench_frame *frame = context;
    frame->aside = !frame->aside;
    frame->view.camera.position.x += frame->aside ? 1e-3 : -1e-3;
    return bench_frame_ms(context);
}

static double frame_peer(void *context)
{
    bench_frame *frame = context;
    return frame->api->frame_ms(frame->embree, frame->shown, frame->peer_pixels);
}

/* Milliseconds of each part, and the pixels in which the two pictures differ by more than 8 of 255 steps. */
static void frame_describe(void *context, char *out, size_t size)
{
    bench_frame *frame = context;
    const daft_counters *c = bench_frame_counters(frame);
    int used = snprintf(out, size, "visibility %.2f, surface %.2f, shadow %.2f, lighting %.2f ms, %llu shadow rays",
                        c->effects[DAFT_EFFECT_VISIBILITY].ms, c->effects[DAFT_EFFECT_SURFACE].ms,
                        c->effects[DAFT_EFFECT_SHADOW].ms, c->effects[DAFT_EFFECT_LIGHTING].ms,
                        (unsigned long long)c->shadow_rays);
    if (!frame->embree || used < 0 || (size_t)used >= size) return;
    size_t apart = 0, pixels = (size_t)(c->width * c->height);
    const uint8_t *ours = bench_frame_pixels(frame);
    for (size_t i = 0; i < pixels; i++) {
        int most = 0;
        for (size_t k = 4 * i; k < 4 * i + 4; k++) {
            int by = abs(ours[k] - frame->peer_pixels[k]);
            most = by > most ? by : most;
        }
        apart += most > 8;
    }
    snprintf(out + used, size - (size_t)used, ", %zu pixels differ", apart);
}

static const char STILL[] = "frame, one light", MOVED[] = "frame, one light, the camera moves";

/* Scenes of instances have a row of their own for frames that keep nothing. */
static bool wants_moved(bench *self, const char *scene)
{
    return strstr(scene, "instances") && bench_wants(self, scene, MOVED);
}

static void measure_frame(bench *self, const bench_scene *scene, int threads, bool still, bool moved)
{
    bench_frame *frame = bench_frame_create(self, scene, threads, 1);
    if (!frame) return;
    frame->api = self->peers ? bench_find_embree() : NULL;
    frame->peer_pixels = daft_alloc_zero(&self->allocator, (size_t)(BENCH_WIDTH * BENCH_HEIGHT), 4);
    if (frame->api && frame->peer_pixels) frame->embree = frame->api->create_scene(scene, threads);
    bench_subject subject = {.scene = scene->name,
                             .what = STILL,
                             .unit = "ms",
                             .isa = self->isa,
                             .threads = threads,
                             .ours = frame_ours,
                             .peer = frame->embree ? frame_peer : NULL,
                             .context = frame,
                             .peer_name = frame->api ? frame->api->name : "Embree",
                             .describe = frame_describe,
                             .budget = {.floor = strstr(scene->name, "instances") ? 1.5 : 2.5}};
    if (still) bench_measure(self, &subject);
    subject.what = MOVED, subject.ours = frame_moved;
    if (moved) bench_measure(self, &subject);
    if (frame->api) frame->api->destroy(frame->embree);
    bench_frame_destroy(frame);
}

/* ---- not called for ---- */

/* The same picture twice: `plain`, and `laden` with something that an effect is for and nobody sees, since it is behind
 * the camera. */
typedef struct unseen_job {
    bench_frame *plain, *laden;
} unseen_job;

static double unseen_ours(void *context)
{
    unseen_job *job = context;
    return bench_frame_ms(job->laden);
}

static double unseen_peer(void *context)
{
    unseen_job *job = context;
    return bench_frame_ms(job->plain);
}

/* Rays and bytes beyond the plain picture's, of all effects. */
static void unseen_describe(void *context, char *out, size_t size)
{
    unseen_job *job = context;
    const daft_counters *c = bench_frame_counters(job->laden), *plain = bench_frame_counters(job->plain);
    uint64_t rays = 0, bytes = 0;
    for (int e = 0; e < DAFT_EFFECT_COUNT; e++)
        rays += c->effects[e].rays - plain->effects[e].rays, bytes += c->effects[e].bytes - plain->effects[e].bytes;
    bool same =
        memcmp(bench_frame_pixels(job->plain), bench_frame_pixels(job->laden), (size_t)(4 * c->width * c->height)) == 0;
    snprintf(out, size, "%llu rays and %llu bytes more, %s picture", (unsigned long long)rays,
             (unsigned long long)bytes, same ? "the same" : "ANOTHER");
}

typedef enum unseen_kind {
    UNSEEN_MIRROR,
    UNSEEN_GLASS,
    UNSEEN_GLOSS,
    UNSEEN_TEXTURE,
    UNSEEN_BLEND,
    UNSEEN_LIGHT
} unseen_kind;
static const struct {
    const char *what, *scene; /* NULL: all of UNSEEN_SCENES */
} UNSEEN[] = {[UNSEEN_MIRROR] = {"frame, unseen mirror, no light", NULL},
              [UNSEEN_GLASS] = {"frame, unseen glass, no light", "cow, whole"},
              [UNSEEN_GLOSS] = {"frame, unseen rough mirror, no light", "cow, whole"},
              [UNSEEN_TEXTURE] = {"frame, unseen texture, no light", "cow, whole"},
              [UNSEEN_BLEND] = {"frame, unseen film, no light", "cow, whole"},
              [UNSEEN_LIGHT] = {"frame, a soft light out of reach", "cow, whole"}};
static const char *const UNSEEN_SCENES[] = {"cow, whole", "1,000 instances of the cow", "interior"};

static bool wants_unseen(bench *self, const char *scene, size_t kind)
{
    if (UNSEEN[kind].scene)
        return strcmp(scene, UNSEEN[kind].scene) == 0 && bench_wants(self, scene, UNSEEN[kind].what);
    for (size_t i = 0; i < DAFT_COUNT_OF(UNSEEN_SCENES); i++)
        if (strcmp(scene, UNSEEN_SCENES[i]) == 0) return bench_wants(self, scene, UNSEEN[kind].what);
    return false;
}

static bool wants_any_unseen(bench *self, const char *scene)
{
    for (size_t kind = 0; kind < DAFT_COUNT_OF(UNSEEN); kind++)
        if (wants_unseen(self, scene, kind)) return true;
    return false;
}

static bool add_unseen(bench_frame *frame, const bench_scene *scene, unseen_kind kind)
{
    const daft_dvec3 behind = daft_to_double(daft_sub(scene->view.from, daft_scale(scene->view.forward, 3)));
    daft_material_def material = daft_default_material_def();
    daft_light_def light = daft_default_light_def();
    daft_entity_def def = daft_default_entity_def();
    light.position = behind, light.range = 1, light.radius = 0.2f;
    if (kind == UNSEEN_LIGHT) return daft_light_create(frame->scene, &light, NULL).id;
    if (kind == UNSEEN_MIRROR || kind == UNSEEN_GLOSS) material.mirror = 0.9f;
    if (kind == UNSEEN_GLOSS) material.roughness = 0.4f;
    if (kind == UNSEEN_GLASS) material.transmission = 0.9f;
    if (kind == UNSEEN_BLEND) material.alpha_mode = DAFT_ALPHA_BLEND, material.opacity = 0.5f;
    if (kind == UNSEEN_TEXTURE)
        material.diffuse_map = daft_texture_load(frame->scene, DAFT_ROOT "/assets/textures/brick.png", NULL);
    def.shape = DAFT_SHAPE_SPHERE, def.radius = 1, def.position = behind;
    def.material = daft_material_create(frame->scene, &material, NULL);
    return def.material.id && daft_entity_create(frame->scene, &def, NULL).id;
}

/* The parts in which rows that compare two of our frames differ. */
typedef struct frame_pair {
    const char *what, *peer_name;
    void (*describe)(void *context, char *out, size_t size);
    bench_budget budget;
} frame_pair;

static void measure_pair(bench *self, const bench_scene *scene, int threads, unseen_job *job, const frame_pair *pair)
{
    bench_subject subject = {.scene = scene->name,
                             .what = pair->what,
                             .unit = "ms",
                             .isa = self->isa,
                             .threads = threads,
                             .ours = unseen_ours,
                             .peer = unseen_peer,
                             .context = job,
                             .peer_name = pair->peer_name,
                             .describe = pair->describe,
                             .budget = pair->budget,
                             .own_peer = true};
    bench_measure(self, &subject);
}

static void measure_unseen(bench *self, const bench_scene *scene, int threads, unseen_kind kind)
{
    const frame_pair pair = {UNSEEN[kind].what, "without it", unseen_describe, {.floor = 0.99}};
    unseen_job job = {bench_frame_create(self, scene, threads, 0), bench_frame_create(self, scene, threads, 0)};
    if (job.plain && job.laden && add_unseen(job.laden, scene, kind)) measure_pair(self, scene, threads, &job, &pair);
    bench_frame_destroy(job.plain);
    bench_frame_destroy(job.laden);
}

/* ---- a planar mirror on the ground ---- */

static const char MIRROR[] = "frame, mirror on the ground, no light";
static const char *const MIRROR_SCENES[] = {"cow, whole", "bunny, whole", "1,000 instances of the cow"};
enum { MIRROR_CELLS = 8 };

/* A square of cells · cells · 2 triangles. One of many waves by a part in 10,000, so that no plane of the engine's
 * holds them and its rays are cast. */
static bool add_mirror(bench_frame *frame, const bench_scene *scene, uint32_t cells)
{
    daft_vec3 at[(MIRROR_CELLS + 1) * (MIRROR_CELLS + 1)];
    uint32_t indices[6 * MIRROR_CELLS * MIRROR_CELLS], count = 0, side = cells + 1;
    float size = 2 * daft_length(scene->view.from);
    for (uint32_t i = 0; i < side * side; i++)
        at[i] = daft_v3(((float)(i % side) / (float)cells - 0.5f) * size,
                        cells > 1 && i % 2 ? 0.001f + 1e-4f * size : 0.001f,
                        ((float)(i / side) / (float)cells - 0.5f) * size);
    for (uint32_t i = 0; i < cells * cells; i++) {
        uint32_t a = i / cells * side + i % cells;
        const uint32_t corners[6] = {a, a + side, a + 1, a + 1, a + side, a + side + 1};
        for (int k = 0; k < 6; k++) indices[count++] = corners[k];
    }
    daft_mesh_def mesh = daft_default_mesh_def();
    mesh.positions = at, mesh.vertex_count = side * side, mesh.indices = indices, mesh.triangle_count = count / 3;
    daft_material_def material = daft_default_material_def();
    material.mirror = 0.8f;
    daft_entity_def def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_MESH, def.mesh = daft_mesh_create(frame->scene, &mesh, NULL);
    def.material = daft_material_create(frame->scene, &material, NULL);
    return def.mesh.id && def.material.id && daft_entity_create(frame->scene, &def, NULL).id;
}

static void mirror_describe(void *context, char *out, size_t size)
{
    unseen_job *job = context;
    const daft_counters *c = bench_frame_counters(job->laden), *other = bench_frame_counters(job->plain);
    const uint8_t *a = bench_frame_pixels(job->laden), *b = bench_frame_pixels(job->plain);
    size_t apart = 0, pixels = (size_t)(c->width * c->height);
    for (size_t i = 0; i < 4 * pixels; i += 4) apart += abs(a[i] - b[i]) > 8 || abs(a[i + 1] - b[i + 1]) > 8;
    snprintf(out, size, "%llu mirrored rays, reflection %.2f ms and %.2f one by one, %zu pixels differ",
             (unsigned long long)c->reflection_rays, c->effects[DAFT_EFFECT_REFLECTION].ms,
             other->effects[DAFT_EFFECT_REFLECTION].ms, apart);
}

static bool wants_mirror(bench *self, const char *scene)
{
    for (size_t i = 0; i < DAFT_COUNT_OF(MIRROR_SCENES); i++)
        if (strcmp(scene, MIRROR_SCENES[i]) == 0) return bench_wants(self, scene, MIRROR);
    return false;
}

/* A mirror of two triangles, whose rays form a pencil, against the same plane cut in many, whose rays are cast. */
static void measure_mirror(bench *self, const bench_scene *scene, int threads)
{
    const frame_pair pair = {.what = MIRROR, .peer_name = "rays one by one", .describe = mirror_describe};
    unseen_job job = {bench_frame_create(self, scene, threads, 0), bench_frame_create(self, scene, threads, 0)};
    if (job.plain && job.laden && add_mirror(job.laden, scene, 1) && add_mirror(job.plain, scene, MIRROR_CELLS))
        measure_pair(self, scene, threads, &job, &pair);
    bench_frame_destroy(job.plain);
    bench_frame_destroy(job.laden);
}

/* ---- all of them ---- */

void bench_frames(bench *self)
{
    int threads[2], count = bench_thread_counts(self, threads);
    for (size_t i = 0; i < bench_scene_count(); i++) {
        const char *name = bench_scene_name(i);
        bool still = bench_wants(self, name, STILL), moved = wants_moved(self, name),
             unseen = wants_any_unseen(self, name), mirror = wants_mirror(self, name);
        bench_scene scene;
        if (!(still || moved || unseen || mirror) || !bench_scene_make(self, i, &scene)) continue;
        for (int t = 0; t < count; t++) {
            if (still || moved) measure_frame(self, &scene, threads[t], still, moved);
            for (size_t kind = 0; unseen && kind < DAFT_COUNT_OF(UNSEEN); kind++)
                if (wants_unseen(self, name, kind)) measure_unseen(self, &scene, threads[t], (unseen_kind)kind);
            if (mirror) measure_mirror(self, &scene, threads[t]);
        }
        bench_scene_free(self, &scene);
    }
}
