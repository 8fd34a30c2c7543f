/* What the tests of media share: bodies that absorb, put into a scene, and asked in double what is where. */
#ifndef DAFT_MEDIA_BODIES_H
#define DAFT_MEDIA_BODIES_H

#include "hard_scenes.h"

#include <math.h>

enum { WIDTH = 160, HEIGHT = 120 };

static const daft_vec3 WHITE = {1, 1, 1}, BLACK = {0, 0, 0};

static const daft_vec3 TINT = {0.5f, 0.2f, 0.9f};

__attribute__((unused)) static daft_material_def medium_def(double index, daft_vec3 tint, double distance, int priority)
{
    daft_material_def def = daft_default_material_def();
    def.specular = BLACK, def.transmission = 1, def.transmission_tint = tint, def.refractive_index = (float)index;
    def.tint_distance = (float)distance, def.medium_priority = priority;
    return def;
}

__attribute__((unused)) static daft_material medium(stage *s, double index, daft_vec3 tint, double distance,
                                                    int priority)
{
    const daft_material_def def = medium_def(index, tint, distance, priority);
    daft_error error = {0};
    daft_material out = daft_material_create(s->scene, &def, &error);
    if (!out.id) fail_msg("%s", error.message);
    return out;
}

__attribute__((unused)) static daft_material glowing(stage *s, daft_vec3 emission)
{
    daft_material_def def = daft_default_material_def();
    def.diffuse = def.ambient = def.specular = BLACK, def.emission = emission;
    daft_material out = daft_material_create(s->scene, &def, NULL);
    assert_true(out.id);
    return out;
}

/* ---- bodies ---- */

typedef enum kind { BALL, BOX, CUP } kind;

typedef struct body {
    kind kind;
    daft_dvec3 low, high; /* a box; a cup's outer one */
    double wall;          /* a cup's, open above; a ball's radius */
    int priority;         /* of media, all different; 0: it lets nothing through */
    double index, distance;
    daft_vec3 tint; /* or what it glows with */
} body;

typedef struct world {
    const body *bodies;
    int count, mirrors, surfaces;
} world;

__attribute__((unused)) static bool in_box(daft_dvec3 low, daft_dvec3 high, daft_dvec3 p)
{
    return p.x > low.x && p.y > low.y && p.z > low.z && p.x < high.x && p.y < high.y && p.z < high.z;
}

__attribute__((unused)) static daft_dvec3 cavity_low(const body *b)
{
    return daft_dadd(b->low, daft_dv3(b->wall, b->wall, b->wall));
}
__attribute__((unused)) static daft_dvec3 cavity_high(const body *b)
{
    return daft_dsub(b->high, daft_dv3(b->wall, 0, b->wall));
}

__attribute__((unused)) static bool contains(const body *b, daft_dvec3 p)
{
    if (b->kind == BALL) {
        const daft_dvec3 d = daft_dsub(p, b->low);
        return daft_ddot(d, d) < b->wall * b->wall;
    }
    if (!in_box(b->low, b->high, p)) return false;
    return b->kind == BOX || !in_box(cavity_low(b), cavity_high(b), p);
}

/* The body that is there; -1: air. */
__attribute__((unused)) static int body_at(const world *w, daft_dvec3 p, unsigned *mask)
{
    int best = -1;
    *mask = 0;
    for (int i = 0; i < w->count; i++) {
        if (!contains(&w->bodies[i], p)) continue;
        *mask |= 1u << i;
        const bool opaque = w->bodies[i].priority == 0;
        if (best < 0 || opaque || (w->bodies[best].priority && w->bodies[i].priority > w->bodies[best].priority))
            best = i;
    }
    return best;
}

typedef struct surface {
    double t;
    daft_dvec3 normal;
} surface;

enum { MOST = 64 };

__attribute__((unused)) static void box_surfaces(daft_dvec3 low, daft_dvec3 high, daft_dvec3 o, daft_dvec3 d,
                                                 surface *list, int *count)
{
    for (int k = 0; k < 6; k++) {
        const int axis = k / 2;
        const double plane = k & 1 ? daft_dv3_at(high, axis) : daft_dv3_at(low, axis),
                     t = (plane - daft_dv3_at(o, axis)) / daft_dv3_at(d, axis);
        const daft_dvec3 p = daft_dadd(o, daft_dscale(d, t));
        bool on = t > 1e-7 && isfinite(t);
        for (int i = 0; i < 3; i++)
            on &= i == axis || (daft_dv3_at(p, i) >= daft_dv3_at(low, i) && daft_dv3_at(p, i) <= daft_dv3_at(high, i));
        if (on) list[(*count)++] = (surface){t, daft_dv3(axis == 0, axis == 1, axis == 2)};
    }
}

