/* Meshes from arrays and boxes; what all meshes need. */
#include "geometry/trimesh.h"
#include "math/simd/ops.h"
#include "math/trig.h"

#include <string.h>

enum { LANES = 16 };

void daft_trimesh_free(const daft_allocator *allocator, daft_trimesh *mesh)
{
    daft_release(allocator, mesh->x);
    daft_release(allocator, mesh->y);
    daft_release(allocator, mesh->z);
    daft_release(allocator, mesh->indices);
    daft_release(allocator, mesh->normals);
    daft_release(allocator, mesh->normal_indices);
    daft_release(allocator, mesh->uvs);
    daft_release(allocator, mesh->uv_indices);
    daft_release(allocator, mesh->slots);
    daft_release(allocator, mesh->colors);
    daft_release(allocator, mesh->color_indices);
    daft_release(allocator, mesh->alphas);
    *mesh = (daft_trimesh){0};
}

static size_t padded(size_t count) { return (count + LANES - 1) / LANES * LANES; }

size_t daft_trimesh_bytes(const daft_trimesh *mesh)
{
    size_t corners = 3 * (size_t)mesh->triangle_count, lists = 1;
    lists += mesh->normal_indices != NULL;
    lists += mesh->uv_indices != NULL;
    lists += mesh->color_indices != NULL;
    size_t bytes = 3 * padded(mesh->vertex_count) * sizeof(float) + lists * corners * sizeof(uint32_t);
    bytes += ((size_t)mesh->normal_count + mesh->color_count) * sizeof(daft_vec3) + mesh->uv_count * sizeof(daft_vec2);
    bytes += mesh->alphas ? mesh->color_count * sizeof(float) : 0;
    return bytes + (mesh->slots ? mesh->triangle_count * sizeof(uint16_t) : 0);
}

/* A copy of `size` bytes, or NULL for NULL. Sets *done to false where memory is out. */
static void *copy_of(const daft_allocator *allocator, const void *from, size_t count, size_t size, bool *done)
{
    void *copy = from ? daft_alloc(allocator, count, size) : NULL;
    if (copy && count) memcpy(copy, from, count * size);
    *done = *done && (copy || !from);
    return copy;
}

bool daft_trimesh_copy(const daft_allocator *allocator, const daft_trimesh *mesh, daft_trimesh *out, daft_error *error)
{
    bool done = true;
    size_t room = padded(mesh->vertex_count), corners = 3 * (size_t)mesh->triangle_count;
    daft_trimesh copy = *mesh;
    copy.x = copy_of(allocator, mesh->x, room, sizeof *mesh->x, &done);
    copy.y = copy_of(allocator, mesh->y, room, sizeof *mesh->y, &done);
    copy.z = copy_of(allocator, mesh->z, room, sizeof *mesh->z, &done);
    copy.indices = copy_of(allocator, mesh->indices, corners, sizeof *mesh->indices, &done);
    copy.normals = copy_of(allocator, mesh->normals, mesh->normal_count, sizeof *mesh->normals, &done);
    copy.normal_indices = copy_of(allocator, mesh->normal_indices, corners, sizeof *mesh->normal_indices, &done);
    copy.uvs = copy_of(allocator, mesh->uvs, mesh->uv_count, sizeof *mesh->uvs, &done);
    copy.uv_indices = copy_of(allocator, mesh->uv_indices, corners, sizeof *mesh->uv_indices, &done);
    copy.colors = copy_of(allocator, mesh->colors, mesh->color_count, sizeof *mesh->colors, &done);
    copy.color_indices = copy_of(allocator, mesh->color_indices, corners, sizeof *mesh->color_indices, &done);
    copy.alphas = copy_of(allocator, mesh->alphas, mesh->color_count, sizeof *mesh->alphas, &done);
    copy.slots = copy_of(allocator, mesh->slots, mesh->triangle_count, sizeof *mesh->slots, &done);
    if (done)
        *out = copy;
    else
        daft_trimesh_free(allocator, &copy);
    return done || daft_fail_memory(error, "a copy of a mesh");
}

