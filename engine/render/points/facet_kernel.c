/* Set-up of hit surfaces: fills one row of `daft_facets` for each triangle or sphere that some ray of a batch hit, with
 * its plane, vertex normals, texture coordinates and error bounds; DAFT_VL triangles at a time, of any instances.
 * surface_kernel.c interpolates at the hit points from these rows. A plane's normal and height are taken in double, so
 * that the points are as precise as that file promises. */
#include "math/simd/ops.h"
#include "render/points/surface.h"

#include <stddef.h>

/* What is fetched of a group's triangles, lane by lane; lanes without one are not set, and what comes of them is
 * dropped. */
typedef struct stage {
    float corner[9][DAFT_VL], normal[9][DAFT_VL]; /* object space: x, y, z of corner 0, then of 1 and 2 */
    const float *maps[DAFT_VL]; /* to_frame, and to_object behind it; of one instance the first alone is set */
    float size[DAFT_VL];
    int32_t word[DAFT_VL];
    vbits triangles, spheres, with_normals, textured, colored;
    bool one_instance;
} stage;

static void add_traits(const daft_snapshot *snapshot, uint32_t material, daft_facets *f)
{
    if (material == f->last_material) return;
    if (f->last_material != UINT32_MAX) f->one_material = false;
    f->last_material = material;
    f->traits |= daft_surface_traits(&snapshot->materials[material]);
}

static void set_sphere(const daft_instance *s, float row[DAFT_FACET_FLOATS])
{
    const float *t = s->to_frame.t;
    int32_t word = (int32_t)s->materials[0] | FACET_SPHERE;
    for (int k = 0; k < 3; k++) row[SPHERE_CENTRE + k] = t[k];
    for (int k = 0; k < 9; k++) row[SPHERE_TURN + k] = s->to_object.m[k];
    row[SPHERE_RADIUS] = s->radius;
    row[FACET_SIZE] = fabsf(t[0]) + fabsf(t[1]) + fabsf(t[2]) + s->radius;
    memcpy(&row[FACET_WORD], &word, sizeof word);
    row[FACET_DENSITY] = 0.225079079f / s->radius; /* the map's area is 2·pi·r by pi·r: its mean density is 1 /
                                                      (sqrt(2)·pi·r) */
}

static void stage_triangle(const daft_instance *s, uint32_t triangle, int lane, stage *out)
{
    const daft_trimesh *mesh = s->mesh;
    const uint32_t *corner = &mesh->indices[3 * (size_t)triangle];
    for (int k = 0; k < 3; k++) {
        uint32_t v = corner[k];
        out->corner[3 * k][lane] = mesh->x[v], out->corner[3 * k + 1][lane] = mesh->y[v],
                        out->corner[3 * k + 2][lane] = mesh->z[v];
    }
    out->triangles |= (vbits)1 << lane;
    if (!mesh->normals) return;
    const uint32_t *at = mesh->normal_indices ? &mesh->normal_indices[3 * (size_t)triangle] : corner;
    for (int k = 0; k < 3; k++) {
        daft_vec3 n = mesh->normals[at[k]];
        out->normal[3 * k][lane] = n.x, out->normal[3 * k + 1][lane] = n.y, out->normal[3 * k + 2][lane] = n.z;
    }
    out->with_normals |= (vbits)1 << lane;
}

void DAFT_KERNEL(daft_facets_fetch)(const daft_snapshot *snapshot, const daft_facets *facets, uint32_t first)
{
    uint32_t end = daft_min_u(first + DAFT_VL, facets->count), last = DAFT_NOTHING;
    const daft_trimesh *mesh = NULL;
    for (uint32_t i = first; i < end; i++) {
        if (facets->instance[i] != last) last = facets->instance[i], mesh = snapshot->instances[last].mesh;
        if (!mesh) continue;
        const uint32_t *corner = &mesh->indices[3 * (size_t)facets->triangle[i]];
        for (int k = 0; k < 3; k++)
            __builtin_prefetch(&mesh->x[corner[k]]), __builtin_prefetch(&mesh->y[corner[k]]),
                __builtin_prefetch(&mesh->z[corner[k]]);
        if (!mesh->normals) continue;
        const uint32_t *at = mesh->normal_indices ? &mesh->normal_indices[3 * (size_t)facets->triangle[i]] : corner;
        for (int k = 0; k < 3; k++) __builtin_prefetch(&mesh->normals[at[k]]);
    }
}

