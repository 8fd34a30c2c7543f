/* Lights of entities that glow (`lights`). A sphere lights as itself. Of a mesh or a box, what gives off light is
 * summed up along axes of its own (glow_sum.c): its area, its bounds, and how much of it faces each of the six ways
 * along these. The sum is kept with the mesh or, of one that plays, with its pose. A picture then lights with one of
 * two stand-ins of the same power:
 *
 * - up to six rectangles, one a way, each of the area that is seen from there, in the middle of what faces it: boxes
 *   and flat meshes are lit as they are, others about so;
 * - where it is round (as large from all six, and with less surface than their boxes have), a sphere whose mean
 *   projected area is the mesh's: of convex bodies a quarter of the surface (Cauchy).
 *
 * Rays to either end before the bounds of what glows, so that it throws no shadow in its own light. */
#include "image/image.h"
#include "render/render.h"
#include "scene/glow.h"

enum { SETS = 8 }; /* of a mesh's slots, in one material and another */

/* ---- meshes ---- */

/* What a material gives off: with a map, in the mean over the image, which is the texel of its last level. */
static daft_vec3 radiance_of(const daft_scene *scene, uint32_t material)
{
    const daft_surface *m = &scene->assets.surfaces[material];
    if (m->maps[DAFT_MAP_EMISSION] == DAFT_NO_TEXTURE) return m->emission;
    const daft_texture_data *image = &scene->assets.textures[m->maps[DAFT_MAP_EMISSION]];
    const uint8_t *mean = image->texels[image->levels - 1];
    float linear[3];
    for (int i = 0; i < 3; i++) linear[i] = daft_srgb_to_linear((float)mean[i] / 255);
    return daft_mul(m->emission, daft_v3(linear[0], linear[1], linear[2]));
}

static bool is_bright(daft_vec3 color) { return color.x > 0 || color.y > 0 || color.z > 0; }

static uint32_t material_of(const daft_entity_item *item, const daft_mesh_item *shape, uint32_t slot)
{
    return item->def.material.id ? daft_asset_index(item->def.material.id) : shape->materials[slot];
}

void daft_glow_free(const daft_scene *scene, daft_glow **list)
{
    for (daft_glow *g = *list, *next; g; g = next) {
        next = g->next;
        daft_release(scene->allocator, g);
    }
    *list = NULL;
}

/* Which slots glow. */
static uint64_t hash_slots(const daft_scene *scene, const daft_entity_item *item, const daft_mesh_item *shape)
{
    uint64_t hash = 1;
    for (uint32_t i = 0; i < daft_max_u(shape->mesh.slot_count, 1); i++)
        if (is_bright(radiance_of(scene, material_of(item, shape, i)))) hash = daft_hash(&i, sizeof i, hash);
    return hash;
}

/* NULL: memory is out. */
static daft_glow *sum_up(const daft_scene *scene, const daft_entity_item *item, const daft_mesh_item *shape,
                         const daft_trimesh *mesh, uint64_t slots)
{
    const uint32_t count = daft_max_u(shape->mesh.slot_count, 1);
    bool *glows = daft_alloc(scene->allocator, count, sizeof *glows);
    for (uint32_t i = 0; glows && i < count; i++) glows[i] = is_bright(radiance_of(scene, material_of(item, shape, i)));
    daft_glow *sum = glows ? daft_glow_sum(scene->allocator, mesh, glows) : NULL;
    if (sum) sum->slots = slots;
    daft_release(scene->allocator, glows);
    return sum;
}

/* Adds one to a list, which is emptied where it has too many. */
static const daft_glow *keep(const daft_scene *scene, daft_glow **list, daft_glow *sum)
{
    int count = 0;
    for (const daft_glow *g = *list; g; g = g->next) count++;
    if (count >= SETS) daft_glow_free(scene, list);
    if (sum) sum->next = *list, *list = sum;
    return sum;
}

/* What glows of an entity as it stands or, while it plays, as it is seen. NULL: memory is out. */
static const daft_glow *glow_of(const daft_scene *scene, const daft_entity_item *item, daft_mesh_item *shape,
                                daft_error *error)
{
    daft_animated *a = item->animated;
    const daft_posed *posed = a ? daft_animated_shown(a, false) : NULL;
    const uint64_t slots = hash_slots(scene, item, shape);
    daft_glow **list = posed ? &a->glow : &shape->glow;
    if (posed && a->glow_revision != posed->revision) daft_glow_free(scene, list), a->glow_revision = posed->revision;
    for (const daft_glow *g = *list; g; g = g->next)
        if (g->slots == slots) return g;
    const daft_glow *sum = keep(scene, list, sum_up(scene, item, shape, posed ? &posed->mesh : &shape->mesh, slots));
    if (!sum) daft_fail_memory(error, "what glows of a mesh");
    return sum;
}

