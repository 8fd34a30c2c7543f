/* What bodies are made of. Hulls, triangles and fields are kept by number while some body uses them, so entities that
 * look alike share one; a saved state names them by these numbers. */
#include "scene/scene.h"

#include <string.h>

daft_collider daft_default_collider(void)
{
    daft_collider collider;
    daft_struct_default(DAFT_STRUCT_COLLIDER, &collider);
    return collider;
}

static const char *const KINDS[] = {"", "sphere", "capsule", "box", "hull", "mesh", "field", "cylinder"};

/* ---- the table ---- */

static void item_free(daft_scene *scene, daft_geometry_item *item)
{
    if (item->hull) daft_hull_free(item->hull);
    if (item->triangles) daft_mesh_shape_free(item->triangles);
    if (item->field) daft_height_field_free(item->field);
    if (item->bvh) daft_bvh_free(item->bvh);
    daft_trimesh_free(scene->allocator, &item->scaled);
    daft_release(scene->allocator, item);
}

void daft_geometry_drop(daft_scene *scene, uint32_t geometry)
{
    if (!geometry) return;
    daft_geometry_item *item = scene->geometries[geometry - 1];
    if (--item->users) return;
    item_free(scene, item);
    scene->geometries[geometry - 1] = NULL;
}

void daft_geometries_free(daft_scene *scene)
{
    for (uint32_t i = 0; i < scene->geometry_count; i++)
        if (scene->geometries[i]) item_free(scene, scene->geometries[i]);
    daft_release(scene->allocator, scene->geometries);
}

bool daft_geometry_uses_mesh(const daft_scene *scene, daft_mesh mesh)
{
    for (uint32_t i = 0; i < scene->geometry_count; i++) {
        const daft_geometry_item *item = scene->geometries[i];
        if (item && item->type == DAFT_GEOMETRY_MESH && item->mesh == mesh.id) return true;
    }
    return false;
}

static daft_sim_shape shape_of(const daft_geometry_item *item)
{
    if (item->type == DAFT_GEOMETRY_HULL) return daft_shape_hull(item->hull);
    return item->type == DAFT_GEOMETRY_MESH ? daft_shape_mesh(item->triangles) : daft_shape_field(item->field);
}

bool daft_geometry_find(void *scene, uint32_t geometry, daft_geometry type, daft_sim_shape *out)
{
    const daft_scene *s = scene;
    if (geometry == 0 || geometry > s->geometry_count || !s->geometries[geometry - 1]) return false;
    *out = shape_of(s->geometries[geometry - 1]);
    return out->type == type;
}

/* A free place, with room for the item; DAFT_NONE: memory is out. */
static uint32_t free_place(daft_scene *scene)
{
    for (uint32_t i = 0; i < scene->geometry_count; i++)
        if (!scene->geometries[i]) return i;
    if (!daft_grow(scene->allocator, &scene->geometries, &scene->geometry_capacity, scene->geometry_count + 1,
                   scene->geometry_count, sizeof *scene->geometries))
        return DAFT_NONE;
    scene->geometries[scene->geometry_count] = NULL;
    return scene->geometry_count++;
}

/* ---- making ---- */

/* A mesh that is drawn larger or smaller needs triangles and a tree of its own. */
static bool scale_mesh(daft_scene *scene, const daft_trimesh *mesh, daft_geometry_item *item, daft_error *error)
{
    daft_vec3 *moved = daft_alloc(scene->allocator, mesh->vertex_count, sizeof *moved);
    if (!moved) return daft_fail_memory(error, "a collider");
    for (uint32_t i = 0; i < mesh->vertex_count; i++)
        moved[i] = daft_mul(daft_v3(mesh->x[i], mesh->y[i], mesh->z[i]), item->scale);
    daft_mesh_def def = daft_default_mesh_def();
    def.positions = moved, def.vertex_count = mesh->vertex_count;
    def.indices = mesh->indices, def.triangle_count = mesh->triangle_count;
    daft_log quiet = {0};
    bool made = daft_trimesh_from_arrays(scene->allocator, &def, &quiet, &item->scaled, error);
    daft_release(scene->allocator, moved);
    if (!made) return false;
    item->bvh = daft_bvh_build_mesh(scene->allocator, &item->scaled, scene->engine->threads, error);
    return item->bvh != NULL;
}

static bool make_triangles(daft_scene *scene, const daft_mesh_item *mesh, daft_geometry_item *item, daft_error *error)
{
    bool as_is = item->scale.x == 1 && item->scale.y == 1 && item->scale.z == 1;
    if (!as_is && !scale_mesh(scene, &mesh->mesh, item, error)) return false;
    item->triangles = daft_mesh_shape_create(scene->allocator, as_is ? &mesh->mesh : &item->scaled,
                                             as_is ? mesh->bvh : item->bvh, false, error);
    return item->triangles != NULL;
}

