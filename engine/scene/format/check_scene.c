/* What is odd about a .scene file beyond what loading refuses: cameras and lights inside solids, the same entity twice
 * in one place, what cannot be drawn, what nothing lights. */
#include "math/trig.h"
#include "scene/format/check_file.h"
#include "scene/format/load.h"

typedef struct checker {
    daft_scene *scene;
    const char *path;
    const daft_problems *problems;
    const daft_scene_item *items;
    size_t count;
    bool refused;       /* some line */
    bool out_of_memory; /* in on_loaded */
} checker;

static void tell(const checker *c, daft_severity severity, const daft_scene_item *at, const char *message)
{
    daft_problem_at(c->problems, severity, DAFT_ERROR_ARGUMENT, at ? at->source : c->path, at ? at->line : 0,
                    at ? at->column : 0, "%s", message);
}

/* ---- inside a solid ---- */

static daft_daffine pose_of(const daft_scene_item *item)
{
    daft_transform transform = {item->entity.position, item->entity.rotation, item->entity.scale};
    return daft_daffine_from(&transform);
}

/* The solid angle of a triangle around the origin: Van Oosterom & Strackee 1983. Radians, -2pi to 2pi. */
static double solid_angle(daft_dvec3 a, daft_dvec3 b, daft_dvec3 c)
{
    double la = sqrt(daft_ddot(a, a)), lb = sqrt(daft_ddot(b, b)), lc = sqrt(daft_ddot(c, c));
    double above = daft_ddot(a, daft_dcross(b, c));
    double below = la * lb * lc + daft_ddot(a, b) * lc + daft_ddot(b, c) * la + daft_ddot(c, a) * lb;
    return 2 * daft_atan2(above, below);
}

/* How often the surface goes round the point, counting outward sides: 1 inside a closed mesh, 0 outside, between the
 * two where the mesh is open. */
static double winding_number(const daft_trimesh *mesh, daft_dvec3 point)
{
    double sum = 0;
    for (uint32_t i = 0; i < mesh->triangle_count; i++) {
        daft_dvec3 corner[3];
        for (uint32_t k = 0; k < 3; k++) {
            uint32_t v = mesh->indices[3 * (size_t)i + k];
            corner[k] = daft_dsub(daft_dv3((double)mesh->x[v], (double)mesh->y[v], (double)mesh->z[v]), point);
        }
        sum += solid_angle(corner[0], corner[1], corner[2]);
    }
    return sum / (4 * DAFT_PI);
}

static bool inside_mesh(const checker *c, const daft_scene_item *item, daft_dvec3 point)
{
    const daft_trimesh *mesh = &c->scene->assets.meshes[daft_asset_index(item->entity.mesh.id)]->mesh;
    daft_daffine pose = pose_of(item), inverse;
    if (!daft_daffine_invert(&pose, &inverse)) return false;
    const double *m = inverse.m, *t = inverse.t;
    daft_dvec3 p = daft_dv3(m[0] * point.x + m[1] * point.y + m[2] * point.z + t[0],
                            m[3] * point.x + m[4] * point.y + m[5] * point.z + t[1],
                            m[6] * point.x + m[7] * point.y + m[8] * point.z + t[2]);
    daft_dvec3 low = daft_to_double(mesh->low), high = daft_to_double(mesh->high);
    if (!(p.x > low.x && p.x < high.x && p.y > low.y && p.y < high.y && p.z > low.z && p.z < high.z)) return false;
    return winding_number(mesh, p) > 0.75;
}

static bool inside_sphere(const daft_scene_item *item, daft_dvec3 point)
{
    daft_dvec3 off = daft_dsub(point, item->entity.position);
    return daft_ddot(off, off) < (double)item->entity.radius * (double)item->entity.radius;
}

/* The item whose solid holds the point, or NULL. */
static const daft_scene_item *solid_around(const checker *c, daft_dvec3 point)
{
    for (size_t i = 0; i < c->count; i++) {
        const daft_scene_item *item = &c->items[i];
        if (item->kind == DAFT_ITEM_SPHERE && inside_sphere(item, point)) return item;
        if (item->kind == DAFT_ITEM_MESH && inside_mesh(c, item, point)) return item;
    }
    return NULL;
}

