/* From the arrays of an OBJ file to a mesh: indices are checked against the final counts, faces are cut into triangles,
 * uvs and normals are brought into shape. */
#include "geometry/formats/obj.h"
#include "geometry/polygon.h"
#include "geometry/trimesh.h"

typedef struct builder {
    daft_obj_source *source;
    daft_trimesh *mesh;
    daft_error *error;
    daft_polygon polygon;
    size_t face;    /* whose triangles are put */
    uint32_t *kept; /* corners of a polygon without repeated ones, relative to its first */
    uint32_t kept_room;
} builder;

/* Where a face stands, for a message; nowhere once messages are only counted, so that time stays linear. */
static const char *place_of(const builder *b, size_t face)
{
    const daft_obj_source *s = b->source;
    if (s->text.warnings >= DAFT_TEXT_WARNINGS && s->first_drop) return s->text.begin;
    return daft_obj_find_face(s, face);
}

static void check_attribute(builder *b, size_t face, uint32_t *index, size_t count, const char *what)
{
    if (*index == DAFT_OBJ_ABSENT || *index < count) return;
    const char *place = b->source->text.warnings < DAFT_TEXT_WARNINGS ? daft_obj_find_face(b->source, face) : NULL;
    daft_text_warn(&b->source->text, place, "%s %u does not exist (the file has %zu), so the corner has none", what,
                   *index + 1, count);
    *index = DAFT_OBJ_ABSENT;
}

static bool has_missing_position(const builder *b, const uint32_t *corners, uint32_t count)
{
    for (uint32_t k = 0; k < count; k++)
        if (corners[k] >= b->source->position_count) return true;
    return false;
}

/* Makes every index of uvs and normals of a face fit its array. */
static void check_corners(builder *b, size_t face, size_t first, uint32_t count)
{
    daft_obj_source *s = b->source;
    for (uint32_t k = 0; k < count; k++) {
        uint32_t *uv = s->corner_uvs ? &s->corner_uvs[first + k] : NULL;
        if (uv) check_attribute(b, face, uv, s->uv_count, "texture coordinate");
        if (s->corner_normals) check_attribute(b, face, &s->corner_normals[first + k], s->normal_count, "normal");
        if (!uv || !s->bad_uv || *uv == DAFT_OBJ_ABSENT) continue;
        if (!isfinite(s->uvs[*uv].x) || !isfinite(s->uvs[*uv].y)) *uv = DAFT_OBJ_ABSENT;
    }
}

static bool has_bad_position(const builder *b, const uint32_t *corners, uint32_t count)
{
    for (uint32_t k = 0; b->source->bad_position && k < count; k++)
        if (!daft_finite3(daft_obj_position(b->source, corners[k]))) return true;
    return false;
}

static inline void put_triangle(builder *b, const size_t corner[3], const daft_obj_run *run)
{
    const daft_obj_source *s = b->source;
    daft_trimesh *mesh = b->mesh;
    size_t at = 3 * (size_t)mesh->triangle_count;
    for (size_t k = 0; k < 3; k++) {
        mesh->indices[at + k] = s->corner_positions[corner[k]];
        if (mesh->uv_indices) mesh->uv_indices[at + k] = s->corner_uvs[corner[k]];
        if (mesh->normal_indices) mesh->normal_indices[at + k] = s->corner_normals[corner[k]];
    }
    if (mesh->slots) mesh->slots[mesh->triangle_count] = (uint16_t)run->slot;
    if (s->groups) s->groups[mesh->triangle_count] = run->group;
    if (s->face_of) s->face_of[mesh->triangle_count] = (uint32_t)b->face;
    mesh->triangle_count++;
}

static bool repeats(uint32_t i, uint32_t j, uint32_t k) { return i == j || j == k || k == i; }

/* The corners of a polygon without those that repeat the vertex before; fills kept, returns how many are left. */
static uint32_t keep_corners(builder *b, const uint32_t *corners, uint32_t count)
{
    uint32_t kept = 0;
    for (uint32_t k = 0; k < count; k++)
        if (kept == 0 || corners[b->kept[kept - 1]] != corners[k]) b->kept[kept++] = k;
    while (kept > 1 && corners[b->kept[kept - 1]] == corners[b->kept[0]]) kept--;
    return kept;
}

