/* Ray queries. A two-level tree in floats finds which triangle or sphere is hit; distance, position and normal are then
 * computed again from that one shape in double.
 *
 * The tree is kept until something moves. Its frame's origin is the ray's origin rounded to a grid whose cell is a
 * power of two of about 1,024 times the smallest entity in the scene, so rays from nearby share a tree, an origin is
 * wrong by at most 2^-24 · 0.87 · 1024, about 5e-5, of that smallest entity, and the answer depends on the scene and
 * the ray alone, not on the rays before it. */
#include "scene/query/query.h"

#include "math/trig.h"

enum { CELL_SIZES = 1024 };

/* The longest side of the entity's bounds in the world; 0 where it has none. */
static double world_size(const daft_scene *scene, const daft_entity_item *item)
{
    const daft_trimesh *mesh = NULL;
    if (item->def.shape == DAFT_SHAPE_MESH) mesh = &scene->assets.meshes[daft_asset_index(item->def.mesh.id)]->mesh;
    daft_dvec3 side = daft_to_double(item->def.size);
    if (item->def.shape == DAFT_SHAPE_SPHERE) side.x = side.y = side.z = 2 * (double)item->def.radius;
    if (mesh) side = daft_dsub(daft_to_double(mesh->high), daft_to_double(mesh->low));
    double longest = 0;
    for (int row = 0; row < 3; row++) {
        const double *m = item->world.m + 3 * row;
        double length = fabs(m[0]) * side.x + fabs(m[1]) * side.y + fabs(m[2]) * side.z;
        if (length > longest) longest = length;
    }
    return longest;
}

static double grid_cell(daft_scene *scene)
{
    double smallest = INFINITY;
    scene->walk = ++scene->engine->revision;
    for (uint32_t i = 0; i < scene->entity_slots.count; i++) {
        if (!scene->entity_slots.items[i].live || scene->entities[i].def.shape == DAFT_SHAPE_NONE) continue;
        const daft_entity_item *item = daft_entity_world(scene, i, 1);
        double size = item->shown ? world_size(scene, item) : 0;
        if (size > 0 && size < smallest) smallest = size;
    }
    if (!isfinite(smallest)) return CELL_SIZES;
    int exponent;
    frexp(smallest, &exponent);
    return ldexp(CELL_SIZES, exponent - 1);
}

static double snap(double x, double cell) { return floor(x / cell + 0.5) * cell; }

static bool cache_build(daft_scene *scene, daft_dvec3 origin, daft_error *error)
{
    daft_query_cache *cache = &scene->query;
    cache->valid = false;
    daft_arena_reset(&cache->arena);
    daft_listing listing = {
        .origin = origin, .alpha = 1, .kdtrees = scene->engine->accel == DAFT_ACCEL_KDTREE, .arena = &cache->arena};
    if (!daft_snapshot_instances(scene, &listing, error)) return false;
    const daft_instance *instances = listing.instances;
    cache->instances = instances, cache->instance_count = listing.count;
    cache->instance_of = daft_arena_alloc(&cache->arena, scene->entity_slots.count, sizeof *cache->instance_of);
    if (!cache->instance_of) return daft_fail_memory(error, "a ray query");
    for (uint32_t i = 0; i < scene->entity_slots.count; i++) cache->instance_of[i] = DAFT_NONE;
    for (uint32_t i = 0; i < cache->instance_count; i++) cache->instance_of[daft_handle_index(instances[i].entity)] = i;
    const daft_tlas_def def = {DAFT_INTERSECT_EXACT, scene->engine->threads, scene->engine->isa};
    cache->tlas = daft_tlas_build_for(&cache->arena, instances, cache->instance_count, &def, error);
    if (!cache->tlas) return false;
    cache->origin = origin;
    cache->revision = scene->revision;
    cache->valid = true;
    return true;
}

