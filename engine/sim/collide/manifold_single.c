/* One pair of boxes, spheres or capsules: in the first lane of the kernels that take many side by side, in a's frame.
 * So there is one way to collide them; what the kernels leave open, as cores that cross, is decided here and in
 * manifold_poly.c, which gives points the same numbers. */
#include "sim/collide/manifold_box.h"
#include "sim/collide/manifold_round.h"

/* Kernels give the same bits for every instruction set; the narrowest does least for the lanes that nobody asked for,
 * which are zero. */
enum { NARROWEST = 0 };

static daft_rigid frame_of(const daft_relpose *pose)
{
    daft_rigid out = {.p = pose->p};
    for (int i = 0; i < 9; i++) out.m[i] = (double)pose->r[i];
    return out;
}

static uint32_t take(const daft_found_lanes *found, daft_manifold *out)
{
    out->normal = daft_lane_get(found->normal, 0);
    out->count = (uint32_t)found->count[0];
    for (uint32_t i = 0; i < out->count; i++)
        out->points[i] = (daft_manifold_point){daft_lane_get(found->point[i], 0), found->separation[i][0],
                                               (uint32_t)found->id[i][0]};
    return out->count > 0;
}

/* ---- boxes ---- */

uint32_t daft_collide_boxes(daft_vec3 half_a, daft_vec3 half_b, const daft_relpose *pose, float margin,
                            daft_manifold *out, daft_pair_cache *cache)
{
    static const daft_box_kernels *const TABLE[DAFT_ISA_COUNT] = DAFT_KERNEL_TABLE(daft_box);
    daft_box_batch batch = {.posed = true};
    daft_rigid a = daft_rigid_identity(), b = frame_of(pose);
    daft_box_batch_put(&batch, 0, &a, &b, half_a, half_b);
    batch.q[0][0] = pose->q.x, batch.q[1][0] = pose->q.y, batch.q[2][0] = pose->q.z;
    batch.margin[0] = margin;
    batch.kind[0] = cache ? cache->kind : DAFT_AXIS_NONE;
    TABLE[NARROWEST]->collide(&batch, 1);
    if (cache) cache->kind = (uint8_t)batch.kind[0];
    return take(&batch.found, out);
}

/* ---- spheres and capsules ---- */

/* b as it stands in a's frame, or a itself, at the origin. */
static daft_outline outline_of(const daft_sim_shape *s, const daft_relpose *pose)
{
    daft_outline out = {.centre = pose ? pose->p : daft_dv3(0, 0, 0), .reach = s->radius, .radius = s->radius};
    if (s->type == DAFT_GEOMETRY_BOX) out.half = s->half, out.reach = daft_length(s->half);
    if (s->type != DAFT_GEOMETRY_CAPSULE) return out;
    out.half = daft_scale(pose ? daft_v3(pose->r[1], pose->r[4], pose->r[7]) : daft_v3(0, 1, 0), s->half_height);
    out.reach += s->half_height;
    return out;
}

static const daft_round_kernels *kernels(void)
{
    static const daft_round_kernels *const TABLE[DAFT_ISA_COUNT] = DAFT_KERNEL_TABLE(daft_round);
    return TABLE[NARROWEST];
}

static bool is_zero(daft_vec3 v) { return v.x == 0 && v.y == 0 && v.z == 0; }

static daft_vec3 across(daft_vec3 d)
{
    daft_vec3 axis = fabsf(d.x) <= fabsf(d.y) && fabsf(d.x) <= fabsf(d.z) ? daft_v3(1, 0, 0)
                     : fabsf(d.y) <= fabsf(d.z)                           ? daft_v3(0, 1, 0)
                                                                          : daft_v3(0, 0, 1);
    return daft_normalize(daft_cross(d, axis));
}

/* One through the other: out sideways, for spheres upwards. */
static daft_vec3 direction_out(daft_vec3 a, daft_vec3 b)
{
    daft_vec3 c = daft_cross(a, b);
    if (daft_dot(c, c) > 1e-6f * daft_dot(a, a) * daft_dot(b, b)) return daft_normalize(c);
    return !is_zero(a) ? across(a) : !is_zero(b) ? across(b) : daft_v3(0, -1, 0);
}

/* Cores so near each other that the kernel does not tell a direction. */
static uint32_t collide_crossing(const daft_outline *a, const daft_outline *b, daft_manifold *out)
{
    float s, t, rounding = a->radius + b->radius;
    daft_vec3 centre = daft_to_float(b->centre);
    daft_segments_closest(daft_neg(a->half), a->half, daft_sub(centre, b->half), daft_add(centre, b->half), &s, &t);
    daft_vec3 on_a = daft_scale(a->half, 2 * s - 1), on_b = daft_add(centre, daft_scale(b->half, 2 * t - 1));
    daft_vec3 gap = daft_sub(on_b, on_a);
    float distance = daft_length(gap);
    daft_vec3 n = distance > 1e-6f * rounding ? daft_scale(gap, 1 / distance) : direction_out(a->half, b->half);
    daft_vec3 middle = daft_scale(daft_add(on_a, on_b), 0.5f);
    out->normal = n, out->count = 1;
    out->points[0] = (daft_manifold_point){daft_add(middle, daft_scale(n, 0.5f * (a->radius - b->radius))),
                                           daft_dot(n, gap) - rounding, 2};
    return 1;
}

uint32_t daft_collide_rounds(const daft_sim_shape *a, const daft_sim_shape *b, const daft_relpose *pose, float margin,
                             daft_manifold *out)
{
    const daft_outline outlines[2] = {outline_of(a, NULL), outline_of(b, pose)};
    daft_round_batch batch = {0};
    daft_round_batch_put(&batch, 0, outlines, 0, 1, margin);
    kernels()->rounds(outlines, &batch, 1);
    if (batch.state[0] == DAFT_ROUND_ASK) return collide_crossing(&outlines[0], &outlines[1], out);
    return batch.state[0] == DAFT_ROUND_MET ? take(&batch.found, out) : 0;
}

bool daft_collide_round_box(const daft_sim_shape *a, const daft_sim_shape *b, const daft_relpose *pose, float margin,
                            daft_manifold *out, uint32_t *count)
{
    const daft_outline outlines[2] = {outline_of(a, NULL), outline_of(b, pose)};
    bool box_first = a->type == DAFT_GEOMETRY_BOX;
    daft_rigid turn = box_first ? daft_rigid_identity() : frame_of(pose);
    daft_round_batch batch = {0};
    daft_round_batch_put(&batch, 0, outlines, 0, 1, margin);
    daft_round_batch_put_box(&batch, 0, outlines, box_first ? pose->p : pose->q, turn.m, box_first);
    kernels()->boxes(outlines, &batch, 1);
    *count = batch.state[0] == DAFT_ROUND_MET ? take(&batch.found, out) : 0;
    return batch.state[0] != DAFT_ROUND_ASK;
}
