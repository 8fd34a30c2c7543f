/* Materials: their definition as users see it, the surface that the kernels read, and what an MTL entry becomes. */
#include "scene/scene.h"

#include "math/trig.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

daft_material_def daft_default_material_def(void)
{
    daft_material_def def;
    daft_struct_default(DAFT_STRUCT_MATERIAL_DEF, &def);
    return def;
}

/* Every texture that a material has. */
const daft_texture *daft_material_textures(const daft_material_def *def, daft_texture out[DAFT_MATERIAL_TEXTURES])
{
    const daft_texture all[DAFT_MATERIAL_TEXTURES] = {def->diffuse_map,  def->ambient_map,    def->specular_map,
                                                      def->emission_map, def->shininess_map,  def->roughness_map,
                                                      def->metallic_map, def->normal_map,     def->bump_map,
                                                      def->alpha_map,    def->reflection_map, def->occlusion_map};
    memcpy(out, all, sizeof all);
    return out;
}

static uint32_t texture_number(daft_texture texture)
{
    return texture.id ? daft_asset_index(texture.id) : DAFT_NO_TEXTURE;
}

static bool mirrors_image(const daft_material_def *def)
{
    return def->reflection_map.id && def->mirror > 0 && def->shading != DAFT_SHADING_PHYSICAL;
}

static bool occludes(const daft_material_def *def) { return def->occlusion_map.id && def->occlusion_strength > 0; }

static void set_maps(const daft_scene *scene, const daft_material_def *def, daft_surface *s)
{
    const daft_texture alpha = def->alpha_map.id ? def->alpha_map : def->diffuse_map;
    const daft_texture maps[DAFT_MAPS] = {
        [DAFT_MAP_AMBIENT] = def->ambient_map,
        [DAFT_MAP_SPECULAR] = def->specular_map,
        [DAFT_MAP_EMISSION] = def->emission_map,
        [DAFT_MAP_SHININESS] = def->shininess_map,
        [DAFT_MAP_ROUGHNESS] = def->roughness_map,
        [DAFT_MAP_METALLIC] = def->metallic_map,
        [DAFT_MAP_NORMAL] = def->normal_map,
        [DAFT_MAP_BUMP] = def->bump_map,
        [DAFT_MAP_ALPHA] = def->alpha_mode == DAFT_ALPHA_OPAQUE ? (daft_texture){0} : alpha,
        [DAFT_MAP_REFLECTION] = mirrors_image(def) ? def->reflection_map : (daft_texture){0},
        [DAFT_MAP_OCCLUSION] = occludes(def) ? def->occlusion_map : (daft_texture){0}};
    bool some = false;
    for (int i = 0; i < DAFT_MAPS; i++) {
        s->maps[i] = texture_number(maps[i]);
        some |= maps[i].id && i != DAFT_MAP_ALPHA;
    }
    /* of an image that has no alpha, unless it is asked for */
    const bool own = alpha.id && scene->assets.textures[daft_asset_index(alpha.id)].has_alpha;
    s->alpha_channel = own || !def->alpha_map.id ? 3 : 1;
    if (some) s->traits |= DAFT_TRAIT_MAPS | DAFT_TRAIT_VARIES;
    if (def->normal_map.id || def->bump_map.id) s->traits |= DAFT_TRAIT_TANGENT;
    if (occludes(def)) s->traits |= DAFT_TRAIT_OCCLUSION;
    if (mirrors_image(def)) s->traits |= DAFT_TRAIT_AROUND, s->reflection = s->mirror, s->mirror = daft_v3(0, 0, 0);
}

/* Any material may be put on any mesh. */
static bool some_mesh_fades(const daft_assets *assets)
{
    for (uint32_t i = 0; i < assets->mesh_slots.count; i++)
        if (assets->meshes[i] && assets->meshes[i]->mesh.alphas) return true;
    return false;
}

/* Its alpha is 1 wherever it is. */
static bool alpha_is_whole(const daft_scene *scene, const daft_material_def *def)
{
    if (def->alpha_map.id) return false; /* which may be a picture's green */
    if (some_mesh_fades(&scene->assets)) return false;
    const bool has = def->diffuse_map.id && scene->assets.textures[daft_asset_index(def->diffuse_map.id)].has_alpha;
    return !has && def->opacity >= (def->alpha_mode == DAFT_ALPHA_MASK ? def->alpha_cutoff : 1);
}

