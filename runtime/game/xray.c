/* Points are taken into the camera's axes, lines cut at the plane before it, and drawn as lines of the HUD. */
#include "game/xray.h"

#include <math.h>
#include <stdlib.h>

static const canvas_color AWAKE = {90, 235, 120, 255}, ASLEEP = {90, 150, 255, 255}, STATIC = {200, 205, 215, 170},
                          KINEMATIC = {255, 175, 60, 255}, SENSOR = {215, 120, 255, 220}, CONTACT = {255, 70, 60, 255};
static const double NEAR = 0.02; /* metres before the camera */

typedef struct eye {
    daft_dvec3 at, axes[3];         /* right, down, forward; right and down as long as half the picture at distance 1 */
    double half_width, half_height; /* HUD units */
    const canvas *target;
} eye;

static daft_dvec3 minus(daft_dvec3 a, daft_dvec3 b) { return (daft_dvec3){a.x - b.x, a.y - b.y, a.z - b.z}; }
static double dot(daft_dvec3 a, daft_dvec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

static daft_dvec3 along(daft_dvec3 a, double t, daft_dvec3 d)
{
    return (daft_dvec3){a.x + t * d.x, a.y + t * d.y, a.z + t * d.z};
}

/* The ray at a place of the picture, as far as the plane at distance 1. */
static daft_dvec3 ray_at(const daft_camera *camera, double x, double y, double aspect, const daft_dvec3 *forward)
{
    const daft_vec3 ray = daft_camera_ray(camera, x, y, aspect);
    const daft_dvec3 d = {(double)ray.x, (double)ray.y, (double)ray.z};
    const double s = forward ? 1 / dot(d, *forward) : 1;
    return (daft_dvec3){s * d.x, s * d.y, s * d.z};
}

static eye eye_of(const canvas *target, const daft_camera *camera)
{
    const double aspect = (double)target->height / (double)target->width;
    eye e = {.at = camera->position,
             .half_width = (double)canvas_hud_width(target) / 2,
             .half_height = CANVAS_HEIGHT / 2.0,
             .target = target};
    e.axes[2] = ray_at(camera, 0.5, 0.5, aspect, NULL);
    e.axes[0] = minus(ray_at(camera, 1, 0.5, aspect, &e.axes[2]), e.axes[2]);
    e.axes[1] = minus(ray_at(camera, 0.5, 1, aspect, &e.axes[2]), e.axes[2]);
    return e;
}

/* In the camera's axes; x and y are within -z to z in the picture. */
static daft_dvec3 look(const eye *e, daft_dvec3 point)
{
    const daft_dvec3 d = minus(point, e->at);
    return (daft_dvec3){dot(d, e->axes[0]) / dot(e->axes[0], e->axes[0]),
                        dot(d, e->axes[1]) / dot(e->axes[1], e->axes[1]), dot(d, e->axes[2])};
}

static canvas_point place(const eye *e, daft_dvec3 seen)
{
    return (canvas_point){(float)(e->half_width * (1 + seen.x / seen.z)),
                          (float)(e->half_height * (1 + seen.y / seen.z))};
}

static void draw_line(const eye *e, daft_dvec3 from, daft_dvec3 to, float width, canvas_color color)
{
    daft_dvec3 a = look(e, from), b = look(e, to);
    if (a.z < NEAR && b.z < NEAR) return;
    const daft_dvec3 d = minus(b, a);
    if (a.z < NEAR) a = along(a, (NEAR - a.z) / d.z, d);
    if (b.z < NEAR) b = along(b, (NEAR - b.z) / d.z, d);
    const canvas_point ends[2] = {place(e, a), place(e, b)};
    if (fmaxf(fabsf(ends[0].x), fabsf(ends[1].x)) > 1e5f || fmaxf(fabsf(ends[0].y), fabsf(ends[1].y)) > 1e5f) return;
    canvas_line(e->target, ends, 2, false, width, color);
}

static canvas_color color_of(const daft_body_edge *edge)
{
    if (edge->sensor) return SENSOR;
    if (edge->kind == DAFT_BODY_STATIC) return STATIC;
    return edge->kind == DAFT_BODY_KINEMATIC ? KINEMATIC : edge->awake ? AWAKE : ASLEEP;
}

static void draw_contacts(const eye *e, daft_scene *scene)
{
    daft_contact *all = malloc(XRAY_CONTACTS * sizeof *all);
    uint32_t count = all ? daft_scene_contacts(scene, all, XRAY_CONTACTS) : 0;
    for (uint32_t i = 0; i < count && i < XRAY_CONTACTS; i++) {
        const daft_dvec3 n = {(double)all[i].normal.x, (double)all[i].normal.y, (double)all[i].normal.z};
        const daft_dvec3 seen = look(e, all[i].point);
        if (seen.z < NEAR || seen.z > XRAY_METRES) continue;
        draw_line(e, all[i].point, along(all[i].point, 0.25, n), 2, CONTACT);
        const canvas_point at = place(e, seen);
        if (fabsf(at.x) < 1e4f && fabsf(at.y) < 1e4f) canvas_circle(e->target, at.x, at.y, 4, 0, CONTACT);
    }
    free(all);
}

uint32_t xray_draw(const canvas *target, daft_scene *scene, const daft_camera *camera)
{
    const eye e = eye_of(target, camera);
    daft_body_edge *edges = malloc(XRAY_EDGES * sizeof *edges);
    if (!edges) return 0;
    const uint32_t all = daft_scene_body_edges(scene, camera->position, XRAY_METRES, edges, XRAY_EDGES);
    for (uint32_t i = 0; i < all && i < XRAY_EDGES; i++)
        draw_line(&e, edges[i].from, edges[i].to, 1.5f, color_of(&edges[i]));
    free(edges);
    draw_contacts(&e, scene);
    return all;
}

/* ---- one entity ---- */

static const canvas_color OUTLINE = {255, 205, 90, 255};

static daft_dvec3 cross(daft_dvec3 a, daft_dvec3 b)
{
    return (daft_dvec3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static daft_dvec3 to_world(const daft_transform *t, daft_dvec3 p)
{
    const daft_dvec3 v = {(double)t->scale.x * p.x, (double)t->scale.y * p.y, (double)t->scale.z * p.z};
    const daft_dvec3 q = {(double)t->rotation.x, (double)t->rotation.y, (double)t->rotation.z}, u = cross(q, v);
    const daft_dvec3 turned = along(along(v, 2 * (double)t->rotation.w, u), 2, cross(q, u));
    return along(t->position, 1, turned);
}

static void draw_box(const eye *e, const daft_transform *t, daft_vec3 low, daft_vec3 high)
{
    daft_dvec3 corners[8];
    for (int i = 0; i < 8; i++)
        corners[i] = to_world(t, (daft_dvec3){(double)(i & 1 ? high.x : low.x), (double)(i & 2 ? high.y : low.y),
                                              (double)(i & 4 ? high.z : low.z)});
    for (int i = 0; i < 8; i++)
        for (int bit = 1; bit < 8; bit *= 2)
            if (!(i & bit)) draw_line(e, corners[i], corners[i | bit], 2, OUTLINE);
}

/* Where its surface is seen from the side. */
static void draw_ball(const eye *e, const daft_transform *t, double radius)
{
    enum { EDGES = 48 };
    const double r = radius * fabs((double)t->scale.x);
    const daft_dvec3 way = minus(t->position, e->at), side = e->axes[0];
    const double distance = sqrt(dot(way, way));
    if (!(distance > r)) return;
    const daft_dvec3 across = cross(way, cross(side, way)), up = cross(way, side);
    const double ring = r * sqrt(1 - r * r / (distance * distance)); /* of the circle of contact of the cone */
    const daft_dvec3 middle = along(t->position, -r * r / (distance * distance), way);
    const double a = ring / sqrt(dot(across, across)), b = ring / sqrt(dot(up, up));
    daft_dvec3 last = along(middle, a, across);
    for (int i = 1; i <= EDGES; i++) {
        const double angle = 6.283185307179586 * i / EDGES;
        const daft_dvec3 next = along(along(middle, a * cos(angle), across), b * sin(angle), up);
        draw_line(e, last, next, 2, OUTLINE);
        last = next;
    }
}

void xray_outline(const canvas *target, daft_scene *scene, const daft_camera *camera, daft_entity entity)
{
    const eye e = eye_of(target, camera);
    daft_entity_def def;
    daft_transform t;
    daft_mesh_info info;
    if (!daft_entity_get(scene, entity, &def, NULL) || !daft_entity_get_world_transform(scene, entity, &t, NULL))
        return;
    const daft_vec3 half = {def.size.x / 2, def.size.y / 2, def.size.z / 2};
    const daft_vec3 some = {0.25f, 0.25f, 0.25f};
    if (def.shape == DAFT_SHAPE_SPHERE)
        draw_ball(&e, &t, (double)def.radius);
    else if (def.shape == DAFT_SHAPE_BOX)
        draw_box(&e, &t, (daft_vec3){-half.x, -half.y, -half.z}, half);
    else if (def.shape == DAFT_SHAPE_MESH && daft_mesh_get_info(scene, def.mesh, &info, NULL))
        draw_box(&e, &t, info.low, info.high);
    else
        draw_box(&e, &t, (daft_vec3){-some.x, -some.y, -some.z}, some);
}
