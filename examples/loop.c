/* loop [FRAMES]: a tower of boxes is hit by a ball, and every tick is drawn into one image that is used again, as a
 * program does that shows it in a window or sends it elsewhere. Prints the time of a frame, and a hash that is the same
 * on every machine; the last frame becomes loop.png. */
#include <daft.h>
#include <stdio.h>
#include <stdlib.h>

enum { WIDTH = 480, HEIGHT = 270, BOXES = 8 };
static const float TICK = 1.0f / 60; /* seconds */

static int fail(const daft_error *error)
{
    char text[1200];
    fprintf(stderr, "loop: %s\n", daft_error_text(error, text, sizeof text));
    return 1;
}

static daft_entity add_box(daft_scene *scene, daft_body_kind body, daft_vec3 size, daft_dvec3 position,
                           daft_error *error)
{
    daft_entity_def box = daft_default_entity_def();
    box.shape = DAFT_SHAPE_BOX;
    box.size = size, box.position = position, box.body = body;
    return daft_entity_create(scene, &box, error);
}

static bool fill(daft_scene *scene, daft_error *error)
{
    bool made = add_box(scene, DAFT_BODY_STATIC, (daft_vec3){20, 1, 20}, (daft_dvec3){0, -0.5, 0}, error).id;
    for (int i = 0; i < BOXES && made; i++)
        made =
            add_box(scene, DAFT_BODY_DYNAMIC, (daft_vec3){0.6f, 0.4f, 0.6f}, (daft_dvec3){0, 0.2 + 0.4 * i, 0}, error)
                .id;

    daft_entity_def ball = daft_default_entity_def();
    ball.shape = DAFT_SHAPE_SPHERE, ball.radius = 0.3f;
    ball.position = (daft_dvec3){-6, 2, 0}, ball.body = DAFT_BODY_DYNAMIC;
    daft_entity thrown = made ? daft_entity_create(scene, &ball, error) : (daft_entity){0};

    daft_light_def sun = daft_default_light_def();
    sun.kind = DAFT_LIGHT_SUN, sun.direction = (daft_vec3){1, -2, 1};
    daft_scene_set_sky_gradient(scene, (daft_vec3){0.2f, 0.4f, 0.9f}, (daft_vec3){0.8f, 0.9f, 1});
    return thrown.id && daft_light_create(scene, &sun, error).id &&
           daft_entity_set_velocity(scene, thrown, (daft_vec3){12, 2, 0}, (daft_vec3){0, 0, 0}, error);
}

/* One tick of the simulation, one picture of it. From the second frame on, nothing is allocated. */
static bool advance(daft_scene *scene, const daft_view *view, daft_image *image, daft_error *error)
{
    daft_scene_begin_tick(scene);
    return daft_scene_step(scene, TICK, error) && daft_render(scene, view, image, error);
}

int main(int argc, char **argv)
{
    int frames = argc > 1 ? atoi(argv[1]) : 120;
    daft_error error;
    daft_engine_def def = daft_default_engine_def();
    daft_engine *engine = daft_engine_create(&def, &error);
    daft_scene *scene = engine ? daft_scene_create(engine, &error) : NULL;
    daft_image *image = scene ? daft_image_create(engine, WIDTH, HEIGHT, &error) : NULL;
    if (!image || !fill(scene, &error)) return fail(&error);

    daft_view view = daft_default_view();
    view.camera = daft_camera_look_at((daft_dvec3){-4, 3, 6}, (daft_dvec3){0, 1, 0}, 1);
    double ms = 0;
    uint64_t hash = 0;
    for (int i = 0; i < frames; i++) {
        if (!advance(scene, &view, image, &error)) return fail(&error);
        ms += daft_scene_counters(scene)->frame_ms;
        hash = daft_hash(daft_image_pixels(image), 4 * WIDTH * HEIGHT, hash); /* here a program would show the picture
                                                                               */
    }
    if (!daft_image_write(image, "loop.png", &error)) return fail(&error);
    printf("%d frames, %.2f ms each\n", frames, frames ? ms / frames : 0);
    printf("pictures %016llx, state %016llx\n", (unsigned long long)hash, (unsigned long long)daft_scene_hash(scene));

    daft_image_destroy(image);
    daft_scene_destroy(scene);
    daft_engine_destroy(engine);
    return 0;
}
