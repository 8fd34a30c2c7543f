/* Transforms: composed in double, interpolated between two ticks, resolved up the hierarchy without recursion. */
#include "scene/scene.h"

bool daft_scale_is_uniform(daft_vec3 scale) { return scale.x == scale.y && scale.y == scale.z; }

/* A float quaternion is unit only to 1e-7; the matrix of the normalised one is a rotation to double's precision. */
static void rotation_matrix(daft_quat q, double m[9])
{
    double x = (double)q.x, y = (double)q.y, z = (double)q.z, w = (double)q.w;
    double s = 2 / (x * x + y * y + z * z + w * w);
    m[0] = 1 - s * (y * y + z * z), m[1] = s * (x * y - z * w), m[2] = s * (x * z + y * w);
    m[3] = s * (x * y + z * w), m[4] = 1 - s * (x * x + z * z), m[5] = s * (y * z - x * w);
    m[6] = s * (x * z - y * w), m[7] = s * (y * z + x * w), m[8] = 1 - s * (x * x + y * y);
}

daft_daffine daft_daffine_from(const daft_transform *transform)
{
    daft_daffine a = {.t = {transform->position.x, transform->position.y, transform->position.z}};
    double scale[3] = {(double)transform->scale.x, (double)transform->scale.y, (double)transform->scale.z};
    rotation_matrix(transform->rotation, a.m);
    for (int i = 0; i < 9; i++) a.m[i] *= scale[i % 3];
    return a;
}

daft_daffine daft_daffine_compose(const daft_daffine *outer, const daft_daffine *inner)
{
    daft_daffine out;
    for (int row = 0; row < 3; row++) {
        const double *m = outer->m + 3 * row;
        for (int column = 0; column < 3; column++)
            out.m[3 * row + column] =
                m[0] * inner->m[column] + m[1] * inner->m[3 + column] + m[2] * inner->m[6 + column];
        out.t[row] = m[0] * inner->t[0] + m[1] * inner->t[1] + m[2] * inner->t[2] + outer->t[row];
    }
    return out;
}

bool daft_daffine_invert(const daft_daffine *a, daft_daffine *out)
{
    const double *m = a->m;
    double cofactor[9] = {m[4] * m[8] - m[5] * m[7], m[2] * m[7] - m[1] * m[8], m[1] * m[5] - m[2] * m[4],
                          m[5] * m[6] - m[3] * m[8], m[0] * m[8] - m[2] * m[6], m[2] * m[3] - m[0] * m[5],
                          m[3] * m[7] - m[4] * m[6], m[1] * m[6] - m[0] * m[7], m[0] * m[4] - m[1] * m[3]};
    double determinant = m[0] * cofactor[0] + m[1] * cofactor[3] + m[2] * cofactor[6];
    if (determinant == 0 || !isfinite(determinant) || !isfinite(1 / determinant)) return false;
    for (int i = 0; i < 9; i++) out->m[i] = cofactor[i] / determinant;
    for (int i = 0; i < 3; i++)
        out->t[i] = -(out->m[3 * i] * a->t[0] + out->m[3 * i + 1] * a->t[1] + out->m[3 * i + 2] * a->t[2]);
    return true;
}

/* Exactly `before` at 0 and `now` at 1; each component stays between its two values. */
static double mix(double before, double now, float alpha)
{
    double a = (double)alpha;
    return a >= 1 ? now : a <= 0 ? before : before + (now - before) * a;
}

static daft_vec3 mix3(daft_vec3 before, daft_vec3 now, float alpha)
{
    return daft_v3((float)mix((double)before.x, (double)now.x, alpha),
                   (float)mix((double)before.y, (double)now.y, alpha),
                   (float)mix((double)before.z, (double)now.z, alpha));
}

static daft_transform mix_transforms(const daft_transform *before, const daft_transform *now, float alpha)
{
    if (alpha >= 1) return *now;
    if (alpha <= 0) return *before;
    return (daft_transform){
        .position =
            daft_dv3(mix(before->position.x, now->position.x, alpha), mix(before->position.y, now->position.y, alpha),
                     mix(before->position.z, now->position.z, alpha)),
        .rotation = daft_quat_nlerp(before->rotation, now->rotation, alpha),
        .scale = mix3(before->scale, now->scale, alpha),
    };
}

static void resolve(daft_scene *scene, uint32_t index, float alpha)
{
    daft_entity_item *item = &scene->entities[index];
    daft_transform pose = item->now;
    if (item->moved_tick == scene->tick) pose = mix_transforms(&item->before, &item->now, alpha);
    item->world = daft_daffine_from(&pose);
    item->shown = item->def.visible;
    item->walk_stamp = scene->walk;
    if (item->parent == DAFT_NONE) return;
    const daft_entity_item *parent = &scene->entities[item->parent];
    item->world = daft_daffine_compose(&parent->world, &item->world);
    item->shown = item->shown && parent->shown;
}

/* Climbs to the nearest ancestor that this walk has resolved, leaving a trail, and walks the trail back down: linear in
 * the number of entities over a whole walk, whatever the depth. */
daft_entity_item *daft_entity_world(daft_scene *scene, uint32_t index, float alpha)
{
    daft_entity_item *items = scene->entities;
    if (items[index].walk_stamp == scene->walk) return &items[index];
    uint32_t top = index;
    items[top].below = DAFT_NONE;
    while (items[top].parent != DAFT_NONE && items[items[top].parent].walk_stamp != scene->walk) {
        items[items[top].parent].below = top;
        top = items[top].parent;
    }
    for (; top != DAFT_NONE; top = items[top].below) resolve(scene, top, alpha);
    return &items[index];
}

bool daft_entity_place(const daft_scene *scene, uint32_t index, float alpha, daft_daffine *out)
{
    bool first = true;
    for (uint32_t at = index; at != DAFT_NONE; at = scene->entities[at].parent, first = false) {
        const daft_entity_item *item = &scene->entities[at];
        daft_transform pose = item->now;
        if (!item->def.visible) return false;
        if (item->moved_tick == scene->tick) pose = mix_transforms(&item->before, &item->now, alpha);
        const daft_daffine own = daft_daffine_from(&pose);
        *out = first ? own : daft_daffine_compose(&own, out);
    }
    return true;
}
