/* What the tests of the ray kernels share: random numbers with a printed seed, meshes, instances, both visibility
 * paths. */
#ifndef DAFT_FIXTURES_H
#define DAFT_FIXTURES_H

#include "accel/bvh.h"
#include "geometry/mesh.h"
#include "math/simd/dispatch.h"
#include "math/trig.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static uint64_t fixture_state;

/* DAFT_SEED=n repeats a run. */
__attribute__((unused)) static void fixture_seed(uint64_t fallback)
{
    const char *text = getenv("DAFT_SEED");
    fixture_state = text ? strtoull(text, NULL, 0) : fallback;
    print_message("seed %llu\n", (unsigned long long)fixture_state);
}

__attribute__((unused)) static uint32_t random_bits(void)
{
    fixture_state = fixture_state * 6364136223846793005u + 1442695040888963407u;
    uint64_t x = fixture_state ^ fixture_state >> 31;
    return (uint32_t)((x * 0x9e3779b97f4a7c15u) >> 32);
}
__attribute__((unused)) static float random_float(float low, float high)
{
    return low + (high - low) * ((float)(random_bits() >> 8) * 0x1p-24f);
}
__attribute__((unused)) static daft_vec3 random_vec3(float low, float high)
{
    float x = random_float(low, high), y = random_float(low, high);
    return daft_v3(x, y, random_float(low, high));
}

typedef struct fixture_mesh {
    daft_trimesh mesh;
    daft_bvh *bvh;
} fixture_mesh;

static const uint32_t FIXTURE_MATERIAL[1] = {0};

__attribute__((unused)) static fixture_mesh mesh_make(const daft_vec3 *positions, uint32_t vertices,
                                                      const uint32_t *indices, uint32_t triangles)
{
    daft_allocator allocator = daft_malloc_allocator();
    daft_mesh_def def = {.cookie = DAFT_COOKIE,
                         .positions = positions,
                         .vertex_count = vertices,
                         .indices = indices,
                         .triangle_count = triangles};
    fixture_mesh out;
    daft_error error = {0};
    if (!daft_trimesh_from_arrays(&allocator, &def, NULL, &out.mesh, &error)) fail_msg("%s", error.message);
    out.bvh = daft_bvh_build_mesh(&allocator, &out.mesh, 1, &error);
    assert_non_null(out.bvh);
    return out;
}

__attribute__((unused)) static void mesh_drop(fixture_mesh *m)
{
    daft_allocator allocator = daft_malloc_allocator();
    daft_bvh_free(m->bvh);
    daft_trimesh_free(&allocator, &m->mesh);
}

/* Triangles with corners within `spread` of random centres within `size`. */
__attribute__((unused)) static fixture_mesh mesh_soup(uint32_t triangles, float size, float spread)
{
    daft_vec3 *p = malloc(3 * triangles * sizeof *p);
    uint32_t *index = malloc(3 * triangles * sizeof *index);
    for (uint32_t i = 0; i < triangles; i++) {
        daft_vec3 centre = random_vec3(-size, size);
        for (uint32_t k = 0; k < 3; k++) {
            p[3 * i + k] = daft_add(centre, random_vec3(-spread, spread));
            index[3 * i + k] = 3 * i + k;
        }
    }
    fixture_mesh out = mesh_make(p, 3 * triangles, index, triangles);
    free(p);
    free(index);
    return out;
}

