/* OBJ texts and files, parsed with a counted allocator, and what mesh.h promises of every mesh. */
#ifndef TESTS_OBJ_FIXTURE_H
#define TESTS_OBJ_FIXTURE_H

#include "geometry/mesh.h"
#include "support_content.h"

static counting memory;
static memo warnings;

static inline bool parse_bytes(const char *text, size_t size, daft_obj *obj, daft_error *error)
{
    daft_allocator allocator = counting_allocator(&memory);
    daft_log log = memo_log(&warnings);
    return daft_obj_parse(&allocator, NULL, "a.obj", text, size, &log, obj, error);
}

static inline void free_obj(daft_obj *obj)
{
    daft_allocator allocator = {.user = &memory, .allocate = counting_allocate, .release = counting_release};
    daft_obj_free(&allocator, obj);
    assert_int_equal(memory.live, 0);
}

static inline daft_obj parse(const char *text)
{
    daft_obj obj;
    daft_error error;
    char shown[1100];
    if (!parse_bytes(text, strlen(text), &obj, &error)) fail_msg("%s", daft_error_text(&error, shown, sizeof shown));
    return obj;
}

/* The text must fail to load with this message, and leave nothing behind. */
static inline void refuse(const char *text, const char *message)
{
    daft_obj obj;
    daft_error error;
    char shown[1100];
    if (parse_bytes(text, strlen(text), &obj, &error)) fail_msg("accepted: %s", text);
    assert_int_equal(memory.live, 0);
    assert_int_equal(error.code, DAFT_ERROR_SYNTAX);
    assert_contains(daft_error_text(&error, shown, sizeof shown), message);
}

static inline daft_dvec3 corner(const daft_trimesh *mesh, uint32_t triangle, uint32_t k)
{
    uint32_t v = mesh->indices[3 * triangle + k];
    return daft_dv3((double)mesh->x[v], (double)mesh->y[v], (double)mesh->z[v]);
}

static inline daft_dvec3 vector_area(const daft_trimesh *mesh, uint32_t triangle)
{
    daft_dvec3 a = corner(mesh, triangle, 0);
    daft_dvec3 ab = daft_dsub(corner(mesh, triangle, 1), a), ac = daft_dsub(corner(mesh, triangle, 2), a);
    return daft_dscale(daft_dcross(ab, ac), 0.5);
}

/* Plain area of triangles first .. first+count-1. */
static inline double area(const daft_trimesh *mesh, uint32_t first, uint32_t count)
{
    double sum = 0;
    for (uint32_t i = first; i < first + count; i++) {
        daft_dvec3 v = vector_area(mesh, i);
        sum += sqrt(daft_ddot(v, v));
    }
    return sum;
}

/* What mesh.h promises of every mesh. */
static inline void check_mesh(const daft_obj *obj)
{
    const daft_trimesh *m = &obj->mesh;
    for (uint32_t i = 0; i < m->vertex_count; i++)
        assert_true(isfinite(m->x[i]) && isfinite(m->y[i]) && isfinite(m->z[i]));
    for (uint32_t i = m->vertex_count; i % 16; i++) assert_true(m->x[i] == 0 && m->y[i] == 0 && m->z[i] == 0);
    for (uint32_t i = 0; i < m->normal_count; i++) {
        float length = daft_length(m->normals[i]);
        assert_true(length > 0.9999f && length < 1.0001f);
    }
    for (uint32_t i = 0; i < m->uv_count; i++) assert_true(isfinite(m->uvs[i].x) && isfinite(m->uvs[i].y));
    assert_true(m->uvs || !m->uv_indices);
    for (size_t i = 0; i < 3 * (size_t)m->triangle_count; i++) {
        assert_true(m->indices[i] < m->vertex_count);
        assert_true(m->indices[i] != m->indices[i % 3 == 2 ? i - 2 : i + 1]);
        uint32_t normal = m->normal_indices ? m->normal_indices[i] : m->indices[i];
        assert_true(normal < m->normal_count);
        uint32_t uv = m->uv_indices ? m->uv_indices[i] : m->indices[i];
        assert_true(!m->uvs || uv == DAFT_NO_UV || uv < m->uv_count);
    }
    for (uint32_t i = 0; m->slots && i < m->triangle_count; i++) assert_true(m->slots[i] < obj->slots.count);
    assert_true(obj->slots.count > 0);
    assert_true(m->triangle_count == 0 ? m->low.x > m->high.x : m->low.x <= m->high.x);
    assert_true(daft_trimesh_bytes(m) >= 12 * (size_t)m->triangle_count);
}

static inline daft_obj load(const char *path)
{
    daft_allocator allocator = counting_allocator(&memory);
    daft_log log = memo_log(&warnings);
    daft_obj obj;
    daft_error error;
    char shown[1100];
    if (!daft_obj_load(&allocator, NULL, path, &log, &obj, &error))
        fail_msg("%s", daft_error_text(&error, shown, sizeof shown));
    check_mesh(&obj);
    return obj;
}

static inline daft_obj load_text(const char *name, const char *text) { return load(write_test_text(name, text)); }

#define SQUARE "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"

#endif