/* A hole is what is seen through: a surface that blends by none or all. */
static void set_alpha(const daft_scene *scene, const daft_material_def *def, daft_surface *s)
{
    s->opacity = def->opacity;
    s->cutoff = def->alpha_mode == DAFT_ALPHA_MASK ? def->alpha_cutoff : 0;
    if (def->alpha_mode == DAFT_ALPHA_OPAQUE) return;
    if (alpha_is_whole(scene, def)) {
        s->maps[DAFT_MAP_ALPHA] = DAFT_NO_TEXTURE, s->cutoff = 0, s->opacity = 1;
        return;
    }
    s->traits |= DAFT_TRAIT_VARIES | DAFT_TRAIT_BLEND | DAFT_TRAIT_SENDS;
    if (s->maps[DAFT_MAP_ALPHA] != DAFT_NO_TEXTURE) s->traits |= DAFT_TRAIT_MAPS;
    s->steepness = daft_mask_steepness(s, scene->assets.textures);
}

/* The most that a surface without maps reflects: directional_albedo of shade/vary_kernel.c at grazing angles, of which
 * it is a rising function, less what rough surfaces are spared. */
static float most_reflected(float f0, float rough)
{
    const float rx = 1 - rough, ry = 0.0425f - rough * 0.0275f, rz = 1.04f - rough * 0.572f,
                rw = rough * 0.022f - 0.04f;
    const float grazing = rx * rx * rx + ry, e = f0 * rz + rw + 1.04f * grazing * (1 - f0);
    return e * (1 + f0 * (1 / (rz + rw) - 1)) * (1 - rough / 2);
}

/* Whether rays follow what it mirrors; 0.04: what dielectrics reflect straight on. */
static bool sends_mirrored(const daft_material_def *def)
{
    if (def->roughness_map.id) return true;
    const float base = fmaxf(def->diffuse.x, fmaxf(def->diffuse.y, def->diffuse.z));
    const float f0 = fmaxf(0.04f, 0.04f * (1 - def->metallic) + base * def->metallic);
    return most_reflected(f0, def->roughness) > 0.99f * DAFT_LEAST_MIRROR;
}

static void set_physical(const daft_material_def *def, daft_surface *s)
{
    s->metallic = def->metallic;
    if (def->shading != DAFT_SHADING_PHYSICAL) return;
    s->traits |= DAFT_TRAIT_VARIES | DAFT_TRAIT_PHYSICAL | DAFT_TRAIT_SPECULAR;
    if (sends_mirrored(def)) s->mirror = daft_v3(1, 1, 1); /* at most: at grazing angles */
}

/* Light within becomes tint^(length / distance): 2^(-absorption · length). */
static void set_medium(const daft_material_def *def, daft_surface *s)
{
    const double most = 1e30; /* 1/m: black at once */
    s->priority = def->medium_priority;
    if (!(def->tint_distance > 0)) return;
    s->transmittance = daft_v3(def->transmission, def->transmission, def->transmission);
    for (int k = 0; k < 3; k++)
        daft_v3_put(
            &s->absorption, k,
            (float)fmin(-daft_log2((double)daft_v3_at(def->transmission_tint, k)) / (double)def->tint_distance, most));
}

static daft_surface surface_from(const daft_scene *scene, const daft_material_def *def)
{
    float kept = 1 - def->transmission;
    daft_surface surface = {
        .ambient = daft_scale(def->ambient, kept),
        .diffuse = daft_scale(def->diffuse, kept),
        .specular = def->specular,
        .emission = def->emission,
        .mirror = daft_scale(def->mirror_tint, def->mirror),
        .transmittance = daft_scale(def->transmission_tint, def->transmission),
        .transmission = def->transmission,
        .index = def->refractive_index,
        .shininess = def->shininess,
        .alpha = def->roughness * def->roughness,
        .texture = texture_number(def->diffuse_map),
        .map_scale = def->map_scale,
        .map_offset = def->map_offset,
        .wrap = def->map_wrap,
        .roughness = def->roughness,
        .normal_strength = def->normal_strength,
        .bump_strength = def->bump_strength,
        .occlusion_strength = def->occlusion_strength,
    };
    set_maps(scene, def, &surface);
    set_alpha(scene, def, &surface);
    set_physical(def, &surface);
    set_medium(def, &surface);
    return surface;
}