static bool reserve(builder *b, uint32_t count)
{
    const daft_allocator *allocator = b->source->allocator;
    if (count > b->kept_room) {
        daft_release(allocator, b->kept);
        b->kept_room = 0;
        b->kept = daft_alloc(allocator, b->source->largest_face, sizeof *b->kept);
        if (!b->kept) return daft_fail_memory(b->error, "a face of many corners");
        b->kept_room = b->source->largest_face;
    }
    return daft_polygon_reserve(allocator, &b->polygon, count) || daft_fail_memory(b->error, "a face of many corners");
}

static bool put_polygon(builder *b, size_t face, size_t first, uint32_t count, const daft_obj_run *run)
{
    if (!reserve(b, count)) return false;
    daft_obj_source *s = b->source;
    const uint32_t *corners = s->corner_positions + first;
    uint32_t kept = keep_corners(b, corners, count), before = b->mesh->triangle_count;
    daft_dvec3 origin = daft_to_double(daft_obj_position(s, corners[b->kept[0]]));
    for (uint32_t k = 0; k < kept; k++)
        b->polygon.points[k] = daft_dsub(daft_to_double(daft_obj_position(s, corners[b->kept[k]])), origin);
    if (kept >= 3 && !daft_polygon_triangulate(&b->polygon, kept))
        daft_text_warn(&s->text, place_of(b, face), "a face of %u corners is too intricate: it was cut roughly", count);
    for (uint32_t t = 0; t + 2 < kept; t++) {
        const uint32_t *local = b->polygon.triangles + 3 * (size_t)t;
        uint32_t i = b->kept[local[0]], j = b->kept[local[1]], k = b->kept[local[2]];
        if (!repeats(corners[i], corners[j], corners[k]))
            put_triangle(b, (size_t[3]){first + i, first + j, first + k}, run);
    }
    if (b->mesh->triangle_count == before)
        daft_obj_drop(s, place_of(b, face), "it has fewer than 3 different vertices");
    return true;
}

static bool put_face(builder *b, size_t face, size_t first, uint32_t count, const daft_obj_run *run)
{
    b->face = face;
    const uint32_t *corners = b->source->corner_positions + first;
    if (has_missing_position(b, corners, count)) {
        daft_obj_drop(b->source, place_of(b, face), "it names a vertex that does not exist");
        return true;
    }
    check_corners(b, face, first, count);
    if (has_bad_position(b, corners, count)) {
        daft_obj_drop(b->source, place_of(b, face), "a vertex of it is not finite");
        return true;
    }
    if (count > 3) return put_polygon(b, face, first, count, run);
    if (repeats(corners[0], corners[1], corners[2]))
        daft_obj_drop(b->source, place_of(b, face), "it has fewer than 3 different vertices");
    else
        put_triangle(b, (size_t[3]){first, first + 1, first + 2}, run);
    return true;
}

static bool put_faces(builder *b)
{
    daft_obj_source *s = b->source;
    size_t run = 0, first = 0;
    for (size_t face = 0; face < s->face_count; face++) {
        uint32_t count = s->faces ? s->faces[face] : 3;
        if (count == 0) continue; /* dropped while reading */
        while (run + 1 < s->run_count && s->runs[run + 1].first_face <= face) run++;
        if (!put_face(b, face, first, count, &s->runs[run])) return false;
        first += count;
    }
    if (s->face_count == 0) daft_text_warn(&s->text, s->text.begin, "the file has no faces: the mesh is empty");
    if (s->face_count > 0 && b->mesh->triangle_count == 0)
        return daft_text_fail(&s->text, s->first_drop, b->error, "no face of the file can be used: %s",
                              s->first_drop_reason);
    return true;
}