/* The mean over all that glows. */
static daft_vec3 mean_radiance(const daft_scene *scene, const daft_entity_item *item, const daft_mesh_item *shape,
                               const daft_glow *glow)
{
    daft_dvec3 power = {0, 0, 0};
    for (uint32_t i = 0; i < daft_max_u(shape->mesh.slot_count, 1); i++) {
        const daft_vec3 radiance = radiance_of(scene, material_of(item, shape, i));
        if (glow->areas[i] > 0) power = daft_dadd(power, daft_dscale(daft_to_double(radiance), glow->areas[i]));
    }
    return daft_to_float(daft_dscale(power, 1 / glow->area));
}

bool daft_glow_is_some(const daft_scene *scene, daft_material material, const daft_mesh_item *shape)
{
    if (material.id || !shape)
        return is_bright(scene->assets.materials[material.id ? daft_asset_index(material.id) : 0].emission);
    for (uint32_t i = 0; i < daft_max_u(shape->mesh.slot_count, 1); i++)
        if (is_bright(scene->assets.materials[shape->materials[i]].emission)) return true;
    return false;
}

/* ---- in a picture ---- */

/* A mesh where it stands, about the picture's origin. */
typedef struct placed {
    const daft_glow *glow;
    daft_dvec3 columns[3], position; /* columns: its axes, in the world's space */
    double size[3];                  /* of the bounds, along its axes, in the mesh's metres */
    double seen[3];                  /* square metres along each axis, no more than the bounds have; the mesh's */
    double outside[3];               /* the same in the world */
    double fullness; /* the surface's part of what the six ways see: 1 of boxes and flat meshes, 2/3 of balls */
} placed;

static daft_dvec3 point_at(const placed *p, daft_dvec3 v)
{
    return daft_dadd(p->position, daft_dadd(daft_dadd(daft_dscale(p->columns[0], v.x), daft_dscale(p->columns[1], v.y)),
                                            daft_dscale(p->columns[2], v.z)));
}

static double length_of(daft_dvec3 v) { return sqrt(daft_ddot(v, v)); }

/* Of the mesh when areas that face the axes grow by `grown`. */
static double surface_of(const daft_glow *glow, const double grown[3])
{
    double sum = 0;
    for (int i = 0; i < DAFT_GLOW_SLANTS; i++) {
        const daft_dvec3 v = glow->slants[i], w = daft_dv3(v.x * grown[0], v.y * grown[1], v.z * grown[2]);
        if (glow->slanted[i] > 0) sum += glow->slanted[i] * length_of(w) / length_of(v);
    }
    return sum;
}

/* A sheet is seen from both sides, and a closed mesh from each by what faces it: the more of the two ways. */
static placed place(const daft_glow *glow, const daft_daffine *world, daft_dvec3 origin)
{
    placed p = {.glow = glow, .position = daft_dsub(daft_dv3(world->t[0], world->t[1], world->t[2]), origin)};
    const daft_dvec3 size = daft_dsub(glow->high, glow->low);
    double all = 0, grown[3];
    for (int k = 0; k < 3; k++) {
        const daft_dvec3 axis = glow->axes[k];
        p.columns[k] = daft_dv3(world->m[0] * axis.x + world->m[1] * axis.y + world->m[2] * axis.z,
                                world->m[3] * axis.x + world->m[4] * axis.y + world->m[5] * axis.z,
                                world->m[6] * axis.x + world->m[7] * axis.y + world->m[8] * axis.z);
        p.size[k] = daft_dv3_at(size, k);
    }
    for (int k = 0; k < 3; k++) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        grown[k] = length_of(daft_dcross(p.columns[i], p.columns[j]));
        all += grown[k] * (glow->facing[2 * k] + glow->facing[2 * k + 1]);
        p.seen[k] = fmin(fmax(glow->facing[2 * k], glow->facing[2 * k + 1]), p.size[i] * p.size[j]);
        p.outside[k] = p.seen[k] * grown[k];
    }
    p.fullness = fmin(surface_of(glow, grown) / all, 1);
    return p;
}

static bool is_round(const placed *p)
{
    const double least = fmin(fmin(p->outside[0], p->outside[1]), p->outside[2]),
                 most = fmax(fmax(p->outside[0], p->outside[1]), p->outside[2]);
    return p->fullness < 0.8 && most < 1.5 * least;
}

/* Along its axes; of a mesh whose triangles are turned inside out, what faces the other way is on this side. */
static daft_dvec3 middle_of_way(const placed *p, int way)
{
    const double *facing = p->glow->facing, most = fmax(facing[way], facing[way ^ 1]);
    const daft_dvec3 *middles = p->glow->middles;
    if (facing[way] < most / 2) way ^= 1;
    const daft_dvec3 own = daft_dscale(middles[way], 1 / facing[way]);
    if (facing[way ^ 1] < most / 2) return own;
    const daft_dvec3 other = daft_dscale(middles[way ^ 1], 1 / facing[way ^ 1]);
    const double beyond = daft_dv3_at(other, way / 2) - daft_dv3_at(own, way / 2);
    return (way % 2 ? -beyond : beyond) > 0 ? other : own;
}