/* What a texture is has changed: whether it has alpha. */
void daft_material_refresh(daft_scene *scene, uint32_t texture)
{
    daft_assets *assets = &scene->assets;
    for (uint32_t i = 0; i < assets->material_slots.count; i++) {
        const daft_material_def *def = &assets->materials[i];
        if (def->alpha_map.id == texture || def->diffuse_map.id == texture)
            assets->surfaces[i] = surface_from(scene, def);
    }
}

void daft_materials_fade(daft_scene *scene)
{
    daft_assets *assets = &scene->assets;
    for (uint32_t i = 0; i < assets->material_slots.count; i++)
        if (assets->materials[i].alpha_mode != DAFT_ALPHA_OPAQUE)
            assets->surfaces[i] = surface_from(scene, &assets->materials[i]);
    daft_scene_touch(scene);
}

static bool def_check(const daft_scene *scene, const daft_material_def *def, daft_error *error)
{
    daft_texture textures[DAFT_MATERIAL_TEXTURES];
    if (!daft_check_pointer(error, "def", def) || !daft_struct_check(DAFT_STRUCT_MATERIAL_DEF, def, error))
        return false;
    daft_material_textures(def, textures);
    for (int i = 0; i < DAFT_MATERIAL_TEXTURES; i++)
        if (!daft_texture_check(scene, textures[i], error)) return false;
    return true;
}

static bool material_reserve(daft_scene *scene, daft_error *error)
{
    daft_assets *assets = &scene->assets;
    const daft_allocator *allocator = scene->allocator;
    size_t count = assets->material_slots.count, needed = daft_slots_needed(&assets->material_slots, 1);
    return (daft_asset_reserve(scene, &assets->material_slots, &assets->material_states,
                               &assets->material_state_capacity) &&
            daft_grow(allocator, &assets->materials, &assets->material_capacity, needed, count,
                      sizeof *assets->materials) &&
            daft_grow(allocator, &assets->surfaces, &assets->surface_capacity, needed, count,
                      sizeof *assets->surfaces) &&
            daft_grow(allocator, &assets->material_keys, &assets->material_key_capacity, needed, count,
                      sizeof *assets->material_keys) &&
            daft_grow(allocator, &assets->material_names, &assets->material_name_capacity, needed, count,
                      sizeof *assets->material_names)) ||
           daft_fail_memory(error, "the list of materials");
}

daft_material daft_material_create(daft_scene *scene, const daft_material_def *def, daft_error *error)
{
    daft_error_clear(error);
    if (!daft_scene_ready(scene, error) || !def_check(scene, def, error) || !material_reserve(scene, error))
        return (daft_material){0};
    daft_assets *assets = &scene->assets;
    daft_material material = {daft_asset_add(scene, &assets->material_slots, assets->material_states)};
    uint32_t index = daft_asset_index(material.id);
    assets->materials[index] = *def;
    assets->surfaces[index] = surface_from(scene, def);
    assets->material_keys[index] = (daft_asset_key){0};
    assets->material_names[index] = NULL;
    return material;
}

/* A free slot is the default material, so that no plan reckons with what is gone. */
void daft_material_free(daft_scene *scene, uint32_t index)
{
    daft_assets *assets = &scene->assets;
    daft_asset_key *key = &assets->material_keys[index];
    if (key->path) daft_map_remove(&assets->material_map, key->hash, index);
    daft_release(scene->allocator, key->path);
    daft_release(scene->allocator, assets->material_names[index]);
    key->path = NULL, assets->material_names[index] = NULL;
    assets->materials[index] = assets->materials[0];
    assets->surfaces[index] = assets->surfaces[0];
    daft_slots_remove(&assets->material_slots, index);
}

