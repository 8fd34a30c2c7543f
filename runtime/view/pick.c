/* What lies under the cursor. */
#include "view/viewer.h"

#include <inttypes.h>
#include <math.h>

bool pick_point(viewer *v, daft_ray_hit *hit)
{
    daft_error error = {0};
    if (!v->content.scene) return false;
    daft_vec3 ray = daft_camera_ray(&v->flight.camera, v->mouse_x, v->mouse_y, viewer_aspect(v));
    return daft_scene_cast_ray(v->content.scene, v->flight.camera.position, ray, INFINITY, (daft_entity){0}, hit,
                               &error);
}

static void pick_pixel(viewer *v)
{
    const daft_image *image = v->content.image;
    int width, height, across = daft_image_width(image), down = daft_image_height(image);
    v->def->screen->get_size(v->def->screen, &width, &height);
    double x = floor(v->place.x * across + (v->mouse_x - 0.5) * width / v->place.zoom);
    double y = floor(v->place.y * down + (v->mouse_y - 0.5) * height / v->place.zoom);
    if (!(x >= 0 && y >= 0 && x < across && y < down)) return;
    const uint8_t *p = daft_image_pixels(v->content.image) + 4 * ((size_t)y * (size_t)across + (size_t)x);
    snprintf(v->found, sizeof v->found, "pixel %.0f, %.0f\nred %d   green %d   blue %d   alpha %d", x, y, p[0], p[1],
             p[2], p[3]);
}

void pick(viewer *v)
{
    daft_ray_hit hit;
    v->found[0] = 0;
    v->hit = false;
    v->repaint = true;
    if (v->content.image) {
        pick_pixel(v);
        return;
    }
    if (!pick_point(v, &hit)) {
        snprintf(v->found, sizeof v->found, "the sky");
        return;
    }
    v->hit = true, v->point = hit.position;
    char name[256];
    daft_material_name(v->content.scene, hit.material, name, sizeof name);
    if (!name[0]) snprintf(name, sizeof name, hit.material.id ? "without a name" : "the default one");
    snprintf(v->found, sizeof v->found,
             "entity 0x%" PRIx32 "   triangle %" PRIu32 "   at %.5g m\nmaterial %.100s\n"
             "position %.6g  %.6g  %.6g\nnormal %.3f  %.3f  %.3f   texture %.4g  %.4g",
             hit.entity.id, hit.triangle, (double)hit.distance, name, hit.position.x, hit.position.y, hit.position.z,
             (double)hit.normal.x, (double)hit.normal.y, (double)hit.normal.z, (double)hit.uv.x, (double)hit.uv.y);
}
