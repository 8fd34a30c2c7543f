/* The scenes of the yardsticks: meshes of 1 m on a ground plane, close up (the mesh fills the picture), whole (from 2.2
 * m) and far (100 pixels tall); cows and spheres strewn about with random rotations; a room around the camera. */
#include "scenes.h"

#include "math/trig.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double FIELD_OF_VIEW = 1.0471975511965976; /* 60 degrees across */
static const daft_vec3 GROUND[4] = {{-BENCH_GROUND, 0, -BENCH_GROUND},
                                    {-BENCH_GROUND, 0, BENCH_GROUND},
                                    {BENCH_GROUND, 0, BENCH_GROUND},
                                    {BENCH_GROUND, 0, -BENCH_GROUND}};
static const uint32_t GROUND_INDICES[6] = {0, 1, 2, 0, 2, 3};

typedef enum scene_kind { CLOSE_UP, WHOLE, FAR, COWS, SPHERES, INTERIOR } scene_kind;

typedef struct scene_entry {
    const char *name, *model; /* model: of those that show one, or many */
    scene_kind kind;
    uint32_t count;
} scene_entry;

static const scene_entry SCENES[] = {
    {"terrain 180k, close up", "terrain 180k", CLOSE_UP, 1},
    {"terrain 180k, whole", "terrain 180k", WHOLE, 1},
    {"terrain 180k, far", "terrain 180k", FAR, 1},
    {"cow, close up", "cow", CLOSE_UP, 1},
    {"cow, whole", "cow", WHOLE, 1},
    {"cow, far", "cow", FAR, 1},
    {"bunny, close up", "bunny", CLOSE_UP, 1},
    {"bunny, whole", "bunny", WHOLE, 1},
    {"bunny, far", "bunny", FAR, 1},
    {"nefertiti, close up", "nefertiti", CLOSE_UP, 1},
    {"nefertiti, whole", "nefertiti", WHOLE, 1},
    {"nefertiti, far", "nefertiti", FAR, 1},
    {"1,000 instances of the cow", "cow", COWS, 1000},
    {"100,000 instances of the cow", "cow", COWS, 100000},
    {"10,000 spheres", NULL, SPHERES, 10000},
    {"interior", NULL, INTERIOR, 1},
};

size_t bench_scene_count(void) { return DAFT_COUNT_OF(SCENES); }
const char *bench_scene_name(size_t index) { return SCENES[index].name; }

/* ---- views ---- */

void bench_look(bench_view *view, daft_vec3 from, daft_vec3 at)
{
    view->from = from, view->at = at;
    view->forward = daft_normalize(daft_sub(at, from));
    view->right = daft_normalize(daft_cross(view->forward, daft_v3(0, 1, 0)));
    view->up = daft_cross(view->right, view->forward);
    bench_view_size(view, BENCH_WIDTH, BENCH_HEIGHT);
}

void bench_view_size(bench_view *view, int width, int height)
{
    view->width = width, view->height = height;
    view->fov = (float)FIELD_OF_VIEW;
    view->focal = (float)(width / 2.0 / daft_tan(FIELD_OF_VIEW / 2));
}

/* From in front, to the side and above. */
static void look_at_model(bench_scene *scene, scene_kind kind)
{
    const daft_trimesh *mesh = &scene->mesh[0];
    daft_vec3 at = daft_scale(daft_add(mesh->low, mesh->high), 0.5f);
    double focal = BENCH_WIDTH / 2.0 / daft_tan(FIELD_OF_VIEW / 2), tall = (double)(mesh->high.y - mesh->low.y);
    float metres = kind == CLOSE_UP ? 0.7f : kind == WHOLE ? 2.2f : (float)(focal * tall / 100);
    bench_look(&scene->view, daft_add(at, daft_scale(daft_normalize(daft_v3(0.45f, 0.3f, 0.84f)), metres)), at);
    scene->light = daft_v3(-1.5f, 2, 1.5f);
}

/* ---- instances ---- */

static float random_between(uint64_t *state, float low, float high) { return low + (high - low) * bench_random(state); }

/* Uniform over all rotations: Shoemake, "Uniform Random Rotations" (Graphics Gems III, 1992). */
static daft_quat random_rotation(uint64_t *state)
{
    double u = (double)bench_random(state), v = 2 * DAFT_PI * (double)bench_random(state),
           w = 2 * DAFT_PI * (double)bench_random(state);
    double a = sqrt(1 - u), b = sqrt(u);
    return (daft_quat){(float)(a * daft_sin(v)), (float)(a * daft_cos(v)), (float)(b * daft_sin(w)),
                       (float)(b * daft_cos(w))};
}

bool bench_add_meshes(bench *self, bench_scene *scene, uint32_t count)
{
    scene->instances = daft_alloc(&self->allocator, count, sizeof *scene->instances);
    if (!scene->instances) return false;
    scene->instance_count = count;
    for (uint32_t i = 0; i < count; i++)
        scene->instances[i] = (bench_instance){.mesh = (int)i, .rotation = daft_quat_identity(), .scale = 1};
    return true;
}

