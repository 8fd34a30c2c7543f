/* A tree's leaves by clusters and groups of these: each leaf once, all of it in every ball around it, and what is said to look
 * away does, by every triangle. */
#include "fixtures.h"

#include "accel/sides.h"

static daft_dvec3 middle_of(const daft_balls *balls, const daft_ball *ball)
{
    daft_dvec3 at = daft_dv3(ball->centre[0], ball->centre[1], ball->centre[2]);
    return daft_dadd(daft_to_double(balls->low), daft_dscale(at, (double)balls->unit));
}

static daft_dvec3 corner_of(const daft_block *block, int corner, uint32_t lane)
{
    const float(*c)[DAFT_BLOCK] = block->corner[corner];
    return daft_dv3((double)c[0][lane], (double)c[1][lane], (double)c[2][lane]);
}

/* Gives the largest distance from the ball's middle over its radius. */
static double check_ball(const daft_bvh *bvh, const daft_balls *balls, const daft_ball *ball, uint32_t first, uint32_t end)
{
    double most = 0, radius = ball->radius * (double)balls->unit;
    for (uint32_t b = first; b < end; b++)
        for (uint32_t i = 0; i < 3 * DAFT_BLOCK; i++) {
            daft_dvec3 d = daft_dsub(corner_of(&bvh->blocks[b], (int)(i / DAFT_BLOCK), i % DAFT_BLOCK), middle_of(balls, ball));
            most = fmax(most, sqrt(daft_ddot(d, d)));
        }
    assert_true(most <= radius);
    return radius - 2 * (double)balls->unit > 0 ? most / (radius - 2 * (double)balls->unit) : 1;
}

/* Leaves in the order of their blocks, which make up all; balls around leaves, clusters and groups. */
static void check_clusters(const daft_bvh *bvh, const daft_balls *balls, const daft_clusters *c)
{
    uint32_t next = 0, leaves = 0;
    for (uint32_t i = 0; i < c->all.count; i++) {
        const daft_cluster *cluster = &c->items[i];
        assert_int_equal(c->all.first[i], next);
        assert_true(cluster->leaf[0] != DAFT_CHILD_NONE);
        for (int k = 0; k < DAFT_CLUSTER_LEAVES; k++) {
            uint32_t leaf = cluster->leaf[k], first = (leaf & ~DAFT_CHILD_LEAF) >> 2;
            if (leaf == DAFT_CHILD_NONE) continue;
            assert_true(leaf & DAFT_CHILD_LEAF && first == next);
            next += (leaf & 3) + 1, leaves++;
            assert_true(check_ball(bvh, balls, &cluster->ball[k], first, next) > 0.99);
        }
        check_ball(bvh, balls, &c->all.balls[i], c->all.first[i], next);
    }
    assert_int_equal(next, bvh->block_count);
    assert_int_equal(c->all.first[c->all.count], next);
    assert_true(leaves >= 4 * (c->all.count - 1)); /* half full at least, on average */
    assert_int_equal(c->groups.count, (c->all.count + DAFT_CLUSTER_GROUP - 1) / DAFT_CLUSTER_GROUP);
    for (uint32_t i = 0; i < c->groups.count; i++) {
        assert_int_equal(c->groups.first[i], c->all.first[i * DAFT_CLUSTER_GROUP]);
        check_ball(bvh, balls, &c->groups.balls[i], c->groups.first[i], c->groups.first[i + 1]);
    }
    assert_int_equal(c->groups.first[c->groups.count], next);
}

static void whole(void **unused)
{
    (void)unused;
    fixture_seed(5);
    daft_allocator allocator = daft_malloc_allocator();
    for (int round = 0; round < 12; round++) {
        fixture_mesh m = round == 0 ? mesh_soup(1, 1, 1) : round & 1 ? mesh_soup(40u << round, 3, 0.1f) : mesh_ball(4u + 10u * (uint32_t)round, 1, 0.3f);
        daft_balls balls;
        daft_clusters clusters;
        assert_true(daft_balls_make(m.bvh, &m.mesh, &balls) && daft_clusters_make(m.bvh, &balls, &clusters));
        check_clusters(m.bvh, &balls, &clusters);
        daft_clusters_free(&allocator, &clusters);
        daft_release(&allocator, balls.items);
        mesh_drop(&m);
    }
}

/* ---- looks ---- */

/* All triangles of blocks are one-sided and seen from behind. `eye`, w as in an outlook. */
static void check_away(const fixture_mesh *m, uint32_t first, uint32_t end, daft_dvec3 eye, double w)
{
    for (uint32_t b = first; b < end; b++)
        for (uint32_t i = 0; i < DAFT_BLOCK; i++) {
            const daft_block *block = &m->bvh->blocks[b];
            if (block->triangle[i] == DAFT_NO_TRIANGLE) continue;
            assert_true(daft_is_one_sided(m->bvh->sides, block->triangle[i]));
            daft_dvec3 p = corner_of(block, 0, i), q = daft_dsub(corner_of(block, 1, i), p), r = daft_dsub(corner_of(block, 2, i), p);
            assert_true(daft_ddot(daft_dcross(q, r), daft_dsub(eye, daft_dscale(p, w))) < 0);
        }
}

static uint32_t check_outlines(const fixture_mesh *m, const daft_outlines *o, const daft_glance *g, daft_dvec3 eye, double w)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < o->count; i++) {
        if (!daft_looks_away(o->looks[i], o->spreads[i], g)) continue;
        check_away(m, o->first[i], o->first[i + 1], eye, w);
        count++;
    }
    return count;
}

static void looks(void **unused)
{
    (void)unused;
    fixture_seed(6);
    fixture_mesh m = mesh_ball(60, 1, 0.002f);
    assert_true(daft_bvh_find_sides(m.bvh, &m.mesh, 1));
    const daft_clusters *c = &m.bvh->sides->clusters;
    uint32_t leaves = 0, clusters = 0;
    for (int round = 0; round < 100; round++) {
        daft_dvec3 eye = daft_to_double(random_vec3(-1, 1));
        bool sun = !(round & 1);
        eye = daft_dscale(eye, (sun ? 1 : (double)random_float(2, 40)) / sqrt(daft_ddot(eye, eye)));
        daft_outlook outlook = daft_outlook_along(eye, 0);
        if (!sun && !daft_outlook_at(m.bvh, &m.mesh, eye, 0, &outlook)) continue;
        daft_glance g = daft_glance_of(m.bvh->sides, &outlook);
        clusters += check_outlines(&m, &c->all, &g, eye, sun ? 0 : 1);
        check_outlines(&m, &c->groups, &g, eye, sun ? 0 : 1);
        for (uint32_t i = 0; i < c->all.count * DAFT_CLUSTER_LEAVES; i++) {
            const daft_cluster *cluster = &c->items[i / DAFT_CLUSTER_LEAVES];
            uint32_t k = i % DAFT_CLUSTER_LEAVES, block = (cluster->leaf[k] & ~DAFT_CHILD_LEAF) >> 2;
            if (cluster->leaf[k] == DAFT_CHILD_NONE || !daft_looks_away(cluster->look[k], cluster->spread[k], &g)) continue;
            check_away(&m, block, block + (cluster->leaf[k] & 3) + 1, eye, sun ? 0 : 1);
            leaves++;
        }
    }
    assert_true(leaves > 100 * c->all.count * DAFT_CLUSTER_LEAVES / 8 && clusters > 100 * c->all.count / 8);
    mesh_drop(&m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(whole), cmocka_unit_test(looks)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
