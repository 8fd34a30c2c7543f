/* An upper bound of a mesh's support along a direction, from its 26-DOP (bound.c). Which three of the numbers in
 * daft_bvh.support it takes depends on the direction's octant and on the order of its components' magnitudes. */
#ifndef DAFT_REACH_H
#define DAFT_REACH_H

#include <stdint.h>

enum { DAFT_REACH_AXES = 0, DAFT_REACH_FACES = 6, DAFT_REACH_OCTANTS = DAFT_REACH_FACES + 3 * 8 };

/* By bits of |x| >= |y|, |y| >= |z|, |x| >= |z|: the axes by size, the largest first. Two cases cannot be. */
static const uint8_t DAFT_REACH_ORDER[8][3] = {{2, 1, 0}, {2, 0, 1}, {1, 2, 0}, {0, 1, 2},
                                               {0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {0, 1, 2}};

/* Places in support; order: the row above; sign: bits of x, y, z < 0. */
static inline uint32_t daft_reach_axis(const uint8_t order[3], uint32_t sign)
{
    return DAFT_REACH_AXES + 2u * order[0] + (sign >> order[0] & 1);
}
static inline uint32_t daft_reach_face(const uint8_t order[3], uint32_t sign)
{
    return DAFT_REACH_FACES + 8u * order[2] + (sign & ~(1u << order[2]));
}
static inline uint32_t daft_reach_octant(uint32_t sign) { return DAFT_REACH_OCTANTS + sign; }

#endif