static bool reserve_triangles(builder *b)
{
    daft_obj_source *s = b->source;
    size_t corners = 3 * s->triangle_count;
    b->mesh->indices = daft_alloc(s->allocator, corners, sizeof(uint32_t));
    bool done = b->mesh->indices != NULL;
    if (s->corner_uvs) done &= (b->mesh->uv_indices = daft_alloc(s->allocator, corners, sizeof(uint32_t))) != NULL;
    if (s->corner_normals)
        done &= (b->mesh->normal_indices = daft_alloc(s->allocator, corners, sizeof(uint32_t))) != NULL;
    return done || daft_fail_memory(b->error, "a mesh's triangles");
}

/* What triangles have by runs of faces. */
static bool reserve_runs(builder *b)
{
    daft_obj_source *s = b->source;
    bool grouped = s->run_count > 1 || (s->run_count == 1 && s->runs[0].group != DAFT_OBJ_GROUP_NONE), done = true;
    if (s->slot_count > 1)
        done &= (b->mesh->slots = daft_alloc(s->allocator, s->triangle_count, sizeof(uint16_t))) != NULL;
    if (grouped) done &= (s->groups = daft_alloc(s->allocator, s->triangle_count, sizeof(uint32_t))) != NULL;
    return done || daft_fail_memory(b->error, "a mesh's triangles");
}

/* ---- files whose faces are all good triangles ---- */

/* Every index is, or is DAFT_OBJ_ABSENT. */
static bool all_below(const uint32_t *list, size_t length, size_t count)
{
    uint32_t end = 0; /* behind the largest; what is absent counts as before the first */
    for (size_t i = 0; list && i < length; i++) end = list[i] + 1 > end ? list[i] + 1 : end;
    return end <= count;
}

static bool is_plain(const daft_obj_source *s)
{
    return s->face_count > 0 && !s->faces && !s->repeats && !s->bad_position && !s->bad_uv &&
           all_below(s->corner_positions, s->corner_count, s->position_count) &&
           all_below(s->corner_uvs, s->corner_count, s->uv_count) &&
           all_below(s->corner_normals, s->corner_count, s->normal_count);
}

/* Hands an array over, in a smaller place if much of its own is unused. */
static void *take(const daft_obj_source *s, void *array_pointer, size_t room, size_t count, size_t size)
{
    void *taken, *nothing = NULL, *smaller;
    memcpy(&taken, array_pointer, sizeof taken);
    if (taken && room > count + count / 16 + 64 && (smaller = daft_alloc(s->allocator, count, size)) != NULL) {
        if (count > 0) memcpy(smaller, taken, count * size);
        daft_release(s->allocator, taken);
        taken = smaller;
    }
    memcpy(array_pointer, &nothing, sizeof nothing);
    return taken;
}

/* The corners as read are the triangles. */
static void take_faces(builder *b)
{
    daft_obj_source *s = b->source;
    daft_trimesh *mesh = b->mesh;
    mesh->indices = take(s, &s->corner_positions, s->corner_room, s->corner_count, sizeof(uint32_t));
    mesh->uv_indices = take(s, &s->corner_uvs, s->corner_room, s->corner_count, sizeof(uint32_t));
    mesh->normal_indices = take(s, &s->corner_normals, s->corner_room, s->corner_count, sizeof(uint32_t));
    mesh->triangle_count = (uint32_t)s->face_count;
    for (uint32_t i = 0, run = 0; (mesh->slots || s->groups) && i < mesh->triangle_count; i++) {
        while (run + 1 < s->run_count && s->runs[run + 1].first_face <= i) run++;
        if (mesh->slots) mesh->slots[i] = (uint16_t)s->runs[run].slot;
        if (s->groups) s->groups[i] = s->runs[run].group;
    }
    for (uint32_t i = 0; s->face_of && i < mesh->triangle_count; i++) s->face_of[i] = i;
}

static bool take_alphas(builder *b)
{
    daft_obj_source *s = b->source;
    if (!daft_grow(s->allocator, &s->alphas, &s->alpha_room, s->position_count, s->alpha_count, sizeof *s->alphas))
        return daft_fail_memory(b->error, "a mesh's colours");
    while (s->alpha_count < s->position_count) s->alphas[s->alpha_count++] = 1;
    b->mesh->alphas = take(s, &s->alphas, s->alpha_room, s->position_count, sizeof *s->alphas);
    return true;
}