bool daft_material_check(const daft_scene *scene, daft_material material, daft_error *error)
{
    if (daft_asset_find(&scene->assets.material_slots, material.id) != DAFT_NONE) return true;
    return daft_fail(error, DAFT_ERROR_HANDLE,
                     material.id ? "material %u is not one of this scene" : "the material is none (0)", material.id);
}

bool daft_material_get(daft_scene *scene, daft_material material, daft_material_def *def, daft_error *error)
{
    daft_error_clear(error);
    if (!daft_check_pointer(error, "scene", scene) || !daft_check_pointer(error, "def", def) ||
        !daft_material_check(scene, material, error))
        return false;
    *def = scene->assets.materials[daft_asset_index(material.id)];
    return true;
}

const char *daft_material_name(const daft_scene *scene, daft_material material, char *buffer, size_t size)
{
    if (!buffer || size == 0) return buffer;
    const bool known = scene && daft_asset_find(&scene->assets.material_slots, material.id) != DAFT_NONE;
    const char *name = known ? scene->assets.material_names[daft_asset_index(material.id)] : NULL;
    snprintf(buffer, size, "%s", name ? name : "");
    return scene ? buffer : NULL;
}

bool daft_material_set(daft_scene *scene, daft_material material, const daft_material_def *def, daft_error *error)
{
    daft_error_clear(error);
    if (!daft_scene_ready(scene, error) || !daft_material_check(scene, material, error) ||
        !def_check(scene, def, error))
        return false;
    scene->assets.materials[daft_asset_index(material.id)] = *def;
    scene->assets.surfaces[daft_asset_index(material.id)] = surface_from(scene, def);
    daft_scene_touch(scene);
    return true;
}

/* ---- from MTL files ---- */

static float largest(daft_vec3 v)
{
    float max = v.x > v.y ? v.x : v.y;
    return max > v.z ? max : v.z;
}

/* How much light passes: what d says is missing. Models 6 and 7 ("refraction on") let all of it pass where d says
 * nothing, 4 and 9 ("glass on") so only where there is a Tf; unless that is black. Other models are seen straight
 * through, and their Tf, which exporters write without meaning it, is left alone. */
void daft_material_transmit(const daft_mtl *mtl, daft_material_def *def)
{
    bool refracts = mtl->illum == 6 || mtl->illum == 7, glass = mtl->illum == 4 || mtl->illum == 9;
    def->transmission = 1 - mtl->opacity;
    def->refractive_index = refracts || glass ? mtl->index : 1;
    if (!refracts && !glass) return;
    def->transmission_tint = mtl->filter;
    def->tint_distance = mtl->tint_distance, def->medium_priority = mtl->priority;
    if (mtl->opacity == 1 && (refracts || mtl->has_filter) && largest(mtl->filter) > 0) def->transmission = 1;
}

/* MTL's illumination models: 0 and 1 have no highlight, 2 has, 3 and above reflect as well, by Ks. What passes
 * light is mirrored by Fresnel's equations, and only what does not pass by Ks. */
static void illuminate(const daft_mtl *mtl, daft_material_def *def)
{
    def->specular = mtl->illum <= 1 ? daft_v3(0, 0, 0) : mtl->specular;
    float weight = mtl->illum >= 3 && mtl->illum <= 9 ? largest(mtl->specular) : 0;
    if (!(weight > 0)) return;
    def->mirror = (weight < 1 ? weight : 1) * (1 - def->transmission);
    def->mirror_tint = daft_scale(mtl->specular, 1 / weight);
}

static daft_texture *map_field(daft_material_def *def, int use)
{
    daft_texture *const fields[DAFT_MTL_CUBE] = {
        [DAFT_MTL_AMBIENT] = &def->ambient_map,    [DAFT_MTL_SPECULAR] = &def->specular_map,
        [DAFT_MTL_EMISSION] = &def->emission_map,  [DAFT_MTL_SHININESS] = &def->shininess_map,
        [DAFT_MTL_ALPHA] = &def->alpha_map,        [DAFT_MTL_BUMP] = &def->bump_map,
        [DAFT_MTL_NORMAL] = &def->normal_map,      [DAFT_MTL_ROUGHNESS] = &def->roughness_map,
        [DAFT_MTL_METALLIC] = &def->metallic_map,  [DAFT_MTL_REFLECTION] = &def->reflection_map,
        [DAFT_MTL_OCCLUSION] = &def->occlusion_map};
    return fields[use];
}

