/* What is shown. */
#include "view/picture/content.h"

#include "common/showcase.h"

#include <math.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>

/* ---- whether it has changed ---- */

/* Adds the file's size and time to *sum. Whether it has changed since `began`. */
static bool add_stamp(const char *path, const struct timespec *began, uint64_t *sum)
{
    struct stat status;
    if (stat(path, &status) != 0) return false;
    uint64_t numbers[3] = {(uint64_t)status.st_size, (uint64_t)status.st_mtim.tv_sec, (uint64_t)status.st_mtim.tv_nsec};
    *sum += daft_hash(numbers, sizeof numbers, daft_hash(path, strlen(path), 0));
    return status.st_mtim.tv_sec > began->tv_sec ||
           (status.st_mtim.tv_sec == began->tv_sec && status.st_mtim.tv_nsec >= began->tv_nsec);
}

static uint64_t stamp_since(const content *c, const struct timespec *began)
{
    uint64_t sum = 0;
    bool fresh = add_stamp(c->path, began, &sum);
    for (uint32_t i = 0; c->scene && i < daft_scene_file_count(c->scene); i++)
        fresh |= add_stamp(daft_scene_get_file(c->scene, i), began, &sum);
    return fresh ? sum + 1 : sum; /* it may have been read before the change: another stamp than the next one's */
}

uint64_t content_stamp(const content *c)
{
    const struct timespec never = {.tv_sec = INT32_MAX};
    return stamp_since(c, &never);
}

/* ---- opening ---- */

static bool choose_camera(content *c, long camera, double aspect, daft_error *error)
{
    uint32_t count = daft_scene_camera_count(c->scene);
    if (camera >= (long)count && camera > 0)
        return fail(error, DAFT_ERROR_ARGUMENT, "--camera %ld: %s has %u camera%s, counted from 0", camera, c->path,
                    count, count == 1 ? "" : "s");
    if (count > 0) return daft_scene_get_camera(c->scene, camera < 0 ? 0 : (uint32_t)camera, &c->start, error);
    if (c->size > 0) c->start = showcase_camera(c->low, c->high, aspect);
    return true;
}

static bool measure(content *c, daft_error *error)
{
    *error = (daft_error){0};
    if (!daft_scene_get_bounds(c->scene, &c->low, &c->high, error)) return error->code == DAFT_OK;
    double x = c->high.x - c->low.x, y = c->high.y - c->low.y, z = c->high.z - c->low.z;
    c->size = sqrt(x * x + y * y + z * z);
    return true;
}

static bool open_scene(content *c, daft_engine *engine, long camera, double aspect, daft_error *error)
{
    c->scene = daft_scene_create(engine, error);
    if (!c->scene) return false;
    return (showcase_is_mesh(c->path) ? showcase_mesh(c->scene, c->path, aspect, error)
                                      : daft_scene_load(c->scene, c->path, error)) &&
           measure(c, error) && choose_camera(c, camera, aspect, error);
}

bool content_open(content *out, daft_engine *engine, const char *path, long camera, double aspect, daft_error *error)
{
    content c = {.start = daft_default_camera()};
    if ((size_t)snprintf(c.path, sizeof c.path, "%s", path) >= sizeof c.path)
        return fail(error, DAFT_ERROR_ARGUMENT, "the name of the file is too long");
    struct timespec began;
    clock_gettime(CLOCK_REALTIME, &began);
    bool scene = has_extension(path, ".scene") || showcase_is_mesh(path), good;
    if (scene)
        good = open_scene(&c, engine, camera, aspect, error);
    else
        good = (c.image = daft_image_load(engine, path, error)) != NULL;
    if (good)
        c.stamp = stamp_since(&c, &began), *out = c;
    else
        content_close(&c);
    return good;
}

void content_close(content *c)
{
    daft_scene_destroy(c->scene);
    daft_image_destroy(c->image);
    c->scene = NULL, c->image = NULL;
}