static void check_inside(const checker *c, const daft_scene_item *at, daft_dvec3 point, const char *what)
{
    const daft_scene_item *solid = solid_around(c, point);
    if (solid)
        daft_problem_at(c->problems, DAFT_SEVERITY_WARNING, DAFT_ERROR_ARGUMENT, at->source, at->line, at->column,
                        "the %s is inside the %s of %.300s:%d", what,
                        solid->kind == DAFT_ITEM_SPHERE ? "sphere" : "mesh", solid->source, solid->line);
}

/* ---- entities ---- */

/* The frame snapshot leaves out what reaches farther than 1e12 metres, in the world or in the mesh's own space, and
 * spheres whose squared radius would underflow. */
static bool can_be_drawn(const checker *c, const daft_scene_item *item)
{
    const double farthest = 1e12;
    if (item->kind == DAFT_ITEM_SPHERE)
        return (double)item->entity.radius >= 1e-15 && (double)item->entity.radius <= farthest;
    const daft_trimesh *mesh = &c->scene->assets.meshes[daft_asset_index(item->entity.mesh.id)]->mesh;
    if (mesh->triangle_count == 0) return true;
    daft_dvec3 low = daft_to_double(mesh->low), high = daft_to_double(mesh->high);
    double reach =
        fmax(fmax(fmax(fabs(low.x), fabs(low.y)), fabs(low.z)), fmax(fmax(fabs(high.x), fabs(high.y)), fabs(high.z)));
    double scale = fabs((double)item->entity.scale.x);
    return reach <= farthest && reach * scale <= farthest && 1 / scale <= farthest;
}

static bool is_black(daft_vec3 color) { return color.x == 0 && color.y == 0 && color.z == 0; }

/* Whether the item's material, or its mesh's own, gives off light. */
static bool glows(const checker *c, const daft_scene_item *item)
{
    const daft_mesh_item *mesh =
        item->kind == DAFT_ITEM_MESH ? c->scene->assets.meshes[daft_asset_index(item->entity.mesh.id)] : NULL;
    return daft_glow_is_some(c->scene, item->entity.material, mesh);
}

static void check_entity(const checker *c, const daft_scene_item *item)
{
    if (item->entity.lights && !glows(c, item))
        tell(c, DAFT_SEVERITY_NOTE, item, "it has 'lights', but its material gives off no light");
    if (!can_be_drawn(c, item))
        tell(c, DAFT_SEVERITY_WARNING, item, "it is not drawn: it is larger than 1e12 metres, or too small for floats");
    if (item->kind != DAFT_ITEM_MESH) return;
    if (item->entity.scale.x < 0) tell(c, DAFT_SEVERITY_NOTE, item, "a negative scale mirrors the mesh");
    if (c->scene->assets.meshes[daft_asset_index(item->entity.mesh.id)]->mesh.triangle_count == 0)
        tell(c, DAFT_SEVERITY_WARNING, item, "the mesh is empty: nothing is drawn");
}

/* Everything that decides whether two entities coincide. */
static uint64_t entity_hash(const daft_scene_item *item)
{
    const daft_entity_def *e = &item->entity;
    double values[] = {e->position.x + 0.0,
                       e->position.y + 0.0,
                       e->position.z + 0.0,
                       (double)e->scale.x,
                       (double)e->rotation.x + 0.0,
                       (double)e->rotation.y + 0.0,
                       (double)e->rotation.z + 0.0,
                       (double)e->rotation.w + 0.0,
                       item->kind == DAFT_ITEM_SPHERE ? (double)e->radius : 0.0,
                       item->kind == DAFT_ITEM_MESH ? (double)e->mesh.id : 0.0};
    return daft_hash(values, sizeof values, 0);
}

static bool check_twins(const checker *c)
{
    const daft_allocator *allocator = c->scene->allocator;
    daft_map map = {0};
    if (c->count > UINT32_MAX / 4 || !daft_map_reserve(&map, allocator, (uint32_t)c->count)) return false;
    for (uint32_t i = 0; i < c->count; i++) {
        const daft_scene_item *item = &c->items[i];
        if (item->kind != DAFT_ITEM_SPHERE && item->kind != DAFT_ITEM_MESH) continue;
        uint64_t hash = entity_hash(item); /* 64 bits: different entities do not collide */
        uint32_t cursor = 0, first = daft_map_next(&map, hash, &cursor);
        if (first == DAFT_NONE)
            daft_map_add(&map, hash, i);
        else
            daft_problem_at(c->problems, DAFT_SEVERITY_WARNING, DAFT_ERROR_ARGUMENT, item->source, item->line,
                            item->column, "the same is in the same place already: %.300s:%d", c->items[first].source,
                            c->items[first].line);
    }
    daft_map_free(&map, allocator);
    return true;
}