static void release_maps(daft_scene *scene, const daft_material_def *def)
{
    daft_texture textures[DAFT_MATERIAL_TEXTURES];
    daft_material_textures(def, textures);
    for (int i = 0; i < DAFT_MATERIAL_TEXTURES; i++)
        if (textures[i].id) daft_texture_release(scene, textures[i], NULL);
}

static bool load_maps(daft_scene *scene, const daft_mtl *mtl, daft_material_def *def, daft_error *error)
{
    for (int i = 0; mtl->maps && i < DAFT_MTL_CUBE; i++) {
        if (!mtl->maps->map[i].path[0]) continue;
        *map_field(def, i) = daft_texture_of_map(scene, mtl, (daft_mtl_use)i, error);
        if (map_field(def, i)->id) continue;
        release_maps(scene, def);
        return false;
    }
    const bool cube = mtl->maps && mtl->maps->map[DAFT_MTL_CUBE].path[0] && !def->reflection_map.id;
    if (!cube || daft_texture_of_cube_map(scene, mtl, &def->reflection_map, error)) return true;
    release_maps(scene, def);
    return false;
}

/* A map_d is a mask if nearly all of it is there or not, and else blends; and d goes into it. */
static void blend_or_mask(const daft_scene *scene, const daft_mtl *mtl, daft_material_def *def)
{
    if (!def->alpha_map.id) {
        if (mtl->alpha_mode == DAFT_ALPHA_OPAQUE) return;
        def->opacity = mtl->opacity, def->transmission = 0;
        const daft_texture own = def->diffuse_map;
        const bool some = own.id && scene->assets.textures[daft_asset_index(own.id)].has_alpha;
        if (!some && def->opacity == 1 && !mtl->fades) def->alpha_mode = DAFT_ALPHA_OPAQUE;
        return;
    }
    const daft_texture_data *t = &scene->assets.textures[daft_asset_index(def->alpha_map.id)];
    const size_t count = (size_t)t->width[0] * (size_t)t->height[0], channel = t->has_alpha ? 3 : 1;
    size_t between = 0;
    for (size_t i = 0; i < count; i++) {
        const uint8_t a = t->texels[0][4 * i + channel];
        between += a > 16 && a < 239;
    }
    def->opacity = mtl->opacity, def->transmission = 0;
    def->alpha_mode = between * 8 > count || mtl->opacity < 1 ? DAFT_ALPHA_BLEND : DAFT_ALPHA_MASK;
}

daft_material daft_material_from_mtl(daft_scene *scene, const daft_mtl *mtl, daft_error *error)
{
    daft_material_def def = daft_default_material_def();
    def.ambient = mtl->ambient;
    def.diffuse = mtl->diffuse;
    def.emission = mtl->emission;
    def.shininess = mtl->shininess < 1000 ? mtl->shininess : 1000;
    def.roughness = mtl->roughness;
    def.map_scale = mtl->scale, def.map_offset = mtl->offset, def.map_wrap = mtl->wrap;
    def.bump_strength = fminf(fmaxf(mtl->bump, -1000), 1000),
    def.normal_strength = fminf(fmaxf(mtl->normal, -100), 100);
    def.metallic = mtl->metallic, def.occlusion_strength = mtl->occlusion;
    def.alpha_mode = mtl->alpha_mode, def.alpha_cutoff = mtl->alpha_cutoff;
    /* illum 3 to 9 with a Pr alone is MTL's mirror, as rough as that says */
    const bool physical = mtl->physical || (mtl->has_roughness && mtl->illum < 3);
    def.shading = physical ? DAFT_SHADING_PHYSICAL : DAFT_SHADING_PHONG;
    daft_material_transmit(mtl, &def);
    if (!physical) illuminate(mtl, &def);
    if (mtl->file[0] && !daft_scene_note_file(scene, mtl->file, error)) return (daft_material){0};
    if (mtl->diffuse_map[0]) {
        def.diffuse_map = daft_texture_of_map(scene, mtl, DAFT_MTL_DIFFUSE, error);
        if (!def.diffuse_map.id) return (daft_material){0};
    }
    if (!load_maps(scene, mtl, &def, error)) return (daft_material){0};
    blend_or_mask(scene, mtl, &def);
    char *name = daft_copy_string(scene->allocator, mtl->name);
    daft_material material = {0};
    if (name)
        material = daft_material_create(scene, &def, error);
    else
        daft_fail_memory(error, "the name of a material");
    if (material.id)
        scene->assets.material_names[daft_asset_index(material.id)] = name;
    else
        daft_release(scene->allocator, name);
    release_maps(scene, &def); /* the material uses them */
    return material;
}