/* Instances strewn over a block that stands on the ground, seen from one of its sides: item 0 is the ground. */
static bool strew(bench *self, bench_scene *scene, uint32_t count, bool spheres)
{
    if (!bench_add_meshes(self, scene, count + 1)) return false;
    double edge = cbrt((double)count / (spheres ? 40 : 0.4)); /* so many a cubic metre */
    float half = (float)(edge * 0.8), high = (float)(edge * 0.625);
    uint64_t state = 20261121;
    scene->instances[0].mesh = 1;
    for (uint32_t i = 1; i <= count; i++) {
        bench_instance *item = &scene->instances[i];
        item->mesh = spheres ? BENCH_SPHERE : 0;
        item->rotation = random_rotation(&state);
        item->scale = spheres ? random_between(&state, 0.02f, 0.12f) : 1;
        float x = random_between(&state, -half, half), y = random_between(&state, 0.7f, high);
        item->position = daft_v3(x, y, random_between(&state, -half, half));
    }
    bench_look(&scene->view, daft_v3(0.1f * half, high * 1.1f, 1.9f * half), daft_v3(0, 0.4f * high, 0));
    scene->light = daft_v3(-half, 3 * high, 1.5f * half);
    return true;
}

/* ---- the room ---- */

/* A box with round edges, 12 by 4 by 8 m, bumpy, seen from within. */
static daft_vec3 room_point(double u, double v)
{
    double yaw = 2 * DAFT_PI * u, polar = DAFT_PI * v;
    double d[3] = {daft_sin(polar) * daft_cos(yaw), -daft_cos(polar), daft_sin(polar) * daft_sin(yaw)}, sum = 0;
    for (int k = 0; k < 3; k++) sum += daft_pow(fabs(d[k]), 8);
    double radius = daft_pow(sum, -0.125);
    radius *= 1 + 0.01 * daft_sin(61 * yaw) * daft_sin(47 * polar) * daft_sin(polar);
    return daft_v3((float)(6 * radius * d[0]), (float)(2 * radius * d[1] + 2), (float)(4 * radius * d[2]));
}

static daft_vec3 column_point(double u, double v)
{
    double yaw = -2 * DAFT_PI * u, radius = 0.22 + 0.02 * daft_cos(16 * yaw) + 0.08 * (2 * v - 1) * (2 * v - 1);
    return daft_v3((float)(radius * daft_cos(yaw)), (float)(4 * v), (float)(radius * daft_sin(yaw)));
}

typedef struct soup {
    daft_vec3 *positions;
    uint32_t *indices;
    uint32_t vertices, triangles;
} soup;

static void soup_add(soup *to, const daft_trimesh *mesh, daft_vec3 at)
{
    for (uint32_t i = 0; i < 3 * mesh->triangle_count; i++)
        to->indices[3 * to->triangles + i] = to->vertices + mesh->indices[i];
    for (uint32_t i = 0; i < mesh->vertex_count; i++)
        to->positions[to->vertices + i] = daft_add(at, daft_v3(mesh->x[i], mesh->y[i], mesh->z[i]));
    to->vertices += mesh->vertex_count;
    to->triangles += mesh->triangle_count;
}

enum { COLUMNS = 10 };

/* The room and its columns as one mesh: nobody has to go through instances for it. */
static bool join_room(bench *self, const daft_trimesh *room, const daft_trimesh *column, daft_trimesh *out)
{
    size_t vertices = room->vertex_count + COLUMNS * (size_t)column->vertex_count;
    size_t triangles = room->triangle_count + COLUMNS * (size_t)column->triangle_count;
    soup all = {.positions = daft_alloc(&self->allocator, vertices, sizeof(daft_vec3)),
                .indices = daft_alloc(&self->allocator, triangles, 3 * sizeof(uint32_t))};
    bool made = all.positions && all.indices;
    if (made) soup_add(&all, room, daft_v3(0, 0, 0));
    for (int i = 0; made && i < COLUMNS; i++)
        soup_add(&all, column, daft_v3(-4 + 2 * (float)(i / 2), 0, i % 2 ? 2.2f : -2.2f));
    daft_mesh_def def = daft_default_mesh_def();
    def.positions = all.positions, def.vertex_count = all.vertices;
    def.indices = all.indices, def.triangle_count = all.triangles;
    daft_log log = {0};
    made = made && daft_trimesh_from_arrays(&self->allocator, &def, &log, out, NULL);
    daft_release(&self->allocator, all.positions);
    daft_release(&self->allocator, all.indices);
    return made;
}