bool daft_trimesh_set_positions(const daft_allocator *allocator, daft_trimesh *mesh, const daft_vec3 *positions,
                                uint32_t count, daft_error *error)
{
    size_t room = count ? padded(count) : LANES;
    mesh->x = daft_alloc(allocator, room, sizeof(float));
    mesh->y = daft_alloc(allocator, room, sizeof(float));
    mesh->z = daft_alloc(allocator, room, sizeof(float));
    if (!mesh->x || !mesh->y || !mesh->z) return daft_fail_memory(error, "a mesh's vertices");
    for (size_t i = 0; i < room; i++) {
        daft_vec3 p = i < count && daft_finite3(positions[i]) ? positions[i] : daft_v3(0, 0, 0);
        mesh->x[i] = p.x, mesh->y[i] = p.y, mesh->z[i] = p.z;
    }
    mesh->vertex_count = count;
    return true;
}

/* Corner by corner. */
static void find_bounds(daft_trimesh *mesh)
{
    mesh->low = daft_v3(INFINITY, INFINITY, INFINITY);
    mesh->high = daft_neg(mesh->low);
    for (size_t i = 0; i < 3 * (size_t)mesh->triangle_count; i++) {
        daft_vec3 p = daft_trimesh_position(mesh, mesh->indices[i]);
        mesh->low = daft_min3(mesh->low, p);
        mesh->high = daft_max3(mesh->high, p);
    }
}

/* The least and the largest of an axis. */
static void find_range(const float *values, uint32_t count, float *low, float *high)
{
    v4 least = v4_set(values[0]), most = least;
    uint32_t i = 0;
    for (; i + 4 <= count; i += 4) {
        v4 value = v4_load(values + i);
        least = v4_min(least, value), most = v4_max(most, value);
    }
    for (; i < count; i++) least = v4_min(least, v4_set(values[i])), most = v4_max(most, v4_set(values[i]));
    *low = fminf(fminf(least[0], least[1]), fminf(least[2], least[3]));
    *high = fmaxf(fmaxf(most[0], most[1]), fmaxf(most[2], most[3]));
}

static uint32_t find_value(const float *values, float value)
{
    uint32_t i = 0;
    while (values[i] != value) i++;
    return i;
}

static bool are_used(const daft_trimesh *mesh, const uint32_t vertices[6])
{
    size_t corners = 3 * (size_t)mesh->triangle_count, i = 0;
    v4i found[6] = {0};
    for (; i + 4 <= corners; i += 4) {
        v4i four;
        memcpy(&four, mesh->indices + i, sizeof four);
        for (int k = 0; k < 6; k++) found[k] |= (v4i)(four == (v4i){0} + (int32_t)vertices[k]);
    }
    for (; i < corners; i++)
        for (int k = 0; k < 6; k++) found[k][0] |= mesh->indices[i] == vertices[k] ? -1 : 0;
    bool all = true;
    for (int k = 0; k < 6; k++) all = all && (found[k][0] | found[k][1] | found[k][2] | found[k][3]);
    return all;
}

/* All vertices are bounded, and if triangles use those at the bounds, these are the triangles' own. */
void daft_trimesh_set_bounds(daft_trimesh *mesh)
{
    if (mesh->triangle_count > 0) {
        const float *axes[3] = {mesh->x, mesh->y, mesh->z};
        float bounds[6];
        uint32_t vertices[6];
        bool signs = true; /* of a zero bound depend on which corner comes first */
        for (int k = 0; k < 3; k++) {
            find_range(axes[k], mesh->vertex_count, &bounds[k], &bounds[k + 3]);
            vertices[k] = find_value(axes[k], bounds[k]), vertices[k + 3] = find_value(axes[k], bounds[k + 3]);
            signs = signs && bounds[k] != 0 && bounds[k + 3] != 0;
        }
        if (signs && are_used(mesh, vertices)) {
            mesh->low = daft_v3(bounds[0], bounds[1], bounds[2]);
            mesh->high = daft_v3(bounds[3], bounds[4], bounds[5]);
            return;
        }
    }
    find_bounds(mesh);
}

daft_vec3 daft_trimesh_face_normal(const daft_trimesh *mesh, uint32_t triangle)
{
    const uint32_t *corner = mesh->indices + 3 * (size_t)triangle;
    daft_dvec3 a = daft_to_double(daft_trimesh_position(mesh, corner[0]));
    daft_dvec3 b = daft_to_double(daft_trimesh_position(mesh, corner[1]));
    daft_dvec3 c = daft_to_double(daft_trimesh_position(mesh, corner[2]));
    return daft_to_float(daft_unit(daft_dcross(daft_dsub(b, a), daft_dsub(c, a))));
}