bool daft_query_open(daft_scene *scene, daft_dvec3 from, daft_error *error)
{
    daft_query_cache *cache = &scene->query;
    bool changed = !cache->valid || cache->revision != scene->revision;
    if (changed) cache->cell = grid_cell(scene);
    daft_dvec3 origin = daft_dv3(snap(from.x, cache->cell), snap(from.y, cache->cell), snap(from.z, cache->cell));
    if (!changed && origin.x == cache->origin.x && origin.y == cache->origin.y && origin.z == cache->origin.z)
        return true;
    return cache_build(scene, origin, error);
}

/* ---- the hit again, in double ---- */

typedef struct exact_hit {
    double distance;
    daft_dvec3 normal; /* any length */
} exact_hit;

static daft_dvec3 daffine_point(const daft_daffine *a, daft_dvec3 p)
{
    return daft_dv3(a->m[0] * p.x + a->m[1] * p.y + a->m[2] * p.z + a->t[0],
                    a->m[3] * p.x + a->m[4] * p.y + a->m[5] * p.z + a->t[1],
                    a->m[6] * p.x + a->m[7] * p.y + a->m[8] * p.z + a->t[2]);
}

/* `frame`: the triangle's transform relative to the ray's origin. */
static exact_hit triangle_hit(const daft_daffine *frame, const daft_trimesh *mesh, uint32_t triangle,
                              daft_dvec3 direction, float t)
{
    daft_dvec3 corner[3];
    for (int i = 0; i < 3; i++) {
        uint32_t v = mesh->indices[3 * triangle + (uint32_t)i];
        corner[i] = daffine_point(frame, daft_dv3((double)mesh->x[v], (double)mesh->y[v], (double)mesh->z[v]));
    }
    daft_dvec3 normal = daft_dcross(daft_dsub(corner[1], corner[0]), daft_dsub(corner[2], corner[0]));
    double along = daft_ddot(normal, direction);
    double distance = along != 0 ? daft_ddot(normal, corner[0]) / along : (double)t;
    return (exact_hit){isfinite(distance) ? distance : (double)t, normal};
}

static exact_hit sphere_hit(const daft_daffine *frame, double radius, daft_dvec3 direction)
{
    daft_dvec3 center = daft_dv3(frame->t[0], frame->t[1], frame->t[2]);
    double middle = daft_ddot(center, direction);
    daft_dvec3 off = daft_dsub(center, daft_dscale(direction, middle));
    double square = radius * radius - daft_ddot(off, off);
    double half = square > 0 ? sqrt(square) : 0;
    double distance = middle - half >= 0 ? middle - half : middle + half;
    return (exact_hit){distance, daft_dsub(daft_dscale(direction, distance), center)};
}

/* ---- what the caller gets ---- */

static daft_vec2 mesh_uv(const daft_trimesh *mesh, const daft_hit *hit)
{
    if (!mesh->uvs) return (daft_vec2){0, 0};
    const uint32_t *indices = (mesh->uv_indices ? mesh->uv_indices : mesh->indices) + 3 * hit->triangle;
    float weight[3] = {1 - hit->u - hit->v, hit->u, hit->v};
    daft_vec2 uv = {0, 0};
    for (int i = 0; i < 3; i++) {
        if (indices[i] == DAFT_NO_UV) return (daft_vec2){0, 0};
        uv.x += weight[i] * mesh->uvs[indices[i]].x;
        uv.y += weight[i] * mesh->uvs[indices[i]].y;
    }
    return uv;
}

/* Longitude and latitude of the point in the sphere's own space, as on an equirectangular image. */
static daft_vec2 sphere_uv(const daft_daffine *world, daft_dvec3 normal)
{
    daft_daffine inverse;
    if (!daft_daffine_invert(world, &inverse)) return (daft_vec2){0, 0};
    inverse.t[0] = inverse.t[1] = inverse.t[2] = 0;
    daft_dvec3 d = daffine_point(&inverse, normal);
    double length = sqrt(daft_ddot(d, d));
    if (!(length > 0)) return (daft_vec2){0, 0};
    return (daft_vec2){(float)(0.5 + daft_atan2(d.z, d.x) / (2 * DAFT_PI)),
                       (float)(0.5 + daft_asin(d.y / length) / DAFT_PI)};
}

