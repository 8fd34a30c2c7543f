/* Any bytes as an MTL file: what loads has finite numbers in their ranges, and strings that end. */
#include "fuzz.h"

#include "geometry/mesh.h"

#include <math.h>
#include <string.h>

static void check_color(daft_vec3 color)
{
    FUZZ_CHECK(isfinite(color.x) && isfinite(color.y) && isfinite(color.z));
    FUZZ_CHECK(color.x >= 0 && color.y >= 0 && color.z >= 0);
}

static void check_material(const daft_mtl *material)
{
    FUZZ_CHECK(memchr(material->name, 0, sizeof material->name) && material->name[0]);
    FUZZ_CHECK(memchr(material->file, 0, sizeof material->file));
    FUZZ_CHECK(memchr(material->diffuse_map, 0, sizeof material->diffuse_map));
    check_color(material->ambient);
    check_color(material->diffuse);
    check_color(material->specular);
    check_color(material->emission);
    FUZZ_CHECK(material->shininess >= 0 && material->shininess <= 1000);
    FUZZ_CHECK(material->index > 0 && material->index <= 10);
    FUZZ_CHECK(material->opacity >= 0 && material->opacity <= 1);
    FUZZ_CHECK(material->illum >= 0 && material->illum <= 10);
}

int mtl_input(const uint8_t *data, size_t size)
{
    daft_allocator allocator = daft_malloc_allocator();
    char path[512], *text = malloc(size + 1);
    snprintf(path, sizeof path, "%s/input.mtl", fuzz_folder());
    if (size > 0) memcpy(text, data, size);
    text[size] = 0;
    daft_mtl_list list = {0};
    daft_error error = {0};
    bool good = daft_mtl_parse(&allocator, NULL, path, text, size, NULL, &list, &error);
    fuzz_check_error(good, &error);
    FUZZ_CHECK(good || list.count == 0);
    for (size_t i = 0; i < list.count; i++) check_material(&list.items[i]);
    daft_mtl_list_free(&allocator, &list);
    free(text);
    return 0;
}