/* ---- from arrays ---- */

static bool is_usable(const daft_mesh_def *def, const uint32_t *corner)
{
    if (corner[0] == corner[1] || corner[1] == corner[2] || corner[2] == corner[0]) return false;
    for (int k = 0; k < 3; k++)
        if (!daft_finite3(def->positions[corner[k]])) return false;
    return true;
}

static bool check_arrays(const daft_mesh_def *def, daft_error *error)
{
    if (def->vertex_count > 0 && !def->positions)
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "a mesh of %u vertices without positions", def->vertex_count);
    if (def->triangle_count > 0 && !def->indices)
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "a mesh of %u triangles without indices", def->triangle_count);
    if (def->triangle_count > UINT32_MAX / 3)
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "a mesh of %u triangles; 32-bit indices hold %u",
                         def->triangle_count, UINT32_MAX / 3);
    for (size_t i = 0; i < 3 * (size_t)def->triangle_count; i++)
        if (def->indices[i] >= def->vertex_count)
            return daft_fail(error, DAFT_ERROR_ARGUMENT, "triangle %zu uses vertex %u, but there are %u vertices",
                             i / 3, def->indices[i], def->vertex_count);
    return true;
}

static bool copy_triangles(const daft_allocator *allocator, const daft_mesh_def *def, const daft_log *log,
                           daft_trimesh *mesh, daft_error *error)
{
    mesh->indices = daft_alloc(allocator, 3 * (size_t)def->triangle_count, sizeof(uint32_t));
    if (!mesh->indices) return daft_fail_memory(error, "a mesh's triangles");
    for (uint32_t i = 0; i < def->triangle_count; i++) {
        const uint32_t *corner = def->indices + 3 * (size_t)i;
        if (is_usable(def, corner))
            memcpy(mesh->indices + 3 * (size_t)mesh->triangle_count++, corner, 3 * sizeof *corner);
    }
    uint32_t dropped = mesh->left_out = def->triangle_count - mesh->triangle_count;
    if (dropped > 0)
        daft_warn_at(log, DAFT_ERROR_ARGUMENT, NULL, 0, 0,
                     "%u of %u triangles are left out: two equal corners, or a corner that is not finite", dropped,
                     def->triangle_count);
    return true;
}

/* Where the caller's normal is zero or not finite: the sum of the faces around, by area. */
static void replace_normals(daft_trimesh *mesh, const daft_mesh_def *def, uint32_t bad)
{
    for (size_t i = 0; bad > 0 && i < 3 * (size_t)mesh->triangle_count; i++) {
        uint32_t vertex = mesh->indices[i];
        daft_vec3 given = def->normals[vertex];
        if (daft_finite3(given) && daft_dot(given, given) > 0) continue;
        mesh->normals[vertex] = daft_add(mesh->normals[vertex], daft_trimesh_face_normal(mesh, (uint32_t)(i / 3)));
    }
    for (uint32_t i = 0; i < mesh->vertex_count; i++) {
        daft_dvec3 unit = daft_unit(daft_to_double(mesh->normals[i]));
        mesh->normals[i] = daft_ddot(unit, unit) > 0 ? daft_to_float(unit) : daft_v3(0, 1, 0);
    }
}

static bool copy_normals(const daft_allocator *allocator, const daft_mesh_def *def, daft_trimesh *mesh,
                         daft_error *error)
{
    mesh->normals = daft_alloc(allocator, def->vertex_count, sizeof(daft_vec3));
    if (!mesh->normals) return daft_fail_memory(error, "a mesh's normals");
    uint32_t bad = 0;
    for (uint32_t i = 0; i < def->vertex_count; i++) {
        daft_vec3 given = def->normals[i];
        bool good = daft_finite3(given) && daft_dot(given, given) > 0;
        mesh->normals[i] = good ? given : daft_v3(0, 0, 0);
        bad += !good;
    }
    mesh->normal_count = def->vertex_count;
    replace_normals(mesh, def, bad);
    return true;
}