void daft_query_answer(const daft_scene *scene, const daft_hit *found, daft_dvec3 origin, daft_dvec3 direction,
                       daft_ray_hit *out)
{
    const daft_instance *instance = &scene->query.instances[found->instance];
    const daft_entity_item *item = &scene->entities[daft_handle_index(instance->entity)];
    daft_daffine frame = item->world;
    frame.t[0] -= origin.x, frame.t[1] -= origin.y, frame.t[2] -= origin.z;
    exact_hit hit = instance->mesh ? triangle_hit(&frame, instance->mesh, found->triangle, direction, found->t)
                                   : sphere_hit(&frame, (double)instance->radius, direction);
    if (hit.distance < 0) hit.distance = 0; /* a surface through the ray's origin */
    double length = sqrt(daft_ddot(hit.normal, hit.normal));
    double sign = daft_ddot(hit.normal, direction) > 0 ? -1 : 1;
    const bool slotted = instance->mesh && instance->mesh->slots;
    const uint32_t material = instance->materials[slotted ? instance->mesh->slots[found->triangle] : 0];
    *out = (daft_ray_hit){
        .entity = {instance->entity},
        .triangle = instance->mesh ? found->triangle : 0,
        .material = {material ? daft_asset_id(&scene->assets.material_slots, material) : 0},
        .distance = (float)hit.distance,
        .position = daft_dadd(origin, daft_dscale(direction, hit.distance)),
        .normal = daft_to_float(daft_dscale(hit.normal, length > 0 ? sign / length : 0)),
        .uv = instance->mesh ? mesh_uv(instance->mesh, found) : sphere_uv(&item->world, hit.normal),
    };
}

/* The float search reaches a little past the limit: the distance in double decides. */
daft_ray daft_query_float_ray(const daft_scene *scene, daft_dvec3 origin, daft_dvec3 direction, float max_distance)
{
    const daft_query_cache *cache = &scene->query;
    double far = (double)max_distance * (1 + 1e-5) + cache->cell * 0x1p-22;
    return (daft_ray){.origin = daft_to_float(daft_dsub(origin, cache->origin)),
                      .direction = daft_to_float(direction),
                      .tmin = 0,
                      .tmax = far < (double)FLT_MAX ? (float)far : FLT_MAX};
}

void daft_query_walk(daft_scene *scene)
{
    scene->walk = ++scene->engine->revision;
    for (uint32_t i = 0; i < scene->query.instance_count; i++)
        daft_entity_world(scene, daft_handle_index(scene->query.instances[i].entity), 1);
}

uint32_t daft_query_skip(const daft_scene *scene, daft_entity ignore)
{
    return ignore.id ? scene->query.instance_of[daft_handle_index(ignore.id)] : UINT32_MAX;
}

static bool ray_check(daft_scene *scene, daft_dvec3 origin, daft_vec3 direction, float max_distance, daft_entity ignore,
                      daft_error *error)
{
    return daft_scene_ready(scene, error) && daft_check_finite_position(error, "origin", origin) &&
           daft_check_direction(error, "direction", direction) &&
           daft_check_range(error, "max_distance", (double)max_distance, 0, INFINITY, "0 or more") &&
           (ignore.id == 0 || daft_entity_find(scene, ignore, error));
}