/* Splits "file.mtl#name" unless a file has just that name. NULL: no name, the first material is meant. */
static bool split_path(const daft_files *files, const char *path, char *file, size_t size, const char **name,
                       daft_error *error)
{
    const char *hash = strrchr(path, '#');
    if (hash && daft_file_exists(files, path)) hash = NULL;
    size_t length = hash ? (size_t)(hash - path) : strlen(path);
    if (length >= size) return daft_fail(error, DAFT_ERROR_IO, "the path has more than %zu characters", size - 1);
    memcpy(file, path, length);
    file[length] = 0;
    *name = hash ? hash + 1 : NULL;
    return true;
}

static const daft_mtl *pick(const daft_mtl_list *list, const char *file, const char *name, daft_error *error)
{
    char known[256] = "";
    size_t used = 0;
    for (size_t i = 0; i < list->count; i++) {
        if (!name || strcmp(list->items[i].name, name) == 0) return &list->items[i];
        if (used < sizeof known)
            used += (size_t)snprintf(known + used, sizeof known - used, "%s%s", i ? ", " : "", list->items[i].name);
    }
    if (list->count == 0)
        daft_fail_at(error, DAFT_ERROR_SYNTAX, file, 0, 0, "has no material (no newmtl line)");
    else
        daft_fail_at(error, DAFT_ERROR_ARGUMENT, file, 0, 0, "has no material '%.100s'; it has %s", name, known);
    return NULL;
}

static daft_material load_new(daft_scene *scene, const char *path, daft_error *error)
{
    char file[1024];
    const char *name = NULL;
    daft_mtl_list list = {0};
    daft_material material = {0};
    if (!split_path(scene->engine->files, path, file, sizeof file, &name, error)) return material;
    if (daft_mtl_load(scene->allocator, scene->engine->files, file, &scene->engine->log, &list, error)) {
        const daft_mtl *mtl = pick(&list, file, name, error);
        if (mtl) material = daft_material_from_mtl(scene, mtl, error);
    }
    daft_mtl_list_free(scene->allocator, &list);
    return material;
}

daft_material daft_material_load(daft_scene *scene, const char *path, daft_error *error)
{
    daft_error_clear(error);
    if (!daft_scene_ready(scene, error) || !daft_check_pointer(error, "path", path)) return (daft_material){0};
    daft_assets *assets = &scene->assets;
    uint64_t hash = daft_path_hash(path);
    for (uint32_t cursor = 0, i; (i = daft_map_next(&assets->material_map, hash, &cursor)) != DAFT_NONE;) {
        if (strcmp(assets->material_keys[i].path, path) != 0) continue;
        assets->material_states[i].holds++;
        return (daft_material){daft_asset_id(&assets->material_slots, i)};
    }
    daft_assets_mark mark = daft_assets_remember(scene);
    char *copy = daft_copy_string(scene->allocator, path);
    daft_material material = {0};
    if (copy && daft_map_reserve(&assets->material_map, scene->allocator, 1))
        material = load_new(scene, path, error);
    else
        daft_fail_memory(error, "a path");
    if (!material.id) {
        daft_release(scene->allocator, copy);
        daft_assets_roll_back(scene, mark);
        return material;
    }
    uint32_t index = daft_asset_index(material.id);
    daft_map_add(&assets->material_map, hash, index);
    assets->material_keys[index] = (daft_asset_key){copy, hash};
    return material;
}