static bool copy_uvs(const daft_allocator *allocator, const daft_mesh_def *def, const daft_log *log, daft_trimesh *mesh,
                     daft_error *error)
{
    mesh->uvs = daft_alloc(allocator, def->vertex_count, sizeof(daft_vec2));
    if (!mesh->uvs) return daft_fail_memory(error, "a mesh's texture coordinates");
    uint32_t bad = 0;
    for (uint32_t i = 0; i < def->vertex_count; i++) {
        daft_vec2 uv = def->uvs[i];
        bool good = isfinite(uv.x) && isfinite(uv.y);
        mesh->uvs[i] = good ? uv : (daft_vec2){0, 0};
        bad += !good;
    }
    mesh->uv_count = def->vertex_count;
    if (bad > 0)
        daft_warn_at(log, DAFT_ERROR_ARGUMENT, NULL, 0, 0, "%u texture coordinates are not finite and become 0, 0",
                     bad);
    return true;
}

float daft_trimesh_color(double encoded)
{
    if (!(encoded > 0)) return 0; /* nor is a NaN */
    if (encoded >= 1) return 1;
    return (float)(encoded <= 0.04045 ? encoded / 12.92 : daft_pow((encoded + 0.055) / 1.055, 2.4));
}

float daft_trimesh_alpha(float alpha) { return alpha >= 0 ? fminf(alpha, 1) : alpha < 0 ? 0 : 1; }

/* Alphas have colours, be they white. */
static bool copy_colors(const daft_allocator *allocator, const daft_mesh_def *def, daft_trimesh *mesh,
                        daft_error *error)
{
    mesh->colors = daft_alloc(allocator, def->vertex_count, sizeof(daft_vec3));
    if (def->alphas) mesh->alphas = daft_alloc(allocator, def->vertex_count, sizeof(float));
    if (!mesh->colors || (def->alphas && !mesh->alphas)) return daft_fail_memory(error, "a mesh's colours");
    mesh->color_count = def->vertex_count;
    for (uint32_t i = 0; i < def->vertex_count; i++) {
        const daft_vec3 white = daft_v3(1, 1, 1), c = def->colors ? def->colors[i] : white;
        mesh->colors[i] = daft_finite3(c) ? daft_min3(daft_max3(c, daft_v3(0, 0, 0)), white) : white;
        if (def->alphas) mesh->alphas[i] = daft_trimesh_alpha(def->alphas[i]);
    }
    return true;
}

bool daft_trimesh_from_arrays(const daft_allocator *allocator, const daft_mesh_def *def, const daft_log *log,
                              daft_trimesh *out, daft_error *error)
{
    if (!check_arrays(def, error)) return false;
    daft_trimesh mesh = {0};
    bool done = daft_trimesh_set_positions(allocator, &mesh, def->positions, def->vertex_count, error) &&
                copy_triangles(allocator, def, log, &mesh, error);
    if (done && def->uvs && def->vertex_count > 0) done = copy_uvs(allocator, def, log, &mesh, error);
    if (done && (def->colors || def->alphas) && def->vertex_count > 0) done = copy_colors(allocator, def, &mesh, error);
    if (done)
        done = def->normals && def->vertex_count > 0 ? copy_normals(allocator, def, &mesh, error)
                                                     : daft_trimesh_smooth(allocator, &mesh, DAFT_SMOOTH_CREASE, error);
    if (!done) {
        daft_trimesh_free(allocator, &mesh);
        return false;
    }
    daft_trimesh_set_bounds(&mesh);
    *out = mesh;
    return true;
}

bool daft_trimesh_deform(const daft_allocator *allocator, daft_trimesh *mesh, const daft_vec3 *positions,
                         const daft_vec3 *normals, daft_error *error)
{
    for (uint32_t i = 0; i < mesh->vertex_count; i++)
        if (!daft_finite3(positions[i])) return daft_fail(error, DAFT_ERROR_ARGUMENT, "position %u is not finite", i);
    daft_mesh_def def = {.normals = normals, .vertex_count = mesh->vertex_count};
    daft_trimesh fresh = *mesh, *rest = &fresh;
    fresh.x = fresh.y = fresh.z = NULL;
    fresh.normals = NULL, fresh.normal_indices = NULL;
    bool done = daft_trimesh_set_positions(allocator, &fresh, positions, mesh->vertex_count, error);
    if (done && normals && mesh->vertex_count > 0)
        done = copy_normals(allocator, &def, &fresh, error);
    else if (done)
        done = daft_trimesh_smooth(allocator, &fresh, DAFT_SMOOTH_CREASE, error);
    if (done) {
        daft_trimesh old = *mesh;
        daft_trimesh_set_bounds(&fresh);
        *mesh = fresh;
        fresh = old;
    }
    void *gone[] = {rest->x, rest->y, rest->z, rest->normals, rest->normal_indices};
    for (size_t i = 0; i < DAFT_COUNT_OF(gone); i++) daft_release(allocator, gone[i]);
    return done;
}

