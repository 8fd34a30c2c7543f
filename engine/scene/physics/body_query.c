/* Queries of bodies: definitions are checked here, sim/ answers, its bodies become entities. */
#include "scene/scene.h"
#include "sim/query/query.h"

/* Metres. Beyond, the fraction of a motion is too coarse a number for a place on it. */
#define FARTHEST 1e9f

daft_query_filter daft_default_query_filter(void)
{
    daft_query_filter filter;
    daft_struct_default(DAFT_STRUCT_QUERY_FILTER, &filter);
    return filter;
}

daft_volume daft_default_volume(void)
{
    daft_volume volume;
    daft_struct_default(DAFT_STRUCT_VOLUME, &volume);
    return volume;
}

static bool read_filter(daft_scene *scene, const daft_query_filter *from, daft_sim_filter *out, daft_error *error)
{
    *out = daft_default_sim_filter();
    if (!from) return true;
    if (!daft_struct_check(DAFT_STRUCT_QUERY_FILTER, from, error)) return false;
    out->kinds = (uint32_t)from->statics << DAFT_BODY_STATIC | (uint32_t)from->kinematics << DAFT_BODY_KINEMATIC |
                 (uint32_t)from->dynamics << DAFT_BODY_DYNAMIC;
    out->layers = from->layers;
    out->mask = from->mask;
    out->sensors = from->sensors;
    if (from->ignore.id == 0) return true;
    const daft_entity_item *item = daft_entity_find(scene, from->ignore, error);
    if (!item) return false;
    out->ignore = item->body;
    return true;
}

static bool read_volume(const daft_volume *from, daft_sim_shape *out, daft_error *error)
{
    if (!daft_check_pointer(error, "volume", from) || !daft_struct_check(DAFT_STRUCT_VOLUME, from, error)) return false;
    if (from->radius == 0) return daft_shape_box(daft_scale(from->size, 0.5f), out, error);
    if (from->height == 0) return daft_shape_sphere(from->radius, out, error);
    return daft_shape_capsule(0.5f * from->height - from->radius, from->radius, out, error);
}

/* The displacement from the origin. */
static bool read_displacement(daft_dvec3 origin, daft_vec3 direction, float max_distance, daft_dvec3 *motion,
                              daft_error *error)
{
    if (!daft_check_finite_position(error, "origin", origin) || !daft_check_direction(error, "direction", direction) ||
        !daft_check_range(error, "max_distance", (double)max_distance, 0, INFINITY, "0 or more"))
        return false;
    daft_dvec3 d = daft_to_double(direction);
    double length = (double)(max_distance < FARTHEST ? max_distance : FARTHEST);
    *motion = daft_dscale(d, length / sqrt(daft_ddot(d, d)));
    return true;
}

static daft_query_hit hit_of(const daft_sim_hit *from)
{
    return (daft_query_hit){.entity = {from->user},
                            .triangle = from->triangle == DAFT_NO_FEATURE ? 0 : from->triangle,
                            .position = from->point,
                            .normal = from->normal,
                            .distance = (float)from->distance,
                            .inside = from->inside};
}

static bool give(const daft_sim_hit *found, daft_query_hit *hit)
{
    if (hit) *hit = hit_of(found);
    return true;
}

/* Hits of the simulation: on the stack, or from the allocator where the caller's list is longer. */
enum { SHORT_LIST = 64 };

typedef struct hit_list {
    daft_sim_hit few[SHORT_LIST], *hits;
    const daft_allocator *allocator;
} hit_list;

static bool list_begin(hit_list *list, daft_scene *scene, uint32_t capacity, daft_error *error)
{
    list->allocator = scene->allocator;
    list->hits = list->few;
    if (capacity > SHORT_LIST) list->hits = daft_alloc(scene->allocator, capacity, sizeof *list->hits);
    return list->hits || daft_fail_memory(error, "a list of hits");
}

