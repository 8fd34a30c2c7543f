/* daft scan: what a laser scanner measures in a scene, as a cloud of points. */
#include "cli/commands.h"

#include "cli/cli.h"
#include "common/showcase.h"
#include "common/util.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const cli_command COMMAND = {
    "scan",
    "SCENE",
    "Measures a .scene file or a mesh (.obj, .gltf, .fbx, ...) with a laser scanner (lidar), and writes the points it "
    "finds.",
    "The sensor stands at the scene's camera, level, and looks the way it looks; a grid is also tilted with it. The "
    "name\n"
    "after -o chooses the format: .ply (x, y, z as doubles) or .pcd (as floats), both binary, in the world's axes, "
    "with\n"
    "range, intensity, time, ray, return, entity and triangle of each point.",
    1,
    1};

enum { FIRST = 1, LAST = 2, BOTH = 3 };

typedef struct scan_options {
    const char *scene, *out, *isa, *pattern, *returns, *at, *velocity, *spin, *rays;
    long camera, threads, rows, columns, seed;
    double bottom, top, left, right, duration, nearest, farthest, noise, drop_out;
    uint64_t memory;
    bool camera_given;
} scan_options;

/* ---- files of points ---- */

typedef struct field {
    const char *name;
    char type; /* F or U */
    size_t size, offset;
} field;

/* A point as both formats hold it, but for the size of its coordinates. */
typedef struct point {
    double at[3];
    float range, intensity, seconds;
    uint32_t ray, number, entity, triangle;
} point;

static const field FIELDS[] = {{"range", 'F', sizeof(float), offsetof(point, range)},
                               {"intensity", 'F', sizeof(float), offsetof(point, intensity)},
                               {"time", 'F', sizeof(float), offsetof(point, seconds)},
                               {"ray", 'U', sizeof(uint32_t), offsetof(point, ray)},
                               {"return", 'U', sizeof(uint32_t), offsetof(point, number)},
                               {"entity", 'U', sizeof(uint32_t), offsetof(point, entity)},
                               {"triangle", 'U', sizeof(uint32_t), offsetof(point, triangle)}};

typedef struct cloud {
    daft_writer *to;
    bool ply;
    uint64_t count;
} cloud;

static void put_text(daft_writer *to, const char *text) { daft_writer_put(to, text, strlen(text)); }

/* Before the points are counted: their number gets its place later, in this many digits. */
enum { DIGITS = 10 };

static uint64_t put_header(cloud *c, uint64_t count)
{
    char text[2000];
    size_t used;
    if (c->ply) {
        used = (size_t)snprintf(text, sizeof text,
                                "ply\nformat binary_little_endian 1.0\ncomment daft scan\nelement vertex %0*" PRIu64
                                "\nproperty double x\nproperty double y\nproperty double z\n",
                                DIGITS, count);
        for (size_t i = 0; i < COUNT_OF(FIELDS); i++)
            used += (size_t)snprintf(text + used, sizeof text - used, "property %s %s\n",
                                     FIELDS[i].type == 'F' ? "float" : "uint", FIELDS[i].name);
        used += (size_t)snprintf(text + used, sizeof text - used, "end_header\n");
    } else {
        used = (size_t)snprintf(text, sizeof text,
                                "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z");
        for (size_t i = 0; i < COUNT_OF(FIELDS); i++)
            used += (size_t)snprintf(text + used, sizeof text - used, " %s", FIELDS[i].name);
        used += (size_t)snprintf(text + used, sizeof text - used, "\nSIZE 4 4 4 4 4 4 4 4 4 4\nTYPE F F F");
        for (size_t i = 0; i < COUNT_OF(FIELDS); i++)
            used += (size_t)snprintf(text + used, sizeof text - used, " %c", FIELDS[i].type);
        used += (size_t)snprintf(text + used, sizeof text - used,
                                 "\nCOUNT 1 1 1 1 1 1 1 1 1 1\nWIDTH %0*" PRIu64 "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\n"
                                 "POINTS %0*" PRIu64 "\nDATA binary\n",
                                 DIGITS, count, DIGITS, count);
    }
    if (count == 0)
        put_text(c->to, text);
    else
        daft_writer_put_at(c->to, 0, text, used);
    return used;
}

static void put_point(cloud *c, const point *p)
{
    uint8_t bytes[sizeof *p];
    size_t used = 0;
    for (int i = 0; i < 3; i++) {
        const float single = (float)p->at[i];
        const size_t size = c->ply ? sizeof p->at[i] : sizeof single;
        memcpy(bytes + used, c->ply ? (const void *)&p->at[i] : (const void *)&single, size);
        used += size;
    }
    for (size_t i = 0; i < COUNT_OF(FIELDS); i++) {
        memcpy(bytes + used, (const char *)p + FIELDS[i].offset, FIELDS[i].size);
        used += FIELDS[i].size;
    }
    daft_writer_put(c->to, bytes, used);
    c->count++;
}

