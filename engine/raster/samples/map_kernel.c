/* An occluder's transform from view space to its own space and back, with the error bounds of both, and the test of
 * which points' shadow rays meet the mesh's bounds. */
#include "raster/samples/setup.h"

/* One instruction each, where fmaxf and fminf are calls; of NaN and a number, the second. */
static inline float larger(float a, float b) { return a > b ? a : b; }
static inline float smaller(float a, float b) { return a < b ? a : b; }

/* View space to the instance's own. With u = 2^-24, s the size of what points and corners are in view space and f the
 * largest share of the direction to the light that a box reaches: places are off by some 8u of |map|·s and of the
 * translation, rays by that and 8u of |map|·f·away; corners that a test in view space takes for met by no more than 16u
 * of the first. Their sum is below 2^-18. */
static void set_back(const occluder *c, daft_affine *back, float pad[3])
{
    const light_view *l = c->view;
    const daft_instance *s = c->instance;
    const float *o = s->to_object.m, *r = (&l->pencil.right.x),
                at[3] = {l->pencil.origin.x, l->pencil.origin.y, l->pencil.origin.z};
    float size = 0, share;
    for (int k = 0; k < 3; k++)
        size += larger(fabsf(daft_v3_at(s->low, k) - at[k]), fabsf(daft_v3_at(s->high, k) - at[k]));
    size = 2 * size + l->size;
    share = smaller(2 * size / (l->near + l->pencil.away), 1);
    if (!l->pencil.parallel && share > 0) size += share * l->pencil.away;
    for (int i = 0; i < 3; i++) {
        const float *a = &o[3 * i], x = a[0] * at[0], y = a[1] * at[1], z = a[2] * at[2], t = s->to_object.t[i];
        float reach = fabsf(a[0]) + fabsf(a[1]) + fabsf(a[2]), still = fabsf(x) + fabsf(y) + fabsf(z) + fabsf(t);
        for (int j = 0; j < 3; j++) back->m[3 * i + j] = a[0] * r[3 * j] + a[1] * r[3 * j + 1] + a[2] * r[3 * j + 2];
        back->t[i] = x + y + z + t;
        pad[i] = (reach * 2 * size + still) * 0x1p-18f;
    }
}

/* What corners' boxes are off by, from all that the mesh reaches in view space, where that is not much more than its
 * distance from the light: depths by a few 2^-24 of it; places in the picture, which are no larger than it over the
 * distance, by that over the distance, by themselves times that, and by 2^-21 of themselves. */
static void set_errors(mesh_occluder *m)
{
    const light_view *l = m->c.view;
    const daft_vec3 from = m->c.instance->mesh->low, until = m->c.instance->mesh->high;
    const float low[3] = {from.x, from.y, from.z}, high[3] = {until.x, until.y, until.z}, *depth = &m->map.map.m[6];
    float size = m->map.size, near = m->map.map.t[2] + l->pencil.away;
    for (int k = 0; k < 3; k++) near += smaller(depth[k] * low[k], depth[k] * high[k]);
    m->before = size < 1e30f &&
                (l->pencil.parallel || near > 0.125f * (size + l->pencil.away * 0x1p-10f)); /* not where large numbers
                                                                                               have made it NaN */
    m->off_depth = size * 0x1p-20f,
    m->off_uv = l->pencil.parallel ? m->off_depth : m->off_depth / near * (2 + size / near);
}

void DAFT_KERNEL(daft_mesh_occluder_make)(const occluder *c, mesh_occluder *out)
{
    const daft_affine map = daft_pencil_map(&c->view->pencil, &c->instance->to_frame);
    out->c = *c;
    const daft_vec3 from = c->instance->mesh->low, until = c->instance->mesh->high;
    const float max[3] = {larger(fabsf(from.x), fabsf(until.x)), larger(fabsf(from.y), fabsf(until.y)),
                          larger(fabsf(from.z), fabsf(until.z))};
    out->map = picture_map_make(c->view, &map, max), out->size = out->map.still;
    set_errors(out);
    set_back(c, &out->back, out->pad);
}

/* A mesh's bounds, grown by what places and rays are off by there. */
typedef struct mesh_bounds {
    daft_affine back;
    float low[3], high[3];
} mesh_bounds;

/* The bits of the DAFT_VL points from `at` on whose rays to the light meet the bounds. */
DAFT_INLINE vbits rays_meet_bounds(const occluder *c, const mesh_bounds *mesh, uint32_t at)
{
    const shadow_points *p = c->points;
    const float *b = mesh->back.m, *t = mesh->back.t;
    vf x = vf_load(&p->x[at]), y = vf_load(&p->y[at]), z = vf_load(&p->depth[at]);
    vf near = vf_set(0), far = vf_set(c->view->pencil.parallel ? INFINITY : 1.00001f);
    for (int k = 0; k < 3; k++) {
        vf across = vf_set(b[3 * k]) * x + vf_set(b[3 * k + 1]) * y,
           from = across + vf_set(b[3 * k + 2]) * z + vf_set(t[k]);
        vf direction = c->view->pencil.parallel ? vf_set(-b[3 * k + 2])
                                                : -(across + vf_set(b[3 * k + 2]) * (z + vf_set(c->view->pencil.away)));
        vf inverse = inverse_of(direction);
        vf to_low = (vf_set(mesh->low[k]) - from) * inverse, to_high = (vf_set(mesh->high[k]) - from) * inverse;
        near = vf_max(vf_min(to_low, to_high), near), far = vf_min(vf_max(to_low, to_high), far);
    }
    return vbits_from_mask(vf_le(near, far * vf_set(1 + 0x1p-20f)));
}

/* The bits of the block's points `in` whose rays meet the bounds. */
DAFT_INLINE uint32_t block_meets(const occluder *c, const mesh_bounds *mesh, uint32_t b, uint32_t in)
{
    uint32_t meet = 0;
    for (uint32_t k = 0; k < SHADOW_BLOCK; k += DAFT_VL) {
        vbits some = rays_meet_bounds(c, mesh, b * SHADOW_BLOCK + k);
        if (c->convex || c->flat) some &= ~lie_on(c, DAFT_NO_TRIANGLE, b * SHADOW_BLOCK + k);
        meet |= some << k;
    }
    return meet & in;
}

static void set_bounds(const occluder *c, mesh_bounds *out)
{
    const daft_trimesh *mesh = c->instance->mesh;
    float pad[3];
    set_back(c, &out->back, pad);
    for (int k = 0; k < 3; k++)
        out->low[k] = daft_v3_at(mesh->low, k) - pad[k], out->high[k] = daft_v3_at(mesh->high, k) + pad[k];
}

uint32_t DAFT_KERNEL(daft_mesh_candidates)(const occluder *c, const picture_box *box, const block_set *behind,
                                           block_points *out)
{
    mesh_bounds bounds;
    uint32_t some = 0, count = 0;
    for (uint32_t word = 0; word < DAFT_COUNT_OF(behind->bits); word++)
        for (uint64_t left = behind->bits[word]; left; left &= left - 1) {
            uint32_t b = word * 64 + (uint32_t)__builtin_ctzll(left);
            out[some] = (block_points){b, points_behind(box, c->points, b)};
            some += out[some].points != 0;
        }
    if (!some) return 0;
    set_bounds(c, &bounds);
    for (uint32_t i = 0; i < some; i++) {
        uint32_t b = out[i].block, in = block_meets(c, &bounds, b, out[i].points);
        c->points->under[b] |= in;
        out[count] = (block_points){b, in};
        count += in != 0;
    }
    return count;
}
