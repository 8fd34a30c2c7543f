/* hello [IMAGE]: a red ball on a white floor, under the sun, as a PNG file. The shortest program that draws something.
 */
#include <daft.h>
#include <stdio.h>

static int fail(const daft_error *error)
{
    char text[1200];
    fprintf(stderr, "hello: %s\n", daft_error_text(error, text, sizeof text));
    return 1;
}

/* Definitions come from their default maker; change what matters and leave the rest. */
static bool fill(daft_scene *scene, daft_error *error)
{
    daft_material_def red = daft_default_material_def();
    red.ambient = red.diffuse = (daft_vec3){0.8f, 0.1f, 0.1f};

    daft_entity_def ball = daft_default_entity_def();
    ball.shape = DAFT_SHAPE_SPHERE;
    ball.radius = 0.5f;
    ball.position = (daft_dvec3){0, 0.5, 0};
    ball.material = daft_material_create(scene, &red, error);

    daft_entity_def floor = daft_default_entity_def();
    floor.shape = DAFT_SHAPE_BOX;
    floor.size = (daft_vec3){10, 0.1f, 10};
    floor.position = (daft_dvec3){0, -0.05, 0};

    daft_light_def sun = daft_default_light_def();
    sun.kind = DAFT_LIGHT_SUN;
    sun.direction = (daft_vec3){1, -2, 0.5f};

    daft_scene_set_sky_gradient(scene, (daft_vec3){0.2f, 0.4f, 0.9f}, (daft_vec3){0.8f, 0.9f, 1});
    return ball.material.id && daft_entity_create(scene, &ball, error).id &&
           daft_entity_create(scene, &floor, error).id && daft_light_create(scene, &sun, error).id;
}

int main(int argc, char **argv)
{
    daft_error error;
    daft_engine_def def = daft_default_engine_def();
    daft_engine *engine = daft_engine_create(&def, &error);
    if (!engine) return fail(&error);
    daft_scene *scene = daft_scene_create(engine, &error);
    daft_image *image = scene ? daft_image_create(engine, 640, 360, &error) : NULL;
    if (!image || !fill(scene, &error)) return fail(&error);

    daft_view view = daft_default_view();
    view.camera = daft_camera_look_at((daft_dvec3){-2.5, 1.5, 1}, (daft_dvec3){0, 0.4, 0}, 1);
    view.quality = daft_preset_quality(DAFT_PRESET_HIGH);
    if (!daft_render(scene, &view, image, &error)) return fail(&error);
    if (!daft_image_write(image, argc > 1 ? argv[1] : "hello.png", &error)) return fail(&error);

    daft_image_destroy(image);
    daft_scene_destroy(scene);
    daft_engine_destroy(engine);
    return 0;
}
