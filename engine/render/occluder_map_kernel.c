/* The shadow pencil's meshes: how an instance's space lies to the lamp's, and which points' ways to the lamp meet the mesh's bounds
 * there. */
#include "accel/open.h"
#include "render/occluder.h"

/* One instruction each, where fmaxf and fminf are calls; of NaN and a number, the second. */
static inline float larger(float a, float b) { return a > b ? a : b; }
static inline float smaller(float a, float b) { return a < b ? a : b; }

/* Light space to the thing's own. With u = 2^-24, s the size of what points and corners are in light space and f the largest
 * share of the way to the lamp that a box reaches: places are off by some 8u of |map|·s and of the translation, ways by that
 * and 8u of |map|·f·away; corners that a test in light space takes for met by no more than 16u of the first. Their sum is
 * below 2^-18. */
static void set_back(const caster *c, daft_affine *back, float pad[3])
{
    const light *l = c->light;
    const daft_instance *s = c->instance;
    const float *o = s->to_object.m, *r = l->map.m, at[3] = {l->origin.x, l->origin.y, l->origin.z};
    float size = 0, share;
    for (int k = 0; k < 3; k++) size += larger(fabsf((&s->low.x)[k] - at[k]), fabsf((&s->high.x)[k] - at[k]));
    size = 2 * size + l->size;
    share = smaller(2 * size / (l->near + l->away), 1);
    if (!l->sun && share > 0) size += share * l->away;
    for (int i = 0; i < 3; i++) {
        const float *a = &o[3 * i], x = a[0] * at[0], y = a[1] * at[1], z = a[2] * at[2], t = s->to_object.t[i];
        float reach = fabsf(a[0]) + fabsf(a[1]) + fabsf(a[2]), still = fabsf(x) + fabsf(y) + fabsf(z) + fabsf(t);
        for (int j = 0; j < 3; j++) back->m[3 * i + j] = a[0] * r[3 * j] + a[1] * r[3 * j + 1] + a[2] * r[3 * j + 2];
        back->t[i] = x + y + z + t;
        pad[i] = (reach * 2 * size + still) * 0x1p-18f;
    }
}

/* What corners' boxes are off by, from all that the mesh reaches in light space, where that is not much more than its distance from
 * the lamp: depths by a few 2^-24 of it; places in the picture, which are no larger than it over the distance, by that over the
 * distance, by themselves times that, and by 2^-21 of themselves. */
static void set_errors(mesh_caster *m)
{
    const light *l = m->c.light;
    const float *low = &m->c.instance->mesh->low.x, *high = &m->c.instance->mesh->high.x, *depth = &m->map.map.m[6];
    float size = m->map.still, near = m->map.map.t[2] + l->away;
    for (int k = 0; k < 3; k++) {
        size += m->map.reach[k] * larger(fabsf(low[k]), fabsf(high[k]));
        near += smaller(depth[k] * low[k], depth[k] * high[k]);
    }
    m->before = size < 1e30f && (l->sun || near > 0.125f * (size + l->away * 0x1p-10f)); /* not where large numbers have made it NaN */
    m->off_depth = size * 0x1p-20f, m->off_uv = l->sun ? m->off_depth : m->off_depth / near * (2 + size / near);
}

void DAFT_KERNEL(daft_mesh_caster_make)(const caster *c, mesh_caster *out)
{
    const daft_affine map = DAFT_KERNEL(daft_light_compose)(&c->light->map, &c->instance->to_frame, c->light->origin);
    out->c = *c;
    out->map = picture_map_make(&map), out->size = out->map.still;
    set_errors(out);
    set_back(c, &out->back, out->pad);
}

/* Whether the map to frame space keeps angles, but for rounding. */
static bool is_even(const daft_affine *a)
{
    const float *m = a->m;
    float sums[6], most = 0, least = INFINITY;
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3;
        sums[i] = m[i] * m[i] + m[3 + i] * m[3 + i] + m[6 + i] * m[6 + i];
        sums[3 + i] = fabsf(m[i] * m[j] + m[3 + i] * m[3 + j] + m[6 + i] * m[6 + j]);
        most = larger(most, sums[i]), least = smaller(least, sums[i]);
    }
    return larger(most - least, larger(sums[3], larger(sums[4], sums[5]))) <= 0x1p-16f * least;
}

/* The free ways off the mesh's triangles, where they hold for the caster's points: NULL where they do not. Points are lifted by 2^-20 of what
 * there is in coordinates, and twice that bounds all that they may be beside their triangles by. */
static const daft_open *open_ways(const caster *c)
{
    const daft_instance *s = c->instance;
    const daft_open *open = s->bvh->open;
    const float *t = s->to_frame.t, *o = s->to_object.m;
    if (!open || open->normals != s->mesh->normals || !is_even(&s->to_frame)) return NULL;
    float size = c->light->reach + fabsf(t[0]) + fabsf(t[1]) + fabsf(t[2]), scale = sqrtf(o[0] * o[0] + o[1] * o[1] + o[2] * o[2]);
    return size * scale * 0x1p-19f <= open->margin ? open : NULL;
}