/* ---- box ---- */

enum { SIDES = 6 };

typedef struct side {
    uint8_t corners[4]; /* bits 0, 1, 2 of a corner: the high end in x, y, z. From lower left, counter-clockwise */
    uint8_t across, up; /* the axes of u and v */
    daft_vec3 normal;
} side;

/* As seen from outside, u to the right. v is up on the four upright sides, -Z on top and +Z below. */
static const side box_sides[SIDES] = {
    {{5, 1, 3, 7}, 2, 1, {1, 0, 0}},  {{0, 4, 6, 2}, 2, 1, {-1, 0, 0}}, {{6, 7, 3, 2}, 0, 2, {0, 1, 0}},
    {{0, 1, 5, 4}, 0, 2, {0, -1, 0}}, {{4, 5, 7, 6}, 0, 1, {0, 0, 1}},  {{1, 0, 2, 3}, 0, 1, {0, 0, -1}},
};

static void fill_side(daft_trimesh *mesh, uint32_t number, const float size[3])
{
    static const uint8_t order[6] = {0, 1, 2, 0, 2, 3};
    const side *s = &box_sides[number];
    float width = size[s->across], height = size[s->up];
    const daft_vec2 uvs[4] = {{0, 0}, {width, 0}, {width, height}, {0, height}};
    memcpy(mesh->uvs + 4 * number, uvs, sizeof uvs);
    mesh->normals[number] = s->normal;
    for (uint32_t k = 0; k < 6; k++) {
        mesh->indices[6 * number + k] = s->corners[order[k]];
        mesh->normal_indices[6 * number + k] = number;
        mesh->uv_indices[6 * number + k] = 4 * number + order[k];
    }
}

bool daft_trimesh_box(const daft_allocator *allocator, daft_vec3 size, daft_trimesh *out, daft_error *error)
{
    if (!daft_finite3(size) || !(size.x > 0 && size.y > 0 && size.z > 0))
        return daft_fail(error, DAFT_ERROR_ARGUMENT, "a box needs three positive sizes, not %g, %g, %g", (double)size.x,
                         (double)size.y, (double)size.z);
    daft_vec3 corners[8];
    for (int i = 0; i < 8; i++)
        corners[i] = daft_v3(i & 1 ? size.x / 2 : -size.x / 2, i & 2 ? size.y / 2 : -size.y / 2,
                             i & 4 ? size.z / 2 : -size.z / 2);
    daft_trimesh mesh = {.triangle_count = 2 * SIDES, .normal_count = SIDES, .uv_count = 4 * SIDES};
    mesh.indices = daft_alloc(allocator, 6 * SIDES, sizeof(uint32_t));
    mesh.normal_indices = daft_alloc(allocator, 6 * SIDES, sizeof(uint32_t));
    mesh.uv_indices = daft_alloc(allocator, 6 * SIDES, sizeof(uint32_t));
    mesh.normals = daft_alloc(allocator, SIDES, sizeof(daft_vec3));
    mesh.uvs = daft_alloc(allocator, 4 * SIDES, sizeof(daft_vec2));
    bool done = daft_trimesh_set_positions(allocator, &mesh, corners, 8, error);
    if (!done || !mesh.indices || !mesh.normal_indices || !mesh.uv_indices || !mesh.normals || !mesh.uvs) {
        daft_trimesh_free(allocator, &mesh);
        return daft_fail_memory(error, "a box");
    }
    for (uint32_t i = 0; i < SIDES; i++) fill_side(&mesh, i, (float[3]){size.x, size.y, size.z});
    daft_trimesh_set_bounds(&mesh);
    *out = mesh;
    return true;
}
