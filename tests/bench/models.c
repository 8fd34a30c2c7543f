/* The meshes of the benchmarks: real ones from a folder beside the checkout, where it is there, and two made up here. */
#include "bench.h"

#include "math/real.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const bench_model BENCH_MODELS[] = {
    {"sphere 130k", NULL},        {"terrain 180k", NULL},           {"cow", "cow.obj"},
    {"bunny", "stanford-bunny.obj"}, {"nefertiti", "nefertiti.obj"},
};
const size_t BENCH_MODEL_COUNT = DAFT_COUNT_OF(BENCH_MODELS);

bool bench_model_path(const bench_model *model, char *out, size_t size)
{
    const char *data = getenv("DAFT_DATA");
    snprintf(out, size, "%s/models/%s", data && data[0] ? data : DAFT_ROOT "/../shared/data", model->file);
    return daft_file_exists(out);
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

/* A grid of columns by rows cells, two triangles each, counter-clockwise seen from above (from outside). */
static bool make_grid(bench *self, uint32_t columns, uint32_t rows, daft_vec3 (*point)(double u, double v),
                      daft_trimesh *out)
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

static bool load_file(bench *self, const bench_model *model, daft_trimesh *out)
{
    char path[1024], text[1200];
    if (!bench_model_path(model, path, sizeof path)) {
        bench_note(self, false, "%s left out: there is no %s", model->name, path);
        return false;
    }
    daft_obj obj;
    daft_error error;
    daft_log log = {0};
    if (!daft_obj_load(&self->allocator, path, &log, &obj, &error)) {
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
    bool loaded = model->file               ? load_file(self, model, out)
                  : model->name[0] == 't' ? make_grid(self, 300, 300, terrain_point, out)
                                            : make_grid(self, 360, 180, sphere_point, out);
    if (loaded) normalise(out);
    return loaded;
}

daft_vec3 *bench_positions(bench *self, const daft_trimesh *mesh)
{
    daft_vec3 *positions = daft_alloc(&self->allocator, mesh->vertex_count, sizeof *positions);
    for (uint32_t i = 0; positions && i < mesh->vertex_count; i++)
        positions[i] = daft_v3(mesh->x[i], mesh->y[i], mesh->z[i]);
    return positions;
}
