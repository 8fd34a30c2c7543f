/* Opacity classes of meshes with their materials, kept with the mesh: made when a picture first shows the two together,
 * again when the texture or what the material says of alpha is another; gone with either. A mesh keeps SETS of them,
 * and more only if one picture shows it in more materials. */
#include "scene/scene.h"

#include <string.h>

enum { SETS = 8 };

/* All that decides a slot's classes. */
typedef struct slot_key {
    uint64_t texture; /* its revision; 0: none */
    daft_vec2 scale, offset;
    daft_vec3 passes;
    float opacity, cutoff;
    uint32_t wrap, channel, blends, unused;
} slot_key;

static slot_key key_of(const daft_scene *scene, const daft_surface *m)
{
    slot_key key;
    memset(&key, 0, sizeof key);
    key.passes = m->transmittance;
    if (!daft_surface_blends(m)) return key;
    const uint32_t map = m->maps[DAFT_MAP_ALPHA];
    key.texture = map == DAFT_NO_TEXTURE ? 0 : scene->assets.textures[map].revision;
    key.scale = m->map_scale, key.offset = m->map_offset;
    key.opacity = m->opacity, key.cutoff = m->cutoff;
    key.wrap = m->wrap, key.channel = m->alpha_channel, key.blends = 1;
    return key;
}

static uint64_t texture_bit(uint64_t revision) { return (uint64_t)(revision != 0) << (revision % 64); }

/* And the bits of the textures. */
static uint64_t hash_slots(const daft_scene *scene, const daft_trimesh *mesh, const uint32_t *materials,
                           uint64_t *textures)
{
    uint64_t hash = 0;
    *textures = 0;
    for (uint32_t slot = 0; slot < daft_max_u(mesh->slot_count, 1); slot++) {
        const slot_key key = key_of(scene, &scene->assets.surfaces[materials[slot]]);
        hash = daft_hash(&key, sizeof key, hash), *textures |= texture_bit(key.texture);
    }
    return hash;
}

static void set_free(const daft_scene *scene, daft_retired *item)
{
    daft_opacity_set *set = (daft_opacity_set *)item;
    if (set->masks) daft_masks_free(scene->allocator, set->masks, set->slots);
    daft_release(scene->allocator, set);
}

void daft_opacity_free(const daft_scene *scene, daft_mesh_item *item)
{
    for (daft_opacity_set *set = item->opacity, *next; set; set = next) {
        next = set->next;
        set_free(scene, &set->retired);
    }
    item->opacity = NULL;
}

/* Frames that are not taken may be shown again: none may have it. */
static void let_go(daft_scene *scene, daft_opacity_set **link)
{
    daft_opacity_set *gone = *link;
    *link = gone->next;
    daft_scene_touch(scene);
    daft_retire(scene, &gone->retired, set_free);
}

static void forget_texture(daft_scene *scene, daft_mesh_item *item, uint64_t bit)
{
    for (daft_opacity_set **link = &item->opacity; *link;)
        if ((*link)->textures & bit)
            let_go(scene, link);
        else
            link = &(*link)->next;
}

void daft_opacity_forget(daft_scene *scene, uint64_t revision)
{
    const daft_assets *assets = &scene->assets;
    const uint64_t bit = texture_bit(revision);
    for (uint32_t i = 0; i < assets->mesh_slots.count; i++)
        if (assets->meshes[i]) forget_texture(scene, assets->meshes[i], bit);
    for (uint32_t i = 0; i < assets->box_slots.count; i++)
        if (assets->boxes[i]) forget_texture(scene, &assets->boxes[i]->shape, bit);
}

size_t daft_opacity_bytes(const daft_mesh_item *item)
{
    size_t bytes = 0;
    for (const daft_opacity_set *set = item->opacity; set; set = set->next)
        bytes += sizeof *set + item->mesh.triangle_count + (set->masks ? daft_masks_bytes(set->masks, set->slots) : 0);
    return bytes;
}

/* Lets the set go that was shown longest ago, unless all have been in this picture. */
static void make_room(daft_scene *scene, daft_mesh_item *item)
{
    uint32_t count = 0;
    daft_opacity_set **oldest = &item->opacity;
    for (daft_opacity_set **link = &item->opacity; *link; link = &(*link)->next, count++)
        if ((*link)->shown < (*oldest)->shown) oldest = link;
    if (count < SETS || (*oldest)->shown == scene->walk) return;
    let_go(scene, oldest);
}

/* All triangles opaque: as if there were no alpha. All clear: there is nothing. */
static uint32_t flags_of_all(const uint8_t *classes, uint32_t count)
{
    uint32_t of[3] = {0, 0, 0};
    for (uint32_t i = 0; i < count; i++) of[classes[i]]++;
    if (of[DAFT_OPACITY_OPAQUE] == count) return DAFT_INSTANCE_CASTS_SHADOW;
    return of[DAFT_OPACITY_CLEAR] == count ? 0 : DAFT_INSTANCE_FILTERS_SHADOW;
}

/* Without memory for masks, rays read textures instead. */
static daft_opacity_set *set_make(const daft_scene *scene, const daft_trimesh *mesh, const uint32_t *materials)
{
    const daft_allocator *allocator = scene->allocator;
    const daft_surface *surfaces = scene->assets.surfaces;
    const uint32_t slots = daft_max_u(mesh->slot_count, 1);
    daft_opacity_set *set =
        daft_alloc_zero(allocator, sizeof *set + slots * sizeof *set->masks + mesh->triangle_count, 1);
    if (!set) return NULL;
    daft_mask *masks = (daft_mask *)(set + 1);
    set->classes = (uint8_t *)(masks + slots), set->slots = slots;
    if (!daft_opacity_classify(allocator, mesh, surfaces, materials, scene->assets.textures, set->classes)) {
        daft_release(allocator, set);
        return NULL;
    }
    set->flags = flags_of_all(set->classes, mesh->triangle_count);
    if (memchr(set->classes, DAFT_OPACITY_MIXED, mesh->triangle_count) &&
        daft_masks_make(allocator, mesh, surfaces, materials, scene->assets.textures, masks))
        set->masks = masks;
    return set;
}

const daft_opacity_set *daft_opacity_find(daft_scene *scene, daft_mesh_item *item, const uint32_t *materials)
{
    const daft_trimesh *mesh = &item->mesh;
    uint64_t textures;
    const uint64_t key = hash_slots(scene, mesh, materials, &textures);
    for (daft_opacity_set *set = item->opacity; set; set = set->next) {
        if (set->key != key) continue;
        set->shown = scene->walk;
        return set;
    }
    daft_opacity_set *set = set_make(scene, mesh, materials);
    if (!set) return NULL;
    make_room(scene, item);
    set->key = key, set->textures = textures, set->shown = scene->walk;
    set->next = item->opacity, item->opacity = set;
    return set;
}