static uint32_t color_traits(const daft_facets *f, const daft_trimesh *mesh)
{
    return (mesh->colors ? DAFT_TRAIT_COLORS : 0u) | (f->fades && mesh->alphas ? DAFT_TRAIT_FADES : 0u);
}

/* Stages triangles of one mesh and one material. Their common data is copied first: the compiler must assume that each
 * store may change it. */
static void stage_alike(const daft_snapshot *snapshot, daft_facets *f, uint32_t first, uint32_t count, stage *out)
{
    const daft_instance *s = &snapshot->instances[f->instance[first]];
    const daft_trimesh *mesh = s->mesh;
    const float *x = mesh->x, *y = mesh->y, *z = mesh->z, *t = s->to_frame.t;
    const uint32_t *indices = mesh->indices, *normal_indices = mesh->normal_indices ? mesh->normal_indices : indices,
                   *triangles = &f->triangle[first];
    const daft_vec3 *normals = mesh->normals;
    const uint32_t material = s->materials[0];
    const vbits lanes = vbits_first_n((int)count);
    for (uint32_t i = 0; i < count; i++) {
        size_t at = 3 * (size_t)triangles[i];
        for (size_t k = 0; k < 3; k++) {
            uint32_t v = indices[at + k];
            out->corner[3 * k][i] = x[v], out->corner[3 * k + 1][i] = y[v], out->corner[3 * k + 2][i] = z[v];
        }
        if (!normals) continue;
        for (size_t k = 0; k < 3; k++) {
            const daft_vec3 n = normals[normal_indices[at + k]];
            out->normal[3 * k][i] = n.x, out->normal[3 * k + 1][i] = n.y, out->normal[3 * k + 2][i] = n.z;
        }
    }
    add_traits(snapshot, material, f);
    out->triangles = lanes, out->with_normals = normals ? lanes : 0;
    out->textured = daft_surface_is_textured(&snapshot->materials[material]) ? lanes : 0;
    out->colored = mesh->colors ? lanes : 0;
    f->traits |= color_traits(f, mesh);
    vf_store(out->size, vf_set(fabsf(t[0]) + fabsf(t[1]) + fabsf(t[2])));
    vi_store(out->word, vi_set((int32_t)material | (mesh->colors ? FACET_COLORED : 0)));
}

static void fetch_group(const daft_snapshot *snapshot, daft_facets *f, uint32_t first, uint32_t count, stage *out)
{
    out->triangles = out->spheres = out->with_normals = out->textured = out->colored = 0, out->one_instance = true;
    out->maps[0] = (const float *)&snapshot->instances[f->instance[first]].to_frame;
    for (uint32_t i = 1; i < count; i++) out->one_instance &= f->instance[first + i] == f->instance[first];
    const daft_trimesh *mesh = snapshot->instances[f->instance[first]].mesh;
    if (out->one_instance && mesh && !mesh->slots) {
        stage_alike(snapshot, f, first, count, out);
        return;
    }
    for (uint32_t i = 1; i < DAFT_VL; i++)
        out->maps[i] = (const float *)&snapshot->instances[f->instance[first + (i < count ? i : 0)]].to_frame;
    for (uint32_t i = 0; i < count; i++) {
        const daft_instance *s = &snapshot->instances[f->instance[first + i]];
        uint32_t triangle = f->triangle[first + i];
        uint32_t material = s->materials[s->mesh && s->mesh->slots ? s->mesh->slots[triangle] : 0];
        add_traits(snapshot, material, f);
        if (!s->mesh) {
            set_sphere(s, f->row[first + i]);
            out->spheres |= (vbits)1 << i;
            continue;
        }
        const float *t = s->to_frame.t;
        stage_triangle(s, triangle, (int)i, out);
        out->size[i] = fabsf(t[0]) + fabsf(t[1]) + fabsf(t[2]);
        out->word[i] = (int32_t)material;
        if (daft_surface_is_textured(&snapshot->materials[material])) out->textured |= (vbits)1 << i;
        if (!s->mesh->colors) continue;
        out->colored |= (vbits)1 << i, out->word[i] |= FACET_COLORED, f->traits |= color_traits(f, s->mesh);
    }
}

