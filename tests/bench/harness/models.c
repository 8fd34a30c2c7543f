/* The meshes of the benchmarks: real ones from a folder beside the checkout, and generated ones, which also stand in
 * for what is missing there. */
#include "bench.h"

#include "math/simd/dispatch.h"
#include "math/trig.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const bench_model BENCH_MODELS[] = {
    {"sphere 130k", NULL, 0},
    {"terrain 180k", NULL, 0},
    {"cow", "cow.obj", 5804},
    {"bunny", "stanford-bunny.obj", 69451},
    {"nefertiti", "nefertiti.obj", 99938},
};
const size_t BENCH_MODEL_COUNT = DAFT_COUNT_OF(BENCH_MODELS);

const bench_model *bench_model_named(const char *name)
{
    for (size_t i = 0; i < BENCH_MODEL_COUNT; i++)
        if (strcmp(BENCH_MODELS[i].name, name) == 0) return &BENCH_MODELS[i];
    return NULL;
}

bool bench_model_path(const bench_model *model, char *out, size_t size)
{
    out[0] = 0;
    if (!model->file) return false;
    const char *data = getenv("DAFT_DATA");
    snprintf(out, size, "%s/models/%s", data && data[0] ? data : DAFT_ROOT "/../shared/data", model->file);
    return daft_file_exists(NULL, out);
}

void bench_label(const char *scene, char *out, size_t size)
{
    char path[1024];
    for (size_t i = 0; i < BENCH_MODEL_COUNT; i++) {
        const bench_model *model = &BENCH_MODELS[i];
        size_t length = strlen(model->name);
        const char *at = strstr(scene, model->name);
        if (!at || !model->file || bench_model_path(model, path, sizeof path)) continue;
        int head = (int)(at - scene) + (int)length;
        snprintf(out, size, "%.*s stand-in%s", head, scene, at + length);
        return;
    }
    snprintf(out, size, "%s", scene);
}

/* A point of a grid over (0..1, 0..1): bumpy ground of 1 m by 1 m. */
static daft_vec3 terrain_point(double u, double v)
{
    double height = 0, amplitude = 0.05, frequency = 7;
    for (int octave = 0; octave < 5; octave++) {
        height += amplitude * daft_sin(frequency * u + 1.3 * octave) * daft_cos(frequency * v - 0.7 * octave);
        amplitude *= 0.5, frequency *= 2.1;
    }
    return daft_v3((float)(u - 0.5), (float)height, (float)(v - 0.5));
}

static daft_vec3 sphere_point(double u, double v)
{
    double yaw = -2 * DAFT_PI * u, polar = DAFT_PI * v;
    return daft_v3((float)(0.5 * daft_sin(polar) * daft_cos(yaw)), (float)(-0.5 * daft_cos(polar)),
                   (float)(0.5 * daft_sin(polar) * daft_sin(yaw)));
}

bool bench_grid(bench *self, uint32_t columns, uint32_t rows, bench_surface *point, daft_trimesh *out)
{
    daft_vec3 *positions = daft_alloc(&self->allocator, (size_t)(columns + 1) * (rows + 1), sizeof *positions);
    uint32_t *indices = daft_alloc(&self->allocator, (size_t)columns * rows * 6, sizeof *indices);
    bool made = positions && indices;
    size_t used = 0;
    for (uint32_t r = 0; made && r <= rows; r++)
        for (uint32_t c = 0; c <= columns; c++)
            positions[r * (columns + 1) + c] = point((double)c / columns, (double)r / rows);
    for (uint32_t r = 0; made && r < rows; r++) {
        for (uint32_t c = 0; c < columns; c++) {
            uint32_t a = r * (columns + 1) + c, b = a + columns + 1;
            const uint32_t corners[6] = {a, b, b + 1, a, b + 1, a + 1};
            memcpy(indices + used, corners, sizeof corners);
            used += 6;
        }
    }
    daft_mesh_def def = daft_default_mesh_def();
    def.positions = positions, def.vertex_count = (columns + 1) * (rows + 1);
    def.indices = indices, def.triangle_count = columns * rows * 2;
    daft_log log = {0};
    made = made && daft_trimesh_from_arrays(&self->allocator, &def, &log, out, NULL);
    daft_release(&self->allocator, positions);
    daft_release(&self->allocator, indices);
    return made;
}

