/* How the camera moves. Axes as daft.h has them: yaw 0 looks along +X and turns towards +Z, positive pitch looks down.
 */
#include "view/fly.h"

#include <math.h>

static const double STEEPEST = 1.5533; /* radians, 89 degrees: further on, left and right would change places */

static daft_dvec3 forward_of(const daft_camera *c)
{
    double yaw = (double)c->yaw, pitch = (double)c->pitch, level = daft_cos(pitch);
    return (daft_dvec3){level * daft_cos(yaw), -daft_sin(pitch), level * daft_sin(yaw)};
}

static daft_dvec3 right_of(const daft_camera *c)
{
    return (daft_dvec3){-daft_sin((double)c->yaw), 0, daft_cos((double)c->yaw)};
}

static daft_dvec3 up_of(const daft_camera *c)
{
    daft_dvec3 r = right_of(c), f = forward_of(c);
    return (daft_dvec3){r.y * f.z - r.z * f.y, r.z * f.x - r.x * f.z, r.x * f.y - r.y * f.x};
}

static double dot(daft_dvec3 a, daft_dvec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

static void add(daft_dvec3 *to, daft_dvec3 v, double scale)
{
    to->x += v.x * scale, to->y += v.y * scale, to->z += v.z * scale;
}

static double limit(double value, double most) { return fmax(-most, fmin(most, value)); }

double fly_speed(double distance)
{
    const double seconds = 4;
    return distance > 0 && isfinite(distance) ? distance / seconds : 1;
}

void fly_change_speed(flight *f, double notches, double size)
{
    double usual = fly_speed(size);
    f->speed = fmax(usual * 1e-4, fmin(usual * 1e3, f->speed * pow(1.25, limit(notches, 20))));
}

static void turn(daft_camera *c, double yaw, double pitch)
{
    const double circle = 6.283185307179586;
    double now = remainder((double)c->yaw + yaw, circle);
    c->yaw = (float)now;
    if (pitch != 0) c->pitch = (float)limit((double)c->pitch + pitch, STEEPEST);
}

static daft_dvec3 to_pivot(const flight *f)
{
    daft_dvec3 d = f->pivot;
    add(&d, f->camera.position, -1);
    return d;
}

void fly_orbit(flight *f, double yaw, double pitch)
{
    daft_camera *c = &f->camera;
    /* The pivot in the camera's axes stays, so that it stands still in the picture. */
    daft_dvec3 d = to_pivot(f);
    double along = dot(d, forward_of(c)), across = dot(d, right_of(c)), above = dot(d, up_of(c));
    turn(c, yaw, pitch);
    c->position = f->pivot;
    add(&c->position, forward_of(c), -along), add(&c->position, right_of(c), -across);
    add(&c->position, up_of(c), -above);
}

bool fly_move(flight *f, const flight_wish *wish, double seconds)
{
    daft_camera *c = &f->camera, before = *c;
    double way = f->speed * wish->factor * seconds;
    if (f->orbits) {
        const double turns = 1.2; /* radians a second, by the keys that move sideways */
        double yaw = wish->yaw - turns * seconds * wish->right, pitch = wish->pitch + turns * seconds * wish->up;
        if (yaw != 0 || pitch != 0) fly_orbit(f, yaw, pitch);
        daft_dvec3 d = to_pivot(f);
        double distance = sqrt(dot(d, d));
        /* Nearer by a fraction of what is left, so that the pivot is never passed. */
        if (distance > 0 && wish->forward != 0) add(&c->position, d, 1 - exp(-wish->forward * way / distance));
    } else {
        if (wish->yaw != 0 || wish->pitch != 0) turn(c, wish->yaw, wish->pitch);
        add(&c->position, forward_of(c), way * wish->forward);
        add(&c->position, right_of(c), way * wish->right);
        c->position.y += way * wish->up;
    }
    if (!isfinite(c->position.x) || !isfinite(c->position.y) || !isfinite(c->position.z)) *c = before;
    return before.yaw != c->yaw || before.pitch != c->pitch || before.position.x != c->position.x ||
           before.position.y != c->position.y || before.position.z != c->position.z;
}
