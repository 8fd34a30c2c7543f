/* A mesh by patches, clusters and groups: each triangle once, with its own corners, all of it in every ball and ellipsoid around it,
 * and what is said to look away does, by every triangle. */
#include "fixtures.h"

#include "accel/sides.h"
#include "geometry/adjacency.h"
#include "geometry/trimesh.h"

static daft_dvec3 middle_of(const daft_patches *p, uint32_t level, uint32_t item)
{
    return daft_dadd(daft_to_double(p->low), daft_dscale(daft_outline_middle(&p->level[level], item), (double)p->unit));
}

/* In units. */
static double radius_of(const daft_patches *p, uint32_t level, uint32_t item)
{
    return (double)p->level[level].items[item / DAFT_PATCH].ball[3][item % DAFT_PATCH];
}

static daft_dvec3 corner_of(const daft_patch *p, int corner, uint32_t triangle)
{
    uint32_t at = p->at[corner][triangle];
    return daft_dv3((double)p->corner[0][at], (double)p->corner[1][at], (double)p->corner[2][at]);
}

/* Each triangle in one patch, its corners those of the mesh, bit for bit and in their order; bits as they were given. */
static void check_triangles(const fixture_mesh *m, const daft_patches *all, const uint32_t *one_sided)
{
    uint8_t *seen = calloc(m->mesh.triangle_count, 1);
    uint32_t count = 0;
    for (uint32_t i = 0; i < all->level[0].count * DAFT_PATCH; i++) {
        const daft_patch *p = &all->items[i / DAFT_PATCH];
        uint32_t t = i % DAFT_PATCH, triangle = p->triangle[t];
        assert_int_equal(p->there >> t & 1, triangle != DAFT_NO_TRIANGLE);
        if (triangle == DAFT_NO_TRIANGLE) {
            assert_true(t > 0 && !(p->there >> t) && !(p->one_sided >> t));
            continue;
        }
        assert_true(triangle < m->mesh.triangle_count && !seen[triangle]);
        assert_int_equal(p->one_sided >> t & 1, one_sided[triangle / 32] >> (triangle % 32) & 1);
        for (int k = 0; k < 3; k++) {
            uint32_t vertex = m->mesh.indices[3 * (size_t)triangle + (uint32_t)k], at = p->at[k][t];
            const float from[3] = {m->mesh.x[vertex], m->mesh.y[vertex], m->mesh.z[vertex]}, to[3] = {p->corner[0][at], p->corner[1][at], p->corner[2][at]};
            assert_memory_equal(from, to, sizeof from);
        }
        for (int k = 0; k < 3; k++) {
            daft_dvec3 d = daft_dsub(corner_of(p, k, t), corner_of(p, (k + 1) % 3, t));
            assert_true(daft_ddot(d, d) <= (double)p->edge * (double)p->edge && p->edge <= all->edge);
        }
        seen[triangle] = 1, count++;
    }
    assert_int_equal(count, m->mesh.triangle_count);
    free(seen);
}

/* Gives the largest distance from the ball's middle over its radius, less what is rounded up. */
static double check_ball(const daft_patches *all, uint32_t level, uint32_t item, uint32_t first, uint32_t end)
{
    double most = 0, radius = radius_of(all, level, item) * (double)all->unit;
    for (uint32_t i = first * DAFT_PATCH; i < end * DAFT_PATCH; i++) {
        const daft_patch *p = &all->items[i / DAFT_PATCH];
        if (!(p->there >> (i % DAFT_PATCH) & 1)) continue;
        for (int k = 0; k < 3; k++) {
            daft_dvec3 d = daft_dsub(corner_of(p, k, i % DAFT_PATCH), middle_of(all, level, item));
            most = fmax(most, sqrt(daft_ddot(d, d)));
        }
    }
    assert_true(most <= radius);
    return radius - 2 * (double)all->unit > 0 ? most / (radius - 2 * (double)all->unit) : 1;
}

/* x·M⁻¹·x <= 1 for each corner: M - x·xᵀ has no negative minor. Gives the trace over the radius squared. */
static double check_shape(const daft_patches *all, uint32_t patch)
{
    double m[DAFT_SHAPE], radius = radius_of(all, 0, patch), cut = (double)all->unit;
    for (int k = 0; k < DAFT_SHAPE; k++) m[k] = (double)all->shapes[patch / DAFT_PATCH].m[k][patch % DAFT_PATCH];
    double xx = m[1] * m[2] - m[5] * m[5], xy = m[4] * m[5] - m[3] * m[2], xz = m[3] * m[5] - m[1] * m[4];
    double yy = m[0] * m[2] - m[4] * m[4], zz = m[0] * m[1] - m[3] * m[3], yz = m[3] * m[4] - m[0] * m[5], det = m[0] * xx + m[3] * xy + m[4] * xz;
    const daft_patch *p = &all->items[patch];
    for (uint32_t i = 0; i < DAFT_PATCH; i++) {
        if (!(p->there >> i & 1)) continue;
        for (int k = 0; k < 3; k++) {
            daft_dvec3 d = daft_dscale(daft_dsub(corner_of(p, k, i), middle_of(all, 0, patch)), 1 / cut);
            double form = xx * d.x * d.x + yy * d.y * d.y + zz * d.z * d.z + 2 * (xy * d.x * d.y + xz * d.x * d.z + yz * d.y * d.z);
            assert_true(form <= det);
        }
    }
    return (m[0] + m[1] + m[2]) / (radius * radius);
}

