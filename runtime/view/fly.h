/* fly: where the camera is and how it moves: flying, or turning around a point. Nothing but numbers. */
#ifndef RUNTIME_VIEW_FLY_H
#define RUNTIME_VIEW_FLY_H

#include "daft.h"

typedef struct flight {
    daft_camera camera;
    double speed; /* metres a second */
    bool orbits;
    daft_dvec3 pivot; /* what it turns around */
} flight;

/* What the user asks for: -1, 0 or 1 each, and the turn in radians. */
typedef struct flight_wish {
    double forward, right, up, yaw, pitch, factor; /* factor: of the speed */
} flight_wish;

/* A speed that covers this distance, in metres, in some seconds. */
double fly_speed(double distance);
void fly_change_speed(flight *f, double notches, double size);
/* Moves for `seconds`. False: nothing has changed. */
bool fly_move(flight *f, const flight_wish *wish, double seconds);
/* Turns about the pivot at the distance that the camera has from it. */
void fly_orbit(flight *f, double yaw, double pitch);

#endif