static bool take_colors(builder *b)
{
    daft_obj_source *s = b->source;
    if (!s->colors) return true;
    if (!daft_grow(s->allocator, &s->colors, &s->color_room, s->position_count, s->color_count, sizeof *s->colors))
        return daft_fail_memory(b->error, "a mesh's colours");
    while (s->color_count < s->position_count) s->colors[s->color_count++] = daft_v3(1, 1, 1);
    b->mesh->colors = take(s, &s->colors, s->color_room, s->position_count, sizeof *s->colors);
    b->mesh->color_count = (uint32_t)s->position_count;
    return !s->alphas || take_alphas(b);
}

/* x, y, z with zeros behind them, and in place of what is not finite: no triangle uses that. */
static bool take_positions(builder *b)
{
    enum { LANES = 16 };
    daft_obj_source *s = b->source;
    daft_trimesh *mesh = b->mesh;
    size_t count = s->position_count, padded = count ? (count + LANES - 1) / LANES * LANES : LANES;
    float **from[3] = {&s->x, &s->y, &s->z}, **to[3] = {&mesh->x, &mesh->y, &mesh->z};
    for (int k = 0; k < 3; k++) {
        size_t room = s->position_room;
        if (!daft_grow(s->allocator, from[k], &room, padded, count, sizeof(float)))
            return daft_fail_memory(b->error, "a mesh's vertices");
        memset(*from[k] + count, 0, (padded - count) * sizeof(float));
    }
    for (size_t i = 0; s->bad_position && i < count; i++)
        if (!daft_finite3(daft_obj_position(s, i))) s->x[i] = s->y[i] = s->z[i] = 0;
    for (int k = 0; k < 3; k++) *to[k] = take(s, from[k], s->position_room, padded, sizeof(float));
    mesh->vertex_count = (uint32_t)count;
    return take_colors(b);
}

/* ---- uvs and normals ---- */

/* Lists that say the same as the vertices' cost nothing. */
static void drop_if_same(const daft_obj_source *s, const daft_trimesh *mesh, uint32_t **list)
{
    size_t bytes = 3 * (size_t)mesh->triangle_count * sizeof(uint32_t);
    if (!*list || memcmp(*list, mesh->indices, bytes) != 0) return;
    daft_release(s->allocator, *list);
    *list = NULL;
}

static bool any_present(const uint32_t *list, size_t count)
{
    for (size_t i = 0; list && i < count; i++)
        if (list[i] != DAFT_OBJ_ABSENT) return true;
    return false;
}

static bool finish_uvs(builder *b)
{
    daft_obj_source *s = b->source;
    daft_trimesh *mesh = b->mesh;
    if (!any_present(mesh->uv_indices, 3 * (size_t)mesh->triangle_count)) {
        daft_release(s->allocator, mesh->uv_indices);
        mesh->uv_indices = NULL;
        return true;
    }
    for (size_t i = 0; s->bad_uv && i < s->uv_count; i++)
        if (!isfinite(s->uvs[i].x) || !isfinite(s->uvs[i].y)) s->uvs[i] = (daft_vec2){0, 0};
    mesh->uvs = take(s, &s->uvs, s->uv_room, s->uv_count, sizeof *s->uvs);
    mesh->uv_count = (uint32_t)s->uv_count;
    drop_if_same(s, mesh, &mesh->uv_indices);
    return true;
}

/* Unit length in place; a normal that has no direction becomes zero. Returns whether there is one. */
static bool normalize_all(daft_obj_source *s)
{
    bool any_zero = false;
    for (size_t i = 0; i < s->normal_count; i++) {
        daft_vec3 n = s->normals[i];
        double x = (double)n.x, y = (double)n.y, z = (double)n.z;
        double length = sqrt(x * x + y * y + z * z);
        bool good = length > 0 && isfinite(length);
        s->normals[i] =
            good ? daft_v3((float)(x / length), (float)(y / length), (float)(z / length)) : daft_v3(0, 0, 0);
        any_zero |= !good;
    }
    return any_zero;
}