/* A closed, bumpy ball: `rings` by 2·rings vertices around two poles. bump 0 is round. */
__attribute__((unused)) static fixture_mesh mesh_ball(uint32_t rings, float radius, float bump)
{
    uint32_t columns = 2 * rings, vertices = rings * columns + 2, triangles = 0;
    daft_vec3 *p = malloc(vertices * sizeof *p);
    uint32_t *index = malloc(6 * columns * rings * sizeof *index + 6 * columns * sizeof *index);
    for (uint32_t i = 0; i < rings; i++) {
        double latitude = DAFT_PI * ((i + 1.0) / (rings + 1.0) - 0.5);
        for (uint32_t j = 0; j < columns; j++) {
            double longitude = 2 * DAFT_PI * j / columns;
            float r = radius * (1 + bump * random_float(-1, 1));
            p[i * columns + j] =
                daft_v3(r * (float)(daft_cos(latitude) * daft_cos(longitude)), r * (float)daft_sin(latitude),
                        r * (float)(daft_cos(latitude) * daft_sin(longitude)));
        }
    }
    uint32_t south = vertices - 2, north = vertices - 1;
    p[south] = daft_v3(0, -radius, 0), p[north] = daft_v3(0, radius, 0);
    for (uint32_t j = 0; j < columns; j++) {
        uint32_t k = (j + 1) % columns, last = (rings - 1) * columns;
        const uint32_t caps[6] = {south, j, k, north, last + k, last + j};
        memcpy(index + 3 * triangles, caps, sizeof caps);
        triangles += 2;
        for (uint32_t i = 0; i + 1 < rings; i++) {
            uint32_t a = i * columns + j, b = i * columns + k, c = a + columns, d = b + columns;
            const uint32_t quad[6] = {a, c, b, b, c, d};
            memcpy(index + 3 * triangles, quad, sizeof quad);
            triangles += 2;
        }
    }
    fixture_mesh out = mesh_make(p, vertices, index, triangles);
    free(p);
    free(index);
    return out;
}

/* to_object is the inverse of to_frame, computed in double. */
__attribute__((unused)) static void affine_invert(const daft_affine *a, daft_affine *out)
{
    double m[9], inverse[9];
    for (int i = 0; i < 9; i++) m[i] = (double)a->m[i];
    double det =
        m[0] * (m[4] * m[8] - m[5] * m[7]) - m[1] * (m[3] * m[8] - m[5] * m[6]) + m[2] * (m[3] * m[7] - m[4] * m[6]);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            int a1 = (j + 1) % 3, a2 = (j + 2) % 3, b1 = (i + 1) % 3, b2 = (i + 2) % 3;
            inverse[3 * i + j] = (m[3 * a1 + b1] * m[3 * a2 + b2] - m[3 * a1 + b2] * m[3 * a2 + b1]) / det;
        }
    for (int i = 0; i < 3; i++) {
        double t = 0;
        for (int j = 0; j < 3; j++) {
            out->m[3 * i + j] = (float)inverse[3 * i + j];
            t -= inverse[3 * i + j] * (double)a->t[j];
        }
        out->t[i] = (float)t;
    }
}

__attribute__((unused)) static daft_affine affine_make(daft_quat rotation, daft_vec3 scale, daft_vec3 position)
{
    double r[9];
    daft_affine out;
    daft_quat_matrix(daft_quat_normalize(rotation), r);
    const float s[3] = {scale.x, scale.y, scale.z};
    for (int i = 0; i < 9; i++) out.m[i] = (float)(r[i] * (double)s[i % 3]);
    out.t[0] = position.x, out.t[1] = position.y, out.t[2] = position.z;
    return out;
}

__attribute__((unused)) static daft_instance instance_make(const fixture_mesh *mesh, daft_affine to_frame)
{
    daft_instance out = {.to_frame = to_frame, .materials = FIXTURE_MATERIAL, .flags = DAFT_INSTANCE_CASTS_SHADOW};
    if (mesh) out.mesh = &mesh->mesh, out.bvh = mesh->bvh;
    affine_invert(&to_frame, &out.to_object);
    daft_instance_bound(&out);
    return out;
}

__attribute__((unused)) static daft_instance sphere_make(daft_vec3 centre, float radius)
{
    daft_instance out = instance_make(NULL, affine_make(daft_quat_identity(), daft_v3(1, 1, 1), centre));
    out.radius = radius;
    daft_instance_bound(&out);
    return out;
}

__attribute__((unused)) static daft_quat random_rotation(void)
{
    float x = random_float(-1, 1), y = random_float(-1, 1), z = random_float(-1, 1);
    return daft_quat_normalize((daft_quat){x, y, z, random_float(-1, 1)});
}

#endif