/* ---- in lanes ---- */

/* A group in frame space. */
typedef struct group {
    vf3 corner[3], normal[3], outward;
    vf area, height, min, max;
    vbits smooth, inner; /* inner: the rays see its inner side */
    vbits mirrored;      /* to_frame mirrors */
} group;

static void move_group(const stage *from, group *g)
{
    _Static_assert(offsetof(daft_instance, to_object) == offsetof(daft_instance, to_frame) + 12 * sizeof(float),
                   "one behind the other");
    vf m[24], *inverse = m + 12;
    for (int k = 0; k < 24 && from->one_instance; k++) m[k] = vf_set(from->maps[0][k]);
    for (int k = 0; k < 24 && !from->one_instance; k += 4) vf_gather_rows4(from->maps, k, m + k);
    const vf3 rows[3] = {{m[0], m[1], m[2]}, {m[3], m[4], m[5]}, {m[6], m[7], m[8]}};
    g->mirrored = vbits_from_mask(vf_lt(vf3_dot(rows[0], cross3(rows[1], rows[2])), vf_set(0)));
    for (int k = 0; k < 3; k++) { /* as daft_affine_point, daft_affine_transposed and daft_normalize */
        vf3 p = {vf_load(from->corner[3 * k]), vf_load(from->corner[3 * k + 1]), vf_load(from->corner[3 * k + 2])};
        vf3 n = {vf_load(from->normal[3 * k]), vf_load(from->normal[3 * k + 1]), vf_load(from->normal[3 * k + 2])};
        g->corner[k] =
            (vf3){((m[0] * p.x + m[1] * p.y) + m[2] * p.z) + m[9], ((m[3] * p.x + m[4] * p.y) + m[5] * p.z) + m[10],
                  ((m[6] * p.x + m[7] * p.y) + m[8] * p.z) + m[11]};
        n = (vf3){(inverse[0] * n.x + inverse[3] * n.y) + inverse[6] * n.z,
                  (inverse[1] * n.x + inverse[4] * n.y) + inverse[7] * n.z,
                  (inverse[2] * n.x + inverse[5] * n.y) + inverse[8] * n.z};
        g->normal[k] = unit3(n);
    }
}

DAFT_INLINE vf3 join3(const vd3 a[2])
{
    return (vf3){vf_demote2(a[0].x, a[1].x), vf_demote2(a[0].y, a[1].y), vf_demote2(a[0].z, a[1].z)};
}