bool daft_scene_cast_ray(daft_scene *scene, daft_dvec3 origin, daft_vec3 direction, float max_distance,
                         daft_entity ignore, daft_ray_hit *hit, daft_error *error)
{
    daft_error_clear(error);
    if (!ray_check(scene, origin, direction, max_distance, ignore, error)) return false;
    scene->counters.query_rays++;
    if (!daft_query_open(scene, origin, error)) return false;
    const daft_query_cache *cache = &scene->query;
    if (cache->instance_count == 0) return false;
    daft_dvec3 d = daft_to_double(direction);
    d = daft_dscale(d, 1 / sqrt(daft_ddot(d, d)));
    daft_ray ray = daft_query_float_ray(scene, origin, d, max_distance);
    daft_hit found;
    daft_ray_hit answer;
    const uint32_t skip = daft_query_skip(scene, ignore);
    if (!daft_accel_kernels_for(scene->engine->isa)->closest(cache->tlas, &ray, skip, &found)) return false;
    scene->walk = ++scene->engine->revision;
    daft_entity_world(scene, daft_handle_index(cache->instances[found.instance].entity), 1);
    daft_query_answer(scene, &found, origin, d, &answer);
    if (answer.distance > max_distance) return false;
    if (hit) *hit = answer;
    return true;
}

/* ---- bounds ---- */

/* The entity's box in its own axes. */
static void own_bounds(const daft_scene *scene, const daft_entity_item *item, daft_dvec3 *low, daft_dvec3 *high)
{
    double r = (double)item->def.radius;
    if (item->def.shape == DAFT_SHAPE_MESH) {
        const daft_mesh_item *mesh = scene->assets.meshes[daft_asset_index(item->def.mesh.id)];
        daft_vec3 a = mesh->mesh.low, b = mesh->mesh.high;
        if (item->animated) daft_animated_bounds(item->animated, mesh->rig, &a, &b);
        *low = daft_to_double(a), *high = daft_to_double(b);
    } else if (item->def.shape == DAFT_SHAPE_SPHERE) {
        *low = daft_dv3(-r, -r, -r), *high = daft_dv3(r, r, r);
    } else {
        *high = daft_dscale(daft_to_double(item->def.size), 0.5), *low = daft_dscale(*high, -1);
    }
}

static bool has_triangles(const daft_scene *scene, const daft_entity_item *item)
{
    return item->def.shape != DAFT_SHAPE_MESH ||
           scene->assets.meshes[daft_asset_index(item->def.mesh.id)]->mesh.triangle_count > 0;
}

static void widen(double value, double *low, double *high) { *low = fmin(*low, value), *high = fmax(*high, value); }

static void add_bounds(const daft_scene *scene, const daft_entity_item *item, daft_dvec3 *low, daft_dvec3 *high)
{
    daft_dvec3 a, b;
    own_bounds(scene, item, &a, &b);
    for (int corner = 0; corner < 8; corner++) {
        daft_dvec3 p = daft_dv3(corner & 1 ? b.x : a.x, corner & 2 ? b.y : a.y, corner & 4 ? b.z : a.z);
        p = daffine_point(&item->world, p);
        if (!isfinite(p.x) || !isfinite(p.y) || !isfinite(p.z)) continue;
        widen(p.x, &low->x, &high->x), widen(p.y, &low->y, &high->y), widen(p.z, &low->z, &high->z);
    }
}

bool daft_scene_get_bounds(daft_scene *scene, daft_dvec3 *low, daft_dvec3 *high, daft_error *error)
{
    daft_error_clear(error);
    if (!daft_scene_ready(scene, error) || !daft_check_pointer(error, "low", low) ||
        !daft_check_pointer(error, "high", high))
        return false;
    daft_dvec3 a = daft_dv3(INFINITY, INFINITY, INFINITY), b = daft_dscale(a, -1);
    scene->walk = ++scene->engine->revision;
    for (uint32_t i = 0; i < scene->entity_slots.count; i++) {
        if (!scene->entity_slots.items[i].live || scene->entities[i].def.shape == DAFT_SHAPE_NONE) continue;
        const daft_entity_item *item = daft_entity_world(scene, i, 1);
        if (item->shown && item->def.visible && has_triangles(scene, item)) add_bounds(scene, item, &a, &b);
    }
    if (!(a.x <= b.x)) return false;
    *low = a, *high = b;
    return true;
}