static bool put_return(cloud *c, const daft_scan_def *def, uint32_t ray, uint32_t number, const daft_scan_return *got,
                       daft_error *error)
{
    daft_dvec3 origin;
    daft_vec3 way;
    double seconds;
    if (!(got->range > 0)) return true;
    if (!daft_scan_ray(def, ray, &origin, &way, &seconds, error)) return false;
    const double range = (double)got->range;
    const point p = {
        {origin.x + range * (double)way.x, origin.y + range * (double)way.y, origin.z + range * (double)way.z},
        got->range,
        got->intensity,
        (float)seconds,
        ray,
        number,
        got->entity.id,
        got->triangle};
    put_point(c, &p);
    return true;
}

static bool write_points(const scan_options *o, const daft_scan_def *def, const daft_scan_return *first,
                         const daft_scan_return *last, uint64_t *count, daft_error *error)
{
    cloud c = {.to = daft_writer_begin(o->out, error), .ply = has_extension(o->out, ".ply")};
    if (!c.to) return false;
    put_header(&c, 0);
    bool good = true;
    const bool wants_first = !o->returns || strcmp(o->returns, "last") != 0;
    for (uint32_t i = 0; good && i < daft_scan_size(def); i++) {
        if (wants_first) good = put_return(&c, def, i, FIRST, &first[i], error);
        if (good && last) good = put_return(&c, def, i, LAST, &last[i], error);
    }
    if (c.count > 0) put_header(&c, c.count);
    *count = c.count;
    if (good) return daft_writer_commit(c.to, error);
    daft_writer_abandon(c.to);
    return false;
}

/* ---- the sensor ---- */

static bool parse_vector(const char *option, const char *text, double out[3], daft_error *error)
{
    const daft_field three = {.name = option, .type = DAFT_FIELD_POSITION, .size = sizeof(daft_dvec3)};
    daft_dvec3 v;
    if (!text) return true;
    if (!daft_field_parse(&three, text, &v, error)) return false;
    out[0] = v.x, out[1] = v.y, out[2] = v.z;
    return true;
}

/* Directions, one in a line. */
static bool read_rays(const char *path, daft_vec3 **out, uint32_t *count, daft_error *error)
{
    size_t size, used = 0;
    char *text = daft_read_file(NULL, path, &size, error);
    if (!text) return false;
    *out = malloc((size / 6 + 1) * sizeof **out); /* a line has three digits, two blanks and its end, at least */
    bool good = *out || fail(error, DAFT_ERROR_MEMORY, "out of memory for the rays of %s", path);
    int line = 0;
    for (char *at = text, *end; good && *at; at = end) {
        float v[3];
        int taken = 0;
        line++;
        end = strchr(at, '\n');
        if (end) *end++ = 0;
        if (!end) end = at + strlen(at);
        if (at[strspn(at, " \t\r")] == 0 || at[0] == '#') continue;
        good = (sscanf(at, "%f %f %f %n", &v[0], &v[1], &v[2], &taken) == 3 && at[taken] == 0) ||
               fail_at(error, path, line, 1, "three numbers expected: a direction, as in: 1 0 -0.5");
        if (good) (*out)[used++] = (daft_vec3){v[0], v[1], v[2]};
    }
    free(text);
    *count = (uint32_t)used;
    return good && (used > 0 || fail_at(error, path, 0, 0, "there is no ray in this file"));
}

static daft_quat look_along(const daft_camera *camera, bool tilted)
{
    /* Turned about y by -yaw, and before that about z by -pitch. */
    const double yaw = -(double)camera->yaw / 2, pitch = tilted ? -(double)camera->pitch / 2 : 0;
    const double sy = daft_sin(yaw), cy = daft_cos(yaw), sz = daft_sin(pitch), cz = daft_cos(pitch);
    return (daft_quat){(float)(sy * sz), (float)(sy * cz), (float)(cy * sz), (float)(cy * cz)};
}

static bool choose_pattern(const scan_options *o, daft_scan_def *def, daft_error *error)
{
    const daft_field *pattern = daft_field_find(DAFT_STRUCT_SCAN_DEF, "pattern");
    if (o->rays) def->pattern = DAFT_SCAN_RAYS;
    return !o->pattern || daft_field_parse(pattern, o->pattern, def, error);
}

