/* render: where mirrors in mirrors end. */
#include "daft.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "stage.h"

static void add_box(stage *s, daft_dvec3 at, daft_vec3 size, float white, float mirror)
{
    daft_error error = {0};
    daft_material_def m = daft_default_material_def();
    m.ambient = m.diffuse = (daft_vec3){white, white, white}, m.specular = (daft_vec3){0, 0, 0};
    m.mirror = mirror;
    daft_entity_def def = daft_default_entity_def();
    def.shape = DAFT_SHAPE_BOX, def.size = size, def.position = at;
    def.material = daft_material_create(s->scene, &m, &error);
    if (!daft_entity_create(s->scene, &def, &error).id) fail_msg("%s", error.message);
}

/* Six mirrors around the camera, open at the edges of their box: what is left of the light after the last bounce is the
 * sky's mean, by its integral over all directions, and nothing is black. */
static void mirrors_in_mirrors_end_in_the_sky(void **unused)
{
    (void)unused;
    for (int depth = 1; depth < 4; depth++) {
        stage *s = stage_make(2, NULL);
        s->view.camera.position = (daft_dvec3){0, 0, 0};
        s->view.quality.edge_samples = 0, s->view.quality.mirror_depth = depth;
        daft_scene_set_ambient(s->scene, (daft_vec3){0, 0, 0});
        daft_scene_set_sky_gradient(s->scene, (daft_vec3){0.5f, 0.25f, 1}, (daft_vec3){1, 0.75f, 0.5f});
        const double at[6][3] = {{9, 0, 0}, {-9, 0, 0}, {0, 9, 0}, {0, -9, 0}, {0, 0, 9}, {0, 0, -9}};
        for (int i = 0; i < 6; i++) add_box(s, (daft_dvec3){at[i][0], at[i][1], at[i][2]}, (daft_vec3){8, 8, 8}, 0, 1);
        draw(s);
        int ended = 0;
        for (int i = 0; i < PIXELS; i++) {
            const double wanted[3] = {0.6 * 0.5 + 19.0 / 60, 0.6 * 0.25 + 0.75 * 19 / 60, 0.6 + 0.5 * 19 / 60};
            const daft_vec3 c = s->color[i];
            assert_true(c.x > 0.3f); /* black nowhere */
            ended +=
                fabs((double)c.x - wanted[0]) + fabs((double)c.y - wanted[1]) + fabs((double)c.z - wanted[2]) < 1e-4;
        }
        print_message("depth %d: %d of %d pixels end in the sky's mean\n", depth, ended, PIXELS);
        assert_true(ended > PIXELS / 20);
        stage_drop(s);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(mirrors_in_mirrors_end_in_the_sky)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
