/* Any bytes as an OBJ file: what loads is a mesh that keeps the promises of geometry/mesh.h. */
#include "fuzz.h"

#include "geometry/mesh.h"

#include <math.h>
#include <string.h>

static void check_corners(const daft_trimesh *mesh)
{
    for (uint32_t i = 0; i < mesh->triangle_count; i++) {
        const uint32_t *corner = mesh->indices + 3 * i;
        for (int k = 0; k < 3; k++) {
            size_t at = 3 * (size_t)i + (size_t)k;
            FUZZ_CHECK(corner[k] < mesh->vertex_count);
            FUZZ_CHECK(corner[k] != corner[(k + 1) % 3]);
            FUZZ_CHECK((mesh->normal_indices ? mesh->normal_indices : mesh->indices)[at] < mesh->normal_count);
            if (mesh->uv_count == 0) continue;
            uint32_t uv = (mesh->uv_indices ? mesh->uv_indices : mesh->indices)[at];
            FUZZ_CHECK(uv < mesh->uv_count || (mesh->uv_indices && uv == DAFT_NO_UV));
        }
        if (mesh->slots) FUZZ_CHECK(mesh->slots[i] < mesh->slot_count);
    }
}

static void check_mesh(const daft_trimesh *mesh)
{
    for (uint32_t i = 0; i < mesh->vertex_count; i++)
        FUZZ_CHECK(isfinite(mesh->x[i]) && isfinite(mesh->y[i]) && isfinite(mesh->z[i]));
    for (uint32_t i = 0; i < mesh->normal_count; i++)
        FUZZ_CHECK(fabsf(daft_dot(mesh->normals[i], mesh->normals[i]) - 1) < 1e-4f);
    for (uint32_t i = 0; i < mesh->uv_count; i++) FUZZ_CHECK(isfinite(mesh->uvs[i].x) && isfinite(mesh->uvs[i].y));
    check_corners(mesh);
    FUZZ_CHECK(mesh->triangle_count == 0 ||
               (mesh->low.x <= mesh->high.x && mesh->low.y <= mesh->high.y && mesh->low.z <= mesh->high.z));
}

int obj_input(const uint8_t *data, size_t size)
{
    daft_allocator allocator = daft_malloc_allocator();
    char path[512], *text = malloc(size + 1); /* its own block, so that reading past the end is seen */
    snprintf(path, sizeof path, "%s/input.obj", fuzz_folder());
    if (size > 0) memcpy(text, data, size);
    text[size] = 0;
    daft_obj obj = {0};
    daft_error error = {0};
    bool good = daft_obj_parse(&allocator, NULL, path, text, size, NULL, &obj, &error);
    fuzz_check_error(good, &error);
    if (good) check_mesh(&obj.mesh);
    if (good) FUZZ_CHECK(obj.slots.count == obj.mesh.slot_count && obj.slots.count > 0);
    daft_obj_free(&allocator, &obj);
    free(text);
    return 0;
}
