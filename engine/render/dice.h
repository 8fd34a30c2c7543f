/* Places of samples: on a disc, all round, as even as few can be. They lie on a spiral of the golden angle (Vogel, "A
 * better way to construct the sunflower head", Mathematical Biosciences 44, 1979), turned by an angle of its own at
 * each pixel; the angles of neighbours differ as much as they can (the R2 sequence: Roberts, "The Unreasonable
 * Effectiveness of Quasirandom Sequences", 2018), so that what is left of noise is fine and even. All of it in whole
 * numbers, so that it is the same everywhere. */
#ifndef DAFT_DICE_H
#define DAFT_DICE_H

#include "math/vec.h"

#include <math.h>

enum { DAFT_TURN_BITS = 8 };

/* The numbers of the R2 sequence, and of the golden ratio, as fractions of 2^32. */
#define DAFT_R2_X   3242174889u
#define DAFT_R2_Y   2447445414u
#define DAFT_GOLDEN 2654435769u
/* Steps of the turn and of the radius from round to round. Multiples of the golden ratio would repeat the angles of the
 * round's own rays. A search found these: they have the least RMS error in the areas that lines cut off the disc, with
 * 4 to 256 samples of a pixel. At 256 it is 0.55 times that of the golden ratio (tests/unit/render/test_dice.c). */
#define DAFT_ROUND_TURN   1145869761u
#define DAFT_ROUND_RADIUS 2621778237u
/* The step of the turn from salt to salt. */
#define DAFT_SALT 747796405u

/* What tells a pixel's samples from those of others: fractions of 2^32. */
typedef struct daft_dice {
    uint32_t turn, radius;
} daft_dice;

/* `round`: of the picture's samples and of pictures; `salt`: of what asks. */
static inline daft_dice daft_dice_throw(uint32_t x, uint32_t y, uint32_t round, uint32_t salt)
{
    return (daft_dice){x * DAFT_R2_X + y * DAFT_R2_Y + DAFT_ROUND_TURN * round + DAFT_SALT * salt,
                       x * DAFT_R2_Y + y * DAFT_R2_X + DAFT_ROUND_RADIUS * round + 2 * DAFT_SALT * salt};
}

/* Sample `k` of `count`: which of the 2^DAFT_TURN_BITS directions; and an even number in 0..1. */
static inline uint32_t daft_dice_turn(daft_dice d, uint32_t k)
{
    return (d.turn + k * DAFT_GOLDEN) >> (32 - DAFT_TURN_BITS);
}

static inline float daft_dice_part(daft_dice d, uint32_t k, uint32_t count)
{
    return ((float)k + (float)(d.radius >> 8) * 0x1p-24f) / (float)count;
}

/* Two axes across a unit vector (Duff and others, "Building an Orthonormal Basis, Revisited", JCGT 6(1), 2017). */
static inline void daft_axes_across(daft_vec3 n, daft_vec3 *a, daft_vec3 *b)
{
    const float sign = n.z < 0 ? -1.0f : 1.0f, p = -1 / (sign + n.z), q = n.x * n.y * p;
    *a = daft_v3(1 + sign * n.x * n.x * p, sign * q, -sign * n.x);
    *b = daft_v3(q, sign + n.y * n.y * p, -n.y);
}

#endif