/* A statue, roughly: a ball with bumps of several sizes, longer than wide. */
static daft_vec3 statue_point(double u, double v)
{
    double yaw = -2 * DAFT_PI * u, polar = DAFT_PI * v, bumps = 0, amplitude = 0.08;
    for (int octave = 0, waves = 3; octave < 4; octave++, waves = 2 * waves + 1, amplitude *= 0.5)
        bumps += amplitude * daft_sin(waves * yaw + octave) * daft_sin(waves * polar);
    double radius = 0.35 * (1 + bumps * daft_sin(polar));
    return daft_v3((float)(radius * daft_sin(polar) * daft_cos(yaw)),
                   (float)(-0.5 * daft_cos(polar) * (1 + bumps * daft_sin(polar))),
                   (float)(radius * daft_sin(polar) * daft_sin(yaw)));
}

static bool load_file(bench *self, const bench_model *model, daft_trimesh *out)
{
    char path[1024], text[1200];
    if (!bench_model_path(model, path, sizeof path)) {
        uint32_t rows = (uint32_t)(sqrt(model->triangles / 4.0) + 0.5);
        bench_note(self, false, "there is no %s: a generated mesh of %u triangles stands in for the %s", path,
                   4 * rows * rows, model->name);
        return bench_grid(self, 2 * rows, rows, statue_point, out);
    }
    daft_obj obj;
    daft_error error;
    daft_log log = {0};
    if (!daft_obj_load(&self->allocator, NULL, path, &log, &obj, &error)) {
        bench_note(self, true, "%s", daft_error_text(&error, text, sizeof text));
        return false;
    }
    *out = obj.mesh;
    obj.mesh = (daft_trimesh){0};
    daft_obj_free(&self->allocator, &obj);
    return true;
}

static void normalise(daft_trimesh *mesh)
{
    daft_vec3 size = daft_sub(mesh->high, mesh->low);
    float scale = 1 / fmaxf(size.x, fmaxf(size.y, size.z));
    daft_vec3 foot = daft_v3((mesh->low.x + mesh->high.x) / 2, mesh->low.y, (mesh->low.z + mesh->high.z) / 2);
    mesh->low = daft_v3(INFINITY, INFINITY, INFINITY);
    mesh->high = daft_neg(mesh->low);
    for (uint32_t i = 0; i < mesh->vertex_count; i++) {
        daft_vec3 p = daft_scale(daft_sub(daft_v3(mesh->x[i], mesh->y[i], mesh->z[i]), foot), scale);
        mesh->x[i] = p.x, mesh->y[i] = p.y, mesh->z[i] = p.z;
        mesh->low = daft_min3(mesh->low, p);
        mesh->high = daft_max3(mesh->high, p);
    }
}

bool bench_model_load(bench *self, const bench_model *model, daft_trimesh *out)
{
    bool loaded = model->file             ? load_file(self, model, out)
                  : model->name[0] == 't' ? bench_grid(self, 300, 300, terrain_point, out)
                                          : bench_grid(self, 360, 180, sphere_point, out);
    if (loaded) normalise(out);
    return loaded;
}

daft_bvh *bench_tree(bench *self, const daft_trimesh *mesh)
{
    const daft_bvh_def def = {.threads = daft_processor_count(), .isa = daft_isa_best()};
    return daft_bvh_build(&self->allocator, mesh, &def, NULL);
}

daft_vec3 *bench_positions(bench *self, const daft_trimesh *mesh)
{
    daft_vec3 *positions = daft_alloc(&self->allocator, mesh->vertex_count, sizeof *positions);
    for (uint32_t i = 0; positions && i < mesh->vertex_count; i++)
        positions[i] = daft_v3(mesh->x[i], mesh->y[i], mesh->z[i]);
    return positions;
}