static bool describe(const scan_options *o, const daft_camera *camera, daft_scan_def *out, daft_error *error)
{
    const double radians = 0.017453292519943295;
    double at[3] = {camera->position.x, camera->position.y, camera->position.z}, velocity[3] = {0}, spin[3] = {0};
    *out = daft_default_scan_def();
    if (!choose_pattern(o, out, error) || !parse_vector("--at", o->at, at, error) ||
        !parse_vector("--velocity", o->velocity, velocity, error) || !parse_vector("--spin", o->spin, spin, error))
        return false;
    out->rotation = look_along(camera, out->pattern != DAFT_SCAN_SPINNING);
    out->position = (daft_dvec3){at[0], at[1], at[2]};
    out->velocity = (daft_vec3){(float)velocity[0], (float)velocity[1], (float)velocity[2]};
    out->spin = (daft_vec3){(float)spin[0], (float)spin[1], (float)spin[2]};
    out->rows = (uint32_t)o->rows, out->columns = (uint32_t)o->columns;
    out->bottom = (float)(o->bottom * radians), out->top = (float)(o->top * radians);
    out->left = (float)(o->left * radians), out->right = (float)(o->right * radians);
    out->duration = (float)o->duration;
    out->min_range = (float)o->nearest, out->max_range = (float)o->farthest;
    out->range_noise = (float)o->noise, out->drop_out = (float)o->drop_out;
    out->seed = (uint64_t)o->seed;
    return true;
}

/* ---- the command ---- */

static bool choose_camera(daft_scene *scene, const scan_options *o, daft_camera *camera, daft_error *error)
{
    const uint32_t count = daft_scene_camera_count(scene);
    if (o->camera < (long)count) return daft_scene_get_camera(scene, (uint32_t)o->camera, camera, error);
    if (o->camera == 0) return true;
    return fail(error, DAFT_ERROR_ARGUMENT, "--camera %ld: %s has %u camera%s, counted from 0", o->camera, o->scene,
                count, count == 1 ? "" : "s");
}

static bool load(daft_scene *scene, const scan_options *o, daft_camera *camera, daft_error *error)
{
    *camera = daft_default_camera();
    return (showcase_is_mesh(o->scene) ? showcase_mesh(scene, o->scene, 1, error)
                                       : daft_scene_load(scene, o->scene, error)) &&
           choose_camera(scene, o, camera, error);
}

static bool scan_and_write(daft_scene *scene, const scan_options *o, const daft_scan_def *def, daft_error *error)
{
    const uint32_t rays = daft_scan_size(def);
    uint64_t points = 0;
    const bool two = o->returns && strcmp(o->returns, "first") != 0;
    daft_scan_return *first = calloc(rays, sizeof *first), *last = two ? calloc(rays, sizeof *last) : NULL;
    bool good = (first && (last || !two)) || fail(error, DAFT_ERROR_MEMORY, "out of memory for %u rays", rays);
    const uint64_t began = clock_now_ns();
    good = good && daft_scan(scene, def, first, last, error);
    const double seconds = (double)(clock_now_ns() - began) / 1e9;
    good = good && write_points(o, def, first, last, &points, error);
    if (good)
        fprintf(stderr,
                "daft: wrote %s: %" PRIu64 " points of %u rays, found in %.1f ms (%.1f million rays a second)\n",
                o->out, points, rays, seconds * 1e3, rays / seconds / 1e6);
    free(first);
    free(last);
    return good;
}

static bool run(daft_engine *engine, const scan_options *o, daft_error *error)
{
    daft_scan_def def;
    daft_camera camera;
    daft_vec3 *rays = NULL;
    daft_scene *scene = daft_scene_create(engine, error);
    bool good = scene && load(scene, o, &camera, error) && describe(o, &camera, &def, error) &&
                (!o->rays || read_rays(o->rays, &rays, &def.ray_count, error));
    if (good) def.rays = rays;
    if (good && daft_scan_size(&def) == 0) { /* says why */
        daft_scan_return none;
        good = daft_scan(scene, &def, &none, NULL, error) && fail(error, DAFT_ERROR_ARGUMENT, "there are no rays");
    }
    good = good && scan_and_write(scene, o, &def, error);
    free(rays);
    daft_scene_destroy(scene);
    return good;
}

static int refuse_options(const scan_options *o)
{
    if (!o->out) return cli_refuse("scan", "-o FILE is missing");
    if (!has_extension(o->out, ".ply") && !has_extension(o->out, ".pcd"))
        return cli_refuse("scan", "-o: a name that ends in .ply or .pcd expected, got '%s'", o->out);
    if (!has_extension(o->scene, ".scene") && !showcase_is_mesh(o->scene) && path_is_file(o->scene))
        return cli_refuse("scan", "'%s' is neither a .scene nor a mesh (.obj, .gltf, .fbx, ...)", o->scene);
    if (o->returns && strcmp(o->returns, "first") != 0 && strcmp(o->returns, "last") != 0 &&
        strcmp(o->returns, "both") != 0)
        return cli_refuse("scan", "--returns: one of first, last, both expected, got '%s'", o->returns);
    if (o->pattern && strcmp(o->pattern, "spinning") != 0 && strcmp(o->pattern, "grid") != 0)
        return cli_refuse("scan", "--pattern: spinning or grid expected, got '%s'; --rays FILE has a list", o->pattern);
    if (o->pattern && o->rays) return cli_refuse("scan", "--pattern and --rays exclude each other");
    return STATUS_DONE;
}

