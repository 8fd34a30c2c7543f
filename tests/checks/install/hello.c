/* The library in thirty lines: a red ball under the sun, looked at in the middle and in a corner. */
#include <daft.h>
#include <stdio.h>

int main(void)
{
    daft_error error = {0};
    char text[1200];
    daft_engine_def engine_def = daft_default_engine_def();
    daft_engine *engine = daft_engine_create(&engine_def, &error);
    daft_scene *scene = engine ? daft_scene_create(engine, &error) : NULL;
    daft_image *image = scene ? daft_image_create(engine, 64, 64, &error) : NULL;
    if (!image) return fprintf(stderr, "%s\n", daft_error_text(&error, text, sizeof text)), 1;

    daft_material_def paint = daft_default_material_def();
    paint.diffuse = paint.ambient = (daft_vec3){0.8f, 0.05f, 0.05f};
    daft_entity_def ball = daft_default_entity_def();
    ball.shape = DAFT_SHAPE_SPHERE, ball.radius = 1, ball.position.x = 3;
    ball.material = daft_material_create(scene, &paint, &error);
    daft_entity_create(scene, &ball, &error);
    daft_light_def sun = daft_default_light_def();
    sun.kind = DAFT_LIGHT_SUN, sun.direction = (daft_vec3){1, -1, 0.5f};
    daft_light_create(scene, &sun, &error);
    daft_scene_set_sky_color(scene, (daft_vec3){0.2f, 0.4f, 1});

    daft_view view = daft_default_view(); /* from the origin along +X */
    if (!daft_render(scene, &view, image, &error)) return fprintf(stderr, "%s\n", error.message), 1;
    const uint8_t *middle = daft_image_pixels(image) + 4 * (32 * 64 + 32), *corner = daft_image_pixels(image);
    printf("middle %d %d %d, corner %d %d %d\n", middle[0], middle[1], middle[2], corner[0], corner[1], corner[2]);
    int ok = middle[0] > 120 && middle[1] < 120 && middle[2] < 120 && corner[2] == 255 && corner[0] < 140;
    daft_image_destroy(image), daft_scene_destroy(scene), daft_engine_destroy(engine);
    return ok ? 0 : 1;
}