/* Corners with a zero normal are as if they had none. Returns whether some corner has none. */
static bool find_absent(const daft_obj_source *s, daft_trimesh *mesh, bool any_zero)
{
    bool any = false;
    uint32_t *list = mesh->normal_indices;
    for (size_t i = 0; i < 3 * (size_t)mesh->triangle_count; i++) {
        if (any_zero && list[i] != DAFT_OBJ_ABSENT) {
            daft_vec3 n = s->normals[list[i]];
            if (n.x == 0 && n.y == 0 && n.z == 0) list[i] = DAFT_OBJ_ABSENT;
        }
        any |= list[i] == DAFT_OBJ_ABSENT;
    }
    return any;
}

/* The normals of the file, then those that were computed for corners without. */
static bool merge_normals(daft_obj_source *s, daft_trimesh *mesh, const daft_trimesh *computed, daft_error *error)
{
    size_t total = s->normal_count + computed->normal_count;
    if (total > UINT32_MAX) return daft_fail_memory(error, "a mesh's normals");
    if (computed->normal_count > 0) {
        if (!daft_grow(s->allocator, &s->normals, &s->normal_room, total, s->normal_count, sizeof *s->normals))
            return daft_fail_memory(error, "a mesh's normals");
        memcpy(s->normals + s->normal_count, computed->normals, computed->normal_count * sizeof *s->normals);
    }
    mesh->normals = take(s, &s->normals, s->normal_room, total, sizeof *s->normals);
    /* A normal without direction that no corner uses any more still has to be a unit vector. */
    for (size_t i = 0; i < s->normal_count; i++)
        if (daft_dot(mesh->normals[i], mesh->normals[i]) < 0.5f) mesh->normals[i] = daft_v3(0, 1, 0);
    mesh->normal_count = (uint32_t)total;
    const uint32_t *own = computed->normal_indices ? computed->normal_indices : mesh->indices;
    for (size_t i = 0; computed->normal_count > 0 && i < 3 * (size_t)mesh->triangle_count; i++)
        if (mesh->normal_indices[i] == DAFT_OBJ_ABSENT) mesh->normal_indices[i] = (uint32_t)s->normal_count + own[i];
    drop_if_same(s, mesh, &mesh->normal_indices);
    return true;
}

bool daft_obj_make_normals(daft_obj_source *s, daft_trimesh *mesh, daft_error *error)
{
    bool any_zero = normalize_all(s);
    bool any_absent = mesh->normal_indices && find_absent(s, mesh, any_zero);
    if (!any_present(mesh->normal_indices, 3 * (size_t)mesh->triangle_count)) {
        daft_release(s->allocator, mesh->normal_indices);
        mesh->normal_indices = NULL;
        return true;
    }
    daft_trimesh computed = *mesh;
    computed.normals = NULL;
    computed.normal_indices = NULL;
    computed.normal_count = 0;
    bool done =
        !any_absent || daft_trimesh_smooth_groups(s->allocator, &computed, DAFT_SMOOTH_CREASE, s->groups, error);
    done = done && merge_normals(s, mesh, &computed, error);
    daft_release(s->allocator, computed.normals);
    daft_release(s->allocator, computed.normal_indices);
    return done;
}

bool daft_obj_make_mesh(daft_obj_source *source, daft_trimesh *mesh, daft_error *error)
{
    builder b = {.source = source, .mesh = mesh, .error = error};
    bool done = reserve_runs(&b);
    if (done && is_plain(source))
        take_faces(&b);
    else
        done = done && reserve_triangles(&b) && put_faces(&b);
    done = done && take_positions(&b) && finish_uvs(&b);
    if (done) daft_trimesh_set_bounds(mesh);
    mesh->left_out = source->drops;
    daft_polygon_free(source->allocator, &b.polygon);
    daft_release(source->allocator, b.kept);
    return done;
}
