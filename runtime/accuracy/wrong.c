/* Pixels that see something else than exact visibility shows them. */
#include "accuracy/sweep.h"

#include "common/util.h"

#include <stdlib.h>

enum { DOT = 2 /* pixels on each side of its middle */ };

typedef struct seen {
    daft_entity *entity;
    uint32_t *triangle;
} seen;

static bool look(daft_scene *scene, const daft_view *from, daft_intersection how, daft_image *image, const seen *out,
                 daft_error *error)
{
    daft_view view = *from;
    view.quality = daft_preset_quality(DAFT_PRESET_DRAFT);
    view.quality.visibility = how;
    view.without = DAFT_WITHOUT_SHADING;
    view.aov = (daft_aov){.entity = out->entity, .triangle = out->triangle};
    view.history = NULL, view.progress = NULL;
    return daft_render(scene, &view, image, error);
}

bool wrong_find(daft_engine *engine, daft_scene *scene, const daft_view *view, int width, int height, uint8_t *mask,
                size_t *count, daft_error *error)
{
    const size_t pixels = (size_t)width * (size_t)height;
    seen all[2] = {{0}};
    daft_image *image = daft_image_create(engine, width, height, error);
    bool good = image != NULL;
    for (int k = 0; good && k < 2; k++) {
        all[k] = (seen){calloc(pixels, sizeof(daft_entity)), calloc(pixels, sizeof(uint32_t))};
        good = (all[k].entity && all[k].triangle) || fail(error, DAFT_ERROR_MEMORY, "out of memory for pixels");
        good = good && look(scene, view, k ? DAFT_INTERSECT_EXACT : view->quality.visibility, image, &all[k], error);
    }
    *count = 0;
    for (size_t i = 0; good && i < pixels; i++) {
        mask[i] = all[0].entity[i].id != all[1].entity[i].id || all[0].triangle[i] != all[1].triangle[i];
        *count += mask[i];
    }
    for (int k = 0; k < 2; k++) free(all[k].entity), free(all[k].triangle);
    daft_image_destroy(image);
    return good;
}

void wrong_paint(const uint8_t *mask, int width, int height, uint8_t *pixels)
{
    for (int i = 0; i < width * height; i++) {
        if (!mask[i]) continue;
        for (int dy = -DOT; dy <= DOT; dy++) {
            for (int dx = -DOT; dx <= DOT; dx++) {
                const int x = i % width + dx, y = i / width + dy;
                if (x < 0 || y < 0 || x >= width || y >= height || dx * dx + dy * dy > DOT * DOT + 1) continue;
                uint8_t *p = pixels + 4 * ((size_t)y * (size_t)width + (size_t)x);
                p[0] = 255, p[1] = 0, p[2] = 0, p[3] = 255;
            }
        }
    }
}
