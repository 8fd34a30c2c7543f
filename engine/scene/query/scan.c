/* Scans: all rays of a laser scanner, on all threads. The search in floats takes sixteen rays at once; distances come
 * from the same double computation as those of single queries. */
#include "base/parallel.h"
#include "math/trig.h"
#include "scene/fields/check.h"
#include "scene/query/query.h"

enum { BAND = 4, BLOCK = 4, RUN = 256 }; /* lines that a task takes; rays of a line side by side; rays in one go */

typedef struct scan_job {
    const daft_scene *scene;
    const daft_scan_def *def;
    const daft_accel_kernels *kernels;
    daft_scan_table table;
    uint32_t skip, rays;
    daft_scan_return *first, *last; /* last: or NULL */
} scan_job;

/* ---- what comes back ---- */

/* 53 bits of a number that seed, ray and purpose choose, as 0 < x < 1. (SplitMix64: Steele, Lea, Flood, "Fast
 * Splittable Pseudorandom Number Generators", 2014.) */
static double uniform_of(const scan_job *j, uint32_t ray, uint32_t purpose)
{
    uint64_t x = j->def->seed + 0x9E3779B97F4A7C15u * ((uint64_t)ray * 8 + purpose + 1);
    x = (x ^ x >> 30) * 0xBF58476D1CE4E5B9u;
    x = (x ^ x >> 27) * 0x94D049BB133111EBu;
    x ^= x >> 31;
    return ((double)(x >> 11) + 0.5) * 0x1p-53;
}

/* Box and Muller, "A Note on the Generation of Random Normal Deviates", 1958. */
static double normal_of(const scan_job *j, uint32_t ray, uint32_t purpose)
{
    const double ln2 = 0.693147180559945309, u = uniform_of(j, ray, purpose), v = uniform_of(j, ray, purpose + 1);
    return sqrt(-2 * ln2 * daft_log2(u)) * daft_cos(2 * DAFT_PI * v);
}

/* The texel at (u, v), repeated, without filtering: a laser's spot is small. */
static daft_vec3 texel_at(const daft_texture_data *map, float u, float v)
{
    const float x = (u - floorf(u)) * (float)map->width[0], y = (1 - (v - floorf(v))) * (float)map->height[0];
    const int column = daft_min_i((int)x, map->width[0] - 1), row = daft_min_i((int)y, map->height[0] - 1);
    const uint8_t *rgba = map->texels[0] + 4 * ((size_t)row * (size_t)map->width[0] + (size_t)column);
    return daft_v3(daft_srgb_to_linear((float)rgba[0] / 255), daft_srgb_to_linear((float)rgba[1] / 255),
                   daft_srgb_to_linear((float)rgba[2] / 255));
}

/* The luminance (BT.709) of what a surface scatters of the light that comes, and of that what gets back. */
static float reflectivity(const daft_scene *scene, const daft_surface *surface, daft_vec2 uv, daft_vec3 through)
{
    daft_vec3 c = surface->diffuse;
    if (surface->texture != DAFT_NO_TEXTURE && isfinite(uv.x) && isfinite(uv.y)) {
        const daft_texture_data *map = &scene->assets.textures[surface->texture];
        const daft_vec3 t = texel_at(map, uv.x * surface->map_scale.x, uv.y * surface->map_scale.y);
        c = daft_v3(c.x * t.x, c.y * t.y, c.z * t.z);
    }
    return 0.2126f * c.x * through.x + 0.7152f * c.y * through.y + 0.0722f * c.z * through.z;
}

static const daft_surface *surface_of(const daft_scene *scene, daft_material material)
{
    return &scene->assets.surfaces[material.id ? daft_asset_index(material.id) : 0];
}

