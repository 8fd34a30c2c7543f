/* cast: the points of a tile and one light, and which of them lie under whose bounds. For the kernels of this room. */
#ifndef DAFT_SAMPLES_CAST_H
#define DAFT_SAMPLES_CAST_H

#include "raster/samples/samples.h"

enum {
    FEW_LOOKS = 64, /* nodes and instances are looked at; then the occluders count as many */
    SHAFT_ROOM = 256
};

/* A tile's points and one light. */
typedef struct cast {
    const daft_samples *samples;
    const daft_apex *light;
    const daft_tlas *tlas;
    uint32_t flag, only;     /* of the occluders; the only one, or DAFT_NOTHING */
    const uint32_t *asked;   /* bits of the points */
    daft_filtered *filtered; /* NULL: the occluders are opaque */
    light_view view;
    picture_map frame_map; /* frame space to view space */
    daft_vec3 low, high;   /* of the points, in frame space */
    bool inverses_known;
    uint32_t sole; /* the instance that all the points lie on, on the side that faces the light; or DAFT_NOTHING */
    uint32_t occluder_count; /* beyond DAFT_MAX_OCCLUDERS: more than are remembered */
    struct {
        uint32_t number;
        picture_box box;
        uint32_t first, blocks; /* of shaft_blocks, all that may hide points; 0: not known */
    } occluder[DAFT_MAX_OCCLUDERS];
    bool sifts, dark; /* occluders go through the shaft (shaft_kernel.c); one hides all points */
    uint32_t hiders, hidden[DAFT_SAMPLES_WORDS]; /* triangles that were asked which points they hide; these points */
    uint32_t sifted, tried;                      /* meshes that were looked at; triangles asked point by point */
    bool keeps;                                  /* some triangle may hide points */
    uint32_t shaft_count;
    const daft_block *shaft_blocks[SHAFT_ROOM];
    uint32_t under[DAFT_SAMPLES_WORDS], rest[DAFT_SAMPLES_WORDS]; /* rest: asked, and not hidden */
    float inverse[3][DAFT_SAMPLES_ROOM];                          /* one over the rays' directions */
    float place[3][DAFT_SAMPLES_ROOM]; /* x, y and depth in view space, of registers with asked points */
    uint32_t own[DAFT_SAMPLES_ROOM];
} cast;

typedef struct frame_box {
    daft_vec3 low, high;
} frame_box;

DAFT_INLINE vbits bits_at(const uint32_t *bits, uint32_t i) { return bits[i / 32] >> (i % 32) & DAFT_ALL_LANES; }

DAFT_INLINE vf3 load3(const daft_points3 *a, uint32_t i)
{
    return (vf3){vf_load(&a->x[i]), vf_load(&a->y[i]), vf_load(&a->z[i])};
}

DAFT_INLINE vf3 minus(vf3 a, daft_vec3 b) { return (vf3){a.x - vf_set(b.x), a.y - vf_set(b.y), a.z - vf_set(b.z)}; }

DAFT_INLINE void set_axes(daft_pencil *view, daft_vec3 z)
{
    daft_vec3 min = fabsf(z.y) < 0.7f ? daft_v3(0, 1, 0) : daft_v3(1, 0, 0);
    view->right = daft_normalize(daft_cross(z, min)), view->up = daft_cross(view->right, z), view->forward = z;
}

DAFT_INLINE occluder occluder_of(const cast *c, uint32_t number, shadow_points *points)
{
    const daft_instance *s = &c->tlas->instances[number];
    return (occluder){.view = &c->view,
                      .light = c->light,
                      .samples = c->samples,
                      .instance = s,
                      .number = number,
                      .convex = !c->filtered && s->flags & DAFT_INSTANCE_CONVEX,
                      .flat = is_flat(s),
                      .points = points,
                      .filtered = c->filtered};
}

/* The asked points' places in view space, and their extent. False: some lie beside or behind the light, and no picture
 * plane holds them all. */
bool DAFT_KERNEL(daft_cast_measure)(cast *c);
/* What of an instance, seen in `box`, stands in the shaft between the asked points and the light. The box may become
 * smaller; the blocks of a mesh are added to c->shaft_blocks where they are known: their number. */
typedef enum shaft_answer { SHAFT_CLEAR, SHAFT_SOME, SHAFT_DARK } shaft_answer;
shaft_answer DAFT_KERNEL(daft_cast_shaft)(cast *c, uint32_t number, picture_box *box, uint32_t *blocks);
/* The points' extent; which triangles cannot shadow the points that lie on them, and whether all points lie on one
 * instance's. */
void DAFT_KERNEL(daft_cast_points)(cast *c);
/* Whether the rays may meet the instance in its bound: neither a convex instance nor a flat one shadows its own points.
 */
bool DAFT_KERNEL(daft_cast_may_shadow)(const cast *c, uint32_t number, frame_box *box);
/* Marks the points whose ray to the light meets the bound; gives whether there is one. Neither a convex instance nor a
 * flat one shadows its own points. */
bool DAFT_KERNEL(daft_cast_mark_under)(cast *c, const frame_box *box, const daft_instance *s, uint32_t number);
/* Remembers the instances that points lie under, and marks these points. False: there may be more than `most` such
 * instances, or more than `looks` had to be looked at, and it is not known which points are under something. */
bool DAFT_KERNEL(daft_cast_find_occluders)(cast *c, uint32_t max, uint32_t looks);
/* Whether nothing can stand between the points and the light, as far as is known before the light's picture is. */
bool DAFT_KERNEL(daft_cast_clear)(const cast *c);

#endif
