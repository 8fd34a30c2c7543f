/* Checkpoints. */
#include "view/route.h"

#include "common/util.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static bool make_room(route *r, daft_error *error)
{
    if (!r->points) r->points = calloc(ROUTE_POINTS, sizeof *r->points);
    if (!r->points) return fail(error, DAFT_ERROR_MEMORY, "out of memory for the camera path");
    return r->count < ROUTE_POINTS ||
           fail(error, DAFT_ERROR_ARGUMENT, "a camera path has at most %d checkpoints here", ROUTE_POINTS);
}

bool route_load(route *r, daft_scene *scene, daft_error *error)
{
    uint32_t count = daft_scene_path_count(scene);
    r->count = 0;
    r->unsaved = false;
    for (uint32_t i = 0; i < count; i++) {
        if (!make_room(r, error) || !daft_scene_get_checkpoint(scene, i, &r->points[i], error)) return false;
        r->count++;
    }
    return true;
}

void route_free(route *r)
{
    free(r->points);
    *r = (route){0};
}

bool route_add(route *r, const daft_camera *camera, double speed, daft_error *error)
{
    if (!make_room(r, error)) return false;
    daft_checkpoint *made = &r->points[r->count];
    *made = (daft_checkpoint){.camera = *camera};
    if (r->count > 0) {
        const daft_checkpoint *last = made - 1;
        daft_dvec3 a = last->camera.position, b = camera->position;
        double x = b.x - a.x, y = b.y - a.y, z = b.z - a.z, way = sqrt(x * x + y * y + z * z);
        double seconds = speed > 0 ? way / speed : 0;
        made->time = last->time + ceil(fmax(0.5, fmin(seconds, 60)) * 10) / 10;
    }
    r->count++;
    r->unsaved = true;
    return true;
}

void route_remove(route *r, uint32_t index)
{
    if (index >= r->count) return;
    memmove(&r->points[index], &r->points[index + 1], (r->count - index - 1) * sizeof *r->points);
    r->count--;
    if (r->count > 0 && index == 0) { /* a path begins at 0 */
        double first = r->points[0].time;
        for (uint32_t i = 0; i < r->count; i++) r->points[i].time -= first;
    }
    r->unsaved = true;
}

void route_delay(route *r, uint32_t index, double seconds)
{
    if (index == 0 || index >= r->count) return;
    double shortest = r->points[index - 1].time + 0.1 - r->points[index].time;
    if (seconds < shortest) seconds = shortest;
    for (uint32_t i = index; i < r->count; i++) r->points[i].time += seconds;
    r->unsaved = true;
}

/* ---- files ---- */

void route_print(const route *r, FILE *out)
{
    const double degrees = 57.29577951308232;
    for (uint32_t i = 0; i < r->count; i++) {
        const daft_camera *c = &r->points[i].camera;
        fprintf(out, "path %.10g   %.15g %.15g %.15g   %.7g %.7g %.7g", r->points[i].time, c->position.x, c->position.y,
                c->position.z, (double)c->pitch * degrees, (double)c->yaw * degrees, (double)c->fov * degrees);
        if (c->roll != 0) fprintf(out, " roll=%.7g", (double)c->roll * degrees);
        fputc('\n', out);
    }
}

static bool is_path_item(const char *line)
{
    line += strspn(line, " \t");
    return strncmp(line, "path", 4) == 0 && (line[4] == ' ' || line[4] == '\t');
}

/* Whether all checkpoints of the scene come from this text. */
static bool path_stands_here(const char *text, const daft_scene *scene)
{
    uint32_t found = 0;
    for (const char *line = text; line; line = strchr(line, '\n')) {
        line += *line == '\n';
        found += is_path_item(line);
    }
    return found >= daft_scene_path_count(scene);
}

/* Copies every line but the path's. */
static void copy_others(const char *text, FILE *out)
{
    for (const char *end; *text; text = end) {
        end = strchr(text, '\n');
        end = end ? end + 1 : text + strlen(text);
        if (is_path_item(text)) continue;
        fwrite(text, 1, (size_t)(end - text), out);
        if (end[-1] != '\n') fputc('\n', out);
    }
}

bool route_save(route *r, const daft_scene *scene, const char *path, daft_error *error)
{
    size_t size;
    draft_file out;
    if (!has_extension(path, ".scene")) return fail_at(error, path, 0, 0, "only a .scene file can hold a camera path");
    char *text = daft_read_file(NULL, path, &size, error);
    if (!text) return false;
    bool good = path_stands_here(text, scene) ||
                fail_at(error, path, 0, 0, "its camera path stands in a file that it includes: change it there");
    good = good && draft_open(&out, error);
    if (good) {
        copy_others(text, out.file);
        route_print(r, out.file);
        good = draft_commit(&out, path, error);
    }
    free(text);
    r->unsaved &= !good;
    return good;
}