/* What the sensor reads of a hit; `through`: the share of the light that comes so far, and back. */
static daft_scan_return read_hit(const scan_job *j, uint32_t ray, bool last, const daft_ray_hit *hit, daft_vec3 way,
                                 daft_vec3 through)
{
    const daft_scan_def *def = j->def;
    const uint32_t purpose = last ? 3 : 0;
    const float cosine = -(hit->normal.x * way.x + hit->normal.y * way.y + hit->normal.z * way.z);
    double range = (double)hit->distance;
    if (!(hit->distance >= def->min_range && hit->distance <= def->max_range)) return (daft_scan_return){0};
    if (def->drop_out > 0 && uniform_of(j, ray, purpose) < (double)def->drop_out) return (daft_scan_return){0};
    if (def->range_noise > 0) range += (double)def->range_noise * normal_of(j, ray, purpose + 1);
    const float shine = reflectivity(j->scene, surface_of(j->scene, hit->material), hit->uv, through);
    return (daft_scan_return){.range = range > 0 ? (float)range : 0,
                              .intensity = shine * (cosine > 0 ? cosine : 0),
                              .entity = hit->entity,
                              .triangle = hit->triangle};
}

enum { BODIES = 4 };

/* The bodies that absorb, and that a ray is in: those of which it has met one side. */
typedef struct bodies {
    uint32_t entity[BODIES], count;
    const daft_surface *surface[BODIES];
} bodies;

/* Into or out of the body whose surface is met. Of more than there is room for, the oldest is forgotten. */
static void cross(bodies *in, uint32_t entity, const daft_surface *surface)
{
    uint32_t at = 0;
    while (at < in->count && in->entity[at] != entity) at++;
    const bool leaves = at < in->count;
    if (!leaves && !daft_surface_absorbs(surface)) return;
    if (!leaves) at = 0;
    if (leaves || in->count == BODIES) {
        for (in->count--; at < in->count; at++)
            in->entity[at] = in->entity[at + 1], in->surface[at] = in->surface[at + 1];
    }
    if (!leaves) in->entity[in->count] = entity, in->surface[in->count++] = surface;
}

/* Where bodies overlap, the one of the highest priority is there, and of these the last. */
static const daft_surface *inside(const bodies *in)
{
    const daft_surface *found = NULL;
    for (uint32_t i = 0; i < in->count; i++)
        if (!found || in->surface[i]->priority >= found->priority) found = in->surface[i];
    return found;
}

/* Beer's law, there and back. */
static daft_vec3 absorbed(daft_vec3 light, const daft_surface *medium, double length)
{
    for (int k = 0; k < 3 && medium; k++)
        daft_v3_put(&light, k,
                    daft_v3_at(light, k) *
                        (float)daft_exp2(fmax(-2 * (double)daft_v3_at(medium->absorption, k) * length, -1000)));
    return light;
}

/* Goes on behind surfaces that let light through, as far as there are some; `hit` is the first, and then the last. */
static daft_vec3 follow(const scan_job *j, const daft_scan_line *line, daft_dvec3 way, daft_ray ray, float t,
                        daft_ray_hit *hit)
{
    enum { MOST_SURFACES = 64 };
    daft_vec3 through = {1, 1, 1};
    bodies in = {.count = 0};
    for (int i = 0; i < MOST_SURFACES; i++) {
        const daft_surface *surface = surface_of(j->scene, hit->material);
        daft_hit found;
        if (!(surface->transmission > 0)) break;
        ray.tmin = nextafterf(t + t * 1e-6f, INFINITY);
        if (!j->kernels->closest(j->scene->query.tlas, &ray, j->skip, &found)) break;
        through = daft_mul(through, daft_mul(surface->transmittance, surface->transmittance)); /* there and back */
        cross(&in, hit->entity.id, surface);
        through = absorbed(through, inside(&in), (double)found.t - (double)t);
        t = found.t;
        daft_query_answer(j->scene, &found, line->origin, way, hit);
    }
    return through;
}

/* ---- the rays ---- */

typedef struct run {
    daft_scan_line lines[RUN];
    daft_dvec3 ways[RUN];
    daft_ray rays[RUN];
    daft_hit hits[RUN];
    uint32_t numbers[RUN]; /* of the rays in the scan */
    uint32_t count;
} run;

