/* Loudness falls with the distance, as it does outdoors, and fades out towards the farthest place it is heard at. */
#include "game/ear.h"

#include <math.h>

/* How far to one side a voice right beside the ear is heard: the other ear hears it, too. */
static const float BESIDE = 0.8f;

/* Ears stay level. */
static daft_vec3 right_of(const daft_camera *c)
{
    const double yaw = (double)c->yaw;
    return (daft_vec3){(float)-daft_sin(yaw), 0, (float)daft_cos(yaw)};
}

/* Whether a body stands between the ear and the voice, but for what carries it, and what the ear is in. */
static bool is_behind(daft_scene *scene, const voice *v, daft_dvec3 ear, daft_vec3 direction, float distance)
{
    enum { MOST = 8 };
    daft_query_hit hits[MOST];
    daft_query_filter filter = daft_default_query_filter();
    daft_error error;
    filter.ignore = v->carrier;
    const float until = distance - 0.25f * v->near; /* sounds begin at surfaces */
    if (until <= 0) return false;
    const uint32_t count = daft_query_ray_all(scene, ear, direction, until, &filter, hits, MOST, &error);
    for (uint32_t i = 0; i < count && i < MOST; i++)
        if (!hits[i].inside) return true;
    return false;
}

/* A carrier that is gone leaves the voice where it was. */
static void go_with_carrier(voice *v, daft_scene *scene)
{
    daft_transform transform;
    daft_error error;
    if (!v->carrier.id) return;
    if (daft_entity_get_world_transform(scene, v->carrier, &transform, &error))
        v->place = transform.position;
    else
        v->carrier.id = 0;
}

static void hear(voice *v, daft_scene *scene, const daft_camera *c)
{
    go_with_carrier(v, scene);
    const double x = v->place.x - c->position.x, y = v->place.y - c->position.y, z = v->place.z - c->position.z;
    const float distance = (float)fmin(sqrt(x * x + y * y + z * z), 1e9);
    v->gain = v->side = v->muffle = 0;
    if (!(distance < v->far)) return;
    const float fade = 1 - fmaxf(0, distance - v->near) / (v->far - v->near);
    v->gain = v->near / fmaxf(distance, v->near) * fade;
    if (distance < 0.01f) return;
    const daft_vec3 right = right_of(c);
    const daft_vec3 to = {(float)(x / (double)distance), (float)(y / (double)distance), (float)(z / (double)distance)};
    const float aside = to.x * right.x + to.z * right.z;
    v->side = BESIDE * aside * fminf(1, distance / v->near);
    v->muffle = is_behind(scene, v, c->position, to, distance) ? 1 : 0;
}

void ear_listen(mixer *m, daft_scene *scene)
{
    const daft_camera camera = daft_scene_camera(scene, 1);
    for (int i = 0; i < SOUND_VOICES; i++)
        if (m->voices[i].id && m->voices[i].placed) hear(&m->voices[i], scene, &camera);
}