/* The plane's normal; a triangle without area has `none`. */
DAFT_INLINE void group_planes(group *g, vf3 none)
{
    vd3 outward[2];
    vd length[2], some[2];
    for (int half = 0; half < 2; half++) {
        vd3 first = half3(g->corner[0], half), a = vd3_sub(half3(g->corner[1], half), first),
            b = vd3_sub(half3(g->corner[2], half), first);
        vd3 cross = {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
        length[half] = vd_sqrt(vd3_dot(cross, cross));
        some[half] = vd_step(length[half]);
        vd scale = 1 / length[half];
        outward[half] = (vd3){cross.x * scale, cross.y * scale, cross.z * scale};
    }
    g->area = vf_demote2(length[0], length[1]);
    g->outward = select3(vf_lt(vf_set(0), vf_demote2(some[0], some[1])), join3(outward), none);
}

/* Turns the plane to the normals' side and finds whether they differ. The outer side is the normals' or, without any,
 * that from which the corners run counter-clockwise: where to_frame mirrors, the frame sees them the other way round.
 */
DAFT_INLINE void group_sides(group *g, vbits with_normals)
{
    vf zero = vf_set(0);
    vf3 sum = add3(add3(add3(set3(daft_v3(0, 0, 0)), g->normal[0]), g->normal[1]), g->normal[2]);
    vm has = vm_from_bits(with_normals);
    g->outward = flip3(g->outward, vm_and(has, vf_lt(vf3_dot(sum, g->outward), zero)));
    vbits smooth = 0;
    for (int k = 0; k < 3; k++) smooth |= vbits_from_mask(vf_lt(vf3_dot(g->normal[k], g->outward), vf_set(0.999999f)));
    g->smooth = smooth & with_normals;
    g->inner = g->mirrored & ~with_normals;
}

/* Turns all of it to the viewer's side. */
DAFT_INLINE void group_faces(group *g, const facet_rays *rays)
{
    g->height = plane_height(g->outward, g->corner[0], rays->origin);
    vm behind = vf_lt(vf_set(0), g->height);
    g->inner ^= vbits_from_mask(behind);
    g->outward = flip3(g->outward, behind);
    g->height = vf_if_then_else(behind, -g->height, g->height);
    for (int k = 0; k < 3; k++) g->normal[k] = flip3(g->normal[k], behind);
    corner_range(g->corner, rays->origin, rays->unit, &g->min, &g->max);
}

DAFT_INLINE vf3 edge_plane(vf3 a, vf3 c)
{
    vf3 d = sub3(a, c), s = add3(a, c);
    return (vf3){d.y * s.z - d.z * s.y, d.z * s.x - d.x * s.z, d.x * s.y - d.y * s.x};
}

DAFT_INLINE void put3(vf v[DAFT_FACET_FLOATS], int at, vf3 a) { v[at] = a.x, v[at + 1] = a.y, v[at + 2] = a.z; }

/* Rows beyond the end of the list may be overwritten; rows of spheres may not. */
DAFT_INLINE void store_eight(float *rows, const vf v[8], vbits lanes)
{
    int32_t row[DAFT_VL];
    if (lanes == DAFT_ALL_LANES) {
        vf_store_interleaved8(rows, DAFT_FACET_FLOATS, v);
        return;
    }
    vi_store(row, vi_iota() * vi_set(DAFT_FACET_FLOATS / 8));
    vf_scatter_rows8(rows, row, v, lanes);
}

/* Facets of rays from one place without smooth normals, texture and colours need only their first eight floats. */
static void store_group(const group *g, const stage *from, bool anywhere, float *rows)
{
    vf v[DAFT_FACET_FLOATS];
    put3(v, FACET_OUTWARD, g->outward);
    if (anywhere)
        put3(v, FACET_FIRST, g->corner[0]);
    else
        v[FACET_HEIGHT] = g->height, v[FACET_LEAST] = g->min, v[FACET_MOST] = g->max;
    v[FACET_SIZE] = vf_load(from->size);
    vi word = vi_load(from->word);
    word = vi_if_then_else(vm_from_bits(g->inner), word | vi_set(FACET_INNER), word);
    v[FACET_WORD] = (vf)vi_if_then_else(vm_from_bits(g->smooth), word | vi_set(FACET_SMOOTH), word);
    vbits lanes = ~from->spheres & DAFT_ALL_LANES;
    store_eight(rows, v, lanes);
    if (!anywhere && !((g->smooth | from->textured | from->colored) & from->triangles)) return;
    for (int k = 0; k < 3; k++) {
        if (!anywhere) put3(v, FACET_EDGE + 3 * k, edge_plane(g->corner[(k + 1) % 3], g->corner[(k + 2) % 3]));
        put3(v, FACET_NORMAL + 3 * k, g->normal[k]);
        put3(v, FACET_CORNER + 3 * k, g->corner[k]);
    }
    if (anywhere)
        for (int k = 0; k < 3; k++) put3(v, FACET_OTHERS + 3 * k, g->corner[k < 2 ? k + 1 : k]);
    v[FACET_DENSITY] = g->area; /* set_texture goes on from it */
    for (int k = FACET_UV; k < FACET_UV + 4; k++) v[k] = vf_set(0);
    for (int k = 8; k < 40; k += 8) store_eight(rows + k, v + k, lanes);
}

static void set_texture(const daft_trimesh *mesh, uint32_t triangle, float row[DAFT_FACET_FLOATS])
{
    const uint32_t *corner = &(mesh->uv_indices ? mesh->uv_indices : mesh->indices)[3 * (size_t)triangle];
    float area = row[FACET_DENSITY];
    daft_vec2 uv[3];
    for (int k = 0; k < 3; k++) {
        bool has = mesh->uvs && corner[k] != DAFT_NO_UV;
        uv[k] = has ? mesh->uvs[corner[k]] : (daft_vec2){0, 0};
        row[FACET_UV + 2 * k] = uv[k].x, row[FACET_UV + 2 * k + 1] = uv[k].y;
    }
    float ax = uv[1].x - uv[0].x, ay = uv[1].y - uv[0].y, bx = uv[2].x - uv[0].x, by = uv[2].y - uv[0].y;
    row[FACET_DENSITY] = area > 0 ? sqrtf(fabsf(ax * by - ay * bx) / area) : 0;
}

static uint32_t color_word(float linear)
{
    const float root = sqrtf(linear > 0 ? linear : 0);
    return (uint32_t)((root < 1 ? root : 1) * FACET_COLOR_MOST + 0.5f);
}

static void set_colors(const daft_trimesh *mesh, uint32_t triangle, bool fades, float row[DAFT_FACET_FLOATS])
{
    const uint32_t *corner = &(mesh->color_indices ? mesh->color_indices : mesh->indices)[3 * (size_t)triangle];
    for (int k = 0; k < 3; k++) {
        const daft_vec3 c = mesh->colors[corner[k]];
        const uint32_t word = color_word(c.x) | color_word(c.y) << 10 | color_word(c.z) << 20;
        memcpy(&row[FACET_COLOR + k], &word, sizeof word);
        if (fades) row[FACET_ALPHA + k] = mesh->alphas ? mesh->alphas[corner[k]] : 1;
    }
}

void DAFT_KERNEL(daft_facets_setup)(const daft_snapshot *snapshot, daft_facets *facets, uint32_t first, uint32_t count,
                                    const facet_rays *rays)
{
    stage from;
    group g;
    fetch_group(snapshot, facets, first, count, &from);
    if (!from.triangles) return;
    move_group(&from, &g);
    group_planes(&g, rays ? flipped3(unit3(rays->direction)) : set3(daft_v3(0, 0, 0)));
    group_sides(&g, from.with_normals);
    if (rays) group_faces(&g, rays);
    store_group(&g, &from, !rays, facets->row[first]);
    for (vbits left = from.textured; left; left &= left - 1) {
        uint32_t at = first + (uint32_t)__builtin_ctz(left);
        set_texture(snapshot->instances[facets->instance[at]].mesh, facets->triangle[at], facets->row[at]);
    }
    for (vbits left = from.colored; left; left &= left - 1) {
        uint32_t at = first + (uint32_t)__builtin_ctz(left);
        set_colors(snapshot->instances[facets->instance[at]].mesh, facets->triangle[at], facets->fades,
                   facets->row[at]);
    }
}