/* ---- the scene as a whole ---- */

static void check_whole(const checker *c)
{
    size_t cameras = 0, lights = 0, entities = 0, skies = 0;
    for (size_t i = 0; i < c->count; i++) {
        const daft_scene_item *item = &c->items[i];
        cameras += item->kind == DAFT_ITEM_CAMERA;
        lights += item->kind == DAFT_ITEM_LIGHT && !is_black(item->light.color);
        if (item->kind == DAFT_ITEM_MESH) {
            const daft_scenery *own = &c->scene->assets.meshes[daft_asset_index(item->entity.mesh.id)]->scenery;
            cameras += item->cameras ? own->camera_count : 0, lights += item->lights ? own->light_count : 0;
        }
        lights +=
            (item->kind == DAFT_ITEM_SPHERE || item->kind == DAFT_ITEM_MESH) && item->entity.lights && glows(c, item);
        entities += item->kind == DAFT_ITEM_SPHERE || item->kind == DAFT_ITEM_MESH;
        if (item->kind == DAFT_ITEM_SKYBOX && skies++ > 0)
            tell(c, DAFT_SEVERITY_WARNING, item, "a second skybox: it takes the place of the one before");
    }
    if (c->refused) return; /* what is missing may be in a line that could not be read */
    if (cameras == 0) tell(c, DAFT_SEVERITY_NOTE, NULL, "no camera: it is seen from the origin, looking along +X");
    if (entities > 0 && lights == 0 && is_black(c->scene->ambient) && !(c->scene->ambient_sky > 0))
        tell(c, DAFT_SEVERITY_WARNING, NULL, "no light, and no ambient light: everything is black");
}

static void on_loaded(void *user, const daft_scene_item *items, size_t count)
{
    checker *c = user;
    c->items = items;
    c->count = count;
    for (size_t i = 0; i < count; i++) {
        const daft_scene_item *item = &items[i];
        if (item->kind == DAFT_ITEM_SPHERE || item->kind == DAFT_ITEM_MESH) check_entity(c, item);
        if (item->kind == DAFT_ITEM_CAMERA) check_inside(c, item, item->camera.position, "camera");
        if (item->kind == DAFT_ITEM_MATERIAL && !item->used)
            tell(c, DAFT_SEVERITY_NOTE, item, "no mesh or sphere uses the material");
        if (item->kind != DAFT_ITEM_LIGHT) continue;
        if (is_black(item->light.color)) tell(c, DAFT_SEVERITY_NOTE, item, "a black light lights nothing");
        if (item->light.kind != DAFT_LIGHT_SUN) check_inside(c, item, item->light.position, "light");
    }
    c->out_of_memory = !check_twins(c);
    check_whole(c);
}

static void on_refused(void *user, const daft_error *error)
{
    checker *c = user;
    c->refused = true;
    c->problems->found(c->problems->user, DAFT_SEVERITY_ERROR, error);
}

/* Each mesh file once. What loading warns of has been told. */
static bool check_meshes(const checker *c, daft_error *error)
{
    const daft_assets *assets = &c->scene->assets;
    for (uint32_t i = 0; i < assets->mesh_slots.count; i++) {
        daft_obj obj;
        daft_error why = {0};
        if (daft_obj_check(c->scene->allocator, c->scene->engine->files, assets->meshes[i]->path, NULL, c->problems,
                           &obj, &why))
            daft_obj_free(c->scene->allocator, &obj);
        else if (why.code == DAFT_ERROR_MEMORY)
            return daft_fail_memory(error, "checking a mesh");
    }
    return true;
}

bool daft_check_scene(daft_engine *engine, const char *path, const daft_problems *problems, daft_error *error)
{
    daft_scene *scene = daft_scene_create(engine, error);
    if (!scene) return false;
    checker c = {.scene = scene, .path = path, .problems = problems};
    daft_scene_watch watch = {on_refused, on_loaded, &c};
    daft_error why = {0};
    bool done = daft_scene_load_watched(scene, path, &watch, &why);
    if (!done && why.code != DAFT_ERROR_MEMORY) {
        problems->found(problems->user, DAFT_SEVERITY_ERROR, &why);
        done = true;
    } else if (!done && error) {
        *error = why;
    }
    if (c.out_of_memory) done = daft_fail_memory(error, "checking a scene");
    done = done && check_meshes(&c, error);
    daft_scene_destroy(scene);
    return done;
}