/* The bits of the DAFT_VL points from `at` on that lie on the mesh and whose ways, in its own space, leave it freely. */
DAFT_INLINE vbits leave_freely(const caster *c, const daft_open *open, const vf way[3], uint32_t at)
{
    vi own = vi_load(&c->points->own[at]);
    vbits on = vbits_from_mask(vi_eq(vi_load(&c->points->instance[at]), vi_set((int32_t)c->number)));
    on &= ~vbits_from_mask(vi_eq(own, vi_set((int32_t)DAFT_NO_TRIANGLE)));
    if (!on) return 0;
    vi cone = vi_gather_index(open->cone, vi_if_then_else(vm_from_bits(on), own, vi_set(0)));
    vf x = vf_convert_to((cone << 24) >> 24), y = vf_convert_to((cone << 16) >> 24), z = vf_convert_to((cone << 8) >> 24);
    vf least = vf_convert_to(cone >> 24), along = x * way[0] + y * way[1] + z * way[2];
    vf length = vf_sqrt(way[0] * way[0] + way[1] * way[1] + way[2] * way[2]);
    return on & vbits_from_mask(vm_and(vf_lt(vf_set(0), least), vf_le(least * length, along)));
}

/* A mesh's bounds, grown by what places and ways are off by there, and which ways leave it freely. */
typedef struct mesh_bounds {
    daft_affine back;
    float low[3], high[3];
    const daft_open *open; /* of blocks with points of the mesh */
} mesh_bounds;

/* The bits of the DAFT_VL points from `at` on whose ways to the lamp meet the bounds; without those on it that leave it `freely`. */
DAFT_INLINE vbits ways_meet(const caster *c, const mesh_bounds *mesh, uint32_t at, vbits *freely)
{
    const shadow_points *p = c->points;
    const float *b = mesh->back.m, *t = mesh->back.t;
    vf x = vf_load(&p->x[at]), y = vf_load(&p->y[at]), z = vf_load(&p->depth[at]), way[3];
    vf near = vf_set(0), far = vf_set(c->light->sun ? INFINITY : 1.00001f);
    for (int k = 0; k < 3; k++) {
        vf across = vf_set(b[3 * k]) * x + vf_set(b[3 * k + 1]) * y, from = across + vf_set(b[3 * k + 2]) * z + vf_set(t[k]);
        way[k] = c->light->sun ? vf_set(-b[3 * k + 2]) : -(across + vf_set(b[3 * k + 2]) * (z + vf_set(c->light->away)));
        vf inverse = way_inverse(way[k]);
        vf to_low = (vf_set(mesh->low[k]) - from) * inverse, to_high = (vf_set(mesh->high[k]) - from) * inverse;
        near = vf_max(vf_min(to_low, to_high), near), far = vf_min(vf_max(to_low, to_high), far);
    }
    *freely = mesh->open ? leave_freely(c, mesh->open, way, at) : 0;
    return vbits_from_mask(vf_le(near, far * vf_set(1 + 0x1p-20f)));
}

/* The bits of the block's points `in` whose ways meet the bounds, and in `freely` those that leave the mesh freely. */
DAFT_INLINE uint32_t block_meets(const caster *c, const mesh_bounds *mesh, uint32_t b, uint32_t in, uint32_t *freely)
{
    uint32_t meet = 0;
    *freely = 0;
    for (uint32_t k = 0; k < SHADOW_BLOCK; k += DAFT_VL) {
        vbits leave, some = ways_meet(c, mesh, b * SHADOW_BLOCK + k, &leave);
        if (c->convex || c->flat) some &= ~lie_on(c, DAFT_NO_TRIANGLE, b * SHADOW_BLOCK + k);
        meet |= some << k, *freely |= leave << k;
    }
    return meet & in;
}

static void set_bounds(const caster *c, bool own, mesh_bounds *out)
{
    const daft_trimesh *mesh = c->instance->mesh;
    float pad[3];
    set_back(c, &out->back, pad);
    for (int k = 0; k < 3; k++) out->low[k] = (&mesh->low.x)[k] - pad[k], out->high[k] = (&mesh->high.x)[k] + pad[k];
    out->open = own ? open_ways(c) : NULL;
}

uint32_t DAFT_KERNEL(daft_mesh_ways)(const caster *c, const picture_box *box, const block_set *behind, block_points *out)
{
    mesh_bounds bounds;
    uint32_t some = 0, count = 0;
    bool own = false;
    for (uint32_t word = 0; word < DAFT_COUNT_OF(behind->bits); word++)
        for (uint64_t left = behind->bits[word]; left; left &= left - 1) {
            uint32_t b = word * 64 + (uint32_t)__builtin_ctzll(left);
            out[some] = (block_points){b, points_behind(box, c->points, b)};
            own |= out[some].points && (c->points->on[b] == c->number || c->points->on[b] == DAFT_NOTHING);
            some += out[some].points != 0;
        }
    if (!some) return 0;
    set_bounds(c, own, &bounds);
    for (uint32_t i = 0; i < some; i++) {
        uint32_t b = out[i].block, freely, in = block_meets(c, &bounds, b, out[i].points, &freely);
        c->points->under[b] |= in;
        out[count] = (block_points){b, in & ~freely};
        count += out[count].points != 0;
    }
    return count;
}
