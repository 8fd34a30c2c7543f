/* The media that a ray is in: bodies that transmit, by their materials. Where bodies overlap, the medium of the highest
 * priority is there alone, and surfaces of the others within it are no interfaces (Schmidt, Budge, "Simple Nested
 * Dielectrics in Ray Traced Images", Journal of Graphics Tools 7(2), 2002). Of equals, what was entered last wins. */
#ifndef DAFT_RENDER_MEDIA_H
#define DAFT_RENDER_MEDIA_H

#include "accel/accel.h"
#include "shade/shade.h"

enum { DAFT_MEDIA = 4 };
#define DAFT_NO_MEDIUM UINT32_MAX

/* In the order in which they were entered; DAFT_NO_MEDIUM behind the last. A material may be there twice. */
typedef struct daft_media {
    uint32_t material[DAFT_MEDIA];
} daft_media;

static inline daft_media daft_no_media(void)
{
    daft_media none;
    for (int i = 0; i < DAFT_MEDIA; i++) none.material[i] = DAFT_NO_MEDIUM;
    return none;
}

/* What surfaces that transmit are between, of each of a batch's points. */
typedef struct daft_crossings {
    daft_media from[DAFT_BATCH_ROOM], beyond[DAFT_BATCH_ROOM]; /* on the viewer's side, of all points; behind it */
    float eta[DAFT_BATCH_ROOM]; /* the index on the viewer's side over the one beyond; 0: it is no interface, light goes
                                   straight on */
} daft_crossings;

/* The medium that is there; DAFT_NO_MEDIUM: air. */
uint32_t daft_media_winner(const daft_media *media, const daft_surface *materials);
/* Through a body's surface. Of more than DAFT_MEDIA the one that is least likely to win is forgotten: of the lowest
 * priority the oldest. To leave what the ray is not in changes nothing. */
void daft_media_pass(daft_media *media, const daft_surface *materials, uint32_t material, bool leaves);
/* A ray that leaves a body was in it; if that was not known, it comes below all others. */
void daft_media_learn(daft_media *media, uint32_t material);
/* The ratio of indices at the surface of a body, as daft_crossings.eta. A medium without a priority takes what lies
 * around it for air, if it has none either. */
float daft_media_eta(const daft_media *from, const daft_media *beyond, const daft_surface *materials, uint32_t material,
                     bool leaves);
/* The loss of light on so many metres, as powers of 1/2 (Beer's law); losses add up along the way. */
daft_vec3 daft_media_loss(const daft_media *media, const daft_surface *materials, float length);

/* Whether a point's surface is seen from its inner side. `outward`: the geometric normal towards the viewer, of any
 * length. The outer side is where the mesh's normals point, as for shading, or where its corners run counter-clockwise
 * if it has none. */
bool daft_seen_from_inside(const daft_instance *instance, uint32_t triangle, daft_vec3 point, daft_vec3 outward);

#endif