/* False: nothing is seen from there. */
static bool shine(const placed *p, int way, daft_light_source *light)
{
    const int k = way / 2, i = (k + 1) % 3, j = (k + 2) % 3;
    const daft_dvec3 normal = daft_dcross(p->columns[i], p->columns[j]);
    const double length = length_of(normal), all = p->outside[0] + p->outside[1] + p->outside[2];
    if (!(p->outside[k] > 1e-3 * all)) return false;
    const double part = sqrt(p->fullness * p->seen[k] / (p->size[i] * p->size[j]));
    const bool mirrored = daft_ddot(normal, p->columns[k]) < 0, against = mirrored != (way % 2 != 0);
    const daft_vec3 u = daft_to_float(daft_dscale(p->columns[i], p->size[i] * part)),
                    v = daft_to_float(daft_dscale(p->columns[j], p->size[j] * part));
    light->area = DAFT_AREA_RECTANGLE;
    light->position = daft_to_float(point_at(p, middle_of_way(p, way)));
    light->to_light = daft_to_float(daft_dscale(normal, (against ? 1 : -1) / length));
    light->edges[0] = against ? u : v, light->edges[1] = against ? v : u;
    return true;
}

static void shine_around(const placed *p, daft_light_source *light)
{
    const double surface = 2 * p->fullness * (p->outside[0] + p->outside[1] + p->outside[2]);
    light->area = DAFT_AREA_SPHERE;
    light->position = daft_to_float(point_at(p, daft_dscale(p->glow->middle, 1 / p->glow->area)));
    light->radius = (float)sqrt(surface / (4 * 3.14159265358979));
}

/* The bounds, a little larger, by more than roundings of places. False: it is too small or too flat for floats, and is
 * not drawn. */
static bool bound(const placed *p, daft_light_source *light)
{
    const daft_dvec3 a = p->glow->low, b = p->glow->high, middle = point_at(p, daft_dscale(daft_dadd(a, b), 0.5)),
                     half = daft_dscale(daft_dsub(b, a), 0.5);
    daft_dvec3 sides[3];
    double most = 0;
    for (int k = 0; k < 3; k++) most = fmax(most, daft_dv3_at(half, k) * length_of(p->columns[k]));
    const double more = 1e-3 * most + 0x1p-20 * (fabs(middle.x) + fabs(middle.y) + fabs(middle.z));
    for (int k = 0; k < 3; k++)
        sides[k] = daft_dscale(p->columns[k], daft_dv3_at(half, k) + more / length_of(p->columns[k]));
    const double volume = daft_ddot(daft_dcross(sides[0], sides[1]), sides[2]);
    light->bounds.middle = daft_to_float(middle), light->bounded = true;
    for (int k = 0; k < 3; k++) {
        const daft_dvec3 across = daft_dcross(sides[(k + 1) % 3], sides[(k + 2) % 3]);
        light->bounds.axes[k] = daft_to_float(daft_dscale(across, 1 / volume));
        if (!daft_finite3(light->bounds.axes[k])) return false;
    }
    return daft_fits_kernels(light->bounds.middle);
}

static uint32_t light_sphere(const daft_scene *scene, const daft_entity_item *item, const daft_daffine *world,
                             daft_light_source *light)
{
    if (!item->def.material.id) return 0;
    light->color = radiance_of(scene, daft_asset_index(item->def.material.id));
    light->area = DAFT_AREA_SPHERE, light->radius = daft_world_radius(world, item->def.radius);
    return is_bright(light->color) && light->radius > 0 && daft_fits_kernels(light->position);
}

/* `like`: what all of its lights have. */
static uint32_t light_shape(const daft_glow *glow, const daft_daffine *world, daft_dvec3 origin, daft_light_source like,
                            daft_light_source *lights)
{
    const placed p = place(glow, world, origin);
    if (!bound(&p, &like)) return 0;
    uint32_t count = 0;
    const bool round = is_round(&p);
    lights[0] = like;
    if (round) shine_around(&p, &lights[count++]);
    for (int way = 0; way < 6 && !round; way++) {
        lights[count] = like;
        count += shine(&p, way, &lights[count]);
    }
    return count;
}

bool daft_glow_lights(const daft_scene *scene, uint32_t index, float alpha, daft_dvec3 origin,
                      daft_light_source lights[DAFT_GLOW_LIGHTS], uint32_t *count, daft_error *error)
{
    const daft_entity_item *item = &scene->entities[index];
    daft_mesh_item *shape = daft_entity_shape(scene, item);
    daft_daffine world;
    *count = 0;
    if (item->def.shape == DAFT_SHAPE_NONE || !daft_entity_place(scene, index, alpha, &world)) return true;
    lights[0] =
        (daft_light_source){.casts_shadow = true,
                            .position = daft_to_float(daft_dsub(daft_dv3(world.t[0], world.t[1], world.t[2]), origin)),
                            .entity = daft_slots_handle(&scene->entity_slots, index)};
    if (!shape) {
        *count = light_sphere(scene, item, &world, &lights[0]);
        return true;
    }
    const daft_glow *glow = glow_of(scene, item, shape, error);
    if (!glow) return false;
    if (!(glow->area > 0)) return true;
    lights[0].color = mean_radiance(scene, item, shape, glow);
    *count = light_shape(glow, &world, origin, lights[0], lights);
    return true;
}