static void answer(const scan_job *j, const run *r, uint32_t i)
{
    const uint32_t ray = r->numbers[i];
    daft_scan_return first = {0}, last = {0};
    if (r->hits[i].instance != UINT32_MAX) {
        daft_ray_hit hit;
        const daft_vec3 way = daft_to_float(r->ways[i]);
        daft_query_answer(j->scene, &r->hits[i], r->lines[i].origin, r->ways[i], &hit);
        first = last = read_hit(j, ray, false, &hit, way, daft_v3(1, 1, 1));
        if (j->last && surface_of(j->scene, hit.material)->transmission > 0) {
            const daft_vec3 through = follow(j, &r->lines[i], r->ways[i], r->rays[i], r->hits[i].t, &hit);
            last = read_hit(j, ray, true, &hit, way, through);
        }
    }
    j->first[ray] = first;
    if (j->last) j->last[ray] = last;
}

static void finish(const scan_job *j, run *r)
{
    if (r->count == 0) return;
    j->kernels->closest_stream(j->scene->query.tlas, r->rays, r->count, j->skip, r->hits);
    for (uint32_t i = 0; i < r->count; i++) answer(j, r, i);
    r->count = 0;
}

/* A few rays of one line, into the run. */
static void add(const scan_job *j, run *r, uint32_t line, uint32_t first, uint32_t count)
{
    daft_scan_lines(&j->table, line, first, count, &r->lines[r->count]);
    for (uint32_t i = 0; i < count; i++, r->count++) {
        const daft_scan_line *leaves = &r->lines[r->count];
        const daft_dvec3 d = daft_to_double(leaves->direction);
        r->ways[r->count] = daft_dscale(d, 1 / sqrt(daft_ddot(d, d)));
        r->rays[r->count] = daft_query_float_ray(j->scene, leaves->origin, r->ways[r->count], j->def->max_range);
        r->numbers[r->count] = line * j->table.fast + first + i;
    }
}

/* Some lines, in squares of rays that lie beside each other, so that packets are narrow. */
static void scan_band(void *context, uint32_t band, uint32_t worker)
{
    (void)worker;
    const scan_job *j = context;
    const uint32_t begin = band * BAND, end = daft_min_u(begin + BAND, j->table.slow);
    run r;
    r.count = 0;
    for (uint32_t at = 0; at < j->table.fast; at += BLOCK)
        for (uint32_t line = begin; line < end; line++) {
            const uint64_t before = (uint64_t)line * j->table.fast + at;
            if (before >= j->rays) break;
            const uint32_t left = daft_min_u(j->table.fast - at, j->rays - (uint32_t)before);
            if (r.count + BLOCK > RUN) finish(j, &r);
            add(j, &r, line, at, daft_min_u(BLOCK, left));
        }
    finish(j, &r);
}

bool daft_scan(daft_scene *scene, const daft_scan_def *def, daft_scan_return *first, daft_scan_return *last,
               daft_error *error)
{
    daft_error_clear(error);
    if (!daft_scene_ready(scene, error) || !daft_scan_def_check(def, error) ||
        !daft_check_pointer(error, "first", first) || (def->ignore.id && !daft_entity_find(scene, def->ignore, error)))
        return false;
    scan_job j = {.scene = scene,
                  .def = def,
                  .kernels = daft_accel_kernels_for(scene->engine->isa),
                  .rays = daft_scan_size(def),
                  .first = first,
                  .last = last};
    if (!daft_query_open(scene, def->position, error) || !daft_scan_table_open(scene->allocator, def, &j.table, error))
        return false;
    scene->counters.query_rays += j.rays;
    j.skip = daft_query_skip(scene, def->ignore);
    daft_query_walk(scene);
    if (scene->query.instance_count > 0)
        daft_parallel_for(scene->engine->threads, (j.table.slow + BAND - 1) / BAND, scan_band, &j);
    else
        for (uint32_t i = 0; i < j.rays; i++) first[i] = (daft_scan_return){0};
    if (scene->query.instance_count == 0 && last)
        for (uint32_t i = 0; i < j.rays; i++) last[i] = (daft_scan_return){0};
    daft_scan_table_close(scene->allocator, &j.table);
    return true;
}
