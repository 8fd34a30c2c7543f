/* Which animated entities a picture can do without: those of which no clip that they play can reach the picture, nor
 * cast a shadow into it. Where something mirrors or lets light through, rays go anywhere and none is left out; nor is
 * one whose pose passes from one clip to another, as that is in neither's bounds. */
#include "scene/animation/animation.h"

#include "math/trig.h"

#include <string.h>

static daft_vec3 plane(daft_vec3 forward, daft_vec3 side, double slope)
{
    const daft_dvec3 f = daft_to_double(forward), s = daft_to_double(side);
    const daft_dvec3 n = daft_dadd(daft_dscale(f, slope), s);
    return daft_to_float(daft_dscale(n, 1 / sqrt(daft_ddot(n, n))));
}

static bool rays_go_anywhere(const daft_scene *scene, const daft_view *view)
{
    if (view->quality.mirror_depth == 0 && view->quality.refraction_depth == 0) return false;
    for (uint32_t i = 0; i < scene->assets.material_slots.count; i++) {
        const daft_surface *s = &scene->assets.surfaces[i];
        if (s->mirror.x > 0 || s->mirror.y > 0 || s->mirror.z > 0 || s->transmission > 0 ||
            s->traits & DAFT_TRAIT_BLEND)
            return true;
    }
    return false;
}

/* A hundredth more than the picture on each side, for samples and rounding. */
void daft_sight_make(const daft_scene *scene, const daft_view *view, int width, int height, daft_sight *out)
{
    daft_vec3 right, up, forward;
    memset(out, 0, sizeof *out);
    daft_camera_axes(&view->camera, &right, &up, &forward);
    const double across = 1.01 * daft_tan((double)view->camera.fov / 2), down = across * height / width;
    out->planes[0] = plane(forward, right, across), out->planes[1] = plane(forward, daft_neg(right), across);
    out->planes[2] = plane(forward, up, down), out->planes[3] = plane(forward, daft_neg(up), down);
    out->planes[4] = forward;
    out->margin = view->without & DAFT_WITHOUT_SHADING ? 0 : scene->occlusion;
    out->anywhere = rays_go_anywhere(scene, view);
    out->shadows = view->quality.shadows && !(view->without & DAFT_WITHOUT_SHADING);
    out->origin = view->camera.position;
}

/* The largest n·p of a box's points, relative to the sight's origin. */
static double farthest(const daft_sight *sight, const daft_daffine *world, const double middle[3], const double half[3],
                       daft_vec3 normal)
{
    const double n[3] = {(double)normal.x, (double)normal.y, (double)normal.z},
                 o[3] = {sight->origin.x, sight->origin.y, sight->origin.z};
    double sum = 0;
    for (int row = 0; row < 3; row++) {
        double at = world->t[row] - o[row];
        for (int k = 0; k < 3; k++) at += world->m[3 * row + k] * middle[k];
        sum += n[row] * at;
    }
    for (int k = 0; k < 3; k++) {
        double along = 0;
        for (int row = 0; row < 3; row++) along += n[row] * world->m[3 * row + k];
        sum += fabs(along) * half[k];
    }
    return sum;
}

/* Shadows go on from the box away from the light: they stay beyond the plane where the light is at least as far on the
 * inner side as the box is. */
static bool shadow_stays(const daft_sight *sight, const daft_light_def *light, daft_vec3 normal, double reach)
{
    const daft_dvec3 n = daft_to_double(normal);
    if (light->kind == DAFT_LIGHT_SUN) {
        const daft_dvec3 d = daft_to_double(light->direction);
        const double length = sqrt(daft_ddot(d, d));
        return daft_ddot(n, d) + length * daft_tan((double)light->disc) <= 0;
    }
    const double w = (double)light->size.x, h = (double)light->size.y,
                 extent = light->kind == DAFT_LIGHT_RECTANGLE ? sqrt(w * w + h * h) / 2 : (double)light->radius;
    return reach <= daft_ddot(n, daft_dsub(light->position, sight->origin)) - extent;
}

bool daft_sight_has(const daft_scene *scene, const daft_sight *sight, const daft_entity_item *item, daft_vec3 low,
                    daft_vec3 high)
{
    if (sight->anywhere || item->animated->track_count > 1) return true;
    const daft_dvec3 a = daft_to_double(low), b = daft_to_double(high);
    const double middle[3] = {(a.x + b.x) / 2, (a.y + b.y) / 2, (a.z + b.z) / 2},
                 half[3] = {(b.x - a.x) / 2, (b.y - a.y) / 2, (b.z - a.z) / 2};
    double reach[5];
    bool seen = true;
    for (int i = 0; i < 5; i++) {
        reach[i] = farthest(sight, &item->world, middle, half, sight->planes[i]);
        seen = seen && !(reach[i] + (double)sight->margin < 0);
    }
    if (seen || (sight->shadows && item->def.casts_shadow && scene->glowing)) return true;
    for (uint32_t l = 0; sight->shadows && item->def.casts_shadow && l < scene->light_slots.count; l++) {
        const daft_light_def *light = &scene->lights[l];
        bool stays = !scene->light_slots.items[l].live || !light->casts_shadow;
        for (int i = 0; i < 5 && !stays; i++)
            stays = reach[i] + (double)sight->margin < 0 && shadow_stays(sight, light, sight->planes[i], reach[i]);
        if (!stays) return true;
    }
    return false;
}
