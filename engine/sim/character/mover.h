/* How a capsule moves among the shapes of a world: planes of what it touches, casts, sliding. No other room includes
 * this.
 *
 * The capsule keeps a skin of `skin` metres to everything. Casts stop at half of it, sliding keeps at least
 * DAFT_MOVER_CLEAR of it, and what comes to stand stops at the whole: so neither does one of them find that another has
 * gone too far, nor does standing creep. */
#ifndef DAFT_SIM_MOVER_H
#define DAFT_SIM_MOVER_H

#include "sim/query/walk.h"

#define DAFT_MOVER_CLEAR 0.75

enum { DAFT_MOVER_PLANES = 32 };

typedef struct daft_mover_plane {
    daft_dvec3 normal;     /* towards the capsule */
    double separation;     /* metres; negative: overlap */
    daft_dvec3 point;      /* relative to the capsule's centre */
    uint32_t part, number; /* what it is of: the order of planes */
} daft_mover_plane;

typedef struct daft_mover {
    daft_world *world;
    daft_sim_filter filter;
    daft_sim_shape capsule;
    double skin;
    double max_slope; /* cosine */
    bool walking;     /* what is too steep to walk on is a wall */
    uint32_t skip;    /* one more body to pass through; 0: none */
    daft_dvec3 position;
    bool collected;
    daft_dvec3 collected_at;
    uint32_t count;                             /* of planes at that position */
    daft_mover_plane planes[DAFT_MOVER_PLANES]; /* the deepest, in their order */
} daft_mover;

/* The planes within two skins of the position, unless they are known. */
void daft_mover_collect(daft_mover *m);
/* The fraction of the motion it can go until it is `gap` metres from something. *hit, if not NULL: the plane of that,
 * as seen from there, where the fraction is below 1. */
double daft_mover_cast(daft_mover *m, daft_dvec3 motion, double gap, daft_mover_plane *hit);
/* Goes as near to position + motion as it can, sliding along what it meets, and out of what it overlaps. */
void daft_mover_slide(daft_mover *m, daft_dvec3 motion);
/* The velocity nearest to the one given that leads into none of the planes; both seen from something that moves with
 * `frame`. Dynamic bodies that come nearer do not add to it. */
daft_dvec3 daft_mover_clip(const daft_mover *m, daft_dvec3 velocity, daft_dvec3 frame);
/* Of the body at the plane's point, m/s. */
daft_dvec3 daft_mover_speed(const daft_mover *m, const daft_mover_plane *plane);
/* Whether one can stand on it. */
bool daft_mover_walkable(const daft_mover *m, daft_dvec3 normal);

#endif
