/* A mesh with its trees, by itself or as an instance, for the property tests: rays through it are compared on every
 * instruction set, to the bit, and with and without the question what is hit. */
#ifndef DAFT_SUBJECT_H
#define DAFT_SUBJECT_H

#include "closed_shapes.h"
#include "fixtures.h"

static const daft_allocator *memory(void)
{
    static daft_allocator allocator;
    if (!allocator.allocate) allocator = daft_malloc_allocator(); /* first asked for before there are workers */
    return &allocator;
}

typedef struct subject {
    closed_shape shape;
    daft_bvh *bvh;
    daft_instance instance;
    daft_arena arena;
    const daft_tlas *tlas;
} subject;

static void subject_place(subject *s, daft_affine to_frame)
{
    const fixture_mesh mesh = {s->shape.mesh, s->bvh};
    daft_error error;
    s->instance = instance_make(&mesh, to_frame);
    s->instance.mesh = &s->shape.mesh;
    daft_arena_reset(&s->arena);
    s->tlas = daft_tlas_build(&s->arena, &s->instance, 1, &error);
    assert_non_null(s->tlas);
}

static daft_affine identity(void) { return affine_make(daft_quat_identity(), daft_v3(1, 1, 1), daft_v3(0, 0, 0)); }

static void subject_wrap(subject *s)
{
    s->bvh = daft_bvh_build_mesh(memory(), &s->shape.mesh, 1, NULL);
    assert_non_null(s->bvh);
    daft_arena_init(&s->arena, memory());
    subject_place(s, identity());
}

/* Numbers from CLOSED_KINDS on are files. False: there is none. */
static bool subject_make(subject *s, int number, uint64_t *state)
{
    *s = (subject){0};
    bool made = number < CLOSED_KINDS ? closed_shape_make(memory(), number, state, &s->shape)
                                      : closed_shape_load(memory(), number - CLOSED_KINDS, &s->shape);
    if (number < CLOSED_KINDS) assert_true(made && closed_mesh(memory(), &s->shape.mesh));
    if (made) subject_wrap(s);
    return made;
}

static void subject_drop(subject *s)
{
    daft_arena_free(&s->arena);
    daft_bvh_free(s->bvh);
    closed_shape_free(memory(), &s->shape);
}

static daft_ray ray_make(daft_vec3 o, daft_vec3 d) { return (daft_ray){.origin = o, .direction = d, .tmax = INFINITY}; }

/* All instruction sets give the same bits, and `occluded` says what `closest` says. */
static bool looks_alike(const daft_tlas *tlas, const daft_ray *ray, const daft_hit *expected)
{
    bool found = expected->instance != UINT32_MAX, same = true;
    for (int isa = 0; isa <= daft_isa_best(); isa++) {
        daft_hit hit;
        same &= daft_accel_kernels_for(isa)->closest(tlas, ray, UINT32_MAX, &hit) == found;
        same &= memcmp(&hit, expected, sizeof hit) == 0 && daft_accel_kernels_for(isa)->occluded(tlas, ray) == found;
    }
    return same;
}

static bool look(const subject *s, const daft_ray *ray, daft_hit *hit)
{
    bool found = daft_accel_kernels_for(daft_isa_best())->closest(s->tlas, ray, UINT32_MAX, hit);
    assert_true(looks_alike(s->tlas, ray, hit));
    return found;
}

/* Somewhere within 1e6 of the frame's origin, turned, scaled by 1e-4 to 1e4, each axis by itself or all alike, or
 * mirrored. */
static daft_affine any_place(uint64_t *state)
{
    daft_quat turn = {hard_float(state, -1, 1), hard_float(state, -1, 1), hard_float(state, -1, 1),
                      hard_float(state, -1, 1)};
    float k = (float)daft_pow(10, (double)hard_float(state, -4, 4)),
          away = (float)daft_pow(10, (double)hard_float(state, -3, 6));
    daft_vec3 scale = {k, k, k};
    if (hard_bits(state) % 3 == 0) scale.y *= hard_float(state, 0.1f, 1), scale.z *= -hard_float(state, 0.1f, 1);
    return affine_make(turn, scale, hard_vec3(state, -away, away));
}

#endif