static uint32_t list_end(hit_list *list, uint32_t found, daft_query_hit *out, uint32_t capacity)
{
    for (uint32_t i = 0; i < capacity && i < found; i++) out[i] = hit_of(&list->hits[i]);
    if (list->hits != list->few) daft_release(list->allocator, list->hits);
    return found;
}

bool daft_query_ray(daft_scene *scene, daft_dvec3 origin, daft_vec3 direction, float max_distance,
                    const daft_query_filter *filter, daft_query_hit *hit, daft_error *error)
{
    daft_sim_filter f;
    daft_dvec3 motion;
    daft_sim_hit found;
    daft_error_clear(error);
    if (!daft_scene_ready(scene, error) || !read_filter(scene, filter, &f, error) ||
        !read_displacement(origin, direction, max_distance, &motion, error))
        return false;
    scene->counters.query_rays++;
    return scene->world && daft_world_cast_ray(scene->world, origin, motion, &f, &found) && give(&found, hit);
}

uint32_t daft_query_ray_all(daft_scene *scene, daft_dvec3 origin, daft_vec3 direction, float max_distance,
                            const daft_query_filter *filter, daft_query_hit *hits, uint32_t capacity, daft_error *error)
{
    daft_sim_filter f;
    daft_dvec3 motion;
    hit_list list;
    daft_error_clear(error);
    if (!hits) capacity = 0;
    if (!daft_scene_ready(scene, error) || !read_filter(scene, filter, &f, error) ||
        !read_displacement(origin, direction, max_distance, &motion, error) ||
        !list_begin(&list, scene, capacity, error))
        return 0;
    scene->counters.query_rays++;
    uint32_t count = scene->world ? daft_world_cast_ray_all(scene->world, origin, motion, &f, list.hits, capacity) : 0;
    return list_end(&list, count, hits, capacity);
}

bool daft_query_cast(daft_scene *scene, const daft_volume *volume, daft_dvec3 origin, daft_vec3 direction,
                     float max_distance, const daft_query_filter *filter, daft_query_hit *hit, daft_error *error)
{
    daft_sim_filter f;
    daft_sim_shape shape;
    daft_dvec3 motion;
    daft_sim_hit found;
    daft_error_clear(error);
    if (!daft_scene_ready(scene, error) || !read_filter(scene, filter, &f, error) ||
        !read_volume(volume, &shape, error) || !read_displacement(origin, direction, max_distance, &motion, error))
        return false;
    return scene->world && daft_world_cast_shape(scene->world, &shape, origin, volume->rotation, motion, &f, &found) &&
           give(&found, hit);
}

uint32_t daft_query_overlap(daft_scene *scene, const daft_volume *volume, daft_dvec3 position,
                            const daft_query_filter *filter, daft_query_hit *hits, uint32_t capacity, daft_error *error)
{
    daft_sim_filter f;
    daft_sim_shape shape;
    hit_list list;
    daft_error_clear(error);
    if (!hits) capacity = 0;
    if (!daft_scene_ready(scene, error) || !read_filter(scene, filter, &f, error) ||
        !read_volume(volume, &shape, error) || !daft_check_finite_position(error, "position", position) ||
        !list_begin(&list, scene, capacity, error))
        return 0;
    uint32_t count = scene->world
                         ? daft_world_overlap(scene->world, &shape, position, volume->rotation, &f, list.hits, capacity)
                         : 0;
    return list_end(&list, count, hits, capacity);
}

bool daft_query_closest(daft_scene *scene, daft_dvec3 point, float max_distance, const daft_query_filter *filter,
                        daft_query_hit *hit, daft_error *error)
{
    daft_sim_filter f;
    daft_sim_hit found;
    daft_error_clear(error);
    if (!daft_scene_ready(scene, error) || !read_filter(scene, filter, &f, error) ||
        !daft_check_finite_position(error, "point", point) ||
        !daft_check_range(error, "max_distance", (double)max_distance, 0, INFINITY, "0 or more"))
        return false;
    double limit = (double)(max_distance < FARTHEST ? max_distance : FARTHEST);
    return scene->world && daft_world_closest(scene->world, point, limit, &f, &found) && give(&found, hit);
}