int command_scan(int argc, char **argv)
{
    scan_options o = {.rows = 64,
                      .columns = 2048,
                      .seed = 1,
                      .bottom = -25,
                      .top = 15,
                      .left = -45,
                      .right = 45,
                      .duration = 0.1,
                      .nearest = 0.3,
                      .farthest = 120};
    const cli_option options[] = {
        {"output", 'o', CLI_TEXT, "FILE", &o.out, 0, 0, "the points to write: .ply or .pcd (required)"},
        {"pattern", 0, CLI_TEXT, "P", &o.pattern, 0, 0,
         "spinning: beams that turn once (default), or grid: a field of view"},
        {"rays", 0, CLI_TEXT, "FILE", &o.rays, 0, 0,
         "rays of your own: a direction in each line, x forward, y up, z right"},
        {"rows", 0, CLI_COUNT, "N", &o.rows, 1, 4096, "beams one above the other, or rows of the grid (64)"},
        {"columns", 0, CLI_COUNT, "N", &o.columns, 1, 65536, "steps of a turn, or columns of the grid (2048)"},
        {"bottom", 0, CLI_NUMBER, "DEG", &o.bottom, -90, 90, "elevation of the lowest row (-25)"},
        {"top", 0, CLI_NUMBER, "DEG", &o.top, -90, 90, "elevation of the highest row (15)"},
        {"left", 0, CLI_NUMBER, "DEG", &o.left, -180, 180, "left end of a grid (-45)"},
        {"right", 0, CLI_NUMBER, "DEG", &o.right, -180, 180, "right end of a grid (45)"},
        {"returns", 0, CLI_TEXT, "R", &o.returns, 0, 0,
         "first (default), last: behind what lets light through, or both"},
        {"min-range", 0, CLI_NUMBER, "M", &o.nearest, 0, 1000000, "nothing comes back from nearer (0.3)"},
        {"max-range", 0, CLI_NUMBER, "M", &o.farthest, 0, 1000000000, "nor from farther away (120)"},
        {"noise", 0, CLI_NUMBER, "M", &o.noise, 0, 1000, "standard deviation of the range (0)"},
        {"drop-out", 0, CLI_NUMBER, "P", &o.drop_out, 0, 1, "share of returns that get lost (0)"},
        {"seed", 0, CLI_COUNT, "N", &o.seed, 0, 1000000000, "of noise and drop-out (1)"},
        {"at", 0, CLI_TEXT, "X,Y,Z", &o.at, 0, 0, "where the sensor stands (the camera's place)"},
        {"velocity", 0, CLI_TEXT, "X,Y,Z", &o.velocity, 0, 0, "how it moves meanwhile, m/s (0,0,0)"},
        {"spin", 0, CLI_TEXT, "X,Y,Z", &o.spin, 0, 0,
         "how it turns meanwhile, rad/s about an axis of the world (0,0,0)"},
        {"duration", 0, CLI_NUMBER, "S", &o.duration, 0, 3600, "from the first ray to the end of the turn (0.1)"},
        {"camera", 0, CLI_COUNT, "N", &o.camera, 0, 1000000, "the N-th camera of the file, counted from 0 (0)"},
        {"threads", 't', CLI_COUNT, "N", &o.threads, 0, 64,
         "worker threads; 0, the default, is one for each processor"},
        {"isa", 0, CLI_ISA, "X", &o.isa, 0, 0, "plain, sse2, avx2 or avx512; default: the best available"},
        {"memory-limit", 0, CLI_BYTES, "BYTES", &o.memory, 1000000, 0,
         "what the scene may hold: 500MB, 2GB (no limit)"}};
    const char *operands[CLI_OPERANDS];
    size_t count;
    daft_error error;
    cli_outcome outcome = cli_parse(&COMMAND, options, COUNT_OF(options), argc, argv, operands, &count);
    if (outcome != CLI_READY) return outcome == CLI_HELPED ? STATUS_DONE : STATUS_BAD_USAGE;
    o.scene = operands[0];
    int refused = refuse_options(&o);
    if (refused) return refused;
    daft_engine_def def = daft_default_engine_def();
    def.threads = (int)o.threads;
    def.isa = o.isa;
    def.memory_limit = o.memory;
    daft_engine *engine = try_engine(&def, &error);
    bool good = engine && run(engine, &o, &error);
    daft_engine_destroy(engine);
    return good ? STATUS_DONE : report(&error);
}