static bool make_room(bench *self, bench_scene *scene)
{
    daft_trimesh room = {0}, column = {0};
    bool made = bench_grid(self, 400, 200, room_point, &room) && bench_grid(self, 64, 48, column_point, &column) &&
                join_room(self, &room, &column, &scene->mesh[0]);
    daft_trimesh_free(&self->allocator, &room);
    daft_trimesh_free(&self->allocator, &column);
    scene->mesh_count = made;
    bench_look(&scene->view, daft_v3(-4.6f, 1.7f, 0.6f), daft_v3(3, 1.5f, -0.6f));
    scene->light = daft_v3(1, 3.4f, 0.3f);
    return made && bench_add_meshes(self, scene, 1);
}

/* ---- making and freeing ---- */

static bool make_ground(bench *self, daft_trimesh *out)
{
    daft_mesh_def def = daft_default_mesh_def();
    daft_log log = {0};
    def.positions = GROUND, def.vertex_count = 4;
    def.indices = GROUND_INDICES, def.triangle_count = 2;
    return daft_trimesh_from_arrays(&self->allocator, &def, &log, out, NULL);
}

static bool make_kind(bench *self, const scene_entry *entry, bench_scene *out)
{
    if (entry->kind == INTERIOR) return make_room(self, out);
    bool made = entry->model ? bench_model_load(self, bench_model_named(entry->model), &out->mesh[0])
                             : make_ground(self, &out->mesh[0]); /* spheres have no use for it, but a mesh 0 there is */
    if (made) out->mesh_count = 1, made = make_ground(self, &out->mesh[1]);
    if (made) out->mesh_count = 2;
    if (made && entry->kind >= COWS) return strew(self, out, entry->count, entry->kind == SPHERES);
    if (made) look_at_model(out, entry->kind);
    return made && bench_add_meshes(self, out, 2);
}

bool bench_scene_build(bench *self, bench_scene *scene)
{
    for (int i = 0; i < scene->mesh_count; i++) {
        scene->bvh[i] = bench_tree(self, &scene->mesh[i]);
        if (!scene->bvh[i]) return false;
    }
    return true;
}

bool bench_scene_make(bench *self, size_t index, bench_scene *out)
{
    *out = (bench_scene){.name = SCENES[index].name, .single = SCENES[index].count == 1};
    if (make_kind(self, &SCENES[index], out) && bench_scene_build(self, out)) return true;
    bench_note(self, true, "%s cannot be made", SCENES[index].name);
    bench_scene_free(self, out);
    return false;
}

bool bench_scene_named(bench *self, const char *name, bench_scene *out)
{
    for (size_t i = 0; i < DAFT_COUNT_OF(SCENES); i++)
        if (strcmp(SCENES[i].name, name) == 0) return bench_scene_make(self, i, out);
    bench_note(self, true, "there is no scene %s", name);
    return false;
}

bool bench_scene_cows(bench *self, uint32_t count, bench_scene *out)
{
    const scene_entry entry = {"cows", "cow", COWS, count};
    *out = (bench_scene){.name = entry.name};
    if (make_kind(self, &entry, out)) return true;
    bench_note(self, true, "%u cows cannot be made", count);
    bench_scene_free(self, out);
    return false;
}

void bench_scene_free(bench *self, bench_scene *scene)
{
    for (int i = 0; i < scene->mesh_count; i++) {
        if (scene->bvh[i]) daft_bvh_free(scene->bvh[i]);
        daft_trimesh_free(&self->allocator, &scene->mesh[i]);
    }
    daft_release(&self->allocator, scene->instances);
    *scene = (bench_scene){0};
}

/* The inverse of turn, scale and move. */
static void invert(const daft_affine *a, float scale, daft_affine *out)
{
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) out->m[3 * i + k] = a->m[3 * k + i] / (scale * scale);
    for (int i = 0; i < 3; i++)
        out->t[i] = -(out->m[3 * i] * a->t[0] + out->m[3 * i + 1] * a->t[1] + out->m[3 * i + 2] * a->t[2]);
}

daft_affine bench_instance_map(const bench_instance *item)
{
    double r[9];
    daft_affine map;
    daft_quat_matrix(item->rotation, r);
    for (int i = 0; i < 9; i++) map.m[i] = (float)(r[i] * (double)item->scale);
    map.t[0] = item->position.x, map.t[1] = item->position.y, map.t[2] = item->position.z;
    return map;
}

daft_instance bench_engine_instance(const bench_scene *scene, uint32_t index)
{
    static const uint32_t material = 0;
    const bench_instance *item = &scene->instances[index];
    daft_instance instance = {.materials = &material, .entity = index, .flags = DAFT_INSTANCE_CASTS_SHADOW};
    bench_instance moved = *item;
    moved.position = daft_sub(item->position, scene->view.from);
    if (item->mesh == BENCH_SPHERE)
        instance.radius = item->scale, moved.scale = 1;
    else
        instance.mesh = &scene->mesh[item->mesh], instance.bvh = scene->bvh[item->mesh];
    instance.to_frame = bench_instance_map(&moved);
    invert(&instance.to_frame, moved.scale, &instance.to_object);
    daft_instance_bound(&instance);
    return instance;
}