static bool make(daft_scene *scene, const daft_collider *collider, const daft_mesh_item *mesh, daft_geometry_item *item,
                 daft_error *error)
{
    if (item->type == DAFT_GEOMETRY_MESH) return make_triangles(scene, mesh, item, error);
    if (item->type == DAFT_GEOMETRY_HULL && !mesh) {
        item->hull = daft_hull_create_cylinder(scene->allocator, item->scale.x, item->scale.y, error);
        return item->hull != NULL;
    }
    if (item->type == DAFT_GEOMETRY_HULL) {
        item->hull = daft_hull_create_mesh(scene->allocator, &mesh->mesh, item->scale, 0, error);
        return item->hull != NULL;
    }
    if (!daft_check_pointer(error, "heights", collider->heights)) return false;
    item->field = daft_height_field_create(scene->allocator, collider->heights, collider->columns, collider->rows,
                                           collider->spacing.x, collider->spacing.y, error);
    return item->field != NULL;
}

/* The same hull or triangles that some body has already. */
static daft_geometry_item *find_shared(const daft_scene *scene, const daft_geometry_item *wanted, uint32_t *place)
{
    for (uint32_t i = 0; i < scene->geometry_count; i++) {
        daft_geometry_item *item = scene->geometries[i];
        if (!item || item->type != wanted->type || item->mesh != wanted->mesh || item->scale.x != wanted->scale.x ||
            item->scale.y != wanted->scale.y || item->scale.z != wanted->scale.z)
            continue;
        *place = i;
        return item;
    }
    return NULL;
}

static bool acquire(daft_scene *scene, const daft_collider *collider, const daft_entity_def *def, daft_geometry type,
                    daft_sim_shape_def *out, daft_error *error)
{
    daft_geometry_item wanted = {.type = type, .users = 1, .scale = def->scale};
    const daft_mesh_item *mesh = NULL;
    uint32_t place = DAFT_NONE;
    bool cylinder = collider->kind == DAFT_COLLIDER_CYLINDER;
    if (cylinder) wanted.scale = daft_v3(collider->radius, collider->height * 0.5f, 0); /* of no mesh: its sizes */
    if (type != DAFT_GEOMETRY_FIELD) {
        daft_mesh id = collider->mesh.id ? collider->mesh : def->mesh;
        mesh = cylinder ? NULL : daft_mesh_find(scene, id, error);
        if (!mesh && !cylinder) return false;
        wanted.mesh = cylinder ? 0 : id.id;
        daft_geometry_item *shared = find_shared(scene, &wanted, &place);
        if (shared) {
            shared->users++;
            out->shape = shape_of(shared), out->geometry_id = place + 1;
            return true;
        }
    }
    daft_geometry_item *item = daft_alloc(scene->allocator, 1, sizeof *item);
    if (!item || (place = free_place(scene)) == DAFT_NONE) {
        daft_release(scene->allocator, item);
        return daft_fail_memory(error, "a collider");
    }
    *item = wanted;
    if (!make(scene, collider, mesh, item, error)) {
        item_free(scene, item);
        return false;
    }
    scene->geometries[place] = item;
    out->shape = shape_of(item), out->geometry_id = place + 1;
    return true;
}

bool daft_collider_acquire(daft_scene *scene, const daft_collider *collider, const daft_entity_def *def,
                           daft_sim_shape_def *out, daft_error *error)
{
    out->geometry_id = 0;
    if (!daft_struct_check_named(DAFT_STRUCT_COLLIDER, collider, "the collider's ", error)) return false;
    out->position = collider->position;
    out->rotation = collider->rotation;
    switch (collider->kind) {
    case DAFT_COLLIDER_SPHERE: return daft_shape_sphere(collider->radius, &out->shape, error);
    case DAFT_COLLIDER_CAPSULE:
        return daft_shape_capsule(collider->height * 0.5f - collider->radius, collider->radius, &out->shape, error);
    case DAFT_COLLIDER_BOX: return daft_shape_box(daft_scale(collider->size, 0.5f), &out->shape, error);
    case DAFT_COLLIDER_CYLINDER:
    case DAFT_COLLIDER_HULL: return acquire(scene, collider, def, DAFT_GEOMETRY_HULL, out, error);
    case DAFT_COLLIDER_MESH:
    case DAFT_COLLIDER_FIELD:
        if (def->body == DAFT_BODY_DYNAMIC)
            return daft_fail(error, DAFT_ERROR_ARGUMENT,
                             "the collider is a %s, which has no mass: a dynamic body can be a hull",
                             KINDS[collider->kind]);
        return acquire(scene, collider, def,
                       collider->kind == DAFT_COLLIDER_MESH ? DAFT_GEOMETRY_MESH : DAFT_GEOMETRY_FIELD, out, error);
    }
    return daft_fail(error, DAFT_ERROR_ARGUMENT,
                     "the collider's kind is %d; it must be sphere, capsule, box, hull, mesh, field or cylinder",
                     (int)collider->kind);
}