/* Gives how many triangles there are to a patch. */
static double check_patches(const fixture_mesh *m)
{
    daft_allocator allocator = daft_malloc_allocator();
    daft_adjacency adjacency;
    daft_patches all;
    uint32_t *one_sided = malloc((m->mesh.triangle_count + 31) / 32 * sizeof *one_sided), each = 1;
    for (uint32_t i = 0; i < (m->mesh.triangle_count + 31) / 32; i++) one_sided[i] = random_bits();
    assert_true(daft_adjacency_make(&allocator, &m->mesh, &adjacency));
    assert_true(daft_patches_make(m->bvh, &m->mesh, &adjacency, one_sided, &all));
    check_triangles(m, &all, one_sided);
    uint32_t count = all.level[0].count;
    for (uint32_t level = 0; level < DAFT_PATCH_LEVELS; level++, each *= DAFT_PATCH) {
        assert_int_equal(all.level[level].count, (count + each - 1) / each);
        for (uint32_t i = 0; i < all.level[level].count; i++) {
            double full = check_ball(&all, level, i, i * each, daft_min_u((i + 1) * each, count));
            if (level == 0) assert_true(full > 0.99 && radius_of(&all, 0, i) <= (double)all.radius);
        }
    }
    for (uint32_t i = 0; i < count; i++) assert_true(check_shape(&all, i) < 4);
    free(one_sided);
    daft_patches_free(&allocator, &all);
    daft_adjacency_free(&allocator, &adjacency);
    return (double)m->mesh.triangle_count / count;
}

static void whole(void **unused)
{
    (void)unused;
    fixture_seed(5);
    const float scales[] = {1, 1e-30f, 1e30f, 1};
    for (int round = 0; round < 16; round++) {
        fixture_mesh m = round == 0 ? mesh_soup(1, 1, 1) : round & 1 ? mesh_soup(20u * (uint32_t)round, 3, 0.1f) : mesh_ball(4u + 6u * (uint32_t)round, 1, 0.3f);
        float scale = scales[round % 4], move = round % 4 == 3 ? 1000 : 0;
        for (uint32_t v = 0; v < m.mesh.vertex_count; v++)
            m.mesh.x[v] = m.mesh.x[v] * scale + move, m.mesh.y[v] *= scale, m.mesh.z[v] *= scale;
        daft_trimesh_set_bounds(&m.mesh);
        daft_allocator allocator = daft_malloc_allocator();
        daft_bvh_free(m.bvh);
        m.bvh = daft_bvh_build_mesh(&allocator, &m.mesh, 1, NULL);
        double triangles = check_patches(&m);
        if (!(round & 1) && round) assert_true(triangles > 12);
        mesh_drop(&m);
    }
}

/* ---- looks ---- */

/* All triangles of patches are one-sided and seen from behind. `eye`, w as in an outlook. */
static void check_away(const fixture_mesh *m, uint32_t first, uint32_t end, daft_dvec3 eye, double w)
{
    for (uint32_t i = first * DAFT_PATCH; i < end * DAFT_PATCH; i++) {
        const daft_patch *patch = &m->bvh->sides->patches.items[i / DAFT_PATCH];
        uint32_t t = i % DAFT_PATCH;
        if (!(patch->there >> t & 1)) continue;
        assert_true(patch->one_sided >> t & 1 && daft_is_one_sided(m->bvh->sides, patch->triangle[t]));
        daft_dvec3 p = corner_of(patch, 0, t), q = daft_dsub(corner_of(patch, 1, t), p), r = daft_dsub(corner_of(patch, 2, t), p);
        assert_true(daft_ddot(daft_dcross(q, r), daft_dsub(eye, daft_dscale(p, w))) < 0);
    }
}

/* By the bytes of which it is made. */
static bool looks_away(const daft_outlines *o, uint32_t lane, const daft_glance *g)
{
    uint32_t look = 0;
    for (int k = 0; k < 4; k++) {
        int8_t byte = (int8_t)o->look[k][lane];
        assert_true((float)byte == o->look[k][lane]);
        look |= (uint32_t)(uint8_t)byte << 8 * k;
    }
    return daft_looks_away(look, o->spread[lane], g);
}

static void looks(void **unused)
{
    (void)unused;
    fixture_seed(6);
    fixture_mesh m = mesh_ball(60, 1, 0.002f);
    assert_true(daft_bvh_find_sides(m.bvh, &m.mesh, 1));
    const daft_patches *all = &m.bvh->sides->patches;
    uint32_t away[DAFT_PATCH_LEVELS] = {0};
    for (int round = 0; round < 100; round++) {
        daft_dvec3 eye = daft_to_double(random_vec3(-1, 1));
        bool sun = !(round & 1);
        eye = daft_dscale(eye, (sun ? 1 : (double)random_float(2, 40)) / sqrt(daft_ddot(eye, eye)));
        daft_outlook outlook = daft_outlook_along(eye, 0);
        if (!sun && !daft_outlook_at(m.bvh, &m.mesh, eye, 0, &outlook)) continue;
        daft_glance g = daft_glance_of(m.bvh->sides, &outlook);
        for (uint32_t level = 0, each = 1; level < DAFT_PATCH_LEVELS; level++, each *= DAFT_PATCH)
            for (uint32_t i = 0; i < all->level[level].count; i++) {
                if (!looks_away(&all->level[level].items[i / DAFT_PATCH], i % DAFT_PATCH, &g)) continue;
                check_away(&m, i * each, daft_min_u((i + 1) * each, all->level[0].count), eye, sun ? 0 : 1);
                away[level]++;
            }
    }
    assert_true(away[0] > 100 * all->level[0].count / 4 && away[1] > 100 * all->level[1].count / 8);
    mesh_drop(&m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(whole), cmocka_unit_test(looks)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