__attribute__((unused)) static void body_surfaces(const body *b, daft_dvec3 o, daft_dvec3 d, surface *list, int *count)
{
    if (b->kind != BALL) {
        box_surfaces(b->low, b->high, o, d, list, count);
        if (b->kind == CUP) box_surfaces(cavity_low(b), cavity_high(b), o, d, list, count);
        return;
    }
    const daft_dvec3 c = daft_dsub(b->low, o);
    const double along = daft_ddot(c, d), root = along * along - daft_ddot(c, c) + b->wall * b->wall;
    for (int k = -1; k <= 1 && root >= 0; k += 2) {
        const double t = along + k * sqrt(root);
        if (t > 1e-7)
            list[(*count)++] =
                (surface){t, daft_dscale(daft_dsub(daft_dadd(o, daft_dscale(d, t)), b->low), 1 / b->wall)};
    }
}

__attribute__((unused)) static int by_t(const void *a, const void *b)
{
    const double s = ((const surface *)a)->t, t = ((const surface *)b)->t;
    return (s > t) - (s < t);
}

/* ---- in scenes ---- */

__attribute__((unused)) static void box_faces(daft_dvec3 low, daft_dvec3 high, bool inwards, bool top, daft_vec3 *p,
                                              uint32_t *count)
{
    static const int FACES[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
    for (int f = 0; f < 6; f++) {
        if (f == 3 && !top) continue;
        for (int k = 0; k < 4; k++) {
            const int c = FACES[f][inwards ? 3 - k : k];
            p[(*count)++] =
                daft_to_float(daft_dv3(c & 1 ? high.x : low.x, c & 2 ? high.y : low.y, c & 4 ? high.z : low.z));
        }
    }
}

/* Five walls with a rim above: one closed mesh. */
__attribute__((unused)) static daft_mesh cup_mesh(stage *s, const body *b)
{
    daft_vec3 p[64];
    uint32_t index[96], count = 0, triangles = 0;
    const daft_dvec3 low = cavity_low(b), high = cavity_high(b);
    box_faces(b->low, b->high, false, false, p, &count);
    box_faces(low, high, true, false, p, &count);
    const daft_dvec3 outer[4] = {{b->low.x, b->high.y, b->low.z},
                                 {b->low.x, b->high.y, b->high.z},
                                 {b->high.x, b->high.y, b->high.z},
                                 {b->high.x, b->high.y, b->low.z}},
                     inner[4] = {{low.x, high.y, low.z},
                                 {low.x, high.y, high.z},
                                 {high.x, high.y, high.z},
                                 {high.x, high.y, low.z}};
    for (int k = 0; k < 4; k++) {
        const int n = (k + 1) % 4;
        const daft_dvec3 rim[4] = {outer[k], outer[n], inner[n], inner[k]};
        for (int i = 0; i < 4; i++) p[count++] = daft_to_float(rim[i]);
    }
    for (uint32_t i = 0; i < count; i += 4) {
        const uint32_t quad[6] = {i, i + 1, i + 2, i, i + 2, i + 3};
        memcpy(index + 3 * triangles, quad, sizeof quad), triangles += 2;
    }
    daft_mesh_def def = daft_default_mesh_def();
    def.positions = p, def.vertex_count = count, def.indices = index, def.triangle_count = triangles;
    daft_mesh out = daft_mesh_create(s->scene, &def, NULL);
    assert_true(out.id);
    return out;
}

__attribute__((unused)) static void add_bodies(stage *s, const world *w)
{
    for (int i = 0; i < w->count; i++) {
        const body *b = &w->bodies[i];
        const daft_material m =
            b->priority ? medium(s, b->index, b->tint, b->distance, b->priority) : glowing(s, b->tint);
        const daft_dvec3 middle = daft_dscale(daft_dadd(b->low, b->high), 0.5);
        if (b->kind == BALL) add(s, sphere(b->low, (float)b->wall, m));
        if (b->kind == BOX) add(s, box(middle, daft_to_float(daft_dsub(b->high, b->low)), m));
        if (b->kind == CUP) add(s, instance(cup_mesh(s, b), daft_dv3(0, 0, 0), 1, daft_quat_identity(), m));
    }
}

#endif
